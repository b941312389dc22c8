"""Values with units, wherever numbers are accepted: one reading, or an error that names what is missing."""

import math
import re

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact.base.errors import ParameterError, ParameterTypeError

RIG = vi.Oscillator.from_dimensional(
    M="2.7 kg", K="42 kN/m", xi="1.1 %", m="0.11 kg", restitution=0.75, F0="6 N"
)
UNITS = RIG.units()
RECORD = vi.SensorRecord(1000, load=np.sin(np.arange(2000.0)), acceleration=np.ones(2000))
LENGTH = 6 / 42e3


def ratio(hertz):
    """The frequency ratio of the rig."""
    return 2 * math.pi * hertz / math.sqrt(42e3 / 2.7)


@pytest.mark.parametrize("make", [list, tuple, np.array, lambda x: np.array(x, dtype=object)])
def test_lists_and_arrays_are_converted_one_by_one(make):
    """A list of texts is converted to the array of their values."""
    given = make(["18 Hz", "1170 rpm"])
    assert UNITS.frequency_ratio(given) == pytest.approx([ratio(18), ratio(19.5)], rel=1e-12)
    assert UNITS.frequency_ratio(f=given) == pytest.approx([ratio(18), ratio(19.5)], rel=1e-12)
    assert UNITS.clearance(make(["3 mm", "0.004 m"])) == pytest.approx(
        [3e-3 / LENGTH, 4e-3 / LENGTH], rel=1e-12
    )


@pytest.mark.parametrize("given", ["-3 Hz", "0 Hz", ["19 Hz", "-1 Hz"]])
def test_frequencies_are_positive(given):
    """A frequency that is not positive is an error that shows it, even with a unit."""
    with pytest.raises(ParameterError, match=r"Hz.*must be"):
        UNITS.frequency_ratio(given)


def test_half_a_range_with_a_unit_is_refused():
    """A range with a unit at one end only is refused with both ends; 0 needs no unit."""
    for call in (
        lambda: UNITS.frequency_ratio(["18 Hz", 19]),
        lambda: UNITS.clearance([3, "4 mm"]),
        lambda: vi.bifurcation_diagram(RIG, "r", ("20 Hz", 21), points=3, clearance="4 mm"),
        lambda: vi.zone(RIG, "RL", ("20 Hz", 1.1), ("2 mm", "6 mm")),
        lambda: vi.design(RIG, r=("20 Hz", "21 Hz"), free={"clearance": ("2 mm", 6)}),
    ):
        with pytest.raises(ParameterError, match=r"has one and .* has none"):
            call()
    plane = vi.basins(
        RIG, "19.5 Hz", "4 mm", (("x", 0, "1 mm", 2), ("z_dot", "-10 mm/s", 0, 2)), cycles=4
    )
    assert plane.keys["high"][0] == pytest.approx(1e-3 / LENGTH, rel=1e-12)


class Almost:
    """It has the attributes by which quantities of pint are recognised, and no others."""

    magnitude, units = 3, "mm"


def test_what_only_resembles_a_quantity_is_refused():
    """The message lists what a quantity must have."""
    with pytest.raises(ParameterTypeError, match=r"d = .*Almost.* to_base_units"):
        UNITS.clearance(Almost())


def test_degrees_a_second_are_angles():
    """360 degrees of pint are one revolution."""
    pint = pytest.importorskip("pint")
    turn = pint.UnitRegistry().Quantity(7020, "degree/second")
    assert UNITS.frequency_ratio(turn) == pytest.approx(ratio(19.5), rel=1e-12)


def test_an_oscillator_takes_units():
    """The class takes the arguments of `from_dimensional`; a free mass needs M."""
    own = vi.Oscillator(xi="1.1 %", mu="110 g", restitution=0.75, M="2.7 kg", K="42 kN/m", F0="6 N")
    assert own == RIG
    assert own.units() == UNITS
    with pytest.raises(ParameterError, match="mu = 110 g"):
        vi.Oscillator(xi=0.1, mu="110 g", restitution=0.75)
    assert RIG.structure("4 mm").gaps == RIG.structure(4e-3 / LENGTH).gaps


def test_results_take_units():
    """Methods of results of a rig take values with units, and give the same as for numbers."""
    zone = vi.zone(RIG, "RL", ("20 Hz", "22 Hz"), ("2 mm", "6 mm"), symmetric=True)
    assert zone.contains(["20.5 Hz", "21 Hz"], "4 mm").tolist() == [
        *zone.contains([ratio(20.5), ratio(21)], 28.0)
    ]
    motion = zone.motion("21 Hz", "4 mm")
    assert motion.r == pytest.approx(ratio(21), rel=1e-12)
    physical = zone.physical("mm N s")
    assert physical.contains(21, 4.0) == zone.contains("21 Hz", "4 mm")
    assert physical.motion(21, 4.0).clearance == pytest.approx(4.0, rel=1e-12)
    run = vi.simulate(RIG, "19.5 Hz", "4 mm", 10)
    times = np.array([0.1, 0.2]) / UNITS.time
    np.testing.assert_allclose(run.sample(["0.1 s", "200 ms"]).X, run.sample(times).X, rtol=1e-9)
    assert run.quantities(window=("0.1 s", "0.3 s")).duration == pytest.approx(0.2 / UNITS.time)
    assert "0.512821 s" in repr(run)
    np.testing.assert_allclose(motion.sample("10 ms").X, motion.sample(0.01 / UNITS.time).X)
    with pytest.raises(ParameterError, match="must be a time"):
        run.sample("4 mm")


