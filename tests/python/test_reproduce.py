"""The recomputed paper: its zones by independent methods, its statements, and the storage of results."""

import contextlib
import json
import math
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact.motions.likeness import standard_motion
from vibroimpact.reproduce import (
    appendix,
    canvas,
    captions,
    damper,
    phase_errors,
    proof6a,
    run,
    scan,
    statements,
    sweeps,
    table1,
    tasks,
)
from vibroimpact.reproduce.digits import upper_boundary
from vibroimpact.reproduce.paper import EQUAL, LOADS, MASRI, UNEQUAL, kind_of
from vibroimpact.reproduce.phases import curve

RATIOS = np.array([0.7, 0.9, 1.0, 1.1, 1.3])
ROUGH = 0.1
VERDICTS = ("agrees", "differs", "cannot be checked")


def perturbed(motion):
    """A state near a motion, just after its first impact."""
    x = 1.001 * float(motion.X[0])
    return {
        "t": motion.load_phase / motion.r, "x": x, "x_dot": float(motion.X_dot_after[0]),
        "z": x + 0.4999 * motion.clearance, "z_dot": float(motion.Z_dot_after[0]),
    }  # fmt: skip


def stays(motion):
    """Whether a simulation that starts near a motion returns to it."""
    run = vi.simulate(
        motion.osc, motion.r, motion.clearance, 4, state=perturbed(motion), discard=4000
    )
    impacts = run.events[run.events["kind"] == "impact"]
    here = impacts["x"][impacts["side"] == "R"]
    return bool(here.size >= 3 and np.allclose(here, motion.X[0], rtol=1e-4))


# zones by scanning


def test_no_equispaced_motion_in_the_gap():
    """No equispaced motion is stable for 0.962 < r < 0.981 with Figure 3's parameters."""
    assert scan.equispaced_zone(MASRI, np.linspace(0.962, 0.9805, 38), 400) == []


def test_the_gap_ends_before_the_printed_end():
    """In the paper the gap ends at r = 0.985, but a simulation confirms a stable equispaced motion at 0.984."""
    (strip,) = scan.equispaced_zone(MASRI, np.array([0.984]), 400)
    pair = vi.equispaced(MASRI, 0.984, math.sqrt(strip.low[0] * strip.high[0]))
    (stable,) = [motion for motion in pair if motion.stable]
    assert stays(stable)


@pytest.mark.parametrize(
    ("r", "there"), [(0.99, False), (1.0, True), (1.05, True), (1.09, True), (1.1, False)]
)
def test_equispaced_motions_on_masris_line(r, there):
    """The equispaced motions at d K/F0 = 37 continue beyond r = 1.04."""
    assert scan.equispaced_verdict(MASRI)(np.array([r]), np.array([37.0]))[0] == there


@pytest.mark.parametrize("edge", ["low", "high"])
def test_edges_of_the_equispaced_zone_by_simulation(edge):
    """Just inside the boundary, a simulation returns to the equispaced motion; just outside it does not."""
    for strip in scan.equispaced_zone(EQUAL, RATIOS, 120):
        for r, gap in zip(strip.r, getattr(strip, edge), strict=True):
            out = 0.98 if edge == "low" else 1.02
            assert any(stays(m) for m in vi.equispaced(EQUAL, r, gap / out))
            assert not any(stays(m) for m in vi.equispaced(EQUAL, r, gap * out))


def test_upper_boundary_to_forty_digits():
    """Multipliers in double precision and the symmetry-breaking limit in 40 digits give the same boundary."""
    r = np.array([0.7, 0.97, 1 - 1e-7, 1.0, 1 + 1e-7, 1.3])
    exact = [float(upper_boundary(EQUAL, float(x))) for x in r]
    np.testing.assert_allclose(statements.upper(r, "double"), exact, rtol=1e-9)
    np.testing.assert_allclose(statements.upper(r, "single"), exact, rtol=1e-4)


def test_both_zones_of_two_impacts_meet():
    """The unequispaced zone, from phases, begins where the equispaced one, from its closed form, ends."""
    equal = scan.equispaced_zone(EQUAL, RATIOS, 120)
    unequal = scan.pair_zone(EQUAL, RATIOS, 400)
    low = {r: a for strip in equal for r, a in zip(strip.r, strip.low, strict=True)}
    high = {r: b for strip in unequal for r, b in zip(strip.r, strip.high, strict=True)}
    for r in RATIOS:
        assert high[r] == pytest.approx(low[r], rel=1e-4)


