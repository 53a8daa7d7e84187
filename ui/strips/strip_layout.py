"""Which charts are shown, in which order and how: plain data, kept in a file.

Values in the file carry units (``low = "-10 deg"``); inside they are SI.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, field_validator, model_validator

from gsapp.foundation import StrictModel, read_toml, write_toml
from gsapp.quantities import CHANNELS, TRACE_COLORS, base_id, channel, from_si, parse_quantity
from ui.translation import QT_TR_NOOP

TraceStyle = Literal["measured", "computed", "previous"]
RangeMode = Literal["auto", "fixed", "limits"]


MAX_TRACES = 4
"""Lines in a chart, at most."""


class Trace(StrictModel):
    """One line in a chart."""

    channel: str  # Channel id.
    # Name in `TRACE_COLORS`; None takes that of the channel, or the next free one.
    color: str | None = None
    style: TraceStyle = "measured"  # Solid, dashed, gray.

    @field_validator("channel")
    @classmethod
    def _in_the_vocabulary(cls, value: str) -> str:
        try:
            channel(value)
        except KeyError as error:
            raise ValueError(str(error)) from error
        return value

    @field_validator("color")
    @classmethod
    def _a_trace_color(cls, value: str | None) -> str | None:
        if value is not None and value not in TRACE_COLORS:
            raise ValueError(f"unknown trace color '{value}'; use one of {', '.join(TRACE_COLORS)}")
        return value


class Strip(StrictModel):
    """One chart."""

    # One, or several of the same quantity, such as left and right elevator.
    traces: Annotated[tuple[Trace, ...], Field(min_length=1, max_length=MAX_TRACES)]
    range: RangeMode = "auto"  # How the y axis is chosen.
    # The fixed range, SI.
    low: float | None = None
    high: float | None = None
    height: Annotated[float, Field(ge=0.25, le=8.0)] = 1.0  # In relation to the other charts.

    @model_validator(mode="before")
    @classmethod
    def _short_form(cls, content: Any) -> Any:
        """Read ``channel = "q"`` for a chart of one line, and values with units."""
        if not isinstance(content, dict):
            return content
        content = dict(content)
        if "channel" in content and "traces" not in content:
            content["traces"] = [
                {key: content.pop(key) for key in ("channel", "color", "style") if key in content}
            ]
        first = next(iter(content.get("traces") or ()), None)
        name = first.get("channel") if isinstance(first, dict) else getattr(first, "channel", None)
        if isinstance(name, str) and base_id(name) in CHANNELS:
            for key in ("low", "high"):
                if isinstance(content.get(key), str):
                    content[key] = parse_quantity(content[key], channel(name).quantity)
        return content

    @model_validator(mode="after")
    def _must_fit_together(self) -> Strip:
        quantities = {channel(trace.channel).quantity for trace in self.traces}
        if len(quantities) > 1:
            raise ValueError(
                f"one chart cannot show {' and '.join(sorted(quantities))}; give each quantity its "
                "own chart"
            )
        if self.range == "fixed" and (
            self.low is None or self.high is None or not self.low < self.high
        ):
            raise ValueError('a fixed range needs low and high; write for example low = "-10 deg"')
        return self

    @property
    def channel(self) -> str:
        return self.traces[0].channel

    def to_dict(self) -> dict[str, Any]:
        """Return what a file holds: short where it can be, values with their unit."""
        if len(self.traces) == 1:
            found = self.traces[0].model_dump(exclude_defaults=True)
        else:
            found = {"traces": [trace.model_dump(exclude_defaults=True) for trace in self.traces]}
        found |= self.model_dump(exclude_defaults=True, exclude={"traces", "low", "high"})
        spec = channel(self.channel)
        for key in ("low", "high"):
            value = getattr(self, key)
            if value is not None:
                shown = from_si(value, spec.si_display, spec.quantity)
                found[key] = f"{shown:.12g} {spec.si_display}".strip()
        return found


class StripGroup(StrictModel):
    """Charts that belong together, under one name."""

    name: str = ""
    strips: tuple[Strip, ...] = ()


class StripLayout(StrictModel):
    """All charts."""

    name: str = QT_TR_NOOP("Flight test")  # For the list of saved layouts.
    window: Annotated[float, Field(gt=0.0)] = 60.0  # Seconds in sight at first.
    groups: tuple[StripGroup, ...] = ()  # From top to bottom.

    @property
    def strips(self) -> tuple[Strip, ...]:
        return tuple(strip for group in self.groups for strip in group.strips)

    @property
    def channels(self) -> tuple[str, ...]:
        found = [trace.channel for strip in self.strips for trace in strip.traces]
        return tuple(dict.fromkeys(found))

    def find_position(self, number: int) -> tuple[int, int]:
        """Return (group, chart within it) of the chart of that number."""
        for index, group in enumerate(self.groups):
            if number < len(group.strips):
                return index, number
            number -= len(group.strips)
        raise IndexError("no such chart")

    def with_strip(self, number: int, strip: Strip | None) -> StripLayout:
        """Return a layout with a chart replaced, or taken away with None."""
        index, within = self.find_position(number)
        strips = list(self.groups[index].strips)
        strips[within : within + 1] = [] if strip is None else [strip]
        return self._with_group(index, strips)

    def with_strip_moved(self, number: int, by: int) -> StripLayout:
        """Return a layout with a chart moved up (-1) or down (+1), across groups if need be."""
        index, within = self.find_position(number)
        strips = list(self.groups[index].strips)
        strip = strips.pop(within)
        if 0 <= within + by <= len(strips):
            strips.insert(within + by, strip)
            return self._with_group(index, strips)
        neighbor = index + (1 if by > 0 else -1)
        if not 0 <= neighbor < len(self.groups):
            return self
        others = list(self.groups[neighbor].strips)
        others.insert(0 if by > 0 else len(others), strip)
        return self._with_group(index, strips)._with_group(neighbor, others)

    def _with_group(self, index: int, strips: Sequence[Strip]) -> StripLayout:
        groups = list(self.groups)
        groups[index] = StripGroup(name=groups[index].name, strips=tuple(strips))
        return StripLayout(name=self.name, window=self.window, groups=tuple(groups))

    def to_dict(self) -> dict[str, Any]:
        """Return what a TOML or JSON file holds; ``StripLayout.model_validate`` reads it."""
        return {
            "name": self.name,
            "window": self.window,
            "groups": [
                {"name": group.name, "strips": [strip.to_dict() for strip in group.strips]}
                for group in self.groups
            ],
        }


def load_layout(path: Path | str) -> StripLayout:
    """Read a layout; `FileProblemsError` names every mistake in the file."""
    return read_toml(path, StripLayout)


def save_layout(path: Path | str, layout: StripLayout) -> Path:
    """Write a layout as TOML, atomically."""
    return write_toml(path, layout.to_dict())


_DEFAULT_GROUPS = (
    (QT_TR_NOOP("Pitch"), ("de", "alpha", "q", "theta", "an")),
    (QT_TR_NOOP("Roll and yaw"), ("da", "dr", "beta", "p", "r", "phi", "ay")),
    (QT_TR_NOOP("Flight"), ("V", "altitude", "throttle", "battery")),
)
# What stands in where a flight lacks the channel.
_SUBSTITUTE_CHANNELS = {
    "V": ("Vc", "qbar", "dynamic_pressure", "ground_speed"),
    "altitude": ("height", "static_pressure"),
    "theta": ("ax",),
    "phi": ("psi", "ax"),
    "de": ("elevator_left", "de_command", "stick_pitch"),
    "da": ("aileron_left", "da_command", "stick_roll"),
    "dr": ("rudder", "dr_command", "stick_yaw"),
    "battery": ("battery_receiver", "rpm_left"),
}


def default_layout(channels: Sequence[str] | None = None) -> StripLayout:
    """Return 16 charts for a flight test.

    `channels`: channels that the flight has. Charts without data give way to what the flight has in
    their stead; None knows nothing and takes the list as it is.
    """
    known = None if channels is None else dict.fromkeys(channels)
    used: set[str] = set()
    groups = []
    for name, wanted in _DEFAULT_GROUPS:
        strips = []
        for first in wanted:
            for candidate in (first, *_SUBSTITUTE_CHANNELS.get(first, ())):
                if candidate not in used and (known is None or candidate in known):
                    used.add(candidate)
                    strips.append(Strip(traces=(Trace(channel=candidate),)))
                    break
        if strips:
            groups.append(StripGroup(name=name, strips=tuple(strips)))
    if known is not None and len(used) < 16:
        rest = [name for name in CHANNELS if name in known and name not in used]
        if used or not all(name.endswith("_volts") for name in rest):
            # Volts are for the bench, unless there is nothing else.
            rest = [name for name in rest if not name.endswith("_volts")]
        others = tuple(Strip(traces=(Trace(channel=name),)) for name in rest[: 16 - len(used)])
        if others:
            groups.append(StripGroup(name=QT_TR_NOOP("Other"), strips=others))
    return StripLayout(groups=tuple(groups))
