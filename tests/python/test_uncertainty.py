"""Uncertain parameters: maps and charts, bands and zones of other systems, exact probabilities."""

import math

import numpy as np
import pytest
import vibroimpact as vi
from shared_systems import FIGURE6, RIG
from shared_zones import motion_at
from vibroimpact.studies import uncertainty as study
from vibroimpact.systems.distribution import interval, shares, systems, uncertain_parameters

stats = pytest.importorskip("scipy.stats")

WINDOW = ((0.8, 1.2), (2, 200))
R, D = np.linspace(0.85, 1.15, 25), np.geomspace(3, 150, 21)
#: Directions in which all parameters move at once, relative to their nominal values.
RELATIVE = {"xi": 1.0, "clearance": 1.0, "restitution": -0.7, "mu": 0.8}


@pytest.fixture(scope="module")
def zones():
    """Zones whose boundaries have all types of pieces, by name."""
    return {
        "pair": vi.zone(FIGURE6, "RL", *WINDOW, symmetric=True),
        "unequal phases": vi.zone(FIGURE6, "RL", *WINDOW, symmetric=False),
        "three": vi.zone(FIGURE6, "RRL", *WINDOW),
        "four": vi.zone(FIGURE6, "RRLL", *WINDOW),
        "rig": vi.zone(RIG, "RRL", *WINDOW),
        "rest": vi.zone(RIG, "RL*", (0.75, 1.2), (0.5, 20)),
    }


def given(osc, width):
    """Uniform distributions of a relative width around the nominal values."""
    found = {}
    for name, by in RELATIVE.items():
        nominal = {"xi": osc.xi, "mu": osc.mu, "clearance": 1.0}.get(name, osc.restitution[0])
        if name == "restitution" and osc.restitution[0] != osc.restitution[1]:
            for wall, value in zip(("R1", "R2"), osc.restitution, strict=True):
                found[wall] = (value * (1 - abs(by) * width), value * (1 + abs(by) * width))
        else:
            found[name] = (nominal * (1 - abs(by) * width), nominal * (1 + abs(by) * width))
    return found


# -- maps


@pytest.mark.parametrize(("pattern", "symmetric"), [("RL", True), ("RL", False), ("RRL", None)])
def test_a_certain_map_is_the_chart(pattern, symmetric):
    """With distributions of zero width the map has exactly the verdicts of the chart."""
    certain = {"xi": 0.0114, "clearance": 1.0, "restitution": (0.75, 0.75), "r": 1, "load": 1}
    found = vi.uncertainty(FIGURE6, pattern, R, D, certain, symmetric, bands=False, samples=7)
    pytest.importorskip("xarray")
    data = vi.chart(FIGURE6, pattern, R, D, symmetric)
    good = (data.consistent == 1) & (data.admissible == 1) & (data.stable == 1)
    assert np.array_equal(found.probability, good.any("motion").values.astype(float))
    assert set(np.unique(found.probability)) == {0.0, 1.0}
    assert not found.standard_error.any()
    assert not found.undecided.any()


def test_the_probability_of_an_uncertain_clearance_is_the_covered_share():
    """With one uncertain factor of the clearance it is the share of the factors that fall into the zone: an exact
    value for each point, from the places where the boundary crosses its line of constant r."""
    low, high, samples = 0.8, 1.3, 200
    r = R[::3]
    found = vi.uncertainty(
        FIGURE6, "RL", r, D, {"clearance": (low, high)}, True, bands=False, samples=samples
    )
    zone = vi.zone(FIGURE6, "RL", (0.8, 1.2), (1, 400), symmetric=True)
    factors = np.linspace(low, high, 801)
    inside = zone.contains(r[None, :, None], D[:, None, None] * factors).astype(float)
    exact = np.trapezoid(inside, dx=1 / 800, axis=-1)
    some = (exact > 0.05) & (exact < 0.95)
    assert some.sum() > 20
    # a stratified sample of one parameter is off by at most one sample for each boundary
    assert abs(found.probability - exact)[some].max() < 2 / samples + 2 / 800
    assert np.array_equal(found.probability[exact == 1] == 1, np.ones((exact == 1).sum(), bool))


def test_factors_move_a_point():
    """A factor of the load equals one of the inverse clearance; a factor of r moves along r."""
    at = {"samples": 1, "bands": False, "symmetric": True}
    load = vi.uncertainty(FIGURE6, "RL", R, D, {"load": stats.uniform(0.5, 1e-12 + 0.5)}, **at)
    gap = vi.uncertainty(FIGURE6, "RL", R, D, {"clearance": (1, 1)}, **at)
    assert load.probability.shape == gap.probability.shape
    changes = systems(
        FIGURE6, uncertain_parameters({"load": (0.5, 1.0)}, "u", True), np.array([[0.0]])
    )
    assert changes[1, 0] == 2.0
    shifted = systems(
        FIGURE6, uncertain_parameters({"r": (0.9, 1.0)}, "u", True), np.array([[0.0]])
    )
    assert shifted[0, 0] == 0.9


