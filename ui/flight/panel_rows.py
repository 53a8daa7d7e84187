"""Values at cursors, marks, alarms and messages as lines of the side panel. No Qt."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType

from gsapp.flight.events import Event
from gsapp.quantities import channel
from gsapp.session.alarms import AlarmEpisode
from gsapp.session.limits import Severity
from gsapp.session.marks import FlightMark as FlightMark
from ui.icons import IndicatorState
from ui.number_format import (
    DASH,
    channel_value_text,
    clock_text,
    elapsed_text,
    number_text,
    symbol_text,
    unit_text,
)
from ui.strips.chart_annotations import (
    AlarmSpan,
    ChannelOrigin,
    ChartMark,
    ChartSpan,
    DisplayFormat,
)
from ui.strips.chart_state import (
    BEYOND_CALIBRATION_MARK,
    BEYOND_CALIBRATION_TEXT,
    channel_difference,
    is_beyond_calibration,
)
from ui.strips.pixel_columns import SampleSource
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.row_model import TableRow


def find_sample(history: SampleSource, channel_id: str, time: float | None) -> float:
    """Return the sample (SI) nearest to a time (s); NaN where there is none.

    A channel slower than the grid has its last sample before, if that is within half a second.
    """
    if time is None or channel_id not in history.channels:
        return math.nan
    last = round(time * history.rate) + 1
    found = history.samples(channel_id, last - max(1, round(0.5 * history.rate)), last)
    for value in found[::-1]:
        if not math.isnan(value):
            return float(value)
    return math.nan


def build_cursor_value_rows(
    history: SampleSource,
    channels: Iterable[str],
    cursors: Mapping[str, float],
    units: str,
    sources: Mapping[str, ChannelOrigin] = MappingProxyType({}),
) -> tuple[TableRow, ...]:
    """Return one line for each channel: at the cursor, at A, at B, and B minus A.

    Values of an instrument beyond what it was calibrated for carry a mark, and the line says it.
    """
    lines = []
    for name in channels:
        spec = channel(name)
        display = DisplayFormat.for_channel(spec, units)
        values = {key: find_sample(history, name, cursors.get(key)) for key in ("cursor", "a", "b")}
        source = sources.get(name)
        beyond = {
            key: _is_sample_beyond_calibration(history, source, cursors.get(key)) for key in values
        }
        shown = [
            (BEYOND_CALIBRATION_MARK if beyond[key] else "")
            + number_text(display.to_display(value), display.decimals)
            for key, value in values.items()
        ]
        apart = display.factor * channel_difference(spec, values["a"], values["b"])
        unit = unit_text(display.unit)
        uncalibrated = source is not None and not source.calibrated
        text = tr(" uncal") if uncalibrated else ""
        text += f" {BEYOND_CALIBRATION_TEXT}" if any(beyond.values()) else ""
        title = f"{symbol_text(spec.symbol)} {unit}".rstrip() + text
        lines.append(
            TableRow(
                key=name,
                cells=(title, *shown, number_text(apart, display.decimals)),
                italic=source is not None and source.kind == "estimated",
                detail=spec.title
                + (tr(" in {unit}").format(unit=unit) if unit else "")
                + (tr(", uncalibrated") if uncalibrated else "")
                + (tr(", * beyond the range that was calibrated") if any(beyond.values()) else ""),
            )
        )
    return tuple(lines)


def _is_sample_beyond_calibration(
    history: SampleSource, source: ChannelOrigin | None, time: float | None
) -> bool:
    return is_beyond_calibration(source, lambda name: find_sample(history, name, time))


def cursor_times_text(cursors: Mapping[str, float]) -> str:
    """Return where the cursors stand: ``A 2:01.0   B 2:03.5   B − A 2.50 s``."""
    parts = [
        f"{title} {clock_text(cursors[key], decimals=1)}"
        for key, title in (("cursor", tr("Cursor")), ("a", "A"), ("b", "B"))
        if key in cursors
    ]
    if "a" in cursors and "b" in cursors:
        apart = cursors["b"] - cursors["a"]
        parts.append(f"B − A {number_text(apart, 2)} s")
        if abs(apart) > 1e-9:
            parts.append(f"1/\N{WORD JOINER}Δt {abs(1.0 / apart):.2f} Hz")
    # A line breaks between the parts only.
    whole = (part.replace(" ", "\N{NO-BREAK SPACE}") for part in parts)
    return "    ".join(whole) or DASH


_DEFAULT_MARK_TITLES = {"mark": QT_TR_NOOP("Mark"), "note": QT_TR_NOOP("Note")}
_SEVERITY_STATES: dict[Severity, IndicatorState] = {
    Severity.NORMAL: "plain",
    Severity.CAUTION: "caution",
    Severity.WARNING: "warning",
}
_SEVERITY_SYMBOLS = {Severity.CAUTION: "▲", Severity.WARNING: "■"}
_WARNING_SEVERITY, _CAUTION_SEVERITY = 3, 4
"""MAVLink severities: up to error is a warning, a warning is a caution."""


def mark_title(mark: FlightMark, number: int) -> str:
    """Return a mark's text, or its number if it has none."""
    return mark.text or tr(_DEFAULT_MARK_TITLES.get(mark.kind, "Mark")) + f" {number}"


