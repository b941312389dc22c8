"""Finds small cases that together exercise the whole core, and keeps its answers.

usage: find_answers.py --search COUNTED [--texts N] [--seed N] [--also LIBRARY...]
       find_answers.py --mutants FOLDER [--sample N] [--seed N] [--file PATTERN] [--also LIBRARY...]
       find_answers.py --renew [--add TEXTS] [--also LIBRARY...]
       find_answers.py --compare LIBRARY...

--search  COUNTED is a C library that counts the blocks it reaches (switched.py makes it). The kept texts, and
          the namelists of inputs/ and of tests/fuzz/seeds, are changed at random; the smallest set of texts that
          reaches each block as often as any of them does is kept.
--mutants FOLDER is the output of switched.py. A sample of the mutants that survive the kept answers is run on
          changed texts that reach the same statement; the smallest set of texts that kills each mutant that any
          of them kills is added.
--renew   writes the answers to the kept texts again, and prints what changed. TEXTS is a JSON file with a list
          of further texts, such as cases that other tests run.
--compare prints the answers of other builds that differ by more than rounding: the exit status is 1 if there
          are any.

Only the digits of an answer on which the package and all named libraries (another compiler, another LAPACK) agree
are kept.
"""

import argparse
import functools
import json
import multiprocessing
import os
import random
import sys
import tempfile
from collections import Counter
from fnmatch import fnmatch
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests" / part) for part in ("python", "fuzz")]

from kills import KILLED, kept_trial  # noqa: E402
from language import Language, parse, write  # noqa: E402
from mutate import core_files, sample  # noqa: E402
from shared_answers import (  # noqa: E402
    DECLARED,
    KEPT,
    STOPPED,
    answer,
    declarations,
    differences,
    load,
    merged,
    put_files,
)
from vibroimpact.results.tables import language  # noqa: E402

from door import BLOCKS, Counted, Library  # noqa: E402

# use one OpenBLAS kernel on all machines: its last digits can decide a case at an edge
os.environ["OPENBLAS_CORETYPE"] = "Haswell"

#: Largest CPU time in seconds of a kept case in the counting library.
LONGEST = 2.0
#: Largest number of bytes of a kept answer.
LARGEST = 6000


class Searched(Counted):
    """The counting library in a search."""

    def search(self, text):
        """(answer, CPU seconds, what was reached: blocks, and powers of eight of how often)."""
        found, took, places = self.reach(text, LONGEST)
        if found is None or found["status"] == 2:
            return found, took, set(places)
        often = np.log2(self.counts[places]).astype(int) // 3
        return found, took, {
            place + BLOCKS * power for place, most in zip(places, often.tolist(), strict=True)
            for power in range(min(most, 3) + 1)
        }  # fmt: skip


def sources(library, kept):
    """Complete namelists with one case each."""
    for path in (
        path
        for folder in ("inputs", "tests/fuzz/seeds")
        for path in sorted((ROOT / folder).glob("*.nml"))
    ):
        text = path.read_text(encoding="utf-8", errors="replace")
        yield from library.cases(text) or [text]
    yield from with_small_cases(kept, library)


def with_small_cases(kept, library):
    """The kept texts and those written by hand: small cases and edge cases."""
    text = (ROOT / "tests/quality/small_cases.nml").read_text(encoding="utf-8")
    cases = library.cases(text)
    if not cases:
        sys.exit(f"find_answers: small_cases.nml: {library.message(text)}")
    small = [
        case for case in cases
        if (found := library.run(case, 20.0)[0]) and len(json.dumps(found)) < LARGEST
    ]  # fmt: skip
    edge = (ROOT / "tests/quality/edge_cases.nml").read_text(encoding="utf-8").split("\n\n")
    texts = [item["text"] for item in kept]
    return list(dict.fromkeys([*texts, *small, *(f"{text.strip()}\n" for text in edge[1:])]))


def change(tongue, rng, groups):
    """Make a text from groups, mostly with changed values, sometimes with a changed form."""
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
    """Return numbers of the same magnitude as before."""
    new = []
    for word in value.split(","):
        try:
            x = float(word) * rng.choice((0.5, 0.9, 0.99, 1.01, 1.1, 1.5, 2.0))
            new.append(str(round(x)) if about["kind"] == "whole" else f"{x:.6g}")
        except (ValueError, OverflowError):
            return value
    return ", ".join(new)


def vary(tongue, rng, groups):
    """Make a text from groups that keeps most values and is mostly accepted."""
    groups = [(name, list(items)) for name, items in groups]
    for _ in range(rng.choice((1, 1, 2, 3, 5))):
        name, items = rng.choice(groups)
        table = {about["name"]: about for about in tongue.keys(name, groups)}
        new = [key for key in table if key not in dict(items)]
        if new and rng.random() < 0.15:
            items.append((key := rng.choice(new), other_value(rng, table[key], "")))
        elif items:
            place = rng.randrange(len(items))
            key, value = items[place]
            if key in table:
                items[place] = key, other_value(rng, table[key], value)
    return write(groups)


