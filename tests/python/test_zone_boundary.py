"""The boundaries of zones of many patterns: laws, a search, and simulation next to them."""

import json

import numpy as np
import pytest
import vibroimpact as vi
from first_principles import System, impact_jacobians, mismatch, velocities
from shared_motions import searched
from shared_systems import FIGURE6, RIG
from shared_zones import WINDOW, distance, random_points
from vibroimpact.motions.exact import newton
from vibroimpact.motions.likeness import is_symmetric
from vibroimpact.studies.geometry import signed_area

CASES = [
    (FIGURE6, "RL", True), (FIGURE6, "RL", False), (FIGURE6, "RRL", False), (FIGURE6, "RRLL", True),
    (FIGURE6, "RRLL", False), (FIGURE6, "RRRL", False), (RIG, "RL", False), (RIG, "RLL", False),
]  # fmt: skip


@pytest.fixture(scope="module", params=CASES, ids=lambda c: f"{c[1]}-{c[2]}-{c[0].restitution[1]}")
def case(request):
    osc, sides, symmetric = request.param
    return vi.zone(osc, vi.Pattern(sides), *WINDOW, symmetric=symmetric)


def test_zones_against_a_search(case):
    """A zone contains exactly the points at which a search finds a stable, admissible motion of its family.

    A search from few guesses can miss a motion, so that one from many guesses decides.
    """
    r, clearance = random_points(60, 2)
    for a, b in zip(r.tolist(), clearance.tolist(), strict=True):
        inside = bool(case.contains(a, b))
        found = any(
            inside
            == any(
                motion.stable and motion.admissible and is_symmetric(motion) == case.symmetric
                for motion in searched(case.osc, a, b, case.pattern, guesses)
            )
            for guesses in (64, 1024)
        )
        assert found or distance(case, a, b) < 1e-6, (a, b)


