"""Run mutated namelists through the reader and runner of two builds, and some through the program itself."""

import json
import os
import random
import re
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from language import Language

#: Number of namelists in a full run, for two builds in turn, and number given to the program.
COUNT, PROGRAMS = 1_000_000, 2_000
#: CPU milliseconds after which a case is asked to stop.
BUDGET = 2
CHUNK = 2500
HEAD = struct.Struct("<3i")
BROKEN_LAW, BREAKDOWN, HANG, LEAK, LEAK_IN_BATCH = range(100, 105)
KINDS = {BREAKDOWN: "breaks down", HANG: "does not end", LEAK: "keeps memory"}
ENVIRONMENT = dict(
    os.environ,
    OPENBLAS_NUM_THREADS="1",
    OMP_NUM_THREADS="1",
    # a small quarantine of freed memory touches fewer pages
    ASAN_OPTIONS="allocator_may_return_null=1:max_allocation_size_mb=1000:hard_rss_limit_mb=3000:quarantine_size_mb=8",
    UBSAN_OPTIONS="halt_on_error=1:print_stacktrace=1",
    # memory is freed at once, so that a leak is attributed to its case
    GLIBC_TUNABLES="glibc.malloc.tcache_count=0",
)


def fuzz(report, options):
    """Run all tests of this file."""
    builds = {"sanitized": options.sanitized, "checked": options.checked}
    described = subprocess.run(
        [options.checked / "src" / "vibroimpact-batch", "--describe"],
        capture_output=True,
        check=True,
    )
    language = Language(json.loads(described.stdout))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        many = max(1, round(COUNT * options.share))
        for number, start in enumerate(range(0, many, CHUNK)):
            rng = random.Random(f"{options.seed} {number}")
            put_files(rng, folder)
            texts = make(language, rng, min(CHUNK, many - start))
            build = list(builds)[number % 2]
            run_texts(report, language, f"namelists, {build}", builds[build], folder, texts)
        rng = random.Random(f"{options.seed} programs")
        for _ in range(max(1, round(PROGRAMS * options.share))):
            put_files(rng, folder)
            run_program(report, "programs", options.sanitized, folder, language.make(rng))


def make(language, rng, n):
    """Texts as (text, index of its twin or None); twins are two texts of one case."""
    texts = []
    while len(texts) < n:
        if rng.random() < 0.05:
            one, other = language.pair(rng)
            texts += [(one, None), (other, len(texts))]
        else:
            texts.append((language.make(rng), None))
    return texts


def put_files(rng, folder):
    """Write the files to which namelists refer, sound or damaged."""
    sound = {
        "mass.mtx": b"%%MatrixMarket matrix array real symmetric\n2 2\n1\n0\n0.5\n",
        "record.csv": b"time, force\n0, 0\n0.5, 1\n1, -1\n",
        "stiffness.npy": npy(np.array([[2.0, -1.0], [-1.0, 1.0]])),
    }
    for name, content in sound.items():
        (folder / name).write_bytes(
            content if rng.random() < 0.5 else Language.damage(rng, content)
        )


def npy(array):
    """The bytes of a NumPy file."""
    with tempfile.TemporaryFile() as file:
        np.save(file, array)
        file.seek(0)
        return file.read()


def outcomes(place, folder, texts, batch=500):
    """Return (outcome, text) of each namelist, and the last indices of batches that leak."""
    path = folder / "texts.bin"
    path.write_bytes(b"".join(struct.pack("<I", len(text)) + text for text in texts))
    program = (place / "tests" / "fuzz" / "fuzz_namelists").resolve()
    done = subprocess.run(
        [program, path, str(BUDGET), str(batch)],
        cwd=folder,
        env=ENVIRONMENT,
        capture_output=True,
        check=False,
    )
    if done.returncode != 0:
        sys.exit(f"{program} ended with {done.returncode}: {done.stderr.decode(errors='replace')}")
    found, leaks, at = [], [], 0
    while at < len(done.stdout):
        outcome, _, n = HEAD.unpack_from(done.stdout, at)
        text = done.stdout[at + HEAD.size : at + HEAD.size + n].decode(errors="replace")
        at += HEAD.size + n
        if outcome == LEAK_IN_BATCH:
            leaks.append((len(found), text))
        else:
            found.append((outcome, text))
    return found, leaks


