"""Identification of a rig: from records of its load and motion to its parameters, with their errors."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import checks
from ..errors import ParameterError, ParameterTypeError, SingularError
from ..measured import MOTIONS, SensorRecord, sensor_response
from ..model import Oscillator, Pattern, of_numbers
from ..motion import Motion
from ..newton import exact
from ..noun import Noun
from ..restitution import PowerLaw, Restitution, TabulatedRestitution
from ..rig_fit import SHARED, Fit, Measured, approach_speeds, described, fit, refine, start_of
from ..signals import (
    Rhythm,
    Tones,
    centred,
    load_frequency,
    no_rhythm,
    period_of,
    repeated,
    rhythm,
    spikes,
    tones,
)  # fmt: skip
from ..structure import Load
from ..structure_branch import branch_structure
from ..structure_motion import StructureMotion, exact_structure
from ..tables import made
from ..units import SI as SI_UNITS
from ..units import Units, positive

__all__ = ["Identification", "identify"]

_Array = NDArray[np.float64]
#: What may be known, and its unit.
KNOWN = {
    "M": "kg", "K": "N/m", "C": "N s/m", "m": "kg", "d": "m", "F0": "N", "omega": "rad/s", "xi": "", "mu": "",
    "R1": "", "R2": "", "exponent": "",
}  # fmt: skip
#: How the coefficients of restitution may depend on the approach speed.
LAWS = ("constant", "power")
OF_LAW = ("R1", "R2", "exponent")
#: The keys of &identify for them.
OF_KEYS = {
    "primary_mass": "M", "spring": "K", "dashpot": "C", "free_mass": "m", "travel": "d", "load_amplitude": "F0",
    "law_exponent": "exponent",
}  # fmt: skip
#: Least number of load cycles of a record, and largest ratio of two load amplitudes that should be the same.
LEAST_CYCLES, LARGEST_RATIO = 8, 1.5
#: What a wrong unit changes a record by, for the message.
FACTORS = {
    9.80665: "g for m/s^2",
    1000.0: "a milli- or kilo-unit",
    4.448: "lbf for N",
    25.4: "inches for mm",
    39.37: "inches for m",
}
#: Harmonics of the load that are measured, in its own channel and, at most, in that of the motion.
LOAD_TONES, MOTION_TONES = 6, 90
#: Share of harmonics in the load from which a result says that its errors do not contain their effect.
SHAPED = 0.003
#: Misfit from which a result says that it is doubtful.
DOUBTFUL = 10.0
#: Half the width of a 95 % interval in standard errors.
WIDTH = 1.959963984540054
#: Time from an impact to its spike, over the inverse of the bandwidth, and errors above which a harmonic is clear.
RISE, CLEAR = 0.2, 6.0
#: The sharpness of a power law, with which it is one down to where it is 1; exponent of a constant.
SHARP, FLAT = 20.0, 1e-7
#: Samples and load cycles of each record that a result keeps for its picture.
SHOWN_SAMPLES, SHOWN_CYCLES = 3000, 6


class Boundary(NamedTuple):
    """A boundary of the zone of a motion.

    Attributes
    ----------
    type : str
        As of the special points of a `Branch`: fold, flip, grazing, ….
    parameter : str
        "r" or "clearance".
    value, distance : float
        Value of the parameter there, and its relative distance from that of the motion.
    """

    type: str
    parameter: str
    value: float
    distance: float


class Identification(Noun, study="identify"):
    """The parameters of a rig that records of it determine, and the steps from the records to them.

    In SI units. With several records the attributes of one record are those of the first one; `records` has all.

    Attributes
    ----------
    status : str
        What the impacts do: "periodic", "not periodic", "accumulation", "rest" or "no impacts". Only periodic
        records have motions, and parameters that are fitted.
    values, errors : dict
        The parameters by name (M, K, omega, xi, mu, R1, R2, d, F0, F0/K), and the standard errors of those that
        were fitted; infinite where the records do not determine a parameter. With a power law the coefficient of
        an impact at the approach speed v is R1 or R2 times (v/v0)^-exponent.
    undetermined : list of str
        Names of the parameters that the records do not determine; their values are those that the fit started
        from.
    oscillator : Oscillator or None
        The identified system, with its units if M and K are among the values. With a power law its coefficients
        of restitution are those at the speed v0.
    restitution : (Restitution, Restitution) or None
        Of the right and of the left wall; a power law as a `PowerLaw` over the approach speed in m/s, which is
        1 at the most.
    r, frequency : float
        Frequency ratio, and load frequency in Hz.
    F0, d, clearance : float
        Load amplitude (NaN if it is not known), clearance d, and d K/F0.
    pattern : Pattern or None
    motion : Motion, StructureMotion or None
        The exact motion with these parameters, with its multipliers and verdicts; with a power law that of
        ``oscillator.structure``, whose multipliers take the law into account.
    impact_times : ndarray (impacts,)
        Times of all impacts that were picked in the record, s.
    impact_sides : ndarray (impacts,) of str
        Their walls.
    impact_phases, impact_phase_errors : ndarray (N,)
        Load phases of the impacts of a period, refined below the sample, and their standard errors (radians).
    misfit : float
        Sum of squares of the weighted residuals over the degrees of freedom; about 1 where the model holds. Errors
        are multiplied by its root where it is larger.
    """

    __slots__ = ("_motions",)
    _motions: list[Motion | StructureMotion | None]

    @property
    def records(self) -> int:
        """Number of records."""
        return int(self._result.tables["records"].dims["recording"])

    def _one(self, name: str, record: int = 0) -> Any:
        """A column of the table of records for one of them."""
        return self._result.column("records", name).decoded()[record].item()

    def _parameters(self, name: str) -> dict[str, Any]:
        """A column of the table of parameters, by their names."""
        names = self._result.column("parameters", "name").decoded().tolist()
        return dict(
            zip(names, self._result.column("parameters", name).decoded().tolist(), strict=True)
        )

    @property
    def status(self) -> str:
        """What the impacts do."""
        status: str = self._one("status")
        return status

    @property
    def values(self) -> dict[str, float]:
        """The parameters by name."""
        return self._parameters("value")

    @property
    def errors(self) -> dict[str, float]:
        """Standard errors of the parameters that are not known, by name."""
        states, errors = self._parameters("state"), self._parameters("error")
        return {name: errors[name] for name, state in states.items() if state != "known"}

    @property
    def undetermined(self) -> list[str]:
        """Names of the parameters that the records do not determine."""
        return [
            name for name, state in self._parameters("state").items() if state == "undetermined"
        ]

    def interval(self, name: str) -> tuple[float, float]:
        """The 95 % interval of a parameter.

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
        if self.status != "periodic":
            return None
        values = self.values
        scale: dict[str, Any] = {
            name: values[name]
            for name in ("M", "K", "F0") if math.isfinite(values.get(name, math.nan))
        }  # fmt: skip
        if not {"M", "K"} <= scale.keys():
            scale = {}
        walls = (values["R1"], values["R2"])
        return Oscillator(xi=values["xi"], mu=values["mu"], restitution=walls, **scale)

    @property
    def restitution(self) -> tuple[Restitution, Restitution] | None:
        """Of the right and of the left wall, over the approach speed in m/s with a power law."""
        return None if self.status != "periodic" else walls_of(self.values, 1.0)

    @property
    def osc(self) -> Any:
        """The identified system, as of other results."""
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
        """d K/F0."""
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
    def pattern(self) -> Pattern | None:
        """Walls of the impacts of a period in order, and load cycles in it."""
        return self.pattern_of(0)

    def pattern_of(self, record: int) -> Pattern | None:
        """The pattern of one of the records, counted from 0."""
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
    def motion(self) -> Motion | StructureMotion | None:
        """The exact motion with the identified parameters."""
        return self.motions[0]

    @property
    def motions(self) -> list[Motion | StructureMotion | None]:
        """Of each record, the exact motion with the identified parameters."""
        try:
            return self._motions
        except AttributeError:
            found = [self._motion_of(i) for i in range(self.records)]
            object.__setattr__(self, "_motions", found)
            return found

    def _motion_of(self, record: int) -> Motion | StructureMotion | None:
        pattern, osc = self.pattern_of(record), self.oscillator
        if pattern is None or osc is None:
            return None
        phases = self._of(record, "impacts", "fitted")
        r, clearance = self._one("r", record), self._one("clearance", record)
        if "v0" in self.values:
            unit = self.values["omega"] * self._one("static", record)
            return motion_of_law(osc, r, clearance, phases, pattern, walls_of(self.values, unit))
        return exact(osc, r, clearance, (phases - phases[0], pattern))

    def _of(self, record: int, table: str, name: str) -> NDArray[Any]:
        """The rows of a table that belong to a record."""
        own = self._result.column(table, "number").values == record + 1
        rows: NDArray[Any] = self._result.column(table, name).decoded()[own]
        return rows

    @property
    def impact_times(self) -> _Array:
        """Times of all impacts that were picked, s."""
        return self._of(0, "picks", "time")

    @property
    def impact_sides(self) -> NDArray[np.str_]:
        """Walls of all impacts that were picked."""
        return self._of(0, "picks", "side")

    @property
    def impact_phases(self) -> _Array:
        """Load phases of the impacts of a period as picked, refined below the sample."""
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
                "units: must have M, K and F0 among the values; known=dict(M=...) and a load give them"
            )
        return osc.units()

    def nearest_boundary(self, record: int = 0) -> Boundary | None:
        """The nearest boundary of the zone of the identified motion, along r or along the clearance.

        The motion is followed in both directions over half and twice the clearance, and over 0.9 and 1.1 r.

        Returns
        -------
        Boundary or None
            None if no boundary is that near, or no motion was fitted.
        """
        from .branch import branch

        motion = self.motions[checks.integer(record, "record", 0, self.records - 1)]
        if motion is None:
            return None
        found = []
        for parameter, factor in (("clearance", 2.0), ("r", 1.1)):
            here = self._one(parameter, record)
            if isinstance(motion, StructureMotion):
                name, unit = {"clearance": ("opening", 2.0), "r": ("frequency", 1.0)}[parameter]
                path = branch_structure(motion, name, (here / unit / factor, here / unit * factor))
                values = [(point.type, unit * point.value) for point in path.special_points]
            else:
                line = branch(motion, parameter, (here / factor, here * factor))
                values = [(point.type, getattr(point, parameter)) for point in line.special_points]
            found += [Boundary(kind, parameter, v, abs(v / here - 1)) for kind, v in values]
        return min(found, key=lambda boundary: boundary.distance, default=None)

    def plot(self, ax: Any = None, kind: str | None = None, record: int = 0) -> Any:
        """Draw every step: record, load, impacts and their sides, pattern, fitted motion, residuals (extra
        `plot`).

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Where to draw one panel; without it a figure with all panels is made.
        kind : {"record", "load", "impacts", "motion", "residuals"}, optional
            Which panel.
        record : int
            Which record, counted from 0.

        Returns
        -------
        Axes, or an array of Axes if all panels were drawn.
        """
        return self._draw(ax, kind, record)

    def require(self) -> None:
        """Nothing: a record that is not periodic has a status."""

    def _facts(self) -> dict[str, str]:
        return {
            name: said(name, value, self.errors.get(name)) for name, value in self.values.items()
        }

    @classmethod
    def computed(
        cls, case: Any, progress: Callable[[float, str], None] | None = None
    ) -> Identification:
        """The result of an &identify case."""
        from ..formats.measured import read_record

        del progress  # it takes a moment
        keys = case.keys
        known = {name: keys[key] for key, name in OF_KEYS.items() if key in keys}
        if "natural_frequency" in keys:
            known["omega"] = 2 * math.pi * keys["natural_frequency"]
        right, left = case.osc.restitution
        start = {"xi": case.osc.xi, "mu": case.osc.mu, "R1": right, "R2": left}
        if case.osc.M is not None:
            F0 = case.osc.F0
            units = Units(case.osc.M, case.osc.K, F0 or 1.0, case.osc.unit_names or SI_UNITS).to(
                SI_UNITS
            )
            own = {"M": units.M, "K": units.K} | ({} if F0 is None else {"F0": units.F0})
            known = own | known
        fixed = keys.get("fixed", [])
        known |= {name: start[name] for name in ([fixed] if isinstance(fixed, str) else fixed)}
        options: dict[str, Any] = {
            "frequency": keys.get("frequency"),
            "known": known,
            "start": case.osc,
            "law": keys.get("law", "constant"),
            "law_speed": keys.get("law_speed"),
        }
        if "impact_times" in keys:
            options |= {
                "impact_times": keys["impact_times"], "impact_sides": keys.get("impact_sides"),
                "load_phase": keys.get("load_phase"),
            }  # fmt: skip
            return identified(case=case.text, **options)
        paths = keys["records"]
        how = {name: keys.get(name) for name in ("rate", "channels", "bandwidth")}
        how["units"] = keys.get("channel_units")
        records = [
            read_record(path, **how) for path in ([paths] if isinstance(paths, str) else paths)
        ]
        return identified(records, case=case.text, **options)

    def __repr__(self) -> str:
        if self.status != "periodic":
            return f"<Identification: {self.status}, {self.impact_times.size} impacts picked>"
        pattern = self.pattern
        assert pattern is not None
        fitted = ", ".join(
            said(name, self.values[name], error)
            for name, error in self.errors.items()
            if name in ("xi", "mu", "R1", "R2", "exponent", "d") and math.isfinite(error)
        )  # fmt: skip
        left = f"; undetermined: {', '.join(self.undetermined)}" if self.undetermined else ""
        return (
            f"<Identification {pattern.sides}/{pattern.cycles} at r = {self.r:.6g}: {fitted}{left}>"
        )


