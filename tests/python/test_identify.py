"""Identification of rigs from records: laws, agreement with the rig that made a record, and named faults."""

import numpy as np
import pytest
import vibroimpact as vi

pytest.importorskip("scipy")
#: The rig of a bench test: 2.7 kg on 42 kN/m, a particle of 0.11 kg, 6 N at 19.5 Hz.
BENCH = {
    "M": 2.7, "K": 42e3, "m": 0.11, "d": 0.006, "xi": 0.01143, "restitution": (0.75, 0.65), "F0": 6.0,
    "frequency": 19.5,
}  # fmt: skip
KNOWN = {"M": 2.7, "K": 42e3, "m": 0.11}


def test_the_bench_rig_is_found():
    """From one record at 40 dB, xi is found to 0.0002 as by hand, and all parameters within four errors."""
    found = vi.identify(vi.VirtualRig(**BENCH).record(seed=1), known=KNOWN)
    assert found.status == "periodic"
    assert found.pattern == vi.Pattern("RLL")
    assert found.undetermined == []
    assert found.errors["xi"] < 0.0002
    true = {"xi": 0.01143, "R1": 0.75, "R2": 0.65, "d": 0.006, "F0": 6.0}
    for name, value in true.items():
        assert abs(found.values[name] - value) < 4 * found.errors[name], name
    assert found.misfit == pytest.approx(1, abs=0.5)
    assert found.motion.stable
    assert found.motion.multipliers == pytest.approx(found.multipliers, rel=1e-9)


def test_an_identification_is_saved_and_read(tmp_path):
    """JSON, netCDF, MATLAB and CSV hold the parameters; what is read has the same motion."""
    found = vi.identify(vi.VirtualRig(**BENCH).record(seed=1), known=KNOWN)
    for suffix in ("json", "nc", "mat"):
        found.save(tmp_path / f"found.{suffix}")
        again = vi.load(tmp_path / f"found.{suffix}")
        assert again.values == found.values
        assert again.motion.phases == pytest.approx(found.motion.phases, abs=1e-12)
    found.save(tmp_path / "found.csv")
    assert np.char.startswith(np.array((tmp_path / "found.csv").read_text().split()), "xi,").any()
