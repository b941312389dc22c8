"""Free vibration: energy, the limits without impacts and without damping, symmetry and scaling."""

import importlib
import itertools
import math

import numpy as np
import pytest
import vibroimpact as vi
from shared_structures import one_stop
from vibroimpact.base.errors import ParameterError, ParameterTypeError

DAMPER = vi.Oscillator(xi=0.005, mu=0.1, restitution=0.75)
UNEVEN = vi.Oscillator(xi=0.02, mu=0.3, restitution=(0.4, 0.9))
STICKY = vi.Oscillator(xi=0.01, mu=0.2, restitution=0.0)
COLUMNS = ("time", "x", "decrement", "damping", "energy", "impacts", "rests", "run")
#: An initial state without zeros that is not at a peak.
START = {"amplitude": -0.8, "x_dot": 0.45, "y": 0.1, "z_dot": -0.6}


def simulated(osc, clearance, last, amplitude=1.0, x_dot=0.0, y=0.0, z_dot=0.0):
    """The same vibration by `simulate`, to a later time; without load the frequency ratio only scales the time."""
    start = {"t": 0, "x": amplitude, "x_dot": x_dot, "z": amplitude + y, "z_dot": z_dot}
    return vi.simulate(osc, 0.7, clearance, 0.7 * (last + 1) / (2 * math.pi), start, load=0)


def viscous(osc, trajectory, first, last):
    """Energy dissipated in the dashpot between two times, by Gauss's rule over the segments between events."""
    nodes, weights = np.polynomial.legendre.leggauss(24)
    inside = trajectory.events["time"]
    ends = np.unique([first, *inside[(inside > first) & (inside < last)], last])
    steps = [np.linspace(a, b, 2 + int(b - a)) for a, b in itertools.pairwise(ends)]
    loss = 0.0
    for knots in steps:
        for a, b in itertools.pairwise(knots):
            speed = trajectory.sample(a + (b - a) * (nodes + 1) / 2).X_dot
            loss += (b - a) / 2 * weights @ (2 * osc.xi * speed**2)
    return loss


def kinetic(osc, events, when):
    """Kinetic energy of both masses before or after events."""
    return 0.5 * (events[f"x_dot_{when}"] ** 2 + osc.mu * events[f"z_dot_{when}"] ** 2)


@pytest.mark.parametrize(("osc", "clearance", "start"), [
    (DAMPER, 0.7, {}), (DAMPER, 0.05, {}), (UNEVEN, 0.9, START), (STICKY, 0.5, {}),
    (vi.Oscillator(xi=0.3, mu=2.0, restitution=0.6), 0.4, START),
    (vi.Oscillator(xi=0.01, mu=0.0, restitution=0.8), 0.6, {}),
])  # fmt: skip
def test_energy_balance(osc, clearance, start):
    """From peak to peak the energy falls by the losses in the dashpot and the impacts of `simulate`."""
    found = vi.decay(osc, clearance, **start, cycles=8)
    assert found.x.size == 17
    trajectory = simulated(osc, clearance, found.time[-1], **start)
    events = trajectory.events
    assert (events["kind"] == "impact").sum() > 5
    at = trajectory.sample(found.time)
    np.testing.assert_allclose(found.x, at.X, atol=1e-12)
    # an event at the time of a peak comes before the peak
    ended = np.nextafter(found.time, np.inf) + 1e-12
    for k in range(16):
        own = events[(events["time"] > ended[k]) & (events["time"] <= ended[k + 1])]
        impact = own["kind"] == "impact"
        assert impact.sum() == found.impacts[k + 1]
        assert (own["kind"] == "stick").sum() == found.rests[k + 1]
        loss = (kinetic(osc, own[impact], "before") - kinetic(osc, own[impact], "after")).sum()
        loss += viscous(osc, trajectory, found.time[k], found.time[k + 1])
        if osc.mu > 0:
            assert found.energy[k] - found.energy[k + 1] == pytest.approx(loss, abs=2e-12)
    assert (np.diff(found.energy) < 0).all()