def walls_of(values: Mapping[str, float], unit: float) -> tuple[Restitution, Restitution]:
    """The coefficients of restitution of the right and of the left wall, over speeds in some unit.

    R (v/v0)^-p is `PowerLaw` far above the speed where it is 1, or, if it is nearly constant, far above a
    thousandth of v0. Where it grows with the speed, it is a table from v0/100 to 100 v0.
    """
    walls = []
    for R in (values["R1"], values["R2"]):
        p, v0 = values.get("exponent", 0.0), values.get("v0", unit) / unit
        law: Restitution = R
        if p > FLAT:
            low = max(min(1.0, R) ** (1 / p), 1e-3)
            law = PowerLaw(min(1.0, R * low**-p), low * v0, p, sharpness=SHARP)
        elif p < -FLAT:
            ratios = np.geomspace(0.01, 100, 41)
            law = TabulatedRestitution(v0 * ratios, np.minimum(1.0, R * ratios**-p))
        walls.append(law)
    return walls[0], walls[1]


def motion_of_law(
    osc: Oscillator, r: float, clearance: float, phases: _Array, pattern: Pattern,
    walls: tuple[Restitution, Restitution],
) -> StructureMotion:  # fmt: skip
    """The exact motion with laws of restitution, speeds in F0 omega/K, from load phases of its impacts."""
    pair = osc.structure(clearance, walls)
    gaps = np.where(pattern.signs > 0, 0, 1)
    return exact_structure(pair, Load(r, sine=[1, 0]), (phases, gaps, pattern.cycles))


