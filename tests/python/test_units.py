"""Physical units: conversion of every result, round trips through files, and axes."""

import math
import re

import numpy as np
import pytest
import vibroimpact as vi
from pandas.testing import assert_frame_equal
from vibroimpact.base.errors import ParameterError, ParameterTypeError
from vibroimpact.identification.known import known_values
from vibroimpact.results.tables import language
from vibroimpact.systems.units import MIXED, NAMED, powers_of

M, K, m, F0 = 2.7, 42e3, 0.11, 6.0
C = 2 * 0.0114 * math.sqrt(K * M)
GIVEN = {"C": C, "m": m, "restitution": 0.75}
RIG = vi.Oscillator.from_dimensional(M=M, K=K, F0=F0, **GIVEN)
UNEVEN = vi.Oscillator.from_dimensional(M=M, K=K, C=C, m=m, restitution=(0.75, 0.61), F0=F0)
UNITS = RIG.units()
R, D = UNITS.frequency_ratio(f=19.5), UNITS.clearance(d=0.004)
MM = "mm N s"


def results():
    """A result of every study, by name."""
    run = vi.simulate(UNEVEN, r=0.9, clearance=6.0, cycles=6, discard=300)
    motion = vi.equispaced(RIG, R, D)[0]
    around = {"r": (0.98, 1.02), "clearance": (20.0, 40.0)}
    short = {"states": 2, "settling": 50}
    return {
        "Motion": motion, "rest": vi.exact(UNEVEN, 0.9, 6.0, run), "Trajectory": run,
        "FoundMotions": vi.find(RIG, R, D, max_impacts=2, max_cycles=1, states=0),
        "Branch": vi.branch(motion, "clearance", (0.8 * D, 1.2 * D)), "Zone": vi.zone(RIG, "RL", **around),
        "Atlas": vi.atlas(RIG, **around, max_impacts=2, survey=0),
        "Response": vi.response(RIG, [0.98, 1.0], clearance=D, **short),
        "Bifurcation": vi.bifurcation_diagram(RIG, "clearance", [D, 1.1 * D, 1.2 * D], r=R, **short),
        "of r": vi.bifurcation_diagram(RIG, "r", [R, 1.01 * R], clearance=D, **short),
        "Lyapunov": vi.lyapunov(RIG, R, D, discard=20, cycles=100),
        "Basins": vi.basins(RIG, R, D, (("x", -9, 9, 3), ("z_dot", -9, 9, 3)), cycles=100, probes=5),
        "Decay": vi.decay(RIG, 0.5, cycles=4),
    }  # fmt: skip


@pytest.fixture(scope="module")
def every():
    return results()


def test_units_of_the_core():
    """Each column of the oscillator has a convertible unit, or none."""
    for about in language()["results"].values():
        for column in about["columns"]:
            if column["model"] != "structure" and column["unit"] != MIXED:
                UNITS.scale(column["unit"])


def test_conversion():
    """Scales follow their definitions, and give the same quantity in other units of length, force and time."""
    assert UNITS.omega == math.sqrt(K / M)
    for unit, value, name in (
        ("F0/K", F0 / K, "m"), ("omega F0/K", F0 / K * UNITS.omega, "m/s"),
        ("omega^2 F0/K", F0 / M, "m/s^2"), ("F0", F0, "N"), ("F0^2/K", F0**2 / K, "N m"),
        ("F0/omega", F0 / UNITS.omega, "N s"), ("1/omega", 1 / UNITS.omega, "s"), ("omega", UNITS.omega, "1/s"),
        ("K/F0", K / F0, "1/m"), ("rad", 1, "rad"), ("", 1, ""), ("1/load cycle", 1, "1/load cycle"),
    ):  # fmt: skip
        assert UNITS.scale(unit) == pytest.approx(value, rel=1e-15)
        assert UNITS.name(unit) == name
    other = UNITS.to("in lbf ms")
    inch, pound, ms = 0.0254, 4.4482216152605, 1e-3
    for unit, factor in (
        ("F0/K", inch), ("omega F0/K", inch / ms), ("omega^2 F0/K", inch / ms**2), ("F0", pound),
        ("F0^2/K", pound * inch), ("F0/omega", pound * ms), ("1/omega", ms),
    ):  # fmt: skip
        assert other.scale(unit) * factor == pytest.approx(UNITS.scale(unit), rel=1e-14)
    assert other.to("SI").M == pytest.approx(M, rel=1e-14)
    assert UNITS.to("m N s") == UNITS
    assert other.hertz == "kHz"
    for micro in ("\N{MICRO SIGN}", "\N{GREEK SMALL LETTER MU}", "u"):
        assert UNITS.to(f"{micro}m N {micro}s") == UNITS.to("um N us")
    # the dimensionless system does not depend on the units in which it is given
    assert UNITS.to(MM).frequency_ratio(f=19.5) == pytest.approx(R, rel=1e-14)
    assert UNITS.to(MM).clearance(d=4.0) == pytest.approx(D, rel=1e-14)
    tonnes = vi.Oscillator.from_dimensional(
        M=M / 1000, K=K / 1000, C=C / 1000, m=m / 1000, restitution=0.75, F0=F0, units=MM
    )
    assert (tonnes.xi, tonnes.mu) == pytest.approx((RIG.xi, RIG.mu), rel=1e-15)
    assert tonnes.units().to("SI").length == pytest.approx(UNITS.length, rel=1e-14)


@pytest.mark.parametrize("unit", [MIXED, "F0/K/kg", "kg F0"])
def test_units_that_are_refused(unit):
    with pytest.raises(ParameterError, match=r"^unit = "):
        powers_of(unit)


@pytest.mark.parametrize("names", ["mm N", "N mm s", "furlong N s", "", "mm N s s", "MM n S"])
def test_names_that_are_refused(names):
    for call in (
        lambda: UNITS.to(names), lambda: vi.Units(M, K, F0, names),
        lambda: vi.Oscillator.from_dimensional(M=M, K=K, units=names, **GIVEN),
        lambda: vi.equispaced(RIG, R, D)[0].physical(names),
    ):  # fmt: skip
        with pytest.raises(ParameterError, match=r"must be units of length, force and time"):
            call()
    with pytest.raises(ParameterTypeError, match=r"^names = 3"):
        UNITS.to(3)


