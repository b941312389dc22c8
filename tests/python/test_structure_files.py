"""Structures by namelists, saved files and the interface of the core: each gives the same digits."""

import csv
import pickle

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact.results import door, namelist
from vibroimpact.results.noun import result_class

FREE = "&structure mass = 1, 0.3, stiffness = 1, 0 /\n"
WALLS = "&gap direction = -1, 1, opening = 1 /\n&gap direction = 1, -1, opening = 1, restitution = .9 /\n"
CELL = f"{FREE}{WALLS}&simulate duration = 20, q_dot = 0, -1 /\n"


def random_structure(rng):
    """Any structure with gaps, its load, and a state in which all gaps are open."""
    n, gaps = int(rng.integers(1, 6)), int(rng.integers(1, 5))

    def definite(rank):
        root = rng.normal(size=(n, rank))
        return root @ root.T

    diagonal = rng.random() < 0.4
    mass = rng.uniform(0.5, 2, n) if diagonal else definite(n) + np.eye(n)
    stiffness = definite(max(1, n - 1))
    damping = rng.choice([0, 0.1]) * definite(n)
    laws = [
        float(rng.uniform(0.3, 1)), vi.PowerLaw(float(rng.uniform(0.5, 1)), float(rng.uniform(0.1, 2)), 0.25),
        vi.TabulatedRestitution([0.0, 0.5, float(rng.uniform(1, 3))], [0.9, 0.8, 0.5]),
    ]  # fmt: skip
    sides = [
        vi.Gap(
            rng.normal(size=n),
            float(rng.uniform(0.5, 1.5)),
            laws[int(rng.choice(3, p=[0.6, 0.2, 0.2]))],
        )
        for _ in range(gaps)
    ]
    h = int(rng.integers(0, 3))
    words = {"constant": rng.normal(size=n)} if h == 0 or rng.random() < 0.5 else {}
    if h:
        words |= {"sine": rng.normal(size=(h, n)), "cosine": rng.normal(size=(h, n))}
    frequency = float(rng.uniform(0.5, 2)) if h or rng.random() < 0.5 else None
    load = None if rng.random() < 0.2 else vi.Load(frequency, **words)
    return vi.Structure(mass, damping, stiffness, sides), load, (np.zeros(n), rng.normal(size=n))


def outcome(compute):
    """The trajectory, or the type of the error."""
    try:
        return compute()
    except vi.VibroimpactError as error:
        return type(error).__name__


def assert_same(one, other):
    """Check that two trajectories have the same bits, or the same type of error."""
    if isinstance(one, str) or isinstance(other, str):
        assert one == other
        return
    for name in ("start", "end", "complete"):
        assert getattr(one, name) == getattr(other, name), name
    assert one.events.tobytes() == other.events.tobytes()
    assert one.states.tobytes() == other.states.tobytes()
    for first, second in zip(one.final_state, other.final_state, strict=True):
        assert first.tobytes() == second.tobytes()
    assert (one.structure.mass == other.structure.mass).all()
    assert (one.structure.stiffness == other.structure.stiffness).all()
    assert repr(one.structure.gaps) == repr(other.structure.gaps)
    assert (one.load is None) == (other.load is None)
    if one.load is not None:
        assert one.load.frequency == other.load.frequency
        assert (one.load.constant == other.load.constant).all()
        assert np.array_equal(one.load.sine, other.load.sine)


def run_case(text):
    found = door.run_text(result_class("simulate"), text)
    found.require()
    return found.parts()[0]


