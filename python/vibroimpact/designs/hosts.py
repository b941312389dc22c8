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
from ..motions.exact import exact_structure
from ..motions.trajectory import Trajectory, simulate_structure
from ..results import door
from ..studies.decay import decay
from ..systems.oscillator import Oscillator
from ..systems.record import Record
from ..systems.structure import Load, Structure
from .problem import Outcome, parameters_of

_Array = NDArray[np.float64]
#: Number of samples in a load cycle from which extremes are refined, and smallest number of samples of a record.
SAMPLES, LEAST = 200, 5_000
#: Figures of a structure that can be limited or minimised.
FIGURES = ("displacement", "rms", "speed", "acceleration", "force", "multiplier", "least_speed")
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
        Largest allowed values of `FIGURES`: the force is that of springs and dashpots on the coordinate, and the
        multiplier is the largest modulus for the motion that is reached. The least speed is a smallest allowed
        value.
    settling, keep : int
        Load cycles before the evaluated ones, and evaluated load cycles; a record is evaluated as a whole.
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
        """The figures of the coordinate, and the greatest approach speed."""
        n = structure.coordinates
        if isinstance(force, Record):
            run = simulate_structure(structure, force)
            begin, many = run.start, max(LEAST, 10 * len(force.force))
        else:
            # velocities in proportion to the response without gaps, in directions that `place` decides
            scale = force.frequency * abs(steady(structure, force))
            turn = np.cos(np.pi * np.arange(1, n + 1) * (1 + place[np.arange(n) % 4]))
            run = simulate_structure(
                structure,
                force,
                cycles=self.settling + self.keep,
                state=(np.zeros(n), scale * turn),
            )
            begin, many = run.end - self.keep * 2 * math.pi / force.frequency, SAMPLES * self.keep
        if not run.complete:
            return dict.fromkeys(FIGURES, math.inf)
        least, greatest, rms = extent(run, begin, many, self.coordinate)
        late = run.events[run.events["time"] >= begin]
        figures = {
            "displacement": max(-least, greatest), "rms": rms, "speed": float(late["speed"].max(initial=0.0)),
        }  # fmt: skip
        hits = late[late["kind"] == "impact"]
        figures["least_speed"] = (
            float(hits["speed"].min(initial=math.inf)) if len(hits) == len(late) else 0.0
        )
        asked = {self.target, *self.limits}
        if "acceleration" in asked and isinstance(self.coordinate, str):
            figures["acceleration"] = greatest_acceleration(run, begin, many, self.coordinate)
        elif asked & {"acceleration", "force"}:
            found = run.quantities(window=(begin, run.end))
            for name, signal in {"acceleration": found.q_ddot, "force": found.transmitted}.items():
                figures[name] = float(np.atleast_1d(signal.peak)[self.coordinate])
        if "multiplier" in asked:
            figures["multiplier"] = self._multiplier(run) if len(late) else 0.0
        return figures

    def _multiplier(self, run: Trajectory) -> float:
        """The largest modulus of the multipliers of the motion that a simulation reached; inf if there is none."""
        if not isinstance(run.load, Load):
            raise ParameterError(
                "limits: multiplier: must be left out for a record, which has no period"
            )
        try:
            return float(np.abs(exact_structure(run.structure, run.load, run).multipliers[0]))
        except (SingularError, ParameterError):
            return math.inf


@dataclass(frozen=True)
class DecayHost:
    """The oscillator in free vibration; its band is that of initial displacements, and its target -damping.

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
        return Outcome(target, np.zeros(len(r)))

    def slopes(
        self, values: Mapping[str, float], r: float, load: float, place: _Array
    ) -> dict[str, float] | None:
        """A free decay is not a periodic motion."""
        return None


def steady(structure: Structure, load: Load) -> NDArray[np.complex128]:
    """Complex amplitudes (n,) of the fundamental without gaps; 0 at an undamped resonance of the structure."""
    omega = load.frequency
    matrix = structure.stiffness - omega**2 * structure.mass + 1j * omega * structure.damping
    try:
        found = np.linalg.solve(matrix, load.cosine[0] - 1j * load.sine[0])
    except np.linalg.LinAlgError:
        found = np.zeros(structure.coordinates, complex)
    return np.asarray(found)


def greatest_acceleration(run: Trajectory, begin: float, many: int, output: str) -> float:
    """The greatest acceleration of an output from a given time to the end, at samples and on both sides of each
    event."""
    times = run.events["time"][(run.events["time"] > begin) & (run.events["time"] < run.end)]
    times = np.union1d(np.linspace(begin, run.end, many + 1), [*times, *np.nextafter(times, begin)])
    return float(np.abs(run._sampled(times, 3, output)[2]).max())


def extent(
    run: Trajectory, begin: float, many: int, coordinate: int | str
) -> tuple[float, float, float]:
    """Least and greatest value, and root mean square, of a coordinate or output from a given time to the end.

    An extreme between two samples is computed from the cubic through their values and velocities, with an error
    proportional to the fourth power of their distance.
    """
    times = np.linspace(begin, run.end, many + 1)
    inside = run.events["time"][(run.events["time"] > begin) & (run.events["time"] < run.end)]
    times = np.union1d(times, inside)
    if isinstance(coordinate, str):
        q, rate = run.sample(times, coordinate)
    else:
        q, rate = (each[coordinate] for each in run.sample(times))
    h = np.diff(times)
    at = np.flatnonzero(rate[:-1] * rate[1:] < 0)
    a, b, step = q[at], q[at + 1], h[at]
    u, v = rate[at] * step, rate[at + 1] * step
    # the derivative of the cubic is u + 2 c2 s + 3 c3 s^2
    c2, c3 = 3 * (b - a) - 2 * u - v, 2 * (a - b) + u + v
    root = np.sqrt(np.maximum(c2**2 - 3 * c3 * u, 0))
    s = -u / (c2 + np.where(c2 < 0, -root, root))
    s = np.clip(np.where(np.isfinite(s), s, 0.0), 0, 1)
    tips = a + s * (u + s * (c2 + s * c3))
    everything = np.append(q, tips)
    # Simpson's rule with the cubic's middle
    middle = 0.5 * (q[:-1] + q[1:]) + 0.125 * h * (rate[:-1] - rate[1:])
    square = np.sum(h * (q[:-1] ** 2 + 4 * middle**2 + q[1:] ** 2)) / 6
    return float(everything.min()), float(everything.max()), math.sqrt(square / (run.end - begin))
