"""What the plot beside the strip charts holds: spectrum, one channel over another, track."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from gsapp.flight.plot_data import TRACK_CHANNELS, GroundOrigin, ground_track, power_density
from gsapp.quantities import FloatArray, channel, from_si, symbol_text, unit_text
from ui.strips.chart_annotations import ChartSpan
from ui.strips.pixel_columns import SampleSource
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.analysis_plot import PlotCurve

_MAX_TRACK_TIME = 1800.0  # s
_MAX_TRACK_POINTS = 2000
_TRACK_NOTES: Final = {
    "position": QT_TR_NOOP("Measured position, last 30 minutes."),
    "ground speed": QT_TR_NOOP("Dead reckoning by ground speed and track, last 30 minutes."),
    "airspeed": QT_TR_NOOP("Dead reckoning by airspeed and heading, no wind, last 30 minutes."),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class PlotContent:
    """Curves, titles, and a note below them."""

    curves: Sequence[PlotCurve]
    title: str
    bottom: str
    left: str
    note: str = ""
    origin: GroundOrigin | None = None  # Of a ground track.


@dataclass(frozen=True, slots=True, kw_only=True)
class PlottedSamples:
    """The samples of a flight between two times."""

    history: SampleSource
    start: float  # Flight time, s.
    stop: float
    units: str  # System of the screen.

    def si(self, name: str, start: float | None = None) -> FloatArray:
        """Return samples of a channel in SI units, from another time on if one is given."""
        rate = self.history.rate
        first = max(round((self.start if start is None else start) * rate), 0)
        return self.history.samples(name, first, max(round(self.stop * rate) + 1, first))

    def shown(self, name: str) -> FloatArray:
        """Return samples of a channel in the unit of the screen."""
        spec = channel(name)
        return np.asarray(from_si(self.si(name), spec.display_unit(self.units), spec.quantity))

    def unit(self, name: str) -> str:
        return unit_text(channel(name).display_unit(self.units))

    def axis_title(self, name: str) -> str:
        return ", ".join(filter(None, (symbol_text(channel(name).symbol), self.unit(name))))


def spectrum_content(samples: PlottedSamples, name: str) -> PlotContent:
    """Return the power density of a channel."""
    frequencies, density = power_density(samples.shown(name), samples.history.rate)
    found = density > 0.0
    level = 10.0 * np.log10(density[found])
    return PlotContent(
        curves=[PlotCurve(x=frequencies[found], y=level, color="blue")] if found.any() else [],
        title=tr("Spectrum of {title}").format(title=channel(name).title),
        bottom=tr("frequency, Hz"),
        left=tr("power density, dB re 1 ({unit})²/Hz").format(unit=samples.unit(name) or "1"),
        note="" if found.any() else tr("Too few samples in view for a spectrum."),
    )


def channels_content(samples: PlottedSamples, name: str, over: str) -> PlotContent:
    """Return one channel over another."""
    x, y = samples.shown(over), samples.shown(name)
    both = np.isfinite(x) & np.isfinite(y)
    curve = PlotCurve(x=x[both], y=y[both], color="blue", points=True)
    return PlotContent(
        curves=[curve] if both.any() else [],
        title=tr("{title} over {other}").format(
            title=channel(name).title, other=channel(over).title
        ),
        bottom=samples.axis_title(over),
        left=samples.axis_title(name),
        note="" if both.any() else tr("No samples of both channels in view."),
    )


def track_content(samples: PlottedSamples, spans: Sequence[ChartSpan]) -> PlotContent:
    """Return the track over the ground, with the stretch in sight and maneuvers."""
    history, stop, rate = samples.history, samples.stop, samples.history.rate
    first = max(history.start or 0.0, stop - _MAX_TRACK_TIME)
    names = {name for pairs in TRACK_CHANNELS.values() for pair in pairs for name in pair}
    held = names.intersection(history.channels)
    track = ground_track({name: samples.si(name, first) for name in held}, rate)
    unit = channel("north").display_unit(samples.units)
    curves: list[PlotCurve] = []

    def add(begin: float, end: float, color: str, name: str) -> None:
        """Add a stretch, with few enough points to be drawn quickly."""
        if track is None:
            return
        places = slice(max(round((begin - first) * rate), 0), round((end - first) * rate) + 1)
        north, east = track.north[places], track.east[places]
        known = np.flatnonzero(np.isfinite(north) & np.isfinite(east))
        known = known[:: max(known.size // _MAX_TRACK_POINTS, 1)]
        if known.size:
            x, y = (np.asarray(from_si(one[known], unit, "length")) for one in (east, north))
            curves.append(PlotCurve(x=x, y=y, color=color, name=name))

    add(first, stop, "previous", tr("flight"))
    add(samples.start, stop, "blue", tr("in view"))
    maneuvers = [one for one in spans if one.kind == "maneuver" and first <= one.start <= stop]
    for number, one in enumerate(maneuvers):
        end = stop if one.stop is None else min(one.stop, stop)
        add(one.start, end, "rust", "" if number else tr("maneuvers"))
    if curves:
        last = curves[0]
        curves.append(
            PlotCurve(x=last.x[-1:], y=last.y[-1:], color="text", points=True, symbol="o",
                      name=tr("aircraft"))
        )  # fmt: skip
    return PlotContent(
        curves=curves,
        title=tr("Ground track"),
        bottom=tr("east, {unit}").format(unit=unit_text(unit)),
        left=tr("north, {unit}").format(unit=unit_text(unit)),
        note=tr("A ground track requires position, or speed and heading.")
        if track is None
        else tr(_TRACK_NOTES[track.source]),
        origin=None if track is None else track.origin,
    )
