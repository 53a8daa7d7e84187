"""The five places of the window."""

from __future__ import annotations

from dataclasses import dataclass

from ui.translation import QT_TR_NOOP


@dataclass(frozen=True, slots=True, kw_only=True)
class PageInfo:
    """One place on the rail."""

    id: str  # Name in code; ``place_<id>`` is the command that goes there.
    title: str  # Word on the rail.
    shortcut: str  # Key that goes there.
    icon: str  # Sign on the rail.
    purpose: str  # What the place is for, one sentence.


PAGES: tuple[PageInfo, ...] = (
    PageInfo(
        id="preflight",
        title=QT_TR_NOOP("Preflight"),
        shortcut="F1",
        icon="preflight",
        purpose=QT_TR_NOOP(
            "Calibrate the surfaces and vanes, and check the aircraft before take-off."
        ),
    ),
    PageInfo(
        id="flight",
        title=QT_TR_NOOP("Flight"),
        shortcut="F2",
        icon="flight",
        purpose=QT_TR_NOOP("Watch the flight on strip charts."),
    ),
    PageInfo(
        id="pilot",
        title=QT_TR_NOOP("Pilot"),
        shortcut="F3",
        icon="pilot",
        purpose=QT_TR_NOOP(
            "Large cues for the pilot, readable from three meters: trim, speed, next maneuver."
        ),
    ),
    PageInfo(
        id="review",
        title=QT_TR_NOOP("Review"),
        shortcut="F4",
        icon="review",
        purpose=QT_TR_NOOP("Cut the maneuvers, estimate the derivatives, and compare the models."),
    ),
    PageInfo(
        id="gap",
        title=QT_TR_NOOP("Model gap"),
        shortcut="F5",
        icon="gap",
        purpose=QT_TR_NOOP(
            "Find where simulation and measurement disagree, and which effect the model lacks."
        ),
    ),
)
"""From top to bottom."""
