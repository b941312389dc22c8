"""Table 1: two equispaced motions and an unequispaced one, each entry compared with the printed one."""

from __future__ import annotations

import csv
import io
import math
from importlib.resources import files
from pathlib import Path

from .. import Motion, Oscillator, Pattern, equispaced, periodic
from ..base.files import write_text

OSCILLATOR = Oscillator(xi=0.005, mu=0.042, restitution=0.75)
R, CLEARANCE, PAIR = 0.94, 37.0, Pattern("RL")

#: Printed entries that cannot be right, with the reason.
MISPRINTS = {
    (
        "X'_2a",
        "unequispaced",
    ): "9.91 with the digits 1 and 9 swapped or misread: (13) with the printed "
    "Z'_1a, Z'_2a gives 9.91",
    (
        "|lambda_4|",
        "equispaced 2",
    ): "0.025: det[P] = exp(-4 pi xi/r) R1^2 R2^2 = 0.296 is the product of "
    "the four moduli, from which 0.25 differs by a factor of ten",
}


def motions() -> dict[str, Motion]:
    """The motions of the three printed columns, and the exact motion that corresponds to the third."""
    first, second = equispaced(OSCILLATOR, R, CLEARANCE)
    third = periodic(OSCILLATOR, R, [0, 1.37 * math.pi], PAIR)
    # the paper kept alpha_2 = 1.37 pi, which needs d K/F0 = 38.22; d K/F0 decreases with alpha_2, to 37 here
    low, high = 1.37 * math.pi, 1.40 * math.pi
    while high - low > 4 * math.ulp(high):
        middle = 0.5 * (low + high)
        above = periodic(OSCILLATOR, R, [0, middle], PAIR).clearance > CLEARANCE
        low, high = (middle, high) if above else (low, middle)
    exact = periodic(OSCILLATOR, R, [0, low], PAIR)
    return {"equispaced 1": first, "equispaced 2": second, "unequispaced": third, "exact": exact}


def entries(motion: Motion) -> dict[str, float | str]:
    """The rows of the table for one motion, with d = 37 as the unit of length, as in the paper."""
    unit = CLEARANCE / motion.clearance
    rows: dict[str, float | str] = {
        "alpha_2/pi": motion.alpha[1] / math.pi,
        "Omega t_1/pi": math.remainder(motion.load_phase, 2 * math.pi) / math.pi,
        "tau/pi": motion.tau / math.pi,
    }
    for name, values in (
        ("X_{}", motion.X), ("Z_{}", motion.Z), ("X'_{}a", motion.X_dot_after),
        ("X'_{}b", motion.X_dot_before), ("Z'_{}a", motion.Z_dot_after),
    ):  # fmt: skip
        for i, value in enumerate(values, start=1):
            rows[name.format(i)] = unit * float(value)
    rows["x_min"], rows["x_max"] = unit * motion.x_min, unit * motion.x_max
    for i, value in enumerate(motion.multipliers, start=1):
        rows[f"|lambda_{i}|"] = abs(complex(value))
    rows["stability"] = "stable" if motion.stable else "unstable"
    return rows


def verdict(computed: float | str, printed: str, misprint: str | None) -> str:
    """The comparison of a computed entry with a printed one; the paper truncates some and rounds others."""
    if isinstance(computed, str):
        agrees = computed == printed
        return "agrees" if agrees else "DIFFERS"
    decimals = len(printed.partition(".")[2])
    steps = computed * 10**decimals
    units = round(float(printed) * 10**decimals)
    if abs(steps - units) <= 0.5 + 1e-9:
        return "agrees"
    if math.trunc(steps) == units:
        return "agrees (truncated)"
    if misprint is not None:
        return f"misprint: {misprint}"
    if abs(steps - units) < 1:
        return "agrees within 1 in the last digit"
    return "DIFFERS"


def printed_values() -> list[dict[str, str]]:
    """The rows of table1.csv."""
    text = (files(__package__) / "table1.csv").read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    return list(csv.DictReader(lines))


def reproduce(folder: Path, resolution: float = 1.0) -> bool:
    """Print the comparison, write table1.txt and table1.csv; True if every entry is accounted for."""
    found = motions()
    computed = {name: entries(motion) for name, motion in found.items()}
    lines = [
        "Table 1: xi = 0.005, r = 0.94, mu = 0.042, R1 = R2 = 0.75, d/(F0/K) = 37",
        "Popplewell, Bapat and McLachlan, J. Sound Vib. 87 (1983); lengths in F0/K, velocities in omega F0/K",
    ]
    table = [["column", "quantity", "computed", "printed", "verdict"]]
    for column in ("equispaced 1", "equispaced 2", "unequispaced"):
        beside = computed["exact"] if column == "unequispaced" else None
        lines += [
            "",
            f"{column}",
            _row("", "computed", "printed", "exact" if beside else "", "verdict"),
        ]
        for row in printed_values():
            name, printed = row["quantity"], row[column]
            value = computed[column][name]
            outcome = verdict(value, printed, MISPRINTS.get((name, column)))
            lines.append(_row(name, value, printed, beside[name] if beside else "", outcome))
            table.append(
                [
                    column,
                    name,
                    repr(float(value)) if isinstance(value, float) else value,
                    printed,
                    outcome,
                ]
            )
    faults = sum(row[-1] == "DIFFERS" for row in table)
    misprints = sum(row[-1].startswith("misprint") for row in table)
    third = found["unequispaced"]
    lines += [
        "",
        f"{len(table) - 1} entries: {len(table) - 1 - faults - misprints} agree, {misprints} are misprints, "
        f"{faults} differ.",
        f"Third column: alpha_2 = 1.37 pi needs d K/F0 = {third.clearance:.4f}; the paper took d = 37 as the",
        f"unit of length. 'exact' is the motion at d K/F0 = 37, where alpha_2 = "
        f"{computed['exact']['alpha_2/pi']:.6f} pi.",
    ]
    text = "\n".join(lines) + "\n"
    buffer = io.StringIO()
    csv.writer(buffer, lineterminator="\n").writerows(table)
    write_text(folder / "table1.txt", text)
    write_text(folder / "table1.csv", buffer.getvalue())
    print(text, end="")
    print(f"written: {folder / 'table1.txt'}, {folder / 'table1.csv'}")
    return faults == 0


def _row(name: str, computed: float | str, printed: str, beside: float | str, outcome: str) -> str:
    values = [f"{x:.4f}" if isinstance(x, float) else x for x in (computed, printed, beside)]
    return f"  {name:<13} {values[0]:>10} {values[1]:>10} {values[2]:>10}   {outcome}".rstrip()
