"""The command prove: certificates that the independent program accepts, and cases that have no proof."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
import vibroimpact as vi
from programs import SYSTEM, contents, write
from vibroimpact.commands.command import main

CHECKER = Path(__file__).parents[1] / "proof" / "check_certificate.py"
OSC = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
DAMPER = "&system xi = 0.0114, mu = 0.028, restitution = 0.75, r = 1.04 /\n"
MOTION = "&motion kind = 'equispaced', clearance = 25 /\n"

pytest.importorskip("flint")


def accepted(path):
    """The output of the independent program for a certificate."""
    done = subprocess.run([sys.executable, CHECKER, path], capture_output=True, text=True)
    return done.returncode, done.stdout


def test_motions_are_proven(tool):
    """Each motion of a case has a certificate, equal to that of `Motion.prove`, which the checker accepts."""
    write(tool.cwd / "pair.nml", SYSTEM + "&motion kind = 'equispaced', clearance = 37 /\n")
    done = tool("prove", "pair.nml", "-o", "out")
    assert (done.status, done.err) == (0, b"")
    paths = [tool.cwd / "out" / f"pair_{i}_proof.json" for i in (1, 2)]
    assert sorted(contents(tool.cwd)) == [
        "out/pair_1_proof.json",
        "out/pair_2_proof.json",
        "pair.nml",
    ]
    osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    for path, motion in zip(paths, vi.equispaced(osc, 0.94, 37.0), strict=True):
        proof, own = vi.load(path).to_dict(), motion.prove().to_dict()
        assert {**proof, "seconds": 0} == {**own, "seconds": 0}
        assert accepted(path)[0] == 0
    assert done.out.decode().count("exists, admissible, not stable") == 2


@pytest.mark.slow
def test_branch_is_proven(tool):
    """The gaps of a branch are printed with their reasons; `--tolerance` changes them."""
    write(
        tool.cwd / "branch.nml",
        DAMPER + MOTION + "&branch parameter = 'clearance', low = 20.5, high = 25 /\n",
    )
    widths = []
    for tolerance in ("0.02", "0.002"):
        done = tool("prove", "branch.nml", "--tolerance", tolerance)
        assert (done.status, done.err) == (0, b"")
        (spans,) = re.findall(
            r"branch_1: not decided: clearance ([\d.]+) to ([\d.]+): stability", done.out.decode()
        )
        low, high = map(float, spans)
        assert low < 21.08006 < high
        widths.append(high - low)
    assert widths[1] < widths[0] / 2
    status, words = accepted(tool.cwd / "results" / "branch_1_proof.json")
    assert (status, "boxes" in words) == (0, True)


def test_zone_is_proven_and_drawn(tool):
    """A certificate of a zone decides on single points; `--plot` draws it."""
    pytest.importorskip("matplotlib")
    write(
        tool.cwd / "zone.nml",
        "&system xi = 0.0114, mu = 0.028, restitution = 0.75 /\n"
        "&zone sides = 'RL', symmetric = 'yes', r_min = 1.04, r_max = 1.0402, clearance_min = 20, "
        "clearance_max = 80, lines = 5 /\n",
    )
    done = tool("prove", "zone.nml", "--tolerance", "0.1", "--plot")
    assert (done.status, done.err) == (0, b"")
    assert sorted(contents(tool.cwd)) == [
        "results/zone_proof.json",
        "results/zone_proof.png",
        "zone.nml",
    ]
    proof = vi.load(tool.cwd / "results" / "zone_proof.json")
    assert (proof.decide(1.0401, 40.0), proof.decide(1.0401, 79.5)) == (True, False)


STRUCTURE = """&structure mass = 1, damping = 0.1, stiffness = 1 /
&gap direction = 1, opening = 1, restitution = 0.8 /
&load frequency = 1, cosine = 1 /
&motion gaps = 0, phases = 0.1 /
"""
WINDOW = "clearance_min = 20, clearance_max = 30, r_min = 1.0, r_max = 1.01"
#: Options, a case, and the expected message.
REFUSED = {
    "simulation": ("", SYSTEM + "&simulate clearance = 37, cycles = 5 /\n",
                   "case: &simulate: must be one of &motion, &branch, &zone for a proof"),
    "structure": ("", STRUCTURE + "&zone x = 'frequency', x_low = 0.9, x_high = 1.1, y = 'load', y_low = 0.9, "
                  "y_high = 1.1 /\n", "&structure: must be a &system for the proof of a &zone"),
    "tolerance of a motion": ("--tolerance .1", DAMPER + MOTION,
                              "--tolerance 0.1: must be left out for case, a &motion"),
    "tolerance": ("--tolerance 2", DAMPER + MOTION + "&branch parameter = 'clearance', low = 22, high = 25 /\n",
                  "--tolerance 2: must be from 1e-13 to 1 for case, a &branch"),
    "zone": ("", DAMPER.replace(", r = 1.04", "") + f"&zone sides = 'RRL', {WINDOW} /\n",
             "with symmetric = True and the pattern RL"),
}  # fmt: skip


def test_motion_of_a_structure_is_proven(tool):
    """A &motion with a &structure has a certificate that is accepted."""
    write(tool.cwd / "wall.nml", STRUCTURE)
    done = tool("prove", "wall.nml")
    assert (done.status, done.err) == (0, b"")
    assert b"impacts on gap 0 in 1 cycle at Omega = 1.0: exists, admissible, stable" in done.out
    assert accepted(tool.cwd / "results" / "wall_proof.json")[0] == 0
    write(
        tool.cwd / "path.nml", STRUCTURE + "&branch parameter = 'load', low = 0.9, high = 1.1 /\n"
    )
    done = tool("prove", "path.nml")
    assert (done.status, done.err) == (0, b"")
    assert b"for load 0.9 to 1.1 in 1 box: exists, admissible, stable" in done.out
    assert accepted(tool.cwd / "results" / "path_proof.json")[0] == 0


@pytest.mark.parametrize("case", REFUSED)
def test_what_has_no_proof_is_refused(tool, case):
    """Each refusal has one clear line, status 2 and no file."""
    words, text, message = REFUSED[case]
    write(tool.cwd / "case.nml", text)
    done = tool("prove", "case.nml", *words.split())
    assert done.status == 2
    assert message in done.err.decode()
    assert done.err.decode().count("\n") == 1
    assert list(contents(tool.cwd)) == ["case.nml"]


def test_nothing_is_there_or_decided(tool):
    """A case without motions has status 1 and no certificate; an undecided certificate gives the reason."""
    write(tool.cwd / "none.nml", DAMPER + MOTION.replace("25", "500"))
    write(tool.cwd / "flat.nml", DAMPER.replace("0.75", "0") + MOTION)
    done = tool("prove", "none.nml")
    assert (done.status, done.err) == (1, b"none: there is no motion, branch or zone to prove\n")
    assert list(contents(tool.cwd)) == ["flat.nml", "none.nml"]
    done = tool("prove", "flat.nml")
    assert done.status == 0
    assert b"admissible not decided" in done.out
    assert (
        b"not decided: the speeds at the ends of flight 0 are not separated from zero" in done.out
    )


def test_without_the_extra(tmp_path, capsys, monkeypatch):
    """Without the library nothing is computed, and the message says how to install it."""
    monkeypatch.setitem(sys.modules, "flint", None)
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "pair.nml", DAMPER + MOTION)
    assert main(["prove", "pair.nml"]) == 1
    output = "proofs need python-flint: pip install 'vibroimpact[proof]'"
    assert capsys.readouterr() == ("", f"vibroimpact prove: {output}\n")
    assert list(contents(tmp_path)) == ["pair.nml"]


def test_for_scripts(tool):
    """`--json` has the certificates among the results."""
    write(tool.cwd / "case.nml", DAMPER + MOTION)
    document = json.loads(tool("prove", "case.nml", "--json").out)
    assert document["status"] == 0
    assert document["files"] == ["results/case_1_proof.json", "results/case_2_proof.json"]
    assert document["results"]["case_1"]["type"] == "Certificate"
