"""The steps of an identification in sequence: from records and options, or a case, to the tables of a result."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from typing import Any

import numpy as np

from ..base import checks
from ..base.errors import ParameterError, ParameterTypeError, SingularError, VibroimpactError
from ..results.tables import Result
from ..systems.oscillator import Oscillator, of_numbers
from ..systems.units import SI as SI_UNITS
from ..systems.units import Units, has_unit, own_number, positive
from .fit import EXPONENTS, Fit
from .known import Doubted, Known, known_values, with_errors
from .laws import KINDS, Law
from .measured import OF_SENSORS, SensorRecord
from .sliding import with_friction
from .stages import again, fitted, identified_by
from .steps import Step, of_record, of_times
from .tables import is_strained, tables_of

#: Relative standard error of the calibration of a sensor.
CALIBRATION = 0.01
#: The keys of &identify for known values.
OF_KEYS = {
    "mass": "M", "stiffness": "K", "damping": "C", "free_mass": "m", "clearance": "d", "load_amplitude": "F0",
}  # fmt: skip
#: The known values that fix a parameter of the fit.
HELD = {
    "mu": ("mu", "m"), "omega": ("omega", "K"), "xi": ("xi", "C"), "d": ("d",),
}  # fmt: skip
#: The shares of the standard error of a known value over which the change of the parameters is computed, in order.
SHARES = (1.0, 0.3, 0.1)


def identified(
    records: Sequence[SensorRecord] = (), *, impact_times: Any = None, impact_sides: Any = None,
    frequency: float | None = None, load_phase: float | None = None, known: Mapping[str, Known] | None = None,
    start: Oscillator | None = None, law: str | None = None, law_speed: float | None = None,
    law_knots: int | None = None, friction: float | str | bool | np.bool_ | None = None,
    calibration: float = CALIBRATION, case: str = "", progress: Callable[[float, str], None] | None = None,
) -> Result:  # fmt: skip
    """All steps; arguments as in `identify`, and the text of a case."""
    if frequency is not None:
        frequency = positive(own_number(frequency, "frequency"), "frequency", given=frequency)
    values, doubted = with_errors(known or {})
    scale, shared = known_values(values)
    calibration = positive(calibration, "calibration", zero=True)
    if not calibration < 1:
        raise ParameterError(
            f"calibration = {calibration!r}: must be below 1, such as 0.01 for 1 %"
        )
    # a known R1 or R2 without a speed is a constant
    may_fall = law is None and friction is None and not {"R1", "R2"} & shared.keys()
    law = "constant" if law is None else checks.choice(law, "law", KINDS)
    if law_speed is not None:
        law_speed = positive(law_speed, "law_speed")
    if law_speed is not None and law == "constant":
        raise ParameterError(
            f"law_speed = {law_speed!r}: must be given with a law over the speed, such as law = 'power'"
        )
    tabulated = law.startswith("table")
    if law_knots is not None and not tabulated:
        raise ParameterError(
            f"law_knots = {law_knots!r}: must be given with law = 'table' or 'tables'"
        )
    knots = checks.integer(3 if law_knots is None else law_knots, "law_knots", 2, 20)
    own = Law(law, knots if tabulated else 0)
    if isinstance(friction, np.bool_):
        friction = bool(friction)
    if friction is not None:
        rubbing = "fitted friction" if friction is True else f"friction = {friction!r}"
        if law != "constant":
            raise ParameterError(f"{rubbing}: must be left out with law = {law!r}")
        if len(records) != 1:
            raise ParameterError(f"{rubbing}: must be given with one record, not {len(records)}")
        if friction is False:
            raise ParameterError("friction = False: must be left out, a known friction, or True")
    for name in shared:
        if name not in own.shared:
            of = [repr(kind) for kind in KINDS if name in Law(kind).shared]
            raise ParameterError(
                f"known {name} = {shared[name]!r}: must be given with law = {' or '.join(of)}"
            )
        if name in ("R1", "R2") and law != "constant" and law_speed is None:
            raise ParameterError(
                f"known {name} = {shared[name]!r}: must be given with law_speed, the speed to which it applies"
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
            of_record(record, frequency, scale, i, len(records), calibration)
            for i, record in enumerate(records)
        ]
    begun = steps
    steps, found, own = identified_by(begun, scale, shared, guess, own, law_speed, progress)
    if friction is not None:
        share = friction_over(friction, steps[0], scale)
        steps, found, own = with_friction((steps, found, own), scale, shared, guess, share)
        if share is not None:
            shared["friction"] = share

    def completed(steps: list[Step], found: Fit | None, own: Law) -> Result:
        """The tables of a fit, with the effects of the errors of known values."""

        def refitted(name: str, value: float) -> dict[str, float]:
            """The values of all parameters with another known value."""
            other = identified(
                records, impact_times=impact_times, impact_sides=impact_sides, frequency=frequency,
                load_phase=load_phase, known={**values, name: value}, start=start, law=own.kind,
                law_speed=law_speed, law_knots=law_knots, friction=friction, calibration=calibration,
                progress=lambda share, task: None,
            )  # fmt: skip
            return by_parameter(other, "value")

        changes = {item.name: (item, change_over(item, refitted)) for item in doubted}
        return tables_of(steps, found, scale, shared, own, case, changes)

    result = completed(steps, found, own)
    if may_fall and found is not None and not is_good(result):
        other = falling(steps if found.motions else begun, steps, found, values, guess)
        result = result if other is None else completed(*other)
    return result


def is_good(result: Result) -> bool:
    """Whether parameters were fitted and there is no doubt about them."""
    doubted = any("doubtful: " in text for _, text in result.notes)
    misfit: float = result.column("records", "misfit").values[0]
    return math.isfinite(misfit) and not doubted


def falling(
    begun: Sequence[Step], steps: Sequence[Step], found: Fit, known: Mapping[str, float], guess: dict[str, float],
) -> tuple[list[Step], Fit, Law] | None:  # fmt: skip
    """The fit with coefficients of restitution that fall with the speed, where only these describe the records.

    Constants are rejected; powers of the speed raise no doubt and determine what constants determine; constants
    remain doubtful even if a contradicted known value, or friction, is fitted as well. Otherwise the result is
    None, since a wrong known value may resemble a law of restitution. Impacts that repeat although no motion with
    constants has them may be those of a motion with powers, which is then searched for like any other.

    Parameters
    ----------
    begun : sequence of Step
        From which the fits begin: with the flights of the motions, or without, if no motion was found.
    steps : sequence of Step
        Those of the fit with constants.
    found : Fit
        With constants.
    known : mapping
        The known values by their given names.
    """
    strained = {name: found.strains[name] for name in found.strains if is_strained(found, name)}
    rejected = [
        each.size for name, each in strained.items() if name in EXPONENTS and each.change > 0
    ]
    if not (rejected and (found.motions or all(again(step) for step in steps))):
        return None

    def described(law: str, without: str = "") -> tuple[list[Step], Fit, Law] | None:
        """A fit without doubts, with a law, or without one of the known values, or with friction."""
        scale, shared = known_values({name: known[name] for name in known if name != without})
        others = [copy(step) for step in begun]
        try:
            one: tuple[list[Step], Fit | None, Law]
            if found.motions:
                one = others, *fitted(others, scale, shared, guess, Law(law), None)
            else:
                one = identified_by(others, scale, shared, guess, Law(law), None)
            others, fit, own = one
            if without == "friction":
                one = with_friction(one, scale, shared, guess, None)
            result = tables_of(*one[:2], scale, shared, one[2], "")
        except VibroimpactError:
            return None
        return (others, fit, own) if fit is not None and is_good(result) else None

    falls = described("powers")
    if falls is None or not falls[1].motions:
        return None
    if set(falls[1].undetermined) - set(EXPONENTS) - set(found.undetermined):
        return None
    if any(falls[1].values[name] < 0 for name in EXPONENTS if name not in falls[1].undetermined):
        return None
    rivals = [name for name in known for of in strained if name in HELD.get(of, ())]
    if "friction" in strained and len(steps) == 1:
        rivals.append("friction")
    if any(described("constant", name) for name in rivals):
        return None
    others = f", and fitting {' or '.join(rivals)} does not explain the record" if rivals else ""
    falls[0][0].notes.insert(
        0,
        f"R falls with the approach speed: constants are rejected ({max(rejected):.2g} standard errors){others}; "
        "law = 'constant' fits constants",
    )
    return falls


def by_parameter(result: Result, name: str) -> dict[str, Any]:
    """A column of the table of parameters of a result, by their names."""
    names = result.column("parameters", "name").decoded().tolist()
    return dict(zip(names, result.column("parameters", name).decoded().tolist(), strict=True))


def change_over(
    item: Doubted, refitted: Callable[[str, float], dict[str, float]]
) -> dict[str, float]:
    """Half the difference of all parameters between fits with a known value one standard error above and below; in
    proportion to the difference at closer values if no motion fits there."""
    reason = ""
    for share in SHARES:
        try:
            above, below = (
                refitted(item.name, item.value + sign * share * item.error) for sign in (1, -1)
            )
        except SingularError as error:
            reason = reason or str(error).partition("; tried:")[0]
            continue
        return {name: (above[name] - below[name]) / (2 * share) for name in above}
    raise SingularError(
        f"known {item.name} = {item.value:.6g} +- {item.error:.2g}: no motion fits with a value within this "
        f"error; state a smaller one ({reason})"
    )


def records_of(
    record: Any, rate: float | None, arrays: Mapping[str, Any], sensors: Mapping[str, Any]
) -> list[SensorRecord]:
    """The given records, or one made from the arrays."""
    given = [name for name, values in arrays.items() if values is not None]
    if record is None:
        if not given:
            raise ParameterError(
                f"record = None: must be given, or one of {', '.join(arrays)}, or impact_times"
            )
        if rate is None:
            raise ParameterTypeError("rate = None: must be the sampling rate in Hz")
        record = SensorRecord(rate, **arrays, **sensors)
    elif extra := [
        *given,
        *(name for name, x in {"rate": rate, **sensors}.items() if x is not None),
    ]:
        raise ParameterError(
            f"{extra[0]}: must be left out if a record is given, which has its own"
        )
    several = record if isinstance(record, (list, tuple)) else [record]
    if not several:
        raise ParameterError("record = []: must be at least one record")
    return [one_record(item) for item in several]


def one_record(item: Any) -> SensorRecord:
    """A record, possibly from a file."""
    if isinstance(item, (str, os.PathLike)):
        from .sensor_files import read_record

        try:
            return read_record(item)
        except ParameterError as error:
            raise ParameterError("record" + str(error).removeprefix("path")) from None
    checks.instance(item, "record", SensorRecord)
    record: SensorRecord = item
    return record


def identified_of(case: Any, progress: Callable[[float, str], None] | None = None) -> Result:
    """The steps for an &identify case and the files that it names."""
    from .sensor_files import read_record

    keys = case.keys
    known = {name: keys[key] for key, name in OF_KEYS.items() if key in keys}
    if "natural_frequency" in keys:
        known["omega"] = (2 * math.pi * np.array(keys["natural_frequency"])).tolist()
    right, left = case.osc.restitution
    for name in ("exponent", "knee"):
        each = np.atleast_1d(keys.get(f"law_{name}", [])).tolist()
        known |= {
            name + wall: value
            for wall, value in zip("12" if len(each) > 1 else [""], each, strict=False)
        }
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
        "law": keys.get("law"),
        "law_speed": keys.get("law_speed"),
        "law_knots": keys.get("law_knots"),
        "friction": friction_of(keys.get("friction")),
        "calibration": keys.get("calibration", CALIBRATION),
        "progress": progress,
    }
    if "impact_times" in keys:
        options |= {
            "impact_times": keys["impact_times"], "impact_sides": keys.get("impact_sides"),
            "load_phase": keys.get("load_phase"),
        }  # fmt: skip
        return identified(case=case.text, **options)
    paths = keys["records"]
    how = {name: keys.get(name) for name in ("rate", "channels", *OF_SENSORS)}
    how["units"] = keys.get("channel_units")
    records = [read_record(path, **how) for path in ([paths] if isinstance(paths, str) else paths)]
    return identified(records, case=case.text, **options)


def friction_of(text: str | None) -> float | str | bool | None:
    """The argument `friction` of a key: a number, a force with its unit, or True for 'fit'."""
    if text is None or text.lower() == "fit":
        return None if text is None else True
    try:
        return float(text)
    except ValueError:
        if not has_unit(text):
            raise ParameterError(
                f"friction = {text!r}: must be 'fit', a fraction of F0, or a force such as '0.3 N'"
            ) from None
        return text


def friction_over(
    friction: float | str | bool, step: Step, scale: Mapping[str, float]
) -> float | None:
    """A known friction over F0; None if it is to be fitted."""
    if friction is True:
        return None
    if not has_unit(friction):
        return positive(friction, "friction", zero=True)
    force = positive(own_number(friction, "load", label="friction"), "friction", zero=True)
    F0 = scale.get("F0", step.F0)
    if F0 is None:
        raise ParameterError(
            "friction: must be a fraction of F0 if neither a load channel nor a known load amplitude gives F0"
        )
    return force / F0
