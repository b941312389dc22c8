"""The explorer's server: the requests that it answers, and that no page blocks another."""

import asyncio
import http.client
import json
import math
import re
import secrets
import signal
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from urllib.parse import parse_qs, urlsplit

import pytest
import vibroimpact as vi
from shared_explorer import Page
from tornado.httpclient import HTTPClientError, HTTPRequest
from tornado.websocket import websocket_connect
from vibroimpact.explorer.limits import MOST_SHOWN
from vibroimpact.explorer.messages import MOST_TEXT, PARTS, checked
from vibroimpact.explorer.process import start
from vibroimpact.explorer.server import interface, needs_token
from vibroimpact.explorer.session import Session
from vibroimpact.explorer.state import Run
from vibroimpact.explorer.turns import MOST_WAITING, Turns


@contextmanager
def served(prelude=""):
    """Host and port of a server, and its link."""
    process, url = start(prelude=prelude)
    yield (urlsplit(url).hostname, urlsplit(url).port), url
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=20)
    assert (process.returncode, err) == (0, "")


@pytest.fixture(scope="module")
def address():
    """Host and port of a server started for the test."""
    with served() as (place, _):
        yield place


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
    """The status of the first request of a websocket: 101 if it is opened."""

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
    """A foreign host name that leads to this machine (DNS rebinding) gets status 403 and no token."""
    host = host.format(address[1])
    for path in PATHS:
        status, _, body = answer(address, path, host, Origin=f"http://{host}")
        assert (status, "token" in body) == (403, False), path
    token = token_of(answer(address)[2])
    assert opened(address, token, Host=host, Origin=f"http://{host}") == 403


def test_its_own_names_are_answered(address):
    """By its address and as localhost the server gives page and files, and a websocket to its own origin."""
    for name in ("127.0.0.1", "localhost", "LOCALHOST"):
        host = f"{name}:{address[1]}"
        status, _, body = answer(address, "/", host)
        assert status == 200
        assert answer(address, "/static/js/bokeh.min.js", host)[0] == 200
        assert opened(address, token_of(body), Host=host, Origin=f"http://{host}") == 101


@pytest.mark.parametrize(
    "path",
    [
        "/components/../../etc/passwd",
        "/components/%2e%2e/a/b/c",
        "/components/..%5c..%5cetc",
        "/components/this/a/b/c",
        "/components/panel/Row/__css__/a",
        "/static/../x",
        "/static/%2e%2e/x",
        "/static/js/%00",
        "/../x",
        "/%0a",
    ],
)
def test_what_no_page_has(path, address):
    """Paths that lead upwards, and those by which Panel would import any module: 404, and the server says nothing
    (the fixture looks at what it printed)."""
    assert answer(address, path)[0] == 404
    assert answer(address, path, "evil.example")[0] == 403
    assert answer(address)[0] == 200


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
    """By the Sec-Fetch headers, a link from another site opens the page; frames and scripts are refused."""
    words = {"Sec_Fetch_Site": site, "Sec_Fetch_Mode": mode, "Sec_Fetch_Dest": dest}
    assert answer(address, "/", **words)[0] == status


def test_no_page_may_frame_it(address):
    """Every answer, including refusals, forbids frames."""
    for path, host in (
        ("/", None),
        ("/static/js/bokeh.min.js", None),
        ("/metadata", None),
        ("/", "evil"),
    ):
        headers = answer(address, path, host)[1]
        assert headers["X-Frame-Options"] == "DENY", path
        assert "frame-ancestors 'none'" in headers["Content-Security-Policy"], path


#: Make the server take its address for one that other machines can reach.
REACHED = "import vibroimpact.explorer.server as server; server.needs_token = lambda number: True"


def test_addresses_that_other_machines_reach_need_a_token():
    """Addresses that other machines reach need a token; an address for all interfaces is refused."""
    assert not any(map(needs_token, map(interface, ("localhost", "127.0.0.1", "127.8.0.1", "::1"))))
    assert all(map(needs_token, map(interface, ("192.168.1.5", "10.0.0.1", "fe80::1"))))
    for text in ("0.0.0.0", "::", "224.0.0.1", "evil.example", "", "127.0.0.1:80"):
        with pytest.raises(
            vi.ParameterError, match="must be localhost or one address of this machine"
        ):
            interface(text)


