"""Zones compared with the closed form of the equispaced pair; their symmetries; invalid input."""

import math
import signal
import subprocess
import sys
import threading

import numpy as np
import pytest
import vibroimpact as vi
from scipy.optimize import brentq
from shared_systems import FIGURE6, RIG
from shared_zones import WINDOW, distance, random_points
from vibroimpact import _core
from vibroimpact.results.tables import from_core


@pytest.fixture(scope="module")
def equispaced():
    return vi.zone(FIGURE6, vi.Pattern("RL"), *WINDOW, symmetric=True)


def assert_closed_form(zone, r, clearance):
    """Assert that the zone contains the points with a stable motion of the pair; return its answers."""
    inside = zone.contains(r, clearance)
    wrong = []
    for a, b, answer in zip(r.tolist(), clearance.tolist(), inside.tolist(), strict=True):
        pair = vi.equispaced(FIGURE6, a, b)
        if any(m.stable and m.admissible for m in pair) != answer:
            wrong.append((a, b))
    # wrong answers are allowed only within the distance of the polygon from the curve
    assert all(distance(zone, *place) < 1e-6 for place in wrong), wrong
    return inside


def test_equispaced_zone_against_the_closed_form(equispaced):
    """At 10,000 points away from the boundary the zone agrees with the verdicts of the pair."""
    r, clearance = random_points(10_000, 1)
    inside = assert_closed_form(equispaced, r, clearance)
    assert 500 < inside.sum() < 9500


@pytest.mark.slow
def test_a_wide_window_against_the_closed_form():
    """The same in a window of two decades of r and five of d K/F0, where resonance needs a denser lattice."""
    window = ((0.1, 10.0), (0.01, 1000.0))
    wide = vi.zone(FIGURE6, vi.Pattern("RL"), *window, symmetric=True)
    assert wide.closed
    assert min(wide.search.lines) > 30
    random = np.random.default_rng(8)
    r, clearance = (np.exp(random.uniform(*np.log(ends), 4000)) for ends in window)
    inside = assert_closed_form(wide, r, clearance)
    assert 300 < inside.sum() < 3700


def test_boundary_against_bisection(equispaced):
    """The leading multiplier of the closed form crosses the unit circle on the boundary."""
    checked = 0
    for r in (0.9, 1.05, 1.15):
        grid = np.geomspace(2.1, 190, 400)

        def stable(clearance, r=r):
            return max(
                (1 - np.abs(m.multipliers).max() for m in vi.equispaced(FIGURE6, r, clearance)
                 if m.admissible), default=-1.0,
            )  # fmt: skip

        values = [stable(c) for c in grid]
        for low, high, a, b in zip(grid, grid[1:], values, values[1:], strict=False):
            if a * b < 0 and min(a, b) > -0.5:
                edge = brentq(stable, low, high, xtol=1e-12)
                assert bool(equispaced.contains(r, edge * (1 + 1e-6))) == (b > 0)
                assert bool(equispaced.contains(r, edge * (1 - 1e-6))) == (a > 0)
                checked += 1
    assert checked >= 2


def test_vertices_against_bisection(equispaced):
    """At the r of a vertex the closed form loses stability at the vertex's clearance, to 1e-8."""
    checked = []
    for piece in equispaced.boundary:
        if piece.type not in ("pitchfork", "neimark_sacker"):
            continue
        # away from the ends of pieces, where another condition may end the zone first
        for j in range(5, len(piece) - 5, 12):
            r, clearance, x = float(piece.r[j]), float(piece.clearance[j]), piece.x_over_D[0, j]

            def margin(clearance, r=r, x=x):
                motions = vi.equispaced(FIGURE6, r, clearance)
                nearest = min(motions, key=lambda m: abs(m.X[0] / m.clearance - x))
                return 1 - float(np.abs(nearest.multipliers).max())

            edge = brentq(margin, clearance * (1 - 1e-4), clearance * (1 + 1e-4), xtol=1e-13)
            assert abs(edge / clearance - 1) < 1e-8
            checked.append(piece.type)
    assert min(checked.count("pitchfork"), checked.count("neimark_sacker")) >= 4


