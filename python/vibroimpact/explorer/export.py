"""The contents of the page as a namelist and as Python; both reproduce the same digits."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from .. import Zone
from .definition import NEEDED
from .explorer import VALUES, Explorer, along
from .motions import Shown
from .state import State
from .zones import GUESSES, lines_of

__all__ = ["as_namelist", "as_python"]


def as_namelist(explorer: Explorer) -> str:
    """The motions, the simulation, the zones and the diagram as a file for `vibroimpact run`.

    Examples
    --------
    >>> from vibroimpact.explorer.explorer import Explorer
    >>> from vibroimpact.explorer.export import as_namelist
    >>> from vibroimpact.explorer.state import State
    >>> print(as_namelist(Explorer(State())))  # doctest: +ELLIPSIS
    ! What the explorer shows at ?
    &system
      xi = 0.0114, mu = 0.028, restitution = 0.75, 0.75, r = 1.04
    /
    ! both equispaced motions are one case; those that are admissible are shown
    &motion
      kind = 'equispaced', cycles = 1, clearance = 25.0
    ...
    """
    state = explorer.state
    lines = [f"! What the explorer shows at ?{state.query}"]
    lines += _system(state, state.r)
    done: set[str] = set()
    for shown in explorer.shown:
        group, keys = _motion_keys(shown, state.clearance)
        if keys not in done:
            done.add(keys)
            if shown.definition.kind == "equispaced":
                lines.append(
                    "! both equispaced motions are one case; those that are admissible are shown"
                )
            lines += _group(group, keys) + _output(f"motion_{len(done)}")
    if state.run is not None:
        run = state.run
        start = ", ".join(f"{name} = {value!r}" for name, value in run.state.items())
        keys = f"clearance = {state.clearance!r}, cycles = {run.cycles!r}, discard = {run.discard!r}, {start}"
        lines += _group("simulate", keys) + _output("run")
    for i, zone in enumerate(explorer.zones.values(), start=1):
        lines += _group("zone", _zone_keys(zone)) + _output(f"zone_{i}")
    return "\n".join([*lines, *_diagram_lines(state)]) + "\n"


def _diagram_lines(state: State) -> list[str]:
    """The diagram, as the last group: a line at an r other than that of the point needs its own &system."""
    if state.line is None:
        return []
    parameter, values, other = along(state)
    if np.ndim(other):
        return [
            "! a &bifurcation cannot follow an oblique line; the diagram is in the copy as Python"
        ]
    low, high = float(values[0]), float(values[-1])
    keys = f"parameter = '{parameter}', low = {low!r}, high = {high!r}, values = {VALUES}"
    if parameter == "r":
        keys += f", clearance = {other!r}"
    system = _system(state, other) if parameter == "clearance" and other != state.r else []
    return system + _group("bifurcation", keys) + _output("diagram")


def _system(state: State, r: float) -> list[str]:
    keys = (
        f"xi = {state.xi!r}, mu = {state.mu!r}, restitution = {state.R1!r}, {state.R2!r}, r = {r!r}"
    )
    units = state.units
    if units is not None:
        keys += f",\n  mass = {units.M!r}, stiffness = {units.K!r}, force = {units.F0!r}, "
        keys += f"unit_names = '{units.names}'"
    return _group("system", keys)


def _group(name: str, keys: str) -> list[str]:
    return [f"&{name}", f"  {keys}", "/"]


def _output(name: str) -> list[str]:
    return _group("output", f"name = 'explorer_{name}'")


def _motion_keys(shown: Shown, clearance: float) -> tuple[str, str]:
    """The group of a motion, and its keys; the clearance of a motion itself has been rounded."""
    definition = shown.definition
    cycles = f"cycles = {definition.pattern.cycles}"
    if definition.kind == "equispaced":
        return "motion", f"kind = 'equispaced', {cycles}, clearance = {clearance!r}"
    if definition.kind == "phases":
        phases = ", ".join(map(repr, definition.numbers))
        return "motion", (
            f"kind = 'exact', sides = '{definition.pattern.sides}', {cycles}, phases = {phases}, "
            f"clearance = {clearance!r}"
        )
    # a &motion cannot start from a state: the events over the same time are computed instead
    state = ", ".join(f"{name} = {v!r}" for name, v in zip(NEEDED, definition.numbers, strict=True))
    return "simulate", (
        f"clearance = {clearance!r}, cycles = {3 * definition.pattern.cycles}, {state}"
    )


def _zone_keys(zone: Zone) -> str:
    kind = {True: "yes", False: "no", None: "both"}[zone.symmetric]
    (r0, r1), (d0, d1) = zone.r, zone.clearance
    return (
        f"sides = '{zone.pattern.sides}', cycles = {zone.pattern.cycles}, symmetric = '{kind}', "
        f"r_min = {r0!r}, r_max = {r1!r}, clearance_min = {d0!r}, clearance_max = {d1!r}, "
        f"lines = {lines_of(zone)}, guesses = {GUESSES[lines_of(zone)]}"
    )


def as_python(explorer: Explorer) -> str:
    """A Python program that computes the motions, the simulation, the diagram and the zones.

    Examples
    --------
    >>> from vibroimpact.explorer.explorer import Explorer
    >>> from vibroimpact.explorer.export import as_python
    >>> from vibroimpact.explorer.state import State
    >>> exec(as_python(Explorer(State())))  # doctest: +ELLIPSIS
    <Motion RL/1 at r = 1.04, d K/F0 = 25: admissible, stable ...
    """
    state = explorer.state
    units = state.units
    physical = "" if units is None else (
        f", M={units.M!r}, K={units.K!r}, F0={units.F0!r}, unit_names={units.names!r}"
    )  # fmt: skip
    blocks = [
        [f"# What the explorer shows at ?{state.query}", *_imports(state), ""],
        [
            f"osc = vi.Oscillator(xi={state.xi!r}, mu={state.mu!r}, restitution=({state.R1!r}, {state.R2!r})"
            f"{physical})",
            f"r, clearance = {state.r!r}, {state.clearance!r}",
            *_list("motions", map(_motion_call, explorer.shown)),
        ],
    ]
    if state.run is not None:
        run = state.run
        blocks.append(
            [f"run = vi.simulate(osc, r, clearance, cycles={run.cycles!r}, state={run.state!r}, "
             f"discard={run.discard!r})"]
        )  # fmt: skip
    if state.line is not None:
        blocks.append([_diagram_call(state.line)])
    if explorer.zones:
        blocks.append([*_list("zones", map(_zone_call, explorer.zones.values()))])
    blocks.append(["for motion in motions:", "    print(repr(motion))"])
    return "\n".join(line for block in blocks for line in block) + "\n"


def _imports(state: State) -> list[str]:
    return (["import numpy as np"] if state.line is not None else []) + ["import vibroimpact as vi"]


def _list(name: str, calls: Iterable[str]) -> Iterator[str]:
    yield f"{name} = ["
    yield from (f"    {call}," for call in calls)
    yield "]"


def _motion_call(shown: Shown) -> str:
    definition = shown.definition
    sides, cycles = definition.pattern.sides, definition.pattern.cycles
    if definition.kind == "equispaced":
        return f"vi.equispaced(osc, r, clearance, cycles={cycles})[{int(definition.numbers[0])}]"
    if definition.kind == "phases":
        return f'vi.exact(osc, r, clearance, ({list(definition.numbers)!r}, vi.Pattern("{sides}", {cycles})))'
    state = dict(zip(NEEDED, definition.numbers, strict=True))
    run = f"vi.simulate(osc, r, clearance, cycles={3 * cycles}, state={state!r})"
    return f"vi.exact(osc, r, clearance, {run})"


def _zone_call(zone: Zone) -> str:
    lines = lines_of(zone)
    return (
        f'vi.zone(osc, vi.Pattern("{zone.pattern.sides}", {zone.pattern.cycles}), r={zone.r!r}, '
        f"clearance={zone.clearance!r}, symmetric={zone.symmetric}, lines={lines}, guesses={GUESSES[lines]})"
    )


def _diagram_call(line: tuple[float, float, float, float]) -> str:
    """The call that computes the diagram as `diagram_of` does."""
    a, b, c, d = line
    if a == c:
        values = f"np.linspace({min(b, d)!r}, {max(b, d)!r}, {VALUES})"
        return f'diagram = vi.bifurcation_diagram(osc, "clearance", {values}, r={a!r})'
    if a > c:
        a, b, c, d = c, d, a, b
    other = repr(b) if b == d else f"np.geomspace({b!r}, {d!r}, {VALUES})"
    return f'diagram = vi.bifurcation_diagram(osc, "r", np.linspace({a!r}, {c!r}, {VALUES}), clearance={other})'
