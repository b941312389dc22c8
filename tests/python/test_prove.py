"""Certificates: verdicts that agree with the package, and an independent program that accepts only true ones."""

import copy
import functools
import json
import math
import subprocess
import sys
from fractions import Fraction
from functools import partial
from itertools import islice
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact.proofs import verdicts

CHECKER = Path(__file__).parents[1] / "proof" / "check_certificate.py"
sys.path.insert(0, str(CHECKER.parent))
import check_certificate as checker  # noqa: E402
import form  # noqa: E402
import search  # noqa: E402
import series  # noqa: E402
from check_certificate import exact  # noqa: E402
from check_structure import check_structure  # noqa: E402

OSC = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
TABLE1 = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)


@pytest.fixture(autouse=True)
def digits():
    """Set the precision of the independent program; the package does not rely on the one that it finds."""
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


def changed_in(data, what, *path, value):
    """A copy of a certificate with one entry replaced, and the name of the change."""
    other = copy.deepcopy(data)
    place = other
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value(place[path[-1]])
    return what, other


def wrong(data):
    """Certificates with a single false change, and the name of the change."""

    changed = partial(changed_in, data)

    def moved(text):
        """A value with which the motion leaves the box."""
        return f"{float(text) * (1.001 if data['kind'] == 'motion' else 0.5):.12g}"

    def shifted(text, by):
        """The centre moved so far that the box no longer contains the motion."""
        found = exact(text) + 2 * exact(by)
        return f"{hex(int(found * 2**300))}p-300"

    box = data["boxes"][0]
    for name in ("xi", "mu", "r", "clearance", "load"):
        if name not in box["parameters"]:
            yield changed(name, "system", name, value=moved)
    for i in range(len(data["system"]["restitution"])):
        yield changed(f"restitution {i}", "system", "restitution", i, value=moved)
    for i in range(len(box["centre"])):
        for k in range(4):
            by = lambda text, radius=box["radius"][i][k]: shifted(text, radius)  # noqa: E731
            yield changed(f"centre {i} {k}", "boxes", 0, "centre", i, k, 0, value=by)
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
    yield changed("kind", "kind", value=lambda _: "zone")
    yield changed("symmetric", "symmetric", value=lambda symmetric: not symmetric)
    for j, one in enumerate(data["boxes"]):
        if len(data["boxes"]) > 1 and (j < 2 or one["stable"] is None):
            dropped = lambda boxes, j=j: boxes[:j] + boxes[j + 1 :]  # noqa: E731
            yield changed(f"box {j} dropped", "boxes", value=dropped)
        for name in ("admissible", "stable"):
            value = lambda old: None if old is None else not old  # noqa: E731
            if one[name] is not None and j % 4 == 1:
                yield changed(f"{name} of box {j}", "boxes", j, name, value=value)
        for name, ends in one["parameters"].items() if j % 3 == 0 else ():
            width = Fraction(ends[1]) - Fraction(ends[0])
            move = lambda old, by=width / 7: [str(Fraction(end) + by) for end in old]  # noqa: E731
            yield changed(f"{name} of box {j} moved", "boxes", j, "parameters", name, value=move)
            wider = lambda old, by=width / 7: [old[0], str(Fraction(old[1]) + by)]  # noqa: E731
            yield changed(f"{name} of box {j} wider", "boxes", j, "parameters", name, value=wider)
    for k, sheet in enumerate(data["sheets"]):
        for name in sheet:
            wider = lambda old: [old[0], str(Fraction(old[1]) + 1)]  # noqa: E731
            yield changed(f"sheet {k} wider", "sheets", k, name, value=wider)
    tight, loose = (1e-7, 1e-2) if data["kind"] == "motion" else (0.02, 0.1)
    if box["multipliers_below"] is not None:
        lower = lambda text: f"{float(text) * (1 - tight):.12f}"  # noqa: E731
        yield changed("bound", "boxes", 0, "multipliers_below", value=lower)
        yield changed("bound above one", "boxes", 0, "multipliers_below", value=lambda _: "1.5")
    if box.get("multipliers_above") is not None:
        higher = lambda text: f"{float(text) * (1 + 1e-7):.12f}"  # noqa: E731
        yield changed("bound", "boxes", 0, "multipliers_above", value=higher)
    if box["attenuation_below"] is not None:
        lower = lambda text: f"{float(text) * (1 - loose):.12f}"  # noqa: E731
        yield changed("attenuation", "boxes", 0, "attenuation_below", value=lower)


def false_items(data):
    """Certificates with an item too few or too many, of another type, or that contradicts the others."""

    changed = partial(changed_in, data)

    places = [(), ("system",), *((("boxes", 0),) if data["boxes"] else ())]
    if data["system"].get("gaps"):
        places.append(("system", "gaps", 0))
    for place in places:
        items = functools.reduce(lambda part, key: part[key], place, data)
        for name in items:
            if name not in ("multipliers_below", "multipliers_above", "attenuation_below"):
                rest = lambda old, name=name: {k: v for k, v in old.items() if k != name}  # noqa: E731
                yield changed_in({"all": data}, f"no {name}", "all", *place, value=rest)
        more = lambda old: old | {"note": "also proven"}  # noqa: E731
        yield changed_in({"all": data}, f"more in {place}", "all", *place, value=more)
    for name, value in (
        ("type", "Proof"), ("format", 2), ("kind", "every"), ("sides", 1), ("cycles", 0), ("cycles", True),
        ("symmetric", 1), ("sheets", []), ("seconds", -1.0), ("seconds", math.nan), ("seconds", "1"),
    ):  # fmt: skip
        yield changed(f"{name} = {value}", name, value=lambda _, value=value: value)
    # undecided items: too much, too little, elsewhere, or without a reason
    undecided = data["undecided"]
    wrong_item = {"reason": "unknown", "parameters": {"clearance": ["1", "2"]}}
    yield changed("one more", "undecided", value=lambda old: [*old, wrong_item])
    if data["kind"] != "zone":
        yield changed("one more", "undecided", value=lambda old: [*old, {"reason": "unknown"}])
    for k, item in enumerate(undecided):
        if "times" not in item and (data["kind"] != "zone" or len(undecided) == 1):
            yield changed("one fewer", "undecided", value=lambda old, k=k: old[:k] + old[k + 1 :])
        yield changed("no reason", "undecided", k, "reason", value=lambda _: "")
        for name, (low, high) in item.get("parameters", {}).items():
            middle = str((Fraction(low) + Fraction(high)) / 2)
            for ends in ([low, middle], [middle, high], [low, str(Fraction(high) + 1)]):
                value = lambda _, ends=ends: ends  # noqa: E731
                yield changed(f"{name}", "undecided", k, "parameters", name, value=value)
    for sheet in data["sheets"]:
        for name in {"r", "clearance", "xi", "mu", "load", "frequency"}.intersection(sheet):
            if name in data["system"]:
                yield changed(f"{name} at the start", "system", name, value=lambda _: "1e6")
    for j, box in list(enumerate(data["boxes"]))[:2]:
        for name, value in (
            ("sheet", len(data["sheets"])), ("sheet", -1), ("sheet", "0"), ("exists", 1),
            ("admissible", "yes"), ("stable", 0),
        ):  # fmt: skip
            yield changed(f"{name} = {value!r}", "boxes", j, name, value=lambda _, v=value: v)
        if data["kind"] == "zone" and box["exists"] is not False:
            continue
        for name, texts in (
            ("multipliers_below", ("0", "-0.5", "1.000001", "nan", "inf", ".9", 0.999)),
            ("multipliers_above", ("0", "-2", "0.999", "nan")),
            ("attenuation_below", ("0", "-1", "nan")),
        ):  # fmt: skip
            for text in texts:
                changed_box = {**box, name: text}
                value = lambda _, new=changed_box: new  # noqa: E731
                yield changed(f"{name} = {text}", "boxes", j, value=value)
        if box["stable"] is not None:
            opened = lambda _, box=box: {**box, "stable": None}  # noqa: E731
            yield changed("open, with a bound or no reason", "boxes", j, value=opened)
        nothing = {name: box[name] for name in ("sheet", "parameters")}
        nothing |= dict.fromkeys(("exists", "admissible", "stable"))
        for name in ("multipliers_below", "multipliers_above", "attenuation_below"):
            value = lambda _, new={**nothing, name: "0.9"}: new  # noqa: E731
            yield changed(f"a bound {name} of nothing", "boxes", j, value=value)


#: Certificates of motions, a branch with a special point, and a box, each small.
CERTIFICATES = [
    MOTIONS[0].prove,
    MOTIONS[1].prove,
    lambda: vi.branch(vi.equispaced(OSC, 1.04, 21.1)[0], "clearance", bounds=(20.9, 21.3)).prove(
        tolerance=0.1
    ),
    lambda: vi.prove_box(OSC, "RL", r=(1.0399, 1.0401), clearance=(24.99, 25.01)),
]


@pytest.mark.parametrize(
    "make", [*CERTIFICATES[:1], *(pytest.param(one, marks=pytest.mark.slow) for one in CERTIFICATES[1:])],
    ids=["stable motion", "unstable motion", "branch", "box"],
)  # fmt: skip
def test_false_certificates_are_rejected(make):
    """The independent program rejects each certificate with a change that makes it false."""
    data = json.loads(make().to_json())
    checker.check(data)
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