def test_traced_zone_is_the_scanned_one():
    """Newton's method over a grid and the linear problem over all phases give the same zone."""
    r = np.linspace(1.08, 1.12, 5)
    (scanned,) = [s for s in scan.pair_zone(UNEQUAL, r, 800) if s.high[0] > 20]
    state = {"t": 0.0, "x": 0.0, "x_dot": 0.0, "z": 0.0, "z_dot": 7.0}
    seed = vi.exact(UNEQUAL, 1.1, 20.0, vi.simulate(UNEQUAL, 1.1, 20.0, 8, state, discard=800))
    (traced,) = scan.traced_zone(UNEQUAL, [seed], r, 60)
    np.testing.assert_allclose(traced.low, scanned.low, rtol=1e-3)
    np.testing.assert_allclose(traced.high, scanned.high, rtol=1e-3)
    assert traced.contains(1.1, 20.0)
    assert not traced.contains(1.1, 1.01 * float(traced.high[2]))
    assert not traced.contains(1.2, 20.0)


def test_a_scan_continues_beyond_the_loads_of_the_sweeps():
    """The scan of motions with rest ends on the traced boundary, at loads that no sweep reaches."""
    r = np.linspace(0.84, 0.86, 5)
    state = {"t": 0.0, "x": 0.0, "x_dot": 0.0, "z": 0.0, "z_dot": 1.0}
    trajectories = (
        vi.simulate(UNEQUAL, 0.85, gap, 8, state, discard=800) for gap in np.linspace(1.3, 2, 8)
    )
    seeds = []
    for end in trajectories:
        with contextlib.suppress(vi.errors.VibroimpactError):  # a run that does not settle
            motion = vi.exact(UNEQUAL, end.r, end.clearance, end)
            seeds += [standard_motion(motion)] if motion.pattern.sides in ("RRL*", "L*RR") else []
    assert seeds
    window = (0.4, 60.0)
    (scanned,) = scan.traced_zone(UNEQUAL, seeds, r, 60, window)
    assert np.all(scanned.low < 0.99 / (LOADS[1] * scan.scale(r)))
    found = vi.zone(UNEQUAL, vi.Pattern("RRL*"), (0.83, 0.87), window)
    for factor, inside in ((0.998, False), (1.002, True)):
        assert np.all(found.contains(r, factor * scanned.low) == inside)


def test_join_follows_slopes_and_splits():
    """Intervals that rise fast stay one strip; where an interval splits in two, a new strip begins."""
    r = np.linspace(1.0, 1.5, 6)
    middle = np.exp(3.0 * r) / scan.scale(r)
    low, high = 0.8 * middle, 1.25 * middle
    (strip,) = scan.join(r, np.arange(6), low, high)
    np.testing.assert_array_equal(strip.high, high)
    middle = np.exp(0.5 * r) / scan.scale(r)
    low, high = 0.8 * middle, 1.25 * middle
    rows = np.array([0, 1, 2, 2, 3, 3])
    lows, highs = low[rows], high[rows]
    highs[[2, 4]], lows[[3, 5]] = 0.95 * middle[[2, 3]], 1.1 * middle[[2, 3]]
    assert sorted(s.r.size for s in scan.join(r, rows, lows, highs)) == [2, 4]
    assert scan.join(r, np.array([], dtype=int), np.array([]), np.array([])) == []


# statements


def test_tau_depends_on_the_load():
    """Figure 4: of two motions at r = 0.999, the one with more load has a different tau."""
    two = curve(0.999, np.array([0.4, 0.85]))
    assert two.clearance[0] < two.clearance[1]
    assert abs(two.sin_tau[0] - two.sin_tau[1]) > 0.1


def test_thin_zone_at_resonance():
    """Figure 3: at r = 1 the unequispaced zone is thin, and its largest multiplier comes close to 1."""
    width, (_, largest) = statements.near_one()
    assert 0 < width < 0.02
    assert 0.99 < largest < 1


@pytest.mark.parametrize(
    "row", appendix.study(), ids=lambda row: f"{row['motion']}: {row['corrected']}"
)
def test_appendix(row):
    """(A6) and (A7) are the derivative, and det[P] obeys its law, only with all three corrections."""
    if len(row["corrected"]) == 3:
        assert row["largest_error"] < 1e-13
        assert row["determinant"] == pytest.approx(row["law"], rel=1e-10)
    else:
        assert row["largest_error"] > 0.1
        assert row["determinant"] != pytest.approx(row["law"], rel=0.1)


