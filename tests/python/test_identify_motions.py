"""Motions of an identification agree with those of the core, under load harmonics and up to a boundary too."""

import numpy as np
import pytest
import vibroimpact as vi

pytest.importorskip("scipy")
from shared_identify import BENCH, KNOWN


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
    from vibroimpact.identification.flights import Measured
    from vibroimpact.identification.motions import PARAMETERS, System, verified

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
