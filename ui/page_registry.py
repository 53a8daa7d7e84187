"""The five places of the window."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class PageInfo:
    """One place on the rail.

    Attributes
    ----------
    id : str
        Name in code; ``place_<id>`` is the command that goes there.
    title : str
        Word on the rail.
    key : str
        Key that goes there.
    glyph : str
        Sign on the rail.
    purpose : str
        What the place is for, one sentence.
    """

    id: str
    title: str
    key: str
    glyph: str
    purpose: str


PAGES: tuple[PageInfo, ...] = (
    PageInfo(
        id="preflight",
        title="Preflight",
        key="F1",
        glyph="preflight",
        purpose="Calibrate the surfaces and vanes, and check the aircraft before take-off.",
    ),
    PageInfo(
        id="flight",
        title="Flight",
        key="F2",
        glyph="flight",
        purpose="Watch the flight on strip charts.",
    ),
    PageInfo(
        id="pilot",
        title="Pilot",
        key="F3",
        glyph="pilot",
        purpose="Large cues for the pilot, readable from three meters: trim, speed, next maneuver.",
    ),
    PageInfo(
        id="review",
        title="Review",
        key="F4",
        glyph="review",
        purpose="Cut the maneuvers, estimate the derivatives, and compare the models.",
    ),
    PageInfo(
        id="gap",
        title="Model gap",
        key="F5",
        glyph="gap",
        purpose="Where simulation and measurement disagree: find out which effect the model lacks.",
    ),
)
"""From top to bottom."""