def test_limits_lower_the_probability():
    """Systems are never more probably within the limits than stable; a limit that all keep changes nothing."""
    uncertain = {"xi": (0.0109, 0.0119), "clearance": (0.9, 1.1)}
    options = {"symmetric": True, "bands": False, "samples": 16}
    loose = vi.uncertainty(FIGURE6, "RL", R, D, uncertain, limit={"attenuation": 1e6}, **options)
    tight = vi.uncertainty(
        FIGURE6, "RL", R, D, uncertain, limit={"attenuation": 0.5, "multiplier": 0.97}, **options
    )
    assert np.array_equal(loose.within, loose.probability)
    assert np.array_equal(tight.probability, loose.probability)
    assert (tight.within <= tight.probability).all()
    assert 0 < tight.within.sum() < tight.probability.sum()
    certain = vi.uncertainty(FIGURE6, "RL", R, D, {}, limit={"attenuation": 0.5}, **options)
    data = vi.chart(FIGURE6, "RL", R, D, True)
    good = (data.admissible == 1) & (data.stable == 1)
    kept = (good & (data.attenuation <= 0.5)).any("motion") & ~(
        good & (data.attenuation > 0.5)
    ).any("motion")
    assert np.array_equal(certain.within == 1, kept.values)


def test_threads_and_seeds():
    """Any number of threads gives the same bits; a different seed gives different samples."""
    uncertain = {"restitution": stats.norm(0.75, 0.01), "clearance": (0.95, 1.05)}
    first, second = (
        vi.uncertainty(FIGURE6, "RRL", R[::4], D[::4], uncertain, samples=6, threads=n, vertices=9)
        for n in (1, 3)
    )
    other = vi.uncertainty(FIGURE6, "RRL", R[::4], D[::4], uncertain, samples=6, vertices=9, rng=1)
    assert np.array_equal(first.probability, second.probability)
    for a, b in zip(first.bands, second.bands, strict=True):
        assert np.array_equal(a.sampled, b.sampled, equal_nan=True)
    assert any(
        not np.array_equal(a.sampled, b.sampled)
        for a, b in zip(first.bands, other.bands, strict=True)
    )


def test_a_pattern_with_rest_has_a_map():
    """The samples are zones: with zero width the map equals the zone."""
    r, clearance = np.linspace(0.86, 0.92, 4), np.geomspace(5, 7, 5)
    found = vi.uncertainty(RIG, "RL*", r, clearance, {}, samples=2, bands=False)
    zone = vi.zone(RIG, "RL*", (0.8, 1.0), (4, 9))
    assert np.array_equal(found.probability, zone.contains(r, clearance[:, None]).astype(float))
    assert 0 < found.probability.sum() < found.probability.size


# -- maps with friction in the slot and compliant walls


def has_stable_pair(point, states):
    """Whether simulations from some states settle on a stable motion that hits each wall once in a load cycle."""
    for x, x_dot, y, z_dot in states:
        place = 0.5 * point.clearance * y
        state = [5 * x, 5 * x + place], [5 * x_dot, 5 * z_dot]
        try:
            motion = vi.exact(point, vi.simulate(point, cycles=20, discard=300, state=state))
        except (vi.ParameterError, vi.SingularError):
            continue
        pairs = zip(motion.gaps, motion.kinds, strict=True)
        contacts = sorted(int(gap) for gap, kind in pairs if kind in ("impact", "touch"))
        if motion.stable and motion.admissible and motion.cycles == 1 and contacts == [0, 1]:
            return True
    return False


@pytest.mark.slow
@pytest.mark.parametrize(("parts", "stops"), [
    ({"friction": (0.0, 0.4), "r": (0.99, 1.01)}, None),
    ({"friction": (0.0, 0.3), "wall_stiffness": (10.0, 60.0)}, (None, (20.0, 0.3))),
    ({"wall_stiffness": (10.0, 60.0), "wall_damping": (0.05, 0.4), "load": (0.9, 1.1)}, None),
])  # fmt: skip
def test_a_map_with_friction_is_that_of_simulations_at_each_point(parts, stops):
    """Whatever simulations of the system of a sample settle on is in the map, and hardly anything else: eight
    random states miss up to two motions of small basins."""
    osc, n = vi.Oscillator(xi=0.04, mu=0.05, restitution=0.75), 2
    r, clearance = np.linspace(0.95, 1.07, 4), np.geomspace(5, 40, 4)
    found = vi.uncertainty(
        osc, "RL", r, clearance, parts, stops=stops, samples=n, bands=False, rng=4
    )
    low, high = np.array(list(parts.values())).T[..., None]
    values = low + (high - low) * shares(n, len(parts), np.random.default_rng(4))
    states = np.random.default_rng(1).uniform(-1, 1, (8, 4))
    total = np.zeros((4, 4))
    for sample in values.T.tolist():
        at = dict(zip(parts, sample, strict=True))
        load = at.get("load", 1.0)
        walls = None
        if "wall_stiffness" in parts:
            wall = at["wall_stiffness"], at.get("wall_damping", 0.3 if stops else 0.0)
            walls = (None if stops else wall, wall)
        for i, j in np.ndindex(4, 4):
            point = osc.at(
                r[j] * at.get("r", 1.0), clearance[i] / load, friction=at.get("friction", 0.0) / load, stops=walls
            )  # fmt: skip
            total[i, j] += has_stable_pair(point, states)
    assert 0.05 < total.mean() / n < 0.95
    more = found.probability * n - total
    assert more.min() == 0
    assert more.sum() <= 2
    assert not found.undecided.any()


