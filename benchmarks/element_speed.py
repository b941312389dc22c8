"""Simulation with stops and friction: cost of an event, compared with heyoka and SciPy, restarted at each event.

The systems are a driven mass that meets a stop of 100 times its stiffness, and a driven mass with dry friction
strong enough to stick. Both sides must find the same events. A contact with the stop is two events.

Further rows compare structures with each other, in turns: the two masses of 1983 with friction in the slot, or
with elastic stops in place of the walls, and the same masses with rigid walls alone, joined by a weak spring, so
that the general path is taken; a driven mass with an elastic stop, and one with a rigid wall; and a chain of
12 masses with 1 to 12 elements, whose cost must grow linearly.

Run with `python benchmarks/element_speed.py` (the rows of SciPy and heyoka need these).
"""

import math
import time

import numpy as np
import taylor_peer
import vibroimpact as vi
from table import row, show

ROUNDS = 5
#: Load cycles: ours, and the first of them by SciPy and by heyoka.
CYCLES, FEW, MORE = 2000, 40, 400
STOP, SLIP = 100.0, 0.6
#: Speed below which heyoka, which knows no departures from a zero, sees a halt.
ROUNDING = 1e-12


def spent(work, rounds):
    """Least CPU time of a call (s), and its result."""
    best = np.inf
    for _ in range(rounds):
        start = time.process_time()
        result = work()
        best = min(best, time.process_time() - start)
    return best, result


def systems():
    """Structures and loads by name, with what SciPy integrates."""
    stop = vi.Structure([1], [0.1], [1], [vi.Stop([1], 1.0, STOP)])
    slider = vi.Structure([1], [0.02], [1], friction=[vi.Friction([1], SLIP)])
    return {
        "an elastic stop": (stop, 1.0, scipy_stop, heyoka_stop),
        "friction with stick": (slider, 0.4, scipy_friction, heyoka_friction),
    }


def scipy_stop(solve, end):
    """Times at which the stop is touched and left."""
    return integrated(
        solve, end, False,
        lambda t, y, presses: [
            y[1], math.cos(t) - 0.1 * y[1] - y[0] - (STOP * (y[0] - 1) if presses else 0.0)
        ],
        lambda t, y, presses: (1 - y[0]) * (-1 if presses else 1),
        lambda t, y, presses: not presses,
    )  # fmt: skip


def scipy_friction(solve, end):
    """Times at which the mass halts and slips."""

    def drive(t, y):
        return math.cos(0.4 * t) - y[0]

    def after(t, y, sense):
        if sense and abs(drive(t, y)) <= SLIP:
            y[1] = 0.0
            return 0
        return 1 if drive(t, y) > 0 else -1

    return integrated(
        solve, end, 0,
        lambda t, y, sense: [y[1], drive(t, y) - 0.02 * y[1] - SLIP * sense] if sense else [0.0, 0.0],
        lambda t, y, sense: sense * y[1] if sense else SLIP - abs(drive(t, y)),
        after, start=lambda t, y: after(t, y, 0) if abs(drive(t, y)) > SLIP else 0,
    )  # fmt: skip


def integrated(solve, end, regime, motion, limit, after, start=None):
    """Times of events, at each of which the integration is restarted in another regime.

    Steps are bounded where nothing moves: they would grow beyond events.
    """
    t, y, times = 0.0, np.zeros(2), []
    if start:
        regime = start(t, y)

    def falls(t, y, regime):
        return limit(t, y, regime)

    falls.terminal, falls.direction = True, -1
    while t < end:
        still = start is not None and regime == 0
        found = solve(
            motion, (t, end), y, method="DOP853", rtol=1e-10, atol=1e-12, events=falls, args=(regime,),
            max_step=0.5 if still else np.inf,
        )  # fmt: skip
        t, y = found.t[-1], found.y[:, -1].copy()
        if found.status == 1:
            times.append(t)
            regime = after(t, y, regime)
    return np.array(times)


def heyoka_stop():
    """A function for the times at which the stop is touched and left; in contact the regime is 1, else -1."""
    import heyoka as hy

    return taylor_peer.switching(
        lambda x, v, p: (v, hy.cos(hy.time) - 0.1 * v - x - 0.5 * (1.0 + p) * STOP * (x - 1.0)),
        lambda x, v, p: [p * (x - 1.0)],
        [lambda t, state, p: -p],
        start=-1.0,
    )


def heyoka_friction():
    """A function that gives the times at which the mass halts and slips; the regime is the direction of slip, 0 in
    stick. An event that cannot happen in a regime is 1 there."""
    import heyoka as hy

    def drive(t, x):
        return math.cos(0.4 * t) - x

    def halts(t, state, p):
        state[1] = 0.0
        return 0.0 if abs(drive(t, state[0])) <= SLIP else math.copysign(1.0, drive(t, state[0]))

    def force(x):
        return hy.cos(0.4 * hy.time) - x

    return taylor_peer.switching(
        lambda x, v, p: (p * p * v, p * p * (force(x) - 0.02 * v - SLIP * p)),
        lambda x, v, p: [
            p * v + ROUNDING + (1.0 - p * p), (1.0 - p * p) * (SLIP * SLIP - force(x) * force(x)) + p * p,
        ],
        [halts, lambda t, state, p: math.copysign(1.0, drive(t, state[0]))],
        start=1.0,
    )  # fmt: skip