def test_what_is_missing_is_named():
    """Units need M, K and F0; a structure uses the units of its user."""
    without = vi.Oscillator.from_dimensional(M=M, K=K, **GIVEN)
    motion = vi.equispaced(without, R, D)[0]
    with pytest.raises(ParameterError, match=r"^F0 = None"):
        motion.physical()
    assert motion.physical(without.units(F0=F0)).clearance == pytest.approx(0.004)
    plain = vi.Oscillator(xi=RIG.xi, mu=RIG.mu, restitution=RIG.restitution)
    with pytest.raises(ParameterError, match=r"^M = None"):
        vi.equispaced(plain, R, D)[0].physical()
    with pytest.raises(ParameterError, match=r"^F0 = 3.0: must be given with M and K"):
        vi.Oscillator(xi=0.1, mu=0.1, restitution=0.5, F0=3.0)
    wall = vi.Structure(mass=[1], damping=[0.1], stiffness=[1], gaps=[vi.Gap([1], 1, 0.8)])
    with pytest.raises(ParameterTypeError, match="a Structure uses the units that you choose"):
        vi.simulate(wall, vi.Load(1.0, cosine=[1]), cycles=3).physical()
    for wrong in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(ParameterError, match=r"^F0 = "):
            vi.Oscillator.from_dimensional(M=M, K=K, F0=wrong, **GIVEN)


def test_every_result_knows_the_units(every):
    """The oscillator of each result, and of its parts, has M, K, F0 and their units."""
    for name, result in every.items():
        assert result.osc.units() == UNITS, name
    assert every["Branch"][0].osc.units() == UNITS
    assert all(zone.osc.units() == UNITS for zone in every["Atlas"].zones)
    assert all(motion.osc.units() == UNITS for motion in every["FoundMotions"])
    assert "force = 6.0" in every["Zone"].to_namelist()


def test_namelist(tmp_path):
    """A namelist gives the units to its results; errors name the key."""
    text = "&system xi = 0, mu = 0, restitution = 1, 1, r = 0.98, {} /\n&simulate clearance = 28, cycles = 2 /\n"
    path = tmp_path / "rig.nml"
    path.write_text(text.format("mass = 2.7, stiffness = 42000, force = 6, unit_names = 'm N s'"))
    case = vi.read_namelist(path)[0]
    assert case.osc.units() == UNITS
    assert case.run()[0].osc.units() == UNITS
    path.write_text(text.format("mass = 2700, stiffness = 42, force = 6, unit_names = 'mm N s'"))
    assert vi.read_namelist(path)[0].osc.units().names == MM
    for wrong, name in (
        ("mass = 2.7", "mass"), ("force = 6", "force"), ("unit_names = 'm N s'", "unit_names"),
        ("mass = 0, stiffness = 1", "mass"), ("mass = 1, stiffness = 1, force = nan", "force"),
        ("mass = 1, stiffness = 1, unit_names = 'mm N'", "unit_names"),
        ("mass = 1, stiffness = 1, unit_names = 'N mm s'", "unit_names"),
        ("mass = 1, stiffness = 1, unit_names = 'mm N s s'", "unit_names"),
    ):  # fmt: skip
        path.write_text(text.format(wrong))
        with pytest.raises(ParameterError, match=name):
            vi.read_namelist(path)


def case_in(tmp_path, system, study):
    """The only case of a namelist."""
    path = tmp_path / "case.nml"
    path.write_text(f"&system restitution = 1, {system} /\n&{study} /\n")
    (case,) = vi.read_namelist(path)
    return case


@pytest.mark.parametrize("names", ["m N s", "mm N s", "in lbf ms"])
def test_namelist_in_units(tmp_path, names):
    """Numbers in `units`, and texts with units, are converted to the numbers that Python's verbs take."""
    own = vi.Oscillator.from_dimensional(
        M="2.7 kg", K="42 kN/m", C="7.7 N s/m", m="0.11 kg", restitution=1.0, F0="6 N", units=names
    )
    as_text = (
        "mass = '2.7 kg', stiffness = '42 kN/m', damping = '7.7 N s/m', free_mass = '0.11 kg', "
        "force = '6 N', units = '{}', r = '19.5 Hz'"
    )
    as_number = (
        f"mass = {own.M!r}, stiffness = {own.K!r}, xi = {own.xi!r}, mu = {own.mu!r}, force = {own.F0!r}, "
        "units = '{}', r = '1170 rpm'"
    )
    units = own.units()
    length = units.to("SI").length
    travel = 4e-3 / length
    study = "simulate clearance = {}, cycles = 2, z = '-1 mm', z_dot = {}, load = {}"
    texts = [
        case_in(tmp_path, system.format(names), study.format(*values))
        for system in (as_text, as_number)
        for values in (
            ("'4 mm'", "'0.5 m/s'", "'3 N'"),
            (
                4e-3 / length * units.length,
                0.5 / units.to("SI").velocity * units.velocity,
                0.5 * units.F0,
            ),
        )
    ]
    r = units.frequency_ratio("19.5 Hz")
    for case in texts:
        assert case.osc.units().names == names
        found = [case.osc.xi, case.osc.mu, case.osc.M, case.osc.K, case.osc.F0, case.r]
        assert found == pytest.approx([own.xi, own.mu, own.M, own.K, own.F0, r], rel=1e-14)
        own_keys = [case.keys[key] for key in ("clearance", "z", "z_dot", "load")]
        wanted = [travel, -travel / 4, 0.5 / units.to("SI").velocity, 0.5]
        assert own_keys == pytest.approx(wanted, rel=1e-14)
        # the case is dimensionless, so its text is an input with the same digits
        (tmp_path / "again.nml").write_text(case.text)
        assert vi.read_namelist(tmp_path / "again.nml")[0].text == case.text


def test_each_unit_is_that_of_python(tmp_path):
    """Each unit has the same size in a namelist as in Python."""
    rig = "mass = 1, stiffness = 1, force = 1, xi = 0.1, mu = 0.1, units = 'm N s', r = "
    kinds = {(1, 0, 0): "x", (0, 1, 0): "load", (0, 0, 1): "t"}
    for name, (size, powers, angular) in NAMED.items():
        for spelled in {
            name,
            name.replace("u", "\N{MICRO SIGN}"),
            name.replace("u", "\N{GREEK SMALL LETTER MU}"),
        }:
            if powers in kinds:
                case = case_in(
                    tmp_path,
                    rig + "0.5",
                    f"simulate cycles = 1, clearance = 1e9, {kinds[powers]} = '3 {spelled}'",
                )
                assert case.keys[kinds[powers]] == pytest.approx(3 * size, rel=1e-15), spelled
            elif powers == (0, 0, -1) and angular:
                case = case_in(tmp_path, rig + f"'3 {name}'", "simulate cycles = 1, clearance = 1")
                assert case.r == pytest.approx(3 * size, rel=1e-15), name
            elif name == "%":
                case = case_in(
                    tmp_path, "mu = 0.1, r = 0.5, xi = '3 %'", "simulate cycles = 1, clearance = 1"
                )
                assert case.osc.xi == 0.03
            elif not angular:
                text = f"mass = '3 {name}', stiffness = 1, force = 1, mu = 0.1, xi = 0.1, r = 0.5"
                case = case_in(tmp_path, text, "simulate cycles = 1, clearance = '1 m'")
                assert case.osc.M == pytest.approx(3 * size, rel=1e-15), name


