"""Every public function, constructor and method by hypothesis: hostile values in place of some arguments.

The functions are found by the names that the package makes public and their signatures, so that a new one is
fuzzed without being listed. An answer, or an error of the package that names a parameter, is as it should be.
"""

import datetime
import decimal
import fractions
import functools
import inspect
import math
import re

import numpy as np
from child import in_child, limited, where
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

#: Number of examples for each function in a full run.
COUNT = 200
#: Methods that need a display or a browser or make a film, and methods of Python sequences.
LEFT_OUT = {"animate", "plot", "count", "index"}


def fuzz(report, options):
    """Run all tests of this file, with one child process for each function."""
    targets = find_targets()
    count = max(2, round(COUNT * options.share))
    for name, (function, base) in targets.items():
        work = functools.partial(tried, name, function, base, count, options.seed)
        in_child(report, "functions", name, work)


def find_targets():
    """Functions with the arguments that they take, by name."""
    import scipy.optimize  # noqa: F401  (a later import could be interrupted)
    import vibroimpact as vi
    import xarray  # noqa: F401

    values, objects = samples(vi)
    found = {}
    for name in vi.__all__:
        item = getattr(vi, name)
        if inspect.isfunction(item):
            found[name] = (item, base_of(item, values))
        elif inspect.isclass(item) and not issubclass(item, BaseException):
            if "Raises\n" in (inspect.getdoc(item) or ""):
                found[name] = (item, base_of(item, values))
            for place, method in inspect.getmembers(item, inspect.ismethod):
                if not place.startswith("_") and "Raises\n" in (inspect.getdoc(method) or ""):
                    found[f"{name}.{place}"] = (method, base_of(method, values))
    for instance in objects:
        for place, _ in inspect.getmembers(type(instance), inspect.isfunction):
            method = getattr(instance, place)
            if (
                not place.startswith("_")
                and place not in LEFT_OUT
                and inspect.signature(method).parameters
            ):
                found[f"{type(instance).__name__}.{place}()"] = (method, base_of(method, values))
    return {name: target for name, target in found.items() if parameters_of(target[0])}


def parameters_of(function):
    """The names of the parameters of a function."""
    return [
        name for name, parameter in inspect.signature(function).parameters.items()
        if parameter.kind not in (parameter.VAR_KEYWORD, parameter.VAR_POSITIONAL)
    ]  # fmt: skip


