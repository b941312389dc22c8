"""Records of forces and base motions in namelists, files and saved results."""

import itertools
import math
from pathlib import Path

import numpy as np
import pytest
import vibroimpact as vi
from scipy.integrate import solve_ivp
from scipy.io import mmwrite
from scipy.linalg import expm

INPUTS = Path(__file__).parents[2] / "inputs"
STRUCTURE = """&structure mass = 2, 0.3, damping = 0.3, -0.1, -0.1, 0.1, stiffness = 3, -1, -1, 1 /
&gap direction = -1, 1, opening = 0.2, restitution = 0.6 /
&gap direction = 1, -1, opening = 0.3, restitution = 0.7 /
"""


def structure():
    """The structure of the namelist STRUCTURE."""
    gaps = [vi.Gap([-1, 1], 0.2, 0.6), vi.Gap([1, -1], 0.3, 0.7)]
    return vi.Structure([2, 0.3], [[0.3, -0.1], [-0.1, 0.1]], [[3, -1], [-1, 1]], gaps)


def bits(run):
    """All numbers of a trajectory."""
    return (
        run.events.tobytes(),
        run.states.tobytes(),
        *(part.tobytes() for part in run.final_state),
    )


def computed(folder, load, study="&simulate duration = 30 /"):
    """The case of a namelist in a folder, and its trajectory."""
    path = folder / "case.nml"
    path.write_text(f"{STRUCTURE}&load {load} /\n{study}\n", encoding="utf-8")
    (case,) = vi.read_namelist(path)
    (run,) = case.run()
    return case, run


def kanai_tajimi():
    """The ground motion of inputs/structure_frame.csv."""
    step, samples, omega, zeta, peak = 0.02, 1001, 15.6, 0.6, 3.0
    t = step * np.arange(samples)
    envelope = np.where(t < 3, (t / 3) ** 2, np.where(t < 9, 1.0, np.exp(-0.4 * (t - 9))))
    noise = envelope * np.random.default_rng(1957).standard_normal(samples)
    flow = expm(np.array([[0, 1, 0], [-(omega**2), -2 * zeta * omega, -1], [0, 0, 0]]) * step)
    u, ground = np.zeros(2), [0.0]
    for w in noise[:-1]:
        u = flow[:2, :2] @ u + flow[:2, 2] * w
        ground.append(-(omega**2 * u[0] + 2 * zeta * omega * u[1]))
    return t, np.array(ground) * peak / np.abs(ground).max()


def test_earthquake_of_the_inputs():
    """The file holds the motion named in its header; between impacts the response obeys the equation of motion."""
    t, ground = kanai_tajimi()
    rows = np.loadtxt(INPUTS / "structure_frame.csv", delimiter=",", comments="#", skiprows=5)
    assert np.abs(rows - np.stack([t, ground], axis=1)).max() <= 0.5001e-5
    (case,) = vi.read_namelist(INPUTS / "structure_frame.nml")
    (run,) = case.run()
    s, first = case.structure, run.events[10]
    begin, end = run.events["time"][10:12]
    force = -s.mass @ np.ones(4)

    def rate(time, state):
        q, q_dot = np.split(state, 2)
        f = force * np.interp(time, rows[:, 0], rows[:, 1])
        return np.append(q_dot, np.linalg.solve(s.mass, f - s.damping @ q_dot - s.stiffness @ q))

    assert first["kind"] == "impact"
    found = solve_ivp(
        rate, (begin, end), run.states[10].ravel(), rtol=1e-10, atol=1e-13, max_step=0.002
    )  # fmt: skip
    later = np.concatenate(run.sample(np.nextafter(end, 0)))[:, 0]
    assert np.abs(found.y[:, -1] - later).max() < 1e-8