def other_value(rng, about, value):
    """Replace a value of a key, in most cases by one near it."""
    parts = [part.strip() for part in value.split(",")]
    place = rng.randrange(len(parts))
    if about["kind"] == "word":
        known = about["words"].split()
        if known:
            parts[place] = repr(rng.choice(known))
        elif parts[place].strip("'*RL") == "":
            parts[place] = repr("".join(rng.choice("RL") for _ in parts[place][2:]) or "RL")
        return ", ".join(parts)
    low = -1e3 if about["low"] is None else about["low"]
    high = 1e3 if about["high"] is None else about["high"]
    try:
        x = float(parts[place])
    except ValueError:
        x = low + rng.choice((0.0, 0.3, 1.0))
    if about["kind"] == "whole":
        x = round(rng.choice((x - 1, x + 1, x + 1, x + 2, 2 * x, x / 2)))
    else:
        x = rng.choice(
            (
                x * rng.choice((0.5, 0.9, 0.99, 1.01, 1.1, 2.0)),
                x + rng.uniform(-1, 1),
                round(x, 1),
                -x,
            )
        )
    x = min(max(x, low), high)
    parts[place] = str(int(x)) if about["kind"] == "whole" else f"{x:.6g}"
    return ", ".join(parts)


def main():
    """Run the requested action."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--search", type=Path, metavar="COUNTED")
    what.add_argument("--mutants", type=Path, metavar="FOLDER")
    what.add_argument("--renew", action="store_true")
    what.add_argument("--compare", type=Path, nargs="+", metavar="LIBRARY")
    parser.add_argument("--texts", type=int, default=10_000, help="texts that are tried (10000)")
    parser.add_argument("--seed", type=int, default=1, help="of the texts and the sample (1)")
    parser.add_argument("--every", type=int, default=1, help="compare every so many-th case (1)")
    parser.add_argument("--sample", type=int, default=300, help="mutants that are tried (300)")
    parser.add_argument(
        "--file", default="*", metavar="PATTERN", help="files whose mutants are tried"
    )
    parser.add_argument(
        "--tries", type=int, default=40, help="texts that are tried for a mutant (40)"
    )
    parser.add_argument("-j", "--jobs", type=int, default=2, help="processes (2)")
    parser.add_argument("--times", type=int, default=3, help="kept cases that reach a block (3)")
    parser.add_argument("--add", type=Path, metavar="TEXTS")
    parser.add_argument("--also", type=Path, nargs="*", default=[], metavar="LIBRARY")
    asked = parser.parse_args()
    others = [path.resolve() for path in asked.also or asked.compare or ()]
    if asked.renew and not others:
        parser.error("--renew needs other libraries, with which answers are compared: --also")
    counted = Searched(asked.search.resolve()) if asked.search else None
    libraries = asked.mutants.resolve() if asked.mutants else None
    more = json.loads(asked.add.read_text(encoding="utf-8")) if asked.add else []
    with tempfile.TemporaryDirectory() as folder:
        put_files(Path(folder))
        os.chdir(folder)
        others = [Library(path) for path in others]
        kept = load() if KEPT.exists() else []
        if asked.compare:
            return compare(kept[:: asked.every], others)
        if asked.mutants:
            found = noticing(asked, libraries)
            return keep([*(item["text"] for item in kept), *found], others, kept)
        if asked.renew:
            return keep([*with_small_cases(kept, others[0]), *more], others, kept)
        found = search(counted, kept, asked.texts, asked.seed)
        # texts written by hand stay
        few = list(dict.fromkeys([*with_small_cases([], counted), *fewest(found, asked.times)]))
        keep(few, [], kept)
        # another library may crash
        return keep(few, others, load())


def compare(kept, others):
    """Print the differences of other libraries; return the exit status."""
    different = 0
    for item in kept:
        for other in others:
            found, _ = other.run(item["text"], 60.0)
            for name in differences(item["answer"], json.loads(json.dumps(found or {}))):
                different += 1
                print(f"{name} differs:\n{item['text']}")
    print(f"{len(kept)} answers of {len(others)} other builds, {different} differences")
    return int(different > 0)


def search(counted, kept, count, seed):
    """Find texts that reach something new: (text, CPU seconds, what it reaches)."""
    rng, tongue, seen, found = random.Random(seed), Language(language()), set(), []
    first = [*sources(counted, kept)]
    pool = [groups for groups in map(parse, first) if groups]
    for number in range(len(first) + count):
        text = first[number] if number < len(first) else change(tongue, rng, rng.choice(pool))
        answered, took, reached = counted.search(text)
        if number % 500 == 0:
            print(
                f"{number} texts, {len(found)} found, {len(seen)} reached",
                file=sys.stderr,
                flush=True,
            )
        if answered is None or len(json.dumps(answered)) > LARGEST or len(text) > 3000:
            continue
        # keep some that reach nothing new: several cases should reach each block
        if not reached <= seen or (answered["status"] != 2 and rng.random() < 0.1):
            seen |= reached
            found.append((text, took, reached))
            pool += [groups for groups in (parse(text),) if groups]
    return found


def noticing(asked, folder):
    """Find texts that detect mutants which the kept answers miss."""
    trial = kept_trial(folder)
    files = [file for file in core_files() if fnmatch(file, asked.file)]
    numbers = trial.statements.numbers
    keys = [(m.file, m.line, m.after) for m in sample(files, asked.sample, asked.seed)]
    drawn = [numbers[key] for key in keys if key in numbers]
    shares = [drawn[first :: asked.jobs] for first in range(asked.jobs)]
    # each process loads its own libraries
    inherited.append(trial)
    with multiprocessing.get_context("fork").Pool(asked.jobs) as pool:
        parts = pool.map(functools.partial(notice, asked), shares, chunksize=1)
    found = [pair for part in parts for pair in part]
    passed = [number for number, text in found if text is None]
    texts = {text for _, text in found if text}
    print(
        f"{len(drawn)} mutants, {len(found)} not noticed, {len(passed)} by no text that was tried"
    )
    return smallest(trial, {number for number, text in found if text}, texts)


#: Objects that processes inherit from their parent.
inherited = []


def notice(asked, numbers):
    """Return the mutants that the kept answers miss, each with a text that detects it, or None."""
    trial = inherited[0]
    rng, tongue, found = random.Random(f"{asked.seed} {numbers[:1]}"), Language(language()), []
    for place, number in enumerate(numbers):
        outcome, _ = trial(number)
        if place % 20 == 0:
            noticed = sum(text is not None for _, text in found)
            print(
                f"{place} of {len(numbers)}, {len(found)} passed, {noticed} noticed",
                file=sys.stderr,
                flush=True,
            )
        if outcome == KILLED:
            continue
        reaching = [
            trial.cases[i] for i in trial.reaching.get(trial.statements.of_number[number], [])
        ]
        # refused texts are short and detect little
        reaching = [case for case in reaching if case[1]["status"] != 2] or reaching
        bases = [groups for case in reaching[:30] if (groups := parse(case[0]))]
        # a text that detected another mutant may detect this one
        texts = {text for _, text in found if text}
        texts |= {
            rng.choice((change, vary, vary, vary))(tongue, rng, rng.choice(bases))
            for _ in range(asked.tries if bases else 0)
        }
        found.append((number, trial.first_that_notices(number, sorted(texts))))
    return found


def smallest(trial, numbers, texts):
    """Choose, greedily, few of the texts that together detect the same mutants."""
    noticed = {
        text: {n for n in numbers if trial.first_that_notices(n, [text])} for text in sorted(texts)
    }
    chosen, left = [], set().union(*noticed.values())
    while left:
        text = max(noticed, key=lambda text: (len(noticed[text] & left), -len(text)))
        chosen.append(text)
        left -= noticed[text]
    return chosen


def fewest(found, times):
    """Choose few texts that reach each block so many times; the next is the one that adds most for its time."""
    left = Counter()
    for _, _, reached in found:
        left.update(reached)
    left = {place: min(times, number) for place, number in left.items()}
    chosen, rest = [], [(text, 0.005 + took, reached) for text, took, reached in found]
    gain = [len(reached) / took for _, took, reached in rest]
    while rest:
        # gains only decrease: a text that still leads with its new gain is the best
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
    """Write the texts with the answers on which all builds agree, and print what changed; return 0."""
    old = {item["text"]: item["answer"] for item in before}
    lines, changed = [], 0
    texts = [*dict.fromkeys(text.removeprefix(STOPPED) for text in texts)]
    for text in (*texts, *(STOPPED + text for text in texts)):
        common = answer(text)
        if text.startswith(STOPPED) and not [*differences(answer(text[len(STOPPED) :]), common)]:
            # it finished before it was asked to stop
            continue
        for other in others:
            # a build with checks is slow, as is a busy machine
            seen, _ = other.run(text, 200.0)
            common = merged(common, seen) if common and seen else None
        if common is None:
            if text in old:
                changed += 1
                print(f"no longer kept:\n{text}")
            continue
        common = json.loads(json.dumps(common))
        lines.append(json.dumps({"text": text, "answer": common}))
        for name in differences(old.get(text, common), common):
            changed += 1
            print(f"{name} changed:\n{text}")
    new = KEPT.with_suffix(".new")
    new.write_text("\n".join([*lines, ""]), encoding="utf-8")
    new.replace(KEPT)
    DECLARED.write_text(json.dumps(declarations(), indent=1) + "\n", encoding="utf-8")
    print(
        f"{len(lines)} answers to {len(texts)} texts, {KEPT.stat().st_size} bytes, {changed} changes"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