def samples(vi):
    """Valid arguments by name or annotation, and objects whose methods are called."""
    osc = vi.Oscillator(xi=0.01, mu=0.05, restitution=0.75, M=2.0, K=3.0, F0=4.0)
    structure = vi.Structure(
        [1, 0.042], [0.01, 0], [1, 0], [vi.Gap([-1, 1], 18.5, 0.75), vi.Gap([1, -1], 18.5, 0.75)]
    )
    load = vi.Load(0.94, sine=[1.0, 0.0])
    motion = vi.equispaced(osc, 0.94, 37.0)[0]
    moving = vi.exact(structure, load, ([1.6250583, 5.9668230], [0, 1]))
    values = {
        "osc": osc, "structure": structure, "motion": motion, "one": motion, "other": motion, "r": 0.94,
        "clearance": 37.0,
        "pattern": "RL", "phases": [0.0, 3.3], "parameter": "clearance", "values": [36.0, 38.0],
        "bounds": (36.0, 38.0),
        "guess": motion, "zone": None, "uncertain": {"xi": (0.01, 0.001)}, "limit": {"attenuation": 1.0},
        "code": 1,
        "frequency": 0.9, "sine": [0.1, 0.0], "step": 0.1, "acceleration": [0.0, 1.0, 0.0], "amplitude": 1.0,
        "duration": 0.5, "path": "x.nml", "paths": ["x.nml"], "cases": [], "store": "store", "folder": "out",
        "f": (1.0, 2.0),
        "low": 1.0, "high": 2.0, "n": 3, "gaps": [0, 1], "free": {"clearance": (10.0, 60.0)}, "host": osc,
        "result": motion,
        "x": ("frequency", 0.85, 0.95), "y": ("load", 0.9, 1.1), "xi": 0.01, "mu": 0.05, "restitution": 0.75,
        "mass": [1.0, 2.0], "damping": [0.0, 0.0], "stiffness": [1.0, 1.0], "direction": [1.0, 0.0],
        "opening": 1.0,
        "force": [[0.0, 1.0], [1.0, 0.0]], "rate": 100.0, "speeds": [0.0, 1.0], "R0": 0.8, "speed": 1.0,
        "exponent": 0.2,
        "M": 2.0, "K": 3.0, "F0": 4.0, "C": 0.1, "m": 0.1, "d": 1.0, "sides": "RL", "state": None,
        "times": [0.0, 0.1],
    }  # fmt: skip
    values |= {
        "cycles": 4, "settling": 2, "states": 1, "guesses": 1, "samples": 2, "lines": 5, "max_points": 100,
        "survey": 1,
        "probes": 1, "max_cycles": 1, "max_impacts": 2, "threads": 1, "max_events": 1000, "discard": 1,
        "batches": 2,
        "keep": 3, "points": 3, "releases": 1, "seeds": 1, "evaluations": 8, "specimens": 1, "nodes": 2,
        "vertices": 3,
    }  # fmt: skip
    annotated = {
        "Load": load, "Structure": structure, "tuple[float, float]": (0.9, 1.1),
        "Trajectory": vi.simulate(osc, 0.94, 37.0, 3),
    }  # fmt: skip
    zone = vi.zone(osc, "RL", (0.93, 0.95), (36.0, 38.0), lines=5, guesses=1)
    values["zone"] = zone
    case = motion.to_namelist()
    objects = [
        osc, motion, moving, annotated["Trajectory"], zone, structure, vi.Pattern("RL"), vi.Units(2.0, 3.0, 4.0),
        vi.PowerLaw(0.8, 1.0, 0.2), vi.TabulatedRestitution([0, 1], [0.9, 0.5]), vi.branch(motion, bounds=(36.5,
        37.5)),
        vi.simulate(structure, load, cycles=3), vi.response(osc, [0.93, 0.94], 37.0, states=1,
        settling=2, keep=3),
        vi.basins(osc, 0.94, 37.0, states=2, cycles=5, probes=1), vi.physical(motion),
        vi.bifurcation_diagram(osc, "clearance", [36.0, 38.0], r=0.94, settling=2, keep=3, impacts=3),
        vi.atlas(osc, (0.93, 0.95), (36.0, 38.0), max_impacts=2, survey=1, lines=5, guesses=1, settling=10),
        vi.find(osc, 0.94, 37.0, max_impacts=2, guesses=1, states=1, settling=2),
        vi.lyapunov(osc, 0.94, 20.0, cycles=40, discard=60, batches=2),
        vi.decay(osc, 1.0, cycles=3, amplitude=2.0),
        vi.branch(moving, "frequency", (0.939, 0.941)),
        vi.zone(moving, values["x"], values["y"], lines=5),
        vi.basins(structure, load, states=1, settling=2),
        vi.bifurcation_diagram(structure, load, "frequency", [0.93, 0.94], settling=2, keep=3, impacts=3),
        vi.response(structure, load, [0.93, 0.94], settling=2, keep=3),
        vi.lyapunov(structure, load, cycles=4, discard=1, batches=2), case,
        vi.Sweep(case, {"clearance": [36.0, 37.0]}),
    ]  # fmt: skip
    return (values, annotated), objects


