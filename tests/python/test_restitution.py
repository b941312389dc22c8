"""Restitution that depends on the approach speed, compared with laws and an independent event loop."""

import math

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact.explorer.opening import state_of

LAWS = [
    vi.PowerLaw(0.9, 0.3, 0.25), vi.PowerLaw(1.0, 0.5, 0.25, sharpness=0.2),
    vi.PowerLaw(0.8, 1.0, 0.234, sharpness=20), vi.PowerLaw(0.7, 2.0, 0.25, sharpness=1.0),
    vi.TabulatedRestitution([0.0, 0.5, 1.0, 3.0], [0.95, 0.9, 0.6, 0.5]),
    vi.TabulatedRestitution([0.2, 0.5, 1.0, 3.0, 4.0], [0.5, 0.9, 0.9, 0.3, 0.4]),
]  # fmt: skip
SPEEDS = np.concatenate([[0.0], np.geomspace(1e-8, 1e8, 4001)])


@pytest.mark.parametrize("law", LAWS)
def test_values_stay_between_zero_and_one(law):
    r = law(SPEEDS)
    assert ((r >= 0) & (r <= 1)).all()
    assert law(SPEEDS.reshape(2, -1)).shape == (2, 2001)


@pytest.mark.parametrize("law", LAWS)
def test_slopes(law):
    """The slope equals central differences, also at the points of a table, where it is continuous."""
    v = np.array([0.07, 0.2, 0.3, 0.5, 0.77, 1.0, 1.9, 3.0, 3.5, 4.0, 10.0])
    h = 1e-6
    differences = (law(v + h) - law(v - h)) / (2 * h)
    assert law.slope(v) == pytest.approx(differences, abs=2e-5)
    smooth = np.array([0.07, 0.77, 1.9, 3.5, 10.0])
    differences = (law(smooth + h) - law(smooth - h)) / (2 * h)
    assert law.slope(smooth) == pytest.approx(differences, abs=1e-9)


@pytest.mark.parametrize("law", [law for law in LAWS if isinstance(law, vi.PowerLaw)])
def test_the_power_law_by_its_formula(law):
    v = np.geomspace(1e-3, 1e3, 200)
    k = law.sharpness
    formula = law.R0 * (1 + (v / law.speed) ** k) ** (-law.exponent / k)
    assert law(v) == pytest.approx(formula, rel=1e-14)
    assert law(0.0) == law.R0
    far = 1e30
    assert law.slope(far) * far / law(far) == pytest.approx(-law.exponent, rel=1e-5)


@pytest.mark.parametrize("law", [law for law in LAWS if not isinstance(law, vi.PowerLaw)])
def test_tables_meet_their_points_and_are_monotone_between(law):
    assert law(law.speeds).tolist() == law.values.tolist()
    for i in range(len(law.speeds) - 1):
        between = law(np.linspace(law.speeds[i], law.speeds[i + 1], 500))
        rise = law.values[i + 1] - law.values[i]
        assert (np.diff(between) * np.sign(rise) >= -1e-15).all()
    assert law(law.speeds[-1] * 100) == law.values[-1]


def damper(law, masses=(1.0, 0.1), opening=0.5):
    gaps = [vi.Gap([-1, 1], opening, law), vi.Gap([1, -1], opening, law)]
    return vi.Structure(masses, [0.02, 0], [1, 0], gaps)


@pytest.mark.parametrize("r", [0.0, 0.37, 0.8, 1.0])
def test_constant_laws_equal_a_number(r):
    """A constant law gives the same bits as the number, for a structure that the oscillator does not cover."""
    load = vi.Load(1.04, sine=[0.3, 0])

    def dragged(law):
        pair = damper(law)
        return vi.Structure(pair.mass, [0.02, 0.001], pair.stiffness, pair.gaps)

    plain = vi.simulate(dragged(r), load, cycles=40)
    assert plain.complete
    assert len(plain.events) > 20
    for law in (vi.TabulatedRestitution([0, 1, 3], [r] * 3), vi.PowerLaw(r, 0.1, 0.0)):
        run = vi.simulate(dragged(law), load, cycles=40)
        assert run.events.tobytes() == plain.events.tobytes()
        assert run.states.tobytes() == plain.states.tobytes()


