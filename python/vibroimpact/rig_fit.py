"""The parameters of a rig from the harmonics of its motion: exact motions fitted by weighted least squares."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .errors import ParameterError, SingularError, VibroimpactError
from .model import Oscillator, Pattern
from .motion import Motion
from .newton import exact, newton
from .solve import equispaced, periodic

_Array = NDArray[np.float64]
_Complex = NDArray[np.complex128]
#: What all records share, in this order; then the mode that rings: frequency (rad/s), damping ratio, share.
SHARED = ("omega", "xi", "mu", "R1", "R2", "exponent", "d")
RING = ("ring omega", "ring damping", "ring share")
#: Largest relative standard error of a combination of parameters that a record determines.
VAGUE = 0.5
#: Largest difference of an impact time, in load cycles, from that where it was picked.
NEAR = 0.05
MOST_ITERATIONS = 60
#: Share of the weighted squares of the harmonics that a fit leaves unexplained, above which it is none.
BAD = 0.5
#: Approach speed, over the largest velocity, that counts as none.
TOUCHING = 1e-6
#: Step of a coefficient of restitution for central differences; error of one that obeys its law, and the most
#: steps to there.
STEP, LAWFUL, MOST_STEPS = 1e-5, 1e-12, 20
#: A fit of impulses is good below this misfit; jumps below this share of the largest one are none; an impact
#: more has to take so much from the sum of squares, and this share of it; and the largest number of impacts in
#: a load cycle.
GOOD, WEAK = 4.0, 0.02
LEAST_GAIN, LEAST_SHARE = 40.0, 0.15
#: Relative error of the acceleration of a free mass for that of one on a spring, times w/omega.
BOUND = 0.05
MOST_IMPACTS = 12
#: Harmonics of the load by which a motion is summed, and the last one of the first stage of a fit.
MANY, FEW = 1000, 6


@dataclass
class Measured:
    """What one record says: the harmonics of the acceleration, and the load.

    Angles are Omega t with t = 0 in the middle of the record.
    """

    #: Load frequency, radians a second.
    Omega: float
    #: Load cycles in a period.
    k: int
    #: (N) Angles Omega t of the impacts from 0 to below 2 pi k, and their errors; changes of velocity.
    angles: _Array = field(default_factory=lambda: np.empty(0))
    angle_errors: _Array = field(default_factory=lambda: np.empty(0))
    jumps: _Array = field(default_factory=lambda: np.empty(0))
    #: (n) Orders (multiples of Omega/k), harmonics of the acceleration, and errors of their real and imaginary
    #: parts. Without a record of the motion there are none.
    orders: _Array = field(default_factory=lambda: np.empty(0))
    values: _Complex = field(default_factory=lambda: np.empty(0, dtype=np.complex128))
    errors: _Array = field(default_factory=lambda: np.empty(0))
    #: Load phase at t = 0 and its error (None: not known), and amplitude and its error (N).
    phase: float | None = None
    phase_error: float = 0.0
    F0: float | None = None
    F0_error: float = 0.0
    #: The load over F0 sin(Omega t + phase): its harmonics at the orders above.
    shape: _Complex = field(default_factory=lambda: np.empty(0, dtype=np.complex128))

    #: Walls of the impacts of a period, in the order of the angles.
    sides: str = ""

    @property
    def pattern(self) -> Pattern:
        """The pattern of the impacts."""
        return Pattern(self.sides, self.k)

    @property
    def frequencies(self) -> _Array:
        """Of the harmonics, radians a second."""
        return self.orders * self.Omega / self.k

    def up_to(self, most: int) -> Measured:
        """The same without the harmonics above one of the load."""
        if self.orders.size == 0 or self.orders[-1] <= most * self.k:
            return self
        low = self.orders <= most * self.k
        arrays = {
            name: getattr(self, name)[low] for name in ("orders", "values", "errors", "shape")
        }
        return replace(self, **arrays)

    def impulses(self, angles: _Array, jumps: _Array) -> tuple[_Complex, _Complex]:
        """The harmonics of impulses, each of 1 at its angle (n, N), and their sum with the given weights."""
        each = (
            self.Omega / (math.pi * self.k) * np.exp(-1j * np.outer(self.orders / self.k, angles))
        )
        return each, each @ jumps


def levenberg(
    function: Callable[[_Array], tuple[_Array, _Array]], start: _Array, scales: _Array, weak: float = 0.0,
    accepted: Callable[[], None] = lambda: None,
) -> tuple[_Array, _Array, _Array, bool]:  # fmt: skip
    """The method of Levenberg and Marquardt: the point, its residuals and their derivatives, and whether it
    converged.

    `function` gives residuals and derivatives, or raises an error of the package where there are none. Directions
    along which the residuals change by less than `weak` over a step of `scales` are left as they are. `accepted`
    is called where the function was evaluated last, if the method goes there.
    """
    x = start.copy()
    f, J = function(x)
    accepted()
    damping = 1e-3
    for _ in range(MOST_ITERATIONS):
        A = J * scales
        squares, V = np.linalg.eigh(A.T @ A)
        slope = V.T @ (A.T @ f)
        kept = squares > max(weak**2, 1e-13 * squares[-1])
        while True:
            step = -V @ np.where(kept, slope / (squares + damping * (1 + squares)), 0.0)
            try:
                trial = x + scales * step
                new_f, new_J = function(trial)
                better = bool(new_f @ new_f <= f @ f)
            except VibroimpactError:
                better = False
            if better:
                break
            damping *= 10
            if damping > 1e12:
                # at a minimum only rounding is left to gain
                left = float(np.sum(np.where(kept, slope**2 / (1 + squares), 0.0)))
                return x, f, J, left <= 1e-4 * max(1.0, float(f @ f))
        accepted()
        gain = f @ f - new_f @ new_f
        x, f, J = trial, new_f, new_J
        if damping <= 1e-4 and gain <= 1e-6:
            return x, f, J, True
        damping = max(damping / 10, 1e-12)
    return x, f, J, False


class Refined(NamedTuple):
    """Impacts refined below the sample, and the mode that rings (None: none does)."""

    angles: _Array
    errors: _Array
    jumps: _Array
    ring: _Array | None
    #: Sum of squares of the weighted residuals, and the degrees of freedom.
    square: float
    freedom: int
    #: What is left of the harmonics, over their errors, in the order of `Impulses`.
    left: _Complex

    @property
    def misfit(self) -> float:
        """Sum of squares over the degrees of freedom."""
        return self.square / max(1, self.freedom)


def resonance(frequencies: _Array, ring: _Array) -> tuple[_Complex, _Complex, _Complex]:
    """Acceleration of a mode for an impulse that changes its velocity by 1, and its derivatives by frequency and
    damping of the mode."""
    w, zeta = ring[0], ring[1]
    below = frequencies**2 - w * w - 2j * zeta * w * frequencies
    value = frequencies**2 / below
    by_w = value / below * (2 * w + 2j * zeta * frequencies)
    by_zeta = value / below * 2j * w * frequencies
    return value, by_w, by_zeta


class Impulses:
    """The harmonics above the third of the load, as those of impulses on a mass that is nearly free there."""

    def __init__(self, data: Measured, omega: float) -> None:
        above = data.orders >= 3 * data.k
        self.frequencies = data.frequencies[above]
        self.values = data.values[above]
        # the mass is not quite free: damping, and a natural frequency that is known roughly
        self.errors = np.hypot(
            data.errors[above], BOUND * omega / self.frequencies * abs(self.values)
        )
        self.orders = data.orders[above] / data.k
        self.free = (self.frequencies**2 / (self.frequencies**2 - omega**2)).astype(np.complex128)
        self.scale = data.Omega / (math.pi * data.k)
        self.Omega, self.k = data.Omega, data.k

    @property
    def most(self) -> int:
        """Largest number of impacts that so many harmonics determine."""
        return (2 * self.orders.size - 8) // 2

    def each(self, angles: _Array) -> _Complex:
        """The harmonics of impulses of 1 (n, N)."""
        shape: _Complex = self.scale * np.exp(-1j * np.outer(self.orders, angles))
        return shape

    def residuals(self, x: _Array, N: int, used: slice) -> tuple[_Array, _Array]:
        """Residuals over errors, and their derivatives by angles, jumps and ringing."""
        angles, jumps = x[:N], x[N : 2 * N]
        orders, each = self.orders[used], self.each(angles)[used]
        response = self.free[used]
        total = each @ jumps
        more = []
        if x.size > 2 * N:
            if not (0 < x[2 * N] < 2 * self.frequencies[-1] and 0 < x[2 * N + 1] < 0.5):
                raise SingularError("no mode rings so")
            value, by_w, by_zeta = resonance(self.frequencies[used], x[2 * N :])
            share = x[2 * N + 2]
            response = response + share * value
            more = [share * by_w * total, share * by_zeta * total, value * total]
        blocks = [-1j * orders[:, None] * each * jumps, each]
        J = np.column_stack([*(block * response[:, None] for block in blocks), *more])
        f = response * total - self.values[used]
        w = 1 / self.errors[used]
        return np.concatenate([f.real * w, f.imag * w]), np.vstack(
            [J.real * w[:, None], J.imag * w[:, None]]
        )

    def jumps_at(self, angles: _Array, used: slice) -> _Array:
        """Jumps by linear least squares."""
        each = self.each(angles)[used] * self.free[used, None] / self.errors[used, None]
        right = self.values[used] / self.errors[used]
        stacked = np.vstack([each.real, each.imag])
        found: _Array = np.linalg.lstsq(
            stacked, np.concatenate([right.real, right.imag]), rcond=None
        )[0]
        return found

    def peak(self) -> float:
        """The frequency at which harmonics stand out most from their neighbours."""
        size = abs(self.values)
        smooth = np.convolve(size, np.ones(2 * self.k + 1), "same")
        wide = 12 * self.k
        background = [np.median(smooth[max(0, i - wide) : i + wide + 1]) for i in range(size.size)]
        return float(self.frequencies[np.argmax(smooth / np.maximum(background, 1e-300))])

    def refined(self, angles: _Array, ring: _Array | None) -> Refined:
        """Angles, jumps and ringing by least squares from approximate angles; of several starts the best one."""
        N, n = angles.size, self.orders.size
        few = slice(0, min(n, max(2 * N + 4, n // 4)))
        peak = self.peak()
        starts = [np.empty(0)]
        if ring is not None:
            starts.append(ring)
        else:
            spacing = self.Omega / self.k
            starts += [np.array([peak + shift * spacing, 0.02, 0.2]) for shift in (-0.4, 0.0, 0.4)]
        best: Refined | None = None
        for begin in starts:
            x = np.concatenate([angles, self.jumps_at(angles, few), begin])
            size = max(float(abs(x[N : 2 * N]).max()), 1e-300)
            scales = np.concatenate(
                [np.full(N, 0.01), np.full(N, 0.1 * size), [0.005 * peak, 0.005, 0.1][: begin.size]]
            )
            for used in (few, slice(0, n)):
                x, f, J, _ = levenberg(partial(self.residuals, N=N, used=used), x, scales)
            square, freedom = float(f @ f), f.size - x.size
            if best is not None and square > 0.9 * best.square:
                continue
            covariance = np.linalg.pinv(J.T @ J) * max(1.0, square / max(1, freedom))
            own = x[2 * N :] if begin.size else None
            best = Refined(
                x[:N],
                np.sqrt(np.diag(covariance)[:N]),
                x[N : 2 * N],
                own,
                square,
                freedom,
                -(f[:n] + 1j * f[n:]),
            )
        assert best is not None
        return best

    def next_angle(self, left: _Complex) -> float:
        """Where one more impulse takes most of what is left."""
        size = 16 * int(self.orders[-1] * self.k)
        spectrum = np.zeros(size, dtype=np.complex128)
        places = np.rint(self.orders * self.k).astype(int)
        spectrum[places] = left * self.free.real / self.errors
        gain = np.fft.ifft(spectrum).real
        return float(2 * math.pi * self.k * np.argmax(abs(gain)) / size)


def refine(data: Measured, omega: float) -> Refined:
    """The impacts of a period from their approximate angles, which may lack some or have too many.

    One impact after another is added while it explains much of what is left, and those that explain little are
    taken away. Where the approximate angles lead to no good fit, none is used.
    """
    system = Impulses(data, omega)
    if system.most < max(2, data.angles.size):
        raise ParameterError(
            f"record with {data.orders.size} harmonics for {data.angles.size} impacts in {data.k} load cycles: "
            "must "
            "have a larger sampling rate or bandwidth"
        )
    best: Refined | None = None
    for angles in (data.angles, np.empty(0)):
        if best is not None and best.misfit < GOOD:
            break
        found = completed(system, angles)
        if found is not None and (best is None or found.square < best.square):
            best = found
    if best is None:
        raise SingularError("no impacts stand out from the noise of the harmonics")
    return best


def completed(system: Impulses, angles: _Array) -> Refined | None:
    """Impacts refined, with those that are missing and without those that are not there."""
    weights = 1 / system.errors
    found: Refined | None = None
    if angles.size:
        found = pruned(system, system.refined(angles, None))
    while found is None or (
        found.misfit > 1.5 and found.angles.size < min(system.most, MOST_IMPACTS * system.k)
    ):
        left = system.values * weights if found is None else found.left
        known = np.empty(0) if found is None else found.angles
        before = float(np.sum(abs(left) ** 2))
        ring = None if found is None else found.ring
        more = system.refined(np.append(known, system.next_angle(left)), ring)
        if more.angles.size > 1:
            more = pruned(system, more)
        if more.angles.size <= known.size or before - more.square < max(
            LEAST_GAIN, LEAST_SHARE * before
        ):
            break
        found = more
    return found


def pruned(system: Impulses, found: Refined) -> Refined:
    """Without impacts of nearly no jump, and with one where two are nearer than harmonics can tell."""
    whole = 2 * math.pi * system.k
    apart = math.pi / system.orders[-1]
    kept = np.ones(found.angles.size, dtype=bool)
    order = np.argsort(-abs(found.jumps)).tolist()
    for place, i in enumerate(order):
        off = [
            abs(math.remainder(found.angles[i] - found.angles[j], whole))
            for j in order[:place]
            if kept[j]
        ]
        kept[i] = all(gap > apart for gap in off)
    sizes = np.median(abs(found.jumps[kept]))
    kept &= abs(found.jumps) > WEAK * sizes
    return found if kept.all() else system.refined(found.angles[kept], found.ring)


def start_of(
    data: Measured, known: dict[str, float], guess: dict[str, float]
) -> tuple[dict[str, float], float, float]:
    """Parameters to start from, by linear equations: the shared ones, F0/K, and the load phase."""
    values = dict(known)
    k, Omega = data.k, data.Omega
    _, impulse = data.impulses(data.angles, data.jumps)
    w = data.frequencies
    low = data.orders <= 6 * k
    # acceleration times (omega^2 - w^2 + 2 i xi omega w) = -w^2 (impulse + load), for omega^2, 2 xi omega and load
    a, s = data.values[low], w[low]
    turn = np.exp(1j * data.phase) if data.phase is not None else 1.0
    load = np.where(data.orders[low] == k, s * s, 0.0)
    weights = 1 / (s * s * data.errors[low])
    matrix = np.column_stack([a, 1j * a * s, load * -1j * turn, load]) * weights[:, None]
    target = (a * s * s - s * s * impulse[low]) * weights
    fixed = np.zeros(4)
    free = [True, True, True, data.phase is None]
    if "omega" in known:
        fixed[0], free[0] = known["omega"] ** 2, False
        if "xi" in known:
            fixed[1], free[1] = 2 * known["xi"] * known["omega"], False
    target = target - matrix @ fixed
    used = matrix[:, free]
    stacked, flat = np.vstack([used.real, used.imag]), np.concatenate([target.real, target.imag])
    size = np.maximum(np.linalg.norm(stacked, axis=0), 1e-300)
    fixed[free] += np.linalg.lstsq(stacked / size, flat, rcond=1e-10)[0] / size
    omega = math.sqrt(fixed[0]) if fixed[0] > 0 else guess.get("omega", Omega)
    if not 0.2 < Omega / omega < 5:
        omega = guess.get("omega", Omega * 1.02)
    xi = known.get("xi", fixed[1] / (2 * omega))
    if not 1e-4 < xi < 0.5:
        xi = known.get("xi", guess.get("xi", 0.01))
    force = -1j * turn * fixed[2] + fixed[3]
    phase = float(np.angle(1j * force))
    static = abs(force) / omega**2
    values |= {"omega": omega, "xi": xi}
    # position and velocities of the primary mass at the impacts, by many harmonics of this oscillator
    many = np.arange(1, MANY * k + 1)
    at = many * Omega / k
    x = 2 * Omega / (2 * math.pi * k) * np.exp(-1j * np.outer(many / k, data.angles)) @ data.jumps
    x[k - 1] += force
    x = x / (omega**2 - at**2 + 2j * xi * omega * at)
    turn = np.exp(1j * np.outer(data.angles / k, many))
    X = (turn @ x).real
    mean = (turn @ (1j * at * x)).real
    before, after = mean - data.jumps / 2, mean + data.jumps / 2
    sides = data.pattern.signs.astype(float)
    duration = np.diff(np.append(data.angles, data.angles[0] + 2 * math.pi * k)) / Omega
    of_x = (np.roll(X, -1) - X) / duration
    of_d = 0.5 * (np.roll(sides, -1) - sides) / duration
    # jump = mu (change of z'): mu times (known + d known)
    first, second = np.roll(of_x, 1) - of_x, np.roll(of_d, 1) - of_d
    if "mu" in known and "d" in known:
        mu, d = known["mu"], known["d"]
    elif "mu" in known:
        mu = known["mu"]
        d = float(second @ (data.jumps / mu - first) / (second @ second))
    elif "d" in known:
        d = known["d"]
        sum_of = first + d * second
        mu = float(sum_of @ data.jumps / (sum_of @ sum_of))
    else:
        matrix2 = np.column_stack([first, second])
        scale = np.linalg.norm(matrix2, axis=0)
        U, s, Vt = np.linalg.svd(matrix2 / scale, full_matrices=False)
        good = s > 0.02 * s[0]
        both = Vt.T @ np.where(good, (U.T @ data.jumps) / np.maximum(s, 1e-300), 0) / scale
        mu, d = float(both[0]), float(both[1] / both[0]) if both[0] else -1.0
        if not (good.all() and 0 < mu < 10 and d > 0):
            mu = guess.get("mu", 0.05)
            d = float(second @ (data.jumps / mu - first) / (second @ second))
    if not 0 < mu < 1e6:
        mu = known.get("mu", guess.get("mu", 0.05))
    if not d > 0:
        d = known.get("d", guess.get("d", 2 * float(abs(X).max())))
    values |= {"mu": mu, "d": d}
    z_after = of_x + d * of_d
    z_before = np.roll(z_after, 1)
    for name, sign in (("R1", 1.0), ("R2", -1.0)):
        own = sides == sign
        ratio = -np.sum((after - z_after)[own] * (before - z_before)[own]) / np.sum(
            (before - z_before)[own] ** 2
        )
        values[name] = known.get(name, float(np.clip(ratio, 0.05, 0.99)))
    return values, static, phase


class Slopes(NamedTuple):
    """Load phases of the impacts and changes of velocity there, and their derivatives by all of a `Point`."""

    phases: _Array
    jumps: _Array
    by: _Array


class Point(NamedTuple):
    """Where a motion is wanted: the coefficient of an impact is R1 or R2 times (v/speed)^-exponent."""

    r: float
    clearance: float
    xi: float
    mu: float
    R1: float
    R2: float
    exponent: float = 0.0
    #: Of reference, in F0 omega/K; None: the coefficients are constants.
    speed: float | None = None


def described(motion: Motion) -> tuple[_Array, _Array]:
    """Load phases of the impacts, and changes of velocity of the primary mass."""
    return motion.phases + motion.load_phase, motion.X_dot_after - motion.X_dot_before


def approach_speeds(motion: Motion) -> _Array:
    """Approach speeds of the impacts."""
    return np.asarray(motion.pattern.signs * (motion.Z_dot_before - motion.X_dot_before))


def slopes(motion: Motion, point: Point) -> Slopes:
    """The derivatives of a motion."""
    gradient = motion.gradient()
    columns = [
        gradient.parameters.index(name) for name in ("r", "clearance", "xi", "mu", "R1", "R2")
    ]
    phases = (gradient["phases"] + gradient["load_phase"])[:, columns]
    jumps = (gradient["X_dot_after"] - gradient["X_dot_before"])[:, columns]
    by = np.zeros((len(Point._fields), 2, phases.shape[0]))
    by[:6] = np.stack([phases.T, jumps.T], axis=1)
    if point.speed is not None:
        v, R, p = approach_speeds(motion), motion.restitution, point.exponent
        right = motion.pattern.signs > 0
        # of the coefficients at fixed speeds
        rates = np.zeros((len(Point._fields), R.size))
        rates[4], rates[5] = R / point.R1 * right, R / point.R2 * ~right
        rates[6], rates[7] = -R * np.log(v / point.speed), p * R / point.speed
        # and with the speeds, which change by the other parameters and by the coefficients
        rates[:4] -= p * R / v * gradient["approach_speeds"][:, columns[:4]].T
        of_phases, of_jumps, of_speeds = by_restitution(motion)
        changes = np.linalg.solve(np.eye(R.size) + (p * R / v)[:, None] * of_speeds, rates.T)
        by[4:6] = 0.0
        by += np.stack([of_phases @ changes, of_jumps @ changes]).transpose(2, 0, 1)
    if not np.isfinite(by).all():
        raise SingularError(
            f"{motion!r}: has no derivatives: {', '.join(gradient.status.values())}"
        )
    return Slopes(*described(motion), by)


def by_restitution(motion: Motion) -> _Array:
    """Derivatives of load phases, changes of velocity and approach speeds by the coefficient of each impact.

    `Motion.gradient` has those by both walls alone, so these are central differences.
    """
    columns = []
    for change in STEP * np.eye(motion.restitution.size):
        ends = []
        for each in (motion.restitution + change, motion.restitution - change):
            near = with_restitution(motion, each)
            ends.append(np.array([*described(near), approach_speeds(near)]))
        off = ends[0] - ends[1]
        off[0] -= 2 * math.pi * np.round(off[0] / (2 * math.pi))
        columns.append(off / (2 * STEP))
    return np.stack(columns, axis=-1)


def with_restitution(motion: Motion, each: _Array) -> Motion:
    """The motion near another one with a coefficient of restitution for each impact."""
    if not ((each >= 0) & (each <= 1)).all():
        raise SingularError(f"coefficients of restitution {each}: must be from 0 to 1")
    return newton(
        motion.osc, motion.r, motion.clearance, 1.0, motion.pattern, motion.X, motion.phases + motion.tau, each
    )  # fmt: skip


def lawful(point: Point, motion: Motion) -> _Array:
    """The coefficients of restitution by the law at the speeds of a motion."""
    walls = np.where(motion.pattern.signs > 0, point.R1, point.R2)
    if point.speed is None:
        return walls
    return np.asarray(walls * (approach_speeds(motion) / point.speed) ** -point.exponent)


def motion_at(point: Point, guess: Motion | tuple[_Array, Pattern]) -> Motion:
    """The exact motion at a point near another one, whose coefficients obey the law at its own speeds."""
    osc = Oscillator(xi=point.xi, mu=point.mu, restitution=(point.R1, point.R2))
    if point.speed is None:
        return approaching(exact(osc, point.r, point.clearance, guess))
    assert isinstance(guess, Motion)
    motion = newton(
        osc, point.r, point.clearance, 1.0, guess.pattern, guess.X * (point.clearance / guess.clearance),
        guess.phases + guess.tau, guess.restitution,
    )  # fmt: skip
    # Newton's method on the coefficients, with the derivatives of the first motion
    slope = -point.exponent * lawful(point, motion) / approach_speeds(motion)
    matrix = np.eye(slope.size) - slope[:, None] * by_restitution(motion)[2]
    for _ in range(MOST_STEPS):
        off = lawful(point, approaching(motion)) - motion.restitution
        if np.max(abs(off)) < LAWFUL:
            return motion
        motion = with_restitution(motion, motion.restitution + np.linalg.solve(matrix, off))
    raise SingularError(f"{motion!r}: no motion near it obeys the law of restitution")


def approaching(motion: Motion) -> Motion:
    """The motion, if each impact has an approach speed, which is more than a rounding error."""
    speeds = approach_speeds(motion)
    if not speeds.min() > TOUCHING * max(1.0, float(np.max(abs(motion.Z_dot_before)))):
        raise SingularError(f"{motion!r}: the walls are not approached at its impacts")
    return motion


@dataclass
class Fit:
    """Fitted parameters with their covariance."""

    values: dict[str, float]
    #: F0/K of each record.
    lengths: list[float]
    phases: list[float]
    ring: _Array | None
    motions: list[Motion]
    #: Names of the columns of `covariance`, which has what was fitted, without ringing and load phases.
    names: list[str]
    covariance: _Array
    undetermined: list[str]
    misfits: list[float]
    #: Reference speed of a power law of restitution (m/s); None: the coefficients are constants.
    speed: float | None = None


def fit(
    records: Sequence[Measured], known: dict[str, float], starts: dict[str, float], lengths: Sequence[float],
    phases: Sequence[float], ring: _Array | None, M: float | None = None, K: float | None = None,
    speed: float | None = None, near: Sequence[Motion] = (), rough: bool = False,
) -> Fit:  # fmt: skip
    """Fit exact motions to the harmonics of one or more records.

    `known` are the shared parameters that are not fitted; `M` or `K` with the load of a record give its F0/K.
    With a reference `speed` (m/s) the coefficients of restitution obey a power law, and `near` has motions whose
    speeds are about those of the records. A `rough` fit, from which another one starts, need not converge.
    """
    free = [name for name in SHARED if name not in known]
    count = len(records)
    ringing = ring is not None and any(data.orders.size for data in records)
    names = [*free, *(f"F0/K {i}" for i in range(count)), *(f"phase {i}" for i in range(count))]
    names += RING if ringing else ()
    place = {name: i for i, name in enumerate(names)}
    x = np.array(
        [
            *(starts[name] for name in free),
            *lengths,
            *phases,
            *(ring if ringing and ring is not None else ()),
        ]
    )
    typical = {"R1": 0.5, "R2": 0.5, "exponent": 0.25, "xi": max(starts["xi"], 0.005)}
    scales = np.array(
        [*(typical.get(name, abs(starts[name])) for name in free), *lengths, *([1.0] * count),
         *([0.05 * ring[0], 0.02, 0.3] if ringing and ring is not None else ())]
    )  # fmt: skip
    guesses: list[Motion] = []
    latest: list[Motion] = []
    turns: list[float] = []
    sizes: list[int] = []

    def shared(x: _Array) -> dict[str, float]:
        return {name: float(x[place[name]]) if name in place else known[name] for name in SHARED}

    def points(x: _Array) -> list[Point]:
        p = shared(x)
        found = []
        for i, data in enumerate(records):
            static = float(x[place[f"F0/K {i}"]])
            walls = (p["R1"], p["R2"], p["exponent"])
            unit = None if speed is None else speed / (p["omega"] * static)
            found.append(
                Point(data.Omega / p["omega"], p["d"] / static, p["xi"], p["mu"], *walls, unit)
            )
        return found

    for i, (data, point) in enumerate(zip(records, points(x), strict=True)):
        static, phase = float(x[place[f"F0/K {i}"]]), float(x[place[f"phase {i}"]])
        start = partial(first_motion, data=data, unit=shared(x)["omega"] * static, phase=phase)
        if point.speed is None:
            guesses.append(start(point))
            continue
        # with constants that the law gives at about the speeds
        each, right = lawful(point, near[i]), near[i].pattern.signs > 0
        means = {"R1": float(each[right].mean()), "R2": float(each[~right].mean())}
        first = start(point._replace(**means, exponent=0.0, speed=None))
        guesses.append(checked(motion_at(point, first), data))
    for i, data in enumerate(records):
        turns.append(turn_of(guesses[i], data, x[place[f"phase {i}"]]))

    def residuals(x: _Array) -> tuple[_Array, _Array]:
        p = shared(x)
        here = points(x)
        new = [motion_at(point, guess) for point, guess in zip(here, guesses, strict=True)]
        all_f, all_J = [], []
        for i, data in enumerate(records):
            f, J = residuals_of(data, i, new[i], here[i], p, x)
            all_f.append(f)
            all_J.append(J)
        latest[:] = new
        sizes[:] = [f.size for f in all_f]
        return np.concatenate(all_f), np.vstack(all_J)

    def accept() -> None:
        guesses[:] = latest

    def residuals_of(
        data: Measured, i: int, motion: Motion, point: Point, p: dict[str, float], x: _Array
    ) -> tuple[_Array, _Array]:
        omega, xi = p["omega"], p["xi"]
        static, phase = x[place[f"F0/K {i}"]], x[place[f"phase {i}"]]
        s = slopes(motion, point)
        angles = s.phases - phase + turns[i]
        # by those of SHARED and then F0/K, which change r = Omega/omega, D = d/(F0/K) and the unit of speeds
        r, D, u = motion.r, motion.clearance, point.speed or 0.0
        by = np.stack([
            -(s.by[0] * r + s.by[7] * u) / omega, *s.by[2:7], s.by[1] / static,
            -(s.by[1] * D + s.by[7] * u) / static,
        ])  # fmt: skip
        unit = omega * static
        jumps = s.jumps * unit
        d_angles, d_jumps = by[:, 0], by[:, 1] * unit
        d_jumps[0] += s.jumps * static
        d_jumps[-1] += s.jumps * omega
        f, J = [], []
        columns = [place.get(name) for name in SHARED] + [place[f"F0/K {i}"]]

        def row(value: _Array, by_shared: _Array, more: dict[int, _Array]) -> None:
            f.append(np.atleast_1d(value))
            block = np.zeros((np.size(value), x.size))
            for column, derivative in zip(columns, by_shared, strict=True):
                if column is not None:
                    block[:, column] = derivative
            for column, derivative in more.items():
                block[:, column] = derivative
            J.append(block)

        if data.orders.size:
            data = data.up_to(stage)
            each, impulse = data.impulses(angles, jumps)
            w = data.frequencies
            below = omega**2 - w**2 + 2j * xi * omega * w
            turned = data.shape * np.exp(1j * phase * data.orders / data.k)
            force = impulse + omega**2 * static * turned
            direct = -(w**2) / below
            value = direct * force
            response = direct
            ring_columns: dict[int, _Complex] = {}
            if ringing:
                own = x[[place[name] for name in RING]]
                mode, by_w, by_zeta = resonance(w, own)
                value = value + own[2] * mode * impulse
                response = direct + own[2] * mode
                for name, derivative in zip(
                    RING, (own[2] * by_w, own[2] * by_zeta, mode), strict=True
                ):
                    ring_columns[place[name]] = derivative * impulse
            by_angle = -1j * (data.orders / data.k)[:, None] * each * jumps
            by_values = (by_angle @ d_angles.T + each @ d_jumps.T).T * response
            by_values[0] += direct * 2 * omega * static * turned - direct * force / below * (
                2 * omega + 2j * xi * w
            )
            by_values[1] += -direct * force / below * 2j * omega * w
            by_values[-1] += direct * omega**2 * turned
            by_phase = -(by_angle.sum(axis=1)) * response
            by_phase = by_phase + direct * omega**2 * static * turned * 1j * data.orders / data.k
            ring_columns[place[f"phase {i}"]] = by_phase
            for part in (np.real, np.imag):
                row(
                    part(value - data.values) / data.errors, part(by_values) / data.errors,
                    {column: part(derivative) / data.errors for column, derivative in ring_columns.items()},
                )  # fmt: skip
        else:
            errors = data.angle_errors
            one = {place[f"phase {i}"]: -1 / errors}
            row((angles - data.angles) / errors, d_angles / errors, one)
        if data.phase is not None:
            off = math.remainder(phase - data.phase, 2 * math.pi)
            row(
                np.array([off / data.phase_error]),
                np.zeros((len(columns), 1)),
                {place[f"phase {i}"]: np.array([1 / data.phase_error])},
            )
        if data.F0 is not None and (K is not None or M is not None):
            stiffness = K if K is not None else (M or 0.0) * omega**2
            change = np.zeros((len(columns), 1))
            change[-1] = stiffness / data.F0_error
            if K is None:
                change[0] = 2 * stiffness / omega * static / data.F0_error
            row(np.array([(static * stiffness - data.F0) / data.F0_error]), change, {})
        return np.concatenate(f), np.vstack(J)

    # first by few harmonics, since the high ones turn fast with the times of impacts
    stage = FEW
    # which do not tell the ringing
    still = np.array([0.0 if name in RING else 1.0 for name in names])
    x, *_ = levenberg(residuals, x, scales * still, 1 / 3, accept)
    stage = 10**9
    x, f, J, converged = levenberg(residuals, x, scales, 1 / 3, accept)
    if not converged and not rough:
        raise SingularError(
            f"the fit did not converge: after {MOST_ITERATIONS} steps the squares of the {f.size} weighted "
            f"residuals add up to {float(f @ f):.3g}"
        )
    found = finished(sizes, x, f, J, names, place, shared(x), guesses, scales, ringing)
    for i, data in enumerate(records):
        left = np.sum(abs((predicted(data, found, i) - data.values) / data.errors) ** 2)
        if left > BAD * np.sum(abs(data.values / data.errors) ** 2):
            raise SingularError(
                f"no exact motion {data.pattern.sides}/{data.k} near the picked impacts fits the record"
            )
    return replace(found, speed=speed)


def turn_of(motion: Motion, data: Measured, phase: float) -> float:
    """The load cycles (radians) from the impacts of a motion to those that were picked."""
    off = data.angles - (described(motion)[0] - phase)
    return 2 * math.pi * round(float(np.median(off)) / (2 * math.pi))


def predicted(data: Measured, found: Fit, i: int) -> _Complex:
    """The harmonics of the acceleration of the fitted motion of record i."""
    phases, jumps = described(found.motions[i])
    omega, xi = found.values["omega"], found.values["xi"]
    static, w = found.lengths[i], data.frequencies
    turn = turn_of(found.motions[i], data, found.phases[i])
    _, impulse = data.impulses(phases - found.phases[i] + turn, jumps * omega * static)
    force = impulse + omega**2 * static * data.shape * np.exp(
        1j * found.phases[i] * data.orders / data.k
    )
    value: _Complex = -(w**2) / (omega**2 - w**2 + 2j * xi * omega * w) * force
    if found.ring is not None:
        value = value + found.ring[2] * resonance(w, found.ring)[0] * impulse
    return value


def finished(
    sizes: Sequence[int], x: _Array, f: _Array, J: _Array, names: list[str],
    place: dict[str, int], values: dict[str, float], motions: list[Motion], scales: _Array, ringing: bool,
) -> Fit:  # fmt: skip
    """Covariance, and what is not determined; `sizes` are the numbers of residuals of the records."""
    count = len(sizes)
    scaled = J * scales
    _, s, Vt = np.linalg.svd(scaled, full_matrices=True)
    s = np.concatenate([s, np.zeros(Vt.shape[0] - s.size)])
    determined = s > 1 / VAGUE
    freedom = max(1, f.size - int(determined.sum()))
    misfit = float(f @ f) / freedom
    # what the records do not determine may be wrong by as much as itself, and what depends on it a little by less
    inverse = 1 / np.maximum(s, 1.0) ** 2
    covariance = (Vt.T * inverse) @ Vt * np.outer(scales, scales) * max(1.0, misfit)
    vague = np.flatnonzero(np.sum(Vt[~determined] ** 2, axis=0) > 0.01)
    kept = [name for name in names if name in SHARED or name.startswith("F0/K")]
    undetermined = [name for name in kept if place[name] in vague]
    columns = [place[name] for name in kept]
    each = np.split(f, np.cumsum(sizes)[:-1])
    parts = [float(own @ own) / max(1, own.size - 4) for own in each]
    return Fit(
        values, [float(x[place[f"F0/K {i}"]]) for i in range(count)],
        [float(x[place[f"phase {i}"]]) for i in range(count)],
        x[[place[name] for name in RING]] if ringing else None, list(motions), kept,
        covariance[np.ix_(columns, columns)], undetermined, parts,
    )  # fmt: skip


def first_motion(point: Point, data: Measured, unit: float, phase: float) -> Motion:
    """The exact motion to start from: of the phases of the impacts by the linear equations, or by continuation.

    `unit` is F0 omega/K in m/s, and `phase` the load phase in the middle of the record.
    """
    r, clearance = point.r, point.clearance
    osc = Oscillator(xi=point.xi, mu=point.mu, restitution=(point.R1, point.R2))
    phases = data.angles - data.angles[0]
    linear = periodic(osc, r, phases, data.pattern)

    def unlike(motion: Motion) -> float:
        """How far load phases and changes of velocity are from those that were picked."""
        here, jumps = described(motion)
        off = float(np.max(abs(np.sin(0.5 * (here - data.angles - phase)))))
        if data.jumps.any():
            off += float(np.max(abs(jumps * unit - data.jumps)) / np.max(abs(data.jumps)))
        return off

    errors, found = [], []
    guesses: list[Motion] = [linear]
    if phases.size == 2 and data.k % 2 and abs(phases[1] / (math.pi * data.k) - 1) < 2 * NEAR:
        # equally spaced impacts leave the amplitude of the linear equations nearly free
        both = replace(osc, restitution=(0.5 * (point.R1 + point.R2),) * 2)
        guesses += equispaced(both, r, clearance, data.k)
    for guess in guesses:
        try:
            found.append(checked(exact(osc, r, clearance, guess), data))
        except VibroimpactError as error:
            errors.append(error)
    if found:
        return min(found, key=unlike)
    # from the clearance of the linear equations to this one in steps
    try:
        motion = exact(osc, r, linear.clearance, linear)
        for share in np.linspace(0, 1, 21)[1:]:
            motion = exact(
                osc, r, linear.clearance * (clearance / linear.clearance) ** share, motion
            )
        return checked(motion, data)
    except VibroimpactError:
        raise SingularError(
            f"no exact motion {data.pattern.sides}/{data.k} near the picked impacts at r = {r:.6g}, d K/F0 = "
            f"{clearance:.6g}: {errors[0]}"
        ) from None


def checked(motion: Motion, data: Measured) -> Motion:
    """The motion, if its impacts are impacts, about where they were picked."""
    approaching(motion)
    off = np.diff(motion.phases) - np.diff(data.angles)
    if off.size and np.max(abs(off)) > NEAR * 2 * math.pi * 2:
        raise SingularError("Newton's method went to another motion")
    return motion
