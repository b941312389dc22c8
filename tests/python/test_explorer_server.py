"""The explorer's server: which requests it answers, and that no page blocks another."""

import asyncio
import http.client
import re
import signal
import time
from concurrent.futures import ThreadPoolExecutor
from urllib.parse import urlsplit

import pytest
from shared_explorer import Page
from tornado.httpclient import HTTPClientError, HTTPRequest
from tornado.websocket import websocket_connect
from vibroimpact.explorer.process import start


@pytest.fixture(scope="module")
def address():
    """Host and port of a server started for the test."""
    process, url = start()
    yield urlsplit(url).hostname, urlsplit(url).port
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=20)
    assert (process.returncode, err) == (0, "")


def answer(address, path="/", host=None, method="GET", **headers):
    """Status, headers and body of the answer to a request with a given Host header."""
    connection = http.client.HTTPConnection(*address, timeout=30)
    try:
        connection.putrequest(method, path, skip_host=True)
        connection.putheader("Host", host or f"127.0.0.1:{address[1]}")
        for name, value in headers.items():
            connection.putheader(name.replace("_", "-"), value)
        connection.endheaders()
        reply = connection.getresponse()
        return reply.status, reply.headers, reply.read().decode()
    finally:
        connection.close()


def opened(address, token, **headers):
    """The status of a websocket's first request: 101 if it is opened."""

    async def ask():
        words = {name.replace("_", "-"): value for name, value in headers.items()}
        request = HTTPRequest(f"ws://127.0.0.1:{address[1]}/ws", headers=words)
        try:
            socket = await websocket_connect(request, subprotocols=["bokeh", token])
        except HTTPClientError as error:
            return error.code
        first = await socket.read_message()  # the server's ACK
        socket.close()
        return 101 if first else None

    # in a separate thread: tests in a browser keep an event loop in this one
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(asyncio.run, ask()).result()


def token_of(page):
    """The token with which a page opens its websocket."""
    return re.search(r'"token":\s*"([^"]+)"', page)[1]


#: Paths of the page, its script, its files, and its websocket.
PATHS = ("/", "/autoload.js", "/static/js/bokeh.min.js", "/ws", "/metadata", "/no/such/page")


@pytest.mark.parametrize("host", [
    "evil.example:{}", "evil.example", "127.0.0.1.evil.example:{}", "localhost.evil.example:{}", "127.0.0.1:1",
    "127.0.0.1", "[::1]:{}", "0.0.0.0:{}"])  # fmt: skip
def test_another_name_gets_nothing(address, host):
    """A name of another site that leads to this machine (DNS rebinding): status 403, no token."""
    host = host.format(address[1])
    for path in PATHS:
        status, _, body = answer(address, path, host, Origin=f"http://{host}")
        assert (status, "token" in body) == (403, False), path
    token = token_of(answer(address)[2])
    assert opened(address, token, Host=host, Origin=f"http://{host}") == 403


def test_its_own_names_are_answered(address):
    """By its address and as localhost the server gives page, files, and a websocket from its own origin."""
    for name in ("127.0.0.1", "localhost", "LOCALHOST"):
        host = f"{name}:{address[1]}"
        status, _, body = answer(address, "/", host)
        assert status == 200
        assert answer(address, "/static/js/bokeh.min.js", host)[0] == 200
        assert opened(address, token_of(body), Host=host, Origin=f"http://{host}") == 101


@pytest.mark.parametrize("origin", [
    "http://evil.example", "http://evil.example:{}", "https://127.0.0.1:{}", "http://127.0.0.1", "null",
    "http://localhost:3000", "http://[", "file://", "http://127.0.0.1:{}.evil.example"])  # fmt: skip
def test_a_page_of_another_origin_gets_nothing(address, origin):
    """Every request from another origin is refused, even with a valid token."""
    origin = origin.format(address[1])
    token = token_of(answer(address)[2])
    assert {answer(address, path, Origin=origin)[0] for path in PATHS} == {403}
    assert opened(address, token, Origin=origin) == 403


@pytest.mark.parametrize(("site", "mode", "dest", "status"), [
    ("same-origin", "no-cors", "script", 200), ("none", "navigate", "document", 200),
    ("cross-site", "navigate", "document", 200), ("cross-site", "navigate", "iframe", 403),
    ("cross-site", "no-cors", "script", 403), ("same-site", "no-cors", "image", 403)])  # fmt: skip
def test_other_sites_may_only_link_to_it(address, site, mode, dest, status):
    """By the Sec-Fetch headers a link from another site opens the page, but a frame or script is refused."""
    words = {"Sec_Fetch_Site": site, "Sec_Fetch_Mode": mode, "Sec_Fetch_Dest": dest}
    assert answer(address, "/", **words)[0] == status


def test_no_page_may_frame_it(address):
    """Every answer, refusals included, forbids frames."""
    for path, host in (
        ("/", None),
        ("/static/js/bokeh.min.js", None),
        ("/metadata", None),
        ("/", "evil"),
    ):
        headers = answer(address, path, host)[1]
        assert headers["X-Frame-Options"] == "DENY", path
        assert "frame-ancestors 'none'" in headers["Content-Security-Policy"], path


#: What a hostile link may ask for: a simulation of 10^10 oscillations, a motion of very many impacts.
HOSTILE = (
    "r=0.000001&r_min=0.0000005&r_max=0.000002&clearance=1e-12&clearance_min=1e-12"
    "&motion=RL/10000/state/0,0,0,0,0",
    "r=0.000001&r_min=0.000001&r_max=0.000002&clearance=1e-12&clearance_min=1e-12"
    "&motion=RL/16/state/0,0,0,0,0&run=0,0,0,0,0,200,20000&line=0.000001,1e-12,0.000002,1",
)  # fmt: skip


@pytest.mark.parametrize("query", HOSTILE)
def test_a_hostile_link_stops_no_other_page(browser, query):
    """Another page is computed meanwhile, the linked page names what was refused, and Ctrl-C ends the server."""
    process, url = start()
    try:
        bad, good = browser.new_page(), browser.new_page()
        bad.goto(f"{url}?{query}")
        begin = time.monotonic()
        host = urlsplit(url)
        assert answer((host.hostname, host.port))[0] == 200
        assert time.monotonic() - begin < 10
        page = Page(good, url)
        page.open("patterns=RL")
        assert len(page.rows()) > 1
        bad.wait_for_selector("#fault:not([hidden])")
        assert "motion = 'RL/1" in bad.locator("#fault").text_content()
        for tab in (bad, good):
            tab.close()
    finally:
        process.send_signal(signal.SIGINT)
        try:
            _, err = process.communicate(timeout=60)
        except Exception:
            process.kill()
            process.communicate()
            raise
    assert (process.returncode, err) == (0, "")