def said(name: str, value: float, error: float | None) -> str:
    """A parameter with its error in words.

    Examples
    --------
    >>> from vibroimpact.studies.identify import said
    >>> said("xi", 0.0114312, 0.000213)
    'xi = 0.01143 +- 0.00021'
    """
    if error is None or error == 0:
        return f"{name} = {value:.6g}"
    if not math.isfinite(error):
        return f"{name} undetermined"
    digits = max(0, 1 - math.floor(math.log10(error)))
    if digits > 8:
        return f"{name} = {value:.6g} +- {error:.2g}"
    return f"{name} = {value:.{digits}f} +- {error:.2g}"


def identify(
    record: SensorRecord | str | os.PathLike[str] | Sequence[Any] | None = None,
    *,
    rate: float | None = None,
    load: ArrayLike | None = None,
    acceleration: ArrayLike | None = None,
    velocity: ArrayLike | None = None,
    displacement: ArrayLike | None = None,
    units: Mapping[str, str] | None = None,
    bandwidth: float | None = None,
    impact_times: ArrayLike | None = None,
    impact_sides: str | Sequence[str] | None = None,
    frequency: float | None = None,
    load_phase: float | None = None,
    known: Mapping[str, float] | None = None,
    start: Oscillator | None = None,
    law: str = "constant",
    law_speed: float | None = None,
) -> Identification:
    """Identify the parameters of a rig from records of its load and of the motion of its primary mass.

    The load gives frequency, phase and amplitude. Impacts are picked as spikes in a band above load, motion and
    ringing, and refined below the sample by the harmonics of the motion, with a mode that rings after them. Their
    phases repeat as a pattern of N impacts in k load cycles, or do not. The linear equations of 1983 with these
    phases give a motion from which exact motions are fitted to all harmonics, weighted by their errors, which the
    noise beside each harmonic tells.

    Parameters
    ----------
    record : SensorRecord, path, or list of them, optional
        One or several records of one rig, fitted at once; else the next arguments make one.
    rate : float
        Sampling rate, Hz.
    load, acceleration, velocity, displacement : array_like (n,)
        The load, and one quantity of the motion of the primary mass.
    units, bandwidth
        As of `SensorRecord`.
    impact_times : array_like (impacts,)
        Times of impacts (s), instead of records of the motion; with `frequency`, `load_phase` if it is known, and
        known M and K, or omega.
    impact_sides : str or sequence of str
        Walls of these impacts, R or L each; by default they alternate, from the right wall on.
    frequency : float, optional
        Load frequency (Hz), by default that of the load, or without one that of the motion.
    load_phase : float, optional
        Phase of the load at time 0 of the impact times (radians).
    known : mapping, optional
        What is known, in SI units: M, K, C, m, d (the whole travel of the free mass), F0, omega, xi, mu, R1, R2,
        and the exponent of a power law.
    start : Oscillator, optional
        What to start from where the records do not tell; xi = 0.01, mu = 0.05 and R = 0.7 by default.
    law : {"constant", "power"}
        How the coefficients of restitution depend on the approach speed v: R1 and R2 are constants, or those at
        the speed v0 of R1 (v/v0)^-exponent and R2 (v/v0)^-exponent. Impacts of different speeds tell the
        exponent: in records at different loads, or in one period.
    law_speed : float, optional
        v0 in m/s; by default the geometric mean of the approach speeds of all impacts.

    Returns
    -------
    Identification

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed, or a record is of no use: clipped, samples missing, too short, channels
        in the wrong order, units that do not agree.
    SingularError
        If there is no motion near the picked impacts.
    MissingExtraError
        Without SciPy (extra `identify`).

    Examples
    --------
    >>> import vibroimpact as vi
    >>> rig = vi.VirtualRig(M=2.7, K=42e3, m=0.11, d=0.006, xi=0.01143, restitution=0.7, F0=6.0, frequency=19.5)
    >>> found = vi.identify(rig.record(seed=1), known=dict(M=2.7, K=42e3, m=0.11))
    >>> found.pattern, found.undetermined
    (Pattern(sides='RLL', cycles=1), [])
    >>> low, high = found.interval("xi")
    >>> bool(low < 0.01143 < high), found.errors["xi"] < 0.0002
    (True, True)
    """
    arrays: dict[str, Any] = {
        "load": load,
        "acceleration": acceleration,
        "velocity": velocity,
        "displacement": displacement,
    }
    given = [name for name, values in arrays.items() if values is not None]
    if impact_times is not None:
        if record is not None or given:
            raise ParameterError("impact_times: must be given without a record")
        return identified(
            impact_times=impact_times, impact_sides=impact_sides, frequency=frequency, load_phase=load_phase,
            known=known, start=start, law=law, law_speed=law_speed,
        )  # fmt: skip
    if record is None:
        if not given:
            raise ParameterError(
                f"record = None: must be given, or one of {', '.join(arrays)}, or impact_times"
            )
        if rate is None:
            raise ParameterTypeError("rate = None: must be the sampling rate in Hz")
        record = SensorRecord(rate, units=units, bandwidth=bandwidth, **arrays)
    elif given or rate is not None or units is not None or bandwidth is not None:
        extra = [
            *given,
            *(
                name
                for name, x in (("rate", rate), ("units", units), ("bandwidth", bandwidth))
                if x is not None
            ),
        ]
        raise ParameterError(f"{extra[0]}: must be left out beside a record, which has its own")
    several = record if isinstance(record, (list, tuple)) else [record]
    if not several:
        raise ParameterError("record = []: must be at least one record")
    return identified(
        [one_record(item) for item in several], frequency=frequency, known=known, start=start, law=law,
        law_speed=law_speed,
    )  # fmt: skip


