"""Trajectories: start and end, continuation, samples."""

import math

import numpy as np
import pytest
import vibroimpact as vi
from shared_simulations import COLUMNS, STATE, assert_laws, plain, settled, state
from shared_systems import EPS, RIG, TURN

# --- start and end of a run -----------------------------------------------------------------


def test_a_run_in_two_parts_is_the_whole_run():
    """A run continued from a final state has the events of the complete run, bit for bit."""
    whole = vi.simulate(RIG, 0.9, 6.0, 20)
    first = vi.simulate(RIG, 0.9, 6.0, 10)
    second = vi.simulate(RIG, 0.9, 6.0, 10, state=first.final_state)
    events = np.concatenate([first.events, second.events])
    assert events["kind"].tolist() == whole.events["kind"].tolist()
    assert np.abs(events["time"] - whole.events["time"]).max() < 1e-9
    assert second.final_state["t"] == whole.final_state["t"]
    assert np.array_equal(events, whole.events)


def test_discarded_cycles_are_the_run_before():
    """`discard` simulates cycles and drops their events."""
    first = vi.simulate(RIG, 0.9, 6.0, 10)
    second = vi.simulate(RIG, 0.9, 6.0, 10, state=first.final_state)
    kept = vi.simulate(RIG, 0.9, 6.0, 10, discard=10)
    assert np.array_equal(kept.events, second.events)
    assert kept.initial_state == first.final_state
    assert kept.final_state == second.final_state


@pytest.mark.parametrize("budget", [1, 2, 7, 46, 100])
def test_event_budget(budget):
    """A run that is cut short is marked, ends at its last event, and can be continued with the same bits."""
    whole = vi.simulate(RIG, 0.9, 6.0, 20)
    cut = vi.simulate(RIG, 0.9, 6.0, 20, max_events=budget)
    assert not cut.complete
    assert whole.complete
    assert "max_events" in repr(cut)
    assert "max_events" not in repr(whole)
    assert cut.events.size == budget
    assert cut.final_state["t"] == cut.events["time"][-1]
    assert np.array_equal(cut.events, whole.events[: cut.events.size])
    more = vi.simulate(RIG, 0.9, 6.0, 20, state=cut.final_state)
    left = whole.events[cut.events.size :]
    assert np.array_equal(more.events[: left.size], left)


def test_event_budget_that_is_just_enough():
    """A run with exactly max_events events is complete."""
    whole = vi.simulate(RIG, 0.9, 6.0, 20)
    exact = vi.simulate(RIG, 0.9, 6.0, 20, max_events=whole.events.size)
    assert exact.complete
    assert np.array_equal(exact.events, whole.events)
    assert exact.final_state == whole.final_state
    assert not vi.simulate(RIG, 0.9, 6.0, 20, max_events=whole.events.size - 1).complete


@pytest.mark.parametrize(("name", "size"), [("CHUNK", 5), ("CHUNK", 64), ("SPAN", 1), ("SPAN", 3)])
def test_calls_of_bounded_work_are_one_run(monkeypatch, name, size):
    """A long run, divided into calls of the core, does not depend on the divisions."""
    whole = vi.simulate(RIG, 0.9, 6.0, 20.3)
    monkeypatch.setattr(f"vibroimpact.motions.trajectory.{name}", size)
    for budget in (10**6, whole.events.size, whole.events.size - 1):
        cut = vi.simulate(RIG, 0.9, 6.0, 20.3, max_events=budget)
        assert np.array_equal(cut.events, whole.events[:budget])
        assert cut.complete == (budget >= whole.events.size)
    assert vi.simulate(RIG, 0.9, 6.0, 20.3).final_state == whole.final_state


def test_event_budget_with_discard():
    """If the discarded cycles use up the budget of events, the error names it."""
    with pytest.raises(vi.errors.VibroimpactError, match="max_events"):
        vi.simulate(RIG, 0.9, 6.0, 1, discard=50, max_events=20)


