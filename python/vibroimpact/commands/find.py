"""`vibroimpact find`: all periodic motions at a point that a search finds."""

from __future__ import annotations

import argparse
import sys
import textwrap

from ..errors import ParameterError, SingularError
from ..find import FoundMotions, find
from ..model import Oscillator
from ..progress import Progress
from ..run import read_namelist
from . import add_files

HELP = "search for all periodic motions at a point"
DESCRIPTION = """Search for all periodic motions, stable and unstable, at the points of the cases of namelist
files, or at the one that the options name; print them and how they were searched for."""
EXAMPLE = "vibroimpact find --xi 0.005 --mu 0.042 --restitution 0.75 --r 0.94 --clearance 37 --max-impacts 3"

#: A point: oscillator, r, clearance, load.
Point = tuple[Oscillator, float, float, float]


def arguments(parser: argparse.ArgumentParser) -> None:
    """Files, or a point; and the limits of the search."""
    add_files(parser, "*")
    for name, wanted in (
        ("xi", "damping ratio"), ("mu", "mass ratio"), ("r", "frequency ratio"),
        ("clearance", "d K/F0"),
    ):  # fmt: skip
        parser.add_argument(f"--{name}", type=float, metavar=name.upper(), help=wanted)
    parser.add_argument(
        "--restitution", type=float, nargs="+", metavar="R",
        help="coefficient of restitution of both walls, or of the right one and the left one",
    )  # fmt: skip
    parser.add_argument(
        "--max-impacts", type=int, default=6, metavar="N", help="impacts a period (default: 6)"
    )
    parser.add_argument(
        "--max-cycles", type=int, default=2, metavar="K", help="load cycles a period (default: 2)"
    )


def run(options: argparse.Namespace) -> int:
    """Search at each point once."""
    status = 0
    for point in dict.fromkeys(_points(options)):
        if point is None:
            status = 1
            continue
        osc, r, clearance, load = point
        with Progress("find") as bar:
            found = find(
                osc, r, clearance, options.max_impacts, options.max_cycles, load, progress=bar.show
            )
        walls = ", ".join(f"{value:g}" for value in osc.restitution)
        print(
            f"xi = {osc.xi:g}, mu = {osc.mu:g}, restitution = {walls}, r = {r:g}, clearance = {clearance:.10g}"
            + (f", load = {load:g}" if load != 1 else "")
        )
        print(table(found))
        options.record.add(f"r = {r!r}, clearance = {clearance!r}", {
            "motions": [motion.to_dict() for motion in found], "searched": str(found.search),
        })  # fmt: skip
        print(textwrap.fill(f"searched: {found.search}", 100))
        status = status if found else 1
    return status


def table(found: FoundMotions) -> str:
    """The motions one a line: pattern, multipliers, extreme positions, load phases of the impacts."""
    if not found:
        return "no periodic motion was found"
    width = max(5, *(len(motion.pattern.sides) for motion in found))
    lines = [f"{'sides':<{width}}  cycles  {'verdict':<32}       x_min       x_max  max|x|/A"]
    for motion in found:
        leading = f"(max|lambda| = {abs(motion.multipliers[0]):.4g}, {motion.leading_kind})"
        verdict = {True: "stable", False: "unstable", None: "stable?"}[motion.stable]
        ratio = f"{motion.attenuation:8.4f}" if motion.A > 0 else "       -"
        lines.append(
            f"{motion.pattern.sides:<{width}}  {motion.pattern.cycles:>6}  {verdict + ' ' + leading:<43}"
            f" {motion.x_min:11.6g} {motion.x_max:11.6g}  {ratio}"
        )
    return "\n".join(lines)


def _points(options: argparse.Namespace) -> list[Point | None]:
    """The points that are asked for; None where one cannot be told."""
    names = ("xi", "mu", "restitution", "r", "clearance")
    given = [name for name in names if getattr(options, name) is not None]
    if options.files:
        if given:
            raise ParameterError(f"--{given[0]}: must be left out beside a namelist file")
        return [point for file in options.files for point in _points_of(file)]
    for name in names:
        if name not in given:
            raise ParameterError(
                f"--{name}: must be given, or a namelist file instead of the options"
            )
    walls = options.restitution[0] if len(options.restitution) == 1 else tuple(options.restitution)
    return [(Oscillator(options.xi, options.mu, walls), options.r, options.clearance, 1.0)]


def _points_of(file: str) -> list[Point | None]:
    """The points of the cases of a file; phases that are given have a clearance of their own."""
    points: list[Point | None] = []
    for case in read_namelist(file):
        if case.r is None or (case.kind != "branch" and "parameter" in case.keys):
            raise ParameterError(
                f"{file}: {case.name}: must be a &motion, &simulate or &branch; "
                f"&{case.kind} has no point to search at"
            )
        if case.motion_kind != "periodic":
            keys = case.keys
            points.append((case.osc, case.r, keys["clearance"], keys.get("load", 1.0)))
            continue
        try:
            points.append((case.osc, case.r, case.motions()[0].clearance, 1.0))
        except SingularError as error:
            print(f"{case.name}: {error}", file=sys.stderr)
            points.append(None)
    return points
