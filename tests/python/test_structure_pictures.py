"""Pictures of structures show the data of the trajectory."""

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact.plot.animation import _Bodies
from vibroimpact.plot.history import KINDS_OF_STRUCTURE as KINDS
from vibroimpact.plot.history import modes_of, spans_of
from vibroimpact.plot.sketch import bodies_of, draw_sketch
from vibroimpact.plot.style import REST, condition_name, parameter_label

plt = pytest.importorskip("matplotlib.pyplot")
same_color = pytest.importorskip("matplotlib.colors").same_color


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


def test_walls_that_move():
    """Animations show each wall of one coordinate at its position, sketches the extremes of its opening."""
    walls = [vi.Gap([-1], 0.3, 0.7, sine=-0.02), vi.Stop([2], 0.4, 50, cosine=[0, 0.1])]
    ball = vi.Structure(mass=[1], damping=[0], stiffness=[0], gaps=walls)
    run = vi.simulate(ball, vi.Load(20.0, constant=[-9.81]), cycles=3)
    _, axes = plt.subplots(2)
    scene = _Bodies(run, run.start, run.end, axes)
    for t in np.linspace(run.start, run.end, 5):
        scene.show(t)
        faces = [segment[0, 1] for segment in scene.bars.get_segments()]
        moved = [-0.3 + 0.02 * np.sin(20 * t), (0.4 + 0.1 * np.cos(40 * t)) / 2]
        np.testing.assert_allclose(faces, moved, atol=1e-12)
        assert axes[0].get_ylim()[0] < min(faces) < max(faces) < axes[0].get_ylim()[1]
    _, ax = plt.subplots()
    draw_sketch(ax, vi.Structure([1], [0], [1], walls))
    labels = " ".join(text.get_text() for text in ax.texts).replace("\n", " ")
    assert "0.28 to 0.32" in labels
    assert "0.3 to 0.5" in labels


def test_a_wall_between_two_masses():
    """The drawn mass moves with the other: the free mass is at its wall at each impact, and between otherwise."""
    slot = [vi.Gap([-1, 1], 0.5, 0.6, cosine=0.1), vi.Gap([1, -1], 0.5, 0.6, cosine=-0.1)]
    pair = vi.Structure([1, 0.1], [0.1, 0], [1, 0], slot)
    run = vi.simulate(pair, vi.Load(1.2, cosine=[1, 0]), cycles=3, discard=20)
    scene = _Bodies(run, run.start, run.end, plt.subplots(2)[1])
    hits = run.events[run.events["kind"] == "impact"][:6]
    assert len(hits)
    for time, gap in zip(hits["time"], hits["gap"], strict=True):
        scene.show(time)
        bars = scene.bars.get_segments()
        free = scene.dots.get_offsets()[1, 1]
        assert [bar[:, 0].mean() for bar in bars] == pytest.approx([1, 1])
        assert bars[gap][0, 1] == pytest.approx(free, abs=1e-9)
        assert bars[1][0, 1] - 1e-9 <= free <= bars[0][0, 1] + 1e-9


def moving(kind, direction, opening, **words):
    """A wall with a long label."""
    return kind(direction, opening, cosine=[0.51 * opening], **words)


@pytest.mark.parametrize("gaps", [
    [moving(vi.Gap, [-1, 1, 0], 0.512)], [moving(vi.Stop, [1, -1, 0], 0.512, stiffness=12.5)],
    [moving(vi.Gap, [0, side, 0], 0.512) for side in (1, -1)]
    + [moving(vi.Gap, [0, 0, 1], 0.512), moving(vi.Gap, [1, 0, 0], 0.755)],
    [moving(vi.Stop, [0, 0, 1], 0.512, stiffness=12.5), moving(vi.Stop, [0, 1, 0], 0.7, stiffness=3.25)],
    [moving(vi.Gap, [1, 0, -1], 0.512)],
])  # fmt: skip
def test_labels_of_walls_that_move_stand_apart(gaps):
    """Labels with the least and greatest opening of moving walls are long; no two labels overlap."""
    chain_of_three = [[2, -1, 0], [-1, 2, -1], [0, -1, 1]]
    structure = vi.Structure([1] * 3, [0.1] * 3, chain_of_three, gaps)
    ax, _ = sketch_of(structure, vi.Load(1.0, cosine=[1, 0, 0]))
    ax.figure.canvas.draw()
    labels = [text for text in ax.texts if text.get_text()]
    boxes = [text.get_window_extent() for text in labels]
    for i, box in enumerate(boxes):
        for j in range(i):
            width = min(box.x1, boxes[j].x1) - max(box.x0, boxes[j].x0)
            height = min(box.y1, boxes[j].y1) - max(box.y0, boxes[j].y0)
            assert min(width, height) < 0.5, (labels[i].get_text(), labels[j].get_text())


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
    # springs between displayed neighbours, and at both ends; a single body has one spring
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
    """The energy of the modes equals that of the matrices, and the shares add up to 1."""
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