def test_a_run_may_end_anywhere_in_an_accumulation():
    """No event is after the end of the run, even if the run ends within an accumulation."""
    run = settled(2)
    stick = run.events["time"][run.events["kind"] == "stick"][0]
    for before in (1e-3, 1e-7, 2e-8, 1e-8, 3e-9, 1e-9, 3e-10, 1e-12):
        cycles = (stick - before - run.initial_state["t"]) * 0.9 / TURN
        part = vi.simulate(RIG, 0.9, 6.0, cycles, state=run.initial_state)
        assert part.events["time"][-1] <= part.final_state["t"]
        assert part.final_state["t"] == pytest.approx(stick - before, abs=1e-12)
        on = vi.simulate(RIG, 0.9, 6.0, 1, state=part.final_state)
        both = np.concatenate([part.events, on.events])
        assert np.array_equal(both[: run.events.size], run.events[: both.size])
        again = on.events["time"][on.events["kind"] == "stick"]
        again = np.append(part.events["time"][part.events["kind"] == "stick"], again)
        assert again[0] == pytest.approx(stick, abs=1e-9)


@pytest.mark.parametrize("kind", ["flight", "rest"])
def test_plain_and_full_states_are_the_same_state(kind):
    """The five numbers of a final state continue the run, in flight and at rest."""
    run = settled(2)
    stick = run.events["time"][run.events["kind"] == "stick"][0]
    later = {"flight": -1.5, "rest": 0.1}[kind]
    cycles = (stick + later - run.initial_state["t"]) * 0.9 / TURN
    end = vi.simulate(RIG, 0.9, 6.0, cycles, state=run.initial_state).final_state
    one = vi.simulate(RIG, 0.9, 6.0, 0.9, state=end)
    other = vi.simulate(RIG, 0.9, 6.0, 0.9, state=plain(end))
    assert one.events["kind"].tolist() == other.events["kind"].tolist()
    assert one.events["time"] == pytest.approx(other.events["time"], abs=1e-10)


@pytest.mark.parametrize("beside", [0, 1, -1])
def test_the_time_of_a_state_is_kept(beside):
    """A state at whole load periods, to the last bit on either side, keeps its time and phase."""
    for r in (0.9, 0.94, 1.0, 2.37):
        for i in [*range(-40, 41), 1001, 12_345, 199_999]:
            t = TURN * i / r
            if beside:
                t = float(np.nextafter(t, beside * np.inf))
            run = vi.simulate(RIG, r, 6.0, 0, state(t=t))
            assert run.initial_state["t"] == pytest.approx(t, abs=1e-12 + 4 * EPS * abs(t))
            assert run.final_state["t"] == run.initial_state["t"]


def test_default_state_and_zero_cycles():
    """The default state is zero; a trajectory of zero cycles is one instant."""
    run = vi.simulate(RIG, 0.9, 6.0, 0)
    assert plain(run.initial_state) == plain(run.final_state) == state()
    assert run.events.size == 0
    assert run.complete
    assert run.sample(0.0).X.shape == ()


def test_change_of_parameter_on_the_way():
    """A final state continues at another frequency, load or clearance without a jump of phase."""
    before = vi.simulate(RIG, 0.9, 6.0, 3.3)
    after = vi.simulate(RIG, 0.95, 6.0, 3, state=before.final_state, load=0.5)
    assert_laws(after)
    phase = before.final_state["phase"]
    assert after.sample(after.initial_state["t"]).load == pytest.approx(0.5 * math.sin(phase))


def test_rest_does_not_jump_to_another_wall():
    """A state at rest on a wall, with the clearance changed, is refused or continues in flight."""
    run = settled(2)
    stick = run.events["time"][run.events["kind"] == "stick"][0]
    cycles = (stick + 0.05 - run.initial_state["t"]) * 0.9 / TURN
    end = vi.simulate(RIG, 0.9, 6.0, cycles, state=run.initial_state).final_state
    assert end["resting"]
    try:
        wide = vi.simulate(RIG, 0.9, 12.0, 0.001, state=end)
    except vi.errors.ParameterError:
        return
    assert wide.sample(wide.initial_state["t"]).Y == pytest.approx(end["z"] - end["x"], abs=1e-9)