@pytest.mark.parametrize(("osc", "clearance", "start"), [(DAMPER, 0.7, {}), (UNEVEN, 0.9, START)])
def test_peaks_are_the_greatest_displacements(osc, clearance, start):
    """Between two zeros of x the largest sample is close to the peak and not beyond it; the sides alternate."""
    found = vi.decay(osc, clearance, **start, cycles=15)
    assert (found.x[1:] * found.x[:-1] < 0).all()
    trajectory = simulated(osc, clearance, found.time[-1], **start)
    t = np.linspace(0, found.time[-1], 200_001)
    x = trajectory.sample(t).X
    zeros = np.flatnonzero(x[1:] * x[:-1] < 0) + 1
    halves = np.split(np.abs(x), zeros)
    # the first one is not a peak where the start moves towards the equilibrium
    moving_in = start.get("amplitude", 1) * start.get("x_dot", 0) < 0
    halves = halves[1:-1] if moving_in else halves[:-1]
    greatest = np.array([half.max() for half in halves])
    peaks = np.abs(found.x[: greatest.size])
    assert greatest.size >= 30
    # simulations of whole flights round differently, and 40 impacts amplify this
    assert (greatest <= peaks * (1 + 1e-11)).all()
    np.testing.assert_allclose(greatest, peaks, rtol=1e-3)


@pytest.mark.parametrize("xi", [0.0, 1e-9, 1e-4, 0.005, 0.3, 0.9])
def test_without_impacts(xi):
    """Without impacts peaks are half a period apart, and each decrement is that of the dashpot."""
    found = vi.decay(vi.Oscillator(xi=xi, mu=0.1, restitution=0.75), 6.0, cycles=10)
    eta = math.sqrt(1 - xi**2)
    np.testing.assert_allclose(found.time, np.arange(21) * math.pi / eta, rtol=1e-13, atol=1e-13)
    np.testing.assert_allclose(
        found.x, (-1.0) ** np.arange(21) * np.exp(-xi * np.arange(21) * math.pi / eta), rtol=1e-11
    )
    np.testing.assert_allclose(found.decrement[:-2], 2 * math.pi * xi / eta, rtol=1e-9, atol=1e-13)
    np.testing.assert_allclose(found.damping[:-2], xi, rtol=1e-9, atol=1e-14)
    assert np.isnan(found.damping[-2:]).all()
    assert not found.impacts.any()


def test_without_loss():
    """Without a dashpot and with R = 1 the energy is constant."""
    found = vi.decay(vi.Oscillator(xi=0.0, mu=0.1, restitution=1.0), [0.3, 1.0, 2.5], cycles=50)
    assert found.impacts.sum() > 300
    assert np.ptp(np.abs(found.x)) > 0.2
    np.testing.assert_allclose(found.energy, 0.5, rtol=1e-11)


def test_an_impulse():
    """After an impulse at x = 0 the first peak is a quarter of a period later."""
    found = vi.decay(
        vi.Oscillator(xi=0.0, mu=0.1, restitution=0.75), 9.0, amplitude=0.0, x_dot=2.0, cycles=3
    )
    # the free mass is at rest at z = 0 and |x| <= 2 < 4.5
    np.testing.assert_allclose(found.time, (np.arange(7) + 0.5) * math.pi, rtol=1e-14)
    np.testing.assert_allclose(found.x, 2 * (-1.0) ** np.arange(7), rtol=1e-14)


def test_mirror_image():
    """Under x -> -x with the walls exchanged, the peaks change sign and nothing else changes."""
    one = vi.decay(UNEVEN, [0.4, 0.9], **START)
    mirrored = vi.Oscillator(xi=UNEVEN.xi, mu=UNEVEN.mu, restitution=UNEVEN.restitution[::-1])
    other = vi.decay(mirrored, [0.4, 0.9], **{name: -value for name, value in START.items()})
    np.testing.assert_array_equal(other.x, -one.x)
    for name in set(COLUMNS) - {"x"}:
        np.testing.assert_array_equal(getattr(other, name), getattr(one, name))