def test_history_of_many_coordinates():
    """Coordinates are stacked: each has its number, all have one scale, and events are on their curves."""
    run = run_of(5)
    ax = run.plot(kind="history")
    times = ax.lines[0].get_xdata()
    q = run.sample(times)[0]
    middle = (q.max(1) + q.min(1)) / 2
    scale = np.ptp(q, axis=1).max() / 3
    for i, values in enumerate(q):
        assert ax.lines[i].get_ydata() == pytest.approx(i + (values - middle[i]) / scale)
    free, coupled = ax.lines[9].get_color(), ax.lines[0].get_color()
    assert [line.get_color() for line in ax.lines[:10]] == [coupled] * 5 + [free] * 5
    assert free != coupled
    texts = [text.get_text() for text in ax.get_legend().get_texts()]
    assert {"coupled", "free masses", "impact", f"one division: {scale:.3g}"} <= {*texts}
    (marks,) = (line for line in ax.lines if line.get_label() == "impact")
    impacts = run.events[run.events["kind"] == "impact"]
    drawn = {*zip(marks.get_xdata(), np.round(marks.get_ydata(), 9), strict=True)}
    here = run.states[:, 0][run.events["kind"] == "impact"]
    for event, state in zip(impacts, here, strict=True):
        for i in np.flatnonzero(run.structure.gaps[event["gap"]].direction):
            assert (event["time"], round(i + (state[i] - middle[i]) / scale, 9)) in drawn
    low, high = ax.get_ylim()
    assert low < marks.get_ydata().min() <= marks.get_ydata().max() < high


def test_energy_of_one_coordinate():
    """A single coordinate has no shares; its energy is that of its displacement and velocity."""
    run = vi.simulate(vi.Structure([2.0], [0.1], [3.0]), duration=5, state=([1.0], [0.5]))
    ax = run.plot(kind="energy")
    times, energy = ax.lines[0].get_data()
    q, rate = run.sample(times)
    assert energy == pytest.approx(rate[0] ** 2 + 1.5 * q[0] ** 2)
    assert ax.get_ylim()[0] == 0
    assert ax.get_xlim() == (0, 5)


def test_times_of_contact_and_of_stick_are_shaded():
    """During a span a stop is compressed or friction does not slide; outside it the reverse holds."""
    stops = [
        vi.Stop([1], 0.5, stiffness=20, damping=2, release="force"),
        vi.Stop([-1], 0.8, stiffness=50),
    ]
    rub = vi.Friction([1], slip=0.5, stick=0.7)
    soft = vi.Structure(mass=[1], damping=[0.1], stiffness=[1], gaps=stops, friction=[rub])
    run = vi.simulate(soft, vi.Load(0.8, cosine=[1.5]), cycles=8)
    spans = spans_of(run)
    assert len(spans["contact"]) > 8
    assert len(spans["stick"]) > 1
    times = np.linspace(run.start, run.end, 4001)[1:-1]
    (q,), (rate,) = run.sample(times)

    def within(kind):
        return np.any([(times > a) & (times < b) for a, b in spans[kind]], axis=0)

    force = np.maximum(20 * (q - 0.5) + 2 * rate, 0) * (q > 0.5) + 50 * np.maximum(-q - 0.8, 0)
    assert np.mean(within("contact") == (force > 0)) > 0.999
    assert np.array_equal(within("stick"), np.abs(rate) < 1e-12)
    run.plot()


