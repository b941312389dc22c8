"""The commands of the studies; the keys that the core declares are their options."""

from __future__ import annotations

import argparse
import textwrap
from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any

from ..results.noun import result_class
from . import STUDIES, add_files, add_forms
from .options import Option, options_of
from .request import Request, request_of


def add_study(
    parser: argparse.ArgumentParser, known: Mapping[str, Option], **own: Mapping[str, Any]
) -> None:
    """Files or options, the folder, and the formats of the results. `own` has the command's own help texts of
    options."""
    add_files(parser, "*")
    for name, option in known.items():
        parser.add_argument(f"--{name}", **(option.how() | dict(own.get(name, {}))))
    add_forms(parser)


def command(
    study: str, details: Callable[[Any], list[str]] | None = None, **own: Mapping[str, Any]
) -> tuple[
    Callable[[argparse.ArgumentParser], None],
    Callable[[argparse.Namespace], Request],
    Callable[[argparse.Namespace], int],
]:
    """The functions `arguments`, `request` and `run` of a command whose options are the keys of a study."""

    def arguments(parser: argparse.ArgumentParser) -> None:
        add_study(parser, options_of(study), **own)

    def request(options: argparse.Namespace) -> Request:
        return request_of(options, study, options_of(study))

    def run(options: argparse.Namespace) -> int:
        from .cases import run_kind

        return run_kind(options, request(options), details)

    return arguments, request, run


def plain_command(study: str) -> SimpleNamespace:
    """The command of a study that has no module here; its example comes from the class of its result."""
    arguments, request, run = command(study)
    does = STUDIES[study]
    return SimpleNamespace(
        DESCRIPTION=textwrap.fill(
            f"{does[0].upper()}{does[1:]}, for the &{study} cases of namelist files or for the case given "
            "by the options. The result is written to DIR/NAME.csv, or in another format; --plot also "
            f'writes a picture. NAME is "{study}" for the case of the options.', 96,
        ),
        EXAMPLE=f"vibroimpact {study} {result_class(study).example} -o results",
        arguments=arguments, request=request, run=run,
    )  # fmt: skip
