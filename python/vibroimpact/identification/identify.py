"""Identification of a rig: from records of its load and motion to its parameters, with their errors."""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base import checks
from ..base.errors import ParameterError, PoorFitWarning
from ..base.progress import with_progress
from ..motions.motion import Motion
from ..results.noun import Noun
from ..systems.oscillator import Oscillator, Pattern
from ..systems.restitution import Restitution
from ..systems.units import Units
from .friction import slid
from .known import Known
from .laws import KNOWN_OF_LAW, law_of
from .measured import PerChannel, SensorRecord
from .motions import oscillator_of, verified
from .sequence import (
    CALIBRATION,
    by_parameter,
    identified,
    identified_of,
    is_good,
    records_of,
)
from .tables import place_in_hertz, said

__all__ = ["Identification", "identify"]

_Array = NDArray[np.float64]


class Boundary(NamedTuple):
    """A boundary of the zone of a motion.

    Attributes
    ----------
    type : str
        The type, as for the special points of a `Branch`: fold, flip, grazing, ….
    parameter : str
        "r" or "clearance".
    value, distance : float
        Value of the parameter at the boundary, and its relative distance from the value at the motion.
    """

    type: str
    parameter: str
    value: float
    distance: float


class Identification(Noun, study="identify"):
    """The parameters of a rig that its records determine, and the steps that lead to them.

    All values are in SI units. With several records, attributes of a single record refer to the first one;
    `records` is the number of records.

    Attributes
    ----------
    status : str
        How the impacts behave: "periodic", "not periodic", "accumulation", "rest" or "no impacts". Only periodic
        records have motions and patterns; for the others, parameters are estimated from the flights between
        impacts, as far as possible.
    values, errors : dict
        The parameters by name (M, K, omega, xi, mu, R1, R2, d, F0, F0/K), and the standard errors of those that
        were fitted; infinite if the records do not determine a parameter. Laws of restitution add parameters of
        their own.
    undetermined : list of str
        Names of the parameters that the records do not determine. Their values only complete the fitted motion;
        other values fit equally well.
    oscillator : Oscillator or None
        The identified system, with its units if M and K are among the values. Its load is K times the fitted
        F0/K of the first record, so that its lengths agree with d; `F0` is the load of the channel. With a law,
        its coefficients of restitution are those at the speed v0.
    restitution : (Restitution, Restitution) or None
        Restitution of the right and of the left wall; a law is a `PowerLaw`, limited to 1, or a
        `TabulatedRestitution` over the approach speed in m/s.
    r, frequency : float
        Frequency ratio, and load frequency in Hz.
    F0, d, clearance : float
        Load amplitude (NaN if it is not known), clearance d (the whole travel of m), and d K/F0. If contacts are
        part of the fit of a record that is not periodic (a note states this), d is the distance between the
        walls, otherwise the travel between the centres of the impacts.
    pattern : Pattern or None
    motion : Motion or None
        The exact motion with these parameters, with its multipliers and verdicts; with a law, or under a load
        with harmonics, it is a motion of ``oscillator.structure``.
    impact_times : ndarray (impacts,)
        Times of all impacts that were detected in the record, s.
    impact_sides : ndarray (impacts,) of str
        Walls of these impacts.
    impact_phases, impact_phase_errors : ndarray (N,)
        Load phases of the impacts of a period, resolved to less than a sampling interval, and their standard
        errors (radians).
    misfit : float
        Sum of squares of the weighted residuals over the degrees of freedom; about 1 if the model holds. If it is
        larger, errors are multiplied by its square root.
    doubts : tuple of str
        Doubts about the fit, the likeliest causes first; empty if there are none.
    assumptions : tuple of str
        Effects that the stated errors do not include, if they exceed two errors: the changes of parameters with a
        known value or with the load phase, and how much closer than d the walls are if contacts last.
    good : bool
        Whether parameters were fitted and there are no doubts about them. If not, the errors are not valid, and
        `identify` warns with a `PoorFitWarning`.
    """

    __slots__ = ("_motions",)
    _motions: list[Motion | None]

    @property
    def records(self) -> int:
        """Number of records."""
        return int(self._result.tables["records"].dims["recording"])

    def _one(self, name: str, record: int = 0) -> Any:
        """A column of the table of records for one of them."""
        return self._result.column("records", name).decoded()[record].item()

    def _parameters(self, name: str) -> dict[str, Any]:
        """A column of the table of parameters, by their names."""
        return by_parameter(self._result, name)

    @property
    def status(self) -> str:
        """How the impacts behave."""
        status: str = self._one("status")
        return status

    @property
    def values(self) -> dict[str, float]:
        """The parameters by name."""
        return self._parameters("value")

    @property
    def errors(self) -> dict[str, float]:
        """Standard errors of the parameters that are not known exactly, by name."""
        states, errors = self._parameters("state"), self._parameters("error")
        return {
            name: errors[name]
            for name, state in states.items()
            if state != "known" or errors[name] > 0
        }

    @property
    def undetermined(self) -> list[str]:
        """Names of the parameters that the records do not determine."""
        return [
            name for name, state in self._parameters("state").items() if state == "undetermined"
        ]

    def interval(self, name: str) -> tuple[float, float]:
        """The 95 % interval of a parameter.

        Parameters
        ----------
        name : str
            Name of the parameter, as in `values`.

        Returns
        -------
        (float, float)
            Lower and upper end, in SI units.

        Raises
        ------
        ParameterError
            If there is no parameter of this name.
        """
        low = self._parameters("low")
        checks.choice(name, "name", tuple(low))
        return low[name], self._parameters("high")[name]

    @property
    def oscillator(self) -> Oscillator | None:
        """The identified system."""
        return self._oscillator_of(0)

    def _oscillator_of(self, record: int) -> Oscillator | None:
        """The identified system in the units of a record."""
        values, static = self.values, self._one("static", record)
        if not all(math.isfinite(values.get(name, math.nan)) for name in ("xi", "mu", "d")):
            return None
        scale: dict[str, Any] = {
            name: values[name]
            for name in ("M", "K", "F0") if math.isfinite(values.get(name, math.nan))
        }  # fmt: skip
        if not {"M", "K"} <= scale.keys():
            scale = {}
        elif "F0" in scale and math.isfinite(static):
            # the load that the motion implies, whose unit of length is that of d
            scale["F0"] = scale["K"] * static
        return oscillator_of(values, **scale)

    @property
    def law(self) -> str:
        """The law of the coefficients of restitution over the approach speed, as in `identify`."""
        return law_of(self.values).kind

    @property
    def restitution(self) -> tuple[Restitution, Restitution] | None:
        """Restitution of the right and of the left wall; a law is over the approach speed in m/s."""
        values = self.values
        return law_of(values).restitution(values) if self.oscillator is not None else None

    @property
    def osc(self) -> Any:
        """The identified system, named as in other results."""
        return self.oscillator

    @property
    def r(self) -> float:
        """Frequency ratio."""
        return float(self._one("r"))

    @property
    def frequency(self) -> float:
        """Load frequency, Hz."""
        return float(self._one("frequency"))

    @property
    def clearance(self) -> float:
        """Clearance d K/F0, dimensionless."""
        return float(self._one("clearance"))

    @property
    def F0(self) -> float:
        """Load amplitude, N; NaN if it is not known."""
        return self.values.get("F0", math.nan)

    @property
    def d(self) -> float:
        """Clearance, m."""
        return self.values.get("d", math.nan)

    @property
    def misfit(self) -> float:
        """Sum of squares of the weighted residuals over the degrees of freedom."""
        return float(self._one("misfit"))

    @property
    def doubts(self) -> tuple[str, ...]:
        """Doubts about the fit, the likeliest causes first."""
        return tuple(text for _, text in self._result.notes if "doubtful: " in text)

    @property
    def assumptions(self) -> tuple[str, ...]:
        """The effects of errors of known values and of the load phase."""
        return tuple(text for _, text in self._result.notes if text.startswith("not in the errors"))

    @property
    def good(self) -> bool:
        """Whether parameters were fitted and there is no doubt about them."""
        return is_good(self._result)

    @property
    def pattern(self) -> Pattern | None:
        """Walls of the impacts of a period in order, and load cycles in it."""
        return self.pattern_of(0)

    def pattern_of(self, record: int) -> Pattern | None:
        """The pattern of one of the records, counted from 0.

        Parameters
        ----------
        record : int
            Number of the record, from 0.

        Returns
        -------
        Pattern or None
            None if the record is not periodic.
        """
        cycles = self._one("cycles", record)
        return Pattern(self._one("sides", record), cycles) if cycles else None

    @property
    def multipliers(self) -> NDArray[np.complex128]:
        """Multipliers of the identified motion, (4,)."""
        multipliers: NDArray[np.complex128] = self._result.column("records", "multipliers").values[
            0
        ]
        return multipliers

    @property
    def motion(self) -> Motion | None:
        """The exact motion with the identified parameters."""
        return self.motions[0]

    @property
    def motions(self) -> list[Motion | None]:
        """For each record, the exact motion with the identified parameters."""
        try:
            return self._motions
        except AttributeError:
            found = [self._motion_of(i) for i in range(self.records)]
            object.__setattr__(self, "_motions", found)
            return found

    def _motion_of(self, record: int) -> Motion | None:
        pattern, osc = self.pattern_of(record), self._oscillator_of(record)
        if pattern is None or osc is None:
            return None
        phases = self._of(record, "impacts", "fitted")
        r, clearance = self._one("r", record), self._one("clearance", record)
        values = self.values
        walls = law_of(values).restitution(values, values["omega"] * self._one("static", record))
        harmonics = self._result.column("records", "harmonics").values[record]
        if "friction" in values:
            speeds = self._of(record, "impacts", "speed") / values["omega"]
            speeds = speeds / self._one("static", record)
            return slid(osc, r, clearance, phases, pattern, values["friction"], speeds, harmonics)
        return verified(osc, r, clearance, phases, pattern, walls, harmonics)

    def _of(self, record: int, table: str, name: str) -> NDArray[Any]:
        """The rows of a table that belong to a record."""
        own = self._result.column(table, "number").values == record + 1
        rows: NDArray[Any] = self._result.column(table, name).decoded()[own]
        return rows

    @property
    def impact_times(self) -> _Array:
        """Times of all impacts that were detected, s."""
        return self._of(0, "picks", "time")

    @property
    def impact_sides(self) -> NDArray[np.str_]:
        """Walls of all impacts that were detected."""
        return self._of(0, "picks", "side")

    @property
    def impact_phases(self) -> _Array:
        """Load phases of the impacts of a period, resolved to less than a sampling interval."""
        return self._of(0, "impacts", "picked")

    @property
    def impact_phase_errors(self) -> _Array:
        """Their standard errors."""
        return self._of(0, "impacts", "picked_error")

    @property
    def units(self) -> Units:
        """Physical units of the identified motion.

        Raises
        ------
        ParameterError
            If M, K or F0 is not known.
        """
        osc = self.oscillator
        if osc is None or osc.F0 is None:
            raise ParameterError(
                "units: the mass M or stiffness K must be known, and the load amplitude F0 must be known or "
                "recorded"
            )
        return osc.units()

    def nearest_boundary(self, record: int = 0) -> Boundary | None:
        """The nearest boundary of the zone of the identified motion, along r or along the clearance.

        The motion is followed in both directions, to half and twice the clearance, and to 0.9 r and 1.1 r.

        Parameters
        ----------
        record : int
            Number of the record, from 0.

        Returns
        -------
        Boundary or None
            None if there is no boundary within this range, or no motion was fitted.
        """
        from ..studies.branch import branch

        motion = self.motions[checks.integer(record, "record", 0, self.records - 1)]
        if motion is None:
            return None
        found = []
        for parameter, factor in (("clearance", 2.0), ("r", 1.1)):
            here = self._one(parameter, record)
            name, unit = parameter, 1.0
            if motion is not None and motion.of_structure:
                name, unit = {"clearance": ("opening", 2.0), "r": ("frequency", 1.0)}[parameter]
            path = branch(motion, name, (here / unit / factor, here / unit * factor))
            for point in path.special_points:
                value = unit * point.value
                found.append(Boundary(point.type, parameter, value, abs(value / here - 1)))
        return min(found, key=lambda boundary: boundary.distance, default=None)

    def plot(self, ax: Any = None, kind: str | None = None, record: int = 0) -> Any:
        """Draw every step from the records to the fitted motion and its residuals (extra `plot`).

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Axes for one panel; without it, a figure with all panels is made.
        kind : {"record", "load", "impacts", "motion", "residuals"}, optional
            Which panel.
        record : int
            Which record, counted from 0.

        Returns
        -------
        Axes, or an array of Axes
            The Axes of the panel, or of all panels.
        """
        return self._draw(ax, kind, record)

    def require(self) -> None:
        """Accept every result; `status` shows whether a record is periodic."""

    def _facts(self) -> dict[str, str]:
        units = self._parameters("unit")
        return {
            name: said(name, value, self.errors.get(name), units[name])
            for name, value in self.values.items()
        }

    @classmethod
    def computed(
        cls, case: Any, progress: Callable[[float, str], None] | None = None
    ) -> Identification:
        """The result of an &identify case.

        Parameters
        ----------
        case : Case
            A case with an &identify.
        progress : callable or None
            As in `identify`.

        Returns
        -------
        Identification
            As `identify` returns it for the files of the case.
        """
        return cls(identified_of(case, progress))

    def __repr__(self) -> str:
        pattern = self.pattern
        if pattern is None and "xi" not in self.errors:
            return f"<Identification: {self.status}, {self.impact_times.size} impacts detected>"
        units = self._parameters("unit")
        fitted = ", ".join(
            said(name, self.values[name], error, units[name])
            for name, error in self.errors.items()
            if name in ("xi", "mu", "R1", "R2", *KNOWN_OF_LAW, "d", "friction") and math.isfinite(error)
        )  # fmt: skip
        left = f"undetermined: {', '.join(self.undetermined)}" if self.undetermined else ""
        doubtful = ""
        if self.doubts:
            doubtful = f"poor fit (misfit {self.misfit:.3g}), errors not valid, see doubts"
        shown = "; ".join(filter(None, (fitted, left, doubtful))) or "all known"
        motion = f"{pattern.sides}/{pattern.cycles}" if pattern else f"({self.status})"
        return f"<Identification {motion} at {place_in_hertz(self.r, self.frequency)}: {shown}>"


