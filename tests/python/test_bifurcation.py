"""Bifurcation diagrams compared with exact motions and zones; namelists that reproduce them."""

import numpy as np
import pytest
import vibroimpact as vi
from shared_motions import state_on
from shared_systems import FIGURE6, RIG

MOVING = {"t": 0, "x": 0, "x_dot": 6, "z": 0, "z_dot": 9}


@pytest.fixture(scope="module")
def sweeps():
    return vi.bifurcation_diagram(FIGURE6, "clearance", np.arange(10.0, 75.0, 0.5), r=1.04)


def test_impacts_are_those_of_exact_motions(sweeps):
    """Where the label is 2/1, the impacts are those of an exact motion, to 1e-5 of the clearance."""
    up = sweeps.runs.index("up")
    checked = 0
    for i in np.flatnonzero(sweeps.labels[up] == "2/1")[::12]:
        clearance = float(sweeps.values[i])
        mine = sweeps.points[(sweeps.points["run"] == up) & (sweeps.points["index"] == i)]
        motions = [m for m in vi.equispaced(FIGURE6, 1.04, clearance) if m.stable]
        motions += vi.find(FIGURE6, 1.04, clearance, max_impacts=2, max_cycles=1, releases=0)
        near = [
            max(abs(mine["x"][mine["side"] == s] - x).max() for s, x in zip("RL", m.X, strict=True))
            for m in motions
            if m.pattern.sides == "RL"
        ]
        assert min(near) < 1e-5 * clearance
        checked += 1
    assert checked > 4


def test_a_sweep_leaves_a_motion_at_the_boundary_of_its_zone():
    """The sweep up follows the two-impact motion to the last value that its zone contains.

    The zone ends in a Neimark-Sacker bifurcation, near which settling is slow and the basin is small.
    """
    zone = vi.zone(FIGURE6, vi.Pattern("RL"), (1.02, 1.06), (20, 90), lines=9)
    values = np.arange(70.0, 72.0, 0.05)
    motion = next(m for m in vi.equispaced(FIGURE6, 1.04, values[0]) if m.stable)
    result = vi.bifurcation_diagram(
        FIGURE6, "clearance", values, r=1.04, sweep="up", state=state_on(motion), settling=5000
    )
    followed = result.labels[0] == "2/1"
    inside = np.array([bool(zone.contains(1.04, value)) for value in values])
    assert inside[0]
    assert not inside[-1]
    assert not followed[~inside].any()
    assert followed[inside][:-1].all()


def test_hysteresis(sweeps):
    """The sweep down reaches the two-impact motion at a lower value than that at which the sweep up leaves it."""
    ends = {w.run: w.high for w in sweeps.windows if w.label == "2/1"}
    assert ends["down"] < ends["up"]
    between = (sweeps.values > ends["down"]) & (sweeps.values <= ends["up"])
    assert sweeps.coexisting[between].all()
    assert not sweeps.coexisting[(sweeps.values > 20) & (sweeps.values <= ends["down"])].any()


def test_many_states_see_both_sides_of_the_hysteresis(sweeps):
    ends = {w.run: w.high for w in sweeps.windows if w.label == "2/1"}
    middle = (ends["down"] + ends["up"]) / 2
    values = [30.0, middle]
    many = vi.bifurcation_diagram(FIGURE6, "clearance", values, r=1.04, sweep="states", states=40)
    assert (many.labels[:, 0] == "2/1").all()
    assert many.labels.shape == (40, 2)
    up = vi.bifurcation_diagram(FIGURE6, "clearance", values, r=1.04, sweep="up")
    assert (up.labels == "2/1").all()


@pytest.mark.parametrize("parameter", ["r", "xi", "mu", "R1", "R2", "restitution"])
def test_every_parameter_is_swept(parameter):
    """At each value the sweep settles on the stable two-impact motion of that system."""
    system = {"xi": 0.0114, "mu": 0.028, "R1": 0.75, "R2": 0.75, "r": 1.04}
    low = 0.75 if parameter == "restitution" else system[parameter]
    values = np.linspace(low, 1.02 * low, 3)
    fixed = {"clearance": 40.0} | ({} if parameter == "r" else {"r": 1.04})
    result = vi.bifurcation_diagram(FIGURE6, parameter, values, sweep="down", settling=600, **fixed)
    assert (result.labels == "2/1").all()
    for i, value in enumerate(values):
        here = system | (
            {"R1": value, "R2": value} if parameter == "restitution" else {parameter: value}
        )
        osc = vi.Oscillator(xi=here["xi"], mu=here["mu"], restitution=(here["R1"], here["R2"]))
        run = vi.simulate(osc, here["r"], 40.0, 8, state=MOVING, discard=900)
        motion = vi.exact(osc, here["r"], 40.0, run)
        reach = max(-motion.x_min, motion.x_max)
        np.testing.assert_allclose(max(-result.x_min[0, i], result.x_max[0, i]), reach, rtol=1e-5)


