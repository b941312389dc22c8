"""A zone contains each seed, or names those without a closed boundary; zones with open boundaries."""

import warnings

import numpy as np
import pytest
import vibroimpact as vi
from shared_systems import FIGURE6
from shared_zones import WINDOW, distance
from vibroimpact.studies.geometry import signed_area

NARROW = vi.Oscillator(xi=0.0188, mu=0.42728, restitution=(0.8054, 0.9253))


def stable_motions(osc, r, clearance, **limits):
    return [m for m in vi.find(osc, r, clearance, **limits) if m.stable and m.admissible]


@pytest.fixture(scope="module")
def narrow_seed():
    """A motion between a flip at d K/F0 = 3.729 and a Neimark-Sacker bifurcation at 3.804."""
    motions = stable_motions(NARROW, 1.0364238337797345, 3.780427505076773)
    return next(m for m in motions if m.pattern.sides == "RRL")


@pytest.mark.parametrize("lines", [5, 17, 33])
def test_a_narrow_zone_contains_its_seed(narrow_seed, lines):
    """A zone that is 5e-5 wide at the edge of the window contains its seed."""
    m = narrow_seed
    zone = vi.zone(NARROW, m.pattern, (0.6, 1.4), (0.5, 150), seeds=[m], lines=lines)
    assert zone.closed
    assert zone.search.open_seeds == []
    assert zone.contains(m.r, m.clearance)
    # each loop encloses an area: none follows a boundary forth and back
    for ring in zone.loops:
        place = np.c_[ring[:, 0], np.log(ring[:, 1])]
        length = np.linalg.norm(np.diff(place, axis=0), axis=1).sum()
        assert abs(signed_area(place)) > 1e-5 * length**2
    # the ends of the zone on the line of the seed, by the multipliers along a branch
    branch = vi.branch(m, "clearance", (3.5, 4.0))
    ends = {p.type: p.clearance for p in branch.special_points if p.r == m.r}
    low, high = ends["flip"], ends["neimark_sacker"]
    assert low < m.clearance < high
    inside = zone.contains(
        m.r, [low * (1 - 1e-6), low * (1 + 1e-6), high * (1 - 1e-6), high * (1 + 1e-6)]
    )
    assert inside.tolist() == [False, True, True, False]


@pytest.mark.parametrize(
    ("xi", "mu", "restitution", "r", "clearance", "sides"),
    [
        (0.004224215693034358, 0.014601482748818895, 0.9290882331817338,
         0.829002422413528, 10.141873636860122, "RL"),
        (0.003034985042577527, 0.02894621967486506, 0.9188256689598893,
         0.966686925788268, 23.794342086350614, "RRLL"),
        (0.014064717728694559, 0.4483871979179741, 0.5162429484873612,
         0.9389653358076223, 2.7764771436891325, "RRLL"),
        (0.006340915098407981, 0.10255675711513366, 0.728528754295891,
         0.8839956945333232, 22.57464937614491, "RLL"),
    ],
)  # fmt: skip
def test_zones_of_a_seed_alone_contain_it(xi, mu, restitution, r, clearance, sides):
    """With five lines in each direction and no guesses, the lines through the seed lead to its zone."""
    osc = vi.Oscillator(xi=xi, mu=mu, restitution=restitution)
    motions = stable_motions(osc, r, clearance, max_impacts=4, max_cycles=1)
    motions = [m for m in motions if m.pattern.sides == sides]
    assert motions
    for m in motions:
        zone = vi.zone(osc, m.pattern, (0.6, 1.4), (0.5, 150), lines=5, guesses=0, seeds=[m])
        assert zone.contains(r, clearance)
        assert zone.closed


def test_a_zone_at_resonance_closes_where_a_fold_leaves_a_pitchfork():
    """The zone closes where rounding dominates the equations near the pitchfork; any lattice gives its area."""
    osc = vi.Oscillator(
        xi=0.0005417004965190911, mu=0.22158630702037513, restitution=0.6657527384929456
    )
    places = np.array(
        [[1.0016207074667514, 8.529850983113421], [1.039258603888283, 6.767918330155784]]
    )
    areas = []
    for lines in (5, 17, 33):
        zone = vi.zone(osc, vi.Pattern("RL"), (0.89255, 1.09089), (6.767, 18.046), lines=lines)
        assert zone.closed
        areas.append(zone.area)
        for r, clearance in places:
            # an unsymmetric motion: its multipliers decide
            unsymmetric = [
                m for m in stable_motions(osc, r, clearance, max_impacts=2, max_cycles=1)
                if abs(m.X[0] + m.X[1]) > 1e-6
            ]  # fmt: skip
            assert unsymmetric
        np.testing.assert_array_equal(zone.contains(*places.T), [True, True])
    np.testing.assert_allclose(areas, areas[0], rtol=1e-6)


