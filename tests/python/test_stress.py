"""Extreme parameters compared with 50-digit arithmetic: each result is accurate, refused, or unknown.

The table of docs/limits.md is the promised accuracy; each test reads its row.
"""

import math
import re
from pathlib import Path

import mpmath as mp
import numpy as np
import pytest
import vibroimpact as vi
from reference_motion import DIGITS, ReferenceMotion
from reference_periodic import GivenPhases
from shared_motions import after_impact

PAGE = Path(__file__).resolve().parents[2] / "docs/limits.md"
#: The number of random systems in each corner of the parameters.
DRAWS = 14


def powers(low, high):
    """Draw a number whose logarithm is uniform."""
    return lambda rng: 10 ** rng.uniform(low, high)


def ends(*values):
    """Draw one of these numbers."""
    return lambda rng: float(rng.choice(values))


#: Name in the table: replacements for xi, mu, r, R; impacts; load cycles; a short distance between phases.
CORNERS = {
    "ξ → 0": {"xi": ends(0.0, 1e-300, 1e-16, 1e-9)},
    "ξ → 1": {"xi": lambda rng: 1 - 10 ** rng.uniform(-15, -2)},
    "r 1e-6 to 0.1": {"r": powers(-6, -1)},
    "r 10 to 1e6": {"r": powers(1, 6)},
    "r within 1e-12 to 1e-3 of 1, ξ 0 to 1e-4": {
        "r": lambda rng: 1 + float(rng.choice([-1, 1])) * 10 ** rng.uniform(-12, -3),
        "xi": lambda rng: float(rng.choice([0, 1])) * 10 ** rng.uniform(-12, -4),
    },
    "μ 0 to 1e-2": {"mu": lambda rng: float(rng.choice([0, 1])) * 10 ** rng.uniform(-12, -2)},
    "μ 10 to 1e6": {"mu": powers(1, 6)},
    "R 0 and 1": {"walls": lambda rng: (ends(0, 1)(rng), ends(0, 1)(rng))},
    "phases 1e-12 to 0.01 apart": {"near": powers(-12, -2)},
    "N = 16 to 64": {"impacts": [16, 33, 64], "cycles": 8},
    "k = 32": {"impacts": [2, 3, 8], "cycles": 32},
}


def systems(name, count, pair=False):
    """Random systems of a corner with phases; only pairs of impacts if requested."""
    corner, rng = CORNERS[name], np.random.default_rng(list(CORNERS).index(name))

    def draw(key, usual):
        return corner.get(key, usual)(rng)

    for i in range(count):
        walls = draw("walls", lambda rng: tuple(rng.uniform(0.3, 0.9, 2)))
        osc = vi.Oscillator(
            xi=float(draw("xi", powers(-3, -0.3))),
            mu=float(draw("mu", powers(-2, 0))),
            restitution=walls,
        )
        r, cycles = float(draw("r", lambda rng: rng.uniform(0.5, 1.5))), corner.get("cycles", 1)
        among = corner.get("impacts", [2, 2, 3, 4])
        # corners with many impacts have few systems: one for each number of impacts
        n = 2 if pair else int(among[i % len(among)] if "impacts" in corner else rng.choice(among))
        sides = ["R", "L", *rng.choice(["R", "L"], n - 2)]
        phases = np.append(0.0, np.sort(rng.uniform(0.05, 6.2 * cycles, n - 1)))
        if "near" in corner:
            phases[1] = phases[0] + corner["near"](rng)
        yield osc, r, phases, vi.Pattern("".join(sides), cycles)


def promised(name):
    """The row of a corner: largest errors of positions, leading multiplier, exact motions (–: not tested)."""
    row = re.search(rf"^\| {re.escape(name)} \|(.*)\|$", PAGE.read_text(encoding="utf-8"), re.M)
    return [float(cell) if cell.strip() != "–" else None for cell in row[1].split("|")]


def far(value, known):
    """The relative difference."""
    return float(abs(value / known - 1))


