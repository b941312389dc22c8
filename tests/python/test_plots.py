"""Pictures: data of the panels, labels, and that drawing does not change the caller's matplotlib."""

import sys

import numpy as np
import pytest
import vibroimpact as vi
from shared_motions import COLUMN, rest_motion
from shared_results import NAMES, STUDIES_NAMED
from shared_simulations import settled
from shared_systems import RIG, TABLE, TURN

matplotlib = pytest.importorskip("matplotlib")
matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from vibroimpact.plot import draw_system, sketch  # noqa: E402

KINDS = ("history", "load", "acceleration", "portrait")
LABELS = {
    "history": ("X", "Z", "F_0/K"),
    "load": ("load", "F_0"),
    "acceleration": (r"\ddot X", "F_0/K"),
    "portrait": (r"\dot Y", "F_0/K"),
}


@pytest.fixture(autouse=True)
def _closed():
    """Close all figures before and after each test."""
    plt.close("all")
    yield
    plt.close("all")


def things():
    """A motion, one with rest, a trajectory and one with rests."""
    return [
        vi.exact(TABLE, 0.94, 37.0, COLUMN),
        rest_motion(),
        vi.simulate(TABLE, 0.94, 37.0, 5.3, {"t": 0, "x": 0, "x_dot": 9, "z": 0, "z_dot": 3}),
        settled(4),
    ]


def lines(ax):
    """Pairs of arrays of all lines of a panel."""
    return [np.array(line.get_data(), dtype=float) for line in ax.get_lines()]


def curve(ax):
    """Return the longest line of a panel that is drawn with many points."""
    return max(lines(ax), key=lambda data: data.shape[1])


@pytest.mark.parametrize("which", range(4))
@pytest.mark.parametrize("kind", KINDS)
def test_one_panel_into_given_axes(which, kind):
    """`ax` is drawn into and returned, without a new figure; labels have symbols and units."""
    figure, ax = plt.subplots()
    before = plt.get_fignums()
    assert things()[which].plot(ax=ax, kind=kind) is ax
    assert plt.get_fignums() == before
    for word in LABELS[kind]:
        assert word in ax.get_ylabel()
    assert "Y" in ax.get_xlabel() if kind == "portrait" else "cycles" in ax.get_xlabel()
    figure.canvas.draw()


@pytest.mark.parametrize("which", range(4))
def test_all_panels(which, tmp_path):
    """Without `ax` one figure has all panels, and can be written to a file."""
    axes = things()[which].plot()
    assert len(axes) == len(KINDS)
    figure = axes[0].figure
    for one in axes:
        assert one.figure is figure
        assert one.get_ylabel()
    path = tmp_path / "motion.png"
    figure.savefig(path)
    assert path.stat().st_size > 10_000
    title = figure.get_suptitle()
    for word in (r"\xi", r"\mu", "R", "r", "dK/F_0"):
        assert word in title


def test_default_panel_is_the_history():
    """`ax` alone draws the time history."""
    _, ax = plt.subplots()
    assert "Z" in vi.exact(TABLE, 0.94, 37.0, COLUMN).plot(ax=ax).get_ylabel()


def test_kind_alone_makes_one_panel():
    """`kind` alone gives one new figure with one panel."""
    ax = vi.exact(TABLE, 0.94, 37.0, COLUMN).plot(kind="load")
    assert len(plt.get_fignums()) == 1
    assert ax.figure.axes == [ax]