def test_with_a_token_nothing_is_answered_without_it():
    """The link gives the token to the browser as a cookie; page, files and websocket need it."""
    with served(REACHED) as (place, url):
        token = parse_qs(urlsplit(url).query)["token"][0]
        assert len(token) >= 43
        wrong = token[:-1] + ("A" if token[-1] != "A" else "B")
        for path in PATHS:
            for query in ("", "?token=", f"?token={wrong}", f"?token={secrets.token_urlsafe(32)}"):
                assert answer(place, path + query)[0] == 403, path
            assert answer(place, path, Cookie=f"vibroimpact-{place[1]}={wrong}")[0] == 403, path
        assert answer(place, f"/static/js/bokeh.min.js?token={token}")[0] == 403
        assert answer(place, f"/?token={token}", "evil.example")[0] == 403
        # the token disappears from the address, and the rest of the link remains
        status, headers, _ = answer(place, f"/?token={token}&r=0.97&patterns=RL,RRL/2")
        assert (status, headers["Location"]) == (302, "/?r=0.97&patterns=RL%2CRRL%2F2")
        cookie, _, kind = headers["Set-Cookie"].partition(";")
        assert {"HttpOnly", "SameSite=Lax"} <= {word.strip() for word in kind.split(";")}
        status, _, body = answer(place, headers["Location"], Cookie=cookie)
        assert status == 200
        assert token not in body
        assert answer(place, "/static/js/bokeh.min.js", Cookie=cookie)[0] == 200
        own = {"Origin": f"http://127.0.0.1:{place[1]}"}
        assert opened(place, token_of(body), **own) == 403
        assert opened(place, token_of(body), Cookie=cookie, **own) == 101
        other = f"localhost:{place[1]}"
        assert answer(place, "/", other, Cookie=cookie)[0] == 403


def test_so_many_pages_are_open_at_most():
    """At most a given number of pages are open; a page too many gets a message, and computes nothing."""
    with served("import vibroimpact.explorer.page as page; page.PLACES.most = 2") as (place, _):
        whole = ['id="history"' in answer(place)[2] for _ in range(4)]
    assert whole == [True, True, False, False]


def test_a_large_message_closes_the_websocket(address):
    """The server does not keep messages that a page never completes."""

    async def ask():
        token = token_of(answer(address)[2])
        request = HTTPRequest(
            f"ws://127.0.0.1:{address[1]}/ws", headers={"Origin": f"http://127.0.0.1:{address[1]}"}
        )
        socket = await websocket_connect(request, subprotocols=["bokeh", token])
        await socket.write_message("x" * 1_000_000)
        while await asyncio.wait_for(socket.read_message(), 20) is not None:
            pass  # parts of the server's ACK
        return "closed"

    with ThreadPoolExecutor(1) as thread:
        assert thread.submit(asyncio.run, ask()).result() == "closed"
    assert answer(address)[0] == 200


def test_a_flood_of_messages_is_not_kept():
    """At most so many messages wait behind a slow one; results of the page's threads are never discarded."""
    turns, go, ran = Turns(), threading.Event(), []
    turns.submit(go.wait)
    for _ in range(10 * MOST_WAITING):
        turns.offer(lambda: ran.append("offered"))
    turns.submit(lambda: ran.append("found"))
    done = threading.Event()
    turns.submit(done.set)
    go.set()
    assert done.wait(20)
    assert len(ran) <= MOST_WAITING + 1
    assert ran[-1] == "found"


LONG = "x" * (MOST_TEXT + 1)


