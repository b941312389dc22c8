"""Free vibration: the peaks, and the damping by impacts, stops and friction."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from typing import TYPE_CHECKING, Any, ParamSpec, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base import checks
from ..base.errors import ParameterError, SingularError
from ..base.spacing import range_values
from ..results import door
from ..results.noun import Noun, column
from ..systems.oscillator import Oscillator
from ..systems.structure import Load, Structure, counted
from ..systems.units import SI, has_unit, own_number, positive
from ..systems.verbs import every_system, physical_arguments

if TYPE_CHECKING:
    from ..systems.units import Units, Value

__all__ = ["Decay", "decay"]

Given = ParamSpec("Given")
#: The first arguments of `decay`.
NAMES = (
    "osc",
    "clearance",
    "amplitude",
    "inverse_clearance",
    "x_dot",
    "y",
    "z_dot",
    "cycles",
    "points",
)


class Decay(Noun, study="decay"):
    """The peaks of free vibrations: one run for each clearance, or one run of a structure.

    A peak is the greatest \\|x\\| between two zeros of x, the displacement of the primary mass or that of a
    structure in a direction. Runs are stored one after another; `run` gives the run of each peak.

    Attributes
    ----------
    osc, clearance : Oscillator, ndarray (runs,)
        For an oscillator.
    structure, load : Structure, Load or None
        For a structure.
    run : ndarray (n,) of int
        Run of each peak, from 0.
    time, x : ndarray (n,)
        Time (in 1/omega for an oscillator) and displacement; its sign gives the side.
    decrement : ndarray (n,)
        ln(x/x'), where x' is the next peak on the same side, one cycle later; NaN for the last two peaks of a run.
        It is negative if other masses return energy.
    damping : ndarray (n,)
        decrement/sqrt(4 pi^2 + decrement^2): xi of a linear oscillator with this decrement.
    energy : ndarray (n,)
        Energy of all masses, springs and compressed stops (over F0^2/K for an oscillator); after the impact, if
        the peak is at an impact.
    impacts, rests : ndarray (n,) of int
        Number since the previous peak, or since the start; contacts with stops count as impacts, and halts by
        friction as rests.
    status : ndarray (runs,) of int
        0 done; see `status_text`.
    case : str
        The case as a namelist.
    complete : bool
        False if Ctrl-C stopped the study early; `cut` then says how far it got.
    """

    __slots__ = ()
    clearance = column("runs")
    status = column("runs")
    time = column("peaks")
    x = column("peaks")
    decrement = column("peaks")
    damping = column("peaks")
    energy = column("peaks")
    impacts = column("peaks")
    rests = column("peaks")

    @property
    def run(self) -> NDArray[np.int32]:
        """Run of each peak, from 0."""
        owners = self._result.tables["peaks"].owners
        return np.zeros(0, np.int32) if owners is None else owners

    def require(self) -> None:
        """Raise a SingularError if there is no peak of a structure."""
        if self.of_structure and self._result.empty:
            raise SingularError(self._result.notes[0][1])

    def plot(
        self, ax: Any = None, kind: str | None = None, units: Units | str | None = None
    ) -> Any:
        """Draw the peaks against time, and the damping of each cycle (extra `plot`).

        The damping of a cycle is drawn against the peak at which it begins.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Axes for one panel; only this panel is then drawn.
        kind : {"peaks", "damping"}, optional
            The only panel to draw; "peaks" if only `ax` is given.
        units : Units or str, optional
            As in `Trajectory.plot`.

        Returns
        -------
        Axes, or an array of Axes
            Both Axes, or the Axes of the panel.
        """
        return self._draw(ax, kind, units=units)

    def __repr__(self) -> str:
        cut = "" if self.complete else f"; cut short, {self.cut}"
        known = self.damping[np.isfinite(self.damping)]
        peaks = counted(self.x.size, "peak")
        runs = "of a structure"
        if not self.of_structure:
            runs = f"at {counted(self.clearance.size, 'clearance')}"
        if not known.size:
            return f"<Decay {runs}: {peaks}{cut}>"
        damping = f"damping ratio of a cycle from {known.min():.4g} to {known.max():.4g}"
        return f"<Decay {runs}: {peaks}, {damping}{cut}>"


def with_length(function: Callable[Given, Decay]) -> Callable[Given, Decay]:
    """A decorator: for a rig without a load, F0/K is the amplitude, so that lengths may have units."""

    @wraps(function)
    def scaled(*args: Given.args, **kwargs: Given.kwargs) -> Decay:
        values: dict[str, Any] = dict(zip(NAMES, args, strict=False)) | kwargs
        osc: Any = values.get("osc")
        rig = isinstance(osc, Oscillator) and osc.K is not None and osc.F0 is None
        if (
            not rig
            or len(args) > len(NAMES)
            or not any(has_unit(values.get(name)) for name in NAMES)
        ):
            return function(*args, **kwargs)
        amplitude = values.get("amplitude", 1.0)
        if not has_unit(amplitude):
            raise ParameterError(
                f"amplitude = {amplitude!r}: must have a unit, as other values have, if F0 of the oscillator is "
                "not known"
            )
        names = osc.unit_names or SI
        length = positive(own_number(amplitude, "d", names, "amplitude"), "amplitude")
        any_function: Callable[..., Decay] = function
        return any_function(**values | {"osc": replace(osc, F0=osc.K * length)})

    return scaled


def decay_structure(
    structure: Structure,
    load: Load | None = None,
    state: tuple[ArrayLike, ArrayLike] | None = None,
    direction: ArrayLike | str | None = None,
    cycles: int = 20,
    max_events: int = 10_000_000,
    progress: door.Progress | None = None,
) -> Decay:
    """As `decay`, for a structure."""
    if isinstance(load, Load) and load.frequency:
        raise ParameterError(
            f"load = {load!r}: must be constant or left out, since the vibration is free"
        )
    keys = door.start_keys(structure, state, 0.0)
    del keys["start"]
    if isinstance(direction, str):
        checks.choice(direction, "direction", tuple(structure.outputs))
        direction = structure.outputs[direction]
    keys |= {"direction": direction, "cycles": cycles, "max_events": max_events}
    found = door.run_structure(
        Decay, structure, load, keys, None, progress, needs_frequency=False, stops=True
    )
    found.require()
    return found


@overload
def decay(
    osc: Oscillator, clearance: ArrayLike | None = None, amplitude: Value = 1.0,
    inverse_clearance: ArrayLike | None = None, x_dot: Value = 0.0, y: Value = 0.0, z_dot: Value = 0.0,
    cycles: int = 20, points: int | None = None, max_events: int = 10_000_000, threads: int | None = None,
    progress: door.Progress | None = None,
) -> Decay: ...  # fmt: skip
@overload
def decay(
    structure: Structure, load: Load | None = None, state: tuple[ArrayLike, ArrayLike] | None = None,
    direction: ArrayLike | str | None = None, cycles: int = 20, max_events: int = 10_000_000,
    progress: door.Progress | None = None,
) -> Decay: ...  # fmt: skip


@with_length
@physical_arguments
@every_system(decay_structure, no_point="give its osc and clearance, or its structure")
def decay(
    osc: Oscillator,
    clearance: ArrayLike | None = None,
    amplitude: Value = 1.0,
    inverse_clearance: ArrayLike | None = None,
    x_dot: Value = 0.0,
    y: Value = 0.0,
    z_dot: Value = 0.0,
    cycles: int = 20,
    points: int | None = None,
    max_events: int = 10_000_000,
    threads: int | None = None,
    progress: door.Progress | None = None,
) -> Decay:
    """The peaks and the damping of free vibration, for one or several clearances, or of a structure.

    There is no load, except constant forces on a structure. For an oscillator, F0/K is then an arbitrary unit of
    length: only the ratio of clearance to amplitude matters, and with the default amplitude the clearance is in
    units of the initial displacement. If F0 of a rig is not known and values have units, F0 is chosen so that F0/K
    is the amplitude.

    Parameters
    ----------
    osc : Oscillator
        The system: xi, mu and the coefficients of restitution of both walls.
    structure, load : Structure, Load or None
        In place of `osc`, with gaps, stops and friction; the load may only have a `constant`.
    clearance : float or array_like (runs,), or (float, float)
        Clearance d K/F0; d is the whole travel between the walls. With `points` a range (lo, hi).
    amplitude : float
        Displacement of the primary mass at the start.
    inverse_clearance : float or array_like (runs,), or (float, float)
        F0/(d K), in place of the clearance.
    x_dot : float
        Velocity of the primary mass at the start.
    y, z_dot : float
        Position z - x of the free mass between the walls, 0 in the middle, and its velocity at the start.
    state : (array_like, array_like)
        For a structure: coordinates and velocities at the start.
    direction : array_like (n,) or str, optional
        For a structure: coefficients of the coordinates in the displacement whose peaks are found, or the name of
        an output; by default the first coordinate.
    cycles : int
        Oscillations: a run ends with peak 2 cycles + 1, or when friction or damping has ended the motion.
    points : int, optional
        Number of evenly spaced values of a range.
    max_events : int
        Events (impacts, rests, releases) after which one simulation is abandoned; its status says so.
    threads : int, optional
        For an oscillator: one for each processor by default. The result does not depend on it.
    progress : callable, optional
        Called a few times a second with the fraction done and the current task; by default a bar on a terminal
        or in a notebook.

    Returns
    -------
    Decay
        The peaks of all runs.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; the message names the parameter, its value and what is allowed.
    SingularError
        If the motion of a structure has no peak because nothing pulls it back, or if the simulation fails.
    StudyInterrupted
        After Ctrl-C; its attribute `result` contains the clearances whose runs were completed.

    Examples
    --------
    As long as the free mass touches no wall, the damping is that of the dashpot.

    >>> import vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.005, mu=0.1, restitution=0.75)
    >>> vi.decay(osc, 6.0).damping[0].round(12)
    np.float64(0.005)
    >>> vi.decay(osc, [0.3, 0.7, 1.5])
    <Decay at 3 clearances: 123 peaks, damping ratio of a cycle from -0.2005 to 0.2452>

    Friction reduces each peak of a mass on a spring by twice its force over the stiffness, until the mass sticks:

    >>> mass = vi.Structure(mass=[1], damping=[0], stiffness=[1], friction=[vi.Friction([1], 0.1)])
    >>> vi.decay(mass, state=([0.85], [0])).x.round(12).tolist()
    [0.85, -0.65, 0.45, -0.25, 0.05]
    """
    clearance = range_values(clearance, "clearance", points)
    inverse_clearance = range_values(inverse_clearance, "inverse_clearance", points)
    keys = {
        "clearance": clearance, "inverse_clearance": inverse_clearance, "amplitude": amplitude,
        "x_dot": x_dot, "y": y, "z_dot": z_dot, "cycles": cycles,
        "max_events": max_events,
    }  # fmt: skip
    return door.run(Decay, osc, keys, threads=threads, progress=progress)
