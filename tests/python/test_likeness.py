"""Comparison of motions: `find`, `same_motion` and saved lists agree on which motions are the same."""

import math

import numpy as np
import pytest
import vibroimpact as vi
from shared_motions import pair_motion, rest_motion, triple_motion
from shared_systems import RIG, TABLE
from vibroimpact.explorer.motions import ordered
from vibroimpact.motions.likeness import is_symmetric, motion_images, same_motion, standard_motion


@pytest.fixture(scope="module")
def fork():
    """The clearance at which the equispaced motion of Table 1 loses its symmetry; two others branch from it."""
    branch = vi.branch(vi.equispaced(TABLE, 0.94, 37.0)[0], "clearance", (30, 120))
    return next(point.clearance for point in branch.special_points if point.type == "pitchfork")


def near(fork, offset):
    """The motion found by Newton's method from unequal phases, at a relative offset from the pitchfork."""
    guess = [0, np.pi * 1.001], vi.Pattern("RL")
    if offset < 0:
        guess = [0, np.pi + 1.5636 * math.sqrt(-offset)], vi.Pattern("RL")
    return vi.exact(TABLE, 0.94, fork * (1 + offset), guess)


def test_two_motions_that_have_just_parted(fork):
    """Mirror images 9e-5 apart are two motions: for `same`, for the explorer and for `is_symmetric`."""
    one = near(fork, -3e-9)
    other = standard_motion(one, mirrored=True)
    # the distance is 1.5636 times the square root of the offset, by the branch at offsets of 1e-3 to 1e-8
    assert one.alpha[1] - np.pi == pytest.approx(8.6e-5, rel=0.02)
    assert not same_motion(one, other)
    assert same_motion(one, other, mirrored=True)
    assert not is_symmetric(one)
    assert len(ordered([one])) == len(ordered([one, other, one])) == 2


def test_one_motion_before_they_part(fork):
    motion = near(fork, 1e-5)
    assert is_symmetric(motion)
    assert same_motion(motion, standard_motion(motion, mirrored=True))
    assert len(ordered([motion])) == 1


@pytest.mark.parametrize("make", [pair_motion, rest_motion, triple_motion])
def test_mirror_images_and_turns(make):
    """The mirror image of the mirror image is the motion; the standard form is stable."""
    motion = make()
    form = standard_motion(motion)
    assert same_motion(form, motion)
    assert standard_motion(form) is form
    if motion.osc.restitution[0] == motion.osc.restitution[1]:
        image = standard_motion(form, mirrored=True)
        assert same_motion(standard_motion(image, mirrored=True), form)
        assert same_motion(image, form, mirrored=True)
        assert [same_motion(one, form) for one in motion_images(form)] == [True, False]
    letters = form.pattern.symbols
    if not form.pattern.has_rest:
        assert letters == max(letters[j:] + letters[:j] for j in range(len(letters)))


def test_rest_is_never_one_with_impacts_alone():
    """Two motions with two letters in one cycle are different if only one of them rests."""
    resting, plain = rest_motion(), pair_motion(RIG, 0.9, 6.0)
    assert len(resting.pattern) == len(plain.pattern)
    assert not same_motion(resting, plain)
    assert not same_motion(plain, resting)