def test_pitchfork_pieces_are_the_pitchfork_of_the_equispaced_motion():
    """Where the unsymmetric motions end the closed form has the multiplier 1."""
    zone = vi.zone(FIGURE6, vi.Pattern("RL"), *WINDOW, symmetric=False)
    pieces = [p for p in zone.boundary if p.type == "pitchfork"]
    assert pieces
    for piece in pieces:
        for r, clearance in zip(piece.r[::5], piece.clearance[::5], strict=True):
            pair = vi.equispaced(FIGURE6, float(r), float(clearance))
            assert min(np.abs(m.multipliers - 1).min() for m in pair) < 1e-7


def test_mirror_images_have_the_same_zone():
    one, other = (vi.zone(FIGURE6, vi.Pattern(s), *WINDOW) for s in ("RRL", "LLR"))
    assert abs(one.area - other.area) < 1e-6 * one.area
    r, clearance = random_points(2000, 3)
    np.testing.assert_array_equal(one.contains(r, clearance), other.contains(r, clearance))


def test_exchanged_walls_exchange_the_zones():
    swapped = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.61, 0.75))
    one = vi.zone(RIG, vi.Pattern("RLL"), *WINDOW)
    other = vi.zone(swapped, vi.Pattern("RRL"), *WINDOW)
    r, clearance = random_points(2000, 4)
    np.testing.assert_array_equal(one.contains(r, clearance), other.contains(r, clearance))


def test_nothing_is_stable_without_loss():
    osc = vi.Oscillator(xi=0.0, mu=0.03, restitution=1.0)
    zone = vi.zone(osc, vi.Pattern("RL"), (1.1, 2.0), (1, 10))
    assert not zone
    assert zone.closed


def test_progress_is_told():
    """Progress runs to 1 over both families of motions, and the zone does not change."""
    shares = []
    message = vi.zone(
        FIGURE6, vi.Pattern("RL"), *WINDOW, progress=lambda share, what: shares.append(share)
    )
    assert shares
    assert shares == sorted(shares)
    assert 0 <= shares[0] <= shares[-1] == 1
    assert message.to_dict() == vi.zone(FIGURE6, vi.Pattern("RL"), *WINDOW).to_dict()


def test_count_and_shapes(equispaced):
    assert equispaced.contains(1.04, [25.0, 3.0]).tolist() == [True, False]
    assert equispaced.count([[1.04], [0.5]], [25.0, np.nan, -1.0]).tolist() == [[1, 0, 0], [0] * 3]


def test_budget_is_told():
    zone = vi.zone(FIGURE6, vi.Pattern("RL"), *WINDOW, symmetric=True, max_points=100)
    assert not zone.closed
    assert "NOT closed" in repr(zone)


@pytest.mark.parametrize("lines", range(5, 13))
def test_a_fold_that_leaves_a_pitchfork(lines):
    """The zone closes where a fold leaves a pitchfork, although only tiny steps resolve the crossing."""
    osc = vi.Oscillator(xi=0.0114, mu=1.0, restitution=0.75)
    zone = vi.zone(osc, vi.Pattern("RL"), *WINDOW, symmetric=False, lines=lines, guesses=4)
    assert zone.closed
    assert {"flip", "fold", "pitchfork"} <= {piece.type for piece in zone.boundary}


@pytest.mark.parametrize(
    ("xi", "mu", "restitution", "lines"),
    [
        (0.00754670733528118, 0.39404804696469653, 0.9014763538990613, 7),
        (0.006030513241567463, 0.35955313165583597, 0.9111231932152131, 6),
        (0.005355200207456664, 0.392074616105469, 0.6571103217073224, 7),
    ],
)
def test_borders_that_do_not_close_are_tried_again(xi, mu, restitution, lines):
    """At a larger distance from the symmetric motions the zone closes, without joining loose ends."""
    osc = vi.Oscillator(xi=xi, mu=mu, restitution=restitution)
    zone = vi.zone(osc, vi.Pattern("RL"), *WINDOW, symmetric=False, lines=lines, guesses=2)
    assert zone.closed
    assert sorted(piece.type for piece in zone.boundary) == ["flip", "fold", "pitchfork", "window"]


@pytest.mark.parametrize(
    ("xi", "mu", "restitution", "sides"),
    [
        (0.05, 0.05, 0.37314990615573823, "RRLL"),
        (0.05, 0.136, (0.46495562191567413, 0.8823162619170517), "RRRL"),
        (0.05, 0.05, 0.6650252815457456, "RRRL"),
        (
            0.09529291238677699,
            0.06261959410863326,
            (0.8872562507394013, 0.43527391677197763),
            "RRLL",
        ),
        (0.04122757228107617, 0.136, (0.5920468392409235, 0.688973467515279), "RRLL"),
    ],
)
def test_all_loops_close(xi, mu, restitution, sides):
    """Five random zones close that have folds of unstable motions, which are easily mistaken for boundaries."""
    zone = vi.zone(vi.Oscillator(xi=xi, mu=mu, restitution=restitution), vi.Pattern(sides), *WINDOW)
    assert zone.closed
    assert len(zone.boundary) > 3


