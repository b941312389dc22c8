"""The paper's statements about its figures, each compared with the computed results."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .. import (
    Branch,
    Certificate,
    Motion,
    Oscillator,
    Pattern,
    branch,
    equispaced,
    equispaced_batch,
    periodic_batch,
)
from ..base.errors import MissingExtraError
from ..base.files import write_text
from ..proofs.balls import exact
from . import appendix, canvas, damper, table1
from .digits import upper_boundary
from .figure9 import PANELS, motions, there
from .paper import EQUAL, KINDS, MASRI, UNEQUAL
from .phases import POINTS, curve
from .scan import Array, Strip, clearance, equispaced_verdict, equispaced_zone, grid, is_good, runs
from .sweeps import read_sweeps

AGREES, DIFFERS, UNCHECKED = "agrees", "differs", "cannot be checked"
#: The verdicts on measurements that the text does not report: only a simulation is compared with the computed
#: zone.
SIMULATED, CONTRADICTED = "simulation agrees", "simulation differs"
#: Share of the simulated holds that must lie in the computed zone.
MOST_HOLDS = 0.9
#: Special points at which a motion that continues loses its stability; the distance from such a point at which
#: both sides are proven; and half of the length of the branch that contains both.
ENDS, HALF_WIDTH, AROUND = ("pitchfork", "neimark_sacker"), 4e-13, 1e-5
#: Distances from r = 1 at which a spike is looked for.
NEAR = (1e-3, 1e-5, 1e-7, 1e-9)


class Row(NamedTuple):
    """A statement about an item, the finding, the verdict, and the part that a certificate proves."""

    where: str
    statement: str
    found: str
    verdict: str
    proven: str = ""


def agreement(good: bool) -> str:
    """A verdict."""
    return AGREES if good else DIFFERS


def proven(statement: Callable[[], str]) -> str:
    """The results that certificates prove; empty without python-flint."""
    try:
        return statement()
    except MissingExtraError:
        return ""


def proof_of_motions() -> str:
    """Which motions of Table 1 exist, and which of them are stable."""
    proofs = {name: motion.prove() for name, motion in table1.motions().items()}
    words = {True: "stable", False: "unstable"}
    found = [
        f"{name} {words[proof.stable]}"
        for name, proof in proofs.items()
        if proof.exists and proof.stable is not None
    ]
    return f"these motions exist: {', '.join(found)}" if found else ""


def proof_of_line(first: float, last: float) -> str:
    """Whether motions on d K/F0 = 37 are proven to be stable and admissible for all r between two values, and the
    ends beyond which they are proven not to be stable."""
    middle = 0.5 * (first + last)
    start = next(one for one in equispaced(MASRI, middle, 37.0) if one.stable)
    line = branch(start, "r", bounds=(first - 1e-3, last + 1e-3))
    proof = branch(start, "r", bounds=(first, last)).prove()
    if not (proof.proven and proof.stable and proof.admissible):
        return ""
    found = f"stable and admissible for every r from {first:.4f} to {last:.4f}"
    ends = [
        certificates_of_end(line, point.r) for point in line.special_points if point.type in ENDS
    ]
    if len(ends) != 2 or None in ends:
        return found
    places = [(float(one.system["r"]) + float(two.system["r"])) / 2 for one, two in ends]  # type: ignore[misc]
    return f"{found}; the ends of this range are {places[0]:.12f} and {places[1]:.12f}, each within {HALF_WIDTH:g}"


def certificates_of_end(line: Branch, r: float) -> tuple[Certificate, Certificate] | None:
    """Certificates on either side of the end of a stable range, one of a stable and one of an unstable motion,
    each `HALF_WIDTH` from the end; None where they do not prove that stability ends in between.

    Both must lie on one branch that is proven to exist.
    """
    known = line[int(np.argmin(np.abs(line.r - r)))].X[0]

    def motion_at(place: float) -> Motion:
        return min(equispaced(MASRI, place, 37.0), key=lambda one: abs(one.X[0] - known))

    around = branch(motion_at(r + AROUND), "r", bounds=(r - AROUND, r + AROUND)).prove()
    if around.exists is not True or around.admissible is not True:
        return None
    sides = motion_at(r - HALF_WIDTH).prove(), motion_at(r + HALF_WIDTH).prove()
    if not all(one.exists and lies_on(one, around) for one in sides):
        return None
    return sides if {one.stable for one in sides} == {True, False} else None


def lies_on(motion: Certificate, line: Certificate) -> bool:
    """Whether a proven motion lies on a proven branch along r: its numbers are in the region with only one
    motion."""
    place = exact(motion.system["r"])
    for box in line.boxes:
        low, high = map(exact, box["parameters"]["r"])
        if low <= place <= high:
            at = (2 * place - low - high) / (high - low)
            rows = zip(
                box["centre"][0], box["radius"][0], motion.boxes[0]["centre"][0], strict=True
            )
            apart = [
                (sum(exact(text) * at**k for k, text in enumerate(texts)) - exact(own[0]), exact(radius))
                for texts, radius, own in rows
            ]  # fmt: skip
            turn = 2 * math.pi * round(float(apart[0][0]) / (2 * math.pi))
            return abs(float(apart[0][0]) - turn) < float(apart[0][1]) / 2 and all(
                abs(by) < radius / 2 for by, radius in apart[1:]
            )
    return False


def strips_of(folder: Path, name: str) -> dict[str, list[Strip]]:
    """The zones in a figure's table."""
    pieces: dict[tuple[str, str], list[list[float]]] = {}
    with (folder / f"{name}.csv").open(encoding="utf-8", newline="") as file:
        for zone, piece, *numbers in list(csv.reader(file))[1:]:
            pieces.setdefault((zone, piece), []).append([float(x) for x in numbers])
    zones: dict[str, list[Strip]] = {}
    for (zone, _), rows in pieces.items():
        zones.setdefault(zone, []).append(Strip(*np.array(rows).T))
    return zones


