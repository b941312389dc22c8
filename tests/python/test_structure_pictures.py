"""Pictures of structures show the data of the trajectory."""

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact.plot.structure import KINDS, modes_of
from vibroimpact.plot.structure_sketch import bodies_of, draw_sketch

plt = pytest.importorskip("matplotlib.pyplot")


@pytest.fixture(autouse=True)
def close_figures():
    yield
    plt.close("all")


def chain(hosts):
    """Hosts in a row between two walls, each with a free mass in its slot."""
    n = 2 * hosts
    stiffness = np.zeros((n, n))
    for i in range(hosts):
        stiffness[i, i] = 2
        if i:
            stiffness[i, i - 1] = stiffness[i - 1, i] = -1
    gaps = []
    for i in range(hosts):
        direction = np.zeros(n)
        direction[[i, hosts + i]] = -1, 1
        gaps += [vi.Gap(direction, 0.2, 0.9), vi.Gap(-direction, 0.2, 0.9)]
    return vi.Structure([1] * hosts + [0.3] * hosts, 0.01 * stiffness, stiffness, gaps)


def run_of(hosts):
    rate = np.zeros(2 * hosts)
    rate[0] = 2
    return vi.simulate(chain(hosts), duration=25, state=(np.zeros(2 * hosts), rate))


def test_bodies_are_the_connected_parts():
    assert bodies_of(chain(3)) == [[0, 1, 2], [3], [4], [5]]
    coupled = vi.Structure(np.eye(3), np.zeros(3), [[1, 0, -1], [0, 1, 0], [-1, 0, 1]])
    assert bodies_of(coupled) == [[0, 2], [1]]


@pytest.mark.parametrize("hosts", [1, 2, 10, 11, 30])
def test_sketch_has_each_body_once(hosts):
    """The sketch names up to ten bodies; of more, the first three and the last one."""
    _, ax = plt.subplots()
    draw_sketch(ax, chain(hosts))
    names = [text.get_text() for text in ax.texts]
    shown = range(hosts) if hosts <= 10 else (0, 1, 2, hosts - 1)
    for i in range(hosts):
        assert sum(name.startswith(f"$m_{{{i}}}$") for name in names) == (i in shown)
        assert sum(name.startswith(f"$m_{{{hosts + i}}}$") for name in names) == (i in shown)
    springs = [name for name in names if name.startswith("$k$")]
    # springs between neighbours that are both shown, and at both ends; a single body has one spring
    assert len(springs) == {1: 1, 2: 3, 10: 11}.get(hosts, 4)


def test_history_shows_the_coordinates():
    run = run_of(2)
    ax = run.plot(kind="history")
    for i in range(4):
        times, values = ax.lines[i].get_data()
        assert np.array_equal(values, run.sample(times)[0][i])
    marked = sum(len(line.get_xdata()) for line in ax.lines[4:] if line.get_label() == "impact")
    assert marked == 2 * (run.events["kind"] == "impact").sum()


def test_openings_of_a_structure_by_its_modes():
    beam = vi.Structure.from_modes(
        [1.0, 6.27, 17.5], [0.01] * 3, [[2, -2, 2]], [vi.Gap([1], 0.05, 0.6)]
    )
    run = vi.simulate(beam, vi.Load(1.0, sine=[0.02, -0.02, 0.02]), cycles=8)
    assert len(run.events) > 3
    times, opening = run.plot(kind="history").lines[0].get_data()
    assert np.array_equal(opening, 0.05 - beam.gaps[0].direction @ run.sample(times)[0])
    assert opening.min() > -1e-12


@pytest.mark.parametrize("hosts", [1, 4])
def test_every_impact_is_in_the_picture(hosts):
    """Every impact is drawn, as a stem if there are few gaps and as a dot if there are many."""
    run = run_of(hosts)
    ax = run.plot(kind="impacts")
    impacts = run.events[run.events["kind"] == "impact"]
    if hosts == 1:
        points = [point for line in ax.lines for point in zip(*line.get_data(), strict=True)]
        assert sorted(points) == sorted(zip(impacts["time"], impacts["speed"], strict=True))
    else:
        (dots,) = ax.collections
        assert np.array_equal(dots.get_offsets()[:, 0], impacts["time"])
        assert np.array_equal(dots.get_offsets()[:, 1], impacts["gap"])
        assert np.array_equal(dots.get_array(), impacts["speed"])


@pytest.mark.parametrize("hosts", [2, 12])
def test_modes_have_all_of_the_energy(hosts):
    """The energy of the modes is that of the matrices, and the shares add up to 1."""
    run = run_of(hosts)
    s = run.structure
    omega, shapes = modes_of(run)
    assert shapes.T @ s.mass @ shapes == pytest.approx(np.eye(2 * hosts), abs=1e-12)
    assert shapes.T @ s.stiffness @ shapes == pytest.approx(np.diag(omega**2), abs=1e-12)
    bands = run.plot(kind="energy").collections
    top = max(band.get_paths()[0].vertices[:, 1].max() for band in bands)
    assert top == pytest.approx(1, abs=1e-12)


def test_all_panels_and_windows():
    run = run_of(2)
    assert run.plot().shape == (len(KINDS),)
    assert run.plot(kind="history", window=(1, 2)).get_xlim() == (1, 2)
    for window in ((2, 1), (0, 26), (1,), "x"):
        with pytest.raises(vi.VibroimpactError, match="must be two increasing times"):
            run.plot(window=window)
    with pytest.raises(vi.ParameterError, match="kind"):
        run.plot(kind="force")


def test_still_structure():
    """A structure without motion and events can be drawn."""
    run = vi.simulate(chain(2), duration=1)
    for kind in KINDS:
        run.plot(kind=kind)
    run.plot(kind="energy")
    assert run._repr_html_()


def test_animation(tmp_path):
    image = pytest.importorskip("PIL.Image")
    run = run_of(2)
    path = run.animate(tmp_path / "run.gif", window=(0, 5), seconds=0.5)
    assert image.open(path).n_frames == 10
    with pytest.raises(vi.ParameterError, match="seconds"):
        run.animate(tmp_path / "run.gif", seconds=0)