def test_only_ratios_of_lengths_matter():
    """Scaling all lengths and velocities by a power of two leaves the damping unchanged to the last bit."""
    one = vi.decay(UNEVEN, [0.4, 0.9], **START)
    other = vi.decay(UNEVEN, [3.2, 7.2], **{name: 8 * value for name, value in START.items()})
    np.testing.assert_array_equal(other.x, 8 * one.x)
    np.testing.assert_array_equal(other.energy, 64 * one.energy)
    for name in ("time", "decrement", "damping", "impacts", "rests"):
        np.testing.assert_array_equal(getattr(other, name), getattr(one, name))


def test_clearances_do_not_depend_on_each_other():
    """A result does not depend on the other clearances, the number of threads, or the form of the list."""
    clearances = [0.25, 0.5, 1.0, 2.0]
    one = vi.decay(DAMPER, clearances, threads=1)
    two = vi.decay(DAMPER, inverse_clearance=[4.0, 2.0, 1.0, 0.5], threads=2)
    for name in COLUMNS:
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))
    for i, clearance in enumerate(clearances):
        alone = vi.decay(DAMPER, clearance)
        np.testing.assert_array_equal(alone.x, one.x[one.run == i])
        np.testing.assert_array_equal(alone.damping, one.damping[one.run == i])


def test_the_damping_is_that_of_the_decrement():
    found = vi.decay(DAMPER, [0.3, 0.7])
    for i in range(2):
        x, decrement = found.x[found.run == i], found.decrement[found.run == i]
        np.testing.assert_allclose(decrement[:-2], np.log(x[:-2] / x[2:]), rtol=1e-12)
        np.testing.assert_allclose(
            found.damping[found.run == i],
            decrement / np.sqrt(4 * math.pi**2 + decrement**2), rtol=1e-14,
        )  # fmt: skip


def test_an_oscillation_that_ends():
    """A strongly damped oscillation falls below the smallest numbers; the peaks before that are kept."""
    found = vi.decay(vi.Oscillator(xi=0.99, mu=0.1, restitution=0.75), 6.0, cycles=40)
    assert 10 < found.x.size < 81
    assert found.status[0] == 0
    np.testing.assert_allclose(found.damping[:-2], 0.99, rtol=1e-9)
    failed, note = found._result.notes[-1]
    assert "with fewer than 81 peaks: the oscillation ends, or stays on one side of 0" in note
    assert not failed


@pytest.mark.parametrize("form", ["json", "nc", "mat"])
def test_files_and_namelist_give_it_again(form, tmp_path):
    """Each file format and the namelist reproduce the result to the last bit."""
    found = vi.decay(UNEVEN, [0.4, 0.9], **START, cycles=6)
    found.save(tmp_path / f"one.{form}")
    again = vi.load(tmp_path / f"one.{form}")
    (tmp_path / "case.nml").write_text(found.to_namelist())
    (case,) = vi.read_namelist(tmp_path / "case.nml")
    (computed,) = case.run()
    assert again.to_json() == computed.to_json() == found.to_json()
    np.testing.assert_array_equal(again.run, found.run)


@pytest.mark.parametrize(("keys", "wanted"), [
    ({"clearance": -1.0}, "clearance = -1.0: must be a number with 1e-12 <= clearance <= 1e12"),
    ({}, "clearance: is missing; must be a number with 1e-12 <= clearance <= 1e12"),
    ({"clearance": 1.0, "inverse_clearance": 1.0}, "must be left out if"),
    ({"clearance": 1.0, "cycles": 0}, "cycles = 0: must be a whole number with 1 <= cycles"),
    ({"clearance": 1.0, "amplitude": 0.0}, "; it must not be 0 if both masses start at rest"),
    ({"clearance": [1.0, 0.4], "y": 0.3},
     "y = 0.3: must be a finite number; y must be within half of the smallest clearance"),
    ({"clearance": [1.0] * 99, "cycles": 10**5}, "; clearances x (2 cycles + 1) must be at most 12500000"),
    ({"clearance": 1.0, "z_dot": math.nan}, "z_dot = nan: must be a number with -1e100 <= z_dot <= 1e100"),
])  # fmt: skip
def test_bad_input(keys, wanted):
    with pytest.raises(ParameterError) as error:
        vi.decay(DAMPER, **keys)
    assert wanted in str(error.value)


