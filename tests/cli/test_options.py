"""Options and what is said about them: in the words that were typed, and never screens of it."""

import pytest
import vibroimpact as vi
from programs import SYSTEM, Runner, find_command

EQUAL = ["--xi", ".0114", "--mu", ".028", "--restitution", ".75"]


@pytest.fixture
def tool(tmp_path):
    """Runner of `vibroimpact` in a folder of its own."""
    return Runner([find_command()], tmp_path)


@pytest.mark.parametrize(
    "group", ["zone sides = 'RL',", "atlas", "chart sides = 'RL', r_points = 3,"]
)
def test_reversed_windows_name_both_ends(group, batch):
    """Who gave two numbers the wrong way round is told both."""
    window = f"&{group} r_min = 1.2, r_max = 0.8, clearance_min = 2, clearance_max = 200 /\n"
    done = batch.case("&system xi = 0.1, mu = 0.1, restitution = 0.7 /\n" + window)
    assert (done.status, len(done.faults)) == (2, 1)
    assert "r_max = 0.8" in done.faults[0]
    assert "; r_min is 1.2" in done.faults[0]
    done = batch.case("&system xi = 0.1, mu = 0.1, restitution = 0.7 /\n" + window.replace("1.2", "0.7", 1)
                      .replace("= 200", "= 1"))  # fmt: skip
    assert "clearance_max = 1" in done.faults[0]
    assert "; clearance_min is 2" in done.faults[0]


@pytest.mark.parametrize("text", [
    "x" * 100_000, "&system xi = " + "7" * 100_000 + " /\n&simulate /\n", "&" + "q" * 50_000 + " /\n",
    SYSTEM + "&motion sides = 'R" + "L" * 30_000 + "' /\n", "&system mu = '" + "v" * 100_000])  # fmt: skip
def test_a_long_line_is_not_echoed(text, batch):
    """What is wrong is still said, with the file and the beginning of the line."""
    done = batch.case(text)
    assert (done.status, len(done.faults)) == (2, 1)
    assert len(done.err) < 700
    assert done.faults[0].startswith("case.nml:")
    assert (
        text[:10] in done.faults[0] or "sides = 'RLLL" in done.faults[0] or "mu" in done.faults[0]
    )


def test_plane_outside_of_the_walls(tool):
    """The plane is named, and what its y may be."""
    plane = ["--plane", "x", "-9", "9", "5", "y", "-9", "8", "5"]
    done = tool("basins", *EQUAL, "--r", "1", "--clearance", "9", *plane)
    assert (done.status, len(done.faults)) == (2, 1)
    assert "plane: y from -9 to 8: must be within half the clearance, -4.5 to 4.5" in done.faults[0]


@pytest.mark.parametrize("threads", [0, -1, 1025, 1.5, True])
def test_threads_of_an_atlas(threads):
    """As everywhere else: a whole number of at least one."""
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    with pytest.raises(
        (vi.errors.ParameterError, vi.errors.ParameterTypeError), match="threads = "
    ):
        vi.atlas(osc, (1.0, 1.1), (20, 60), threads=threads)
