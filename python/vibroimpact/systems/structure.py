"""Linear structures with gaps, elastic stops and dry friction, and their loads."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base import checks
from ..base.errors import ParameterError, ParameterTypeError, SingularError
from ..base.status import DEFECTIVE, raise_status, sentence
from .restitution import KINDS, ByValue, Law, Restitution, checked, numbers_of, to_columns
from .units import Units, number_of

__all__ = ["Friction", "Gap", "Load", "Stop", "Structure"]

_Array = NDArray[np.float64]
#: Largest number of coordinates of a structure, and of gaps.
MOST = 500
#: Largest modulus of an entry of a matrix; of a frequency, a damping ratio, a mode shape or a direction.
LARGEST, LARGEST_MODAL = 1e100, 1e40
MOST_OUTPUTS = 100
#: The laws for coupled gaps that close at one instant, as the core numbers them.
SIMULTANEOUS = (None, "newton", "sequence")
#: Largest number of harmonics of the motion of a wall.
MOST_HARMONICS = 100
#: The functions that accept stops and friction.
WITH_ELEMENTS = (
    "simulate, periodic, exact, find, branch, zone, chart, atlas, response, bifurcation_diagram,"
    " lyapunov, basins and decay"
)


def _numbers(values: Any, name: str, wanted: str, shape: tuple[int, ...]) -> _Array:
    """A read-only array of finite numbers of a given shape; -1 allows any length."""
    array = np.array(checks.real_array(values, name, wanted), dtype=np.float64)
    if array.ndim != len(shape) or any(
        n not in (-1, m) for n, m in zip(shape, array.shape, strict=True)
    ):
        raise ParameterError(f"{name} of shape {array.shape}: must be {wanted}")
    if not np.isfinite(array).all():
        raise ParameterError(f"{name}: must be {wanted}, all of them finite")
    array.flags.writeable = False
    return array


def counted(many: int, noun: str) -> str:
    """A number of things, with the plural."""
    return f"{many} {noun}{'s' * (many != 1)}"


def _checked_direction(direction: ArrayLike) -> _Array:
    """The direction of a gap, a stop or friction, checked."""
    wanted = "numbers from -1e40 to 1e40, one per coordinate, not all 0"
    array = _numbers(direction, "direction", wanted, (-1,))
    if not array.any() or (np.abs(array) > LARGEST_MODAL).any():
        raise ParameterError(f"direction = {checks.shown(array.tolist())}: must be {wanted}")
    return array


def _wall(cosine: ArrayLike | None, sine: ArrayLike | None) -> tuple[_Array, _Array]:
    """The amplitudes of the motion of a wall, checked, with equal numbers of cosines and sines."""
    wanted = f"at most {MOST_HARMONICS} numbers from -1e100 to 1e100"
    parts = []
    for name, values in {"cosine": cosine, "sine": sine}.items():
        given = np.zeros(0) if values is None else checks.real_array(values, name, wanted)
        array = _numbers(np.atleast_1d(given), name, wanted, (-1,))
        if len(array) > MOST_HARMONICS or (np.abs(array) > LARGEST).any():
            raise ParameterError(f"{name} = {checks.shown(array.tolist())}: must be {wanted}")
        parts.append(array)
    most = max(map(len, parts))
    whole = [np.pad(array, (0, most - len(array))) for array in parts]
    for array in whole:
        array.flags.writeable = False
    return whole[0], whole[1]


def _place(direction: ArrayLike, opening: float) -> tuple[_Array, float]:
    """The direction and the opening of a gap or a stop, checked."""
    array = _checked_direction(direction)
    opening = checks.to_float(opening, "opening", "a finite number")
    if not np.isfinite(opening):
        raise ParameterError(f"opening = {opening!r}: must be a finite number")
    return array, opening


@dataclass(frozen=True, eq=False, repr=False)
class Gap(ByValue):
    """A gap that opens and closes: opening - direction.q >= 0.

    Its wall may move at the load frequency Omega; the opening is then opening + the sum of cosine_h cos(h Omega t)
    + sine_h sin(h Omega t).

    Parameters
    ----------
    direction : array_like (n,)
        The direction in the coordinates that closes the gap, such as ``[-1, 1]`` for a stop of body 1 to the right
        of body 2.
    opening : float
        Opening at q = 0; negative if the gap is closed there.
    restitution : float, PowerLaw or TabulatedRestitution
        Coefficient of restitution, 0 to 1, or a law as a function of the approach speed.
    cosine, sine : float or array_like (H,), optional
        Amplitudes of the harmonics 1 to H of the opening.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not as described.

    Examples
    --------
    A ball under gravity on a vibrating table; upwards is positive, and the table moves by 0.1 sin(20 t):

    >>> import vibroimpact as vi
    >>> table = vi.Gap([-1], 0.0, restitution=0.7, sine=0.1)
    >>> ball = vi.Structure(mass=[1], damping=[0], stiffness=[0], gaps=[table])
    >>> run = vi.simulate(ball, vi.Load(20.0, constant=[-9.81]), cycles=50, state=([0.5], [0]))
    >>> bool(run.states[0, 0, 0] > -0.1)
    True
    """

    direction: _Array
    opening: float
    restitution: Restitution = 1.0
    cosine: _Array = field(default_factory=lambda: np.zeros(0))
    sine: _Array = field(default_factory=lambda: np.zeros(0))

    def __init__(
        self, direction: ArrayLike, opening: float, restitution: Restitution = 1.0,
        cosine: ArrayLike | None = None, sine: ArrayLike | None = None,
    ) -> None:  # fmt: skip
        direction, opening = _place(direction, opening)
        wall = _wall(cosine, sine)
        object.__setattr__(self, "cosine", wall[0])
        object.__setattr__(self, "sine", wall[1])
        object.__setattr__(self, "direction", direction)
        object.__setattr__(self, "opening", opening)
        object.__setattr__(self, "restitution", checked(restitution))

    def _law(self) -> list[float]:
        """Kind and numbers of its law, for the core."""
        return numbers_of(self.restitution)

    def _group(self) -> tuple[str, dict[str, Any]]:
        """The group of a namelist that describes it."""
        place = {"direction": self.direction.tolist(), "opening": self.opening}
        return "gap", place | _motion_of(self) | to_columns(self.restitution)

    def __repr__(self) -> str:
        r = self.restitution
        law = f"{r!r}" if isinstance(r, Law) else f"{r:g}"
        shown = [f"restitution={law}", *(f"{k}={v}" for k, v in _motion_of(self).items())]
        return f"Gap({self.direction.tolist()}, {self.opening:g}, {', '.join(shown)})"


@dataclass(frozen=True, eq=False, repr=False)
class Stop(ByValue):
    """An elastic stop: a spring and a dashpot that push back once the gap has closed.

    At a penetration depth d = direction.q - opening > 0, the force preload + stiffness d + damping d' acts against
    `direction`.

    Parameters
    ----------
    direction : array_like (n,)
        The direction in the coordinates that compresses the stop, as in `Gap`.
    opening : float
        Opening at q = 0; negative if the stop is compressed there.
    stiffness, damping, preload : float
        Each at least 0, and at least one above 0. With a preload, the force jumps when contact begins.
    release : "gap" or "force"
        When contact ends. "gap": when d returns to 0; a dashpot may pull just before. "force": the force is never
        below 0, so contact ends when the force vanishes; it begins again when the force rises, even at a depth
        d > 0.
    cosine, sine : float or array_like (H,), optional
        Amplitudes of the harmonics of the opening, as for a `Gap`.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not as described.

    Examples
    --------
    A mass on a spring that hits a stop a hundred times as stiff as its spring:

    >>> import vibroimpact as vi
    >>> stop = vi.Stop([1], 0.0, stiffness=1e6)
    >>> mass = vi.Structure(mass=[100], damping=[0], stiffness=[1e4], gaps=[stop])
    >>> run = vi.simulate(mass, duration=0.1, state=([0], [1]))
    >>> run.events["kind"].tolist(), run.events["time"].round(8).tolist()
    (['touch', 'leave'], [0.0, 0.03126002])
    """

    direction: _Array
    opening: float
    stiffness: float
    damping: float = 0.0
    preload: float = 0.0
    release: Literal["gap", "force"] = "gap"
    cosine: _Array = field(default_factory=lambda: np.zeros(0))
    sine: _Array = field(default_factory=lambda: np.zeros(0))

    def __init__(
        self, direction: ArrayLike, opening: float, stiffness: float, damping: float = 0.0, preload: float = 0.0,
        release: Literal["gap", "force"] = "gap", cosine: ArrayLike | None = None, sine: ArrayLike | None = None,
    ) -> None:  # fmt: skip
        direction, opening = _place(direction, opening)
        wall = _wall(cosine, sine)
        object.__setattr__(self, "cosine", wall[0])
        object.__setattr__(self, "sine", wall[1])
        object.__setattr__(self, "direction", direction)
        object.__setattr__(self, "opening", opening)
        wanted = "a number from 0 to 1e100"
        given = {"stiffness": stiffness, "damping": damping, "preload": preload}
        for name, value in given.items():
            number = checks.to_float(value, name, wanted)
            if not 0 <= number <= LARGEST:
                raise ParameterError(f"{name} = {number!r}: must be {wanted}")
            object.__setattr__(self, name, number)
        if not self.stiffness + self.damping + self.preload > 0:
            raise ParameterError(
                f"stiffness = {self.stiffness!r}: must be above 0 unless damping or preload is"
            )
        if release not in ("gap", "force"):
            raise ParameterError(f"release = {release!r}: must be 'gap' or 'force'")
        object.__setattr__(self, "release", release)

    def _law(self) -> list[float]:
        """Kind and numbers of its law, for the core."""
        kind = KINDS.index("stop" if self.release == "gap" else "pushing")
        return [float(kind), self.stiffness, self.damping, self.preload]

    def _group(self) -> tuple[str, dict[str, Any]]:
        """The group of a namelist that describes it."""
        return "stop", {
            "direction": self.direction.tolist(), "opening": self.opening, "stiffness": self.stiffness,
            "damping": self.damping, "preload": self.preload, "release": self.release, **_motion_of(self),
        }  # fmt: skip

    def __repr__(self) -> str:
        further = {"damping": self.damping, "preload": self.preload}
        shown = [f"{name}={value:g}" for name, value in further.items() if value]
        shown += ["release='force'"] if self.release == "force" else []
        shown += [f"{name}={values}" for name, values in _motion_of(self).items()]
        place = f"{self.direction.tolist()}, {self.opening:g}, stiffness={self.stiffness:g}"
        return f"Stop({', '.join([place, *shown])})"


def _motion_of(part: Gap | Stop | Friction) -> dict[str, list[float]]:
    """The keys of the motion of a wall, if it moves."""
    if isinstance(part, Friction):
        return {}
    parts = {"cosine": part.cosine, "sine": part.sine}
    return {name: values.tolist() for name, values in parts.items() if values.any()}


def moves(part: Gap | Stop) -> bool:
    """Whether the wall of a gap or stop moves."""
    return bool(part.cosine.any() or part.sine.any())


def opening_at(part: Gap | Stop, t: Any, frequency: float) -> Any:
    """The opening at q = 0 at given times; it varies if the wall moves."""
    angles = np.multiply.outer(np.asarray(t), frequency * np.arange(1, len(part.cosine) + 1))
    return part.opening + np.cos(angles) @ part.cosine + np.sin(angles) @ part.sine


def opening_speed_at(part: Gap | Stop, t: Any, frequency: float) -> Any:
    """The time derivative of `opening_at`."""
    paces = frequency * np.arange(1, len(part.cosine) + 1)
    angles = np.multiply.outer(np.asarray(t), paces)
    return np.cos(angles) @ (paces * part.sine) - np.sin(angles) @ (paces * part.cosine)


@dataclass(frozen=True, eq=False, repr=False)
class Friction(ByValue):
    """Dry friction along a direction, with a constant normal force.

    With s = direction.q' - speed, the force `slip` acts against s while the contact slips (s != 0). While the
    contact sticks (s = 0), a force of at most `stick` holds it.

    Parameters
    ----------
    direction : array_like (n,)
        The direction in the coordinates along which friction acts, such as ``[-1, 1]`` for friction between bodies
        1 and 2.
    slip : float
        Force while slipping, at least 0: the coefficient of friction times the normal force.
    stick : float, optional
        Largest force while sticking, at least `slip`; by default equal to `slip`.
    speed : float
        Belt speed.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not as described.

    Examples
    --------
    A mass on a spring that slides to rest:

    >>> import vibroimpact as vi
    >>> mass = vi.Structure(mass=[1], damping=[0], stiffness=[1e4], friction=[vi.Friction([1], slip=1)])
    >>> run = vi.simulate(mass, duration=1, state=([0.85e-3], [0]))
    >>> run.events["kind"].tolist()
    ['slip_up', 'slip_down', 'slip_up', 'halt']
    >>> (1e3 * run.states[:, 0, 0]).round(2).tolist()
    [-0.65, 0.45, -0.25, 0.05]
    """

    direction: _Array
    slip: float
    stick: float
    speed: float = 0.0

    def __init__(
        self, direction: ArrayLike, slip: float, stick: float | None = None, speed: float = 0.0
    ) -> None:
        object.__setattr__(self, "direction", _checked_direction(direction))
        slip = checks.to_float(slip, "slip", "a number from 0 to 1e100")
        if not 0 <= slip <= LARGEST:
            raise ParameterError(f"slip = {slip!r}: must be a number from 0 to 1e100")
        wanted = f"a number from slip = {slip!r} to 1e100"
        stick = slip if stick is None else checks.to_float(stick, "stick", wanted)
        if not slip <= stick <= LARGEST:
            raise ParameterError(f"stick = {stick!r}: must be {wanted}")
        speed = checks.to_float(speed, "speed", "a number from -1e100 to 1e100")
        if not abs(speed) <= LARGEST:
            raise ParameterError(f"speed = {speed!r}: must be a number from -1e100 to 1e100")
        for name, value in {"slip": slip, "stick": stick, "speed": speed}.items():
            object.__setattr__(self, name, value)

    def _law(self) -> list[float]:
        """Kind and numbers of its law, for the core."""
        return [float(KINDS.index("friction")), self.slip, self.stick, self.speed]

    def _group(self) -> tuple[str, dict[str, Any]]:
        """The group of a namelist that describes it."""
        names = ("slip", "stick", "speed")
        return "friction", {"direction": self.direction.tolist()} | {
            name: getattr(self, name) for name in names
        }

    def __repr__(self) -> str:
        shown = [f"stick={self.stick:g}"] if self.stick != self.slip else []
        shown += [f"speed={self.speed:g}"] if self.speed else []
        return f"Friction({', '.join([f'{self.direction.tolist()}, {self.slip:g}', *shown])})"


#: Columns of results, which cannot be names of outputs.
RESERVED = ("time", "kind", "gap", "phase", "speed", "impulse")


class Outputs(Mapping[str, _Array]):
    """Linear combinations of the coordinates by name, as read-only rows of coefficients."""

    def __init__(self, given: Any, coordinates: int) -> None:
        if not isinstance(given, Mapping):
            raise ParameterTypeError(
                f"outputs = {given!r}: must map names to rows, such as {{'tip': [1, 0]}}"
            )
        wanted = f"{coordinates} numbers from -1e40 to 1e40, one per coordinate"
        self._rows: dict[str, _Array] = {}
        for name, values in given.items():
            good = isinstance(name, str) and re.fullmatch(r"(?a:[a-z]\w{0,22})", name, re.I)
            if not good or name.startswith("q_") or name.endswith("_dot") or name in RESERVED:
                raise ParameterError(
                    f"outputs: name {name!r}: must have at most 23 letters, digits and _, begin with a letter, "
                    f"and be none of {', '.join(RESERVED)}, q_..., ..._dot, which are columns of results"
                )
            row = _numbers(values, f"outputs[{name!r}]", wanted, (coordinates,))
            if (np.abs(row) > LARGEST_MODAL).any():
                raise ParameterError(f"outputs[{name!r}] = {row.tolist()!r}: must be {wanted}")
            self._rows[name] = row
        if len(self._rows) > MOST_OUTPUTS:
            raise ParameterError(f"outputs: {len(self)} of them; must be at most {MOST_OUTPUTS}")

    def __getitem__(self, name: str) -> _Array:
        return self._rows[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._rows)

    def __len__(self) -> int:
        return len(self._rows)

    def _values(self) -> tuple[Any, ...]:
        """Names and numbers."""
        return tuple((name, (row + 0.0).tobytes()) for name, row in self._rows.items())

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Outputs) and self._values() == other._values()

    def __hash__(self) -> int:
        return hash(self._values())

    def __repr__(self) -> str:
        return repr({name: row.tolist() for name, row in self._rows.items()})


@dataclass(frozen=True, eq=False, repr=False)
class Structure(ByValue):
    """A linear structure M q'' + C q' + K q = f with gaps, elastic stops and dry friction.

    All bodies are treated alike, free masses included: a mass between two walls of another body is a coordinate
    without stiffness and two gaps. Any consistent units may be used.

    Parameters
    ----------
    mass, damping, stiffness : array_like (n, n)
        Symmetric matrices M (positive definite), C and K (positive semidefinite), of numbers from -1e100 to 1e100.
        A vector (n,) is taken as a diagonal.
    gaps : sequence of Gap or Stop
        Rigid walls and elastic stops, numbered from 0 in this order.
    friction : sequence of Friction
        Friction contacts, numbered after all gaps and stops. All studies of motions accept stops and friction, as
        do `gradient` and `quantities`.
    outputs : mapping of str to array_like (n,), optional
        Displacements of interest by name, each as a row of coefficients of the coordinates. Trajectories and
        motions can be sampled at outputs; responses, bifurcation diagrams, plots and CSV files show them by name.
    base : array_like (n,), optional
        Displacement of each coordinate when the base moves by 1 and nothing is deformed: the direction of
        `base_motion` and `base_record`.
    simultaneous : "newton", "sequence" or None
        What happens when coupled gaps (an impulse at one changes the speed of another) close at the same instant,
        or when a gap closes while one coupled with it rests. None: a SingularError. "sequence": one impact after
        another, always at the gap that is closing fastest, until none is closing. "newton": simultaneous impulses
        >= 0 at all closed gaps, after which none is closing and the gaps with an impulse separate at R times the
        approach speed; see the how-to on structures.

    Attributes
    ----------
    participation : ndarray (n,)
        Participation factors: the inertia forces on the coordinates per unit of base acceleration, with the
        opposite sign; M times `base`. Raises an AttributeError if no `base` was given.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed.

    Examples
    --------
    A mass on a spring that carries a free mass between two walls:

    >>> import vibroimpact as vi
    >>> gaps = [vi.Gap([-1, 1], 0.5, 0.8), vi.Gap([1, -1], 0.5, 0.8)]
    >>> vi.Structure(mass=[1, 0.1], damping=[0.02, 0], stiffness=[1, 0], gaps=gaps)
    <Structure of 2 coordinates with 2 gaps>

    The extension of a spring between two masses, as an output of a motion that starts from rest:

    >>> two = vi.Structure([1, 1], [0, 0], [[2, -1], [-1, 1]], outputs={"extension": [-1, 1]})
    >>> run = vi.simulate(two, vi.Load(1.0, sine=[0, 0.1]), duration=5)
    >>> q, q_dot = run.sample([1.0, 2.0])
    >>> bool((run.sample([1.0, 2.0], "extension")[0] == q[1] - q[0]).all())
    True
    """

    mass: _Array
    damping: _Array
    stiffness: _Array
    gaps: tuple[Gap | Stop, ...] = field(default=())
    friction: tuple[Friction, ...] = field(default=())
    outputs: Mapping[str, _Array] = field(default_factory=dict)
    simultaneous: Literal["newton", "sequence"] | None = None
    _base: _Array | None = field(default=None, compare=False)
    _is_modal: bool = field(default=False, compare=False)
    #: The physical units of a structure that `Oscillator.at` or `Oscillator.structure` made, if they are known.
    _units: Units | None = field(default=None, compare=False)

    def __init__(
        self, mass: ArrayLike, damping: ArrayLike, stiffness: ArrayLike,
        gaps: Sequence[Gap | Stop] = (), friction: Sequence[Friction] = (),
        outputs: Mapping[str, ArrayLike] | None = None, base: ArrayLike | None = None,
        simultaneous: Literal["newton", "sequence"] | None = None,
    ) -> None:  # fmt: skip
        if simultaneous not in SIMULTANEOUS:
            raise ParameterError(
                f"simultaneous = {simultaneous!r}: must be 'newton', 'sequence' or None"
            )
        object.__setattr__(self, "simultaneous", simultaneous)
        matrices = {}
        for name, values in {"mass": mass, "damping": damping, "stiffness": stiffness}.items():
            matrices[name] = _square(values, name)
        n = len(matrices["mass"])
        if not 1 <= n <= MOST:
            raise ParameterError(f"mass of shape {(n, n)}: must be for 1 to {MOST} coordinates")
        masses = np.diag(matrices["mass"])
        # coordinates scaled by the square roots of their masses, so that the checks do not depend on their units
        unit = 1 / np.sqrt(masses) if (masses > 0).all() else np.ones(n)
        for name, matrix in matrices.items():
            if len(matrix) != n:
                raise ParameterError(
                    f"{name} of shape {matrix.shape}: must be ({n}, {n}), the shape of mass"
                )
            object.__setattr__(self, name, _symmetric(matrix, unit, name))
            if ((masses < 1e-40) | (masses > 1e40)).any():
                # a simulation rejects such masses; their factors would overflow
                unit = np.ones(n)
        gaps = _list_of_gaps(gaps)
        friction = _list_of_gaps(friction, "friction", (Friction,))
        for name, parts in {"gaps": gaps, "friction": friction}.items():
            for i, part in enumerate(parts):
                if len(part.direction) != n:
                    raise ParameterError(
                        f"{name}[{i}].direction has {counted(len(part.direction), 'number')}: "
                        f"must have {n}, one per coordinate"
                    )
            object.__setattr__(self, name, parts)
        object.__setattr__(self, "outputs", Outputs({} if outputs is None else outputs, n))
        if base is not None:
            base = _numbers(base, "base", f"{n} finite numbers, one per coordinate", (n,))
        object.__setattr__(self, "_base", base)

    @classmethod
    def from_modes(
        cls,
        frequencies: ArrayLike,
        damping_ratios: ArrayLike,
        shapes: ArrayLike,
        gaps: Sequence[Gap | Stop] = (),
        friction: Sequence[Friction] = (),
        outputs: Mapping[str, ArrayLike] | None = None,
        base: ArrayLike | None = None,
        simultaneous: Literal["newton", "sequence"] | None = None,
    ) -> Structure:
        """A structure given by its modes; the modal amplitudes are the coordinates.

        Define the points of interest as `outputs`, because a modal amplitude is not a displacement.

        Parameters
        ----------
        frequencies : array_like (n,)
            Circular frequencies of the modes; 0 is allowed.
        damping_ratios : array_like (n,)
            Damping ratio of each mode, 1 for critical damping.
        shapes : array_like (points, n)
            Mass-normalised mode shapes at some points.
        gaps : sequence of Gap or Stop
            Their directions refer to the points: `direction` has one number per point.
        friction : sequence of Friction
            Their directions likewise.
        outputs : mapping of str to array_like (n,), optional
            Displacements of interest by name, each given by the mode shapes at its point, such as a row of
            `shapes`.
        base : array_like (points,), optional
            Mass lumped at each of the points, times its rigid-body displacement for a unit displacement of the
            base. The participation factor of each mode is then the sum over the points of this value times its
            shape; it is exact if the points carry the whole mass.
        simultaneous : "newton", "sequence" or None
            As in `Structure`.

        Examples
        --------
        >>> import vibroimpact as vi
        >>> beam = vi.Structure.from_modes([1.0, 6.27], [0.01, 0.01], [[2.0, -2.0]], [vi.Gap([1.0], 0.1, 0.6)])
        >>> beam.gaps[0].direction.tolist()
        [2.0, -2.0]

        A mass of 4 on a spring, with mode shape 1/2, on a base that moves by 0.1 sin(2 t): the load is the inertia
        force, 4 times 2^2 times 0.1, times the shape.

        >>> rig = vi.Structure.from_modes([3.0], [0.01], [[0.5]], outputs={"mass": [0.5]}, base=[4.0])
        >>> rig.participation.tolist(), vi.base_motion(rig, 2.0, sine=0.1, relative=True).sine.tolist()
        ([2.0], [[0.8]])
        """
        wanted = "numbers from 0 to 1e40, one per mode"
        omega = _numbers(frequencies, "frequencies", wanted, (-1,))
        n = len(omega)
        _check_size(omega, "frequencies")
        zeta = _numbers(damping_ratios, "damping_ratios", wanted, (n,))
        for name, values in {"frequencies": omega, "damping_ratios": zeta}.items():
            outside = (values < 0) | (values > LARGEST_MODAL)
            if outside.any():
                i = int(np.argmax(outside))
                raise ParameterError(f"{name}[{i}] = {float(values[i])!r}: must be {wanted}")
        wanted = "an array (points, modes) of numbers from -1e40 to 1e40"
        points = _numbers(shapes, "shapes", wanted, (-1, n))
        if (np.abs(points) > LARGEST_MODAL).any():
            value = float(points.flat[int(np.argmax(np.abs(points)))])
            raise ParameterError(f"shapes with {value!r}: must be {wanted}")
        given = {f"gaps[{i}]": gap for i, gap in enumerate(_list_of_gaps(gaps))}
        for i, part in enumerate(_list_of_gaps(friction, "friction", (Friction,))):
            given[f"friction[{i}]"] = part
        modal = []
        for label, part in given.items():
            if len(part.direction) != len(points):
                raise ParameterError(
                    f"{label}.direction has {counted(len(part.direction), 'number')}: "
                    f"must have {len(points)}, one per point"
                )
            # point by point, as the core does, so that the digits do not depend on a library
            direction = np.zeros(n)
            for factor, shape in zip(part.direction, points, strict=True):
                direction = direction + factor * shape
            if not direction.any() or (np.abs(direction) > LARGEST_MODAL).any():
                raise ParameterError(
                    f"{label}.direction and shapes give {direction.tolist()!r} for the modes: must be "
                    "numbers from -1e40 to 1e40, not all 0"
                )
            modal.append(replace(part, direction=direction))
        rubbing = [part for part in modal if isinstance(part, Friction)]
        closing = [part for part in modal if not isinstance(part, Friction)]
        factors = None
        if base is not None:
            wanted = f"{len(points)} finite numbers, one per point"
            factors = _numbers(base, "base", wanted, (len(points),)) @ points
        found = cls(
            np.eye(n), np.diag(2 * zeta * omega), np.diag(omega**2), closing, rubbing, outputs, factors,
            simultaneous,
        )  # fmt: skip
        object.__setattr__(found, "_is_modal", True)
        return found

    @property
    def participation(self) -> _Array:
        """Participation factors for a motion of the base (n)."""
        if self._base is None:
            raise AttributeError("participation: a Structure without base does not have it")
        factors: _Array = self.mass @ self._base
        return factors

    def _row(self, output: Any) -> _Array:
        """The row of an output."""
        if not isinstance(output, str) or output not in self.outputs:
            known = ", ".join(self.outputs) or "none"
            raise ParameterError(
                f"output = {output!r}: must be the name of an output of the structure, which has {known}"
            )
        return self.outputs[output]

    @property
    def coordinates(self) -> int:
        """Number of coordinates."""
        return len(self.mass)

    def _arrays(self) -> tuple[_Array, _Array, _Array]:
        """Matrices (n, n, 3), directions (n, gaps), and openings with coefficients of restitution.

        The last array is (2, gaps), or with laws (3 or more, gaps): the opening, then the kind and the numbers of
        each law.
        """
        matrices = np.stack([self.mass, self.damping, self.stiffness], axis=-1)
        # f2py refuses arrays with two rows and no column: without gaps, one that never closes is used
        gaps = self._parts or (Gap(np.eye(self.coordinates)[0], 1e300),)
        directions = np.array([gap.direction for gap in gaps]).T
        constant = [gap.restitution for gap in gaps if isinstance(gap, Gap)]
        openings = [0.0 if isinstance(gap, Friction) else gap.opening for gap in gaps]
        law = SIMULTANEOUS.index(self.simultaneous)
        plain = all(isinstance(value, float) for value in constant) and not (self._moves or law)
        if len(constant) == len(gaps) and plain:
            values = np.array([openings, constant])
        else:
            columns = []
            for opening, gap in zip(openings, gaps, strict=True):
                kind, *numbers = gap._law()
                wall = (
                    np.zeros(0)
                    if isinstance(gap, Friction)
                    else np.ravel([gap.cosine, gap.sine], "F")
                )
                kind += 5 * len(wall) + 10000 * law
                columns.append([opening, kind, *wall.tolist(), *numbers])
            values = np.zeros((max(map(len, columns)), len(gaps)))
            for j, column in enumerate(columns):
                values[: len(column), j] = column
        return np.asfortranarray(matrices), np.asfortranarray(directions), np.asfortranarray(values)

    def _raise_status(self, code: int) -> None:
        """As `raise_status`, but also names the eigenvalues of two modes that nearly coincide."""
        if code != DEFECTIVE:
            raise_status(code)
            return
        n = self.coordinates
        rates = np.linalg.solve(self.mass, np.hstack([self.stiffness, self.damping]))
        values, vectors = np.linalg.eig(np.vstack([np.eye(n, 2 * n, n), -rates]))
        # complex eigenvalues first: two equal real ones belong to critical damping
        moving = np.abs(values) > 1e-6 * np.abs(values).max()
        for kept in (values.imag > 0, moving & (values.imag == 0)):
            parallel = np.triu(np.abs(vectors[:, kept].conj().T @ vectors[:, kept]), 1)
            if parallel.max(initial=0.0) > 0.99:
                first, second = np.unravel_index(int(np.argmax(parallel)), parallel.shape)
                pair = f"{values[kept][first]:.6g} and {values[kept][second]:.6g}"
                raise SingularError(f"{sentence(code)}; their eigenvalues are {pair}")
        raise_status(code)

    def _groups(self) -> list[tuple[str, dict[str, Any]]]:
        """The namelist groups that describe it."""
        if not self._parts:
            raise ParameterError(
                f"{self!r}: has no namelist, since a &structure has at least one &gap, &stop or &friction"
            )
        matrices = {}
        for name in ("mass", "damping", "stiffness"):
            matrix = getattr(self, name)
            diagonal = np.diag(matrix)
            plain = diagonal if np.array_equal(matrix, np.diag(diagonal)) else matrix.ravel()
            matrices[name] = plain.tolist()
        if self.outputs:
            rows = np.ravel([*self.outputs.values()]).tolist()
            matrices |= {"outputs": [*self.outputs], "output_rows": rows}
        if self.simultaneous:
            matrices["simultaneous"] = self.simultaneous
        if self._units is not None:
            known = self._units
            matrices |= {"scales": [known.M, known.K, known.F0], "unit_names": known.names}
        return [("structure", matrices), *(part._group() for part in self._parts)]

    def _with_units(self, units: Units | None) -> Structure:
        """The structure itself, after its units are set."""
        object.__setattr__(self, "_units", units)
        return self

    def _in(self, units: Units) -> Structure:
        """A structure of an oscillator, whose coordinates are displacements, in physical units."""
        length, speed = units.length, units.velocity
        stiffness, damping = units.K, units.K * units.time

        def wall(part: Gap | Stop) -> dict[str, Any]:
            names = ("opening", "cosine", "sine")
            return {name: getattr(part, name) * length for name in names}

        gaps: list[Gap | Stop] = []
        for part in self.gaps:
            if isinstance(part, Gap):
                law = part.restitution
                own = law._in_speeds(speed) if isinstance(law, Law) else law
                gaps.append(replace(part, restitution=own, **wall(part)))
            else:
                gaps.append(replace(
                    part, stiffness=part.stiffness * stiffness, damping=part.damping * damping,
                    preload=part.preload * units.F0, **wall(part),
                ))  # fmt: skip
        friction = [
            replace(part, slip=part.slip * units.F0, stick=part.stick * units.F0, speed=part.speed * speed)
            for part in self.friction
        ]  # fmt: skip
        found = Structure(
            self.mass * units.M, self.damping * damping, self.stiffness * stiffness, gaps, friction,
            self.outputs, simultaneous=self.simultaneous,
        )  # fmt: skip
        return found._with_units(Units(1.0, 1.0, 1.0, units.names))

    @property
    def _parts(self) -> tuple[Gap | Stop | Friction, ...]:
        """Gaps and stops, then friction, in the order of the core."""
        return (*self.gaps, *self.friction)

    @property
    def _moves(self) -> bool:
        """Whether the wall of a gap or a stop moves."""
        return any(_motion_of(part) for part in self._parts)

    @property
    def _is_rigid(self) -> bool:
        """Whether it has neither stops nor friction."""
        return not self.friction and all(isinstance(gap, Gap) for gap in self.gaps)

    def _rigid(self) -> list[Gap]:
        """The gaps; ParameterError if one of them is a stop, or if there is friction."""
        if self.friction:
            raise ParameterError(
                f"friction[0] = {self.friction[0]!r}: must be left out here; only {WITH_ELEMENTS} take friction"
            )
        found = []
        for i, gap in enumerate(self.gaps):
            if isinstance(gap, Stop):
                raise ParameterError(
                    f"gaps[{i}] = {gap!r}: must be a Gap here; only {WITH_ELEMENTS} take stops"
                )
            found.append(gap)
        return found

    def __repr__(self) -> str:
        n, stops = self.coordinates, sum(isinstance(gap, Stop) for gap in self.gaps)
        gaps = len(self.gaps) - stops
        parts = [f"{gaps} gap{'s' * (gaps != 1)}"] if gaps or not (stops or self.friction) else []
        parts += [f"{stops} stop{'s' * (stops != 1)}"] if stops else []
        parts += ["friction"] if self.friction else []
        law = f", simultaneous={self.simultaneous!r}" if self.simultaneous else ""
        return (
            f"<Structure of {n} coordinate{'s' if n != 1 else ''} with {' and '.join(parts)}{law}>"
        )


def _check_size(array: NDArray[Any], name: str) -> None:
    """Raises an error, before the matrix is made, if it or its diagonal is for too many coordinates."""
    if max(array.shape, default=0) > MOST:
        raise ParameterError(f"{name} of shape {array.shape}: must be for 1 to {MOST} coordinates")


def _list_of_gaps(
    gaps: Any, name: str = "gaps", kinds: tuple[type, ...] = (Gap, Stop)
) -> tuple[Any, ...]:
    """Gaps and stops, or friction, as a tuple."""
    try:
        found = tuple(gaps)
    except TypeError:
        what = "Gap and Stop" if name == "gaps" else "Friction"
        raise ParameterTypeError(f"{name} = {gaps!r}: must be a list of {what}") from None
    if len(found) > MOST:
        raise ParameterError(f"{name}: {len(found)} of them; must be at most {MOST}")
    for i, gap in enumerate(found):
        if not isinstance(gap, kinds):
            wanted = " or ".join(f"a vibroimpact.{kind.__name__}" for kind in kinds)
            raise ParameterTypeError(
                f"{name}[{i}] = {gap!r}: must be {wanted}, not {type(gap).__name__}"
            )
    return found


def _square(values: Any, name: str) -> _Array:
    """A square matrix; a vector is taken as its diagonal."""
    wanted = "a symmetric matrix (n, n), or its diagonal (n,)"
    array = checks.real_array(values, name, wanted)
    _check_size(array, name)
    array = _numbers(np.diag(array) if array.ndim == 1 else array, name, wanted, (-1, -1))
    if array.shape[0] != array.shape[1]:
        raise ParameterError(f"{name} of shape {array.shape}: must be {wanted}")
    outside = np.abs(array) > LARGEST
    if outside.any():
        i, j = np.unravel_index(int(np.argmax(outside)), array.shape)
        raise ParameterError(
            f"{name}[{i}, {j}] = {float(array[i, j])!r}: must be a number from -1e100 to 1e100"
        )
    return array


def _symmetric(matrix: _Array, unit: _Array, name: str) -> _Array:
    """A matrix checked to be symmetric and definite as required, up to rounding; `unit` scales the coordinates."""
    scales = np.outer(unit, unit)
    scaled = matrix * scales
    apart = np.abs(scaled - scaled.T)
    largest = np.abs(scaled).max()
    if apart.max() > 1e-12 * largest:
        i, j = np.unravel_index(int(np.argmax(apart)), apart.shape)
        raise ParameterError(
            f"{name}[{i}, {j}] = {float(matrix[i, j])} and {name}[{j}, {i}] = {float(matrix[j, i])}: must be equal"
        )
    symmetric: _Array = np.array(0.5 * (matrix + matrix.T))
    symmetric.flags.writeable = False
    n = len(matrix)
    least = float(np.linalg.eigvalsh(0.5 * (scaled + scaled.T)).min())
    rule = ""
    if name == "mass" and not least > n * np.finfo(float).eps:
        rule = "must be positive definite; its least eigenvalue"
    elif least < -1e-12 * largest * n:
        rule = "must have no negative eigenvalue; the least one"
    if rule:
        # the sign may be lost if coordinates have very different units
        own = float(np.linalg.eigvalsh(symmetric).min())
        lost = " with coordinates scaled by the square roots of their masses" if own > 0 else ""
        raise ParameterError(f"{name}: {rule} is {least if own > 0 else own:.3g}{lost}")
    return symmetric


@dataclass(frozen=True, eq=False, repr=False)
class Load(ByValue):
    """A periodic load: the sum of cosine_h cos(h Omega t) + sine_h sin(h Omega t), plus a constant.

    Parameters
    ----------
    frequency : float, optional
        Omega > 0, or with a unit, such as "19.5 Hz", which is converted to rad/s; not needed for a constant load.
    sine, cosine : array_like (n,) or (H, n), optional
        Amplitudes of harmonics 1 to H at each coordinate; a vector is taken as the first harmonic.
    constant : array_like (n,), optional
        A constant force, such as gravity.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> vi.Load(1.04, sine=[1, 0])
    <Load of 1 harmonic of Omega = 1.04 on 2 coordinates>
    """

    frequency: float
    sine: _Array
    cosine: _Array
    constant: _Array
    #: Whether the frequency had a unit, and is in radians per second.
    _in_seconds: ClassVar[bool] = False

    def __init__(
        self, frequency: float | None = None, sine: ArrayLike | None = None,
        cosine: ArrayLike | None = None, constant: ArrayLike | None = None,
    ) -> None:  # fmt: skip
        if frequency is not None:
            frequency = number_of(frequency, "frequency", "omega", self._units_of_seconds)
            frequency = checks.to_float(frequency, "frequency", "a number > 0")
            if not 0 < frequency < np.inf:
                raise ParameterError(f"frequency = {frequency!r}: must be a finite number > 0")
        elif sine is not None or cosine is not None:
            raise ParameterError("frequency = None: must be given with sine or cosine")
        parts = {}
        for name, values in {"sine": sine, "cosine": cosine}.items():
            if values is not None:
                wanted = "amplitudes (n,) or (harmonics, n)"
                array = checks.real_array(values, name, wanted)
                parts[name] = _numbers(
                    array[None] if array.ndim == 1 else array, name, wanted, (-1, -1)
                )
        if constant is not None:
            wanted = "a list (n,) with one force for each coordinate"
            parts["constant"] = _numbers(constant, "constant", wanted, (-1,))
        if not parts:
            raise ParameterError("sine, cosine, constant: one of them must be given")
        sizes = {name: array.shape[-1] for name, array in parts.items()}
        n = min(sizes.values())
        if n == 0 or len(set(sizes.values())) > 1:
            found = ", ".join(f"{name} is for {size}" for name, size in sizes.items())
            raise ParameterError(f"{found}: must be for the same number of coordinates, at least 1")
        harmonics = max(
            (len(array) for name, array in parts.items() if name != "constant"), default=0
        )
        for name in ("sine", "cosine"):
            whole = np.zeros((harmonics, n))
            if name in parts:
                whole[: len(parts[name])] = parts[name]
            whole.flags.writeable = False
            object.__setattr__(self, name, whole)
        object.__setattr__(self, "constant", parts.get("constant", np.zeros(n)))
        object.__setattr__(self, "frequency", frequency or 0.0)

    @classmethod
    def none(cls) -> Load:
        """No load, for a structure with any number of coordinates; for `simulate`, `exact`, `find` and others.

        Examples
        --------
        >>> import vibroimpact as vi
        >>> vi.Load.none()
        <No load>
        """
        found = cls.__new__(cls)
        parts = {
            "frequency": 0.0,
            "sine": np.zeros((0, 0)),
            "cosine": np.zeros((0, 0)),
            "constant": np.zeros(0),
        }
        for name, value in parts.items():
            object.__setattr__(found, name, value)
        return found

    def _units_of_seconds(self) -> Units:
        """The units of a frequency that has one, which is then known to be in radians per second."""
        object.__setattr__(self, "_in_seconds", True)
        return Units(1.0, 1.0, 1.0)

    @property
    def coordinates(self) -> int:
        """Number of coordinates; 0 for no load."""
        return self.constant.size

    def _in(self, units: Units) -> Load:
        """The load on a structure of an oscillator in physical units."""
        if not self.coordinates:
            return self
        parts = {"sine": self.sine, "cosine": self.cosine} if len(self.sine) else {}
        parts = {name: values * units.F0 for name, values in parts.items()}
        frequency = self.frequency * units.omega or None
        return Load(frequency, **parts, constant=self.constant * units.F0)

    def __add__(self, other: Load) -> Load:
        """The sum of two loads, which must have the same frequency unless one of them is constant.

        Examples
        --------
        >>> import vibroimpact as vi
        >>> gravity = vi.Load(constant=[0.0, -9.81])
        >>> gravity + vi.Load(2.0, sine=[1.0, 0.0])
        <Load of 1 harmonic of Omega = 2 on 2 coordinates>
        """
        if not isinstance(other, Load):
            return NotImplemented
        if not self.coordinates or not other.coordinates:
            return self if self.coordinates else other
        if self.coordinates != other.coordinates:
            raise ParameterError(
                f"load for {counted(other.coordinates, 'coordinate')}: must be for {self.coordinates}, "
                "like the load to which it is added"
            )
        frequencies = {load.frequency for load in (self, other) if load.frequency}
        if len(frequencies) > 1:
            raise ParameterError(
                f"frequency = {other.frequency!r}: must be {self.frequency!r}, the frequency of the load "
                "to which it is added"
            )
        parts: dict[str, _Array] = {"constant": self.constant + other.constant}
        most = max(len(self.sine), len(other.sine))
        for name in ("sine", "cosine") if most else ():
            both = [getattr(load, name) for load in (self, other)]
            first, second = (np.pad(part, ((0, most - len(part)), (0, 0))) for part in both)
            parts[name] = first + second
        return Load(max(frequencies, default=None), **parts)

    def _groups(self) -> list[tuple[str, dict[str, Any]]]:
        """The group of a namelist that describes it."""
        keys: dict[str, Any] = {"frequency": self.frequency or None}
        if len(self.sine):
            keys |= {"cosine": self.cosine.ravel().tolist(), "sine": self.sine.ravel().tolist()}
        return [("load", keys | {"constant": self.constant.tolist()})]

    def _arrays(self) -> tuple[float, _Array, _Array]:
        """Omega (0 without harmonics), harmonics (n, 2, H), and the constant part."""
        both = (
            np.stack([self.cosine, self.sine], axis=1).T
            if self.sine.size
            else np.zeros((self.coordinates, 2, 0))
        )
        return self.frequency if len(self.sine) else 0.0, np.asfortranarray(both), self.constant

    def __repr__(self) -> str:
        n, places = len(self.sine), counted(self.coordinates, "coordinate")
        if not self.coordinates:
            return "<No load>"
        if not self.frequency:
            return f"<Load, constant, on {places}>"
        return f"<Load of {counted(n, 'harmonic')} of Omega = {self.frequency:g} on {places}>"


def without_none(load: Any) -> Any:
    """None for `Load.none()`, otherwise the load."""
    return None if isinstance(load, Load) and not load.coordinates else load


def check_load(
    structure: Any, load: Any, frequency: bool = False, kinds: tuple[type, ...] = (Load,),
    stops: bool = False,
) -> None:  # fmt: skip
    """Checks that a load is of an allowed kind, fits the structure, and has a frequency if one is required; and
    that the structure has stops only if they are allowed."""
    checks.instance(structure, "structure", Structure)
    if not stops:
        structure._rigid()
    if without_none(load) is None and load is not None and type(None) not in kinds:
        raise ParameterError(f"load = {load!r}: must be a load with a frequency here")
    load = without_none(load)
    if not isinstance(load, kinds):
        checks.instance(load, "load", Load)
    if structure._moves and not getattr(load, "frequency", 0.0):
        raise ParameterError(
            f"load = {load!r}: must have a frequency, with which the walls of the structure move"
        )
    if load is None:
        return
    if load.coordinates != structure.coordinates:
        raise ParameterError(
            f"load for {counted(load.coordinates, 'coordinate')}: must be for {structure.coordinates}, "
            "as many as the structure has"
        )
    if frequency and not load.frequency:
        raise ParameterError(f"load = {load!r}: must have a frequency, which gives the period")
    units = structure._units
    if getattr(load, "_in_seconds", False) and units is not None and units.to("SI").omega != 1:
        own = load.frequency / units.to("SI").omega
        raise ParameterError(
            f"load = {load!r}: must have a frequency that is a plain number, in the structure's own unit (a ratio "
            f"r if it is dimensionless): {own:.10g}, not {load.frequency:.10g} rad/s"
        )
