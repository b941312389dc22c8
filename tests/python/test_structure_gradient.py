"""Derivatives of motions of structures, compared with those of the oscillator, laws, and differences."""

import math

import numpy as np
import pytest
import vibroimpact as vi
from test_structure_motion import damper, samples
from test_structure_rest import BALLS, ball_on_a_table, inelastic_walls, settled_with_rest

PHASES = [0.517272128279 * math.pi, 1.899298624085 * math.pi]


@pytest.fixture(scope="module")
def pair():
    """The motion of the third column of Table 1, of a structure and of the oscillator."""
    structure = vi.exact(damper(), vi.Load(0.94, sine=[1, 0]), (PHASES, [0, 1]))
    osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    return structure, vi.exact(osc, 0.94, 37.0, ([0, PHASES[1] - PHASES[0]], vi.Pattern("RL")))


@pytest.fixture(scope="module")
def random_motions():
    """Motions of random structures, with two harmonics and free masses."""
    return [motion for motion, _ in samples(6, seed=3)]


@pytest.mark.parametrize(
    ("name", "parameter", "factor"),
    [
        ("frequency", "r", 1), ("mass_1_1", "mu", 1), ("opening", "clearance", 2),
        ("restitution", "R", 1), ("restitution_0", "R1", 1), ("restitution_1", "R2", 1),
        ("load", "load", 1), ("damping_0_0", "xi", 0.5),
    ],
)  # fmt: skip
def test_agrees_with_the_oscillator(pair, name, parameter, factor):
    """Two methods without a common formula agree to 1e-10 of the largest derivative of each quantity."""
    ours, theirs = pair[0].gradient([name]), pair[1].gradient()
    for mine, other in [
        (ours["q", name][:, 0], theirs["X", parameter]),
        (ours["q", name][:, 1], theirs["Z", parameter]),
        (ours["q_dot", name][:, 0], theirs["X_dot_after", parameter]),
        (ours["q_dot", name][:, 1], theirs["Z_dot_after", parameter]),
        (ours["speeds", name], theirs["approach_speeds", parameter]),
        (ours["phases", name], theirs["phases", parameter]),
    ]:  # fmt: skip
        scale = 1e-10 * max(1.0, np.abs(other).max())
        assert mine == pytest.approx(factor * other, abs=scale)
    for multiplier, slope in zip(pair[0].multipliers, ours["multipliers", name], strict=True):
        at = np.abs(pair[1].multipliers - multiplier).argmin()
        expected = factor * theirs["multipliers", parameter]
        assert slope == pytest.approx(expected[at], abs=1e-10 * np.abs(expected).max())
    assert ours["stability_margin", name] == pytest.approx(
        factor * theirs["stability_margin", parameter], rel=1e-9
    )


def test_laws_of_random_structures(random_motions):
    """Scaling by the units of mass, length and time, and det P = exp(-tr(M^-1 C) T) prod R_i^2."""
    checked = 0
    for motion in random_motions:
        factors = ["mass", "damping", "stiffness", "load"]
        each = range(len(motion.structure.gaps))
        names = [
            *factors,
            "frequency",
            *(f"{word}_{j}" for word in ("opening", "restitution") for j in each),
        ]
        gradient = motion.gradient(names)
        frequency = motion.load.frequency
        openings = [gap.opening for gap in motion.structure.gaps]
        inverse = np.linalg.inv(motion.structure.mass)
        decay = motion.period * np.trace(inverse @ motion.structure.damping)
        law = {
            "mass": decay,
            "damping": -decay,
            "stiffness": 0.0,
            "load": 0.0,
            "frequency": decay / frequency,
        }
        for j in each:
            restitution = motion.structure.gaps[j].restitution
            law |= {
                f"opening_{j}": 0.0,
                f"restitution_{j}": 2 * (motion.gaps == j).sum() / restitution,
            }
        for name, expected in law.items():
            terms = gradient["multipliers", name] / motion.multipliers
            if not np.isnan(terms).any() and np.abs(motion.multipliers).min() > 1e-4:
                checked += 1
                size = np.abs(terms).max(initial=1.0)
                assert terms.sum() == pytest.approx(expected, abs=1e-8 * size), name
        for quantity, values in gradient.values.items():
            table = gradient[quantity]
            if np.isnan(table).any():
                continue
            size = 1e-9 * np.abs(table).max(initial=1.0) * max(1.0, frequency)
            mass = sum(gradient[quantity, name] for name in factors)
            assert mass == pytest.approx(values if quantity == "impulses" else 0 * values, abs=size)
            time = frequency * gradient[quantity, "frequency"] + gradient[quantity, "damping"]
            time = time + 2 * gradient[quantity, "stiffness"] + 2 * gradient[quantity, "load"]
            speed = quantity in ("speeds", "impulses", "q_dot")
            assert time == pytest.approx(values if speed else 0 * values, abs=size), quantity
            length = gradient[quantity, "load"] + sum(
                opening * gradient[quantity, f"opening_{j}"] for j, opening in enumerate(openings)
            )
            long = quantity in ("speeds", "impulses", "q", "q_dot")
            assert length == pytest.approx(values if long else 0 * values, abs=size), quantity
    assert checked > 30