def test_spans_of_what_never_changes():
    """A stop that stays compressed, and friction that always sticks, have no events."""
    stop = vi.Stop([1], 0.0, stiffness=1)
    pressed = vi.Structure(mass=[1], damping=[0], stiffness=[1], gaps=[stop])
    run = vi.simulate(pressed, vi.Load(constant=[1.0]), duration=3, state=([0.5], [0]))
    assert spans_of(run)["contact"].tolist() == [[0.0, 3.0]]
    stuck = vi.Structure(mass=[1], damping=[0], stiffness=[1], friction=[vi.Friction([1], slip=2)])
    run = vi.simulate(stuck, vi.Load(1.3, cosine=[1]), cycles=1)
    assert spans_of(run)["stick"].tolist() == [[run.start, run.end]]
    axes = run.plot()
    assert axes[2].get_ylabel() == "sliding speed $s$"


def test_animation(tmp_path):
    image = pytest.importorskip("PIL.Image")
    run = run_of(2)
    path = run.animate(tmp_path / "run.gif", window=(0, 5), seconds=0.5)
    with image.open(path) as picture:
        assert picture.n_frames == 10
    with pytest.raises(vi.ParameterError, match="seconds"):
        run.animate(tmp_path / "run.gif", seconds=0)
    with pytest.raises(
        vi.ParameterError, match=r"seconds = 0\.01: makes 0 pictures at 20 per second; must be 2 to"
    ):
        run.animate(tmp_path / "run.gif", seconds=0.01)


def test_frames_show_the_state_and_the_contact():
    """Dots are at the coordinates by their numbers, and those in contact have the colour of rest."""
    structure = vi.Structure([1, 1], [0.05] * 2, [1, 1], [vi.Gap([1, 0], 0.1, 0.2)])
    load = vi.Load(0.3, sine=[0, 0.1], constant=[1.0, 0])
    run = vi.simulate(structure, load, duration=40)
    (stick,) = run.events[run.events["kind"] == "stick"]
    scene = _Bodies(run, run.start, run.end, plt.subplots(2)[1])
    for time in (0.5 * stick["time"], 30.0):
        scene.show(time)
        q = run.sample([time])[0][:, 0]
        assert np.array_equal(scene.dots.get_offsets(), np.column_stack([[0, 1], q]))
        ends = [segment[1] for segment in scene.stems.get_segments()]
        assert np.array_equal(ends, np.column_stack([[0, 1], q]))
        before = (run.events["time"] <= time) & (run.events["kind"] == "impact")
        assert scene.text.get_text() == f"$t$ = {time:.4g}   impacts: {before.sum()}"
    colours = scene.dots.get_facecolor()
    assert same_color(colours[0], REST)
    assert not same_color(colours[1], REST)


def links(springs, dashpots=(), walls=()):
    """Stiffness and damping of a row of three bodies: links {(i, j): value}, and walls {i: value}."""
    matrices = np.zeros((2, 3, 3))
    for matrix, links in zip(matrices, (springs, dict(dashpots)), strict=True):
        for (i, j), value in links.items():
            matrix[np.ix_([i, j], [i, j])] += value * (2 * np.eye(2) - 1)
    for i, value in dict(walls).items():
        matrices[:, i, i] += value
    return matrices


def sketch_of(structure, load=None):
    _, ax = plt.subplots()
    draw_sketch(ax, structure, load)
    bodies = [p for p in ax.patches if p.get_height() == 1.8 and p.get_facecolor()[3] > 0]
    return ax, [(p.get_x(), p.get_x() + p.get_width()) for p in bodies]


def text_of(ax, words):
    (text,) = (text for text in ax.texts if text.get_text() == words)
    return text


def stops_of(ax):
    """The abscissae of the thick vertical lines, which represent stops."""
    return sorted(line.get_xdata()[0] for line in ax.lines if line.get_lw() == 2.6)