def test_labels_of_motions_with_rest():
    result = vi.bifurcation_diagram(RIG, "clearance", [5.9, 6.0], r=0.9, sweep="up")
    assert (result.labels == "2/1").all()  # RL*: the accumulation is one letter
    assert (result.rests == 1).all()
    assert (result.impacts > 10).all()


def test_spaced_values():
    """Both end values are exact, differences or ratios are equal, and values equal those of numpy to rounding."""
    for low, high, n in [(5.0, 60.0, 12), (1e-6, 1e6, 100), (37.0, 37.0001, 7)]:
        even, ratios = (vi.spaced(low, high, n, name) for name in ("linear", "geometric"))
        np.testing.assert_allclose(even, np.linspace(low, high, n), rtol=1e-15)
        np.testing.assert_allclose(ratios, np.geomspace(low, high, n), rtol=1e-14)
        np.testing.assert_allclose(
            ratios[1:] / ratios[:-1], (high / low) ** (1 / (n - 1)), rtol=1e-14
        )
        assert [ratios[0], ratios[-1]] == [even[0], even[-1]] == [low, high]


def test_a_sweep_in_ratios_is_that_over_the_same_values():
    """Where the values of both spacings are equal, the results of independent starts are equal too."""
    ratios = vi.spaced(15.0, 60.0, 3, "geometric")
    even = vi.spaced(15.0, 60.0, 4)
    study = {"r": 1.04, "sweep": "states", "states": 3, "settling": 100}
    one, other = (vi.bifurcation_diagram(FIGURE6, "clearance", v, **study) for v in (ratios, even))
    for i, j in ((0, 0), (2, 3)):
        ours, theirs = (d.points[d.points["index"] == k] for d, k in ((one, i), (other, j)))
        assert len(ours) > 10
        for name in ours.dtype.names:
            if name != "index":
                np.testing.assert_array_equal(ours[name], theirs[name])
    assert "spacing = 'geometric'" in one.case
    assert "spacing = 'linear'" in other.case


@pytest.mark.parametrize(
    ("parameter", "values", "more"),
    [
        ("clearance", vi.spaced(8.0, 70.0, 5, "geometric"), {"r": 1.04, "sweep": "down"}),
        ("r", vi.spaced(1.0, 1.04, 3, "geometric"), {"clearance": 30.0, "state": MOVING}),
        (
            "restitution",
            [0.5, 0.6, 0.7],
            {"r": 1.04, "clearance": 30.0, "sweep": "states", "states": 2},
        ),
    ],
)
def test_the_namelist_of_a_diagram(parameter, values, more, tmp_path):
    """The namelist of a diagram reproduces it to the last bit."""
    result = vi.bifurcation_diagram(
        FIGURE6, parameter, values, settling=40, impacts=9, load=1.1, **more
    )
    (tmp_path / "case.nml").write_text(result.to_namelist())
    (case,) = vi.read_namelist(tmp_path / "case.nml")
    (again,) = case.run()
    np.testing.assert_array_equal(again.points, result.points)
    np.testing.assert_array_equal(again.values, result.values)
    assert again.case == result.case


@pytest.mark.parametrize(
    ("parameter", "values", "beside"),
    [
        ("clearance", [20.0, 21.0, 26.0], {"r": 1.04}),
        ("clearance", [20.0, 21.0, 26.0], {"r": [1.0, 1.03, 1.04]}),
        ("r", [1.0, 1.03, 1.04], {"clearance": [20.0, 30.0, 25.0]}),
        ("mu", [0.01, 0.02, 0.05], {"r": [1.0, 1.03, 1.04], "clearance": 25.0}),
    ],
)
@pytest.mark.parametrize("sweep", ["both", "states"])
def test_lists_have_a_namelist_too(parameter, values, beside, sweep, tmp_path):
    """Unevenly spaced values and a line across the plane; states at one value do not depend on the others."""
    more = {"settling": 30, "keep": 9, "impacts": 7, "sweep": sweep, "states": 2}
    result = vi.bifurcation_diagram(FIGURE6, parameter, values, **beside, **more)
    (tmp_path / "case.nml").write_text(result.to_namelist())
    (case,) = vi.read_namelist(tmp_path / "case.nml")
    (again,) = case.run()
    assert again.to_json() == result.to_json()
    for name, given in beside.items():
        np.testing.assert_array_equal(getattr(result, name), given)
    if sweep == "both":
        return
    for i in (0, 1):
        pair = {
            name: given[i : i + 2] if np.ndim(given) else given for name, given in beside.items()
        }
        alone = vi.bifurcation_diagram(FIGURE6, parameter, values[i : i + 2], **pair, **more)
        np.testing.assert_array_equal(alone.x_max, result.x_max[:, i : i + 2])


