"""The cases of a namelist file, read by the compiled reader and computed by Python."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import _core, door
from .errors import ParameterError
from .interchange.namelist import keys_of
from .model import Oscillator, Pattern
from .motion import Motion
from .newton import exact, newton
from .solve import equispaced, impact_restitution, periodic
from .studies.atlas import Atlas
from .studies.basins import Basins
from .studies.bifurcation import BifurcationDiagram
from .studies.branch import Branches
from .studies.chart import Chart
from .studies.decay import Decay
from .studies.find import Findings
from .studies.lyapunov import Lyapunov, with_exponents
from .studies.response import Response
from .studies.zone import Zone
from .trajectory import Trajectory, simulate

__all__ = ["Case", "read_namelist"]


#: Kinds of cases.
KINDS = (
    "periodic", "equispaced", "exact", "simulate", "find", "chart", "branch", "zone", "atlas", "lyapunov",
    "bifurcation", "response", "decay", "basins",
)  # fmt: skip


class Case(NamedTuple):
    """A case of a namelist file.

    Attributes
    ----------
    name : str
        Of the result.
    kind : str
        That of a &motion ("periodic", "equispaced", "exact"), else the name of the group.
    osc : Oscillator
    r : float or None
        Of a case that has several, None.
    keys : dict
        All other keys of its groups, with the values of those that were missing; of a branch also
        motion_kind, the kind of its &motion.
    text : str
        The complete case as a namelist, as the header of its result has it.
    """

    name: str
    kind: str
    osc: Oscillator
    r: Any
    keys: dict[str, Any]
    text: str

    @property
    def motion_kind(self) -> str:
        """The kind of the motion, also of that which a branch starts from."""
        kind: str = self.keys.get("motion_kind", self.kind)
        return kind

    def run(self, progress: Callable[[float, str], None] | None = None) -> list[Any]:
        """What the case asks for: its motions, branches, or one trajectory, zone, atlas or chart.

        `progress` is as of `atlas`, and for all but motions.
        """
        if self.kind in (
            "find", "chart", "atlas", "zone", "lyapunov", "bifurcation", "response", "decay", "basins",
        ):  # fmt: skip
            return [getattr(self, self.kind)(progress)]
        if self.kind == "simulate":
            return [self.trajectory(progress)]
        if self.kind in ("periodic", "equispaced", "exact"):
            return list(self.motions())
        return list(self.branches(progress))

    def to_namelist(self) -> str:
        """The case as a namelist, with what was missing filled in."""
        return self.text

    def motions(self) -> list[Motion]:
        """The motions that a &motion asks for, none if there is no such motion."""
        keys = self.keys
        if self.motion_kind == "equispaced":
            return equispaced(
                self.osc, self.r, keys["clearance"], keys["cycles"], keys["precision"]
            )
        pattern = Pattern(keys["sides"], keys["cycles"])
        if "positions" in keys:  # a whole motion as the guess
            each = impact_restitution(self.osc, pattern, keys.get("impact_restitution"))
            x, phases = np.array(keys["positions"]), np.array(keys["phases"])
            return [
                newton(
                    self.osc, self.r, keys["clearance"], 1.0, pattern, x, phases + keys["tau"], each
                )
            ]
        motion = periodic(
            self.osc, self.r, keys["phases"], pattern, keys.get("impact_restitution"),
            keys["precision"], keys.get("acceptance", 1.0),
        )  # fmt: skip
        if self.motion_kind == "exact":
            motion = exact(self.osc, self.r, keys["clearance"], motion)
        return [motion]

    def branches(self, progress: Callable[[float, str], None] | None = None) -> Branches:
        """The branches that a &branch case asks for, one for each of its motions that can be followed."""
        return door.run_text(Branches, self.text, progress=progress)

    def chart(self, progress: Callable[[float, str], None] | None = None) -> Chart:
        """The chart that a &chart case asks for."""
        return door.run_text(Chart, self.text, progress=progress)

    def zone(self, progress: Callable[[float, str], None] | None = None) -> Zone:
        """The zone that a &zone case asks for."""
        return door.run_text(Zone, self.text, progress=progress)

    def atlas(self, progress: Callable[[float, str], None] | None = None) -> Atlas:
        """The atlas that an &atlas case asks for."""
        return door.run_text(Atlas, self.text, progress=progress)

    def lyapunov(self, progress: Callable[[float, str], None] | None = None) -> Lyapunov:
        """The exponents that a &lyapunov case asks for."""
        return with_exponents(door.run_text(Lyapunov, self.text, progress=progress))

    def bifurcation(
        self, progress: Callable[[float, str], None] | None = None
    ) -> BifurcationDiagram:
        """The diagram that a &bifurcation case asks for."""
        return door.run_text(BifurcationDiagram, self.text, progress=progress)

    def response(self, progress: Callable[[float, str], None] | None = None) -> Response:
        """The response that a &response case asks for."""
        return door.run_text(Response, self.text, progress=progress)

    def find(self, progress: Callable[[float, str], None] | None = None) -> Findings:
        """The motions at a point that a &find case asks for."""
        return door.run_text(Findings, self.text, progress=progress)

    def decay(self, progress: Callable[[float, str], None] | None = None) -> Decay:
        """The free vibrations that a &decay case asks for."""
        return door.run_text(Decay, self.text, progress=progress)

    def basins(self, progress: Callable[[float, str], None] | None = None) -> Basins:
        """The basins that a &basins case asks for."""
        return door.run_text(Basins, self.text, progress=progress)

    def _state(self) -> dict[str, float]:
        """The initial state."""
        return {name: self.keys[name] for name in ("t", "x", "x_dot", "z", "z_dot")}

    def trajectory(self, progress: Callable[[float, str], None] | None = None) -> Trajectory:
        """The simulation that a &simulate case asks for."""
        keys = self.keys
        return simulate(
            self.osc, self.r, keys["clearance"], keys["cycles"], self._state(), keys["load"],
            keys["discard"], keys["max_events"], progress,
        )  # fmt: skip


def read_namelist(path: str | os.PathLike[str]) -> list[Case]:
    """The cases of a namelist file, read by the compiled reader, which also fills in what is missing.

    Parameters
    ----------
    path : path
        A file with the groups &system, &motion, … (see inputs/README.md), or an earlier result.

    Returns
    -------
    list of Case
        Each with `run`, which gives the motions, branches, trajectory, zone, atlas or chart with the
        digits that `run_namelists` writes.

    Raises
    ------
    ParameterError
        If the file is wrong: file, line, key, value and what is allowed.

    Examples
    --------
    >>> import pathlib, tempfile, vibroimpact as vi
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "pair.nml"
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> _ = path.write_text(vi.equispaced(osc, r=0.94, clearance=37.0)[0].to_namelist())
    >>> (case,) = vi.read_namelist(path)
    >>> case.run()
    [<Motion RL/1 at r = 0.94, ...unstable...>, <Motion RL/1 at r = 0.94, ...unstable...>]
    """
    name = path_bytes(path)
    capacity = 65_536 + 40 * (Path(path).stat().st_size if os.path.isfile(path) else 0)
    text, length, status = _core.read_namelist(characters(name), capacity)
    if length > capacity:
        text, length, status = _core.read_namelist(characters(name), length)
    said = os.fsdecode(text[:length].tobytes())
    if status:
        raise ParameterError(said)
    cases: list[dict[str, Any]] = []
    # the reader gives each case as the header of its result has it: one `# key = value` a line
    for line in said.split("\n"):
        if line.startswith("# &system"):
            cases.append({"text": ""})
        if cases and not line.startswith("# !"):
            cases[-1]["text"] += line[2:] + "\n"
    return [_case(keys_of(item["text"]) | item) for item in cases]


def _case(keys: dict[str, Any]) -> Case:
    name, kind, xi, mu, walls, r, text = (
        keys.pop(key, None) for key in ("name", "kind", "xi", "mu", "restitution", "r", "text")
    )
    return Case(name, kind, Oscillator(xi, mu, tuple(walls)), r, keys, text.strip("\n") + "\n")


def path_bytes(path: str | os.PathLike[str]) -> bytes:
    """A path as the compiled reader takes it."""
    name = os.fsencode(path)
    if not name or b"\n" in name or b"\0" in name:
        raise ParameterError(f"path = {os.fsdecode(name)!r}: must not be empty or hold a line feed")
    return name


def characters(text: bytes) -> NDArray[np.bytes_]:
    return np.frombuffer(text, "S1")
