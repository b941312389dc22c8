"""Designs for hosts other than the oscillator under a harmonic load: structures, and free vibration."""

import math

import numpy as np
import pytest
import vibroimpact as vi
from shared_design import FEW, GOOD, QUICK
from vibroimpact.designs.hosts import DecayHost, StructureHost, extent
from vibroimpact.designs.problem import OscillatorHost


def test_the_oscillator_as_a_structure_has_the_same_figures():
    """Two calculations agree: the kernel of the oscillator, and interpolated samples of the structure."""
    osc = vi.Oscillator(xi=0.02, mu=0.05, restitution=0.7)

    def build(r, load, clearance):
        return osc.structure(clearance), vi.Load(r, sine=[load, 0])

    values = {"clearance": np.array([10.0, 20.0, 30.0])}
    r, load = np.array([1.0, 1.01, 1.02]), np.array([1.0, 0.8, 1.2])
    places = np.random.default_rng(0).uniform(-1, 1, (4, 3))
    for target, limits in (
        ("attenuation", {"speed": 20.0}), ("displacement", {"multiplier": 0.5}), ("rms", {"force": 3.0}),
        ("acceleration", {"acceleration": 4.0}), ("force", {"multiplier": 0.9, "least_speed": 3.0}),
        ("rms", {"least_speed": 3.0}),
    ):  # fmt: skip
        one = StructureHost(build, 0, target, limits, 400, 6, None)
        other = OscillatorHost(osc, None, target, limits, 400, 6, None)
        found, expected = (host.outcome(values, r, load, places, None, "") for host in (one, other))
        np.testing.assert_allclose(found.target, expected.target, rtol=2e-3)
        np.testing.assert_allclose(found.excess, expected.excess, rtol=2e-3)


def test_extent_of_a_harmonic_motion():
    """The order is four: with half the step the error falls by a factor of sixteen."""
    free = vi.Structure([1.0], [0.0], [1.0], gaps=[])
    run = vi.simulate(free, duration=20.0, state=([0.3], [1.0]))
    amplitude = math.hypot(0.3, 1.0)
    errors = [abs(extent(run, 2.0, many, 0)[1] / amplitude - 1) for many in (40, 80)]
    assert errors[1] < 1e-5
    assert errors[0] / errors[1] > 8
    times = np.linspace(2, 20, 100_001)
    square = np.mean(run.sample(times)[0] ** 2)
    assert extent(run, 2.0, 400, 0)[2] == pytest.approx(math.sqrt(square), rel=1e-5)


@pytest.mark.slow
def test_design_of_a_structure_chooses_the_number_of_units():
    """More free masses reduce the motion: the search chooses the largest number allowed."""

    def build(r, load, units, clearance):
        n, mu = 1 + units, 0.02
        gaps = []
        for i in range(1, n):
            direction = np.zeros(n)
            direction[[0, i]] = -1, 1
            # different clearances, since equal units would synchronise, with coupled impacts at one instant
            half = 0.5 * clearance * (1 + 0.2 * i)
            gaps += [vi.Gap(direction, half, 0.7), vi.Gap(-direction, half, 0.7)]
        host = np.zeros((n, n))
        host[0, 0] = 1
        damping = 0.04 * host
        sine = np.zeros(n)
        sine[0] = load
        return vi.Structure(np.diag([1.0, *[mu] * units]), damping, host, gaps), vi.Load(
            r, sine=sine
        )

    found = vi.design(
        build, r=(1.0, 1.01), free={"units": range(1, 4), "clearance": (5.0, 20.0)}, samples=40, evaluations=16,
        specimens=1, nodes=2, states=1, settling=60, keep=4, limit=0.9,
    )  # fmt: skip
    assert found.values["units"] == 3
    assert found.level < 0.6
    assert found.samples == 40
    assert found.probability > 0.9


def test_damping_of_free_decay_is_a_target():
    """The target equals `decay` itself on a grid of clearances."""
    osc = vi.Oscillator(xi=0.005, mu=0.1, restitution=0.75)
    host = DecayHost(osc, None, 5, None)
    clearances = np.array([0.3, 0.7, 1.5, 6.0])
    found = host.outcome(
        {"clearance": clearances}, np.ones(4), np.ones(4), np.zeros((4, 4)), None, ""
    )
    runs = vi.decay(osc, clearances, cycles=5)
    for i in range(4):
        peaks = runs.x[runs.run == i]
        decrement = math.log(peaks[0] / peaks[10]) / 5
        assert -found.target[i] == pytest.approx(
            decrement / math.hypot(2 * math.pi, decrement), rel=1e-12
        )
    assert -found.target[3] == pytest.approx(0.005, rel=1e-9)
    best = vi.design(
        osc,
        target="damping",
        amplitude=1.0,
        free={"clearance": (0.2, 2.0)},
        **{**FEW, "evaluations": 40, "specimens": 1},
    )
    grid_of = np.linspace(0.2, 2.0, 60)
    levels = host.outcome(
        {"clearance": grid_of}, np.ones(60), np.ones(60), np.zeros((4, 60)), None, ""
    )
    assert best.level > 0.9 * -levels.target.min() * 0.8


def test_errors_of_a_host_are_its_own():
    """SciPy replaces value and type errors that a function raises; the caller sees the original error."""
    with pytest.raises(vi.ParameterTypeError, match="host returned 3"):
        vi.design(lambda r, load, clearance: 3, **GOOD, **QUICK)
    with pytest.raises(TypeError, match="unexpected keyword argument 'clearance'"):
        vi.design(lambda r, load: 3, **GOOD, **QUICK)


def test_a_record_has_no_multiplier():
    """The error names the limit."""
    wall = vi.Structure([1.0], [0.1], [1.0], [vi.Gap([1.0], 0.1, 0.7)])

    def build(r, load, opening):
        return wall, vi.Record(0.1, load * np.sin(np.arange(200) / 10)[:, None])

    host = StructureHost(build, 0, "rms", {"multiplier": 0.9}, 1, 1, None)
    one = np.ones(1)
    with pytest.raises(
        vi.ParameterError, match="limits: multiplier: must be left out for a record"
    ):
        host.outcome({"opening": one}, one, one, np.zeros((4, 1)), None, "")
