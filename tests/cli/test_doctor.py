"""The command doctor, and options of all commands: --quiet, --json, --help with an example."""

import json
import re
from importlib.metadata import metadata

import numpy
import pytest
import vibroimpact as vi
from programs import Runner, find_command, write


@pytest.fixture
def tool(tmp_path):
    """Runner of `vibroimpact` in a folder of its own."""
    return Runner([find_command()], tmp_path)


def test_doctor_tells_of_this_installation(tool):
    """The versions are those of this interpreter, and the motion of Table 1 is correct."""
    done = tool("doctor", "--json")
    assert (done.status, done.err) == (0, b"")
    facts = json.loads(done.out)["results"]["doctor"]
    assert facts["vibroimpact"] == vi.__version__
    assert facts["numpy"] == numpy.__version__
    assert facts["program"] == f"vibroimpact-batch {vi.__version__}"
    assert facts["computes"] == "yes"
    assert re.match(r"\w+ \d+\.\d+", facts["compiler"])
    assert facts["lapack"]
    assert facts["extras"]["plot"].keys() == {"matplotlib"}
    known = set(metadata("vibroimpact").get_all("Provides-Extra"))
    assert facts["extras"].keys() == known - {"bench", "docs", "lint", "test", "wheel"}
    plain = tool("doctor")
    assert plain.status == 0
    for name in ("vibroimpact", "lapack", "compiler", "computes"):
        assert re.search(rf"^{name}: +{re.escape(facts[name])}$", plain.out.decode(), re.MULTILINE)


def test_doctor_says_how_to_get_what_is_missing(tool):
    """A missing library is named with its purpose, and is no error."""
    write(tool.cwd / "sitecustomize.py", """import importlib.metadata as m
known = m.version
def version(name):
    if name == 'matplotlib':
        raise m.PackageNotFoundError(name)
    return known(name)
m.version = version
""")  # fmt: skip
    done = tool("doctor", env={"PYTHONPATH": str(tool.cwd), "PATH": ""})
    assert (done.status, done.err) == (0, b"")
    assert "matplotlib MISSING" in done.out.decode()
    assert "for pictures: pip install 'vibroimpact[plot]'" in done.out.decode()


def test_doctor_sees_threads(tool):
    """The number of threads is that of the environment, as OpenMP uses it."""
    done = tool("doctor", env={"OMP_NUM_THREADS": "3", "PATH": ""})
    output = re.search(r"threads: +(.*)", done.out.decode())[1]
    assert output.startswith("3 of ") or "without OpenMP" in output


def test_quiet(tool):
    """With --quiet standard output is empty, but faults are reported."""
    done = tool("doctor", "--quiet")
    assert (done.status, done.out) == (0, b"")
    done = tool("run", "missing.nml", "--quiet")
    assert (done.status, done.out, len(done.faults)) == (2, b"", 1)


def test_json_of_a_wrong_input(tool):
    """With --json wrong input gives the document, too, with the status and the fault of standard error."""
    done = tool("find", "--xi", "2", "--mu", "0.1", "--restitution", "0.7", "--r", "1", "--clearance", "9",
                "--json")  # fmt: skip
    document = json.loads(done.out)
    assert (done.status, document["status"]) == (2, 2)
    assert done.faults == document["faults"]
    assert document["faults"][0].startswith("vibroimpact find: --xi 2.0: must be ")