@pytest.mark.parametrize("name", CORNERS)
def test_given_phases(name):
    """Clearance, positions, tau and the leading multiplier of `periodic`; no verdict is wrong."""
    place, leading, _ = promised(name)
    count = DRAWS if name != "N = 16 to 64" else 3
    compared = 0
    with mp.workdps(DIGITS):
        for osc, r, phases, pattern in systems(name, count):
            try:
                motion = vi.periodic(osc, r, phases, pattern)
            except vi.errors.SingularError:
                continue
            compared += 1
            known = GivenPhases(osc, r, phases, pattern)
            size = max(known.clearance, *(abs(x) for x in known.x))
            off = [mp.mpf(float(a)) - b for a, b in zip(motion.X, known.x, strict=True)]
            assert max(abs(value) for value in off) <= place * size
            assert far(motion.clearance, known.clearance) <= place
            assert abs(mp.expj(mp.mpf(motion.tau) - known.tau) - 1) <= place
            radius = float(max(abs(value) for value in known.multipliers()))
            assert far(abs(motion.multipliers[0]), radius) <= leading
            assert motion.stable in (None, radius < 1)
            flags = vi.stability_flags(osc, [r], phases[:, None], pattern)
            assert flags.stable[0] in (-1, radius < 1)
    assert compared > count // 4


@pytest.mark.parametrize("name", [name for name in CORNERS if name != "N = 16 to 64"])
def test_exact_and_simulated(name):
    """Exact motions of two impacts, their first impacts in a simulation, and those of a structure.

    A structure of the same two masses is simulated by other procedures of the core.
    """
    _, leading, place = promised(name)
    compared = 0
    with mp.workdps(DIGITS):
        for osc, r, phases, pattern in systems(name, 8, pair=True):
            try:
                guess = vi.periodic(osc, r, phases, pattern)
                motion = vi.exact(osc, r, guess.clearance, guess)
            except vi.errors.SingularError:
                continue
            compared += 1
            known = ReferenceMotion(motion)
            size = max(mp.mpf(motion.clearance), *(abs(x) for x in known.u[:2]))
            assert all(
                abs(mp.mpf(float(a)) - b) <= place * size
                for a, b in zip(motion.X, known.u, strict=False)
            )
            for phase, theta in zip(motion.alpha, known.u[2:], strict=True):
                assert abs(mp.expj(mp.mpf(float(phase)) + mp.mpf(motion.tau) - theta) - 1) <= place
            radius = float(max(abs(value) for value in known.multipliers()))
            assert far(abs(motion.multipliers[0]), radius) <= leading
            assert motion.stable in (None, radius < 1)
            if motion.admissible and osc.restitution[0] > 0:
                assert_simulated(motion, known, place, size)
    assert compared or name.startswith("phases")


def assert_simulated(motion, known, place, size):
    """Phase and position of the first impact after the first one of the motion."""
    osc, first = motion.osc, after_impact(motion)
    cycles = (motion.alpha[1] * 1.001 + 1e-12) / (2 * math.pi)
    run = vi.simulate(osc, motion.r, motion.clearance, cycles, first)
    theta = float(known.u[3] - known.u[2])
    spread = 1e-11 + place
    event = run.events[0]
    assert abs(event["time"] * motion.r - first["t"] * motion.r - theta) <= spread * max(1, theta)
    assert abs(event["x"] - float(known.u[1])) <= 10 * place * float(size)
    if not osc.mu:
        return
    half = motion.clearance / 2
    gaps = [vi.Gap([-1, 1], half, osc.restitution[0]), vi.Gap([1, -1], half, osc.restitution[1])]
    structure = vi.Structure([1, osc.mu], [2 * osc.xi, 0], [1, 0], gaps)
    state = ([first["x"], first["z"]], [first["x_dot"], first["z_dot"]])
    duration = (event["time"] - first["t"]) * 1.0005 + 1e-12 / motion.r
    load, start = vi.Load(motion.r, sine=[1, 0]), first["t"]
    try:
        other = vi.simulate(structure, load, duration=duration, state=state, start=start)
    except (vi.errors.SingularError, vi.errors.ParameterError):
        return
    assert abs(other.events["time"][0] - event["time"]) * motion.r <= spread * max(1, theta)


