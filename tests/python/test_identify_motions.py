"""Motions of an identification agree with those of the core, under load harmonics and up to a boundary too."""

from types import SimpleNamespace

import numpy as np
import pytest
import vibroimpact as vi

pytest.importorskip("scipy")
from shared_identify import BENCH, KNOWN
from vibroimpact.identification import tables
from vibroimpact.identification.fit import Fit
from vibroimpact.identification.signals import settling
from vibroimpact.identification.steps import Step


def fitted_laws():
    """Laws with the numbers of both walls."""
    from vibroimpact.identification.laws import Law

    knots = ((0.2, 0.5, 0.9), (0.1, 0.3, 0.8))
    return {
        "constant": (Law(), (0.75, 0.65)),
        "powers": (Law("powers", v0=0.4), (0.75, 0.1, 0.65, 0.15)),
        "knees": (Law("knees", v0=0.4), (0.75, 0.1, 0.3, 0.65, 0.15, 0.2)),
        "tables": (Law("tables", 3, 0.4, knots), (0.8, 0.76, 0.72, 0.7, 0.66, 0.62)),
    }


@pytest.mark.parametrize("kind", ["constant", "powers", "knees", "tables"])
@pytest.mark.parametrize("shaped", [False, True])
def test_motions_of_a_fit_are_those_of_the_core(kind, shaped):
    """Impacts agree with those of the core; derivatives with its own, or with differences of its motions."""
    from vibroimpact.identification.motions import PARAMETERS, System, verified
    from vibroimpact.identification.waves import Measured

    rig = vi.VirtualRig(**BENCH)
    run = vi.simulate(rig.oscillator, rig.r, rig.clearance, cycles=20, discard=400)
    near = vi.exact(rig.oscillator, rig.r, rig.clearance, run)
    Omega, later = 2 * np.pi * rig.frequency, 0.7
    orders, shape = np.array([1.0, 2.0, 3.0]), np.array([-1j, 0.02 + 0.03j, -0.01j])
    data = Measured(
        Omega, 1, near.phases - later, sides=near.pattern.sides, orders=orders,
        shape=shape * (orders == 1) if not shaped else shape,
    )  # fmt: skip
    law, numbers = fitted_laws()[kind]
    p = np.array([rig.omega, rig.xi, rig.m / rig.M, rig.d, rig.F0 / rig.K, later, *numbers])
    start = (data.angles, (near.X_dot_after - near.X_dot_before) * rig.omega * p[4])
    found = System(data, law).motion(p, *start)

    def core(p):
        """Angles and jumps agree with the core's Newton method, with a law that a structure accepts."""
        omega, xi, mu, d, static, phase, *of_walls = p
        names = law.of_wall(0) + law.of_wall(1)
        walls = law.restitution(dict(zip(names, of_walls, strict=True)), omega * static)
        osc = vi.Oscillator(xi=xi, mu=mu, restitution=walls if kind == "constant" else 0.7)
        motion = verified(
            osc,
            Omega / omega,
            d / static,
            found.angles + phase,
            near.pattern,
            walls,
            data.shape[1:],
        )
        jumps, angles = motion.impulses * near.pattern.signs, motion.phases - phase
        turn = 2 * np.pi * np.round((angles - found.angles) / (2 * np.pi))
        return np.array([angles - turn, jumps * omega * static])

    assert np.array([found.angles, found.jumps]) == pytest.approx(core(p), abs=1e-9)
    for i, name in enumerate((*PARAMETERS, *law.of_wall(0), *law.of_wall(1))):
        h = 3e-6 * abs(p[i]) * np.eye(p.size)[i]
        differences = (core(p + h) - core(p - h)) / (2 * h[i])
        # the load phase shifts all angles and changes no jump
        size = np.maximum(np.abs(differences).max(axis=1, keepdims=True), 1e-3)
        assert found.by[..., i] / size == pytest.approx(differences / size, abs=2e-5), name


@pytest.mark.parametrize("harmonics", [(0.1,), (0.02, 0.1)])
def test_harmonics_of_the_load_move_the_impacts(harmonics, tmp_path):
    """With a load that is not a sine the parameters are found too, for the motion under this load."""
    found = vi.identify(vi.VirtualRig(**BENCH, harmonics=harmonics).record(rng=1), known=KNOWN)
    for name, value in (("xi", 0.01143), ("R1", 0.75), ("R2", 0.65), ("d", 0.006), ("F0", 6.0)):
        assert abs(found.values[name] - value) < 4 * found.errors[name], name
    assert found.misfit < 1.5
    found.save(tmp_path / "found.json")
    for item in (found, vi.load(tmp_path / "found.json")):
        assert item.motion.of_structure
        assert item.motion.stable
        turns = (item.motion.phases - item._of(0, "impacts", "fitted")) / (2 * np.pi)
        assert turns == pytest.approx(np.round(turns), abs=1e-9)
        assert item.motion.load.sine[1:, 0] == pytest.approx(
            [*harmonics, *np.zeros(11 - len(harmonics))], abs=1e-3
        )


