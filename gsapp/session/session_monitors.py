"""The consumers of a session's samples: alarms, cues, estimates and landing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from gsapp.quantities import Block
from gsapp.session.alarms import AlarmRegistry
from gsapp.session.channel_states import ChannelStates
from gsapp.session.cue_monitor import CueMonitor
from gsapp.session.failure_guard import FailureGuard, GuardedConsumer
from gsapp.session.landing_monitor import LandingMonitor
from gsapp.session.limit_monitor import LimitMonitor
from gsapp.session.limits import LimitSet, Severity
from gsapp.session.marks import MarkStore
from gsapp.session.message_presence import MessagePresenceMonitor
from gsapp.session.session_setting import SessionOptions, SessionSetting

if TYPE_CHECKING:
    from gsapp.excitation.doublets.verdict import InputVerdict
    from gsapp.flight.info import FlightInfo
    from gsapp.session.consumer_scheduler import Consumer
    from gsapp.session.live_estimation.estimate_monitor import EstimateMonitor


class AlarmMonitor:
    """Watches the samples of a flight for alarms: limits and instruments that fall silent.

    Parameters
    ----------
    registry : AlarmRegistry
        Where alarms go.
    rate : float
        Of the grid, Hz.
    group : callable
        What carries a channel; see `MessagePresenceMonitor`.
    together : callable
        Whether two channels come in the same blocks; see `LimitMonitor`.
    """

    def __init__(
        self,
        registry: AlarmRegistry,
        limits: LimitSet,
        rate: float,
        group: Callable[[str], str | None],
        together: Callable[[str, str], bool],
    ) -> None:
        self._registry = registry
        self._limits = LimitMonitor(limits, registry, rate, together)
        self._presence = MessagePresenceMonitor(registry, group)

    def feed(self, block: Block) -> None:
        self._limits.feed(block)
        self._presence.feed(block)

    def reload_limits(self, channel_id: str) -> None:
        """Take other limits for a channel."""
        self._limits.reload_limits(channel_id)

    def process_step(self) -> None:
        self._presence.process_step()

    def reset(self) -> None:
        self._limits.reset()
        self._presence.reset()
        self._registry.reset()


_LIMITS = "limits and missing messages are no longer monitored"
_ESTIMATES = "estimates stopped"
_LANDING = "landing detection stopped"
_FURTHER = "a monitor failed"


class SessionMonitors:
    """Makes the consumers of a session, and holds them.

    Parameters
    ----------
    now : callable
        Flight time, s.
    info : callable
        The flight card as it is now.

    Attributes
    ----------
    consumers : list of Consumer
        All, in the order in which they are fed. In a live flight none of them may hold up the
        others.
    urgent : list of Consumer
        Those that find what the crew is told at once.
    alarms_ahead : AlarmMonitor or None
        In a replay, over the whole record as it is read.
    """

    def __init__(
        self,
        name: str,
        setting: SessionSetting,
        options: SessionOptions,
        states: ChannelStates,
        marks: MarkStore,
        *,
        live: bool,
        alarms_ahead: AlarmRegistry | None,
        now: Callable[[], float | None],
        info: Callable[[], FlightInfo | None],
        read_events: Callable[[], None],
        on_ground: Callable[[float], bool | None],
    ) -> None:
        self._registry = states.registry
        self._live = live
        self._now = now
        history = states.history

        def alarm_monitor(registry: AlarmRegistry) -> AlarmMonitor:
            return AlarmMonitor(
                registry, states.limits, history.rate, states.message_of, states.share_message
            )

        self.alarms = alarm_monitor(self._registry)
        self.alarms_ahead = None if alarms_ahead is None else alarm_monitor(alarms_ahead)
        self.cues: CueMonitor | None = None
        if options.get("cues", True):
            from gsapp.excitation.cueing import CueGenerator  # the window starts without it

            cueing = CueGenerator(
                setting.aircraft,
                setting.model,
                history.rate,
                cards=setting.cards,
                fence=setting.fence,
                system=options.get("system", "US"),
            )
            self.cues = CueMonitor(cueing, self._registry, marks, read_events, live=live)
        self.estimates: EstimateMonitor | None = None
        workers = options.get("workers")
        if workers is not None and setting.aircraft is not None:
            from gsapp.session.live_estimation import estimate_monitor  # as above

            self.estimates = estimate_monitor.EstimateMonitor(
                setting.aircraft, setting.model, history, info, name, self._verdicts, workers
            )
        self.landing = LandingMonitor(setting.aircraft, history.rate, on_ground)
        self.consumers = self._all(options.get("consumers", ()))
        self.urgent = self.consumers[: 1 if self.cues is None else 2]

    def _all(self, further: Sequence[Consumer]) -> list[Consumer]:
        found = [self._guarded(self.alarms, _LIMITS, Severity.WARNING)]
        if self.cues is not None:
            found.append(self.cues)  # on its own guard, in a replay too
        if self.estimates is not None:
            found.append(self._guarded(self.estimates, _ESTIMATES))
        if self._live:
            found.append(self._guarded(self.landing, _LANDING))
        return [*found, *(self._guarded(one, _FURTHER) for one in further)]

    def _guarded(
        self, consumer: Consumer, what: str, severity: Severity = Severity.CAUTION
    ) -> Consumer:
        if not self._live:
            return consumer
        key = f"failed:{type(consumer).__name__}"
        return GuardedConsumer(
            consumer, FailureGuard(key, what, severity, self._registry, self._now)
        )

    def _verdicts(self) -> Sequence[InputVerdict]:
        return () if self.cues is None else self.cues.cueing.verdicts

    def reload_limits(self, channel_id: str) -> None:
        """Take other limits for a channel."""
        for monitor in (self.alarms, self.alarms_ahead):
            if monitor is not None:
                monitor.reload_limits(channel_id)

    def finish(self, *, wait: bool) -> None:
        """Judge the very last rows of a flight that is over."""
        if self.cues is not None:
            self.cues.finish()
        if self.estimates is not None:
            self.estimates.finish(wait=wait)