@pytest.mark.parametrize("unit", [1.0, 3.7, 0.02])
def test_unit_of_length(unit):
    """Multipliers are dimensionless; only with the printed S_6i in P_ia(3,1) they depend on the unit of length."""
    motion = vi.periodic(MASRI, 0.94, [0, 1.37 * math.pi], vi.Pattern("RL"))
    for left in appendix.CORRECTIONS:
        chosen = set(appendix.CORRECTIONS) - {left}
        here, there = (
            appendix.largest(motion, chosen, x) for x in (motion.clearance, motion.clearance / unit)
        )
        assert (there == pytest.approx(here, rel=1e-9)) == (left != "P31" or unit == 1)
    whole = appendix.largest(motion, appendix.CORRECTIONS, motion.clearance / unit)
    assert whole == pytest.approx(abs(motion.multipliers[0]), rel=1e-9)


def test_phases_read_without_error_are_consistent():
    """With exact phases the overdetermined equations hold to rounding, and all verdicts are right."""
    motions = phase_errors.family(0.90, 8.0, 4)
    row = phase_errors.misread(motions, 0.0, 2)
    assert row["residual"][2] < 1e-12
    assert row["accepted"] == [1.0, 1.0]
    assert row["wrong"] == [0.0, 0.0]
    assert row["clearance_off"] < 1e-10
    assert phase_errors.misread(motions, 0.05, 20)["accepted"][0] < 1


@pytest.mark.parametrize(
    ("point", "sides"), list(zip(phase_errors.POINTS, ("RRL", "RRLL", "RRRLL"), strict=True))
)
def test_patterns_are_found(point, sides):
    """A search at a point of Figure 7 finds stable motions with three, four and five impacts per cycle."""
    found = vi.find(EQUAL, *point, max_impacts=5, max_cycles=1, states=8)
    # attractors beyond the limits of the search are listed too
    stable = [m for m in found if m.stable and len(m.pattern) <= 5 and m.pattern.cycles == 1]
    assert {
        max(m.pattern.sides, standard_motion(m, mirrored=True).pattern.sides) for m in stable
    } == {sides}


# simulated sweeps


def test_sweep_ends_on_motions_of_the_zone():
    """In a sweep of the load at r = 1.1, steps that settle on equispaced motions are in the equispaced zone."""
    seen = sweeps.sweep(EQUAL, 1.1, 9, 30.0)
    assert [item["direction"] for item in seen] == ["up"] * 9 + ["down"] * 9
    assert seen[8]["load"] == seen[9]["load"] > seen[0]["load"]
    (strip,) = scan.equispaced_zone(EQUAL, np.array([1.1]), 120)
    holds = [item for item in seen if item["kind"] == "2e"]
    assert len(holds) >= 4
    for item in holds:
        assert strip.low[0] < 1 / item["load"] < strip.high[0]
        gap = 1 / item["load"]
        (motion,) = [m for m in vi.equispaced(EQUAL, 1.1, gap) if m.stable]
        assert item["attenuation"] == pytest.approx(motion.attenuation, rel=1e-3)


def test_bars_join_successive_holds():
    """A bar is a sequence of steps of a sweep with one kind of motion in one direction."""
    kinds = ["2e", "2e", "3", "2e"]
    seen = [
        {"direction": d, "kind": kind, "load": load}
        for d, order in (("up", (0, 1, 2, 3)), ("down", (3, 2, 1, 0)))
        for load, kind in ((float(i), kinds[i]) for i in order)
    ]
    found = sweeps.bars([{"r": 1.0, "seen": seen}], "2e")
    assert [(bar.low, bar.high) for bar in found] == [(0, 1), (3, 3), (3, 3), (0, 1)]


def test_kinds():
    """Kinds of motions have the names used in the paper."""
    assert kind_of("RL", 1, [0, math.pi], alike=True) == "2e"
    assert kind_of("LR", 1, [1, 5], alike=True) == "2u"
    assert kind_of("RL", 1, [0, math.pi]) == "2"
    assert kind_of("RRLL", 1) == "4"
    assert kind_of("RLRL", 2) == "4/2"
    assert kind_of("RL*", 1) == "rest"


# how results are stored


