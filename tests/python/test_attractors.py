"""Attractors: exponents against multipliers and volume, diagrams against zones, basins against the end.

Simulations go on bit for bit, so what a basin says about a state can be compared with where that
very trajectory is later, even in transient chaos.
"""

import importlib
import math
from dataclasses import replace

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact.studies.basins import Axis

TABLE = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
EQUAL = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
UNEQUAL = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))
COLUMN = ([0, 1.37 * math.pi], vi.Pattern("RL"))
MOVING = {"t": 0, "x": 0, "x_dot": 6, "z": 0, "z_dot": 9}
PLANE = (("x", -30, 30, 40), ("x_dot", -30, 30, 40))


def state_on(motion):
    """Return the state just after the first impact of a motion."""
    return {
        "t": motion.load_phase / motion.r, "x": motion.X[0], "x_dot": motion.X_dot_after[0],
        "z": motion.Z[0], "z_dot": motion.Z_dot_after[0],
    }  # fmt: skip


@pytest.fixture(scope="module")
def plane():
    return vi.basins(TABLE, 0.94, 37.0, PLANE)


@pytest.fixture(scope="module")
def sweeps():
    return vi.bifurcation_diagram(EQUAL, "clearance", np.arange(10.0, 75.0, 0.5), r=1.04)


# Lyapunov exponents


@pytest.mark.parametrize(
    ("osc", "r", "clearance", "guess"),
    [
        (TABLE, 0.94, 37.0, COLUMN),
        (EQUAL, 1.04, 14.0, None),
        (EQUAL, 1.04, 6.0, None),
        (UNEQUAL, 1.04, 30.0, None),
    ],
)
def test_exponents_of_periodic_motions_are_those_of_the_multipliers(osc, r, clearance, guess):
    """... and their sum is that of the invariant det [P] = exp(-4 pi xi k/r) prod R^2."""
    run = guess or vi.simulate(osc, r, clearance, 12, discard=2000)
    motion = vi.exact(osc, r, clearance, run)
    assert motion.stable
    result = vi.lyapunov(osc, r, clearance, state=state_on(motion))
    k = motion.pattern.cycles
    np.testing.assert_allclose(result.per_cycle, np.log(np.abs(motion.multipliers)) / k, atol=1e-6)
    volume = -4 * np.pi * osc.xi / r + 2 * np.log(motion.restitution).sum() / k
    np.testing.assert_allclose(result.per_cycle.sum(), volume, rtol=1e-9)
    assert result.dimension == 0
    assert result.rests == 0


def test_exponents_of_a_motion_with_rest():
    """Two are those of the return map at a release, two are extinguished."""
    motion = vi.exact(UNEQUAL, 0.9, 6.0, vi.simulate(UNEQUAL, 0.9, 6.0, cycles=8, discard=200))
    result = vi.lyapunov(UNEQUAL, 0.9, 6.0)
    np.testing.assert_allclose(
        result.per_cycle[:2], np.log(np.abs(motion.multipliers[:2])), atol=1e-6
    )
    assert np.all(result.exponents[2:] == -math.inf)
    assert result.rests >= result.cycles
    assert result.identity_error < 1e-6


def test_volume_is_checked_on_every_trajectory():
    """The sum of the logarithms is that of volume, in chaos too and for unequal walls."""
    for osc in (EQUAL, UNEQUAL):
        result = vi.lyapunov(osc, 1.04, np.linspace(5, 60, 12), cycles=2000)
        assert np.all(result.identity_error[result.rests == 0] < 1e-12)
        # at the end of an accumulation speeds of 1e-8 are differences of velocities
        assert np.all(result.identity_error < 1e-6)
        assert np.any(result.largest > 3 * result.standard_error[0])


def test_largest_exponent_is_the_rate_at_which_neighbours_part():
    """Against two simulations a small distance apart, which know nothing of derivatives."""
    r, clearance, cycles, small = 1.04, 7.5, 1500, 1e-7
    names = ("x", "x_dot", "z", "z_dot")
    here = vi.simulate(EQUAL, r, clearance, 0, discard=500).final_state
    there = {name: here[name] for name in ("t", *names)}
    there["x_dot"] += small
    growth = []
    for _ in range(cycles):
        after = vi.simulate(EQUAL, r, clearance, 1, state=here).final_state
        beside = vi.simulate(EQUAL, r, clearance, 1, state=there).final_state
        apart = np.array([beside[name] - after[name] for name in names])
        growth.append(math.log(np.linalg.norm(apart) / small))
        there = {"t": after["t"]}
        for name, step in zip(names, apart * (small / np.linalg.norm(apart)), strict=True):
            there[name] = after[name] + step
        half = clearance / 2
        there["z"] = there["x"] + min(max(there["z"] - there["x"], -half), half)
        here = after
    growth = np.array(growth[50:])
    error = growth.reshape(50, -1).mean(axis=1).std() / math.sqrt(50)
    result = vi.lyapunov(EQUAL, r, clearance, cycles=20_000)
    combined = math.hypot(error, float(result.standard_error[0]) * 2 * np.pi / r)
    assert result.per_cycle[0] > 0.5
    assert abs(growth.mean() - result.per_cycle[0]) < 4 * combined
    assert 1 < result.dimension < 4