def test_same_digits_through_every_door(tmp_path):
    """A Python call, a namelist text, a namelist file, and the tables of `run` give the same digits."""
    rng = np.random.default_rng(11)
    found = 0
    for i in range(60):
        structure, load, state = random_structure(rng)
        span = {"duration": 12.0}
        if load is not None and load.frequency and rng.random() < 0.5:
            span = {"cycles": 2.5}
        if rng.random() < 0.3:
            span["discard"] = float(rng.choice([1.25, 3.0]))
        # all arguments of the call; it may also raise the error that the motion cannot be followed
        words = span | {"state": state, "start": float(rng.choice([0, 3.25]))}
        direct = outcome(lambda: vi.simulate(structure, load, max_events=400, **words))  # noqa: B023
        request = span | {
            "q": state[0].tolist(), "q_dot": state[1].tolist(), "start": words["start"], "max_events": 400,
        }  # fmt: skip
        groups = [*structure._groups(), *([] if load is None else load._groups())]
        text = namelist.text([*groups, ("simulate", request)])
        assert_same(direct, outcome(lambda: run_case(text)))  # noqa: B023
        path = tmp_path / f"case{i}.nml"
        path.write_text(text, encoding="utf-8")
        (case,) = vi.read_namelist(path)
        assert (case.structure.damping == structure.damping).all()
        log = vi.run_namelists([path], tmp_path)
        if isinstance(direct, str):
            assert log.status == 1
            continue
        assert direct.to_namelist() == text
        assert log.status == (0 if direct.complete else 1)
        found += len(direct.events)
        with log.results[0].open(encoding="utf-8", newline="") as lines:
            rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
        assert [float(row["time"]) for row in rows] == direct.events["time"].tolist()
        assert [int(row["gap"]) for row in rows] == direct.events["gap"].tolist()
        n = structure.coordinates
        velocities = [[float(row[f"q_dot_{k}"]) for k in range(n)] for row in rows]
        assert np.array_equal(np.reshape(velocities, (-1, n)), direct.states[:, 1])
        # the header of the table reproduces the table
        again = vi.run_namelists([log.results[0]], tmp_path / "again")
        assert again.results[0].read_bytes() == log.results[0].read_bytes()
    assert found > 500


@pytest.mark.parametrize("suffix", [".json", ".nc", ".mat"])
@pytest.mark.parametrize("words", [
    {"duration": 20, "state": ([0, 0], [0, -1])}, {"duration": 20}, {"duration": 0.0},
    {"duration": 20, "max_events": 3, "state": ([0, 0], [0, -1])},
    {"cycles": 4, "load": vi.Load(0.7, sine=[[1, 0], [0.25, 0]], constant=[0, 0.1])},
])  # fmt: skip
def test_saved_and_read_back(tmp_path, suffix, words):
    structure = run_case(CELL).structure
    run = vi.simulate(
        structure, words.get("load"), **{k: v for k, v in words.items() if k != "load"}
    )
    path = tmp_path / f"run{suffix}"
    run.save(path)
    again = vi.load(path)
    assert_same(run, again)
    assert again.to_json() == run.to_json()
    assert again.to_namelist() == run.to_namelist()
    times = np.linspace(run.start, run.end, 20)
    assert np.array_equal(again.sample(times)[1], run.sample(times)[1])
    assert_same(run, pickle.loads(pickle.dumps(run)))


def test_saved_table_is_that_of_the_runner(tmp_path):
    path = tmp_path / "cell.nml"
    path.write_text(CELL, encoding="utf-8")
    log = vi.run_namelists([path], tmp_path / "by program")
    run_case(CELL).save(tmp_path / "cell.csv")
    assert (tmp_path / "cell.csv").read_bytes() == log.results[0].read_bytes()


def test_structure_without_gaps_is_saved_without_its_case(tmp_path):
    run = vi.simulate(vi.Structure([1], [0], [1]), duration=1, state=([1], [0]))
    with pytest.raises(vi.ParameterError, match="has no namelist"):
        run.to_namelist()
    run.save(tmp_path / "free.json")
    assert_same(run, vi.load(tmp_path / "free.json"))


