"""The five places of the window, and what is honest to say of those still empty."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
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
    coming : tuple of str
        What will stand here; empty for a place that is built.
    today : tuple of (str, str)
        What can be done already instead, and how.
    """

    id: str
    title: str
    key: str
    glyph: str
    purpose: str
    coming: tuple[str, ...] = ()
    today: tuple[tuple[str, str], ...] = ()


PLACES: tuple[Place, ...] = (
    Place(
        id="preflight",
        title="Preflight",
        key="F1",
        glyph="preflight",
        purpose="Calibrate the surfaces and vanes, and check the aircraft before take-off.",
    ),
    Place(
        id="flight",
        title="Flight",
        key="F2",
        glyph="flight",
        purpose="Watch the flight on strip charts.",
    ),
    Place(
        id="pilot",
        title="Pilot",
        key="F3",
        glyph="pilot",
        purpose="Large cues for the pilot, readable from three meters: trim, speed, next maneuver.",
    ),
    Place(
        id="review",
        title="Review",
        key="F4",
        glyph="review",
        purpose="Cut the maneuvers, estimate the derivatives, and compare the models.",
        coming=(
            "Maneuvers found and graded, to be corrected by hand",
            "Derivatives with honest bounds, by maximum likelihood and by the transform in flight",
            "A report of the flight",
        ),
        today=(
            ("Look at a flight again", "Ctrl+O or Ctrl+Shift+O, any speed from 0.1x to 50x"),
            ("Measure between two times", "Flight (F2): cursors 1 and 2, values with Ctrl+2"),
            ("Take the data elsewhere", "Ctrl+E writes CSV, MATLAB or Parquet"),
        ),
    ),
    Place(
        id="gap",
        title="Model gap",
        key="F5",
        glyph="gap",
        purpose="Where simulation and measurement disagree: find out which effect the model lacks.",
    ),
)
"""From top to bottom."""


def place(place_id: str) -> Place:
    """Return a place by its id."""
    return next(known for known in PLACES if known.id == place_id)
