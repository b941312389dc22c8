"""Exact motions of a rig with dry friction in its slot, and the effect of friction on a record.

Friction opposes the slip of the free mass and drags the primary mass along with it. The force is constant between
impacts and reversals of the slip, at which it changes its sign. The response of the primary mass to such a force
is a sum of closed forms, like its response to impulses: the derivative of the response to a step is the response
to an impulse.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.errors import SingularError
from ..motions.exact import settled
from ..motions.motion import Motion
from ..systems.oscillator import Oscillator, Pattern
from ..systems.structure import Load
from .laws import Law
from .motions import FARTHEST, MOST_STEPS, SETTLED, STEP, TOUCHING, Impacting, System
from .slips import Slips
from .waves import Measured, predicted
from .windows import Flown, Windows

_Array = NDArray[np.float64]
_Ints = NDArray[np.int64]
#: Instants of a flight at which the sign of the slip is evaluated, and the number of searches for reversals.
ALONG, LOOKS = 200, 3
#: Least friction over F0 of a motion of the core; without friction the motion has other events.
LEAST = 1e-9


class Rubbing(System):
    """The data shared by all motions of a record with friction in the slot.

    The last parameter is the friction over F0. The angles at which the slip reverses are unknown, like the angles
    and jumps of the impacts; the slip is zero there.
    """

    def steps(self, flight: _Ints) -> tuple[_Array, _Array]:
        """Changes of the sign of the slip at impacts, and at reversals in the flights after given impacts."""
        number = np.arange(flight.size) - np.searchsorted(flight, flight)
        return -2 * self.signs, 2 * self.signs[flight] * (-1.0) ** number

    def equations(
        self, p: Any, angles: Any, turns: Any, jumps: Any, flight: _Ints
    ) -> tuple[Any, Any, Any]:
        """The equations of each impact and reversal (..., 2N + reversals), approach speeds and coefficients of
        restitution; parameters `p` (P, ...), angles, jumps and reversals (...) may be complex."""
        omega, xi, mu, d, static, phase, *walls, friction = (value[..., None] for value in p)
        N, signs = self.signs.size, self.signs
        places = np.concatenate([angles, turns], axis=-1)
        changes = np.concatenate(self.steps(flight))
        X, V = self.loaded(omega, xi, static, phase, places)
        # responses to an impulse of 1 in every period, its rate and its integral
        whole = 2 * math.pi * self.k
        since = places[..., :, None] - places[..., None, :]
        since = since - whole * np.floor(since.real / whole)
        decay, rate = xi * omega, omega * np.sqrt(1 - xi**2)
        q = np.exp(-decay * whole / self.Omega)
        turn = rate * whole / self.Omega
        c, s = (1 - q * np.cos(turn))[..., None], (q * np.sin(turn))[..., None]
        fade = np.exp(-decay[..., None] * since / self.Omega) / (c * c + s * s)
        turn = rate[..., None] * since / self.Omega
        cosine, sine = fade * np.cos(turn), fade * np.sin(turn)
        response = (c * sine + s * cosine) / rate[..., None]
        real = c * cosine - s * sine
        of_jump = (real - decay[..., None] * response)[..., :N]
        half = np.eye(places.shape[-1])
        of_jump = of_jump - 0.5 * half[:, :N]  # the mean of the values before and after
        summed = (0.5 * half - real - decay[..., None] * response) / omega[..., None] ** 2
        push = friction * static * omega**2
        X = X + (response[..., :N] @ jumps[..., None])[..., 0] + push * (summed @ changes)
        V = V + (of_jump @ jumps[..., None])[..., 0] + push * (response @ changes)
        X, V, at_turns = X[..., :N], V[..., :N], V[..., N:]
        # flights of the free mass, which friction bends
        z = X + signs * d / 2
        flights = (np.roll(angles, -1, axis=-1) - angles + self.last) / self.Omega
        own = (flight == np.arange(N)[:, None]).astype(float)
        left = ((np.roll(angles, -1, axis=-1) + self.last)[..., flight] - turns) / self.Omega
        drag = push / mu
        once = -signs * flights + (left * changes[N:]) @ own.T
        twice = 0.5 * (-signs * flights**2 + (left**2 * changes[N:]) @ own.T)
        after = (np.roll(z, -1, axis=-1) - z) / flights + drag * twice / flights
        before = np.roll(after - drag * once, 1, axis=-1)
        gone = flights[..., flight] - left
        earlier = (flight[:, None] == flight) & (
            np.arange(flight.size)[:, None] > np.arange(flight.size)
        )
        bent = -signs[flight] * gone
        bent = bent + ((gone[..., :, None] - gone[..., None, :]) * earlier) @ changes[N:]
        slip = after[..., flight] - drag * bent - at_turns
        speeds = signs * (before - V + jumps / 2)
        positive = np.where(speeds.real > 0, speeds, 1.0)
        n = len(self.law.of_wall(0))
        each = (self.law.coefficient(i, w, positive) for i, w in enumerate((walls[:n], walls[n:])))
        R = np.where(signs > 0, *each)
        momentum = jumps + mu * (after - before)
        restitution = after - V - jumps / 2 + signs * R * speeds
        return np.concatenate([momentum, restitution, slip], axis=-1), speeds, R

    def motion(self, p: _Array, angles: _Array, jumps: _Array) -> Impacting:
        """The exact motion near given angles and jumps."""
        N, turns, flight = angles.size, np.empty(0), np.empty(0, dtype=np.int64)
        for _ in range(LOOKS):
            turns, flight = self.reversals(p, angles, turns, jumps, flight)
        n = turns.size
        x, places = np.concatenate([angles, turns, jumps]), np.append(np.arange(N), flight)
        for _ in range(MOST_STEPS):
            point = np.concatenate([x, p])
            points = point + 1j * STEP * np.eye(point.size)
            found, speeds, R = self.equations(
                points[:, x.size :].T, points[:, :N], points[:, N : N + n], points[:, N + n : x.size], flight
            )  # fmt: skip
            by = found.imag.T / STEP
            if not np.isfinite(by).all():
                break
            right = np.column_stack([found[0].real, by[:, x.size :]])
            try:
                change = -np.linalg.solve(by[:, : x.size], right)
            except np.linalg.LinAlgError:
                break
            step, first = change[:, 0], np.sort(x[: N + n])
            room = FARTHEST * np.diff(first, append=first[0] + 2 * math.pi * self.k).min()
            step = step * min(1.0, room / max(abs(step[: N + n]).max(), 1e-300))
            x = x + step
            angles, turns, jumps = np.split(x, [N, N + n])
            order = np.lexsort((x[: N + n], places))
            if (np.diff(x[: N + n][order]) <= 0).any():
                break
            size = max(abs(jumps).max(), 1e-300)
            if abs(step[: N + n]).max() + abs(step[N + n :]).max() / size < SETTLED:
                if not speeds[0].real.min() > TOUCHING * size / max(p[2], 1e-3):
                    raise SingularError(
                        "the free mass does not approach the walls at the impacts of the motion"
                    )
                slopes = np.asarray(change[:, 1:], dtype=np.float64)
                self.slides(p, angles, turns, jumps, flight)
                both = np.stack([slopes[:N], slopes[N + n :]])
                return self.with_response(
                    p, Impacting(angles, jumps, speeds[0].real, R[0].real, both), turns, flight, slopes[: N + n]
                )  # fmt: skip
        raise SingularError("Newton's method found no motion with these impacts and friction")

    def reversals(
        self, p: _Array, angles: _Array, turns: _Array, jumps: _Array, flight: _Ints
    ) -> tuple[_Array, _Ints]:
        """Where the slip of approximate flights changes its sign, with the impacts before, from approximate
        reversals."""
        N = angles.size
        ends = np.append(angles[1:], angles[0] + 2 * math.pi * self.k)
        part = (np.arange(ALONG) + 0.5) / ALONG
        places = angles[:, None] + (ends - angles)[:, None] * part
        velocity = self.velocity(p, places.ravel(), angles, turns, jumps, flight).reshape(N, ALONG)
        at = self.positions(p, angles, turns, jumps, flight)
        T = (ends - angles) / self.Omega
        drag = p[-1] * p[4] * p[0] ** 2 / p[2]
        sign = np.empty((N, ALONG))
        for i in range(N):
            passed = (places[i][:, None] > turns[flight == i]).sum(axis=1)
            sign[i] = -self.signs[i] * (-1.0) ** passed
        # velocities of the free mass from the mean of its flight
        fallen = np.cumsum(-drag * sign * T[:, None] / ALONG, axis=1)
        fallen -= fallen.mean(axis=1, keepdims=True)
        slip = ((np.roll(at, -1) - at) / T)[:, None] + fallen - velocity
        found, of = [], []
        for i in range(N):
            own = np.concatenate([[-self.signs[i]], slip[i], [self.signs[(i + 1) % N]]])
            x = np.concatenate([angles[i : i + 1], places[i], ends[i : i + 1]])
            for j in np.flatnonzero(np.sign(own[1:]) * np.sign(own[:-1]) < 0).tolist():
                share = 0.5 if j in (0, ALONG) else own[j] / (own[j] - own[j + 1])
                found.append(float(x[j] + share * (x[j + 1] - x[j])))
                of.append(i)
        return np.array(found), np.array(of, dtype=np.int64)

    def velocity(
        self, p: _Array, places: _Array, angles: _Array, turns: _Array, jumps: _Array, flight: _Ints,
        order: int = 1,
    ) -> _Array:  # fmt: skip
        """A derivative of the displacement of the primary mass at given angles; that at a step is the one after
        it."""
        omega, xi, _, _, static, phase = p[:6].tolist()
        own = predicted(self.data, places, order, omega, xi, static, phase, angles, jumps).value
        found: _Array = own + self.response(p, places, angles, turns, flight, order)[0]
        return found

    def response(
        self, p: _Array, places: _Array, angles: _Array, turns: _Array, flight: _Ints, order: int
    ) -> tuple[_Array, Any, _Array, _Array]:
        """The response of the primary mass to friction, to a step at each change of its sign (with derivatives),
        these steps, and the sign of the slip at given angles (zero for derivatives)."""
        omega, xi, _, _, static, phase = p[:6].tolist()
        changes = np.concatenate(self.steps(flight))
        at = np.concatenate([angles, turns])
        push = p[-1] * static * omega**2 * changes
        one = predicted(self.data, places, order - 1, omega, xi, 0.0, phase, at, push)
        sign = np.zeros(places.size)
        if order == 0:
            # from the first impact on
            whole = 2 * math.pi * self.k
            since = (places - angles[0]) % whole
            passed = since[:, None] >= (at - angles[0]) % whole
            sign = passed @ changes + self.signs[0]
        value: _Array = one.value + p[-1] * static * sign
        return value, one, changes, sign

    def positions(
        self, p: _Array, angles: _Array, turns: _Array, jumps: _Array, flight: _Ints
    ) -> _Array:
        """Positions of the free mass at the impacts."""
        x = self.velocity(p, angles, angles, turns, jumps, flight, 0)
        found: _Array = x + self.signs * p[3] / 2
        return found

    def slides(
        self, p: _Array, angles: _Array, turns: _Array, jumps: _Array, flight: _Ints
    ) -> None:
        """Raises an error if the free mass would stick at a reversal."""
        if not turns.size:
            return
        changes = self.steps(flight)[1]
        push = p[-1] * p[4] * p[0] ** 2
        # the acceleration at a reversal is that just after it
        after = self.velocity(p, turns, angles, turns, jumps, flight, 2)
        middle = after - push * 0.5 * changes
        if (abs(middle) <= push * (1 + 1 / p[2])).any() or (middle * changes > 0).any():
            raise SingularError("friction would stick where the slip reverses")

    def with_response(
        self, p: _Array, motion: Impacting, turns: _Array, flight: _Ints, by: _Array
    ) -> Impacting:
        """The motion with its response to friction at the samples of the record; `by` are the derivatives of
        impacts and reversals."""
        places, order = self.data.places, self.data.order
        motion = motion._replace(
            turns=turns, flight=flight, aside=0.0, aside_by=0.0,
            at=lambda at: self.response(p, at, motion.angles, turns, flight, order)[0],
        )  # fmt: skip
        if not places.size:
            return motion
        value, one, changes, sign = self.response(p, places, motion.angles, turns, flight, order)
        omega, static, friction = p[0], p[4], p[-1]
        own = np.zeros((places.size, p.size))
        own[:, 0] = one.omega + one.jumps @ changes * (2 * friction * static * omega)
        own[:, 1] = one.xi
        unit = static * (one.jumps @ changes * omega**2 + sign)
        own[:, 4] = unit * friction / static
        own[:, -1] = unit
        return motion._replace(aside=value, aside_by=own + one.angles @ by)


def slid(
    osc: Oscillator, r: float, clearance: float, phases: _Array, pattern: Pattern, friction: float,
    speeds: _Array, harmonics: NDArray[np.complex128],
) -> Motion:  # fmt: skip
    """The exact motion with friction in the slot as computed by the core, near given load phases and approach
    speeds of its impacts; lengths in F0/K, and `harmonics` as in `verified`."""
    right, left = osc.restitution
    signs = pattern.signs.astype(float)
    jumps = signs * osc.mu * (1 + np.where(signs > 0, right, left)) / (1 + osc.mu) * speeds
    shape = np.append(-1j, harmonics)
    data = Measured(
        r, pattern.cycles, phases, jumps=jumps, sides=pattern.sides,
        orders=np.arange(1.0, shape.size + 1), shape=shape,
    )  # fmt: skip
    p = np.array([1.0, osc.xi, osc.mu, clearance, 1.0, 0.0, right, left, friction])
    system = Rubbing(data, Law())
    one = system.motion(p, phases, jumps)
    # the middle of the first flight until its first event
    until = min([one.angles[1], *one.turns[one.flight == 0]])
    place = 0.5 * (one.angles[:1] + until)
    own = p, one.angles, one.turns, one.jumps, one.flight
    x, v = (system.velocity(p, place, *own[1:], order)[0] for order in (0, 1))
    ends = system.positions(*own)
    T, drag = (one.angles[1] - one.angles[0]) / r, friction / osc.mu
    left_over = (one.angles[1] - one.turns[one.flight == 0]) / r
    changes = system.steps(one.flight)[1][one.flight == 0]
    twice = 0.5 * (-signs[0] * T**2 + left_over**2 @ changes)
    since = float(place[0] - one.angles[0]) / r
    after = (ends[1] - ends[0]) / T + drag * twice / T
    bent = drag * signs[0]
    state = (
        np.array([x, ends[0] + after * since + 0.5 * bent * since**2]),
        np.array([v, after + bent * since]),
    )
    none = np.zeros(shape.size)
    load = Load(
        r, sine=np.column_stack([-shape.imag, none]), cosine=np.column_stack([shape.real, none])
    )
    structure = osc.at(r, clearance, friction=max(friction, LEAST)).structure
    return settled(structure, load, place[0] % (2 * math.pi) / r, state, 0, cycles=pattern.cycles)


def of_no_friction(data: Measured, law: Any, p: _Array, motion: Impacting) -> Impacting:
    """The motion without friction, with its derivatives with respect to friction (over F0) as the last ones."""
    return Rubbing(data, law).motion(np.append(p, 0.0), motion.angles, motion.jumps)


def slips_of(
    windows: Windows, flown: Flown, states: _Array, common: _Array, values: Mapping[str, float], friction: float
) -> Slips:  # fmt: skip
    """The slip in the flights of a record, for given masses, clearance and friction over F0.

    A flight whose two impacts are resolved has a known mean velocity of the free mass, and its neighbours have a
    known velocity at the impact between, by the conservation of momentum. The others have no known slip.
    """
    resolved, signs, none = flown.resolved, np.sign(flown.jumps), np.empty(0)
    omega, xi, static = (float(common[i]) for i in range(3))
    slips = windows.slips or Slips(none, none, none, omega, xi)
    t, X, V, after = windows.events(states, common, flown.times)
    t = np.where(resolved, t, flown.times)
    size = windows.friction * windows.static
    X, V, after = (x + size * slips.at(t, order) for x, order in ((X, 0), (V, 1), (after, 1)))
    z = X + 0.5 * signs * values["d"] * values.get("gain", 1.0)
    push = friction * static * omega**2
    drag = push / values["mu"]
    part = (np.arange(ALONG) + 0.5) / ALONG
    begins, ends = np.append(windows.t[0], t), np.append(t, windows.t[-1])
    T = np.maximum(ends - begins, 0.0)
    inner = begins[:, None] + T[:, None] * part
    with np.errstate(all="ignore"):  # for flights that do not exist
        velocity = windows.velocities(states, common, inner, windows.begins)
        velocity = velocity + size * slips.at(inner, 1)
        known = np.zeros(T.size, dtype=bool)
        known[1:-1] = resolved[:-1] & resolved[1:]
        mean = np.where(known[1:-1], np.diff(z) / T[1:-1], 0.0)
        passed = (after - V) / values["mu"]
    for _ in range(LOOKS if friction else 1):
        bent = np.zeros((T.size, ALONG))
        whole, start = np.zeros(T.size), np.zeros(T.size)
        if slips.times.size:
            so_far = slips.sums(begins)[0]
            bent = drag * (slips.sums(inner)[0] - so_far[:, None])
            whole = drag * (slips.sums(ends)[0] - so_far)
            start[1:-1] = drag * slips.between(t)[1]
        start[1:-1] += mean
        begun, ended = known.copy(), known.copy()
        for j in np.flatnonzero(~known).tolist():
            if j > 0 and known[j - 1]:
                start[j], begun[j] = start[j - 1] - whole[j - 1] - passed[j - 1], True
            elif j < known.size - 1 and known[j + 1]:
                start[j], ended[j] = start[j + 1] + passed[j] + whole[j], True
        slip = start[:, None] - bent - velocity
        slips = stepped(slip, inner, begins, ends, begun, ended, signs, omega, xi)
    return slips


def stepped(
    slip: _Array, inner: _Array, begins: _Array, ends: _Array, begun: NDArray[np.bool_],
    ended: NDArray[np.bool_], signs: _Array, omega: float, xi: float,
) -> Slips:  # fmt: skip
    """The steps of the sign of the slip, from the slip at instants of each flight."""
    times: list[float] = []
    level: list[float] = []
    turns: list[float] = []
    for j in np.flatnonzero(begun | ended).tolist():
        own, x = np.sign(slip[j]), inner[j]
        if not np.isfinite(slip[j]).all():
            continue
        # at an impact the free mass leaves the wall, or moves towards it
        own = np.concatenate([
            [-signs[j - 1] if begun[j] else own[0]], own, [signs[j] if ended[j] else own[-1]]
        ])  # fmt: skip
        x = np.concatenate([begins[j : j + 1], x, ends[j : j + 1]])
        places = np.flatnonzero(own[1:] * own[:-1] < 0)
        full = np.concatenate([own[:1], slip[j], own[-1:]])
        share = np.full(places.size, 0.5)
        some = (places > 0) & (places < ALONG)
        share[some] = (full[places] / (full[places] - full[places + 1]))[some]
        reversals = (x[places] + share * (x[places + 1] - x[places])).tolist()
        turns += reversals
        times += [float(begins[j]), *reversals, float(ends[j])]
        level += [*(own[0] * (-1.0) ** np.arange(len(reversals) + 1)).tolist(), 0.0]
    # where flights follow each other, the sign does not pass through 0
    every, signs_of = np.array(times), np.array(level)
    kept = np.append(every[1:] > every[:-1], True) if every.size else np.zeros(0, dtype=bool)
    every, signs_of = every[kept], signs_of[kept]
    return Slips(every, np.diff(signs_of, prepend=0.0), np.array(turns), omega, xi)
