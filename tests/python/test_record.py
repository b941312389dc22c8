"""Structures under sampled forces and base motions, compared with closed forms and matrix exponentials."""

import math

import numpy as np
import pytest
import vibroimpact as vi
from shared_structures import exponential


def frame(gaps=True, coupling=False):
    """Three storeys, and a free mass in a slot of the top one."""
    stiffness = np.zeros((4, 4))
    for i in range(3):
        part = np.zeros(4)
        part[i] = 1
        if i:
            part[i - 1] = -1
        stiffness += 4 * np.outer(part, part)
    damping = 0.02 * stiffness
    if coupling:
        damping[0, 0] += 0.1
    slots = []
    if gaps:
        slots = [vi.Gap([0, 0, -1, 1], 0.3, 0.95), vi.Gap([0, 0, 1, -1], 0.3, 0.9)]
    return vi.Structure([1, 1, 1, 0.2], damping, stiffness, slots)


def flight(structure, force, rate, state, t):
    """The state after a time under the force f + rate t, by the matrix exponential."""
    n = structure.coordinates
    inverse = np.linalg.inv(structure.mass)
    a = np.zeros((2 * n + 2, 2 * n + 2))
    a[:n, n : 2 * n] = np.eye(n)
    a[n : 2 * n, :n] = -inverse @ structure.stiffness
    a[n : 2 * n, n : 2 * n] = -inverse @ structure.damping
    a[n : 2 * n, 2 * n] = inverse @ force
    a[n : 2 * n, 2 * n + 1] = inverse @ rate
    a[2 * n, 2 * n] = 0
    a[2 * n + 1, 2 * n] = 0
    full = np.concatenate([*state, [1.0, 0.0]])
    a[2 * n + 1, 2 * n] = 1.0
    found = exponential(a * t) @ full
    return found[:n], found[n : 2 * n]


def force_at(record, t):
    """The force and its rate just after a time."""
    i = math.floor(t / record.step + 1e-9)
    if i >= len(record.force) - 1:
        return record.constant, 0 * record.constant, math.inf
    rate = (record.force[i + 1] - record.force[i]) / record.step
    return (
        record.constant + record.force[i] + (t - i * record.step) * rate, rate, (i + 1) * record.step
    )  # fmt: skip


def check(run, tolerance=1e-9):
    """Check every flight between samples by the matrix exponential, every impact by its law, and all gaps."""
    s, record = run.structure, run.load
    t, state = run.start, [np.array(part) for part in run.initial_state]
    marks = [(e["time"], e, after) for e, after in zip(run.events, run.states, strict=True)]
    if not marks or run.complete:
        marks.append((run.end, None, run.final_state))
    for time, event, after in marks:
        if event is not None and event["kind"] != "impact":
            return
        while t < time:
            force, rate, end = force_at(record, t)
            until = min(end, time)
            if until > t:
                state = flight(s, force, rate, state, until - t)
            t = until
            for gap in s.gaps:
                assert gap.opening - gap.direction @ state[0] > -tolerance
        assert np.abs(after[0] - state[0]).max() < tolerance
        if event is None:
            assert np.abs(after[1] - state[1]).max() < tolerance
            continue
        gap = s.gaps[event["gap"]]
        assert abs(gap.opening - gap.direction @ state[0]) < tolerance
        speed = gap.direction @ state[1]
        kick = np.linalg.solve(s.mass, gap.direction)
        jump = (1 + gap.restitution) * speed / (gap.direction @ kick) * kick
        assert abs(speed - event["speed"]) < tolerance
        assert np.abs(after[1] - state[1] + jump).max() < tolerance
        state = [np.array(part) for part in after]


def noise(samples, n, seed=1):
    rng = np.random.default_rng(seed)
    return rng.normal(size=(samples, n))


@pytest.mark.parametrize("coupling", [False, True])
@pytest.mark.parametrize("step", [0.02, 0.3, 2.0])
def test_flights_and_impacts(step, coupling):
    """Flights and impacts obey their laws for steps below, near and above the shortest time scale."""
    record = vi.Record(step, 2 * noise(int(12 / step), 4), constant=[0.1, 0, 0, 0.05])
    run = vi.simulate(frame(coupling=coupling), record, duration=15.0)
    assert (run.events["kind"] == "impact").sum() > 5
    check(run)


def test_samples():
    record = vi.Record(0.07, 2 * noise(100, 4))
    run = vi.simulate(frame(), record)
    assert run.end == record.duration
    assert set(run.events["kind"]) == {"impact"}
    t = np.sort(np.random.default_rng(2).uniform(0, run.end, 400))
    q, rate = run.sample(t)
    for i in range(0, 400, 7):
        part = vi.simulate(frame(), record, duration=t[i])
        assert q[:, i] == pytest.approx(part.final_state[0], abs=1e-11)
        assert rate[:, i] == pytest.approx(part.final_state[1], abs=1e-11)
    # the order of the times does not matter
    back = run.sample(t[::-1])
    assert back[0][:, ::-1].tobytes() == q.tobytes()


