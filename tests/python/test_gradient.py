"""Derivatives of motions by their parameters, compared with differences in 50 digits and with laws."""

import math

import mpmath as mp
import numpy as np
import pytest
import vibroimpact as vi
from reference_motion import DIGITS, ReferenceMotion
from shared_motions import COLUMN, UNEVEN, motions
from shared_systems import FIGURE6, RIG, TABLE

STEP = "1e-12"


#: The parameters without derivatives of a greatest value that both walls share: R1 and R2.
SYMMETRIC = [False] * 4 + [True] * 2 + [False] * 2


def uneven():
    """The motion of Table 1's third column at the clearance 37."""
    return vi.exact(TABLE, 0.94, 37.0, COLUMN)


def cases():
    """Motions of several patterns: unequal walls, another load, close to touching a wall."""
    yield uneven()
    three = [motion for motion in motions(RIG, 0.9, 6.0, 3, 1) if len(motion.pattern) == 3]
    yield three[0]
    yield vi.exact(UNEVEN, 1.1, 3.0, motions(UNEVEN, 1.1, 2.0, 3, 2)[-1], load=1.5)


def reference(motion, parameter):
    """Derivatives by one parameter, by central differences in 50 digits."""
    h = mp.mpf(STEP)
    ahead, behind = (ReferenceMotion(motion, **{parameter: step}).quantities() for step in (h, -h))
    found = {}
    for name, values in ahead.items():
        old = behind[name]
        if name == "multipliers":
            # in the order of the motion
            values, old = (
                [min(numbers, key=lambda z, at=at: abs(z - at)) for at in motion.multipliers]
                for numbers in (values, old)
            )
        if not isinstance(values, list):
            values, old = [values], [old]
        found[name] = np.array(
            [complex((b - a) / (2 * h)) for a, b in zip(old, values, strict=True)]
        )
    return found


@pytest.mark.slow
@pytest.mark.parametrize("number", range(3))
def test_agrees_with_differences_of_50_digits(number):
    """Every quantity by every parameter, to 1e-10 of the largest derivative of that quantity."""
    motion = list(cases())[number]
    gradient = motion.gradient()
    assert "multipliers" in gradient.values
    assert not [text for text in gradient.status.values() if "not stationary" not in text]
    with mp.workdps(DIGITS):
        for parameter in gradient.parameters:
            if parameter == "R":
                continue
            for name, expected in reference(motion, parameter).items():
                got = np.atleast_1d(gradient[name, parameter])
                scale = np.nanmax(np.abs(gradient[name]), initial=1.0)
                there = ~np.isnan(expected)
                assert np.array_equal(there, ~np.isnan(got)), (name, parameter)
                assert got[there] == pytest.approx(expected[there], abs=1e-10 * scale, rel=1e-10), (
                    name,
                    parameter,
                )


@pytest.mark.parametrize("number", range(3))
def test_laws(number):
    """Both R together, the unit of length, and det [P] = exp(-4 pi xi k/r) prod R_i^2."""
    motion = list(cases())[number]
    gradient, system = motion.gradient(), motion.osc
    for name, values in gradient.values.items():
        both = gradient[name, "R1"] + gradient[name, "R2"]
        assert np.allclose(gradient[name, "R"], both, rtol=1e-12, atol=0, equal_nan=True)
        power = 0 if name in PURE else 1
        scaled = (
            motion.clearance * gradient[name, "clearance"] + motion.load * gradient[name, "load"]
        )
        size = np.nanmax(np.abs(gradient[name, "clearance"]), initial=0) * motion.clearance + 1
        assert scaled == pytest.approx(power * values, abs=1e-12 * size, nan_ok=True), name
    decay = 4 * math.pi * motion.pattern.cycles / motion.r
    right = motion.pattern.signs > 0
    expected = {
        "r": decay * system.xi / motion.r,
        "xi": -decay,
        "R1": (2 / motion.restitution[right]).sum(),
        "R2": (2 / motion.restitution[~right]).sum(),
        "mu": 0.0,
        "clearance": 0.0,
    }
    for name, law in expected.items():
        terms = gradient["multipliers", name] / motion.multipliers
        assert terms.sum() == pytest.approx(law, abs=1e-9 * np.abs(terms).max(initial=1)), name


PURE = (
    "alpha", "phases", "tau", "load_phase", "attenuation", "fundamental_phase", "stability_margin", "multipliers",
)  # fmt: skip


