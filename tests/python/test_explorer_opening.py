"""The explorer starts from a saved result: a motion at its point, or a design with its box of tolerances."""

import signal
from urllib.parse import urlsplit

import pytest
import vibroimpact as vi
from shared_design import short_searches
from shared_motions import rest_motion
from vibroimpact.base.errors import ParameterError, ParameterTypeError
from vibroimpact.commands.command import main
from vibroimpact.explorer.explorer import Explorer
from vibroimpact.explorer.opening import state_of
from vibroimpact.explorer.process import start
from vibroimpact.explorer.state import Box, State

RIG = vi.Oscillator.from_dimensional(
    M=2.7, K=42e3, C=7.7, m=0.11, restitution=(0.75, 0.7), F0=6.0, units="m N s"
)


@pytest.fixture(scope="module")
def motion():
    """A stable motion of the rig."""
    return next(m for m in vi.find(RIG, 0.94, 37.0) if m.stable)


@pytest.fixture(scope="module")
def made():
    """A design of the rig with tolerances of clearance and restitution, and loads that vary."""
    with short_searches():
        return vi.design(
            RIG, r=(1.0, 1.02), free={"clearance": (25, 40)}, load=(0.9, 1.1), limit=0.5, evaluations=8,
            tolerance={"clearance": (-2, 3), "restitution": (0.7, 0.8)}, specimens=4, nodes=3, samples=0,
        )  # fmt: skip


def shown(state):
    """The explorer in a state that was passed through a link."""
    again, faults = State.read(state.query)
    explorer = Explorer(again)
    assert faults + explorer.restore() == []
    return explorer


def test_a_motion_is_chosen_at_its_point(motion):
    """The chosen motion is the saved one, in the units of the rig; its pattern has a zone."""
    explorer = shown(state_of(motion))
    state = explorer.state
    assert (state.r, state.clearance, state.osc) == (motion.r, motion.clearance, RIG)
    assert state.units == RIG.units()
    assert vi.same_motion(explorer.chosen.motion, motion)
    assert explorer.chosen.motion.attenuation == pytest.approx(motion.attenuation, rel=1e-12)
    assert state_of(motion.physical("mm N s")).units == RIG.units().to("mm N s")


def test_a_motion_outside_the_window_or_with_rest_is_shown():
    """The window contains the point, with a margin; a motion with rest is shown by one of its states."""
    far = vi.equispaced(vi.Oscillator(xi=0.02, mu=0.05, restitution=0.8), 2.5, 0.5)[0]
    state = state_of(far)
    assert state.r_min < 2.2 < 2.8 < state.r_max
    assert state.clearance_min < 0.25 < 1 < state.clearance_max
    rest = rest_motion()
    explorer = shown(state_of(rest))
    assert vi.same_motion(explorer.chosen.motion, rest)
    assert explorer.state.units is None


def test_a_load_is_part_of_the_units(motion):
    """A motion at twice the load is shown at half the d K/F0, with the same d and displacement in mm."""
    double = vi.exact(RIG, motion.r, 2 * motion.clearance, motion, load=2.0)
    state = state_of(double)
    units = double.physical("mm N s").units
    assert state.clearance == pytest.approx(motion.clearance)
    scale = state.units.to("mm N s")
    assert state.clearance * scale.length == pytest.approx(double.clearance * units.length)
    chosen = shown(state).chosen.motion
    assert chosen.x_max * scale.length == pytest.approx(double.x_max * units.length)


def test_a_design_has_its_box(made):
    """The box is the band and the clearances of all units and loads; other parameters have their middle value."""
    state = state_of(made)
    chosen = made.values["clearance"]
    (r0, r1), (low, high) = state.box.ends
    assert (r0, r1) == pytest.approx((1.0, 1.02))
    assert low == pytest.approx((chosen - 2) / 1.1)
    assert high == pytest.approx((chosen + 3) / 0.9)
    assert (state.R1, state.R2, state.limit) == pytest.approx((0.75, 0.75, 0.5))
    assert (state.r, state.clearance) == (state.box.r, state.box.clearance)
    assert state.units == RIG.units()
    assert State.read(state.query) == (state, [])


def test_what_cannot_be_shown_is_named(motion, capsys, short):
    """Other results, a load of 0, free vibration and missing files give one message each."""
    with pytest.raises(
        ParameterTypeError,
        match="must be an Oscillator, a Motion of one, an Identification or a Design",
    ):
        state_of(3)
    with pytest.raises(ParameterError, match=r"load = 0\.0 of the motion: must not be 0"):
        state_of(motion.__replace__(load=0.0))
    damped = vi.design(
        RIG, target="damping", amplitude=(5, 20), free={"clearance": (2, 10)}, evaluations=8, specimens=2,
        nodes=2, samples=0, r=None,
    )  # fmt: skip
    with pytest.raises(ParameterError, match="target = 'damping' of the design"):
        state_of(damped)
    for words in (["none.json"], ["--units", "2.7 42000"]):
        assert main(["explore", "--no-browser", "--port", "0", *words]) == 2
        out, err = capsys.readouterr()
        assert (out, err.count("\n")) == ("", 1)
        assert words[-1].split()[0] in err


