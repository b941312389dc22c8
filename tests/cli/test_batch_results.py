"""Numbers in results: their laws, the header that reproduces them, and bitwise agreement with the Python API."""

import cmath
import math
import random

import pytest
import vibroimpact as vi
from programs import (
    IMPACT,
    SYSTEM,
    Runner,
    assert_same,
    contents,
    floats,
    motions,
    multipliers,
)


def random_case(rng, n):
    """Parameters of a motion with n impacts, all of them within their ranges."""
    cycles = rng.randint(1, 3)
    phases = sorted(rng.uniform(0.05, 2 * cycles - 0.05) for _ in range(n - 1))
    sides = "RL" + "".join(rng.choice("RL") for _ in range(n - 2))
    return {
        "xi": rng.uniform(0.0, 0.3), "mu": rng.uniform(0.0, 0.5), "r": rng.uniform(0.3, 2.0),
        "restitution": (rng.uniform(0.3, 1.0), rng.uniform(0.3, 1.0)), "cycles": cycles,
        "sides": sides, "phases_over_pi": [0.0, *phases],
        "impact_restitution": [rng.uniform(0.3, 1.0) for _ in range(n)] if n % 2 else None,
    }  # fmt: skip


def namelist(case, name, precision):
    """The namelist of a random case, its numbers written with all their digits."""
    own = case["impact_restitution"]
    each = f", impact_restitution = {', '.join(map(repr, own))}" if own else ""
    return (
        f"&system xi = {case['xi']!r}, mu = {case['mu']!r}, r = {case['r']!r}\n"
        f"restitution = {case['restitution'][0]!r}, {case['restitution'][1]!r} /\n"
        f"&motion sides = '{case['sides']}', cycles = {case['cycles']}, acceptance = 1\n"
        f"phases_over_pi = {', '.join(map(repr, case['phases_over_pi']))}\n"
        f"precision = '{precision}'{each} /\n&output name = '{name}' /\n"
    )


def by_api(case, precision):
    """The same case through the Python API."""
    osc = vi.Oscillator(xi=case["xi"], mu=case["mu"], restitution=case["restitution"])
    return vi.periodic(
        osc, case["r"], [phase * math.pi for phase in case["phases_over_pi"]],
        vi.Pattern(case["sides"], case["cycles"]), case["impact_restitution"], precision,
        acceptance=1.0,
    )  # fmt: skip


@pytest.fixture(scope="module")
def cases():
    """Random cases with 2 to 5 impacts, in both precisions."""
    rng = random.Random(1983)
    made = [random_case(rng, n) for n in (2, 2, 2, 3, 4, 5) for _ in range(5)]
    return {
        f"{precision}_{i}": (case, precision)
        for i, case in enumerate(made)
        for precision in ("double", "single")
    }


@pytest.fixture(scope="module")
def results(cases, binary, tmp_path_factory):
    """The folder with the results of all random cases."""
    folder = tmp_path_factory.mktemp("random")
    text = "".join(namelist(case, name, word) for name, (case, word) in cases.items())
    done = Runner([binary], folder).case(text)
    assert (done.status, done.err) == (0, b""), done
    return folder / "results"


@pytest.fixture(scope="module")
def doubles(cases, results):
    """Every random case in double precision, with its motion."""
    return [
        (case, motions(results / f"{name}.csv")[0])
        for name, (case, word) in cases.items()
        if word == "double"
    ]


def close(left, right, scale=1.0):
    """Check equality to rounding."""
    return math.isclose(left, right, rel_tol=1e-9, abs_tol=1e-9 * scale)


def test_momentum_is_conserved(doubles):
    """At an impact x' + mu z' is conserved."""
    for case, motion in doubles:
        columns = [floats(motion, key) for key in IMPACT[2:]]
        for xb, xa, zb, za in zip(*columns, strict=True):
            scale = abs(xb) + abs(zb)
            assert close(xa + case["mu"] * za, xb + case["mu"] * zb, scale)


def test_restitution_at_every_impact(doubles):
    """The relative velocity is reversed and multiplied by the R of that impact."""
    for case, motion in doubles:
        walls = dict(zip("RL", case["restitution"], strict=True))
        expected = case["impact_restitution"] or [walls[side] for side in case["sides"]]
        assert floats(motion, "restitution") == expected
        columns = [floats(motion, key) for key in ("restitution", *IMPACT[2:])]
        for R, xb, xa, zb, za in zip(*columns, strict=True):
            assert close(za - xa, -R * (zb - xb), abs(zb) + abs(xb))


def test_free_mass_touches_the_walls(doubles):
    """At an impact z - x = +d/2 on the right wall, -d/2 on the left one."""
    for _, motion in doubles:
        half = floats(motion, "clearance")[0] / 2
        assert half > 0
        x_column, z_column = floats(motion, "x"), floats(motion, "z")
        for side, x, z in zip(motion["side"], x_column, z_column, strict=True):
            assert close(z - x, half if side == "R" else -half, abs(x))


def test_free_mass_flies_straight(doubles):
    """Between impacts z' is constant, and z grows by z' times the time (phase / r)."""
    for case, motion in doubles:
        columns = [floats(motion, key) for key in ("phase", "z", "z_dot_before", "z_dot_after")]
        points = list(zip(*columns, strict=True))
        turn = (points[0][0] + 2 * math.pi * case["cycles"], *points[0][1:])
        following = [*points[1:], turn]
        for (t0, z0, _, after), (t1, z1, before, _) in zip(points, following, strict=True):
            assert close(before, after, abs(z0) + 1)
            assert close(z1 - z0, after * (t1 - t0) / case["r"], abs(z0) + abs(z1))


