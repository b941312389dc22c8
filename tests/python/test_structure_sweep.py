"""Sweeps of structures along a parameter: closed forms, published points, separate simulations."""

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact import _core
from vibroimpact.base.interrupt import new_counters
from vibroimpact.results.tables import from_core

#: The impact oscillator of VIVID: one impact in two load cycles from F = 0.34753... on.
WALL, LOAD = vi.Structure([1], [0.04], [1], [vi.Gap([1], 1, 0.9)]), vi.Load(0.81, cosine=[1.0])


def damper(opening=0.5):
    gaps = [vi.Gap([-1, 1], opening, 0.8), vi.Gap([1, -1], opening, 0.8)]
    return vi.Structure([1.0, 0.1], [0.02, 0.0], [1.0, 0.0], gaps), vi.Load(1.1, sine=[0.1, 0])


@pytest.fixture(scope="module")
def diagram():
    return vi.bifurcation_diagram(WALL, LOAD, "load", np.linspace(0.349, 0.373, 5), settling=600)


def test_the_motion_of_two_cycles_exists_above_the_published_flip(diagram):
    """The motion of two cycles exists above the flip at F = 0.3475334 (tests/data/vivid.csv)."""
    assert set(diagram.labels.ravel()) == {"1/2"}
    below = vi.bifurcation_diagram(WALL, LOAD, "load", [0.345, 0.347], sweep="down", settling=600)
    assert "1/2" not in below.labels


def test_the_states_of_a_period_are_those_of_a_simulation(diagram):
    assert diagram.runs == ["up", "down"]
    for run, index in np.ndindex(diagram.labels.shape):
        states, hits = (
            table[(table["run"] == run) & (table["index"] == index)]
            for table in (diagram.strobes, diagram.points)
        )
        q, rate = states["q"], states["q_dot"]
        assert q.shape == rate.shape == (2, 1)
        load = vi.Load(0.81, cosine=[diagram.values[index]])
        alone = vi.simulate(WALL, load, cycles=2, state=(q[0], rate[0]))
        np.testing.assert_allclose(alone.final_state, [q[0], rate[0]], atol=1e-4)
        assert (hits["gap"] == 0).all()
        events = alone.events[alone.events["kind"] == "impact"]
        np.testing.assert_allclose(hits["speed"][-1], events["speed"], rtol=1e-3)
        wanted = np.mod(events["time"] * 0.81, 2 * np.pi)
        np.testing.assert_allclose(hits["phase"][-1], wanted, atol=1e-3)


def test_up_and_down_agree_where_one_motion_is_stable(diagram):
    np.testing.assert_allclose(diagram.values, np.linspace(0.349, 0.373, 5), rtol=1e-15)
    first, second = (
        [sorted(here["q"][here["index"] == i, 0]) for i in range(5)]
        for here in (diagram.strobes[diagram.strobes["run"] == run] for run in (0, 1))
    )
    np.testing.assert_allclose(first, second, atol=1e-5)


def test_hysteresis_ends_at_the_fold_of_the_branch():
    """In the sweep up impacts last to the fold; in the sweep down they begin again far below it."""
    wall = vi.Structure([1], [0.1], [1], [vi.Gap([1], 1, 0.8)])
    values = np.linspace(1.1, 1.5, 21)
    found = vi.response(wall, vi.Load(1.1, cosine=[0.3]), values)
    hits = {
        name: found.values[impacts > 0]
        for name, impacts in zip(found.runs, found.impacts.T, strict=True)
    }
    load = vi.Load(1.2, cosine=[0.3])
    run = vi.simulate(wall, load, cycles=100, state=([0.0], [1.0]))
    motion = vi.exact(wall, load, run)
    branch = vi.branch(motion, "frequency", bounds=(1.0, 1.6))
    (fold,) = (point.value for point in branch.special_points if point.type == "fold")
    assert hits["up"].max() < fold < hits["up"].max() + 0.02
    assert hits["down"].max() < hits["up"].max() - 0.1


