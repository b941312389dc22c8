"""Test a wheel where a user would be: a clean environment, and no compiler and no BLAS in sight.

    python packaging/test_wheel.py FILE.whl [PYTHON]

The Python that runs this has the package built in the tree, and mypy; the wheel is for it, or for
another that is named. Everything is in build/wheel.
"""

import base64
import csv
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
from fnmatch import filter as fnmatch_filter
from fnmatch import fnmatch
from pathlib import Path
from zipfile import ZipFile

import bill
from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator
from elftools.elf.elffile import ELFFile
from hide import HIDDEN, hidden

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "build" / "wheel"
PYTHON = FOLDER / "env" / "bin" / "python"
CASE = ROOT / "inputs" / "table1.nml"
GCC = "GCC RUNTIME LIBRARY EXCEPTION"
#: Of each library that a wheel may carry: the package that its licence came from, and words of it.
LICENCES = {
    "libgfortran": ("libgfortran*", GCC),
    "libgomp": ("libgomp*", GCC),
    "libgcc_s": ("libgcc*", GCC),
    "libquadmath": ("libquadmath*", "(Library|Lesser) General Public"),
    "liblapack": ("liblapack*", "University of Tennessee"),
    "libblas": ("libblas*", "University of Tennessee"),
    "libopenblas": ("libopenblas*", "OpenBLAS"),
    "libscipy_openblas": ("scipy-openblas32", "OpenBLAS"),
}
USER_SCRIPT = """import vibroimpact as vi

osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
motion: vi.Motion = vi.equispaced(osc, r=0.94, clearance=37.0)[0]
attenuation: float = motion.attenuation
"""


def install(wheel, python=sys.executable):
    """A new environment with the wheel and what it asks for, and nothing else."""
    shutil.rmtree(FOLDER / "env", ignore_errors=True)
    subprocess.run([python, "-m", "venv", "--without-pip", FOLDER / "env"], check=True)
    pip = [sys.executable, "-m", "pip", "--python", PYTHON, "--quiet", "install"]
    subprocess.run([*pip, wheel], check=True)


def check_in_clean_environment():
    """The module, the commands and the program; for what should be hidden and is not, say so."""
    # the user's variables stay outside
    bare = {
        "PATH": f"{PYTHON.parent}:/usr/bin:/bin",
        "HOME": str(FOLDER),
        "OPENBLAS_NUM_THREADS": "1",
    }
    check = [str(PYTHON), str(Path(__file__).with_name("check_installed.py")), str(CASE)]
    line = hidden([*HIDDEN], [*check, *HIDDEN])
    if not line:
        print("not hidden (no mount namespaces here): libraries; the compiler is out of PATH only")
        line, bare["PATH"] = [*check, "compiler"], str(PYTHON.parent)
    tool = shutil.which(line[0]) or line[0]
    if subprocess.run([tool, *line[1:]], cwd=FOLDER, env=bare).returncode != 0:
        sys.exit("test_wheel: the installed wheel fails the checks of check_installed.py")


def lapack(python):
    """Which LAPACK the package of a Python has."""
    code = "from vibroimpact._build import FACTS; print(FACTS['lapack'])"
    return subprocess.check_output([python, "-c", code], cwd=FOLDER, text=True).strip()


def check_results():
    """The program of the wheel writes what that of the tree writes."""
    program = Path(sys.executable).with_name("vibroimpact-batch")
    subprocess.run([program, CASE, "-o", FOLDER / "expected"], check=True, capture_output=True)
    same_lapack = lapack(PYTHON) == lapack(sys.executable)
    expected = {path.name: path.read_bytes() for path in (FOLDER / "expected").iterdir()}
    results = {path.name: path.read_bytes() for path in (FOLDER / "results").iterdir()}
    assert len(expected) == 4
    assert expected.keys() == results.keys()
    for name, text in expected.items():
        assert text == results[name] or (not same_lapack and close(text, results[name])), name
    print("results of the program: equal", "to the last bit" if same_lapack else "to 1e-12")


def close(one, other):
    """Whether two texts differ in the last digits of their numbers only."""
    number = rb"-?\d+\.\d+(?:E[+-]\d+)?"
    pairs = list(zip(re.findall(number, one), re.findall(number, other), strict=True))
    same_words = re.sub(number, b"", one).split() == re.sub(number, b"", other).split()
    return same_words and all(
        abs(float(a) - float(b)) <= 1e-12 * max(1, abs(float(a))) for a, b in pairs
    )


def check_licences(wheel):
    """The licence of each library that is in the wheel is there too, and RECORD knows every file."""
    with ZipFile(wheel) as opened:
        held = {name: opened.read(name) for name in opened.namelist() if not name.endswith("/")}
    (info,) = {name.split("/")[0] for name in held if ".dist-info/" in name}
    folder = f"{info}/licenses/"
    texts = {
        name.removeprefix(folder): text.decode()
        for name, text in held.items()
        if name.startswith(folder)
    }
    told = re.findall(r"^License-File: (.*)", held[f"{info}/METADATA"].decode(), re.MULTILINE)
    assert sorted(told) == sorted(texts)
    carried = carried_by(held)
    for library in carried:
        key = next((key for key in LICENCES if library.startswith(key)), None)
        assert key, f"{library}: whose licence that is, test_wheel.py does not know"
        package, words = LICENCES[key]
        own = [text for name, text in texts.items() if fnmatch(name, f"{package}/*")]
        assert any(re.search(words, text, re.IGNORECASE) for text in own), (
            f"{library}: no licence in {sorted(texts)}"
        )
        # what an exception is made from
        version = re.compile(r"GNU GENERAL PUBLIC LICENSE\s+Version 3")
        assert words != GCC or any(map(version.search, texts.values())), f"{library}: no GPL 3"
    record = held.pop(f"{info}/RECORD").decode().splitlines()
    sums = {name: sum256 for name, sum256, _ in csv.reader(record)}
    assert {**{name: digest(data) for name, data in held.items()}, f"{info}/RECORD": ""} == sums
    print("licences: of", *sorted(carried))


