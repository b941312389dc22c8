"""Certificates: verdicts that the package shares, and an independent program that accepts them and no others."""

import copy
import json
import math
import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
import vibroimpact as vi

CHECKER = Path(__file__).parents[1] / "proof" / "check_certificate.py"
sys.path.insert(0, str(CHECKER.parent))
import check_certificate as checker  # noqa: E402

OSC = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
TABLE1 = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)


@pytest.fixture(autouse=True)
def digits():
    """The digits of the independent program, in which the package does not rely on those that it finds."""
    with checker.ctx.workprec(checker.BITS):
        yield


def motions():
    """Stable and unstable, admissible and inadmissible motions of two and three impacts."""
    stable = vi.equispaced(OSC, 1.04, 25.0)[0]
    unstable = vi.equispaced(TABLE1, 0.94, 37.0)
    inadmissible = [
        m for r in (0.45, 0.6) for m in vi.equispaced(TABLE1, r, 1.0) if m.admissible is False
    ]
    found = (
        motion for motion in vi.find(OSC, 0.9, 5.0) if motion.pattern.sides in ("RRL", "RLR", "LRR")
    )
    three = next(found)
    return [stable, *unstable, *inadmissible[:1], three]


MOTIONS = motions()


def test_motions_of_each_kind():
    """The motions of these tests have all verdicts."""
    assert {motion.stable for motion in MOTIONS} == {True, False}
    assert {motion.admissible for motion in MOTIONS} == {True, False}


@pytest.mark.parametrize("motion", MOTIONS, ids=repr)
def test_verdicts_are_proven(motion):
    """A certificate has the verdicts of the motion, encloses its numbers, and is accepted."""
    proof = motion.prove()
    assert (proof.exists, proof.admissible, proof.stable) == (
        True,
        motion.admissible,
        motion.stable,
    )
    assert proof.proven == (motion.admissible and motion.stable)
    largest = max(abs(motion.multipliers))
    if proof.stable:
        assert largest <= proof.multiplier_bound < min(1, largest * (1 + 1e-6))
    if proof.admissible:
        assert motion.attenuation <= proof.attenuation_bound < motion.attenuation * 1.002
    checker.check(json.loads(proof.to_json()))


def wrong(data):
    """Certificates that differ in one thing and are false; what was changed."""

    def changed(what, *path, value):
        other = copy.deepcopy(data)
        place = other
        for key in path[:-1]:
            place = place[key]
        place[path[-1]] = value(place[path[-1]])
        return what, other

    def moved(text):
        """A parameter whose last digit is another one, and which leaves the box."""
        return (
            str(Fraction(text) * Fraction(1001, 1000).limit_denominator(1000))
            if "/" in text
            else (f"{float(text) * 1.001:.12g}")
        )

    def shifted(text):
        sign, power = ("-", text[1:]) if text.startswith("-") else ("", text)
        digits, exponent = power.split("p")
        return f"{sign}{hex(int(digits, 16) * (1 << 20) + (1 << 48))}p{int(exponent) - 20}"

    box = data["boxes"][0]
    for name in ("xi", "mu", "r", "clearance", "load"):
        yield changed(name, "system", name, value=moved)
    for i in range(len(data["system"]["restitution"])):
        yield changed(f"restitution {i}", "system", "restitution", i, value=moved)
    for i in range(len(box["centre"])):
        for k in range(4):
            yield changed(f"centre {i} {k}", "boxes", 0, "centre", i, k, value=shifted)
            yield changed(f"no radius {i} {k}", "boxes", 0, "radius", i, k, value=lambda _: "0x0p0")
        yield changed(
            f"impact {i} dropped", "boxes", 0, "centre", value=lambda c, i=i: c[:i] + c[i + 1 :]
        )
    for name in ("admissible", "stable"):
        yield changed(name, "boxes", 0, name, value=lambda verdict: not verdict)
    yield changed("walls", "sides", value=lambda text: text.translate({82: "L", 76: "R"}))
    yield changed("cycles", "cycles", value=lambda k: k + 1)
    yield changed("box dropped", "boxes", value=lambda _: [])
    yield changed("exists", "boxes", 0, "exists", value=lambda _: False)
    yield changed("kind", "kind", value=lambda _: "branch")
    if box["multipliers_below"] is not None:
        lower = lambda text: f"{float(text) * (1 - 1e-7):.12f}"  # noqa: E731
        yield changed("bound", "boxes", 0, "multipliers_below", value=lower)
        yield changed("bound above one", "boxes", 0, "multipliers_below", value=lambda _: "1.5")
    if box["multipliers_above"] is not None:
        higher = lambda text: f"{float(text) * (1 + 1e-7):.12f}"  # noqa: E731
        yield changed("bound", "boxes", 0, "multipliers_above", value=higher)
    if box["attenuation_below"] is not None:
        lower = lambda text: f"{float(text) * (1 - 1e-2):.12f}"  # noqa: E731
        yield changed("attenuation", "boxes", 0, "attenuation_below", value=lower)