def one_record(item: Any) -> SensorRecord:
    """A record, also of a file."""
    if isinstance(item, (str, os.PathLike)):
        from ..formats.measured import read_record

        return read_record(item)
    checks.instance(item, "record", SensorRecord)
    record: SensorRecord = item
    return record


def identified(
    records: Sequence[SensorRecord] = (), *, impact_times: Any = None, impact_sides: Any = None,
    frequency: float | None = None, load_phase: float | None = None, known: Mapping[str, float] | None = None,
    start: Oscillator | None = None, law: str = "constant", law_speed: float | None = None, case: str = "",
) -> Identification:  # fmt: skip
    """All steps; arguments as of `identify`."""
    if frequency is not None:
        frequency = positive(frequency, "frequency")
    scale, shared = known_values(known or {})
    power = checks.choice(law, "law", LAWS) == "power"
    if law_speed is not None:
        law_speed = positive(law_speed, "law_speed")
    for name, given in (("law_speed", law_speed), ("known exponent", shared.get("exponent"))):
        if given is not None and not power:
            raise ParameterError(f"{name} = {given!r}: must come with law = 'power'")
    for name in ("R1", "R2"):
        if power and name in shared and law_speed is None:
            raise ParameterError(
                f"known {name} = {shared[name]!r}: must come with law_speed, at which it is known"
            )
    guess = {"xi": 0.01, "mu": 0.05, "R1": 0.7, "R2": 0.7}
    if start is not None:
        of_numbers(start, "start")
        guess = {
            "xi": start.xi,
            "mu": start.mu,
            "R1": start.restitution[0],
            "R2": start.restitution[1],
        }
    if impact_times is not None:
        steps = [of_times(impact_times, impact_sides, frequency, load_phase, scale, shared)]
    else:
        steps = [
            of_record(record, frequency, scale, i, len(records)) for i, record in enumerate(records)
        ]
    found = None
    if all(step.rhythm.status == "periodic" for step in steps):
        found = fitted(steps, scale, shared, guess, power, law_speed)
    return Identification(tables_of(steps, found, scale, shared, case))


def known_values(known: Mapping[str, float]) -> tuple[dict[str, float], dict[str, float]]:
    """What is known: M, K, F0, and the parameters of a fit."""
    if not isinstance(known, Mapping):
        raise ParameterTypeError(
            f"known = {known!r}: must be a mapping such as dict(M=2.7, K=42e3)"
        )
    values: dict[str, float] = {}
    for name, value in known.items():
        checks.choice(name, "known: name", tuple(KNOWN))
        if name in ("xi", "mu", "R1", "R2"):
            values[name] = checks.number(
                value, "restitution" if name[0] == "R" else name, f"known {name}"
            )
        elif name == "exponent":
            values[name] = checks.to_float(value, f"known {name}", "a finite number")
            if not math.isfinite(values[name]):
                raise ParameterError(f"known {name} = {value!r}: must be a finite number")
        else:
            values[name] = positive(value, f"known {name}", zero=name == "C")
    if values.get("mu") == 0:
        raise ParameterError("known mu = 0.0: must be > 0, or impacts do not show in the motion")
    if {"M", "K", "omega"} <= values.keys():
        if abs(values["K"] / values["M"] / values["omega"] ** 2 - 1) > 1e-6:
            raise ParameterError(
                "known M, K, omega: must be such that omega^2 = K/M, or two of them given"
            )
    elif {"M", "K"} <= values.keys():
        values["omega"] = math.sqrt(values["K"] / values["M"])
    elif {"M", "omega"} <= values.keys():
        values["K"] = values["M"] * values["omega"] ** 2
    elif {"K", "omega"} <= values.keys():
        values["M"] = values["K"] / values["omega"] ** 2
    for name, needs, ratio in (("m", ("M",), "mu"), ("C", ("M", "K"), "xi")):
        if name not in values:
            continue
        if not set(needs) <= values.keys():
            raise ParameterError(
                f"known {name} = {values[name]!r}: must come with {' and '.join(needs)}"
            )
        if ratio in values:
            raise ParameterError(
                f"known {name} and {ratio}: must be one of them, which gives the other"
            )
        values[ratio] = (
            values["m"] / values["M"]
            if name == "m"
            else values["C"] / (2 * math.sqrt(values["K"] * values["M"]))
        )
        if ratio == "xi" and not values["xi"] < 1:
            raise ParameterError(f"known C = {values['C']!r}: must be below critical damping")
    scale: dict[str, float] = {name: values[name] for name in ("M", "K", "F0") if name in values}
    return scale, {name: values[name] for name in SHARED if name in values}


class Step:
    """What one record says, step by step."""

    def __init__(self, record: SensorRecord | None, quantity: str) -> None:
        self.record = record
        self.quantity = quantity
        self.Omega = math.nan
        self.load: Tones | None = None
        self.motion: Tones | None = None
        #: All picked impacts: times from the start, and signs.
        self.times: _Array = np.empty(0)
        self.signs: _Array = np.empty(0)
        self.rhythm = no_rhythm("no impacts")
        self.data: Measured | None = None
        self.ring: _Array | None = None


