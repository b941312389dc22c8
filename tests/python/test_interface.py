"""The interactive interface: names for completion, patterns as text, arguments by name, representations."""

import copy
import inspect
import math
import pickle
import re
from types import ModuleType
from xml.etree import ElementTree

import numpy as np
import pytest
import vibroimpact as vi
from shared_systems import FIGURE6

TABLE = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
FUNCTIONS = [
    value for name in vi.__all__ if inspect.isfunction(value := getattr(vi, name))
    and inspect.signature(value).parameters
]  # fmt: skip


def test_dir_shows_the_public_names_alone():
    """`dir` shows the public names; the only module is `errors`, whose errors are public names too."""
    assert set(dir(vi)) == {*vi.__all__, "__version__"}
    modules = {name for name in dir(vi) if isinstance(getattr(vi, name), ModuleType)}
    assert modules == {"errors"}
    for name in vi.errors.__all__:
        assert getattr(vi, name) is getattr(vi.errors, name)
    assert len(vi.__all__) == len(set(vi.__all__))


@pytest.mark.parametrize("function", FUNCTIONS, ids=lambda function: function.__name__)
def test_docstrings_say_what_is_raised(function):
    """The docstring of each public function with arguments names an error of the package under Raises."""
    text = inspect.getdoc(function)
    raised = re.search(r"^Raises\n-+\n((?:.+\n|\n(?=    ))+)", text, re.MULTILINE)
    assert raised, text
    assert re.search(r"Parameter(Type)?Error", raised[1])


# -- the oscillator


def test_an_oscillator_needs_names():
    """Arguments must be named, because in a different order they would be a valid but different oscillator."""
    with pytest.raises(vi.ParameterTypeError, match="names") as caught:
        vi.Oscillator(0.75, 0.0114, 0.028)
    assert str(caught.value).startswith("Oscillator(0.75, 0.0114, 0.028): must have the names")
    assert "Oscillator(xi=0.0114, mu=0.028, restitution=0.75)" in str(caught.value)
    with pytest.raises(vi.ParameterTypeError, match="names"):
        vi.Oscillator(0.01, mu=0.028, restitution=0.75)
    with pytest.raises(vi.ParameterTypeError, match=r"from_dimensional\(M="):
        vi.Oscillator.from_dimensional(2.0, 800.0, 0.4, 0.08, 0.75)
    assert list(inspect.signature(vi.Oscillator).parameters) == [
        "xi", "mu", "restitution", "M", "K", "F0", "unit_names",
    ]  # fmt: skip
    rig = vi.Oscillator.from_dimensional(M=2.0, K=800.0, C=0.4, m=0.08, restitution=0.75)
    for again in (pickle.loads(pickle.dumps(rig)), copy.deepcopy(rig), copy.copy(rig)):
        assert (again, again.M, again.K) == (rig, 2.0, 800.0)


# -- patterns


def test_a_pattern_is_also_a_text():
    """Wherever a pattern is taken, "RL/2" gives the same as Pattern("RL", 2)."""
    second = np.linspace(1.2, 1.5, 5) * math.pi
    phases = [np.zeros(5), second]
    r, clearance = np.array([0.9, 0.95]), np.array([20.0, 40.0])
    window = {"r": (0.93, 0.95), "clearance": (36.0, 38.0), "lines": 5, "guesses": 1}
    calls = {
        "periodic": lambda p: vi.periodic(TABLE, 0.94, [0, 4.0], p).X.tolist(),
        "periodic_batch": lambda p: vi.periodic_batch(TABLE, 0.94, phases, p).X.tolist(),
        "linear_system": lambda p: vi.linear_system(TABLE, 0.94, [0, 4.0], p)[0].tolist(),
        "stability_flags": lambda p: vi.stability_flags(TABLE, 0.94, phases, p).stable.tolist(),
        "exact": lambda p: vi.exact(TABLE, 0.94, 37.0, ([0, 4.3], p)).X.tolist(),
        "chart": lambda p: repr(vi.chart(TABLE, p, r, clearance)),
        "zone": lambda p: repr(vi.zone(TABLE, p, **window)),
        "prove_box": lambda p: vi.prove_box(TABLE, p, 0.94, 37.0).sheets,
        "uncertainty": lambda p: repr(
            vi.uncertainty(TABLE, p, r, clearance, {}, samples=1, bands=False)
        ),
    }
    takes = {
        name for name in vi.__all__ if inspect.isfunction(function := getattr(vi, name))
        and {"pattern", "guess"} & set(inspect.signature(function).parameters)
    }  # fmt: skip
    # a guess for a structure has the numbers of its gaps
    assert takes - {"exact_structure"} == set(calls)
    for name, call in calls.items():
        assert call("RL") == call(vi.Pattern("RL")) == call("RL/1"), name
    two = vi.periodic(TABLE, 0.94, [0, 7.0], "rl/2")
    assert two.pattern == vi.Pattern("RL", 2)
    for name, call in calls.items():
        if name == "exact":
            continue
        for wrong in (
            "RL/x",
            "RL/0",
            "RL/",
            "",
            "RX",
            "RL/" + "1" * 5000,
            "RL/²",
            7,
            None,
            ("RL", 1),
        ):
            with pytest.raises(
                (vi.ParameterError, vi.ParameterTypeError), match=r"^pattern"
            ) as caught:
                call(wrong)
            assert len(str(caught.value)) < 400, name