def test_sketch_of_links_beyond_neighbours_and_to_the_ground():
    """A link that spans a body is drawn above it, from middle to middle; one to the ground is below its body."""
    stiffness, damping = links({(0, 1): 2.0, (0, 2): 0.5}, {(1, 2): 0.25}, {1: 0.125, 2: 4.0})
    gap = vi.Gap([1, 0, -1], 0.3)
    ax, boxes = sketch_of(vi.Structure([1, 2, 3], damping, stiffness, [gap]))
    middle = np.mean(boxes, axis=1)
    words = [text.get_text() for text in ax.texts]
    assert [word for word in words if word.startswith("$k$")] == [
        "$k$ = 2", "$k$ = 0.5", "$k$ = 0.125", "$k$ = 4"
    ]  # fmt: skip
    assert [word for word in words if word.startswith("$c$")] == [
        "$c$ = 0.125", "$c$ = 0.25", "$c$ = 4"
    ]  # fmt: skip
    over = [line.get_xdata() for line in ax.lines if line.get_lw() == 0.8]
    assert np.array_equal(over, [middle[[0, 0, 2, 2]]])
    assert text_of(ax, "$k$ = 0.5").get_position()[0] == middle[[0, 2]].mean()
    for words, side in (("$k$ = 0.125", -1), ("$c$ = 0.125", 1)):
        x, y = text_of(ax, words).get_position()
        assert boxes[1][0] < x < boxes[1][1]
        assert (x - middle[1]) * side > 0
        assert y < 0
    # the gap of the outer bodies is below the one between them, with its two stops
    assert text_of(ax, "$e$ = 0.3").get_position()[1] < 0
    assert stops_of(ax) == pytest.approx(middle[[0, 2]].mean() + np.array([-0.3, 0.3]))
    apart = vi.Structure([1, 2, 3], damping, stiffness, [vi.Gap(-gap.direction, 0.3)])
    assert text_of(sketch_of(apart)[0], "$e$ = 0.3 (apart)")


@pytest.mark.parametrize("side", [-1, 1])
def test_sketch_of_fixed_stops(side):
    """A stop of an outer body is a wall next to it; a stop of an inner or held body is a post below it."""
    stiffness, damping = links({(0, 1): 1.0, (1, 2): 1.0}, (), {2 if side < 0 else 0: 0.5})
    outer, inner = np.zeros((2, 3))
    outer[0 if side < 0 else 2], inner[1] = side, side
    gaps = [vi.Gap(outer, 0.2), vi.Gap(inner, 0.4)]
    ax, boxes = sketch_of(vi.Structure([1, 1, 1], damping, stiffness, gaps))
    wall = boxes[2][1] + 1.4 if side > 0 else boxes[0][0] - 1.4
    post, beside = sorted(stops_of(ax), key=lambda x: abs(x - wall), reverse=True)
    assert beside == wall
    low, high = ax.get_xlim()
    assert low < wall < high
    assert (
        min(boxes[0][0], wall) < text_of(ax, "$e$ = 0.2").get_position()[0] < max(boxes[2][1], wall)
    )
    assert boxes[1][0] - 0.8 < post < boxes[1][1] + 0.8
    assert (text_of(ax, "$e$ = 0.4").get_position()[0] - post) * side > 0
    # where a spring holds the body to a wall, its stop is a post too
    held = links({(0, 1): 1.0, (1, 2): 1.0}, (), {0: 0.5})
    ax, _ = sketch_of(vi.Structure([1, 1, 1], held[1], held[0], [vi.Gap([-1, 0, 0], 0.1)]))
    assert text_of(ax, "$e$ = 0.1").get_position()[1] == -0.6


