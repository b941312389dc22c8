"""Report progress, keep findings on disk, and print a table at the end."""

import hashlib
import resource
import sys
import time
from pathlib import Path

FINDINGS = Path(__file__).with_name("findings")


class Report:
    """Counts of inputs by what was tested."""

    #: Number of examples kept for each kind of finding.
    most = 3
    #: Number of bytes of each example that are printed.
    shown = 2000

    def __init__(self):
        self.rows = {}
        self.kinds = {}
        self.told = time.monotonic()

    def count(self, what, refused=0, accepted=0):
        """Count inputs that were answered correctly."""
        row = self.rows.setdefault(what, [0, 0, 0])
        row[0] += refused
        row[1] += accepted
        if time.monotonic() > self.told + 10:
            self.told = time.monotonic()
            print(f"{what}: {sum(row):,}", file=sys.stderr, flush=True)

    def find(self, what, kind, data, suffix):
        """Keep an input that was not answered correctly; `kind` describes in one line what happened."""
        self.rows.setdefault(what, [0, 0, 0])[2] += 1
        seen = self.kinds.setdefault((what, kind), [])
        if len(seen) < self.most:
            FINDINGS.mkdir(exist_ok=True)
            path = FINDINGS / f"{hashlib.sha256(data).hexdigest()[:12]}{suffix}"
            path.write_bytes(data)
            seen.append(path)
            print(f"{what}: {kind}: {path}", file=sys.stderr, flush=True)

    def finish(self):
        """Print the findings with the beginnings of their inputs, and the table; return the exit status."""
        for (what, kind), paths in self.kinds.items():
            print(f"\n{what}: {kind}")
            for path in paths:
                text = path.read_bytes()[: self.shown].decode(errors="backslashreplace")
                print(f"--- {path}\n{''.join(map(visible, text))}")
        print(f"{'':32}{'tried':>10}{'refused':>10}{'accepted':>10}{'findings':>10}")
        for what, row in self.rows.items():
            print(f"{what:32}{sum(row):10,}{row[0]:10,}{row[1]:10,}{row[2]:10,}")
        used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
        print(f"{sum(use.ru_utime + use.ru_stime for use in used):.0f} s of CPU time")
        return 1 if self.kinds else 0


def visible(character):
    """A character in a form that a log can show."""
    return character if character.isprintable() or character == "\n" else ascii(character)[1:-1]
