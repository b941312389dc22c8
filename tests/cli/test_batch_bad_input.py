"""Invalid input: one line with file, line, group, key, value, what is allowed; status 2; no result."""

import shutil

import pytest
from programs import (
    COMPLETE,
    PAIR,
    SYSTEM,
    Runner,
    bound_by_permissions,
    changed,
    contents,
    find_twin,
    write,
)

LONG = "RL" * 501
WALLS = "one number for both walls or two"
IMPACTS = "letters R and L, one for each impact, 2 to 1000"
PHASES = "increasing from 0 to below 2 pi cycles"
OVER_PI = "increasing from 0 to below 2 cycles"
NAME = "at most 100 letters, digits"
NEEDED = "1e-6 <= r <= 1e6"
WHOLE = "a whole number with 1 <= cycles <= 10000"

#: One line of the complete case is replaced: its number, its new text, the allowed values.
VALUES = [
    *[(2, f"xi = {v}", "0 <= xi < 1") for v in (
        "-0.1", "1", "1.5", "nan", "inf", "-inf", "1e999", "abc", "'0.1'", ".true.", "(0.1,0)",
        "0.1 0.2", "0,005", "0.005.1", "1e", "--1", "0x1", "1*", "''")],
    *[(3, f"mu = {v}", "0 <= mu <= 1e6") for v in ("-1e-9", "2e6", "nan", "inf", "x")],
    *[(4, f"restitution = {v}", WALLS) for v in (
        "-0.1", "1.01", "nan", "0.75, nan", "nan, 0.75", "0.7, 0.6, 0.5", "3*0.5", "0.7, 1.5",
        "inf", "R", "0,75, 0,61")],
    *[(5, f"r = {v}", NEEDED) for v in ("0", "-1", "1e-7", "1e7", "nan", "inf", "r", "0.9, 1.0")],
    *[(8, f"sides = {v}", IMPACTS) for v in (
        "'R'", "''", "'RR'", "'LLL'", "'RX'", "'R L'", "' RL'", "RL", "1", f"'{LONG}'",
        "'RL', 'RL'")],
    *[(9, f"cycles = {v}", WHOLE) for v in (
        "0", "-1", "10001", "1.0", "1.5", "1e0", "nan", "'1'", "99999999999", "1, 2", "one")],
    *[(10, f"phases_over_pi = {v}", OVER_PI) for v in (
        "0", "0, 1.37, 1.5", "0, 0", "0, -1", "0, 2", "0, 2.5", "0.1, 1.37", "1.37, 0", "nan, 1",
        "0, nan", "0, inf", "0, 1e999", "0, a", "'0', '1'", "0 1.37 x", "0, 1,37", "2000*0.5",
        "0,, 1.37", "0, 1.37, nan", "0, nan, 1.37")],
    *[(10, f"phases = {v}", PHASES) for v in (
        "0", "0, 6.2831853071795865", "0, 6.3", "4.3, 0", "0, 4.3, 4.3", "0, nan", "1, 2",
        "0, 4.3, nan")],
    *[(13, f"name = {v}", NAME) for v in (
        "''", "'a b'", "'a/b'", "'../up'", "'/tmp/x'", "'.hidden'", "'..'", "' a'", "'it''s'",
        f"'{'n' * 101}'", f"'{'n' * 300}'", "'\xa0'", "abc", "'a', 'b'", "'a\\b'", "'a:b'",
        "'*'")],
    *[(14, f"format = {v}", "'csv', 'table' or 'both'") for v in (
        "''", "'xlsx'", "csv", "'csv,table'", "1", "'csv                 x'")],
]  # fmt: skip

#: The same for keys that the complete case does not have: they replace `cycles`.
KEYS = [
    ("kind = 'chaotic'", "'periodic' (phases given), 'equispaced'"),
    ("kind = ''", "'periodic'"),
    ("kind = periodic", "'periodic'"),
    ("kind = 'periodic            x'", "'periodic'"),
    ("precision = 'half'", "'double' or 'single'"),
    ("precision = 'double              x'", "'double' or 'single'"),
    ("acceptance = -0.1", "0 <= acceptance <= 1"),
    ("acceptance = 1.1", "0 <= acceptance <= 1"),
    ("acceptance = nan", "0 <= acceptance <= 1"),
    ("impact_restitution = 0.7", "one number for each impact, each with 0 <= R <= 1"),
    ("impact_restitution = 0.7, 0.6, 0.5", "2 impacts"),
    ("impact_restitution = 0.7, 1.1", "0 <= R <= 1"),
    ("impact_restitution = 0.7, nan", "0 <= R <= 1"),
    ("impact_restitution = 0.7, 0.6, nan", "0 <= R <= 1"),
    ("clearance = 37", "not apply to kind = 'periodic'"),
]

