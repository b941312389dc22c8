"""Equations at impacts, with the states of four flights in sequence in each: derivatives and covariances."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base.libraries import scipy
from .forced import STEP

_Array = NDArray[np.float64]
_Bool = NDArray[np.bool_]


@np.errstate(all="ignore")  # for flights that do not exist
def slopes(
    constraints: Any, states: _Array, common: _Array, g: _Array, free: NDArray[np.int64]
) -> tuple[_Array, _Array, _Array, _Array]:
    """The constraints (n, 2), and their derivatives with respect to the states of the four adjacent flights (n, 2,
    4, 2), to common parameters and to the others."""
    # no constraint contains two flights of one colour
    flights = np.arange(states.shape[0])
    n = states.shape[0] - 3
    # all of them by steps along the imaginary axis: 8 of states, then common parameters, then the others
    F, count = 8 + free.size, 8 + free.size + g.size
    moved = np.zeros((count, *states.shape), dtype=complex)
    for colour in range(4):
        for q in range(2):
            moved[2 * colour + q, flights % 4 == colour, q] = 1j * STEP
    of_common, of_g = np.zeros((count, common.size)), np.zeros((count, g.size))
    of_common[np.arange(8, F), free], of_g[F:] = STEP, STEP * np.eye(g.size)
    found = constraints(states + moved, common + 1j * of_common, g + 1j * of_g)
    by = found.imag / STEP
    each = (np.arange(n)[:, None] + np.arange(4)) % 4
    A = np.stack(
        [by[2 * each + q, np.arange(n)[:, None]] for q in range(2)], axis=-1
    )  # (n, 4, 2, q)
    C, G = np.moveaxis(by[8:F], 0, -1).copy(), np.moveaxis(by[F:], 0, -1).copy()
    return found[0].real.copy(), np.swapaxes(A, 1, 2), C, G


def passed_on(A: _Array, C: _Array, turned: _Array) -> _Array:
    """Derivatives of the constraints with respect to common parameters, including the effect through the states of
    the flights; `C` are the derivatives at fixed states with respect to the first parameters."""
    n = A.shape[0]
    of_turned = np.stack([turned[j : j + n] for j in range(4)], axis=1)
    through: _Array = -np.einsum("nclq,nlqk->nck", A, of_turned)
    through[..., : C.shape[-1]] += C
    return through


def own_blocks(A: _Array, spread: _Array, ok: _Bool) -> _Array:
    """The covariances of the two equations of each impact."""
    n = A.shape[0]
    block = sum(
        np.einsum("naq,nqr,nbr->nab", A[:, :, j], spread[j : j + n], A[:, :, j]) for j in range(4)
    )
    return np.where(ok[:, None, None], block, np.eye(2))


def banded(A: _Array, spread: _Array, ok: _Bool) -> _Array:
    """The covariances of all equations, as lower bands for `solveh_banded`."""
    n = A.shape[0]
    bands = np.zeros((8, 2 * n))
    for k in range(4):
        if k >= n:
            break
        m = n - k
        block = np.zeros((m, 2, 2))
        for j in range(k, 4):
            block += np.einsum("naq,nqr,nbr->nab", A[k:, :, j - k], spread[j : j + m], A[:m, :, j])
        if k == 0:
            block = np.where(ok[:, None, None], block, np.eye(2))
        for row in range(2):
            for column in range(2):
                off = 2 * k + row - column
                if off >= 0:
                    bands[off, column : 2 * m : 2] += block[:, row, column]
    return bands


class Covariance(NamedTuple):
    """The covariance of all equations: of errors of the states of flights, and of others, which many flights have
    in common."""

    #: As from `banded`.
    bands: _Array
    #: (equations, parts) Changes of the equations by independent errors of standard deviation 1.
    shared: _Array

    def solve(self, right: _Array) -> _Array:
        """The inverse of the covariance times given columns."""
        banded_solve = scipy("linalg", "the fit of impacts").solveh_banded
        found: _Array = banded_solve(self.bands, right, lower=True)
        if not self.shared.size:
            return found
        U = banded_solve(self.bands, self.shared, lower=True)
        inner = np.eye(U.shape[1]) + self.shared.T @ U
        return np.asarray(found - U @ np.linalg.solve(inner, U.T @ right), dtype=np.float64)


def scaled_solve(information: _Array, slope: _Array, scales: _Array) -> _Array:
    """The least-squares step, without components in undetermined directions."""
    A = information * np.outer(scales, scales)
    s, V = np.linalg.eigh(A)
    kept = s > 0.1
    step: _Array = scales * (V @ np.where(kept, (V.T @ (slope * scales)) / np.where(kept, s, 1), 0))
    return step