def test_dead_walls_extinguish_directions():
    """With R = 0 on both walls the determinant is 0, so at most three exponents are finite."""
    osc = vi.Oscillator(xi=0.02, mu=0.05, restitution=0.0)
    result = vi.lyapunov(osc, 0.9, 4.0, cycles=500)
    assert result.impacts > 0
    assert result.exponents[3] == -math.inf
    assert np.isfinite(result.exponents[0])


def test_exponents_do_not_depend_on_threads():
    points = np.linspace(6, 60, 7)
    one, three = (vi.lyapunov(EQUAL, 1.04, points, cycles=400, threads=n) for n in (1, 3))
    np.testing.assert_array_equal(one.exponents, three.exponents)
    alone = vi.lyapunov(EQUAL, 1.04, points[2], cycles=400)
    np.testing.assert_array_equal(alone.exponents, one.exponents[:, 2])


def test_without_impacts_there_are_no_exponents():
    with pytest.raises(vi.errors.SingularError, match="no impacts"):
        vi.lyapunov(TABLE, 0.5, 100.0, cycles=100)
    both = vi.lyapunov(TABLE, 0.94, [100.0, 37.0], cycles=100)
    assert np.isnan(both.exponents[:, 0]).all()
    assert np.isnan(both.dimension[0])
    assert both.impacts[0] == 0


# Bifurcation diagrams


def test_impacts_are_those_of_exact_motions(sweeps):
    """Where the label is 2/1 the impacts are those of the motion that Newton's method finds from them."""
    up = sweeps.runs.index("up")
    checked = 0
    for i in np.flatnonzero(sweeps.labels[up] == "2/1")[::12]:
        clearance = float(sweeps.values[i])
        mine = sweeps.points[(sweeps.points["run"] == up) & (sweeps.points["index"] == i)]
        motions = [m for m in vi.equispaced(EQUAL, 1.04, clearance) if m.stable]
        motions += vi.find(EQUAL, 1.04, clearance, max_impacts=2, max_cycles=1, releases=0)
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

    It ends in a Neimark-Sacker bifurcation: it settles ever more slowly, and what goes to it shrinks.
    """
    zone = vi.zone(EQUAL, vi.Pattern("RL"), (1.02, 1.06), (20, 90), lines=9)
    values = np.arange(70.0, 72.0, 0.05)
    motion = next(m for m in vi.equispaced(EQUAL, 1.04, values[0]) if m.stable)
    result = vi.bifurcation_diagram(
        EQUAL, "clearance", values, r=1.04, sweep="up", state=state_on(motion), settling=5000
    )
    followed = result.labels[0] == "2/1"
    inside = np.array([bool(zone.contains(1.04, value)) for value in values])
    assert inside[0]
    assert not inside[-1]
    assert not followed[~inside].any()
    assert followed[inside][:-1].all()


def test_hysteresis(sweeps):
    """The sweep down finds the two-impact motion later than the sweep up has left it."""
    ends = {w.run: w.high for w in sweeps.windows if w.label == "2/1"}
    assert ends["down"] < ends["up"]
    between = (sweeps.values > ends["down"]) & (sweeps.values <= ends["up"])
    assert sweeps.coexisting[between].all()
    assert not sweeps.coexisting[(sweeps.values > 20) & (sweeps.values <= ends["down"])].any()


def test_many_states_see_both_sides_of_the_hysteresis(sweeps):
    ends = {w.run: w.high for w in sweeps.windows if w.label == "2/1"}
    middle = (ends["down"] + ends["up"]) / 2
    values = [30.0, middle]
    many = vi.bifurcation_diagram(EQUAL, "clearance", values, r=1.04, sweep="states", states=40)
    assert (many.labels[:, 0] == "2/1").all()
    assert many.labels.shape == (40, 2)
    up = vi.bifurcation_diagram(EQUAL, "clearance", values, r=1.04, sweep="up")
    assert (up.labels == "2/1").all()


@pytest.mark.parametrize("parameter", ["r", "xi", "mu", "R1", "R2", "restitution"])
def test_every_parameter_is_swept(parameter):
    """At each value the stable two-impact motion of that very system is what is left."""
    system = {"xi": 0.0114, "mu": 0.028, "R1": 0.75, "R2": 0.75, "r": 1.04}
    low = 0.75 if parameter == "restitution" else system[parameter]
    values = np.linspace(low, 1.02 * low, 3)
    fixed = {"clearance": 40.0} | ({} if parameter == "r" else {"r": 1.04})
    result = vi.bifurcation_diagram(EQUAL, parameter, values, sweep="down", settling=600, **fixed)
    assert (result.labels == "2/1").all()
    for i, value in enumerate(values):
        here = system | (
            {"R1": value, "R2": value} if parameter == "restitution" else {parameter: value}
        )
        osc = vi.Oscillator(here["xi"], here["mu"], (here["R1"], here["R2"]))
        run = vi.simulate(osc, here["r"], 40.0, 8, state=MOVING, discard=900)
        motion = vi.exact(osc, here["r"], 40.0, run)
        reach = max(-motion.x_min, motion.x_max)
        np.testing.assert_allclose(max(-result.x_min[0, i], result.x_max[0, i]), reach, rtol=1e-5)


def test_labels_of_motions_with_rest():
    result = vi.bifurcation_diagram(UNEQUAL, "clearance", [5.9, 6.0], r=0.9, sweep="up")
    assert (result.labels == "2/1").all()  # RL*: the accumulation is one letter
    assert (result.rests == 1).all()
    assert (result.impacts > 10).all()


def test_spaced_values():
    """Both ends exactly, equal differences or ratios, and numpy's to rounding."""
    for low, high, n in [(5.0, 60.0, 12), (1e-6, 1e6, 100), (37.0, 37.0001, 7)]:
        even, ratios = (vi.spaced(low, high, n, name) for name in ("linear", "geometric"))
        np.testing.assert_allclose(even, np.linspace(low, high, n), rtol=1e-15)
        np.testing.assert_allclose(ratios, np.geomspace(low, high, n), rtol=1e-14)
        np.testing.assert_allclose(
            ratios[1:] / ratios[:-1], (high / low) ** (1 / (n - 1)), rtol=1e-14
        )
        assert [ratios[0], ratios[-1]] == [even[0], even[-1]] == [low, high]


