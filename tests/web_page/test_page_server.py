"""Who may see the page, what browsers may do with it, and browsers that misbehave."""

import contextlib
import http.client
import re
import socket
import time

import numpy as np
import pytest

from gsapp.foundation import LinkError
from gsapp.telemetry.settings import TELEMETRY
from gsapp.telemetry.stream_server import share_address
from tests.telemetry.conftest import free_port, wait_until
from tests.web_page.conftest import Page, make_frame
from ui.web_page.page_frame import PageFrame
from ui.web_page.page_server import PageServer
from ui.web_page.settings import WEB_PAGE


def receive(connection: socket.socket) -> bytes:
    """Return what comes; nothing where the other side hangs up."""
    try:
        return connection.recv(1000)
    except ConnectionError:
        return b""


def test_a_browser_is_sent_the_newest_frame_with_the_columns_that_it_lacks(page: Page) -> None:
    first, *others = page.frames(6)
    assert len(first["curves"][0][0]) == 100
    known = first["first"] + 100
    for frame in others:
        low, high = frame["curves"][0]
        assert frame["first"] == known - WEB_PAGE.overlap
        assert low[0] == frame["first"]
        assert high == [value + 1.0 for value in low]
        known = frame["first"] + len(low)


def test_missing_samples_are_null() -> None:
    frame = PageFrame(lines=((np.array([1.0, np.nan]), np.array([2.0, np.nan]), 1),))
    assert b"[[[1.0,null],[2.0,null]]]" in frame.encode(0)


def test_a_frame_that_is_old_is_not_sent(page: Page) -> None:
    """A window that hangs shows its last cue to nobody who connects afterwards."""
    wait_until(lambda: page.published > 3)
    page.pause()
    with socket.create_connection(("127.0.0.1", page.port)) as browser:
        browser.sendall(b"GET /frames HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
        browser.settimeout(1.0)
        with pytest.raises(TimeoutError):
            browser.recv(1)
        page.server.publish(make_frame(500))
        assert browser.recv(100).startswith(b"HTTP/1.1 200")


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "PATCH", "OPTIONS", "HEAD"])
@pytest.mark.parametrize("path", ["/", "/frames"])
def test_only_get_is_answered(page: Page, method: str, path: str) -> None:
    body = "go" if method in ("POST", "PUT", "PATCH") else None
    assert page.ask(path, method, body).status == 405


@pytest.mark.parametrize(
    ("host", "status"),
    [
        ("127.0.0.1", 200), ("localhost:8080", 200), ("192.168.1.20:8080", 200), ("[::1]:80", 200),
        (socket.gethostname(), 200), ("stranger.example", 403), ("127.0.0.1.stranger.example", 403),
        ("", 403), ("[", 403),
    ],
)  # fmt: skip
def test_a_page_of_a_stranger_cannot_read_it_by_a_name_of_its_own(
    page: Page, host: str, status: int
) -> None:
    """DNS rebinding: the name of the stranger's page suddenly leads to this computer."""
    for path in ("/", "/page.js", *(("/frames",) if status == 403 else ())):
        assert page.ask(path, Host=host).status == status


@pytest.mark.parametrize("is_open", [False, True])
def test_other_computers_need_the_key_unless_the_crew_allows_all(is_open: bool) -> None:
    page = Page("0.0.0.0", is_open=is_open)  # noqa: S104
    try:
        assert bool(page.key) is not is_open
        if is_open:
            assert page.frames(1)
            return
        for wrong in ({}, {"Authorization": "Bearer "}, {"Authorization": f"Bearer {page.key}x"}):
            begin = time.monotonic()
            assert page.ask("/frames", **wrong).status == 401
            assert time.monotonic() - begin >= WEB_PAGE.refusal_delay
        assert page.frames(1, Authorization=f"Bearer {page.key}")
        for path in ("/", "/page.js", "/page.css"):
            assert page.key.encode() not in page.ask(path).read()
    finally:
        page.close()


