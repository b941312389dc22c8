"""Nonlinear least squares with analytic derivatives."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..base.errors import SingularError, VibroimpactError

_Array = NDArray[np.float64]
MOST_ITERATIONS = 60
#: Number of steps by which it is judged whether the remaining ones can make a fit good.
JUDGED = 10


def levenberg(
    function: Callable[[_Array], tuple[_Array, _Array]], start: _Array, scales: _Array, weak: float = 0.0,
    accepted: Callable[[], None] = lambda: None, low: float | _Array = -math.inf, high: float | _Array = math.inf,
    most: int = MOST_ITERATIONS, hopeless: float = math.inf,
) -> tuple[_Array, _Array, _Array, bool]:  # fmt: skip
    """The Levenberg–Marquardt method; return the point, its residuals and their derivatives, and whether the
    iteration converged.

    `function` returns residuals and derivatives, or raises an error of the package where they do not exist.
    Directions along which the residuals change by less than `weak` over a step of `scales` are not changed.
    `accepted` is called after each accepted step, at the point where the function was last evaluated. All points
    lie between `low` and `high`; the number of steps is limited. The iteration also ends if at the rate of the
    last steps all remaining ones would leave a mean square of the residuals above `hopeless`.
    """
    x = start.copy()
    f, J = function(x)
    if not finite(f, J * scales):
        raise SingularError("residuals too large for floating-point numbers")
    accepted()
    damping, at_end = 1e-3, False
    sums: list[float] = []
    for i in range(most):
        sums.append(float(f @ f))
        rate = (sums[max(0, i - JUDGED)] - sums[i]) / JUDGED
        if i >= JUDGED and sums[i] - rate * (most - i) > hopeless * f.size:
            return x, f, J, False
        A = J * scales
        outward = A.T @ f
        A[:, ((x <= low) & (outward > 0)) | ((x >= high) & (outward < 0))] = 0
        squares, V = np.linalg.eigh(A.T @ A)
        slope = V.T @ (A.T @ f)
        kept = squares > max(weak**2, 1e-13 * squares[-1])
        # the gain of a full step; at a minimum it is no larger than this, and rounding decides
        left = float(np.sum(np.where(kept, slope**2 / (1 + squares), 0.0)))
        at_end = left <= 1e-4 * max(1.0, float(f @ f))
        while True:
            step = -V @ np.where(kept, slope / (squares + damping * (1 + squares)), 0.0)
            try:
                trial = np.clip(x + scales * step, low, high)
                new_f, new_J = function(trial)
                better = finite(new_f, new_J * scales) and bool(new_f @ new_f <= f @ f)
            except VibroimpactError:
                better = False
            if better:
                break
            damping *= 10
            if damping > 1e12:
                return x, f, J, at_end
        accepted()
        gain = f @ f - new_f @ new_f
        x, f, J = trial, new_f, new_J
        # a step of the size of rounding may be accepted again and again
        if (damping <= 1e-4 and gain <= 1e-6) or (at_end and gain <= 1e-14 * (f @ f)):
            return x, f, J, True
        damping = max(damping / 10, 1e-12)
    return x, f, J, at_end


def finite(f: _Array, J: _Array) -> bool:
    """Whether sums of squares of residuals and of their derivatives are finite numbers."""
    with np.errstate(over="ignore", invalid="ignore"):
        return bool(np.isfinite(f @ f) and np.isfinite(np.sum(J * J)))
