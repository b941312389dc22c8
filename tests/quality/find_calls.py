"""Keeps calls of procedures of _core that no case makes: arguments that tests pass, and the answers.

usage: find_calls.py --record TEST...   run tests, and add some of their calls to the kept calls
       find_calls.py --renew            write the answers again, and print what changed
       find_calls.py --answers          print the answers to the kept calls; --renew runs this in other builds

Only the part of an answer on which this package, with two versions of the sine function, and the builds in the
folders of --also agree is kept; these folders contain the module _core.
"""

import argparse
import json
import os
import random
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests/python")]

import shared_kept_calls as calls  # noqa: E402
from package import PLAIN_SINES, copy_package, core_of, variables  # noqa: E402
from shared_answers import common  # noqa: E402

#: Bytes of the arguments of a kept call; calls of a procedure, and how many of them need not be of a new kind.
LARGEST, MOST, ALIKE = 3000, 100, 30
#: The pytest plugin that records calls.
RECORDER = """
import json, os
import numpy as np
import shared_kept_calls as calls
from vibroimpact import _core

def recorded(name, procedure, out):
    def call(*arguments, **named):
        if not named and sum(np.size(argument) for argument in arguments) < 300:
            packed = [calls.pack(argument) for argument in arguments]
            text = json.dumps([name, packed])
            if None not in packed and len(text) < int(os.environ["LARGEST"]):
                print(text, file=out, flush=True)
        return procedure(*arguments, **named)
    return call

out = open(os.environ["RECORDED"] + str(os.getpid()), "a")
for name in calls.procedures():
    setattr(_core, name, recorded(name, getattr(_core, name), out))
"""


def main():
    """Run the requested action."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--record", nargs="+", metavar="TEST")
    what.add_argument("--renew", action="store_true")
    what.add_argument("--answers", action="store_true")
    parser.add_argument("--also", type=Path, nargs="*", default=[], metavar="FOLDER")
    asked = parser.parse_args()
    kept = calls.load() if calls.KEPT.exists() else []
    if asked.answers:
        print(json.dumps([calls.answer(call["procedure"], call["arguments"]) for call in kept]))
        return
    if asked.record:
        kept += chosen(record(asked.record), kept)
    keep(kept, [folder.resolve() for folder in asked.also])


def record(tests):
    """Return each call that tests make once: (procedure, arguments)."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "recorder.py").write_text(RECORDER, encoding="utf-8")
        paths = os.pathsep.join([folder, str(ROOT / "tests/python")])
        environment = {"PYTHONPATH": paths, "RECORDED": f"{folder}/calls.", "LARGEST": str(LARGEST)}
        subprocess.run(
            [sys.executable, "-m", "pytest", "-q", "-p", "recorder", "-p", "no:cacheprovider", *tests],
            cwd=ROOT, env=os.environ | environment, check=False,
        )  # fmt: skip
        lines = {
            line for path in Path(folder).glob("calls.*") for line in path.read_text().splitlines()
        }
    return [json.loads(line) for line in sorted(lines)]


def chosen(recorded, kept):
    """Choose recorded calls, most of which differ in the whole numbers of their answers, such as verdicts."""
    seen, count = set(), Counter(call["procedure"] for call in kept)
    random.Random(1).shuffle(recorded)
    for procedure, arguments in recorded:
        answer = calls.answer(procedure, arguments)
        # a checksum of whole numbers; of reals, their number and how many are not finite
        kind = procedure, json.dumps([part[:2] for part in answer])
        if count[procedure] < (ALIKE if kind in seen else MOST):
            seen.add(kind)
            count[procedure] += 1
            yield {"procedure": procedure, "arguments": arguments, "answer": None}


def keep(kept, folders):
    """Write calls with the answers on which all builds agree, and print what changed."""
    old = [call["answer"] for call in kept]
    write(kept)
    answers = [answers_of(os.environ), answers_of(os.environ | PLAIN_SINES)]
    for build in folders:
        with tempfile.TemporaryDirectory() as site:
            core = copy_package(Path(site), build)
            core.symlink_to(core_of(build))
            program = build / "src/vibroimpact-batch"
            answers.append(answers_of(os.environ | variables(Path(site), program)))
    new, changed = [], 0
    for place, call in enumerate(kept):
        answer = answers[0][place]
        for other in answers[1:]:
            answer = merged(answer, other[place])
        if answer is None:
            continue
        new.append(call | {"answer": answer})
        if old[place] and calls.differences(old[place], answer):
            changed += 1
            print(f"changed: {call['procedure']} of {call['arguments']}")
    write(new)
    print(
        f"{len(new)} answers to {len(kept)} calls, {calls.KEPT.stat().st_size} bytes, {changed} changes"
    )


def answers_of(environment):
    """Compute the answers to the kept calls in another process."""
    command = [sys.executable, __file__, "--answers"]
    return json.loads(
        subprocess.run(command, env=environment, stdout=subprocess.PIPE, check=True).stdout
    )


def merged(one, other):
    """Return the common part of two answers; None if they differ by more than rounding."""
    if one is None or len(one) != len(other):
        return None
    both = [common(mine, yours) for mine, yours in zip(one, other, strict=True)]
    return None if None in both else both


def write(kept):
    """Write calls, one per line."""
    new = calls.KEPT.with_suffix(".new")
    new.write_text("".join(json.dumps(call) + "\n" for call in kept), encoding="utf-8")
    new.replace(calls.KEPT)


if __name__ == "__main__":
    main()
