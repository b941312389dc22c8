"""Restitution that depends on speed: the identified law is that of the rig."""

import numpy as np
import pytest
import vibroimpact as vi

pytest.importorskip("scipy")
from scipy.stats import binom
from shared_identify import BENCH, IDEAL, KNOWN
from vibroimpact.identification import fit, stages
from vibroimpact.identification.laws import Law

#: A power law on both walls, equal to one below 0.02 m/s, and load amplitudes of three records.
LAW = tuple(vi.PowerLaw(R, speed=0.02, exponent=0.1, sharpness=20) for R in (1.0, 0.9))
LOADS = (6.0, 6.4, 6.8)
#: Signal-to-noise ratio of the records, dB: flights without pulse shapes separate a law from constants only at low
#: noise.
SNR = 60.0


def records_at_loads(walls, seed):
    """Records of the bench rig at three load amplitudes."""
    return [
        vi.VirtualRig(**BENCH | IDEAL | {"F0": F0, "restitution": walls}, snr=SNR).record(
            2.0, rng=seed + i
        )
        for i, F0 in enumerate(LOADS)
    ]


def true_of_law(walls, v0):
    """Check the identification with a power law."""
    exponent = walls[0].exponent if isinstance(walls[0], vi.PowerLaw) else 0.0
    right, left = (float(law(v0)) if exponent else law for law in walls)
    return {"xi": 0.01143, "d": 0.006, "exponent": exponent, "R1": right, "R2": left}


@pytest.mark.parametrize("walls", [LAW, (0.75, 0.65)])
def test_a_power_law_is_found(walls):
    """Three loads determine the exponent (0 for constants); the law and its multipliers are those of the rig."""
    found = vi.identify(records_at_loads(walls, 1), calibration=0, known=KNOWN, law="power")
    assert found.undetermined == []
    true = true_of_law(walls, found.values["v0"])
    for name, value in true.items():
        assert abs(found.values[name] - value) < 4 * found.errors[name], name
    assert found.errors["exponent"] < 1e-3
    assert found.misfit < 1.5
    speeds = found._result.column("impacts", "speed").values
    right = found._result.column("impacts", "side").decoded() == "R"
    for law, own in zip(found.restitution, (right, ~right), strict=True):
        here = found._result.column("impacts", "restitution").values[own]
        assert law(speeds[own]) == pytest.approx(here, rel=1e-6)
    for i, motion in enumerate(found.motions):
        assert motion.stable
        fitted = found._of(i, "impacts", "fitted")
        assert np.exp(1j * motion.phases) == pytest.approx(np.exp(1j * fitted), abs=1e-6)
        assert motion.multipliers == pytest.approx(
            found._result.column("records", "multipliers").values[i], abs=1e-6
        )


@pytest.mark.slow
def test_a_power_law_holds_where_constants_fail():
    """Impacts of different speeds in one period also determine the exponent; constants do not fit them."""
    record = records_at_loads(LAW, 1)[1]
    with pytest.warns(vi.PoorFitWarning, match="law of restitution"):
        constant = vi.identify(record, calibration=0, known=KNOWN)
    found = vi.identify(record, calibration=0, known=KNOWN, law="power")
    assert found.good
    assert constant.misfit > 5
    assert found.misfit < 2
    for name, value in true_of_law(LAW, found.values["v0"]).items():
        assert abs(found.values[name] - value) < 4 * found.errors[name], name
    assert found.nearest_boundary().distance < 0.1
    here = vi.identify(
        record, calibration=0, known=KNOWN | {"exponent": 0.1}, law="power", law_speed=0.3
    )
    assert here.values["v0"] == 0.3
    assert abs(here.values["R1"] - float(LAW[0](0.3))) < 4 * here.errors["R1"]


