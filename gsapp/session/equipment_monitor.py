"""Link, recorder and disk of a live flight: what the bar says of them, and their alarms."""

from __future__ import annotations

import shutil
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from gsapp.decoding.health import LinkHealth, LinkReport
from gsapp.session.alarms import AlarmRegistry
from gsapp.session.limits import Severity
from gsapp.session.monitor_settings import MONITORS
from gsapp.telemetry.link_diagnosis import diagnose_link
from gsapp.telemetry.recorder_control import RecorderHandle, find_recorder, read_last_status
from gsapp.telemetry.recorder_status import RecorderStatus, ShareStatus

_NOT_HEARD_YET = ("no data", "no aircraft")
# States of a recorder that holds what arrives in memory: the record says nothing of the link.
_NOT_WRITING = ("not writing", "without folder")
STUCK_DISK_TEXT = "the disk does not respond: the display is stopped until it does"


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkSummary:
    """The link as the bar shows it."""

    state: str
    """``ok``, ``waiting``, ``no data``, ``no aircraft``, ``silent``, ``unreadable``, ``lost``,
    ``ended`` ..."""
    severity: Severity = Severity.NORMAL
    system: int | None = None
    """The flown system; None before it is known, and for lines of text."""
    assumed_address: str = ""
    """Where its first heartbeat came from, if it is taken from there without a choice of the crew.
    """
    problem: str = ""
    """Why no aircraft is heard and what to try, in sentences; empty where one is."""
    rate: float = 0.0
    """Messages of the flown aircraft per second."""
    age: float | None = None
    """Seconds since the last of them; None before the first, where it cannot be read, and in a
    replay."""
    loss: float = 0.0
    """Share of its frames lost in the last seconds (in a replay: in all), 0 to 1."""
    good: int = 0
    damaged: int = 0
    unknown: int = 0
    lost: int = 0
    remarks: tuple[str, ...] = ()
    """What else the crew should know, in words."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RecorderSummary:
    """The recorder as the bar shows it."""

    state: str
    """``recording``, ``stopped``, ``failed`` ..."""
    severity: Severity = Severity.NORMAL
    pid: int | None = None
    link: str = ""
    source_state: str = ""
    """How the link fares, in its words."""
    received_bytes: int = 0
    heartbeats: int = 0
    """Sent so far."""
    byte_rate: float = 0.0
    growing: bool = False
    """Whether what was written grew since the look before."""
    shares: tuple[ShareStatus, ...] = ()
    """Whom it passes on to what it receives."""
    share_notes: bool = False
    """Whether the notes of those are written into the flight."""
    sends_notes: bool | None = None
    """Of a flight that is copied now: whether its recorder takes the notes made here; else None."""
    remarks: tuple[str, ...] = ()
    """What was found in the folder at its start, and what is wrong."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DiskSummary:
    """The room for recording."""

    free_bytes: int | None = None
    seconds_left: float | None = None
    """For how long it lasts at the present rate; None while nothing comes."""
    severity: Severity = Severity.NORMAL


@dataclass(frozen=True, slots=True, kw_only=True)
class RecorderObservation:
    """What the disk tells of a recorder."""

    handle: RecorderHandle | None = None
    status: RecorderStatus | None = None
    is_folder_reachable: bool = True
    """Whether the flight folder is where it was."""
    free_bytes: int | None = None
    """On the disk of the flight, where the recorder does not say so."""


class RecorderProbe:
    """Reads from the disk how the recorder of a flight folder fares."""

    def __init__(self, folder: Path) -> None:
        self._folder = self._recorded_in = folder.absolute()
        self._status: RecorderStatus | None = None

    def read(self) -> RecorderObservation:
        handle = find_recorder(self._folder)
        status = handle.status() if handle is not None else None
        # Where nothing can be read any more, what was there last must not pass for nothing.
        if handle is not None:
            self._recorded_in = handle.folder
        self._status = status or read_last_status(self._recorded_in) or self._status
        free = None if handle is None or self._status is None else self._status.disk_free_bytes
        if free is None:
            with suppress(OSError):
                free = shutil.disk_usage(self._folder).free
        return RecorderObservation(
            handle=handle,
            status=self._status,
            is_folder_reachable=handle is None or handle.is_folder_reachable(),
            free_bytes=free,
        )