@pytest.mark.slow
@pytest.mark.parametrize("symmetric", [True, None])
def test_weak_friction_and_stiff_walls_do_not_change_a_map(symmetric):
    """Friction of 1e-7, and walls of stiffness 1e8 with the dashpot of the coefficient of restitution, leave the
    map of rigid walls without friction as it is: both change boundaries by less than their distance from its
    points."""
    r, clearance = R[::6], D[::5]
    zeta = -math.log(0.75) / math.hypot(math.pi, math.log(0.75))
    k, effective = 1e8, FIGURE6.mu / (1 + FIGURE6.mu)
    stiff = {"wall_stiffness": k, "wall_damping": 2 * zeta * math.sqrt(k * effective)}
    options = {"symmetric": symmetric, "bands": False, "samples": 1}
    rigid = vi.uncertainty(FIGURE6, "RL", r, clearance, {"xi": (0.0113, 0.0115)}, **options)
    assert set(np.unique(rigid.probability)) >= {0.0, 1.0}
    for parts in ({"friction": 1e-7}, stiff):
        found = vi.uncertainty(
            FIGURE6, "RL", r, clearance, {"xi": (0.0113, 0.0115)} | parts, **options
        )
        assert np.array_equal(found.probability, rigid.probability)


def test_limits_of_a_map_with_friction_are_those_of_its_motions():
    """Limits just below and above the figures of the one stable motion at a point, in F0/K of the nominal load."""
    point = FIGURE6.at(1.04, 25.0, friction=0.05)
    motion = vi.exact(point, vi.simulate(point, cycles=600))
    largest = motion.quantities().q.peak[0]
    figures = {
        "displacement": largest, "attenuation": largest * math.hypot(1 - 1.04**2, 2 * FIGURE6.xi * 1.04),
        "multiplier": abs(motion.multipliers[0]),
    }  # fmt: skip
    for name, value in figures.items():
        for factor in (1 - 1e-6, 1 + 1e-6):
            found = vi.uncertainty(
                point, "RL", {}, True, limit={name: factor * value}, samples=2, bands=False
            )
            assert found.probability.item() == 1
            assert found.within.item() == (factor > 1)


@pytest.mark.slow
def test_threads_do_not_change_a_map_with_friction():
    given = {"friction": (0.0, 0.2), "r": (0.99, 1.01)}
    r, clearance = np.linspace(0.95, 1.05, 3), [12.0, 25.0]
    one, two = (
        vi.uncertainty(FIGURE6, "RL", r, clearance, given, bands=False, samples=3, threads=threads)
        for threads in (1, 2)
    )
    assert np.array_equal(one.probability, two.probability)
    assert np.array_equal(one.undecided, two.undecided)


@pytest.mark.parametrize(("options", "message"), [
    ({"uncertain": {"friction": (0.0, 0.1)}}, "bands = True: must be False with friction"),
    ({"stops": ((100.0, 0.1), None)}, "bands = True: must be False with friction in the slot or compliant walls"),
    ({"friction": 0.1, "pattern": "RL*", "bands": False}, r"pattern = RL\*/1: must be without rest"),
    ({"uncertain": {"R1": 0.5}, "stops": ((9.0, 0.1), None), "bands": False}, "'R1': must be left out for a"),
    ({"uncertain": {"wall_damping": 0.5}, "bands": False}, "'wall_damping': must be given with a wall_stiffness"),
    ({"friction": -0.1, "bands": False}, "friction = -0.1: must be"),
    ({"friction": 0.1, "uncertain": {"mu": (0.0, 0.0)}, "bands": False}, "mu = 0.0: must be above 0 in all"),
    ({"r": 1.0}, "bands = True: must be False where r or clearance has a single value"),
    ({"r": 1.0, "friction": 0.1}, "bands = True: must be False with friction"),
])  # fmt: skip
def test_bad_input_of_maps_with_friction_is_named(options, message):
    given = {"pattern": "RL", "uncertain": {"xi": 0.0114}, "r": [0.9, 1.1]} | options
    with pytest.raises(vi.ParameterError, match=message):
        vi.uncertainty(FIGURE6, clearance=[10.0, 20.0], samples=2, **given)
    zone = vi.zone(FIGURE6, "RL", (1.0, 1.1), (20, 30), symmetric=True)
    with pytest.raises(vi.ParameterError, match="'friction': must be left out"):
        vi.boundary_bands(zone, {"friction": 0.1})


# -- bands


@pytest.mark.parametrize("name", ["pair", "unequal phases", "three", "four", "rig", "rest"])
def test_first_order_and_samples_agree_to_second_order(zones, name):
    """A tenth of the width divides the difference between both bands by a hundred, for all types of boundaries."""
    zone = zones[name]
    largest = 1e-4 if name == "rest" else 1e-3
    wide, narrow = (
        vi.boundary_bands(zone, given(zone.osc, width), samples=12, vertices=9)
        for width in (largest, 0.1 * largest)
    )
    assert {band.type for band in wide} == {piece.type for piece in zone.boundary} - {"window"}
    for a, b in zip(wide, narrow, strict=True):
        # near a corner, the other condition bounds the zone for some samples
        assert b.holds[1:-1].mean() > 0.8
        good = a.holds & b.holds
        off = [abs(band.first_order - band.sampled).max(axis=0)[good] for band in (a, b)]
        width = np.ptp(b.sampled, axis=0)[good]
        assert np.median(off[1] / width) < 2e-3
        assert (off[1] < 0.03 * off[0] + 1e-5 * width + 1e-11).mean() > 0.9


