"""Points with friction or stops have results of a structure, converted to the units of the oscillator."""

import json

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact.plot import draw_chart, draw_system

RIG = vi.Oscillator.from_dimensional(
    M="2.7 kg", K="42 kN/m", xi="1.1 %", m="0.11 kg", restitution=0.75, F0="6 N"
)
POINT = RIG.at("20.5 Hz", "2 mm", friction="0.3 N", stops=(("40 kN/m", "3 N s/m"), None))
RUBS = RIG.at("20.5 Hz", "2 mm", friction="0.3 N")
FREQUENCY = 2 * np.pi * 20.5
HERTZ = {"Hz": 2 * np.pi, "kHz": 2e3 * np.pi, "rpm": np.pi / 30}


@pytest.fixture(scope="module")
def run():
    """The trajectory at the point with friction and a stop."""
    return vi.simulate(POINT, cycles=5, discard=400)


@pytest.fixture(scope="module")
def motion():
    """The periodic motion at the point with friction."""
    return vi.exact(RUBS, vi.simulate(RUBS, cycles=5, discard=400))


def by_hand():
    """The rig at the point as a structure in m, N and s, from its definition."""
    M, K, m = 2.7, 42e3, 0.11
    C = 2 * 0.011 * np.sqrt(K * M)
    gaps = [vi.Stop([-1, 1], 1e-3, stiffness=40e3, damping=3.0), vi.Gap([1, -1], 1e-3, 0.75)]
    structure = vi.Structure([M, m], [C, 0], [K, 0], gaps, [vi.Friction([-1, 1], 0.3)])
    return structure, vi.Load(FREQUENCY, sine=[6.0, 0.0])


def header(path):
    """The units that a CSV names, and its rows as an array of texts by column."""
    lines = path.read_text().splitlines()
    rows = [line.split(",") for line in lines if not line.startswith("#")]
    return lines[0].partition("; ")[2], dict(zip(rows[0], zip(*rows[1:], strict=True), strict=True))


