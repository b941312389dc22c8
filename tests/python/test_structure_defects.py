"""Bodies whose damping makes modes nearly coincide: no digits are lost, or the body is refused."""

import re

import mpmath
import numpy as np
import pytest
import vibroimpact as vi
from scipy.linalg import expm


def flown(mass, damping, stiffness, state, t):
    """Coordinates and velocities after a time, of a structure whose gap never closes."""
    gap = vi.Gap(np.eye(len(mass))[0], 1e9)
    run = vi.simulate(vi.Structure(mass, damping, stiffness, [gap]), duration=t, state=state)
    return np.ravel(run.sample(np.array([t])))


def exponential(mass, damping, stiffness, state, t):
    """The same by the exponential of the first-order matrix, with 40 digits."""
    n = len(mass)
    with mpmath.workdps(40):
        inverse = mpmath.matrix(mass) ** -1
        a = mpmath.zeros(2 * n)
        a[:n, n:] = mpmath.eye(n)
        a[n:, :n] = -inverse * mpmath.matrix(stiffness)
        a[n:, n:] = -inverse * mpmath.matrix(damping)
        return np.array(mpmath.expm(a * t) * mpmath.matrix(np.ravel(state)), dtype=float).ravel()


def real_eigenvalues(damping, stiffness):
    """The number of real eigenvalues of a body of unit masses."""
    n = len(damping)
    first_order = np.block([[np.zeros((n, n)), np.eye(n)], [-stiffness, -damping]])
    return np.count_nonzero(np.linalg.eigvals(first_order).imag == 0)


def critical(damping, stiffness):
    """The factor of the damping at which two complex eigenvalues become a double real one."""
    grid = np.geomspace(1e-3, 1e3, 300)
    counts = [real_eigenvalues(f * damping, stiffness) for f in grid]
    i = next(i for i in range(len(grid)) if counts[i] != counts[0])
    low, high = grid[i - 1], grid[i]
    for _ in range(70):
        middle = (low + high) / 2
        if real_eigenvalues(middle * damping, stiffness) == counts[0]:
            low = middle
        else:
            high = middle
    return low


@pytest.mark.parametrize("seed", range(12))
def test_through_critical_damping(seed):
    """Random bodies keep their digits while damping passes the value at which two eigenvectors coincide."""
    rng = np.random.default_rng(seed)
    n = 2 + seed % 3
    root = rng.normal(size=(n, n))
    stiffness = (root @ root.T + 0.05 * np.eye(n)) * 10 ** rng.uniform(-2, 2)
    root = rng.normal(size=(n, n))
    damping = root @ root.T
    damping *= critical(damping, stiffness)
    speed = np.sqrt(np.linalg.eigvalsh(stiffness).max())
    state, t = rng.normal(size=(2, n)) * [[1], [speed]], 7 / speed
    for distance in (0.0, 1e-15, 1e-12, 1e-10, 1e-8, 1e-7, 1e-6, 1e-4, 1e-2):
        for sign in (-1, 1):
            body = np.eye(n), (1 + sign * distance) * damping, stiffness
            exact = exponential(*body, state, t).reshape(2, n)
            apart = np.abs(flown(*body, state, t).reshape(2, n) - exact).max(1)
            assert (apart <= 1e-12 * np.maximum(np.abs(state), np.abs(exact)).max(1)).all()


@pytest.mark.parametrize("seed", range(12))
def test_dashpots_between_free_bodies(seed):
    """Several modes of frequency 0 keep their digits, whether or not dashpots couple them."""
    rng = np.random.default_rng(seed)
    n = 2 + seed % 3
    for stiff in range(n):
        for damped in range(1, n + 1):
            root = rng.normal(size=(n, n))
            mass = root @ root.T + np.eye(n)
            springs, dashpots = rng.normal(size=(n, stiff)), rng.normal(size=(n, damped))
            damping = 10 ** rng.uniform(-3, 0) * dashpots @ dashpots.T
            body = mass, damping, springs @ springs.T
            state = rng.normal(size=(2, n))
            exact = exponential(*body, state, 7.0)
            assert np.abs(flown(*body, state, 7.0) - exact).max() <= 1e-12 * np.abs(exact).max()


