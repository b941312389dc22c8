"""Every periodic motion at a point: motions that must be listed, no duplicates, and the summary of the search."""

import dataclasses
import itertools
import math
import os
import re
import sys

import numpy as np
import pytest
import vibroimpact as vi
from shared_motions import UNEVEN, after_impact
from shared_simulations import state
from shared_systems import RIG, TABLE, TURN
from vibroimpact.studies.find import Search


def same_orbit(one, other):
    """Whether two motions are one orbit, up to a rotation of the impacts by whole load periods."""
    n, k = len(one.pattern), one.pattern.cycles
    if (n, k) != (len(other.pattern), other.pattern.cycles):
        return False
    letters = one.pattern.symbols
    for j in range(n):
        if letters[j:] + letters[:j] != other.pattern.symbols:
            continue
        phases = np.append(one.alpha[j:], one.alpha[:j] + TURN * k) + one.load_phase
        gap = phases - other.alpha - other.load_phase
        gap -= TURN * np.rint(gap[0] / TURN)
        if np.abs(gap).max() < 1e-6 and np.allclose(np.roll(one.X, -j), other.X, atol=1e-6):
            return True
    return False


def check_found(found, osc, r, clearance):
    """Assert the properties that every motion of a search has."""
    for i, motion in enumerate(found):
        assert motion.residual <= 1e-12
        assert motion.consistent
        assert motion.admissible
        assert (motion.osc, motion.r, motion.clearance) == (osc, r, clearance)
        history = motion.sample(np.linspace(0, motion.period, 3001))
        assert np.abs(history.Y).max() <= 0.5 * clearance * (1 + 1e-9)
        for other in found[:i]:
            assert not same_orbit(motion, other)
    stable = [bool(motion.stable) for motion in found]
    assert stable == sorted(stable, reverse=True)


def attracts(motion, cycles=300):
    """Whether simulations that start near a motion return to it, as they do to a stable motion."""
    if motion.pattern.has_rest:
        release = motion.events[motion.events["kind"] == "release"][0]
        v = release["x_dot_after"] + 1e-7 * motion.clearance
        x = np.sin(release["phase"]) - 2 * motion.osc.xi * v
        side = 0.5 * motion.clearance * (1 if release["side"] == "R" else -1)
        first = {"t": release["phase"] / motion.r, "x": x, "x_dot": v, "z": x + side, "z_dot": v}
    else:
        first = after_impact(motion)
        first["x_dot"] += 1e-7 * motion.clearance
    k = motion.pattern.cycles
    run = vi.simulate(motion.osc, motion.r, motion.clearance, 2 * k + 2, first, discard=cycles * k)
    again = vi.exact(motion.osc, motion.r, motion.clearance, run)
    return len(again.pattern) == len(motion.pattern) and np.allclose(
        np.sort(again.X), np.sort(motion.X), atol=1e-6 * motion.clearance
    )


def is_mirror(one, other):
    """Whether a motion is the mirror image of another, half a load period later."""
    letters = other.pattern.sides.translate(str.maketrans("RL", "LR"))
    for j in range(len(one.pattern)):
        turned = one.pattern.symbols[j:] + one.pattern.symbols[:j]
        if "".join(turned) != letters or one.pattern.cycles != other.pattern.cycles:
            continue
        if np.allclose(-np.roll(one.X, -j), other.X, atol=1e-7):
            return True
    return False


