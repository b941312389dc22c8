"""Motions in which gaps rest beside stops and friction: derivatives, branches and zones, compared with simulations
by matrix exponentials and with closed forms."""

from dataclasses import replace

import numpy as np
import pytest
import vibroimpact as vi
from shared_structures import exponential, extended, first_order

STOP = vi.Stop([-1], 0.4, stiffness=20, damping=0.5)


def beside_stop(restitution, opening=0.3, stop=STOP):
    return vi.Structure([1], [0.1], [1], [vi.Gap([1], opening, restitution), stop])


def rubbing(restitution, slip=0.1, stick=None, opening=0.3):
    """A mass with friction along its gap."""
    friction = vi.Friction([1], slip, stick=stick)
    return vi.Structure([1], [0.1], [1], [vi.Gap([1], opening, restitution)], [friction])


def two_masses(restitution, friction=True):
    """A mass with a gap on one with a stop, and friction that is not along the gap."""
    parts = [vi.Gap([0, 1], 0.2, restitution), vi.Stop([-1, 0], 0.3, stiffness=15, damping=0.8)]
    return vi.Structure(
        [1, 0.5], [[0.15, -0.05], [-0.05, 0.05]], [[1.3, -0.3], [-0.3, 0.3]], parts,
        [vi.Friction([1, 0], 0.05)] if friction else [],
    )  # fmt: skip


def drive(structure, frequency):
    return vi.Load(frequency, cosine=np.eye(structure.coordinates)[0])


def settled(structure, frequency):
    load = drive(structure, frequency)
    return vi.exact(structure, load, vi.simulate(structure, load, cycles=300))


class Reference:
    """A structure with one gap, and any stops and friction, by exponentials of the matrix of each regime.

    Impacts follow each other until they depart with less than 1e-7; then the gap rests.
    """

    def __init__(self, structure, load, step=5e-3):
        self.structure, self.load, self.step = structure, load, step
        self.gap, *self.stops = structure.gaps
        self.inverse = np.linalg.inv(structure.mass)
        self.known = {}

    def regime(self, key):
        """The matrix, and the rows that stay positive until an event, with its kind and number."""
        if key in self.known:
            return self.known[key]
        rests, pressed, signs = key
        n, a = self.structure.coordinates, first_order(self.structure, self.load)
        one, watched = np.eye(len(a))[2 * n], []

        def row(of_q, of_rate=0.0, constant=0.0):
            return np.concatenate(
                [of_q + np.zeros(n), of_rate + np.zeros(n), one[2 * n :] * constant]
            )

        for i, stop in enumerate(self.stops):
            depth = row(stop.direction, constant=-stop.opening)
            watched.append((depth if i in pressed else -depth, "stop", i))
            if i in pressed:
                force = stop.stiffness * depth + row(0.0, stop.damping * stop.direction)
                a[n : 2 * n] -= np.outer(self.inverse @ stop.direction, force)
        g, levels = self.gap.direction, 0.0
        for i, part in enumerate(self.structure.friction):
            if rests and abs(np.linalg.det([g, part.direction]) if n == 2 else 0.0) < 1e-12:
                levels += part.stick * np.linalg.norm(part.direction) / np.linalg.norm(g)
                continue
            a[n : 2 * n] -= np.outer(self.inverse @ part.direction, signs[i] * part.slip * one)
            watched.append((row(0.0, signs[i] * part.direction), "turn", i))
        if rests:
            push = g @ a[n : 2 * n] / (g @ self.inverse @ g)
            a[n : 2 * n] -= np.outer(self.inverse @ g, push)
            watched.append((push + levels * one, "release", 0))
        else:
            watched.append((row(-g, constant=self.gap.opening), "impact", 0))
        self.known[key] = a, exponential(a * self.step), watched
        return self.known[key]

    def run(self, start, state, duration):
        """The state at the end, and the events (time, kind, number)."""
        n, y, t = self.structure.coordinates, extended([np.ravel(state)], self.load, start), 0.0
        rows = [part.direction for part in self.structure.friction]
        signs = [1 if row @ y[n : 2 * n] > 0 else -1 for row in rows]
        pressed = {i for i, stop in enumerate(self.stops) if stop.direction @ y[:n] > stop.opening}
        rests, events, g = False, [], self.gap.direction
        kick = self.inverse @ g / (g @ self.inverse @ g)
        while True:
            a, whole, watched = self.regime((rests, frozenset(pressed), tuple(signs)))
            step = min(self.step, duration - t)
            after = (whole if step == self.step else exponential(a * step)) @ y
            zeros = [
                (zero(a, y, row, step), kind, i) for row, kind, i in watched if row @ after < 0
            ]
            if not zeros:
                y, t = after, t + step
                if t >= duration:
                    return y[: 2 * n], events
                continue
            time, kind, i = min(zeros)
            y, t = exponential(a * time) @ y, t + time
            events.append((start + t, kind, i))
            if kind == "stop":
                pressed ^= {i}
            elif kind == "release":
                rests = False
                signs = [-s if s * (row @ g) > 0 else s for s, row in zip(signs, rows, strict=True)]
            elif kind == "turn":
                signs[i] = -signs[i]
                a = self.regime((rests, frozenset(pressed), tuple(signs)))[0]
                assert signs[i] * (rows[i] @ (a @ y)[n : 2 * n]) > 0, "friction sticks"
            else:
                speed = g @ y[n : 2 * n]
                rests = self.gap.restitution * speed < 1e-7
                y[n : 2 * n] -= (1 + (not rests) * self.gap.restitution) * speed * kick
                turned = [row @ y[n : 2 * n] for row in rows]
                signs = [
                    s if abs(v) < 1e-12 else int(np.sign(v))
                    for s, v in zip(signs, turned, strict=True)
                ]


