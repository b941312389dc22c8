"""Files of sensor records: each format gives back the channels, and errors are named."""

import json

import numpy as np
import pytest
import vibroimpact as vi

pytest.importorskip("scipy")


RECORD = vi.SensorRecord(
    1000,
    load=np.sin(np.arange(200) / 8),
    acceleration=np.cos(np.arange(200) / 8),
    units={"acceleration": "g"},
)


def test_the_sensors_are_in_the_repr():
    """The sensor data of each channel, in SI units; nothing for a channel without sensor data."""
    samples, told = np.arange(20) / 19, {"load": 2000, "acceleration": 600}
    record = vi.SensorRecord(
        1000, load=samples, acceleration=samples, bandwidth=told, delay=1e-4, range=5, noise=0.02,
        units={"acceleration": "g"},
    )  # fmt: skip
    assert repr(record) == (
        "<SensorRecord of 20 samples at 1000 Hz, 0.02 s: load (bandwidth 2000 Hz), acceleration "
        "(bandwidth 600 Hz, delay 0.0001 s, range 49.0332 m/s^2, noise 0.196133 m/s^2)>"
    )
    assert repr(RECORD).endswith("0.2 s: load, acceleration>")


def same(record):
    """Check that a record read from a file equals RECORD."""
    return (
        record.rate == pytest.approx(RECORD.rate)
        and np.allclose(record.load, RECORD.load, atol=1e-6)
        and np.allclose(record.acceleration, RECORD.acceleration, atol=1e-5)
    )


def write_csv(path):
    rows = zip(RECORD.times, RECORD.load, RECORD.acceleration / 9.80665, strict=True)
    path.write_text(
        "# a comment\ntime [s];force (N);acc (g)\n"
        + "\n".join(";".join(map(str, row)) for row in rows)
    )


def write_json(path):
    path.write_text(json.dumps(sep005()))


def write_mat(path):
    from scipy.io import savemat

    data = {"fs": 1000.0, "force": RECORD.load, "a": RECORD.acceleration / 9.80665, "a_unit": "g"}
    savemat(path, {"bench": data})


def write_nc(path):
    xarray = pytest.importorskip("xarray")
    data = xarray.Dataset(
        {
            "load": ("time", RECORD.load, {"units": "N"}),
            "acceleration": ("time", RECORD.acceleration, {"units": "m/s^2"}),
        },
        {"time": RECORD.times},
    )
    data.to_netcdf(path, engine="h5netcdf")


def write_uff(path):
    pyuff = pytest.importorskip("pyuff")
    channels = ((9, "force", "N", RECORD.load), (12, "acc", "m/s^2", RECORD.acceleration))
    for code, name, unit, values in channels:
        data = pyuff.prepare_58(
            binary=0, func_type=1, rsp_node=1, rsp_dir=1, ref_dir=1, ref_node=1, data=values, x=RECORD.times,
            id1=name,
            ordinate_spec_data_type=code, ordinate_axis_units_lab=unit,
            orddenom_spec_data_type=0, abscissa_inc=1e-3,
            abscissa_spacing=1, abscissa_min=0.0, num_pts=values.size, ord_data_type=4,
        )  # fmt: skip
        pyuff.UFF(str(path)).write_sets(data, "add")


def sep005():
    """RECORD by SDyPy's SEP005."""
    return [
        {"name": "load", "data": RECORD.load.tolist(), "fs": 1000, "unit_str": "N"},
        {
            "name": "acceleration",
            "data": RECORD.acceleration.tolist(),
            "fs": 1000,
            "unit_str": "m/s^2",
        },
    ]


@pytest.mark.parametrize("write", [write_csv, write_json, write_mat, write_nc, write_uff])
def test_files_of_records_are_read(write, tmp_path):
    """Each format gives back the channels, in SI units, and the rate."""
    path = tmp_path / f"bench.{write.__name__.partition('_')[2]}"
    write(path)
    assert same(vi.read_record(path))


