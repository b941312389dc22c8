"""The type that every solver returns: a periodic motion with impacts."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass, fields
from typing import Any, ClassVar, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from ..base import checks
from ..base.errors import ParameterError
from ..base.sizes import memory_for
from ..base.status import NO_MOTION, VERDICT, raise_status
from ..results import namelist
from ..results.events import (
    EVENT_TYPE,
    Sample,
    event_columns,
    events_of,
    sample,
    segments,
    with_accelerations,
)
from ..results.gradient import Gradient
from ..results.noun import ACTIONS, Noun, Savable
from ..results.tables import Result, Table, made, runs
from ..systems.oscillator import Oscillator, Pattern
from .quantities import Quantities, quantities_of

__all__ = ["Motion", "Motions", "Sample"]

#: Columns of the core's tables of motions and impacts; those of impacts by their names here.
OF_MOTION = (
    "r", "clearance", "A", "tau", "residual", "x_min", "x_max", "load", "kind", "precision",
)  # fmt: skip
VERDICTS = ("consistent", "admissible", "stable")
OF_IMPACTS = {
    "restitution": "restitution", "phases": "phase", "X": "X", "Z": "Z", "X_dot_before": "X_dot_before",
    "X_dot_after": "X_dot_after", "Z_dot_before": "Z_dot_before", "Z_dot_after": "Z_dot_after",
}  # fmt: skip
#: The codes of the verdicts in tables.
CODES = {True: 1, False: 0, None: -1}
#: Largest residual of a consistent motion, unless &motion specifies another.
ACCEPTANCE = 0.03

#: The leading arguments of the core's procedures on a finished motion.
_Array = NDArray[np.float64]
_Flights = tuple[float, float, float, int, NDArray[np.int32], _Array, _Array, _Array, float, float]


@dataclass(frozen=True, eq=False, repr=False, slots=True)
class Motion(Savable, study="motion"):
    """A periodic motion with impacts. Lengths in F0/K, velocities in omega F0/K, angles in radians.

    Motions come from `periodic`, `equispaced`, `exact` and `find`; their arrays are read-only.

    Attributes
    ----------
    osc : Oscillator
    r : float
        Frequency ratio Omega/omega.
    clearance : float
        D = d K/F0; d is the whole travel of the free mass between the walls.
    pattern : Pattern
    restitution : ndarray (N,)
        Coefficient of restitution of each impact.
    phases : ndarray (N,)
        Phase of each impact, alpha_i, counted from the first (whose load phase is `load_phase`).
    X, Z : ndarray (N,)
        Positions of primary and free mass at each impact.
    X_dot_before, X_dot_after, Z_dot_before, Z_dot_after : ndarray (N,)
        Velocities just before and just after each impact.
    A, tau : float
        Amplitude of the motion without impacts and phase of equation (4): the forced part of the
        motion is ``A sin(r t + tau)`` with t = 0 at the first impact.
    residual : float
        Relative 2-norm of the residual of equations (26), (30). With N = 2 they are a square system,
        and it is 0 by definition.
    multipliers : ndarray (4,) of complex
        Eigenvalues of [P], in order of decreasing modulus; NaN where an impact has no approach speed.
    consistent : bool
        Whether the residual is within the acceptance.
    admissible : bool or None
        Whether the masses approach at each impact and the free mass stays between the walls.
    stable : bool or None
        Whether all multipliers lie inside the unit circle. None where there are no multipliers, or where
        the leading one is on the circle within rounding (no damping, for example).
    x_min, x_max : float
        Extreme positions of the primary mass over the period.
    precision : str
        "double", or "single" if the chain was computed in 32-bit arithmetic.
    load : float
        Load amplitude f; 1 unless `exact` was given another one.
    kind : str
        The method: "periodic" or "equispaced" (the linear equations), or "exact".
    guess : ndarray (N,) or None
        Of an exact motion: the phases from which it was found, if it began with the linear equations.
    rest_events : structured ndarray or None
        For a pattern with a star: all impacts, sticks and releases of a period from the first impact on.
        The arrays above have one entry a symbol then; that of a starred symbol is the first impact of
        the accumulation.
    """

    osc: Oscillator
    r: float
    clearance: float
    pattern: Pattern
    restitution: NDArray[np.float64]
    phases: NDArray[np.float64]
    X: NDArray[np.float64]
    Z: NDArray[np.float64]
    X_dot_before: NDArray[np.float64]
    X_dot_after: NDArray[np.float64]
    Z_dot_before: NDArray[np.float64]
    Z_dot_after: NDArray[np.float64]
    A: float
    tau: float
    residual: float
    multipliers: NDArray[np.complex128]
    consistent: bool | None
    admissible: bool | None
    stable: bool | None
    x_min: float
    x_max: float
    precision: str = "double"
    load: float = 1.0
    kind: str = "exact"
    guess: NDArray[np.float64] | None = None
    rest_events: NDArray[Any] | None = None

    @property
    def events(self) -> NDArray[Any]:
        """The events of one period from the first impact on, with the columns of `Trajectory.events`."""
        if self.rest_events is not None:
            return self.rest_events
        events = np.empty(len(self.pattern), dtype=EVENT_TYPE)
        events["time"] = self.phases / self.r
        events["kind"] = "impact"
        events["side"] = self.pattern.symbols
        events["phase"] = np.mod(self.phases + self.load_phase, 2 * math.pi)
        for name, values in (
            ("x", self.X), ("x_dot_before", self.X_dot_before), ("x_dot_after", self.X_dot_after),
            ("z_dot_before", self.Z_dot_before), ("z_dot_after", self.Z_dot_after),
        ):  # fmt: skip
            events[name] = values
        return events

    @property
    def period(self) -> float:
        """Period of the motion, 2 pi k/r in units of 1/omega."""
        return 2 * math.pi * self.pattern.cycles / self.r

    @property
    def attenuation(self) -> float:
        """max|x|/A; if it is below 1 the impacts reduce the motion of the primary mass."""
        return max(-self.x_min, self.x_max) / self.A

    @property
    def load_phase(self) -> float:
        """Phase of the load at the first impact, Omega t_1: the load is ``sin(r t + load_phase)``."""
        return self.tau + math.atan2(2 * self.osc.xi * self.r, (1 - self.r) * (1 + self.r))

    @property
    def leading_kind(self) -> str | None:
        """Where the leading multiplier lies: "positive", "negative" or "complex" (None: unknown).

        Crossing the unit circle there is a fold or pitchfork, a flip, or a Neimark-Sacker bifurcation.
        """
        leading = complex(self.multipliers[0])
        if leading != leading:
            return None
        if leading.imag != 0:
            return "complex"
        return "positive" if leading.real >= 0 else "negative"

    @memory_for("a sample at the times t")
    def sample(self, t: ArrayLike) -> Sample:
        """Positions, velocities, accelerations and load at any times, from the closed form.

        Parameters
        ----------
        t : array_like
            Times in 1/omega, 0 at the first impact; any finite value, the motion being periodic. At an
            impact velocities and accelerations are those just after it.

        Returns
        -------
        Sample
            Arrays ``X, X_dot, Z, Z_dot, Y, load, X_ddot, Z_ddot``; Y is Z - X.

        Examples
        --------
        >>> import numpy as np, vibroimpact as vi
        >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
        >>> motion = vi.equispaced(osc, r=0.94, clearance=37.0)[0]
        >>> history = motion.sample(np.linspace(0, motion.period, 400))
        >>> bool(np.all(abs(history.Y) <= 37.0 / 2 + 1e-12))
        True
        """
        times = checks.real_array(t, "t", "real times")
        if not np.isfinite(times).all():
            raise ParameterError(f"t = {t!r}: must be finite")
        if self.rest_events is None:
            values = _core.sample(*self._flights(), times.ravel())
            values[5] *= self.load
            return with_accelerations(self.osc, values.reshape((6, *times.shape)))
        starts, resting = segments(self.rest_events, self.clearance)
        wrapped = np.mod(times, self.period)
        return sample(self.osc, self.r, self.load, self.clearance, starts, resting, wrapped)

    @memory_for("quantities, by their window and harmonics")
    def quantities(self, harmonics: int = 10) -> Quantities:
        """Response quantities over a period: rms, extremes and harmonics, impacts and energies.

        Parameters
        ----------
        harmonics : int
            Harmonics of the load, 1 to 10000.

        Raises
        ------
        ParameterError, ParameterTypeError
            If the number of harmonics is not allowed.

        Examples
        --------
        Dashpot and impacts dissipate the work of the load:

        >>> import vibroimpact as vi
        >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
        >>> found = vi.equispaced(osc, r=0.94, clearance=37.0)[0].quantities()
        >>> round(found.x.rms, 4), round(found.x_ddot.peak, 4)
        (11.8761, 15.7311)
        >>> abs(found.work - found.damping_loss - found.impact_loss) < 1e-12 * found.work
        True
        """
        events = self.events
        starts, resting = segments(events, self.clearance)
        end = starts[0, 0] + self.period
        return quantities_of(
            self.osc, self.r, self.load, starts, resting, end, None, events, harmonics
        )

    def plot(self, ax: Any = None, kind: str | None = None, cycles: float | None = None) -> Any:
        """Draw time history, load, acceleration and phase portrait (extra `plot`).

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Where to draw one panel; without it a figure with all panels is made.
        kind : {"history", "load", "acceleration", "portrait"}, optional
            Which panel.
        cycles : float, optional
            Load cycles shown; by default one period, at least two cycles.

        Returns
        -------
        Axes, or an array of Axes if all panels were drawn.
        """
        return self._draw(ax, kind, max(2, self.pattern.cycles) if cycles is None else cycles)

    def animate(
        self,
        path: str | os.PathLike[str] | None = None,
        cycles: float | None = None,
        seconds: float = 3.0,
    ) -> Any:
        """Animate the masses; the wall that is hit flashes (extra `plot`).

        Parameters
        ----------
        path : str or path, optional
            The file to write; it ends with .gif (Pillow) or .mp4 (the program ffmpeg, or the extra `film`).
        cycles : float, optional
            Load cycles shown from the first impact on; by default one period, so that the animation can loop.
        seconds : float
            Duration of a load cycle on the screen.

        Returns
        -------
        Path
            Without `path` matplotlib's FuncAnimation, which a notebook shows by its `to_jshtml()`.

        Examples
        --------
        >>> import vibroimpact as vi
        >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
        >>> motion = vi.equispaced(osc, r=0.94, clearance=37.0)[0]
        >>> motion.animate("pair.gif", seconds=0.3).name
        'pair.gif'
        """
        return self._animate(path, self.pattern.cycles if cycles is None else cycles, seconds)

    def impact_maps(self) -> NDArray[np.float64]:
        """The matrices [P_i] of (A7), (N, 4, 4).

        P_i is the derivative of the state (x, x', z', alpha) just after impact i+1 with respect to that
        just after impact i. All zero where the impact has no approach speed.
        """
        if self.pattern.has_rest:
            raise ParameterError(
                f"pattern = {self.pattern.sides!r}: must be without rest, which has no finite list of [P_i]"
            )
        maps, _ = _core.impact_maps(*self._flights())
        return np.moveaxis(maps, 2, 0)

    def stability_matrix(self) -> NDArray[np.float64]:
        """[P] = [P_N] ... [P_1] of equation (32), (4, 4); its eigenvalues are the multipliers."""
        product = np.eye(4)
        for matrix in self.impact_maps():
            product = matrix @ product
        return product

    def gradient(self) -> Gradient:
        """The derivatives of all quantities with respect to r, clearance, xi, mu, R1, R2, R and load.

        They are those of the exact motion, with the phases as functions of the parameters, from the
        implicit-function theorem and the derivatives of [P_i]; no difference quotients are taken. R1 and R2 change
        the restitution of all impacts on their wall, R that of all impacts.

        Beside attributes of the motion the quantities are `load_phase`, `attenuation`, the response `x_rms`,
        `fundamental_amplitude` and `fundamental_phase` (as `quantities` has them), and the distances to the
        boundaries of its zone: `approach_speeds` at the impacts; `gaps_right` and `gaps_left`, the least distance
        to each wall where the relative position is stationary in the flight after each impact (NaN if it is so
        nowhere); and `stability_margin`, which is 1 - max|lambda|.

        Returns
        -------
        Gradient
            NaN with a `status` where a single quantity has no derivatives: multipliers that coincide, or a
            greatest value that is reached twice, as by symmetric motions if R1 alone changes. Of a motion with
            rest or with more than 24 impacts there are no gaps, rms and fundamental.

        Raises
        ------
        ParameterError
            If the motion has no load.
        SingularError
            If the motion is at a fold, a pitchfork or a graze, or if its phases are not exact (`exact` finds the
            exact motion nearby).

        Examples
        --------
        >>> import vibroimpact as vi
        >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
        >>> gradient = vi.equispaced(osc, 0.94, 37.0)[0].gradient()
        >>> round(float(gradient["attenuation", "clearance"]), 6)
        0.015041
        >>> gradient["X", "mu"].shape
        (2,)
        """
        if not self.load > 0:
            raise ParameterError(f"load = {self.load!r}: must be above 0 to have derivatives")
        found: Gradient = ACTIONS["motion_gradient"](self)
        return found

    def to_namelist(self) -> str:
        """The case as a namelist, from which `vibroimpact run` and `vibroimpact-batch` compute it again.

        The digits are the same if the motion was computed from phases. Otherwise the motion itself is the guess
        for Newton's method, which then ends within rounding of it. An equispaced motion comes with its twin.
        """
        return namelist.case(self.osc, self.r, motion=self._keys())

    def _keys(self) -> dict[str, Any]:
        """The group &motion that produces it."""
        if self.pattern.has_rest or self.load != 1.0:
            what = "rest" if self.pattern.has_rest else f"load = {self.load!r}"
            raise ParameterError(f"motion with {what}: has no namelist; a &simulate comes to it")
        keys: dict[str, Any] = {"kind": self.kind, "cycles": self.pattern.cycles}
        if self.kind == "equispaced":
            return keys | {"clearance": self.clearance, "precision": self.precision}
        phases = self.phases if self.guess is None else self.guess
        keys |= {"sides": self.pattern.sides, "phases": phases.tolist()}
        right, left = self.osc.restitution
        if not np.array_equal(self.restitution, np.where(self.pattern.signs > 0, right, left)):
            keys["impact_restitution"] = self.restitution.tolist()
        if self.kind == "exact":
            keys["clearance"] = self.clearance
            if self.guess is None:
                keys |= {"positions": self.X.tolist(), "tau": self.tau}
            return keys
        if self.consistent != (self.residual <= ACCEPTANCE):
            # the acceptance was different: set it just above the residual, or just below
            kind = np.float32 if self.precision == "single" else np.float64
            limit = kind(self.residual)
            limit = limit if self.consistent else np.nextafter(limit, kind(0))
            keys["acceptance"] = min(1.0, float(limit))
        return keys | {"precision": self.precision}

    @property
    def _result(self) -> Result:
        """Its tables, with the columns that the core declares for &motion."""
        try:
            case = self.to_namelist()
        except ParameterError:
            case = ""
        n, (right, left) = len(self.pattern), self.osc.restitution
        own: dict[str, Any] = {name: getattr(self, name) for name in OF_MOTION}
        own |= {name: CODES[getattr(self, name)] for name in VERDICTS}
        own |= {
            "motion": 1, "sides": self.pattern.sides, "cycles": self.pattern.cycles, "status": 0,
            "attenuation": self.attenuation if self.A > 0 else math.nan,
            "multipliers": self.multipliers, "xi": self.osc.xi, "mu": self.osc.mu, "R1": right,
            "R2": left, **units_of(self.osc),
        }  # fmt: skip
        impacts = {key: getattr(self, name) for name, key in OF_IMPACTS.items()}
        impacts |= {
            "impact": np.arange(1, n + 1),
            "side": self.pattern.symbols,
            "guess": self.guess,
        }
        tables: dict[str, Any] = {"motions": ((), own), "impacts": (("impact",), impacts)}
        if self.rest_events is not None:
            tables["events"] = (("event",), event_columns(self.rest_events))
        return made("motion", case, tables)

    @classmethod
    def of_result(cls, result: Result) -> Motion:
        """The motion of a result that has one."""
        found = motions_of(result)
        if len(found) != 1:
            raise ParameterError(f"result with {len(found)} motions: must have one")
        return found[0]

    def _facts(self) -> dict[str, str]:
        shown = ", ".join(f"{phase:.4g}" for phase in self.phases[:12] / np.pi)
        return {
            "x": f"{self.x_min:.6g} to {self.x_max:.6g}",
            "max|x|/A": f"{self.attenuation:.4g}" if self.A > 0 else "-",
            "phases/π": shown + (", …" if len(self.phases) > 12 else ""),
            "|λ|": ", ".join(f"{size:.4g}" for size in np.abs(self.multipliers)),
            "residual": f"{self.residual:.1e}",
        }

    def _draw_small(self, ax: Any) -> None:
        self.plot(ax=ax, kind="history")

    def verdicts(self) -> str:
        """The three verdicts in words, with the numbers behind them."""
        words = []
        for name, value in (("consistent", self.consistent), ("admissible", self.admissible)):
            words.append({True: name, False: f"not {name}", None: f"{name}?"}[value])
        modulus = abs(complex(self.multipliers[0]))
        stability = {True: "stable", False: "unstable", None: "stable?"}[self.stable]
        words.append(f"{stability} (max|lambda| = {modulus:.4g}, {self.leading_kind})")
        return ", ".join(words)

    def __repr__(self) -> str:
        single = ", single precision" if self.precision == "single" else ""
        # one line on a terminal: "consistent" and the kind of multiplier are only in `str`
        verdicts = (
            self.verdicts().removeprefix("consistent, ").replace(f", {self.leading_kind})", ")")
        )
        return (
            f"<Motion {self.pattern.sides}/{self.pattern.cycles} at r = {self.r:.6g}, "
            f"d K/F0 = {self.clearance:.6g}{single}: {verdicts}>"
        )

    def __str__(self) -> str:
        n = len(self.pattern)
        cycles = "cycle" if self.pattern.cycles == 1 else f"{self.pattern.cycles} cycles"
        lines = [
            f"{n} impacts/{cycles}, sides {self.pattern.sides}",
            f"  r = {self.r:.10g}   d K/F0 = {self.clearance:.10g}   A = {self.A:.6g}   "
            f"tau/pi = {self.tau / math.pi:.6g}",
            f"  {self.verdicts()}",
            f"  residual = {self.residual:.2e}   x from {self.x_min:.6g} to {self.x_max:.6g}   "
            f"max|x|/A = {self.attenuation:.6g}",
            "  side  phase/pi          X          Z  X' before   X' after  Z' before   Z' after",
        ]
        columns = zip(
            self.pattern.symbols, self.phases / math.pi, self.X, self.Z, self.X_dot_before,
            self.X_dot_after, self.Z_dot_before, self.Z_dot_after, strict=True,
        )  # fmt: skip
        for side, *numbers in columns:
            lines.append(
                f"  {side:>4}  {numbers[0]:8.5f}" + "".join(f" {x:10.4f}" for x in numbers[1:])
            )
        return "\n".join(lines)

    def _flights(self) -> _Flights:
        """The leading arguments of the core's procedures on a finished motion."""
        columns = (
            self.X, self.Z, self.X_dot_before, self.X_dot_after, self.Z_dot_before, self.Z_dot_after,
        )  # fmt: skip
        impacts = np.stack(columns, axis=1)
        return (
            self.osc.xi, self.osc.mu, self.r, self.pattern.cycles, self.pattern.signs,
            self.restitution, self.phases, impacts, self.A, self.tau,
        )  # fmt: skip


