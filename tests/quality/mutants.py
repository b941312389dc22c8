"""Mutants of a Fortran source: copies that differ in one place of one line, and should make a test fail.

No parser is needed, because all sources have the same style (free form, spaces around binary + and -, declarations
with `::`). A mutant that is not valid Fortran does not compile, and is not counted.
"""

import re
from dataclasses import dataclass
from pathlib import Path

#: Statements that are not changed: declarations, and those that only give structure.
STRUCTURE = re.compile(
    r"(use|implicit|public|private|import|module|submodule|interface|procedure|deallocate|stop|error stop"
    r"|select case|select type|class is|type is)\b"
    r"|(contains|else)$|case (\(|default)|end\w*\b(?!\s*[=%(])|type\b(?!\()"
    r"|((pure|elemental|impure|recursive|module|(integer|logical|real|complex|type|character)(\([^)]*\))?) )*"
    r"(subroutine|function) ",
    re.IGNORECASE,
)
DECLARATION = re.compile(
    r"(integer|real|logical|complex|character|type\(|class\(|procedure)[^=]*::"
)
OPPOSITE = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "/=", "/=": "=="}
EDGE = {"<": "<=", "<=": "<", ">": ">=", ">=": ">"}
#: pattern, replacement for the text found (constants: one more or less), what it is called
SIMPLE = (
    (r"(?<=\s)[+-](?=\s)", {"+": "-", "-": "+"}.get, "arithmetic"),
    (r"(?<=[\w)\]])[*](?=[\w(+-])", {"*": "/"}.get, "arithmetic"),
    (r"(?<=[\w)\]])/(?=[\w(])", {"/": "*"}.get, "arithmetic"),
    (r"(?:(?<=[(\[,=<>])|(?<=[(\[,=<>] ))-(?=[\w(])", lambda _: "", "sign"),
    (r"\.(?:and|or)\.", {".and.": ".or.", ".or.": ".and."}.get, "logic"),
    (r"\.not\. ?", lambda _: "", "logic"),
    (r"\.(?:true|false)\.", {".true.": ".false.", ".false.": ".true."}.get, "logic"),
    (r"\babs(?=\()", lambda _: "", "bound"),
    (r"\b(?:max|min|maxval|minval|any|all)(?=\()",
     {"max": "min", "min": "max", "maxval": "minval", "minval": "maxval", "any": "all", "all": "any"}.get,
     "bound"),
    (r"(?<![\w.%])(?<![\d.][eEdD][+-])[0-4](?![\w.])", None, "constant"),
)  # fmt: skip
RELATION = re.compile(r"(?<![=/<>])(<=|>=|==|/=|<|>)(?!=)")
REMOVABLE = re.compile(
    r"(call\s+\w|return$|exit$|cycle$|[a-z_][\w%]*(\([^=]*\))?(%[\w%]+(\([^=]*\))?)*\s=\s)",
    re.IGNORECASE,
)
GUARDED = re.compile(r"(else )?if \((?=.*\))")


@dataclass(frozen=True)
class Mutant:
    """One line of a file and its replacement."""

    file: str
    #: Counted from 1.
    line: int
    kind: str
    before: str
    after: str

    def source(self, root: Path) -> str:
        """Return the text of the mutated file."""
        lines = (root / self.file).read_text(encoding="utf-8").splitlines()
        lines[self.line - 1] = self.after
        return "\n".join(lines) + "\n"

    def __str__(self):
        return f"{self.file}:{self.line}\n- {self.before.strip()}\n+ {self.after.strip()}"


def code_of(line: str, quote: str = "") -> str:
    """Return a line with blanks in the place of texts and comments; `quote`: of a text that goes on in it."""
    out = []
    for place, char in enumerate(line):
        if quote:
            quote = "" if char == quote else quote
            out.append(" ")
        elif char in "'\"":
            quote = char
            out.append(" ")
        elif char == "!":
            out.append(" " * (len(line) - place))
            break
        else:
            out.append(char)
    return "".join(out)


