"""Several gaps at rest simultaneously, compared with event-driven integration of the equations of motion."""

import numpy as np
import pytest
import vibroimpact as vi

solve_ivp = pytest.importorskip("scipy.integrate").solve_ivp

#: Rebound speed below which the integration lets a gap rest; the error is of its third power.
SLOW = 3e-4


def loaded_hosts(seed):
    """Three hosts with springs and dashpots between all, each with a free mass that lies on it; and their load."""
    rng = np.random.default_rng(seed)
    n = 3

    def semidefinite(size):
        root = rng.normal(size=(n, n))
        matrix = np.zeros((2 * n, 2 * n))
        matrix[:n, :n] = size * root @ root.T
        return matrix

    stiffness = semidefinite(1.0) + np.diag([1.0] * n + [0.0] * n)
    # springs between the free masses: the flight of each depends on the others
    stiffness[n:, n:] += 0.1 * np.array([[1, -1, 0], [-1, 2, -1], [0, -1, 1]])
    damping = semidefinite(0.05) + np.diag([0.1] * n + [0.02] * n)
    directions = np.hstack([np.eye(n), -np.eye(n)])
    gaps = [vi.Gap(direction, 0.0, float(rng.uniform(0.1, 0.4))) for direction in directions]
    s = vi.Structure(rng.uniform(0.5, 2, 2 * n), damping, stiffness, gaps)
    weights = np.append(np.zeros(n), -np.diag(s.mass)[n:])
    sine = np.append(rng.uniform(0.8, 1.6, n), np.zeros(n))
    return s, vi.Load(float(rng.uniform(0.9, 1.3)), sine=sine, constant=weights)


class Integration:
    """The motion as a list of solutions, with the sticks and releases, and the sets of gaps at rest."""

    def __init__(self, s, load, q, end):
        self.s, self.load, self.n = s, load, s.coordinates
        self.directions = np.array([gap.direction for gap in s.gaps])
        self.inverse = np.linalg.inv(s.mass)
        self.mobility = self.directions @ self.inverse @ self.directions.T
        self.active, self.pieces, self.changes, self.most = [], [], [], 0
        self.run(np.append(q, np.zeros(self.n)), end)

    def accelerations(self, t, y):
        """q'' and the forces of the gaps at rest, which keep their speeds constant."""
        q, v = np.split(y, 2)
        angle = self.load.frequency * t
        force = self.load.sine[0] * np.sin(angle) + self.load.constant
        free = self.inverse @ (force - self.s.damping @ v - self.s.stiffness @ q)
        if not self.active:
            return free, np.zeros(0)
        rows = self.directions[self.active]
        pushes = np.linalg.solve(self.mobility[np.ix_(self.active, self.active)], rows @ free)
        return free - self.inverse @ rows.T @ pushes, pushes

    def piece(self, t, y, end, longest):
        """Integrate to the first gap that closes or contact force that ends; return their number and kind."""
        watched = []
        for j in range(len(self.directions)):
            if j in self.active:
                place = self.active.index(j)
                watched.append((j, "release", lambda t, y, p=place: self.accelerations(t, y)[1][p]))
            else:
                row = self.directions[j]
                watched.append((j, "impact", lambda t, y, row=row: -(row @ y[: self.n])))
        for _, _, event in watched:
            event.terminal, event.direction = True, -1
        found = solve_ivp(
            lambda t, y: np.append(y[self.n :], self.accelerations(t, y)[0]), (t, end), y,
            method="DOP853", rtol=1e-11, atol=1e-13, max_step=longest, dense_output=True,
            events=[event for _, _, event in watched],
        )  # fmt: skip
        self.pieces.append((found.t[0], found.t[-1], found.sol))
        for (j, kind, _), times in zip(watched, found.t_events, strict=True):
            if len(times):
                return found.t[-1], found.y[:, -1], j, kind
        return found.t[-1], found.y[:, -1], None, ""

    def run(self, y, end):
        t, hop = 0.0, np.inf
        while t < end:
            # a short hop after an impact is not stepped over
            until = min(end, t + 1.5 * hop)
            t, y, j, kind = self.piece(t, y, until, min(0.05, hop / 8))
            hop = np.inf
            if kind == "release":
                self.active.remove(j)
                self.changes.append((t, "release", j))
            elif kind == "impact":
                hop = self.impact(t, y, j)

    def impact(self, t, y, j):
        """The impact in `y`, or the start of a rest; the duration of the bounce that follows."""
        row, v = self.directions[j], y[self.n :]
        restitution = self.s.gaps[j].restitution
        speed = row @ v
        v -= (1 + restitution) * speed / self.mobility[j, j] * (self.inverse @ row)
        closing = row @ self.accelerations(t, y)[0]
        rebound = restitution * speed
        if rebound < SLOW and closing > 0:
            v -= (row @ v) / self.mobility[j, j] * (self.inverse @ row)
            self.active = sorted([*self.active, j])
            self.changes.append((t + 2 * rebound / (closing * (1 - restitution)), "stick", j))
            self.most = max(self.most, len(self.active))
            return np.inf
        return 2 * rebound / closing if closing > 0 else np.inf

    def sample(self, times):
        """Coordinates at given times."""
        begins = np.array([begin for begin, _, _ in self.pieces])
        places = np.searchsorted(begins, times, side="right") - 1
        return np.array([
            self.pieces[place][2](t)[: self.n] for t, place in zip(times, places, strict=True)
        ]).T  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
