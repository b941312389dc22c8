"""States of simulations, and the laws that every simulation obeys."""

import numpy as np
import pytest
import reference_simulation as rs
import vibroimpact as vi
from shared_systems import EPS, RIG

STATE = ("t", "x", "x_dot", "z", "z_dot")
COLUMNS = ("x", "x_dot_before", "x_dot_after", "z_dot_before", "z_dot_after")


def state(t=0.0, x=0.0, x_dot=0.0, z=0.0, z_dot=0.0):
    """Return a state in the form that callers pass."""
    return {"t": t, "x": x, "x_dot": x_dot, "z": z, "z_dot": z_dot}


def plain(full):
    """Return the five numbers of a final state, without the entries needed to continue bit for bit."""
    return {name: full[name] for name in STATE}


def system(osc, r, clearance, load=1.0):
    """Return the same system in the form of the reference."""
    return rs.System(osc.xi, osc.mu, osc.restitution, r, clearance, load)


def signs(events):
    """Return +1 for right and -1 for left, for each event."""
    return np.where(events["side"] == "R", 1.0, -1.0)


def settled(cycles=4, discard=300):
    """Return a run with one impact on the right wall, chatter and rest on the left."""
    return vi.simulate(RIG, 0.9, 6.0, cycles, discard=discard)


def assert_laws(run):
    """Assert order, approach, restitution and momentum at every event, and that no wall is passed in between."""
    events, osc = run.events, run.osc
    side = signs(events)
    ends = [run.initial_state["t"], *events["time"], run.final_state["t"]]
    assert np.all(np.diff(ends) >= -4 * EPS * np.abs(ends).max())
    speed = np.abs([events[name] for name in COLUMNS[1:]]).max(0, initial=0.0) + 1e-300
    approach = side * (events["z_dot_before"] - events["x_dot_before"])
    departure = side * (events["x_dot_after"] - events["z_dot_after"])
    impact = events["kind"] == "impact"
    restitution = np.where(events["side"] == "R", *osc.restitution)
    assert np.all(approach >= -4 * EPS * speed)
    assert np.all(np.abs(departure - restitution * approach)[impact] <= 16 * EPS * speed[impact])
    change = (
        events["x_dot_after"]
        - events["x_dot_before"]
        + osc.mu * (events["z_dot_after"] - events["z_dot_before"])
    )
    assert np.all(np.abs(change) <= 16 * EPS * (1 + osc.mu) * speed)
    assert np.all((approach == 0) & (departure == 0) | impact)
    times = np.linspace(run.initial_state["t"], run.final_state["t"], 4001)[1:-1]
    history = run.sample(times)
    size = max(1.0, run.clearance, np.abs(history.X).max())
    assert np.abs(history.Y).max() <= 0.5 * run.clearance + 1e-11 * size
    assert history.Y == pytest.approx(history.Z - history.X, abs=4 * EPS * np.abs(history.Z).max())


def energy(osc, x, x_dot, z_dot):
    """Kinetic and elastic energy, M = K = 1."""
    return 0.5 * (x_dot**2 + x**2 + osc.mu * z_dot**2)


def assert_energy_is_accounted_for(run, tolerance=1e-10):
    """Assert that load, damper and impacts account for every change of energy.

    Power of load and damper are integrated by Gauss and Legendre in each segment, in pieces no
    longer than 0.5.
    """
    osc, events = run.osc, run.events
    begin, end = run.initial_state["t"], run.final_state["t"]
    grid = np.linspace(begin, end, int((end - begin) * max(1.0, run.r) / 0.5) + 2)
    edges = np.unique(np.concatenate([grid, events["time"]]))
    edges = edges[(edges >= begin) & (edges <= end)]
    nodes, weights = np.polynomial.legendre.leggauss(12)
    half = 0.5 * np.diff(edges)
    times = edges[:-1, None] + half[:, None] * (1 + nodes)
    h = run.sample(np.clip(times, begin, end))
    power = h.load * h.X_dot - 2 * osc.xi * h.X_dot**2
    work = np.concatenate([[0.0], np.cumsum((power * weights).sum(1) * half)])
    after = energy(osc, events["x"], events["x_dot_after"], events["z_dot_after"])
    before = energy(osc, events["x"], events["x_dot_before"], events["z_dot_before"])
    loss = before - after
    approach = events["z_dot_before"] - events["x_dot_before"]
    restitution = np.where(events["side"] == "R", *osc.restitution)
    reduced = osc.mu / (1 + osc.mu)
    size = max(1.0, before.max(initial=0.0))
    assert loss == pytest.approx(
        0.5 * reduced * (1 - restitution**2) * approach**2, abs=64 * EPS * size
    )
    s = run.initial_state
    start = energy(osc, s["x"], s["x_dot"], s["z_dot"])
    balance = start + np.interp(events["time"], edges, work) - np.cumsum(loss) - after
    assert np.abs(balance).max(initial=0.0) <= tolerance * size
    s = run.final_state
    final = start + work[-1] - loss.sum() - energy(osc, s["x"], s["x_dot"], s["z_dot"])
    assert abs(final) <= tolerance * size
