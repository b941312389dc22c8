"""All studies of attractors: invalid input, tables and pictures, Ctrl-C and progress."""

import importlib

import numpy as np
import pytest
import vibroimpact as vi
from shared_systems import FIGURE6, TABLE


@pytest.mark.parametrize(
    ("call", "word"),
    [
        (lambda: vi.lyapunov(FIGURE6, 1.04, 10.0, cycles=10), "cycles"),
        (lambda: vi.lyapunov(FIGURE6, 1.04, -1.0), "clearance"),
        (lambda: vi.lyapunov(FIGURE6, [1.0, 1.1], [1.0, 2.0, 3.0]), "the same shape"),
        (lambda: vi.lyapunov(FIGURE6, 1.04, 10.0, state={"y": 0}), "state"),
        (lambda: vi.bifurcation_diagram(FIGURE6, "D", [1, 2], r=1.0), "parameter"),
        (lambda: vi.bifurcation_diagram(FIGURE6, "r", [1, 1.1]), "clearance"),
        (lambda: vi.bifurcation_diagram(FIGURE6, "r", [1, 1.1], r=1.0, clearance=9), "left out"),
        (lambda: vi.bifurcation_diagram(FIGURE6, "r", [1], clearance=9), "values"),
        (lambda: vi.bifurcation_diagram(FIGURE6, "R1", [0.5, 1.5], 1.0, 9.0), "R1"),
        (lambda: vi.bifurcation_diagram(FIGURE6, "r", [1, 1.1], clearance=9, sweep="x"), "sweep"),
        (lambda: vi.spaced(1, 2, 5, "equal"), "spacing"),
        (lambda: vi.spaced(2, 1, 5), "low below high"),
        (lambda: vi.spaced(0, 1, 5, "geometric"), "positive"),
        (lambda: vi.spaced(0, 1, 1), "n = 1"),
        (lambda: vi.basins(FIGURE6, 1.04, 10.0), "exactly one must be given"),
        (lambda: vi.basins(FIGURE6, 1.04, 10.0, (("z", 0, 1, 5), ("x", 0, 1, 5))), "two of 'x'"),
        (
            lambda: vi.basins(FIGURE6, 1.04, 10.0, (("x", 1, 0, 5), ("y", 0, 1, 5))),
            "plane: high = .* must be two numbers from -1e100 to 1e100",
        ),
        (
            lambda: vi.basins(FIGURE6, 1.04, 10.0, (("x", 0, 1, 5), ("y", 0, 9, 5))),
            "half the clearance",
        ),
        (lambda: vi.basins(FIGURE6, 1.04, 10.0, states=0), "states"),
        (lambda: vi.basins(FIGURE6, 1.04, 10.0, states=9, rng=-1), "rng"),
        (lambda: vi.basins(FIGURE6, 1.04, 10.0, states=9, rng=2**31), "rng"),
        (
            lambda: vi.basins(FIGURE6, 1.04, 10.0, states=9, fixed={"x": 1}),
            "fixed .* used only with plane",
        ),
        (
            lambda: vi.basins(
                FIGURE6, 1.04, 10.0, (("x", 0, 1, 5), ("y", 0, 1, 5)), fixed={"x": 1}
            ),
            "it is an axis",
        ),
        (
            lambda: vi.response(FIGURE6, [1.0]),
            "clearance: is missing; .* or give inverse_clearance",
        ),
        (lambda: vi.response(FIGURE6, [1.0], clearance=-1.0), "1e-12 <= clearance"),
        (lambda: vi.response(FIGURE6, [1.0], clearance=9.0, load=0), "load"),
    ],
)
def test_bad_input_is_named(call, word):
    with pytest.raises((vi.errors.ParameterError, vi.errors.ParameterTypeError), match=word):
        call()


def test_tables_and_pictures():
    """Every study has a labelled table and a picture with labelled axes, drawn into the given axes."""
    xarray = pytest.importorskip("xarray")
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    plt = (
        matplotlib.pyplot
        if hasattr(matplotlib, "pyplot")
        else __import__("matplotlib.pyplot").pyplot
    )
    plane = vi.basins(TABLE, 0.94, 37.0, (("x", -30, 30, 12), ("x_dot", -30, 30, 12)))
    sweeps = vi.bifurcation_diagram(FIGURE6, "clearance", np.arange(10.0, 75.0, 5.0), r=1.04)
    results = [
        vi.lyapunov(FIGURE6, 1.04, np.linspace(6, 40, 4), cycles=200),
        sweeps,
        plane,
        vi.response(FIGURE6, [1.0, 1.02], clearance=25.0, states=4),
    ]
    for result in results:
        assert isinstance(result.to_xarray(), xarray.Dataset)
        figure, ax = plt.subplots()
        assert result.plot(ax=ax) is ax
        assert ax.get_xlabel()
        assert ax.get_ylabel()
        plt.close(figure)
    table = plane.to_xarray()
    np.testing.assert_array_equal(table["label"].transpose("x", "x_dot"), plane.labels)
    table = sweeps.to_xarray()
    np.testing.assert_array_equal(table["clearance"], sweeps.values)
    with pytest.raises(vi.errors.ParameterError, match="quantity"):
        sweeps.plot(quantity="colour")


def stopped(monkeypatch, study, *arguments, **more):
    """The partial result of a study that is stopped after about a third of its work."""
    monkeypatch.setattr(importlib.import_module("vibroimpact.base.interrupt"), "INTERVAL", 0.001)

    def progress(share, what):
        if share > 0.3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as stop:
        study(*arguments, **more, progress=progress)
    return stop.value.result