def agree(times, known, end):
    """Whether a peer finds the same events, those at the start and near the end left out."""
    known = known[(known > 1e-9) & (known < end - 1e-3)]
    times = times[times > 1e-9]
    return len(times) >= len(known) and bool(np.abs(times[: len(known)] - known).max() < 1e-6)


def stop_like(direction, opening, restitution, mass):
    """An elastic stop that reflects a mass nearly as a rigid wall does."""
    decrement = -math.log(restitution)
    damping = decrement / math.hypot(math.pi, decrement)
    return vi.Stop(direction, opening, STOP, 2 * damping * math.sqrt(STOP * mass))


def pair(friction=0.0, elastic=False):
    """The two masses of 1983, which a weak spring keeps from the kernel of the oscillator."""
    spring = 1e-3 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    reduced = 1 / (1 + 1 / 0.028)
    gaps = [
        stop_like(d, 12.5, 0.75, reduced) if elastic else vi.Gap(d, 12.5, 0.75)
        for d in ([-1, 1], [1, -1])
    ]
    slot = [vi.Friction([-1, 1], friction)] if friction else []
    s = vi.Structure([1, 0.028], [0.0228, 0], np.diag([1.0, 0]) + spring, gaps, slot)
    return s, vi.Load(1.04, sine=[1.0, 0.0])


def mass(elastic):
    """A driven mass that meets a wall or an elastic stop once a cycle."""
    limit = stop_like([1], 1.0, 0.8, 1.0) if elastic else vi.Gap([1], 1.0, 0.8)
    return vi.Structure([1], [0.1], [1], [limit]), vi.Load(1.0, cosine=[1.0])


def chain(elements):
    """A chain of 12 masses, and elements of three kinds on the first of them."""
    n = 12
    stiffness = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    kinds = (
        lambda d: vi.Stop(d, 0.5, 20.0, 0.5),
        lambda d: vi.Friction(d, 0.02),
        lambda d: vi.Gap(d, 0.5, 0.7),
    )
    parts = [kinds[i % 3](np.eye(n)[i]) for i in range(elements)]
    friction = [part for part in parts if isinstance(part, vi.Friction)]
    gaps = [part for part in parts if not isinstance(part, vi.Friction)]
    s = vi.Structure(np.ones(n), 0.05 * stiffness, stiffness, gaps, friction)
    return s, vi.Load(0.8, cosine=np.ones(n))


def event_costs(systems, cycles):
    """Microseconds of an event of each system, the least of several turns; those of the regimes are met before."""
    best = np.full(len(systems), np.inf)
    for _ in range(ROUNDS):
        for i, (structure, load) in enumerate(systems):
            seconds, run = spent(
                lambda s=structure, w=load: vi.simulate(
                    s, w, cycles=cycles, discard=20, max_events=10**7
                ),
                1,
            )
            best[i] = min(best[i], 1e6 * seconds * cycles / (cycles + 20) / len(run.events))
    return best


def growth():
    """Rows of the pair and of a mass, and of the chain; a contact with a stop is two events."""
    plain, slot, soft = event_costs([pair(), pair(0.05), pair(elastic=True)], CYCLES)
    hard, give = event_costs([mass(False), mass(True)], CYCLES)
    table = [
        row("the pair with friction: an event", "µs", slot, 1.5 * plain, plain, "without friction"),
        row("the pair with stops: a contact", "µs", 2 * soft, 2 * plain, plain, "rigid impact"),
        row("a mass with a stop: a contact", "µs", 2 * give, 2 * hard, hard, "rigid impact"),
    ]
    many = [1, 2, 3, 4, 5, 6, 12]
    costs = event_costs([chain(m) for m in many], 300)
    line = np.polyfit(many, costs, 1)
    for m, cost in zip(many, costs, strict=True):
        table.append(
            row(
                f"a chain with {m} element{'s' * (m > 1)}: an event",
                "µs",
                cost,
                None,
                np.polyval(line, m),
                "a straight line",
            )
        )
    return table


def rows():
    try:
        from scipy.integrate import solve_ivp
    except ImportError:
        solve_ivp = None
    table = []
    for name, (structure, frequency, by_scipy, by_heyoka) in systems().items():
        load = vi.Load(frequency, cosine=[1.0])
        ours, run = spent(
            lambda s=structure, w=load: vi.simulate(
                s, w, cycles=CYCLES, state=([0.0], [0.0]), max_events=10**6
            ),
            ROUNDS,
        )
        cost, peers = 1e6 * ours / len(run.events), []
        if solve_ivp:
            end = FEW * 2 * math.pi / frequency
            peers.append(("SciPy", end, *spent(lambda p=by_scipy, e=end: p(solve_ivp, e), 1)))
        if taylor_peer.here():
            # compiled beforehand
            end, peer = MORE * 2 * math.pi / frequency, by_heyoka()
            peers.append(("heyoka", end, *spent(lambda p=peer, e=end: p(e), ROUNDS)))
        for label, end, seconds, times in peers:
            same = agree(times, run.events["time"], end)
            table.append(
                row(f"{name}: an event", "µs", cost, None, 1e6 * seconds / len(times), label, same)
            )
        if not peers:
            table.append(row(f"{name}: an event", "µs", cost, None, None, "", None))
    return table + growth()


if __name__ == "__main__":
    raise SystemExit(0 if show(rows()) else 1)
