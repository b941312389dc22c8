"""Invalid arguments of `simulate` are reported with their values and the allowed values."""

import math

import pytest
import vibroimpact as vi
from shared_simulations import STATE, state
from shared_systems import RIG

NAN, INF = math.nan, math.inf
GOOD = {"osc": RIG, "r": 0.9, "clearance": 6.0, "cycles": 2}


def assert_refused(changes, *words, kind=(ValueError, TypeError)):
    """Assert that a call is refused with a message that has these words."""
    with pytest.raises(kind) as caught:
        vi.simulate(**GOOD | changes)
    assert isinstance(caught.value, vi.errors.VibroimpactError)
    for word in (*words, "must"):
        assert word in str(caught.value), str(caught.value)


@pytest.mark.parametrize("value", [NAN, INF, -INF, -1.0, 0.0, 1e7])
def test_frequency_values(value):
    """r is positive and finite."""
    assert_refused({"r": value}, "r = ", str(value), kind=ValueError)


@pytest.mark.parametrize("name", ["clearance", "load", "cycles", "discard"])
@pytest.mark.parametrize("value", [NAN, INF, -1.0, 1e13])
def test_values_of_lengths_and_cycles(name, value):
    """Negative and infinite values are refused; the message uses the name that the caller typed."""
    assert_refused({name: value}, f"{name} = {value}", f"<= {name} <=", kind=ValueError)


def test_a_time_in_place_of_cycles():
    """The message says that load cycles are counted."""
    for name in ("cycles", "discard"):
        wanted = f"must be a number of load cycles with 0 <= {name} <= 1e+09"
        assert_refused({name: "1 s"}, f"{name} = '1 s'", wanted, kind=TypeError)


@pytest.mark.parametrize("name", [*GOOD, "load", "discard", "max_events"])
@pytest.mark.parametrize("value", ["1", None, 1j, [1.0], b"1", True])
def test_types(name, value):
    """Arguments that are not numbers, including bools, are refused."""
    assert_refused({name: value}, name, repr(value), kind=TypeError)


@pytest.mark.parametrize("value", [0, -3, 10**10, 2.5])
def test_max_events_values(value):
    """`max_events` must be a whole number from 1."""
    assert_refused({"max_events": value}, "max_events", str(value), kind=ValueError)


def test_zero_clearance_and_undamped_resonance():
    """A clearance of 0, and r = 1 without damping, are refused."""
    assert_refused({"clearance": 0.0}, "clearance", "0.0", kind=ValueError)
    assert_refused(
        {"osc": vi.Oscillator(xi=0.0, mu=0.1, restitution=0.5), "r": 1.0},
        "r = 1.0",
        kind=ValueError,
    )


@pytest.mark.parametrize("name", STATE)
@pytest.mark.parametrize("value", [NAN, INF, 1.1e100, -1e250, "0", None, 1j])
def test_state_values(name, value):
    """Each number of a state must be real and at most 1e100 in size."""
    assert_refused({"state": state() | {name: value}}, name, repr(value))


@pytest.mark.parametrize("bad", [3, [0.0] * 5, "rest", (1, 2)])
def test_state_types(bad):
    """A state must be a mapping."""
    assert_refused({"state": bad}, "state", repr(bad), kind=TypeError)


def test_state_keys():
    """Omitted keys are 0; unknown keys are named, and so are those that a final state lacks."""
    assert_refused({"state": state() | {"y": 1.0}}, "'y'", kind=ValueError)
    assert_refused({"state": {}}, "state", "x_dot", kind=ValueError)


@pytest.mark.parametrize("z", [3.1, -3.1, 1e9])
def test_state_outside_the_walls(z):
    """The free mass must start between the walls."""
    assert_refused({"state": state(z=z)}, "z", f"{z!r}", "3", kind=ValueError)


@pytest.mark.parametrize(("name", "value"), [
    ("cycle", 1e300), ("cycle", 0.5), ("phase", -1.0), ("phase", 1e9), ("side", 7),
    ("resting", 3.7), ("released", -2), ("speed", -1.0),
])  # fmt: skip
def test_a_final_state_that_was_tampered_with(name, value):
    """The additional entries of a final state are checked like the others."""
    end = vi.simulate(RIG, 0.9, 6.0, 2).final_state
    assert_refused({"state": end | {name: value}}, name, kind=ValueError)


def test_time_of_a_final_state_that_was_changed():
    """A new t in a final state is not silently ignored: it is used, or refused."""
    end = vi.simulate(RIG, 0.9, 6.0, 2.3).final_state
    try:
        run = vi.simulate(RIG, 0.9, 6.0, 1, state=end | {"t": 1.5})
    except vi.errors.ParameterError:
        return
    assert run.initial_state["t"] == pytest.approx(1.5)
