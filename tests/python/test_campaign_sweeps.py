"""Sweeps of campaigns: their cases and points, the group &sweep, and what is refused."""

import json

import numpy as np
import pytest
import vibroimpact as vi
from shared_campaign import SWEEP, command, equispaced_case, small_sweep

pytest.importorskip("zarr")


def test_cases_of_a_grid():
    """Each case is the template with its values, in the order of a C array."""
    sweep = small_sweep()
    assert sweep.shape == (3, 4)
    for i in range(len(sweep)):
        point = sweep.point(i)
        row, column = np.unravel_index(i, sweep.shape)
        assert point == {
            "system.r": [0.9, 1.0, 1.1][row], "motion.clearance": [5.0, 20.0, 80.0, 500.0][column],
        }  # fmt: skip
        (case,) = [vi.cases.case.case_of(sweep.text(i))]
        assert (case.r, case.keys["clearance"]) == (point["system.r"], point["motion.clearance"])


def test_a_key_that_the_template_lacks_is_added():
    """An optional key of a group may be swept."""
    sweep = vi.Sweep(equispaced_case(), {"acceptance": [0.01, 0.02]})
    assert sweep.text(1).count("acceptance = 0.02\n/") == 1


@pytest.mark.parametrize("method", ["sobol", "latin_hypercube"])
def test_points_fill_the_box(method):
    """Each of 64 equal parts of each side has one point; the logarithm of a geometric key is spread evenly."""
    sweep = vi.Sweep(
        equispaced_case(), {"r": (0.9, 1.1), "clearance": (2, 200)}, samples=64, method=method, rng=3,
        geometric=["clearance"],
    )  # fmt: skip
    unit = np.stack(
        [(sweep.points[:, 0] - 0.9) / 0.2, np.log(sweep.points[:, 1] / 2) / np.log(100)]
    )
    for side in unit:
        assert sorted(np.floor(side * 64).astype(int)) == list(range(64))
    again = vi.Sweep.of_record(json.loads(json.dumps(sweep.record)))
    np.testing.assert_array_equal(again.points, sweep.points)


def test_points_are_made_in_blocks(monkeypatch):
    """Blocks of any size, in any order, give the same points; a billion points are not stored."""
    box = {"r": (0.9, 1.1), "clearance": (2, 200)}
    whole = vi.Sweep(equispaced_case(), box, samples=1000, rng=3)
    points, texts = whole.points, [whole.text(i) for i in range(1000)]
    monkeypatch.setattr("vibroimpact.campaigns.sweep.BLOCK", 64)
    parts = vi.Sweep(equispaced_case(), box, samples=1000, rng=3)
    np.testing.assert_array_equal(parts.points, points)
    for i in (999, 0, 500, 63, 64, 128):
        assert parts.text(i) == texts[i]
    many = vi.Sweep(equispaced_case(), box, samples=10**9, rng=3)
    assert list(many.point(999).values()) == points[999].tolist()
    assert many.point(10**6) != many.point(10**6 + 1)
    with pytest.raises(vi.ParameterError, match="samples = 1073741824: must be"):
        vi.Sweep(equispaced_case(), box, samples=2**30, method="latin_hypercube")


@pytest.mark.parametrize("number", [-1, 12, 2**40, 1.0, None, [0]])
def test_numbers_without_a_case(number):
    """A case is accessed by its number, from 0."""
    wanted = r"number = .*: must be a whole number with 0 <= number <= 11"
    for ask in (small_sweep().point, small_sweep().text):
        with pytest.raises((vi.errors.ParameterError, vi.errors.ParameterTypeError), match=wanted):
            ask(number)


