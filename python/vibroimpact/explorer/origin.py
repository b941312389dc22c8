"""Requests that the server refuses: those under a foreign host name, and those of pages of other sites."""

from __future__ import annotations

from typing import Any
from urllib.parse import urlsplit

from tornado.httputil import HTTPServerRequest
from tornado.routing import Matcher, Rule
from tornado.web import Application, OutputTransform, RequestHandler

__all__ = ["protect"]

#: Headers of all answers: no other page may show this one in a frame, or take its files.
HEADERS = {
    "X-Frame-Options": "DENY",
    "Content-Security-Policy": "frame-ancestors 'none'",
    "Cross-Origin-Resource-Policy": "same-origin",
    "X-Content-Type-Options": "nosniff",
}


def protect(application: Application, names: tuple[str, ...], port: int) -> None:
    """Make a server answer only its own page and links to it, by one of its names; others get status 403.

    A name of another site can be made to lead to this machine (DNS rebinding), so the name counts that was asked
    for, not the address that was reached.

    Parameters
    ----------
    application : tornado.web.Application
    names : tuple of str
        Its names, as "localhost" or "[::1]".
    port : int
    """
    hosts = frozenset(f"{name}:{port}" for name in names) | (set(names) if port == 80 else set())
    application.default_router.rules.insert(0, Rule(Foreign(hosts), Refusal))
    application.add_transform(Headers)


class Foreign(Matcher):  # type: ignore[misc]
    """Matches the requests to be refused."""

    def __init__(self, hosts: frozenset[str]) -> None:
        self.hosts = hosts

    def match(self, request: HTTPServerRequest) -> dict[str, Any] | None:
        headers = request.headers
        asked = [host.lower() for host in headers.get_list("Host")]
        if len(asked) != 1 or asked[0] not in self.hosts:
            return {}
        if any(not self.own(origin) for origin in headers.get_list("Origin")):
            return {}
        # browsers report the site of the page that sends the request; a link that opens this page may be on any
        # site
        site = headers.get("Sec-Fetch-Site", "none")
        opened = (headers.get("Sec-Fetch-Mode"), headers.get("Sec-Fetch-Dest")) == (
            "navigate", "document",
        )  # fmt: skip
        return None if site in ("none", "same-origin") or opened else {}

    def own(self, origin: str) -> bool:
        """Whether an Origin is this server."""
        try:
            parts = urlsplit(origin.lower())
        except ValueError:
            return False
        return parts.scheme == "http" and parts.netloc in self.hosts


class Refusal(RequestHandler):  # type: ignore[misc]
    """Status 403 for every method, and for a websocket's first request."""

    def prepare(self) -> None:
        self.set_status(403)
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        self.finish("403: the explorer answers only its own page, at the address that it printed\n")

    def _log(self) -> None:
        """Print nothing: another site could flood the terminal."""


class Headers(OutputTransform):  # type: ignore[misc]
    """Adds the headers to every answer."""

    def transform_first_chunk(
        self, status_code: int, headers: Any, chunk: bytes, finishing: bool
    ) -> tuple[int, Any, bytes]:
        for name, value in HEADERS.items():
            headers[name] = value
        return status_code, headers, chunk
