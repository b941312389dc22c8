"""Runs of namelist files that keep the cases of one study, and advice about an installation."""

from types import SimpleNamespace

import vibroimpact as vi
from vibroimpact.commands import doctor

CASES = (
    "&system xi = 0.005, mu = 0.042, restitution = 0.75, r = 0.94 /\n"
    "&motion sides = 'RL', phases_over_pi = 0, 1.37 /\n"
    "&simulate clearance = 5, cycles = 5 /\n"
)


def test_only_one_study_of_a_file_is_run(tmp_path):
    """The results of one study are those of a run of all, byte by byte; a file without it is an error."""
    path = tmp_path / "both.nml"
    path.write_text(CASES)
    every = vi.run_namelists([path], tmp_path / "every")
    assert every.status == 0
    assert sorted(place.name for place in every.results) == ["both_1.csv", "both_2.csv"]
    for only, name in (("simulate", "both_2.csv"),):
        log = vi.run_namelists([path], tmp_path / only, only=only)
        assert [place.name for place in (tmp_path / only).iterdir()] == [name]
        assert [place.name for place in log.results] == [name]
        assert (tmp_path / only / name).read_bytes() == (tmp_path / "every" / name).read_bytes()
    log = vi.run_namelists([path], tmp_path / "none", only="zone")
    assert log.lines == [(True, f"{path}: must hold a group &zone; there is none")]
    assert (log.status, log.results) == (2, [])
    assert not (tmp_path / "none").exists()


def test_the_doctor_says_what_is_missing(monkeypatch, capsys):
    """Missing libraries, a missing program and a slow build: each with what to do; the status is 1."""
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
        "charts and atlases would be faster with OpenMP", "the systems are small: set OPENBLAS_NUM_THREADS=1",
        "a build of type debug is slow", "install the package anew",
    )  # fmt: skip
    assert all(line.startswith(start) for line, start in zip(advice, starts, strict=True))


def test_the_doctor_sees_a_wrong_motion(monkeypatch):
    """Errors and wrong multipliers of the core are said."""
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
