"""Identification of rigs that change during the record, and of records whose flights are not what they should be:
nothing is wrong in silence."""

import warnings
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import vibroimpact as vi

pytest.importorskip("scipy")
from reference_rig import K, M, chaotic_rig, random_rig, record
from vibroimpact.identification import tables, windows
from vibroimpact.identification.signals import centred, changed, load_frequency, tones
from vibroimpact.identification.steps import growth_of


def identified(rig, seed, **known):
    """The result for a rig with known M and K, without the warning about a poor fit."""
    _, load, acceleration, _ = record(rig, seed)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", vi.PoorFitWarning)
        return vi.identify(
            rate=rig.rate, load=load, acceleration=acceleration, known={"M": M, "K": K, **known}
        )


@pytest.mark.parametrize(
    ("change", "size", "seed", "kind", "said"),
    [
        ("fading", 0.01, 3, "defg", "R1 and R2 seem to fall by"),
        ("load_growth", 0.01, 5, "defg", "the load grows by"),
        ("gain_growth", 0.03, 3, "defg", "the gain of the motion sensor, seems to grow by"),
    ],
)
def test_what_changes_during_a_chaotic_record_is_named(change, size, seed, kind, said):
    """A load, restitution or gain that changes by some per cent is doubted, with its size to within a third."""
    found = identified(replace(chaotic_rig(seed, kind)[0], **{change: size}), seed)
    assert found.status == "not periodic"
    assert not found.good
    doubt = next(doubt for doubt in found.doubts if said in doubt)
    assert float(doubt.split(said)[1].split()[0]) == pytest.approx(100 * size, rel=0.33)


@pytest.mark.slow
def test_a_steady_chaotic_record_raises_no_doubt():
    """Without the change, the same rig raises no doubt."""
    found = identified(chaotic_rig(5, "defg")[0], 5)
    assert found.good
    assert found.doubts == ()


@pytest.mark.parametrize(("seed", "kind"), [(0, "abc"), (2, "defg")])
def test_the_parameters_of_a_changing_periodic_motion_are_those_of_its_middle(seed, kind):
    """R falls by 1 % and the gain grows by 0.5 %: the motion of the middle is exact to within the noise, and its
    parameters are within four errors, although no motion describes the mean of the record."""
    rig, _, k, sides = random_rig(seed, kind)
    rig = replace(rig, fading=0.01, gain_growth=0.005, noise=0.004)
    found = identified(rig, seed, m=M * rig.mu)
    assert found.good
    assert found.pattern == vi.Pattern(sides, k).standard()
    assert any("the parameters are those of its middle" in note for _, note in found._result.notes)
    true = {"xi": rig.xi, "R1": rig.restitution[0], "R2": rig.restitution[1], "d": rig.d}
    for name, value in true.items():
        assert abs(found.values[name] - value) < 4 * found.errors[name], name


def test_a_slow_change_leaves_the_middle_of_a_signal_and_its_noise():
    """What is subtracted from a periodic signal whose size is a quadratic polynomial of time is its change since
    the middle, to within the noise; the noise that remains is that of the signal, by the factor returned."""
    rate, n, random = 2000.0, 12000, np.random.default_rng(0)
    t = centred(n, rate)
    shape, since = np.cos(2 * np.pi * 17.3 * t) ** 3, 2 * t / (t[-1] - t[0])
    noise = 1e-3 * random.standard_normal(n)
    growth = 0.02 * since - 0.01 * since**2
    slow, factor = changed(shape * (1 + growth) + noise, rate, 2 * np.pi * 17.3, 1)
    assert np.std(slow - shape * growth) < 0.5e-3
    left = shape * growth + noise - slow
    assert np.std(left) * factor**0.5 == pytest.approx(1e-3, rel=0.02)


@pytest.mark.slow
def test_a_growing_load_of_an_almost_periodic_motion_is_a_doubt():
    """Slow chaos that a load which grows by 1 % makes look like a motion of few cycles is refused, or the growth
    is named."""
    named = 0
    for seed in (3, 6):
        rig, _ = chaotic_rig(seed, "hi")
        try:
            found = identified(replace(rig, load_growth=0.01), seed)
        except vi.SingularError:
            continue
        assert any("the load grows by 1 %" in doubt for doubt in found.doubts)
        named += 1
    assert named >= 1


@pytest.mark.slow
def test_a_period_that_leaves_all_open_is_doubted():
    """Chaos that a sensor with a growing gain makes look like RLRL/2: the fit tells neither mass nor restitution,
    and its period is doubted."""
    rig = replace(chaotic_rig(3, "other")[0], gain_growth=0.03, duration=2.2)
    found = identified(rig, 3)
    assert {"mu", "R1", "R2", "d"} <= set(found.undetermined)
    assert not found.good
    assert any("the motion may not be periodic" in doubt for doubt in found.doubts)


