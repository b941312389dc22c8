"""How many grazing impacts are found: this package, SciPy's event detection by sign change, and heyoka's.

The primary mass is in its steady motion without impacts and the free mass is at rest in the middle. The clearance
is such that each half cycle the wall overshoots the free mass by a small share of d: one short contact, which is
there in every one of 51 runs that start at different phases. A search for sign changes at the ends of steps loses
those that begin and end within a step. heyoka isolates the zeros of its Taylor polynomials, and finds all.

Run with `python benchmarks/missed_impacts.py` (needs SciPy; heyoka if it is installed).
"""

import math

import taylor_peer
import vibroimpact as vi
from scipy.integrate import solve_ivp
from table import row, show

XI, R, RUNS = 0.0114, 0.94, 51
OSC = vi.Oscillator(xi=XI, mu=0.0, restitution=1.0)
AMPLITUDE = 1 / math.hypot(1 - R * R, 2 * XI * R)
LAG = math.atan2(2 * XI * R, 1 - R * R)


def start(run):
    """State of one run: time and the steady motion of the primary mass at it."""
    # from just after one greatest position until just after the next, the contact is still to come
    phase = math.pi / 2 + LAG + 0.3 + 2.2 * run / (RUNS - 1)
    x = AMPLITUDE * math.sin(phase - LAG)
    x_dot = AMPLITUDE * R * math.cos(phase - LAG)
    return {"t": phase / R, "x": x, "x_dot": x_dot, "z": 0.0, "z_dot": 0.0}


def found_here(state, clearance):
    """Whether this package finds an impact within half a cycle."""
    return len(vi.simulate(OSC, R, clearance, 0.5, state=state).events) > 0


def found_by_scipy(state, clearance):
    """Whether solve_ivp finds a gap that falls through 0 within half a cycle."""

    def motion(t, y):
        return [y[1], math.sin(R * t) - 2 * XI * y[1] - y[0], y[3], 0.0]

    def right(_, y):
        return 0.5 * clearance - (y[2] - y[0])

    def left(_, y):
        return 0.5 * clearance + (y[2] - y[0])

    for event in (right, left):
        event.terminal, event.direction = True, -1
    first = [state[name] for name in ("x", "x_dot", "z", "z_dot")]
    span = (state["t"], state["t"] + math.pi / R)
    answer = solve_ivp(
        motion, span, first, method="DOP853", rtol=1e-10, atol=1e-10, events=(right, left)
    )
    return any(times.size for times in answer.t_events)


def found_by_heyoka(states, clearance):
    """How many of the runs have an impact within half a cycle by heyoka."""
    integrator, times = taylor_peer.oscillator(XI, 0.0, 1.0, R, clearance)
    found = 0
    for state in states:
        times.clear()
        taylor_peer.restart(
            integrator, state["t"], [state[name] for name in ("x", "x_dot", "z", "z_dot")]
        )
        integrator.propagate_until(state["t"] + math.pi / R)
        found += len(times) > 0
    return found


def rows():
    """Impacts found of 51, by overshoot as a share of d."""
    answer = []
    for overshoot in (1e-2, 1e-3, 1e-4, 1e-6, 1e-9, 1e-12):
        clearance = 2 * AMPLITUDE / (1 + 2 * overshoot)
        states = [start(run) for run in range(RUNS)]
        here = sum(found_here(state, clearance) for state in states)
        scipy = sum(found_by_scipy(state, clearance) for state in states)
        work = f"impacts that overshoot by {overshoot:.0e} d"
        unit = f"of {RUNS} found"
        answer.append(row(work, unit, here, RUNS, scipy, "SciPy DOP853, rtol 1e-10"))
        if taylor_peer.here():
            there = found_by_heyoka(states, clearance)
            answer.append(row(work, unit, here, None, there, taylor_peer.NAME, here == there))
    return answer


if __name__ == "__main__":
    show(rows())
