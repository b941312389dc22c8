"""The vibroimpact oscillator for thousands of states at once, from Newton's law: to audit the package with.

Between events everything is a damped oscillation plus a forced one, written as real parts of two
complex exponentials. A state advances by cells, a fixed part of the load cycle. In a cell the
gaps (or, in a rest, the contact force) lie between a cubic and a bound on the fourth derivative;
where that cannot exclude a zero the cell is halved until one is bracketed or excluded, so that no
contact is missed. An impact is momentum and restitution. Where the rebound on a wall against
which the mass is pressed is too small for later impacts to matter, the masses stick, with
their common momentum, and move together until the contact force ends.

Units: time in 1/omega, length in F0/K; the load is sin(r t), and states begin at t = 0.
"""

from dataclasses import dataclass, field

import numpy as np

TURN = 2 * np.pi
CELLS = 24
"""Cells in a load cycle."""
SPENT = 1e-13
"""A rebound of speed u under an acceleration a leaves an error of u^3/a^2 when it is left out."""
NARROW = 1e-9
"""An interval in which a contact may hide; grazes of about its square are not told apart."""
FLIGHT, IMPACT, STICK, RELEASE = 0, 1, 2, 3


@dataclass(frozen=True)
class Systems:
    """Oscillators and loads, one for each lane; `restitution` is (right, left)."""

    xi: np.ndarray
    mu: np.ndarray
    restitution: np.ndarray
    r: np.ndarray
    clearance: np.ndarray

    @classmethod
    def of(cls, xi, mu, restitution, r, clearance):
        """Return one oscillator, repeated for many points."""
        r, clearance = np.broadcast_arrays(np.asarray(r, float), np.asarray(clearance, float))
        one = np.ones(r.size)
        walls = np.outer(np.broadcast_to(np.asarray(restitution, float), 2), one)
        return cls(xi * one, mu * one, walls, r.ravel().copy(), clearance.ravel().copy())

    def take(self, lanes):
        """Return the selected lanes."""
        return Systems(
            self.xi[lanes],
            self.mu[lanes],
            self.restitution[:, lanes],
            self.r[lanes],
            self.clearance[lanes],
        )


@dataclass
class Events:
    """Events: lane, cell count and time in the cell, kind, side, state after, approach speed."""

    lane: list = field(default_factory=list)
    time: list = field(default_factory=list)
    kind: list = field(default_factory=list)
    side: list = field(default_factory=list)
    state: list = field(default_factory=list)
    approach: list = field(default_factory=list)

    def add(self, lane, time, kind, side, state, approach):
        """Append events, one for each lane."""
        self.lane.append(lane)
        self.time.append(time)
        self.kind.append(np.full(lane.size, kind))
        self.side.append(side)
        self.state.append(state)
        self.approach.append(approach)

    def table(self):
        """Return arrays, in the order of lanes and, within a lane, of time."""
        if not self.lane:
            none = np.zeros(0)
            return none.astype(int), none, none.astype(int), none, none.reshape(0, 4), none
        lane = np.concatenate(self.lane)
        order = np.argsort(lane, kind="stable")
        rows = (self.time, self.kind, self.side, self.state, self.approach)
        return lane[order], *(np.concatenate(row)[order] for row in rows)


