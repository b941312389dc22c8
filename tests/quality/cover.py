"""The lines that the tests run: of the Fortran sources by gcovr, of the Python package by coverage.py.

A build that counts lines is installed, as a plain package, in a separate environment. The Fortran tests and then
all other tests run there, with every process that they start: the program, the C library, commands, servers and
workers. The reports are in build/coverage, as HTML (fortran/index.html, python/index.html), text and JSON. The
exit status is 0 only if enough lines of each language are run and no test fails. Further arguments go to pytest:
`-n 2 --dist loadfile` runs two files at a time, and the name of a test file shows which lines this file runs.
"""

import argparse
import importlib.util
import json
import os
import shutil
import subprocess
import sys
import time
import venv
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
HERE = ROOT / "build/coverage"
BUILD, ENVIRONMENT, CONFIG = HERE / "build", HERE / "env", HERE / "coverage.ini"
FORTRAN, PYTHON = HERE / "fortran.json", HERE / "python.json"
#: Tools of this environment come first, whether it is activated or not.
SEARCH = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
#: Tests that measure memory, which counters need, too; and those in which nothing can be counted, or counts are
#: spoiled: nothing can be written, or a process is killed.
LEFT_OUT = (
    "not claims_too_much and not small_stacks and not full_disk and not size_limit and not at_the_start"
    " and not test_faults"
)
#: Lines are counted before the compiler moves them. A count that two threads spoil may even be negative, and a
#: whole run counts more than gcovr takes for true: neither matters for whether a line is run.
OPTIONS = (
    "-Db_coverage=true", "-Doptimization=1", "-Ddebug=false", "-Dlibrary_for_c=disabled",
)  # fmt: skip
SETTINGS = f"""[run]
source_pkgs = vibroimpact, vibroimpact_start
omit =
    */vibroimpact/_build.py
    */pytest-of-*
parallel = true
data_file = {HERE}/counts/python
patch = _exit, execv, fork
sigterm = true
[paths]
package =
    {ROOT}/python
    {ENVIRONMENT}/lib/*/site-packages
[report]
exclude_also =
    if TYPE_CHECKING:
    @overload
    raise NotImplementedError
"""