@pytest.mark.parametrize(
    ("rig", "study", "why"),
    [
        ("mass = 2.7, stiffness = 42e3", "simulate clearance = 0.004, cycles = 2", "two ways"),
        ("mass = 2.7, stiffness = 42e3, force = 6", "simulate clearance = 0.004, cycles = 2", "two ways"),
        ("mass = 2.7, stiffness = 42e3, units = 'm N s'", "simulate clearance = 0.004, cycles = 2", "force"),
        ("", "simulate clearance = '4 mm', cycles = 2", "mass, stiffness and force"),
        ("mass = 2.7, stiffness = 42e3, force = 6", "simulate clearance = '4 N', cycles = 2", "of a length"),
        ("mass = 2.7, stiffness = 42e3, force = 6", "simulate clearance = '4 q', cycles = 2", "unknown unit q"),
        ("mass = 2.7, stiffness = 42e3, force = 6", "simulate clearance = '4', cycles = 2", "with its unit"),
        ("", "simulate clearance = 4, x = '', cycles = 2", "with its unit"),
        (
            "mass = 1, stiffness = 1, units = 'm N s', force = 1",
            "simulate clearance = 4, x = ' '",
            "with its unit",
        ),
        ("mass = '3 N', stiffness = 42e3", "simulate clearance = 4, cycles = 2", "not that of a mass"),
        ("mass = 2, stiffness = 2, damping = 4", "simulate clearance = '4 mm', cycles = 2", "if damping is given"),
        (
            "mass = 2.7, stiffness = 42e3, force = 6, units = 'm N s'",
            "bifurcation parameter = 'clearance', low = '19 Hz', high = 2, values = 3",
            "of a length",
        ),
        ("mass = 1, stiffness = 1, units = 'm N s', unit_names = 'm N s'", "simulate clearance = 4", "unit_names"),
    ],
)  # fmt: skip
def test_namelist_refuses_what_has_no_reading(tmp_path, rig, study, why):
    """An ambiguous number, and a text with the wrong kind of unit, are refused."""
    with pytest.raises(ParameterError, match=why):
        case_in(tmp_path, f"xi = 0.1, mu = 0.1, r = 0.98{', ' * bool(rig)}{rig}", study)


def test_planes_and_lines_in_units(tmp_path):
    """Bounds have the unit of their parameter or axis, whichever key comes first."""
    rig = "mass = 2.7, stiffness = 42e3, xi = 0.01, mu = 0.04, force = 6, units = 'm N s', r = 0.98"
    length, speed = 6 / 42e3, 6 / np.sqrt(2.7 * 42e3)
    case = case_in(
        tmp_path, rig,
        "basins low = '-1 mm', '-10 mm/s', axes = 'x', 'x_dot', high = 0.001, 0.01, values = 3, 3, "
        "clearance = 0.004",
    )  # fmt: skip
    assert case.keys["low"] == pytest.approx([-1e-3 / length, -1e-2 / speed], rel=1e-14)
    assert case.keys["high"] == pytest.approx([1e-3 / length, 1e-2 / speed], rel=1e-14)
    states = "basins list = 0.1, 0.001, 0.01, 0.002, 0.02, 0, 0, 0, 0, '1 m/s', clearance = 0.01"
    with pytest.raises(ParameterError, match="list"):  # numbers or texts
        case_in(tmp_path, rig, states)
    case = case_in(tmp_path, rig, states.replace("'1 m/s'", "1"))
    omega = np.sqrt(42e3 / 2.7)
    wanted = [
        0.1 * omega,
        1e-3 / length,
        0.01 / speed,
        2e-3 / length,
        0.02 / speed,
        0,
        0,
        0,
        0,
        1 / speed,
    ]
    assert case.keys["list"] == pytest.approx(wanted, rel=1e-14)
    line = "bifurcation low = {}, high = {}, parameter = 'clearance', values = 3"
    case = case_in(tmp_path, rig, line.format("'2 mm'", "'4 mm'"))
    assert [case.keys["low"], case.keys["high"]] == pytest.approx(
        [2e-3 / length, 4e-3 / length], rel=1e-14
    )
    assert case_in(tmp_path, rig, line.format("0.002", "0.004")).text == case.text


def test_motion_in_physical_units(every):
    """Each attribute is that of the dimensionless motion times its unit; the samples obey Newton's law."""
    motion, p = every["Motion"], every["Motion"].physical()
    old = UNITS.motion(motion)
    for name in old.keys() - {"d", "Omega", "t"}:
        np.testing.assert_allclose(getattr(p, name), old[name], rtol=1e-14)
    assert p.clearance == pytest.approx(0.004, rel=1e-14)
    assert p.frequency == pytest.approx(19.5, rel=1e-14)
    assert (p.r, p.pattern, p.stable) == (motion.r, motion.pattern, motion.stable)
    np.testing.assert_array_equal(p.alpha, motion.alpha)
    t = np.linspace(0, p.period, 301)
    s = p.sample(t)
    phase = 2 * np.pi * 19.5 * t + motion.load_phase
    np.testing.assert_allclose(s.load, F0 * np.sin(phase), atol=1e-9 * F0)
    np.testing.assert_allclose(
        M * s.X_ddot + C * s.X_dot + K * s.X, s.load, atol=1e-9 * K * p.x_max
    )
    assert np.abs(s.Y).max() <= 0.002 * (1 + 1e-12)
    np.testing.assert_allclose(np.gradient(s.X, t)[5:20], s.X_dot[5:20], rtol=0.02)


def test_quantities_in_physical_units(every):
    """Momentum, energy and the transmitted force have the values of their definitions."""
    for name in ("Motion", "rest", "Trajectory"):
        p = every[name].physical()
        q = p.quantities()
        events = p.events[p.events["kind"] == "impact"]
        momentum = m * np.abs(events["z_dot_after"] - events["z_dot_before"])
        np.testing.assert_allclose(q.impacts["impulse"], momentum, rtol=1e-8, atol=1e-12)
        energy = [
            0.5 * (M * events[f"x_dot_{when}"] ** 2 + m * events[f"z_dot_{when}"] ** 2)
            for when in ("before", "after")
        ]
        np.testing.assert_allclose(
            q.impacts["loss"], energy[0] - energy[1], atol=1e-12 * energy[0].max()
        )
        assert q.damping_loss == pytest.approx(C * q.x_dot.rms**2 * q.duration, rel=1e-12)
        assert q.work == pytest.approx(q.damping_loss + q.impact_loss + q.energy_change, rel=1e-9)
        assert q.duration == pytest.approx(q.cycles / p.frequency, rel=1e-12)
        harmonic = abs(K + 2j * np.pi * p.frequency * C) * q.x.amplitude
        if name != "Trajectory":
            assert q.transmitted.amplitude == pytest.approx(harmonic, rel=1e-10)
    in_mm = every["Motion"].physical(MM).quantities()
    assert in_mm.x_ddot.peak == pytest.approx(
        1000 * every["Motion"].physical().quantities().x_ddot.peak
    )


