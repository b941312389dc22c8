"""`periodic` of structures with stops, friction and rests: for given times of all events, the rest is linear."""

import numpy as np
import pytest
import vibroimpact as vi
from shared_structures import one_stop, with_elements, written
from test_elements_audit import of_all_kinds, with_stops_that_impacts_change

CASES = with_elements()


def motion_with_kinds(name):
    """The motion on which a simulation settles, and the kinds of its events."""
    structure, load = CASES[name]
    motion = vi.exact(structure, load, vi.simulate(structure, load, cycles=500))
    run = motion._from_flight()
    since = np.mod(motion.phases - run.start * load.frequency, 2 * np.pi * motion.cycles)
    kinds = np.empty(len(since), "U9")
    kinds[np.argsort(since, kind="stable")] = run.events["kind"]
    return motion, kinds.tolist()


@pytest.mark.parametrize("name", CASES)
def test_the_events_of_a_motion_give_it_again(name):
    """The residual is rounding; states, speeds and multipliers are those of Newton's method."""
    motion, kinds = motion_with_kinds(name)
    given = (motion.structure, motion.load, motion.phases, motion.gaps, motion.cycles)
    found = vi.periodic(*given, kinds=kinds)
    assert found.residual < 1e-14
    assert found.admissible
    assert found.stable
    assert found.phases == pytest.approx(motion.phases, abs=1e-14)
    size = np.abs(motion.states).max()
    assert np.abs(found.states - motion.states).max() < 1e-11 * size
    assert np.abs(found.speeds - motion.speeds).max() < 1e-11 * size
    assert found.multipliers == pytest.approx(motion.multipliers, abs=1e-10)
    assert found.determinant == pytest.approx(motion.law, rel=1e-9, abs=1e-12)


def with_rests():
    """Structures with gaps that rest after impacts with zero restitution, and their loads."""
    push, slow = vi.Load(0.8, cosine=[1]), vi.Load(0.6, cosine=[1, 0.4], constant=[0.3, 0])
    gap, chain = vi.Gap([1], 0.3, 0.0), np.array([[2.0, -1.0], [-1.0, 2.0]])
    two = ([1, 1], 0.05 * chain, chain)
    walls = [vi.Gap([1], 0.3, 0.0, cosine=0.05, sine=0.03), vi.Stop([-1], 0.4, 20, sine=0.02)]
    soft = vi.Stop([0, 1], 0.3, 10, 0.5, release="force")
    slot = [[0.1, 0], [0, 0.02]], [[1.2, -0.2], [-0.2, 0.2]]
    between = vi.Gap([-1, 1], 0.5, 0.0)
    return {
        "a gap alone": (vi.Structure([1], [0.1], [1], [gap]), push),
        "a stop": (vi.Structure([1], [0.1], [1], [gap, vi.Stop([-1], 0.4, 20)]), push),
        "friction along it": (vi.Structure([1], [0.1], [1], [gap], [vi.Friction([-1], 0.2, 0.3)]), push),
        "moving walls": (vi.Structure([1], [0.1], [1], walls), push),
        "events during it": (
            vi.Structure(*two, [vi.Gap([1, 0], 0.3, 0.0), soft], [vi.Friction([0, 1], 0.1)]), slow
        ),
        "two impacts": (
            vi.Structure(*two, [vi.Gap([1, 0], 0.3, 0.0)], [vi.Friction([0, 1], 0.3)]),
            vi.Load(0.6, cosine=[1, 0.4]),
        ),
        "a reversal that releases it": (
            vi.Structure(*two, [vi.Gap([1, -1], 0.2, 0.0)], [vi.Friction([0, 1], 0.15)]),
            vi.Load(0.7, cosine=[1, 0.3]),
        ),
        "friction in a slot": (
            vi.Structure([1, 0.3], *slot, [between], [vi.Friction([-1, 1], 0.02)]), vi.Load(0.8, sine=[1, 0])
        ),
    }  # fmt: skip


RESTS = with_rests()


