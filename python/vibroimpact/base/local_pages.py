"""Requests that the server rejects: with a foreign host name, from pages of other sites, without a token, and for
paths that do not exist."""

from __future__ import annotations

import hmac
from typing import Any
from urllib.parse import unquote, urlencode, urlsplit

from tornado.httputil import HTTPServerRequest
from tornado.routing import Matcher, Rule
from tornado.web import Application, OutputTransform, RequestHandler

__all__ = ["protect"]

#: Headers of all answers: no other page may show this one in a frame, or load its files.
HEADERS = {
    "X-Frame-Options": "DENY",
    "Content-Security-Policy": "frame-ancestors 'none'",
    "Cross-Origin-Resource-Policy": "same-origin",
    "X-Content-Type-Options": "nosniff",
}


def protect(application: Application, names: tuple[str, ...], port: int, token: str = "") -> None:
    """Make a server answer only requests for its own page and the links to it, under one of its names; other
    requests get status 403.

    Paths that lead upwards get status 404, and so do paths of Panel's components, which would import the module
    that they name.

    Another site can make its name resolve to this machine (DNS rebinding), so the requested host name is checked
    rather than the address. With a token, only a browser that has opened a link with the token is answered: the
    browser keeps the token as a cookie, and the address of the page does not contain it.

    Parameters
    ----------
    application : tornado.web.Application
    names : tuple of str
        The names of the server, such as "localhost" or "[::1]".
    port : int
    token : str
        If empty, no token is needed.
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
    """Matches the requests to be rejected."""

    def __init__(self, hosts: frozenset[str]) -> None:
        self.hosts = hosts

    def match(self, request: HTTPServerRequest) -> dict[str, Any] | None:
        headers = request.headers
        asked = [host.lower() for host in headers.get_list("Host")]
        if len(asked) != 1 or asked[0] not in self.hosts:
            return {}
        if any(not self.own(origin) for origin in headers.get_list("Origin")):
            return {}
        # browsers report the site of the page that sends the request; a link to this page may be on any site
        # site
        site = headers.get("Sec-Fetch-Site", "none")
        opened = (headers.get("Sec-Fetch-Mode"), headers.get("Sec-Fetch-Dest")) == (
            "navigate", "document",
        )  # fmt: skip
        return None if site in ("none", "same-origin") or opened else {}

    def own(self, origin: str) -> bool:
        """Whether an Origin header names this server."""
        try:
            parts = urlsplit(origin.lower())
        except ValueError:
            return False
        return parts.scheme == "http" and parts.netloc in self.hosts


class Key:
    """The token of a request: `token` in the query, or a cookie."""

    def __init__(self, token: str, cookie: str) -> None:
        self.token, self.cookie = token, cookie

    def is_token(self, text: bytes) -> bool:
        """Compare in constant time."""
        return hmac.compare_digest(text, self.token.encode())

    def in_query(self, request: HTTPServerRequest) -> bool:
        """Whether the query contains the token."""
        return any(map(self.is_token, request.query_arguments.get("token", ())))

    def in_cookie(self, request: HTTPServerRequest) -> bool:
        """Whether the cookie contains the token."""
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
    """Gives the token to the browser as a cookie, and redirects to the page without it."""

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
        self.finish(
            "403: the explorer answers only requests from its own page, at the printed address\n"
        )

    def _log(self) -> None:
        """Print nothing: another site could flood the terminal."""


class Stray(Matcher):  # type: ignore[misc]
    """Matches paths that do not exist: upwards, with control characters, and those of components."""

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
