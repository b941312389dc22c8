"""What errors of the states of flights add to the information on parameters, which is none."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.libraries import scipy
from .coupled import banded

_Array = NDArray[np.float64]
#: Draws of errors of the states, and share of the information on a direction of the parameters that they add,
#: above which the states are taken to tell nothing of it: the fit would follow the noise.
DRAWS, MOST_NOISE = 4, 0.15


@np.errstate(all="ignore")  # of flights that are none
def noise_information(equations: Any, here: _Array, spread: _Array, seed: int) -> _Array:
    """What errors of the states add to the information on the parameters.

    The derivatives of the constraints are taken at states with errors, which make them vary from impact to impact
    also where the states themselves do not, as of a motion that repeats. Errors of the same size, once more, add
    as much again. They are drawn from what remains of the errors of the states when the constraints are fulfilled.
    """
    banded_solve = scipy("linalg", "the fit of impacts").solveh_banded
    random = np.random.default_rng(seed)
    size, axes = np.linalg.eigh(np.where(np.isfinite(spread), spread, 0.0))
    roots = axes * np.sqrt(np.maximum(size, 0))[:, None, :]

    def information(states: _Array) -> tuple[_Array, _Array, _Array]:
        A, through, G, ok = equations(states)
        B = np.concatenate([through, G], axis=-1).reshape(2 * A.shape[0], -1)
        cov = banded(A, spread, ok)
        return B.T @ banded_solve(cov, B, lower=True), A, cov

    middle, A, cov = information(here)
    n = A.shape[0]
    total = np.zeros_like(middle)
    for _ in range(DRAWS):
        drawn = np.einsum("nab,nb->na", roots, random.standard_normal(here.shape))
        local = np.stack([drawn[j : j + n] for j in range(4)], axis=1)
        off = np.einsum("nclq,nlq->nc", A, local).reshape(-1)
        multiplier = banded_solve(cov, off, lower=True).reshape(n, 2)
        for j in range(4):
            drawn[j : j + n] -= np.einsum(
                "nqr,ncr,nc->nq", spread[j : j + n], A[:, :, j], multiplier
            )
        for sign in (1, -1):
            total += (information(here + sign * drawn)[0] - middle) / (2 * DRAWS)
    return total


def without_noise(information: _Array, of_noise: _Array) -> _Array:
    """Derivatives J whose J'J is the information of parameters without that which noise adds.

    With information I, of which I - N is that of the states without errors, the covariance of the parameters is
    (I - N)^-1 I (I - N)^-1. Directions of which noise tells a larger share than MOST_NOISE are not determined.
    """
    size, axes = np.linalg.eigh(information)
    size = np.maximum(size, 1e-14 * max(float(size[-1]), 1e-300))
    root = axes * np.sqrt(size)
    inner = (axes / np.sqrt(size)).T @ of_noise @ (axes / np.sqrt(size))
    share, turned = np.linalg.eigh(np.where(np.isfinite(inner), inner, 0.0))
    left = np.where(share > MOST_NOISE, 0.0, 1 - np.clip(share, 0.0, 1.0))
    J: _Array = left[:, None] * (root @ turned).T
    return J