#: Certificates of each kind, as small as possible.
KINDS = {
    "motion": lambda: MOTIONS[0].prove(),
    "nothing": lambda: vi.prove_box(OSC, "RL", r=1.04, clearance=(10, 11)),
    "branch": lambda: vi.branch(
        vi.equispaced(OSC, 1.04, 21.1)[0], "clearance", bounds=(21.0, 21.2)
    ).prove(tolerance=0.3),
    "box": lambda: vi.prove_box(OSC, "RL", r=(1.0399, 1.0401), clearance=(24.99, 25.01)),
    "zone": lambda: proof_of_zone(0.1, 60.0)[1],
    "all": lambda: vi.prove_all(TABLE1, 0.94, 37.0, max_impacts=2),
    "structure": lambda: structures()[0].prove(),
    "symmetric structure": lambda: structures()[1].prove(),
    "branch of structure": lambda: vi.branch(
        structures()[0], "frequency", bounds=(0.99, 1.01)
    ).prove(),
}


@pytest.mark.parametrize(("parameter", "bounds"), [("R1", (0.749, 0.751)), ("R2", (0.74, 0.76))])
def test_branches_along_the_restitution_of_one_wall(parameter, bounds):
    """The motion is symmetric at one point only, even if that is the middle: the certificate has both impacts."""
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    motion = vi.equispaced(osc, r=1.04, clearance=25.0)[0]
    branch = vi.branch(motion, parameter, bounds=bounds)
    proof = branch.prove()
    assert not proof.symmetric
    assert proof.exists
    data = json.loads(proof.to_json())
    checker.check(data)
    for box in data["boxes"]:
        low, high = (float(exact(end)) for end in box["parameters"][parameter])
        for i in np.flatnonzero((branch.values >= low) & (branch.values <= high)).tolist():
            at = (branch.values[i] - (low + high) / 2) / ((high - low) / 2)
            found = [
                sum(float(exact(text)) * at**k for k, text in enumerate(row))
                for row in (box["centre"][n][j] for n in range(2) for j in (1, 2, 3))
            ]
            known = np.stack([branch.X, branch.X_dot_after, branch.Z_dot_after])[:, :, i].T.ravel()
            assert np.abs(found - known).max() < 1e-3


def two_branches():
    """Certificates of two motions along one interval of the clearance, each in two boxes."""
    found = []
    for motion in vi.equispaced(TABLE1, 0.94, 37.0)[:2]:
        data = json.loads(vi.branch(motion, "clearance", bounds=(36.5, 37.5)).prove().to_json())
        checker.check(data)
        (box,) = data["boxes"]
        for half in series.halves(box, "clearance"):
            texts = [[[str(one) for one in text] for text in row] for row in half["centre"]]
            found.append((data, half | {"centre": texts}))
    return found


def test_boxes_of_two_branches_are_not_one_curve():
    """Parts of two branches do not form a branch, in any order or on any number of sheets."""
    (data, first), _, _, (_, last) = two_branches()
    both = copy.deepcopy(data) | {"boxes": [first, last]}
    twice = copy.deepcopy(data) | {
        "sheets": data["sheets"] * 2,
        "boxes": [one | {"sheet": k} for one in (first, last) for k in (0, 1)],
    }
    low, high = (Fraction(end) for end in last["parameters"]["clearance"])
    part = next(series.halves(last, "clearance"))
    part |= {"centre": [[[str(one) for one in text] for text in row] for row in part["centre"]]}
    open_ = {"sheet": 0, "parameters": {"clearance": [str((low + high) / 2), str(high)]}}
    open_ |= dict.fromkeys(("exists", "admissible", "stable"))
    apart = copy.deepcopy(data) | {
        "boxes": [first, open_, part],
        "undecided": [{"reason": "open", "parameters": open_["parameters"]}],
    }
    for false in (both, both | {"boxes": both["boxes"][::-1]}, twice, apart):
        with pytest.raises(checker.RejectedError, match="neighbours may hold different"):
            checker.check(false)


def test_a_wall_has_one_restitution():
    """Impacts on one wall with two coefficients belong to no oscillator."""
    rrl = next(
        one for one in vi.find(TABLE1, 1.0, 30.0, max_impacts=3) if len(one.pattern.sides) == 3
    )
    data = json.loads(rrl.prove().to_json())
    checker.check(data)
    side = next(side for side in "RL" if data["sides"].count(side) == 2)
    data["system"]["restitution"][data["sides"].index(side)] = "0.750000000000000001"
    with pytest.raises(checker.RejectedError, match="one R of each wall"):
        checker.check(data)


@pytest.mark.parametrize("kind", KINDS)
def test_each_item_is_checked(kind):
    """In each kind of certificate every item is needed, no other is accepted, and none contradicts the boxes."""
    data = json.loads(KINDS[kind]().to_json())
    form.check_form(data)
    accepted = []
    number = 0
    for what, other in false_items(data):
        number += 1
        try:
            checker.check(other.get("all", other))
        except checker.RejectedError:
            continue
        accepted.append(what)
    assert accepted == []
    assert number > 25


def test_zones_state_no_bounds():
    """The lengths of a zone have other units than A, in which a false bound of max|x|/A would seem true."""
    data = json.loads(KINDS["zone"]().to_json())
    place = next(k for k, box in enumerate(data["boxes"]) if box["admissible"] and box["stable"])
    for name, text in (("attenuation_below", "1000"), ("multipliers_below", "1")):
        false = copy.deepcopy(data)
        false["boxes"][place][name] = text
        with pytest.raises(checker.RejectedError, match="the items of a box"):
            checker.check(false)
        with pytest.raises(vi.ParameterError, match="without bounds in a zone"):
            vi.Certificate.from_dict(false)


@pytest.mark.parametrize("kind", ["motion", "branch", "box", "structure", "branch of structure"])
def test_centres_of_another_form(kind):
    """Too few or too many coefficients, and numbers that are not texts, are rejected without a crash."""
    data = json.loads(KINDS[kind]().to_json())
    for value in ([], ["0"] * 50, "0", 1, [1], [["0"]], None):
        _, false = changed_in(data, "", "boxes", 0, "centre", 0, 1, value=lambda _, v=value: v)
        with pytest.raises(checker.RejectedError):
            checker.check(false)
    for value in (1, True, None, ["1"]):
        _, false = changed_in(data, "", "boxes", 0, "radius", 0, 1, value=lambda _, v=value: v)
        with pytest.raises(checker.RejectedError):
            checker.check(false)


def test_numbers_are_texts():
    """Entries of a structure are exact texts in lists; JSON numbers and true are rejected."""
    data = json.loads(KINDS["structure"]().to_json())
    for path, value in (
        (("mass", 0, 0), 1), (("mass", 0, 0), True), (("frequency",), 1), (("gaps", 0, "opening"), True),
        (("mass", 0), "1"), (("constant",), "0"), (("gaps", 0, "direction"), "1"), (("sine",), "0"),
    ):  # fmt: skip
        _, false = changed_in(data, "", "system", *path, value=lambda _, v=value: v)
        with pytest.raises(checker.RejectedError):
            checker.check(false)


def test_regions_that_are_ambiguous():
    """A branch has one parameter, the same on all sheets, and restitution means both R1 and R2."""
    data = json.loads(KINDS["branch"]().to_json())
    mu = {"mu": ["0.027", "0.029"]}
    for sheets, message in (
        ([data["sheets"][0] | mu], "along one parameter"),
        ([data["sheets"][0], mu], "the same parameters"),
    ):
        with pytest.raises(checker.RejectedError, match=message):
            checker.check(data | {"sheets": sheets})
    both = {name: ["0.7", "0.8"] for name in ("restitution", "R1")}
    with pytest.raises(checker.RejectedError, match="one R of each wall"):
        checker.check(data | {"kind": "box", "sheets": [both]})
    data = json.loads(KINDS["all"]().to_json())
    for cycles in (True, 1.0, 0, "1"):
        _, false = changed_in(data, "", "sheets", 0, "cycles", value=lambda _, k=cycles: k)
        with pytest.raises(checker.RejectedError, match="a number of cycles"):
            checker.check(false)


def test_motions_that_do_not_approach_exclude_nothing(monkeypatch):
    """The search finds all motions with positive approach; a motion without it is not the only one in its box."""
    seen = []
    monkeypatch.setattr(search, "check_others", lambda pair, motions, exempt: seen.extend(motions))
    speeds = {"approaches": [1, 2], "leaves": [1, -1], "may leave": [checker.arb(1, 2)]}
    pair = SimpleNamespace(approach=lambda state: map(checker.arb, speeds[state]))
    data = {
        "sides": "RL", "cycles": 1, "sheets": [{"sides": "RL", "cycles": 1}], "undecided": [],
        "system": {"restitution": ["0.7", "0.7"]},
        "boxes": [{"sheet": 0, "parameters": {}, "is": state} for state in speeds],
    }  # fmt: skip
    search.check_all(data, lambda *_: pair, lambda word, box: box["is"])
    assert seen == ["approaches"]


def test_just_beyond_a_graze():
    """A gap that closes for a very short time is proven to close, and the independent program detects it."""
    motion = vi.exact(TABLE1, 0.94, 37.0, ([0, 1.37 * math.pi], vi.Pattern("RL")))
    path = vi.branch(motion, "clearance", bounds=(17, 38))
    (graze,) = [one.clearance for one in path.special_points if one.type == "grazing"]
    near = path[int(np.argmin(abs(path.values - graze)))]
    first = vi.exact(WALL, vi.Load(1.0, cosine=[1.0]), ([0.1], [0]))
    path = vi.branch(first, "frequency", bounds=(0.69, 1.1))
    (place,) = [one.value for one in path.special_points if one.type == "grazing"]
    one = path[int(np.argmin(abs(path.values - place)))]
    for by in (1e-3, 1e-6, 1e-10):
        load = vi.Load(place * (1 - by), cosine=[1.0])
        motions = (
            vi.exact(TABLE1, 0.94, graze * (1 - by), near),
            vi.exact(WALL, load, (one.phases, [0], one.cycles)),
        )
        for found in motions:
            proof = found.prove()
            assert (proof.exists, proof.admissible, proof.undecided) == (True, False, [])
            checker.check(json.loads(proof.to_json()))
    frequency = place * (1 - 1e-5)
    found = vi.exact(WALL, vi.Load(frequency, cosine=[1.0]), (one.phases, [0], one.cycles))
    branch = vi.branch(found, "frequency", bounds=(frequency, place * (1 - 5e-6)))
    proof = branch.prove(tolerance=1)
    assert (proof.admissible, proof.undecided) == (False, [])
    checker.check(json.loads(proof.to_json()))


