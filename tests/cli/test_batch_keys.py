"""The tables of keys, as `--describe` prints them, hold for namelists, options and Python."""

import inspect
import json
import math
import random
import re
import subprocess
import sys
from ast import literal_eval
from functools import partial

import pytest
import vibroimpact as vi
from programs import IN_PYTHON, ROOT, SYSTEM, find_batch
from vibroimpact.base import checks
from vibroimpact.base.errors import ParameterError, VibroimpactError
from vibroimpact.commands import STUDIES as COMMANDS
from vibroimpact.commands import Record, cases
from vibroimpact.commands.command import module_of, parser_of
from vibroimpact.commands.init import example, shown
from vibroimpact.commands.request import read_cases

WALLS = SYSTEM.replace(", r = 0.94", "")
POINT = "&motion kind = 'exact', sides = 'RL', phases = 0, 4.3, clearance = 37 /\n"
WINDOW = "r_min = 0.8, r_max = 1.2, clearance_min = 2, clearance_max = 200"
LANGUAGE = json.loads(
    subprocess.run([find_batch(), "--describe"], capture_output=True, check=True).stdout
)
TABLES = {
    group: [key for key in keys if key["model"] != "structure"]
    for group, keys in LANGUAGE["groups"].items()
}
#: Studies whose smallest case is the example of their command, reduced to keys without a default.
OTHERS = [
    name for name in COMMANDS
    if name not in ("simulate", "find", "chart", "branch", "zone", "atlas", "lyapunov", "bifurcation",
                    "response", "basins")
]  # fmt: skip


def needed(name):
    """The frequency ratio and the keys of a command's example, as in a namelist."""
    groups = example(name)[1]
    given = {
        key["name"]: groups[name].get(key["name"]) for key in TABLES[name] if not key["default"]
    }
    given = {"r": groups["system"].get("r")} | given
    return {key: shown(value) for key, value in given.items() if value is not None}


def smallest(name):
    """The groups that precede a study, and the keys of the study."""
    keys = needed(name)
    before = WALLS if keys.pop("r", None) is None else SYSTEM
    return before, ", ".join(f"{key} = {value}" for key, value in keys.items())


def call(name, osc, **keys):
    """A function that calls a study with these keys, and with others."""
    instead = {key["name"] for key in TABLES[name] if key["or"] in keys}
    ours = {
        key: literal_eval(f"[{value}]") for key, value in needed(name).items() if key not in instead
    }
    return getattr(vi, name)(
        osc, **{key: x[0] if len(x) == 1 else x for key, x in ours.items()} | keys
    )


#: The smallest case of each group: the groups that precede it, and its keys.
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
    **{name: smallest(name) for name in OTHERS},
}
#: Calls from Python with the arguments that have no default; further keys are passed by name.
CALLS = {
    "simulate": lambda osc, **keys: vi.simulate(osc, 0.94, **{"clearance": 37, "cycles": 1} | keys),
    "zone": lambda osc, **keys: vi.zone(osc, vi.Pattern("RL"), (0.8, 1.2), (2, 200), **keys),
    "atlas": lambda osc, **keys: vi.atlas(osc, (0.8, 1.2), (2, 200), **keys),
    "lyapunov": lambda osc, **keys: vi.lyapunov(osc, 0.94, **{"clearance": 37} | keys),
    "response": lambda osc, **keys: vi.response(
        osc, [0.94], **({} if {"clearance", "inverse_clearance"} & set(keys) else {"clearance": 37}) | keys),
    "basins": lambda osc, states=None, **keys: vi.basins(osc, 0.94, **{"clearance": 37} | (
        {"plane": (("x", -1, 1, 2), ("z_dot", -1, 1, 2))} if states is None and "rng" not in keys
        else {"states": 9 if states is None else states}) | keys),
    "branch": lambda osc, **keys: vi.branch(
        vi.equispaced(osc, 0.94, 37)[0], bounds=(10, 60), **keys),
    **{name: partial(call, name) for name in OTHERS if name not in IN_PYTHON},
    "design": lambda osc, **keys: vi.design(
        osc, **{"r": (1, 1.02), "free": {"clearance": (20, 40)}} | keys),
}  # fmt: skip

#: Arguments of calls whose names differ from those of their keys.
ARGUMENTS = {"bifurcation": {"points": "impacts"}}


