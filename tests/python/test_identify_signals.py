"""Sensors and channels: ringing, bandwidth, and errors in records, which are named."""

import warnings

import numpy as np
import pytest
import vibroimpact as vi

pytest.importorskip("scipy")
from shared_identify import BENCH, KNOWN


def faulty(change):
    """A record of the bench rig, with sensors of a stated bandwidth, after a change of its channels."""
    record = vi.VirtualRig(**BENCH, known_bandwidth=True).record(rng=1)
    channels = {"load": record.load.copy(), "acceleration": record.acceleration.copy()}
    change(channels)
    return vi.SensorRecord(record.rate, bandwidth=record.bandwidth, **channels)


def clip(channels):
    channels["acceleration"] = np.clip(channels["acceleration"], -40, 40)


def lose(channels):
    channels["acceleration"][700:703] = np.nan


def swap(channels):
    channels["load"], channels["acceleration"] = channels["acceleration"], channels["load"]


def in_g(channels):
    channels["acceleration"] /= 9.80665


def in_kilonewtons(channels):
    channels["load"] /= 1000


def short(channels):
    for name, values in channels.items():
        channels[name] = values[:2000]


def stick(channels):
    channels["acceleration"][9000:9100] = 0.0


def turn(channels):
    channels["acceleration"] *= -1


def flat(channels):
    channels["load"][:] = 3.0


def test_samples_beyond_the_range_of_a_sensor_are_named():
    """A known range finds clipped samples before several of them occur in a row."""
    record = vi.VirtualRig(**BENCH).record(rng=1)
    most = 0.99 * float(abs(record.acceleration).max())
    given = vi.SensorRecord(record.rate, **record.channels, range=most)
    with pytest.raises(vi.ParameterError, match="must be within the range of its sensor"):
        vi.identify(given, known=KNOWN)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (clip, r"acceleration is clipped at -?40 in \d+ samples"),
        (lose, r"acceleration\[700\] = nan: .*3 of 30720 samples are missing"),
        (swap, "wrong order"),
        (in_g, r"must agree; .* factor of 9\.[78].*is it g for m/s\^2\?"),
        (in_kilonewtons, "must agree; .* factor of "),
        (short, r"0\.195.* s with 3\.8 load cycles .*must be at least 8 load cycles"),
        (flat, "load = 3 in all samples: must vary"),
        (stick, r"acceleration\[9000\] = 0 in 100 samples: must vary; samples are missing"),
        (turn, "must have the same positive direction"),
    ],
)
def test_faults_of_records_are_named(change, message):
    """Clipped signals, missing samples, channels in the wrong order, wrong units, short and constant records."""
    with pytest.raises(vi.ParameterError, match=message):
        vi.identify(faulty(change), known=KNOWN)


@pytest.mark.parametrize(
    ("known", "message"),
    [
        (
            KNOWN | {"R1": 0.3},
            "no exact motion RLL/1 near the detected impacts: .*known values, .* may be wrong",
        ),
        (KNOWN | {"d": 0.012}, "no exact motion RLL/1 near the detected impacts: "),
    ],
)
def test_what_is_known_wrongly_is_no_result(known, message):
    """With wrong known values there is no fit, and the error lists what was tried."""
    with pytest.raises(vi.SingularError, match=message) as refused:
        vi.identify(vi.VirtualRig(**BENCH).record(rng=1), known=known)
    assert "tried: " in str(refused.value)


def test_a_bandwidth_above_half_the_rate_is_an_error():
    """Frequencies above half the rate that the sensors pass are aliased onto the harmonics."""
    record = vi.VirtualRig(**BENCH).record(rng=1)
    every = vi.SensorRecord(
        record.rate / 8,
        load=record.load[::8],
        acceleration=record.acceleration[::8],
        bandwidth=2000,
    )
    with pytest.raises(
        vi.ParameterError,
        match="rate = 1280: must be more than twice the bandwidth of 2000 Hz of a",
    ):
        vi.identify(every, known=KNOWN)


@pytest.mark.parametrize(
    ("rate", "bandwidth", "seed"),
    [(4096, 600, 1), (4096, 700, 1), (10240, 600, 2), (10240, 700, 3), (10240, 800, 2)],
)
def test_impacts_below_the_band_of_ringing_are_found(rate, bandwidth, seed):
    """With sensors that hardly pass more than the ringing there are no spikes, but harmonics.

    A filter that is stated and impacts of no duration leave enough of them.
    """
    rig = vi.VirtualRig(**BENCH, rate=rate, bandwidth=bandwidth, contact=0.0, known_bandwidth=True)
    found = vi.identify(rig.record(rng=seed), known=KNOWN)
    assert found.pattern == vi.Pattern("RLL")
    assert found.impact_times.size == pytest.approx(3 * 3.0 * 19.5, abs=2)
    for name, value in (("xi", 0.01143), ("R1", 0.75), ("R2", 0.65), ("d", 0.006)):
        assert abs(found.values[name] - value) < 4 * found.errors[name], name