def test_files_of_each_format_have_the_same_digits(tmp_path):
    """CSV in several forms, Matrix Market, NumPy in both orders and plain numbers give the same digits."""
    force = np.random.default_rng(3).normal(size=(600, 2))
    digits = [[repr(float(x)) for x in row] for row in force]
    lines = [",".join(row) for row in digits]
    (tmp_path / "plain.csv").write_text("\n".join(lines), encoding="utf-8")
    blanks = "".join(line.replace(",", "\t ") + "\r\n" for line in lines)
    named = '\ufeff# measured\n\n"f_0 [N]";f_1\n' + blanks + "\r\n"
    (tmp_path / "names.csv").write_text(named, encoding="utf-8")
    times = [f"{0.05 * i:.2f},{line}" for i, line in enumerate(lines)]
    (tmp_path / "times.csv").write_text("\n".join(["Time (s),f0,f1", *times]), encoding="utf-8")
    mmwrite(tmp_path / "array.mtx", force, precision=17)
    np.save(tmp_path / "rows.npy", force)
    np.save(tmp_path / "columns.npy", np.asfortranarray(force))
    wanted = vi.simulate(structure(), vi.Record(0.05, force), duration=30)
    assert len(wanted.events) > 10
    loads = [f"record = {', '.join(map(repr, force.ravel().tolist()))}, step = 0.05"] + [
        f"record_file = '{path.name}', step = 0.05" for path in sorted(tmp_path.iterdir())
    ]
    assert len(loads) == 7
    for load in loads:
        case, run = computed(tmp_path, load)
        assert bits(run) == bits(wanted), load
        assert case.load == wanted.load
    case, run = computed(tmp_path, "record_file = 'times.csv'", "&simulate /")
    assert case.load.step == pytest.approx(0.05, rel=1e-14)
    assert run.end == case.load.duration


def test_a_coordinate_or_weights(tmp_path):
    """One column acts on the named coordinates, or on all by weights; a constant force is added."""
    signal = np.random.default_rng(4).normal(size=500)
    np.save(tmp_path / "one.npy", signal)
    both = np.zeros((500, 2))
    both[:, 1] = signal
    wanted = vi.simulate(structure(), vi.Record(0.1, both, [0.1, 0]), duration=60)
    named = "record_file = 'one.npy', step = 0.1, acts_on = 1, constant = 0.1, 0"
    assert bits(computed(tmp_path, named, "&simulate duration = 60 /")[1]) == bits(wanted)
    case, run = computed(tmp_path, "record_file = 'one.npy', step = 0.1, weights = -0.3, 0.7")
    record = vi.Record(0.1, signal[:, None], weights=[[-0.3, 0.7]])
    assert case.load == record
    assert np.array_equal(record.force, np.outer(signal, [-0.3, 0.7]))
    assert bits(run) == bits(vi.simulate(structure(), record, duration=30))
    # the last sample of both is at the same time
    assert vi.simulate(structure(), record).end == computed(
        tmp_path, "record_file = 'one.npy', step = 0.1, weights = -0.3, 0.7", "&simulate /"
    )[1].end  # fmt: skip


def test_body_without_gaps_whose_damping_is_not_classical():
    """The structure's mode pairs are complex, and positions depend on the record directly."""
    mass, step = np.array([1, 1.5, 1.0]), 0.1
    stiffness, damping = np.array([[3, -1, 0], [-1, 2, 0], [0, 0, 1]]), np.diag([0.5, 0.02, 0.1])
    force = np.random.default_rng(1).normal(size=(400, 3))
    structure = vi.Structure(mass, damping, stiffness, [vi.Gap([0, 0, 1], 50.0)])
    run = vi.simulate(structure, vi.Record(step, force))
    # state, force and its rate
    system = np.zeros((12, 12))
    system[:3, 3:6] = np.eye(3)
    system[3:6, :3], system[3:6, 3:6] = -stiffness / mass[:, None], -damping / mass[:, None]
    system[3:6, 6:9], system[6:9, 9:] = np.diag(1 / mass), np.eye(3)
    flow, state = expm(system * step), np.zeros(6)
    for here, there in itertools.pairwise(force):
        state = (flow @ np.concatenate([state, here, (there - here) / step]))[:6]
    assert np.concatenate(run.final_state) == pytest.approx(state, abs=1e-11)