@pytest.mark.parametrize(
    ("parameter", "unit", "steps"),
    [("frequency", "Hz", ("19.5 Hz", 19.5, 1e-4)), ("clearance", "mm", ("4 mm", 4.0, 1e-4))],
)
def test_derivatives_in_physical_units(parameter, unit, steps):
    """Derivatives per hertz and per millimetre are those of motions at other frequencies and clearances."""
    text, value, step = steps
    motion = vi.exact(RIG, "19.5 Hz", "4 mm", vi.equispaced(RIG, R, D)[0])
    gradient = motion.physical(MM).gradient()
    assert gradient.units[parameter] == unit
    assert (gradient.units["x_max"], gradient.units["X_dot_before"]) == ("mm", "mm/s")
    assert gradient.units["multipliers"] == gradient.units["mu"] == gradient.units["R1"] == ""
    places = [
        {"frequency": "19.5 Hz", "clearance": "4 mm"}
        | {parameter: text.replace(f"{value:g}", f"{value + sign * step:.6f}")}
        for sign in (1, -1)
    ]
    above, below = (
        vi.exact(RIG, place["frequency"], place["clearance"], motion).physical(MM)
        for place in places
    )
    for name in ("x_max", "X", "X_dot_before", "Z", "A"):
        slope = (getattr(above, name) - getattr(below, name)) / (2 * step)
        scale = np.abs(gradient.values[name]).max()
        assert gradient[name, parameter] == pytest.approx(slope, rel=1e-6, abs=1e-8 * scale)
        np.testing.assert_allclose(gradient.values[name], getattr(motion.physical(MM), name))


def test_derivatives_of_runs_in_physical_units():
    """Quantities, and the initial state by which they are differentiated, have their units; a table shows them."""
    run = vi.simulate(RIG, "19.5 Hz", "4 mm", cycles=2)
    plain, found = run.gradient(), run.physical(MM).gradient()
    assert len(run.events) == 0
    assert (found.units["final_z_dot"], found.units["x_dot"], found.units["t"]) == (
        "mm/s",
        "mm/s",
        "s",
    )
    units = RIG.units().to(MM)
    ratio = found["final_x", "frequency"] / plain["final_x", "r"]
    assert ratio == pytest.approx(units.length / units.frequency, rel=1e-14)
    text = str(found)
    assert all(
        part in text for part in ("19.5 Hz, d = 4 mm", "frequency [Hz]", "final_z_dot [mm/s]")
    )
    pytest.importorskip("xarray")
    table = found.to_xarray()
    assert table["final_x"].attrs["units"] == "mm"
    assert table["parameter_unit"].sel(parameter="clearance") == "mm"


@pytest.mark.parametrize("extension", [".json", ".nc", ".mat"])
def test_files(every, tmp_path, extension):
    """A file restores the result with its units; in physical units it gives the same view."""
    for name, result in every.items():
        path = tmp_path / f"{name}{extension}"
        result.save(path)
        assert vi.load(path).osc.units() == UNITS, name
        p = result.physical(MM)
        p.save(path)
        again = vi.load(path)
        assert isinstance(again, vi.Physical), name
        assert again.units == p.units, name
        assert again.to_json() == p.to_json(), name


def test_csv(every, tmp_path):
    """The columns are those of the dimensionless file times their units, and the header is an input."""
    for name, result in every.items():
        path = tmp_path / f"{name}.csv"
        result.physical(MM).save(path)
        lines = path.read_text().splitlines()
        head = [line for line in lines if line.startswith("#")]
        assert head[0].startswith("# ! vibroimpact ")
        rows = lines[len(head) :]
        frame, plain = result.physical(MM).to_pandas(), result.to_pandas(units="dimensionless")
        assert_frame_equal(result.to_pandas(), frame)
        assert_frame_equal(result.to_pandas(units="mm N s"), frame)
        assert rows[0].split(",") == [*frame.columns]
        assert len(rows) == 1 + len(frame) == 1 + len(plain)
        units = frame.attrs["units"]
        assert {*units} <= {*frame.columns}, name
        for column, other in zip(frame.columns, plain.columns, strict=True):
            unit = units.get(column, "")
            factor = {
                "mm": 1000 * UNITS.length,
                "mm/s": 1000 * UNITS.velocity,
                "s": UNITS.time,
            }.get(unit)
            factor = {"Hz": UNITS.frequency, "N mm": 1000 * UNITS.energy}.get(unit, factor)
            if factor and frame[column].dtype == float:
                np.testing.assert_allclose(frame[column], plain[other] * factor, rtol=1e-13)
        if "Motion" in name or name == "Trajectory":
            assert vi.read_namelist(path)[0].osc.units() == UNITS


def numbers_in(path):
    """The first line of a CSV, its column names, and its cells."""
    lines = path.read_text().splitlines()
    names, *rows = [line.split(",") for line in lines if not line.startswith("#")]
    return lines[0], names, np.array(rows)


def units_in(line):
    """The columns with units that the first line of a CSV names, with # for the place within a row."""
    return {re.sub(r"_\d+", "_#", part) for part in line.partition("; ")[2].split(", ")}


def test_csv_of_the_core(every, tmp_path):
    """`save` writes the columns of a rig in Hz and mm, or in other units."""
    path = tmp_path / "result.csv"
    for name, result in every.items():
        result.save(path)
        head, names, cells = numbers_in(path)
        result.physical(MM).save(path)
        line, others, wanted = numbers_in(path)
        assert units_in(line) == units_in(head), name
        kept = [names.index(other) for other in others]
        shape = np.shape(wanted)
        assert len(kept) == len(names), name
        for i, j in zip(kept, range(len(others)), strict=True):
            assert_cells(cells[:, i].reshape(shape[0], -1), wanted[:, j].reshape(shape[0], -1))
        assert ("frequency Hz" in head) == ("frequency" in names), name
        result.save(path, units="dimensionless")
        again = numbers_in(path)[1]
        assert [n for n in again if n not in names] == ["r"] * ("frequency" in names), name
    every["of r"].save(path, units="SI")
    head, names, cells = numbers_in(path)
    assert "frequency Hz" in head
    assert " x m," in head
    r = sorted({float(cell) for cell in cells[:, names.index("frequency")]})
    np.testing.assert_allclose(r, np.array([R, 1.01 * R]) * UNITS.frequency, rtol=1e-14)