def test_a_function_gives_the_same_as_a_name():
    structure, _ = damper()

    def at(factor):
        return structure, vi.Load(1.1, sine=[0.1 * factor, 0])

    values = np.linspace(1.0, 1.5, 4)
    one = vi.bifurcation_diagram(*at(1.0), "load", values)
    two = vi.bifurcation_diagram(*at(1.0), at, values)
    np.testing.assert_array_equal(one.labels, two.labels)
    for name in ("q", "q_dot"):
        np.testing.assert_allclose(one.strobes[name], two.strobes[name], atol=1e-8)
    again = two.to_namelist()
    assert "function" in again


def test_a_gap_that_becomes_smaller_pushes_the_state_back():
    structure, load = damper(2.0)
    values = np.linspace(0.05, 2.0, 8)
    found = vi.bifurcation_diagram(structure, load, "opening", values, sweep="down", settling=50)
    assert (found.status == 0).all()


def test_the_response_without_impacts_is_the_closed_form():
    structure = vi.Structure.from_modes([1.0, 2.5], [0.02, 0.05], np.eye(2), [vi.Gap([1, 1], 1e6)])
    load = vi.Load(1.0, sine=[0.2, 0.1], cosine=[0.0, 0.3])
    found = vi.response(structure, load, np.linspace(0.5, 3.0, 11), settling=4000, sweep="up")
    w = found.values
    for i, (omega, zeta) in enumerate(((1.0, 0.02), (2.5, 0.05))):
        force = abs(load.cosine[0, i] - 1j * load.sine[0, i])
        wanted = force / abs(omega**2 - w**2 + 2j * zeta * omega * w)
        np.testing.assert_allclose(found.steady_largest[i], wanted, rtol=1e-4)
        np.testing.assert_allclose(found.steady_rms[i], wanted / np.sqrt(2), rtol=1e-10)
        np.testing.assert_allclose(found.largest[i, :, 0], wanted, rtol=1e-4)
        np.testing.assert_allclose(found.rms[i, :, 0], wanted / np.sqrt(2), rtol=1e-9)
    assert set(found.labels.ravel()) == {"0/1"}


def test_a_constant_force_moves_the_steady_motion():
    structure = vi.Structure([1], [0.1], [4], [vi.Gap([1], 1e6)])
    load = vi.Load(1.0, cosine=[0.0], constant=[2.0])
    found = vi.response(structure, load, [1.0, 1.5], settling=600)
    np.testing.assert_allclose(found.steady_largest, 0.5, rtol=1e-12)
    np.testing.assert_allclose(found.rms, 0.5, rtol=1e-9)
    free = vi.Structure([1], [0.1], [0], [vi.Gap([1], 1e6)])  # it drifts: there is no steady motion
    assert np.isnan(vi.response(free, load, [1.0, 1.5], settling=10).steady_rms).all()


def test_sizes_are_those_of_a_sampled_period():
    structure, load = damper()
    found = vi.response(structure, load, [1.0, 1.1], sweep="up", settling=600)
    assert found.labels[1, 0] == "2/1"
    load = vi.Load(1.1, sine=[0.1, 0])
    motion = vi.exact(structure, load, vi.simulate(structure, load, cycles=800))
    t = motion.period * (np.arange(40_000) + 0.5) / 40_000
    q, _ = motion.sample(t)
    np.testing.assert_allclose(found.largest[:, 1, 0], abs(q).max(axis=1), rtol=1e-4)
    np.testing.assert_allclose(found.rms[:, 1, 0], np.sqrt((q**2).mean(axis=1)), rtol=1e-4)
    np.testing.assert_allclose(found.q_min[:, 1, 0], q.min(axis=1), rtol=1e-4)
    np.testing.assert_allclose(found.q_max[:, 1, 0], q.max(axis=1), rtol=1e-4)


