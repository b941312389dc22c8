"""Motions with rest near the ends of their family, and the exact boundaries of their zones."""

import contextlib
import math

import numpy as np
import pytest
import vibroimpact as vi
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq
from shared_simulations import state
from shared_systems import RIG
from test_exact_rest import strobe_matrix
from vibroimpact.motions.exact import release_motion

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
        with contextlib.suppress(vi.errors.VibroimpactError):  # a run that does not settle
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
    """Within 1e-4 of a grazing `stable` agrees with the growth of small perturbations in a simulation.

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
    """Return the exponent of the power law for the duration of the rest near the end of its family.

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


def settled(motion, r, clearance, discard=400):
    """Return the letters of the period on which a simulation from a release of a motion settles."""
    release = motion.events[motion.events["kind"] == "release"][0]
    unit = clearance / motion.clearance
    x, v = unit * float(release["x"]), unit * float(release["x_dot_after"])
    y = clearance / 2 if release["side"] == "R" else -clearance / 2
    start = state(float(release["phase"]) / r, x, v, x + y, v)
    run = vi.simulate(motion.osc, r, clearance, 10, start, discard=discard)
    return run.period(1, 1e-6).pattern.symbols


def least_force(motion):
    """Return the least contact force inside the rests of a motion, relative to the greatest one, by samples."""
    events = motion.events
    least = 1.0
    for i in np.flatnonzero(events["kind"] == "stick"):
        begin, end = float(events["time"][i]), float(events["time"][(i + 1) % len(events)])
        end += motion.period if end < begin else 0.0
        time = np.linspace(begin, end, 4001)
        x, x_dot = motion.sample(np.mod(time, motion.period))[:2]
        phase = motion.r * time + float(events["phase"][0]) - motion.r * float(events["time"][0])
        force = np.sin(phase) - 2 * motion.osc.xi * x_dot - x  # load, spring and dashpot
        force *= -1 if events["side"][i] == "R" else 1
        dips = force[1:-1][(force[1:-1] < force[:-2]) & (force[1:-1] < force[2:])]
        if dips.size:
            least = min(least, float(dips.min() / force.max()))
    return least


@pytest.mark.slow
def test_a_rest_splits_on_the_boundary():
    """A zone closes where the contact force touches zero inside a rest; beyond it there are two rests.

    That boundary meets the one where the gap closes again after the release in a cusp.
    """
    osc = vi.Oscillator(
        xi=0.0061398624765195324, mu=0.016622360910071847,
        restitution=(0.5106197889349746, 0.9046394803234539),
    )  # fmt: skip
    zone = vi.zone(osc, vi.Pattern("R*LL"), (0.32, 0.33), (0.28, 0.3693374205997))
    assert zone.closed
    kinds = [piece.type for piece in zone.boundary]
    assert "rest_splits" in kinds
    assert "joint" not in kinds
    piece = max((p for p in zone.boundary if p.type == "rest_splits"), key=len)
    # towards the cusp the boundaries approach each other
    for i in np.argsort(-piece.r)[[2, 5, 8]]:
        r, edge = float(piece.r[i]), float(piece.clearance[i])
        low, high = zone.count(r, [edge * (1 - 1e-4), edge * (1 + 1e-4)])
        assert abs(int(high) - int(low)) == 1
        way = 1 if high > low else -1
        clearance = edge * (1 + way * 1e-4)
        release = np.array([[1.0], [piece.theta[0, i]], [piece.x_over_D[0, i] * clearance]])
        motion = release_motion(osc, r, clearance, 1.0, 1, release)
        assert motion.stable
        assert motion.admissible
        force = least_force(motion)
        assert 0 < force < 0.01
        nearer = vi.exact(osc, r, edge * (1 + way * 1e-6), motion)
        assert 0 < least_force(nearer) < 0.1 * force
        beyond = "".join(settled(nearer, r, edge * (1 - way * 1e-4)))
        assert "R*R*" in 2 * beyond


@pytest.mark.slow
def test_a_boundary_that_turns_round_encloses_nothing():
    """Where the surface of motions ends without a condition the boundary is open: no loop retraces its own path.

    Here accumulating impacts begin to graze; a loop that returned would pass each of its corners twice.
    """
    osc = vi.Oscillator(
        xi=0.002, mu=0.0162069554296606, restitution=(0.6998675374205895, 0.4365646045162401)
    )
    zone = vi.zone(osc, vi.Pattern("RRL*"), (0.1875, 0.33), (0.0562560556, 0.900096890))
    assert len({piece.loop for piece in zone.boundary}) > 3
    for loop in {piece.loop for piece in zone.boundary if piece.loop >= 0}:
        corners = [(p.r[0], p.clearance[0]) for p in zone.boundary if p.loop == loop]
        for i, corner in enumerate(corners):
            assert all(np.hypot(*np.subtract(corner, other)) > 1e-7 for other in corners[:i])
    # the undecided part is a strip; the zone is closed along its edges
    assert not zone.closed
    assert {piece.detail for piece in zone.boundary if piece.type == "cut"} == {"r"}
    assert all(0.198 < q.r.min() <= q.r.max() < 0.202 for q in zone.open_boundary)
    assert zone.contains(0.21319097457014108, 0.4461478382868581)
    with pytest.warns(UserWarning, match="not decided"):
        zone.contains(0.1995, 0.6)


