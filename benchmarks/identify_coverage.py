"""Coverage of the intervals of `identify` on generators of records.

    python benchmarks/identify_coverage.py [rigs of each kind] [first seed] [generator...]

"pulses" and "spikes" are those of tests/python/reference_rig.py, which share no code with the package: impacts are
pulses of finite duration, which an unknown low-pass may follow, or impulses through a known one. "virtual" is the
package's `VirtualRig`, with pulses through a low-pass that every other record does not state; in "drift" its
coefficients of restitution also fall by up to 1 % during the record, the true ones being their means. In
"contacts" walls are springs with dampers, linear or by the law of Hunt and Crossley, whose true R are those of
isolated impacts at v0 or at the mean speed, and sensors have analogue filters of several kinds. Its d is the
distance of the walls if motions are chaotic, else the travel between the centres of the impacts. Rigs are drawn
alike for all: rates of 2 to 50 kHz, noise of 20 to 50 dB, contacts of 0.05 to 1.5 ms, ringing of up to 30 %,
harmonics of the load, R(v), sensors that are exact or off by 1 %. A kind is a generator with periodic or with
chaotic motions. M, K and, of periodic records, m are known.

The table has, of each kind, the records that are identified without a doubt, those that are rejected or in doubt,
those that are wrong (another pattern), and the shares of true values within the 68 % and the 95 % interval and
beyond five errors. Parameters of one record depend on each other: the errors of the shares are by drawing records
again (bootstrap). Parameters that are undetermined are not counted.
"""

import math
import pathlib
import sys
import time
import warnings

import numpy as np
import vibroimpact as vi

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "tests/python"))
from reference_rig import SPEED, K, M, truth, wide_rig
from shared_identify import recorded

GENERATORS = ("pulses", "spikes", "virtual", "drift", "contacts")
#: Largest share by which coefficients of restitution fall in "drift".
DRIFT = 0.01
#: Standard deviations of an interval that holds 68 %.
SIGMA68 = 0.9944578832097532


def scored(generator, chaos, seed):
    """The outcome of one record: its state, errors over the stated ones by name, its rig, and seconds."""
    own = generator in ("virtual", "drift")
    drift = DRIFT * np.random.default_rng(seed).uniform() if generator == "drift" else 0.0
    rig, record, k, sides = recorded(seed, "virtual" if own else generator, chaos, drift)
    known = {"M": M, "K": K} | ({} if chaos else {"m": M * rig.mu})
    begin = time.process_time()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", vi.PoorFitWarning)
            found = vi.identify(
                record,
                known=known,
                calibration=rig.calibration,
                law="power"
                if rig.exponent or (chaos and rig.wall == "hunt-crossley")
                else "constant",
            )
    except vi.VibroimpactError as error:
        return "refused", {}, rig, time.process_time() - begin, str(error)
    spent = time.process_time() - begin
    if not found.good:
        return "doubted", {}, rig, spent, "; ".join(found.doubts) or str(found)
    scale = (found.values.get("v0", SPEED) / SPEED) ** -rig.exponent if rig.exponent else 1.0
    true = {
        "xi": rig.xi, "mu": rig.mu, "R1": rig.restitution[0] * scale, "R2": rig.restitution[1] * scale,
        "d": rig.d, "exponent": rig.exponent,
    }  # fmt: skip
    if rig.wall:
        impacts = wide_rig(seed, generator, chaos)[1][3]
        true["R1"], true["R2"], travel = truth(rig, impacts, found.values.get("v0"))
        true["d"] = rig.d if chaos else travel
        del true["exponent"]  # the law is no power
    off = {
        name: (found.values[name] - value) / found.errors[name] for name, value in true.items()
        if name in found.errors and name not in found.undetermined
    }  # fmt: skip
    told = None if chaos or own else found.pattern
    if told is not None and (told.cycles, told) != (k, vi.Pattern(sides, k).standard()):
        return "wrong", off, rig, spent, f"{told} {sides}/{k}"
    return "open" if found.undetermined else "right", off, rig, spent, ""


def shares(each):
    """Shares of true values within the 68 % and the 95 % interval and beyond five errors, with their errors."""
    random = np.random.default_rng(0)
    sizes = [np.abs([*off.values()]) for off in each if off]
    if not sizes:
        return np.full((3, 2), math.nan)
    tests = (lambda z: z < SIGMA68, lambda z: z < 1.959963984540054, lambda z: z > 5)
    found = []
    for test in tests:
        inside = np.array([[test(own).sum(), own.size] for own in sizes])
        again = [
            np.divide(*inside[random.integers(0, len(inside), len(inside))].sum(axis=0))
            for _ in range(400)
        ]
        found.append((np.divide(*inside.sum(axis=0)), np.std(again)))
    return np.array(found)


def main(count=60, first=0, *generators):
    """The table."""
    print(
        "| generator | motions | right | rejected or in doubt | wrong | within 68 % | within 95 % | beyond five |"
    )
    print("|---|---|---|---|---|---|---|---|")
    rows = []
    for generator in generators or GENERATORS:
        for chaos in (False, True):
            own = [
                scored(generator, chaos, seed)
                for seed in range(int(first), int(first) + int(count))
            ]
            states = [state for state, *_ in own]
            told = shares([off for state, off, *_ in own if state in ("right", "open")])
            cells = [f"{100 * share:.1f} ± {100 * error:.1f} %" for share, error in told]
            left = states.count("refused") + states.count("doubted")
            right = states.count("right") + states.count("open")
            name = "chaotic" if chaos else "periodic"
            print(
                f"| {generator} | {name} | {right} | {left} | {states.count('wrong')} | {' | '.join(cells)} |",
                flush=True,
            )
            rows += [(generator, chaos, first + i, *one) for i, one in enumerate(own)]
    times = [row[6] for row in rows]
    print(f"\n{np.mean(times):.2f} s a record, {max(times):.2f} s at the most")
    return rows


if __name__ == "__main__":
    main(*map(int, sys.argv[1:3]), *sys.argv[3:])