def test_a_huge_grid(tmp_path):
    """No object holds all cases: a campaign of 10^12 cases starts, stops, and reports its progress."""
    keys = {"xi": (0.001, 0.1), "mu": (0.01, 0.1), "r": (0.9, 1.1), "clearance": (2, 200)}
    sweep = vi.Sweep(
        equispaced_case(), {key: np.linspace(*ends, 1000) for key, ends in keys.items()}
    )
    assert len(sweep) == 10**12
    assert sweep.point(10**12 - 1) == {
        key: end for key, (_, end) in zip(sweep.keys, keys.values(), strict=True)
    }

    def stop(share, note):
        """Stop after the first chunk."""
        if share:
            raise RuntimeError(note)

    with pytest.raises(RuntimeError, match="of 1000000000000 cases"):
        vi.campaign(sweep, tmp_path / "store", chunk=4, threads=1, progress=stop)
    found = vi.Campaign(tmp_path / "store")
    assert 0 < found._done() <= 12
    assert f": {found._done()} of 1000000000000 cases finished" in repr(found)
    assert found[0].to_dict()
    with pytest.raises(vi.OutOfMemoryError, match=r"10{12} cases needs more memory"):
        found.values("motions", "attenuation")


@pytest.mark.parametrize(
    ("values", "options", "message"),
    [
        ({"xii": [1.0]}, {}, "'xii' is not a key of the case; must be one of system.xi, "),
        ({}, {}, "must be a mapping with at least one key"),
        ({"xi": []}, {}, "is empty; must have at least one value"),
        ({"xi": [0.1, 0.1]}, {}, "each value must occur once"),
        ({"xi": [0.1], "system.xi": [0.2]}, {}, "system.xi is given twice"),
        ({"xi": (0.1, 0.2, 0.3)}, {"samples": 4}, "must be two numbers"),
        ({"xi": (0.2, 0.1)}, {"samples": 4}, "must be two numbers with low < high"),
        ({"xi": (0.0, 0.1)}, {"samples": 4, "geometric": ["xi"]}, "0 < low < high"),
        ({"xi": (0.1, 0.2)}, {"samples": 4, "method": "halton"}, "'sobol' or 'latin_hypercube'"),
        ({"xi": (0.1, 0.2)}, {"samples": 0}, "samples = 0"),
        ({"xi": [0.1]}, {"geometric": ["xi"]}, "geometric: needs samples"),
        ({"xi": [float("nan")]}, {}, "nan must be a finite number"),
        ({"xi": (0.1, float("inf"))}, {"samples": 3}, "inf must be a finite number"),
        ({"xi": (0.1, 0.2)}, {"samples": 10**12}, "1 <= samples <= 1073741824"),
        ({"XI": [0.1]}, {}, "'XI' is not a key of the case"),
        ({"response.states": [3]}, {}, "'response.states' is not a key of the case"),
    ],
)
def test_bad_sweeps(values, options, message):
    """One error names the key and what is allowed."""
    with pytest.raises(vi.ParameterError) as caught:
        vi.Sweep(equispaced_case(), values, **options)
    assert message in str(caught.value)


@pytest.mark.parametrize("value", [True, None, 1j, object()])
def test_values_of_a_wrong_type(value):
    """A namelist can hold only numbers and texts."""
    with pytest.raises(vi.ParameterTypeError, match="values"):
        vi.Sweep(equispaced_case(), {"xi": [value]})


@pytest.mark.parametrize("geometric", ["xi", None, 3])
def test_geometric_is_a_sequence(geometric):
    """Take a text as an invalid value."""
    with pytest.raises(vi.ParameterTypeError, match="must be a sequence of keys"):
        vi.Sweep(equispaced_case(), {"xi": (0.1, 0.2)}, samples=2, geometric=geometric)


