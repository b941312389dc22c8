"""The free-free chain of hosts with a free mass in each, with 40 digits: a plain simulation to test the package.

The modes of the hosts have a closed form. A contact is found by a dense scan in double precision and
refined by Newton's method with 40 digits. All masses of hosts, springs and half gaps are 1, all free
masses 0.3, and no impact loses energy.
"""

import mpmath as mp
import numpy as np

DIGITS = 40
FREE = 0.3
"""Mass of a free mass."""
STEP = 5e-4
"""Step of the scan for a contact; shorter overlaps are missed."""
WINDOW = 0.25
"""Time that is scanned at once."""


def flight(a, b, omega, h):
    """Amplitudes and velocities of modes after a time h; the first mode has frequency 0."""
    turns = [mp.cos_sin(w * h) for w in omega[1:]]
    later = zip(a[1:], b[1:], omega[1:], turns, strict=True)
    pairs = [(x * c + v * s / w, v * c - x * w * s) for x, v, w, (c, s) in later]
    return [a[0] + b[0] * h, *(x for x, _ in pairs)], [b[0], *(v for _, v in pairs)]


def first_contact(shape, omega, modes, masses, longest):
    """Duration of a flight, cell and side of the contact at its end; None if the flight exceeds `longest`."""
    (a, b), (z, w) = modes, masses
    shapes, frequencies, amplitudes, rates, places, speeds = (
        np.array(values, float) for values in (shape, omega, a, b, z, w)
    )
    for begin in np.arange(0, longest, WINDOW):
        times = begin + np.arange(STEP, WINDOW + STEP, STEP)
        angles = np.outer(frequencies[1:], times)
        moving = amplitudes[1:, None] * np.cos(angles)
        moving += (rates[1:] / frequencies[1:])[:, None] * np.sin(angles)
        hosts = shapes @ np.vstack([amplitudes[0] + rates[0] * times, moving])
        apart = places[:, None] + speeds[:, None] * times - hosts
        beyond = np.abs(apart) > 1 + 1e-12
        if not beyond.any():
            continue
        at = int(np.argmax(beyond.any(axis=0)))
        found = []
        for cell in np.flatnonzero(beyond[:, at]):
            h, side = mp.mpf(times[at]), 1 if apart[cell, at] > 0 else -1
            for _ in range(60):
                x, v = (mp.fdot(shape[cell], part) for part in flight(a, b, omega, h))
                change = (side * (z[cell] + w[cell] * h - x) - 1) / (side * (w[cell] - v))
                h -= change
                if abs(change) < mp.mpf(10) ** (4 - DIGITS):
                    break
            assert times[at] - 1.5 * STEP < h <= times[at]
            found.append((h, int(cell), side))
        return min(found)
    return None


def simulate(cells, speed, end):
    """Times, cells and sides of all impacts until `end`; the first host has an initial speed, others have none."""
    with mp.workdps(DIGITS):
        ks, places = range(cells), [2 * i + 1 for i in range(cells)]
        size = [mp.sqrt(mp.mpf(2 if k else 1) / cells) for k in ks]
        shape = [[size[k] * mp.cos(mp.pi * k * p / (2 * cells)) for k in ks] for p in places]
        omega = [2 * mp.sin(mp.pi * k / (2 * cells)) for k in ks]
        a, b = [mp.mpf(0)] * cells, [speed * c for c in shape[0]]
        z, w = [mp.mpf(0)] * cells, [mp.mpf(0)] * cells
        mass, t, impacts = mp.mpf(FREE), mp.mpf(0), []
        while True:
            hit = first_contact(shape, omega, (a, b), (z, w), end - float(t))
            if hit is None or t + hit[0] > end:
                return impacts
            h, cell, side = hit
            a, b = flight(a, b, omega, h)
            z = [x + v * h for x, v in zip(z, w, strict=True)]
            approach = w[cell] - mp.fdot(shape[cell], b)
            w[cell] -= 2 / (1 + mass) * approach
            b = [
                v + c * 2 * mass / (1 + mass) * approach
                for v, c in zip(b, shape[cell], strict=True)
            ]
            t += h
            impacts.append((t, cell, side))
