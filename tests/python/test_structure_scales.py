"""Structures whose masses, stiffnesses, rates, units or times differ by many orders of magnitude."""

import math

import numpy as np
import pytest
import vibroimpact as vi


@pytest.mark.parametrize("apart", [1e-2, 1e-5, 3e-9])
def test_near_a_resonance_without_damping_digits_are_kept(apart):
    omega = 1 + apart
    run = vi.simulate(
        vi.Structure([1.0], [0.0], [1.0], [vi.Gap([1.0], 9.0)]),
        vi.Load(omega, sine=[1.0]),
        cycles=2,
    )
    t = np.linspace(0, 12, 50)
    # (sin omega t - omega sin t)/(1 - omega^2) with both differences of sines as products
    half = apart / 2
    exact = (np.sin(t) - 2 * np.cos((1 + half) * t) * np.sin(half * t) / apart) / (2 + apart)
    np.testing.assert_allclose(run.sample(t)[0][0], exact, atol=1e-14 + 4e-16 / apart)


def exact_pull(mass, stiffness, force, t):
    """The positions at t under a constant force, from rest, with 60 digits."""
    mpmath = pytest.importorskip("mpmath")
    with mpmath.workdps(60):
        n = len(mass)
        roots = [mpmath.sqrt(mpmath.mpf(float(m))) for m in mass]
        a = mpmath.matrix(n, n)
        for i in range(n):
            for j in range(n):
                a[i, j] = mpmath.mpf(float(stiffness[i, j])) / (roots[i] * roots[j])
        squares, shapes = mpmath.eigsy(a)
        pull = shapes.T * mpmath.matrix([mpmath.mpf(float(force[i])) / roots[i] for i in range(n)])
        share = [
            (1 - mpmath.cos(mpmath.sqrt(w) * t)) / w if abs(w) > 1e-40 else mpmath.mpf(t) ** 2 / 2
            for w in squares
        ]
        y = shapes * mpmath.matrix([p * s for p, s in zip(pull, share, strict=True)])
        return np.array([float(y[i] / roots[i]) for i in range(n)])


@pytest.mark.parametrize("free", [False, True])
@pytest.mark.parametrize("tiny", [1e-3, 1e-6, 1e-9, 1e-12])
@pytest.mark.parametrize(("n", "at"), [(3, 0), (3, 1), (5, 2), (8, 0), (8, 4), (8, 7)])
def test_very_light_bodies(n, at, tiny, free):
    """A very light body does not cost the slow modes of a chain digits, nor a free chain its rigid mode."""
    stiffness = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    if free:
        stiffness[0, 0] = stiffness[-1, -1] = 1
    mass, force = np.ones(n), np.eye(n)[(at + 1) % n]
    mass[at] = tiny
    s = vi.Structure(mass, np.zeros(n), stiffness, [])
    run = vi.simulate(s, vi.Load(None, constant=force), duration=3)
    known = exact_pull(mass, stiffness, force, 3)
    assert np.abs(run.sample([3])[0][:, 0] - known).max() < 1e-12 * np.abs(known).max()


