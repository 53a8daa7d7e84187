"""The page in a real Chromium, at the sizes of a phone and a tablet."""

import socket
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path

import pytest

from gsapp.flight.writers import write_flight_csv
from tests.telemetry.conftest import free_port, wait_until
from tests.ui import pilot_kit
from tests.web_page.browser import CHROMIUM, PHONE, SMALL_PHONE, TABLET, Browser
from tests.web_page.conftest import Page, make_frame

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="needs Chromium")
MARKUP = "<img src=x onerror=alert(1)><b>&amp;"
SHOWN = (
    "typeof latest !== 'undefined' && latest !== null && !document.body.classList.contains('lost')"
)


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with Browser(tmp_path_factory.mktemp("chromium")) as made:
        yield made


@pytest.fixture(autouse=True)
def _no_complaints(browser: Browser) -> Iterator[None]:
    """Nothing fails in the page, and nothing breaks its security policy."""
    browser.console.clear()
    yield
    assert [text for text in browser.console if '"source": "network"' not in text] == []


@pytest.mark.parametrize("state", sorted(pilot_kit.STATES))
@pytest.mark.parametrize("size", [SMALL_PHONE, TABLET])
def test_every_cue_is_shown_whole(
    browser: Browser, page: Page, state: str, size: tuple[int, int, float]
) -> None:
    cue = pilot_kit.display(pilot_kit.STATES[state])
    page.make = lambda end: make_frame(end, cue=asdict(cue))
    browser.open(page.server.url, size)
    browser.wait_for(SHOWN)
    assert browser.text("#word") == cue.status_text
    hints = "[...document.querySelectorAll('#hints li')].map((one) => one.textContent)"
    assert browser.evaluate(hints) == [hint.text for hint in cue.hints]
    assert browser.text("#card .text") == cue.card.text
    # In one line, and within the screen.
    assert browser.evaluate("document.documentElement.scrollWidth") == size[0]
    assert browser.evaluate(
        "(() => { const box = document.getElementById('cue'); const word = "
        "document.getElementById('word').getClientRects(); return word.length === 1 && "
        "box.scrollWidth <= box.clientWidth && word[0].bottom < innerHeight; })()"
    )


def test_names_are_text_and_never_markup(browser: Browser, page: Page) -> None:
    last = {"title": MARKUP, "time": MARKUP, "result": MARKUP, "tone": "good", "advice": MARKUP}
    page.make = lambda end: make_frame(end, text=MARKUP, last=last)
    browser.open(page.server.url)
    browser.wait_for(SHOWN)
    for selector in ("#flight", "#word", ".strip .title", ".strip .unit", "#last .title"):
        assert browser.text(selector) == MARKUP
    assert browser.evaluate("document.querySelectorAll('img').length") == 0
    assert (
        browser.evaluate("document.querySelectorAll('#word *, .strip .line *:not(span)').length")
        == 0
    )


@pytest.mark.parametrize(("scheme", "color"), [("light", [1, 71, 197]), ("dark", [116, 182, 255])])
def test_curves_are_drawn_in_the_colors_of_the_scheme(
    browser: Browser, page: Page, scheme: str, color: list[int]
) -> None:
    browser.open(page.server.url, PHONE, scheme)
    browser.wait_for(f"{SHOWN} && curves[0]?.low.length === 100")
    drawn = browser.evaluate(
        "(() => { const one = document.querySelector('canvas'); const data = one.getContext('2d')"
        ".getImageData(0, 0, one.width, one.height).data; let count = 0;"
        f"for (let i = 0; i < data.length; i += 4) if (data[i] === {color[0]} && data[i + 1] === "
        f"{color[1]} && data[i + 2] === {color[2]}) count++; return count; }})()"
    )
    assert drawn > 300
    dark = browser.evaluate("getComputedStyle(document.body).backgroundColor") < "rgb(2"
    assert dark == (scheme == "dark")


def test_a_cue_is_withdrawn_as_soon_as_nothing_comes_any_more(browser: Browser, page: Page) -> None:
    """A pilot must not fly by a GO of a laptop that is gone."""
    browser.open(page.server.url)
    browser.wait_for(SHOWN)
    assert browser.text("#word") == "GO"
    page.pause()
    browser.wait_for(f"!({SHOWN})", 10.0)
    assert browser.text("#word") == "NO CONNECTION"
    assert browser.text(".strip .value") == "–"
    assert browser.text("#gauges") == browser.text("#card .text") == ""
    page.resume()
    browser.wait_for(SHOWN)
    assert browser.text("#word") == "GO"


def test_a_page_without_the_key_shows_nothing_and_says_what_is_missing(browser: Browser) -> None:
    page = Page("0.0.0.0")  # noqa: S104
    try:
        url = f"http://127.0.0.1:{page.port}/"
        browser.open(url)
        browser.wait_for("document.querySelector('#hints li')?.textContent.includes('key')")
        assert browser.text(".strip") == ""
        browser.open(f"{url}#{page.key}")
        browser.wait_for(SHOWN)
        assert browser.text("#word") == "GO"
    finally:
        page.close()


def test_a_flight_is_replayed_without_a_window_and_shown(browser: Browser, tmp_path: Path) -> None:
    """The whole road: a flight on the disk, the command, a browser."""
    from tests.flight.maneuver_kit import Input, make_flight

    block = make_flight([Input(at=45.0, surface="de")], seconds=60.0).block
    path = write_flight_csv(tmp_path / f"{MARKUP.replace('/', '')}.csv", block, "us")
    port = free_port(socket.SOCK_STREAM)
    command = [
        sys.executable, "-m", "gsapp", "replay", str(path), "--headless", "--speed", "4",
        "--share", f"http:127.0.0.1:{port}",
    ]  # fmt: skip
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as replay:
        try:
            line = replay.stdout.readline()
            while "http://" not in line:
                line = replay.stdout.readline()
            browser.open(line.split()[-1])
            browser.wait_for(f"{SHOWN} && curves[0]?.low.length > 100")
            assert browser.text("#flight") == path.stem
            assert browser.evaluate("document.querySelectorAll('.strip canvas').length") >= 4
            before = browser.text("#time")
            wait_until(lambda: browser.text("#time") > before)
        finally:
            replay.terminate()
