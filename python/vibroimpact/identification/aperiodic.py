"""The parameters of a rig from the individual flights of a record that is not periodic: chaos, transients, rests.

The laws of momentum and restitution at each impact, between two flights of the free mass, are equations that
relate measured quantities: the states of the flights of the primary mass just before and after this impact and the
neighbouring impacts. The parameters must satisfy these equations within the errors of the measured quantities.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base.errors import SingularError
from .contact import HALF_SINE
from .coupled import Covariance, banded, own_blocks, passed_on, scaled_solve, slopes
from .fit import (
    DOUBTFUL,
    EXPONENTS,
    FAR_OFF,
    MORE,
    OF_CONTACT,
    TRIED,
    TYPICAL_FRICTION,
    VAGUE,
    Fit,
    allow_effects,
    covariance_of,
    far_off_gain,
)
from .forced import STEP
from .friction import slips_of
from .known import HINT
from .laws import Law
from .motions import CONTACT, accelerated
from .slips import Slips
from .state_noise import noise_information, without_noise
from .strains import held_strains, strains_of, trends_of
from .waves import Measured
from .windows import Flown, Windows

_Array = NDArray[np.float64]
_Bool = NDArray[np.bool_]
#: Standard deviations beyond which an impact does not follow the laws; smallest share of impacts that follow them.
UNLAWFUL, LAWFUL = 6.0, 0.6
#: Smallest number of impacts from which parameters are estimated.
LEAST_IMPACTS = 6
#: Most steps to a minimum; steps after which impacts are judged; and share of a step that is taken after the last
#: of these.
STEPS, JUDGED, DAMPED = 40, (1, 3, 5, 8), 0.5
#: Error of the time of an impact, relative to the shorter adjacent flight of the free mass, above which its
#: equations are not linear within the errors; standard errors by which its time is moved to look for another
#: minimum; distance (in impacts) of impacts that are moved together; number of flights on either side that are
#: affected.
BLURRED, MOVED, APART, REACH = 0.02, 3.0, 8, 4
#: Share of the variance that a fit may leave beyond noise, and standard deviations allowed for chance.
EXCESS, CHANCE = 0.3, 4.0
#: Largest m/M; standard errors by which a parameter may exceed its possible range.
LARGEST_MASS, BEYOND = 10.0, 3.0
#: Share of the clearance by which the free mass may pass a wall between two impacts that are used (or CHANCE
#: errors of the displacement), number of instants of a flight at which this is checked, and how often flights are
#: fitted anew without those in which it does.
CROSSED, ALONG, CROSSINGS = 0.02, 64, 5
#: Change of the sum of squares above which two minima count as different.
OTHER = 0.01
#: Standard errors that the effects of contacts that last must exceed to be part of a fit.
SHOWN = 3.0
#: Half the mean square of the duration of a force, as a half sine, over that of the depth of `CONTACT`.
SPREAD = 0.5 * (HALF_SINE / OF_CONTACT[0]) ** 2
#: Size of a part of the noise of a load, over the largest one, below which it does not count.
LEAST_PART = 1e-4
#: Number of estimates of friction from momentum alone.
FRICTIONS = 3
#: Share by which coefficients of restitution grow during the record, 0 in every fit: on both walls, and on each.
DRIFTS = ("drift", "drift1", "drift2")


class TooFewError(SingularError):
    """Too few impacts to fit momentum and restitution."""


class Minimum(NamedTuple):
    """Parameters and states of flights at which the residuals of the equations are a minimum."""

    chi: float
    #: Changes of the common parameters and of the states of flights (N + 1, 2), and the other parameters.
    change: _Array
    eta: _Array
    g: _Array
    #: Covariance of all parameters.
    information: _Array
    #: Derivatives of the equations with respect to the parameters, covariances of the equations (bands), residuals
    #: over these, and the impacts of the equations.
    B: _Array
    cov: Covariance
    multiplier: _Array
    ok: _Bool


class Impacts:
    """The equations of momentum and restitution at all impacts between two others, and the parameters that they
    determine."""

    def __init__(
        self, windows: Windows, flown: Flown, shared: Mapping[str, float], guess: Mapping[str, float],
        law: Law, law_speed: float | None, contact: float = 0.0,
    ) -> None:  # fmt: skip
        self.windows, self.flown = windows, flown
        self.signs = signs = np.sign(flown.jumps)
        N = flown.times.size
        resolved = flown.resolved
        self.lawful = lawful = np.zeros(N, dtype=bool)
        lawful[1:-1] = resolved[:-2] & resolved[1:-1] & resolved[2:]
        inner, without = int(lawful.sum()), ""
        if windows.slips is not None:
            # where the slip reverses friction may stick, and its errors are not those of a linear equation
            turned = np.searchsorted(flown.times, windows.slips.turns)
            lawful[turned[turned < N]] = lawful[turned[turned > 0] - 1] = False
            without = f"; {inner - int(lawful.sum())} more are next to a reversal of the slip"
        if lawful.sum() < LEAST_IMPACTS:
            raise TooFewError(
                f"{int(lawful.sum())} of {N} impacts are resolved together with both neighbours{without}: must be "
                f"at least {LEAST_IMPACTS}; {windows.hindered()}"
            )
        # entries of unresolved impacts are not used
        self.states, self.spread, self.turned = (
            x.copy() for x in (flown.states, flown.spread, flown.turned)
        )
        t, X, V, after = windows.events(self.states, flown.common, flown.times)
        push = self.take(windows.slips, windows.friction, windows.static)
        X, V, after = (x + push * self.beside[i] for x, i in ((X, 0), (V, 1), (after, 1)))
        # no data of unresolved impacts are used
        t[~resolved], X[~resolved], V[~resolved], after[~resolved] = flown.times[~resolved], 0, 0, 0
        duration = np.diff(t)
        duration[duration == 0] = 1
        first, second = np.diff(X) / duration, 0.5 * np.diff(signs) / duration
        of_x, of_d = np.zeros((2, N))
        of_x[1:-1], of_d[1:-1] = np.diff(first), np.diff(second)
        jumps = after - V
        # friction bends the flights of the free mass
        bent = push * float(flown.common[0]) ** 2
        jumps[1:-1] += bent * (np.diff(self.mean) + self.once[:-1])
        values = dict(shared)
        #: The terms of the linear equations of momentum.
        self.momentum = jumps, of_x, of_d
        values |= start_of_laws(jumps[lawful], of_x[lawful], of_d[lawful], None, shared, guess)
        z_after, z_before = np.zeros((2, N))
        z_after[:-1] = first + values["d"] * second + bent / values["mu"] * self.mean
        z_before[1:] = z_after[:-1] - bent / values["mu"] * self.once
        closing = signs * (z_before - V)
        good = lawful & (closing > 0)
        ratio = np.where(good, signs * (after - z_after), 0) / np.where(good, closing, 1)
        for name, sign in (("R1", 1), ("R2", -1)):
            own = good & (signs == sign)
            values[name] = shared.get(
                name,
                float(np.clip(np.median(ratio[own]), 0.05, 0.99)) if own.sum() > 2 else guess[name],
            )
        if law.kind != "constant":
            walls = [closing[good & (signs == sign)] for sign in (1, -1)]
            law = law.about(walls, law_speed)
            ends = ("",) if law.kind == law.shape else ("1", "2")
            values |= {name: shared.get(name, value) for name, value in law.start(
                values | {f"exponent{end}": 0.0 for end in ends}
            ).items()}  # fmt: skip
        self.law = law
        self.names = [name for name in ("mu", *law.names, "d") if name not in shared]
        # the gain of the motion sensor is known to within its calibration
        self.calibration = windows.data.calibration
        values["gain"] = 1.0
        #: Standard errors of what is known without the impacts: the gain, and the effects of contacts, which may
        #: last as long as given, or have none.
        self.doubtful = dict(zip(CONTACT, (contact * share for share in OF_CONTACT), strict=True))
        self.doubtful["gain"] = self.calibration
        values |= dict.fromkeys(CONTACT, 0.0)
        self.names += [name for name, error in self.doubtful.items() if error > 0]
        self.values = values
        self.walls = [law.of_wall(i) for i in (0, 1)]
        # known values, with respect to which derivatives are computed after the fit, and the absence of drift
        self.held = [name for name in ("mu", *law.names, "d") if name in shared]
        self.held += [name for name in CONTACT if name not in self.names]
        self.held += EXPONENTS if law.kind == "constant" else ()
        self.values |= dict.fromkeys((*DRIFTS, *EXPONENTS), 0.0) | {"friction": windows.friction}
        #: The approach speeds of the inner impacts, from the first guess.
        self.closing = closing[1:-1]
        self.elapsed = flown.times[1:-1] / np.ptp(windows.t)
        self.active = lawful[1:-1].copy()
        #: Changes of the equations by the independent parts of the noise of the load.
        self.shared = np.zeros((2 * self.active.size, 0))
        self.g = np.array([values[name] for name in self.names])
        self.typical = [
            max(abs(self.g[j]), 1e-3)
            if name in ("mu", "d")
            else TRIED * self.doubtful[name]
            if name in CONTACT
            else law.typical(name, values[name])
            for j, name in enumerate(self.names)
        ]
        #: The information on the parameters without the impacts, and their values by it.
        self.weights = np.array([self.doubtful.get(name, math.inf) for name in self.names]) ** -2.0
        self.middle = self.g.copy()
        self.scales = np.array(
            [
                *(max(abs(flown.common[i]), 1e-3) if i != 3 else 1.0 for i in flown.free),
                *self.typical,
            ]
        )
        #: Time of flight of the free mass before each impact and after the last (N - 1), s.
        self.duration = duration
        if flown.further is not None:
            self.shared = self.by_noise(*flown.further)

    @property
    def usual(self) -> _Array:
        """The mean speed of the impacts used on the wall of each inner impact, to which a constant R applies."""
        signs, used = self.signs[1:-1], self.active & (self.closing > 0)
        walls = [self.closing[used & (signs == sign)] for sign in (1, -1)]
        right, left = (float(own.mean()) if own.size else 1.0 for own in walls)
        return np.where(signs > 0, right, left)

    @np.errstate(all="ignore")  # where flights do not exist
    def by_noise(self, w: _Array, sizes: NDArray[np.complex128], states: _Array) -> _Array:
        """The changes of the equations by independent parts of the noise of the load, which also change the states
        of the flights as given."""
        data = self.windows.data
        assert data.forced is not None
        if not w.size:
            return self.shared
        noisy = replace(data, forced=data.forced.with_further(w, sizes))
        moved = self.states + 1j * STEP * np.moveaxis(states, -1, 0)
        found = self.constraints(moved, self.flown.common + 0j, self.g + 0j, noisy)
        by = np.where(np.isfinite(found), found, 0.0).imag / STEP
        every = by.reshape(w.size, -1).T
        # fewer parts with the same covariance
        size = np.maximum(np.linalg.norm(every, axis=1), 1e-300)[:, None]
        left, sizes_of, _ = np.linalg.svd(every / size, full_matrices=False)
        kept = sizes_of > LEAST_PART * sizes_of[0]
        return np.asarray(size * left[:, kept] * sizes_of[kept], dtype=np.float64)

    def take(self, slips: Slips | None, friction: float, static: float) -> float:
        """Take friction into account in the equations, for a static displacement under F0; return the static
        displacement under the friction."""
        #: The slip in the flights, if friction is part of the equations.
        self.slips, self.static = slips, static
        N = self.flown.times.size
        #: Response of the primary mass, its rate, and its acceleration before and after the impacts, and integrals
        #: over the flights between them.
        self.beside, self.once, self.mean = np.zeros((4, N)), np.zeros(N - 1), np.zeros(N - 1)
        if slips is not None:
            x, v = (slips.at(self.flown.times, order) for order in (0, 1))
            square = slips.omega**2
            rest = -square * x - 2 * slips.xi * slips.omega * v
            # the slip, that of the free mass against the wall, reverses at the impact
            self.beside = np.stack([x, v, rest + square * self.signs, rest - square * self.signs])
            self.once, self.mean = slips.between(self.flown.times)
        return friction * static

    def constraints(self, states: Any, common: Any, g: Any, data: Measured | None = None) -> Any:
        """Momentum and restitution at the inner impacts (..., N - 2, 2), under the load of the windows or of other
        data."""
        data = data or self.windows.data
        every, signs, rubs = [*self.names, *self.held, *DRIFTS], self.signs, self.slips is not None
        value = {**self.values, **{every[j]: g[..., j, None] for j in range(g.shape[-1])}}
        t, X, V, after = self.windows.events(states, common, self.flown.times, data)
        if rubs:
            push, off = value["friction"] * self.static, t - self.flown.times
            x, v, a_before, a_after = self.beside
            X = X + push * (x + v * off)
            V, after = V + push * (v + a_before * off), after + push * (v + a_after * off)
        z = X + 0.5 * signs * value["d"] * value["gain"]
        z = z + (1 + 1 / value["mu"]) * value["depth"] * (after - V)
        flight = np.diff(z, axis=-1) / np.diff(t, axis=-1)
        one, two = flight[..., :-1], flight[..., 1:]
        if rubs:
            drag = push * common[..., None, 0] ** 2 / value["mu"]
            # the slip reverses at the impacts, at their own times
            once, mean, T = self.once, self.mean, np.diff(self.flown.times)
            begin, end = off[..., :-1], off[..., 1:]
            once, mean = (
                once + signs[:-1] * begin + signs[1:] * end,
                mean + (signs[:-1] + mean / T) * begin + (once - mean) / T * end,
            )
            one = one + (drag * (mean - once))[..., :-1]
            two = two + (drag * mean)[..., 1:]
        omega, xi, static, phase = (common[..., None, i] for i in range(4))
        rate = accelerated(data, omega, xi, static, phase, t, X, 0.5 * (V + after))[..., 1:-1]
        V, after, sign = V[..., 1:-1], after[..., 1:-1], signs[1:-1]
        speed = sign * (one - V)
        # the law depends on speeds, which the sensor scales by its gain
        true_speed = np.where(speed.real > 0, speed, 1.0) / value["gain"]
        R = np.where(
            sign > 0,
            *(
                self.law.coefficient(i, [value[name] for name in self.walls[i]], true_speed)
                for i in (0, 1)
            ),
        )
        own = np.where(sign > 0, value["drift1"], value["drift2"])
        R = R * (1 + self.elapsed * (value["drift"] + own))
        if len(self.names) < g.shape[-1] and self.law.kind == "constant":
            # for the derivatives after the fit
            exponent = np.where(sign > 0, *(value[name] for name in EXPONENTS))
            R = R * (true_speed / self.usual) ** -exponent
        # a force that lasts makes the primary mass oscillate less than its impulse
        less = SPREAD * (omega * value["depth"]) ** 2
        momentum = (after - V) * (1 + less) + value["mu"] * (two - one)
        restitution = two - after + sign * R * speed - (1 - R) * value["push"] * rate
        return np.stack([momentum, restitution], axis=-1)

    def equations(self, here: _Array, change: _Array, g: _Array) -> tuple[Any, ...]:
        """The constraints for given states, their derivatives with respect to states, common parameters and the
        others, and the impacts that they belong to."""
        free = self.flown.free[self.flown.free < 4]
        c, A, C, G = slopes(self.constraints, here, self.common(change), g, free)
        ok = self.active & np.isfinite(c).all(axis=1) & np.isfinite(A).all(axis=(1, 2, 3))
        through = passed_on(A, C, self.turned)
        for array in (c, A, through, G):
            array[~ok] = 0
        return c, A, through, G, ok

    def common(self, change: _Array) -> _Array:
        """The common parameters, with changed values of the free ones."""
        common = self.flown.common.copy()
        common[self.flown.free] += change
        return common

    def here(self, at: Minimum) -> _Array:
        """The states of the flights at a minimum."""
        states: _Array = self.states - self.turned @ at.change + at.eta
        return states

    @np.errstate(all="ignore")  # where flights do not exist
    def crossed(self, at: Minimum) -> _Bool:
        """Flights (N + 1) in which the free mass, straight from impact to impact, would pass a wall: they hide an
        impact."""
        N, value = self.flown.times.size, dict(zip(self.names, at.g, strict=True))
        common, here = self.common(at.change), self.here(at)
        t, X, _, _ = self.windows.events(here, common, self.flown.times)
        d = value.get("d", self.values["d"]) * value.get("gain", 1.0)
        # the free mass moves beyond a wall by the depth of a contact, but does not pass it
        z = X + 0.5 * self.signs * d
        along = np.linspace(0, 1, ALONG)
        x = np.zeros((N + 1, ALONG))
        x[1:-1] = np.diff(t)[:, None] * along + t[:-1, None]
        times, x = x[1:-1], self.windows.displacements(here, common, x)[1:-1]
        path = np.diff(z)[:, None] * along + z[:-1, None]
        if self.slips is not None:
            push = self.values["friction"] * self.static
            x = x + push * self.slips.at(times, 0)
            # chords between the ends of the bent flights
            twice = self.slips.sums(times)[1]
            chord = twice[:, :1] + (twice[:, -1:] - twice[:, :1]) * along
            mu = value.get("mu", self.values["mu"])
            path = path + push * self.slips.omega**2 / mu * (chord - twice)
        apart = abs(path - x).max(axis=1)
        # flights of the equations that are used
        active = np.zeros(N, dtype=bool)
        active[1:-1] = at.ok
        crossed = np.zeros(N + 1, dtype=bool)
        error = np.sqrt(np.trace(self.spread, axis1=1, axis2=2))[1:-1]
        beyond = apart - 0.5 * d > np.maximum(CROSSED * d, CHANCE * error)
        crossed[1:-1] = (active[:-1] | active[1:]) & beyond
        return crossed

    def rubbed(self, at: Minimum) -> tuple[Flown, _Array]:
        """The flights with friction as the only known common parameter, and the derivatives of all equations with
        respect to it (equations, 1)."""
        value = self.values | dict(zip(self.names, at.g.tolist(), strict=True))
        here, common = self.here(at), self.common(at.change)
        flown, windows = self.flown, self.windows
        if self.slips is None:
            self.take(slips_of(windows, flown, here, common, value, 0.0), 0.0, float(common[2]))
        assert self.slips is not None
        states, inverse, _, left, _, _ = windows.fitted(windows.common)
        samples = self.static * self.slips.at(windows.t[windows.used], windows.data.order)
        turned, slope, weight, shared = windows.along(samples, states, inverse, left)
        every = flown._replace(
            held=np.array([shared.size]), slope=np.append(flown.slope, slope),
            every_weight=np.block([[flown.every_weight, shared[:, None]], [shared, weight]]),
        )  # fmt: skip
        held, self.held = self.held, ["friction"]
        at_it = np.append(at.g, self.values["friction"])
        _, A, C, G = slopes(self.constraints, here, common, at_it, flown.free[:0])
        self.held = held
        by: _Array = passed_on(A, C, turned[..., None]) + G[..., -1:]
        by[~at.ok] = 0
        return every, by.reshape(-1, 1)

    @np.errstate(all="ignore")
    def settled(self, change: _Array, eta: _Array, g: _Array, judge: bool) -> Minimum:
        """The minimum reached by iteration from given parameters and states.

        With `judge`, impacts that do not follow the laws are discarded during the iteration.
        """
        flown, spread = self.flown, self.spread
        n, F = self.active.size, flown.free.size
        chi = math.inf
        for rounds in range(STEPS):
            here = self.states - self.turned @ change + eta
            c, A, through, G, ok = self.equations(here, change, g)
            local = np.stack([eta[j : j + n] for j in range(4)], axis=1)
            w = c - np.einsum("nclq,nlq->nc", A, local) - through @ change
            if judge and rounds in JUDGED:
                own = w + np.concatenate([through, G], axis=-1) @ np.append(
                    change, np.zeros(g.size)
                )
                self.judged(own, own_blocks(A, spread, ok), ok)
                ok &= self.active
                for array in (A, through, G, w):
                    array[~ok] = 0
            cov = Covariance(banded(A, spread, ok), self.shared * np.repeat(ok, 2)[:, None])
            B = np.concatenate([through, G], axis=-1).reshape(2 * n, -1)
            both = np.column_stack([B, w.reshape(-1)])
            try:
                solved = cov.solve(both)
            except (np.linalg.LinAlgError, ValueError):
                break
            information = B.T @ solved[:, :-1]
            information[:F, :F] += flown.weights
            slope = B.T @ solved[:, -1]
            own = np.arange(F, F + g.size)
            information[own, own] += self.weights
            slope[F:] += self.weights * (g - self.middle)
            step = -scaled_solve(information, slope, self.scales)
            new, dg = step[:F], step[F:]
            part = min(
                [1.0, *(0.5 * self.typical[j] / max(abs(dg[j]), 1e-300) for j in range(g.size))]
            )
            # with nonlinear equations the iteration may oscillate about the minimum
            part = min(part, DAMPED) if rounds > JUDGED[-1] else part
            multiplier = solved[:, -1] + solved[:, :-1] @ step
            M = multiplier.reshape(n, 2)
            new_eta = np.zeros_like(eta)
            for j in range(4):
                new_eta[j : j + n] -= np.einsum("nqr,ncr,nc->nq", spread[j : j + n], A[:, :, j], M)
            old = chi
            chi = float(multiplier @ (w.reshape(-1) + B @ step)) + float(new @ flown.weights @ new)
            off = np.append(new - change, dg)
            moved = float(off @ information @ off)
            change, eta, g = (
                change + part * (new - change),
                eta + part * (new_eta - eta),
                g + part * dg,
            )
            if not (np.isfinite(g).all() and np.isfinite(change).all()):
                break
            enough = rounds > (JUDGED[-1] if judge else 1) and part >= DAMPED
            if enough and (moved < 1e-4 or abs(old - chi) < 1e-4):
                return Minimum(chi, change, eta, g, information, B, cov, multiplier, ok)
        raise SingularError(
            f"the fit of momentum and restitution at {int(self.active.sum())} impacts did not converge; {HINT}"
        )

    def judged(self, own: _Array, block: _Array, ok: _Bool) -> None:
        """Discard impacts that do not follow the laws, because they are of another kind or next to such an impact:
        `own` are the residuals of the two equations of each impact, `block` their covariance."""
        size = np.einsum("na,nab,nb->n", own, np.linalg.inv(block), own)
        usual = max(1.0, float(np.median(size[ok])) / 1.386)
        self.active &= ~(ok & (size > usual * UNLAWFUL**2))
        if self.active.sum() < max(LEAST_IMPACTS, LAWFUL * self.lawful.sum()):
            raise SingularError(
                f"{int(self.active.sum())} of {int(self.lawful.sum())} impacts agree with momentum and "
                f"restitution for a single set of parameters: too few; {HINT}"
            )

    def minima(self) -> list[Minimum]:
        """The minima, lowest first.

        If an impact hardly changes the flights that it separates, or is just before or after another impact, its
        equations are not linear within the errors of the states: a gap that closes slowly may close at two times.
        The time of each such impact is moved in both directions (impacts far enough apart are moved together), and
        states near the impact are replaced if they then fit better.
        """
        N = self.flown.times.size
        best = self.settled(np.zeros(self.flown.free.size), np.zeros((N + 1, 2)), self.g, True)
        found = [best]
        by = self.windows.by_states(self.here(best), self.common(best.change), self.flown.times)[
            :, :, 0
        ]
        toward = np.einsum("snab,snb->sna", np.stack([self.spread[:-1], self.spread[1:]]), by)
        error = np.sqrt(np.einsum("sna,sna->n", toward, by))
        blurred = np.zeros(N, dtype=bool)
        blurred[1:-1] = self.active & (
            error[1:-1] > BLURRED * np.minimum(self.duration[:-1], self.duration[1:])
        )
        inverse = np.linalg.inv(self.spread)
        for some in far_apart(np.flatnonzero(blurred).tolist()):
            for sign in (MOVED, -MOVED):
                eta = best.eta.copy()
                eta[some] += sign * toward[0, some] / error[some, None]
                eta[[i + 1 for i in some]] += sign * toward[1, some] / error[some, None]
                other = self.settled_from(best, eta)
                if other is None:
                    continue
                tried = [other]
                each = [
                    np.einsum("na,nab,nb->n", one.eta, inverse, one.eta) for one in (best, other)
                ]
                gain = np.convolve(each[0] - each[1], np.ones(2 * REACH + 1), "same")
                better = [i for i in some if max(gain[i], gain[i + 1]) > 1]
                if 0 < len(better) < len(some):
                    eta = best.eta.copy()
                    for i in better:
                        about = slice(max(i + 1 - REACH, 0), i + 1 + REACH)
                        eta[about] = other.eta[about]
                    tried += filter(None, [self.settled_from(best, eta)])
                found += tried
                best = min([best, *tried], key=lambda one: one.chi)
        return sorted(found, key=lambda one: one.chi)

    def settled_from(self, at: Minimum, eta: _Array) -> Minimum | None:
        """The minimum reached from given parameters with other states; None if there is none."""
        try:
            other = self.settled(at.change, eta, at.g, False)
        except SingularError:
            return None
        return other if (other.ok == at.ok).all() else None


def far_apart(places: list[int]) -> list[list[int]]:
    """Indices, divided into lists in which they are far from each other."""
    lists: list[list[int]] = []
    for i in places:
        free = next((own for own in lists if i - own[-1] >= APART), None)
        if free is None:
            lists.append([i])
        else:
            free.append(i)
    return lists


def by_laws(
    windows: Windows, flown: Flown, shared: Mapping[str, float], guess: Mapping[str, float], law: Law,
    law_speed: float | None, rough: bool = False,
) -> tuple[Fit, Law, _Bool]:  # fmt: skip
    """The parameters from momentum and restitution at all impacts, and the impacts for which these laws hold.

    Impacts have no duration, unless the record shows that contacts last, by as much as their pulses allow.
    """
    given, poor = (shared, guess, law, law_speed), windows.poor.copy()
    contact = 0.0 if rough else windows.contact(flown)
    plain: tuple[Fit, Law, _Bool] | None = None
    failed: SingularError | None = None
    shown = math.inf
    try:
        plain = of_laws(windows, flown, *given, 0.0, rough)
        shown = max(
            (abs(plain[0].strains[name].size) for name in CONTACT if name in plain[0].strains),
            default=0,
        )
    except SingularError as error:
        failed = error
    if contact and shown > SHOWN and not (law.friction or isinstance(failed, TooFewError)):
        kept = dict(vars(windows))
        windows.poor = poor
        with contextlib.suppress(SingularError, np.linalg.LinAlgError):
            other = of_laws(windows, windows.without(poor), *given, contact, rough)
            if plausible(other[0], contact):
                assert other[0].of_effects is not None
                allow_effects(other[0], contact, *other[0].of_effects)
                return other
        vars(windows).update(kept)
    if plain is None:
        assert failed is not None
        raise failed
    if not rough:
        assert plain[0].of_effects is not None
        allow_effects(plain[0], contact, *plain[0].of_effects)
    return plain


def plausible(found: Fit, contact: float) -> bool:
    """Whether the fitted effects of contacts are those of contacts of about a given duration, and clear."""
    clear = False
    for name, share in zip(CONTACT, OF_CONTACT, strict=True):
        value, error = found.lasting[name]
        if not -BEYOND * error <= value <= MORE * share * contact + BEYOND * error:
            return False
        clear = clear or value > SHOWN * error
    return clear


def of_laws(
    windows: Windows, flown: Flown, shared: Mapping[str, float], guess: Mapping[str, float], law: Law,
    law_speed: float | None, contact: float, rough: bool,
) -> tuple[Fit, Law, _Bool]:  # fmt: skip
    """The parameters as in `by_laws`, with effects of contacts of up to a given duration that are fitted as well.

    If the response to friction is not part of the flights, the friction is known, or fitted if it is not among the
    `shared` values: then the value is the one whose response was subtracted from the record, and the strain is its
    distance from the fitted one. A `rough` fit, which only provides a start, may contradict what is known.
    """
    for _ in range(CROSSINGS):
        impacts = Impacts(windows, flown, shared, guess, law, law_speed, contact)
        minima = impacts.minima()
        best = minima[0]
        crossed = impacts.crossed(best)
        if not crossed.any():
            break
        flown = windows.without(windows.poor | crossed)
    else:
        raise SingularError(
            f"the free mass would pass a wall in flights at whose ends momentum and restitution hold; {HINT}"
        )
    law, names, values, scales = impacts.law, impacts.names, impacts.values, impacts.scales
    change, g, held = best.change, best.g, impacts.held
    common = impacts.common(change)
    for place, name in ((2, "static"), (3, "phase")):
        if name in windows.priors and not rough:
            value, error = windows.priors[name]
            if abs(common[place] - value) > FAR_OFF * error:
                raise SingularError(
                    f"the load of its channel is {abs(common[place] - value) / error:.3g} standard errors away "
                    f"from the one that the motion implies; {HINT}"
                )
    calibration = impacts.calibration
    if calibration and not rough and abs(g[-1] - 1) > FAR_OFF * calibration:
        raise SingularError(far_off_gain(float(g[-1]), calibration))
    # errors increase with the residuals of the laws, and with noise that is stronger at low frequencies
    count = 2 * int(best.ok.sum())
    misfit = best.chi / max(1, count - g.size)
    here = impacts.here(best)
    of_noise = noise_information(
        lambda states: impacts.equations(states, change, g)[1:],
        here,
        impacts.spread,
        impacts.shared,
        here.shape[0],
    )
    sizes = np.outer(scales, scales)
    J = without_noise(best.information * sizes, of_noise * sizes) / scales
    covariance, vague, _ = covariance_of(J, scales)
    variance = max(1.0, misfit) * flown.colour
    places = [
        *(
            ("omega", "xi", "F0/K 0", "phase", "offset")[i] if i < 5 else f"pole {i}"
            for i in flown.free
        ),
        *names,
    ]
    order = [
        name
        for name in ("omega", "xi", *names, "F0/K 0")
        if name in places and name not in impacts.doubtful
    ]
    strains = strains_of(
        windows, common, dict(zip(places, np.diag(covariance).tolist(), strict=True)), variance
    )
    # known natural frequency and damping ratio, other known parameters, and what might drift
    tested = [*held, *DRIFTS]
    _, A, C, G = slopes(
        impacts.constraints,
        here,
        common,
        np.append(g, [values[name] for name in tested]),
        flown.held,
    )
    by_held = np.concatenate(
        [passed_on(A, C, flown.every_turned[:, :, flown.held]), G[..., g.size :]], axis=-1
    )
    by_held[~best.ok] = 0
    by_held = by_held.reshape(-1, by_held.shape[-1])
    every, by_friction = impacts.rubbed(best)
    fitted = law.friction and "friction" not in shared
    H = flown.held.size
    both = every._replace(held=np.append(flown.held, every.held)) if fitted else flown
    of_what = [*(("omega", "xi")[i] for i in flown.held), *["friction"] * fitted, *tested]
    by_what = np.column_stack([by_held[:, :H], by_friction, by_held[:, H:]]) if fitted else by_held
    also = H if fitted else None
    of_held, leans, *_ = held_strains(
        both, of_what, by_what, best.multiplier, change, best.cov, best.B, covariance, variance, places, also
    )  # fmt: skip
    # friction and contacts may resemble other parameters: their tests use all information, including that of noise
    inverse = np.asarray(
        np.linalg.pinv(best.information * sizes, rcond=1e-12, hermitian=True) * sizes, dtype=np.float64
    )  # fmt: skip
    of_friction, by, *_ = held_strains(
        every, ["friction"], by_friction, best.multiplier, change, best.cov, best.B, inverse, variance, places
    )  # fmt: skip
    of_held, leans = of_held | of_friction, leans | by
    effects = [name for name in (*CONTACT, *EXPONENTS) if name in held]
    of_effects = None
    if not rough:
        *_, information, pull = held_strains(
            both, of_what, by_what, best.multiplier, change, best.cov, best.B, inverse, variance, places, also
        )  # fmt: skip
        own = [of_what.index(name) for name in effects]
        of_effects = effects, information[np.ix_(own, own)], pull[own]
    drifts = {name: of_held.pop(name) for name in DRIFTS if name in of_held} | trends_of(flown)
    leans = {name: by for name, by in leans.items() if name not in DRIFTS}
    strains |= of_held
    covariance = variance * covariance + beyond(minima, variance)
    if fitted:
        # all parameters change with friction, whose error is that of its score test
        strain = strains.get("friction")
        error = strain.change / strain.size if strain and strain.size else math.inf
        lean = np.append([leans["friction"][name] for name in places], 1.0)
        covariance = np.pad(covariance, (0, 1))
        if math.isfinite(error):
            covariance += np.outer(lean, lean) * error**2
        places.append("friction")
        order.insert(len(order) - ("F0/K 0" in order), "friction")
        if not error < VAGUE * TYPICAL_FRICTION:
            vague = vague | {places.index("friction")}
        del leans["friction"]
    columns = [places.index(name) for name in order]
    values |= {"omega": float(common[0]), "xi": float(common[1])}
    values |= dict(zip(names, g.tolist(), strict=True))
    # the equations hold to first order in the duration; the remainder is about as large as its known part
    less = SPREAD * (values["omega"] * values["depth"]) ** 2
    for i, name in enumerate(places):
        if name in ("xi", "mu", "d"):
            covariance[i, i] += (less * values[name]) ** 2
    lawful = impacts.lawful.copy()
    lawful[1:-1] = best.ok
    part = covariance[np.ix_(columns, columns)]
    if calibration:
        # the length F0/K is in the units of the sensor
        place = order.index("F0/K 0")
        part[place, place] += (calibration * common[2]) ** 2
    found = Fit(
        {name: values[name] for name in (*law.shared, *CONTACT)}, [float(common[2])], [float(common[3])], [],
        order, part, [name for name in order if places.index(name) in vague],
        [misfit * flown.colour], variance, strains=strains, leans=leans, drifts=drifts, early=flown.early,
        most=min(DOUBTFUL, flown.colour * bearable(count - g.size)), slips=impacts.slips,
        gain=float(g[-1]) if calibration else 1.0, of_effects=of_effects,
    )  # fmt: skip
    if contact:
        every_error = dict(zip(places, np.sqrt(np.diag(covariance)).tolist(), strict=True))
        found.contact = contact
        found.lasting = {name: (values[name], every_error[name]) for name in CONTACT}
    if not rough:
        possible(found, int(best.ok.sum()))
    return found, law, lawful


def possible(found: Fit, count: int) -> None:
    """Raise an error if parameters are outside their possible range by more than their errors; otherwise limit
    them to this range.

    The equations for a few similar impacts also have solutions that are physically impossible.
    """
    bounds = {"xi": (0.0, 0.9), "mu": (0.0, LARGEST_MASS), "d": (0.0, math.inf)}
    bounds |= {name: (0.0, 1.0) for name in found.values if name[0] == "R"}
    for name in bounds.keys() & set(found.names):
        (low, high), value = bounds[name], found.values[name]
        place = found.names.index(name)
        error = math.inf
        if name not in found.undetermined:
            error = BEYOND * math.sqrt(found.covariance[place, place])
        if not low - error <= value <= high + error:
            raise SingularError(
                f"momentum and restitution at {count} impacts give {name} = {value:.4g}: must be from {low:g} to "
                f"{high:g}; {HINT}"
            )
        found.values[name] = min(max(value, low), high)


def bearable(freedom: int) -> float:
    """The misfit, for a number of degrees of freedom, that noise alone rarely exceeds."""
    return 1 + max(EXCESS, CHANCE * math.sqrt(2 / max(freedom, 1)))


def beyond(minima: list[Minimum], variance: float) -> _Array:
    """The contribution of other minima to the covariance of the parameters about the lowest one, weighted by
    likelihood."""
    points: list[_Array] = []
    chis: list[float] = []
    for one in minima:
        if not chis or all(abs(one.chi - chi) > OTHER for chi in chis):
            points.append(np.append(one.change, one.g))
            chis.append(one.chi)
    weights = np.exp(-0.5 * (np.array(chis) - chis[0]) / variance)
    off = np.array(points) - points[0]
    both: _Array = (off.T * (weights / weights.sum())) @ off
    return both


def by_flights(windows: Windows, flown: Flown, shared: Mapping[str, float], law: Law) -> Fit:
    """The parameters from flights alone: natural frequency, damping and load, without the equations of the
    impacts."""
    common, free = flown.common, flown.free
    names = ["omega", "xi", "F0/K 0", "phase", "offset", *(["pole"] * common.size)]
    values = {
        "omega": float(common[0]),
        "xi": float(common[1]),
        **dict.fromkeys(law.shared, math.nan),
        **shared,
    }
    values |= {"omega": float(common[0]), "xi": float(common[1])}
    covariance = np.asarray(np.linalg.inv(flown.weights), dtype=np.float64)
    variances = {names[i]: float(covariance[j, j]) for j, i in enumerate(free.tolist())}
    strains = strains_of(windows, common, variances, flown.colour)
    strains |= held_strains(
        flown, [("omega", "xi")[i] for i in flown.held], np.zeros((0, len(flown.held))), np.zeros(0),
        np.zeros(free.size), None, np.zeros((0, free.size)), covariance, flown.colour,
        [names[i] for i in free],
    )[0]  # fmt: skip
    covariance *= flown.colour
    kept = [j for j, i in enumerate(free) if i < 3]
    none = [name for name in law.shared if name not in shared and name not in ("omega", "xi")]
    both = np.zeros((len(kept) + len(none),) * 2)
    both[: len(kept), : len(kept)] = covariance[np.ix_(kept, kept)]
    return Fit(
        values, [float(common[2])], [float(common[3])], [], [*(names[free[j]] for j in kept), *none], both, none,
        [flown.colour], flown.colour, strains=strains, drifts=trends_of(flown), early=flown.early,
    )  # fmt: skip


def start_of_friction(
    windows: Windows,
    shared: Mapping[str, float],
    guess: Mapping[str, float],
    law: Law,
    friction: float,
) -> tuple[dict[str, float], Slips]:
    """mu, d and friction over F0 of a record without parameters that fulfil the laws with some friction, and the
    slip.

    Momentum at the impacts alone gives mu and d with this friction, with which the slip is known, and then all
    three.
    """
    flown = windows.without(windows.poor)
    impacts = Impacts(windows, flown, shared, guess, law, None)
    values = impacts.values
    for _ in range(FRICTIONS):
        slips = slips_of(windows, flown, flown.states, windows.common, values, friction)
        once, mean = slips.between(flown.times)
        of_friction = np.zeros(flown.times.size)
        of_friction[1:-1] = windows.common[2] * slips.omega**2 * (np.diff(mean) + once[:-1])
        own = [x[impacts.lawful] for x in (*impacts.momentum, of_friction)]
        values = values | start_of_laws(own[0], own[1], own[2], own[3], shared, guess)
    values["friction"] += friction
    return values, slips


def start_of_laws(
    jumps: _Array, of_x: _Array, of_d: _Array, of_friction: _Array | None, shared: Mapping[str, float],
    guess: Mapping[str, float],
) -> dict[str, float]:  # fmt: skip
    """mu and d from linear equations in which outliers among the impacts have small weights; with friction, if the
    derivatives of the equations with respect to it are given."""
    mu, d = shared.get("mu", guess["mu"]), shared.get("d", math.nan)
    rest, columns = jumps, [of_x, of_d]
    if "d" in shared:
        columns = [of_x + d * of_d]
    if "mu" in shared:
        rest = jumps + mu * columns[0]
        columns = [mu * of_d] * ("d" not in shared)
    known = len(columns)
    columns += [of_friction] if of_friction is not None else []
    x, weights = np.zeros(len(columns)), np.ones(jumps.size)
    A = np.column_stack([np.zeros((jumps.size, 0)), *columns])
    for _ in range(20 if columns else 0):
        root = np.sqrt(weights)[:, None]
        size = np.maximum(np.linalg.norm(A * root, axis=0), 1e-300)
        x = np.linalg.lstsq(A * root / size, -rest * root[:, 0], rcond=1e-6)[0] / size
        left = rest + A @ x
        spread = max(float(np.median(abs(left))) / 0.6745, 1e-300)
        weights = 1 / (1 + (left / (2 * spread)) ** 2) ** 2
    if "mu" not in shared:
        mu = float(x[0])
    if "d" not in shared:
        d = float(x[known - 1]) / (mu or math.nan) if "mu" not in shared else float(x[0])
    if not 0 < mu < 10:
        mu = guess["mu"]
    if not (math.isfinite(d) and d > 0):
        d = shared.get("d", 1e-3)
    found = {"mu": mu, "d": d}
    if of_friction is not None:
        found["friction"] = float(x[-1])
    return found