def test_shares_and_masses(short):
    """A damping ratio may be in %, and a mass ratio the free mass."""
    motion = vi.equispaced(RIG, "20.6 Hz", "3.5 mm")[0]
    path = vi.branch(motion, "xi", ("1.2 %", "1 %"))
    assert [min(path.values), max(path.values)] == pytest.approx([0.01, 0.012])
    quick = {"evaluations": 8, "searches": 1, "samples": 0, "specimens": 1, "nodes": 2}
    with pytest.raises(ParameterError, match="a mass, or a ratio"):
        vi.design(RIG, r=("20 Hz", "21 Hz"), free={"mu": ("1 N", "2 N")}, clearance="4 mm", **quick)
    found = vi.design(
        RIG, r=("20 Hz", "21 Hz"), free={"mu": ("0.05 kg", "200 g")}, clearance="4 mm", **quick
    )
    assert found.ranges["mu"] == pytest.approx((0.05 / 2.7, 0.2 / 2.7), rel=1e-12)


def test_uncertain_values_with_units_are_factors():
    """A range of clearances at one nominal clearance is equivalent to a range of factors."""
    few = {"samples": 5, "rng": 1}
    limit = {"displacement": "4 mm"}
    first, second = (
        vi.limit_probability(RIG, "20 Hz", "4 mm", {"clearance": one, "xi": xi}, limit, **few)
        for one, xi in (((0.95, 1.05), (0.01, 0.012)), (("3.8 mm", "4.2 mm"), ("1 %", "1.2 %")))
    )
    assert repr(first) == repr(second)
    with pytest.raises(ParameterError, match="must be factors of the nominal clearance"):
        vi.limit_probability(
            RIG, "20 Hz", ["4 mm", "5 mm"], {"clearance": ("3.8 mm", "4.2 mm")}, limit, **few
        )
    line = vi.limit_probability(
        RIG, ("20 Hz", "21 Hz"), "4 mm", {"xi": ("1 %", "1.2 %")}, limit, points=3, **few
    )
    assert line.r == pytest.approx([ratio(20), ratio(20.5), ratio(21)], rel=1e-12)


def test_bands_of_boundaries_take_units():
    """Masses, forces and percentages are the parameters of the zone's rig; a zone has no single clearance."""
    zone = vi.zone(RIG, "RL", ("20 Hz", "21 Hz"), ("6 mm", "12 mm"), lines=5, guesses=2)
    texts = {"mu": ("100 g", "120 g"), "load": ("5.7 N", "6.3 N"), "xi": ("1 %", "1.2 %")}
    numbers = {"mu": (0.1 / 2.7, 0.12 / 2.7), "load": (0.95, 1.05), "xi": (0.01, 0.012)}
    first, second = (
        vi.boundary_bands(zone, one, samples=4, vertices=4) for one in (texts, numbers)
    )
    assert len(first) == len(second) > 0
    for one, other in zip(first, second, strict=True):
        assert one.sampled == pytest.approx(other.sampled, rel=1e-9, nan_ok=True)
    with pytest.raises(ParameterError, match="must be factors of the nominal clearance"):
        vi.boundary_bands(zone, {"clearance": ("7 mm", "9 mm")}, samples=4)


def test_sensors_take_units():
    """Rate, bandwidth, delay, range and noise with units are equivalent to SI values."""
    t = np.arange(50) / 1000
    known = {"units": {"load": "kN"}}
    found = vi.SensorRecord(
        "1 kHz", load=t, acceleration=t, bandwidth="400 Hz", delay="2 ms", range={"load": "1 kN"},
        noise={"acceleration": "1 mm/s^2"}, start="3 ms", **known,
    )  # fmt: skip
    plain = vi.SensorRecord(
        1000, load=t, acceleration=t, bandwidth=400, delay=0.002, range={"load": 1},
        noise={"acceleration": 1e-3}, start=0.003, **known,
    )  # fmt: skip
    for name in ("rate", "bandwidth", "delay", "range", "noise", "start"):
        assert getattr(found, name) == getattr(plain, name), name
    with pytest.raises(ParameterError, match="bandwidth"):
        vi.SensorRecord(1000, load=t, acceleration=t, bandwidth="4 mm")


