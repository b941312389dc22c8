"""An audit: atlas, `find` and `exact` are compared with independent simulations of random systems.

Many states of random systems are simulated (`lane_simulation.py`) until they repeat; Newton's
method on the stroboscopic map, differentiated by central differences with Richardson's step, gives
each periodic attractor to rounding, with its multipliers. The results of the package are compared with
them, and further motions that it lists are compared with the stroboscopic map from their states.
"""

from collections import Counter
from dataclasses import dataclass, replace
from itertools import pairwise

import lane_simulation as ls
import numpy as np
import vibroimpact as vi
from vibroimpact.studies.atlas import names_of

R_RANGE, CLEARANCE_RANGE = (0.6, 1.4), (0.5, 150.0)
MOST_CYCLES = 4
"""Periods looked for, in load cycles."""
NEARLY = 0.01
"""What repeats to so much of its size is about to settle."""
BESIDE = 1e-4
"""Distance from a boundary, in r or log D, within which a zone need not contain an attractor."""
CHUNK = 20_000


@dataclass(frozen=True)
class Orbit:
    """A period of the independent simulation.

    `cell` is the phase of the section, in cells; `state` is (x, v, z, w) there; `multipliers` are those of the
    map of `cycles` load cycles, in order of decreasing modulus; `starts` (phase, x, v, w) just after
    the first impact of each letter.
    """

    cell: int
    cycles: int
    state: np.ndarray
    multipliers: np.ndarray
    residual: float
    letters: tuple
    starts: np.ndarray


@dataclass(frozen=True)
class Finding:
    """One disagreement."""

    check: str
    osc: vi.Oscillator
    r: float
    clearance: float
    text: str

    def __str__(self):
        o = self.osc
        return (
            f"{self.check}: Oscillator(xi={o.xi!r}, mu={o.mu!r}, restitution={o.restitution!r}), r = {self.r!r}, "
            f"D = {self.clearance!r}: {self.text}"
        )


def random_oscillators(count, seed):
    """Return oscillators, half of them with equal walls."""
    draw, systems = np.random.default_rng(seed), []
    for _ in range(count):
        xi, mu = 10 ** draw.uniform(-3, -1), 10 ** draw.uniform(np.log10(0.005), np.log10(0.5))
        walls = draw.uniform(0.3, 0.95, 2)
        if draw.random() < 0.5:
            walls[1] = walls[0]
        systems.append(vi.Oscillator(xi=float(xi), mu=float(mu), restitution=tuple(walls.tolist())))
    return systems


def random_points(count, seed):
    """Return r and D."""
    draw = np.random.default_rng(seed)
    r = draw.uniform(*R_RANGE, count)
    return r, np.exp(draw.uniform(*np.log(CLEARANCE_RANGE), count))


def systems_of(oscillators, r, clearance):
    """Return lanes of one oscillator each."""
    walls = np.array([osc.restitution for osc in oscillators], float).reshape(-1, 2).T
    return ls.Systems(
        np.array([osc.xi for osc in oscillators]),
        np.array([osc.mu for osc in oscillators]),
        walls,
        np.asarray(r, float),
        np.asarray(clearance, float),
    )


def random_states(systems, seed):
    """Lanes with random slow and fast states of both masses."""
    draw, n = np.random.default_rng(seed), systems.r.size
    size = np.minimum(20.0, 1 / np.abs(1 - systems.r**2 + 2j * systems.xi * systems.r))
    x, v, w = draw.normal(size=(3, n)) * size
    z = x + draw.uniform(-0.5, 0.5, n) * systems.clearance
    return ls.Lanes(systems, x, v, z, w)


def letters_of(kind, side):
    """Letters of events, and the event that starts each letter; impacts that end in rest are one letter."""
    letters, first, run = [], [], 0
    for i, (what, where) in enumerate(zip(kind.tolist(), side.tolist(), strict=True)):
        name = "R" if where > 0 else "L"
        if what == ls.IMPACT:
            run = run + 1 if run and letters[-1] == name else 1
            letters.append(name)
            first.append(i)
        elif what == ls.STICK:
            start = first[-run]
            del letters[len(letters) - run :], first[len(first) - run :]
            letters.append(name + "*")
            first.append(start)
            run = 0
        else:
            run = 0
    return tuple(letters), first


def spread(events, lanes):
    """The events of each lane: list of (time, kind, side, state)."""
    lane, *rows = events.table()
    edges = np.searchsorted(lane, np.arange(lanes + 1))
    return [tuple(row[low:high] for row in rows[:4]) for low, high in pairwise(edges)]


