"""Finds small cases that together reach what the core can do, and keeps what it answers.

usage: find_answers.py --search COUNTED [--texts N] [--seed N] [--also LIBRARY...]
       find_answers.py --renew [--also LIBRARY...]
       find_answers.py --compare LIBRARY...

--search  COUNTED is a library for C that counts the blocks it reaches (reached.c tells how it is built). The kept
          texts, and namelists of inputs/ and of tests/fuzz/seeds, are changed at random; the fewest that reach
          each block, as often as any of them does, are kept.
--renew   writes the answers to the kept texts again, and prints what changed.
--compare prints what other builds answer differently, but for rounding: the exit status is 1 if anything.

An answer is kept as far as the package and all libraries named (another compiler, another LAPACK) agree.
"""

import argparse
import ctypes
import json
import os
import random
import sys
import tempfile
import threading
import time
from collections import Counter
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests" / part) for part in ("python", "fuzz")]

from language import Language, parse, write  # noqa: E402
from shared_answers import KEPT, answer, differences, load, merged, put_files, read  # noqa: E402
from vibroimpact.tables import language  # noqa: E402

#: CPU seconds that a kept case may take in the counting library.
LONGEST = 2.0
BLOCKS = 1 << 24


class Library:
    """A library for C."""

    def __init__(self, path):
        self.c = ctypes.CDLL(str(path))
        self.c.vibroimpact_text.restype = ctypes.c_size_t

    def text(self, handle, what):
        """A text of a result."""
        n = self.c.vibroimpact_text(handle, what, None, ctypes.c_size_t(0))
        out = ctypes.create_string_buffer(n + 1)
        self.c.vibroimpact_text(handle, what, out, ctypes.c_size_t(n + 1))
        return out.value.decode(errors="surrogateescape")

    def cases(self, text):
        """The cases of a text, each as a text of its own; none if it is refused."""
        handle = ctypes.c_int64()
        self.c.vibroimpact_cases(text.encode(), ctypes.byref(handle))
        about = json.loads(self.text(handle, 7))
        self.c.vibroimpact_free(handle)
        return next(
            (item["words"] for item in about.get("columns", ()) if item["name"] == "text"), []
        )

    def message(self, text):
        """Why a text is refused."""
        handle = ctypes.c_int64()
        self.c.vibroimpact_cases(text.encode(), ctypes.byref(handle))
        return self.text(handle, 0)

    def run(self, text, seconds=20.0):
        """(answer, CPU seconds); the answer is None for a case that took longer."""
        handle, counters = ctypes.c_int64(), (ctypes.c_int32 * 3)()
        clock = threading.Timer(seconds, counters.__setitem__, (2, 1))
        clock.start()
        begin = time.thread_time()
        status = self.c.vibroimpact_run(text.encode(), 1, counters, ctypes.byref(handle))
        took = time.thread_time() - begin
        clock.cancel()
        stopped = counters[2] or status not in (0, 1, 2)
        found = None if stopped else read(self, status, self.text(handle, 7))
        self.c.vibroimpact_free(handle)
        return found, took


class Counted(Library):
    """The library that counts."""

    def __init__(self, path):
        super().__init__(path)
        with open("/proc/self/maps", encoding="ascii") as maps:
            lines = [line for line in maps if "libvibroimpact.so" in line]
        self.first = ctypes.c_void_p(min(int(line.split("-")[0], 16) for line in lines))
        self.forget = self.c.count_from
        counts = (ctypes.c_uint32 * BLOCKS).in_dll(self.c, "reached")
        self.counts = np.ctypeslib.as_array(counts)

    def reach(self, text):
        """(answer, CPU seconds, what was reached: blocks, and powers of eight of how often)."""
        self.forget(self.first)
        found, took = self.run(text, LONGEST)
        places = np.flatnonzero(self.counts)
        if found is None or found["status"] == 2:
            return found, took, set(places.tolist())
        often = np.log2(self.counts[places]).astype(int) // 3
        return found, took, {
            place + BLOCKS * power for place, most in zip(places.tolist(), often.tolist(), strict=True)
            for power in range(min(most, 3) + 1)
        }  # fmt: skip


def sources(library):
    """Complete namelists of one case each."""
    folders = (ROOT / "inputs", ROOT / "tests/fuzz/seeds", ROOT / "tests/quality")
    for path in (path for folder in folders for path in sorted(folder.glob("*.nml"))):
        text = path.read_text(encoding="utf-8", errors="replace")
        found = library.cases(text)
        if path.parent == folders[-1] and len(found) < 70:
            sys.exit(f"find_answers: {library.message(text)}")
        yield from found or [text]


def change(tongue, rng, groups):
    """A text made from groups: changed in its values mostly, sometimes in its form."""
    groups = [(name, list(items)) for name, items in groups]
    kind = rng.random()
    if kind < 0.25:
        tongue.mutate(rng, groups)
    else:
        for _ in range(rng.choice((1, 1, 2, 3))):
            name, items = rng.choice(groups)
            table = tongue.keys(name, groups)
            if not table:
                continue
            about = rng.choice(table)
            place = next((i for i, (key, _) in enumerate(items) if key == about["name"]), None)
            if about["kind"] != "word" and place is not None and rng.random() < 0.6:
                value = nearby(rng, items[place][1], about)
            else:
                value = tongue.value(rng, about)
            if place is None:
                items.append((about["name"], value))
            else:
                items[place] = (about["name"], value)
    text = write(groups)
    if kind > 0.97:
        text = tongue.restyle(rng, text)
    elif kind > 0.95:
        text = tongue.damage(rng, text.encode()).decode(errors="replace").replace("\0", "?")
    return text


