"""`vibroimpact zone`: where the motions of a pattern are stable and admissible."""

from __future__ import annotations

from .study import command

DESCRIPTION = """Find the zones of the plane (r, d K/F0) in which a pattern has stable, admissible motions,
for the &zone cases of namelist files or for the case given by the options. The boundaries
are written to DIR/NAME.csv, one row for each vertex with the type of its piece, or in another
format; --plot also writes a picture. NAME is "zone" for the case of the options."""
EXAMPLE = (
    "vibroimpact zone --xi .0114 --mu .028 --restitution .75 --sides RL --symmetric yes --r 0.8 1.2 "
    "--clearance 2 200 -o results"
)

arguments, request, run = command("zone")
