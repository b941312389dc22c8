"""Results of identify for records that no fit describes, and for drifting coefficients of restitution."""

import warnings

import pytest
import vibroimpact as vi

pytest.importorskip("scipy")
from reference_rig import K, M
from shared_identify import BENCH, of_no_duration, recorded
from vibroimpact.identification import fit, flights, waves, windows
from vibroimpact.identification.attempts import Attempt, Attempts
from vibroimpact.identification.steps import of_record

CHAOTIC = BENCH | {"d": 0.0037}


def quietly(record, known):
    """The result, without the warning about a poor fit."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", vi.PoorFitWarning)
        return vi.identify(record, known=known)


@pytest.mark.slow
def test_a_refusal_lists_what_was_tried_once(monkeypatch):
    """With a wrong mass no motion exists: the error lists every attempt, the best one, and possible remedies.

    All attempts, in evaluations of residuals: flights are searched once for each period (1058 evaluations), and
    fits of motions end where they cannot become good (1213 without it)."""
    counts = dict.fromkeys((flights, fit), 0)
    for module in counts:

        def counted(function, *args, module=module, search=module.levenberg, **options):
            def once(x):
                counts[module] += 1
                return function(x)

            return search(once, *args, **options)

        monkeypatch.setattr(module, "levenberg", counted)
    record = vi.VirtualRig(**BENCH).record(duration=2.0, rng=3)
    with pytest.raises(vi.SingularError, match="no exact motion RLL/1") as refused:
        vi.identify(record, known={"M": 2.7, "K": 42e3, "m": 2.7}, calibration=0)
    text = str(refused.value)
    for part in (
        "tried: the impacts of the record (RLL/1): ", "without the weakest impact", "the best is ",
        "what would help most: ",
    ):  # fmt: skip
        assert part in text
    assert counts[flights] < 1100
    assert counts[fit] < 700


def counted(monkeypatch, counts, owner, name, key):
    """Count the calls of a function or method of the package."""
    function = getattr(owner, name)

    def once(*given, **options):
        counts[key] = counts.get(key, 0) + 1
        return function(*given, **options)

    monkeypatch.setattr(owner, name, once)


#: Records of the generators of `reference_rig` whose identification took 2.5 to 8.5 s, and the most calls that it
#: may make: folds of the record in which onsets are sought ("folds"), derivatives of residuals of flights
#: ("derivatives"), exact motions ("motions"), and fits of all single flights ("flights"). Formerly there were 24
#: folds, and derivatives for each of 4500 residuals.
SLOW = {
    ("pulses", False, 4002): {"folds": 6, "derivatives": 2200},
    # 1800 if its channels were known to be simultaneous
    ("spikes", False, 4002): {"folds": 8, "derivatives": 2300},
    ("virtual", True, 4004): {"folds": 10, "derivatives": 2700},
    # at a fold, beyond which no motion exists; formerly 2102 motions
    ("pulses", False, 4001): {"motions": 1600},
    # some 100 flights at 50 kHz; formerly 276 fits
    ("pulses", True, 4004): {"flights": 260},
}


#: Those of them that no motion describes, after all attempts; the others have good results.
UNDESCRIBED = {("pulses", False, 4002), ("virtual", True, 4004)}


@pytest.mark.slow
@pytest.mark.parametrize("which", SLOW, ids=lambda which: f"{which[0]}-{which[2]}")
def test_slow_records_take_few_evaluations(which, monkeypatch):
    """Derivatives are computed at accepted points only, the record is folded once for each period and number of
    bins, single flights are fitted once for each set of common parameters, and fits that no longer move are given
    up."""
    generator, chaos, seed = which
    rig, record, *_ = recorded(seed, generator, chaos)
    counts = {}
    counted(monkeypatch, counts, flights, "folded", "folds")
    counted(monkeypatch, counts, waves.Predicted, "by_impacts", "derivatives")
    counted(monkeypatch, counts, fit.System, "motion", "motions")
    counted(monkeypatch, counts, windows.Windows, "solved", "flights")
    known = {"M": M, "K": K} | ({} if chaos else {"m": M * rig.mu})
    law = "power" if rig.exponent else "constant"
    options = {"known": known, "calibration": rig.calibration, "law": law}
    if which in UNDESCRIBED:
        with pytest.raises(vi.SingularError, match="no exact motion"):
            vi.identify(record, **options)
    else:
        assert vi.identify(record, **options).good
    assert {name: counts[name] for name in SLOW[which] if counts[name] > SLOW[which][name]} == {}


def test_the_best_attempt_has_the_least_misfit():
    """The best attempt is chosen in any sequence of attempts; attempts without a fit do not count."""
    tried = Attempts()
    tried.all = [
        Attempt("as it is", "RL/1", 7.0, "no motion"),
        Attempt("fewer", "RL/1", float("nan"), "no flights"),
        Attempt("twice", "RLRL/2", 3.0, "misfit of 3"),
    ]
    record = vi.VirtualRig(**BENCH).record(duration=1.0, rng=3)
    step = of_record(record, None, {}, 0, 1)
    text = tried.said([step], {})
    assert "the best is twice the period (RLRL/2) with a misfit of 3;" in text
    assert "a known free mass m (with the mass M)" in text
    assert "a known free mass" not in tried.said([step], {"mu": 0.04})
    assert "a longer record (now 20 load cycles)" in text


@pytest.mark.parametrize("error", [0.0, 0.04])
def test_a_wrong_mass_that_misleads_the_errors_raises_a_doubt(error, monkeypatch):
    """The wrong mass is 3.6 standard errors from the record, below 4, but it moves R by five of its own errors, if
    these contain neither contacts that last nor R that depends on the speed."""
    of_no_duration(monkeypatch)
    monkeypatch.setattr(fit, "TYPICAL_EXPONENT", 1e-9)
    record = vi.VirtualRig(**BENCH).record(duration=3.0, rng=3)
    found = quietly(record, {"M": 2.7, "K": 42e3, "m": 0.11 * (1 + error)})
    away = abs(found.values["R1"] - 0.75) / found.errors["R1"]
    assert found.good == (error == 0)
    assert (away > 4) == (error > 0)
    assert any("known mu" in doubt for doubt in found.doubts) == (error > 0)


@pytest.mark.slow
@pytest.mark.parametrize("drift", [0.0, 0.06])
def test_a_drift_of_the_restitution_raises_a_doubt(drift):
    """In a chaotic record a fall of R shows as a drift; without a drift none is reported."""
    rig = vi.VirtualRig(**CHAOTIC, drift=drift)
    found = quietly(rig.record(duration=6.0, rng=1), {"M": 2.7, "K": 42e3})
    assert found.status == "not periodic"
    assert found.good == (drift == 0)
    assert any("fall by" in doubt for doubt in found.doubts) == (drift > 0)


@pytest.mark.parametrize("name", ["f", "friction"])
def test_friction_is_refused_by_name(name):
    """Friction is not accepted as a known parameter."""
    with pytest.raises(vi.ParameterError, match=f"known {name} = 0.1: must be left out"):
        vi.identify(vi.VirtualRig(**BENCH).record(duration=1.0, rng=3), known={name: 0.1})
