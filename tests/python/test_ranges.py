"""Ranges: every verb that sweeps takes an array, or (lo, hi) with a number of points."""

import numpy as np
import pytest
import vibroimpact as vi
from shared_systems import FIGURE6

WALL = vi.Structure([1], [0.1], [1], [vi.Gap([1], 1, 0.8)])
LOAD = vi.Load(1.0, cosine=[1])
SHORT = {"settling": 5, "keep": 5}
#: Verbs that sweep: (call of a range, its ends, the words of the arguments).
SWEEPS = {
    "bifurcation": (
        lambda x, **n: vi.bifurcation_diagram(FIGURE6, "clearance", x, r=1.04, sweep="up", **SHORT, **n),
        (20.0, 26.0), "values",
    ),
    "bifurcation of a structure": (
        lambda x, **n: vi.bifurcation_diagram(WALL, LOAD, "load", x, sweep="up", **SHORT, **n),
        (1.0, 1.5), "values",
    ),
    "bifurcation of a load": (
        lambda x, **n: vi.bifurcation_diagram(
            FIGURE6, "r", x, clearance=20.0, load=vi.Load(1.0, sine=[1, 0]), sweep="up", **SHORT, **n
        ), (1.0, 1.1), "values",
    ),
    "response": (
        lambda x, **n: vi.response(FIGURE6, x, 25.0, states=2, **SHORT, **n), (1.0, 1.1), "r",
    ),
    "response of a structure": (
        lambda x, **n: vi.response(WALL, LOAD, x, sweep="up", **SHORT, **n), (0.9, 1.1), "values",
    ),
    "lyapunov": (
        lambda x, **n: vi.lyapunov(FIGURE6, x, 20.0, cycles=8, discard=5, batches=2, **n), (1.0, 1.1), "r",
    ),
    "decay": (lambda x, **n: vi.decay(FIGURE6, x, cycles=2, **n), (0.5, 1.5), "clearance"),
    "chart": (
        lambda x, **n: vi.chart(FIGURE6, "RL", x, 25.0, symmetric=True, multipliers=False, **n), (1.0, 1.1), "r",
    ),
    "uncertainty": (
        lambda x, **n: vi.uncertainty(FIGURE6, "RL", x, 25.0, {}, samples=1, bands=False, **n), (1.0, 1.1), "r",
    ),
}  # fmt: skip


def numbers(result):
    """The result of a sweep, as a text in which NaN is equal to itself."""
    if isinstance(result, vi.Uncertainty):
        return repr((result.r, result.clearance, result.probability))
    return repr(result.to_dict())


@pytest.mark.parametrize("name", SWEEPS)
def test_a_range_is_the_array_of_its_points(name):
    """(lo, hi) with points gives the result of the evenly spaced array, and messages that name the argument."""
    sweep, (low, high), word = SWEEPS[name]
    assert numbers(sweep((low, high), points=3)) == numbers(sweep(vi.spaced(low, high, 3)))
    for wrong in ((low, high, high), (low, low), (low, np.nan), [low]):
        with pytest.raises(vi.ParameterError, match=rf"^{word} (=|of shape) .* range \(lo, hi\)"):
            sweep(wrong, points=3)
    for wrong in (1, 2.5):
        with pytest.raises(vi.ParameterError, match=r"^points = .* whole number"):
            sweep((low, high), points=wrong)


@pytest.mark.parametrize("name", SWEEPS)
def test_an_array_may_be_uneven(name):
    """Any different values in ascending order are accepted, with one result for each."""
    sweep, (low, high), _ = SWEEPS[name]
    values = [low, low + 0.1 * (high - low), high]
    found = numbers(sweep(values))
    assert found != numbers(sweep(vi.spaced(low, high, 3)))


def test_values_that_fall_give_the_same_diagram():
    """A diagram goes through its values in order, however they are listed."""
    sweep, (low, high), _ = SWEEPS["bifurcation"]
    assert numbers(sweep((high, low), points=3)) == numbers(sweep((low, high), points=3))


@pytest.mark.parametrize("name", ["chart", "uncertainty"])
def test_axes_of_planes_may_fall(name):
    """Charts and probabilities over a plane are in ascending order, in whatever order the values are listed."""
    sweep, (low, high), _ = SWEEPS[name]
    values = [low, low + 0.1 * (high - low), high]
    assert numbers(sweep(values[::-1])) == numbers(sweep(values))


def test_values_in_hertz_are_a_range():
    """A multiple of evenly spaced numbers is a range too, even if its bits are not those of a range."""
    frequencies = 2 * np.pi * np.linspace(0.14, 0.17, 4)
    assert (
        vi.response(WALL, LOAD, frequencies, sweep="up", **SHORT).values.tolist()
        == frequencies.tolist()
    )
    rig = vi.Oscillator.from_dimensional(
        M=2.7, K=42e3, C=7.4, m=0.11, restitution=0.7, F0=6.0, units="m N s"
    )
    short = dict(clearance="4 mm", states=2, **SHORT)
    ours = vi.response(rig, ("19 Hz", "20 Hz"), points=3, **short)
    assert ours.r * rig.units().frequency == pytest.approx([19, 19.5, 20])


