"""`vibroimpact explore`: the interactive explorer in a browser on this machine."""

from __future__ import annotations

import argparse

from ..base.errors import ParameterError
from ..formats.load import load

DESCRIPTION = """Serve a page on this machine and open it. The page shows the zones of stable motions over
frequency ratio and clearance, which follow the sliders, and the motions under the pointer,
with simulations, bifurcation diagrams, links and namelists, a map of max|X|/A, and a box of
tolerances. With FILE it opens a saved result: a motion, an identification, or a
design with its tolerances. Ctrl-C stops it. It needs the extra `explorer`:
pip install 'vibroimpact[explorer]'."""
EXAMPLE = "vibroimpact explore --port 5006 --no-browser"


def arguments(parser: argparse.ArgumentParser) -> None:
    """The initial contents, where to serve, and whether to open a browser."""
    parser.add_argument(
        "file", nargs="?", metavar="FILE",
        help="a saved motion, identification or design (.json, .nc or .mat)",
    )  # fmt: skip
    parser.add_argument(
        "--units", metavar="TEXT",
        help="physical units to show: M, K and F0 and their units of length, force and time, "
        "such as '2.7 42000 6 m N s'",
    )  # fmt: skip
    parser.add_argument(
        "--port", type=int, default=5006, metavar="N",
        help="port of the page (default: 5006; 0: any free port)",
    )  # fmt: skip
    parser.add_argument(
        "--address", default="127.0.0.1", metavar="A",
        help="address to listen on (default: 127.0.0.1, this machine only); any other one requires the token in "
        "the printed link",
    )  # fmt: skip
    browser = parser.add_mutually_exclusive_group()
    browser.add_argument(
        "--show", dest="show", action="store_true", default=True, help="open a browser (default)"
    )
    browser.add_argument(
        "--no-browser", dest="show", action="store_false", help="only print the address of the page"
    )


def run(options: argparse.Namespace) -> int:
    """Serve until Ctrl-C, the normal end, with status 0."""
    from ..explorer.opening import state_of
    from ..explorer.server import serve
    from ..explorer.state import State

    if not 0 <= options.port <= 65535:
        raise ParameterError(f"--port {options.port}: must be a whole number from 0 to 65535")
    state = State() if options.file is None else state_of(load(options.file))
    if options.units is not None:
        state = state.changed({"units": options.units})
    serve(options.address, options.port, options.show, print_address, state.query)
    print("ended")
    return 0


def print_address(url: str) -> None:
    """Print the address of the page."""
    print(f"explorer: {url}   (Ctrl-C ends it)", flush=True)
    if "token=" in url:
        print(
            "Other machines can reach this page, and anyone who has the link can use it. The connection is "
            "not encrypted: outside a network that you trust, use ssh -L and the address 127.0.0.1.",
            flush=True,
        )