@with_progress
def identify(
    record: SensorRecord | str | os.PathLike[str] | Sequence[Any] | None = None,
    *,
    rate: float | None = None,
    load: ArrayLike | None = None,
    acceleration: ArrayLike | None = None,
    velocity: ArrayLike | None = None,
    displacement: ArrayLike | None = None,
    units: Mapping[str, str] | None = None,
    bandwidth: PerChannel = None,
    delay: PerChannel = None,
    range: PerChannel = None,  # noqa: A002, the word of a sensor's data sheet
    noise: PerChannel = None,
    impact_times: ArrayLike | None = None,
    impact_sides: str | Sequence[str] | None = None,
    frequency: float | None = None,
    load_phase: float | None = None,
    known: Mapping[str, Known] | None = None,
    start: Oscillator | None = None,
    law: str | None = None,
    law_speed: float | None = None,
    law_knots: int | None = None,
    friction: float | str | bool | None = None,
    calibration: float = CALIBRATION,
    progress: Callable[[float, str], None] | None = None,
) -> Identification:
    """Identify the parameters of a rig from records of its load and of the motion of its primary mass.

    The load gives frequency, phase and amplitude. The record is folded over the smallest number k of load cycles
    that is consistent with the scatter from period to period. An impact is detected where the motion differs from
    the prediction from its past. Between impacts the primary mass is a damped oscillator under the load. Flights
    of this form, with velocity jumps at fitted instants, and modes that ring after the impacts are fitted outside
    the pulses, whose lengths are determined from the data. Therefore neither the shape of the contact pulse nor a
    delay of the motion sensor matters; the possible effect of contacts as long as the pulses is part of the
    errors. Exact motions are then fitted to the same data, weighted by the scatter of the samples. If the record
    is not periodic, each flight has its own state, and the parameters follow from momentum and restitution at the
    impacts between flights. A load that is not nearly a sine, such as a swept sine or noise, is used as recorded;
    its records are always fitted in this way, and `frequency` must be left out.

    Parameters
    ----------
    record : SensorRecord, path, or list of them, optional
        One or several records of the same rig, fitted together; without it, a record is made from the following
        arguments.
    rate : float
        Sampling rate, Hz.
    load, acceleration, velocity, displacement : array_like (n,)
        The load, and one quantity of the motion of the primary mass.
    units : mapping, optional
        Units by channel, as in `SensorRecord`.
    bandwidth, delay, range, noise : float or mapping, optional
        As in `SensorRecord`: a number for the motion channels, or a mapping with values by channel.
    impact_times : array_like (impacts,)
        Times of impacts (s), instead of records of the motion; with `frequency`, with `load_phase` if it is known,
        and with known M and K, or omega.
    impact_sides : str or sequence of str
        Walls of these impacts, each R or L; by default they alternate, starting with the right wall.
    frequency : float, optional
        Load frequency (Hz); by default it is determined from the load or, without a load channel, from the motion.
    load_phase : float, optional
        Phase of the load at time 0 of the impact times (radians).
    known : mapping, optional
        Known values, in SI units: M, K, C, m, d (the whole travel of the free mass), F0, omega, xi, mu, R1, R2,
        and for a law exponent and knee (m/s), or exponent1, exponent2, knee1 and knee2. A value that is not known
        exactly has a standard error, as in ``K=(42e3, 420)`` or ``K=("42 kN/m", "1 %")``; its effect, obtained
        from two further fits with the value one standard error higher and lower, becomes part of all errors. Near
        a resonance, a stiffness that is wrong by 1 % may change xi by many times its statistical error without
        being noticed.
    start : Oscillator, optional
        Starting values of the fit for parameters that the records do not give; xi = 0.01, mu = 0.05 and R = 0.7 by
        default.
    law : {"constant", "power", "powers", "knee", "knees", "table", "tables"}, optional
        The law of the coefficients of restitution as a function of the approach speed v; with a name in the
        plural, each wall has its own law. By default "constant"; if a periodic record rejects constants and only
        powers of the speed describe it, "powers", which a note states. "power": R1 (v/v0)^-exponent and R2
        (v/v0)^-exponent, a `PowerLaw` far above its knee. "knee": a `PowerLaw` of sharpness 2, with the values R1
        and R2 at the speed v0, the `exponent` and the speed `knee`. "table": linear between knots, R[1] at the
        speed v[1] and so on, and constant beyond them. With plurals, the parameters are exponent1, knee1 and R1[1]
        on the right wall, and exponent2, knee2 and R2[1] on the left one. A law requires impacts of different
        speeds, from records at different loads or within one period. Parameters that the impacts do not determine
        are listed in `undetermined`.
    law_speed : float, optional
        Speed v0 in m/s; by default the geometric mean of the approach speeds of all impacts.
    law_knots : int, optional
        Number of knots of a table, 3 by default, at most 20. The knots are quantiles of the approach speeds; the
        outermost knots lie slightly beyond the range of the speeds.
    friction : float, str or True, optional
        Known dry friction of the free mass in its slot, as a fraction of F0 or a force such as "0.3 N"; True: it
        is fitted, and an error is raised if the record does not determine it. Both require a single record and
        constant coefficients of restitution. By default no friction is assumed, and this assumption is tested.
    calibration : float
        Relative standard error of the calibration of each sensor, 1 % by default; 0 if the calibrations are exact.
        It is part of all errors: gain errors of load and motion change xi at a resonance, and a gain error of the
        motion changes lengths.
    progress : callable, optional
        Called with the fraction done and the next task; by default, if the call takes more than two seconds, a bar
        shows them on a terminal or in a notebook.

    Returns
    -------
    Identification
        The parameters with their errors, the fitted motions, and any doubts.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed, or a record is unusable: it is clipped or too short, samples are missing,
        channels are in the wrong order, or units do not agree.
    SingularError
        If there is no motion near the detected impacts.
    MissingExtraError
        If SciPy is not installed (extra `identify`).

    Warns
    -----
    PoorFitWarning
        If the fit does not describe the records to within their noise, or if the records contradict the known
        values.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> rig = vi.VirtualRig(M=2.7, K=42e3, m=0.11, d=0.006, xi=0.01143, restitution=0.7, F0=6.0, frequency=19.5)
    >>> found = vi.identify(rig.record(rng=1), known=dict(M=2.7, K=42e3, m=0.11))
    >>> found.pattern, found.undetermined
    (Pattern(sides='RLL', cycles=1), [])
    >>> low, high = found.interval("xi")
    >>> bool(low < 0.01143 < high), found.errors["xi"] < 0.0006
    (True, True)
    """
    arrays: dict[str, Any] = {
        "load": load,
        "acceleration": acceleration,
        "velocity": velocity,
        "displacement": displacement,
    }
    sensors: dict[str, Any] = {
        "units": units, "bandwidth": bandwidth, "delay": delay, "range": range, "noise": noise,
    }  # fmt: skip
    options: dict[str, Any] = {
        "frequency": frequency, "known": known, "start": start, "law": law, "law_speed": law_speed,
        "law_knots": law_knots, "friction": friction, "calibration": calibration, "progress": progress,
    }  # fmt: skip
    checks.progress(progress)
    records: list[SensorRecord]
    if impact_times is not None:
        if record is not None or any(values is not None for values in arrays.values()):
            raise ParameterError("impact_times: must be given without a record")
        records, options["load_phase"] = [], load_phase
        options |= {"impact_times": impact_times, "impact_sides": impact_sides}
    else:
        records = records_of(record, rate, arrays, sensors)
    found = Identification(identified(records, **options))
    if found.doubts:
        warnings.warn(
            f"{found.doubts[0]}; the errors are not valid; see `doubts` of the result for all of them",
            PoorFitWarning,
            stacklevel=2,
        )
    return found
