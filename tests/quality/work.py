"""How much work a case takes: how often each procedure is called from another file.

An answer does not tell whether a fast path decided, or how often an iteration began again, and on a busy machine
the time tells little. So the objects of a build are linked once more, with a counter before each procedure of
numerics, mechanics, motions and studies that other files call (--wrap of the linker): nothing is compiled again.
"""

import ctypes
import json
import os
import re
import shlex
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from door import Library

ROOT = Path(__file__).resolve().parents[2]
KEPT = ROOT / "tests/data/answers/work.jsonl"
ROOMS = ("numerics", "mechanics", "motions", "studies")
#: How gfortran and flang name a procedure of a module.
SYMBOL = re.compile(
    r"__vi_(?P<module>\w+?)_MOD_(?P<procedure>[a-z]\w*)|_QMvi_(?P<of>\w+?)P(?P<name>[a-z]\w*)"
)
#: Declarations of studies and reports of progress do not count as work.
OTHER = re.compile(r"(progress|processor|status)\.|.*_study\.declare_")
#: Files of lanes are compiled twice, and the processor decides which copy runs: both count as one.
WIDE = "_wide"
HEAD = """.section .note.GNU-stack,"",@progbits
.bss
.balign 8
.globl work
.type work,@object
.size work,{size}
work: .globl counters
.hidden counters
counters: .zero {size}
.text
"""
COUNTED = """.globl __wrap_{symbol}
.hidden __wrap_{symbol}
__wrap_{symbol}: lock incq counters+{offset}(%rip)
jmp __real_{symbol}
"""


class Work(Library):
    """The library for C of a build, whose calls are counted; it is made beside that library."""

    def __init__(self, build: Path):
        symbols = called(build)
        with tempfile.TemporaryDirectory(dir=build / "src/c") as folder:
            counted = Path(folder) / "counted.so"
            link(build, list(symbols), counted)
            # the place where it looks for LAPACK may be relative to its own
            place = counted.replace(build / f"src/c/counted-{os.getpid()}.so")
        super().__init__(place)
        place.unlink()
        counters = (ctypes.c_int64 * len(symbols)).in_dll(self.c, "work")
        self.counters = np.ctypeslib.as_array(counters)
        self.names = list(symbols.values())

    def count(
        self, text: str, seconds: float | None = None
    ) -> tuple[dict | None, float, dict[str, int]]:
        """Return the answer to a case, its CPU seconds, the calls of each procedure and its progress."""
        self.counters[:] = 0
        found, took = self.run(text, seconds)
        calls = dict(zip(("progress.done", "progress.expected"), self.progress, strict=True))
        for i in np.flatnonzero(self.counters):
            calls[self.names[i]] = calls.get(self.names[i], 0) + int(self.counters[i])
        return found, took, calls


def called(build: Path) -> dict[str, str]:
    """Return the symbols of procedures that other files call, each with the name of module and procedure."""
    here = {path.stem for room in ROOMS for path in (ROOT / "src" / room).glob("*.f90")}
    objects = [*build.glob("src/libvibroimpact*.p/*.o"), *build.glob("src/c/*.p/*.o")]
    told = subprocess.run(["nm", *objects], check=True, capture_output=True, text=True).stdout
    kinds = {"T": set(), "U": set()}
    for kind, symbol in re.findall(r"^[\da-f ]* ([TU]) (\S+)$", told, re.MULTILINE):
        kinds[kind].add(symbol)
    names = {}
    for symbol in sorted(kinds["T"] & kinds["U"]):
        if found := SYMBOL.fullmatch(symbol):
            module = (found["module"] or found["of"]).removesuffix(WIDE)
            name = f"{module}.{found['procedure'] or found['name']}"
            if module.removesuffix("_single") in here and not OTHER.match(name):
                names[symbol] = name
    return names


def link(build: Path, symbols: list[str], out: Path) -> None:
    """Link the library for C of a build, with a counter before each of some procedures."""
    ask = ["ninja", "-C", build, "-t", "commands", "-s", library_of(build)]
    said = subprocess.run(ask, check=True, capture_output=True, text=True).stdout
    words = shlex.split(said.splitlines()[-1])
    counted, hidden = out.with_suffix(".s"), out.with_suffix(".map")
    counted.write_text(
        HEAD.format(size=8 * len(symbols))
        + "".join(COUNTED.format(symbol=symbol, offset=8 * i) for i, symbol in enumerate(symbols)),
        encoding="utf-8",
    )
    option = "-Wl,--version-script="
    shown = next(word for word in words if word.startswith(option)).removeprefix(option)
    hidden.write_text(
        (build / shown).read_text(encoding="utf-8").replace("global:", "global: work;", 1),
        encoding="utf-8",
    )
    assembled = out.with_suffix(".o")
    subprocess.run(["as", "-o", assembled, counted], check=True)
    words[words.index("-o") + 1] = str(out)
    words[words.index(option + shown)] = option + str(hidden)
    first = next(
        i for i, word in enumerate(words) if word.endswith(".a") or word == "-Wl,--start-group"
    )
    wrapped = [f"-Wl,--wrap={symbol}" for symbol in symbols]
    subprocess.run(
        [*words[:first], str(assembled), *wrapped, *words[first:]], cwd=build, check=True
    )


def library_of(build: Path) -> str:
    """Return the library for C of a build, as a path in its folder."""
    return str((build / "src/c/libvibroimpact.so").resolve().relative_to(build.resolve()))


def differences(kept: dict[str, int | None], found: dict[str, int]) -> list[str]:
    """Return the procedures that are not called as often as was kept; None: that depends on the compiler."""
    return [
        name for name in sorted({*kept, *found})
        if kept.get(name, 0) is not None and kept.get(name, 0) != found.get(name, 0)
    ]  # fmt: skip


def merged(one: dict[str, int | None], other: dict[str, int]) -> dict[str, int | None]:
    """Return the calls that two builds have in common; None where they have not."""
    return {
        name: one.get(name, 0) if one.get(name, 0) == other.get(name, 0) else None
        for name in {*one, *other}
    }


def load(count: int) -> list[dict[str, int | None]]:
    """Return the kept calls of so many cases."""
    cases: list[dict[str, int | None]] = [{} for _ in range(count)]
    with KEPT.open(encoding="utf-8") as lines:
        for line in lines:
            kept = json.loads(line)
            for case, calls in kept["calls"].items():
                cases[int(case)][kept["procedure"]] = calls
    return cases


def store(cases: list[dict[str, int | None]]) -> None:
    """Keep the calls of cases: a line for each procedure."""
    names = sorted({name for case in cases for name in case})
    lines = [
        json.dumps({
            "procedure": name, "calls": {i: case[name] for i, case in enumerate(cases) if name in case},
        }, separators=(",", ":"))
        for name in names
    ]  # fmt: skip
    new = KEPT.with_suffix(".new")
    new.write_text("\n".join([*lines, ""]), encoding="utf-8")
    new.replace(KEPT)
