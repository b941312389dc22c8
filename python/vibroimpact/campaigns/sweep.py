"""The cases of a campaign: a base case in which some keys take many values."""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base import checks
from ..base.checks import Rng
from ..base.errors import ParameterError, ParameterTypeError
from ..base.libraries import scipy
from ..base.spacing import spaced
from ..cases.case import Case
from ..results import namelist
from ..results.tables import keys_for, language

__all__ = ["CaseList", "Sweep"]

#: Ways to choose points in a box.
METHODS = ("sobol", "latin_hypercube")
#: Largest number of cases of a grid, and of points by each method.
MOST = 10**12
MOST_POINTS = {"sobol": 2**30, "latin_hypercube": 2**20}
#: Number of points kept in memory at a time.
BLOCK = 2**20


class Sweep:
    """Cases that differ in the values of some keys: a grid of values, or points in a box.

    Parameters
    ----------
    case : str or Case
        A complete case as a namelist, as returned by `to_namelist` of any result; keys that are not swept keep
        their values.
    values : mapping
        The values of each key: numbers, texts, or tuples for a key with several values. A key is named as in the
        namelist, such as "xi", or with its group if two groups have the key: "system.r". With `samples`, the
        lowest and the largest value of each key.
    samples : int, optional
        Number of points in the box between these values: at most 2^30, or 2^20 for a Latin hypercube. Without it
        the cases are all combinations of the values, in C order (last key fastest).
    method : str
        How the points are chosen: "sobol" (scrambled; the number of samples should be a power of 2) or
        "latin_hypercube".
    rng : int, numpy.random.Generator or None
        Seed of the points, or a generator from which a seed is drawn; None: another seed in each call. The same
        seed gives the same points.
    geometric : sequence of str
        Keys whose logarithms are evenly distributed.

    Raises
    ------
    ParameterError, ParameterTypeError
        If the case does not have a key, or a key cannot take a value.
    MissingExtraError
        If points in a box are requested and scipy is not installed.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    >>> case = vi.equispaced(osc, r=1.0, clearance=20.0)[0].to_namelist()
    >>> sweep = vi.Sweep(case, {"r": [0.9, 1.0], "clearance": [10.0, 20.0, 30.0]})
    >>> len(sweep), sweep.shape, sweep.point(4)
    (6, (2, 3), {'system.r': 1.0, 'motion.clearance': 20.0})
    """

    def __init__(
        self, case: str | Case, values: Mapping[str, Sequence[Any]], *, samples: int | None = None,
        method: str = "sobol", rng: Rng = 0, geometric: Sequence[str] = (),
    ) -> None:  # fmt: skip
        if isinstance(geometric, str) or not isinstance(geometric, Sequence):
            raise ParameterTypeError(f"geometric = {geometric!r}: must be a sequence of keys")
        text = case.text if isinstance(case, Case) else case
        if not isinstance(text, str):
            raise ParameterTypeError(f"case = {text!r}: must be a namelist as a text, or a Case")
        self.template = text.strip("\n") + "\n"
        groups = _groups(self.template)
        if not isinstance(values, Mapping) or not values:
            raise ParameterError(f"values = {values!r}: must be a mapping with at least one key")
        self.keys = tuple(_full_name(key, groups) for key in values)
        for key in self.keys:
            if self.keys.count(key) > 1:
                raise ParameterError(f"values: {key} is given twice; must be given once")
        names = dict(zip(values, self.keys, strict=True))
        given = {full: _listed(values[key], full) for key, full in names.items()}
        #: Plain values from which the same sweep can be created.
        self.record: dict[str, Any] = {"template": self.template, "values": given}
        self._parts = _split(self.template, self.keys)
        #: Shape of the grid of cases: one size per key, or the number of all cases.
        self.shape: tuple[int, ...]
        self._points: Points | None = None
        if samples is None:
            if geometric:
                raise ParameterError("geometric: needs samples; the values of a grid are given")
            self.shape = tuple(map(len, given.values()))
            if math.prod(self.shape) > MOST:
                raise ParameterError(
                    f"values: give {math.prod(self.shape)} cases; must be at most {MOST}"
                )
        else:
            seed = checks.seed_of(rng, 2**63 - 1)
            logs = {_full_name(key, groups) for key in geometric}
            if logs - set(self.keys):
                raise ParameterError(f"geometric = {list(geometric)!r}: must be keys of values")
            boxes = [_box(ends, key, key in logs) for key, ends in given.items()]
            self._points = Points(boxes, [key in logs for key in self.keys], samples, method, seed)
            self.shape = (self._points.size,)
            self.record |= {
                "samples": samples, "method": method, "seed": seed, "geometric": sorted(logs),
                "points": hashlib.sha256(self._points.block(0).tobytes()).hexdigest(),
            }  # fmt: skip

    @property
    def points(self) -> NDArray[np.float64] | None:
        """The points (samples, keys) in the box; None for a grid."""
        return None if self._points is None else self._points.all()

    @property
    def axes(self) -> tuple[list[Any], ...]:
        """For each key its values: those of the grid, or those of all points."""
        if self._points is None:
            return tuple(self.record["values"].values())
        return tuple(self._points.all().T.tolist())

    @classmethod
    def of_case(cls, case: Case) -> Sweep:
        """The sweep of a case with a &sweep.

        Parameters
        ----------
        case : Case
            A case of a file, with a &sweep after its study.

        Returns
        -------
        Sweep
            The cases that the lists of the &sweep define.

        Raises
        ------
        ParameterError
            If the case has no &sweep, or the lists of its &sweep are inconsistent.
        """
        checks.instance(case, "case", Case)
        parts = dict(namelist.parts_of(case.text))
        if "sweep" not in parts:
            raise ParameterError(f"{case.name}: has no &sweep; must have one after &{case.kind}")
        text = re.sub(r"(?ms)^&(sweep|output)$.*?^/$\n?", "", case.text)
        try:
            return _of_keys(cls, text, parts["sweep"])
        except ParameterError as error:
            raise ParameterError(f"{case.name}: &sweep {error}") from None

    @classmethod
    def of_record(cls, record: Mapping[str, Any]) -> Sweep:
        """The sweep from its record.

        Parameters
        ----------
        record : mapping
            The attribute `record` of a sweep.

        Returns
        -------
        Sweep
            The same sweep.
        """
        options = {
            "rng" if key == "seed" else key: record[key]
            for key in ("samples", "method", "seed", "geometric") if key in record
        }  # fmt: skip
        found = cls(record["template"], record["values"], **options)
        if found.record != record:
            raise ParameterError(
                "the cases of the sweep are not those of the store: "
                + (
                    "its points were generated by a different release of scipy"
                    if options
                    else "its plan is damaged"
                )
            )
        return found

    def __len__(self) -> int:
        return math.prod(self.shape)

    def __repr__(self) -> str:
        return f"<Sweep of {len(self)} cases over {', '.join(self.keys)}>"

    def point(self, number: int) -> dict[str, Any]:
        """The values of the swept keys in a case, given by its number.

        Parameters
        ----------
        number : int
            Number of the case, from 0.

        Returns
        -------
        dict
            The value of each swept key.
        """
        number = checks.integer(number, "number", 0, len(self) - 1)
        if self._points is not None:
            return dict(zip(self.keys, self._points[number], strict=True))
        places = np.unravel_index(number, self.shape)
        return {key: axis[i] for key, axis, i in zip(self.keys, self.axes, places, strict=True)}

    def text(self, number: int) -> str:
        """A case as a namelist, given by its number.

        Parameters
        ----------
        number : int
            Number of the case, from 0.

        Returns
        -------
        str
            The case with its values filled in.
        """
        values = self.point(number)
        return "".join(
            part
            if isinstance(part, str)
            else f"  {part[1]} = {namelist._value(values['.'.join(part)])}\n"
            for part in self._parts
        )