@pytest.mark.slow
def test_a_bounce_that_touches_bounds_a_zone():
    """A zone ends where a bounce of an accumulation begins to touch the wall, and closes near the loose ends.

    On one side of the boundary the motion from the same release has one impact more, a weak one while the
    acceleration opens the gap. Outside the strips of the loose ends verdicts agree with simulations.
    """
    osc = vi.Oscillator(
        xi=0.002, mu=0.0162069554296606, restitution=(0.6998675374205895, 0.4365646045162401)
    )
    zone = vi.zone(osc, vi.Pattern("RL*"), (0.1875, 0.33), (0.0562560556, 0.900096890))
    assert not zone.closed
    (piece,) = (p for p in zone.open_boundary if p.type == "grazing")
    for i in (2, len(piece) // 2, len(piece) - 3):
        r, clearance = float(piece.r[i]), float(piece.clearance[i])
        phase, v = float(piece.theta[0, i]), float(piece.x_over_D[0, i])
        impacts = []
        for there in (clearance * (1 - 1e-6), clearance * (1 + 1e-6)):
            x = math.sin(phase) - 2 * osc.xi * v * there
            run = vi.simulate(
                osc, r, there, 1, state(phase / r, x, v * there, x - there / 2, v * there)
            )
            events = run.events[run.events["kind"] == "impact"]
            push = -(np.sin(events["phase"]) - 2 * osc.xi * events["x_dot_after"] - events["x"])
            speed = events["x_dot_after"] - events["z_dot_after"]
            weak = (events["side"] == "L") & (np.abs(speed) < 0.01 * there) & (push > 0)
            impacts.append(int(np.sum(weak)))
        assert sorted(impacts) == [0, 1]
    for r, clearance in [(0.253289, 0.874915), (0.282818, 0.754742), (0.24, 0.6), (0.3, 0.6)]:
        seen = {motion.pattern.sides for motion in attractors(osc, r, clearance, 4)}
        assert bool(zone.contains(r, clearance)) == bool(seen & {"RL*", "L*R"})


@pytest.mark.parametrize("walls", [(0.75, 0.0), (0.0, 0.0)])
def test_zones_of_rest_without_restitution(walls):
    """With R = 0 a single impact is the accumulation; the boundary where its rest vanishes has two sides.

    The masses stay together on one side and part on the other: the zone of the pattern without this
    rest, which comes from the equations of motions without rest, has the same boundary.
    """
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=walls)
    sides = "RL*" if walls[0] else "R*L*"
    resting = vi.zone(osc, vi.Pattern(sides), (0.8, 1.2), (2, 100))
    assert resting.closed
    rng = np.random.default_rng(3)
    inside = 0
    for _ in range(12):
        r, clearance = float(rng.uniform(0.8, 1.2)), float(np.exp(rng.uniform(*np.log((2, 100)))))
        motions = attractors(osc, r, clearance, 6, inside)
        simulated = any(
            m.stable and set(m.pattern.symbols) == set(vi.Pattern(sides).symbols)
            and len(m.pattern.symbols) == 2 and m.pattern.cycles == 1 for m in motions
        )  # fmt: skip
        assert bool(resting.contains(r, clearance)) == simulated
        inside += simulated
    assert 0 < inside < 12
    if not walls[0]:
        return
    parting = vi.zone(osc, vi.Pattern("RL"), (0.8, 1.2), (2, 100))
    curves = [
        max((p for p in zone.boundary if p.type == "rest_vanishes"), key=len)
        for zone in (resting, parting)
    ]
    one, two = curves
    assert np.all(np.diff(two.r) < 0) or np.all(np.diff(two.r) > 0)
    way = 1 if two.r[-1] > two.r[0] else -1
    spline = CubicSpline(two.r[::way], np.log(two.clearance[::way]))
    common = (one.r > two.r.min()) & (one.r < two.r.max())
    assert common.sum() > 20
    np.testing.assert_allclose(np.log(one.clearance[common]), spline(one.r[common]), atol=2e-6)


@pytest.mark.slow
def test_a_zone_that_simulations_reach_slowly():
    """With little damping and impacts without restitution the motion is reached after hundreds of cycles."""
    osc = vi.Oscillator(
        xi=0.0009677178408478815, mu=0.0012020140301225988, restitution=(0.0, 0.0)
    )  # fmt: skip
    zone = vi.zone(osc, vi.Pattern("R*L*"), (0.22, 0.26), (0.04, 0.07))
    assert zone.closed
    assert zone.contains(0.2382373870261574, 0.05465576996014399)


@pytest.mark.slow
def test_long_accumulations():
    """A zone is found although an accumulation with R = 0.98 has 800 impacts per cycle."""
    osc = vi.Oscillator(
        xi=0.027702308414662674, mu=1.1994445585977482,
        restitution=(0.9771757564531268, 0.2980283841557604),
    )  # fmt: skip
    zone = vi.zone(osc, vi.Pattern("L*R*"), (0.62, 0.74), (0.008, 0.016))
    assert zone.contains(0.6794256273928386, 0.011559364174016444)


@pytest.mark.slow
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
    """A point at which simulations settle on a motion is in the zone of its pattern."""
    osc = vi.Oscillator(**dict(zip(("xi", "mu", "restitution"), parameters, strict=True)))
    names = {sides[j:] + sides[:j] for j in range(len(sides))}
    assert names & {motion.pattern.sides for motion in attractors(osc, r, clearance, 6)}
    zone = vi.zone(osc, vi.Pattern(sides), (r - 0.05, r + 0.05), (0.7 * clearance, 1.4 * clearance))
    assert zone.closed
    assert zone.contains(r, clearance)


@pytest.mark.parametrize("share", [1.02, 1.0, 0.995, 0.99, 0.988])
def test_a_motion_with_rest_may_have_any_number_of_impacts(share):
    """Patterns beyond the 24 symbols of a zone also have the multipliers of small perturbations in simulations."""
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
                guess = (piece.theta[0, i], piece.x_over_D[0, i] * edge)
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