@pytest.mark.parametrize("restitution", [0.5, 0.3])
def test_a_constant_record_is_a_constant_load(restitution):
    """A constant record gives the events of a constant load: a ball on a spring-supported table under gravity."""
    gaps = [vi.Gap([1, -1], 0.0, restitution)]
    s = vi.Structure([1.0, 0.2], [0.1, 0], [20.0, 0], gaps)
    weight = np.array([-1.0, -0.2])
    state = ([0, 1.0], [0, 0])
    known = vi.simulate(s, vi.Load(1.0, constant=weight), duration=10, state=state)
    assert "stick" in known.events["kind"]
    for step in (0.013, 0.1, 1.0):
        samples = int(10 / step) + 2
        for record in (
            vi.Record(step, np.tile(weight, (samples, 1))),
            vi.Record(step, np.zeros((2, 2)), constant=weight),
        ):
            run = vi.simulate(s, record, duration=10, state=state)
            pick = known.events["speed"] > 1e-4
            mine = run.events[run.events["speed"] > 1e-4]
            assert mine["time"] == pytest.approx(known.events["time"][pick], abs=1e-12)
            assert mine["speed"] == pytest.approx(known.events["speed"][pick], abs=1e-11)
            for kind in ("stick", "release"):
                times = run.events["time"][run.events["kind"] == kind]
                assert times == pytest.approx(
                    known.events["time"][known.events["kind"] == kind], abs=1e-10
                )
            assert np.concatenate(run.final_state) == pytest.approx(
                np.concatenate(known.final_state), abs=1e-10
            )


def test_release_from_rest_by_a_record():
    """A block on the ground, pulled up by a growing force, is released when the force exceeds its weight."""
    s = vi.Structure([2.0], [0.0], [0.0], [vi.Gap([-1.0], 0.0, 0.5)])
    force = np.linspace(0.0, 4.0, 11)[:, None]
    run = vi.simulate(s, vi.Record(0.3, force, constant=[-2.5]), duration=3.0)
    # 4 t/3 = 2.5; then x'' = (4/3) (t - t0)/2
    release = 2.5 / (4 / 3)
    assert run.events["kind"].tolist() == ["release"]
    assert run.events["time"][0] == pytest.approx(release, abs=1e-13)
    assert run.final_state[0][0] == pytest.approx((4 / 3) / 2 * (3 - release) ** 3 / 6, abs=1e-13)


def test_a_sampled_sine_converges_with_the_square_of_the_step():
    s = frame()
    load = vi.Load(1.3, sine=[1.5, 0, 0, 0])
    known = vi.simulate(s, load, duration=9.0)
    assert len(known.events) > 3
    errors = []
    for i in range(5):
        step = 0.1 / 2**i
        t = step * np.arange(int(9.0 / step) + 2)
        record = vi.Record(step, 1.5 * np.outer(np.sin(1.3 * t), [1, 0, 0, 0]))
        run = vi.simulate(s, record, duration=9.0)
        assert run.events["gap"].tolist() == known.events["gap"].tolist()
        errors.append(np.abs(run.events["time"] - known.events["time"]).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders == pytest.approx(2.0, abs=0.1)


def test_the_start_may_lie_within_the_record():
    record = vi.Record(0.11, 2 * noise(150, 4))
    whole = vi.simulate(frame(), record, duration=15.0)
    first = vi.simulate(frame(), record, duration=6.02)
    rest = vi.simulate(frame(), record, start=6.02, duration=15.0 - 6.02, state=first.final_state)
    later = whole.events["time"] > 6.02
    assert rest.events["time"] == pytest.approx(whole.events["time"][later], abs=1e-9)


def test_many_intervals():
    """A record of 10^5 samples gives the result of its parts, and without a gap that of matrix exponentials."""
    s = frame(gaps=False)
    record = vi.Record(0.01, noise(20_000, 4))
    run = vi.simulate(s, record)
    n, inverse = 4, np.linalg.inv(s.mass)
    a = np.zeros((16, 16))
    a[:n, n : 2 * n] = np.eye(n)
    a[n : 2 * n, :n] = -inverse @ s.stiffness
    a[n : 2 * n, n : 2 * n] = -inverse @ s.damping
    a[n : 2 * n, 2 * n : 3 * n] = inverse
    a[2 * n : 3 * n, 3 * n :] = np.eye(n)
    step = exponential(a * record.step)[: 2 * n]
    state = np.zeros(2 * n)
    for i in range(len(record.force) - 1):
        rate = (record.force[i + 1] - record.force[i]) / record.step
        state = step @ np.concatenate([state, record.force[i], rate])
    assert np.concatenate(run.final_state) == pytest.approx(state, abs=1e-8)


def base(seed=4):
    """A structure whose first body is connected to the base; a free mass in a slot."""
    stiffness = [[5.0, -2, 0], [-2, 2, 0], [0, 0, 0]]
    damping = [[0.3, -0.1, 0], [-0.1, 0.1, 0], [0, 0, 0]]
    gaps = [vi.Gap([0, -1, 1], 0.2, 0.7), vi.Gap([0, 1, -1], 0.2, 0.7)]
    return vi.Structure([1.0, 0.8, 0.2], damping, stiffness, gaps)


def test_a_periodic_base_motion_gives_equal_gaps_in_both_coordinates():
    s, omega = base(), 1.1
    sine, cosine = [0.3, 0.05], [0.1]
    absolute = vi.base_motion(s, omega, sine, cosine)
    relative = vi.base_motion(s, omega, sine, cosine, relative=True)
    # at t = 0: y and y'
    y, rate = cosine[0], omega * (sine[0] + 2 * sine[1])
    run = vi.simulate(s, absolute, cycles=5, state=([y] * 3, [rate] * 3))
    same = vi.simulate(s, relative, cycles=5)
    assert len(run.events) > 10
    assert set(run.events["kind"]) == {"impact"}
    assert run.events["time"] == pytest.approx(same.events["time"], abs=1e-9)
    assert run.events["speed"] == pytest.approx(same.events["speed"], abs=1e-8)
    t = np.linspace(0, run.end, 200)
    gaps = [1, -1] @ run.sample(t)[0][1:]
    assert gaps == pytest.approx([1, -1] @ same.sample(t)[0][1:], abs=1e-8)


def test_a_recorded_base_motion_gives_equal_gaps_in_both_coordinates():
    """y'' is linear between samples in both coordinates; y, a cubic there, is linear between samples to h^2."""
    s = base()
    first, errors = None, []
    for step in (0.02, 0.01, 0.005):
        t = step * np.arange(int(8 / step) + 1)
        y = 0.05 * t**2 * np.sin(2 * t)
        v = 0.1 * t * np.sin(2 * t) + 0.1 * t**2 * np.cos(2 * t)
        a = 0.1 * np.sin(2 * t) + 0.4 * t * np.cos(2 * t) - 0.2 * t**2 * np.sin(2 * t)
        one = vi.simulate(s, vi.base_record(s, step, a))
        two = vi.simulate(s, vi.base_record(s, step, displacement=y, velocity=v))
        assert one.events["gap"].tolist() == two.events["gap"].tolist()
        first = first or len(one.events)
        errors.append(np.abs(one.events["time"] - two.events["time"])[:5].max())
    assert first > 5
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2, abs=0.3)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(2, abs=0.3)


