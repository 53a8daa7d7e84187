"""Colors stay apart for every kind of color vision, shapes tell states, and nothing moves."""

from itertools import combinations
from pathlib import Path

import pytest
from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QColor, QImage, QPainter
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from gsapp.report.palette import PRINT_PALETTE, Palette
from tests.ui.color_vision import VISIONS, ciede2000, distance
from tests.ui.window_kit import opened_window
from ui.icons import paint_indicator
from ui.theme import THEMES, Theme, contrast

STATES = ("good", "caution", "warning", "target")
FILLS = ("good_fill", "caution_fill", "warning_fill")

# Just seen side by side is 2; at 10 two lines are told apart at a glance.
LEAST_OF_TRACES, LEAST_OF_STATES, LEAST_OF_FILLS, LEAST_OF_SPANS = 10.0, 8.0, 12.0, 3.0

both = pytest.mark.parametrize("vision", VISIONS)
themes = pytest.mark.parametrize("theme", THEMES.values(), ids=lambda theme: theme.name)


@pytest.mark.parametrize(
    ("one", "other", "expected"),
    [
        ((50.0, 2.6772, -79.7751), (50.0, 0.0, -82.7485), 2.0425),
        ((50.0, 2.5, 0.0), (73.0, 25.0, -18.0), 27.1492),
        ((2.0776, 0.0795, -1.1350), (0.9033, -0.0636, -0.5514), 0.9082),
    ],
)
def test_the_distance_is_that_of_the_paper(one, other, expected):
    assert ciede2000(one, other) == pytest.approx(expected, abs=1e-4)


def test_deficient_color_vision_confuses_what_it_should():
    red, green = "#ff0000", "#008000"
    assert distance(red, green, "normal") > 60.0
    assert distance("#b00020", "#4a3a00", "protanopia") < distance("#b00020", "#4a3a00", "normal")
    assert distance("#0060ff", "#008080", "tritanopia") < distance("#0060ff", "#008080", "normal")


@pytest.mark.parametrize("palette", [*THEMES.values(), PRINT_PALETTE], ids=[*THEMES, "print"])
@both
def test_traces_stay_apart(palette: Theme | Palette, vision: str) -> None:
    lines = {**palette.traces, "previous": palette.previous}
    for (one, first), (other, second) in combinations(lines.items(), 2):
        assert distance(first, second, vision) >= LEAST_OF_TRACES, (one, other)


def test_printed_lines_stand_out_from_paper() -> None:
    """As WCAG 2.2 asks of graphics, success criterion 1.4.11."""
    for color in (*PRINT_PALETTE.traces.values(), PRINT_PALETTE.previous):
        assert contrast(color, PRINT_PALETTE.background) >= 3.0


@themes
@both
def test_states_stay_apart(theme: Theme, vision: str) -> None:
    for names, least in ((STATES, LEAST_OF_STATES), (FILLS, LEAST_OF_FILLS)):
        for one, other in combinations(names, 2):
            apart = distance(getattr(theme, one), getattr(theme, other), vision)
            assert apart >= least, (one, other)
    assert distance(theme.span, theme.event, vision) >= LEAST_OF_SPANS


def test_the_sign_of_each_state_has_a_shape_of_its_own(qapp: QApplication) -> None:
    """All in one color: what remains is the shape."""
    drawn = []
    for state in ("good", "caution", "warning", "unknown"):
        image = QImage(32, 32, QImage.Format.Format_RGB32)
        image.fill(Qt.GlobalColor.white)
        painter = QPainter(image)
        paint_indicator(painter, state, QRectF(2, 2, 28, 28), QColor("black"))
        painter.end()
        drawn.append(image)
    for one, other in combinations(drawn, 2):
        assert one != other


def test_nothing_moves_while_a_job_runs(qtbot: QtBot, tmp_path: Path) -> None:
    """No animation, no blinking: motion disturbs some people, and draws the eye from the charts."""
    with opened_window(tmp_path) as window:
        banner = window.banners.show_banner("work", "Estimating", ("Stop", lambda: None))
        banner.set_progress(None)
        window.activateWindow()
        window.pages.setFocus()
        qtbot.wait(100)
        first = window.grab().toImage()
        assert banner.progress_bar.isVisible()
        for _ in range(3):
            qtbot.wait(70)
            assert window.grab().toImage() == first
        banner.set_progress(0.5)
        assert window.grab().toImage() != first