def test_signals_in_memory_and_sound_are_read(tmp_path):
    """SEP005 dicts as they are, and a WAV file with the full scale of its channels."""
    from scipy.io import wavfile

    assert same(vi.read_record(sep005()))
    path = tmp_path / "bench.wav"
    wavfile.write(
        path, 1000, np.column_stack([RECORD.load / 2, RECORD.acceleration / 20]).astype(np.float32)
    )
    assert same(vi.read_record(path, scale=[2, 20]))
    swapped = vi.read_record(path, channels=["acceleration", "load"], scale=[2, 20])
    assert np.allclose(swapped.load, RECORD.acceleration, atol=1e-5)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.xyz", "1", "must end with one of .csv"),
        ("a.csv", "", "no rows: must have samples"),
        ("a.csv", "load,acc\n1,x\n", "row 1: 'x' must be a number"),
        ("a.csv", "load,acc\n1\n2,3\n", "row 1 with 1 values: must have 2"),
        ("a.csv", "one,two\n1,2\n", "one must be named load"),
        ("a.csv", "load,acc\n" + "1,2\n" * 20, "rate: is missing; must be the sampling rate"),
        ("a.csv", "time,load\n" + "".join(f"{t},1\n" for t in (*range(20), *range(25, 40))),
         "5 samples are missing"),
        ("a.csv", "load (stone)\n" + "1\n" * 20, "unit of load = 'stone': must be one of"),
        ("a.json", "{", "must be a record in the format of .json"),
        ("a.mat", "no", "it is not a MATLAB file"),
    ],
)  # fmt: skip
def test_faults_of_files_are_named(name, text, message, tmp_path):
    """An error in a file is reported with its path."""
    (tmp_path / name).write_text(text)
    rate = 1000 if "stone" in text else None
    with pytest.raises(vi.ParameterError, match=message):
        vi.read_record(tmp_path / name, rate=rate)
    with pytest.raises(vi.ParameterError, match="there is none"):
        vi.read_record(tmp_path / "nothing.csv")


@pytest.mark.parametrize(
    ("header", "step"),
    [("time (ms),load (lbf),acc (g)", 1.0), ("t_us,force_lbf,acc_g", 1000.0), ("time [s],load_lbf,a g", 1e-3)],
)  # fmt: skip
def test_units_in_a_header_count(tmp_path, header, step):
    """A record has the same samples in SI units for any units in its header, including those of time."""
    rows = "\n".join(f"{i * step:.17g},{i % 7},{i % 5}" for i in range(100))
    (tmp_path / "bench.csv").write_text(f"{header}\n{rows}")
    found = vi.read_record(tmp_path / "bench.csv")
    assert found.rate == pytest.approx(1000)
    assert found.load[1] == pytest.approx(4.4482216152605)
    assert found.acceleration[1] == pytest.approx(9.80665)


def test_an_unknown_unit_of_time_is_an_error(tmp_path):
    """Times in an unknown unit are not mistaken for seconds."""
    (tmp_path / "bench.csv").write_text(
        "time (days),load,a\n" + "\n".join(f"{i},1,2" for i in range(20))
    )
    with pytest.raises(vi.ParameterError, match=r"unit of time = 'days': must be one of s,"):
        vi.read_record(tmp_path / "bench.csv")


def rows_of(times):
    """A table of loads and accelerations at given times."""
    return "time,load,acc\n" + "".join(f"{t},{i % 7},{i % 5}\n" for i, t in enumerate(times))