def test_point_of_table_1():
    """Two unstable equispaced motions, the stable unequispaced one and its mirror image."""
    found = vi.find(TABLE, 0.94, 37.0)
    check_found(found, TABLE, 0.94, 37.0)
    pairs = [m for m in found if m.pattern.sides == "RL" and m.pattern.cycles == 1]
    even = [m for m in pairs if abs(m.alpha[1] - math.pi) < 1e-9]
    odd = [m for m in pairs if abs(m.alpha[1] - math.pi) > 0.1]
    assert len(even) == len(odd) == 2
    assert sorted(np.abs(m.multipliers).max() for m in even) == pytest.approx(
        [3.8284, 12.0742], abs=1e-4
    )
    assert all(m.stable for m in odd)
    assert not any(m.stable for m in even)
    assert is_mirror(odd[0], odd[1])
    assert sorted(m.alpha[1] / math.pi for m in odd) == pytest.approx(
        [2 - 1.382026, 1.382026], abs=1e-6
    )
    known = vi.equispaced(TABLE, 0.94, 37.0)
    for motion in known:
        assert any(same_orbit(motion, other) for other in even)


def test_symmetric_walls_give_mirror_images():
    """With equal walls every motion has its mirror image in the list, or is its own mirror image."""
    found = vi.find(TABLE, 0.94, 37.0, max_impacts=4)
    for motion in found:
        assert any(is_mirror(motion, other) for other in found)


@pytest.mark.parametrize(("osc", "r", "clearance"), [
    (RIG, 0.9, 6.0), (UNEVEN, 1.1, 2.0), (TABLE, 0.97, 30.0),
    (vi.Oscillator(xi=0.0, mu=0.1, restitution=0.6), 0.8, 3.0),
])  # fmt: skip
def test_none_is_found_twice(osc, r, clearance):
    """Every motion is listed once, and is a solution that stays between the walls."""
    found = vi.find(osc, r, clearance, max_impacts=4)
    assert found
    check_found(found, osc, r, clearance)


def test_motion_with_rest_is_found():
    """The example's attractor is among the motions of its point, and it is stable."""
    found = vi.find(RIG, 0.9, 6.0, max_impacts=3, max_cycles=1)
    resting = [m for m in found if m.pattern.has_rest]
    assert len(resting) == 1
    assert resting[0].stable
    assert sorted(resting[0].pattern.symbols) == ["L*", "R"]
    assert np.array_equal(resting[0].multipliers[2:], [0, 0])
    assert [m.stable for m in found].count(True) == 1


def test_stable_motions_are_what_states_settle_on():
    """Every motion to which 40 random states settle in 800 cycles is listed."""
    found = [m for m in vi.find(TABLE, 0.94, 37.0) if m.stable and not m.pattern.has_rest]
    draw, seen = np.random.default_rng(5), 0
    for _ in range(40):
        x, x_dot, z_dot = 12 * draw.normal(size=3)
        first = state(draw.uniform(0, 7), x, x_dot, x + draw.uniform(-18, 18), z_dot)
        run = vi.simulate(TABLE, 0.94, 37.0, 8.3, first, discard=800)
        try:
            motion = vi.exact(TABLE, 0.94, 37.0, run)
        except vi.errors.ParameterError:
            continue
        seen += 1
        assert any(same_orbit(motion, other) for other in found), motion
    assert seen >= 10


def test_stable_motions_stay_and_unstable_ones_do_not():
    """After a small perturbation a simulation of 100 cycles returns to stable motions and leaves the others."""
    for motion in vi.find(TABLE, 0.94, 37.0, max_impacts=3, max_cycles=1):
        first = after_impact(motion)
        first["x_dot"] += 1e-6
        run = vi.simulate(TABLE, 0.94, 37.0, 400, first)
        last = run.events["x"][-40:]
        off = np.abs(last[:, None] - motion.X).min(1).max()
        assert (off < 1e-8) == motion.stable


def test_same_search_same_answer():
    """Two calls give the same motions, bit for bit, for any order of the threads."""
    one, other = (vi.find(TABLE, 0.94, 37.0, max_impacts=3) for _ in range(2))
    assert [repr(m) for m in one] == [repr(m) for m in other]
    for a, b in zip(one, other, strict=True):
        assert np.array_equal(a.X, b.X)
        assert np.array_equal(a.multipliers, b.multipliers)
    assert one.search == other.search