# -- representations


def cells(thing):
    """The rows of a table as Jupyter shows it."""
    return [
        [cell.text for cell in row]
        for row in ElementTree.fromstring(thing._repr_html_()).iter("tr")
    ]


def test_jupyter_shows_oscillator_units_and_what_find_gives():
    """Oscillators, units and the list of `find` are tables of their numbers."""
    rig = vi.Oscillator.from_dimensional(M=2.0, K=800.0, C=0.4, m=0.08, restitution=(0.75, 0.61))
    shown = dict(cells(rig))
    assert [float(shown[name]) for name in ("xi", "mu", "M", "K")] == [rig.xi, rig.mu, 2.0, 800.0]
    assert (shown["R1 (right wall)"], shown["R2 (left wall)"]) == ("0.75", "0.61")
    units = rig.units(F0=4.0)
    assert {name: float(value) for name, value in cells(units)} == {
        "omega": 20.0, "length": 0.005, "time": 0.05, "velocity": 0.1, "acceleration": 2.0, "force": 4.0,
    }  # fmt: skip
    found = vi.find(TABLE, 0.94, 37.0, 2, 1)
    head, *rows = cells(found)
    assert head[1:3] == ["pattern", "stable"]
    assert [row[1] for row in rows] == [f"{m.pattern.sides}/{m.pattern.cycles}" for m in found]
    assert [row[2] == "yes" for row in rows] == [m.stable for m in found]
    assert [float(row[3]) for row in rows] == [
        pytest.approx(max(abs(m.multipliers)), rel=1e-3) for m in found
    ]
    assert str(found.search) in found._repr_html_()


def test_jupyter_shows_a_point():
    point = TABLE.at(0.94, 37.0, 2.0)
    shown = dict(cells(point))
    assert [float(shown[name]) for name in ("r", "d K/F0", "load over F0")] == [0.94, 37.0, 2.0]
    assert "Oscillator" in point._repr_html_()


def test_what_find_gives_is_a_line():
    """The representation gives the number of motions; the motions are its items."""
    found = vi.find(TABLE, 0.94, 37.0, 2, 1)
    assert repr(found) == (
        "<FoundMotions at r = 0.94, d K/F0 = 37: 5 motions, 3 of them stable; "
        "and the motion without impacts, since D > 2A>"
    )
    # below twice the amplitude without impacts the walls always reach the free mass
    assert repr(vi.find(TABLE, 0.94, 10.0, 2, 1)).endswith("of them stable>")
    assert repr(vi.find(TABLE, 0.94, 1e6, 2, 1)) == (
        "<FoundMotions at r = 0.94, d K/F0 = 1e+06: 0 motions, 0 of them stable; "
        "and the motion without impacts, since D > 2A>"
    )