class EquipmentMonitor:
    """Looks after the equipment of a live flight, and raises its alarms.

    Parameters
    ----------
    facts : callable, optional
        Returns what the disk tells of the recorder; by default that is read with every look.

    Attributes
    ----------
    landed : bool
        Whether the aircraft has landed: it may be switched off, and silence is no alarm.
    """

    def __init__(
        self,
        folder: Path,
        registry: AlarmRegistry,
        clock: Callable[[], float],
        wall_us: Callable[[], int],
        facts: Callable[[], RecorderObservation] | None = None,
    ) -> None:
        self._folder = folder.absolute()
        self._read_facts = facts or RecorderProbe(folder).read
        self._facts = RecorderObservation()
        self._registry = registry
        self._clock = clock
        self._wall_us = wall_us
        self._next_check = -1.0
        self._written: int | None = None
        self._updated_us: int | None = None
        self._spoke = 0.0  # by the clock that never goes back
        self._reported_ahead_us = 0
        self._folder_move_reported = ""
        self._recent: deque[tuple[float, int, int]] = deque()
        self.landed = False
        self.link = LinkSummary(state="waiting")
        self.recorder = RecorderSummary(state="none")
        self.disk = DiskSummary()

    @property
    def handle(self) -> RecorderHandle | None:
        """Return the recorder that runs, for stopping it."""
        return self._facts.handle

    @property
    def _status(self) -> RecorderStatus | None:
        return self._facts.status

    @property
    def ended(self) -> bool:
        """Return whether the record is complete: its recorder was told to stop, and did."""
        return self.handle is None and self._status is not None and self._status.state == "stopped"

    @property
    def moved_to(self) -> Path | None:
        """Return the folder in which the record continues once this one is gone; else None."""
        handle = self.handle
        return None if handle is None or handle.folder == self._folder else handle.folder

    def host_us(self) -> int:
        """Return the present time as the recorder stamps it, microseconds since 1970.

        Where the computer's clock was set back, its stamps went on; ages count from here.
        """
        return self._wall_us() + (0 if self._status is None else self._status.ahead_us)

    def update(
        self,
        health: LinkHealth | None,
        now: float | None,
        *,
        caught_up: bool = True,
        unread: bool = False,
        stuck: bool = False,
    ) -> bool:
        """Look at everything, if it is time; return whether it was.

        Parameters
        ----------
        caught_up : bool
            Whether everything recorded was counted in `health`. While an older part of the record
            is being read its age says nothing of the link.
        unread : bool
            Whether the record cannot be read. What the recorder says of the link counts then.
        stuck : bool
            Whether the disk does not respond: nothing is known of link and recorder.
        """
        time = self._clock()
        if time < self._next_check:
            return False
        self._next_check = time + MONITORS.equipment_interval
        self._facts = self._read_facts()
        if stuck:
            self._note_stuck_disk(now)
            return True
        self._update_recorder_age(self._status, time)
        self._check_clock(now)
        self._check_folder(now)
        self.recorder = self._check_recorder(now, time)
        self.disk = self._check_disk(now)
        if unread or self.recorder.state in _NOT_WRITING:
            self.link = self._check_unread_link(now)
        elif caught_up or self.handle is None:
            self.link = self._check_link(health, time, now)
        else:
            self.link = replace(self.link, state="catching up", age=None)
        return True

    def _note_stuck_disk(self, now: float | None) -> None:
        self._update_alarm("disk", Severity.WARNING, now, STUCK_DISK_TEXT, self.disk.severity)
        self.disk = replace(self.disk, severity=Severity.WARNING)
        # An alarm of the link stays until it is known to be well again.
        self.link = replace(self.link, state="not read", age=None)

    def _update_recorder_age(self, status: RecorderStatus | None, time: float) -> None:
        """Note when the recorder last spoke.

        How old its first word is only the computer's clock can tell. From then on the clock
        counts that nobody sets.
        """
        if status is None or status.updated_us == self._updated_us:
            return
        first = self._updated_us is None
        old = max(self.host_us() - status.updated_us, 0) / 1e6 if first else 0.0
        self._updated_us, self._spoke = status.updated_us, time - old

    def _check_clock(self, now: float | None) -> None:
        """Tell once of every time that the computer's clock was set back."""
        status = self._status
        ahead = 0 if status is None else status.ahead_us - status.clock_offset_us
        if ahead - self._reported_ahead_us >= MONITORS.clock_set_back_us:
            self._reported_ahead_us = ahead
            self._registry.raise_("clock", Severity.CAUTION, now, _clock_set_back_text(ahead))
        else:
            # It happened and is over: the alarm stays until somebody has seen it.
            self._reported_ahead_us = min(self._reported_ahead_us, ahead)
            self._registry.clear("clock", now)

    def _check_folder(self, now: float | None) -> None:
        """Tell once that the record continues in another folder; until somebody has seen it."""
        former = "" if self._status is None else self._status.moved_from
        if former != self._folder_move_reported:
            self._folder_move_reported = former
            here = Path(self._status.folder).name if self._status is not None else ""
            text = (
                f"flight folder {Path(former).name} was removed, renamed or made read-only: "
                f"recording continues in {here}"
            )
            self._registry.raise_("folder", Severity.WARNING, now, text)
        else:
            self._registry.clear("folder", now)

    def _update_alarm(
        self, key: str, severity: Severity, now: float | None, text: str, former: Severity
    ) -> None:
        if severity is not Severity.NORMAL:
            self._registry.raise_(key, severity, now, text)
        elif former is not Severity.NORMAL:
            self._registry.clear(key, now)

    def _check_recorder(self, now: float | None, time: float) -> RecorderSummary:
        former = self.recorder
        status = self._status
        text, severity, sentence = self._state_of_recorder(time)
        self._update_alarm("recorder", severity, now, sentence, former.severity)
        if status is None:
            return RecorderSummary(state=text, severity=severity)
        running = self.handle is not None
        growing = self._written is not None and status.received_bytes > self._written
        self._written = status.received_bytes
        set_back_us = status.ahead_us - status.clock_offset_us
        ahead = (
            (_clock_set_back_text(set_back_us),)
            if set_back_us >= MONITORS.clock_set_back_us
            else ()
        )
        wrong = (sentence,) if sentence else ()
        return RecorderSummary(
            state=text,
            severity=severity,
            pid=status.pid if running else None,
            link=status.link,
            source_state=status.source_state if running else "",
            received_bytes=status.received_bytes,
            heartbeats=status.heartbeats,
            byte_rate=status.byte_rate if running else 0.0,
            growing=running and growing,
            shares=tuple(status.shares) if running else (),
            share_notes=running and status.share_notes,
            sends_notes=status.sends_notes if running else None,
            remarks=(*wrong, *ahead, *status.warnings, *status.notes),
        )

    def _state_of_recorder(self, time: float) -> tuple[str, Severity, str]:
        """Return the state in one word, whether it is well, and the sentence of the alarm."""
        status = self._status
        if self.handle is None:
            if status is None:
                return "none", Severity.NORMAL, ""
            if status.state == "stopped":
                return "stopped", Severity.NORMAL, ""
            return (
                "failed",
                Severity.WARNING,
                "the recorder stopped unexpectedly: not recording until it restarts",
            )
        if not self._facts.is_folder_reachable:
            return (
                "without folder",
                Severity.WARNING,
                (status.error if status is not None else "")
                or "flight folder not found: the recorder is moving to a new one beside it",
            )
        if status is None:
            return "starting", Severity.NORMAL, ""
        if time - self._spoke > MONITORS.recorder_timeout:
            return (
                "hangs",
                Severity.WARNING,
                "no recorder status for more than 5 s: computer overloaded or disk stalled",
            )
        if status.error:
            text = "on failing disk" if status.unconfirmed else "not writing"
            return text, Severity.WARNING, status.error
        return status.state, Severity.NORMAL, ""

    def _check_disk(self, now: float | None) -> DiskSummary:
        former = self.disk
        status = self._status if self.handle is not None else None
        if status is not None and status.disk_free_bytes is not None:
            free: int | None = status.disk_free_bytes
            left = status.seconds_until_full
        else:
            free, left = self._facts.free_bytes, None
        severity = Severity.NORMAL
        lasts = float("inf") if left is None else left
        if free is not None and self.handle is not None:
            if free < MONITORS.full_disk_bytes or lasts < MONITORS.full_disk_time:
                severity = Severity.WARNING
            elif free < MONITORS.low_disk_bytes or lasts < MONITORS.low_disk_time:
                severity = Severity.CAUTION
        minutes = f", enough for {left / 60.0:.0f} min" if left is not None else ""
        sentence = f"the disk has {(free or 0) / 1e6:.0f} MB left{minutes}: make room"
        self._update_alarm("disk", severity, now, sentence, former.severity)
        return DiskSummary(free_bytes=free, seconds_left=left, severity=severity)

    def _check_link(self, health: LinkHealth | None, time: float, now: float | None) -> LinkSummary:
        former = self.link
        report = None if health is None else health.report(self.host_us())
        loss = self._recent_loss(report, time)
        age = None if report is None else report.age
        unreadable = "" if report is None else report.unreadable
        arrived = None if health is None else health.last_stamp
        if arrived is None or self.host_us() - arrived > MONITORS.silence_time * 1e6:
            unreadable = ""
        text, severity, sentence = self._state_of_link(report, age, loss, unreadable)
        if self.landed:
            severity, sentence = Severity.NORMAL, ""
        if text == "unreadable":
            age = None
        self._update_alarm("link", severity, now, sentence, former.severity)
        if former.state in _NOT_HEARD_YET and text == "ok":
            # Whoever waited for the aircraft need not confirm that it came.
            self._registry.dismiss("link")
        remarks = () if report is None else report.warnings
        others = [said for said in remarks if said != unreadable]
        if others and self.handle is not None:
            self._registry.raise_("aircraft", Severity.CAUTION, now, " ".join(others))
        else:
            self._registry.clear("aircraft", now)
        strangers = () if report is None else report.recently_rejected
        if strangers and self.handle is not None:
            self._registry.raise_("stranger", Severity.WARNING, now, " ".join(strangers))
        else:
            self._registry.clear("stranger", now)
        view = build_link_summary(report, words=text, severity=severity, loss=loss, age=age)
        return replace(view, problem=sentence if age is None else "")

    def _check_unread_link(self, now: float | None) -> LinkSummary:
        former = self.link
        heard = None if self._status is None else self._status.last_data_us
        age = None if heard is None else max(self.host_us() - heard, 0) / 1e6
        text, severity, sentence = self._state_of_link(None, age, 0.0, "")
        if self.landed:
            severity, sentence = Severity.NORMAL, ""
        self._update_alarm("link", severity, now, sentence, former.severity)
        return LinkSummary(state="not read" if text == "ok" else text, severity=severity)

    def _state_of_link(
        self, report: LinkReport | None, age: float | None, loss: float, unreadable: str
    ) -> tuple[str, Severity, str]:
        status = self._status
        if self.handle is None or status is None:
            return ("ended" if self.ended else "none"), Severity.NORMAL, ""
        if not status.connected:
            state = status.source_state or "the port cannot be opened"
            return "lost", Severity.WARNING, f"link lost: {state}"
        if unreadable:
            found = diagnose_link(status)
            known = found is not None and found.problem in ("unreadable", "text", "mavlink")
            return "unreadable", Severity.WARNING, str(found) if known else unreadable
        if age is None:
            return self._no_contact_state(status, report)
        if age > MONITORS.silence_time:
            return "silent", Severity.WARNING, _silence_text(report)
        if loss > MONITORS.max_loss:
            return (
                "weak",
                Severity.CAUTION,
                "the link is weak: more than a tenth of the frames are lost",
            )
        return "ok", Severity.NORMAL, ""

    def _no_contact_state(
        self, status: RecorderStatus, report: LinkReport | None
    ) -> tuple[str, Severity, str]:
        """Return how a link stands over which the aircraft has not been heard yet."""
        waited = (status.updated_us - status.started_us) / 1e6
        problem = self._problem(status, report) if waited >= MONITORS.no_data_time else ""
        if not problem:
            return "waiting", Severity.NORMAL, ""
        text = _NOT_HEARD_YET[status.received_bytes > 0]
        return text, Severity.CAUTION, problem

    @staticmethod
    def _problem(status: RecorderStatus, report: LinkReport | None) -> str:
        others = () if report is None else map(str, report.senders)
        found = diagnose_link(status, others=others)
        return "" if found is None else str(found)

    def _recent_loss(self, report: LinkReport | None, time: float) -> float:
        """Return the share of frames lost over the last seconds."""
        if report is None:
            return 0.0
        recent, flown = self._recent, report.flown
        recent.append((time, *((flown.arrived, flown.lost) if flown is not None else (0, 0))))
        while len(recent) > 2 and recent[1][0] <= time - MONITORS.loss_window:
            recent.popleft()
        came = recent[-1][1] - recent[0][1]
        lost = max(recent[-1][2] - recent[0][2], 0)
        return lost / (came + lost) if came + lost >= MONITORS.min_loss_frames else 0.0