def test_search_says_how_it_was_done():
    """The summary counts patterns, guesses and simulated states, and says that motions can be missed."""
    found = vi.find(TABLE, 0.94, 37.0, max_impacts=3, max_cycles=2, guesses=10, states=4)
    search = found.search
    assert search.patterns == 4  # RL and RRL (or its mirror image), 1 and 2 cycles
    assert 0 < search.guesses <= 40
    assert search.states == 4
    assert 0 <= search.settled <= 4
    text = str(search)
    for word in ("patterns", "guesses", "simulated", "missed"):
        assert word in text
    more = vi.find(TABLE, 0.94, 37.0, max_impacts=3, max_cycles=2, guesses=200, states=4)
    assert more.search.guesses > search.guesses
    assert len(more) >= len(found)


def test_no_guess_and_no_state_find_nothing():
    """A search without guesses and states gives an empty list, with a summary."""
    found = vi.find(TABLE, 0.94, 37.0, max_impacts=2, max_cycles=1, guesses=0, states=0)
    assert list(found) == []
    assert found.search.guesses == found.search.states == 0


def test_load_and_lengths_scale():
    """At twice the load and the clearance `find` lists the same motions, twice as large."""
    one = vi.find(TABLE, 0.94, 37.0, max_impacts=2, max_cycles=1)
    other = vi.find(TABLE, 0.94, 74.0, max_impacts=2, max_cycles=1, load=2.0)
    # four motions of two impacts, and the attractor of twelve in five cycles on which simulations settle
    assert len(one) == len(other) == 5
    for a, b in zip(one, other, strict=True):
        assert b.load == 2.0
        assert 2 * a.X == pytest.approx(b.X, abs=1e-9)
        assert b.multipliers == pytest.approx(a.multipliers, abs=1e-8)


@pytest.mark.parametrize(("name", "value"), [
    ("r", -0.5), ("r", math.nan), ("clearance", 0.0), ("clearance", math.inf), ("load", -1.0),
    ("load", math.nan), ("max_impacts", 1), ("max_impacts", 1000), ("max_cycles", 0),
    ("max_cycles", 1000), ("guesses", -1), ("states", -1), ("settling", -1), ("max_impacts", 2.5),
])  # fmt: skip
def test_values(name, value):
    """Values outside their ranges are refused, with the name and the value."""
    with pytest.raises(vi.errors.ParameterError, match=name) as caught:
        vi.find(**{"osc": TABLE, "r": 0.94, "clearance": 37.0} | {name: value})
    assert str(value) in str(caught.value)


@pytest.mark.parametrize("name", ["osc", "r", "clearance", "max_impacts", "max_cycles", "guesses"])
@pytest.mark.parametrize("value", ["2", None, 1j, True])
def test_types(name, value):
    """Wrong types are refused by name."""
    with pytest.raises(vi.errors.ParameterTypeError, match=name):
        vi.find(**{"osc": TABLE, "r": 0.94, "clearance": 37.0} | {name: value})


def test_free_vibration_has_no_periodic_impacts():
    """Without load all motion decays, so no periodic motion is found."""
    found = vi.find(TABLE, 0.94, 37.0, max_impacts=2, max_cycles=1, load=0.0, states=4)
    assert [m for m in found if m.admissible and np.abs(m.X).max() > 1e-9] == []