def test_bad_types():
    with pytest.raises(ParameterTypeError, match="osc"):
        vi.decay(3, 1.0)
    with pytest.raises(ParameterTypeError, match="cycles"):
        vi.decay(DAMPER, 1.0, cycles="many")


@pytest.mark.parametrize("clearances", [[0.7], [0.3, 0.7], np.geomspace(0.1, 2, 12)])
def test_picture(clearances):
    """Each peak is in both panels, with symbols and units on the axes; a panel can be drawn alone."""
    plt = pytest.importorskip("matplotlib.pyplot")
    found = vi.decay(DAMPER, clearances)
    panels = found.plot()
    alone = [found.plot(kind=kind) for kind in ("peaks", "damping")]
    given = [found.plot(plt.subplots()[1]), found.plot(plt.subplots()[1], "damping")]
    try:
        message = panels[0].figure.get_suptitle()
        assert message.startswith(r"free vibration: $\xi$ = 0.005, $\mu$ = 0.1, $R$ = 0.75")
        assert ("dK/F_0" in message) == (len(clearances) == 1)
        for peaks, damping in (panels, alone, given):
            assert peaks.get_yscale() == damping.get_xscale() == "log"
            assert (peaks.get_xlabel(), peaks.get_ylabel()) == (
                r"$t$ ($1/\omega$)",
                "peaks $|X|$ ($F_0/K$)",
            )
            assert (r"\zeta" in damping.get_ylabel(), "F_0/K" in damping.get_xlabel()) == (
                True,
                True,
            )
            assert len(peaks.lines) == len(clearances)
            for i, (peak, cycle) in enumerate(zip(peaks.lines, damping.lines, strict=False)):
                x, zeta = np.abs(found.x[found.run == i]), found.damping[found.run == i]
                np.testing.assert_array_equal(peak.get_ydata(), x)
                np.testing.assert_array_equal(cycle.get_xdata(), x)
                np.testing.assert_array_equal(cycle.get_ydata(), zeta)
        with pytest.raises(ParameterError, match="kind = 'energy': must be"):
            found.plot(kind="energy")
    finally:
        plt.close("all")


def test_interrupted(monkeypatch):
    """After Ctrl-C the runs that are kept are complete, and have the same bits as an undisturbed call."""
    monkeypatch.setattr(importlib.import_module("vibroimpact.base.interrupt"), "INTERVAL", 0.001)
    clearances = np.linspace(0.1, 2, 200)

    def progress(share, what):
        if share > 0.3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as stop:
        vi.decay(DAMPER, clearances, cycles=2000, progress=progress)
    part = stop.value.result
    whole = vi.decay(DAMPER, clearances, cycles=2000)
    n = part.clearance.size
    assert 0 < n < 200
    assert (part.complete, part.cut) == (False, f"{n} of 200 clearances were reached")
    assert (whole.complete, whole.cut) == (True, "")
    at = np.searchsorted(clearances, part.clearance)
    for i, run in enumerate(at.tolist()):
        np.testing.assert_array_equal(part.damping[part.run == i], whole.damping[whole.run == run])


#: A gap that stays open.
FAR = vi.Gap([1.0], 99.0)


def of_structure(osc, clearance):
    """The oscillator as a structure."""
    return osc.at(1.0, clearance).structure


