"""A window of zones, points in it and motions on their boundaries."""

import math

import numpy as np
from vibroimpact.motions.exact import newton

WINDOW = ((0.8, 1.2), (2, 200))


def random_points(count, seed):
    random = np.random.default_rng(seed)
    return random.uniform(*WINDOW[0], count), np.exp(random.uniform(*np.log(WINDOW[1]), count))


def distance(zone, r, clearance):
    """Distance to the nearest vertex of a boundary, with the window as the unit square."""
    scale = np.array([np.ptp(zone.r), np.ptp(np.log(zone.clearance))])
    place = np.array([r, math.log(clearance)])
    rings = [np.c_[ring[:, 0], np.log(ring[:, 1])] for ring in zone.loops]
    return min((np.abs((ring - place) / scale).max(axis=1).min() for ring in rings), default=1.0)


def motion_at(zone, piece, j):
    """The exact motion of a vertex."""
    return newton(
        zone.osc, piece.r[j], piece.clearance[j], 1.0, zone.pattern,
        piece.x_over_D[:, j] * piece.clearance[j], piece.theta[:, j],
    )  # fmt: skip
