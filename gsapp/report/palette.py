"""The colors that pictures are drawn in: ink on white paper, or those of a window's theme."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Palette:
    """Colors (``#rrggbb``) and weight of a picture; flights and traces from a color-blind-safe set.

    Attributes
    ----------
    background : str
        Behind everything.
    ink, quiet : str
        What is read; what is read second.
    faint : str
        Grid and frames.
    measured, computed, previous : str
        Traces: measured is drawn solid, computed dashed, what was known before gray.
    band : str
        Areas behind the traces: 95 % of a mean, what white noise keeps within.
    left_out : str
        Points that do not count.
    flights : tuple of str
        One color after the other; each flight has a marker of its own, too.
    weight : float
        Of lines, 1 on paper.
    """

    background: str
    ink: str
    quiet: str
    faint: str
    measured: str
    computed: str
    previous: str
    band: str
    left_out: str
    flights: tuple[str, ...]
    weight: float = 1.0

    def flight(self, place: int) -> str:
        """Return the color of a flight by its place among all, from 0."""
        return self.flights[place % len(self.flights)]


PAPER = Palette(
    background="#ffffff",
    ink="#20262e",
    quiet="#4a525d",
    faint="#c8ccd2",
    measured="#0072b2",
    computed="#d55e00",
    previous="#7d8590",
    band="#dfe9f2",
    left_out="#9aa2ac",
    flights=("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#20262e"),
)
"""Of every report."""

MARKERS = "os^Dv<>pXh"
"""Of the flights, in their order."""


def marker(place: int) -> str:
    """Return the marker of a flight by its place among all, from 0."""
    return MARKERS[place % len(MARKERS)]
