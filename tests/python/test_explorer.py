"""The explorer without a page: its state, motions and zones, and its command."""

import json
import signal
import socket
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import vibroimpact as vi
from shared_explorer_states import RUN, STATES
from vibroimpact.base.errors import MissingExtraError, ParameterError
from vibroimpact.commands.command import main
from vibroimpact.commands.explore import EXAMPLE
from vibroimpact.explorer.definition import Definition
from vibroimpact.explorer.explorer import Explorer, settles_on
from vibroimpact.explorer.motions import fuller, quick
from vibroimpact.explorer.process import start
from vibroimpact.explorer.server import panel
from vibroimpact.explorer.session import Session
from vibroimpact.explorer.shapes import thinned, zone_shapes
from vibroimpact.explorer.state import Run, State
from vibroimpact.explorer.zones import COARSE, FINE, compute, families
from vibroimpact.motions.likeness import same_motion
from vibroimpact.studies.geometry import signed_area

# -- the state and its link


@pytest.mark.parametrize("state", STATES.values(), ids=STATES)
def test_a_link_holds_the_whole_state(state):
    """Every field is restored bit for bit, including the chosen motion."""
    explorer = Explorer(state)
    explorer.choose(len(explorer.shown) - 1)
    explorer.let_run(RUN)
    state = explorer.state
    again, faults = State.read(state.query)
    assert (again, faults) == (state, [])
    other = Explorer(again)
    assert other.restore() == []
    assert other.index == explorer.index
    assert other.chosen.motion.X.tolist() == explorer.chosen.motion.X.tolist()


@pytest.mark.parametrize(("query", "word"), [
    ("xi=lots", "xi = 'lots'"), ("mu=-1", "mu = -1.0"), ("R1=1.5", "R1 = 1.5"), ("r=nan", "r = nan"),
    ("clearance=0", "clearance = 0.0"), ("r_min=1.3", "r = (1.3, 1.2)"), ("patterns=RX", "sides = 'RX'"),
    ("r=1e400", "r = '1e400'"), ("mu=1e-400", "mu = '1e-400'"), ("r=1_0", "r = '1_0'"),
    ("patterns=RL/" + "1" * 5000, "patterns = 'RL/111"), ("patterns=" + "RL" * 5000, "at most 8 symbols"),
    ("motion=RL/" + "1" * 5000 + "/phases/0,1", "motion = 'RL/111"), ("motion=RL/17/phases/0,1", "16 load cycles"),
    ("motion=RL/10000/state/0,0,0,0,0", "16 load cycles"), ("motion=" + "RL" * 13 + "/1/phases/0", "24 symbols"),
    ("patterns=RL/x", "patterns = 'RL/x'"), ("patterns=", "patterns"), ("line=1,2,3", "line = '1,2,3'"),
    ("line=1,2,1,2", "line = (1.0, 2.0, 1.0, 2.0)"), ("run=1,2", "run = '1,2'"), ("show=all", "show = 'all'"),
    ("run=0,0,0,0,inf,1,0", "z_dot = 'inf'"), ("run=0,0,0,0,0,0,0", "cycles = 0.0"),
    ("colour=red", "colour = 'red'"), ("motion=RL/1/phases/0", "motion = 'RL/1/phases/0'"),
    ("motion=RL/2/equispaced/0", "number 0 or 1"), ("xi=0", "xi = 0")])  # fmt: skip
def test_a_bad_part_of_a_link_is_named_and_the_rest_kept(query, word):
    """An invalid part of a link gives one message, and every other part is kept."""
    state, faults = State.read(
        f"{query}&mu=0.05&R2=0.5" if "mu" not in query else f"{query}&R2=0.5"
    )
    assert len(faults) == 1
    assert word in faults[0]
    assert len(faults[0]) < 300
    assert state.R2 == 0.5
    assert replace(state, R2=0.75, mu=0.028) == State()


def test_a_motion_that_is_not_there_is_named():
    """A link whose motion does not exist at its point gives a message that names it, and restores the rest."""
    explorer = Explorer(State(clearance=200.0, motion=Definition.read("RL/1/equispaced/0")))
    (fault,) = explorer.restore()
    assert "RL/1/equispaced/0" in fault
    assert explorer.state == State(clearance=200.0)


