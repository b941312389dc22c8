"""The command `vibroimpact`; its subcommands are the other modules of this folder."""

from __future__ import annotations

import argparse
import os
import re
import sys
from collections.abc import Sequence
from contextlib import nullcontext, redirect_stdout
from importlib import import_module
from importlib.metadata import version
from importlib.util import find_spec
from io import StringIO
from typing import TYPE_CHECKING, Any, NoReturn

from ..base.errors import VibroimpactError
from . import HELPS, NAMES, PICTURES, STUDIES, Record, add_common, name_file, need_extras
from .options import number

if TYPE_CHECKING:
    from _typeshed import SupportsWrite

EXIT_STATUS = (
    "exit status: 0 done; 1 ran, but something failed or was not found; 2 the input is wrong"
)
INTERRUPT = "Ctrl-C: finished results are kept, status 1"
#: Note on units in the help of the commands that read or write numbers.
UNITS = (
    "lengths are in F0/K (clearance: d K/F0), time in 1/omega, angles in radians, r = Omega/omega;\n"
    "values may also have units, such as '19.5 Hz' and '4 mm', with --mass, --stiffness and --force"
)
WITHOUT_UNITS = ("explore", "identify", "prove", "reproduce", "init", "doctor", "completion")
#: Commands that compute nothing that is saved.
WITHOUT_FILES = ("explore", "init", "doctor", "completion")


#: A negative number in any notation.
NEGATIVE = re.compile(r"-(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$|-(inf|infinity|nan)$", re.IGNORECASE)


class Version(argparse.Action):
    """Prints the version; unlike the action of argparse, it reports a full disk."""

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> NoReturn:
        print(f"vibroimpact {version('vibroimpact')}")
        parser.exit()


