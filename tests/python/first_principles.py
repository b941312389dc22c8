"""The vibroimpact oscillator from Newton's law: a small model to test the package against.

Nothing here uses the coefficients of the paper's appendix. A flight is the exponential of the
oscillator's 2 x 2 matrix, an impact is momentum and restitution solved as two linear equations,
and everything else (the overdetermined linear system, the derivative of the impact map, exact
periodic motions) is obtained by evaluating these two pieces, on unit vectors or with a complex
step.

Units: time in 1/omega; length in the clearance d in the linear system (`mismatch`,
`linear_system`, `newton`) and in F0/K in a `Motion`. An angle is load phase, r times time, zero at
the first impact. The steady motion is A sin(angle + tau) = c sin(angle) + s cos(angle) with
c = A cos(tau) and s = A sin(tau).
"""

from dataclasses import dataclass

import numpy as np

STEP = 1e-30
"""Complex step; a derivative Im f(x + i STEP)/STEP has no cancellation, so it can be tiny."""


@dataclass(frozen=True)
class System:
    """An oscillator, a load frequency and an order of impacts.

    Parameters
    ----------
    xi, mu, r : float
        Damping ratio, mass ratio m/M, load frequency over natural frequency.
    sides : str
        R and L, one letter for each impact.
    cycles : int
        Load cycles in one period.
    restitution : tuple of float
        One coefficient for each impact.
    """

    xi: float
    mu: float
    r: float
    sides: str
    cycles: int
    restitution: tuple

    @property
    def signs(self):
        """Position of the ball in the slot at each impact: +1 right, -1 left, in d/2."""
        return np.array([1.0 if side == "R" else -1.0 for side in self.sides])

    @property
    def amplitude(self):
        """Amplitude of the steady motion without impacts, in F0/K."""
        return abs(1.0 / (1.0 - self.r**2 + 2j * self.xi * self.r))

    @property
    def lag(self):
        """Angle by which the load leads the steady motion."""
        return -np.angle(1.0 / (1.0 - self.r**2 + 2j * self.xi * self.r))


@dataclass(frozen=True)
class Motion:
    """A periodic motion in F0/K, 1/omega; one entry for each impact."""

    system: System
    alpha: np.ndarray
    clearance: float
    c: float
    s: float
    X: np.ndarray
    Z: np.ndarray
    X_dot_before: np.ndarray
    X_dot_after: np.ndarray
    Z_dot_before: np.ndarray
    Z_dot_after: np.ndarray
    residual: float

    @property
    def tau(self):
        """Angle of the steady motion at the first impact, in (-pi, pi]."""
        return np.arctan2(self.s, self.c)


def exponential(xi, t):
    """Exponential of B t for the undriven oscillator (x, v)' = B (x, v).

    (B + xi I)^2 = -(1 - xi^2) I, so the series of exp((B + xi I) t) sums to a cosine and a sine.

    Parameters
    ----------
    xi : float
        Damping ratio below 1.
    t : array
        Times, complex allowed.

    Returns
    -------
    tuple of four arrays
        The entries (x from x, x from v, v from x, v from v), each shaped like t.
    """
    eta = np.sqrt(1.0 - xi**2)
    decay = np.exp(-xi * t)
    cosine, sine = decay * np.cos(eta * t), decay * np.sin(eta * t) / eta
    return cosine + xi * sine, sine, -sine, cosine - xi * sine


def steady(r, c, s, angle):
    """Position and velocity of the steady motion c sin(angle) + s cos(angle)."""
    sine, cosine = np.sin(angle), np.cos(angle)
    return c * sine + s * cosine, r * (c * cosine - s * sine)


def fly(xi, r, c, s, angle, x, v, t):
    """Position and velocity of M a time t after it was at x with velocity v and load angle."""
    x0, v0 = steady(r, c, s, angle)
    x1, v1 = steady(r, c, s, angle + r * t)
    xx, xv, vx, vv = exponential(xi, t)
    return xx * (x - x0) + xv * (v - v0) + x1, vx * (x - x0) + vv * (v - v0) + v1


