"""The small horizon below the places: where ground and sky lie, and what is too old."""

import math
from pathlib import Path

import numpy as np
import pytest
from pytestqt.qtbot import QtBot

from gsapp.quantities import Block
from gsapp.session.sample_history import SampleHistory
from tests.ui.window_kit import open_small_flight, pixels, until
from ui.display_style import DisplayStyle
from ui.main_window import MainWindow
from ui.window_frame.attitude_indicator import AttitudeIndicator

SIZE = (80, 112)


def history_of(bank: float, pitch: float) -> SampleHistory:
    """Return a second of steady flight at 30 m/s; angles in degrees."""
    names = ("phi", "theta", "Vc")
    history = SampleHistory(names, rate=100.0)
    times = np.arange(0.0, 1.0, 0.01)
    rows = np.tile([math.radians(bank), math.radians(pitch), 30.0], (times.size, 1))
    history.append(Block(channels=names, times=times, values=rows))
    return history


@pytest.fixture
def indicator(qtbot: QtBot) -> AttitudeIndicator:
    made = AttitudeIndicator(DisplayStyle())
    qtbot.addWidget(made)
    made.resize(*SIZE)
    return made


@pytest.mark.parametrize(
    ("bank", "pitch", "right", "left", "above", "below"),
    [
        (0.0, 10.0, "sky", "sky", "sky", "ground"),
        (0.0, -10.0, "ground", "ground", "sky", "ground"),
        # The right wing points to the ground.
        (60.0, 0.0, "ground", "sky", "sky", "ground"),
        (-60.0, 0.0, "sky", "ground", "sky", "ground"),
        (180.0, 0.0, "ground", "ground", "ground", "sky"),
        # Some of the other side is always in sight.
        (0.0, 80.0, "sky", "sky", "sky", "ground"),
    ],
)
def test_ground_and_sky_lie_as_seen_from_the_aircraft(
    indicator: AttitudeIndicator,
    bank: float, pitch: float, right: str, left: str, above: str, below: str,
) -> None:  # fmt: skip
    indicator.show_flight(history_of(bank, pitch), 1.0)
    indicator.show()
    screen = pixels(indicator)
    theme = DisplayStyle().theme
    names = {int(theme.plot[1:], 16): "sky", int(theme.axis[1:], 16): "ground"}
    half = (SIZE[0] - 12) // 2
    x, y = SIZE[0] // 2, 4 + half
    far = round(0.8 * half)
    # Beside the line that a wing at zero pitch and the horizon would share.
    seen = {
        "right": screen[y - 3, x + far], "left": screen[y - 3, x - far],
        "above": screen[y - far, x + 3],
        "below": screen[y + round(0.85 * half), x + 1],
    }  # fmt: skip
    found = {place: names[int(color) & 0xFFFFFF] for place, color in seen.items()}
    expected = {"right": right, "left": left, "above": above, "below": below}
    assert found == expected
    assert indicator.attitude == pytest.approx((math.radians(bank), math.radians(pitch)))
    assert indicator.speed_text.split()[0] == "98.4"  # ft/s
    assert indicator.accessibleDescription()


def test_what_is_older_than_two_seconds_is_not_shown(indicator: AttitudeIndicator) -> None:
    indicator.show_flight(history_of(10.0, 5.0), 2.9)
    assert indicator.attitude is not None
    indicator.show_flight(history_of(10.0, 5.0), 3.1)
    assert indicator.attitude is None
    assert not indicator.isHidden()
    indicator.show_flight(None, None)
    assert indicator.isHidden()


def test_a_flight_without_attitude_has_no_indicator(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    indicator = window.navigation_rail.attitude
    window.show_page("flight")
    indicator.show_flight(history_of(0.0, 0.0), 1.0)
    assert indicator.isVisible()
    open_small_flight(window, qtbot, tmp_path)  # Of alpha, q, V and de.
    until(qtbot, indicator.isHidden)
