"""`vibroimpact find`: all periodic motions at a point that a search finds."""

from __future__ import annotations

import argparse
import contextlib
import re
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from ..base.errors import ParameterError, SingularError, StudyInterrupted
from ..base.progress import Progress
from ..cases.case import Case, read_namelist
from ..motions.motion import Motion
from ..studies.find import WITHOUT_IMPACTS, find
from ..systems.oscillator import Oscillator
from ..systems.units import Units, checked_names, units_to_show
from . import FORMATS, Record, add_files, add_forms, picture_writer, ready
from .cases import run_kind
from .options import options_of
from .request import Request, beside_files, read_cases, request_of

DESCRIPTION = """Search for all periodic motions, stable and unstable, for the &find cases of namelist files, at
the points of their other cases, or at the point given by the options; print the motions and the
extent of the search. With -o, --format or --plot they are written to DIR/NAME.csv, one row for
each impact, or in another format; --plot also writes a picture of their histories and
multipliers. NAME is "find" for the point of the options."""
EXAMPLE = (
    "vibroimpact find --xi .005 --mu .042 --restitution .75 --r .94 --clearance 37 --max-impacts 3 "
    "--plot -o results"
)
#: Keys of a search, other than those of the point.
LIMITS = ("max_impacts", "max_cycles", "guesses", "states", "settling", "releases", "max_events")


class Point(NamedTuple):
    """A point, and the limits of the search there."""

    osc: Oscillator
    r: float
    clearance: float
    load: float
    limits: tuple[tuple[str, Any], ...] = ()


def arguments(parser: argparse.ArgumentParser) -> None:
    """Files, or a point; and the limits of the search, which may also be given with files."""
    add_files(parser, "*")
    for name, option in options_of("find").items():
        parser.add_argument(f"--{name}", **option.how())
    add_forms(parser, on_request=True)


def request(options: argparse.Namespace) -> Request:
    """The case that the options name."""
    return request_of(options, "find", options_of("find"))


def run(options: argparse.Namespace) -> int:
    """Search at each point; errors in options are reported in terms of the options."""
    try:
        return search(options)
    except ParameterError as error:
        words = str(error)
        if match := re.match(r"(\w+) = ", words):
            option = f"--{match[1].replace('_', '-')}"
            words = f"{option} {words[match.end() :]}"
        raise ParameterError(words.replace(" max_", " --max-")) from None


def search(options: argparse.Namespace) -> int:
    """Search once at each point; print, write and draw the motions."""
    if options.files and any(
        case.structure for file in options.files for case in read_namelist(file)
    ):
        return run_structures(options)
    points, status = _points(options)
    if options.stem and len(points) != 1:
        raise ParameterError(
            f"-o {options.stem}.{FORMATS[options.format]}: names a file, and there are {len(points)} points; must "
            "be a folder"
        )
    with contextlib.nullcontext() if options.folder is None else ready(Path(options.folder)):
        return max(status, search_at(options, points))


def run_structures(options: argparse.Namespace) -> int:
    """Run the &find cases of files with structures, with the limits given there."""
    for name, option in options_of("find").items():
        if option.typed(options) is not None:
            raise ParameterError(beside_files(name, options.files))
    if options.folder is None:
        options.folder, options.format = "results", options.format or "csv"
    return run_kind(options, request(options), lambda found: repr(found).split("\n"))


