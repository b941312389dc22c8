"""Results on their way to other programs and back: the same bits, and clear faults for what is broken."""

import base64
import copy
import csv
import json
import math
import sys
from xml.etree import ElementTree

import numpy as np
import pytest
import vibroimpact as vi
from test_exact import COLUMN, TABLE, rest_motion
from vibroimpact.interchange import plain
from vibroimpact.interchange.plain import attributes

FIGURE6 = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
STATE = {"t": 0, "x": 3.5, "x_dot": 0, "z": 0, "z_dot": -2}
NAMES = (
    "motion",
    "rest",
    "free",
    "pair",
    "linear",
    "trajectory",
    "rests",
    "still",
    "branch",
    "zone",
    "atlas",
)


@pytest.fixture(scope="module")
def results():
    """One result of each kind, and of the kinds within them."""
    motion = vi.exact(TABLE, 0.94, 37.0, COLUMN)
    uneven = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))
    return {
        "motion": motion,
        "rest": rest_motion(),
        "free": vi.exact(TABLE, 0.94, 74.0, motion, load=2.0),
        "pair": vi.equispaced(TABLE, 0.94, 37.0)[0],
        "linear": vi.periodic(
            TABLE, 0.94, [0, 2.0, 4.1], vi.Pattern("RRL"), [0.7, 0.8, 0.75], "single"
        ),
        "trajectory": vi.simulate(TABLE, 0.94, 37.0, 20, STATE),
        "rests": vi.simulate(uneven, 0.9, 6.0, 4, discard=50),
        "still": vi.simulate(TABLE, 0.94, 37.0, 0),
        "branch": vi.branch(motion, "clearance", (15, 45)),
        "zone": vi.zone(FIGURE6, vi.Pattern("RL"), (0.8, 1.2), (2, 200)),
        "atlas": vi.atlas(FIGURE6, (1.0, 1.1), (20, 60), max_impacts=2, survey=12),
    }


def same(one, other):
    """Whether two results are the same in type and in every bit, NaN, -0.0 and structure included."""
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray):
        return (
            one.dtype == other.dtype
            and one.shape == other.shape
            and one.tobytes() == other.tobytes()
        )
    if isinstance(one, float):
        return np.float64(one).tobytes() == np.float64(other).tobytes()
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    if hasattr(one, "__dataclass_fields__"):
        return all(
            same(getattr(one, name), getattr(other, name)) for name in one.__dataclass_fields__
        )
    if isinstance(one, (list, tuple)):
        return len(one) == len(other) and all(map(same, one, other))
    return one == other


@pytest.mark.parametrize("name", NAMES)
def test_json_gives_every_bit(name, results, tmp_path):
    """Through text and through a file, in strict JSON."""
    result = results[name]
    text = result.to_json()
    assert "NaN" not in text
    assert "Infinity" not in text
    again = type(result).from_json(text)
    assert same(again, result)
    assert repr(again) == repr(result)
    result.save(tmp_path / "result.json")
    assert same(vi.load(tmp_path / "result.json"), result)
    assert json.loads((tmp_path / "result.json").read_text()) == result.to_dict()


def test_same_tells_results_apart(results):
    """The comparison of these tests sees one bit."""
    motion = results["motion"]
    data = motion.to_dict()
    data["X"] = [math.nextafter(data["X"][0], 99), data["X"][1]]
    assert not same(vi.Motion.from_dict(data), motion)
    assert not same(results["rest"], motion)


def test_numbers_that_json_does_not_have():
    """NaN, infinity and minus zero come back."""
    values = np.array([[np.nan, np.inf], [-np.inf, -0.0]])
    coded = json.loads(json.dumps(plain.encode(values), allow_nan=False))
    array = plain.decode(np.ndarray, coded, "values")
    np.testing.assert_array_equal(array, values)
    assert np.signbit(array[1, 1])
    assert math.isnan(plain.decode(float, plain.encode(math.nan), "x"))


