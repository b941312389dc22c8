"""Runs of namelist files restricted to the cases of one study."""

import vibroimpact as vi

CASES = (
    "&system xi = 0.005, mu = 0.042, restitution = 0.75, r = 0.94 /\n"
    "&motion sides = 'RL', phases_over_pi = 0, 1.37 /\n"
    "&simulate clearance = 5, cycles = 5 /\n"
)


def test_only_one_study_of_a_file_is_run(tmp_path):
    """The results of one study equal those of a run of all, byte for byte; a file without it is an error."""
    path = tmp_path / "both.nml"
    path.write_text(CASES)
    every = vi.run_namelists([path], tmp_path / "every")
    assert every.status == 0
    assert sorted(place.name for place in every.results) == ["both_1.csv", "both_2.csv"]
    log = vi.run_namelists([path], tmp_path / "one", only="simulate")
    assert [place.name for place in (tmp_path / "one").iterdir()] == ["both_2.csv"]
    assert [place.name for place in log.results] == ["both_2.csv"]
    assert (tmp_path / "one/both_2.csv").read_bytes() == (
        tmp_path / "every/both_2.csv"
    ).read_bytes()
    log = vi.run_namelists([path], tmp_path / "none", only="zone")
    assert log.lines == [(True, f"{path}: must contain a group &zone; there is none")]
    assert (log.status, log.results) == (2, [])
    assert not (tmp_path / "none").exists()