def run_texts(report, language, what, place, folder, texts):
    """Run texts and look for unacceptable answers."""
    only = [text for text, _ in texts]
    found, leaks = outcomes(place, folder, only)
    for end, said in leaks:
        first = (end - 1) // 500 * 500
        for text in only[first:end]:
            alone, leak = outcomes(place, folder, [text], 1)
            if leak or alone[0][0] > 4:
                report.find(what, f"leak: {signature(leak[0][1] if leak else said)}", text, ".nml")
                break
    refused = accepted = 0
    for (text, twin), (outcome, answer) in zip(texts, found, strict=True):
        fault = wrong(language, found, twin, outcome, answer)
        if fault:
            report.find(what, fault, text, ".nml")
        elif outcome == 2:
            refused += 1
        else:
            accepted += 1
    report.count(what, refused, accepted)


def wrong(language, found, twin, outcome, answer):
    """Return what is wrong with an answer, in one line, or None."""
    if outcome == BROKEN_LAW:
        return answer.split("\n")[0]
    if outcome in KINDS:
        return f"{KINDS[outcome]}: {signature(answer)}"
    if outcome not in (0, 1, 2, 4):
        return f"outcome {outcome}"
    if outcome == 2:
        if twin is not None and found[twin][0] != 2:
            return "one of two texts of a case is refused"
        return None
    for breach in language.breaches(answer):
        return f"accepted: {re.sub(' = .*', '', breach)}"
    if twin is not None and found[twin][0] < 100:
        if found[twin][0] == 2:
            return "one of two texts of a case is refused"
        if found[twin][1] != answer:
            return "two texts of a case give two cases"
    return None


def signature(said):
    """The most informative line of a report of a sanitizer or of the compiler's checks."""
    lines = said.split("\n")
    for line in lines:
        if "At line" in line and "Fortran runtime warning" not in "".join(
            lines[lines.index(line) + 1 : lines.index(line) + 2]
        ):
            return line.strip()
    kind = next((line for line in lines if "ERROR:" in line or "runtime error" in line), "")
    kind = re.sub(r"==\d+==|0x[0-9a-f]+|\(pc.*", "", kind).strip()
    frames = [line for line in lines if re.search(r"#\d+ .* in .*/src/(?!c/)", line)]
    frame = re.sub(r".* in ", "", frames[0]).strip() if frames else ""
    return f"{kind} {frame}".strip() or next((x for x in reversed(lines) if x.strip()), "")[:200]


def run_program(report, what, place, folder, text):
    """Check the program itself: its exit status, its messages, and where it writes."""
    (folder / "texts.bin").unlink(missing_ok=True)
    case, results = folder / "case.nml", folder / "results"
    case.write_bytes(text)
    shutil.rmtree(results, ignore_errors=True)  # left by a program that was killed
    before = sorted(path.name for path in folder.iterdir())
    program = (place / "src" / "vibroimpact-batch").resolve()
    running = subprocess.Popen(
        [program, case.name, "-o", "results"],
        cwd=folder,
        env=ENVIRONMENT,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        errors="replace",
    )
    stopped = False
    try:
        _, said = running.communicate(timeout=5)
    except subprocess.TimeoutExpired:
        stopped = True
        running.send_signal(signal.SIGINT)
        try:
            _, said = running.communicate(timeout=60)
        except subprocess.TimeoutExpired:
            running.kill()
            running.communicate()
            report.find(what, "does not stop when it is interrupted", text, ".nml")
            return
    status = running.returncode
    said = re.sub(
        r"(?m)^At line .*\n(?=Fortran runtime warning)|^Fortran runtime warning.*\n", "", said
    )
    lines = said.split("\n")[:-1]
    after = sorted(path.name for path in folder.iterdir() if path != results)
    fault = None
    if after != before:
        fault = "writes outside its folder"
    elif status not in ((0, 1, 130) if stopped else (0, 1, 2)):
        fault = f"exit status {status}: {signature(said)}"
    elif status == 2 and (len(lines) != 1 or not lines[0].startswith("case.nml:")):
        fault = "exit status 2 without one line that begins with the file"
    elif status == 2 and results.exists():
        fault = "exit status 2 with results"
    elif status == 1 and not lines:
        fault = "exit status 1 without a message"
    elif results.exists() and any(
        path.suffix not in (".csv", ".txt") for path in results.rglob("*") if path.is_file()
    ):
        fault = "leaves a file that is no result"
    shutil.rmtree(results, ignore_errors=True)
    if fault:
        report.find(what, fault, text, ".nml")
    else:
        report.count(what, refused=status == 2, accepted=status != 2)