def test_a_result_with_one_empty_word_is_written_in_other_units(tmp_path):
    """If no state has settled all labels are empty; the core counts an empty word as one."""
    result = vi.bifurcation_diagram(RIG, "r", [0.98, 0.99], clearance="4 mm", states=2, settling=50)
    assert set(result.labels.ravel().tolist()) == {""}
    rows = []
    for units in (None, "SI", "mm N s", "dimensionless"):
        result.save(tmp_path / "result.csv", units=units)
        rows.append(len(numbers_in(tmp_path / "result.csv")[2]))
    assert rows == rows[:1] * 4


def assert_cells(found, wanted):
    """Check that numbers agree, and that other cells are the same."""
    for one, other in zip(found.ravel(), wanted.ravel(), strict=True):
        try:
            # a difference of positions cancels
            assert float(one) == pytest.approx(float(other), rel=1e-13, abs=1e-12, nan_ok=True)
        except ValueError:
            assert one == other


def test_datasets(every):
    """Variables of a dataset name their physical units; a frequency ratio becomes a frequency."""
    data = every["Response"].physical().to_xarray()
    assert data["frequency"].attrs["units"] == "Hz"
    np.testing.assert_allclose(data["frequency"], np.array([0.98, 1.0]) * UNITS.frequency)
    np.testing.assert_allclose(data["clearance"], 0.004)
    chart = vi.chart(RIG, "RL", np.linspace(0.95, 1.05, 5), np.linspace(10, 20, 4))
    found = vi.physical(chart, MM)
    assert found["clearance"].attrs["units"] == "mm"
    np.testing.assert_allclose(found["clearance"], np.linspace(10, 20, 4) * UNITS.length * 1000)
    np.testing.assert_allclose(found["x_max"], chart["x_max"] * UNITS.length * 1000)
    assert found["x_max"].dims == ("motion", "clearance", "frequency")
    np.testing.assert_array_equal(found["attenuation"], chart["attenuation"])
    from vibroimpact.plot import draw_chart

    for units, unit in (
        (UNITS.to(MM), "(mm)"),
        (None, "(mm)"),
        ("m N s", "(m)"),
        ("dimensionless", "F_0$"),
    ):
        ax = draw_chart(chart, units=units)
        assert ax.get_ylabel().endswith(unit)
        assert ax.get_xlabel().endswith("(Hz)") == (units != "dimensionless")
    pure = vi.Oscillator(xi=RIG.xi, mu=RIG.mu, restitution=RIG.restitution)
    plain = vi.chart(pure, "RL", [0.95, 1.05], [10.0, 20.0])
    assert draw_chart(plain).get_ylabel() == ax.get_ylabel()
    with pytest.raises(ParameterError, match="has no M, K and F0"):
        draw_chart(plain, units="mm N s")
    with pytest.raises(ParameterError, match="give the units as"):
        draw_chart(found)


def test_parts_of_results(every):
    """Motions of a batch and of a branch, special points, and pieces of a boundary."""
    pair = vi.periodic_batch(RIG, [0.95, 0.96], [[0, 0], [4.3, 4.4]], "RL")
    p = vi.physical(pair, MM)
    assert len(p) == 2
    np.testing.assert_allclose(p.clearance, pair.clearance * 1000 * UNITS.length, rtol=1e-14)
    np.testing.assert_allclose(p.X_dot_after, pair.X_dot_after * 1000 * UNITS.velocity, rtol=1e-14)
    np.testing.assert_allclose(p.frequency, [0.95 * UNITS.frequency, 0.96 * UNITS.frequency])
    np.testing.assert_array_equal(p.multipliers, pair.multipliers)
    assert p[1].x_max == pytest.approx(pair[1].x_max * 1000 * UNITS.length, rel=1e-14)
    assert [one.units.names for one in p[:]] == [MM, MM]
    branch = every["Branch"]
    point, own = branch.special_points[-1], branch.physical(MM).special_points[-1]
    assert own.clearance == pytest.approx(point.clearance * 1000 * UNITS.length, rel=1e-14)
    assert own.frequency == point.r * UNITS.frequency
    assert own.motion.x_max == pytest.approx(point.motion.x_max * 1000 * UNITS.length, rel=1e-14)
    assert (own.type, own.index, own.r) == (point.type, point.index, point.r)
    assert branch.physical(MM)[3].A == pytest.approx(branch[3].A * 1000 * UNITS.length, rel=1e-14)
    piece, own = every["Zone"].boundary[0], every["Zone"].physical(MM).boundary[0]
    np.testing.assert_allclose(own.clearance, piece.clearance * 1000 * UNITS.length, rtol=1e-14)
    np.testing.assert_allclose(own.frequency, piece.r * UNITS.frequency, rtol=1e-14)
    # these are x_i/D
    np.testing.assert_array_equal(own.x_over_D, piece.x_over_D)
    assert len(own) == len(piece)


def test_windows_and_columns_of_every_system(every):
    """A window has physical times; speeds, impulses and ends have their units."""
    run, units = every["Trajectory"], UNITS.to(MM)
    own = run.physical(MM)
    assert (own.start, own.end) == pytest.approx((run.start * units.time, run.end * units.time))
    middle = run.start + 0.4 * (run.end - run.start)
    whole, part = (
        own.quantities(window=(own.start, own.end)),
        run.quantities(window=(middle, run.end)),
    )
    assert whole.work == pytest.approx(own.quantities().work, rel=1e-12)
    shown = own.quantities(window=(middle * units.time, own.end))
    assert shown.work == pytest.approx(part.work * units.scale("F0^2/K"), rel=1e-9)
    assert own.plot(kind="load", window=(middle * units.time, own.end)) is not None
    motion, p = every["Motion"], every["Motion"].physical(MM)
    change = (
        np.abs(p.X_dot_after - p.X_dot_before) * units.scale("F0/omega") / units.scale("omega F0/K")
    )
    assert p.impulses == pytest.approx(change, rel=1e-9)
    assert p.speeds == pytest.approx(motion.speeds * units.scale("omega F0/K"), rel=1e-14)
    np.testing.assert_array_equal(p.gaps, motion.gaps)


