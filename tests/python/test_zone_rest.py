"""Motions with rest near the ends of their family, and the exact boundaries of their zones."""

import contextlib
import math

import numpy as np
import pytest
import vibroimpact as vi
from scipy.optimize import brentq
from shared_simulations import state
from shared_systems import RIG
from test_exact_rest import strobe_matrix
from vibroimpact.newton import release_motion

#: The same walls, exchanged.
TURNED = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.61, 0.75))
#: A heavy free mass between hard walls: its zones with rest are narrow.
HEAVY = vi.Oscillator(xi=0.0188, mu=0.42728, restitution=(0.8054, 0.9253))


def attractors(osc, r, clearance, count, seed=0):
    """Return the exact motions that simulations from random states settle on, each once."""
    rng = np.random.default_rng(seed)
    found = {}
    for _ in range(count):
        x, x_dot, z_dot, y = rng.uniform(-1, 1, 4) * [3, 3, 3, 0.49] * clearance
        start = state(0.0, x, x_dot, x + y, z_dot)
        run = vi.simulate(osc, r, clearance, 16, start, discard=1500)
        with contextlib.suppress(vi.errors.VibroimpactError):  # one that does not settle
            motion = vi.exact(osc, r, clearance, run)
            found[motion.pattern.sides, round(float(motion.X[0]), 6)] = motion
    return list(found.values())


def stroboscopic_multipliers(motion, size):
    """Eigenvalues of the derivative of the stroboscopic map, by differences of simulations."""
    release = motion.events[motion.events["kind"] == "release"][0]
    shift = 0.05
    h = motion.sample(float(np.mod(release["time"] + shift, motion.period)))
    base = state((release["phase"] + shift * motion.r) / motion.r, *(float(h[i]) for i in range(4)))
    values = np.linalg.eigvals(strobe_matrix(motion.osc, motion.r, motion.clearance, base, size))
    return values[np.argsort(-np.abs(values))]


@pytest.mark.parametrize(("r", "clearance"), [(0.98828677, 5.503184141), (0.9084234, 0.890988794)])
def test_verdict_beside_a_grazing(r, clearance):
    """Within 1e-4 of a grazing `stable` agrees with the growth of small disturbances in a simulation.

    The points were found by an audit with an independent program: R*LLLL is stable there.
    """
    motions = [m for m in attractors(TURNED, r, clearance, 24) if len(m.pattern) == 5]
    assert motions
    for motion in motions:
        assert motion.pattern.sides == "LLLLR*"
        assert motion.stable
        values = stroboscopic_multipliers(motion, 2e-7 * clearance)
        assert abs(values[0]) == pytest.approx(abs(motion.multipliers[0]), abs=2e-5)


def test_a_simulated_motion_with_rest_is_not_denied():
    """`exact`, `find` and `zone` all contain the motion on which a simulation settles."""
    r, clearance = 1.100088, 3.904359
    for motion in attractors(TURNED, r, clearance, 4):
        assert motion.pattern.sides == "LR*"
        assert motion.stable
    found = vi.find(TURNED, r, clearance, max_impacts=3, max_cycles=1)
    assert [m.pattern.sides for m in found if m.stable] in (["LR*"], ["R*L"])
    zone = vi.zone(TURNED, vi.Pattern("R*L"), (1.05, 1.15), (3, 5))
    assert zone.contains(r, clearance)


def power_of_rest(restitution):
    """Return the exponent of the power law of the rest's duration near the end of its family.

    An accumulation of impacts with a closing acceleration that falls linearly through zero has a
    self-similar limit: after each impact the time s that is left shrinks by 1 - tau, and a
    distance from the limit grows by `growth`. Both follow analytically from one impact to the next: a
    gap u t - s t^2/2 + t^3/6 closes at t = tau s, and the speed there times R is the next u.
    """

    def speed(tau):  # departure speed over s^2 with which the gap closes at tau s
        return tau / 2 - tau**2 / 6

    def next_speed(tau):
        return restitution * (-speed(tau) + tau - tau**2 / 2) / (1 - tau) ** 2

    tau = brentq(lambda t: next_speed(t) - speed(t), 1e-9, 1 - 1e-9)
    h = 1e-6
    growth = (next_speed(tau + h) - next_speed(tau - h)) / (speed(tau + h) - speed(tau - h))
    return -math.log(1 - tau) / math.log(growth)