def test_a_change_that_is_refused_changes_nothing():
    """An error names the field, and the state does not change."""
    explorer = Explorer(State())
    for words in ({"xi": "2"}, {"r": "1", "xi": "0"}, {"run": "0,0,0,99,0,5,0"}):
        with pytest.raises(ParameterError):
            explorer.set(words) if "run" not in words else explorer.let_run(Run(z=99.0))
        assert explorer.state == State()


# -- motions and zones


@pytest.mark.parametrize(("r", "clearance", "walls"), [
    (0.94, 37.0, (0.75, 0.75)), (1.04, 25.0, (0.75, 0.75)), (0.9, 6.0, (0.75, 0.61)),
    (1.1, 9.0, (0.6, 0.6))])  # fmt: skip
def test_definitions_give_the_same_bits(r, clearance, walls):
    """Recomputing each displayed motion from its definition gives the same bits; all motions of `find` appear."""
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=walls)
    found = vi.find(osc, r, clearance)
    shown = fuller(osc, r, clearance, quick(osc, r, clearance))
    assert all(any(same_motion(motion, item.motion) for item in shown) for motion in found)
    assert len(shown) >= len(found) > 0
    for item in shown:
        again = Definition.read(item.definition.text).solve(osc, r, clearance)
        assert again.X.tolist() == item.motion.X.tolist()
        assert again.multipliers.tolist() == item.motion.multipliers.tolist()
    stable = [item.motion.stable for item in shown]
    assert stable == sorted(stable, reverse=True)


@pytest.mark.slow
def test_zones_tell_of_their_motions():
    """At each point in a zone the quick search finds a stable motion of the zone's pattern."""
    osc, window = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75), ((0.8, 1.2), (2.0, 200.0))
    named = list(families(osc, State().patterns))
    zones = [compute(osc, family, window, FINE) for family in named]
    checked = set()
    for r, clearance in (
        np.random.default_rng(5).uniform((0.82, 1.1), (1.18, 4.5), (60, 2)).tolist()
    ):
        inside = [z for z in zones if z.contains(r, np.exp(clearance))]
        shown = quick(osc, r, float(np.exp(clearance)), inside)
        for zone in inside:
            stable = [i for i in shown if i.motion.stable and i.motion.pattern == zone.pattern]
            assert stable, (r, clearance, zone)
            checked.add((zone.pattern.sides, zone.symmetric))
    assert len(checked) >= 4


def test_a_chosen_motion_is_followed():
    """Along a path through the plane the chosen motion is the one that a branch follows."""
    explorer = Explorer(State(r=0.94, clearance=37.0, xi=0.005, mu=0.042))
    labels = [item.label for item in explorer.shown]
    explorer.choose(labels.index("2/1 RL"))
    start = explorer.chosen.motion
    for _ in range(5):
        explorer.step(0, -0.004)
    path = vi.branch(start, "clearance", bounds=(explorer.state.clearance, 37.0))
    end = (
        path.special_points[0].motion if path.clearance[0] < 37 else path.special_points[-1].motion
    )
    assert same_motion(explorer.chosen.motion, end)


def test_a_motion_that_has_gone_is_not_chosen():
    """A click on a motion of an earlier point, which does not exist at this point, chooses no motion."""
    message = []
    session = Session("", lambda text, _: message.append(json.loads(text)), lambda work: work())
    before = session.explorer.state
    gone = {"kind": "choose", "number": 1, "motion": "RLL/1/phases/0.0,2.0,4.0"}
    session.heard(gone)
    assert (message[-1]["fault"], session.explorer.state) == ("", before)
    last = message[-1]["table"][-1]["definition"]
    session.heard(gone | {"number": 2, "motion": last})
    assert session.explorer.state == replace(before, motion=Definition.read(last))
    assert [row["chosen"] for row in message[-1]["table"]][-1]


@pytest.mark.parametrize(
    ("name", "text"), [("z_dot", "abc"), ("x", "1,5"), ("t", ""), ("cycles", "1e400")]
)
def test_a_field_of_a_run_that_is_no_number_is_named(name, text):
    """The message has the field and its text, even with a comma in it; no simulation runs."""
    message = []
    session = Session("", lambda text, _: message.append(json.loads(text)), lambda work: work())
    session.heard(
        {"kind": "run", "number": 1, "words": dict.fromkeys(vars(RUN), "1") | {name: text}}
    )
    assert message[-1]["fault"] == f"{name} = {text!r}: must be a finite number"
    assert session.explorer.state == State()