def test_bound_of_x_across_zero(monkeypatch):
    """The bound of |x| holds where x changes its sign within a piece that ends at its largest value."""
    n, factor, third = 40, 2.5, 2.5 * 40 * 39 * 38

    class Steep:
        """x = 1 - factor t^n, and the distance 1000 (1 - t) from a wall, in a flight of the duration 1."""

        def __init__(self, *_):
            self.third = checker.arb(third)

        def at(self, t):
            one = checker.arb(1)
            x, v, a = (one * (k == 0) - factor * math.perm(n, k) * t ** (n - k) for k in range(3))
            return (1 - t) * 1000, one * 1000, one * 0, x, v, a

    monkeypatch.setattr(verdicts, "Path", Steep)
    clear, bound = verdicts.flight_between_walls(None, SimpleNamespace(tau=checker.arb(1), after=1))
    assert clear
    assert bound >= factor - 1


def test_unknowns_that_vanish():
    """For the impact pair without losses, X' after the impacts is 0 and has no scale of its own."""
    osc = vi.Oscillator(xi=0.01, mu=0.0, restitution=1.0)
    for motion in vi.equispaced(osc, 0.7, 1.5):
        assert np.abs(motion.X_dot_after).max() < 1e-14
        proof = motion.prove()
        assert (proof.exists, proof.admissible) == (True, motion.admissible)
        assert proof.attenuation_bound is None or 1 <= proof.attenuation_bound < 1.002
        checker.check(json.loads(proof.to_json()))
        branch = vi.branch(motion, "r", bounds=(0.69, 0.71)).prove(tolerance=0.5)
        assert branch.exists
        checker.check(json.loads(branch.to_json()))


@pytest.mark.parametrize("text", ["-0.9", "0", "1.0000001"])
@pytest.mark.parametrize("kind", ["motion", "structure", "branch of structure"])
def test_bounds_of_multipliers_lie_between_0_and_1(kind, text):
    """Each of the three programs that check multipliers rejects a different bound of a stable motion."""
    data = json.loads(KINDS[kind]().to_json())
    box = data["boxes"][0]
    box["multipliers_below"] = text
    # also without the check of the format
    alone = check_structure if kind == "structure" else lambda data: checker.check_box(data, box)
    for check in (checker.check, alone):
        with pytest.raises(checker.RejectedError, match="bound"):
            check(data)


@pytest.mark.slow
def test_restitution_from_zero_to_one():
    """At R = 0 nothing is proven, with the reason; for all larger R up to 1 certificates are accepted."""
    wall = structures()[0]
    proof = vi.branch(wall, "restitution", bounds=(0, 1)).prove(tolerance=0.02)
    assert "R = 0" in proof.undecided[0]["reason"]
    assert proof.boxes[0]["exists"] is None
    assert proof.boxes[1]["exists"]
    checker.check(json.loads(proof.to_json()))
    proof = vi.branch(MOTIONS[0], "restitution", bounds=(0, 0.8)).prove(tolerance=0.02)
    assert "R = 0" in proof.undecided[0]["reason"]
    data = json.loads(proof.to_json())
    form.check_form(data)
    for box in data["boxes"][:3]:
        checker.check_box(data, box)
    # neither end is a binary number, so a ball around the ends reaches beyond 1
    span = {"xi": (0, 0.001), "restitution": (0.97, 1)}
    proof = vi.prove_box(OSC, "RL", r=1.3, clearance=3.0, most_boxes=3, **span)
    checker.check(json.loads(proof.to_json()))


def test_branch():
    """Verdicts along a branch agree with its points, gaps are around the special points, and it is accepted."""
    branch = vi.branch(MOTIONS[0], "clearance", bounds=(15.0, 90.0))
    proof = branch.prove()
    kinds = {point.type: point.clearance for point in branch.special_points}
    assert {"pitchfork", "neimark_sacker"} <= set(kinds)
    gaps = [
        [float(Fraction(end)) for end in gap["parameters"]["clearance"]] for gap in proof.undecided
    ]
    assert [
        any(low <= kinds[kind] <= high for low, high in gaps)
        for kind in ("pitchfork", "neimark_sacker")
    ]
    assert sum(high - low for low, high in gaps) < 0.05
    for box in proof.boxes:
        low, high = (float(Fraction(end)) for end in box["parameters"]["clearance"])
        assert box["exists"]
        for i in np.flatnonzero((low <= branch.clearance) & (branch.clearance <= high)):
            for name in ("stable", "admissible"):
                if branch.special_points and box[name] is not None and branch[i].consistent:
                    near = min(abs(branch.clearance[i] - value) for value in kinds.values()) < 1e-6
                    assert near or box[name] == getattr(branch, name)[i]
    # the middle of each polynomial is the exact motion there
    box = proof.boxes[len(proof.boxes) // 2]
    low, high = (Fraction(end) for end in box["parameters"]["clearance"])
    motion = vi.exact(OSC, 1.04, float(low + high) / 2, MOTIONS[0])
    with checker.ctx.workprec(checker.BITS):
        assert float(checker.number(box["centre"][0][1][0])) == pytest.approx(motion.X[0], rel=1e-9)
    stable = vi.branch(MOTIONS[0], "clearance", bounds=(21.0801, 71.2733)).prove()
    assert stable.proven
    assert not stable.undecided
    checker.check(json.loads(stable.to_json()))


@pytest.mark.slow
def test_branch_in_halves():
    """The independent program halves a box whose models are too wide; a false certificate stays false."""
    motion = vi.equispaced(OSC, 1.04, 22.0)[1]
    branch = vi.branch(motion, "clearance", bounds=(20.6, 26.0))
    data = json.loads(branch.prove(tolerance=0.3).to_json())
    box = data["boxes"][0]
    assert (box["exists"], box["admissible"], box["stable"]) == (True, False, False)
    pair = checker.Pair(data, box)
    states = pair.enclosure(box)
    with pytest.raises(checker.RejectedError):
        checker.check_stability(pair, states, box)
    checker.check_box(data, box)
    for name in ("stable", "admissible"):
        with pytest.raises(checker.RejectedError):
            checker.check_box(data, {**box, name: True})


def test_branch_with_folds():
    """A branch that turns back has a sheet for each part, and a gap at the fold."""
    motion = vi.equispaced(TABLE1, 0.94, 37.0)[0]
    branch = vi.branch(motion, "clearance", bounds=(30.0, 1000.0))
    folds = [point for point in branch.special_points if point.type == "fold"]
    assert folds
    proof = branch.prove(tolerance=1e-2)
    assert len(proof.sheets) == len(folds) + 1
    for fold in folds:
        assert any(
            float(Fraction(low)) - 1e-9 <= fold.clearance <= float(Fraction(high)) + 1e-9
            for low, high in (gap["parameters"]["clearance"] for gap in proof.undecided)
        )


def test_box():
    """A motion is proven for all tolerances, and the exact motions at the corners keep its bounds."""
    proof = vi.prove_box(OSC, "RL", r=1.04, clearance=(24, 26), restitution=(0.745, 0.755))
    assert proof.proven
    assert proof.kind == "box"
    for clearance in (24.0, 26.0):
        for restitution in (0.745, 0.755):
            osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=restitution)
            motion = vi.exact(osc, 1.04, clearance, MOTIONS[0])
            assert motion.stable
            assert motion.attenuation < proof.attenuation_bound
            assert max(abs(motion.multipliers)) < proof.multiplier_bound
    checker.check(json.loads(proof.to_json()))
    point = vi.prove_box(OSC, "RL", r=1.04, clearance=25.0)
    assert (point.kind, point.proven) == ("motion", True)


def test_box_is_not_proven():
    """A box across the pitchfork is not proven, and one without a stable motion has no boxes."""
    proof = vi.prove_box(OSC, "RL", r=1.04, clearance=(21, 21.5), most_boxes=100)
    assert not proof.proven
    assert proof.stable is None
    assert proof.undecided
    none = vi.prove_box(OSC, "RL", r=1.04, clearance=(10, 11))
    assert none.boxes == []
    assert not none.proven
    assert "was found at the middle" in none.undecided[0]["reason"]
    # it states only the reason
    data = json.loads(none.to_json())
    checker.check(data)
    with pytest.raises(checker.RejectedError, match="leaves more open than is said"):
        checker.check({**data, "undecided": []})
    # the ends in either order
    down = vi.prove_box(OSC, "RL", r=1.04, clearance=(25.125, 25))
    assert down.sheets == [{"clearance": ["25", "201/8"]}]
    for wrong in ((24, 25, 26), np.array([[24, 26]])):
        with pytest.raises(vi.ParameterError, match=r"must be a number or \(lowest, highest\)"):
            vi.prove_box(OSC, "RL", r=1.04, clearance=wrong)
    with pytest.raises(vi.ParameterError, match=r"restitution = 0\.7: must be left out"):
        vi.prove_box(OSC, "RL", r=1.04, clearance=25, restitution=0.7, R1=0.7)