def main() -> int:
    """Build, test, and report."""
    parser = argparse.ArgumentParser(
        prog="./run coverage", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument(
        "--least",
        type=float,
        default=95,
        metavar="P",
        help="percentage of lines, of either language (95)",
    )
    parser.add_argument(
        "--add", action="store_true", help="add to what earlier runs counted, if no source changed"
    )
    parser.add_argument(
        "--report", action="store_true", help="report what was counted, without a test"
    )
    parser.add_argument(
        "--fortran-only",
        type=Path,
        metavar="FOLDER",
        help="the Fortran tests alone, in a build with -Db_coverage=true",
    )
    asked, for_pytest = parser.parse_known_args()
    if not 0 <= asked.least <= 100:
        parser.error(f"--least {asked.least:g} is no percentage from 0 to 100")
    for module in ("gcovr", "coverage", "pytest"):
        if importlib.util.find_spec(module) is None:
            parser.error(f"{module} is missing: python -m pip install gcovr coverage pytest")
    for program in ("meson", "ninja", "gcov"):
        if shutil.which(program, path=SEARCH) is None:
            parser.error(f"{program} is missing: python -m pip install meson ninja; gcc has gcov")
    if asked.fortran_only:
        folder = asked.fortran_only.resolve()
        passed = test_fortran(folder)
        return int(not (report_fortran(folder, asked.least) and passed))
    passed = True
    if not asked.report:
        build(asked.add)
        passed = test_fortran(BUILD)
        passed &= test_package(for_pytest)
    enough = report_fortran(BUILD, asked.least)
    enough &= report_python(asked.least)
    print(f"\nAll lines: {HERE}/fortran/index.html, {HERE}/python/index.html")
    return int(not (enough and passed))


def run(*command: object, **environment: str) -> bool:
    """Run a command in the project's folder, print how long it took, and return whether it succeeded."""
    words = [str(word) for word in command]
    print("::", " ".join(words), flush=True)
    begin = time.monotonic()
    status = subprocess.run(
        words, cwd=ROOT, env={**os.environ, "PATH": SEARCH} | environment
    ).returncode
    print(f":: {time.monotonic() - begin:.0f} s, exit status {status}", flush=True)
    return status == 0


def build(add: bool) -> None:
    """Install the counting build, and discard earlier counts unless new ones are to be added."""
    (HERE / "counts").mkdir(parents=True, exist_ok=True)
    CONFIG.write_text(SETTINGS, encoding="utf-8")
    venv.create(ENVIRONMENT, symlinks=True)
    (site,) = ENVIRONMENT.glob("lib/*/site-packages")
    # the tools of this environment without its editable package; every process is measured
    tools = [folder for folder in sys.path if folder.endswith("site-packages")]
    start = "import coverage; coverage.process_startup()"
    (site / "tools.pth").write_text("\n".join([*tools, start, ""]), encoding="utf-8")
    pip = [sys.executable, *["-m", "pip", "--python"], ENVIRONMENT / "bin/python"]
    install = [
        "install",
        ".",
        "--verbose",
        "--no-build-isolation",
        "--no-deps",
        "--force-reinstall",
    ]
    options = [f"-Csetup-args={option}" for option in OPTIONS]
    # the library for C is not part of a wheel and is built afterwards
    if not (
        run(*pip, *install, f"-Cbuild-dir={BUILD}", *options)
        and run("meson", "configure", BUILD, "-Dlibrary_for_c=enabled")
        and run("ninja", "-C", BUILD)
    ):
        sys.exit("cover: the package was not built")
    for path in () if add else (*BUILD.rglob("*.gcda"), *HERE.glob("counts/*")):
        path.unlink()


def test_fortran(folder: Path) -> bool:
    """Run the Fortran tests of a build; return whether all passed."""
    return run("meson", "test", "-C", folder, *["--timeout-multiplier", "10", "--print-errorlogs"])


def test_package(for_pytest: list[str]) -> bool:
    """Run the tests by pytest; return whether all passed."""
    python = ENVIRONMENT / "bin/python"
    # -p no:cacheprovider: keep the list of tests that failed last in the ordinary build
    return run(
        python, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-k", LEFT_OUT, *for_pytest,
        COVERAGE_PROCESS_START=str(CONFIG),
        VIBROIMPACT_FORTRAN_BUILD=str(BUILD),
        PATH=f"{python.parent}{os.pathsep}{SEARCH}",
        # a process that cannot write its counts does not report it among its messages
        GCOV_ERROR_FILE=str(HERE / "gcov.log"),
    )  # fmt: skip


def report_fortran(folder: Path, least: float) -> bool:
    """Report the covered lines of a build; return whether there are enough."""
    (HERE / "fortran").mkdir(parents=True, exist_ok=True)
    pages = ["--html-nested", HERE / "fortran/index.html", "--txt", HERE / "fortran.txt"]
    if not run(
        "gcovr", "--root", ROOT, "--object-directory", folder, "--filter", "src/", "--filter", "python/boundary/",
        "--gcov-ignore-errors=all", "--gcov-ignore-parse-errors=all",
        "--merge-mode-functions=merge-use-line-min", "--json-summary", FORTRAN,
        *(pages if folder == BUILD else []), folder,
    ):  # fmt: skip
        return False
    found = json.loads(FORTRAN.read_text(encoding="utf-8"))["files"]
    lines = [(file["filename"], file["line_covered"], file["line_total"]) for file in found]
    return table("Fortran", lines, least)


def report_python(least: float) -> bool:
    """Report the covered lines of the package; return whether there are enough."""
    coverage, config = [sys.executable, "-m", "coverage"], f"--rcfile={CONFIG}"
    good = True
    if parts := [*HERE.glob("counts/python.*")]:
        good = run(*coverage, "combine", "--append", "--quiet", config)
        for part in parts:  # left by processes that were killed
            part.unlink(missing_ok=True)
    # tests ran copies of files that no longer exist
    options = ["--quiet", "--ignore-errors", config]
    if not (
        good
        and run(*coverage, "html", "-d", HERE / "python", *options)
        and run(*coverage, "json", "-o", PYTHON, *options)
    ):
        return False
    found = json.loads(PYTHON.read_text(encoding="utf-8"))["files"]
    return table(
        "Python",
        [
            (name, file["summary"]["covered_lines"], file["summary"]["num_statements"])
            for name, file in found.items()
        ],
        least,
    )


def table(language: str, files: list[tuple[str, int, int]], least: float) -> bool:
    """Print the coverage of folders, and the files with the most uncovered lines; return whether it suffices."""
    covered, total = Counter(), Counter()
    for name, run_lines, lines in files:
        for folder in (str(Path(name).parent), "all"):
            covered[folder] += run_lines
            total[folder] += lines
    print(f"\n{language:<42}{'lines':>8}{'not run':>9}{'run':>9}")
    for folder in sorted(total, key=lambda folder: (folder == "all", folder)):
        share = 100 * covered[folder] / max(1, total[folder])
        print(f"{folder:<42}{total[folder]:>8}{total[folder] - covered[folder]:>9}{share:>8.2f}%")
    print("most lines that are not run:")
    for name, run_lines, lines in sorted(files, key=lambda file: file[1] - file[2])[:10]:
        print(f"  {name:<40}{lines:>8}{lines - run_lines:>9}")
    share = 100 * covered["all"] / max(1, total["all"])
    if share < least:
        print(
            f"cover: of {language}, {share:.2f} % of the lines are run, not {least:g} %",
            file=sys.stderr,
        )
    return share >= least


if __name__ == "__main__":
    sys.exit(main())
