"""Derivatives of trajectories through impacts and rests, compared with differences with 100 digits and laws."""

import math

import numpy as np
import pytest
import reference_simulation as rs
import vibroimpact as vi
from mpmath import mp, mpf
from shared_motions import COLUMN
from shared_systems import RIG, TABLE

STATE = ("t", "x", "x_dot", "z", "z_dot")
SYSTEM = ("r", "clearance", "xi", "mu", "R1", "R2", "load")
#: Nine impacts on both walls; accumulating impacts, two rests, and an impact between the rests.
FLYING = dict(
    zip(STATE + SYSTEM, [0.3, 0.1, 0.2, 0.4, 1.5, 0.9, 6.0, 0.02, 0.1, 0.8, 0.6, 1.1], strict=True)
)
RESTING = dict(
    zip(STATE + SYSTEM, [0.3, 0.1, 1.2, 0.4, 2.5, 0.5, 4.0, 0.05, 0.2, 0.5, 0.3, 1.0], strict=True)
)


def simulated(values, cycles):
    """The package's trajectory."""
    osc = vi.Oscillator(xi=values["xi"], mu=values["mu"], restitution=(values["R1"], values["R2"]))
    start = {name: values[name] for name in STATE}
    return vi.simulate(osc, values["r"], values["clearance"], cycles, start, load=values["load"])


def followed(values, cycles):
    """Events and the final state, with 100 digits."""
    walls = (values["R1"], values["R2"])
    names = (values[name] for name in ("r", "clearance", "load"))
    system = rs.System(values["xi"], values["mu"], walls, *names)
    start = rs.State(*(mpf(values[name]) for name in STATE))
    span = 2 * mp.pi * cycles / values["r"]
    events = rs.simulate(system, start, 10**6, limit=span)
    last = events[-1]
    move = rs.fly if last.kind != "stick" else rs.roll
    side = () if last.kind != "stick" else (last.side,)
    return events, move(system, last.after, *side, start.t + span - last.after.t)


def difference(ahead, behind, step):
    """Central difference of a function with 100 digits."""
    return float((ahead - behind) / (2 * step))


def differences(values, cycles, name):
    """Derivatives of the states after all events and of the final state, by one parameter."""
    step = mpf(10) ** -25
    ahead, behind = (
        followed(values | {name: mpf(values[name]) + change}, cycles) for change in (step, -step)
    )
    states = [(e.after, f.after) for e, f in zip(ahead[0], behind[0], strict=True)]
    return np.array([
        [difference(getattr(a, key), getattr(b, key), step) for key in ("t", "x", "v", "z", "w")]
        for a, b in [*states, (ahead[1], behind[1])]
    ])  # fmt: skip


@pytest.mark.parametrize("name", STATE + SYSTEM)
def test_agrees_with_differences_of_100_digits(name):
    """Times and velocities of all impacts, and the final state, to 1e-10 of the largest derivative."""
    run = simulated(FLYING, 3)
    gradient = run.gradient()
    assert len(run.events) == 9
    expected = differences(FLYING, 3, name)
    columns = ("time", "x", "x_dot_after", None, "z_dot_after")
    for i, column in enumerate(columns):
        if column:
            scale = 1e-10 * np.abs(gradient[column]).max()
            assert gradient[column, name] == pytest.approx(expected[:-1, i], abs=scale), column
    for i, key in enumerate(STATE):
        scale = 1e-10 * np.abs(gradient[f"final_{key}"]).max()
        assert gradient[f"final_{key}", name] == pytest.approx(expected[-1, i], abs=scale), key


@pytest.mark.slow
@pytest.mark.parametrize("name", ["z_dot", "r", "clearance", "xi", "mu", "R1", "R2", "load"])
def test_agrees_through_rest(name):
    """The final state after accumulations and rests.

    The package sums an accumulation to its limit from departure speeds of 1e-6 on, where the derivative is that of
    the limit.
    """
    run = simulated(RESTING, 3)
    gradient = run.gradient()
    assert (run.events["kind"] == "release").sum() >= 2
    expected = differences(RESTING, 3, name)[-1]
    for i, key in enumerate(STATE):
        scale = 1e-9 * np.abs(gradient[f"final_{key}"]).max()
        assert gradient[f"final_{key}", name] == pytest.approx(expected[i], abs=scale), key


def test_unit_of_length():
    """Scaling all lengths, including the load, scales lengths and velocities, and leaves times unchanged."""
    gradient = simulated(FLYING, 3).gradient()
    for name, values in gradient.values.items():
        lengths = ("x", "x_dot", "z", "z_dot", "clearance", "load")
        scaled = sum(FLYING[length] * gradient[name, length] for length in lengths)
        expected = 0 if name in ("time", "final_t") else values
        size = np.abs(gradient[name]).max()
        assert scaled == pytest.approx(expected, abs=1e-12 * size), name
        both = gradient[name, "R1"] + gradient[name, "R2"]
        assert gradient[name, "R"] == pytest.approx(both, rel=1e-14, abs=1e-14 * size)


