"""Invalid arguments: every error names the parameter, its value and the allowed values."""

import math
import re

import numpy as np
import pytest
import vibroimpact as vi
from shared_calls import (
    EVEN,
    INF,
    NAN,
    OSC,
    PAIR,
    batch,
    equispaced,
    linear_system,
    oscillator,
    periodic,
)


def assert_refused(call, name, value, allowed=(), kind=(ValueError, TypeError), shown=None):
    """Assert that a call with one wrong argument is refused: the name, the value, and what it must be."""
    with pytest.raises(kind) as caught:
        call(**{name: value})
    assert isinstance(caught.value, vi.errors.VibroimpactError)
    text = str(caught.value)
    head, must, wanted = text.partition(" must ")
    assert re.match(rf"{name}\b", head), text
    assert must, text
    shown = str(value) if shown is None else shown
    # the text of the allowed values must not be mistaken for the value, nor the value for that text
    assert any(one in head for one in (shown, repr(value))), text
    for word in allowed:
        assert word in wanted, text


@pytest.mark.parametrize("value", [NAN, INF, -INF, -0.1, 1.0, 1.5, 1e300])
def test_xi_values(value):
    """The damping ratio must be at least 0 and below 1."""
    assert_refused(oscillator, "xi", value, ("0 <= xi < 1",), ValueError)


@pytest.mark.parametrize("value", [NAN, INF, -INF, -1e-9, -1.0])
def test_mu_values(value):
    """A mass ratio cannot be negative."""
    assert_refused(oscillator, "mu", value, ("0 <= mu <= 1e+06",), ValueError)


@pytest.mark.parametrize("value", [NAN, INF, -0.1, 1.0001, 7.0])
@pytest.mark.parametrize("place", [None, 0, 1])
def test_restitution_values(value, place):
    """Each coefficient of restitution lies in [0, 1]."""
    pair = [0.5, 0.5]
    if place is None:
        pair = value
    else:
        pair[place] = value
    assert_refused(oscillator, "restitution", pair, ("0", "1"), ValueError, str(value))
    if place is not None:
        assert_refused(periodic, "restitution", pair, ("0", "1"), ValueError, str(value))
        assert_refused(batch, "restitution", pair, ("0", "1"), ValueError, str(value))
        assert_refused(linear_system, "restitution", pair, ("0", "1"), ValueError, str(value))


@pytest.mark.parametrize("value", [(), (0.5,), (0.5, 0.5, 0.5), [[0.5, 0.5]]])
def test_restitution_shapes(value):
    """Restitution must be one number or one for each wall, or in the solvers one for each impact."""
    assert_refused(oscillator, "restitution", value)
    assert_refused(periodic, "restitution", value)


@pytest.mark.parametrize("value", ["0.1", b"0.1", None, 0.1j, [0.1], (), {}, np.array([0.1, 0.2])])
@pytest.mark.parametrize("name", ["xi", "mu"])
def test_oscillator_types(name, value):
    """Damping and mass ratio must be real numbers."""
    assert_refused(oscillator, name, value, (), TypeError)


@pytest.mark.parametrize("value", ["0.1", None, 0.1j, ("a", "b"), (0.5, None), (0.5, 1j), {}])
def test_restitution_types(value):
    """Restitution is a number or a pair of them."""
    shown = repr(value[1]) if isinstance(value, tuple) else None
    if value == ("a", "b"):
        shown = "'a'"
    assert_refused(oscillator, "restitution", value, (), TypeError, shown)


@pytest.mark.parametrize("value", ["", "R", "L", "RR", "LLL", "RX", "R L", "R,L", "R1", "L*", "RÉ"])
def test_sides_values(value):
    """The sides must have only letters R and L, and both of them."""
    assert_refused(lambda sides: vi.Pattern(sides), "sides", value, (), ValueError)


@pytest.mark.parametrize("value", [None, 12, 1.5, ["R", "L"], b"RL", True])
def test_sides_types(value):
    """The sides must be a string."""
    assert_refused(lambda sides: vi.Pattern(sides), "sides", value, (), TypeError)