@pytest.mark.parametrize(("osc", "clearance", "start"), [
    (DAMPER, 0.7, {}), (UNEVEN, 0.9, START), (STICKY, 0.5, {}),
])  # fmt: skip
def test_a_structure_is_the_oscillator(osc, clearance, start):
    """The peaks by the closed form of the oscillator and those of a structure of two masses are the same."""
    own = vi.decay(osc, clearance, **start, cycles=8)
    s = {"amplitude": 1.0, "x_dot": 0.0, "y": 0.0, "z_dot": 0.0} | start
    state = ([s["amplitude"], s["amplitude"] + s["y"]], [s["x_dot"], s["z_dot"]])
    found = vi.decay(of_structure(osc, clearance), state=state, cycles=8)
    assert found.rests.tolist() == own.rests.tolist()
    if not own.rests.any():  # the sums of accumulations begin at different impacts
        assert found.impacts.tolist() == own.impacts.tolist()
    for name in ("time", "x", "energy", "decrement", "damping"):
        assert getattr(found, name) == pytest.approx(getattr(own, name), abs=1e-9, nan_ok=True)


@pytest.mark.parametrize("zeta", [0.0, 0.004, 0.2])
@pytest.mark.parametrize("f", [0.0, 0.013, 0.3])
def test_damping_and_friction(zeta, f):
    """Between reversals x decays towards the equilibrium of spring and friction, until the mass sticks."""
    s = vi.Structure([2.0], [2 * zeta * math.sqrt(2 * 3.0)], [3.0], [FAR],
                     [vi.Friction([1.0], f)] if f else [])  # fmt: skip
    found = vi.decay(s, state=([0.85], [0.0]), cycles=25)
    w, k = math.sqrt(1 - zeta**2), 3.0
    loss = math.exp(-zeta * math.pi / w)
    expected = [0.85]
    while len(expected) < 51 and abs(expected[-1]) > f / k:
        shift = math.copysign(f / k, expected[-1])
        following = shift - (expected[-1] - shift) * loss
        if following * expected[-1] > 0:
            break  # it moves a little, and halts on the same side
        expected.append(following)
    assert found.x == pytest.approx(expected, rel=1e-11, abs=1e-13)
    half = math.pi / w / math.sqrt(k / 2.0)
    assert found.time == pytest.approx(half * np.arange(len(expected)), rel=1e-11)
    assert found.energy == pytest.approx(1.5 * np.square(expected), rel=1e-11)
    assert found.rests.sum() == (len(expected) < 51 and abs(expected[-1]) <= f / k)
    if not f:
        decrement = 2 * math.pi * zeta / w
        assert found.decrement[:-2] == pytest.approx(decrement, rel=1e-9, abs=1e-12)
        assert found.damping[:-2] == pytest.approx(zeta, rel=1e-9, abs=1e-12)


def test_a_stop_without_loss():
    """Half oscillations on one spring and on both springs, with the same energy."""
    s = vi.Structure([100.0], [0.0], [1e4], [vi.Stop([1.0], 0.0, stiffness=1e6)])
    found = vi.decay(s, state=([0.0], [1.0]), cycles=10)
    assert found.x[::2] == pytest.approx(1 / math.sqrt(10100), rel=1e-11)
    assert found.x[1::2] == pytest.approx(-0.1, rel=1e-11)
    assert found.energy == pytest.approx(50.0, rel=1e-11)
    assert found.impacts.tolist() == [1, 0] * 10 + [1]
    assert found.decrement[:-2] == pytest.approx(0, abs=1e-11)