def base_of(function, samples):
    """Valid arguments of a function: the required ones, and those that keep the computation small."""
    values, annotated = samples
    base = {}
    for name, parameter in inspect.signature(function).parameters.items():
        if parameter.kind in (parameter.VAR_KEYWORD, parameter.VAR_POSITIONAL):
            continue
        needed = parameter.default is parameter.empty
        kind = str(parameter.annotation).strip("'").split(" | ")[0]
        if kind in annotated and (needed or kind == "Load"):
            base[name] = annotated[kind]
        elif name in values and (needed or isinstance(values[name], int)):
            base[name] = values[name]
        elif needed:
            base[name] = 1
    return base


# -- values


def odd_arrays():
    """Arrays of unusual type, shape and layout."""
    plain = np.array([[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]])
    readonly = np.arange(3.0)
    readonly.flags.writeable = False
    structured = np.zeros(2, dtype=[("a", float), ("b", int)])
    objects = np.empty(2, dtype=object)
    objects[:] = [None, "x"]
    return [
        np.array([]), np.zeros((0, 3)), np.zeros((2, 0)), np.array(1.0), plain, plain.T, plain[:, ::2],
        plain[::-1],
        np.arange(6.0)[::2], np.broadcast_to(1.0, (3,)), np.asfortranarray(plain), readonly, structured, objects,
        np.array([0.5, "a"], dtype=object), np.array([0.5, 1], dtype=object), np.array([[1.0], [2.0]]),
        np.zeros((2, 2, 2)),
        np.ma.array([1.0, 2.0], mask=[0, 1]), np.ma.masked, np.array([1.0, np.nan]), np.array([1.0, np.inf]),
        np.array([5e-324, 1e308]), np.array([1e-40, 1], np.float32), np.array([1, 2], np.float16), np.array([1,
        2], np.int8),
        np.array([1, 2], ">f8"), np.array([1, 2], np.longdouble), np.array([True, False]), np.array([1j, 2]),
        np.array(["1", "2"]), np.array([b"1"]), np.array(["2020"], "datetime64[Y]"), np.array([1],
        "timedelta64[s]"),
        np.matrix("1 2"), np.float64(1), np.float32(0.5), np.int64(3), np.bool_(True), np.str_("RL"),
        np.uint64(2**63),
        np.full(3, -1.0), np.zeros(3), np.ones(1000), np.zeros((1, 1)), memoryview(b"12345678"),
    ]  # fmt: skip


class Hostile:
    """An object whose special methods fail."""

    def __float__(self):
        raise RuntimeError("no number")

    def __array__(self, *_, **__):
        raise RuntimeError("no array")

    def __repr__(self):
        return "Hostile()"


SCALARS = [
    None, True, False, 0, 1, -1, 2, 3, 7, 1000, 2**31 - 1, 2**31, 2**53 + 1, 2**63, 2**70, 10**400, 0.0, -0.0,
    0.5, 1.0, 1.5,
    -1.5, 1e-12, 1e12, 1e13, 1e300, 1.7976931348623157e308, 5e-324, 2.2e-308, math.nan, math.inf, -math.inf, 1j,
    "", "x", "RL",
    "RRL", "RL*", "RL/2", "0", "nan", "both", "\0", "a\nb", "\ud800", "\u00e9", "x" * 2000, "&", b"", b"RL",
    bytearray(b"x"), ...,
    fractions.Fraction(1, 2), decimal.Decimal("0.5"), decimal.Decimal("nan"), decimal.Decimal("sNaN"), object,
    print, len,
    datetime.date(2020, 1, 1), range(3), range(0), set(), {1.0, 2.0}, frozenset(), (), [], {}, [[]], [[1.0],
    [1.0, 2.0]], [None],
    ["x"], [math.nan], [math.inf], [1.0, "2"], [1, 2, 3], [0.5], [[0.5]], (1.0, 2.0), (2.0, 1.0), (1.0, 1.0),
    (0.9, 1.1),
    (1.0,), (1.0, 2.0, 3.0), ("RL", "RL"), {"x": 1.0}, {"xi": 0.1}, {"xi": math.nan}, {1: 2},
    {"clearance": (1.0, 2.0)},
    {"clearance": None}, {"x": None, "t": 0, "x_dot": 0, "z": 0, "z_dot": 0}, slice(None), NotImplemented,
    Exception("x"),
    Hostile(), Hostile,
]  # fmt: skip