def test_box_at_a_point_without_a_motion():
    """Where nothing varies and no motion is found, the representation names the point."""
    inelastic = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.0)
    proof = vi.prove_box(inelastic, "RL", r=1.04, clearance=25)
    assert repr(proof).startswith("<Certificate of RL/1 at r = 1.04, d K/F0 = 25.0: exists not")
    assert not proof.proven
    assert "no stable, admissible motion" in proof.undecided[0]["reason"]


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"r": None}, "r = None: must be a number with"),
        ({"clearance": None}, "clearance = None: must be a"),
        ({"most_boxes": 0}, "most_boxes = 0: must be a whole number"),
        ({"most_boxes": float("nan")}, "most_boxes = nan: must be a whole number"),
    ],
)
def test_boxes_are_checked(given, message):
    """r and the clearance have no default; most_boxes is a whole number, whether or not there is a box."""
    with pytest.raises((vi.ParameterError, vi.ParameterTypeError), match=f"^{message}"):
        vi.prove_box(OSC, "RL", **({"r": 1.04, "clearance": 25.0} | given))


def test_proofs_with_units():
    """An oscillator with M, K and F0 takes Hz and mm: the same proof as with the numbers."""
    rig = vi.Oscillator.from_dimensional(
        M="2.7 kg", K="42 kN/m", xi=0.0114, m="0.11 kg", restitution=0.75, F0="6 N"
    )
    at = rig.at("20.6 Hz", "3.6 mm")
    box = vi.prove_box(rig, "RL", r="20.6 Hz", clearance=("3.6 mm", "3.61 mm"))
    same = vi.prove_box(rig, "RL", r=at.r, clearance=(at.clearance, rig.at(1, "3.61 mm").clearance))
    assert box.proven
    assert (box.system, box.boxes) == (same.system, same.boxes)
    found = vi.prove_all(rig, "20.6 Hz", "3.6 mm", 2)
    assert found.boxes == vi.prove_all(rig, at.r, at.clearance, 2).boxes


def proof_of_zone(tolerance=0.1, low=20.0):
    """A narrow strip across a zone, with its upper end in the zone, and its certificate."""
    zone = vi.zone(OSC, "RL", r=(1.04, 1.0404), clearance=(low, 80), symmetric=True, lines=5)
    return zone, zone.prove(tolerance)


@pytest.mark.slow
def test_zone(tmp_path):
    """Boxes proven inside and outside agree with the boundary and exact motions; most boxes are decided."""
    zone, proof = proof_of_zone()
    random = np.random.default_rng(3)
    decided = {True: 0, False: 0, None: 0}
    for _ in range(200):
        r, clearance = (
            random.uniform(1.04, 1.0404),
            math.exp(random.uniform(math.log(20), math.log(80))),
        )
        found = proof.decide(r, clearance)
        decided[found] += 1
        assert found in (None, bool(zone.contains(r, clearance)))
        stable = [m for m in vi.equispaced(OSC, r, clearance) if m.stable and m.admissible]
        assert found in (None, bool(stable))
    shares = proof.shares()
    assert sum(shares.values()) == pytest.approx(1, abs=1e-9)
    assert shares["undecided"] < 0.2
    assert min(decided[True], decided[False]) > 0
    assert proof.decide(1.2, 30.0) is None
    proof.save(tmp_path / "zone.json")
    assert vi.load(tmp_path / "zone.json") == proof
    assert "inside" in repr(proof)
    pytest.importorskip("matplotlib")
    assert proof.plot().get_legend() is not None
    with pytest.raises(vi.ParameterError, match="symmetric = True"):
        vi.zone(OSC, "RL", r=(1.04, 1.0404), clearance=(20, 80), lines=5).prove()
    with pytest.raises(AttributeError, match="only certificates of zones"):
        MOTIONS[0].prove().decide(1.04, 25.0)
    data = json.loads(proof.to_json())
    for box in data["boxes"][::12]:
        checker.check_box(data, box)


@pytest.mark.parametrize("r", [0.9984912506265515, 0.9984912506273515])
def test_beside_a_pitchfork(r):
    """A multiplier outside the circle by less than its bound has digits: the verdict holds, without a bound."""
    motion = min(vi.equispaced(TABLE1, r, 37.0), key=lambda one: max(abs(one.multipliers)))
    proof = motion.prove()
    assert (proof.exists, proof.admissible, proof.stable) == (True, True, r > 0.998491250627)
    checker.check(json.loads(proof.to_json()))


@functools.cache
def wide_zone():
    """A wide window across a zone, and its certificate."""
    zone = vi.zone(OSC, "RL", r=(1.2, 1.22), clearance=(1, 200), symmetric=True)
    return zone, zone.prove(tolerance=1e-3)


@pytest.mark.slow
def test_zone_across_its_window():
    """Nearly all of a wide window is decided, in agreement with the boundary of the zone, in few boxes."""
    zone, proof = wide_zone()
    assert len(proof.boxes) < 400
    shares = proof.shares()
    assert shares["undecided"] < 3e-3
    within = wrong = decided = 0
    for r in np.linspace(1.2005, 1.2195, 10):
        for clearance in np.exp(np.linspace(math.log(1.01), math.log(199), 200)):
            known, found = bool(zone.contains(r, clearance)), proof.decide(r, clearance)
            within += known
            decided += known and found is True
            wrong += found not in (None, known)
    assert wrong == 0
    assert decided > 0.98 * within > 0
    data = json.loads(proof.to_json())
    for box in data["boxes"][::25]:
        checker.check_box(data, box)


@pytest.mark.slow
def test_zone_against_simulations():
    """Simulations, which do not know the equations of motions, reach a symmetric motion at points proven inside,
    from near it and from other states, and at no point proven outside."""
    _, proof = wide_zone()
    random = np.random.default_rng(7)
    points, states, near, inside = [], [], [], []
    for _ in range(120):
        r, clearance = random.uniform(1.2, 1.22), math.exp(random.uniform(0, math.log(200)))
        decided = proof.decide(r, clearance)
        if decided is None:
            continue
        amplitude = 1 / math.hypot(1 - r * r, 2 * OSC.xi * r)
        starts = []
        if decided:
            (motion,) = [m for m in vi.equispaced(OSC, r, clearance) if m.stable and m.admissible]
            x_dot, z_dot = motion.X_dot_after[0], motion.Z_dot_after[0] * (1 + 1e-5)
            starts.append((motion.load_phase / r, motion.X[0], x_dot, motion.Z[0], z_dot))
        for _ in range(4):
            x = random.uniform(-1.2, 1.2) * amplitude
            starts.append((
                random.uniform(0, 2 * math.pi), x, random.uniform(-1.2, 1.2) * amplitude,
                x + random.uniform(-0.5, 0.5) * clearance, random.uniform(-1, 1) * clearance,
            ))  # fmt: skip
        for number, start in enumerate(starts):
            points.append((r, clearance))
            states.append(start)
            near.append(decided and number == 0)
            inside.append(decided)
    points, inside = np.transpose(points), np.array(inside)
    # not a whole number of cycles, so that no period ends at an impact
    run = vi.simulate_bundle(OSC, *points, 4000.137, np.transpose(states))
    assert (run.status == 0).all()
    reached = np.array([run.t, run.x, run.x_dot, run.z, run.z_dot])
    half = vi.simulate_bundle(OSC, *points, 0.5, reached)
    apart = np.abs([half.x + run.x, half.x_dot + run.x_dot, half.z + run.z, half.z_dot + run.z_dot])
    symmetric = apart.max(axis=0) < 1e-6 * np.abs(reached[1:]).max(axis=0)
    symmetric &= (half.impacts == 1) & (half.rests == 0)
    assert symmetric[near].all()
    assert sum(near) > 20
    assert (symmetric & inside & ~np.array(near)).any()
    assert not symmetric[~inside].any()
    assert (~inside).sum() > 100


@pytest.mark.slow
def test_false_zones_are_rejected(share):
    """The independent program accepts a zone, and rejects it if a box was dropped, shifted or flipped."""
    data = json.loads(proof_of_zone(0.1, 60.0)[1].to_json())
    checker.check(data)
    random = np.random.default_rng(5)
    for j in random.choice(len(data["boxes"]), max(1, share(6)), replace=False).tolist():
        dropped = copy.deepcopy(data)
        del dropped["boxes"][j]
        with pytest.raises(checker.RejectedError):
            checker.check(dropped)
        box = copy.deepcopy(data["boxes"][j])
        shifted = copy.deepcopy(data)
        low, high = (Fraction(end) for end in box["parameters"]["tangent"])
        shifted["boxes"][j]["parameters"]["tangent"] = [
            str(low + (high - low) / 8),
            str(high + (high - low) / 8),
        ]
        with pytest.raises(checker.RejectedError):
            checker.check(shifted)
        for name in ("stable", "admissible"):
            if box["exists"] and box[name] is not None:
                flipped = {**box, name: not box[name]}
                with pytest.raises(checker.RejectedError):
                    checker.check_box(data, flipped)
    # this box has a motion within the window
    motion = next(m for m in vi.equispaced(OSC, 1.04015, 66.0) if m.stable)
    place = {"r": 1.04015, "tangent": math.tan(motion.tau)}
    (known,) = (
        box for box in data["boxes"]
        if box["stable"] and all(
            float(Fraction(low)) < place[name] < float(Fraction(high))
            for name, (low, high) in box["parameters"].items()
        )
    )  # fmt: skip
    with pytest.raises(checker.RejectedError):
        checker.check_box(data, {**known, "exists": False})
    # a wider window has more motions: one of its boxes makes the certificate fail
    window = copy.deepcopy(data)
    window["system"]["clearance"] = ["0.001", "1000"]
    outside = [box for box in data["boxes"] if box["exists"] is False]
    with pytest.raises(checker.RejectedError):
        [checker.check_box(window, box) for box in outside]


