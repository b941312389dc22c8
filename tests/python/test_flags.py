"""`stability_flags` and `periodic_batch` on many points, compared with a chain of LAPACK calls."""

import sys

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact import _core
from vibroimpact.motions import flags
from vibroimpact.motions.periodic import impact_restitution


def columns(rng, n, m, cycles):
    """Random impact phases (n, m)."""
    gaps = rng.uniform(0.05, 1.0, (n, m))
    gaps *= 2 * np.pi * cycles / gaps.sum(axis=0)
    return np.vstack([np.zeros(m), np.cumsum(gaps, axis=0)[:-1]])


def systems(seed, count, most):
    """Random oscillators and patterns, including the ends of the parameter ranges."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        n = int(rng.integers(2, most + 1))
        xi = rng.choice([0.0, 10 ** rng.uniform(-3, -1), rng.uniform(0.1, 0.95)], p=[0.1, 0.7, 0.2])
        mu = rng.choice([0.0, 10 ** rng.uniform(-3, 0.5)], p=[0.1, 0.9])
        walls = rng.choice([0.0, 1.0, rng.uniform(0.1, 1.0)], 2, p=[0.1, 0.1, 0.8])
        sides = "".join(rng.permutation(["R", "L", *rng.choice(["R", "L"], n - 2)]))
        osc = vi.Oscillator(xi=float(xi), mu=float(mu), restitution=tuple(map(float, walls)))
        yield rng, osc, vi.Pattern(sides, int(rng.integers(1, 4)))


def same_bits(one, other):
    """Whether two results of the core are equal to the last bit."""
    return all(
        np.asarray(a).tobytes() == np.asarray(b).tobytes() for a, b in zip(one, other, strict=True)
    )


def sensitivity(rng, osc, r, phases, pattern, radius):
    """Change of LAPACK's spectral radius when the last bits of r and the phases change."""
    many = np.repeat(phases[:, np.newaxis], 128, axis=1)
    many += rng.integers(-2, 3, many.shape) * np.spacing(many) * (many > 0)
    ratios = r + rng.integers(-2, 3, 128) * np.spacing(r)
    moved = vi.periodic_batch(osc, ratios, many, pattern, flights=False)
    return np.abs(np.abs(moved.multipliers[0]) / radius - 1).max()


@pytest.mark.slow
def test_a_million_points_agree_with_lapack():
    m, referred, compared, far = 5_000, 0, 0, 0
    for rng, osc, pattern in systems(seed=1, count=200, most=6):
        phases = columns(rng, len(pattern), m, pattern.cycles)
        r = np.exp(rng.uniform(np.log(0.2), np.log(5.0), m))
        r[np.abs(r - 1) < 1e-2] = 0.7
        lapack = vi.periodic_batch(osc, r, phases, pattern, flights=False)
        fast = vi.stability_flags(osc, r, phases, pattern, spectral_radius=True)
        radius = np.abs(lapack.multipliers[0])
        assert np.array_equal(fast.status, lapack.status)
        assert np.array_equal(fast.consistent, lapack.consistent)
        # rounding decides on the circle, and either answer is valid
        clear = ~(np.abs(radius - 1) < 1e-9)
        assert np.array_equal(fast.stable[clear], lapack.stable[clear])
        assert np.array_equal(np.isnan(fast.spectral_radius), np.isnan(radius))
        known = ~np.isnan(radius)
        apart = np.abs(fast.spectral_radius / radius - 1)
        for j in np.flatnonzero(known & (apart > 1e-11)):
            assert apart[j] < 10 * sensitivity(rng, osc, r[j], phases[:, j], pattern, radius[j])
            far += 1
        # without the radius fewer points are passed to LAPACK, with the same verdicts
        plain = vi.stability_flags(osc, r, phases, pattern)
        assert plain.spectral_radius is None
        assert plain.referred <= fast.referred
        assert np.array_equal(plain.stable[clear], lapack.stable[clear])
        compared += m
        referred += plain.referred
    assert compared == 1_000_000
    assert referred < 0.1 * compared
    assert far < 1e-4 * compared


def test_same_bits_on_any_number_of_threads_and_in_any_company():
    for rng, osc, pattern in systems(seed=2, count=10, most=5):
        m = 1000
        phases = columns(rng, len(pattern), m, pattern.cycles)
        r = rng.uniform(1.1, 1.4, m)
        each = impact_restitution(osc, pattern, None)

        def core(order, threads, wide):
            return _core.stability_flags(
                osc.xi, osc.mu, osc.restitution, r[order], pattern.cycles, pattern.signs, each,  # noqa: B023
                np.ascontiguousarray(phases[:, order]).T, 0.03, True, threads, wide,  # noqa: B023
            )  # fmt: skip

        everything = np.arange(m)
        answer = core(everything, 1, False)
        assert same_bits(answer, core(everything, 2, False))
        assert same_bits(answer, core(everything, 3, True))
        order = rng.permutation(m)[:77]
        assert same_bits([column[order] for column in answer[:4]], core(order, 1, True)[:4])


