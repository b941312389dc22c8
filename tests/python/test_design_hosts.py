"""Designs for hosts other than the oscillator under a harmonic load: structures, and free vibration."""

import functools
import math

import numpy as np
import pytest
import vibroimpact as vi
from shared_design import FEW, GOOD, OSC, QUICK
from vibroimpact.designs import hosts
from vibroimpact.designs.hosts import DecayHost, StructureHost
from vibroimpact.designs.order import asked_by
from vibroimpact.designs.problem import OscillatorHost
from vibroimpact.motions.reached import extent


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


def test_runs_that_failed_have_an_infinite_excess(monkeypatch):
    """A decay without enough extremes, and a simulation that `max_events` cuts short, whatever the limits are."""
    osc = vi.Oscillator(xi=0.9, mu=1.0, restitution=1.0)
    place = np.array([[0.0], [0.0], [0.3], [0.0]])
    one, values = np.ones(1), {"clearance": np.array([0.1])}
    found = DecayHost(osc, None, 10, 1).outcome(values, one, one, place, None, "")
    assert (found.target[0], found.excess[0]) == (math.inf, math.inf)

    def build(r, load, clearance):
        return OSC.structure(clearance), vi.Load(r, sine=[load, 0])

    figures = functools.partial(hosts.reached_figures, max_events=3)
    monkeypatch.setattr(hosts, "reached_figures", figures)
    for limits in ({}, {"least_speed": 1e-9}):
        for target in ("displacement", "attenuation"):
            host = StructureHost(build, 0, target, limits, 5, 5, 1)
            found = host.outcome(values, one, one, place, None, "")
            assert (found.target[0], found.excess[0]) == (math.inf, math.inf)


def test_a_motion_without_multipliers_keeps_no_limit_of_them():
    """A rod that hits two walls at one instant has no multipliers: whether it is stable is not known."""
    gaps = [vi.Gap([1, -1], 0.3, 0.3), vi.Gap([1, 1], 0.3, 0.3)]
    rod = vi.Structure([1.0, 0.2], [0.1, 0.5], [1.0, 1.0], gaps, simultaneous="newton")
    load = vi.Load(0.9, sine=[0.5, 0])
    assert np.isnan(vi.exact(rod, load, vi.simulate(rod, load, cycles=100)).multipliers).all()
    host = StructureHost(
        lambda r, load: (rod, vi.Load(r, sine=[load, 0])), 0, "rms", {"multiplier": 1.0}, 100, 5, 1
    )
    found = host.outcome({}, np.full(1, 0.9), np.full(1, 0.5), np.zeros((4, 1)), None, "")
    assert np.isfinite(found.target[0])
    assert found.excess[0] == math.inf


def test_friction_and_walls_that_give_are_parameters():
    """The figures of a unit are those of the motion of the point with its load."""
    values = {"friction": 0.2, "wall_stiffness": 20.0, "wall_damping": 0.15, "clearance": 30.0}
    load, wall = 1.5, (20.0, 0.15)
    point = OSC.at(1.02, 30.0, load, friction=0.2, stops=(wall, wall))
    motion = vi.exact(point, vi.simulate(point, cycles=600))
    limits = {"speed": 1.0, "displacement": 1.0}
    host = OscillatorHost(OSC, None, "displacement", limits, 600, 32, 1)
    units = {name: np.array([value]) for name, value in values.items()}
    found = host.outcome(units, np.array([1.02]), np.array([load]), np.full((4, 1), 0.3), None, "")
    greatest = motion.quantities().q.peak[0]
    assert found.target[0] == pytest.approx(greatest, rel=1e-6)
    assert found.excess[0] == pytest.approx(max(greatest, motion.speeds.max()), rel=1e-6)
    assert host.slopes(values, 1.02, load, np.zeros(4)) is None


def test_friction_and_walls_that_give_are_keys(tmp_path):
    """A case has them as free or uncertain parameters, and their rules are those of the core."""
    path = tmp_path / "tape.nml"
    path.write_text(
        "&system xi = 0.0114, mu = 0.028, restitution = 0.75 /\n"
        "&design band = 1, 1.02, clearance = 25, free_friction = 0, 0.3, tolerance_wall_damping = 0.1, 0.2\n"
        "  tolerance_wall_stiffness = 20, 2, normal = 'wall_stiffness' /\n",
        encoding="utf-8",
    )
    case = vi.read_namelist(path)[0]
    problem, _ = asked_by(case.osc, case.keys)
    assert problem.free == {"friction": (0.0, 0.3)}
    values, _ = problem.units(np.array([0.2]), np.full((3, 1), 0.5))
    assert values == {"friction": 0.2, "wall_stiffness": 20.0, "wall_damping": pytest.approx(0.15)}
    units = {name: np.array([value]) for name, value in values.items()}
    found = problem.host.outcome(units, np.ones(1), np.ones(1), np.full((4, 1), 0.3), None, "")
    wall = 20.0, 0.15
    point = OSC.at(1.0, 25.0, friction=0.2, stops=(wall, wall))
    motion = vi.exact(point, vi.simulate(point, cycles=600))
    assert found.target[0] == pytest.approx(motion.quantities().q.peak[0] * 2 * OSC.xi, rel=1e-6)
    asked = {
        "r": (1.0, 1.02), "free": {"friction": (0.0, 0.3)}, "clearance": 25.0,
        "tolerance": {"wall_damping": (0.1, 0.2), "wall_stiffness": (5.0, 50.0)},
    }  # fmt: skip
    for keys, message in (
        ({"free": {"R1": (0.1, 0.2)}}, r"free\['R1'\] .* with tolerance_wall_stiffness"),
        ({"tolerance": {"wall_damping": (0.1, 0.2)}}, "must be left out without a wall_stiffness"),
        ({"limits": {"least_gap": 1.0}}, r"limits\['least_gap'\] .* must be left out with "),
        ({"tolerance": {"friction": (-2.0, -1.0)}}, "deviations with 0 among them"),
    ):
        with pytest.raises(vi.ParameterError, match=message):
            vi.design(OSC, **asked | keys)


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