@pytest.mark.parametrize("which", range(4))
def test_history_is_the_sample(which):
    """The curves X and Z equal those of `sample`, walls are at X +- d/2, and events have markers."""
    thing = things()[which]
    motion = isinstance(thing, vi.Motion)
    _, ax = plt.subplots()
    thing.plot(ax=ax, kind="history", cycles=2)
    start = 0.0 if motion else thing.final_state["t"] - 2 * TURN / thing.r
    labels = {str(line.get_label()).split()[0].strip("$"): line for line in ax.get_lines()}
    for name in ("X", "Z"):
        cycles, values = np.array(labels[name].get_data(), float)
        assert cycles[0] == pytest.approx(0, abs=1e-9)
        assert cycles[-1] == pytest.approx(2, abs=1e-9)
        assert cycles.size >= 800
        inside = cycles[1:-1:7]
        times = start + inside * TURN / thing.r
        want = getattr(thing.sample(times), name)
        assert values[1:-1:7] == pytest.approx(want, abs=1e-6 * thing.clearance)
    walls = [d for d in lines(ax) if d.shape[1] == labels["X"].get_xdata().size]
    offsets = {round(float(np.mean(d[1] - labels["X"].get_ydata())), 6) for d in walls}
    assert {0.5 * thing.clearance, -0.5 * thing.clearance} <= offsets
    events = thing.events
    if not motion:
        events = events[events["time"] >= start]
    cycles, values = np.array(labels["impact"].get_data(), float)
    hits = events[events["kind"] == "impact"]
    assert cycles.size in (hits.size, 2 * hits.size, 2 * hits.size + 1)
    side = np.where(hits["side"] == "R", 0.5, -0.5)
    got, want = np.sort(values)[[0, -1]], np.sort(hits["x"] + side * thing.clearance)[[0, -1]]
    assert got == pytest.approx(want, abs=1e-6)


def test_rests_are_marked():
    """Sticks and releases have their own markers, as many as there are."""
    run = settled(4)
    _, ax = plt.subplots()
    run.plot(ax=ax, cycles=4)
    for kind in ("stick", "release"):
        line = next(line for line in ax.get_lines() if line.get_label() == kind)
        assert len(line.get_xdata()) == (run.events["kind"] == kind).sum()
        assert line.get_marker() not in ("", "None", None)


@pytest.mark.parametrize("which", range(4))
def test_load_panel(which):
    """The load drawn is f sin(phase) of the motion or trajectory."""
    thing = things()[which]
    _, ax = plt.subplots()
    thing.plot(ax=ax, kind="load", cycles=2)
    cycles, values = curve(ax)
    offset = thing.load_phase if isinstance(thing, vi.Motion) else thing.final_state["phase"]
    assert values == pytest.approx(thing.load * np.sin(offset + TURN * cycles), abs=1e-9)


@pytest.mark.parametrize("which", range(4))
def test_acceleration_panel(which):
    """The acceleration is load - 2 xi X' - X, divided by 1 + mu at rest, with a spike at each impact."""
    thing = things()[which]
    osc, motion = thing.osc, isinstance(thing, vi.Motion)
    _, ax = plt.subplots()
    thing.plot(ax=ax, kind="acceleration", cycles=2)
    cycles, values = curve(ax)
    start = 0.0 if motion else thing.final_state["t"] - 2 * TURN / thing.r
    pick = slice(3, -3, 11)
    times = start + cycles[pick] * TURN / thing.r
    h = thing.sample(times)
    free = h.load - 2 * osc.xi * h.X_dot - h.X
    rest = np.abs(np.abs(h.Y) - 0.5 * thing.clearance) < 1e-12
    rest &= h.X_dot == h.Z_dot
    want = np.where(rest, free / (1 + osc.mu), free)
    good = np.abs(values[pick] - want) < 1e-5 * max(1.0, np.abs(want).max())
    # both sides of a jump are drawn, and rounding decides to which side such a time belongs
    events = np.array(thing.events["time"])
    events = np.concatenate([events + i * thing.period for i in range(4)]) if motion else events
    away = np.abs(times[:, None] - events).min(axis=1) > 1e-9
    assert away.sum() > 20
    assert good[away].all()
    spikes = [seg for part in ax.collections for seg in getattr(part, "get_segments", list)()]
    assert len(spikes) >= 2


def test_load_amplitude_is_drawn():
    """A trajectory under another load draws that load."""
    run = vi.simulate(RIG, 0.9, 6.0, 5, load=2.5)
    _, ax = plt.subplots()
    run.plot(ax=ax, kind="load")
    assert np.abs(curve(ax)[1]).max() == pytest.approx(2.5, abs=1e-3)


