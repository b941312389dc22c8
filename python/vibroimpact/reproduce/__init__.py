"""The tables and figures of Popplewell, Bapat and McLachlan (1983), computed and compared."""

from __future__ import annotations

from collections.abc import Iterable
from importlib import import_module
from pathlib import Path

from ..errors import ParameterError

#: What can be recomputed; each is a module here with a function `reproduce(folder) -> bool`.
NAMES = ("table1", "figure9")


def reproduce(names: Iterable[str], folder: str | Path) -> int:
    """Recompute the named items (all, if none is named) and write them to a folder.

    Returns
    -------
    int
        0 if everything agrees with the paper or is explained, 1 if something differs.
    """
    wanted = list(names) or list(NAMES)
    for name in wanted:
        if name not in NAMES:
            raise ParameterError(f"NAME = {name!r}: must be one of {', '.join(NAMES)}")
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    agree = [import_module(f".{name}", __name__).reproduce(folder) for name in wanted]
    return 0 if all(agree) else 1
