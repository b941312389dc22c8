"""The case of a result as a namelist: what `vibroimpact run` and `vibroimpact-batch` take."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import ParameterError
from ..model import Oscillator

if TYPE_CHECKING:
    from ..motion import Motion

#: Namelist groups with their keys; those with the value None are left out.
Groups = Mapping[str, Mapping[str, Any]]
#: How namelists spell which motions are meant.
SYMMETRIC = {True: "yes", False: "no", None: "both"}
#: Largest residual of a consistent motion, if &motion names no other.
ACCEPTANCE = 0.03


def text(groups: Groups) -> str:
    """Groups as a namelist; numbers have all their digits."""
    lines = []
    for group, keys in groups.items():
        lines += [
            f"&{group}",
            *(f"  {key} = {_value(x)}" for key, x in keys.items() if x is not None),
            "/",
        ]
    return "\n".join(lines) + "\n"


def case(osc: Oscillator, r: float | None = None, **groups: Mapping[str, Any]) -> str:
    """A system with what is asked of it."""
    walls = list(osc.restitution)
    return text({"system": {"xi": osc.xi, "mu": osc.mu, "restitution": walls, "r": r}, **groups})


def window(r: tuple[float, float], clearance: tuple[float, float]) -> dict[str, float]:
    """The keys of a window."""
    return {
        "r_min": r[0], "r_max": r[1], "clearance_min": clearance[0], "clearance_max": clearance[1],
    }  # fmt: skip


def of_motion(motion: Motion) -> dict[str, Any]:
    """The group &motion that gives a motion."""
    if motion.pattern.has_rest or motion.load != 1.0:
        what = "rest" if motion.pattern.has_rest else f"load = {motion.load!r}"
        raise ParameterError(f"motion with {what}: has no namelist; a &simulate comes to it")
    keys: dict[str, Any] = {"kind": motion.kind, "cycles": motion.pattern.cycles}
    right, left = motion.osc.restitution
    own = not np.array_equal(motion.restitution, np.where(motion.pattern.signs > 0, right, left))
    if motion.kind == "equispaced":
        return keys | {"clearance": motion.clearance, "precision": motion.precision}
    phases = motion.phases if motion.guess is None else motion.guess
    keys |= {"sides": motion.pattern.sides, "phases": phases.tolist()}
    if own:
        keys["impact_restitution"] = motion.restitution.tolist()
    if motion.kind == "exact":
        keys["clearance"] = motion.clearance
        if motion.guess is None:
            keys |= {"positions": motion.X.tolist(), "tau": motion.tau}
        return keys
    if motion.consistent != (motion.residual <= ACCEPTANCE):
        # the acceptance was another one, just enough or just not
        limit = motion.residual if motion.consistent else np.nextafter(motion.residual, 0.0)
        keys["acceptance"] = float(min(1.0, limit))
    return keys | {"precision": motion.precision}


def _value(value: Any) -> str:
    if isinstance(value, str):
        return "'" + value.replace("'", "''").replace("\n", " ") + "'"
    return ", ".join(map(repr, value)) if isinstance(value, (list, tuple)) else repr(value)


def keys_of(text: str) -> dict[str, Any]:
    """The keys of a case that the core completed, one `key = value` a line, and its kind."""
    keys: dict[str, Any] = {}
    for line in text.split("\n"):
        name, equals, value = line.strip().partition(" = ")
        if name == "&branch":
            keys |= {"motion_kind": keys["kind"], "kind": "branch"}
        elif line[:1] == "&" and name not in ("&system", "&output"):
            keys.setdefault("kind", name[1:])
        elif equals:
            keys[name] = _read(value)
    return keys


def _read(text: str) -> Any:
    """A text, a number, or a list of texts or numbers."""
    if text.startswith("'"):
        words = text[1:-1].split("', '")
        return words if len(words) > 1 else words[0]
    numbers = [float(item) if "." in item else int(item) for item in text.split(", ")]
    return numbers if len(numbers) > 1 else numbers[0]