def test_agrees_with_differences(random_motions):
    """Derivatives equal sixth-order differences between exact motions, to the rounding of these."""
    motion = max(random_motions, key=lambda one: one.structure.coordinates)
    weights = {-3: -1, -2: 9, -1: -45, 1: 45, 2: -9, 3: 1}

    def stiffer(p):
        matrix = motion.structure.stiffness.copy()
        matrix[0, 0] += p**2
        changed = vi.Structure(
            motion.structure.mass, motion.structure.damping, matrix, motion.structure.gaps
        )
        return changed, motion.load

    function = ("spring", lambda p: stiffer(np.sqrt(max(p, 0.0)) - 1.0), 1.0)
    gradient = motion.gradient([function, "frequency"])
    h = 1e-4
    for name in ("spring", "frequency"):
        sums = dict.fromkeys(("phases", "speeds", "q", "q_dot", "impulses"), 0.0)
        for step, weight in weights.items():
            if name == "spring":
                structure, load = function[1](1.0 + step * h)
            else:
                structure, old = motion.structure, motion.load
                load = vi.Load(old.frequency + step * h, sine=old.sine, cosine=old.cosine)
            near = vi.exact(structure, load, motion)
            values = {"phases": near.phases, "speeds": near.speeds, "q": near.states[:, 0],
                      "q_dot": near.states[:, 1], "impulses": near.impulses}  # fmt: skip
            for quantity in sums:
                sums[quantity] = sums[quantity] + weight * values[quantity] / (60 * h)
        for quantity, slope in sums.items():
            size = max(1.0, np.abs(slope).max())
            assert gradient[quantity, name] == pytest.approx(slope, abs=1e-8 * size), (
                quantity,
                name,
            )


def test_a_function_is_a_name(pair):
    """The same change by a name and by a function gives the same derivatives."""
    motion = pair[0]

    def heavier(m):
        structure = motion.structure
        mass = structure.mass.copy()
        mass[1, 1] = m
        return vi.Structure(
            mass, structure.damping, structure.stiffness, structure.gaps
        ), motion.load

    gradient = motion.gradient(["mass_1_1", ("m", heavier, 0.042)])
    assert gradient.parameters == ("mass_1_1", "m")
    for quantity in gradient.values:
        table = gradient[quantity]
        assert table[..., 0] == pytest.approx(
            table[..., 1], rel=1e-10, abs=1e-10 * np.abs(table).max()
        )


