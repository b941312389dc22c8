"""Whether the words of the documentation, of the docstrings and of the Fortran comments are English.

usage: python .ci/check_spelling.py

British spelling, by aspell; docs/words.txt holds the words that it does not know. Code is left out.
"""

import ast
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
#: What is no prose, in the order in which it is taken out.
CODE = (
    r"(?ms)^```.*?^```", r"(?s)``.*?``", r"`[^`]*`", r"(?s)\$\$.*?\$\$", r"\$[^$]*\$", r"\]\([^)]*\)",
    r"https?:\S+",
    r"(?ms)^\s*(>>>|\.\.\.) .*?(?=^\s*$|\Z)", r"(?m)^    \S.*$", r"&\w+", r"\S*[\w\]][/_=.^()\[\]|]+\w\S*",
    r"--?\w[\w-]*",
)  # fmt: skip


def python_prose(path):
    """The docstrings of a file."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)):
            text = ast.get_docstring(node) or ""
            # the heads of parameters are names
            yield re.sub(r"^\w[\w, *]* :.*$", "", text, flags=re.MULTILINE)


def fortran_prose(path):
    """The comments of a file that tell what is there."""
    for line in path.read_text(encoding="utf-8").splitlines():
        found = re.match(r"\s*![>!]? ?(.*)", line)
        yield found[1] if found else ""


def prose():
    """(file, its words) for every file."""
    for path in sorted([*ROOT.glob("*.md"), *ROOT.glob("*/README.md"), *ROOT.glob("docs/**/*.md")]):
        if "generated" not in path.parts and "gallery" not in path.parts:
            yield path, path.read_text(encoding="utf-8")
    for path in sorted([*ROOT.glob("python/**/*.py"), *ROOT.glob("docs/examples/*.py")]):
        yield path, "\n\n".join(python_prose(path))
    for path in sorted(ROOT.glob("src/**/*.f90")):
        yield path, "\n".join(fortran_prose(path))


def unknown(text, known):
    """The words of a text that neither aspell nor the list knows."""
    for pattern in CODE:
        text = re.sub(pattern, " ", text)
    said = subprocess.run(
        ["aspell", "--lang=en_GB", "--encoding=utf-8", "list"],
        input=text,
        text=True,
        capture_output=True,
        check=True,
    ).stdout
    # names like LAPACK and ParameterError, and what is too short to be misspelt
    words = {word.removesuffix("'s") for word in said.split()}
    words = {word for word in words if len(word) > 3 and not re.search("[A-Z]", word[1:])}
    return {word for word in words if word.lower() not in known}


if __name__ == "__main__":
    known = set((ROOT / "docs" / "words.txt").read_text(encoding="utf-8").split())
    status = 0
    for path, text in prose():
        if wrong := unknown(text, known):
            print(f"{path.relative_to(ROOT)}: {', '.join(sorted(wrong))}")
            status = 1
    sys.exit(status)