def test_portrait_stays_between_the_walls():
    """Y on the horizontal axis, never beyond the walls that are drawn."""
    for thing in things():
        _, ax = plt.subplots()
        thing.plot(ax=ax, kind="portrait")
        y = curve(ax)[0]
        assert np.abs(y).max() <= 0.5 * thing.clearance * (1 + 1e-9)
        assert np.abs(y).max() > 0.49 * thing.clearance


@pytest.mark.parametrize(("name", "value"), [
    ("kind", "pie"), ("kind", 3), ("cycles", 0), ("cycles", -1), ("cycles", float("nan")),
    ("cycles", "2"),
])  # fmt: skip
def test_wrong_arguments(name, value):
    """Invalid words and numbers are refused by name, and no figure is left open."""
    for thing in (vi.exact(TABLE, 0.94, 37.0, COLUMN), settled(2)):
        with pytest.raises(vi.errors.VibroimpactError, match=name):
            thing.plot(**{name: value})
        assert plt.get_fignums() == []


def test_short_and_quiet_trajectories_are_drawn():
    """Trajectories without impacts, without duration, or with fewer cycles than the window are drawn."""
    for run in (
        vi.simulate(RIG, 0.9, 1e4, 3),
        vi.simulate(RIG, 0.9, 6.0, 0.5),
        vi.simulate(RIG, 0.9, 6.0, 2, load=0.0),
        vi.simulate(RIG, 0.9, 6.0, 0),
    ):
        axes = run.plot()
        axes[0].figure.canvas.draw()
        assert len(axes) == len(KINDS)
        assert np.isfinite([one.get_xlim() + one.get_ylim() for one in axes]).all()


def test_clearance_in_the_sketch_is_the_whole_travel():
    """The two gaps on both sides of m are d/2 each, with the sum d; all symbols are within the picture."""
    ax = draw_system()
    texts = [text.get_text() for text in ax.texts]
    for symbol in ("$M$", "$m$", "$K$", "$C$", "$X$", "$Z$"):
        assert symbol in texts
    assert texts.count("$d/2$") == 2
    assert any("whole travel" in text for text in texts)
    (left, right), (low, high) = sketch.SLOT[:2], sketch.MASS[:2]
    assert low - left == pytest.approx(right - high)
    figure = ax.figure
    figure.canvas.draw()
    for text in ax.texts:
        box = text.get_window_extent()
        assert figure.bbox.x0 <= box.x0 < box.x1 <= figure.bbox.x1
        assert figure.bbox.y0 <= box.y0 < box.y1 <= figure.bbox.y1


def test_the_sketch_shows_the_values_of_a_rig():
    """The values of a physical rig and of its point are above the sketch in its units, within the picture."""
    rig = vi.Oscillator.from_dimensional(
        M="2.7 kg", K="42 kN/m", xi="1.1 %", m="0.11 kg", restitution=(0.7, 0.6), F0="6 N"
    )
    damping = 2 * 0.011 * np.sqrt(2.7 * 42e3)
    mass = [f"$M$ = {2.7:.6g} kg", "$m$ = 0.11 kg", "$K$ = 42000 N/m", f"$C$ = {damping:.6g} N s/m"]
    place = ["$f$ = 19.5 Hz", "$d$ = 4 mm", "$F_0$ = 6 N"]
    for thing, wanted in (
        (rig, [*mass, "$F_0$ = 6 N", "$R_1$ = 0.7", "$R_2$ = 0.6"]),
        (rig.at("19.5 Hz", "4 mm"), [*mass, *place]),
        (rig.at("19.5 Hz", "4 mm", friction="0.1 N"), [*mass, *place, "in kg, N/m"]),
        (TABLE, [r"$\xi$ = 0.005", r"$\mu$ = 0.042", "$R$ = 0.75"]),
        (TABLE.at(0.94, 37.0, load=2.0), ["$r$ = 0.94", "$dK/F_0$ = 37", "load/$F_0$ = 2"]),
        (vi.Oscillator(xi=0.01, mu=0.1, restitution=(0.7, vi.PowerLaw(0.7, 20, 0.25))), ["R(v)"]),
    ):
        figure = draw_system(thing).figure
        title = figure.axes[0].title
        assert [text for text in wanted if text not in title.get_text()] == []
        figure.canvas.draw()
        box = title.get_window_extent()
        assert figure.bbox.x0 <= box.x0 < box.x1 <= figure.bbox.x1
        assert box.y1 <= figure.bbox.y1


