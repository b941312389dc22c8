"""Charts: the motions of one pattern on a grid of two parameters."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base import checks
from ..base.errors import StudyInterrupted
from ..base.libraries import xarray
from ..base.spacing import ascending, range_axes
from ..base.status import status_text
from ..motions.motion import Motion
from ..results import door
from ..results.namelist import symmetric_word
from ..results.noun import column
from ..results.parameters import Span
from ..systems.oscillator import Oscillator, Pattern, of_numbers, plain_pattern
from ..systems.units import GAP, OF_STRUCTURE
from ..systems.verbs import every_system, physical_arguments
from .branch import Followed, run_from
from .zone import keys_of_plane

if TYPE_CHECKING:
    from ..systems.units import Units

__all__ = ["Chart", "chart"]

#: The caller's names for the words of the core.
WORDS = {"sides": "pattern", "'yes'": "True", "'no'": "False", "'both'": "None"}


class Variable(NamedTuple):
    """An array with the names of its axes, its description and its unit."""

    dims: tuple[str, ...]
    values: NDArray[Any]
    attrs: dict[str, Any]


class Chart(Followed, study="chart"):
    """The motions of one pattern on a grid, as computed by the core; `to_xarray` labels them.

    `vibroimpact.chart` returns the dataset itself; `vibroimpact.load` and `Case.run` return this class.

    Attributes
    ----------
    osc : Oscillator
    pattern : Pattern
        For an oscillator.
    structure, load : Structure, Load
        For a structure, at the motion that the chart starts from.
    gaps : ndarray (N,) of int
        For a structure: the gaps of the impacts, from 0.
    cycles : int
        Load cycles in a period.
    x, y : ndarray
        For a structure: the values of both parameters.
    variables : dict of Variable
        The contents of the dataset, available without xarray: (dims, values, attrs) by name.
    attrs : dict
    """

    __slots__ = ()
    _of_start = "motion"
    x = column("abscissas")
    y = column("ordinates")

    @property
    def pattern(self) -> Pattern:
        """For an oscillator: the pattern of all motions."""
        if self.of_structure:
            raise AttributeError(self._lack("pattern", "gaps"))
        return Pattern(self.keys["sides"], self.keys["cycles"])

    @property
    def attrs(self) -> dict[str, Any]:
        """The attributes of the dataset: system, pattern, case and version."""
        from .. import __version__

        keys = self.keys
        common = {
            "source": f"vibroimpact {__version__}", "result": "Chart", "complete": int(self.complete),
            "case": self.case, "Conventions": "CF-1.11",
        }  # fmt: skip
        if self.of_structure:
            return {
                "title": "motions of a structure with impacts", "gaps": self.gaps.tolist(), "cycles": self.cycles,
                **common,
            }  # fmt: skip
        osc = self.osc
        right, left = osc.restitution
        known = {name: getattr(osc, name) for name in ("M", "K", "F0", "unit_names")}
        known = {} if osc.F0 is None else known
        return {
            "title": f"motions {keys['sides']}/{keys['cycles']} of a vibrating system with impacts",
            "xi": osc.xi, "mu": osc.mu, "R1": right, "R2": left, "sides": keys["sides"],
            "cycles": keys["cycles"], "load": 1.0, **known,
            "units": "length in F0/K, time in 1/omega, angles in radians",
            "motions": {"yes": "symmetric", "no": "not symmetric", "both": "all"}[keys["symmetric"]],
            **{name: keys[name] for name in ("slots", "guesses", "seeds")}, **common,
        }  # fmt: skip

    @cached_property
    def variables(self) -> dict[str, Variable]:
        tables = self._result.tables
        plane = ("y", "x") if self.of_structure else ("clearance", "r")
        grid, flags = ("motion", *plane), np.array([1, 0, -1], np.int8)
        columns = {
            name: np.moveaxis(item.values, (0, 1, 2), (-1, -2, -3))
            for name, item in tables["motions"].columns.items()
        }
        multipliers, codes = columns["multipliers"], np.unique(columns["status"])
        moduli = np.hypot(multipliers.real, multipliers.imag)
        variables: dict[str, tuple[Any, Any, str, str]] = {
            "multiplier_modulus": (
                ("multiplier", *grid), moduli, "1",
                "modulus of the multipliers (eigenvalues of [P]), leading one first",
            ),
            "multiplier_angle": (
                ("multiplier", *grid), np.angle(multipliers), "rad", "angle of the multipliers",
            ),
            "found": (
                plane, tables["points"].columns["found"].values.T, "1", "motions found at the point",
            ),
            **self._own_variables(columns, grid),
        }  # fmt: skip
        found = {
            name: Variable(
                dims, np.ascontiguousarray(values), {"long_name": meaning, "units": unit}
            )
            for name, (dims, values, unit, meaning) in variables.items()
        }
        for name in ("consistent", "admissible", "stable"):
            about = {
                "long_name": f"whether the motion is {name}", "units": "1", "flag_values": flags,
                "flag_meanings": "yes no unknown",
            }  # fmt: skip
            found[name] = Variable(grid, columns[name].astype(np.int8), about)
        about = {
            "long_name": "status of the slot", "units": "1", "flag_values": codes,
            "flag_meanings": "; ".join(map(status_text, codes.tolist())),
        }  # fmt: skip
        found["status"] = Variable(grid, columns["status"], about)
        if self.of_structure:
            found["gap"] = Variable(("impact",), self.gaps, {"long_name": "gap of the impact"})
            return found
        walls = np.array(self.pattern.symbols)
        found["side"] = Variable(
            ("impact",), walls, {"long_name": "wall of the impact, right or left"}
        )
        return found

    def _own_variables(
        self, columns: dict[str, Any], grid: tuple[str, ...]
    ) -> dict[str, tuple[Any, Any, str, str]]:
        """The variables of charts of this kind of system, each with dimensions, values, unit and meaning."""
        if self.of_structure:
            names = {axis: str(self.keys[axis]) for axis in "xy"}
            # of the structure of an oscillator; others have the units of their user
            unit = {
                name: item.unit for name, item in self._result.tables["motions"].columns.items()
            }
            axis = {
                key: OF_STRUCTURE.get(name.split("_")[0], "") if unit["q_max"] else ""
                for key, name in names.items()
            }
            period = (
                {"period": (grid, columns["period"], unit["period"], "period")}
                if self.self_excited else {}
            )  # fmt: skip
            return period | {
                "q_min": (
                    ("coordinate", *grid), columns["q_min"], unit["q_min"], "smallest value of each coordinate",
                ),
                "q_max": (
                    ("coordinate", *grid), columns["q_max"], unit["q_max"], "greatest value of each coordinate",
                ),
                "phases": (("impact", *grid), columns["phases"], "rad", "load phase of each impact"),
                "speeds": (
                    ("impact", *grid), columns["speeds"], unit["speeds"], "approach speed of each impact",
                ),
                "x": (("x",), self.x, axis["x"], names["x"]), "y": (("y",), self.y, axis["y"], names["y"]),
            }  # fmt: skip
        tables = self._result.tables
        r, clearance = (
            tables["ratios"].columns["r"].values,
            tables["clearances"].columns["clearance"].values,
        )
        with np.errstate(divide="ignore", over="ignore"):
            a = 1 / np.hypot((1 - r) * (1 + r), 2 * self.osc.xi * r)
        attenuation = np.maximum(-columns["x_min"], columns["x_max"]) / a
        return {
            "x_min": (grid, columns["x_min"], "F0/K", "least position of the primary mass"),
            "x_max": (grid, columns["x_max"], "F0/K", "greatest position of the primary mass"),
            "attenuation": (grid, attenuation, "1", "greatest |x| over the amplitude without impacts"),
            "tau": (grid, columns["tau"], "rad", "phase of the forced motion at the first impact"),
            "alpha": (
                ("impact", *grid), columns["phases"], "rad", "phase of each impact from the first one on",
            ),
            "X": (
                ("impact", *grid), columns["X"], "F0/K", "position of the primary mass at each impact",
            ),
            "A": (("r",), a, "F0/K", "amplitude without impacts"),
            "r": (("r",), r, "1", "frequency ratio Omega/omega"),
            "clearance": (("clearance",), clearance, "F0/K", GAP),
        }  # fmt: skip

    def __getitem__(self, name: str) -> Variable:
        return self.variables[name]

    @property
    def drawable(self) -> bool:  # type: ignore[override]
        """Whether it has motions."""
        return not self._result.empty

    def to_xarray(self) -> Any:
        """An xarray.Dataset with the variables on their axes (extra `data`).

        Returns
        -------
        xarray.Dataset
            As `vibroimpact.chart` returns it.
        """
        own = {name: tuple(item) for name, item in self.variables.items()}
        names = ("x", "y", "gap") if self.of_structure else ("r", "clearance", "side")
        coords = {name: own.pop(name) for name in names}
        return xarray("charts").Dataset(own, coords, self.attrs)

    def plot(
        self, ax: Any = None, color: str | None = None, inverse: bool = False, units: Units | str | None = None,
    ) -> Any:  # fmt: skip
        """Draw where the motions are stable, unstable, inadmissible or absent; see `plot.draw_chart`.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Axes to draw on; by default those of a new figure.
        color : {"multiplier", "attenuation"}, optional
            The quantity by which stable motions are shaded.
        inverse : bool
            For an oscillator: draw F0/(d K) on the vertical axis instead of d K/F0.
        units : Units or str, optional
            As in `Trajectory.plot`.

        Returns
        -------
        Axes
            The Axes with the picture.
        """
        return self._draw(ax, color, inverse, units=units)

    def __repr__(self) -> str:
        sizes = self._result.tables["points"].dims
        cut = "" if self.complete else f"; cut short, {self.cut}"
        if self.of_structure:
            return (
                f"<Chart of {self.gaps.size} impacts: {sizes['x']} values of {self.keys['x']}, "
                f"{sizes['y']} of {self.keys['y']}{cut}>"
            )
        return (
            f"<Chart of {self.pattern.sides}/{self.pattern.cycles}: {sizes['r']} frequency ratios, "
            f"{sizes['clearance']} clearances{cut}>"
        )


def chart_structure(
    motion: Motion,
    x: Span | tuple[Any, ArrayLike],
    y: Span | tuple[Any, ArrayLike],
    points: int | tuple[int, int] = 33,
    threads: int | None = None,
    progress: door.Progress | None = None,
    x_at: float | None = None,
    y_at: float | None = None,
) -> Any:
    """As `chart`, for a motion of a structure."""
    xarray("charts")
    both = points if isinstance(points, tuple) and len(points) == 2 else (points, points)
    keys, names = keys_of_plane(motion.structure, motion._given_load, (x, y), (x_at, y_at))
    for name, axis, n in zip("xy", (x, y), both, strict=True):
        values = axis[1] if len(axis) == 2 else ()
        if np.ndim(values) == 1 and np.size(values) > 2:  # two numbers are a range
            array = checks.real_array(values, f"{name}[1]", "numbers that rise or fall throughout")
            keys[f"{name}_values"] = np.sort(array).tolist()
            names[f"{name}_values"] = f"{name}[1]"
        else:
            keys[f"{name}_points"], names[f"{name}_points"] = n, "points"
    try:
        return run_from(motion, Chart, keys, names, progress, threads).to_xarray()
    except StudyInterrupted as stop:
        raise StudyInterrupted(stop.result.to_xarray()) from None


@overload
def chart(
    osc: Oscillator, pattern: Pattern | str, r: ArrayLike, clearance: ArrayLike, symmetric: bool | None = None, *,
    points: int | tuple[int, int] | None = None, multipliers: bool = True, slots: int = 4, guesses: int = 32,
    seeds: int = 12, threads: int | None = None, progress: door.Progress | None = None,
) -> Any: ...  # fmt: skip
@overload
def chart(
    motion: Motion, x: Span | tuple[Any, ArrayLike], y: Span | tuple[Any, ArrayLike],
    points: int | tuple[int, int] = 33, threads: int | None = None, progress: door.Progress | None = None,
    x_at: float | None = None, y_at: float | None = None,
) -> Any: ...  # fmt: skip


@physical_arguments
@every_system(
    chart_structure, Motion, no_point="give its osc, a pattern, and values of r and clearance"
)
def chart(
    osc: Oscillator,
    pattern: Pattern | str,
    r: ArrayLike,
    clearance: ArrayLike,
    symmetric: bool | None = None,
    *,
    points: int | tuple[int, int] | None = None,
    multipliers: bool = True,
    slots: int = 4,
    guesses: int = 32,
    seeds: int = 12,
    threads: int | None = None,
    progress: door.Progress | None = None,
) -> Any:
    """The motions of a pattern at every point of a grid, as a labelled dataset (extra `data`).

    For an oscillator: two equally spaced impacts with equal restitution (the pattern RL, k odd) have a closed
    form. All other motions are found by Newton's method: a search at some points of the grid, then from each
    solved point to its neighbours.

    For a motion of a structure: the motions with the same impacts over the plane of any two parameters. The motion
    is followed along the lines of the grid, and from each crossing of two lines further motions are followed, as
    by `zone`, including unstable and inadmissible ones. Sheets that are not connected to the motion need separate
    charts.

    Parameters
    ----------
    osc : Oscillator
        The system: xi, mu and the coefficients of restitution of both walls.
    pattern : Pattern or str
        Without rest.
    motion : Motion
        For a structure, in place of the oscillator and the pattern; as in `zone`.
    x, y : (parameter, (float, float)) or (parameter, array_like)
        For a structure, in place of r and clearance: each a parameter, as in `branch`, with its range, or with 3
        to 129 values that rise or fall throughout.
    points : int or (int, int), optional
        Numbers of evenly spaced values if r and clearance are ranges; for a structure, numbers of values of x and
        y, 2 to 129, 33 by default.
    r, clearance : array_like, or (float, float)
        Frequency ratios and clearances d K/F0 that rise or fall throughout, at most 1000000 points altogether; d
        is the whole travel of m between the walls. With `points` each is a range (lo, hi), or one number.
    symmetric : bool, optional
        True: only motions that are their own mirror image half a period later (of RL these are the equispaced
        ones); False: only the other motions; None: both.
    multipliers : bool
        Whether to compute the multipliers of the equispaced motions. If not, they are NaN; the verdict
        `stable` is the same, and the chart takes a fraction of the time.
    slots : int
        Number of slots for motions that have no closed form, 1 to 32.
    guesses, seeds : int
        Number of guesses of the search at each point, and number of search points along each axis. A zone that
        contains none of these points, and is not connected to one that does, is not found.
    threads : int, optional
        Default: one for each processor. The result is identical for any number.
    progress : callable, optional
        Called a few times a second with the fraction done and the current task; by default a bar on a terminal
        or in a notebook.
    x_at, y_at : float, optional
        For a structure: the value of the parameter at the motion, if the parameter is a function.

    Returns
    -------
    xarray.Dataset
        With the dimensions `motion` (slot), `clearance` and `r`:

        - `consistent`, `admissible`, `stable`: 1, 0, or -1 for unknown;
        - `multiplier_modulus`, `multiplier_angle` (first dimension `multiplier`), leading one first;
        - `x_min`, `x_max`, `attenuation` (max|x|/A), `tau`, and `X`, `alpha` (first dimension
          `impact`);
        - `status`: 0 where there is a motion; other codes are explained by `status_text`;
        - `found`: number of motions at the point, including those for which there was no slot.

        A slot is continuous over the grid. The equispaced pair has the slots 0 and 1, in the order of
        `equispaced`: tau above and below the mean of the two. The other motions follow: motions that continue each
        other from point to point share a slot. Slots go first to the motions with the most admissible and stable
        points, then to those with the most admissible ones. Where there are more motions than `slots`, a slot may
        change from one motion to another; an admissible and stable motion always takes precedence over one that is
        not.

        For a structure, the dimensions are `motion`, `y` and `x`; in place of X, tau and so on there are `q_min`,
        `q_max` (first dimension `coordinate`), `phases` and `speeds` (first dimension `impact`), and `period` of
        self-excited motions. At each point, the motion whose leading multiplier has the smallest modulus comes
        first.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; nothing was computed.
    MissingExtraError
        If xarray is missing.
    StudyInterrupted
        After Ctrl-C, once the motions found so far are finished (this takes at most about a fifth of the time of a
        large search); its attribute `result` is the dataset so far, with a special status where nothing was
        computed.

    Examples
    --------
    >>> import numpy as np, vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    >>> data = vi.chart(
    ...     osc, vi.Pattern("RL"), np.linspace(0.9, 1.1, 21), np.geomspace(5, 100, 16), symmetric=True
    ... )
    >>> dict(data.sizes)["motion"]
    2
    >>> int(((data.admissible == 1) & (data.stable == 1)).any("motion").sum())
    107

    The motion of a mass that hits one wall, over the frequency and the amplitude of the load:

    >>> wall = vi.Structure(mass=[1], damping=[0.1], stiffness=[1], gaps=[vi.Gap([1], 1, 0.8)])
    >>> load = vi.Load(1.0, cosine=[1])
    >>> motion = vi.exact(wall, load, vi.simulate(wall, load, cycles=300))
    >>> data = vi.chart(motion, ("frequency", (0.8, 1.2)), ("load", (0.5, 2)), points=(9, 7))
    >>> data.stable.dims, int(((data.admissible == 1) & (data.stable == 1)).any("motion").sum())
    (('motion', 'y', 'x'), 59)
    """
    xarray("charts")
    r, clearance = map(ascending, range_axes(r, clearance, points))
    options = {"slots": slots, "guesses": guesses, "seeds": seeds}
    try:
        found = compute_chart(
            osc, pattern, r, clearance, symmetric, multipliers, threads, progress, **options
        )
    except StudyInterrupted as stop:
        raise StudyInterrupted(stop.result.to_xarray()) from None
    return found.to_xarray()


def compute_chart(
    osc: Oscillator, pattern: Pattern | str, r: ArrayLike, clearance: ArrayLike, symmetric: bool | None,
    multipliers: bool, threads: int | None, progress: door.Progress | None, *, slots: int = 4,
    guesses: int = 32, seeds: int = 12,
) -> Chart:  # fmt: skip
    """The result of `chart` as a `Chart`, which does not need xarray."""
    of_numbers(osc)
    pattern = plain_pattern(pattern)
    with_multipliers = checks.truth(multipliers, "multipliers")
    keys = {
        "sides": pattern.sides, "cycles": pattern.cycles, **door.line("r", r),
        **door.line("clearance", clearance, geometric=True), "symmetric": symmetric_word(symmetric),
        "slots": slots, "guesses": guesses, "seeds": seeds,
        "multipliers": "yes" if with_multipliers else "no",
    }  # fmt: skip
    names = {"r_points": "r", "clearance_points": "clearance", "r_min": "r[0]", "r_max": "r[-1]"}
    names |= {"clearance_min": "clearance[0]", "clearance_max": "clearance[-1]"}
    names["increasing numbers"] = (
        "increasing or decreasing numbers"  # `chart` reverses decreasing numbers
    )
    return door.run(
        Chart, osc, keys, threads=threads, progress=progress, parameters={**names, **WORDS}
    )