def argument_of(group, key):
    """The argument of a call that corresponds to a key."""
    return ({"seed": "rng"} | ARGUMENTS.get(group, {})).get(key, key)


#: The smallest case of each group that has a command, as options without the oscillator.
OPTIONS = {
    "simulate": "--r 0.94 --clearance 37 --cycles 1",
    "chart": "--sides RL --r .8 1.2 2 --clearance 2 200 2",
    "branch": "--r 0.94 --sides RL --phases 0 4.3 --clearance 37 --parameter clearance --bounds 10 60",
    "zone": "--sides RL --r .8 1.2 --clearance 2 200",
    "atlas": "--r .8 1.2 --clearance 2 200",
    "lyapunov": "--r 0.94 --clearance 37",
    "bifurcation": "--r 0.94 --parameter clearance --values 2 9 3",
    "response": "--r .9 1.1 3 --clearance 37",
    "basins": "--r 0.94 --clearance 37 --plane x -1 1 2 z_dot -1 1 2",
    **{
        name: " ".join(
            f"--{key.replace('_', '-')} {value}".replace(",", "").replace("'", "")
            for key, value in needed(name).items()
        )
        for name in OTHERS
    },
}

STUDIES = list(SMALLEST)
KEYS = [(group, key["name"]) for group in STUDIES for key in TABLES[group]]


def key_of(group, name):
    """The row of a table for a key."""
    return next(key for key in TABLES[group] if key["name"] == name)


def case(group, extra="", without=()):
    """The smallest case of a group, with keys added and removed."""
    before, keys = SMALLEST[group]
    for name in without:
        keys = re.sub(rf"(^|, ){name} = (?:(?!, \w+ =).)*", "", keys).removeprefix(", ")
    return f"{before}&{group} {keys} {extra} /\n"


def echo(folder, text):
    """The case as read, with all defaults; or the error, without its place."""
    path = folder / "case.nml"
    path.write_text(text, encoding="utf-8")
    try:
        (one,) = vi.read_namelist(path)
    except VibroimpactError as error:
        return re.sub(r"^.*?\.nml(:\d+)?: ", "", str(error))
    return one


@pytest.mark.parametrize("group", STUDIES)
def test_smallest_case_is_complete(group, tmp_path):
    """The smallest case is accepted, and is refused if any of its keys is removed."""
    assert not isinstance(echo(tmp_path, case(group)), str)
    for key in TABLES[group]:
        if key["default"] or key["may_miss"] or f"{key['name']} =" not in SMALLEST[group][1]:
            continue
        output = echo(tmp_path, case(group, without=[key["name"]]))
        # without a parameter, the clearance is missing
        name = "clearance" if (group, key["name"]) == ("bifurcation", "parameter") else key["name"]
        takes = key_of(group, name)["takes"]
        assert output.startswith(f"&{group} {name}: is missing; must be {takes}"), output


@pytest.mark.parametrize(("group", "name"), KEYS)
def test_default_is_what_is_taken(group, name, tmp_path):
    """A case with a key set to its default equals the case without the key."""
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
        value = key.get(end)
        if value is None:
            continue
        if key[open_end]:
            yield value
        beyond = value + direction * (step or 1e-9 * max(abs(value), 1e-9))
        if abs(beyond) < 2**31:
            yield beyond


@pytest.mark.parametrize(("group", "name"), KEYS)
def test_range_of_a_number(group, name, tmp_path):
    """A number beyond the end of a range is refused in the words of the table; the end itself is accepted."""
    key = key_of(group, name)
    if key["kind"] == "word" or key["most"] > 1 or key["low"] is key["high"] is None:
        assert key["kind"] == "word" or key["most"] > 1 or "range" in key["takes"] \
            or "finite" in key["takes"] or "motion" in key["takes"]  # fmt: skip
        return
    for value in outside(key):
        text = f"{value:d}" if key["kind"] == "whole" else repr(float(value))
        output = echo(tmp_path, case(group, f"{name} = {text}", [name]))
        assert output == f"&{group} {name} = {text}: must be {key['takes']}"
    for end, open_end in (("low", "above"), ("high", "below")):
        if key[end] is None or key[open_end]:
            continue
        text = f"{key[end]:d}" if key["kind"] == "whole" else repr(float(key[end]))
        output = echo(tmp_path, case(group, f"{name} = {text}", [name]))
        assert not str(output).endswith(f"{name} = {text}: must be {key['takes']}")