def test_needs_come_first():
    """Every task comes after the tasks that it needs, and naming a task includes them."""
    order = list(tasks.TASKS)
    for name, task in tasks.TASKS.items():
        assert all(order.index(need) < order.index(name) for need in task.needs)
    assert tasks.with_needs(["table1"]) == ["table1"]
    assert set(tasks.with_needs(["figure7"])) == {"figure7", *tasks.SWEEPS["equal"]}
    assert set(tasks.with_needs(["report"])) == set(order) - set(tasks.ON_REQUEST)
    assert set(captions.CAPTIONS) == {name for name in tasks.NAMES if name.startswith("figure")}


def test_unknown_name_gives_the_list(tmp_path):
    """The error for an unknown name lists the known names."""
    with pytest.raises(vi.errors.ParameterError, match=r"figure5.*table1, figure3, figure4a"):
        run.reproduce(["figure5"], tmp_path)
    assert not list(tmp_path.iterdir())


def test_failure_fails_what_needs_it_and_nothing_else(tmp_path, monkeypatch, capsys):
    """Without matplotlib Figure 4a fails, but Table 1 is written."""
    monkeypatch.setitem(sys.modules, "matplotlib.pyplot", None)
    assert run.reproduce(["table1", "figure4a"], tmp_path, ROUGH, workers=1) == 1
    assert "matplotlib" in capsys.readouterr().err
    assert (tmp_path / "table1.csv").exists()
    assert not (tmp_path / "figure4a.csv").exists()


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """All tasks at a coarse resolution, in two processes, as the command runs them."""
    folder = tmp_path_factory.mktemp("results")
    assert run.reproduce((), folder, ROUGH, workers=2) in (0, 1)
    return folder


@pytest.mark.slow
def test_everything_is_there(whole):
    """All outputs of all tasks exist, and no temporary file is left."""
    for name, task in tasks.TASKS.items():
        for output in task.outputs:
            if name in tasks.ON_REQUEST:
                assert not (whole / output).exists()
            else:
                assert (whole / output).stat().st_size > 0
    assert not list(whole.rglob("*.part"))


def statements_of(folder):
    """The rows of the statements."""
    return json.loads((folder / "data" / "statements.json").read_text(encoding="utf-8"))


@pytest.mark.slow
def test_unit_of_the_printed_multiplier(whole):
    """The statement gives the multiplier by the transcribed formulas in two units of length."""
    (row,) = (row for row in statements_of(whole) if row["where"] == "(A6), (A7)")
    motion = vi.periodic(MASRI, 0.94, [0, 1.37 * math.pi], vi.Pattern("RL"))
    units = {
        "as transcribed with lengths in F₀/K": motion.clearance,
        "with Table 1's unit (d = 37)": 37.0,
    }
    for unit, clearance in units.items():
        assert f"{appendix.largest(motion, (), clearance):.1f} {unit}" in row["found"]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "osc"), [("a", EQUAL), ("b", UNEQUAL)])
def test_two_readings_of_figure_10(name, osc, whole):
    """The statement quotes the paper; at r = 0.98 the quoted words hold for some loads, but not for every load."""
    rows = [
        row for row in statements_of(whole)
        if row["where"] == f"Figure 10{name}" and "“amplifications always occur”" in row["statement"]
    ]  # fmt: skip
    extremes = np.sort(damper.curve(osc, 0.98).attenuation)[[0, -1]]
    assert extremes[0] < 1 < extremes[1]
    assert [row["verdict"] for row in rows] == ["differs", "agrees"]
    for row, loads, extreme in zip(rows, ("every load", "some loads"), extremes, strict=True):
        assert row["statement"].endswith(loads)
        assert f"X_max/A: {extreme:.3f} at r = 0.98" in row["found"]


@pytest.mark.slow
def test_simulations_are_not_called_measurements(whole):
    """If only a simulation is compared, the verdict states this, and no text calls it an experiment."""
    rows = [row for row in statements_of(whole) if "simulated" in row["found"]]
    assert len(rows) >= 8
    for row in rows:
        assert row["verdict"] in ("simulation agrees", "simulation differs", "cannot be checked")
        assert "measure" in row["statement"]
    report = (whole / "report.html").read_text(encoding="utf-8")
    assert "numerical experiment" not in report
    assert "experiment and theory" not in report
    for name in ("figure6a", "figure6b", "figure7", "figure8a", "figure8b", "figure10a"):
        done = json.loads((whole / "data" / f".{name}.done").read_text(encoding="utf-8"))
        assert "experiment" not in done["messages"]