class Signal:
    """c0 + c1 s + Re(free e^(rate s)) + Re(forced e^(i r s)) in lanes, and limits for it."""

    def __init__(self, parts, low, high):
        """Take the terms of the signal."""
        self.parts, self.low, self.high = parts, low, high
        _, _, free, rate, forced, r = parts
        size, drive = np.abs(rate), np.abs(forced)
        self.third = np.abs(free) * size**3 + drive * r**3
        self.fourth = np.abs(free) * size**4 + drive * r**4

    def take(self, lanes):
        """Return the signal of the selected lanes."""
        return Signal(tuple(part[lanes] for part in self.parts), self.low[lanes], self.high[lanes])

    def at(self, s):
        """Value and slope after a time."""
        c0, c1, free, rate, forced, r = self.parts
        one, two = free * np.exp(rate * s), forced * np.exp(1j * r * s)
        return c0 + c1 * s + one.real + two.real, c1 + (rate * one).real + (1j * r * two).real

    def size(self):
        """Sum of the magnitudes of the terms, the scale of the rounding errors."""
        c0, _, free, _, forced, _ = self.parts
        return np.abs(c0) + np.abs(free) + np.abs(forced)

    def inside(self, f, slope, g, slope_g, width):
        """Whether the signal certainly stays within the limits between two times."""
        third = width / 3
        one, two, hidden = f + slope * third, g - slope_g * third, self.fourth * width**4 / 384
        top = np.maximum(np.maximum(f, g), np.maximum(one, two)) + hidden
        bottom = np.minimum(np.minimum(f, g), np.minimum(one, two)) - hidden
        return (top < self.high) & (bottom > self.low)


def crossings(signal, begin, end):
    """When signals first leave their limits, and through which limit: +1 upper, -1 lower, 0 none.

    Up to `begin` the signals are known to stay within them.
    """
    n, whole = begin.size, signal
    when, through, low, high = end.copy(), np.zeros(n), np.zeros(n), np.zeros(n)
    lanes = np.flatnonzero(begin < end)
    p = begin[lanes].copy()
    width = end[lanes] - p
    signal = signal.take(lanes)
    f, slope = signal.at(p)
    while lanes.size:
        last = end[lanes]
        q = np.minimum(p + width, last)
        g, slope_g = signal.at(q)
        width = q - p
        clear = signal.inside(f, slope, g, slope_g, width)
        out = (g >= signal.high) | (g <= signal.low)
        monotone = (slope * slope_g > 0) & (
            np.minimum(abs(slope), abs(slope_g)) > signal.third * width**2 / 8
        )
        narrow = width < NARROW
        found = ~clear & out & (monotone | narrow)
        if found.any():
            at = lanes[found]
            low[at], high[at] = p[found], q[found]
            through[at] = np.where(g[found] >= signal.high[found], 1.0, -1.0)
        on = clear | (~out & (narrow | (monotone & ~clear & within(signal, g))))
        p = np.where(on, q, p)
        f, slope = np.where(on, g, f), np.where(on, slope_g, slope)
        width = np.where(on, 2 * width, 0.5 * width)
        left = ~found & (p < last)
        if not left.all():
            lanes, p, width, f, slope = (a[left] for a in (lanes, p, width, f, slope))
            signal = signal.take(left)
    at = np.flatnonzero(through)
    if at.size:
        when[at] = refined(whole.take(at), low[at], high[at], through[at])
    return when, through


def within(signal, g):
    """Whether a value is within the limits; if the signal is monotone, so are all values before it."""
    return (g < signal.high) & (g > signal.low)


def refined(signal, low, high, side):
    """The places between two where signals cross a limit, by Newton's method in a bracket."""
    level = np.where(side > 0, signal.high, signal.low)
    # rounding may put a signal beyond its limit at the start
    root = np.where(side * (signal.at(low)[0] - level) >= 0, low, 0.5 * (low + high))
    keep = root > low
    lanes, s = np.flatnonzero(keep), root.copy()
    for _ in range(70):
        if not lanes.size:
            break
        if lanes.size < s.size:
            signal, low, high, side, level, s = (
                signal.take(keep),
                *(a[keep] for a in (low, high, side, level, s)),
            )
        f, slope = signal.at(s)
        off = f - level
        over = side * off >= 0
        high, low = np.where(over, s, high), np.where(over, low, s)
        with np.errstate(all="ignore"):
            step = s - off / slope
        there = np.abs(off) <= 2e-15 * signal.size()
        new = np.where((step > low) & (step < high), step, np.where(there, s, 0.5 * (low + high)))
        keep = ~there & (np.abs(new - s) > 4e-16)
        root[lanes] = s = new
        lanes = lanes[keep]
    return root


