"""`vibroimpact decay`: the peaks and the damping of free vibration."""

from __future__ import annotations

from .study import command

DESCRIPTION = """Simulate free vibration from an initial displacement or velocity, for one or several
clearances, for the &decay cases of namelist files or for the case given by the options. The
peaks of the primary mass, the damping from each peak to the next on the same side, and the
energy are written to DIR/NAME.csv, one row for each peak, or in another format; --plot also
writes a picture. NAME is "decay" for the case of the options."""
EXAMPLE = (
    "vibroimpact decay --xi .005 --mu .1 --restitution .75 --clearance .3 .7 1.5 "
    "--cycles 20 -o results"
)

arguments, request, run = command("decay")
