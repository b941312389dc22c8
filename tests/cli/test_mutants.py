"""The tool that tries mutants of the core: what it changes, and its list of survivors."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/quality"))

from kills import Trial  # noqa: E402
from mutants import code_of, mutants_of  # noqa: E402
from mutate import ROOMS, listed, sample  # noqa: E402

SOURCE = """module vi_sample
   use vi_kinds, only: wp
   integer, parameter :: terms = 3
   integer :: unused = 4
contains
   subroutine change(x, n)  ! a + b
      real(wp), intent(inout) :: x(2)
      if (n < 1 .or. .not. x(1) > 2.0e-3_wp) return
      x(1) = max(x(1), -abs(x(2)))
      print *, 'n + 1'
   end subroutine change
end module vi_sample
"""


def test_each_kind_of_change(tmp_path):
    """Operators, constants, bounds, signs and statements are changed; texts, comments and declarations are not."""
    (tmp_path / "sample.f90").write_text(SOURCE)
    found = {(m.line, m.after.strip()) for m in mutants_of(tmp_path, "sample.f90")}
    assert found >= {
        (3, "integer, parameter :: terms = 4"),
        (8, "if (n >= 1 .or. .not. x(1) > 2.0e-3_wp) return"),
        (8, "if (n < 1 .and. .not. x(1) > 2.0e-3_wp) return"),
        (8, "if (n < 1 .or. x(1) > 2.0e-3_wp) return"),
        (8, "continue"),
        (9, "x(1) = min(x(1), -abs(x(2)))"),
        (9, "x(1) = max(x(1), abs(x(2)))"),
        (9, "x(1) = max(x(1), -(x(2)))"),
        (9, "continue"),
    }
    assert {line for line, _ in found} == {3, 8, 9}
    assert code_of("a = 'it''s + 1' ! - 2").split() == ["a", "="]


@pytest.mark.parametrize("folder", ROOMS)
def test_one_line_of_one_file(folder):
    files = [
        str(path.relative_to(ROOT)) for path in sorted((ROOT / "src" / folder).rglob("[p-s]*.f90"))
    ]
    drawn = sample(files, 20, 5)
    assert drawn == sample(files, 20, 5) != sample(files, 20, 6)
    for mutant in drawn:
        before = (ROOT / mutant.file).read_text(encoding="utf-8").splitlines()
        after = mutant.source(ROOT).splitlines()
        changed = [
            i for i, pair in enumerate(zip(before, after, strict=True), 1) if len(set(pair)) > 1
        ]
        assert changed == [mutant.line]


def test_survivors_are_mutants_of_today():
    """Every survivor is a mutant of the present code, and has a reason."""
    for (file, before, after), reason in listed().items():
        of_today = {(m.before.strip(), m.after.strip()) for m in mutants_of(ROOT, file)}
        assert (before, after) in of_today
        assert len(reason) > 20


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("--sample", "0"),
        ("--sample", "-3"),
        ("--sample", "x"),
        ("-j", "0"),
        ("--least", "101"),
        ("--least", "nan"),
    ],
)
def test_bad_options(option, value):
    """The message names the option, its value and what is allowed."""
    told = subprocess.run(
        [sys.executable, ROOT / "tests/quality/mutate.py", option + "=" * option.startswith("--") + value],
        capture_output=True, text=True,
    )  # fmt: skip
    assert told.returncode == 2
    assert option in told.stderr
    assert repr(value) in told.stderr
    assert "Traceback" not in told.stderr


@pytest.mark.parametrize("end", [*range(8), 127, "signal", "exception", "in vain"])
def test_a_process_that_ends_by_itself_has_noticed_a_mutant(end):
    """LAPACK ends a process with status 0, the Fortran runtime with 2, a memory fault with a signal."""

    class Ends(Trial):
        def __init__(self):
            pass

        def notices(self, number, cases, out, alone=""):
            os.write(out, (0).to_bytes(4, "little"))
            os.write(out, (1).to_bytes(4, "little"))
            if end == "signal":
                os.kill(os.getpid(), signal.SIGKILL)
            if end == "exception":
                raise ValueError
            if end == "in vain":
                return False
            os._exit(end)

    assert Ends().noticed(1, []) == (-1 if end == "in vain" else 1)
