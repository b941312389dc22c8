"""Make a copy of the Python package with another build of the core, not hidden by an editable install."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
#: Python reads this file first; it hides the editable package, which would otherwise be found first.
HIDE = "import sys; sys.meta_path[:] = [f for f in sys.meta_path if type(f).__name__ != 'MesonpyMetaFinder']\n"
#: Makes glibc use its sines for processors without fused multiply-add.
PLAIN_SINES = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX2_Usable,-FMA_Usable"}


def copy_package(site: Path, build: Path) -> Path:
    """Link the files of the package into a folder for PYTHONPATH; return the path at which the module _core
    belongs.

    `build` is the folder of a build that contains the files of the package that meson generates.
    """
    package = site / "vibroimpact"
    package.mkdir(parents=True)
    (site / "sitecustomize.py").write_text(HIDE, encoding="utf-8")
    written = (path for path in (build / "python").glob("_*.py"))
    for path in (*(ROOT / "python/vibroimpact").iterdir(), *written):
        (package / path.name).symlink_to(path)
    (site / "vibroimpact_start.py").symlink_to(ROOT / "python/vibroimpact_start.py")
    return package / core_of(build).name


def core_of(build: Path) -> Path:
    """Return the module _core of a build."""
    return next((build / "python").glob("_core.*.so"))


def variables(site: Path, program: Path) -> dict[str, str]:
    """Return the environment of tests with such a copy."""
    return {"PYTHONPATH": str(site), "VIBROIMPACT_BATCH": str(program), "VIBROIMPACT_BUILT": "1"}
