#!/usr/bin/env python3
"""Rules of the Fortran core that no compiler checks, as tests for pytest and as a script."""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SOURCE = ROOT / "src"
KINDS = "numerics/kinds.f90"
# Each folder may use only folders before it.
FOLDERS = ("numerics", "mechanics", "motions", "cases", "studies", "door", "cli", "c")
# The folders of studies, likewise.
STUDIES = (
    "common", "structures", "simulate", "periodic", "continuation", "attractors", "find", "branches", "zones",
    "charts", "atlas", "rigs",
)  # fmt: skip
MAX_COLUMNS = 100


def ordered_files():
    """The files of src/meson.build in the order of its lists, which is the order of dependence."""
    build = re.sub(r"#.*", "", (SOURCE / "meson.build").read_text(encoding="utf-8"))
    names = re.findall(r"'([\w/]+\.f90(?:\.in)?)'", build)
    assert KINDS in names, "src/meson.build was not understood"
    return list(dict.fromkeys(names))


def code_lines(path):
    """The lines without comments; no string of the core holds an exclamation mark."""
    return [line.split("!")[0].rstrip() for line in path.read_text(encoding="utf-8").splitlines()]


def stem_module(name):
    return "vi_" + Path(name).name.split(".")[0]


def every_source():
    return [
        *SOURCE.rglob("*.f90*"),
        *Path(__file__).parent.glob("*.f90"),
        *(ROOT / "benchmarks").glob("*.f90"),
        *(ROOT / "python/boundary").glob("*.f90"),
    ]


def test_every_file_is_listed():
    listed = set(ordered_files())
    present = {path.relative_to(SOURCE).as_posix() for path in SOURCE.rglob("*.f90*")}
    assert present - listed == set(), f"not in src/meson.build: {sorted(present - listed)}"


def test_modules_are_used_upwards_only():
    above = set()
    core = set()
    for name in ordered_files():
        path = SOURCE / name
        if not path.exists():  # output of a template
            continue
        used = set()
        for line in code_lines(path):
            match = re.match(r"\s*use\s*(?:,\s*(\w+)\s*)?(?:::)?\s*(\w+)", line)
            if match and match[1] != "intrinsic":
                used.add(match[2])
        if name.endswith("_single.f90"):
            assert used == set(), f"{name} uses {sorted(used)}"
        # single precision and wide variants are generated from files listed above
        allowed = above | {module + twin for module in core for twin in ("_single", "_wide")}
        assert used <= allowed, f"{name} uses what is not above it: {sorted(used - allowed)}"
        above.add(stem_module(name))
        core.add(stem_module(name))


def rank(name):
    """The place of a file's folder in the order, and within studies of the folder there."""
    folder, *inner = name.split("/")[:-1]
    return FOLDERS.index(folder), STUDIES.index(inner[0]) if folder == "studies" else 0


def test_folders_are_used_upwards_only():
    names = [name for name in ordered_files() if (SOURCE / name).exists()]
    rank_of = {stem_module(name): rank(name) for name in names}
    for name in names:
        path = SOURCE / name
        for line in code_lines(path):
            match = re.match(r"\s*use\s*(?:,\s*\w+\s*)?(?:::)?\s*(\w+)", line)
            below = match and rank_of.get(match[1], (0, 0)) > rank(name)
            assert not below, f"{name} uses {match[1]}, which is in a folder below it"


def test_module_names():
    for path in SOURCE.rglob("*.f90*"):
        text = "\n".join(code_lines(path))
        modules = re.findall(r"^\s*module\s+(?!procedure)(\w+)$", text, re.MULTILINE)
        programs = re.findall(r"^\s*program\s+\w+$", text, re.MULTILINE)
        assert programs or modules == [stem_module(path)], f"{path} holds {modules}"


def test_no_results_of_deferred_length():
    """gfortran keeps their length in a static variable of the caller, which threads share."""
    begin = re.compile(r"\s*(?!end\b).*\bfunction\s+(\w+)\s*\([^)]*\)(?:.*\bresult\s*\((\w+)\))?")
    for path in every_source():
        result = None
        for line in "\n".join(code_lines(path)).replace("&\n", "").splitlines():
            if match := begin.match(line):
                result = match[2] or match[1]
            if re.match(r"\s*character\s*\((len\s*=)?\s*:\s*\)", line):
                names = re.findall(r"\w+", line.partition("::")[2])
                assert result not in names, f"{path}: {result} has a deferred length"
            if re.match(r"\s*end\s+function\b", line):
                result = None


def test_names_are_closed():
    """`implicit none (type, external)` and `private` in every module, `only` in every use."""
    for path in every_source():
        lines = code_lines(path)
        text = "\n".join(lines)
        assert "implicit none (type, external)" in text, path
        if re.search(r"^\s*module\s+\w+$", text, re.MULTILINE):
            assert re.search(r"^\s*private$", text, re.MULTILINE), f"{path}: no private"
        for line in lines:
            if re.match(r"\s*use\b", line):
                assert re.search(r",\s*only\s*:", line), f"{path}: {line.strip()}"
            nameless = re.match(r"\s*end\s*(module|subroutine|function|program|type)$", line)
            assert not nameless, f"{path}: {line.strip()}"


def test_layout_of_lines():
    wrong = []
    for path in every_source():
        lines = path.read_text(encoding="utf-8").splitlines()
        for number, line in enumerate(lines, 1):
            if len(line) > MAX_COLUMNS:
                wrong.append(f"{path}:{number}: {len(line)} columns")
            if line != line.rstrip() or "\t" in line:
                wrong.append(f"{path}:{number}: blanks at the end, or tabs")
    assert not wrong, "\n".join(["layout of lines", *wrong])


def test_core_is_silent():
    """Below the command line nothing prints, stops, or reads and writes files."""
    for folder in ("numerics", "mechanics", "motions", "cases", "studies", "c"):
        for path in (SOURCE / folder).rglob("*.f90"):
            for line in code_lines(path):
                verb = re.match(r"\s*(print|stop|error stop|open|close|read|write)\b", line)
                if folder == "cases" and re.match(
                    r"\s*(read|write) \((text|buffer|digits)\b", line
                ):
                    continue  # numbers to and from text
                assert not verb, f"{path}: {line.strip()}"


def main():
    failed = 0
    tests = [(name, item) for name, item in globals().items() if name.startswith("test_")]
    for name, item in tests:
        try:
            item()
        except AssertionError as error:
            failed += 1
            print(f"FAILED: {name}: {error}")
    print(f"{len(tests) - failed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
