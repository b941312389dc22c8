"""Known values with standard errors: these contribute to the errors of all dependent parameters."""

import warnings

import numpy as np
import pytest
import vibroimpact as vi
from shared_identify import of_no_duration
from vibroimpact.identification import fit

RIG = vi.VirtualRig(
    M=2.7, K=42e3, m=0.11, d=0.006, xi=0.01143, restitution=0.7, F0=6.0, frequency=19.5
)
KNOWN = {"M": 2.7, "K": 42e3, "m": 0.11}


@pytest.fixture(scope="module")
def record():
    """A record of a periodic motion near the resonance."""
    return RIG.record(rng=1)


@pytest.fixture(scope="module")
def exact(record):
    """The fit with exactly known values."""
    return vi.identify(record, known=KNOWN)


@pytest.mark.slow
@pytest.mark.parametrize("damping", [{}, {"xi": 0.01143}])
def test_picked_phases_scatter_by_their_errors(damping):
    """Impact times from the flights alone differ from those of the motion by their errors; known damping leaves
    them their scatter."""
    every = [vi.identify(RIG.record(rng=seed), known=KNOWN | damping) for seed in range(4)]
    off = [(one.impact_phases - one.motion.phases) / one.impact_phase_errors for one in every]
    # the sum of twelve squares is between 3.6 and 26.2 in 98 % of such sets
    assert 3.6 < np.square(off).sum() < 26.2


def propagated(record, known, name, share, values):
    """The changes of all parameters per error of known value `name`, from fits with slightly different values."""
    step = 2e-4
    ends = [
        vi.identify(record, known=known | {name: known[name] * (1 + sign * step)}).values
        for sign in (1, -1)
    ]
    return {key: abs(ends[0][key] - ends[1][key]) / (2 * step) * share for key in values}


def test_errors_are_those_of_linear_propagation(record, exact):
    """Errors combine in quadrature with the changes of refitted parameters; values stay equal bit for bit."""
    share = {"M": 0.0004, "K": 0.001, "m": 0.004}
    own = {name: (value, value * share[name]) for name, value in KNOWN.items()}
    found = vi.identify(record, known=own)
    assert found.values == exact.values
    changes = [propagated(record, KNOWN, name, share[name], found.values) for name in KNOWN]
    for name in found.values:
        expected = np.sqrt(
            exact.errors.get(name, 0.0) ** 2 + sum(change[name] ** 2 for change in changes)
        )
        assert found.errors.get(name, 0.0) == pytest.approx(expected, rel=0.01, abs=1e-12), name
    low, high = found.interval("xi")
    assert high - low == pytest.approx(2 * 1.959964 * found.errors["xi"], rel=1e-6)
    assert not [text for text in found.assumptions if "as known were" in text]
    assert [text for text in exact.assumptions if "K/M" in text]


def test_without_errors_nothing_changes(record, exact):
    """An error of 0 leaves the result unchanged to the last bit."""
    again = vi.identify(record, known={name: (value, 0) for name, value in KNOWN.items()})
    mine, its = again.to_dict(), exact.to_dict()
    assert mine["tables"] == its["tables"]
    assert mine["notes"] == its["notes"]


@pytest.fixture(scope="module")
def of_stiffness(record, exact):
    """The change of xi per 1 % of K."""
    return propagated(record, KNOWN, "K", 0.01, exact.values)["xi"]


@pytest.mark.parametrize("error", ["1 %", "420 N/m", 420, "0.42 kN/m"])
def test_forms_of_an_error(record, exact, of_stiffness, error):
    """An error is a number in SI, a text with a unit, or a fraction of a quantity with a dimension."""
    found = vi.identify(record, known=KNOWN | {"K": ("42 kN/m", error)})
    assert of_stiffness > 5 * exact.errors["xi"]
    # over 1 % the change is not quite linear
    expected = np.hypot(exact.errors["xi"], of_stiffness)
    assert found.errors["xi"] == pytest.approx(expected, rel=0.1)
    assert found.errors["K"] == pytest.approx(420)
    assert found.errors["omega"] == pytest.approx(0.005 * found.values["omega"], rel=1e-4)


@pytest.mark.slow
def test_mass_alone(record):
    """With M alone, the stiffness M omega^2 changes with M and with omega, which M shifts; m/M with M alone."""
    plain = vi.identify(record, known={"M": 2.7, "m": 0.11})
    found = vi.identify(record, known={"M": ("2.7 kg", "1 %"), "m": 0.11})
    assert found.values == plain.values
    shift = {
        name: np.sqrt(found.errors[name] ** 2 - plain.errors[name] ** 2) / found.values[name]
        for name in ("K", "omega")
    }
    assert shift["omega"] > 1e-4
    # omega rises or falls
    ends = [abs(0.01 + sign * 2 * shift["omega"]) for sign in (1, -1)]
    assert min(abs(shift["K"] - end) for end in ends) < 1e-4
    assert found.errors["mu"] == pytest.approx(0.01 * found.values["mu"], rel=1e-3)
    assert found.errors["M"] == pytest.approx(0.027)


