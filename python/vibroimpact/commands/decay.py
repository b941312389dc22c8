"""`vibroimpact decay`: the peaks and the damping of free vibration."""

from __future__ import annotations

from .study import command

DESCRIPTION = """Let the system vibrate freely from an initial displacement or velocity, for one or several
clearances: for the &decay cases of namelist files or for the one that the options name. The
peaks of the primary mass, the damping from each to the next on the same side, and the energy
are written to DIR/NAME.csv, one row a peak, or in another form; with --plot a picture stands
beside them. NAME is "decay" for the case of the options."""
EXAMPLE = (
    "vibroimpact decay --xi .005 --mu .1 --restitution .75 --clearance .3 .7 1.5 "
    "--cycles 20 -o results"
)

arguments, request, run = command("decay")
