"""`vibroimpact atlas`: all zones of a window, found without being told the patterns."""

from __future__ import annotations

from .study import command

DESCRIPTION = """Find all zones of the plane (r, d K/F0) in which motions of any pattern, up to a number of
impacts and cycles, are stable and admissible, for the &atlas cases of namelist files or for
the one that the options name. The boundaries are written to DIR/NAME.csv, one row a vertex
with the pattern and the type of its piece, or in another form; with --plot a picture stands
beside them. NAME is "atlas" for the case of the options. What became of the points of the
survey is counted: periodic within the limits, beyond them, without impacts, chaotic, not
settled. Motions that simulations settle on and that lie in no zone are listed, and give exit
status 1."""
EXAMPLE = (
    "vibroimpact atlas --xi .0114 --mu .028 --restitution .75 --r 1.0 1.1 --clearance 20 60 "
    "--max-impacts 3 --survey 20 -o results"
)

arguments, request, run = command("atlas")