def test_a_zone_that_vanishes(zones):
    """Where the zone no longer exists for 2 % less R1, first order is reported as invalid."""
    for band in vi.boundary_bands(zones["rest"], {"R1": (0.735, 0.75)}, samples=6, vertices=3):
        assert not band.holds.any()
        assert (band.found < 1).all()
    other = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.735, 0.61))
    assert not vi.zone(other, "RL*", (0.75, 1.2), (0.5, 20))


def test_sampled_bands_are_the_boundaries_of_other_systems(zones):
    """The displaced vertices lie on the zone that is traced anew for the displaced system."""
    zone = zones["pair"]
    for name, value in (("xi", 0.0119), ("restitution", 0.70), ("mu", 0.03)):
        bands = vi.boundary_bands(zone, {name: value}, samples=1, vertices=15)
        values = {"xi": 0.0114, "mu": 0.028, "restitution": 0.75, name: value}
        other = vi.zone(vi.Oscillator(**values), "RL", (0.78, 1.22), (1.5, 250), symmetric=True)
        away = []
        for band in bands:
            r, clearance = (edge[0] for edge in band.edges())
            on = band.found == 1
            for x, y in zip(r[on], np.log(clearance[on]), strict=True):
                away.append(nearest(other, x, y))
        assert len(away) > 30
        assert max(away) < 2e-6, name


def nearest(zone, r, log_clearance):
    """Distance to the boundary from the polygons of the loops, with the window as the unit square."""
    best = math.inf
    scale = np.array([np.ptp(zone.r), np.ptp(np.log(zone.clearance))])
    for loop in zone.loops:
        ring = np.c_[loop[:, 0], np.log(loop[:, 1])] / scale
        start, step = ring, np.roll(ring, -1, axis=0) - ring
        gap = np.array([r, log_clearance]) / scale - start
        along = np.clip((gap * step).sum(1) / np.maximum((step**2).sum(1), 1e-300), 0, 1)
        best = min(best, float(np.linalg.norm(gap - along[:, None] * step, axis=1).min()))
    return best


def test_first_order_is_that_of_the_derivatives_of_multipliers(zones):
    """On a Neimark-Sacker boundary 1 - max|lambda| is zero: its derivatives by r, D and a parameter, from
    `Motion.gradient`, give the displacement along the normal."""
    zone = zones["pair"]
    piece = next(piece for piece in zone.boundary if piece.type == "neimark_sacker")
    bands = vi.boundary_bands(zone, given(FIGURE6, 1e-4), samples=2, vertices=len(piece))
    band = next(band for band in bands if band.type == "neimark_sacker")
    assert len(band) == len(piece)
    for j in range(2, len(piece) - 2, 7):
        motion = motion_at(zone, piece, j)
        by = motion.gradient()
        normal = band.normal[:, j]
        rate = by["stability_margin", "r"] * normal[0]
        rate += by["stability_margin", "clearance"] * motion.clearance * normal[1]
        for name, key in (("xi", "xi"), ("mu", "mu"), ("R", "restitution")):
            wanted = -by["stability_margin", name] / rate
            assert band.sensitivity[key][j] == pytest.approx(float(wanted), rel=1e-5), (j, name)
        assert band.sensitivity["clearance"][j] == pytest.approx(
            float(-by["stability_margin", "clearance"] * motion.clearance / rate), rel=1e-5
        )


def test_where_first_order_fails_it_is_said():
    """At the end of a fold, where the zone is a narrow tongue, large changes move the boundary off the normal."""
    zone = vi.zone(FIGURE6, "RL", *WINDOW, symmetric=True)
    bands = vi.boundary_bands(
        zone, {"restitution": (0.6825, 0.75), "clearance": (0.9, 1.1)}, samples=32
    )
    flags = np.concatenate([band.holds for band in bands])
    found = np.concatenate([band.found for band in bands])
    assert 0.5 < flags.mean() < 1
    assert found.min() < 0.9
    assert not flags[found < 1].any()
    for band in bands:
        apart = abs(band.first_order - band.sampled).max(axis=0)
        assert (apart <= 0.1 * np.ptp(band.sampled, axis=0) + 1e-12)[band.holds].all()


def test_displacements_point_out_of_the_zone(zones):
    """A step along the normal leaves the zone, a step against it enters the zone."""
    for name in ("pair", "three"):
        zone = zones[name]
        for band in vi.boundary_bands(zone, {"xi": (0.011, 0.012)}, samples=1, vertices=15):
            inner = slice(2, -2)
            r, clearance, normal = band.r[inner], band.clearance[inner], band.normal[:, inner]
            for part, inside in ((1e-4, False), (-1e-4, True)):
                at = r + part * normal[0], clearance * np.exp(part * normal[1])
                assert (zone.contains(*at) == inside).mean() > 0.85


