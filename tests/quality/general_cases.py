"""Draws random cases with general parameters, so that no symmetry and no parameter of 0 or 1 hides a fault.

usage: general_cases.py SEED N >TEXTS

Prints N namelists as a JSON list, which `find_answers.py --renew --add TEXTS` keeps. Each case is small: a small
window, few points, a short simulation.
"""

import json
import math
import random
import sys

#: Patterns of zones and charts.
PATTERNS = (
    "RL",
    "RRL",
    "RLL",
    "RRLL",
    "RLRL",
    "RRRL",
    "RRLRL",
    "RL*",
    "R*L*",
    "RRL*",
    "R*RL",
    "RLLL",
    "RRLLRL",
)
#: Parameters of branches and bifurcations of structures, and of both axes of zones.
PARAMETERS = (
    "frequency", "opening", "load", "restitution", "damping", "stiffness",
    "opening_0", "restitution_0", "stiffness_0_0", "damping_0_0", "mass_0_0",
)  # fmt: skip


class Draw(random.Random):
    """Random numbers, as namelists write them."""

    def numbers(self, n, low, high):
        """A list of n random numbers."""
        return [self.uniform(low, high) for _ in range(n)]

    def matrix(self, n, low, high, off):
        """A symmetric matrix with a range for its diagonal, and one for the rest."""
        rows = [[0.0] * n for _ in range(n)]
        for i in range(n):
            rows[i][i] = self.uniform(low, high)
            for j in range(i):
                rows[i][j] = rows[j][i] = self.uniform(-off, off) / max(1, n - 1)
        return rows

    def restitution(self):
        """A number from 0 to 1, sometimes 0 or 1 itself."""
        return self.choice([0, 1, 0.2, 0.75]) if self.random() < 0.2 else self.uniform(0.1, 0.95)


def text_of(values):
    """Numbers as a list with four digits each."""
    return ", ".join(f"{value:.4g}" for value in values)


def group(name, **keys):
    """A group of a namelist: words are quoted, lists are written with commas."""
    words = {
        key: f"'{value}'"
        if isinstance(value, str)
        else text_of(value if isinstance(value, list) else [value])
        for key, value in keys.items()
    }
    return f"&{name} " + ", ".join(f"{key} = {word}" for key, word in words.items()) + " /\n"


def bodies(draw):
    """M, K and C of a structure, and the directions of its gaps."""
    kind = draw.choice(["one", "one", "pair", "damper", "apart", "mirror", "chain", "chain"])
    if kind == "one":
        walls = [[1.0]] if draw.random() < 0.5 else [[1.0], [-1.0]]
        return (
            [[draw.uniform(0.5, 2)]],
            [[draw.uniform(0.5, 3)]],
            [[draw.choice([0, 0.02, 0.1, 0.3])]],
            walls,
        )
    if kind in ("pair", "damper"):
        # a free mass in the cavity of the other, without or with a dashpot
        drag = draw.uniform(0, 0.1) if kind == "damper" else 0.0
        damping = [[draw.choice([0.0, 0.02, 0.1]) + drag, -drag], [-drag, drag]]
        return [[1, 0], [0, draw.uniform(0.02, 0.4)]], [[1, 0], [0, 0]], damping, [[-1, 1], [1, -1]]
    if kind == "apart":
        stiffness = [[draw.uniform(0.5, 2), 0], [0, draw.uniform(0.5, 2)]]
        damping = [[draw.uniform(0, 0.2), 0], [0, draw.uniform(0, 0.2)]]
        walls = [[1, 0], [0, 1]] if draw.random() < 0.5 else [[1, -1], [-1, 1]]
        return [[1, 0], [0, draw.uniform(0.3, 1)]], stiffness, damping, walls
    if kind == "mirror":
        k, c = draw.uniform(0.1, 0.6), draw.uniform(0.02, 0.1)
        return [[1, 0], [0, 1]], [[1 + k, -k], [-k, 1 + k]], [[c, 0], [0, c]], [[1, 0], [0, 1]]
    n = draw.choice([2, 3])
    walls = [
        draw.numbers(n, -1, 1)
        if draw.random() < 0.5
        else draw.sample([draw.choice([1.0, -1.0]), *[0.0] * (n - 1)], n)
        for _ in range(draw.randint(1, 3))
    ]
    mass = draw.matrix(n, 0.6, 1.6, draw.choice([0, 0.2]))
    return mass, draw.matrix(n, 0.6, 1.6, 0.5), draw.matrix(n, 0.09, 0.24, 0.03), walls


