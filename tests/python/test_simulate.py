"""Simulations: energy balance, and the symmetries of the equations."""

import sys

import numpy as np
import pytest
import vibroimpact as vi
from hypothesis import given
from hypothesis import strategies as st
from shared_simulations import COLUMNS, assert_energy_is_accounted_for, assert_laws, energy, state
from shared_systems import EPS, RIG, TURN, law


@pytest.mark.parametrize(("osc", "r", "clearance", "load"), [
    (RIG, 0.9, 6.0, 1.0),
    (vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75), 0.94, 20.0, 1.0),
    (vi.Oscillator(xi=0.1, mu=1.0, restitution=(0.0, 1.0)), 2.2, 0.3, 2.5),
    (vi.Oscillator(xi=0.0, mu=0.3, restitution=(0.3, 0.6)), 0.4, 1.0, 0.7),
    (vi.Oscillator(xi=0.02, mu=0.5, restitution=(0.9, 0.5)), 0.7, 0.5, 0.0),
])  # fmt: skip
def test_energy_is_accounted_for_at_every_event(osc, r, clearance, load):
    """From event to event the energy changes by the work of the load minus the losses in damper and impacts."""
    run = vi.simulate(osc, r, clearance, 40, state(x_dot=0.4, z_dot=-0.2), load=load)
    assert run.events.size > 10
    assert_laws(run)
    assert_energy_is_accounted_for(run)


@given(st.integers(0, 10**6))
@law(25)
def test_free_decay_only_loses_energy(seed):
    """Without load the energy never grows, and damper and impacts account for all losses."""
    draw = np.random.default_rng(seed)
    osc = vi.Oscillator(
        xi=draw.uniform(0.01, 0.3),
        mu=draw.uniform(0.05, 2),
        restitution=tuple(draw.uniform(0, 1, 2)),
    )
    first = state(0.0, *draw.normal(size=2), z_dot=draw.normal())
    first["z"] = first["x"] + draw.uniform(-0.5, 0.5)
    run = vi.simulate(osc, 1.1, 1.0, 20, first, load=0.0, max_events=20_000)
    h = run.sample(np.linspace(0.0, run.final_state["t"], 5000))
    total = energy(osc, h.X, h.X_dot, h.Z_dot)
    assert np.all(np.diff(total) <= 1e-13 * total[0])
    assert np.array_equal(h.load, 0 * h.load)
    assert_energy_is_accounted_for(run)


# --- symmetries -----------------------------------------------------------------------------


def mirrored(events, back=0):
    """Return the numbers of the mirror image, with sides swapped and times measured back."""
    numbers = np.array([events["time"] - back] + [-events[name] for name in COLUMNS])
    return numbers, np.where(events["side"] == "R", "L", "R"), events["kind"]


def test_mirror_image_without_load_is_exact():
    """Under x -> -x, R <-> L every bit of a free vibration is mirrored."""
    osc = vi.Oscillator(xi=0.02, mu=0.3, restitution=(0.8, 0.5))
    turned = vi.Oscillator(xi=0.02, mu=0.3, restitution=(0.5, 0.8))
    first = state(0.0, 0.4, 1.1, 0.3, -0.7)
    run = vi.simulate(osc, 0.9, 0.8, 20, first, load=0.0)
    image = vi.simulate(turned, 0.9, 0.8, 20, {k: -v for k, v in first.items()}, load=0.0)
    numbers, sides, kinds = mirrored(image.events)
    assert run.events.size > 10
    assert np.array_equal(numbers[1:], [run.events[name] for name in COLUMNS])
    assert np.array_equal(numbers[0], run.events["time"])
    assert np.array_equal(sides, run.events["side"])
    assert np.array_equal(kinds, run.events["kind"])


def test_mirror_image_under_load():
    """With load the mirror image comes half a load period later."""
    turned = vi.Oscillator(xi=RIG.xi, mu=RIG.mu, restitution=RIG.restitution[::-1])
    run = vi.simulate(RIG, 0.9, 6.0, 6)
    image = vi.simulate(turned, 0.9, 6.0, 6, state(t=np.pi / 0.9))
    numbers, sides, kinds = mirrored(image.events, np.pi / 0.9)
    assert np.array_equal(kinds, run.events["kind"])
    assert np.array_equal(sides, run.events["side"])
    assert numbers[0] == pytest.approx(run.events["time"], abs=1e-9)
    assert numbers[1:] == pytest.approx(np.array([run.events[n] for n in COLUMNS]), abs=1e-9)


def apart(run, other, shift=0.0):
    """Return the largest difference of any number, event by event, from a run that began earlier by `shift`."""
    assert np.array_equal(other.events["kind"], run.events["kind"])
    numbers = np.array(
        [other.events[name] - run.events[name] for name in ("time", "phase", *COLUMNS)]
    )
    numbers[0] -= shift
    return np.abs(numbers).max(0)