def test_base_motion_of_one_mass_in_closed_form():
    """For a mass on a spring and a damper F0 = K Y sqrt(1 + (2 xi r)^2), and the phase lead is atan(2 xi r)."""
    xi, r, size = 0.1, 1.3, 0.4
    s = vi.Structure([1.0], [2 * xi], [1.0])
    load = vi.base_motion(s, r, sine=size)
    assert math.hypot(load.sine[0, 0], load.cosine[0, 0]) == pytest.approx(
        size * math.sqrt(1 + (2 * xi * r) ** 2), rel=1e-14
    )
    lead = math.atan2(load.cosine[0, 0], load.sine[0, 0])
    assert lead == pytest.approx(math.atan(2 * xi * r), rel=1e-14)


@pytest.mark.parametrize(("make", "message"), [
    (lambda: vi.Record(0, [[1], [1]]), "step = 0.0: must be a finite number > 0"),
    (lambda: vi.Record(0.1, [1, 1]), "force of shape (2,): must be samples (samples, n)"),
    (lambda: vi.Record(0.1, [[1]]), "force of shape (1, 1): must be samples"),
    (lambda: vi.Record(0.1, [[1], [math.nan]]), "force: must be samples (samples, n), at least two, all of them"),
    (lambda: vi.Record(0.1, [[1], [2]], constant=[1, 2]), "constant of shape (2,)"),
    (lambda: vi.simulate(frame(), vi.Record(0.1, [[1], [2]])), "load for 1 coordinate: must be for 4"),
    (lambda: vi.simulate(frame(), vi.Record(0.1, [[1] * 4] * 2), cycles=2), "give duration without"),
    (lambda: vi.base_record(base(), 0.1), "given: []"),
    (lambda: vi.base_record(base(), 0.1, [1, 2], velocity=[1, 2]), "must be acceleration alone, or"),
    (lambda: vi.base_record(base(), 0.1, displacement=[1, 2, 3], velocity=[1, 2]), "must have the same number"),
    (lambda: vi.base_motion(base(), 1.0, sine=math.inf), "sine: must be amplitudes of y"),
    (lambda: vi.base_motion(base(), -1.0, sine=1), "frequency = -1.0"),
    (lambda: vi.base_motion(base(), 1.0, sine=1, direction=[1]), "direction of shape (1,): must be 3 numbers"),
])  # fmt: skip
def test_bad_records(make, message):
    with pytest.raises((vi.ParameterError, vi.ParameterTypeError)) as caught:
        make()
    assert message in str(caught.value)