def test_what_is_read_goes_on(results):
    """A motion is sampled and followed, a simulation continues bit for bit, a zone contains."""
    motion = vi.Motion.from_json(results["motion"].to_json())
    times = np.linspace(0, 7, 50)
    np.testing.assert_array_equal(motion.sample(times), results["motion"].sample(times))
    assert len(vi.branch(motion, "clearance", (36, 38))) > 2
    run = vi.Trajectory.from_json(results["trajectory"].to_json())
    ours = vi.simulate(TABLE, 0.94, 37.0, 7, run.final_state)
    theirs = vi.simulate(TABLE, 0.94, 37.0, 7, results["trajectory"].final_state)
    np.testing.assert_array_equal(ours.events, theirs.events)
    zone = vi.Zone.from_json(results["zone"].to_json())
    assert (
        zone.contains(1.04, [25.0, 3.0]).tolist()
        == results["zone"].contains(1.04, [25.0, 3.0]).tolist()
    )
    atlas = vi.Atlas.from_json(results["atlas"].to_json())
    assert [len(atlas.at(r, 30.0)) for r in (1.01, 1.09)] == [
        len(results["atlas"].at(r, 30.0)) for r in (1.01, 1.09)
    ]


BROKEN = [
    ("motion", ["X"], [1.0], r"X of shape \(1,\): must be \(impact 2\)"),
    ("motion", ["X"], "north", "X = 'north': must be a number"),
    ("motion", ["X"], [1.0, "north"], "X = 'north': must be a number"),
    ("motion", ["multipliers"], [[1, 2]], r"multipliers of shape \(1,\): must be \(multiplier 4\)"),
    ("motion", ["multipliers"], [1, 2, 3, 4], r"multipliers = .*: must be pairs \[re, im\]"),
    ("motion", ["stable"], 1, "stable = 1: must be true or false"),
    ("motion", ["r"], True, "r = True: must be a number"),
    ("motion", ["osc", "xi"], 2.0, "osc: xi = 2.0: must be a number with 0 <= xi < 1"),
    ("motion", ["pattern", "sides"], "RR", "pattern: sides = 'RR': must name both walls"),
    ("motion", ["pattern"], 3, "pattern = 3: must be an object with named values"),
    ("motion", ["type"], "Zone", "type = 'Zone': must be 'Motion'"),
    ("rest", ["rest_events", "kind"], ["nothing"] * 99, "rest_events.kind = .*: must be"),
    ("trajectory", ["events", "x"], [], r"events.x = \[\]: must be a list of 46"),
    ("trajectory", ["events", "side"], ["R"] * 45 + ["Q"], "events.side = 'Q': must be 'R' or 'L'"),
    ("trajectory", ["final_state", "x"], "far", "final_state.x = 'far': must be a number"),
    ("branch", ["verdicts"], [[1.5]], "verdicts = 1.5: must be lists of whole numbers"),
    ("branch", ["special_points", 0, "motion", "A"], None, None),
    ("zone", ["boundary", 1, "r"], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0], r"boundary\[1\].clearance of"),
    ("zone", ["loops", 0], [[1.0, 2.0, 3.0]], r"loops\[0\] of shape \(1, 3\): must be \(vertex, coordinate 2\)"),
    ("zone", ["loops"], {}, "loops = {}: must be a list"),
    ("zone", ["r"], [1.0], r"r = \[1.0\]: must be a list of 2"),
    ("zone", ["search", "steps"], None, "search.steps = None: must be a whole number"),
    ("atlas", ["zones", 0, "pattern", "cycles"], 0, r"zones\[0\].pattern: cycles = 0: must be"),
    ("atlas", ["attractors", 0, "clearance"], [], r"attractors\[0\].clearance = \[\]: must be a number"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "path", "value", "said"), BROKEN)
def test_broken_data_is_named(name, path, value, said, results):
    """What is wrong, its value and what it must be; never a bare KeyError."""
    data = copy.deepcopy(results[name].to_dict())
    inner = data
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = value
    if said is None:  # NaN is allowed
        assert math.isnan(type(results[name]).from_dict(data).special_points[0].motion.A)
        return
    with pytest.raises(vi.errors.ParameterError, match=said):
        type(results[name]).from_dict(data)


@pytest.mark.parametrize("name", NAMES)
def test_missing_values_are_named(name, results):
    """Each attribute without a default is asked for by name."""
    data = results[name].to_dict()
    optional = {"type", "vibroimpact", "attenuation"}
    for key in data.keys() - optional:
        less = {other: item for other, item in data.items() if other != key}
        if attributes(type(results[name]))[key][1]:
            with pytest.raises(
                vi.errors.ParameterError, match=rf"must have '{key}'; it is missing"
            ):
                type(results[name]).from_dict(less)
        else:
            type(results[name]).from_dict(less)


