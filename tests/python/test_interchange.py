"""Results as JSON and as namelists, and back: the same bits, and clear errors for broken files."""

import copy
import csv
import json
import math
import re

import numpy as np
import pytest
import vibroimpact as vi
from shared_results import NAMES, same, write
from shared_systems import FIGURE6, TABLE
from vibroimpact.formats import record


@pytest.mark.parametrize("name", NAMES)
def test_json_gives_every_bit(name, results, tmp_path):
    """JSON is strict, and restores every bit of a result, as text and as a file."""
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
    """The function `same` of these tests detects a change of one bit."""
    motion = results["motion"]
    data = motion.to_dict()
    columns = data["tables"]["impacts"]["columns"]
    columns["X"] = [math.nextafter(columns["X"][0], 99), columns["X"][1]]
    assert not same(vi.Motion.from_dict(data), motion)
    assert not same(results["rest"], motion)


def test_numbers_that_json_does_not_have():
    """NaN, infinity and minus zero are restored."""
    values = np.array([[np.nan, np.inf], [-np.inf, -0.0]])
    coded = json.loads(json.dumps(record.no_nan(values.tolist()), allow_nan=False))
    array = record.array_of("values", coded, (2, 2), "<f8")
    np.testing.assert_array_equal(array, values)
    assert np.signbit(array[1, 1])


def test_what_is_read_goes_on(results):
    """Loaded results are usable: motions can be sampled and followed, simulations continued, zones queried."""
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


MOTIONS, IMPACTS, EVENTS = (
    ("tables", name, "columns") for name in ("motions", "impacts", "events")
)
BROKEN = [
    ("motion", [*IMPACTS, "X"], [1.0], r"impacts.X = \[1.0\]: must be numbers of shape \(2,\)"),
    ("motion", [*IMPACTS, "X"], "north", "impacts.X = north: must be numbers"),
    ("motion", [*IMPACTS, "X"], [1.0, "north"], "impacts.X = .*: must be numbers"),
    ("motion", [*IMPACTS, "side"], ["R", "Q"], "impacts.side = 'Q': must be one of R, L"),
    ("motion", [*IMPACTS, "side"], ["R", 3], "impacts.side = 3: must be a text"),
    ("motion", [*MOTIONS, "multipliers"], [[1, 2]], r"motions.multipliers of shape \(1,\): must have 4"),
    ("motion", [*MOTIONS, "multipliers"], [1, 2, 3, 4], "motions.multipliers = .*: must be numbers"),
    ("motion", [*MOTIONS, "stable"], 7, "motions.stable = 7: must be codes from -1 to 1"),
    ("motion", [*MOTIONS, "r"], "high", "motions.r = high: must be numbers"),
    ("motion", [*MOTIONS, "xi"], 2.0, "xi = 2.0: must be a number with 0 <= xi < 1"),
    ("motion", [*MOTIONS, "sides"], "RR", "sides = 'RR': must name both walls"),
    ("motion", [*MOTIONS, "sides"], "RRL", r"impacts.X of shape \(2,\): must be one number for each of RRL"),
    ("motion", ["tables", "motions"], 3, "motions = '3': must be an object"),
    ("motion", ["type"], "Zone", "type = 'Zone': must be 'Motion'"),
    ("rest", [*EVENTS, "kind"], ["nothing"] * 99, "events.kind = .*: must be numbers of shape"),
    ("trajectory", [*EVENTS, "x"], [], r"events.x = \[\]: must be numbers of shape \(46,\)"),
    ("trajectory", [*EVENTS, "side"], ["R"] * 45 + ["Q"], "events.side = 'Q': must be one of R, L"),
    ("trajectory", [*EVENTS, "side"], ["R"] * 45 + [""], "events.side = '': must be a word"),
    ("trajectory", ["tables", "final", "columns", "state"], "far", "final.state = far: must be numbers"),
    ("trajectory", ["tables", "moments", "columns", "contact"], [[0, 0]] * 4, "must be .* \\(4, 3\\)"),
    ("trajectory", ["case"], "&simulate", "case: must have the keys of a &simulate; missing"),
    ("branch", ["tables", "points", "columns", "stable"], [1, 0], "points.stable = .*: must be numbers"),
    ("zone", ["tables", "vertices", "columns", "r"], [1.0, 2.0], r"vertices.r = .*: must be numbers of shape"),
    ("zone", ["tables", "vertices", "columns", "r"], "north", "vertices.r = north: must be numbers"),
    ("zone", ["tables", "rings", "owners"], None, "rings.owners = None: must be numbers of shape"),
    ("zone", ["tables", "pieces", "columns", "nothing"], [1], "pieces.nothing: must be one of loop, piece"),
    ("zone", ["tables", "pieces", "parent"], "nothing", "pieces.parent = 'nothing': must be another table"),
    ("zone", ["tables"], [], r"tables = '\[\]': must be an object"),
    ("zone", ["case"], 3, "case = 3: must be of type str"),
    ("atlas", ["tables", "families", "columns", "lines"], [[1]], "families.lines = .*: must be numbers"),
    ("atlas", ["tables", "points", "dims"], 7, "points.dims = '7': must be an object"),
    ("atlas", ["notes"], [1], r"notes = \[1\]: must be pairs"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "path", "value", "output"), BROKEN)
