"""Nonlinear least squares with analytic derivatives."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..base.errors import SingularError, VibroimpactError

_Array = NDArray[np.float64]
#: Residuals, and their derivatives or a function that returns these, if possible in a given array.
_Residuals = tuple[_Array, _Array | Callable[[_Array | None], _Array]]
MOST_ITERATIONS = 60
#: Number of steps by which it is judged whether the remaining ones can make a fit good.
JUDGED = 10
#: Gain of these steps, relative to that of one full step of the linearized residuals, below which a fit no
#: longer moves: it is at a fold, beyond which the residuals do not exist, or in a curved valley.
STUCK = 1e-3


def levenberg(
    function: Callable[[_Array], _Residuals], start: _Array, scales: _Array, weak: float = 0.0,
    accepted: Callable[[], None] = lambda: None, low: float | _Array = -math.inf, high: float | _Array = math.inf,
    most: int = MOST_ITERATIONS, hopeless: float = math.inf,
) -> tuple[_Array, _Array, _Array, bool]:  # fmt: skip
    """The Levenberg–Marquardt method; return the point, its residuals and their derivatives, and whether the
    iteration converged.

    `function` returns residuals, and their derivatives or a function that returns these, which is called for
    accepted points only; it raises an error of the package where they do not exist.
    Directions along which the residuals change by less than `weak` over a step of `scales` are not changed.
    `accepted` is called after each accepted step, at the point where the function was last evaluated. All points
    lie between `low` and `high`; the number of steps is limited. With a finite `hopeless`, the iteration also ends
    if at the rate of the last steps all remaining ones would leave a mean square of the residuals above it, or if
    the last steps hardly gained anything of what a full step promises.
    """
    x = start.copy()
    f, by = function(x)
    J = by(None) if callable(by) else by
    gram = products(J, scales)
    if not finite(f, gram):
        raise SingularError("residuals too large for floating-point numbers")
    accepted()
    damping, at_end = 1e-3, False
    sums: list[float] = []
    # large arrays are used again, since new ones cost more than what is computed in them
    spare: _Array | None = None
    for i in range(most):
        sums.append(float(f @ f))
        rate = (sums[max(0, i - JUDGED)] - sums[i]) / JUDGED
        if i >= JUDGED and sums[i] - rate * (most - i) > hopeless * f.size:
            return x, f, J, False
        outward = (J.T @ f) * scales
        held = ((x <= low) & (outward > 0)) | ((x >= high) & (outward < 0))
        gram[held], gram[:, held], outward[held] = 0, 0, 0
        squares, V = np.linalg.eigh(gram)
        slope = V.T @ outward
        kept = squares > max(weak**2, 1e-13 * squares[-1])
        # the gain of a full step; at a minimum it is no larger than this, and rounding decides
        left = float(np.sum(np.where(kept, slope**2 / (1 + squares), 0.0)))
        at_end = left <= 1e-4 * max(1.0, float(f @ f))
        if hopeless < math.inf and i >= JUDGED and not at_end and JUDGED * rate < STUCK * left:
            return x, f, J, False
        while True:
            step = -V @ np.where(kept, slope / (squares + damping * (1 + squares)), 0.0)
            try:
                trial = np.clip(x + scales * step, low, high)
                new_f, by = function(trial)
                better = below(new_f, f)
                if better:
                    new_J = by(spare) if callable(by) else by
                    new_gram = products(new_J, scales)
                    better = finite(new_f, new_gram)
                    spare = None if better or not callable(by) else new_J
            except VibroimpactError:
                better = False
            if better:
                break
            damping *= 10
            if damping > 1e12:
                return x, f, J, at_end
        accepted()
        gain = f @ f - new_f @ new_f
        x, f, J, spare, gram = trial, new_f, new_J, J if callable(by) else None, new_gram
        # a step of the size of rounding may be accepted again and again
        if (damping <= 1e-4 and gain <= 1e-6) or (at_end and gain <= 1e-14 * (f @ f)):
            return x, f, J, True
        damping = max(damping / 10, 1e-12)
    return x, f, J, at_end


def below(f: _Array, other: _Array) -> bool:
    """Whether the sum of squares of residuals is a number that does not exceed that of others."""
    with np.errstate(over="ignore", invalid="ignore"):
        return bool(f @ f <= other @ other)


def products(J: _Array, scales: _Array) -> _Array:
    """Products of the derivatives of residuals, summed, per step of `scales`."""
    with np.errstate(over="ignore", invalid="ignore"):
        gram: _Array = (J.T @ J) * np.outer(scales, scales)
        return gram


def finite(f: _Array, gram: _Array) -> bool:
    """Whether sums of squares of residuals and of their derivatives are finite numbers."""
    with np.errstate(over="ignore", invalid="ignore"):
        return bool(np.isfinite(f @ f) and np.isfinite(np.trace(gram)))
