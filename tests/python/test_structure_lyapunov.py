"""Lyapunov exponents of structures: multipliers, volume, the oscillator, divergence of neighbours."""

from pathlib import Path

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact import _core
from vibroimpact.base.interrupt import new_counters
from vibroimpact.results.tables import from_core

INPUT = Path(__file__).parents[2] / "inputs" / "structure_lyapunov.nml"
WALL = vi.Structure([1], [0.1], [1], [vi.Gap([1], 1, 0.8)])


def pair(clearance, walls=(0.75, 0.75), mu=0.028, xi=0.0114):
    """The oscillator of the 1983 paper as the matrices of its two masses."""
    gaps = [vi.Gap([-1, 1], clearance / 2, walls[0]), vi.Gap([1, -1], clearance / 2, walls[1])]
    return vi.Structure([1, mu], [2 * xi, 0], [1, 0], gaps)


def two_hosts(frequency=0.8):
    """Two hosts with damping that couples their modes, and a particle whose restitution depends on the speed."""
    law = vi.PowerLaw(0.9, 0.5, 0.3)
    gaps = [vi.Gap([-1, 0, 1], 0.6, law), vi.Gap([1, 0, -1], 0.6, 0.7), vi.Gap([0, 1, 0], 0.9, 0.8)]
    damping = [[0.2, -0.15, 0], [-0.15, 0.18, 0], [0, 0, 0.0]]
    stiffness = [[2.0, -1.0, 0], [-1.0, 1.5, 0], [0, 0, 0]]
    return vi.Structure([1, 0.7, 0.1], damping, stiffness, gaps), vi.Load(
        frequency, sine=[0.8, 0, 0]
    )


def sine(frequency):
    return vi.Load(frequency, sine=[1, 0])


@pytest.mark.parametrize(
    ("structure", "load"),
    [(WALL, vi.Load(1.0, cosine=[1])), (pair(14), sine(1.04)), two_hosts()],
)
def test_of_periodic_motions_they_are_those_of_the_multipliers(structure, load):
    motion = vi.exact(structure, load, vi.simulate(structure, load, cycles=400))
    assert motion.stable
    assert not len(motion.rests)
    start = motion.phases[0] / load.frequency
    state = (motion.q, motion.q_dot)
    found = vi.lyapunov(structure, load, cycles=10_000, state=state, start=start)
    expected = np.log(np.abs(motion.multipliers)) / motion.cycles
    np.testing.assert_allclose(found.per_cycle, expected, atol=1e-6)
    np.testing.assert_allclose(
        found.per_cycle.sum(), np.log(abs(motion.law)) / motion.cycles, rtol=1e-9
    )
    assert 0 <= found.identity_error < 1e-12


def test_the_two_masses_of_1983_have_the_exponents_of_the_oscillator():
    """Exponents agree with the oscillator's: to rounding in periodic motion, within both errors in chaos."""
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    own = vi.lyapunov(osc, 1.04, 14.0)
    found = vi.lyapunov(pair(14), sine(1.04), cycles=10_000)
    np.testing.assert_allclose(found.per_cycle, own.per_cycle, atol=1e-6)
    state = ([0, 0], [6, 9])
    start = {"t": 0, "x": 0, "x_dot": 6, "z": 0, "z_dot": 9}
    own = vi.lyapunov(osc, 1.04, 5.0, cycles=4000, state=start)
    found = vi.lyapunov(pair(5), sine(1.04), cycles=4000, state=state)
    assert found.largest > 3 * found.standard_error[0]
    error = np.hypot(found.standard_error, own.standard_error)
    assert (np.abs(found.exponents - own.exponents) < 5 * error).all()
    assert 0 <= found.identity_error < 1e-12


def test_in_chaos_the_volume_shrinks_as_damping_and_impacts_say():
    found = vi.lyapunov(*two_hosts(1.1), cycles=1000)
    assert found.largest > 3 * found.standard_error[0]
    assert 0 <= found.identity_error < 1e-12
    assert 1 < found.dimension < 6