def test_unstable_motion_with_rest_is_found():
    """Two motions with rest, one of them unstable, from one fold; each repeats itself when simulated."""
    osc = vi.Oscillator(xi=0.0213, mu=0.2506, restitution=(0.173, 0.632))
    r, clearance = 0.8656, 12.9043
    found = vi.find(osc, r, clearance, max_impacts=3, max_cycles=1, states=0)
    rests = [motion for motion in found if motion.pattern.has_rest]
    assert [(motion.pattern.sides, motion.stable) for motion in rests] == [
        ("LR*", True),
        ("LR*", False),
    ]
    assert rests[1].leading_kind == "positive"
    for motion in rests:
        assert motion.residual < 1e-10
        # the leading multiplier, from the rate at which a small change of one release shrinks or grows
        release = motion.events[motion.events["kind"] == "release"][0]
        sign = 1 if release["side"] == "R" else -1

        def released(push, release=release, sign=sign):
            """State of a release at the phase of the motion, with a slightly changed velocity."""
            v = release["x_dot_after"] + push
            x = np.sin(release["phase"]) - 2 * osc.xi * v
            return {
                "t": release["phase"] / r, "x": x, "x_dot": v, "z": x + sign * clearance / 2, "z_dot": v,
            }  # fmt: skip

        cycles, push = 20, 1e-6
        after = []
        for p in (push, -push):
            run = vi.simulate(osc, r, clearance, cycles, state=released(p))
            last = run.events[run.events["kind"] == "release"]
            after.append(last[["phase", "x_dot_after"]][-3:].tolist())
        grown = np.diff(np.array(after), axis=0)[0]
        rate = np.linalg.norm(grown[-1]) / np.linalg.norm(grown[-2])
        assert rate == pytest.approx(abs(motion.multipliers[0]), rel=1e-3)
    # without the search from releases neither is found
    assert "releases from rest" in str(found.search)
    assert found.search.releases == 2 * 32
    without = vi.find(osc, r, clearance, max_impacts=3, max_cycles=1, states=0, releases=0)
    assert not any(motion.pattern.has_rest for motion in without)


@pytest.mark.parametrize(("r", "clearance"), [
    (0.8373877928058429, 14.073636669583083), (0.8364626148185172, 14.479751428411182),
])  # fmt: skip
def test_what_settles_where_the_masses_resonate_together_is_listed(r, clearance):
    """The joined masses resonate at r = 1/sqrt(1 + mu) = 0.845, where |x| reaches 15 A with long rests.

    A fifth of the states with such initial velocities settle on it.
    """
    osc = vi.Oscillator(
        xi=0.008523192404041762,
        mu=0.401053499446079,
        restitution=(0.8517960973509633, 0.9457629788111999),
    )
    together = 1 / abs(1 - (1 + osc.mu) * r**2 + 2j * osc.xi * r)
    found = vi.find(osc, r, clearance, max_impacts=3, max_cycles=1, guesses=4)
    random = np.random.default_rng(5)
    settled = []
    for _ in range(40):
        x, x_dot, z_dot = random.normal(size=3) * together
        z = x + random.uniform(-0.5, 0.5) * clearance
        state = {"t": 0.0, "x": x, "x_dot": x_dot, "z": z, "z_dot": z_dot}
        run = vi.simulate(osc, r, clearance, 4, state, discard=600)
        try:
            motion = vi.exact(osc, r, clearance, run)
        except vi.errors.VibroimpactError:
            continue
        if motion.stable and motion.admissible and abs(motion.multipliers[0]) ** 600 < 1e-3:
            settled.append(motion)
    assert len(settled) >= 4
    assert max(np.abs(motion.X).max() for motion in settled) > 10 * settled[0].A
    for motion in settled:
        assert any(same_orbit(motion, other) for other in found), motion


def test_a_mirror_image_that_is_lost_ends_no_search():
    """A motion is listed even if Newton's method does not converge to its mirror image."""
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    found = vi.find(osc, 1.0, 1e-4, guesses=0, releases=0, states=4)
    assert any(motion.stable and motion.pattern.has_rest for motion in found)


def test_progress_is_told():
    """The shares of progress rise, with the pattern being searched, and the motions do not change."""
    message = []
    osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    limits = {"max_impacts": 3, "max_cycles": 1, "states": 4}
    motions = vi.find(osc, 0.94, 37.0, **limits, progress=lambda *what: message.append(what))
    shares = [share for share, _ in message]
    assert shares == sorted(shares)
    assert 0 < shares[0] <= shares[-1] <= 1
    assert {"RL/1", "RRL/1"} <= {what for _, what in message}
    assert list(map(repr, motions)) == list(map(repr, vi.find(osc, 0.94, 37.0, **limits)))