def test_run_is_that_of_the_structure_in_si(run):
    """A run in SI agrees with that of the structure defined in SI: the motion is periodic and stable."""
    structure, load = by_hand()
    other = vi.simulate(structure, load, cycles=5, discard=400)
    own = run.physical("SI")
    assert own.events["kind"].tolist() == other.events["kind"].tolist()
    for name in ("time", "speed", "impulse"):
        np.testing.assert_allclose(own.events[name], other.events[name], rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(own.states, other.states, rtol=1e-8, atol=1e-10)
    t = np.linspace(other.start, other.end, 50)[1:-1]
    for mine, its in zip(own.sample(t), other.sample(t), strict=True):
        np.testing.assert_allclose(mine, its, rtol=1e-8, atol=1e-9)
    np.testing.assert_allclose(own.structure.mass, structure.mass)
    np.testing.assert_allclose(own.structure.damping, structure.damping, rtol=1e-12)
    assert own.structure.gaps[0].stiffness == pytest.approx(40e3)
    assert own.structure.friction[0].slip == pytest.approx(0.3)
    assert own.load.frequency == pytest.approx(FREQUENCY)


def test_physical_run_has_a_namelist_in_its_units(run, tmp_path):
    """The case of a run in SI reproduces the run, up to rounding."""
    own = run.physical("SI")
    path = tmp_path / "run.nml"
    path.write_text(own.to_namelist())
    ((again,),) = (case.run() for case in vi.read_namelist(path))
    np.testing.assert_allclose(again.events["time"], own.events["time"], rtol=1e-8)
    assert again.structure._units == own.structure._units


@pytest.mark.parametrize("units", [None, "SI", "in lbf s"])
def test_csv(run, units, tmp_path):
    """A CSV names the unit of each column, and its numbers are those of the run in these units."""
    run.save(tmp_path / "run.csv", units=units)
    names, columns = header(tmp_path / "run.csv")
    shown = {None: "mm N s", "SI": "m N s"}.get(units, units)
    length, force, time = shown.split()
    assert names == (
        f"time {time}, speed {length}/{time}, impulse {force} {time}, q_# {length}, q_dot_# {length}/{time}"
    )
    own = run.physical(shown)
    np.testing.assert_allclose(np.array(columns["time"], float), own.events["time"], rtol=1e-13)
    np.testing.assert_allclose(np.array(columns["q_1"], float), own.states[:, 0, 1], rtol=1e-13)


def test_dimensionless_csv_and_files(run, tmp_path):
    """A dimensionless CSV states this, and files restore the units."""
    run.save(tmp_path / "run.csv", units="dimensionless")
    names, columns = header(tmp_path / "run.csv")
    assert names.startswith("units as in the case")
    np.testing.assert_array_equal(np.array(columns["time"], float), run.events["time"])
    for suffix in ("json", "nc", "mat"):
        run.save(tmp_path / f"run.{suffix}")
        again = vi.load(tmp_path / f"run.{suffix}")
        assert again.structure._units == RIG.units()
        assert repr(again) == repr(run)
    assert "19.5" in repr(run)
    assert " s: " in repr(run)


def test_motion(motion):
    """A motion in mm: speeds and states scale, and the multipliers are those of its matrix."""
    own, units = motion.physical("mm N s"), RIG.units().to("mm N s")
    np.testing.assert_allclose(own.speeds, motion.speeds * units.velocity)
    np.testing.assert_allclose(
        sorted(abs(np.linalg.eigvals(own.matrix))), sorted(abs(motion.multipliers)), rtol=1e-9
    )
    structure, load = own.structure, own.load
    again = vi.exact(structure, load, own)
    np.testing.assert_allclose(again.speeds, own.speeds, rtol=1e-9, atol=1e-9)


def labels(axes):
    """The labels of both axes of each panel."""
    return [f"{ax.get_xlabel()} | {ax.get_ylabel()}" for ax in np.ravel(axes)]


def test_pictures_of_runs_and_motions(run, motion):
    """Each axis with a dimension names its unit, and has numbers in this unit."""
    for thing in (run, motion):
        _, history, impacts, energy = thing.plot()
        assert "(s)" in history.get_xlabel()
        assert "(mm)" in history.get_ylabel()
        assert "(mm/s)" in impacts.get_ylabel()
        assert "(s)" in energy.get_xlabel()
    line = run.plot(kind="history").get_lines()[0]
    assert np.abs(line.get_ydata()).max() == pytest.approx(
        np.abs(run.sample(np.linspace(run.start, run.end, 1500))[0][0]).max() * 1e3 * 6 / 42e3,
        rel=1e-3,
    )
    assert "(mm)" not in run.plot(kind="history", units="dimensionless").get_ylabel()
    assert "kg" in draw_system(POINT).get_title()


def test_pictures_and_tables_of_studies(motion, tmp_path):
    """Responses, diagrams, branches, zones and charts along frequency and clearance in Hz and mm."""
    response = vi.response(RUBS, ("18 Hz", "22 Hz"), points=5, settling=50)
    assert labels(response.plot()) == ["load frequency $\\Omega/2\\pi$ (Hz) | $\\max|q_{0}|$ (mm)"]
    assert "18 to 22 Hz" in repr(response)
    response.save(tmp_path / "r.csv")
    names, columns = header(tmp_path / "r.csv")
    assert names.startswith("value Hz, largest_# mm")
    np.testing.assert_allclose(np.array(columns["value"], float)[:5], [18, 19, 20, 21, 22])
    table = response.physical("mm N s").to_pandas()
    np.testing.assert_allclose(table["value"][:5], [18, 19, 20, 21, 22])
    np.testing.assert_allclose(table["largest_0"], np.array(columns["largest_0"], float))
    for name, values, unit in (
        ("r", ("18 Hz", "20 Hz"), "Hz"), ("clearance", ("2 mm", "3 mm"), "mm"), ("slip", ("0.2 N", "0.3 N"), "N"),
    ):  # fmt: skip
        diagram = vi.bifurcation_diagram(RUBS, name, values, points=3, settling=20, keep=4)
        assert f"({unit})" in diagram.plot().get_xlabel()
        low, high = diagram.plot().get_xlim()
        given = [float(value.split()[0]) for value in values]
        assert low < given[0] < given[1] < high < 2 * given[1]
        assert f"{values[0].split()[0]} to {values[1]}" in repr(diagram)
        diagram.save(tmp_path / "d.csv")
        assert header(tmp_path / "d.csv")[0].startswith(f"value {unit}, q_# mm")
    branch = vi.branch(motion, "opening", bounds=("0.95 mm", "1.05 mm"))
    assert "0.95 to 1.05 mm" in repr(branch)
    assert "(mm)" in branch.plot().get_ylabel()
    spans = ("frequency", "20.3 Hz", "20.7 Hz"), ("opening", ("0.95 mm", "1.05 mm"))
    zone = vi.zone(motion, *spans, lines=5)
    assert "(Hz)" in zone.plot().get_xlabel()
    assert "(mm)" in zone.plot().get_ylabel()
    np.testing.assert_allclose(zone.plot().get_xlim(), [20.3, 20.7])
    chart = vi.chart(motion, *spans, points=3)
    np.testing.assert_allclose(vi.physical(chart, "mm N s")["x"], [20.3, 20.5, 20.7])
    assert "(Hz)" in draw_chart(chart).get_xlabel()


def test_basins_along_velocities():
    """A plane of velocities takes speeds, and its axes show speeds."""
    plane = ("q_0", ("-1 mm", "1 mm")), ("q_dot_0", "-5 mm/s", "5 mm/s", 3)
    basins = vi.basins(RUBS, plane=plane, points=3, settling=100)
    axes = basins.axes
    units = RIG.units().to("mm N s")
    np.testing.assert_allclose(axes[1].values * units.velocity, [-5, 0, 5], atol=1e-12)
    assert labels(basins.plot()) == ["$q_{0}$ (mm) | $\\dot q_{0}$ (mm/s)"]


def test_initial_states_and_times_with_units():
    """States by name or as lists, and times, mean the same as their dimensionless numbers."""
    units = RIG.units().to("mm N s")
    start = {"x": "0.2 mm", "z": "0.5 mm", "z_dot": "40 mm/s", "t": "10 ms"}
    named = vi.simulate(POINT, 3, start)
    state = (["0.2 mm", "0.5 mm"], [0, "40 mm/s"])
    listed = vi.simulate(POINT, cycles=3, state=state, start="10 ms")
    plain = (np.array([0.2, 0.5]) / units.length, np.array([0, 40]) / units.velocity)
    bare = vi.simulate(POINT, cycles=3, state=plain, start=0.01 / units.time)
    for one in (named, listed):
        np.testing.assert_allclose(one.initial_state, bare.initial_state, rtol=1e-14)
        np.testing.assert_allclose(one.states, bare.states, rtol=1e-9, atol=1e-9)
        assert one.start == pytest.approx(bare.start, rel=1e-14)
    lasting = vi.simulate(POINT, duration="100 ms", state=state)
    assert lasting.end * units.time == pytest.approx(0.1)
    found = vi.lyapunov(POINT, cycles=40, state=state)
    np.testing.assert_array_equal(
        found.exponents, vi.lyapunov(POINT, cycles=40, state=plain).exponents
    )


def test_samples_at_times_with_units(run, motion):
    """Times in ms, also of the run in other units, give the same samples; so do windows."""
    units = RIG.units().to("mm N s")
    times = [f"{1000 * t * units.time:.12g} ms" for t in np.linspace(run.start, run.end, 7)[1:-1]]
    bare = np.linspace(run.start, run.end, 7)[1:-1]
    for own, its, scale in zip(
        run.physical("mm N s").sample(times), run.sample(bare), (units.length, units.velocity), strict=True
    ):  # fmt: skip
        np.testing.assert_allclose(own, its * scale, rtol=1e-7)
    np.testing.assert_allclose(run.sample(times), run.sample(bare), rtol=1e-7)
    np.testing.assert_allclose(run.acceleration(times), run.acceleration(bare), rtol=1e-7)
    np.testing.assert_allclose(run.sample(times[0]), run.sample(bare[0]), rtol=1e-7)
    own = run.quantities(window=(times[0], times[3]))
    np.testing.assert_allclose(own.q.rms, run.quantities(window=bare[[0, 3]]).q.rms, rtol=1e-7)
    np.testing.assert_allclose(
        motion.sample(["5 ms"]), motion.sample([0.005 / units.time]), rtol=1e-7
    )


def test_basins_by_the_names_of_the_oscillator():
    """A plane at such a point takes x, z and their velocities."""
    spans = ("-0.2 mm", "0.2 mm"), ("-5 mm/s", "5 mm/s")
    found = [
        vi.basins(RUBS, plane=tuple(zip(names, spans, strict=True)), points=2, settling=50)
        for names in (("z", "x_dot"), ("q_1", "q_dot_0"))
    ]
    assert [axis.name for axis in found[0].axes] == ["q_1", "q_dot_0"]
    np.testing.assert_array_equal(found[0].states, found[1].states)
    with pytest.raises(vi.errors.ParameterError, match="'y', 'q_dot_0': must be two of 'q_0'"):
        vi.basins(RUBS, plane=tuple(zip(("y", "x_dot"), spans, strict=True)), points=2)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"cycles": 1, "state": (["0.2 mm", "9 mm"], [0, 0])}, "gaps[0] is -7.8 mm, must be >= 0"),
        (
            {"cycles": 1, "state": (["0.2 mm"], [0, 0])},
            "state = ([0.2 mm], [0, 0]): must be two lists",
        ),
        ({"cycles": 1, "state": (["0.2 mm/s", 0], [0, 0])}, "state = 0.2 mm/s: must be a length"),
        ({"cycles": 1, "state": ["1 mm", "2 mm"]}, "state = '1 mm': must be two lists"),
        ({"duration": "-1 s"}, "duration = -1 s: must be a number"),
        ({"duration": "1 Hz"}, "duration = 1 Hz: must be a time"),
    ],
)
def test_refused_at_a_point(given, message):
    """Messages show what was given."""
    with pytest.raises(vi.errors.VibroimpactError) as caught:
        vi.simulate(RUBS, **given)
    assert message in str(caught.value)