def nearby(rng, value, about):
    """Numbers of the same size as before."""
    new = []
    for word in value.split(","):
        try:
            x = float(word) * rng.choice((0.5, 0.9, 0.99, 1.01, 1.1, 1.5, 2.0))
            new.append(str(round(x)) if about["kind"] == "whole" else f"{x:.6g}")
        except (ValueError, OverflowError):
            return value
    return ", ".join(new)


def main():
    """Do what is asked for."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--search", type=Path, metavar="COUNTED")
    what.add_argument("--renew", action="store_true")
    what.add_argument("--compare", type=Path, nargs="+", metavar="LIBRARY")
    parser.add_argument("--texts", type=int, default=10_000, help="texts that are tried (10000)")
    parser.add_argument("--seed", type=int, default=1, help="of the texts (1)")
    parser.add_argument("--times", type=int, default=3, help="kept cases that reach a block (3)")
    parser.add_argument("--also", type=Path, nargs="*", default=[], metavar="LIBRARY")
    asked = parser.parse_args()
    others = [path.resolve() for path in asked.also or asked.compare or ()]
    counted = Counted(asked.search.resolve()) if asked.search else None
    with tempfile.TemporaryDirectory() as folder:
        put_files(Path(folder))
        os.chdir(folder)
        others = [Library(path) for path in others]
        kept = load() if KEPT.exists() else []
        if asked.compare:
            return compare(kept, others)
        if asked.renew:
            return keep([item["text"] for item in kept], others, kept)
        found = search(counted, [item["text"] for item in kept], asked.texts, asked.seed)
        few = fewest(found, asked.times)
        keep(few, [], kept)
        # another library may break down
        return keep(few, others, load())


def compare(kept, others):
    """Print what differs in other libraries; return the exit status."""
    different = 0
    for item in kept:
        for other in others:
            found, _ = other.run(item["text"])
            for name in differences(item["answer"], json.loads(json.dumps(found or {}))):
                different += 1
                print(f"{name} differs:\n{item['text']}")
    print(f"{len(kept)} answers of {len(others)} other builds, {different} differences")
    return int(different > 0)


def search(counted, kept, count, seed):
    """Texts that reach something new: (text, CPU seconds, what it reaches)."""
    rng, tongue, seen, found = random.Random(seed), Language(language()), set(), []
    first = [*kept, *sources(counted)]
    pool = [groups for groups in map(parse, first) if groups]
    for number in range(len(first) + count):
        text = first[number] if number < len(first) else change(tongue, rng, rng.choice(pool))
        answered, took, reached = counted.reach(text)
        if number % 500 == 0:
            print(
                f"{number} texts, {len(found)} found, {len(seen)} reached",
                file=sys.stderr,
                flush=True,
            )
        if answered is None or len(json.dumps(answered)) > 6000 or len(text) > 3000:
            continue
        # some that reach nothing new are kept, too: more than one case is to reach a block
        if not reached <= seen or (answered["status"] != 2 and rng.random() < 0.1):
            seen |= reached
            found.append((text, took, reached))
            pool += [groups for groups in (parse(text),) if groups]
    return found


def fewest(found, times):
    """Few texts that reach all, each block by so many of them: the one that adds most for its time is next."""
    left = Counter()
    for _, _, reached in found:
        left.update(reached)
    left = {place: min(times, number) for place, number in left.items()}
    chosen, rest = [], [(text, 0.005 + took, reached) for text, took, reached in found]
    gain = [len(reached) / took for _, took, reached in rest]
    while rest:
        # a gain only falls: what still leads with its new gain is the best
        best = max(range(len(rest)), key=gain.__getitem__)
        text, took, reached = rest[best]
        new = sum(place in left for place in reached) / took
        if new < gain[best]:
            gain[best] = new
            continue
        del rest[best], gain[best]
        if new == 0:
            break
        chosen.append(text)
        for place in reached & left.keys():
            left[place] -= 1
            if left[place] == 0:
                del left[place]
    return chosen


def keep(texts, others, before):
    """Write the texts with the answers that all builds have in common, and tell what changed; return 0."""
    old = {item["text"]: item["answer"] for item in before}
    lines, changed = [], 0
    for text in texts:
        common = answer(text)
        for other in others:
            seen, _ = other.run(text)
            common = merged(common, seen) if common and seen else None
        if common is None:
            continue
        common = json.loads(json.dumps(common))
        lines.append(json.dumps({"text": text, "answer": common}))
        for name in differences(old.get(text, common), common):
            changed += 1
            print(f"{name} changed:\n{text}")
    new = KEPT.with_suffix(".new")
    new.write_text("\n".join([*lines, ""]), encoding="utf-8")
    new.replace(KEPT)
    print(f"{len(lines)} of {len(texts)} kept, {KEPT.stat().st_size} bytes, {changed} changes")
    return 0


if __name__ == "__main__":
    sys.exit(main())
