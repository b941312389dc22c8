"""Derivatives of motions and trajectories of structures with stops and friction, compared with differences."""

from dataclasses import replace

import numpy as np
import pytest
import vibroimpact as vi
from shared_structures import with_elements
from test_elements_audit import with_stops_that_impacts_change

CASES = with_elements()
QUANTITIES = ("phases", "speeds", "impulses", "q", "q_dot")


def changed(structure, load, name, step):
    """A structure and its load after a step of a parameter."""
    word, *numbers = name.split("_")
    parts = list(structure._parts)
    if word in ("frequency", "load"):
        more = step if word == "frequency" else 0.0
        factor = 1.0 if word == "frequency" else 1 + step
        return structure, vi.Load(
            load.frequency + more, sine=factor * load.sine, cosine=factor * load.cosine
        )
    j = int(numbers[0])
    if word == "slip":
        slip = parts[j].slip + step
        parts[j] = replace(parts[j], slip=slip, stick=parts[j].stick * slip / parts[j].slip)
    else:
        field = {"contact": "stiffness"}.get(word, word)
        parts[j] = replace(parts[j], **{field: getattr(parts[j], field) + step})
    gaps, friction = parts[: len(structure.gaps)], parts[len(structure.gaps) :]
    matrices = (structure.mass, structure.damping, structure.stiffness)
    return vi.Structure(*matrices, gaps, friction), load


def settled(structure, load):
    return vi.exact(structure, load, vi.simulate(structure, load, cycles=500))


def rows(motion, like):
    """The quantities of the events of a motion, starting at the event that is first in another motion."""
    whole = 2 * np.pi * like.cycles
    apart = [
        np.mod(np.roll(motion.phases, -k) - like.phases + whole / 2, whole) - whole / 2
        for k in range(len(like.phases))
    ]
    k = min(range(len(apart)), key=lambda i: np.abs(apart[i]).max())
    states = np.roll(motion.states, -k, axis=0)
    return {
        "phases": like.phases + apart[k], "speeds": np.roll(motion.speeds, -k),
        "impulses": np.roll(motion.impulses, -k), "q": states[:, 0], "q_dot": states[:, 1],
    }  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_motion_against_differences_of_exact(name):
    motion = settled(*CASES[name])
    gradient = motion.gradient()
    assert set(gradient.parameters) >= {"frequency", "load"}
    step = 1e-5
    for parameter in gradient.parameters:
        ends = [
            vi.exact(*changed(*CASES[name], parameter, sign * step), motion) for sign in (1, -1)
        ]
        up, down = (rows(end, motion) for end in ends)
        for quantity in QUANTITIES:
            slope = (up[quantity] - down[quantity]) / (2 * step)
            apart = np.abs(gradient[quantity, parameter] - slope).max()
            assert apart < 2e-6 * max(1, np.abs(slope).max()), (parameter, quantity)
        largest = [np.abs(end.multipliers).max() for end in ends]
        slope = (largest[1] - largest[0]) / (2 * step)
        assert gradient["stability_margin", parameter] == pytest.approx(slope, rel=1e-5, abs=1e-5)


@pytest.mark.parametrize("name", CASES)
def test_trajectory_against_differences(name):
    structure, load = CASES[name]
    n = structure.coordinates
    start = np.array([np.full(n, 0.1), 0.23 * (1 + np.arange(n))])

    def end(parameter, step):
        state = start.copy()
        if parameter.startswith("q"):
            state[int(parameter.startswith("q_dot")), int(parameter[-1])] += step
            return np.ravel(vi.simulate(structure, load, cycles=3, state=state).final_state)
        run = vi.simulate(*changed(structure, load, parameter, step), cycles=3, state=start)
        return np.ravel(run.final_state)

    run = vi.simulate(structure, load, cycles=3, state=start)
    gradient = run.gradient()
    assert not gradient.status
    step = 1e-6
    for parameter in gradient.parameters:
        if parameter == "start":
            continue
        slope = (end(parameter, step) - end(parameter, -step)) / (2 * step)
        own = np.append(gradient["final_q", parameter], gradient["final_q_dot", parameter])
        assert np.abs(own - slope).max() < 1e-6 * max(1, np.abs(slope).max()), parameter


