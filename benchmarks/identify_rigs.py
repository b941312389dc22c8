"""Score of `identify` on records that the package did not make (tests/python/reference_rig.py).

    python benchmarks/identify_rigs.py [rigs] [first seed]
    python benchmarks/identify_rigs.py [rigs] [first seed] chaos

By kind of record: right ones, those that leave a parameter open, doubtful ones (a misfit above 2, no fit), wrong
ones; how often the true value is within one and 1.96 stated errors, and beyond five; and times. M, K and, of
periodic records, m are known, all else is to be found. The gains of both sensors are off by 1 % (a standard
deviation), which `identify` knows.
"""

import pathlib
import sys
import time

import numpy as np
import vibroimpact as vi

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "tests/python"))
from reference_rig import K, M, chaotic_rig, random_rig

KINDS = {
    "abc": "contact 0.4 ms, 5 kHz",
    "defg": "contact 0.2 to 1 ms",
    "hi": "low-pass",
    "other": "skewed",
}


def scored(seed, kind, chaos):
    """Whether a rig is right, doubtful or wrong; errors over the stated ones; seconds."""
    made = chaotic_rig(seed, kind) if chaos else random_rig(seed, kind)
    rig, (_, load, acceleration, _) = made[:2]
    begin = time.perf_counter()
    try:
        found = vi.identify(
            rate=rig.rate,
            load=load,
            acceleration=acceleration,
            known={"M": M, "K": K} | ({} if chaos else {"m": M * rig.mu}),
        )
    except vi.VibroimpactError:
        return "doubtful", [], time.perf_counter() - begin
    spent = time.perf_counter() - begin
    if found.oscillator is None or found.doubts:
        return "doubtful", [], spent
    if (found.pattern is None) != chaos:
        return "wrong", [], spent
    if not chaos:
        _, k, sides = made[1:]
        if found.pattern.cycles != k or found.pattern != vi.Pattern(sides, k).standard():
            return "wrong", [], spent
    true = {"xi": rig.xi, "R1": rig.restitution[0], "R2": rig.restitution[1], "d": rig.d}
    off = [(found.values[name] - true[name]) / found.errors[name] for name in true]
    return ("open" if found.undetermined else "right"), off, spent


def main(count=40, first=0, chaos=""):
    """The tables."""
    errors, times = [], []
    for kind, text in KINDS.items():
        states = []
        for seed in range(int(first), int(first) + int(count) // len(KINDS)):
            state, off, spent = scored(seed, kind, chaos == "chaos")
            states.append(state)
            errors.append(off)
            times.append(spent)
        shown = ", ".join(
            f"{states.count(name)} {name}" for name in ("right", "open", "doubtful", "wrong")
        )
        print(f"{kind:6s} {text:24s} {shown}")
    size = np.abs([off for off in errors if off])
    for name, own in zip(("xi", "R1", "R2", "d"), size.T, strict=True):
        parts = (f"{np.mean(own < 1):.1%} {np.mean(own < 1.96):.1%} {np.mean(own > 5):.1%}").split()
        print(
            f"{name:3s} within one error {parts[0]}, within 1.96 {parts[1]}, beyond five {parts[2]}"
        )
    print(f"{np.mean(times):.2f} s a record, {max(times):.2f} s at the most")


if __name__ == "__main__":
    main(*sys.argv[1:])