def test_sketch_of_elastic_stops_and_friction():
    """A stop is a plate on a spring; friction is a hatched contact on the ground, a belt, a body or in a slot."""
    stop = vi.Stop([1], 1, stiffness=50)
    ax, boxes = sketch_of(vi.Structure([1], [0.1], [1], [stop], [vi.Friction([1], 0.6, 1, 0.2)]))
    plate = boxes[0][1] + 1.4 - 0.6
    assert stops_of(ax) == pytest.approx([plate])
    springs = [line.get_xdata() for line in ax.lines if line.get_xdata().size == 14]
    assert [(x[0], x[-1]) for x in springs][-1] == pytest.approx((plate, plate + 0.6))
    assert text_of(ax, "$e$ = 1, $k$ = 50")
    assert text_of(ax, "$f$ = 0.6 to 1, belt at 0.2").get_position()[1] < 0
    contacts = [p for p in ax.patches if p.get_hatch() == "xxxxxxx"]
    assert [p.get_y() + p.get_height() for p in contacts] == [0]

    slot = [vi.Gap([-1, 1], 5, 0.7), vi.Gap([1, -1], 5, 0.7)]
    held = vi.Structure([1, 0.1], [0.1, 0], [1, 0], slot, [vi.Friction([-1, 1], 0.02)])
    ax, boxes = sketch_of(held)
    (contact,) = (p for p in ax.patches if p.get_hatch() == "xxxxxxx")
    assert boxes[0][0] < contact.get_x() < contact.get_x() + contact.get_width() < boxes[0][1]
    assert text_of(ax, "$f$ = 0.02")
    slot = [vi.Stop([-1, 1], 5, stiffness=30), vi.Stop([1, -1], 5, stiffness=30)]
    ax, _ = sketch_of(vi.Structure([1, 0.1], [0.1, 0], [1, 0], slot))
    assert [text.get_text() for text in ax.texts].count("5") == 2
    assert [text.get_text() for text in ax.texts].count("$k$ = 30") == 2
    assert sum(line.get_xdata().size == 8 for line in ax.lines) == 2

    two = vi.Structure([1, 1], [0, 0], [[2, -1], [-1, 1]], [], [vi.Friction([-1, 1], 0.02)])
    ax, boxes = sketch_of(two)
    (contact,) = (p for p in ax.patches if p.get_hatch() == "xxxxxxx")
    assert boxes[1][0] < contact.get_x() < contact.get_x() + contact.get_width() < boxes[1][1]


def test_stiffness_of_a_stop_in_a_slot_crosses_no_wall():
    """A long stiffness is written between the slot and the top of its body, on the side of its stop."""
    slot = [vi.Gap([-1, 1], 0.002, 0.7), vi.Stop([1, -1], 0.002, stiffness=8.4e5)]
    ax, ((left, right),) = sketch_of(vi.Structure([2.7, 0.11], [7.4, 0], [4.2e4, 0], slot))
    ax.figure.canvas.draw()
    label = text_of(ax, "$k$ = 8.4e+05").get_window_extent()
    low, high = ax.transData.inverted().transform(label.get_points())
    inner = max(
        (p for p in ax.patches if p.get_facecolor()[:3] == (1, 1, 1)), key=lambda p: p.get_width()
    )
    assert inner.get_y() + inner.get_height() <= low[1]
    assert high[1] <= 1.8
    assert left < low[0] < high[0] < 0.5 * (left + right)


@pytest.mark.parametrize("count", [1, 6])
def test_sketch_of_modes(count):
    """Modal coordinates are not bodies: a block with the frequencies and up to four gaps."""
    omega = [1.0, 6.27, 17.5, 34.4, 56.8][: max(2, count - 1)]
    shapes = [np.arange(1, len(omega) + 1)]
    gaps = [vi.Gap([(-1.0) ** k], 0.05 * (k + 1)) for k in range(count)]
    ax, _ = sketch_of(vi.Structure.from_modes(omega, [0.01] * len(omega), shapes, gaps))
    shown = ", ".join(f"{value:.3g}" for value in omega[:4]) + (", …" if len(omega) > 4 else "")
    words = [text.get_text() for text in ax.texts]
    assert f"linear structure, $n$ = {len(omega)}\n$\\omega$ = {shown}" in words
    assert [word for word in words if word.startswith("gap ")] == [
        f"gap {k}: $e$ = {gap.opening:.3g}" for k, gap in enumerate(gaps[:4])
    ]
    assert ("and 2 more gaps" in words) == (count == 6)
    assert stops_of(ax) == [6.9] * min(count, 4) + [7.8] * min(count, 4)
    low, high = ax.get_ylim()
    assert all(low < y < high for line in ax.lines for y in line.get_ydata())


