"""The public names, and where they are: the package imports each when it is used for the first time."""

from .base import errors
from .base.errors import (
    ClusterError,
    MissingExtraError,
    OpenBoundaryWarning,
    OutOfMemoryError,
    ParameterError,
    ParameterTypeError,
    PoorFitWarning,
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
from .identification.measured import SensorRecord
from .identification.sensor_files import read_record
from .identification.virtual_rig import VirtualRig, virtual_record
from .motions.bundle import Bundle, simulate_bundle
from .motions.exact import exact
from .motions.flags import StabilityFlags, stability_flags
from .motions.likeness import is_symmetric, motion_images, same_motion, standard_motion
from .motions.motion import Motion, Motions
from .motions.periodic import equispaced, equispaced_batch, linear_system, periodic, periodic_batch
from .motions.quantities import Quantities
from .motions.trajectory import Trajectory, simulate
from .physical_results import Physical, physical
from .proofs.certificate import Certificate
from .proofs.complete import prove_all
from .proofs.prove import prove_box
from .results.events import Sample
from .results.gradient import Gradient
from .studies.atlas import Atlas, SurveyMotion, SurveyPoint, atlas
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
from .systems.structure import Friction, Gap, Load, Stop, Structure
from .systems.units import Units

__version__: str

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
    "Certificate",
    "Chart",
    "ClusterError",
    "Decay",
    "Design",
    "FoundMotions",
    "Friction",
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
    "PoorFitWarning",
    "PowerLaw",
    "Quantities",
    "Record",
    "Response",
    "Sample",
    "SensorRecord",
    "SingularError",
    "SpecialPoint",
    "StabilityFlags",
    "Stop",
    "Structure",
    "StudyInterrupted",
    "SurveyMotion",
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
    "prove_all",
    "prove_box",
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
