"""Charts compared with single points; symmetry, continuity of slots, threads, files and invalid input."""

import math
import sys

import numpy as np
import pytest
import vibroimpact as vi
from shared_motions import searched
from vibroimpact.motions.exact import newton

xarray = pytest.importorskip("xarray")

standard_motion = vi.standard_motion

OSC = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
UNEQUAL = vi.Oscillator(xi=0.01, mu=0.02, restitution=(0.7, 0.6))
RL = vi.Pattern("RL")
R = np.linspace(0.8, 1.2, 33)
D = np.geomspace(2, 200, 31)
#: 1, 0 and -1 of the verdicts
CODE = {True: 1, False: 0, None: -1}


def modulus(motion):
    return np.abs(motion.multipliers)


@pytest.fixture(scope="module")
def pair():
    return vi.chart(OSC, RL, R, D, symmetric=True)


@pytest.fixture(scope="module")
def others():
    return vi.chart(OSC, RL, R, D, symmetric=False)


@pytest.fixture(scope="module")
def three():
    return vi.chart(OSC, vi.Pattern("RRL"), R, D)


@pytest.mark.parametrize("seed", range(8))
def test_equispaced_points(seed):
    """Every point of the closed form equals `equispaced`: general procedures, full period."""
    rng = np.random.default_rng(seed)
    osc = vi.Oscillator(
        xi=rng.choice([0.0, 0.001, 0.02, 0.3]),
        mu=rng.choice([0.0, 0.05, 1.0]),
        restitution=rng.uniform(0.3, 1),
    )
    cycles = int(rng.choice([1, 3]))
    r = np.sort(rng.uniform(0.3, 2.5, 9))
    clearance = np.geomspace(0.1, 30, 10) * rng.uniform(0.5, 2)
    data = vi.chart(osc, vi.Pattern("RL", cycles), r, clearance, symmetric=True)
    quick = vi.chart(osc, vi.Pattern("RL", cycles), r, clearance, symmetric=True, multipliers=False)
    assert np.isnan(quick.multiplier_modulus).all()
    for name in ("consistent", "admissible", "stable", "x_max", "x_min", "tau", "X", "status"):
        assert quick[name].identical(data[name]), name
    seen = 0
    for k, j in np.ndindex(r.size, clearance.size):
        motions = vi.equispaced(osc, r[k], clearance[j], cycles)
        here = data.isel(r=k, clearance=j)
        assert int(here.found) == len(motions) == int((here.status == 0).sum())
        for i, motion in enumerate(motions):
            seen += 1
            item = here.isel(motion=i)
            for name in ("consistent", "admissible", "stable"):
                assert int(item[name]) == CODE[getattr(motion, name)], name
            scale = max(abs(motion.x_max), motion.A)
            assert float(item.x_max) == pytest.approx(motion.x_max, rel=1e-12, abs=1e-12 * scale)
            assert float(item.x_min) == pytest.approx(motion.x_min, rel=1e-12, abs=1e-12 * scale)
            assert float(item.attenuation) == pytest.approx(motion.attenuation, rel=1e-12)
            assert item.X.values == pytest.approx(motion.X, rel=1e-12, abs=1e-12 * scale)
            assert math.remainder(float(item.tau) - motion.tau, 2 * math.pi) == pytest.approx(
                0, abs=1e-12
            )
            assert item.alpha.values == pytest.approx(motion.alpha)
            leading = modulus(motion)[0]
            assert item.multiplier_modulus.values == pytest.approx(
                modulus(motion), rel=1e-7, abs=1e-10 * leading
            )
    assert seen > 30


