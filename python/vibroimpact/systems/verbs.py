"""Functions that accept every system: an oscillator, a structure with its load, or an oscillator at a point."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterable, Mapping
from typing import Any, ParamSpec, TypeVar

import numpy as np

from ..base.errors import ParameterError, ParameterTypeError
from .distribution import FACTORS
from .oscillator import Oscillator, Point
from .structure import Load, Structure
from .units import (
    AXES,
    BY_NAME,
    OF_PARAMETER,
    OF_STATES,
    PARAMETERS,
    PLAIN,
    START,
    TIMES,
    OfStructure,
    dimensionless,
    has_unit,
    refuse_hertz,
    shown_as_given,
)

#: Parameters without a dimension, which may be given in %.
SHARES = [name for name, unit in PARAMETERS.items() if unit == ""]
#: Examples of texts with units as arguments.
EXAMPLES = '"19.5 Hz", "4 mm" and "6 N"'
Given = ParamSpec("Given")
Found = TypeVar("Found")
#: The attributes of a point, by the names of arguments.
OF_POINT = {
    "osc": "osc", "r": "r", "clearance": "clearance", "load": "amplitude", "friction": "friction",
    "stops": "stops",
}  # fmt: skip


def usage(name: str, kind: type | None, of_structure: Callable[..., Any]) -> str:
    """A sentence of the docstring with the signature of a function for structures."""
    of = "a motion of a structure" if kind else "a structure"
    shown = plain_signature([*inspect.signature(of_structure).parameters.values()])
    return f"For {of}: ``{name}{shown}``."


def usage_of_point(name: str, of_point: list[inspect.Parameter], no_point: str = "") -> str:
    """A sentence of the docstring with the signature of a function for points, or with what to give instead."""
    if no_point:
        return f"A point (`Oscillator.at`) is not accepted; {no_point}."
    first = inspect.Parameter("point", inspect.Parameter.POSITIONAL_OR_KEYWORD)
    shown = plain_signature([first, *of_point])
    return f"For a point (`Oscillator.at`): ``{name}{shown}``."


def with_forms(doc: str | None, forms: str) -> str:
    """A docstring with the further forms of call after the summary, in place of those that it has there."""
    parts = inspect.cleandoc(doc or "").split("\n\n")
    kept = parts[2:] if len(parts) > 1 and has_forms(parts[1]) else parts[1:]
    return "\n\n".join([parts[0], forms, *kept]) + "\n"


def has_forms(paragraph: str) -> bool:
    """Whether a paragraph of a docstring shows the further forms of call."""
    return paragraph.startswith(("For a ", "A point (`Oscillator.at`)"))


def plain_signature(parameters: list[inspect.Parameter]) -> inspect.Signature:
    """A signature without types."""
    return inspect.Signature(
        [item.replace(annotation=inspect.Parameter.empty) for item in parameters]
    )


def every_system(
    of_structure: Callable[..., Any], kind: type | None = None,
    of_law: Callable[[dict[str, Any]], None] | None = None, along: tuple[str, ...] = (), no_point: str = "",
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:  # fmt: skip
    """Decorate a function for oscillators so that calls with a structure go to `of_structure`.

    Parameters
    ----------
    of_structure : callable
        The function for structures.
    kind : type, optional
        The class of the first argument for which `of_structure` is called, if it is not `Structure`.
    of_law : callable, optional
        Oscillators whose restitution depends on the speed or whose load is a `Load`, and points with friction or
        stops, also go to `of_structure`. `of_law` converts the arguments, by name, to those of a point and those
        for structures. For such a point, the arguments also contain "point".
    along : tuple of str
        The parameter that the function varies, and others that a point makes superfluous. A point replaces the
        oscillator and the other arguments that it contains.
    no_point : str
        What to give instead of a point, for functions that do not accept points.
    """

    def decorate(of_oscillator: Callable[..., Any]) -> Callable[..., Any]:
        signature = inspect.signature(of_oscillator).parameters
        parameters, name = list(signature), of_oscillator.__name__
        of_point = [signature[key] for key in left_of_point(parameters, along)]
        forms = f"{usage(name, kind, of_structure)} {usage_of_point(name, of_point, no_point)}"
        of_oscillator.__doc__ = with_forms(of_oscillator.__doc__, forms)

        @functools.wraps(of_oscillator)
        def either(*args: Any, **kwargs: Any) -> Any:
            # most calls: all but the oscillator are numbers
            if (
                args
                and type(args[0]) is Oscillator
                and not args[0]._has_law
                and kwargs.keys() <= signature.keys()
                and all(type(value) in PLAIN for value in (*args[1:], *kwargs.values()))
            ):
                return of_oscillator(*args, **kwargs)
            given = dict(zip(["the first argument"], args, strict=False)) | kwargs
            if any(
                isinstance(x, kind or Structure) and getattr(x, "of_structure", True)
                for x in given.values()
            ):
                return called(args, kwargs)
            first = args[0] if args else kwargs.get(parameters[0])
            if kind and any(isinstance(x, Structure) for x in given.values()):
                raise ParameterTypeError(
                    f"motion = {first!r}: must be a vibroimpact.{kind.__name__}, not Structure"
                )
            for key, value in given.items():
                if isinstance(value, Point) and (value is not first or no_point):
                    wanted = no_point or "a point can only be the first argument"
                    if no_point and (value._has_elements or isinstance(value.amplitude, Load)):
                        # its osc lacks the friction, the stops or the load
                        wanted = (
                            "give a motion there, as exact(point, guess)"
                            if kind
                            else "give its structure and load"
                        )
                    raise ParameterTypeError(f"{key} = {value!r}: must not be a point; {wanted}")
            if isinstance(first, Point):
                kwargs = spread_out(name, parameters, first, args[1:], kwargs, along)
                args = ()
            if isinstance(first, Point) and first._has_elements:
                return handed_over(named(name, parameters, args, kwargs), first)
            if of_law and (
                getattr(args[0] if args else kwargs.get("osc"), "_has_law", False)
                or isinstance(kwargs.get("load"), Load)
            ):
                return handed_over(named(name, parameters, args, kwargs))
            for key in kwargs:
                if key not in signature:
                    others = inspect.signature(of_structure).parameters
                    note = ", which is for structures" if key in others else ""
                    raise TypeError(
                        f"{name}() got an unexpected keyword argument {key!r}{note}; "
                        f"for an oscillator the arguments are {', '.join(parameters)}"
                    )
            return of_oscillator(*args, **kwargs)

        def called(args: tuple[Any, ...], kwargs: dict[str, Any]) -> Any:
            """Call the function for structures; errors in the number and names of arguments show the public
            name."""
            own = inspect.signature(of_structure)
            try:
                own.bind(*args, **kwargs)
            except TypeError as error:
                raise TypeError(
                    f"{name}(): {error}; for a structure the arguments are {', '.join(own.parameters)}"
                ) from None
            return of_structure(*args, **kwargs)

        def handed_over(given: dict[str, Any], point: Point | None = None) -> Any:
            assert of_law
            if point:
                given["point"] = point
            of_law(given)
            given.pop("point", None)
            missing = [key for key in ("r", "clearance") if key not in given]
            if missing:
                raise TypeError(f"{name}(): missing a required argument: {missing[0]!r}")
            osc = given.pop("osc")
            of_point = {key: given.pop(key) for key in list(OF_POINT)[1:] if key in given}
            point = point or osc.at(**of_point)
            (_, _, *known) = inspect.signature(of_structure).parameters
            for key, value in list(given.items()):
                if key in known:
                    continue
                plain = value is None or isinstance(value, (bool, int, float, str))
                if plain and key in signature and value == signature[key].default:
                    del given[key]
                    continue
                raise ParameterTypeError(
                    f"{key} = {value!r}: must be left out if the oscillator is treated as a structure; further "
                    f"arguments are {', '.join(known)}"
                )
            return of_structure(point.structure, point.load, **given)

        either.takes_points = True  # type: ignore[attr-defined]
        either.along = along  # type: ignore[attr-defined]
        either.of_structure = of_structure  # type: ignore[attr-defined]
        return either

    return decorate


def named(
    verb: str, names: list[str], args: tuple[Any, ...], kwargs: Mapping[str, Any]
) -> dict[str, Any]:
    """All arguments of a call by name."""
    if len(args) > len(names):
        raise TypeError(
            f"{verb}(): {len(args)} arguments given by position; these are {', '.join(names)}"
        )
    found = dict(zip(names, args, strict=False))
    for key in found.keys() & kwargs.keys():
        raise TypeError(f"{verb}(): {key} is given twice, {found[key]!r} and {kwargs[key]!r}")
    return {**found, **kwargs}


def left_of_point(parameters: list[str], along: tuple[str, ...] = ()) -> list[str]:
    """The parameters of a function that a point does not provide; `along` is as in `every_system`."""
    provided = {*set(OF_POINT) - set(along[:1]), *along[1:]}
    return [key for key in parameters if key not in provided]


def spread_out(
    verb: str, parameters: list[str], point: Point, args: tuple[Any, ...], kwargs: Mapping[str, Any],
    along: tuple[str, ...] = (),
) -> dict[str, Any]:  # fmt: skip
    """The arguments of a call by name, where a point provides several; `along` is as in `every_system`."""
    names = left_of_point(parameters, along)
    of_point = {
        key: getattr(point, attribute)
        for key, attribute in OF_POINT.items() if key in parameters and key not in names
    }  # fmt: skip
    further = {key: value for key, value in kwargs.items() if value is not point}
    found = named(verb, names, args, further)
    of_point.pop(str(found.get("parameter")), None)
    for key in [*of_point, *along[1:]]:
        if key in found:
            raise ParameterTypeError(
                f"{key} = {found[key]!r}: must be left out; {point!r} gives it"
            )
    return of_point | found


def of_plain_point(
    verb: str, parameters: list[str], point: Point, args: tuple[Any, ...], kwargs: Mapping[str, Any]
) -> dict[str, Any]:
    """The arguments of a function that takes only an oscillator, from a point."""
    if not {"osc", "r", "clearance"} <= {*parameters}:
        raise ParameterTypeError(f"{parameters[0]} = {point!r}: must not be a point; give its osc")
    if (point._has_elements and "stops" not in parameters) or isinstance(point.amplitude, Load):
        raise ParameterTypeError(
            f"osc = {point!r}: must have rigid walls, no friction, and a number as its load"
        )
    if point.amplitude != 1 and "load" not in parameters:
        both = "clearance and friction" if point.friction else "clearance"
        raise ParameterTypeError(
            f"osc = {point!r}: must have the load amplitude 1, for which {verb} is defined; divide its {both} by "
            "the load"
        )
    return spread_out(verb, parameters, point, args, kwargs)


def factors_of(given: Mapping[str, Any], before: Mapping[str, Any]) -> dict[str, Any]:
    """Uncertain parameters, in which values of r, clearance and load that had a unit are factors of the nominal
    values.

    Raises
    ------
    ParameterError
        If there are several nominal values.
    """
    found = dict(given["uncertain"])
    for name in FACTORS:
        if not has_unit(before.get(name)):
            continue
        # a zone has no single frequency and clearance; the load of a zone or a pattern is F0
        nominal = np.asarray(given.get(name, 1.0 if name == "load" else ()), dtype=float)
        if nominal.size != 1:
            raise ParameterError(
                f"uncertain[{name!r}] = {before[name]!s}: must be factors of the nominal {name}, such as "
                f"(0.95, 1.05), where there are several"
            )
        factors = np.asarray(found[name], dtype=float) / nominal.item()
        found[name] = tuple(np.atleast_1d(factors).tolist())
    return found


def check_deviations(given: Mapping[str, Any], before: Mapping[str, Any]) -> None:
    """Raise an error for a tolerance, given in units, of a free parameter if its range does not include 0.

    Its dimensionless numbers might include 1, and would then be taken as factors.
    """
    free: Any = given.get("free") or {}
    for name, unit in PARAMETERS.items():
        value = before.get(name)
        if not unit or name not in free or not has_unit(value) or "%" in str(value):
            continue
        try:
            numbers = np.asarray(given["tolerance"][name], dtype=float)
        except (TypeError, ValueError):
            continue
        if numbers.size > 1 and not numbers.min() <= 0 <= numbers.max():
            raise ParameterError(
                f"tolerance[{name!r}] = {value!s}: must include 0, as deviations from the chosen value; "
                "factors of it, such as (0.95, 1.05), have no unit"
            )


def is_of_structure(value: Any) -> bool:
    """Whether a value is a structure, or a motion of one."""
    return isinstance(value, Structure) or bool(getattr(value, "of_structure", False))


def listed_names(names: Iterable[str]) -> str:
    """Names of arguments as in a docstring."""
    return ", ".join(f"`{name}`" for name in names)


def physical_arguments(function: Callable[Given, Found]) -> Callable[Given, Found]:
    """A decorator: frequencies, lengths and loads may have units if those of the oscillator are known."""
    signature = inspect.signature(function).parameters
    names = list(signature)
    takes_points = hasattr(function, "takes_points")
    of_structure: Mapping[str, inspect.Parameter] = {}
    if not takes_points and names[0] == "osc":
        of_point = [item for name, item in signature.items() if name not in OF_POINT]
        no_point = "" if {"r", "clearance"} <= {*names} else "give its osc"
        forms = usage_of_point(function.__name__, of_point, no_point)
        function.__doc__ = with_forms(function.__doc__, forms)
    known = {*PARAMETERS, *(START if "amplitude" in names else ())}
    if takes_points:
        of_structure = inspect.signature(function.of_structure).parameters  # type: ignore[attr-defined]
    in_cycles = set() if "duration" in of_structure else {"discard"}
    taken = {*known, *OF_STATES, *OF_PARAMETER, *BY_NAME, "plane", "discard"} - in_cycles
    taken_of_structure = {*taken, *AXES, *TIMES} - in_cycles
    places = [(i, name) for i, name in enumerate(names) if name in taken]
    # by keyword only
    late = [name for name in (*TIMES, "state") if name in of_structure and name not in names]
    places += [(len(signature) + len(of_structure), name) for name in late]
    defaults = {
        name: item.default for name, item in signature.items() if name in ("parameter", "target")
    }
    with_units = listed_names(name for name in names if name in taken - {*SHARES, *TIMES})
    # its load has a frequency with a unit
    more = listed_names(name for name in of_structure if name in taken_of_structure - {*PARAMETERS})
    if with_units:
        parts = inspect.cleandoc(function.__doc__ or "").split("\n\n")
        # after the summary and the further forms of call
        place = 2 if len(parts) > 1 and has_forms(parts[1]) else 1
        note = f"With units, such as {EXAMPLES}, for an oscillator with known M, K and F0: {with_units}"
        note += f"; for its structure (`Oscillator.structure`): {more}." if more else "."
        function.__doc__ = "\n\n".join([*parts[:place], note, *parts[place:]]) + "\n"

    @functools.wraps(function)
    def converted(*args: Given.args, **kwargs: Given.kwargs) -> Found:
        if not takes_points and args and isinstance(args[0], Point):
            spread = of_plain_point(function.__name__, names, args[0], args[1:], kwargs)
            return converted(**spread)  # type: ignore[call-arg]
        order, where = names, places
        if args and isinstance(args[0], Point):  # which replaces several arguments
            order = [names[0], *left_of_point(names[1:], getattr(function, "along", ()))]
            where = [(i, name) for i, name in enumerate(order) if name in taken]
            where += places[len([name for name in names if name in taken]) :]
        elif takes_points and is_of_structure(
            args[0] if args else kwargs.get(next(iter(of_structure)))
        ):
            order = list(of_structure)
            where = [(i, name) for i, name in enumerate(order) if name in taken_of_structure]
        for i, name in where:  # most calls have numbers
            value = args[i] if i < len(args) else kwargs.get(name)
            if type(value) not in PLAIN and has_unit(value):
                break
        else:
            return function(*args, **kwargs)
        given: dict[str, Any] = dict(zip(order, args, strict=False)) | kwargs
        physical = [name for _, name in where if has_unit(given.get(name))]
        if "discard" in physical and given.get("cycles") is not None:
            physical.remove("discard")  # in load cycles
        first: Any = given.get(order[0])
        osc = first if isinstance(first, Oscillator) else getattr(first, "osc", None)
        of_itself = isinstance(first, Structure)
        structure = first if of_itself else getattr(first, "structure", None)
        units = getattr(structure, "_units", None)
        if units is not None and not isinstance(osc, Oscillator):
            osc = OfStructure(units)
            physical = [name for name in physical if of_itself or name in (*OF_PARAMETER, *AXES)]
        if not isinstance(osc, (Oscillator, OfStructure)):
            return function(*args, **kwargs)
        if "r" not in physical:
            refuse_hertz(osc, given.get("r"))
        before = {name: given[name] for name in physical}
        if given.get("parameter") == "load" and isinstance(getattr(first, "amplitude", 0), Load):
            for name in physical:
                if name in OF_PARAMETER:
                    raise ParameterError(
                        f"{name} = {given[name]!s}: must be numbers, factors of the `Load` of the point"
                    )
        chosen = defaults | {name: given[name] for name in ("parameter", "target") if name in given}
        if of_itself:  # a response is along the frequency
            chosen = {"parameter": "frequency"} | chosen
        for name in physical:
            of = str(chosen.get("parameter", chosen.get("target")))
            given[name] = dimensionless(osc, name, given[name], of)
        used = [(before[name], given[name]) for name in physical]
        if "tolerance" in physical:
            check_deviations(given, before["tolerance"])
        if "uncertain" in physical:
            given["uncertain"] = factors_of(given, before["uncertain"])
        own = [given[name] for name in order[: len(args)]]
        rest: Any = {name: given[name] for name in kwargs}
        with shown_as_given(used, osc):
            return function(*own, *args[len(own) :], **rest)  # type: ignore[arg-type]

    return converted