def case_in(tmp_path, system, study):
    """The only case of a namelist."""
    path = tmp_path / "case.nml"
    path.write_text(f"&system restitution = .75, xi = 0.011, {system} /\n&{study} /\n", "utf-8")
    (case,) = vi.read_namelist(path)
    return case


TEXTS = "mass = '2.7 kg', stiffness = '42 kN/m', force = '6 N', free_mass = '0.11 kg'"
NUMBERS = "units = 'mm N s', mass = 0.0027, stiffness = 42, force = 6, free_mass = 0.00011"
DESIGN = (
    "design band = '20 Hz', '21 Hz', free_clearance = '2 mm', '6 mm', target = '{}', limit = {}"
)


@pytest.mark.parametrize(
    ("target", "bare", "text", "wanted"),
    [
        ("displacement", "3", "'3 mm'", 3e-3 / LENGTH),
        ("rms", "3", "'0.003 m'", 3e-3 / LENGTH),
        ("acceleration", "5e4", "'50 m/s^2'", 50 / (6 / 2.7)),
        ("force", "100", "'0.1 kN'", 100 / 6),
        ("attenuation", "0.5", "'50 %'", 0.5),
    ],
)
def test_the_limit_of_a_design_has_the_unit_of_its_target(tmp_path, target, bare, text, wanted):
    """A limit is read in the unit of the target, and refused if it has two readings."""
    for system, limit in ((NUMBERS, bare), (NUMBERS, text), (TEXTS, text)):
        study = DESIGN.format(target, limit)
        if "units" in system:
            study = study.replace("'2 mm', '6 mm'", "2, 6")
        case = case_in(tmp_path, system, study)
        assert case.keys["limit"] == pytest.approx(wanted, rel=1e-12), limit
    if target == "attenuation":
        assert case_in(tmp_path, TEXTS, DESIGN.format(target, bare)).keys["limit"] == 0.5
        return
    with pytest.raises(ParameterError, match=r"limit = .* in two ways"):
        case_in(tmp_path, TEXTS, DESIGN.format(target, bare))
    with pytest.raises(ParameterError, match="its unit is not that of"):
        case_in(tmp_path, TEXTS, DESIGN.format(target, "'3 s'"))


def test_a_free_mass_in_a_design(tmp_path):
    """The range of m/M may be given as a range of m; plain numbers are always m/M."""
    study = "design band = 1, 1.02, clearance = '4 mm', free_mu = {}"
    found = case_in(tmp_path, TEXTS, study.format("'0.05 kg', '200 g'")).keys["free_mu"]
    assert found == pytest.approx([0.05 / 2.7, 0.2 / 2.7], rel=1e-12)
    assert case_in(tmp_path, TEXTS, study.format("0.02, 0.1")).keys["free_mu"] == [0.02, 0.1]


def test_both_ends_of_a_range_have_units_in_a_namelist(tmp_path):
    """Low and high must both have a unit, or neither."""
    study = "bifurcation parameter = 'r', values = 3, clearance = '4 mm', low = {}, high = {}"
    for ends in (("'20 Hz'", "1.05"), ("1", "'21 Hz'")):
        with pytest.raises(ParameterError, match="low and high must both have a unit"):
            case_in(tmp_path, TEXTS, study.format(*ends))
    case = case_in(tmp_path, TEXTS, study.format("'20 Hz'", "'21 Hz'"))
    assert [case.keys["low"], case.keys["high"]] == pytest.approx([ratio(20), ratio(21)])


@pytest.mark.parametrize("system", [TEXTS, NUMBERS])
def test_a_bare_frequency_in_hertz_is_refused(tmp_path, system):
    """Without a unit 20 is a ratio, here of 400 Hz; the natural frequency is 19.85 Hz."""
    study = "design band = {}, free_mu = 0.01, 0.1, clearance = '4 mm'"
    for wrong in ("20, 20.6", "15", "'20 Hz', 20.6"):
        with pytest.raises(ParameterError, match=r"band = .*20 Hz"):
            case_in(tmp_path, system, study.format(wrong))
    for right, ends in (("1, 1.02", [1, 1.02]), ("5, 60", [5, 60]), ("'400 Hz'", [ratio(400)])):
        found = case_in(tmp_path, system, study.format(right)).keys["band"]
        assert np.atleast_1d(found) == pytest.approx(ends, rel=1e-12)
    one = case_in(tmp_path, system + ", r = '20 Hz'", "simulate clearance = '4 mm', cycles = 2")
    assert one.osc is not None
    with pytest.raises(ParameterError, match="r = 20"):
        case_in(tmp_path, system + ", r = 20", "simulate clearance = '4 mm', cycles = 2")
    # numbers of a dimensionless case are ratios
    bare = system.replace("units = 'mm N s', ", "") + ", units = 'dimensionless'"
    if system == TEXTS:
        case_in(tmp_path, bare + ", r = 20", "simulate clearance = 20, cycles = 2")