def law(draw):
    """The restitution of a gap: a constant, a power law or a table."""
    kind = draw.choice(["constant", "constant", "constant", "power", "table"])
    if kind == "constant":
        return {"restitution": draw.restitution()}
    if kind == "power":
        return {
            "law": kind, "restitution": draw.uniform(0.4, 0.9), "law_speed": draw.uniform(0.2, 1),
            "law_exponent": draw.uniform(0.05, 0.3),
        }  # fmt: skip
    speeds = [0, draw.uniform(0.1, 0.4), draw.uniform(0.5, 1), draw.uniform(1.2, 3)]
    return {
        "law": kind,
        "law_speeds": speeds,
        "law_values": sorted(draw.numbers(4, 0.3, 0.95), reverse=True),
    }


def structure(draw):
    """A case of a structure."""
    mass, stiffness, damping, walls = bodies(draw)
    n = len(mass)
    flat = {"mass": mass, "damping": damping, "stiffness": stiffness}
    text = group(
        "structure", **{name: [x for row in rows for x in row] for name, rows in flat.items()}
    )
    opening = draw.uniform(0.02, 1.2) if draw.random() < 0.6 else None
    same = law(draw) if draw.random() < 0.5 else None
    for wall in walls:
        text += group(
            "gap", direction=wall, opening=opening or draw.uniform(0.02, 1.2), **(same or law(draw))
        )
    frequency, load = draw.uniform(0.3, 2.5), {"cosine": draw.numbers(n, -1, 1)}
    more = draw.choice(["", "sine", "constant", "harmonic"])
    if more in ("sine", "constant"):
        load[more] = draw.numbers(n, -0.3, 0.3)
    if more == "harmonic":
        load["cosine"] += draw.numbers(n, -0.3, 0.3)
    text += group("load", frequency=frequency, **load)

    near = {
        "frequency": frequency, "opening": opening or 0.5, "opening_0": opening or 0.5, "restitution": 0.6,
        "restitution_0": 0.6, "stiffness_0_0": stiffness[0][0], "damping_0_0": max(damping[0][0], 0.01),
        "mass_0_0": mass[0][0],
    }  # fmt: skip

    def window(parameter):
        middle, share = near.get(parameter, 1), draw.uniform(0.05, 0.4)
        most = 1 if "restitution" in parameter else math.inf
        return middle * (1 - share), min(most, middle * (1 + share))

    parameter, other = draw.sample(PARAMETERS[:6], 2)
    low, high = window(parameter)
    settled = group(
        "motion",
        kind="settled",
        settling=draw.choice([60, 150, 300]),
        max_cycles=draw.randint(1, 6),
    )
    few = {
        "values": draw.randint(2, 4),
        "settling": draw.choice([10, 40]),
        "keep": draw.randint(3, 8),
    }
    study = draw.choice(
        [
            "simulate",
            "motion",
            "branch",
            "branch",
            "lyapunov",
            "response",
            "bifurcation",
            "basins",
            "find",
            "zone",
        ]
    )
    if study == "simulate":
        return text + group(study, cycles=draw.randint(2, 12), q_dot=draw.numbers(n, -1, 1))
    if study == "motion":
        return text + settled
    if study == "branch":
        one = draw.choice(PARAMETERS)
        first, last = window(one)
        return text + settled + group(study, parameter=one, low=first, high=last, longest_step=0.1)
    if study == "zone":
        y_low, y_high = window(other)
        return text + settled + group(
            study, x=parameter, x_low=low, x_high=high, y=other, y_low=y_low, y_high=y_high, lines=5
        )  # fmt: skip
    if study == "lyapunov":
        batches = draw.randint(2, 4)
        return text + group(
            study, cycles=draw.randint(2 * batches, 40), discard=draw.randint(0, 20), batches=batches,
            directions=draw.randint(1, 2 * n),
        )  # fmt: skip
    if study == "response":
        return text + group(study, low=0.8 * frequency, high=1.2 * frequency, **few)
    if study == "bifurcation":
        return text + group(study, parameter=parameter, low=low, high=high, **few)
    if study == "basins":
        axes = f"&basins axes = 'q_0', 'q_dot_{n - 1}', "
        rest = group("basins", low=[-(opening or 0.5), -1], high=[0.9 * (opening or 0.5), 1],
                     values=[draw.randint(2, 4), draw.randint(2, 4)], settling=draw.choice([20, 60]))  # fmt: skip
        return text + rest.replace("&basins ", axes)
    return text + group(
        study, max_impacts=draw.randint(2, 4), max_cycles=draw.randint(1, 2), guesses=draw.randint(2, 8),
        states=draw.randint(2, 6), settling=100,
    )  # fmt: skip