def independent_events(structure, state, duration):
    """Impacts of undamped bodies: modes by NumPy, roots by scanning and bisection."""
    omega2, shapes = np.linalg.eigh(
        structure.stiffness / np.sqrt(np.outer(*2 * [np.diag(structure.mass)]))
    )
    root = np.sqrt(np.diag(structure.mass))
    omega = np.sqrt(np.maximum(omega2, 0))

    def flight(q, rate, t):
        a, b = shapes.T @ (root * q), shapes.T @ (root * rate)
        w = np.array([math.sin(o * t) / o if o > 1e-7 else t for o in omega])
        return (
            shapes @ (np.cos(omega * t) * a + w * b) / root,
            shapes @ (np.cos(omega * t) * b - omega2 * w * a) / root,
        )

    q, rate = (np.array(part, dtype=float) for part in state)
    t, events, step = 0.0, [], 1e-3
    while t < duration:
        found = None
        for i in range(1, int((duration - t) / step) + 2):
            here, speeds = flight(q, rate, i * step)
            for j, gap in enumerate(structure.gaps):
                if gap.direction @ here > gap.opening and gap.direction @ speeds > 0:
                    low, high = (i - 1) * step, i * step
                    for _ in range(60):
                        middle = 0.5 * (low + high)
                        if gap.direction @ flight(q, rate, middle)[0] > gap.opening:
                            high = middle
                        else:
                            low = middle
                    found = (high, j)
            if found:
                break
        if not found or t + found[0] > duration:
            return np.array(events)
        dt, j = found
        q, rate = flight(q, rate, dt)
        t += dt
        gap = structure.gaps[j]
        speed = gap.direction @ rate
        kick = gap.direction / np.diag(structure.mass)
        rate = rate - (1 + float(gap.restitution(speed))) * speed / (gap.direction @ kick) * kick
        events.append((t, j, speed))
    return np.array(events)


@pytest.mark.parametrize("law", LAWS)
def test_against_an_independent_event_loop(law):
    gaps = [vi.Gap([-1, 1, 0], 0.5, law), vi.Gap([1, -1, 0], 0.5, law), vi.Gap([0, 0, 1], 0.4, law)]
    s = vi.Structure([1, 0.3, 0.5], [0, 0, 0], [[2, 0, -1], [0, 0, 0], [-1, 0, 1]], gaps)
    state = ([0.1, 0.0, 0.0], [1.0, -2.0, 0.5])
    known = independent_events(s, state, 20.0)
    run = vi.simulate(s, duration=20.0, state=state)
    assert len(known) > 5
    assert run.events["gap"].tolist() == known[:, 1].astype(int).tolist()
    assert run.events["time"] == pytest.approx(known[:, 0], abs=1e-10)
    assert run.events["speed"] == pytest.approx(known[:, 2], abs=1e-10)


@pytest.mark.parametrize("law", LAWS)
def test_the_energy_lost_at_each_impact(law):
    """Each impact dissipates m v^2 (1 - R(v)^2)/2, where m is the effective mass of the bodies."""
    s = damper(law)
    s = vi.Structure(s.mass, np.zeros((2, 2)), s.stiffness, s.gaps)
    run = vi.simulate(s, duration=60, state=([0, 0], [1, -1]))
    impacts = run.events["kind"] == "impact"
    n = len(impacts) if impacts.all() else int(np.argmin(impacts))
    assert n > 10
    states = [np.array(run.initial_state), *run.states[:n]]
    energies = [0.5 * (d @ s.mass @ d + q @ s.stiffness @ q) for q, d in states]
    v = run.events["speed"][:n]
    m = 0.1 / 1.1
    assert -np.diff(energies) == pytest.approx(0.5 * m * v**2 * (1 - law(v) ** 2), abs=1e-14)
    assert run.events["impulse"][:n] == pytest.approx((1 + law(v)) * m * v, rel=1e-13)


@pytest.mark.parametrize("law", [
    vi.PowerLaw(0.5, 1.0, 0.25), vi.PowerLaw(0.6, 1e-3, 0.5), vi.PowerLaw(0.5, 1.0, 0.25, sharpness=0.2),
    vi.TabulatedRestitution([0, 1, 5], [0.4, 0.7, 0.2]),
])  # fmt: skip
def test_a_ball_comes_to_rest(law):
    """The bounces of a ball follow v -> R(v) v, each lasts 2 v/g, and it rests at the limit of their sum."""
    g, height = 9.81, 1.0
    s = vi.Structure([2.0], [0.0], [0.0], [vi.Gap([-1.0], 0.0, law)])
    run = vi.simulate(s, vi.Load(1.0, constant=[-2.0 * g]), duration=5.0, state=([height], [0.0]))
    time, speed = math.sqrt(2 * height / g), math.sqrt(2 * height * g)
    times = []
    while speed > 1e-20:
        times.append(time)
        speed *= float(law(speed))
        time += 2 * speed / g
    impacts = run.events["time"][run.events["kind"] == "impact"]
    assert len(impacts) > 8
    assert impacts == pytest.approx(times[: len(impacts)], rel=1e-13)
    assert run.events["kind"][-1] == "stick"
    assert run.events["time"][-1] == pytest.approx(time, rel=1e-13)