def test_more_clearance_moves_boundaries_along_it_alone(zones):
    """If the true clearance is 1 % greater, the boundary is at a nominal clearance that is 1 % less."""
    for band in vi.boundary_bands(
        zones["three"], {"clearance": (1.0, 1.01)}, samples=1, vertices=15
    ):
        sample = systems(
            FIGURE6, uncertain_parameters({"clearance": (1.0, 1.01)}, "u", True),
            shares(1, 1, np.random.default_rng(0)),
        )  # fmt: skip
        factor = sample[1, 0]
        on = band.found == 1
        assert on.any()
        r, clearance = (edge[0, on] for edge in band.edges())
        away = [
            nearest(zones["three"], x, y)
            for x, y in zip(r, np.log(clearance * factor), strict=True)
        ]
        assert max(away) < 2e-6


# -- limits on attractors


def test_limit_probability_agrees_with_the_attractor_of_each_sample():
    """A system without uncertainty keeps a limit always or never; the interval has the stated ends."""
    samples = 40
    for greatest, expected in ((10.0, 1.0), (1e-3, 0.0)):
        found = vi.limit_probability(
            FIGURE6, 1.0, 25.0, {}, {"attenuation": greatest}, samples=samples
        )
        assert found.probability == expected
        assert not found.failed
        assert found.low <= expected <= found.high
    assert found.high == pytest.approx(1 - 0.025 ** (1 / samples))
    # 1 - .025^(1/40) = .08810
    assert repr(found).endswith("0 (95 % interval 0 to 0.0881), 40 samples>")
    both = vi.limit_probability(
        FIGURE6, [1.0, 1.02], [[25.0], [30.0]], {"xi": (0.01, 0.012)}, {"speed": 5.0}, samples=10
    )
    assert both.probability.shape == both.low.shape == (2, 2)
    assert f"{both.probability.min():.4g} to {both.probability.max():.4g} at 4 points" in repr(both)


def test_limit_probability_is_that_of_an_exact_case():
    """One uncertain parameter, one attractor: its largest displacement falls with xi, and the limit is that at the
    30 % quantile of xi, so that 70 % of the systems keep it."""
    low, high, r, clearance = 0.02, 0.06, 1.02, 20.0
    at = {}
    for share in (0.1, 0.3, 0.7):
        osc = vi.Oscillator(xi=low + share * (high - low), mu=0.028, restitution=0.75)
        at[share] = max(
            motion.x_max
            for motion in vi.find(osc, r, clearance, 4, 1)
            if motion.stable and motion.admissible
        )
    assert at[0.1] > at[0.3] > at[0.7]
    osc = vi.Oscillator(xi=0.04, mu=0.028, restitution=0.75)
    found = vi.limit_probability(
        osc,
        r,
        clearance,
        {"xi": (low, high)},
        {"displacement": at[0.3]},
        samples=600,
        confidence=0.999,
    )
    assert found.low < 0.7 < found.high
    assert found.high - found.low < 0.15
    again = vi.limit_probability(
        osc,
        r,
        clearance,
        {"xi": (low, high)},
        {"displacement": at[0.3]},
        samples=600,
        starts=2,
        threads=1,
    )
    assert again.probability <= found.probability + 0.1


def test_limits_do_not_grow_with_an_uncertain_load():
    """With a free mass of no weight, a limit 1.2 times the nominal figure is kept up to the load 1.2; with
    impacts, the share is that of the equispaced motions at each load."""
    osc, r = vi.Oscillator(xi=0.1, mu=0.0, restitution=0.75), 0.6
    amplitude = 1 / math.hypot(1 - r**2, 2 * osc.xi * r)
    figures = {
        "displacement": amplitude, "rms": amplitude / math.sqrt(2), "acceleration": r**2 * amplitude,
        "force": amplitude * math.hypot(1, 2 * osc.xi * r),
    }  # fmt: skip
    for name, figure in figures.items():
        for load in (1.1999, 1.2001):
            found = vi.limit_probability(
                osc,
                r,
                1e4,
                {"load": (min(1.0, load), 1.0, load, load, load)},
                {name: 1.2 * figure},
                samples=20,
            )
            assert found.probability < 1 if load > 1.2 else found.probability == 1
    spread = {"load": stats.uniform(0.5, 1.0)}
    at = {"bands": False, "samples": 64, "symmetric": True}
    motion = vi.equispaced(FIGURE6, 1.04, 25.0)[0]
    largest = max(motion.x_max, -motion.x_min)
    found = vi.uncertainty(FIGURE6, "RL", 1.04, 25.0, spread, limit={"displacement": largest}, **at)
    loads = np.linspace(0.5, 1.5, 2001)
    kept = 0
    for load in loads:
        stable = [m for m in vi.equispaced(FIGURE6, 1.04, 25.0 / load) if m.stable and m.admissible]
        kept += bool(stable) and all(load * max(m.x_max, -m.x_min) <= largest for m in stable)
    assert found.within == pytest.approx(kept / len(loads), abs=2 / 64)
    assert 0.1 < kept / len(loads) < 0.9


