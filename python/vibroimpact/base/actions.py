"""What is done with results elsewhere: files, pictures, physical units, derivatives.

The package registers these functions when it is imported, so that results depend on none of their modules.
"""

from collections.abc import Callable
from typing import Any

ACTIONS: dict[str, Callable[..., Any]] = {}