class MotionSet(Noun, study="motion"):
    """The motions of a &motion case: two of the equispaced kind, else one; none if there is no such motion."""

    __slots__ = ()
    printable = True

    def parts(self) -> list[Motion]:
        """The motions."""
        return motions_of(self._result)

    def require(self) -> None:
        """SingularError if the motion cannot be computed."""
        codes = self._result.column("motions", "status").values.tolist()
        if all(codes) and codes[0] != NO_MOTION:
            raise_status(codes[0])

    def __repr__(self) -> str:
        return f"<MotionSet: {', '.join(map(repr, self.parts())) or 'none'}>"


def motions_of(result: Result, osc: Oscillator | None = None) -> list[Motion]:
    """The motions of the core's tables, without those that failed.

    Parameters
    ----------
    osc : Oscillator, optional
        Their system, if the caller has it.
    """
    names = (*OF_MOTION, *VERDICTS, "sides", "cycles", "status")
    fields = {name: result.column("motions", name).decoded().ravel().tolist() for name in names}
    multipliers = result.column("motions", "multipliers").values
    if multipliers.size and multipliers.shape[-1] != 4:
        raise ParameterError(
            f"motions.multipliers of shape {multipliers.shape}: must have 4 in a row"
        )
    multipliers = multipliers.reshape(-1, 4)
    columns = {name: result.column("impacts", key).values for name, key in OF_IMPACTS.items()}
    if "guess" in result.tables["impacts"].columns:
        columns["guess"] = result.column("impacts", "guess").values
    n = len(multipliers)
    own = runs(result.tables["impacts"], n)
    events = result.tables.get("events", Table({}))
    resting = runs(events, n) if events.columns else [slice(0, 0)] * n
    found = []
    for i in range(n):
        if fields["status"][i]:
            continue
        values: dict[str, Any] = {name: fields[name][i] for name in OF_MOTION}
        values |= {name: VERDICT[fields[name][i]] for name in VERDICTS}
        values |= {name: column[own[i]] for name, column in columns.items()}
        pattern = Pattern(fields["sides"][i], fields["cycles"][i])
        if len(values["X"]) != len(pattern):
            raise ParameterError(
                f"impacts.X of shape ({len(values['X'])},): must be one number for each of {pattern.sides}"
            )
        rest_events = events_of(result, resting[i]) if pattern.has_rest else None
        found.append(
            Motion(
                osc=osc or osc_of(result, "motions", i), pattern=pattern, multipliers=multipliers[i],
                rest_events=rest_events, **values,
            )
        )  # fmt: skip
    return found


