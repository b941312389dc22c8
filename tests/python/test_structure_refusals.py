"""Refusals of structures, loads and their simulations, and results kept when a run stops."""

import math

import numpy as np
import pytest
import vibroimpact as vi


def test_coupled_impacts_at_one_instant_are_refused():
    """A ball hits a wall and another ball simultaneously: the impact law does not determine the result."""
    gaps = [vi.Gap([1, 0], 1.0), vi.Gap([-1, 1], 1.0)]
    s = vi.Structure([1, 1], [0, 0], [0, 0], gaps)
    with pytest.raises(vi.SingularError, match="coupled gaps"):
        vi.simulate(s, duration=3, state=([0, 0], [1, 2]))


def test_what_was_computed_before_an_error_is_kept():
    """The events of a ball between two walls, until a second ball arrives at the same time, are kept."""
    gaps = [vi.Gap([1, 0], 1.0), vi.Gap([-1, 0], 1.0), vi.Gap([-1, 1], 1.0)]
    s = vi.Structure([1, 1], [0, 0], [0, 0], gaps)
    # the first ball meets walls at t = 1, 3, 5; the second one is at 2 = 1 + 1 then
    with pytest.raises(vi.SingularError, match="coupled gaps") as caught:
        vi.simulate(s, duration=9, state=([0, -8], [1, 2]))
    part = caught.value.result
    assert part.events["time"].tolist() == [1.0, 3.0]
    assert part.events["gap"].tolist() == [0, 1]
    assert not part.complete
    assert "coupled gaps" in part.cut
    assert part.end == pytest.approx(5.0)
    assert part.sample([4.0])[0][:, 0].tolist() == [0.0, 0.0]


def test_events_before_a_rest_that_cannot_be_computed_are_kept():
    """The events before a rest at resonance, which cannot be computed, are kept."""
    structure = vi.Structure([1.0, 0.21], [0, 0], [1.21, 0], [vi.Gap([-1, 1], 0.1, 0.0)])
    load = vi.Load(1.0, sine=[0.01, 0], constant=[0, 0.5])
    with pytest.raises(vi.SingularError, match="resonates") as error:
        vi.simulate(structure, load, duration=5)
    assert error.value.result.events["kind"].tolist() == ["impact"]
    assert not error.value.result.complete


@pytest.mark.parametrize("apart", [0, 1e-15, -1e-13, 1e-10])
def test_resonance_without_damping_is_named(apart):
    s = vi.Structure([1.0], [0.0], [4.0], [])
    with pytest.raises(vi.SingularError, match="resonates"):
        vi.simulate(s, vi.Load(2.0 * (1 + apart), sine=[1.0]), cycles=1)


def test_a_slot_without_play_is_named():
    gaps = [vi.Gap([-1, 1], 0.0, 0.8), vi.Gap([1, -1], 0.0, 0.8)]
    with pytest.raises(vi.SingularError, match="a slot without play"):
        vi.simulate(
            vi.Structure([1, 0.1], [0.02, 0], [1, 0], gaps), vi.Load(1.04, sine=[0.1, 0]), cycles=2
        )


def test_a_frequency_beyond_all_units_is_named():
    with pytest.raises(vi.SingularError, match="choose other units"):
        vi.simulate(vi.Structure([1.0], [0.0], [1.0], []), vi.Load(1e300, sine=[1.0]), duration=1)


@pytest.mark.parametrize(("words", "message"), [
    ({"mass": [[1, 2], [2, 1]]}, "mass: must be positive definite; its least eigenvalue is -1"),
    ({"mass": [1, np.nan]}, "mass: must be a symmetric matrix"),
    ({"stiffness": [[1, 2], [0, 1]]}, "stiffness[0, 1] = 2.0 and stiffness[1, 0] = 0.0: must be equal"),
    ({"stiffness": [-1, 1]}, "stiffness: must have no negative eigenvalue"),
    ({"damping": [1, 2, 3]}, "damping of shape (3, 3): must be (2, 2)"),
    ({"stiffness": [1e308, 1]}, "stiffness[0, 0] = 1e+308: must be a number from -1e100 to 1e100"),
    ({"damping": [[0, 1e308], [1e308, 0]]}, "damping[0, 1] = 1e+308: must be a number from -1e100"),
    ({"mass": np.ones(501)}, "mass of shape (501,): must be for 1 to 500 coordinates"),
    ({"gaps": [vi.Gap([1], 1)]}, "gaps[0].direction has 1 number: must have 2"),
    ({"gaps": [3]}, "gaps[0] = 3: must be a vibroimpact.Gap"),
])  # fmt: skip
def test_bad_structures(words, message):
    good = {"mass": [1, 1], "damping": [0, 0], "stiffness": [1, 1], "gaps": []}
    with pytest.raises((vi.ParameterError, vi.ParameterTypeError)) as caught:
        vi.Structure(**(good | words))
    assert message in str(caught.value)


