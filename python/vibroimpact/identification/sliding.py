"""The fit of a rig with friction in its slot to a record."""

from __future__ import annotations

import math
from collections.abc import Mapping
from copy import copy
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..base.errors import SingularError
from .aperiodic import BEYOND, by_laws, start_of_friction
from .fit import Fit, fit
from .friction import slips_of
from .known import HINT
from .laws import Law
from .motions import Impacting
from .signals import centred
from .stages import APART, lawful_of
from .steps import Step, flown, flown_apart
from .strains import Strain
from .waves import Measured
from .windows import SMOOTHED

_Array = NDArray[np.float64]
#: Largest number of fits with the response to friction of the previous one, and its change at which they end,
#: relative to the errors of a folded record.
ROUNDS, SETTLED = 12, 0.03
#: Number of rounds in which the impacts of a record that is not periodic are searched for again, and largest
#: change of a parameter in the last round, in standard errors.
SEARCHES, MOVED = 2, 0.1
#: The message about a friction that a record does not determine.
UNDETERMINED = (
    "fitted friction: not determined by this record, since with these impacts friction has nearly the same effect "
    "as other coefficients of restitution; it must be known or left out"
)
#: Largest friction over F0 with which a fit begins.
MOST = 0.1


def with_friction(
    found: tuple[list[Step], Fit | None, Law], scale: Mapping[str, float], shared: Mapping[str, float],
    guess: Mapping[str, float], friction: float | None,
) -> tuple[list[Step], Fit, Law]:  # fmt: skip
    """The fit with a known friction over F0, or with a fitted friction (None), starting from a fit without
    friction.

    Friction acts between the impacts, where the primary mass would fly freely. Flights are therefore fitted to the
    record minus the response to friction of the previously fitted motion, repeatedly until this response no longer
    changes.
    """
    (step, *_), plain, law = found
    given = "fitted friction" if friction is None else f"friction = {friction:g}"
    if plain is not None and step.windows is not None and step.data is None:
        try:
            return of_flights(found, scale, shared, guess, friction)
        except np.linalg.LinAlgError as error:
            raise SingularError(f"{given}: the fit of flights failed: {error}; {HINT}") from error
    if plain is None or step.data is None or not plain.motions:
        raise SingularError(
            f"{given}: must be left out for a record with the status {step.rhythm.status!r}, from which no "
            "parameters are fitted"
        )
    law = replace(law, friction=True)
    known = dict(shared)
    if friction is None:
        strain = plain.strains.get("friction")
        start = float(np.clip(strain.change if strain else 0.0, 0.0, MOST))
    else:
        known["friction"] = start = friction
    values = {**plain.values, "friction": start}
    data = step.data
    M, K = scale.get("M"), scale.get("K")
    assert step.record is not None
    angles = step.Omega * centred(len(step.record), step.record.rate)
    # with the flights of the first fit, friction is only approximate
    now = fit(
        [data], known, values, plain.lengths, plain.phases, M, K, law, plain.motions, rough=True
    )
    aside: _Array | float = 0.0
    for _ in range(ROUNDS):
        motion = now.motions[0]
        assert motion.at is not None
        response = motion.at(angles)
        change, aside = float(np.std(response - aside)), response
        other = copy(step)
        other.aside, other.known_flights, other.notes = aside, {}, [*step.notes]
        other.data = replace(data, places=np.empty(0))
        flown(other, scale, shared, guess)
        if other.data is None or other.data.sides != data.sides:
            raise SingularError(
                f"{given}: the impacts found in the record depend on whether its effect is included; {HINT}"
            )
        own = away_from(motion, other.data)
        own = replace(own, values=own.values + motion.at(own.places))
        other.data = own
        last = change < SETTLED * float(np.median(own.errors))
        now = fit(
            [own], known, now.values, now.lengths, now.phases, M, K, law, nearest(now.motions, own), rough=not last
        )  # fmt: skip
        if last and "friction" in now.undetermined:
            raise SingularError(UNDETERMINED)
        if last:
            return [other], now, law
    raise SingularError(f"{given}: the fit did not converge in {ROUNDS} rounds; {HINT}")


