"""Score tests (Lagrange multiplier tests) of known values that are not fitted: do the records contradict them?"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .coupled import Covariance
from .windows import Flown, Windows

_Array = NDArray[np.float64]
#: Change of the residuals over a step of a typical size, in standard errors, along directions that are fitted.
WEAK = 1 / 3
#: The common parameters of flights that should not change during a record, in their order.
TRENDS = ("omega", "xi", "static", "phase")


class Strain(NamedTuple):
    """A difference between a known value and the value that the records imply, in standard errors and in its own
    unit."""

    size: float
    change: float


def of_known(
    f: _Array, J: _Array, scales: _Array, names: list[str], free_of: Mapping[str, _Array], spread: float
) -> tuple[dict[str, Strain], dict[str, dict[str, float]]]:  # fmt: skip
    """The change of each value that was not fitted if it were fitted, from the derivatives of the residuals with
    respect to it (the score test, or Lagrange multiplier test, of its value), and the derivatives of the fitted
    parameters with respect to it. `spread` is the variance of a residual."""
    U, s, Vt = np.linalg.svd(J * scales, full_matrices=False)
    known, moved = s > 1e-9 * s[0], s > WEAK
    strains, leans = {}, {}
    for name, g in free_of.items():
        along = U.T @ g
        by = -scales * (Vt[moved].T @ (along[moved] / s[moved]))
        leans[name] = dict(zip(names, by.tolist(), strict=True))
        own = g - U[:, known] @ along[known]
        size = float(own @ own)
        # an effect that the fitted parameters can imitate cannot be detected
        if size > 1e-12 * float(g @ g):
            change = -float(own @ f) / size
            strains[name] = Strain(change * math.sqrt(size / spread), change)
    return strains, leans


def held_strains(
    flown: Flown, names: list[str], by: _Array, multiplier: _Array, change: _Array,
    cov: Covariance | None, B: _Array, covariance: _Array, spread: float, places: list[str],
    also: int | None = None,
) -> tuple[dict[str, Strain], dict[str, dict[str, float]], _Array, _Array]:  # fmt: skip
    """The score test of each known value, the derivatives of the fitted parameters with respect to it, and the
    information on all these values together, with minus half the gradient of the sum of squares, over `spread`.

    `by` (equations, names) are derivatives of the constraints with respect to known values; `multiplier` are the
    residuals of the constraints over their covariance `cov`; `B` are their derivatives with respect to the
    fitted parameters, whose covariance without `spread` is `covariance`; `change` is the difference between the
    common parameters and their values from the flights alone. The value of the number `also` is fitted as well.
    """
    F, H = flown.free.size, len(flown.held)
    slope, own = np.zeros(len(names)), np.zeros((len(names), len(names)))
    cross = np.zeros((len(names), covariance.shape[0]))
    if by.shape[0]:
        assert cov is not None
        solved = cov.solve(by)
        slope, own, cross = -by.T @ multiplier, by.T @ solved, solved.T @ B
    W = flown.every_weight[flown.held]
    slope[:H] += flown.slope[flown.held] - W[:, flown.free] @ change
    own[:H, :H] += W[:, flown.held]
    cross[:H, :F] += W[:, flown.free]
    strains, leans = {}, {}
    lean_of = -cross @ covariance
    own_left = own + lean_of @ cross.T
    if also is not None and own_left[also, also] > 1e-9 * own[also, also]:
        by = own_left[also] / own_left[also, also]
        by[also] = 0.0
        lean_of -= np.outer(by, lean_of[also])
        own_left -= np.outer(by, own_left[also])
        slope -= by * slope[also]
    for i, name in enumerate(names):
        leans[name] = dict(zip(places, lean_of[i].tolist(), strict=True))
        left = float(own_left[i, i])
        # an effect that the fitted parameters can imitate cannot be detected
        if left > 1e-9 * own[i, i]:
            strains[name] = Strain(
                float(slope[i]) / math.sqrt(left * spread), float(slope[i]) / left
            )
    return strains, leans, own_left / spread, slope / spread


def strains_of(
    windows: Windows, common: _Array, variances: Mapping[str, float], spread: float
) -> dict[str, Strain]:
    """The differences between the load of its channel and that implied by the motion: residuals over their own
    standard errors, which are smaller than the error of the channel to the extent that the fit follows it.
    `variances` are those of the fitted parameters."""
    found = {}
    for place, name, fitted, label in (
        (2, "static", "F0/K 0", "F0 0"),
        (3, "phase", "phase", "phase 0"),
    ):
        if name not in windows.priors or fitted not in variances:
            continue
        value, error = windows.priors[name]
        own = 1 - variances[fitted] / error**2
        if own > 1e-6:
            change = (common[place] - value) / own
            unit = (windows.data.F0 or math.nan) / value if name == "static" else 1.0
            size = float(change) * math.sqrt(own / spread) / error
            found[label] = Strain(size, float(change) * unit)
    return found


def trends_of(flown: Flown) -> dict[str, Strain]:
    """The changes of natural frequency, damping ratio, load and its phase from the start of a record to its end,
    by score tests on the residuals of single flights."""
    slope, own, cross = flown.trends
    covariance = np.linalg.inv(flown.weights)
    found = {}
    for i, name in enumerate(TRENDS):
        shared = cross[i, flown.free]
        left = float(own[i] - shared @ covariance @ shared)
        # an effect that the fitted parameters can imitate cannot be detected
        if left > 1e-9 * own[i]:
            size = float(slope[i]) / math.sqrt(left * flown.colour)
            found[name] = Strain(size, float(slope[i]) / left)
    return found