def test_a_sweep_in_ratios_is_that_over_the_same_values():
    """Where the values of the two spacings are equal, what starts anew at each is too."""
    ratios = vi.spaced(15.0, 60.0, 3, "geometric")
    even = vi.spaced(15.0, 60.0, 4)
    study = {"r": 1.04, "sweep": "states", "states": 3, "settling": 100}
    one, other = (vi.bifurcation_diagram(EQUAL, "clearance", v, **study) for v in (ratios, even))
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
    """It gives the diagram again, to the last bit."""
    result = vi.bifurcation_diagram(
        EQUAL, parameter, values, settling=40, points=9, load=1.1, **more
    )
    (tmp_path / "case.nml").write_text(result.to_namelist())
    (case,) = vi.read_namelist(tmp_path / "case.nml")
    (again,) = case.run()
    np.testing.assert_array_equal(again.points, result.points)
    np.testing.assert_array_equal(again.values, result.values)
    assert again.case == result.case


STATE = {"t": 0.3, "x": 1.0, "x_dot": -2.0, "z": 2.5, "z_dot": 4.0}


@pytest.mark.parametrize(
    ("r", "clearance"),
    [(1.04, 25.0), (vi.spaced(1.0, 1.05, 4), 25.0), (1.04, vi.spaced(20.0, 30.0, 3, "geometric"))],
)
@pytest.mark.parametrize("state", [None, STATE])
def test_the_namelist_of_exponents(r, clearance, state, tmp_path):
    """It gives them again, to the last bit."""
    result = vi.lyapunov(EQUAL, r, clearance, 61, state, load=1.1, discard=20, batches=3)
    (tmp_path / "case.nml").write_text(result.to_namelist())
    (case,) = vi.read_namelist(tmp_path / "case.nml")
    (again,) = case.run()
    for name in ("r", "clearance", "exponents", "standard_error", "impacts"):
        np.testing.assert_array_equal(
            np.ravel(getattr(again, name)), np.ravel(getattr(result, name))
        )
    assert again.cycles == result.cycles == 60
    assert again.case == result.case


def test_exponents_without_a_namelist():
    """A grid, a diagonal, points spaced otherwise, and a start that goes on from another trajectory."""
    grid = np.meshgrid([1.0, 1.02], [20.0, 30.0])
    final = vi.simulate(EQUAL, 1.04, 25.0, 3).final_state
    calls = [(grid, None), (([1.0, 1.02], [20.0, 30.0]), None), (([1.0, 1.01, 1.04], 20.0), None)]
    for (r, clearance), state in [*calls, ((1.04, 25.0), final)]:
        result = vi.lyapunov(EQUAL, r, clearance, 40, state)
        with pytest.raises(vi.errors.ParameterError, match="has no namelist"):
            result.to_namelist()


