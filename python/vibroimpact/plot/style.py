"""The common style of all figures: colours that colour-blind readers can distinguish, symbols and units on
axes."""

from __future__ import annotations

import io
import math
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.errors import MissingExtraError
from ..base.files import write_bytes
from ..systems.oscillator import Oscillator
from ..systems.units import OF_STRUCTURE, SI, Units

#: The colours of Okabe and Ito.
PRIMARY, FREE, LOAD, IMPACT, REST = "#0072B2", "#D55E00", "#000000", "#CC79A7", "#009E73"
#: Colours of areas, attractors and motions, in order.
AREAS = (
    "#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#F0E442", "#332288", "#882255",
)  # fmt: skip
#: Widths of one and two columns of print, in inches.
ONE_COLUMN, TWO_COLUMNS = 3.5, 7.2

#: How parameters are written in the line above a figure.
SYMBOLS = {
    "xi": r"$\xi$", "mu": r"$\mu$", "R": "$R$", "R1": "$R_1$", "R2": "$R_2$", "r": "$r$",
    "clearance": "$dK/F_0$", "load": "load/$F_0$",
}  # fmt: skip

#: Labels of axes: a quantity, and its unit in brackets unless it is dimensionless.
R_LABEL, CLEARANCE_LABEL, LOAD_LABEL = r"$r = \Omega/\omega$", "$dK/F_0$", "$F_0/(dK)$"
ATTENUATION_LABEL = r"$\max|X|/A$"
FREQUENCY = r"load frequency $\Omega/2\pi$"
#: Symbols of parameters and columns on axes, and their dimensionless units.
NAMES = {
    "xi": r"$\xi$", "mu": r"$\mu$", "R1": "$R_1$", "R2": "$R_2$", "restitution": "$R$",
    "attenuation": ATTENUATION_LABEL, "x_max": r"$X_{\max}$", "x_min": r"$X_{\min}$", "tau": r"$\tau$",
    "largest": r"$\max|\lambda|$", "A": "$A$", "x": "$X$", "x_dot": r"$\dot X$", "y": "$Y$",
    "z_dot": r"$\dot Z$", "t": "$t$", "r": "$r$", "clearance": "$d$",
    "friction": "friction", "wall_stiffness": "wall stiffness", "wall_damping": "wall damping",
}  # fmt: skip
UNITS = {
    "x_max": "F0/K", "x_min": "F0/K", "tau": "rad", "A": "F0/K", "x": "F0/K", "y": "F0/K",
    "x_dot": "omega F0/K", "z_dot": "omega F0/K", "t": "1/omega", "clearance": "F0/K", "load": "F0",
    "friction": "F0", "wall_stiffness": "K", "wall_damping": "K/omega",
}  # fmt: skip

#: How dimensionless units are written.
DIMENSIONLESS = {
    "F0/K": "$F_0/K$", "omega F0/K": r"$\omega F_0/K$", "omega^2 F0/K": r"$\omega^2 F_0/K$", "F0": "$F_0$",
    "1/omega": r"$1/\omega$", "F0^2/K": "$F_0^2/K$", "K": "$K$", "K/omega": r"$K/\omega$",
}  # fmt: skip

SETTINGS = {
    "font.size": 8,
    "axes.labelsize": 8,
    "axes.linewidth": 0.6,
    "lines.linewidth": 1.0,
    "legend.frameon": False,
    "legend.fontsize": 7,
    "axes.spines.top": False,
    "axes.spines.right": False,
}
#: A legend above the axes, where it does not cover anything, in the font size of SETTINGS.
ABOVE = {
    "loc": "lower left", "bbox_to_anchor": (0.0, 1.0), "ncols": 3, "fontsize": 7, "frameon": False,
    "borderaxespad": 0.2, "columnspacing": 1.2, "handlelength": 2.6,
}  # fmt: skip


def add_legend(ax: Any, *entries: Any, **options: Any) -> Any:
    """Add a legend that is not clipped when the figure is saved at its own size.

    A legend that does not fit in the figure gets fewer columns; if that is not enough, it is placed within the
    axes. A layout engine makes room above and next to the axes, but not for a legend wider than the figure.
    """
    figure = ax.get_figure()
    laid_out = getattr(figure, "get_layout_engine", lambda: None)() is not None
    beside = options.get("bbox_to_anchor", (0, 0))[0] >= 1 and "left" in options.get("loc", "")
    options.setdefault("ncols", 1)
    for columns in range(options["ncols"], 0, -1):
        legend = ax.legend(*entries, **options | {"ncols": columns})
        box, room = legend.get_window_extent(), figure.bbox
        if laid_out and not beside and box.width > 0.6 * room.width:
            with (
                warnings.catch_warnings()
            ):  # from a layout engine that finds no room for so many columns
                warnings.simplefilter("ignore", UserWarning)
                figure.draw_without_rendering()  # which moves the axes
            box = legend.get_window_extent()
        wide = box.x0 < room.x0 or box.x1 > room.x1
        if laid_out and beside:
            wide = box.width > room.width
        if not wide and (laid_out or box.y1 <= room.y1):
            return legend
    inside = {"loc": "best", "ncols": 1, "bbox_to_anchor": None, "frameon": True, "framealpha": 0.8}
    return ax.legend(*entries, **options | inside | {"borderaxespad": 0.4, "fontsize": 6})


