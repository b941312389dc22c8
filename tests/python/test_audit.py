"""Atlas, `find` and `exact` compared with an independent simulation of random systems.

`--audit-systems` and `--audit-points` set its size; `--audit-seed` draws other systems.
"""

import numpy as np
import pytest
import shared_audit
import vibroimpact as vi
from lane_simulation import CELLS, Lanes
from shared_simulations import STATE, state
from shared_systems import RIG

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def report(request, share):
    """The comparisons as a table, and every disagreement; two systems are enough for each check to occur."""
    systems, points, seed = (
        request.config.getoption(f"--audit-{name}") for name in ("systems", "points", "seed")
    )
    done = shared_audit.audit(min(systems, max(2, share(systems))), points, seed)
    print(done)
    return done


def disagreements(report, *checks):
    """The disagreements of some checks; the first check must have been made."""
    assert report.counts[checks[0], True] > 0
    return [str(finding) for finding in report.findings if finding.check in checks]


def test_lanes_are_the_simulation():
    """The independent simulation agrees with that of the package, state by state, with accumulation and rest."""
    draw = np.random.default_rng(7)
    r, clearance = draw.uniform(0.7, 1.3, 40), np.exp(draw.uniform(0, 4, 40))
    systems = shared_audit.systems_of([RIG] * 40, r, clearance)
    z, w = draw.uniform(-0.5, 0.5, 40) * clearance, draw.normal(size=40)
    lanes = Lanes(systems, 0.0, 0.0, z, w)
    lanes.run(2 * CELLS)
    assert not lanes.failed.any()
    rests = 0
    for i in range(40):
        run = vi.simulate(RIG, r[i], clearance[i], 2, state(z=z[i], z_dot=w[i]))
        rests += (run.events["kind"] == "stick").sum()
        end = [run.final_state[name] for name in STATE[1:]]
        assert lanes.state()[i] == pytest.approx(end, abs=1e-9 * clearance[i])
    assert rests > 0


def test_exact_is_the_attractor(report):
    """From the package's simulation, `exact` has the phases and states of the independent orbit, to 1e-8."""
    assert disagreements(report, "exact", "admissible") == []


def test_verdicts_are_those_of_the_stroboscopic_map(report):
    """`stable` and the leading multiplier agree with central differences with Richardson's step."""
    assert disagreements(report, "stable", "multiplier") == []


def test_simulation_denies_no_motion(report):
    """Each motion returns to itself; after a change of 1e-6 it comes back only if it is stable."""
    assert disagreements(report, "returns", "stays", "leaves") == []


def test_find_lists_every_attractor(report):
    """At every eighth point `find` lists each attractor within its limits."""
    assert disagreements(report, "find") == []


def test_zones_hold_stable_motions_alone(report):
    """At a random point inside each zone `find` lists the motion, and a simulation stays on it."""
    assert disagreements(report, "zone") == []


def test_undecided_verdicts_are_rare(report):
    """`stable` is None only near a bifurcation, where rounding hides the side of the unit circle."""
    assert report.undecided == []


def test_atlas_contains_every_attractor(report):
    """Each attractor within the limits and farther than 1e-4 from a boundary lies in a zone of its pattern."""
    assert disagreements(report, "atlas") == []
