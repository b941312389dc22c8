"""What each test checks, by the first sentence of its docstring, grouped by file."""

import ast
import re

from .shared import ROOT, sentence

#: Folders of tests, and the files of each that hold what the tests compare with.
FOLDERS = {
    "tests/python": "The package",
    "tests/cli": "The programs",
    "tests/fortran": "The Fortran core",
}
#: The source of a file's independent data, by a word in the file.
ROUTES = {
    "first_principles": "`first_principles.py`",
    "reference_simulation": "`reference_simulation.py`",
    "mpmath": "mpmath",
    "scipy.optimize": "SciPy's roots and minima",
    "scipy.io": "SciPy's reader of MATLAB files",
    "import h5py": "h5py",
    "table1.csv": "the paper's numbers",
    "shared_published": "published numbers",
    "use random_systems": "random systems",
    "hypothesis": "random systems",
}

#: Words of files whose checks are listed one by one, because they compare with an independent model.
INDEPENDENT = ("first_principles", "reference_simulation", "reference_motion", "scipy.optimize")


def words(name):
    """The name of a test as a sentence."""
    text = name.removeprefix("test_").replace("_", " ")
    return text[:1].upper() + text[1:] + "."


def python_checks(path):
    """(purpose of the file, [what each test checks]); for a test without a docstring, its name."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test_"):
            text = ast.get_docstring(node)
            title = words(node.name)
            found.append(f"{title[:-1]}: {first_sentence(text).lstrip('. ')}" if text else title)
    return ast.get_docstring(tree) or "", found


def first_sentence(text):
    """The first sentence of a docstring."""
    whole = " ".join(text.split("\n\n")[0].split())
    return re.split(r"(?<=[a-z)0-9]\.) (?=[A-Z])", whole, maxsplit=1)[0]


def fortran_checks(path):
    """The same of a Fortran file: the texts of its calls of `check` and `check_close`."""
    source = path.read_text(encoding="utf-8")
    text = re.sub(r"&\s*\n\s*&?", "", source)
    purpose = " ".join(
        re.findall(r"^!(?:>|!) ?(.*)", source.split("module ")[0].split("program ")[0], re.M)
    )
    found = []
    for line in re.findall(r"^.*call check(?:_close)?\(.*$", text, re.M):
        literals = re.findall(r"'((?:[^']|'')*)'", line)
        if literals and literals[-1].strip():
            said = literals[-1].replace("''", "'").strip(" :,")
            found.append(said[:1].upper() + said[1:] + ".")
    return purpose, list(dict.fromkeys(found))


def is_independent(path):
    """Whether a file of tests/python holds no tests but a model or data that tests compare with."""
    return path.suffix == ".py" and not path.name.startswith(
        ("test_", "conftest", "programs", "shared_")
    )


def pages():
    """A count by subject, the references, then the single checks against independent code or data."""
    totals, body, details, routes, whole = [], [], [], [], 0
    for folder, title in FOLDERS.items():
        table, lists, total = [], [], 0
        for path in sorted(
            (ROOT / folder).iterdir(), key=lambda path: path.stem.removeprefix("test_")
        ):
            if is_independent(path):
                routes.append(f"- `{path.name}`: {sentence(python_checks(path)[0])}")
            if path.suffix not in (".py", ".f90") or path.name == "checks.f90":
                continue
            purpose, found = (python_checks if path.suffix == ".py" else fortran_checks)(path)
            if not found:
                continue
            subject = path.stem.removeprefix("test_").replace("_", " ").capitalize()
            text = path.read_text(encoding="utf-8")
            used = ", ".join(dict.fromkeys(route for word, route in ROUTES.items() if word in text))
            about = sentence(re.split(r"(?<=\.) ", " ".join(purpose.split()), maxsplit=1)[0])
            table.append(f"| {subject} | {len(found)} | {about} | {used} |")
            total += len(found)
            if folder != "tests/python" or not any(word in text for word in INDEPENDENT):
                continue
            lists += [
                f"### {subject}",
                "",
                f"`{folder}/{path.name}`: {sentence(purpose)}",
                "",
                "<details>",
                f"<summary>{len(found)} checks</summary>"
                if len(found) > 1
                else "<summary>1 check</summary>",
                "",
            ]
            lists += [f"- {sentence(text)}" for text in found]
            lists += ["", "</details>", ""]
        totals.append(f"{total} of {title[:1].lower()}{title[1:]}")
        whole += total
        head = [
            "| subject | checks | what is checked, and against what | independent code and data |",
            "|---|---|---|---|",
        ]
        body += [f"## {title}", "", *head, *table, ""]
        details += lists
    compare = [
        "## Independent models",
        "",
        "The tests compare the package with these:",
        "",
        *routes,
        "",
    ]
    singles = ["## Single checks against independent code or data", "", *details]
    first = [f"**{whole} checks**: {', '.join(totals)}.", ""]
    return {"checks.md": "\n".join([*first, *compare, *body, *singles])}
