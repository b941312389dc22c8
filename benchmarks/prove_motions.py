#!/usr/bin/env python3
"""How many motions of `find` on random systems are proven: verdicts, contradictions, and reasons where nothing is.

    python benchmarks/prove_motions.py [motions] [seed]

The systems and points are drawn as those of the audit (tests/python/shared_audit.py). A contradiction is a proven
verdict that is not the one of the motion.
"""

import sys
import time
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "python"))
import vibroimpact as vi
from shared_audit import random_oscillators, random_points

#: Points of each system.
POINTS = 4


def drawn(seed):
    """Random systems with a point each, without end."""
    number = 0
    while True:
        for osc in random_oscillators(16, [seed, number]):
            number += 1
            for r, clearance in zip(*random_points(POINTS, [seed, number, 1]), strict=True):
                yield osc, float(r), float(clearance)


def count(motions, seed, told=None):
    """Counts of what is proven of so many motions, and the motions that are contradicted or lack a reason."""
    counts, reasons, wrong = Counter(), Counter(), []
    for osc, r, clearance in drawn(seed):
        for motion in vi.find(osc, r, clearance):
            if motion.pattern.has_rest:
                counts["with rest, refused"] += 1
                continue
            begin = time.process_time()
            proof = motion.prove()
            counts["seconds"] += time.process_time() - begin
            counts["motions"] += 1
            counts["impacts"] += len(motion.pattern)
            own = proof.exists, proof.admissible, proof.stable
            counts["proven"] += None not in own
            for name, verdict in zip(("exists", "admissible", "stable"), own, strict=True):
                counts[f"{name} not decided"] += verdict is None
            if None in own:
                given = [item["reason"].split(":")[0] for item in proof.undecided]
                reasons.update(given or ["no reason"])
                if not given:
                    wrong.append(motion)
            claimed = (True, motion.admissible, motion.stable)
            if any(
                None not in pair and pair[0] != pair[1] for pair in zip(own, claimed, strict=True)
            ):
                counts["contradictions"] += 1
                wrong.append(motion)
            if told is not None:
                told(counts, reasons, wrong)
            if counts["motions"] == motions:
                return counts, reasons, wrong
    raise AssertionError


def main(motions=1000, seed=47):
    """Print the counts."""

    def told(counts, reasons, wrong):
        if counts["motions"] % 500 == 0:
            print(dict(counts), dict(reasons), wrong, flush=True)

    counts, reasons, wrong = count(motions, seed, told)
    for name, number in [*counts.items(), *reasons.items()]:
        print(f"{name:40} {number:g}")
    for motion in wrong:
        print(motion, motion.osc, motion.r, motion.clearance)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
