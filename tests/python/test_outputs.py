"""Outputs of structures by name, and loads of a moving base."""

from __future__ import annotations

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact.base.errors import ParameterError, ParameterTypeError

GAPS = [vi.Gap([-1.0, 1.0], 0.4, 0.7), vi.Gap([1.0, 0.0], 0.6, 0.5)]
MATRICES = (np.diag([1.0, 0.5]), [[0.06, -0.02], [-0.02, 0.02]], [[3.0, -1.0], [-1.0, 1.0]])
LOAD = vi.Load(1.1, sine=[0.3, 0.0], cosine=[0.0, 0.1])
VALUES = np.linspace(0.9, 1.5, 4)
#: Other coordinates p of the same structure, q = TURNED p.
TURNED = np.array([[1.0, 0.5], [-0.5, 2.0]])
NAMES = ("largest", "rms", "least", "greatest", "steady_largest", "steady_rms")


def body(**options):
    """A structure of two bodies."""
    return vi.Structure(*MATRICES, GAPS, **options)


def turned(outputs):
    """The same structure in other coordinates, with its load."""
    gaps = [vi.Gap(gap.direction @ TURNED, gap.opening, gap.restitution) for gap in GAPS]
    matrices = [TURNED.T @ np.asarray(matrix) @ TURNED for matrix in MATRICES]
    load = vi.Load(LOAD.frequency, sine=LOAD.sine @ TURNED, cosine=LOAD.cosine @ TURNED)
    return vi.Structure(*matrices, gaps, outputs=outputs), load


def test_an_output_that_is_a_coordinate_has_its_bits():
    found = vi.response(body(outputs={"first": [1, 0], "second": [0, 1]}), LOAD, VALUES)
    plain = vi.response(body(), LOAD, VALUES)
    for i, name in enumerate(("first", "second")):
        for part, coordinate in zip(found.of(name), plain.of(i), strict=True):
            assert np.array_equal(part, coordinate, equal_nan=True)
    diagram = vi.bifurcation_diagram(
        body(outputs={"second": [0, 1]}), LOAD, "load", [1.0, 1.1, 1.2]
    )
    assert np.array_equal(diagram.column("second"), diagram.column("q_1"))


def test_outputs_do_not_depend_on_the_coordinates():
    # stable motions: chaotic ones differ by their rounding
    rows = np.linalg.inv(TURNED)
    structure, load = turned(
        {"first": TURNED[0], "second": TURNED[1], "sum": TURNED[0] + TURNED[1]}
    )
    assert np.allclose(TURNED @ rows, np.eye(2))
    found = vi.response(structure, load, VALUES, sweep="up")
    plain = vi.response(body(), LOAD, VALUES, sweep="up")
    stable = (found.cycles > 0) & (found.cycles == plain.cycles)
    assert stable.sum() >= 3
    for i, name in enumerate(("first", "second")):
        for part, own in zip(found.of(name)[:4], plain.of(i)[:4], strict=True):
            assert np.allclose(part[stable], own[stable], rtol=1e-8)
        for part, own in zip(found.of(name)[4:], plain.of(i)[4:], strict=True):
            assert np.allclose(part, own, rtol=1e-10)


def test_the_size_of_an_output_is_that_of_samples():
    structure = body(outputs={"between": [-1, 1]})
    found = vi.response(structure, LOAD, [1.1, 1.2], sweep="up", keep=20, settling=100).of(
        "between"
    )
    run = vi.simulate(structure, LOAD, cycles=20, discard=100)
    times = np.linspace(run.start, run.end, 200_001)
    values = run.sample(times, "between")[0]
    with_corners = run.sample(np.union1d(times, run.events["time"]), "between")[0]
    assert with_corners.max() == pytest.approx(found.greatest[0, 0], rel=1e-6)
    assert with_corners.min() == pytest.approx(found.least[0, 0], rel=1e-6)
    assert np.sqrt(np.mean(values**2)) == pytest.approx(found.rms[0, 0], rel=1e-4)


def test_samples_of_an_output():
    structure = body(outputs={"between": [-1, 1]})
    run = vi.simulate(structure, LOAD, cycles=20, discard=300)
    times = np.linspace(run.start, run.end, 50)
    (q, rate), (value, speed) = run.sample(times), run.sample(times, "between")
    assert np.array_equal(value, q[1] - q[0])
    assert np.array_equal(speed, rate[1] - rate[0])
    more = run.acceleration(times)
    assert np.array_equal(run.acceleration(times, "between"), more[1] - more[0])
    motion = vi.exact(structure, LOAD, run)
    inner = motion.sample(times, "between")[0], motion.acceleration(times, "between")
    assert np.array_equal(inner[0], np.diff(motion.sample(times)[0], axis=0)[0])
    assert np.array_equal(inner[1], np.diff(motion.acceleration(times), axis=0)[0])


