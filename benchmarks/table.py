"""Rows of measurements: printed as text, or written as a page for the documentation.

A row is a dictionary: `work`, `ours`, `peer` and `peer_name` (None without one), `unit` (more is better if it ends
with "/s" or "times"), `target` (None without one), `same_answer` (whether both sides gave the same answer; None
without a peer).
"""

HEADER = ("work", "unit", "vibroimpact", "peer", "which", "ratio", "target", "same answer")


def row(work, unit, ours, target=None, peer=None, peer_name="", same_answer=None):
    """One row."""
    return {
        "work": work, "unit": unit, "ours": ours, "target": target, "peer": peer, "peer_name": peer_name,
        "same_answer": same_answer,
    }  # fmt: skip


def digits(number):
    """Three significant digits, without a power of ten if the number has at most five digits."""
    return f"{number:.0f}" if 1000 <= number < 1e5 else f"{number:.3g}"


def more_is_better(item):
    """Whether a row measures a rate, of which more is better, and not a cost."""
    return item["unit"].endswith(("/s", "times", "found"))


def cells(item):
    """A row as texts."""
    peer, ratio = "", ""
    if item["peer"] is not None:
        peer = digits(item["peer"])
    if item["peer"]:
        better = item["ours"] / item["peer"]
        ratio = digits(better if more_is_better(item) else 1 / better)
    target = ""
    if item["target"] is not None:
        met = (
            item["ours"] >= item["target"]
            if more_is_better(item)
            else item["ours"] <= item["target"]
        )
        target = f"{item['target']:.3g} {'met' if met else 'not met'}"
    same = {True: "yes", False: "NO", None: ""}[item["same_answer"]]
    return (
        item["work"], item["unit"], digits(item["ours"]), peer, item["peer_name"] or "", ratio, target, same,
    )  # fmt: skip


def show(rows):
    """Print rows as a table of text; False if an answer was not the same."""
    lines = [HEADER, *map(cells, rows)]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    for line in lines:
        print(
            "  ".join(f"{text:<{width}}" for text, width in zip(line, widths, strict=True)).rstrip()
        )
    return all(item["same_answer"] is not False for item in rows)


def markdown(rows):
    """The table in Markdown."""
    lines = [HEADER, ("---",) * len(HEADER), *map(cells, rows)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)
