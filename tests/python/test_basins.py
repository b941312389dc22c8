"""Basins compared with the ends of trajectories, closed forms, and counts over every pair of states.

Simulations continue bit for bit, so the attractor of a state can be compared with the end of that
very trajectory, even in transient chaos.
"""

import math
import re

import numpy as np
import pytest
import vibroimpact as vi
from shared_systems import FIGURE6, RIG, TABLE

PLANE = (("x", -30, 30, 40), ("x_dot", -30, 30, 40))


@pytest.fixture(scope="module")
def plane():
    return vi.basins(TABLE, 0.94, 37.0, PLANE)


def test_states_go_where_their_basin_says(plane):
    """Each trajectory, continued for many cycles, has the impacts of the motion that its label names."""
    states = plane.states.reshape(5, -1)
    labels = plane.labels.ravel()
    assert (labels >= 0).all()
    r, clearance, checked = plane.r, plane.clearance, 0
    for j in range(0, labels.size, 7):
        item = plane.attractors[labels[j]]
        start = dict(zip(("t", "x", "x_dot", "z", "z_dot"), states[:, j], strict=True))
        cycles = 5 if item.motion is None else item.motion.pattern.cycles
        run = vi.simulate(TABLE, r, clearance, cycles, state=start, discard=1500)
        if item.kind == "no impacts":
            assert len(run.events) == 0
            continue
        x, own = np.sort(run.events["x"]), np.sort(item.motion.X)
        assert x.size == own.size
        np.testing.assert_allclose(x, own, atol=1e-5 * clearance)
        checked += 1
    assert checked > 150


def mirrors(one, other):
    """For each attractor of one result, the mirror image among the attractors of the other."""
    return [
        next(j for j, item in enumerate(other.attractors)
             if np.abs(np.sort(item.motion.X) - np.sort(-mine.motion.X)).max() < 1e-7)
        for mine in one.attractors
    ]  # fmt: skip


def test_mirror_images_have_equal_shares():
    """Mirror images of random states, half a period later, go to the mirror images of their attractors."""
    result = vi.basins(FIGURE6, 1.04, 14.0, states=3000)
    reflected = -result.states
    reflected[0] = math.pi / 1.04
    there = vi.basins(FIGURE6, 1.04, 14.0, states=reflected)
    first, second = result.attractors
    assert {first.kind, second.kind} == {"periodic"}
    assert sorted(mirrors(result, result)) == [0, 1] != mirrors(result, result)
    images = np.array(mirrors(result, there))
    # rounding decides transient chaos: the shares agree, but not every state
    assert np.mean(images[result.labels] == there.labels) > 0.95
    error = 4 * math.hypot(result.standard_error[0], there.standard_error[0])
    np.testing.assert_allclose(result.fractions, there.fractions[images], atol=error)
    # a plane that is its own mirror image: a whole period of times
    period = 2 * math.pi / 1.04
    plane = (("t", 0, period * 39 / 40, 40), ("x", -20, 20, 41))
    even = vi.basins(FIGURE6, 1.04, 14.0, plane)
    assert abs(np.diff(even.fractions)[0]) < 4 * 2 * even.standard_error[0]
    assert result.fractions.sum() == even.fractions.sum() == 1
    for item in result.attractors:
        assert np.abs(item.motion.multipliers).max() < item.contraction < 1
        assert item.radius > 0


