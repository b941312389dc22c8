"""Stable periodic motions of a vibrating system in which a free mass collides with its walls."""

from collections.abc import Callable as _Callable
from importlib import import_module as _import_module
from importlib.metadata import version as _version

from .base import errors
from .base.errors import (
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
from .base.spacing import spaced
from .base.status import status_text
from .campaigns.campaign import Campaign
from .campaigns.run import campaign
from .campaigns.sweep import Sweep
from .cases.case import Case, read_namelist
from .cases.run import run_namelists
from .designs.design import Design, design
from .formats.load import load
from .identification.identify import Identification, identify
from .identification.measured import SensorRecord, VirtualRig, virtual_record
from .identification.sensor_files import read_record
from .motions.bundle import Bundle, simulate_bundle
from .motions.exact import exact
from .motions.flags import StabilityFlags, stability_flags
from .motions.likeness import is_symmetric, motion_images, same_motion, standard_motion
from .motions.motion import Motion, Motions
from .motions.periodic import equispaced, equispaced_batch, linear_system, periodic, periodic_batch
from .motions.quantities import Quantities
from .motions.trajectory import Trajectory, simulate
from .physical import Physical, physical
from .results.events import Sample
from .results.gradient import Gradient
from .results.noun import ACTIONS as _ACTIONS
from .studies.atlas import Atlas, SurveyPoint, atlas
from .studies.basins import Attractor, Basins, basins
from .studies.bifurcation import BifurcationDiagram, bifurcation_diagram
from .studies.boundary_band import BoundaryBand, boundary_bands
from .studies.branch import Branch, SpecialPoint, branch
from .studies.chart import Chart, chart
from .studies.decay import Decay, decay
from .studies.find import FoundMotions, find
from .studies.lyapunov import Lyapunov, lyapunov
from .studies.response import Response, response
from .studies.uncertainty import LimitProbability, Uncertainty, limit_probability, uncertainty
from .studies.zone import Piece, Zone, zone
from .systems.excitations import half_sine, swept_sine
from .systems.oscillator import Oscillator, Pattern, Point
from .systems.record import Record, base_motion, base_record
from .systems.restitution import PowerLaw, TabulatedRestitution
from .systems.structure import Gap, Load, Structure
from .systems.units import Units

__version__ = _version("vibroimpact")

__all__ = [
    "Atlas",
    "Attractor",
    "Basins",
    "BifurcationDiagram",
    "BoundaryBand",
    "Branch",
    "Bundle",
    "Campaign",
    "Case",
    "Chart",
    "ClusterError",
    "Decay",
    "Design",
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
    "Physical",
    "Piece",
    "Point",
    "PowerLaw",
    "Quantities",
    "Record",
    "Response",
    "Sample",
    "SensorRecord",
    "SingularError",
    "SpecialPoint",
    "StabilityFlags",
    "Structure",
    "StudyInterrupted",
    "SurveyPoint",
    "Sweep",
    "TabulatedRestitution",
    "Trajectory",
    "Uncertainty",
    "Units",
    "VibroimpactError",
    "VirtualRig",
    "Zone",
    "atlas",
    "base_motion",
    "base_record",
    "basins",
    "bifurcation_diagram",
    "boundary_bands",
    "branch",
    "campaign",
    "chart",
    "decay",
    "design",
    "equispaced",
    "equispaced_batch",
    "errors",
    "exact",
    "find",
    "half_sine",
    "identify",
    "is_symmetric",
    "limit_probability",
    "linear_system",
    "load",
    "lyapunov",
    "motion_images",
    "periodic",
    "periodic_batch",
    "physical",
    "read_namelist",
    "read_record",
    "response",
    "run_namelists",
    "same_motion",
    "simulate",
    "simulate_bundle",
    "spaced",
    "stability_flags",
    "standard_motion",
    "status_text",
    "swept_sine",
    "uncertainty",
    "virtual_record",
    "zone",
]


def _later(place: str) -> _Callable[..., object]:
    """Return a function of a module that is imported when the function is called for the first time."""
    module, name = place.split(":")
    return lambda *arguments: getattr(_import_module(module, __name__), name)(*arguments)


_ACTIONS.update(
    motion_gradient=_later(".derivatives.period_gradient:oscillator_gradient"),
    trajectory_gradient=_later(".derivatives.gradient:trajectory_gradient"),
    structure_motion_gradient=_later(".derivatives.structure_gradient:structure_gradient"),
    structure_trajectory_gradient=_later(
        ".derivatives.structure_gradient:structure_trajectory_gradient"
    ),
    draw=_later(".plot.pictures:draw_result"),
    animate=_later(".plot.animation:animate"),
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
