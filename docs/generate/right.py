"""The measured errors of docs/right.md: results of the package against independent routes, on a fixed sample.

usage: python -m generate.right, in the folder docs, writes them; a test fails if they have become larger.
"""

import math
import sys

import numpy as np
import vibroimpact as vi

from .shared import ROOT
from .validation import SUPERSCRIPTS, TABLE, bound

sys.path.insert(0, str(ROOT / "tests" / "python"))
import first_principles as fp
import reference_simulation as rs
from reference_motion import DIGITS, ReferenceMotion, mp
from shared_laws import scaled
from shared_motions import POINTS, after_impact, motions, system_of
from shared_simulations import system
from shared_systems import RIG
from shared_systems import TABLE as FIRST

PAGE = ROOT / "docs" / "right.md"
DIGITS_OF = {code: chr(plain) for plain, code in SUPERSCRIPTS.items()}
#: Factor by which an error may exceed the one on the page; the last bits differ between machines.
SLACK = 10


def waves(motion):
    """The steady part of a motion, A cos(tau) and A sin(tau)."""
    return motion.A * np.cos(motion.tau), motion.A * np.sin(motion.tau)


def maps_of(motion):
    """Derivatives of the maps between impacts by complex step, from first principles."""
    return fp.impact_jacobians(
        system_of(motion),
        motion.alpha,
        motion.X,
        motion.X_dot_after,
        motion.Z_dot_after,
        *waves(motion),
    )


def newtons_law(motion):
    """The residuals of Newton's law, momentum and restitution, relative to the clearance."""
    lengths = np.divide(
        [motion.X, *(np.full(len(motion.X), w) for w in waves(motion))], motion.clearance
    )
    off = fp.mismatch(system_of(motion), motion.alpha, lengths[0], lengths[1][0], lengths[2][0])
    return np.abs(off).max()


def linear_problem(motion):
    """Clearance and positions of the linear problem (DGELS) with exact phases, relative to the clearance."""
    linear = vi.periodic(motion.osc, motion.r, motion.alpha, motion.pattern)
    apart = [linear.clearance - motion.clearance, *(linear.X - motion.X)]
    return np.abs(apart).max() / motion.clearance


def derivative(motion):
    """Each matrix [P_i] against the complex step, relative to its largest element."""
    wanted, have = scaled(maps_of(motion), motion), scaled(motion.impact_maps(), motion)
    size = np.abs(wanted).max(axis=(1, 2))
    return (np.abs(have - wanted).max(axis=(1, 2)) / size).max()


def determinant(motion):
    """det [P], the product of the determinants of the [P_i], against its law."""
    law = math.exp(-4 * math.pi * motion.osc.xi * motion.pattern.cycles / motion.r)
    law *= np.prod(motion.restitution**2)
    maps = scaled(motion.impact_maps(), motion)
    return abs(np.prod([np.linalg.det(one) for one in maps]) / law - 1)


def multiplier(motion):
    """Relative error of the largest multiplier, against 50 digits."""
    with mp.workdps(DIGITS):
        known = float(max(abs(value) for value in ReferenceMotion(motion).multipliers()))
    return abs(np.abs(motion.multipliers).max() / known - 1)


