"""The method of the paper for more than two impacts: phases read from a record, least squares, a residual of up to
3 %.

Known errors are added to the phases of exact motions, and the overdetermined equations are solved. The study
counts how often the solution is accepted, and how often its verdict on stability is wrong.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from .. import Motion, exact, periodic_batch, simulate
from ..base.errors import SingularError
from ..base.files import write_text
from .paper import EQUAL, NATURAL_FREQUENCY

#: A point in the zone of 3, 4 and 5 impacts: r and d K/F0.
POINTS = ((0.90, 8.0), (1.06, 4.0), (1.22, 1.0))
#: Standard deviations of a misread phase (radians): 0.02 is about a hundredth of the record's 16.7 ms division.
ERRORS = (0.005, 0.02, 0.05, 0.1)
#: Accepted relative residuals.
RULES = (0.03, 0.015)


def family(r: float, clearance: float, count: int) -> list[Motion]:
    """Motions of one pattern at one r, from inside its zone to well outside."""
    first = exact(EQUAL, r, clearance, simulate(EQUAL, r, clearance, 8, discard=800))
    found = [first]
    for factor in (1.004, 1 / 1.004):
        motion = first
        for _ in range(count):
            try:
                motion = exact(EQUAL, r, motion.clearance * factor, motion)
            except SingularError:
                break
            if not motion.admissible:
                break
            found.append(motion)
    return found


def misread(motions: list[Motion], error: float, samples: int) -> dict[str, Any]:
    """The least-squares solutions for motions whose phases are misread."""
    random = np.random.default_rng(1983)
    accepted = dict.fromkeys(RULES, 0)
    wrong = dict.fromkeys(RULES, 0)
    residuals, off = [], []
    for motion in motions:
        n = len(motion.pattern)
        phases = motion.alpha[:, None] + error * random.standard_normal((n, samples))
        phases -= phases[:1]
        keep = (np.diff(phases, axis=0) > 0).all(axis=0) & (phases[-1] < 2 * math.pi)
        found = periodic_batch(EQUAL, motion.r, phases[:, keep], motion.pattern, flights=False)
        for rule in RULES:
            taken = found.residual < rule
            accepted[rule] += int(taken.sum())
            wrong[rule] += int((taken & ((found.stable == 1) != bool(motion.stable))).sum())
        residuals.append(found.residual)
        off.append((found.clearance / motion.clearance - 1)[found.residual < RULES[0]])
    residual, misfit = np.concatenate(residuals), np.concatenate(off)
    total = len(motions) * samples
    return {
        "sides": motions[0].pattern.sides, "r": motions[0].r, "motions": len(motions),
        "stable": sum(motion.stable is True for motion in motions), "error": error,
        "milliseconds": 1e3 * error / (2 * math.pi * NATURAL_FREQUENCY * motions[0].r),
        "residual": np.quantile(residual, [0.05, 0.5, 0.95]).tolist(),
        "accepted": [accepted[rule] / total for rule in RULES],
        "wrong": [wrong[rule] / max(1, accepted[rule]) for rule in RULES],
        "clearance_off": float(np.sqrt(np.mean(misfit**2))) if misfit.size else math.nan,
    }  # fmt: skip


def study(resolution: float = 1.0) -> list[dict[str, Any]]:
    """All patterns and errors."""
    samples = max(20, round(100 * resolution))
    families = [family(*point, max(10, round(120 * resolution))) for point in POINTS]
    return [misread(motions, error, samples) for motions in families for error in ERRORS]


def reproduce(folder: Path, resolution: float = 1.0) -> bool:
    """Write data/phase_errors.json."""
    rows = study(resolution)
    write_text(folder / "data" / "phase_errors.json", json.dumps(rows, indent=1) + "\n")
    for row in rows:
        print(
            f"Phases misread by {row['error']:g} rad ({row['milliseconds']:.2f} ms), {row['sides']}: 3 % accepts "
            f"{row['accepted'][0]:.0%}, {row['wrong'][0]:.1%} of them with the wrong stability; "
            f"1.5 %: {row['accepted'][1]:.0%}, {row['wrong'][1]:.1%}"
        )
    return True
