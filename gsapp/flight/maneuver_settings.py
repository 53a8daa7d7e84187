"""What the maneuvers of flights are read with: every command and form that takes flights."""

from __future__ import annotations

from typing import Final

from gsapp.foundation.settings import Names, SettingsModel, setting
from gsapp.foundation.translation import QT_TR_NOOP

_OF_FLIGHT: Final = "that of each flight"


class ManeuverSettings(SettingsModel):
    """Which aircraft, map and certificates apply, and which maneuvers of the flights count."""

    # fmt: off
    aircraft: str = setting(
        "", QT_TR_NOOP("Aircraft"),
        QT_TR_NOOP("Aircraft: a file, or the name of a shipped one; else the copy in the flight "
                   "folder. Choose another file only to correct what was recorded with the "
                   "flight."),
        option="--aircraft", metavar="FILE", default_text=_OF_FLIGHT)
    maneuver_windows: Names = setting(
        (), QT_TR_NOOP("Maneuver windows"),
        QT_TR_NOOP("Use this time window (s) instead of detected maneuvers; K:START:STOP for the "
                   "K-th flight."),
        option="--maneuver", metavar="START:STOP", is_repeatable=True)
    every_grade: bool = setting(
        False, QT_TR_NOOP("Every grade"),
        QT_TR_NOOP("Include maneuvers graded unfit (D)."),
        option="--every-grade")
    as_found: bool = setting(
        False, QT_TR_NOOP("As found"),
        QT_TR_NOOP("Ignore manual changes from the review."),
        option="--as-found")
    channel_map: str = setting(
        "", QT_TR_NOOP("Channel map"),
        QT_TR_NOOP("Channel map: a file, or the name of a shipped one."),
        option="--map", metavar="MAP", default_text=_OF_FLIGHT)
    calibration: str = setting(
        "", QT_TR_NOOP("Certificates"),
        QT_TR_NOOP("Certificates to use instead of those of the flight: a folder, or a shipped "
                   "set. Choose others after a calibration that was found wrong."),
        option="--calibration", metavar="FOLDER|NAME", default_text="those of each flight")
    # fmt: on