def test_exact_points(three):
    """Every motion found by continuation over the grid solves the equations; Newton's method does not move it."""
    rng = np.random.default_rng(5)
    places = np.argwhere((three.status == 0).values)
    for i, j, k in places[rng.choice(len(places), 60, replace=False)]:
        item = three.isel(motion=i, clearance=j, r=k)
        r, clearance = float(item.r), float(item.clearance)
        guess = newton(
            OSC, r, clearance, 1.0, vi.Pattern("RRL"), item.X.values,
            item.alpha.values + float(item.tau),
        )  # fmt: skip
        assert guess.X == pytest.approx(item.X.values, rel=1e-9, abs=1e-9 * clearance)
        assert guess.residual < 1e-9
        for name in ("consistent", "admissible", "stable"):
            assert int(item[name]) == CODE[getattr(guess, name)], name
        assert float(item.x_max) == pytest.approx(guess.x_max, rel=1e-9)
        assert item.multiplier_modulus.values == pytest.approx(modulus(guess), rel=1e-6, abs=1e-8)
        # det[P] = exp(-4 pi xi k/r) prod R^2
        product = np.prod(item.multiplier_modulus.values)
        assert product == pytest.approx(math.exp(-4 * math.pi * OSC.xi / r) * 0.75**6, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(("sides", "cycles"), [("RL", 1), ("RRL", 1), ("RRLL", 1), ("RL", 2)])
def test_nothing_missed(sides, cycles):
    """The chart contains the motions that an independent, denser search finds at random points."""
    pattern = vi.Pattern(sides, cycles)
    data = vi.chart(OSC, pattern, R, D, slots=12)
    rng = np.random.default_rng(7)
    seen = 0
    for _ in range(40):
        j, k = rng.integers(16), rng.integers(R.size)
        here = data.isel(r=k, clearance=j)
        known = here.X.values[:, (here.status == 0).values]
        for motion in searched(OSC, R[k], D[j], pattern, 200):
            if not motion.admissible or len(standard_motion(motion).pattern) < len(pattern):
                continue
            seen += 1
            turns = [np.roll(motion.X, -i) for i in range(len(pattern))]
            gaps = [np.abs(known.T - turn).max(axis=1).min(initial=np.inf) for turn in turns]
            assert min(gaps) < 1e-6 * D[j], (R[k], D[j], motion)
    assert seen > 5 or cycles == 2


def test_pairs_and_others(pair, others):
    """`symmetric=None` gives both families; unsymmetric motions come with their mirror images."""
    both = vi.chart(OSC, RL, R, D)
    first, rest = both.isel(motion=slice(2)), both.isel(motion=slice(2, None))
    for name in pair.data_vars:
        if "motion" in pair[name].dims and name != "status":
            assert first[name].equals(pair[name]), name
            assert rest[name].equals(others[name]), name
    assert both.found.equals(pair.found + others.found)
    assert (others.found % 2 == 0).all()
    one, other = others.isel(motion=0), others.isel(motion=1)
    there = (one.status == 0).values
    assert there.sum() > 200
    assert ((other.status == 0).values == there).all()
    for name in ("admissible", "stable"):
        assert (one[name] == other[name]).all()
    assert one.x_max.values[there] == pytest.approx(-other.x_min.values[there], rel=1e-7)
    # the mirror image starts with the other wall: X_1, X_2 become -X_2, -X_1
    assert one.X.values[0][there] == pytest.approx(-other.X.values[1][there], rel=1e-6, abs=1e-6)
    assert not np.isclose(one.X.values.sum(axis=0)[there], 0, atol=1e-6).any()


def test_mirrored_system():
    """With walls and letters exchanged the motions are mirrored, possibly in other slots."""
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))
    turned = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.61, 0.75))
    r, d = np.linspace(0.85, 1.1, 14), np.geomspace(2, 40, 13)
    for sides, image in (("RL", "LR"), ("RRL", "LLR")):
        one = vi.chart(osc, vi.Pattern(sides), r, d)
        other = vi.chart(turned, vi.Pattern(image), r, d)
        assert one.found.equals(other.found)
        assert int(one.found.sum()) > 50
        for name in ("x_max", "multiplier_modulus"):
            mirrored = -other.x_min if name == "x_max" else other[name]
            a, b = (np.sort(np.nan_to_num(item.values), axis=-3) for item in (one[name], mirrored))
            assert a == pytest.approx(b, rel=1e-6, abs=1e-8), name