def test_random_boxes():
    """Statements proven for all parameters of boxes hold for the exact motions at random points of the boxes."""
    random = np.random.default_rng(7)
    tried = 0
    for _ in range(4):
        osc = vi.Oscillator(
            xi=random.uniform(0.005, 0.03),
            mu=random.uniform(0.02, 0.1),
            restitution=random.uniform(0.5, 0.9),
        )
        r, clearance = random.uniform(0.8, 1.2), random.uniform(2, 30)
        proof = vi.prove_box(
            osc, "RL", r=(r, r + 1e-4), clearance=(clearance, clearance * 1.001), most_boxes=40
        )
        for motion in vi.equispaced(
            osc, r + random.uniform(0, 1e-4), clearance * random.uniform(1, 1.001)
        ):
            if proof.proven and motion.stable and motion.admissible:
                tried += 1
                assert motion.attenuation <= proof.attenuation_bound
                assert max(abs(motion.multipliers)) < 1
    assert tried > 0


def test_each_digit_of_a_centre():
    """A centre with a changed digit is rejected only where its box no longer contains the motion."""
    data = json.loads(MOTIONS[0].prove().to_json())
    text = data["boxes"][0]["centre"][0][0][0]
    radius = checker.number(data["boxes"][0]["radius"][0][0])
    digits, power = text.split("p")
    for k in range(2, len(digits)):
        other = copy.deepcopy(data)
        digit = format((int(digits[k], 16) + 1) % 16, "x")
        changed = f"{digits[:k]}{digit}{digits[k + 1 :]}p{power}"
        other["boxes"][0]["centre"][0][0][0] = changed
        distance = abs(checker.number(changed) - checker.number(text))
        if distance > 2 * radius:
            with pytest.raises(checker.RejectedError):
                checker.check(other)
        elif 8 * distance < radius:
            checker.check(other)


def test_independent_program(tmp_path):
    """The program accepts a file, rejects another, with its exit status; it does not import the package."""
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
    assert len(source.splitlines()) <= 400
    for part in CHECKER.parent.glob("*.py"):
        assert "import vibroimpact" not in part.read_text()
    assert "import vibroimpact" not in source


@pytest.mark.parametrize(
    "text",
    [
        None,
        "",
        "{",
        "[]",
        "null",
        "7",
        '{"type": "Certificate"}',
        "[" * 100_000,
        '{"a": NaN}',
        "\xff",
    ],
)
def test_independent_program_of_what_is_no_certificate(tmp_path, text):
    """One line names the error, and the exit status is 1."""
    path = tmp_path / "case.json"
    if text is not None:
        path.write_bytes(text.encode("latin-1"))
    assert checker.main([str(path)]) == 1


def test_independent_program_says_what_it_cannot_read(tmp_path, capsys):
    """The message names the file; a certificate that states nothing is reported as such."""
    missing, broken, nothing = (str(tmp_path / name) for name in ("none.json", "{.json", "no.json"))
    Path(broken).write_text("{")
    vi.prove_box(OSC, "RL", r=1.04, clearance=(10, 11)).save(nothing)
    assert checker.main([missing, broken, nothing]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith(f"{missing}: cannot be read: ")
    assert lines[1].startswith(f"{broken}: cannot be read: ")
    assert lines[2] == f"{nothing}: accepted: it proves nothing"


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (("cycles",), True, "cycles = True: must be of type int"),
        (("kind",), "foo", "kind = 'foo': must be one of motion"),
        (("seconds",), math.nan, "seconds = nan: must be a time in seconds"),
        (("system",), {}, r"system\['xi'\] = None: must be the text of an exact number"),
        (("system", "r"), "1e999999999", r"system\['r'\] = '1e999999999': must be the text"),
        (("sheets", 0), {"r": ["a", "b"]}, r"sheets\[0\]\['r'\] = 'a': must be the text"),
        (("boxes", 0), 1, r"boxes\[0\] = 1: must be a dict"),
        (("boxes", 0), {}, r"boxes\[0\]\['sheet'\] = None: must be the number of a sheet"),
        (("boxes", 0, "stable"), "no", r"boxes\[0\]\['stable'\] = 'no': must be True, False or None"),
        (("boxes", 0, "multipliers_below"), "nan", r"\['multipliers_below'\] = 'nan': must be the text"),
        (("boxes", 0, "centre", 0, 0), ["x"], r"boxes\[0\]\['centre'\] = 'x': must be the text"),
        (("boxes", 0, "radius"), ["0x1p0"], r"boxes\[0\]\['radius'\] = .* must be lists of exact"),
        (("undecided",), [1], r"undecided\[0\] = 1: must be a dict with a reason"),
        (("boxes", 0, "attenuation_below"), "1" * 5000, r"\['attenuation_below'\] = '1+: must be the text"),
        (("boxes", 0, "parameters"), {"r": ["0x1p99999", "1"]}, r"\['r'\] = '0x1p99999': must be the text"),
    ],
)  # fmt: skip
def test_files_of_another_form(path, value, message):
    """An item that a certificate cannot have is named."""
    _, other = changed_in(MOTIONS[0].prove().to_dict(), "", *path, value=lambda _: value)
    with pytest.raises((vi.ParameterError, vi.ParameterTypeError), match=message):
        vi.Certificate.from_dict(other)


def test_files_with_fractions():
    """Bounds and places may be fractions or hexadecimal, as all exact numbers."""
    data = MOTIONS[0].prove().to_dict()
    bounds = {"multipliers_below": "0x1p0", "attenuation_below": "7/8"}
    _, other = changed_in(data, "", "boxes", 0, value=lambda box: box | bounds)
    checker.check(json.loads(json.dumps(other)))
    proof = vi.Certificate.from_dict(other)
    assert (proof.multiplier_bound, proof.attenuation_bound) == (1.0, 0.875)
    assert "max|lambda| < 1)" in repr(proof)
    data = KINDS["zone"]().to_dict()
    low = data["boxes"][0]["parameters"]["tangent"][0]
    assert low == "-4096"
    path = ("boxes", 0, "parameters", "tangent", 0)
    _, other = changed_in(data, "", *path, value=lambda _: "-0x1000p0")
    assert vi.Certificate.from_dict(other).shares() == vi.Certificate.from_dict(data).shares()


def test_files_of_whole_seconds_and_broken_text():
    """A whole number of seconds is valid as a time; broken JSON is an error of the text."""
    data = MOTIONS[0].prove().to_dict()
    assert vi.Certificate.from_dict(data | {"seconds": 1}).seconds == 1.0
    with pytest.raises(vi.ParameterError, match=r"text = '\{': must be JSON"):
        vi.Certificate.from_json("{")


@pytest.mark.parametrize("kind", KINDS)
def test_files_of_each_kind(kind):
    """A certificate of each kind is read back from its text."""
    proof = KINDS[kind]()
    assert vi.Certificate.from_json(proof.to_json()) == proof


def test_files(tmp_path):
    """A saved certificate is read with the same numbers."""
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
    """At a pitchfork existence or stability is undecided, with the reason, and never guessed."""
    branch = vi.branch(MOTIONS[0], "clearance", bounds=(15.0, 30.0))
    (fork,) = [point for point in branch.special_points if point.type == "pitchfork"]
    assert not fork.motion.prove().proven
    # the next double is 1e-14 off: what is decided there is true of its decimal text
    near = branch.prove(tolerance=0.01)
    (gap,) = near.undecided
    assert "unit circle" in gap["reason"]
    assert near.stable is None


def test_no_damping():
    """With R = 1 and xi = 0 nothing decays: no motion is proven stable."""
    osc = vi.Oscillator(xi=0, mu=0.1, restitution=1)
    found = [motion for r in (0.5, 0.8, 1.3) for motion in vi.equispaced(osc, r, 1.0)]
    assert found
    for motion in found:
        assert motion.prove().stable is not True


def test_refused():
    """Motions with rest and boxes of structures have other equations."""
    stop = vi.Structure([1], [0.1], [1], [vi.Gap([1], 1, 0.8)])
    for call in (
        lambda: vi.prove_box(stop, "RL", r=1.0, clearance=2.0),
        lambda: vi.prove_all(stop, 1.0, 2.0),
    ):
        with pytest.raises(
            vi.ParameterTypeError, match=r"must be a vibroimpact\.Oscillator, not Structure"
        ):
            call()
    osc = vi.Oscillator(xi=0.05, mu=0.1, restitution=0.3)
    rest = next(motion for motion in vi.find(osc, 0.3, 0.5) if motion.pattern.has_rest)
    for call in (rest.prove, lambda: vi.prove_box(osc, rest.pattern, r=0.3, clearance=0.5)):
        with pytest.raises(vi.ParameterError, match="must be without rest, which proofs") as error:
            call()
        name = "motion = <Motion" if call == rest.prove else "pattern = 'R*L*/"
        assert str(error.value).startswith(name)
    with pytest.raises(
        vi.ParameterError, match=r"^pattern = '(RL)*/1': must have at most 12 impacts"
    ):
        vi.prove_box(OSC, "RL" * 20, r=1.04, clearance=25.0)


@pytest.mark.slow
def test_motions_of_find(share):
    """Motions of random oscillators have proven verdicts without contradictions; few are undecided."""
    random = np.random.default_rng(47)
    number = open_ = 0
    systems = share(25)
    for _ in range(systems):
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
    assert number > 4 * systems
    assert open_ <= 0.03 * number + 1


