"""Bands in which the boundary of a zone lies if parameters are uncertain."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..base import checks
from ..base.checks import Rng
from ..base.errors import ParameterError, ParameterTypeError
from ..base.interrupt import new_counters, stoppable
from ..base.progress import with_progress
from ..results import door
from ..systems.distribution import ROWS, Uncertain, shares, systems, uncertain_parameters
from ..systems.oscillator import Oscillator, Pattern
from ..systems.verbs import physical_arguments
from .zone import Piece, Zone

__all__ = ["BoundaryBand", "boundary_bands"]

_Array = NDArray[np.float64]
#: The conditions whose boundaries move, in the order of the core's numbers, from 1.
TYPES = (
    "fold", "flip", "neimark_sacker", "zero_approach", "grazing", "pitchfork", "rest_vanishes",
    "rest_splits",
)  # fmt: skip
#: Largest difference of the two bands, relative to the width of the sampled one, for which they agree.
AGREEMENT = 0.1
#: Codes of the core: a displaced vertex that bounds the zone; a vertex that was prepared.
FOUND, DONE = 1, 0


@dataclass(frozen=True, eq=False, repr=False)
class BoundaryBand:
    """The band in which a piece of the boundary of a zone lies, at some of its vertices.

    Displacements are along the normal of the nominal boundary, positive away from the zone. For a zone thinner
    than 1e-4 of the window the sign is arbitrary.

    Attributes
    ----------
    type, detail : str
        The condition that is zero there, as in `Piece`.
    symmetric : bool
        Whether the piece bounds motions that are their own mirror image.
    r, clearance : ndarray (V,)
        The vertices.
    normal : ndarray (2, V)
        Change of r and of the logarithm of the clearance for one unit of displacement.
    sensitivity : dict of ndarray (V,)
        First derivative of the displacement with respect to each uncertain parameter (for r, clearance and load:
        with respect to the factor).
    first_order : ndarray (2, V)
        Displacements at both quantiles to first order in the parameters.
    sampled : ndarray (2, V)
        Displacements at both quantiles of the samples for which the displaced boundary was found; NaN if there
        are none.
    found : ndarray (V,)
        Share of the samples for which it was found. For the other samples, the condition vanishes nowhere along
        the normal or could not be followed there, or another condition bounds the zone.
    holds : ndarray (V,) of bool
        Whether first order suffices: the boundary was found for all samples, and the ends of the two bands
        differ by at most a tenth of the width of the sampled band.
    """

    type: str
    detail: str
    symmetric: bool
    r: _Array
    clearance: _Array
    normal: _Array
    sensitivity: dict[str, _Array]
    first_order: _Array
    sampled: _Array
    found: _Array
    holds: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.r)

    def __repr__(self) -> str:
        detail = f" ({self.detail})" if self.detail else ""
        return (
            f"<band of {self.type}{detail}: {len(self)} vertices, first order holds at "
            f"{int(self.holds.sum())}>"
        )

    def edges(self, kind: str = "sampled") -> tuple[_Array, _Array]:
        """Both edges of the band: r and clearance, each (2, V).

        Parameters
        ----------
        kind : {"sampled", "first_order"}
            The band of the samples, or that to first order in the parameters.

        Returns
        -------
        (ndarray, ndarray)
            Frequency ratios and clearances d K/F0, each (2, V): at the low and at the high quantile.

        Raises
        ------
        ParameterError
            If there is no such kind.
        """
        checks.choice(kind, "kind", ("sampled", "first_order"))
        moved = getattr(self, kind)
        return self.r + self.normal[0] * moved, self.clearance * np.exp(self.normal[1] * moved)


@physical_arguments
@with_progress
def boundary_bands(
    zone: Zone,
    uncertain: Mapping[str, Any],
    *,
    samples: int = 64,
    vertices: int = 40,
    quantiles: tuple[float, float] = (0.025, 0.975),
    rng: Rng = 0,
    threads: int | None = None,
    progress: door.Progress | None = None,
) -> list[BoundaryBand]:
    """The bands in which the boundary of a zone lies if parameters are uncertain.

    At each vertex one condition holds: a multiplier on the unit circle, a grazing contact, or a vanishing approach
    speed. The unknowns of the motion are eliminated from the equations of the motion and this condition; what
    remains gives the displacement along the normal to first order. For every sample the displaced boundary is also
    found on the normal by Newton's method. Both bands use the same samples, so that they differ only by the terms
    of higher order.

    Parameters
    ----------
    zone : Zone
        The zone for the nominal values.
    uncertain : dict
        As in `uncertainty`. R1 and R2 of equal walls are rejected: the zone would lose its symmetry, and its
        boundary would not move smoothly.
    samples : int
        1 to 100000.
    vertices : int
        Largest number of vertices of a piece that are examined, 2 to 10000.
    quantiles : (float, float)
        Quantiles of the displacement at the ends of the bands.
    rng : int, numpy.random.Generator or None
        Seed of the samples, as in `uncertainty`.
    threads : int, optional
        Default: one for each processor.
    progress : callable, optional
        As in `uncertainty`.

    Returns
    -------
    list of BoundaryBand
        One for each piece that is not an edge of the window.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    >>> zone = vi.zone(osc, "RL", (0.8, 1.2), (2, 200), symmetric=True)
    >>> bands = vi.boundary_bands(zone, dict(xi=(0.0113, 0.0115), clearance=(0.99, 1.01)))
    >>> [band.type for band in bands]
    ['pitchfork', 'neimark_sacker', 'fold']
    """
    checks.instance(zone, "zone", Zone)
    if zone.of_structure:
        raise ParameterTypeError(f"zone = {zone!r}: must be a zone of an Oscillator")
    parameters = uncertain_parameters(uncertain, "uncertain", factors=True)
    count = checks.integer(samples, "samples", 1, 100_000)
    random = np.random.default_rng(checks.seed_of(rng))
    changes = systems(zone.osc, parameters, shares(count, len(parameters), random))
    return bands_of(
        zone, parameters, changes, vertices, quantile_pair(quantiles), threads, progress
    )


def quantile_pair(quantiles: Any) -> tuple[float, float]:
    """Two quantiles in order."""
    wanted = "two numbers with 0 <= low < high <= 1"
    values = checks.real_array(quantiles, "quantiles", wanted)
    if values.shape != (2,) or not 0 <= values[0] < values[1] <= 1:
        raise ParameterError(f"quantiles = {quantiles!r}: must be {wanted}")
    return float(values[0]), float(values[1])


def bands_of(
    zone: Zone, parameters: Mapping[str, Uncertain], changes: _Array, vertices: Any,
    quantiles: tuple[float, float], threads: int | None, progress: door.Progress | None,
) -> list[BoundaryBand]:  # fmt: skip
    """The bands of a zone for some samples (6, n)."""
    most = checks.integer(vertices, "vertices", 2, 10_000)
    workers = checks.integer(
        os.cpu_count() or 1 if threads is None else threads, "threads", 1, 1024
    )
    keeps_symmetry(zone.osc, changes)
    pieces = [piece for piece in zone.boundary if piece.type in TYPES]
    found = []
    for i, piece in enumerate(pieces):

        def tell(share: float, note: str, i: int = i) -> None:
            if progress is not None:
                progress((i + share) / len(pieces), note)

        found.append(
            band(zone, piece, parameters, changes, most, quantiles, workers, progress and tell)
        )
    return found


def keeps_symmetry(osc: Oscillator, changes: _Array) -> None:
    """Rejects samples with different walls for a system with equal walls."""
    right, left = osc.restitution
    if right == left and (changes[4] != changes[5]).any():
        raise ParameterError(
            "uncertain: R1 and R2 of equal walls must not differ: the motions would lose their symmetry, and the "
            "boundary would not move smoothly; give restitution (the same on both walls), or bands=False"
        )


def band(
    zone: Zone, piece: Piece, parameters: Mapping[str, Uncertain], changes: _Array, most: int,
    quantiles: tuple[float, float], workers: int, progress: Callable[[float, str], None] | None,
) -> BoundaryBand:  # fmt: skip
    """The band of one piece."""
    here = spread(zone, piece, most)
    r, clearance = piece.r[here], piece.clearance[here]
    families = [(piece.type, piece.symmetric, zone.pattern)]
    if piece.type == "pitchfork" and not piece.symmetric:
        # at the vertices the motions are symmetric; the motions of the zone branch off there
        families = [("pitchfork", True, zone.pattern)]
    elif piece.type == "flip":
        families += [("flip", False, shorter) for shorter in divided(zone.pattern)]
    for kind, symmetric, pattern in families:
        steps, slopes, moved, outcomes, status = shifted(
            zone, piece, here, kind, symmetric, pattern, changes, workers, progress
        )
        if (status == DONE).any():
            break
    sign = outwards(zone, r, clearance, steps)
    moved = np.where(outcomes == FOUND, moved * sign, np.nan)
    share = (outcomes == FOUND).mean(axis=0)
    nominal = np.array([1.0, 1.0, zone.osc.xi, zone.osc.mu, *zone.osc.restitution])
    offsets = np.concatenate([np.log(changes[:2]), changes[2:] - nominal[2:, None]])
    linear = np.quantile(sign * (offsets.T @ slopes), quantiles, axis=0)
    sampled = np.full((2, len(here)), np.nan)
    some = share > 0
    if some.any():
        sampled[:, some] = np.nanquantile(moved[:, some], quantiles, axis=0)
    with np.errstate(invalid="ignore"):
        apart = abs(linear - sampled).max(axis=0)
        holds = (share == 1) & (apart <= AGREEMENT * np.ptp(sampled, axis=0) + 1e-12)
    return BoundaryBand(
        piece.type, piece.detail, piece.symmetric, r, clearance, steps * sign, by_name(parameters, slopes * sign),
        linear, sampled, share, holds,
    )  # fmt: skip


def spread(zone: Zone, piece: Piece, most: int) -> NDArray[np.int64]:
    """Selects vertices of a piece: half of them evenly by index, which is denser in bends, half evenly by
    length."""
    if most >= len(piece):
        return np.arange(len(piece))
    r, clearance = (
        piece.r / np.ptp(zone.r),
        np.log(piece.clearance) / np.ptp(np.log(zone.clearance)),
    )
    length = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(r), np.diff(clearance)))])
    place = np.linspace(0, 1, len(piece)) + length / max(float(length[-1]), 1e-300)
    wanted = np.linspace(0, place[-1], min(most, len(piece)))
    return np.unique(np.abs(place - wanted[:, None]).argmin(axis=1))


def shifted(
    zone: Zone, piece: Piece, here: NDArray[np.int64], kind: str, symmetric: bool, pattern: Pattern,
    changes: _Array, workers: int, progress: Callable[[float, str], None] | None,
) -> Any:  # fmt: skip
    """The core's results for some vertices of a piece, as motions of a family."""
    n = 1 if pattern.has_rest else len(pattern)
    sides = [
        int(s) * (2 if "*" in name else 1)
        for s, name in zip(pattern.signs, pattern.symbols, strict=True)
    ]
    number = re.search(r"\d+", piece.detail)
    found, complete = stoppable(
        _core.shift_boundary, zone.osc.xi, zone.osc.mu, zone.osc.restitution, pattern.cycles, sides,
        symmetric, np.array([zone.r, zone.clearance]).T, np.full(len(here), TYPES.index(kind) + 1, np.int32),
        np.full(len(here), int(number[0]) if number else 0, np.int32),
        np.array([piece.r[here], piece.clearance[here]]), piece.x_over_D[:n, here], piece.theta[:n, here], changes,
        workers, counters=new_counters(), progress=progress, note="bands",
    )  # fmt: skip
    if not complete:
        raise KeyboardInterrupt
    return found


