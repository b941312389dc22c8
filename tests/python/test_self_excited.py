"""Self-excited motions: no load, an unknown period, and one multiplier equal to 1."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
import vibroimpact as vi
from reference_regimes import ReferenceRegimes

BELT = {"slip": 0.6, "stick": 1.0, "speed": 0.2}


def bow(damping=0.0, mass=1.0, **belt):
    """A mass with a spring of stiffness 1 and a dashpot on a belt."""
    return vi.Structure([mass], [damping], [1.0], friction=[vi.Friction([1], **(BELT | belt))])


def self_excited(structure, duration=100.0, load=None, state=None):
    return vi.exact(structure, load, vi.simulate(structure, load, duration=duration, state=state))


#: Two coupled masses on a belt.
PAIR = vi.Structure(
    [1, 1.3], [[0.02, -0.01], [-0.01, 0.02]], [[2, -1], [-1, 2]],
    friction=[vi.Friction([1, 0], 0.5, 0.8, 0.3), vi.Friction([0, 1], 0.45, 0.7, 0.3)],
)  # fmt: skip


def slip_of(damping, mass, slip, stick, speed):
    """Position and speed of a slip as functions of the time since the spring exceeded the stick level."""
    sigma = damping / (2 * mass)
    w = math.sqrt(1 / mass - sigma**2)
    start = stick - damping * speed

    def at(t):
        # from the slip level as the origin: y'' + 2 sigma y' + y/m = 0
        a, b = start - slip, (speed + sigma * (start - slip)) / w
        decay = math.exp(-sigma * t)
        y = decay * (a * math.cos(w * t) + b * math.sin(w * t))
        rate = decay * (
            (b * w - sigma * a) * math.cos(w * t) - (a * w + sigma * b) * math.sin(w * t)
        )
        return slip + y, rate

    return at, start, w


def fastest_slip(damping, mass=1.0, slip=0.6, stick=1.0, speed=0.2):
    """When the slip is fastest after it has turned round, and its speed: at the second zero of y'', in closed
    form."""
    at, start, w = slip_of(damping, mass, slip, stick, speed)
    # y'' = e^(-sigma t) (first cos wt + second sin wt)
    first = (slip - start - damping * speed) / mass
    second = -(speed + 0.5 * damping * first) / (mass * w)
    time = (math.atan2(-first, second) % math.pi + math.pi) / w
    return time, at(time)[1]


def matched_period(damping, mass=1.0, slip=0.6, stick=1.0, speed=0.2):
    """The time of a slip, from where the spring overcomes the stick level to where the mass is as fast as the belt
    again, in closed form with a bisection, and that in which the belt then carries the mass back."""
    at, start, w = slip_of(damping, mass, slip, stick, speed)
    # between its turn and its greatest speed it becomes ever faster
    high = fastest_slip(damping, mass, slip, stick, speed)[0]
    low = high - math.pi / w
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if at(middle)[1] < speed else (low, middle)
    return low + (start - at(low)[0]) / speed


@pytest.mark.parametrize(("damping", "mass", "speed"), [
    (0, 1, 0.2), (0.02, 1, 0.2), (0.1, 1, 0.2), (0.05, 2.5, 0.1),
])  # fmt: skip
def test_period_of_stick_and_slip(damping, mass, speed):
    """Stick and slip phases that are computed separately and matched."""
    motion = self_excited(bow(damping, mass, speed=speed))
    assert motion.period == pytest.approx(matched_period(damping, mass, speed=speed), rel=1e-13)
    if not damping and mass == 1:
        assert motion.period == pytest.approx(8.068887871591405, rel=1e-14)
    assert motion.self_excited
    assert motion.phases[0] == 0
    assert motion.multipliers[motion.trivial] == pytest.approx(1, abs=1e-12)
    assert np.abs(motion.multipliers[1 - motion.trivial]) < 1e-12  # sticking friction
    assert motion.stable
    assert motion.admissible
    assert motion.law == 0


def test_two_masses_by_an_independent_program():
    """The motion returns after a period, and the traces of [P] equal those of differences."""
    motion = self_excited(PAIR, 600)
    assert len({*motion.gaps.tolist()}) == 2
    _, (q, rate) = motion._run()._between_events()
    assert min(abs(rate - 0.3)) > 0.1  # both masses slip there
    reference = ReferenceRegimes(PAIR, None, 5e-3)
    state = np.concatenate([q, rate])

    def after(state):
        reference.simulate(motion.period, np.split(state, 2))
        return reference.final.copy()

    assert after(state) == pytest.approx(state, abs=1e-9)
    steps = 1e-6 * np.eye(4)
    P = np.transpose([(after(state + step) - after(state - step)) / 2e-6 for step in steps])
    found = [np.sum(motion.multipliers**k).real for k in (1, 2)]
    assert found == pytest.approx([np.trace(P), np.trace(P @ P)], abs=1e-6)


def test_exponents_are_logarithms_of_the_multipliers():
    """The trivial multiplier is the exponent 0."""
    motion = self_excited(PAIR, 600)
    others = np.sort(np.abs(np.delete(motion.multipliers, motion.trivial)))[::-1]
    found = vi.lyapunov(PAIR, vi.Load.none(), cycles=8000, discard=600)
    assert found.exponents[0] == pytest.approx(0, abs=1e-6)
    assert found.exponents[1:3] == pytest.approx(np.log(others[:2]) / motion.period, abs=1e-5)
    assert found.exponents[3] == -np.inf
    assert others[2] < 1e-12


def test_from_another_motion_and_under_a_constant_force():
    """A constant force shifts the motion and keeps the period; neighbouring motions are found from each other."""
    motion = self_excited(bow())
    load = vi.Load(constant=[0.3])
    pushed = vi.exact(bow(), load, vi.simulate(bow(), load, duration=60))
    assert pushed.period == pytest.approx(motion.period, rel=1e-13)
    assert pushed.states[:, 0] == pytest.approx(motion.states[:, 0] + 0.3, abs=1e-13)
    assert pushed.multipliers == pytest.approx(motion.multipliers, abs=1e-12)
    again = vi.exact(bow(0.02), vi.Load.none(), motion)
    assert again.period == pytest.approx(matched_period(0.02), rel=1e-13)
    q, rate = motion.sample([0.3, 0.3 + motion.period])
    assert q[:, 0] == pytest.approx(q[:, 1], abs=1e-12)
    assert rate[:, 0] == pytest.approx(rate[:, 1], abs=1e-12)


def test_files_and_namelists(tmp_path):
    motion = self_excited(PAIR, 600)
    motion.save(tmp_path / "motion.json")
    loaded = vi.load(tmp_path / "motion.json")
    assert loaded.period == motion.period
    assert loaded.trivial == motion.trivial
    assert np.array_equal(loaded.multipliers, motion.multipliers)
    case = tmp_path / "again.nml"
    case.write_text(motion.to_namelist())
    vi.run_namelists([case], tmp_path)
    rows = [
        line for line in (tmp_path / "again.csv").read_text().splitlines() if line[0] not in "#i"
    ]
    phases = [float(row.split(",")[2]) for row in rows]
    assert phases == motion.phases.tolist()
    vi.exact(PAIR, None, loaded)


@pytest.mark.parametrize(("parameter", "bounds"), [
    ("speed", (0.05, 0.6)), ("slip", (0.3, 0.9)), ("stick", (0.8, 2.0)), ("damping", (0.1, 3.0)),
])  # fmt: skip
def test_branches_in_closed_form(parameter, bounds):
    """The period along a branch equals the closed form, and so does that of the motion at a point."""
    own = BELT | {"damping": 0.02}
    branch = vi.branch(self_excited(bow(0.02)), parameter, bounds=bounds)
    assert branch.ends == ("bound of the parameter",) * 2
    assert branch.self_excited
    for i in range(0, len(branch), max(1, len(branch) // 20)):
        value = float(branch.values[i])
        here = own | {parameter: 0.02 * value if parameter == "damping" else value}
        if parameter == "slip":
            here["stick"] = value / 0.6
        assert branch.period[i] == pytest.approx(matched_period(**here), rel=1e-13)
    assert branch.residual.max() < 1e-13
    assert branch.multipliers[0] == pytest.approx(1, abs=1e-12)
    assert np.abs(branch.multipliers[1]).max() < 1e-12
    assert (branch.admissible == 1).all()
    assert 0 not in branch.stable
    point = branch[len(branch) // 2]
    assert point.self_excited
    assert point.period == pytest.approx(branch.period[len(branch) // 2], rel=1e-13)


def test_a_halt_vanishes():
    """Damping ends stick-slip where the fastest slip just reaches the speed of the belt."""
    branch = vi.branch(self_excited(bow(0.05)), "damping_0_0", bounds=(0.01, 1.0))
    (end,) = (point for point in branch.special_points if point.type == "event_vanishes")
    assert "a halt or a slip vanishes" in branch.ends
    assert end.detail.startswith("friction 0")
    assert np.isnan(branch.multipliers[:, end.index]).all()
    assert (branch.stable[end.index], branch.admissible[end.index]) == (-1, -1)
    # y'' = 0 there: the spring and the dashpot balance the slip level at the speed of the belt
    at, _, w = slip_of(end.value, 1.0, 0.6, 1.0, 0.2)
    t = np.linspace(math.pi / w, 2 * math.pi / w, 200_001)
    rates = np.array([at(time)[1] for time in t[::100]])
    near = t[::100][rates.argmax()] + np.linspace(-2e-3, 2e-3, 2001)
    assert max(at(time)[1] for time in near) == pytest.approx(0.2, abs=1e-11)
    with pytest.raises(vi.SingularError, match="a motion without impacts"):
        self_excited(bow(end.value + 1e-3))


PLANE = ("speed", (0.05, 0.6)), ("damping_0_0", (0.01, 0.6))


@pytest.fixture(scope="module")
def squeal():
    """The region where the mass on the belt squeals, over the speed of the belt and the damping."""
    return vi.zone(self_excited(bow(0.05)), *PLANE, lines=7)


def test_zone_is_drawn(squeal):
    """Each kind of boundary has a separate line in the legend."""
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    labels = {text.get_text() for text in squeal.plot().get_legend().get_texts()}
    assert any("event" in label for label in labels), labels


def test_zone_in_closed_form(squeal, tmp_path):
    """It ends where the fastest slip is just as fast as the belt. The periods along it are those of the closed
    form, and its motions those of simulations."""
    assert squeal.closed
    assert squeal.self_excited
    assert {piece.type for piece in squeal.boundary} == {"window", "event_vanishes"}
    assert squeal.load.frequency
    for piece in squeal.boundary:
        for i in range(0, len(piece), 10):
            x, y = float(piece.x[i]), float(piece.y[i])
            if piece.type == "event_vanishes":
                assert fastest_slip(y, speed=x)[1] == pytest.approx(x, rel=1e-10)
            else:
                assert piece.period[i] == pytest.approx(matched_period(y, speed=x), rel=1e-11)
    assert piece.phases[-1] == pytest.approx([2 * math.pi] * len(piece))
    rng = np.random.default_rng(3)
    x, y = rng.uniform(*PLANE[0][1], 200), rng.uniform(*PLANE[1][1], 200)
    inside = squeal.contains(x, y)
    assert 20 < inside.sum() < 180
    for i, (speed, damping) in enumerate(zip(x.tolist(), y.tolist(), strict=True)):
        assert inside[i] == (fastest_slip(damping, speed=speed)[1] > speed)
        # a mass that has stuck sticks again or slides permanently
        run = vi.simulate(
            bow(damping, speed=speed), duration=200, state=([1 - damping * speed], [speed])
        )
        assert inside[i] == ("halt" in run.events["kind"].tolist()[1:])
        if i % 20 == 0:
            found = squeal.motion(speed, damping)
            assert (found is not None) == inside[i]
            if found is not None:
                assert found.stable
                assert found.period == pytest.approx(
                    matched_period(damping, speed=speed), rel=1e-12
                )
                again = vi.exact(*squeal.at(speed, damping), run)
                assert again.period == pytest.approx(found.period, rel=1e-12)
    squeal.save(tmp_path / "zone.json")
    again = vi.load(tmp_path / "zone.json")
    assert again.boundary[0].period.tolist() == squeal.boundary[0].period.tolist()
    case = tmp_path / "squeal.nml"
    case.write_text(squeal.to_namelist())
    vi.run_namelists([case], tmp_path)
    squeal.save(tmp_path / "saved.csv")
    one, two = (
        [line for line in (tmp_path / name).read_text().splitlines() if line[0] != "#"]
        for name in ("squeal.csv", "saved.csv")
    )
    assert one == two


@pytest.mark.slow
def test_an_atlas_has_the_zone(squeal, tmp_path):
    """An atlas knows no motion, and finds the same zone: each motion of its survey lies in it."""
    atlas = vi.atlas(bow(0.05), vi.Load.none(), *PLANE, survey=12, settling=60, lines=9)
    (zone,) = atlas.zones
    assert zone.closed
    assert len(atlas.unexplained) == 0
    counts = atlas.survey.counts
    assert counts["periodic"] > 1
    assert counts["periodic"] + counts["without impacts"] == 12
    for piece in zone.boundary:
        for x, y in zip(piece.x[::10].tolist(), piece.y[::10].tolist(), strict=True):
            if piece.type == "event_vanishes":
                assert fastest_slip(y, speed=x)[1] == pytest.approx(x, rel=1e-10)
    x, y = np.random.default_rng(4).uniform(*zip(PLANE[0][1], PLANE[1][1], strict=True), (200, 2)).T
    assert (zone.contains(x, y) == squeal.contains(x, y)).all()
    atlas.save(tmp_path / "atlas.json")
    assert repr(vi.load(tmp_path / "atlas.json")) == repr(atlas)
    (case,) = vi.read_namelist(_written(tmp_path, atlas.to_namelist()))
    assert case.text.startswith(atlas.case)


def reaches_the_belt(damping, q, rate, slip=0.6, speed=0.2):
    """Whether a slipping mass of 1 on a spring of 1 becomes as fast as the belt, in closed form."""
    sigma = damping / 2
    w = math.sqrt(1 - sigma**2)
    # q - slip = e^(-sigma t) (a cos wt + b sin wt); the speed is greatest where the acceleration vanishes
    a = q - slip
    b = (rate + sigma * a) / w
    velocity = b * w - sigma * a, -(a * w + sigma * b)
    acceleration = velocity[1] * w - sigma * velocity[0], -(velocity[0] * w + sigma * velocity[1])
    first = math.atan2(-acceleration[0], acceleration[1]) % math.pi
    peaks = [
        math.exp(-sigma * t / w) * (velocity[0] * math.cos(t) + velocity[1] * math.sin(t))
        for t in (first, first + math.pi)
    ]
    return max(rate, *peaks) - speed


def test_basins_in_closed_form(tmp_path):
    """A mass that slips more slowly than the belt sticks later, and goes on to stick and slip, or slides steadily
    for ever: the closed form of a slip tells which."""
    damping = 0.1
    plane = (("q_0", (-0.2, 1.4)), ("q_dot_0", (-0.6, 0.19)))
    basins = vi.basins(bow(damping), vi.Load.none(), plane, points=(15, 14), settling=20)
    assert [one.name for one in basins.attractors] == ["2/1", "equilibrium"]
    cycle = basins.attractors[0].motion
    assert cycle.self_excited
    assert cycle.period == pytest.approx(self_excited(bow(damping)).period, rel=1e-12)
    q, rate = basins.states[:, 0]
    margin = np.vectorize(reaches_the_belt)(damping, q, rate)
    clear = abs(margin) > 1e-9
    assert clear.mean() > 0.9
    assert ((margin > 0) == (basins.labels == 0))[clear].all()
    assert 0.05 < (basins.labels == 1).mean() < 0.95
    basins.save(tmp_path / "basins.json")
    again = vi.load(tmp_path / "basins.json")
    assert (again.labels == basins.labels).all()
    assert again.attractors[0].motion.period == cycle.period
    (case,) = vi.read_namelist(_written(tmp_path, basins.to_namelist()))
    assert (case.run()[0].labels == basins.labels).all()


def test_basins_beyond_the_end_of_the_branch():
    """Where stick-slip is damped out, all states slide steadily; a constant force moves the equilibrium alone."""
    for load in (None, vi.Load(constant=[0.3])):
        basins = vi.basins(bow(0.2908), load, states=10, settling=100)
        assert [one.name for one in basins.attractors] == ["equilibrium"]
        assert basins.fractions == pytest.approx([1.0])
        assert basins.attractors[0].motion is None


def test_what_nothing_damps_is_no_equilibrium():
    """Without a dashpot a mass slides on, however large the other states of the plane are."""
    for high in (0.7, 1000.0):
        plane = (("q_0", (0.65, high)), ("q_dot_0", (0.01, high)))
        basins = vi.basins(bow(0.0), None, plane, points=2, settling=20)
        assert basins.labels[0, 0] == -1


def test_a_chart_has_the_periods():
    """One motion at each point before the end of stick-slip, with the period of the closed form."""
    pytest.importorskip("xarray")
    chart = vi.chart(self_excited(bow(0.05)), *PLANE, points=(4, 5))
    good = (chart.admissible.values == 1) & (chart.stable.values == 1)
    for (j, damping), (i, speed) in itertools.product(
        enumerate(chart.y.values.tolist()), enumerate(chart.x.values.tolist())
    ):
        assert good[:, j, i].sum() == (fastest_slip(damping, speed=speed)[1] > speed)
        if good[:, j, i].any():
            period = float(chart.period.values[good[:, j, i].argmax(), j, i])
            assert period == pytest.approx(matched_period(damping, speed=speed), rel=1e-11)


#: Two coupled masses, the first of them on a belt.
FLIPPING = vi.Structure(
    [1, 1.3], [[0.03, -0.012], [-0.012, 0.036]], [[1.5, -0.6], [-0.6, 1.8]],
    friction=[vi.Friction([1, 0], 0.49, 0.87, 0.15)],
)  # fmt: skip
TURNING = vi.Structure(
    [1, 0.7], [[0.024, -0.008], [-0.008, 0.044]], [[1.2, -0.4], [-0.4, 2.2]],
    friction=[vi.Friction([1, 0], 0.53, 0.79, 0.15)],
)  # fmt: skip


def test_period_doubling():
    """Where a multiplier passes -1 a motion of twice the period begins, and its branch ends at that flip."""
    branch = vi.branch(self_excited(FLIPPING, 400), "speed", bounds=(0.05, 0.4))
    flips = [point for point in branch.special_points if point.type == "flip"]
    flip = flips[int(np.argmin([abs(point.value - 0.0969) for point in flips]))]
    assert np.abs(branch.multipliers[:, flip.index] + 1).min() < 1e-8
    unstable = np.flatnonzero((branch.stable == 0) & (np.abs(branch.values - flip.value) < 4e-3))
    beside = branch[int(unstable[np.abs(branch.values[unstable] - flip.value).argmax()])]
    q, rate = beside._run()._between_events()[1]
    run = vi.simulate(beside.structure, duration=3000, state=(1.001 * q, rate))
    double = vi.exact(beside.structure, None, run)
    assert len(double.phases) == 2 * len(beside.phases)
    assert double.period == pytest.approx(2 * beside.period, rel=0.02)
    assert double.stable
    assert not beside.stable
    doubled = vi.branch(double, "speed", bounds=(0.05, 0.4))
    place = doubled.ends.index("meets a motion that repeats itself")
    assert doubled.values[-place] == pytest.approx(flip.value, abs=1e-8)
    assert doubled.period[-place] == pytest.approx(2 * branch.period[flip.index], rel=1e-8)


@pytest.mark.slow
def test_zone_of_two_masses():
    """Motions scale with the speed of the belt and all friction forces together, so that flips lie on rays from
    the origin, along which the period is constant; inside, simulations of disturbed motions return to them."""
    motion = self_excited(FLIPPING, 400)
    zone = vi.zone(motion, ("speed", 0.05, 0.4), ("slip", 0.35, 0.6), lines=7)
    assert zone.closed
    branch = vi.branch(motion, "speed", bounds=(0.05, 0.4))
    expected = sorted(point.value / 0.49 for point in branch.special_points if point.type == "flip")
    rays = []
    for piece in zone.boundary:
        assert piece.type in ("window", "flip")
        if piece.type == "flip":
            rays.append(float(np.mean(piece.x / piece.y)))
            assert piece.x / piece.y == pytest.approx([rays[-1]] * len(piece), rel=1e-9)
            assert piece.period == pytest.approx([piece.period[0]] * len(piece), rel=1e-9)
    assert sorted(rays) == pytest.approx(expected, rel=1e-9)
    rng = np.random.default_rng(4)
    for x, y in zip(
        rng.uniform(0.05, 0.4, 12).tolist(), rng.uniform(0.35, 0.6, 12).tolist(), strict=True
    ):
        found = zone.motion(x, y)
        assert (found is not None and bool(found.stable)) == zone.contains(x, y)
        if not zone.contains(x, y):
            continue
        _, state = found._run()._between_events()
        run = vi.simulate(
            zone.at(x, y)[0], duration=200 * found.period, state=[1.0001 * state[0], state[1]]
        )
        halts = run.events["time"][run.events["kind"] == "halt"]
        assert np.diff(halts)[-3:] == pytest.approx([found.period] * 3, rel=1e-9)


def test_folds_and_neimark_sacker_points():
    """The parameter turns back at folds, where one more multiplier is 1; motions that are simulated there have the
    multipliers of the branch, and its verdicts."""
    branch = vi.branch(self_excited(TURNING, 400), "speed", bounds=(0.05, 0.4))
    kinds = [point.type for point in branch.special_points]
    assert {"fold", "neimark_sacker"} <= {*kinds}
    turns = np.flatnonzero(np.diff(np.sign(np.diff(branch.values)))) + 1
    folds = [point.index for point in branch.special_points if point.type == "fold"]
    assert folds == turns.tolist()
    for point in branch.special_points:
        found = branch.multipliers[:, point.index]
        if point.type == "fold":
            assert np.sort(np.abs(found - 1))[1] < 1e-6
            assert branch.stable[point.index] == -1
        elif point.type == "neimark_sacker":
            others = found[np.abs(found.imag) > 0]
            assert np.abs(others) == pytest.approx(1, abs=1e-9)
    for i in range(1, len(branch), 7):
        if branch.admissible[i] != 1 or i in folds:
            continue
        point = branch[i]
        assert point.period == pytest.approx(branch.period[i], rel=1e-9)
        assert np.sort(np.abs(point.multipliers)) == pytest.approx(
            np.sort(np.abs(branch.multipliers[:, i])), rel=1e-5, abs=1e-7
        )
        if branch.stable[i] >= 0 and point.stable is not None:
            assert point.stable == bool(branch.stable[i])


def from_same_event(motion, first):
    """The quantities of a motion from the event that comes first in another one near it, and the sum of its
    multipliers."""
    m = len(first.phases)
    states = [np.abs(np.roll(motion.states, -i, axis=0) - first.states).max() for i in range(m)]
    i = int(np.argmin(states))
    phases = np.roll(motion.phases, -i) - motion.phases[i]
    q, q_dot = np.roll(motion.states, -i, axis=0).transpose(1, 0, 2)
    return {
        "period": motion.period, "phases": np.mod(phases, 2 * math.pi),
        "speeds": np.roll(motion.speeds, -i), "impulses": np.roll(motion.impulses, -i),
        "q": q, "q_dot": q_dot, "multipliers": motion.multipliers.sum().real,
    }  # fmt: skip


@pytest.mark.parametrize("structure", [
    bow(0.02), PAIR, FLIPPING,
    vi.Structure([1], [0.02], [1], [vi.Stop([-1], -0.4, 5, 0.1)], [vi.Friction([1], 0.6, 1.0, 0.2)]),
    vi.Structure([1], [0.02], [1], [vi.Gap([-1], -0.4, 0.6)], [vi.Friction([1], 0.6, 1.0, 0.2)]),
], ids=["bow", "pair", "one belt", "stop", "gap"])  # fmt: skip
def test_derivatives(structure):
    """The period, its events and multipliers change as differences of exact motions do."""
    first, h = len(structure.gaps), 1e-6
    motion = self_excited(structure, 400, state=([0.5], [0.2]) if structure.gaps else None)

    def changed(word, step):
        own = structure.friction[0]
        slip = own.slip + step * (word == "slip")
        values = {"slip": slip, "stick": own.stick * slip / own.slip + step * (word == "stick")}
        belt = replace(own, **values, speed=own.speed + step * (word == "speed"))
        found = vi.Structure(
            structure.mass, structure.damping * (1 + step * (word == "damping")), structure.stiffness,
            structure.gaps, [belt, *structure.friction[1:]],
        )  # fmt: skip
        return from_same_event(vi.exact(found, None, motion), motion)

    words = ["speed", "slip", "stick", "damping"]
    gradient = motion.gradient([word if word == "damping" else f"{word}_{first}" for word in words])
    assert gradient["phases"][0].tolist() == [0.0] * 4
    for word, name in zip(words, gradient.parameters, strict=True):
        up, down = changed(word, h), changed(word, -h)
        for quantity, value in up.items():
            slope = (value - down[quantity]) / (2 * h)
            own = gradient[quantity, name]
            if quantity == "multipliers":
                own = np.nansum(own).real
            assert own == pytest.approx(slope, rel=1e-6, abs=1e-6), (name, quantity)
    # the period does not depend on a constant force, which shifts the motion
    if structure == bow(0.02):
        pushed = ("push", lambda f: (bow(0.02), vi.Load(constant=[f])), 0.0)
        found = motion.gradient([pushed])
        assert abs(found["period", "push"]) < 1e-12
        assert found["q", "push"] == pytest.approx(np.ones((2, 1)), abs=1e-12)


def test_branches_by_functions_and_files(tmp_path):
    """A function of a parameter gives the same branch; files and namelists keep the periods."""
    motion = self_excited(bow())
    named = vi.branch(motion, "speed", bounds=(0.1, 0.3))
    branch = vi.branch(motion, lambda v: (bow(speed=v), vi.Load.none()), bounds=(0.1, 0.3), at=0.2)
    assert branch.period == pytest.approx(named.period, rel=1e-12)
    assert branch.at(0.25)[0].friction[0].speed == pytest.approx(0.25, rel=1e-15)
    named.save(tmp_path / "branch.json")
    loaded = vi.load(tmp_path / "branch.json")
    assert loaded.period.tolist() == named.period.tolist()
    assert loaded[3].period == pytest.approx(named.period[3], rel=1e-13)
    case = tmp_path / "again.nml"
    case.write_text(named.case)
    again = vi.read_namelist(case)[0].run()[0]
    assert again.period.tolist() == named.period.tolist()
    # under a load the period is that of the load
    load = vi.Load(0.7, cosine=[1.0])
    stop = vi.Structure([1.0], [0.1], [1.0], [vi.Stop([1.0], 0.5, 4.0)])
    forced = vi.branch(
        vi.exact(stop, load, vi.simulate(stop, load, cycles=100)), "frequency", (0.69, 0.71)
    )
    assert not forced.self_excited
    assert forced.period == pytest.approx(2 * math.pi / forced.values, rel=1e-14)


def test_two_periods_are_not_followed_as_one(tmp_path):
    """A motion counted over twice its period is distinguished from one whose period has doubled."""
    motion = self_excited(bow())
    q, rate = (float(values[0]) for values in motion._run()._between_events()[1])
    case = tmp_path / "case.nml"
    case.write_text(motion.to_namelist().split("&motion")[0] + (
        f"&motion kind = 'settled', q = {q}, q_dot = {rate}, period = {2 * motion.period} /\n"
        "&branch parameter = 'slip', low = .5, high = .7 /\n"
    ))  # fmt: skip
    with pytest.raises(vi.SingularError, match="repeats itself within its period"):
        vi.read_namelist(case)[0].run()


def test_what_is_not_self_excited():
    """Permanent sliding, permanent sticking, no repetition, and other verbs are refused by name."""
    with pytest.raises(vi.SingularError, match="a motion without impacts"):
        self_excited(bow(0.5))
    with pytest.raises(vi.SingularError, match="a permanent rest"):
        self_excited(bow(speed=0.0), 10)
    with pytest.raises(vi.SingularError, match="does not repeat"):
        self_excited(bow(), 3 * 8.068887871591405 / 2)
    motion = self_excited(bow())
    for name in ("frequency", "load", "wall"):
        with pytest.raises(vi.ParameterError, match="a self-excited motion has no load") as caught:
            vi.branch(motion, name, bounds=(0.5, 0.9))
        # the refused verb is not among the allowed ones
        assert str(caught.value).count(f"'{name}'") == 1
        for verb in (vi.zone, vi.chart):
            with pytest.raises(vi.ParameterError, match=f"y.0. = '{name}': must be another one"):
                verb(motion, ("speed", (0.1, 0.3)), (name, (0.5, 0.9)))
    with pytest.raises(vi.ParameterError, match="a stick level must be at least the slip level"):
        vi.branch(motion, "stick", bounds=(0.5, 1.2))
    with pytest.raises(
        vi.ParameterError, match="must be a Trajectory, as from simulate, or a Motion"
    ):
        vi.exact(bow(), vi.Load.none(), ([0.1], [0]))
    with pytest.raises(vi.ParameterError, match="a self-excited motion has no load"):
        vi.atlas(bow(), None, ("speed", (0.1, 0.3)), ("frequency", (0.5, 0.9)))
    free = vi.Structure([1.0], [0.1], [0.0], friction=[vi.Friction([1], **BELT)])
    with pytest.raises(vi.SingularError, match="no spring holds it"):
        vi.basins(free, None, states=3)
    with pytest.raises(vi.SingularError, match="no spring holds it"):
        vi.atlas(free, None, ("speed", (0.1, 0.3)), ("damping_0_0", (0.1, 0.5)), survey=3)
    with pytest.raises(vi.ParameterError, match="must have 2 coordinates"):
        vi.exact(PAIR, vi.Load.none(), motion)


@pytest.mark.parametrize(("load", "keys", "message"), [
    ("&load frequency = 1, cosine = 1 /", "duration = 50", "the &load has a frequency"),
    ("&load frequency = 1, cosine = 1 /", "period = 8", "the &load has a frequency"),
    ("", "", "it requires a &load with a frequency"),
    ("", "duration = 0", "must be a number with 0 < duration"),
    ("", "duration = 50 / &zone x = 'slip', x_low = .5, x_high = .7, y = 'load', y_low = .1, y_high = .3",
     "&zone y = 'load': must be another one"),
])  # fmt: skip
def test_bad_namelists(tmp_path, load, keys, message):
    case = tmp_path / "case.nml"
    case.write_text(
        "&structure mass = 1, damping = 0, stiffness = 1 /\n"
        f"&friction direction = 1, slip = .6, stick = 1, speed = .2 /\n{load}\n"
        f"&motion kind = 'settled', {keys} /\n"
    )
    with pytest.raises(vi.ParameterError, match=message):
        vi.read_namelist(case)


@pytest.mark.parametrize("damping", [0.02, 0.28])
def test_a_search_finds_the_one_limit_cycle(damping, tmp_path):
    """The motion equals that of `exact`, listed once whatever its first event; other states slide steadily."""
    found = vi.find(bow(damping), vi.Load.none())
    (motion,) = found
    assert motion.self_excited
    assert motion.period == pytest.approx(self_excited(bow(damping)).period, rel=1e-13)
    assert motion.multipliers[motion.trivial] == pytest.approx(1, abs=1e-12)
    assert (found.settled[0] + found.without_impacts, found.unsettled) == (24, 0)
    pushed = vi.find(bow(damping), vi.Load(constant=[0.3]))
    assert [one.period for one in pushed] == pytest.approx([motion.period], rel=1e-12)
    found.save(tmp_path / "found.json")
    loaded = vi.load(tmp_path / "found.json")
    assert loaded[0].period == motion.period
    assert (loaded.settled, loaded.without_impacts) == (found.settled, found.without_impacts)
    again = vi.exact(bow(damping), vi.Load.none(), loaded[0])
    assert again.period == pytest.approx(motion.period, rel=1e-13)
    (case,) = vi.read_namelist(_written(tmp_path, found.to_namelist()))
    assert case.run()[0][0].period == motion.period


def _written(folder, text):
    path = folder / "case.nml"
    path.write_text(text)
    return path


def test_a_search_beyond_the_end_of_the_branch_finds_no_motion():
    found = vi.find(bow(0.2908), vi.Load.none())
    assert (len(found), found.without_impacts, found.unsettled) == (0, 24, 0)
    assert "24 states in an equilibrium" in repr(found)


def test_a_search_says_why_incommensurate_motions_are_not_found():
    """Two masses that stick and slip independently have no common period; one of them may slide steadily."""
    belts = [vi.Friction([1, 0], **BELT), vi.Friction([0, 1], **BELT | {"speed": 0.25})]
    apart = vi.Structure([1, 1], [[0.02, 0], [0, 0.02]], [[1, 0], [0, 1.7]], friction=belts)
    found = vi.find(apart, vi.Load.none(), states=6, settling=100)
    assert all(len({*motion.gaps.tolist()}) == 1 for motion in found)
    assert found.unsettled > 0
    assert any("does not repeat" in text for text in found.failures)


def test_searches_of_random_systems():
    """Each motion found returns to itself in simulation, and no two are the same."""
    rng = np.random.default_rng(45)
    number = 0
    for _ in range(30):
        n = int(rng.integers(1, 3))
        coupling = rng.uniform(0.1, 0.6) * (n > 1)
        stiffness = np.diag(rng.uniform(0.8, 2.0, n)) + coupling * (2 * np.eye(n) - 1)
        slip = rng.uniform(0.3, 0.7, n)
        belts = [
            vi.Friction(np.eye(n)[i], slip[i], slip[i] * rng.uniform(1.2, 2.0), rng.uniform(0.1, 0.3))
            for i in range(n)
        ]  # fmt: skip
        damping = rng.uniform(0.01, 0.08) * stiffness
        structure = vi.Structure(rng.uniform(0.5, 1.5, n), damping, stiffness, friction=belts)
        found = vi.find(structure, vi.Load.none(), states=4, settling=60)
        assert sum(found.settled) + found.without_impacts + found.unsettled == 4
        for motion in found:
            number += 1
            _, state = motion._run()._between_events()
            end = vi.simulate(structure, duration=motion.period, state=state).final_state
            assert np.abs(np.subtract(end, state)).max() < 1e-9 * max(1, np.abs(state).max())
        periods = sorted((motion.period, len(motion.phases)) for motion in found)
        for one, other in itertools.pairwise(periods):
            assert abs(one[0] - other[0]) > 1e-6 or n > 1
    assert number >= 15


# -- motions that are their own mirror images


def between_belts(stick):
    """A mass between two belts in opposite directions, with a second mass between two stops."""
    belts = [vi.Friction([side, 0], slip=0.6, stick=stick, speed=0.32) for side in (1, -1)]
    stops = [vi.Stop([0, side], 0.54, 5.0) for side in (1, -1)]
    return vi.Structure([1, 0.13], [0.01, 0.01], [[1.9, -0.9], [-0.9, 1.2]], stops, belts)


def half_map(motion):
    """Minus the derivative of half a period, by differences of simulations, from a flight without stick."""
    system, period = motion.structure, motion.period
    run = motion._run()
    times = np.append(run.events["time"], run.end)
    middles = 0.5 * (times[1:] + times[:-1])[np.diff(times) > 0.05]
    q, rate = run.sample(middles)
    free = np.abs(np.abs(rate[0]) - 0.32) > 1e-2
    at = np.flatnonzero(free)[0]
    state = np.concatenate([q[:, at], rate[:, at]])

    def moved(start):
        run = vi.simulate(system, vi.Load.none(), duration=period / 2, state=(start[:2], start[2:]))
        return -np.concatenate(run.final_state)

    assert moved(state) == pytest.approx(state, abs=1e-9)
    steps = 1e-6 * np.eye(4)
    return np.array([(moved(state + h) - moved(state - h)) / 2e-6 for h in steps]).T


def test_a_symmetric_self_excited_motion_has_pitchforks():
    """Half a period and the mirror are the map Q with [P] = Q^2: a pitchfork is where a multiplier of Q passes -1,
    by differences of simulations, and multipliers along the branch are those of `exact` over the whole period."""
    (motion,) = vi.find(between_belts(1.72), vi.Load.none(), states=8)
    branch = vi.branch(motion, "stick", bounds=(1.7, 2.0))
    points = [point for point in branch.special_points if point.type == "pitchfork"]
    assert [point.type for point in branch.special_points] == [
        "bound",
        "pitchfork",
        "pitchfork",
        "bound",
    ]
    for point in points:
        one = branch.multipliers[:, point.index] - 1
        assert np.sort(np.abs(one))[:2] == pytest.approx(0, abs=1e-7)
    assert [branch.stable[i] for i in (0, points[0].index + 1, -1)] == [1, 0, 1]
    for i in (5, len(branch) - 6):
        whole = vi.exact(between_belts(branch.values[i]), vi.Load.none(), branch[i])
        assert branch.period[i] == pytest.approx(whole.period, rel=1e-13)
        assert np.sort_complex(branch.multipliers[:, i]) == pytest.approx(
            np.sort_complex(whole.multipliers), abs=1e-12
        )
    near = points[0].index + np.array([-2, -1, 1, 2])
    least = []
    for i in near:
        found = np.linalg.eigvals(half_map(branch[int(i)]))
        assert np.abs(found - 1).min() < 1e-6  # the trivial one
        assert np.sort_complex(found**2) == pytest.approx(
            np.sort_complex(branch.multipliers[:, i]), abs=1e-6
        )
        least.append(found.real.min())
    assert least[0] > least[1] > -1 > least[2] > least[3]
    away = branch.values[near] - points[0].value
    assert np.polyfit(away, least, 3)[-1] == pytest.approx(-1, abs=1e-3)


def test_only_one_belt_breaks_the_symmetry():
    """Along the speed of one of two belts the motion is symmetric at one value alone, so there is no pitchfork."""
    (motion,) = vi.find(between_belts(1.72), vi.Load.none(), states=8)
    both = vi.branch(motion, "speed", bounds=(0.31, 0.33))
    one = vi.branch(motion, "speed_2", bounds=(0.31, 0.33))
    i, j = (int(np.abs(branch.values - 0.32).argmin()) for branch in (both, one))
    assert both.period[i] == pytest.approx(one.period[j], rel=1e-6)
    assert all(point.type != "pitchfork" for point in one.special_points)
    states = vi.exact(one[0].structure, vi.Load.none(), one[0]).states
    assert np.abs(np.roll(states, -4, axis=0) + states).max() > 1e-4


def test_a_zone_of_symmetric_self_excited_motions_is_bounded_by_pitchforks():
    """The boundary passes through the pitchforks of the branch."""
    (motion,) = vi.find(between_belts(1.72), vi.Load.none(), states=8)
    zone = vi.zone(motion, ("stick", 1.72, 2.0), ("speed", 0.31, 0.33), lines=5)
    assert zone.closed
    assert {piece.type for piece in zone.boundary} == {"pitchfork", "window"}
    branch = vi.branch(motion, "stick", bounds=(1.7, 2.0))
    _, first, second, _ = branch.special_points
    for point, sides in ((first, [True, False]), (second, [False, True])):
        found = zone.contains(point.value + np.array([-1e-4, 1e-4]), [0.32, 0.32])
        assert found.tolist() == sides


def test_simulations_of_no_duration_are_refused():
    """Without a period of the load, nothing repeats within no time."""
    message = "settling = 0: must be .*; without a periodic load at least 1"
    for study in (vi.basins, vi.find):
        with pytest.raises(vi.ParameterError, match=message):
            study(bow(0.05), vi.Load.none(), states=2, settling=0)