@pytest.mark.parametrize(
    "law",
    [
        vi.PowerLaw(0.8, speed=20.0, exponent=0.25),
        vi.TabulatedRestitution([0.0, 10.0, 30.0, 60.0], [0.85, 0.8, 0.7, 0.6]),
    ],
)
def test_restitution_that_depends_on_the_speed(law):
    """Derivatives equal differences, and the determinant obeys the law R (R + R' v)."""
    load = vi.Load(0.94, sine=[1, 0])
    motion = vi.exact(damper(restitution=law), load, (PHASES, [0, 1]))
    gradient = motion.gradient()
    h = 1e-5
    weights = {-2: 1, -1: -8, 1: 8, 2: -1}
    total = {"speeds": 0.0, "multipliers": 0.0}
    for step, weight in weights.items():
        near = vi.exact(damper(restitution=law), vi.Load(0.94 + step * h, sine=[1, 0]), motion)
        order = [int(np.abs(near.multipliers - one).argmin()) for one in motion.multipliers]
        total["speeds"] = total["speeds"] + weight * near.speeds / (12 * h)
        total["multipliers"] = total["multipliers"] + weight * near.multipliers[order] / (12 * h)
    assert gradient["speeds", "frequency"] == pytest.approx(total["speeds"], rel=1e-8)
    assert gradient["multipliers", "frequency"] == pytest.approx(
        total["multipliers"], abs=1e-6 * np.abs(total["multipliers"]).max()
    )
    assert ("restitution_0" in gradient.parameters) == isinstance(law, vi.PowerLaw)


def test_refuses_where_there_are_no_derivatives(pair):
    """A fold, and phases that are not exact, are refused by name."""
    branch = vi.branch(pair[0], "frequency", (0.85, 1.1))
    special = {point.type: branch[point.index] for point in branch.special_points}
    for kind in ("fold", "pitchfork"):
        if kind in special:
            with pytest.raises(vi.SingularError, match="fold or a pitchfork"):
                special[kind].gradient()
    assert {"fold", "pitchfork"} & set(special)
    rough = vi.periodic(damper(), vi.Load(0.94, sine=[1, 0]), [1.6, 5.9], gaps=[0, 1])
    with pytest.raises(vi.SingularError, match="exact motion first"):
        rough.gradient()


def test_refuses_parameters_that_are_not_there(pair):
    """Each error gives the allowed values."""
    motion = pair[0]
    for name in ("masses", "mass_0", "opening_0_1", "frequency_1", "x", ""):
        with pytest.raises(vi.ParameterError, match="must be 'frequency', 'load'"):
            motion.gradient([name])
    for name in ("opening_7", "mass_5_5", "constant"):
        with pytest.raises(vi.ParameterError, match="it changes nothing in this structure"):
            motion.gradient([name])
    with pytest.raises(vi.ParameterTypeError, match="must be a list of parameters"):
        motion.gradient("frequency")
    with pytest.raises(
        vi.ParameterTypeError, match=r"must be a name, or \(name, function, value\)"
    ):
        motion.gradient([3])
    table = vi.TabulatedRestitution([0.0, 10.0, 60.0], [0.85, 0.8, 0.6])
    other = vi.exact(damper(restitution=table), vi.Load(0.94, sine=[1, 0]), (PHASES, [0, 1]))
    with pytest.raises(vi.ParameterError, match="is a table"):
        other.gradient(["restitution_0"])


@pytest.mark.parametrize("ball", [None, *BALLS])
def test_motions_that_rest_where_r_is_0_or_the_opening_is(ball):
    """Derivatives equal differences of motions, which are one-sided at R = 0."""
    system = inelastic_walls() if ball is None else ball_on_a_table(*ball)
    motion = settled_with_rest(*system)
    structure, load = system
    names = ["frequency", "load", "opening", "restitution_0"]
    gradient = motion.gradient(names)

    def moved(**steps):
        gaps = [
            vi.Gap(
                gap.direction,
                gap.opening + steps.get("opening", 0),
                gap.restitution + steps.get(f"restitution_{j}", 0),
            )
            for j, gap in enumerate(structure.gaps)
        ]
        other = vi.Structure(structure.mass, structure.damping, structure.stiffness, gaps)
        pushed = vi.Load(
            load.frequency + steps.get("frequency", 0),
            sine=load.sine * (1 + steps.get("load", 0)),
            constant=load.constant,
        )
        return vi.exact(other, pushed, motion)

    h, weights = 1e-4, np.array([-25, 48, -36, 16, -3])
    hit = int(motion.gaps[0])
    for name in names:
        # the first impact on this gap, at any position in the period
        parts = [moved(**{name: step * h}) for step in range(5)]
        first = [part.gaps.tolist().index(hit) for part in parts]
        for quantity in ("phases", "speeds", "q_dot"):
            values = [
                part.states[i, 1] if quantity == "q_dot" else getattr(part, quantity)[i]
                for part, i in zip(parts, first, strict=True)
            ]
            if quantity == "phases":
                values = np.unwrap(values)
            slope = np.tensordot(weights, np.array(values), 1) / (12 * h)
            size = np.abs(gradient[quantity]).max()
            found = gradient[quantity, name][0]
            assert found == pytest.approx(slope, rel=1e-5, abs=1e-6 * size), (name, quantity)


