"""Namelists that the fuzzer keeps: each is computed, refused in one clear line, or stops when requested."""

import signal
import time
from pathlib import Path

import pytest
import vibroimpact as vi

SEEDS = sorted((Path(__file__).parents[1] / "fuzz" / "seeds").glob("*.nml"))


def interrupt(*_):
    """Stop as Ctrl-C does."""
    raise KeyboardInterrupt


@pytest.mark.parametrize("path", SEEDS, ids=lambda path: path.stem)
def test_kept_namelists(path, tmp_path):
    """Mass.mtx and the other files of one case are missing: it is refused."""
    before = signal.signal(signal.SIGALRM, interrupt)
    signal.setitimer(signal.ITIMER_REAL, 2)
    begin = time.process_time()
    try:
        log = vi.run_namelists([path], tmp_path)
    except KeyboardInterrupt:
        assert time.process_time() < begin + 20
        return
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert log.status in (0, 1, 2)
    if log.status == 2:
        assert len(log.lines) == 1
    for _, line in log.lines:
        assert line.isprintable()


def test_a_record_longer_than_a_simulation(tmp_path):
    """A simulation to the end of a record is refused if that duration is above the limit of the key."""
    (path,) = (path for path in SEEDS if path.stem == "structure_long_record")
    log = vi.run_namelists([path], tmp_path)
    assert log.status == 2
    assert log.lines[0][1].endswith(
        "&simulate duration: is missing; must be a number with 0 <= duration <= 1e12; the record is "
        "longer than that"
    )


def test_messages_hold_no_control_characters(tmp_path):
    """A byte that a terminal would obey is shown as a question mark, also where a program reads the message."""
    path = tmp_path / "odd.nml"
    path.write_bytes(b"&system\n xi = 0.0\x1b1, mu = 0, restitution = 1 /\n&decay clearance = 1 /")
    with pytest.raises(vi.ParameterError, match=r"xi = 0\.0\?1") as error:
        vi.read_namelist(path)
    assert str(error.value).isprintable()
