"""Whether the version, which meson.build says, is the same elsewhere, and the recipe for conda fits.

usage: python .ci/check_version.py    (needs py-rattler-build)
"""

import re
import sys
import tomllib
from pathlib import Path

from rattler_build import JinjaConfig, PlatformConfig, RenderConfig, Stage0Recipe, VariantConfig

ROOT = Path(__file__).parents[1]
CONDA = ROOT / "packaging" / "conda"


def text(name):
    """What a file of the project says."""
    return (ROOT / name).read_text(encoding="utf-8")


version = re.search(r"^  version: '(.*)',$", text("meson.build"), re.MULTILINE)[1]
settings = tomllib.loads(text("pyproject.toml"))
project = settings["project"]
# the package that stands in for a system without LAPACK comes without a bound
building = {need for need in settings["build-system"]["requires"] if ">=" in need}
faults = [f"run does not install '{need}'" for need in building if f"'{need}'" not in text("run")]
for name, phrase in (
    ("CITATION.cff", f"\nversion: {version}\n"),
    ("docs/tutorial.md", f"\nvibroimpact {version}\n"),
    ("docs/howto/install.md", f" vibroimpact-{version}-cp"),
):
    if phrase not in text(name):
        faults.append(f"{name} does not have {phrase.strip()!r}")
recipe = Stage0Recipe.from_file(CONDA / "recipe.yaml")
for system in ("linux-64", "osx-arm64"):
    platform = PlatformConfig(target_platform=system)
    variants = VariantConfig.from_file_with_context(
        CONDA / "variants.yaml", JinjaConfig(platform=platform)
    )
    for rendered in recipe.render(variants, RenderConfig(platform=platform)):
        made = rendered.recipe.to_dict()
        said = made["package"]["version"], made["about"]["license"], made["about"]["summary"]
        if said != (version, project["license"], project["description"]):
            faults.append(f"recipe.yaml says {said}")
        needs = {need.replace(" ", "") for need in made["requirements"]["run"]}
        if needs != {"python", *project["dependencies"]}:
            faults.append(f"recipe.yaml needs {sorted(needs)}")
        host = {need.replace(" ", "") for need in made["requirements"]["host"]}
        if not building <= host:
            faults.append(f"recipe.yaml is built with {sorted(host)}, not with {sorted(building)}")
for fault in dict.fromkeys(faults):
    print(fault)
sys.exit(bool(faults))
