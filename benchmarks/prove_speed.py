#!/usr/bin/env python3
"""Times of proofs in ball arithmetic, compared with double precision without a proof."""

import statistics
import time

import flint
import vibroimpact as vi
from table import row, show

#: Milliseconds of a motion by its number of impacts, and seconds of the branch.
TARGETS, BRANCH_TARGET = {2: 2.0, 5: 25.0}, 1.0
ROUNDS = 15


def spent(*calls, rounds=ROUNDS):
    """Medians of the seconds of the processor that each call takes, in turn, and what they gave."""
    times = [[] for _ in calls]
    found = [call() for call in calls]
    for _ in range(rounds):
        for own, call in zip(times, calls, strict=True):
            begin = time.process_time()
            call()
            own.append(time.process_time() - begin)
    return [statistics.median(own) for own in times], found


def encloses(proof, motion):
    """Whether a certificate has the verdicts of a motion, and bounds around its numbers."""
    if (proof.exists, proof.admissible, proof.stable) != (True, motion.admissible, motion.stable):
        return False
    return proof.attenuation_bound is None or proof.attenuation_bound >= motion.attenuation


def motion_row(motion):
    """The row of one motion."""
    call = lambda: vi.exact(motion.osc, motion.r, motion.clearance, motion).multipliers  # noqa: E731
    (ours, peer), (proof, _) = spent(motion.prove, call)
    n = len(motion.pattern)
    return row(
        f"proof of a motion, N = {n}", "ms", ours * 1e3, TARGETS[n], peer * 1e3, "exact, without proof",
        encloses(proof, motion),
    )  # fmt: skip


def structure_rows(pair):
    """Those of structures: one mass before a wall, the pair of a motion, and a branch of the first."""
    wall = vi.Structure([[1]], [[0.1]], [[1]], [vi.Gap([1], 1.0, 0.8)])
    first = vi.exact(wall, vi.Load(1.0, cosine=[1.0]), ([0.076], [0], 1))
    point = pair.osc.at(pair.r, pair.clearance)
    guess = pair.phases, pair.gaps.tolist(), pair.cycles
    found = []
    for name, motion in (
        ("one mass before a wall", first), ("the pair", vi.exact(point.structure, point.load, guess)),
    ):  # fmt: skip
        given = motion.phases, motion.gaps.tolist(), motion.cycles
        call = lambda motion=motion, given=given: vi.exact(motion.structure, motion.load, given)  # noqa: E731
        (ours, peer), (proof, _) = spent(motion.prove, call)
        work = f"proof of a structure's motion, {name}"
        found.append(
            row(
                work,
                "ms",
                ours * 1e3,
                None,
                peer * 1e3,
                "exact, without proof",
                encloses(proof, motion),
            )
        )
    call = lambda: vi.branch(first, "frequency", bounds=(0.9, 1.1))  # noqa: E731
    (ours, peer), (proof, _) = spent(call().prove, call, rounds=3)
    work = "proof of a structure's branch, frequency from 0.9 to 1.1"
    found.append(row(work, "s", ours, None, peer, "branch, without proof", proof.proven))
    return found


def rows():
    """All rows."""
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    motion = vi.equispaced(osc, r=1.04, clearance=25.0)[0]
    five = next(one for one in vi.find(osc, 0.9, 5.0, max_impacts=5) if len(one.pattern) == 5)
    found = [motion_row(motion), motion_row(five)]
    branch = vi.branch(motion, "clearance", bounds=(10, 100))
    (ours, peer), (proof, _) = spent(
        branch.prove, lambda: vi.branch(motion, "clearance", bounds=(10, 100)), rounds=3
    )
    gaps = {kind for item in proof.undecided for kind in [item["reason"].split(":")[0]]}
    found.append(
        row(
            "proof of a branch, d K/F0 from 10 to 100", "s", ours, BRANCH_TARGET, peer, "branch, without proof",
            proof.exists is True and gaps <= {"stability"},
        )
    )  # fmt: skip
    found += structure_rows(motion)
    (ours, peer), (proof, motions) = spent(
        lambda: vi.prove_all(osc, 1.04, 25.0),
        lambda: vi.find(osc, 1.04, 25.0, max_impacts=3, max_cycles=1),
        rounds=1,
    )
    same = proof.complete and len(proof.boxes) == len(motions)
    found.append(
        row("proof of all motions, N = 2 and 3", "s", ours, None, peer, "find, without proof", same)
    )
    return found


if __name__ == "__main__":
    print(f"python-flint {flint.__version__}")
    show(rows())
