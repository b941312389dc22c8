"""Periodic motions of structures by namelists, the program, Python, and files."""

import json
from pathlib import Path

import numpy as np
import pytest
import vibroimpact as vi

INPUT = Path(__file__).parents[2] / "inputs" / "structure_motion.nml"


def damper():
    gaps = [vi.Gap([-1, 1], 18.5, 0.75), vi.Gap([1, -1], 18.5, 0.75)]
    return vi.Structure([1, 0.042], [0.01, 0], [1, 0], gaps), vi.Load(0.94, sine=[1, 0])


def with_rest():
    gaps = [vi.Gap([-1, 1], 3, 0.75), vi.Gap([1, -1], 3, 0.61)]
    structure = vi.Structure([1, 0.028], [0.0228, 0], [1, 0], gaps)
    load = vi.Load(0.9, sine=[1, 0])
    return vi.exact(structure, load, vi.simulate(structure, load, cycles=200))


def with_law():
    law = vi.TabulatedRestitution([0.1, 1.0, 30.0], [0.9, 0.8, 0.7])
    gaps = [vi.Gap([-1, 1], 18.5, law), vi.Gap([1, -1], 18.5, vi.PowerLaw(0.8, 40.0, 0.25))]
    structure = vi.Structure([1, 0.042], [0.01, 0], [1, 0], gaps)
    return vi.exact(structure, vi.Load(0.94, sine=[1, 0]), ([1.62, 5.97], [0, 1]))


MAKERS = {
    "exact": lambda: vi.exact(*damper(), ([1.62, 5.97], [0, 1])),
    "periodic": lambda: vi.periodic(*damper(), [1.62, 5.97], [0, 1]),
    "rest": with_rest,
    "law": with_law,
}


def same(one, other):
    """Check that all digits are equal."""
    for name in (
        "gaps",
        "phases",
        "speeds",
        "impulses",
        "states",
        "matrix",
        "multipliers",
        "rests",
    ):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)
    for name in ("cycles", "residual", "determinant", "law", "consistent", "admissible", "stable"):
        assert getattr(one, name) == getattr(other, name), name


@pytest.mark.parametrize("maker", MAKERS)
def test_namelist_gives_the_same_digits(maker, tmp_path):
    motion = MAKERS[maker]()
    path = tmp_path / "case.nml"
    path.write_text(motion.to_namelist())
    (case,) = vi.read_namelist(path)
    (again,) = case.run()
    same(motion, again)
    assert again.to_namelist() == motion.to_namelist()


@pytest.mark.parametrize("maker", MAKERS)
@pytest.mark.parametrize("extension", ["json", "nc", "mat"])
def test_files_give_the_motion_back(maker, extension, tmp_path):
    motion = MAKERS[maker]()
    path = tmp_path / f"motion.{extension}"
    motion.save(path)
    again = vi.load(path)
    same(motion, again)
    assert repr(again) == repr(motion)
    t = np.linspace(0, 9, 5)
    np.testing.assert_array_equal(again.sample(t), motion.sample(t))


def test_inputs_run(tmp_path):
    motions = [motion for case in vi.read_namelist(INPUT) for motion in case.run()]
    assert [len(motion.gaps) for motion in motions[:3]] == [2, 2, 1]
    assert [len(motion.rests) for motion in motions] == [0, 0, 0, 1]
    assert all(motion.stable for motion in motions)


REFUSED = [
    ("gaps = 0, 2, phases = 1, 2", "the structure has 2 gaps"),
    ("gaps = 0, 1, phases = 1", "1 number for 2 impacts in gaps"),
    ("gaps = 0, 1, phases = 2, 1", "number 2 must not be below number 1"),
    ("gaps = 0, 1, phases = 1, 9", "less than a period"),
    ("gaps = 0, 1, phases = 1e7, 1.00000001e7", "in magnitude"),
    ("gaps = 0, 1.5, phases = 1, 2", "gaps"),
    ("kind = 'settled', gaps = 0, phases = 1", "gaps"),
    ("gaps = 0, phases = 1, settling = 3", "settling"),
    ("kind = 'settled', q = 1", "1 number for 2 coordinates"),
    ("kind = 'other'", "kind"),
    ("", "gaps"),
]


@pytest.mark.parametrize(("keys", "message"), REFUSED)
def test_refused_cases(keys, message, tmp_path):
    head = MAKERS["exact"]().to_namelist().split("&motion")[0]
    path = tmp_path / "case.nml"
    path.write_text(f"{head}&motion {keys} /\n")
    with pytest.raises(vi.errors.ParameterError, match=message):
        vi.read_namelist(path)


def test_one_phase_beyond_the_limit_is_refused(tmp_path):
    """One phase beyond the limit is refused, in either position and with either sign."""
    head = MAKERS["exact"]().to_namelist().split("&motion")[0]
    path = tmp_path / "case.nml"
    for phases in ("999999, 1000001", "-1000001, -999999"):
        path.write_text(f"{head}&motion gaps = 0, 1, phases = {phases} /\n")
        with pytest.raises(vi.errors.ParameterError, match="at most 1e6 rad in magnitude"):
            vi.read_namelist(path)
    path.write_text(f"{head}&motion gaps = 0, 1, phases = 999998, 1000000 /\n")
    vi.read_namelist(path)


def test_a_load_without_frequency_is_refused(tmp_path):
    path = tmp_path / "case.nml"
    path.write_text(
        "&structure mass = 1 /\n&gap direction = 1, opening = 1 /\n&load constant = 1 /\n"
        "&motion gaps = 0, phases = 1 /\n"
    )
    with pytest.raises(vi.errors.ParameterError, match="a &load with a frequency"):
        vi.read_namelist(path)


def test_a_settled_motion_without_impacts_says_so(tmp_path):
    head = MAKERS["exact"]().to_namelist().split("&motion")[0]
    path = tmp_path / "case.nml"
    path.write_text(f"{head}&motion kind = 'settled', settling = 2000 /\n")
    (case,) = vi.read_namelist(path)
    with pytest.raises(vi.errors.SingularError, match="without impacts"):
        case.run()


def test_files_of_the_former_classes(tmp_path):
    """Motions and trajectories of structures had separate classes, which named their files."""
    structure, load = damper()
    motion = with_rest()
    run = vi.simulate(structure, load, cycles=3, state=([0, 0], [60, 0]))
    for found, name in ((motion, "StructureMotion"), (run, "StructureTrajectory")):
        record = found.to_dict() | {"type": name}
        record.pop("study")
        path = tmp_path / f"{name}.json"
        path.write_text(json.dumps(record))
        for read in (type(found).from_dict(record), vi.load(path)):
            assert type(read) is type(found)
            assert read.to_dict() == found.to_dict()
    with pytest.raises(vi.ParameterError, match="type = 'StructureMotion': must be 'Trajectory'"):
        vi.Trajectory.from_dict(motion.to_dict() | {"type": "StructureMotion"})