def scale_of(systems):
    """A length scale for comparing positions."""
    return np.maximum(1.0, systems.clearance)


def attractors(systems, seed, cycles=400, patience=1600):
    """The attractors reached from random states: for each lane an Orbit, "no impact" or "no period"."""
    lanes = random_states(systems, seed)
    found = ["no period"] * systems.r.size
    left = np.arange(systems.r.size)
    for end in (cycles, patience):
        lanes.run(end * ls.CELLS)
        for i, orbit_ in enumerate(repeats(lanes)):
            found[left[i]] = orbit_ or "no period"
        late = np.array([found[i] == "no period" for i in left], bool)
        left, lanes = left[late], lanes.take(late)
        if not left.size:
            break
    return found


def repeats(lanes):
    """The orbits that the lanes repeat: Orbit, "no impact" or None, one for each lane.

    A stable orbit that is within a hundredth of where a lane is after 8 load cycles is what it
    settles on. The lanes go on to the next whole cycle.
    """
    n, start = lanes.x.size, int(lanes.cell.max())
    events, strobe_ = ls.Events(), [lanes.state()]
    for turn in range(1, 2 * MOST_CYCLES + 1):
        lanes.run(start + turn * ls.CELLS, events)
        strobe_.append(lanes.state())
    each, last = spread(events, n), start + 2 * MOST_CYCLES * ls.CELLS
    found = [None if len(row[0]) or lanes.failed[i] else "no impact" for i, row in enumerate(each)]
    for k in range(1, MOST_CYCLES + 1):
        off = np.abs(strobe_[-1] - strobe_[-1 - k]).max(1)
        use = np.flatnonzero(off < NEARLY * scale_of(lanes.systems))
        # a lane that failed, or is between two impacts far apart in time, has no events to read
        end = last // ls.CELLS
        use = use[
            [found[lane] is None and bool((each[lane][0] > end - 2 * k).any()) for lane in use]
        ]
        if not use.size:
            continue
        cell = np.array([section(each[lane], k, end) for lane in use])
        there = lanes.take(use)
        there.run(last + cell)
        state = there.state()
        for lane, near, orbit_ in zip(
            use, state, orbits(there.systems, cell, np.full(use.size, k), state), strict=True
        ):
            if orbit_ is None or not abs(orbit_.multipliers[0]) < 1:
                continue
            if np.abs(orbit_.state - near).max() < 10 * NEARLY * max(
                1.0, lanes.systems.clearance[lane]
            ):
                found[lane] = orbit_
    return found


def section(events, cycles, end):
    """The cell of the period that is in flight and farthest from all events."""
    time, kind, _, _ = events
    late = time > end - 2 * cycles
    time, kind = time[late], kind[late]
    places = np.arange(ls.CELLS * cycles) / ls.CELLS
    # the last event before each place, a period earlier or not, and the distance from the nearest
    after = end - cycles + places
    before = np.searchsorted(time, after) - 1
    resting = (before >= 0) & (kind[before] == ls.STICK)
    gap = np.abs(after[:, None] - time[None, :])
    gap = np.minimum(gap, np.abs(after[:, None] - time[None, :] - cycles)).min(1)
    return int(np.argmax(np.where(resting, -1.0, gap)))


