"""The results of a campaign, read from its store, also while it runs."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base import checks
from ..base.errors import OutOfMemoryError, ParameterError, ParameterTypeError
from ..base.libraries import xarray
from ..results.noun import Noun
from ..results.tables import declared, language, present
from .chunk import joined, recoded
from .store import OWN, PLAN, Store
from .sweep import Sweep

__all__ = ["Campaign"]

#: How `Campaign.values` reduces the rows of a case to one number.
REDUCTIONS: dict[str, Any] = {"min": np.minimum, "max": np.maximum, "sum": np.add}


class Campaign:
    """The results in the store of a campaign.

    Parameters
    ----------
    store : path
        The folder of the campaign.

    Attributes
    ----------
    study : str
        The study of its cases.
    sweep : Sweep or None
        None if the cases were given individually.
    size : int
        The number of its cases.

    Raises
    ------
    ParameterError
        If the folder is not the store of a campaign.

    Examples
    --------
    >>> import pathlib, tempfile, vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    >>> case = vi.equispaced(osc, r=1.0, clearance=20.0)[0].to_namelist()
    >>> sweep = vi.Sweep(case, {"r": [0.9, 1.0], "clearance": [10.0, 20.0, 30.0]})
    >>> store = pathlib.Path(tempfile.mkdtemp()) / "store"
    >>> _ = vi.campaign(sweep, store)
    >>> found = vi.Campaign(store)
    >>> found.values("motions", "attenuation", "min").round(3)
    array([[..., ..., ...],
           [..., ..., ...]])
    """

    def __init__(self, store: str | os.PathLike[str]) -> None:
        self._store = Store(store)
        plan = self._store.plan()
        self.sweep = None
        try:
            self.study: str = present(plan["study"])
            structure = bool(plan.get("of_structure", self.study != plan["study"]))
            self.size: int = checks.integer(plan["size"], "size", 0, 2**62)
            self._chunk: int = checks.integer(plan["chunk"], "chunk", 1, 10**7)
            if "template" in plan and self.study in language()["results"]:
                self.sweep = Sweep.of_record({k: v for k, v in plan.items() if k not in OWN})
        except (LookupError, ValueError, TypeError, AttributeError) as error:
            raise ParameterError(
                f"store = {str(store)!r}: its {PLAN} is damaged; restore it, or use another store ({error})"
            ) from error
        if self.study not in language()["results"]:
            raise ParameterError(
                f"store = {str(self._store.folder)!r}: holds cases of {self.study!r}, which this vibroimpact does "
                f"not have; must be read with vibroimpact {plan.get('vibroimpact')}"
            )
        self._declared = declared(self.study, structure)
        self._read = lru_cache(4)(self._store.read)

    @property
    def failures(self) -> Path:
        """The folder with the cases that were rejected or failed, as namelists."""
        return self._store.failures

    def __repr__(self) -> str:
        return (
            f"<Campaign of {self.study}: {self._done()} of {self.size} cases finished, "
            f"{self._store.failed()} rejected>"
        )

    def __len__(self) -> int:
        return self.size

    def _chunks(self) -> Iterator[tuple[int, str]]:
        """The finished chunks: the number of the first case, and the name."""
        for name in self._store.names():
            yield int(name.partition("-")[0]), name

    def _done(self) -> int:
        """The number of finished cases."""
        return sum(min(self._chunk, self.size - first) for first, _ in self._chunks())

    def _array(self, value: Any) -> NDArray[Any]:
        """A value for each case."""
        try:
            return np.full(self.size, value)
        except MemoryError:
            raise OutOfMemoryError(
                f"store = {str(self._store.folder)!r}: one number for each of {self.size} cases needs more memory "
                "than is available; read it in parts from results.zarr"
            ) from None

    @property
    def finished(self) -> NDArray[np.bool_]:
        """For each case, whether its chunk is in the store."""
        done = self._array(False)
        for first, _ in self._chunks():
            done[first : first + self._chunk] = True
        return done

    @property
    def refused(self) -> dict[int, str]:
        """The cases that the study rejected, by number, with the reason."""
        return {
            first + i: head["error"]
            for first, name in self._chunks()
            for i, head in enumerate(self._store.heads(name)["heads"]) if "error" in head
        }  # fmt: skip

    def __getitem__(self, number: int) -> Noun:
        """The result of a case, by number from 0, as its study returns it."""
        if not isinstance(number, (int, np.integer)) or not -self.size <= number < self.size:
            raise IndexError(f"case {number!r}: must be a whole number below {self.size}")
        place = int(number) % self.size
        first = place // self._chunk * self._chunk
        for begin, name in self._chunks():
            if begin == first:
                return self._read(name).noun(place - first)
        raise ParameterError(
            f"case {place}: is not finished; continue the campaign by the same call"
        )

    def values(
        self, table: str, column: str, reduce: str = "first", where: Mapping[str, Any] | None = None
    ) -> NDArray[Any]:
        """One number for each case, in the shape of the sweep.

        Parameters
        ----------
        table, column : str
            A column of the results, as in the `to_xarray` of a single result; its values must be real numbers,
            whole numbers, verdicts or logical values.
        reduce : str
            How several rows of a case are reduced: "first", "min", "max", "sum", "mean", or "count" for their
            number. NaN is ignored.
        where : mapping, optional
            Columns of the same table with the value that a row must have to be counted: {"stable": True}.

        Returns
        -------
        ndarray
            NaN for a case that is not finished, was rejected, or has no rows.

        Raises
        ------
        ParameterError
            If the study has no such column.
        """
        checks.choice(reduce, "reduce", ("first", *REDUCTIONS, "mean", "count"))
        known = [f"{one}.{name}" for one, name in self._declared]
        if f"{table}.{column}" not in known:
            raise ParameterError(f"{table}.{column}: must be one of {', '.join(known)}")
        if where is not None and not isinstance(where, Mapping):
            raise ParameterTypeError(f"where = {where!r}: must be a mapping of columns to values")
        for name, wanted in (where or {}).items():
            if f"{table}.{name}" not in known:
                raise ParameterError(f"where: {table}.{name}: must be one of {', '.join(known)}")
            if not isinstance(wanted, (bool, int, float, np.number, np.bool_)):
                raise ParameterTypeError(
                    f"where: {table}.{name} = {wanted!r}: must be a number, True or False"
                )
            if (one := self._declared[table, name])["kind"] == "word" or one["each"]:
                raise ParameterError(
                    f"where: {table}.{name}: must be a column of single numbers or verdicts"
                )
        item = self._declared[table, column]
        if item["kind"] in ("complex", "word") or item["each"]:
            raise ParameterError(f"{table}.{column}: must be a column of single real numbers")
        found = self._array(np.nan)
        for first, name in self._chunks():
            columns = self._store.columns(name, table, ("case", column, *(where or {})))
            if not columns:
                continue
            cases = columns["case"].astype(int) + first
            values = columns[column].astype(float)
            there = ~np.isnan(values)
            for key, wanted in (where or {}).items():
                there &= columns[key] == wanted
            found_here, starts, counts = np.unique(
                cases[there], return_index=True, return_counts=True
            )
            values = values[there]
            if not len(values):
                continue
            if reduce == "first":
                found[found_here] = values[starts]
            elif reduce == "count":
                found[found_here] = counts
            elif reduce == "mean":
                found[found_here] = np.add.reduceat(values, starts) / counts
            else:
                found[found_here] = REDUCTIONS[reduce].reduceat(values, starts)
        return found.reshape(self.shape)

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of the sweep."""
        return (self.size,) if self.sweep is None else self.sweep.shape

    def to_xarray(
        self, table: str, column: str | None = None, reduce: str = "first",
        where: Mapping[str, Any] | None = None,
    ) -> Any:  # fmt: skip
        """The `values` as an xarray object with the values of the swept keys along its dimensions.

        Without a column: a dataset of all rows of the table, for all finished cases one after the other, where
        `case` is the case of each row and `owner` is the row of the parent table within this case. Shorter lists
        are padded with NaN, -1 (verdicts) or 0.

        Parameters
        ----------
        table : str
            Name of a table of the results.
        column : str, optional
            A column of the table, as in `values`; without it, all rows of the table.
        reduce : str
            How several rows of a case are reduced, as in `values`.
        where : mapping, optional
            Values that rows must have to be counted, as in `values`.

        Returns
        -------
        xarray.DataArray or xarray.Dataset
            The numbers of the column, or all rows of the table.
        """
        if column is None:
            return self._rows(table)
        values = self.values(table, column, reduce, where)
        item = self._declared[table, column]
        about = {"long_name": item["meaning"], "units": item["unit"] or "1", "reduction": reduce}
        if self.sweep is None:
            return xarray().DataArray(values, dims=["case"], name=column, attrs=about)
        axes = dict(zip(self.sweep.keys, self.sweep.axes, strict=True))
        if self.sweep._points is not None:
            points = {key: ("case", axis) for key, axis in axes.items()}
            return xarray().DataArray(values, points, ["case"], name=column, attrs=about)
        ends = {
            key: axis if np.ndim(axis) == 1 else list(map(str, axis)) for key, axis in axes.items()
        }
        return xarray().DataArray(values, ends, list(ends), name=column, attrs=about)

    def _rows(self, table: str) -> Any:
        """All rows of a table."""
        known = self._declared
        coded = {
            key for (one, key), item in known.items() if one == table and item["kind"] == "word"
        }
        cases: list[NDArray[Any]] = []
        parts: dict[str, list[Any]] = {}
        codes: dict[str, dict[str, int]] = {}
        for first, name in self._chunks():
            columns, words = self._store.table(name, table, coded)
            if not len(columns.get("case", ())):
                continue
            cases.append(columns["case"].astype(np.int64) + first)
            for key, values in columns.items():
                if key == "owner":
                    parts.setdefault(key, []).append(values)
                elif key != "case":
                    if key in coded:
                        values = recoded(words[key], values, codes.setdefault(key, {}))
                    whole = values if values.ndim == 2 else values[:, np.newaxis]
                    parts.setdefault(key, []).append((int(cases[-1][0]), whole))
        if not cases:  # a table without columns of its own is not declared
            checks.choice(table, "table", tuple(dict.fromkeys(one for one, _ in known)))
        row = f"{table}_row"
        data: dict[str, Any] = {}
        for key, given in parts.items():
            values = joined(self._declared, table, key, given, cases)
            if key == "owner":
                data[key] = (row, values, {"long_name": "row of the parent table within the case"})
                continue
            item = known[table, key]
            about = {"long_name": item["meaning"], "units": item["unit"] or "1"}
            if key in codes:
                values = np.array(["", *codes[key]], dtype=object)[values]
            dims = [row, f"{key}_item"][: values.ndim]
            if item["kind"] == "complex":
                data |= {
                    f"{key}_real": (dims, values.real, about),
                    f"{key}_imag": (dims, values.imag, about),
                }
            else:
                data[key] = (dims, values, about)
        found = np.concatenate(cases) if cases else np.empty(0, np.int64)
        return xarray().Dataset(data, {"case": (row, found, {"long_name": "number of the case"})})
