"""Microseconds a point from phases to the verdict `stable`, and to the spectral radius too.

This package (`stability_flags`, one thread), a numba loop with its own Householder least squares and double-shift
QR, and NumPy's batched `qr`, `solve` and `eigvals`, on the same random points; it stops unless all give the same
verdicts and radii. For comparison the LAPACK calls alone on points of the same kind, without assembly of their
matrices, if reference_chain is built.

Run with `python benchmarks/flags_speed.py` (needs numba).
"""

import math
import statistics
import subprocess
import time
from pathlib import Path

import numba
import numpy as np
import vibroimpact as vi

OSC = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))
POINTS, ROUNDS = 100_000, 7
TARGETS = {2: 0.12, 3: 0.20, 5: 0.35}
RADIUS_TARGET = 0.5
CHAIN = Path(__file__).resolve().parents[1] / "build/fortran/benchmarks/reference_chain"


@numba.njit(fastmath=True)
def equations(xi, mu, r, alpha, y, wall, a):
    """Equations (26) and (30), one a row of a (2N, N + 3); of many points, if r and alpha[i] are arrays."""
    n = len(alpha)
    h = math.sqrt(1 - xi * xi)
    a[:] = 0.0
    for i in range(n):
        p, j, k = (i - 1) % n, (i + 1) % n, (i + 2) % n
        lp = alpha[i] - alpha[p] + (2 * math.pi if i == 0 else 0.0)
        li = alpha[j] - alpha[i] + (2 * math.pi if j == 0 else 0.0)
        lj = alpha[k] - alpha[j] + (2 * math.pi if k == 0 else 0.0)
        e, t = np.exp(-xi * li / r), h * li / r
        c1, c2 = e * np.sin(t), e * np.cos(t)
        c3, c4 = h * c2 - xi * c1, -(h * c1 + xi * c2)
        g1 = (1 + mu) * wall[i] * r / ((1 + wall[i]) * lp)
        g2 = (1 - mu * wall[i]) * r / ((1 + wall[i]) * li)
        g3 = (wall[j] - mu) * r / ((1 + wall[j]) * li)
        g4 = (1 + mu) * r / ((1 + wall[j]) * lj)
        s, c, s2, k2 = (
            np.sin(alpha[i]),
            np.cos(alpha[i]),
            np.sin(alpha[j]),
            np.cos(alpha[j]),
        )
        su, cu = (r * c + xi * s) / h, (-r * s + xi * c) / h
        pull = g1 * (y[i] - y[p]) + g2 * (y[j] - y[i])
        a[i, i] += c1 / h * (g2 - g1 - xi) - c2
        a[i, j] += 1 - c1 / h * g2
        a[i, p] += c1 / h * g1
        a[i, n], a[i, n + 1] = c1 * su + c2 * s - s2, c1 * cu + c2 * c - k2
        a[i, n + 2] = c1 / h * pull
        a[n + i, i] += -g3 - c4 - c3 / h * (g1 - g2 + xi)
        a[n + i, j] += g3 - g4 - c3 / h * g2
        a[n + i, k] += g4
        a[n + i, p] += c3 / h * g1
        a[n + i, n], a[n + i, n + 1] = c3 * su + c4 * s - r * k2, c3 * cu + c4 * c + r * s2
        a[n + i, n + 2] = -g3 * (y[j] - y[i]) - g4 * (y[k] - y[j]) + c3 / h * pull


@numba.njit(fastmath=True)
def linear_motion(xi, mu, r, alpha, y, wall, a, x):
    """Least squares solution of the equations by Householder reflections."""
    equations(xi, mu, r, alpha, y, wall, a)
    n = alpha.size
    m, q = 2 * n, n + 2
    for j in range(min(q, m - 1)):
        norm = 0.0
        for i in range(j, m):
            norm += a[i, j] * a[i, j]
        d = -math.copysign(math.sqrt(norm), a[j, j])
        v = a[j, j] - d
        a[j, j] = v
        for k in range(j + 1, q + 1):
            w = 0.0
            for i in range(j, m):
                w += a[i, j] * a[i, k]
            w /= d * v
            for i in range(j, m):
                a[i, k] += w * a[i, j]
        a[j, j] = d
    for i in range(q - 1, -1, -1):
        w = a[i, q]
        for j in range(i + 1, q):
            w -= a[i, j] * x[j]
        x[i] = w / a[i, i]