def test_a_wall_limits_the_response():
    wall = vi.Structure([1], [0.1], [1], [vi.Gap([1], 1, 0.8)])
    found = vi.response(wall, vi.Load(1.0, cosine=[0.3]), np.linspace(0.6, 1.8, 13))
    assert (found.q_max <= 1 + 1e-12).all()
    steady = found.steady_largest[0]
    for hits, largest in zip(found.impacts.T > 0, found.largest[0].T, strict=True):
        assert (steady[~hits] < 1).all()
        agree = (steady < 0.99) & ~hits
        np.testing.assert_allclose(largest[agree], steady[agree], rtol=1e-3)


@pytest.mark.parametrize("extension", ["json", "nc", "mat"])
def test_files_and_namelists_give_them_back(extension, diagram, tmp_path):
    response = vi.response(*damper(), np.linspace(1.0, 1.2, 3), settling=20)
    for found in (diagram, response):
        path = tmp_path / f"found.{extension}"
        found.save(path)
        namelist = tmp_path / "case.nml"
        namelist.write_text(found.to_namelist())
        (case,) = vi.read_namelist(namelist)
        for again in (vi.load(path), case.run()[0]):
            assert repr(again) == repr(found)
            for name in ("values", "runs", "cycles", "impacts", "status"):
                np.testing.assert_array_equal(getattr(again, name), getattr(found, name))
            if found is diagram:
                np.testing.assert_array_equal(again.strobes, found.strobes)
            else:
                np.testing.assert_array_equal(again.rms, found.rms)


def test_pictures(diagram):
    pytest.importorskip("matplotlib")
    assert diagram.plot().get_xlabel() == "load factor"
    assert diagram.plot(quantity="speed").get_ylabel() == "approach speed"
    with pytest.raises(vi.ParameterError, match="quantity"):
        diagram.plot(quantity="q_1")
    response = vi.response(*damper(), [1.0, 1.2], settling=20)
    assert response.plot(coordinate=1).get_ylabel() == r"$\max|q_{1}|$"
    with pytest.raises(vi.ParameterError, match="coordinate"):
        response.plot(coordinate=2)
    own = vi.response(
        vi.Oscillator(xi=0.01, mu=0.03, restitution=0.8), [1.0], 25.0, states=1, settling=5, keep=3
    )
    with pytest.raises(vi.ParameterError, match="coordinate = 1: must be left out"):
        own.plot(coordinate=1)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"parameter": "weight"}, "parameter = 'weight': must be 'frequency'"),
        ({"parameter": "opening_3"}, "parameter = 'opening_3': must be"),
        ({"parameter": 3}, "parameter = 3: must be a name"),
        (
            {"parameter": "restitution", "values": [1.5, 0.5]},
            "max(values) = 1.5: must be a finite number; a coefficient",
        ),
        (
            {"parameter": "frequency", "values": [-1.0, 1.0]},
            "min(values) = -1.0: must be a finite number; a frequency must be above 0",
        ),
        ({"values": [1.0]}, "values of shape (1,): must be at least two different"),
        ({"values": [1.0, 1.0]}, "values of shape (2,): must be"),
        ({"values": [1.0, np.nan]}, "values of shape (2,): must be"),
        ({"values": [[1.0, 1.1]]}, "values of shape (1, 2): must be"),
        ({"sweep": "left"}, "sweep = 'left': must be 'up', 'down' or 'both'"),
        ({"keep": 2}, "keep = 2: must be a whole number with 3 <="),
        ({"state": ([0, 1], [0])}, "state = "),
        (
            {"state": ([1e200], [0])},
            "state = ([1e+200], [0]): must be two lists of 1 finite numbers from -1e100",
        ),
        (
            {"state": ([0], [-2e100])},
            "state = ([0], [-2e+100]): must be two lists of 1 finite numbers from",
        ),
        ({"load": vi.Load(constant=[1.0])}, "load = "),
    ],
)
def test_errors_name_the_parameter(change, message):
    arguments = {"load": LOAD, "parameter": "load", "values": [0.3, 0.4], **change}
    with pytest.raises((vi.ParameterError, vi.ParameterTypeError)) as caught:
        vi.bifurcation_diagram(WALL, **arguments)
    assert str(caught.value).startswith(message)