@pytest.mark.parametrize(
    "case",
    [
        "", "&system\n/\n", "&system xi = 1 /", "nonsense", equispaced_case().upper(),
        equispaced_case().replace("mu = ", "mu = 0.02 ! "), equispaced_case().replace("\n  mu", "  mu"),
        equispaced_case().replace("'equispaced'", "'equispaced' ! kind"),
        equispaced_case().replace("&motion", "&nonsense"),
    ],
)  # fmt: skip
def test_a_template_that_is_no_case(case):
    """The template must be complete and canonical."""
    with pytest.raises(vi.ParameterError, match="must be a complete case"):
        vi.Sweep(case, {"xi": [0.1]})


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("keys = 'xi'", "values: must be given, or words, or low and high"),
        ("keys = 'xi', low = 0.1", "high: must be given with low"),
        ("keys = 'xi', low = 0.1, high = 0.2", "counts: must be given"),
        (
            "keys = 'xi', 'mu', values = 0.1, 0.2, counts = 1, 2",
            "counts = [1, 2]: must be the number",
        ),
        ("keys = 'xi', 'mu', low = 1, 2, 3, high = 4", "low: has 3 values"),
        ("keys = 'xi', high = 4", "high"),
        (
            "keys = 'xi', values = 1\n/\n&sweep\n  keys = 'mu', values = 1",
            "&sweep: follows &sweep; must",
        ),
        ("keys = 'xi', values = nan", "nan"),
        ("keys = 'xi', 'system.xi', values = 1, 2, counts = 1, 1", "system.xi is given twice"),
        ("keys = 'xi', values = 1, samples = 3", "samples"),
    ],
)
def test_bad_groups(tmp_path, line, message):
    """Lists of a &sweep that do not fit together are refused."""
    path = tmp_path / "bad.nml"
    path.write_text(SWEEP.split("&sweep")[0] + f"&sweep\n  {line}\n/\n")
    process = command(path, "--store", tmp_path / "store")
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 2
    assert message in errors
    assert not (tmp_path / "store").exists()


def test_a_sweep_after_the_output(tmp_path):
    """The error names the place of the group."""
    path = tmp_path / "bad.nml"
    path.write_text(SWEEP.replace("&sweep", "&output name = 'a' /\n&sweep"))
    with pytest.raises(vi.ParameterError, match="follows &output; must occur once"):
        vi.read_namelist(path)


@pytest.mark.parametrize(
    ("line", "values"),
    [
        ("keys = 'xi', 'r', values = 0.1, 0.2, 0.9, 1, 1.1, counts = 2, 3",
         {"xi": [0.1, 0.2], "r": [0.9, 1.0, 1.1]}),
        ("keys = 'xi', values = 0.1, 0.2", {"xi": [0.1, 0.2]}),
        ("keys = 'precision', words = 'single', 'double'", {"precision": ["single", "double"]}),
        ("keys = 'r', low = 0.9, high = 1.1, counts = 3", {"r": vi.spaced(0.9, 1.1, 3)}),
        ("keys = 'xi', low = 0.001, high = 0.1, counts = 3, spacing = 'geometric'",
         {"xi": vi.spaced(0.001, 0.1, 3, "geometric")}),
    ],
)  # fmt: skip
def test_groups_are_sweeps(tmp_path, line, values):
    """A &sweep gives the cases of the same sweep in Python."""
    path = tmp_path / "sweep.nml"
    path.write_text(SWEEP.split("&sweep")[0] + f"&sweep\n  {line}\n/\n")
    (case,) = vi.read_namelist(path)
    found = vi.Sweep.of_case(case)
    expected = vi.Sweep(found.template, values)
    assert len(found) == len(expected)
    assert [found.text(i) for i in range(len(found))] == [
        expected.text(i) for i in range(len(found))
    ]


def test_a_box_of_a_group(tmp_path):
    """Points of a &sweep are those of the same box in Python."""
    path = tmp_path / "sweep.nml"
    path.write_text(
        SWEEP.split("&sweep")[0]
        + "&sweep\n  keys = 'xi', 'r', low = 0.001, 0.9, high = 0.1, 1.1, samples = 8, "
        "method = 'latin_hypercube', seed = 5, spacing = 'geometric', 'linear'\n/\n"
    )
    found = vi.Sweep.of_case(vi.read_namelist(path)[0])
    expected = vi.Sweep(
        found.template, {"xi": (0.001, 0.1), "r": (0.9, 1.1)}, samples=8, method="latin_hypercube", rng=5,
        geometric=["xi"],
    )  # fmt: skip
    np.testing.assert_array_equal(found.points, expected.points)


def test_a_sweep_is_left_to_the_command(tmp_path):
    """The compiled program names the program that runs a &sweep, and writes nothing."""
    path, folder = tmp_path / "sweep.nml", tmp_path / "results"
    path.write_text(SWEEP)
    log = vi.run_namelists([path], folder)
    assert log.status == 1
    assert "vibroimpact campaign" in log.lines[0][1]
    assert not list(folder.glob("*.csv"))