def of_record(
    record: SensorRecord, frequency: float | None, scale: Mapping[str, float], i: int, count: int
) -> Step:
    """The steps before the fit; errors name what is wrong with the record."""
    where = (record.name and f"{record.name}: ") or (f"record {i + 1}: " if count > 1 else "")
    quantity = next((name for name in MOTIONS if getattr(record, name) is not None), None)
    if quantity is None:
        raise ParameterError(
            f"{where}channels {', '.join(record.channels)}: must have one of {', '.join(MOTIONS)}"
        )
    step = Step(record, quantity)
    values: _Array = getattr(record, quantity)
    for name in ("load", quantity):
        channel = getattr(record, name)
        if channel is not None:
            usable(channel, f"{where}{name}")
    rate = record.rate
    near = None if frequency is None else 2 * math.pi * frequency
    force = record.load
    order = MOTIONS[quantity]
    # as a displacement, in which the load frequency is strongest
    source = force if force is not None else smooth(values, rate, order)
    step.Omega = Omega = load_frequency(source, rate, near)
    cycles = record.duration * Omega / (2 * math.pi)
    if cycles < LEAST_CYCLES:
        raise ParameterError(
            f"{where}{record.duration:.6g} s with {cycles:.1f} load cycles of {Omega / (2 * math.pi):.6g} Hz: "
            "must be "
            f"at least {LEAST_CYCLES} load cycles"
        )
    if Omega / (2 * math.pi) > rate / 20:
        raise ParameterError(
            f"{where}rate = {rate:g}: must be at least 20 samples a load cycle of {Omega / (2 * math.pi):.6g} Hz"
        )
    if force is not None:
        step.load = tones(force, rate, Omega, LOAD_TONES)
        order_of_channels(force, values, step.load, Omega, rate, quantity, where)
    k = period_of(values, rate, Omega)
    if order == 2:
        times, step.signs = spikes(values, rate, Omega, record.bandwidth)
        times -= 0.0 if record.bandwidth is None else RISE / record.bandwidth
        step.times = times + (len(record) - 1) / 2 / rate + record.start
        step.rhythm = rhythm(Omega * times / (2 * math.pi), step.signs, cycles, k)
    elif k:  # impacts are no spikes in these, and are found by their harmonics
        step.rhythm = Rhythm("periodic", k, np.empty(0), np.empty(0))
    else:
        step.rhythm = no_rhythm("not periodic")
    if step.rhythm.status != "periodic":
        return step
    base = Omega / k
    top = min(0.4 * rate, math.inf if record.bandwidth is None else 0.8 * record.bandwidth)
    most = int(min(top * 2 * math.pi / base, MOTION_TONES * k))
    # the high harmonics tell the frequency better than the load
    base += tones(values, rate, base, most).off
    step.Omega = Omega = base * k
    step.motion = tones(values, rate, base, most)
    if force is not None:
        step.load = tones(force, rate, Omega, LOAD_TONES)
    orders = np.arange(1, most + 1)
    w = orders * base
    passed = sensor_response(w / (2 * math.pi), record.bandwidth) / (1j * w) ** (2 - order)
    shape = np.zeros(most, dtype=np.complex128)
    shape[k - 1] = -1j
    data = Measured(
        Omega, k, 2 * math.pi * step.rhythm.phases, orders=orders.astype(float),
        values=step.motion.values[1:] / passed, errors=step.motion.errors[1:] / abs(passed), shape=shape,
    )  # fmt: skip
    if step.load is not None:
        response = sensor_response(
            np.arange(LOAD_TONES + 1) * Omega / (2 * math.pi), record.bandwidth
        )
        tone = step.load.values / response
        phase = float(np.angle(1j * tone[1]))
        data.phase, data.phase_error = phase, float(step.load.errors[1] / abs(step.load.values[1]))
        data.F0, data.F0_error = float(abs(tone[1])), float(step.load.errors[1])
        for j in range(2, LOAD_TONES + 1):
            if j * k <= most and abs(step.load.values[j]) > 4 * step.load.errors[j]:
                data.shape[j * k - 1] = tone[j] / abs(tone[1]) * np.exp(-1j * j * phase)
    if "F0" in scale:
        data.F0, data.F0_error = scale["F0"], 1e-9 * scale["F0"]
    high = data.orders >= 3 * k
    if np.count_nonzero(abs(data.values[high]) > CLEAR * data.errors[high]) < 2:
        step.rhythm = no_rhythm("no impacts")
        return step
    step.data = data
    return step


def letters_of(signs: _Array) -> str:
    """The walls of impacts by the signs of the jumps of velocity of the primary mass."""
    return "".join("R" if sign > 0 else "L" for sign in signs)


def smooth(values: _Array, rate: float, order: int) -> _Array:
    """About the displacement, of which its derivative of some order was recorded."""
    spectrum = np.fft.rfft(values - values.mean())
    w = 2 * math.pi * np.fft.rfftfreq(values.size, 1 / rate)
    w[0] = math.inf
    low = max(2, int(5 * values.size / values.size))
    spectrum[:low] = 0
    shape: _Array = np.fft.irfft(spectrum / w**order, values.size)
    return shape


def usable(values: _Array, name: str) -> None:
    """An error if a channel does not vary, or is clipped."""
    low, high = float(values.min()), float(values.max())
    if not high > low:
        raise ParameterError(f"{name} = {low:g} in all samples: must vary")
    for end in (low, high):
        at = np.flatnonzero(values == end)
        runs = np.split(at, np.flatnonzero(np.diff(at) > 1) + 1)
        long = [run.size for run in runs if run.size >= 3]
        if len(long) >= 3 or (long and max(long) >= 8):
            raise ParameterError(
                f"{name} is clipped at {end:.6g}: {int(sum(long))} samples stay there; must be within the "
                "range of "
                "its sensor"
            )


def order_of_channels(
    force: _Array, values: _Array, load: Tones, Omega: float, rate: float, quantity: str, where: str
) -> None:
    """An error if the load looks like a motion with impacts, and the motion like a load."""

    def off_sine(channel: _Array, first: complex) -> float:
        power = float(np.var(channel))
        return math.sqrt(max(0.0, 1 - 0.5 * abs(first) ** 2 / power))

    of_load = off_sine(force, complex(load.values[1]))
    of_motion = off_sine(values, complex(tones(values, rate, Omega, 1).values[1]))
    if of_load > 0.3 and of_motion < 0.15:
        raise ParameterError(
            f"{where}load is {of_load:.0%} off a sine and {quantity} {of_motion:.0%}: must be the load and the "
            "motion; "
            "they seem to be in the wrong order"
        )
    if of_load > 0.5:
        raise ParameterError(
            f"{where}load is {of_load:.0%} off a sine: must be the load of a shaker"
        )


