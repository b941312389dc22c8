"""What a caller can get wrong: every error names the parameter, its value and what is allowed."""

import json
import math
import pickle
import re
from fractions import Fraction

import numpy as np
import pytest
import vibroimpact as vi
from hypothesis import given, settings
from hypothesis import strategies as st

NAN, INF = math.nan, math.inf
OSC = vi.Oscillator(xi=0.01, mu=0.05, restitution=(0.75, 0.61))
EVEN = vi.Oscillator(xi=0.01, mu=0.05, restitution=0.75)
PAIR = vi.Pattern("RL")
PHASES = [0.0, 3.3]
ARRAYS = (
    "restitution",
    "phases",
    "X",
    "Z",
    "X_dot_before",
    "X_dot_after",
    "Z_dot_before",
    "Z_dot_after",
    "multipliers",
)


def oscillator(**changes):
    """Make the oscillator with some parameter wrong."""
    return vi.Oscillator(**{"xi": 0.01, "mu": 0.05, "restitution": 0.75} | changes)


def periodic(**changes):
    """Solve the periodic problem with some argument wrong."""
    return vi.periodic(**{"osc": OSC, "r": 0.9, "phases": PHASES, "pattern": PAIR} | changes)


def linear_system(**changes):
    """Assemble the linear system with some argument wrong."""
    return vi.linear_system(**{"osc": OSC, "r": 0.9, "phases": PHASES, "pattern": PAIR} | changes)


def batch(**changes):
    """Solve a batch of two with some argument wrong."""
    good = {"osc": OSC, "r": 0.9, "phases": [[0.0, 0.0], [3.3, 3.4]], "pattern": PAIR}
    return vi.periodic_batch(**good | changes)


def equispaced(**changes):
    """Solve the equispaced problem with some argument wrong."""
    return vi.equispaced(**{"osc": EVEN, "r": 0.9, "clearance": 20.0} | changes)


def refused(call, name, value, allowed=(), kind=(ValueError, TypeError), shown=None):
    """Assert that a call with one wrong argument is refused: the name, the value, and what it must be."""
    with pytest.raises(kind) as caught:
        call(**{name: value})
    assert isinstance(caught.value, vi.errors.VibroimpactError)
    text = str(caught.value)
    head, must, wanted = text.partition(" must ")
    assert re.match(rf"{name}\b", head), text
    assert must, text
    shown = str(value) if shown is None else shown
    # what is asked for must not stand in for the value, nor the value for what is asked for
    assert any(one in head for one in (shown, repr(value))), text
    for word in allowed:
        assert word in wanted, text


@pytest.mark.parametrize("value", [NAN, INF, -INF, -0.1, 1.0, 1.5, 1e300])
def test_xi_values(value):
    """Damping from 0 to below 1."""
    refused(oscillator, "xi", value, ("0 <= xi < 1",), ValueError)


@pytest.mark.parametrize("value", [NAN, INF, -INF, -1e-9, -1.0])
def test_mu_values(value):
    """A mass ratio cannot be negative."""
    refused(oscillator, "mu", value, ("0 <= mu <= 1e+06",), ValueError)


@pytest.mark.parametrize("value", [NAN, INF, -0.1, 1.0001, 7.0])
@pytest.mark.parametrize("place", [None, 0, 1])
def test_restitution_values(value, place):
    """Each coefficient of restitution lies in [0, 1]."""
    pair = [0.5, 0.5]
    if place is None:
        pair = value
    else:
        pair[place] = value
    refused(oscillator, "restitution", pair, ("0", "1"), ValueError, str(value))
    if place is not None:
        refused(periodic, "restitution", pair, ("0", "1"), ValueError, str(value))
        refused(batch, "restitution", pair, ("0", "1"), ValueError, str(value))
        refused(linear_system, "restitution", pair, ("0", "1"), ValueError, str(value))


@pytest.mark.parametrize("value", [(), (0.5,), (0.5, 0.5, 0.5), [[0.5, 0.5]]])
def test_restitution_shapes(value):
    """One number, or one a wall; one an impact in the solvers."""
    refused(oscillator, "restitution", value)
    refused(periodic, "restitution", value)


