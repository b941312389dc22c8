"""Simultaneous impacts on coupled gaps, by Newton's law at all of them and in sequence."""

import numpy as np
import pytest
import vibroimpact as vi
from reference_regimes import ReferenceRegimes

LAWS = ("newton", "sequence")


def cradle(balls, law, restitution=1.0, offset=0.0):
    """Equal balls in a row; the first one is 1 away from the others."""
    directions = np.eye(balls)[:-1] - np.eye(balls)[1:]
    openings = [1.0] + [offset] * (balls - 2)
    gaps = [vi.Gap(g, e, restitution) for g, e in zip(directions, openings, strict=True)]
    return vi.Structure([1] * balls, [0] * balls, [0] * balls, gaps, simultaneous=law)


def thrown(structure, speeds, duration=1e-9, **options):
    """The velocities after a short simulation from q = 0, and the impulse on each gap."""
    n = structure.coordinates
    run = vi.simulate(structure, duration=duration, state=(np.zeros(n), speeds), **options)
    impulses = np.zeros(len(structure.gaps))
    for event in run.events:
        impulses[event["gap"]] += event["impulse"]
    return run, run.final_state[1], impulses


def test_both_laws_are_named_where_none_is_chosen():
    """The error names the laws, and the change of an opening that avoids the ambiguity."""
    with pytest.raises(vi.SingularError) as caught:
        thrown(cradle(3, None), [1, 0, 0], 2)
    for word in ("simultaneous", "newton", "sequence", "1e-12"):
        assert word in str(caught.value)


@pytest.mark.parametrize("balls", [3, 5])
def test_cradle_of_balls_that_touch(balls):
    """In sequence the last ball leaves alone; by Newton's law all but the first move on at 2/N, a known result."""
    start = [1.0] + [0.0] * (balls - 1)
    run, speeds, impulses = thrown(cradle(balls, "sequence"), start, 3)
    assert speeds.tolist() == [0.0] * (balls - 1) + [1.0]
    hits = run.events[run.events["kind"] == "impact"]
    assert hits["gap"].tolist() == list(range(balls - 1))
    assert np.all(hits["time"] == 1.0)
    # the same balls 1e-12 apart
    _, apart, _ = thrown(cradle(balls, None, offset=1e-12), start, 3)
    assert np.abs(apart - speeds).max() < 1e-15
    _, speeds, impulses = thrown(cradle(balls, "newton"), start, 3)
    assert np.abs(speeds - ([2 / balls - 1] + [2 / balls] * (balls - 1))).max() < 1e-15
    assert np.abs(impulses - 2 / balls * np.arange(balls - 1, 0, -1)).max() < 1e-14


def test_rod_on_two_ends():
    """A uniform rod falls flat: by Newton's law both ends rebound at R, in sequence one end after the other."""
    to_ends = np.array([[-1.0, -0.5], [-1.0, 0.5]])
    a = to_ends @ np.diag([1.0, 12.0]) @ to_ends.T
    for restitution in (1.0, 0.5, 0.0):
        gaps = [vi.Gap(g, 0.0, restitution) for g in to_ends]
        for law in LAWS:
            rod = vi.Structure([1, 1 / 12], [0, 0], [0, 0], gaps, simultaneous=law)
            run, speeds, _ = thrown(rod, [-1.0, 0.0])
            closing, hits = np.array([1.0, 1.0]), []
            while law == "sequence" and closing.max() > 1e-14:
                end = int(closing.argmax())
                hits.append(end)
                closing = closing - a[:, end] * (1 + restitution) * closing[end] / a[end, end]
            if law == "newton":
                closing = -restitution * closing
            assert np.abs(to_ends @ speeds - closing).max() < 1e-13
            if hits and restitution:
                assert run.events["gap"].tolist() == hits
    # without loss both laws give the mirror image
    assert len(hits) != 2


