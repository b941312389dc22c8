"""The lines that the tests run: of the Fortran core by gcovr, of the Python package by coverage.py.

A build of its own counts lines; the Fortran tests and then the Python tests run with it. Arguments go to
pytest. The reports are in build/coverage, as text and HTML. The exit status is 0 only if 95 % of the lines of
either are run, and no test fails.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

from package import copy_package, core_of, variables

ROOT = Path(__file__).resolve().parents[2]
HERE = ROOT / "build/coverage"
LEAST = "95"
#: Tests that measure time, or say what an ordinary build is.
LEFT_OUT = "not claims_too_much and not small_stacks"


def run(*command: object, **environment: str) -> bool:
    """Run a command in the project's folder; return whether it went well."""
    words = [str(word) for word in command]
    print("::", " ".join(words), flush=True)
    return subprocess.run(words, cwd=ROOT, env={**os.environ, **environment}).returncode == 0


def main() -> int:
    """Build, test, and report."""
    build, site, data = HERE / "build", HERE / "site", HERE / "python.data"
    HERE.mkdir(parents=True, exist_ok=True)
    if not (build / "build.ninja").exists():
        # lines are counted before the compiler moves them; a count that two threads spoil is still above 0
        options = [
            "-Db_coverage=true",
            "-Doptimization=1",
            "-Ddebug=false",
            "-Dlibrary_for_c=disabled",
        ]
        if not run("meson", "setup", build, "-Dpython=enabled", *options):
            return 1
    for path in (*build.rglob("*.gcda"), *HERE.glob("python.data*")):
        path.unlink()
    good = run("ninja", "-C", build)
    good &= run("meson", "test", "-C", build, "--timeout-multiplier", "10", "--print-errorlogs")
    shutil.rmtree(site, ignore_errors=True)
    # processes that tests start are measured, too
    core = copy_package(site, build, "import coverage; coverage.process_startup()\n")
    core.symlink_to(core_of(build))
    config = HERE / "coverage.ini"
    config.write_text(f"[run]\nsource_pkgs = vibroimpact\nparallel = true\ndata_file = {data}\n")
    coverage = [sys.executable, "-m", "coverage"]
    good &= run(
        *coverage, "run", f"--rcfile={config}", "-m", "pytest", "-q", "-p", "no:cacheprovider",
        "-k", LEFT_OUT, *sys.argv[1:],
        COVERAGE_PROCESS_START=str(config), **variables(site, build / "src/vibroimpact-batch"),
    )  # fmt: skip
    good &= run(
        "gcovr", "--root", ROOT, "--object-directory", build, "--filter", "src/", "--gcov-ignore-errors=all",
        "--txt", HERE / "fortran.txt", "--html-nested", HERE / "fortran.html", "--print-summary",
        "--fail-under-line", LEAST, build,
    )  # fmt: skip
    good &= run(*coverage, "combine", f"--rcfile={config}", "-q")
    good &= run(*coverage, "html", f"--rcfile={config}", "-q", "-d", HERE / "python")
    with (HERE / "python.txt").open("w") as out:
        subprocess.run([*coverage, "report", f"--rcfile={config}"], cwd=ROOT, stdout=out)
    good &= run(
        *coverage, "report", f"--rcfile={config}", f"--fail-under={LEAST}", "--skip-covered"
    )
    return int(not good)


if __name__ == "__main__":
    sys.exit(main())