@pytest.mark.parametrize("value", ["0.1", b"0.1", None, 0.1j, [0.1], (), {}, np.array([0.1, 0.2])])
@pytest.mark.parametrize("name", ["xi", "mu"])
def test_oscillator_types(name, value):
    """Numbers are real numbers."""
    refused(oscillator, name, value, (), TypeError)


@pytest.mark.parametrize("value", ["0.1", None, 0.1j, ("a", "b"), (0.5, None), (0.5, 1j), {}])
def test_restitution_types(value):
    """Restitution is a number or a pair of them."""
    shown = repr(value[1]) if isinstance(value, tuple) else None
    if value == ("a", "b"):
        shown = "'a'"
    refused(oscillator, "restitution", value, (), TypeError, shown)


@pytest.mark.parametrize("value", ["", "R", "L", "RR", "LLL", "RX", "R L", "R,L", "R1", "L*", "RÉ"])
def test_sides_values(value):
    """Letters R and L only, and both of them: with one wall nothing is periodic."""
    refused(lambda sides: vi.Pattern(sides), "sides", value, (), ValueError)


@pytest.mark.parametrize("value", [None, 12, 1.5, ["R", "L"], b"RL", True])
def test_sides_types(value):
    """The sides are a string."""
    refused(lambda sides: vi.Pattern(sides), "sides", value, (), TypeError)


@pytest.mark.parametrize("value", [0, -1, 1.5, True, False, NAN, INF, "1", None, 1j, [1], 10**30])
def test_cycles(value):
    """A whole number of load cycles from 1; a bool is not a number of cycles."""
    refused(lambda cycles: vi.Pattern("RL", cycles), "cycles", value, ("1 <= cycles <= 10000",))
    refused(equispaced, "cycles", value)


CALLS = [periodic, linear_system, batch, equispaced]


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("value", [0.0, -0.0, -0.9, NAN, INF, -INF])
def test_r_values(call, value):
    """A frequency ratio is positive and finite."""
    refused(call, "r", value, ("1e-06 <= r <= 1e+06",), ValueError)


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("value", ["0.9", None, 0.9j])
def test_r_types(call, value):
    """A frequency ratio is a real number."""
    refused(call, "r", value, (), TypeError)


@pytest.mark.parametrize("call", CALLS)
def test_resonance_without_damping(call):
    """With r = 1 and xi = 0 the amplitude A is infinite; just beside it is not."""
    osc = oscillator(xi=0.0)
    with pytest.raises(ValueError, match="xi") as caught:
        call(osc=osc, r=1.0)
    assert isinstance(caught.value, vi.errors.VibroimpactError)
    assert "r = 1" in str(caught.value)
    call(osc=osc, r=1.0 + 1e-9)
    call(osc=oscillator(xi=1e-6), r=1.0)


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        ([], None),
        ([0.0], None),
        ([0.0, 1.0, 2.0], None),
        (0.0, None),
        ([[0.0, 3.3]], "3.3"),
        ([0.0, 0.0], "0.0"),
        ([0.0, -1.0], "-1.0"),
        ([0.1, 3.3], "0.1"),
        ([0.0, 2 * math.pi], "6.28"),
        ([0.0, 100.0], "100.0"),
        ([0.0, NAN], "nan"),
        ([0.0, INF], "inf"),
        ([NAN, 3.3], "nan"),
        ([-0.1, 3.3], "-0.1"),
        ([[0.0], [1.0, 2.0]], None),
        ([0.0, 1e300], "1e+300"),
    ],
)
@pytest.mark.parametrize("call", [periodic, linear_system])
def test_phases_values(call, value, shown):
    """As many phases as impacts, from 0, increasing, below the period."""
    refused(call, "phases", value, (), ValueError, shown)


@pytest.mark.parametrize("value", [[0.0, 3.0, 2.0], [0.0, 2.0, 2.0], [0.0, 2.0, 7.0]])
def test_phases_of_three(value):
    """Unsorted, repeated, beyond the period."""
    with pytest.raises(ValueError, match=r"^phases\b.* must ") as caught:
        vi.periodic(OSC, 0.9, value, vi.Pattern("RRL"))
    assert isinstance(caught.value, vi.errors.VibroimpactError)
    assert str(value[2]) in str(caught.value)


