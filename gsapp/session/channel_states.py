"""What can be said of each channel at a moment: fresh or not, within limits or not, from where."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Literal

from gsapp.decoding.derived_channels import select_derivations
from gsapp.decoding.health import LinkReport
from gsapp.decoding.pipeline import ChannelSource
from gsapp.session.alarms import AlarmRegistry
from gsapp.session.flight_metadata import FlightMetadata
from gsapp.session.limits import LimitSet, Severity
from gsapp.session.monitor_settings import MONITORS
from gsapp.session.sample_history import SampleHistory


class Freshness(Enum):
    """How old the latest sample is."""

    FRESH = "fresh"
    STALE = "stale"
    MISSING = "missing"


@dataclass(frozen=True, slots=True, kw_only=True)
class ChannelState:
    """A channel at one moment."""

    channel: str
    freshness: Freshness
    """MISSING if it never had a sample."""
    time: float | None = None
    value: float | None = None
    """The latest sample: flight time (s), SI. Not to be shown as a value unless fresh."""
    age: float | None = None
    severity: Severity = Severity.NORMAL
    clipped: bool = False
    """Whether it stands at the end of its instrument's range."""
    kind: Literal["measured", "estimated", "derived"] = "measured"
    calibrated: bool = True
    """Whether a certificate is in force, where one is needed."""
    source: str = ""
    """Message and field, column, or formula."""


def source_message(source: ChannelSource | None) -> str | None:
    """Return the message, with its selector, that a channel comes in; None for derived ones."""
    if source is None or source.kind == "derived":
        return None
    head, _, _ = source.source.partition(".")
    return head or None


def share_message(one: str, other: str, sources: Mapping[str, ChannelSource]) -> bool:
    """Return whether the samples of two channels come in the same messages, row for row."""
    measured = [name for name, source in sources.items() if source.kind != "derived"]
    inputs = {each.output: each.fast_inputs for each in select_derivations(measured)}

    def messages(channel_id: str) -> frozenset[str]:
        source = sources.get(channel_id)
        if source is None:
            return frozenset()
        if source.kind == "derived":
            return frozenset().union(*map(messages, inputs.get(channel_id, ())))
        return frozenset(part.partition(".")[0] for part in source.source.split(", else "))

    carriers = messages(one)
    return bool(carriers) and carriers == messages(other)


def stale_timeout_by_message(report: LinkReport | None) -> Mapping[str, float]:
    """Return after how many seconds each message of the flown system is late, by its usual rate."""
    found: dict[str, float] = {}
    if report is None:
        return found
    for message in report.messages:
        if message.rate > 0.0 and message.system == report.system:
            seconds = min(
                max(MONITORS.stale_periods / message.rate, MONITORS.min_stale_time),
                MONITORS.max_stale_time,
            )
            found[message.name] = max(seconds, found.get(message.name, 0.0))
    return found


class ChannelStates:
    """States of all channels of a session, and which message carries which channel."""

    def __init__(
        self,
        metadata: FlightMetadata,
        history: SampleHistory,
        limits: LimitSet,
        registry: AlarmRegistry,
    ) -> None:
        self.history = history
        self.limits = limits
        self.registry = registry
        self._metadata = metadata
        self._messages: dict[str, str | None] = {}

    def message_of(self, channel_id: str) -> str | None:
        """Return the message, with its selector, that carries a channel; None for derived ones."""
        if channel_id not in self._messages:
            self._messages[channel_id] = source_message(self._metadata.sources.get(channel_id))
        return self._messages[channel_id]

    def share_message(self, one: str, other: str) -> bool:
        """Return whether two channels come in the same blocks."""
        return self._metadata.is_read_whole or share_message(one, other, self._metadata.sources)

    def stale_timeouts(self, channel_ids: Sequence[str]) -> dict[str, float]:
        """Return after how many seconds without a sample each channel is stale."""
        decoder = self._metadata.decoder
        late = stale_timeout_by_message(None if decoder is None else decoder.health.report())
        carriers = {name: self.message_of(name) or "" for name in channel_ids}
        return {
            name: late.get(message.partition("[")[0], MONITORS.default_stale_time)
            for name, message in carriers.items()
        }

    def states(
        self, channel_ids: Sequence[str] | None, now: float | None
    ) -> dict[str, ChannelState]:
        """Return the states at flight time `now` (s); by default of all that there can be."""
        names = channel_ids
        if names is None:
            names = list(dict.fromkeys((*self._metadata.sources, *self.history.channels)))
        patience = self.stale_timeouts(names)
        return {name: self._state(name, now, patience[name]) for name in names}

    def _state(self, channel_id: str, now: float | None, patience: float) -> ChannelState:
        source = self._metadata.sources.get(channel_id)
        last = self.history.last(channel_id) if self.history.has(channel_id) else None
        kind = "measured" if source is None else source.kind
        calibrated = True if source is None else source.calibrated
        origin = "" if source is None else source.source
        if last is None or now is None:
            return ChannelState(
                channel=channel_id,
                freshness=Freshness.MISSING,
                kind=kind,
                calibrated=calibrated,
                source=origin,
            )
        age = max(now - last[0], 0.0)
        fresh = age <= patience
        alarms = (
            self.registry.severity(f"{channel_id}:low"),
            self.registry.severity(f"{channel_id}:high"),
        )
        return ChannelState(
            channel=channel_id,
            freshness=Freshness.FRESH if fresh else Freshness.STALE,
            time=last[0],
            value=last[1],
            age=age,
            severity=max(alarms) if fresh else Severity.NORMAL,
            clipped=fresh and self.limits.is_clipped(channel_id, last[1]),
            kind=kind,
            calibrated=calibrated,
            source=origin,
        )