def orbits(systems, cell, cycles, state):
    """Orbits near states at cells, by Newton's method; None where it fails."""
    found = []
    for low in range(0, cell.size, CHUNK // 17):
        part = np.arange(low, min(cell.size, low + CHUNK // 17))
        found += _orbits(systems.take(part), cell[part], cycles[part], state[part].copy())
    return found


def _orbits(systems, cell, cycles, state):
    """Orbits of one batch of states, as for `orbits`."""
    jacobian, _ = strobe_matrix(systems, cell, cycles, state)
    for turn in range(6):
        end, _ = strobe(systems, cell, cycles, state)
        with np.errstate(all="ignore"):
            step = np.linalg.solve(
                np.eye(4) - np.nan_to_num(jacobian, nan=0.5), (end - state)[..., None]
            )[..., 0]
        big = np.abs(step).max(1) > 0.1 * scale_of(systems)
        state = state + np.where(big[:, None] | ~np.isfinite(step), 0.0, step)
        if turn == 2:
            jacobian, _ = strobe_matrix(systems, cell, cycles, state)
    jacobian, smooth = strobe_matrix(systems, cell, cycles, state)
    end, each = strobe(systems, cell, cycles, state)
    residual = np.abs(end - state).max(1) / scale_of(systems)
    return [
        orbit(int(cell[i]), int(cycles[i]), state[i], jacobian[i], residual[i], each[i])
        if smooth[i] and residual[i] < 1e-8 and each[i][0].size
        else None
        for i in range(cell.size)
    ]


def orbit(cell, cycles, state, jacobian, residual, events):
    """Return the Orbit of a state and the events of its period."""
    time, kind, side, after = events
    # start with a release, so that no accumulation is cut in two
    turn = int(np.flatnonzero(kind == ls.RELEASE)[-1]) + 1 if (kind == ls.RELEASE).any() else 0
    time = np.roll(np.where(np.arange(time.size) < turn, time + cycles, time), -turn)
    kind, side, after = np.roll(kind, -turn), np.roll(side, -turn), np.roll(after, -turn, 0)
    letters, first = letters_of(kind, side)
    starts = np.c_[ls.TURN * time[first], after[first][:, [0, 1, 3]]]
    values = np.linalg.eigvals(jacobian)
    values = values[np.argsort(-np.abs(values))]
    return Orbit(cell, cycles, state, values, float(residual), letters, starts)


def strobe(systems, cell, cycles, state):
    """State some load cycles later, and the events of each lane."""
    lanes = ls.Lanes(systems, *state.T)
    lanes.cell[:] = cell
    events = ls.Events()
    lanes.run(cell + cycles * ls.CELLS, events)
    end = lanes.state()
    end[(lanes.side != 0) | lanes.failed] = np.nan
    return end, spread(events, cell.size)


def strobe_matrix(systems, cell, cycles, state):
    """Derivatives of the stroboscopic map, and whether no difference crossed a change of pattern.

    Central differences with steps h and h/2 are combined to an error of order h^4.
    """
    n = cell.size
    matrix, smooth = np.full((n, 4, 4), np.nan), np.zeros(n, bool)
    for size in (3e-5, 3e-6, 3e-7, 3e-8, 3e-9):
        todo = np.flatnonzero(~smooth)
        if not todo.size:
            break
        h = size * scale_of(systems.take(todo))
        changes = [np.zeros((1, 4)), *(s * np.eye(4) for s in (1.0, -1.0, 0.5, -0.5))]
        changes = np.concatenate(changes)
        m = len(changes)
        moved = state[todo][None] + changes[:, None, :] * h[None, :, None]
        many = systems.take(np.tile(todo, m))
        end, each = strobe(
            many, np.tile(cell[todo], m), np.tile(cycles[todo], m), moved.reshape(-1, 4)
        )
        end = end.reshape(m, todo.size, 4)
        wide = (end[1:5] - end[5:9]) / (2 * h[None, :, None])
        fine = (end[9:13] - end[13:17]) / h[None, :, None]
        new = np.moveaxis((4 * fine - wide) / 3, 0, 2)
        # a difference across a corner of the map shows in a disagreement of the two steps
        names = [letters_of(kind, side)[0] for _, kind, side, _ in each]
        same = np.array([
            all(names[j * todo.size + i] == names[i] for j in range(m)) for i in range(todo.size)
        ])  # fmt: skip
        rough = np.moveaxis(np.abs(fine - wide), 0, 2).max((1, 2))
        good = same & np.isfinite(new).all((1, 2)) & (rough <= 3e-4 * np.abs(new).max((1, 2)))
        matrix[todo[good]], smooth[todo[good]] = new[good], True
    return matrix, smooth


def section_of(motion):
    """Cell and state of a motion of the package, in flight and far from events."""
    cells, k = ls.CELLS, motion.pattern.cycles
    start = float(motion.load_phase)
    phases = np.arange(cells * k) * ls.TURN / cells
    times = np.mod(phases - start, ls.TURN * k) / motion.r
    history = motion.sample(times)
    if motion.rest_events is None:
        happened, resting = np.asarray(motion.alpha) / motion.r, np.zeros(times.size, bool)
    else:
        events = motion.events
        happened = np.asarray(events["time"])
        before = np.searchsorted(happened, times, side="right") - 1
        resting = events["kind"][before] == "stick"
    gap = np.abs(times[:, None] - happened[None, :])
    gap = np.minimum(gap, motion.period - gap).min(1)
    best = int(np.argmax(np.where(resting, -1.0, gap)))
    state = np.array([history.X[best], history.X_dot[best], history.Z[best], history.Z_dot[best]])
    return best, state.astype(float)


def matches(motion, orbit_, tolerance=1e-8):
    """Whether an exact motion is an orbit: letters, phases and states after the first impacts."""
    letters = motion.pattern.symbols
    n, turn = len(letters), ls.TURN * motion.pattern.cycles
    # the uncertainty that the residual of the orbit's Newton iteration leaves
    error = orbit_.residual / np.abs(1 - orbit_.multipliers).min()
    tolerance = max(tolerance, 100 * error)
    if n != len(orbit_.letters) or motion.pattern.cycles != orbit_.cycles:
        return False
    phase = np.asarray(motion.alpha) + motion.load_phase
    own = np.c_[phase, motion.X, motion.X_dot_after, motion.Z_dot_after]
    limits = tolerance * np.array([1.0, *3 * [max(1.0, motion.clearance)]])
    for shift in range(n):
        if tuple(letters[shift:] + letters[:shift]) != orbit_.letters:
            continue
        turned = np.roll(own, -shift, 0)
        turned[n - shift :, 0] += turn
        off = turned - orbit_.starts
        off[:, 0] -= ls.TURN * np.round(off[0, 0] / ls.TURN)
        if np.all(np.abs(off) <= limits):
            return True
    return False


def primitive(orbit_):
    """The orbit over its shortest period: a slow transient may first repeat over several periods.

    Of its multipliers only the moduli are kept then.
    """
    n = len(orbit_.letters)
    for times in (4, 3, 2):
        m = n // times
        if n % times or orbit_.cycles % times or orbit_.letters != orbit_.letters[:m] * times:
            continue
        shift = [ls.TURN * orbit_.cycles / times, 0, 0, 0]
        off = np.abs(orbit_.starts[m:] - orbit_.starts[:-m] - shift)
        if off.max() < 1e-6 * max(1.0, np.abs(orbit_.starts[:, 1:]).max()):
            return replace(
                orbit_,
                cycles=orbit_.cycles // times,
                letters=orbit_.letters[:m],
                starts=orbit_.starts[:m],
                multipliers=np.abs(orbit_.multipliers) ** (1 / times),
            )
    return orbit_


def mirrored(orbit_):
    """The mirror image of an orbit: half a load cycle later, left and right exchanged."""
    swap = str.maketrans("RL", "LR")
    starts = orbit_.starts * [1, -1, -1, -1] + [np.pi, 0, 0, 0]
    return replace(
        orbit_, letters=tuple(name.translate(swap) for name in orbit_.letters), starts=starts
    )


def explained(osc, zones, r, clearance, pattern):
    """Whether a point lies in a zone of a pattern, or close to the boundary of one."""
    names = names_of(pattern, osc)
    place = np.array([r, np.log(clearance)])
    for zone in zones:
        if zone.pattern.cycles != pattern.cycles or zone.pattern.sides not in names:
            continue
        if bool(zone.contains(r, clearance)):
            return True
        for piece in zone.boundary:
            line = np.c_[piece.r, np.log(piece.clearance)]
            if to_line(place, line) < BESIDE:
                return True
    return False


def point_inside(zone, draw, tries=2000):
    """A random point of a zone, not close to its boundary; None if none is found."""
    for _ in range(tries):
        ring = zone.loops[draw.integers(len(zone.loops))]
        low, high = ring.min(0), ring.max(0)
        r = draw.uniform(low[0], high[0])
        clearance = np.exp(draw.uniform(*np.log([low[1], high[1]])))
        if not zone.contains(r, clearance):
            continue
        place = np.array([r, np.log(clearance)])
        lines = [np.c_[piece.r, np.log(piece.clearance)] for piece in zone.boundary]
        if min(to_line(place, line) for line in lines) > BESIDE:
            return float(r), float(clearance)
    return None


def to_line(place, line):
    """Distance of a point from a polygonal line."""
    if len(line) < 2:
        return float(np.abs(line - place).max(1).min(initial=np.inf))
    a, d = line[:-1], np.diff(line, axis=0)
    share = ((place - a) * d).sum(1) / np.maximum((d * d).sum(1), 1e-300)
    return float(np.abs(a + np.clip(share, 0, 1)[:, None] * d - place).max(1).min())


class Audit:
    """Counts the comparisons, and keeps the disagreements."""

    def __init__(self):
        """Begin with no comparisons."""
        self.counts, self.kinds, self.findings = Counter(), Counter(), []
        self.undecided = []

    def note(self, check, holds, osc, r, clearance, text):
        """Record one comparison."""
        self.counts[check, bool(holds)] += 1
        if not holds:
            self.findings.append(Finding(check, osc, float(r), float(clearance), text))

    def exact_of(self, osc, r, clearance, orbit_):
        """(c) `exact` from the package's own simulation gives the orbit, (e) with its verdict."""
        phase = ls.TURN * (orbit_.cell % ls.CELLS) / ls.CELLS
        names = ("x", "x_dot", "z", "z_dot")
        start = dict(zip(names, orbit_.state.tolist(), strict=True)) | {"t": phase / r}
        text = f"{''.join(orbit_.letters)}/{orbit_.cycles}"
        try:
            run = vi.simulate(osc, r, clearance, 4 * orbit_.cycles, start)
            motion = vi.exact(osc, r, clearance, run)
        except vi.errors.VibroimpactError as error:
            self.note("exact", False, osc, r, clearance, f"{text}: {error}")
            return None
        self.note("exact", matches(motion, orbit_), osc, r, clearance, f"{text} is {motion!r}")
        self.verdict(motion, orbit_.multipliers, text)
        self.note("admissible", motion.admissible, osc, r, clearance, repr(motion))
        return motion

    def verdict(self, motion, multipliers, text):
        """(e) `stable`, and the leading multiplier, are those of the stroboscopic map."""
        own, other = abs(motion.multipliers[0]), abs(multipliers[0])
        place = motion.osc, motion.r, motion.clearance
        near = abs(other - 1) < 1e-4
        holds = motion.stable is None or near or motion.stable == (other < 1)
        if motion.stable is None and not near:
            self.undecided.append(f"{text}: {motion!r}, differences {other:.9g}")
        self.note("stable", holds, *place, f"{text}: {motion!r}, differences {other:.9g}")
        # the second derivative of the map with a multiplier of this size
        close = abs(own - other) <= 1e-5 * max(1.0, own) + 1e-4 * (own > 30) * own
        self.note("multiplier", close, *place, f"{text}: {own:.9g}, differences {other:.9g}")

    def found(self, osc, r, clearance, orbits_, **limits):
        """(b) `find` lists the orbits within its limits; returns its motions."""
        motions = vi.find(osc, r, clearance, **limits)
        for orbit_ in orbits_:
            if orbit_.cycles > 2 or len(orbit_.letters) > 6:
                continue
            images = (
                [orbit_, mirrored(orbit_)] if osc.restitution[0] == osc.restitution[1] else [orbit_]
            )
            listed = any(matches(m, image, 1e-6) for m in motions for image in images)
            text = f"{''.join(orbit_.letters)}/{orbit_.cycles} is not among {len(motions)} motions"
            self.note("find", listed, osc, r, clearance, text)
        return motions

    def zones(self, osc, here, impacts=5, cycles=1):
        """(a) The atlas has a zone around every orbit (r, D, orbit) within its limits."""
        atlas = vi.atlas(osc, R_RANGE, CLEARANCE_RANGE, max_impacts=impacts, max_cycles=cycles)
        for r, clearance, orbit_ in here:
            if orbit_.cycles > cycles or len(orbit_.letters) > impacts:
                continue
            pattern = vi.Pattern("".join(orbit_.letters), orbit_.cycles)
            held = explained(osc, atlas.zones, r, clearance, pattern)
            text = f"{pattern.sides}/{cycles} is in none of {len(atlas.zones)} zones"
            self.note("atlas", held, osc, r, clearance, text)
        return atlas.zones

    def inside(self, osc, zones, seed):
        """(a) At a random point inside each zone there is a stable motion of its pattern; returns the motions."""
        draw = np.random.default_rng(seed)
        stable = []
        for zone in zones:
            place = point_inside(zone, draw)
            if place is None:
                continue
            n, k = len(zone.pattern), zone.pattern.cycles
            names = names_of(zone.pattern, osc)
            motions = [
                motion
                for motion in vi.find(osc, *place, max_impacts=max(2, n), max_cycles=k)
                if motion.pattern.sides in names and motion.pattern.cycles == k and motion.stable
            ]
            self.note(
                "zone", motions, osc, *place, f"{zone!r} holds no stable {zone.pattern.sides}/{k}"
            )
            stable += motions
        return stable

    def claims(self, motions):
        """(d) and (e) for motions of the package: they return to themselves, with stability as stated."""
        motions = [motion for motion in motions if motion.admissible]
        if not motions:
            return
        places = [section_of(motion) for motion in motions]
        cell = np.array([place[0] for place in places])
        state = np.array([place[1] for place in places])
        cycles = np.array([motion.pattern.cycles for motion in motions])
        systems = systems_of(
            [m.osc for m in motions], [m.r for m in motions], [m.clearance for m in motions]
        )
        end, _ = strobe(systems, cell, cycles, state)
        matrix, smooth = strobe_matrix(systems, cell, cycles, state)
        off = np.abs(end - state).max(1)
        for i, motion in enumerate(motions):
            place = motion.osc, motion.r, motion.clearance
            size = np.nanmax(np.abs(matrix[i])) if smooth[i] else 1e3
            returns = off[i] < 1e-9 * max(1.0, size) * max(1.0, motion.clearance)
            self.note("returns", returns, *place, f"{motion!r}: off by {off[i]:.3g} after a period")
            if returns and smooth[i]:
                values = np.linalg.eigvals(matrix[i])
                self.verdict(motion, values[np.argsort(-np.abs(values))], "claimed")
        self.perturbed(motions, systems, cell, cycles, state)

    def perturbed(self, motions, systems, cell, cycles, state, turns=100):
        """(d) A change of 1e-6 dies out where a motion is stable, and grows where it is not."""
        size = 1e-6 * scale_of(systems)
        draw = np.random.default_rng(0).normal(size=state.shape)
        change = size[:, None] * draw / np.linalg.norm(draw, axis=1)[:, None]
        lanes = ls.Lanes(systems, *(state + change).T)
        lanes.cell[:] = cell
        most = np.zeros(len(motions))
        for turn in range(1, turns + 1):
            lanes.run(cell + turn * cycles * ls.CELLS)
            off = np.abs(lanes.state() - state).max(1) / size
            most = np.fmax(most, off)
        for i, motion in enumerate(motions):
            place = motion.osc, motion.r, motion.clearance
            growth = turns * np.log(abs(motion.multipliers[0]))
            if motion.stable and growth < -7:
                self.note(
                    "stays", off[i] < 0.1, *place, f"{motion!r}: {off[i]:.3g} of a change left"
                )
            if motion.stable is False and growth > 9:
                self.note("leaves", most[i] > 10, *place, f"{motion!r}: {most[i]:.3g} of a change")

    def table(self):
        """Rows (check, agreements, disagreements)."""
        checks = dict.fromkeys(check for check, _ in self.counts)
        return [(check, self.counts[check, True], self.counts[check, False]) for check in checks]

    def __str__(self):
        kinds = [f"{name}: {count}" for name, count in self.kinds.most_common()]
        rows = [f"{check}: {good} agree, {bad} do not" for check, good, bad in self.table()]
        return "\n".join([*kinds, *rows, *map(str, self.findings)])


def kind_of(found):
    """The name of an attractor in the table."""
    if isinstance(found, str):
        return found
    return "with rest" if any("*" in name for name in found.letters) else "without rest"


def audit(systems, points, seed=1, searched=8, cycles=200, patience=200):
    """Audit random systems at random points, one random state each.

    At every `searched`-th point with an attractor, `find` is called too, and all its statements are compared
    with the independent simulation. Returns the Audit, its `kinds` counting what the states
    settle on.
    """
    oscillators = random_oscillators(systems, seed)
    r, clearance = np.array([random_points(points, [seed, i]) for i in range(systems)]).swapaxes(
        0, 1
    )
    lanes = systems_of(
        [osc for osc in oscillators for _ in range(points)], r.ravel(), clearance.ravel()
    )
    found = attractors(lanes, seed, cycles, patience)
    return compared(oscillators, r, clearance, found, searched)


def compared(oscillators, r, clearance, found, searched=8):
    """Compare the package with the attractors of random states; arguments as in `audit`."""
    report = Audit()
    report.kinds.update(map(kind_of, found))
    points, claimed = r.shape[1], []
    for i, osc in enumerate(oscillators):
        here = [
            (r[i, j], clearance[i, j], primitive(found[i * points + j]))
            for j in range(points)
            if not isinstance(found[i * points + j], str)
        ]
        for *place, orbit_ in here:
            motion = report.exact_of(osc, *place, orbit_)
            claimed += [motion] if motion is not None else []
        for *place, orbit_ in here[::searched]:
            claimed += report.found(osc, *place, [orbit_])
        zones = report.zones(osc, here)
        claimed += report.inside(osc, zones, [i, points])
    report.claims(claimed)
    return report