def _of_keys(kind: type[Sweep], text: str, given: Mapping[str, Any]) -> Sweep:
    """The sweep that the keys of a &sweep define."""
    lists = {
        key: value if isinstance(value, list) else [value] for key, value in given.items()
    }  # fmt: skip
    keys, n = lists["keys"], len(lists["keys"])

    def each(key: str, default: Any = None) -> list[Any]:
        """A list with a value for each key."""
        found = lists.get(key, [default] * n)
        if len(found) == 1:
            found = found * n
        if len(found) != n:
            raise ParameterError(
                f"{key}: has {len(found)} values; must have one for each of {n} keys"
            )
        return found

    if ("values" in lists) + ("words" in lists) + ("low" in lists) != 1:
        raise ParameterError("values: must be given, or words, or low and high")
    if "low" not in lists:
        items = lists.get("values") or lists["words"]
        counts = each("counts", len(items) if n == 1 else None)
        if None in counts or sum(counts) != len(items):
            raise ParameterError(
                f"counts = {lists.get('counts')}: must be the number of values of each key; there are "
                f"{len(items)} values"
            )
        ends = np.cumsum([0, *counts]).tolist()
        return kind(
            text, {key: items[a:b] for key, a, b in zip(keys, ends[:-1], ends[1:], strict=True)}
        )
    if "high" not in lists:
        raise ParameterError("high: must be given with low")
    low, high, spacing = each("low"), each("high"), each("spacing", "linear")
    boxes = dict(zip(keys, zip(low, high, strict=True), strict=True))
    geometric = [key for key, word in zip(keys, spacing, strict=True) if word == "geometric"]
    if "samples" in lists:
        return kind(
            text, boxes, samples=given["samples"], method=given.get("method", "sobol"),
            rng=given.get("seed", 0), geometric=geometric,
        )  # fmt: skip
    if "counts" not in lists:
        raise ParameterError("counts: must be given with low and high, or samples")
    values = {}
    for key, (a, b), count in zip(keys, boxes.values(), each("counts"), strict=True):
        _box([a, b], key, key in geometric)
        values[key] = spaced(a, b, count, "geometric" if key in geometric else "linear").tolist()
    return kind(text, values)