def test_energy_of_a_structure():
    """From peak to peak the energy falls by the losses in impacts, dashpots, stops and friction of `simulate`."""
    s = vi.Structure(
        [1.0, 0.4, 0.7], [[0.03, -0.01, 0], [-0.01, 0.02, 0], [0, 0, 0.01]],
        [[3.0, -1, 0], [-1, 2.5, -1], [0, -1, 1.5]],
        [vi.Gap([-1, 1, 0], 0.3, 0.7), vi.Stop([0, 0, 1], 0.4, stiffness=30, damping=0.3),
         vi.Stop([0, 0, -1], 0.5, stiffness=20, damping=0.4, preload=0.02, release="force")],
        [vi.Friction([0, 0, 1], 0.01), vi.Friction([1, -1, 0], 0.005)],
        outputs={"tip": [0, 0.2, 1]},
    )  # fmt: skip
    state = ([1.0, 0.8, 0.3], [0.1, 0.0, -0.4])
    found = vi.decay(s, state=state, direction="tip", cycles=8)
    assert found.x.size == 17
    assert found.impacts.sum() > 5
    run = vi.simulate(s, duration=found.time[-1] + 0.1, state=state)
    kinds = run.events["kind"][run.events["time"] <= found.time[-1]]
    assert found.impacts.sum() == np.isin(kinds, ["impact", "touch"]).sum()
    assert found.rests.sum() == np.isin(kinds, ["stick", "halt"]).sum()
    assert np.diff(found.energy).max() < 0
    # the greatest displacement between two zeros
    t = np.linspace(0, found.time[-1], 100_001)
    y = np.array([0, 0.2, 1]) @ run.sample(t)[0]
    halves = np.split(np.abs(y), np.flatnonzero(y[1:] * y[:-1] < 0) + 1)
    # the first half oscillation begins beyond its peak
    greatest = [half.max() for half in halves[1:]]
    assert np.abs(found.x) == pytest.approx(greatest, rel=1e-5)
    for k in range(16):
        window = (found.time[k], found.time[k + 1])
        balance = run.quantities(window=window)
        lost = found.energy[k] - found.energy[k + 1]
        assert lost == pytest.approx(losses(balance), abs=1e-9), k


def losses(balance):
    """Losses of all kinds within a window."""
    return balance.damping_loss + balance.impact_loss + balance.friction_loss


def test_a_constant_load():
    """Weight shifts the equilibrium about which a mass oscillates, but zeros are those of the displacement."""
    s = vi.Structure([1.0], [0.02], [1.0], [FAR])
    found = vi.decay(s, vi.Load(constant=[-0.3]), state=([0.7], [0.0]), cycles=3)
    free = vi.decay(s, state=([1.0], [0.0]), cycles=3)
    assert found.x == pytest.approx(free.x[: len(found.x)] - 0.3, rel=1e-10)
    with pytest.raises(ParameterError, match=r"load = <Load of 1 .*must be constant or left out"):
        vi.decay(s, vi.Load(1.0, cosine=[1.0]), state=([1.0], [0.0]))


@pytest.mark.parametrize(("given", "wanted"), [
    ({}, "q = 0.*it must not be 0 if all masses start at rest"),
    ({"state": ([1.0], [0.0]), "direction": [0.0]}, "direction = 0.0: must be numbers from -1e40"),
    ({"state": ([1.0], [0.0]), "direction": [1.0, 2.0]}, "direction"),
    ({"state": ([1.0], [0.0]), "direction": "tip"}, "direction = 'tip': must be"),
])  # fmt: skip
def test_bad_input_of_a_structure(given, wanted):
    with pytest.raises(ParameterError, match=wanted):
        vi.decay(one_stop(0.5, stiffness=4), **given)


def test_a_structure_that_nothing_pulls_back():
    with pytest.raises(vi.SingularError, match="no spring holds the structure"):
        vi.decay(vi.Structure([1.0], [0.1], [0.0], [FAR]), state=([1.0], [0.0]))


def test_a_structure_again(tmp_path):
    """Files and the namelist reproduce the decay of a structure; it can be drawn."""
    pytest.importorskip("matplotlib")
    found = vi.decay(one_stop(0.5, stiffness=4, damping=0.2), state=([1.0], [0.0]), cycles=4)
    assert repr(found).startswith("<Decay of a structure: 9 peaks, damping ratio of a cycle from")
    found.save(tmp_path / "one.json")
    (tmp_path / "case.nml").write_text(found.to_namelist())
    (case,) = vi.read_namelist(tmp_path / "case.nml")
    assert vi.load(tmp_path / "one.json").to_json() == case.run()[0].to_json() == found.to_json()
    assert [panel.get_xlabel()[:3] for panel in found.plot()] == ["$t$", "$|X"]
    with pytest.raises(AttributeError, match="clearance"):
        _ = found.clearance
