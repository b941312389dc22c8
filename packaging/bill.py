"""The software bill of materials of a wheel: every library in it with version, licence and where it came from.

auditwheel lists the shared libraries that it copied; what is linked statically, the licences and the checksums are
added here. It is CycloneDX 1.6, in dist-info/sboms of the wheel.
"""

import hashlib
import json
import platform
import re
import shutil
import subprocess
from fnmatch import fnmatch
from importlib.metadata import version

from cyclonedx.model import HashType
from cyclonedx.model.bom import Bom
from cyclonedx.model.component import Component, ComponentType
from cyclonedx.model.license import LicenseExpression
from cyclonedx.output.json import JsonV1Dot6
from packageurl import PackageURL

NAME = "vibroimpact.cdx.json"
RUNTIME = "GPL-3.0-or-later WITH GCC-exception-3.1"
#: SPDX expressions of the packages that a wheel may carry.
LICENCES = {
    "vibroimpact": "BSD-3-Clause",
    "libgfortran*": RUNTIME,
    "libgomp*": RUNTIME,
    "libgcc*": RUNTIME,
    "libquadmath*": "LGPL-2.1-or-later",
    "liblapack*": "BSD-3-Clause-Open-MPI",
    "lapack*": "BSD-3-Clause-Open-MPI",
    "libblas*": "BSD-3-Clause-Open-MPI",
    "blas*": "BSD-3-Clause-Open-MPI",
    "*openblas*": "BSD-3-Clause",
}


def licence(package):
    """The licence of a package, which has to be known."""
    known = [text for pattern, text in LICENCES.items() if fnmatch(package, pattern)]
    assert known, f"{package}: whose licence that is, bill.py does not know"
    return LicenseExpression(known[0])


def system_package(name):
    """A package of the system, as a component."""
    deb = shutil.which("dpkg-query") is not None
    ask = (
        ["dpkg-query", "-W", "-f", "${Version}"]
        if deb
        else ["rpm", "-q", "--queryformat", "%{VERSION}"]
    )
    found = subprocess.run([*ask, name], check=True, capture_output=True, text=True).stdout
    system = platform.freedesktop_os_release()["ID"]
    return component(name, found, PackageURL("deb" if deb else "rpm", system, name, found))


def component(name, found, purl):
    """A library of a version, from where a package URL says."""
    return Component(
        type=ComponentType.LIBRARY, name=name, version=found, purl=purl, bom_ref=purl.to_string(),
        licenses=[licence(name)],
    )  # fmt: skip


def add(wheel, static, lapack):
    """Write the bill of an unpacked wheel, with the packages linked statically, or where its LAPACK came from."""
    (info,) = wheel.glob("*.dist-info")
    (copied,) = info.glob("sboms/auditwheel.cdx.json")
    bill = Bom.from_json(json.loads(copied.read_text(encoding="utf-8")))
    own = bill.metadata.component
    bill.components = [part for part in bill.components if part.name != own.name]
    for part in [own, *bill.components]:
        part.licenses = [licence(part.name)]
    for path in wheel.glob("*.libs/*"):
        stem = re.match(r"[a-z_]+", path.name)[0]
        (part,) = (part for part in bill.components if part.name.startswith(stem))
        digest = hashlib.sha256(path.read_bytes()).hexdigest()
        part.hashes = [HashType.from_hashlib_alg("sha256", digest)]
    more = [system_package(name) for name in static]
    if lapack == "scipy-openblas32":
        found = version(lapack)
        more.append(component(lapack, found, PackageURL("pypi", None, lapack, found)))
    for part in more:
        bill.components.add(part)
    bill.register_dependency(own, more)
    text = JsonV1Dot6(bill).output_as_string(indent=1)
    (info / "sboms" / NAME).write_text(text + "\n", encoding="utf-8")