@pytest.mark.parametrize(
    ("text", "options", "message"),
    [
        ("load,force\n" + "1,2\n" * 20, {},
         "channel 'force': is a second load channel; must be the only one, or give `channels`"),
        ("load,a\n" + "1,2\n" * 20, {"scale": [1.0]},
         "scale = [1.0]: must be 2 numbers, one for each channel"),
        ("load,a\n" + "1,2\n" * 20, {"units": ["N"]},
         "units = ['N']: must be 2 words, one for each channel"),
        ("load,a\n" + "1,2\n" * 20, {"channels": ["load", 3]}, "channels = ['load', 3]: must be words"),
        (rows_of([0, 1, "", 3, 4]), {}, "time[2] = nan: must be a finite number"),
        (rows_of([0]), {}, "time of shape (1,): must be one list of at least 2 numbers"),
        (rows_of([3, 2, 1, 0]), {}, "time from 3 to 0: must increase"),
        (rows_of([0, 1, 2, 3, 3.2, 4, 5, 6]), {}, "time[4] = 3.2 after 3: must be 1 later; samples are irregular"),
    ],
)  # fmt: skip
def test_faults_of_tables_are_named(text, options, message, tmp_path):
    """The invalid channel or sample is named with its value."""
    path = tmp_path / "a.csv"
    path.write_text(text)
    with pytest.raises(vi.ParameterError) as caught:
        vi.read_record(path, **options)
    assert str(caught.value) == f"path = {str(path)!r}: {message}"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ([3], "path: signal 0 must be a SEP005 dict with name, data, unit_str, and fs or time"),
        ({"fs": 1000}, "channels 'acceleration' and 'load': rates are 500 and 1000 Hz; must be the same of all "
         "channels"),
        ({"time": [0, 1]}, "channel 'load' of 20 samples: must have as many samples as times, 2"),
        ({"time": np.arange(20) / 500}, "channels 'acceleration' and 'load': must both have times, "
         "both have a rate, or have neither"),
        ({"fs": 500, "time": np.arange(20) / 501}, "channel 'load': its rate is 500 Hz and that of its times 501 "
         "Hz; must be the same"),
        ({"fs": 500, "start_timestamp": "yesterday"}, "start_timestamp of 'load' = 'yesterday': must be a date "
         "and time such as '2026-01-31T12:00:00'"),
        ({"name": ["load"], "data": np.ones((2, 20)), "fs": 500},
         "name = ['load']: must be 2 names, one for each channel of data"),
    ],
)  # fmt: skip
def test_faults_of_signals_are_named(change, message):
    """Signals of different rates, and a signal whose channels lack names, are refused."""
    first = {"name": "acceleration", "data": np.ones(20), "fs": 500}
    signals = (
        change
        if isinstance(change, list)
        else [first, {"name": "load", "data": np.ones(20)} | change]
    )
    with pytest.raises(vi.ParameterError) as caught:
        vi.read_record(signals)
    assert str(caught.value) == message


def test_signals_of_several_channels_have_the_rate_of_their_times():
    """One signal with the two channels of RECORD, and times instead of a rate."""
    data = np.array([RECORD.load, RECORD.acceleration])
    assert same(vi.read_record({"name": ["load", "a"], "data": data, "time": RECORD.times}))


@pytest.mark.parametrize(("kind", "zero", "scale"), [("uint8", 128, 128), ("int16", 0, 32768)])
def test_whole_numbers_of_sound_are_parts_of_the_full_scale(kind, zero, scale, tmp_path):
    from scipy.io import wavfile

    values = np.array([[-1.0, 0.5], [0.25, -0.125]] * 20)
    wavfile.write(tmp_path / "a.wav", 1000, (values * scale + zero).astype(kind))
    found = vi.read_record(tmp_path / "a.wav")
    assert np.array_equal(found.load, values[:, 0])
    assert np.array_equal(found.acceleration, values[:, 1])


def test_a_step_and_a_bandwidth_are_variables(tmp_path):
    from scipy.io import savemat

    variables = {"dt": 0.004, "bandwidth": 90.0, "load": RECORD.load, "a": RECORD.load}
    savemat(tmp_path / "a.mat", variables)
    found = vi.read_record(tmp_path / "a.mat")
    assert (found.rate, found.bandwidth) == (250, {"acceleration": 90})
    assert np.array_equal(found.load, RECORD.load)
    savemat(tmp_path / "a.mat", variables | {"dt": -0.004})
    with pytest.raises(vi.ParameterError, match=r"dt = -0\.004: must be"):
        vi.read_record(tmp_path / "a.mat")


