"""Time of a chart of the equispaced motion, 200 x 200 points, and of exact motions followed over it."""

import statistics
import time

import numpy as np
import vibroimpact as vi
from vibroimpact import _core

ROUNDS = 7
OSC = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
R, D = np.linspace(0.8, 1.2, 200), np.geomspace(2, 200, 200)


def median(call):
    """Median CPU time of a few calls, in milliseconds."""
    times = []
    for _ in range(ROUNDS):
        begin = time.process_time()
        call()
        times.append(1e3 * (time.process_time() - begin))
    return statistics.median(times)


def pair(multipliers):
    """The core's part of a chart of the equispaced motions, on one thread."""
    _core.equispaced_chart(OSC.xi, OSC.mu, OSC.restitution, R, D, 1, multipliers, 1)


def one_after_the_other():
    """The same answers by the general procedures, one motion after the other."""
    return _core.equispaced(
        OSC.xi, OSC.mu, OSC.restitution, np.repeat(R, D.size), np.tile(D, R.size), 1, 0.03, False, True
    )  # fmt: skip


def same_answers():
    """Whether both ways give the same verdicts and the same largest positions."""
    scalars, _, verdicts, status = _core.equispaced_chart(
        OSC.xi, OSC.mu, OSC.restitution, R, D, 1, False, 1
    )
    _, general, _, decided, code = one_after_the_other()
    # (rows, 2, D, R) against (rows, R * D * 2)
    general = general.reshape(6, R.size, D.size, 2).transpose(0, 3, 2, 1)
    decided = decided.reshape(3, R.size, D.size, 2).transpose(0, 3, 2, 1)
    code = code.reshape(R.size, D.size, 2).transpose(2, 1, 0)
    there = status == 0
    return (
        np.array_equal(status, code)
        and np.array_equal(verdicts[:, there], decided[:, there])
        and np.allclose(scalars[3][there], general[5][there], rtol=1e-10, atol=0)
    )


def rows():
    """Return the row of the table: work, ours, peer, peer_name, unit, target, same_answer."""
    return [
        {
            "work": "chart of the equispaced motion, 200 x 200",
            "ours": median(lambda: pair(False)),
            "peer": median(one_after_the_other),
            "peer_name": "one motion after the other",
            "unit": "ms",
            "target": 12.0,
            "same_answer": same_answers(),
        }
    ]


def main():
    print("milliseconds of CPU for 200 x 200 points, median of", ROUNDS)
    print(f"  equispaced, verdicts and x_max   {median(lambda: pair(False)):8.1f}")
    print(f"  equispaced, multipliers too      {median(lambda: pair(True)):8.1f}")
    general = median(one_after_the_other)
    print(f"  the same by `equispaced`         {general:8.1f}")
    exact = median(lambda: vi.chart(OSC, vi.Pattern("RRL"), R, D, threads=1))
    print(f"  RRL: search, flood, dataset      {exact:8.1f}")


if __name__ == "__main__":
    main()