def test_a_final_state_is_short():
    """The 28 numbers of `since` are not printed; they still exist, and continue the run with the same bits."""
    run = vi.simulate(FIGURE6, 1.04, 25.0, 3.5, {"t": 0, "x": 0, "x_dot": 0, "z": 0, "z_dot": 5.0})
    state = run.final_state
    assert (
        repr(state["since"]) == f"<{len(state['since'])} numbers: where the flight or rest began>"
    )
    assert len(repr(state)) < 400
    again = pickle.loads(pickle.dumps(state))
    assert again == state
    whole = vi.simulate(FIGURE6, 1.04, 25.0, 2, state).events.tolist()
    assert vi.simulate(FIGURE6, 1.04, 25.0, 2, again).events.tolist() == whole
    assert vi.Trajectory.from_json(run.to_json()).final_state == state


# -- units


def test_units_take_arrays():
    """Conversions take arrays, element by element; numbers that are not positive are refused by name."""
    units = vi.Oscillator.from_dimensional(M=2.0, K=800.0, C=0.4, m=0.08, restitution=0.75).units(
        4.0
    )
    for name, method, unit in (
        ("d", units.clearance, units.length),
        ("Omega", lambda value: units.frequency_ratio(Omega=value), units.omega),
    ):
        values = np.array([[1.0, 2.0], [3.0, 0.5]])
        found = method(values)
        assert found.tolist() == [[method(v) for v in row] for row in values.tolist()]
        assert found.tolist() == (values / unit).tolist()
        assert method([1, 2]).tolist() == [method(1.0), method(2.0)]
        assert isinstance(method(3), float)
        for wrong in ([1.0, 0.0], [1.0, math.nan], [1.0, -2.0], [math.inf]):
            with pytest.raises(vi.ParameterError, match=rf"^{name} with .* must be finite numbers"):
                method(wrong)
        for wrong in (["a"], "a", [True], [1j]):
            with pytest.raises(vi.ParameterTypeError, match=rf"^{name}"):
                method(wrong)
    for given in ({}, {"f": 1.0, "Omega": 1.0}, {"frequency": "1 Hz", "f": 1.0}):
        with pytest.raises(vi.ParameterError, match="must be one of frequency, Omega and f"):
            units.frequency_ratio(**given)


# -- a run without impacts


def test_exact_says_that_there_were_no_impacts():
    """Without impacts the error gives the amplitude, half the clearance, and what to change."""
    r, clearance = 1.3, 25.0
    A = 1 / math.hypot(1 - r * r, 2 * FIGURE6.xi * r)
    assert clearance > 2 * A
    run = vi.simulate(FIGURE6, r, clearance, 40, discard=300)
    for call in (lambda: vi.exact(FIGURE6, r, clearance, run), run.period):
        with pytest.raises(vi.ParameterError, match="no impact happened in it") as caught:
            call()
        assert f"A = {A:.6g}, below D/2 = 12.5" in str(caught.value)
        assert "another state" in str(caught.value)
        assert "do not repeat" not in str(caught.value)
    # nearer to resonance the walls are reached later
    early = vi.simulate(FIGURE6, 1.02, clearance, 0.1)
    with pytest.raises(vi.ParameterError, match=r"above D/2 = 12\.5: simulate longer"):
        vi.exact(FIGURE6, 1.02, clearance, early)
    # if the impacts end, the error gives the time of the last one
    slow = vi.simulate(
        FIGURE6, r, clearance, 2000, {"t": 0, "x": 0, "x_dot": 0, "z": 0, "z_dot": 9.0}
    )
    assert len(slow.events)
    if slow.events["time"][-1] < slow.final_state["t"] - 49 * 2 * math.pi / r:
        with pytest.raises(vi.ParameterError, match="no impact happened since t ="):
            slow.period()


@pytest.mark.parametrize("r", [0.3, 0.9, 0.99, 1.0, 1.01, 1.4, 3.0])
def test_from_all_zero_a_wall_is_reached_where_the_amplitude_says_so(r):
    """From rest a wall is reached if A > D/2, and is not reached if D/2 exceeds the bound on the transient."""
    osc = vi.Oscillator(xi=0.05, mu=0.1, restitution=0.5)
    A = 1 / math.hypot(1 - r * r, 2 * osc.xi * r)
    assert len(vi.simulate(osc, r, 2 * A * 0.999, 400).events)
    # the transient, which cancels A sin(r t - phi) and its velocity at t = 0, adds at most this
    most = A * (1 + math.sqrt((max(1, r * r) + osc.xi * r) / (1 - osc.xi**2)))
    assert not len(vi.simulate(osc, r, 2 * most * 1.001, 400).events)