#: Ten points of systems with light and heavy damping, weak and strong impacts, and walls that differ.
POINTS = [
    *((OSC, r, clearance) for r, clearance in ((1.04, 25.0), (0.9, 5.0), (0.8, 3.0), (1.2, 4.0), (1.0, 60.0))),
    (TABLE1, 0.94, 37.0),
    (vi.Oscillator(xi=0.005, mu=0.042, restitution=(0.75, 0.6)), 0.97, 20.0),
    (vi.Oscillator(xi=0.05, mu=0.1, restitution=0.5), 0.7, 1.5),
    (vi.Oscillator(xi=0.1, mu=0.3, restitution=0.8), 1.5, 0.8),
    (vi.Oscillator(xi=0.02, mu=0.05, restitution=(0.4, 0.9)), 1.1, 6.0),
]  # fmt: skip


def assert_all(osc, r, clearance, impacts, cycles=1):
    """All motions are proven, and `find` has exactly the admissible ones."""
    proof = vi.prove_all(osc, r, clearance, max_impacts=impacts, max_cycles=cycles)
    assert proof.complete
    words = [tuple(sheet.values()) for sheet in proof.sheets]
    found = [
        motion for motion in vi.find(osc, r, clearance, max_impacts=impacts, max_cycles=cycles)
        if (motion.pattern.sides, motion.cycles) in words
    ]  # fmt: skip
    listed = [
        (*words[box["sheet"]], box["stable"], exact(box["centre"][0][1][0]))
        for box in proof.boxes if box["admissible"]
    ]  # fmt: skip
    known = [(motion.pattern.sides, motion.cycles, motion.stable, motion.X[0]) for motion in found]
    assert [one[:3] for one in sorted(listed)] == [one[:3] for one in sorted(known)]
    places = [[float(one[3]) for one in sorted(some)] for some in (listed, known)]
    assert places[0] == pytest.approx(places[1], rel=1e-7)
    return proof


@pytest.mark.parametrize("point", [1, 5, 6])
def test_all_motions_of_two_impacts(point):
    """The motions equal those of `find` that stay between the walls; the independent program proves it too."""
    proof = assert_all(*POINTS[point], 2)
    checker.check(json.loads(proof.to_json()))
    assert "all motions RL/1" in repr(proof)
    assert "complete" in repr(proof)


@pytest.mark.slow
def test_all_motions_of_several_cycles():
    """The same for periods of one and of two load cycles."""
    proof = assert_all(*POINTS[5], 2, 2)
    assert {proof.sheets[box["sheet"]]["cycles"] for box in proof.boxes} == {1, 2}
    data = json.loads(proof.to_json())
    checker.check(data)
    # a motion of two cycles is none of one cycle, and none may be omitted
    two = next(k for k, box in enumerate(data["boxes"]) if box["sheet"] == 1)
    moved = copy.deepcopy(data)
    moved["boxes"][two]["sheet"] = 0
    for false in (moved, {**data, "boxes": data["boxes"][:two] + data["boxes"][two + 1 :]}):
        with pytest.raises(checker.RejectedError):
            checker.check(false)


@pytest.mark.slow
def test_all_motions_of_three_impacts(share):
    """The same for RL, RRL and RLL at ten points and, in complete runs, for two load cycles at one of them."""
    tried = POINTS[: share(len(POINTS))]
    proofs = [assert_all(*point, 3) for point in tried]
    if tried == POINTS:
        proofs.append(assert_all(*POINTS[5], 3, 2))
    for proof in proofs:
        checker.check(json.loads(proof.to_json()))


@pytest.mark.parametrize(("sides", "cycles"), [("RRL", 1), ("RLL", 1), ("RL", 2)])
def test_linear_laws_of_given_times(sides, cycles):
    """The laws that the independent search uses hold for a motion, and their slopes are derivatives."""
    osc, r, clearance = POINTS[5]
    found = vi.find(osc, r, clearance, max_impacts=len(sides), max_cycles=cycles)
    shifted = [sides[k:] + sides[:k] for k in range(len(sides))]
    motion = next(
        one
        for one in found
        if one.pattern.sides in shifted and one.cycles == cycles and one.admissible
    )
    data = json.loads(motion.prove().to_json())
    pair = checker.Pair(data | {"symmetric": False}, {"parameters": {}})
    phases = motion.phases
    times = [float(one) for one in np.diff(phases) / (2 * math.pi * cycles)]
    word = search.Word(pair, [])
    amplitude = float(checker.ball(pair.A).mid())
    theta = phases[0] + math.atan2(float(checker.ball(pair.b)), float(checker.ball(pair.a)))
    before = np.roll(motion.Z_dot_after, 1)
    speeds = [
        one * side for one, side in zip(before - motion.X_dot_before, pair.sides, strict=True)
    ]
    unknowns = [
        *speeds,
        motion.Z_dot_after[0],
        math.sin(theta) * amplitude,
        math.cos(theta) * amplitude,
    ]
    column = np.array(unknowns) / amplitude

    def laws(times):
        matrix, right, slopes = word.laws([checker.arb(one) for one in times])
        doubles = lambda one: np.array([[float(x.mid()) for x in row] for row in one.tolist()])  # noqa: E731
        return doubles(matrix), doubles(right)[:, 0], [doubles(one) for one in slopes]

    matrix, right, slopes = laws(times)
    assert np.abs(matrix @ column - right).max() < 1e-9 * np.abs(column).max()
    for k, slope in enumerate(slopes):
        step = [1e-6 * (i == k) for i in range(len(times))]
        ends = [laws(np.array(times) + sign * np.array(step))[0] for sign in (1, -1)]
        assert (ends[0] - ends[1]) / 2e-6 == pytest.approx(
            slope, rel=1e-6, abs=1e-6 * np.abs(slope).max()
        )


@pytest.mark.slow
def test_false_certificates_of_all_motions_are_rejected():
    """A certificate with a motion missing or duplicated, or with changed words or numbers, is rejected."""
    data = json.loads(vi.prove_all(TABLE1, 0.94, 37.0, max_impacts=2).to_json())
    assert len(data["boxes"]) == 4
    false = []
    for j in range(len(data["boxes"])):
        rest = data["boxes"][:j] + data["boxes"][j + 1 :]
        false += [{**data, "boxes": rest}, {**data, "boxes": [*data["boxes"], data["boxes"][j]]}]
        flipped = copy.deepcopy(data)
        flipped["boxes"][j]["stable"] = not flipped["boxes"][j]["stable"]
        false.append(flipped)
    false += [
        {**data, "system": {**data["system"], name: text}}
        for name, text in (
            ("clearance", "37.01"),
            ("r", "0.9401"),
            ("restitution", ["0.75", "0.74"]),
        )
    ]
    false += [
        {**data, "sheets": [*data["sheets"], {"sides": "RL", "cycles": 2}], "sides": "RL, RL"},
        {**data, "sheets": [{"sides": "RL", "cycles": 3}], "cycles": 3},
        {**data, "sheets": [], "boxes": [], "sides": ""},
    ]
    for one in false:
        with pytest.raises(checker.RejectedError):
            checker.check(one)


def test_all_motions_are_not_promised_in_vain():
    """Near a fold boxes of times stay undecided, as the certificate states; cases without a bound are refused."""
    motion = vi.equispaced(TABLE1, 0.94, 37.0)[0]
    points = vi.branch(motion, "clearance", bounds=(30.0, 1000.0)).special_points
    fold = next(point for point in points if point.type == "fold")
    clearance = float(f"{fold.clearance:.14g}")
    proof = vi.prove_all(TABLE1, 0.94, clearance, max_impacts=2)
    assert not proof.complete
    assert "there may be others" in repr(proof)
    assert {item["sheet"] for item in proof.undecided} == {0}
    checker.check(json.loads(proof.to_json()))
    with pytest.raises(
        vi.ParameterError, match="must have xi, mu and R1, R2 above 0, and R1, R2 below 1"
    ):
        vi.prove_all(vi.Oscillator(xi=0.01, mu=0.03, restitution=1.0), 0.9, 5.0)
    with pytest.raises(
        vi.ParameterError,
        match="max_impacts = 4: must be a whole number with 2 <= max_impacts <= 3",
    ):
        vi.prove_all(OSC, 0.9, 5.0, max_impacts=4)


@pytest.mark.slow
def test_branch_across_resonance():
    """Over wide boxes of r the amplitude without impacts has no bound: they are halved, and all is proven."""
    motion = vi.equispaced(vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75), 1.01, 37.0)[0]
    branch = vi.branch(motion, "r", bounds=(0.9985, 1.0155))
    proof = branch.prove()
    assert branch.stable.all()
    assert (proof.proven, proof.stable, proof.admissible) == (True, True, True)
    ends = [[float(Fraction(end)) for end in box["parameters"]["r"]] for box in proof.boxes]
    assert (min(low for low, _ in ends), max(high for _, high in ends)) == (0.9985, 1.0155)


#: One oscillator before a wall (COCO's example 15.2), and the pair as a structure.
WALL = vi.Structure([[1]], [[0.1]], [[1]], [vi.Gap([1], 1.0, 0.8)])


def structures():
    """A motion with one wall, one of the pair, and an unstable one of the pair."""
    one = vi.exact(WALL, vi.Load(1.0, cosine=[1.0]), ([0.0759], [0], 1))
    found = [one]
    for osc, r, clearance, motion in (
        (OSC, 1.04, 25.0, MOTIONS[0]), (TABLE1, 0.94, 37.0, MOTIONS[1]),
    ):  # fmt: skip
        point = osc.at(r, clearance)
        found.append(
            vi.exact(point.structure, point.load, (motion.phases, motion.gaps.tolist(), 1))
        )
    return found