def collide(mu, restitution, v, w):
    """Velocities of M and ball after an impact, from those before it.

    Momentum v' + mu w' = v + mu w and restitution v' - w' = -R (v - w), solved together.
    """
    left = np.array([[1.0, mu], [1.0, -1.0]])
    right = np.stack([v + mu * w, -restitution * (v - w)])
    return tuple(np.linalg.solve(left, right.reshape(2, -1)).reshape(right.shape))


def carrier_velocities(mu, restitution, w_before, w_after):
    """Velocities of M before and after every impact, from those of the ball.

    The same two laws as `collide`, with the velocities of M as the unknowns; one row for each impact.
    """
    one = np.ones_like(restitution)
    left = np.stack([np.stack([-one, one], -1), np.stack([restitution, one], -1)], -2)
    right = np.stack([mu * (w_before - w_after), w_after + (restitution * w_before.T).T], 1)
    flat = np.linalg.solve(left, right.reshape(len(one), 2, -1)).reshape(right.shape)
    return flat[:, 0], flat[:, 1]


def velocities(system, phases, X, d=1.0):
    """Flight times, and the four velocities at every impact, that follow from the positions.

    Parameters
    ----------
    system : System
    phases, X : array, shape (N, ...)
        Load phase and position of M at every impact.
    d : float
        Clearance in the unit of X.

    Returns
    -------
    tuple of arrays, each shape (N, ...)
        Flight time after each impact; velocity of M before and after; of the ball before and after.
    """
    turns = np.zeros_like(phases)
    turns[-1] = 2.0 * np.pi * system.cycles
    time = (np.roll(phases, -1, 0) + turns - phases) / system.r
    Z = X + (0.5 * d * system.signs).reshape(-1, *[1] * (X.ndim - 1))
    w_after = (np.roll(Z, -1, 0) - Z) / time
    w_before = np.roll(w_after, 1, 0)
    R = np.array(system.restitution, float)
    return time, *carrier_velocities(system.mu, R, w_before, w_after), w_before, w_after


def mismatch(system, phases, X, c, s):
    """The state that the impact laws require minus the state at the end of each flight (d = 1).

    Parameters
    ----------
    system : System
    phases, X : array, shape (N, ...)
    c, s : array, shape (...)
        A cos(tau), A sin(tau) over d.

    Returns
    -------
    array, shape (2N, ...)
        N mismatches of position, then N of velocity before the impact; affine in X, c and s.
    """
    time, before, after, _, _ = velocities(system, phases, X)
    x, v = fly(system.xi, system.r, c, s, phases, X, after, time)
    return np.concatenate([np.roll(X, -1, 0) - x, np.roll(before, -1, 0) - v])


def linear_system(system, phases):
    """Matrix (2N, N + 2) and right side (2N,) of mismatch = 0, by probing with unit vectors."""
    n = len(phases)
    phases = np.broadcast_to(np.asarray(phases, float)[:, None], (n, n + 3))
    probe = np.hstack([np.zeros((n + 2, 1)), np.eye(n + 2)])
    value = mismatch(system, phases, probe[:n], probe[n], probe[n + 1])
    return value[:, 1:] - value[:, :1], -value[:, 0]


def motion_from(system, phases, unknowns, residual=0.0):
    """Motion in F0/K from the unknowns X, A cos(tau), A sin(tau) over d."""
    phases = np.array(phases, float)
    d = system.amplitude / np.hypot(*unknowns[-2:])
    X = d * unknowns[:-2]
    _, v_before, v_after, w_before, w_after = velocities(system, phases, X, d)
    return Motion(
        system,
        phases,
        d,
        d * unknowns[-2],
        d * unknowns[-1],
        X,
        X + 0.5 * d * system.signs,
        v_before,
        v_after,
        w_before,
        w_after,
        residual,
    )