#: Complete files: id, text, line, beginning of the message after the place, a part of the rest.
FORMS = [
    ("empty", "", 0, "contains no namelist group", "&system"),
    ("blank", " \n\t\n! nothing\n", 0, "contains no namelist group", "&system"),
    ("byte order mark only", b"\xef\xbb\xbf", 0, "contains no namelist group", "&system"),
    ("unknown key", changed(3, "weight = 1"), 3, "&system weight = 1", "xi, mu, restitution, r"),
    ("a law", changed(3, "law = 'power'"), 3, "&system law = 'power'", "a &gap of a &structure"),
    ("component", changed(3, "mu%x = 1"), 3, "&system mu%x = 1", "xi, mu, restitution, r"),
    ("key of another group", changed(9, "xi = 0.1"), 9, "&motion xi = 0.1", "kind, cycles"),
    ("key twice", changed(3, "xi = 0.1"), 3, "&system xi = 0.1", "line 2"),
    ("element twice", changed(9, "phases( 1) = 0\nphases(1) = 0"), 10, "&motion phases(1) = 0",
     "line 9"),
    ("no value", changed(3, "mu ="), 3, "&system mu = ", "0 <= mu <= 1e6"),
    ("no value but a comma", changed(3, "mu = ,"), 3, "&system mu = ", "0 <= mu <= 1e6"),
    ("no xi", changed(2, ""), 1, "&system xi: is missing", "0 <= xi < 1"),
    ("no mu", changed(3, ""), 1, "&system mu: is missing", "0 <= mu <= 1e6"),
    ("no restitution", changed(4, ""), 1, "&system restitution: is missing", WALLS),
    ("no r", changed(5, ""), 1, "&system r: is missing", NEEDED),
    ("no sides", changed(8, ""), 7, "&motion sides: is missing", IMPACTS),
    ("no phases", changed(10, ""), 7, "&motion phases: is missing", "phases_over_pi"),
    ("phases in both units", changed(9, "phases = 0, 4"), 9, "&motion phases = 0, 4", "phases_over_pi"),
    ("one wall of two", changed(4, "restitution(2) = 0.5"), 4, "&system restitution", WALLS),
    ("second phase only", changed(10, "phases(2) = 4.3"), 10, "&motion phases", PHASES),
    ("subscript 0", changed(10, "phases(0) = 0, 4.3"), 10, "&motion phases", PHASES),
    ("subscript 1001", changed(9, "phases(1001) = 4.3"), 9, "&motion phases", PHASES),
    ("subscript of a number", changed(2, "xi(1) = 0.1"), 2, "&system xi", "0 <= xi < 1"),
    ("resonance", changed(5, "r = 1").replace("xi = 0.005", "xi = 0"), 5, "&system r = 1",
     "differ from 1 when xi = 0"),
    ("unknown group", PAIR + "&plot\n/\n", 3, "&plot",
     "&system, &output, &motion, &simulate, &find, &chart, &branch, &zone, &atlas"),
    ("no group name", "& system\n/\n", 1, "&", "must be"),
    ("no system", PAIR.splitlines()[1], 1, "&motion", "no &system"),
    ("no motion", SYSTEM, 1, "&system", "no &motion"),
    ("no motion for the first system", SYSTEM + PAIR, 1, "&system", "no &motion"),
    ("output without motion", "&output /\n" + PAIR, 1, "&output", "no &motion"),
    ("output before motion", SYSTEM + "&output /\n" + PAIR, 1, "&system", "no &motion"),
    ("two outputs", PAIR + "&output name = 'a' /\n&output /", 4, "&output", "no &motion"),
    ("no slash before a group", changed(6, ""), 1, "&system", "no / closes the group of line 1"),
    ("no slash at the end", changed(15, ""), 12, "&output", "no / closes the group of line 12"),
    ("text before", "hello\n" + PAIR, 1, "hello", "outside a group"),
    ("text between", PAIR.replace("/\n&", "/\nhello\n&"), 2, "hello", "outside a group"),
    ("text after", PAIR + "\n\nhello", 5, "hello", "outside a group"),
    ("text after a slash", PAIR.replace("/\n&", "/ hello\n&"), 1, "hello", "outside a group"),
    ("text in a group", changed(1, "&system hello"), 1, "&system hello", "key = value"),
    ("colon for equals", changed(2, "xi: 0.1"), 2, "&system xi: 0.1", "key = value"),
    ("double equals", changed(2, "xi == 0.1"), 2, "&system", "key = value"),
    ("no key", changed(2, "= 0.1"), 2, "&system", "key = value"),
    ("quote not closed", changed(8, "sides = 'RL"), 8, "&motion", "quote is not closed"),
    ("JSON", '{"xi": 0.1}', 1, '{"xi": 0.1}', "outside a group"),
    ("binary", bytes(range(256)), 1, "", "outside a group"),
    ("UTF-16", PAIR.encode("utf-16"), 1, "", "outside a group"),
    ("two cases with one name", PAIR + "&output name = 'a' /" + PAIR + "&output name = 'A' /", 5,
     "&output name = 'A'", "already the name"),
    ("clearance missing", SYSTEM + "&motion kind = 'equispaced' /", 2,
     "&motion clearance: is missing", "1e-12 <= clearance <= 1e12"),
    ("clearance nan", SYSTEM + "&motion kind = 'equispaced', clearance = nan /", 2,
     "&motion clearance = nan", "1e-12 <= clearance <= 1e12"),
    ("clearance negative", SYSTEM + "&motion kind = 'equispaced', clearance = -1 /", 2,
     "&motion clearance = -1", "1e-12 <= clearance <= 1e12"),
    ("even cycles", SYSTEM + "&motion kind = 'equispaced', clearance = 1\ncycles = 2 /", 3,
     "&motion cycles = 2", "odd"),
    ("equispaced with sides", SYSTEM + "&motion kind = 'equispaced', clearance = 1\nsides = 'RL' /",
     3, "&motion sides = 'RL'", "not apply to kind = 'equispaced'"),
    ("equispaced with two R", SYSTEM.replace("0.75", "0.7, 0.6")
     + "&motion kind = 'equispaced', clearance = 1 /", 2, "&motion kind", "equal restitution"),
    ("wrong element of several", changed(10, "phases(1) = abc\nphases(2) = 4.3"), 10,
     "&motion phases", "abc"),
    ("first wall of two", changed(4, "restitution(1) = 1.5\nrestitution(2) = 0.6"), 4,
     "&system restitution", "1.5"),
]  # fmt: skip


