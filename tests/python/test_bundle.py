"""Many simulations in one call: the same bits as one by one, for any number of threads."""

import numpy as np
import pytest
import vibroimpact as vi
from shared_simulations import STATE
from shared_systems import FIGURE6, RIG

RATIOS = np.linspace(0.8, 1.1, 7)
STATES = np.random.default_rng(6).uniform(-1.4, 1.4, (5, 7))


def test_a_bundle_is_the_single_simulations():
    """Final states and numbers of impacts and rests are bit for bit those of single simulations."""
    bundle = vi.simulate_bundle(RIG, RATIOS, 6.0, 40, STATES, load=1.5)
    for j, r in enumerate(RATIOS):
        start = dict(zip(STATE, STATES[:, j].tolist(), strict=True))
        run = vi.simulate(RIG, r, 6.0, 40, start, load=1.5)
        assert [getattr(bundle, name)[j] for name in STATE] == [run.final_state[n] for n in STATE]
        kinds = run.events["kind"].tolist()
        assert (bundle.impacts[j], bundle.rests[j]) == (kinds.count("impact"), kinds.count("stick"))
    assert (bundle.status == 0).all()
    assert bundle.impacts.min() > 0
    assert bundle.rests.max() > 0


@pytest.mark.parametrize("threads", [2, 3, 64])
def test_threads_change_no_bit(threads):
    one, many = (vi.simulate_bundle(RIG, RATIOS, 6.0, 40, STATES, threads=n) for n in (1, threads))
    for name in (*STATE, "impacts", "rests", "status"):
        assert getattr(one, name).tobytes() == getattr(many, name).tobytes()


def test_one_state_for_all():
    """Without states all simulations start at rest in the middle; a single state or parameter applies to all."""
    alike = vi.simulate_bundle(FIGURE6, 1.04, [25.0, 25.0], 30, [0.0, 1.0, 0.0, 0.5, 0.0])
    assert (
        alike.x[0]
        == alike.x[1]
        == vi.simulate_bundle(FIGURE6, 1.04, 25.0, 30, [[0.0], [1.0], [0.0], [0.5], [0.0]]).x
    )
    rest = vi.simulate(FIGURE6, 1.04, 25.0, 30).final_state
    assert vi.simulate_bundle(FIGURE6, 1.04, 25.0, 30).x[0] == rest["x"]


def test_event_budget():
    """A simulation that exceeds the limit of events ends early with a status; the others continue."""
    whole = vi.simulate_bundle(RIG, RATIOS, 6.0, 40)
    most = int(np.median(whole.impacts + whole.rests))
    cut = vi.simulate_bundle(RIG, RATIOS, 6.0, 40, max_events=most)
    assert {0, 13} == set(cut.status.tolist())
    for j in np.flatnonzero(cut.status == 0):
        assert cut.x[j] == whole.x[j]
    assert (cut.t[cut.status == 13] < whole.t[cut.status == 13]).all()
    assert "max_events" in vi.status_text(13)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"osc": None}, "osc = None"),
        ({"r": 0.0}, "r = 0.0"),
        ({"r": []}, "r, clearance, load, states: must"),
        ({"clearance": [1.0, -1.0]}, "clearance = -1.0"),
        ({"r": [0.9, 1.0], "clearance": [1.0, 2.0, 3.0]}, r"r \(2,\), clearance \(3,\)"),
        ({"load": np.nan}, "load = nan"),
        ({"cycles": -1}, "cycles = -1"),
        ({"states": np.zeros(4)}, r"states of shape \(4,\)"),
        ({"states": [0, 0, 0, np.inf, 0]}, r"states\[:, 0\] = .*inf.*: must be finite"),
        ({"states": [0, 0, 0, 3.1, 0]}, r"states\[:, 0\] = .*: must have z - x .* -3 to 3"),
        ({"max_events": 0}, "max_events = 0"),
        ({"threads": 0}, "threads = 0"),
    ],
)
def test_bad_input(changes, words):
    given = {"osc": RIG, "r": 0.9, "clearance": 6.0, "cycles": 3, **changes}
    with pytest.raises(vi.errors.VibroimpactError, match=words):
        vi.simulate_bundle(**given)


def test_resonance_without_damping():
    with pytest.raises(vi.errors.ParameterError, match=r"r = 1\.0.*xi = 0"):
        vi.simulate_bundle(vi.Oscillator(xi=0.0, mu=0.1, restitution=0.5), [0.9, 1.0], 6.0, 3)


def test_progress_counts_the_simulations(monkeypatch, capsys):
    """The share rises from 0 to 1, and without `progress` a terminal shows a bar; neither changes a bit."""
    monkeypatch.setattr("vibroimpact.base.interrupt.INTERVAL", 0.001)
    states, shares = np.tile(STATES, 40), []
    told = vi.simulate_bundle(
        RIG, 0.94, 6.0, 200, states, progress=lambda share, what: shares.append(share)
    )
    assert shares == sorted(shares)
    assert 0 <= shares[0] < shares[-1] <= 1
    assert capsys.readouterr().err == ""
    for name, value in (("PATIENCE", 0.0), ("INTERVAL", 0.0), ("attended", lambda: True)):
        monkeypatch.setattr(f"vibroimpact.base.progress.{name}", value)
    plain = vi.simulate_bundle(RIG, 0.94, 6.0, 200, states)
    assert "simulate_bundle [#" in capsys.readouterr().err
    np.testing.assert_array_equal(plain.z, told.z)
    with pytest.raises(KeyboardInterrupt):
        vi.simulate_bundle(RIG, 0.94, 6.0, 10**6, STATES, progress=interrupting)


def interrupting(share, what):
    raise KeyboardInterrupt
