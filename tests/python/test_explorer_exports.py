"""Exports of the explorer: Python, namelists, definitions of motions."""

import subprocess
import sys
from pathlib import Path

import pytest
import vibroimpact as vi
from shared_explorer_states import STATES
from vibroimpact.cases.case import read_namelist
from vibroimpact.explorer.definition import definition_of
from vibroimpact.explorer.explorer import Explorer, diagram_of, simulate_run
from vibroimpact.explorer.export import as_namelist, as_python
from vibroimpact.explorer.motions import fuller
from vibroimpact.explorer.state import State
from vibroimpact.explorer.zones import FINE, compute, families
from vibroimpact.motions.likeness import same_motion


def filled(state):
    """An explorer after its full search, with complete zones."""
    explorer = Explorer(state)
    explorer.learn(fuller(state.osc, state.r, state.clearance, explorer.shown))
    explorer.zones = {
        family: compute(state.osc, family, state.window, FINE)
        for family in families(state.osc, state.patterns[:2])
    }
    return explorer


@pytest.mark.slow
@pytest.mark.parametrize("state", STATES.values(), ids=STATES)
def test_python_gives_what_is_shown(state, capsys):
    """The exported Python computes every number of the motions, run, diagram and zones to the last bit."""
    explorer, names = filled(state), {}
    exec(as_python(explorer), names)
    assert len(capsys.readouterr().out.splitlines()) == len(explorer.shown)
    for motion, item in zip(names["motions"], explorer.shown, strict=True):
        assert motion.pattern == item.motion.pattern
        for name in ("phases", "X", "X_dot_after", "Z_dot_after", "multipliers"):
            assert getattr(motion, name).tolist() == getattr(item.motion, name).tolist()
        assert (motion.stable, motion.attenuation) == (item.motion.stable, item.motion.attenuation)
    assert names["run"].events.tolist() == simulate_run(state).events.tolist()
    assert names["diagram"].points.tolist() == diagram_of(state).points.tolist()
    for zone, shown in zip(names["zones"], explorer.zones.values(), strict=True):
        assert [ring.tolist() for ring in zone.loops] == [ring.tolist() for ring in shown.loops]


@pytest.mark.slow
@pytest.mark.parametrize("state", STATES.values(), ids=STATES)
def test_namelist_gives_what_is_shown(state, tmp_path):
    """The cases of the file are the motions (with rest: their events), the run and the zones, bit for bit."""
    explorer = filled(state)
    (tmp_path / "explorer.nml").write_text(as_namelist(explorer), encoding="utf-8")
    log = vi.run_namelists([tmp_path / "explorer.nml"], tmp_path)
    assert log.status == 0 or all("no such" in line for fault, line in log.lines if fault)
    cases = {case.name: case for case in read_namelist(tmp_path / "explorer.nml")}
    found, rests = [], []
    for name, case in cases.items():
        if "motion" in name:
            (rests if case.kind == "simulate" else found).extend(case.run())
    assert sum(motion.admissible for motion in found) + len(rests) == len(explorer.shown)
    for item in explorer.shown:
        if item.definition.kind == "state":
            assert any(
                same_motion(vi.exact(run.osc, run.r, run.clearance, run), item.motion)
                for run in rests
            )
            continue
        assert item.motion.X.tolist() in [motion.X.tolist() for motion in found]
    assert cases["explorer_run"].run()[0].events.tolist() == simulate_run(state).events.tolist()
    for i, zone in enumerate(explorer.zones.values(), start=1):
        rings = cases[f"explorer_zone_{i}"].run()[0].loops
        assert [ring.tolist() for ring in rings] == [ring.tolist() for ring in zone.loops]


@pytest.mark.parametrize("line", [
    (1.04, 5.0, 1.04, 60.0), (1.01, 60.0, 1.01, 5.0), (0.96, 20.0, 1.06, 20.0),
    (1.06, 7.0, 0.96, 7.0)])  # fmt: skip
def test_the_batch_program_gives_the_diagram(line, tmp_path):
    """From the namelist the program computes each impact of the displayed diagram, also at another r."""
    explorer = Explorer(State(line=line))
    (tmp_path / "explorer.nml").write_text(as_namelist(explorer), encoding="utf-8")
    program = [Path(sys.executable).with_name("vibroimpact-batch"), "explorer.nml", "-o", "out"]
    subprocess.run(program, cwd=tmp_path, check=True, capture_output=True)
    lines = (tmp_path / "out" / "explorer_diagram.csv").read_text().splitlines()
    head, *rows = [row.split(",") for row in lines if not row.startswith("#")]
    diagram = diagram_of(explorer.state)
    assert head[1] == diagram.parameter
    assert len(rows) == len(diagram.points) > 1000
    for i, name in enumerate(head[4:], start=4):
        assert [float(row[i]) for row in rows] == diagram.points[name].tolist()
    assert [float(row[1]) for row in rows] == diagram.values[diagram.points["index"]].tolist()


def test_an_oblique_line_is_left_to_python():
    """A line across both axes is not in the namelist, which states this in a comment."""
    text = as_namelist(Explorer(State(line=(0.9, 10.0, 1.1, 30.0))))
    assert "\n&bifurcation" not in text
    assert text.splitlines()[-1].startswith("! a &bifurcation cannot follow an oblique line")


def test_motions_without_phases_have_a_definition():
    """A motion with rest is defined by one of its states."""
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))
    motion = vi.exact(osc, 0.9, 6.0, vi.simulate(osc, 0.9, 6.0, cycles=8, discard=200))
    definition, made = definition_of(motion)
    assert definition.kind == "state"
    assert made.pattern == motion.pattern
    assert abs(made.multipliers[0]) == pytest.approx(abs(motion.multipliers[0]), rel=1e-9)