def test_a_boundary_is_where_the_motion_is_lost():
    """Beyond the nearest boundary the motion is not stable and admissible; before the boundary it is."""
    found = vi.identify(vi.VirtualRig(**BENCH).record(rng=1), known=KNOWN)
    nearest = found.nearest_boundary()
    here = {"r": found.r, "clearance": found.clearance}
    good = []
    for factor in (0.9, 1.1):
        point = dict(here)
        start = here[nearest.parameter]
        point[nearest.parameter] = start + factor * (nearest.value - start)
        motion = vi.exact(found.oscillator, point["r"], point["clearance"], found.motion)
        good.append(bool(motion.stable and motion.admissible))
    assert good == [True, False]
    assert nearest.distance == pytest.approx(abs(nearest.value / here[nearest.parameter] - 1))


@pytest.mark.slow
def test_a_motion_that_settles_is_named_as_such():
    """Just beyond a period doubling at a clearance of 39.35, 60 load cycles are too few: the motion of the record
    is no exact one, and the doubt says why. The errors, which grow with the misfit, contain it. After 1000 cycles
    the same rig gives a good fit; a rig that changes steadily does not look as if it settled."""
    rig = vi.VirtualRig(**BENCH | {"d": 39.1 * 6 / 42e3}, snr=30, known_bandwidth=True)
    with pytest.warns(vi.PoorFitWarning, match="had probably not settled"):
        early = vi.identify(rig.record(3.0, rng=2, settle=60), known=KNOWN)
    assert any("identify its last part" in doubt for doubt in early.doubts)
    late = vi.identify(rig.record(3.0, rng=2, settle=1000), known=KNOWN)
    assert late.good
    assert late.pattern == vi.Pattern("RLLRLL", 2)
    of_rig = {"xi": rig.xi, "R1": 0.75, "R2": 0.65, "d": rig.d}
    for found in (early, late):
        for name, value in of_rig.items():
            assert abs(found.values[name] - value) < 3 * found.errors[name], name
    record = rig.record(3.0, rng=2, settle=60)
    assert settling(record.acceleration, record.rate, 2 * np.pi * 19.5, 2) > 1.5 * tables.SETTLES
    drifting = vi.VirtualRig(**BENCH, drift=0.09, known_bandwidth=True).record(3.0, rng=1)
    assert (
        settling(drifting.acceleration, drifting.rate, 2 * np.pi * 19.5, 1) < tables.SETTLES / 1.3
    )


@pytest.mark.parametrize(("clearance", "seed"), [(39.35, 1), (39.45, 1)])
def test_a_motion_near_a_period_doubling_may_seem_unstable(clearance, seed, monkeypatch):
    """Within the errors of the parameters the motion may be on the other side, where it exists, too: this is no
    doubt. Without the error of the multiplier it is."""
    rig = vi.VirtualRig(**BENCH | {"d": clearance * 6 / 42e3}, snr=30, known_bandwidth=True)
    record = rig.record(3.0, rng=seed, settle=3000)
    found = vi.identify(record, known=KNOWN)
    assert found.good
    assert abs(found.multipliers).max() > 1.05
    for name, value in {"xi": rig.xi, "R1": 0.75, "R2": 0.65, "d": rig.d}.items():
        assert abs(found.values[name] - value) < 2 * found.errors[name], name
    monkeypatch.setattr(tables, "UNSURE", 0.0)
    with pytest.warns(vi.PoorFitWarning, match="the motion is unstable"):
        vi.identify(record, known=KNOWN)


def followed(multipliers, phases=(1.0, 4.0)):
    """A motion with the given multipliers and load phases of the impacts."""
    return SimpleNamespace(multipliers=np.array(multipliers), phases=np.array(phases))