def test_accumulation_is_not_completed_where_nothing_is_lost_in_the_limit():
    """With R(v) = (1 + v^2)^(-1/8) the n-th speed falls as n^(-1/2), and the sum of the bounces has no limit."""
    s = vi.Structure([1.0], [0.0], [0.0], [vi.Gap([-1.0], 0.0, vi.PowerLaw(1.0, 1.0, 0.25))])
    run = vi.simulate(
        s, vi.Load(1.0, constant=[-1.0]), duration=1e6, state=([1.0], [0.0]), max_events=3000
    )
    assert set(run.events["kind"]) == {"impact"}
    v = run.events["speed"]
    assert v[1:] == pytest.approx(v[:-1] * (1 + v[:-1] ** 2) ** -0.125, rel=1e-12)
    assert 1 / v[-1] ** 2 == pytest.approx(3000 / 4, rel=0.02)


@pytest.mark.parametrize(("make", "message"), [
    (lambda: vi.PowerLaw(1.2, 1, 0.2), "R0 = 1.2: must be"),
    (lambda: vi.PowerLaw(0.9, 0, 0.2), "speed = 0.0: must be a finite number > 0"),
    (lambda: vi.PowerLaw(0.9, 1, -0.2), "exponent = -0.2: must be a finite number >= 0"),
    (lambda: vi.PowerLaw(0.9, 1, 0.2, math.inf), "sharpness = inf: must be"),
    (lambda: vi.TabulatedRestitution([0], [1]), "speeds = [0.0]: must be at least two"),
    (lambda: vi.TabulatedRestitution([0, 0], [1, 1]), "speeds = [0.0, 0.0]: must be"),
    (lambda: vi.TabulatedRestitution([0, 1], [1, 1.1]), "values = [1.0, 1.1]: must be"),
    (lambda: vi.TabulatedRestitution([0, 1], [1, math.nan]), "values = [1.0, nan]: must be"),
    (lambda: vi.TabulatedRestitution([0, 1], [1]), "values = [1.0]: must be"),
    (lambda: vi.PowerLaw(0.9, 1, 0.2)(-1.0), "speed: must be numbers >= 0"),
    (lambda: vi.Gap([1], 1, "hard"), "restitution = 'hard'"),
])  # fmt: skip
def test_bad_laws(make, message):
    with pytest.raises((vi.ParameterError, vi.ParameterTypeError)) as caught:
        make()
    assert message in str(caught.value)


def oscillator(law):
    return vi.Oscillator(xi=0.005, mu=0.042, restitution=law)


def test_an_oscillator_with_a_law_is_its_structure():
    """Each verb gives the result of the structure with these laws, bit for bit."""
    laws = (vi.PowerLaw(0.75, 20, 0.25), vi.TabulatedRestitution([0, 10, 40], [0.8, 0.75, 0.6]))
    osc = oscillator(laws)
    pair, load = osc.structure(37.0), vi.Load(0.94, sine=[2.0, 0])
    assert [gap.restitution for gap in pair.gaps] == list(laws)
    state = {"t": 0.3, "x": 0.1, "x_dot": -1.0, "z": 2.0, "z_dot": 3.0}
    by_pair = {"start": 0.3, "state": ([0.1, 2.0], [-1.0, 3.0])}
    ours = vi.simulate(osc, 0.94, 37.0, 50, state=state, load=2.0)
    theirs = vi.simulate(pair, load, cycles=50, **by_pair)
    assert ours.events.tobytes() == theirs.events.tobytes()
    assert len(ours.events) > 20
    ours = vi.find(osc, 0.94, 37.0, states=4, guesses=4, load=2.0)
    theirs = vi.find(pair, load, states=4, guesses=4)
    assert [m.phases.tolist() for m in ours] == [m.phases.tolist() for m in theirs]
    assert ours
    more = {"cycles": 40, "discard": 10}
    ours = vi.lyapunov(osc, 0.94, 37.0, state=state, load=2.0, **more)
    assert ours.to_json() == vi.lyapunov(pair, load, **by_pair, **more).to_json()
    ours = vi.basins(osc=osc, r=0.94, clearance=37.0, states=3, settling=50, load=2.0)
    assert ours.to_json() == vi.basins(pair, load, states=3, settling=50).to_json()