@pytest.mark.slow
def test_animations(every, tmp_path):
    """The masses, walls and cursor in physical units, and an animation."""
    import matplotlib.pyplot as plt
    from vibroimpact.plot.animation import _Scene
    from vibroimpact.plot.history import history

    motion, units = every["Motion"], UNITS.to(MM)
    scenes = [
        _Scene(motion, history(motion, 1, units=chosen), plt.subplots(2)[1])
        for chosen in (None, units)
    ]
    for time in (0.0, 1.3, 4.0):
        for scene in scenes:
            scene.show(time)
        plain, own = scenes
        assert own.free.get_x() == pytest.approx(plain.free.get_x() * units.length, rel=1e-12)
        assert own.cursor.get_xdata()[0] == pytest.approx(time * units.time, rel=1e-12)
        assert own.text.get_text().startswith(f"t = {time * units.time:.4g} s   load ")
    assert plain.flash == own.flash
    plt.close("all")
    for name in ("Motion", "Trajectory"):
        film = every[name].physical(MM).animate(tmp_path / f"{name}.gif", seconds=0.2)
        assert film.exists()


def test_unknown_units_are_no_numbers(every):
    """A result without a form in physical units is an error rather than a dimensionless number."""
    p = every["Motion"].physical()
    for name in ("impact_maps", "multipliers_of", "to_namelist"):
        with pytest.raises(AttributeError):
            getattr(p, name)
    with pytest.raises(AttributeError, match=r"^values: "):
        _ = every["Bifurcation"].physical().values
    with pytest.raises(AttributeError, match="cannot be changed"):
        p.r = 3


LABELS = {
    "Motion": ("s", "mm"), "Trajectory": ("s", "mm"), "rest": ("s", "mm"), "Zone": ("Hz", "mm"),
    "Atlas": ("Hz", "mm"), "Decay": ("s", "mm"), "Basins": ("mm", "mm/s"),
    "Branch": ("mm", "A"), "Response": ("Hz", "A"), "Bifurcation": ("mm", "mm"), "of r": ("Hz", "mm"),
}  # fmt: skip


@pytest.mark.parametrize("name", LABELS)
def test_pictures(every, name):
    """The data of a picture in physical units are the dimensionless data times the units of its axes."""
    import matplotlib.pyplot as plt

    result = every[name]
    axes = [plt.figure().add_subplot() for _ in range(3)]
    options = {"kind": "history"} if hasattr(result, "sample") else {}
    result.plot(ax=axes[0], units="dimensionless", **options)
    result.physical(MM).plot(ax=axes[1], **options)
    # the units of the rig have metres, which are millimetres on axes
    result.plot(ax=axes[2], **options)
    assert axes[2].get_xlabel() == axes[1].get_xlabel()
    assert axes[2].get_ylabel() == axes[1].get_ylabel()
    for label, unit in zip((axes[1].get_xlabel(), axes[1].get_ylabel()), LABELS[name], strict=True):
        assert label.endswith(f"({unit})") if unit != "A" else label.endswith("A$")
    factors = {
        "s": UNITS.time * (2 * np.pi / result.r if options else 1), "mm": 1000 * UNITS.length,
        "mm/s": 1000 * UNITS.velocity, "Hz": UNITS.frequency, "A": 1.0,
    }  # fmt: skip
    lines = [
        [line for line in ax.get_lines() if line.get_transform() == ax.transData] for ax in axes
    ]
    assert len(lines[0]) == len(lines[1]) == len(lines[2])
    for one, other in zip(lines[1], lines[2], strict=True):
        np.testing.assert_array_equal(one.get_xydata(), other.get_xydata())
    for one, other in zip(*lines[:2], strict=True):
        for unit, a, b in zip(LABELS[name], one.get_data(), other.get_data(), strict=True):
            wanted = np.asarray(a, float) * factors[unit]
            np.testing.assert_allclose(np.asarray(b, float), wanted, rtol=1e-12, atol=1e-15)
    plt.close("all")


def test_units_of_pictures(every):
    """Units of a picture are chosen by name; unknown units, and those of a structure, are refused."""
    import matplotlib.pyplot as plt

    branch = every["Branch"]
    for units, label in (
        ("um N s", "(um)"),
        (UNITS.to("cm N s"), "(cm)"),
        ("dimensionless", "$dK/F_0$"),
    ):
        assert branch.plot(units=units).get_xlabel().endswith(label)
    assert branch.physical("cm N s").plot().get_xlabel().endswith("(cm)")
    assert every["Motion"].plot(kind="acceleration").get_ylabel().endswith("(m/s²)")
    with pytest.raises(vi.ParameterError, match="units = 'parsec N s': must be units of length"):
        branch.plot(units="parsec N s")
    wall = vi.Structure([1], [0.1], [1], [vi.Gap([1], 1, 0.8)])
    run = vi.simulate(wall, vi.Load(1.0, cosine=[1]), cycles=3)
    with pytest.raises(vi.ParameterError, match="units = 'mm N s': must be left out; a Structure"):
        run.plot(units="mm N s")
    heavy = vi.Oscillator.from_dimensional(M=1e3, K=1e3, xi=0.01, m=9, restitution=0.7, F0=2e3)
    assert heavy.units().of_pictures.names == "m N s"
    plain = vi.Oscillator(xi=0.01, mu=0.1, restitution=0.7)
    axes = vi.equispaced(plain, 0.98, 30.0)[0].plot(kind="history")
    assert axes.get_ylabel() == "$X$, $Z$ ($F_0/K$)"
    plt.close("all")


def test_command_draws_in_physical_units(tmp_path, capsys):
    """`vibroimpact plot --units` draws items with units, and refuses others before anything is drawn."""
    from vibroimpact.commands.command import main

    text = "&system xi = 0, mu = 0, restitution = 1, 1, r = 0.98, {} /\n&simulate clearance = 28, cycles = 2 /\n"
    path = tmp_path / "rig.nml"
    path.write_text(text.format("mass = 2.7, stiffness = 42000, force = 6, unit_names = 'm N s'"))
    assert main(["plot", str(path), "--units", MM, "-o", str(tmp_path)]) == 0
    assert (tmp_path / "rig.png").exists()
    capsys.readouterr()
    for keys, units in (
        ("mass = 2.7, stiffness = 42000, unit_names = 'm N s'", MM),
        ("", "SI"),
        ("mass = 1, stiffness = 1, force = 1, unit_names = 'm N s'", "mm"),
    ):
        path.write_text(text.format(keys))
        assert main(["plot", str(path), "--units", units, "-o", str(tmp_path / "other")]) == 2
        assert "--units " in capsys.readouterr().err


def test_the_ends_of_a_trajectory_are_within_it():
    """Sampling at both ends works in any units, although conversion rounds the end times."""
    for f in np.linspace(13, 29, 30):
        rig = vi.Oscillator.from_dimensional(M=M, K=K, C=C, m=m, restitution=0.7, F0=F0)
        run = vi.simulate(rig, rig.units().frequency_ratio(f=f), 14.0, cycles=5).physical(
            "in lbf ms"
        )
        ends = run.sample([run.initial_state["t"], run.final_state["t"]])
        assert ends.X[1] == pytest.approx(run.final_state["x"], rel=1e-9)


