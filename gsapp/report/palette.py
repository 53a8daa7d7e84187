"""The colors that pictures are drawn in: ink on white paper, or those of a window's theme."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from gsapp.quantities import TRACE_COLORS, trace_color

FLIGHT_COLORS: Final = ("blue", "rust", "purple", "olive", "sky", "ink")
"""Trace colors of flights, in the order in which they are handed out."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Palette:
    """Colors (``#rrggbb``) and weight of a picture.

    A measured channel is solid in its own color (`channel`), a computed one dashed in ink. Flights
    and estimators take trace colors by name.
    """

    background: str
    ink: str
    secondary_ink: str
    """What is read; what is read second."""
    faint: str
    previous: str
    """What was known before; another run."""
    band: str
    """Areas behind the traces: 95 % of a mean, what white noise keeps within."""
    excluded: str
    """Points that do not count."""
    traces: Mapping[str, str] = field(hash=False)
    """Colors of the names in `TRACE_COLORS`."""
    line_scale: float = 1.0

    def channel(self, name: str) -> str:
        """Return the color of a channel or a coefficient, the same in every figure."""
        return self.traces[trace_color(name)]

    def flight(self, place: int) -> str:
        """Return the color of a flight by its place among all, from 0."""
        return self.traces[FLIGHT_COLORS[place % len(FLIGHT_COLORS)]]


PRINT_PALETTE = Palette(
    background="#ffffff",
    ink="#20262e",
    secondary_ink="#4a525d",
    faint="#c8ccd2",
    previous="#69737f",
    band="#dfe9f2",
    excluded="#9aa2ac",
    traces=dict(
        zip(
            TRACE_COLORS,
            ("#0072b2", "#cc79a7", "#d55e00", "#20262e", "#179be6", "#5a5100"),
            strict=True,
        )
    ),
)
"""Of every report: the Okabe-Ito set; yellow and sky blue are darkened for white paper, and to stay
apart from rust and blue for every kind of color vision."""

FLIGHT_MARKERS = "os^Dv<>pXh"


def flight_marker(place: int) -> str:
    """Return the marker of a flight by its place among all, from 0."""
    return FLIGHT_MARKERS[place % len(FLIGHT_MARKERS)]