def test_a_bare_frequency_in_hertz_is_refused_in_calls():
    """As in namelists, where another value has a unit; dimensionless numbers are ratios."""
    for call in (
        lambda: RIG.at(19.5, "4 mm"),
        lambda: RIG.at(19.5, 28, load="6 N"),
        lambda: vi.simulate(RIG, 19.5, "4 mm", cycles=2),
        lambda: vi.response(RIG, (19, 21), clearance="4 mm", points=2),
        lambda: vi.response(RIG, np.array([19.0, 21.0]), clearance="4 mm"),
        lambda: vi.zone(RIG, "RL", (19, 21), ("2 mm", "6 mm")),
    ):
        with pytest.raises(ParameterError, match=r"r = .*19.*'20 Hz'"):
            call()
    assert RIG.at(0.98, "4 mm").clearance == pytest.approx(4e-3 / LENGTH, rel=1e-12)
    assert RIG.at(19.5, 28).r == vi.simulate(RIG, 19.5, 28, cycles=2).r == 19.5
    # five, and three times the natural frequency
    assert [RIG.at(r, "4 mm").r for r in (5.0, 60.0)] == [5.0, 60.0]


def test_lists_may_fall(tmp_path):
    """A descending list is the same case as the ascending list, with the data of each value."""
    chart = "chart sides = 'RL', r = {}, clearance = {}"
    falls = case_in(tmp_path, "mu = 0.04", chart.format("1.1, 1.05, 1.02", "30, 20"))
    assert (
        falls.text == case_in(tmp_path, "mu = 0.04", chart.format("1.02, 1.05, 1.1", "20, 30")).text
    )
    line = "bifurcation parameter = 'clearance', list = {}, r = {}"
    falls = case_in(tmp_path, "mu = 0.04", line.format("40, 25, 20", "1.1, 1.2, 1.3"))
    rises = case_in(tmp_path, "mu = 0.04", line.format("20, 25, 40", "1.3, 1.2, 1.1"))
    assert falls.text == rises.text
    plane = "basins clearance = 20, axes = 'x', 'x_dot', first_values = {}, second_values = {}"
    falls = case_in(tmp_path, "mu = 0.04, r = 1.1", plane.format("5, 2, 1", "1, 3"))
    assert (
        falls.text == case_in(tmp_path, "mu = 0.04, r = 1.1", plane.format("1, 2, 5", "1, 3")).text
    )
    with pytest.raises(ParameterError, match="first_values = 5, 1, 2"):
        case_in(tmp_path, "mu = 0.04, r = 1.1", plane.format("5, 1, 2", "1, 3"))
    with pytest.raises(ParameterError, match="list = 20, 40, 25"):
        case_in(tmp_path, "mu = 0.04", line.format("20, 40, 25", "1.1, 1.2, 1.3"))


@pytest.mark.parametrize("micro", ["\N{MICRO SIGN}", "\N{GREEK SMALL LETTER MU}", "u"])
def test_micro_in_names_of_units(tmp_path, micro):
    """Both letters for micro are read in &system and in &output."""
    system = TEXTS + f", units = '{micro}m N {micro}s', r = 0.98"
    case = case_in(
        tmp_path, system, f"simulate clearance = 4000, cycles = 1 /\n&output units = '{micro}m N s'"
    )
    assert case.keys["clearance"] == pytest.approx(4e-3 / LENGTH, rel=1e-12)
    assert case.osc.unit_names == "um N us"
    assert case.keys["units"] == "um N s"


def test_known_values_are_in_the_units_of_the_system(tmp_path):
    """Known values of &identify are numbers in `units` too; one value in two places is refused, naming both."""
    study = "identify impact_times = 0, 0.5, frequency = 19.5, clearance = {}, free_mass = {}"
    plain = "units = 'mm N s', mass = 0.0027, stiffness = 42, mu = 0.04"
    case = case_in(tmp_path, plain, study.format("4", "1.1e-4"))
    assert [case.keys["clearance"], case.keys["free_mass"]] == pytest.approx(
        [0.004, 0.11], rel=1e-12
    )
    with pytest.raises(
        ParameterError, match=r"&identify mass = 2.6: must be left out if mass is given in &system"
    ):
        case_in(tmp_path, plain, study.format("4", "1.1e-4, mass = 2.6"))
    # a standard error has the unit of its value, and is not 0
    for given in ("4, 0.1", "'4 mm', '0.01 cm'"):
        case = case_in(tmp_path, plain, study.format(given, "1.1e-4"))
        assert case.keys["clearance"] == pytest.approx([4e-3, 1e-4], rel=1e-12)
    for given in ("4, 0", "4, -0.1", "4, nan", "'4 mm', 0.1", "'4 mm', '1 %'", "4, 0.1, 0.1"):
        with pytest.raises(
            ParameterError, match=r"or two, of which the second is its standard error; both"
        ):
            case_in(tmp_path, plain, study.format(given, "1.1e-4"))