@pytest.mark.slow
def test_two_readings_of_section_2(whole):
    """One row is about the verdicts, one about the accepted motions; with 1.5 % far fewer motions are accepted."""
    rows = [row for row in statements_of(whole) if "virtually no effect" in row["statement"]]
    assert [row["statement"].split("read as: on ")[1].split()[0] for row in rows] == [
        "the",
        "which",
    ]
    assert rows[1]["verdict"] == "differs"
    near = [
        row
        for row in json.loads((whole / "data" / "phase_errors.json").read_text(encoding="utf-8"))
        if row["error"] == 0.02
    ]
    change = max(abs(row["wrong"][0] - row["wrong"][1]) for row in near)
    assert rows[0]["verdict"] == ("agrees" if 100 * change < 2 else "differs")
    for k, rule in enumerate(("3 %", "1.5 %")):
        shares = ", ".join(f"{100 * row['accepted'][k]:.0f}" for row in near)
        assert f"{shares} % ({rule})" in rows[1]["found"]


def test_counts_every_statement():
    """Each verdict is counted once."""
    verdicts = [*VERDICTS, "agrees", "simulation agrees", "simulation agrees", "simulation differs"]
    assert statements.counted(verdicts) == (
        "2 agree, 1 differ, 1 cannot be checked; 3 are about measurements that the text does not give: for 2 of "
        "them a simulation agrees with the computed zone"
    )


def test_thinned_outline_is_the_same_curve():
    """Every omitted point is within the tolerance of the drawn line."""
    angle = np.linspace(0, 2 * math.pi, 4001)
    line = np.stack([1 + 0.3 * np.cos(angle), np.exp(np.sin(3 * angle))], axis=1)
    few = canvas.thinned(line)
    assert len(few) < 400
    assert (few[0] == line[0]).all()
    assert (few[-1] == line[-1]).all()
    scale = np.ptp(np.c_[line[:, 0], np.log(line[:, 1])], axis=0)
    points, corners = (np.c_[x[:, 0], np.log(x[:, 1])] / scale for x in (line, few))
    start, step = corners[:-1], np.diff(corners, axis=0)
    share = ((points[:, None] - start) * step).sum(axis=2) / (step**2).sum(axis=1)
    foot = start + np.clip(share, 0, 1)[..., None] * step
    away = np.linalg.norm(points[:, None] - foot, axis=2).min(axis=1)
    assert away.max() <= canvas.THINNED


@pytest.mark.slow
def test_proof_of_figure_6a(tmp_path, monkeypatch):
    """A coarse proof of a part of the zone agrees with the traced zone, and its certificate is kept."""
    pytest.importorskip("flint")
    monkeypatch.setattr(proof6a, "R", (1.2, 1.21))
    assert run.reproduce(["proof6a"], tmp_path, resolution=0.005, workers=1) == 0
    proof = vi.Certificate.from_json((tmp_path / "proof6a.json").read_text(encoding="utf-8"))
    zone = vi.zone(EQUAL, "RL", r=proof6a.R, clearance=proof6a.CLEARANCE, symmetric=True)
    decided = 0
    for r, D in np.random.default_rng(3).uniform((1.2, 0), (1.21, math.log(200)), (40, 2)):
        verdict = proof.decide(r, math.exp(D))
        decided += verdict is not None
        assert verdict in (None, bool(zone.contains(r, math.exp(D))))
    assert decided > 10
    assert (tmp_path / "proof6a.png").stat().st_size > 0


@pytest.mark.slow
def test_report_stands_alone(whole):
    """The page has no external references, and contains every figure and statement."""
    text = (whole / "report.html").read_text(encoding="utf-8")
    outside = re.findall(r'(?:src|href|url)\s*[=(]\s*["\']?(?!data:|#)([^"\')>\s]+)', text)
    assert outside == []
    assert not re.search(r"https?://|<script|@import", text)
    assert text.count("<img ") == sum(name.startswith("figure") for name in tasks.NAMES)
    assert text.count('src="data:image/svg+xml;base64,') == text.count("<img ")
    for row in statements_of(whole):
        assert row["verdict"] in {*VERDICTS, "simulation agrees", "simulation differs"}
        assert row["found"]
    counted = statements.counted([row["verdict"] for row in statements_of(whole)])
    assert text.index(counted) < text.index("<nav>")
    assert len(text) < 3_000_000
    assert text.count("<section") == text.count("</section>")