def test_plot_draws_the_pieces(equispaced):
    plt = pytest.importorskip("matplotlib.pyplot")
    ax = equispaced.plot(inverse=True)
    lines = [line.get_xydata() for line in ax.get_lines()]
    for piece in equispaced.boundary:
        if piece.type != "window":
            data = np.c_[piece.r, 1 / piece.clearance]
            assert any(item.shape == data.shape and np.array_equal(item, data) for item in lines)
    plt.close("all")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"r": (0.8, 0.8)}, r"r\[1\] = 0.8: .* r\[0\] below r\[1\]"),
        ({"r": (1.0, 1.0)}, r"r\[1\] = 1.0: .* r\[0\] below r\[1\]"),
        ({"r": (math.nan, 1.0)}, r"r\[0\] = nan"),
        ({"clearance": 3.0}, "clearance = 3.0"),
        ({"pattern": vi.Pattern("RRL"), "symmetric": True}, "symmetric = True"),
        ({"lines": 4}, "lines = 4"),
        ({"guesses": -1}, "guesses = -1"),
        ({"max_points": 5}, "max_points = 5"),
        ({"pattern": vi.Pattern("RL" * 13)}, "pattern = 'RLRL.*must be .* 2 to 24 of them"),
        ({"seeds": [3]}, r"seeds\[0\] = 3"),
    ],
)
def test_bad_input(arguments, words):
    given = {"pattern": vi.Pattern("RL"), "r": WINDOW[0], "clearance": WINDOW[1], **arguments}
    with pytest.raises(vi.errors.VibroimpactError, match=words):
        vi.zone(FIGURE6, **given)


def test_seed_of_another_pattern():
    seed = vi.equispaced(FIGURE6, 1.04, 25.0)[0]
    with pytest.raises(vi.errors.ParameterError, match=r"seeds\[0\].pattern"):
        vi.zone(FIGURE6, vi.Pattern("RRL"), *WINDOW, seeds=[seed])


def test_an_interrupt_is_heard_within_a_call():
    """Ctrl-C ends a long zone at once, not when the core has finished."""
    code = (
        # names are imported on use: Python handles an interrupt during an import, and numpy's import renames it
        "from vibroimpact import Oscillator, Pattern, zone; "
        "osc, pattern = Oscillator(xi=0.0114, mu=0.028, restitution=0.5), Pattern('R*L*'); "
        "print('begin', flush=True); zone(osc, pattern, (0.5, 1.2), (0.5, 10))"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    assert process.stdout.readline() == "begin\n"
    process.send_signal(signal.SIGINT)
    _, output = process.communicate(timeout=60)
    assert output.splitlines()[-1] == "KeyboardInterrupt"


def test_what_progress_raises_ends_the_search(monkeypatch):
    """An exception of `progress` stops the core within a long call, and its partial result is marked."""
    core, ended, answers = _core.run_case, threading.Event(), []

    def watched(*arguments):
        answers.append(core(*arguments))
        ended.set()
        return answers[-1]

    def enough(*_):
        raise RuntimeError("enough")

    monkeypatch.setattr(_core, "run_case", watched)
    with pytest.raises(RuntimeError, match="enough"):
        vi.zone(
            vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.5), vi.Pattern("R*L*"), (0.5, 1.2),
            (0.5, 10), lines=129, progress=enough,
        )  # fmt: skip
    assert ended.wait(60)
    result = from_core("zone", answers[0][0])
    assert result.cut == "the computation was stopped before all boundaries were followed"
    assert result.tables == {}


@pytest.mark.parametrize("symmetric", ["yes", 2])
def test_symmetric_is_one_of_three(symmetric):
    with pytest.raises(vi.errors.ParameterTypeError, match=r"^symmetric = "):
        vi.zone(
            vi.Oscillator(xi=0.01, mu=0.03, restitution=0.75), vi.Pattern("RL"), (0.8, 1.2), (2, 200),
            symmetric=symmetric,
        )  # fmt: skip