@pytest.mark.slow
def test_a_growth_of_the_load_is_measured():
    """The share of the change is within five of its own errors, and zero where nothing changes."""
    rig, _, _, _ = random_rig(0, "abc")
    for share in (0.0, 0.004):
        _, load, _, _ = record(replace(rig, load_growth=share), 0)
        found, size = growth_of(
            load, rig.rate, tones(load, rig.rate, load_frequency(load, rig.rate), 12)
        )
        error = abs(found / size)
        assert error < 5e-4
        assert abs(found - share) < 5 * error


def test_a_periodic_motion_bears_a_gain_within_its_calibration():
    """A load cell whose gain grows by 2 % beside a steady motion: no doubt if gains are uncertain by 1 %, one if
    they are exact."""
    rig, (_, load, acceleration, _), _, _ = random_rig(0, "abc")
    growing = load * (1 + 0.02 * np.linspace(-0.5, 0.5, load.size))
    given = {"rate": rig.rate, "load": growing, "acceleration": acceleration}
    known = {"M": M, "K": K, "m": M * rig.mu}
    said = "the load grows by 2 % during the record"
    found = vi.identify(**given, known=known)
    assert found.good
    assert any(said in note for _, note in found._result.notes)
    with pytest.warns(vi.PoorFitWarning, match=said):
        vi.identify(**given, known=known, calibration=0)


@pytest.mark.slow
def test_ringing_is_found_at_two_samples_a_millisecond(monkeypatch):
    """At 2 kHz a mode of 250 Hz rings after contacts of 1.5 ms: it is found, and no parameter is four stated
    errors off. Where it is not looked for, what it leaves just after impacts is a doubt."""
    rig = replace(
        chaotic_rig(4, "abc")[0], rate=2000.0, contact=1.5e-3, ringing=253.5, ring_decay=82.0, ring_share=0.3,
        noise=0.02, calibration=0.0,
    )  # fmt: skip
    found = identified(rig, 4)
    assert found.good
    true = {
        "xi": rig.xi,
        "mu": rig.mu,
        "R1": rig.restitution[0],
        "R2": rig.restitution[1],
        "d": rig.d,
    }
    for name, value in true.items():
        assert abs(found.values[name] - value) < 4 * found.errors[name], name
    monkeypatch.setattr(windows, "LEAST_BINS", 100)
    found = identified(rig, 4)
    assert not found.good
    assert any("ringing was not detected as a mode" in note for _, note in found._result.notes)


def test_an_unstable_motion_is_a_doubt(monkeypatch):
    """An unstable motion is doubted, however well it describes the record."""
    rig, _, _, _ = random_rig(0, "abc")
    assert identified(rig, 0, m=M * rig.mu).good
    unstable = SimpleNamespace(multipliers=np.array([1.2, 0.5, 0.5, 0.1], dtype=complex))
    monkeypatch.setattr(tables, "verified", lambda *given: unstable)
    found = identified(rig, 0, m=M * rig.mu)
    assert not found.good
    assert "the motion is unstable (its largest multiplier is 1.2)" in found.doubts[0]


@pytest.mark.slow
def test_a_period_longer_than_a_short_record_shows_is_found():
    """Nine periods of four load cycles, the halves of which are nearly alike: the record denies two cycles, and
    has enough periods of four that leave clearly less scatter."""
    rig, (_, load, acceleration, _), k, sides = random_rig(1167, "other")
    assert (k, sides) == (4, "LRLRLRLR")
    found = vi.identify(
        rate=rig.rate, load=load, acceleration=acceleration, known={"M": M, "K": K, "m": M * rig.mu}
    )
    assert found.good
    assert found.misfit < 1.1
    assert found.pattern == vi.Pattern("RL" * 4, 4)
    true = {"xi": rig.xi, "R1": rig.restitution[0], "R2": rig.restitution[1], "d": rig.d}
    for name, value in true.items():
        assert abs(found.values[name] - value) < 4 * found.errors[name], name


def test_impacts_that_no_flights_resolve_are_explained():
    """Contacts that leave most flights too few samples: the error gives the number, the reason and a remedy."""
    rig, _ = chaotic_rig(1026, "other")
    found = identified(rig, 1026)
    assert found.oscillator is None
    (why,) = (
        note
        for _, note in found._result.notes
        if "are resolved together with both neighbours" in note
    )
    assert "next to a flight with too few samples outside the pulses" in why
    assert "what would help most: a higher sampling rate and bandwidth" in why
