"""Verdicts on the stability of many motions with given phases."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from ..base import checks
from ..base.errors import ParameterError
from ..base.progress import in_parts, reported
from ..systems.oscillator import Oscillator, Pattern, of_numbers, plain_pattern
from ..systems.verbs import physical_arguments
from .periodic import frequency_ratios, impact_restitution

__all__ = ["StabilityFlags", "stability_flags"]

#: Largest number of points in a call of the core; Ctrl-C and progress take effect between calls.
CHUNK = 1 << 18


@dataclass(frozen=True, eq=False, repr=False)
class StabilityFlags:
    """Verdicts on many motions with given phases.

    Attributes
    ----------
    consistent, stable : ndarray (M,) of int8
        1, 0, or -1 for unknown.
    status : ndarray (M,) of int8
        0 where the motion was computed; other codes are explained by `status_text`.
    spectral_radius : ndarray (M,) or None
        Largest modulus of a multiplier, NaN where there is none.
    referred : int
        Number of points that were decided by LAPACK.
    """

    consistent: NDArray[np.int8]
    stable: NDArray[np.int8]
    status: NDArray[np.int8]
    spectral_radius: NDArray[np.float64] | None
    referred: int

    def __len__(self) -> int:
        return len(self.status)

    def __repr__(self) -> str:
        both = (self.consistent == 1) & (self.stable == 1)
        return f"<StabilityFlags: {len(self)} points, {both.sum()} consistent and stable>"


@physical_arguments
def stability_flags(
    osc: Oscillator,
    r: ArrayLike,
    phases: ArrayLike,
    pattern: Pattern | str,
    restitution: ArrayLike | None = None,
    acceptance: float = 0.03,
    spectral_radius: bool = False,
    threads: int | None = None,
    *,
    progress: Callable[[float, str], None] | None = None,
) -> StabilityFlags:
    """Whether motions with given phases are stable, for many points.

    The verdicts are those of `periodic_batch`, in a fraction of the time: many points are computed at once, and
    Jury's conditions on the characteristic polynomial of [P] replace its eigenvalues. A point is computed with
    LAPACK, as in `periodic_batch`, where rounding could change a verdict: usually where the spectral radius is
    within 1e-8 of 1. Apart from its arguments and its result, the call needs little memory. The results are
    identical for any number of threads.

    Parameters
    ----------
    osc : Oscillator
        The system: xi, mu and the coefficients of restitution of both walls.
    r : array_like, scalar or (M,)
        Frequency ratio Omega/omega, one for all sets of phases or one for each.
    phases : array_like (N, M)
        One set of impact phases per column.
    pattern : Pattern or str
        Sides of the N impacts and the number of load cycles.
    restitution : array_like, optional
        Coefficient of restitution of each impact (N,); by default that of the wall.
    acceptance : float
        As in `periodic`.
    spectral_radius : bool
        Whether to compute the largest modulus of a multiplier too. It agrees with that of LAPACK to a relative
        1e-11, or within the effect of the last bits of r and the phases.
    threads : int, optional
        Default: one for each processor.
    progress : callable, optional
        Called with the fraction done and an empty text; by default a bar on a terminal or in a notebook.

    Returns
    -------
    StabilityFlags
        The verdicts, one for each set of phases.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; nothing was computed.

    Examples
    --------
    >>> import numpy as np, vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> second = np.linspace(1.01, 1.9, 100_000) * np.pi
    >>> flags = vi.stability_flags(osc, 0.94, [np.zeros_like(second), second], vi.Pattern("RL"))
    >>> round(float(np.mean(flags.stable == 1)), 3)
    0.441
    """
    of_numbers(osc)
    pattern = plain_pattern(pattern)
    n = len(pattern)
    wanted = f"an array (N = {n}, M), each column increasing from 0 to below 2 pi k"
    table = checks.real_array(phases, "phases", wanted)
    if table.ndim != 2 or table.shape[0] != n or table.shape[1] == 0:
        raise ParameterError(f"phases of shape {table.shape}: must be {wanted}, M at least 1")
    m = table.shape[1]
    ratios = frequency_ratios(r, m, osc.xi)
    each = impact_restitution(osc, pattern, restitution)
    acceptance = checks.number(acceptance, "acceptance")
    with_radius = checks.truth(spectral_radius, "spectral_radius")
    threads = checks.integer(
        os.cpu_count() or 1 if threads is None else threads, "threads", 1, 1024
    )
    consistent, stable, status = (np.empty(m, dtype=np.int8) for _ in range(3))
    radius = np.empty(m) if with_radius else None
    referred = 0
    checks.progress(progress)
    with reported(progress, "stability_flags") as told:
        for part in in_parts(m, CHUNK, told):
            columns = checks.phase_table(table[:, part], n, pattern.cycles, part.start)
            consistent[part], stable[part], moduli, status[part], count = _core.stability_flags(
                osc.xi, osc.mu, osc.restitution, ratios[part], pattern.cycles, pattern.signs, each,
                np.ascontiguousarray(columns).T, acceptance, with_radius, threads, True,
            )  # fmt: skip
            referred += count
            if radius is not None:
                radius[part] = moduli
    return StabilityFlags(consistent, stable, status, radius, referred)