def matrix_market(matrix, symmetric, coordinate):
    """A matrix as a Matrix Market file."""
    n = len(matrix)
    cells = [(i, j) for j in range(n) for i in range(j if symmetric else 0, n)]
    kind = "coordinate" if coordinate else "array"
    lines = [
        f"%%MatrixMarket matrix {kind} real {'symmetric' if symmetric else 'general'}",
        "% a comment",
    ]
    if coordinate:
        cells = [(i, j) for i, j in cells if matrix[i, j]]
        lines += [
            f"{n} {n} {len(cells)}",
            *(f"{i + 1} {j + 1}\t{matrix[i, j]!r}" for i, j in cells),
        ]
    else:
        lines += [f"{n} {n}", *(repr(float(matrix[i, j])) for i, j in cells)]
    return "\n".join(lines) + "\n"


def test_matrices_of_files(tmp_path):
    """All formats of a file give the same matrix, to the bit; paths are relative to the folder of the namelist."""
    rng = np.random.default_rng(3)
    root = rng.normal(size=(3, 3))
    matrix = np.array(root @ root.T)
    matrix[2] = matrix[:, 2] = 0
    matrix = 0.5 * (matrix + matrix.T)
    folder = tmp_path / "inner"
    folder.mkdir()
    np.save(folder / "c.npy", matrix)
    np.save(folder / "f.npy", np.asfortranarray(matrix))
    np.save(folder / "big.npy", matrix.astype(">f8"))
    with (folder / "second.npy").open("wb") as file:
        np.lib.format.write_array(file, matrix, version=(2, 0))
    for symmetric in (True, False):
        for coordinate in (True, False):
            text = (
                matrix_market(matrix, symmetric, coordinate)
                .replace("np.float64(", "")
                .replace(")", "")
            )
            (folder / f"{symmetric}{coordinate}.mtx").write_text(text, encoding="utf-8")
    files = [path for path in folder.iterdir() if path.suffix in (".npy", ".mtx")]
    assert len(files) == 8
    for path in files:
        case = tmp_path / f"{path.stem}.nml"
        case.write_text(
            f"&structure mass = 3*1, stiffness_file = 'inner/{path.name}', damping_file = '{path}' /\n"
            "&gap direction = 1, 0, 0, opening = 1 /\n&simulate duration = 1 /\n", encoding="utf-8",
        )  # fmt: skip
        (read,) = vi.read_namelist(case)
        assert np.array_equal(read.structure.stiffness, matrix), path
        assert np.array_equal(read.structure.damping, matrix), path
        assert "_file" not in read.text


def test_diagonal_of_a_file(tmp_path):
    np.save(tmp_path / "m.npy", np.array([2.0, 3.0]))
    path = tmp_path / "case.nml"
    path.write_text(
        "&structure mass_file = 'm.npy' /\n&gap direction = 1, 0, opening = 1 /\n"
        "&simulate duration = 1 /\n", encoding="utf-8",
    )  # fmt: skip
    (case,) = vi.read_namelist(path)
    assert np.array_equal(case.structure.mass, np.diag([2.0, 3.0]))
    assert not case.structure.stiffness.any()


def test_lists_of_four_numbers():
    """Four numbers are a matrix of 2 coordinates or the diagonal of 4; the first gap decides."""
    for direction, n in (("1, 0", 2), ("1, 0, 0, 0", 4)):
        run = run_case(
            f"&structure mass = 4, 1, 1, 4 /\n&gap direction = {direction}, opening = 1 /\n"
            "&simulate duration = 1 /\n"
        )
        wanted = [[4, 1], [1, 4]] if n == 2 else np.diag([4, 1, 1, 4])
        assert np.array_equal(run.structure.mass, wanted)