@pytest.mark.parametrize("extension", ["json", "nc", "mat", "csv"])
def test_outputs_are_saved_by_name(extension, tmp_path):
    structure = body(outputs={"between": [-1, 1], "first": [1, 0]})
    found = vi.response(structure, LOAD, VALUES, sweep="up")
    path = tmp_path / f"response.{extension}"
    found.save(path)
    if extension == "csv":
        header = next(line for line in path.read_text().split("\n") if line[:1] not in ("#", ""))
        assert header.split(",")[-8:] == [
            f"{size}_{name}" for size in ("largest", "rms", "steady_largest", "steady_rms")
            for name in ("between", "first")
        ]  # fmt: skip
        assert list(found.to_pandas().columns) == header.split(",")
        return
    read = vi.load(path)
    assert read.structure == structure
    assert all(
        np.array_equal(a, b) for a, b in zip(read.of("first"), found.of("first"), strict=True)
    )
    read.save(tmp_path / "again.csv")
    found.save(tmp_path / "first.csv")
    again = (tmp_path / "again.csv").read_text().replace("again", "first")
    assert again == (tmp_path / "first.csv").read_text()


def test_the_csv_of_a_diagram_and_the_trajectory_of_a_file_keep_outputs(tmp_path):
    structure = body(outputs={"between": [-1, 1]})
    diagram = vi.bifurcation_diagram(structure, LOAD, "load", [1.0, 1.1], sweep="up")
    table = diagram.to_pandas()
    assert np.array_equal(table["between"], table["q_1"] - table["q_0"])
    run = vi.simulate(structure, LOAD, cycles=3)
    run.save(tmp_path / "run.json")
    assert vi.load(tmp_path / "run.json").structure == structure
    assert structure != body()
    assert len({structure, body(outputs={"between": [-1, 1]}), body()}) == 2


def test_the_csv_of_a_trajectory_has_outputs(tmp_path):
    """The columns of the CSV are the outputs just after the events, from Python, a file and a namelist."""
    rng = np.random.default_rng(3)
    n = 12
    stiffness = np.diag(np.full(n, 2.0)) - np.eye(n, k=1) - np.eye(n, k=-1)
    gaps = [vi.Gap(np.eye(n)[0], 0.3, 0.7), vi.Gap(np.eye(n)[5] - np.eye(n)[6], 0.2, 0.6)]
    outputs = {"tip": np.eye(n)[-1], "mixed": rng.normal(size=n), "other": rng.normal(size=n)}
    structure = vi.Structure(np.ones(n), 0.02 * stiffness, stiffness, gaps, outputs=outputs)
    run = vi.simulate(structure, vi.Load(0.5, sine=np.eye(n)[2]), cycles=40)
    assert len(run.events) > 20
    run.save(tmp_path / "run.csv")
    table = run.to_pandas()
    assert list(table.columns)[-6:] == [*outputs, *(f"{name}_dot" for name in outputs)]
    for name, row in outputs.items():
        # `sample` gives the velocity before the impact at its time
        assert np.allclose(table[name], run.sample(run.events["time"], name)[0], atol=1e-12)
        assert np.allclose(table[f"{name}_dot"], run.states[:, 1] @ row, rtol=1e-12, atol=1e-12)
    (tmp_path / "run.nml").write_text(run.to_namelist())
    (case,) = vi.read_namelist(tmp_path / "run.nml")
    (result,) = case.run()
    result.save(tmp_path / "case.csv")
    run.save(tmp_path / "run.json")
    vi.load(tmp_path / "run.json").save(tmp_path / "file.csv")
    rows = [
        [line for line in (tmp_path / f"{name}.csv").read_text().split("\n") if line[:1] != "#"]
        for name in ("run", "file")
    ]
    assert rows[0] == rows[1]
    for name in table:
        if table[name].dtype.kind == "f":  # the sums have another order
            assert np.allclose(table[name], result.to_pandas()[name], rtol=1e-13, atol=1e-14)


def test_pictures_show_outputs():
    structure = body(outputs={"tip_end": [-1, 1]})
    plt = pytest.importorskip("matplotlib.pyplot")
    found = vi.response(structure, LOAD, VALUES, sweep="up")
    assert "tip" in found.plot().get_ylabel()
    assert "q_{0}" in found.plot(coordinate=0).get_ylabel()
    diagram = vi.bifurcation_diagram(structure, LOAD, "load", [1.0, 1.1], sweep="up")
    assert "tip_end" in diagram.plot().get_ylabel()
    assert "q_{0}" not in diagram.plot().get_ylabel()
    run = vi.simulate(structure, LOAD, cycles=3)
    assert run.plot(kind="history").get_ylabel() == "outputs"
    plt.close("all")


