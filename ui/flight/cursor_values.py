"""Values at the cursors, and their differences. No Qt."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Protocol

from gsapp.quantities import FloatArray, channel
from ui.number_format import DASH, clock_text, number_text, symbol_text, unit_text
from ui.strips.chart_annotations import DisplayFormat, OriginInfo
from ui.strips.chart_state import (
    BEYOND_CALIBRATION_MARK,
    BEYOND_CALIBRATION_TEXT,
    channel_difference,
    is_beyond_calibration,
)
from ui.translation import tr
from ui.widgets.row_model import TableRow


class SampleReader(Protocol):
    """What is read from; `gsapp.session.sample_history.SampleHistory` fits."""

    @property
    def rate(self) -> float:
        """Return samples per second."""

    @property
    def channels(self) -> Iterable[str]:
        """Return the channels that exist."""

    def samples(self, channel_id: str, first: int, last: int) -> FloatArray:
        """Return samples by absolute index."""


def find_sample(history: SampleReader, channel_id: str, time: float | None) -> float:
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
    history: SampleReader,
    channels: Iterable[str],
    cursors: Mapping[str, float],
    units: str,
    sources: Mapping[str, OriginInfo] = MappingProxyType({}),
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
        said = tr(" uncal") if uncalibrated else ""
        said += f" {BEYOND_CALIBRATION_TEXT}" if any(beyond.values()) else ""
        title = f"{symbol_text(spec.symbol)} {unit}".rstrip() + said
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
    history: SampleReader, source: OriginInfo | None, time: float | None
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