@pytest.mark.parametrize("text", ["", "{", "[1, 2]", "7", "{}", '{"type": "Nothing"}', '{"type": ["Zone"]}',
                                  '{"type": "Zone"}', "\N{SNOWMAN}"])  # fmt: skip
def test_files_of_another_kind(text, tmp_path):
    """The file is named, and what it should be."""
    path = tmp_path / "other.json"
    path.write_text(text, encoding="utf-8")
    for read in (vi.load, vi.Atlas.load):
        with pytest.raises(
            vi.errors.ParameterError, match=r"other\.json': must be a file that"
        ) as caught:
            read(path)
        assert caught.value.__cause__ is None
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(vi.errors.ParameterError, match="must be a file that"):
        vi.load(path)


def test_cut_and_missing_files(results, tmp_path):
    """Half of a file, and none."""
    path = tmp_path / "zone.json"
    results["zone"].save(path)
    whole = path.read_text()
    for part in (1, len(whole) // 2, len(whole) - 1):
        path.write_text(whole[:part])
        with pytest.raises(vi.errors.ParameterError, match="must be a file that"):
            vi.load(path)
    with pytest.raises(vi.errors.ParameterError, match=r"none\.json.*No such file"):
        vi.load(tmp_path / "none.json")
    path.write_text(whole)
    with pytest.raises(vi.errors.ParameterError, match="not a Zone"):
        vi.Atlas.load(path)


def test_names_of_files(results, tmp_path):
    """The form is that of the name's end."""
    with pytest.raises(vi.errors.ParameterError, match=r"motion.doc'.*must end with one of \.json"):
        results["motion"].save(tmp_path / "motion.doc")
    results["motion"].save(str(tmp_path / "MOTION.JSON"))
    assert same(vi.load(str(tmp_path / "MOTION.JSON")), results["motion"])


def write(path, text):
    """A file, and its path."""
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    "name", ["motion", "pair", "linear", "trajectory", "rests", "branch", "zone", "atlas"]
)
def test_the_namelist_of_a_result_gives_it_again(name, results, tmp_path):
    """Every bit, by way of the compiled reader; and the namelist of that is the same."""
    result = results[name]
    path = write(tmp_path / "case.nml", result.to_namelist())
    (case,) = vi.read_namelist(path)
    again = case.run()[0]
    assert same(again, result)
    assert again.to_namelist() == result.to_namelist()
    path = write(tmp_path / "again.nml", case.to_namelist())
    (other,) = vi.read_namelist(path)
    assert other == case


@pytest.mark.parametrize("name", ["motion", "trajectory", "branch", "zone", "atlas"])
def test_the_namelist_runs(name, results, tmp_path):
    """`vibroimpact run` and the program write digits that are the result's own."""
    path = write(tmp_path / "case.nml", results[name].to_namelist())
    log = vi.run_namelists([path], tmp_path)
    assert log.status == 0
    lines = [line for line in log.results[0].read_text().splitlines() if not line.startswith("#")]
    table = list(csv.DictReader(lines))
    result = results[name]
    column, wanted = {
        "motion": lambda: ("X", result.X),
        "trajectory": lambda: ("time", result.events["time"]),
        "branch": lambda: ("attenuation", result.attenuation),
        "zone": lambda: ("r", np.concatenate([piece.r for piece in result.boundary])),
        "atlas": lambda: (
            "clearance", np.concatenate([p.clearance for zone in result.zones for p in zone.boundary]),
        ),
    }[name]()  # fmt: skip
    assert [float(row[column]) for row in table] == wanted.tolist()


def test_motions_found_otherwise_come_back_within_rounding(tmp_path):
    """Their own phases are the guess."""
    for motion in vi.find(FIGURE6, 1.04, 25.0, max_impacts=3, max_cycles=1):
        (case,) = vi.read_namelist(write(tmp_path / "case.nml", motion.to_namelist()))
        nearest = min(case.run(), key=lambda again: abs(again.X - motion.X).max())
        np.testing.assert_allclose(nearest.X, motion.X, atol=1e-9)
        np.testing.assert_allclose(nearest.phases, motion.phases, atol=1e-9)


