"""Several gaps at rest simultaneously, against event-driven integration of the equations of motion."""

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
        """Integrates to the first gap that closes or force that ends; their number and kind."""
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
        """The impact in `y`, or the beginning of a rest; the length of the hop that follows."""
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
        """Coordinates at some times."""
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
