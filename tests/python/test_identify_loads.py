"""Identification under loads that are not periodic: sweeps, beats and noise, used as recorded.

The records are those of `reference_rig`, which shares no code with the package: a load is a sum of sines, flights
are exact, and both channels are noisy.
"""

import functools
import math
from dataclasses import replace

import numpy as np
import pytest
import vibroimpact as vi
from reference_rig import K, M, loaded_rig, record
from scipy.signal import butter, sosfilt
from vibroimpact.identification import aperiodic, steps
from vibroimpact.identification.aperiodic import Impacts
from vibroimpact.identification.coupled import Covariance, banded, own_blocks
from vibroimpact.identification.forced import STEP, Forced, mean_frequency, noise_of
from vibroimpact.identification.signals import centred
from vibroimpact.identification.waves import Measured, of_load, turns_of

RATE, OMEGA = 5000.0, 2 * math.pi * 19.5
LOADS = ("sweep", "beat", "noise")
PARAMETERS = ("xi", "mu", "R1", "R2", "d")


def of_frequencies(hertz, noise=0.0):
    """A record of 4 s whose load is a sum of sines of 2 N, and the sines' angular frequencies."""
    t = centred(20000, RATE)
    w = 2 * math.pi * np.array(hertz)
    load = 2 * np.sin(np.outer(w, t) + np.arange(w.size)[:, None]).sum(axis=0)
    load += noise * np.random.default_rng(3).standard_normal(t.size)
    return vi.SensorRecord(RATE, load=load, acceleration=np.cos(t)), w


@pytest.mark.parametrize("order", [0, 1, 2])
def test_the_response_to_a_sine_is_the_steady_one_but_for_a_free_vibration(order):
    measured, (w,) = of_frequencies([20.3])
    forced, data = Forced(measured, "acceleration", w), Measured(w, 1)
    at = order, 124.7, 0.0114, 2e-4, 0.05
    rows = forced.rows(*at)
    # amplitude and phase of the load at the middle of the record
    assert forced.F0 == pytest.approx(2.0, rel=1e-3)
    steady = forced.F0 / 2.0 * rows[0] - of_load(data, *at)[0] @ turns_of(data, w * forced.times)
    pole = 124.7 * complex(-0.0114, math.sqrt(1 - 0.0114**2))
    wave = np.exp(pole * forced.times)
    free = np.column_stack([wave.real, wave.imag])
    left = steady - free @ np.linalg.lstsq(free, steady, rcond=None)[0]
    inner = slice(1000, -1000)
    assert abs(left[inner]).max() < 2e-5 * abs(rows[0]).max()


def test_the_response_obeys_newtons_law_at_all_times():
    measured, w = of_frequencies([17.2, 19.9, 23.1])
    forced = Forced(measured, "acceleration", float(w.mean()))
    t = np.linspace(-1.5, 1.5, 777)
    X, V = forced.at(124.7, 0.0114, 1.0, 0.2, t)
    A = forced.at(124.7, 0.0114, 1.0, 0.2, t, 1)[1]
    load = forced.load_at(0.2, t)
    assert 124.7**2 * (load - X) - 2 * 0.0114 * 124.7 * V == pytest.approx(
        A, abs=1e-9 * abs(A).max()
    )
    true = 2 * np.sin(np.outer(t + 0.2 / w.mean(), w) + np.arange(3)).sum(axis=1)
    assert forced.F0 * load == pytest.approx(true, abs=2e-3)


def test_derivatives_of_the_response_are_those_of_differences():
    measured, w = of_frequencies([17.2, 19.9])
    forced = Forced(measured, "acceleration", float(w.mean()))
    t = np.linspace(-1.0, 1.0, 101)
    at = np.array([124.7, 0.0114, 1.3, 0.2])
    rows = forced.rows(0, *at)
    for i, size in enumerate((1e-3, 1e-6, 1e-4, 1e-5)):
        up, down = (at + sign * size * np.eye(4)[i] for sign in (1, -1))
        difference = (forced.rows(0, *up)[0] - forced.rows(0, *down)[0]) / (2 * size)
        assert rows[1 + i] == pytest.approx(difference, abs=1e-6 * abs(difference).max())
        exact = forced.at(*(at + 1j * STEP * np.eye(4)[i]), t)[0].imag / STEP
        slope = (forced.at(*up, t)[0] - forced.at(*down, t)[0]) / (2 * size)
        assert exact == pytest.approx(slope, abs=1e-5 * abs(slope).max())
    # and by time
    exact = forced.at(*at, t + 1j * STEP)[0].imag / STEP
    assert exact == pytest.approx(forced.at(*at, t)[1], abs=1e-7 * abs(exact).max())


