"""The C library as called by the tools in this folder."""

import ctypes
import json
import threading
import time

import numpy as np
from shared_answers import STOPPED, read

#: The number of blocks that reached.c can count.
BLOCKS = 1 << 24


class Library:
    """A C library."""

    def __init__(self, path):
        self.c = ctypes.CDLL(str(path))
        self.c.vibroimpact_text.restype = ctypes.c_size_t
        self.progress = [0, 0]

    def text(self, handle, what):
        """Return a text of a result."""
        n = self.c.vibroimpact_text(handle, what, None, ctypes.c_size_t(0))
        out = ctypes.create_string_buffer(n + 1)
        self.c.vibroimpact_text(handle, what, out, ctypes.c_size_t(n + 1))
        return out.value.decode(errors="surrogateescape")

    def cases(self, text):
        """Return the cases of a text, each as a separate text; none if it is refused."""
        handle = ctypes.c_int64()
        self.c.vibroimpact_cases(text.encode(), ctypes.byref(handle))
        about = json.loads(self.text(handle, 7))
        self.c.vibroimpact_free(handle)
        return next(
            (item["words"] for item in about.get("columns", ()) if item["name"] == "text"), []
        )

    def message(self, text):
        """Return why a text is refused."""
        handle = ctypes.c_int64()
        self.c.vibroimpact_cases(text.encode(), ctypes.byref(handle))
        return self.text(handle, 0)

    def run(self, text, seconds=None):
        """(answer, CPU seconds); the answer is None for a case that exceeded its time limit.

        `progress` is then the progress that the case reported: units of work done and expected.
        """
        handle, counters = ctypes.c_int64(), (ctypes.c_int32 * 3)()
        counters[2] = meant = text.startswith(STOPPED)
        clock = threading.Timer(seconds, counters.__setitem__, (2, 1)) if seconds else None
        if clock:
            clock.start()
        begin = time.thread_time()
        status = self.c.vibroimpact_run(text.encode(), 1, counters, ctypes.byref(handle))
        took = time.thread_time() - begin
        if clock:
            clock.cancel()
        self.progress = list(counters[:2])
        late = (counters[2] or status not in (0, 1, 2)) and not meant
        found = None if late else read(self, status, self.text(handle, 7))
        self.c.vibroimpact_free(handle)
        return None if found is None else json.loads(json.dumps(found)), took

    def choose(self, mutant):
        """Select the mutant that a library of switched.py runs; 0 selects the original code."""
        ctypes.c_int.in_dll(self.c, "vibroimpact_mutant").value = mutant


class Counted(Library):
    """A library that counts the blocks that it reaches (reached.c)."""

    def __init__(self, path):
        super().__init__(path)
        with open("/proc/self/maps", encoding="ascii") as maps:
            lines = [line for line in maps if str(path) in line]
        self.first = ctypes.c_void_p(min(int(line.split("-")[0], 16) for line in lines))
        counts = (ctypes.c_uint32 * BLOCKS).in_dll(self.c, "reached")
        self.counts = np.ctypeslib.as_array(counts)

    def reach(self, text, seconds=None):
        """(answer, CPU seconds, places of the blocks that were reached)."""
        self.c.count_from(self.first)
        found, took = self.run(text, seconds)
        return found, took, np.flatnonzero(self.counts).tolist()