def test_motion_of_one_wall():
    """The phase, the speed and the multipliers that COCO's tutorial prints are enclosed."""
    motion = structures()[0]
    proof = motion.prove()
    assert proof.proven
    # |lambda|^2 is the determinant, exp(-.1 T) R^2, since both multipliers are complex
    law = 0.8 * math.exp(-0.1 * math.pi)
    assert law < proof.multiplier_bound < law * (1 + 1e-6)
    time, q, speed = (float(exact(text)) for (text,) in proof.boxes[0]["centre"][0])
    assert [time, q] == pytest.approx([0.07595216493831, 1.0], rel=1e-12)
    assert speed == pytest.approx(-0.8 * 1.69573294, rel=1e-8)
    assert "exists, admissible, stable" in repr(proof)
    assert "proven" in proof._repr_html_()


def test_pair_as_structure():
    """The verdicts and the bound equal those of the oscillator's proof."""
    for motion, of_oscillator in zip(structures()[1:], MOTIONS, strict=False):
        proof, other = motion.prove(), of_oscillator.prove()
        for name in ("symmetric", "exists", "admissible", "stable"):
            assert getattr(proof, name) is getattr(other, name)
        if other.stable:
            assert proof.multiplier_bound == pytest.approx(other.multiplier_bound, rel=1e-9)
        checker.check(json.loads(proof.to_json()))


def wrong_structures(data):
    """Certificates of a structure with a single false change."""

    changed = partial(changed_in, data)

    for name in ("mass", "damping", "stiffness", "sine", "cosine"):
        for i, row in enumerate(data["system"][name]):
            for j, text in enumerate(row):
                if float(text):
                    more = lambda text: repr(float(text) * 1.000001)  # noqa: E731
                    yield changed(f"{name} {i} {j}", "system", name, i, j, value=more)
    yield changed(
        "frequency", "system", "frequency", value=lambda text: repr(float(text) * 1.00001)
    )
    for name in ("opening", "restitution"):
        more = lambda text: repr(float(text) * 1.00001)  # noqa: E731
        yield changed(name, "system", "gaps", 0, name, value=more)
    for i in range(len(data["system"]["gaps"])):
        for j, text in enumerate(data["system"]["gaps"][i]["direction"]):
            more = lambda text: repr(float(text) * 1.00001 or 0.001)  # noqa: E731
            if any(k == i for k in data["system"]["impacts"]):
                yield changed(f"direction {i} {j}", "system", "gaps", i, "direction", j, value=more)
    yield changed("constant", "system", "constant", 0, value=lambda text: repr(float(text) + 1e-5))
    yield changed("impacts", "system", "impacts", value=lambda gaps: [*gaps, gaps[0]])
    yield changed("sides", "sides", value=lambda sides: sides + " 0")
    yield changed("box dropped", "boxes", value=lambda _: [])
    yield changed("symmetric", "symmetric", value=lambda symmetric: not symmetric)
    yield changed("cycles", "cycles", value=lambda k: k + 1)
    box = data["boxes"][0]
    for i, row in enumerate(box["centre"]):
        for k in range(len(row)):
            moved = (exact(row[k][0]) + 2 * exact(box["radius"][i][k])) * 2**300
            by = lambda _, moved=int(moved): f"{hex(moved)}p-300"  # noqa: E731
            yield changed(f"centre {i} {k}", "boxes", 0, "centre", i, k, 0, value=by)
            yield changed(f"radius {i} {k}", "boxes", 0, "radius", i, k, value=lambda _: "0x0p0")
    for name in ("exists", "admissible", "stable"):
        yield changed(name, "boxes", 0, name, value=lambda verdict: not verdict)
    if box["multipliers_above"]:
        higher = lambda text: f"{float(text) * (1 + 1e-5):.12f}"  # noqa: E731
        yield changed("bound", "boxes", 0, "multipliers_above", value=higher)
    if box["multipliers_below"]:
        lower = lambda text: f"{float(text) * (1 - 1e-5):.12f}"  # noqa: E731
        yield changed("bound", "boxes", 0, "multipliers_below", value=lower)


def test_false_certificates_of_structures_are_rejected():
    """Changed digits, shifted boxes and flipped verdicts are rejected."""
    for motion in structures():
        data = json.loads(motion.prove().to_json())
        checker.check(data)
        for what, other in wrong_structures(data):
            with pytest.raises(checker.RejectedError):
                checker.check(other)
            assert what


def beam_motion():
    """A beam of three modes between two different walls."""
    shapes = [[1.2, -0.7, 0.4], [0.6, 1.1, -0.8]]
    beam = vi.Structure.from_modes(
        [1.0, 2.7, 5.3], [0.02, 0.01, 0.01], shapes,
        gaps=[vi.Gap([1, 0], 0.9, 0.7), vi.Gap([0, -1], 0.6, 0.6)],
    )  # fmt: skip
    load = vi.Load(0.83, sine=[[0.9, 0.2, 0.1]], constant=[0.05, 0, 0])
    return vi.exact(beam, load, vi.simulate(beam, load, cycles=400))


def test_beam_with_two_gaps():
    """The verdicts for the motion of a beam, and its numbers, are proven."""
    motion = beam_motion()
    proof = motion.prove()
    assert (proof.exists, proof.admissible, proof.stable) == (
        True,
        motion.admissible,
        motion.stable,
    )
    assert max(abs(motion.multipliers)) < proof.multiplier_bound < 1
    texts, radii = (np.array(proof.boxes[0][key]) for key in ("centre", "radius"))
    centre = np.array([[float(exact(text)) for text in row] for row in texts[..., 0]])
    radius = np.array([[float(exact(text)) for text in row] for row in radii])
    states = motion.states.reshape(len(centre), -1)
    assert np.all(abs(centre[:, 1:] - states) < 10 * radius[:, 1:])
    checker.check(json.loads(proof.to_json()))
    assert vi.Certificate.from_json(proof.to_json()) == proof


def chain_motion():
    """Three masses, the last one facing a wall, under a harmonic and a constant force."""
    stiffness = np.array([[2.0, -1, 0], [-1, 2, -1], [0, -1, 1]])
    chain = vi.Structure(np.eye(3), 0.1 * stiffness, stiffness, [vi.Gap([0, 0, 1], 1.0, 0.6)])
    load = vi.Load(0.5, sine=[[0, 0, 1.0]], constant=[0, 0, 0.01])
    return vi.exact(chain, load, vi.simulate(chain, load, cycles=400))


#: A motion of a structure, the parameter, the interval, and whether half a period is enough.
BRANCHES = [
    (lambda: structures()[0], "frequency", (0.98, 1.02), False),
    (lambda: structures()[0], "opening", (0.9, 1.1), False),
    (lambda: structures()[1], "opening", (10.4, 12.5), True),
    (lambda: structures()[1], "restitution_0", (0.74, 0.76), False),
    (chain_motion, "constant", (0.5, 1.5), False),
    (chain_motion, "frequency", (0.499, 0.501), False),
]


@pytest.mark.parametrize(
    ("motion", "parameter", "bounds", "symmetric"), BRANCHES,
    ids=["wall frequency", "wall opening", "pair opening", "pair one wall", "chain constant", "chain frequency"],
)  # fmt: skip
def test_branch_of_structure(motion, parameter, bounds, symmetric):
    """Verdicts agree with those of the points, motions in between are inside the boxes, and the check succeeds."""
    motion = motion()
    branch = vi.branch(motion, parameter, bounds=bounds)
    proof = branch.prove(tolerance=1e-2)
    assert (proof.kind, proof.exists, proof.admissible) == ("branch", True, True)
    assert proof.symmetric is symmetric
    special = [point.value for point in branch.special_points if point.type != "bound"]
    assert (proof.stable is None) == bool(special) == bool(proof.undecided)
    for gap in proof.undecided:
        low, high = (float(Fraction(end)) for end in gap["parameters"][parameter])
        assert any(low <= value <= high for value in special)
    for box in proof.boxes:
        low, high = (float(Fraction(end)) for end in box["parameters"][parameter])
        value = low + 0.7 * (high - low)
        structure, load = branch.at(value)
        near = branch[int(np.argmin(abs(branch.values - value)))]
        own = vi.exact(structure, load, (near.phases, near.gaps.tolist(), near.cycles))
        times = own.phases / load.frequency
        states = np.column_stack([times, own.states.reshape(len(times), -1)])[: len(box["centre"])]
        centre = [
            [sum(float(exact(text)) * 0.4**k for k, text in enumerate(one)) for one in row]
            for row in box["centre"]
        ]
        radius = [[float(exact(text)) for text in row] for row in box["radius"]]
        assert np.all(abs(states - centre) < radius)
        # far less than the radius: the polynomials follow the motions
        assert states == pytest.approx(np.array(centre), rel=1e-4, abs=1e-4)
        assert box["stable"] in (None, own.stable)
        if box["multipliers_below"]:
            assert max(abs(own.multipliers)) < float(box["multipliers_below"])
    checker.check(json.loads(proof.to_json()))
    assert f"for {parameter} {bounds[0]:g} to {bounds[1]:g} in " in repr(proof)