@pytest.mark.parametrize("alike", [True, False])
def test_every_pattern_has_its_share_of_the_progress(alike):
    """All orders of impacts, up to rotation and exchange of equal walls, by the square of their length."""
    osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=(0.75, 0.75 if alike else 0.6))
    told = []
    vi.find(
        osc,
        0.94,
        37.0,
        5,
        2,
        guesses=1,
        states=0,
        releases=0,
        progress=lambda *what: told.append(what),
    )

    def same(sides):
        """Return one name for all equivalent orders."""
        images = [sides, sides.translate(str.maketrans("RL", "LR"))][: 1 + alike]
        return max(image[i:] + image[:i] for image in images for i in range(len(sides)))

    orders = [order for n in range(2, 6) for order in itertools.product("RL", repeat=n)]
    wanted = {(same("".join(o)), k) for o in orders for k in (1, 2) if len(set(o)) == 2}
    patterns = [(what.split("/"), share) for share, what in told if what != "simulations"]
    assert len(patterns) == len(wanted)
    assert {(same(sides), int(cycles)) for (sides, cycles), _ in patterns} == wanted
    done = np.cumsum([len(sides) ** 2 for (sides, _), _ in patterns])
    assert np.allclose(
        [share for _, share in patterns], done / done[-1] * patterns[-1][1], rtol=1e-12
    )


def test_little_work_is_done_without_threads(monkeypatch):
    """A small search starts no thread, and gives the same motions bit for bit."""
    wanted = vi.find(RIG, 0.95, 9.0, 4, 1, guesses=12, states=4, settling=100, releases=8)
    monkeypatch.setattr(
        sys.modules["vibroimpact.studies.find"], "LITTLE", 0
    )  # the name vibroimpact.studies.find is the module
    found = vi.find(RIG, 0.95, 9.0, 4, 1, guesses=12, states=4, settling=100, releases=8)
    assert [motion.X.tolist() for motion in found] == [motion.X.tolist() for motion in wanted]
    assert str(found.search) == str(wanted.search)
    assert len(found) > 1
    monkeypatch.undo()
    monkeypatch.setattr("threading.Thread.start", lambda _: pytest.fail("a thread was started"))
    vi.find(RIG, 0.95, 9.0, 4, 1, guesses=12, states=4, settling=100, releases=8)


def check_account(found):
    """Assert that every simulated state is counted once, and that the text names each outcome."""
    search = found.search
    reasons = {
        "near an unstable motion": search.not_stable, "Newton's method finds no motion": search.unconfirmed,
        "did not repeat": search.wandering, "no more impacts": search.without_impacts,
        "could not be simulated": search.unfinished,
    }  # fmt: skip
    assert search.settled + sum(reasons.values()) == search.states
    for text, count in reasons.items():
        assert (text in str(search)) == (count > 0)


def test_attractor_of_many_letters_is_listed():
    """All states end on an impact train with rest that exceeds the limits: it is listed."""
    osc = vi.Oscillator(
        xi=0.005237033396, mu=0.267405956, restitution=(0.6664908148, 0.789348612516)
    )
    r, clearance = 0.926034818765, 0.700744637918
    found = vi.find(osc, r, clearance, max_impacts=4, max_cycles=1, guesses=8, settling=300)
    check_found(found, osc, r, clearance)
    check_account(found)
    assert found.search.settled == found.search.states == 24
    (motion,) = [m for m in found if m.stable]
    # twenty impacts on the left and one accumulation on the right, by an independent simulation
    assert sorted(motion.pattern.symbols) == ["L"] * 20 + ["R*"]
    assert attracts(motion)


def test_attractor_of_many_cycles_is_listed():
    """An attractor with more cycles and impacts than the limits is listed, with its mirror image."""
    found = vi.find(TABLE, 0.94, 37.0, max_impacts=2, max_cycles=1)
    check_found(found, TABLE, 0.94, 37.0)
    check_account(found)
    beyond = [m for m in found if len(m.pattern) > 2]
    assert [(len(m.pattern), m.pattern.cycles, m.stable) for m in beyond] == [(12, 5, True)]
    assert attracts(beyond[0])