def value_cases():
    """Convert the tables VALUES and KEYS to the form of FORMS."""
    group = {2: "system", 3: "system", 4: "system", 5: "system", 13: "output", 14: "output"}
    for line, text, allowed in VALUES:
        start = f"&{group.get(line, 'motion')} {text}: must be "
        # a very long message keeps its first 200 characters
        yield text[:40], changed(line, "  " + text), line, start[:200], allowed
    for text, allowed in KEYS:
        yield text, changed(9, "  " + text), 9, f"&motion {text}: must be ", allowed


CASES = [*value_cases(), *FORMS]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with every bad file of this module."""
    made = tmp_path_factory.mktemp("bad")
    for i, (_, text, *_) in enumerate(CASES):
        write(made / f"bad{i}.nml", text)
    return made


@pytest.fixture(scope="module")
def said_by_command(folder):
    """The command's messages about all bad files in one call, and its status."""
    names = [f"bad{i}.nml" for i in range(len(CASES))]
    return Runner(find_twin(), folder)(*names, "-o", "out")


@pytest.mark.parametrize("i", range(len(CASES)), ids=[case[0] for case in CASES])
def test_fault_is_named(i, folder, binary):
    """An error gives one line, file:line: &group key = value: what is allowed; status 2 and no result."""
    _, _, line, start, part = CASES[i]
    done = Runner([binary], folder)(f"bad{i}.nml", "-o", f"out{i}")
    place = f"bad{i}.nml:{line}: " if line else f"bad{i}.nml: "
    assert (done.status, done.out, len(done.faults)) == (2, b"", 1), done
    assert done.faults[0].startswith(place + start), done.faults[0]
    assert part in done.faults[0][len(place) :], done.faults[0]
    assert not (folder / f"out{i}").exists()


def test_command_says_the_same(folder, binary, said_by_command):
    """The command and the program give the same messages about all files in one call, and the same status."""
    names = [f"bad{i}.nml" for i in range(len(CASES))]
    done = Runner([binary], folder)(*names, "-o", "out")
    assert done.status == said_by_command.status == 2
    assert text_of(done) == text_of(said_by_command)


def text_of(done):
    """The lines on stderr; bytes that are not UTF-8 are tested separately."""
    return done.err.decode(errors="replace").split("\n")


def test_message_in_full(batch):
    """The whole line: file with its line, group, key, value, what is allowed."""
    done = batch.case(changed(5, "  r = -0.94"))
    assert done.err == b"case.nml:5: &system r = -0.94: must be a number with 1e-6 <= r <= 1e6\n"