def _silence_text(report: LinkReport | None) -> str:
    system = None if report is None else report.system
    name = "aircraft" if system is None else f"aircraft (system {system})"
    return f"{name} silent: no data for more than {MONITORS.silence_time:.0f} s"


def _clock_set_back_text(ahead_us: int) -> str:
    seconds = ahead_us / 1e6
    much = f"{seconds:.0f} s" if seconds < 120.0 else f"{seconds / 60.0:.0f} min"
    return (
        f"the computer's clock was set back: it is {much} behind the record, whose time "
        "continues; check the date and time"
    )


def build_link_summary(
    report: LinkReport | None,
    *,
    words: str,
    severity: Severity = Severity.NORMAL,
    loss: float | None = None,
    age: float | None = None,
) -> LinkSummary:
    """Return what to show of a report; without `loss` that since the beginning."""
    if report is None:
        return LinkSummary(state=words, severity=severity)
    return LinkSummary(
        state=words,
        severity=severity,
        system=report.system,
        assumed_address=(
            "" if report.flown is None or report.is_address_selected else report.flown.address
        ),
        rate=report.rate,
        age=age,
        loss=report.loss if loss is None else loss,
        good=report.good,
        damaged=report.damaged,
        unknown=report.unknown,
        lost=report.lost,
        remarks=report.warnings,
    )
