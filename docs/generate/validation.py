"""The tables of docs/validation.md: published numbers beside those of the package.

usage: python -m generate.validation, in the folder docs, writes them; a test fails if the page is out of date.
"""

import cmath
import csv
import math
import re
import sys

import numpy as np
import vibroimpact as vi

from .shared import ROOT

sys.path.insert(0, str(ROOT / "tests" / "python"))
from shared_published import CYCLES, DRAG, RESTITUTION, balance, phase_of_speed, published, zero

PAGE = ROOT / "docs" / "validation.md"
#: A table of the page, between comments.
TABLE = re.compile(r"(<!-- table (\w+), [^>]*-->\n).*?(\n<!-- end -->)", re.DOTALL)
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def bound(x, least=1e-13):
    """A difference, rounded up to one digit, which hardly depends on the last bits."""
    if x < least:
        return "below 10⁻¹³"
    power = math.floor(math.log10(x))
    digit = math.ceil(x / 10.0**power - 1e-3)
    power, digit = (power + 1, 1) if digit == 10 else (power, digit)
    times = "" if digit == 1 else f"{digit}·"
    return f"below {times}10{str(power).translate(SUPERSCRIPTS)}"


def row(name, text, value):
    """A quantity: the printed digits, the computed value with as many decimals, and their difference."""
    decimals = len(text.partition(".")[2])
    shown = f"{value:.{decimals}f}".replace("-", "−")
    return f"| {name} | {text.replace('-', '−')} | {shown} | {bound(abs(value - float(text)))} |"


def one_wall():
    """The oscillator with one wall in example 15.2 of the book."""
    wall = vi.Structure([1], [0.1], [1], [vi.Gap([1], 1, 0.8)])
    motion = vi.exact(wall, vi.Load(1.0, cosine=[1]), ([0.1], [0]))
    leading = motion.multipliers[0]
    return [
        "| quantity | reference | here | difference |",
        "|---|---|---|---|",
        row("load phase of the impact (rad)", "0.07595216493831", float(motion.phases[0])),
        row("approach speed", "1.69573294", float(motion.speeds[0])),
        row("multipliers, real part", "-0.58429531", leading.real),
        row("multipliers, imaginary part ±", "0.00560035", abs(leading.imag)),
        row("det [P]", "0.34143237829831", motion.determinant),
    ]


def stop():
    """The one-wall oscillator of the published bifurcations."""
    return vi.Structure([1], [DRAG], [1], [vi.Gap([1], 1, RESTITUTION)])


def presumed(wall, phase, omega):
    """The motion with its impact at a load phase, and its load amplitude."""
    load = float(balance(phase, omega)[0])
    return vi.periodic(wall, vi.Load(omega, cosine=[load]), [phase], [0], CYCLES), load


def critical(wall, side, omega, begin):
    """The load amplitude at which a multiplier is -1 or 1, and the residual there."""

    def test(phase):
        matrix = presumed(wall, phase, omega)[0].matrix
        # det([P] - side I) for two coordinates
        return float(1 - side * np.trace(matrix) + np.linalg.det(matrix))

    motion, load = presumed(wall, zero(test, begin), omega)
    return load, motion.residual


def bifurcations():
    """All published bifurcations of the one-wall oscillator."""
    wall = stop()
    counts = {"flip": 0, "fold": 0}
    names = ("F", "speed", "multiplier", "critical", "residual")
    largest = {kind: dict.fromkeys(names, 0.0) for kind in counts}
    for kind, omega, load, speed, multiplier in published():
        if speed < 0:
            continue
        counts[kind] += 1
        phase = phase_of_speed(omega, load, speed)
        if kind == "flip":
            motion = vi.exact(wall, vi.Load(omega, cosine=[load]), ([phase], [0], CYCLES))
            here = load
        else:
            motion, here = presumed(wall, phase, omega)
        top, residual = critical(wall, -1 if kind == "flip" else 1, omega, phase)
        found = {
            "F": abs(here - load), "speed": abs(float(motion.speeds[0]) - speed),
            "multiplier": float(np.abs(motion.multipliers - multiplier).min()),
            "critical": abs(top - load), "residual": max(residual, motion.residual),
        }  # fmt: skip
        for name, value in found.items():
            largest[kind][name] = max(largest[kind][name], value)
    flip, fold = largest["flip"], largest["fold"]
    head = (
        "| curve | rows | published value that is used | load amplitude F | approach speed | multiplier "
        "| F where the multiplier is exactly −1 or 1 |"
    )
    return [
        head,
        "|---|---|---|---|---|---|---|",
        f"| flip | {counts['flip']} | F | – | {bound(flip['speed'])} | {bound(flip['multiplier'])} "
        f"| {bound(flip['critical'])} |",
        f"| fold | {counts['fold']} | approach speed | {bound(fold['F'])} | – | {bound(fold['multiplier'])} "
        f"| {bound(fold['critical'])} |",
    ]


