"""What the bar on top says, from plain facts. No Qt painting here."""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from pathlib import Path

from calibration.validity import CalibrationStatus
from gsapp.session import Alarm, Session, SessionSnapshot
from gsapp.session.equipment_monitor import DiskSummary, LinkSummary, RecorderSummary
from gsapp.session.limits import Severity
from ui.icons import IndicatorState
from ui.number_format import (
    DASH,
    bytes_text,
    clock_text,
    count_text,
    duration_text,
    floor_percent,
    join_sentences,
    percent_text,
    unit_text,
)
from ui.translation import tr


@dataclass(frozen=True, slots=True, kw_only=True)
class StatusItem:
    """What one part of the bar says."""

    id: str  # Name in code.
    title: str  # What it is about, such as ``LINK``.
    value: str = DASH  # The number, or a dash.
    note: str = ""  # What else belongs to it, smaller.
    # ``plain``, ``good``, ``caution``, ``warning`` or ``unknown`` (hatched).
    state: IndicatorState = "unknown"
    detail: str = ""  # The whole in a sentence, for the tool tip and for screen readers.
    # Points reserved for value and note, so that nothing moves when numbers change.
    width: int = 96
    hint: str = ""  # What can be done, beside the word where there is room.
    shows_button: bool = False  # Whether the button beside it is shown.
    # Whether it takes what is left of the bar, and breaks a long value into two lines.
    stretches: bool = False


_STATES_WITHOUT_NUMBERS = (
    "waiting", "no data", "no aircraft", "silent", "unreadable", "not read", "lost", "none",
    "ended", "catching up",
)  # fmt: skip
"""States of the link in which its last numbers are not shown."""
_MINUS_SIGN = re.compile(r"(?<=\s)-(?=\d)")
_BEFORE_UNIT = re.compile(r"(?<=\d) (?=[^\d\s])")
_NO_DATA_STATES = ("silent", "no data", "no aircraft", "unreadable", "not read", "lost")