class CaseList:
    """Cases that are given one by one."""

    keys: tuple[str, ...] = ()

    def __init__(self, cases: Iterable[str | Case]) -> None:
        try:
            given = list(cases)
        except TypeError:
            raise ParameterTypeError(
                f"cases = {cases!r}: must be a list of cases, or a Sweep"
            ) from None
        self.cases = [case.text if isinstance(case, Case) else case for case in given]
        for i, text in enumerate(self.cases):
            if not isinstance(text, str):
                raise ParameterTypeError(
                    f"cases[{i}] = {text!r}: must be a namelist as a text, or a Case"
                )
            _groups(text, f"cases[{i}]")
        if not self.cases:
            raise ParameterError("cases: is empty; must contain at least one case")
        for i, text in enumerate(self.cases):
            if namelist.has_structure(text) != namelist.has_structure(self.cases[0]):
                raise ParameterError(
                    f"cases[{i}]: must be of the same model as cases[0]: &system or &structure"
                )
        self.shape = (len(self.cases),)
        digest = hashlib.sha256("\0".join(self.cases).encode()).hexdigest()
        self.record: dict[str, Any] = {"cases": len(self.cases), "digest": digest}

    def __len__(self) -> int:
        return len(self.cases)

    def text(self, number: int) -> str:
        """A case, by number from 0."""
        return self.cases[number]


def _groups(text: str, name: str = "case") -> list[str]:
    """The groups of a case; an error unless it is written with one key per line, as `to_namelist` does."""
    groups = re.findall(r"(?m)^&(\w+)$", text)
    try:
        whole = len(namelist.parts_of(text)) == len(groups) > 1 and language()["groups"].keys() >= {
            *groups
        }
    except ValueError:  # a line with a comment or a second key
        whole = False
    inside = re.sub(r"(?m)^!.*$|'[^'\n]*'", "", text)
    if not whole or "!" in inside:
        raise ParameterError(
            f"{name} = {text[:60]!r}: must be a complete case with one `key = value` per line, in the form that "
            "`to_namelist` of a result or `read_namelist` returns"
        )
    return groups


def _known(group: str, groups: Sequence[str]) -> list[str]:
    """The keys that a group of a case may have."""
    return [str(key["name"]) for key in keys_for(group, "structure" in groups)]


def _full_name(key: Any, groups: Sequence[str]) -> str:
    """The name of a key with its group."""
    if not isinstance(key, str):
        raise ParameterTypeError(
            f"values: the key {key!r} must be a text such as 'xi' or 'system.xi'"
        )
    group, _, name = key.rpartition(".")
    asked = [one for one in dict.fromkeys(groups) if one != "output" and one in (group or one)]
    found = [one for one in asked if name in _known(one, groups)]
    if not found:
        known = ", ".join(
            f"{one}.{item}" for one in asked or groups[:-1] for item in _known(one, groups)
        )
        raise ParameterError(f"values: {key!r} is not a key of the case; must be one of {known}")
    if len(found) > 1:
        choice = " or ".join(f"{one}.{name}" for one in found)
        raise ParameterError(f"values: {key!r} is a key of several groups; must be {choice}")
    if groups.count(found[0]) > 1:
        raise ParameterError(
            f"values: {key!r}: the case has several &{found[0]}; must be another key"
        )
    return f"{found[0]}.{name}"


