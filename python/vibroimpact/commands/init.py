"""`vibroimpact init`: a commented namelist to start from."""

from __future__ import annotations

import argparse
from importlib.resources import files
from pathlib import Path

from ..errors import ParameterError
from ..files import write_text

HELP = "write a commented namelist to start from"
DESCRIPTION = """Write NAME.nml, a namelist of one kind of case with every key explained, which runs as it
is. A file that is there is kept."""
EXAMPLE = "vibroimpact init zone"

TEMPLATES = files("vibroimpact") / "templates"


def kinds() -> dict[str, str]:
    """The kinds of cases, each with the namelist to start from."""
    found = {
        Path(item.name).stem: item.read_text(encoding="utf-8")
        for item in TEMPLATES.iterdir() if item.name.endswith(".nml")
    }  # fmt: skip
    return dict(sorted(found.items()))


def arguments(parser: argparse.ArgumentParser) -> None:
    """The kind and the file, or --list."""
    known = kinds()
    parser.add_argument(
        "name", nargs="?", metavar="NAME", choices=known, help=f"one of {', '.join(known)}"
    )
    parser.add_argument("-o", dest="file", metavar="FILE.nml", help="the file (default: NAME.nml)")
    parser.add_argument("--list", action="store_true", help="tell what each kind of case is")
    parser.add_argument("--force", action="store_true", help="write over a file that is there")


def run(options: argparse.Namespace) -> int:
    """Write it, or list what there is."""
    known = kinds()
    if options.list:
        for name, text in known.items():
            title = text.partition("\n")[0].removeprefix("! ")
            print(f"{name:<12} {title}")
            options.record.add(name, title)
        return 0
    if options.name is None:
        raise ParameterError(f"NAME: must be given, one of {', '.join(known)}; or --list")
    path = Path(options.file or f"{options.name}.nml")
    if path.exists() and not options.force:
        raise ParameterError(f"{path}: is there already; must be another file, or --force")
    if not path.parent.is_dir():
        raise ParameterError(
            f"-o {path}: there is no folder {path.parent}; must be in one that is there"
        )
    write_text(path, known[options.name].replace(f"{options.name}.nml", str(path)))
    options.record.files.append(str(path))
    print(f"{path}: run it by `vibroimpact run {path} -o results`")
    return 0