@pytest.mark.parametrize("name", RESTS)
def test_rests_from_the_instants_of_all_events(name):
    """With the beginning and the end of rests the problem is linear, too, from whichever event it is written."""
    structure, load = RESTS[name]
    motion = vi.exact(structure, load, vi.simulate(structure, load, cycles=400))
    events = motion._from_flight().events
    turn, times = 2 * np.pi * motion.cycles, events["time"] * load.frequency
    assert len(motion.rests) == 1
    for first in np.flatnonzero(np.diff(times, prepend=-1.0)).tolist():
        order = np.r_[first : len(events), :first]
        phases = times[order] + turn * (order < first)
        given = (structure, load, phases, events["gap"][order], motion.cycles)
        found = vi.periodic(*given, kinds=events["kind"][order].tolist())
        assert found.residual < 1e-13
        assert found.admissible
        assert found.stable
        sums = [[np.sum(m.multipliers**k) for k in range(1, 5)] for m in (found, motion)]
        assert sums[0] == pytest.approx(sums[1], abs=1e-10)
        assert found.determinant == pytest.approx(0, abs=1e-12)
        apart = np.mod(found.rests["begin"] - motion.rests["begin"] + 0.5 * turn, turn) - 0.5 * turn
        assert apart == pytest.approx(0, abs=1e-12)
        assert np.diff(found.rests[["begin", "end"]].tolist()) == pytest.approx(
            np.diff(motion.rests[["begin", "end"]].tolist()), abs=1e-12
        )
        order = np.argsort(np.mod(found.phases - motion.phases[0] + 1e-9, turn), kind="stable")
        assert found.gaps[order].tolist() == motion.gaps.tolist()
        assert np.array(found.kinds)[order].tolist() == list(motion.kinds)
        assert np.abs(found.states[order] - motion.states).max() < 1e-11
        assert found.speeds[order] == pytest.approx(motion.speeds, abs=1e-11)
    again = vi.exact(structure, load, found)
    assert np.sort(again.speeds) == pytest.approx(np.sort(motion.speeds), abs=1e-11)


def test_a_rest_that_ends_elsewhere_is_not_one_of_a_motion(tmp_path):
    """The force of the wall is not 0 at a wrong instant; the namelist of a right one gives the motion again."""
    structure, load = RESTS["a stop"]
    motion = vi.exact(structure, load, vi.simulate(structure, load, cycles=400))
    events = motion._from_flight().events
    given = {"gaps": events["gap"], "kinds": events["kind"].tolist()}
    phases = events["time"] * load.frequency
    later = phases + 1e-3 * (events["kind"] == "release")
    found = vi.periodic(structure, load, later, **given)
    assert found.consistent is False
    assert found.residual > 1e-5
    again = vi.exact(structure, load, found)
    assert np.sort(again.speeds) == pytest.approx(np.sort(motion.speeds), abs=1e-11)
    found = vi.periodic(structure, load, phases, **given)
    (case,) = written(tmp_path, found.to_namelist())
    (same,) = case.run()
    assert np.array_equal(same.states, found.states)
    assert same.rests.tolist() == found.rests.tolist()


@pytest.mark.parametrize(("restitution", "kinds", "phases", "message"), [
    (0.5, ["impact", "stick", "release"], [1, 1, 2], "gap 0, whose restitution is above 0: infinitely many"),
    (0.0, ["impact", "release"], [1, 2], "number 2 cannot occur at element 0"),
    (0.0, ["impact", "stick"], [1, 1], "number 1 cannot occur at element 0"),
    (0.0, ["impact", "stick", "release"], [1, 1.5, 2], "number 2 cannot occur at element 0"),
    (0.0, ["impact", "stick", "impact", "release"], [1, 1, 1.5, 2], "number 3 cannot occur at element 0"),
    (0.0, ["impact", "impact"], [1, 1], "must differ for impacts on the same gap"),
])  # fmt: skip
def test_rests_that_are_refused(restitution, kinds, phases, message):
    structure = vi.Structure([1.0], [0.1], [1.0], gaps=[vi.Gap([1], 0.3, restitution)])
    with pytest.raises(vi.ParameterError, match=message):
        vi.periodic(structure, vi.Load(0.8, cosine=[1]), phases, [0] * len(kinds), kinds=kinds)