@pytest.mark.parametrize("value", [0, -1, 1.5, True, False, NAN, INF, "1", None, 1j, [1], 10**30])
def test_cycles(value):
    """The number of load cycles must be a whole number from 1, and not a bool."""
    assert_refused(
        lambda cycles: vi.Pattern("RL", cycles), "cycles", value, ("1 <= cycles <= 10000",)
    )
    assert_refused(equispaced, "cycles", value)


CALLS = [periodic, linear_system, batch, equispaced]


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("value", [0.0, -0.0, -0.9, NAN, INF, -INF])
def test_r_values(call, value):
    """A frequency ratio is positive and finite."""
    assert_refused(call, "r", value, ("1e-06 <= r <= 1e+06",), ValueError)


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("value", ["0.9", None, 0.9j])
def test_r_types(call, value):
    """A frequency ratio is a real number."""
    assert_refused(call, "r", value, (), TypeError)


@pytest.mark.parametrize("call", CALLS)
def test_resonance_without_damping(call):
    """With r = 1 and xi = 0 the amplitude A is infinite; at neighbouring r it is finite."""
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
        ([0.0, 2 * math.pi], "6.28"),
        ([0.0, 100.0], "100.0"),
        ([0.0, NAN], "nan"),
        ([0.0, INF], "inf"),
        ([NAN, 3.3], "nan"),
        ([[0.0], [1.0, 2.0]], None),
        ([0.0, 1e300], "1e+300"),
    ],
)
@pytest.mark.parametrize("call", [periodic, linear_system])
def test_phases_values(call, value, shown):
    """There must be as many phases as impacts, starting at 0, increasing, and below the period."""
    assert_refused(call, "phases", value, (), ValueError, shown)


@pytest.mark.parametrize("value", [[0.0, 3.0, 2.0], [0.0, 2.0, 2.0], [0.0, 2.0, 7.0]])
def test_phases_of_three(value):
    """Unsorted, repeated, and too large phases of three impacts are refused."""
    with pytest.raises(ValueError, match=r"^phases\b.* must ") as caught:
        vi.periodic(OSC, 0.9, value, vi.Pattern("RRL"))
    assert isinstance(caught.value, vi.errors.VibroimpactError)
    assert str(value[2]) in str(caught.value)


@pytest.mark.parametrize("value", ["03", None, [0.0, 3.3j], ["0", "3.3"], [0.0, None], {}])
@pytest.mark.parametrize("call", [periodic, linear_system, batch])
def test_phases_types(call, value):
    """Phases are real numbers."""
    assert_refused(call, "phases", value)


@pytest.mark.parametrize(
    "value",
    [
        [0.0, 3.3],
        [[0.0, 0.0]],
        [[NAN, 0.1], [3.3, 3.3]],
        [[INF, 0.1], [INF, 3.3]],
        [[0.0, 0.0], [3.3, 7.0]],
        [[0.0, 0.0], [3.3, NAN]],
        [[0.0, 0.0], [3.3, 0.0]],
    ],
)
def test_batch_phases(value):
    """Each column is one set of phases; the message shows the invalid column, or the shape."""
    with pytest.raises(ValueError, match=r"^phases\b.* must ") as caught:
        batch(phases=value)
    assert isinstance(caught.value, vi.errors.VibroimpactError)


def test_phases_count_by_their_differences():
    """Phases of a motion, which are load phases, are accepted as input again."""
    first, again = periodic(phases=[0.0, 3.25]), periodic(phases=[0.5, 3.75])
    assert again.to_dict() == first.to_dict()
    rows = batch(phases=[[0.0, -0.5], [3.25, 2.75]], r=[0.9, 0.9])
    assert np.array_equal(rows.alpha, [[0.0, 0.0], [3.25, 3.25]])
    assert np.array_equal(rows[0].X, rows[1].X)