def test_an_exponent_that_is_not_fitted_changes_a_fit_by_its_derivative(monkeypatch):
    """The derivatives of the fitted parameters with respect to the exponent of a wall are those of fits of a power
    law with given exponents; impacts of equal speed have none."""
    record = vi.VirtualRig(**BENCH | IDEAL, snr=SNR).record(2.0, rng=1)
    kept, leans = [], {}
    fitted, allow = fit.fit, fit.allow_effects

    def fit_of(*of, **more):
        kept.append((of, fitted(*of, **more)))
        return kept[-1][1]

    def allow_effects(found, contact, names, *rest):
        leans.update({name: found.leans[name] for name in names})
        allow(found, contact, names, *rest)

    monkeypatch.setattr(stages, "fit", fit_of)
    monkeypatch.setattr(fit, "allow_effects", allow_effects)
    vi.identify(record, calibration=0, known=KNOWN)
    (records, known, *_), found = kept[-1]
    motion, signs = found.motions[0], records[0].pattern.signs
    assert sorted((signs > 0).tolist()) == [False, False, True]
    v0 = motion.speeds[signs < 0].mean()
    values = [
        fitted(
            records, known | {"exponent1": 0.0, "exponent2": p}, found.values, found.lengths, found.phases,
            KNOWN["M"], KNOWN["K"], Law("powers", v0=v0), found.motions,
        ).values
        for p in (-2e-3, 2e-3)
    ]  # fmt: skip
    for name in ("xi", "R1", "R2", "d"):
        change = (values[1][name] - values[0][name]) / 4e-3
        assert leans["exponent2"][name] == pytest.approx(change, rel=0.02), name
        assert leans["exponent1"][name] == 0.0


@pytest.mark.parametrize("seed", range(3))
def test_constant_restitution_raises_no_doubt(seed):
    """Impacts of different speeds on one wall, and the same R."""
    found = vi.identify(
        vi.VirtualRig(**BENCH, snr=SNR).record(2.0, rng=seed), calibration=0, known=KNOWN
    )
    assert found.pattern.sides == "RLL"
    assert found.good
    for name, value in true_of_law((0.75, 0.65), 1.0).items():
        assert name == "exponent" or abs(found.values[name] - value) < 4 * found.errors[name], name


def test_a_knee_is_said_not_to_be_fitted():
    """At a knee a power law fits one record; coefficients at the impacts are right, and a note gives the rest."""
    walls = tuple(vi.PowerLaw(R, speed=0.3, exponent=0.2) for R in (0.9, 0.8))
    record = records_at_loads(walls, 1)[0]
    found = vi.identify(record, calibration=0, known=KNOWN, law="power")
    speeds, each, sides = (
        found._of(0, "impacts", name) for name in ("speed", "restitution", "side")
    )
    for side, law in zip("RL", walls, strict=True):
        own = sides == side
        assert each[own] == pytest.approx(law(speeds[own]), abs=1e-3)
    assert any("without a knee" in text for _, text in found._result.notes)


@pytest.mark.parametrize(
    ("keys", "values"),
    [
        ("law = 'powers', law_exponent = 0.1, 0.12", {"exponent1": 0.1, "exponent2": 0.12}),
        ("law = 'power', law_exponent = 0.1", {"exponent": 0.1}),
        ("law = 'knees', law_knee = 0.02, 0.03", {"knee1": 0.02, "knee2": 0.03}),
        ("law = 'tables', law_knots = 2", {"R1[2]": None, "R2[1]": None}),
    ],
)
def test_keys_of_a_law(keys, values, tmp_path):
    """A namelist gives the known values of a law, for both walls or for each, and the number of knots."""
    record = records_at_loads(LAW, 1)[1]
    columns = zip(record.times, record.load, record.acceleration, strict=True)
    (tmp_path / "bench.csv").write_text(
        "time (s),load (N),acc (m/s^2)\n"
        + "\n".join(",".join(repr(float(value)) for value in row) for row in columns)
    )
    (tmp_path / "bench.nml").write_text(
        "&system xi = 0.01, mu = 0.05, restitution = 0.7 /\n&identify records = 'bench.csv', "
        f"bandwidth = 0, 2000, 2000, mass = 2.7, stiffness = 42000, free_mass = 0.11, {keys} /\n"
    )
    (case,) = vi.read_namelist(tmp_path / "bench.nml")
    found = case.compute()
    for name, value in values.items():
        assert name in found.values
        if value is not None:
            assert found.values[name] == value
            assert name not in found.errors