def test_a_run_settles_on_a_motion_of_the_table():
    """A run names its stable motion as the table does, whichever impact comes first."""
    explorer = Explorer(State(R2=0.61, r=0.9, clearance=30.0))
    for discard in (0.0, 0.4, 0.8):
        run = explorer.let_run(replace(explorer.start(), discard=200.0 + discard))
        stable = [item.label.partition(",")[0] for item in explorer.shown if item.motion.stable]
        assert settles_on(run).removeprefix("settles on ") in stable


def test_coarse_zones_are_nearly_the_fine_ones():
    """Coarse and fine zones with loops have nearly equal areas; the outline has the area of the zone."""
    state = State()
    for family in families(state.osc, state.patterns):
        coarse, fine = (compute(state.osc, family, state.window, n) for n in (COARSE, FINE))
        if len(coarse.loops) == len(fine.loops):
            assert coarse.area == pytest.approx(fine.area, rel=1e-3)
        drawn = [thinned(ring, state.window) for ring in fine.loops]
        area = sum(signed_area(np.c_[ring[:, 0], np.log(ring[:, 1])]) for ring in drawn)
        assert area == pytest.approx(fine.area, rel=2e-2)
        assert sum(map(len, drawn)) < 0.2 * sum(map(len, fine.loops))


def test_holes_stay_empty():
    """A ring of the opposite orientation is a hole of the ring around it."""
    angle = np.linspace(0, 2 * np.pi, 200)
    ring = np.c_[1 + 0.1 * np.cos(angle), 20 * np.exp(np.sin(angle))]
    hole = np.c_[1 + 0.05 * np.cos(-angle), 20 * np.exp(0.5 * np.sin(-angle))]
    family = next(families(State().osc, State().patterns))
    zone = compute(State().osc, family, State().window, COARSE)
    vars(zone).update(loops=[hole, ring], boundary=[])
    ((xs,),) = zone_shapes({family: zone})["fills"]["xs"]
    assert [len(part) for part in xs] == [
        len(thinned(item, State().window)) for item in (ring, hole)
    ]


def test_what_is_known_is_kept():
    """At the same point known motions are kept; at a neighbouring point they are continued."""
    explorer = Explorer(State())
    explorer.learn(fuller(explorer.state.osc, 1.04, 25.0, explorer.shown))
    before = explorer.shown
    explorer.look()
    assert [item.definition for item in explorer.shown] == [item.definition for item in before]
    explorer.move(1.0401, 25.0)
    assert {item.label for item in before} <= {item.label for item in explorer.shown}


def test_lines_snap_and_are_clipped():
    """A line nearly parallel to an axis is made parallel; a line that leaves the window ends at its edge."""
    explorer = Explorer(State())
    explorer.draw_line((0.9, 10.0, 1.1, 10.1))
    assert explorer.state.line == (0.9, 10.0, 1.1, 10.0)
    explorer.draw_line((0.9, 500.0, 0.901, 0.1))
    assert explorer.state.line == (0.9, 200.0, 0.9, 2.0)
    with pytest.raises(ParameterError, match="longer"):
        explorer.draw_line((0.9, 10.0, 0.905, 10.0))


def test_a_line_across_the_plane_is_the_same_both_ways():
    """A sweep of r along a line in the plane is the sweep of the clearance along the same line."""
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    r, clearance = np.linspace(1.0, 1.1, 21), np.geomspace(20, 60, 21)
    one = vi.bifurcation_diagram(osc, "r", r, clearance=clearance)
    other = vi.bifurcation_diagram(osc, "clearance", clearance, r=r)
    assert one.points.tolist() == other.points.tolist()
    assert one.labels.tolist() == other.labels.tolist()
    np.testing.assert_array_equal(one.to_xarray()["clearance_along"], clearance)
    np.testing.assert_array_equal(other.to_xarray()["r_along"], r)
    flat = vi.bifurcation_diagram(osc, "r", r, clearance=np.full(21, 30.0))
    assert (
        flat.points.tolist() == vi.bifurcation_diagram(osc, "r", r, clearance=30.0).points.tolist()
    )
    for wrong in ([30.0] * 3, clearance[::-1] * np.nan):
        with pytest.raises(ParameterError, match="clearance"):
            vi.bifurcation_diagram(osc, "r", r, clearance=wrong)
    with pytest.raises(ParameterError, match="ascending"):
        vi.bifurcation_diagram(osc, "r", r[::-1], clearance=clearance)