def test_values_are_those_of_the_motion():
    """The quantities of the gradient that the motion has as well."""
    motion = uneven()
    gradient = motion.gradient()
    for name in gradient.values:
        if hasattr(motion, name):
            assert gradient.values[name] == pytest.approx(getattr(motion, name), rel=1e-9), name
    assert gradient.values["stability_margin"] == pytest.approx(1 - abs(motion.multipliers[0]))
    response = motion.quantities().x
    assert gradient.values["x_rms"] == pytest.approx(response.rms, rel=1e-12)
    assert gradient.values["fundamental_amplitude"] == pytest.approx(response.amplitude, rel=1e-12)
    assert gradient.values["fundamental_phase"] == pytest.approx(response.phase, rel=1e-12)
    assert gradient.values["approach_speeds"] == pytest.approx(
        motion.pattern.signs * (motion.Z_dot_before - motion.X_dot_before)
    )


def test_symmetric_motion():
    """The mirror image changes alike; max|x| is reached on both sides, which R1 alone changes differently."""
    motion = vi.equispaced(TABLE, 0.94, 37.0)[0]
    gradient = motion.gradient()
    for name in ("X", "Z", "X_dot_before", "X_dot_after", "Z_dot_before", "Z_dot_after"):
        first, second = gradient[name]
        swapped = second[[0, 1, 2, 3, 5, 4, 6, 7]]
        assert first == pytest.approx(-swapped, rel=1e-10, abs=1e-10 * abs(first).max())
    missing = np.isnan(gradient["attenuation"])
    assert [gradient.parameters[i] for i in np.flatnonzero(missing)] == ["R1", "R2"]
    assert "equally large" in gradient.status["attenuation"]


@pytest.mark.parametrize(
    ("xi", "mu", "r", "clearance"),
    [
        (0.00030354624653739805, 0.0018542386387087302, 2.819861542568646, 0.30838358853245346),
        (0.00010587058435497757, 0.009412574453329978, 2.060129580274066, 0.6716313722270588),
    ],
)
def test_symmetric_motions_that_hardly_depend_on_restitution(xi, mu, r, clearance):
    """The restitution of one wall separates the extremes by 1e-10 of their size: still there is no derivative."""
    osc = vi.Oscillator(xi=xi, mu=mu, restitution=1.0)
    found = [motion.gradient() for motion in vi.equispaced(osc, r, clearance)]
    assert found
    for gradient in found:
        assert np.isnan(gradient["attenuation"][4:6]).all()
    # in the other motion x_max itself is reached twice
    once = [gradient for gradient in found if np.isfinite(gradient["x_max"]).all()]
    assert once
    assert once[0]["x_max", "R1"] == pytest.approx(-once[0]["x_min", "R2"], rel=1e-4)
    assert np.isnan(once[0]["attenuation"]).tolist() == SYMMETRIC


def test_predicts_the_next_motion():
    """A change of all parameters by h changes the motion by the gradient times h, to the order h^2."""
    motion = uneven()
    gradient = motion.gradient()
    errors = []
    for h in (1e-4, 1e-5):
        step = h * np.array([1.0, 10.0, 0.1, 0.3, 1.0, -0.5, 0.0, 1.0])
        osc = vi.Oscillator(
            xi=TABLE.xi + step[2],
            mu=TABLE.mu + step[3],
            restitution=(0.75 + step[4], 0.75 + step[5]),
        )
        near = vi.exact(osc, 0.94 + step[0], 37.0 + step[1], motion, load=1 + step[7])
        errors.append(
            max(
                np.abs(getattr(near, name) - getattr(motion, name) - gradient[name] @ step).max()
                for name in ("X", "X_dot_after", "x_max", "attenuation", "multipliers")
            )
        )
    assert errors[1] < 1.5e-2 * errors[0]


def test_refuses_where_there_are_no_derivatives():
    """A fold, a grazing, and phases that are not exact are refused by name."""
    branch = vi.branch(uneven(), "r", (0.8, 1.1))
    special = {point.type: point.motion for point in branch.special_points}
    assert {"fold", "pitchfork", "grazing", "flip"} <= set(special)
    for kind in ("fold", "pitchfork", "grazing"):
        with pytest.raises(vi.SingularError, match="a graze" if kind == "grazing" else "a fold"):
            special[kind].gradient()
    # a flip is no obstacle: the motion continues through it
    gradient = special["flip"].gradient()
    assert gradient.values["stability_margin"] == pytest.approx(0, abs=1e-9)
    assert np.isfinite(gradient["stability_margin"]).all()
    rough = vi.periodic(RIG, 0.9, np.array([0.0, 2.0, 3.0]), "RRL")
    with pytest.raises(vi.SingularError, match="exact motion first"):
        rough.gradient()