def table_1(folder: Path) -> list[Row]:
    """Entries, misprints and the law of the determinant."""
    found = table1.motions()
    laws = [math.exp(-4 * math.pi * MASRI.xi / 0.94) * 0.75**4] * 3
    dets = [float(np.linalg.det(found[name].stability_matrix())) for name in list(found)[:3]]
    with (folder / "table1.csv").open(encoding="utf-8", newline="") as file:
        verdicts = [row["verdict"] for row in csv.DictReader(file)]
    misprints = sum(item.startswith("misprint") for item in verdicts)
    differ = verdicts.count("DIFFERS")
    return [
        Row("Table 1", "60 printed entries for two equispaced motions and an unequispaced one",
            f"{len(verdicts) - misprints - differ} agree to the printed digits, {misprints} are misprints, "
            f"{differ} differ", agreement(differ == 0), proven(proof_of_motions)),
        Row("Table 1", "det[P] must equal exp(−4πξ/r)·R₁²R₂² (a law, not in the paper)",
            f"{laws[0]:.6f}; computed {', '.join(f'{x:.6f}' for x in dets)}",
            agreement(bool(np.allclose(dets, laws, rtol=1e-9)))),
    ]  # fmt: skip


def figure_3(folder: Path) -> list[Row]:
    """The gap, the narrow zone at r = 1, the line dK/F0 = 37."""
    ends = [np.arange(start, start + 0.004, 0.0001) for start in (0.9590, 0.9790)]
    below, above = ([s.r for s in equispaced_zone(MASRI, r, 1500)] for r in ends)
    left, right = max(map(np.max, below)), min(map(np.min, above))
    (at_985,) = equispaced_zone(MASRI, np.array([0.985]), 1500)
    ratio, largest = near_one()
    line = np.arange(0.98, 1.2, 0.0005)
    on = line[equispaced_verdict(MASRI)(line, np.full_like(line, 37.0))]
    threes = strips_of(folder, "figure3").get("3", [])
    steps = np.arange(0.8, 1.2, 0.0005)
    at = np.array([any(s.contains(float(x), 37.0) for s in threes) for x in steps])
    where = [f"{steps[a]:.4f} to {steps[b - 1]:.4f}" for a, b in runs(at)]
    return [
        Row("Figure 3", "no stable equispaced motion for 0.960 < r < 0.985",
            f"none for {left:.4f} < r < {right:.4f}; above this range there is one in a thin band of loads, "
            f"{100 * (at_985.high[0] / at_985.low[0] - 1):.0f} % wide at r = 0.985",
            agreement(bool(left < 0.9605 and right >= 0.985))),
        Row("Figure 3", "a very narrow unequispaced zone near r = 1.00, its largest |λ| close to 1",
            f"at r = 1.00 it is {100 * ratio:.2f} % of dK/F₀ wide; max|λ| between {largest[0]:.4f} and "
            f"{largest[1]:.4f} in it", agreement(0 < ratio < 0.05)),
        Row("Figure 3", "equispaced motions continue past r = 1.04 at dK/F₀ = 37",
            f"stable from r = {on.min():.4f} to {on.max():.4f}", agreement(bool(on.max() > 1.04)),
            proven(lambda: proof_of_line(float(on.min()), float(on.max())))),
        Row("Figure 3", "three impacts a cycle at dK/F₀ = 37 (Masri's only example)",
            f"stable for r from {', '.join(where)}", agreement(bool(where))),
    ]  # fmt: skip