def zero(a, y, row, step):
    """Where a row falls to 0 in a step; it may be 0 at its beginning."""
    low, high = 0.0, step
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if row @ exponential(a * middle) @ y > 0 else (low, middle)
    return high


SYSTEMS = {
    "stop, R = 0": (beside_stop(0.0), 0.8),
    "stop, R = 0.3": (beside_stop(0.3), 0.8),
    "rub, R = 0": (rubbing(0.0), 0.8),
    "rub with stick, R = 0": (rubbing(0.0, stick=0.15), 0.8),
    "rub, R = 0.3": (rubbing(0.3), 0.6),
    "two masses, R = 0": (two_masses(0.0), 0.7),
    "two masses, R = 0.4": (two_masses(0.4), 0.7),
}


def mid_flight(motion):
    """A time within the longest flight without rest, and the state there."""
    return motion._run()._between_events()


@pytest.mark.parametrize("name", SYSTEMS)
def test_multipliers_against_differences(name):
    """Rests make two multipliers zero; all are those of differences of an independent simulation."""
    motion = settled(*SYSTEMS[name])
    structure, load = motion.structure, motion.load
    assert motion.admissible
    assert len(motion.rests) == 1
    assert motion.law == 0
    assert np.sum(np.abs(motion.multipliers) < 1e-9) >= 2
    start, state = mid_flight(motion)
    reference = Reference(structure, load)
    end, _ = reference.run(start, state, motion.period)
    assert end == pytest.approx(np.ravel(state), abs=1e-9)
    h, columns = 1e-6, []
    for change in np.eye(2 * structure.coordinates) * h:
        ends = [
            reference.run(start, np.ravel(state) + sign * change, motion.period)[0]
            for sign in (1, -1)
        ]
        columns.append((ends[0] - ends[1]) / (2 * h))
    ours = np.sort(np.abs(motion.multipliers))
    assert np.sort(np.abs(np.linalg.eigvals(np.transpose(columns)))) == pytest.approx(
        ours, abs=1e-4 if ours[-1] < 1e-9 else 2e-7
    )


def changed(structure, load, name, step):
    """The system after a step of a parameter."""
    if name == "frequency":
        return structure, vi.Load(load.frequency + step, cosine=load.cosine)
    word, j = name.split("_")
    parts = [*structure.gaps, *structure.friction]
    part = parts[int(j)]
    if word == "slip":
        stick = part.stick * (1 + step / part.slip) if part.stick > part.slip else None
        new = replace(part, slip=part.slip + step, stick=stick)
    else:
        field = {"contact": "stiffness"}.get(word, word)
        new = replace(part, **{field: getattr(part, field) + step})
    parts[int(j)] = new
    count = len(structure.gaps)
    matrices = structure.mass, structure.damping, structure.stiffness
    return vi.Structure(*matrices, parts[:count], parts[count:]), load


PARAMETERS = {
    "stop, R = 0": ["frequency", "opening_0", "contact_1"],
    "stop, R = 0.3": ["opening_0", "restitution_0"],
    "rub, R = 0": ["frequency", "slip_1"],
    "rub with stick, R = 0": ["slip_1"],
    "rub, R = 0.3": ["slip_1"],
    "two masses, R = 0": ["opening_0", "slip_2"],
    "two masses, R = 0.4": ["contact_1", "restitution_0"],
}


