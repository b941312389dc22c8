"""Stable periodic motions of a vibrating system in which a free mass collides with its walls."""

from collections.abc import Callable as _Callable
from importlib import import_module as _import_module
from importlib.metadata import version as _version

from . import errors
from .bundle import Bundle, simulate_bundle
from .campaigns.campaign import Campaign
from .campaigns.run import campaign
from .campaigns.sweep import Sweep
from .case import Case, read_namelist
from .errors import (
    ClusterError,
    MissingExtraError,
    OpenBoundaryWarning,
    OutOfMemoryError,
    ParameterError,
    ParameterTypeError,
    SingularError,
    StudyInterrupted,
    VibroimpactError,
)
from .events import Sample
from .excitations import half_sine, swept_sine
from .flags import StabilityFlags, stability_flags
from .formats.load import load
from .formats.measured import read_record
from .gradient import Gradient
from .likeness import is_symmetric, motion_images, same_motion, standard_motion
from .measured import SensorRecord, VirtualRig, virtual_record
from .model import Oscillator, Pattern
from .motion import Motion, Motions
from .newton import exact
from .noun import ACTIONS as _ACTIONS
from .period import Period
from .physical import Physical, physical
from .quantities import Quantities, Signal
from .record import Record, base_motion, base_record
from .restitution import PowerLaw, TabulatedRestitution
from .run import RunLog, run_namelists
from .solve import equispaced, equispaced_batch, linear_system, periodic, periodic_batch
from .spacing import spaced
from .status import status_text
from .structure import Gap, Load, Structure
from .structure_branch import StructureBranch, StructureSpecialPoint, branch_structure
from .structure_find import StructureMotions, find_structure, same_structure_motion
from .structure_motion import StructureMotion, exact_structure, periodic_structure
from .structure_quantities import StructureQuantities
from .structure_trajectory import StructureTrajectory, simulate_structure
from .structure_zone import StructurePiece, StructureZone, zone_structure
from .studies.atlas import Atlas, Attractor, atlas
from .studies.basins import BasinAttractor, Basins, basins
from .studies.bifurcation import BifurcationDiagram, PeriodicWindow, bifurcation_diagram
from .studies.boundary_band import BoundaryBand, boundary_bands
from .studies.branch import Branch, Branches, SpecialPoint, branch
from .studies.chart import Chart, chart
from .studies.decay import Decay, decay
from .studies.design import Design, design
from .studies.find import Findings, FoundMotions, Search, find
from .studies.identify import Identification, identify
from .studies.lyapunov import Lyapunov, lyapunov
from .studies.response import Response, response
from .studies.structure_basins import StructureAttractor, StructureBasins, basins_structure
from .studies.structure_lyapunov import StructureLyapunov, lyapunov_structure
from .studies.structure_sweep import (
    StructureBifurcation,
    StructureResponse,
    bifurcation_structure,
    response_structure,
)
from .studies.uncertainty import LimitProbability, Uncertainty, limit_probability, uncertainty
from .studies.zone import Piece, Zone, ZoneSearch, zone
from .trajectory import Trajectory, simulate
from .units import Units

__version__ = _version("vibroimpact")

__all__ = [
    "Atlas",
    "Attractor",
    "BasinAttractor",
    "Basins",
    "BifurcationDiagram",
    "BoundaryBand",
    "Branch",
    "Branches",
    "Bundle",
    "Campaign",
    "Case",
    "Chart",
    "ClusterError",
    "Decay",
    "Design",
    "Findings",
    "FoundMotions",
    "Gap",
    "Gradient",
    "Identification",
    "LimitProbability",
    "Load",
    "Lyapunov",
    "MissingExtraError",
    "Motion",
    "Motions",
    "OpenBoundaryWarning",
    "Oscillator",
    "OutOfMemoryError",
    "ParameterError",
    "ParameterTypeError",
    "Pattern",
    "Period",
    "PeriodicWindow",
    "Physical",
    "Piece",
    "PowerLaw",
    "Quantities",
    "Record",
    "Response",
    "RunLog",
    "Sample",
    "Search",
    "SensorRecord",
    "Signal",
    "SingularError",
    "SpecialPoint",
    "StabilityFlags",
    "Structure",
    "StructureAttractor",
    "StructureBasins",
    "StructureBifurcation",
    "StructureBranch",
    "StructureLyapunov",
    "StructureMotion",
    "StructureMotions",
    "StructurePiece",
    "StructureQuantities",
    "StructureResponse",
    "StructureSpecialPoint",
    "StructureTrajectory",
    "StructureZone",
    "StudyInterrupted",
    "Sweep",
    "TabulatedRestitution",
    "Trajectory",
    "Uncertainty",
    "Units",
    "VibroimpactError",
    "VirtualRig",
    "Zone",
    "ZoneSearch",
    "atlas",
    "base_motion",
    "base_record",
    "basins",
    "basins_structure",
    "bifurcation_diagram",
    "bifurcation_structure",
    "boundary_bands",
    "branch",
    "branch_structure",
    "campaign",
    "chart",
    "decay",
    "design",
    "equispaced",
    "equispaced_batch",
    "errors",
    "exact",
    "exact_structure",
    "find",
    "find_structure",
    "half_sine",
    "identify",
    "is_symmetric",
    "limit_probability",
    "linear_system",
    "load",
    "lyapunov",
    "lyapunov_structure",
    "motion_images",
    "periodic",
    "periodic_batch",
    "periodic_structure",
    "physical",
    "read_namelist",
    "read_record",
    "response",
    "response_structure",
    "run_namelists",
    "same_motion",
    "same_structure_motion",
    "simulate",
    "simulate_bundle",
    "simulate_structure",
    "spaced",
    "stability_flags",
    "standard_motion",
    "status_text",
    "swept_sine",
    "uncertainty",
    "virtual_record",
    "zone",
    "zone_structure",
]


def _later(place: str) -> _Callable[..., object]:
    """Return a function of a module that is imported when the function is called for the first time."""
    module, name = place.split(":")
    return lambda *arguments: getattr(_import_module(module, __name__), name)(*arguments)


_ACTIONS.update(
    draw=_later(".plot.pictures:draw_result"),
    animate=_later(".plot.pictures:animate_result"),
    thumbnail=_later(".plot.thumbnail:thumbnail"),
    report=_later(".plot.design:report"),
    html=_later(".formats.html:html"),
    to_dict=_later(".formats.record:to_dict"),
    from_dict=_later(".formats.record:from_dict"),
    to_json=_later(".formats.record:to_json"),
    from_json=_later(".formats.record:from_json"),
    to_xarray=_later(".formats.dataset:to_xarray"),
    to_pandas=_later(".formats.rows:to_pandas"),
    save=_later(".formats.save:save"),
    load=load,
    physical=physical,
)


def __dir__() -> list[str]:
    """The public names, without the modules that hold them."""
    return sorted([*__all__, "__version__"])
