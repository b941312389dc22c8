"""Animations: positions of the masses, flashes of the walls, and how the file is written."""

import subprocess
import sys

import numpy as np
import pytest
import vibroimpact as vi
from shared_motions import COLUMN
from shared_simulations import settled
from shared_systems import RIG, TABLE, TURN

matplotlib = pytest.importorskip("matplotlib")
matplotlib.use("Agg")
import matplotlib.animation  # noqa: E402
import matplotlib.pyplot as plt  # noqa: E402
from PIL import Image  # noqa: E402
from vibroimpact.plot import animation, style  # noqa: E402
from vibroimpact.plot.history import history  # noqa: E402


@pytest.fixture(autouse=True)
def _closed():
    """Close all figures after each test."""
    yield
    plt.close("all")


def scene_of(thing, cycles):
    """The artists, and the window."""
    window = history(thing, cycles)
    return animation._Scene(thing, window, plt.subplots(2)[1]), window


@pytest.mark.parametrize("which", range(2))
def test_masses_stand_to_scale(which):
    """The gaps between the free mass and the walls are d/2 + Y on the left and d/2 - Y on the right."""
    thing = (vi.exact(TABLE, 0.94, 37.0, COLUMN), settled(3))[which]
    scene, window = scene_of(thing, 1)
    for time in np.linspace(window.first, window.last, 12, endpoint=False):
        scene.show(time)
        now = thing.sample(time)
        left, right = scene.walls
        faces = left.get_x() + left.get_width(), right.get_x()
        free = scene.free.get_x(), scene.free.get_x() + scene.free.get_width()
        half = 0.5 * thing.clearance
        assert free[0] - faces[0] == pytest.approx(half + float(now.Y), abs=1e-9 * half)
        assert faces[1] - free[1] == pytest.approx(half - float(now.Y), abs=1e-9 * half)
        assert sum(faces) / 2 == pytest.approx(float(now.X), abs=1e-9 * half)


def test_load_phase_is_that_of_the_load():
    """The sine of the displayed phase is the load, at the beginning of the window too."""
    for thing in (vi.exact(TABLE, 0.94, 37.0, COLUMN), settled(3)):
        window = history(thing, 1)
        assert np.sin(window.phase) == pytest.approx(
            float(thing.sample(window.first).load), abs=1e-9
        )


def test_the_wall_that_is_hit_flashes():
    """Just after an impact its wall is at full brightness and the other one is not; then it fades."""
    motion = vi.exact(TABLE, 0.94, 37.0, COLUMN)
    events = motion.events
    for event in events:
        state = animation.glow(events, event["time"], 0.1)
        bright = (state.right, state.left) if event["side"] == "R" else (state.left, state.right)
        assert bright == (1, 0)
        later = animation.glow(events, event["time"] + 0.05, 0.1)
        assert max(later.left, later.right) == pytest.approx(0.5)
        assert animation.glow(events, event["time"] + 0.11, 0.1) == (0, 0, 0)


def test_the_wall_of_a_rest_has_its_colour():
    """From stick to release the wall in contact has the colour of rest, even if the window begins in a rest."""
    run = settled(4)
    events = run.events
    (stick,) = np.flatnonzero(events["kind"] == "stick")[:1]
    begin, end = events["time"][stick : stick + 2]
    side = 1 if events["side"][stick] == "R" else -1
    assert events["kind"][stick + 1] == "release"
    assert animation.glow(events, 0.5 * (begin + end), 1e-9).rest == side
    assert animation.glow(events, end, 1e-9).rest == 0
    cycles = (run.final_state["t"] - 0.5 * (begin + end)) * run.r / TURN
    assert history(run, cycles).resting == side
    scene, window = scene_of(run, cycles)
    scene.flash = 1e-9
    scene.show(window.first)
    wall = scene.walls[side > 0].get_facecolor()
    assert wall == matplotlib.colors.to_rgba(style.REST)


def test_gif(tmp_path):
    """The GIF has the requested number of frames and frame rate, and loops; the folder holds nothing else."""
    motion = vi.exact(TABLE, 0.94, 37.0, COLUMN)
    path = motion.animate(tmp_path / "pair.gif", seconds=0.2)
    assert path == tmp_path / "pair.gif"
    assert [item.name for item in tmp_path.iterdir()] == ["pair.gif"]
    with Image.open(path) as film:
        assert film.n_frames == 0.2 * animation.RATE
        assert film.info["duration"] == 1000 / animation.RATE
        assert film.info["loop"] == 0
    assert plt.get_fignums() == []