def test_the_largest_is_the_rate_at_which_neighbours_part():
    """The largest exponent is the rate at which two simulations diverge, rescaled after every cycle."""
    structure, load = pair(5), sine(1.04)
    found = vi.lyapunov(structure, load, cycles=1500, state=([0, 0], [6, 9]), directions=1)
    apart, growth, n = 1e-8, [], 600
    q, rate = vi.simulate(structure, load, cycles=300, state=([0, 0], [6, 9])).final_state
    near = np.concatenate([q, rate]) + apart * np.array([1, 0, 0, 0])
    for cycle in range(n):
        start = cycle * 2 * np.pi / load.frequency
        ends = [
            np.concatenate(
                vi.simulate(structure, load, cycles=1, state=state, start=start).final_state
            )
            for state in ((q, rate), (near[:2], near[2:]))
        ]
        change = ends[1] - ends[0]
        growth.append(np.log(np.linalg.norm(change) / apart))
        q, rate = ends[0][:2], ends[0][2:]
        near = ends[0] + change * (apart / np.linalg.norm(change))
    batches = np.mean(np.reshape(growth[100:], (10, -1)), axis=1)
    error = np.hypot(batches.std(ddof=1) / np.sqrt(10), found.error_per_cycle[0])
    assert abs(batches.mean() - found.per_cycle[0]) < 4 * error


def test_a_rest_extinguishes_two_directions():
    structure, load = pair(6, (0.75, 0.61)), sine(0.9)
    motion = vi.exact(structure, load, vi.simulate(structure, load, cycles=200))
    assert len(motion.rests)
    found = vi.lyapunov(structure, load, cycles=400)
    np.testing.assert_allclose(found.per_cycle[:2], np.log(abs(motion.multipliers[:2])), atol=1e-6)
    assert np.isneginf(found.per_cycle[2:]).all()
    assert found.rests == 400 // motion.cycles
    assert np.isnan(found.identity_error)


def test_a_rest_of_the_transient_extinguishes_no_direction_of_the_attractor():
    structure = vi.Structure([1], [0.1], [1], [vi.Gap([1], 0.0, 0.8)])
    of_flight, of_rest = (
        vi.lyapunov(structure, vi.Load(2.0, cosine=[1]), cycles=400, discard=100, state=([q], [0]))
        for q in (-0.1, 0)
    )
    assert np.isfinite(of_flight.exponents).all()
    np.testing.assert_allclose(sum(of_rest.exponents), sum(of_flight.exponents), rtol=1e-9)
    # the multipliers are a complex pair with rotating directions, whose angles at the end of the average differ
    np.testing.assert_allclose(of_rest.exponents, of_flight.exponents, rtol=1e-3)


def test_the_greatest_is_first_however_short_the_average():
    """Equal exponents are swapped within the error of a short average; their errors are swapped with them."""
    load = vi.Load(1.0, cosine=[1])
    found = vi.lyapunov(WALL, load, cycles=40, batches=4)
    assert (np.diff(found.exponents) <= 0).all()
    assert found.identity_error < 1e-12
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    found = vi.lyapunov(osc, 1.04, np.linspace(6, 16, 8), cycles=40, batches=4)
    assert np.isfinite(found.per_cycle).all()
    assert (np.diff(found.per_cycle, axis=0) <= 0).all()


def test_rest_for_ever_and_a_wall_without_rebound():
    ball = vi.Structure([1], [0], [0], [vi.Gap([-1], 0.0, 0.5)])
    gravity = vi.Load(constant=[-1])
    found = vi.lyapunov(ball, gravity, cycles=100, state=([1], [0]), discard=10)
    assert np.isneginf(found.exponents).all()
    dead = vi.Structure([1], [0.1], [1], [vi.Gap([1], 1, 0.0)])
    found = vi.lyapunov(dead, vi.Load(1.0, cosine=[1]))
    assert np.isfinite(found.exponents[0])
    assert np.isneginf(found.exponents[1])


def test_without_impacts_they_are_the_damping_of_the_modes():
    structure = vi.Structure.from_modes([1.0, 3.0], [0.02, 0.01], np.eye(2), [vi.Gap([1, 0], 1e6)])
    found = vi.lyapunov(structure, sine(0.7), cycles=4000, discard=0)
    np.testing.assert_allclose(found.exponents, [-0.02, -0.02, -0.03, -0.03], atol=1e-5)
    assert found.impacts == 0


def test_without_damping_they_are_in_pairs_of_opposite_sign():
    """Without damping exponents come in pairs of opposite sign; in free motion one pair is zero."""
    gaps = [vi.Gap([-1, 1], 1.0), vi.Gap([1, -1], 1.0)]
    cell = vi.Structure([1, 0.3], [0, 0], [1, 0], gaps)
    found = vi.lyapunov(cell, cycles=20_000, state=([0, 0], [0, -1]))
    np.testing.assert_allclose(found.exponents + found.exponents[::-1], 0, atol=1e-10)
    assert found.exponents[0] > 10 * found.standard_error[0]
    assert abs(found.exponents[1]) < 1e-3
    assert 0 <= found.identity_error < 1e-12
    assert abs(found.dimension - 4) < 1e-6
    # a ball between two walls: regular motion
    between = vi.Structure([1], [0], [0], [vi.Gap([1], 1.0), vi.Gap([-1], 1.0)])
    found = vi.lyapunov(between, cycles=20_000, state=([0], [1]))
    assert np.abs(found.exponents).max() < 1e-3


