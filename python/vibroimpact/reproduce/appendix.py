"""Equations (A5)-(A7) as they are printed, and with their three corrections, against the exact derivative."""

from __future__ import annotations

import json
import math
from collections.abc import Collection
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import Motion, Pattern, exact, periodic, simulate
from ..base.files import write_text
from .paper import MASRI, UNEQUAL

#: The clearance d in the unit of length of Table 1.
TABLE_1 = 37.0
#: The corrections: the position, the printed form, and the correct form.
CORRECTIONS = {
    "S5": ("S_5i in (A6), first term", "X'_ia/Omega", "Z'_ia/Omega"),
    "S11": ("S_11i in (A6), last term", "X'_ia/Omega", "Z'_ia/Omega"),
    "P31": ("P_ia(3,1) in (A7), first term", "S_6i", "S_3i"),
}


def maps(motion: Motion, corrected: Collection[str], unit: float = 1.0) -> NDArray[np.float64]:
    """The matrices [P_ia] of a motion by (A5)-(A7), (N, 4, 4), with some of the corrections applied.

    Lengths are measured in units of the given multiple of F0/K.
    """
    xi, mu, r, n = motion.osc.xi, motion.osc.mu, motion.r, len(motion.pattern)
    eta, turn = math.sqrt(1 - xi * xi), 2 * math.pi * motion.pattern.cycles
    alpha = np.append(motion.alpha, turn)
    result = np.empty((n, 4, 4))
    for i in range(n):
        after = motion.restitution[(i + 1) % n]
        step, here, there = (
            alpha[i + 1] - alpha[i],
            alpha[i] + motion.tau,
            alpha[i + 1] + motion.tau,
        )
        decay = math.exp(-xi * step / r)
        c1, c2 = decay * math.sin(eta * step / r), decay * math.cos(eta * step / r)  # (9), (10)
        c3, c4 = eta * c2 - xi * c1, -(eta * c1 + xi * c2)  # (A4)
        a, x_dot, z_dot = (
            float(x) / unit for x in (motion.A, motion.X_dot_after[i], motion.Z_dot_after[i])
        )
        b = float(motion.X[i]) / unit - a * math.sin(here)  # (6)
        u = x_dot - a * r * math.cos(here)
        k1, k2 = (1 - mu * after) / (1 + mu), mu * (1 + after) / (1 + mu)  # (A5)
        k3, k4 = (1 + after) / (1 + mu), (mu - after) / (1 + mu)
        s1, s2, s3, s4 = (xi * c1 + eta * c2) / eta, c1 / eta, -c1 / eta, c3 / eta  # (A6)
        s6 = (b * s3 + u * c3 / eta) / r
        s5 = (z_dot if "S5" in corrected else x_dot) / r - a * math.cos(there) - s6
        s7, s8, s9, s10 = s1 / s5, s2 / s5, -1 / s5, -step / (r * s5)
        forced = -a * s1 * math.cos(here) + a * r * s2 * math.sin(here) - s6
        s11 = (forced + (z_dot if "S11" in corrected else x_dot) / r) / s5
        s12 = a * math.cos(there) + s6
        s13 = (-b * c3 + (eta * c4 - xi * c3) * u) / (r * eta)
        s14 = s13 - a * r * math.sin(there)
        load = -a * s3 * math.cos(here) + a * r * s4 * math.sin(here) - s13 + s11 * s14
        velocity = np.array([s3 + (s7 + s9) * s14, s4 + s8 * s14, s10 * s14, load])
        result[i] = [  # (A7)
            [s1 + s12 * (s7 + s9), s2 + s8 * s12, s10 * s12, forced + s11 * s12],
            k1 * velocity + [0, 0, k2, 0],
            k3 * velocity + [0, 0, k4, 0],
            [s7 + s9, s8, s10, s11],
        ]
        if "P31" not in corrected:
            result[i, 2, 0] = k3 * (s6 + (s7 + s9) * s14)
    return result


def over_a_period(matrices: NDArray[np.float64]) -> NDArray[np.float64]:
    """[P], the product of the matrices."""
    product = np.eye(4)
    for matrix in matrices:
        product = matrix @ product
    return product


def largest(motion: Motion, corrected: Collection[str], clearance: float) -> float:
    """max|lambda| for the unit of length in which the clearance d has this value.

    S_6i is a length and S_3i is a number: with S_6i in P_ia(3,1), as printed, the multipliers depend on the unit.
    """
    product = over_a_period(maps(motion, corrected, motion.clearance / clearance))
    return float(np.abs(np.linalg.eigvals(product)).max())


def row(name: str, motion: Motion, corrected: Collection[str]) -> dict[str, Any]:
    """The errors of (A5)-(A7) with some corrections for a motion, lengths in F0/K, and max|lambda| in Table 1's
    unit."""
    found = maps(motion, corrected)
    product = over_a_period(found)
    law = math.exp(-4 * math.pi * motion.osc.xi * motion.pattern.cycles / motion.r)
    return {
        "motion": name, "corrected": sorted(corrected),
        "multipliers": sorted(np.abs(np.linalg.eigvals(product)).tolist(), reverse=True),
        "largest_in_table_1": largest(motion, corrected, TABLE_1),
        "determinant": float(np.linalg.det(product)),
        "law": law * float(np.prod(motion.restitution**2)),
        "largest_error": float(np.abs(found - motion.impact_maps()).max() / np.abs(found).max()),
    }  # fmt: skip


def study() -> list[dict[str, Any]]:
    """The cases with no correction, with all, and with all but one, for Table 1's third column and for Figure
    9b."""
    table1 = periodic(MASRI, 0.94, [0, 1.37 * math.pi], Pattern("RL"))
    three = exact(UNEQUAL, 0.9, 12.0, simulate(UNEQUAL, 0.9, 12.0, 8, discard=500))
    sets = [set(CORRECTIONS), *(set(CORRECTIONS) - {name} for name in CORRECTIONS), set()]
    motions = {"Table 1, column 3": table1, "Figure 9b": three}
    return [row(name, motion, chosen) for name, motion in motions.items() for chosen in sets]


def reproduce(folder: Path, resolution: float = 1.0) -> bool:
    """Write data/appendix.json; True if the corrected equations give the exact derivative."""
    rows = study()
    write_text(folder / "data" / "appendix.json", json.dumps(rows, indent=1) + "\n")
    for one in rows:
        moduli = ", ".join(f"{x:.4g}" for x in one["multipliers"])
        print(
            f"(A6), (A7), {one['motion']}, corrected: {', '.join(one['corrected']) or 'nothing'}: |lambda| = "
            f"{moduli}; det[P] = {one['determinant']:.6g} ({one['law']:.6g})"
        )
    return all(one["largest_error"] < 1e-12 for one in rows if len(one["corrected"]) == 3)
