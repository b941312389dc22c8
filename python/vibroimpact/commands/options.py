"""Options of commands that do not make a case."""

from __future__ import annotations

import argparse


def add_system(parser: argparse.ArgumentParser) -> None:
    """The oscillator."""
    parser.add_argument("--xi", type=float, metavar="XI", help="damping ratio")
    parser.add_argument("--mu", type=float, metavar="MU", help="mass ratio m/M")
    parser.add_argument(
        "--restitution", type=float, nargs="+", metavar="R",
        help="coefficient of restitution of both walls, or of the right one and the left one",
    )  # fmt: skip


def add_numbers(parser: argparse.ArgumentParser, **wanted: str) -> None:
    """Options that are whole numbers, with their meaning."""
    for name, meaning in wanted.items():
        parser.add_argument(f"--{name.replace('_', '-')}", type=int, metavar="N", help=meaning)