def test_values_have_any_spacing_and_order():
    """Each value of a list gives the result that it has alone; the sweep follows the order of the list."""
    given = [1.2, 0.9, 0.97, 1.1]
    found = vi.response(WALL, LOAD, given, sweep="up")
    assert found.values.tolist() == sorted(given)
    assert "list = " in found.to_namelist()
    # the same with the state passed from value to value in the test
    state = ([0.0], [0.0])
    for i, value in enumerate(sorted(given)):
        pair = vi.response(WALL, LOAD, [value, 2.0], sweep="up", state=state)
        strobes = vi.bifurcation_diagram(
            WALL, LOAD, "frequency", [value, 2.0], sweep="up", state=state
        ).strobes
        last = strobes[strobes["index"] == 0][-1]
        state = (last["q"], last["q_dot"])
        if found.cycles[i, 0] > 0:
            assert pair.largest[0, 0, 0] == pytest.approx(found.largest[0, i, 0], rel=1e-12)
    even = vi.response(WALL, LOAD, np.linspace(0.9, 1.1, 3))
    back = vi.response(WALL, LOAD, np.linspace(0.9, 1.1, 3)[::-1])
    assert np.array_equal(even.largest, back.largest)
    assert "list" not in even.to_namelist()
    diagram = vi.bifurcation_diagram(WALL, LOAD, "load", [0.45, 0.3, 0.31])
    assert diagram.values.tolist() == [0.3, 0.31, 0.45]


def test_a_list_of_a_namelist_is_checked(tmp_path):
    text = vi.response(WALL, LOAD, [0.9, 1.0, 1.2], sweep="up").to_namelist()
    line = next(item for item in text.split("\n") if "list = " in item)
    for value, fault in (
        ("1.0, 0.9, 1.1", "increasing or decreasing"), ("1.0", "two or more"), ("-1, 1", "list"),
        ("0.9, 1\n  low = 2", "low"),
    ):  # fmt: skip
        path = tmp_path / "list.nml"
        path.write_text(text.replace(line, f"  list = {value}"))
        with pytest.raises(vi.ParameterError, match=fault):
            vi.read_namelist(path)


def test_a_stop_keeps_what_was_reached(diagram):
    sizes = vi.response(WALL, LOAD, np.linspace(0.9, 1.1, 5))
    for result, study, count in (
        (diagram, "bifurcation", 10), (sizes, "response", 10),
    ):  # fmt: skip
        counters = new_counters()
        counters[2] = 1
        handle, _ = _core.run_case(np.frombuffer(result.to_namelist().encode(), "S1"), 1, counters)
        assert from_core(study, handle).cut == f"0 of {count} values were reached"
        assert counters[0] == 0  # no work was done


def shortened(found, rows):
    """The record of a sweep that was stopped after some rows."""
    data = found.to_dict()
    cells = data["tables"]["cells"]
    for name, values in cells["columns"].items():
        cells["columns"][name] = values[:rows]
    cells["dims"]["cell"] = rows
    for table in data["tables"].values():
        if "owners" in table:
            keep = sum(owner < rows for owner in table["owners"])
            (dim,) = table["dims"]
            table["dims"][dim], table["owners"] = keep, table["owners"][:keep]
            table["columns"] = {name: item[:keep] for name, item in table["columns"].items()}
    return data | {"cut": f"{rows} of 10 values were reached"}


