"""The tables of keys, as `--describe` prints them: every door keeps what they say."""

import inspect
import json
import math
import random
import re
import subprocess

import pytest
import vibroimpact as vi
from programs import ROOT, SYSTEM, find_batch
from vibroimpact.errors import ParameterError, VibroimpactError

WALLS = SYSTEM.replace(", r = 0.94", "")
POINT = "&motion kind = 'exact', sides = 'RL', phases = 0, 4.3, clearance = 37 /\n"
WINDOW = "r_min = 0.8, r_max = 1.2, clearance_min = 2, clearance_max = 200"
#: The smallest case of each group: what stands before it, and its keys.
SMALLEST = {
    "motion": (SYSTEM, "sides = 'RL', phases = 0, 4.3"),
    "simulate": (SYSTEM, "clearance = 37, cycles = 1"),
    "chart": (WALLS, f"sides = 'RL', {WINDOW}, r_points = 2, clearance_points = 2"),
    "branch": (SYSTEM + POINT, "parameter = 'clearance', low = 10, high = 60"),
    "zone": (WALLS, f"sides = 'RL', {WINDOW}"),
    "atlas": (WALLS, WINDOW),
    "lyapunov": (SYSTEM, "clearance = 37"),
    "bifurcation": (SYSTEM, "parameter = 'clearance', low = 2, high = 9, values = 3"),
    "response": (WALLS, "r_min = 0.9, r_max = 1.1, r_points = 3, clearance = 37"),
    "basins": (
        SYSTEM,
        "clearance = 37, axes = 'x', 'z_dot', low = -1, -1, high = 1, 1, values = 2, 2",
    ),
}
#: What a call from Python takes beside the oscillator, for the keys that it has by their names.
CALLS = {
    "simulate": lambda osc, **keys: vi.simulate(osc, 0.94, **{"clearance": 37, "cycles": 1} | keys),
    "zone": lambda osc, **keys: vi.zone(osc, vi.Pattern("RL"), (0.8, 1.2), (2, 200), **keys),
    "atlas": lambda osc, **keys: vi.atlas(osc, (0.8, 1.2), (2, 200), **keys),
    "lyapunov": lambda osc, **keys: vi.lyapunov(osc, 0.94, **{"clearance": 37} | keys),
    "response": lambda osc, **keys: vi.response(
        osc, [0.94], **({} if {"clearance", "inverse_clearance"} & set(keys) else {"clearance": 37}) | keys),
    "basins": lambda osc, states=None, **keys: vi.basins(osc, 0.94, **{"clearance": 37} | (
        {"plane": (("x", -1, 1, 2), ("z_dot", -1, 1, 2))} if states is None and "seed" not in keys
        else {"states": 9 if states is None else states}) | keys),
    "branch": lambda osc, **keys: vi.branch(
        vi.equispaced(osc, 0.94, 37)[0], bounds=(10, 60), **keys),
}  # fmt: skip

TABLES = json.loads(
    subprocess.run([find_batch(), "--describe"], capture_output=True, check=True).stdout
)["groups"]
STUDIES = list(SMALLEST)
KEYS = [(group, key["name"]) for group in STUDIES for key in TABLES[group]]


def key_of(group, name):
    """The row of a table."""
    return next(key for key in TABLES[group] if key["name"] == name)


def case(group, extra="", without=()):
    """The smallest case of a group with more keys, and without some."""
    before, keys = SMALLEST[group]
    for name in without:
        keys = re.sub(rf"(^|, ){name} = (?:(?!, \w+ =).)*", "", keys).removeprefix(", ")
    return f"{before}&{group} {keys} {extra} /\n"


def echo(folder, text):
    """What is read of a case, with all that was filled in; or the fault, without its place."""
    path = folder / "case.nml"
    path.write_text(text, encoding="utf-8")
    try:
        (one,) = vi.read_namelist(path)
    except VibroimpactError as error:
        return re.sub(r"^.*?\.nml(:\d+)?: ", "", str(error))
    return one


@pytest.mark.parametrize("group", STUDIES)
def test_smallest_case_is_complete(group, tmp_path):
    """No key without a default is missing in it, and none can be taken away."""
    assert not isinstance(echo(tmp_path, case(group)), str)
    for key in TABLES[group]:
        if key["default"] or key["may_miss"] or f"{key['name']} =" not in SMALLEST[group][1]:
            continue
        said = echo(tmp_path, case(group, without=[key["name"]]))
        # without a parameter it is the clearance that is missing
        name = "clearance" if (group, key["name"]) == ("bifurcation", "parameter") else key["name"]
        takes = key_of(group, name)["takes"]
        assert said.startswith(f"&{group} {name}: is missing; must be {takes}"), said


@pytest.mark.parametrize(("group", "name"), KEYS)
def test_default_is_what_is_taken(group, name, tmp_path):
    """A key with its default written out is the case without it."""
    key = key_of(group, name)
    if not key["default"] or key["only"]:
        assert key["may_miss"] or key["only"] or key["is"] or not key["default"]
        return
    one = echo(tmp_path, case(group, f"{name} = {key['default']}"))
    if group == "basins" and name in ("x", "z_dot"):
        assert one == f"&basins {name} = 0: must be left out: it is an axis"
    else:
        assert one == echo(tmp_path, case(group))


def outside(key):
    """Numbers beyond the ends of the range of a key."""
    step = 1 if key["kind"] == "whole" else None
    for end, direction, open_end in (("low", -1, "above"), ("high", 1, "below")):
        value = key[end]
        if value is None:
            continue
        if key[open_end]:
            yield value
        beyond = value + direction * (step or 1e-9 * max(abs(value), 1e-9))
        if abs(beyond) < 2**31:
            yield beyond


