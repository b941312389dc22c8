"""Microseconds of CPU per point of a boundary of a zone, here and by AUTO-07p (if installed) on the same curve."""

import math
import os
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import vibroimpact as vi

ROUNDS = 7
HERE = Path(__file__).resolve().parent
OSC = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
PROGRAM = HERE.parent / "build/fortran/benchmarks/boundary_point"
WINDOW = ((0.8, 1.2), (2, 200))
TARGET = 5.0
# name, pattern, symmetric, type of piece, its number in the core, multiplier (AUTO's condition; None: not asked)
CASES = [
    ("flip curve of two impacts", "RL", False, "flip", 2, -1),
    ("fold curve of three impacts", "RRL", False, "fold", 1, 1),
    ("Neimark-Sacker curve of three impacts", "RRL", False, "neimark_sacker", 3, None),
]
CONSTANTS = """\
NDIM={size}, IPS=0, IRS=0, ILP=0, ICP=[1]
NTST=1, NCOL=4, IAD=0, ISP=0, ISW=1, IPLT=0, NBC=0, NINT=0
NMX={points}, NPR=100000, MXBF=0, IID=0, ITMX=8, ITNW=8, NWTN=3, JAC=0
EPSL=1e-10, EPSU=1e-10, EPSS=1e-8
DS={step}, DSMIN=1e-6, DSMAX={step}, IADS=1
NPAR=2, THL={{}}, THU={{}}, UZSTOP={{1: [{low}, {high}]}}
"""


def auto_folder():
    """Folder of AUTO's object files; None without AUTO or a compiler."""
    folders = [os.environ.get("AUTO_DIR", ""), "/usr/lib/auto-07p"]
    program = shutil.which("auto-07p") or shutil.which("auto")
    if program:
        folders.append(str(Path(program).resolve().parent.parent))
    found = [Path(f) for f in folders if f and (Path(f) / "lib" / "main.o").exists()]
    return found[0] if found and shutil.which("gfortran") else None


def cpu_of(command, folder):
    """Seconds of CPU of a program."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


class Auto:
    """AUTO on one boundary, from the middle of the longest piece to its end.

    Its steps are ten times shorter than ours may be, so that there are enough points to measure and Newton's
    method has less to do. It checks nothing at its points: no multipliers, no other impacts.
    """

    def __init__(self, auto, folder, zone, kind, multiplier):
        self.folder = Path(folder)
        piece = max((p for p in zone.boundary if p.type == kind), key=len)
        middle = len(piece) // 2
        start = [*piece.x[:, middle], *piece.theta[:, middle], piece.r[middle]]
        sides = zone.pattern.signs.tolist()
        words = {
            "n": str(len(sides)),
            "sides": ", ".join(map(str, [*sides, sides[0]])),
            "multiplier": f"{multiplier}d0",
            "unknowns": ", ".join(f"{x:.17e}".replace("e", "d") for x in start),
            "log_clearance": f"{math.log(piece.clearance[middle]):.17e}".replace("e", "d"),
        }
        self.size = len(start)
        ends = [math.log(piece.clearance.min()), math.log(piece.clearance.max())]
        self.ends = ends
        for name, out in (("quiet", ".false."), ("telling", ".true.")):
            text = (HERE / "auto_boundary.f90.in").read_text()
            for word, value in {**words, "print": out}.items():
                text = text.replace(f"@{word}@", value)
            (self.folder / f"{name}.f90").write_text(text)
            objects = sorted(map(str, (auto / "lib").glob("*.o")))
            subprocess.run(
                ["gfortran", "-O3", "-ffree-line-length-none", "-fopenmp", f"{name}.f90", "-o", name, *objects],
                cwd=self.folder, check=True, capture_output=True,
            )  # fmt: skip

    def run(self, points, name="quiet"):
        """Seconds of CPU for so many points."""
        low, high = self.ends
        text = CONSTANTS.format(size=self.size, points=points, step=0.002, low=low, high=high)
        (self.folder / "fort.2").write_text(text)
        return cpu_of([f"./{name}"], self.folder)

    def points(self, count):
        """The number of points computed, which are written to fort.99 as lines u_i, theta_i, r, log D."""
        self.run(count, "telling")
        rows = (line.split() for line in (self.folder / "fort.7").read_text().splitlines())
        return sum(1 for row in rows if row[0] != "0")


def measure(program, auto, sides, symmetric, kind, number, multiplier):
    """Times of a point of the curve, a vertex of the zone, a step of the net, a point by AUTO; its deviation."""
    own = [str(program), sides, str(int(symmetric)), str(number), "1"]
    times, others, apart = [], [], None
    with tempfile.TemporaryDirectory() as folder:
        peer = None
        if auto and multiplier is not None:
            zone = vi.zone(OSC, vi.Pattern(sides), *WINDOW, symmetric=symmetric)
            peer = Auto(auto, folder, zone, kind, multiplier)
            count = peer.points(1000)
        for _ in range(ROUNDS):
            answer = subprocess.run(own, check=True, capture_output=True, text=True).stdout
            times.append([float(word) for word in answer.split()])
            if peer:
                # the time of the start is subtracted
                others.append(1e6 * (peer.run(count) - peer.run(2)) / (count - 2))
        if peer:
            command = [*own, f"{folder}/fort.99"]
            answer = subprocess.run(command, check=True, capture_output=True, text=True).stdout
            apart = float(answer.split()[1])
    vertex, point, step = (statistics.median(column) for column in zip(*times, strict=True))
    return point, vertex, step, statistics.median(others) if others else None, apart


def rows(program=PROGRAM) -> list[dict]:
    """The measurements, one dictionary per row; `peer` and `same_answer` are None without a peer."""
    if not Path(program).exists():
        sys.exit(f"{program} is not there: ninja -C build/fortran benchmarks/boundary_point")
    auto = auto_folder()
    answer = []
    for title, *case in CASES:
        work = f"{title} ({case[0]})"
        point, vertex, step, other, apart = measure(program, auto, *case)
        peer = {"peer": None, "peer_name": None, "same_answer": None}
        told = dict(peer)
        if other is not None:
            told = {"peer": other, "peer_name": "AUTO-07p", "same_answer": apart < 1e-7}
        answer += [
            {"work": f"a point of the {work}", "ours": point, "unit": "µs", "target": TARGET, **told},
            {"work": f"a vertex of the zone, {work}", "ours": vertex, "unit": "µs", "target": TARGET, **peer},
            {"work": f"a step of the net, {work}", "ours": step, "unit": "µs", "target": None, **peer},
        ]  # fmt: skip
    return answer


def main():
    print("microseconds of CPU, median of", ROUNDS)
    if auto_folder() is None:
        print("  AUTO-07p or gfortran is not installed: our own times only")
    wrong = False
    for row in rows(*sys.argv[1:2]):
        peer = ""
        if row["peer"] is not None:
            peer = f"   {row['peer_name']} {row['peer']:6.1f}, {row['peer'] / row['ours']:.1f} times as much"
            wrong = wrong or not row["same_answer"]
        print(f"  {row['work']:67} {row['ours']:6.2f}{peer}")
    if wrong:
        sys.exit("AUTO's points are not on the curve")


if __name__ == "__main__":
    main()
