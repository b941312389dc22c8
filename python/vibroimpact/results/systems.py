"""The system of a result: an oscillator, or a structure with its load, in tables and in cases."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..base.errors import ParameterError, VibroimpactError
from ..systems.oscillator import Oscillator
from ..systems.record import Record
from ..systems.restitution import KINDS, Restitution, at_rest, from_columns, to_columns
from ..systems.structure import Friction, Gap, Load, Stop, Structure
from ..systems.units import SI, Units
from . import namelist
from .tables import Result

__all__ = [
    "check_gap_numbers", "from_groups", "osc_of", "structure_of", "structure_tables", "system_of", "units_of",
    "with_owners",
]  # fmt: skip

#: The numbers of a power law in tables of gaps.
LAW_NUMBERS = ("law_speed", "law_exponent", "law_sharpness")
#: Those of friction and of a stop, and how the contact of each kind of stops ends.
FRICTION_NUMBERS = ("slip", "stick", "speed")
STOP_NUMBERS = ("stiffness", "damping", "preload")
RELEASES = {"stop": "gap", "pushing": "force"}


def osc_of(result: Result, table: str, row: int = 0) -> Oscillator:
    """The oscillator of a table row that contains its parameters."""
    xi, mu, *walls = (
        float(result.column(table, name).values.ravel()[row]) for name in ("xi", "mu", "R1", "R2")
    )
    columns = result.tables[table].columns
    known: dict[str, Any] = {
        name: columns[name].decoded().ravel()[row].item()
        for name in ("M", "K", "F0", "units") if name in columns
    }  # fmt: skip
    if not known and result.case:
        keys = namelist.system_keys(result.case)
        of_system = {"M": "mass", "K": "stiffness", "F0": "force", "units": "unit_names"}
        known = {name: keys[key] for name, key in of_system.items() if key in keys}
    names = known.pop("units", None)
    return Oscillator(xi=xi, mu=mu, restitution=(walls[0], walls[1]), **known, unit_names=names)


def units_of(osc: Oscillator) -> dict[str, Any]:
    """The columns of the physical units of an oscillator, None where they are not known."""
    return {"M": osc.M, "K": osc.K, "F0": osc.F0, "units": osc.unit_names}


def system_of(case: str) -> tuple[Structure, Load | Record | None]:
    """The structure and the load of the case of a study, with the defaults filled in by the core.

    Raises
    ------
    ParameterError
        If the case is incomplete, as it may be in a file.
    """
    try:
        return from_groups(namelist.parts_of(case)[:-1])
    except VibroimpactError as error:
        raise ParameterError(f"case: {error}") from None
    except (ArithmeticError, LookupError, TypeError, ValueError) as error:
        raise ParameterError(
            f"case = {case[:60]!r}: must be that of a structure; {type(error).__name__}: {error}"
        ) from None


def from_groups(
    groups: Sequence[tuple[str, Mapping[str, Any]]],
) -> tuple[Structure, Load | Record | None]:
    """The structure and the load of the groups of a namelist, with the defaults filled in by the core."""
    (_, keys), *parts = groups
    gaps = [_contact(name, part) for name, part in parts if name in ("gap", "stop")]
    friction = [
        Friction(**{**part, "direction": np.atleast_1d(part["direction"])})
        for name, part in parts if name == "friction"
    ]  # fmt: skip
    if "frequencies" in keys:
        omega = np.atleast_1d(keys["frequencies"])
        shapes = np.reshape(keys["shapes"], (-1, len(omega)))
        structure = Structure.from_modes(
            omega, np.atleast_1d(keys["damping_ratios"]), shapes, gaps, friction, outputs_of(keys),
            simultaneous=keys.get("simultaneous"),
        )  # fmt: skip
    else:
        n = len((*gaps, *friction)[0].direction)
        mass, damping, stiffness = (
            _square(keys[name], n) for name in ("mass", "damping", "stiffness")
        )
        structure = Structure(
            mass, damping, stiffness, gaps, friction, outputs_of(keys), simultaneous=keys.get("simultaneous")
        )._with_units(scales_of(keys))  # fmt: skip
    load: Load | Record | None = None
    for part in (part for name, part in parts if name == "load"):
        n = structure.coordinates
        constant = np.atleast_1d(part["constant"]) if "constant" in part else None
        if "record" in part:
            weights = (
                np.reshape(part["weights"], (-1, n)) if "weights" in part
                else np.eye(n)[np.atleast_1d(part.get("acts_on", np.arange(n)))]
            )  # fmt: skip
            samples = np.reshape(part["record"], (-1, len(weights)))
            return structure, Record(part["step"], samples, constant, weights)
        harmonics = {
            name: np.reshape(part[name], (-1, n)) for name in ("sine", "cosine") if name in part
        }
        load = Load(part.get("frequency"), **harmonics, constant=constant)
    return structure, load


def outputs_of(keys: Mapping[str, Any]) -> dict[str, Any]:
    """The outputs of a structure by the keys of its group."""
    names = keys.get("outputs", [])
    names = [names] if isinstance(names, str) else names
    rows = np.reshape(keys["output_rows"], (len(names), -1)) if names else ()
    return dict(zip(names, rows, strict=True))


def scales_of(keys: Mapping[str, Any]) -> Units | None:
    """The physical units of a dimensionless structure by the keys of its group."""
    if "scales" not in keys:
        return None
    M, K, F0 = keys["scales"]
    return Units(M, K, F0, keys.get("unit_names", SI))


def _contact(name: str, part: Mapping[str, Any]) -> Gap | Stop:
    """The gap or stop of a group of a namelist."""
    direction = np.atleast_1d(part["direction"])
    if name == "stop":
        return Stop(**{**part, "direction": direction})
    return Gap(direction, part["opening"], from_columns(part), part.get("cosine"), part.get("sine"))


def check_gap_numbers(result: Result, structure: Structure) -> None:
    """Raises an error if a column of gaps contains a number that the structure does not have; the core would read
    beyond its arrays."""
    many = len(structure._parts)
    # an atlas has room for the motion with most impacts
    least = -1 if result.study == "atlas" else 0
    for name, table in result.tables.items():
        for key in {"gap", "gaps"} & set(table.columns):
            numbers = table.columns[key].values
            wrong = numbers[~((numbers >= least) & (numbers < many))]
            if wrong.size:
                raise ParameterError(
                    f"{name}.{key} = {wrong[0]}: must be the number of one of {many} gaps, from 0"
                )
        for key, column in table.columns.items():
            if column.each == "coordinate" and column.values.shape[-1] != structure.coordinates:
                raise ParameterError(
                    f"{name}.{key} of shape {column.values.shape}: must be for {structure.coordinates} coordinates"
                )
            if column.each == "output" and column.values.shape[-1] != len(structure.outputs):
                raise ParameterError(
                    f"{name}.{key} of shape {column.values.shape}: must be for {len(structure.outputs)} outputs"
                )


def _square(numbers: Any, n: int) -> Any:
    """A matrix, or its diagonal, from a list."""
    array = np.atleast_1d(numbers)
    return array if len(array) == n else array.reshape(n, n)


def structure_tables(s: Structure, load: Load | Record | None) -> dict[str, Any]:
    """The tables of a structure, its gaps and its load in a result."""
    n = s.coordinates
    nothing = np.zeros((0, n))
    periodic = load if isinstance(load, Load) else None
    laws: list[dict[str, Any]] = []
    for gap in s._parts:
        if isinstance(gap, Gap):
            laws.append(to_columns(gap.restitution))
        else:
            kind, *numbers = gap._law()
            laws.append({"law": KINDS[int(kind)], **dict(zip(LAW_NUMBERS, numbers, strict=True))})
    return {
        "gaps": (("number",), {
            "opening": [getattr(gap, "opening", 0.0) for gap in s._parts],
            "restitution": [at_rest(getattr(gap, "restitution", 0.0)) for gap in s._parts],
            "law": [law.get("law", "constant") for law in laws],
            "law_numbers": np.reshape([[law.get(key, 0.0) for key in LAW_NUMBERS] for law in laws], (-1, 3)),
            "direction": np.reshape([gap.direction for gap in s._parts], (-1, n)),
        }),
        "law_points": (("law_point",), {
            "speed": [v for law in laws for v in law.get("law_speeds", ())],
            "restitution": [value for law in laws for value in law.get("law_values", ())],
        }),
        "matrices": (("row",), {
            "mass": s.mass, "damping": s.damping, "stiffness": s.stiffness,
            "constant": np.zeros(n) if load is None else load.constant,
        }),
        "harmonics": (("harmonic",), {
            "cosine": periodic.cosine if periodic else nothing,
            "sine": periodic.sine if periodic else nothing,
        }),
    }  # fmt: skip


def with_owners(s: Structure, result: Result) -> Result:
    """A result in which each point of a tabulated restitution is assigned to its gap."""
    owners = [
        i for i, gap in enumerate(s.gaps)
        if isinstance(gap, Gap)
        for _ in to_columns(gap.restitution).get("law_speeds", ())
    ]  # fmt: skip
    points = result.tables["law_points"]
    owned = replace(points, parent="gaps", owners=np.array(owners, np.int32))
    return replace(result, tables=result.tables | {"law_points": owned})


def structure_of(result: Result, frequency: float, loaded: bool) -> tuple[Structure, Load | None]:
    """The structure and the load of a result."""

    def values(table: str, *names: str) -> list[Any]:
        return [result.column(table, name).decoded() for name in names]

    gaps: list[Gap | Stop] = []
    friction: list[Friction] = []
    for direction, opening, law in zip(
        *values("gaps", "direction", "opening"), _laws_of(result), strict=True
    ):
        if not isinstance(law, dict):
            gaps.append(Gap(direction, opening, law))
        elif "slip" in law:
            friction.append(Friction(direction, **law))
        else:
            gaps.append(Stop(direction, opening, **law))
    mass, damping, stiffness, constant = values(
        "matrices", "mass", "damping", "stiffness", "constant"
    )
    groups = namelist.parts_of(result.case)
    outputs = outputs_of(groups[0][1]) if groups else None
    # only the case contains the motion of the walls
    parts = [part for name, part in groups if name in ("gap", "stop")]
    if len(parts) == len(gaps):
        walls: list[dict[str, Any]] = [
            {name: part.get(name) for name in ("cosine", "sine")} for part in parts
        ]
        gaps = [replace(gap, **wall) for gap, wall in zip(gaps, walls, strict=True)]
    law = groups[0][1].get("simultaneous") if groups else None
    structure = Structure(mass, damping, stiffness, gaps, friction, outputs, simultaneous=law)
    structure._with_units(scales_of(groups[0][1]) if groups else None)
    if not loaded:
        return structure, None
    sine, cosine = values("harmonics", "sine", "cosine")
    own = {"sine": sine, "cosine": cosine} if len(sine) else {}
    return structure, Load(frequency or None, **own, constant=constant)


def _laws_of(result: Result) -> list[Restitution | dict[str, Any]]:
    """The laws of restitution of the gaps of a result; the arguments of stops and of friction."""
    kinds, lowest, numbers = (
        result.column("gaps", name).decoded() for name in ("law", "restitution", "law_numbers")
    )
    speeds, values = (result.column("law_points", name).values for name in ("speed", "restitution"))
    owners = result.tables["law_points"].owners
    if owners is None:
        raise ParameterError("law_points.owners: must be present; they are missing")
    return [
        dict(zip(STOP_NUMBERS, numbers[i].tolist(), strict=True), release=RELEASES[kind]) if kind in RELEASES
        else dict(zip(FRICTION_NUMBERS, numbers[i].tolist(), strict=True)) if kind == "friction"
        else from_columns({
            "law": kind, "restitution": float(lowest[i]), "law_speeds": speeds[owners == i],
            "law_values": values[owners == i], **dict(zip(LAW_NUMBERS, numbers[i].tolist(), strict=True)),
        })
        for i, kind in enumerate(kinds.tolist())
    ]  # fmt: skip
