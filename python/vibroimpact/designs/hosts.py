"""Hosts of a design other than the oscillator under a load: structures, and free decay."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..base.errors import ParameterError, ParameterTypeError, SingularError
from ..motions.reached import reached_figures, steady
from ..results import door
from ..studies.decay import decay
from ..systems.oscillator import Oscillator
from ..systems.record import Record
from ..systems.structure import Load, Structure
from .problem import Outcome, parameters_of

_Array = NDArray[np.float64]
TARGETS = ("attenuation", "displacement", "rms", "acceleration", "force")


@dataclass(frozen=True)
class StructureHost:
    """A structure built from the parameters by a function of the caller.

    Attributes
    ----------
    build : callable
        ``build(r=frequency, load=amplitude, **parameters)`` returns a Structure and its Load or Record.
    coordinate : int or str
        The coordinate, or the output of the structure, whose motion counts.
    target : str
        One of `TARGETS`; the attenuation is the greatest displacement over that of the structure without gaps.
    limits : mapping
        Largest allowed figures, named as in `reached_figures`; for the least speed, the smallest allowed value.
    settling, keep : int
        Load cycles simulated before the evaluation, and load cycles evaluated; a record is evaluated as a whole.
    threads : int or None
    """

    build: Callable[..., tuple[Structure, Load | Record]]
    coordinate: int | str
    target: str
    limits: Mapping[str, float]
    settling: int
    keep: int
    threads: int | None

    def outcome(
        self, values: Mapping[str, _Array], r: _Array, load: _Array, places: _Array,
        progress: door.Progress | None, note: str,
    ) -> Outcome:  # fmt: skip
        """As for all hosts."""

        def one(i: int) -> tuple[float, float]:
            return self._one(
                {name: each[i].item() for name, each in values.items()}, r[i], load[i], places[:, i]
            )

        found = np.empty((len(r), 2))
        with ThreadPoolExecutor(self.threads or os.cpu_count()) as pool:
            for i, pair in enumerate(pool.map(one, range(len(r)))):
                found[i] = pair
                if progress is not None:
                    progress((i + 1) / len(r), note)
        return Outcome(found[:, 0], found[:, 1])

    def slopes(
        self, values: Mapping[str, float], r: float, load: float, place: _Array
    ) -> dict[str, float] | None:
        """A structure from a function has no derivatives."""
        return None

    def _one(
        self, values: Mapping[str, float], r: float, load: float, place: _Array
    ) -> tuple[float, float]:
        """Target and excess of one unit."""
        structure, force = self._built(values, r, load)
        try:
            figures = self._figures(structure, force, place)
        except (
            SingularError
        ):  # a failure, such as coupled gaps that close at one instant, counts as bad
            return math.inf, math.inf
        if math.isinf(figures["displacement"]):  # a simulation that was cut short
            return math.inf, math.inf
        if self.target == "attenuation":
            free = Structure(
                structure.mass, structure.damping, structure.stiffness, outputs=structure.outputs
            )
            target = figures["displacement"] / self._figures(free, force, 0 * place)["displacement"]
        else:
            target = figures[self.target]
        least = figures.get("least_speed", math.inf)
        over = [
            (limit / least if least > 0 else math.inf)
            if name == "least_speed"
            else figures[name] / limit
            for name, limit in self.limits.items()
        ]
        return target, max([0.0, *over])

    def _built(
        self, values: Mapping[str, float], r: float, load: float
    ) -> tuple[Structure, Load | Record]:
        built = self.build(r=float(r), load=float(load), **values)
        wanted = "a function that returns a Structure and its Load or Record"
        if not (isinstance(built, tuple) and len(built) == 2 and isinstance(built[0], Structure)):
            raise ParameterTypeError(f"host returned {built!r}: must be {wanted}")
        structure, force = built
        if not isinstance(force, (Load, Record)) or (
            isinstance(force, Load) and not force.frequency
        ):
            raise ParameterTypeError(
                f"host returned the load {force!r}: must be {wanted}, which has a frequency"
            )
        if isinstance(self.coordinate, str):
            if self.coordinate not in structure.outputs:
                names = "".join(f", or the output {name!r}" for name in structure.outputs)
                raise ParameterError(
                    f"coordinate = {self.coordinate!r}: must be 0 to {structure.coordinates - 1}{names} for this "
                    "structure"
                )
            if "force" in {self.target, *self.limits}:
                raise ParameterError(
                    f"coordinate = {self.coordinate!r}: must be the number of a coordinate for a force"
                )
        elif not self.coordinate < structure.coordinates:
            raise ParameterError(
                f"coordinate = {self.coordinate}: must be 0 to {structure.coordinates - 1} for this structure"
            )
        return structure, force

    def _figures(
        self, structure: Structure, force: Load | Record, place: _Array
    ) -> dict[str, float]:
        """The figures of the coordinate, with initial velocities in proportion to the response without gaps, in
        directions that `place` decides."""
        state: tuple[_Array, _Array] | None = None
        if isinstance(force, Load):
            n = structure.coordinates
            scale: _Array = force.frequency * np.abs(steady(structure, force)).astype(np.float64)
            turn = np.cos(np.pi * np.arange(1, n + 1) * (1 + place[np.arange(n) % 4]))
            state = np.zeros(n), scale * turn
        asked = {self.target, *self.limits}
        return reached_figures(
            structure, force, state, asked, self.coordinate, self.settling, self.keep
        )


@dataclass(frozen=True)
class DecayHost:
    """The oscillator in free vibration; the band consists of initial displacements, and the target is -damping.

    Attributes
    ----------
    osc, clearance : Oscillator, float or None
        As for `OscillatorHost`; the unit of length is arbitrary.
    cycles : int
        Cycles over which the damping ratio is averaged.
    threads : int or None
    """

    osc: Oscillator
    clearance: float | None
    cycles: int
    threads: int | None

    def outcome(
        self, values: Mapping[str, _Array], r: _Array, load: _Array, places: _Array,
        progress: door.Progress | None, note: str,
    ) -> Outcome:  # fmt: skip
        """As for all hosts; r are the initial displacements."""
        parameters = parameters_of(self.osc, self.clearance, values, r, np.ones(r.shape))

        def one(i: int) -> float:
            _, clearance, xi, mu, right, left = parameters[:, i].tolist()
            osc = Oscillator(xi=xi, mu=mu, restitution=(right, left))
            y = 0.499 * clearance * places[2, i]
            found = decay(
                osc, clearance, amplitude=float(r[i]), y=float(y), cycles=self.cycles, threads=1
            )
            if found.status[0] != 0 or found.x.size <= 2 * self.cycles:
                return math.inf
            decrement = math.log(found.x[0] / found.x[2 * self.cycles]) / self.cycles
            return -decrement / math.hypot(2 * math.pi, decrement)

        with ThreadPoolExecutor(self.threads or os.cpu_count()) as pool:
            target = np.fromiter(pool.map(one, range(len(r))), float, len(r))
        if progress is not None:
            progress(1.0, note)
        return Outcome(target, np.where(np.isfinite(target), 0.0, math.inf))

    def slopes(
        self, values: Mapping[str, float], r: float, load: float, place: _Array
    ) -> dict[str, float] | None:
        """A free decay is not a periodic motion."""
        return None
