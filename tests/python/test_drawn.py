"""Contents of pictures: the line that names the system, marks, numbers on axes, hatching."""

import numpy as np
import pytest
import vibroimpact as vi
from shared_motions import COLUMN
from shared_systems import FIGURE6, RIG, TABLE

matplotlib = pytest.importorskip("matplotlib")
matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.path import Path  # noqa: E402
from vibroimpact.plot import style  # noqa: E402
from vibroimpact.plot.found import draw_multipliers, drawn_at  # noqa: E402
from vibroimpact.plot.zone import covered  # noqa: E402


@pytest.fixture(autouse=True)
def _closed():
    """Close all figures after each test."""
    yield
    plt.close("all")


def words(ax):
    """The line above a figure, without mathematical markup."""
    return ax.figure.get_suptitle().replace("$", "").replace("\\", "")


@pytest.mark.parametrize(("name", "output"), [
    ("lyapunov", "xi = 0.0114, mu = 0.028, R = 0.75, r = 1.04"),
    ("basins", "xi = 0.005, mu = 0.042, R = 0.75, r = 0.94, dK/F_0 = 37"),
    ("bifurcation", "xi = 0.0114, mu = 0.028, R = 0.75, r = 1.04"),
    ("response", "xi = 0.0114, mu = 0.028, R = 0.75, dK/F_0 = 25"),
])  # fmt: skip
def test_attractors_are_identified(name, output, attractors):
    """The line above names the system and the constant parameters; axes of the caller do not get it."""
    assert words(attractors[name].plot()) == output
    _, ax = plt.subplots()
    assert words(attractors[name].plot(ax)) == ""


@pytest.mark.parametrize(("name", "output"), [
    ("zone", "xi = 0.0114, mu = 0.028, R = 0.75"), ("atlas", "xi = 0.0114, mu = 0.028, R = 0.75"),
    ("branch", "RL/1: xi = 0.005, mu = 0.042, R = 0.75, r = 0.94"),
])  # fmt: skip
def test_zones_and_branches_are_identified(name, output, results):
    """The line above a picture of a zone or branch names the system."""
    assert words(results[name].plot()) == output


def test_what_varies_is_not_told():
    """The line gives both restitutions if they differ, a load other than F0, and no swept parameter."""
    run = vi.bifurcation_diagram(RIG, "clearance", [9.0, 10.0], r=1.04, load=2.0, settling=9)
    assert words(run.plot()).endswith("R_1 = 0.75, R_2 = 0.61, r = 1.04, load/F_0 = 2")
    run = vi.bifurcation_diagram(RIG, "restitution", [0.6, 0.7], r=1.04, clearance=9.0, settling=9)
    assert words(run.plot()) == "xi = 0.0114, mu = 0.028, r = 1.04, dK/F_0 = 9"
    start = vi.exact(TABLE, 0.94, 37.0, COLUMN)
    assert "R" not in words(vi.branch(start, "restitution", (0.74, 0.76)).plot()).replace("RL", "")


def test_chart_is_identified_and_hatched_to_its_edges():
    """The chart names pattern and system; the hatching covers exactly the cells of its class."""
    pytest.importorskip("xarray")
    from vibroimpact.plot.chart import _edges, classes, draw_chart

    data = vi.chart(
        FIGURE6, vi.Pattern("RL"), np.linspace(0.9, 1.1, 21), np.geomspace(5, 100, 16), True
    )
    ax = draw_chart(data)
    assert words(ax) == "RL/1: xi = 0.0114, mu = 0.028, R = 0.75"
    hatched = [item for item in ax.collections if getattr(item, "hatches", [None])[0] == "////"]
    (path,) = hatched[0].get_paths()
    kind, inside = classes(data), np.zeros(0)
    r, clearance = _edges(data["r"].values), _edges(data["clearance"].values)
    for share in (0.02, 0.5, 0.98):  # positions within a cell, as a share of its width
        points = np.meshgrid(
            r[:-1] + share * np.diff(r), clearance[:-1] + share * np.diff(clearance)
        )
        # pieces and holes are one path: count crossings by parity
        rings = [ring for ring in path.to_polygons(closed_only=False) if len(ring) > 2]
        inside = sum(Path(ring).contains_points(np.c_[points[0].ravel(), points[1].ravel()])
                     for ring in rings) % 2  # fmt: skip
        np.testing.assert_array_equal(inside.reshape(kind.shape) == 1, kind == 2)


