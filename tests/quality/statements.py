"""The statements with mutants in the compiled sources (switched.py)."""

import json
import re
import subprocess
from bisect import bisect_left
from collections import defaultdict
from itertools import groupby
from pathlib import Path

#: The end of a procedure: the statements before it are not related to those after it.
END = re.compile(r"end (subroutine|function)\b|contains\b", re.IGNORECASE)


class Statements:
    """Of each statement: its lines, its mutants, and the first number among them, by which it is called."""

    def __init__(self, folder: Path):
        self.index = json.loads((folder / "mutants.json").read_text(encoding="utf-8"))
        #: Of each file, in order: (first line, last line, first number).
        self.known = defaultdict(list)
        #: The statement of a mutant by its number.
        self.of_number = {}
        #: The number of a mutant by file, line and text.
        self.numbers = {}
        for number, file, line, _before, after, begin, end in self.index:
            self.numbers[file, line, after] = number
            known = self.known[Path(file).name]
            if not known or known[-1][0] != begin:
                known.append((begin, end, number))
            self.of_number[number] = known[-1][2]
        #: Of each statement: those of its procedure, in order.
        self.beside: dict[int, list[int]] = {}
        for path in (path for path in folder.glob("tree/src/*/*.f90") if path.name in self.known):
            lines = path.read_text(encoding="utf-8").splitlines()
            ends = [i for i, line in enumerate(lines, 1) if END.match(line.strip())]
            for _, group in groupby(self.known[path.name], lambda item: bisect_left(ends, item[0])):  # noqa: B023
                firsts = [first for _, _, first in group]
                self.beside |= dict.fromkeys(firsts, firsts)

    def names(self) -> dict[int, tuple]:
        """Return, of each statement, what stays when others change: file, text, and which of these it is."""
        names, seen = {}, defaultdict(int)
        for number, file, _, text, *_ in self.index:
            if self.of_number[number] == number:
                seen[file, text.strip()] += 1
                names[number] = (file, text.strip(), seen[file, text.strip()])
        return names

    def nearest(self, statement: int, reached) -> int:
        """Return a statement if it is reached, otherwise the nearest reached statement before it, or after it.

        A compiler joins some statements with their neighbours, or inlines or moves them, so that nothing is
        counted at their lines.
        """
        firsts = self.beside[statement]
        place = firsts.index(statement)
        around = [*firsts[place::-1], *firsts[place + 1 :]]
        return next((first for first in around if first in reached), statement)

    def at(self, file: str, line: int) -> int:
        """Return the statement at a line; 0 if none that has mutants is there."""
        # a twin has the line numbers of its source
        known = self.known.get(file.replace("_single.f90", ".f90").replace("_wide.f90", ".f90"), ())
        place = bisect_left(known, (line + 1,)) - 1
        return known[place][2] if place >= 0 and known[place][0] <= line <= known[place][1] else 0

    def of_places(self, program: Path, places: list[int]) -> dict[int, int]:
        """Return the statement of each place that a program or library counts."""
        said = subprocess.run(
            ["addr2line", "-e", str(program)], input="\n".join(hex(place - 1) for place in places),
            capture_output=True, text=True, check=True,
        ).stdout  # fmt: skip
        found = {}
        for place, line in zip(places, said.splitlines(), strict=True):
            file, _, number = line.split(" ")[0].rpartition(":")
            found[place] = self.at(Path(file).name, int(number)) if number.isdigit() else 0
        return found