def test_refused_times_and_values(run, motion):
    """Times of samples, bounds and values are named as they were given."""
    with pytest.raises(
        vi.errors.ParameterError, match=r"t = \[9 s\]: must be times .* 9 s is 1122\."
    ):
        run.sample(["9 s"])
    with pytest.raises(vi.errors.ParameterError, match=r"window = \(1 s, 99 s\): must be"):
        run.quantities(window=("1 s", "99 s"))
    with pytest.raises(
        vi.errors.ParameterError, match=r"bounds\[1\] = 0.9 mm: .* opening = 1 mm; without"
    ):
        vi.branch(motion, "opening", bounds=("0.8 mm", "0.9 mm"))
    with pytest.raises(vi.errors.ParameterError, match=r"min\(values\) = -1 N: must"):
        vi.bifurcation_diagram(RUBS, "slip", ("-1 N", "0.3 N"), points=3)
    with pytest.raises(vi.errors.ParameterError, match="no units for the parameter 'stiffness_1'"):
        vi.bifurcation_diagram(RUBS, "stiffness_1", ("1 kN/m", "2 kN/m"), points=3)


def test_branches_and_zones_at_values_with_units(motion):
    """Special points are in the units of the rig, and systems, motions and membership at such values are found."""
    branch = vi.branch(motion, "slip", bounds=("0.29 N", "0.31 N"))
    assert [repr(point) for point in branch.special_points] == [
        "<bound at slip = 0.29 N>", "<bound at slip = 0.31 N>"
    ]  # fmt: skip
    assert branch.at("0.3 N")[0].friction[0].slip == pytest.approx(0.05)
    with pytest.raises(vi.errors.ParameterError, match=r"value = 0\.3 mm: must be a force"):
        branch.at("0.3 mm")
    spans = ("frequency", "20.3 Hz", "20.7 Hz"), ("opening", ("0.95 mm", "1.05 mm"))
    zone = vi.zone(motion, *spans, lines=5)
    units = RIG.units().to("mm N s")
    for x, y in (("20.5 Hz", "1 mm"), ("20.4 Hz", "9 mm")):
        bare = (float(x[:-3]) / units.frequency, float(y[:-3]) / units.length)
        assert zone.contains(x, y) == zone.contains(*bare) == (y == "1 mm")
    assert zone.at("20.5 Hz", "1 mm")[1].frequency == pytest.approx(20.5 / units.frequency)
    assert zone.motion("20.5 Hz", "1 mm").stable
    with pytest.raises(vi.errors.ParameterError, match="y = 1 N: must be a length"):
        zone.contains("20.5 Hz", "1 N")


