"""Records of virtual rigs with dry friction in the slot."""

import pytest
import vibroimpact as vi

pytest.importorskip("scipy")
from shared_identify import BENCH

#: A motion R, L, L with reversals of slip between both impacts on L.
RUBBING = BENCH | {"friction": 0.05}


def test_friction_of_a_virtual_rig_is_a_share_of_the_load_or_a_force():
    """Both give the same record, which no friction does not."""
    share, force = (
        vi.virtual_record(1.0, 3, **BENCH | {"friction": f}).acceleration for f in (0.05, "0.3 N")
    )
    assert abs(share - force).max() < 1e-6
    assert abs(share - vi.virtual_record(1.0, 3, **BENCH).acceleration).max() > 1
    with pytest.raises(vi.ParameterError, match=r"friction = -0\.1"):
        vi.VirtualRig(**BENCH, friction=-0.1)


def test_a_virtual_rig_with_friction_obeys_newtons_law():
    """Between impacts, the mean acceleration of the primary mass times its mass is the sum of all forces."""
    rig = vi.VirtualRig(
        **RUBBING, snr=None, contact=0.0, offset=0.0, ring_share=0.0, rate=50e3, bandwidth=20e3
    )
    a = rig.record(1.0, 3, "acceleration").acceleration
    x, v = (getattr(rig.record(1.0, 3, name), name) for name in ("displacement", "velocity"))
    load = rig.record(1.0, 3).load
    force = (a * rig.M + rig.C * v + rig.K * x - load)[2000:-2000]
    # +- the friction, but for impacts; the sensors delay all channels alike
    level = 0.3
    near = abs(abs(force) - level) < 0.02
    assert near.mean() > 0.9
    assert (force[near] > 0).any()
    assert (force[near] < 0).any()
