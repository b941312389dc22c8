"""Exact motions of a rig under a load with harmonics, with coefficients of restitution that follow a law, and
their derivatives.

With the angles and jumps of the impacts given, the motion of the primary mass is a sum of closed forms: the steady
motion under the load, and the periodic response to impulses. Momentum and restitution at each impact are then two
equations, which Newton's method solves. All derivatives are computed by complex steps, which have no cancellation
errors.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base.errors import SingularError
from ..motions.exact import exact, exact_structure
from ..motions.motion import Motion
from ..systems.oscillator import Oscillator, Pattern
from ..systems.restitution import Restitution
from ..systems.structure import Load
from .laws import Law, law_of
from .waves import Measured

_Array = NDArray[np.float64]
_Complex = NDArray[np.complex128]
#: Parameters of the motion of a record: system, F0/K in m and the load phase at time 0; then the parameters of the
#: law of the right wall, and those of the left one.
PARAMETERS = ("omega", "xi", "mu", "d", "F0/K", "phase")
#: Approach speed, relative to the largest velocity, that counts as zero.
TOUCHING = 1e-6
#: The imaginary step; relative change of a step of Newton's method at its end, and the most steps to there.
STEP, SETTLED, MOST_STEPS = 1e-30, 1e-11, 25
#: Largest fraction of the time to the next impact by which a step of Newton's method moves an impact.
FARTHEST = 0.3


#: What contacts that last change (s): how far the free mass goes beyond the wall, over its jump of velocity; and
#: how much faster it leaves a wall that accelerates towards it, over this acceleration and 1 - R.
CONTACT = ("depth", "push")


class Impacting(NamedTuple):
    """The impacts of a period: angles Omega t, jumps of the velocity of the primary mass, approach speeds,
    coefficients of restitution; derivatives of angles and jumps with respect to all parameters (2, N, P). With
    friction in the slot, also the angles at which the slip reverses, the impacts before these reversals, and the
    response to friction at the samples of the record with its derivatives (n, P), and as a function of angles."""

    angles: _Array
    jumps: _Array
    speeds: _Array
    restitution: _Array
    by: _Array
    turns: Any = None
    flight: Any = None
    aside: Any = None
    aside_by: Any = None
    at: Callable[[_Array], _Array] | None = None


class System:
    """The data shared by all motions of a record, with a law of restitution."""

    def __init__(self, data: Measured, law: Law) -> None:
        self.data = data
        self.Omega, self.k = data.Omega, data.k
        self.signs = data.pattern.signs.astype(float)
        self.law = law
        self.orders, self.shape = data.orders, data.shape
        #: The jump of the velocity of the primary mass at which the depth of contacts is part of d.
        self.usual = 0.0
        N = self.signs.size
        self.later = 2 * math.pi * self.k * np.triu(np.ones((N, N)), 1)
        self.last = 2 * math.pi * self.k * np.eye(N)[-1]

    def impacts(
        self, p: Any, angles: Any, jumps: Any, rows: Any = slice(None), of: Any = slice(None)
    ) -> tuple[Any, Any, Any]:
        """Both equations of each impact (..., 2N), approach speeds and coefficients of restitution.

        The parameters `p` (P, ...), angles and jumps (..., N) may be complex; the last two parameters may be
        those of `CONTACT`. Among several points, `rows` selects those with different angles, omega or xi, and `of`
        is the index in `rows` for each point.
        """
        n = len(self.law.of_wall(0))
        omega, xi, mu, d, static, phase, *walls = (value[..., None] for value in p)
        walls, (depth, push) = walls[: 2 * n], walls[2 * n :] or (0.0, 0.0)
        X, V = self.loaded(omega, xi, static, phase, angles)
        by_time, response = (
            part[of] for part in self.responses(omega[rows], xi[rows], angles[rows])
        )
        X = X + (response @ jumps[..., None])[..., 0]
        V = V + (by_time @ jumps[..., None])[..., 0]
        # without a free mass, which a fit may reach, there is no depth
        more = 1 / np.where(mu == 0, math.inf, mu)
        beyond = (1 + more) * depth * (self.signs * jumps - self.usual)
        z = X + self.signs * (d / 2 + beyond)
        flights = np.roll(angles, -1, axis=-1) - angles + self.last
        after = self.Omega * (np.roll(z, -1, axis=-1) - z) / flights
        before = np.roll(after, 1, axis=-1)
        speeds = self.signs * (before - V + jumps / 2)
        right = self.signs > 0
        positive = np.where(speeds.real > 0, speeds, 1.0)
        each = (self.law.coefficient(i, w, positive) for i, w in enumerate((walls[:n], walls[n:])))
        R = np.where(right, *each)
        momentum = jumps + mu * (after - before)
        rate = accelerated(self.data, omega, xi, static, phase, angles / self.Omega, X, V)
        restitution = after - V - jumps / 2 + self.signs * R * speeds - (1 - R) * push * rate
        return np.concatenate([momentum, restitution], axis=-1), speeds, R

    def loaded(self, omega: Any, xi: Any, static: Any, phase: Any, angles: Any) -> tuple[Any, Any]:
        """The steady motion under each harmonic of the load, displacement and velocity, at given angles (..., n);
        the parameters (..., 1)."""
        w, F = self.orders * self.Omega, omega**2 * static
        a, b = omega**2 - w**2, 2 * xi * omega * w
        size = F / (a**2 + b**2)
        P = (size * (self.shape.real * a + self.shape.imag * b))[..., None, :]
        Q = (size * (self.shape.imag * a - self.shape.real * b))[..., None, :]
        turn = self.orders * (angles + phase)[..., None]
        cosine, sine = np.cos(turn), np.sin(turn)
        X = (P * cosine - Q * sine).sum(axis=-1)
        V = -(w * (P * sine + Q * cosine)).sum(axis=-1)
        return X, V

    def responses(self, omega: Any, xi: Any, angles: Any) -> tuple[Any, Any]:
        """The rate of the response at each impact to an impulse of 1 at another one in every period, which jumps
        by 1, and the response (..., N, N); omega and xi are (..., 1)."""
        since = angles[..., :, None] - angles[..., None, :] + self.later
        decay, rate = xi * omega, omega * np.sqrt(1 - xi**2)
        whole = 2 * math.pi * self.k / self.Omega
        q = np.exp(-decay * whole)
        c, s = 1 - q * np.cos(rate * whole), q * np.sin(rate * whole)
        fade = (np.exp(-decay[..., None] * since / self.Omega)) / (c * c + s * s)[..., None]
        turn = rate[..., None] * since / self.Omega
        cosine, sine = fade * np.cos(turn), fade * np.sin(turn)
        c, s = c[..., None], s[..., None]
        response = (c * sine + s * cosine) / rate[..., None]
        by_time = c * cosine - s * sine - decay[..., None] * response
        # the mean of the values before and after
        return by_time - 0.5 * np.eye(self.signs.size), response

    def rates(
        self, p: _Array, angles: _Array, jumps: _Array
    ) -> tuple[_Array, _Array, _Array, _Array]:
        """The equations, their derivatives with respect to angles, jumps and parameters, speeds and
        coefficients."""
        N = angles.size
        point = np.concatenate([angles, jumps, p])
        points = point + 1j * STEP * np.eye(point.size)
        # points that differ in angles, in omega and in xi, and one for all others
        own = np.concatenate([np.arange(N + 1), 2 * N + np.arange(2)])
        of = np.full(point.size, N)
        of[own] = np.arange(N + 3)
        found, speeds, R = self.impacts(
            points[:, 2 * N :].T, points[:, :N], points[:, N : 2 * N], own, of
        )
        return found[0].real, found.imag.T / STEP, speeds[0].real, R[0].real

    def motion(self, p: _Array, angles: _Array, jumps: _Array) -> Impacting:
        """The exact motion near given angles and jumps."""
        N = angles.size
        for _ in range(MOST_STEPS):
            off, by, speeds, R = self.rates(p, angles, jumps)
            if not np.isfinite(by).all():
                break
            right = np.column_stack([off, by[:, 2 * N :]])
            try:
                change = -np.linalg.solve(by[:, : 2 * N], right)
            except np.linalg.LinAlgError:
                break
            step = change[:, 0]
            room = FARTHEST * (np.roll(angles, -1) - angles + self.last).min()
            step = step * min(1.0, room / max(abs(step[:N]).max(), 1e-300))
            angles, jumps = angles + step[:N], jumps + step[N:]
            if (angles[1:] <= angles[:-1]).any():
                break
            small = abs(step[:N]).max() + abs(step[N:]).max() / max(abs(jumps).max(), 1e-300)
            if small < SETTLED:
                largest = max(abs(jumps).max() / max(p[2], 1e-3), 1e-300)
                if not speeds.min() > TOUCHING * largest:
                    raise SingularError(
                        "the free mass does not approach the walls at the impacts of the motion"
                    )
                slopes = np.asarray(change[:, 1:].reshape(2, N, p.size), dtype=np.float64)
                return Impacting(angles, jumps, speeds, R, slopes)
        raise SingularError("Newton's method found no motion with these impacts")


def accelerated(
    data: Measured, omega: Any, xi: Any, static: Any, phase: Any, t: Any, X: Any, V: Any
) -> Any:
    """The acceleration of the primary mass by its spring, dashpot and load, for given displacements and
    velocities."""
    load = data.forced.load_at(phase, t) if data.forced is not None else 0.0
    for n, shape in zip(data.orders.tolist(), data.shape.tolist(), strict=True):
        turn = n * (data.Omega * t + phase)
        load = load + shape.real * np.cos(turn) - shape.imag * np.sin(turn)
    return omega**2 * (static * load - X) - 2 * xi * omega * V


def oscillator_of(values: Mapping[str, float], **scale: Any) -> Oscillator:
    """The system with given parameters, with the coefficients of a law at v0, and with M, K and F0 if they are
    known."""
    law = law_of(values)
    right, left = (
        float(np.clip(law.coefficient(i, [values[name] for name in law.of_wall(i)], law.v0), 0, 1))
        for i in (0, 1)
    )
    return Oscillator(xi=values["xi"], mu=values["mu"], restitution=(right, left), **scale)


def verified(
    osc: Oscillator, r: float, clearance: float, phases: _Array, pattern: Pattern,
    walls: tuple[Restitution, Restitution], harmonics: _Complex,
) -> Motion:  # fmt: skip
    """The exact motion as computed by the core, with its verdicts, from the load phases of its impacts.

    Speeds of laws are in F0 omega/K; `harmonics` are the second and higher harmonics of the load, relative to the
    first. With a law or with harmonics the motion is that of `Oscillator.structure`.
    """
    if walls == osc.restitution and not harmonics.any():
        return exact(osc, r, clearance, (phases, pattern))
    pair = osc.structure(clearance, walls)
    gaps = np.where(pattern.signs > 0, 0, 1)
    tones = np.append(-1j, harmonics)
    none = np.zeros(tones.size)
    load = Load(
        r, sine=np.column_stack([-tones.imag, none]), cosine=np.column_stack([tones.real, none])
    )
    return exact_structure(pair, load, (phases, gaps, pattern.cycles))
