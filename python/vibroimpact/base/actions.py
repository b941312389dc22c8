"""Functions on results that other modules provide: files, pictures, physical units, derivatives.

The package registers them when it is imported, so that `results` does not depend on these modules.
"""

from collections.abc import Callable
from typing import Any

ACTIONS: dict[str, Callable[..., Any]] = {}
