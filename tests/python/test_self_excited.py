"""Self-excited motions: no load, the period is unknown, and one multiplier is 1."""

import math

import numpy as np
import pytest
import vibroimpact as vi
from reference_regimes import ReferenceRegimes

BELT = {"slip": 0.6, "stick": 1.0, "speed": 0.2}


def bow(damping=0.0, mass=1.0, **belt):
    """A mass with a spring of stiffness 1 and a dashpot on a belt."""
    return vi.Structure([mass], [damping], [1.0], friction=[vi.Friction([1], **(BELT | belt))])


def self_excited(structure, duration=100.0, load=None):
    return vi.exact(structure, load, vi.simulate(structure, load, duration=duration))


#: Two coupled masses on a belt.
PAIR = vi.Structure(
    [1, 1.3], [[0.02, -0.01], [-0.01, 0.02]], [[2, -1], [-1, 2]],
    friction=[vi.Friction([1, 0], 0.5, 0.8, 0.3), vi.Friction([0, 1], 0.45, 0.7, 0.3)],
)  # fmt: skip


def matched_period(damping, mass=1.0, slip=0.6, stick=1.0, speed=0.2):
    """The time of a slip, from where the spring overcomes the stick level to where the mass is as fast as the belt
    again, in closed form with a bisection, and that in which the belt then carries the mass back."""
    sigma = damping / (2 * mass)
    w = math.sqrt(1 / mass - sigma**2)
    start = stick - damping * speed

    def at(t):
        """Place and speed from the slip level as the origin: y'' + 2 sigma y' + y/m = 0."""
        a, b = start - slip, (speed + sigma * (start - slip)) / w
        decay = math.exp(-sigma * t)
        y = decay * (a * math.cos(w * t) + b * math.sin(w * t))
        rate = decay * (
            (b * w - sigma * a) * math.cos(w * t) - (a * w + sigma * b) * math.sin(w * t)
        )
        return slip + y, rate

    low, high = 0.5 * math.pi / w, 2 * math.pi / w  # it comes back after more than half a vibration
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if at(middle)[1] < speed else (low, middle)
    return low + (start - at(low)[0]) / speed


@pytest.mark.parametrize(("damping", "mass", "speed"), [
    (0, 1, 0.2), (0.02, 1, 0.2), (0.1, 1, 0.2), (0.05, 2.5, 0.1),
])  # fmt: skip
def test_period_of_stick_and_slip(damping, mass, speed):
    """Stick and slip phases that are computed apart and matched."""
    motion = self_excited(bow(damping, mass, speed=speed))
    assert motion.period == pytest.approx(matched_period(damping, mass, speed=speed), rel=1e-13)
    if not damping and mass == 1:
        assert motion.period == pytest.approx(8.068887871591405, rel=1e-14)
    assert motion.self_excited
    assert motion.phases[0] == 0
    assert motion.multipliers[motion.trivial] == pytest.approx(1, abs=1e-12)
    assert np.abs(motion.multipliers[1 - motion.trivial]) < 1e-12  # what sticks
    assert motion.stable
    assert motion.admissible
    assert motion.law == 0


def test_two_masses_by_an_independent_program():
    """It returns after a period, and the traces of [P] are those of differences."""
    motion = self_excited(PAIR, 600)
    assert len({*motion.gaps.tolist()}) == 2
    _, (q, rate) = motion._run()._between_events()
    assert min(abs(rate - 0.3)) > 0.1  # both slip there
    reference = ReferenceRegimes(PAIR, None, 5e-3)
    state = np.concatenate([q, rate])

    def after(state):
        reference.simulate(motion.period, np.split(state, 2))
        return reference.final.copy()

    assert after(state) == pytest.approx(state, abs=1e-9)
    steps = 1e-6 * np.eye(4)
    P = np.transpose([(after(state + step) - after(state - step)) / 2e-6 for step in steps])
    found = [np.sum(motion.multipliers**k).real for k in (1, 2)]
    assert found == pytest.approx([np.trace(P), np.trace(P @ P)], abs=1e-6)