def test_equal_speeds_do_not_tell_the_exponent():
    """For a record whose impacts have one speed a note names the exponent; the rest is as with constants."""
    walls = (vi.PowerLaw(1.0, speed=0.02, exponent=0.1, sharpness=20),) * 2
    rig = vi.VirtualRig(**BENCH | IDEAL | {"d": 0.0036, "restitution": walls, "frequency": 20.6})
    record = rig.record(rng=4)
    constant, found = (
        vi.identify(record, calibration=0, known=KNOWN, law=law) for law in ("constant", "power")
    )
    assert found.undetermined == ["exponent"]
    assert np.isinf(found.errors["exponent"])
    for name in ("xi", "R1", "R2", "d"):
        assert found.values[name] == pytest.approx(constant.values[name], rel=1e-6)
        assert found.errors[name] == pytest.approx(constant.errors[name], rel=1e-3)
    assert found.values["R1"] == pytest.approx(float(walls[0](found.values["v0"])), abs=1e-3)


@pytest.mark.slow
def test_a_power_law_of_each_wall_is_found():
    """Walls with different exponents need one exponent each; the misfit shows it if both share one."""
    walls = tuple(
        vi.PowerLaw(R, speed=0.02, exponent=p, sharpness=20) for R, p in ((1.0, 0.1), (0.9, 0.12))
    )
    records = records_at_loads(walls, 1)
    with pytest.warns(vi.PoorFitWarning, match="law of restitution"):
        one = vi.identify(records, calibration=0, known=KNOWN, law="power")
    each = vi.identify(records, calibration=0, known=KNOWN, law="powers")
    assert one.misfit > 2
    assert each.misfit < 1.5
    v0 = each.values["v0"]
    true = {"exponent1": 0.1, "exponent2": 0.12, "R1": walls[0](v0), "R2": walls[1](v0), "d": 0.006}
    for name, value in true.items():
        assert abs(each.values[name] - value) < 4 * each.errors[name], name
    assert [law.exponent for law in each.restitution] == pytest.approx([0.1, 0.12], abs=1e-3)
    assert all(motion.stable for motion in each.motions)
    here = vi.identify(records, calibration=0, known=KNOWN | {"exponent2": 0.12}, law="powers")
    assert abs(here.values["exponent1"] - 0.1) < 4 * here.errors["exponent1"]


#: Loads for which motions with these walls are periodic and their impacts have different speeds.
KNEE_LOADS = (5.5, 6.1, 6.7)


def records_of(walls, loads=KNEE_LOADS, seed=1):
    """Records of the bench rig at some load amplitudes."""
    rigs = (
        vi.VirtualRig(**BENCH | IDEAL | {"F0": F0, "restitution": walls}, snr=SNR) for F0 in loads
    )
    return [rig.record(2.0, rng=seed + i) for i, rig in enumerate(rigs)]


@pytest.mark.parametrize(
    ("kind", "loads", "left"),
    [("knee", (5.4, 5.8, 6.4), (0.8, 0.3, 0.2)), ("knees", KNEE_LOADS, (0.8, 0.3, 0.24))],
)
def test_a_knee_is_found(kind, loads, left, tmp_path):
    """Speeds around the knee determine it, for both walls or each; the law is that of the rig and is saved."""
    walls = (vi.PowerLaw(0.9, 0.3, 0.2), vi.PowerLaw(*left))
    found = vi.identify(records_of(walls, loads), calibration=0, known=KNOWN, law=kind)
    assert found.undetermined == []
    assert found.misfit < 1.5
    ends = ("", "") if kind == "knee" else ("1", "2")
    v0 = found.values["v0"]
    true = {"xi": 0.01143, "d": 0.006}
    for wall, law, end in zip(("R1", "R2"), walls, ends, strict=True):
        true |= {wall: float(law(v0)), f"exponent{end}": law.exponent, f"knee{end}": law.speed}
    for name, value in true.items():
        assert abs(found.values[name] - value) < 4 * found.errors[name], name
    found.save(tmp_path / "found.json")
    for item in (found, vi.load(tmp_path / "found.json")):
        for law, own in zip(item.restitution, walls, strict=True):
            assert isinstance(law, vi.PowerLaw)
            assert law([0.65, 0.7]) == pytest.approx(own([0.65, 0.7]), abs=1e-3)
        assert all(motion.stable for motion in item.motions)