def hostile():
    """Any value."""
    simple = st.one_of(
        st.sampled_from(SCALARS),
        st.sampled_from(odd_arrays()),
        st.floats(),
        st.integers(-10, 10**6),
        st.text(max_size=5),
        arrays.arrays(st.sampled_from([np.float64, np.int32, np.float32]), arrays.array_shapes(min_dims=0,
        max_dims=3, max_side=4)),
    )  # fmt: skip
    return st.one_of(
        simple,
        st.lists(simple, max_size=3),
        st.tuples(simple, simple),
        st.dictionaries(
            st.sampled_from(["x", "xi", "mu", "r", "clearance", "R1", "t", "load", 1]),
            simple,
            max_size=2,
        ),
    )


def calls(base, names):
    """Arguments, and the names of the hostile ones."""
    changed = st.lists(st.sampled_from(names), min_size=1, max_size=2, unique=True)
    return changed.flatmap(
        lambda chosen: st.fixed_dictionaries({name: hostile() for name in chosen}).map(
            lambda odd: (base | odd, chosen)
        )
    )


# -- one function


def tried(name, function, base, count, number, begin):
    """Count refused and accepted calls, and collect (kind, text) of those that went wrong."""
    from vibroimpact.base.errors import ParameterError, VibroimpactError

    parameters = parameters_of(function)
    counts, faults = [0, 0], {}

    @seed(number)
    @settings(
        max_examples=count,
        database=None,
        deadline=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(calls(base, parameters))
    def call(drawn):
        arguments, chosen = drawn
        text = f"{name}\n" + "\n".join(f"{key} = {short(arguments[key])}" for key in chosen)
        begin(text)
        kind = fault_of(function, arguments, parameters, counts, (ParameterError, VibroimpactError))
        if kind is not None:
            faults.setdefault(kind, (f"{text}\n{kind}\n".encode("utf-8", "replace"), ".txt"))

    call()
    return *counts, faults


def short(value):
    """Describe a value in words."""
    try:
        return repr(value)[:300]
    except Exception as error:
        return f"a {type(value).__name__} that {type(error).__name__} keeps from being shown"


def fault_of(function, arguments, parameters, counts, errors):
    """Call a function once; return what is wrong with its answer, or None."""
    parameter_error, own_error = errors
    positional = inspect.signature(function).parameters
    first = [
        arguments[name]
        for name, p in positional.items()
        if name in arguments and p.kind is p.POSITIONAL_ONLY
    ]
    named = {
        name: value
        for name, value in arguments.items()
        if positional[name].kind is not inspect.Parameter.POSITIONAL_ONLY
    }

    def call():
        answer = function(*first, **named)
        if inspect.isgenerator(answer):
            list(zip(range(10), answer, strict=False))

    error = limited(call)
    lacks = isinstance(error, AttributeError) and " does not have it; it has " in str(error)
    if error is None or lacks or isinstance(error, KeyboardInterrupt):
        counts[1] += 1
        return None
    if isinstance(error, own_error):
        message = str(error)
        of_object = inspect.ismethod(function) and re.match(r"<|\w+( = |:)", message)
        if (
            isinstance(error, parameter_error)
            and not of_object
            and not names_one(message, parameters)
        ):
            return f"{type(error).__name__} without the name of a parameter: {message[:150]!r}"
    elif not isinstance(error, RuntimeError) or str(error) not in ("no number", "no array"):
        return where(error)
    counts[0] += 1
    return None


def names_one(message, parameters):
    """Whether a message names one of the parameters; a message about a namelist begins with its path."""
    if parameters == ["path"] and ": " in message:
        return True
    return any(re.search(rf"\b{re.escape(name)}\b", message) for name in parameters)
