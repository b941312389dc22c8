"""Requests that the server refuses: under a foreign host name, of pages of other sites, without a token, and for
what no page has."""

from __future__ import annotations

import hmac
from typing import Any
from urllib.parse import unquote, urlencode, urlsplit

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


def protect(application: Application, names: tuple[str, ...], port: int, token: str = "") -> None:
    """Make a server answer only its own page and links to it, by one of its names; others get status 403.

    Paths that lead upwards, and those of Panel's components, which import the module that they name, get 404.

    A name of another site can be made to lead to this machine (DNS rebinding), so the name counts that was asked
    for, not the address that was reached. With a token only a browser is answered that has opened a link with it:
    the browser keeps it as a cookie, and the page's own address is without it.

    Parameters
    ----------
    application : tornado.web.Application
    names : tuple of str
        Its names, as "localhost" or "[::1]".
    port : int
    token : str
        If empty, none is needed.
    """
    hosts = frozenset(f"{name}:{port}" for name in names) | (set(names) if port == 80 else set())
    rules = [Rule(Foreign(hosts), Refusal)]
    if token:
        key = Key(token, f"vibroimpact-{port}")
        rules += [Rule(Opening(key), Opened, {"key": key}), Rule(Unknown(key), Refusal)]
    rules.append(Rule(Stray(), Nothing))
    application.default_router.rules[:0] = rules
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


class Key:
    """The token, where a request may hold it: as `token` of the query, or as a cookie."""

    def __init__(self, token: str, cookie: str) -> None:
        self.token, self.cookie = token, cookie

    def is_token(self, text: bytes) -> bool:
        """Compare in a time that does not depend on where they differ."""
        return hmac.compare_digest(text, self.token.encode())

    def in_query(self, request: HTTPServerRequest) -> bool:
        """Whether the query holds it."""
        return any(map(self.is_token, request.query_arguments.get("token", ())))

    def in_cookie(self, request: HTTPServerRequest) -> bool:
        """Whether the cookie holds it."""
        held = request.cookies.get(self.cookie)
        return held is not None and self.is_token(held.value.encode())


class Opening(Matcher):  # type: ignore[misc]
    """Matches links to the page with the token."""

    def __init__(self, key: Key) -> None:
        self.key = key

    def match(self, request: HTTPServerRequest) -> dict[str, Any] | None:
        here = request.method == "GET" and request.path == "/"
        return {} if here and self.key.in_query(request) else None


class Opened(RequestHandler):  # type: ignore[misc]
    """Gives the token to the browser, and leads to the page without it."""

    def initialize(self, key: Key) -> None:
        self.key = key

    def get(self) -> None:
        self.set_cookie(self.key.cookie, self.key.token, httponly=True, samesite="Lax", path="/")
        query = self.request.query_arguments
        rest = [
            (name, values[-1].decode("utf-8", "replace"))
            for name, values in query.items() if name != "token"
        ]  # fmt: skip
        self.redirect(f"/?{urlencode(rest)}" if rest else "/")

    def _log(self) -> None:
        """Print nothing."""


class Unknown(Matcher):  # type: ignore[misc]
    """Matches the requests without the token."""

    def __init__(self, key: Key) -> None:
        self.key = key

    def match(self, request: HTTPServerRequest) -> dict[str, Any] | None:
        return None if self.key.in_cookie(request) else {}


class Refusal(RequestHandler):  # type: ignore[misc]
    """Status 403 for every method, and for a websocket's first request."""

    def prepare(self) -> None:
        self.set_status(403)
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        self.finish("403: the explorer answers only its own page, at the address that it printed\n")

    def _log(self) -> None:
        """Print nothing: another site could flood the terminal."""


class Stray(Matcher):  # type: ignore[misc]
    """Matches paths that no page has: upwards, with control characters, and those of components."""

    def match(self, request: HTTPServerRequest) -> dict[str, Any] | None:
        path = unquote(request.path).replace("\\", "/")
        parts = path.split("/")
        stray = ".." in parts or not path.isprintable() or "components" in parts[1:2]
        return {} if stray else None


class Nothing(Refusal):
    """Status 404 for every method."""

    def prepare(self) -> None:
        self.set_status(404)
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        self.finish("404: there is no such page\n")


class Headers(OutputTransform):  # type: ignore[misc]
    """Adds the headers to every answer."""

    def transform_first_chunk(
        self, status_code: int, headers: Any, chunk: bytes, finishing: bool
    ) -> tuple[int, Any, bytes]:
        for name, value in HEADERS.items():
            headers[name] = value
        return status_code, headers, chunk
