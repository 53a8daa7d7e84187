"""Serves the page to browsers, read only, from a thread of its own.

A browser loads three files and then one response without end: a line of JSON for each frame. It is
sent the newest frame as soon as it took the one before, so nothing queues up for a slow one.
"""

from __future__ import annotations

import asyncio
import contextlib
import hmac
import secrets
import socket
import threading
from ipaddress import ip_address
from pathlib import Path
from typing import Any, Final
from urllib.parse import urlsplit

from jinja2 import Environment, StrictUndefined
from tornado.httpserver import HTTPServer
from tornado.iostream import IOStream, StreamClosedError
from tornado.web import Application, HTTPError, RequestHandler

from gsapp.telemetry.settings import TELEMETRY
from gsapp.telemetry.sources.link_source import network_error
from gsapp.telemetry.sources.network import listen_on, resolve
from ui.theme import DARK, DAYLIGHT
from ui.translation import tr
from ui.web_page.page_frame import PageFrame
from ui.web_page.page_link import parse_page_link
from ui.web_page.settings import WEB_PAGE

_LETTERS: Final = "abcdefghjkmnpqrstuvwxyz23456789"  # None is taken for another one.
_FILES: Final = {"page.html": "text/html", "page.css": "text/css", "page.js": "text/javascript"}
_HEADERS: Final = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
        "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Cache-Control": "no-store",
}


def _render_files() -> dict[str, tuple[str, bytes]]:
    """Return content type and content of each file by its path in an address."""
    folder = Path(__file__).with_name("templates")
    environment = Environment(undefined=StrictUndefined, autoescape=True)
    words = {
        "title": tr("Ground station"),
        "last": tr("Last maneuver"),
        "leg": tr("LEG LEFT"),
        "lost": tr("NO CONNECTION"),
        "connecting": tr("Connecting to the ground station"),
        "refused": tr("Open the whole address that the ground station shows, with its key."),
        "busy": tr("As many browsers as possible are connected."),
    }
    files = {}
    for name, kind in _FILES.items():
        text = (folder / name).read_text(encoding="utf-8")
        if not name.endswith(".js"):
            text = environment.from_string(text).render(words=words, light=DAYLIGHT, dark=DARK)
        files[name.replace("page.html", "")] = f"{kind}; charset=utf-8", text.encode()
    return files


class _Handler(RequestHandler):
    """What all answers have in common: who may ask, and what a browser may do with them."""

    def initialize(self, server: PageServer) -> None:
        self.server = server

    def set_default_headers(self) -> None:
        self.clear_header("Server")
        for name, value in _HEADERS.items():
            self.set_header(name, value)

    def prepare(self) -> None:
        # A stranger's page, whose name leads to this computer, names itself here.
        if not self.server.is_own_host(self.request.headers.get("Host", "")):
            raise HTTPError(403)

    def write_error(self, status_code: int, **_details: Any) -> None:
        self.set_header("Content-Type", "text/plain")
        self.finish(str(status_code))


class _FileHandler(_Handler):
    def get(self, name: str) -> None:
        try:
            kind, content = self.server.files[name]
        except KeyError:
            raise HTTPError(404) from None
        self.set_header("Content-Type", kind)
        self.write(content)


class _FrameHandler(_Handler):
    """The frames, one after the other, until the browser hangs up."""

    _task: asyncio.Task[Any] | None = None

    async def get(self) -> None:
        server = self.server
        if not server.is_key(self.request.headers.get("Authorization", "")):
            await asyncio.sleep(WEB_PAGE.refusal_delay)
            raise HTTPError(401)
        if len(server.tasks) >= TELEMETRY.max_clients:
            raise HTTPError(503)
        self._task = asyncio.current_task()
        server.tasks.add(self._task)
        self.set_header("Content-Type", "application/x-ndjson")
        self.set_header("X-Accel-Buffering", "no")
        try:
            await self._send_frames()
        except (TimeoutError, asyncio.CancelledError, StreamClosedError):
            self._hang_up()
        finally:
            server.tasks.discard(self._task)

    async def _send_frames(self) -> None:
        after, record = 0, -1
        last: PageFrame | None = None
        while True:
            frame = await self.server.next_frame(last)
            if frame.record != record:
                after, record = 0, frame.record
            self.write(frame.encode(after - WEB_PAGE.overlap))
            await asyncio.wait_for(self.flush(), WEB_PAGE.send_timeout)
            after, last = frame.end_column, frame

    def _hang_up(self) -> None:
        with contextlib.suppress(Exception):  # it may be closed already
            self.detach().close()

    def on_connection_close(self) -> None:
        if self._task is not None:
            self._task.cancel()