def _split(template: str, keys: Sequence[str]) -> list[str | tuple[str, str]]:
    """The case as pieces of text, with (group, key) in place of each line that changes."""
    parts: list[str | tuple[str, str]] = []
    group, fixed, left = "", "", list(keys)
    for line in template.splitlines(keepends=True):
        word = line.strip()
        if line[:1] == "&":
            group = word[1:]
        full = f"{group}.{word.partition(' = ')[0]}"
        ending = [key for key in left if key.startswith(f"{group}.")] if word == "/" else []
        if full in left:
            ending = [full]
        for key in ending:
            left.remove(key)
            parts += [fixed, (group, key.partition(".")[2])]
            fixed = ""
        if full not in keys:
            fixed += line
    return [*parts, fixed]


def _plain(value: Any, key: str) -> Any:
    """Checks a value for a namelist."""
    if isinstance(value, (list, tuple, np.ndarray)):
        return [_plain(item, key) for item in np.asarray(value, dtype=object).ravel().tolist()]
    if isinstance(value, (bool, np.bool_)) or value is None:
        raise ParameterTypeError(f"values[{key!r}]: {value!r} must be a number or a text")
    if isinstance(value, (str, int)):
        return value
    if isinstance(value, np.integer):
        return int(value)
    found = checks.to_float(value, f"values[{key!r}]", "numbers or texts")
    if not math.isfinite(found):
        raise ParameterError(f"values[{key!r}]: {found!r} must be a finite number")
    return found


def _listed(values: Any, key: str) -> list[Any]:
    """The values of a key, in order."""
    if isinstance(values, str) or not isinstance(values, (Sequence, np.ndarray)):
        raise ParameterTypeError(f"values[{key!r}] = {values!r}: must be a sequence of values")
    found = [_plain(value, key) for value in values]
    if not found:
        raise ParameterError(f"values[{key!r}]: is empty; must have at least one value")
    if len({repr(value) for value in found}) < len(found):
        raise ParameterError(f"values[{key!r}]: contains a value twice; each value must occur once")
    return found


def _box(ends: list[Any], key: str, geometric: bool) -> tuple[float, float]:
    """The lowest and the largest value of a key."""
    if len(ends) != 2 or not all(isinstance(end, (int, float)) for end in ends):
        raise ParameterError(f"values[{key!r}] = {ends!r}: must be two numbers with samples")
    low, high = map(float, ends)
    if not low < high or (geometric and low <= 0):
        wanted = "0 < low < high" if geometric else "low < high"
        raise ParameterError(f"values[{key!r}] = {ends!r}: must be two numbers with {wanted}")
    return low, high


class Points:
    """Points in a box, generated in blocks; only one block is kept in memory."""

    def __init__(
        self, boxes: Sequence[tuple[float, float]], logs: Sequence[bool], samples: int, method: str, seed: int
    ) -> None:  # fmt: skip
        if method not in METHODS:
            raise ParameterError(f"method = {method!r}: must be {' or '.join(map(repr, METHODS))}")
        self.size = checks.integer(samples, "samples", 1, MOST_POINTS[method])
        self.seed = seed
        self.boxes, self.logs, self.method = boxes, logs, method
        self._engine()
        #: The current block, its number, and the generator of the next one.
        self._held: tuple[int, NDArray[np.float64], Any] = (-1, np.empty(0), None)

    def _engine(self) -> Any:
        """A new generator of points in the unit cube."""
        qmc = scipy("stats.qmc", "samples", "campaign")
        kind = qmc.Sobol if self.method == "sobol" else qmc.LatinHypercube
        return kind(len(self.boxes), seed=np.random.default_rng(self.seed))

    def block(self, number: int) -> NDArray[np.float64]:
        """The points (at most BLOCK, keys) of a block."""
        held, points, engine = self._held
        if held == number:
            return points
        if held + 1 != number or engine is None:
            engine = self._engine()
            if number:
                engine.fast_forward(number * BLOCK)
        left = min(BLOCK, self.size - number * BLOCK)
        # the Sobol sequence is generated in powers of 2; surplus points are dropped
        unit = engine.random(
            left if self.method != "sobol" else 1 << max(0, left - 1).bit_length()
        )[:left]
        columns = [
            low * (high / low) ** share if log else low + (high - low) * share
            for (low, high), log, share in zip(self.boxes, self.logs, unit.T, strict=True)
        ]  # fmt: skip
        points = np.stack(columns, axis=1)
        self._held = (number, points, engine)
        return points

    def __getitem__(self, number: int) -> list[float]:
        """A point."""
        block, place = divmod(range(self.size)[number], BLOCK)
        point: list[float] = self.block(block)[place].tolist()
        return point

    def all(self) -> NDArray[np.float64]:
        """All points (samples, keys)."""
        return np.concatenate([self.block(i) for i in range(-(-self.size // BLOCK))])