@pytest.mark.parametrize(
    "outputs", [{"q_1": [1, 0]}, {"a b": [1, 0]}, {"phase": [1, 0]}, {"gap": [1, 0]}, {"tip_dot": [1, 0]},
                {"x": [1]}, {"x" * 24: [1, 0]},
                {"é": [1, 0]}, {1: [1, 0]}, {"x": [1e41, 0]}, {"x": [np.nan, 0]}],
)  # fmt: skip
def test_outputs_that_are_refused(outputs):
    with pytest.raises(ParameterError, match="outputs"):
        body(outputs=outputs)


def test_names_that_are_no_outputs():
    with pytest.raises(ParameterTypeError, match="outputs"):
        body(outputs=[1, 0])
    run = vi.simulate(body(outputs={"between": [-1, 1]}), LOAD, cycles=1)
    with pytest.raises(ParameterError, match=r"output = 'tip': must be .* which has between"):
        run.sample([0.0], "tip")
    osc = vi.Oscillator(xi=0.01, mu=0.03, restitution=0.75)
    with pytest.raises(ParameterError, match="output = 'tip': must be left out"):
        vi.simulate(osc, 1.04, 25.0, cycles=3).sample([0.0], "tip")


def test_a_base_that_moves():
    """The relative motion of two masses on a base equals their motion under equivalent forces."""
    mass, damping, stiffness = (
        np.array([2.0, 0.5]),
        [[0.1, -0.04], [-0.04, 0.04]],
        [[5, -1], [-1, 1]],
    )
    relative = vi.Structure(mass, damping, stiffness, base=[1, 1])
    omega, a = 1.3, 0.7
    base, speed = -a / omega**2, -a / omega
    load = vi.base_motion(relative, omega, sine=base, relative=True)
    assert np.array_equal(relative.participation, mass)
    q = vi.simulate(relative, load, cycles=3, state=([0.2, -0.1], [0.3, 0.4]))
    # a sin(omega t) is the acceleration of a base at -a/omega^2 sin(omega t): x = q + y
    sine, cosine = np.array([4.0, 0.0]) * base, np.array([0.06, 0.0]) * base * omega
    absolute = vi.Load(omega, sine=sine, cosine=cosine)
    x = vi.simulate(
        vi.Structure(mass, damping, stiffness), absolute, cycles=3, state=([0.2, -0.1], [0.3 + speed, 0.4 + speed])
    )  # fmt: skip
    times = np.linspace(0, q.end, 40)
    assert np.allclose(
        x.sample(times)[0], q.sample(times)[0] + base * np.sin(omega * times), atol=1e-13
    )


def test_participation_of_modes():
    mass, stiffness = np.diag([2.0, 0.5]), np.array([[5.0, -1.0], [-1.0, 1.0]])
    root = np.sqrt(np.diag(mass))
    values, vectors = np.linalg.eigh(stiffness / np.outer(root, root))
    shapes = vectors / root[:, None]
    modal = vi.Structure.from_modes(
        np.sqrt(values), [0.01, 0.02], shapes, base=np.diag(mass),
        outputs=dict(zip(("lower", "upper"), shapes, strict=True)),
    )  # fmt: skip
    whole = vi.Structure(mass, 0 * mass, stiffness, base=[1, 1])
    # over all modes: the squares are the effective masses, whose sum is the total mass
    assert np.allclose(modal.participation, shapes.T @ whole.participation)
    assert (modal.participation**2).sum() == pytest.approx(2.5)
    load = vi.base_motion(modal, 1.3, sine=0.1, relative=True)
    assert np.allclose(load.sine, vi.base_motion(whole, 1.3, sine=0.1, relative=True).sine @ shapes)
    shock = vi.base_record(modal, 0.1, acceleration=[0.0, 1.0, 0.0])
    assert np.allclose(
        shock.force, vi.base_record(whole, 0.1, acceleration=[0.0, 1.0, 0.0]).force @ shapes
    )
    with pytest.raises(AttributeError, match="participation"):
        _ = body().participation
    with pytest.raises(ParameterError, match="direction = None: must be the participation"):
        vi.base_motion(vi.Structure.from_modes([1.0], [0.0], [[1.0]]), 1.3, sine=0.1)