def of_times(
    impact_times: Any, impact_sides: Any, frequency: float | None, load_phase: float | None,
    scale: Mapping[str, float], shared: Mapping[str, float],
) -> Step:  # fmt: skip
    """The steps before the fit, of impact times alone."""
    if frequency is None:
        raise ParameterError(
            "frequency = None: must be the load frequency in Hz beside impact_times"
        )
    wanted = "increasing finite numbers, at least two"
    times = checks.real_array(impact_times, "impact_times", wanted)
    if (
        times.ndim != 1
        or times.size < 2
        or not np.isfinite(times).all()
        or (np.diff(times) <= 0).any()
    ):
        raise ParameterError(f"impact_times of shape {times.shape}: must be {wanted}")
    if "omega" not in shared:
        raise ParameterError(
            "known: must have omega, or M and K, beside impact_times, which do not tell it"
        )
    letters = "".join(impact_sides).upper() if impact_sides is not None else "RL" * times.size
    letters = letters[: times.size] if impact_sides is None else letters
    if len(letters) != times.size or set(letters) - {"R", "L"}:
        raise ParameterError(
            f"impact_sides = {impact_sides!r}: must be one letter R or L for each of {times.size} impacts"
        )
    step = Step(None, "impact times")
    step.Omega = Omega = 2 * math.pi * frequency
    step.times, step.signs = times, np.array([1.0 if letter == "R" else -1.0 for letter in letters])
    cycles = Omega * times / (2 * math.pi)
    span = cycles[-1] - cycles[0] + float(np.median(np.diff(cycles)))
    if span < 3:  # about one period
        period = max(1, round(span))
        order = np.argsort(cycles % period)
        step.rhythm = Rhythm("periodic", period, (cycles % period)[order], step.signs[order])
    else:
        step.rhythm = rhythm(cycles, step.signs, span, repeated(cycles, step.signs, span))
    if step.rhythm.status == "periodic" and len(set(step.rhythm.signs)) < 2:
        step.rhythm = no_rhythm("not periodic")
    if step.rhythm.status != "periodic":
        return step
    k = step.rhythm.cycles
    angles, errors = [], []
    for phase, sign in zip(step.rhythm.phases, step.rhythm.signs, strict=True):
        off = (cycles - phase + k / 2) % k - k / 2
        own = off[(abs(off) < 0.05) & (step.signs == sign)]
        angles.append(2 * math.pi * (phase + own.mean()))
        errors.append(
            2 * math.pi * (own.std(ddof=1) / math.sqrt(own.size) if own.size > 1 else 1e-3)
        )
    data = Measured(
        Omega, k, np.array(angles), np.maximum(errors, 1e-9), np.zeros(len(angles)),
        sides=letters_of(step.rhythm.signs),
    )  # fmt: skip
    if "F0" in scale:
        data.F0, data.F0_error = scale["F0"], 1e-9 * scale["F0"]
    if load_phase is not None:
        data.phase, data.phase_error = (
            checks.to_float(load_phase, "load_phase", "a finite number"),
            1e-6,
        )
    step.data = data
    return step


def fitted(
    steps: list[Step], scale: Mapping[str, float], shared: dict[str, float], guess: dict[str, float],
    power: bool, law_speed: float | None,
) -> Fit:  # fmt: skip
    """The fit of exact motions to all records."""
    law = shared
    # constants first: what is known of a law does not hold for them
    shared = {name: value for name, value in shared.items() if not (power and name in OF_LAW)}
    shared |= {"exponent": 0.0}
    starts: list[dict[str, float]] = []
    lengths, phases, rings = [], [], []
    for step in steps:
        data = step.data
        assert data is not None
        if data.orders.size:
            first = step.data = refined(step, shared.get("omega", data.Omega * 1.0))
            values, static, phase = start_of(first, shared, guess)
            units_agree(step, first, values, static, scale)
        else:
            values, static, phase = start_of_times(data, scale, shared, guess)
        rings.append(step.ring)
        starts.append(values)
        lengths.append(static)
        phases.append(phase)
    M, K = scale.get("M"), scale.get("K")
    found = [step.data for step in steps if step.data is not None]
    # each record by itself, and then all from what these tell together
    single = [
        fit([data], shared, begin, [length], [phase], ring, M, K, rough=power)
        for data, begin, length, phase, ring in zip(
            found, starts, lengths, phases, rings, strict=True
        )
    ]
    if len(found) == 1 and not power:
        return single[0]
    middle = dict(shared)
    for name in (name for name in SHARED if name not in shared):
        sizes = [
            one.covariance[j, j] if name not in one.undetermined else math.inf
            for one in single for j in [one.names.index(name)]
        ]  # fmt: skip
        weights = np.array([1 / max(size, 1e-300) for size in sizes])
        weights = weights if weights.any() else np.ones(len(single))
        middle[name] = float(np.average([one.values[name] for one in single], weights=weights))
    ring = next((one.ring for one in single if one.ring is not None), None)
    lengths, phases = [one.lengths[0] for one in single], [one.phases[0] for one in single]
    if not power:
        return fit(found, shared, middle, lengths, phases, ring, M, K)
    speed, of_law = start_of_law(single, law, law_speed)
    near = [one.motions[0] for one in single]
    return fit(found, law, middle | of_law, lengths, phases, ring, M, K, speed, near)


def start_of_law(
    single: Sequence[Fit], known: Mapping[str, float], speed: float | None
) -> tuple[float, dict[str, float]]:
    """The reference speed, and a power law through the coefficients of records that were fitted by themselves."""
    units = [one.values["omega"] * one.lengths[0] for one in single]
    all_speeds = [
        unit * approach_speeds(one.motions[0]) for unit, one in zip(units, single, strict=True)
    ]
    if speed is None:
        speed = float(np.exp(np.mean(np.log(np.concatenate(all_speeds)))))
    x, y = np.empty((2, len(single))), np.empty((2, len(single)))
    for i, (one, speeds) in enumerate(zip(single, all_speeds, strict=True)):
        for j, (name, sign) in enumerate((("R1", 1), ("R2", -1))):
            own = one.motions[0].pattern.signs == sign
            x[j, i] = np.mean(np.log(speeds[own] / speed))
            y[j, i] = math.log(min(max(one.values[name], 0.05), 1.0))
    apart = x - x.mean(axis=1, keepdims=True)
    # none where the speeds are nearly alike
    steep = float(np.clip(-np.sum(apart * y) / (np.sum(apart**2) + 1e-2), -0.5, 0.5))
    values = {"exponent": known.get("exponent", steep)}
    for name, level in zip(("R1", "R2"), np.mean(y + values["exponent"] * x, axis=1), strict=True):
        values[name] = known.get(name, float(min(math.exp(level), 0.99)))
    return speed, values