@pytest.mark.parametrize("seed", [1, 2])
def test_contacts_behind_a_low_filter_are_right_or_doubted(seed):
    """Behind an unknown filter that passes little more than the ringing, results are right or doubted."""
    rig = vi.VirtualRig(**BENCH, bandwidth=600.0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", vi.PoorFitWarning)
        found = vi.identify(rig.record(rng=seed), known=KNOWN)
    true = {"xi": 0.01143, "R1": 0.75, "R2": 0.65, "d": 0.006}
    off = [abs(found.values[name] - value) / found.errors[name] for name, value in true.items()]
    assert max(off) < 4 or not found.good


@pytest.mark.parametrize("seed", [1, 2])
def test_too_small_a_bandwidth_is_said(seed):
    """If the sensors barely pass the ringing, the result is right, or the error names what may be too small."""
    rig = vi.VirtualRig(**BENCH, rate=4096.0, bandwidth=500.0)
    try:
        found = vi.identify(rig.record(rng=seed), known=KNOWN)
    except vi.SingularError as error:
        said = str(error)
    else:
        said = "too small" if found.pattern == vi.Pattern("RLL") else ""
        assert abs(found.d - 0.006) < 4 * found.errors["d"]
    assert "too small" in said


def test_ringing_is_that_of_a_passive_mode():
    """At 4096 Hz few impacts are picked at first; a mode with negative damping must not explain the others."""
    rig = vi.VirtualRig(**BENCH, rate=4096.0, bandwidth=1000.0)
    found = vi.identify(rig.record(duration=1.5, rng=17), known=KNOWN)
    assert found.pattern == vi.Pattern("RLL")
    for name, value in (("xi", 0.01143), ("R1", 0.75), ("R2", 0.65)):
        assert abs(found.values[name] - value) < 4 * found.errors[name], name


@pytest.mark.slow
def test_what_the_errors_do_not_contain_is_said():
    """Dropped samples, for which impacts repeat without a motion, and drifting coefficients are doubted."""
    record = vi.VirtualRig(**BENCH).record(rng=1)
    channels = {name: np.delete(values, 9000) for name, values in record.channels.items()}
    dropped = vi.SensorRecord(record.rate, bandwidth=record.bandwidth, **channels)
    drifting = vi.VirtualRig(**BENCH, drift=0.09).record(rng=1)
    for item, text in (
        (dropped, "samples are missing or"),
        (drifting, "the rig changed"),
        (record, ""),
    ):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", vi.PoorFitWarning)
            found = vi.identify(item, known=KNOWN)
        assert found.good == (item is record)
        notes = [note for _, note in found._result.notes]
        said = [
            note
            for note in notes
            if "the load phase deviates from that of a constant frequency" in note
            or "misfit" in note
        ]
        assert any(text in note for note in said) if text else said == []


@pytest.mark.parametrize(
    ("clearance", "contact", "status"),
    [(0.06, None, "no impacts"), (0.0005, 0.0, "rest"), (0.0005, None, "not periodic"),
     (0.004, None, "not periodic")],
)  # fmt: skip
def test_other_records_have_a_status(clearance, contact, status):
    """Records without a periodic pattern of impacts say what they are, and what their flights tell is right.

    Impacts that accumulate are picked one by one only if their contacts are short.
    """
    rig = vi.VirtualRig(**BENCH | {"d": clearance}, contact=contact)
    found = vi.identify(rig.record(rng=1), known=KNOWN)
    assert found.status == status
    assert (found.motion, found.pattern) == (None, None)
    assert (found.oscillator is None) == (found.errors.get("d", np.inf) == np.inf)
    true = {"xi": 0.01143, "R1": 0.75, "R2": 0.65, "d": clearance}
    for name in found.errors.keys() & true.keys():
        assert not abs(found.values[name] - true[name]) > 4 * found.errors[name], name
    assert abs(found.F0 - 6) < 4 * found.errors["F0"]
    assert found.frequency == pytest.approx(19.5, rel=1e-5)
    assert (found.impact_times.size == 0) == (status == "no impacts")
    assert found.impact_times.size == found.impact_sides.size
    assert any(
        "no motion is fitted" in text or "without a motion" in text
        for _, text in found._result.notes
    )


@pytest.mark.parametrize(
    ("call", "message"),
    [
        ({"known": {"Q": 1.0}}, "known: name = 'Q': must be"),
        ({"known": {"m": 0.11}}, "known m = 0.11: must be given with the mass M"),
        ({"known": {"M": -1.0}}, "known M = -1.0: must be"),
        (
            {"known": {"M": 2.7, "K": 42e3, "omega": 3.0}},
            "known mass M, stiffness K, natural frequency omega: must satisfy",
        ),
        ({"frequency": 0.0}, "frequency = 0.0: must be"),
        ({"bandwidth": 300.0}, "bandwidth: must be left out if a record is given"),
        ({"impact_times": [0, 1]}, "impact_times: must be given without a record"),
        ({"law": "cubic"}, "law = 'cubic': must be"),
        (
            {"law_speed": 0.3},
            "law_speed = 0.3: must be given with a law over the speed, such as law = 'power'",
        ),
        ({"law_knots": 3}, "law_knots = 3: must be given with law = 'table' or 'tables'"),
        ({"law": "table", "law_knots": 1}, "law_knots = 1: must be"),
        (
            {"law": "table", "known": {"R1": 0.7}},
            "known R1 = 0.7: must be given with law = 'constant' or",
        ),
        (
            {"law": "power", "known": {"knee": 0.3}},
            "known knee = 0.3: must be given with law = 'knee'",
        ),
        (
            {"known": {"exponent": 0.1}},
            "known exponent = 0.1: must be given with law = 'power' or 'knee'",
        ),
        (
            {"law": "power", "known": {"exponent1": 0.1}},
            "exponent1 = 0.1: must be given with law = 'powers'",
        ),
        ({"law": "power", "law_speed": -1.0}, "law_speed = -1.0: must be"),
        ({"law": "power", "known": {"exponent": np.nan}}, "known exponent = nan: must be"),
        ({"law": "power", "known": {"R1": 0.7}}, "known R1 = 0.7: must be given with law_speed"),
    ],
)
def test_faults_of_calls_are_named(call, message):
    """Each invalid argument has one message."""
    with pytest.raises(vi.ParameterError, match=message):
        vi.identify(vi.VirtualRig(**BENCH).record(0.9, rng=1), **call)


def test_load_phases_of_picked_impacts_are_those_of_the_motion():
    """Times of picked impacts are free of the known filter delay, and so are their load phases."""
    rig = vi.VirtualRig(**BENCH, bandwidth=500.0, contact=0.0, known_bandwidth=True)
    found = vi.identify(rig.record(rng=1), known=KNOWN)
    cycles = found.frequency * found.impact_times + found._one("load_phase") / (2 * np.pi)
    fitted = found._of(0, "impacts", "fitted") / (2 * np.pi)
    off = (cycles[:, None] - fitted + 0.5) % 1 - 0.5
    assert np.median(abs(off).min(axis=1)) < 0.002


@pytest.mark.slow
def test_flights_that_run_away_hide_no_wrong_unit():
    """A short record in g, in which some trial flights grow beyond the number range: a doubt names the unit."""
    record = vi.VirtualRig(**BENCH).record(1.0, rng=1)
    with pytest.warns(vi.PoorFitWarning):
        found = vi.identify(
            rate=record.rate, load=record.load, acceleration=record.acceleration / 9.80665,
            bandwidth=dict(record.bandwidth), known=KNOWN,
        )  # fmt: skip
    assert not found.good
    assert any("is it g for m/s^2?" in text for text in found.doubts)


def test_progress_is_told():
    """Shares of the work never decrease, and come with the current step; non-functions are refused."""
    rig = vi.VirtualRig(**BENCH | {"d": 0.0037})
    told = []
    record = rig.record(2.0, rng=1)
    vi.identify(record, known=KNOWN, progress=lambda share, note: told.append((share, note)))
    shares = [share for share, _ in told]
    assert shares == sorted(shares)
    assert 0 <= shares[0] <= shares[-1] <= 1
    assert {note for _, note in told} <= {"single flights", "flights of a period"}
    with pytest.raises(vi.ParameterTypeError, match="progress = 3"):
        vi.identify(record, known=KNOWN, progress=3)


@pytest.mark.parametrize("noise", [0.0, 1e-9, 1e-6, 1e-4, 0.03])
@pytest.mark.parametrize("rate", [1000.0, 5000.0])
def test_a_record_without_impacts_has_none(rate, noise):
    """The steady motion of the primary mass alone, at any signal-to-noise ratio."""
    M, K, F0, Omega = 2.7, 42e3, 6.0, 2 * np.pi * 15
    t, draw = np.arange(0, 3, 1 / rate), np.random.default_rng(1)
    whole = F0 / (K - M * Omega**2 + 2j * 0.0114 * np.sqrt(M * K) * Omega)
    motion = np.imag(-(Omega**2) * whole * np.exp(1j * Omega * t))
    load = F0 * (np.sin(Omega * t) + noise * draw.normal(size=t.size))
    motion += noise * np.ptp(motion) / 2 * draw.normal(size=t.size)
    found = vi.identify(rate=rate, load=load, acceleration=motion)
    assert found.status == "no impacts"
    assert len(found.impact_times) == 0
