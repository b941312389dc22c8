"""Motions, their responses and trajectories as functions for JAX, with exact derivatives (extra `jax`).

Each function in this module returns a function of parameters that works under `jax.jit`, `jax.vmap`, `jax.grad`
and `jax.jacrev`. The core computes its values and derivatives in double precision, on the host, one point after
another. Derivatives are those of `Motion.gradient` and `Trajectory.gradient`, in reverse mode and of first order.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .base import checks
from .base.errors import MissingExtraError, ParameterError, ParameterTypeError, SingularError
from .derivatives.gradient import PARAMETERS
from .motions.exact import exact
from .motions.motion import Motion
from .motions.trajectory import simulate
from .results.gradient import Gradient
from .results.states import NEEDED
from .systems.oscillator import Oscillator, of_numbers

try:
    import jax
except ImportError:
    raise MissingExtraError("vibroimpact.jax needs JAX: pip install 'vibroimpact[jax]'") from None

__all__ = ["final_state", "motion", "response"]

_Array = NDArray[np.float64]
#: The parameters, without R, which would set both coefficients of restitution to one value.
NAMES = tuple(name for name in PARAMETERS if name != "R")
#: Quantities of a motion by default.
QUANTITIES = (
    "phases", "X", "Z", "X_dot_before", "X_dot_after", "Z_dot_before", "Z_dot_after", "A", "tau",
    "x_max", "x_min", "attenuation", "stability_margin",
)  # fmt: skip


def motion(guess: Motion, quantities: Sequence[str] = QUANTITIES) -> Callable[..., dict[str, Any]]:
    """The exact motion near a guess, as a function of the parameters.

    Parameters
    ----------
    guess : Motion
        The motion from which Newton's method starts in each call.
    quantities : sequence of str
        Real quantities of `Motion.gradient`.

    Returns
    -------
    callable
        Takes any of r, clearance, xi, mu, R1, R2 and load by name; the others have the values of the guess. It
        returns a dict with an array for each quantity. The array is NaN where there is no motion, where `exact`
        finds another motion beyond a flip or a pitchfork, where the motion would pass through a wall (unless the
        guess does), and where a parameter is outside its range. Derivatives that do not exist are NaN.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed, or JAX computes in single precision.

    Examples
    --------
    >>> import jax, vibroimpact as vi, vibroimpact.jax
    >>> jax.config.update("jax_enable_x64", True)
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> motion = vi.jax.motion(vi.equispaced(osc, 0.94, 37.0)[0], ["x_max"])
    >>> round(float(jax.grad(lambda d: motion(clearance=d)["x_max"])(37.0)), 6)
    0.128797
    """
    checks.instance(guess, "guess", Motion)
    first = guess.gradient()
    if not isinstance(quantities, Sequence):
        raise ParameterTypeError(f"quantities = {quantities!r}: must be a list of names")
    names = list(quantities)
    real = [name for name in first.values if name != "multipliers"]
    for name in names:
        if name not in real:
            raise ParameterError(f"quantity {name!r}: must be one of {', '.join(real)}")
    shapes = [first.values[name].shape for name in names]
    own = [guess.r, guess.clearance, guess.osc.xi, guess.osc.mu, *guess.osc.restitution, guess.load]

    def compute(point: _Array) -> Gradient:
        r, clearance, xi, mu, *walls, load = point.tolist()
        osc = Oscillator(xi=xi, mu=mu, restitution=(walls[0], walls[1]))
        found = exact(osc, r, clearance, guess, load)
        if guess.admissible and found.admissible is False:
            raise SingularError("the motion would pass through a wall")
        return found.gradient()

    function = differentiable(compute, names, shapes, NAMES)

    def evaluate(**parameters: Any) -> dict[str, Any]:
        return function(filled(parameters, dict(zip(NAMES, own, strict=True))))

    return evaluate


def response(guess: Motion) -> Callable[..., dict[str, Any]]:
    """The response of the primary mass in the exact motion near a guess, as a function of the parameters.

    Parameters
    ----------
    guess : Motion
        As in `motion`.

    Returns
    -------
    callable
        As in `motion`, but the dict contains `amplitude`, max|X|, and `attenuation`, max|X|/A.

    Raises
    ------
    ParameterError, ParameterTypeError
        As for `motion`.

    Examples
    --------
    >>> import jax, vibroimpact as vi, vibroimpact.jax
    >>> jax.config.update("jax_enable_x64", True)
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> response = vi.jax.response(vi.equispaced(osc, 0.94, 37.0)[0])
    >>> round(float(jax.grad(lambda mu: response(mu=mu)["attenuation"])(0.042)), 4)
    28.4669
    """
    function = motion(guess, ["attenuation", "A"])

    def evaluate(**parameters: Any) -> dict[str, Any]:
        found = function(**parameters)
        return {"amplitude": found["attenuation"] * found["A"], "attenuation": found["attenuation"]}

    return evaluate


def final_state(
    osc: Oscillator, r: float, clearance: float, cycles: float, load: float = 1.0
) -> Callable[..., dict[str, Any]]:
    """The final state of a simulation, as a function of its initial state and of the parameters.

    Parameters
    ----------
    osc, r, clearance, load
        As in `simulate`: the default values of the parameters.
    cycles : float
        Load cycles to simulate.

    Returns
    -------
    callable
        Takes a mapping with any of t, x, x_dot, z and z_dot (0 otherwise), and any of r, clearance, xi, mu, R1,
        R2 and load by name. It returns a dict with t, x, x_dot, z and z_dot at the end: NaN where the simulation
        fails, and where a number is outside its range.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed, or JAX computes in single precision.

    Examples
    --------
    >>> import jax, vibroimpact as vi, vibroimpact.jax
    >>> jax.config.update("jax_enable_x64", True)
    >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    >>> final = vi.jax.final_state(osc, r=1.04, clearance=25.0, cycles=5)
    >>> slopes = jax.grad(lambda state: final(state)["x"])({"x": 1.0, "z_dot": 3.0})
    >>> sorted(slopes)
    ['x', 'z_dot']
    """
    of_numbers(osc)
    checks.number(cycles, "cycles_simulated", "cycles")
    own = dict(zip(NAMES, (r, clearance, osc.xi, osc.mu, *osc.restitution, load), strict=True))

    def compute(point: _Array) -> Gradient:
        state, values = point[:5].tolist(), point[5:].tolist()
        r, clearance, xi, mu, *walls, load = values
        changed = Oscillator(xi=xi, mu=mu, restitution=(walls[0], walls[1]))
        start = dict(zip(NEEDED, state, strict=True))
        return simulate(changed, r, clearance, cycles, start, load=load).gradient()

    names = [f"final_{name}" for name in NEEDED]
    function = differentiable(compute, names, [()] * 5, NEEDED + NAMES)

    def evaluate(state: Mapping[str, Any] | None = None, **parameters: Any) -> dict[str, Any]:
        given = {} if state is None else state
        if not isinstance(given, Mapping):
            raise ParameterTypeError(f"state = {given!r}: must be a mapping of {', '.join(NEEDED)}")
        start = filled(given, dict.fromkeys(NEEDED, 0.0), "state")
        found = function(jax.numpy.concatenate([start, filled(parameters, own)]))
        return {name: found[f"final_{name}"] for name in NEEDED}

    return evaluate


def filled(given: Mapping[str, Any], own: Mapping[str, float], what: str = "parameter") -> Any:
    """The given numbers, with defaults for missing ones, as one array."""
    if not jax.config.jax_enable_x64:
        raise ParameterError(
            "jax_enable_x64 = False: must be True, since motions need double precision: "
            "jax.config.update('jax_enable_x64', True)"
        )
    for name in given:
        if name not in own:
            raise ParameterError(f"{what} {name!r}: must be one of {', '.join(own)}")
    point = []
    for name, value in own.items():
        try:
            point.append(jax.numpy.asarray(given.get(name, value), float).reshape(()))
        except (TypeError, ValueError):
            raise ParameterTypeError(
                f"{what} {name} = {given[name]!r}: must be a real number"
            ) from None
    return jax.numpy.stack(point)


def differentiable(
    compute: Callable[[_Array], Gradient], names: list[str], shapes: list[tuple[int, ...]],
    parameters: Sequence[str],
) -> Callable[[Any], dict[str, Any]]:  # fmt: skip
    """A function that JAX can differentiate, made from one on the host that returns values and derivatives."""
    sizes = [int(np.prod(shape)) for shape in shapes]
    total = sum(sizes)

    def on_host(point: Any) -> tuple[_Array, _Array]:
        try:
            gradient = compute(np.asarray(point, float))
        # no motion, or a parameter outside its range: JAX would hide the name of an error raised in compiled code
        except (SingularError, ParameterError):
            return np.full(total, np.nan), np.full((total, len(parameters)), np.nan)
        values = [np.ravel(gradient.values[name]) for name in names]
        columns = [gradient.parameters.index(parameter) for parameter in parameters]
        slopes = [
            gradient[name][..., columns].reshape(size, -1)
            for name, size in zip(names, sizes, strict=True)
        ]
        return np.concatenate(values), np.concatenate(slopes)

    def called(point: Any) -> Any:
        of = (
            jax.ShapeDtypeStruct((total,), np.float64),
            jax.ShapeDtypeStruct((total, len(parameters)), np.float64),
        )
        return jax.pure_callback(on_host, of, point, vmap_method="sequential")

    flat = jax.custom_vjp(lambda point: called(point)[0])

    def pulled(slopes: Any, weights: Any) -> tuple[Any]:
        # quantities with zero weight may lack derivatives
        terms = jax.numpy.where(weights[:, None] == 0, 0.0, weights[:, None] * slopes)
        return (terms.sum(axis=0),)

    flat.defvjp(called, pulled)

    def function(point: Any) -> dict[str, Any]:
        parts = jax.numpy.split(flat(point), np.cumsum(sizes)[:-1])
        return {
            name: part.reshape(shape)
            for name, part, shape in zip(names, parts, shapes, strict=True)
        }

    return function
