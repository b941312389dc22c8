"""Derivatives in JAX: checked by its own differences, and on bounces with a known answer."""

import math
import subprocess
import sys

import numpy as np
import pytest
import vibroimpact as vi
from shared_motions import COLUMN
from shared_systems import RIG, TABLE

jax = pytest.importorskip("jax")
check_grads = pytest.importorskip("jax.test_util").check_grads

import vibroimpact.jax  # noqa: E402

jnp = jax.numpy


@pytest.fixture(autouse=True)
def double_precision():
    """JAX computes in single precision by default."""
    jax.config.update("jax_enable_x64", True)
    yield
    jax.config.update("jax_enable_x64", False)


@pytest.fixture(scope="module")
def uneven():
    """The motion of Table 1's third column at the clearance 37."""
    return vi.exact(TABLE, 0.94, 37.0, COLUMN)


POINT = {
    "r": 0.94,
    "clearance": 37.0,
    "xi": 0.005,
    "mu": 0.042,
    "R1": 0.75,
    "R2": 0.75,
    "load": 1.0,
}


def test_motions(uneven):
    """`check_grads` on all quantities by all parameters."""
    function = vi.jax.motion(uneven)
    check_grads(
        lambda point: function(**point), (POINT,), order=1, modes=["rev"], eps=1e-7, rtol=1e-5
    )


def test_derivatives_are_those_of_the_motion(uneven):
    """Under jit as well; a quantity without derivatives does not affect the others."""
    function = vi.jax.motion(uneven, ["X", "attenuation", "gaps_right", "stability_margin"])
    slopes = jax.jit(jax.jacrev(lambda point: function(**point)))(POINT)
    gradient = uneven.gradient()
    for name in ("X", "attenuation", "stability_margin"):
        for parameter in POINT:
            got = np.asarray(slopes[name][parameter])
            assert got == pytest.approx(gradient[name, parameter], rel=1e-9, abs=1e-9), name


def test_responses(uneven):
    """Amplitude and attenuation, and many points by vmap."""
    function = vi.jax.response(uneven)
    check_grads(
        lambda point: function(**point), (POINT,), order=1, modes=["rev"], eps=1e-7, rtol=1e-5
    )
    clearances = jnp.linspace(36.5, 37.5, 4)
    slope = jax.grad(lambda d: function(clearance=d)["attenuation"])
    many = jax.jit(jax.vmap(slope))(clearances)
    each = [slope(d) for d in clearances]
    assert np.asarray(many) == pytest.approx(np.array(each), rel=1e-14)


def test_trajectories():
    """`check_grads` on the final state after many impacts, by the initial state and all parameters."""
    osc = vi.Oscillator(xi=0.02, mu=0.1, restitution=(0.8, 0.6))
    function = vi.jax.final_state(osc, 0.9, 6.0, cycles=3, load=1.1)
    state = {"t": 0.3, "x": 0.1, "x_dot": 0.2, "z": 0.4, "z_dot": 1.5}
    point = {"r": 0.9, "clearance": 6.0, "xi": 0.02, "mu": 0.1, "R1": 0.8, "R2": 0.6, "load": 1.1}
    check_grads(
        lambda state, point: function(state, **point), (state, point), order=1, modes=["rev"], eps=1e-7,
        rtol=1e-5,
    )  # fmt: skip


def test_a_bounce():
    """A change of position before a bounce appears after it multiplied by -R.

    A simulator that applies the impact at the end of a time step gives the derivative 1 instead: it leaves out
    that the instant of the impact changes.
    """
    still = vi.Oscillator(xi=0.01, mu=0.0, restitution=(0.7, 0.5))
    function = vi.jax.final_state(still, r=1.0, clearance=4.0, cycles=0.5, load=0.0)
    duration = math.pi

    def height(z, z_dot, clearance, restitution):
        return function({"z": z, "z_dot": z_dot}, clearance=clearance, R1=restitution)["z"]

    place = (0.5, 1.2, 4.0, 0.7)
    reached = 0.5 + 1.2 * duration - 2.0
    assert float(height(*place)) == pytest.approx(2.0 - 0.7 * reached, rel=1e-14)
    slopes = jax.grad(height, argnums=(0, 1, 2, 3))(*place)
    expected = (-0.7, -0.7 * duration, (1 + 0.7) / 2, -reached)
    assert np.array(slopes) == pytest.approx(expected, rel=1e-13)
    check_grads(height, place, order=1, modes=["rev"], eps=1e-7, rtol=1e-6)