@pytest.mark.parametrize("acceptance", [0.0, 0.03, 1.0])
def test_acceptance_is_kept(acceptance, tmp_path):
    """What counted as consistent does so again."""
    motion = vi.periodic(TABLE, 0.94, [0, 2.0, 4.1], vi.Pattern("RRL"), acceptance=acceptance)
    (case,) = vi.read_namelist(write(tmp_path / "case.nml", motion.to_namelist()))
    assert case.run()[0].consistent == motion.consistent


def test_no_namelist_can_tell(results):
    """A motion with rest or another load, the rest of a trajectory, a zone with seeds: said, not guessed."""
    run = results["trajectory"]
    later = vi.simulate(TABLE, 0.94, 37.0, 3, run.final_state)
    seeded = vi.zone(
        TABLE, vi.Pattern("RL"), (0.9, 1.0), (30, 40), lines=5, seeds=[results["motion"]]
    )
    for result in (results["rest"], results["free"], later, seeded):
        with pytest.raises(vi.errors.ParameterError, match="has no namelist"):
            result.to_namelist()


FILES = [name for name in NAMES if name != "still"]


@pytest.mark.parametrize("suffix", [".nc", ".mat"])
@pytest.mark.parametrize("name", FILES)
def test_files_give_every_bit(name, suffix, results, tmp_path):
    """netCDF and MATLAB files are read back whole; nothing is left of the temporary file."""
    pytest.importorskip({".nc": "h5netcdf", ".mat": "scipy"}[suffix])
    path = tmp_path / f"result{suffix}"
    results[name].save(path)
    assert [item.name for item in tmp_path.iterdir()] == [path.name]
    assert same(vi.load(path), results[name])


@pytest.mark.parametrize("name", NAMES)
def test_datasets_are_labelled(name, results):
    """Every variable has a unit or flags and a meaning; the case and the version are there."""
    pytest.importorskip("xarray")
    result = results[name]
    data = result.to_xarray()
    for variable in data.variables.values():
        assert variable.attrs["long_name"]
        assert "units" in variable.attrs or variable.dtype.kind in "OU"
    assert data.attrs["source"] == f"vibroimpact {vi.__version__}"
    assert data.attrs["Conventions"].startswith("CF-")
    if name not in ("rest", "free"):
        assert data.attrs["case"] == result.to_namelist()
    if isinstance(result, vi.Motion):
        np.testing.assert_array_equal(data.X, result.X)
        np.testing.assert_array_equal(
            data.multipliers_real + 1j * data.multipliers_imag, result.multipliers
        )
        assert float(data.clearance) == result.clearance
    elif isinstance(result, vi.Trajectory):
        np.testing.assert_array_equal(data.time, result.events["time"])
        assert data.side.values.tolist() == result.events["side"].tolist()
    elif isinstance(result, vi.Branch):
        np.testing.assert_array_equal(data.Z_dot_after[:, 3], result[3].Z_dot_after)
    elif isinstance(result, vi.Zone):
        for i, piece in enumerate(result.boundary):
            here = data.sel(vertex=data.piece == i)
            np.testing.assert_array_equal(here.r, piece.r)
            np.testing.assert_array_equal(here.piece_x[: len(piece.x)], piece.x)
            assert str(data.type.values[i]) == piece.type
        for i, ring in enumerate(result.loops):
            here = data.sel(ring_vertex=data.ring == i)
            np.testing.assert_array_equal(np.c_[here.ring_r, here.ring_clearance], ring)
    else:
        assert data.sides.values.tolist() == [zone.pattern.sides for zone in result.zones]
        assert data.sizes["vertex"] == sum(len(p) for zone in result.zones for p in zone.boundary)


def test_netcdf_is_read_by_others(results, tmp_path):
    """Plain h5py sees the numbers and the units."""
    h5py = pytest.importorskip("h5py")
    results["motion"].save(tmp_path / "motion.nc")
    with h5py.File(tmp_path / "motion.nc") as file:
        assert file["X"][:].tolist() == results["motion"].X.tolist()
        unit = file["X"].attrs["units"]
        assert (unit.decode() if isinstance(unit, bytes) else unit) == "F0/K"