@pytest.mark.slow
def test_stopped_lyapunov(monkeypatch):
    """The finished points have the bits of the complete line."""
    line = np.linspace(10, 24, 300)
    part = stopped(monkeypatch, vi.lyapunov, FIGURE6, 1.04, line, cycles=4000)
    whole = vi.lyapunov(FIGURE6, 1.04, line, cycles=4000)
    at = np.searchsorted(line, part.clearance)
    assert 0 < part.r.size < line.size
    np.testing.assert_array_equal(part.clearance, line[at])
    np.testing.assert_array_equal(part.exponents, whole.exponents[:, at])
    np.testing.assert_array_equal(part.impacts, whole.impacts[at])
    assert part.cut == f"{part.r.size} of 300 points were reached"
    assert (part.complete, whole.complete, whole.cut) == (False, True, "")


def test_stopped_response(monkeypatch):
    """The finished frequency ratios have the bits of the complete curve."""
    r = np.linspace(1.0, 1.02, 200)
    part = stopped(monkeypatch, vi.response, FIGURE6, r, 33.0, states=12)
    whole = vi.response(FIGURE6, r, 33.0, states=12)
    at = np.searchsorted(r, part.r)
    assert 0 < part.r.size < r.size
    np.testing.assert_array_equal(part.attenuation, whole.attenuation[at])
    np.testing.assert_array_equal(part.highest, whole.highest[at])
    assert part.cut == f"{part.r.size} of 200 points were reached"
    assert (part.complete, whole.complete, whole.cut) == (False, True, "")


def test_stopped_bifurcation(monkeypatch):
    """Stopped sweeps have the impacts of the complete diagram at the finished values, and none at the others."""
    values = np.linspace(50, 75, 400)
    part = stopped(monkeypatch, vi.bifurcation_diagram, FIGURE6, "clearance", values, r=1.04)
    whole = vi.bifurcation_diagram(FIGURE6, "clearance", values, r=1.04)
    done = part.status == 0
    assert 0 < done.sum() < done.size
    assert vi.status_text(int(part.status.max())) == "the computation was stopped before this point"
    # up from the left, down from the right
    assert (np.diff(done[0].astype(int)) <= 0).all()
    assert (np.diff(done[1].astype(int)) >= 0).all()
    there = done[whole.points["run"], whole.points["index"]]
    assert part.points.tolist() == whole.points[there].tolist()
    assert (part.cycles[~done] == 0).all()
    assert np.isnan(part.x_max[~done]).all()
    # complete windows are windows of the whole diagram, and cut windows are parts of them
    assert set(part.windows) < set(whole.windows)
    for run, low, high, label in part.cut_windows:
        assert any(
            (window.run, window.label) == (run, label) and window.low <= low and high <= window.high
            for window in whole.windows
        )
    assert part.cut_windows
    assert not whole.cut_windows
    assert not part.coexisting[~done.all(axis=0)].any()
    assert (part.complete, whole.complete) == (False, True)


def test_stopped_basins(monkeypatch):
    """Decided states have the attractors of the complete result; shares are those of the states reached."""
    plane = (("x", -30, 30, 120), ("x_dot", -30, 30, 120))
    part = stopped(monkeypatch, vi.basins, TABLE, 0.94, 37.0, plane)
    whole = vi.basins(TABLE, 0.94, 37.0, plane)
    done = part.labels >= 0
    assert 0 < done.sum() < done.size

    def ends(result, where):
        x = np.array([item.motion.X[0] if item.motion else np.nan for item in result.attractors])
        return x[result.labels[where]]

    np.testing.assert_array_equal(ends(part, done), ends(whole, done))
    reached = part.labels != -2
    assert done.sum() <= reached.sum() == part.reached < done.size
    assert part.fractions.sum() == pytest.approx(done[reached].mean(), rel=1e-12)
    assert part.standard_error[0] > whole.standard_error[0]
    assert (whole.labels != -2).all()
    assert (part.complete, whole.complete) == (False, True)
    with pytest.raises(vi.errors.ParameterError, match="must be the whole plane"):
        _ = part.uncertainty_exponent


def test_stopped_before_anything(monkeypatch):
    """A single point has no partial result: stopping it raises a plain KeyboardInterrupt."""
    monkeypatch.setattr(importlib.import_module("vibroimpact.base.interrupt"), "INTERVAL", 0.001)

    def progress(share, what):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as stop:
        vi.lyapunov(FIGURE6, 1.04, 20.0, cycles=10**8, progress=progress)
    assert not isinstance(stop.value, vi.errors.StudyInterrupted)


def test_progress_changes_nothing(monkeypatch):
    """The share of progress rises from 0 to 1, and the result has the same bits as without `progress`."""
    monkeypatch.setattr(importlib.import_module("vibroimpact.base.interrupt"), "INTERVAL", 0.001)
    shares = []
    line = np.linspace(10, 24, 100)
    message = vi.lyapunov(
        FIGURE6, 1.04, line, cycles=2000, progress=lambda share, what: shares.append(share)
    )
    assert shares == sorted(shares)
    assert 0 <= shares[0] <= shares[-1] <= 1
    np.testing.assert_array_equal(
        message.exponents, vi.lyapunov(FIGURE6, 1.04, line, 2000).exponents
    )