def first_contact(osc, r, clearance, start, side, near):
    """The time near a given one at which the free mass meets a wall, and its speed there, in 50 digits."""
    xi, ratio, begin = mp.mpf(osc.xi), mp.mpf(r), mp.mpf(start["t"])
    gain, eta = 1 / mp.hypot(1 - ratio**2, 2 * xi * ratio), mp.sqrt(1 - xi**2)
    lag = mp.atan2(2 * xi * ratio, 1 - ratio**2)
    c = mp.mpf(start["x"]) - gain * mp.sin(ratio * begin - lag)
    s = (mp.mpf(start["x_dot"]) - gain * ratio * mp.cos(ratio * begin - lag) + xi * c) / eta

    def beyond(t):
        forced = gain * mp.sin(ratio * (begin + t) - lag)
        free = mp.exp(-xi * t) * (c * mp.cos(eta * t) + s * mp.sin(eta * t))
        return start["z"] + start["z_dot"] * t - forced - free - side * mp.mpf(clearance) / 2

    time = mp.findroot(beyond, near)
    return time, abs(mp.diff(beyond, time))


@pytest.mark.parametrize("powers", [(-9.95, -9), (-9, -4), (-4, 3), (3, 11)])
def test_small_and_large_clearances(powers):
    """The first impact of a simulation is as accurate as the displacements are, or the clearance is refused."""
    rng = np.random.default_rng(12)
    compared = 0
    with mp.workdps(DIGITS):
        for _ in range(40):
            osc = vi.Oscillator(xi=10 ** rng.uniform(-3, -0.3), mu=0.1, restitution=0.6)
            r = rng.uniform(0.5, 1.5)
            amplitude = 1 / math.hypot(1 - r * r, 2 * osc.xi * r)
            clearance = amplitude * 10 ** rng.uniform(*powers)
            x, gap = clearance * rng.uniform(-0.2, 0.2), clearance * rng.uniform(-0.4, 0.4)
            speeds = clearance * rng.uniform(-1, 1, 2)
            start = {
                "t": rng.uniform(0, 6),
                "x": x,
                "x_dot": speeds[0],
                "z": x + gap,
                "z_dot": speeds[1],
            }
            run = vi.simulate(osc, r, clearance, 3, start)
            if not len(run.events):
                continue
            compared += 1
            event, side = run.events[0], 1 if run.events[0]["side"] == "R" else -1
            flight = mp.mpf(float(event["time"])) - mp.mpf(start["t"])
            known, speed = first_contact(osc, r, clearance, start, side, flight)
            rounding = 2.3e-16 * (max(amplitude, clearance) / float(speed) + 6 + float(known))
            assert abs(flight - known) <= 2 * rounding
            assert abs(flight / known - 1) <= 2e-6
            for low, more in (
                (amplitude * 1.08e-10, {}),
                (1e3, {"state": start | {"x": 9.3e12, "z": 9.3e12}}),
            ):
                with pytest.raises(
                    vi.errors.ParameterError, match="a million times the rounding error"
                ) as refused:
                    vi.simulate(osc, r, low, 1, **more)
                least = float(re.search("at least ([^,]*)", str(refused.value))[1])
                vi.simulate(osc, r, least, 0.001, **more)
                assert low < least < 1.3 * low
    assert compared > 20


#: Heavy free masses: the residual hardly shows that these phases do not belong to a motion.
HEAVY = [
    (8202.382721515947, 0.0074877, 1.150934473, (0.343461772, 0.62152920), "RLR", [0, 0.456120354, 2.72733036]),
    (275.2255982760631, 0.0771409, 1.074423710, (0.615117902, 0.82508250), "RRRL",
     [0, 1.04984, 2.15551, 5.84657]),
]  # fmt: skip


@pytest.mark.parametrize(("mu", "xi", "r", "walls", "sides", "phases"), HEAVY)
def test_no_verdict_without_the_law(mu, xi, r, walls, sides, phases):
    """Where det[P] does not obey its law, `stable` is unknown in every function that gives it."""
    osc = vi.Oscillator(xi=xi, mu=mu, restitution=walls)
    motion = vi.periodic(osc, r, phases, sides)
    determinant = np.linalg.det(np.linalg.multi_dot(motion.impact_maps()[::-1]))
    law = math.exp(-4 * math.pi * xi / r) * np.prod(motion.restitution**2)
    assert motion.consistent
    assert abs(determinant / law - 1) > 0.01
    assert motion.stable is None
    columns = np.repeat(np.array(phases, float)[:, None], 40, axis=1)
    assert all(
        verdict is None or verdict == -1
        for verdict in vi.periodic_batch(osc, [r] * 40, columns, sides).stable
    )
    for radius in (False, True):
        flags = vi.stability_flags(osc, [r] * 40, columns, sides, spectral_radius=radius)
        assert (flags.stable == -1).all()