def test_without_friction_and_with_stiff_walls_a_structure_is_the_oscillator():
    """The same samples from the same initial states keep the same limits: with friction 0 up to the interpolation
    of extremes, and with walls of stiffness k up to k^(-1/2)."""
    osc = vi.Oscillator(xi=0.04, mu=0.028, restitution=0.75)
    k, effective = 1e8, osc.mu / (1 + osc.mu)
    zeta = -math.log(0.75) / math.hypot(math.pi, math.log(0.75))
    stiff = {"wall_stiffness": k, "wall_damping": 2 * zeta * math.sqrt(k * effective)}
    middle = max(m.x_max for m in vi.find(osc, 1.02, 20.0, 4, 1) if m.stable and m.admissible)
    options = {"limit": {"displacement": middle, "speed": 25.0}, "samples": 60, "rng": 3}
    rigid = vi.limit_probability(osc, 1.02, 20.0, {"xi": (0.02, 0.06)}, **options)
    assert 0.3 < rigid.probability < 0.7
    for parts in ({"friction": 0.0}, stiff):
        found = vi.limit_probability(osc, 1.02, 20.0, {"xi": (0.02, 0.06)} | parts, **options)
        assert abs(found.probability - rigid.probability) <= 1 / 60
        assert not found.failed


def test_limit_probability_with_friction_is_that_of_single_simulations():
    """The share is that of simulations of the points at the sampled values of friction, stiffness and load."""
    osc = vi.Oscillator(xi=0.04, mu=0.028, restitution=0.75)
    r, clearance, n, limit = 1.02, 20.0, 24, 9.0
    parts = {"friction": (0.0, 0.5), "wall_stiffness": (5.0, 50.0), "load": (0.7, 1.3)}
    point = osc.at(r, clearance, friction=0.2, stops=(None, (10.0, 0.3)))
    found = vi.limit_probability(point, parts, {"displacement": limit}, samples=n, rng=5)
    random = np.random.default_rng(5)
    where, places = random.random((3, n)), random.uniform(-1, 1, (4, n))
    low, high = np.array(list(parts.values())).T[..., None]
    kept = 0
    for (friction, stiffness, load), place in zip(
        (low + (high - low) * where).T, places.T, strict=True
    ):
        at = osc.at(r, clearance, load, friction=friction, stops=(None, (stiffness, 0.3)))
        scale = min(max(load / math.hypot(1 - r**2, 2 * osc.xi * r), clearance / 2), 3 * clearance)
        x, x_dot, y, z_dot = place * [scale, scale, clearance / 2, scale]
        run = vi.simulate(at, cycles=64, discard=400, state=([x, x + y], [x_dot, z_dot]))
        kept += run.quantities().q.peak[0] <= limit
    assert 3 <= kept <= n - 3
    assert found.probability * n == pytest.approx(kept)


@pytest.mark.parametrize("parts", [
    {"friction": 0.05}, {"wall_stiffness": 20.0, "wall_damping": 0.05},
    {"friction": 0.02, "wall_stiffness": 20.0, "wall_damping": 0.2},
])  # fmt: skip
def test_limits_with_friction_and_walls_that_give_are_those_of_the_exact_motion(parts):
    """Limits just below and above the figures of the motion of the point itself."""
    wall = parts.get("wall_stiffness"), parts.get("wall_damping", 0.0)
    stops = (wall, wall) if "wall_stiffness" in parts else None
    point = FIGURE6.at(1.04, 25.0, friction=parts.get("friction", 0.0), stops=stops)
    motion = vi.exact(point, vi.simulate(point, cycles=600))
    hits = motion.speeds[[kind in ("impact", "touch") for kind in motion.kinds]]
    figures = {
        "displacement": motion.quantities().q.peak[0], "multiplier": abs(motion.multipliers[0]),
        "speed": max(hits), "least_speed": min(hits),
    }  # fmt: skip
    for name, value in figures.items():
        for factor in (1 - 1e-4, 1 + 1e-4):
            found = vi.limit_probability(
                FIGURE6, 1.04, 25.0, parts, {name: factor * value}, samples=4, threads=2
            )
            kept = (factor > 1) != (name == "least_speed")
            assert (found.probability, found.failed) == (kept, 0)


@pytest.mark.parametrize(("holds", "count"), [(0, 20), (7, 20), (20, 20), (993, 1000)])
def test_intervals_are_those_of_scipy(holds, count):
    """The interval of Clopper and Pearson equals quantiles of the beta distribution."""
    for share in (0.9, 0.99):
        low, high = interval(holds, count, share)
        wanted = stats.binomtest(holds, count).proportion_ci(share, "exact")
        assert (low, high) == pytest.approx((wanted.low, wanted.high), abs=1e-12)


def test_a_latin_hypercube_has_one_share_in_each_part():
    """Every row has exactly one number in each of n equal parts."""
    found = shares(50, 3, np.random.default_rng(4))
    assert np.array_equal(np.sort(np.floor(found * 50), axis=1), np.tile(np.arange(50), (3, 1)))


# -- results and bad input


def test_results_as_datasets_and_pictures():
    """Labelled maps with the vertices of the bands; a picture with the map, the boundary and the bands."""
    pytest.importorskip("xarray")
    pytest.importorskip("matplotlib").use("Agg")
    found = vi.uncertainty(
        FIGURE6,
        "RL",
        R,
        D,
        given(FIGURE6, 0.03),
        True,
        limit={"attenuation": 0.4},
        samples=8,
        vertices=12,
    )
    data = found.to_xarray()
    assert data.probability.dims == ("clearance", "r")
    assert data.sizes["vertex"] == sum(map(len, found.bands))
    assert np.array_equal(data.within, found.within)
    assert data.attrs["limit_attenuation"] == 0.4
    assert {f"by_{name}" for name in found.uncertain} <= set(data.data_vars)
    ax = found.plot(inverse=True)
    assert ax.get_ylabel() == "$F_0/(dK)$"
    labels = ax.get_legend_handles_labels()[1]
    assert labels.count("nominal boundary") == labels.count("band of 95 %") == 1
    assert found.plot(what="within").get_xlabel() == ax.get_xlabel()
    point = vi.limit_probability(FIGURE6, [1.0, 1.1], 25.0, {}, {"rms": 1.0}, samples=3)
    assert point.to_xarray().sizes == {"point": 2}
    with pytest.raises(AttributeError):
        found.samples = 3


