"""The search for zones: one call of the core a family of motions, and its vertices as named pieces."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from .. import _core, checks
from ..errors import ParameterError
from ..interchange import namelist
from ..interrupt import interruptible, new_tally
from ..model import Oscillator, Pattern
from ..motion import Motion
from ..status import MORE_EVENTS
from .conditions import EDGE, can_be_symmetric, check_symmetric, type_name
from .geometry import dense_ring
from .zone import Piece, Window, Zone, ZoneSearch, checked_window

__all__ = ["zone"]

_Array = NDArray[np.float64]
#: Room for vertices and loops in one call of the core.
ROOM, LOOPS = 200_000, 400
#: What one family counts in the core's tally of work.
ZONE_WORK = 1000


def zone(
    osc: Oscillator,
    pattern: Pattern,
    r: tuple[float, float],
    clearance: tuple[float, float],
    symmetric: bool | None = None,
    lines: int = 17,
    guesses: int = 12,
    seeds: Sequence[Motion] = (),
    max_points: int = 20_000,
    progress: Callable[[float, str], None] | None = None,
) -> Zone:
    """The zones of stable, admissible motions of a pattern, as closed curves of named pieces.

    Motions of a pattern with rest are followed by the same means. Where a rest vanishes, the accumulation of
    impacts just fails to be completed before the acceleration that closes the gap changes its sign; that end is
    exact to about 1e-10.

    Motions are searched at some nodes of a lattice over the window, and the lattice lines are followed on
    every sheet of motions that they lie on. Where a line enters or leaves a zone, the boundary is traced by
    pseudo-arclength continuation of the motion together with the one condition that is zero there (fold,
    flip, pitchfork, Neimark-Sacker, grazing, zero approach, or an edge of the window); where another condition
    gets zero there is a corner and the boundary goes on along that one.

    Parameters
    ----------
    osc : Oscillator
    pattern : Pattern
        At most 24 impacts.
    r, clearance : (float, float)
        The window: lowest and highest frequency ratio and d K/F0.
    symmetric : bool, optional
        Only motions that are their own mirror image half a period later (True: the equispaced ones, of two
        impacts), only others (False), or both (None).
    lines : int
        Lattice lines each way over a window like that of the 1983 charts (r 0.8 to 1.2, and a factor 100 in
        d K/F0), 5 to 129; a larger window gets more of them, in proportion to the logarithm of d K/F0 and to
        asinh(10 (r - 1)); at least 33 are taken for a pattern with rest. Parts of a zone that touch no line can
        be missed: more lines see more.
    guesses : int
        Guesses for motions at every second node each way; a quarter of it at the others.
    seeds : sequence of Motion
        Motions of the pattern that are known to be there, for sheets that the search could miss. The lines of
        constant r and of constant d K/F0 through each are followed, and every boundary that they meet is traced:
        the zone contains each that is stable, admissible and inside the window, or `search.open_seeds` has it.
    max_points : int
        Most vertices of a loop.
    progress : callable, optional
        Called a few times a second with the share done and what is being done; what it raises ends the search.

    Returns
    -------
    Zone
        Without loops where no stable, admissible motion was found.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed, or the pattern can have no such motions.

    Examples
    --------
    The equispaced motion of Figure 6:

    >>> import vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    >>> equispaced = vi.zone(osc, vi.Pattern("RL"), (0.8, 1.2), (2, 200), symmetric=True)
    >>> equispaced
    <Zone RL/1, symmetric: 1 loop, bounded by pitchfork, neimark_sacker, fold>
    >>> equispaced.contains(1.04, [25.0, 3.0]).tolist()
    [True, False]
    """
    checks.instance(osc, "osc", Oscillator)
    checks.instance(pattern, "pattern", Pattern)
    if len(pattern) > 24:
        raise ParameterError(f"pattern of {len(pattern)} impacts: must have at most 24")
    window = checked_window(osc, r, clearance)
    lines = checks.integer(lines, "lines", 5, 129)
    guesses = checks.integer(guesses, "guesses", 0, 10**5)
    max_points = checks.integer(max_points, "max_points", 100, ROOM)
    if symmetric is not None and pattern.has_rest:
        raise ParameterError(
            f"symmetric = {symmetric!r}: must be None for a pattern with rest, whose motions are not told apart"
        )
    check_symmetric(symmetric, osc, pattern)
    kinds = [symmetric]
    if symmetric is None:
        kinds = [True, False] if can_be_symmetric(osc, pattern) else [False]
    table = seed_table(pattern, seeds)
    found = assemble(
        osc, pattern, window, symmetric, kinds, lines, guesses, table, max_points, progress
    )
    if len(seeds):
        return found
    limits = {"lines": lines, "guesses": guesses, "max_points": max_points}
    sides = {
        "sides": pattern.sides,
        "cycles": pattern.cycles,
        "symmetric": namelist.SYMMETRIC[symmetric],
    }
    asked = namelist.case(osc, zone={**sides, **namelist.window(*window), **limits})
    return replace(found, case=asked)


def assemble(
    osc: Oscillator, pattern: Pattern, window: Window, symmetric: bool | None, kinds: Sequence[bool | None],
    lines: int, guesses: int, seeds: _Array, max_points: int,
    progress: Callable[[float, str], None] | None = None,
) -> Zone:  # fmt: skip
    """One zone from the symmetric and the other motions of a pattern; all arguments are checked."""
    tally = new_tally()  # the core keeps it up to date while it runs

    def watch() -> None:
        if progress:
            progress(
                float(tally[0]) / (ZONE_WORK * len(kinds)), f"{pattern.sides}/{pattern.cycles}"
            )

    parts = [
        one_family(
            osc, pattern, window, bool(kind), lines, guesses, seeds, max_points, tally,
            watch if progress else None,
        )
        for kind in kinds
    ]  # fmt: skip
    pieces: list[Piece] = []
    rings: list[_Array] = []
    for part_pieces, part_rings, *_ in parts:
        pieces.extend(
            p if p.loop < 0 else replace(p, loop=p.loop + len(rings)) for p in part_pieces
        )
        rings.extend(part_rings)
    work = np.sum([part[3][:3] for part in parts], axis=0).tolist()
    is_open = np.any([part[4] for part in parts], axis=0)
    search = ZoneSearch(
        work[0], work[1], work[2], tuple(parts[0][3][3:].tolist()),
        [(r, d) for r, d in seeds[:2, is_open].T.tolist()],
    )  # fmt: skip
    closed = all(part[2] for part in parts) and not search.open_seeds
    return Zone(osc, pattern, *window, symmetric, pieces, rings, closed, search)


def seed_table(pattern: Pattern, seeds: Sequence[Motion]) -> _Array:
    """Seeds as columns r, D, x_i/D, theta_i."""
    columns = []
    for i, motion in enumerate(seeds):
        checks.instance(motion, f"seeds[{i}]", Motion)
        if motion.pattern != pattern:
            raise ParameterError(
                f"seeds[{i}].pattern = {motion.pattern!r}: must be {pattern!r}, with the same first impact"
            )
        if pattern.has_rest:
            columns.append(rest_seed(motion))
            continue
        columns.append(
            np.r_[
                motion.r, motion.clearance, motion.X / motion.clearance, motion.phases + motion.tau
            ]
        )
    return np.asfortranarray(np.array(columns).reshape(len(columns), 2 + 2 * len(pattern)).T)


def rest_seed(motion: Motion) -> _Array:
    """A motion with rest as a seed: its release at the end of the last starred letter."""
    side = [letter for letter in motion.pattern.letters if letter.endswith("*")][-1][0]
    events = motion.events
    release = events[(events["kind"] == "release") & (events["side"] == side)][-1]
    column = np.zeros(2 + 2 * len(motion.pattern))
    column[:4] = (
        motion.r,
        motion.clearance,
        release["phase"],
        release["x_dot_after"] / motion.clearance,
    )
    return column


def one_family(
    osc: Oscillator, pattern: Pattern, window: Window, symmetric: bool, lines: int, guesses: int,
    seeds: _Array, max_points: int, tally: NDArray[np.int32], watch: Callable[[], None] | None,
) -> tuple[list[Piece], list[_Array], bool, NDArray[np.int32], NDArray[np.bool_]]:  # fmt: skip
    """Pieces, rings, whether all are closed, work, and open seeds of the symmetric or the other motions."""
    # simulation finds a motion with rest only inside its zone, which may be narrow
    lines = max(lines, 33) if pattern.has_rest else lines
    vertices, unknowns, labels, _, loops, inside, n_loops, open_seeds, work, status = interruptible(
        _core.zone, osc.xi, osc.mu, osc.restitution, pattern.cycles, letter_codes(pattern), symmetric,
        *window, lines, guesses, max_points, seeds, tally, ROOM, LOOPS, watch=watch, tally=tally,
    )  # fmt: skip
    pieces, rings, all_closed = named_pieces(
        osc,
        pattern,
        window,
        symmetric,
        vertices,
        unknowns,
        labels,
        loops[:, : int(n_loops)],
        inside,
    )
    all_closed = all_closed and int(status) != MORE_EVENTS and int(work[2]) == 0
    return pieces, rings, all_closed, work, open_seeds == 1


def named_pieces(
    osc: Oscillator, pattern: Pattern, window: Window, symmetric: bool, vertices: _Array, unknowns: _Array,
    labels: NDArray[np.int32], loops: NDArray[np.int32], inside: _Array,
) -> tuple[list[Piece], list[_Array], bool]:  # fmt: skip
    """Pieces, rings, and whether all are closed, of the loops that the core traced one after the other."""
    mirrored = not symmetric and can_be_symmetric(osc, pattern)
    pieces: list[Piece] = []
    rings: list[_Array] = []
    all_closed = True
    first = 0
    for i in range(loops.shape[1]):
        count, closed = loops[:, i].tolist()
        here = slice(first, first + count)
        first += count
        all_closed = all_closed and closed == 1
        if closed:
            rings.append(dense_ring(vertices[:, here], window, inside[:, i]))
        number = len(rings) - 1 if closed else -1
        pieces.extend(
            split_pieces(
                vertices[:, here],
                unknowns[1::-1, here] if pattern.has_rest else unknowns[:, here],
                labels[:, here],
                number,
                symmetric,
                mirrored,
                1 if pattern.has_rest else len(pattern),
                closed == 1,
            )
        )
    return pieces, rings, all_closed


def letter_codes(pattern: Pattern) -> NDArray[np.int32]:
    """The core's letters: +1, -1 for an impact, +2, -2 for accumulation and rest."""
    return pattern.signs * np.where(pattern.rests, 2, 1).astype(np.int32)