@pytest.mark.slow
def test_interrupt_leaves_whole_items(tmp_path):
    """Ctrl-C ends with status 1; the outputs of finished tasks are complete."""
    code = "import sys; from vibroimpact.commands.command import main; sys.exit(main(sys.argv[1:]))"
    names = ["figure3", "figure7", "figure8b", "figure10a"]
    command = [sys.executable, "-c", code, "reproduce", *names, "-o", str(tmp_path)]
    process = subprocess.Popen(
        command,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        # a background job of a shell would inherit that interrupts are ignored
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    while process.poll() is None and len(list(tmp_path.glob("data/.sweep*.done"))) < 2:
        time.sleep(0.005)
    os.killpg(process.pid, signal.SIGINT)  # the signal goes to all processes, as from a terminal
    _, message = process.communicate()
    assert process.returncode == 1
    assert "interrupted" in message
    assert "Traceback" not in message
    assert not list(tmp_path.rglob("*.part"))
    stamps = list(tmp_path.glob("data/.sweep*.done"))
    assert 2 <= len(stamps) < sum(map(len, tasks.SWEEPS.values()))
    for stamp in stamps:
        done = tasks.Done(**json.loads(stamp.read_text(encoding="utf-8")))
        (output,) = tasks.TASKS[done.name].outputs
        assert json.loads((tmp_path / output).read_text(encoding="utf-8"))


def session_of(leader):
    """The ids of the processes of a session, without zombies."""
    found = []
    for place in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            state, _, _, session = place.read_text().rpartition(")")[2].split()[:4]
            if int(session) == leader and state != "Z":
                found.append(int(place.parent.name))
    return found


@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="no /proc")
def test_workers_end_with_a_killed_program(tmp_path):
    """After kill -9 of the program its busy and idle workers end within seconds."""
    code = "import sys; from vibroimpact.commands.command import main; sys.exit(main(sys.argv[1:]))"
    # two workers, one of which is idle as soon as the other has the last task
    start = "import os; os.sched_getaffinity = lambda _: {0, 1}\n" + code
    process = subprocess.Popen(
        [sys.executable, "-c", start, "reproduce", "figure8b", "-o", str(tmp_path)],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True,
    )  # fmt: skip
    try:
        while process.poll() is None and len(list(tmp_path.glob("data/.sweep*.done"))) < 2:
            time.sleep(0.01)
        assert len(session_of(process.pid)) >= 3
        process.kill()
        process.wait()
        end = time.monotonic() + 60
        while session_of(process.pid) and time.monotonic() < end:
            time.sleep(0.1)
        assert session_of(process.pid) == []
    finally:
        for number in session_of(process.pid):
            with contextlib.suppress(OSError):
                os.kill(number, signal.SIGKILL)


@pytest.mark.parametrize(
    ("end", "stable"), [(0, (False, True)), pytest.param(1, (True, False), marks=pytest.mark.slow)]
)
def test_proofs_of_the_ends_of_a_range(end, stable):
    """They are between a stable and an unstable motion less than 1e-12 apart."""
    pytest.importorskip("flint")
    start = next(one for one in vi.equispaced(MASRI, 1.04, 37.0) if one.stable)
    line = vi.branch(start, "r", bounds=(0.9975, 1.0965))
    ends = [point.r for point in line.special_points if point.type in statements.ENDS]
    assert len(ends) == 2
    sides = statements.certificates_of_end(line, ends[end])
    assert tuple(side.stable for side in sides) == stable
    places = [float(side.system["r"]) for side in sides]
    assert 0 < places[1] - places[0] < 1e-12


def test_proofs_of_statements(monkeypatch):
    """The proofs agree with the motions found; without python-flint there are none, and the page states this."""
    pytest.importorskip("flint")
    stable = {name: motion.stable for name, motion in table1.motions().items()}
    text = statements.proof_of_motions()
    assert text.count(",") == len(stable) - 1
    for name, verdict in stable.items():
        assert f"{name} {'stable' if verdict else 'unstable'}" in text
    # the whole range crosses resonance; beyond its ends not all motions are stable
    assert "from 1.0390 to 1.0410" in statements.proof_of_line(1.039, 1.041)
    assert statements.proof_of_line(1.09, 1.1) == ""
    start = next(one for one in vi.equispaced(MASRI, 1.04, 37.0) if one.stable)
    # another motion at these parameters is not on this branch
    other = next(one for one in vi.equispaced(MASRI, 1.04, 37.0) if not one.stable)
    near = vi.branch(start, "r", bounds=(1.0399, 1.0401)).prove()
    assert statements.lies_on(start.prove(), near)
    assert not statements.lies_on(other.prove(), near)
    monkeypatch.setitem(sys.modules, "flint", None)
    assert statements.proven(statements.proof_of_motions) == ""