class Scales:
    """Numbers and labels of the axes of a picture, dimensionless or in physical units."""

    def __init__(self, units: Units | None, bare: bool = False) -> None:
        self.units = units
        #: Whether the labels have no units, as for a structure, whose numbers are in units that the user chooses.
        self.bare = bare

    def __call__(self, values: Any, unit: str) -> Any:
        """Values of a dimensionless unit in the unit of the picture."""
        units = self._units_for(unit)
        return values if units is None else values * units.scale(unit)

    def _units_for(self, unit: str) -> Units | None:
        """The units of a quantity: accelerations are in m/s^2 if lengths are in mm."""
        if self.units is None or unit != "omega^2 F0/K" or self.units.names != "mm N s":
            return self.units
        return self.units.to(SI)

    def r(self, values: Any) -> Any:
        """Frequency ratios, or frequencies."""
        return values if self.units is None else values * self.units.frequency

    def of(self, name: str, values: Any) -> Any:
        """Values of a parameter or a column by its name."""
        return self.r(values) if name == "r" else self(values, UNITS.get(name, ""))

    def unit(self, unit: str) -> str:
        """The name of the unit of the picture."""
        units = self._units_for(unit)
        return (
            DIMENSIONLESS.get(unit, unit) if units is None else units.name(unit).replace("^2", "²")
        )

    def label(self, symbol: str, unit: str) -> str:
        """The label of an axis: a quantity, and its unit in brackets unless it is dimensionless."""
        return f"{symbol} ({self.unit(unit)})" if unit and not self.bare else symbol

    def parameter(self, name: str, values: Any) -> tuple[Any, str]:
        """Values of a parameter of a structure, and the label of their axis."""
        unit, label = OF_STRUCTURE.get(name.split("_")[0], ""), parameter_label(name)
        if self.units is None or not unit:
            return values, label
        if unit == "omega":
            return values * self.units.frequency, self.name("r")
        return self(values, unit), self.label(label, unit)

    def frequency(self, omega: float) -> str:
        """A circular frequency of a structure as a text, in cycles per unit of time if that has a name."""
        if self.units is None:
            return rf"$\omega$ = {omega:.3g}"
        return f"{omega * self.units.frequency:.4g} {self.units.hertz}"

    def name(self, name: str) -> str:
        """The label of an axis of a parameter or a column by its name."""
        if name == "r":
            return R_LABEL if self.units is None else f"{FREQUENCY} ({self.units.hertz})"
        if name == "clearance":
            return (
                CLEARANCE_LABEL
                if self.units is None
                else self.label("clearance $d$, wall to wall", "F0/K")
            )
        return self.label(NAMES[name], UNITS.get(name, ""))

    def given(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Texts of the physical parameters among some dimensionless ones, with the load amplitude."""
        if self.units is None:
            return dict(values)
        texts = {}
        for name, value in values.items():
            if name in ("r", "clearance", "load") and value is not None and np.ptp(value) == 0:
                number = float(np.ravel(self.of(name, np.asarray(value)))[0])
                unit = self.units.hertz if name == "r" else self.unit(UNITS[name])
                symbol = {"r": r"$f$", "clearance": "$d$", "load": "$F_0$"}[name]
                texts[symbol] = f"{number:.6g} {unit}"
            elif name not in ("r", "clearance", "load"):
                texts[name] = value
        if "$F_0$" not in texts:
            texts["$F_0$"] = f"{self.units.F0:.6g} {self.unit('F0')}"
        return texts


class Plane(Scales):
    """Scales of the plane of frequency ratio and clearance; F0/(d K) remains dimensionless."""

    def __init__(self, units: Units | None, inverse: bool) -> None:
        super().__init__(units)
        self.inverse = inverse

    def gap(self, clearance: Any) -> Any:
        """Clearances as on the vertical axis."""
        return 1 / clearance if self.inverse else self(clearance, "F0/K")

    def label_axes(self, ax: Any) -> None:
        """Labels both axes."""
        ax.set_xlabel(self.name("r"))
        ax.set_ylabel(LOAD_LABEL if self.inverse else self.name("clearance"))


def system(osc: Oscillator) -> dict[str, float]:
    """The parameters of a system by name."""
    right, left = osc.restitution
    return {"xi": osc.xi, "mu": osc.mu, "R1": right, "R2": left}


def pyplot() -> Any:
    """matplotlib's pyplot, or an error that says how to install it."""
    try:
        import matplotlib.pyplot as plt
    except ImportError:
        raise MissingExtraError(
            "pictures need matplotlib: pip install 'vibroimpact[plot]'"
        ) from None
    return plt


def save(axes: Any, path: Path) -> Path:
    """Write the figure of some axes, in the format of the path's suffix, and close it."""
    figure = np.ravel(axes)[0].figure
    kind, content = path.suffix[1:], io.BytesIO()
    # without dates and random names, so that each run writes the same bytes
    dates = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
    with pyplot().rc_context({"svg.hashsalt": "vibroimpact"}):
        figure.savefig(content, format=kind, dpi=200, metadata=dates.get(kind))
    pyplot().close(figure)
    write_bytes(path, content.getvalue())
    return path


def identify(ax: Any, values: Mapping[str, Any], head: str = "") -> None:
    """A small line above a figure: its subject, and the parameters that are constant in it."""
    text = given(values)
    ax.figure.suptitle(f"{head}: {text}" if head else text, fontsize=7)


def given(values: Mapping[str, Any]) -> str:
    """Symbols and values of parameters, except those that vary or are None, and a load of F0."""
    texts = {name: value for name, value in values.items() if isinstance(value, str)}
    fixed = {
        name: float(np.ravel(value)[0])
        for name, value in values.items()
        if name not in texts and value is not None and np.ptp(value) == 0
    }  # fmt: skip
    if fixed.get("load") == 1:
        del fixed["load"]
    if "R1" in fixed and fixed["R1"] == fixed.get("R2"):
        fixed = {
            "R" if name == "R1" else name: item for name, item in fixed.items() if name != "R2"
        }
    shown = {SYMBOLS[name]: f"{value:.6g}" for name, value in fixed.items()}
    return ", ".join(f"{name} = {value}" for name, value in (shown | texts).items())


def is_geometric(values: NDArray[np.float64]) -> bool:
    """Whether the values of an axis are closer to a geometric than to an arithmetic sequence."""
    if values.size < 3 or values.min() <= 0 or np.ptp(values) == 0:
        return False
    steps, ratios = np.abs(np.diff(values)), np.abs(np.diff(np.log(values)))
    return bool(np.ptp(ratios) / ratios.mean() < np.ptp(steps) / steps.mean())


def log_scale(ax: Any, which: str) -> None:
    """A logarithmic axis ("x" or "y") with plain numbers, and as many ticks between the powers of ten as fit."""
    from matplotlib.ticker import FuncFormatter

    axis = getattr(ax, f"{which}axis")

    def minor(value: float, _: Any) -> str:
        low, high = sorted(axis.get_view_interval())
        decades = math.log10(high / low)
        shown = "" if decades > 2.7 else "25" if decades > 1.3 else "235"
        return plain(value) if decades < 0.7 or f"{value:e}"[0] in shown else ""

    getattr(ax, f"set_{which}scale")("log")
    axis.set_tick_params(which="minor", pad=5.0)  # numbers in one row for ticks of both lengths
    axis.set_major_formatter(FuncFormatter(lambda value, _: plain(value)))
    axis.set_minor_formatter(FuncFormatter(minor))


def plain(value: float) -> str:
    """A number on an axis; powers of ten only if there would be many zeros."""
    if 1e-3 <= value < 1e5:
        return f"{value:.6g}"
    power = math.floor(math.log10(value) + 1e-9)
    factor = f"{value / 10**power:.3g}"
    return rf"$10^{{{power}}}$" if factor == "1" else rf"${factor}\times10^{{{power}}}$"


def condition_name(kind: str) -> str:
    """The printed name of a bifurcation."""
    return kind.replace("neimark_sacker", "Neimark–Sacker").replace("_", " ")


#: Symbols of parameters, and of columns of a branch with a number.
PARAMETERS = {
    "frequency": r"$\Omega$", "load": "load factor", "constant": "factor of the constant forces",
    "damping": "factor of $C$", "stiffness": "factor of $K$", "opening": "$e$", "restitution": "$R$",
    "mass": "$M$", "function": "parameter", "clearance": "clearance $d$, wall to wall",
}  # fmt: skip


def parameter_label(name: str) -> str:
    """The label of an axis along a parameter."""
    word, *numbers = name.split("_")
    if not numbers:
        return PARAMETERS.get(word, name)
    symbol = {"damping": "C", "stiffness": "K", "mass": "M", "opening": "e", "restitution": "R"}
    return f"${symbol.get(word, word)}_{{{','.join(numbers)}}}$"
