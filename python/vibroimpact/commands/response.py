"""`vibroimpact response`: the largest displacement against the frequency ratio."""

from __future__ import annotations

from .study import command

DESCRIPTION = """Find max|X|/A along r for a clearance or a load, from many initial states, for the &response
cases of namelist files or for the case given by the options. The smallest and the largest
value over the coexisting attractors are written to DIR/NAME.csv, one row for each frequency
ratio, or in another format (netCDF and JSON also contain the motion that each initial state
reaches); --plot also writes a picture. NAME is "response" for the case of the options."""
EXAMPLE = (
    "vibroimpact response --xi .0114 --mu .028 --restitution .75 --r .95 1.05 21 "
    "--inverse-clearance .03 --states 6 -o results"
)

arguments, request, run = command("response")