def test_three_gaps_at_rest(seed):
    s, load = loaded_hosts(seed)
    end, q = 30.0, np.append(np.zeros(3), [0.3, 0.2, 0.1])
    run = vi.simulate(s, load, duration=end, state=(q, np.zeros(6)))
    reference = Integration(s, load, q, end)
    changes = [
        (e["time"], str(e["kind"]), int(e["gap"])) for e in run.events if e["kind"] != "impact"
    ]
    assert reference.most == 3
    assert len(changes) > 6
    assert sorted(kind + str(gap) for _, kind, gap in changes) == sorted(
        kind + str(gap) for _, kind, gap in reference.changes
    )
    for kind in ("stick", "release"):
        for gap in range(3):
            ours = [t for t, *what in changes if what == [kind, gap]]
            theirs = [t for t, *what in reference.changes if what == [kind, gap]]
            np.testing.assert_allclose(ours, theirs, atol=1e-5)
    t = np.linspace(0, end, 500)[:-1]
    np.testing.assert_allclose(run.sample(t)[0], reference.sample(t), atol=1e-6)


def test_rest_across_the_ends_of_a_spring():
    """Two bodies that rest on each other move as one, for any spring and dashpot at their ends."""
    masses = np.array([3.194308434581922, 1.8461862772452002, 2.688583956279266])
    springs = 0.1 * np.array([[0, 0, 0], [0, 1, -1], [0, -1, 1]])
    for unit in (1.0, 3.0, 1e-9, 1e9):
        gaps = [vi.Gap([0, -1, 1], 1e-3, 0.0)]
        s = vi.Structure(unit * masses, 0.5 * unit * springs, unit * springs, gaps)
        run = vi.simulate(s, vi.Load(constant=[0, 0, unit]), duration=4)
        assert run.events["kind"].tolist() == ["impact", "stick"]
        q, rate = run.final_state
        assert q[2] - q[1] == pytest.approx(1e-3, rel=1e-9)
        assert rate[1:] == pytest.approx(4 / masses[1:].sum(), rel=1e-12)


@pytest.mark.parametrize("seed", range(2))
def test_no_rest_of_a_free_chain_is_refused(seed):
    """Chains of bodies with random springs and dashpots, with rest across some of them.

    They are not connected to the ground: their momentum is that of the load.
    """
    rng = np.random.default_rng(seed + 1)
    coupled = 0
    for _ in range(500):
        n = int(rng.integers(2, 9))
        masses = 10 ** rng.uniform(-1, 1, n)
        damping, stiffness = np.zeros((n, n)), np.zeros((n, n))
        for i in range(n - 1):
            link = np.eye(n)[i] - np.eye(n)[i + 1]
            for matrix in (damping, stiffness):
                if rng.random() < 0.6:
                    matrix += 10 ** rng.uniform(-2, 1) * np.outer(link, link)
        at = rng.choice(n - 1, min(n - 1, 1 + int(rng.random() < 0.4)), replace=False)
        gaps = [vi.Gap(np.eye(n)[j + 1] - np.eye(n)[j], 1e-3, 0.0) for j in at]
        load = vi.Load(constant=sum(np.eye(n)[j + 1] for j in at))
        try:
            run = vi.simulate(vi.Structure(masses, damping, stiffness, gaps), load, duration=3)
        except vi.SingularError as error:
            if "two coupled gaps" not in str(error):
                raise
            coupled += 1
            continue
        _, rate = run.final_state
        assert masses @ rate == pytest.approx(3.0 * len(at), rel=1e-9)
    assert coupled < 150


def linked(n, rng, share):
    """Random springs or dashpots between n bodies, from 0.01 to 100, without a connection to the ground."""
    matrix = np.zeros((n, n))
    for i in range(n):
        for j in range(i):
            link = np.eye(n)[i] - np.eye(n)[j]
            matrix += (rng.random() < share) * 10 ** rng.uniform(-2, 2) * np.outer(link, link)
    return matrix