@pytest.mark.parametrize("form", ["json", "nc", "mat"])
@pytest.mark.parametrize("values", [[20.0, 21.0, 26.0], [5000.0, 6000.0]])
def test_a_file_gives_the_diagram_again(values, form, tmp_path):
    """Saved diagrams, one of them without impacts, and the core's table are read back to the last bit."""
    start = dict.fromkeys(("t", "x", "x_dot", "z", "z_dot"), 0.0)
    result = vi.bifurcation_diagram(FIGURE6, "clearance", values, r=1.04, state=start, settling=30)
    assert (result.points.size > 0) == (values[0] < 100)
    result.save(tmp_path / f"one.{form}")
    again = vi.load(tmp_path / f"one.{form}")
    assert again.to_json() == result.to_json()
    assert again.points.tobytes() == result.points.tobytes()
    assert again.windows == result.windows
    tables = []
    for item in (result, again):
        item.save(tmp_path / "table.csv")
        tables.append((tmp_path / "table.csv").read_bytes())
    assert tables[0] == tables[1]


def test_states_of_their_own():
    """The initial state `state` is for sweeps; with sweep = 'states' it is refused."""
    start = dict.fromkeys(("t", "x", "x_dot", "z", "z_dot"), 0.0)
    with pytest.raises(vi.errors.ParameterError, match=r"^state\['t'\] = 0.0: must be left out"):
        vi.bifurcation_diagram(FIGURE6, "r", [1, 1.1], clearance=9, sweep="states", state=start)


@pytest.mark.parametrize("name", ["r", "clearance"])
def test_parameter_is_not_given_twice(name):
    with pytest.raises(
        vi.errors.ParameterError,
        match=rf"^{name} = 1.2: must be left out, since it is the parameter",
    ):
        vi.bifurcation_diagram(FIGURE6, name, [1.1, 1.3], r=1.2, clearance=1.2)


def test_resonance_without_damping_among_the_values():
    """A value of r that is 1 is refused at any position; so is a fixed r = 1 where xi begins at 0."""
    undamped = vi.Oscillator(xi=0.0, mu=0.1, restitution=0.7)
    for values in ([1.0, 1.1], [0.9, 1.0, 1.1], [0.9, 1.0]):
        with pytest.raises(vi.errors.ParameterError, match="resonance without damping"):
            vi.bifurcation_diagram(undamped, "r", values, clearance=9.0)
    with pytest.raises(vi.errors.ParameterError, match="resonance without damping"):
        vi.bifurcation_diagram(FIGURE6, "xi", [0.0, 0.1], r=1.0, clearance=9.0)
    options = {"settling": 3, "keep": 3, "sweep": "up"}
    damped = vi.bifurcation_diagram(FIGURE6, "xi", [0.05, 0.1], r=1.0, clearance=9.0, **options)
    assert damped.values.tolist() == [0.05, 0.1]


def test_near_a_flip_the_shortest_period_counts():
    """The flip of RL/1 is at 11.08153: above it, no slowly settling run counts as one of two cycles."""
    values = [11.0926, 11.1, 11.12]
    for sweep in ("both", "states"):
        diagram = vi.bifurcation_diagram(RIG, "clearance", values, r=1.1, sweep=sweep)
        # no other label; nearly every run has settled
        assert set(diagram.labels.ravel()) <= {"2/1", ""}
        assert np.mean(diagram.cycles == 1) > 0.9


def test_a_motion_that_is_left_slowly_has_no_label():
    """Just below the flip the sweep down stays at the unstable motion for longer than the simulation lasts."""
    diagram = vi.bifurcation_diagram(RIG, "clearance", [11.07, 11.09, 11.12], r=1.1, sweep="down")
    assert diagram.labels[0].tolist() == ["", "2/1", "2/1"]
    motion = vi.exact(RIG, 1.1, 11.07, vi.exact(RIG, 1.1, 11.12, ([0, 4.26686453], "LR")))
    assert motion.stable is False