_STATES: dict[Severity, IndicatorState] = {
    Severity.NORMAL: "good",
    Severity.CAUTION: "caution",
    Severity.WARNING: "warning",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class AlarmSummary:
    """The alarms that nobody has acknowledged, newest first, and how many stand in all."""

    sentences: tuple[str, ...] = ()
    severe: bool = False
    active: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class StatusBarData:
    """Everything that the bar tells."""

    name: str = ""  # Of the flight; empty if none is open.
    time: float | None = None  # Flight time, s.
    stale: bool = False  # Whether that time stands still though it should not.
    replay: bool = False  # Whether a record is being replayed.
    others: tuple[str, ...] = ()  # Other flights that are being recorded, the newest first.
    # What the session says of them; None without a flight.
    link: LinkSummary | None = None
    recorder: RecorderSummary | None = None
    disk: DiskSummary | None = None
    aircraft: str = ""  # Name; empty if there is none.
    calibration: str = ""  # How many certificates are in force; empty if none is.
    # Whether they count; None without a flight.
    calibration_status: CalibrationStatus | None = None
    # What a replay is read with in place of the flight's own certificates; empty for its own.
    other_calibration: str = ""
    alarms: AlarmSummary = field(default_factory=AlarmSummary)  # Alarms.
    page_url: str = ""  # Where browsers show the flight; empty for nowhere.
    muted: bool = False  # Whether the sound is off.
    # How much of the flight so far was read, and how much looked through for alarms, 0 to 1.
    read_share: float = 1.0
    monitored_share: float = 1.0


def create_status_items(facts: StatusBarData) -> tuple[StatusItem, ...]:
    """Return the parts of the bar, left to right."""
    return (
        _flight(facts),
        _link(facts),
        _with_page(_recorder(facts), facts.page_url),
        _aircraft(facts),
        _calibration(facts),
        _sound(facts),
        _alarms(facts),
    )


def _flight(facts: StatusBarData) -> StatusItem:
    if not facts.name:
        return StatusItem(
            id="flight", title=tr("FLIGHT"), value=tr("none open"), state="plain", width=168,
            detail=tr("No flight is open."),
        )  # fmt: skip
    time = DASH if facts.stale else clock_text(facts.time, decimals=1)
    kind = tr("REPLAY") if facts.replay else tr("FLIGHT")
    return StatusItem(
        id="flight",
        title=f"{kind}  {facts.name}",
        value=time,
        note="" if not facts.stale else tr("no new samples"),
        state="unknown" if facts.stale else "plain",
        detail=tr("{name}, flight time {time}").format(name=facts.name, time=time),
        width=168,
    )


def describe_assumed_address(link: LinkSummary) -> str:
    """Return where the aircraft is taken from without a choice of the crew; empty for a choice."""
    if link.system is None or not link.assumed_address:
        return ""
    return tr(
        "System {system} at {address} is taken as the aircraft: its autopilot was received first. "
        "Click LINK to choose another."
    ).format(system=link.system, address=link.assumed_address)


def _link(facts: StatusBarData) -> StatusItem:
    link = facts.link
    if link is None:
        return StatusItem(
            id="link",
            title=tr("LINK"),
            value=tr("none"),
            state="plain",
            detail=tr("No link."),
            width=176,
        )
    port = facts.recorder.source_state if facts.recorder is not None else ""
    said = (link.problem, describe_assumed_address(link), *link.remarks, f"{port}." if port else "")
    remarks = " ".join(filter(None, said))
    state = _STATES[link.severity]
    name = (
        tr("LINK")
        if link.system is None
        else tr("LINK  SYSTEM {system}").format(system=link.system)
    )
    if facts.replay:
        value = percent_text(link.loss) if link.good or link.lost else DASH
        return StatusItem(
            id="link",
            title=tr("{name}  AS RECORDED").format(name=name),
            value=value,
            note=tr("lost"),
            state="plain",
            width=176,
            detail=(
                tr(
                    "{good} good frames, {damaged} damaged, {unknown} unknown, "
                    "{lost} lost. {remarks}"
                ).format(
                    good=link.good,
                    damaged=link.damaged,
                    unknown=link.unknown,
                    lost=link.lost,
                    remarks=remarks,
                )
            ).strip(),
        )
    if link.age is None or link.state in _STATES_WITHOUT_NUMBERS:
        age = f" {duration_text(link.age)}" if link.age is not None else ""
        return StatusItem(
            id="link",
            title=name,
            note=f"{link.state}{age}{_share(facts.read_share)}",
            state=state if link.severity is not Severity.NORMAL else "unknown",
            width=176,
            detail=tr("The link: {state}{age}. {remarks}")
            .format(state=link.state, age=age, remarks=remarks)
            .strip(),
        )
    lost = tr("{loss} lost").format(loss=percent_text(link.loss))
    return StatusItem(
        id="link",
        title=name if link.state == "ok" else f"{name}  {link.state}",
        value=f"{link.rate:.0f}/s",
        note=tr("{age:.1f} s old, {lost}").format(age=link.age, lost=lost),
        state=state,
        width=176,
        detail=(
            tr(
                "{rate:.0f} messages/s, newest {age:.1f} s old, {lost}. {good} "
                "good, {damaged} damaged, {unknown} of unknown kind. {remarks}"
            ).format(
                rate=link.rate,
                age=link.age,
                lost=lost,
                good=link.good,
                damaged=link.damaged,
                unknown=link.unknown,
                remarks=remarks,
            )
        ).strip(),
    )


def _with_page(item: StatusItem, url: str) -> StatusItem:
    if not url:
        return item
    shared = tr("  SHARED")
    detail = tr("{detail} Shown in browsers: {url}").format(detail=item.detail, url=url)
    return replace(item, title=item.title.removesuffix(shared) + shared, detail=detail)


def _recorder(facts: StatusBarData) -> StatusItem:
    recorder, disk = facts.recorder, facts.disk
    others = ", ".join(facts.others)
    if recorder is None or recorder.state in ("none", "stopped"):
        if others:
            several = len(facts.others) > 1
            return StatusItem(
                id="record",
                title=tr("REC"),
                value=tr("{count} flights").format(count=len(facts.others)) if several else others,
                note=tr("click to attach"),
                state="good",
                width=192,
                detail=tr("Being recorded: {others}. Click to attach.").format(others=others),
            )
        stopped = recorder is not None and recorder.state == "stopped"
        return StatusItem(
            id="record",
            title=tr("REC"),
            value=tr("stopped") if stopped else tr("off"),
            state="plain",
            width=192,
            detail=tr("Not recording."),
        )
    size = bytes_text(recorder.received_bytes)
    free = bytes_text(disk.free_bytes) if disk is not None else DASH
    severity = recorder.severity
    note = tr("{state}, {free} left").format(
        state=tr("growing") if recorder.growing else tr("idle"), free=free
    )
    if disk is not None and disk.severity > severity:
        severity = disk.severity
        left = duration_text(disk.seconds_left)
        note = (
            tr("{free} left").format(free=free)
            if disk.seconds_left is None
            else tr("disk full in {left}").format(left=left)
        )
    if recorder.severity is not Severity.NORMAL:
        note = tr("recorder {state}").format(state=recorder.state)
    state = _STATES[severity]
    if state == "good" and not recorder.growing:
        state = "caution"
    more = (
        tr(" Also being recorded: {others}. Click to attach.").format(others=others)
        if others
        else ""
    )
    remarks = (*recorder.remarks, *(share.describe() for share in recorder.shares))
    return StatusItem(
        id="record",
        title=_recorder_text(recorder, len(facts.others)),
        shows_button=recorder.pid is not None,
        value=size,
        note=note,
        state=state,
        width=192,
        detail=tr("{size} recorded, {note}. {remarks}{more}")
        .format(size=size, note=note, remarks=join_sentences(remarks), more=more)
        .strip(),
    )


def _recorder_text(recorder: RecorderSummary, others: int) -> str:
    state = "" if recorder.state == "recording" else f"  {recorder.state}"
    if any(not share.error for share in recorder.shares):
        state += tr("  SHARED")
    return (
        tr("REC{state}  +{others} more").format(state=state, others=others)
        if others
        else tr("REC{state}").format(state=state)
    )


def _aircraft(facts: StatusBarData) -> StatusItem:
    return StatusItem(
        id="aircraft",
        title=tr("AIRCRAFT"),
        value=facts.aircraft or DASH,
        state="plain",
        width=88,
        detail=tr("Aircraft file {aircraft}").format(aircraft=facts.aircraft)
        if facts.aircraft
        else tr("No aircraft file in force."),
    )


def _calibration(facts: StatusBarData) -> StatusItem:
    status = facts.calibration_status
    if status is None:
        return StatusItem(id="calibration", title=tr("CALIBRATION"), state="plain", width=128)
    other = facts.other_calibration
    instead = (
        tr("Those of '{other}' instead of the flight's own. ").format(other=other) if other else ""
    )
    state: IndicatorState = "plain" if status.state == "unknown" else status.state
    note = other if other and state == "good" else status.summary
    return StatusItem(
        id="calibration",
        title=tr("CALIBRATION  OTHER") if other else tr("CALIBRATION"),
        value=facts.calibration or tr("none"),
        note="" if state == "plain" else note,
        state="caution" if other and state == "good" else state,
        width=144 if other else 128,
        detail=f"{instead}{status.detail}.",
    )


def _alarms(facts: StatusBarData) -> StatusItem:
    alarms = facts.alarms
    if not alarms.sentences and facts.monitored_share < 1.0:
        return StatusItem(
            id="alarms", title=tr("ALARMS"), value=tr("catching up"),
            note=_share(facts.monitored_share).strip(),
            state="unknown", width=184, stretches=True,
            detail=tr("Checking the flight so far for alarms and cues."),
        )  # fmt: skip
    if not alarms.sentences:
        standing = alarms.active
        value = tr("{standing} seen").format(standing=standing) if standing else tr("none")
        return StatusItem(
            id="alarms", title=tr("ALARMS"), value=value, width=184, stretches=True,
            state="caution" if standing else ("good" if facts.name else "plain"),
            detail=tr("{alarms} active, all acknowledged").format(
                alarms=count_text(standing, "alarm")
            ),
        )  # fmt: skip
    count = len(alarms.sentences)
    return StatusItem(
        id="alarms",
        title=count_text(count, "ALARM"),
        hint=tr("K acknowledges"),
        value=alarms.sentences[0],
        state="warning" if alarms.severe else "caution",
        width=184,
        stretches=True,
        detail="\n".join(alarms.sentences),
    )


def format_alarm(alarm: Alarm, units: str) -> str:
    """Return an alarm in words, units as they are shown everywhere else."""
    words = alarm.message_text(units)
    if alarm.rule is not None:
        # Only numbers with units are rewritten; the other sentences are plain words.
        words = _MINUS_SIGN.sub("\N{MINUS SIGN}", unit_text(words))
        words = _BEFORE_UNIT.sub("\N{NO-BREAK SPACE}", words)
    return words[:1].upper() + words[1:]


def _share(done: float) -> str:
    return f" {floor_percent(done)} %" if done < 1.0 else ""


def _sound(facts: StatusBarData) -> StatusItem:
    return StatusItem(
        id="sound",
        title=tr("SOUND"),
        value=tr("off") if facts.muted else tr("on"),
        state="caution" if facts.muted else "plain",
        width=64,
        detail=tr("Alarm sound off.") if facts.muted else tr("Alarm sound on."),
    )


def status_bar_data(
    session: Session, snapshot: SessionSnapshot, units: str, *, muted: bool
) -> StatusBarData:
    """Return what the status bar shows of a session."""
    waiting = [alarm for alarm in snapshot.alarms if not alarm.acknowledged]
    replay = snapshot.mode == "replay"
    return StatusBarData(
        name=snapshot.name,
        time=snapshot.now,
        stale=not replay and snapshot.link.state in _NO_DATA_STATES,
        replay=replay,
        link=snapshot.link,
        recorder=None if replay else snapshot.recorder,
        disk=snapshot.disk,
        aircraft=snapshot.aircraft,
        calibration=str(len(snapshot.calibration)) if snapshot.calibration else "",
        other_calibration=Path(session.calibration.override_source).name,
        calibration_status=snapshot.calibration_status,
        alarms=AlarmSummary(
            sentences=tuple(format_alarm(alarm, units) for alarm in waiting),
            severe=any(alarm.severity is Severity.WARNING for alarm in waiting),
            active=len(snapshot.alarms),
        ),
        muted=muted,
        read_share=1.0 if snapshot.is_up_to_date else snapshot.progress,
        monitored_share=snapshot.monitored_fraction,
    )


def session_status_items(
    session: Session | None,
    snapshot: SessionSnapshot | None,
    others: tuple[str, ...],
    units: str,
    *,
    muted: bool,
    page_url: str = "",
) -> tuple[StatusItem, ...]:
    """Return the parts of the bar, of a session or without one."""
    data = StatusBarData(muted=muted)
    if session is not None and snapshot is not None:
        data = status_bar_data(session, snapshot, units, muted=muted)
    return create_status_items(replace(data, others=others, page_url=page_url))