def build_mark_rows(marks: Sequence[FlightMark]) -> tuple[TableRow, ...]:
    """Return one line for each mark, in order of time."""
    return tuple(
        TableRow(
            key=mark.id,
            cells=(clock_text(mark.time, decimals=1), mark_title(mark, number)),
            is_bold=mark.kind == "note",
            italic=bool(mark.author),
            detail=tr("From {author}").format(author=mark.author) if mark.author else "",
        )
        for number, mark in enumerate(marks, start=1)
    )


def build_chart_marks(marks: Sequence[FlightMark]) -> tuple[ChartMark, ...]:
    """Return the marks as the charts draw them."""
    return tuple(
        ChartMark(label=mark_title(mark, number), time=mark.time)
        for number, mark in enumerate(marks, start=1)
        if mark.time is not None and mark.end is None
    )


def build_chart_spans(marks: Sequence[FlightMark]) -> tuple[ChartSpan, ...]:
    """Return marks that last as the spans that the charts draw."""
    return tuple(
        ChartSpan(label=mark_title(mark, number), start=mark.time, stop=mark.end, kind="event")
        for number, mark in enumerate(marks, start=1)
        if mark.time is not None and mark.end is not None
    )


def build_alarm_rows(
    episodes: Iterable[AlarmEpisode], units: str, last: float | None, *, live: bool
) -> tuple[TableRow, ...]:
    """Return one line for each alarm of the flight; those that nobody has seen are strong.

    `episodes`: by onset. `last`: flight time (s) up to which an alarm lasts whose cause is still
    there.
    """
    found = []
    for one in episodes:
        seconds = None
        stop = one.end if one.is_over else last
        if one.onset is not None and stop is not None:
            seconds = max(stop - one.onset, 0.0)
        still = "" if one.is_over else (tr("\nactive") if live else tr("\nto end"))
        seen = one.acknowledgment
        what, sign = _alarm_cause_text(one), _SEVERITY_SYMBOLS.get(one.severity, "")
        found.append(
            TableRow(
                key=("alarm", one.key, one.onset),
                cells=(
                    clock_text(one.onset, decimals=1),
                    f"{sign} {what}",
                    _value_and_limit_text(one, units),
                    f"{elapsed_text(seconds)}{still}",
                    tr("no")
                    if seen is None
                    else f"{clock_text(seen.time, decimals=1)}\n{seen.by or 'crew'}",
                ),
                sort_values=(
                    one.onset,
                    what,
                    one.value,
                    seconds,
                    None if seen is None else seen.time,
                ),
                state=_SEVERITY_STATES[one.severity],
                is_bold=seen is None,
                colored=frozenset({1}),
            )
        )
    return tuple(found)


def _value_and_limit_text(one: AlarmEpisode, units: str) -> str:
    if one.rule is None:
        return ""
    spec, sign = channel(one.rule.channel), ">" if one.rule.side == "high" else "<"
    value, limit = (channel_value_text(spec, x, units) for x in (one.value, one.limit))
    return f"{value}\n{sign} {limit}"


def _alarm_cause_text(one: AlarmEpisode) -> str:
    words = one.meaning
    if one.rule is not None:
        head = f"{channel(one.rule.channel).title} {one.rule.side}"
        words = f"{head}: {words}" if words else head
    return words[:1].upper() + words[1:]


def build_chart_alarms(episodes: Iterable[AlarmEpisode]) -> tuple[AlarmSpan, ...]:
    """Return the alarms as charts and slider draw them."""
    return tuple(
        AlarmSpan(
            start=one.onset,
            # Of what is over since nobody knows when, the onset alone is known.
            stop=one.onset if one.is_over and one.end is None else one.end,
            state="warning" if one.severity is Severity.WARNING else "caution",
            channel="" if one.rule is None else one.rule.channel,
        )
        for one in episodes
        if one.onset is not None
    )


def build_message_rows(events: Iterable[Event]) -> tuple[TableRow, ...]:
    """Return what the aircraft said, newest first."""
    found = []
    for index, message in enumerate(events):
        severity = message.data.get("severity")
        state: IndicatorState = "plain"
        if severity is not None and severity <= _CAUTION_SEVERITY:
            state = "warning" if severity <= _WARNING_SEVERITY else "caution"
        sign = {"warning": "■ ", "caution": "▲ "}.get(state, "")
        found.append(
            TableRow(
                key=("message", index, message.time),
                cells=(clock_text(message.time, decimals=1), f"{sign}{message.text}"),
                state=state,
                colored=frozenset({1}),
            )
        )
    return tuple(reversed(found))