class Lanes:
    """States of many systems, advanced by whole cells."""

    def __init__(self, systems, x, v, z, w, side=None, cell=0):
        """`side` is the wall that the free mass rests on, or 0; `cell` the first cell."""
        self.systems = systems
        n = systems.r.size
        self.x, self.v, self.z, self.w = (
            np.array(np.broadcast_to(a, n), float) for a in (x, v, z, w)
        )
        self.side = np.zeros(n) if side is None else np.array(side, float)
        self.cell = np.array(np.broadcast_to(cell, n), dtype=int)
        self.tau = np.zeros(n)
        # the wall just left in an impact (+-1) or a release (+-2), or 0
        self.left = np.zeros(n)
        self.steps = TURN / systems.r / CELLS
        one, r, xi = 1 + systems.mu, systems.r, systems.xi
        # M alone, and both masses together
        self.rates = np.stack([(-xi + 1j * np.sqrt(m - xi**2)) / m for m in (1.0, one)])
        self.forces = np.stack([-1j / (1 - m * r**2 + 2j * xi * r) for m in (1.0, one)])
        self.failed = np.zeros(n, bool)

    def take(self, lanes):
        """Return the selected lanes as an object of their own."""
        some = Lanes(
            self.systems.take(lanes), *self.state()[lanes].T, self.side[lanes], self.cell[lanes]
        )
        some.tau, some.left = self.tau[lanes].copy(), self.left[lanes].copy()
        some.failed = self.failed[lanes].copy()
        return some

    def state(self):
        """Return x, v, z, w (n, 4)."""
        return np.stack([self.x, self.v, self.z, self.w], 1)

    def parts(self, lanes):
        """The oscillation of M from now on: free amplitude, rate, forced amplitude, r."""
        resting = (self.side[lanes] != 0).astype(int)
        r = self.systems.r[lanes]
        phase = TURN * ((self.cell[lanes] % CELLS) / CELLS) + r * self.tau[lanes]
        rate = self.rates[resting, lanes]
        forced = self.forces[resting, lanes] * np.exp(1j * phase)
        a = self.x[lanes] - forced.real
        b = self.v[lanes] + r * forced.imag
        return a - 1j * (b - rate.real * a) / rate.imag, rate, forced, r

    def run(self, end, events=None):
        """Advance all states to the start of a cell; `events` receives the events."""
        turn = 0
        while True:
            lanes = np.flatnonzero((self.cell < end) & ~self.failed)
            if not lanes.size:
                return
            self.advance(lanes, events)
            turn += 1
            if turn > 400 * (np.max(end) + 100):
                self.failed[lanes] = True

    def advance(self, lanes, events):
        """Advance to the end of the cell, or to the next event in it."""
        parts = self.parts(lanes)
        side, left = self.side[lanes], self.left[lanes]
        span = self.steps[lanes] - self.tau[lanes]
        free, rate, forced, r = parts
        resting = side != 0
        half = 0.5 * self.systems.clearance[lanes]
        # y = z - x in flight; in a rest side x'', which may not rise above zero
        turned = np.where(resting, side, -1.0)
        signal = Signal(
            (
                np.where(resting, 0.0, self.z[lanes]),
                np.where(resting, 0.0, self.w[lanes]),
                turned * free * np.where(resting, rate**2, 1.0),
                rate,
                turned * forced * np.where(resting, -(r**2), 1.0),
                r,
            ),
            np.where(resting, -np.inf, -half),
            np.where(resting, 0.0, half),
        )
        f, slope = signal.at(np.zeros(lanes.size))
        g, slope_g = signal.at(span)
        clear = (left == 0) & signal.inside(f, slope, g, slope_g, span)
        when, through = span, np.zeros(lanes.size)
        hard = np.flatnonzero(~clear)
        if hard.size:
            begin = self.departures(lanes[hard], signal.take(hard), span[hard])
            when = span.copy()
            when[hard], through[hard] = crossings(signal.take(hard), begin, span[hard])
        self.move(lanes, parts, when)
        done = through == 0
        on = lanes[done]
        self.cell[on] += 1
        self.tau[on] = 0
        self.left[on] = 0
        self.tau[lanes[~done]] += when[~done]
        self.release(lanes[~done & resting], events)
        hit = ~done & ~resting
        self.collide(lanes[hit], through[hit], events)

    def departures(self, lanes, signal, span):
        """The time until which the gap to the wall just left certainly grows or is positive; 0 for the others."""
        left = np.sign(self.left[lanes])
        _, _, free, rate, forced, r = signal.parts
        # of the gap half - left y
        u = -left * signal.at(np.zeros(lanes.size))[1]
        a = -left * ((rate**2 * free).real - (r**2 * forced).real)
        j = -left * ((rate**3 * free).real + r**3 * forced.imag)
        third = signal.third / 3
        u = np.maximum(u, 0.0)
        with np.errstate(all="ignore"):
            root = np.sqrt(0.25 * a * a + 2 * third * u)
            impact = np.where(a > 0, (0.5 * a + root) / third, 2 * u / (root - 0.5 * a))
            release = np.where(j > 0, 2 * j / signal.fourth, 1e-6)
        begin = np.where(np.abs(self.left[lanes]) > 1.5, release, impact * (1 - 1e-6))
        begin = np.where(np.isfinite(begin), begin, 0.0)
        return np.where(left == 0, 0.0, np.minimum(begin, span))

    def move(self, lanes, parts, s):
        """Let the masses move for a time."""
        free, rate, forced, r = parts
        one, two = free * np.exp(rate * s), forced * np.exp(1j * r * s)
        self.x[lanes] = one.real + two.real
        self.v[lanes] = (rate * one).real - r * two.imag
        side = self.side[lanes]
        rests = side != 0
        self.z[lanes] = np.where(
            rests,
            self.x[lanes] + 0.5 * side * self.systems.clearance[lanes],
            self.z[lanes] + self.w[lanes] * s,
        )
        self.w[lanes] = np.where(rests, self.v[lanes], self.w[lanes])

    def collide(self, lanes, side, events):
        """Momentum and restitution; if the rebound is negligible, momentum and rest."""
        if not lanes.size:
            return
        s = self.systems.take(lanes)
        restitution = np.where(side > 0, s.restitution[0], s.restitution[1])
        self.z[lanes] = self.x[lanes] + 0.5 * side * s.clearance
        v, w = self.v[lanes], self.w[lanes]
        approach = np.maximum(side * (w - v), 0.0)
        centre = (v + s.mu * w) / (1 + s.mu)
        apart = side * restitution * approach
        self.v[lanes] = centre + s.mu * apart / (1 + s.mu)
        self.w[lanes] = centre - apart / (1 + s.mu)
        self.left[lanes] = side
        if events is not None:
            events.add(lanes, self.times(lanes), IMPACT, side, self.state()[lanes], approach)
        free, rate, forced, r = self.parts(lanes)
        a = -side * ((rate**2 * free).real - (r**2 * forced).real)
        j = side * ((rate**3 * free).real + r**3 * forced.imag)
        u = restitution * approach
        rest_of_time = 2 * u / (np.maximum(a, 1e-300) * (1 - restitution))
        spent = (a > 0) & (u**3 <= SPENT * a * a) & (np.abs(j) * rest_of_time < 0.1 * a)
        stuck = lanes[spent]
        if not stuck.size:
            return
        self.side[stuck] = side[spent]
        self.left[stuck] = 0
        self.v[stuck] = self.w[stuck] = centre[spent]
        if events is not None:
            events.add(
                stuck, self.times(stuck), STICK, side[spent], self.state()[stuck], approach[spent]
            )

    def release(self, lanes, events):
        """End the rest, as the contact force has ended."""
        if not lanes.size:
            return
        side = self.side[lanes]
        self.left[lanes] = 2 * side
        self.side[lanes] = 0
        if events is not None:
            events.add(lanes, self.times(lanes), RELEASE, side, self.state()[lanes], 0 * side)

    def times(self, lanes):
        """Time in load cycles."""
        return self.cell[lanes] / CELLS + self.tau[lanes] * self.systems.r[lanes] / TURN
