"""What is said of the result of a case, as the compiled program says it."""

from __future__ import annotations

import os
import sys

from ..run import RunLog


def tell(log: RunLog) -> None:
    """Print what was said while namelist files ran, faults to standard error."""
    for fault, line in log.lines:
        stream = sys.stderr if fault else sys.stdout
        # a path need not be text: its bytes are printed as they are
        buffer = getattr(stream, "buffer", None)
        if buffer is None:
            print(line, file=stream)
        else:
            stream.flush()
            buffer.write(os.fsencode(line + "\n"))
            buffer.flush()