@pytest.mark.parametrize("name", SYSTEMS)
def test_gradients_against_differences(name):
    """The end of a period, simulated by the reference, and the events of the motion, found by `exact`."""
    motion = settled(*SYSTEMS[name])
    start, state = mid_flight(motion)
    run = vi.simulate(
        motion.structure, motion.load, duration=motion.period, state=state, start=start
    )
    gradient = run.gradient(PARAMETERS[name])
    of_motion = motion.gradient(PARAMETERS[name])
    step = 1e-6
    for parameter in PARAMETERS[name]:
        systems = [
            changed(motion.structure, motion.load, parameter, sign * step) for sign in (1, -1)
        ]
        ends = [Reference(*system).run(start, state, motion.period)[0] for system in systems]
        slope = (ends[0] - ends[1]) / (2 * step)
        own = np.append(gradient["final_q", parameter], gradient["final_q_dot", parameter])
        assert own == pytest.approx(slope, abs=1e-5 * max(1, np.abs(slope).max()))
        up, down = (vi.exact(*system, motion) for system in systems)
        assert len(up.phases) == len(down.phases)
        for quantity in ("phases", "speeds", "impulses"):
            slope = (getattr(up, quantity) - getattr(down, quantity)) / (2 * step)
            tolerance = 1e-4 if name == "rub, R = 0.3" else 1e-6
            assert of_motion[quantity, parameter] == pytest.approx(
                slope, abs=tolerance * max(1, np.abs(slope).max())
            )


@pytest.mark.parametrize(
    ("frequency", "stick"), [(0.4, None), (0.5558018646663013, 0.15), (1.5963228661341593, None)]
)
def test_a_gap_with_friction_rests_after_its_impact(frequency, stick):
    """With R = 0 friction must not hold the mass beside its wall, at a distance of rounding."""
    structure = rubbing(0.0, stick=stick)
    run = vi.simulate(structure, drive(structure, frequency), cycles=30, discard=100)
    kinds, gaps = run.events["kind"], run.events["gap"]
    assert (kinds[1:][kinds[:-1] == "impact"] == "stick").all()
    assert not (kinds == "halt").any()
    assert np.sum(gaps == 0) == 3 * np.sum(kinds == "release")


BRANCHES = [
    ("stop, R = 0", "opening_0", (0.0, 1.5)),
    ("stop, R = 0.3", "frequency", (0.4, 2.0)),
    ("rub, R = 0", "frequency", (0.4, 2.0)),
    ("rub with stick, R = 0", "stick", (0.1, 0.6)),
    ("rub, R = 0.3", "frequency", (0.4, 2.0)),
    ("two masses, R = 0", "frequency", (0.6, 0.8)),
    ("two masses, R = 0.4", "contact", (10.0, 20.0)),
]