def test_pattern_from_the_left(pair):
    """LR is RL counted from the other impact."""
    left = vi.chart(OSC, vi.Pattern("LR"), R, D, symmetric=True)
    assert left.x_max.equals(pair.x_max)
    assert np.array_equal(left.X.values, pair.X.values[::-1], equal_nan=True)
    shift = (left.tau - pair.tau).values
    assert np.abs(shift[~np.isnan(shift)]) == pytest.approx(math.pi)
    assert [str(side) for side in left.side.values] == ["L", "R"]


@pytest.mark.parametrize("sides", ["RL", "RRL", "RRLL"])
def test_slots_are_continuous(sides):
    """Refining the grid makes the steps within a slot smaller: no slot jumps between motions."""
    worst = []
    for n in (41, 81):
        r, clearance = np.linspace(0.85, 0.93, n), np.geomspace(4, 12, n)
        data = vi.chart(OSC, vi.Pattern(sides), r, clearance, slots=12)
        there = (data.status == 0).values
        assert (there.sum(axis=0) == data.found).all()  # there was a slot for each
        x = data.X.values / data.clearance.values[:, None]
        tau = np.exp(1j * data.tau.values)
        steps = []
        for axis in (-1, -2):
            both = np.logical_and(
                np.take(there, range(1, n), axis), np.take(there, range(n - 1), axis)
            )
            steps += [np.abs(np.diff(part, axis=axis))[both] for part in (*x, tau)]
        worst.append(np.sort(np.concatenate(steps))[::-1])
    # at a fold the steps shrink with the square root of the grid's step, elsewhere in proportion to it
    assert worst[1][0] < 0.45
    assert np.quantile(worst[1], 0.99) < 0.6 * np.quantile(worst[0], 0.99)


def test_best_motions_come_first():
    """With a single slot, the chart keeps an admissible and stable motion wherever one exists."""
    pattern = vi.Pattern("RRL")
    one, many = (vi.chart(OSC, pattern, R, D, slots=slots) for slots in (1, 8))
    assert (one.sizes["motion"], many.sizes["motion"]) == (1, 8)
    good = [((item.admissible == 1) & (item.stable == 1)).any("motion") for item in (one, many)]
    assert int(good[1].sum()) > 30
    assert good[0].equals(good[1])


def test_threads():
    """The same bits for any number of threads."""
    for pattern in (RL, vi.Pattern("RRLL")):
        charts = [vi.chart(OSC, pattern, R[::2], D[::2], threads=n) for n in (1, 2, 5)]
        for other in charts[1:]:
            assert other.identical(charts[0])


@pytest.mark.parametrize("engine", ["h5netcdf", "scipy"])
def test_netcdf(tmp_path, three, engine):
    """A chart is unchanged by saving; units, names and parameters are in the file."""
    pytest.importorskip(engine)
    path = tmp_path / "chart.nc"
    three.to_netcdf(path, engine=engine)
    with xarray.open_dataset(path, engine=engine, decode_cf=False) as back:
        back.load()
    for name in three.data_vars:
        assert np.array_equal(back[name].values, three[name].values, equal_nan=True), name
        assert back[name].attrs["units"]
        assert back[name].attrs["long_name"]
    assert back.stable.dtype == np.int8
    assert back.attrs["xi"] == OSC.xi
    assert (back.attrs["R1"], back.attrs["R2"]) == OSC.restitution
    assert (back.attrs["sides"], back.attrs["cycles"]) == ("RRL", 1)
    for axis in ("r", "clearance"):
        assert {"units", "long_name"} <= set(back[axis].attrs)