def near_one() -> tuple[float, tuple[float, float]]:
    """Relative width in clearance of the unequispaced zone at r = 1 of Figure 3, and its range of max|lambda|."""
    second = np.linspace(math.pi, 2 * math.pi, 20001)[1:-1]
    found = periodic_batch(MASRI, 1.0, [np.zeros_like(second), second], Pattern("RL"))
    good = (found.stable == 1) & (found.admissible == 1)
    if not good.any():
        return 0.0, (math.nan, math.nan)
    gap, largest = found.clearance[good], np.abs(found.multipliers[0, good])
    return float(gap.max() / gap.min() - 1), (float(largest.min()), float(largest.max()))


def figure_4(folder: Path) -> list[Row]:
    """tau depends on the load."""
    two = curve(0.999, np.array(POINTS))
    return [
        Row("Figure 4", "near r = 1 the phase τ depends on F₀",
            f"r = 0.999: dK/F₀ {two.clearance[1]:.4f} → {two.clearance[0]:.4f} moves sin τ "
            f"{two.sin_tau[1]:.3f} → {two.sin_tau[0]:.3f}",
            agreement(bool(abs(two.sin_tau[0] - two.sin_tau[1]) > 0.01))),
        Row("Figure 4", "large differences in sin τ from the older Fourier theory near r = 1",
            "the older theory's curves are not in the text", UNCHECKED),
    ]  # fmt: skip


