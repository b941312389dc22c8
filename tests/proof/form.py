"""The form of certificates, for the program that checks them: each has all items and no others, and what it calls
not decided is what its boxes leave open, neither more nor less."""

from math import isfinite

from series import exact, flat, need

#: The items of a certificate and of its parts, with their allowed values.
ITEMS = {
    "type": str, "format": int, "kind": str, "sides": str, "cycles": int, "symmetric": bool,
    "system": dict, "sheets": list, "boxes": list, "undecided": list, "seconds": (int, float),
}  # fmt: skip
KINDS = ("motion", "branch", "box", "zone", "all")
PAIR = ("xi", "mu", "r", "clearance", "load", "restitution")
STRUCTURE = (
    "mass", "damping", "stiffness", "gaps", "frequency", "sine", "cosine", "constant", "impacts",
)  # fmt: skip
GAP = ("direction", "opening", "restitution")
VERDICTS = ("exists", "admissible", "stable")
BOUNDS = ("multipliers_below", "multipliers_above", "attenuation_below")


def check_form(data):
    """Raise RejectedError unless a certificate has this form."""
    need(isinstance(data, dict), "a certificate is an object")
    need(data.get("type") == "Certificate" and data.get("format") == 1, "a certificate, format 1")
    need(set(data) == set(ITEMS), f"the items {', '.join(ITEMS)}")
    for name, kind in ITEMS.items():
        value = data[name]
        need(isinstance(value, kind), f"{name} of another type")
        need(isinstance(value, bool) == (kind is bool), f"{name} of another type")
    kind, system, sheets, boxes = (data[name] for name in ("kind", "system", "sheets", "boxes"))
    need(kind in KINDS, "a certificate of a kind")
    need(data["cycles"] > 0, "a number of cycles")
    need(isfinite(data["seconds"]) and data["seconds"] >= 0, "a time in seconds")
    need(set(system) == set(STRUCTURE if "mass" in system else PAIR), "the items of a system")
    need(all(set(gap) == set(GAP) for gap in system.get("gaps", [])), "the items of a gap")
    need("mass" not in system or kind in ("motion", "branch"), "a motion or branch of a structure")
    need("mass" in system or isinstance(system["restitution"], list), "a list of R")
    need(sheets, "a sheet")
    need(kind not in ("motion", "box") or len(sheets) == 1, "one sheet")
    need(kind != "motion" or sheets == [{}], "a motion at one point")
    need(kind != "branch" or len(sheets[0]) == 1, "a branch along one parameter")
    need(all(set(one) == set(sheets[0]) for one in sheets), "the same parameters in all sheets")
    need(
        "restitution" not in sheets[0] or not {"R1", "R2"}.intersection(sheets[0]),
        "one R of each wall",
    )
    need(kind != "all" or data["symmetric"] is False, "all motions, symmetric or not")
    for one in sheets if kind == "all" else ():
        need(set(one) == {"sides", "cycles"} and isinstance(one["sides"], str), "one word a sheet")
        need(type(one["cycles"]) is int and one["cycles"] > 0, "a number of cycles")
    for box in boxes:
        check_box_form(box, kind, len(sheets))
    if kind == "zone":
        need(exact(system["load"]) == 1, "clearances d K/F0, for the load 1")
        low, high = map(exact, system["clearance"])
        need(0 < low < high, "a window of clearances")
    elif kind != "all":
        check_start(system, sheets, data["sides"])
    check_undecided(data)


def check_box_form(box, kind, sheets):
    """As `check_form`, for a box."""
    need(isinstance(box, dict), "a box is an object")
    solved = box.get("exists") is True and kind != "zone"
    items = {"sheet", "parameters", *VERDICTS, *(("centre", "radius") if solved else ())}
    # lengths in zones have other units
    need(items <= set(box) <= items | set(BOUNDS if kind != "zone" else ()), "the items of a box")
    need(type(box["sheet"]) is int and 0 <= box["sheet"] < sheets, "the number of a sheet")
    if solved:
        centre, radius, rows = box["centre"], box["radius"], flat(box["centre"])
        lists = [centre, *centre, *rows, radius, *radius]
        need(all(isinstance(one, list) for one in lists), "lists of numbers")
        need(all(isinstance(one, str) for one in flat([*rows, *radius])), "texts of numbers")
    need(all(box[name] in (None, True, False) for name in VERDICTS), "true, false or null")
    need(all(type(box[name]) is not int for name in VERDICTS), "verdicts are true, false or null")
    need(box["exists"] is not False or kind == "zone", "a motion exists or is not decided")
    below, above, largest = (box.get(name) for name in BOUNDS)
    need(below is None or (box["stable"] is True and 0 < exact(below) <= 1), "a bound below 1")
    need(above is None or (box["stable"] is False and exact(above) >= 1), "a bound above 1")
    need(largest is None or (box["admissible"] is True and exact(largest) > 0), "a bound of |x|")
    if box["exists"] is not True:
        others = [box.get(name) for name in (*VERDICTS[1:], *BOUNDS)]
        need(all(one is None for one in others), "no verdict on what is not proven to exist")