def test_period_has_the_multipliers():
    """Over a period the derivative of the final by the initial state has the multipliers as eigenvalues."""
    motion = vi.exact(TABLE, 0.94, 37.0, COLUMN)
    middle = motion.sample(motion.alpha[1] / motion.r / 2)
    start = {"t": motion.load_phase / motion.r + motion.alpha[1] / motion.r / 2}
    start |= {"x": middle.X, "x_dot": middle.X_dot, "z": middle.Z, "z_dot": middle.Z_dot}
    start = {name: float(value) for name, value in start.items()}
    gradient = vi.simulate(TABLE, 0.94, 37.0, 1, start).gradient()
    rows = [[gradient[f"final_{row}", column] for column in STATE[1:]] for row in STATE[1:]]
    found = np.linalg.eigvals(np.array(rows))
    for multiplier in motion.multipliers:
        assert np.abs(found - multiplier).min() < 1e-11
    law = math.exp(-4 * math.pi * TABLE.xi / 0.94) * 0.75**4
    assert np.linalg.det(np.array(rows)) == pytest.approx(law, rel=1e-11)


def test_period_with_rest_has_the_multipliers():
    """A rest leaves two directions: two multipliers are 0."""
    run = vi.simulate(RIG, 0.9, 6.0, cycles=8, discard=200)
    motion = vi.exact(RIG, 0.9, 6.0, run)
    release = run.events[run.events["kind"] == "release"][0]
    middle = float(release["time"]) + 0.2
    state = run.sample(middle)
    start = {"t": middle, "x": state.X, "x_dot": state.X_dot, "z": state.Z, "z_dot": state.Z_dot}
    gradient = vi.simulate(
        RIG, 0.9, 6.0, 1, {name: float(value) for name, value in start.items()}
    ).gradient()
    rows = [[gradient[f"final_{row}", column] for column in STATE[1:]] for row in STATE[1:]]
    found = np.linalg.eigvals(np.array(rows))
    for multiplier in motion.multipliers[:2]:
        assert np.abs(found - multiplier).min() < 1e-7
    assert (np.abs(found) < 1e-7).sum() == 2


def test_starts_at_rest():
    """Where the free mass rests at the start, it has no independent velocity to vary."""
    run = vi.simulate(RIG, 0.9, 6.0, cycles=8, discard=200)
    stick = run.events[run.events["kind"] == "stick"][0]
    start = {"t": float(stick["time"]) + 0.01}
    state = run.sample(start["t"])
    start |= {"x": float(state.X), "x_dot": float(state.X_dot), "z_dot": float(state.X_dot)}
    side = 1 if stick["side"] == "R" else -1
    start["z"] = start["x"] + side * 3.0
    resting = vi.simulate(RIG, 0.9, 6.0, 1, start)
    assert resting.initial_state["resting"]
    gradient = resting.gradient()
    assert np.isnan(gradient["final_x", "z"])
    assert np.isnan(gradient["final_x", "z_dot"])
    assert "rests on a wall" in gradient.status["z, z_dot"]
    assert np.isfinite(gradient["final_x", "x"])
    h = 1e-5
    changed = [
        vi.simulate(RIG, 0.9, 6.0, 1, start | {"x": start["x"] + d, "z": start["z"] + d})
        for d in (h, -h)
    ]
    slope = (changed[0].final_state["x_dot"] - changed[1].final_state["x_dot"]) / (2 * h)
    assert gradient["final_x_dot", "x"] == pytest.approx(slope, rel=1e-6)


def test_continues():
    """The derivative over two parts is the product of the derivatives over each."""
    whole = simulated(FLYING, 4).gradient()
    first = simulated(FLYING, 2)
    second = vi.simulate(first.osc, first.r, first.clearance, 2, first.final_state, load=first.load)

    def matrix(gradient):
        return np.array([gradient[f"final_{key}"][:5] for key in STATE])

    product = matrix(second.gradient()) @ matrix(first.gradient())
    assert matrix(whole) == pytest.approx(product, abs=1e-11 * np.abs(product).max())


def test_no_derivative_after_a_graze():
    """After an impact without approach speed derivatives are NaN, and the status names it."""
    run = simulated(FLYING, 3)
    events = run.events.copy()
    events["z_dot_before"][5] = events["x_dot_before"][5]
    gradient = run.__replace__(events=events).gradient()
    assert "graze" in gradient.status["events[5:]"]
    assert np.isfinite(gradient["time"][:5]).all()
    assert np.isnan(gradient["time"][5:]).all()
    assert np.isnan(gradient["final_x"]).all()


def test_refuses_what_is_cut_short():
    """A trajectory that reached max_events ends at an event, not after a given number of cycles."""
    run = vi.simulate(RIG, 0.9, 6.0, cycles=8, max_events=3, state=None)
    assert not run.complete
    with pytest.raises(vi.ParameterError, match="must be complete"):
        run.gradient()


def test_without_events():
    """Free flight: the derivatives of the closed form, and no events."""
    start = {"t": 0.0, "x": 0.3, "x_dot": 0.1, "z": 0.2, "z_dot": 0.0}
    run = vi.simulate(TABLE, 0.5, 50.0, 1, start)
    gradient = run.gradient()
    assert gradient["time"].shape == (0, 13)
    t = run.final_state["t"]
    decay, frequency = TABLE.xi, math.sqrt(1 - TABLE.xi**2)
    sine = math.exp(-decay * t) * math.sin(frequency * t) / frequency
    assert gradient["final_x", "x_dot"] == pytest.approx(sine, rel=1e-13)
    assert gradient["final_z", "z_dot"] == pytest.approx(t, rel=1e-14)
    assert gradient["final_t", "r"] == pytest.approx(-t / 0.5, rel=1e-14)
