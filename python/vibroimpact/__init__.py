"""Vibrating systems with impacts: periodic motions and their stability, simulation, identification and design.

The public names are listed in `__init__.pyi`, which type checkers also read.
"""

import re as _re
from collections.abc import Callable as _Callable
from importlib import import_module as _import_module
from pathlib import Path as _Path

from .base import errors as errors
from .base.actions import ACTIONS as _ACTIONS

#: The module of each public name, from lines `from .module import (name, ...)`.
_PLACES = {
    name: module
    for module, names in _re.findall(
        r"(?m)^from ([\w.]+) import (\([^)]*\)|[^(\n]*)$",
        _Path(__file__).with_suffix(".pyi").read_text("utf-8"),
    )
    for name in _re.findall(r"\w+", names)
}
__all__ = sorted(_PLACES)


def _later(place: str) -> _Callable[..., object]:
    """Return a function of a module that is imported when the function is called for the first time."""
    module, name = place.split(":")
    return lambda *arguments, **named: getattr(_import_module(module, __name__), name)(
        *arguments, **named
    )


def _import_all() -> None:
    """Import every public name."""
    for name in __all__:
        globals()[name] = __getattr__(name)


_ACTIONS.update(
    motion_gradient=_later(".derivatives.period_gradient:oscillator_gradient"),
    trajectory_gradient=_later(".derivatives.gradient:trajectory_gradient"),
    structure_motion_gradient=_later(".derivatives.carried:motion_gradient"),
    structure_trajectory_gradient=_later(".derivatives.carried:trajectory_gradient"),
    prove_motion=_later(".proofs.prove:prove_motion"),
    prove_branch=_later(".proofs.prove:prove_branch"),
    prove_zone=_later(".proofs.zones:prove_zone"),
    plane_of=_later(".proofs.zones:Plane"),
    draw=_later(".plot.pictures:draw_result"),
    animate_result=_later(".plot.pictures:animate_result"),
    thumbnail=_later(".plot.thumbnail:thumbnail"),
    report=_later(".plot.design:report"),
    html=_later(".formats.html:html"),
    to_dict=_later(".formats.record:to_dict"),
    from_dict=_later(".formats.record:from_dict"),
    to_json=_later(".formats.record:to_json"),
    from_json=_later(".formats.record:from_json"),
    to_xarray=_later(".formats.dataset:to_xarray"),
    to_pandas=_later(".formats.rows:to_pandas"),
    save=_later(".formats.save:save"),
    load=_later(".formats.load:load"),
    physical=_later(".physical_results:physical"),
    import_all=_import_all,
)


def __getattr__(name: str) -> object:
    """Import a public name from its module when it is first used."""
    if name == "__version__":
        from importlib.metadata import version

        found: object = version("vibroimpact")
    elif name in _PLACES:
        found = getattr(_import_module(_PLACES[name], __name__), name)
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    """The public names, without the modules that hold them."""
    return sorted([*__all__, "__version__"])