def test_what_cannot_be_sketched_is_refused():
    """Objects other than systems, and loads of oscillators, are refused by name; axes are given by name."""
    _, ax = plt.subplots()
    for wrong in (ax, 3):
        with pytest.raises(TypeError, match=r"system = .*axes are given as ax="):
            draw_system(wrong)
    with pytest.raises(ValueError, match=r"load = .*unless system is a Structure"):
        draw_system(TABLE, vi.Load(0.94, sine=[1, 0]))
    with pytest.raises(TypeError, match="load = 2: must be a Load or a Record"):
        draw_system(TABLE.structure(37.0), 2)
    assert draw_system(TABLE.structure(37.0), ax=ax) is ax


def test_the_scale_of_the_spikes_is_told():
    """The legend gives the velocity jump of the longest spike, and is above the axes."""
    motion = vi.exact(TABLE, 0.94, 37.0, COLUMN)
    ax = motion.plot(kind="acceleration")
    largest = np.abs(motion.X_dot_after - motion.X_dot_before).max()
    ax.figure.canvas.draw()
    (text,) = ax.get_legend().get_texts()
    assert f"longest: {largest:.3g} " in text.get_text()
    assert ax.get_legend().get_window_extent().y0 >= ax.bbox.y1 - 1


def test_settings_are_left_alone():
    """Drawing does not change the caller's style."""
    before = dict(matplotlib.rcParams)
    settled(2).plot()
    assert dict(matplotlib.rcParams) == before


def test_without_matplotlib(monkeypatch):
    """An import error of the package names what to install; computations work without matplotlib."""
    motion = vi.exact(TABLE, 0.94, 37.0, COLUMN)
    for name in list(sys.modules):
        if name.split(".")[0] == "matplotlib":
            monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(ImportError, match=r"vibroimpact\[plot\]") as caught:
        motion.plot()
    assert isinstance(caught.value, vi.errors.VibroimpactError)
    assert type(caught.value).__name__ == "MissingExtraError"
    assert vi.simulate(RIG, 0.9, 6.0, 1).events.size > 0


@pytest.mark.parametrize("engine", [None, "constrained"])
@pytest.mark.parametrize("name", [*NAMES, *STUDIES_NAMED])
def test_legends_are_not_cut_off(name, engine, results, attractors):
    """In small axes of the caller every legend is within the figure."""
    noun = results[name] if name in NAMES else attractors[name]
    if not noun.drawable:
        with pytest.raises(vi.errors.ParameterError):
            noun.plot()
        return
    figure, ax = plt.subplots(figsize=(2.4, 2.0), layout=engine)
    try:
        noun.plot(ax=ax)
        figure.canvas.draw()
        for legend in (one for one in (axes.get_legend() for axes in figure.axes) if one):
            box = legend.get_window_extent()
            assert box.x0 > -1
            assert box.x1 < figure.bbox.x1 + 1
            if engine is None:
                assert box.y1 < figure.bbox.y1 + 1
    finally:
        plt.close(figure)


def test_the_shares_of_basins_are_of_the_same_states():
    """Undecided states and attractors are shares of the states without a closed gap, and make 100 %."""
    gap = vi.Gap([1], 0.3, 0.5)
    belt = vi.Friction([1], slip=0.6, stick=0.9, speed=0.2)
    mass = vi.Structure([1.0], [0.1], [1.0], [gap], friction=[belt])
    plane = (("q_0", (-0.9, 0.9)), ("q_dot_0", (-0.3, 0.1)))
    basins = vi.basins(mass, None, plane, points=(6, 3), settling=1)
    assert (basins.labels == -4).mean() == pytest.approx(1 / 3)
    texts = [text.get_text() for text in basins.plot().get_legend().get_texts()]
    of_open = [text for text in texts if "closed gap" not in text]
    assert "closed gap  33.3%" in texts
    assert any("undecided" in text for text in of_open)
    assert sum(float(text.split()[-1].rstrip("%")) for text in of_open) == pytest.approx(
        100, abs=0.2
    )