@pytest.mark.parametrize("call", [
    lambda thing: vi.is_symmetric(thing), lambda thing: vi.motion_images(thing),
    lambda thing: vi.standard_motion(thing), lambda thing: vi.same_motion(thing, thing),
    lambda thing: vi.run_namelists(thing)])  # fmt: skip
@pytest.mark.parametrize("thing", [None, 7, "RL", TABLE])
def test_what_is_no_motion_and_no_list_is_named(call, thing):
    """An argument that is neither a motion nor a list of them raises an error of the package that names it."""
    with pytest.raises(vi.ParameterTypeError, match=r"^(motion|one|paths) = "):
        call(thing)


def test_results_that_are_sequences_take_slices():
    """Results are indexed like lists, with negative indices and slices; other indices are refused."""
    motion = vi.equispaced(TABLE, 0.94, 37.0)[0]
    line = vi.branch(motion, "clearance", bounds=(36.0, 37.0))
    batch = vi.periodic_batch(TABLE, 0.94, [np.zeros(5), np.linspace(4.1, 4.5, 5)], "RL")
    for items in (line, batch):
        every = [items[i] for i in range(len(items))]
        shown = list(map(repr, every))
        assert list(map(repr, items)) == shown
        for part in (
            slice(0, 3),
            slice(None),
            slice(None, None, -2),
            slice(-2, None),
            slice(3, 3),
            slice(2, 10**9),
        ):
            assert list(map(repr, items[part])) == shown[part]
        assert repr(items[np.int64(-1)]) == shown[-1]
        for beyond in (len(items), -len(items) - 1, 10**30):
            with pytest.raises(IndexError, match=rf"{beyond} of {len(items)}$"):
                items[beyond]
        for wrong in (
            "a",
            None,
            1.5,
            (0, 1),
            [0, 1],
            np.array([True]),
            True,
            slice("a"),
            slice(None, None, 0),
        ):
            with pytest.raises(vi.ParameterTypeError, match=r"^index = "):
                items[wrong]


OSC = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
LAW = vi.Oscillator(xi=0.005, mu=0.042, restitution=vi.PowerLaw(0.75, speed=20, exponent=0.25))
WALL = vi.Structure([1], [0.1], [1], [vi.Gap([1], 1, 0.8)])
GUESS = ([0, 4.3], "RL")
ROUGH = OSC.at(0.94, 37.0, friction=0.1)


def test_a_point_stands_for_its_arguments():
    """Each verb that looks at one point uses its load; the structure and load of the point move alike."""
    point = OSC.at(0.94, 37.0, 2.0)
    place, state = (OSC, 0.94, 37.0), {"x_dot": 60.0}
    few = {"cycles": 8, "batches": 2, "discard": 5, "state": state}
    for ours, theirs in (
        (vi.simulate(point, 5, state), vi.simulate(*place, 5, state, 2.0)),
        (vi.exact(point, GUESS), vi.exact(*place, GUESS, 2.0)),
        (vi.lyapunov(point, **few), vi.lyapunov(*place, load=2.0, **few)),
        (vi.basins(point, states=2, rng=1), vi.basins(*place, states=2, rng=1, load=2.0)),
        (vi.response(point, [0.93, 0.94], states=2), vi.response(OSC, [0.93, 0.94], 37.0, states=2, load=2.0)),
    ):  # fmt: skip
        assert ours.to_dict() == theirs.to_dict()
    run = vi.simulate(point, 5, state)
    moved = vi.simulate(point.structure, point.load, cycles=5, state=([0, 0], [60.0, 0]))
    np.testing.assert_allclose(moved.events["time"], run.events["time"], rtol=1e-9)
    motion = vi.exact(point, GUESS)
    same = vi.exact(point.structure, point.load, (motion.phases, [0, 1]))
    np.testing.assert_allclose(same.q, [motion.X[0], motion.Z[0]], rtol=1e-9)
    assert same.phases == pytest.approx(motion.phases, abs=1e-12)
    rig = vi.Oscillator(xi=0.0114, mu=0.04, restitution=0.7, M=2.7, K=42e3, F0=6.0)
    scales = rig.at(1.04, 25.0).scales
    assert scales["length"] == pytest.approx(6.0 / 42e3)
    assert scales["time"] == pytest.approx((2.7 / 42e3) ** 0.5)