def test_zones_in_one_picture_differ_in_fill(results):
    """The fill of each further zone in the same axes has another colour, unless a colour is given."""
    zone = results["zone"]
    ax = zone.plot()
    zone.plot(ax)
    fills = [patch.get_facecolor()[:3] for patch in ax.patches]
    assert len(fills) == 2
    assert fills[0] != fills[1]


def test_shared_boundaries_are_drawn_once(results):
    """The pitchfork between two zones is drawn as a single line; all other vertices are drawn."""
    atlas = results["atlas"]
    ax = atlas.plot()
    for line in lines_of(ax):
        for other in lines_of(ax):
            if other is not line and line.get_linestyle() == other.get_linestyle():
                assert not covered(scaled(line, atlas), [scaled(other, atlas)]).any()
    pieces = [piece for zone in atlas.zones for piece in zone.boundary if piece.type != "window"]
    drawn = [scaled(line, atlas) for line in lines_of(ax)]
    assert len(drawn) < len(pieces)
    for piece in pieces:
        assert covered(unit(piece.r, piece.clearance, atlas), drawn).all()


def test_points_that_no_zone_explains_are_marked():
    """Each point has one mark, each outcome a different shape, and the legend gives their numbers."""
    atlas = vi.atlas(FIGURE6, (0.8, 1.2), (2, 200), max_impacts=2, survey=60, guesses=0)
    ax = atlas.plot()
    legend = [text.get_text() for text in ax.get_legend().get_texts()]
    left_out = {"periodic", "without impacts"}
    shapes = []
    for name, number in atlas.counts.items():
        if number and name not in left_out:
            assert f"{name} ({number})" in legend
            (marks,) = [item for item in ax.collections if item.get_label() == f"{name} ({number})"]
            assert len(marks.get_offsets()) == number
            shapes.append(marks.get_paths()[0].vertices.tobytes())
    assert len(set(shapes)) == len(shapes) > 1
    assert any(text.startswith("without impacts") for text in legend)


def lines_of(ax):
    """The lines that have points."""
    return [line for line in ax.get_lines() if len(line.get_xdata())]


def unit(r, clearance, atlas):
    """Points, with the window as the unit square."""
    low, high = np.log(atlas.clearance)
    first, last = atlas.r
    return np.c_[(r - first) / (last - first), (np.log(clearance) - low) / (high - low)]


def scaled(line, atlas):
    """The vertices that a line shows."""
    r, clearance = np.array(line.get_data(), float)
    return unit(r, clearance, atlas)[~np.isnan(r)]


def test_covered():
    """Vertices on a line with both neighbours, within a distance."""
    along = np.linspace(0, 1, 11)
    line = np.c_[along, along**2]
    assert covered(line, [line]).all()
    assert not covered(line, []).any()
    assert not covered(line + np.array([0, 0.01]), [line]).any()
    half = covered(line, [line[:6]])
    assert half.tolist() == [True] * 5 + [False] * 6


def test_exponents_of_minus_infinity_are_marked():
    """Each exponent of -inf is an open mark at the lower edge, which the legend explains."""
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.3)
    result = vi.lyapunov(osc, [0.9, 1.0, 1.2], 2.0, 60, discard=100)
    lost = np.isneginf(result.per_cycle)
    assert 0 < lost.sum() < lost.size
    ax = result.plot()
    marks = [line for line in ax.get_lines() if line.get_transform() == ax.get_xaxis_transform()]
    marks = [line for line in marks if line.get_markerfacecolor() == "none"]
    got = sorted(x for line in marks for x in line.get_xdata())
    assert got == sorted(np.broadcast_to(result.r, lost.shape)[lost])
    assert len({line.get_ydata()[0] for line in marks}) == len(marks)
    assert r"$-\infty$" in [text.get_text() for text in ax.texts]
    finite = vi.lyapunov(FIGURE6, 1.04, [25.0, 30.0], 60, discard=50).plot()
    assert list(finite.texts) == []