def chain():
    """The free-free chain of 20 cells."""
    cells = 20
    stiffness = np.zeros((2 * cells, 2 * cells))
    gaps = []
    for i in range(cells):
        if i < cells - 1:
            stiffness[i : i + 2, i : i + 2] += [[1, -1], [-1, 1]]
        direction = np.zeros(2 * cells)
        direction[[i, cells + i]] = -1, 1
        gaps += [vi.Gap(direction, 1.0), vi.Gap(-direction, 1.0)]
    structure = vi.Structure([1.0] * cells + [0.3] * cells, np.zeros(2 * cells), stiffness, gaps)
    rate = np.zeros(2 * cells)
    rate[0] = -1
    times = vi.simulate(structure, duration=10, state=(np.zeros(2 * cells), rate)).events["time"]
    lines = [
        "| impact | neural network | 40 digits | here | here − neural network |",
        "|---|---|---|---|---|",
    ]
    for i, (learnt, known) in enumerate(
        [("1.32868", "1.328742412"), ("2.58660", "2.586409675"), ("3.84609", "3.845947525")]
    ):
        apart = f"{times[i] - float(learnt):+.5f}".replace("-", "−")
        lines.append(f"| {i + 1} | {learnt} | {known} | {times[i]:.9f} | {apart} |")
    return lines


def ball():
    """The first impacts of the ball on a spring."""
    text = (ROOT / "tests" / "data" / "siconos.csv").read_text(encoding="utf-8").splitlines()
    rows = list(csv.DictReader(line for line in text if not line.startswith("#")))
    spring = vi.Structure([1e-3], [0], [100], [vi.Gap([-1], 0, 0.9)])
    load = vi.Load(1.0, constant=[-9.81e-3])
    run = vi.simulate(spring, load, duration=float(rows[-1]["time"]) + 1e-3, state=([1.0], [0.0]))
    events = run.events[: len(rows)]
    lines = [
        "| impact | time, Siconos | here | approach speed, Siconos | here |",
        "|---|---|---|---|---|",
    ]
    for i in (0, 1, 9, len(rows) - 1):
        lines.append(
            f"| {i + 1} | {float(rows[i]['time']):.13f} | {events['time'][i]:.13f} "
            f"| {float(rows[i]['speed']):.9f} | {events['speed'][i]:.9f} |"
        )
    apart = [
        max(abs(float(r[name]) / events[name][i] - 1) for i, r in enumerate(rows))
        for name in ("time", "speed")
    ]
    lines.append(
        f"| all {len(rows)}, largest relative difference | | {bound(apart[0])} | | {bound(apart[1])} |"
    )
    return lines


def two_masses(t):
    """Positions of two masses of 5 with a spring of 1e4 between them, and their speeds, while the first one slips.

    The force 3e3 acts on the second one until 0.2; friction on the first one is at most 3e3 while it sticks, and
    2e3 while it slips.
    """
    omega, slip, change = math.sqrt(2000.0), math.pi / 2 / math.sqrt(2000.0), 0.2
    if t <= slip:
        return 0.0, 0.3 * (1 - math.cos(omega * t)), 0.0, 0.3 * omega * math.sin(omega * t)
    # mean and difference of the positions, and their rates
    mean, mean_rate, apart, apart_rate = 0.15, 0.15 * omega, 0.3, 0.3 * omega
    fast, begin = math.sqrt(4000.0), slip
    for end, force in ((min(t, change), 3e3), (t, 0.0)):
        step, level = max(0.0, end - begin), (force + 2e3) / 2e4
        pull = (force - 2e3) / 10
        mean += mean_rate * step + pull * step**2 / 2
        mean_rate += pull * step
        c, s = math.cos(fast * step), math.sin(fast * step)
        apart, apart_rate = (
            level + (apart - level) * c + apart_rate / fast * s,
            apart_rate * c - (apart - level) * fast * s,
        )
        begin = max(begin, end)
    one, two = mean - apart / 2, mean + apart / 2
    return one, two, mean_rate - apart_rate / 2, mean_rate + apart_rate / 2


