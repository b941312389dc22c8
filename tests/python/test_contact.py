"""Every contact is found, and no spurious contact.

The reference numbers come from `reference_simulation` (100 digits, scan and bisection); the
rest are laws. The time of a contact that closes a gap slowly is known only to rounding of the gap over the
speed, and the tolerances follow from that.
"""

import numpy as np
import pytest
import reference_simulation as rs
import vibroimpact as vi
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp, mpf
from shared_simulations import assert_laws, signs, state, system
from shared_systems import EPS, TURN, law


@given(st.integers(0, 10**6), st.sampled_from([0.0, 1.0]))
@law(150)
def test_random_systems_obey_the_laws(seed, load):
    """For any parameters and state the simulation ends without an exception, and every law holds."""
    draw = np.random.default_rng(seed)
    wall = draw.choice([0.0, 1.0, -1.0], 2)
    restitution = np.where(wall < 0, draw.uniform(0, 1, 2), wall)
    osc = vi.Oscillator(
        xi=draw.choice([0, 0.005, draw.uniform(0, 0.9)]),
        mu=draw.uniform(0, 2),
        restitution=tuple(map(float, restitution)),
    )
    clearance = float(10 ** draw.uniform(-3, 3))
    x, x_dot, z_dot = 10 ** draw.uniform(-2, 2) * draw.normal(size=3)
    y = draw.choice([0.5, -0.5, draw.uniform(-0.5, 0.5)])
    first = state(draw.uniform(-50, 50), x, x_dot, x + y * clearance, draw.choice([z_dot, x_dot]))
    r = 0.05 * 100 ** draw.uniform()
    assert_laws(vi.simulate(osc, r, clearance, 10, first, load=load, max_events=5000))


def flight_peak(seed):
    """A random flight, and the greatest |z - x| within its first 12 units of time, in mpmath.

    Returns
    -------
    tuple
        Oscillator, r, first state, time of the peak, its height, and |y''| there.
    """
    draw = np.random.default_rng(seed)
    osc = vi.Oscillator(xi=[0.0, 0.01, 0.3][seed % 3], mu=0.1, restitution=0.5)
    r = float(draw.uniform(0.4, 2.5))
    first = state(*np.round(draw.uniform(-1, 1, 3), 6), z_dot=float(draw.uniform(-0.02, 0.02)))
    free, begin = system(osc, r, 1e3), rs.start(**first)
    grid = np.linspace(0.0, 12.0, 2401)[1:]
    long = vi.simulate(osc, r, 1e3, 12 * r / TURN, first)
    peak = int(np.argmax(np.abs(long.sample(first["t"] + 0.999999 * grid).Y)))
    if peak in (0, grid.size - 1):
        return None

    def rate(t):
        later = rs.fly(free, begin, t)
        return later.w - later.v

    bracket = mpf(float(grid[peak - 1])), mpf(float(grid[peak + 1]))
    top = mp.findroot(rate, bracket, solver="anderson")
    later = rs.fly(free, begin, top)
    return osc, r, first, top, abs(later.z - later.x), abs(rs.acceleration(free, later))


