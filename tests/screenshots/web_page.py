"""The page for browsers, as a tablet shows it.

``python -m tests.screenshots.web_page --out docs/images/web-page.png`` flies the virtual aircraft,
replays the flight without a window, and saves what Chromium shows at the first GO.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from gsapp.foundation import GroundStationError
from gsapp.session import Session
from tests.screenshots.virtual_flight import write_virtual_flight
from tests.web_page.browser import TABLET, Browser
from ui.web_page.page_frame import PageFrameBuilder
from ui.web_page.page_publisher import PagePublisher
from ui.web_page.page_server import PageServer
from ui.web_page.settings import WEB_PAGE

_LINK = "http:127.0.0.1:8765"
_SPEED = 2.0


def save_page_screenshot(out: Path, scheme: str) -> None:
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        flight = write_virtual_flight(folder)
        session = Session.replay(flight, speed=_SPEED, cards="b777")
        server = PageServer(_LINK)
        publisher = PagePublisher(server, PageFrameBuilder(lambda: session))
        with Browser(folder / "browser") as browser:
            browser.open(server.url, TABLET, scheme)
            state = ""
            while state != "go":
                if session.replay_feed.at_end and session.replay_feed.complete:
                    raise GroundStationError("no GO was given in this flight")
                session.update(0.02)
                publisher.publish_due()
                cues = session.cues
                state = "" if cues is None or cues.trim is None else cues.trim.state
            for _ in range(3):  # frames that show it
                time.sleep(WEB_PAGE.interval)
                session.update(0.02)
                publisher.publish_due()
            browser.wait_for("document.getElementById('word').textContent === 'GO'", 1.0)
            browser.screenshot(out, whole=False)
        server.close()
        session.close()


def main(arguments: Sequence[str] | None = None) -> None:
    """Take one picture; see the module's text."""
    parser = argparse.ArgumentParser("tests.screenshots.web_page", description=__doc__)
    parser.add_argument("--out", type=Path, required=True, help="picture to write")
    parser.add_argument("--scheme", choices=("light", "dark"), default="light")
    given = parser.parse_args(arguments)
    save_page_screenshot(given.out, given.scheme)


if __name__ == "__main__":
    main()
