"""Structures in the stand-alone program: one clear message for each error, and results that are inputs."""

import numpy as np
import pytest
from programs import PAIR

STRUCTURE = "&structure mass = 1, 0.1, stiffness = 1, 0 /\n"
GAP = "&gap direction = -1, 1, opening = 0.5 /\n"
LOAD = "&load frequency = 0.9, sine = 0.1, 0 /\n"
RUN = "&simulate duration = 20 /\n"
CASE = STRUCTURE + GAP + LOAD + RUN
MODES = """&structure frequencies = 1, 2, damping_ratios = 0.1, 0, shapes = 1, 1 /
&gap direction = 1, opening = 1 /
"""

FAULTS = [
    (GAP + CASE, "gap", "must follow a &structure", 1),
    (STRUCTURE + RUN, "structure", "no &gap, &stop or &friction follows", 1),
    ("&system xi = 0.1, mu = 0.1, r = 1 /\n" + GAP + RUN, "gap", "must follow a &structure, not a &system", 2),
    (STRUCTURE + GAP, "structure", "no &motion, &simulate", 1),
    (STRUCTURE + GAP + LOAD * 2 + RUN, "load", "is the second of this &structure", 4),
    (CASE + GAP, "gap", "must follow a &structure and precede its studies", 5),
    (CASE + LOAD, "load", "must follow a &structure and precede its studies", 5),
    (STRUCTURE + GAP + "&design cycles = 2 /\n", "design", "is not a study of a &structure; must be", 3),
    (RUN, "simulate", "no &system or &structure precedes it", 1),
    (STRUCTURE + GAP * 501 + RUN, "gap", "must be at most 500", 502),
    *[(CASE.replace("mass = 1, 0.1", f"mass = {v}"), "structure", wanted, 1) for v, wanted in (
        ("1, -1", "must be positive definite, and its least eigenvalue is -1"), ("1, 0", "least eigenvalue is 0"),
        ("1, 2, 2, 1", "least eigenvalue is -1"), ("", "must be n numbers"), ("1, nan", "must be n numbers"),
        ("1, inf", "must be n numbers"), ("1, x", "must be n numbers"), ("3*1", "not fit the 3 numbers of mass"),
        ("501*1", "it has 501 numbers"), ("250001*1", "must be n numbers"), ("1, 1, mass = 2", "was given before"),
        ("1, 1, mass_file = 'm.npy'", "must be left out if mass_file is given"),
    )],
    *[(CASE.replace("stiffness = 1, 0", v), "structure", wanted, 1) for v, wanted in (
        ("stiffness = 1, 2, 3, 1", "row 1, column 2 holds 2, and row 2, column 1 3"),
        ("stiffness = 1, 2, 2, 1", "no negative eigenvalue, and the least one is -1"),
        ("damping = -1, 0", "no negative eigenvalue, and the least one is -1"),
        ("stiffness = 1, 2, 3", "it has 3 numbers, which does not fit the 2 numbers of mass"),
        ("stif = 1, 0", "is not a key of &structure; must be one of mass, damping"),
        ("frequencies = 1", "must be left out if frequencies is given"), ("shapes = 1", "requires frequencies"),
    )],
    *[(CASE.replace("stiffness = 1, 0", f"stiffness_file = '{v}'"), "structure", wanted, 1) for v, wanted in (
        ("none.npy", "none.npy: No such file"), (".", "Is a directory"), ("", "must be a Matrix Market file"),
        ("text.mtx", "starts neither as a Matrix Market file"), ("empty.mtx", "starts neither as"),
        ("short.mtx", "line 5: must contain row, column and value of entry 3 of 3"),
        ("complex.mtx", "line 1: must declare a matrix that is coordinate or array"),
        ("outside.mtx", "line 4: must give a row and a column, not given before, within 2 rows and 2 columns"),
        ("twice.mtx", "line 4: must give a row and a column, not given before, within 2 rows and 2 columns"),
        ("long.mtx", "line 7: there must be nothing after the last entry"), ("large.mtx", "99999999 rows"),
        ("nan.mtx", "line 4: must contain one number of entry 2 of 4"),
        ("whole.npy", "it holds '<i8'; must be float64"), ("nan.npy", "not finite"),
        ("three.npy", "does not fit the 2 numbers of mass"), ("wide.npy", "2 rows and 3 columns; must be square"),
        ("none_0.npy", "0 rows"), ("large.npy", "501 rows"), ("cube.npy", "the shape (2,2,2)"),
        ("cut.npy", "it has 29 bytes of numbers; must be 32"), ("head.npy", "its header is damaged"),
    )],
    *[(CASE.replace(GAP, f"&gap {v} /\n"), "gap", wanted, 2) for v, wanted in (
        ("direction = 1, opening = 1", "it has 1, not 2"), ("direction = 1, 1, 1, opening = 1", "it has 3, not 2"),
        ("direction = 0, 0, opening = 1", "not all 0"), ("direction = 1, 0", "opening: is missing"),
        ("opening = 1", "direction: is missing"), ("direction = 1, 0, opening = inf", "a finite number"),
        ("direction = 1, 0, opening = 1, restitution = 1.5", "0 <= restitution <= 1"),
        ("direction = 1, 0, opening = 1, resitution = 1", "is not a key of &gap; must be one of direction"),
    )],
    *[(CASE.replace(LOAD, f"&load {v} /\n"), "load", wanted, 3) for v, wanted in (
        ("frequency = 1, base = 'motion', base_sine = 1e300", "one number from -1e40 to 1e40 for each harmonic"),
        ("frequency = 1, sine = 1", "it has 1 number for 2 coordinates"), ("sine = 1, 0", "requires frequency"),
        ("frequency = 0, sine = 1, 0", "0 < frequency"), ("frequency = 1", "or give cosine or sine"),
        ("constant = 1, 2, 3, 4", "it has 4 numbers for 2 coordinates"), ("", "constant: is missing"),
    )],
    *[(CASE.replace(LOAD, f"&load {v}, step = 0.1 /\n"), "load", wanted, 3) for v, wanted in (
        ("record_file = 'none.csv', acts_on = 1", "none.csv: No such file"),
        ("record_file = 'words.csv', acts_on = 1", "line 2: must contain finite numbers"),
        ("record_file = 'nan.csv', acts_on = 1", "nan.csv: line 3: must contain 1 finite number, like the"),
        ("record_file = 'inf.csv', acts_on = 1", "inf.csv: line 2: must contain 1 finite number"),
        ("record_file = 'blank.csv', acts_on = 1", "blank.csv: line 2: must contain 1 finite number"),
        ("record_file = 'ragged.csv'", "ragged.csv: line 2: must contain 2 finite numbers, like the lines before"),
        ("record_file = 'cell.csv'", "cell.csv: line 2: must contain 2 finite numbers"),
        ("record_file = 'one.csv', acts_on = 1", "it has one sample"),
        ("record_file = 'empty.mtx', acts_on = 1", "it contains no numbers"),
        ("record_file = 'times.csv'", "it has only a column of times"),
        ("record_file = 'late.csv', acts_on = 1", "sample 1 is at time 1; must be 0"),
        ("record_file = 'jump.csv', acts_on = 1", "sample 3 is at time 0.3; must be 0.2"),
        ("record_file = 'nan.npy'", "that is not finite, in row 1, column 1"),
        ("record_file = 'cube.npy'", "must be a table, or a list"),
        ("record_file = 'twice.mtx'", "line 4: must give a row and a column, not given before, within 2"),
        ("record_file = 'three.npy'", "it has 3 columns, not the 2 of all coordinates; or give acts_on"),
        ("record_file = 'three.npy', acts_on = 0", "it has 3 columns, not the 1 of acts_on"),
        ("record_file = 'three.npy', base = 'acceleration'", "it has 3 columns, not the 1 of base"),
        ("record_file = 'three.npy', base = 'motion'", "it has 3 columns, not the 2 of base"),
        ("record_file = 'three.npy', weights = 1, 1", "it has 3 columns, not the 1 of weights"),
        ("record = 1, 2, 3", "it has 3 numbers for the 2 columns of all coordinates"),
        ("record = 1, 2", "it has one sample"), ("record = 1, nan", "must be one number for each column"),
        ("record = 3*1, base = 'motion'", "it has 3 numbers for the 2 columns of base"),
        ("record = 3*1, acts_on = 2", "must be the number of a coordinate, from 0"),
        ("record = 4*1, acts_on = 0, 0", "no number twice"),
        ("record = 3*1, weights = 1, 2, 3", "it has 3 numbers for 2 coordinates"),
        ("record = 3*1, weights = 1, 2, acts_on = 1", "acts_on = 1: must be left out if weights is given"),
        ("record = 3*1, weights = 1, 2, base = 'motion'", "weights = 1, 2: must be left out if base is given"),
        ("record = 3*1, base = 'yes'", "must be 'acceleration' (one column)"),
        ("record = 3*1, base_direction = 1, 1", "it requires base"),
        ("record = 3*1, base = 'acceleration', base_direction = 1", "it has 1 number for 2 coordinates"),
        ("record = 4*1, frequency = 1", "must be left out if frequency is given"),
        ("record = 4*1, record_file = 'm.csv'", "must be left out if record"),
        ("constant = 1, 0", "step = 0.1: must be left out: it requires record or record_file"),
    )],
    (CASE.replace(LOAD, "&load record = 4*1 /\n"), "load", "step: is missing; must be a number with 0 < step", 3),
    (CASE.replace(LOAD, "&load record = 4*1, step = 0 /\n"), "load", "0 < step", 3),
    (CASE.replace(LOAD, "&load record = 4*1, step = 1 /\n").replace("duration", "cycles"), "simulate",
     "a &load with a frequency", 4),
    (CASE.replace(LOAD, "&load record = 4*1, step = 1 /\n").replace(RUN, "&lyapunov cycles = 100 /\n"), "lyapunov",
     "must be periodic or constant, not a record", 4),
    (CASE.replace(LOAD, "&load record = 4*1, step = 1 /\n").replace(RUN, "&motion kind = 'settled' /\n"), "motion",
     "a &load with a frequency", 4),
    *[(CASE.replace(RUN, f"&simulate {v} /\n"), "simulate", wanted, 4) for v, wanted in (
        ("", "duration: is missing"), ("duration = 1, cycles = 1", "must be left out if cycles is given"),
        ("duration = -1", "0 <= duration <= 1e12"), ("duration = 1, q = 1", "1 number for 2 coordinates"),
        ("duration = 1, q_dot = 1, 2, 3", "3 numbers for 2 coordinates"), ("cycles = 1e9, start = -1", "start"),
        ("duration = 1, max_events = 0", "max_events"), ("duration = 1, clearance = 1", "is not a key of"),
    )],
    (CASE.replace(LOAD, "").replace("duration = 20", "cycles = 2"), "simulate", "a &load with a frequency", 3),
    (CASE.replace("frequency = 0.9", "frequency = 1e-9").replace("duration = 20", "cycles = 1e9"), "simulate",
     "at most 1e12", 4),
    (MODES.replace("ratios = 0.1, 0", "ratios = 0.1") + RUN, "structure", "there are 2 frequencies", 1),
    (MODES.replace("shapes = 1, 1", "shapes = 1, 1, 1") + RUN, "structure", "2 frequencies and 3 numbers", 1),
    (MODES.replace("= 1, 2,", "= -1, 2,") + RUN, "structure", "one number from 0 to 1e40", 1),
    (MODES.replace("direction = 1", "direction = 1, 1") + RUN, "gap", "it has 2, not 1", 2),
]  # fmt: skip
MARKET = "%%MatrixMarket matrix "
FILES = {
    "text.mtx": "hello", "empty.mtx": "", "short.mtx": f"{MARKET}coordinate real symmetric\n2 2 3\n1 1 1\n2 2 1\n",
    "complex.mtx": f"{MARKET}coordinate complex general\n2 2 1\n1 1 1 0\n",
    "outside.mtx": f"{MARKET}coordinate real symmetric\n2 2 2\n1 1 1\n3 1 1\n",
    "twice.mtx": f"{MARKET}coordinate real general\n2 2 2\n1 1 1\n1 1 2\n",
    "long.mtx": f"{MARKET}array real general\n2 2\n1\n0\n0\n1\n7\n",
    "large.mtx": f"{MARKET}array real general\n99999999 2\n",
    "words.csv": "f\none\n1\n", "nan.csv": "f\n1\nnan\n2\n",
    "inf.csv": "1\ninf\n2\n", "blank.csv": "1\n\n2\n",
    "ragged.csv": "1,2\n3\n4,5\n", "cell.csv": "1,2\n3,\n4,5\n", "one.csv": "f\n1\n",
    "times.csv": "time\n0\n0.1\n",
    "late.csv": "t,f\n1,2\n1.1,2\n1.2,3\n", "jump.csv": "t f\n0,2\n0.1,2\n0.3,3\n0.4,3\n",
    "nan.mtx": f"{MARKET}array real general\n2 2\n1\nnan\n0\n1\n",
}  # fmt: skip


