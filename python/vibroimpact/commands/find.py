"""`vibroimpact find`: all periodic motions at a point that a search finds."""

from __future__ import annotations

import argparse
import contextlib
import re
import textwrap
from pathlib import Path

from ..case import read_namelist
from ..errors import ParameterError, SingularError
from ..find import FoundMotions, Point, find
from ..found import Findings
from ..model import Oscillator
from ..progress import Progress
from . import FORMATS, Record, add_files, add_forms, picture_writer, ready
from .options import add_numbers, add_system

HELP = "search for all periodic motions at a point"
DESCRIPTION = """Search for all periodic motions, stable and unstable, at the points of the cases of namelist
files, or at the one that the options name; print them and how they were searched for. With -o,
--format or --plot they are written to DIR/NAME.csv, one row an impact, or in another form, and a
picture of their histories and multipliers stands beside them. NAME is "find" for the point of
the options."""
EXAMPLE = (
    "vibroimpact find --xi .005 --mu .042 --restitution .75 --r .94 --clearance 37 --max-impacts 3 "
    "--plot -o results"
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """Files, or a point; and the limits of the search."""
    add_files(parser, "*")
    add_system(parser)
    parser.add_argument("--r", type=float, metavar="R", help="frequency ratio")
    parser.add_argument("--clearance", type=float, metavar="D", help="clearance d K/F0")
    add_numbers(
        parser,
        max_impacts="most impacts a period, 2 to 12 (default: 6)",
        max_cycles="most load cycles a period, 1 to 8 (default: 2)",
    )
    add_forms(parser, on_request=True)


def run(options: argparse.Namespace) -> int:
    """Search at each point; what is wrong with an option is said in its words."""
    try:
        return search(options)
    except ParameterError as error:
        words = str(error)
        if match := re.match(r"(\w+) = ", words):
            option = f"--{match[1].replace('_', '-')}"
            words = f"{option} {words[match.end() :]}".replace(" max_", " --max-")
        raise ParameterError(words) from None


def search(options: argparse.Namespace) -> int:
    """Search at each point once, print, write and draw the motions."""
    points, status = _points(options)
    if options.stem and len(points) != 1:
        raise ParameterError(
            f"-o {options.stem}.{FORMATS[options.format]}: names a file, and there are {len(points)} points; must "
            "be a folder"
        )
    with contextlib.nullcontext() if options.folder is None else ready(Path(options.folder)):
        return max(status, search_at(options, points))


def search_at(options: argparse.Namespace, points: dict[Point, str]) -> int:
    """The same at points that are good."""
    save, status = picture_writer() if options.plot else None, 0
    limits = {
        name: getattr(options, name)
        for name in ("max_impacts", "max_cycles") if getattr(options, name) is not None
    }  # fmt: skip
    for point, name in points.items():
        osc, r, clearance, load = point
        with Progress("find") as bar:
            found = find(osc, r, clearance, load=load, progress=bar.show, **limits)
        walls = ", ".join(f"{value:g}" for value in osc.restitution)
        print(
            f"xi = {osc.xi:g}, mu = {osc.mu:g}, restitution = {walls}, r = {r:g}, clearance = {clearance:.10g}"
            + (f", load = {load:g}" if load != 1 else "")
        )
        print(table(found))
        print(textwrap.fill(f"searched: {found.search}", 100))
        result = Findings.of(osc, r, clearance, found, load)
        options.record.add(f"r = {r!r}, clearance = {clearance!r}", result)
        if not found:
            status = 1
        elif options.folder is not None:
            folder = Path(options.folder)
            folder.mkdir(parents=True, exist_ok=True)
            path = folder / f"{options.stem or name}.{FORMATS[options.format]}"
            result.save(path)
            options.record.wrote(name, path)
            if save is not None:
                drawn = save(result.plot(), path.with_suffix(f".{options.plot}"))
                options.record.wrote(name, drawn)
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


def _points(options: argparse.Namespace) -> tuple[dict[Point, str], int]:
    """The points that are asked for, each with the name of its result; status 1 where one cannot be told."""
    names = ("xi", "mu", "restitution", "r", "clearance")
    given = [name for name in names if getattr(options, name) is not None]
    points: dict[Point, str] = {}
    if options.files:
        if given:
            raise ParameterError(f"--{given[0]}: must be left out beside a namelist file")
        return points, max(_add_points(file, points, options.record) for file in options.files)
    for name in names:
        if name not in given:
            raise ParameterError(
                f"--{name}: must be given, or a namelist file instead of the options"
            )
    walls = options.restitution[0] if len(options.restitution) == 1 else tuple(options.restitution)
    osc = Oscillator(options.xi, options.mu, walls)
    return {Point(osc, options.r, options.clearance, 1.0): "find"}, 0


def _add_points(file: str, points: dict[Point, str], record: Record) -> int:
    """The points of the cases of a file; phases that are given have a clearance of their own."""
    status = 0
    for case in read_namelist(file):
        if case.r is None or (case.kind != "branch" and "parameter" in case.keys):
            raise ParameterError(
                f"{file}: {case.name}: must be at one point of r and clearance; this &{case.kind} is not"
            )
        keys = case.keys
        point = Point(case.osc, case.r, keys.get("clearance", 0.0), keys.get("load", 1.0))
        if case.motion_kind == "periodic":
            try:
                point = point._replace(clearance=case.motions()[0].clearance)
            except SingularError as error:
                record.fault(f"{case.name}: {error}")
                status = 1
                continue
        if (
            points.setdefault(point, case.name) != case.name
            or [*points.values()].count(case.name) < 2
        ):
            continue
        raise ParameterError(
            f"{file}: &output name = {case.name!r}: is already the name of another point; must be another"
        )
    return status