def test_chunks_do_not_show(monkeypatch):
    rng = np.random.default_rng(3)
    osc, pattern = vi.Oscillator(xi=0.01, mu=0.05, restitution=(0.7, 0.6)), vi.Pattern("RRL")
    phases, r = columns(rng, 3, 1000, 1), rng.uniform(0.8, 0.95, 1000)
    whole = vi.stability_flags(osc, r, phases, pattern, spectral_radius=True)
    monkeypatch.setattr(flags, "CHUNK", 37)
    parts = vi.stability_flags(osc, r, phases, pattern, spectral_radius=True)
    for name in ("consistent", "stable", "status", "spectral_radius", "referred"):
        assert (
            np.asarray(getattr(whole, name)).tobytes() == np.asarray(getattr(parts, name)).tobytes()
        )
    with pytest.raises(ValueError, match=r"phases\[:, 40\]"):
        vi.stability_flags(osc, r, np.where(np.arange(1000) == 40, 7.0, phases), pattern)


@pytest.mark.parametrize(
    ("osc", "r", "pattern", "phases", "status"),
    [
        (vi.Oscillator(xi=0.01, mu=0.05, restitution=0.7), 0.9, "RL", [0.0, np.pi], 2),
        (vi.Oscillator(xi=0.01, mu=0.05, restitution=(0.7, 0.6)), 1e-6, "RL", [0.0, 3.0], 0),
        (vi.Oscillator(xi=0.01, mu=0.05, restitution=(0.7, 0.6)), 1e6, "RL", [0.0, 3.0], None),
        (
            vi.Oscillator(xi=0.9, mu=0.05, restitution=(0.7, 0.6)),
            1e-3,
            "RRL",
            [0.0, 3.0, 5.0],
            None,
        ),
        (
            vi.Oscillator(xi=0.01, mu=0.05, restitution=(0.7, 0.6)),
            0.9,
            "RL" * 9,
            np.arange(18.0) / 3,
            0,
        ),
    ],
)
def test_extremes_are_lapacks(osc, r, pattern, phases, status):
    phases = np.tile(np.asarray(phases)[:, np.newaxis], 3)
    pattern = vi.Pattern(pattern)
    fast = vi.stability_flags(osc, r, phases, pattern, spectral_radius=True)
    lapack = vi.periodic_batch(osc, r, phases, pattern, flights=False)
    assert status is None or fast.status.tolist() == [status] * 3
    assert fast.referred == 3
    for name in ("consistent", "stable", "status"):
        assert np.array_equal(getattr(fast, name), getattr(lapack, name))
    # numpy's modulus of a complex number may differ from Fortran's in the last bit
    radius = np.abs(lapack.multipliers[0])
    np.testing.assert_allclose(fast.spectral_radius, radius, rtol=1e-15)


def test_bad_input():
    good = {
        "osc": vi.Oscillator(xi=0.01, mu=0.05, restitution=(0.7, 0.6)),
        "r": 0.9,
        "phases": [[0.0, 0.0], [3.0, 3.1]],
        "pattern": vi.Pattern("RL"),
    }
    assert len(vi.stability_flags(**good)) == 2
    for name, value in {
        "r": [0.9, -1.0],
        "phases": [[0.0, 0.0], [3.0, 6.3]],
        "acceptance": 2.0,
        "threads": 0,
        "restitution": [0.5, 1.5],
        "pattern": vi.Pattern("RL*"),
    }.items():
        with pytest.raises(vi.errors.ParameterError, match=name):
            vi.stability_flags(**good | {name: value})
    with pytest.raises(vi.errors.ParameterTypeError, match="osc"):
        vi.stability_flags(**good | {"osc": 3})
    with pytest.raises(vi.errors.ParameterError, match=r"shape \(2,\)"):
        vi.stability_flags(**good | {"phases": [0.0, 3.0]})


@pytest.mark.parametrize("name", ["stability_flags", "periodic_batch"])
def test_progress_changes_no_bit(name, monkeypatch):
    """The share rises to 1 over the calls of the core, and the parts add up to the whole."""
    osc, phases = (
        vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75),
        columns(np.random.default_rng(3), 3, 500, 1),
    )
    verb, shares = getattr(vi, name), []
    whole = verb(osc, 0.94, phases, "RRL")
    monkeypatch.setattr(flags, "CHUNK", 128)
    monkeypatch.setattr(sys.modules["vibroimpact.motions.periodic"], "CHUNK", 128)
    parts = verb(osc, 0.94, phases, "RRL", progress=lambda share, what: shares.append(share))
    assert shares == [128 / 500, 256 / 500, 384 / 500, 1.0]
    for one in (
        "consistent",
        "stable",
        "status",
        *(("X", "x_max", "multipliers") if name == "periodic_batch" else ()),
    ):
        assert getattr(parts, one).tobytes() == getattr(whole, one).tobytes()
    with pytest.raises(ZeroDivisionError):
        verb(osc, 0.94, phases, "RRL", progress=lambda share, what: 1 / 0)
    with pytest.raises(vi.ParameterTypeError, match="progress = 3"):
        verb(osc, 0.94, phases, "RRL", progress=3)