@pytest.mark.parametrize("over", [1e-3, 1e-6, 1e-9, 1e-12, -1e-12])
def test_overshoots_of_any_size_are_found(over):
    """51 states whose flight passes the wall by a fraction of d: all are found; a near miss is no impact."""
    count = 0
    for seed in range(80):
        flight = flight_peak(seed)
        if flight is None:
            continue
        osc, r, first, top, height, curvature = flight
        clearance = float(height / (mpf(1) / 2 + mpf(over)))
        run = vi.simulate(osc, r, clearance, float((top + 0.3) * r / TURN), first)
        excess = height - mpf(clearance) / 2
        hit = run.events["time"][:1]
        if over < 0:
            assert hit.size == 0
        else:
            assert hit.size == 1
            begin, side = rs.start(**first), signs(run.events)[0]
            guess = top - mp.sqrt(2 * excess / curvature)

            def close(t, clear=clearance, osc=osc, r=r, begin=begin, side=side):
                s = system(osc, r, clear)
                return rs.gap(s, rs.fly(s, begin, t), side)

            time = mp.findroot(close, guess)
            slope = float(mp.sqrt(2 * excess * curvature))
            error = abs(float(begin.t + time - mpf(float(hit[0]))))
            assert error <= 1e-14 + 32 * EPS * (1 + clearance) / slope
        count += 1
    assert count >= 51


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("speed", [1e-9, 1e-3, 1.0])
def test_contact_at_the_start(side, speed):
    """A mass on the wall that approaches has an impact at once; one that departs has none."""
    osc = vi.Oscillator(xi=0.01, mu=0.1, restitution=0.5)
    first = state(t=0.3, x=0.25, z=0.25 + side, z_dot=side * speed)
    hit = vi.simulate(osc, 0.9, 2.0, 0.01, first).events[0]
    assert hit["kind"] == "impact"
    assert hit["side"] == ("R" if side > 0 else "L")
    assert hit["time"] == pytest.approx(0.3, abs=1e-15)
    assert hit["z_dot_before"] - hit["x_dot_before"] == pytest.approx(side * speed, rel=1e-6)
    first["z_dot"] = -side * speed
    events = vi.simulate(osc, 0.9, 2.0, 1.0, first).events
    assert not events.size or events["time"][0] > 0.3 + 1e-10


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("speed", [1e-9, 1e-12, 1e-15])
def test_slow_approach_on_a_wall_that_recedes(side, speed):
    """An approach on the wall is an impact at once, however slow, even if the gap would open a moment later."""
    osc = vi.Oscillator(xi=0.05, mu=0.1, restitution=0.7)
    first = state(x=side * -0.5, z=side * 2.5, z_dot=side * speed)
    hit = vi.simulate(osc, 0.9, 6.0, 0.01, first, load=3.0).events[0]
    assert (hit["kind"], hit["time"]) == ("impact", 0.0)
    assert hit["side"] == ("R" if side > 0 else "L")
    approach = side * (hit["z_dot_before"] - hit["x_dot_before"])
    assert approach == pytest.approx(speed, abs=4 * EPS)


def test_idle_flight_ends_where_it_must():
    """A slow mass reaches its wall millions of time units later, after all oscillation has decayed."""
    osc = vi.Oscillator(xi=0.05, mu=0.1, restitution=0.7)
    for z_dot in (1e-6, -1e-6):
        run = vi.simulate(osc, 0.9, 6.0, 8e5, state(x=0.5, z_dot=z_dot), load=0.0, max_events=1)
        assert run.events["side"].tolist() == ["R" if z_dot > 0 else "L"]
        assert run.events["time"][0] == pytest.approx(3e6, rel=1e-14)


@pytest.mark.parametrize(("clearance", "speed"), [(1e-9, 1.0), (1.0, 1e9)])
def test_both_walls_within_1e_9(clearance, speed):
    """Impacts on both walls a billionth of a time unit apart are found one by one."""
    osc = vi.Oscillator(xi=0.01, mu=0.2, restitution=(0.9, 0.8))
    first = state(x=0.3, x_dot=0.1, z=0.3, z_dot=speed)
    run = vi.simulate(osc, 0.9, clearance, 1.0, first, max_events=20)
    expected = rs.simulate(system(osc, 0.9, clearance), rs.start(**first), 20)
    assert "".join(run.events["side"][:20]) == "".join("LR"[e.side > 0] for e in expected)
    for mine, its in zip(run.events, expected, strict=False):
        assert float(mine["time"]) == pytest.approx(float(its.after.t), rel=1e-6, abs=0)
        assert mine["z_dot_after"] == pytest.approx(float(its.after.w), rel=1e-12, abs=1e-12)