def split_pieces(
    vertices: _Array, unknowns: _Array, labels: NDArray[np.int32], loop: int, symmetric: bool,
    mirrored: bool, n: int, closed: bool,
) -> list[Piece]:  # fmt: skip
    """The runs of vertices with one condition; the first and the last run join at the start."""
    count = labels.shape[1]
    # a corner is there twice: where a piece ends (1) and where the next begins (2)
    changes = [j for j in range(1, count) if labels[3, j] == 2]
    runs = [list(range(a, b)) for a, b in zip([0, *changes], [*changes, count], strict=True)]
    if closed:
        if len(runs) == 1:
            runs[0].append(0)
        elif labels[3, 0] != 2:
            runs[0] = runs.pop() + runs[0]
    pieces = []
    for run in runs:
        kind, index, side, _ = labels[:, run[-1] if len(run) < 2 else run[1]].tolist()
        name = type_name(kind, index, symmetric, mirrored)
        detail = ""
        if kind == EDGE:
            name = "window"
            detail = f"{'lowest' if side > 0 else 'highest'} {('r', 'd K/F0')[index - 1]}"
        elif name == "grazing":
            detail = f"flight {index} touches {'R' if side > 0 else 'L'}"
        elif name == "zero_approach":
            detail = f"impact {index}"
        pieces.append(
            Piece(
                name,
                vertices[0, run],
                vertices[1, run],
                unknowns[:n, run],
                unknowns[n : 2 * n, run],
                loop,
                detail,
                symmetric,
            )
        )
    return pieces
