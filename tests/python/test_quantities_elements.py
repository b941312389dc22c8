"""Response quantities of structures with stops and friction: energy balance, and closed forms."""

import math

import numpy as np
import pytest
import vibroimpact as vi
from shared_structures import with_elements

CASES = with_elements()


@pytest.mark.parametrize("name", CASES)
def test_energy_of_a_motion(name):
    """Over a period the work of the load equals the losses in dashpots, impacts and friction."""
    structure, load = CASES[name]
    found = vi.exact(structure, load, vi.simulate(structure, load, cycles=500)).quantities()
    losses = found.damping_loss + found.impact_loss + found.friction_loss
    assert found.work == pytest.approx(losses, rel=1e-11)
    assert abs(found.energy_change) < 1e-11 * found.work
    assert (found.friction_loss > 0) == bool(structure.friction)


@pytest.mark.parametrize("seed", range(6))
def test_energy_of_windows(seed):
    """The balance of any window, with belts, preloads and stops of both kinds."""
    rng = np.random.default_rng(seed)
    stops = [
        vi.Stop([1, 0], 0.3, stiffness=20, damping=1, preload=0.2 * rng.random()),
        vi.Stop([0, 1], 0.4, stiffness=30, damping=2, release="force"),
    ]
    rubbing = [
        vi.Friction([1, -1], 0.1, stick=0.15, speed=rng.normal()),
        vi.Friction([0, 1], 0.05),
    ]
    structure = vi.Structure(
        [1.0, 0.7], [0.02, 0.01], [[2, -1], [-1, 1.5]], [*stops, vi.Gap([-1, 0], 0.5, 0.6)], rubbing
    )
    load = vi.Load(1.2, sine=[0.8, 0.4], constant=[0.1, -0.2])
    run = vi.simulate(structure, load, cycles=8)
    assert {"touch", "let_go", "impact"} <= set(run.events["kind"])
    for window in ((0.0, run.end), np.sort(run.start + rng.random(2) * run.end)):
        found = run.quantities(window=window)
        losses = found.damping_loss + found.impact_loss + found.friction_loss
        assert found.energy_change == pytest.approx(found.work - losses, abs=1e-12)
        assert found.friction_loss > 0


def test_friction_takes_its_force_times_the_way():
    """For a mass that slides to rest, friction takes the travel between the extremes times the force."""
    mass = vi.Structure([1], [0], [1e4], friction=[vi.Friction([1], slip=1)])
    run = vi.simulate(mass, duration=0.2, state=([0.85e-3], [0]))
    found = run.quantities()
    way = 1e-3 * (0.85 + 2 * 0.65 + 2 * 0.45 + 2 * 0.25 + 0.05)
    assert found.friction_loss == pytest.approx(way, rel=1e-12)
    assert found.energy_change == pytest.approx(-way, rel=1e-9)
    assert found.work == 0


def test_a_belt_gives_what_friction_takes():
    """Stick-slip without damping: in a period the work of the belt equals the loss of friction."""
    belt = vi.Structure([1], [0], [1], friction=[vi.Friction([1], 0.6, stick=1.0, speed=0.2)])
    motion = vi.exact(belt, vi.Load.none(), vi.simulate(belt, duration=100))
    found = motion.quantities()
    assert found.work == pytest.approx(found.friction_loss, rel=1e-11)
    # slip against the belt from x = 1 to -1 + 2 * 0.6: the travel relative to the belt
    slip = 2 * math.pi - 2 * math.atan(0.4 / 0.2)
    assert found.friction_loss == pytest.approx(0.6 * (0.8 + 0.2 * slip), rel=1e-11)


def test_elastic_contact_keeps_energy():
    """A stop without dashpots returns what it took; in between its spring stores it."""
    stop = vi.Stop([1], 0.0, stiffness=1e6)
    mass = vi.Structure([100], [0], [1e4], gaps=[stop])
    run = vi.simulate(mass, duration=0.3, state=([0], [1]))
    middle = 0.5 * 0.0312600152681
    for end in (middle, 0.1, 0.3):
        assert abs(run.quantities(window=(0.0, end)).energy_change) < 1e-10