def philox(counter, key):
    """Return the words of Philox4x32-10 (Salmon et al., SC11), computed with Python's unbounded integers."""
    c, (a, b), word = list(counter), key, 2**32
    for _ in range(10):
        p, q = 0xD2511F53 * c[0], 0xCD9E8D57 * c[2]
        c = [q // word ^ c[1] ^ a, q % word, p // word ^ c[3] ^ b, p % word]
        a, b = (a + 0x9E3779B9) % word, (b + 0xBB67AE85) % word
    return c


@pytest.mark.parametrize(("load", "seed"), [(1.0, 0), (0.0, 7), (50.0, 2**31 - 1)])
def test_random_states(load, seed):
    """Random states are the numbers of a published counter-based generator, scaled to the documented box."""
    r, clearance, n = 1.04, 14.0, 30
    states = vi.basins(
        FIGURE6, r, clearance, states=n, load=load, rng=seed, cycles=1, probes=1
    ).states
    known = [0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1]
    pi = (0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344), (0xA4093822, 0x299F31D0)
    assert philox(*pi) == known
    amplitude = load / math.hypot(1 - r**2, 2 * FIGURE6.xi * r)
    s = min(max(amplitude, clearance / 2), 3 * clearance)
    for i, (t, x, x_dot, z, z_dot) in enumerate(states.T.tolist()):
        u = [(2 * word + 1) / 2**32 - 1 for word in philox((i, 0, 0, 0), (seed, 0))]
        assert t == 0
        np.testing.assert_allclose(
            [x, x_dot, z - x, z_dot],
            [s * u[0], s * u[1], clearance / 2 * u[2], s * u[3]],
            rtol=1e-12,
        )
    fewer = vi.basins(FIGURE6, r, clearance, states=9, load=load, rng=seed, cycles=1, probes=1)
    np.testing.assert_array_equal(fewer.states, states[:, :9])


def test_random_shares_are_those_of_a_lattice():
    """The shares agree with those of states in the middles of 4096 equal cells of the same box."""
    r, clearance = 0.94, 37.0
    s = 1 / math.hypot(1 - r**2, 2 * TABLE.xi * r)
    s = min(max(s, clearance / 2), 3 * clearance)
    u = (np.arange(8) + 0.5) / 4 - 1
    x, x_dot, y, z_dot = (item.ravel() for item in np.meshgrid(u, u, u, u))
    states = [0 * x, s * x, s * x_dot, s * x + clearance / 2 * y, s * z_dot]
    lattice = vi.basins(TABLE, r, clearance, states=np.array(states))
    thrown = vi.basins(TABLE, r, clearance, states=3000, rng=1)
    shares = [
        dict(zip([np.round(np.sort(a.motion.X), 5).tobytes() if a.motion else a.kind
                  for a in result.attractors], result.fractions.tolist(), strict=True))
        for result in (lattice, thrown)
    ]  # fmt: skip
    assert max(shares[0].values()) < 0.9
    for which, share in shares[0].items():
        error = math.sqrt(share * (1 - share) * (1 / 4096 + 1 / 3000)) + 1e-3
        assert abs(shares[1].get(which, 0.0) - share) < 4 * error


@pytest.mark.parametrize(
    "start",
    [
        {"states": 60, "rng": 3},
        {"plane": (("y", -3, 3, 5), ("t", 0, 6, 7)), "fixed": {"x": 1.5, "z_dot": -2}},
    ],
)
def test_the_namelist_of_basins(start, tmp_path):
    """The namelist of basins reproduces them to the last bit."""
    result = vi.basins(FIGURE6, 1.04, 14.0, load=1.1, probes=20, max_cycles=4, **start)
    (tmp_path / "case.nml").write_text(result.to_namelist())
    (case,) = vi.read_namelist(tmp_path / "case.nml")
    (again,) = case.run()
    np.testing.assert_array_equal(again.states, result.states)
    np.testing.assert_array_equal(again.labels, result.labels)
    assert again.case == result.case
    # the text must not depend on the order of sets, which differs between processes
    others = re.findall(r"^  (t|x|x_dot|y|z_dot) = ", result.case, re.MULTILINE)
    assert others == ["x", "x_dot", "z_dot"] * ("plane" in start)


def test_decision_does_not_depend_on_how_soon(plane):
    """Fewer cycles in each round give the same labels, since undecided states continue where they are."""
    hasty = vi.basins(TABLE, 0.94, 37.0, PLANE, cycles=60, probes=400)
    ours = [item.motion and np.sort(item.motion.X) for item in plane.attractors]
    share = 0
    for item, fraction in zip(hasty.attractors, hasty.fractions, strict=True):
        match = [
            i for i, x in enumerate(ours)
            if item.motion is not None and x is not None and len(x) == len(item.motion.X)
            and np.abs(x - np.sort(item.motion.X)).max() < 1e-6
        ]  # fmt: skip
        if match:
            # rounding decides transient chaos: the shares agree, but not the states
            error = math.hypot(plane.standard_error[match[0]], 1e-3)
            assert abs(fraction - plane.fractions[match[0]]) < 4 * error
            share += fraction
    assert share > 0.85


def test_motion_with_rest_and_chaos_are_told():
    resting = vi.basins(RIG, 0.9, 6.0, states=100)
    assert [item.kind for item in resting.attractors] == ["rest"]
    assert resting.attractors[0].motion.pattern == vi.Pattern("RL*")
    wild = vi.basins(FIGURE6, 1.04, 72.0, states=60)
    assert [item.kind for item in wild.attractors] == ["chaotic"]
    assert wild.attractors[0].lyapunov.per_cycle[0] > 0.1
    assert wild.labels.max() == 0


def test_a_long_chaotic_transient_with_slow_phases_is_no_attractor():
    """The transient ends at random after about 70,000 load cycles, as did independent simulations of 14 states."""
    result = vi.basins(TABLE, 0.8432, 52.211, states=20)
    assert [item.kind for item in result.attractors] == ["periodic"]
    assert (result.labels == 0).all()


@pytest.mark.slow
def test_a_chaotic_attractor_that_was_seen_in_a_quiet_phase_is_one():
    """At times its motions have few impacts for thousands of load cycles."""
    osc = vi.Oscillator(xi=0.1203, mu=0.5491, restitution=0.4072)
    result = vi.basins(osc, 0.8893, 13.27, states=9, rng=4, cycles=80)
    assert [item.kind for item in result.attractors] == ["chaotic"]
    assert (result.labels == 0).all()


@pytest.mark.slow
@pytest.mark.parametrize("states", [
    12, *(pytest.param(states, marks=pytest.mark.slow) for states in (60, 600))
])  # fmt: skip
def test_chaotic_attractors_that_are_mirror_images_are_two(states):
    """The mirror image of a state on one, half a load period later, is on the other, for any number of states."""
    r, clearance = 0.92, 14.674134539926223
    result = vi.basins(TABLE, r, clearance, states=states)
    assert [item.kind for item in result.attractors] == ["chaotic"] * 2
    starts = np.array([[*item.state.values()] for item in result.attractors]).T
    mirrored = np.vstack([starts[0] + math.pi / r, -starts[1:]])
    again = vi.basins(TABLE, r, clearance, states=np.hstack([starts, mirrored]))
    assert again.labels.tolist() in ([0, 1, 1, 0], [1, 0, 0, 1])


def test_what_never_settles_is_not_decided():
    """Free vibration decays without end: no state is assigned to an attractor."""
    result = vi.basins(FIGURE6, 0.9, 5.0, states=20, load=0.0, cycles=100)
    assert (result.labels == -1).all()
    assert result.attractors == []
    assert "20 not decided" in repr(result)


@pytest.mark.parametrize(
    ("xi", "walls", "r", "clearance"),
    [
        (0.0202443167605986, (0.6974883085198703, 0.701778734695422), 0.9286407087615169, 15.779277974773596),
        (0.10741807170297947, (0.8764470105060991, 0.7296261710310169), 1.6984197629262416, 0.0331078408349547),
    ],
)  # fmt: skip
def test_free_vibration_that_decays_for_a_million_cycles_is_no_attractor(xi, walls, r, clearance):
    """With a heavy free mass both masses swing for 1/xi million cycles, which looks quasi-periodic."""
    osc = vi.Oscillator(xi=xi, mu=1e6, restitution=walls)
    result = vi.basins(osc, r, clearance, states=2)
    assert (result.labels == -1).all()
    light = vi.Oscillator(xi=xi, mu=1.0, restitution=walls)
    assert (vi.basins(light, r, clearance, states=2).labels >= 0).all()


def test_basins_do_not_depend_on_threads():
    one, two = (vi.basins(TABLE, 0.94, 37.0, states=200, threads=n) for n in (1, 2))
    np.testing.assert_array_equal(one.labels, two.labels)
    np.testing.assert_array_equal(one.states, two.states)
    assert one.impacts == two.impacts


def test_a_smooth_boundary():
    """The states without impacts are those of the closed form, and their boundary is a smooth curve."""
    xi, r, clearance = 0.1, 1.0, 11.0
    osc = vi.Oscillator(xi=xi, mu=0.1, restitution=0.6)
    result = vi.basins(osc, r, clearance, (("x", -3, 3, 64), ("x_dot", 2, 8, 64)))
    quiet = [item.kind for item in result.attractors].index("no impacts")
    x, x_dot = result.states[1:3]
    gain, w, t = 1 / complex(1 - r**2, 2 * xi * r), math.sqrt(1 - xi**2), 0.0
    a, b = x - gain.imag, x_dot - (1j * r * gain).imag
    farthest = np.zeros_like(x)
    while t < 80:
        forced = (gain * np.exp(1j * r * t)).imag
        free = a * math.cos(w * t) + (b + xi * a) / w * math.sin(w * t)
        farthest = np.maximum(farthest, np.abs(forced + math.exp(-xi * t) * free - x))
        t += 0.01
    clear = np.abs(farthest - clearance / 2) > 1e-3
    assert clear.mean() > 0.99
    np.testing.assert_array_equal(
        (farthest < clearance / 2)[clear], (result.labels == quiet)[clear]
    )
    # slightly below 1: there are fewer pairs far apart, as s/(64 - s)
    assert abs(result.uncertainty_exponent - 1) < 0.03


def test_integrity_is_that_of_every_pair(plane):
    """The radius agrees with brute force over all pairs of a state and one in another basin or beyond the edge."""
    first, second = plane.axes
    cells = np.array([60 / 39, 60 / 39])
    for label in range(len(plane.attractors)):
        outside = np.argwhere(np.pad(plane.labels != label, 1, constant_values=True)) - 1
        apart = np.argwhere(np.ones_like(plane.labels))[:, None] - outside
        near = np.linalg.norm(apart * cells, axis=-1).min(axis=1).reshape(plane.labels.shape)
        radius, centre = plane.integrity(label)
        assert radius == pytest.approx(near.max(), rel=1e-12)
        i, j = (
            int(np.searchsorted(a.values, x)) for a, x in zip((first, second), centre, strict=True)
        )
        assert near[i, j] == pytest.approx(radius, rel=1e-12)
    with pytest.raises(vi.errors.ParameterError, match=r"^attractor = "):
        plane.integrity(len(plane.attractors))


def test_uncertain_pairs_are_counted(plane):
    """All pairs of states along each axis are counted by brute force; the exponent is the slope of the counts."""
    distance, share = plane.uncertain
    for s, own in zip(distance.astype(int), share, strict=True):
        pairs = [plane.labels[s:] != plane.labels[:-s], plane.labels[:, s:] != plane.labels[:, :-s]]
        assert own == np.mean(np.concatenate([item.ravel() for item in pairs]))
    slope = np.polyfit(np.log(distance), np.log(share), 1)[0]
    assert plane.uncertainty_exponent == pytest.approx(slope, rel=1e-12)


def test_a_list_of_states_has_a_namelist_too(plane, tmp_path):
    """The namelist of listed states reproduces the basins to the last bit; they equal those of a plane."""
    result = vi.basins(TABLE, 0.94, 37.0, states=plane.states.reshape(5, -1))
    (tmp_path / "case.nml").write_text(result.to_namelist())
    (case,) = vi.read_namelist(tmp_path / "case.nml")
    (again,) = case.run()
    assert again.to_json() == result.to_json()
    np.testing.assert_array_equal(result.labels, plane.labels.ravel())
    assert result.axes is None
    for name in ("uncertain", "uncertainty_exponent"):
        with pytest.raises(vi.errors.ParameterError, match=f"must be given for {name}"):
            getattr(result, name)


@pytest.mark.parametrize("form", ["json", "nc", "mat"])
@pytest.mark.parametrize("start", [{"states": 20}, {"plane": (("y", -9, 9, 4), ("x", -3, 3, 5))}])
def test_a_file_gives_the_basins_again(start, form, tmp_path):
    """Saved basins are read back to the last bit, and so is the table that the core writes."""
    result = vi.basins(TABLE, 0.94, 37.0, probes=20, **start)
    result.save(tmp_path / f"one.{form}")
    again = vi.load(tmp_path / f"one.{form}")
    assert again.to_json() == result.to_json()
    assert [item.state for item in again.attractors] == [item.state for item in result.attractors]
    assert again.axes == result.axes
    tables = []
    for item in (result, again):
        item.save(tmp_path / "table.csv")
        tables.append((tmp_path / "table.csv").read_bytes())
    assert tables[0] == tables[1]


@pytest.mark.parametrize(("states", "wanted"), [
    (np.zeros((4, 3)), "of shape"), (np.zeros((5, 0)), "of shape"),
    ([[0.0], [math.nan], [0.0], [0.0], [0.0]], "must be numbers from -1e100 to 1e100"),
    ([[0.0, 0], [0, 0], [0, 0], [0, 6], [0, 0]], "within half the clearance, but is not in state 2"),
])  # fmt: skip
def test_bad_lists(states, wanted):
    with pytest.raises(vi.errors.ParameterError, match=rf"^states.*{wanted}"):
        vi.basins(FIGURE6, 1.04, 10.0, states=states)


#: A point, a number of states, and the attractors: settling simulations mistake several periods for one.
IN_TURNS = [
    (0.16927064225535599, 0.4028836456687256, (0, 0), 1.1116023291034687, 5.601916857805584, 24, ["RL/1"]),
    (0.15222675174436914, 0.49220377043862157, (0, 0.6), 1.0333539391011177, 7.59212674849985, 24, ["R*L/2"]),
    (0.10810779356305288, 0.2694989044142598, (0.3, 0.3), 1.5642670440507604, 1.101117484100148, 24,
     ["RLRLL/2", "RRLRL/2"]),
    (0.02534094120854979, 0.29404333404175353, (0.8, 0), 1.5828113012165286, 1.2407034715726932, 200, ["RL*/1"]),
]  # fmt: skip


@pytest.mark.parametrize(("xi", "mu", "walls", "r", "clearance", "states", "names"), IN_TURNS)
def test_a_motion_is_named_by_its_shortest_period(xi, mu, walls, r, clearance, states, names):
    """A motion approached with alternating sign seems to have several periods; its growth is the exponent."""
    osc = vi.Oscillator(xi=xi, mu=mu, restitution=walls)
    found = vi.basins(osc, r, clearance, states=states)
    assert [attractor.name for attractor in found.attractors] == names
    for one in found.attractors:
        assert one.motion.pattern.cycles == int(names[0][-1])
        assert one.growth == pytest.approx(abs(one.motion.multipliers[0]), rel=1e-6)
        time = one.motion.pattern.cycles * 2 * np.pi / r
        exponents = vi.lyapunov(osc, r, clearance, 4000, one.state).exponents
        assert exponents[0] * time == pytest.approx(np.log(one.growth), abs=1e-3)


@pytest.mark.parametrize(("point", "states"), [
    ((0.14353074654115955, 0.47226232565615794, 0, 0.9305868605408785, 7.877226864655274), 60),
    ((0.17746891934879389, 0.40417724585871123, (0.2, 0), 0.958073656292679, 6.6632066928121825), 60),
])  # fmt: skip
def test_each_periodic_attractor_has_its_motion(point, states):
    """Even where the state that the core names has not settled within twice the period, the motion is found."""
    xi, mu, walls, r, clearance = point
    found = vi.basins(vi.Oscillator(xi=xi, mu=mu, restitution=walls), r, clearance, states=states)
    for one in found.attractors:
        if one.kind in ("periodic", "rest"):
            assert one.growth == pytest.approx(abs(one.motion.multipliers[0]), rel=1e-6)
            assert f"/{one.motion.pattern.cycles}" in one.name


SLOW = (
    # two spirals onto a motion with rest, one of them through a slow pair of multipliers
    (0.0005404645377920503, 0.28751605060791563, (0.08164089879625747, 0.24927555332513807),
     3.145267271295667, 0.0250476858226475, "R*L*/1"),
    # a chaotic transient
    (0.00022366023689906347, 0.009411554634031486, 0.41492002260369976,
     1.4980755879601932, 0.8482889741285213, "RRLRRLLRLL/3"),
)  # fmt: skip


@pytest.mark.parametrize(("xi", "mu", "walls", "r", "clearance", "name"), SLOW)
def test_what_settles_slowly_is_neither_chaotic_nor_quasi_periodic(
    xi, mu, walls, r, clearance, name
):
    osc = vi.Oscillator(xi=xi, mu=mu, restitution=walls)
    result = vi.basins(osc, r, clearance, states=12)
    assert [item.name for item in result.attractors] == [name]
    assert (result.labels == 0).all()
    item = result.attractors[0]
    assert item.motion.stable
    exponents = vi.lyapunov(osc, r, clearance, state=item.state, discard=20_000)
    assert exponents.per_cycle[0] + 4 * exponents.error_per_cycle[0] < 0
    assert exponents.per_cycle[0] == pytest.approx(
        np.log(abs(item.motion.multipliers[0])) / item.motion.pattern.cycles, rel=1e-2
    )


def test_a_chaotic_transient_with_many_impacts_is_no_attractor():
    """The transient ends at random after about 35,000 load cycles on one of two mirror-image motions."""
    osc = vi.Oscillator(
        xi=5.393016929676998e-4, mu=2.0323541470510546e-3, restitution=0.9877129484339674
    )
    result = vi.basins(osc, 0.21978205375145463, 1.2037570985830306, states=8)
    assert sorted(item.name for item in result.attractors) == ["RLLL/1", "RRRL/1"]
    assert (result.labels >= 0).all()


@pytest.mark.slow
def test_labels_do_not_depend_on_rounding_where_transients_are_long():
    """Each state wanders for 10^4 to 10^6 load cycles; its final motion does not depend on its last bits."""
    wall, r, clearance = 0.7189674455988654, 1.4616163504310702, 33.7456669137705
    osc = vi.Oscillator(xi=0.01154927445245723, mu=0.01757787366661444, restitution=wall)
    plane = (("y", (-0.45 * clearance, 0.45 * clearance)), ("z_dot", (-17, 17)))
    states = vi.basins(osc, r, clearance, plane, points=(5, 5)).states.reshape(5, -1)
    for change in (1, 1 + 1e-14, 1 + 3e-14):
        result = vi.basins(osc, r, clearance, states=states * change)
        assert {item.name for item in result.attractors} == {"RL/3", "no impacts"}
        assert (result.labels >= 0).all()


@pytest.mark.slow
def test_a_transient_of_half_a_million_impacts_is_no_attractor():
    """Simulations of 25 states reach the only attractor after 10^4 to 3 10^5 load cycles, at random."""
    osc = vi.Oscillator(
        xi=0.003936963780311907,
        mu=0.05835217662897958,
        restitution=(0.9418246311468366, 0.7301702729389197),
    )
    result = vi.basins(osc, 0.8273387806376318, 8.450064820836847, states=9)
    assert [item.name for item in result.attractors] == ["RRL/1"]


@pytest.mark.slow
def test_a_period_that_is_not_considered_is_not_decided_soon():
    """The motion has a period of 19 load cycles, while periods up to 16 are considered."""
    osc = vi.Oscillator(
        xi=0.003268685691789558,
        mu=0.012192598631411566,
        restitution=(0.5538257197742631, 0.04892169533845492),
    )
    point = (0.2799831591147713, 0.7565223971839834)
    result = vi.basins(osc, *point, states=2)
    assert (result.labels == -1).all()
    longer = vi.basins(osc, *point, states=2, max_cycles=19)
    assert [(item.kind, item.name.split("/")[1]) for item in longer.attractors] == [("rest", "19")]


def test_kinds_agree_with_the_exponents_of_long_averages():
    """Chaotic attractors have an exponent positive beyond its error, in an average ten times as long."""
    seen = set()
    for osc, r, clearance in ((FIGURE6, 1.04, 72.0), (TABLE, 0.8432, 52.211)):
        for item in vi.basins(osc, r, clearance, states=40).attractors:
            long = vi.lyapunov(osc, r, clearance, 100_000, state=item.state)
            if item.kind == "chaotic":
                assert long.per_cycle[0] > 6 * long.error_per_cycle[0]
            elif item.kind == "quasi-periodic":
                assert abs(long.per_cycle[0]) < 1e-4
            else:
                assert long.per_cycle[0] < 0
            seen.add(item.kind)
    assert "chaotic" in seen


@pytest.mark.parametrize("whole", [True, False])
def test_what_is_stopped_while_it_is_watched_stays_undecided(whole):
    """Ctrl-C while possibly chaotic motions are monitored keeps the states; the bar is not full."""
    shares = []

    def press(share, _):
        shares.append(share)
        if share > 0.5:  # all states were simulated
            raise KeyboardInterrupt

    walls = [vi.Gap([-1, 1], 36, 0.75), vi.Gap([1, -1], 36, 0.75)]
    host = vi.Structure([1, FIGURE6.mu], [2 * FIGURE6.xi, 0], [1, 0], walls)
    system = (FIGURE6, 1.04, 72.0) if whole else (host, vi.Load(1.04, sine=[1, 0]))
    with pytest.raises(vi.StudyInterrupted) as caught:
        vi.basins(*system, states=5, threads=1, progress=press)
    found = caught.value.result
    assert (found.labels == -1).any()
    assert (found.labels >= -1).all()
    assert max(shares) < 1