@pytest.mark.parametrize("value", ["03", None, [0.0, 3.3j], ["0", "3.3"], [0.0, None], {}])
@pytest.mark.parametrize("call", [periodic, linear_system, batch])
def test_phases_types(call, value):
    """Phases are real numbers."""
    refused(call, "phases", value)


@pytest.mark.parametrize(
    "value",
    [
        [0.0, 3.3],
        [[0.0, 0.0]],
        [[0.0, 0.1], [3.3, 3.3]],
        [[0.0, 0.0], [3.3, 7.0]],
        [[0.0, 0.0], [3.3, NAN]],
        [[0.0, 0.0], [3.3, 0.0]],
    ],
)
def test_batch_phases(value):
    """One set of phases a column; the message shows the column, or the shape."""
    with pytest.raises(ValueError, match=r"^phases\b.* must ") as caught:
        batch(phases=value)
    assert isinstance(caught.value, vi.errors.VibroimpactError)


@pytest.mark.parametrize("value", [[0.9], [0.9, 1.1]])
def test_batch_r_shapes_that_fit(value):
    """One r, or one a column."""
    assert len(batch(r=value)) == 2


@pytest.mark.parametrize("value", [[], [0.9] * 3, [[0.9, 0.9]], [0.9, NAN], [0.9, 0.0]])
def test_batch_r_shapes_that_do_not(value):
    """The number of r is that of the columns."""
    with pytest.raises(ValueError, match=r"^r\b.* must ") as caught:
        batch(r=value)
    assert isinstance(caught.value, vi.errors.VibroimpactError)


def test_an_empty_batch():
    """No points are an error that names the phases, never one from inside the core."""
    with pytest.raises(ValueError, match=r"^phases\b.* must ") as caught:
        batch(phases=np.zeros((2, 0)))
    assert isinstance(caught.value, vi.errors.VibroimpactError)


@pytest.mark.parametrize("value", [0.0, -1.0, NAN, INF, -INF])
def test_clearance_values(value):
    """A clearance is positive and finite."""
    refused(equispaced, "clearance", value, ("1e-12 <= clearance <= 1e+12",), ValueError)


@pytest.mark.parametrize("value", ["20", None, 20j, [20.0, 21.0]])
def test_clearance_types(value):
    """A clearance is a number."""
    refused(equispaced, "clearance", value, (), TypeError)


@pytest.mark.parametrize("call", [periodic, batch])
@pytest.mark.parametrize("value", [-0.1, NAN, INF, "0.03", None, 1j])
def test_acceptance(call, value):
    """The accepted residual is a finite number from 0."""
    refused(call, "acceptance", value)


@pytest.mark.parametrize("call", [periodic, batch, equispaced])
@pytest.mark.parametrize("value", ["half", "", "Double", None, 64, float])
def test_precision(call, value):
    """Two words."""
    kind = ValueError if isinstance(value, str) else TypeError
    refused(call, "precision", value, ("double", "single"), kind)


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("value", [None, 0.1, (0.01, 0.05, 0.75), "osc", vi.Oscillator])
def test_osc(call, value):
    """An Oscillator, not its numbers."""
    refused(call, "osc", value, ("Oscillator",), TypeError)


@pytest.mark.parametrize("call", [periodic, linear_system, batch])
@pytest.mark.parametrize("value", [None, "RL", ("RL", 1), vi.Pattern])
def test_pattern(call, value):
    """A Pattern, not its sides."""
    refused(call, "pattern", value, ("Pattern",), TypeError)


def test_equispaced_needs_equal_restitution():
    """The symmetric pair exists with R1 = R2 only."""
    with pytest.raises(ValueError, match=r"^restitution\b.* must ") as caught:
        equispaced(osc=OSC)
    assert isinstance(caught.value, vi.errors.VibroimpactError)
    assert "0.75" in str(caught.value)
    assert "0.61" in str(caught.value)


@pytest.mark.parametrize("cycles", [2, 4, 100])
def test_equispaced_needs_odd_cycles(cycles):
    """Half of an even number of cycles is no mirror of the load."""
    refused(equispaced, "cycles", cycles, ("odd",), ValueError)