@pytest.mark.parametrize(("name", "label"), [
    ("frequency", r"$\Omega$"), ("opening", "$e$"), ("opening_2", "$e_{2}$"),
    ("stiffness_0_1", "$K_{0,1}$"), ("damping", "factor of $C$"),
])  # fmt: skip
def test_labels_of_parameters(name, label):
    assert parameter_label(name) == label


@pytest.fixture(scope="module")
def motion():
    """A motion of Table 1 of the 1983 paper as a motion of a structure, periodic by its closed form."""
    phases = [0.517272128279 * np.pi, 1.899298624085 * np.pi]
    gaps = [vi.Gap([-1, 1], 18.5, 0.75), vi.Gap([1, -1], 18.5, 0.75)]
    damper = vi.Structure([1, 0.042], [0.01, 0], [1, 0], gaps)
    return vi.exact(damper, vi.Load(0.94, sine=[1, 0]), (phases, [0, 1]))


def test_branches_are_drawn_whole(motion):
    """Each point of a branch is drawn according to its verdict; an invalid column is named with the valid ones."""
    branch = vi.branch(motion, "frequency", (0.85, 1.1))
    for y, column, label in (
        ("q_max_1", branch.q_max[1], r"$\max q_{1}$"), ("speed_2", branch.speeds[1], "$v_{2}$"),
        ("largest", np.abs(branch.multipliers).max(axis=0), r"$\max|\lambda|$"),
    ):  # fmt: skip
        ax = branch.plot(y=y)
        assert (ax.get_xlabel(), ax.get_ylabel()) == (r"$\Omega$", label)
        curves = {line.get_label(): line for line in ax.lines}
        good, stable = branch.admissible == 1, branch.stable == 1
        for name, here in (("stable", good & stable), ("unstable", good & ~stable)):
            x, values = curves[name].get_data()
            assert np.array_equal(x, branch.values)
            assert np.array_equal(values[here], column[here])
        legend = [text.get_text() for text in ax.get_legend().get_texts()]
        assert {"stable", "unstable"} <= {*legend}
        assert len({*legend}) == len(legend)
    with pytest.raises(vi.ParameterError) as caught:
        branch.plot(y="q_max_2")
    columns = "largest q_max_0 q_max_1 q_min_0 q_min_1 speed_1 speed_2 impulse_1 impulse_2 phase_1 phase_2"
    assert str(caught.value) == "y = 'q_max_2': must be " + ", ".join(map(repr, columns.split()))


def test_zones_are_drawn_whole(motion):
    """The fill of a zone is that of its loops, its label is inside, and each kind of boundary has one entry."""
    zone = vi.zone(motion, x=("frequency", 0.9, 1.1), y=("opening", 5.0, 25.0), lines=9)
    ax = zone.plot(label="RL")
    (fill,) = ax.patches
    corners = fill.get_path().vertices
    assert len(corners) == sum(len(ring) + 1 for ring in zone.loops)
    assert {*map(tuple, corners)} == {tuple(point) for ring in zone.loops for point in ring}
    assert bool(zone.contains(*text_of(ax, "RL").xy))
    pieces = [piece for piece in zone.boundary if piece.type != "window"]
    assert len(ax.lines) == len(pieces) > 0
    for line, piece in zip(ax.lines, pieces, strict=True):
        assert np.array_equal(line.get_xydata(), np.column_stack([piece.x, piece.y]))
    kinds = {condition_name(piece.type) for piece in pieces}
    assert sorted(text.get_text() for text in ax.get_legend().get_texts()) == sorted(kinds)
    assert (ax.get_xlim(), ax.get_ylim()) == ((0.9, 1.1), (5.0, 25.0))
    assert (ax.get_xlabel(), ax.get_ylabel()) == (r"$\Omega$", "$e$")
    # a second zone in the same axes has another colour, and no duplicate entries
    with pytest.raises(vi.ParameterError, match=r"^inverse = True: must be False"):
        zone.plot(inverse=True)
    zone.plot(ax)
    assert not same_color(ax.patches[1].get_facecolor(), fill.get_facecolor())
    assert len(ax.get_legend().get_texts()) == len(kinds)