# -- arguments with units

TEXTS = vi.Oscillator.from_dimensional(
    M="2.7 kg", K="42 kN/m", xi="1.1 %", m="0.11 kg", restitution=0.75, F0="6 N"
)  # fmt: skip
#: 19.5 Hz and 4 mm of that rig: Omega/omega and d K/F0.
AT = (2 * math.pi * 19.5 / math.sqrt(42e3 / 2.7), 4e-3 * 42e3 / 6)


def test_a_rig_from_texts():
    """Masses, stiffness, damping and force with units make the oscillator of their numbers, in any units."""
    assert (TEXTS.xi, TEXTS.M, TEXTS.K, TEXTS.F0) == (0.011, 2.7, 42e3, 6.0)
    C = 2 * 0.011 * math.sqrt(2.7 * 42e3)
    for given in ({"C": C}, {"C": f"{C!r} N s/m"}, {"C": f"{C / 1e3!r} N*s/mm"}):
        osc = vi.Oscillator.from_dimensional(M=2.7, K=42e3, m=0.11, restitution=0.75, F0=6, **given)
        assert osc.xi == pytest.approx(0.011, rel=1e-15)
    tonnes = vi.Oscillator.from_dimensional(
        M="2700000 mN s^2/m", K="42000 N/m", xi=0.011, m="110 mN s2/m", restitution=0.75, F0="6e-3 kN", units=MM
    )  # fmt: skip
    assert (tonnes.M, tonnes.K, tonnes.F0) == pytest.approx((2.7, 42.0, 6.0), rel=1e-15)
    assert tonnes.mu == pytest.approx(0.11 / 2700, rel=1e-15)


@pytest.mark.parametrize("texts", [
    ("19.5 Hz", "4 mm"), ("1170 rpm", "0.4 cm"), ("0.0195 kHz", "4000 um"), ("19.5Hz", ".004 m"),
    (f"{2 * math.pi * 19.5!r} rad/s", f"{4 / 25.4!r} in"),
])  # fmt: skip
def test_a_point_from_texts(texts):
    point = TEXTS.at(*texts, load="3 N")
    assert (point.r, point.clearance) == pytest.approx(AT, rel=1e-14)
    assert point.amplitude == 0.5
    units = TEXTS.units()
    assert (units.frequency_ratio(texts[0]), units.clearance(texts[1])) == pytest.approx(
        AT, rel=1e-14
    )


def test_quantities_of_pint():
    """Quantities of pint are recognised; 1 Hz is one cycle per second, where pint itself has 1 rad/s."""
    pint = pytest.importorskip("pint")
    ureg = pint.UnitRegistry()
    for frequency in (
        19.5 * ureg.Hz,
        1170 * ureg.rpm,
        2 * math.pi * 19.5 * ureg.rad / ureg.s,
        0.0195 * ureg.kHz,
    ):
        point = TEXTS.at(frequency, 4 * ureg.mm, 3 * ureg.newton)
        assert (point.r, point.clearance, point.amplitude) == pytest.approx((*AT, 0.5), rel=1e-12)
    # a ratio without a dimension is the bare number, whatever its units were
    M, K, F0 = 2.7 * ureg.kg, 42 * ureg.kN / ureg.m, 6 * ureg.newton
    natural = ((K / M) ** 0.5).to("1/s") / (2 * math.pi) * ureg.s * ureg.Hz
    ratios = TEXTS.at(19.5 * ureg.Hz / natural, 4 * ureg.mm * K / F0, 3 * ureg.newton / F0)
    assert (ratios.r, ratios.clearance, ratios.amplitude) == pytest.approx((*AT, 0.5), rel=1e-12)
    with pytest.raises(ParameterError, match=r"^r = .*: must be a frequency$"):
        TEXTS.at(19.5 * ureg.Hz / (K / M) ** 0.5, 28)  # of cycles and radians
    load = vi.Load(19.5 * ureg.Hz / natural, sine=[1, 0])
    assert load.frequency == pytest.approx(AT[0], rel=1e-12)
    run = vi.simulate(TEXTS.structure(28), load, cycles=1)  # no radians per second
    assert run.end == pytest.approx(2 * math.pi / AT[0], rel=1e-12)
    assert (
        vi.Load(19.5 * ureg.Hz, sine=[1, 0]).frequency == vi.Load("19.5 Hz", sine=[1, 0]).frequency
    )
    several = vi.equispaced_batch(TEXTS, 19.5 * ureg.Hz, [3.0, 4.0] * ureg.mm)
    assert several[0].clearance.ravel() == pytest.approx([21.0, 28.0])
    with pytest.raises(ParameterError, match=r"^r = .*: must be in Hz, rpm or rad/s$"):
        TEXTS.at(3 / ureg.s, 4 * ureg.mm)
    with pytest.raises(ParameterError, match=r"^clearance = .*: must have a mechanical unit$"):
        TEXTS.at("19.5 Hz", 4 * ureg.kelvin)
    heavy = vi.Oscillator.from_dimensional(
        M=2.7 * ureg.kg, K=42 * ureg.kN / ureg.m, xi=0.011, m=110 * ureg.gram, restitution=0.75, F0=6 * ureg.newton
    )  # fmt: skip
    assert (heavy.M, heavy.K, heavy.mu) == pytest.approx((2.7, 42e3, TEXTS.mu), rel=1e-14)