# -- the command


def test_bad_options_are_named(capsys):
    """A network address, a port in use and an invalid port give status 2 and one line."""
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        # the last address is reserved for documentation, so no machine has it
        for words in (
            ["--port", port], ["--port", "70000"], ["--address", "0.0.0.0"], ["--address", "192.0.2.1"]
        ):  # fmt: skip
            status = main(["explore", "--no-browser", *words])
            out, err = capsys.readouterr()
            assert (status, out, err.count("\n")) == (2, "", 1)
            assert f"{words[0]} " in err
            assert words[1] in err


def test_missing_extra(monkeypatch):
    """Without panel one line names the package to install."""
    monkeypatch.setitem(sys.modules, "panel", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'vibroimpact\[explorer\]'"):
        panel()


ENDS = """
import threading
from vibroimpact.explorer import background
from vibroimpact.explorer.latest import Latest

def job(current):
    begun.set()
    while current():
        pass
    print("ends by itself", flush=True)
    raise RuntimeError

begun = threading.Event()
worker = Latest(print)
worker.submit(job)
begun.wait()
worker.submit(lambda current: print("never"))
worker.drop()
begun.clear()
worker.submit(job)
begun.wait()
# a search that waits for zones that never come
background.PATIENCE = 10**6
behind = background.Background(print, print)
behind.motions(None, None, None)
"""


def test_threads_end_before_the_interpreter():
    """At exit threads are stopped and joined: a thread still in C++ would abort the process."""
    done = subprocess.run(
        [sys.executable, "-c", ENDS], capture_output=True, text=True, timeout=100, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "ends by itself\n" * 2, "")


@pytest.mark.slow
def test_interrupt_ends_it():
    """Ctrl-C ends the explorer with status 0 and an empty stderr; it listens on loopback only.

    It is started by the example of the help, except for the port.
    """
    assert EXAMPLE.split()[:4] == ["vibroimpact", "explore", "--port", "5006"]
    process, url = start(*EXAMPLE.split()[4:])
    assert url.startswith("http://127.0.0.1:")
    port = int(url.rstrip("/").rsplit(":", 1)[1])
    if Path("/proc/net/tcp").exists():
        listening = [row.split() for row in Path("/proc/net/tcp").read_text().splitlines()[1:]]
        places = [row[1] for row in listening if row[3] == "0A" and row[1].endswith(f":{port:04X}")]
        assert places == [f"0100007F:{port:04X}"]
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=20)
    assert (process.returncode, out, err) == (0, "ended\n", "")


OPEN = """
import vibroimpact as vi
from vibroimpact.explorer import words
from vibroimpact.explorer.explorer import Explorer
from vibroimpact.explorer.state import State
from vibroimpact.explorer.zones import families
state = State()
family = next(iter(families(state.osc, state.patterns)))
zone = vi.zone(state.osc, vi.Pattern("RL"), (0.8, 1.2), (2, 200), max_points=100)
explorer = Explorer(state)
explorer.zones = {family: zone}
explorer.look()
undecided = int(zone.undecided(state.r, state.clearance))
print(family.name, zone.closed, undecided, words.open_zones(explorer.zones), sep="|")
"""


def test_an_open_boundary_is_reported_on_the_page_alone():
    """The page names the zone; the terminal of the server gets no OpenBoundaryWarning."""
    done = subprocess.run(
        [sys.executable, "-c", OPEN], capture_output=True, text=True, check=True, timeout=300
    )
    name, closed, undecided, text = done.stdout.strip().split("|")
    assert (closed, undecided) == ("False", "1")
    assert text == f"{name}: a boundary could not be closed"
    assert done.stderr == ""