def test_a_constant_law_of_an_oscillator_is_its_number():
    """Motion, multipliers and the flip along the clearance, starting from a motion with constant R."""
    plain, flat = oscillator(0.75), oscillator(vi.PowerLaw(0.75, 1.0, 0.0))
    motion = vi.exact(plain, 0.94, 37.0, ([0, 4.34], "RL"))
    same = vi.exact(flat, 0.94, 37.0, motion)
    assert np.diff(same.phases) == pytest.approx(np.diff(motion.phases), abs=1e-12)
    assert np.poly(same.multipliers) == pytest.approx(np.poly(motion.multipliers), abs=1e-9)
    ours, theirs = vi.branch(same, "opening", (15, 20)), vi.branch(motion, "clearance", (30, 40))
    assert [p.type for p in ours.special_points] == [p.type for p in theirs.special_points]
    found = [2 * point.value for point in ours.special_points]
    assert found == pytest.approx([point.clearance for point in theirs.special_points], rel=1e-9)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda osc: vi.periodic(osc, 0.94, [0, 4.3], "RL"), "restitution.*PowerLaw.*must be numbers"),
        (lambda osc: vi.equispaced(osc, 0.94, 37.0), "of osc: must be numbers"),
        (lambda osc: vi.zone(osc, "RL", (0.9, 1), (10, 20)), "of osc: must be numbers"),
        (lambda osc: vi.atlas(osc, (0.9, 1), (10, 20)), "of osc: must be numbers"),
        (lambda osc: vi.response(osc, [1.1, 1.1], clearance=10), "r of shape.*two different numbers"),
        (lambda osc: vi.response(osc, [1, 1.1], clearance=10, states=3), "states = 3: must be left out"),
        (lambda osc: vi.response(osc, [1, 1.1], 10, 0.1), "must not both be given"),
        (lambda osc: vi.bifurcation_diagram(osc, "r", [1, 1.1], r=1, clearance=5), "it is the parameter"),
        (lambda osc: vi.bifurcation_diagram(osc, "r", [1, 1.1], clearance=[5, 6]), "must be a number"),
        (lambda osc: vi.bifurcation_diagram(osc, "R2", [0.5, 0.6], 1, 5), "depends on the speed"),
        (lambda osc: vi.bifurcation_diagram(osc, "r", [1, 1.1]), "missing.*clearance"),
        (lambda osc: vi.design(osc, r=(0.9, 1.1), free={"clearance": (5, 50)}), "of host: must be numbers"),
        (state_of, "the explorer does not support laws"),
        (lambda osc: vi.simulate(osc, 0.94, 37.0, 20, state={"y": 0}), "must have some of t, x"),
        (lambda osc: vi.simulate(osc, 0.0, 37.0, 20), "r = 0.0"),
        (lambda osc: vi.exact(osc, 0.94, 37.0, ([0, 4.3], "RL*")), "must have no star"),
        (lambda osc: vi.find(oscillator((osc.restitution[0], 2)), 0.94, 37.0), r"restitution\[1\] = 2"),
    ],
)  # fmt: skip
def test_what_takes_no_law_says_so(call, words):
    with pytest.raises((vi.ParameterError, TypeError), match=words):
        call(oscillator(vi.PowerLaw(0.75, 20, 0.25)))