def test_energy_and_momentum_of_random_structures():
    """Impulses are >= 0 and balance the momentum; no gap closes afterwards; the energy never grows and stays where
    R = 1; impulses of Newton's law obey its complementarity, and where it would add energy it is refused."""
    rng = np.random.default_rng(3)
    tried, reasons = 0, []
    for trial in range(150):
        n = int(rng.integers(2, 6))
        many = int(rng.integers(2, n + 1))
        root = rng.normal(size=(n, n))
        mass, g = root @ root.T + n * np.eye(n), rng.normal(size=(many, n))
        a = g @ np.linalg.solve(mass, g.T)
        if np.linalg.cond(a) > 100:
            continue
        r = [np.ones(many), np.full(many, 0.7), rng.uniform(0, 1, many)][trial % 3]
        gaps = [vi.Gap(*each) for each in zip(g, np.zeros(many), r, strict=True)]
        before = rng.normal(size=n)
        for law in LAWS:
            s = vi.Structure(mass, np.zeros((n, n)), np.zeros((n, n)), gaps, simultaneous=law)
            try:
                run, after, impulses = thrown(s, before)
            except vi.SingularError as error:
                reasons.append((law, trial % 3, "add energy" in str(error)))
                continue
            tried += 1
            assert (run.events["impulse"] >= 0).all()
            assert np.abs(mass @ (after - before) + g.T @ impulses).max() < 1e-11
            assert (g @ after < 1e-12).all()
            change = (after @ mass @ after) / (before @ mass @ before) - 1
            assert change < 1e-12
            if trial % 3 == 0:
                assert abs(change) < 1e-11
            if law == "newton" and (g @ before > 0).all():
                excess = g @ after + r * (g @ before)
                assert (excess < 1e-12).all()
                assert np.abs(impulses * excess).max() < 1e-11
    assert tried > 200
    assert set(reasons) == {("newton", 2, True)}


def test_legs_of_a_table():
    """Four legs have dependent directions: with one R the speeds are still determined."""
    legs = np.array([[-1.0, x, y] for x in (-1, 1) for y in (-1, 1)])
    table = vi.Structure(
        [1, 0.5, 0.5], [0] * 3, [0] * 3, [vi.Gap(g, 0.0, 0.6) for g in legs], simultaneous="newton"
    )
    _, speeds, _ = thrown(table, [-1.0, 0.0, 0.0])
    assert np.abs(speeds - [0.6, 0, 0]).max() < 1e-15


def test_sequence_that_hardly_ends():
    """Two walls at an angle of 1e-5, between which a body would collide 3e5 times."""
    gaps = [vi.Gap([1, 0], 0.0), vi.Gap([-1, 1e-5], 0.0)]
    wedge = vi.Structure([1, 1], [0, 0], [0, 0], gaps, simultaneous="sequence")
    with pytest.raises(vi.SingularError, match="20000 successive impacts"):
        thrown(wedge, [1.0, 1.0])


@pytest.mark.parametrize("law", LAWS)
def test_ball_on_a_ball_at_rest(law):
    """A ball falls on a ball that lies on a table; both come to rest, with or without other elements."""
    gaps = [vi.Gap([-1, 0, 0], 0.0, 0.5), vi.Gap([1, -1, 0], 0.0, 0.5)]
    weights = vi.Load(constant=[-1.0, -1.0, 0.0])
    for parts in ({}, {"friction": [vi.Friction([0, 0, 1], 0.01)]}):
        stops = [vi.Stop([0, 0, 1], 0.1, 10.0)] if parts else []
        s = vi.Structure(
            [1, 0.7, 1], [0] * 3, [0, 0, 1], [*gaps, *stops], simultaneous=law, **parts
        )
        run = vi.simulate(s, weights, duration=12, state=([0, 0.5, 0], [0, 0, 0.3]))
        assert len(run.events)
        assert run.sample([12.0])[0][:2, 0] == pytest.approx([0, 0], abs=1e-7)
        times = run.events["time"]
        assert (np.diff(times) >= 0).all()
        # energy of the balls after all simultaneous impacts
        last = np.append(np.diff(times) > 0, True)
        q, rate = run.states[:, 0, :2], run.states[:, 1, :2]
        energy = q.sum(axis=1) + 0.5 * (rate**2 @ np.array([1, 0.7]))
        assert (np.diff(energy[last]) < 1e-12).all()


