"""Where the commands begin: a module beside the package, so that nothing heavy comes before Ctrl-C is heard."""

import os
import signal
import subprocess
import sys
from pathlib import Path
from types import FrameType

INTERRUPTED = "vibroimpact: interrupted; nothing was finished"


def main() -> int:
    """Run `vibroimpact`; returns the exit status."""
    try:
        heard = signal.getsignal(signal.SIGINT)
        # not where a shell has it ignored, in the background
        if heard is signal.default_int_handler:
            signal.signal(signal.SIGINT, stop)
        from vibroimpact.commands.command import main as run

        signal.signal(signal.SIGINT, heard)
        return run()
    except KeyboardInterrupt:  # before the work, or for the second time
        print(INTERRUPTED, file=sys.stderr)
        return 1


def stop(_signal: int, _frame: FrameType | None) -> None:
    """End at once: an exception within the import of a compiled module may come out as another one."""
    os.write(2, f"{INTERRUPTED}\n".encode())
    os._exit(1)


def batch() -> int:
    """Start the stand-alone program that lies inside the package, which is not imported if it lies here."""
    program = Path(__file__).with_name("vibroimpact") / "_bin" / "vibroimpact-batch"
    if not program.exists():  # an editable install
        from importlib.resources import as_file, files

        with as_file(files("vibroimpact") / "_bin" / "vibroimpact-batch") as found:
            program = Path(found)
    if os.name == "posix":  # the program takes the place of the launcher, signals and all
        os.execv(program, [str(program), *sys.argv[1:]])
    return subprocess.call([str(program), *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