def test_states_in_intermittent_chaos_have_not_settled():
    """At a point without stable motions, states that repeat for some time do not count as settled."""
    osc = vi.Oscillator(xi=0.005642181773706736, mu=0.04074074074074074, restitution=0.72)
    found = vi.find(osc, 0.9823623663921875, 28.0, max_impacts=4, max_cycles=1, guesses=24)
    check_account(found)
    assert not any(motion.stable for motion in found)
    assert found.search.settled == 0
    # states repeat for some time, which a simpler test would take for settled
    assert found.search.not_stable + found.search.unconfirmed > 0
    # after many more cycles no state is periodic
    assert {item.kind for item in vi.basins(
        osc, 0.9823623663921875, 28.0, states=36, cycles=2000
    ).attractors} == {"chaotic"}  # fmt: skip


@pytest.mark.parametrize(
    ("xi", "mu", "restitution", "r", "clearance"),
    [(0.3, 20, (0.6, 0.2), 0.7, 8.0), (0.3, 0.04, 0.5, 0.9, 1e3)],
)
def test_a_free_mass_that_moves_slowly_is_not_without_impacts(xi, mu, restitution, r, clearance):
    """Two impacts can be further apart than the load cycles examined, although the impacts never end."""
    osc = vi.Oscillator(xi=xi, mu=mu, restitution=restitution)
    found = vi.find(osc, r, clearance, max_impacts=2, max_cycles=1, guesses=4, states=6)
    check_account(found)
    assert list(found) == []
    assert found.search.without_impacts == found.search.settled == found.search.not_stable == 0
    start = {"x": 1.0798, "x_dot": 0.7425, "z": -0.2629, "z_dot": 0.0019}
    run = vi.simulate(osc, r, clearance, cycles=400000, state=start)
    cycles = run.events["time"] * r / TURN
    assert np.diff(cycles).max() > 1000
    assert cycles[-1] > 390000


@pytest.mark.parametrize("name", ["cpu_count"])
def test_threads_do_not_change_the_answer(name, monkeypatch):
    """The number of threads does not change motions or summary, bit for bit."""
    answers = []
    for threads in (1, 2, 5):
        monkeypatch.setattr(os, name, lambda threads=threads: threads)
        answers.append(vi.find(RIG, 0.95, 9.0, 4, 2, guesses=24, states=8, settling=200))
    for other in answers[1:]:
        assert other.search == answers[0].search
        assert [m.X.tobytes() for m in other] == [m.X.tobytes() for m in answers[0]]
        assert [m.multipliers.tobytes() for m in other] == [
            m.multipliers.tobytes() for m in answers[0]
        ]


def test_what_progress_raises_ends_the_search():
    """An exception of `progress` also stops the core."""

    def stop(share, what):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        vi.find(TABLE, 0.94, 37.0, 8, 2, progress=stop)


def test_a_stopped_search_keeps_what_it_found():
    """Ctrl-C after the first patterns keeps their motions in a result marked as cut short, also as JSON."""

    def stop(share, what):
        raise KeyboardInterrupt

    with pytest.raises(vi.errors.StudyInterrupted) as caught:
        vi.find(TABLE, 0.94, 37.0, 8, 2, progress=stop)
    found = caught.value.result
    assert not found.complete
    message = r"\d+ of 86 patterns were searched, 0 releases and 0 of 24 states were tried"
    assert re.fullmatch(message, found.cut)
    assert "RL" in [motion.pattern.sides for motion in found]
    assert 0 < found.search.patterns < 86
    check_found(found, TABLE, 0.94, 37.0)
    assert vi.FoundMotions.from_json(found.to_json()).cut == found.cut


