"""Different spellings of one case give the result of the plain spelling, byte for byte."""

import pytest
from programs import COMPLETE, PAIR, SYSTEM, Runner, contents, motions, write

ONE_LINE = (
    "&system xi=0.005 mu=0.042 restitution=0.75 r=0.94/&motion sides='RL' cycles=1 "
    "phases_over_pi=0 1.37/&output name='case' format='csv'/"
)

SPELLINGS = {
    "tabs": COMPLETE.replace("  ", "\t").replace(" = ", "\t=\t"),
    "carriage returns": COMPLETE.replace("\n", "\r\n"),
    "byte order mark": b"\xef\xbb\xbf" + COMPLETE.encode(),
    "mark and carriage returns": b"\xef\xbb\xbf" + COMPLETE.replace("\n", "\r\n").encode(),
    "no last line feed": COMPLETE.rstrip("\n"),
    "upper case keys": COMPLETE.upper().replace("'CASE'", "'case'"),
    "lower case sides": COMPLETE.replace("'RL'", "'rl'"),
    "double quotes": COMPLETE.replace("'", '"'),
    "one line": ONE_LINE,
    "commas at the ends": COMPLETE.replace("\n  ", ",\n  ").replace("&system,", "&system")
    .replace("&motion,", "&motion").replace("&output,", "&output"),
    "no blanks": COMPLETE.replace(" ", ""),
    "comments": "! first\n" + COMPLETE.replace("\n", " ! it's a / comment & = ''\n"),
    "blank lines": COMPLETE.replace("\n", "\n\n \t\n"),
    "end for slash": COMPLETE.replace("\n/", "\n&end"),
    "END for slash": COMPLETE.replace("\n/", "\n&END"),
    "repeat": COMPLETE.replace("restitution = 0.75", "restitution = 2*0.75"),
    "two numbers": COMPLETE.replace("restitution = 0.75", "restitution = 0.75, 0.75"),
    "elements": COMPLETE.replace("restitution = 0.75", "restitution(1)=0.75\nrestitution(2)=0.75"),
    "section": COMPLETE.replace("phases_over_pi", "phases_over_pi(1:2)"),
    "one element each": COMPLETE.replace("_pi = 0, 1.37", "_pi(2)=1.37, phases_over_pi(1) = 0"),
    "blanks in a subscript": COMPLETE.replace("_pi = 0", "_pi( 1 : 2 ) = 0"),
    "numbers over lines": COMPLETE.replace("0, 1.37", "\n0\n,\n! between\n1.37\n"),
    "blank between numbers": COMPLETE.replace("0, 1.37", "0 1.37"),
    "d exponent": COMPLETE.replace("1.37", "1.37d0"),
    "D exponent": COMPLETE.replace("1.37", "0.137D+01"),
    "e exponent": COMPLETE.replace("1.37", "137.e-2"),
    "plus sign": COMPLETE.replace("1.37", "+1.37"),
    "no digit before the point": COMPLETE.replace("0.005", ".005"),
    "defaults left out": COMPLETE.replace("  cycles = 1\n", "").replace("  format = 'csv'\n", ""),
    "defaults written out": COMPLETE.replace("cycles = 1", "cycles = 1, precision = 'double'\n"
                                             "kind = 'periodic', acceptance = 0.03"),
    "choices in upper case": COMPLETE.replace("'csv'", "'CSV'"),
    "named after the file": COMPLETE.replace("  name = 'case'\n", ""),
    "no output group": COMPLETE[: COMPLETE.index("&output")],
}  # fmt: skip


@pytest.fixture(scope="module")
def plain(tmp_path_factory, binary):
    """The result of the plain spelling."""
    folder = tmp_path_factory.mktemp("plain")
    assert Runner([binary], folder).case(COMPLETE).status == 0
    return (folder / "results" / "case.csv").read_bytes()


@pytest.mark.parametrize("spelling", SPELLINGS)
def test_spelling_does_not_matter(spelling, batch, plain):
    """The same numbers in another spelling give the same bytes."""
    done = batch.case(SPELLINGS[spelling])
    assert (done.status, done.err) == (0, b"")
    assert contents(batch.cwd / "results") == {"case.csv": plain}


def test_command_reads_them_the_same(batch, command, plain):
    """The command reads every spelling as the program does."""
    for i, text in enumerate(SPELLINGS.values()):
        text = text if isinstance(text, bytes) else text.encode()
        name = b"s%d" % i
        text = text.replace(b"'case'", b"'%s'" % name).replace(b'"case"', b'"%s"' % name)
        write(batch.cwd / f"s{i}.nml", text)
    names = [f"s{i}.nml" for i in range(len(SPELLINGS))]
    assert command(*names, "-o", "out").status == 0
    for i in range(len(SPELLINGS)):
        assert (batch.cwd / f"out/s{i}.csv").read_bytes().replace(b"'s%d'" % i, b"'case'") == plain


def test_comment_characters_in_a_quote(batch):
    """!, / and & in quotes are part of the name, which is refused as written."""
    done = batch.case(COMPLETE.replace("'case'", "'a!b/c&d'"))
    assert "name = 'a!b/c&d': must be" in done.faults[0]


@pytest.mark.parametrize(("key", "factor"), [("phases", 3.141592653589793), ("phases_over_pi", 1)])
def test_phases_in_both_units(key, factor, batch):
    """Phases in units of pi and in radians give the same result."""
    batch.case(f"{SYSTEM}&motion sides = 'RL', {key} = 0, {1.37 * factor!r} /\n")
    phases = motions(batch.cwd / "results/case.csv")[0]["phase"]
    assert [float(item) for item in phases] == [0.0, 1.37 * 3.141592653589793]


def test_system_serves_all_motions_after_it(batch):
    """A &system applies until the next one; every motion starts from the defaults."""
    other = SYSTEM.replace("0.94", "0.9").replace("0.75", "0.8, 0.6")
    batch.case(
        f"{SYSTEM}&motion sides = 'LR', phases = 0, 4 /\n&motion sides = 'RL', phases = 0, 4 /\n"
        f"&output name = 'second' /{other}&motion sides = 'RL', phases = 0, 4 /"
    )
    found = {name: motions(batch.cwd / f"results/{name}.csv")[0]
             for name in ("case_1", "second", "case_3")}  # fmt: skip
    assert [float(found[name]["r"][0]) for name in found] == [0.94, 0.94, 0.9]
    assert [float(x) for x in found["case_3"]["restitution"]] == [0.8, 0.6]
    assert [found[name]["side"] for name in found] == [["L", "R"], ["R", "L"], ["R", "L"]]


@pytest.mark.parametrize("name", ["plain", "two.dots", "UPPER", "a-b_c", "7", "x" * 100])
def test_name_of_the_file_is_the_name_of_the_case(name, batch):
    """A case without a name takes the name of its file, without the suffix."""
    batch.case(PAIR, name=f"{name}.nml")
    assert list(contents(batch.cwd / "results")) == [f"{name}.csv"]


@pytest.mark.parametrize("name", ["a b.nml", "Ünï.nml", ".nml", ".hidden.nml", "n" * 120 + ".nml",
                                  "no_ending", "x.y.z", "-dash.nml"])  # fmt: skip
def test_any_file_name_gives_an_input_again(name, batch):
    """A case name made from any file name is valid when the result is used as an input."""
    write(batch.cwd / name, PAIR)
    assert batch(f"./{name}").status == 0
    (result,) = (batch.cwd / "results").iterdir()
    done = batch(f"results/{result.name}", "-o", "again")
    assert done.status == 0, done.faults
    assert contents(batch.cwd / "again") == {result.name: result.read_bytes()}