@pytest.mark.parametrize(("group", "name"), KEYS)
def test_range_of_a_number(group, name, tmp_path):
    """What is beyond an end is refused with the words of the table, an end itself is not."""
    key = key_of(group, name)
    if key["kind"] == "word" or key["most"] > 1 or key["low"] is key["high"] is None:
        assert key["kind"] == "word" or key["most"] > 1 or "range" in key["takes"] \
            or "finite" in key["takes"] or "motion" in key["takes"]  # fmt: skip
        return
    for value in outside(key):
        text = f"{value:d}" if key["kind"] == "whole" else repr(float(value))
        said = echo(tmp_path, case(group, f"{name} = {text}", [name]))
        assert said == f"&{group} {name} = {text}: must be {key['takes']}"
    for end, open_end in (("low", "above"), ("high", "below")):
        if key[end] is None or key[open_end]:
            continue
        text = f"{key[end]:d}" if key["kind"] == "whole" else repr(float(key[end]))
        said = echo(tmp_path, case(group, f"{name} = {text}", [name]))
        assert not str(said).endswith(f"{name} = {text}: must be {key['takes']}")


@pytest.mark.parametrize(
    "group", [group for group in STUDIES if group not in ("motion", "bifurcation")]
)
def test_python_has_the_same_defaults(group):
    """A call from Python that leaves a key out takes what a namelist takes."""
    compared = 0
    for name, parameter in inspect.signature(getattr(vi, group)).parameters.items():
        rows = [key for key in TABLES[group] if key["name"] == name]
        if not rows or parameter.default in (inspect.Parameter.empty, None):
            continue
        default = rows[0]["default"]
        if not default:  # a namelist names the parameter of a branch
            continue
        compared += 1
        assert default.strip("'") == str(parameter.default) or float(default) == parameter.default
    assert compared >= 2, group


@pytest.mark.parametrize("group", CALLS)
def test_python_refuses_the_same(group):
    """A number beyond an end of its range is refused by the call too, before anything is computed."""
    osc = vi.Oscillator(0.005, 0.042, 0.75)
    names = inspect.signature(getattr(vi, group)).parameters
    compared = 0
    for key in TABLES[group]:
        if key["name"] not in names or key["kind"] == "word" or key["most"] > 1:
            continue
        for value in outside(key):
            with pytest.raises(ParameterError, match=f"^{key['name']}"):
                CALLS[group](osc, **{key["name"]: value})
            compared += 1
    assert compared >= 3, group


def drawn(draw, key):
    """A value that a key takes, as text; None where only the study knows."""
    if key["words"]:
        return f"'{draw.choice(key['words'].split())}'"
    if key["kind"] == "word" or key["most"] > 1 or key["low"] is None or key["high"] is None:
        return None
    low, high = key["low"], key["high"]
    if key["kind"] == "whole":
        return str(draw.randint(low, min(high, low + draw.choice((1, 30, 10**9)))))
    value = math.exp(draw.uniform(math.log(max(low, 1e-12)), math.log(high)))
    return repr(value) if low < value < high or value < high else None


@pytest.mark.parametrize("group", STUDIES)
def test_random_cases(group, tmp_path):
    """What is accepted is read again from its own echo, to the same; what is not names a key."""
    draw, accepted = random.Random(group), 0
    for _ in range(150):
        keys = draw.sample(TABLES[group], draw.randint(0, min(4, len(TABLES[group]))))
        values = {key["name"]: drawn(draw, key) for key in keys}
        values = {name: value for name, value in values.items() if value is not None}
        extra = ", ".join(f"{name} = {value}" for name, value in values.items())
        one = echo(tmp_path, case(group, extra, values))
        if isinstance(one, str):
            assert re.match(r"&\w+ \w+( = .+)?: (must be|is missing)", one), one
            continue
        accepted += 1
        assert echo(tmp_path, one.text) == one
    assert accepted > 10


def readme_rows():
    """Group, names of keys, and default of each row of the table of the language."""
    group = None
    for line in (ROOT / "inputs/README.md").read_text(encoding="utf-8").splitlines():
        cells = [cell.strip() for cell in line.replace(r"\|", "").split("|")[1:-1]]
        if len(cells) != 4 or cells[0] in ("group", "---"):
            continue
        group = cells[0].strip("`&") or group
        yield group, re.findall(r"`(\w+)`", cells[1].partition(" (")[0]), cells[3].strip("`")


def test_readme_has_every_key_with_its_default():
    """The table of inputs/README.md and those of the program."""
    told = {group: {} for group in TABLES}
    for group, names, default in readme_rows():
        told[group] |= dict.fromkeys(names, default)
    for group, keys in TABLES.items():
        assert set(told[group]) == {key["name"] for key in keys}, group
        for key in keys:
            default = told[group][key["name"]]
            if re.fullmatch(r"'.*'|[\d.e-]+", default):
                assert key["default"] in (default, default.strip("'")), (group, key["name"])
            elif default == "error":
                assert not key["default"], (group, key["name"])


def test_keys_of_a_group_for_people(batch):
    """`--keys zone` tells each key, what it takes, what it means and its default."""
    done = batch("--keys", "zone")
    assert done.status == 0
    lines = done.out.decode().splitlines()
    assert lines[0] == "&zone"
    for key in TABLES["zone"]:
        assert f"  {key['name']}: {key['takes']}" in lines
        assert any(key["meaning"] in line for line in lines), key["name"]
    assert batch("--keys", "&ZONE") == done
    for wrong in ("zon", "", "&"):
        done = batch("--keys", wrong)
        assert (done.status, done.out) == (2, b"")
        assert done.faults == [f"--keys {wrong}: must be followed by one of {', '.join(TABLES)}"]
