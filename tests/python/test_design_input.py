"""Invalid arguments of a design are refused, each with one message."""

import math
import sys

import pytest
import vibroimpact as vi
from scipy import stats
from shared_design import GOOD, OSC, QUICK

#: Arguments that have no meaning for free vibration, at their defaults.
FREE = {"load": 1.0, "settling": 400, "keep": 32}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"r": (1.0, 1.01, 1.02)},
            "r = 1.0, 1.01, 1.02: must be one frequency ratio, or the lowest and the highest one",
        ),
        ({"r": (0, 1)}, "r = 0"),
        ({"r": "1"}, "r = '1'"),
        ({"r": (1, math.nan)}, "r = "),
        ({"free": {}}, "free = {}"),
        ({"free": {"gap": (1, 2)}}, "unknown parameter 'gap'"),
        (
            {"free": {"clearance": 20}},
            r"free\['clearance'\] = 20.0: must be two numbers from 1e-12 to 1e12",
        ),
        ({"free": {"clearance": (-1, 2)}}, r"free\['clearance'\] = -1.0, 2.0: must be two numbers"),
        ({"free": 3}, "free = 3: must be a dict"),
        (
            {"free": {"restitution": (0.5, 0.6), "R1": (0.5, 0.6)}, "clearance": 20.0},
            "must be left out if",
        ),
        (
            {"tolerance": {"clearance": (-30, 0)}},
            r"tolerance\['clearance'\] = -30.0, 0.0: .* in the range of clearance",
        ),
        (
            {"tolerance": {"restitution": (0.9, 1.2)}},
            r"tolerance\['restitution'\] = 0.9, 1.2: .* in the range",
        ),
        (
            {
                "free": {"R1": (0.3, 0.9)},
                "tolerance": {"restitution": (0.5, 0.7)},
                "clearance": 20.0,
            },
            r"free\['R1'\] = 0.3, 0.9: must be left out if tolerance_restitution is given",
        ),
        (
            {
                "free": {"restitution": (0.3, 0.9)},
                "tolerance": {"R2": (0.5, 0.7)},
                "clearance": 20.0,
            },
            r"tolerance\['R2'\] = 0.5, 0.7: must be left out if free_restitution is given",
        ),
        (
            {"target": "damping", "r": None, "amplitude": 1.0, "limits": {"speed": 1.0}, **FREE},
            r"limits\['speed'\] = 1.0: must be left out if amplitude is given",
        ),
        *(
            (
                {"target": "damping", "r": None, "amplitude": 1.0, **FREE, name: value},
                rf"{name} = .*: must be left out if amplitude is given",
            )
            for name, value in (("load", (0.5, 2.0)), ("settling", 300), ("keep", 5))
        ),
        ({"cycles": 6}, "cycles = 6: must be left out: it requires amplitude"),
        *(
            (
                {"tolerance": {"clearance": values}},
                r"tolerance\['clearance'\] = .*deviations with 0 among",
            )
            for values in (
                (0.5, 0.9),
                (1.1, 1.2),
                (-2, -1),
                stats.norm(1.0, 0.2),
                stats.norm(0.5, 0.2),
            )
        ),
        ({"tolerance": {"xi": (0.0, 0.01)}}, "without damping r = 1 is resonance"),
        ({"progress": 3}, "progress = 3: must be None or callable"),
        ({"tolerance": {"xi": (0.02, 0.01)}}, "low <= high"),
        ({"tolerance": {"xi": stats.norm(0.01, 0.01)}}, "6 standard deviations"),
        ({"clearance": 20.0}, "clearance = 20.0: must be left out if free_clearance is given"),
        ({"free": {"mu": (0.02, 0.1)}}, "clearance: is missing"),
        ({"amplitude": 1.0}, "must be left out if"),
        ({"target": "damping"}, "needs an amplitude"),
        ({"load": 0}, "load = 0"),
        ({"target": "noise"}, "target = 'noise'"),
        ({"over": "all"}, "over = 'all'"),
        ({"quantile": 0.2}, "quantile = 0.2"),
        ({"quantile": math.nan}, "quantile = nan"),
        ({"limit": -1}, "limit = -1"),
        ({"limits": {"noise": 1}}, "noise"),
        ({"limits": {"speed": math.inf}}, r"limits\['speed'\] = inf"),
        ({"states": 0}, "states = 0"),
        ({"samples": 5}, "samples = 5"),
        ({"evaluations": 1.5}, "evaluations = 1.5"),
        ({"rng": -1}, "rng = -1"),
        ({"nodes": 1}, "nodes = 1"),
    ],
)
def test_bad_arguments_are_refused(change, message):
    with pytest.raises((vi.ParameterError, vi.ParameterTypeError), match=message):
        vi.design(OSC, **{**GOOD, **QUICK, **change})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"amplitude": 1.0}, "amplitude = 1.0: must be left out for a function"),
        ({"cycles": 7}, "cycles = 7: must be left out for a function"),
        ({"tolerance": {"clearance": (1.5, 2.0)}}, "deviations with 0 among them"),
        ({"tolerance": {"clearance": stats.norm(1, 0.2)}}, "if normal, with mean 0 or 1"),
    ],
)
def test_bad_arguments_for_a_structure_are_refused(change, message):
    with pytest.raises(vi.ParameterError, match=message):
        vi.design(lambda r, load, clearance: None, **{**GOOD, **QUICK, **change})


