"""Put the licences of the libraries that a self-contained wheel carries into it, and its bill of materials.

    python packaging/licences.py FILE.whl

They are taken from the packages that the libraries came from: those that auditwheel copied are in its
list (sboms), and vibroimpact/_build.py says which LAPACK was linked. The wheel is written anew.
"""

import json
import re
import runpy
import shutil
import subprocess
import sys
from importlib.metadata import files
from pathlib import Path
from tempfile import TemporaryDirectory

import bill

COMMON = Path("/usr/share/common-licenses")


def printed(*command):
    """What a command prints."""
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


def owner(path):
    """The package of the system that a file belongs to."""
    if shutil.which("dpkg"):
        return re.match(r"[^:,]+", printed("dpkg", "-S", path))[0]
    return printed("rpm", "-q", "--queryformat", "%{NAME}", "-f", path)


def static_archives():
    """The reference LAPACK, where packaging/lapack/meson.build finds it."""
    for name in ("lapack", "blas"):
        path = printed("gfortran", f"-print-file-name={name}/lib{name}.a")
        if path.startswith("/"):
            yield Path(path).resolve()


def packages(wheel):
    """The packages of the system whose libraries are in an unpacked wheel."""
    for copied in wheel.glob("*.dist-info/sboms/auditwheel.cdx.json"):
        for component in json.loads(copied.read_text(encoding="utf-8"))["components"]:
            if found := re.match(r"pkg:(?:deb|rpm)/[^/]+/([^@]+)@", component["purl"]):
                yield found[1]
    yield from static(wheel)


def static(wheel):
    """The packages of the system that are linked statically."""
    return [*map(owner, static_archives())] if lapack(wheel) == "reference LAPACK, static" else []


def lapack(wheel):
    """Which LAPACK the wheel was built with."""
    return runpy.run_path(str(wheel / "vibroimpact" / "_build.py"))["FACTS"]["lapack"]


def system_texts(package):
    """The files with a package's licence, by the names that they get in the wheel."""
    if shutil.which("dpkg"):
        copyright_file = Path("/usr/share/doc", package, "copyright")
        found = {f"{package}/copyright": copyright_file}
        # it names the common ones only; a name without a number, as LGPL, is each version of it
        named = re.findall(rf"{COMMON}/([\w.-]*\w)", copyright_file.read_text(encoding="utf-8"))
        for path in (path for name in named for path in COMMON.glob(f"{name}*")):
            if not path.is_symlink():
                found[f"common-licenses/{path.name}"] = path
        return found
    listed = map(Path, printed("rpm", "-q", "--licensefiles", package).splitlines())
    return {f"{package}/{path.name}": path for path in listed}


def texts(wheel):
    """All that belong into an unpacked wheel."""
    found = {}
    for package in packages(wheel):
        found |= system_texts(package)
    if lapack(wheel) == "scipy-openblas32":
        listed = (path for path in files("scipy-openblas32") if "LICENSE" in path.name)
        found |= {f"scipy-openblas32/{path.name}": path.locate() for path in listed}
    return found


def add(wheel):
    """The texts go into dist-info/licenses, their names into METADATA (PEP 639)."""
    (info,) = wheel.glob("*.dist-info")
    found = texts(wheel)
    for name, path in found.items():
        target = info / "licenses" / name
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, target)
    metadata = (info / "METADATA").read_text(encoding="utf-8")
    lines = "".join(f"License-File: {name}\n" for name in sorted(found))
    assert "License-File: LICENSE\n" in metadata
    metadata = metadata.replace("License-File: LICENSE\n", f"License-File: LICENSE\n{lines}", 1)
    (info / "METADATA").write_text(metadata, encoding="utf-8")
    return found


if __name__ == "__main__":
    file = Path(sys.argv[1])
    with TemporaryDirectory() as folder:
        tool = [sys.executable, "-m", "wheel"]
        subprocess.run([*tool, "unpack", "--dest", folder, file], check=True)
        (unpacked,) = Path(folder).iterdir()
        print(*sorted(add(unpacked)), sep="\n")
        bill.add(unpacked, static(unpacked), lapack(unpacked))
        for made in unpacked.glob(f"*.dist-info/sboms/{bill.NAME}"):
            shutil.copyfile(made, file.with_suffix(".cdx.json"))
        # writes RECORD anew
        subprocess.run([*tool, "pack", "--dest-dir", file.parent, unpacked], check=True)
