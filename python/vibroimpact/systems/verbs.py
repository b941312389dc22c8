"""Verbs for every system: an oscillator, a structure with its load, or an oscillator at a point."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import Any

from ..base.errors import ParameterTypeError
from .oscillator import Point
from .structure import Structure

#: The attributes of a point, by the names of arguments.
OF_POINT = {"osc": "osc", "r": "r", "clearance": "clearance", "load": "amplitude"}


def every_system(
    of_structure: Callable[..., Any], kind: type | None = None,
    of_law: Callable[[dict[str, Any]], None] | None = None, along: str = "",
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:  # fmt: skip
    """A decorator: a procedure for oscillators, which hands structures, or objects of a class of theirs, over.

    A point stands for the oscillator and the arguments that it has, except `along`, which the procedure varies.
    With `of_law` oscillators whose restitution depends on the speed are handed over, too: it turns further
    arguments, by name, into those for structures.
    """

    def decorate(of_oscillator: Callable[..., Any]) -> Callable[..., Any]:
        parameters = list(inspect.signature(of_oscillator).parameters)

        @functools.wraps(of_oscillator)
        def either(*args: Any, **kwargs: Any) -> Any:
            given = (*args[:1], *kwargs.values())
            if any(isinstance(x, kind or Structure) for x in given):
                return of_structure(*args, **kwargs)
            if kind and any(isinstance(x, Structure) for x in given):
                raise ParameterTypeError(
                    f"motion = {given[0]!r}: must be a vibroimpact.{kind.__name__}, not Structure"
                )
            if any(isinstance(x, Point) for x in given):
                kwargs = spread_out(args, kwargs)
                args = ()
            if of_law and getattr(args[0] if args else kwargs.get("osc"), "_has_law", False):
                names = dict(zip(parameters, args, strict=False))
                return handed_over(names | kwargs)
            return of_oscillator(*args, **kwargs)

        def spread_out(args: tuple[Any, ...], kwargs: dict[str, Any]) -> dict[str, Any]:
            """The arguments by name, of which a point, the first one, gives several."""
            point = kwargs.pop("osc", None) if not args else args[0]
            if not isinstance(point, Point):
                raise ParameterTypeError(
                    f"{point!r}: must be the oscillator; a point is the first argument"
                )
            of_point = {
                name: getattr(point, key)
                for name, key in OF_POINT.items() if name in parameters and name != along
            }  # fmt: skip
            free = [name for name in parameters if name not in of_point]
            named = dict(zip(free, args[1:], strict=False))
            varied = named.get("parameter", kwargs.get("parameter"))
            of_point.pop(str(varied), None)
            for name in kwargs:
                if name in of_point or name in named:
                    raise ParameterTypeError(f"{name} = {kwargs[name]!r}: is given by {point!r}")
            return of_point | named | kwargs

        def handed_over(given: dict[str, Any]) -> Any:
            osc = given.pop("osc")
            point = osc.at(**{name: given.pop(name) for name in OF_POINT if name in given})
            assert of_law
            of_law(given)
            (_, _, *known) = inspect.signature(of_structure).parameters
            for name, value in given.items():
                if name not in known:
                    raise ParameterTypeError(
                        f"{name} = {value!r}: must be left out where restitution depends on the speed; further "
                        f"arguments are {', '.join(known)}"
                    )
            return of_structure(point.structure, point.load, **given)

        return either

    return decorate