def test_a_period_doubling_has_a_negative_multiplier_or_its_square():
    """A motion remains near beyond a bifurcation with a negative or complex multiplier. A positive one above 1
    must be the square of a negative one: of a motion followed for two load cycles, with equal halves."""
    half = followed([0.2, -1.05])
    twice = np.array([1.0, 4.0, 1.0 + 2 * np.pi, 4.0 + 2 * np.pi])

    def remains(multipliers, sides, cycles, phases, half=half):
        def one():
            if half is None:
                raise vi.SingularError("there is no such motion")
            return half

        return tables.remains(followed(multipliers, phases), vi.Pattern(sides, cycles), one)

    assert remains([0.2, -1.1], "RL", 1, twice[:2])
    assert remains([0.9 + 0.6j, 0.9 - 0.6j], "RL", 1, twice[:2])
    assert remains([0.04, 1.1], "RLRL", 2, twice)
    # folds or pitchforks: of one load cycle, of different halves or walls, of a half with a positive multiplier
    assert not remains([0.2, 1.1], "RL", 1, twice[:2])
    assert not remains([0.2, 1.1], "RLRL", 1, [1.0, 2.0, 4.0, 5.0])
    assert not remains([0.2, 1.1], "RLRL", 2, twice * (1 + 1e-4))
    assert not remains([0.2, 1.1], "RLLR", 2, twice)
    assert not remains([0.2, 1.1], "RLR", 2, twice[:3])
    assert not remains([0.04, 1.1], "RLRL", 2, twice, followed([0.2, 1.05]))
    assert not remains([0.04, 1.1], "RLRL", 2, twice, followed([np.nan, np.nan]))
    assert not remains([0.04, 1.1], "RLRL", 2, twice, None)


def test_restitution_that_falls_with_the_speed_changes_a_multiplier(monkeypatch):
    """In proportion to a small exponent, since the motion with one speed on each wall stays the same; with the
    exponent of the errors the motion is more stable."""
    given, change = [], tables.multiplier_of_speed
    rig = vi.VirtualRig(**BENCH | {"d": 0.0036, "frequency": 20.6}, snr=60, known_bandwidth=True)
    monkeypatch.setattr(tables, "UNSTABLE", 0.0)
    monkeypatch.setattr(tables, "remains", lambda *_: True)
    monkeypatch.setattr(tables, "multiplier_of_speed", lambda *of: given.append(of) or change(*of))
    found = vi.identify(rig.record(3.0, rng=1), known=KNOWN)
    assert found.pattern.sides == "RL"
    by = {}
    for exponent in (1e-4, 2e-4, 0.25):
        monkeypatch.setattr(tables, "TYPICAL_EXPONENT", exponent)
        by[exponent] = change(*given[-1])
    assert by[2e-4] == pytest.approx(2 * by[1e-4], rel=0.01)
    assert by[0.25] > 100 * by[1e-4]


@pytest.mark.parametrize("other", ["exists", "has no multipliers", "does not exist"])
def test_the_error_of_a_multiplier(other, monkeypatch):
    """The standard error of the largest multiplier follows from those of the parameters, with their correlation.
    It is 0, which leaves the doubt, if a motion nearby does not exist or has no multipliers."""
    slopes, errors = np.array([3.0, -50.0]), np.array([0.02, 0.001])
    covariance = np.outer(errors, errors) * [[1, 0.6], [0.6, 1]]

    def exact_of(step, near, i, law, harmonics):
        change = slopes @ [near.values["R1"] - 0.75, near.lengths[0] - 1e-3]
        if change < 0 and other == "does not exist":
            raise vi.SingularError("there is no such motion")
        if change < 0 and other == "has no multipliers":
            return followed([np.nan, np.nan])
        return followed([0.2, -1.1 - change])

    found = Fit({"R1": 0.75}, [1e-3], [0.0], [], ["R1", "F0/K 0"], covariance, [], [1.0])
    monkeypatch.setattr(tables, "exact_of", exact_of)
    error = tables.multiplier_error(None, found, 0, None, None)
    expected = (slopes @ covariance @ slopes) ** 0.5 if other == "exists" else 0.0
    assert error == pytest.approx(expected, rel=1e-9, abs=0)


@pytest.mark.parametrize(
    ("multiplier", "unsure", "doubted"),
    [(-1.04, 0.0, False), (-1.1, 0.0, True), (-1.1, 0.06, False), (-1.1, 0.04, True), (-3.0, 2.0, True)],
)  # fmt: skip
def test_a_multiplier_far_from_the_unit_circle_is_doubted(multiplier, unsure, doubted):
    """Within two of its standard errors a multiplier may be on the unit circle; a linear error tells nothing far
    from it."""
    found = Fit({}, [1e-3], [0.0], [], [], np.zeros((0, 0)), [], [1.0])
    step = Step(None, "acceleration")
    doubts = tables.doubts_of(0, step, found, np.zeros(1), {}, [0.2, multiplier], unsure)
    assert any("the motion is unstable" in text for text in doubts) == doubted