def test_broken_data_is_named(name, path, value, output, results):
    """The error names the wrong item, its value and the allowed values, and belongs to the package."""
    data = copy.deepcopy(results[name].to_dict())
    inner = data
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = value
    with pytest.raises(vi.errors.ParameterError, match=output):
        type(results[name]).from_dict(data)


def test_a_table_is_no_file_to_load(results, tmp_path):
    """Loading a CSV table is refused; the message says that `vibroimpact run` can read it."""
    results["pair"].save(tmp_path / "pair.csv")
    with pytest.raises(
        vi.errors.ParameterError, match=r"a CSV table whose header .* read by .vibroimpact run"
    ):
        vi.load(tmp_path / "pair.csv")


@pytest.mark.parametrize("name", NAMES)
def test_missing_values_are_named(name, results):
    """A missing attribute without a default is named in the error."""
    data = results[name].to_dict()
    for key in data.keys() - {"type", "study", "vibroimpact"}:
        less = {other: item for other, item in data.items() if other != key}
        with pytest.raises(vi.errors.ParameterError, match=rf"{key} = .*: must be"):
            type(results[name]).from_dict(less)


@pytest.mark.parametrize("name", ["motion", "rest", "trajectory"])
def test_missing_columns_are_named(name, results):
    """A missing column that the object or its CSV needs is named in the error; other columns may be missing."""
    data = results[name].to_dict()
    # columns derived from others, or known for few motions only
    spare = {"attenuation", "motion", "impact", "impacts.side", "moment", "final.state"}
    for table, item in data["tables"].items():
        for key in item["columns"]:
            less = copy.deepcopy(data)
            del less["tables"][table]["columns"][key]
            if key == "guess":  # a motion need not have one
                assert type(results[name]).from_dict(less).guess is None
                continue
            error = refusal(type(results[name]), less)
            if error is None:
                assert {key, f"{table}.{key}"} & spare
                assert same(type(results[name]).from_dict(less), results[name])
            else:
                assert re.match(rf"{table}\.({key}: must be present|columns: must have)", error)


def refusal(kind, data):
    """The message with which a record is refused, None if it is not."""
    try:
        kind.from_dict(data)
    except vi.errors.ParameterError as error:
        return str(error)
    return None


@pytest.mark.parametrize("text", ["", "{", "[1, 2]", "7", "{}", '{"type": "Nothing"}', '{"type": ["Zone"]}',
                                  '{"type": "Zone"}', "\N{SNOWMAN}"])  # fmt: skip
def test_files_of_another_kind(text, tmp_path):
    """A file that holds no result is refused, with its name and what it must be."""
    path = tmp_path / "other.json"
    path.write_text(text, encoding="utf-8")
    for read in (vi.load, vi.Atlas.load):
        with pytest.raises(
            vi.errors.ParameterError, match=r"other\.json': must be a file written by"
        ) as caught:
            read(path)
        assert caught.value.__cause__ is None
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(vi.errors.ParameterError, match="must be a file written by"):
        vi.load(path)