def test_a_search_stopped_among_its_releases_is_not_complete():
    """A search stopped during its releases is incomplete, even if no states were to be simulated."""

    def stop(share, what):
        if share > 0.5:
            raise KeyboardInterrupt

    with pytest.raises(vi.errors.StudyInterrupted) as caught:
        vi.find(TABLE, 0.94, 37.0, 2, 2, guesses=1, states=0, releases=10**6, progress=stop)
    assert not caught.value.result.complete
    assert re.search(r", \d+ releases and 0 of 0 states were tried$", caught.value.result.cut)


# An independent program found the first motion, `atlas` the others; each lies in a zone of its pattern. Searches
# from guesses at the point alone find none of them.
@pytest.mark.parametrize(("osc", "r", "clearance", "sides"), [
    (vi.Oscillator(xi=0.01217, mu=0.00669, restitution=0.6442),
     1.2155878899, 2.4896275074, "RRRL"),
    (vi.Oscillator(xi=0.011034978108937223, mu=0.0806591606462771, restitution=0.606112168259465),
     0.6747261334109927, 2.932875778974124, "RRRL"),
    (vi.Oscillator(xi=0.001548761577619145, mu=0.058963257248291344,
                   restitution=(0.8964898765237495, 0.8517327004447015)),
     0.9569945985239037, 123.82368984446552, "RLL"),
    (vi.Oscillator(xi=0.015415261571253993, mu=0.0406338670902431,
                   restitution=(0.8664840270394671, 0.6433572026290861)),
     0.7081459093011717, 2.5742700956974205, "RLLLL"),
    (vi.Oscillator(xi=0.005607590419145073, mu=0.0072555916074259885, restitution=0.9444511941671303),
     0.9964485734684072, 39.886233514984326, "RRRLL"),
    (vi.Oscillator(xi=0.001002428235205874, mu=0.34340255053497015,
                   restitution=(0.6833793858566803, 0.6341701950083543)),
     0.6, 4.750097926738158, "RLLLL"),
    (vi.Oscillator(xi=0.04574888526484828, mu=0.18302956470693785,
                   restitution=(0.7625810501229096, 0.43476189622849204)),
     0.6140786992542269, 4.926482430237885, "RLLLL"),
    # only by a line that starts where RRLL grazes while it is 0.38 D beyond a wall elsewhere
    (vi.Oscillator(xi=0.002374185982558025, mu=0.01630728362595265,
                   restitution=(0.6215415626727533, 0.7888733600894499)),
     0.9899980522469702, 47.01496391078142, "RRRLL"),
])  # fmt: skip
def test_stable_motions_of_zones_are_found(osc, r, clearance, sides):
    """Branches of constant r and of constant clearance from the motions of the guesses find the stable motions."""
    found = vi.find(osc, r, clearance, 5, 1, guesses=60, states=0, releases=0)
    check_found(found, osc, r, clearance)
    pattern = [m for m in found if m.stable and m.pattern == vi.Pattern(sides)]
    assert pattern
    assert all(attracts(motion) for motion in pattern)


def test_an_old_account_can_be_read():
    """Counts by reason that an older file lacks are 0."""
    search = Search(**{
        field.name: 3 for field in dataclasses.fields(Search)
        if field.default is dataclasses.MISSING
    })  # fmt: skip
    assert search.wandering == search.lost == 0


@pytest.mark.slow
def test_states_that_settle_slowly_are_examined_again():
    """With the multiplier .99892 no state has settled after 600 cycles."""
    osc = vi.Oscillator(
        xi=0.0005404645377920503, mu=0.28751605060791563,
        restitution=(0.08164089879625747, 0.24927555332513807),
    )  # fmt: skip
    found = vi.find(
        osc, 3.145267271295667, 0.0250476858226475, max_impacts=2, max_cycles=1, guesses=4
    )
    check_account(found)
    assert found.search.settled == found.search.states
    assert found[0].stable
    assert abs(found[0].multipliers[0]) == pytest.approx(0.99892, abs=1e-5)