def test_shows_itself(pair):
    """The printed table, and the dataset."""
    gradient = pair[0].gradient()
    assert "q[1, 0]" in str(gradient)
    assert gradient.parameters[:2] == ("frequency", "load")
    assert gradient.to_xarray()["q_dot"].dims == ("impact", "coordinate", "parameter")


@pytest.mark.parametrize(
    ("damping", "kind"), [(0.05, "coupled gaps"), (0.0, None)], ids=["dashpots", "uncoupled"]
)
def test_impacts_at_one_instant(damping, kind):
    """Two simultaneous impacts have derivatives only if their order does not matter; dashpots may couple them."""
    joined = np.array([[3.0, -1.0], [-1.0, 3.0]])
    structure = vi.Structure(
        np.diag([2.0, 2.0]), damping * joined + np.diag([0.1, 0.1]), joined,
        [vi.Gap([1, 0], 0.5, 0.7), vi.Gap([0, 1], 0.5, 0.7)],
    )  # fmt: skip
    load = vi.Load(1.0, sine=[1, 1])
    run = vi.simulate(structure, load, cycles=2)
    motion = vi.exact(structure, load, ([1.6, 1.6], [0, 1], 1))
    assert motion.phases[1] == pytest.approx(motion.phases[0], abs=1e-12)
    if kind:
        assert kind in run.gradient().status["events[1:]"]
        with pytest.raises(vi.SingularError, match=kind):
            motion.gradient()
        return
    assert run.gradient().status == {}
    phases = motion.gradient()["phases", "opening_0"]
    moved = []
    # small, as second derivatives differ between the two orders and the error is O(h)
    for h in (-1e-6, 1e-6):
        gaps = [vi.Gap([1, 0], 0.5 + h, 0.7), structure.gaps[1]]
        other = vi.Structure(structure.mass, structure.damping, joined, gaps)
        order = [0, 1] if h < 0 else [1, 0]  # the narrower gap is hit first
        motion = vi.exact(other, load, ([1.6, 1.6], order, 1))
        moved.append(motion.phases[order])
    assert phases == pytest.approx((moved[1] - moved[0]) / 2e-6, rel=1e-5)


def test_a_touch_between_impacts():
    """A motion that touches a wall without an impact, and its trajectory, are refused by name."""
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    three = next(m for m in vi.find(osc, 1.0, 20.0, max_impacts=3) if m.pattern.sides == "RLL")
    gaps = np.where(three.pattern.signs > 0, 0, 1)
    load = vi.Load(1.0, sine=[1, 0])
    motion = vi.exact(osc.structure(20.0), load, (three.phases, gaps, 1))
    branch = vi.branch(motion, "opening", (2, 40))
    point = next(point for point in branch.special_points if point.type == "grazing")
    at = branch[point.index]
    hard = at.speeds > 1e-9
    assert hard.sum() == 2
    touching = vi.exact(at.structure, load, (at.phases[hard], at.gaps[hard], 1))
    assert touching.consistent
    assert touching.speeds.min() > 1
    for item in (at, touching):
        with pytest.raises(vi.SingularError, match="at such a graze"):
            item.gradient()
