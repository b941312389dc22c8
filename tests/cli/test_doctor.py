"""The command doctor, and options of all commands: --quiet, --json, --help with an example."""

import json
import re
from importlib.metadata import metadata
from types import SimpleNamespace

import numpy
import vibroimpact as vi
from programs import write
from vibroimpact.commands import doctor


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
    """A missing library is named with its purpose, and is not an error."""
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
    """The number of threads is that of the environment, as OpenMP applies it."""
    done = tool("doctor", env={"OMP_NUM_THREADS": "3", "PATH": ""})
    output = re.search(r"threads: +(.*)", done.out.decode())[1]
    assert output.startswith("3 of ") or "without OpenMP" in output


def test_quiet(tool):
    """With --quiet standard output is empty, but errors are reported."""
    done = tool("doctor", "--quiet")
    assert (done.status, done.out) == (0, b"")
    done = tool("run", "missing.nml", "--quiet")
    assert (done.status, done.out, len(done.faults)) == (2, b"", 1)


def test_json_of_a_wrong_input(tool):
    """With --json invalid input also gives the document, with the status and the error of standard error."""
    done = tool("find", "--xi", "2", "--mu", "0.1", "--restitution", "0.7", "--r", "1", "--clearance", "9",
                "--json")  # fmt: skip
    document = json.loads(done.out)
    assert (done.status, document["status"]) == (2, 2)
    assert done.faults == document["faults"]
    assert document["faults"][0].startswith("vibroimpact find: --xi 2.0: must be ")


def test_the_doctor_says_what_is_missing(monkeypatch, capsys):
    """Missing libraries, a missing program and a slow build are reported, each with a remedy; the status is 1."""
    added = {}
    options = SimpleNamespace(record=SimpleNamespace(add=added.__setitem__))
    built = {**doctor.built(), "openmp": "", "buildtype": "debug", "lapack": "openblas 0.3"}
    monkeypatch.setattr(doctor, "built", lambda: built)
    monkeypatch.setattr(doctor, "program", lambda: doctor.MISSING)
    monkeypatch.setattr(
        doctor, "extras", lambda: {"plot": {"matplotlib": None, "cmcrameri": "1.9"}}
    )
    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    assert doctor.run(options) == 1
    said = capsys.readouterr().out.splitlines()
    assert "extra plot:        matplotlib MISSING, cmcrameri 1.9" in said
    assert any(line.endswith("processors (built without OpenMP)") for line in said)
    advice = added["doctor"]["advice"]
    assert said[-len(advice) :] == advice
    starts = (
        "for pictures: pip install 'vibroimpact[plot]'", "in a copy of the project: pip install",
        "charts and atlases would be faster with OpenMP", "set OPENBLAS_NUM_THREADS=1",
        "a build of type debug is slow", "reinstall the package",
    )  # fmt: skip
    assert all(line.startswith(start) for line, start in zip(advice, starts, strict=True))


def test_the_doctor_sees_a_wrong_motion(monkeypatch):
    """Errors and wrong multipliers of the core are reported."""
    assert doctor.computes() == "yes"
    right = doctor.exact

    def wrong(osc, *others):
        return right(vi.Oscillator(xi=osc.xi, mu=osc.mu, restitution=0.7), *others)

    monkeypatch.setattr(doctor, "exact", wrong)
    assert doctor.computes().startswith("NO: residual ")

    def failing(*_):
        raise vi.SingularError("no motion")

    monkeypatch.setattr(doctor, "exact", failing)
    assert doctor.computes() == "NO: no motion"