def test_modes():
    """A structure given by modes equals that of `Structure.from_modes`, to the bit."""
    rng = np.random.default_rng(8)
    omega, zeta, shapes = rng.uniform(0, 9, 5), rng.uniform(0, 0.1, 5), rng.normal(size=(3, 5))
    gaps = [vi.Gap(rng.normal(size=3), 0.4, 0.6) for _ in range(2)]
    direct = vi.Structure.from_modes(omega, zeta, shapes, gaps)
    groups = [("structure", {
        "frequencies": omega.tolist(), "damping_ratios": zeta.tolist(), "shapes": shapes.ravel().tolist(),
    })]  # fmt: skip
    groups += [("gap", {"direction": gap.direction.tolist(), "opening": 0.4, "restitution": 0.6})
               for gap in gaps]  # fmt: skip
    rate = rng.normal(size=5)
    text = namelist.text([*groups, ("simulate", {"duration": 30, "q_dot": rate.tolist()})])
    run = run_case(text)
    for name in ("mass", "damping", "stiffness"):
        assert np.array_equal(getattr(run.structure, name), getattr(direct, name))
    again = vi.simulate(direct, duration=30, state=(np.zeros(5), rate))
    assert len(again.events) > 5
    assert_same(run, again)


def test_repeats_and_messages_of_large_matrices():
    """A matrix of 500 coordinates is read, and an error in it has a short message."""
    zeros = "500*1"
    text = f"&structure mass = {zeros}, stiffness = 249999*0, -1 /\n"
    text += "&gap direction = 1, 499*0, opening = 1 /\n&simulate duration = 1 /\n"
    with pytest.raises(vi.ParameterError, match="least one is -1") as fault:
        run_case(text)
    assert len(str(fault.value)) < 800


def test_case_of_a_structure(tmp_path):
    path = tmp_path / "cell.nml"
    path.write_text(CELL, encoding="utf-8")
    (case,) = vi.read_namelist(path)
    assert case.kind == "simulate"
    assert case.study == "simulate"
    assert case.osc is None
    assert case.load is None
    assert case.structure.gaps[1].restitution == 0.9
    (run,) = case.run()
    assert_same(run, vi.simulate(case.structure, duration=20, state=([0, 0], [0, -1])))


def test_one_file_with_both_kinds_of_systems(tmp_path):
    """Each study belongs to the system before it."""
    pair = "&system xi = 0.1, mu = 0.1, restitution = 0.7, r = 0.9 /\n&simulate clearance = 5, cycles = 3 /\n"
    path = tmp_path / "both.nml"
    path.write_text(pair + CELL + pair, encoding="utf-8")
    cases = vi.read_namelist(path)
    assert [case.study for case in cases] == ["simulate", "simulate", "simulate"]
    assert cases[0].text.replace("both_1", "") == cases[2].text.replace("both_3", "")
    # a zone of a structure starts from a motion, a zone of an oscillator does not
    path.write_text(
        "&system xi = 0.1, mu = 0.1, restitution = 0.7, r = 0.9 /\n&motion kind = 'equispaced', clearance = 5 /\n"
        "&zone sides = 'RL', r_min = 0.8, r_max = 1, clearance_min = 2, clearance_max = 9 /\n", encoding="utf-8",
    )  # fmt: skip
    assert [case.study for case in vi.read_namelist(path)] == ["motion", "zone"]


def test_structures_are_compared_by_value():
    rng = np.random.default_rng(4)
    for _ in range(20):
        structure, load, _ = random_structure(rng)
        if load is None:
            continue
        text = namelist.text(
            [*structure._groups(), *load._groups(), ("simulate", {"duration": 0.0})]
        )
        run = run_case(text)
        assert run.structure == structure
        assert run.load == load
        assert len({run.structure, structure}) == 1
        other = vi.Structure(
            2 * structure.mass, structure.damping, structure.stiffness, structure.gaps
        )
        assert other != structure
        assert structure != load