@pytest.mark.parametrize(
    "group", [group for group in STUDIES if group not in ("motion", "bifurcation", *IN_PYTHON)]
)
def test_python_has_the_same_defaults(group):
    """An omitted key has the same default in a call from Python as in a namelist."""
    compared = 0
    for name, parameter in inspect.signature(getattr(vi, group)).parameters.items():
        rows = [key for key in TABLES[group] if argument_of(group, key["name"]) == name]
        if not rows or parameter.default in (inspect.Parameter.empty, None):
            continue
        default = rows[0]["default"]
        if not default:  # in a namelist, the parameter of a branch is a name
            continue
        compared += 1
        assert default.strip("'") == str(parameter.default) or float(default) == parameter.default
    assert compared >= 2, group


#: The group and key that declare each range that calls with arrays check directly.
RANGES = {
    "acceptance": ("motion", "acceptance"), "load": ("simulate", "load"), "clearance": ("simulate", "clearance"),
    "cycles_simulated": ("simulate", "cycles"), "longest_step": ("branch", "longest_step"),
    **{name: ("design", f"free_{name}") for name in ("friction", "wall_stiffness", "wall_damping")},
}  # fmt: skip


def test_calls_on_arrays_have_the_same_ranges():
    """The ranges that calls with arrays check directly, for speed, are those of the tables."""
    for name, (low, high, closed) in checks.RANGES.items():
        key = key_of(*RANGES.get(name, ("system", name)))
        assert (low, high, closed) == (key["low"], key["high"], not key["below"])
        assert not key["above"]
    assert key_of("motion", "cycles")["high"] == checks.MAX_CYCLES
    assert key_of("motion", "phases")["most"] == checks.MAX_IMPACTS
    assert key_of("basins", "states")["high"] == checks.MOST_NUMBERS


@pytest.mark.parametrize("group", CALLS)
def test_python_refuses_the_same(group):
    """A number beyond an end of its range is refused by the call too, before anything is computed."""
    osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    names = inspect.signature(getattr(vi, group)).parameters
    compared = 0
    for key in TABLES[group]:
        name = argument_of(group, key["name"])
        if name not in names or key["kind"] == "word" or key["most"] > 1:
            continue
        for value in outside(key):
            with pytest.raises(ParameterError, match=f"^{name}"):
                CALLS[group](osc, **{name: value})
            compared += 1
    assert compared >= 3, group


def drawn(draw, key):
    """A value allowed for a key, as text; None if the table does not determine one."""
    if key["words"]:
        return f"'{draw.choice(key['words'].split())}'"
    if key["kind"] == "word":
        return None
    if key["most"] > 1:
        one = {**key, "least": 1, "most": 1}
        items = [drawn(draw, one) for _ in range(draw.randint(key["least"], max(3, key["least"])))]
        return None if None in items else ", ".join(items)
    if key["low"] is None or key["high"] is None:
        return repr(draw.uniform(-3, 3))
    low, high = key["low"], key["high"]
    if key["kind"] == "whole":
        return str(draw.randint(low, min(high, low + draw.choice((1, 30, 10**9)))))
    value = math.exp(draw.uniform(math.log(max(low, 1e-12)), math.log(high)))
    return repr(value) if low < value < high or value < high else None


@pytest.mark.parametrize("group", STUDIES)
def test_random_cases(group, tmp_path):
    """Reading the echo of an accepted case gives the same case; a refusal names a key."""
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


def as_options(values, table):
    """Values of keys as options of a command; None if only some keys of a shared option are given."""
    words = []
    options = {key["name"]: key["option"] or key["name"].replace("_", "-") for key in table}
    for option in dict.fromkeys(options[name] for name in values):
        names = [name for name in options if options[name] == option]
        if option == "-" or not set(names) <= set(values):
            return None
        columns = [values[name].replace("'", "").split(", ") for name in names]
        words += [f"--{option}", *(word for row in zip(*columns, strict=True) for word in row)]
    return words