def refined(step: Step, omega: float) -> Measured:
    """The impacts of a record refined below the sample."""
    data = step.data
    assert data is not None
    better = refine(data, omega)
    step.ring = better.ring
    whole = 2 * math.pi * data.k
    order = np.argsort(better.angles % whole)
    sides = letters_of(np.sign(better.jumps[order]))
    if len(set(sides)) < 2:
        raise SingularError(
            f"impacts {sides} in {data.k} load cycles: must be on both walls; with impacts on one wall no "
            "motion is "
            "periodic"
        )
    if step.quantity != "acceleration" and step.record is not None:
        turns = np.arange(math.ceil(step.record.duration * data.Omega / whole) + 2)[:, None]
        half = (len(step.record) - 1) / 2 / step.record.rate
        times = (
            (better.angles[order] % whole + whole * (turns - turns.size // 2 - 1)) / data.Omega
            + half
        ).ravel()
        inside = (times >= 0) & (times <= 2 * half)
        step.times = times[inside] + step.record.start
        step.signs = np.tile(np.sign(better.jumps[order]), turns.size)[inside]
    # begun where R comes before L, as in `Pattern.standard`
    first = max(range(len(sides)), key=lambda i: sides[i:] + sides[:i])
    order = np.roll(order, -first)
    angles = np.unwrap(better.angles[order] % whole, period=whole)
    angles[1:] += whole * (angles[1:] < angles[0])
    return replace(
        data, sides=sides[first:] + sides[:first], angles=angles, angle_errors=better.errors[order],
        jumps=better.jumps[order],
    )  # fmt: skip


def start_of_times(
    data: Measured,
    scale: Mapping[str, float],
    shared: Mapping[str, float],
    guess: Mapping[str, float],
) -> tuple[dict[str, float], float, float]:
    """Parameters to start from, where there are impact times alone: the linear equations tell D."""
    from ..solve import periodic

    values = {**guess, **shared}
    osc = Oscillator(xi=values["xi"], mu=values["mu"], restitution=(values["R1"], values["R2"]))
    linear = periodic(osc, data.Omega / values["omega"], data.angles - data.angles[0], data.pattern)
    static = scale["F0"] / scale["K"] if {"F0", "K"} <= scale.keys() else 1 / linear.clearance
    values.setdefault("d", linear.clearance * static)
    phase = data.phase if data.phase is not None else linear.load_phase - float(data.angles[0])
    return values, values["d"] / linear.clearance, phase


def units_agree(
    step: Step,
    data: Measured,
    values: Mapping[str, float],
    static: float,
    scale: Mapping[str, float],
) -> None:
    """An error if the load by its channel is not about the load by the motion."""
    stiffness = scale.get("K", scale.get("M", math.nan) * values["omega"] ** 2)
    if data.F0 is None or not math.isfinite(stiffness):
        return
    ratio = data.F0 / (stiffness * static)
    if 1 / LARGEST_RATIO < ratio < LARGEST_RATIO:
        return
    near = [
        text
        for factor, text in FACTORS.items()
        if abs(abs(math.log(ratio)) - math.log(factor)) < 0.3
    ]
    hint = f"; is it {near[0]}?" if near else ""
    raise ParameterError(
        f"load of {data.F0:.4g} N and {step.quantity}, which tells {stiffness * static:.4g} N: must agree; the "
        "units of a "
        f"channel, or known M and K, are wrong by a factor of {max(ratio, 1 / ratio):.4g}{hint}"
    )


def tables_of(
    steps: list[Step],
    found: Fit | None,
    scale: Mapping[str, float],
    shared: Mapping[str, float],
    case: str,
) -> Any:
    """All columns of a result."""
    parameters = parameters_of(steps, found, scale, shared)
    names = (
        "status", "quantity", "sides", "cycles", "frequency", "load", "load_phase", "r", "clearance",
        "static", "first", "misfit", "multipliers",
    )  # fmt: skip
    records: dict[str, list[Any]] = {name: [] for name in names}
    impacts: dict[str, list[Any]] = {
        name: []
        for name in ("number", "side", "picked", "picked_error", "fitted", "speed", "restitution")
    }
    picks: dict[str, list[Any]] = {name: [] for name in ("number", "time", "side")}
    samples: dict[str, list[Any]] = {
        name: [] for name in ("number", "time", "load", "load_fit", "motion", "motion_fit")
    }
    notes: list[tuple[bool, str]] = []
    for i, step in enumerate(steps):
        data, record = step.data, step.record
        motion = found.motions[i] if found is not None else None
        multipliers = (
            np.full(4, complex(math.nan, math.nan)) if motion is None else motion.multipliers
        )
        pattern = data.pattern if data is not None and found is not None else None
        middle = 0.0 if record is None else (len(record) - 1) / 2 / record.rate
        begin = 0.0 if record is None else record.start
        load = data.F0 if data is not None and data.F0 is not None else math.nan
        if data is None and step.load is not None:
            load = float(abs(step.load.values[1]))
        phase = found.phases[i] if found is not None else math.nan
        if found is None and step.load is not None:
            phase = float(np.angle(1j * step.load.values[1]))
        fit_of: dict[str, Any] = {
            "status": step.rhythm.status, "quantity": step.quantity,
            "sides": pattern.sides if pattern else "", "cycles": pattern.cycles if pattern else 0,
            "frequency": step.Omega / (2 * math.pi), "load": load,
            "load_phase": (phase - step.Omega * middle) % (2 * math.pi),
            "r": motion.r if motion else math.nan,
            "clearance": motion.clearance if motion else math.nan,
            "static": found.lengths[i] if found is not None else math.nan,
            "misfit": found.misfits[i] if found is not None else math.nan,
        }  # fmt: skip
        first = math.nan
        if found is not None and motion is not None and data is not None:
            unit = found.values["omega"] * found.lengths[i]
            if found.speed is not None:
                of_law = {**found.values, "v0": found.speed}
                multipliers = motion_of_law(
                    motion.osc, motion.r, motion.clearance, described(motion)[0], motion.pattern,
                    walls_of(of_law, unit),
                ).multipliers  # fmt: skip
            impacts["speed"] += (unit * approach_speeds(motion)).tolist()
            impacts["restitution"] += motion.restitution.tolist()
            fitted_angles = motion.phases + motion.load_phase
            turn = fitted_angles - phase - data.angles
            fitted_angles = fitted_angles - 2 * math.pi * round(
                float(np.median(turn)) / (2 * math.pi)
            )
            first = (fitted_angles[0] - phase) / step.Omega + middle + begin
            own = Pattern(pattern.sides, pattern.cycles).symbols if pattern else []
            impacts["number"] += [i + 1] * len(own)
            impacts["side"] += own
            impacts["picked"] += (data.angles + phase).tolist()
            impacts["picked_error"] += data.angle_errors.tolist()
            impacts["fitted"] += fitted_angles.tolist()
        for name, value in {**fit_of, "multipliers": multipliers, "first": first}.items():
            records[name].append(value)
        picks["number"] += [i + 1] * step.times.size
        picks["time"] += step.times.tolist()
        picks["side"] += ["R" if sign > 0 else "L" for sign in step.signs]
        if record is not None:
            add_samples(samples, i, step, record, found)
        said_of = f"record {i + 1}: " if len(steps) > 1 else ""
        if found is not None and found.misfits[i] > DOUBTFUL:
            notes.append(
                (
                    False,
                    f"{said_of}misfit of {found.misfits[i]:.3g}: the motion does not describe the record to "
                    "its scatter, so that the pattern or a known value may be wrong",
                )
            )
        if step.load is not None and found is not None:
            tone = abs(step.load.values)
            share = math.sqrt(float(np.sum(tone[2:] ** 2))) / float(tone[1])
            if share > SHAPED:
                notes.append(
                    (
                        False,
                        f"{said_of}the load has harmonics of {100 * share:.2g} % of its fundamental: the "
                        "impacts of the fitted motion ignore them, and the errors do not contain this",
                    )
                )
        if pattern is not None:
            notes.append(
                (False, f"{said_of}{pattern.sides}/{pattern.cycles} at r = {records['r'][i]:.6g}")
            )
        else:
            notes.append(
                (
                    True,
                    f"{said_of}{step.rhythm.status}: {step.times.size} impacts picked; no motion is fitted",
                )
            )
    if found is not None:
        columns = (parameters[key] for key in ("name", "value", "error", "state"))
        notes += [
            (False, said(name, value, error))
            for name, value, error, state in zip(*columns, strict=True)
            if state != "known" and math.isfinite(value)
        ]
    tables = {
        "parameters": (("parameter",), parameters),
        "records": (("recording",), records),
        "impacts": (("impact",), impacts),
        "picks": (("pick",), picks),
        "samples": (("sample",), samples),
    }
    return made("identify", case, tables, notes=notes)


def add_samples(
    samples: dict[str, list[Any]], i: int, step: Step, record: SensorRecord, found: Fit | None
) -> None:
    """Samples of the first load cycles of a record, with what was fitted to them."""
    cycles = SHOWN_CYCLES * max(1, step.rhythm.cycles)
    n = min(len(record), int(cycles * 2 * math.pi / step.Omega * record.rate), SHOWN_SAMPLES * 4)
    here = slice(0, n, max(1, n // SHOWN_SAMPLES))
    t = centred(len(record), record.rate)[here]
    none = np.full(t.size, math.nan)
    load = record.load[here] if record.load is not None else none
    load_fit = step.load.at(t) if step.load is not None else none
    values = getattr(record, step.quantity)[here]
    motion_fit = none
    if found is not None and step.data is not None and step.motion is not None:
        motion_fit = modelled(step.data, i, step, record, found).at(t)
    samples["number"] += [i + 1] * t.size
    samples["time"] += record.times[here].tolist()
    for name, column_values in (
        ("load", load),
        ("load_fit", load_fit),
        ("motion", values),
        ("motion_fit", motion_fit),
    ):
        samples[name] += column_values.tolist()


def modelled(data: Measured, i: int, step: Step, record: SensorRecord, found: Fit) -> Tones:
    """The harmonics of the fitted motion as the sensor gives them."""
    from ..rig_fit import predicted

    # up to half the sampling rate, which is more than was fitted
    k, n = data.k, int(0.5 * record.rate * 2 * math.pi / data.Omega * data.k)
    shape = np.concatenate([data.shape, np.zeros(max(0, n - data.shape.size))])
    data = replace(data, orders=np.arange(1.0, shape.size + 1), shape=shape)
    values = predicted(data, found, i)
    w = data.frequencies
    passed = sensor_response(w / (2 * math.pi), record.bandwidth) / (1j * w) ** (
        2 - MOTIONS[step.quantity]
    )
    all_values = np.concatenate(
        [[step.motion.values[0] if step.motion is not None else 0.0], values * passed]
    )
    return Tones(data.Omega / k, all_values, np.zeros(all_values.size), 0.0)


def parameters_of(
    steps: list[Step], found: Fit | None, scale: Mapping[str, float], shared: Mapping[str, float]
) -> dict[str, list[Any]]:
    """The table of parameters: what is known, what was fitted, and what follows from both."""
    rows: list[tuple[str, float, float, str, str]] = []
    units = KNOWN | {"F0/K": "m", "v0": "m/s"}

    def add(name: str, value: float, error: float, state: str) -> None:
        rows.append(
            (name, value, error, units.get(name, "m" if name.startswith("F0/K") else "N"), state)
        )

    errors: dict[str, float] = {}
    states: dict[str, str] = {}
    values: dict[str, float] = dict(shared)
    if found is not None:
        values = {
            **found.values,
            **{name: found.lengths[int(name.split()[1])] for name in found.names if " " in name},
        }
        for j, name in enumerate(found.names):
            vague = name in found.undetermined
            errors[name] = math.inf if vague else math.sqrt(found.covariance[j, j])
            states[name] = "undetermined" if vague else "fitted"
    data = steps[0].data
    F0 = data.F0 if data is not None else None
    F0_error = data.F0_error if data is not None else math.nan
    omega, static = values.get("omega", math.nan), values.get("F0/K 0", math.nan)

    def relative(*powers: tuple[str, float]) -> float:
        """Relative error of a product of powers of fitted parameters."""
        if found is None:
            return math.inf
        if any(states.get(name) == "undetermined" for name, _ in powers):
            return math.inf
        place = [
            (found.names.index(name), power / values[name])
            for name, power in powers
            if name in found.names
        ]
        return math.sqrt(
            max(0.0, sum(a * b * found.covariance[j, k] for j, a in place for k, b in place))
        )

    if found is not None or scale:
        M, K = scale.get("M"), scale.get("K")
        if M is not None:
            add("M", M, 0.0, "known")
        if K is not None:
            add("K", K, 0.0, "known")
        if M is None and found is not None:
            value, share = math.nan, math.inf
            if K is not None:
                value, share = K / omega**2, relative(("omega", -2.0))
            elif F0 is not None:
                value = F0 / (static * omega**2)
                share = math.hypot(relative(("omega", -2.0), ("F0/K 0", -1.0)), F0_error / F0)
            add(
                "M",
                value,
                value * share if math.isfinite(value) else math.inf,
                "fitted" if math.isfinite(share) else "undetermined",
            )
        if K is None and found is not None:
            value, share = math.nan, math.inf
            if M is not None:
                value, share = M * omega**2, relative(("omega", 2.0))
            elif F0 is not None:
                value, share = F0 / static, math.hypot(relative(("F0/K 0", -1.0)), F0_error / F0)
            add(
                "K",
                value,
                value * share if math.isfinite(value) else math.inf,
                "fitted" if math.isfinite(share) else "undetermined",
            )
    if found is not None and found.speed is not None:
        add("v0", found.speed, 0.0, "known")
    for name in SHARED:
        if name == "exponent" and (found is None or found.speed is None):
            continue
        if name in shared:
            add(name, shared[name], 0.0, "known")
        elif found is not None:
            add(name, values[name], errors[name], states[name])
    if found is not None and F0 is None and "K" in scale:
        share = relative(("F0/K 0", 1.0))
        add(
            "F0",
            scale["K"] * static,
            scale["K"] * static * share,
            "fitted" if math.isfinite(share) else "undetermined",
        )
    elif F0 is not None:
        add("F0", F0, 0.0 if "F0" in scale else F0_error, "known" if "F0" in scale else "fitted")
    elif found is not None:
        add("F0", math.nan, math.inf, "undetermined")
    for j in range(len(steps) if found is not None else 0):
        name = f"F0/K {j}"
        add("F0/K" if j == 0 else f"F0/K {j + 1}", values[name], errors[name], states[name])
    table: dict[str, list[Any]] = {
        key: [row[j] for row in rows]
        for j, key in enumerate(("name", "value", "error", "unit", "state"))
    }
    half = [WIDTH * error for error in table["error"]]
    table["low"] = [value - width for value, width in zip(table["value"], half, strict=True)]
    table["high"] = [value + width for value, width in zip(table["value"], half, strict=True)]
    return table