def test_refuses_other_motions():
    """Unknown quantities or parameters are refused."""
    gradient = uneven().gradient()
    with pytest.raises(vi.ParameterError, match="quantity 'x': must be one of alpha, X"):
        gradient["x"]
    with pytest.raises(vi.ParameterError, match="parameter 'k': must be one of r, clearance"):
        gradient["X", "k"]


def test_coincident_multipliers_have_a_status():
    """Where a complex pair becomes two real multipliers these have no derivatives; the others do."""
    low, high = 34.97, 37.0
    motion = uneven()
    for _ in range(60):
        middle = (low + high) / 2
        motion = vi.exact(TABLE, 0.94, middle, motion)
        if (motion.multipliers.imag != 0).all():
            high = middle
        else:
            low = middle
    gradient, multipliers = motion.gradient(), motion.multipliers
    apart = np.abs(multipliers[:, None] - multipliers) + np.eye(4)
    double = apart.min(axis=1) < 1e-6
    assert double.sum() == 2
    assert np.isnan(gradient["multipliers"][double]).all()
    assert np.isfinite(gradient["multipliers"][~double]).all()
    assert all("coincide" in gradient.status[f"multipliers[{i}]"] for i in np.flatnonzero(double))
    assert np.isfinite(gradient["X"]).all()


def test_motion_with_rest():
    """Derivatives equal differences between exact motions, to the rounding of these, and scale with the length."""
    motion = vi.exact(RIG, 0.9, 6.0, vi.simulate(RIG, 0.9, 6.0, cycles=8, discard=200))
    assert motion.pattern.has_rest
    gradient = motion.gradient()
    values = {
        "r": 0.9,
        "clearance": 6.0,
        "xi": RIG.xi,
        "mu": RIG.mu,
        "R1": 0.75,
        "R2": 0.61,
        "load": 1.0,
    }
    names = ("alpha", "phases", "X", "Z", "X_dot_before", "X_dot_after", "Z_dot_after", "tau", "load_phase", "A",
             "x_max", "x_min", "attenuation")  # fmt: skip
    weights, h = {-2: 1, -1: -8, 1: 8, 2: -1}, 1e-5
    for parameter in values:
        total = dict.fromkeys(names, 0.0)
        for step, weight in weights.items():
            moved = values | {parameter: values[parameter] + step * h}
            osc = vi.Oscillator(
                xi=moved["xi"], mu=moved["mu"], restitution=(moved["R1"], moved["R2"])
            )
            near = vi.exact(osc, moved["r"], moved["clearance"], motion, load=moved["load"])
            for name in names:
                total[name] = total[name] + weight * getattr(near, name) / (12 * h)
        for name, expected in total.items():
            size = max(1.0, np.abs(gradient[name]).max())
            assert gradient[name, parameter] == pytest.approx(expected, abs=1e-7 * size), (
                name,
                parameter,
            )
    for name in names:
        power = 0 if name in PURE else 1
        scaled = 6.0 * gradient[name, "clearance"] + gradient[name, "load"]
        size = np.abs(gradient[name, "clearance"]).max() * 6.0 + 1
        assert scaled == pytest.approx(power * gradient.values[name], abs=1e-9 * size), name
    # two multipliers are 0 and coincide
    apart = np.abs(motion.multipliers) > 1e-3
    assert apart.any()
    assert np.isfinite(gradient["multipliers"][apart]).all()
    for parameter in ("r", "clearance", "mu", "R1"):
        ends = []
        for step in (h, -h):
            moved = values | {parameter: values[parameter] + step}
            osc = vi.Oscillator(
                xi=moved["xi"], mu=moved["mu"], restitution=(moved["R1"], moved["R2"])
            )
            ends.append(vi.exact(osc, moved["r"], moved["clearance"], motion).multipliers[0])
        assert gradient["multipliers", parameter][0] == pytest.approx(
            (ends[0] - ends[1]) / (2 * h), rel=1e-5, abs=1e-5
        )
    assert gradient["stability_margin", "mu"] == pytest.approx(
        -np.abs(motion.multipliers[0])
        * (gradient["multipliers", "mu"] / motion.multipliers)[0].real
    )