# --- the Trajectory -------------------------------------------------------------------------


def test_samples_in_any_order_and_shape():
    """`sample` keeps the shape of the times; at an event the velocities are those after it."""
    run = settled(2)
    a, b = run.initial_state["t"], run.final_state["t"]
    times = np.random.default_rng(1).uniform(a, b, (3, 4, 5))
    h = run.sample(times)
    assert h.X.shape == (3, 4, 5)
    assert np.array_equal(run.sample(times.ravel()[::-1]).Z, h.Z.ravel()[::-1])
    at = run.sample(run.events["time"])
    assert at.X_dot == pytest.approx(run.events["x_dot_after"], abs=1e-12)
    assert at.Z_dot == pytest.approx(run.events["z_dot_after"], abs=1e-12)
    ends = run.sample([a, b])
    for i, end in enumerate((run.initial_state, run.final_state)):
        got = [ends.X[i], ends.X_dot[i], ends.Z[i], ends.Z_dot[i]]
        assert got == pytest.approx([end[name] for name in STATE[1:]], abs=1e-11)
    assert run.sample([]).X.size == 0


@pytest.mark.parametrize("bad", [-1.0, 1e9, np.nan, np.inf, [0.0, 1e9], "now", None, 1j])
def test_sample_outside_or_wrong(bad):
    """Times outside the trajectory are refused, not extrapolated."""
    run = vi.simulate(RIG, 0.9, 6.0, 2)
    with pytest.raises(vi.errors.VibroimpactError) as caught:
        run.sample(bad)
    assert isinstance(caught.value, (ValueError, TypeError))
    assert "t " in str(caught.value)


def test_trajectory_is_frozen_and_says_what_it_is():
    """Events are read-only, attributes are fixed, the repr counts impacts and rests."""
    run = settled(2)
    with pytest.raises(ValueError, match="read-only"):
        run.events["x"][0] = 0.0
    with pytest.raises((AttributeError, TypeError)):
        run.r = 1.0
    impacts = int((run.events["kind"] == "impact").sum())
    for word in ("Trajectory", "0.9", "6", f"{impacts} impacts", "2 rests"):
        assert word in repr(run)
    assert run.osc is RIG
    assert (run.r, run.clearance, run.load) == (0.9, 6.0, 1.0)
    assert run.complete
    names = ("time", "kind", "side", *COLUMNS)
    assert set(names) <= set(run.events.dtype.names)


def test_a_stopped_case_keeps_its_events(tmp_path, monkeypatch):
    """A stopped case has the complete run's events up to the stop; files keep the time of the stop."""
    monkeypatch.setattr("vibroimpact.base.interrupt.INTERVAL", 0.001)
    path = tmp_path / "case.nml"
    path.write_text(
        "&system xi = 0.0114, mu = 0.028, restitution = 0.75, 0.61, r = 0.9 /\n"
        "&simulate clearance = 6, cycles = 100000000, max_events = 50000000 /\n"
    )
    (case,) = vi.read_namelist(path)
    calls = []

    def stop(share, note):
        calls.append(share)
        if len(calls) > 3:
            raise KeyboardInterrupt

    with pytest.raises(vi.errors.StudyInterrupted) as stopped:
        case.run(stop)
    (run,) = stopped.value.result.parts()
    assert not run.complete
    assert "stopped after" in run.cut
    assert run.cut in repr(run)
    whole = vi.simulate(RIG, 0.9, 6.0, 30)
    assert run.events[: whole.events.size].tobytes() == whole.events.tobytes()
    run.save(tmp_path / "run.json")
    again = vi.load(tmp_path / "run.json")
    assert (again.cut, again.final_state) == (run.cut, run.final_state)
    later = vi.simulate(RIG, 0.9, 6.0, 1, again.final_state)
    assert later.events[0]["time"] > run.events[-1]["time"]
    run.save(tmp_path / "run.csv")
    with (tmp_path / "run.csv").open() as table:
        assert f"# ! cut short: {run.cut}\n" in [next(table) for _ in range(40)]