def of_flights(
    found: tuple[list[Step], Fit | None, Law], scale: Mapping[str, float], shared: Mapping[str, float],
    guess: Mapping[str, float], friction: float | None,
) -> tuple[list[Step], Fit, Law]:  # fmt: skip
    """The fit to the single flights of a record that is not periodic, as `with_friction`.

    In each round the response to the slip of the previous round is subtracted from the record. Flights whose slip
    is unknown are left out.
    """
    (step, *_), now, law = found
    windows = step.windows
    assert now is not None
    assert windows is not None
    given = "fitted friction" if friction is None else f"friction = {friction:g}"
    law, known, static = replace(law, friction=True), dict(shared), now.lengths[0]
    values, slips = {**now.values, "gain": now.gain}, now.slips
    if slips is None:
        values, slips = start_of_friction(windows, shared, guess, law, 0.0)
    else:
        strain = now.strains.get("friction")
        values["friction"] = strain.change if strain else 0.0
    here = float(np.clip(values["friction"], 0.0, MOST))
    if friction is not None:
        known["friction"] = here = friction
    other = copy(step)
    other.notes = [note for note in step.notes if not note.startswith(APART)]
    searches = 0
    for i in range(ROUNDS):
        rough = searches < SEARCHES
        if rough:
            # the friction that remains because of a wrong slip would look like impacts
            rubbed = here, slips, static
            flights = flown_apart(other, scale, shared, guess, rubbed, complete=searches > 0)
        windows = other.windows
        assert windows is not None
        # a fit may have left flights out of the windows after these flights
        slips = slips_of(windows, flights, flights.states, flights.common, values, here)
        static = float(flights.common[2])
        windows.rub(here, slips, static, same=not rough)
        times = flights.times
        middle = 0.5 * (np.append(windows.t[0], times) + np.append(times, windows.t[-1]))
        unknown = slips.sign(middle) == 0
        flights = windows.without(windows.poor | unknown)
        before, poor = values, windows.poor
        try:
            now, law, lawful = by_laws(windows, flights, known, guess, law, None, rough)
        except (SingularError, np.linalg.LinAlgError):
            if not rough or i == ROUNDS - 1:
                raise
            # the fit may have failed because it left out too many
            windows.poor = poor
            values, slips = start_of_friction(windows, shared, guess, law, here)
            if friction is None:
                here = float(np.clip(values["friction"], 0.0, MOST))
            continue
        searches += 1
        values = {**now.values, "gain": now.gain}
        errors = dict(zip(now.names, np.sqrt(np.diag(now.covariance)).tolist(), strict=True))
        if friction is None:
            if "friction" in now.undetermined and not rough:
                raise SingularError(UNDETERMINED)
            strain = now.strains.pop("friction", Strain(0.0, 0.0))
            if here == 0 and strain.size < -BEYOND and not rough:
                raise SingularError(
                    f"{given}: momentum and restitution at {int(lawful.sum())} impacts give "
                    f"{strain.change:.4g} F0: must be at least 0; {HINT}"
                )
            values["friction"] = here = max(here + strain.change, 0.0)
        moves = (
            abs(values[name] - before.get(name, math.inf)) / error
            for name, error in errors.items()
            if name in values and name not in now.undetermined
        )
        moved = max(moves, default=0.0)
        if not rough and moved < MOVED:
            reversing = np.unique(np.searchsorted(flights.times, slips.turns)).size
            others = (
                "is too short, hides an impact, has an unknown slip, or is one of "
                f"{reversing} in which the slip reverses or friction sticks"
            )
            other.notes.append(lawful_of(lawful, others))
            return [other], now, law
    raise SingularError(f"{given}: the fit did not converge in {ROUNDS} rounds; {HINT}")


def nearest(motions: list[Impacting], data: Measured) -> list[Impacting]:
    """The motions with angles near those of flights."""
    turn = 2 * math.pi * round(float(np.mean(data.angles - motions[0].angles)) / (2 * math.pi))
    return [one._replace(angles=one.angles + turn) for one in motions]


def away_from(motion: Impacting, data: Measured) -> Measured:
    """The data without the places about reversals of the slip, where a filter smooths the step of the force."""
    whole, width = 2 * math.pi * data.k, SMOOTHED * data.Omega
    off = (data.places[:, None] - motion.turns + whole / 2) % whole - whole / 2
    kept = abs(off).min(axis=1, initial=math.inf) > width
    if kept.all():
        return data
    beside = np.linalg.qr(data.beside[kept])[0]
    return replace(
        data,
        places=data.places[kept],
        values=data.values[kept],
        errors=data.errors[kept],
        beside=beside,
    )