def test_resonance_without_damping():
    """A singular column of a chart has a status, and the other columns are computed."""
    osc = vi.Oscillator(xi=0.0, mu=0.05, restitution=0.8)
    data = vi.chart(osc, RL, [0.9, 1.0, 1.1], [1.0, 5.0], symmetric=True)
    assert (data.status.sel(r=1.0) == 1).all()
    assert (data.status.sel(r=0.9) == 0).any()
    assert np.isnan(data.x_max.sel(r=1.0)).all()
    assert (data.stable.sel(r=1.0) == -1).all()
    everything = vi.chart(osc, RL, [0.9, 1.0, 1.1], [1.0, 5.0])
    assert (everything.status.sel(r=1.0) != 0).all()


class Impatient:
    """A `progress` function that interrupts a study when a share of the work is done."""

    def __init__(self, share):
        self.share = share

    def __call__(self, done, what):
        if done > self.share:
            raise KeyboardInterrupt


def test_interrupt(monkeypatch):
    """After Ctrl-C the finished columns have the same bits as in a complete chart, and the rest is marked."""
    monkeypatch.setattr("vibroimpact.base.interrupt.INTERVAL", 0.0005)
    r, clearance = np.linspace(0.8, 1.2, 800), np.geomspace(2, 200, 400)
    with pytest.raises(vi.errors.StudyInterrupted) as caught:
        vi.chart(OSC, RL, r, clearance, symmetric=True, progress=Impatient(0.1))
    part = caught.value.result
    assert part.attrs["complete"] == 0
    done = (part.status != 12).all(["motion", "clearance"]).values
    assert 0 < done.sum() < r.size
    assert (part.status == 12).all(["motion", "clearance"]).values[~done].all()
    whole = vi.chart(OSC, RL, r[done], clearance, symmetric=True)
    assert part.isel(r=done).drop_attrs().identical(whole.drop_attrs())
    assert "stopped" in vi.status_text(12)


def test_interrupted_continuation(monkeypatch):
    """A stop during the continuation keeps all motions found so far, and marks the other points."""
    monkeypatch.setattr("vibroimpact.base.interrupt.INTERVAL", 0.0005)
    with pytest.raises(vi.errors.StudyInterrupted) as caught:
        vi.chart(OSC, vi.Pattern("RRL"), R, D, progress=Impatient(0.6))
    part = caught.value.result
    assert set(np.unique(part.status)) == {0, 12}
    pytest.importorskip("matplotlib")
    from vibroimpact.plot import draw_chart

    (legend,) = [draw_chart(part).get_legend()]
    names = [text.get_text() for text in legend.get_texts()]
    assert names[-1] == "not reached, or no motion"


def test_missing_xarray(monkeypatch):
    """Without xarray the error names the extra that installs it."""
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(vi.errors.MissingExtraError, match=r"vibroimpact\[data\]"):
        vi.chart(OSC, RL, R, D)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"r": []}, "r of shape"),
        ({"r": [0.9, math.nan]}, "r = 0.9, nan: must be"),
        ({"r": [0.9, math.inf]}, "r = 0.9, inf: must be"),
        (
            {"r": [0.9, 1.1, 1.0]},
            "must be increasing or decreasing numbers .*number 3 must be above number 2",
        ),
        ({"clearance": [1.0, 1.0]}, "clearance = 1.0, 1.0: must be increasing"),
        ({"clearance": [-1.0, 1.0]}, r"clearance\[0\] = -1.0: must be"),
        ({"clearance": [[1.0, 2.0]]}, "clearance of shape"),
        (
            {"r": np.linspace(0.5, 1, 2000), "clearance": np.linspace(1, 2, 2000)},
            "clearance = 2000: .*r x clearance <= 1000000; r is 2000",
        ),
        (
            {"r": np.linspace(0.5, 1, 999), "clearance": np.linspace(1, 2, 999), "slots": 32},
            "slots",
        ),
        (
            {"pattern": vi.Pattern("RL", 2), "symmetric": True},
            "symmetric = True: .*half mirrors the first",
        ),
        (
            {"osc": vi.Oscillator(xi=0.01, mu=0.02, restitution=(0.7, 0.6)), "symmetric": True},
            "symmetric = True: .*half mirrors the first",
        ),
        ({"pattern": vi.Pattern("RL*")}, "exact and find"),
        ({"pattern": vi.Pattern("RL" * 7)}, "pattern = .*2 to 12 of them"),
        ({"clearance": [-math.inf, 20.0]}, "clearance = -inf, 20.0: must be increasing"),
        ({"slots": 0}, "slots = 0"),
        ({"guesses": 0}, "guesses = 0"),
        ({"seeds": 0}, "seeds = 0"),
        ({"threads": 0}, "threads = 0"),
    ],
)
def test_bad_input(change, words):
    """An invalid argument raises one error that names it, and nothing is computed."""
    given = {"osc": OSC, "pattern": RL, "r": R, "clearance": D} | change
    with pytest.raises(vi.errors.ParameterError, match=words):
        vi.chart(**given)