def test_vertices_meet_their_condition(case):
    """Vertices meet their conditions on the multipliers, computed from the impact laws without iteration.

    Products over all multipliers are smooth where two of them meet; the multipliers themselves are not.
    """
    assert case.closed
    letters = "".join(case.pattern.symbols)
    walls = tuple(case.osc.restitution["RL".index(side)] for side in letters)
    identity, checked = np.eye(4), 0
    for piece in case.boundary:
        for j in range(0, len(piece), max(1, len(piece) // 20)):
            if piece.type not in ("fold", "pitchfork", "flip", "neimark_sacker"):
                continue
            system = System(
                case.osc.xi, case.osc.mu, piece.r[j], letters, case.pattern.cycles, walls
            )
            x, theta = piece.x_over_D[:, j], piece.theta[:, j]
            phases = theta - theta[0]
            forced = (
                system.amplitude
                / piece.clearance[j]
                * np.array([np.cos(theta[0]), np.sin(theta[0])])
            )
            _, _, x_dot, _, z_dot = velocities(system, phases, x)
            parts = impact_jacobians(system, phases, x, x_dot, z_dot, *forced)
            monodromy = np.linalg.multi_dot(parts[::-1])
            if piece.type == "neimark_sacker":
                multipliers = np.linalg.eigvals(monodromy)
                value = np.prod(
                    [1 - a * b for i, a in enumerate(multipliers) for b in multipliers[:i]]
                )
            else:
                value = np.linalg.det(monodromy + (1 if piece.type == "flip" else -1) * identity)
            assert np.abs(mismatch(system, phases, x, *forced)).max() < 1e-13
            assert abs(value) < 1e-12
            checked += 1
    assert checked >= 40  # 20 of each piece


def test_pieces_join_in_closed_rings(case):
    for loop, ring in enumerate(case.loops):
        pieces = [p for p in case.boundary if p.loop == loop]
        for one, other in zip(pieces, pieces[1:] + pieces[:1], strict=True):
            assert abs(one.r[-1] - other.r[0]) < 1e-9
            assert abs(one.clearance[-1] / other.clearance[0] - 1) < 1e-9
        assert len(ring) > 3
        assert np.isfinite(ring).all()
        assert signed_area(np.c_[ring[:, 0], np.log(ring[:, 1])]) != 0
    assert case.area > 0


def test_corners_meet_both_conditions(case):
    """Where two pieces meet, the conditions of both are met."""
    names = {"fold", "flip", "neimark_sacker", "window"}
    checked = 0
    for piece in case.boundary:
        for other in case.boundary:
            same = (piece.r[-1], piece.clearance[-1]) == (other.r[0], other.clearance[0])
            if piece is other or piece.loop != other.loop or not same:
                continue
            assert (piece.type, piece.detail) != (other.type, other.detail)
            for kind, there in ((piece, len(piece) - 1), (other, 0)):
                if kind.type == "window":
                    values = {*case.r} if kind.detail.endswith(" r") else {*case.clearance}
                    value = kind.r[there] if kind.detail.endswith(" r") else kind.clearance[there]
                    assert min(abs(value / bound - 1) for bound in values) < 1e-12
            if not {piece.type, other.type} <= names:
                continue
            # from the phases: at a fold r and D determine a motion only to the square root of rounding
            phases = piece.theta[:, -1] - piece.theta[0, -1]
            try:
                motion = vi.periodic(case.osc, piece.r[-1], phases, case.pattern)
            except vi.errors.SingularError:  # equispaced phases do not determine the clearance
                continue
            assert abs(motion.clearance / piece.clearance[-1] - 1) < 1e-9
            multipliers = motion.multipliers
            pairs = [1 - a * b for i, a in enumerate(multipliers) for b in multipliers[:i]]
            zero = {
                "fold": np.prod(1 - multipliers),
                "flip": np.prod(1 + multipliers),
                "neimark_sacker": np.prod(pairs),
                "window": 0.0,
            }
            assert abs(zero[piece.type]) < 1e-7
            assert abs(zero[other.type]) < 1e-7
            checked += 1
    assert checked or case.pattern.sides == "RL"


def test_impacts_follow_each_other(case):
    """No flight has a negative duration; solutions with such flights are not motions."""
    for piece in case.boundary:
        assert (np.diff(piece.theta, axis=0) > 0).all()
        assert (piece.theta[-1] - piece.theta[0] < 2 * np.pi * case.pattern.cycles).all()


def test_file_and_repetition(case):
    again = vi.Zone.from_dict(json.loads(json.dumps(case.to_dict())))
    assert again.to_dict() == case.to_dict()
    twice = vi.zone(case.osc, case.pattern, *WINDOW, symmetric=case.symmetric)
    assert json.dumps(twice.to_dict()) == json.dumps(case.to_dict())


GRAZING = [
    (vi.Oscillator(xi=0.05, mu=0.3, restitution=0.6), vi.Pattern("RRL"), (0.8, 1.2), (2, 200)),
    (vi.Oscillator(xi=0.05, mu=0.3, restitution=0.6), vi.Pattern("RL", 3), (0.3, 0.7), (0.5, 50)),
    (FIGURE6, vi.Pattern("RL"), (0.3, 0.7), (0.5, 50)),
    (RIG, vi.Pattern("RRLL"), (0.3, 0.7), (0.5, 50)),
]


def letters_from(motion, cycles):
    """Sides of the impacts of a simulation that starts just after the first impact of a motion."""
    state = {
        "t": motion.load_phase / motion.r, "x": motion.X[0], "x_dot": motion.X_dot_after[0],
        "z": motion.Z[0], "z_dot": motion.Z_dot_after[0],
    }  # fmt: skip
    run = vi.simulate(motion.osc, motion.r, motion.clearance, cycles, state=state)
    return "".join(run.events["side"][run.events["kind"] == "impact"].tolist())


@pytest.mark.parametrize(("osc", "pattern", "r", "clearance"), GRAZING)
def test_grazing_pieces_against_simulation(osc, pattern, r, clearance):
    """Inside a grazing piece a simulation keeps the pattern; outside it there is one impact more."""
    zone = vi.zone(osc, pattern, r, clearance)
    pieces = [p for p in zone.boundary if p.type == "grazing" and len(p) > 6]
    assert pieces
    n, k = len(pattern), pattern.cycles
    for piece in pieces:
        flight, side = int(piece.detail.split()[1]), piece.detail[-1]
        longer = pattern.sides[:flight] + side + pattern.sides[flight:]
        j = 3 * len(piece) // 4  # near an end there can be a fold, with motions on one side only
        for step in (np.array([1e-5, 0]), np.array([0, 1e-5])):
            verdicts = []
            for sign in (1, -1):
                a, b = np.array([piece.r[j], piece.clearance[j]]) * (1 + sign * step)
                motion = newton(
                    osc, a, b, 1.0, pattern, piece.x_over_D[:, j] * b, piece.theta[:, j]
                )
                assert motion.stable
                verdicts.append(motion.admissible)
                if motion.admissible:
                    letters = letters_from(motion, 200 * k)
                    wanted = (pattern.sides * 201)[1:]
                    assert letters == wanted[: len(letters)]
                    assert len(letters) >= 200 * n - 1
                else:
                    letters = letters_from(motion, k)
                    assert letters[:flight] == longer[1 : flight + 1]
                assert zone.contains(a, b) == motion.admissible
            assert sorted(verdicts) == [False, True]