@pytest.mark.slow
def test_branches_of_symmetric_pairs():
    """Certificates of random pairs as structures are accepted, also of motions with large multipliers, and where
    a number of Routh's array changes its sign."""
    largest = []
    for mu, R, xi, r, clearance, parameter in (
        (0.1, 0.8, 0.025, 1.006, 10.9, "frequency"),
        (0.05, 0.75, 0.01, 1.04, 9.4, "frequency"),
        (0.36, 0.53, 0.0355, 1.139, 10.0, "opening"),
    ):
        osc = vi.Oscillator(xi=xi, mu=mu, restitution=R)
        for motion in vi.equispaced(osc, r, clearance):
            point = osc.at(r, clearance)
            motion = vi.exact(point.structure, point.load, (motion.phases, motion.gaps.tolist(), 1))
            bounds = (r, r * 1.006) if parameter == "frequency" else (4.5, 5.5)
            proof = vi.branch(motion, parameter, bounds=bounds).prove(tolerance=0.3)
            assert (proof.symmetric, proof.exists) == (True, True)
            largest.append(max(abs(motion.multipliers)))
            checker.check(json.loads(proof.to_json()))
    assert max(largest) > 2


def wrong_branches(data):
    """Certificates of a branch of a structure with a single false change."""

    changed = partial(changed_in, data)

    ((varied, ends),) = data["boxes"][0]["parameters"].items()
    half = lambda text: repr(float(text) * 0.5)  # noqa: E731
    for name in ("mass", "damping", "stiffness", "sine", "cosine"):
        for i, row in enumerate(data["system"][name]):
            for j, text in enumerate(row):
                if float(text):
                    yield changed(f"{name} {i} {j}", "system", name, i, j, value=half)
    if varied != "frequency":
        yield changed("frequency", "system", "frequency", value=half)
    for name in ("opening", "restitution"):
        if name not in (varied, varied[:-2]):
            yield changed(name, "system", "gaps", 0, name, value=half)
    yield changed("impacts", "system", "impacts", value=lambda gaps: [*gaps, gaps[0]])
    yield changed("sides", "sides", value=lambda sides: sides + " 0")
    yield changed("symmetric", "symmetric", value=lambda symmetric: not symmetric)
    yield changed("cycles", "cycles", value=lambda k: k + 1)
    yield changed("kind", "kind", value=lambda _: "box")
    width = (Fraction(ends[1]) - Fraction(ends[0])) / 7
    move = lambda old: [str(Fraction(end) + width) for end in old]  # noqa: E731
    wider = lambda old: [old[0], str(Fraction(old[1]) + width)]  # noqa: E731
    yield changed("sheet wider", "sheets", 0, varied, value=wider)
    for j, box in enumerate(data["boxes"]):
        if j > 1 and box["stable"] is not None:
            continue
        yield changed(
            f"box {j} dropped", "boxes", value=lambda boxes, j=j: boxes[:j] + boxes[j + 1 :]
        )
        for what, value in (("moved", move), ("wider", wider)):
            yield changed(f"box {j} {what}", "boxes", j, "parameters", varied, value=value)
        for name in ("exists", "admissible", "stable"):
            if box[name] is not None:
                flip = lambda verdict: not verdict  # noqa: E731
                yield changed(f"{name} of box {j}", "boxes", j, name, value=flip)
        if box["multipliers_below"]:
            lower = lambda text: f"{float(text) * 0.8:.12f}"  # noqa: E731
            yield changed(f"bound {j}", "boxes", j, "multipliers_below", value=lower)
    box = data["boxes"][0]
    for i, row in enumerate(box["centre"]):
        for k in range(len(row)):
            moved = (exact(row[k][0]) + 2 * exact(box["radius"][i][k])) * 2**300
            by = lambda _, moved=int(moved): f"{hex(moved)}p-300"  # noqa: E731
            yield changed(f"centre {i} {k}", "boxes", 0, "centre", i, k, 0, value=by)
            yield changed(f"radius {i} {k}", "boxes", 0, "radius", i, k, value=lambda _: "0x0p0")


@pytest.mark.slow
@pytest.mark.parametrize("number", [
    1, *(pytest.param(number, marks=pytest.mark.slow) for number in (0, 2))
])  # fmt: skip
def test_false_branches_of_structures_are_rejected(number, pytestconfig):
    """Changed systems, shifted and dropped boxes, and flipped verdicts are rejected; every eighth with --once."""
    make, parameter, bounds, _ = BRANCHES[number]
    data = json.loads(vi.branch(make(), parameter, bounds=bounds).prove(tolerance=1e-1).to_json())
    checker.check(data)
    accepted = []
    step = 8 if pytestconfig.getoption("--once") else 1
    for what, other in islice(wrong_branches(data), 0, None, step):
        try:
            checker.check(other)
        except checker.RejectedError:
            continue
        accepted.append(what)
    assert accepted == []


def test_symmetric_structure_beside_a_pitchfork():
    """Over half a period the symmetric motion is proven next to the pitchfork: unstable before, stable after."""
    branch = vi.branch(structures()[1], "opening", bounds=(10.4, 12.5))
    point = next(one for one in branch.special_points if one.type == "pitchfork")
    for share, stable in ((-1e-8, False), (1e-8, True)):
        structure, load = branch.at(point.value * (1 + share))
        near = branch[point.index]
        proof = vi.exact(structure, load, (near.phases, near.gaps.tolist(), 1)).prove()
        assert (proof.symmetric, proof.exists, proof.stable) == (True, True, stable)
        checker.check(json.loads(proof.to_json()))


def test_branches_of_structures_that_are_refused():
    """Refusals name the parameter, or the item that the equations do not contain."""
    motion = structures()[0]
    with pytest.raises(
        vi.ParameterError, match=r"parameter = 'stiffness': must be one of frequency"
    ):
        vi.branch(motion, "stiffness", bounds=(0.9, 1.1)).prove()
    load = vi.Load(1.0, cosine=[1.0])
    stop = vi.Structure([[1]], [[0.1]], [[1]], [vi.Stop([1], 1.0, 10.0)])
    soft = vi.exact(stop, load, vi.simulate(stop, load, cycles=400))
    with pytest.raises(vi.ParameterError, match="must not have stops, which proofs"):
        vi.branch(soft, "frequency", bounds=(0.98, 1.02)).prove()


def test_structures_that_are_refused():
    """Refusals name the item that the equations do not contain."""
    load = vi.Load(1.0, cosine=[1.0])
    law = vi.PowerLaw(0.8, 1.0, 0.2)
    friction = vi.Structure(
        [[1]], [[0.1]], [[1]], [vi.Gap([1], 1.0, 0.8)], friction=[vi.Friction([1], 0.01)]
    )
    for structure, name in (
        (vi.Structure([[1]], [[0.1]], [[1]], [vi.Stop([1], 1.0, 10.0)]), "stops"),
        (friction, "friction"),
        (vi.Structure([[1]], [[0.1]], [[1]], [vi.Gap([1], 1.0, law)]), r"R\(v\)"),
    ):
        motion = vi.exact(structure, load, vi.simulate(structure, load, cycles=400))
        with pytest.raises(vi.ParameterError, match=f"must not have {name}, which proofs"):
            motion.prove()


def test_structure_near_a_fold():
    """At a published fold nothing is proven; just above it both the stable and the unstable motion are."""
    wall = vi.Structure([[1]], [[0.04]], [[1]], [vi.Gap([1], 1.0, 0.9)])
    proofs = [
        vi.exact(wall, vi.Load(0.799, cosine=[force]), ([phase], [0], 2)).prove()
        for force, phase in ((0.3628362019808788, 0.0573), (0.36283621, 0.05), (0.36283621, 0.1))
    ]
    assert [proof.stable for proof in proofs] == [None, True, False]
    assert [proof.exists for proof in proofs] == [None, True, True]
    assert "near a fold" in proofs[0].undecided[0]["reason"]
    for proof in proofs:
        checker.check(json.loads(proof.to_json()))


@pytest.mark.parametrize(("frequency", "phase", "stable"), [(0.9, 0.01, None), (1.5, 3.13, False)])
def test_structure_without_loss(frequency, phase, stable):
    """Multipliers on the unit circle are undecided; one of a reciprocal pair is proven to be outside."""
    wall = vi.Structure([[1]], [[0]], [[1]], [vi.Gap([1], 1.0, 1.0)])
    proof = vi.exact(wall, vi.Load(frequency, cosine=[1.0]), ([phase], [0], 1)).prove()
    assert (proof.exists, proof.admissible, proof.stable) == (True, True, stable)
    assert bool(proof.undecided) is (stable is None)
    checker.check(json.loads(proof.to_json()))


@pytest.mark.slow
def test_random_structures(share):
    """No verdict contradicts that of the motion; nothing is proven only if a floating mass has a multiplier 1."""
    pytest.importorskip("scipy")
    from test_structure_motion import samples

    decided = 0
    for motion, _ in samples(share(12)):
        proof = motion.prove()
        if proof.exists is None:
            assert min(abs(motion.multipliers - 1)) < 1e-6
            continue
        assert (proof.admissible, proof.stable) == (motion.admissible, motion.stable)
        decided += 1
        if len(motion.gaps) < 4:
            checker.check(json.loads(proof.to_json()))
    assert decided > 0


@pytest.mark.parametrize("name", ["motion", "structure"])
def test_progress_of_a_motion(name):
    """Each attempt is reported before it starts, and the certificate is the same."""
    motion = MOTIONS[0] if name == "motion" else structures()[0]
    told = []
    proof = motion.prove(progress=lambda share, what: told.append((share, what)))
    assert told[0] == (0.0, "64 bits")
    assert told == sorted(told, key=lambda pair: pair[0])
    assert told[-1][0] < 1
    assert repr(proof) == repr(motion.prove())
    with pytest.raises(vi.ParameterTypeError, match="progress = 3"):
        motion.prove(progress=3)