def simulated(motion):
    """Load phases (rad) of the impacts of a simulation over five periods of a stable motion."""
    periods = 5
    run = vi.simulate(
        motion.osc,
        motion.r,
        motion.clearance,
        periods * motion.pattern.cycles - 0.01,
        after_impact(motion),
    )
    n = len(motion.alpha)
    turns = np.arange(1, len(run.events) + 1)
    wanted = motion.alpha[turns % n] + 2 * math.pi * motion.pattern.cycles * (turns // n)
    return np.abs(run.events["time"] * motion.r - motion.load_phase - wanted).max()


def many_digits(osc, r, clearance):
    """Times and positions of the first impacts against 100 digits."""
    start = {"t": 0.3, "x": 0.1 * clearance, "x_dot": 0.5, "z": 0.2 * clearance, "z_dot": -0.4}
    known = [
        e
        for e in rs.simulate(system(osc, r, clearance), rs.start(**start), 6)
        if e.kind == "impact"
    ]
    run = vi.simulate(osc, r, clearance, 20, start)
    have = run.events[run.events["kind"] == "impact"][: len(known)]
    return max(
        max(abs(float(e.after.t - h["time"])), abs(float(e.after.x - h["x"])) / clearance)
        for e, h in zip(known, have, strict=True)
    )


def structures(motion):
    """Times of the impacts of the same system as a structure with a third mass, over ten periods."""
    osc, D = motion.osc, motion.clearance
    structure = vi.Structure(
        [1, osc.mu, 1], [2 * osc.xi, 0, 0.1], [[1, 0, 0], [0, 0, 0], [0, 0, 2]],
        [vi.Gap([-1, 1, 0], D / 2, osc.restitution[0]), vi.Gap([1, -1, 0], D / 2, osc.restitution[1])],
    )  # fmt: skip
    first = after_impact(motion)
    first |= {name: 0.9 * first[name] for name in ("x_dot", "z_dot")}
    first["z"] = first["x"]
    cycles = 10 * motion.pattern.cycles
    one = vi.simulate(osc, motion.r, D, cycles, first).events["time"]
    state = ([first["x"], first["z"], 0.3], [first["x_dot"], first["z_dot"], 0.0])
    load = vi.Load(motion.r, sine=[1, 0, 0])
    end = first["t"] + 2 * math.pi * cycles / motion.r
    other = vi.simulate(structure, load, duration=end - first["t"], state=state, start=first["t"])
    return np.abs(one - other.events["time"]).max()


def exponent(motion):
    """The largest Lyapunov exponent of a stable motion against its multiplier, per load cycle."""
    found = vi.lyapunov(
        motion.osc, motion.r, motion.clearance, state=after_impact(motion), cycles=4000
    )
    wanted = math.log(np.abs(motion.multipliers).max()) / motion.pattern.cycles
    return abs(found.exponents[0] * 2 * math.pi / motion.r - wanted)


def boundaries():
    """det([P] - I) or det([P] + I) of the independent model at the vertices of a zone where it is zero."""
    zone = vi.zone(FIRST, "RL", (0.9, 1.0), (20.0, 60.0))
    errors = []
    for piece in zone.boundary:
        sign = {"fold": -1, "pitchfork": -1, "flip": 1}.get(piece.type)
        for j in range(len(piece) if sign else 0):
            one = fp.System(FIRST.xi, FIRST.mu, piece.r[j], "RL", 1, FIRST.restitution)
            x, theta = piece.x_over_D[:, j], piece.theta[:, j]
            steady = (
                one.amplitude / piece.clearance[j] * np.array([np.cos(theta[0]), np.sin(theta[0])])
            )
            phases = theta - theta[0]
            _, _, x_dot, _, z_dot = fp.velocities(one, phases, x)
            maps = fp.impact_jacobians(one, phases, x, x_dot, z_dot, *steady)
            errors.append(abs(np.linalg.det(np.linalg.multi_dot(maps[::-1]) + sign * np.eye(4))))
    return errors


def rows():
    """Each comparison: quantity, reference, number of cases, and largest error."""
    all_motions = [motion for point in POINTS for motion in motions(*point)]
    isolated = [
        motion for motion in all_motions
        if len(motion.pattern) != 2 or abs(motion.alpha[1] - math.pi * motion.pattern.cycles) > 1e-6
    ]  # fmt: skip
    stable = [motion for motion in all_motions if motion.stable and motion.admissible]
    points = [(RIG, 0.9, 6.0), (FIRST, 0.94, 37.0), (FIRST, 1.1, 4.0)]
    return [
        ("exact motions",
         "Newton's law, momentum and restitution by an independent model, relative to the clearance",
         [newtons_law(motion) for motion in all_motions]),
        ("exact motions",
         "the linear equations (26), (30), solved by DGELS with their phases, relative to the clearance",
         [linear_problem(motion) for motion in isolated]),
        ("matrices [P<sub>i</sub>]", "derivative of an independent model by complex step, relative",
         [derivative(motion) for motion in all_motions]),
        ("det [P]", "exp(−4πξk/r) ∏ R<sub>i</sub>², relative", [determinant(motion) for motion in all_motions]),
        ("largest multiplier", "50-digit arithmetic, relative",
         [multiplier(motion) for motion in all_motions[:4]]),
        ("simulation over five periods", "the exact motion from which it starts: load phases of impacts (rad)",
         [simulated(motion) for motion in stable]),
        ("simulation", "100-digit arithmetic: times and positions of six impacts",
         [many_digits(*point) for point in points]),
        ("structures, ten periods of a disturbed motion", "the procedures of the oscillator: times of impacts",
         [structures(motion) for motion in stable]),
        ("zone boundary: folds, pitchforks, flips", "det([P] ± I) = 0 by the independent model", boundaries()),
        ("Lyapunov exponent", "logarithm of the multiplier, per load cycle",
         [exponent(motion) for motion in stable]),
    ]  # fmt: skip


def table():
    """The table of the page."""
    lines = ["| result | compared with | cases | worst error |", "|---|---|---|---|"]
    for result, other, errors in rows():
        worst = bound(max(errors), 0).removeprefix("below ")
        lines.append(f"| {result} | {other} | {len(errors)} | {worst} |")
    return lines


def number(text):
    """The number that `bound` writes."""
    digit, _, power = text.rpartition("10")
    return float(f"{digit.rstrip('·') or 1}e{power.translate(DIGITS_OF)}")


if __name__ == "__main__":
    text = TABLE.sub(
        lambda found: found[1] + "\n".join(table()) + found[3], PAGE.read_text(encoding="utf-8")
    )
    PAGE.write_text(text, encoding="utf-8")