@pytest.mark.parametrize("value", [[0.9], [0.9, 1.1]])
def test_batch_r_shapes_that_fit(value):
    """A batch takes one r, or one for each column."""
    assert len(batch(r=value)) == 2


@pytest.mark.parametrize("value", [[], [0.9] * 3, [[0.9, 0.9]], [0.9, NAN], [0.9, 0.0]])
def test_batch_r_shapes_that_do_not(value):
    """The number of frequency ratios must be 1 or the number of columns."""
    with pytest.raises(ValueError, match=r"^r\b.* must ") as caught:
        batch(r=value)
    assert isinstance(caught.value, vi.errors.VibroimpactError)


def test_an_empty_batch():
    """A batch without points is refused by an error that names the phases."""
    with pytest.raises(ValueError, match=r"^phases\b.* must ") as caught:
        batch(phases=np.zeros((2, 0)))
    assert isinstance(caught.value, vi.errors.VibroimpactError)


@pytest.mark.parametrize("value", [0.0, -1.0, NAN, INF, -INF])
def test_clearance_values(value):
    """A clearance is positive and finite."""
    assert_refused(equispaced, "clearance", value, ("1e-12 <= clearance <= 1e+12",), ValueError)


@pytest.mark.parametrize("value", ["20", None, 20j, [20.0, 21.0]])
def test_clearance_types(value):
    """A clearance is a number."""
    assert_refused(equispaced, "clearance", value, (), TypeError)


@pytest.mark.parametrize("call", [periodic, batch])
@pytest.mark.parametrize("value", [-0.1, NAN, INF, "0.03", None, 1j])
def test_acceptance(call, value):
    """The accepted residual is a finite number from 0."""
    assert_refused(call, "acceptance", value)


@pytest.mark.parametrize("call", [periodic, batch, equispaced])
@pytest.mark.parametrize("value", ["half", "", "Double", None, 64, float])
def test_precision(call, value):
    """The precision must be 'double' or 'single'."""
    kind = ValueError if isinstance(value, str) else TypeError
    assert_refused(call, "precision", value, ("double", "single"), kind)


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("value", [None, 0.1, (0.01, 0.05, 0.75), "osc", vi.Oscillator])
def test_osc(call, value):
    """`osc` must be an Oscillator, not its numbers."""
    assert_refused(call, "osc", value, ("Oscillator",), TypeError)


@pytest.mark.parametrize("call", [periodic, linear_system, batch])
@pytest.mark.parametrize("value", [None, 7, ("RL", 1), vi.Pattern])
def test_pattern(call, value):
    """`pattern` must be a Pattern or its text."""
    assert_refused(call, "pattern", value, ("Pattern",), TypeError)


def test_equispaced_needs_equal_restitution():
    """The symmetric pair exists with R1 = R2 only."""
    with pytest.raises(ValueError, match=r"^restitution\b.* must ") as caught:
        equispaced(osc=OSC)
    assert isinstance(caught.value, vi.errors.VibroimpactError)
    assert "0.75" in str(caught.value)
    assert "0.61" in str(caught.value)


@pytest.mark.parametrize("cycles", [2, 4, 100])
def test_equispaced_needs_odd_cycles(cycles):
    """The load is its own mirror image only after an odd number of half cycles, so `cycles` must be odd."""
    assert_refused(equispaced, "cycles", cycles, ("odd",), ValueError)


@pytest.mark.parametrize("value", ["1", None, 1j, NAN, INF, [0.0, NAN], ["a"]])
def test_sample_times(value):
    """Times are finite real numbers."""
    motion = periodic()
    assert_refused(lambda t: motion.sample(t), "t", value)