def test_sweeps_are_told_apart_by_marks(attractors):
    """Upward and downward runs have different marks; each impact is drawn once, as its run and side."""
    diagram = attractors["bifurcation"]
    assert diagram.runs == ["up", "down"]
    lines = {
        line.get_label(): line for line in diagram.plot().get_lines() if "on" in line.get_label()
    }
    assert len({line.get_marker() for line in lines.values()}) == 4
    run = np.array(diagram.runs)[diagram.points["run"]]
    for label, line in lines.items():
        side, name = label.removeprefix("impacts on ").split(", ")
        assert (line.get_markerfacecolor() == "none") == (name == "down")
        mine = diagram.points[(diagram.points["side"] == side) & (run == name)]
        np.testing.assert_array_equal(line.get_xdata(), diagram.values[mine["index"]])
        np.testing.assert_array_equal(line.get_ydata(), mine["x"])
    one = vi.bifurcation_diagram(FIGURE6, "clearance", [20, 30], r=1.04, sweep="up", settling=9)
    labels = [line.get_label() for line in one.plot().get_lines()]
    assert [text for text in labels if "on" in text] == ["impacts on R", "impacts on L"]


def test_geometric_values_have_a_logarithmic_axis():
    """Geometrically spaced values have a logarithmic axis, evenly spaced ones a linear axis."""
    for values, scale in ((np.geomspace(10, 60, 9), "log"), (np.linspace(10, 60, 9), "linear")):
        run = vi.bifurcation_diagram(FIGURE6, "clearance", values, r=1.04, settling=5)
        assert run.plot().get_xscale() == scale
        exponents = vi.lyapunov(FIGURE6, 1.04, values, 40, discard=5)
        assert exponents.plot().get_xscale() == scale


@pytest.mark.parametrize(("window", "output"), [
    ((20, 60), ["20", "30", "40", "50", "60"]),
    ((9, 110), ["10", "20", "30", "50", "100"]),
    ((2, 200), ["2", "5", "10", "20", "50", "100", "200"]),
    ((0.5, 2e4), ["1", "10", "100", "1000", "10000"]),
    ((1e-5, 2e-3), ["$10^{-5}$", r"$2\times10^{-5}$", r"$5\times10^{-5}$", "$10^{-4}$",
                    r"$2\times10^{-4}$", r"$5\times10^{-4}$", "0.001", "0.002"]),
])  # fmt: skip
def test_numbers_of_a_logarithmic_axis(window, output):
    """Tick labels are round numbers, written plainly where short; narrow windows have labels between powers."""
    figure, ax = plt.subplots()
    style.log_scale(ax, "y")
    ax.set_ylim(window)
    figure.canvas.draw()
    low, high = (value * factor for value, factor in zip(window, (0.999, 1.001), strict=True))
    ticks = [*ax.yaxis.get_major_ticks(), *ax.yaxis.get_minor_ticks()]
    shown = sorted((tick.get_loc(), tick.label1.get_text()) for tick in ticks)
    assert [text for value, text in shown if low <= value <= high and text] == output


def test_found_motions_are_numbered():
    """Each motion is numbered once, at its leading multiplier, and the legend explains all marks."""
    found = vi.find(TABLE, 0.94, 37.0, max_impacts=2, max_cycles=1)
    panels = found.plot()
    assert len(panels) == len(found) + 1
    numbers = {
        int(number): text.xy for text in panels[-1].texts for number in text.get_text().split(", ")
    }
    assert sorted(numbers) == list(range(1, len(found) + 1))
    for number, place in numbers.items():
        point = drawn_at(found[number - 1].multipliers)[0]
        assert abs(complex(point.real, abs(point.imag)) - complex(*place)) < 0.1
    (legend,) = panels[0].figure.legends
    names = " ".join(text.get_text() for text in legend.get_texts())
    for name in ("X", "walls dashed", "Z", "impact", "multipliers, stable", "not stable"):
        assert name in names
    figure = panels[0].figure
    figure.canvas.draw()
    ax = panels[-1]
    unit_x, unit_y = ax.transData.transform([(1, 0), (0, 1)]) - ax.transData.transform((0, 0))
    # circular up to the change of the layout after the limits were set
    assert unit_x[0] == pytest.approx(unit_y[1], rel=0.01)
    renderer = figure.canvas.get_renderer()
    boxes = [super(type(text), text).get_window_extent(renderer) for text in ax.texts]
    for i, box in enumerate(boxes):
        assert not any(box.overlaps(other) for other in boxes[:i])


def test_distance_of_multipliers():
    """Multipliers are drawn unchanged within the unit circle; beyond it each power of ten adds one."""
    values = np.array([0.5, -1.0, 10j, -100.0])
    assert drawn_at(values) == pytest.approx([0.5, -1.0, 2j, -3.0])
    _, ax = plt.subplots()
    draw_multipliers([], ax)