def test_friction_after_impacts_at_one_instant():
    """The last ball of a cradle, which stuck before, slips in the direction of its speed."""
    gaps, friction = cradle(3, None).gaps, [vi.Friction([0, 0, 1], 0.1)]
    s = vi.Structure([1] * 3, [0] * 3, [0] * 3, gaps, friction, simultaneous="sequence")
    run = vi.simulate(s, duration=6, state=([0, 0, 0], [1, 0, 0]))
    assert run.sample([6.0])[1][:, 0] == pytest.approx([0, 0, 0.5], abs=1e-14)
    assert run.events["kind"].tolist().count("slip_up") == 1


def rod_on_springs(law):
    """A driven mass with a second coordinate, which meets two walls at once as long as it does not turn."""
    gaps = [vi.Gap([1, -1], 0.3, 0.3), vi.Gap([1, 1], 0.3, 0.3)]
    return vi.Structure([1.0, 0.2], [0.1, 0.5], [1.0, 1.0], gaps, simultaneous=law)


def test_motion_with_impacts_at_one_instant():
    """Such a motion repeats itself, but has no multipliers and gives the reason; other verbs refuse it by name."""
    s, load = rod_on_springs("newton"), vi.Load(0.9, sine=[0.5, 0])
    run = vi.simulate(s, load, cycles=100)
    motion = vi.exact(s, load, run)
    assert motion.gaps.tolist() == [0, 1]
    assert np.ptp(motion.phases) == 0
    assert (motion.consistent, motion.stable) == (True, None)
    assert np.isnan(motion.multipliers).all()
    assert "no derivatives" in motion.without_multipliers
    times = run.end - np.linspace(0.5, 6.5, 9)
    assert np.abs(motion.sample(times)[0] - run.sample(times)[0]).max() < 1e-11
    assert np.isnan(vi.exact(s, load, motion).multipliers).all()
    (same,) = vi.find(s, load, max_impacts=4, threads=1)
    assert same.stable is None
    again = vi.find(s, load, max_impacts=4, threads=2)[0]
    assert again.states.tobytes() == same.states.tobytes()
    assert again.phases.tobytes() == same.phases.tobytes()
    for refused in (
        lambda: vi.branch(motion, "load", (0.5, 1.2)),
        lambda: vi.lyapunov(s, load, cycles=50),
        lambda: run.gradient(["load"]),
        motion.gradient,
    ):
        with pytest.raises(
            (vi.ParameterError, vi.SingularError), match=r"coupled gaps|derivatives"
        ):
            refused()


def unbalanced(found):
    """The energy that quantities leave unexplained, as a share of the work and the losses."""
    losses = found.damping_loss, found.impact_loss, found.friction_loss
    return abs(found.work - sum(losses) - found.energy_change) / (
        abs(found.work) + np.abs(losses).sum()
    )


@pytest.mark.parametrize("element", ["none", "friction", "stop"])
@pytest.mark.parametrize("law", LAWS)
def test_motions_with_rests_and_impacts_at_one_instant(law, element):
    """Balls that land on each other and rest on a shaken floor, also with friction or a stop: the motion is
    that of a simulation much later, rests included, and has no verdict of stability."""
    rng = np.random.default_rng(5)
    found = 0
    for _ in range(12):
        n = int(rng.integers(2, 4))
        mass, r = rng.uniform(0.3, 2, n), float(rng.choice([0, 0.1, 0.3]))
        gaps = [vi.Gap(-row, 0.0, r) for row in np.eye(n) - np.eye(n, k=-1)]
        friction = [vi.Friction(np.eye(n)[0], 0.05)] if element == "friction" else []
        if element == "stop":
            gaps.append(vi.Stop(np.eye(n)[-1], 1.0, stiffness=20, damping=0.2))
        s = vi.Structure(mass, np.zeros((n, n)), np.zeros((n, n)), gaps, friction, simultaneous=law)
        load = vi.Load(
            rng.uniform(1.2, 3), constant=-mass, cosine=rng.uniform(1.5, 3) * mass[0] * np.eye(n)[0]
        )
        try:
            motion = vi.exact(s, load, vi.simulate(s, load, cycles=200))
        except vi.SingularError:
            continue
        if not motion.without_multipliers:
            continue
        found += 1
        assert motion.stable is None
        assert motion.admissible is not False
        assert len(motion.rests)
        period = motion.cycles * 2 * np.pi / load.frequency
        later = vi.simulate(s, load, cycles=motion.cycles, discard=400 * motion.cycles)
        times = later.start + np.linspace(0.01, 0.99, 50) * period
        q = np.array(later.sample(times)[0])
        assert np.abs(motion.sample(times)[0] - q).max() < 1e-8 * np.abs(q).max()
        again = vi.exact(s, load, motion)
        assert np.abs(again.sample(times)[0] - q).max() < 1e-8 * np.abs(q).max()
        assert unbalanced(motion.quantities()) < 1e-8
    assert found or (law, element) == ("newton", "friction")


