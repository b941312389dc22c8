"""The explorer's server: by default for this machine only; it loads nothing from the network."""

from __future__ import annotations

import errno
import ipaddress
import logging
import secrets
import signal
import socket
import sys
from collections.abc import Callable
from typing import Any

from ..base import checks
from ..base.errors import MissingExtraError, ParameterError
from .opening import state_of
from .state import State

__all__ = ["explore", "interface", "serve"]

#: Largest message of a page, in bytes; one with all fields is a few kB.
LARGEST = 100_000


def panel() -> Any:
    """Panel with Bokeh, or an error that says how to get them."""
    try:
        import bokeh  # noqa: F401
        import panel
    except ImportError:
        raise MissingExtraError(
            "the explorer needs panel and bokeh: pip install 'vibroimpact[explorer]'"
        ) from None
    return panel


def interface(address: str) -> str:
    """An address of this machine, as a number.

    Examples
    --------
    >>> from vibroimpact.explorer.server import interface
    >>> interface("localhost")
    '127.0.0.1'
    >>> interface("0.0.0.0")
    Traceback (most recent call last):
    vibroimpact.ParameterError: --address '0.0.0.0': must be localhost or one address of this machine, ...
    """
    try:
        number = ipaddress.ip_address("127.0.0.1" if address == "localhost" else address)
    except ValueError:
        number = None
    if number is None or number.is_unspecified or number.is_multicast:
        raise ParameterError(
            f"--address {address!r}: must be localhost or one address of this machine, such as 127.0.0.1, ::1 or "
            "192.168.1.5; requests under other names are rejected, so it cannot be all addresses"
        )
    return str(number)


def needs_token(number: str) -> bool:
    """Whether other machines may reach an address."""
    return not ipaddress.ip_address(number).is_loopback


def explore(
    start: Any = None, *, port: int = 5006, address: str = "127.0.0.1", show: bool = True,
    ready: Callable[[str], None] = print,
) -> None:  # fmt: skip
    """Serve the explorer until Ctrl-C (extra `explorer`).

    Parameters
    ----------
    start : Oscillator, Motion, Design or Identification, optional
        What the page shows first; see `state_of` in `vibroimpact.explorer.opening`.
    port : int
        0 for any free port.
    address : str
        A loopback address, or one that other machines can reach. In the second case no browser is opened, and only
        users who have the link passed to `ready`, which contains a random token, can open the page.
    show : bool
        Whether to open a browser.
    ready : callable
        Called with the address of the page.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed, or the page cannot show `start`.
    MissingExtraError
        If panel or bokeh is not installed.
    """
    state = State() if start is None else state_of(start)
    serve(address, checks.integer(port, "port", 0, 65535), show, ready, state.query)


def serve(
    address: str, port: int, show: bool, ready: Callable[[str], None], query: str = ""
) -> None:
    """Serve until an interrupt; `ready` is called with the address of the page, which includes the state as its
    query.

    An address that other machines can reach contains a token; requests without it are not answered.

    Raises
    ------
    MissingExtraError, ParameterError
        If panel is not installed, the address does not belong to this machine, or the port is in use.
    """
    number = interface(address)
    pn = panel()
    from tornado.ioloop import IOLoop

    from ..base.local_pages import protect
    from .page import page

    host = f"[{number}]" if ":" in number else number
    port = _free(number, port)
    loop = IOLoop.current()
    token = secrets.token_urlsafe(32) if needs_token(number) else ""
    names = (host,) if token else tuple(dict.fromkeys((host, "localhost")))
    server = pn.serve(
        {"/": page}, port=port, address=number, show=False, start=False, verbose=False, loop=loop,
        title="vibroimpact explorer", websocket_origin=[f"{name}:{port}" for name in names],
        # a ping may reach a page that is closing before its messages are read, which Bokeh reports as an error
        keep_alive_milliseconds=0, websocket_max_message_size=LARGEST,
    )  # fmt: skip
    protect(server._tornado, names, port, token)
    query = "&".join(filter(None, (f"token={token}" if token else "", query)))
    url = f"http://{host}:{port}/" + (f"?{query}" if query else "")
    # handled by the event loop, so that an interrupt never occurs while a message is processed
    for number_of in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number_of, lambda *_: loop.add_callback_from_signal(loop.stop))
    # it is not an error if a page is closed while a message is being sent to it
    logging.getLogger("bokeh.server.views.ws").setLevel(logging.ERROR)
    loop.asyncio_loop.set_exception_handler(_unless_closed)
    # computing threads release the interpreter to the page after a millisecond
    sys.setswitchinterval(1e-3)
    server.start()
    ready(url)
    if (
        show and not token
    ):  # all users of this machine can see command lines, and so would see the token
        import webbrowser

        loop.add_callback(webbrowser.open, url)
    try:
        loop.start()
    finally:
        server.stop()


def _unless_closed(loop: Any, context: dict[str, Any]) -> None:
    """Report an error that was not handled, unless a closed page caused it."""
    from tornado.websocket import WebSocketClosedError

    if not isinstance(context.get("exception"), WebSocketClosedError):
        loop.default_exception_handler(context)


def _free(address: str, port: int) -> int:
    """The port, or any free one for 0; raises an error if it is not available."""
    family = socket.AF_INET6 if ":" in address else socket.AF_INET
    with socket.socket(family, socket.SOCK_STREAM) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((address, port))
        except OSError as error:
            if error.errno == errno.EADDRNOTAVAIL:
                raise ParameterError(
                    f"--address {address!r}: must be localhost or one address of this machine"
                ) from None
            raise ParameterError(
                f"--port {port}: cannot be used on {address} ({str(error.strerror).lower()}); choose another "
                "port, or 0 for any that is free"
            ) from None
        free: int = probe.getsockname()[1]
        return free