def test_the_rest_vanishes_on_the_boundary():
    """Towards the boundary the rest shortens by its power law; beyond the boundary there is no such motion."""
    zone = vi.zone(RIG, vi.Pattern("RL*"), (0.8, 1.2), (2, 200))
    assert zone.closed
    piece = max((p for p in zone.boundary if p.type == "rest_vanishes"), key=len)
    power = power_of_rest(RIG.restitution[1])
    for i in (len(piece) // 4, len(piece) // 2):
        r, edge = float(piece.r[i]), float(piece.clearance[i])
        way = 1 if zone.contains(r, edge * 1.001) else -1
        motion = vi.simulate(RIG, r, edge * (1 + way * 1e-2), 8, discard=400)
        rests = []
        for distance in 10.0 ** -np.arange(2, 10):
            motion = vi.exact(RIG, r, edge * (1 + way * distance), motion)
            time = {e["kind"]: e["time"] for e in motion.events if e["kind"] != "impact"}
            rests.append(time["release"] - time["stick"])
            assert motion.stable
        powers = -np.diff(np.log10(rests))
        assert powers[3:] == pytest.approx(power, abs=1e-3)
        assert powers[-1] == pytest.approx(power, abs=2e-4)
        for distance in (1e-9, 1e-6):
            with pytest.raises(vi.errors.SingularError):
                vi.exact(RIG, r, edge * (1 - way * distance), motion)


def test_a_narrow_zone_closes_where_a_fold_meets_the_end_of_rest():
    """A zone that is very narrow in places closes, and is the same for another lattice."""
    zone = vi.zone(HEAVY, vi.Pattern("R*L"), (0.82, 0.88), (7, 12))
    assert zone.closed
    assert {p.type for p in zone.boundary} >= {"rest_vanishes", "fold"}
    finer = vi.zone(HEAVY, vi.Pattern("R*L"), (0.82, 0.88), (7, 12), lines=65)
    assert finer.area == pytest.approx(zone.area, rel=1e-6)
    line = np.linspace(0.82, 0.88, 60_001)
    inside = line[zone.contains(line, np.full(line.size, 8.0))]
    assert inside.size
    middle = float(inside[inside.size // 2])
    motions = attractors(HEAVY, middle, 8.0, 20)
    assert {m.pattern.sides for m in motions if m.stable} & {"R*L", "LR*"}


@pytest.mark.parametrize(
    ("parameters", "sides", "r", "clearance"),
    [
        ((0.0040966909, 0.2047723022, (0.3540170312, 0.4378941026)), "LLLR*", 0.6471112477, 1.2913476063),
        ((0.0293, 0.1082, (0.8019, 0.5346)), "RL*", 0.8863, 6.241),
    ],
)  # fmt: skip
def test_zones_hold_the_attractors_with_rest(parameters, sides, r, clearance):
    """A point at which simulations settle on a motion lies in the zone of its pattern."""
    osc = vi.Oscillator(**dict(zip(("xi", "mu", "restitution"), parameters, strict=True)))
    names = {sides[j:] + sides[:j] for j in range(len(sides))}
    assert names & {motion.pattern.sides for motion in attractors(osc, r, clearance, 6)}
    zone = vi.zone(osc, vi.Pattern(sides), (r - 0.05, r + 0.05), (0.7 * clearance, 1.4 * clearance))
    assert zone.closed
    assert zone.contains(r, clearance)


@pytest.mark.parametrize("share", [1.02, 1.0, 0.995, 0.99, 0.988])
def test_a_motion_with_rest_may_have_any_number_of_impacts(share):
    """Beyond the 24 symbols of a zone, too, multipliers are those of small disturbances in a simulation."""
    osc = vi.Oscillator(
        xi=0.005237033396, mu=0.267405956, restitution=(0.6664908148, 0.789348612516)
    )
    r, clearance = 0.926034818765, 0.700744637918 * share
    motions = attractors(osc, r, clearance, 3)
    assert len(motions) == 1  # each motion once
    for motion in motions:
        assert motion.pattern.sides == "L" * (len(motion.pattern) - 1) + "R*"
        assert motion.residual < 1e-12
        assert motion.stable
        values = stroboscopic_multipliers(motion, 2e-7 * clearance)
        assert abs(values[0]) == pytest.approx(abs(motion.multipliers[0]), abs=2e-5)
    (listed,) = [m for m in vi.find(osc, r, clearance, 2, 1, guesses=2, states=4) if m.stable]
    assert listed.pattern == motions[0].pattern


def test_vertices_bound_the_stable_motions():
    """Just inside each piece of a boundary there is a stable motion, and just outside there is none."""
    osc = vi.Oscillator(xi=0.00359, mu=0.05224, restitution=(0.6257, 0.371))
    zone = vi.zone(osc, vi.Pattern("RRRL*"), (0.9, 1.1), (2, 20))
    assert zone.closed
    assert len({p.type for p in zone.boundary}) > 2
    for piece in zone.boundary:
        if piece.type == "window":
            continue
        for i in np.linspace(1, len(piece) - 2, 3).astype(int):
            r, edge = float(piece.r[i]), float(piece.clearance[i])
            for distance in (1e-6, -1e-6):
                guess = (piece.theta[0, i], piece.x[0, i] * edge)
                stable = stable_near(osc, r, edge * (1 + distance), guess)
                assert stable == bool(zone.contains(r, edge * (1 + distance))), (piece, i, distance)


def stable_near(osc, r, clearance, release):
    """Whether the return map has a stable motion RRRL* near a release."""
    try:
        motion = release_motion(osc, r, clearance, 1.0, 1, np.array([-1, *release])[:, None])
    except vi.errors.SingularError:
        return False
    if motion.pattern.sides != "RRRL*":  # near its corner there is another motion, RRL*
        return False
    phase, v = motion.events[["phase", "x_dot_after"]][-1]  # of the last event, the release
    near = math.hypot(math.remainder(phase - release[0], 2 * math.pi), v / release[1] - 1)
    return near < 0.02 and motion.stable is True


@pytest.mark.slow
def test_the_atlas_of_a_heavy_free_mass_explains_its_attractors():
    """Its zones with rest are narrow, and contain all motions of a survey within the limits."""
    atlas = vi.atlas(HEAVY, (0.6, 1.4), (0.5, 150))
    assert all(zone.closed for zone in atlas.zones)
    assert atlas.unexplained == []
    assert {"R*L", "R*LL", "RRL"} <= {zone.pattern.sides for zone in atlas.zones}
    draw = np.random.default_rng(3)
    for zone in atlas.zones:
        if not zone.pattern.has_rest:
            continue
        inside = next(
            (r, c)
            for r, c in zip(
                draw.uniform(0.6, 1.4, 100_000), np.exp(draw.uniform(-0.7, 5, 100_000)), strict=True
            )
            if zone.contains(r, c)
        )
        stable = {m.pattern for m in vi.find(HEAVY, *inside, len(zone.pattern), 1) if m.stable}
        assert zone.pattern in {pattern.standard() for pattern in stable}
