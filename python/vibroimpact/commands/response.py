"""`vibroimpact response`: the greatest displacement along the frequency."""

from __future__ import annotations

from .study import command

DESCRIPTION = """Find max|X|/A along r for a clearance or a load, from many initial states, for the &response
cases of namelist files or for the one that the options name. Its least and greatest value
over the attractors that coexist are written to DIR/NAME.csv, one row a frequency ratio, or
in another form, of which netCDF and JSON also hold what each state came to; with --plot a
picture stands beside them. NAME is "response" for the case of the options."""
EXAMPLE = (
    "vibroimpact response --xi .0114 --mu .028 --restitution .75 --r .95 1.05 21 "
    "--inverse-clearance .03 --states 6 -o results"
)

arguments, request, run = command("response")
