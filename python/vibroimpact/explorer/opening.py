"""The state in which the explorer begins: at an oscillator with its units, a motion or a design."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from .. import Design, Identification, Motion, Oscillator, Physical, Units, exact
from ..base.errors import ParameterError, ParameterTypeError, SingularError
from .definition import definition_of
from .state import MOST_CYCLES, MOST_PATTERNS, MOST_SYMBOLS, Box, State

__all__ = ["state_of"]


def state_of(start: Any) -> State:
    """The state that shows an oscillator, a motion at its point, or a design with its tolerance box.

    An identification is shown by its motion. Physical units are those of the result or, if it has none, of its
    oscillator, provided that the load amplitude of the oscillator is known.

    Raises
    ------
    ParameterError, ParameterTypeError
        If the page cannot show the object.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> from vibroimpact.explorer.opening import state_of
    >>> rig = vi.Oscillator.from_dimensional(
    ...     M=2.7, K=42e3, C=7.7, m=0.11, restitution=0.75, F0=6.0, units="m N s"
    ... )
    >>> motion = vi.equispaced(rig, r=1.02, clearance=30.0)[0]
    >>> state_of(motion).units == rig.units()
    True
    >>> state_of(motion).motion.text
    'RL/1/equispaced/0'
    """
    units = start.units if isinstance(start, Physical) else None
    result = start.result if isinstance(start, Physical) else start
    if isinstance(result, Oscillator):
        if not all(isinstance(value, float) for value in result.restitution):
            raise ParameterError(
                f"restitution = {result.restitution!r}: must be numbers; the explorer does not support "
                "laws of restitution"
            )
        return of_system(result, units)
    if isinstance(result, Design):
        return of_design(result, units)
    if isinstance(result, Identification) and result.motion is None:
        raise ParameterError(
            f"status = {result.status!r} of the identification: must be 'periodic'; there is no motion to show"
        )
    if isinstance(result, Identification) and result.motion and result.motion.of_structure:
        if result.law != "constant":
            raise ParameterError(
                f"law = {result.law!r} of the identification: must be 'constant'; the explorer has no laws of "
                "restitution"
            )
        raise ParameterError(
            "load of the identification: must be a sine without harmonics; the explorer does not support "
            "other loads"
        )
    motion = result.motion if isinstance(result, Identification) else result
    if not isinstance(motion, Motion) or motion.of_structure:
        raise ParameterTypeError(
            f"start = {result!r}: must be an Oscillator, a Motion of one, an Identification or a Design, not "
            f"{type(result).__name__}"
        )
    return of_motion(motion, units or units_of(motion.osc))


def units_of(osc: Oscillator) -> Units | None:
    """The units of an oscillator, if they are known."""
    return None if osc.M is None or osc.F0 is None else osc.units()


def of_system(osc: Oscillator, units: Units | None) -> State:
    """The state with an oscillator."""
    right, left = osc.restitution
    return State(xi=osc.xi, mu=osc.mu, R1=right, R2=left, units=units or units_of(osc))


def of_motion(motion: Motion, units: Units | None) -> State:
    """The state with a motion at its point."""
    if motion.load == 0:
        raise ParameterError(
            "load = 0.0 of the motion: must not be 0; the explorer shows clearances as d K/F0"
        )
    load, osc, r = motion.load, motion.osc, motion.r
    clearance = motion.clearance / load
    try:
        near = motion if motion.load == 1 else exact(osc, r, clearance, motion)
        made = definition_of(near)
    except SingularError:
        made = None
    if made is None:
        raise ParameterError(
            f"motion = {motion!r}: must be a motion of its oscillator that `exact` finds again from its phases or "
            "its state"
        )
    # the load of this motion is a multiple of the load amplitude F0 of the units
    scaled = units and Units(units.M, units.K, units.F0 * load, units.names)
    state = around(of_system(osc, scaled), (r, r), (clearance, clearance))
    state = replace(state, r=r, clearance=clearance, motion=made[0])
    pattern = motion.pattern.standard(osc.restitution[0] == osc.restitution[1])
    small = len(pattern) <= MOST_SYMBOLS and pattern.cycles <= MOST_CYCLES
    if pattern not in state.patterns and small:
        state = replace(state, patterns=(pattern, *state.patterns)[:MOST_PATTERNS])
    return state


def of_design(design: Design, units: Units | None) -> State:
    """The state that shows a design: the box spans its band and the tolerance of its clearance for all its loads.

    Other parameters are at the middle of their tolerances.
    """
    if design.target == "damping":
        raise ParameterError(
            "target = 'damping' of the design: must be a target over a band of r; free vibration has no band"
        )
    spread = design.spread
    (r0, r1), (low, _, high) = design.ends, spread["clearance"]
    if not 0 < low:
        raise ParameterError(
            f"tolerance of the clearance: must keep d K/F0 > 0; it reaches {low:.6g}"
        )
    sizes = (0.5 * (r0 + r1), 0.5 * (low + high), 0.5 * (r1 - r0), 0.5 * (high - low))
    box = Box(*(float(f"{size:.10g}") for size in sizes))
    xi, mu, right, left = (spread[name][1] for name in ("xi", "mu", "R1", "R2"))
    state = State(xi=xi, mu=mu, R1=right, R2=left, units=units or units_of(design.osc))
    state = around(state, (r0, r1), (low, high))
    if design.target == "attenuation":
        state = replace(state, limit=design.level if design.limit is None else design.limit)
    return replace(state, r=box.r, clearance=box.clearance, box=box)


def around(state: State, r: tuple[float, float], clearance: tuple[float, float]) -> State:
    """The state with a window that contains the given ranges with a margin; its own window if that is large
    enough."""
    if not state.r_min < r[0] <= r[1] < state.r_max:
        state = replace(
            state,
            r_min=round(0.85 * r[0], 3) or 0.5 * r[0],
            r_max=round(1.15 * r[1], 3) or 2 * r[1],
        )
    if not state.clearance_min < clearance[0] <= clearance[1] < state.clearance_max:
        low, high = float(f"{clearance[0] / 8:.2g}"), float(f"{clearance[1] * 8:.2g}")
        state = replace(state, clearance_min=low, clearance_max=high)
    return state