def test_fewer_directions_are_the_first_ones():
    structure, load = two_hosts()
    whole = vi.lyapunov(structure, load, cycles=200)
    part = vi.lyapunov(structure, load, cycles=200, directions=2)
    np.testing.assert_allclose(part.exponents[0], whole.exponents[0], rtol=1e-9)
    # the second and the third are equal: the greater one depends on the rotation of their directions
    assert whole.exponents[1] - whole.exponents[2] < whole.standard_error[1]
    assert abs(part.exponents[1] - whole.exponents[1]) < whole.standard_error[1]
    assert np.isnan(part.dimension)
    assert np.isnan(part.identity_error)


@pytest.mark.parametrize("extension", ["json", "nc", "mat"])
def test_files_and_namelists_give_it_back(extension, tmp_path):
    found = vi.lyapunov(*two_hosts(), cycles=60, discard=5)
    path = tmp_path / f"found.{extension}"
    found.save(path)
    again = vi.load(path)
    np.testing.assert_array_equal(again.exponents, found.exponents)
    assert repr(again) == repr(found)
    assert again.dimension == found.dimension
    namelist = tmp_path / "case.nml"
    namelist.write_text(found.to_namelist())
    (case,) = vi.read_namelist(namelist)
    (again,) = case.run()
    np.testing.assert_array_equal(again.exponents, found.exponents)
    assert again.structure.gaps[0].restitution == found.structure.gaps[0].restitution


def test_inputs_run(tmp_path):
    log = vi.run_namelists([INPUT], tmp_path)
    assert log.status == 0, log
    assert len(list(tmp_path.glob("*.csv"))) == 3


def test_picture():
    pytest.importorskip("matplotlib")
    found = vi.lyapunov(pair(6, (0.75, 0.61)), sine(0.9), cycles=60)
    ax = found.plot()
    assert ax.get_ylabel() == "exponent per load cycle"
    assert "-\\infty" in ax.texts[0].get_text()
    assert "Lyapunov" in found._repr_html_()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"cycles": 30}, "cycles = 30: must be a whole number, 2 batches <= cycles <= 1e9; batches is 20"),
        ({"directions": 3}, "directions = 3: must be a whole number, 1 <= directions <= 2n"),
        ({"state": ([1, 2], [0])}, "state"),
        ({"max_events": 0}, "max_events = 0: must be a whole number with 1 <="),
        ({"load": vi.Load(1.0, cosine=[1, 0])}, "load for 2 coordinates: must be for 1"),
    ],
)  # fmt: skip
def test_errors_name_the_parameter(options, message):
    with pytest.raises(vi.ParameterError) as caught:
        vi.lyapunov(WALL, **{"load": vi.Load(1.0, cosine=[1]), **options})
    assert str(caught.value).startswith(message)


def test_a_record_and_a_structure_without_gaps_are_refused():
    with pytest.raises(vi.ParameterTypeError, match=r"^load"):
        vi.lyapunov(WALL, vi.Record(0.1, np.zeros((10, 1))))
    with pytest.raises(vi.ParameterError, match="at least one &gap, &stop or &friction"):
        vi.lyapunov(vi.Structure([1], [0.1], [1]), vi.Load(1.0, cosine=[1]))


def test_what_fails_says_so():
    with pytest.raises(vi.SingularError, match="max_events"):
        vi.lyapunov(WALL, vi.Load(1.0, cosine=[1]), max_events=100)
    gaps = [vi.Gap([1, 0], 1.0), vi.Gap([1, -1], 1.0)]  # both gaps close at once
    coupled = vi.Structure([1, 1], [0, 0], [0, 0], gaps)
    with pytest.raises(vi.SingularError, match="coupled"):
        vi.lyapunov(coupled, cycles=100, state=([0, 0], [1, 0]), discard=10)


def test_it_stops_when_asked():
    """A stop flag set before the start leaves a result without points."""
    counters = new_counters()
    counters[2] = 1
    text = vi.lyapunov(WALL, vi.Load(1.0, cosine=[1]), cycles=40).to_namelist()
    handle, _ = _core.run_case(np.frombuffer(text.encode(), "S1"), 1, counters)
    assert from_core("lyapunov", handle).cut