@pytest.mark.parametrize("n", [3, 5, 8])
@pytest.mark.parametrize("stiff", [1e2, 1e4, 1e6, 1e7, 1e8, 1e9, 1e10, 1e12])
def test_very_stiff_springs(n, stiff):
    """A spring that is too stiff is refused, by name, before fewer than 7 digits are left."""
    springs = np.ones(n + 1)
    springs[n // 2] = stiff
    stiffness = np.diag(springs[:-1] + springs[1:])
    stiffness -= np.diag(springs[1:-1], 1) + np.diag(springs[1:-1], -1)
    force = np.eye(n)[0]
    s = vi.Structure(np.ones(n), np.zeros(n), stiffness, [])
    load = vi.Load(None, constant=force)
    if stiff >= 1e9 or (stiff, n) == (1e8, 8):
        with pytest.raises(vi.SingularError, match="stiffnesses differ so much"):
            vi.simulate(s, load, duration=3)
        return
    run = vi.simulate(s, load, duration=3)
    known = exact_pull(np.ones(n), stiffness, force, 3)
    off = np.abs(run.sample([3])[0][:, 0] - known).max() / np.abs(known).max()
    assert off < 4 * stiff * np.finfo(float).eps
    assert off < 1e-7


def test_rest_does_not_depend_on_the_units_of_coordinates():
    ends = []
    for unit in (1.0, 1e-3, 1e-9, 1e6):
        scale = np.array([1.0, unit])
        gaps = [vi.Gap([-1, unit], 3, 0.75), vi.Gap([1, -unit], 3, 0.61)]
        mass = np.array([1, 0.028]) * scale**2
        run = vi.simulate(
            vi.Structure(mass, [0.0228, 0], [1, 0], gaps), vi.Load(0.9, sine=[1, 0]), cycles=40
        )
        ends.append(run.events["time"][run.events["kind"] == "stick"])
    for other in ends[1:]:
        # the impacts before a rest amplify rounding errors
        np.testing.assert_allclose(other, ends[0], rtol=1e-9)


@pytest.mark.parametrize("tiny", [1e-8, 1e-12, 1e-16, 1e-24, 1e-100])
@pytest.mark.parametrize("of", ["damping", "stiffness"])
def test_rates_that_differ_by_many_orders(tiny, of):
    """A damping or stiffness far below all others neither changes nor adds an event."""
    matrices = {"damping": [0.02, 0.0, 0.0], "stiffness": [1.0, 3.0, 0.0]}

    def events(**changed):
        gaps = [vi.Gap([-1, 0, 1], 0.5, 0.8), vi.Gap([1, 0, -1], 0.5, 0.8), vi.Gap([0, 1, 0], 10.0)]
        s = vi.Structure([1, 1, 0.1], **(matrices | changed), gaps=gaps)
        return vi.simulate(s, duration=15, state=([1, 1, 1], [0, 0.5, 0])).events

    plain = events()
    assert len(plain) > 5
    assert (plain["gap"] < 2).all()
    place = {"damping": 1, "stiffness": 2}[of]
    other = events(**{of: [tiny if i == place else x for i, x in enumerate(matrices[of])]})
    assert other["gap"].tolist() == plain["gap"].tolist()
    np.testing.assert_allclose(other["time"], plain["time"], rtol=1e-11 + 1e3 * tiny)


def test_a_dashpot_between_the_ends_of_a_free_chain():
    """Rounding gives the mode in which the ends move alike a damping far below all others."""
    stiffness = [[1, -1, 0], [-1, 2, -1], [0, -1, 1]]
    damping = 0.1 * np.array([[1, 0, -1], [0, 0, 0], [-1, 0, 1]])
    for direction in ([1, 0, 0], [0, 1, 0], [0, 0, 1], [1, -1, 0], [1, 0, -1]):
        s = vi.Structure([1, 1, 1], damping, stiffness, [vi.Gap(direction, 10)])
        assert len(vi.simulate(s, duration=20, state=([1, 1, 0.9], [0, 0, 0.3])).events) == 0


def test_samples_after_many_cycles():
    """With a period of 4, whole periods are exact: late samples are those of the first cycles."""
    gaps = [vi.Gap([-1, 1], 0.5, 0.8), vi.Gap([1, -1], 0.5, 0.8)]
    host = vi.Structure([1, 0.1], [0.02, 0], [1, 0], gaps)
    load = vi.Load(math.pi / 2, sine=[[1, 0], [0.2, 0]])
    late = 4.0 * 2**20
    first, other = (vi.simulate(host, load, duration=64, start=start) for start in (0.0, late))
    assert len(first.events) > 20
    assert np.array_equal(first.states, other.states)
    t = np.arange(0, 64, 2.0**-6)
    early, later = (np.array(run.sample(t + run.start)) for run in (first, other))
    free = t < first.events["time"][0]
    assert np.array_equal(early[..., free], later[..., free])
    # an impact that is rounded to the other side of a sample changes the velocities there
    near = np.abs(t[:, None] - first.events["time"]).min(axis=1) < 1e-6
    assert np.abs(early - later)[..., ~near].max() < 16 * np.spacing(late)


@pytest.mark.parametrize("scale", [1e-200, 1e-60, 1e60, 1e200])
@pytest.mark.parametrize("of", ["length", "mass", "time"])
def test_extreme_units_are_refused(scale, of):
    """Units whose powers underflow or overflow, so that impacts are missed, are refused; others change nothing."""

    def simulated(unit):
        m, d, t = (unit if name == of else 1.0 for name in ("mass", "length", "time"))
        gaps = [vi.Gap([-1, 1], 0.5 * d, 0.8), vi.Gap([1, -1], 0.5 * d, 0.8)]
        stiffness = m / t / t
        s = vi.Structure([m, 0.1 * m], [0.02 * m / t, 0], [stiffness, 0], gaps)
        return vi.simulate(s, vi.Load(1.1 / t, sine=[0.1 * d * stiffness, 0]), cycles=20)

    wanted = "choose other units|finite|eigenvalue|duration|definite|from -1e100 to 1e100"
    with pytest.raises((vi.SingularError, vi.ParameterError), match=wanted):
        simulated(scale)
    for unit in (2.0**-30, 2.0**30):
        events = simulated(unit).events
        time = unit if of == "time" else 1.0
        assert np.array_equal(events["time"] / time, simulated(1.0).events["time"])