@pytest.mark.parametrize(
    "name",
    ["simulate", "periodic", "exact", "find", "branch", "zone", "basins", "lyapunov", "response"],
)
def test_help_describes_both_systems(name):
    """The help describes oscillators and structures, and names no procedure for structures only."""
    text = getattr(vi, name).__doc__
    assert "structure" in text
    assert "_structure" not in text
    first = "motion" if name in ("branch", "zone") else "structure"
    of = "a motion of a structure" if first == "motion" else "a structure"
    assert text.split("\n\n")[1].startswith(f"For {of}: ``{name}({first}, ")
    assert not hasattr(vi, f"{name}_structure")


@pytest.mark.parametrize(("words", "message"), [
    ({}, "cycles = None, duration = None: exactly one must be given"),
    ({"duration": -1}, "duration = -1.0: must be a number with 0 <= duration"),
    ({"duration": math.nan}, "duration = nan"),
    ({"cycles": 3}, "give duration without"),
    ({"duration": 1, "state": [1]}, "state = [1]: must be two lists of 1"),
    ({"duration": 1, "state": ([0, 1], [0, 1])}, "must be two lists of 1 finite numbers"),
    ({"duration": 1, "load": vi.Load(1, sine=[1, 2])}, "load for 2 coordinates: must be for 1"),
    ({"duration": 1, "max_events": 0}, "max_events = 0"),
    ({"duration": 1, "discard": -1}, "discard = -1.0: must be a number >= 0"),
    ({"duration": 1, "discard": math.nan}, "discard = nan"),
    ({"duration": 1, "discard": 1e13}, "discard = 10000000000000.0"),
    ({"duration": 1, "discard": "all"}, "discard = 'all'"),
    ({"duration": 1, "discard": 50, "state": ([0], [9]), "max_events": 3}, "within the discarded time"),
])  # fmt: skip
def test_bad_simulations(words, message):
    s = vi.Structure([1.0], [0.0], [1.0], [vi.Gap([1.0], 1.0)])
    with pytest.raises((vi.ParameterError, vi.ParameterTypeError)) as caught:
        vi.simulate(s, **words)
    assert message in str(caught.value)


def test_a_gap_that_is_less_than_closed():
    s = vi.Structure([1.0], [0.0], [1.0], [vi.Gap([1.0], 1.0)])
    with pytest.raises(vi.SingularError, match=r"negative in the initial state.*gaps\[0\] is -0.5"):
        vi.simulate(s, duration=1, state=([1.5], [0.0]))


@pytest.mark.parametrize(("words", "message"), [
    ({}, "one of them must be given"), ({"constant": 3.0}, r"constant of shape \(\): must be a list \(n,\)"),
    ({"constant": [[1, 2]]}, r"constant of shape \(1, 2\): must be a list"), ({"constant": []}, "is for 0"),
    ({"frequency": 1, "sine": [1, 0], "constant": [1, 2, 3]}, "sine is for 2, constant is for 3: must be"),
])  # fmt: skip
def test_bad_loads(words, message):
    with pytest.raises(vi.ParameterError, match=message):
        vi.Load(**words)


@pytest.mark.parametrize("n", [501, 100_000])
def test_sizes_are_checked_before_matrices_are_made(n):
    """A diagonal of 100000 numbers would be a matrix of 75 GB."""
    with pytest.raises(
        vi.ParameterError, match=rf"mass of shape \({n},\): must be for 1 to 500 coordinates"
    ):
        vi.Structure(np.ones(n), np.zeros(n), np.ones(n))
    with pytest.raises(
        vi.ParameterError, match=rf"frequencies of shape \({n},\): must be for 1 to 500"
    ):
        vi.Structure.from_modes(np.ones(n), np.zeros(n), np.ones((1, n)))


@pytest.mark.parametrize("gaps", [None, 3, [3]])
def test_gaps_of_modes_are_a_list_of_gaps(gaps):
    """The same as for matrices."""
    with pytest.raises(vi.ParameterTypeError, match="gaps"):
        vi.Structure.from_modes([1.0], [0.01], [[1.0]], gaps)


