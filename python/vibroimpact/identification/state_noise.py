"""The spurious information on parameters that errors of the states of flights seem to add."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .coupled import Covariance, banded

_Array = NDArray[np.float64]
#: Number of random draws of errors of the states, and the share of the information on a direction of the
#: parameters that comes from them above which the direction counts as undetermined: the fit would follow the
#: noise.
DRAWS, MOST_NOISE = 4, 0.15


@np.errstate(all="ignore")  # for flights that do not exist
def noise_information(
    equations: Any, here: _Array, spread: _Array, shared: _Array, seed: int
) -> _Array:
    """The spurious information that errors of the states add to the information on the parameters.

    The derivatives of the constraints are evaluated at states with errors, so that they vary from impact to impact
    even if the true states do not, as for a periodic motion. Adding errors of the same size a second time adds the
    same amount again, which measures the effect. The errors are drawn from the remaining errors of the states
    under the constraints; `shared` are changes of the equations as in `Covariance`. The errors of the states that
    these cause are not drawn: since the states compensate for the errors of a recorded load, the motion at an
    impact hardly changes. For sweeps, beats and noise of `test_identify_loads.py` they are 0.4 to 36 % of the
    variance of an equation (medians of the records), and all other errors add less than 0.5 % of the information
    on any direction.
    """
    random = np.random.default_rng(seed)
    size, axes = np.linalg.eigh(np.where(np.isfinite(spread), spread, 0.0))
    roots = axes * np.sqrt(np.maximum(size, 0))[:, None, :]

    def information(states: _Array) -> tuple[_Array, _Array, Covariance]:
        A, through, G, ok = equations(states)
        B = np.concatenate([through, G], axis=-1).reshape(2 * A.shape[0], -1)
        cov = Covariance(banded(A, spread, ok), shared * np.repeat(ok, 2)[:, None])
        return B.T @ cov.solve(B), A, cov

    middle, A, cov = information(here)
    n = A.shape[0]
    total = np.zeros_like(middle)
    for _ in range(DRAWS):
        drawn = np.einsum("nab,nb->na", roots, random.standard_normal(here.shape))
        local = np.stack([drawn[j : j + n] for j in range(4)], axis=1)
        off = np.einsum("nclq,nlq->nc", A, local).reshape(-1)
        multiplier = cov.solve(off).reshape(n, 2)
        for j in range(4):
            drawn[j : j + n] -= np.einsum(
                "nqr,ncr,nc->nq", spread[j : j + n], A[:, :, j], multiplier
            )
        for sign in (1, -1):
            total += (information(here + sign * drawn)[0] - middle) / (2 * DRAWS)
    return total


def without_noise(information: _Array, of_noise: _Array) -> _Array:
    """Derivatives J such that J'J is the information on the parameters without the part that noise adds.

    With the information I, of which I - N remains for states without errors, the covariance of the parameters is
    (I - N)^-1 I (I - N)^-1. Directions in which the share of noise exceeds MOST_NOISE are not determined.
    """
    size, axes = np.linalg.eigh(information)
    size = np.maximum(size, 1e-14 * max(float(size[-1]), 1e-300))
    root = axes * np.sqrt(size)
    inner = (axes / np.sqrt(size)).T @ of_noise @ (axes / np.sqrt(size))
    share, turned = np.linalg.eigh(np.where(np.isfinite(inner), inner, 0.0))
    left = np.where(share > MOST_NOISE, 0.0, 1 - np.clip(share, 0.0, 1.0))
    J: _Array = left[:, None] * (root @ turned).T
    return J