def test_the_noise_of_a_load_is_measured_and_its_parts_have_its_power():
    measured, w = of_frequencies([17.2, 19.9, 23.1], 0.05)
    forced = Forced(measured, "acceleration", float(w.mean()))
    assert forced.noise == pytest.approx(0.05, rel=0.05)
    clean = of_frequencies([17.2, 19.9, 23.1])[0].load
    assert forced.F0 == pytest.approx(math.sqrt(2) * clean.std(), rel=1e-3)
    lines, sizes = forced.of_noise(124.7)
    # of white noise below twice the natural frequency: the share of the band in the power
    band = 1.95 * 124.7 / (math.pi * RATE)
    power = (forced.noise / forced.F0) ** 2 * band
    assert (abs(sizes) ** 2).sum() / 2 == pytest.approx(power, rel=5e-3)
    assert 0 < lines.min() < lines.max() < 2 * 124.7


@functools.cache
def found_in(seed, load):
    """What `identify` finds in a record, with the true parameters."""
    rig, (_, force, motion, _) = loaded_rig(seed, load)
    found = vi.identify(rate=rig.rate, load=force, acceleration=motion, known={"M": M, "K": K})
    R1, R2 = rig.restitution
    return found, {"xi": rig.xi, "mu": rig.mu, "R1": R1, "R2": R2, "d": rig.d}


def deviations(found, true):
    """Deviations of the parameters in standard errors."""
    return np.array([(found.values[name] - true[name]) / found.errors[name] for name in PARAMETERS])


@pytest.mark.parametrize("load", [pytest.param("sweep", marks=pytest.mark.slow), "beat",
                                  pytest.param("noise", marks=pytest.mark.slow)])  # fmt: skip
def test_a_load_of_any_form_gives_all_parameters(load):
    found, true = found_in(4, load)
    assert found.status == "not periodic"
    assert found.good
    assert not found.undetermined
    assert abs(deviations(found, true)).max() < 3
    # hundreds of impacts determine the parameters well
    assert found.errors["mu"] < 3e-3 * true["mu"]
    assert found.errors["xi"] < 5e-3 * true["xi"]
    assert any("used as recorded" in note for _, note in found._result.notes)


@pytest.mark.slow
@pytest.mark.parametrize("load", LOADS)
def test_intervals_cover_the_truth(load, share):
    """Of 20 records with each load nearly all are identified, none wrong in silence."""
    every = []
    seeds = range(max(2, share(20)))
    for seed in seeds:
        found, true = found_in(seed, load)
        assert not found.undetermined
        if found.good:
            every.append(deviations(found, true))
    assert len(every) >= 0.9 * len(seeds)
    size = abs(np.array(every))
    assert size.max() < 4
    # of independent parameters, four standard errors of these shares
    n = size.size
    for width, share_of in ((1.0, 0.683), (1.96, 0.95)):
        assert (size < width).mean() > share_of - 4 * math.sqrt(share_of * (1 - share_of) / n)


@pytest.mark.slow
def test_the_noise_of_a_load_is_part_of_the_errors_and_of_the_misfit(monkeypatch):
    """The response to noise near the natural frequency lasts much longer than a flight."""
    with_noise, _ = found_in(4, "beat")
    monkeypatch.setattr(Forced, "of_noise", lambda *_: (np.zeros(0), np.zeros(0, dtype=complex)))
    found_in.cache_clear()
    plain, _ = found_in(4, "beat")
    found_in.cache_clear()
    assert with_noise.misfit < plain.misfit
    assert with_noise.errors["mu"] > plain.errors["mu"]