def test_a_sweep_that_was_stopped_has_what_was_reached(diagram):
    """In the sweep down values that were not reached are marked; those that no run reached are left out."""
    part = vi.BifurcationDiagram.from_dict(shortened(diagram, 7))
    np.testing.assert_array_equal(part.values, diagram.values)
    down = [""] * 3 + ["1/2"] * 2
    assert part.labels.tolist() == [["1/2"] * 5, down]
    assert (part.status[1] == 12).tolist() == [not label for label in down]
    assert part.failures == {}
    size = part.strobes.size
    np.testing.assert_array_equal(part.strobes, diagram.strobes[:size])
    assert "up, down, 7 of 7 with a period; cut short" in repr(part)
    few = vi.BifurcationDiagram.from_dict(shortened(diagram, 3))
    assert (few.runs, few.values.tolist()) == (["up"], diagram.values[:3].tolist())
    sizes = vi.response(WALL, LOAD, np.linspace(0.9, 1.1, 5), settling=20)
    part = vi.Response.from_dict(shortened(sizes, 7))
    np.testing.assert_array_equal(part.largest[:, :, 0], sizes.largest[:, :, 0])
    np.testing.assert_array_equal(part.largest[:, 3:, 1], sizes.largest[:, 3:, 1])
    assert np.isnan(part.largest[:, :3, 1]).all()
    np.testing.assert_array_equal(part.steady_rms, sizes.steady_rms)


@pytest.mark.parametrize(
    ("name", "former"),
    [("BifurcationDiagram", "StructureBifurcation"), ("Response", "StructureResponse")],
)
def test_records_of_the_former_classes_are_read(name, former, diagram):
    """Earlier records had separate classes for structures, and did not name the study."""
    found = diagram
    if name == "Response":
        found = vi.response(WALL, LOAD, [0.9, 1.0], settling=20)
    data = found.to_dict() | {"type": former}
    del data["study"]
    again = getattr(vi, name).from_dict(data)
    assert type(again).__name__ == name
    assert again.to_dict() == found.to_dict()


def test_what_a_system_lacks_is_named(diagram):
    sizes = vi.response(WALL, LOAD, [0.9, 1.0], settling=20)
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    short = {"settling": 5, "keep": 3}
    own = vi.response(osc, [0.9, 1.0], 25.0, states=2, **short)
    sweep = vi.bifurcation_diagram(osc, "r", [0.9, 1.0], clearance=25.0, **short)
    for noun, name in (
        (diagram, "x_max"), (diagram, "symbols"), (diagram, "windows"), (diagram, "osc"),
        (sizes, "attenuation"), (sizes, "symbols"), (own, "largest"), (own, "steady_rms"),
        (own, "structure"), (sweep, "strobes"),
    ):  # fmt: skip
        with pytest.raises(AttributeError, match=rf"^{name}: a .* does not have it; it has "):
            getattr(noun, name)
    assert own.runs == ["state 1", "state 2"]
    np.testing.assert_array_equal(own.values, own.r)
    np.testing.assert_array_equal(own.labels != "", own.cycles > 0)


def test_a_point_stands_for_the_oscillator():
    osc, short = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75), {"settling": 5, "keep": 3}
    point = osc.at(1.04, 25.0, load=1.1)
    for one, two in (
        (vi.response(point, [0.9, 1.0], states=2, **short),
         vi.response(osc, [0.9, 1.0], 25.0, states=2, load=1.1, **short)),
        (vi.bifurcation_diagram(point, "clearance", [20, 30], **short),
         vi.bifurcation_diagram(osc, "clearance", [20, 30], r=1.04, load=1.1, **short)),
        (vi.bifurcation_diagram(point, "mu", [0.02, 0.03], sweep="up", **short),
         vi.bifurcation_diagram(osc, "mu", [0.02, 0.03], 1.04, 25.0, "up", load=1.1, **short)),
    ):  # fmt: skip
        assert one.to_dict() == two.to_dict()


def test_an_event_limit_is_a_status():
    found = vi.bifurcation_diagram(WALL, LOAD, "load", [0.36, 0.37], max_events=5)
    assert (found.status != 0).all()
    assert list(found.failures) == [vi.status_text(13)]


