"""Cases of namelist files, or the one that options name: run, written in any form, and drawn, once."""

from __future__ import annotations

import argparse
import json
import re
import tempfile
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from ..errors import ChartInterrupted, ParameterError
from ..files import write_text
from ..interchange.dataset import save_dataset
from ..interchange.namelist import Groups
from ..interchange.plain import encode
from ..interchange.table import (
    NOT_CLOSED,
    chart_columns,
    counted,
    head_text,
    rows_text,
    tag,
)
from ..plot.animation import check_format
from ..progress import Progress
from ..run import Case, run_namelists
from . import FORMATS, picture_writer
from .options import read_cases, run_cases
from .run import tell

#: Kinds that Python computes itself wherever more than a table is wanted, since they take their time.
LONG = ("zone", "atlas", "chart")


def run_kind(
    options: argparse.Namespace, kind: str | None, groups: Groups, needed: Sequence[str]
) -> int:
    """Run all cases of a kind (or of any), write and draw them; gives the exit status.

    Tables alone are left to the compiled program. Its words are those that are said in any case, and its
    tables have the bytes of those that are written here.
    """
    folder = Path(options.folder)
    animated = getattr(options, "animate", None)
    save = picture_writer() if options.plot or animated else None
    if animated:
        check_format(animated, f"--animate {animated}")
    if save is None and options.format == "csv" and not (options.json or options.stem):
        with Progress(kind or "run") as bar:
            show = bar.show if bar.wanted else None
            log = run_cases(options, kind, groups, needed, folder, show)
        tell(log)
        return log.status
    status = 0
    for case in renamed(options, read_cases(options, kind, groups, needed)):
        one = finish if case.kind in LONG else shorter
        status = max(status, one(options, case, folder, save))
    return status


def renamed(options: argparse.Namespace, cases: list[Case]) -> list[Case]:
    """The cases; the only one with the name of the file that -o names."""
    if not options.stem:
        return cases
    if len(cases) != 1:
        raise ParameterError(
            f"-o {options.stem}.{FORMATS[options.format]}: names a file, and there are {len(cases)} cases; must "
            "be a folder"
        )
    text = re.sub(r"(?m)^(  name = ).*$", rf"\g<1>'{options.stem}'", cases[0].text)
    return [cases[0]._replace(name=options.stem, text=text)]


def shorter(
    options: argparse.Namespace, case: Case, folder: Path, save: Callable[[Any, Path], Path] | None
) -> int:
    """Leave the table and the words of a case to the compiled program, and make the rest of it anew."""
    with tempfile.TemporaryDirectory() as place:
        source = Path(place) / "case.nml"
        source.write_text(case.text, encoding="utf-8")
        target = folder if options.format == "csv" else place
        with Progress(case.name) as bar:
            log = run_namelists(
                [source], target, progress=partial(bar.show, note="table") if bar.wanted else None
            )
    tell(log, options.record)
    if options.format == "csv":
        options.record.files += map(str, log.results)
    with Progress(case.name) as bar:
        results = case.run(bar.show if bar.wanted else None) if log.results else []
    put(options, case, results, folder, save)
    return log.status


def finish(
    options: argparse.Namespace, case: Case, folder: Path, save: Callable[[Any, Path], Path] | None
) -> int:
    """Compute a case that takes its time, say what came out, write and draw it."""
    stopped = False
    with Progress(case.name) as bar:
        try:
            (result,) = case.run(bar.show)
        except ChartInterrupted as stop:  # as far as it came
            result, stopped = stop.chart, True
    news, faults, there = WORDS[case.kind](result)
    for line in news:
        print(f"{case.name}: {line}")
    for line in faults:
        options.record.fault(f"{case.name}: {line}")
    if there:
        put(options, case, [result], folder, save)
    if stopped:
        raise KeyboardInterrupt
    return 1 if faults else 0