def test_the_load_of_a_branch_is_a_factor():
    """The load of a structure is a factor of that of the point, and is not shown as a force."""
    point = RIG.at("20.5 Hz", "2 mm", load="5 N", friction="0.3 N")
    motion = vi.exact(point, vi.simulate(point, cycles=5, discard=400))
    branch = vi.branch(motion, "load", bounds=(0.99, 1.01))
    assert "along load, 0.99 to 1.01:" in repr(branch)
    assert repr(branch.special_points[0]) == "<bound at load = 0.99>"
    with pytest.raises(vi.errors.ParameterError, match="no units for the parameter 'load'"):
        vi.branch(motion, "load", bounds=("4.9 N", "5.1 N"))


def test_the_structure_of_a_rig_takes_units():
    """Times, states and values of a structure made by the rig, in the units of the rig or dimensionless."""
    load = vi.Load("20 Hz", sine=[6, 0])
    cyclic = 2 * np.pi * 20
    pair = RIG.structure(d="8 mm")
    texts, numbers = (
        vi.simulate(pair, load, duration=duration, state=state, start=start).events
        for duration, state, start in (
            ("0.5 s", (["1 mm", "2 mm"], ["10 mm/s", 0]), "5 ms"),
            (0.5, ([1e-3, 2e-3], [0.01, 0]), 5e-3),
        )
    )
    assert len(texts) == len(numbers) > 5
    assert texts["time"] == pytest.approx(numbers["time"], rel=1e-9)
    few = {"points": 2, "settling": 5, "keep": 5}
    for study in (
        lambda values: vi.response(pair, load, values, **few),
        lambda values: vi.bifurcation_diagram(pair, load, "frequency", values, **few),
    ):
        assert study(("19 Hz", "20 Hz")).values == pytest.approx(
            study((0.95 * cyclic, cyclic)).values, rel=1e-12
        )
    scaled = vi.simulate(RIG.structure("8 mm"), vi.Load(1.0, sine=[1, 0]), duration="0.1 s")
    assert scaled.end == pytest.approx(0.1 * np.sqrt(42e3 / 2.7), rel=1e-12)
    with pytest.raises(vi.ParameterError, match="duration = 1 mm: must be a time"):
        vi.simulate(pair, load, duration="1 mm")
    # radians per second are no ratio: r would be 126
    ratio = RIG.units().frequency_ratio("20 Hz")
    with pytest.raises(
        vi.ParameterError,
        match=rf"^load = .*: must have a frequency that is a plain number, .*: {ratio:.10g}, not 125.6",
    ):
        vi.simulate(RIG.structure("8 mm"), load, cycles=3)
    assert load == vi.Load(load.frequency, sine=[6, 0])
    users, force = by_hand()
    with pytest.raises(vi.ParameterTypeError, match="duration = '1 s': must be a number"):
        vi.simulate(users, force, duration="1 s")