def test_equispaced_answers():
    """Two motions below the largest clearance, none above, one or two equal ones there."""
    osc = vi.Oscillator(xi=0.0, mu=0.0, restitution=0.5)
    r, A = 0.5, 1.0 / 0.75
    limit = A * math.hypot(3.0 * math.pi, 2.0)
    below, above = (vi.equispaced(osc, r, limit * f) for f in (1 - 1e-6, 1 + 1e-6))
    assert len(below) == 2
    assert below[0].tau != below[1].tau
    assert above == []
    there = vi.equispaced(osc, r, limit)
    assert len(there) <= 2
    assert all(abs(motion.tau - there[0].tau) < 1e-6 for motion in there)


def test_singular_phases():
    """Equal restitution and equal halves leave the amplitude free: an error that says so."""
    with pytest.raises(vi.errors.SingularError) as caught:
        vi.periodic(EVEN, 0.9, [0.0, math.pi], PAIR)
    assert isinstance(caught.value, ArithmeticError)
    assert isinstance(caught.value, vi.errors.VibroimpactError)
    assert len(str(caught.value)) > 20


def test_phases_that_need_no_load():
    """Two symmetric periods in one cycle are answered without load: then no clearance is right."""
    osc = vi.Oscillator(xi=0.0, mu=0.0, restitution=0.0)
    with pytest.raises(vi.errors.SingularError, match="load"):
        vi.periodic(osc, 2.0, np.arange(4) * math.pi / 2, vi.Pattern("RLRL"))


def test_unusual_but_right():
    """Integers, tuples, float32, arrays of one number's kind, N = 8, R = 0 and 1, mu = 0."""
    one = vi.Oscillator(0, 0, 1)
    assert one.restitution == (1.0, 1.0)
    assert vi.Oscillator(0.1, 1, (0, 1)).restitution == (0.0, 1.0)
    expected = vi.periodic(OSC, 2.0, [0.0, 3.0], PAIR).X
    for phases in ((0, 3), np.array([0, 3]), np.array([0, 3], np.float32), range(0, 6, 3)):
        assert np.array_equal(vi.periodic(OSC, 2, phases, PAIR).X, expected)
    assert np.array_equal(vi.periodic(OSC, np.float64(2.0), [0, 3], PAIR).X, expected)
    many = vi.periodic(OSC, 2.0, np.arange(8) * 0.7, vi.Pattern("RRLLRLRL"))
    assert many.X.shape == (8,)
    assert vi.Pattern("RL", np.int64(2)).cycles == 2


def test_frozen():
    """Nothing of an oscillator, a pattern or a motion can be assigned."""
    motion = periodic()
    for thing, name in (
        (OSC, "xi"),
        (OSC, "restitution"),
        (PAIR, "sides"),
        (PAIR, "cycles"),
        (motion, "X"),
        (motion, "stable"),
        (motion, "clearance"),
        (motion, "r"),
    ):
        before = getattr(thing, name)
        with pytest.raises(AttributeError):
            setattr(thing, name, 1.0)
        with pytest.raises(AttributeError):
            delattr(thing, name)
        assert getattr(thing, name) is before


def test_arrays_are_read_only_and_ours():
    """The arrays of a motion cannot be written, and are not the caller's."""
    phases, own = np.array(PHASES), np.array([0.5, 0.6])
    motion = periodic(phases=phases, restitution=own)
    (half, *_) = vi.equispaced(EVEN, 0.9, 20.0)
    many = np.array([[0.0, 0.0], [3.3, 3.4]])
    ratios = np.array([0.9, 0.91])
    motions = batch(phases=many, r=ratios)
    for thing in (motion, half, motions, motions[1]):
        for name in ARRAYS:
            with pytest.raises(ValueError, match="read-only"):
                getattr(thing, name)[0] = 0.0
    phases[1], own[0], many[1, 0], ratios[0] = 2.0, 0.1, 2.0, 0.5
    assert (motion.phases[1], motion.restitution[0]) == (3.3, 0.5)
    assert (motions.phases[1, 0], motions.r[0]) == (3.3, 0.9)
    motion.impact_maps()[0, 0, 0] = 1.0
    assert motion.impact_maps()[0, 0, 0] != 1.0


