"""The command bench: its labels, units and counts; durations are not tested."""

import json
import math

import numpy as np
import pytest
import vibroimpact as vi
from programs import Runner, find_command
from vibroimpact.commands import bench

NAMES = ["impacts_per_second", "verdicts_per_second", "chart_ms", "vertex_us"]


def test_document(tmp_path):
    """The JSON document has each number by name, and what it was measured on; no file is written."""
    done = Runner([find_command()], tmp_path)("bench", "--json")
    assert (done.status, done.err) == (0, b"")
    document = json.loads(done.out)
    found = document["results"]["bench"]
    assert list(found) == ["vibroimpact", "machine", "compiler", "lapack", "threads", *NAMES]
    assert found["vibroimpact"] == vi.__version__
    assert all(found[name] for name in ("machine", "compiler", "lapack"))
    assert found["threads"].startswith("measured on 1; ")
    for name, (label, unit, _) in bench.MEASURES.items():
        assert 0 < found[name] < math.inf
        (line,) = [line for line in document["output"] if line.startswith(label)]
        assert line.endswith(f" {found[name]:,.4g} {unit}")
    assert not list(tmp_path.iterdir())


def test_fastest_run_divided_by_what_it_did(monkeypatch):
    """`best` divides the shortest run by its count, by a simulated clock; the first run does not count."""
    clock, lasts, runs = [0.0], iter([0.1, 2.0, 1.0, 3.0]), []

    def work():
        clock[0] += next(lasts)
        runs.append(clock[0])
        return 4

    monkeypatch.setattr(bench.time, "process_time", lambda: clock[0])
    monkeypatch.setattr(bench, "BUDGET", 3.5)
    assert bench.best(work) == pytest.approx(0.25)
    assert len(runs) == 4


def test_what_is_counted(monkeypatch):
    """The counts are of impacts only, of computed verdicts, and of the vertices of a closed zone."""
    kept = {}
    for name in ("simulate", "stability_flags", "zone"):
        real = getattr(bench, name)

        def noted(*args, _real=real, _name=name, **words):
            kept[_name] = _real(*args, **words)
            return kept[_name]

        monkeypatch.setattr(bench, name, noted)
    assert bench.impacts() == (kept["simulate"].events["kind"] == "impact").sum() > 5000
    flags_number = bench.verdicts()
    flags = kept["stability_flags"]
    assert flags_number == flags.status.size
    assert (flags.status == 0).sum() >= flags_number - 1  # in one, three phases are within 0.007
    assert {0, 1} <= set(np.unique(flags.stable))
    assert bench.vertices() == sum(len(loop) for loop in kept["zone"].loops) > 1000
    assert kept["zone"].closed
    assert bench.chart() == 1