@pytest.mark.slow
def test_mp4(tmp_path, monkeypatch):
    """ffmpeg from imageio-ffmpeg writes as many frames as the GIF has, and its previous path is restored."""
    program = pytest.importorskip("imageio_ffmpeg").get_ffmpeg_exe()
    monkeypatch.setenv("PATH", "")
    setting = matplotlib.rcParams["animation.ffmpeg_path"]
    motion = vi.exact(TABLE, 0.94, 37.0, COLUMN)
    path = motion.animate(tmp_path / "pair.mp4", seconds=0.5)
    assert [item.name for item in tmp_path.iterdir()] == ["pair.mp4"]
    assert matplotlib.rcParams["animation.ffmpeg_path"] == setting
    raw = subprocess.run(
        [program, "-i", path, "-f", "rawvideo", "-pix_fmt", "rgb24", "-"],
        capture_output=True,
        check=True,
    ).stdout
    pictures = np.frombuffer(raw, np.uint8).reshape(-1, 360, 600, 3).astype(float)
    assert len(pictures) == 0.5 * animation.RATE
    with Image.open(motion.animate(tmp_path / "pair.gif", seconds=0.5)) as film:
        for i in range(len(pictures)):
            film.seek(i)
            distances = [np.abs(other - np.array(film.convert("RGB"))).mean() for other in pictures]
            assert np.argmin(distances) == i
            assert distances[i] < 4


def test_without_a_path_a_notebook_gets_it():
    """Without a path `animate` returns matplotlib's animation, and leaves the caller's settings unchanged."""
    before = dict(matplotlib.rcParams)
    film = settled(2).animate(cycles=1, seconds=0.1)
    assert isinstance(film, matplotlib.animation.FuncAnimation)
    assert film.to_jshtml().count("data:image/png") == 2
    assert dict(matplotlib.rcParams) == before


def test_interrupted_film_leaves_the_old_one(tmp_path, monkeypatch):
    """If writing is interrupted, the earlier file remains and no part of the new one."""
    path = tmp_path / "film.gif"
    path.write_text("old")

    show, shown = animation._Scene.show, []

    def broken(self, time):
        if shown:
            raise KeyboardInterrupt
        shown.append(time)
        show(self, time)

    monkeypatch.setattr(animation._Scene, "show", broken)
    with pytest.raises(KeyboardInterrupt):
        settled(2).animate(path, cycles=1, seconds=0.1)
    assert [item.read_text() for item in tmp_path.iterdir()] == ["old"]


@pytest.mark.parametrize(("words", "output"), [
    ({"path": "film.avi"}, r"path = 'film.avi': must end with .gif or .mp4"),
    ({"path": "film"}, r"path = 'film': must end"), ({"path": 3}, "path = 3"),
    ({"cycles": 0}, "cycles = 0"), ({"cycles": 1, "seconds": -1}, "seconds = -1"),
    ({"cycles": 1, "seconds": 1e6}, "seconds = 1e"), ({"cycles": 1, "seconds": 1e-3}, "pictures"),
])  # fmt: skip
def test_wrong_arguments(words, output):
    """Invalid arguments are refused by name, before anything is drawn."""
    with pytest.raises(vi.errors.VibroimpactError, match=output):
        vi.simulate(RIG, 0.9, 6.0, 2).animate(**words)
    assert plt.get_fignums() == []


def test_missing_writers(tmp_path, monkeypatch):
    """Without Pillow or ffmpeg the error names what each file suffix requires."""
    run = vi.simulate(RIG, 0.9, 6.0, 2)
    monkeypatch.setenv("PATH", "")
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(vi.errors.MissingExtraError, match="ffmpeg"):
        run.animate(tmp_path / "film.mp4")
    monkeypatch.setitem(sys.modules, "PIL.Image", None)
    with pytest.raises(vi.errors.MissingExtraError, match="Pillow"):
        run.animate(tmp_path / "film.gif")
    assert not list(tmp_path.iterdir())
