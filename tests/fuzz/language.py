"""Mutate namelists: their groups, keys, values and bytes."""

import math
import re
from itertools import accumulate
from pathlib import Path

SEEDS = Path(__file__).with_name("seeds")

#: Milliseconds that texts of a seed take on average in a build with sanitizers, where that is many: the seed is
#: chosen so much less often.
COSTS = {
    "record_short_steps": 10, "structure_basins": 4, "structure_record": 5, "structure_response": 5,
    "structure_settled": 20, "structure_simulate": 5,
}  # fmt: skip
#: Texts that replace a value.
VALUES = [
    "0", "-0", "-0.0", "1", "-1", "2", "3", "0.5", "1.5", "1e-300", "4.9e-324", "2.2250738585072014e-308",
    "1e308",
    "1.7976931348623157e308", "1e309", "1d400", "-1d400", "1e-400", "nan", "NaN(1)", "inf", "-Infinity", "+inf",
    "0x10", "z'ff'", "1.0_8", "1,5", "1e", "1e+", "e5", ".", "-.", "1.", ".1", "1..2", "1-2", "1+2", "1d2.5",
    "1 2 3",
    "2147483647", "2147483648", "-2147483648", "4294967296", "9223372036854775808", "99999999999999999999999",
    "3*1",
    "3*", "0*1", "-1*1", "99999999999*1", "2*2*2", "*", "3*'a'", "1000001*0", "100000*1", ".true.", "T",
    "(1,2)", "''",
    "' '", '""', "'", '"', "'a", "'RL'", "'RRL'", "'R*L'", "'RL*'", "'" + "R" * 1001 + "'", "'" + "RL" * 12 + "'",
    "'R''L'", "'../x'", "'/dev/null'", "'/dev/stdin'", "'/'", "'.'", "'no/file.mtx'", "'\u00e4'", "1" * 400,
    "0." + "3" * 400, "1e99999999999999999999", ",", ",,", "", "1,,2", "1, 2, 3, 4, 5", "!", "/", "&", "$",
    "1 /", "@",
    "'mass.mtx'", "'stiffness.npy'", "'record.csv'", "1e-12", "1e12", "1e6", "1e-6", "1e-13", "1.0000001e12",
    "0.9999999999999999", "1.0000000000000002",
]  # fmt: skip
#: Keys that determine how much is computed.
AMOUNTS = {
    "batches", "clearance_points", "cycles", "discard", "duration", "guesses", "keep", "lines", "max_cycles",
    "max_events", "max_impacts", "max_points", "points", "probes", "r_points", "releases", "samples", "seeds",
    "settling", "states", "survey", "values",
}  # fmt: skip
#: Bytes that are inserted anywhere.
PIECES = [
    b"&", b"/", b"'", b'"', b"!", b"=", b",", b";", b"(", b")", b"*", b"%", b":", b"\n", b"\r", b"\r\n", b"\t",
    b"\0",
    b"\x1b", b"\xff", b"\xc3", b"\xe2\x80\xa8", b"\xc2\xa0", b"\xef\xbb\xbf", b"#", b"nan", b"inf", b"-",
    b"1e999",
    b"99999999999", b"&end", b"$", b"?", b"=?", b"(1)", b"(0)", b"(1001)", b"(1:2)", b"(::-1)", b"(:)", b"(1,1)",
    b"(2147483648)", b"phases", b"name='../x'", b"3*", b"0*1", b"-1*1", b".true.", b" " * 300, b"R" * 1200,
    b"\n" * 300, b"a" * 5000, b"&motion", b"&system", b"&output", b"&structure", b"&gap", b"&load", b"&sweep",
]  # fmt: skip
SUBSCRIPTS = [
    "(1)",
    "(2)",
    "(0)",
    "(-1)",
    "(1:2)",
    "(2:3)",
    "(1001)",
    "(2147483648)",
    "(1",
    "(:)",
    "(1,1)",
    "( 2 )",
]


