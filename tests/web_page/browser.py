"""A real Chromium without a window, driven over its DevTools protocol."""

import asyncio
import base64
import json
import shutil
import subprocess
import time
from pathlib import Path
from typing import Any, Self

from tornado.httpclient import HTTPRequest
from tornado.websocket import WebSocketClientConnection, websocket_connect

CHROMIUM = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
)
PHONE, SMALL_PHONE, TABLET = (412, 915, 2.0), (360, 640, 2.0), (1280, 800, 1.0)
"""Width and height in CSS pixels, and pixels of the screen in each."""
_STARTS = 60.0  # s


class Browser:
    """One page of a browser."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._loop = asyncio.new_event_loop()
        self._count = 0
        self.console: list[str] = []  # What went wrong in the page, and what it logs.

    def __enter__(self) -> Self:
        self._process = subprocess.Popen(
            [
                str(CHROMIUM), "--headless=new", "--no-sandbox", "--disable-gpu",
                "--remote-debugging-port=0", f"--user-data-dir={self._folder}",
                "--no-first-run", "--disable-dev-shm-usage", "about:blank",
            ],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        self._connection: WebSocketClientConnection = self._loop.run_until_complete(self._connect())
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.send(f"{domain}.enable")
        return self

    def __exit__(self, *_: object) -> None:
        self._connection.close()
        self._loop.close()
        self._process.terminate()
        self._process.wait(20.0)

    async def _connect(self) -> WebSocketClientConnection:
        deadline = time.monotonic() + _STARTS
        note = self._folder / "DevToolsActivePort"
        while not (note.is_file() and note.read_text().count("\n")):
            assert time.monotonic() < deadline, "Chromium does not start"
            await asyncio.sleep(0.05)
        port, path = note.read_text().split("\n")[:2]
        browser = await websocket_connect(f"ws://127.0.0.1:{port}{path}")
        await browser.write_message(json.dumps({"id": 0, "method": "Target.getTargets"}))
        answer = json.loads(await browser.read_message())
        (page,) = [one for one in answer["result"]["targetInfos"] if one["type"] == "page"]
        browser.close()
        request = HTTPRequest(f"ws://127.0.0.1:{port}/devtools/page/{page['targetId']}")
        return await websocket_connect(request, max_message_size=1 << 26)

    def send(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Call a method, and return its result."""
        return self._loop.run_until_complete(self._send(method, parameters))

    async def _send(self, method: str, parameters: dict[str, Any]) -> dict[str, Any]:
        self._count += 1
        message = {"id": self._count, "method": method, "params": parameters}
        await self._connection.write_message(json.dumps(message))
        while True:
            text = await asyncio.wait_for(self._connection.read_message(), _STARTS)
            assert text is not None, "Chromium has ended"
            answer = json.loads(text)
            if answer.get("id") == self._count:
                assert "error" not in answer, answer
                return answer["result"]
            self._note(answer)

    def _note(self, event: dict[str, Any]) -> None:
        if event.get("method") in ("Runtime.exceptionThrown", "Log.entryAdded"):
            self.console.append(json.dumps(event["params"]))

    def open(self, url: str, size: tuple[int, int, float] = PHONE, scheme: str = "light") -> None:
        width, height, ratio = size
        self.send(
            "Emulation.setDeviceMetricsOverride", width=width, height=height,
            deviceScaleFactor=ratio, mobile=True,
        )  # fmt: skip
        feature = {"name": "prefers-color-scheme", "value": scheme}
        self.send("Emulation.setEmulatedMedia", features=[feature])
        self.send("Page.navigate", url=url)

    def evaluate(self, expression: str) -> Any:
        """Return the value of JavaScript in the page."""
        result = self.send("Runtime.evaluate", expression=expression, returnByValue=True)
        assert "exceptionDetails" not in result, result
        return result["result"].get("value")

    def text(self, selector: str) -> str:
        return str(self.evaluate(f"document.querySelector({selector!r})?.textContent ?? ''"))

    def wait_for(self, condition: str, seconds: float = 30.0) -> None:
        deadline = time.monotonic() + seconds
        while not self.evaluate(condition):
            assert time.monotonic() < deadline, (condition, self.console)
            time.sleep(0.1)

    def screenshot(self, path: Path, *, whole: bool = True) -> None:
        shot = self.send("Page.captureScreenshot", captureBeyondViewport=whole)
        path.write_bytes(base64.b64decode(shot["data"]))