def osc_of(result: Result, table: str, row: int = 0) -> Oscillator:
    """The system of a row of a table that has its numbers."""
    xi, mu, *walls = (
        float(result.column(table, name).values.ravel()[row]) for name in ("xi", "mu", "R1", "R2")
    )
    columns = result.tables[table].columns
    known: dict[str, Any] = {
        name: columns[name].decoded().ravel()[row].item()
        for name in ("M", "K", "F0", "units") if name in columns
    }  # fmt: skip
    if not known and result.case:
        keys = namelist.keys_of(result.case)
        of_system = {"M": "mass", "K": "stiffness", "F0": "force", "units": "unit_names"}
        known = {name: keys[key] for name, key in of_system.items() if key in keys}
    names = known.pop("units", None)
    return Oscillator(xi=xi, mu=mu, restitution=(walls[0], walls[1]), **known, unit_names=names)


def units_of(osc: Oscillator) -> dict[str, Any]:
    """The columns of the physical units of an oscillator, None where they are not known."""
    return {"M": osc.M, "K": osc.K, "F0": osc.F0, "units": osc.unit_names}


@dataclass(frozen=True, eq=False, repr=False, slots=True)
class Motions:
    """Many motions of one pattern as arrays, points on the last axis; an index gives one `Motion`.

    Attributes
    ----------
    osc, pattern, restitution, precision
        As in `Motion`, common to all points.
    r : ndarray (M,)
    phases : ndarray (N, M)
    X, Z, X_dot_before, X_dot_after, Z_dot_before, Z_dot_after : ndarray (N, M)
    clearance, A, tau, residual, x_min, x_max : ndarray (M,)
    multipliers : ndarray (4, M) of complex
    consistent, admissible, stable : ndarray (M,) of int8
        1, 0, or -1 for "not computed".
    status : ndarray (M,) of int
        0 where the motion was computed; other codes are explained by `status_text`. The numbers of
        a failed point are NaN.
    """

    study: ClassVar[str] = "motion"
    osc: Oscillator
    r: NDArray[np.float64]
    clearance: NDArray[np.float64]
    pattern: Pattern
    restitution: NDArray[np.float64]
    phases: NDArray[np.float64]
    X: NDArray[np.float64]
    Z: NDArray[np.float64]
    X_dot_before: NDArray[np.float64]
    X_dot_after: NDArray[np.float64]
    Z_dot_before: NDArray[np.float64]
    Z_dot_after: NDArray[np.float64]
    A: NDArray[np.float64]
    tau: NDArray[np.float64]
    residual: NDArray[np.float64]
    multipliers: NDArray[np.complex128]
    consistent: NDArray[np.int8]
    admissible: NDArray[np.int8]
    stable: NDArray[np.int8]
    x_min: NDArray[np.float64]
    x_max: NDArray[np.float64]
    status: NDArray[np.int32]
    precision: str

    @property
    def attenuation(self) -> NDArray[np.float64]:
        """max|x|/A of each motion."""
        return np.maximum(-self.x_min, self.x_max) / self.A

    def __len__(self) -> int:
        return len(self.status)

    @overload
    def __getitem__(self, index: int) -> Motion: ...
    @overload
    def __getitem__(self, index: slice) -> list[Motion]: ...
    def __getitem__(self, index: Any) -> Any:
        """One motion, or a list of them for a slice; raises SingularError if that point failed."""
        places = checks.place(index, len(self), "motion")
        if isinstance(places, range):
            return [self[j] for j in places]
        index = places
        raise_status(int(self.status[index]))
        values: dict[str, Any] = {}
        for item in fields(self):
            if item.name == "status":
                continue
            value = getattr(self, item.name)
            if item.name in ("consistent", "admissible", "stable"):
                value = VERDICT[int(value[index])]
            elif isinstance(value, np.ndarray) and item.name != "restitution":
                value = value[..., index]
                value = float(value) if value.ndim == 0 else value
            values[item.name] = value
        return Motion(**values, kind="periodic")

    def __repr__(self) -> str:
        good = self.status == 0
        all_three = good & (self.consistent == 1) & (self.admissible == 1) & (self.stable == 1)
        return (
            f"<Motions {self.pattern.sides}/{self.pattern.cycles}: {len(self)} points, {good.sum()} computed, "
            f"{all_three.sum()} consistent, admissible and stable>"
        )