def test_a_key_is_made_anew_every_time() -> None:
    keys = []
    for _ in range(2):
        server = PageServer(f"http:0.0.0.0:{free_port(socket.SOCK_STREAM)}")
        keys.append(server.url.partition("#")[2])
        server.close()
    assert keys[0] != keys[1]
    assert all(re.fullmatch(r"[a-z2-9]{10}", key) for key in keys)


def test_no_script_but_that_of_the_page_runs(page: Page) -> None:
    answer = page.ask()
    policy = answer.headers["Content-Security-Policy"].split("; ")
    assert "default-src 'none'" in policy
    assert "script-src 'self'" in policy
    content = answer.read().decode()
    assert re.findall(r"<script[^>]*>", content) == ['<script src="page.js" defer>']
    loaded = content + "".join(page.ask(f"/page.{kind}").read().decode() for kind in ("js", "css"))
    assert "innerHTML" not in loaded
    assert not re.search(r"(https?:)?//[a-z]", loaded)  # nothing comes from the internet


@pytest.mark.parametrize("path", ["/../page.py", "/templates/page.js", "/%2e%2e/x", "/frames/x"])
def test_nothing_else_is_served(page: Page, path: str) -> None:
    assert page.ask(path).status == 404


def test_a_browser_that_never_reads_delays_nobody_and_is_disconnected(
    page: Page,
) -> None:
    page.make = lambda end: make_frame(end, flight="f" * 100_000)
    with socket.socket() as stuck:
        stuck.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        stuck.connect(("127.0.0.1", page.port))
        stuck.sendall(b"GET /frames HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
        wait_until(lambda: page.server.client_count == 1)
        ends = [frame["first"] + len(frame["curves"][0][0]) for frame in page.frames(40)]
        assert ends == sorted(set(ends))
        assert page.published + 100 - ends[-1] < 20
        wait_until(lambda: page.server.client_count == 0)
    assert page.slowest < 0.5


def test_the_ninth_browser_is_refused_until_another_leaves(page: Page) -> None:
    request = b"GET /frames HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"
    shown = [socket.create_connection(("127.0.0.1", page.port)) for _ in range(8)]
    for browser in shown:
        browser.sendall(request)
    wait_until(lambda: page.server.client_count == TELEMETRY.max_clients == 8)
    assert page.ask("/frames").status == 503
    shown.pop().close()
    wait_until(lambda: page.server.client_count == 7)
    assert page.frames(1)
    for browser in shown:
        browser.close()
    wait_until(lambda: page.server.client_count == 0)


def test_connections_are_bounded(page: Page) -> None:
    held = [
        socket.create_connection(("127.0.0.1", page.port)) for _ in range(WEB_PAGE.max_connections)
    ]
    with socket.create_connection(("127.0.0.1", page.port)) as refused:
        refused.settimeout(10.0)
        refused.sendall(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
        assert receive(refused) == b""
    for one in held:
        one.close()

    def is_served() -> bool:
        with contextlib.suppress(ConnectionError):
            return page.ask().status == 200
        return False

    wait_until(is_served)


def test_a_request_without_end_is_given_up(page: Page) -> None:
    with socket.create_connection(("127.0.0.1", page.port)) as flood:
        flood.settimeout(10.0)
        flood.sendall(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX: " + b"x" * 20_000)
        assert not receive(flood).startswith(b"HTTP/1.1 200")


def test_the_port_is_free_again_once_the_page_is_closed(page: Page) -> None:
    with pytest.raises(LinkError):
        PageServer(page.server.link)
    browser = page.ask("/frames")
    page.close()
    with pytest.raises(http.client.IncompleteRead):  # hung up
        browser.read()
    PageServer(page.server.link).close()


@pytest.mark.parametrize("link", ["http:0.0.0.0", "http:127.0.0.1:0", "https:127.0.0.1:8080"])
def test_a_wrong_address_is_refused(link: str) -> None:
    with pytest.raises(LinkError):
        PageServer(link)


def test_a_recorder_serves_no_page() -> None:
    with pytest.raises(LinkError, match="gsapp replay"):
        share_address("http:127.0.0.1:8080")