@numba.njit(fastmath=True)
def monodromy(xi, mu, r, alpha, y, wall, x, p, part, new):
    """[P] = [P_N] .. [P_1] by (A5)-(A7); part and new are scratch."""
    n = len(alpha)
    h = math.sqrt(1 - xi * xi)
    for i in range(n):
        b4, j = (i - 1) % n, (i + 1) % n
        lp = alpha[i] - alpha[b4] + (2 * math.pi if i == 0 else 0.0)
        li = alpha[j] - alpha[i] + (2 * math.pi if j == 0 else 0.0)
        zp = r * (x[i] + y[i] - x[b4] - y[b4]) / lp
        z = r * (x[j] + y[j] - x[i] - y[i]) / li
        v = ((1 + mu) * wall[i] * zp + (1 - mu * wall[i]) * z) / (1 + wall[i])
        e, t = np.exp(-xi * li / r), h * li / r
        c1, c2 = e * np.sin(t), e * np.cos(t)
        c3, c4 = h * c2 - xi * c1, -(h * c1 + xi * c2)
        sa, ca, sb, cb = (
            np.sin(alpha[i]),
            np.cos(alpha[i]),
            np.sin(alpha[j]),
            np.cos(alpha[j]),
        )
        s, c = sa * x[n] + ca * x[n + 1], ca * x[n] - sa * x[n + 1]
        s_, c_ = sb * x[n] + cb * x[n + 1], cb * x[n] - sb * x[n + 1]
        b, f = x[i] - s, v - r * c
        s1, s2, s4 = (xi * c1 + h * c2) / h, c1 / h, c3 / h
        s6 = (f * s4 - b * s2) / r
        q = 1 / (z / r - c_ - s6)
        s12, s13 = c_ + s6, (-b * c3 + (h * c4 - xi * c3) * f) / (r * h)
        s14 = s13 - r * s_
        top = -s1 * c + r * s2 * s - s6
        t1, t2, t3, t4 = (s1 - 1) * q, s2 * q, -li / r * q, (top + z / r) * q
        low = s2 * c + r * s4 * s - s13
        k1, k2 = (1 - mu * wall[j]) / (1 + mu), mu * (1 + wall[j]) / (1 + mu)
        k3, k4 = (1 + wall[j]) / (1 + mu), (mu - wall[j]) / (1 + mu)
        part[0, 0], part[0, 1], part[0, 2], part[0, 3] = (
            s1 + s12 * t1,
            s2 + s12 * t2,
            s12 * t3,
            top + s12 * t4,
        )
        w1, w2, w3, w4 = s14 * t1 - s2, s4 + s14 * t2, s14 * t3, low + s14 * t4
        part[1, 0], part[1, 1], part[1, 2], part[1, 3] = k1 * w1, k1 * w2, k1 * w3 + k2, k1 * w4
        part[2, 0], part[2, 1], part[2, 2], part[2, 3] = k3 * w1, k3 * w2, k3 * w3 + k4, k3 * w4
        part[3, 0], part[3, 1], part[3, 2], part[3, 3] = t1, t2, t3, t4
        if i == 0:
            p[:] = part
        else:
            for u in range(4):
                for w in range(4):
                    total = 0.0
                    for g in range(4):
                        total += part[u, g] * p[g, w]
                    new[u, w] = total
            p[:] = new