def figure_6a(folder: Path) -> list[Row]:
    """Precision, the spike, and the largest multiplier."""
    steps = np.array([*(1 - np.array(NEAR)), 1.0, *(1 + np.array(NEAR)[::-1])])
    boundary = {kind: upper(steps, kind) for kind in ("double", "single")}
    wide = np.linspace(0.6, 1.45, 61)
    apart = np.abs(upper(wide, "single") / upper(wide, "double") - 1)
    smooth = np.polyval(np.polyfit(steps - 1, boundary["double"], 2), steps - 1)
    bump = np.abs(boundary["double"] / smooth - 1).max()
    try:
        exact = np.array([float(upper_boundary(EQUAL, float(x))) for x in steps])
        apart_40 = np.abs(boundary["double"] / exact - 1).max()
        digits = f"; 40-digit arithmetic by another route agrees to {apart_40:.0e}"
    except MissingExtraError:
        digits = "; 40-digit check left out (mpmath is not installed)"
    share, least, most = multipliers()
    at = boundary["double"][steps == 1.0][0]
    return [
        Row("Figure 6a", "single precision gives a clearly different upper boundary",
            f"in IEEE single precision it moves by at most {apart.max():.1e} (relative), which is not visible",
            agreement(bool(apart.max() > 0.01))),
        Row("Figure 6a", "double precision gives a spike of the zone at r = 1",
            f"no spike: at r = 1 the boundary is F₀/(dK) = {at:.8f}, and for |r − 1| = 1e−3 … 1e−9 it "
            f"deviates from a parabola by {bump:.1e}{digits}. The equations have no spike: the arithmetic "
            "caused it",
            agreement(bool(bump > 0.01))),
        Row("Figure 6a", "in the zone max|λ| lies between 0.996 and 0.999",
            f"it lies between {least:.3f} and {most:.4f}; {100 * share:.1f} % of the zone (in ln F₀/(dK) and r) "
            "has 0.996 to 0.999", agreement(share > 0.5)),
    ]  # fmt: skip


def upper(r: Array, precision: str) -> Array:
    """Upper boundary in F0/(dK) of the equispaced zone of Figure 6a."""
    zone = equispaced_zone(EQUAL, r, 160, precision)
    return 1 / np.array([min(s.low[s.r == x][0] for s in zone if x in s.r) for x in r])


def multipliers() -> tuple[float, float, float]:
    """Share of Figure 6a's zone with max|lambda| from 0.996 to 0.999, and its range."""
    r, p = (x.ravel() for x in np.meshgrid(np.linspace(0.6, 1.45, 120), grid(160)))
    both = equispaced_batch(EQUAL, r, clearance(r, p))
    largest = np.abs(np.concatenate([one.multipliers[0, is_good(one)] for one in both]))
    share = ((largest > 0.996) & (largest < 0.999)).mean()
    return float(share), float(largest.min()), float(largest.max())


def figures_6_to_8(folder: Path) -> list[Row]:
    """The zones compared with simulated sweeps of the load, sensitivity, and the scatter of R."""
    rows = []
    for name, rig, kinds in (
        ("figure6a", "equal", {"2e": ["double"]}), ("figure6b", "equal", {"2u": ["2u"]}),
        ("figure7", "equal", {"3": None, "4": None, "5": None}),
        ("figure8a", "unequal", {"2": ["2"], "3": ["3"]}), ("figure8b", "unequal", {"rest": None}),
    ):  # fmt: skip
        zones, sweeps = strips_of(folder, name), read_sweeps(folder, rig)
        for kind, names in kinds.items():
            chosen = names or [z for z in zones if kind == "rest" or len(z) == int(kind)]
            strips = [strip for zone in chosen for strip in zones.get(zone, [])]
            text = canvas.inside(sweeps, kind, strips)
            good, whole = (int(x) for x in text.split(" simulated")[0].split(" of "))
            more = "" if names else f" (patterns {', '.join(chosen)})"
            agree = bool(strips) and good > MOST_HOLDS * whole
            verdict = SIMULATED if agree else CONTRADICTED
            figure = f"Figure {name.removeprefix('figure')}"
            claim = f"the measured loads of {KINDS[kind][1]} lie in the computed zone"
            if kind == "rest":
                claim = "the measured sliding-like motions have their own zone (the paper has no theory)"
            found = f"no measurements in the text; {text}{more}"
            rows.append(Row(figure, claim, found, verdict))
    wall = upper(np.array([0.99, 1.01]), "double")
    soft, hard = (
        equispaced_zone(
            Oscillator(xi=EQUAL.xi, mu=EQUAL.mu, restitution=0.75 * f), np.array([0.8, 1.2]), 160
        )
        for f in (0.955, 1.045)
    )
    change = [abs(a.low[0] / b.low[0] - 1) for a, b in zip(soft, hard, strict=True)]
    rows += [
        Row("Figures 6–8", "near r = 1 small changes of the parameters have large effects",
            f"from r = 0.99 to 1.01 the upper boundary of 6a rises by a factor {wall[1] / wall[0]:.2f}",
            agreement(bool(wall[1] / wall[0] > 1.2))),
        Row("Figures 6–8", "R fell by about 9 % over the range, with a small effect on the zones",
            f"a change of R by 9 % moves the upper boundary of 6a by {100 * max(change):.0f} % at r = 0.8 or 1.2",
            agreement(max(change) < 0.2)),
        Row("Figures 6–8", "the measured bars themselves", "not in the text; the bars here are simulated",
            UNCHECKED),
        Row("Section 3", "natural frequency 19.87 Hz from K = 65.01 lbf/in and M = 1.61 lbf",
            f"{math.sqrt(65.01 * 386.0886 / 1.61) / (2 * math.pi):.2f} Hz; μ = 0.044/1.61 = "
            f"{0.044 / 1.61:.4f} (0.028 used; 0.044 ± 0.002 allows {0.042 / 1.61:.4f} to {0.046 / 1.61:.4f})",
            AGREES),
    ]  # fmt: skip
    return rows


