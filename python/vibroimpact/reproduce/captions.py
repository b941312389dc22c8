"""The texts of the report."""

from __future__ import annotations

INTRODUCTION = (
    "<p>Our scan of the paper lacks the figures, so each figure is computed from the parameters "
    "in its caption and compared with what the text says about it. Zones are drawn where a motion "
    "is consistent (its phases solve the equations), admissible (the masses approach at each "
    "impact, and the free mass stays between the walls) and stable (all multipliers lie inside "
    "the unit circle). Figures 1, 2 and 5 of the paper show the model, the notation and the rig; "
    "they contain nothing to compute. The vertical axes are logarithmic because the zones span two "
    "decades.</p> "
    "<p>The text does not give the measurements of the paper. The bars in Figures 6 to 8 and the "
    "marks in Figure 10 are therefore simulations made here, not measurements: at a fixed "
    "frequency the load is raised step by step and lowered again; each level is held for two "
    "minutes of the rig's time (120 s at 19.87 Hz) and starts from the state at the end of the "
    "level before it. No impact is missed. A bar spans the loads at which the hold ended on the "
    "motion. If the free mass comes to rest clear of the walls, it is given a velocity, like a push "
    "on the test rig. Ticks inside a bar show where rising and falling load differ. A simulation "
    "that lies in a computed zone confirms the computation, not the paper's experiment.</p>"
)

PHASE_ERRORS = (
    "<p>For more than two impacts the paper took the phases from a record, solved the "
    "overdetermined equations by least squares, and accepted a relative residual below 3\u00a0%. "
    "Here the phases of exact motions along a line through each zone are given normally "
    "distributed errors. Wrong means that the verdict on stability differs from that of the "
    "exact motion. A fiftieth of a division of the paper's records is 0.33 ms.</p>"
)

#: Title, caption, and whether the picture uses the full width.
CAPTIONS: dict[str, tuple[str, str, bool]] = {
    "figure3": (
        "Figure 3: two and three impacts a cycle",
        "Zones in the plane of r and dK/F₀. The dashed line marks Masri's computations; the "
        "cross is the point of Table 1. The zone of two unequispaced impacts continues as a thin "
        "strip past r = 1, below the equispaced zone.",
        False,
    ),
    "figure4a": (
        "Figure 4a: clearance and ratio of durations",
        "Two impacts a cycle at constant r, stability ignored. The ratio is the duration from the "
        "right to the left wall over the duration from left to right; the mirror images lie above "
        "1. Dotted: the free mass would have to pass through a wall. The assignment of the axes "
        "follows from the text: smaller dK/F₀ is to the left.",
        False,
    ),
    "figure4b": (
        "Figure 4b: phase and ratio of durations",
        "The same motions. A larger load moves B to B′ in Figure 4a and A to A′ here: τ depends "
        "on the load, most strongly near r = 1, where a very small change of load changes the "
        "durations considerably.",
        False,
    ),
    "figure6a": (
        "Figure 6a: two equispaced impacts, equal restitution",
        "Left: the zone in double precision, the zone in single precision (dotted, on top of it) "
        "and the simulated holds. Right: the upper boundary near r = 1, down to |r − 1| = 1e−9; "
        "there is no spike. The thin strip near r = 1.49 and F₀/(dK) = 0.055 is the tip of a "
        "second zone of the equispaced motion, bounded by a fold and a Neimark–Sacker curve; it "
        "begins at r = 1.487 and widens to the right of the window.",
        True,
    ),
    "figure6b": (
        "Figure 6b: two unequispaced impacts, equal restitution",
        "The zone adjoins that of Figure 6a: the equispaced motion loses its symmetry at the "
        "common boundary.",
        False,
    ),
    "figure7": (
        "Figure 7: three, four and five impacts, equal restitution",
        "Zones traced by Newton's method from the motions at the ends of the simulated holds. "
        "Each pattern has a mirror image with the same zone. The thin zones are much narrower "
        "than the steps of the load.",
        False,
    ),
    "figure8a": (
        "Figure 8a: two and three impacts, unequal restitution",
        "R₁ = 0.75 (steel), R₂ = 0.61 (tape). Two impacts a cycle have a second, thin zone within "
        "the zone of three. The letters mark the points of Figure 9, which are chosen here.",
        False,
    ),
    "figure8b": (
        "Figure 8b: accumulation and rest",
        "The sliding-like motions, which the paper's theory does not cover: impacts on the tape "
        "accumulate, and the free mass rests on it until the contact force ends. Zones of exact "
        "motions with 1, 2, 3 and 4 impacts on steel. Bars outside the zones are motions with "
        "several rests or other orders of impacts. The bars end at the highest simulated load.",
        False,
    ),
    "figures6to8": (
        "Figures 6 to 8 with bands",
        "Uncertainty of the boundaries if the damping ratio, the gap and the coefficients of "
        "restitution are known only as accurately as the paper states. Along the normal of a "
        "boundary, 95\u00a0% of the displaced boundaries lie in the band. Crosses mark where first "
        "derivatives do not describe it: at corners, along zones so thin that they vanish for some "
        "rigs, and along the zone of RL*, which disappears if R₁ alone falls by 1\u00a0%.",
        True,
    ),
    "figure9": (
        "Figure 9: load and acceleration of the primary mass",
        "The four kinds of motion, exact, at points inside their zones (the paper does not give "
        "its points). Each spike is an impact; its length is proportional to the change of "
        "velocity; the legend of each panel gives the change of velocity of the longest spike.",
        True,
    ),
    "figure10a": (
        "Figure 10a: the damper, equal restitution",
        "Largest displacement relative to that without impacts. Lines: stable motions with two "
        "impacts a cycle. Marks: simulated holds at the same r, filled for two impacts a cycle, "
        "open for other motions.",
        False,
    ),
    "figure10b": (
        "Figure 10b: the damper, unequal restitution",
        "R₁ = 0.61, R₂ = 0.75, the mirror image of the walls of Figure 8. Lines and marks as in "
        "Figure 10a.",
        False,
    ),
}