def test_numbers_by_a_function():
    """Through a function, any number of an element is a parameter: a dashpot, a preload, the speed of a belt."""
    load = vi.Load(1.3, cosine=[1.0])

    def system(c=2.0, preload=0.1, speed=0.3):
        stop = vi.Stop([1], 0.5, stiffness=20, damping=c, preload=preload)
        belt = vi.Friction([1], slip=0.1, stick=0.15, speed=speed)
        return vi.Structure([1.0], [0.1], [1.0], [stop], [belt]), load

    motion = settled(*system())
    wanted = [
        ("c", lambda c: system(c=c), 2.0), ("preload", lambda p: system(preload=p), 0.1),
        ("speed", lambda v: system(speed=v), 0.3), "contact", "slip",
    ]  # fmt: skip
    gradient = motion.gradient(wanted)
    for name, function, value in wanted[:3]:
        up, down = (rows(vi.exact(*function(value + h), motion), motion) for h in (1e-6, -1e-6))
        for quantity in QUANTITIES:
            slope = (up[quantity] - down[quantity]) / 2e-6
            assert gradient[quantity, name] == pytest.approx(slope, abs=1e-6), (name, quantity)
    assert np.array_equal(
        gradient["q", "contact"], motion.gradient(["contact_0"])["q", "contact_0"]
    )


def test_what_has_no_derivative():
    """Friction that sticks at the start keeps its speed; the frequency of a self-excited motion is a result."""
    structure, load = CASES["stick"]
    run = vi.simulate(structure, load, cycles=2, state=([0.1], [0.0]))
    gradient = run.gradient(["q_0", "q_dot_0", "slip_0"])
    assert np.isnan(gradient["final_q", "q_dot_0"]).all()
    assert np.isfinite(gradient["final_q", "q_0"]).all()
    assert "friction that sticks would slip" in next(iter(gradient.status.values()))
    belt = vi.Structure([1], [0], [1], friction=[vi.Friction([1], 0.6, stick=1.0, speed=0.2)])
    motion = vi.exact(belt, vi.Load.none(), vi.simulate(belt, duration=100))
    with pytest.raises(vi.ParameterError, match="'frequency' must be left out"):
        motion.gradient(["frequency"])
    with pytest.raises(vi.ParameterError, match="it changes nothing in this structure"):
        settled(structure, load).gradient(["contact"])


@pytest.mark.parametrize("number", [364, 424, 501])
def test_stops_that_impacts_change(number):
    """An impact that makes a stop let go or press moves that change with itself."""
    structure, load, motion, follows = with_stops_that_impacts_change(number)
    gradient = motion.gradient(["frequency"])
    slopes = gradient["phases", "frequency"]
    after = np.flatnonzero(follows)
    assert slopes[after + 1] == pytest.approx(slopes[after], abs=1e-12)
    step = 1e-6
    loads = [changed(structure, load, "frequency", sign * step)[1] for sign in (1, -1)]
    high, low = (vi.exact(structure, other, motion) for other in loads)
    assert slopes == pytest.approx((high.phases - low.phases) / (2 * step), abs=2e-7)
    speeds = (high.speeds - low.speeds) / (2 * step)
    assert gradient["speeds", "frequency"] == pytest.approx(speeds, abs=2e-7)


def test_simultaneous_changes_of_stops_that_are_not_coupled():
    """A stiffness moves only the events of its own stop, also where another stop changes at the same instant."""
    stop = vi.Stop([1], 0.5, 20, 1, release="force")
    alone = settled(vi.Structure([1], [0.1], [1], [stop]), vi.Load(0.8, cosine=[1]))
    stops = [replace(stop, direction=row) for row in np.eye(2)]
    structure = vi.Structure(np.eye(2), 0.1 * np.eye(2), np.eye(2), stops)
    load = vi.Load(0.8, cosine=[1, 1])
    both = vi.exact(structure, load, vi.simulate(structure, load, cycles=200))
    assert np.diff(both.phases)[::2] == pytest.approx(0, abs=1e-12)
    gradient = both.gradient(["contact_0", "contact_1"])
    expected = alone.gradient(["contact"])["phases", "contact"]
    for i in (0, 1):
        slopes = gradient["phases", f"contact_{i}"]
        assert slopes[both.gaps == i] == pytest.approx(expected, abs=1e-12)
        assert slopes[both.gaps != i] == pytest.approx(0, abs=1e-12)