@pytest.mark.parametrize(("sides", "cycles", "phases"), [
    ("RL", 1, [0.0, 4.3]), ("LR", 1, [0.0, 2.0]), ("RRL", 2, [0.0, 2.01848, 6.07922]),
])  # fmt: skip
def test_columns_of_every_system(sides, cycles, phases):
    """A motion of an oscillator has the columns of its structure, and conserves momentum at each impact."""
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))
    point = osc.at(0.85, 20.0)
    motion = vi.exact(point, (phases, vi.Pattern(sides, cycles)))
    same = vi.exact(point.structure, point.load, (motion.phases, motion.gaps, motion.cycles))
    for name in (
        "gaps",
        "phases",
        "speeds",
        "impulses",
        "states",
        "cycles",
        "period",
        "q",
        "q_dot",
    ):
        ours, theirs = np.asarray(getattr(motion, name)), np.asarray(getattr(same, name))
        assert ours.shape == theirs.shape, name
        assert ours == pytest.approx(theirs, rel=1e-10, abs=1e-10), name
    directions = np.array([gap.direction for gap in point.structure.gaps])[motion.gaps]
    before = motion.states[:, 1] + motion.impulses[:, None] * directions / [1, osc.mu]
    assert before[:, 0] == pytest.approx(motion.X_dot_before, rel=1e-12)
    assert before[:, 1] == pytest.approx(motion.Z_dot_before, rel=1e-12)
    assert [motion.load_phase % (2 * np.pi), *np.diff(motion.phases)] == pytest.approx(
        [motion.phases[0], *np.diff(motion.alpha)], abs=1e-13
    )
    again = vi.periodic(osc, 0.85, motion.phases, motion.pattern)
    assert again.X == pytest.approx(motion.X, rel=1e-9)
    times = np.linspace(0.1, motion.period - 0.1, 7)  # not at an impact
    start = motion.phases[0] / 0.85
    assert motion.acceleration(times) == pytest.approx(same.acceleration(start + times), abs=1e-9)
    assert vi.is_symmetric(motion) is vi.is_symmetric(same) is False


def test_trajectories_of_every_system():
    """Trajectories of both systems agree in states, ends and windows."""
    point = OSC.at(0.94, 37.0)
    run = vi.simulate(point, 8, {"x_dot": 60.0})
    same = vi.simulate(point.structure, point.load, cycles=8, state=([0, 0], [60.0, 0]))
    assert (run.start, run.end) == (same.start, pytest.approx(same.end, rel=1e-14))
    assert run.states == pytest.approx(same.states, rel=1e-9, abs=1e-9)
    assert run.acceleration([1.0, 2.0]) == pytest.approx(same.acceleration([1.0, 2.0]), abs=1e-9)
    turn = 2 * np.pi / 0.94
    for options in ({"cycles": 2}, {"window": (turn, 3 * turn)}, {}):
        ours, theirs = run.quantities(**options), same.quantities(**options)
        assert ours.work == pytest.approx(theirs.work, rel=1e-9)
        assert ours.x.rms == pytest.approx(theirs.q.rms[0], rel=1e-9)
        balance = ours.work - ours.damping_loss - ours.impact_loss - ours.energy_change
        assert abs(balance) < 1e-10 * abs(ours.work)
    for item in (run, same):
        for options in ({"cycles": 9}, {"window": (3, 2)}, {"cycles": 1, "window": (1, 2)}):
            with pytest.raises(vi.ParameterError, match=rf"^{list(options)[-1]} = "):
                item.quantities(**options)
        for kind in ("history", None):
            assert item.plot(kind=kind, cycles=2) is not None
            assert item.plot(kind=kind, window=(1.0, 9.0)) is not None
    assert run.plot(kind="history", window=(1.0, 9.0)).get_xlim() == pytest.approx((0.0, 8 / turn))