@pytest.mark.parametrize("state", [([0.0], [1e60]), ([1e60], [0.0]), ([-1e41], [0.0])])
def test_a_start_of_extreme_size_is_a_status(state):
    """Every value starts anew after a failure, and says that the units of the start are extreme, as a simulation
    does: a start beyond a wall is not moved into the gap from there."""
    found = vi.bifurcation_diagram(WALL, LOAD, "load", [0.36, 0.37], state=state)
    assert list(found.failures) == [vi.status_text(23)]
    assert set(found.labels.ravel()) == {""}
    with pytest.raises(vi.SingularError, match=vi.status_text(23)):
        vi.simulate(WALL, LOAD, cycles=1, state=state)


@pytest.mark.parametrize("key", ["q", "q_dot"])
@pytest.mark.parametrize(
    "group", ["bifurcation", "response", "simulate", "lyapunov", "basins", "motion"]
)
def test_namelists_refuse_states_beyond_their_range(group, key, tmp_path):
    """Each number of a start is at most 1e100 in size, in the groups of all studies."""
    rest = {
        "bifurcation": "parameter = 'load', low = 0.3, high = 0.4, values = 2",
        "response": "low = 0.8, high = 0.9, values = 2", "simulate": "cycles = 1", "lyapunov": "cycles = 40",
        "basins": "axes = 'q_0' 'q_dot_0', low = 0 0, high = 1 1, values = 2 2", "motion": "kind = 'settled'",
    }  # fmt: skip
    path = tmp_path / "far.nml"
    structure = (
        "&structure mass = 1, damping = 0.04, stiffness = 1 /\n&gap direction = 1, opening = 1 /\n"
    )
    path.write_text(
        f"{structure}&load frequency = 0.81, cosine = 1 /\n&{group} {rest[group]}, {key} = -1.1e100 /\n"
    )
    with pytest.raises(vi.ParameterError) as caught:
        vi.read_namelist(path)
    assert f"{key} = -1.1e100: must be one number from -1e100 to 1e100 for each coordinate" in str(
        caught.value
    )


def test_an_event_limit_after_settling_leaves_no_values():
    """A value whose motion is only partly examined has neither states nor a number of impacts."""
    found = vi.bifurcation_diagram(WALL, LOAD, "load", [0.36, 0.37], settling=2, max_events=10)
    assert list(found.failures) == [vi.status_text(13)]
    assert not found.impacts.any()
    assert not found.strobes.size


def test_the_shortest_period_counts():
    """With a pair of multipliers .975 exp(2 pi i .283) a slowly settling run repeats itself after 7 cycles."""
    gaps = [vi.Gap([-1, 1], 0.5, 0.8), vi.Gap([1, -1], 0.5, 0.8)]
    host = vi.Structure([1.0, 0.1], [0.02, 0.0], [1.0, 0.0], gaps)
    for frequency in np.linspace(1.15, 1.35, 9):
        load = vi.Load(frequency, sine=[0.1, 0])
        for settling in (60, 120, 200):
            curve = vi.response(
                host, load, [frequency, 1.01 * frequency], sweep="up", settling=settling
            )
            if not curve.cycles[0, 0]:
                continue
            wanted = vi.exact(host, load, vi.simulate(host, load, cycles=4000))
            assert curve.cycles[0, 0] == wanted.cycles
            assert curve.labels[0, 0] == f"{len(wanted.gaps)}/{wanted.cycles}"


def test_a_run_that_has_not_settled_has_no_label():
    """Near a motion that is left slowly, or approached slowly from far away, no stable motion is confirmed."""
    unstable = vi.exact(WALL, vi.Load(0.81, cosine=[0.3476]), ([0.07], [0]))
    assert unstable.cycles == 1
    assert unstable.stable is False
    diagram = vi.bifurcation_diagram(
        WALL, LOAD, "load", [0.3476, 0.36], sweep="up", settling=2,
        state=state_at_phase_0(unstable),
    )  # fmt: skip
    assert diagram.labels[0, 0] == ""


def state_at_phase_0(motion):
    """Coordinates and velocities of a motion at load phase 0."""
    q, rate = motion.sample(np.array([0.0]))
    return q[:, 0], rate[:, 0]
