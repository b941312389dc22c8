"""The command `vibroimpact`."""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from collections.abc import Sequence
from importlib.metadata import version
from importlib.resources import as_file, files

from .errors import VibroimpactError

EXIT_STATUS = (
    "exit status: 0 done; 1 ran, but something failed or is not there; 2 the input is wrong"
)


def parser() -> argparse.ArgumentParser:
    """The argument parser of all subcommands."""
    style = argparse.RawDescriptionHelpFormatter
    main_parser = argparse.ArgumentParser(
        prog="vibroimpact",
        description="Stable periodic motions of a vibrating system in which a free mass hits its walls.",
        epilog=f"example: vibroimpact reproduce table1\n\n{EXIT_STATUS}",
        formatter_class=style,
    )
    main_parser.add_argument(
        "--version", action="version", version=f"vibroimpact {version('vibroimpact')}"
    )
    commands = main_parser.add_subparsers(dest="command", metavar="COMMAND", required=True)

    run = commands.add_parser(
        "run",
        help="run namelist files",
        description="Run namelist files: each case is written to DIR/NAME.csv, with the same digits as\n"
        "the stand-alone program vibroimpact-batch gives.",
        epilog=f"example: vibroimpact run inputs/table1.nml -o results\n\n{EXIT_STATUS}",
        formatter_class=style,
    )
    run.add_argument(
        "files", nargs="+", metavar="FILE.nml", help="namelist files, or earlier results"
    )
    run.add_argument(
        "-o", dest="folder", default="results", metavar="DIR", help="folder for the results"
    )

    from .reproduce import NAMES

    reproduce = commands.add_parser(
        "reproduce",
        help="recompute the tables and figures of the 1983 paper",
        description="Recompute the tables and figures of Popplewell, Bapat and McLachlan (1983) and\n"
        "compare them with the printed values. Available: " + ", ".join(NAMES) + ".",
        epilog=f"example: vibroimpact reproduce table1 -o results\n\n{EXIT_STATUS}",
        formatter_class=style,
    )
    reproduce.add_argument(
        "names", nargs="*", metavar="NAME", help="what to recompute (default: all)"
    )
    reproduce.add_argument(
        "-o", dest="folder", default="results", metavar="DIR", help="folder for the results"
    )
    return main_parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point of the command; returns the exit status."""
    options = _parse(arguments)
    try:
        if options.command == "run":
            return _run(options)
        return _reproduce(options)
    except VibroimpactError as error:
        print(f"vibroimpact {options.command}: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"vibroimpact {options.command}: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print(
            f"vibroimpact {options.command}: interrupted; what was finished is kept",
            file=sys.stderr,
        )
        return 1


def batch() -> int:
    """Start the stand-alone program that lies inside the package."""
    with as_file(files("vibroimpact") / "_bin" / "vibroimpact-batch") as program:
        if os.name == "posix":  # the program takes the place of the launcher, signals and all
            os.execv(program, [str(program), *sys.argv[1:]])
        return subprocess.call([str(program), *sys.argv[1:]])


def _run(options: argparse.Namespace) -> int:
    from .run import run_namelists

    log = run_namelists(options.files, options.folder)
    for fault, line in log.lines:
        stream = sys.stderr if fault else sys.stdout
        # a path need not be text: its bytes are printed as they are
        buffer = getattr(stream, "buffer", None)
        if buffer is None:
            print(line, file=stream)
        else:
            stream.flush()
            buffer.write(os.fsencode(line + "\n"))
            buffer.flush()
    return log.status


def _parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Parse the arguments; files and names may stand on both sides of an option."""
    main_parser = parser()
    options, rest = main_parser.parse_known_args(arguments)
    if rest and (
        options.command not in ("run", "reproduce") or any(x.startswith("-") for x in rest)
    ):
        main_parser.error(f"unrecognized arguments: {' '.join(rest)}")
    if rest:
        (options.files if options.command == "run" else options.names).extend(rest)
    return options


def _reproduce(options: argparse.Namespace) -> int:
    from .reproduce import reproduce

    return reproduce(options.names, options.folder)