class _BoundedServer(HTTPServer):
    """Refuses connections beyond a number."""

    _count = 0

    def handle_stream(self, stream: IOStream, address: tuple[Any, ...]) -> None:
        if self._count >= WEB_PAGE.max_connections:
            stream.close()
            return
        self._count += 1
        super().handle_stream(stream, address)

    def on_close(self, server_conn: object) -> None:
        self._count -= 1
        super().on_close(server_conn)


class PageServer:
    """A page at an address, until it is closed.

    Parameters
    ----------
    link : str
        ``http:HOST:PORT``.
    is_open : bool
        Whether other computers need no key.

    Raises
    ------
    LinkError
        If it is no such address, or another program has the port.
    """

    def __init__(self, link: str, *, is_open: bool = False) -> None:
        self.link = link
        self._address = parse_page_link(link)
        self.files = _render_files()
        self.tasks: set[asyncio.Task[Any] | None] = set()  # One for each browser.
        try:
            host = ip_address(resolve(self._address, socket.SOCK_STREAM)[1][0])
            self._socket = listen_on(self._address)
        except OSError as error:
            raise network_error(self._address, error) from error
        # What waits in the system is old when it arrives; connections have it from the listener.
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, TELEMETRY.client_send_buffer)
        self._host = _own_address() if host.is_unspecified else self._address.host
        needs_key = not (host.is_loopback or is_open)
        key = "".join(secrets.choice(_LETTERS) for _ in range(WEB_PAGE.key_length))
        self._key = key if needs_key else ""
        self._frame = PageFrame()
        self._runner = asyncio.Runner(loop_factory=asyncio.SelectorEventLoop)
        self._loop = self._runner.get_loop()
        self._changed = asyncio.Event()
        self._over = asyncio.Event()
        self._thread = threading.Thread(target=self._run, name="web page", daemon=True)
        self._thread.start()

    @property
    def url(self) -> str:
        """Return the address for a browser. The key stays in it: a browser sends no fragment."""
        host = f"[{self._host}]" if ":" in self._host else self._host
        return f"http://{host}:{self._address.port}/" + (f"#{self._key}" if self._key else "")

    @property
    def client_count(self) -> int:
        """Return how many browsers show the page."""
        return len(self.tasks)

    def publish(self, frame: PageFrame) -> None:
        """Let browsers show a frame; returns at once."""
        with contextlib.suppress(RuntimeError):  # closed
            self._loop.call_soon_threadsafe(self._take, frame)

    def close(self) -> None:
        """Hang up, and give the port back."""
        with contextlib.suppress(RuntimeError):
            self._loop.call_soon_threadsafe(self._over.set)
        self._thread.join(WEB_PAGE.closing_time)

    # In the thread

    def _run(self) -> None:
        with self._runner:
            self._runner.run(self._serve())

    async def _serve(self) -> None:
        application = Application(
            [
                (r"/frames", _FrameHandler, {"server": self}),
                (r"/(page\.css|page\.js|)", _FileHandler, {"server": self}),
            ],
            default_handler_class=_MissingHandler,
            default_handler_args={"server": self},
            log_function=lambda _handler: None,
        )
        server = _BoundedServer(
            application, max_header_size=WEB_PAGE.max_request_bytes,
            max_body_size=WEB_PAGE.max_request_bytes, body_timeout=WEB_PAGE.send_timeout,
            idle_connection_timeout=WEB_PAGE.idle_timeout,
        )  # fmt: skip
        server.add_sockets([self._socket])
        await self._over.wait()
        server.stop()
        for task in list(self.tasks):
            if task is not None:
                task.cancel()
        await server.close_all_connections()

    def _take(self, frame: PageFrame) -> None:
        self._frame = frame
        self._changed.set()
        self._changed = asyncio.Event()

    async def next_frame(self, last: PageFrame | None) -> PageFrame:
        """Return a frame that came after the last one; the first to a browser is a new one."""
        if last is None or last is self._frame:
            await self._changed.wait()
        return self._frame

    def is_own_host(self, host: str) -> bool:
        """Return whether a Host header names this computer: by number, or by its own name."""
        try:
            name = urlsplit(f"//{host}").hostname or ""
        except ValueError:
            return False
        own = socket.gethostname().lower()
        if name in ("localhost", self._address.host.lower(), own, f"{own}.local"):
            return True
        with contextlib.suppress(ValueError):
            return bool(ip_address(name))
        return False

    def is_key(self, authorization: str) -> bool:
        given = authorization.removeprefix("Bearer ")
        return not self._key or hmac.compare_digest(given.encode(), self._key.encode())


class _MissingHandler(_Handler):
    def prepare(self) -> None:
        super().prepare()
        raise HTTPError(404)


def _own_address() -> str:
    """Return an address by which other computers find this one; its name where it has none."""
    with contextlib.suppress(OSError), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.connect(("192.0.2.1", 9))  # nothing is sent
        return str(probe.getsockname()[0])
    return socket.gethostname()
