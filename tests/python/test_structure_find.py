"""Motions found by a search of a structure: those of the oscillator, mirror images, doubled periods."""

import numpy as np
import pytest
import vibroimpact as vi

POINTS = [
    (0.0128, 0.1, 0.75, 1.05, 8.0),
    (0.0043, 0.147, 0.65, 0.836, 14.47),
    (0.0255, 0.0463, 0.78, 0.917, 27.2),
    (0.0429, 0.1937, 0.7833, 0.8855, 10.2346),
    (0.007, 0.0626, (0.82, 0.73), 0.8376, 7.32),
]


def sizes(motions):
    """Cycles, number of impacts and logarithm of the leading multiplier of each motion without rest, in order."""
    return sorted(
        (motion.cycles, len(motion.phases), float(np.log(abs(motion.multipliers).max())))
        for motion in motions
        if not len(getattr(motion, "rests", ())) and len(motion.phases) <= 4
    )


def search(point, **options):
    return vi.find(
        point.structure, point.load, **{"max_impacts": 4, "max_cycles": 2, "states": 0, **options}
    )


@pytest.mark.parametrize(("xi", "mu", "restitution", "r", "clearance"), POINTS)
def test_the_two_masses_of_1983_have_the_motions_of_the_oscillator(
    xi, mu, restitution, r, clearance
):
    """Every motion of one search is in the other one, also after a flip: the sides RLRL of a doubled RL."""
    osc = vi.Oscillator(xi=xi, mu=mu, restitution=restitution)
    wanted = sizes(vi.find(osc, r, clearance, max_impacts=4, states=0, releases=0))
    found = sizes(search(osc.at(r, clearance)))
    assert len(found) == len(wanted) >= 7
    for one, other in zip(found, wanted, strict=True):
        assert one == pytest.approx(other, abs=1e-5)


@pytest.mark.parametrize(
    ("frequency", "cosine", "cycles"), [(0.6, 0.36, 1), (1.1, 0.36, 3), (0.7, 0.8, 1)]
)
def test_an_order_that_repeats_itself_has_motions_of_its_own(frequency, cosine, cycles):
    """Two unequal impacts on one wall: stable motions, on which simulations stay."""
    wall = vi.Structure([1], [0.04], [1], [vi.Gap([1], 1, 0.9)])
    load = vi.Load(frequency, cosine=[cosine])
    found = vi.find(wall, load, states=0, max_cycles=3, guesses=12)
    (motion,) = (motion for motion in found if len(motion.phases) == 2 and motion.stable)
    assert motion.cycles == cycles
    assert np.ptp(motion.speeds) > 0.1
    start = motion.phases[0] / frequency
    run = vi.simulate(wall, load, cycles=200, state=(motion.q, motion.q_dot), start=start)
    np.testing.assert_allclose(np.sort(run.events["speed"][-2:]), np.sort(motion.speeds), rtol=1e-9)


def two_particles(harmonics=1):
    """A host with a slot and a stop on both sides; under two harmonics there are no mirror images."""
    gaps = [
        vi.Gap([sign * x for x in direction], opening, restitution)
        for direction, opening, restitution in (([-1, 1, 0], 0.5, 0.8), ([-1, 0, 1], 0.7, 0.6))
        for sign in (1, -1)
    ]
    load = [[0.1, 0, 0], [0.02, 0, 0]][:harmonics]
    return vi.Structure([1, 0.1, 0.05], [0.05, 0, 0], [1, 0, 0], gaps), vi.Load(1.04, sine=load)


def mirrored(motion, other):
    """Whether another motion has the opposite gaps half a load cycle later."""
    if motion.cycles != other.cycles or len(motion.gaps) != len(other.gaps):
        return False
    image = sorted(
        (gap ^ 1, round(speed, 6))
        for gap, speed in zip(motion.gaps.tolist(), motion.speeds.tolist(), strict=True)
    )
    known = sorted(
        (gap, round(speed, 6))
        for gap, speed in zip(other.gaps.tolist(), other.speeds.tolist(), strict=True)
    )
    later = (motion.phases[0] + np.pi - other.phases[other.gaps == (motion.gaps[0] ^ 1)]) / (
        2 * np.pi
    )
    return image == known and bool((abs(later - np.round(later)) < 1e-6).any())


def test_mirror_images_are_found():
    found = vi.find(*two_particles(), max_impacts=4, max_cycles=1, states=0, guesses=16)
    assert len(found) > 2
    for motion in found:
        assert any(mirrored(motion, other) for other in found)
    found = vi.find(*two_particles(2), max_impacts=4, max_cycles=1, states=0, guesses=16)
    assert not all(any(mirrored(motion, other) for other in found) for motion in found)


@pytest.mark.slow
def test_lines_reach_what_few_times_do_not():
    """With few sets of times, the lines through the motions found reach all motions found from many sets."""
    point = vi.Oscillator(xi=0.0429, mu=0.1937, restitution=0.7833).at(0.8855, 10.2346)
    assert len(search(point, guesses=16)) == len(search(point, guesses=200))


def test_a_search_finds_nothing_twice_and_only_what_stays_open():
    found = vi.find(*two_particles(), max_impacts=3, max_cycles=2, states=4, guesses=16)
    for i, motion in enumerate(found):
        assert motion.consistent
        assert motion.admissible
        assert not any(vi.same_motion(motion, other) for other in found[:i])