def test_unit_names_leaves_no_number_without_a_unit(tmp_path):
    """Numbers are dimensionless next to `unit_names` only in the &system of a result; else they are refused."""
    result = "xi = 0.01, mu = 0.04, restitution = 0.75, 0.75, r = {}, mass = 0.0027, stiffness = 42"
    named = result + ", force = 6, unit_names = 'mm N s'"
    study = "&simulate clearance = {}, cycles = 1 /"
    path = tmp_path / "case.nml"

    def read(system, clearance):
        path.write_text(f"&system {system} /\n{study.format(clearance)}\n")
        return vi.read_namelist(path)[0]

    whole = named.format("0.98")
    case = read(whole, "4")
    assert case.keys["clearance"] == 4
    assert case.osc.unit_names == "mm N s"
    assert read(whole.replace(", force = 6", ""), "4").keys["clearance"] == 4
    by_hand = (
        whole.replace("0.75, 0.75", "0.75"),  # a result has both coefficients
        whole.replace("xi = 0.01, mu = 0.04", "mu = 0.04, xi = 0.01"),  # in another order
        "unit_names = 'mm N s', " + whole.replace(", unit_names = 'mm N s'", ""),
        whole.replace(
            "mu = 0.04, restitution = 0.75, 0.75, r = 0.98", "restitution = 0.75, r = 0.98"
        )
        + ", free_mass = 1.1e-4",
        named.format("'19.5 Hz'"),
    )
    for system in (*by_hand, by_hand[0].replace(", force = 6", "")):
        with pytest.raises(ParameterError, match=r"clearance = 4: .* in two ways"):
            read(system, "4")
    for system in by_hand:
        assert read(system, "'4 mm'").keys["clearance"] == pytest.approx(28, rel=1e-12)
        either = system.replace("unit_names = 'mm N s'", "units = 'mm N s'")
        assert read(either, "4").keys["clearance"] == pytest.approx(28, rel=1e-12)
    for system in (
        TEXTS.replace("r = 0.98", "r = 0.5"),
        by_hand[0].replace(", unit_names = 'mm N s'", ""),
    ):
        either = system + ", units = 'dimensionless'" + ("" if "r = " in system else ", r = 0.5")
        if "xi" not in either:
            either += ", xi = 0.01"
        if "restitution" not in either:
            either += ", restitution = 0.75"
        assert read(either, "4").keys["clearance"] == 4


def test_a_case_of_a_rig_is_read_back(tmp_path):
    """Cases and headers of results keep their digits, written as `unit_names` requires."""
    osc = vi.Oscillator.from_dimensional(
        M="2.7 kg", K="42 kN/m", xi="1.1 %", m="0.11 kg", restitution=0.75, F0="6 N"
    )
    run = vi.simulate(osc.at("19.5 Hz", "4 mm"), cycles=3)
    run.save(tmp_path / "run.csv")
    (tmp_path / "run.nml").write_text(run.to_namelist())
    for name in ("run.csv", "run.nml"):
        (case,) = vi.read_namelist(tmp_path / name)
        assert case.osc.units() == osc.units()
        (again,) = case.run()
        assert again.clearance == run.clearance
        np.testing.assert_array_equal(again.events, run.events)


def test_signals_take_units():
    """Times, frequencies and amplitudes of signals with units are equivalent to SI values."""
    shock = vi.half_sine("50 m/s^2", duration="11 ms", step="0.1 ms", end="0.05 s")
    np.testing.assert_array_equal(shock, vi.half_sine(50.0, 0.011, 1e-4, 0.05))
    sweep = vi.swept_sine("6 N", ("15 Hz", "25 Hz"), "1 s", "1 ms")
    np.testing.assert_array_equal(sweep, vi.swept_sine(6.0, (15.0, 25.0), 1.0, 1e-3))
    assert vi.Load("19.5 Hz", sine=[1]).frequency == pytest.approx(2 * math.pi * 19.5, rel=1e-14)
    assert vi.Record("1 ms", [[0.0], [1.0]]).step == 1e-3
    with pytest.raises(ParameterError, match="amplitude = '5 mm'"):
        vi.half_sine("5 mm", 0.011, 1e-4)


def test_a_decay_needs_no_load():
    """Without F0 the amplitude is the unit of length."""
    bare = vi.Oscillator.from_dimensional(M=2.7, K=42e3, xi=0.011, m=0.11, restitution=0.75)
    found = vi.decay(bare, ["2 mm", "4 mm"], amplitude="2 mm", cycles=3)
    np.testing.assert_allclose(found.clearance, [1, 2], rtol=1e-12)
    assert found.physical("mm N s").clearance == pytest.approx([2, 4], rel=1e-12)
    with pytest.raises(ParameterError, match=r"amplitude = 1.0: must have a unit"):
        vi.decay(bare, "2 mm")