def test_shift_by_load_periods():
    """From the same state whole load periods later, the same events follow later, with the same phases.

    Later times have fewer digits; this error grows no more than a small change of the state.
    """
    first = state(t=0.7, x=0.1, z=0.3)
    run = vi.simulate(RIG, 0.9, 6.0, 6, first)
    changed = [
        vi.simulate(RIG, 0.9, 6.0, 6, first | {name: first[name] + 1e-10})
        for name in ("x", "x_dot", "z", "z_dot")
    ]
    growth = np.max([apart(run, other) for other in changed], axis=0) / 1e-10
    growth = np.maximum.accumulate(growth)
    for periods in (1, 1000):
        shift = periods * TURN / 0.9
        later = vi.simulate(RIG, 0.9, 6.0, 6, first | {"t": 0.7 + shift})
        assert np.all(apart(run, later, shift) <= growth * EPS * later.events["time"])


@pytest.mark.parametrize("factor", [2.0, 0.5, 1024.0, 3.0, 0.1])
@pytest.mark.parametrize("load", [1.0, 0.0])
def test_answers_scale_with_the_load(factor, load):
    """All lengths scale with the load; with a power of two all other numbers keep their bits."""
    first = state(0.2, 0.4, 0.8, 0.3, -0.6)
    run = vi.simulate(RIG, 0.9, 1.5, 6, first, load=load)
    larger = {name: value * (1.0 if name == "t" else factor) for name, value in first.items()}
    other = vi.simulate(RIG, 0.9, 1.5 * factor, 6, larger, load=factor * load)
    exact = factor in (2.0, 0.5, 1024.0)
    for name in ("time", "phase", *COLUMNS):
        size = factor if name in COLUMNS else 1.0
        got, want = other.events[name] / size, run.events[name]
        assert np.array_equal(got, want) if exact else got == pytest.approx(want, abs=1e-9)


def test_same_call_same_bits():
    """Repeated calls give the same bits, also after another study with threads."""
    runs = [vi.simulate(RIG, 0.9, 6.0, 50) for _ in range(3)]
    vi.find(RIG, 0.9, 6.0, max_impacts=2, max_cycles=1, guesses=4, states=2)
    runs.append(vi.simulate(RIG, 0.9, 6.0, 50))
    for run in runs[1:]:
        assert np.array_equal(run.events, runs[0].events)
        assert run.final_state == runs[0].final_state


# --- the namelist program -------------------------------------------------------------------


def test_namelist_gives_the_same_digits(tmp_path):
    """&simulate writes the events that `simulate` returns, bit for bit."""
    path = tmp_path / "run.nml"
    path.write_text(
        "&system xi = 0.0114, mu = 0.028, restitution = 0.75, 0.61, r = 0.9 /\n"
        "&simulate clearance = 6, cycles = 20, discard = 3, load = 1.5, t = 0.4, x = 0.1,\n"
        "  x_dot = -0.2, z = 0.3, z_dot = 0.25 /\n"
    )
    log = vi.run_namelists([path], tmp_path)
    assert log.status == 0, log.lines
    lines = (tmp_path / "run.csv").read_text().splitlines()
    rows = [line.split(",") for line in lines if not line.startswith("#")]
    run = vi.simulate(RIG, 0.9, 6.0, 20, state(0.4, 0.1, -0.2, 0.3, 0.25), load=1.5, discard=3)
    head, rows = [name.strip() for name in rows[0]], rows[1:]
    assert len(rows) == run.events.size > 50
    for name in ("time", "phase", *COLUMNS):
        written = [float(row[head.index(name)]) for row in rows]
        assert np.array_equal(written, run.events[name]), name
    for name in ("kind", "side"):
        assert [row[head.index(name)].strip() for row in rows] == run.events[name].tolist()


def test_namelist_event_budget(tmp_path):
    """A simulation that is cut short has status 1 and a message."""
    path = tmp_path / "cut.nml"
    path.write_text(
        "&system xi = 0.0114, mu = 0.028, restitution = 0.75, 0.61, r = 0.9 /\n"
        "&simulate clearance = 6, cycles = 20, max_events = 9 /\n"
    )
    log = vi.run_namelists([path], tmp_path)
    assert log.status == 1
    assert any("max_events" in text for _, text in log.lines)


def test_a_call_is_short():
    """A call runs at most 40 functions of Python around the core: they take most of the time of a short run."""
    names = []

    def note(frame, event, _):
        if event == "call":
            names.append(frame.f_code.co_name)

    vi.simulate(RIG, 0.9, 6.0, cycles=1)
    before = sys.getprofile()
    sys.setprofile(note)
    try:
        vi.simulate(RIG, 0.9, 6.0, cycles=1)
    finally:
        sys.setprofile(before)
    assert "simulate" in names
    assert len(names) <= 40