def parse(text):
    """Groups with their keys and values, read from a namelist with one key per line."""
    groups = []
    for line in text.split("\n"):
        if line.startswith("&"):
            groups.append((line[1:].strip(), []))
        elif "=" in line and groups:
            key, _, value = line.partition("=")
            groups[-1][1].append((key.strip(), value.strip()))
    return groups


def write(groups):
    """The namelist with these groups."""
    lines = []
    for name, items in groups:
        lines += [f"&{name}", *(f"  {key} = {value}" for key, value in items), "/"]
    return "\n".join([*lines, ""])


class Language:
    """The seed namelists, and the program's description of its groups and keys."""

    def __init__(self, described):
        paths = sorted(SEEDS.glob("*.nml"))
        self.seeds = [path.read_bytes() for path in paths]
        self.weights = list(accumulate(1 / COSTS.get(path.stem, 1) for path in paths))
        self.parsed = [parse(seed.decode(errors="replace")) for seed in self.seeds]
        self.groups = described["groups"]
        self.names = [*self.groups]

    def choose(self, rng):
        """Choose the index of a seed."""
        return rng.choices(range(len(self.seeds)), cum_weights=self.weights)[0]

    def keys(self, group, groups):
        """The table of keys of a group in a case."""
        model = "structure" if any(name == "structure" for name, _ in groups) else "oscillator"
        return [key for key in self.groups.get(group, []) if key["model"] in ("", model)]

    def value(self, rng, key):
        """A plausible value of a key: at a bound, near one, or one of its words."""
        choice = rng.random()
        if choice < 0.3:
            return rng.choice(VALUES)
        if key["kind"] == "word":
            words = key["words"].split() or ["x", "RL", "q_0", "opening", "stiffness 0 0", "case"]
            return ", ".join(repr(rng.choice(words)) for _ in range(rng.choice((1, 1, 1, 2, 3))))
        return ", ".join(self.number(rng, key) for _ in range(rng.choice((1, 1, 1, 1, 2, 3, 4))))

    @staticmethod
    def number(rng, key):
        """A number at or near a bound of a key, or any number."""
        low, high = key.get("low"), key.get("high")
        if high is not None and 100 < high and key["name"] in AMOUNTS and rng.random() < 0.9:
            high = None  # keep the case small
        bound = rng.choice([bound for bound in (low, high, 0.0, 1.0) if bound is not None])
        if key["kind"] == "whole":
            return str(int(bound) + rng.choice((-1, 0, 0, 1, 2)))
        x = rng.choice(
            (
                bound, math.nextafter(bound, math.inf), math.nextafter(bound, -math.inf), 2 * bound,
                -bound, rng.uniform(-1, 1), 10 ** rng.uniform(-3, 3), 10 ** rng.uniform(-320, 308),
            )
        )  # fmt: skip
        return rng.choice((repr, repr, "{:.17e}".format, "{:.3g}".format, "{:+.15G}".format))(x)

    def mutate(self, rng, groups):
        """Change groups, keys and values in place."""
        for _ in range(rng.choice((1, 1, 1, 2, 2, 4))):
            if not groups:
                return
            at = rng.randrange(len(groups))
            name, items = groups[at]
            kind = rng.random()
            table = self.keys(name, groups)
            place = rng.randrange(len(items)) if items else 0
            if kind < 0.4 and items:
                key = items[place][0]
                about = next((k for k in table if k["name"] == key), None)
                new = self.value(rng, about) if about else rng.choice(VALUES)
                items[place] = (key, new)
            elif kind < 0.62 and table:
                about = rng.choice(table)
                items.insert(place, (about["name"], self.value(rng, about)))
            elif kind < 0.66:
                about = rng.choice(self.groups[rng.choice([*self.groups])])
                items.insert(place, (about["name"], self.value(rng, about)))
            elif kind < 0.72 and items:
                del items[place]
            elif kind < 0.76 and items:
                items.insert(rng.randrange(len(items) + 1), items[place])
            elif kind < 0.80 and items:
                key, value = items[place]
                items[place] = (key + rng.choice(SUBSCRIPTS), value)
            elif kind < 0.84 and items:
                key, value = items[place]
                items[place] = (key, ", ".join([value] * rng.choice((2, 3, 20))))
            elif kind < 0.87:
                del groups[at]
            elif kind < 0.90:
                groups.insert(rng.randrange(len(groups) + 1), (name, list(items)))
            elif kind < 0.92:
                rng.shuffle(groups)
            elif kind < 0.95:
                groups.insert(at, (rng.choice(self.names), []))
            elif kind < 0.98:
                other = rng.choice(rng.choice(self.parsed))
                groups.insert(at, (other[0], list(other[1])))
            else:
                groups[at] = (rng.choice(self.names), items)

    @staticmethod
    def damage(rng, text):
        """Change bytes."""
        text = bytearray(text)
        for _ in range(rng.choice((1, 1, 2, 4))):
            at = rng.randrange(len(text) + 1)
            kind = rng.randrange(5)
            if kind == 0:
                text[at : at + 1] = bytes([rng.randrange(256)])
            elif kind == 1:
                del text[at : at + rng.choice((1, 1, 2, 8, 40))]
            elif kind == 2:
                text[at:at] = rng.choice(PIECES)
            elif kind == 3:
                text[at : at + rng.randrange(1, 5)] = rng.choice(PIECES)
            else:
                text[at:at] = text[rng.randrange(len(text) + 1) :][: rng.choice((1, 10, 100))]
        return bytes(text)

    @staticmethod
    def restyle(rng, text):
        """The same case with other blanks, comments, line ends and upper-case names."""
        style = rng.randrange(6)
        if style == 0:
            return text.replace("\n", "\r\n")
        if style == 1:
            return re.sub(r"(?m)^(  \w+ =|&\w+)", lambda m: m.group().upper(), text)
        if style == 2:
            return text.replace("\n", " ! x = 'y' /\n")
        if style == 3:
            return text.replace(" = ", "\t=   ")
        if style == 4:
            return "".join(f"#{line}\n" for line in text.split("\n"))
        return "! before\n\n" + re.sub(r"(?m)^/$", "&end", text) + "\n! after"

    def make(self, rng):
        """One mutated text."""
        at = self.choose(rng)
        kind = rng.random()
        if kind < 0.2:
            return self.damage(rng, self.seeds[at])
        groups = [(name, list(items)) for name, items in self.parsed[at]]
        self.mutate(rng, groups)
        text = write(groups).encode("utf-8", "replace")
        return text if kind < 0.9 else self.damage(rng, text)

    def pair(self, rng):
        """Two texts of one case, well-formed except for its values."""
        groups = [(name, list(items)) for name, items in self.parsed[self.choose(rng)]]
        name, items = rng.choice(groups)
        if items:
            place = rng.randrange(len(items))
            about = next((k for k in self.keys(name, groups) if k["name"] == items[place][0]), None)
            if about and about["kind"] != "word":
                items[place] = (items[place][0], self.number(rng, about))
        text = write(groups)
        return text.encode(), self.restyle(rng, text).encode()

    def breaches(self, case):
        """Numbers of a complete case outside the ranges of their keys."""
        groups = parse(case)
        for name, items in groups:
            table = {key["name"]: key for key in self.keys(name, groups)}
            for key, value in items:
                about = table.get(key)
                if about is None:
                    yield f"&{name} {key} is not a key"
                elif about["kind"] != "word":
                    numbers = re.sub(r"(\d+)\*", "", value).split(",")
                    for number in map(float, numbers):
                        low = -math.inf if about["low"] is None else about["low"]
                        high = math.inf if about["high"] is None else about["high"]
                        good = low <= number <= high and math.isfinite(number)
                        good &= not (about["above"] and number == low)
                        good &= not (about["below"] and number == high)
                        if not good:
                            yield f"&{name} {key} = {number}"