def test_progress_is_told_and_stops():
    """Shares rise to 1; an exception of the function ends the computation."""
    told = []
    vi.uncertainty(
        FIGURE6, "RL", R, D, {"xi": (0.01, 0.02)}, True, samples=4,
        progress=lambda share, note: told.append((share, note)),
    )  # fmt: skip
    rising = [share for share, _ in told]
    assert rising == sorted(rising)
    assert 0.99 < rising[-1] <= 1
    assert told[-1][1] == "bands"

    class EnoughError(Exception):
        pass

    def stop(share, note):
        raise EnoughError

    for call in (
        lambda: vi.uncertainty(FIGURE6, "RRL", R, D, {"xi": (0.01, 0.02)}, progress=stop),
        lambda: vi.limit_probability(
            FIGURE6, 1.0, 25.0, {}, {"rms": 1.0}, samples=5000, progress=stop
        ),
    ):
        with pytest.raises(EnoughError):
            call()


BAD = [
    ({"uncertain": 3}, "uncertain = 3: must be a dict"),
    ({"uncertain": {"gap": (1, 2)}}, "unknown parameter 'gap': must be one of xi, mu"),
    (
        {"uncertain": {"xi": (0.5, 1.5)}},
        r"uncertain\['xi'\] = 1.5: must be a number with 0 <= .* < 1",
    ),
    ({"uncertain": {"xi": "wide"}}, "must be a number, a range"),
    ({"uncertain": {"xi": (0.02, 0.01)}}, "low <= high"),
    ({"uncertain": {"xi": (0.01, math.nan)}}, "low <= high"),
    ({"uncertain": {"restitution": 0.7, "R1": 0.7}}, "not both"),
    ({"uncertain": {"clearance": (9.5, 11.5)}}, "factors of the nominal clearance"),
    ({"uncertain": {"load": (0.0, 1.0)}}, "factors of the nominal load, above 0"),
    ({"uncertain": {"R1": (0.7, 0.75)}, "symmetric": None}, "lose their symmetry"),
    ({"r": [0.9, 1.1, 1.0]}, "r of shape"),
    ({"r": []}, "r of shape"),
    ({"clearance": [1.0, math.inf]}, "clearance = inf"),
    ({"clearance": [5.0]}, "bands = True: must be False where"),
    ({"limit": {"noise": 1}}, "limit: unknown quantity 'noise'"),
    ({"limit": {"attenuation": -1}}, r"limit\['attenuation'\] = -1: must be a positive"),
    ({"limit": 0.3}, "limit = 0.3: must be a dict"),
    ({"samples": 0}, "samples = 0: must be a whole number"),
    ({"quantiles": (0.9, 0.1)}, "quantiles = "),
    ({"rng": -1}, "rng = -1"),
    ({"vertices": 1}, "vertices = 1"),
    ({"progress": 3}, "progress = 3: must be None or callable"),
    ({"bands": 1}, "bands = 1: must be True or False"),
    ({"threads": 0}, "threads = 0"),
]


@pytest.mark.parametrize(("options", "message"), BAD)
def test_bad_input_is_named(options, message):
    """Each error names the parameter, its value and the allowed values."""
    good = {
        "r": R[::8], "clearance": D[::8], "uncertain": {"xi": (0.01, 0.012)}, "symmetric": True, "samples": 2
    }  # fmt: skip
    with pytest.raises((vi.ParameterError, vi.ParameterTypeError), match=message):
        vi.uncertainty(FIGURE6, "RL", **good | options)


