"""Searches for motions of structures by namelists, the program, Python, and files."""

import json
from pathlib import Path

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact import _core
from vibroimpact.base.interrupt import new_counters
from vibroimpact.results.tables import from_core

INPUT = Path(__file__).parents[2] / "inputs" / "structure_find.nml"


def search(**options):
    gaps = [vi.Gap([-1, 1], 3, 0.75), vi.Gap([1, -1], 3, 0.61)]
    structure = vi.Structure([1, 0.028], [0.0228, 0], [1, 0], gaps)
    load = vi.Load(0.9, sine=[1, 0])
    return vi.find(structure, load, **{"states": 4, "max_cycles": 1, "guesses": 12, **options})


def same(one, other):
    """Check that all digits are equal."""
    assert repr(one) == repr(other)
    assert (one.settled, one.failures) == (other.settled, other.failures)
    for a, b in zip(one, other, strict=True):
        for name in ("gaps", "phases", "speeds", "states", "matrix", "multipliers", "rests"):
            np.testing.assert_array_equal(getattr(a, name), getattr(b, name), err_msg=name)


@pytest.mark.parametrize("extension", ["json", "nc", "mat"])
def test_files_and_namelists_give_it_back(extension, tmp_path):
    found = search()
    assert any(len(motion.rests) for motion in found)
    path = tmp_path / f"found.{extension}"
    found.save(path)
    same(found, vi.load(path))
    namelist = tmp_path / "case.nml"
    namelist.write_text(found.to_namelist())
    (case,) = vi.read_namelist(namelist)
    (again,) = case.run()
    same(found, again)


def test_each_motion_has_a_namelist_of_its_own(tmp_path):
    for motion in search():
        path = tmp_path / "motion.nml"
        path.write_text(motion.to_namelist())
        (case,) = vi.read_namelist(path)
        (again,) = case.run()
        assert vi.same_motion(motion, again)
        assert abs(again.multipliers - motion.multipliers).max() < 1e-8


def test_a_motion_of_the_search_solves_its_equations():
    """The state after a simulated period is the one before it."""
    for motion in search():
        if not motion.stable:
            continue
        start = motion.phases[0] / motion.load.frequency
        run = vi.simulate(
            motion.structure, motion.load, cycles=motion.cycles, state=(motion.q, motion.q_dot), start=start
        )  # fmt: skip
        np.testing.assert_allclose(run.final_state[0], motion.q, atol=1e-8)


def test_states_that_settle_early_settle_on_the_motion_of_a_long_simulation():
    found = search(states=1)
    structure, load = found.structure, found.load
    wanted = vi.exact(structure, load, vi.simulate(structure, load, cycles=600))
    assert vi.same_motion(wanted, found[0])
    # a state that has not settled when it is first examined continues
    early = search(settling=0, states=1)
    assert early.unsettled == 0
    assert vi.same_motion(wanted, early[0])


def test_inputs_run(tmp_path):
    log = vi.run_namelists([INPUT], tmp_path)
    assert log.status == 0, log
    table = (tmp_path / "structure_find_table1.csv").read_text()
    assert "motion,cycles,stable,settled,impact,gap" in table


def test_picture():
    pytest.importorskip("matplotlib")
    found = search()
    ax = found.plot()
    numbers = sorted(int(n) for text in ax.texts for n in text.get_text().split(", "))
    assert numbers == list(range(1, len(found) + 1))
    names = {text.get_text() for text in ax.get_legend().get_texts()}
    stable = {f"multipliers, {'' if motion.stable else 'not '}stable" for motion in found}
    assert names == stable
    assert "FoundMotions" in found._repr_html_()


def test_it_stops_when_asked():
    counters = new_counters()
    counters[2] = 1
    handle, _ = _core.run_case(np.frombuffer(search().to_namelist().encode(), "S1"), 1, counters)
    result = from_core("find", handle)
    assert result.cut == "0 of 4 states and 0 sets of impact times were tried"


def test_an_event_limit_is_kept():
    found = search(max_events=100, max_impacts=0)
    assert found.unsettled == 4
    assert any("max_events" in text for text in found.failures)


def test_what_fails_says_so():
    ball = vi.Structure([1], [0], [0], [vi.Gap([-1], -0.1, 0.5)])
    with pytest.raises(vi.SingularError, match="closed at q = 0"):
        vi.find(ball, vi.Load(1.0, sine=[1]))
    with pytest.raises(vi.SingularError, match="the structure has none"):
        vi.find(ball, vi.Load(constant=[1]))


def test_permanent_rest_is_settled():
    """A ball on a table that barely shakes comes to rest permanently: all its states settle."""
    table = vi.Structure([1], [0.1], [0], [vi.Gap([-1], 1.0, 0.5)])
    load = vi.Load(1.0, sine=[0.1], constant=[-1.0])
    found = vi.find(table, load, states=4, max_impacts=1, max_cycles=1, guesses=4)
    assert (found.without_impacts, found.unsettled) == (4, 0)
    assert "4 states without further impacts" in repr(found)
    names = [item.name for item in vi.basins(table, load, states=4).attractors]
    assert names == ["permanent rest"]


def test_both_systems_have_one_class(tmp_path):
    """Files of earlier versions, with three classes and two studies, are read; missing attributes are named."""
    osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    of_osc = vi.find(osc, 0.94, 37.0, max_impacts=2, max_cycles=1, guesses=12, states=2)
    at_point = vi.find(osc.at(0.94, 37.0), max_impacts=2, max_cycles=1, guesses=12, states=2)
    assert at_point.to_json() == of_osc.to_json()
    for found, name, study in (
        (search(), "StructureMotions", "find_structure"), (search(), "FoundMotions", "find_structure"),
        (search(), "StructureMotions", ""), (of_osc, "Findings", ""),
    ):  # fmt: skip
        record = found.to_dict() | {"type": name, "study": study}
        if not study:
            del record["study"]
        (tmp_path / "old.json").write_text(json.dumps(record))
        read = vi.load(tmp_path / "old.json")
        assert read.to_json() == found.to_json()
        assert isinstance(read, vi.FoundMotions)
    assert of_osc.without_impacts == of_osc.search.without_impacts
    for found, name, there in (
        (of_osc, "settled", "search"), (of_osc, "failures", "search"), (of_osc, "structure", "osc"),
        (search(), "search", "unsettled"), (search(), "r", "unsettled"), (search(), "osc", "structure"),
    ):  # fmt: skip
        with pytest.raises(AttributeError, match=f"^{name}: a FoundMotions of an? .*{there}"):
            getattr(found, name)


def test_motions_of_two_systems_are_not_compared():
    motion = search(states=1)[0]
    other = vi.equispaced(vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75), 0.94, 37.0)[0]
    for one, two in ((motion, other), (other, motion)):
        with pytest.raises(
            vi.ParameterTypeError, match=r"^other = .* must be a motion of the same system"
        ):
            vi.same_motion(one, two)
    with pytest.raises(vi.ParameterError, match=r"^mirrored = True: must be False for motions"):
        vi.same_motion(motion, motion, mirrored=True)