def carried_by(names):
    """The libraries among the files of a wheel."""
    paths = [Path(name) for name in names if re.search(r"\.libs/|/lib[^/]*\.(so|dylib)", name)]
    found = {re.match(r"lib[a-z_]+", path.name)[0] for path in paths}
    return found | (
        {"liblapack", "libblas"} if lapack(PYTHON) == "reference LAPACK, static" else set()
    )


def check_bill(wheel):
    """The bill of materials is valid, and has each library with a version, a licence and a source."""
    with ZipFile(wheel) as opened:
        (name,) = fnmatch_filter(opened.namelist(), f"*.dist-info/sboms/{bill.NAME}")
        text = opened.read(name).decode()
        libraries = carried_by(opened.namelist())
        sums = {
            hashlib.sha256(opened.read(name)).hexdigest()
            for name in opened.namelist() if ".libs/" in name
        }  # fmt: skip
    assert Path(wheel).with_suffix(".cdx.json").read_text(encoding="utf-8") == text
    assert JsonStrictValidator(SchemaVersion.V1_6).validate_str(text) is None
    parts = json.loads(text)["components"]
    for library in libraries:
        pattern = next(LICENCES[key][0] for key in LICENCES if library.startswith(key))
        (part,) = (part for part in parts if fnmatch(part["name"], pattern))
        assert all(part[key] for key in ("version", "licenses", "purl")), part
    assert len(parts) == len(libraries)
    assert sums == {one["content"] for part in parts for one in part.get("hashes", ())}
    print("bill of materials:", *(f"{part['name']} {part['version']}" for part in parts))


def check_checksums(wheel):
    """SHA256SUMS has each file that was made, and nothing else."""
    folder = Path(wheel).parent
    lines = (folder / "SHA256SUMS").read_text().splitlines()
    told = {name: number for number, name in (line.split("  ") for line in lines)}
    made = {
        path.name: hashlib.sha256(path.read_bytes()).hexdigest()
        for path in folder.glob("vibroimpact-*")
    }
    assert told == made
    print("checksums: of", *sorted(made))


def glibc_of(file):
    """The newest version of the C library that a file needs, as (2, 34)."""
    needed = ELFFile(file).get_section_by_name(".gnu.version_r")
    names = [item.name for _, items in needed.iter_versions() for item in items] if needed else []
    found = [name.removeprefix("GLIBC_") for name in names if re.fullmatch(r"GLIBC_[\d.]+", name)]
    return max((tuple(map(int, name.split("."))) for name in found), default=(2, 0))


def check_glibc(wheel):
    """What is compiled here needs no newer C library than what the compiler's libraries need."""
    needs = {}
    with ZipFile(wheel) as opened:
        for name in opened.namelist():
            with opened.open(name) as file:
                if file.read(4) == b"\x7fELF":
                    file.seek(0)
                    needs[name] = glibc_of(file)
    libraries = {name: need for name, need in needs.items() if ".libs/" in name}
    newest = max(libraries.values())
    assert all(need <= newest for need in needs.values()), needs
    holding = sorted(Path(name).name for name, need in libraries.items() if need == newest)
    print(f"needs glibc {newest[0]}.{newest[1]}, for:", *holding)


def digest(data):
    """As RECORD has it."""
    sum256 = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).decode().rstrip("=")
    return f"sha256={sum256}"


def check_types():
    """A user's script passes mypy --strict, and one with a wrong type does not."""
    mypy = [sys.executable, "-m", "mypy", "--strict", "--config-file=", "--cache-dir=cache"]
    for text, accepted in ((USER_SCRIPT, True), (USER_SCRIPT.replace(": float", ": str"), False)):
        (FOLDER / "user.py").write_text(text)
        done = subprocess.run(
            [*mypy, "--python-executable", PYTHON, "user.py"],
            cwd=FOLDER, capture_output=True, text=True, env={**os.environ, "MYPYPATH": ""},
        )  # fmt: skip
        assert (done.returncode == 0) == accepted, done.stdout + done.stderr
        assert accepted or "[assignment]" in done.stdout, done.stdout + done.stderr
    print("types of the installed package: mypy --strict agrees")


if __name__ == "__main__":
    for name in ("table1", "results", "expected"):
        shutil.rmtree(FOLDER / name, ignore_errors=True)
    install(*sys.argv[1:])
    check_in_clean_environment()
    check_results()
    for check in (check_licences, check_bill, check_checksums, check_glibc):
        check(sys.argv[1])
    check_types()