def test_motions_of_a_zone_belong_to_its_family():
    """A zone of unsymmetric motions returns no symmetric motion, even next to a pitchfork."""
    zone = vi.zone(
        vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75),
        "RL",
        (0.8, 1.2),
        (2, 60),
        symmetric=False,
    )
    found = 0
    for clearance in np.geomspace(30, 42, 12).tolist():
        if not zone.contains(0.94, clearance):
            continue
        motion = zone.motion(0.94, clearance)
        if motion is not None:
            found += 1
            assert motion.stable
            assert not vi.is_symmetric(motion)
    assert found


#: Oscillator, pattern, a point where a simulation settles on the pattern, and a window around it.
HARD = [
    # few of the guesses with six impacts lead to a motion
    ((0.003488393605663722, 0.022610994224851556, 0.3051494846523276), "RRRLLL", 1,
     (0.11240394087518273, 1.1189566021598252),
     (0.08430295565638704, 0.14331502461585796), (0.45873126762222394, 2.8329130738776533)),
    # the motions begin at a pitchfork of the symmetric ones
    ((0.0010384155090637625, 0.009838515598367315, 0.9296712782075642), "RL", 1,
     (0.12644813341283004, 27.910408526237415),
     (0.1231807465734381, 0.15192292077390698), (16.181023956548284, 33.5178353385643)),
    # the motions begin at a flip of those of half the pattern
    ((0.0033846793235335674, 0.06033283629883693, 0.11636282176678817), "RLRL", 2,
     (0.12515748916100344, 4.239534489566866),
     (0.09083954557909796, 0.15979765638642518), (3.1865737331962225, 12.637022380977164)),
    # a zone of motions with eight impacts, narrow and as high as the window
    ((0.0036632390822039698, 0.003002728587055602, 0.46142234465752974), "RRRRLLLL", 1,
     (1.027266099952177, 7.345390058348557),
     (0.8143618435566341, 1.405846633042275), (2.7424682872468593, 16.17689385653798)),
]  # fmt: skip


@pytest.mark.parametrize(("system", "sides", "cycles", "point", "r", "clearance"), HARD)
def test_zones_that_newtons_method_at_nodes_misses(system, sides, cycles, point, r, clearance):
    """The zone of a motion on which simulations settle is found."""
    xi, mu, restitution = system
    osc = vi.Oscillator(xi=xi, mu=mu, restitution=restitution)
    zone = vi.zone(osc, vi.Pattern(sides, cycles), r, clearance)
    assert zone.count(*point) == 1
    settled = vi.find(osc, *point, max_impacts=2, max_cycles=1, guesses=1, releases=0, states=48)
    assert any(m.stable and m.pattern == zone.pattern for m in settled)


def test_a_thin_zone_between_a_flip_and_a_neimark_sacker_point():
    """A zone thinner than a step: on either side a different multiplier is outside the unit circle."""
    osc = vi.Oscillator(
        xi=0.027757398620042766, mu=0.13773267343919315, restitution=0.9586250802854672
    )
    window = (1.9659244341715572, 2.3914725534277994), (0.2620495762711161, 1.6605096660820937)
    assert vi.zone(osc, "RLL", *window).contains(2.306148503, 0.2888079132)


def test_a_boundary_that_folds_along_its_whole_length():
    """Inside a fold with two cusps two stable motions coexist, whose zone surrounds the fold."""
    osc = vi.Oscillator(
        xi=0.0016522891629765835,
        mu=0.018259241210753042,
        restitution=(0.7670850567906443, 0.4474414017026341),
    )
    zone = vi.zone(osc, vi.Pattern("RLRL", 2), (0.68, 0.78), (12, 17))
    r, clearance = 0.7162756352311942, 15.123462167343908
    found = []
    for piece in zone.boundary:
        for theta in piece.theta.T:
            try:
                motion = vi.exact(osc, r, clearance, (theta - theta[0], zone.pattern))
            except vi.errors.SingularError:
                continue
            own = np.sort(motion.X)
            if motion.stable and motion.admissible and np.ptp(own[::2] - own[1::2]) > 1e-6:
                found += [own] if not any(np.allclose(own, other) for other in found) else []
    assert len(found) == 2
    assert zone.count(r, clearance) == 2


