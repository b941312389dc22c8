"""Certificates: proven statements about motions, with the exact numbers needed to check them independently."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from ..base import checks
from ..base.actions import ACTIONS
from ..base.errors import ParameterError
from ..base.files import place_for, write_text
from ..base.jupyter import facts_html
from ..results.noun import NOUNS
from .balls import exact
from .form import ITEMS, VERDICTS, check_form

__all__ = ["Certificate"]

#: The format of the JSON.
FORMAT = 1


@dataclass(frozen=True, repr=False)
class Certificate:
    """What is proven about one motion, or about the motions for all parameters in some boxes.

    Certificates come from `Motion.prove`, `Branch.prove`, `Zone.prove`, `prove_box` and `prove_all`. They hold for
    the decimal texts of the parameters: 0.028 is the rational number 28/1000 and not the nearest double. All
    numbers in the JSON are exact, and the bounds include every rounding error of the computation (ball arithmetic
    of FLINT).

    Attributes
    ----------
    kind : str
        "motion", "branch", "box", "zone" or "all".
    sides : str
    cycles : int
        The word of the motion and the load cycles in its period; for "all", the words and the largest number of
        load cycles. For a motion of a structure, the word consists of the numbers of the gaps of all impacts.
    symmetric : bool
        Whether the motions are their own mirror images half a period later, and are proven over that half.
    system : dict
        The texts of xi, mu, r, clearance and load, and of restitution, a list with one text for each impact; for
        "all", one for the right and one for the left wall. For a structure: mass, damping, stiffness, gaps
        (direction, opening, restitution), frequency, sine, cosine and constant of the load, and impacts: the gap
        of each.
    sheets : list of dict
        The regions that the boxes cover: (lowest, highest) of each parameter that varies, as texts. For a motion,
        one empty region; for a branch, one for each part between folds. For a zone, r and tan(theta), for
        cos(theta) > 0 and for cos(theta) < 0, where A sin(theta) is the steady motion at an impact on the right
        wall. For "all", the ``sides`` and ``cycles`` of each word.
    boxes : list of dict
        ``sheet``, the number of the region, and ``parameters``, the part of the region; ``centre``, psi, X, X', Z'
        just after each impact (for a structure t, q, q'), as coefficients of polynomials in the parameters on [-1,
        1], and ``radius``, the distance from the centre within which there is one and only one motion (with
        `symmetric` one and only one symmetric motion); ``exists, admissible, stable``, True, False or None;
        ``multipliers_below`` or ``multipliers_above``, bounds of max|lambda|, and ``attenuation_below``, a bound
        of max|x|/A; None where they are not proven.
    undecided : list of dict
        ``reason``: what is not proven, and why; ``parameters``: where this is so. For "all", the ``times`` between
        impacts, as fractions of the period, for which there may be other motions of the word ``sheet``.
    seconds : float
        Computing time.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    >>> motion = vi.exact(osc, 1.04, 25.0, vi.simulate(osc, r=1.04, clearance=25.0, cycles=100, discard=500))
    >>> proof = motion.prove()
    >>> proof.stable, proof.admissible, proof.attenuation_bound
    (True, True, 0.5424)
    """

    kind: str
    sides: str
    cycles: int
    symmetric: bool
    system: dict[str, Any]
    sheets: list[dict[str, Any]]
    boxes: list[dict[str, Any]]
    undecided: list[dict[str, Any]] = field(default_factory=list)
    seconds: float = 0.0

    def _all(self, name: str) -> Any:
        """The value that all boxes share; None if it differs between boxes or is not proven in all of them."""
        values = [box.get(name) for box in self.boxes]
        same = values and values.count(values[0]) == len(values)
        return values[0] if same else None

    @property
    def exists(self) -> bool | None:
        """True: there is exactly one motion within the radii, for all parameters. None: not decided."""
        found: bool | None = self._all("exists")
        return found

    @property
    def admissible(self) -> bool | None:
        """Whether the masses approach at each impact and both gaps stay open in between; None: not decided."""
        found: bool | None = self._all("admissible")
        return found

    @property
    def stable(self) -> bool | None:
        """True: all multipliers lie inside the unit circle. False: one lies outside. None: not decided."""
        found: bool | None = self._all("stable")
        return found

    @property
    def proven(self) -> bool:
        """Whether an admissible, stable motion is proven, for all parameters."""
        return self.exists is True and self.admissible is True and self.stable is True

    @property
    def complete(self) -> bool:
        """For all motions at a point: whether no others of the words, with an approach at each impact, exist."""
        return self.kind == "all" and not any("times" in item for item in self.undecided)

    def _bound(self, name: str) -> float | None:
        """The largest bound of the boxes, rounded to a double."""
        texts: list[Any] = [box.get(name) for box in self.boxes]
        return float(max(map(exact, texts))) if texts and None not in texts else None

    @cached_property
    def _plane(self) -> Any:
        """The boxes of a certificate of a zone, in the plane (r, d K/F0)."""
        if self.kind != "zone":
            raise AttributeError(f"kind = {self.kind!r}: only certificates of zones have this")
        return ACTIONS["plane_of"](self)

    def decide(self, r: float, clearance: float) -> bool | None:
        """For a zone: whether a stable, admissible motion is proven to exist at a point.

        Parameters
        ----------
        r, clearance : float
            Frequency ratio and d K/F0.

        Returns
        -------
        bool or None
            True if such a motion is proven to exist, False if it is proven that there is none; None if neither is
            proven, and outside the window.
        """
        place = checks.finite(r, "r"), checks.finite(clearance, "clearance")
        found: bool | None = self._plane.decide(*place)
        return found

    def shares(self) -> dict[str, float]:
        """For a zone: the fractions of the window (r, log D) "inside", "outside" and "undecided".

        Returns
        -------
        dict of float
            The three fractions by name, summed along lines; together they are 1.
        """
        found: dict[str, float] = self._plane.shares()
        return found

    def plot(self, ax: Any = None) -> Any:
        """Draw a certificate of a zone: areas proven to be inside, proven to be outside, and undecided.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Axes to draw on; by default those of a new figure.

        Returns
        -------
        Axes
            The Axes with the picture.
        """
        return ACTIONS["draw"](self, ax)

    @property
    def multiplier_bound(self) -> float | None:
        """A strict upper bound of max|lambda| of a stable motion."""
        return self._bound("multipliers_below")

    @property
    def attenuation_bound(self) -> float | None:
        """An upper bound of max|x|/A of an admissible motion."""
        return self._bound("attenuation_below")

    def _places(self) -> str:
        """The intervals of the parameters that vary, and the number of boxes; empty if none varies."""
        places = dict.fromkeys(
            f"{name} {float(exact(low)):.10g} to {float(exact(high)):.10g}"
            for sheet in self.sheets for name, (low, high) in sheet.items()
        )  # fmt: skip
        number = f"{len(self.boxes)} box{'es' * (len(self.boxes) != 1)}"
        return f"for {', '.join(places)} in {number}" if places else ""

    def __repr__(self) -> str:
        words = []
        for name, word in zip(VERDICTS, ("exists", "admissible", "stable"), strict=True):
            verdict = getattr(self, name)
            words.append(
                f"{word} not decided" if verdict is None else word if verdict else f"not {word}"
            )
        bound = self.multiplier_bound
        if self.stable and bound is not None:
            words[-1] += f" (max|lambda| < {bound:.10g})"
        if "mass" in self.system:
            gaps = f"gap{'s' * (' ' in self.sides)} {self.sides}"
            cycles = f"{self.cycles} cycle{'s' * (self.cycles != 1)}"
            place = self._places() or f"at Omega = {self.system['frequency']}"
            return f"<Certificate of impacts on {gaps} in {cycles} {place}: {', '.join(words)}>"
        place = f"at r = {self.system['r']}, d K/F0 = {self.system['clearance']}"
        if self.kind == "all":
            orders = ", ".join(f"{sheet['sides']}/{sheet['cycles']}" for sheet in self.sheets)
            good = sum(bool(box["stable"] and box["admissible"]) for box in self.boxes)
            ending = "complete" if self.complete else "there may be others"
            return (
                f"<Certificate of all motions {orders} {place}: {len(self.boxes)}, of them {good} stable and "
                f"admissible; {ending}>"
            )
        if self.kind == "zone":
            shares = ", ".join(
                f"{name} {100 * share:.2f} %" for name, share in self.shares().items()
            )
            (low, high), (small, large) = self.system["r"], self.system["clearance"]
            place = f"r {low} to {high}, d K/F0 {small} to {large}"
            return f"<Certificate of the zone of {self.sides}/{self.cycles}, {place}: {shares}>"
        place = self._places() or place
        return f"<Certificate of {self.sides}/{self.cycles} {place}: {', '.join(words)}>"

    def _repr_html_(self) -> str:
        """The representation in Jupyter."""
        words = {True: "proven", False: "refuted", None: "not decided"}
        facts = {}
        if self.kind == "zone":
            facts = {name: f"{100 * share:.2f} %" for name, share in self.shares().items()}
        elif self.kind == "all":
            facts = {"motions": str(len(self.boxes)), "complete": words[self.complete or None]}
        else:
            facts = {name: words[getattr(self, name)] for name in VERDICTS}
        for name, symbol in (("multiplier_bound", "max|λ| <"), ("attenuation_bound", "max|x|/A <")):
            if (bound := getattr(self, name)) is not None:
                facts[symbol] = f"{bound:.10g}"
        facts["time"] = f"{self.seconds:.3g} s"
        if self.undecided:
            facts["not decided"] = "; ".join(item["reason"] for item in self.undecided)
        return facts_html(repr(self), facts)

    def to_dict(self) -> dict[str, Any]:
        """All attributes as plain Python values, ready for JSON; exact numbers are strings.

        Returns
        -------
        dict
            The attributes by name.
        """
        return {"type": "Certificate", "format": FORMAT} | {
            name: getattr(self, name) for name in ITEMS
        }

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> Certificate:
        """The inverse of `to_dict`.

        Parameters
        ----------
        data : dict
            What `to_dict` returned.

        Returns
        -------
        Certificate
            An equal certificate.
        """
        if not isinstance(data, dict) or data.get("type") != "Certificate":
            raise ParameterError("certificate: must be a dict with type = 'Certificate'")
        if data.get("format") != FORMAT:
            raise ParameterError(f"format = {data.get('format')!r}: must be {FORMAT}")
        check_form(data)
        found = {name: data[name] for name in ITEMS}
        return cls(**found | {"seconds": float(data["seconds"])})

    def to_json(self) -> str:
        """`to_dict` as JSON text.

        Returns
        -------
        str
            One JSON object.
        """
        return json.dumps(self.to_dict(), indent=1, ensure_ascii=False) + "\n"

    @classmethod
    def from_json(cls, text: str) -> Certificate:
        """The inverse of `to_json`.

        Parameters
        ----------
        text : str
            What `to_json` returned.

        Returns
        -------
        Certificate
            An equal certificate.
        """
        try:
            data = json.loads(text)
        except (ValueError, RecursionError) as error:
            raise ParameterError(f"text = {text!r:.80}: must be JSON; {error}") from None
        return cls.from_dict(data)

    def save(self, path: str | Path) -> None:
        """Write a .json file, completely or not at all; `vibroimpact.load` reads it back.

        Parameters
        ----------
        path : str or Path
            The file.
        """
        write_text(place_for(path, {".json": None}), self.to_json())


NOUNS["Certificate"] = Certificate  # type: ignore[assignment]