@pytest.mark.parametrize(("name", "instead"), [
    ("X", "states"), ("Z_dot_before", "states and impulses"), ("pattern", "gaps and cycles"), ("tau", "phases"),
    ("attenuation", "quantities"), ("events", "gaps"), ("impact_maps", "matrix"), ("osc", "structure"),
    ("load_phase", "phases"),
])  # fmt: skip
def test_a_motion_tells_what_its_system_has(name, instead):
    """An attribute that only motions of an oscillator have gives an error that names that of a structure."""
    point = OSC.at(0.94, 37.0)
    motion = vi.exact(point, GUESS)
    same = vi.exact(point.structure, point.load, motion_guess(motion))
    assert hasattr(motion, name)
    with pytest.raises(
        AttributeError, match=f"^{name}: a Motion of a Structure .* it has {instead}"
    ):
        value_of(same, name)
    for name, instead in (
        ("structure", "osc"),
        ("rests", "rest_events"),
        ("matrix", "stability_matrix"),
    ):
        with pytest.raises(
            AttributeError, match=f"^{name}: a Motion of an Oscillator .* it has {instead}"
        ):
            getattr(motion, name)
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        motion.nonsense  # noqa: B018


def value_of(motion, name):
    value = getattr(motion, name)
    return value() if callable(value) else value


def motion_guess(motion):
    return motion.phases, motion.gaps, motion.cycles


def test_guesses_of_an_oscillator_with_a_law():
    """A guess may be phases with a pattern, phases with gaps, or a motion for constant restitution."""
    motion = vi.exact(OSC, 0.94, 37.0, GUESS)
    point = LAW.at(0.94, 37.0)
    found = [
        vi.exact(point, guess)
        for guess in (
            motion,
            (motion.phases, motion.pattern),
            (motion.phases, "RL"),
            motion_guess(motion),
        )
    ]
    assert len({repr(one) for one in found}) == 1
    assert all(vi.same_motion(found[0], one) for one in found)


@pytest.mark.parametrize(("call", "message"), [
    (lambda point: vi.exact(OSC, 0.94, 37.0, of_wall()), "guess = .*: must be for an oscillator"),
    (lambda point: vi.exact(WALL, vi.Load(1, cosine=[1]), vi.exact(point, GUESS)), "must be for a structure"),
    (lambda point: vi.standard_motion(of_wall()), "motion = .*: must be a motion of an oscillator"),
    (lambda point: vi.simulate(point, 3).gradient(["r"]), "parameters = .*: must be left out for an oscillator"),
    (lambda point: vi.exact(point, GUESS).plot(window=(0, 1)), "window = .*: must be left out"),
])  # fmt: skip
def test_solutions_of_the_other_system_are_refused(call, message):
    with pytest.raises((vi.ParameterError, vi.ParameterTypeError), match=message):
        call(OSC.at(0.94, 37.0))


def of_wall():
    return vi.exact(WALL, vi.Load(1.0, cosine=[1]), ([0.1], [0]))