@pytest.mark.parametrize("motion", MOTIONS[:2], ids=repr)
def test_false_certificates_are_rejected(motion):
    """The independent program rejects each one that was changed so that it is false."""
    data = json.loads(motion.prove().to_json())
    accepted = []
    number = 0
    for what, other in wrong(data):
        number += 1
        try:
            checker.check(other)
        except checker.RejectedError:
            continue
        accepted.append(what)
    assert number > 20
    assert accepted == []


def test_each_digit_of_a_centre():
    """A centre with another digit is rejected where its box does not hold the motion any more, and only there."""
    data = json.loads(MOTIONS[0].prove().to_json())
    text = data["boxes"][0]["centre"][0][0]
    radius = checker.number(data["boxes"][0]["radius"][0][0])
    digits, power = text.split("p")
    for k in range(2, len(digits)):
        other = copy.deepcopy(data)
        digit = format((int(digits[k], 16) + 1) % 16, "x")
        changed = f"{digits[:k]}{digit}{digits[k + 1 :]}p{power}"
        other["boxes"][0]["centre"][0][0] = changed
        distance = abs(checker.number(changed) - checker.number(text))
        if distance > 2 * radius:
            with pytest.raises(checker.RejectedError):
                checker.check(other)
        elif 8 * distance < radius:
            checker.check(other)


def test_independent_program(tmp_path):
    """It accepts a file, rejects another, and says so by its exit status; it does not import the package."""
    path = tmp_path / "motion.json"
    MOTIONS[0].prove().save(path)
    data = json.loads(path.read_text())
    data["boxes"][0]["stable"] = False
    false = tmp_path / "false.json"
    false.write_text(json.dumps(data))
    command = [sys.executable, str(CHECKER), str(path)]
    good = subprocess.run(command, capture_output=True, text=True)
    assert (good.returncode, good.stderr) == (0, "")
    assert good.stdout.endswith("accepted: one motion RL/1, admissible = True, stable = True\n")
    bad = subprocess.run([*command, str(false)], capture_output=True, text=True)
    assert bad.returncode == 1
    assert "false.json: REJECTED" in bad.stdout
    source = CHECKER.read_text()
    assert "import vibroimpact" not in source
    assert len(source.splitlines()) <= 400


def test_files(tmp_path):
    """A certificate that was saved is read with the same numbers."""
    proof = MOTIONS[0].prove()
    proof.save(tmp_path / "proof.json")
    assert vi.load(tmp_path / "proof.json") == proof
    assert vi.Certificate.from_json(proof.to_json()) == proof
    assert "proven" in proof._repr_html_()
    with pytest.raises(vi.ParameterError, match="format = 2"):
        vi.Certificate.from_dict(proof.to_dict() | {"format": 2})
    with pytest.raises(vi.ParameterTypeError, match="boxes = 'none'"):
        vi.Certificate.from_dict(proof.to_dict() | {"boxes": "none"})


def test_near_the_circle_nothing_is_proven():
    """At a pitchfork existence or stability is not decided, with the reason, and never a guess."""
    branch = vi.branch(MOTIONS[0], "clearance", bounds=(15.0, 30.0))
    (fork,) = [point for point in branch.special_points if point.type == "pitchfork"]
    proof = fork.motion.prove()
    assert proof.stable is None or proof.exists is None
    assert proof.undecided
    assert not proof.proven


def test_no_damping():
    """With R = 1 and xi = 0 nothing decays: no motion is proven stable."""
    osc = vi.Oscillator(xi=0, mu=0.1, restitution=1)
    found = [motion for r in (0.5, 0.8, 1.3) for motion in vi.equispaced(osc, r, 1.0)]
    assert found
    for motion in found:
        assert motion.prove().stable is not True


def test_refused():
    """Motions of structures and with rest have other equations."""
    stop = vi.Structure([1], [0.1], [1], [vi.Gap([1], 1, 0.8)])
    with pytest.raises(vi.ParameterError, match="must be one of an Oscillator"):
        vi.exact(stop, vi.Load(1.0, cosine=[1]), ([0.1], [0])).prove()


@pytest.mark.slow
def test_motions_of_find():
    """Motions of random oscillators have proven verdicts, none of which contradicts; few are not decided."""
    random = np.random.default_rng(47)
    number = open_ = 0
    for _ in range(25):
        xi, mu = (
            random.uniform(0.002, 0.05),
            math.exp(random.uniform(math.log(0.01), math.log(0.3))),
        )
        walls = tuple(random.uniform(0.2, 0.95, 2).tolist())
        osc = vi.Oscillator(xi=xi, mu=mu, restitution=walls)
        r, clearance = (
            random.uniform(0.4, 1.8),
            math.exp(random.uniform(math.log(0.2), math.log(60))),
        )
        for motion in vi.find(osc, r, clearance):
            if motion.pattern.has_rest:
                continue
            proof = motion.prove()
            number += 1
            assert proof.stable in (None, motion.stable), motion
            assert proof.admissible in (None, motion.admissible), motion
            if None in (proof.exists, proof.admissible, proof.stable):
                open_ += 1
                assert proof.undecided[0]["reason"]
            elif number % 5 == 0:
                checker.check(json.loads(proof.to_json()))
    assert number > 100
    assert open_ <= 0.03 * number