def put(
    options: argparse.Namespace, case: Case, results: Sequence[Any], folder: Path,
    save: Callable[[Any, Path], Path] | None,
) -> None:  # fmt: skip
    """Write the results of a case in the form that is wanted, and draw them."""
    for i, result in enumerate(results, start=1):
        folder.mkdir(parents=True, exist_ok=True)
        name = case.name if len(results) == 1 else f"{case.name}_{i}"
        options.record.add(name, chart_dict(result) if case.kind == "chart" else result)
        if options.format != "csv" or case.kind in LONG:
            path = folder / f"{name}.{FORMATS[options.format]}"
            if case.kind == "chart":
                write_chart(result, case, path)
            else:
                result.save(path)
            options.record.files.append(str(path))
        if save is not None and getattr(options, "animate", None):
            film = result.animate(folder / f"{name}.{options.animate}")
            options.record.files.append(str(film))
            print(f"{case.name}: {film}")
        if save is not None and options.plot and (case.kind not in LONG or drawable(result)):
            path = save(picture(result), folder / f"{name}.{options.plot}")
            options.record.files.append(str(path))
            print(f"{case.name}: {path}")


def drawable(result: Any) -> bool:
    """Whether there is anything to see."""
    return bool(getattr(result, "zones", True))


def picture(result: Any) -> Any:
    """The axes of a picture."""
    from ..plot.chart import draw_chart

    return (
        result.plot() if hasattr(result, "osc") or hasattr(result, "ends") else draw_chart(result)
    )


def chart_dict(data: Any) -> dict[str, Any]:
    """A chart as plain values."""
    values = {name: encode(item.values) for name, item in data.variables.items()}
    attributes = {name: encode(value) for name, value in data.attrs.items()}
    dimensions = {name: list(item.dims) for name, item in data.variables.items()}
    return {"type": "Chart", "attributes": attributes, "dimensions": dimensions, **values}


def write_chart(data: Any, case: Case, path: Path) -> None:
    """A chart in the form that its name ends with."""
    if path.suffix == ".nc":
        save_dataset(data.assign_attrs(case=case.text, Conventions="CF-1.11"), path)
    elif path.suffix == ".json":
        write_text(path, json.dumps(chart_dict(data), allow_nan=False))
    else:
        table = chart_columns(data)
        rows = rows_text(table, zip(*table.values(), strict=True))
        write_text(path, head_text(case.text.splitlines()) + rows)


#: What was said, what is missing, and whether there is a result.
Words = tuple[list[str], list[str], bool]


def zone_words(zone: Any) -> Words:
    """As the compiled program has them."""
    if zone.search.motions == 0:
        return [], [f"no motion {tag(zone)} was found anywhere in the window"], False
    if not zone.boundary and zone.closed:
        return [], [
            f"no zone: motions {tag(zone)} were found in the window, but none that is both stable and admissible"
        ], False  # fmt: skip
    kinds = ", ".join(dict.fromkeys(piece.type for piece in zone.boundary))
    said = (
        f"{tag(zone)}, {counted(len(zone.loops), 'loop')} in {counted(len(zone.boundary), 'piece')}"
    )
    said += f": {kinds}" if kinds else ""
    return [said], [] if zone.closed else [NOT_CLOSED], True


def atlas_words(atlas: Any) -> Words:
    """As the compiled program has them."""
    faults = [f"{tag(zone)} {NOT_CLOSED}" for zone in atlas.zones if not zone.closed]
    surveyed = counted(len(atlas.attractors), "attractor")
    if atlas.unexplained:
        lost = ", ".join(dict.fromkeys(map(tag, atlas.unexplained)))
        faults.append(f"{len(atlas.unexplained)} of {surveyed} in no zone of the pattern: {lost}")
    if not (atlas.zones or faults):
        return [], [
            "no zone: neither search nor survey found a stable, admissible motion within the limits in the window"
        ], False  # fmt: skip
    loops = [len(zone.loops) for zone in atlas.zones if zone]
    said = f"{counted(len(loops), 'zone')}, {counted(sum(loops), 'loop')}, {surveyed} surveyed"
    return [said], faults, True


def chart_words(data: Any) -> Words:
    """As the compiled program has them."""
    what = f"{data.attrs['sides']}/{data.attrs['cycles']}"
    there = data.status == 0
    if not bool(there.any()):
        return [], [f"no motion {what} was found anywhere in the window"], False
    good = (data.consistent == 1) & (data.admissible == 1) & (data.stable == 1)
    return [
        f"{int(there.sum())} motions {what} at {int(there.any('motion').sum())} of "
        f"{there.sizes['r'] * there.sizes['clearance']} points, {int(good.sum())} admissible and stable"
    ], [], True  # fmt: skip


WORDS: dict[str, Callable[[Any], Words]] = {
    "zone": zone_words, "atlas": atlas_words, "chart": chart_words,
}  # fmt: skip