def elements():
    """An elastic stop and dry friction beside closed forms."""
    mass = vi.Structure([100], [0], [1e4], [vi.Stop([1], 0, stiffness=1e6)])
    run = vi.simulate(mass, duration=1, state=([0], [1]))
    times, omega = run.events["time"], math.sqrt(1.01e4)
    depth = run.sample([times[1] / 2])[0][0, 0]
    rows = [
        ("end of the first contact", math.pi / omega, times[1]),
        ("largest depth", 1 / omega, depth),
        ("largest force", 1e6 / omega, 1e6 * depth),
        ("beginning of the second contact", math.pi / omega + math.pi / 10, times[2]),
    ]
    slider = vi.Structure([1], [0], [1e4], friction=[vi.Friction([1], slip=1)])
    run = vi.simulate(slider, duration=1, state=([0.85e-3], [0]))
    rows += [
        (f"extreme {i + 1} (10⁻³)", 0.85 * (-1) ** (i + 1) + 0.2 * (i + 1) * (-1) ** i, 1e3 * x)
        for i, x in enumerate(run.states[:, 0, 0].tolist())
    ]
    rows.append(("time at which it rests", math.pi / 25, run.events["time"][-1]))
    pair = vi.Structure(
        [5, 5], [0, 0], [[1e4, -1e4], [-1e4, 1e4]], friction=[vi.Friction([1, 0], 2e3, stick=3e3)]
    )
    run = vi.simulate(pair, vi.Record(0.1, [[0.0, 3e3]] * 3), duration=0.34)
    first, last = run.events["time"].tolist()
    rest = zero(lambda t: two_masses(t)[2], 0.315)
    rows += [
        ("first mass begins to slip", math.pi / 2 / math.sqrt(2000), first),
        ("it sticks again", rest, last),
    ]
    for t, i in ((0.02, 1), (0.15, 0), (0.15, 1)):
        rows.append((f"x{i + 1}({t})", two_masses(t)[i], run.sample([t])[0][i, 0]))
    # the first mass sticks, and the second one oscillates on the spring
    held, other, _, speed = two_masses(rest)
    turn = cmath.exp(1j * math.sqrt(2000) * (0.34 - rest))
    after = held + (other - held) * turn.real + speed / math.sqrt(2000) * turn.imag
    rows.append(("x2(0.34)", after, run.sample([0.34])[0][1, 0]))
    lines = ["| quantity | closed form | here | difference |", "|---|---|---|---|"]
    for name, known, value in rows:
        lines.append(row(name, f"{known:.12g}", float(value)))
    return lines


#: SDND104: amplitude of the acceleration of the base, and the published power.
WEAR = ((15.0, "15.2670995894"), (1.5, "0.40906245"), (1.01, "0.0002261641"), (0.99, "0"))


def wear():
    """The power of wear of a mass on a base that vibrates, beside published numbers."""
    lines = ["| acceleration of the base | published | here | difference |", "|---|---|---|---|"]
    mass = vi.Structure([1], [0], [0], friction=[vi.Friction([1], slip=1)])
    for amplitude, published_power in WEAR:
        load = vi.Load(2 * math.pi, sine=[-amplitude])
        run = vi.simulate(mass, load, cycles=8, discard=4, state=([0], [0]))
        # the speed has one sign between two events
        positions = run.sample(np.r_[run.start, run.events["time"], run.end])[0][0]
        power = 10 * np.abs(np.diff(positions)).sum() / 8
        lines.append(row(f"{amplitude:g}", published_power, float(power)))
    return lines


def written(text, names=("one_wall", "bifurcations", "chain", "ball", "elements", "wear")):
    """The page with some of its tables computed again."""

    def table(found):
        if found[2] not in names:
            return found[0]
        return found[1] + "\n".join(globals()[found[2]]()) + found[3]

    return TABLE.sub(table, text)


if __name__ == "__main__":
    PAGE.write_text(written(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