@pytest.mark.parametrize(("name", "parameter", "bounds"), BRANCHES)
def test_branches(name, parameter, bounds):
    """The points are motions on which simulations settle, and motions simulated from these points."""
    motion = settled(*SYSTEMS[name])
    branch = vi.branch(motion, parameter, bounds=bounds)
    assert list(branch.resting) == [0]
    # where a rest vanishes, its beginning is ever more sensitive to rounding
    low, high = branch.values.min(), branch.values.max()
    inner = np.abs(branch.values - (low + high) / 2) < 0.48 * (high - low)
    good = np.flatnonzero((branch.admissible == 1) & (branch.stable == 1) & inner)
    assert branch.residual[good].max() < 1e-12
    for i in good[:: max(1, len(good) // 4)].tolist():
        found = branch[i]
        assert found.admissible
        far = settled(found.structure, found.load.frequency)
        for other in (found, far):
            assert other.rests[0][0] == 0
            turn = 2 * np.pi * np.round((other.rests["end"] - branch.rests[:, 1, i]) / (2 * np.pi))
            for column, end in enumerate(("begin", "end")):
                assert branch.rests[:, column, i] + turn == pytest.approx(
                    other.rests[end], abs=1e-8
                )
            assert np.sort(np.abs(branch.multipliers[:, i])) == pytest.approx(
                np.sort(np.abs(other.multipliers)), abs=1e-6
            )


@pytest.mark.parametrize(
    "name", ["stop, R = 0", "rub, R = 0", "rub with stick, R = 0", "rub, R = 0.3"]
)
def test_releases_of_one_mass(name):
    """A mass at rest on its wall is released where the load no longer exceeds spring and stick level."""
    motion = settled(*SYSTEMS[name])
    branch = vi.branch(motion, "opening_0", bounds=(0.05, 1.0))
    stick = motion.structure.friction[0].stick if motion.structure.friction else 0.0
    inside = branch.admissible == 1
    assert inside.sum() > 10
    released = np.cos(branch.rests[0, 1]) - (branch.values - stick)
    assert np.abs(released[inside]).max() < 1e-12


def has_rest(structure, frequency):
    run = vi.simulate(structure, drive(structure, frequency), cycles=1, discard=200)
    return bool((run.events["kind"] == "stick").any())


@pytest.mark.parametrize(("make", "frequency", "tolerance"), [
    (lambda opening: beside_stop(0.0, opening), 0.8, 1e-7),
    (lambda opening: beside_stop(0.3, opening), 0.8, 1e-7),
    (lambda opening: rubbing(0.3, stick=0.15, opening=opening), 0.6, 2e-6),
])  # fmt: skip
def test_rests_vanish_where_simulations_have_none(make, frequency, tolerance):
    branch = vi.branch(settled(make(0.3), frequency), "opening_0", bounds=(0.3, 1.5))
    (end,) = (point for point in branch.special_points if point.type == "rest_vanishes")
    assert end.detail == "rest of gap 0"
    assert branch.ends[1] == "a rest vanishes"
    assert has_rest(make(end.value - tolerance), frequency)
    assert not has_rest(make(end.value + tolerance), frequency)


def sequence(structure, frequency):
    """The events of a period on which a simulation settles, without the order in which they are told."""
    run = vi.simulate(structure, drive(structure, frequency), cycles=1, discard=150)
    return sorted(zip(run.events["kind"].tolist(), run.events["gap"].tolist(), strict=True))


PLANES = [
    (beside_stop, 0.9, ("frequency", 0.6, 1.6), ("opening_0", 0.05, 0.9),
     {"grazing", "rest_vanishes", "rest_splits", "window"}),
    (rubbing, 0.8, ("frequency", 0.4, 1.7), ("slip_1", 0.05, 0.6),
     {"stick_begins", "rest_vanishes", "rest_splits", "window"}),
]  # fmt: skip


@pytest.mark.parametrize(("make", "frequency", "x", "y", "kinds"), PLANES)
def test_zones(make, frequency, x, y, kinds):
    """Inside a zone simulations settle on its sequence of events, outside they do not; also beside its edge."""
    motion = settled(make(0.0), frequency)
    wanted = sequence(motion.structure, frequency)
    zone = vi.zone(motion, x, y, lines=9)
    assert zone.closed
    assert {piece.type for piece in zone.boundary} == kinds
    g = np.random.default_rng(0)
    places = [g.uniform(*x[1:], 60), g.uniform(*y[1:], 60)]
    for piece in zone.boundary:
        if piece.type == "window":
            continue
        # points 1e-3 of the window to both sides of the boundary
        size = np.array([x[2] - x[1], y[2] - y[1]])
        at = np.array([piece.x, piece.y]).T / size
        i = np.linspace(1, len(at) - 2, 5).astype(int)
        along = at[i + 1] - at[i - 1]
        aside = np.array([along[:, 1], -along[:, 0]]).T / np.linalg.norm(along, axis=1)[:, None]
        for sign in (1, -1):
            both = (at[i] + sign * 1e-3 * aside) * size
            places = [np.append(old, new) for old, new in zip(places, both.T, strict=True)]
    a, b = places
    within = (x[1] < a) & (a < x[2]) & (y[1] < b) & (b < y[2])
    places = a[within], b[within]
    inside = zone.contains(*places)
    assert 20 < inside.sum() < len(inside) - 15
    for a, b, within in zip(*places, inside.tolist(), strict=True):
        structure = make(0.0, **{y[0].split("_")[0]: b})
        assert (sequence(structure, a) == wanted) == within, (a, b)


def test_two_gaps_with_friction_in_the_slot():
    """Both gaps of a damper rest in turn, and friction acts along both."""
    slot = [vi.Gap([-1, 1], 1.2, 0.0), vi.Gap([1, -1], 1.2, 0.0)]
    s = vi.Structure([1, 0.2], [0.05, 0], [1, 0], slot, [vi.Friction([-1, 1], 0.01)])
    load = vi.Load(0.85, sine=[1, 0])
    motion = vi.exact(s, load, vi.simulate(s, load, cycles=300))
    assert sorted(gap for gap, *_ in motion.rests) == [0, 1]
    branch = vi.branch(motion, "frequency", bounds=(0.8, 0.9))
    assert sorted(branch.resting) == [0, 1]
    good = np.flatnonzero(branch.admissible == 1)
    assert len(good) > 5
    for i in good[::5].tolist():
        found = branch[i]
        begins = np.sort(np.mod(found.rests["begin"], 2 * np.pi))
        assert np.sort(np.mod(branch.rests[:, 0, i], 2 * np.pi)) == pytest.approx(begins, abs=1e-8)


def test_friction_that_slips_as_a_rest_begins():
    """A rest after an impact with R = 0 changes the force on friction that sticks, and it slips at once: [P] and
    the linear problem of the instants of all events agree with differences of the simulation."""
    stiffness = np.array([[2.0, -1.0], [-1.0, 2.0]])
    parts = [vi.Gap([1, 0], 0.2, 0.0)], [vi.Friction([0, 1], 0.44, speed=0.2)]
    s = vi.Structure([1, 1], 0.3 * stiffness, stiffness, *parts)
    load = vi.Load(0.3, cosine=[1, 0.3], sine=[0, 0.5])
    motion = vi.exact(s, load, vi.simulate(s, load, cycles=60))
    events = motion._from_flight().events
    assert events["kind"].tolist() == ["halt", "impact", "stick", "slip_down", "release"]
    assert events["time"][1] == events["time"][2] == events["time"][3]
    start, state = motion._run()._between_events()
    middle, step = np.concatenate(state), 1e-5

    def a_period_later(y):
        run = vi.simulate(s, load, duration=motion.period, start=start, state=(y[:2], y[2:]))
        return np.concatenate(run.final_state)

    both = [
        [a_period_later(middle + sign * change) for change in step * np.eye(4)] for sign in (1, -1)
    ]
    P = (np.array(both[0]) - both[1]).T / (2 * step)
    phases = events["time"] * load.frequency
    given = vi.periodic(s, load, phases, events["gap"], kinds=events["kind"].tolist())
    assert given.residual < 1e-13
    assert given.admissible
    for found in (motion, given):
        assert found.multipliers.sum() == pytest.approx(np.trace(P), rel=1e-8)
        assert (found.multipliers**2).sum() == pytest.approx(np.trace(P @ P), rel=1e-8)


def self_excited(opening):
    """A mass on a belt, and one coupled with it that comes to rest on a wall in each period."""
    parts = [vi.Gap([0, 1], opening, 0.0)], [vi.Friction([1, 0], 0.6, stick=1.0, speed=0.2)]
    s = vi.Structure([1, 0.3], [0.02, 0.05], [[2.0, -1.0], [-1.0, 1.2]], *parts)
    return vi.exact(s, vi.Load.none(), vi.simulate(s, duration=300, state=([0, -1], [0, 0])))


def test_self_excited_motions():
    """The period and the length of the rest along a branch, and their derivatives."""
    motion = self_excited(0.2)
    assert len(motion.rests) == 1
    gradient = motion.gradient(["opening_0"])
    step = 1e-5
    periods = [self_excited(0.2 + sign * step).period for sign in (1, -1)]
    slope = (periods[0] - periods[1]) / (2 * step)
    assert gradient["period", "opening_0"] == pytest.approx(slope, abs=1e-7)
    branch = vi.branch(motion, "opening_0", bounds=(0.1, 0.3))
    assert (branch.admissible == 1).all()
    for i in range(0, len(branch), len(branch) // 4):
        for other in (branch[i], self_excited(branch.values[i])):
            assert branch.period[i] == pytest.approx(other.period, abs=1e-9)
            length = other.rests["end"] - other.rests["begin"]
            assert np.diff(branch.rests[:, :, i])[:, 0] == pytest.approx(length, abs=1e-9)


def test_what_is_refused():
    """Zones of motions with impacts that accumulate on a gap along which friction acts."""
    motion = settled(rubbing(0.3), 0.6)
    with pytest.raises(
        vi.SingularError, match="impacts accumulate on a gap along which friction acts"
    ):
        vi.zone(motion, ("frequency", 0.5, 0.7), ("slip", 0.05, 0.2))