@pytest.mark.parametrize("wall", [{"clearance": 25.0}, {"inverse_clearance": 0.03}])
def test_the_namelist_of_a_response(wall, tmp_path):
    """It gives the response again, to the last bit."""
    line = vi.spaced(1.0, 1.02, 3)
    result = vi.response(EQUAL, line, **wall, states=4, load=1.1, settling=30, keep=9)
    (tmp_path / "case.nml").write_text(result.to_namelist())
    (case,) = vi.read_namelist(tmp_path / "case.nml")
    (again,) = case.run()
    for name in ("r", "clearance", "attenuation", "lowest", "highest", "cycles"):
        np.testing.assert_array_equal(getattr(again, name), getattr(result, name))
    assert again.case == result.case
    given = {name: np.full(3, value) for name, value in wall.items()}
    with pytest.raises(vi.errors.ParameterError, match="has no namelist"):
        vi.response(EQUAL, line, **given, states=4, settling=30).to_namelist()


def test_a_diagram_without_a_namelist():
    """Values that are spaced otherwise, and a line across the plane."""
    odd = vi.bifurcation_diagram(EQUAL, "clearance", [20, 21, 23], r=1.04, settling=10)
    values = [1.0, 1.02, 1.04]
    across = vi.bifurcation_diagram(EQUAL, "r", values, clearance=[20, 21, 22], settling=10)
    for result in (odd, across):
        with pytest.raises(vi.errors.ParameterError, match="has no namelist"):
            result.to_namelist()


def test_diagram_does_not_depend_on_threads():
    for sweep in ("both", "states"):
        one, two = (
            vi.bifurcation_diagram(EQUAL, "r", [1.0, 1.02], clearance=20.0, sweep=sweep, threads=n)
            for n in (1, 2)
        )
        np.testing.assert_array_equal(one.points, two.points)
        np.testing.assert_array_equal(one.labels, two.labels)


# Basins


def test_states_go_where_their_basin_says(plane):
    """Each trajectory, simulated far on, has the impacts of the motion that its label names."""
    states = plane.states.reshape(5, -1)
    labels = plane.labels.ravel()
    assert (labels >= 0).all()
    r, clearance, checked = plane.r, plane.clearance, 0
    for j in range(0, labels.size, 7):
        item = plane.attractors[labels[j]]
        start = dict(zip(("t", "x", "x_dot", "z", "z_dot"), states[:, j], strict=True))
        cycles = 5 if item.motion is None else item.motion.pattern.cycles
        run = vi.simulate(TABLE, r, clearance, cycles, state=start, discard=1500)
        if item.kind == "no impacts":
            assert len(run.events) == 0
            continue
        x, own = np.sort(run.events["x"]), np.sort(item.motion.X)
        assert x.size == own.size
        np.testing.assert_allclose(x, own, atol=1e-5 * clearance)
        checked += 1
    assert checked > 150


def mirrors(one, other):
    """Return which attractor of one result is the mirror image of which of the other."""
    return [
        next(j for j, item in enumerate(other.attractors)
             if np.abs(np.sort(item.motion.X) - np.sort(-mine.motion.X)).max() < 1e-7)
        for mine in one.attractors
    ]  # fmt: skip


def test_mirror_images_have_equal_shares():
    """Of random states, and of their mirror images half a period later: those go to the mirror images."""
    result = vi.basins(EQUAL, 1.04, 14.0, states=3000)
    reflected = -result.states
    reflected[0] = math.pi / 1.04
    there = vi.basins(EQUAL, 1.04, 14.0, states=reflected)
    first, second = result.attractors
    assert {first.kind, second.kind} == {"periodic"}
    assert sorted(mirrors(result, result)) == [0, 1] != mirrors(result, result)
    images = np.array(mirrors(result, there))
    # transient chaos is decided by rounding: shares, not every state, are the same
    assert np.mean(images[result.labels] == there.labels) > 0.95
    error = 4 * math.hypot(result.standard_error[0], there.standard_error[0])
    np.testing.assert_allclose(result.fractions, there.fractions[images], atol=error)
    # a plane that is its own mirror image: a whole period of times
    period = 2 * math.pi / 1.04
    plane = (("t", 0, period * 39 / 40, 40), ("x", -20, 20, 41))
    even = vi.basins(EQUAL, 1.04, 14.0, plane)
    assert abs(np.diff(even.fractions)[0]) < 4 * 2 * even.standard_error[0]
    assert result.fractions.sum() == even.fractions.sum() == 1
    for item in result.attractors:
        assert np.abs(item.motion.multipliers).max() < item.contraction < 1
        assert item.radius > 0