@pytest.mark.parametrize(("call", "message"), [
    (lambda point: vi.exact(point, GUESS, 2.0), "exact.*2 arguments given by position; these are guess"),
    (lambda point: vi.lyapunov(point, 0.94, cycles=40), "cycles is given twice, 0.94 and 40"),
    (lambda point: vi.find(point, r=0.9), "r = 0.9: must be left out; <Oscillator"),
    (lambda point: vi.response(point, [0.9, 1.1], inverse_clearance=0.1), "inverse_clearance = 0.1: must be left"),
    (lambda point: vi.find(OSC, 0.94, 37.0, load=point), "load = <.*>: must not be a point"),
    (lambda point: vi.periodic(point, *GUESS), "must not be a point; the clearance is a result"),
    (lambda point: vi.zone(point, "RL", (0.8, 1.2), (2, 200)), "must not be a point; give its osc"),
    (lambda point: vi.branch(point, "clearance", (10, 60)), "must not be a point; give a motion there"),
    (lambda point: vi.stability_flags(point, [[0.0], [3.0]], "RL"), "must not be a point; give its osc"),
    (lambda point: vi.zone(ROUGH, "RL", (0.8, 1.2), (2, 200)), "must not be a point; give a motion there"),
    (lambda point: vi.chart(ROUGH, "RL", [1.0], [25.0]), "must not be a point; give a motion there"),
    (lambda point: vi.atlas(ROUGH, (0.9, 1.1), (10, 50)), "must not be a point; give its structure and load"),
    (lambda point: vi.periodic(ROUGH, *GUESS), "must not be a point; give its structure and load"),
    (lambda point: vi.equispaced(OSC.at(0.94, 37.0, friction=0.1)), "must have rigid walls, no friction"),
    (lambda point: vi.equispaced(point, r=2.0), "r = 2.0: must be left out"),
    (lambda point: vi.simulate(LAW, 0.94, r=0.5, clearance=37.0, cycles=1), "r is given twice"),
    (lambda point: vi.exact(LAW, 0.94, 37.0, GUESS, 1.0, 9), "6 arguments given by position"),
    (lambda point: vi.lyapunov(LAW), "lyapunov.*missing a required argument: 'r'"),
    (lambda point: vi.lyapunov(LAW.at(0.94, 37.0), state={}, start=3.0), "start = 3.0: must be left out"),
    (lambda point: vi.basins(WALL, states=2), "basins.*missing.*'load'; for a structure the arguments are"),
    (lambda point: vi.bifurcation_diagram(WALL, vi.Load(1, sine=[1]), lambda v: 3, [0, 1]), "must be .Structure,"),
])  # fmt: skip
def test_arguments_of_systems_are_neither_dropped_nor_given_twice(call, message):
    """Arguments of a point, a structure, and an oscillator with a law of restitution cannot be given twice."""
    with pytest.raises((TypeError, vi.ParameterError), match=message):
        call(OSC.at(0.94, 37.0))


#: Small calls of every verb that takes a point: (arguments after the point, options).
OF_POINTS = {
    "equispaced": ((), {}),
    "equispaced_batch": ((), {}),
    "exact": ((GUESS,), {}),
    "find": ((), {"max_impacts": 2, "max_cycles": 1, "guesses": 8, "states": 2, "settling": 50}),
    "simulate": ((3,), {}),
    "simulate_bundle": ((3,), {}),
    "lyapunov": ((), {"cycles": 8, "discard": 5, "batches": 2, "state": {"x_dot": 60.0}}),
    "bifurcation_diagram": (("clearance", [36.0, 37.0]), {"sweep": "up", "settling": 5, "keep": 5}),
    "response": (([0.94, 0.95],), {"states": 2, "settling": 5, "keep": 5}),
    "basins": ((), {"states": 3, "cycles": 20}),
    "uncertainty": (("RL", {}), {"samples": 1, "bands": False}),
    "limit_probability": (({}, {"displacement": 60.0}), {"samples": 2, "settling": 8}),
    "prove_box": (("RL",), {}),
    "prove_all": ((), {"max_impacts": 2}),
}


def test_every_form_for_points_runs():
    """Each verb whose help shows a point runs with it, as with its oscillator and with r and clearance by name."""
    shown = {name for name in VERBS if f"``{name}(point" in getattr(vi, name).__doc__}
    assert shown == {*OF_POINTS}
    for name, (args, options) in OF_POINTS.items():
        verb = getattr(vi, name)
        if name.startswith("prove"):
            pytest.importorskip("flint")
        given = {"r": 0.94, "clearance": 37.0}
        if name in ("bifurcation_diagram", "response"):
            del given["clearance" if name == "bifurcation_diagram" else "r"]
        names = [key for key in inspect.signature(verb).parameters if key not in ("osc", *given)]
        found = verb(OSC.at(0.94, 37.0), *args, **options)
        wanted = verb(OSC, **given, **dict(zip(names, args, strict=False)), **options)
        assert repr(found) == repr(wanted), name