@pytest.mark.parametrize("seed", range(4))
def test_rest_does_not_depend_on_the_units_of_mass_and_time(seed):
    """Free bodies with random springs and dashpots, some of them pressed together: no unit is refused."""
    rng = np.random.default_rng(seed + 20)
    for _ in range(150):
        n = int(rng.integers(4, 9))
        mass = 10 ** rng.uniform(-2, 2, n)
        damping, stiffness = linked(n, rng, 0.5), linked(n, rng, rng.choice([0.2, 0.5, 1.0]))
        at = rng.choice(n, (3, 2))
        gaps = [np.eye(n)[i] - np.eye(n)[j] if i != j else np.eye(n)[i] for i, j in at]
        if np.linalg.matrix_rank(gaps) < len(gaps):
            continue
        # forces that push on the gaps, and a force that moves the bodies
        push = rng.uniform(0.5, 2, 3) @ gaps
        wave = 0.1 * rng.normal(size=n)
        found = []
        for heavy, slow in [(1, 1), (3, 1), (1e-3, 1), (1 / 3, 1), (1, 1e3), (1, 1e-3), (1, 3)]:
            force = heavy / slow**2
            structure = vi.Structure(
                heavy * mass,
                heavy / slow * damping,
                force * stiffness,
                [vi.Gap(gap, 0.0, 0.0) for gap in gaps],
            )
            load = vi.Load(1.3 / slow, cosine=[force * wave], constant=force * push)
            run = vi.simulate(
                structure, load, duration=0.03 * slow, state=(np.zeros(n), np.zeros(n))
            )
            assert not run.events.size
            found.append(run.final_state[0])
        # without gaps the displacement is half the acceleration times the time squared, and further terms
        assert np.abs(found[0]).max() > 1e-9
        assert np.abs(found - found[0]).max() < 1e-9 * np.abs(found[0]).max()


def test_rest_leaves_soft_springs_of_other_bodies():
    """A rest between stiff bodies does not free another body whose spring is 1e-17 as stiff."""
    gaps = [vi.Gap([1, -1, 0], 0.0, 0.0)]
    s = vi.Structure([1, 1, 1], [0, 0, 0], [1e17, 1e17, 1], gaps)
    load = vi.Load(constant=[1.0, -1.0, 0.0])
    run = vi.simulate(s, load, duration=2, state=([0, 0, 1], [0, 0, 0]))
    assert run.permanent == (0,)
    assert run.final_state[0][2] == pytest.approx(np.cos(2.0), rel=1e-12)


@pytest.mark.parametrize("light", [1.0, 1e-8, 1e-16])
def test_a_light_body_between_heavy_ones_that_rest_on_it(light):
    """The forces on the light body follow from the heavy bodies; the products of directions would lose them."""
    gaps = [vi.Gap([1, -1, 0], 0.0, 0.0), vi.Gap([0, 1, -1], 0.0, 0.0)]
    s = vi.Structure([1, light, 1], [0, 0, 0], [0, 0, 0], gaps)
    # the last body is pulled more and more, until it leaves where both accelerations are equal
    load = vi.Record(1.0, np.outer(np.arange(4.0), [0, 0, 1]), constant=[1.0, 0, 0])
    run = vi.simulate(s, load, duration=3)
    released = run.events[run.events["kind"] == "release"]
    first = released["time"][0]
    assert first == pytest.approx(1 / (1 + light), rel=1e-7)
    assert run.sample([first])[1][:, 0] == pytest.approx(
        (first + first**2 / 2) / (2 + light), rel=1e-7
    )


def test_a_rest_that_never_ends_is_named():
    """A mass that lies on a table has no events; the trajectory states that it rests."""
    table = vi.Structure([1], [0], [0], [vi.Gap([1], 0.0, 0.5)])
    weight = vi.Load(constant=[1.0])
    run = vi.simulate(table, weight, duration=4)
    assert run.permanent == (0,)
    assert repr(run) == "<Trajectory t = 0 to 4: 0 impacts, gap 0 rests all the time>"
    dropped = vi.simulate(table, weight, duration=9, state=([-1.0], [0.0]))
    assert dropped.permanent == ()
    assert vi.simulate(table, weight, duration=1, discard=8, state=([-1.0], [0.0])).permanent == (
        0,
    )
    pulled = vi.Load(0.1, sine=[-2.0], constant=[1.0])
    assert vi.simulate(table, pulled, cycles=1).permanent == ()
    shaken = vi.Load(0.1, sine=[-0.5], constant=[1.0])
    resting = vi.simulate(table, shaken, cycles=2)
    with pytest.raises(vi.SingularError, match="settles on a permanent rest"):
        vi.exact(table, shaken, resting)
    found = vi.basins(table, shaken, states=4, settling=50)
    assert [item.name for item in found.attractors] == ["permanent rest"]
    osc = vi.Oscillator(xi=0.1, mu=0.1, restitution=0.0)
    rests = vi.simulate(osc, 0.9, 1.0, 3, state={"z": 0.5}, load=0.0)
    assert "m rests on R all the time" in repr(rests)
