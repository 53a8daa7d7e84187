"""What strip charts show: samples, layout, annotations, the part of the flight in sight."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gsapp.quantities import channel
from gsapp.session.limits import LimitBands
from ui.display_limits import DISPLAY
from ui.number_format import DASH, number_text
from ui.strips.chart_annotations import AlarmSpan, ChannelOrigin, ChartMark, ChartSpan
from ui.strips.chart_state import (
    BEYOND_CALIBRATION_MARK,
    ChartState,
    DisplayedValue,
    channel_difference,
    create_chart,
    find_displayed_value,
    is_beyond_calibration,
)
from ui.strips.pixel_columns import SampleSource, column_extremes
from ui.strips.strip_layout import StripLayout, default_layout
from ui.strips.strip_view import StripView
from ui.theme import DAYLIGHT, Theme
from ui.translation import QT_TR_NOOP, tr


@dataclass(slots=True, eq=False)
class ChartModel:
    """Everything that the charts show."""

    history: SampleSource | None = None  # The samples.
    # Time (s) up to which to show; None goes by the newest sample.
    flight_time: float | None = None
    layout: StripLayout = field(default_factory=default_layout)
    theme: Theme = DAYLIGHT
    units: str = "US"  # ``US`` or ``SI``.
    scale: float = 1.0  # Size of text and lines, 1.0 to 2.5.
    spans: tuple[ChartSpan, ...] = ()
    marks: tuple[ChartMark, ...] = ()
    alarms: tuple[AlarmSpan, ...] = ()
    # By channel id: limits, origin, and the age (s) from which its value is stale.
    limits: Mapping[str, LimitBands] = field(default_factory=dict)
    sources: Mapping[str, ChannelOrigin] = field(default_factory=dict)
    stale_ages: Mapping[str, float] = field(default_factory=dict)
    recording: bool = False  # Whether a recorder runs, which a paused display says.
    # What the newest flight time is; what to show while there is no sample.
    newest_text: str = QT_TR_NOOP("now")
    empty_text: str = ""
    # Whether values at the cursors have columns beside the charts.
    shows_cursor_values: bool = True
    view: StripView = field(default_factory=StripView)  # The part of the flight in sight.
    charts: dict[int, ChartState] = field(default_factory=dict)  # The charts by number.

    def change(self, name: str, value: Any) -> bool:
        """Set an attribute; return whether it was another."""
        if getattr(self, name) == value:
            return False
        setattr(self, name, value)
        return True

    def show_history(self, history: SampleSource | None) -> None:
        self.history = history
        self.flight_time = None
        rate = history.rate if history is not None else 100.0
        self.view = StripView(width=self.view.width, rate=rate, window=self.view.window)
        self.charts.clear()

    def advance_time(self) -> None:
        """Let the view know the newest flight time."""
        end = None if self.history is None else self.history.end
        if self.history is None or end is None:
            return
        self.view.set_now(end if self.flight_time is None else max(end, self.flight_time))
        self.view.start = self.history.start

    # Charts

    def create_charts(self) -> None:
        """Create the charts of the layout; those that exist keep their range."""
        known = self.charts
        self.charts = {
            index: known[index]
            if index in known and known[index].strip == strip
            else create_chart(strip, self.theme, self.units, self.limits.get(strip.channel))
            for index, strip in enumerate(self.layout.strips)
        }

    @property
    def selected_chart(self) -> ChartState | None:
        return self.charts.get(self.view.selected)

    def describe_selection(self) -> str:
        """Return which chart is selected, for screen readers."""
        strips, selected = self.layout.strips, self.view.selected
        if not strips:
            return tr("No chart chosen")
        chart = self.selected_chart
        unit = chart.displays[0].unit if chart is not None else ""
        title = channel(strips[selected].channel).title
        return (
            tr("Chart {selected} of {count}: {title} {unit}")
            .format(selected=selected + 1, count=len(strips), title=title, unit=unit)
            .rstrip()
        )

    # Values

    def find_displayed_values(self, chart: ChartState) -> tuple[DisplayedValue, ...]:
        """Return the current values of a chart."""
        if self.history is None:
            return tuple(DisplayedValue(text=DASH, stale=True) for _ in chart.specs)
        return tuple(
            find_displayed_value(
                self.history,
                spec,
                display,
                self.view.now,
                max(self.stale_ages.get(spec.id, 0.0), DISPLAY.min_stale_age),
                self.limits.get(spec.id),
                self.sources.get(spec.id),
            )
            for spec, display in zip(chart.specs, chart.displays, strict=True)
        )

    def value_at(self, channel_id: str, time: float) -> float:
        """Return the sample (SI) of a channel nearest to a time (s); NaN where there is none."""
        history = self.history
        if history is None or channel_id not in history.channels:
            return math.nan
        index = round(time * history.rate)
        return float(history.samples(channel_id, index, index + 1)[0])

    @property
    def shown_cursors(self) -> Mapping[str, float]:
        """Return the cursors whose values are shown: not the cursor where A or B is."""
        cursors = dict(self.view.cursors)
        if cursors.get("cursor") in (cursors.get("a"), cursors.get("b")):
            cursors.pop("cursor", None)
        return cursors

    @property
    def cursor_value_count(self) -> int:
        """Return how many values at cursors the fullest chart has."""
        names = len(self.shown_cursors) + ({"a", "b"} <= {*self.view.cursors})
        lines = max((len(chart.specs) for chart in self.charts.values()), default=1)
        return names * lines if self.shows_cursor_values else 0

    def cursor_texts(self, number_of_chart: int) -> dict[str, list[str]]:
        """Return the values of a chart at the cursors as they are shown, by cursor.

        ``delta`` is B minus A; a chart of several lines has a text for each. A value beyond the
        calibrated range begins with `BEYOND_CALIBRATION_MARK`.
        """
        chart = self.charts[number_of_chart]
        pairs = list(zip(chart.specs, chart.displays, strict=True))
        values: dict[str, list[float]] = {}
        beyond: dict[str, list[bool]] = {}
        for name, time in self.shown_cursors.items():
            values[name] = [self.value_at(spec.id, time) for spec in chart.specs]
            beyond[name] = [self._is_beyond_calibration(spec.id, time) for spec in chart.specs]
        shown = {
            name: [
                display.to_display(value) for value, (_, display) in zip(row, pairs, strict=True)
            ]
            for name, row in values.items()
        }
        if "a" in values and "b" in values:
            shown["delta"] = [
                display.factor * channel_difference(spec, a, b)
                for (spec, display), a, b in zip(pairs, values["a"], values["b"], strict=True)
            ]
            beyond["delta"] = [a or b for a, b in zip(beyond["a"], beyond["b"], strict=True)]
        return {
            name: [
                DASH
                if math.isnan(value)
                else (BEYOND_CALIBRATION_MARK if marked else "")
                + number_text(value, display.decimals)
                for value, marked, (_, display) in zip(row, beyond[name], pairs, strict=True)
            ]
            for name, row in shown.items()
        }

    def _is_beyond_calibration(self, channel_id: str, time: float) -> bool:
        source = self.sources.get(channel_id)
        return is_beyond_calibration(source, lambda name: self.value_at(name, time))

    def sampled_time(self, share: float) -> float:
        """Return the time (s) of a column in sight that holds samples, 0 the first and 1 the last.

        Where no column does, any counts.
        """
        view, history = self.view, self.history
        held = np.zeros(view.width, dtype=bool)
        if history is not None:
            for name in {*self.layout.channels} & {*history.channels}:
                held |= np.isfinite(column_extremes(history, name, view.scale, *view.columns)[0])
        columns = np.flatnonzero(held) if held.any() else np.arange(view.width)
        return view.sample_time(int(columns[round(share * (columns.size - 1))]))