def moving():
    """A trajectory, a motion, the motions of a search, a branch, a zone, and two sweeps."""
    gaps = [vi.Gap([-1, 1], 18.5, 0.75), vi.Gap([1, -1], 18.5, 0.75)]
    cell = vi.Structure([1, 0.042], [0.01, 0], [1, 0], gaps)
    load = vi.Load(0.94, sine=[1.0, 0.0])
    motion = vi.exact(cell, load, ([1.6250583, 5.9668230], [0, 1]))
    return [
        vi.simulate(cell, load, cycles=5, state=([0, 0], [1, -3])), motion,
        vi.branch(motion, "frequency", (0.939, 0.941)),
        vi.zone(motion, ("frequency", 0.93, 0.95), ("load", 0.95, 1.05), lines=5),
        vi.find(cell, load, guesses=2, states=2, settling=20),
        vi.bifurcation_diagram(cell, load, "frequency", [0.93, 0.94], settling=2, keep=3, impacts=3),
    ]  # fmt: skip


@pytest.fixture(scope="module")
def results():
    return moving()


@pytest.mark.parametrize("number", [2, 10**6, -5, -1])
def test_gap_numbers_are_checked_when_they_are_read(results, number):
    """Without checks the core would read beyond its arrays in samples, quantities and derivatives."""
    tried = 0
    for result in results:
        for name, table in result.to_dict()["tables"].items():
            for key in {"gap", "gaps"} & set(table["columns"]):
                data = result.to_dict()
                inner = data["tables"][name]["columns"]
                while isinstance(inner[key], list) and inner[key]:
                    inner, key = inner[key], 0
                if isinstance(inner[key], list):
                    continue
                inner[key], tried = number, tried + 1
                with pytest.raises(
                    vi.ParameterError, match=rf"{name}\.gaps? = {number}: must be the number of one"
                ):
                    type(result).from_dict(data)
    assert tried >= 5


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t: t["events"]["columns"]["time"].reverse(), r"events.time\[\d\] = .*: must be in ascending"),
        (lambda t: t["moments"]["columns"]["time"].reverse(), "moments.time = .*: must be finite, and in order"),
        (lambda t: t["events"]["columns"]["kind"].__setitem__(0, ""), "events.kind = '': must be one of impact"),
        (lambda t: t["events"]["columns"]["gap"].__setitem__(0, 0.5), "events.gap = .*: must be numbers of shape"),
        (lambda t: t["events"]["columns"]["gap"].__setitem__(0, "1"), "events.gap = .*: must be numbers of shape"),
        (lambda t: t["events"]["columns"]["speed"].__setitem__(0, "1_00"), "events.speed = .*: must be numbers"),
        (lambda t: t["moments"]["columns"]["q"][0].__setitem__(0, None), "moments.q: must be finite numbers"),
        (lambda t: t["events"]["dims"].update({"x" * 20: 1}), "events.dims: 'xxx.*' must be a name of 1 to 15"),
    ],
)  # fmt: skip
def test_trajectories_of_files_are_checked(results, change, message):
    """An inconsistent item is named before the core uses it."""
    data = results[0].to_dict()
    change(data["tables"])
    with pytest.raises(vi.ParameterError, match=message):
        vi.Trajectory.from_dict(data)


def test_a_loaded_diagram_is_saved_as_the_first_one(results, tmp_path):
    """A loaded diagram is saved like the original; this study has the longest name."""
    diagram = results[-1]
    again = type(diagram).from_json(diagram.to_json())
    again.save(tmp_path / "run.csv")
    diagram.save(tmp_path / "other.csv")
    other = (tmp_path / "other.csv").read_text().replace("name = 'other'", "name = 'run'")
    assert (tmp_path / "run.csv").read_text() == other


@pytest.mark.parametrize(
    "case", ["", "&load\n  frequency = 1_0\n/\n", "&structure\n  mass = 9999999999*1.0\n/\n"]
)
def test_results_of_structures_need_their_case(results, case):
    """A record that is not that of a structure gives an error of the package."""
    data = results[-1].to_dict() | {"case": case}
    with pytest.raises(vi.ParameterError, match=r"case|a list of 9999999999 numbers"):
        type(results[-1]).from_dict(data)