def test_matlab_is_read_by_others(results, tmp_path):
    """As MATLAB sees them: a struct, cells of structs, complex numbers, logicals."""
    scipy_io = pytest.importorskip("scipy.io")
    for name in ("motion", "zone", "trajectory"):
        results[name].save(tmp_path / f"{name}.mat")
    motion = scipy_io.loadmat(tmp_path / "motion.mat", simplify_cells=True)["motion"]
    np.testing.assert_array_equal(motion["multipliers"], results["motion"].multipliers)
    np.testing.assert_array_equal(motion["X_dot_before"], results["motion"].X_dot_before)
    assert motion["pattern"]["sides"] == "RL"
    assert motion["osc"]["restitution"].tolist() == [0.75, 0.75]
    assert bool(motion["stable"]) is True
    zone = scipy_io.loadmat(tmp_path / "zone.mat", simplify_cells=True)["zone"]
    for ours, theirs in zip(zone["boundary"], results["zone"].boundary, strict=True):
        assert ours["type"] == theirs.type
        np.testing.assert_array_equal(ours["clearance"], theirs.clearance)
    run = scipy_io.loadmat(tmp_path / "trajectory.mat", simplify_cells=True)["trajectory"]
    np.testing.assert_array_equal(run["events"]["x"], results["trajectory"].events["x"])
    assert run["events"]["side"].tolist() == results["trajectory"].events["side"].tolist()


@pytest.mark.parametrize(
    "name", ["motion", "linear", "trajectory", "rests", "still", "branch", "zone", "atlas"]
)
def test_csv_is_what_run_writes(name, results, tmp_path):
    """The same bytes as by way of a namelist; so it is an input that gives the same once more."""
    results[name].save(tmp_path / "mine.csv")
    path = write(tmp_path / "case.nml", results[name].to_namelist() + "&output name = 'mine' /\n")
    log = vi.run_namelists([path], tmp_path / "run")
    assert (log.status, len(log.results)) == (0, 1)
    assert (tmp_path / "mine.csv").read_text() == log.results[0].read_text()
    log = vi.run_namelists([tmp_path / "mine.csv"], tmp_path / "again")
    assert log.results[0].read_bytes() == (tmp_path / "mine.csv").read_bytes()


def test_csv_without_a_namelist(results, tmp_path):
    """The table is there, and that no namelist tells how it began."""
    results["rest"].save(tmp_path / "rest.csv")
    lines = (tmp_path / "rest.csv").read_text().splitlines()
    assert lines[0].endswith("no namelist tells how it began")
    assert len(lines) == 2 + len(results["rest"].pattern)
    with pytest.raises(vi.errors.ParameterError, match=r"rest\.csv': must be a file that"):
        vi.load(tmp_path / "rest.csv")


@pytest.mark.parametrize("name", NAMES)
def test_data_frames(name, results):
    """The columns of the table, with their numbers."""
    pytest.importorskip("pandas")
    frame = results[name].to_pandas()
    result = results[name]
    if isinstance(result, vi.Trajectory):
        assert frame["x"].tolist() == result.events["x"].tolist()
    elif isinstance(result, vi.Motion):
        assert frame["phase"].tolist() == result.phases.tolist()
        assert frame["r"].unique().tolist() == [result.r]
    elif isinstance(result, vi.Branch):
        assert frame["special"][frame["special"] != ""].tolist() == [
            p.type for p in result.special_points
        ]
    else:
        assert set(frame["type"]) <= {"fold", "pitchfork", "neimark_sacker", "flip", "grazing", "window",
                                      "zero_approach"}  # fmt: skip


def test_files_of_another_kind_by_suffix(results, tmp_path):
    """A file that is not what its name says, and one without a record, are named."""
    pytest.importorskip("h5netcdf")
    pytest.importorskip("scipy.io").savemat(tmp_path / "other.mat", {"a": 1})
    results["motion"].to_xarray().to_netcdf(tmp_path / "other.nc", engine="h5netcdf")
    write(tmp_path / "text.nc", "no netCDF")
    write(tmp_path / "text.mat", "no matrix, however long the text may be " * 9)
    for name in ("other.mat", "other.nc", "text.nc", "text.mat", "none.nc", "none.mat"):
        with pytest.raises(vi.errors.ParameterError, match=rf"{name}': must be a file that"):
            vi.load(tmp_path / name)