def test_all_tolerances_may_be_normal(tmp_path):
    """The names of all parameters are words of the key `normal`."""
    names = ["xi", "mu", "friction", "wall_stiffness", "wall_damping"]
    spread = ", ".join(f"tolerance_{name} = 0.1, 0.01" for name in names)
    words = ", ".join(f"'{name}'" for name in (*names, "load"))
    (tmp_path / "normal.nml").write_text(
        "&system xi = 0.1, mu = 0.1, restitution = 0.7 /\n&design band = 1, 1.02, free_clearance = 20, 40, "
        f"load = 1, 0.1, {spread}, normal = {words} /\n"
    )
    (case,) = vi.read_namelist(tmp_path / "normal.nml")
    assert list(case.keys["normal"]) == [*names, "load"]


def test_without_scipy_the_extra_is_named(monkeypatch):
    """The error says how to install what is missing."""
    for name in ("scipy", "scipy.optimize", "scipy.stats"):
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(vi.MissingExtraError, match=r"pip install 'vibroimpact\[design\]'"):
        vi.design(OSC, r=(1.0, 1.02), free={"clearance": (20, 40)}, **QUICK)


def wall(r, load, m=0.1):
    """A host given as a function."""
    return vi.Structure([1, m], [0.1, 0], [1, 0], [vi.Gap([-1, 1], 5.0, 0.7)]), vi.Load(
        r, sine=[load, 0]
    )


@pytest.mark.parametrize("group", ["free", "tolerance"])
@pytest.mark.parametrize("name", ["r", "load", "", " ", "a b", "=1+1", 3, None])
def test_names_of_parameters_of_a_function(group, name):
    """The parameters are those of its arguments, without those that it always gets; the function is not called."""
    words = {"free": {"m": (0.1, 0.2)}} | {group: {name: (0.1, 0.2)}}
    with pytest.raises(
        vi.ParameterError,
        match=f"{group}: parameter {name!r}: must be the name of an arg".replace("+", "."),
    ):
        vi.design(wall, r=(0.9, 1.1), **words)


def test_a_function_without_a_parameter():
    """A function that does not take a free parameter is refused before the search."""
    with pytest.raises(
        vi.ParameterTypeError, match="must take the arguments k, load, r; got an unexpected"
    ):
        vi.design(wall, r=(0.9, 1.1), free={"k": (0.1, 0.2)})