@pytest.mark.parametrize("number", [364, 424, 501])
def test_stops_that_impacts_change(number):
    """An impact that makes a stop let go or press at its instant is followed by that change, with no equation."""
    structure, load, motion, _ = with_stops_that_impacts_change(number)
    given = (structure, load, motion.phases, motion.gaps, motion.cycles)
    found = vi.periodic(*given, kinds=motion.kinds)
    assert found.residual < 1e-13
    assert found.admissible
    assert np.abs(found.states - motion.states).max() < 1e-11
    assert found.speeds == pytest.approx(motion.speeds, abs=1e-11)
    assert found.determinant == pytest.approx(motion.determinant, rel=1e-8, abs=1e-12)
    sums = [[np.sum(m.multipliers**k) for k in range(1, 5)] for m in (found, motion)]
    assert sums[0] == pytest.approx(sums[1], abs=1e-9)


def test_branch_of_a_motion_whose_stop_an_impact_changes():
    """Points of a branch are the motions on which simulations settle there, with the same kinds of events."""
    structure, load = of_all_kinds(np.random.default_rng([1, 501]))
    motion = vi.exact(structure, load, vi.simulate(structure, load, cycles=600, discard=500))
    branch = vi.branch(motion, "load", (0.97, 1.03))
    for i in (0, len(branch) - 1):
        point = branch[i]
        start = float(point.phases[0] / load.frequency)
        run = vi.simulate(
            structure, point.load, cycles=300, state=(point.q, point.q_dot), start=start
        )
        settled = vi.exact(structure, point.load, run)
        assert settled.kinds == point.kinds
        assert settled.speeds == pytest.approx(point.speeds, abs=1e-11)
        assert settled.stable
        assert point.stable


def test_a_halt_that_makes_other_friction_slip():
    """Where a halt changes the force on friction that sticks, and it slips at once, its slip has no equation."""
    stiffness = np.array([[2.0, -1.0], [-1.0, 2.0]])
    rubbing = [vi.Friction([1, 0], 0.51, 0.663), vi.Friction([1, -1], 0.19, 0.247)]
    structure = vi.Structure([1, 1], 0.05 * stiffness, stiffness, friction=rubbing)
    load = vi.Load(0.7, cosine=[1, 0.5])
    motion = vi.exact(structure, load, vi.simulate(structure, load, cycles=100))
    events = motion._from_flight().events
    at_once = events["kind"][np.flatnonzero(np.diff(events["time"]) == 0)]
    assert set(at_once.tolist()) == {"halt"}
    phases = events["time"] * load.frequency
    found = vi.periodic(structure, load, phases, events["gap"], kinds=events["kind"].tolist())
    assert found.residual < 1e-13
    assert found.admissible
    sums = [[np.sum(m.multipliers**k) for k in range(1, 5)] for m in (found, motion)]
    assert sums[0] == pytest.approx(sums[1], abs=1e-10)


def test_periods_of_several_cycles():
    """A motion of two load cycles is admissible, whichever cycle its longest flight begins in."""
    parts = [vi.Stop([1], 0.5, 20, 1.0, preload=0.3, release="force"), vi.Gap([-1], 1.5, 0.7)]
    structure, load = vi.Structure([1], [0.1], [1], parts), vi.Load(1.3, cosine=[1.0])
    motion = vi.exact(structure, load, vi.simulate(structure, load, cycles=300))
    assert motion.cycles == 2
    for first in range(len(motion.phases)):
        phases = motion.phases[first:], motion.phases[:first] + 4 * np.pi
        kinds = [*motion.kinds[first:], *motion.kinds[:first]]
        given = (structure, load, np.concatenate(phases), np.roll(motion.gaps, -first), 2)
        found = vi.periodic(*given, kinds=kinds)
        assert found.residual < 1e-14
        assert found.admissible
        assert found.stable


@pytest.mark.parametrize("name", ["stop", "reversals", "stick"])
def test_other_instants_are_not_a_motion(name):
    """The residual grows in proportion to the error of the times; `exact` recovers the motion."""
    motion, kinds = motion_with_kinds(name)
    residuals = []
    for shift in (1e-5, 1e-4):
        phases = motion.phases + shift * np.cos(np.arange(len(kinds)))
        given = (motion.structure, motion.load, phases, motion.gaps, motion.cycles)
        found = vi.periodic(*given, kinds=kinds)
        assert found.consistent is False
        assert found.stable is None
        residuals.append(found.residual)
    assert residuals[1] / residuals[0] == pytest.approx(10, rel=0.05)
    again = vi.exact(motion.structure, motion.load, found)
    assert again.speeds == pytest.approx(motion.speeds, abs=1e-10)