SLOW, FAST = np.arange(60) / 100, np.arange(120) / 200


def signal(name, times, **more):
    """A channel in SEP005 form whose samples encode their times."""
    return {"name": name, "data": np.sin(5 * times), "time": times} | more


@pytest.mark.parametrize("shift", [-7, 0, 5])
def test_channels_of_other_start_times_are_joined_by_time(shift):
    """Samples of one time have one position, and the record is the part that both channels have."""
    found = vi.read_record([signal("load", SLOW), signal("a", SLOW + shift / 100)])
    assert len(found) == len(SLOW) - abs(shift)
    assert found.start == pytest.approx(max(0, shift) / 100)
    assert np.allclose(found.load, np.sin(5 * found.times))
    assert np.allclose(found.acceleration, np.sin(5 * found.times))


def test_start_timestamps_are_times():
    """Signals with rates that start at different times."""
    first = {
        "name": "load",
        "data": np.sin(5 * SLOW),
        "fs": 100,
        "start_timestamp": "2026-01-31T12:00:00",
    }
    other = {
        "name": "a", "data": np.sin(5 * (SLOW + 0.25)), "fs": 100, "start_timestamp": "2026-01-31T12:00:00.25",
    }  # fmt: skip
    found = vi.read_record([first, other])
    assert (len(found), found.start) == (35, 0.25)
    assert np.allclose(found.load, found.acceleration)


@pytest.mark.parametrize(
    ("times", "message"),
    [
        (FAST, "channels 'load' and 'a': rates are 100 and 200 Hz"),
        (SLOW * (1 + 1e-3), "rates are 100 and 99.9000999 Hz"),
        (SLOW + 0.004, "start at 0 and 0.004 s, 0.4 samples apart; must be sampled at the same times"),
        (SLOW + 3, "channels 'load', 'a': must have times in common"),
        (SLOW[:-1], None),
    ],
)  # fmt: skip
@pytest.mark.parametrize("form", ["json", "nc", "uff"])
def test_channels_that_do_not_fit_together_are_refused(form, times, message, tmp_path):
    """Channels of other rates, or with samples at other times, are not joined by their index, in any format."""
    signals = [signal("load", SLOW), signal("a", times)]
    path = tmp_path / f"bench.{form}"
    if form == "json":
        listed = [
            {key: x if key == "name" else x.tolist() for key, x in one.items()} for one in signals
        ]
        path.write_text(json.dumps(listed))
    elif form == "nc":
        xarray = pytest.importorskip("xarray")
        xarray.Dataset(
            {one["name"]: (f"of_{one['name']}", one["data"]) for one in signals}
            | {f"time_of_{one['name']}": (f"of_{one['name']}", one["time"]) for one in signals}
        ).to_netcdf(path, engine="h5netcdf")
    else:
        pyuff = pytest.importorskip("pyuff")
        for code, one in zip((9, 12), signals, strict=True):
            data = pyuff.prepare_58(
                binary=0, func_type=1, rsp_node=1, rsp_dir=1, ref_dir=1, ref_node=1, data=one["data"],
                x=one["time"], id1=one["name"], ordinate_spec_data_type=code, ordinate_axis_units_lab="NONE",
                orddenom_spec_data_type=0, abscissa_inc=one["time"][1] - one["time"][0], abscissa_spacing=1,
                abscissa_min=one["time"][0], num_pts=one["data"].size, ord_data_type=4,
            )  # fmt: skip
            pyuff.UFF(str(path)).write_sets(data, "add")
        message = message and message.replace("'a'", "'acceleration'")
    if message is None:
        assert len(vi.read_record(path)) == len(times)
        return
    with pytest.raises(vi.ParameterError, match=message):
        vi.read_record(path)