def coinciding(ratio, sigma):
    """A body of two unit masses with a double pair of complex eigenvalues, of frequency 1."""
    stiffness = np.diag([ratio, 1 / ratio])
    second = 4 * sigma / (1 + ratio)
    between = np.sqrt((ratio - 1) ** 2 * (1 / ratio - (2 * sigma / (1 + ratio)) ** 2))
    return np.array([[ratio * second, between], [between, second]]), stiffness


@pytest.mark.parametrize(("ratio", "sigma"), [(1.5, 0.3), (1.2, 0.2), (2.0, 0.5)])
def test_pairs_that_coincide(ratio, sigma):
    """Two coinciding pairs of complex eigenvectors are refused; a small distance apart they keep all digits."""
    damping, stiffness = coinciding(ratio, sigma)
    state, t = np.array([[1.0, -0.5], [0.3, 0.8]]), 7.0
    messages = {}
    for distance in (0.0, 1e-14, 1e-12, 1e-10, 1e-9, 3e-9, 1e-8, 3e-8, 1e-7, 1e-6, 1e-4, 1e-2):
        body = np.eye(2), damping + np.diag([distance, 0.0]), stiffness
        try:
            apart = flown(*body, state, t) - exponential(*body, state, t)
        except vi.SingularError as error:
            messages[distance] = str(error)
        else:
            assert np.abs(apart).max() <= 1e-12
    assert 0.0 in messages
    assert max(messages) < 1e-6
    assert all("change a damping coefficient" in message for message in messages.values())
    value = complex(-sigma, np.sqrt(1 - sigma**2))
    for message in messages.values():
        named = [complex(number) for number in re.findall(r"-[0-9.]+[+-][0-9.]+j", message)]
        assert named == pytest.approx([value, value], abs=1e-3)


def copies(seed):
    """Two or three copies of a body with coupled damping, in rotated coordinates."""
    rng = np.random.default_rng(seed)
    n, count = 2 + seed % 2, 2 + seed // 2 % 2
    stiff, damped = rng.normal(size=(2, n, n))
    turn = np.linalg.qr(rng.normal(size=(n * count, n * count)))[0]
    stiffness = turn @ np.kron(np.eye(count), stiff @ stiff.T + 0.2 * np.eye(n)) @ turn.T
    damping = turn @ np.kron(np.eye(count), 0.2 * damped @ damped.T) @ turn.T
    return np.eye(n * count), (damping + damping.T) / 2, (stiffness + stiffness.T) / 2


def ring(cells):
    """Equal masses in a ring of springs, each with a small mass on a spring and a dashpot."""
    between = np.array([[1.0, -1.0], [-1.0, 1.0]])
    around = np.roll(np.eye(cells), 1, axis=0)
    ground = (1.0 + 0.8) * np.eye(cells) - 0.4 * (around + around.T)
    one = np.eye(cells)
    stiffness = np.kron(ground, np.diag([1.0, 0.0])) + np.kron(one, 0.3 * between)
    return np.kron(one, np.diag([1.0, 0.2])), np.kron(one, 0.05 * between), stiffness


@pytest.mark.parametrize("body", [*map(copies, range(24)), *map(ring, (3, 4, 5, 6, 8))])
def test_repeated_pairs_of_symmetric_bodies(body):
    """Repeated complex eigenvalues with independent eigenvectors lose no digits."""
    mass, damping, stiffness = body
    n = len(mass)
    first_order = np.block(
        [
            [np.zeros((n, n)), np.eye(n)],
            [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping)],
        ]
    )
    values = np.linalg.eigvals(first_order)
    nearest = np.abs(values[:, None] - values) + np.diag(np.full(2 * n, np.inf))
    assert np.count_nonzero((nearest.min(0) < 1e-9) & (values.imag > 0)) >= 2
    state = np.random.default_rng(n).normal(size=(2, n))
    exact = expm(7.0 * first_order) @ state.ravel()
    assert np.abs(flown(*body, state, 7.0) - exact).max() <= 1e-12
