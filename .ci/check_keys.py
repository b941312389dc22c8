"""Write the tables of keys in inputs/README.md from what the core declares, or compare them.

usage: check_keys.py [--write]
"""

import re
import sys
from pathlib import Path

from vibroimpact.commands.options import takes
from vibroimpact.results.tables import MODELS, keys_for, language

PLACE = Path(__file__).parents[1] / "inputs" / "README.md"
BEGIN = "<!-- The tables of keys are written by .ci/check_keys.py --write. -->\n"
END = "<!-- The end of the tables of keys. -->\n"


def condition(text):
    """'key' or 'key=word' as it would stand in a file."""
    name, _, word = text.partition("=")
    return f"`{name} = '{word}'`" if word else f"`{name}`"


def missing(key):
    """What is taken if a key is left out."""
    if key["default"]:
        return f"`{key['default']}`"
    if key["may_miss"]:
        return "none"
    unless = " or ".join(map(condition, [*key["never"].split(), *filter(None, [key["or"]])]))
    return "error" + (f", unless {unless} is given" if unless else "")


def row(key):
    """Name, meaning with what it takes, and what is taken if it is left out."""
    about = "; ".join(takes(key)).replace("<=", "≤")
    text = key["meaning"] + (f" ({about})" if about else "")
    text = re.sub(r"([*|])", r"\\\1", text)
    if key["only"]:
        text = f"with {condition(key['only'])}: {text}"
    return f"| `{key['name']}` | {text} | {missing(key)} |"


def tables():
    """One table for each group."""
    lines = []
    for group in language()["groups"]:
        about = language()["results"].get(group, {"rows": MODELS[:1]})
        for model in about["rows"]:
            of_structure = model == MODELS[True]
            title = f"### `&{group}`" + " of a `&structure`" * of_structure
            lines += [title, "", "| key | what it is | if it is missing |", "|---|---|---|"]
            lines += [*map(row, keys_for(group, of_structure)), ""]
    return "\n".join(lines)


text = PLACE.read_text(encoding="utf-8")
before, _, rest = text.partition(BEGIN)
new = f"{before}{BEGIN}\n{tables()}\n{END}{rest.partition(END)[2]}"
if "--write" in sys.argv:
    PLACE.write_text(new, encoding="utf-8")
elif new != text:
    sys.exit("inputs/README.md differs from the tables of keys: python .ci/check_keys.py --write")
