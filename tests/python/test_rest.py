"""Accumulations end at their limits, in a rest that obeys Newton's law."""

import itertools
import math

import numpy as np
import pytest
import reference_simulation as rs
import vibroimpact as vi
from mpmath import mpf
from shared_simulations import (
    assert_energy_is_accounted_for,
    assert_laws,
    energy,
    plain,
    settled,
    state,
    system,
)
from shared_systems import RIG, TURN


def accumulating():
    """A simple state of the example half a time unit after a release, and its system."""
    run = settled(2)
    release = run.events[run.events["kind"] == "release"][0]
    history = run.sample(release["time"] + 0.5)
    numbers = [float(history[i]) for i in range(4)]
    first = state(release["phase"] / 0.9 + 0.5, *numbers)
    return first, system(RIG, 0.9, 6.0)


def test_limit_of_an_accumulation_against_140_impacts():
    """Time, position and speed at the limit of an accumulation, and at the release, agree with the reference.

    The reference follows the impacts until the flights last 1e-30. The claimed error of the time
    is 1e-16; rounding in the flights before, and its growth, adds to it.
    """
    first, its_system = accumulating()
    expected = rs.simulate(its_system, rs.start(**first), 400, limit=7)
    ends = [event for event in expected if event.kind != "impact"]
    run = vi.simulate(RIG, 0.9, 6.0, 1, first)
    mine = run.events[run.events["kind"] != "impact"]
    assert [event.kind for event in ends] == ["stick", "release"]
    assert mine["kind"].tolist()[:2] == ["stick", "release"]
    assert sum(event.kind == "impact" for event in expected) > 120
    assert (run.events["kind"] == "impact").sum() < 60
    names = ("time", "x", "x_dot_after", "z_dot_after")
    for one, other in zip(mine, ends, strict=False):
        got = [float(one[name]) for name in names]
        want = [float(v) for v in (other.after.t, other.after.x, other.after.v, other.after.w)]
        assert got == pytest.approx(want, abs=2e-12)


@pytest.mark.parametrize("restitution", [0.1, 0.5, 0.8])
@pytest.mark.parametrize("mu", [0.0, 2.0])
def test_accumulation_is_summed_not_cut_off(restitution, mu):
    """From one small bounce the limit is correct to 1e-15, for any R and mass ratio."""
    osc = vi.Oscillator(xi=0.2, mu=mu, restitution=restitution)
    first = state(x=1.0, z=2.0, z_dot=-0.02)
    run = vi.simulate(osc, 0.9, 2.0, 0.1, first)
    flat = system(osc, 0.9, 2.0)
    few = rs.simulate(flat, rs.start(**first), 2000, limit=mpf("0.6"))
    want = next(event for event in few if event.kind == "stick")
    stick = run.events[run.events["kind"] == "stick"][0]
    assert stick["side"] == "R"
    assert stick["time"] == pytest.approx(float(want.after.t), abs=2e-15)
    assert stick["x"] == pytest.approx(float(want.after.x), abs=1e-14)
    assert stick["x_dot_after"] == pytest.approx(float(want.after.v), abs=1e-14)


def rests(run):
    """Pairs (stick, release) of a trajectory: the rests that begin and end within it."""
    ends = run.events[run.events["kind"] != "impact"]
    return [(a, b) for a, b in itertools.pairwise(ends) if a["kind"] == "stick"]


def test_rest_obeys_newton_and_the_contact_pushes():
    """In rest both masses accelerate as one and the contact force pushes; the rest ends where it is zero."""
    run = settled(5)
    xi, mu, r = RIG.xi, RIG.mu, 0.9
    found = rests(run)
    assert len(found) == 4
    for stick, release in found:
        side = 1 if stick["side"] == "R" else -1
        times = np.linspace(stick["time"], release["time"], 200)[1:-1]
        h = run.sample(times)
        assert h.Y == pytest.approx(side * 3.0, abs=1e-13)
        assert np.array_equal(h.X_dot, h.Z_dot)
        step = 1e-4
        inner = times[(times > times[0] + step) & (times < times[-1] - step)]
        rate = (run.sample(inner + step).X_dot - run.sample(inner - step).X_dot) / (2 * step)
        at = run.sample(inner)
        assert (1 + mu) * rate == pytest.approx(
            np.sin(r * inner) - 2 * xi * at.X_dot - at.X, abs=1e-7
        )
        force = (np.sin(r * times) - 2 * xi * h.X_dot - h.X) * side / (1 + mu)
        assert np.all(force <= 1e-12)
        free = math.sin(release["phase"]) - 2 * xi * release["x_dot_after"] - release["x"]
        assert free == pytest.approx(0.0, abs=1e-12)
        assert r * math.cos(release["phase"]) * side > release["x_dot_after"] * side


def test_the_example_repeats_every_cycle():
    """In each cycle the example repeats one impact on one wall and a completed chatter with rest on the other."""
    run = settled(6)
    kinds = run.events["kind"]
    period = TURN / 0.9
    right = run.events[run.events["side"] == "R"]
    assert right["kind"].tolist() == ["impact"] * 6
    assert (kinds == "stick").sum() == (kinds == "release").sum() == 6
    assert set(run.events["side"][kinds != "impact"]) == {"L"}
    for kind in ("stick", "release"):
        times = run.events["time"][kinds == kind]
        assert np.diff(times) == pytest.approx(period, abs=1e-8)
    assert_laws(run)
    assert_energy_is_accounted_for(run)


