"""Oscillators, patterns, motions and batches as objects: immutability, equality, JSON, representations."""

import json
import math
import pickle
from fractions import Fraction

import numpy as np
import pytest
import vibroimpact as vi
from hypothesis import given, settings
from hypothesis import strategies as st
from shared_calls import EVEN, OSC, PAIR, PHASES, batch, periodic

ARRAYS = (
    "restitution",
    "alpha",
    "X",
    "Z",
    "X_dot_before",
    "X_dot_after",
    "Z_dot_before",
    "Z_dot_after",
    "multipliers",
)


def test_equispaced_answers():
    """Two motions exist below the largest clearance, none above it, and one or two equal ones at it."""
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
    """Equal restitution and equal halves leave the amplitude undetermined, which is an error."""
    with pytest.raises(vi.errors.SingularError) as caught:
        vi.periodic(EVEN, 0.9, [0.0, math.pi], PAIR)
    assert isinstance(caught.value, ArithmeticError)
    assert isinstance(caught.value, vi.errors.VibroimpactError)
    assert len(str(caught.value)) > 20


def test_phases_that_need_no_load():
    """Two symmetric periods in one cycle need no load, so no clearance is determined: an error."""
    osc = vi.Oscillator(xi=0.0, mu=0.0, restitution=0.0)
    with pytest.raises(vi.errors.SingularError, match="load"):
        vi.periodic(osc, 2.0, np.arange(4) * math.pi / 2, vi.Pattern("RLRL"))


def test_unusual_but_right():
    """Valid but unusual arguments: integers, tuples, float32, 0-d arrays, N = 8, R = 0 and 1, mu = 0."""
    one = vi.Oscillator(xi=0, mu=0, restitution=1)
    assert one.restitution == (1.0, 1.0)
    assert vi.Oscillator(xi=0.1, mu=1, restitution=(0, 1)).restitution == (0.0, 1.0)
    expected = vi.periodic(OSC, 2.0, [0.0, 3.0], PAIR).X
    for phases in ((0, 3), np.array([0, 3]), np.array([0, 3], np.float32), range(0, 6, 3)):
        assert np.array_equal(vi.periodic(OSC, 2, phases, PAIR).X, expected)
    assert np.array_equal(vi.periodic(OSC, np.float64(2.0), [0, 3], PAIR).X, expected)
    many = vi.periodic(OSC, 2.0, np.arange(8) * 0.7, vi.Pattern("RRLLRLRL"))
    assert many.X.shape == (8,)
    assert vi.Pattern("RL", np.int64(2)).cycles == 2


def test_no_attenuation_without_forced_motion(results):
    """max|x|/A is omitted where A is 0: free vibration between the walls."""
    free = results["motion"].__replace__(A=0.0)
    assert free._facts()["max|x|/A"] == "-"
    assert results["motion"]._facts()["max|x|/A"] != "-"


def test_frozen():
    """Attributes of an oscillator, a pattern or a motion cannot be assigned."""
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
    """The arrays of a motion are read-only, and separate from the caller's."""
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
    assert (motion.alpha[1], motion.restitution[0]) == (3.3, 0.5)
    assert (motions.alpha[1, 0], motions.r[0]) == (3.3, 0.9)
    motion.impact_maps()[0, 0, 0] = 1.0
    assert motion.impact_maps()[0, 0, 0] != 1.0


def test_equal_oscillators_and_patterns():
    """Oscillators and patterns compare by value, and can be keys of a dictionary."""
    assert vi.Oscillator(xi=0.01, mu=0.05, restitution=(0.75, 0.61)) == OSC
    assert vi.Pattern("RL", 1) == PAIR
    assert vi.Pattern("RL", 2) != PAIR
    assert len({OSC, vi.Oscillator(xi=0.01, mu=0.05, restitution=(0.75, 0.61))}) == 1
    assert len({PAIR, vi.Pattern("RL")}) == 1
    assert eval(repr(OSC), {"Oscillator": vi.Oscillator}) == OSC
    assert eval(repr(PAIR), {"Pattern": vi.Pattern}) == PAIR
    assert pickle.loads(pickle.dumps(OSC)) == OSC
    assert pickle.loads(pickle.dumps(PAIR)) == PAIR
    assert np.array_equal(pickle.loads(pickle.dumps(periodic())).X, periodic().X)