def test_extreme_at_an_impact():
    """Where an impact reverses the primary mass, its position is the extreme, and has the same derivatives."""
    osc = vi.Oscillator(
        xi=0.0041569628760348585, mu=1.8902694504388748, restitution=(0.4877735757663336, 0.24949359287277673)
    )  # fmt: skip
    r, clearance = 2.605906995313719, 0.24330279747179723
    motion = vi.exact(osc, r, clearance, vi.simulate(osc, r, clearance, cycles=8, discard=400))
    assert motion.pattern.sides == "RL*"
    assert motion.x_min == motion.X[0]
    gradient = motion.gradient()
    assert gradient["x_min"] == pytest.approx(gradient["X"][0], rel=1e-12)
    h = 1e-5
    ends = [vi.exact(osc, r, clearance + step, motion) for step in (h, -h)]
    for name in ("x_min", "x_max", "attenuation"):
        change = getattr(ends[0], name) - getattr(ends[1], name)
        assert gradient[name, "clearance"] == pytest.approx(change / (2 * h), rel=1e-6), name
    assert gradient["x_min", "clearance"] == pytest.approx(-0.61647429846, rel=1e-9)


@pytest.mark.parametrize(
    ("xi", "mu", "R", "r", "clearance"),
    [(0.02, 0.003, 0.49, 0.8, 0.013), (0.01, 0.001, 0.27, 0.1, 0.025), (0.03, 0.02, 0.0, 0.4, 0.4)],
)
def test_symmetric_motion_with_rest(xi, mu, R, r, clearance):
    """By symmetry x_max depends on R1 as -x_min on R2; the attenuation has no derivative by one of them alone.

    Where R is 0 every impact begins a rest, and no quantity depends on R to first order.
    """
    osc = vi.Oscillator(xi=xi, mu=mu, restitution=R)
    run = vi.simulate(osc, r, clearance, cycles=10, discard=500)
    motion = vi.exact(osc, r, clearance, run)
    assert sorted(motion.pattern.symbols) == ["L*", "R*"]
    gradient = motion.gradient()
    for one, other in (("R1", "R2"), ("R2", "R1"), ("R", "R"), ("mu", "mu"), ("xi", "xi")):
        assert gradient["x_max", one] == pytest.approx(
            -gradient["x_min", other], rel=1e-5, abs=1e-12
        )
    assert np.isnan(gradient["attenuation"]).tolist() == (SYMMETRIC if R else [False] * 8)
    assert ("equally large" in gradient.status.get("attenuation", "")) == (R > 0)
    if not R:
        assert gradient["x_max"][4:7] == pytest.approx([0, 0, 0], abs=1e-12)


def test_motion_of_many_impacts():
    """A motion counted over 13 periods has the derivatives of one period, and its multipliers are their powers."""
    one = vi.exact(TABLE, 0.94, 37.0, COLUMN)
    phases = (one.alpha + 2 * math.pi * np.arange(13)[:, None]).ravel()
    many = vi.exact(TABLE, 0.94, 37.0, (phases, vi.Pattern("RL" * 13, 13)))
    assert len(many.pattern) == 26
    few, gradient = one.gradient(), many.gradient()
    for name in ("X", "Z", "X_dot_before", "Z_dot_after", "approach_speeds"):
        expected = np.tile(few[name], (13, 1))
        assert gradient[name] == pytest.approx(
            expected, rel=1e-8, abs=1e-8 * np.abs(expected).max()
        )
    for name in ("A", "x_max", "x_min", "attenuation", "load_phase"):
        assert gradient[name] == pytest.approx(few[name], rel=1e-7, abs=1e-7), name
    power = 13 * one.multipliers[:2, None] ** 12 * few["multipliers"][:2]
    found = [int(np.abs(many.multipliers - value**13).argmin()) for value in one.multipliers[:2]]
    assert gradient["multipliers"][found] == pytest.approx(power, rel=1e-6, abs=1e-8)


def test_shows_itself():
    """The printed table, and the dataset."""
    gradient = vi.equispaced(FIGURE6, 0.94, 20.0)[0].gradient()
    assert "22 quantities by r, clearance, xi, mu, R1, R2, R, load" in repr(gradient)
    assert "attenuation" in str(gradient)
    assert "multipliers[3] imag" in str(gradient)
    table = gradient.to_xarray()
    assert table["X"].dims == ("impact", "parameter")
    assert float(table["x_max"].sel(parameter="mu")) == gradient["x_max", "mu"]
    with pytest.raises(ValueError, match="read-only"):
        gradient["X"][0, 0] = 1.0