def test_cut_and_missing_files(results, tmp_path):
    """A truncated file and a missing file are refused by name."""
    path = tmp_path / "zone.json"
    results["zone"].save(path)
    whole = path.read_text()
    for part in (1, len(whole) // 2, len(whole) - 1):
        path.write_text(whole[:part])
        with pytest.raises(vi.errors.ParameterError, match="must be a file written by"):
            vi.load(path)
    with pytest.raises(vi.errors.ParameterError, match=r"none\.json.*No such file"):
        vi.load(tmp_path / "none.json")
    path.write_text(whole)
    with pytest.raises(vi.errors.ParameterError, match="not a Zone"):
        vi.Atlas.load(path)


def test_names_of_files(results, tmp_path):
    """The suffix of the name determines the form; unknown suffixes are refused, and capitals are allowed."""
    with pytest.raises(vi.errors.ParameterError, match=r"motion.doc'.*must end with one of \.json"):
        results["motion"].save(tmp_path / "motion.doc")
    results["motion"].save(str(tmp_path / "MOTION.JSON"))
    assert same(vi.load(str(tmp_path / "MOTION.JSON")), results["motion"])


@pytest.mark.parametrize(
    "name", ["motion", "pair", "linear", "trajectory", "rests", "branch", "zone", "atlas"]
)
def test_the_namelist_of_a_result_gives_it_again(name, results, tmp_path):
    """The namelist of a result, read by the compiled reader, gives every bit of it, and the same namelist."""
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
    """`vibroimpact run` and the program write the digits of the result from its namelist."""
    path = write(tmp_path / "case.nml", results[name].to_namelist())
    log = vi.run_namelists([path], tmp_path)
    assert log.status == 0
    lines = [line for line in log.results[0].read_text().splitlines() if not line.startswith("#")]
    table = list(csv.DictReader(lines))
    result = results[name]
    column, wanted = {
        "motion": lambda: ("x", result.X),
        "trajectory": lambda: ("time", result.events["time"]),
        "branch": lambda: ("attenuation", result.attenuation),
        "zone": lambda: ("r", np.concatenate([piece.r for piece in result.boundary])),
        "atlas": lambda: (
            "clearance", np.concatenate([p.clearance for zone in result.zones for p in zone.boundary]),
        ),
    }[name]()  # fmt: skip
    assert [float(row[column]) for row in table] == wanted.tolist()


def test_motions_found_otherwise_come_back_within_rounding(tmp_path):
    """The namelist of a motion of `find` has it as the guess, and reproduces it within 1e-9."""
    for motion in vi.find(FIGURE6, 1.04, 25.0, max_impacts=3, max_cycles=1):
        (case,) = vi.read_namelist(write(tmp_path / "case.nml", motion.to_namelist()))
        nearest = min(case.run(), key=lambda again: abs(again.X - motion.X).max())
        np.testing.assert_allclose(nearest.X, motion.X, atol=1e-9)
        np.testing.assert_allclose(nearest.alpha, motion.alpha, atol=1e-9)


@pytest.mark.parametrize("clearance", [20.0, 25.0, 33.3, 70.0])
def test_equispaced_motions_come_back_to_the_bit(clearance, tmp_path):
    """Equispaced motions are restored bit for bit, with the given clearance and not one from rounded results."""
    motions = vi.equispaced(FIGURE6, 1.04, clearance)
    assert [motion.clearance for motion in motions] == [clearance] * 2
    for motion in motions:
        (case,) = vi.read_namelist(write(tmp_path / "case.nml", motion.to_namelist()))
        assert [again.to_json() for again in case.run()] == [item.to_json() for item in motions]


@pytest.mark.parametrize("precision", ["double", "single"])
@pytest.mark.parametrize("acceptance", [0.0, 0.03, 1.0])
@pytest.mark.parametrize("phases", [[0, 2.0, 4.1], [0, 1.25, 4.0]])
def test_acceptance_is_kept(phases, acceptance, precision, tmp_path):
    """A motion that was consistent under its acceptance is consistent after loading."""
    motion = vi.periodic(TABLE, 0.94, phases, vi.Pattern("RRL"), None, precision, acceptance)
    (case,) = vi.read_namelist(write(tmp_path / "case.nml", motion.to_namelist()))
    assert case.run()[0].consistent == motion.consistent


def test_seeds_are_part_of_the_case(results, tmp_path):
    """The namelist of a zone includes its seeds, and reproduces the zone to the last bit."""
    seeds = [results["motion"]]
    seeded = vi.zone(TABLE, vi.Pattern("RL"), (0.9, 1.0), (30, 40), lines=5, guesses=0, seeds=seeds)
    assert seeded.contains(0.94, 37.0)
    (case,) = vi.read_namelist(write(tmp_path / "case.nml", seeded.to_namelist()))
    assert case.run()[0].to_json() == seeded.to_json()


def test_no_namelist_can_tell(results):
    """Motions with rest or another load, and continued trajectories, have no namelist: an error states this."""
    run = results["trajectory"]
    later = vi.simulate(TABLE, 0.94, 37.0, 3, run.final_state)
    for result in (results["rest"], results["free"], later):
        with pytest.raises(vi.errors.ParameterError, match="has no namelist"):
            result.to_namelist()
