"""Variants of the text of a case: the same numbers, some of them multiplied by a factor."""

import re

ITEM = re.compile(
    r"&(?P<group>\w+)|(?<![\w'])(?P<key>[a-z_0-9]+)(?P<sign>(?:\([^)]*\))?\s*=\s*)(?P<value>[^=/&!']*?)"
    r"(?=\s*,?\s*[a-z_0-9]+(?:\([^)]*\))?\s*=|\s*[/&!]|\s*\Z)", re.S
)  # fmt: skip
NUMBER = re.compile(r"(\d+\*)?([-+]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d+)?)")


def multiplied(text, factor_of):
    """A case with the numbers of each key multiplied by `factor_of(group, key)`, unless that is 1."""
    group = ""

    def changed(item):
        nonlocal group
        group = item["group"] or group
        factor = factor_of(group, item["key"]) if item["key"] else 1
        if factor == 1:
            return item[0]
        new = NUMBER.sub(
            lambda n: (n[1] or "") + repr(float(n[2].lower().replace("d", "e")) * factor),
            item["value"],
        )
        return item["key"] + item["sign"] + new

    return ITEM.sub(changed, text)