def rod_with_elements(rng, law):
    """A driven rod that falls flat on two walls, pressed stops that cannot pull, and perhaps friction."""
    r = rng.uniform(0.5, 0.9, 2 if law == "sequence" else 1)
    gaps = [vi.Gap([1, -1], 0.3, r[0]), vi.Gap([1, 1], 0.3, r[-1])]
    for _ in range(rng.integers(1, 3)):
        opening, k, c = rng.uniform(-0.1, 0.28), rng.uniform(1, 10), rng.uniform(1, 4)
        gaps.append(vi.Stop([1, rng.choice([0, 0.4])], opening, k, c, release="force"))
    friction = [vi.Friction([1, 0], rng.uniform(0.05, 0.2))] if rng.random() < 0.5 else []
    mass = [rng.uniform(0.5, 2), rng.uniform(0.1, 0.4)]
    s = vi.Structure(mass, [0.1, 0.05], [1.0, 1.0], gaps, friction, simultaneous=law)
    return s, vi.Load(rng.uniform(0.7, 1.5), sine=[rng.uniform(0.3, 1), 0])


@pytest.mark.parametrize("law", LAWS)
def test_energy_of_motions_of_a_rod(law):
    """The work of the load is what dashpots, friction and impacts at one instant dissipate."""
    rng = np.random.default_rng(6)
    for _ in range(20):
        s, load = rod_with_elements(rng, law)
        start = [rng.uniform(-0.3, 0.1), 0.0], [rng.uniform(0.5, 2), 0.0]
        try:
            run = vi.simulate(s, load, duration=3, state=start)
        except vi.SingularError as error:
            run = error.result
        assert unbalanced(run.quantities(window=(0.0, run.end))) < 1e-10


@pytest.mark.parametrize("law", LAWS)
def test_stops_and_friction_after_impacts_at_one_instant(law):
    """Stops that such impacts make pull let go at that instant, and friction opposes its new speed: times, states
    and the kinds of changes are those of a simulation by matrix exponentials."""
    rng = np.random.default_rng(4)
    changed = 0
    for _ in range(30):
        s, load = rod_with_elements(rng, law)
        start = [rng.uniform(-0.3, 0.1), 0.0], [rng.uniform(0.5, 2), 0.0]
        try:
            run = vi.simulate(s, load, duration=5, state=start)
        except vi.SingularError as error:
            run = error.result
        # up to where impacts follow each other too closely for the steps of the reference
        hits = np.unique(run.events["time"][run.events["kind"] == "impact"])
        close = hits[1:][np.diff(hits) < 0.01]
        duration = close.min(initial=run.end) - 0.005
        run = vi.simulate(s, load, duration=duration, state=start)
        reference = ReferenceRegimes(s, load, 1e-3)
        known = reference.simulate(duration, start)
        # the reference has one impact at each instant
        last = np.append(np.diff(run.events["time"]) > 0, True)
        times = np.array([t for t, *_ in known])
        final = np.append(np.diff(times) > 1e-9, True)
        assert run.events["time"][last] == pytest.approx(times[final], abs=1e-9)
        states = np.array([y for *_, y in known])[final]
        assert np.abs(run.states[last].reshape(len(states), -1) - states).max() < 1e-8
        for kind in ("let_go", "press", "touch", "leave", "slip_up", "slip_down"):
            assert np.sum(run.events["kind"] == kind) == [k for _, k, *_ in known].count(kind)
        assert np.abs(np.concatenate(run.final_state) - reference.final).max() < 1e-8
        hit = np.flatnonzero(
            (run.events["kind"][:-1] == "impact") & (np.diff(run.events["time"]) == 0)
        )
        changed += np.sum(np.isin(run.events["kind"][hit + 1], ["let_go", "press"]))
    assert changed > 5