class Parser(argparse.ArgumentParser):
    """A parser that reports errors in the same form as the rest of the program, also to scripts."""

    #: Whether an error is also reported in a JSON document.
    in_json = False

    def __init__(self, **options: Any) -> None:
        #: The arguments outside groups, in order.
        self.added: list[argparse.Action] = []
        super().__init__(**options)
        self.register("type", int, whole)
        self.register("type", float, number)

    def add_argument(self, *names: Any, **options: Any) -> argparse.Action:
        """As in the base class; the argument is kept in `added`."""
        self.added.append(super().add_argument(*names, **options))
        return self.added[-1]

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As in the base class, but -1e-3 and -inf are also values and not options: a blank is put before each of
        them."""
        return super().parse_known_args(
            [f" {word}" if NEGATIVE.match(word) else word for word in args], namespace
        )

    def print_help(self, file: SupportsWrite[str] | None = None) -> None:
        """As in the base class, but a full disk is an error."""
        print(self.format_help(), end="", file=file)

    def error(self, message: str) -> NoReturn:
        """Report an error and exit."""
        message = re.sub(r"^argument ([^:]+): (?=.*: must be )", r"\1 ", message)
        if not self.in_json:
            self.print_usage(sys.stderr)
        record = Record(self.prog.partition(" ")[2])
        record.fault(f"{self.prog}: {message}; see `{self.prog} --help`")
        if self.in_json:
            print(record.text(2, ""))
        self.exit(2)


def whole(text: str) -> int:
    """The value of an option for a whole number."""
    try:
        if "_" in text or not text.isascii():
            raise ValueError
        return int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text.strip()}: must be a whole number") from None


def parsers() -> tuple[Parser, dict[str, Parser]]:
    """The main argument parser, and the parser of each subcommand."""
    parser, each = main_parser()
    for name in NAMES:
        fill(each[name], name)
    return parser, each


def main_parser() -> tuple[Parser, dict[str, Parser]]:
    """The argument parser, and that of each subcommand, as yet without its arguments."""
    parser = Parser(
        prog="vibroimpact",
        description="Vibrating systems with impacts: periodic motions and their stability, simulation,\n"
        "identification and design.",
        epilog=f"example: vibroimpact reproduce table1\n\n{EXIT_STATUS}\n{INTERRUPT}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--version", action=Version, nargs=0, help="show the version of the program, and exit"
    )
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    each = {name: commands.add_parser(name, help=does) for name, does in HELPS.items()}
    return parser, each


def parser_of(name: str) -> Parser:
    """The parser of a subcommand."""
    parser = Parser(prog=f"vibroimpact {name}")
    fill(parser, name)
    return parser


def fill(parser: Parser, name: str) -> None:
    """Give the parser of a subcommand its texts and arguments."""
    module = module_of(name)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.description = module.DESCRIPTION
    parser.epilog = "\n\n".join([
        f"example: {module.EXAMPLE}", *[UNITS] * (name not in WITHOUT_UNITS),
        "\n".join([EXIT_STATUS, *[INTERRUPT] * (name not in WITHOUT_FILES)]),
    ])  # fmt: skip
    module.arguments(parser)
    add_common(parser)


def module_of(name: str) -> Any:
    """The module of a subcommand, or a generated replacement for a study without one."""
    place = f"{__package__}.{name}"
    if name in STUDIES and find_spec(place) is None:
        from .study import plain_command

        return plain_command(name)
    return import_module(place)


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point of the command; returns the exit status."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    name = words[0] if words else ""
    parser = parser_of(name) if name in NAMES else main_parser()[0]
    if not words:
        parser.print_help(sys.stderr)
        return 2
    try:
        try:
            parser.in_json = "--json" in words
            if name not in NAMES:
                parser.parse_args(words)  # help, version or an error
                parser.error(f"{name}: must be a command")
            # files and names may come before and after an option
            try:
                options = parser.parse_intermixed_args(_separated(words[1:]))
            except AttributeError as error:
                # argparse restores at its end a state that Ctrl-C may have prevented it from saving
                if isinstance(error.__context__, KeyboardInterrupt):
                    raise KeyboardInterrupt from None
                raise
            options.record = Record(name)
            return said_or_told(name, options)
        finally:
            sys.stdout.flush()  # the parser may also print
    except OSError as error:
        # the reader has closed the pipe, or the disk is full: leave nothing to be flushed at exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if not isinstance(error, BrokenPipeError):
            print(f"{parser.prog}: standard output: {error.strerror or error}", file=sys.stderr)
        return 1


def said_or_told(name: str, options: argparse.Namespace) -> int:
    """Run a command with normal output, quietly, or with all output in one JSON document."""
    heard = options.quiet or options.json
    with redirect_stdout(StringIO()) if heard else nullcontext() as printed:
        status = outcome(name, options)
    if options.json:
        print(options.record.text(status, printed.getvalue() if printed else ""))
    return status


def outcome(name: str, options: argparse.Namespace) -> int:
    """Run a command and return the exit status, even after an error."""
    status = 2
    try:
        name_file(options)
        need_extras(options)
        status = module_of(name).run(options)
    except VibroimpactError as error:
        status = error.status
        options.record.fault(f"vibroimpact {name}: {error}")
    except OSError as error:
        if error.filename is None:  # standard output
            raise
        options.record.fault(
            f"vibroimpact {name}: {error.filename}: {error.strerror}; the folder and the disk must be "
            "writable"
        )
    except KeyboardInterrupt:
        status = 1
        options.record.interrupted(name not in WITHOUT_FILES)
    return status


def _separated(words: list[str]) -> list[str]:
    """The arguments with the value of --plot written as --plot=VALUE; otherwise the option would take a file as
    its value.

    A word after --plot that is not a file counts as a format, even if it is unknown.
    """
    plain = [*words]
    for i, word in enumerate(words):
        after = words[i + 1] if i + 1 < len(words) else "-"
        if word == "--plot" and after not in PICTURES:
            named = after.isalnum() and not os.path.exists(after)
            plain[i] = "--plot" if named else f"--plot={PICTURES[0]}"
    return plain
