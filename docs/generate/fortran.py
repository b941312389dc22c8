"""The Fortran modules: their purpose and what is public in them, from the comments of the sources."""

# Not by ford: its 680 pages (23 s, 22 MB) load style and search from other hosts.

import re

from .shared import ROOT, sentence

FOLDERS = ("numerics", "mechanics", "motions", "cases", "studies", "door", "cli")
HEAD = re.compile(
    r"^   (?:(?:pure|elemental|recursive|impure|module|type\([\w ]+\)|real\([\w ]+\)|integer|logical"
    r"|character\([\w *:]+\))\s+)*(?:function|subroutine)\s+(\w+)|^   type(?:, \w+(?:\(\w+\))?)* ::\s*(\w+)"
    r"|^   [\w()* ]+, parameter(?:, public)? ::\s*(\w+)|^      integer\(c_int\) function (\w+)"
)
#: The codes of vi_status, each below a comment.
CODE = re.compile(r"^ +!> (.*)\n +integer :: (\w+) = (\d+)$", re.MULTILINE)


def comment_before(lines, i):
    """The `!>` block that ends right above a line."""
    first = i
    while first > 0 and lines[first - 1].lstrip().startswith("!"):
        first -= 1
    block = [line.strip() for line in lines[first:i]]
    starts = [k for k, line in enumerate(block) if line.startswith("!>")]
    if not starts:
        return ""
    begin = starts[-1]
    while begin - 1 in starts:
        begin -= 1
    # a list becomes a sentence
    return " ".join(re.sub("^- ", "", line.lstrip("!> ")) for line in block[begin:])


def joined(lines, i):
    """A statement with its continuation lines."""
    text = lines[i].strip()
    while text.endswith("&"):
        i += 1
        text = text[:-1].rstrip() + " " + lines[i].strip().lstrip("&")
    return re.sub(r"\s+", " ", text)


def module(path):
    """One module: purpose, then each public type and procedure."""
    lines = path.read_text(encoding="utf-8").splitlines()
    start = next(k for k, line in enumerate(lines) if re.match(r"(module|program) ", line))
    name = lines[start].split()[1]
    public = {
        m[1] for m in re.finditer(r"^   .*, public ::\s*(\w+)", "\n".join(lines), re.MULTILINE)
    }
    for k, line in enumerate(lines):
        if line.startswith("   public ::"):
            public |= set(re.findall(r"\w+", joined(lines, k).split("::")[1]))
    out = [
        f"### {name}",
        "",
        f"`{path.relative_to(ROOT)}` {sentence(comment_before(lines, start))}",
        "",
    ]
    for k, line in enumerate(lines):
        found = HEAD.match(line)
        what = next(filter(None, found.groups()), "") if found else ""
        if what in public:
            text = re.sub(r", public\b", "", joined(lines, k)).replace("`", "")
            said = sentence(comment_before(lines, k))
            out += [f"`{text}`", *([f": {said}"] if said else []), ""]
    if codes := name == "vi_status" and CODE.findall("\n".join(lines)):
        out += ["| code | `stat%` | meaning |", "|---|---|---|", "| 0 | `ok` | Done. |"]
        out += [f"| {number} | `{word}` | {sentence(said)} |" for said, word, number in codes]
        out += [""]
    return out


def pages():
    """One page, folder by folder, in the order in which the files may use each other."""
    listed = re.findall(
        r"'(\w+/\w+\.f90)'", (ROOT / "src" / "meson.build").read_text(encoding="utf-8")
    )
    lines = []
    for folder in FOLDERS:
        lines += [f"## {folder}", ""]
        for name in listed:
            if name.startswith(f"{folder}/") and not name.endswith("_single.f90"):
                lines += module(ROOT / "src" / name)
    return {"fortran.md": "\n".join(lines)}