def solve(system, phases):
    """Least squares motion at given phases; the exact one for two impacts."""
    matrix, right = linear_system(system, phases)
    unknowns = np.linalg.lstsq(matrix, right, rcond=None)[0]
    residual = np.linalg.norm(matrix @ unknowns - right) / np.linalg.norm(right)
    return motion_from(system, phases, unknowns, residual)


def equispaced(system, clearance):
    """Symmetric motions of two impacts half a period apart (odd cycles, equal restitution).

    X_2 = -X_1 leaves two equations for X_1, c, s: a line, cut by the circle that the clearance
    fixes, c^2 + s^2 = (A/d)^2.

    Returns
    -------
    list of Motion
        0 or 2 of them (two equal ones where the line touches the circle).
    """
    phases = np.array([0.0, np.pi * system.cycles])
    matrix, right = linear_system(system, phases)
    half = np.column_stack([matrix[:, 0] - matrix[:, 1], matrix[:, 2:]])[[0, 2]]
    point = np.linalg.lstsq(half, right[[0, 2]], rcond=None)[0]
    along = np.linalg.svd(half)[2][-1]
    square = along[1:] @ along[1:], 2 * point[1:] @ along[1:], point[1:] @ point[1:]
    roots = np.roots([*square[:2], square[2] - (system.amplitude / clearance) ** 2])
    if np.iscomplexobj(roots):
        return []
    found = [point + root * along for root in roots]
    return [motion_from(system, phases, np.array([x, -x, c, s])) for x, c, s in found]


def newton(system, phases, clearance=None, steps=40):
    """Exact periodic motion near a guess of the phases.

    The unknowns are X_1 .. X_N, c, s and the phases 2 .. N, the equations `mismatch` = 0 and,
    with a clearance, c^2 + s^2 = (A/d)^2. Without one there is a curve of motions and each step is
    the shortest. The Jacobian is by complex step.

    Returns
    -------
    Motion or None
        None if the iteration did not converge to ordered phases, or converged to a motion without load.
    """
    n = len(phases)
    target = None if clearance is None else (system.amplitude / clearance) ** 2

    def equations(u):
        x, c, s = u[:n], u[n], u[n + 1]
        value = mismatch(system, np.concatenate([np.zeros_like(u[:1]), u[n + 2 :]]), x, c, s)
        circle = [] if target is None else [(c * c + s * s) / target - 1.0]
        return np.concatenate([value, np.array(circle).reshape(-1, *value.shape[1:])])

    start = np.linalg.lstsq(*linear_system(system, phases), rcond=None)[0]
    u = np.concatenate([start, np.asarray(phases, float)[1:]])
    for _ in range(steps):
        value = equations(u)
        jacobian = equations(u[:, None] + 1j * STEP * np.eye(len(u))).imag / STEP
        step = np.linalg.lstsq(jacobian, -value, rcond=None)[0]
        step *= min(1.0, 0.3 / max(np.abs(step[n + 2 :]).max(), 1e-300))
        u = u + step
        edges = np.concatenate([[0.0], u[n + 2 :], [2.0 * np.pi * system.cycles]])
        if not np.all(np.diff(edges) > 1e-2) or not np.abs(u).max() < 1e3:
            return None
        if np.abs(step).max() < 1e-14 * np.abs(u).max():
            break
    error = np.linalg.norm(equations(u))
    scale = np.abs(jacobian).max() * np.abs(u).max()
    if error > 1e-13 * scale or np.hypot(u[n], u[n + 1]) <= 1e-6 * max(np.abs(u[:n]).max(), 1.0):
        return None
    return motion_from(system, np.concatenate([[0.0], u[n + 2 :]]), u[: n + 2], error)


