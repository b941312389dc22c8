"""The vibroimpact oscillator with 100 digits: a slow, plain simulation to test the package against.

A flight is the exponential of the oscillator's 2 x 2 matrix plus the steady motion, both by mpmath.
A contact is bracketed by a dense scan of the gap and refined by bisection; an accumulation of
impacts is simulated impact by impact until the flights are shorter than 1e-30; rest is the joint
oscillation, and it ends where a bisection finds that the contact force ends.

Units: time in 1/omega, length in F0/K; the load is f sin(r t).
"""

from dataclasses import dataclass

from mpmath import mp, mpf

mp.dps = 100
SCAN = mpf(1) / 50
"""Step of the scans for a contact and for the end of a rest; shorter events are missed."""
SHORTEST = mpf(10) ** -30
"""Flights shorter than this end an accumulation. Their gaps are about its square, 40 digits above
rounding."""


@dataclass(frozen=True)
class System:
    """Oscillator, load and clearance; restitution is (right, left)."""

    xi: float
    mu: float
    restitution: tuple
    r: float
    clearance: float
    load: float = 1.0


@dataclass(frozen=True)
class State:
    """Time, position and velocity of M, position and velocity of the free mass."""

    t: object
    x: object
    v: object
    z: object
    w: object


@dataclass(frozen=True)
class Event:
    """An event: "impact", "stick" or "release", the side, and the state just after it."""

    kind: str
    side: int
    after: State
    approach: object = 0


def start(t=0.0, x=0.0, x_dot=0.0, z=0.0, z_dot=0.0):
    """Return the state that `vibroimpact.simulate` gives under these names."""
    return State(*map(mpf, (t, x, x_dot, z, z_dot)))


def oscillate(mass, xi, r, load, t0, x, v, t):
    """Position and velocity of `mass x'' + 2 xi x' + x = load sin(r t)` a time t after t0."""
    mass, xi, r, load = mpf(mass), mpf(xi), mpf(r), mpf(load)
    response = load / (1 - mass * r * r + 2j * xi * r)
    before, after = response * mp.expj(r * t0), response * mp.expj(r * (t0 + t))
    x0, v0 = before.imag, r * before.real
    decay = xi / mass
    eta = mp.sqrt(mass - xi * xi) / mass
    shrink = mp.exp(-decay * t)
    cosine, sine = shrink * mp.cos(eta * t), shrink * mp.sin(eta * t) / eta
    free, rate = x - x0, v - v0
    position = free * (cosine + decay * sine) + rate * sine
    velocity = rate * (cosine - decay * sine) - free * sine / mass
    return position + after.imag, velocity + r * after.real


def fly(system, state, t):
    """State of a flight a time t later."""
    x, v = oscillate(1, system.xi, system.r, system.load, state.t, state.x, state.v, t)
    return State(state.t + t, x, v, state.z + state.w * t, state.w)


def roll(system, state, side, t):
    """State of a rest on a wall a time t later."""
    mass = 1 + mpf(system.mu)
    x, v = oscillate(mass, system.xi, system.r, system.load, state.t, state.x, state.v, t)
    return State(state.t + t, x, v, x + side * mpf(system.clearance) / 2, v)


def gap(system, state, side):
    """Distance from the wall of a side; negative beyond it."""
    return mpf(system.clearance) / 2 - side * (state.z - state.x)


def acceleration(system, state):
    """Acceleration of M in flight."""
    load = mpf(system.load) * mp.sin(mpf(system.r) * state.t)
    return load - 2 * mpf(system.xi) * state.v - state.x


def bisect(function, low, high):
    """Zero of a function that is positive at `low` and not at `high`, to the last digit."""
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if function(middle) > 0 else (low, middle)
    root = mp.findroot(function, (low, high), solver="anderson", tol=mpf(10) ** -180, verify=False)
    return root if low <= root <= high else (low + high) / 2


def next_contact(system, state, left, limit):
    """Flight time to the next contact and its side; None if there is none within the limit.

    Parameters
    ----------
    left : int
        Wall just left, whose gap is 0 now, or 0.
    """
    if left:
        speed = left * (state.v - state.w)
        closing = -left * acceleration(system, state)
        # at a release both are 0 to rounding
        if speed > 0 and closing > 0 and 2 * speed / closing < SCAN:
            estimate = 2 * speed / closing

            def rest_of(t):
                return gap(system, fly(system, state, t), left) / t

            return bisect(rest_of, estimate * mpf("0.7"), estimate * mpf("1.4")), left
    step = min(SCAN, mpf(system.clearance) / (abs(state.w - state.v) + mpf(10) ** -40) / 4)
    t = step / 1000 if left else mpf(0)
    while t < limit:
        after = fly(system, state, t + step)
        for side in (1, -1):
            if gap(system, after, side) <= 0:

                def close(t, side=side):
                    return gap(system, fly(system, state, t), side)

                return bisect(close, t, t + step), side
        t += step
    return None


def collide(system, state, side):
    """Return the event of an impact, from momentum and restitution."""
    restitution, mu = mpf(system.restitution[0 if side > 0 else 1]), mpf(system.mu)
    approach = side * (state.w - state.v)
    centre = (state.v + mu * state.w) / (1 + mu)
    apart = side * restitution * approach
    after = State(
        state.t, state.x, centre + mu * apart / (1 + mu), state.z, centre - apart / (1 + mu)
    )
    return Event("impact", side, after, approach)


def release(system, state, side, limit):
    """Time until the contact force in a rest ends; None if not within the limit."""

    def force(t):
        later = roll(system, state, side, t)
        return -side * acceleration(system, later)

    t = mpf(0)
    while t < limit:
        if force(t + SCAN) <= 0:
            return bisect(force, t, t + SCAN)
        t += SCAN
    return None


def simulate(system, state, impacts, limit=1000, side=0):
    """Events until a number of impacts with flights of at least `SHORTEST` were found, or until time runs out."""
    events, count = [], 0
    end = state.t + limit
    while count < impacts:
        found = next_contact(system, state, side, end - state.t)
        if found is None:
            return events
        time, side = found
        event = collide(system, fly(system, state, time), side)
        events.append(event)
        state, count = event.after, count + 1
        closing = -side * acceleration(system, state)
        if time < SHORTEST or (state.v == state.w and closing > 0):
            events.append(Event("stick", side, state))
            time = release(system, state, side, end - state.t)
            if time is None:
                return events
            state = roll(system, state, side, time)
            events.append(Event("release", side, state))
    return events