@pytest.fixture(scope="module")
def unclosed():
    """A zone whose boundary is cut short, and the complete zone."""
    pattern = vi.Pattern("RL")
    return (
        vi.zone(FIGURE6, pattern, *WINDOW, symmetric=True, max_points=100),
        vi.zone(FIGURE6, pattern, *WINDOW, symmetric=True),
    )


def test_an_open_boundary_is_kept_and_told(unclosed):
    """The part traced in both directions is kept, is on the boundary, and is reported as open."""
    cut, whole = unclosed
    assert not cut.closed
    assert cut.open_boundary
    assert sum(len(piece) for piece in cut.open_boundary) > 100
    for piece in cut.open_boundary:
        for r, clearance in zip(piece.r[::9], piece.clearance[::9], strict=True):
            assert distance(whole, r, clearance) < 0.02
    again = vi.Zone.from_dict(cut.to_dict())
    assert [len(p) for p in again.open_boundary] == [len(p) for p in cut.open_boundary]


def test_membership_beside_an_open_boundary_is_undecided(unclosed):
    """Near an open boundary `contains` warns, and points of the zone are inside or undecided."""
    cut, whole = unclosed
    random = np.random.default_rng(2)
    r, clearance = random.uniform(*WINDOW[0], 300), np.exp(random.uniform(*np.log(WINDOW[1]), 300))
    inside = whole.contains(r, clearance)
    assert inside.any()
    assert not whole.undecided(r, clearance).any()
    with pytest.warns(vi.errors.OpenBoundaryWarning, match="not decided"):
        output = cut.contains(r, clearance)
    assert (output | cut.undecided(r, clearance))[inside].mean() > 0.95
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert not cut.contains(0.1, 1e6)
        whole.contains(r, clearance)


def test_a_seed_within_no_closed_boundary_is_named():
    """A seed in no closed boundary, for lack of points, is not contained, but named by the result."""
    seed = next(m for m in vi.equispaced(FIGURE6, 1.04, 25.0) if m.stable)
    zone = vi.zone(FIGURE6, vi.Pattern("RL"), *WINDOW, symmetric=True, max_points=100, seeds=[seed])
    assert not zone.closed
    assert zone.search.open_seeds == [(1.04, 25.0)]
    assert zone.undecided(1.04, 25.0)
    again = vi.Zone.from_dict(zone.to_dict())
    assert again.search == zone.search
    whole = vi.zone(FIGURE6, vi.Pattern("RL"), *WINDOW, symmetric=True, seeds=[seed])
    assert whole.closed
    assert whole.search.open_seeds == []


def test_a_boundary_is_followed_round_a_narrow_tongue():
    """Both sides of a tongue of unstable motions, 1.2e-3 wide in r, between two flips.

    Found by an independent program: a trace that returned along the other side of the tongue was
    mistaken for closed. The flips are those of the branch along r at d K/F0 = 33.
    """
    osc = vi.Oscillator(
        xi=0.0012213737261727341,
        mu=0.008322584487239597,
        restitution=(0.6742052403036547, 0.9050322935952178),
    )
    zones = [
        vi.zone(osc, vi.Pattern("LR"), (0.6, 1.4), (0.5, 150), lines=lines)
        for lines in (17, 33, 65)
    ]
    start = next(
        m for m in vi.find(osc, 0.676, 33.0, 2, 1) if m.pattern.sides in ("RL", "LR") and m.stable
    )
    branch = vi.branch(start, "r", (0.6755, 0.681))
    low, high = sorted(p.r for p in branch.special_points if p.type == "flip")
    assert high - low == pytest.approx(1.2e-3, abs=1e-4)
    middle = (low + high) / 2
    # beyond the flips the motions of two cycles are stable
    assert not [m for m in vi.find(osc, middle, 33.0, 2, 1) if m.stable and m.pattern.cycles == 1]
    places = [low - 1e-6, low + 1e-6, middle, high - 1e-6, high + 1e-6]
    for zone in zones:
        assert zone.closed
        assert zone.contains(places, 33.0).tolist() == [True, False, False, False, True]
        assert zone.area == pytest.approx(zones[0].area, rel=1e-5)


def test_a_seed_that_is_no_motion_is_named():
    """A seed that is not a motion has no zone, and the result names it."""
    good = vi.equispaced(FIGURE6, 1.1, 25.0)[0]
    bad = good.__replace__(X=9 * good.X, alpha=good.alpha * 0.1)
    zone = vi.zone(FIGURE6, good.pattern, (1.0, 1.2), (10, 60), seeds=[good, bad])
    (remark,) = [text for text in zone.to_dict()["remarks"] if "not used" in text]
    assert remark.startswith("the seed at r = 1.1")
    assert zone.contains(good.r, good.clearance) == good.stable
    alone = vi.zone(FIGURE6, good.pattern, (1.0, 1.2), (10, 60), seeds=[good])
    assert not [text for text in alone.to_dict()["remarks"] if "not used" in text]
