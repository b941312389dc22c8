"""Results as xarray datasets: named dimensions; units, symbol and meaning of each variable."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import MissingExtraError, ParameterError

if TYPE_CHECKING:
    from ..found import Findings
    from ..motion import Motion
    from ..studies.atlas import Atlas
    from ..studies.branch import Branch
    from ..studies.zone import Zone
    from ..trajectory import Trajectory

#: Unit, symbol and meaning of each variable.
VARIABLES = {
    "r": ("1", "r", "frequency ratio Omega/omega"),
    "clearance": ("1", "D", "clearance d K/F0"),
    "xi": ("1", "xi", "damping ratio"),
    "mu": ("1", "mu", "mass ratio"),
    "R1": ("1", "R1", "coefficient of restitution of the right wall"),
    "R2": ("1", "R2", "coefficient of restitution of the left wall"),
    "load": ("F0", "f", "load amplitude"),
    "time": ("1/omega", "t", "time"),
    "phase": ("rad", "", "phase of the load, in [0, 2 pi)"),
    "phases": ("rad", "alpha", "load phase of each impact after the first"),
    "restitution": ("1", "R", "coefficient of restitution of each impact"),
    "X": ("F0/K", "X", "position of the primary mass"),
    "Z": ("F0/K", "Z", "position of the free mass"),
    "x": ("F0/K", "x", "position of the primary mass"),
    "z": ("F0/K", "z", "position of the free mass"),
    "A": ("F0/K", "A", "amplitude of the motion without impacts"),
    "tau": ("rad", "tau", "phase of the forced motion at the first impact"),
    "residual": ("1", "epsilon", "relative residual of the equations"),
    "x_min": ("F0/K", "x_min", "least position of the primary mass"),
    "x_max": ("F0/K", "x_max", "greatest position of the primary mass"),
    "attenuation": ("1", "max|x|/A", "greatest |x| over the amplitude without impacts"),
    "multipliers_real": ("1", "Re lambda", "real part of the multipliers (eigenvalues of [P])"),
    "multipliers_imag": ("1", "Im lambda", "imaginary part of the multipliers"),
    "kind": ("", "", "impact; stick, where accumulating impacts end in rest; release, where it ends"),
    "side": ("", "", "wall, right or left; * for accumulation and rest"),
    "special": ("", "", "bifurcation, or end, at the point"),
    "piece_x": ("1", "x/D", "position of the primary mass at each impact, over D"),
    "piece_theta": ("rad", "theta", "phase of the forced motion at each impact"),
    "piece": ("1", "", "piece that the vertex belongs to"),
    "type": ("", "", "what happens along the piece"),
    "detail": ("", "", "which flight touches which wall, or which edge of the window"),
    "loop": ("1", "", "loop that the piece belongs to; -1: left open"),
    "ring": ("1", "", "loop that the point belongs to"),
    "ring_r": ("1", "r", "frequency ratio along the loops, anticlockwise round a zone"),
    "ring_clearance": ("1", "D", "clearance d K/F0 along the loops"),
    "zone": ("1", "", "zone that the piece belongs to"),
    "ring_zone": ("1", "", "zone that the point belongs to"),
    **{
        f"{name}_{key}": (unit, symbol, f"{meaning} {of}")
        for name, of in (
            ("survey", "of a point of the survey"),
            ("unexplained", "of a motion in no zone of its pattern"),
            ("beyond", "of a motion beyond the limits of impacts and cycles"),
        )
        for key, unit, symbol, meaning in (
            ("r", "1", "r", "frequency ratio"), ("clearance", "1", "D", "clearance d K/F0"),
            ("pattern", "", "", "pattern"),
        )
    },
    "sides": ("", "", "walls of the impacts in order"),
    "cycles": ("1", "k", "load cycles in a period"),
    **{
        f"{letter}_dot{when}": (
            "omega F0/K", f"d{letter}/dt",
            f"velocity of the {mass} mass" + (f" just {when[1:]} the impact" if when else ""),
        )
        for letter, mass in (("X", "primary"), ("x", "primary"), ("Z", "free"), ("z", "free"))
        for when in ("", "_before", "_after")
    },
}  # fmt: skip
VERDICTS = ("consistent", "admissible", "stable")
CODES = {True: 1, False: 0, None: -1}


def xarray(what: str = "tables") -> Any:
    """The xarray module, or an error that says how to get it, for the sake of what."""
    try:
        import xarray as module
    except ImportError:
        raise MissingExtraError(f"{what} need xarray: pip install 'vibroimpact[data]'") from None
    return module


def to_xarray(result: Any) -> Any:
    """A result as a Dataset, with its complete case among the attributes."""
    makers: dict[str, Any] = {
        "Motion": of_motion, "Trajectory": of_trajectory, "Branch": of_branch, "Zone": of_zone,
        "Atlas": of_atlas, "Findings": of_found,
    }  # fmt: skip
    name = type(result).__name__
    data, attributes = makers[name](result)
    variables = {
        key: (dims, np.asarray(values), described(key)) for key, (dims, values) in data.items()
    }
    return xarray().Dataset(variables, attrs={**attributes, **common(result)})


def described(name: str) -> dict[str, Any]:
    """The attributes of a variable."""
    if name == "outcome":
        return outcome_attributes()
    if name in VERDICTS:
        flags = {"flag_values": np.array([1, 0, -1], np.int8), "flag_meanings": "yes no unknown"}
        return {"long_name": f"whether the motion is {name}", "units": "1", **flags}
    unit, symbol, meaning = VARIABLES[name]
    named = {"long_name": meaning, "units": unit, "symbol": symbol}
    return {key: text for key, text in named.items() if text}


def outcome_attributes() -> dict[str, Any]:
    """Of the codes of what became of the points of a survey."""
    from ..studies.atlas import OUTCOMES

    return {
        "long_name": "what became of the point of the survey", "units": "1",
        "flag_values": np.arange(1, len(OUTCOMES) + 1, dtype=np.int8),
        "flag_meanings": " ".join(name.replace(" ", "_") for name in OUTCOMES),
    }  # fmt: skip


def common(result: Any) -> dict[str, Any]:
    """Attributes of every dataset."""
    from .. import __version__

    try:
        case = result.to_namelist()
    except ParameterError:
        case = ""
    return {
        "Conventions": "CF-1.11", "title": repr(result), "case": case,
        "source": f"vibroimpact {__version__}", "result": type(result).__name__,
        "comment": "lengths in F0/K, time in 1/omega, angles in radians",
    }  # fmt: skip


def system(osc: Any, pattern: Any = None) -> dict[str, Any]:
    """Attributes that tell of the system, and of the pattern."""
    right, left = osc.restitution
    own = {"xi": osc.xi, "mu": osc.mu, "R1": right, "R2": left}
    return own if pattern is None else own | {"sides": pattern.sides, "cycles": pattern.cycles}


def event_variables(events: Any) -> dict[str, Any]:
    """Events, one dimension."""
    return {name: ("event", events[name]) for name in events.dtype.names}


def of_motion(motion: Motion) -> tuple[dict[str, Any], dict[str, Any]]:
    """Impacts, multipliers, and what there is one of."""
    names = (
        "restitution",
        "phases",
        "X",
        "Z",
        "X_dot_before",
        "X_dot_after",
        "Z_dot_before",
        "Z_dot_after",
    )
    data: dict[str, Any] = {name: ("impact", getattr(motion, name)) for name in names}
    data["side"] = ("impact", motion.pattern.letters)
    data["multipliers_real"] = ("multiplier", motion.multipliers.real)
    data["multipliers_imag"] = ("multiplier", motion.multipliers.imag)
    for name in ("r", "clearance", "load", "A", "tau", "residual", "x_min", "x_max"):
        data[name] = ((), getattr(motion, name))
    data["attenuation"] = ((), motion.attenuation if motion.A > 0 else np.nan)
    for name in VERDICTS:
        data[name] = ((), np.int8(CODES[getattr(motion, name)]))
    if motion.rest_events is not None:
        events = event_variables(motion.rest_events)
        data |= {name: item for name, item in events.items() if name not in data}
    kinds = {"kind_of_motion": motion.kind, "precision": motion.precision}
    return data, {**system(motion.osc, motion.pattern), **kinds}


def of_found(found: Findings) -> tuple[dict[str, Any], dict[str, Any]]:
    """One motion after the other, NaN where one has fewer impacts than another."""
    each = [of_motion(motion)[0] for motion in found.motions]
    most = max([len(motion.pattern) for motion in found.motions], default=0)
    data: dict[str, Any] = {
        "sides": ("motion", np.array([motion.pattern.sides for motion in found.motions], dtype=object)),
        "cycles": ("motion", np.array([motion.pattern.cycles for motion in found.motions], dtype=np.int32)),
    }  # fmt: skip
    for name, (dims, _) in (each[0] if each else {}).items():
        if dims in ("event", ()) and name in ("r", "clearance", "load"):
            continue
        if dims == "impact" and name != "side":
            table = np.full((len(each), most), np.nan)
            for row, one in zip(table, each, strict=True):
                row[: len(one[name][1])] = one[name][1]
            data[name] = (("motion", "impact"), table)
        elif dims in ("multiplier", ()):
            data[name] = (
                ("motion", dims) if dims else "motion",
                np.array([one[name][1] for one in each]),
            )
    data |= {name: ((), getattr(found, name)) for name in ("r", "clearance", "load")}
    return data, {**system(found.osc), "searched": str(found.search)}


def of_trajectory(run: Trajectory) -> tuple[dict[str, Any], dict[str, Any]]:
    """Events, and both ends as attributes."""
    data = event_variables(run.events)
    data |= {name: ((), getattr(run, name)) for name in ("r", "clearance", "load")}
    names = ("t", "x", "x_dot", "z", "z_dot")
    ends = {
        f"{end}_{name}": getattr(run, f"{end}_state")[name]
        for end in ("initial", "final")
        for name in names
    }
    return data, {**system(run.osc), **ends, "complete": int(run.complete)}


def of_branch(branch: Branch) -> tuple[dict[str, Any], dict[str, Any]]:
    """Points."""
    names = (
        "r",
        "clearance",
        "xi",
        "mu",
        "R1",
        "R2",
        "A",
        "tau",
        "residual",
        "x_min",
        "x_max",
        "attenuation",
    )
    data: dict[str, Any] = {name: ("point", getattr(branch, name)) for name in names}
    data |= {
        name: ("point", row.astype(np.int8))
        for name, row in zip(VERDICTS, branch.verdicts, strict=True)
    }
    data["phases"] = (("impact", "point"), branch.phases)
    columns = ("X", "Z", "X_dot_before", "X_dot_after", "Z_dot_before", "Z_dot_after")
    data |= {name: (("impact", "point"), branch.impacts[:, i]) for i, name in enumerate(columns)}
    data["side"] = ("impact", branch.pattern.letters)
    data["multipliers_real"] = (("multiplier", "point"), branch.multipliers.real)
    data["multipliers_imag"] = (("multiplier", "point"), branch.multipliers.imag)
    special = np.full(len(branch), "", dtype="U16")
    for item in branch.special_points:
        special[item.index] = item.type
    data["special"] = ("point", special)
    return data, {
        "parameter": branch.parameter, "sides": branch.pattern.sides, "cycles": branch.pattern.cycles,
        "symmetric": int(branch.symmetric), "first_end": branch.ends[0], "last_end": branch.ends[1],
    }  # fmt: skip


def of_zone(zone: Zone) -> tuple[dict[str, Any], dict[str, Any]]:
    """Vertices of the pieces, and points of the loops."""
    data = zones([zone])
    window = {
        "r": list(zone.r),
        "clearance": list(zone.clearance),
        "closed": int(zone.closed),
    }
    words = {True: "yes", False: "no", None: "both"}
    return data, {**system(zone.osc, zone.pattern), **window, "symmetric": words[zone.symmetric]}


def of_atlas(atlas: Atlas) -> tuple[dict[str, Any], dict[str, Any]]:
    """The same of all zones, with their patterns."""
    data = zones(atlas.zones)
    data["zone"] = (
        "piece_number",
        np.repeat(range(len(atlas.zones)), [len(z.boundary) for z in atlas.zones]),
    )
    points = [sum(map(len, zone.loops)) for zone in atlas.zones]
    data["ring_zone"] = ("ring_vertex", np.repeat(range(len(atlas.zones)), points))
    data["sides"] = (
        "zone_number",
        np.array([zone.pattern.sides for zone in atlas.zones], dtype=object),
    )
    data["cycles"] = (
        "zone_number",
        np.array([zone.pattern.cycles for zone in atlas.zones], dtype=np.int32),
    )
    data["survey_r"] = ("survey_point", atlas.survey.r)
    data["survey_clearance"] = ("survey_point", atlas.survey.clearance)
    data["outcome"] = ("survey_point", np.asarray(atlas.survey.outcome, np.int8))
    for name, items in (("unexplained", atlas.unexplained), ("beyond", atlas.beyond)):
        data[f"{name}_r"] = (name, np.array([item.r for item in items], dtype=float))
        data[f"{name}_clearance"] = (
            name,
            np.array([item.clearance for item in items], dtype=float),
        )
        data[f"{name}_pattern"] = (
            name,
            np.array(
                [f"{item.pattern.sides}/{item.pattern.cycles}" for item in items], dtype=object
            ),
        )
    return data, {
        **system(atlas.osc), "r": list(atlas.r), "clearance": list(atlas.clearance), "survey": str(atlas.survey),
        "without_impacts": "the free mass at rest, where clearance > 2/sqrt((1 - r^2)^2 + (2 xi r)^2)",
    }  # fmt: skip


def zones(found: list[Zone]) -> dict[str, Any]:
    """The tables of vertices, pieces and rings of some zones, numbered through."""
    pieces = [piece for zone in found for piece in zone.boundary]
    rings = [ring for zone in found for ring in zone.loops]
    lengths = [len(piece) for piece in pieces]
    most = max([len(piece.x) for piece in pieces], default=0)
    x, theta = (np.full((most, sum(lengths)), np.nan) for _ in range(2))
    first = 0
    for piece in pieces:
        x[: len(piece.x), first : first + len(piece)] = piece.x
        theta[: len(piece.theta), first : first + len(piece)] = piece.theta
        first += len(piece)
    points = np.concatenate([np.empty((0, 2)), *rings])
    words = {
        name: np.array([getattr(p, name) for p in pieces], dtype=object)
        for name in ("type", "detail")
    }
    return {
        "r": ("vertex", np.concatenate([np.empty(0), *(piece.r for piece in pieces)])),
        "clearance": ("vertex", np.concatenate([np.empty(0), *(piece.clearance for piece in pieces)])),
        "piece_x": (("unknown", "vertex"), x), "piece_theta": (("unknown", "vertex"), theta),
        "piece": ("vertex", np.repeat(range(len(pieces)), lengths)),
        "type": ("piece_number", words["type"]), "detail": ("piece_number", words["detail"]),
        "loop": ("piece_number", np.array([piece.loop for piece in pieces], dtype=np.int32)),
        "ring_r": ("ring_vertex", points[:, 0]), "ring_clearance": ("ring_vertex", points[:, 1]),
        "ring": ("ring_vertex", np.repeat(range(len(rings)), [len(ring) for ring in rings])),
    }  # fmt: skip