@pytest.mark.parametrize("message", [
    None, 3, [], {}, {"kind": None}, {"kind": "__init__"}, {"kind": "close"}, {"kind": ["set"]}, {"kind": LONG},
    *({"kind": kind} for kind in PARTS), *({"kind": kind, "number": "1" * 10**5} for kind in PARTS),
    *({"kind": kind, "number": 1} for kind, parts in PARTS.items() if parts),
    *({"kind": kind, "number": 1, "r": r, "clearance": 25} for kind in ("point", "peek", "drag")
      for r in (math.nan, math.inf, "1", None, [1], True)),
    {"kind": "set", "number": 1, "words": {str(i): "1" for i in range(1000)}},
    {"kind": "set", "number": 1, "words": {"r": 1.0}}, {"kind": "set", "number": 1, "words": {"r": LONG}},
    {"kind": "run", "number": 1, "words": {}}, {"kind": "line", "number": 1, "from": [1], "to": [1, 2, 3]},
    {"kind": "export", "number": 1, "form": "__class__"}, {"kind": "choose", "number": 1, "motion": {}},
])  # fmt: skip
def test_messages_that_no_page_sends_are_refused(message):
    """Each message gets one short answer with the allowed values, and no internal error of the explorer."""
    with pytest.raises(vi.ParameterError, match="must be") as caught:
        Run.read(checked(message)["words"])
    assert len(str(caught.value)) < 300 + MOST_SHOWN


#: Numbers allowed in a message, but not for any window, box, line or simulation.
EXTREME = [
    {"kind": "point", "r": 1e300, "clearance": 1e-300}, {"kind": "peek", "r": -1.0, "clearance": 1e308},
    {"kind": "step", "right": 1e308, "up": 1e308}, {"kind": "step", "right": -1e308, "up": -1e308},
    {"kind": "launch", "y": 1e308, "y_dot": 1e308}, {"kind": "drag", "r": 0.0, "clearance": -1e308},
    {"kind": "line", "from": [1e308, 1e308], "to": [-1e308, -1e308]},
    {"kind": "set", "words": {"r_max": "1e308", "clearance_max": "1e308"}}, {"kind": "set", "words": {"no": "1"}},
    {"kind": "set", "words": {"patterns": "RL/99999999"}},
    {"kind": "set", "words": {"xi": "9" * 1999}},
    {"kind": "set", "words": {"patterns": ",".join(["RRRRLLLL/4"] * 150)}},
    {"kind": "set", "words": {"run": "0,0,0,0,0,1e9,1e9"}},
    {"kind": "set", "words": {"motion": "RL/9999/phases/0"}},
    {"kind": "run", "words": dict.fromkeys(("x", "x_dot", "z", "z_dot", "t", "cycles", "discard"), "1e300")},
]  # fmt: skip


@pytest.mark.parametrize("message", EXTREME)
def test_extreme_messages_are_answered_soon(message, caplog):
    """The answer is a result or an error that names the invalid part, but no internal error of the explorer."""
    sent, turns = [], []
    session = Session("", lambda text, numbers: sent.append(json.loads(text)), turns.append)
    session.background = Idle()
    begin = time.process_time()
    session.heard({"number": 7, **message})
    assert time.process_time() - begin < 12  # the time limit of a page, twice, on two processors
    assert sent[-1]["number"] == 7
    assert "own" not in sent[-1].get("fault", "")
    assert not caplog.records


class Idle:
    """Replaces the threads of a page, whose limits have separate tests."""

    def __getattr__(self, name):
        return self if name in ("rest", "map", "box") else lambda *_: None


#: Requests of a hostile link: a simulation of 10^10 oscillations, a motion with very many impacts.
HOSTILE = (
    "r=0.000001&r_min=0.0000005&r_max=0.000002&clearance=1e-12&clearance_min=1e-12"
    "&motion=RL/10000/state/0,0,0,0,0",
    "r=0.000001&r_min=0.000001&r_max=0.000002&clearance=1e-12&clearance_min=1e-12"
    "&motion=RL/16/state/0,0,0,0,0&run=0,0,0,0,0,200,20000&line=0.000001,1e-12,0.000002,1",
)  # fmt: skip


@pytest.mark.parametrize("query", HOSTILE)
def test_a_hostile_link_stops_no_other_page(browser, query):
    """Meanwhile another page is computed; the linked page names the refused parts, and Ctrl-C ends the server."""
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
