"""The oscillators of the paper, and how random examples are drawn."""

import os

import numpy as np
import vibroimpact as vi
from hypothesis import HealthCheck, settings

EPS = np.finfo(float).eps
TURN = 2.0 * np.pi
#: Table 1 and Figure 3; Figure 6; Figure 8.
TABLE = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
FIGURE6 = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
RIG = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))


def law(examples):
    """Return hypothesis settings: the same examples in every run, no limit of time on one.

    VIBROIMPACT_EXAMPLES sets the largest number of examples.
    """
    examples = min(examples, int(os.environ.get("VIBROIMPACT_EXAMPLES", examples)))
    health = [HealthCheck.filter_too_much, HealthCheck.too_slow, HealthCheck.data_too_large]
    return settings(
        max_examples=examples, deadline=None, derandomize=True, suppress_health_check=health
    )