def test_unreadable_files(batch, command):
    """A missing file, a folder, and a path below a file give one line each; both programs agree."""
    (batch.cwd / "folder.nml").mkdir()
    write(batch.cwd / "plain", "x")
    names = ["nope.nml", "folder.nml", "plain/x.nml", ""]
    done = batch(*names, "-o", "out")
    assert done.status == 2
    assert [line.partition(": ")[0] for line in done.faults] == names
    assert all("cannot be read: " in line for line in done.faults)
    assert [line.rsplit(": ", 1)[1] for line in done.faults[:3]] == [
        "No such file or directory", "Is a directory", "Not a directory"]  # fmt: skip
    assert command(*names[:3], "-o", "out").faults == done.faults[:3]
    assert not (batch.cwd / "out").exists()


def test_reason_of_a_long_path(batch):
    """The reason is not lost behind a path longer than a message buffer."""
    name = "/".join(["d" * 60] * 5) + "/x.nml"
    assert batch(name).faults == [f"{name}: cannot be read: No such file or directory"]


def test_file_without_permission(batch):
    """A file without read permission is reported as such."""
    write(batch.cwd / "case.nml", PAIR).chmod(0)
    done = batch("case.nml", preexec_fn=bound_by_permissions)
    assert (done.status, len(done.faults)) == (2, 1)
    assert "ermission denied" in done.faults[0]


def test_other_files_still_run(batch, command):
    """A bad file in any position does not keep other files from running; the status is the worst one."""
    write(batch.cwd / "first.nml", PAIR)
    write(batch.cwd / "bad.nml", changed(2, "xi = 2"))
    write(batch.cwd / "last.nml", PAIR)
    names = ["first.nml", "bad.nml", "nope.nml", "last.nml"]
    done = batch(*names, "-o", "out")
    assert done.status == 2
    assert [line.partition(":")[0] for line in done.faults] == ["bad.nml", "nope.nml"]
    assert sorted(contents(batch.cwd / "out")) == ["first.csv", "last.csv"]
    assert command(*names, "-o", "again") == done
    assert contents(batch.cwd / "again") == contents(batch.cwd / "out")


def test_nothing_of_a_bad_file_runs(batch):
    """An error in the last case of a file keeps the whole file from running."""
    done = batch.case(PAIR + PAIR + "&output name = 'a b' /")
    assert (done.status, len(done.faults)) == (2, 1)
    assert not (batch.cwd / "results").exists()


def test_refused_file_takes_no_names(batch):
    """Result names of a refused file are free for the next file."""
    twice = PAIR + "&output name = 'a' /\n" + PAIR + "&output name = 'b' /\n"
    write(batch.cwd / "refused.nml", twice + PAIR + "&output name = 'b' /\n")
    write(batch.cwd / "good.nml", PAIR + "&output name = 'a' /\n")
    done = batch("refused.nml", "good.nml", "-o", "out")
    assert len(done.faults) == 1
    assert sorted(contents(batch.cwd / "out")) == ["a.csv"]


def test_one_name_in_two_files(batch):
    """The second of two files with one name is refused, with the place of the first."""
    write(batch.cwd / "a.nml", PAIR + "&output name = 'same' /\n")
    write(batch.cwd / "b.nml", "\n" + PAIR + "&output name = 'same' /\n")
    done = batch("a.nml", "b.nml", "-o", "out")
    assert done.status == 2
    assert done.faults[0].startswith("b.nml:4: &output name = 'same': ")
    assert "a.nml:3" in done.faults[0]


def test_fault_with_control_characters_is_one_line(batch):
    """Carriage returns, form feeds and escapes of a bad value do not appear in the message."""
    done = batch.case(COMPLETE.replace("'case'", "'a\rb\x0bc\x0cd\x1b[31me'"))
    assert done.status == 2
    assert len(done.faults) == 1, done.faults
    assert not any(byte < 32 for byte in done.err[:-1]), done.err


def test_bytes_that_are_no_utf8(batch, command):
    """A value in Latin-1 is echoed byte by byte, also by the command."""
    text = changed(2, "xi = caf?").encode().replace(b"?", b"\xe9")
    done = batch.case(text)
    assert b"xi = caf\xe9: must be" in done.err
    assert command("case.nml") == done


def test_earlier_result_survives_bad_input(batch):
    """Invalid input does not change the results of an earlier run."""
    assert batch.case(PAIR).status == 0
    before = contents(batch.cwd / "results")
    assert batch.case(PAIR.replace("1.37", "2.37")).status == 2
    assert contents(batch.cwd / "results") == before
    shutil.rmtree(batch.cwd / "results")


@pytest.mark.parametrize("text", ["1e-5000", "-2.5d-400"])
def test_a_number_that_would_be_rounded_to_zero(text, batch):
    """A number within its range that would be rounded to zero is refused for that reason."""
    done = batch.case(changed(2, f"  xi = {text}"))
    assert done.status == 2
    assert done.faults[0].endswith("; a number this close to 0 cannot be represented; write 0")
