"""Run a command when no other that is started so is running: builds in one folder take turns.

    python packaging/in_turn.py LOCK COMMAND...

What the command starts in this way belongs to it, and does not wait. Who has to wait is told on the
terminal, if there is one: this is called where standard error is a log.
"""

import contextlib
import fcntl
import os
import sys


def main(lock, *command):
    """Take the lock, which ends with the command and all that it starts."""
    if os.environ.get("VIBROIMPACT_TURN") != lock:
        held = os.open(lock, os.O_CREAT | os.O_RDWR, 0o666)
        os.set_inheritable(held, True)
        try:
            fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            with contextlib.suppress(OSError), open("/dev/tty", "w", encoding="utf-8") as terminal:
                print("vibroimpact is being built: waiting for it", file=terminal)
            fcntl.flock(held, fcntl.LOCK_EX)
        os.environ["VIBROIMPACT_TURN"] = lock
    os.execvp(command[0], command)


if __name__ == "__main__":
    main(*sys.argv[1:])
