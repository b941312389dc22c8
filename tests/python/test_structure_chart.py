"""Charts of structures agree with those of the oscillator, zones, exact motions and simulations."""

import numpy as np
import pytest
import vibroimpact as vi

xarray = pytest.importorskip("xarray")

OSC = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
FREQUENCIES, OPENINGS = (0.9, 1.1), (5.0, 20.0)


@pytest.fixture(scope="module")
def motion():
    """The equispaced motion at r = 1.04, D = 25, as a motion of a structure."""
    point = OSC.at(1.04, 25.0)
    guess = vi.equispaced(OSC, 1.04, 25.0)[0]
    phases = guess.load_phase + np.array([0, np.pi])
    return vi.exact(point.structure, point.load, (phases, guess.gaps.tolist(), 1))


@pytest.fixture(scope="module")
def data(motion):
    return vi.chart(motion, ("frequency", *FREQUENCIES), ("opening", *OPENINGS), points=(9, 7))


def stable(data):
    return np.asarray(((data.admissible == 1) & (data.stable == 1)).any("motion"))


def test_the_two_masses_of_1983_have_the_chart_of_the_oscillator(data):
    """Motions, verdicts and leading multipliers of the closed form, at every point."""
    theirs = vi.chart(
        OSC, "RL", np.linspace(*FREQUENCIES, 9), 2 * np.linspace(*OPENINGS, 7), symmetric=True
    )
    np.testing.assert_allclose(data.x, theirs.r, rtol=1e-15)
    np.testing.assert_allclose(2 * data.y, theirs.clearance, rtol=1e-15)
    np.testing.assert_array_equal(stable(data), stable(theirs))
    assert 0 < stable(data).sum() < stable(data).size
    # the line of motions ends where an approach speed vanishes: only the closed form continues
    found = np.sort(np.where(data.status == 0, data.multiplier_modulus[0], np.inf), axis=0)
    known = np.sort(np.where(theirs.status == 0, theirs.multiplier_modulus[0], np.inf), axis=0)
    both = np.isfinite(found[0]) & stable(theirs)
    np.testing.assert_allclose(found[0][both], known[0][both], rtol=1e-8)


def test_values_need_not_be_evenly_spaced(motion):
    """Arrays with any spacing, rising or falling, give the chart of the oscillator at the same points."""
    r, gaps = [0.9, 0.97, 1.04, 1.1], np.geomspace(20.0, 5.0, 5)
    ours = vi.chart(motion, ("frequency", r), ("opening", gaps))
    theirs = vi.chart(OSC, "RL", r, 2 * gaps[::-1], symmetric=True)
    assert ours.x.values.tolist() == r
    assert ours.y.values.tolist() == gaps[::-1].tolist()
    np.testing.assert_array_equal(stable(ours), stable(theirs))
    assert 0 < stable(ours).sum() < stable(ours).size


def test_a_zone_is_where_the_chart_is_stable(motion, data):
    zone = vi.zone(motion, ("frequency", *FREQUENCIES), ("opening", *OPENINGS))
    x, y = np.meshgrid(data.x, data.y)
    inside = zone.contains(x, y)
    np.testing.assert_array_equal(inside[1:-1, 1:-1], stable(data)[1:-1, 1:-1])


