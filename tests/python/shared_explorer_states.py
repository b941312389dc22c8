"""States of the explorer that several tests use."""

import vibroimpact as vi
from vibroimpact.explorer.state import Run, State

RUN = Run(0.1, 2.0, -3.0, 4.0, 5.5, 6.0, 2.0)
#: A state with every field set, at a point with a motion with rest, and a state at a point with many motions.
STATES = {
    "start": State(run=RUN, line=(1.04, 5.0, 1.04, 60.0)),
    "rest": State(R2=0.61, r=0.9, clearance=6.0, run=RUN, line=(0.85, 3.0, 0.95, 9.0)),
    "many": State(r=0.96, clearance=20.0, patterns=(vi.Pattern("RL"), vi.Pattern("RRL")),
                  run=RUN, show="run", line=(0.96, 5.0, 0.96, 60.0)),
}  # fmt: skip
