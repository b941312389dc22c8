"""Elastic stops and dry friction: where they are refused, and files."""

import numpy as np
import pytest
import vibroimpact as vi
from shared_structures import written

STOP = ("stop", "stiffness = 1", "&stop direction = 1, opening = .5, {} /")
FRICTION = ("friction", "slip = 1", "&friction direction = 1, {} /")


def namelist(element, keys, study="simulate cycles = 1"):
    """A mass with the element, and a study."""
    return (
        f"&structure mass = 1, damping = .1, stiffness = 1 /\n{element[2].format(keys)}\n"
        f"&load frequency = 1, cosine = 1 /\n&{study} /\n"
    )


@pytest.mark.parametrize(("element", "keys", "message"), [
    (STOP, "stiffness = -1", "stiffness = -1: must be a number with 0 <= stiffness <= 1e100"),
    (STOP, "stiffness = 0", "stiffness"),
    (STOP, "damping = 1", "stiffness"),
    (STOP, "stiffness = 1, release = 'never'", "release"),
    (STOP, "stiffness = 1, restitution = .5", "restitution = .5: is not a key of &stop"),
    (STOP, "stiffness = 1, direction = 2", "was given before"),
    (("stop", "", STOP[2].replace("= 1,", "= 1, 2,")), "stiffness = 1", "direction"),
    (FRICTION, "slip = -1", "slip = -1: must be a number with 0 <= slip <= 1e100"),
    (FRICTION, "slip = 1, stick = .5", "stick = .5: must be a number from slip to 1e100"),
    (FRICTION, "stick = 1", "slip"),
    (FRICTION, "slip = 1, opening = .5", "opening = .5: is not a key of &friction"),
])  # fmt: skip
def test_bad_namelists(tmp_path, element, keys, message):
    with pytest.raises(vi.ParameterError) as caught:
        written(tmp_path, namelist(element, keys))
    assert message in str(caught.value)


GAP, PUSHING = vi.Gap([1.0], 3.0, 0.7), vi.Stop([1.0], 0.5, 20, 2, 0.1, "force")
SLIDING = [vi.Friction([1.0], 0.2, 0.3), vi.Friction([1.0], 0.05, speed=0.4)]


@pytest.mark.parametrize("ending", ["nc", "json", "mat"])
@pytest.mark.parametrize(("frequency", "gaps", "friction", "kinds"), [
    (1.3, [GAP, PUSHING, vi.Stop([-1.0], 0.6, 30)], [], {"touch", "leave", "let_go"}),
    (0.5, [GAP, PUSHING], SLIDING[:1], {"halt"}),
    (0.5, [], SLIDING, {"slip_up"}),
])  # fmt: skip
def test_files(tmp_path, frequency, gaps, friction, kinds, ending):
    """Each format keeps elements, their numbers and their events."""
    s = vi.Structure([1.0], [0.1], [1.0], gaps, friction)
    run = vi.simulate(s, vi.Load(frequency, cosine=[1.0]), cycles=5)
    assert kinds <= set(run.events["kind"])
    run.save(tmp_path / f"run.{ending}")
    again = vi.load(tmp_path / f"run.{ending}")
    assert again.structure == s
    assert np.array_equal(again.events, run.events)
    t = np.linspace(0, run.end, 40)
    assert np.array_equal(again.sample(t)[0], run.sample(t)[0])