def test_a_rate_does_not_override_times(tmp_path):
    """A rate that differs from that of the file is refused, whether the file has times or a rate."""
    path = tmp_path / "bench.csv"
    path.write_text(rows_of(np.arange(40) / 1000))
    assert vi.read_record(path, rate=1000).rate == pytest.approx(1000)
    with pytest.raises(
        vi.ParameterError,
        match=r"rate = 500: must be left out, or equal the rate of the record, 1000 Hz",
    ):
        vi.read_record(path, rate=500)
    with pytest.raises(vi.ParameterError, match=r"rate = 500: must be left out, or .* 1000 Hz"):
        vi.read_record({"name": "load", "data": RECORD.load, "fs": 1000}, rate=500)
    path.write_text("time,load,t\n" + "".join(f"{i},1,{2 * i}\n" for i in range(40)))
    with pytest.raises(
        vi.ParameterError, match="channel 't': is a second time channel; must be the only one"
    ):
        vi.read_record(path)
    assert vi.read_record(path, channels=["time", "load", "none"]).rate == 1


def test_times_of_a_matlab_file_count(tmp_path):
    """Times of another length, and a rate that does not match them, are refused."""
    from scipy.io import savemat

    path = tmp_path / "a.mat"
    savemat(path, {"t": np.arange(100) / 50, "load": RECORD.load})
    with pytest.raises(
        vi.ParameterError,
        match="channel 'load' of 200 samples: must have as many samples as times, 100",
    ):
        vi.read_record(path)
    savemat(path, {"t": np.arange(200) / 50, "load": RECORD.load, "fs": 51.0})
    with pytest.raises(vi.ParameterError, match="its rate is 51 Hz and that of its times 50 Hz"):
        vi.read_record(path)


def test_what_is_known_of_sensors_is_by_channel():
    """A bare number applies to the motion; range and noise are in the unit of the channel."""
    found = vi.read_record(
        [signal("load", SLOW), signal("acc_g", SLOW)], bandwidth=40, delay={"load": -1e-3},
        range=[0, 50], noise=[0.1, 0.01],
    )  # fmt: skip
    assert found.bandwidth == {"acceleration": 40}
    assert found.delay == {"load": -1e-3}
    assert found.range == {"acceleration": pytest.approx(50 * 9.80665)}
    assert found.noise == {"load": 0.1, "acceleration": pytest.approx(0.0980665)}


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"bandwidth": {"load": -1}}, "bandwidth of load = -1: must be"),
        ({"bandwidth": {"velocity": 10}}, "bandwidth: channel = 'velocity': must be"),
        ({"delay": np.nan}, "delay = nan: must be a finite number of seconds"),
        ({"noise": [1, 2, 3]}, r"noise = \[1, 2, 3\]: must be one number, or 2, .*: load, acc_g$"),
    ],
)
def test_faults_of_sensors_are_named(options, message):
    """The error names the wrong quantity and channel."""
    with pytest.raises(vi.ParameterError, match=message):
        vi.read_record([signal("load", SLOW), signal("acc_g", SLOW)], **options)


@pytest.mark.parametrize("header", ["time_ms,shaker_N,acc_g", "time (ms),shaker (N),top (g)"])
def test_a_unit_tells_a_channel_whose_name_does_not(header, tmp_path):
    """A channel in newtons is a force, and one in g an acceleration, whatever its name."""
    path = tmp_path / "bench.csv"
    rows = zip(RECORD.times * 1e3, RECORD.load, RECORD.acceleration / 9.80665, strict=True)
    path.write_text("\n".join([header, *(f"{t:.9g},{x:.17g},{a:.17g}" for t, x, a in rows)]))
    assert same(vi.read_record(path))


def test_what_is_not_read_is_named(tmp_path):
    """A channel of unknown quantity is left out with a warning, or silently if it is declared as none."""
    path = tmp_path / "bench.csv"
    path.write_text("load,acc,tacho\n" + "1,2,3\n" * 20)
    with pytest.warns(
        UserWarning, match=r"bench\.csv: not read: 'tacho'; neither the name nor the unit"
    ):
        assert list(vi.read_record(path, rate=100).channels) == ["load", "acceleration"]
    found = vi.read_record(path, rate=100, channels=["load", "acceleration", "none"])
    assert list(found.channels) == ["load", "acceleration"]