@pytest.mark.parametrize(
    ("name", "values", "point", "of_structure"),
    [
        ("clearance", [36.0, 37.0, 38.0], {"r": 0.94}, ("opening", [18.0, 18.5, 19.0])),
        ("r", [0.94, 0.95, 0.96], {"clearance": 37.0}, ("frequency", [0.94, 0.95, 0.96])),
        ("mu", [0.04, 0.041, 0.042], {"r": 0.94, "clearance": 37.0}, ("mass_1_1", [0.04, 0.041, 0.042])),
    ],
)  # fmt: skip
def test_diagrams_of_an_oscillator_with_a_law_are_those_of_its_structure(
    name, values, point, of_structure
):
    """The parameters of the oscillator are those of the structure; a constant law acts as its number."""
    law = vi.PowerLaw(0.75, 20, 0.25)
    osc = vi.Oscillator(xi=0.005, mu=0.04 if name == "mu" else 0.042, restitution=law)
    start = osc.at(**{"r": 0.94, "clearance": 36.0} | point)
    parameter, along = of_structure
    options = {"sweep": "up", "settling": 100, "keep": 8}
    ours = vi.bifurcation_diagram(osc, name, values, **point, **options)
    theirs = vi.bifurcation_diagram(start.structure, start.load, parameter, along, **options)
    np.testing.assert_allclose(ours.values, values, rtol=1e-15)
    assert ours.labels.tolist() == theirs.labels.tolist()
    np.testing.assert_allclose(ours.points["phase"], theirs.points["phase"], atol=1e-7)
    flat = vi.Oscillator(xi=osc.xi, mu=osc.mu, restitution=vi.PowerLaw(0.75, 1.0, 0.0))
    plain = vi.Oscillator(xi=osc.xi, mu=osc.mu, restitution=0.75)
    options |= {"settling": 400, "state": {"x_dot": 20.0, "z_dot": -30.0}}
    ours = vi.bifurcation_diagram(flat, name, values, **point, **options)
    theirs = vi.bifurcation_diagram(plain, name, values, **point, **options)
    assert ours.labels.tolist() == theirs.labels.tolist()
    assert (ours.cycles > 0).any()


def test_the_response_of_an_oscillator_with_a_law_is_that_of_its_structure():
    osc = oscillator(vi.PowerLaw(0.75, 20, 0.25))
    point = osc.at(0.9, 37.0, 2.0)
    options = {"sweep": "up", "settling": 100, "keep": 8}
    theirs = vi.response(point.structure, point.load, [0.9, 0.94], **options)
    for ours in (
        vi.response(osc, [0.9, 0.94], 37.0, load=2.0, **options),
        vi.response(osc, [0.9, 0.94], inverse_clearance=1 / 37.0, load=2.0, **options),
        vi.response(point, [0.9, 0.94], **options),
    ):
        np.testing.assert_allclose(ours.largest, theirs.largest, rtol=1e-9)
        assert ours.labels.tolist() == theirs.labels.tolist()


def test_a_load_of_several_harmonics_makes_an_oscillator_a_structure():
    """Every verb gives the result of the structure under this load; one harmonic gives that of the oscillator."""
    osc = oscillator(0.75)
    load = vi.Load(0.94, sine=[[1, 0], [0.3, 0]])
    point = osc.at(0.94, 37.0, load)
    assert point.load is load
    assert "2 harmonics" in repr(point)
    assert "2 harmonics" in point._repr_html_()
    pair = osc.structure(37.0)
    assert (
        vi.simulate(point, 30).events.tobytes()
        == vi.simulate(pair, load, cycles=30).events.tobytes()
    )
    ours = vi.find(osc, 0.94, 37.0, load=load, states=2, guesses=4)
    theirs = vi.find(pair, load, states=2, guesses=4)
    assert [m.phases.tolist() for m in ours] == [m.phases.tolist() for m in theirs]
    options = {"sweep": "up", "settling": 50, "keep": 8}
    ours = vi.response(osc, [0.9, 0.92], 37.0, load=load, **options)
    theirs = vi.response(pair, load, [0.9, 0.92], **options)
    np.testing.assert_array_equal(ours.largest, theirs.largest)
    one = vi.Load(0.94, sine=[1, 0])
    ours = vi.lyapunov(osc.at(0.94, 37.0, one), cycles=100)
    np.testing.assert_allclose(
        ours.per_cycle[:1], vi.lyapunov(pair, one, cycles=100).per_cycle[:1], rtol=1e-9
    )
    for wrong in (vi.Load(0.9, sine=[1, 0]), vi.Load(0.94, sine=[1])):
        with pytest.raises(vi.ParameterError, match=r"the frequency r = 0\.94 and 2 coordinates"):
            osc.at(0.94, 37.0, wrong)


def test_a_function_is_no_law():
    """The message names the classes of laws."""
    for make in (
        lambda law: vi.Gap([1.0], 1.0, law), lambda law: vi.Oscillator(xi=0.1, mu=0.1, restitution=law),
        lambda law: vi.Oscillator(xi=0.1, mu=0.1, restitution=(0.5, law)),
    ):  # fmt: skip
        with pytest.raises(vi.ParameterTypeError, match="PowerLaw or TabulatedRestitution"):
            make(lambda v: 0.5)