@pytest.mark.parametrize(
    "change",
    [
        {"r": ["a"]},
        {"osc": 1},
        {"pattern": 7},
        {"slots": "4"},
        {"symmetric": "yes"},
        {"multipliers": "no"},
        {"progress": 5},
    ],
)
def test_bad_types(change):
    """A wrong type raises a TypeError."""
    given = {"osc": OSC, "pattern": RL, "r": R, "clearance": D} | change
    with pytest.raises(vi.errors.ParameterTypeError):
        vi.chart(**given)


def test_plot(pair, three):
    """The picture has the right axes, classes and colours."""
    pytest.importorskip("matplotlib").use("Agg")
    from vibroimpact.plot import draw_chart
    from vibroimpact.plot.chart import classes

    kind = classes(pair)
    assert set(np.unique(kind)) == {0, 1, 2, 3}
    for j, k in ((0, 0), (10, 16), (20, 3), (30, 5)):
        motions = vi.equispaced(OSC, R[k], D[j])
        best = max((1 + bool(m.admissible) * (1 + bool(m.stable)) for m in motions), default=0)
        assert kind[j, k] == best
    ax = draw_chart(pair)
    assert ax.get_ylabel() == "$dK/F_0$"
    assert ax.get_xlabel() == r"$r = \Omega/\omega$"
    assert ax.get_yscale() == "log"
    assert len(ax.get_legend().get_patches()) == 4
    hatches = {patch.get_hatch() for patch in ax.get_legend().get_patches()}
    assert len(hatches) == 3
    ax = draw_chart(pair, inverse=True)
    assert ax.get_ylabel() == "$F_0/(dK)$"
    low, high = ax.get_ylim()
    assert low < 1 / 200 < 1 / 2 < high
    for color in ("multiplier", "attenuation"):
        assert len(draw_chart(three, color=color).figure.axes) == 2
    quick = vi.chart(OSC, RL, R, D, symmetric=True, multipliers=False)
    with pytest.raises(vi.errors.ParameterError, match="without"):
        draw_chart(quick, color="multiplier")
    with pytest.raises(vi.errors.ParameterTypeError):
        draw_chart(OSC)
    with pytest.raises(vi.errors.ParameterError):
        draw_chart(pair, color="red")
    draw_chart(pair.isel(r=[3]))


def test_progress(monkeypatch):
    """The share of progress rises from 0 to 1, and no result changes."""
    monkeypatch.setattr("vibroimpact.base.interrupt.INTERVAL", 0.001)
    shares = []
    message = vi.chart(OSC, RL, R, D, progress=lambda done, what: shares.append((done, what)))
    assert shares == sorted(shares)
    assert shares[-1][0] == 1
    assert message.identical(vi.chart(OSC, RL, R, D))
