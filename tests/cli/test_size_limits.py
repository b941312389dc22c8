"""Studies that are too large: the program and the Python calls refuse them with the same words."""

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact.base.errors import ParameterError

OSC = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
SYSTEM = "&system xi = 0.0114, mu = 0.028, restitution = 0.75, r = 1.04 /\n"
FREE = "&system xi = 0.0114, mu = 0.028, restitution = 0.75 /\n"


def diagram(values, sweep, points=64, **more):
    """A namelist and the equivalent call."""
    words = "".join(f", {name} = {value}" for name, value in more.items())
    text = (
        f"{SYSTEM}&bifurcation parameter = 'clearance', low = 20, high = 26, values = {values}, "
        f"sweep = '{sweep}', points = {points}{words} /\n"
    )
    return text, lambda: vi.bifurcation_diagram(
        OSC, "clearance", vi.spaced(20.0, 26.0, values), r=1.04, sweep=sweep, impacts=points, **more
    )


def response(r_points, states):
    text = (
        f"{FREE}&response clearance = 30, r_min = 0.9, r_max = 1.1, r_points = {r_points}, "
        f"states = {states} /\n"
    )
    return text, lambda: vi.response(OSC, np.linspace(0.9, 1.1, r_points), 30.0, states=states)


def exponents(values):
    text = f"{SYSTEM}&lyapunov parameter = 'clearance', low = 20, high = 26, values = {values} /\n"
    return text, lambda: vi.lyapunov(OSC, 1.04, vi.spaced(20.0, 26.0, values))


def plane(n, m):
    text = (
        f"{SYSTEM}&basins clearance = 30, axes = 'x', 'x_dot', low = -9, -9, high = 9, 9, "
        f"values = {n}, {m} /\n"
    )
    return text, lambda: vi.basins(OSC, 1.04, 30.0, (("x", -9, 9, n), ("x_dot", -9, 9, m)))


def chart(sides, r_points, clearance_points, **more):
    r, clearance = np.linspace(0.9, 1.1, r_points), np.linspace(5, 50, clearance_points)
    words = "".join(f", {name} = {value}" for name, value in more.items())
    text = (
        f"{FREE}&chart sides = '{sides}', r_min = 0.9, r_max = 1.1, r_points = {r_points}, clearance_min = 5, "
        f"clearance_max = 50, clearance_points = {clearance_points}{words} /\n"
    )
    return text, lambda: vi.chart(OSC, sides, r, clearance, **more)


def random_states(states):
    text = f"{SYSTEM}&basins clearance = 30, states = {states} /\n"
    return text, lambda: vi.basins(OSC, 1.04, 30.0, states=states)


# each exceeds the limit by one
@pytest.mark.parametrize(("doors", "words"), [
    (diagram(1_000_001, "up", 1), "must be a whole number with 2 <= values <= 1000000"),
    (diagram(12_501, "up", 1000), "values x runs x points must be at most 12500000"),
    (diagram(6251, "both", 1000), "values x runs x points must be at most 12500000"),
    (diagram(12_501, "states", 100, states=10), "values x runs x points must be at most 12500000"),
    (response(12_501, 1000), "r_points x states must be at most 12500000"),
    (response(1_000_001, 1), "must be a whole number with 2 <= r_points <= 1000000"),
    (exponents(1_000_001), "must be a whole number with 2 <= values <= 1000000"),
    (plane(3126, 4000), "together at most 12500000 states"),
    (random_states(12_500_001), "must be a whole number with 1 <= states <= 12500000"),
])  # fmt: skip
def test_both_doors_refuse(doors, words, batch):
    text, call = doors
    done = batch.case(text)
    assert (done.status, words in str(done)) == (2, True), done
    with pytest.raises(ParameterError) as caught:
        call()
    # in a call, the number of impacts has its own name
    assert str(caught.value).replace("impacts", "points").endswith(words)


@pytest.mark.parametrize("doors", [diagram(12_500, "up", 1000), diagram(6250, "both", 1000)])
def test_the_limit_itself_is_allowed(doors, batch):
    """A size at the limit is accepted, so that the error is another one (z = 99)."""
    text, _ = doors
    done = batch.case(text[:-3] + ", z = 99 /\n")
    assert done.status == 2
    assert "z - x must be within half the clearance" in str(done)


def test_limits_of_charts(batch, tmp_path):
    """Points x slots x impacts are limited; if all motions are equispaced, they need no slots."""
    words = "points x slots x impacts must be at most 12500000"
    for sides, most, slots in (("RL", 892, 7), ("RRLL", 625, 5), ("RRL", 1000, 4)):
        read_chart(tmp_path, sides, most, slots, "both")
    for sides, points, slots in (("RL", 893, 7), ("RRLL", 626, 5), ("RRL", 834, 5)):
        text, call = chart(sides, points, 1000, slots=slots)
        done = batch.case(text)
        assert (done.status, words in str(done)) == (2, True), done
        with pytest.raises(ParameterError) as caught:
            call()
        assert str(caught.value).endswith(words)
    read_chart(tmp_path, "RL", 1000, 32, "yes")


def read_chart(folder, sides, points, slots, symmetric):
    """A namelist that is accepted when it is read."""
    text, _ = chart(sides, points, 1000, slots=slots, symmetric=f"'{symmetric}'")
    path = folder / "case.nml"
    path.write_text(text)
    (case,) = vi.read_namelist(path)
    assert f"r_points = {points}" in case.text