def test_exponents_are_logarithms_of_the_multipliers():
    """The trivial multiplier is the exponent 0."""
    motion = self_excited(PAIR, 600)
    others = np.sort(np.abs(np.delete(motion.multipliers, motion.trivial)))[::-1]
    found = vi.lyapunov(PAIR, vi.Load.none(), cycles=8000, discard=600)
    assert found.exponents[0] == pytest.approx(0, abs=1e-6)
    assert found.exponents[1:3] == pytest.approx(np.log(others[:2]) / motion.period, abs=1e-5)
    assert found.exponents[3] == -np.inf
    assert others[2] < 1e-12


def test_from_another_motion_and_under_a_constant_force():
    """A force moves the motion, without a change of the period; near motions are found from each other."""
    motion = self_excited(bow())
    load = vi.Load(constant=[0.3])
    pushed = vi.exact(bow(), load, vi.simulate(bow(), load, duration=60))
    assert pushed.period == pytest.approx(motion.period, rel=1e-13)
    assert pushed.states[:, 0] == pytest.approx(motion.states[:, 0] + 0.3, abs=1e-13)
    assert pushed.multipliers == pytest.approx(motion.multipliers, abs=1e-12)
    again = vi.exact(bow(0.02), vi.Load.none(), motion)
    assert again.period == pytest.approx(matched_period(0.02), rel=1e-13)
    q, rate = motion.sample([0.3, 0.3 + motion.period])
    assert q[:, 0] == pytest.approx(q[:, 1], abs=1e-12)
    assert rate[:, 0] == pytest.approx(rate[:, 1], abs=1e-12)


def test_files_and_namelists(tmp_path):
    motion = self_excited(PAIR, 600)
    motion.save(tmp_path / "motion.json")
    loaded = vi.load(tmp_path / "motion.json")
    assert loaded.period == motion.period
    assert loaded.trivial == motion.trivial
    assert np.array_equal(loaded.multipliers, motion.multipliers)
    case = tmp_path / "again.nml"
    case.write_text(motion.to_namelist())
    vi.run_namelists([case], tmp_path)
    rows = [
        line for line in (tmp_path / "again.csv").read_text().splitlines() if line[0] not in "#i"
    ]
    phases = [float(row.split(",")[2]) for row in rows]
    assert phases == motion.phases.tolist()
    vi.exact(PAIR, None, loaded)


def test_what_is_not_self_excited():
    """Sliding for ever, sticking for ever, no repetition, and other verbs, each by name."""
    with pytest.raises(vi.SingularError, match="a motion without impacts"):
        self_excited(bow(0.5))
    with pytest.raises(vi.SingularError, match="a rest that never ends"):
        self_excited(bow(speed=0.0), 10)
    with pytest.raises(vi.SingularError, match="does not repeat"):
        self_excited(bow(), 3 * 8.068887871591405 / 2)
    motion = self_excited(bow())
    with pytest.raises(vi.ParameterError, match="self-excited motions are not followed"):
        vi.branch(motion, "slip", bounds=(0.5, 0.7))
    with pytest.raises(vi.ParameterError, match="must be a Motion or a Trajectory"):
        vi.exact(bow(), vi.Load.none(), ([0.1], [0]))
    with pytest.raises(
        vi.ParameterError, match=r"load = <No load>: must be a load with a frequency"
    ):
        vi.basins(bow(), vi.Load.none(), states=3)
    with pytest.raises(vi.ParameterError, match="must have 2 coordinates"):
        vi.exact(PAIR, vi.Load.none(), motion)


@pytest.mark.parametrize(("load", "keys", "message"), [
    ("&load frequency = 1, cosine = 1 /", "duration = 50", "the &load has a frequency"),
    ("&load frequency = 1, cosine = 1 /", "period = 8", "the &load has a frequency"),
    ("", "", "it goes with a &load that has a frequency"),
    ("", "duration = 0", "must be a number with 0 < duration"),
    ("", "duration = 50 / &branch parameter = 'slip', low = .5, high = .7", "are not followed"),
])  # fmt: skip
def test_bad_namelists(tmp_path, load, keys, message):
    case = tmp_path / "case.nml"
    case.write_text(
        "&structure mass = 1, damping = 0, stiffness = 1 /\n"
        f"&friction direction = 1, slip = .6, stick = 1, speed = .2 /\n{load}\n"
        f"&motion kind = 'settled', {keys} /\n"
    )
    with pytest.raises(vi.ParameterError, match=message):
        vi.read_namelist(case)