def piecewise(speeds, values):
    """A law that is linear between its knots, as nearly as a table of the core allows."""
    speeds = np.array(speeds)
    points = np.sort(np.concatenate([speeds, speeds[1:] * 0.9999, speeds[:-1] * 1.0001]))
    return vi.TabulatedRestitution(points, np.interp(points, speeds, values))


def test_a_table_is_found():
    """The table of each wall has its knots within the speeds of its impacts; R there is that of the rig."""
    walls = (piecewise([0.5, 0.9], [0.78, 0.72]), piecewise([0.1, 0.6], [0.76, 0.64]))
    found = vi.identify(
        records_of(walls, (5.6, 6.0, 6.4)), calibration=0, known=KNOWN, law="tables"
    )
    assert found.undetermined == []
    assert found.misfit < 1.5
    values = found.values
    for i, law in enumerate(walls):
        knots = [values[f"v{i + 1}[{j}]"] for j in (1, 2, 3)]
        speeds, sides = (found._result.column("impacts", name) for name in ("speed", "side"))
        own = speeds.values[sides.decoded() == "RL"[i]]
        assert knots[0] < own.min() < knots[1] < own.max() < knots[2]
        for j, v in enumerate(knots):
            name = f"R{i + 1}[{j + 1}]"
            assert abs(values[name] - law(v)) < 4 * found.errors[name], name
        assert found.restitution[i](own) == pytest.approx(law(own), abs=1e-3)


def test_what_two_speeds_tell_of_a_table_is_named():
    """A periodic motion with one and two speeds on its walls determines neither five knots nor a knee."""
    record = vi.VirtualRig(**BENCH | IDEAL).record(rng=1)
    tables = vi.identify(record, calibration=0, known=KNOWN, law="tables", law_knots=5)
    # one speed on the right wall, at the middle knot; two on the left one
    assert set(tables.undetermined) >= {
        "R1[1]",
        "R1[2]",
        "R1[4]",
        "R1[5]",
        "R2[1]",
        "R2[3]",
        "R2[5]",
    }
    assert tables.misfit < 1.5
    assert abs(tables.d - 0.006) < 4 * tables.errors["d"]
    walls = (vi.PowerLaw(0.9, 0.3, 0.2), vi.PowerLaw(0.8, 0.3, 0.2))
    assert vi.identify(
        records_of(walls, (5.8,)), calibration=0, known=KNOWN, law="knee"
    ).undetermined == [
        "exponent",
        "knee",
    ]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "walls"),
    [("power", LAW), ("knee", [vi.PowerLaw(R, 0.3, 0.2) for R in (0.9, 0.8)]),
     ("tables", [piecewise([0.5, 0.9], [0.78, 0.72]), piecewise([0.1, 0.6], [0.76, 0.64])])],
)  # fmt: skip
def test_intervals_of_a_law(law, walls, share):
    """Over some triples of records the 95 % intervals cover."""
    count = share(40 if law == "power" else 12)
    loads = {"power": LOADS, "knee": (5.4, 5.8, 6.4), "tables": (5.6, 6.0, 6.4)}[law]
    inside = {}
    for seed in range(count):
        found = vi.identify(
            records_of(walls, loads, 100 * seed), calibration=0, known=KNOWN, law=law
        )
        v0 = found.values["v0"]
        true = {"xi": 0.01143, "d": 0.006} | {
            "power": {"exponent": 0.1, "R1": walls[0](v0), "R2": walls[1](v0)},
            "knee": {"exponent": 0.2, "knee": 0.3, "R1": walls[0](v0), "R2": walls[1](v0)},
            "tables": {
                f"R{i}[{j}]": walls[i - 1](found.values[f"v{i}[{j}]"])
                for i in (1, 2) for j in (1, 2, 3) if law == "tables"
            },
        }[law]  # fmt: skip
        for name, value in true.items():
            low, high = found.interval(name)
            inside.setdefault(name, []).append(low < value < high)
    # fewer have a probability of 0.35 % each
    least = binom.ppf(0.0035, count, 0.95)
    assert all(sum(covered) >= least for covered in inside.values())