@pytest.mark.parametrize("law", LAWS)
def test_history_of_friction_along_a_gap_that_others_release(law):
    """The history of balls that hit one with friction, which rests, reaches the state of each next event, and that
    friction has no events while its gap rests."""
    rng = np.random.default_rng(0)
    compared = 0
    for _ in range(10):
        mass = rng.uniform(0.3, 2, 3)
        gaps = [vi.Gap(-g, 0.0, rng.uniform(0.3, 0.9)) for g in np.eye(3) - np.eye(3, k=-1)]
        friction = [vi.Friction([1, 0, 0], 0.3 * mass[0])]
        s = vi.Structure(mass, [0] * 3, [0] * 3, gaps, friction, simultaneous=law)
        load = vi.Load(1.0, constant=-mass, cosine=[mass[0] * rng.uniform(0, 3), 0, 0])
        try:
            run = vi.simulate(s, load, duration=6, state=([0, 0.3, 0.9], [0, 0, 0]), max_events=500)
        except vi.SingularError as error:
            run = error.result
        rests = False
        for kind, gap in run.events[["kind", "gap"]].tolist():
            rests = (rests and (kind, gap) != ("release", 0)) or (kind, gap) == ("stick", 0)
            assert not (rests and gap == 3)
        times = run.events["time"]
        for i in np.flatnonzero(np.diff(times) > 1e-3):
            q = run.sample([times[i + 1] - 1e-10])[0][:, 0]
            assert np.abs(q - run.states[i + 1, 0]).max() < 1e-8
            compared += 1
    assert compared > 50


def test_a_motion_of_a_run_that_was_cut_short_says_so():
    """With friction, the impacts of two bodies on a base go on at one instant; without an exact motion the error
    names the reason for which the simulation ended."""
    mass = np.array([0.9914769035997333, 0.49857880900859963])
    gaps = [vi.Gap(-row, 0.0, 0.3) for row in np.eye(2) - np.eye(2, k=-1)]
    bodies = vi.Structure(
        mass, np.zeros((2, 2)), np.zeros((2, 2)), gaps, [vi.Friction([1, 0], 0.05)], simultaneous="sequence"
    )  # fmt: skip
    load = vi.Load(2.335808151474926, constant=-mass, cosine=[2.5899912444599895, 0.0])
    run = vi.simulate(bodies, load, cycles=200, max_events=20000)
    assert not run.complete
    with pytest.raises(vi.SingularError, match="cut short, max_events was reached"):
        vi.exact(bodies, load, run)


def test_law_is_kept(tmp_path):
    """Files, namelists, texts and copies keep the law; structures with different laws differ."""
    s = cradle(3, "sequence")
    assert "simultaneous='sequence'" in repr(s)
    assert s != cradle(3, "newton")
    assert s == cradle(3, "sequence")
    run = vi.simulate(s, vi.Load(1.0, sine=[0, 0, 0.1]), duration=3, state=([0, 0, 0], [1, 0, 0]))
    run.save(tmp_path / "run.json")
    assert vi.load(tmp_path / "run.json").structure == s
    modal = vi.Structure.from_modes(
        [1.0], [0.1], [[1.0]], [vi.Gap([1], 0.1)], simultaneous="newton"
    )
    assert modal.simultaneous == "newton"
    with pytest.raises(vi.ParameterError, match="simultaneous = 'both'"):
        cradle(3, "both")