@pytest.mark.parametrize("damping", [[[0.3, -0.1], [-0.1, 0.1]], [[0.5, -0.3], [-0.3, 0.3]]])
def test_more_numbers_on_the_same_lines(damping):
    """A record is linear between its numbers: four times as many on the same lines are the same force.

    Intervals that are proven to be without an event are passed at once, with open gaps or a resting body.
    """
    coarse, step = np.random.default_rng(7).normal(size=(60, 2)) * [1.5, 0.5] + [0.8, 0.4], 0.8
    fine = np.array([np.interp(np.arange(237) / 4, np.arange(60), column) for column in coarse.T]).T
    gaps = [vi.Gap([1, 0], 0.2, 0.3), vi.Gap([0, 1], 0.4, 0.2), vi.Gap([0, -1], 0.5, 0.0)]
    structure = vi.Structure([1, 0.5], damping, [[1, -0.3], [-0.3, 0.8]], gaps)
    one, other = (
        vi.simulate(structure, vi.Record(step / parts, record), duration=47.0)
        for parts, record in ((1, coarse), (4, fine))
    )
    assert one.events.size == other.events.size > 100
    assert (one.events["kind"] == "stick").sum() > 5
    for name in ("kind", "gap"):
        assert np.array_equal(one.events[name], other.events[name])
    assert one.events["time"] == pytest.approx(other.events["time"], abs=1e-8)
    assert np.concatenate(one.final_state) == pytest.approx(
        np.concatenate(other.final_state), abs=1e-8
    )


@pytest.mark.parametrize("direction", [None, [1.0, 0.25]])
def test_motion_of_the_base(tmp_path, direction):
    """A base motion equals that of `base_record`, bit for bit; gaps are the same in both kinds of coordinates."""
    t = 0.01 * np.arange(3001)
    y, y_dot, acceleration = np.sin(t) - t * np.exp(-t), np.cos(t) - (1 - t) * np.exp(-t), None
    acceleration = -np.sin(t) + (2 - t) * np.exp(-t)
    np.savetxt(tmp_path / "relative.csv", acceleration, fmt="%.17g")
    np.savetxt(tmp_path / "absolute.csv", np.stack([y, y_dot], axis=1), fmt="%.17g", delimiter=",")
    s = structure()
    end = "" if direction is None else f", base_direction = {direction[0]}, {direction[1]}"
    runs = {}
    for name, base, given in (
        ("relative", "acceleration", {"acceleration": acceleration}),
        ("absolute", "motion", {"displacement": y, "velocity": y_dot}),
    ):
        case, run = computed(
            tmp_path, f"record_file = '{name}.csv', base = '{base}', step = 0.01{end}"
        )
        record = vi.base_record(s, 0.01, **given, direction=direction)
        assert case.load == record
        assert bits(run) == bits(vi.simulate(s, record, duration=30))
        runs[name] = run
    if direction is None:
        times = np.linspace(0, 20, 401)
        relative, absolute = (s.gaps[0].direction @ run.sample(times)[0] for run in runs.values())
        assert np.abs(relative - absolute).max() < 2e-4  # linear between samples in only one
        assert np.ptp(relative) > 0.4


@pytest.mark.parametrize("ending", ["json", "nc", "mat"])
@pytest.mark.parametrize("kind", ["dense", "one", "base"])
def test_saved_results_keep_the_record(tmp_path, ending, kind):
    force = np.random.default_rng(5).normal(size=(400, 2))
    record = {
        "dense": vi.Record(0.05, force, [0.0, 0.1]),
        "one": vi.Record(0.05, force * [0, 1]),
        "base": vi.base_record(structure(), 0.05, displacement=force[:, 0], velocity=force[:, 1]),
    }[kind]
    run = vi.simulate(structure(), record)
    path = tmp_path / f"run.{ending}"
    run.save(path)
    back = vi.load(path)
    assert back.load == record
    assert back.to_namelist() == run.to_namelist()
    t = np.linspace(0, run.end, 777)
    for one, other in zip(run.sample(t), back.sample(t), strict=True):
        assert one.tobytes() == other.tobytes()
    assert "<svg" in run._repr_html_() or "<img" in run._repr_html_()
    back.plot()
    (case,) = [*vi.read_namelist(written(tmp_path, run))]
    assert bits(*case.run()) == bits(run)
    run.save(tmp_path / "run.csv")
    (case,) = vi.read_namelist(tmp_path / "run.csv")
    assert bits(*case.run()) == bits(run)


def written(folder, run):
    """The namelist of a trajectory."""
    path = folder / "again.nml"
    path.write_text(run.to_namelist(), encoding="utf-8")
    return path