def test_an_event_that_resets_the_state():
    """With R = 0 the free mass stops at the wall: its later motion depends on the event through its state alone.

    Its place does not depend on its speed before, and the wall carries it: d z/d clearance = 1/2. A derivative
    without the change of the event's time would contain the velocity before it.
    """
    still = vi.Oscillator(xi=0.01, mu=0.0, restitution=0.0)
    function = vi.jax.final_state(still, r=1.0, clearance=4.0, cycles=0.5, load=0.0)

    def place(z, z_dot, clearance):
        return function({"z": z, "z_dot": z_dot}, clearance=clearance)["z"]

    slopes = jax.grad(place, argnums=(0, 1, 2))(0.5, 1.2, 4.0)
    assert np.array(slopes) == pytest.approx((0.0, 0.0, 0.5), abs=1e-14)


def test_rest_resets_the_velocity():
    """Accumulating impacts end in rest, and the state after the release has exact derivatives too."""
    run = vi.simulate(RIG, 0.9, 6.0, cycles=8, discard=200)
    state = {name: float(run.final_state[name]) for name in ("t", "x", "x_dot", "z", "z_dot")}
    function = vi.jax.final_state(RIG, 0.9, 6.0, cycles=1)
    again = vi.simulate(RIG, 0.9, 6.0, 1, state)
    assert (again.events["kind"] == "release").any()
    slope = jax.grad(lambda mu: function(state, mu=mu)["x"])(0.028)
    assert float(slope) == pytest.approx(float(again.gradient()["final_x", "mu"]), rel=1e-12)


def test_where_there_is_no_motion(uneven):
    """The result is NaN if the motion would pass through a wall, or a parameter is outside its range."""
    function = vi.jax.motion(uneven, ["x_max"])
    slopes = jax.grad(lambda d: function(clearance=d)["x_max"])
    for clearance in (200.0, 12.0):
        assert np.isnan(function(clearance=clearance)["x_max"])
        assert np.isnan(slopes(clearance))
    for outside in ({"mu": -1.0}, {"r": 0.0}, {"R1": 1.5}, {"xi": math.nan}, {"clearance": -3.0}):
        assert np.isnan(function(**outside)["x_max"])
        ((name, value),) = outside.items()
        assert np.isnan(
            jax.jit(jax.grad(lambda x, name=name: function(**{name: x})["x_max"]))(value)
        )
    points = jax.vmap(lambda mu: function(mu=mu)["x_max"])(jnp.array([0.042, -1.0, 0.042]))
    assert np.isfinite(points).tolist() == [True, False, True]
    final = vi.jax.final_state(TABLE, 0.9, 6.0, 1)
    for outside in ({"r": -1.0}, {"load": 1e13}, {"state": {"t": math.inf}}):
        assert np.isnan(final(**outside)["x"])
    assert np.isfinite(slopes(37.0))


def test_beyond_a_flip_and_a_pitchfork(uneven):
    """The result is NaN: the motion found there is not that of the guess."""
    branch = vi.branch(uneven, "clearance", (30, 40))
    flip = next(p for p in branch.special_points if p.type == "flip")
    (doubled,) = flip.switch()
    function = vi.jax.motion(doubled, ["x_max"])
    beyond = 2 * flip.clearance - doubled.clearance
    assert np.isfinite(function()["x_max"])
    assert np.isnan(function(clearance=beyond)["x_max"])
    assert np.isnan(jax.grad(lambda d: function(clearance=d)["x_max"])(beyond))
    function = vi.jax.motion(uneven, ["x_max"])
    assert np.isfinite(function(r=0.925)["x_max"])
    assert np.isnan(function(r=0.91)["x_max"])


def test_refused_arguments(uneven):
    """Errors are raised at once, by name."""
    with pytest.raises(vi.ParameterError, match="quantity 'x': must be one of alpha"):
        vi.jax.motion(uneven, ["x"])
    with pytest.raises(vi.ParameterError, match="parameter 'k': must be one of r"):
        vi.jax.motion(uneven)(k=1.0)
    with pytest.raises(vi.ParameterError, match="state 'v': must be one of t"):
        vi.jax.final_state(TABLE, 0.9, 6.0, 1)({"v": 1.0})
    with pytest.raises(
        vi.ParameterTypeError, match=r"parameter r = \[1, 2\]: must be a real number"
    ):
        vi.jax.motion(uneven)(r=[1, 2])
    with pytest.raises(vi.ParameterTypeError, match="state = 3: must be a mapping of t"):
        vi.jax.final_state(TABLE, 0.9, 6.0, 1)(3)
    jax.config.update("jax_enable_x64", False)
    with pytest.raises(vi.ParameterError, match="jax_enable_x64 = False: must be True"):
        vi.jax.motion(uneven)(r=0.94)


def test_missing_jax_is_said():
    """The package does not import JAX; without it, its module says how to install it."""
    code = (
        "import sys, vibroimpact; assert 'jax' not in sys.modules\n"
        "sys.modules['jax'] = None\n"
        "try:\n    import vibroimpact.jax\n"
        "except vibroimpact.MissingExtraError as error:\n    print(error)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "vibroimpact.jax needs JAX: pip install 'vibroimpact[jax]'\n"