def divided(pattern: Pattern) -> list[Pattern]:
    """The shorter patterns of which a pattern is a repetition."""
    n, symbols = len(pattern), pattern.symbols
    return [
        Pattern("".join(symbols[: n // m]), pattern.cycles // m)
        for m in range(2, n + 1)
        if n % m == 0 and pattern.cycles % m == 0 and symbols == symbols[: n // m] * m
    ]


def outwards(zone: Zone, r: _Array, clearance: _Array, steps: _Array) -> _Array:
    """-1 if a step along the normal enters the zone, 1 if it leaves it."""
    with np.errstate(invalid="ignore"):
        behind, ahead = (
            zone._turns(r + part * steps[0], clearance * np.exp(part * steps[1]))
            for part in (-1e-4, 1e-4)
        )
    sign = np.sign(behind - ahead).astype(np.float64)
    known = np.flatnonzero(sign)
    if not known.size:
        return np.ones_like(r)
    # at the edge of the window or in a thin zone: the sign of the nearest vertex where it is known
    nearest = known[np.abs(np.arange(len(r)) - known[:, None]).argmin(axis=0)]
    alike = np.where((steps * steps[:, nearest]).sum(axis=0) < 0, -1.0, 1.0)
    return np.asarray(np.where(sign == 0, alike * sign[nearest], sign))


def by_name(parameters: Mapping[str, Uncertain], slopes: _Array) -> dict[str, _Array]:
    """The derivatives of displacements with respect to each parameter, for factors at their nominal value 1."""
    found = {}
    for name in parameters:
        if name == "restitution":
            found[name] = slopes[4] + slopes[5]
        else:
            found[name] = -slopes[1] if name == "load" else slopes[ROWS.index(name)]
    return found