def figure_9(folder: Path) -> list[Row]:
    """The four motions."""
    rows = []
    for panel, motion in motions().items():
        caption, sides, r, gap = PANELS[panel]
        good = there(motion, sides)
        rows.append(
            Row(f"Figure 9{panel}", caption, f"{sides} at r = {r:g}, F₀/(dK) = {1 / gap:.4g}: stable, max|λ| = "
                f"{abs(complex(motion.multipliers[0])):.4f}", agreement(good)))  # fmt: skip
    return rows


#: The statements of Section 4 on Figure 10, quoted, since they can be read in two ways.
AMPLIFIED = "“amplifications always occur” for “a slight decrease in r” from 1 (Section 4)"


def last_amplified(r: Array, attenuation: Array) -> float:
    """The largest r below 1 with X_max/A > 1; minus infinity if there is none."""
    above = (attenuation > 1) & np.isfinite(attenuation) & (r < 1)
    return float(r[above].max(initial=-math.inf))


def figure_10(folder: Path) -> list[Row]:
    """The frequency ratio at which the damper is best, and the behaviour on both sides of it."""
    r = np.arange(0.94, 1.0601, 0.002)
    best, rows = {}, []
    for name, osc in (("a", EQUAL), ("b", UNEQUAL)):

        def range_of(x: float, resolution: float, osc: Oscillator = osc) -> tuple[float, float]:
            found = damper.curve(osc, x, resolution).attenuation
            return float(found.min(initial=math.inf)), float(found.max(initial=-math.inf))

        least, most = np.array([range_of(float(x), 0.25) for x in r]).T
        k = int(np.argmin(least))
        above, below, lower = range_of(1.02, 1.0), range_of(0.98, 1.0), range_of(0.96, 1.0)
        best[name] = range_of(1.0, 1.0)[0]
        rows += [
            Row(f"Figure 10{name}", "X_max/A is least when r = 1",
                f"least at r = {r[k]:.3f} (steps of 0.002); {best[name]:.4f} at r = 1",
                agreement(abs(r[k] - 1) < 0.0021)),
            Row(f"Figure 10{name}", "a little above r = 1 the attenuation is less",
                f"least X_max/A at r = 1.02: {above[0]:.4f}", agreement(above[0] > best[name])),
            Row(f"Figure 10{name}", f"{AMPLIFIED}, read as: at every load",
                f"least X_max/A: {below[0]:.3f} at r = 0.98, {lower[0]:.3f} at r = 0.96; amplified at every "
                f"load only up to r = {last_amplified(r, least):.3f}", agreement(below[0] > 1)),
            Row(f"Figure 10{name}", f"{AMPLIFIED}, read as: at some loads",
                f"largest X_max/A: {below[1]:.3f} at r = 0.98, {lower[1]:.3f} at r = 0.96; amplified at some "
                f"load only up to r = {last_amplified(r, most):.3f}", agreement(below[1] > 1)),
        ]  # fmt: skip
    rows.append(
        Row("Figure 10", "equal coefficients of restitution are better",
            f"least X_max/A at r = 1: {best['a']:.4f} with equal, {best['b']:.4f} with unequal ones",
            agreement(best["a"] < best["b"])))  # fmt: skip
    return rows