def impact_map(system, steady_motion, restitution, state, time, travel=None):
    """State just after the next impact from the state just after this one.

    Parameters
    ----------
    system : System
    steady_motion : tuple of float
        c and s in the unit of the positions.
    restitution : float
        Of the next impact.
    state : array, shape (4, ...)
        X, X_dot_after, Z_dot_after, load phase; complex allowed.
    time : float
        Guess of the flight time.
    travel : float, optional
        Change of Z - X from this impact to the next. By default the change that the flight gives at
        the guess, which is then exactly the flight time, and only its derivative is computed.

    Returns
    -------
    tuple
        The next state, shape (4, ...), and the flight time that Newton's iteration found.
    """
    x, v, w, angle = state
    time = time + 0.0 * x
    for _ in range(60):
        x1, v1 = fly(system.xi, system.r, *steady_motion, angle, x, v, time)
        change = w * time - (x1 - x)
        travel = change.real if travel is None else travel
        step = (change - travel) / (w - v1)
        time = time - step
        real, imag = np.abs(np.real(step)).max(), np.abs(np.imag(step)).max()
        if real <= 1e-14 * np.abs(time).max() and imag <= 1e-14 * np.abs(np.imag(time)).max():
            break
    x1, v1 = fly(system.xi, system.r, *steady_motion, angle, x, v, time)
    v1, w1 = collide(system.mu, restitution, v1, w)
    return np.stack([x1, v1, w1 + 0.0 * v1, angle + system.r * time]), time


def impact_jacobians(system, phases, X, X_dot_after, Z_dot_after, c, s):
    """Differentiate every impact-to-impact map by complex step.

    The next impact is where Z - X has changed as much as the flight changes it by the next phase:
    plus or minus the clearance or zero in a periodic motion. This is still defined, with
    the same derivative, in a least squares one.

    Returns
    -------
    array, shape (N, 4, 4)
        d(X, X_dot_after, Z_dot_after, phase) after impact i + 1 by the same after impact i.
    """
    end = np.append(phases[1:], phases[0] + 2.0 * np.pi * system.cycles)
    maps = []
    for i, time in enumerate((end - phases) / system.r):
        state = np.array([X[i], X_dot_after[i], Z_dot_after[i], phases[i]])
        step = state[:, None] + 1j * STEP * np.eye(4)
        restitution = system.restitution[(i + 1) % len(phases)]
        after, _ = impact_map(system, (c, s), restitution, step, time)
        maps.append(after.imag / STEP)
    return np.array(maps)


def impact_pair(r, phases, signs, cycles, restitution):
    """Solve the pair without mass ratio: M is c sin + s cos whatever the ball does (mu = 0, d = 1).

    Two impacts, so w_i = (1 + R_i) v_i - R_i w_{i-1} at each gives two equations for c and s.

    Returns
    -------
    tuple
        c, s and the positions X (2,) of M at the impacts.
    """
    phases, signs, R = (np.asarray(a, float) for a in (phases, signs, restitution))
    gap = np.array([phases[1] - phases[0], phases[0] + 2 * np.pi * cycles - phases[1]])
    positions = np.column_stack([np.sin(phases), np.cos(phases)])
    speeds = r * np.column_stack([np.cos(phases), -np.sin(phases)])
    across = (positions[[1, 0]] - positions) * (r / gap)[:, None]
    walls = 0.5 * (signs[[1, 0]] - signs) * r / gap
    matrix = across + R[:, None] * across[[1, 0]] - (1.0 + R)[:, None] * speeds
    c, s = np.linalg.solve(matrix, -(walls + R * walls[[1, 0]]))
    return c, s, positions @ [c, s]


def impact_pair_limit(restitution, cycles):
    """Largest clearance over A with an equispaced motion of the impact pair (mu = 0).

    Half a period after X_1 = A sin(tau) the ball meets -X_1, so its speed is
    -(2 A sin(tau) + d) r / (k pi), and restitution asks
    (1 + R) k pi cos(tau) + 2 (1 - R) sin(tau) = -(1 - R) d/A.
    """
    return np.hypot((1 + restitution) * np.pi * cycles / (1 - restitution), 2.0)
