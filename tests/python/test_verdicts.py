"""Verdicts close to rounding: near bifurcations, and where masses separate slowly after an impact."""

import numpy as np
import pytest
import vibroimpact as vi
from reference_motion import excess
from shared_motions import after_impact, searched

#: Oscillator, r and clearance near folds, pitchforks, flips and Neimark-Sacker points.
PLACES = [
    (vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75), 0.95, 30.0),
    (vi.Oscillator(xi=0.0025, mu=0.0405, restitution=(0.387, 0.562)), 0.7628, 4.0),
    (vi.Oscillator(xi=0.02, mu=0.1, restitution=(0.8, 0.5)), 1.1, 2.0),
]
TYPES = ("fold", "pitchfork", "flip", "neimark_sacker")
#: Relative distance from a bifurcation beyond which there is always a verdict.
CERTAIN = 5e-9


def bifurcations(osc, r, clearance):
    """The bifurcations along the first motions that a search finds, up to three times the clearance."""
    found = vi.find(
        osc, r, clearance, max_impacts=3, max_cycles=1, guesses=24, states=4, releases=0
    )
    for motion in [motion for motion in found if not motion.pattern.has_rest][:3]:
        line = vi.branch(motion, "clearance", (clearance / 2, 3 * clearance), max_points=300)
        yield from (point for point in line.special_points if point.type in TYPES)


@pytest.mark.slow
@pytest.mark.parametrize("place", PLACES)
def test_stable_is_true_or_none_beside_a_bifurcation(place):
    """At relative distances of 1e-6 to 1e-14 from a bifurcation `stable` is correct, or None within 5e-9.

    The reference is the motion solved with 50 digits.
    """
    osc, r, _ = place
    verdicts = none = 0
    for point in bifurcations(*place):
        for distance in 10.0 ** np.arange(-6, -14.5, -1):
            for side in (1, -1):
                try:
                    motion = vi.exact(osc, r, point.clearance * (1 + side * distance), point.motion)
                except vi.errors.SingularError:  # beyond a fold
                    continue
                if motion.stable is None:
                    assert distance < CERTAIN
                    none += 1
                    continue
                verdicts += 1
                assert motion.stable == (excess(motion) < 0)
    assert verdicts > 20
    assert none > 0


def test_stable_beside_a_pitchfork_of_equispaced_impacts():
    """Above the pitchfork `stable` of the symmetric motion is never False, and below it never True.

    Found by an independent program; at 1.857e-11 below it the multiplier is 1 + 3.57e-10.
    """
    osc = vi.Oscillator(
        xi=0.0005606787567717536, mu=0.014046975668913076, restitution=0.8307133294500499
    )
    r, place = 1.0112241944274716, 58.584229646340845
    for distance in [1.857e-11, *10.0 ** np.arange(-6, -15, -0.5)]:
        for side in (1, -1):
            clearance = place * (1 + side * distance)
            guess = vi.equispaced(osc, r, clearance)[0]
            motion = vi.exact(osc, r, clearance, guess)
            if motion.stable is None:
                assert distance < CERTAIN
            else:
                assert motion.stable == (side > 0)
                assert motion.stable == (excess(motion) < 0)


def test_masses_that_leave_an_impact_together_must_part():
    """With R = 0 `admissible` is the sign of the gap's acceleration after the impact, and None at rounding.

    Found by an independent program: the acceleration passes through zero at this clearance.
    """
    osc = vi.Oscillator(
        xi=0.012990423377549564, mu=1.1610183760956951, restitution=(0.0, 0.3767430040877141)
    )
    r, place, pattern = 0.9414722592567588, 6.916237727485273, vi.Pattern("RRL", 2)
    known = searched(osc, r, 1.0001 * place, pattern, 2000)
    motion = next(motion for motion in known if motion.admissible and motion.stable)
    none = 0
    for distance in 10.0 ** np.arange(-3, -13.5, -0.5):
        for side in (1, -1):
            motion = vi.exact(osc, r, place * (1 + side * distance), motion)
            start = after_impact(motion, int(np.argmin(separations(motion))))
            load = np.sin(r * start["t"])
            opening = load - 2 * osc.xi * start["x_dot"] - start["x"]
            if motion.admissible is None:
                assert distance < 1e-10
                none += 1
            else:
                assert motion.admissible == (side > 0)
                assert motion.admissible == (opening > 0)
    assert none > 0


def separations(motion):
    """Separation speeds after the impacts at which the gap has the least acceleration."""
    apart = motion.pattern.signs * (motion.X_dot_after - motion.Z_dot_after)
    load = np.sin(motion.alpha + motion.load_phase)
    pull = load - 2 * motion.osc.xi * motion.X_dot_after - motion.X
    return np.where(np.abs(apart) < 1e-12, np.abs(pull), np.inf)