def test_events_that_do_not_fit_into_memory(monkeypatch):
    """One error of the package names the excessive size; the same holds for samples and quantities."""
    wall = vi.Structure([1.0], [0.1], [1.0], [vi.Gap([1.0], 1.0, 0.8)])
    run = vi.simulate(wall, vi.Load(1.0, cosine=[3.0]), cycles=5)

    def none(*_, **__):
        raise MemoryError("Unable to allocate 3 GiB")

    monkeypatch.setattr(np, "empty", none)
    message = "by max_events: needs more memory than is available; Unable to allocate 3 GiB"
    with pytest.raises(vi.OutOfMemoryError, match=message):
        vi.simulate(wall, vi.Load(1.0, cosine=[3.0]), cycles=5)
    with pytest.raises(vi.OutOfMemoryError, match=message):
        vi.simulate(vi.Oscillator(xi=0.01, mu=0.05, restitution=0.7), 1.0, 20.0, 5)
    with pytest.raises(vi.OutOfMemoryError, match="a sample at the times t: needs more memory"):
        run.sample([0.0])


def test_quantities_of_many_harmonics_are_those_of_few():
    """Harmonics do not depend on the number of harmonics requested."""
    wall = vi.Structure([1.0], [0.1], [1.0], [vi.Gap([1.0], 1.0, 0.8)])
    run = vi.simulate(wall, vi.Load(1.0, cosine=[3.0]), cycles=5)
    few, many = (run.quantities(harmonics=n).q.harmonics for n in (2, 400))
    np.testing.assert_allclose(many[:, :2], few, rtol=1e-13, atol=1e-15)


@pytest.mark.parametrize(("words", "message"), [
    (([1e200], [0.1], [[1]]), "frequencies[0] = 1e+200: must be numbers from 0 to 1e40"),
    (([1], [1e300], [[1]]), "damping_ratios[0] = 1e+300"),
    (([1], [0.1], [[1e300]]), "shapes with 1e+300"),
    (([1], [0.1], [[1e30]], [vi.Gap([1e30], 1)]), "gaps[0].direction and shapes give"),
    (([1], [0.1], [[1]], None), "gaps = None: must be a list"),
])  # fmt: skip
def test_modes_that_overflow(words, message):
    with pytest.raises((vi.ParameterError, vi.ParameterTypeError)) as caught:
        vi.Structure.from_modes(*words)
    assert message in str(caught.value)


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
@pytest.mark.parametrize("fault", [0.0, 1e-9])
def test_units_of_coordinates_do_not_change_what_is_refused(scale, fault):
    """A negative eigenvalue counts by its frequency, in any units of each coordinate."""
    mass = np.array([[2, 0.5, 0], [0.5, 2, 0.5], [0, 0.5, 1.0]])
    springs = np.array([[1, -1, 0], [-1, 2, -1], [0, -1, 1.0]])
    units = np.diag([scale, 1.0, 1 / scale])

    def structure(m, c, k):
        return vi.Structure(*(units @ matrix @ units for matrix in (m, c, k)), [])

    structure(mass, 0.1 * springs, springs)
    if fault:
        for words in (
            (mass, springs, springs - fault * mass),
            (mass, springs - fault * mass, springs),
        ):
            with pytest.raises(vi.ParameterError, match="no negative eigenvalue"):
                structure(*words)
        singular = np.array([[1, 1, 0], [1, 1 - fault, 0], [0, 0, 1.0]])
        with pytest.raises(vi.ParameterError, match="positive definite"):
            structure(singular, springs, springs)


@pytest.mark.parametrize(("directions", "wanted"), [
    ([[-1, 1]], r"gaps\[0\].opening = 1e-09: must be 0 or at least 7.8e-05"),
    ([[-1, 1], [1, -1]], r"gaps\[0\].opening \+ gaps\[1\].opening = 2e-09: must be at least 7.8e-05"),
])  # fmt: skip
def test_openings_below_the_rounding_of_displacements(directions, wanted):
    """Both masses oscillate with 3e5: the first impact would be at 9.1e-10 instead of 1e-9."""
    springs = [[1, -1], [-1, 1]]
    load = vi.Load(1.0, sine=[1, 0])
    state = ([0, 0], [0, 1])

    def simulated(opening):
        gaps = [vi.Gap(direction, opening, 0.8) for direction in directions]
        return vi.simulate(
            vi.Structure([1e-6, 2e-6], [0, 0], springs, gaps), load, duration=1e-8, state=state
        )

    with pytest.raises(vi.ParameterError, match=wanted):
        simulated(1e-9)
    simulated(1e-4)
    if len(directions) == 1:
        simulated(0.0)


