"""The command completion, tested in the shells."""

import shutil
import subprocess
import sys

import pytest
from programs import ROOT, Runner, find_command
from vibroimpact.cases.case import kinds
from vibroimpact.commands import FORMATS, NAMES
from vibroimpact.commands.command import main


@pytest.fixture
def script(tmp_path):
    """The completion script for a shell, in a file; skips if the shell is not installed."""

    def write(shell):
        if shutil.which(shell) is None:
            pytest.skip(f"no {shell} here")
        done = Runner([find_command()], tmp_path)("completion", shell)
        assert (done.status, done.err) == (0, b"")
        (tmp_path / "script").write_bytes(done.out)
        return tmp_path / "script"

    return write


def answer(words, cwd):
    """The output of a shell, as a set of words."""
    done = subprocess.run(words, capture_output=True, text=True, cwd=cwd, timeout=60, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    return set(done.stdout.split())


#: Typed words, and some of their completions.
TYPED = [
    ("vibroimpact ", {*NAMES}),
    ("vibroimpact zo", {"zone"}),
    ("vibroimpact zone --format ", {*FORMATS}),
    ("vibroimpact zone --format n", {"netcdf"}),
    ("vibroimpact zone --symm", {"--symmetric"}),
    ("vibroimpact find --form", {"--format"}),
    ("vibroimpact find --plot ", {"png", "svg", "pdf"}),
    ("vibroimpact bifurcation --spacing ", {"linear", "geometric"}),
    ("vibroimpact plot --format ", {"png", "svg", "pdf"}),
    ("vibroimpact init ", {*kinds(structures=False), "structure", "stops"}),
    ("vibroimpact reproduce tab", {"table1"}),
    ("vibroimpact run inputs/table1", {"inputs/table1.nml", "inputs/table1_single.nml"}),
]


@pytest.mark.parametrize(("typed", "wanted"), TYPED)
def test_bash(typed, wanted, script):
    """The completion function, called as bash calls it, gives the completions."""
    path = script("bash")
    words = typed.split(" ")
    array = " ".join(f"'{word}'" for word in words)
    code = f"source {path}; COMP_WORDS=({array}); COMP_CWORD={len(words) - 1}; _shtab_vibroimpact; "
    code += 'echo "${COMPREPLY[@]}"'
    found = answer(["bash", "-c", code], ROOT)
    assert found - {"--help", "--version"} == wanted


def test_bash_takes_a_file_with_a_blank_as_one(script, tmp_path):
    """A file name with a blank is completed as one word."""
    (tmp_path / "two words.nml").touch()
    code = f"source {script('bash')}; COMP_WORDS=(vibroimpact run tw); COMP_CWORD=2; _shtab_vibroimpact; "
    code += 'printf "%s|" "${COMPREPLY[@]}"'
    done = subprocess.run(
        ["bash", "-c", code], capture_output=True, text=True, cwd=tmp_path, check=True
    )
    assert done.stdout == "two words.nml|"


@pytest.mark.parametrize(("typed", "wanted"), TYPED)
def test_fish(typed, wanted, script):
    """fish gives the completions."""
    path = script("fish")
    done = subprocess.run(
        ["fish", "--no-config", "-c", f"source {path}; complete -C '{typed}'"],
        capture_output=True, text=True, cwd=ROOT, timeout=60, check=False,
    )  # fmt: skip
    found = {line.split("\t")[0] for line in done.stdout.splitlines()}
    assert wanted <= found
    if not typed.endswith("/"):
        last = typed.split(" ")[-1]
        assert all(item.startswith(last) for item in found)


def test_zsh_takes_it(script):
    """zsh sources the script without an error, and binds the completion to the command."""
    path = script("zsh")
    code = f'autoload -Uz compinit && compinit -D -u; eval "$(cat {path})"; echo ${{_comps[vibroimpact]}}'
    assert "vibroimpact" in " ".join(answer(["zsh", "-f", "-c", code], ROOT))


def test_every_command_and_option_is_there(script):
    """Each script has all commands, and options of several of them."""
    for shell in ("bash", "fish"):
        if shutil.which(shell):
            text = script(shell).read_text()
            for name in NAMES:
                assert name in text
            for word in (
                "longest-step",
                "inverse-clearance",
                "spacing",
                "state",
                "quantity",
                "quiet",
            ):
                assert word in text


def test_missing_library(monkeypatch, capsys):
    """Without the library, one line says what to install; status 1, and nothing else is printed."""
    monkeypatch.setitem(sys.modules, "shtab", None)
    assert main(["completion", "bash"]) == 1
    output = "completion in a shell needs shtab: pip install 'vibroimpact[completion]'"
    assert capsys.readouterr() == ("", f"vibroimpact completion: {output}\n")
