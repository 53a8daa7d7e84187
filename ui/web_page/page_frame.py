"""What the page in a browser shows at one moment: cues, values, columns of the strips. No Qt."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, Final

import numpy as np

from gsapp.excitation.cues import CueSnapshot
from gsapp.quantities import FloatArray
from gsapp.session import Session
from ui.display_limits import DISPLAY
from ui.number_format import clock_text, number_text, symbol_text, unit_text
from ui.pilot.cue_display import RESULT_SIGNS, advice_text, surfaces_text
from ui.pilot.page_state import FlightCues, PilotPageState
from ui.strips.axis_ticks import step_decimals, value_ticks
from ui.strips.chart_annotations import ChannelOrigin
from ui.strips.chart_state import ChartState, create_chart, find_displayed_value
from ui.strips.strip_layout import Strip, Trace
from ui.theme import DARK, DAYLIGHT
from ui.translation import tr
from ui.web_page.settings import WEB_PAGE

_STRIP_CHANNELS: Final = ("V", "altitude", "alpha", "de", "phi", "q", "theta", "p", "r", "beta")
"""Of a page without a layout, the first that have data."""
_MORE_PLACES: Final = 2  # Digits of a point of a curve beyond those of its value.


@dataclass(frozen=True, slots=True, kw_only=True)
class PageFrame:
    """What the page shows at one moment."""

    content: Mapping[str, Any] = field(default_factory=dict)  # All but the curves.
    record: int = 0  # Another one: what was drawn before is void.
    first_column: int = 0  # Index of the first column, from flight time 0.
    # Of each line, strip by strip: lowest and highest value of every column, displayed units.
    lines: tuple[tuple[FloatArray, FloatArray, int], ...] = ()
    _encoded: dict[int, bytes] = field(default_factory=dict)

    @property
    def end_column(self) -> int:
        return self.first_column + (self.lines[0][0].size if self.lines else 0)

    def encode(self, after: int) -> bytes:
        """Return the frame as a line of JSON, with the columns that follow index `after`."""
        start = min(max(after, self.first_column), self.end_column)
        if start not in self._encoded:
            skip = start - self.first_column
            curves = [
                [_rounded(low[skip:], places), _rounded(high[skip:], places)]
                for low, high, places in self.lines
            ]
            message = {**self.content, "record": self.record, "first": start, "curves": curves}
            text = json.dumps(message, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
            self._encoded[start] = text.encode() + b"\n"
        return self._encoded[start]


def _rounded(values: FloatArray, places: int) -> list[float | None]:
    return [None if math.isnan(value) else value for value in np.round(values, places).tolist()]


def select_strips(strips: Sequence[Strip], known: Sequence[str]) -> tuple[Strip, ...]:
    """Return the strips of the page: the first of a layout that have data, or usual channels."""
    usual = [Strip(traces=(Trace(channel=name),)) for name in _STRIP_CHANNELS]
    with_data = [one for one in strips or usual if one.channel in known]
    return tuple(with_data[: WEB_PAGE.max_strips])


class PageFrameBuilder:
    """Makes the page of the flight that is open.

    Parameters
    ----------
    session : callable
        Returns the flight; None where none is open.
    strips : callable
        Returns the strips of the present layout; none for usual channels.
    units : callable
        Returns ``US`` or ``SI``.
    """

    def __init__(
        self,
        session: Callable[[], Session | None],
        strips: Callable[[], Sequence[Strip]] = tuple,
        units: Callable[[], str] = lambda: "US",
    ) -> None:
        self._get_session = session
        self._get_strips = strips
        self._get_units = units
        self._pilot_page = PilotPageState(FlightCues(session))
        self._session: Session | None = None
        self._charts: tuple[tuple[ChartState, tuple[str, ...]], ...] = ()
        self._key: tuple[Any, ...] = ()
        self._record = 0
        self._end = -math.inf

    def build(self) -> PageFrame:
        """Return the page as it is now."""
        session, units = self._get_session(), self._get_units()
        if session is not self._session:
            self._session, self._key = session, ()
            self._pilot_page.restart()
        cues = self._pilot_page.update()
        content: dict[str, Any] = {
            "cue": asdict(self._pilot_page.build_display(units)),
            "last": _last_maneuver(cues),
        }
        if session is None:
            return PageFrame(content=content, record=self._record)
        content |= {
            "flight": session.name,
            "time": clock_text(session.now, decimals=1) if session.now is not None else "",
            "mode": tr("LIVE") if session.mode == "live" else tr("REPLAY"),
        }
        self._choose_charts(session, units)
        return self._with_strips(session, content)

    def _choose_charts(self, session: Session, units: str) -> None:
        """Make the charts again where layout, units or flight are others, or time went back."""
        end = session.history.end
        end = -math.inf if end is None else end
        strips = select_strips(self._get_strips(), session.history.channels_with_data)
        key = (strips, units)
        if key != self._key or end < self._end:
            self._record += 1
        if key != self._key:
            dark = [create_chart(strip, DARK, units, None).colors for strip in strips]
            charts = [create_chart(strip, DAYLIGHT, units, None) for strip in strips]
            self._charts = tuple(zip(charts, dark, strict=True))
        self._key, self._end = key, end

    def _with_strips(self, session: Session, content: dict[str, Any]) -> PageFrame:
        history = session.history
        column_size = max(round(WEB_PAGE.column_time * history.rate), 1)
        seconds = column_size / history.rate
        end = 0 if history.end is None else math.floor(history.end / seconds) + 1
        start = 0 if history.start is None else math.floor(history.start / seconds)
        first = max(start, end - round(WEB_PAGE.window / seconds))
        stale = session.stale_timeouts(
            [spec.id for chart, _ in self._charts for spec in chart.specs]
        )
        lines, strips = [], []
        for chart, dark_colors in self._charts:
            curves = []
            for spec, display in zip(chart.specs, chart.displays, strict=True):
                low, high = (
                    history.extremes(spec.id, first, end, column_size)
                    if history.has(spec.id)
                    else (np.full(end - first, np.nan),) * 2
                )
                curves.append((display.to_display(low), display.to_display(high)))
                lines.append((*curves[-1], display.decimals + _MORE_PLACES))
            _update_range(chart, curves, self._end)
            strips.append(_describe_strip(session, chart, dark_colors, stale))
        content |= {"strips": strips, "column": seconds, "window": WEB_PAGE.window}
        return PageFrame(
            content=content, record=self._record, first_column=first, lines=tuple(lines)
        )


def _last_maneuver(cues: CueSnapshot | None) -> dict[str, str] | None:
    verdict = None if cues is None else cues.verdict
    if verdict is None:
        return None
    result, _sign, tone = RESULT_SIGNS[verdict.result]
    return {
        "title": f"{surfaces_text(verdict.surfaces)} {verdict.kind}",
        "time": clock_text(verdict.t_input),
        "result": tr(result),
        "tone": tone,
        "advice": advice_text(verdict),
    }


def _update_range(
    chart: ChartState, curves: Sequence[tuple[FloatArray, FloatArray]], now: float
) -> None:
    if chart.strip.range == "auto":
        lows = np.concatenate([low for low, _ in curves])
        highs = np.concatenate([high for _, high in curves])
        if not np.isnan(lows).all():
            chart.auto_range.update(float(np.nanmin(lows)), float(np.nanmax(highs)), now)
            chart.low, chart.high = chart.auto_range.low, chart.auto_range.high


def _describe_strip(
    session: Session, chart: ChartState, dark_colors: Sequence[str], stale: Mapping[str, float]
) -> dict[str, Any]:
    ticks = value_ticks(chart.low, chart.high, *WEB_PAGE.tick_geometry, most=WEB_PAGE.max_ticks)
    decimals = max((step_decimals(abs(tick)) for tick in ticks if tick), default=0)
    rows = zip(
        chart.specs, chart.displays, chart.text_colors, dark_colors, chart.dashed, strict=True
    )
    lines = []
    for spec, display, color, dark, dashed in rows:
        source = session.sources.get(spec.id)
        origin = (
            None if source is None else ChannelOrigin(source.kind, not source.uncalibrated_channel)
        )
        value = find_displayed_value(
            session.history,
            spec,
            display,
            session.now,
            max(stale.get(spec.id, 0.0), DISPLAY.min_stale_age),
            session.limits.bands(spec.id),
            origin,
        )
        notes = (
            value.state_text,
            tr("estimated") if value.estimated else "",
            tr("uncalibrated") if value.uncalibrated else "",
        )
        lines.append(
            {
                "title": f"{symbol_text(spec.symbol)} {spec.title}",
                "color": color,
                "dark": dark,
                "dashed": dashed,
                "value": value.text,
                "stale": value.stale,
                "state": value.state,
                "note": ", ".join(note for note in notes if note),
            }
        )
    return {
        "unit": unit_text(chart.displays[0].unit),
        "low": chart.low,
        "high": chart.high,
        "ticks": [[tick, number_text(tick, decimals)] for tick in ticks],
        "lines": lines,
    }