def test_planes_of_states():
    """An axis of a plane is a name with a range or an array; others are refused by their place."""

    def plane(*axes, **options):
        return vi.basins(FIGURE6, 1.04, 25.0, axes, cycles=20, probes=4, **options).to_dict()  # fmt: skip

    first, second = (("x", -8, 8, 3), ("x_dot", -4, 4, 2))
    whole = plane(first, second)
    assert plane(("x", (-8, 8)), ("x_dot", (-4, 4)), points=(3, 2)) == whole
    assert plane(("x", np.linspace(-8, 8, 3)), ("x_dot", (-4, 4)), points=(None, 2)) == whole
    assert plane(("x", [8, 0, -8]), second) == whole
    for wrong in ([1, 2, 2], [1, 3, 2], [1], [1, np.nan]):
        with pytest.raises(
            vi.ParameterError, match=r"^plane\[1\]\[1\] of shape .* must be an array that rises or"
        ):
            plane(first, ("x_dot", wrong))
    with pytest.raises(vi.ParameterError, match=r"^plane\[0\]\[1\] = .* range \(lo, hi\)"):
        plane(("x", [1, 2, 3]), second, points=3)
    with pytest.raises(vi.ParameterError, match=r"^plane = "):
        plane(first)


def test_planes_of_uneven_values(tmp_path):
    """Each state of an uneven plane ends as the same state of a list, also after saving the plane."""
    x, x_dot = [-8, -7, 3], 2 * np.pi * np.linspace(0.5, -0.5, 3)
    short = {"cycles": 200, "probes": 9}
    found = vi.basins(FIGURE6, 1.04, 25.0, (("x", x), ("x_dot", x_dot)), **short)
    first, second = found.axes
    assert first.values.tolist() == x
    assert second.values == pytest.approx(x_dot[::-1], abs=1e-12)
    assert found.states[1].tolist() == np.repeat([x], 3, 0).T.tolist()
    alone = vi.basins(FIGURE6, 1.04, 25.0, states=found.states.reshape(5, 9), **short)
    assert found.labels.ravel().tolist() == alone.labels.tolist()
    down = vi.basins(FIGURE6, 1.04, 25.0, (("x", x[::-1]), ("x_dot", x_dot)), **short)
    assert down.to_dict() == found.to_dict()
    found.save(tmp_path / "basins.json")
    assert vi.load(tmp_path / "basins.json").axes == found.axes
    for name in ("uncertain", "uncertainty_exponent"):
        with pytest.raises(vi.ParameterError, match=r"^plane: must have evenly spaced values"):
            getattr(found, name)
    with pytest.raises(vi.ParameterError, match=r"^plane\[0\]\[1\] = .* y must be within half"):
        vi.basins(FIGURE6, 1.04, 25.0, (("y", [-13, 0, 1]), ("x", x)), **short)


def test_a_plane_of_a_structure_may_be_uneven():
    """The states of an uneven plane are its values in ascending order."""
    plane = (("q_0", [0.5, -0.2, -0.5]), ("q_dot_0", (-0.5, 0.5)))
    found = vi.basins(WALL, LOAD, plane, points=(None, 2), settling=20)
    assert found.states[0, 0, :, 0].tolist() == [-0.5, -0.2, 0.5]
    assert found.states[1, 0, 0].tolist() == [-0.5, 0.5]
    assert found.axes[0].values.tolist() == [-0.5, -0.2, 0.5]


def test_windows():
    """The ends of an array are a window; an array that reverses its direction is refused."""
    ours = {"lines": 5, "guesses": 1}
    whole = vi.zone(FIGURE6, "RL", (1.0, 1.1), (20.0, 30.0), **ours).to_dict()
    assert (
        vi.zone(FIGURE6, "RL", [1.1, 1.05, 1.0], np.linspace(20, 30, 4), **ours).to_dict() == whole
    )
    with pytest.raises(vi.ParameterError, match=r"^r of shape \(3,\): must rise or fall"):
        vi.zone(FIGURE6, "RL", [1.0, 1.1, 1.05], (20.0, 30.0))
    with pytest.raises(vi.ParameterError, match=r"^clearance = 20.0: must be"):
        vi.atlas(FIGURE6, (1.0, 1.1), 20.0)
    motion = vi.exact(WALL, LOAD, vi.simulate(WALL, LOAD, cycles=100))
    pairs = vi.zone(motion, ("frequency", (0.9, 1.1)), ("load", (0.8, 1.2)), lines=5)
    assert (
        vi.zone(motion, ("frequency", 0.9, 1.1), ("load", 0.8, 1.2), lines=5).to_dict()
        == pairs.to_dict()
    )
    with pytest.raises(vi.ParameterError, match=r"^y\[1\] = 3: must be \(parameter, \(lo, hi\)\)"):
        vi.zone(motion, ("frequency", (0.9, 1.1)), ("load", 3))


def test_charts_have_two_numbers_of_points():
    """A chart takes a number of points for each axis, or one number for both."""
    one = vi.chart(FIGURE6, "RL", (1.0, 1.1), (20.0, 30.0), symmetric=True, points=(3, 2))
    other = vi.chart(FIGURE6, "RL", vi.spaced(1.0, 1.1, 3), [20.0, 30.0], symmetric=True)
    assert one.equals(other)
    with pytest.raises(vi.ParameterError, match=r"^points\[1\] = 1"):
        vi.chart(FIGURE6, "RL", (1.0, 1.1), (20.0, 30.0), points=(3, 1))