def oscillator(draw):
    """A case of an oscillator with a free mass."""
    xi = (
        draw.choice([0, 0.005, 0.0114, 0.05, 0.2, 0.5])
        if draw.random() < 0.5
        else draw.uniform(0.003, 0.3)
    )
    mu, first = draw.uniform(0.02, 0.6), draw.restitution()
    second = first if draw.random() < 0.5 else draw.restitution()
    r, clearance = draw.uniform(0.25, 1.6), math.exp(draw.uniform(-1.5, 3.6))
    system = {"xi": xi, "mu": mu, "restitution": [first, second][: 1 + (first != second)]}
    share = draw.uniform(0.02, 0.2)
    window = {
        "r_min": r * (1 - share), "r_max": r * (1 + share),
        "clearance_min": clearance * (1 - 2 * share), "clearance_max": clearance * (1 + 2 * share),
    }  # fmt: skip
    at = group("system", **system, r=r)
    study = draw.choice(
        ["zone", "zone", "atlas", "atlas", "chart", "find", "branch", "basins", "lyapunov", "bifurcation",
         "response", "simulate", "decay"]
    )  # fmt: skip
    if study == "zone":
        words = {"sides": draw.choice(PATTERNS), "cycles": draw.choice([1, 1, 1, 2])}
        return group("system", **system) + group(study, **words, **window, lines=5)
    if study == "atlas":
        return group("system", **system) + group(
            study, **window, survey=draw.randint(6, 24), lines=5, settling=draw.choice([60, 150]),
            guesses=draw.choice([0, 4, 8]),
        )  # fmt: skip
    if study == "chart":
        few = {"r_points": draw.randint(2, 5), "clearance_points": draw.randint(2, 5)}
        return group("system", **system) + group(
            study, sides=draw.choice(PATTERNS[:6]), **window, **few
        )
    if study == "response":
        return group("system", **system) + group(
            study, r_min=window["r_min"], r_max=window["r_max"], r_points=draw.randint(2, 4),
            clearance=clearance, states=draw.randint(2, 4), settling=50, keep=10,
        )  # fmt: skip
    if study == "decay":
        return group("system", **system) + group(
            study, clearance=clearance, cycles=draw.randint(4, 20)
        )
    if study == "branch":
        pair = {"sides": "RL", "phases_over_pi": [0, draw.uniform(0.8, 1.2)]}
        three = {
            "sides": "RRL",
            "phases_over_pi": [0, draw.uniform(0.2, 0.8), draw.uniform(0.9, 1.4)],
        }
        guess = draw.choice([pair, three])
        motion = {"kind": "equispaced"} if first == second else {"kind": "exact"} | guess
        values = {
            "clearance": clearance,
            "r": r,
            "xi": max(xi, 0.01),
            "mu": mu,
            "R1": first,
            "R2": second,
        }
        parameter = draw.choice([*values])
        wide, most = draw.uniform(0.1, 0.6), 1 if parameter[0] == "R" else math.inf
        value = values[parameter]
        bounds = {"low": value * (1 - wide), "high": min(most, value * (1 + wide))}
        return (
            at
            + group("motion", **motion, clearance=clearance)
            + group(study, parameter=parameter, **bounds)
        )
    if study == "find":
        return at + group(
            study, clearance=clearance, max_impacts=draw.randint(2, 4), max_cycles=draw.randint(1, 2),
            guesses=draw.randint(4, 20), states=draw.randint(2, 8),
        )  # fmt: skip
    if study == "basins":
        return at + group(
            study, clearance=clearance, states=draw.randint(4, 10), seed=draw.randint(1, 9),
            cycles=draw.choice([40, 80]),
        )  # fmt: skip
    if study == "lyapunov":
        batches = draw.randint(2, 4)
        return at + group(
            study, clearance=clearance, cycles=draw.randint(2 * batches, 60), discard=draw.randint(0, 20),
            batches=batches,
        )  # fmt: skip
    if study == "bifurcation":
        return at + group(
            study, parameter="clearance", low=window["clearance_min"], high=window["clearance_max"],
            values=draw.randint(2, 5), settling=50, keep=draw.randint(3, 10),
        )  # fmt: skip
    return at + group(
        study, clearance=clearance, cycles=draw.randint(2, 10), z_dot=draw.uniform(-2, 2)
    )


def main():
    """Print the cases."""
    draw = Draw(int(sys.argv[1]))
    print(
        json.dumps(
            [
                (structure if draw.random() < 0.6 else oscillator)(draw)
                for _ in range(int(sys.argv[2]))
            ]
        )
    )


if __name__ == "__main__":
    main()