def section_2(folder: Path) -> list[Row]:
    """The corrections of the appendix, and the rule of 3 %."""
    whole, none = (
        one for one in appendix.study()[:5] if len(one["corrected"]) in (0, 3)
    )  # fmt: skip
    phase_errors = json.loads((folder / "data" / "phase_errors.json").read_text(encoding="utf-8"))
    near = [row for row in phase_errors if row["error"] == 0.02]
    wrong, accepted = (
        [[100 * row[name][k] for row in near] for k in (0, 1)] for name in ("wrong", "accepted")
    )
    rule = "accepting a residual of 1.5 % instead of 3 % has virtually no effect"
    numbers = "phases misread by 0.02 rad, 3, 4, 5 impacts:"
    return [
        Row("(A6), (A7)", "the elements of [P] as printed",
            f"Table 1, column 3: max|λ| = {none['multipliers'][0]:.1f} as transcribed with lengths in F₀/K, "
            f"{none['largest_in_table_1']:.1f} with Table 1's unit (d = {appendix.TABLE_1:g}): S_6i in P_ia(3,1) "
            f"makes it depend on the unit of length; {whole['multipliers'][0]:.4f} in any unit with three "
            "corrections (printed: 0.93); see below", DIFFERS),
        Row("Section 2", f"{rule}, read as: on the verdicts on stability",
            f"{numbers} wrong among the accepted {', '.join(f'{x:.1f}' for x in wrong[0])} % (3 %), "
            f"{', '.join(f'{x:.1f}' for x in wrong[1])} % (1.5 %)",
            agreement(max(abs(a - b) for a, b in zip(*wrong, strict=True)) < 2)),
        Row("Section 2", f"{rule}, read as: on which motions are accepted",
            f"{numbers} accepted {', '.join(f'{x:.0f}' for x in accepted[0])} % (3 %), "
            f"{', '.join(f'{x:.0f}' for x in accepted[1])} % (1.5 %)",
            agreement(max(abs(a - b) for a, b in zip(*accepted, strict=True)) < 2)),
    ]  # fmt: skip


GROUPS: tuple[Callable[[Path], list[Row]], ...] = (
    table_1, section_2, figure_3, figure_4, figure_6a, figures_6_to_8, figure_9, figure_10,
)  # fmt: skip


def reproduce(folder: Path, resolution: float = 1.0) -> bool:
    """Write data/statements.json from the figures in the folder."""
    rows = [row._asdict() for group in GROUPS for row in group(folder)]
    write_text(
        folder / "data" / "statements.json", json.dumps(rows, indent=1, ensure_ascii=False) + "\n"
    )
    print(f"Statements of the paper: {counted([row['verdict'] for row in rows])}")
    return True


def counted(verdicts: Sequence[str]) -> str:
    """A text on how many statements have each verdict."""
    agree, differ, unchecked, simulated, contradicted = (
        verdicts.count(verdict) for verdict in (AGREES, DIFFERS, UNCHECKED, SIMULATED, CONTRADICTED)
    )
    return (
        f"{agree} agree, {differ} differ, {unchecked} cannot be checked; "
        f"{simulated + contradicted} are about measurements that the text does not give: for "
        f"{simulated} of them a simulation agrees with the computed zone"
    )