def test_rest_that_never_ends():
    """A rest under a steady push of the spring, or without any motion, has no release."""
    osc = vi.Oscillator(xi=0.05, mu=0.1, restitution=0.2)
    run = vi.simulate(osc, 1e-3, 1.0, 1e-4, state(x=2.0, z=2.45), load=2.0)
    assert run.events["kind"].tolist()[-1] == "stick"
    assert run.final_state["t"] > run.events["time"][-1] + 0.1
    assert run.final_state["resting"]
    assert run.final_state["z"] - run.final_state["x"] == pytest.approx(0.5, abs=1e-15)
    still = vi.simulate(osc, 1.1, 1.0, 10**6, state(z=0.5), load=0.0)
    assert still.events.size == 0
    assert plain(still.final_state) | {"t": 0} == state(z=0.5)
    light = vi.Oscillator(xi=0.1, mu=0.0, restitution=0.0)
    soft = vi.simulate(light, 0.9, 2.0, 1000, state(z_dot=0.3), load=0.0)
    assert soft.events["kind"].tolist()[0] == "impact"
    assert soft.final_state["z"] == 1.0


def test_release_that_turns_into_chatter_again():
    """A release is followed by another accumulation and rest on the same wall."""
    osc, found = vi.Oscillator(xi=0.1, mu=0.5, restitution=(0.3, 0.5)), 0
    for r in (0.1, 0.15, 0.2):
        run = vi.simulate(osc, r, 0.5, 40, state(x_dot=0.3))
        assert_laws(run)
        assert_energy_is_accounted_for(run)
        events = run.events
        for i in np.flatnonzero(events["kind"] == "release"):
            later = events[i + 1 :]
            stop = np.flatnonzero(later["kind"] == "stick")
            found += bool(stop.size) and set(later["side"][: stop[0] + 1]) == {events["side"][i]}
        ends = events["kind"][events["kind"] != "impact"]
        assert ends.tolist() == (["stick", "release"] * len(ends))[: len(ends)]
    assert found > 100


def test_plastic_walls_rest_after_one_impact():
    """With R = 0 each rest begins at a single impact, and the velocities after each impact are equal."""
    osc = vi.Oscillator(xi=0.05, mu=0.3, restitution=0.0)
    run = vi.simulate(osc, 0.8, 0.7, 40)
    assert_laws(run)
    assert_energy_is_accounted_for(run)
    kinds, times = run.events["kind"], run.events["time"]
    sticks = np.flatnonzero(kinds == "stick")
    assert sticks.size > 10
    assert np.all(kinds[sticks - 1] == "impact")
    assert np.array_equal(times[sticks - 1], times[sticks])
    assert np.all(run.events["x_dot_after"] == run.events["z_dot_after"])


def test_elastic_walls_never_rest():
    """With R = 1 there is no rest, and without damping and load no energy is lost."""
    osc = vi.Oscillator(xi=0.0, mu=0.4, restitution=1.0)
    first = state(x=1.0, z=0.9, z_dot=0.3)
    run = vi.simulate(osc, 0.8, 0.5, 100, first, load=0.0)
    assert set(run.events["kind"]) == {"impact"}
    start, end = (
        energy(osc, s["x"], s["x_dot"], s["z_dot"]) for s in (run.initial_state, run.final_state)
    )
    assert end == pytest.approx(start, rel=1e-13 * run.events.size)


def test_without_load_the_frequency_ratio_does_not_matter():
    """Without load r has no effect, even at the undamped resonance of both masses, (1 + mu) r^2 = 1."""
    osc = vi.Oscillator(xi=0.0, mu=3.0, restitution=0.3)
    start = {"t": 0, "x": 3.0, "x_dot": 0.3, "z": 3.0, "z_dot": 1.0}
    runs = [vi.simulate(osc, r, 1.0, 6 * r, start, load=0.0) for r in (0.5, 0.7)]
    one, other = (run.events for run in runs)
    assert (one["kind"] == "stick").sum() > 0
    assert one["kind"].tolist() == other["kind"].tolist()
    np.testing.assert_allclose(one["time"], other["time"], rtol=1e-9)
    np.testing.assert_allclose(one["x"], other["x"], rtol=0, atol=1e-9)


@pytest.mark.parametrize("mu", [0.1, 2.0])
def test_an_impact_that_leaves_neither_speed_nor_acceleration(mu):
    """With R = 0 the masses move on together from x = 0, and part after half a period of their joint motion."""
    osc = vi.Oscillator(xi=0, mu=mu, restitution=0.0)
    run = vi.simulate(osc, 1.1, 2, 2, state(z_dot=1.0), load=0)
    assert run.events["kind"].tolist()[:3] == ["impact", "stick", "release"]
    half = math.pi * math.sqrt(1 + mu)
    assert run.events["time"][:3] == pytest.approx([1, 1, 1 + half], abs=1e-14)
    v = mu / (1 + mu)
    t = np.linspace(0.1, 0.9 * half, 5)
    sampled = run.sample(1 + t)
    assert sampled[0] == pytest.approx(
        v * math.sqrt(1 + mu) * np.sin(t / math.sqrt(1 + mu)), abs=1e-14
    )


@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("x_dot", [1.0, -1.0])
def test_masses_that_touch_without_acceleration_part_by_the_next_derivative(restitution, x_dot):
    """At x = 0 the primary mass has no acceleration: its velocity decides on which wall the free mass stays."""
    osc = vi.Oscillator(xi=0, mu=0.5, restitution=restitution)
    for side in (1, -1):
        run = vi.simulate(osc, 1.1, 2, 1, state(x_dot=x_dot, z=float(side), z_dot=x_dot), load=0)
        apart = 1 - side * (run.sample(0.5)[2] - run.sample(0.5)[0])
        if side * x_dot > 0:
            assert apart == pytest.approx(0, abs=1e-15)
            assert run.events["kind"][0] == "release"
        else:
            # z = side + x_dot t, x = x_dot sin t
            assert apart == pytest.approx(0.5 - math.sin(0.5), abs=1e-14)
        assert len(run.events) < 40