def test_no_boundary_has_its_zone_on_the_wrong_side():
    """Where boundaries cross themselves in the plane, counts are never below zero."""
    osc = vi.Oscillator(
        xi=0.027265061489798084, mu=0.021176221177298987, restitution=0.7459907616623795
    )
    zone = vi.zone(osc, vi.Pattern("RLRLRL", 3), (0.177, 0.189), (1.95, 2.75))
    r, clearance = np.meshgrid(np.linspace(0.177, 0.189, 300), np.geomspace(1.95, 2.75, 300))
    assert zone.count(r, clearance).min() == 0
    # between the flip and the fold on both sides of a crossing
    assert zone.contains(0.1825439919, 2.622)
    assert zone.contains(0.1829190016, [2.535, 2.616]).all()


def test_the_motion_of_a_zone_is_stable_where_there_is_a_stable_one():
    """Next to a fold the unstable motion may be nearer to the boundary."""
    osc = vi.Oscillator(
        xi=0.03657899861721822, mu=0.0044577341927940035, restitution=0.5153245490335636
    )
    window = (0.47124024723865143, 0.5717818700510147), (6.090043158348211, 21.202865616356327)
    zone = vi.zone(osc, "RL", *window)
    rng = np.random.default_rng(5)
    r = rng.uniform(*window[0], 120)
    clearance = np.exp(rng.uniform(*np.log(window[1]), 120))
    inside = zone.contains(r, clearance)
    assert inside.sum() > 20
    for place in zip(r[inside].tolist(), clearance[inside].tolist(), strict=True):
        motion = zone.motion(*place)
        assert motion.stable
        assert motion.admissible


@pytest.mark.slow
def test_a_cascade_is_searched_once():
    """Simulations show motions of many narrow zones of one sheet: their lines are followed only once."""
    osc = vi.Oscillator(
        xi=0.03237542623298211, mu=0.08068603519992577, restitution=0.4615499467330675
    )
    zone = vi.zone(
        osc,
        vi.Pattern("RLRLRL", 3),
        (0.09023610433330607, 0.12536332064082698),
        (3.796325892057212, 8.245444543656742),
    )
    assert zone.closed
    assert len(zone.loops) > 40
    assert zone.search.steps < 400_000


def test_zones_at_resonances_of_higher_order():
    """With little damping zones are narrow near r = 1/n: the lattice has a line there."""
    osc = vi.Oscillator(
        xi=0.0007955433930108345,
        mu=0.002113611800647377,
        restitution=(0.5941015168197833, 0.24197750080170805),
    )
    zone = vi.zone(osc, "RLLL", (0.103, 0.1446), (0.522, 2.237))
    assert zone.search.lines == (20, 17)
    for place in [(0.1428466, 1.192865), (0.1429977, 1.185485), (0.1251348, 0.832701)]:
        assert zone.contains(*place)
        assert zone.motion(*place).stable


@pytest.mark.parametrize(
    ("system", "sides", "cycles", "point", "r", "clearance"),
    [
        # a unit that is its own mirror image, twice
        ((0.03961335609201366, 0.013106635893706881, 0.6603719614444107), "RLRL", 2,
         (0.802094545011187, 5.788495208803536),
         (0.85 * 0.802094545011187, 1.18 * 0.802094545011187),
         (0.5 * 5.788495208803536, 2 * 5.788495208803536)),
        # three times, where the whole pattern is its own mirror image as well
        ((0.24516080209640617, 0.002134883304171633, 0.9702722972066312), "RLRLRL", 3,
         (1.6261488493967327, 2.186038532704614),
         (1.2229467741992963, 1.8994678727852838), (0.9162012382583987, 4.815706056569196)),
        # a unit four times, with different walls
        ((0.004510901441748813, 0.022514025126847997, (0.9940599996759076, 0.6093083328261)), "RLRLRLRL", 4,
         (1.2094620599178056, 7.404070317111004),
         (1.1441692787236828, 1.3149803759704242), (4.075267979622953, 31.888401845873698)),
    ],
)  # fmt: skip
def test_a_motion_and_its_images_count_once(system, sides, cycles, point, r, clearance):
    """A motion numbered from another unit, or from one of its mirror image, is the same: loops differ."""
    xi, mu, restitution = system
    zone = vi.zone(
        vi.Oscillator(xi=xi, mu=mu, restitution=restitution),
        vi.Pattern(sides, cycles),
        r,
        clearance,
    )
    assert zone.count(*point) == 1
    boxes = np.array([[ring.min(axis=0), ring.max(axis=0)] for ring in zone.loops])
    for i, box in enumerate(boxes):
        assert not any(np.allclose(box, other, rtol=1e-7) for other in boxes[:i])