def test_modes_need_a_direction(tmp_path):
    """With modes (M = I) base_direction d, the participation factors, is required; the force is -d y''."""
    text = """&structure frequencies = 1, 3, damping_ratios = 0.01, 0.01, shapes = 1, -1 /
&gap direction = 1, opening = 0.1 /
&load record = 0, 1, 0.5, step = 0.5, base = 'acceleration'{} /
&simulate duration = 5 /
"""
    path = tmp_path / "case.nml"
    path.write_text(text.format(", base_direction = 0.8, 0.4"), encoding="utf-8")
    (case,) = vi.read_namelist(path)
    assert case.load == vi.Record(0.5, [[0], [1], [0.5]], weights=[[-0.8, -0.4]])
    path.write_text(text.format(""), encoding="utf-8")
    with pytest.raises(vi.ParameterError, match="base_direction: is missing"):
        vi.read_namelist(path)


HARMONICS = "base_cosine = 0, 0.02, base_sine = 0.1"


@pytest.mark.parametrize("direction", [None, [1.0, 0.25]])
def test_harmonics_of_the_base(tmp_path, direction):
    """The forces equal those of `base_motion`, add to the forces of the group, and are echoed as forces."""
    s = structure()
    end = "" if direction is None else f", base_direction = {direction[0]}, {direction[1]}"
    motion = {"cosine": [0, 0.02], "sine": [0.1], "direction": direction}
    own = vi.Load(1.5, sine=np.arange(6.0).reshape(3, 2), constant=[0.5, -1])
    forces = "frequency = 1.5, sine = 0, 1, 2, 3, 4, 5, constant = 0.5, -1"
    for words, wanted in (
        (f"frequency = 1.5, base = 'motion', {HARMONICS}{end}", vi.base_motion(s, 1.5, **motion)),
        (f"{forces}, base = 'motion', {HARMONICS}{end}", own + vi.base_motion(s, 1.5, **motion)),
    ):
        case, run = computed(tmp_path, words)
        for name in ("frequency", "cosine", "sine", "constant"):
            found, right = getattr(case.load, name), getattr(wanted, name)
            np.testing.assert_allclose(found, right, rtol=1e-14, atol=1e-16)
        (again,) = vi.read_namelist(written(tmp_path, run))
        assert again.load == case.load
        assert bits(again.run()[0]) == bits(run)
    # an acceleration y'' = -h^2 Omega^2 y gives the load in coordinates relative to the base
    scale = -(1.5**2), -4 * 1.5**2
    words = f"base_cosine = 0, {0.02 * scale[1]!r}, base_sine = {0.1 * scale[0]!r}"
    case, _ = computed(tmp_path, f"frequency = 1.5, base = 'acceleration', {words}{end}")
    relative = vi.base_motion(s, 1.5, **motion, relative=True)
    np.testing.assert_allclose(case.load.sine, relative.sine, rtol=1e-14, atol=1e-16)
    np.testing.assert_allclose(case.load.cosine, relative.cosine, rtol=1e-14, atol=1e-16)


@pytest.mark.parametrize(("words", "wanted"), [
    ("frequency = 1.5, sine = 1, 0, base_sine = 0.1", "base_sine = 0.1: .*it requires base"),
    ("base = 'motion', base_sine = 0.1", "frequency: is missing"),
    ("frequency = 1.5, sine = 1, 0, base = 'motion'", "base = 'motion': .*base_cosine or base_sine"),
    ("record = 0, 1, step = 1, base = 'motion', base_sine = 0.1", "base_sine = 0.1: .*record is given"),
    ("frequency = 1.5, base = 'motion', base_sine = 0.1, base_direction = 1", "base_direction = 1: .*2 coord"),
    ("frequency = 1.5, base = 'motion', base_sine = 'a'", "base_sine = 'a'"),
])  # fmt: skip
def test_wrong_harmonics_of_the_base(tmp_path, words, wanted):
    with pytest.raises((vi.ParameterError, vi.ParameterTypeError), match=wanted):
        computed(tmp_path, words)


@pytest.mark.parametrize(("words", "wanted"), [
    ({"weights": [1, 2]}, r"an array \(2, n\)"), ({"weights": [[1, 2, 3]]}, r"an array \(2, n\)"),
    ({"weights": [[1, math.nan], [0, 1]]}, "finite"), ({"constant": [1]}, "as many as force has"),
])  # fmt: skip
def test_wrong_records(words, wanted):
    with pytest.raises(vi.ParameterError, match=wanted):
        vi.Record(0.1, np.ones((3, 2)), **words)