def test_primary_mass_obeys_newton(doubles):
    """For N = 2, x'' + 2 xi x' + x = sin(load) carries each impact's state to the next one."""
    for case, motion in doubles:
        if len(case["sides"]) > 2:
            continue
        phases = [*floats(motion, "phase"), 2 * math.pi * case["cycles"]]
        x, before, after = (floats(motion, k) for k in ("x", "x_dot_before", "x_dot_after"))
        A, tau = floats(motion, "A")[0], floats(motion, "tau")[0]
        for i in range(2):
            state = (x[i], after[i])
            end = flight(case, A, tau, phases[i], phases[i + 1], state)
            assert close(end[0], x[1 - i], A)
            assert close(end[1], before[1 - i], A)


def flight(case, A, tau, start, stop, state):
    """Position and velocity after a flight, by complex exponentials."""
    xi, r = case["xi"], case["r"]
    root = complex(-xi, math.sqrt(1 - xi * xi))
    time = (stop - start) / r
    u = state[0] - A * math.sin(start + tau)
    v = state[1] - A * r * math.cos(start + tau)
    # u(t) = Re(c exp(root t)) with Re(c) = u, Re(c root) = v
    c = complex(u, (root.real * u - v) / root.imag)
    free = c * cmath.exp(root * time)
    position = free.real + A * math.sin(stop + tau)
    return position, (root * free).real + A * r * math.cos(stop + tau)


def test_amplitude_without_impacts(doubles):
    """A = 1/sqrt((1 - r^2)^2 + (2 xi r)^2) in units of F0/K."""
    for case, motion in doubles:
        xi, r = case["xi"], case["r"]
        assert close(floats(motion, "A")[0], 1 / math.hypot(1 - r * r, 2 * xi * r))


def test_product_of_the_multipliers(doubles):
    """det[P] = exp(-4 pi xi k/r) times the product of all R^2, for N = 2 (exact motions)."""
    for case, motion in doubles:
        if len(case["sides"]) > 2:
            continue
        expected = math.exp(-4 * math.pi * case["xi"] * case["cycles"] / case["r"])
        expected *= math.prod(R * R for R in floats(motion, "restitution"))
        product = math.prod(multipliers(motion), start=1)
        largest = max(map(abs, multipliers(motion)))
        assert abs(product - expected) <= 1e-9 * max(expected, 1e-6 * largest**2)


def test_extremes_enclose_the_impacts(doubles):
    """x_min <= X_i <= x_max, and the attenuation is max|x|/A."""
    for _, motion in doubles:
        low, high, ratio, A = (floats(motion, k)[0] for k in ("x_min", "x_max", "attenuation", "A"))
        assert all(low <= x <= high for x in floats(motion, "x"))
        assert ratio == max(-low, high) / A


def test_same_bits_as_the_python_api(cases, results, same_build):
    """Each 17-digit number parses to exactly the number that `vi.periodic` returns."""
    for name, (case, precision) in cases.items():
        (motion,) = motions(results / f"{name}.csv")
        assert_same(motion, by_api(case, precision))


@pytest.mark.parametrize("word", ["double", "single"])
def test_given_numbers_stand_in_the_rows(word, cases, results):
    """r, phases and restitution in the rows equal those of the header and of the Python API."""
    for name, (case, precision) in cases.items():
        if precision != word:
            continue
        motion, expected = motions(results / f"{name}.csv")[0], by_api(case, precision)
        assert floats(motion, "r")[0] == expected.r
        assert floats(motion, "phase") == expected.alpha.tolist()
        assert floats(motion, "restitution") == expected.restitution.tolist()


def test_single_precision_differs(cases, results):
    """For N = 2, single precision gives the same numbers to 1e-2, but never the same bits."""
    for i in range(15):
        double, single = (motions(results / f"{w}_{i}.csv")[0] for w in ("double", "single"))
        x, y = floats(double, "x")[0], floats(single, "x")[0]
        scale = floats(double, "A")[0] + floats(double, "clearance")[0]
        assert 0 < abs(x - y) < 1e-2 * scale


def test_results_are_inputs(cases, results, binary, tmp_path):
    """Every result, run as an input, reproduces itself byte for byte."""
    names = [f"{name}.csv" for name in cases]
    done = Runner([binary], results)(*names, "-o", str(tmp_path / "again"))
    assert (done.status, done.err) == (0, b"")
    assert contents(tmp_path / "again") == contents(results)


def test_command_gives_the_same_bytes(cases, results, command, tmp_path):
    """`vibroimpact run` writes the same files as the program."""
    text = "".join(namelist(case, name, word) for name, (case, word) in cases.items())
    assert command.case(text, "-o", "out").status == 0
    assert contents(tmp_path / "out") == contents(results)


def test_printout_has_no_stars(cases, batch):
    """No number of the printout overflows its column, whatever the parameters."""
    texts = [namelist(case, name, word) for name, (case, word) in cases.items()]
    wide = SYSTEM + "&motion sides = 'RL', phases = 0, 1e-7 /\n&output name = 'wide' /\n"
    text = "".join([*texts, wide]).replace("name = ", "format = 'table', name = ")
    batch.case(text)
    assert "wide.txt" in contents(batch.cwd / "results")
    for name, content in contents(batch.cwd / "results").items():
        assert b"*" not in content, name