@pytest.mark.slow
def test_noise_of_a_load_adds_little_information(monkeypatch):
    """The noise of a load changes the equations less than that of the motion, whose spurious information is small:
    this is why that of the load is not determined. The derivatives with respect to it leave the data unchanged."""
    kept, noise_information, by_noise = [], aperiodic.noise_information, Impacts.by_noise

    def noted(equations, here, spread, shared, seed):
        of_noise = noise_information(equations, here, spread, shared, seed)
        kept.append((equations(here), spread, shared, of_noise))
        return of_noise

    def same_load(impacts, *parts):
        data, of_motion = impacts.windows.data, Impacts.constraints
        forced = data.forced

        def constraints(one, *of):
            assert one.windows.data is data
            assert data.forced is forced
            return of_motion(one, *of)

        with monkeypatch.context() as patch:
            patch.setattr(Impacts, "constraints", constraints)
            return by_noise(impacts, *parts)

    monkeypatch.setattr(aperiodic, "noise_information", noted)
    monkeypatch.setattr(Impacts, "by_noise", same_load)
    rig, (_, force, motion, _) = loaded_rig(4, "beat")
    assert vi.identify(rate=rig.rate, load=force, acceleration=motion, known={"M": M, "K": K}).good
    (A, through, G, ok), spread, shared, of_noise = kept[-1]
    own = np.trace(own_blocks(A, spread, ok)[ok], axis1=1, axis2=2)
    of_load = (shared**2).sum(axis=1).reshape(-1, 2).sum(axis=1)[ok]
    assert 0 < np.median(of_load / own) < 0.1
    B = np.concatenate([through, G], axis=-1).reshape(2 * len(A), -1)
    cov = Covariance(banded(A, spread, ok), shared * np.repeat(ok, 2)[:, None])
    information = B.T @ cov.solve(B)
    scale = 1 / np.sqrt(np.diag(information))
    size, axes = np.linalg.eigh(information * np.outer(scale, scale))
    root = axes / np.sqrt(np.maximum(size, 1e-12))
    share = np.linalg.eigvalsh(root.T @ (of_noise * np.outer(scale, scale)) @ root)
    assert share.max() < 0.01


@pytest.mark.parametrize("load", LOADS)
def test_channels_in_the_wrong_order_are_refused(load):
    rig, (_, force, motion, _) = loaded_rig(4, load)
    with pytest.raises(vi.ParameterError, match=r"load with \d+ abrupt changes.*wrong order"):
        vi.identify(rate=rig.rate, load=motion, acceleration=force)


@pytest.mark.parametrize("lost", [110, 120])
def test_missing_samples_are_no_load_of_another_form(lost):
    """Both channels lack the same samples: a sine then has a jump of its phase, as no shaker makes it."""
    rig, _ = loaded_rig(4, "beat")
    rig = replace(rig, lines=((1.0, 1.0, 0.0),))
    _, force, motion, _ = record(rig, 0, settle=100)
    kept = np.delete(np.arange(force.size), slice(8000, 8000 + lost))
    with pytest.raises(vi.ParameterError, match=r"abrupt change.*samples may be missing"):
        vi.identify(rate=rig.rate, load=force[kept], acceleration=motion[kept])


def test_the_noise_of_a_load_behind_a_filter_is_measured():
    """And at low rates, where no frequencies above those of the load are left."""
    low, _ = of_frequencies([17.2, 19.9, 23.1])
    noise = 0.1 * np.random.default_rng(2).standard_normal(len(low))
    passed = sosfilt(butter(4, 250.0, fs=RATE, output="sos"), noise)
    assert noise_of(low.load + passed, RATE) == pytest.approx(0.1, rel=0.2)
    for several in (8, 11):
        some = (low.load + noise)[::several]
        assert noise_of(some, RATE / several) == pytest.approx(0.1, rel=0.25)


def test_noise_does_not_change_the_mean_frequency():
    measured, w = of_frequencies([17.2, 19.9, 23.1], 0.7)
    assert mean_frequency(measured.load, RATE) == pytest.approx(w.mean(), rel=2e-3)


T = centred(20000, RATE)
SINE = np.sin(OMEGA * T) + 0.2 * np.sin(2 * OMEGA * T)


@pytest.mark.parametrize(
    ("load", "of_any_form"),
    [
        (SINE + 0.4 * np.random.default_rng(1).standard_normal(T.size), False),
        (SINE * (1 + 0.05 * T), False),  # it grows by 20 %
        (SINE + 0.5 * np.sin(2 * math.pi * 50 * T), False),  # hum of the channel
        (np.sin(OMEGA * T) + 1.3 * np.sin(2 * OMEGA * T), True),
        (np.sin(OMEGA * T + 3 * T**2), True),
        (np.sin(OMEGA * T) + 0.8 * np.sin(1.05 * OMEGA * T), True),
    ],
    ids=["noise", "growth", "hum", "harmonic", "sweep", "beat"],
)
def test_which_loads_are_used_as_recorded(load, of_any_form):
    """A motion that repeats under a load with hum, and one like the load otherwise."""
    motion = np.cos(OMEGA * T) if not of_any_form else np.gradient(load)
    assert steps.no_sine(load, motion, RATE, OMEGA) == of_any_form


def test_a_given_frequency_is_that_of_a_sine():
    rig, (_, force, motion, _) = loaded_rig(4, "beat")
    with pytest.raises(vi.ParameterError, match="without a given frequency, a load of any form"):
        vi.identify(rate=rig.rate, load=force, acceleration=motion, frequency=rig.frequency)