#: Calls of studies with None for a number, or with a bool in a list of numbers, and the named argument.
NO_NUMBERS = {
    "r = [1.0, True]": lambda: vi.response(EVEN, [1.0, True], 25.0),
    "r = [1.0, None]": lambda: vi.response(EVEN, [1.0, None], 25.0),
    "states = None": lambda: vi.response(EVEN, [1.0, 1.1], 25.0, states=None),
    "states = True": lambda: vi.response(EVEN, [1.0, 1.1], 25.0, states=True),
    "load = None": lambda: vi.response(EVEN, [1.0, 1.1], 25.0, load=None),
    "clearance = [25.0, True]": lambda: vi.lyapunov(EVEN, 1.04, [25.0, True]),
    "cycles = None": lambda: vi.lyapunov(EVEN, 1.04, 25.0, cycles=None),
    "values = [20, True]": lambda: vi.bifurcation_diagram(EVEN, "clearance", [20, True], r=1.04),
    "values = [20, None]": lambda: vi.bifurcation_diagram(EVEN, "clearance", [20, None], r=1.04),
    "r[1] = True": lambda: vi.zone(EVEN, PAIR, (0.9, True), (20, 30)),
    "r[1]: is missing": lambda: vi.zone(EVEN, PAIR, (0.9, None), (20, 30)),
    "lines = None": lambda: vi.zone(EVEN, PAIR, (0.9, 1.0), (20, 30), lines=None),
    "clearance[1]: is missing": lambda: vi.atlas(EVEN, (0.9, 1.0), (20, None)),
    "clearance = [0.5, True]": lambda: vi.decay(EVEN, [0.5, True], cycles=2),
    "phases = [0.0, True]": lambda: vi.periodic(EVEN, 0.9, [0.0, True], PAIR),
    "state['x'] = True": lambda: vi.simulate(
        EVEN, 0.9, 20.0, 1, {"t": 0, "x": True, "x_dot": 0, "z": 0, "z_dot": 0}
    ),
    "r = None": lambda: vi.find(EVEN, None, 20.0),
    "guesses = None": lambda: vi.find(EVEN, 0.9, 20.0, guesses=None),
    "r = [0.9, True]": lambda: vi.chart(EVEN, PAIR, r=[0.9, True], clearance=[20, 30]),
    "clearance = [20, None]": lambda: vi.chart(EVEN, PAIR, r=[0.9, 1.0], clearance=[20, None]),
    "clearance: is missing": lambda: vi.basins(EVEN, 0.9, None, states=2),
    "high = [True, 1]": lambda: vi.basins(EVEN, 0.9, 20.0, (("x", -1, True, 3), ("y", -1, 1, 3))),
    "restitution[1] = True": lambda: vi.Oscillator(xi=0.1, mu=0.1, restitution=(0.5, True)),
    "phases = [[0, 0], [True, 3.2]]": lambda: vi.stability_flags(
        EVEN, 0.9, [[0, 0], [True, 3.2]], PAIR
    ),
    "r = [1.1, True]": lambda: vi.simulate_bundle(EVEN, [1.1, True], 20.0, 1),
}


@pytest.mark.parametrize("name", NO_NUMBERS)
def test_none_and_bool_are_not_numbers(name):
    """None and bool are refused where a number is required, also in lists, and the argument is named."""
    with pytest.raises(vi.errors.VibroimpactError) as caught:
        NO_NUMBERS[name]()
    assert name in str(caught.value)


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (lambda r: vi.bifurcation_diagram(OSC, "clearance", [1, 2, 3], r=r), "r"),
        (lambda restitution: OSC.structure(1.0, restitution), "restitution"),
        (lambda cases: vi.campaign(cases, "nowhere"), "cases"),
    ],
)
@pytest.mark.parametrize("value", [([], [[0.0]]), [0.5, 0.5, 0.5], np.array(0.0)])
def test_lists_of_another_shape(call, name, value):
    """A list of lists of different lengths, one of a wrong length, and an array without dimensions."""
    if name == "restitution" and isinstance(value, np.ndarray):
        value = ([], [], [])
    if name == "r" and isinstance(value, list):
        value = [[0.5], [0.5, 0.6]]
    if name == "r" and isinstance(value, np.ndarray):
        value = np.array([0.9, 0.9])
    with pytest.raises(vi.errors.VibroimpactError, match=rf"^{name}\b"):
        call(value)
