"""The pilot's page in the window: keys, pixels, its own window, at several sizes and themes."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from PySide6.QtCore import QRect, QRectF, Qt
from PySide6.QtGui import QFont, QFontMetricsF
from PySide6.QtWidgets import QAbstractButton, QApplication
from pytestqt.qtbot import QtBot

import ui.pilot.pilot_canvas
from gsapp.excitation.announcer import Announcement
from gsapp.excitation.cues import CueSnapshot
from gsapp.quantities.constants import FOOT
from tests.ui.pilot_kit import BASE, CARDS, STATES, VERDICT, cue, display
from tests.ui.preflight_kit import as_opened, dress
from tests.ui.window_kit import LOOKS, SHIFT, count, open_window, pixels, press
from ui.display_style import DisplayStyle
from ui.main_window import MainWindow
from ui.pilot.cue_display import STATEMENT_SEPARATOR
from ui.pilot.page_layout import create_font, elide_text, fit_font
from ui.pilot.page_state import FlightCues
from ui.pilot.pilot_canvas import PilotCanvas, footer_text
from ui.pilot.pilot_window import find_other_screen
from ui.theme import THEMES, contrast

LAPTOP_MM = 286.5
"""Width of the screen of a laptop of 13.3 inches, 16:10."""


@pytest.fixture
def window(made: MainWindow, qtbot: QtBot) -> Iterator[MainWindow]:
    yield from as_opened(made, qtbot)
    made.pilot_page.own_window.close_with_main()
    made.pilot_page.show_page(debrief=False)


class Flown:
    def __init__(self) -> None:
        self.snapshot: CueSnapshot | None = BASE
        self.silent: float | None = None
        self.chosen: list[str] = []
        self.units: list[str] = []


@pytest.fixture
def flown(window: MainWindow, monkeypatch: pytest.MonkeyPatch) -> Flown:
    made = Flown()
    monkeypatch.setattr(FlightCues, "is_open", True)
    monkeypatch.setattr(FlightCues, "cards", CARDS)
    monkeypatch.setattr(FlightCues, "snapshot", lambda _self: made.snapshot)
    monkeypatch.setattr(FlightCues, "seconds_without_data", lambda _self: made.silent)
    monkeypatch.setattr(FlightCues, "select_card", lambda _self, card: made.chosen.append(card))
    monkeypatch.setattr(FlightCues, "set_units", lambda _self, units: made.units.append(units))
    window.show_page("pilot")
    window.pilot_page.state.restart()
    window.pilot_page.refresh()
    return made


def show(window: MainWindow, flown: Flown, cues: CueSnapshot | None) -> PilotCanvas:
    flown.snapshot = cues
    window.pilot_page.state.restart()
    window.pilot_page.refresh()
    QApplication.processEvents()
    return window.pilot_page.canvas


def inner(box: QRectF) -> QRect:
    return box.toAlignedRect()


# What is on screen


def test_f3_shows_the_page_and_the_keyboard_is_on_it(window: MainWindow, qtbot: QtBot) -> None:
    qtbot.keyClick(window, Qt.Key.Key_F3)
    assert window.pilot_page.canvas.hasFocus()
    assert window.pilot_page.canvas.display.status_text == "NO FLIGHT"
    assert "Ctrl+Shift+T" in window.pilot_page.canvas.accessibleDescription()


FILLS = {"go": "good_fill", "gusty": "caution_fill", "too-small": "caution_fill",
         "danger": "warning_fill", "good": "good_fill", "hands-off": "text"}  # fmt: skip


@pytest.mark.parametrize("theme", THEMES)
def test_states_are_shown_in_their_color_and_letters_in_ink(
    window: MainWindow, flown: Flown, theme: str
) -> None:
    window.display_style.set_theme(theme)
    colors = THEMES[theme]
    for name, fill in FILLS.items():
        page = show(window, flown, STATES[name])
        box = inner(page.compute_regions().state)
        area = box.width() * box.height()
        assert count(page, getattr(colors, fill), box) > 0.4 * area, name
    for name in ("fly", "hold", "turn", "blind"):
        page = show(window, flown, STATES[name])
        box = inner(page.compute_regions().state)
        assert count(page, colors.plot, box) > 0.6 * box.width() * box.height(), name
        assert count(page, colors.muted if name == "blind" else colors.text, box) > 2000, name


def test_every_state_has_a_shape_of_its_own_in_black_and_white(window, flown):
    seen: dict[str, np.ndarray] = {}
    for name in ("hold", "go", "gusty", "turn", "blind", "too-small", "too-large", "too-fast",
                 "too-slow", "not-trimmed", "invalid", "good", "danger"):  # fmt: skip
        page = show(window, flown, STATES[name])
        shown = pixels(page, inner(page.compute_regions().sign))
        ink = shown != np.bincount(shown.ravel() & 0xFFFFFF).argmax()
        for other, before in seen.items():
            assert (ink != before).mean() > 0.02, (name, other)
        seen[name] = ink


def test_the_marker_stands_where_the_speed_is_and_the_band_is_cyan(window, flown):
    theme = window.display_style.theme

    def marker(speed: float) -> float:
        page = show(window, flown, replace(BASE, speed=speed * FOOT))
        box = inner(page.compute_regions().gauges)
        # Right of the number, below the words.
        shown = pixels(page, box)[int(0.5 * box.height()) : int(0.85 * box.height())]
        dark = (shown == int(theme.text[1:], 16)).mean(axis=0) > 0.9
        columns = np.flatnonzero(dark[int(0.4 * box.width()) :]) + int(0.4 * box.width())
        assert columns.size, speed
        return float(columns.mean())

    slow, right, fast = marker(95.0), marker(100.0), marker(105.0)
    assert right - slow == pytest.approx(fast - right, abs=3)
    page = show(window, flown, BASE)
    box = inner(page.compute_regions().gauges)
    shown = pixels(page, box)[int(0.6 * box.height())]
    cyan = np.flatnonzero(shown == int(theme.target[1:], 16))
    assert cyan.min() == pytest.approx(slow, abs=6)
    assert cyan.max() == pytest.approx(fast, abs=6)


@pytest.mark.parametrize(("speed", "side"), [(60.0, "left"), (140.0, "right")])
def test_a_speed_beyond_the_bar_is_an_arrow_at_its_end(
    window: MainWindow, flown: Flown, speed: float, side: str
) -> None:
    page = show(window, flown, replace(BASE, speed=speed * FOOT))
    box = inner(page.compute_regions().gauges)
    shown = pixels(page, box)[int(0.42 * box.height()) : int(0.95 * box.height())]
    shown = shown[:, int(0.37 * box.width()) :]
    ink = (shown == int(window.display_style.theme.text[1:], 16)).sum(axis=0)
    columns = np.flatnonzero(ink)
    tip, base = (columns[0], columns[-1]) if side == "left" else (columns[-1], columns[0])
    assert abs(tip - base) > 10
    inward = ink[columns] if side == "left" else ink[columns][::-1]
    assert (np.diff(inward) >= -1).all()
    assert inward[0] < 0.2 * inward[-1]
    # The band of what is wanted lies in the middle fifths of the bar.
    cyan = np.flatnonzero((shown == int(window.display_style.theme.target[1:], 16)).any(axis=0))
    middle = (cyan.min() + cyan.max()) / 2
    half = 2.5 * (middle - cyan.min())
    assert tip == pytest.approx(middle + (half if side == "right" else -half), abs=8)


def test_nothing_flickers_while_the_cues_stand(window: MainWindow, flown: Flown) -> None:
    page = show(window, flown, STATES["go"])
    before = pixels(page)
    window.pilot_page.refresh()
    assert (pixels(page) == before).all()
    flown.snapshot = replace(STATES["go"], speed=101.2 * FOOT)
    window.pilot_page.refresh()
    changed = np.argwhere(pixels(page) != before)
    box = inner(page.compute_regions().gauges)
    assert changed.size
    assert changed[:, 0].min() >= box.top()
    assert changed[:, 0].max() <= box.bottom()


def test_a_dead_link_leaves_no_go_standing(window: MainWindow, flown: Flown) -> None:
    page = show(window, flown, STATES["go"])
    flown.silent = 1.7
    window.pilot_page.refresh()
    assert page.display.status_text == "NO DATA"
    assert count(page, window.display_style.theme.good_fill) == 0


# Sizes


SIZES = ((1280, 800), (2560, 1600), (640, 400))


@pytest.mark.parametrize("size", SIZES)
def test_words_fit_their_boxes_and_boxes_lie_apart(
    qtbot: QtBot, monkeypatch: pytest.MonkeyPatch, size: tuple[int, int]
) -> None:
    """All states: each text is measured where it is drawn, and between rows nothing is drawn."""
    page = PilotCanvas(DisplayStyle())
    qtbot.addWidget(page)
    page.resize(*size)
    drawn: list[tuple[str, QRectF, QFont, bool]] = []

    def watched(text: str, box: QRectF, *sizes: int, **how: bool) -> QFont:
        font = fit_font(text, box, *sizes, **how)
        drawn.append((text, box, font, how.get("wrap", False)))
        return font

    monkeypatch.setattr(ui.pilot.pilot_canvas, "fit_font", watched)
    panel = int(page._style.theme.plot[1:], 16)
    for name, cues in STATES.items():
        page.show_display(display(cues))
        shown = pixels(page)
        for text, box, font, wrap in drawn:
            flags = Qt.TextFlag.TextWordWrap if wrap else Qt.TextFlag.TextSingleLine
            room = QRectF(0, 0, box.width(), 10_000)
            taken = QFontMetricsF(font).boundingRect(room, flags, text)
            assert taken.width() <= box.width() + 1, (name, text)
            assert taken.height() <= box.height() + 1, (name, text)
        drawn.clear()
        places = page.compute_regions()
        rows = (places.state, places.hints, places.gauges, places.card, places.footer)
        for above, below in pairwise(rows):
            top, bottom = int(above.bottom()) + 2, int(below.top()) - 1
            assert (shown[top:bottom] == panel).all(), (name, top)
        left = int(min(row.left() for row in rows)) - 1
        assert (shown[:, :left] == panel).all(), name


def test_letters_grow_with_the_size_of_text(window, flown, monkeypatch):
    used: dict[str, int] = {}

    def watched(text: str, *sizes: object, **how: object) -> QFont:
        font = fit_font(text, *sizes, **how)
        used[text] = font.pixelSize()
        return font

    monkeypatch.setattr(ui.pilot.pilot_canvas, "fit_font", watched)
    window.resize(1280, 800)
    former: dict[str, int] = {}
    for scale in (100, 125, 150, 200):
        dress(window, "daylight", scale)
        used.clear()
        pixels(show(window, flown, BASE))
        titles = {words: used[words] for words in ("SPEED", "LEG LEFT", "FLIGHT")}
        assert all(size >= 0.11 * scale for size in titles.values())
        assert all(titles[words] >= size for words, size in former.items()), scale
        former = titles
        judged = [size for words, size in used.items() if words.startswith("Not evaluated")]
        assert all(size >= 0.11 * scale for size in judged)


def test_the_small_line_leaves_whole_statements_out(qtbot: QtBot) -> None:
    style = DisplayStyle()
    page = PilotCanvas(style)
    qtbot.addWidget(page)
    page.show_display(display(BASE))
    first, second = page.display.footer.split(STATEMENT_SEPARATOR)
    box = QRectF(
        0, 0, QFontMetricsF(create_font(11)).horizontalAdvance(page.display.footer) - 5, 14
    )
    assert footer_text(page.display.footer, box, 11) == first
    assert footer_text(page.display.footer, box.adjusted(0, 0, 20, 0), 11).endswith(second)
    page.resize(1160, 480)
    assert page.compute_regions().footer is not None
    style.set_scale(200)
    assert page.compute_regions().footer is None


def test_a_long_small_line_ends_in_an_ellipsis_and_is_whole_for_those_who_hear_it(qtbot):
    missing = tuple(f"channel number {number} is not calibrated" for number in range(40))
    page = PilotCanvas(DisplayStyle())
    qtbot.addWidget(page)
    page.resize(1280, 600)
    page.show_display(display(replace(BASE, limitations=missing)))
    box = page.compute_regions().footer
    words = elide_text(page.display.footer, box, 11)
    assert words.startswith("Not evaluated")
    assert words.endswith("…")
    assert len(words) < len(page.display.footer)
    assert missing[-1] in page.accessibleDescription()
    metrics = QFontMetricsF(create_font(11))
    room = QRectF(0, 0, box.width(), 10_000)
    taken = metrics.boundingRect(room, Qt.TextFlag.TextWordWrap, words)
    assert taken.height() <= box.height()


def test_the_state_is_25_mm_high_on_a_small_laptop(window: MainWindow, flown: Flown) -> None:
    millimeters = LAPTOP_MM / 1280
    for name, cues in STATES.items():
        page = show(window, flown, cues)
        box = inner(page.compute_regions().word).adjusted(0, 6, 0, -6)
        shown = pixels(page, box)
        rows = np.flatnonzero((shown != shown[0, -1]).any(axis=1))
        assert (rows[-1] - rows[0]) * millimeters >= 25.0, (name, page.display.status_text)


def test_what_is_read_has_enough_contrast() -> None:
    for name in ("daylight", "high-contrast"):
        theme = THEMES[name]
        for fill in (theme.good_fill, theme.caution_fill, theme.warning_fill):
            assert contrast(theme.fill_text, fill) >= 7.0, (name, fill)
        for ink in (theme.text, theme.muted, theme.target, theme.caution, theme.warning):
            assert contrast(ink, theme.plot) >= 7.0, (name, ink)


def test_controls_are_high_enough_for_gloves_and_have_names(window, flown):
    for size, scale, theme in LOOKS:
        dress(window, theme, scale)
        window.resize(*size)
        show(window, flown, STATES["too-small"])
        buttons = [
            button
            for button in window.pilot_page.buttons.findChildren(QAbstractButton)
            if button.isVisible()
        ]
        assert buttons
        for button in buttons:
            assert button.height() >= window.display_style.px(44), button.text()
            text = button.fontMetrics().horizontalAdvance(button.text())
            assert button.width() >= text + window.display_style.px(8), button.text()
            assert button.accessibleName(), button.text()
        # The page has the rest of the room, and the buttons lie below it.
        assert window.pilot_page.canvas.height() > 0.4 * window.height()


# Keys


def test_cards_are_chosen_by_keys(window: MainWindow, flown: Flown, qtbot: QtBot) -> None:
    page = show(window, flown, STATES["too-small"])
    page.setFocus()
    ids = [card.id for card in CARDS.cards]
    after = ids[(ids.index("C1") + 1) % len(ids)]
    press(qtbot, Qt.Key.Key_PageDown)
    assert page.display.card.heading.startswith(f"SHOWING {after}")
    assert not flown.chosen
    press(qtbot, Qt.Key.Key_PageUp)
    assert page.display.card.heading.startswith("NEXT C1")
    press(qtbot, Qt.Key.Key_PageDown)
    press(qtbot, Qt.Key.Key_Return)
    press(qtbot, Qt.Key.Key_R)
    press(qtbot, Qt.Key.Key_Backspace)
    assert flown.chosen == [after, "C1", ""]
    assert not page.display.card.heading.startswith("SHOWING")


def test_space_puts_the_verdict_away_and_acts_only_then(window, flown, qtbot):
    page = show(window, flown, STATES["too-small"])
    page.setFocus()
    action = window.commands.actions["pilot_dismiss"]
    assert action.isEnabled()
    press(qtbot, Qt.Key.Key_Space)
    assert page.display.status_text == "FLY"
    assert not action.isEnabled()
    flown.snapshot = replace(STATES["good"], verdict=replace(VERDICT, id="M8", result="good"))
    window.pilot_page.refresh()
    assert page.display.status_text == "GOOD"


def test_buttons_do_what_keys_do(window: MainWindow, flown: Flown) -> None:
    show(window, flown, STATES["too-small"])
    names = [offer.id for offer in window.pilot_page.buttons.offers]
    window.pilot_page.buttons.triggered.emit("pilot_dismiss")
    assert window.pilot_page.canvas.display.status_text == "FLY"
    assert [offer.id for offer in window.pilot_page.buttons.offers] == names
    window.pilot_page.buttons.triggered.emit("pilot_dismiss")
    assert window.pilot_page.canvas.display.status_text == "FLY"


def test_units_of_the_screen_are_those_of_the_page(window, flown, qtbot):
    page = show(window, flown, BASE)
    press(qtbot, Qt.Key.Key_U, Qt.KeyboardModifier.ControlModifier)
    window.pilot_page.state.restart()
    window.pilot_page.refresh()
    assert page.display.gauges[0].unit == "m/s"
    assert flown.units == ["SI"]


# The second window


def test_the_page_has_a_window_of_its_own_that_obeys_its_keys(window, flown, qtbot):
    show(window, flown, STATES["too-small"])
    press(qtbot, Qt.Key.Key_F3, SHIFT)
    own = window.pilot_page.own_window.window
    assert own.isVisible()
    # There is one screen here: it does not cover it unasked.
    assert not own.isFullScreen()
    # Its title bar is on the screen, too.
    around = own.screen().availableGeometry()
    assert around.adjusted(8, 32, -8, -8).contains(own.geometry())
    assert window.store.current.pilot_window
    assert own.canvas.display.status_text == "TOO SMALL"
    # Also while the main window shows another place.
    window.show_page("flight")
    qtbot.keyClick(own, Qt.Key.Key_Space)
    assert own.canvas.display.status_text == "FLY"
    qtbot.keyClick(own, Qt.Key.Key_PageDown, Qt.KeyboardModifier.KeypadModifier)
    assert own.canvas.display.card.heading.startswith("SHOWING")
    qtbot.keyClick(own, Qt.Key.Key_F11)
    assert own.isFullScreen()
    assert not window.isFullScreen()
    qtbot.keyClick(own, Qt.Key.Key_F11)
    muted = window.store.current.muted
    qtbot.keyClick(own, Qt.Key.Key_S)
    assert window.store.current.muted is not muted
    qtbot.keyClick(own, Qt.Key.Key_S)
    qtbot.keyClick(own, Qt.Key.Key_Escape)
    assert window.pilot_page.own_window.window is None
    assert not window.store.current.pilot_window


def test_the_second_window_closes_with_the_first_and_comes_back(qtbot, tmp_path, alone):
    first = open_window(tmp_path, pilot_window=True)
    try:
        qtbot.waitUntil(lambda: first.pilot_page.own_window.window is not None)
        own = first.pilot_page.own_window.window
    finally:
        first.close()
        first.deleteLater()
    assert not own.isVisible()
    assert first.store.current.pilot_window


def test_another_screen_is_found_if_there_is_one() -> None:
    one, two = object(), object()
    assert find_other_screen(one, [one, two]) is two  # type: ignore[arg-type, list-item]
    assert find_other_screen(one, [one]) is None  # type: ignore[arg-type, list-item]


def test_a_page_that_nobody_sees_is_not_made(window, flown, monkeypatch):
    show(window, flown, BASE)
    window.show_page("flight")
    painted = []
    monkeypatch.setattr(PilotCanvas, "show_display", lambda *_: painted.append(1))
    flown.snapshot = replace(BASE, trim=cue("go"))
    window.pilot_page.refresh()
    assert not painted


# Speech


def test_cues_are_spoken_once_the_page_was_opened(window, monkeypatch):
    """Or always, or never, as the crew wishes; which is remembered."""
    said: list[Announcement] = []
    heard: list[str] = []
    monkeypatch.setattr(FlightCues, "snapshot", lambda _self: replace(BASE, time=100.0))
    monkeypatch.setattr(FlightCues, "spoken_cues", lambda _self: said)
    monkeypatch.setattr(window.pilot_page, "_was_opened", False)
    window.pilot_page.speech.restart()
    window.voice.spoken.connect(heard.append)
    window.crew.toggle_mute()  # the windows of the tests begin muted
    speak = window.commands.actions["pilot_speak"]

    def tell(words: str) -> None:
        said.append(Announcement(time=100.0, text=words, priority="warning"))
        window.flight_controller.refreshed.emit()

    try:
        tell("one")
        assert not heard
        assert not speak.isChecked()
        window.show_page("pilot")
        tell("two")
        window.show_page("flight")
        tell("three")
        assert heard[0] == "two"
        assert speak.isChecked()
        speak.trigger()
        assert window.store.current.flight_speech == "never"
        before = list(heard)
        tell("four")
        assert heard == before
        speak.trigger()
        assert window.store.current.flight_speech == "always"
    finally:
        window.voice.spoken.disconnect(heard.append)
        window.store.change(flight_speech="page")
        window.crew.toggle_mute()
