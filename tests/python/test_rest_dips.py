"""Rests in which the contact force falls to zero briefly: the contact opens and closes again at once.

The letter ends there, and another one of the same wall begins. The systems were found by simulating random
ones at low frequency, where the free vibration of the primary mass lets the force fall several times a cycle.
"""

import numpy as np
import pytest
import shared_audit
import vibroimpact as vi

CASES = {
    "R*L*L*": (0.02522752839922839, 0.5164270411909851, (0.10944265493251046, 0.26996049126028554),
               0.10709056705508135, 0.04491044370753087),
    "LLR*R*": (0.06434235618670925, 0.17625804816778212, (0.025871788600487732, 0.5831663381659735),
               0.11953935513853389, 0.9905333519097683),
    "L*R*R*L*": (0.03177283013049195, 0.09217698211732823, (0.42972649692212583, 0.1751538135675721),
                 0.1414843600010459, 0.23263411521285673),
}  # fmt: skip


@pytest.fixture(scope="module")
def motions():
    """The motion on which each system settles; the primary mass starts in the middle with a velocity."""
    found = {}
    for sides, (xi, mu, walls, r, clearance) in CASES.items():
        osc = vi.Oscillator(xi=xi, mu=mu, restitution=walls)
        speed = 0.5 / np.hypot(1 - r**2, 2 * xi * r)
        state = {"t": 0, "x": 0, "x_dot": speed, "z": 0, "z_dot": 0}
        found[sides] = vi.exact(
            osc, r, clearance, vi.simulate(osc, r, clearance, 8, state, discard=300)
        )
    return found


@pytest.mark.parametrize("sides", CASES)
def test_letters(motions, sides):
    """A rest that follows a release from the same wall is a separate letter."""
    motion = motions[sides]
    letters = motion.pattern.symbols
    assert any(letters[i - 1] == letters[i] and "*" in letters[i] for i in range(len(letters)))
    turns = {"".join(letters[j:] + letters[:j]) for j in range(len(letters))}
    assert sides in turns
    assert motion.residual < 1e-9
    events = motion.events
    assert (events["kind"] == "stick").sum() == sum("*" in letter for letter in letters)


@pytest.mark.slow
def test_verdicts_by_an_independent_simulation(motions):
    """Each motion returns to itself, and has the multipliers and verdict of its stroboscopic map."""
    report = shared_audit.Audit()
    report.claims(list(motions.values()))
    assert report.findings == []
    assert report.counts["returns", True] == len(motions)
    assert report.counts["stable", True] > 0