@pytest.fixture(scope="module")
def broken(tmp_path_factory):
    """A folder with files that are not symmetric matrices of 2 rows."""
    folder = tmp_path_factory.mktemp("matrices")
    for name, text in FILES.items():
        (folder / name).write_text(text, encoding="utf-8")
    arrays = {
        "whole": np.eye(2, dtype=np.int64), "nan": np.full((2, 2), np.nan), "three": np.eye(3),
        "wide": np.ones((2, 3)), "none_0": np.zeros((0, 0)), "large": np.eye(501), "cube": np.ones((2, 2, 2)),
    }  # fmt: skip
    for name, array in arrays.items():
        np.save(folder / f"{name}.npy", array)
    np.save(folder / "good.npy", np.eye(2))
    content = (folder / "good.npy").read_bytes()
    (folder / "cut.npy").write_bytes(content[:-3])
    (folder / "head.npy").write_bytes(content[:20])
    return folder


@pytest.mark.parametrize(("text", "group", "wanted", "line"), FAULTS)
def test_one_clear_error(text, group, wanted, line, batch, broken):
    text = text.replace("_file = '", f"_file = '{broken}/") if "_file = ''" not in text else text
    text = text.replace(f"{broken}/m.npy", "m.npy")
    done = batch.case(text)
    assert (done.status, done.out, len(done.faults)) == (2, b"", 1), done
    assert done.faults[0].startswith(f"case.nml:{line}: &{group}"), done.faults
    assert wanted in done.faults[0]