def test_arguments_of_a_structure_by_name():
    """Times of a structure have units by position and by name; `discard` is a time unless cycles are given."""
    load, pair = vi.Load("20 Hz", sine=[6, 0]), RIG.structure(d="8 mm")
    run = vi.simulate(pair, load, duration=0.5, discard=1.0)
    assert len(run.events) > 5
    for named in (
        vi.simulate(structure=pair, load=load, duration="0.5 s", discard="1 s"),
        vi.simulate(pair, load=load, duration="500 ms", discard="1000 ms"),
    ):
        assert named.events.tolist() == run.events.tolist()
    point = RIG.at("20.5 Hz", "4 mm", friction="0.1 N")
    numbers = [scale / RIG.units().time for scale in (0.5, 1.0)]
    plain = vi.simulate(point, duration=numbers[0], discard=numbers[1])
    for run in (
        vi.simulate(point, duration="0.5 s", discard="1 s"),
        vi.simulate(osc=point, duration="0.5 s", discard="1 s"),
    ):
        assert (run.start, run.end) == pytest.approx((plain.start, plain.end), rel=1e-14)
    for call in (
        lambda: vi.simulate(pair, load, cycles=3, discard="1 s"),
        lambda: vi.simulate(RIG, "20.5 Hz", "4 mm", 3, discard="1 s"),
        lambda: vi.lyapunov(pair, load, discard="1 s"),
    ):
        with pytest.raises(vi.ParameterTypeError, match=r"discard = '1 s': must be a .*number"):
            call()