@pytest.mark.parametrize("duration", [1.5, pytest.param(3.0, marks=pytest.mark.slow)])
def test_flights_of_a_chaotic_record(duration):
    """A record that is fitted flight by flight also includes the errors of its known values."""
    chaotic = vi.VirtualRig(
        M=2.7, K=42e3, m=0.11, d=0.004, xi=0.011, restitution=0.75, F0=6.0, frequency=19.5
    ).record(duration=duration, rng=1)
    plain = vi.identify(chaotic, known={"M": 2.7, "K": 42e3})
    found = vi.identify(chaotic, known={"M": 2.7, "K": ("42 kN/m", "1 %")})
    assert found.values == plain.values
    assert found.errors["omega"] == pytest.approx(0.005 * found.values["omega"], rel=1e-4)
    for name in ("xi", "mu", "R1", "R2", "d"):
        assert found.errors[name] > plain.errors[name]


@pytest.mark.slow
def test_intervals_cover_the_truth(monkeypatch):
    """With K drawn from its error, xi is as often within its errors as stated; without the error it is not. The
    rig has impacts of no duration and constant coefficients of restitution."""
    of_no_duration(monkeypatch)
    monkeypatch.setattr(fit, "TYPICAL_EXPONENT", 1e-9)
    rng = np.random.default_rng(46)
    wide, narrow = [], []
    for seed in range(6):
        K = 42e3 * (1 + 0.003 * rng.standard_normal())
        record = RIG.record(rng=seed)
        found = vi.identify(record, known=KNOWN | {"K": (K, "0.3 %")})
        plain = vi.identify(record, known=KNOWN | {"K": K})
        off = found.values["xi"] - 0.01143
        assert plain.values["xi"] == found.values["xi"]
        wide.append(off / found.errors["xi"])
        narrow.append(off / plain.errors["xi"])
    # the sum of six squares is between 0.87 and 16.8 in 98 % of such sets
    assert 0.87 < np.square(wide).sum() < 16.8
    assert np.square(narrow).sum() > 16.8


@pytest.mark.slow
def test_a_stated_error_explains_a_contradiction(record):
    """A wrong m is doubtful unless its error is stated."""
    stated = vi.SensorRecord(
        record.rate, load=record.load, acceleration=record.acceleration, bandwidth=2000
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the record also contradicts other values
        wrong = vi.identify(stated, known=KNOWN | {"m": 0.114})
        with_error = vi.identify(stated, known=KNOWN | {"m": (0.114, 0.01)})
    assert "known mu" in " ".join(wrong.doubts)
    assert "known mu" not in " ".join(with_error.doubts)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"K": (42e3,)}, "a value and its standard error"),
        ({"K": (42e3, 1, 2)}, "a value and its standard error"),
        ({"K": (42e3, -1)}, "error of known K"),
        ({"K": (42e3, "1 mm")}, "error of known K"),
        ({"K": (42e3, float("nan"))}, "error of known K"),
        ({"K": (42e3, 420), "omega": 124.722}, "must be only two of the three"),
        (
            {"K": (42e3, "300 %")},
            "error of known K = '300 %': must be smaller than the value, 42000",
        ),
        (
            {"xi": (0.0, "10 %")},
            "error of known xi = '10 %': must be left out, since the value is 0",
        ),
        ({"M": 1e300}, r"known M = 1e\+300: must be from 1e-12 to 1e\+12 kg"),
        ({"K": (1e-300, "1 %")}, "known K = 1e-300: must be from 1e-12 to 1e[+]12 N/m"),
        ({"weight": (1, 2)}, "name"),
    ],
)
def test_errors_that_are_refused(record, given, message):
    """An error is one number of at least 0, of the kind of its value."""
    with pytest.raises((vi.errors.ParameterError, vi.errors.ParameterTypeError), match=message):
        vi.identify(record, known=KNOWN | given)


def test_namelist_and_command(record, tmp_path):
    """The namelist and the option have the error as a second number."""
    path = tmp_path / "rec.csv"
    rows = zip(record.times, record.load, record.acceleration, strict=True)
    lines = [
        "time (s),load (N),acceleration (m/s^2)",
        *(",".join(map(repr, map(float, row))) for row in rows),
    ]
    path.write_text("\n".join(lines))
    namelist = tmp_path / "identify.nml"
    system = "&system xi = 0.01, mu = 0.05, restitution = 0.7 /\n"
    keys = "mass = 2.7, free_mass = 0.11, natural_frequency = 19.85, 0.05"
    namelist.write_text(f"{system}&identify records = '{path}', {keys} /\n")
    ((found,),) = (case.run() for case in vi.read_namelist(namelist))
    known = {"M": 2.7, "m": 0.11, "omega": (2 * np.pi * 19.85, 2 * np.pi * 0.05)}
    same = vi.identify(path, known=known)
    assert found.errors == same.errors
    assert "natural_frequency = 1.985" in found.case.replace("E+001", "")
