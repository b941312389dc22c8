"""`vibroimpact chart`: the motions of a pattern on a grid."""

from __future__ import annotations

from .study import command

DESCRIPTION = """Compute all motions of a pattern on a grid of the plane (r, d K/F0), or those of a structure
over two of its parameters, with their stability, for the &chart cases of namelist files or for
the case given by the options. They are written to DIR/NAME.csv, one row for each motion, or in
another format, which also contains the phases and all multipliers and can be read by
vibroimpact.load; --plot also writes a picture. NAME is "chart" for the case of the options."""
EXAMPLE = (
    "vibroimpact chart --xi .0114 --mu .028 --restitution .75 --sides RL --r 0.9 1.1 21 "
    "--clearance 5 100 16 --spacing geometric --symmetric yes -o results"
)

arguments, request, run = command("chart")