def open_quote(line: str, quote: str = "") -> str:
    """Return the quotation mark of a text that goes on in the next line, if there is one."""
    for char in line:
        if quote:
            quote = "" if char == quote else quote
        elif char in "'\"":
            quote = char
        elif char == "!":
            break
    return quote


def integers(text: str) -> set[str]:
    """Return the names that are declared as integers somewhere in a file, and as reals nowhere."""
    found: dict[str, set[str]] = {"integer": set(), "real": set()}
    for kind, names in re.findall(r"^\s*(integer|real)\b[^:\n]*::([^\n!]*)", text, re.MULTILINE):
        found[kind] |= set(re.findall(r"[a-z_]\w*", re.sub(r"\([^)]*\)", "", names)))
    return found["integer"] - found["real"]


def closing(code: str, start: int) -> int:
    """Return the place of the parenthesis that closes the one before `start`, or -1."""
    depth = 1
    for place in range(start, len(code)):
        depth += {"(": 1, ")": -1}.get(code[place], 0)
        if depth == 0:
            return place
    return -1


def mutants_of(root: Path, file: str) -> list[Mutant]:
    """Return all mutants of a file."""
    text = (root / file).read_text(encoding="utf-8")
    whole = integers(text)
    found, seen = [], set()
    skip = continued = False
    first, quote = 0, ""
    for number, line in enumerate(text.splitlines(), 1):
        code, quote = code_of(line, quote), open_quote(line, quote)
        bare = code.strip()
        if not bare:
            continue
        if not continued:
            declares = DECLARATION.match(bare)
            first = (
                code.index("=", declares.end())
                if declares and "parameter" in code and "=" in code[declares.end() :]
                else 0
            )
            skip = bool(STRUCTURE.match(bare)) or bool(declares and not first)
        ends = not quote and not bare.endswith("&")
        if not skip:
            for kind, begin, end, new in places(
                code, whole, first, alone=not continued and ends and not first
            ):
                after = line[:begin] + new + line[end:]
                if after != line and (number, after) not in seen:
                    seen.add((number, after))
                    found.append(Mutant(file, number, kind, line, after))
        continued = not ends
        first = first if continued else 0
    return found


def places(code: str, whole: set[str], first: int, alone: bool):
    """Yield what can be replaced in a line: kind, begin, end, and the new text.

    Nothing before column `first` is changed; a statement is removed only if it is alone on its line.
    """
    for pattern, change, kind in SIMPLE:
        for match in re.finditer(pattern, code):
            if match.start() >= first:
                # a constant grows or shrinks by one, depending on where it stands
                by = 1 if match[0] == "0" or match.start() % 2 else -1
                yield (
                    kind,
                    match.start(),
                    match.end(),
                    change(match[0]) if change else str(int(match[0]) + by),
                )
    for match in RELATION.finditer(code):
        if match.start() < first:
            continue
        yield "relation", match.start(), match.end(), OPPOSITE[match[0]]
        # between reals equality is hit by no test and has no meaning
        sides = (
            re.search(r"([\w%]+)(\([^()]*\))?\s*$", code[: match.start()]),
            re.match(r"\s*([\w%]+)", code[match.end() :]),
        )
        names = {side[1].split("%")[-1] for side in sides if side}
        if match[0] in EDGE and names & (whole | {"size", "count", "ubound"}):
            yield "edge", match.start(), match.end(), EDGE[match[0]]
    if not alone:
        return
    begin = len(code) - len(code.lstrip())
    bare = code.strip()
    guard = GUARDED.match(bare)
    if guard and not bare.startswith("else"):
        end = closing(code, begin + guard.end())
        if end > 0:
            condition = code[begin + guard.end() : end]
            if not RELATION.search(condition) and not condition.startswith(".not."):
                yield "logic", begin + guard.end(), end, f".not. ({condition})"
            if not code[end + 1 :].strip().startswith("then") and code[end + 1 :].strip():
                yield "removed", begin, len(code.rstrip()), "continue"
    elif REMOVABLE.match(bare):
        yield "removed", begin, len(code.rstrip()), "continue"
