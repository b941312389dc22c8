"""Run work in a child process, which may crash and is killed if one call takes too long."""

import os
import pickle
import resource
import select
import signal
import tempfile
import time
import traceback
import warnings

#: CPU seconds after which a call is interrupted, CPU seconds that it then has to end, and seconds after which an
#: idle child counts as hanging.
PATIENCE, GRACE, LIMIT = 0.5, 20, 600
#: Bytes of memory that it may use.
ROOM = 8 << 30


def in_child(report, what, name, work):
    """Calls `work(begin)` in a child, and reports what it returns.

    It calls `begin` with a text before each attempt, and returns the numbers of those refused and accepted, and
    {kind: (input, ending of its file)} of those that went wrong.
    """
    ends = os.pipe()
    with tempfile.NamedTemporaryFile() as begun:
        child = os.fork()
        if child == 0:
            os.close(ends[0])
            run(work, begun.name, ends[1])
        os.close(ends[1])
        with os.fdopen(ends[0], "rb") as source:
            watch(child, begun.name, source)
            answer = source.read()
        _, status = os.waitpid(child, 0)
        last = begun.read()
    if status != 0 or not answer:
        report.find(what, f"{name} ends the process, status {status}", last, ".txt")
        return
    refused, accepted, faults = pickle.loads(answer)
    for kind, (data, suffix) in faults.items():
        report.find(what, f"{name}: {kind}", data, suffix)
    report.count(what, refused, accepted)


def run(work, begun, to):
    """Run the work in the child: in an empty folder, without input or output, with little memory."""

    def begin(text):
        with open(begun, "w", encoding="utf-8", errors="replace") as file:
            file.write(text)

    status = 1
    try:
        # a thread of a call that was interrupted may still write into the folder
        with (
            tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder,
            os.fdopen(to, "wb") as answer,
        ):
            os.chdir(folder)
            null = os.open(os.devnull, os.O_RDWR)
            for number in (0, 1, 2):
                os.dup2(null, number)
            resource.setrlimit(resource.RLIMIT_AS, (ROOM, ROOM))
            warnings.simplefilter("ignore")
            signal.signal(signal.SIGPROF, stop)
            signal.signal(signal.SIGALRM, stop)
            pickle.dump(work(begin), answer)
        status = 0
    except BaseException as error:
        begin("".join(traceback.format_exception(error)))
    finally:
        os._exit(status)


def watch(child, begun, source):
    """Wait until a child has an answer; kill it if one call takes longer than the limit."""
    while not select.select([source], [], [], 5)[0]:
        if time.time() > os.stat(begun).st_mtime + LIMIT:
            os.kill(child, signal.SIGKILL)
            return


def limited(call, seconds=PATIENCE):
    """The exception that ends a call, None for an answer; the call is interrupted after seconds of CPU time.

    On a busy machine the clock runs, but not the call: what only waits has twenty times as long.
    """
    try:
        try:
            signal.setitimer(signal.ITIMER_PROF, seconds, GRACE)
            signal.setitimer(signal.ITIMER_REAL, 20 * seconds, 20 * GRACE)
            call()
        finally:
            for clock in (signal.ITIMER_PROF, signal.ITIMER_REAL):
                signal.setitimer(clock, 0)
    except (Exception, KeyboardInterrupt) as error:
        # the interrupt may have arrived before these lines
        for clock in (signal.ITIMER_PROF, signal.ITIMER_REAL):
            signal.setitimer(clock, 0)
        return error
    return None


def stop(_, frame):
    """As Ctrl-C; but an import goes on, since half a module would break all that follows."""
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            signal.setitimer(signal.ITIMER_REAL, PATIENCE, GRACE)
            return
        frame = frame.f_back
    raise KeyboardInterrupt


def where(error):
    """The exception and the line of the package that raised it."""
    frames = [
        frame
        for frame in traceback.extract_tb(error.__traceback__)
        if "vibroimpact" in frame.filename
    ]
    place = f"{os.path.basename(frames[-1].filename)}:{frames[-1].lineno}" if frames else "the call"
    return f"{type(error).__name__} at {place}: {str(error)[:150]!r}"
