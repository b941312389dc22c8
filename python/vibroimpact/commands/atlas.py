"""`vibroimpact atlas`: all zones of a window; the patterns need not be given."""

from __future__ import annotations

from .study import command

DESCRIPTION = """Find all zones of the plane (r, d K/F0), or of two parameters of a structure, in which motions
of any pattern, up to a number of impacts and cycles, are stable and admissible, for the &atlas
cases of namelist files or for the case given by the options. The boundaries are written to
DIR/NAME.csv, one row for each vertex with the pattern and the type of its piece, or in another
format; --plot also writes a picture. NAME is "atlas" for the case of the options. The points
of the survey are counted by outcome: periodic within the limits, beyond them, without impacts,
chaotic, not settled. Motions on which simulations settle and that lie in no zone are listed;
the exit status is then 1."""
EXAMPLE = (
    "vibroimpact atlas --xi .0114 --mu .028 --restitution .75 --r 1.0 1.1 --clearance 20 60 "
    "--max-impacts 3 --survey 20 -o results"
)

arguments, request, run = command("atlas")
