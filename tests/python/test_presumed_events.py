"""`periodic` of structures with stops and friction: for given times of all events, the rest is linear."""

import numpy as np
import pytest
import vibroimpact as vi
from shared_structures import one_stop, with_elements
from test_elements_audit import of_all_kinds

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


@pytest.mark.parametrize("number", [364, 424, 501])
def test_stops_that_impacts_change(number):
    """An impact that makes a stop let go or press at its instant is followed by that change, with no equation."""
    structure, load = of_all_kinds(np.random.default_rng([1, number]))
    motion = vi.exact(structure, load, vi.simulate(structure, load, cycles=600, discard=500))
    follows = np.isin(motion.kinds[1:], ["let_go", "press"]) & (np.diff(motion.phases) == 0)
    assert follows.any()
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
    ({"kinds": ["touch", "touch"]}, "number 1 is impossible for element 0 after the events before it"),
    ({"kinds": ["halt", "slip_up"]}, "number 1 is impossible for element 0"),
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