@numba.njit(fastmath=True)
def largest_modulus(p):
    """Spectral radius: Hessenberg form by elimination with pivots, then Francis' double-shift QR (`hqr`)."""
    a, n = p, 4
    for m in range(1, n - 1):
        x, i = 0.0, m
        for j in range(m, n):
            if abs(a[j, m - 1]) > abs(x):
                x, i = a[j, m - 1], j
        if i != m:
            for j in range(m - 1, n):
                a[i, j], a[m, j] = a[m, j], a[i, j]
            for j in range(n):
                a[j, i], a[j, m] = a[j, m], a[j, i]
        if x != 0.0:
            for i in range(m + 1, n):
                y = a[i, m - 1] / x
                if y != 0.0:
                    a[i, m - 1] = 0.0
                    for j in range(m, n):
                        a[i, j] -= y * a[m, j]
                    for j in range(n):
                        a[j, m] += y * a[j, i]
    radius, hi, turns = 0.0, n - 1, 0
    norm = 0.0
    for i in range(n):
        for j in range(max(i - 1, 0), n):
            norm += abs(a[i, j])
    while hi >= 0 and turns < 60:
        low = hi
        while low > 0:
            s = abs(a[low - 1, low - 1]) + abs(a[low, low])
            if abs(a[low, low - 1]) <= 1e-16 * (s if s > 0 else norm):
                break
            low -= 1
        x = a[hi, hi]
        if low == hi:
            radius, hi = max(radius, abs(x)), hi - 1
            continue
        y, w = a[hi - 1, hi - 1], a[hi, hi - 1] * a[hi - 1, hi]
        if low == hi - 1:
            g = 0.5 * (y - x)
            q = g * g + w
            if q >= 0:
                big = x + g + math.copysign(math.sqrt(q), g) if g != 0 else x + math.sqrt(q)
                one = g + math.copysign(math.sqrt(q), g)
                radius = max(radius, abs(x + one), abs(x - w / one) if one != 0 else abs(big))
            else:
                radius = max(radius, math.sqrt((x + g) ** 2 - q))
            hi -= 2
            continue
        turns += 1
        for k in range(low, hi):
            if k == low:
                f = a[k, k] * (a[k, k] - x - y) + x * y - w + a[k, k + 1] * a[k + 1, k]
                g = a[k + 1, k] * (a[k, k] + a[k + 1, k + 1] - x - y)
                e = a[k + 1, k] * a[k + 2, k + 1]
            else:
                f, g = a[k, k - 1], a[k + 1, k - 1]
                e = a[k + 2, k - 1] if k + 2 <= hi else 0.0
            size = math.sqrt(f * f + g * g + e * e)
            if size == 0.0:
                continue
            d = -math.copysign(size, f)
            f -= d
            share = -1 / (d * f)
            last = min(k + 2, hi)
            for j in range(max(k - 1, low), n):
                t = f * a[k, j] + g * a[k + 1, j] + (e * a[k + 2, j] if last == k + 2 else 0.0)
                t *= share
                a[k, j] -= t * f
                a[k + 1, j] -= t * g
                if last == k + 2:
                    a[k + 2, j] -= t * e
            for i in range(min(k + 3, hi) + 1):
                t = f * a[i, k] + g * a[i, k + 1] + (e * a[i, k + 2] if last == k + 2 else 0.0)
                t *= share
                a[i, k] -= t * f
                a[i, k + 1] -= t * g
                if last == k + 2:
                    a[i, k + 2] -= t * e
    return radius


@numba.njit(fastmath=True)
def numba_radii(xi, mu, r, phases, y, wall, radii):
    """Spectral radius of every point; the phases of a point are a row."""
    n = phases.shape[1]
    a, x, p = np.empty((2 * n, n + 3)), np.empty(n + 2), np.empty((4, 4))
    part, new = np.empty((4, 4)), np.empty((4, 4))
    for j in range(r.size):
        linear_motion(xi, mu, r[j], phases[j], y, wall, a, x)
        monodromy(xi, mu, r[j], phases[j], y, wall, x, p, part, new)
        radii[j] = largest_modulus(p)


