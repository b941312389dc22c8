"""The upper boundary of Figure 6a to 40 digits, by a route of its own (extra `reproduce`: mpmath).

There the equispaced motion loses its symmetry: two unequispaced motions, mirror images, part from it. So the
boundary is the limit of the linear problem of two impacts as their durations become equal. It is even in the
difference from pi, so that a difference of 1e-15 leaves an error of about 1e-30.
"""

from __future__ import annotations

from typing import Any

from ..model import Oscillator
from ..plot.style import MissingExtraError

DIGITS = 40


def upper_boundary(osc: Oscillator, r: float | str) -> Any:
    """F0/(dK) where the equispaced motion becomes unequispaced, as an mpmath number."""
    try:
        from mpmath import cos, exp, matrix, mp, mpf, pi, sin, sqrt
    except ImportError:
        raise MissingExtraError("the 40-digit check needs mpmath: pip install mpmath") from None
    with mp.workdps(DIGITS):
        xi, mu, walls = mpf(str(osc.xi)), mpf(str(osc.mu)), [mpf(str(x)) for x in osc.restitution]
        ratio, eta = mpf(r), sqrt(1 - xi * xi)
        phase = [mpf(0), pi + mpf(10) ** -15]
        span = [(phase[1] - phase[0]) / ratio, (2 * pi - phase[1] + phase[0]) / ratio]
        sides = [mpf(1) / 2, mpf(-1) / 2]
        # unknowns: x_1, x_2, A cos(tau), A sin(tau), for d = 1
        equations, rhs = matrix(4, 4), matrix(4, 1)
        for i, j in ((0, 1), (1, 0)):
            speed = (lambda k, m: _row({m: 1 / span[k], k: -1 / span[k]}, (sides[m] - sides[k]) / span[k]))
            before, after = speed(j, i), speed(i, j)
            x_dot = _sum((1 + mu) * walls[i] / (1 + walls[i]), before,
                         (1 - mu * walls[i]) / (1 + walls[i]), after)  # (13)
            x_dot_end = _sum((walls[j] - mu) / (1 + walls[j]), after,
                             (1 + mu) / (1 + walls[j]), before)  # (28)
            a, b = phase[i], phase[i] + span[i] * ratio
            s, c = exp(-xi * span[i]) * sin(eta * span[i]), exp(-xi * span[i]) * cos(eta * span[i])
            # free part: position p and velocity q just after impact i
            p = _row({i: 1, 2: -sin(a), 3: -cos(a)}, 0)
            q = _sum(1, x_dot, 1, _row({2: -ratio * cos(a), 3: ratio * sin(a)}, 0))
            end = _sum(c + xi * s / eta, p, s / eta, q)
            end_dot = _sum(-s / eta, p, c - xi * s / eta, q)
            position = _sum(1, end, 1, _row({j: -1, 2: sin(b), 3: cos(b)}, 0))
            velocity = _sum(1, _sum(1, end_dot, 1, _row({2: ratio * cos(b), 3: -ratio * sin(b)}, 0)),
                            -1, x_dot_end)  # fmt: skip
            for k, (coefficients, known) in enumerate((position, velocity)):
                for column, value in enumerate(coefficients):
                    equations[2 * i + k, column] = value
                rhs[2 * i + k] = -known
        solution = mp.lu_solve(equations, rhs)
        amplitude = sqrt(solution[2] ** 2 + solution[3] ** 2)  # A/d
        return amplitude * sqrt((1 - ratio**2) ** 2 + (2 * xi * ratio) ** 2)


def _row(coefficients: dict[int, Any], known: Any) -> tuple[list[Any], Any]:
    """A linear expression in the four unknowns."""
    return [coefficients.get(k, 0) for k in range(4)], known


def _sum(a: Any, one: Any, b: Any, other: Any) -> tuple[list[Any], Any]:
    """a times one expression plus b times another."""
    return [a * x + b * y for x, y in zip(one[0], other[0], strict=True)], a * one[1] + b * other[1]
