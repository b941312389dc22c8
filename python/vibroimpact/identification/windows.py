"""The individual flights of a record that is not periodic, between the impacts that its spikes indicate.

During each flight between two impacts the primary mass is a damped oscillator under the load, with its own state.
Therefore each flight is fitted separately, outside the pulses, and the shared parameters (natural frequency,
damping, load, ringing) are fitted to all flights together. An impact is the point where two flights meet.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base.errors import SingularError
from .contact import duration, pulses_of
from .flights import DECAYS, LEAST_DAMPED, LEAST_GAIN, LOWEST, MARGIN, MOST_DAMPED, MOST_MODES
from .forced import STEP, Forced
from .known import HINT
from .signals import spikes
from .slips import Slips
from .waves import Measured, Ringing, of_load, turns_of

_Array = NDArray[np.float64]
_Bool = NDArray[np.bool_]
#: Seconds around an impact that are excluded at first, and at most after it; the factor by which a pulse shrinks
#: in a round, and the increase of scatter that shows that it is too short.
AHEAD, PULSE, LONGEST, SHRINK, WORSE = 0.5e-3, 4e-3, 10e-3, 0.6, 1.05
#: Mean residual after impacts, relative to its error, above which a pulse still lasts, and how long it may be
#: interrupted (s).
LASTS, PAUSE = 4.0, 0.8e-3
#: Least time between two impacts that are picked, s.
APART = 2.5e-3
#: Samples of a flight beyond the number of its parameters; rounds; and largest number of steps of a fit in each.
SPARE, ROUNDS, STEPS = 4, 12, 12
#: Standard deviations by which the scatter of a flight is increased if an impact is missing; number of errors
#: below which a jump does not count as an impact.
MISSED, CLEAR = 8.0, 3.5
#: Ratio of the residual variance of flights just after impacts to that later, above which something rings.
RINGS = 1.5
#: Deviation of a ratio of variances that is ascribed to chance, in standard deviations.
CHANCE = 5.0
#: Standard deviations by which a pulse differs from the others if another impact is hidden in it; smallest number
#: of pulses for this comparison.
UNLIKE, ALIKE = 10.0, 12
#: Time from the ends of a flight within which no spike is a missing impact, s.
NEAR_ENDS = 1e-3
#: Largest error of the time of a resolved impact, s.
BLURRED = 2e-3
#: Smallest number of time bins after impacts in which residuals can show a ringing mode.
LEAST_BINS = 12
#: Largest weight of a flight when one more mode is tried.
CLIPPED = 50.0
#: Time about a reversal of slip (s) within which a filter of the sensor may smooth the step of the force.
SMOOTHED = 1.5e-3
#: Samples whose responses to the noise of a load are computed at once.
PART = 1024
#: Samples of a flight over which noise is summed, and the variance ratio above which residuals are not noise.
WIDE, UNEXPLAINED = 24, 10.0


class Flown(NamedTuple):
    """Separately fitted flights."""

    #: (N) Times of the impacts, 0 in the middle of the record, jumps of the velocity, and which are resolved.
    times: _Array
    jumps: _Array
    resolved: _Bool
    #: (N + 1, 2) States of the flights, their covariances, and their derivatives with respect to the common
    #: parameters.
    states: _Array
    spread: _Array
    turned: _Array
    #: Common parameters (omega, xi, static, phase, offset, real and imaginary part of each pole), which are free,
    #: and
    #: their weights.
    common: _Array
    free: NDArray[np.int64]
    weights: _Array
    noise: float
    colour: float
    #: Known natural frequency and damping ratio (0, 1), the derivatives of the states with respect to all common
    #: parameters, their weights, and minus half the gradient of the sum of squares.
    held: NDArray[np.int64]
    every_turned: _Array
    every_weight: _Array
    slope: _Array
    #: Variance of the residuals in the first quarters of flights over that in their second halves.
    early: float
    #: Of linear changes of the common parameters during the record: slope, weight, and cross terms with these.
    trends: tuple[_Array, _Array, _Array]
    #: Of the independent parts of the noise of a load of any form: frequencies, complex amplitudes, and changes of
    #: the states of flights (N + 1, 2, parts).
    further: tuple[_Array, NDArray[np.complex128], _Array] | None = None


class Windows:
    """A record, cut into flights at impacts."""

    def __init__(
        self, t: _Array, values: _Array, data: Measured, times: _Array, omega: float | None, xi: float,
        priors: Mapping[str, tuple[float, float]], start: tuple[float, float],
    ) -> None:  # fmt: skip
        self.t, self.values, self.data = t, values, data
        self.step = float(t[1] - t[0])
        self.turns = turns_of(data, data.Omega * t)
        self.times = np.sort(times)
        self.common = np.array([omega or data.Omega, xi, *start, float(values.mean())])
        self.free_omega = omega is None
        self.priors = priors
        self.before, self.after = AHEAD + self.step, PULSE
        self.noise = math.nan
        #: Whether no further mode is to be added.
        self.rung = False
        #: Numbers of impacts that are not resolved, by reason: next to a flight that was discarded or has too few
        #: samples outside the pulses, with an unclear jump, at an unclear time, and with a pulse that may hide
        #: another one.
        self.lost: list[int] = []
        #: Flights that are discarded at the end.
        self.poor = np.zeros(0, dtype=bool)
        #: The slip in the flights, whose response is not part of `values`, and the friction over F0 and the
        #: static displacement for which it is taken out.
        self.slips: Slips | None = None
        self.friction, self.static = 0.0, float(start[0])
        self.recorded = values
        #: Samples that are not about a reversal of the slip.
        self.smooth = np.ones(t.size, dtype=bool)
        #: Whether missing impacts are looked for, and flights that hide some are left out.
        self.complete = True

    def rub(self, friction: float, slips: Slips, static: float, same: bool = False) -> None:
        """Subtract the response to friction from the record, and exclude samples near reversals of the slip unless
        the used samples must stay the same; call `cut` afterwards, as in `run` and `without`."""
        self.friction, self.slips, self.static = friction, slips, static
        self.values = self.recorded - self.aside(self.t)
        if same:
            return
        turns = np.concatenate([[-math.inf], slips.turns, [math.inf]])
        place = np.searchsorted(turns, self.t)
        self.smooth = np.minimum(self.t - turns[place - 1], turns[place] - self.t) > SMOOTHED

    def aside(self, t: _Array) -> Any:
        """The response to friction that is not part of the flights."""
        if self.slips is None:
            return 0.0
        return self.friction * self.static * self.slips.at(t, self.data.order)

    @property
    def modes(self) -> int:
        """Number of modes that ring."""
        return (self.common.size - 5) // 2

    def cut(self) -> None:
        """Sort the samples into flights."""
        self.flight = np.searchsorted(self.times, self.t, side="right")
        self.begins = np.append(self.t[0], self.times)
        ends = np.append(self.times, self.t[-1] + 1.0)
        self.since = self.t - self.begins[self.flight]
        left = ends[self.flight] - self.t
        first = self.flight == 0
        used = ((self.since > self.after) | first) & (left > self.before)
        # the filters of the sensors settle in the first load cycle
        used &= self.smooth
        used &= self.t > self.t[0] + min(2 * math.pi / self.data.Omega, 0.02 * np.ptp(self.t))
        numbers = np.bincount(self.flight[used], minlength=self.begins.size)
        self.flies = numbers >= 2 + 2 * self.modes + SPARE
        if self.poor.size == self.flies.size:
            self.flies &= ~self.poor
        self.used = np.flatnonzero(used & self.flies[self.flight])
        if self.used.size < 0.1 * self.t.size:
            raise SingularError(
                f"pulses of {self.times.size} impacts leave too little of the motion; {HINT}"
            )
        self.own = np.flatnonzero(self.flies)
        self.edges = np.searchsorted(self.flight[self.used], [self.own, self.own + 1])
        first, last = self.edges
        self.numbers = last - first
        self.count = self.used - np.repeat(self.used[first], self.numbers)
        # what each step of a fit uses; a new large array would cost more than what is computed in it
        self.turns_used, self.since_used = self.turns[:, self.used], self.since[self.used]
        self.values_used = self.values[self.used]
        self.rows = np.empty((4 * self.modes + 10, self.used.size))
        self.latest: tuple[_Array, tuple[_Array, ...]] | None = None

    def faded(self, pole: complex) -> Any:
        """exp(pole t) at the used samples, with t from the impact before each of them; the exponential of a sum is
        a product, so that few have to be computed."""
        steps = np.exp(pole * self.step * np.arange(self.count.max(initial=-1) + 1))
        begins = np.exp(pole * self.since_used[self.edges[0]])
        return np.repeat(begins, self.numbers) * steps[self.count]

    def poles(self, common: _Array) -> list[complex]:
        """The pole of the primary mass, and those of the modes that ring."""
        omega, xi = common[:2].tolist()
        return [
            omega * complex(-xi, math.sqrt(1 - xi**2)),
            *(complex(a, b) for a, b in common[5:].reshape(-1, 2).tolist()),
        ]

    def waves(self, since: _Array, common: _Array) -> _Array:
        """The basis motions of each flight at times since its impact: columns (n, 2 + 2 modes)."""
        poles = self.poles(common)
        rows = np.empty((2 * len(poles), since.size))
        for j, pole in enumerate(poles):
            set_wave(rows, j, pole ** (0 if j else self.data.order) * np.exp(pole * since))
        return rows.T

    def basis(self, common: _Array) -> _Array:
        """At the samples used, rows of the basis motions of each flight (2 + 2 modes), of these multiplied by the
        time since the impact (the same number; for the primary mass this is the derivative with respect to its
        pole), of the derivatives with respect to omega, xi, static and phase under the load alone, of the offset,
        and of the record without the load."""
        poles, (omega, xi, static, phase, offset) = self.poles(common), common[:5].tolist()
        since, q, rows = self.since_used, len(poles), self.rows
        for j, pole in enumerate(poles):
            wave = self.faded(pole)
            if not j:
                wave *= pole**self.data.order
            set_wave(rows, j, wave)
            wave *= since if j else since + self.data.order / pole
            set_wave(rows, q + j, wave)
        if self.data.forced is not None:
            load = self.data.forced.rows(self.data.order, omega, xi, static, phase)[:, self.used]
        else:
            load = of_load(self.data, self.data.order, omega, xi, static, phase) @ self.turns_used
        rows[-6:-2], rows[-2] = load[1:], 1.0
        rows[-1] = self.values_used - load[0] - offset
        return rows

    def by_common(self, common: _Array, states: _Array) -> _Array:
        """Derivatives with respect to the common parameters as sums of the rows of `basis` but the last, for given
        states of flights (flights, rows, parameters)."""
        q, (omega, xi) = 1 + self.modes, common[:2].tolist()
        found = np.zeros((states.shape[0], 4 * q + 5, common.size))
        found[:, -5:, :5] = np.eye(5)
        C = states[:, ::2] + 1j * states[:, 1::2]
        for column, by in enumerate(
            (self.poles(common)[0] / omega, omega * complex(-1, -xi / math.sqrt(1 - xi**2)))
        ):
            one = C[:, 0] * by
            found[:, 2 * q, column], found[:, 2 * q + 1, column] = one.real, one.imag
        for j in range(1, q):
            re, im = 2 * (q + j), 2 * j + 3
            found[:, re, im], found[:, re + 1, im] = C[:, j].real, C[:, j].imag
            found[:, re, im + 1], found[:, re + 1, im + 1] = -C[:, j].imag, C[:, j].real
        return found

    def allowed(self, common: _Array) -> bool:
        """Whether parameters are those of a damped oscillator with ringing modes."""
        within = 0 <= common[1] < 0.9 and common[0] > 0 and common[2] > 0
        for a, b in common[5:].reshape(-1, 2):
            within = within and LEAST_DAMPED * b < -a < MOST_DAMPED * b
            within = (
                within
                and LOWEST < b / self.data.Omega < 0.8 * math.pi / self.step / self.data.Omega
            )
        return bool(within)

    def fitted(self, common: _Array) -> tuple[Any, ...]:
        """States of all flights by linear least squares, the residuals, and the equations for the common
        parameters, of the trusted flights; only these are computed anew if nothing else has changed."""
        if self.latest is None or not np.array_equal(self.latest[0], common):
            self.latest = common.copy(), self.solved(common)
        gram, states, inverse, by, coupled, turned, left = self.latest[1]
        q = 2 + 2 * self.modes
        some = self.trusted & self.flies
        of_left = gram[some, :-1, -1] - (gram[some, :-1, :q] @ states[some, :, None])[..., 0]
        own, back = by[some], np.swapaxes(by[some], 1, 2)
        weights = (back @ (gram[some, :-1, :-1] @ own)).sum(axis=0)
        weights -= np.tensordot(coupled[some], turned[some], ((0, 1), (0, 1)))
        slope = (back @ of_left[..., None]).sum(axis=0)[:, 0]
        return states, inverse, turned, left, weights, slope

    def solved(self, common: _Array) -> tuple[_Array, ...]:
        """The products of the rows of `basis` in each flight; states and the inverses of their equations; the
        derivatives as sums of rows, with respect to the states and of the states; and the residuals."""
        rows, q = self.basis(common), 2 + 2 * self.modes
        gram = np.zeros((self.begins.size, rows.shape[0], rows.shape[0]))
        gram[:, :q, :q] = np.eye(q)
        for i, a, b in zip(self.own.tolist(), *self.edges.tolist(), strict=True):
            own = rows[:, a:b]
            np.matmul(own, own.T, out=gram[i])
        inner = gram[:, :q, :q]
        size = np.sqrt(inner[:, np.arange(q), np.arange(q)])
        weight = inner / (size[:, :, None] * size[:, None, :]) + 1e-12 * np.eye(q)
        inverse = np.linalg.inv(weight) / (size[:, :, None] * size[:, None, :])
        states = (inverse @ gram[:, :q, -1:])[..., 0]
        left = rows[-1]
        for j in range(q):
            left = left - rows[j] * np.repeat(states[self.own, j], self.numbers)
        by = self.by_common(common, states)
        coupled = gram[:, :q, :-1] @ by
        turned = inverse @ coupled
        return gram, states, inverse, by, coupled, turned, left

    def trends(
        self, states: _Array, inverse: _Array, left: _Array
    ) -> tuple[_Array, _Array, _Array]:
        """The effect of a linear change of each common parameter from the start of the record to its end, about
        its value in the middle: minus half the derivative of the sum of squares, the weight, and the cross
        terms with the common parameters."""
        rows, q, by = (
            self.basis(self.common),
            2 + 2 * self.modes,
            self.by_common(self.common, states),
        )
        L, G = rows[:q].T, np.empty((self.used.size, self.common.size))
        moved = self.t[self.used] / np.ptp(self.t)
        of_moving, of_common = np.zeros((2, self.begins.size, q, G.shape[1]))
        for i, a, b in zip(self.own.tolist(), *self.edges.tolist(), strict=True):
            G[a:b] = rows[:-1, a:b].T @ by[i]
            of_moving[i] = (L[a:b] * moved[a:b, None]).T @ G[a:b]
            of_common[i] = L[a:b].T @ G[a:b]
        moving, good = G * moved[:, None], self.trusted[self.flight[self.used]]
        back, inner = of_moving[self.trusted], inverse[self.trusted]
        H = moving[good]
        weight = H.T @ H - np.einsum("iqk,iqr,irl->kl", back, inner, back)
        shared = H.T @ G[good] - np.einsum("iqk,iqr,irl->kl", back, inner, of_common[self.trusted])
        return (
            H.T @ left[good] / self.noise**2,
            np.diag(weight) / self.noise**2,
            shared / self.noise**2,
        )

    def along(
        self, g: _Array, states: _Array, inverse: _Array, left: _Array
    ) -> tuple[_Array, float, float, _Array]:
        """The effect of a further linear parameter of which `g` are the derivatives of the used samples: the
        derivatives of the states of flights, minus half that of the sum of squares, the weight, and the cross
        terms with the common parameters."""
        rows, q = self.basis(self.common), 2 + 2 * self.modes
        by = self.by_common(self.common, states)
        turned = np.zeros((self.begins.size, q))
        slope, weight, shared = 0.0, 0.0, np.zeros(self.common.size)
        for i, a, b in zip(self.own.tolist(), *self.edges.tolist(), strict=True):
            if not g[a:b].any():
                continue
            L, G, own = rows[:q, a:b], rows[:-1, a:b].T @ by[i], g[a:b]
            turned[i] = inverse[i] @ (L @ own)
            if self.trusted[i]:
                slope += float(own @ left[a:b])
                weight += float(own @ own - (L @ own) @ turned[i])
                shared += own @ G - turned[i] @ (L @ G)
        size = self.noise**2
        return turned[:, :2], slope / size, weight / size, shared / size

    def refine(self, enough: float = 1.0) -> tuple[Any, ...]:
        """The common parameters by the damped Gauss–Newton method."""
        free = self.free()
        self.trusted = np.ones(self.begins.size, dtype=bool)
        now = self.fitted(self.common)
        self.noise = self.scatter(now[3])
        for _ in range(2):
            now = self.descended(free, now, enough)
            self.noise = self.scatter(now[3])
            # flights in which an impact is missing are not used for the common parameters
            bad = self.bad(now)
            if not bad.any() or bad.sum() > 0.5 * self.own.size:
                break
            self.trusted = ~bad
            now = self.fitted(self.common)
        return now

    def descended(
        self, free: NDArray[np.int64], now: tuple[Any, ...], enough: float
    ) -> tuple[Any, ...]:
        """Steps downhill until a further step gains less than `enough`."""
        square = self.total(now[3], self.common)
        damping = 1e-6
        for _ in range(STEPS):
            W, g = self.with_priors(now[4], now[5], self.common)
            W, g = W[np.ix_(free, free)], g[free]
            scale = np.sqrt(np.maximum(np.diag(W), 0))
            scale[scale == 0] = 1
            A = W / np.outer(scale, scale)
            moved = False
            while damping < 1e6:
                step = np.linalg.solve(A + damping * np.eye(free.size), g / scale) / scale
                common = self.common.copy()
                common[free] += step
                common[1] = max(common[1], 0.0)
                if self.allowed(common):
                    trial = self.fitted(common)
                    total = self.total(trial[3], common)
                    if total <= square:
                        moved = True
                        break
                damping = max(10 * damping, 1e-3)
            if not moved:
                break
            gain, square = square - total, total
            now, self.common = trial, common
            damping = damping / 10 if damping > 1e-8 else damping
            if gain < enough:
                break
        return now

    def squares(self, left: _Array) -> _Array:
        """Sums of squares of the flights, relative to the noise."""
        sums = np.zeros(self.begins.size)
        sums[self.own] = np.add.reduceat(left**2, self.edges[0]) / self.noise**2
        return sums

    def bad(self, now: tuple[Any, ...]) -> _Bool:
        """Flights that their states do not describe, for instance because an impact is missing."""
        numbers = np.bincount(self.flight[self.used], minlength=self.begins.size)
        freedom = np.maximum(numbers - 2 - 2 * self.modes, 1)
        bad: _Bool = self.flies & (self.squares(now[3]) > freedom + MISSED * np.sqrt(2 * freedom))
        return bad

    def at(self, t: _Array) -> _Array:
        """The motion of the flights at given times, NaN where there is none; to be called after `run`."""
        flight = np.searchsorted(self.times, t, side="right")
        since = t - self.begins[flight]
        waves = (self.waves(since, self.common) * self.states[flight]).sum(axis=1)
        ahead = np.append(self.times, math.inf)[flight] - t
        inside = ((since > self.after) | (flight == 0)) & (ahead > self.before)
        inside &= t >= self.t[self.used[0]]
        motion = self.loaded(t) + waves + self.aside(t)
        return np.where(self.flies[flight] & inside, motion, math.nan)

    def free(self) -> NDArray[np.int64]:
        """Indices of the fitted common parameters."""
        fixed = [] if self.free_omega else [0]
        if self.priors.get("xi", (0, 1))[1] == 0:
            fixed.append(1)
        return np.setdiff1d(np.arange(self.common.size), fixed)

    def scatter(self, left: _Array) -> float:
        """The typical scatter of a sample in a flight."""
        sums = np.add.reduceat(left**2, self.edges[0])
        numbers = np.diff(self.edges, axis=0)[0]
        freedom = numbers - (2 + 2 * self.modes)
        clear = freedom >= np.quantile(freedom, 0.3)
        return math.sqrt(max(float(np.median((sums / freedom)[clear])), 1e-300))

    def with_priors(self, weights: _Array, slope: _Array, common: _Array) -> tuple[_Array, _Array]:
        """Equations relative to the noise, including those of known values."""
        W, g = weights / self.noise**2, slope / self.noise**2
        for place, name in enumerate(("omega", "xi", "static", "phase")):
            if name in self.priors and self.priors[name][1] > 0:
                value, error = self.priors[name]
                W[place, place] += 1 / error**2
                g[place] += (value - common[place]) / error**2
        return W, g

    def total(self, left: _Array, common: _Array) -> float:
        """The sum of squares, including the terms of known values."""
        total = float(self.squares(left)[self.trusted].sum())
        for place, name in enumerate(("omega", "xi", "static", "phase")):
            if name in self.priors and self.priors[name][1] > 0:
                total += ((self.priors[name][0] - common[place]) / self.priors[name][1]) ** 2
        return total

    def ringing(self, now: tuple[Any, ...]) -> bool:
        """Add a ringing mode, if it explains much of the residuals."""
        common, kept, before = self.common, self.noise, self.squares(now[3])
        tau, mean, weight = self.echo(now)
        good = (tau > self.after) & (weight > 0)
        if good.sum() < LEAST_BINS:
            return False
        tau, mean, weight = tau[good], mean[good], np.sqrt(weight[good])
        highest = min(0.4 / self.step, 3000.0)
        tried = np.geomspace(LOWEST * self.data.Omega / (2 * math.pi), highest, 160)
        poles = (-np.array(DECAYS)[:, None] + 2j * math.pi * tried).ravel()
        # by the normal equations of real and imaginary part of each wave
        wave = np.exp(np.outer(poles, tau)) * weight
        a, b, c = (np.einsum("pn,pn->p", *two) for two in (
            (wave.real, wave.real), (wave.real, wave.imag), (wave.imag, wave.imag)
        ))  # fmt: skip
        target = mean * weight
        u, v = wave.real @ target, wave.imag @ target
        gains = (c * u**2 - 2 * b * u * v + a * v**2) / np.maximum(
            a * c - b**2, 1e-9 * a * c + 1e-300
        )
        best = poles[np.argmax(gains)]
        if gains.max() < LEAST_GAIN:
            self.rung = True
            return False
        self.common = np.append(common, [best.real, best.imag])
        try:
            self.cut()
            own = self.flies
            after = self.squares(self.refine()[3])
            # a flight in which an impact is missing gets little weight
            gain = float(
                np.minimum((before - after * (self.noise / kept) ** 2)[own], CLIPPED).sum()
            )
            N = np.count_nonzero(own)
            if gain > 2 * N + 8 * math.sqrt(N) + LEAST_GAIN and self.another():
                return True
        except SingularError:
            pass
        self.common, self.noise, self.rung = common, kept, True
        self.cut()
        return False

    def another(self) -> bool:
        """Whether the last mode is real, and not the tail of a pulse or a duplicate of another mode."""
        *others, (a, b) = self.common[5:].reshape(-1, 2).tolist()
        ends = 1.1 * LEAST_DAMPED * b < -a < 0.9 * MOST_DAMPED * b
        return ends and all(abs(b - other) > 0.1 * other for _, other in others)

    def echo(self, now: tuple[Any, ...]) -> tuple[_Array, _Array, _Array]:
        """The average residual after impacts, relative to their jumps: times since the impacts, means, and their
        weights."""
        states = now[0]
        if not self.times.size:
            raise SingularError(f"no impacts: {HINT}")
        jumps = self.jumps_of(states)
        # the residual of each sample against its flight, also within pulses
        own = (self.flies & ~self.bad(now))[self.flight]
        L = self.waves(self.since[own], self.common)
        rest = (
            self.values[own] - self.loaded(self.t[own]) - (L * states[self.flight[own]]).sum(axis=1)
        )
        flight, since = self.flight[own], self.since[own]
        later = flight > 0
        jump = np.where(later, jumps[flight - 1], 0.0)
        size = max(0.8 * self.step, 0.1e-3)
        bins = np.floor(since / size).astype(np.int64)
        kept = later & (since < 1.2 * LONGEST) & (jump != 0)
        count = int(1.2 * LONGEST / size) + 1
        top = np.bincount(bins[kept], (jump * rest)[kept], count)
        below = np.bincount(bins[kept], (jump**2)[kept], count)
        spread = np.bincount(bins[kept], (jump**2 * rest**2)[kept], count)
        good = below > 0
        mean = np.where(good, top / np.maximum(below, 1e-300), 0.0)
        numbers = np.bincount(bins[kept], minlength=count)
        error2 = np.maximum(spread, self.noise**2 * below) / np.maximum(below, 1e-150) ** 2
        weight = np.where(good & (numbers > 5), 1 / np.maximum(error2, 1e-300), 0.0)
        self.ahead = self.early(rest, flight, own, jumps)
        times = (np.arange(count) + 0.5) * size
        both: tuple[_Array, ...] = tuple(
            np.asarray(x, dtype=np.float64) for x in (times, mean, weight)
        )
        return both[0], both[1], both[2]

    def crowded(self, states: _Array) -> _Bool:
        """Impacts whose pulse, relative to the jump, differs from that of the others, because another impact is
        hidden in it.

        No flight shows such a hidden impact. It would change the equations of its neighbours by less than their
        random errors, but would still shift the parameters by several errors.
        """
        jumps = self.jumps_of(states)
        # the contact itself may look different in each sample
        late = (self.since > APART) & (self.since <= self.after)
        near = np.flatnonzero(late & self.flies[self.flight] & (self.flight > 0))
        near = near[jumps[self.flight[near] - 1] != 0]
        impact, since = self.flight[near] - 1, self.since[near]
        L = self.waves(since, self.common)
        rest = self.values[near] - self.loaded(self.t[near])
        rest -= (L * states[impact + 1]).sum(axis=1)
        jump = jumps[impact]
        crowded = np.zeros(jumps.size, dtype=bool)
        bins = np.floor(since / max(0.5 * self.step, 0.1e-3)).astype(np.int64)
        strong = abs(jump) >= np.median(abs(jumps[jumps != 0])) if jump.size else jump > 0
        for one in np.unique(bins):
            own = bins == one
            some = own & strong
            if some.sum() < ALIKE:
                continue
            # a straight line through the residuals of strong impacts relative to their jumps, over the time
            # within a sample
            place = since - since[some].mean()
            shape = np.column_stack([np.ones(place.size), place])
            ratio = rest[some] / jump[some]
            weights = np.ones(ratio.size)
            for _ in range(5):
                root = np.sqrt(weights)
                line = np.linalg.lstsq(shape[some] * root[:, None], ratio * root, rcond=1e-10)[0]
                off = ratio - shape[some] @ line
                spread = max(float(np.median(abs(off))) / 0.6745, 1e-300)
                weights = 1 / (1 + (off / (2 * spread)) ** 2) ** 2
            left = rest[own] - jump[own] * (shape[own] @ line)
            unlike = abs(left) > UNLIKE * np.hypot(self.noise, jump[own] * spread)
            crowded[impact[own][unlike]] = True
        return crowded

    def contact(self, flown: Flown) -> float:
        """The duration of the contacts (s), from the pulses of resolved impacts that are not close to others, or
        else at most as long as the pulses."""
        data = self.data
        apart = np.diff(flown.times, prepend=-math.inf, append=math.inf)
        gaps, pulse = np.minimum(apart[:-1], apart[1:]), self.before + self.after
        alone = flown.resolved & (gaps > 2 * pulse)
        if not alone.any():
            alone = flown.resolved & (gaps > pulse)
        if not alone.any():
            return pulse  # no contact lasts longer
        # each sample belongs to the latest impact, or to the next one if that is near
        ahead = np.append(flown.times, math.inf)[self.flight] - self.t
        impact = self.flight - (ahead > self.before)
        near = np.flatnonzero((impact >= 0) & (impact < alone.size))
        near = near[alone[impact[near]]]
        impact = impact[near]
        off = self.t[near] - flown.times[impact]
        inside = off < self.after
        near, impact, off = near[inside], impact[inside], off[inside]
        # the flight of the samples between the impact and the end of the flight that was fitted before
        flight = impact + (off > 0)
        rest = self.values[near] - self.loaded(self.t[near])
        L = self.waves(self.t[near] - self.begins[flight], self.common)
        rest -= (L * self.states[flight]).sum(axis=1)
        jumps = flown.jumps[alone]
        place = np.searchsorted(np.flatnonzero(alone), impact)
        modes = self.begun(flown.times, np.flatnonzero(alone))
        width = np.full(place.size, self.step)
        forces, errors, modes = pulses_of(data, jumps, modes, place, off, rest, width, self.noise)
        return min(duration(data, forces, errors, jumps, modes), pulse)

    def begun(self, times: _Array, impacts: NDArray[np.int64]) -> list[Ringing]:
        """The ringing that begins at impacts of given numbers, at times (N) of all impacts."""
        modes = []
        for j, pole in enumerate(self.poles(self.common)[1:], 1):
            size = self.states[:, 2 * j] + 1j * self.states[:, 2 * j + 1]
            before, after = (
                size[impacts + i] * np.exp(pole * (times[impacts] - self.begins[impacts + i]))
                for i in (0, 1)
            )
            modes.append(Ringing(pole, after - np.where(self.flies[impacts], before, 0.0)))
        return modes

    def loaded(self, t: _Array) -> _Array:
        """The motion under the load alone, with the offset."""
        omega, xi, static, phase, offset = self.common[:5].tolist()
        if self.data.forced is not None:
            here = self.data.forced.at(omega, xi, static, phase, t, self.data.order)[0]
            return np.asarray(here + offset, dtype=np.float64)
        turns = turns_of(self.data, self.data.Omega * t)
        load = of_load(self.data, self.data.order, omega, xi, static, phase) @ turns
        loaded: _Array = load[0] + offset
        return loaded

    def early(self, rest: _Array, flight: NDArray[np.int64], own: _Bool, jumps: _Array) -> float:
        """The time before impacts during which the flights do not describe the record (s)."""
        ends = np.append(self.times, math.inf)
        left = ends[flight] - self.t[own]
        size = max(0.8 * self.step, 0.1e-3)
        kept = left < 2e-3
        jump = jumps[np.minimum(flight[kept], jumps.size - 1)]
        bins = np.floor(left[kept] / size).astype(np.int64)
        top = np.bincount(bins, jump * rest[kept])
        spread = np.bincount(bins, np.maximum((jump * rest[kept]) ** 2, (jump * self.noise) ** 2))
        lasts = np.flatnonzero(abs(top) > LASTS * np.sqrt(np.maximum(spread, 1e-300)))
        return float((lasts[-1] + 1) * size) if lasts.size else 0.0

    def jumps_of(self, states: _Array) -> _Array:
        """Jumps of the velocity where flights meet; 0 where they do not meet."""
        here = self.events(states, self.common, self.times)
        return np.where(self.flies[:-1] & self.flies[1:], here[3] - here[2], 0.0)

    def lengths(self, now: tuple[Any, ...]) -> None:
        """Determine the lengths of pulses from the data."""
        tau, mean, weight = self.echo(now)
        lasts = tau[abs(mean) * np.sqrt(weight) > LASTS]
        ends = np.flatnonzero(np.diff(np.append(lasts, math.inf)) > max(PAUSE, 6 * self.step))
        last = float(lasts[ends[0]]) if lasts.size and lasts[0] < PAUSE + 2 * self.step else 0.0
        # not faster than the flights improve
        after = min(last * (1 + MARGIN) + 2 * self.step, LONGEST)
        self.after = max(after, SHRINK * self.after)
        self.before = max(min(self.ahead, 1e-3) + 2 * self.step, SHRINK * self.before)

    @np.errstate(all="ignore")  # where flights do not exist or do not meet
    def events(self, states: Any, common: Any, times: Any, data: Measured | None = None) -> Any:
        """The points where flights meet: times, displacements, velocities before and after (4, ..., N).

        All arguments may have a small imaginary part. `states` is (..., N + 1, 2); the times are those about which
        the crossing of the flights is linearized. Responses to friction are not included. The load may be that of
        other `data`.
        """
        omega, xi, static, phase = (common[..., None, i] for i in range(4))
        decay, rate = xi * omega, omega * np.sqrt(1 - xi**2)

        def free(state: Any, begins: Any, t: Any) -> tuple[Any, Any]:
            since = t - begins
            fade = np.exp(-decay * since)
            c, s = fade * np.cos(rate * since), fade * np.sin(rate * since)
            a, b = state[..., 0], state[..., 1]
            X = a * c - b * s
            return X, -decay * X - rate * (a * s + b * c)

        before, after = states[..., :-1, :], states[..., 1:, :]
        both = [free(before, self.begins[:-1], times), free(after, self.begins[1:], times)]
        slope = both[1][1] - both[0][1]
        t = times - (both[1][0] - both[0][0]) / slope
        X, V = free(before, self.begins[:-1], t)
        V_after = free(after, self.begins[1:], t)[1]
        load, speed = under_load(data or self.data, omega, xi, static, phase, t)
        return np.stack([t, X + load, V + speed, V_after + speed])

    @np.errstate(all="ignore")  # where flights do not exist or do not meet
    def displacements(self, states: _Array, common: _Array, t: _Array) -> _Array:
        """Displacements of the primary mass in all flights (N + 1, n), at times t (N + 1, n)."""
        pole = self.poles(common)[0]
        C = (states[:, 0] + 1j * states[:, 1])[:, None]
        omega, xi, static, phase = common[:4].tolist()
        X, _ = under_load(self.data, omega, xi, static, phase, t)
        moved: _Array = X + (C * np.exp(pole * (t - self.begins[:, None]))).real
        return moved

    @np.errstate(all="ignore")  # where flights do not exist
    def velocities(self, states: _Array, common: _Array, t: _Array, begins: _Array) -> _Array:
        """Velocities of the primary mass in flights of given states (N, 2) and beginnings, at times t (N, n)."""
        pole = self.poles(common)[0]
        C = (states[:, 0] + 1j * states[:, 1])[:, None]
        omega, xi, static, phase = common[:4].tolist()
        _, V = under_load(self.data, omega, xi, static, phase, t)
        moved: _Array = V + (pole * C * np.exp(pole * (t - begins[:, None]))).real
        return moved

    def by_states(self, states: _Array, common: _Array, times: _Array) -> _Array:
        """Derivatives of time and jump of each impact with respect to the states of the flights before and after
        it (2 flights, N, 2 for time and jump, 2 for a state)."""
        flights = np.arange(states.shape[0])
        found = np.zeros((2, times.size, 2, 2))
        # of two consecutive flights one is varied at a time
        for parity in (0, 1):
            own = flights % 2 == parity
            each = []
            for change in 1j * STEP * np.eye(2):
                one = self.events(states + own[:, None] * change, common, times)
                each.append(np.stack([one[0], one[3] - one[2]], axis=-1).imag / STEP)
            by = np.stack(each, axis=-1)
            found[0, own[:-1]], found[1, own[1:]] = by[own[:-1]], by[own[1:]]
        return np.where(np.isfinite(found), found, 0.0)

    def met(self, states: _Array, inverse: _Array) -> tuple[_Array, _Array, _Array, _Bool]:
        """Times of the impacts from the flights, jumps, errors of the times, and which impacts are resolved."""
        t, states = self.times.copy(), states[:, :2]
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            for _ in range(4):
                here = self.events(states, self.common, t)
                t = np.where(abs(here[0] - self.times) < 3e-3, here[0], t)
            jumps = here[3] - here[2]
            P = inverse[:, :2, :2] * self.noise**2
            by = self.by_states(states, self.common, t)
            variance = np.einsum("snqa,snab,snqb->nq", by, np.stack([P[:-1], P[1:]]), by)
            both = self.flies[:-1] & self.flies[1:]
            error, of_jump = np.sqrt(np.maximum(variance.T, 0))
            clear = abs(jumps) > CLEAR * of_jump
            near = abs(here[0] - self.times) < 3e-3
            resolved = both & clear & (error < BLURRED) & near
        odd = (
            np.zeros(self.begins.size, dtype=bool)
            if self.poor.size != self.begins.size
            else self.poor
        )
        bad = odd[:-1] | odd[1:]
        self.lost = [
            int(x.sum())
            for x in (~both & bad, ~both & ~bad, both & ~clear, both & clear & ~resolved)
        ]
        return (
            t,
            np.where(np.isfinite(jumps), jumps, 0.0),
            np.where(both, error, math.inf),
            resolved,
        )

    def run(self, report: Callable[[float, str], None]) -> Flown:
        """All rounds: flights, ringing, pulses, missing and spurious impacts; `report` receives the share that is
        done."""
        self.cut()
        now = self.refine()
        settled = False
        for i in range(ROUNDS):
            report(i / ROUNDS, "single flights")
            while not self.rung and self.modes < MOST_MODES and self.ringing(now):
                now = self.fitted(self.common)
            before, noise = (self.before, self.after), self.noise
            t, _, _, resolved = self.met(now[0], now[1])
            near = resolved & (abs(t - self.times) < 1e-3)
            if not settled:
                self.lengths(now)
            weak = self.needless(now, np.flatnonzero(~resolved))
            more = self.missing(now) if self.complete and i < ROUNDS - 2 else []
            self.times = np.sort(np.append(np.delete(np.where(near, t, self.times), weak), more))
            self.cut()
            now = self.refine()
            if self.noise > WORSE * noise and not settled:
                # flights entirely within pulses do not count
                self.before, self.after = (1.2 * length for length in before)
                settled = True
                self.cut()
                now = self.refine()
            change = max(abs(before[0] - self.before), abs(before[1] - self.after))
            if change < 0.5 * self.step and not weak and not more:
                break
            # pulses of other lengths may hide or reveal a mode
            self.rung = self.rung and (change < 0.5e-3 or i > 2)
        return self.without(self.bad(now) & self.complete)

    def without(self, poor: _Bool) -> Flown:
        """The flights, without those in which impacts are hidden."""
        self.poor = poor
        self.cut()
        now = self.refine(1e-3)
        states, inverse, turned, left, weights, slope = now
        t, jumps, _, resolved = self.met(states, inverse)
        crowded = resolved & self.crowded(states)
        self.lost.append(int(crowded.sum()))
        resolved &= ~crowded
        W, slope = self.with_priors(weights, slope, self.common)
        free = self.free()
        self.states = states
        trends, further = self.trends(states, inverse, left), None
        if self.data.forced is not None:
            further, W, slope, trends = self.with_noise(self.data.forced, now, W, slope, trends)
        colour = self.colour(left)
        if self.complete and colour > UNEXPLAINED:
            raise SingularError(
                f"the residuals of the flights are not white noise: sums over {WIDE} samples have {colour:.3g} "
                f"times the variance of white noise; {HINT}"
            )
        return Flown(
            t, jumps, resolved, states[:, :2], inverse[:, :2, :2] * self.noise**2, turned[:, :2, free],
            self.common, free, W[np.ix_(free, free)], self.noise, colour,
            np.setdiff1d([0, 1], free), turned[:, :2], W, slope, self.early_share(left), trends,
            further,
        )  # fmt: skip

    def with_noise(
        self, forced: Forced, now: tuple[Any, ...], W: _Array, slope: _Array,
        trends: tuple[_Array, _Array, _Array],
    ) -> tuple[Any, ...]:  # fmt: skip
        """The independent parts of the noise in the channel of a load of any form, with what each changes in the
        states of flights; and the equations for the common parameters and for their trends with this noise."""
        states, inverse = now[:2]
        omega, xi, static = self.common[:3].tolist()
        rows, q = self.basis(self.common), 2 + 2 * self.modes
        by = self.by_common(self.common, states)
        w, sizes = forced.of_noise(omega)
        change = np.zeros((self.begins.size, q, w.size))
        of_common, of_trends = np.zeros((2, self.common.size, w.size))
        # the turns of consecutive samples
        turns = np.exp(1j * self.step * np.outer(np.arange(PART), w[::2]))
        each = static * forced.responses(w[::2], sizes[::2], self.data.order, omega, xi)
        for i, a, b in zip(self.own.tolist(), *self.edges.tolist(), strict=True):
            # products of the rows with the responses, and with the waves; and the same, times the time
            products = np.zeros((2, rows.shape[0] - 1, w.size + q))
            for begin in range(a, b, PART):
                part = slice(begin, min(begin + PART, b))
                t, place = self.t[self.used[part]], self.count[part] - self.count[begin]
                here = each * np.exp(1j * w[::2] * t[0])
                turned = (
                    turns[place] if place[-1] < PART else np.exp(1j * np.outer(t - t[0], w[::2]))
                )
                wave = here * turned
                both = np.empty((t.size, w.size + q))
                both[:, : w.size : 2], both[:, 1 : w.size : 2] = wave.real, -wave.imag
                both[:, w.size :] = rows[:q, part].T
                products[0] += rows[:-1, part] @ both
                products[1] += rows[:-1, part] @ (both * t[:, None])
            change[i] = -inverse[i] @ products[0, :q, : w.size]
            if self.trusted[i]:
                left = products[..., : w.size] + products[..., w.size :] @ change[i]
                of_common += by[i].T @ left[0]
                of_trends += by[i].T @ left[1] / np.ptp(self.t)
        # the step to the common parameters stays the same; values that are not free do not absorb the noise
        own, free = of_common / self.noise**2, np.ix_(self.free(), self.free())
        noisy, plain = W + own @ own.T, W[free]
        share = np.linalg.solve(noisy, W).T
        W = share @ W
        W[free] = plain @ np.linalg.solve(noisy[free], plain)
        moving, weight, shared = trends
        less = weight / (weight + ((of_trends / self.noise**2) ** 2).sum(axis=1) + 1e-300)
        trends = moving * less, weight * less, shared * less[:, None]
        return (w, sizes, change[:, :2]), 0.5 * (W + W.T), share @ slope, trends

    def hindered(self) -> str:
        """Why impacts are not resolved, the most common reason first, and what would help."""
        pulse = 1e3 * (self.before + self.after)
        reasons = (
            "next to a flight that does not fit the samples, in which an impact may be hidden"
            + ", or one whose slip is unknown" * (self.slips is not None),
            f"next to a flight with too few samples outside the pulses, which last {pulse:.2g} ms",
            f"with a velocity jump below {CLEAR:g} standard errors",
            "at a time that the flights do not determine",
            "with a pulse unlike the others, which may hide another impact",
        )
        helps = (
            "a higher sampling rate and bandwidth, or a larger d, with which fewer impacts are close together",
            "a higher sampling rate and bandwidth, which shorten the pulses, or a larger d",
            "less noise, or a stronger load",
            "less noise, or a higher sampling rate",
            "a higher sampling rate and bandwidth, or a larger d",
        )
        order = [i for i in np.argsort([-number for number in self.lost]) if self.lost[i]]
        if not order:
            return "a longer record would help"
        each = ", ".join(f"{self.lost[i]} {reasons[i]}" for i in order)
        return f"unresolved impacts: {each}; what would help most: {helps[order[0]]}"

    def early_share(self, left: _Array) -> float:
        """Variance of the residuals in the first quarters of flights over that in their second halves: 1 within
        chance, more if ringing after impacts is not described by any mode."""
        soon, late = np.zeros(left.size, dtype=bool), np.zeros(left.size, dtype=bool)
        for i, a, b in zip(self.own.tolist(), *self.edges.tolist(), strict=True):
            soon[a : a + (b - a) // 4] = late[b - (b - a) // 2 : b] = i > 0
        if min(soon.sum(), late.sum()) < SPARE:
            return 1.0
        share = float(np.mean(left[soon] ** 2) / np.mean(left[late] ** 2))
        return share if share > 1 + CHANCE * math.sqrt(2 / soon.sum() + 2 / late.sum()) else 1.0

    def colour(self, left: _Array) -> float:
        """Variance of sums of neighbouring samples, relative to that of as many independent ones."""
        sums, numbers, used = 0.0, 0, 0.0
        for a, b in self.edges.T.tolist():
            count = (b - a) // WIDE
            if count < 2:
                continue
            own = left[a : a + count * WIDE]
            sums += float((own.reshape(count, WIDE).sum(axis=1) ** 2).sum()) / WIDE
            used += float(own @ own) / WIDE
            numbers += count
        return max(1.0, sums / used) if numbers > 20 else 1.0

    def needless(self, now: tuple[Any, ...], places: NDArray[np.int64]) -> list[int]:
        """The impacts that are not needed: one flight describes the record as well as the two around the
        impact."""
        found: list[int] = []
        q = 2 + 2 * self.modes
        for i in places.tolist():
            if not (self.flies[i] and self.flies[i + 1]) or (found and found[-1] == i - 1):
                continue
            first, last = np.searchsorted(self.flight[self.used], [i, i + 2]).tolist()
            before = float(now[3][first:last] @ now[3][first:last])
            # with the samples of the pulse, which exists only at an impact
            own = slice(int(self.used[first]), int(self.used[last - 1]) + 1)
            A = self.waves(self.t[own] - self.begins[i], self.common)
            rest = self.values[own] - self.loaded(self.t[own])
            A /= np.maximum(np.linalg.norm(A, axis=0), 1e-300)
            left = rest - A @ np.linalg.lstsq(A, rest, rcond=1e-10)[0]
            more = rest.size - (last - first) + q
            if (left @ left - before) / self.noise**2 < more + 5 * math.sqrt(2 * more) + LEAST_GAIN:
                found.append(i)
        return found

    def missing(self, now: tuple[Any, ...]) -> list[float]:
        """Times of missing impacts: one in each flight that is described better with another impact."""
        numbers = self.numbers - 2 - 2 * self.modes
        excess = self.squares(now[3])[self.own] / numbers - 1
        unlike = (numbers >= 8) & (excess >= MISSED * np.sqrt(2 / numbers))
        found = self.hidden(now[3], np.flatnonzero(unlike), excess)
        # a weak impact hardly changes the variance of a long flight
        found = found or self.hidden(now[3], np.flatnonzero(~unlike & (numbers >= 8)), excess)
        # if there are many, missing impacts are not the cause
        worst = sorted(found.values())[-max(1, self.own.size // 8) :]
        return [time for _, time in worst]

    def hidden(
        self, left: _Array, places: NDArray[np.int64], excess: _Array
    ) -> dict[int, tuple[float, float]]:
        """Of the used flights with given numbers, those that are described better with another impact: its time,
        after the `excess` of the variance of the flight."""
        found = {}
        L, pole = self.waves(self.since[self.used], self.common), self.poles(self.common)[0]
        for i in places.tolist():
            a, b = self.edges[:, i].tolist()
            t = self.t[self.used[a:b]]
            grid = t[2:-2][:: max(1, (b - a) // 120)]
            # of a jump at each of these times, from the end of its pulse on: its wave, its product with the
            # residuals, and its square, without the part that the state of the flight describes, from sums over
            # all later samples
            wave = np.exp(pole * (t - t[0]))
            begin = pole**self.data.order * np.exp(-pole * (grid - t[0]))
            basis = np.linalg.qr(L[a:b])[0]
            sums = np.column_stack(
                [wave * left[a:b], abs(wave) ** 2, wave**2, wave[:, None] * basis]
            )
            later = np.vstack([np.cumsum(sums[::-1], axis=0)[::-1], np.zeros(sums.shape[1])])
            later = later[np.searchsorted(t, grid + min(self.after, 2e-3))]
            size = 0.5 * (abs(begin) ** 2 * later[:, 1].real - (begin**2 * later[:, 2]).real)
            inside = (begin[:, None] * later[:, 3:]).imag
            unlike = np.maximum(size - (inside**2).sum(axis=1), 1e-9 * size + 1e-300)
            gain = (begin * later[:, 0]).imag ** 2 / unlike
            # or samples hidden by the pulse itself
            place, peak = int(np.argmax(gain)), int(np.argmax(abs(left[a:b])))
            within = min(t[peak] - t[0], t[-1] - t[peak]) > NEAR_ENDS
            if within and abs(left[a + peak]) > MISSED * self.noise:
                found[i] = float(excess[i]), float(t[peak]) - 0.5 * self.step
            elif gain[place] / self.noise**2 > LEAST_GAIN:
                found[i] = float(excess[i]), float(grid[place])
        return found


def set_wave(rows: _Array, j: int, wave: Any) -> None:
    """Put real and negative imaginary part of a complex wave into two rows."""
    rows[2 * j] = wave.real
    np.negative(wave.imag, out=rows[2 * j + 1])


def unfound_ringing(early: float) -> str:
    """The message about residuals whose variance just after impacts is `early` times that later; empty if there is
    none."""
    if early < RINGS:
        return ""
    return (
        f"the variance of the residuals of the flights is {early:.2g} times as large just after impacts as later: "
        "ringing was not detected as a mode; a higher sampling rate, or a known bandwidth, would help"
    )


def picked(values: _Array, rate: float, Omega: float, order: int) -> _Array:
    """Times of possible impacts, 0 in the middle of the record, from a derivative of the displacement."""
    for _ in range(2 - order):
        values = np.gradient(values) * rate
    kept: list[float] = []
    for time in spikes(values, rate, Omega, None)[0].tolist():
        # a long pulse has several spikes
        if not kept or time > kept[-1] + APART:
            kept.append(time)
    return np.array(kept)


def under_load(
    data: Measured, omega: Any, xi: Any, static: Any, phase: Any, t: Any
) -> tuple[Any, Any]:
    """Displacement and velocity of the steady motion under the load; all arguments may have an imaginary part."""
    if data.forced is not None:
        return data.forced.at(omega, xi, static, phase, t)
    X, V = 0.0, 0.0
    for n, shape in zip(data.orders.tolist(), data.shape.tolist(), strict=True):
        w = n * data.Omega
        a, b = omega**2 - w**2, 2 * xi * omega * w
        size = omega**2 * static / (a**2 + b**2)
        P = size * (shape.real * a + shape.imag * b)
        Q = size * (shape.imag * a - shape.real * b)
        turn = w * t + n * phase
        c, s = np.cos(turn), np.sin(turn)
        X, V = X + P * c - Q * s, V - w * (P * s + Q * c)
    return X, V