def numpy_radii(xi, mu, r, phases, y, wall):
    """The same formulas on arrays, with NumPy's batched linear algebra; the phases of a point are a column."""
    n, count = phases.shape
    a = np.empty((2 * n, n + 3, count))
    equations.py_func(xi, mu, r, phases, y, wall, a)
    a = np.ascontiguousarray(np.moveaxis(a, 2, 0))
    q, upper = np.linalg.qr(a[:, :, :-1])
    x = np.linalg.solve(upper, np.swapaxes(q, 1, 2) @ a[:, :, -1:])[:, :, 0].T
    p, part, new = np.empty((3, 4, 4, count))
    monodromy.py_func(xi, mu, r, phases, y, wall, x, p, part, new)
    return np.abs(np.linalg.eigvals(np.moveaxis(p, 2, 0))).max(axis=1)


def points(n):
    """Impacts spread over one cycle, both walls in turn, around resonance."""
    rng = np.random.default_rng(1983)
    gaps = rng.uniform(0.5, 1.5, (n, POINTS))
    gaps *= 2 * np.pi / gaps.sum(axis=0)
    phases = np.vstack([np.zeros(POINTS), np.cumsum(gaps, axis=0)[:-1]])
    return vi.Pattern("RL" * (n // 2) + "R" * (n % 2)), rng.uniform(0.85, 1.15, POINTS), phases


def microseconds(calls):
    """Median CPU time a point of each call, the calls taking turns."""
    times = [[] for _ in calls]
    for _ in range(ROUNDS):
        for call, spent in zip(calls, times, strict=True):
            begin = time.process_time()
            call()
            spent.append(1e6 * (time.process_time() - begin) / POINTS)
    return [statistics.median(spent) for spent in times]


def lapack_alone():
    """Microseconds a point of the LAPACK calls alone by N, if reference_chain is built."""
    if not CHAIN.exists():
        return {}
    lines = subprocess.run([CHAIN], check=True, capture_output=True, text=True).stdout.splitlines()
    return {int(line.split()[0]): float(line.split()[1]) for line in lines[2:]}


def rows():
    """Return the rows of the table: work, ours, peer, peer_name, unit, target, same_answer."""
    lapack, table = lapack_alone(), []
    for n, target in TARGETS.items():
        pattern, r, phases = points(n)
        wall = np.where(pattern.signs > 0, *OSC.restitution)
        turned, radii = np.ascontiguousarray(phases.T), np.empty(POINTS)

        def peer():
            numba_radii(OSC.xi, OSC.mu, r, turned, 0.5 * pattern.signs, wall, radii)  # noqa: B023

        def arrays():
            return numpy_radii(OSC.xi, OSC.mu, r, phases, 0.5 * pattern.signs, wall)  # noqa: B023

        def ours(radius):
            return vi.stability_flags(OSC, r, phases, pattern, spectral_radius=radius, threads=1)  # noqa: B023

        peer()
        flags = ours(True)
        clear = np.abs(radii - 1) > 1e-6
        apart = np.abs(flags.spectral_radius / radii - 1)
        apart = np.maximum(apart, np.abs(arrays() / radii - 1))
        same = bool(
            ((flags.stable == 1) == (radii < 1))[clear].all() and np.quantile(apart, 0.999) < 1e-9
        )
        fast, both, loop, batched = microseconds(
            [lambda: ours(False), lambda: ours(True), peer, arrays]
        )
        for work, mine, wanted in (
            ("stable", fast, target),
            ("stable, radius", both, RADIUS_TARGET),
        ):
            for name, other in (
                ("numba", loop),
                ("NumPy, batched", batched),
                ("bare LAPACK", lapack.get(n)),
            ):
                if other is not None:
                    table.append(
                        {
                            "work": f"phases to {work}, N = {n}", "ours": mine, "peer": other, "peer_name": name,
                            "unit": "µs a point", "target": wanted, "same_answer": same,
                        }
                    )  # fmt: skip
    return table


def main():
    """Print the table."""
    print(f"{'work':<30}{'ours':>8}{'target':>8}{'peer':>8}{'ratio':>7}  peer, µs a point")
    for row in rows():
        assert row["same_answer"], f"{row['work']}: the answers differ"
        print(
            f"{row['work']:<30}{row['ours']:8.3f}{row['target']:8.2f}{row['peer']:8.2f}"
            f"{row['peer'] / row['ours']:7.1f}  {row['peer_name']}"
        )


if __name__ == "__main__":
    main()