def search_at(options: argparse.Namespace, points: dict[Point, str]) -> int:
    """Search at points that have been checked."""
    if options.units not in (None, "dimensionless"):
        options.units = checked_names(options.units, "--units")
    save, status, stopped = picture_writer() if options.plot else None, 0, False
    given = {name: getattr(options, name) for name in LIMITS}
    given = {name: value for name, value in given.items() if value is not None}
    for point, name in points.items():
        osc, r, clearance, load, limits = point
        with Progress("find") as bar:
            try:
                result = find(
                    osc, r, clearance, load=load, progress=bar.show, **(dict(limits) | given)
                )
            except StudyInterrupted as stop:
                result, stopped = stop.result, True
        walls = ", ".join(f"{value:g}" for value in osc.restitution)
        units = units_to_show(osc)
        if units is not None and options.units is not None:
            units = None if options.units == "dimensionless" else units.to(options.units)
        place = f"r = {r:g}, clearance = {clearance:.10g}"
        if units is not None:
            place = (
                f"{r * units.frequency:.6g} {units.hertz}, clearance d = {clearance * units.length:.10g} "
                f"{units.names.split()[0]} ({place})"
            )
        print(
            f"xi = {osc.xi:g}, mu = {osc.mu:g}, restitution = {walls}, {place}"
            + (f", load = {load:g}" if load != 1 else "")
        )
        print(table(result, units))
        if result._is_free:
            print(f"and {WITHOUT_IMPACTS}")
        print(textwrap.fill(f"searched: {result.search}", 100))
        if stopped:
            print(f"cut short: {result.cut}")
        options.record.add(f"r = {r!r}, clearance = {clearance!r}", result)
        if not result:
            status = 1
        elif options.folder is not None:
            folder = Path(options.folder)
            folder.mkdir(parents=True, exist_ok=True)
            path = folder / f"{options.stem or name}.{FORMATS[options.format]}"
            asked = options.units
            if asked is None and units is not None and options.format != "csv":
                asked = units.names
            result.save(path, units=asked)
            options.record.wrote(name, path)
            if save is not None:
                drawn = save(result.plot(units=options.units), path.with_suffix(f".{options.plot}"))
                options.record.wrote(name, drawn)
        if stopped:
            raise KeyboardInterrupt
    return status


def table(found: Sequence[Motion], units: Units | None = None) -> str:
    """The motions, one per line: pattern, multipliers, extreme positions (in units, if given)."""
    if not found:
        return "no periodic motion was found"
    length = 1.0 if units is None else units.length
    width = max(5, *(len(motion.pattern.sides) for motion in found))
    unit = "" if units is None else f" ({units.names.split()[0]})"
    lines = [
        f"{'sides':<{width}}  cycles  {'verdict':<32} {'x_min' + unit:>11} {'x_max' + unit:>11}  max|x|/A"
    ]
    for motion in found:
        leading = f"(max|lambda| = {abs(motion.multipliers[0]):.4g}, {motion.leading_kind})"
        verdict = {True: "stable", False: "unstable", None: "stable?"}[motion.stable]
        ratio = f"{motion.attenuation:8.4f}" if motion.A > 0 else "       -"
        lines.append(
            f"{motion.pattern.sides:<{width}}  {motion.pattern.cycles:>6}  {verdict + ' ' + leading:<43}"
            f" {motion.x_min * length:11.6g} {motion.x_max * length:11.6g}  {ratio}"
        )
    return "\n".join(lines)


def _points(options: argparse.Namespace) -> tuple[dict[Point, str], int]:
    """The requested points, each with the name of its result; status 1 if one cannot be determined."""
    if not options.files:
        ((case,), _) = read_cases(options, request(options))
        return {point_of(case): case.name}, 0
    for name, option in options_of("find").items():
        if name.replace("-", "_") not in LIMITS and option.typed(options) is not None:
            raise ParameterError(beside_files(name, options.files))
    points: dict[Point, str] = {}
    return points, max(_add_points(file, points, options.record) for file in options.files)


def point_of(case: Case) -> Point:
    """The point of a case, with the limits of a &find."""
    keys = case.keys
    if case.osc is None:
        raise ParameterError(f"{case.name}: must be a case of a &system, not of a &structure")
    limits = tuple((key, keys[key]) for key in LIMITS) if case.kind == "find" else ()
    return Point(case.osc, case.r, keys.get("clearance", 0.0), keys.get("load", 1.0), limits)


def _add_points(file: str, points: dict[Point, str], record: Record) -> int:
    """The points of the cases of a file; given phases determine the clearance."""
    status = 0
    for case in read_namelist(file):
        if case.r is None or (case.kind != "branch" and "parameter" in case.keys):
            raise ParameterError(
                f"{file}: {case.name}: must be at one point of r and clearance; this &{case.kind} is not"
            )
        point = point_of(case)
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