def test_verbs_of_oscillators_alone_take_points_too():
    point, states = OSC.at(0.94, 37.0), np.zeros((5, 2))
    found, wanted = vi.equispaced(point), vi.equispaced(OSC, 0.94, 37.0)
    assert [motion.to_json() for motion in found] == [motion.to_json() for motion in wanted]
    one, two = (vi.simulate_bundle(*system, 20, states) for system in ((point,), (OSC, 0.94, 37.0)))
    np.testing.assert_array_equal(one.z, two.z)


def test_records_with_the_case_of_another_system():
    """A record of an oscillator with the case of a structure is refused."""
    few = {"cycles": 8, "batches": 2, "discard": 5}
    ours = vi.lyapunov(OSC, 0.94, 37.0, state={"x_dot": 60.0}, **few)
    theirs = vi.lyapunov(WALL, vi.Load(1.0, cosine=[1]), **few)
    with pytest.raises(
        vi.ParameterError, match=r"points.* must be left out; the case is that of a structure"
    ):
        vi.Lyapunov.from_dict(ours.to_dict() | {"case": theirs.case})
    with pytest.raises(
        vi.ParameterError, match=r"exponents.* must be left out; the case is that of an oscillator"
    ):
        vi.Lyapunov.from_dict(theirs.to_dict() | {"case": ours.case})


@pytest.mark.parametrize(
    "name", ["simulate", "find", "exact", "response", "bifurcation_diagram", "lyapunov", "basins"]
)
def test_help_shows_every_form_of_call(name):
    """The help shows the signature for an oscillator, and one line each for a structure and a point."""
    verb = getattr(vi, name)
    assert next(iter(inspect.signature(verb).parameters)) == "osc"
    forms = " ".join(verb.__doc__.split("\n\n")[1].split())
    assert f"For a structure: ``{name}(structure, load" in forms
    assert f"For a point (`Oscillator.at`): ``{name}(point, " in forms


def message_of(call):
    """The error of a call with a wrong argument; nothing may be computed."""
    with pytest.raises((TypeError, vi.ParameterError)) as error:
        call()
    return str(error.value)


VERBS = [
    name
    for name in vi.__all__
    if inspect.isfunction(verb := getattr(vi, name))
    and (next(iter(inspect.signature(verb).parameters), "") == "osc" or name == "branch")
]


@pytest.fixture(scope="module")
def of_a_structure():
    """The first argument of verbs of structures, and of those of their motions."""
    return {"structure": WALL, "motion of a structure": vi.exact(LAW, 0.94, 37.0, GUESS)}


@pytest.mark.parametrize("name", VERBS)
def test_help_shows_the_forms_that_a_call_accepts(name, of_a_structure):
    """Of every verb: help shows a form for points, or what to give instead, and a form for structures, if the
    call accepts one."""
    verb = getattr(vi, name)
    forms = " ".join(verb.__doc__.split("\n\n")[1].split())
    refused = "must not be a point" in message_of(lambda: verb(OSC.at(0.94, 37.0), unknown=1))
    assert (f"For a point (`Oscillator.at`): ``{name}(point" in forms) != refused
    assert ("A point (`Oscillator.at`) is not accepted; " in forms) == refused
    for kind, first in of_a_structure.items():
        taken = "for a structure the arguments are" in message_of(
            lambda first=first: verb(first, unknown=1)
        )
        assert taken == (f"For a {kind}: ``{name}(" in forms)


def test_a_load_that_a_verb_does_not_know_is_refused():
    """A verb without a load argument refuses a point with a load amplitude other than 1."""
    with pytest.raises(
        vi.ParameterTypeError, match="must have the load amplitude 1, for which equispaced"
    ):
        vi.equispaced(OSC.at(0.94, 37.0, 2.0))
    assert len(vi.equispaced(OSC.at(0.94, 37.0, 1.0))) == 2
    for friction, wanted in (
        (0.0, "divide its clearance by"),
        (0.1, "its clearance and friction by"),
    ):
        with pytest.raises(vi.ParameterTypeError, match=wanted):
            vi.limit_probability(
                OSC.at(0.94, 37.0, 2.0, friction=friction),
                {"load": (0.9, 1.1)},
                {"displacement": 9.0},
            )