def test_values_of_rigs_take_units():
    """Units, bases, structures, virtual rigs and known values accept values with units."""
    inch = vi.Oscillator.from_dimensional(
        M="1 lb", K="65 lbf/in", xi=0.01, m="20 g", restitution=0.7, F0="2 N", units="in lbf s"
    )
    assert inch.units(F0="2 N") == inch.units()
    same = vi.Units(M="1 lb", K="65 lbf/in", F0="2 N", names="in lbf s")
    assert same.M == pytest.approx(inch.units().M, rel=1e-14)
    gap = inch.structure(d="25.4 mm").gaps[0].opening
    assert gap == pytest.approx(0.5, rel=1e-14)
    metres = inch.base_load("600 rpm", acceleration="0.0254 m/s^2")
    assert metres == pytest.approx(inch.base_load(10.0, acceleration=1.0), rel=1e-14)
    rig = vi.VirtualRig(
        M="2.7 kg", K="42 kN/m", m="110 g", d="5 mm", xi="1.5 %", restitution=0.75, F0="6 N",
        frequency="19.6 Hz", bandwidth="2 kHz",
    )  # fmt: skip
    assert rig == vi.VirtualRig(
        M=2.7, K=42e3, m=0.11, d=5e-3, xi=0.015, restitution=0.75, F0=6.0, frequency=19.6, bandwidth=2000.0
    )  # fmt: skip
    found = known_values({"M": "2.7 kg", "omega": "1200 rpm", "C": "7 N s/m"})
    wanted = known_values({"M": 2.7, "omega": 40 * np.pi, "C": 7.0})
    for one, other in zip(found, wanted, strict=True):
        assert one == pytest.approx(other, rel=1e-14)
    for call, message in (
        (lambda: vi.Units(M="2 N", K=1, F0=1), "M = 2 N: must be a mass"),
        (lambda: inch.base_load("3 mm", displacement=1), "f = 3 mm: must be a frequency"),
        (
            lambda: inch.base_load(3, acceleration="3 mm"),
            "acceleration = 3 mm: must be an acceleration",
        ),
        (lambda: known_values({"K": "3 N"}), "known K = 3 N: must be a stiffness"),
    ):
        with pytest.raises(ParameterError, match=f"^{message}"):
            call()


def test_every_verb_takes_units():
    """An argument with a unit is converted to its dimensionless number, in every verb."""
    r, clearance = TEXTS.at("19.5 Hz", "4 mm").r, TEXTS.at("19.5 Hz", "4 mm").clearance
    here, there = ("19.5 Hz", "4 mm"), (r, clearance)
    window, inner = ("19 Hz", "20 Hz"), ("3 mm", "4 mm")
    low = TEXTS.units().frequency_ratio("19 Hz"), TEXTS.units().frequency_ratio("20 Hz")
    gaps = (TEXTS.units().clearance("3 mm"), TEXTS.units().clearance("4 mm"))
    speed = 0.1 / TEXTS.units().scale("omega F0/K")
    motion = vi.equispaced(TEXTS, r, clearance)[0]
    pairs = (
        (lambda at: vi.simulate(TEXTS, *at, cycles=9).events["time"], here, there),
        (lambda at: vi.simulate(TEXTS, *there, 9, state={"x_dot": at}).events["time"], "0.1 m/s", speed),
        (lambda at: vi.equispaced(TEXTS, *at)[0].X, here, there),
        (lambda at: vi.exact(TEXTS, *at, guess=motion).X, here, there),
        (lambda at: vi.find(TEXTS, *at, 4, 1)[0].X, here, there),
        (lambda at: vi.basins(TEXTS, *at, states=3, rng=1).labels, here, there),
        (lambda at: vi.basins(TEXTS, *there, (("z_dot", at), ("x", -9, 9, 2)), points=2, fixed={"x_dot": at[1]},
            cycles=30).labels, ("0 m/s", "0.1 m/s"), (0.0, speed)),
        (lambda at: vi.decay(TEXTS, at, amplitude=at, cycles=3).x, "4 mm", clearance),
        (lambda at: vi.decay(TEXTS, 9.0, x_dot=at, y=0, cycles=3).x, "0.1 m/s", speed),
        (lambda at: vi.lyapunov(TEXTS, *at, cycles=50).largest, here, there),
        (lambda at: vi.zone(TEXTS, "RL", *at, lines=9).loops[0], (window, inner), (low, gaps)),
        (lambda at: vi.chart(TEXTS, "RL", *at)["stable"].values, (window, inner), (low, gaps)),
        (lambda at: vi.branch(motion, "clearance", bounds=at).X, ("3 mm", "6 mm"), (gaps[0], 2 * gaps[0])),
        (lambda at: vi.bifurcation_diagram(TEXTS, "clearance", at, r=r).values, inner, gaps),
    )  # fmt: skip
    for call, given, number in pairs:
        assert np.array_equal(call(given), call(number))


@pytest.mark.parametrize(("given", "message"), [
    (("19.5", 4.0), r"r = '19\.5': must be a number with .*, not str \(a number without a unit has no quotes\)"),
    (("19.5 mm", 4.0), r"r = 19\.5 mm: must be a frequency"),
    (("3 1/s", 4.0), r"r = 3 1/s: must be in Hz, rpm or rad/s"),
    ((1.0, "4 parsec"), r"clearance = '4 parsec': unknown unit 'parsec'; must be made of m, mm"),
    ((1.0, "4 Hz"), r"clearance = 4 Hz: must be a length"),
    ((1.0, "four mm"), r"clearance = 'four mm': must be"),
    ((1.0, "-4 mm"), r"clearance = -4 mm: must be"), ((1.0, "4 mm", "3 mm"), r"load = 3 mm: must be a force"),
    ((1.0, "nan mm"), r"clearance = 'nan mm': must be"), (("1e999 Hz", 4.0), "r = inf: must be"),
])  # fmt: skip
def test_wrong_units_are_named(given, message):
    with pytest.raises((ParameterError, ParameterTypeError), match=f"^{message}"):
        TEXTS.at(*given)


def test_friction_with_a_wrong_unit_is_named():
    """A message names the argument friction, and not the load, whose unit it has."""
    assert TEXTS.at(1.0, "4 mm", friction="0.3 N").friction == pytest.approx(0.05, rel=1e-14)
    with pytest.raises(ParameterError, match=r"^friction = 5 mm: must be a force"):
        TEXTS.at(1.0, "4 mm", friction="5 mm")


def test_what_has_no_units_takes_numbers():
    """Without M and K a text is refused, and so is a bare frequency that could be in cycles or radians."""
    plain = vi.Oscillator(xi=0.011, mu=0.04, restitution=0.75)
    with pytest.raises(
        ParameterError, match=r"^r = 19.5 Hz: must be without .*; M = None: must be the"
    ):
        vi.simulate(plain, "19.5 Hz", 28.0, cycles=1)
    with pytest.raises(
        ParameterError, match=r"^frequency = 19\.5: must have a unit, such as '19\.5 Hz'"
    ):
        TEXTS.units().frequency_ratio(19.5)
    # a frequency does not need the load
    unloaded = vi.Oscillator.from_dimensional(M=2.7, K=42e3, xi=0.011, m=0.11, restitution=0.75)
    assert unloaded.at("19.5 Hz", 28.0).r == pytest.approx(AT[0], rel=1e-14)
    with pytest.raises(ParameterError, match=r"^clearance = 4 mm: .*; F0 = None: must be the load"):
        unloaded.at("19.5 Hz", "4 mm")
    with pytest.raises(ParameterError, match=r"^C = 1\.0, xi = 0\.1: exactly one must be given"):
        vi.Oscillator.from_dimensional(M=1.0, K=1.0, C=1.0, xi=0.1, m=0.1, restitution=0.5)