def test_the_output_of_a_structure_is_designed(short):
    """A design may judge an output; an output equal to a coordinate gives the result of that coordinate."""

    def host(clearance, load, r):
        gaps = [vi.Gap([-1, 1], clearance, 0.7), vi.Gap([1, -1], clearance, 0.7)]
        structure = vi.Structure([1, 0.1], [0.02, 0], [1, 0], gaps, outputs={"tip": [1, 0]})
        return structure, vi.Load(r, sine=[load, 0])

    asked = {
        "r": (1.0, 1.02), "free": {"clearance": (5, 20)}, "samples": 0, "evaluations": 8, "searches": 1,
        "nodes": 2, "specimens": 1, "settling": 5, "keep": 2, "states": 1,
    }  # fmt: skip
    for target in ("displacement", "acceleration"):
        tip, first = (vi.design(host, target=target, coordinate=one, **asked) for one in ("tip", 0))
        assert tip.level == pytest.approx(first.level, rel=1e-3)
        assert f"{target} of tip <= " in repr(tip)
    with pytest.raises(
        ParameterError, match="coordinate = 'top': must be 0 to 1, or the output 'tip'"
    ):
        vi.design(host, target="displacement", coordinate="top", **asked)
    pytest.importorskip("matplotlib")
    labels = [panel.get_xlabel() + panel.get_ylabel() for panel in tip.plot()]
    assert any("acceleration of tip" in label for label in labels)
    assert not any("F_0" in label for label in labels)


