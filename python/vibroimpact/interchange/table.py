"""Results as tables: the columns that `vibroimpact run` writes, for CSV and pandas."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import MissingExtraError, ParameterError

if TYPE_CHECKING:
    from ..motion import Motion
    from ..trajectory import Trajectory

#: Names of columns with the values of all rows.
Columns = dict[str, list[Any]]


def columns(result: Any) -> Columns:
    """The table of a result: one row an impact, event, point or vertex."""
    name = type(result).__name__
    if name not in TABLES:
        raise ParameterError(f"{result!r}: is no table; must be one of {', '.join(TABLES)}")
    table: Columns = TABLES[name](result)
    return table


def to_pandas(result: Any) -> Any:
    """The table as a DataFrame."""
    try:
        import pandas
    except ImportError:
        raise MissingExtraError(
            "data frames need pandas: pip install 'vibroimpact[data]'"
        ) from None
    return pandas.DataFrame(columns(result))


def motion_columns(motion: Motion, number: int = 1) -> Columns:
    """One row an impact; what all impacts share is repeated."""
    n = len(motion.pattern)
    table: Columns = {
        "motion": [number] * n,
        "impact": list(range(1, n + 1)),
        "side": motion.pattern.symbols,
    }
    own = ("X", "Z", "X_dot_before", "X_dot_after", "Z_dot_before", "Z_dot_after")
    table |= {"restitution": motion.restitution.tolist(), "phase": motion.phases.tolist()}
    table |= {name: getattr(motion, name).tolist() for name in own}
    shared = (
        "r",
        "clearance",
        "A",
        "tau",
        "residual",
        "consistent",
        "admissible",
        "stable",
        "x_min",
        "x_max",
    )
    table |= {name: [getattr(motion, name)] * n for name in shared}
    table["attenuation"] = [motion.attenuation if motion.A > 0 else np.nan] * n
    for i, value in enumerate(motion.multipliers.tolist(), start=1):
        table |= {f"multiplier_{i}_re": [value.real] * n, f"multiplier_{i}_im": [value.imag] * n}
    return table


def event_columns(run: Trajectory) -> Columns:
    """One row an event."""
    return {name: run.events[name].tolist() for name in run.events.dtype.names or ()}


def numbered(results: Sequence[Any], own: Callable[[Any, int], Columns]) -> Columns:
    """The rows of several results, one after the other."""
    table: Columns = {}
    for number, result in enumerate(results, start=1):
        for name, values in own(result, number).items():
            table.setdefault(name, []).extend(values)
    return table


TABLES: dict[str, Any] = {
    "Motion": motion_columns, "Trajectory": event_columns,
}  # fmt: skip