@pytest.mark.parametrize(
    ("rig", "law", "message"),
    [({"harmonics": (0.1,)}, "constant", "load of the identification: must be a sine"),
     ({}, "table", "law = 'table' of the identification: must be 'constant'")],
)  # fmt: skip
def test_what_an_identification_has_beyond_the_explorer_is_named(rig, law, message):
    """A load with harmonics and a law of restitution have different messages."""
    pytest.importorskip("scipy")
    bench = vi.VirtualRig(
        M=2.7, K=42e3, m=0.11, d=0.006, xi=0.01143, restitution=0.7, F0=6.0, frequency=19.5, **rig
    )
    found = vi.identify(bench.record(2.0, rng=1), known={"M": 2.7, "K": 42e3, "m": 0.11}, law=law)
    with pytest.raises(ParameterError, match=message):
        state_of(found)


def test_the_command_opens_a_file(page, motion, tmp_path):
    """`vibroimpact explore FILE` gives the address of a page with the point marked and the motion chosen."""
    path = tmp_path / "motion.json"
    motion.save(path)
    process, url = start(str(path), "--units", "2.7 42000 6 SI")
    process.send_signal(signal.SIGINT)
    assert process.communicate(timeout=20)[1] == ""
    page.open(urlsplit(url).query)
    assert page.text("fault") == ""
    assert (page.field("r"), page.field("clearance")) == ("0.94", "37")
    assert page.data("zones.point", "x") + page.data("zones.point", "y") == [0.94, 37.0]
    chosen = page.page.locator("#table tr.chosen td").all_inner_texts()
    assert chosen[2] == f"{motion.attenuation:.6g}"
    x, t = page.curve("history", "x")[1], page.curve("history", "x")[0]
    assert max(x) == pytest.approx(motion.x_max, rel=1e-3)
    assert max(t) == pytest.approx(2)


def test_a_design_opens_with_its_box(page, made, tmp_path):
    """The page of a saved design draws its box, and applies the limit of the design."""
    path = tmp_path / "design.json"
    made.save(path)
    state = state_of(vi.load(path))
    assert state == state_of(made)
    page.open(state.query)
    ends = [page.data("zones.box", name)[0] for name in ("left", "right", "bottom", "top")]
    assert ends == pytest.approx([end for pair in state.box.ends for end in pair])
    assert page.field("limit") == "0.5"
    assert "of 400 points have max|X|/A ≤ 0.5" in page.text("boxed")


def test_an_identified_motion_opens_on_its_chart(page, tmp_path):
    """The identified motion is chosen at its point, in the units of the rig of the record."""
    pytest.importorskip("scipy")
    # with exact sensors, lengths and loads have the same scale
    rig = vi.VirtualRig(
        M=2.7, K=42e3, m=0.11, d=0.006, xi=0.01143, restitution=(0.75, 0.65), F0=6.0, frequency=19.5
    )  # fmt: skip
    found = vi.identify(rig.record(rng=1), known={"M": 2.7, "K": 42e3, "m": 0.11}, calibration=0)
    found.save(tmp_path / "found.json")
    state = state_of(vi.load(tmp_path / "found.json"))
    assert vi.same_motion(shown(state).chosen.motion, found.motion)
    page.open(state.query)
    assert page.text("fault") == ""
    assert float(page.field("r")) == found.r
    assert page.data("zones.point", "y") == [state.clearance]
    assert state.clearance == pytest.approx(found.clearance, rel=1e-12)
    chosen = page.page.locator("#table tr.chosen td").all_inner_texts()
    assert chosen[0].strip() == "3/1 RLL"
    assert chosen[2] == f"{found.motion.attenuation:.6g}"
    assert f"({found.frequency:.5g} Hz)" in page.text("place")
    d = found.clearance * found.oscillator.units().length
    assert d == pytest.approx(found.d, rel=1e-12)
    assert f"(d = {1e3 * d:.5g} mm)" in page.text("place")
    peak = found.motion.physical().quantities().x.peak
    assert f"max|X| = {1e3 * peak:.4g} mm " in page.text("physical")
    still = vi.VirtualRig(
        M=2.7, K=42e3, m=0.11, d=0.5, xi=0.01143, restitution=(0.75, 0.65), F0=6.0, frequency=19.5
    )  # fmt: skip
    none = vi.identify(still.record(rng=1), known={"M": 2.7, "K": 42e3, "m": 0.11})
    with pytest.raises(ParameterError, match="of the identification: must be 'periodic'"):
        state_of(none)
    law = vi.identify(rig.record(rng=1), known={"M": 2.7, "K": 42e3, "m": 0.11}, law="power")
    with pytest.raises(ParameterError, match="law = 'power' of the identification: must be"):
        state_of(law)


def test_a_box_out_of_range_is_named():
    """A box that reaches zero, or the resonance without damping, is refused by name."""
    for words in ((1, 20, 1, 1), (1, 20, 0.1, 20), (1, 20, -0.1, 1), (-1, 20, 0.1, 1)):
        with pytest.raises(ParameterError, match="of the box"):
            Box(*map(float, words))
    with pytest.raises(ParameterError, match="must not contain 1 when xi = 0"):
        State(xi=0.0, r_min=1.1, r_max=1.5, r=1.2, box=Box(1.0, 20.0, 0.1, 1.0))