def test_a_load_that_does_not_act_on_a_mode_does_not_resonate_with_it():
    """A symmetric load at the frequency of an undamped antisymmetric mode: the motion is symmetric."""
    rng = np.random.default_rng(4)
    for _ in range(50):
        a, b, c, outer, inner = 10 ** rng.uniform(-1, 1, 5)
        stiffness = [[a + b, -b, 0], [-b, 2 * b + c, -b], [0, -b, a + b]]
        s = vi.Structure([outer, inner, outer], [0, 0, 0], stiffness, [])
        force = rng.uniform(0.1, 1, 2)[[0, 1, 0]]
        load = vi.Load(math.sqrt((a + b) / outer), sine=force)
        q, _ = vi.simulate(s, load, cycles=3).sample([2 / load.frequency])
        assert q[0] == pytest.approx(q[2], rel=1e-9)
        with pytest.raises(vi.SingularError, match="resonates"):
            vi.simulate(s, vi.Load(load.frequency, sine=force * [1, 1, 1 + 1e-9]), cycles=3)


def test_damping_that_swallows_a_slow_motion_is_refused():
    """A dashpot of 1e100 turns the slow eigenvalue of its mode into a 0 that belongs to no mode of frequency 0."""
    with pytest.raises(vi.SingularError, match="stiff"):
        vi.simulate(
            vi.Structure([1, 1], [0.97, 1e100], [[2, -1], [-1, 1]], [vi.Gap([1, 0], 0.5, 0.8)]),
            duration=1, state=([0, 0], [5, 2]),
        )  # fmt: skip


def test_long_lists_are_shortened():
    """A message names the parameter and the allowed values, with the ends of a long list."""
    wall = vi.Structure([1], [0.1], [1], [vi.Gap([1], 1)])
    load = vi.Load(1.0, cosine=[1])
    for ask in (
        lambda: vi.Gap([1], 1, 0.8, cosine=[1] * 2000),
        lambda: vi.Load(1.0, cosine=["a"] * 2000),
        lambda: vi.periodic(wall, load, np.arange(2000.0)[::-1].tolist(), [0] * 1000),
        lambda: vi.periodic(wall, load, [0.1], [7] * 1000),
    ):
        with pytest.raises((vi.ParameterError, vi.ParameterTypeError)) as caught:
            ask()
        text = str(caught.value)
        assert len(text) < 500
        assert " = [" in text
        assert "must be" in text


@pytest.mark.parametrize("openings", [(0.5, -0.7), (-0.5, 0.3)])
def test_walls_that_overlap(openings, tmp_path):
    """Two opposite walls that overlap leave no position: the message names both and the sum."""
    gaps = [vi.Gap([side], e, 0.8) for side, e in zip((1, -1), openings, strict=True)]
    s, load = vi.Structure([1], [0.1], [1], gaps), vi.Load(1.0, cosine=[1.0])
    named = r"face each other and overlap: the sum of their openings is -0\.2, must be >= 0"
    with pytest.raises(vi.SingularError, match=r"gaps\[0\] and gaps\[1\] " + named):
        vi.simulate(s, load, cycles=3)
    case = tmp_path / "case.nml"
    case.write_text(
        "&structure mass = 1, damping = 0.1, stiffness = 1 /\n"
        + "".join(
            f"&gap direction = {side}, opening = {e} /\n"
            for side, e in zip((1, -1), openings, strict=True)
        )
        + "&load frequency = 1, cosine = 1 /\n&simulate cycles = 3 /\n"
    )
    with pytest.raises(vi.SingularError, match="gaps 0 and 1 " + named):
        vi.read_namelist(case)[0].run()


def test_moving_walls_that_overlap():
    """The walls overlap in a part of the cycle, which a shorter simulation does not reach."""
    walls = [
        vi.Gap([1], 0.5, 0.8, cosine=[0.4]),
        vi.Gap([-1], 0.1, 0.8, cosine=[0.4]),
    ]
    s, load = vi.Structure([1], [0.1], [1], walls), vi.Load(1.0, cosine=[1.0])
    message = r"falls to -0\.2, must be >= 0 at all times"
    with pytest.raises(vi.SingularError, match=message) as caught:
        vi.simulate(s, load, cycles=3)
    assert caught.value.result.end > 1
    assert vi.simulate(s, load, duration=1.0).complete


def test_a_base_that_moves_too_far():
    """An amplitude for which no motion can be computed is refused by name."""
    s = vi.Structure([1], [0.1], [1], [vi.Gap([1], 1)])
    for name in ("sine", "cosine"):
        with pytest.raises(vi.ParameterError, match=rf"{name} = \[1e\+300\]: must be .* 1e40"):
            vi.base_motion(s, 1.0, **{name: [1e300]})