@pytest.mark.parametrize(
    "text", ["20 Hz", "19.5 Hz", "20.2 Hz", "17.3 Hz", "0.0173 kHz", "1170 rpm"]
)
def test_a_load_in_hertz_ends_a_range(text):
    """A frequency is the same number as that of a load and as the end of a range, which it may therefore end."""
    load, pair = vi.Load(text, sine=[6, 0]), RIG.structure(d="8 mm")
    few = {"max_impacts": 1, "survey": 1, "settling": 5}
    opening = ("opening", "3.9 mm", "4.1 mm")
    for x in (("frequency", "17 Hz", text), ("frequency", text, "21 Hz")):
        atlas = vi.atlas(pair, load, x, opening, **few)
        assert load.frequency in atlas.x
    assert load.frequency == pytest.approx(
        float(text.split()[0]) * HERTZ[text.split()[1]], rel=1e-15
    )


def test_axes_of_a_structure_are_named_as_given():
    """Messages about a window give its values, and that of the start, in the units of the call."""
    load, pair = vi.Load("20 Hz", sine=[6, 0]), RIG.structure(d="4 mm")
    opening = ("opening", "1.9 mm", "2.1 mm")
    motion = vi.exact(pair, load, vi.simulate(pair, load, cycles=20, discard=400))
    for study, start in (
        (lambda x: vi.atlas(pair, load, x, opening), "structure"),
        (lambda x: vi.zone(motion, x, opening), "motion"),
        (lambda x: vi.zone(motion=motion, x=x, y=opening), "motion"),
    ):
        with pytest.raises(
            vi.ParameterError, match=rf"^x\[1\] = 21 Hz: .*; the {start} has frequency = 20 Hz;"
        ):
            study(("frequency", "21 Hz", "22 Hz"))
        with pytest.raises(vi.ParameterError, match=r"^x = 19 mm: must be a frequency$"):
            study(("frequency", "19 mm", "22 Hz"))
        for wrong in (("frequency",), (), ("frequency", "19 Hz"), "19 Hz"):
            with pytest.raises(vi.ParameterError, match=r"^x.* = .*: must be \(parameter, "):
                study(wrong)


@pytest.mark.parametrize(
    "plane",
    [
        {"q_0": ("-1 mm", "1 mm"), "q_dot_1": ("-1 mm/s", "1 mm/s")}, ("q_0", ("-1 mm", "1 mm")),
        ("1 mm", 5), (("q_0", "-1 mm", "1 mm", 3), ()), (("q_0", "-1 mm", "1 mm", 3), 5),
    ],
)  # fmt: skip
def test_planes_that_are_refused(plane):
    """What is no plane is refused with what was given and what is allowed, also if it has units."""
    load, pair = vi.Load("20 Hz", sine=[6, 0]), RIG.structure(d="8 mm")
    with pytest.raises(vi.ParameterError, match=r"^plane = .*-?1 mm.*: must be two of \(name, "):
        vi.basins(pair, load, plane=plane)


def test_structures_of_users_have_no_units():
    """A structure defined by the user is shown in the user's units, which have no names."""
    structure, load = by_hand()
    run = vi.simulate(structure, load, cycles=2)
    assert run.plot(kind="history").get_ylabel() == "coordinates $q_i$"
    for units in ("mm N s", None):
        with pytest.raises(vi.errors.ParameterTypeError, match="units that you choose"):
            run.physical(units)
    assert "F0" not in json.dumps(
        {k: v.attrs for k, v in run.to_xarray().variables.items()}, default=str
    )


def test_point_names_its_units():
    """The point shows friction and stops as they were given."""
    assert "friction 0.3 N" in repr(POINT)
    assert "right (40 N/mm, 0.003 N s/mm), left rigid" in repr(POINT)
    bare = vi.Oscillator(xi=0.01, mu=0.04, restitution=0.75).at(1.0, 20, friction=0.05)
    assert "friction 0.05" in repr(bare)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ("scales = 2.7, 42e3", "scales"),
        ("scales = 2.7, 42e3, 0", "scales"),
        ("scales = 2.7, 42e3, 6, unit_names = 'mm N'", "unit_names"),
        ("unit_names = 'mm N s'", "scales"),
    ],
)
def test_scales_of_a_namelist(keys, message, tmp_path):
    """Scales are three positive numbers, with units of length, force and time."""
    text = (
        f"&structure mass = 1, 0.04, damping = 0.02, 0, stiffness = 1, 0, {keys} /\n"
        "&gap direction = -1, 1, opening = 14 /\n&load frequency = 1, sine = 1, 0 /\n&simulate cycles = 1 /\n"
    )
    path = tmp_path / "scales.nml"
    path.write_text(text)
    with pytest.raises(vi.errors.ParameterError, match=message):
        vi.read_namelist(path)