def philox(counter, key):
    """Return the words of Philox4x32-10 (Salmon et al., SC11) in whole numbers without end."""
    c, (a, b), word = list(counter), key, 2**32
    for _ in range(10):
        p, q = 0xD2511F53 * c[0], 0xCD9E8D57 * c[2]
        c = [q // word ^ c[1] ^ a, q % word, p // word ^ c[3] ^ b, p % word]
        a, b = (a + 0x9E3779B9) % word, (b + 0xBB67AE85) % word
    return c


@pytest.mark.parametrize(("load", "seed"), [(1.0, 0), (0.0, 7), (50.0, 2**31 - 1)])
def test_random_states(load, seed):
    """Bit for bit a count through a published generator, in the box that is told."""
    r, clearance, n = 1.04, 14.0, 30
    states = vi.basins(
        EQUAL, r, clearance, states=n, load=load, seed=seed, cycles=1, probes=1
    ).states
    known = [0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1]
    pi = (0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344), (0xA4093822, 0x299F31D0)
    assert philox(*pi) == known
    amplitude = load / math.hypot(1 - r**2, 2 * EQUAL.xi * r)
    s = min(max(amplitude, clearance / 2), 3 * clearance)
    for i, (t, x, x_dot, z, z_dot) in enumerate(states.T.tolist()):
        u = [(2 * word + 1) / 2**32 - 1 for word in philox((i, 0, 0, 0), (seed, 0))]
        assert t == 0
        np.testing.assert_allclose(
            [x, x_dot, z - x, z_dot],
            [s * u[0], s * u[1], clearance / 2 * u[2], s * u[3]],
            rtol=1e-12,
        )
    fewer = vi.basins(EQUAL, r, clearance, states=9, load=load, seed=seed, cycles=1, probes=1)
    np.testing.assert_array_equal(fewer.states, states[:, :9])


def test_random_shares_are_those_of_a_lattice():
    """Of states in the middles of 4096 equal boxes that fill the same box."""
    r, clearance = 0.94, 37.0
    s = 1 / math.hypot(1 - r**2, 2 * TABLE.xi * r)
    s = min(max(s, clearance / 2), 3 * clearance)
    u = (np.arange(8) + 0.5) / 4 - 1
    x, x_dot, y, z_dot = (item.ravel() for item in np.meshgrid(u, u, u, u))
    states = [0 * x, s * x, s * x_dot, s * x + clearance / 2 * y, s * z_dot]
    lattice = vi.basins(TABLE, r, clearance, states=np.array(states))
    thrown = vi.basins(TABLE, r, clearance, states=3000, seed=1)
    shares = [
        dict(zip([np.round(np.sort(a.motion.X), 5).tobytes() if a.motion else a.kind
                  for a in result.attractors], result.fractions.tolist(), strict=True))
        for result in (lattice, thrown)
    ]  # fmt: skip
    assert max(shares[0].values()) < 0.9
    for which, share in shares[0].items():
        error = math.sqrt(share * (1 - share) * (1 / 4096 + 1 / 3000)) + 1e-3
        assert abs(shares[1].get(which, 0.0) - share) < 4 * error


@pytest.mark.parametrize(
    "start",
    [
        {"states": 60, "seed": 3},
        {"plane": (("y", -3, 3, 5), ("t", 0, 6, 7)), "fixed": {"x": 1.5, "z_dot": -2}},
    ],
)
def test_the_namelist_of_basins(start, tmp_path):
    """It gives them again, to the last bit."""
    result = vi.basins(EQUAL, 1.04, 14.0, load=1.1, probes=20, max_cycles=4, **start)
    (tmp_path / "case.nml").write_text(result.to_namelist())
    (case,) = vi.read_namelist(tmp_path / "case.nml")
    (again,) = case.run()
    np.testing.assert_array_equal(again.states, result.states)
    np.testing.assert_array_equal(again.labels, result.labels)
    assert again.case == result.case
    given = vi.basins(EQUAL, 1.04, 14.0, states=result.states.reshape(5, -1), probes=20)
    with pytest.raises(vi.errors.ParameterError, match="has no namelist"):
        given.to_namelist()


def test_decision_does_not_depend_on_how_soon(plane):
    """Fewer cycles a round decide the same: what is left goes on from where it is."""
    hasty = vi.basins(TABLE, 0.94, 37.0, PLANE, cycles=60, probes=400)
    ours = [item.motion and np.sort(item.motion.X) for item in plane.attractors]
    share = 0
    for item, fraction in zip(hasty.attractors, hasty.fractions, strict=True):
        match = [
            i for i, x in enumerate(ours)
            if item.motion is not None and x is not None and len(x) == len(item.motion.X)
            and np.abs(x - np.sort(item.motion.X)).max() < 1e-6
        ]  # fmt: skip
        if match:
            # transient chaos is decided by rounding: shares, not states, are the same
            error = math.hypot(plane.standard_error[match[0]], 1e-3)
            assert abs(fraction - plane.fractions[match[0]]) < 4 * error
            share += fraction
    assert share > 0.85


def test_motion_with_rest_and_chaos_are_told():
    resting = vi.basins(UNEQUAL, 0.9, 6.0, states=100)
    assert [item.kind for item in resting.attractors] == ["rest"]
    assert resting.attractors[0].motion.pattern == vi.Pattern("RL*")
    wild = vi.basins(EQUAL, 1.04, 72.0, states=60)
    assert [item.kind for item in wild.attractors] == ["chaotic"]
    assert wild.attractors[0].lyapunov.per_cycle[0] > 0.1
    assert wild.labels.max() == 0


def test_what_never_settles_is_not_decided():
    """Free vibration dies out for ever: no state is given an attractor."""
    result = vi.basins(EQUAL, 0.9, 5.0, states=20, load=0.0, cycles=100)
    assert (result.labels == -1).all()
    assert result.attractors == []
    assert "20 not decided" in repr(result)


def test_basins_do_not_depend_on_threads():
    one, two = (vi.basins(TABLE, 0.94, 37.0, states=200, threads=n) for n in (1, 2))
    np.testing.assert_array_equal(one.labels, two.labels)
    np.testing.assert_array_equal(one.states, two.states)
    assert one.impacts == two.impacts


def drawn(labels, low=-1.0, high=1.0):
    """Return basins with given labels on a square."""
    n, m = labels.shape
    axes = (Axis("x", low, high, n), Axis("x_dot", low, high, m))
    made = vi.BasinAttractor("periodic", "made", None, {})
    both = [made, replace(made, name="other")]
    return vi.Basins(
        EQUAL, 1.0, 1.0, 1.0, both, labels.astype(np.int32), axes, np.zeros((5, n, m)), 0
    )


def test_uncertainty_exponent_of_known_boundaries():
    """1 for a straight boundary, 0 where labels are thrown, 1 - log 2/log 3 for the set of Cantor."""
    x = np.linspace(-1, 1, 243)
    half = drawn(np.add.outer(x, 0.3 * x) > 0.1)
    assert abs(half.uncertainty_exponent - 1) < 0.02
    thrown = drawn(np.random.default_rng(3).random((300, 300)) > 0.5)
    assert abs(thrown.uncertainty_exponent) < 0.02
    assert math.isnan(drawn(np.zeros((50, 50))).uncertainty_exponent)


def test_a_smooth_boundary():
    """The free mass at rest is never hit from where the closed form says; the edge of that is a smooth curve."""
    xi, r, clearance = 0.1, 1.0, 11.0
    osc = vi.Oscillator(xi=xi, mu=0.1, restitution=0.6)
    result = vi.basins(osc, r, clearance, (("x", -3, 3, 64), ("x_dot", 2, 8, 64)))
    quiet = [item.kind for item in result.attractors].index("no impacts")
    x, x_dot = result.states[1:3]
    gain, w, t = 1 / complex(1 - r**2, 2 * xi * r), math.sqrt(1 - xi**2), 0.0
    a, b = x - gain.imag, x_dot - (1j * r * gain).imag
    farthest = np.zeros_like(x)
    while t < 80:
        forced = (gain * np.exp(1j * r * t)).imag
        free = a * math.cos(w * t) + (b + xi * a) / w * math.sin(w * t)
        farthest = np.maximum(farthest, np.abs(forced + math.exp(-xi * t) * free - x))
        t += 0.01
    clear = np.abs(farthest - clearance / 2) > 1e-3
    assert clear.mean() > 0.99
    np.testing.assert_array_equal(
        (farthest < clearance / 2)[clear], (result.labels == quiet)[clear]
    )
    # not quite 1: of pairs far apart there are fewer, as s/(64 - s)
    assert abs(result.uncertainty_exponent - 1) < 0.03


def test_integrity_is_the_largest_disc():
    x = np.linspace(-1, 1, 201)
    distance = np.hypot(*np.meshgrid(x - 0.2, x + 0.1, indexing="ij"))
    disc = drawn(np.where(distance < 0.5, 0, 1))
    radius, centre = disc.integrity(0)
    assert abs(radius - 0.5) < 0.011
    assert np.hypot(centre[0] - 0.2, centre[1] + 0.1) < 0.011


@pytest.mark.parametrize("seed", range(5))
def test_integrity_is_that_of_every_pair(seed):
    """Of all states and all that are elsewhere or a cell beyond the edge, by brute force."""
    labels = (np.random.default_rng(seed).random((13, 17)) > 0.2).astype(int)
    basins = drawn(labels, -1.0, 2.0)
    first, second = basins.axes
    cells = np.array([3 / 12, 3 / 16])
    for label in (0, 1):
        outside = np.argwhere(np.pad(labels != label, 1, constant_values=True)) - 1
        apart = np.argwhere(np.ones_like(labels))[:, None] - outside
        near = np.linalg.norm(apart * cells, axis=-1).min(axis=1).reshape(labels.shape)
        radius, centre = basins.integrity(label)
        assert radius == pytest.approx(near.max(), rel=1e-12)
        i, j = (
            int(np.searchsorted(a.values, x)) for a, x in zip((first, second), centre, strict=True)
        )
        assert near[i, j] == pytest.approx(radius, rel=1e-12)


# Response


def test_response_is_that_of_the_exact_motions():
    """Each attractor's max|X|/A is that of a motion that Newton's method finds."""
    r, inverse = np.array([1.04, 1.06]), 0.03
    result = vi.response(EQUAL, r, inverse_clearance=inverse, states=8)
    for i, one in enumerate(r.tolist()):
        motions = vi.find(EQUAL, one, 1 / inverse, max_impacts=3, max_cycles=1)
        own = np.array([m.attenuation for m in motions if m.stable])
        assert (result.cycles[i] > 0).all()
        for value in result.attenuation[i]:
            assert np.abs(own / value - 1).min() < 1e-5
    assert np.all(result.lowest <= result.highest)


def test_response_by_clearance_is_the_same():
    one = vi.response(EQUAL, [1.0, 1.02], clearance=25.0, states=4, threads=1)
    two = vi.response(EQUAL, [1.0, 1.02], inverse_clearance=0.04, states=4, threads=2)
    np.testing.assert_array_equal(one.attenuation, two.attenuation)


def test_load_scales_lengths():
    """Twice the load with twice the clearance is the same motion, twice as large."""
    plain = vi.response(EQUAL, [1.04], clearance=30.0, states=4)
    twice = vi.response(EQUAL, [1.04], clearance=60.0, states=4, load=2.0)
    np.testing.assert_allclose(plain.highest, twice.highest, rtol=1e-9)


# All of them


@pytest.mark.parametrize(
    ("call", "word"),
    [
        (lambda: vi.lyapunov(EQUAL, 1.04, 10.0, cycles=10), "cycles"),
        (lambda: vi.lyapunov(EQUAL, 1.04, -1.0), "clearance"),
        (lambda: vi.lyapunov(EQUAL, [1.0, 1.1], [1.0, 2.0, 3.0]), "one shape"),
        (lambda: vi.lyapunov(EQUAL, 1.04, 10.0, state={"t": 0}), "state"),
        (lambda: vi.bifurcation_diagram(EQUAL, "D", [1, 2], r=1.0), "parameter"),
        (lambda: vi.bifurcation_diagram(EQUAL, "r", [1, 1.1]), "clearance"),
        (lambda: vi.bifurcation_diagram(EQUAL, "r", [1, 1.1], r=1.0, clearance=9), "left out"),
        (lambda: vi.bifurcation_diagram(EQUAL, "r", [1], clearance=9), "values"),
        (lambda: vi.bifurcation_diagram(EQUAL, "R1", [0.5, 1.5], 1.0, 9.0), "R1"),
        (lambda: vi.bifurcation_diagram(EQUAL, "r", [1, 1.1], clearance=9, sweep="x"), "sweep"),
        (lambda: vi.spaced(1, 2, 5, "equal"), "spacing"),
        (lambda: vi.spaced(2, 1, 5), "low below high"),
        (lambda: vi.spaced(0, 1, 5, "geometric"), "positive"),
        (lambda: vi.spaced(0, 1, 1), "n = 1"),
        (lambda: vi.basins(EQUAL, 1.04, 10.0), "give one"),
        (lambda: vi.basins(EQUAL, 1.04, 10.0, (("z", 0, 1, 5), ("x", 0, 1, 5))), "name"),
        (lambda: vi.basins(EQUAL, 1.04, 10.0, (("x", 1, 0, 5), ("y", 0, 1, 5))), "rise"),
        (
            lambda: vi.basins(EQUAL, 1.04, 10.0, (("x", 0, 1, 5), ("y", 0, 9, 5))),
            "half the clearance",
        ),
        (lambda: vi.basins(EQUAL, 1.04, 10.0, states=0), "states"),
        (lambda: vi.basins(EQUAL, 1.04, 10.0, states=9, seed=-1), "seed"),
        (lambda: vi.basins(EQUAL, 1.04, 10.0, states=9, seed=2**31), "seed"),
        (
            lambda: vi.basins(EQUAL, 1.04, 10.0, states=9, fixed={"x": 1}),
            "fixed .* goes with plane",
        ),
        (
            lambda: vi.basins(EQUAL, 1.04, 10.0, (("x", 0, 1, 5), ("y", 0, 1, 5)), fixed={"x": 1}),
            "it is an axis",
        ),
        (lambda: vi.response(EQUAL, [1.0]), "give one"),
        (lambda: vi.response(EQUAL, [1.0], clearance=-1.0), "positive"),
        (lambda: vi.response(EQUAL, [1.0], clearance=9.0, load=0), "load"),
    ],
)
def test_bad_input_is_named(call, word):
    with pytest.raises((vi.errors.ParameterError, vi.errors.ParameterTypeError), match=word):
        call()


def test_tables_and_pictures(plane, sweeps):
    """Every study has a labelled table and a picture with labelled axes, drawn where it is told."""
    xarray = pytest.importorskip("xarray")
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    plt = (
        matplotlib.pyplot
        if hasattr(matplotlib, "pyplot")
        else __import__("matplotlib.pyplot").pyplot
    )
    results = [
        vi.lyapunov(EQUAL, 1.04, np.linspace(6, 40, 4), cycles=200),
        sweeps,
        plane,
        vi.response(EQUAL, [1.0, 1.02], clearance=25.0, states=4),
    ]
    for result in results:
        assert isinstance(result.to_xarray(), xarray.Dataset)
        figure, ax = plt.subplots()
        assert result.plot(ax=ax) is ax
        assert ax.get_xlabel()
        assert ax.get_ylabel()
        plt.close(figure)
    table = plane.to_xarray()
    np.testing.assert_array_equal(table["label"].transpose("x", "x_dot"), plane.labels)
    table = sweeps.to_xarray()
    np.testing.assert_array_equal(table["clearance"], sweeps.values)
    with pytest.raises(vi.errors.ParameterError, match="quantity"):
        sweeps.plot(quantity="colour")


def stopped(monkeypatch, study, *arguments, **more):
    """What a study has finished that is stopped when about a third of its work is done."""
    monkeypatch.setattr(importlib.import_module("vibroimpact.interrupt"), "INTERVAL", 0.001)

    def progress(share, what):
        if share > 0.3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as stop:
        study(*arguments, **more, progress=progress)
    return stop.value.result


def test_stopped_lyapunov(monkeypatch):
    """The points that are finished have the bits of the whole line."""
    line = np.linspace(10, 24, 300)
    part = stopped(monkeypatch, vi.lyapunov, EQUAL, 1.04, line, cycles=4000)
    whole = vi.lyapunov(EQUAL, 1.04, line, cycles=4000)
    at = np.searchsorted(line, part.clearance)
    assert 0 < part.r.size < line.size
    np.testing.assert_array_equal(part.clearance, line[at])
    np.testing.assert_array_equal(part.exponents, whole.exponents[:, at])
    np.testing.assert_array_equal(part.impacts, whole.impacts[at])


def test_stopped_response(monkeypatch):
    """The frequency ratios that are finished have the bits of the whole curve."""
    r = np.linspace(1.0, 1.02, 200)
    part = stopped(monkeypatch, vi.response, EQUAL, r, 33.0, states=12)
    whole = vi.response(EQUAL, r, 33.0, states=12)
    at = np.searchsorted(r, part.r)
    assert 0 < part.r.size < r.size
    np.testing.assert_array_equal(part.attenuation, whole.attenuation[at])
    np.testing.assert_array_equal(part.highest, whole.highest[at])


def test_stopped_bifurcation(monkeypatch):
    """Sweeps have the impacts of the whole diagram as far as they came, and none beyond."""
    values = np.linspace(50, 75, 400)
    part = stopped(monkeypatch, vi.bifurcation_diagram, EQUAL, "clearance", values, r=1.04)
    whole = vi.bifurcation_diagram(EQUAL, "clearance", values, r=1.04)
    done = part.status == 0
    assert 0 < done.sum() < done.size
    assert vi.status_text(int(part.status.max())) == "it was stopped before this point was computed"
    # up from the left, down from the right
    assert (np.diff(done[0].astype(int)) <= 0).all()
    assert (np.diff(done[1].astype(int)) >= 0).all()
    there = done[whole.points["run"], whole.points["index"]]
    assert part.points.tolist() == whole.points[there].tolist()
    assert (part.cycles[~done] == 0).all()
    assert np.isnan(part.x_max[~done]).all()


def test_stopped_basins(monkeypatch):
    """States that were decided go where they go in the whole plane; the others are not decided."""
    plane = (("x", -30, 30, 120), ("x_dot", -30, 30, 120))
    part = stopped(monkeypatch, vi.basins, TABLE, 0.94, 37.0, plane)
    whole = vi.basins(TABLE, 0.94, 37.0, plane)
    done = part.labels >= 0
    assert 0 < done.sum() < done.size

    def ends(result, where):
        x = np.array([item.motion.X[0] if item.motion else np.nan for item in result.attractors])
        return x[result.labels[where]]

    np.testing.assert_array_equal(ends(part, done), ends(whole, done))


def test_stopped_before_anything(monkeypatch):
    """A single point has no part: a plain interrupt."""
    monkeypatch.setattr(importlib.import_module("vibroimpact.interrupt"), "INTERVAL", 0.001)

    def progress(share, what):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as stop:
        vi.lyapunov(EQUAL, 1.04, 20.0, cycles=10**8, progress=progress)
    assert not isinstance(stop.value, vi.errors.StudyInterrupted)


def test_progress_changes_nothing(monkeypatch):
    """What is told goes from 0 to 1, and the answer is the same to the last bit."""
    monkeypatch.setattr(importlib.import_module("vibroimpact.interrupt"), "INTERVAL", 0.001)
    shares = []
    line = np.linspace(10, 24, 100)
    told = vi.lyapunov(
        EQUAL, 1.04, line, cycles=2000, progress=lambda share, what: shares.append(share)
    )
    assert shares == sorted(shares)
    assert 0 <= shares[0] <= shares[-1] <= 1
    np.testing.assert_array_equal(told.exponents, vi.lyapunov(EQUAL, 1.04, line, 2000).exponents)