def check_start(system, sheets, sides):
    """Whether the value of the varying parameter is one of those that a certificate covers."""
    for name in {name for sheet in sheets for name in sheet}:
        key, _, number = name.partition("_")
        if name in ("R1", "R2", "restitution") and "mass" not in system:
            walls = zip(sides, system["restitution"], strict=True)
            texts = [text for side, text in walls if name != {"R": "R2", "L": "R1"}[side]]
        elif key in GAP:
            texts = [gap[key] for k, gap in enumerate(system["gaps"]) if number in ("", str(k))]
        else:
            # factors of the load and the constant force are 1 at the start
            texts = [system[name]] if name in (*PAIR, "frequency") and name in system else ["1"]
        spans = [tuple(map(exact, sheet[name])) for sheet in sheets]
        low, high = min(one for one, _ in spans), max(one for _, one in spans)
        need(all(low <= exact(text) <= high for text in texts), f"{name} at the start")


def is_open(box, kind):
    """Whether a box leaves something open."""
    if box["exists"] is False or (kind == "zone" and False in (box["stable"], box["admissible"])):
        return False
    return any(box[name] is None for name in VERDICTS)


def check_undecided(data):
    """Check that what is not decided follows from the boxes, in their order, and that reasons are words."""
    items, kind, sheets = data["undecided"], data["kind"], data["sheets"]
    need(
        all(isinstance(one, dict) and isinstance(one.get("reason"), str) for one in items),
        "reasons",
    )
    need(all(one["reason"] for one in items), "reasons")
    names = {"all": [set(), {"sheet", "times"}], "motion": [set()], "zone": [set()]}
    allowed = names.get(kind, [{"parameters"}])
    need(all(set(one) - {"reason"} in allowed for one in items), "the items of what is not decided")
    waiting = [box["parameters"] for box in data["boxes"] if is_open(box, kind)]
    if kind == "zone":
        need(bool(items) == bool(waiting), "reasons of what is not decided")
        return
    if kind == "all":
        timed = [one for one in items if "times" in one]
        need(len(items) - len(timed) == len(waiting), "a reason of each verdict that is open")
        for one in timed:
            need(
                type(one["sheet"]) is int and 0 <= one["sheet"] < len(sheets), "the sheet of times"
            )
            need(
                len(one["times"]) == len(sheets[one["sheet"]]["sides"]) - 1, "times of all flights"
            )
            need(all(exact(low) < exact(high) for low, high in one["times"]), "intervals of times")
        return
    if not data["boxes"]:
        waiting = sheets
    ends = lambda span: {name: tuple(map(exact, two)) for name, two in span.items()}  # noqa: E731
    waiting = [ends(one) for one in waiting][::-1]
    for one in items:
        wanted = ends(one.get("parameters", {}))
        need(waiting, "more is not decided than the boxes leave open")
        found = waiting.pop()
        # neighbours along one parameter may be reported as one
        while found != wanted:
            need(
                len(found) == 1 and waiting and set(waiting[-1]) == set(found),
                "what is not decided",
            )
            ((name, (low, high)),) = found.items()
            after, end = waiting.pop()[name]
            need(after == high, "what is not decided")
            found = {name: (low, end)}
    need(not waiting, "a box leaves more open than is said")


def proves(data):
    """Whether a certificate proves anything."""
    known = any(box["exists"] is not None for box in data["boxes"])
    return known or (data["kind"] == "all" and not any("times" in one for one in data["undecided"]))