def test_to_dict_is_json():
    """`to_dict` gives values that JSON can hold, and restores the same object."""
    motion = periodic()
    tables = json.loads(json.dumps(motion.to_dict(), allow_nan=False))["tables"]
    plain, impacts = (tables[name]["columns"] for name in ("motions", "impacts"))
    for name in ("r", "clearance", "A", "tau", "residual", "x_min", "x_max", "precision", "kind"):
        assert plain[name] == getattr(motion, name), name
    codes = {True: 1, False: 0, None: -1}
    for name in ("consistent", "admissible", "stable"):
        assert plain[name] == codes[getattr(motion, name)], name
    for name in ARRAYS[:-1]:
        assert impacts[{"alpha": "phase"}.get(name, name)] == getattr(motion, name).tolist(), name
    multipliers = np.array(plain["multipliers"])
    assert np.array_equal(multipliers[:, 0] + 1j * multipliers[:, 1], motion.multipliers)
    assert plain["sides"] == "RL"
    assert len(impacts["X"]) == 2


@pytest.mark.parametrize("name", ["consistent", "admissible", "stable"])
def test_repr_names_the_verdicts(name):
    """The text of a motion has its verdicts; its one-line repr omits only `consistent`."""
    assert name in str(periodic())
    assert name in repr(periodic()) or name == "consistent"
    assert len(repr(periodic())) <= 88
    assert "RL" in repr(periodic())


def test_repr_of_an_inconsistent_motion():
    """The repr of an inconsistent motion states that it is not consistent."""
    motion = periodic().__replace__(consistent=False)
    assert ": not consistent (residual " in repr(motion)


def test_sample_of_nothing():
    """An empty list of times gives empty arrays."""
    assert periodic().sample([]).X.shape == (0,)


def test_index_of_a_batch():
    """A batch takes indices from both ends, and refuses indices out of range."""
    motions = batch()
    assert np.array_equal(motions[-1].X, motions[1].X)
    assert len(list(motions)) == 2
    with pytest.raises(IndexError):
        motions[2]


@given(st.floats(0.01, 0.99), st.floats(-150, 150), st.floats(-150, 150))
@settings(max_examples=300, deadline=None, derandomize=True)
def test_damping_ratio_is_the_nearest_number(xi, log_M, log_K):
    """C/(2 sqrt(K M)) is exact to the last bit, however large or small M and K are."""
    M, K = 10.0**log_M, 10.0**log_K
    C = xi * 2 * math.sqrt(M) * math.sqrt(K)
    osc = vi.Oscillator.from_dimensional(M=M, K=K, C=C, m=0.1 * M, restitution=0.5)
    below, above = (
        (Fraction(osc.xi) + Fraction(math.nextafter(osc.xi, end))) / 2 for end in (0, 1)
    )
    square = Fraction(C) ** 2 / (4 * Fraction(K) * Fraction(M))
    assert below**2 <= square <= above**2


def test_round_damping_ratios_come_out_round():
    """M = 4, K = 25 and C = 1 are 5 % of critical damping."""
    assert vi.Oscillator.from_dimensional(M=4.0, K=25.0, C=1.0, m=0.1, restitution=0.5).xi == 0.05
    assert vi.Oscillator.from_dimensional(M=2.0, K=800.0, C=4.0, m=0.1, restitution=0.5).xi == 0.05
    with pytest.raises(vi.errors.ParameterError, match="critical damping 2 sqrt"):
        vi.Oscillator.from_dimensional(M=4.0, K=25.0, C=20.0, m=0.1, restitution=0.5)