REFUSED = {
    "state": (
        lambda: vi.simulate(RIG, "19.5 Hz", "4 mm", 5, {"x": "1 mm", "z": "5 mm"}),
        "state['z'] - state['x'] = 5 mm - 1 mm: must be between the walls, -14 to 14; without units 5 mm is 35, "
        "1 mm is 7",
    ),
    "list": (
        lambda: vi.simulate(RIG, "19.5 Hz", "4 mm", 5, ["1 mm", "2 mm"]),
        "state = ['1 mm', '2 mm']: must be a mapping",
    ),
    "clearance": (
        lambda: vi.zone(RIG, "RL", ("19 Hz", "21 Hz"), ("-1 mm", "8 mm")), "clearance[0] = -1 mm: must be a number"
    ),
    "range": (lambda: vi.response(RIG, ("18 Hz", "18 Hz"), "4 mm", points=3), "r = (18 Hz, 18 Hz): must be"),
    "load": (lambda: RIG.at("19.5 Hz", "4 mm", load="-3 N"), "load = -3 N: must be a number"),
    "friction": (lambda: RIG.at("19.5 Hz", "4 mm", friction="-0.1 N"), "friction = -0.1 N: must be a force"),
    "frequency": (lambda: RIG.at("-2 Hz", "4 mm"), "r = -2 Hz: must be a number"),
    "zero": (lambda: RIG.at("19.5 Hz", "-4 mm"), "clearance = -4 mm: must be a finite number with clearance > 0"),
    "many": (lambda: RIG.at("19.5 Hz", ["3 mm", "4 mm"]), "clearance = [3 mm, 4 mm]: must be a finite number"),
    "fixed": (
        lambda: vi.basins(
            RIG, "19.5 Hz", "4 mm", (("x", ("-1 mm", "1 mm")), ("z_dot", (-1, 1))), points=2, fixed={"x": "2 mm"}
        ),
        "fixed['x'] = 2 mm: must be left out: it is an axis",
    ),
    "both": (
        lambda: vi.simulate(RIG.at("19.5 Hz", "4 mm", friction="1 N"), duration="2 s", cycles=20),
        "cycles = 20, duration = 2 s: exactly one must be given",
    ),
    "limits": (
        lambda: vi.limit_probability(RIG, ["19 Hz"], "4 mm", {"xi": (0.01, 0.012)}, {"displacement": "nan mm"}),
        "limit['displacement'] = 'nan mm': must be a positive number in F0/K, or a text with a unit, such as",
    ),
    "target": (
        lambda: vi.design(RIG, r=("19 Hz", "20 Hz"), free={"mu": (0.02, 0.05)}, clearance="4 mm", limit="2 mm"),
        "limit = '2 mm': must be a positive number (attenuation is dimensionless)",
    ),
    "stop": (
        lambda: RIG.at("19.5 Hz", "4 mm", stops=(None, ("-840 kN/m", "75 N s/m"))),
        "stiffness of the left wall = -840 kN/m: must be a number from 0 to 1e100; without units -840 kN/m is -20",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_messages_show_what_was_given(name):
    """The value in a message is the text that was given; its dimensionless number is named for the rest of it."""
    call, message = REFUSED[name]
    with pytest.raises((ParameterError, ParameterTypeError)) as caught:
        call()
    assert message in str(caught.value)


def test_bounds_of_a_branch_are_named_as_given():
    """Bounds in mm and Hz are refused with these, and with the value of the motion in them."""
    motion = next(m for m in vi.equispaced(RIG, "20.6 Hz", "3.6 mm") if m.stable)
    for name, bounds, parts in (
        ("clearance", ("2 mm", "3 mm"), ("bounds[1] = 3 mm: must", "= 3.6 mm; without units 3 mm is 21")),
        ("r", ("21 Hz", "22 Hz"), ("bounds[0] = 21 Hz: must", "has r = 20.6 Hz; without units 21 Hz is")),
        ("clearance", ("-3 mm", "4 mm"), ("bounds[0] = -3 mm: must",)),
    ):  # fmt: skip
        with pytest.raises(ParameterError) as caught:
            vi.branch(motion, name, bounds=bounds)
        for part in parts:
            assert part in str(caught.value)
    default, named = (
        vi.branch(motion, *name, bounds=("3 mm", "4 mm")) for name in ((), ("clearance",))
    )
    np.testing.assert_array_equal(default.clearance, named.clearance)


def test_percentages_of_the_walls_and_the_mass():
    """A restitution and a mass ratio may be given in %, alone or for each wall."""
    plain = vi.Oscillator(xi=0.011, mu=0.04, restitution=(0.75, 0.6))
    assert vi.Oscillator(xi="1.1 %", mu="4 %", restitution=("75 %", "60 %")) == plain
    assert vi.Gap([1], 0.1, "75 %").restitution == 0.75
    with pytest.raises(ParameterError, match="restitution = 7 mm: must be a number"):
        vi.Oscillator(xi=0.011, mu=0.04, restitution="7 mm")
    with pytest.raises(
        ParameterError, match=r"restitution = 1\.75: must be .* 0 <= restitution <= 1"
    ):
        vi.Oscillator(xi=0.011, mu=0.04, restitution="175 %")


def test_an_amplitude_of_either_sign():
    """Free vibration starts on either side, with or without a unit."""
    for amplitude in (-5, 5):
        given = vi.decay(RIG, "4 mm", amplitude=f"{amplitude} mm", cycles=4)
        plain = vi.decay(RIG, 4e-3 / LENGTH, amplitude=amplitude * 1e-3 / LENGTH, cycles=4)
        np.testing.assert_allclose(given.x, plain.x, rtol=1e-11)
        assert np.sign(given.x.ravel()[0]) == np.sign(amplitude)


def test_the_load_of_a_point_with_friction_is_an_amplitude():
    """A sweep of the load starts from F0, whatever the load of the point; a factor has no unit."""
    of_3, of_9 = (RIG.at("19.5 Hz", "4 mm", friction="1 N", load=f"{load} N") for load in (3, 9))
    options = {"settling": 60, "sweep": "up"}
    given = vi.bifurcation_diagram(of_9, "load", ["3 N", "3.3 N"], **options)
    assert "over load = 3 to 3.3 N" in repr(given)
    factors = vi.bifurcation_diagram(of_3.structure, of_3.load, "load", [1.0, 1.1], **options)
    assert "over load = 1 to 1.1:" in repr(factors)
    np.testing.assert_allclose(given.column("q_0"), factors.column("q_0"), atol=1e-9)
    harmonics = RIG.at("19.5 Hz", "4 mm", friction="1 N", load=vi.Load(ratio(19.5), sine=[1.5, 0]))
    with pytest.raises(ParameterError, match="must be numbers, factors of the `Load`"):
        vi.bifurcation_diagram(harmonics, "load", ["3 N", "3.3 N"])


def test_an_argument_for_structures_is_named():
    """An unknown argument of an oscillator is answered with those it has."""
    with pytest.raises(
        TypeError, match=r"basins\(\) got .* 'settling', which is for structures; .* cycles"
    ):
        vi.basins(RIG.at("19.5 Hz", "4 mm"), states=3, settling=20)
    with pytest.raises(TypeError, match=r"basins\(\) got .* argument 'cycle'; for an oscillator"):
        vi.basins(RIG.at("19.5 Hz", "4 mm"), states=3, cycle=20)


def test_a_point_in_physical_units():
    """Numbers of a point, and the representation of response quantities, have the units of the rig."""
    point = RIG.at("19.5 Hz", "4 mm", friction="0.2 N")
    shown = vi.physical(point, "mm N s")
    assert (shown.clearance, shown.amplitude, shown.friction) == pytest.approx(
        (4, 6, 0.2), rel=1e-12
    )
    assert shown.r == point.r
    run = vi.simulate(RIG, "19.5 Hz", "4 mm", cycles=3)
    assert "over 0.153846 s" in repr(run.physical().quantities())
    assert " mm, of accelerations " in repr(run.physical("mm N s").quantities())
    # dimensionless numbers name their units, also where the point is treated as a structure
    for quantities in (run.quantities(), vi.simulate(point, cycles=3).quantities()):
        assert re.search(
            r"over \S+/omega: .* F0/K, of accelerations \S+ omega\^2 F0/K;", repr(quantities)
        )


def test_a_printed_motion_is_in_the_units_of_the_rig():
    """Its table has lengths in mm and velocities in mm/s, as in a CSV; without units it has none."""
    motion = vi.equispaced(RIG, "19.5 Hz", "8 mm")[0]
    first, point, *_, row, _ = str(motion).splitlines()
    assert first.endswith("X, Z, A, x in mm, X', Z' in mm/s")
    assert point.startswith("  19.5 Hz, d = 8 mm (r = ")
    length = 1e3 * LENGTH
    omega = math.sqrt(42e3 / 2.7)
    assert [float(text) for text in row.split()[2:5]] == pytest.approx(
        [motion.X[0] * length, motion.Z[0] * length, motion.X_dot_before[0] * length * omega],
        abs=1e-4,
    )
    plain = vi.Oscillator(xi=RIG.xi, mu=RIG.mu, restitution=RIG.restitution)
    text = str(vi.equispaced(plain, motion.r, motion.clearance)[0])
    assert " mm" not in text
    assert f"{motion.X[0]:11.4f}" in text


def test_notebooks_show_the_units_of_the_rig():
    """A point has its frequency, clearance and load with units beside the ratios, and a motion its extremes."""
    point = RIG.at("19.5 Hz", "4 mm", "3 N")
    cells = dict(
        re.findall(r"<t[hd][^>]*>([^<]*)</t[hd]><td[^>]*>([^<]*)</td>", point._repr_html_())
    )
    assert (cells["f"], cells["d"], cells["load"]) == ("19.5 Hz", "4 mm", "3 N")
    assert (float(cells["d K/F0"]), float(cells["load over F0"])) == pytest.approx((28, 0.5))
    motion = vi.equispaced(RIG, "19.5 Hz", "8 mm")[0]
    extremes = f"{1e3 * LENGTH * motion.x_min:.6g} to {1e3 * LENGTH * motion.x_max:.6g} mm"
    assert extremes in motion._repr_html_()


def test_a_run_without_impacts_is_named_in_the_units_of_the_rig():
    """The amplitude and half the clearance are in mm, and the run is shown as it shows itself."""
    run = vi.simulate(RIG, "19.5 Hz", "12 mm", cycles=30)
    r = ratio(19.5)
    amplitude = 1e3 * LENGTH / math.hypot(1 - r * r, 2 * 0.011 * r)
    with pytest.raises(vi.ParameterError) as caught:
        vi.exact(RIG, "19.5 Hz", "12 mm", run)
    message = str(caught.value)
    assert message.startswith(f"guess = {run!r}: must have impacts")
    assert f"settles to A = {amplitude:.6g} mm, below d/2 = 6 mm" in message


def test_a_tolerance_with_a_unit_is_a_deviation():
    """A tolerance in mm that does not include 0 is refused, also if its dimensionless numbers include 1."""
    for tolerance in (("0.1 mm", "0.2 mm"), ("-0.2 mm", "-0.1 mm")):
        with pytest.raises(
            ParameterError, match=r"tolerance\['clearance'\] = .*mm.*: must include 0"
        ):
            vi.design(
                RIG, r=("20 Hz", "20.4 Hz"), free={"clearance": ("3 mm", "8 mm")},
                tolerance={"clearance": tolerance}, samples=0,
            )  # fmt: skip


@pytest.mark.parametrize(
    ("name", "value"),
    [("M", "-2.7 kg"), ("K", "0 kN/m"), ("m", "-110 g"), ("F0", "-6 N"), ("C", "-2 N s/m"), ("d", "-4 mm"),
     ("f", "-3 Hz"), ("frequency", "-19.5 Hz"), ("duration", "-1 s"), ("rate", "-1 kHz"), ("known K", "-42 kN/m"),
     ("error of known K", "-1 %"), ("friction", "-0.1 N")],
)  # fmt: skip
def test_values_of_rigs_are_shown_as_given(name, value):
    """A value that must be positive is refused with its unit."""
    rig = {"M": "2.7 kg", "K": "42 kN/m", "m": "0.11 kg", "restitution": 0.75, "F0": "6 N"}
    own = {"d": "4 mm", "frequency": "19.5 Hz"}
    damping = {"C": value} if name == "C" else {"xi": "1.1 %"}
    calls = {
        "d": lambda: RIG.structure(d=value),
        "f": lambda: RIG.base_load(value, acceleration="1 m/s^2"),
        "frequency": lambda: vi.VirtualRig(**rig, xi=0.01, **own | {name: value}),
        "friction": lambda: vi.VirtualRig(**rig, xi=0.01, **own, friction=value),
        "duration": lambda: vi.VirtualRig(**rig, xi=0.01, **own).record(value),
        "rate": lambda: vi.SensorRecord(value, load=np.ones(20), acceleration=np.ones(20)),
        "known K": lambda: vi.identify(RECORD, known={"K": value}),
        "error of known K": lambda: vi.identify(RECORD, known={"K": ("42 kN/m", value)}),
    }
    with pytest.raises(ParameterError) as caught:
        calls.get(name, lambda: vi.Oscillator.from_dimensional(**rig | {name: value} | damping))()
    assert str(caught.value).startswith(f"{name} = {value}: must be a finite number with {name} >")