def test_file_faults_name_the_file(batch, broken):
    """A path is relative to the folder of the namelist."""
    (batch.cwd / "m.mtx").write_text(FILES["long.mtx"], encoding="utf-8")
    text = CASE.replace("stiffness = 1, 0", "stiffness_file = 'm.mtx'")
    assert_refused_with_file(
        batch, text, "m.mtx: line 7: there must be nothing after the last entry"
    )


def assert_refused_with_file(batch, text, wanted):
    done = batch.case(text)
    assert (done.status, len(done.faults)) == (2, 1)
    assert wanted in done.faults[0]


def test_group_of_an_oscillator_after_a_structure(batch):
    """A &system after a &structure replaces it."""
    done = batch.case(CASE + PAIR)
    assert (done.status, done.faults) == (0, [])


def test_closed_gap_fails_without_a_result(batch):
    """A state with a negative gap gives no result, but is valid input, since the whole case has to be known."""
    done = batch.case(CASE.replace("duration = 20", "duration = 20, q = 0, 3"))
    assert done.status == 1
    fault = "case: a gap is negative in the initial state: gap 0 is -2.5, must be >= 0"
    assert done.faults == [fault]


def test_result_is_an_input(batch):
    """The header holds the matrices of files, so that the result needs no other file."""
    np.save(batch.cwd / "k.npy", np.array([[1.0, -0.25], [-0.25, 0.5]]))
    done = batch.case(CASE.replace("stiffness = 1, 0", "stiffness_file = 'k.npy'"))
    assert done.status == 0
    first = (batch.cwd / "results" / "case.csv").read_bytes()
    assert b"_file" not in first
    assert b"stiffness = 1.0000000000000000E+000, -2.5000000000000000E-001, -2.5" in first
    (batch.cwd / "k.npy").unlink()
    (batch.cwd / "again.csv").write_bytes(first)
    assert batch("again.csv", "-o", "more").status == 0
    assert (batch.cwd / "more" / "case.csv").read_bytes() == first


def test_keys_of_the_groups(batch):
    """`--keys` gives those of &simulate for both kinds of systems, and those of the groups of a structure."""
    text = batch("--keys", "simulate").out.decode()
    assert "clearance: " in text
    assert "&simulate of a &structure\n  duration: " in text
    for group, key in (("structure", "stiffness_file"), ("gap", "direction"), ("load", "cosine")):
        assert f"\n  {key}: " in batch("--keys", group).out.decode()