def test_very_long_flight_ends_at_the_first_crest_that_reaches():
    """With a slow drift of 1e-6 under an oscillation, a crest reaches the wall after 700,000 cycles."""
    osc, r, clearance, drift = vi.Oscillator(xi=0.1, mu=0.2, restitution=0.7), 1.3, 10.0, 1e-6
    amplitude = abs(1 / mp.mpc(1 - mpf(r) ** 2, 2 * mpf(0.1) * r))
    first = state(z_dot=drift)
    run = vi.simulate(osc, r, clearance, 10**6, first, max_events=1)
    hit = run.events[0]
    assert run.events.size == 1
    assert hit["side"] == "R"
    assert hit["time"] * drift + float(amplitude) == pytest.approx(5.0, abs=1e-5)
    flat = system(osc, r, clearance)
    crest = rs.fly(flat, rs.start(**first), mpf(float(hit["time"])))
    rate = float(crest.w - crest.v)
    assert abs(float(rs.gap(flat, crest, 1))) <= 1e-14 + rate * 4 * EPS * hit["time"]
    before = rs.fly(flat, rs.start(**first), mpf(float(hit["time"])) - 2 * mp.pi / r)
    crest_before = before.v**2 / (2 * abs(rs.acceleration(flat, before)))
    assert rs.gap(flat, before, 1) - crest_before > mpf(10) ** -7


@pytest.mark.parametrize("clearance", [1e-6, 1e-3, 1.0, 1e3, 1e6])
@pytest.mark.parametrize("load", [0.0, 1.0])
def test_clearances_of_all_sizes(clearance, load):
    """For parameters from a millionth to a million the laws hold, free and forced, with and without damping."""
    for xi in (0.0, 0.05):
        osc = vi.Oscillator(xi=xi, mu=0.1, restitution=(0.8, 0.6))
        first = state(x_dot=1.0, z_dot=clearance if clearance > 1 else 0.5)
        run = vi.simulate(osc, 0.9, clearance, 5, first, load=load, max_events=100_000)
        assert run.events.size > 0
        assert_laws(run)


@pytest.mark.parametrize(("osc", "r", "clearance"), [
    (vi.Oscillator(xi=0.1, mu=0.2, restitution=(0.8, 0.7)), 0.94, 2.0),
    (vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75), 0.94, 2.0),
    (vi.Oscillator(xi=0.0, mu=0.5, restitution=(1.0, 0.4)), 1.7, 0.5),
    (vi.Oscillator(xi=0.3, mu=1.5, restitution=(0.8, 0.9)), 2.1, 0.1),
])  # fmt: skip
def test_first_twenty_impacts_against_many_digits(osc, r, clearance):
    """Times, positions and velocities of the first 20 impacts agree to rounding times the growth of errors.

    The growth is measured by a change of the first state by 1e-9.
    """
    first = state(t=0.1, z=0.01)
    run = vi.simulate(osc, r, clearance, 30, first)
    other = vi.simulate(osc, r, clearance, 30, first | {"x": 1e-9})
    expected = rs.simulate(system(osc, r, clearance), rs.start(**first), 20)
    hits = run.events[run.events["kind"] == "impact"]
    expected = [event for event in expected if event.kind == "impact"]
    assert len(hits) >= len(expected) == 20
    names, growth = ("time", "x", "x_dot_after", "z_dot_after"), 1.0
    for mine, moved, its in zip(hits, other.events, expected, strict=False):
        assert ("R" if its.side > 0 else "L") == mine["side"]
        got = np.array([mine[name] for name in names])
        want = [float(v) for v in (its.after.t, its.after.x, its.after.v, its.after.w)]
        growth = max(growth, np.abs(got - [moved[name] for name in names]).max() / 1e-9)
        assert np.abs(got - want).max() <= 256 * EPS * growth
    assert growth < 1e6