def test_limits_of_a_rig_are_shown_in_its_units():
    """Limits stay as they were given; dimensionless limits of a system without dimensions are unchanged."""
    rig = vi.Oscillator.from_dimensional(M=2.7, K=42e3, xi=0.011, m=0.11, restitution=0.75, F0=6.0)
    given = {"uncertain": {"xi": (0.01, 0.012)}, "samples": 2, "starts": 1}
    found = vi.limit_probability(
        rig, "19.5 Hz", "4 mm", limit={"rms": "1 mm", "multiplier": 0.9}, **given
    )
    assert "rms <= 1 mm, multiplier <= 0.9:" in repr(found)
    assert found.limit["rms"] == pytest.approx(1e-3 * 42e3 / 6)
    plain = vi.limit_probability(FIGURE6, 1.0, 25.0, limit={"rms": 7.0}, **given)
    assert "rms <= 7:" in repr(plain)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"limit": {}}, "limit = {}: must have at least one"),
        ({"confidence": 1.0}, "confidence = 1.0: must be a number between 0 and 1"),
        ({"starts": 0}, "starts = 0"),
        ({"settling": 1}, "settling = 1"),
        ({"r": [1, 2], "clearance": [1, 2, 3]}, "must be broadcastable"),
        (
            {"uncertain": {"friction": (-0.1, 0.1)}},
            r"uncertain\['friction'\] = -0.1: must be a number with 0 <= ",
        ),
        (
            {"uncertain": {"wall_stiffness": 3.0, "R1": 0.5}},
            "'R1': must be left out for a compliant wall",
        ),
        (
            {"uncertain": {"wall_damping": 3.0}},
            "'wall_damping': must be given with a wall_stiffness",
        ),
        (
            {"uncertain": {"friction": 0.1, "mu": 0.0}},
            "mu = 0.0: must be above 0 in all samples with friction",
        ),
        (
            {"uncertain": {"friction": 0.1}, "limit": {"least_gap": 1.0}},
            "must be left out with friction or compliant walls",
        ),
        ({"r": []}, "0 points"),
        ({"clearance": math.nan}, "clearance = nan"),
        ({"samples": 10**6, "starts": 1000}, "simulations: must be 1 to"),
    ],
)
def test_bad_input_of_limits_is_named(options, message):
    """Each error names the parameter, its value and the allowed values."""
    good = {"r": 1.0, "clearance": 25.0, "uncertain": {}, "limit": {"rms": 1.0}, "samples": 2}
    with pytest.raises((vi.ParameterError, vi.ParameterTypeError), match=message):
        vi.limit_probability(FIGURE6, **good | options)


def test_bands_need_a_zone():
    """Other objects and unknown kinds of edges are refused."""
    with pytest.raises(vi.ParameterTypeError, match="zone"):
        vi.boundary_bands("RL", {})
    zone = vi.zone(FIGURE6, "RL", *WINDOW, symmetric=True)
    band = vi.boundary_bands(zone, {"xi": (0.011, 0.012)}, samples=2, vertices=5)[0]
    with pytest.raises(vi.ParameterError, match="kind"):
        band.edges("third")


def test_ctrl_c_keeps_what_uncertainty_and_limits_finished(monkeypatch):
    """The first samples, or the first points, are kept; before any of them there is nothing to keep."""
    works = {name: getattr(study, name) for name in ("perform_points", "verdicts")}

    def stop_after(name, calls):
        work, done = works[name], iter(range(calls))

        def counted(*args):
            if next(done, None) is None:
                raise KeyboardInterrupt
            return work(*args)

        monkeypatch.setattr(study, name, counted)

    spread = {"restitution": (0.68, 0.75)}
    points, limit = [20.0, 25.0, 30.0], {"attenuation": 0.6}
    whole = vi.limit_probability(FIGURE6, 1.04, points, spread, limit, samples=20)
    assert whole.complete
    monkeypatch.setattr(study, "FIRST", (1, 8))
    stop_after("perform_points", 1)
    with pytest.raises(vi.StudyInterrupted) as caught:
        vi.limit_probability(FIGURE6, 1.04, points, spread, limit, samples=20)
    part = caught.value.result
    assert (part.samples, part.complete) == (1, False)
    assert "interrupted" in repr(part)
    monkeypatch.setattr(study, "FIRST", ())
    stop_after("perform_points", 2)
    with pytest.raises(vi.StudyInterrupted) as caught:
        vi.limit_probability(FIGURE6, 1.04, points, spread, limit, samples=20)
    part = caught.value.result
    np.testing.assert_array_equal(part.probability[:2], whole.probability[:2])
    assert np.isnan(part.probability[2])
    stop_after("perform_points", 1)
    monkeypatch.setattr(study, "BLOCK", 12)
    with pytest.raises(vi.StudyInterrupted) as caught:
        vi.limit_probability(FIGURE6, 1.04, points, spread, limit, samples=20)
    part = caught.value.result
    assert part.samples == 12
    assert np.isfinite(part.probability).tolist() == [True, False, False]
    assert 12 * part.probability[0] == round(12 * part.probability[0])
    stop_after("perform_points", 0)
    with pytest.raises(KeyboardInterrupt) as caught:
        vi.limit_probability(FIGURE6, 1.04, points, spread, limit, samples=20)
    assert not isinstance(caught.value, vi.StudyInterrupted)
    assert "before the first of 20 samples of the first point was finished" in str(caught.value)
    pattern, r = vi.Pattern("RL", 1), [1.0, 1.02]
    stop_after("verdicts", 3)
    with pytest.raises(vi.StudyInterrupted) as caught:
        vi.uncertainty(FIGURE6, pattern, r, [30.0, 60.0], spread, samples=8, bands=False)
    few = caught.value.result
    assert (few.samples, few.complete) == (3, False)
    assert "interrupted" in repr(few)
    assert ((few.probability >= 0) & (few.probability <= 1)).all()
    np.testing.assert_allclose(3 * few.probability, np.round(3 * few.probability), atol=1e-12)
    # the part of an interrupted sample is not a result of this function
    part = vi.StudyInterrupted("part of a sample")
    monkeypatch.setattr(study, "verdicts", lambda *args: (_ for _ in ()).throw(part))
    with pytest.raises(KeyboardInterrupt) as caught:
        vi.uncertainty(FIGURE6, pattern, r, [30.0, 60.0], spread, samples=8, bands=False)
    assert not isinstance(caught.value, vi.StudyInterrupted)
    assert "before the first of 8 samples was finished, so that there is no result" in str(
        caught.value
    )
