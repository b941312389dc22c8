"""The upper boundary of Figure 6a to 40 digits, by an independent method (extra `reproduce`: mpmath).

At this boundary the equispaced motion loses its symmetry: two unequispaced motions, mirror images of each other,
branch off. The boundary is therefore the limit of the linear problem of two impacts as the durations of the two
flights become equal. The limit is an even function of the difference of the phase from pi, so that a difference of
1e-15 causes an error of about 1e-30.
"""

from __future__ import annotations

from typing import Any

from .. import Oscillator
from ..base.errors import MissingExtraError

DIGITS = 40
#: Phase from each impact to the other one.
_TURNS = ((0, 1), (1, 0))


def upper_boundary(osc: Oscillator, r: float | str) -> Any:
    """F0/(dK) where the equispaced motion becomes unequispaced, as an mpmath number."""
    try:
        from mpmath import cos, exp, matrix, mp, mpf, pi, sin, sqrt
    except ImportError:
        raise MissingExtraError("the 40-digit check needs mpmath: pip install mpmath") from None
    with mp.workdps(DIGITS):
        xi, mu, (right, left) = (
            mpf(str(osc.xi)),
            mpf(str(osc.mu)),
            (mpf(str(x)) for x in osc.restitution),
        )
        ratio, eta, walls, sides = (
            mpf(r),
            sqrt(1 - xi * xi),
            (right, left),
            (mpf(1) / 2, -mpf(1) / 2),
        )
        second = pi + mpf(10) ** -15
        spans = second / ratio, (2 * pi - second) / ratio
        # velocity of the free mass after each impact; the unknowns are x_1, x_2, A cos(tau), A sin(tau), for d = 1
        speeds = [
            _row({j: 1 / spans[i], i: -1 / spans[i]}, (sides[j] - sides[i]) / spans[i])
            for i, j in _TURNS
        ]
        rows = []
        for i, j in _TURNS:
            x_dot = _sum(
                (1 + mu) * walls[i] / (1 + walls[i]),
                speeds[j],
                (1 - mu * walls[i]) / (1 + walls[i]),
                speeds[i],
            )  # (13)
            x_dot_end = _sum(
                (walls[j] - mu) / (1 + walls[j]), speeds[i], (1 + mu) / (1 + walls[j]), speeds[j]
            )  # (28)
            begin = i * second
            end, decay = begin + spans[i] * ratio, exp(-xi * spans[i])
            s, c = decay * sin(eta * spans[i]), decay * cos(eta * spans[i])
            # the free part of the motion just after impact i, and its value at impact j
            x, v = (
                _row({i: 1, 2: -sin(begin), 3: -cos(begin)}),
                _row({2: -ratio * cos(begin), 3: ratio * sin(begin)}),
            )
            v = _sum(1, v, 1, x_dot)
            position, velocity = (
                _sum(c + xi * s / eta, x, s / eta, v),
                _sum(-s / eta, x, c - xi * s / eta, v),
            )
            velocity = _sum(1, velocity, -1, x_dot_end)
            rows.append(_sum(1, position, 1, _row({j: -1, 2: sin(end), 3: cos(end)})))
            rows.append(_sum(1, velocity, 1, _row({2: ratio * cos(end), 3: -ratio * sin(end)})))
        solution = mp.lu_solve(matrix([row[:4] for row in rows]), matrix([-row[4] for row in rows]))
        amplitude = sqrt(solution[2] ** 2 + solution[3] ** 2)  # A/d
        return amplitude * sqrt((1 - ratio**2) ** 2 + (2 * xi * ratio) ** 2)


def _row(coefficients: dict[int, Any], known: Any = 0) -> list[Any]:
    """A linear expression in the four unknowns."""
    return [*(coefficients.get(k, 0) for k in range(4)), known]


def _sum(a: Any, one: list[Any], b: Any, other: list[Any]) -> list[Any]:
    """a times one expression plus b times another."""
    return [a * x + b * y for x, y in zip(one, other, strict=True)]