def test_a_matrix_of_a_matlab_file_is_named(tmp_path):
    """A column of sample numbers is not a channel."""
    from scipy.io import savemat

    savemat(
        tmp_path / "a.mat",
        {"load": RECORD.load, "acc": RECORD.load, "fs": 100.0, "modes": np.ones((5, 4))},
    )
    with pytest.warns(UserWarning, match="not read: 'modes'"):
        vi.read_record(tmp_path / "a.mat")


@pytest.mark.parametrize(
    ("header", "rate", "load", "acceleration"),
    [
        ("time_ms,load_N,acceleration_mm/s2", 1000, 1, 1e-3),
        ("TIME_MS,SHAKER_N,ACC_G", 1000, 1, 9.80665),
        ("time.ms,load_kn,acceleration_mg", 1000, 1000, 9.80665e-3),
        ("time (MS),load (KN),acc (G)", 1000, 1000, 9.80665),
        ("time_ms,F_N,top_mm_s2", 1000, 1, 1e-3),
        ("time_ms,load_cell_MN,acc_ips2", 1000, 1e6, 0.0254),
        ("time_s,load_lbs,acc_ms2", 1, 4.4482216152605, 1),
        ("time_ms,load,acc_x", 1000, 1, 1),
    ],
)
@pytest.mark.filterwarnings("error")
def test_no_unit_of_a_header_is_dropped(tmp_path, header, rate, load, acceleration):
    """Each spelling of a unit is accepted, in any case where that is unambiguous."""
    rows = "\n".join(f"{i},{i % 7},{i % 5}" for i in range(50))
    (tmp_path / "bench.csv").write_text(f"{header}\n{rows}")
    found = vi.read_record(tmp_path / "bench.csv")
    assert found.rate == pytest.approx(rate)
    assert found.load[1] == pytest.approx(load)
    assert found.acceleration[1] == pytest.approx(acceleration)


@pytest.mark.parametrize(
    ("header", "name"),
    [
        ("time_ms,load_mV,acc_g", "load_mV"), ("time_ms,load_N,acc_V", "acc_V"),
        ("time_Hz,load_N,acc_g", "time_Hz"),
        ("time_ms,load_mn,acc_g", "load_mn"), ("time_ms,load_N,acc_ips", "acc_ips"),
    ],
)  # fmt: skip
def test_units_of_something_else_are_refused(tmp_path, header, name):
    """A unit that does not fit the quantity, or that is ambiguous, is an error that names the column."""
    rows = "\n".join(f"{i},{i % 7},{i % 5}" for i in range(50))
    (tmp_path / "bench.csv").write_text(f"{header}\n{rows}")
    with pytest.raises(vi.ParameterError, match=f"channel '{name}': unit"):
        vi.read_record(tmp_path / "bench.csv")


def test_an_ending_that_is_no_unit_is_named(tmp_path):
    """The warning gives the unit in which the channel is read."""
    rows = "\n".join(f"{i},{i % 7},{i % 5}" for i in range(50))
    (tmp_path / "bench.csv").write_text(f"time_ms,load_N,acc_top\n{rows}")
    with pytest.warns(UserWarning, match="'acc_top': 'top' is not a known unit; .* in m/s"):
        vi.read_record(tmp_path / "bench.csv")


@pytest.mark.parametrize("header", ["time_s,shaker,acc", "time_s,force,top"])
@pytest.mark.filterwarnings("ignore:.*not read")
def test_a_record_has_a_load_and_a_motion(tmp_path, header):
    """A missing channel is an error that lists the columns, unless the caller identifies them."""
    rows = "\n".join(f"{i},{i % 7},{i % 5}" for i in range(50))
    path = tmp_path / "bench.csv"
    path.write_text(f"{header}\n{rows}")
    with pytest.raises(vi.ParameterError, match="must contain a load and a motion"):
        vi.read_record(path)
    channels = ["time", "load", "acceleration"]
    assert vi.read_record(path, channels=channels).load is not None
