"""`vibroimpact chart`: the motions of a pattern on a grid."""

from __future__ import annotations

from .study import command

DESCRIPTION = """Compute all motions of a pattern on a grid of the plane (r, d K/F0), with their stability,
for the &chart cases of namelist files or for the one that the options name. They are
written to DIR/NAME.csv, one row a motion, or in another form, which also holds the phases
and all multipliers and is read by vibroimpact.load; with --plot a picture stands beside
them. NAME is "chart" for the case of the options."""
EXAMPLE = (
    "vibroimpact chart --xi .0114 --mu .028 --restitution .75 --sides RL --r 0.9 1.1 21 "
    "--clearance 5 100 16 --spacing geometric --symmetric yes -o results"
)

arguments, request, run = command("chart")