def test_each_point_is_an_exact_motion_on_which_a_simulation_stays(motion, data):
    rng = np.random.default_rng(5)
    slots = np.argwhere(np.asarray(data.status == 0))
    stayed = 0
    for slot, row, column in rng.permutation(slots)[:12]:
        one = data.isel(motion=slot, y=row, x=column)
        point = OSC.at(float(one.x), 2 * float(one.y))
        exact = vi.exact(
            point.structure, point.load, (one.phases.values, one.gap.values.tolist(), 1)
        )
        np.testing.assert_allclose(exact.speeds, one.speeds, rtol=1e-9)
        modulus = abs(exact.multipliers)
        np.testing.assert_allclose(modulus[0], float(one.multiplier_modulus[0]), rtol=1e-6)
        assert int(one.admissible) == {True: 1, False: 0, None: -1}[exact.admissible]
        t = np.linspace(0, 2 * np.pi / point.r, 400)
        assert (exact.sample(t)[0].max(axis=1) <= one.q_max.values + 1e-9).all()
        if not (exact.admissible and exact.stable):
            continue
        start = exact.phases[0] / point.r
        run = vi.simulate(
            point.structure, point.load, cycles=200, state=(exact.q, exact.q_dot), start=start
        )
        np.testing.assert_allclose(
            np.sort(run.events["speed"][-2:]), np.sort(exact.speeds), rtol=1e-9
        )
        stayed += 1
    assert stayed > 1


def host():
    gaps = [vi.Gap([-1, 1], 0.5, 0.8), vi.Gap([1, -1], 0.5, 0.8)]
    structure, load = (
        vi.Structure([1, 0.1], [0.02, 0], [1, 0], gaps),
        vi.Load(1.1, sine=[0.1, 0]),
    )
    return vi.exact(structure, load, vi.simulate(structure, load, cycles=300))


@pytest.mark.parametrize("suffix", ["json", "nc"])
def test_files_and_namelists_give_it_back(suffix, tmp_path):
    motion = host()
    data = vi.chart(motion, ("frequency", 1.0, 1.2), ("load", 0.5, 1.5), points=5)
    namelist = tmp_path / "case.nml"
    namelist.write_text(data.attrs["case"])
    (case,) = vi.read_namelist(namelist)
    (again,) = case.run()
    assert repr(again) == "<Chart of 2 impacts: 5 values of frequency, 5 of load>"
    assert again.structure == motion.structure
    path = tmp_path / f"chart.{suffix}"
    again.save(path)
    for one in (again, vi.load(path)):
        xarray.testing.assert_equal(one.to_xarray(), data)


def test_a_function_is_a_parameter_too():
    motion = host()
    gaps, load = motion.structure.gaps, motion.load

    def heavier(p):
        return vi.Structure([1.1 - p, p], motion.structure.damping, [1, 0], gaps), load

    one = vi.chart(motion, (heavier, 0.05, 0.15), ("load", 0.8, 1.2), points=(3, 3), x_at=0.1)
    other = vi.chart(motion, ("frequency", 1.0, 1.2), ("load", 0.8, 1.2), points=(3, 3))
    # both grids have the motion itself in the middle
    np.testing.assert_allclose(
        one.multiplier_modulus[:, 0, 1, 1], other.multiplier_modulus[:, 0, 1, 1], rtol=1e-8
    )


def test_a_picture_shows_both_parameters(data):
    pytest.importorskip("matplotlib")
    from vibroimpact.plot import draw_chart

    ax = draw_chart(data, color="multiplier")
    assert ax.get_xlim() == pytest.approx((0.8875, 1.1125))
    for options in ({"inverse": True}, {"color": "attenuation"}):
        with pytest.raises(vi.ParameterError, match="of a structure"):
            draw_chart(data, **options)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"x": ("frequency", 1.2, 1.3)}, "the motion has frequency = 1.1"),
        ({"x": "frequency"}, "must be .parameter, .lo, hi.."),
        ({"y": ("frequency", 1.0, 1.2)}, "it changes the same parameter as x.0."),
        ({"points": 1}, "points"),
        ({"points": (5, 200)}, "points"),
    ],
)
def test_errors_name_the_parameter(change, message):
    motion = host()
    keys = {"x": ("frequency", 1.0, 1.2), "y": ("load", 0.5, 1.5), "points": 5}
    with pytest.raises((vi.ParameterError, vi.ParameterTypeError), match=message):
        vi.chart(motion, **keys | change)
    with pytest.raises(vi.ParameterTypeError, match="give its osc"):
        vi.chart(OSC.at(1, 2), "RL", [1, 2], [1, 2])