def test_equal_oscillators_and_patterns():
    """Values compare by value and can be keys."""
    assert vi.Oscillator(0.01, 0.05, (0.75, 0.61)) == OSC
    assert vi.Pattern("RL", 1) == PAIR
    assert vi.Pattern("RL", 2) != PAIR
    assert len({OSC, vi.Oscillator(0.01, 0.05, (0.75, 0.61))}) == 1
    assert len({PAIR, vi.Pattern("RL")}) == 1
    assert eval(repr(OSC), {"Oscillator": vi.Oscillator}) == OSC
    assert eval(repr(PAIR), {"Pattern": vi.Pattern}) == PAIR
    assert pickle.loads(pickle.dumps(OSC)) == OSC
    assert pickle.loads(pickle.dumps(PAIR)) == PAIR
    assert np.array_equal(pickle.loads(pickle.dumps(periodic())).X, periodic().X)


def test_to_dict_is_json():
    """Plain values throughout, and the same after a round trip."""
    motion = periodic()
    plain = json.loads(json.dumps(motion.to_dict(), allow_nan=False))
    for name in (
        "r",
        "clearance",
        "A",
        "tau",
        "residual",
        "x_min",
        "x_max",
        "consistent",
        "admissible",
        "stable",
        "precision",
    ):
        assert plain[name] == getattr(motion, name), name
    for name in ARRAYS[:-1]:
        assert plain[name] == getattr(motion, name).tolist(), name
    multipliers = np.array(plain["multipliers"])
    assert np.array_equal(multipliers[:, 0] + 1j * multipliers[:, 1], motion.multipliers)
    assert "RL" in json.dumps(plain)
    assert len(motion.to_dict()["X"]) == 2


@pytest.mark.parametrize("name", ["consistent", "admissible", "stable"])
def test_repr_names_the_verdicts(name):
    """A glance at a motion shows what it is worth."""
    assert name in repr(periodic())
    assert "RL" in repr(periodic())


@pytest.mark.parametrize("value", ["1", None, 1j, NAN, INF, [0.0, NAN], ["a"]])
def test_sample_times(value):
    """Times are finite real numbers."""
    motion = periodic()
    refused(lambda t: motion.sample(t), "t", value)


def test_sample_of_nothing():
    """No times give empty arrays."""
    assert periodic().sample([]).X.shape == (0,)


def test_index_of_a_batch():
    """Points are found from both ends, and none beyond."""
    motions = batch()
    assert np.array_equal(motions[-1].X, motions[1].X)
    assert len(list(motions)) == 2
    with pytest.raises(IndexError):
        motions[2]


@given(st.floats(0.01, 0.99), st.floats(-150, 150), st.floats(-150, 150))
@settings(max_examples=300, deadline=None, derandomize=True)
def test_damping_ratio_is_the_nearest_number(xi, log_M, log_K):
    """C/(2 sqrt(K M)) to the last bit, in exact arithmetic, however large or small M and K are."""
    M, K = 10.0**log_M, 10.0**log_K
    C = xi * 2 * math.sqrt(M) * math.sqrt(K)
    osc = vi.Oscillator.from_dimensional(M, K, C, 0.1 * M, 0.5)
    below, above = (
        (Fraction(osc.xi) + Fraction(math.nextafter(osc.xi, end))) / 2 for end in (0, 1)
    )
    square = Fraction(C) ** 2 / (4 * Fraction(K) * Fraction(M))
    assert below**2 <= square <= above**2


def test_round_damping_ratios_come_out_round():
    """M = 4, K = 25 and C = 1 are 5 % of critical damping."""
    assert vi.Oscillator.from_dimensional(4.0, 25.0, 1.0, 0.1, 0.5).xi == 0.05
    assert vi.Oscillator.from_dimensional(2.0, 800.0, 4.0, 0.1, 0.5).xi == 0.05
    with pytest.raises(vi.errors.ParameterError, match="critical damping 2 sqrt"):
        vi.Oscillator.from_dimensional(4.0, 25.0, 20.0, 0.1, 0.5)
