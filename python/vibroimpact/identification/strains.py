"""Score tests (Lagrange multiplier tests) of what is known and not fitted: do the records contradict it?"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base.libraries import scipy
from .windows import Flown, Windows

_Array = NDArray[np.float64]
#: Change of the residuals over a step of a typical size, in standard errors, along directions that are fitted.
WEAK = 1 / 3


class Strain(NamedTuple):
    """A difference between what is known and what the records say of it, in standard errors and as it is."""

    size: float
    change: float


def of_known(
    f: _Array, J: _Array, scales: _Array, names: list[str], free_of: Mapping[str, _Array], spread: float
) -> tuple[dict[str, Strain], dict[str, dict[str, float]]]:  # fmt: skip
    """What each value that was not fitted would change by if it were, by the derivatives of the residuals by it:
    the score test (Lagrange multiplier test) of its value; and how the fitted ones change with it. `spread` is the
    variance of a residual."""
    U, s, Vt = np.linalg.svd(J * scales, full_matrices=False)
    known, moved = s > 1e-9 * s[0], s > WEAK
    strains, leans = {}, {}
    for name, g in free_of.items():
        along = U.T @ g
        by = -scales * (Vt[moved].T @ (along[moved] / s[moved]))
        leans[name] = dict(zip(names, by.tolist(), strict=True))
        own = g - U[:, known] @ along[known]
        size = float(own @ own)
        # what the fitted parameters imitate cannot be told
        if size > 1e-12 * float(g @ g):
            change = -float(own @ f) / size
            strains[name] = Strain(change * math.sqrt(size / spread), change)
    return strains, leans


def held_strains(
    flown: Flown, names: list[str], by: _Array, multiplier: _Array, change: _Array, cov: _Array, B: _Array,
    covariance: _Array, spread: float, places: list[str],
) -> tuple[dict[str, Strain], dict[str, dict[str, float]]]:  # fmt: skip
    """The score test of each known value, and how the fitted ones change with it.

    `by` (equations, names) are derivatives of the constraints by what is known, `multiplier` what the constraints
    leave over their covariance `cov` (bands), `B` their derivatives by the fitted parameters of which `covariance`
    is that without `spread`, `change` how far the common ones are from those of the flights alone.
    """
    F, H = flown.free.size, len(flown.held)
    slope, own = np.zeros(len(names)), np.zeros((len(names), len(names)))
    cross = np.zeros((len(names), covariance.shape[0]))
    if by.shape[0]:
        solved = scipy("linalg", "the fit of impacts").solveh_banded(cov, by, lower=True)
        slope, own, cross = -by.T @ multiplier, by.T @ solved, solved.T @ B
    W = flown.every_weight[flown.held]
    slope[:H] += flown.slope[flown.held] - W[:, flown.free] @ change
    own[:H, :H] += W[:, flown.held]
    cross[:H, :F] += W[:, flown.free]
    strains, leans = {}, {}
    for i, name in enumerate(names):
        lean = -covariance @ cross[i]
        leans[name] = dict(zip(places, lean.tolist(), strict=True))
        left = float(own[i, i] + cross[i] @ lean)
        # what the fitted parameters imitate cannot be told
        if left > 1e-9 * own[i, i]:
            strains[name] = Strain(
                float(slope[i]) / math.sqrt(left * spread), float(slope[i]) / left
            )
    return strains, leans


def strains_of(
    windows: Windows, common: _Array, variances: Mapping[str, float], spread: float
) -> dict[str, Strain]:
    """How far the load by its channel is from that by the motion: residuals over their own standard errors, which
    are smaller than that of the channel as far as the fit follows it. `variances` are of the fitted parameters."""
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