def test_a_motion_that_passes_through_a_wall_is_not_admissible():
    """The linear equations do not account for a second stop that the motion would touch."""
    motion, kinds = motion_with_kinds("stop")
    lowest = float(motion.sample(np.linspace(0, motion.period, 200))[0].min())
    further = vi.Stop([-1], -0.9 * lowest, stiffness=10)
    structure = vi.Structure([1.0], [0.1], [1.0], gaps=[motion.structure.gaps[0], further])
    found = vi.periodic(structure, motion.load, motion.phases, motion.gaps, kinds=kinds)
    assert found.consistent
    assert found.admissible is False


def test_namelist(tmp_path):
    """A namelist reproduces the motion, from its phases, and exactly from a guess of them."""
    motion, kinds = motion_with_kinds("force")
    phases = np.round(motion.phases, 3)
    found = vi.periodic(motion.structure, motion.load, phases, motion.gaps, kinds=kinds)
    case = tmp_path / "given.nml"
    case.write_text(found.to_namelist())
    assert "kinds = 'touch', 'let_go', 'leave'" in case.read_text()
    again = vi.read_namelist(case)[0].run()[0]
    assert np.array_equal(again.states, found.states)
    case.write_text(found.to_namelist().replace("'periodic'", "'exact'"))
    exact = vi.read_namelist(case)[0].run()[0]
    assert exact.speeds == pytest.approx(motion.speeds, abs=1e-11)


@pytest.mark.parametrize(("change", "message"), [
    ({"kinds": None}, "kinds = None: must be one of impact"),
    ({"kinds": ["touch"]}, "kinds"),
    ({"kinds": ["touch", "touch"]}, "number 1 cannot occur at element 0 after the preceding events"),
    ({"kinds": ["halt", "slip_up"]}, "number 1 cannot occur at element 0"),
    ({"kinds": ["touch", "sit"]}, "kinds"),
    ({"phases": [0.1, 0.1]}, "must differ for impacts on the same gap"),
    ({"gaps": [0, 1]}, "each below 1"),
    ({"full": True}, "full = True: must be left out"),
])  # fmt: skip
def test_what_is_refused(change, message):
    structure, load = CASES["stop"]
    given = {"phases": [0.1, 0.5], "gaps": [0, 0], "kinds": ["touch", "leave"]} | change
    with pytest.raises(vi.ParameterError, match=message):
        vi.periodic(structure, load, **given)


def test_friction_without_events():
    """Friction without events needs a belt; a fast belt only adds a constant force."""
    stop = one_stop(1.0, stiffness=100, damping=1).gaps
    load = vi.Load(1.0, cosine=[1.0])
    still = vi.Structure([1.0], [0.1], [1.0], gaps=stop, friction=[vi.Friction([1.0], 0.1)])
    with pytest.raises(
        vi.ParameterError, match="element 1 is friction without a belt and must have an event"
    ):
        vi.periodic(still, load, [0.1, 0.5], [0, 0], kinds=["touch", "leave"])
    fast = vi.Structure([1.0], [0.1], [1.0], gaps=stop, friction=[vi.Friction([1.0], 0.1, speed=9)])
    motion = vi.exact(fast, load, vi.simulate(fast, load, cycles=300))
    found = vi.periodic(fast, load, motion.phases, motion.gaps, kinds=["touch", "leave"])
    plain = vi.Structure([1.0], [0.1], [1.0], gaps=stop)
    pushed = vi.periodic(
        plain, vi.Load(1.0, cosine=[1.0], constant=[0.1]), motion.phases, [0, 0], kinds=["touch", "leave"]
    )  # fmt: skip
    assert found.residual < 1e-14
    assert found.speeds == pytest.approx(pushed.speeds, rel=1e-12)


def test_a_rigid_structure_has_impacts_alone():
    structure = vi.Structure([1.0], [0.1], [1.0], gaps=[vi.Gap([1], 0.5, 0.8)])
    with pytest.raises(vi.ParameterError, match="all events are impacts"):
        vi.periodic(structure, vi.Load(1.0, cosine=[1.0]), [0.1], [0], kinds=["impact"])