def made(group, words):
    """The case made by options, as `echo` reads it; or the error."""
    found = []
    module = module_of(group)
    system = "--xi 0.005 --mu 0.042 --restitution 0.75"
    options = parser_of(group).parse_intermixed_args(
        [*system.split(), *OPTIONS[group].split(), *words]
    )
    options.record = Record(group)
    with pytest.MonkeyPatch.context() as patch:
        for place in (cases, module):
            patch.setattr(place, "run_kind", lambda *message: found.append(message), raising=False)
        try:
            module.run(options)
        except ParameterError as error:
            return str(error)
    try:
        ((one,), _) = read_cases(options, found[0][1])
    except ParameterError as error:
        return str(error)
    return one.text.replace(f"name = '{group}'", "name = 'case'")


@pytest.mark.parametrize("group", OPTIONS)
def test_random_options(group, tmp_path):
    """Options and a namelist with the same keys give the same case, or both are refused."""
    draw, counts = random.Random(group), {True: 0, False: 0}
    bounded = [key for key in TABLES[group] if list(outside(key))]
    for i in range(150):
        keys = draw.sample(TABLES[group], draw.randint(0, min(3, len(TABLES[group]))))
        if i % 3 == 0:
            keys += [key for key in TABLES[group] if key["option"] == "state"]
        values = {key["name"]: drawn(draw, key) for key in keys}
        if i % 4 == 1:
            key = draw.choice(bounded)
            values[key["name"]] = str(draw.choice(list(outside(key))))
        values = {name: value for name, value in values.items() if value is not None}
        words = as_options(values, TABLES[group])
        if words is None or (group == "lyapunov" and ", " in values.get("clearance", "")):
            continue  # there, three numbers define a line of points
        extra = ", ".join(f"{name} = {value}" for name, value in values.items())
        wanted, found = echo(tmp_path, case(group, extra, values)), made(group, words)
        refused = isinstance(wanted, str)
        counts[refused] += 1
        assert found.startswith("--") if refused else found == wanted.text, words
    assert min(counts.values()) >= 5


@pytest.mark.parametrize("group", OPTIONS)
def test_every_key_has_an_option(group):
    """Every key has an option, except the line of points of &lyapunov, given by the name of its parameter."""
    known = {flag for action in parser_of(group)._actions for flag in action.option_strings}
    for key in TABLES[group]:
        if key["option"] == "-":
            assert group == "lyapunov"
        else:
            assert f"--{key['option'] or key['name'].replace('_', '-')}" in known


def test_readme_has_the_tables():
    """The tables of inputs/README.md are those of the program."""
    done = subprocess.run(
        [sys.executable, ROOT / ".ci/check_keys.py"], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_keys_of_a_group_for_people(batch):
    """`--keys zone` prints for each key the values it takes, its meaning and its default."""
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


@pytest.mark.parametrize("study", LANGUAGE["results"])
def test_a_study_has_all_its_parts(study):
    """Each study has a meaning, and for each of its models rows in the CSV, a case in inputs/, and an entry in
    inputs/README.md."""
    message = LANGUAGE["results"][study]
    assert message["in_python"] == (study in IN_PYTHON)
    assert message["meaning"]
    inputs = [path.read_text(encoding="utf-8") for path in (ROOT / "inputs").glob("*.nml")]
    for model, table in message["rows"].items():
        assert table in {
            item["table"] for item in message["columns"] if item["model"] in ("", model)
        }
        system = "structure" if model == "structure" else "system"
        assert any(re.search(rf"(?ms)^&{system}\b.*^&{study}\b", text) for text in inputs)
        row = f"`&{study}`" + " of a `&structure`" * (model == "structure")
        assert f"\n| {row} | " in (ROOT / "inputs/README.md").read_text(encoding="utf-8")


def test_the_help_says_what_each_study_does():
    """The help has one line for each study, with its declared meaning."""
    text = subprocess.run(
        [find_batch(), "--help"], capture_output=True, text=True, check=True
    ).stdout
    found = re.findall(r"^  &(\w+) +(.*)$", text, re.MULTILINE)
    assert found == [(study, message["meaning"]) for study, message in LANGUAGE["results"].items()]


def test_columns_have_one_spelling():
    """No two columns of tables differ only in their case: a displacement is x in all of them."""
    spelled = {}
    for study, about in LANGUAGE["results"].items():
        for column in about["columns"]:
            if column["listed"]:
                shown = column["label"] or column["name"]
                stem = shown.removesuffix("_#")
                spelled.setdefault(stem.lower(), {}).setdefault(stem, study)
    assert len(spelled) > 80
    assert {key: found for key, found in spelled.items() if len(found) > 1} == {}
    assert "x" in spelled["x"]
