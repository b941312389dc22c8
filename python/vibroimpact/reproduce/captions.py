"""The texts of the report."""

from __future__ import annotations

INTRODUCTION = (
    "<p>The scan that was at hand has no pictures, so each figure is computed from its caption's "
    "parameters and compared with what the text says about it. Zones are drawn where a motion is "
    "consistent (its phases solve the equations), admissible (the masses approach at each impact, "
    "and the free mass stays between the walls) and stable (all multipliers inside the unit "
    "circle). Ordinates are logarithmic, as the zones span two decades.</p> <p>In place of the "
    "measured bars there is a numerical experiment: at a fixed frequency the load is raised step "
    "by step and lowered again, the motion carries over, each load is held for two minutes of the "
    "rig's time (120 s at 19.87 Hz), no impact is missed, and the bar shows the loads at which "
    "the hold ended on the motion. A free mass that has come to stay clear of the walls is "
    "pushed, as it would be on a bench. Ticks inside a bar are where rising and falling load "
    "differ.</p>"
)

PHASE_ERRORS = (
    "<p>With more than two impacts the paper read the phases off a record, solved the "
    "overdetermined equations by least squares and accepted a relative residual below 3\u00a0%. Here "
    "exact motions along a line through each zone have their phases misread by normally "
    "distributed errors. Wrong means that the verdict on stability is not that of the exact "
    "motion. A fiftieth of a division of the paper's records is 0.33 ms.</p>"
)

#: Title, caption, and whether the picture takes the whole width.
CAPTIONS: dict[str, tuple[str, str, bool]] = {
    "figure3": (
        "Figure 3: two and three impacts a cycle",
        "Zones in dK/F₀ over r. The dashed line is the one along which Masri computed, the cross "
        "the point of Table 1. The zone of two unequispaced impacts goes on as a thread past r = "
        "1, below the equispaced one.",
        False,
    ),
    "figure4a": (
        "Figure 4a: clearance and ratio of durations",
        "Two impacts a cycle at constant r, stability ignored. The ratio is that of the duration "
        "from the right to the left wall to the other one; above 1 lie the mirror images. Dotted: "
        "the free mass would have to pass through a wall. Which quantity is on which axis follows "
        "from the text: less dK/F₀ is to the left.",
        False,
    ),
    "figure4b": (
        "Figure 4b: phase and ratio of durations",
        "The same motions. A larger load takes B to B′ in Figure 4a and A to A′ here: τ depends "
        "on the load, most of all near r = 1, where a tiny change of load changes the durations "
        "much.",
        False,
    ),
    "figure6a": (
        "Figure 6a: two equispaced impacts, equal restitution",
        "Left: the zone in double precision, in single precision (dotted, on top of it) and the "
        "experiment. Right: the upper boundary about r = 1, down to |r − 1| = 1e−9: there is no "
        "spike.",
        True,
    ),
    "figure6b": (
        "Figure 6b: two unequispaced impacts, equal restitution",
        "The zone adjoins that of Figure 6a: the equispaced motion loses its symmetry there.",
        False,
    ),
    "figure7": (
        "Figure 7: three, four and five impacts, equal restitution",
        "Zones traced by Newton's method from the motions that the experiment ended on. Each "
        "pattern comes with its mirror image, which has the same zone. The thin zones are far "
        "narrower than the steps of the load.",
        False,
    ),
    "figure8a": (
        "Figure 8a: two and three impacts, unequal restitution",
        "R₁ = 0.75 (steel), R₂ = 0.61 (tape). Two impacts have a second, thin zone within that of "
        "three. The letters are the points of Figure 9, chosen here.",
        False,
    ),
    "figure8b": (
        "Figure 8b: accumulation and rest",
        "The sliding-like motions, outside the paper's theory: impacts on the tape accumulate and "
        "the free mass rests on it until the contact force ends. Zones of exact motions with 1, "
        "2, 3, 4 impacts on steel; bars outside them are motions with several rests or other "
        "orders of impacts. The experiment ends at the load where its levels end.",
        False,
    ),
    "figure9": (
        "Figure 9: load and acceleration of the primary mass",
        "The four kinds of motion, exact, at points inside their zones (the paper does not give "
        "its points). A spike is an impact; its length is the change of velocity.",
        True,
    ),
    "figure10a": (
        "Figure 10a: the damper, equal restitution",
        "Largest deflection relative to that without impacts. Lines: stable motions with two "
        "impacts a cycle; dots: holds of the experiment.",
        False,
    ),
    "figure10b": (
        "Figure 10b: the damper, unequal restitution",
        "R₁ = 0.61, R₂ = 0.75, the mirror image of the walls of Figure 8.",
        False,
    ),
}