def test_missing_libraries_are_named(results, tmp_path, monkeypatch):
    """The extra that has them; and no half of a file."""
    for module in ("scipy", "scipy.io", "xarray", "pandas"):
        monkeypatch.setitem(sys.modules, module, None)
    for suffix, extra in ((".mat", "matlab"), (".nc", "data")):
        with pytest.raises(
            vi.errors.MissingExtraError, match=rf"pip install 'vibroimpact\[{extra}\]'"
        ):
            results["motion"].save(tmp_path / f"motion{suffix}")
    with pytest.raises(vi.errors.MissingExtraError, match=r"vibroimpact\[data\]"):
        results["motion"].to_pandas()
    assert list(tmp_path.iterdir()) == []


@pytest.fixture(scope="module")
def attractors():
    """Results of the studies of attractors, with motions, exponents and states within them."""
    return {
        "lyapunov": vi.lyapunov(FIGURE6, 1.04, [25.0, 30.0], cycles=100, discard=50),
        "one": vi.lyapunov(FIGURE6, 1.04, 25.0, cycles=100, discard=50),
        "basins": vi.basins(TABLE, 0.94, 37.0, (("x", -30, 30, 6), ("x_dot", -30, 30, 5))),
        "states": vi.basins(TABLE, 0.94, 37.0, states=9),
        "bifurcation": vi.bifurcation_diagram(FIGURE6, "clearance", [20, 30, 40], r=1.04),
        "response": vi.response(FIGURE6, [1.0, 1.02], clearance=25.0, states=3),
    }


@pytest.mark.parametrize("suffix", [".json", ".nc", ".mat"])
@pytest.mark.parametrize("name", ["lyapunov", "one", "basins", "states", "bifurcation", "response"])
def test_studies_of_attractors_come_back(name, suffix, attractors, tmp_path):
    """Every bit of them too."""
    pytest.importorskip({".nc": "h5netcdf", ".mat": "scipy", ".json": "json"}[suffix])
    path = tmp_path / f"result{suffix}"
    attractors[name].save(path)
    assert same(vi.load(path), attractors[name])


@pytest.mark.parametrize("name", NAMES)
def test_jupyter_shows_a_picture(name, results):
    """HTML that parses, with what the result says of itself and one image; no figure is left open."""
    plt = pytest.importorskip("matplotlib.pyplot")
    before = plt.get_fignums()
    text = results[name]._repr_html_()
    assert plt.get_fignums() == before
    root = ElementTree.fromstring(text)
    assert root.find("code").text == repr(results[name])
    assert len(text) < 100_000
    kind, _, data = root.find("img").get("src").partition("base64,")
    assert kind == "data:image/png;"
    picture = base64.b64decode(data)
    assert picture.startswith(b"\x89PNG")
    assert len(picture) > 3000
    if isinstance(results[name], vi.Motion):
        cells = {row[0].text: row[1].text for row in root.iter("tr")}
        moduli = [float(word) for word in cells["|λ|"].split(", ")]
        assert moduli == pytest.approx(np.abs(results[name].multipliers), rel=1e-3)


def test_jupyter_without_matplotlib(results, monkeypatch):
    """The numbers alone."""
    for module in [name for name in sys.modules if name.split(".")[0] == "matplotlib"]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    text = results["motion"]._repr_html_()
    assert "img" not in text
    assert "<table>" in text


def test_jupyter_of_an_empty_zone():
    """There is nothing to see, and that is said."""
    zone = vi.zone(FIGURE6, vi.Pattern("RL"), (0.9, 1.0), (1e5, 1e6), lines=5, guesses=1)
    assert "0 loops" in zone._repr_html_()
    assert "img" not in zone._repr_html_()


@pytest.mark.parametrize("name", ["lyapunov", "basins", "states", "bifurcation", "response"])
def test_jupyter_shows_studies_of_attractors(name, attractors):
    """They inherit it; states in no plane have no picture."""
    pytest.importorskip("matplotlib")
    root = ElementTree.fromstring(attractors[name]._repr_html_())
    assert root.find("code").text == repr(attractors[name])
    assert (root.find("img") is None) == (name == "states")
