"""What the bar on top says, from plain facts. No Qt painting here."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ui.frame.bar_part import BarPart
from ui.glyphs import State
from ui.words import (
    DASH,
    bytes_text,
    clock_text,
    count_text,
    duration_text,
    percent_text,
)

_LATE, _SILENT = 1.0, 3.0
"""Seconds without anything from the link: late, silent."""

_LOSSY, _BAD = 0.02, 0.10
"""Share of frames lost that calls for caution, for a warning."""

_TIGHT, _FULL = 3600.0, 600.0
"""Seconds of recording that still fit on the disk: caution, warning."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkFacts:
    """The link now.

    Attributes
    ----------
    rate : float
        Frames or lines in a second.
    age : float or None
        Seconds since the last one; None before the first.
    loss : float
        Share lost over the last seconds, 0 to 1.
    words : str
        What the source says of itself; empty if nothing.
    """

    rate: float = 0.0
    age: float | None = None
    loss: float = 0.0
    words: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class RecorderFacts:
    """The recorder now.

    Attributes
    ----------
    size : int
        Bytes in the flight folder's raw files.
    growing : bool
        Whether they grew within the last seconds.
    alive : bool
        Whether the process is there.
    disk_free : float or None
        Bytes left on the disk.
    disk_seconds : float or None
        How long the recording could go on at its present rate, s.
    """

    size: int = 0
    growing: bool = False
    alive: bool = False
    disk_free: float | None = None
    disk_seconds: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class AlarmFacts:
    """The alarms that nobody has acknowledged, newest first, and how many stand in all."""

    sentences: tuple[str, ...] = ()
    severe: bool = False
    standing: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class BarFacts:
    """Everything that the bar tells.

    Attributes
    ----------
    name : str
        Of the flight; empty if none is open.
    time : float or None
        Flight time, s.
    stale : bool
        Whether that time stands still though it should not.
    replay : bool
        Whether a record is being replayed.
    link : LinkFacts or None
        None without a link.
    recorder : RecorderFacts or None
        None if nothing is recorded.
    aircraft, calibration : str
        Names; empty if there is none.
    calibrated_on : str
        Date of the oldest certificate in force.
    uncalibrated : int
        Charted channels that should be calibrated and are not.
    alarms : AlarmFacts
        Alarms.
    muted : bool
        Whether the sound is off.
    """

    name: str = ""
    time: float | None = None
    stale: bool = False
    replay: bool = False
    link: LinkFacts | None = None
    recorder: RecorderFacts | None = None
    aircraft: str = ""
    calibration: str = ""
    calibrated_on: str = ""
    uncalibrated: int = 0
    alarms: AlarmFacts = AlarmFacts()
    muted: bool = False


def bar_parts(facts: BarFacts) -> tuple[BarPart, ...]:
    """Return the parts of the bar, left to right."""
    return (
        _flight(facts),
        _link(facts),
        _recorder(facts),
        _aircraft(facts),
        _calibration(facts),
        _alarms(facts),
        _sound(facts),
    )


def _flight(facts: BarFacts) -> BarPart:
    if not facts.name:
        return BarPart(
            id="flight", word="FLIGHT", value="none open", state="plain", width=168,
            detail="No flight is open.",
        )  # fmt: skip
    time = DASH if facts.stale else clock_text(facts.time, tenths=True)
    kind = "REPLAY" if facts.replay else "FLIGHT"
    return BarPart(
        id="flight",
        word=f"{kind}  {facts.name}",
        value=time,
        note="" if not facts.stale else "no new samples",
        state="unknown" if facts.stale else "plain",
        detail=f"{facts.name}, flight time {time}",
        width=168,
    )


def _link(facts: BarFacts) -> BarPart:
    link = facts.link
    if link is None:
        value, detail = (
            ("none", "No link.") if not facts.replay else ("replay", "A recorded flight.")
        )
        return BarPart(id="link", word="LINK", value=value, state="plain", detail=detail, width=176)
    if link.age is None or not math.isfinite(link.age):
        return BarPart(
            id="link", word="LINK", note="waiting for the first", state="unknown", width=176,
            detail=link.words or "Nothing has come over the link yet.",
        )  # fmt: skip
    if link.age > _SILENT:
        words = f"silent for {duration_text(link.age)}"
        return BarPart(
            id="link", word="LINK", note=words, state="warning", width=176,
            detail=f"The link is {words}. {link.words}".strip(),
        )  # fmt: skip
    state: State = "good"
    if link.age > _LATE or link.loss > _LOSSY:
        state = "caution"
    if link.loss > _BAD:
        state = "warning"
    return BarPart(
        id="link",
        word="LINK",
        value=f"{link.rate:.0f}/s",
        note=f"{link.age:.1f} s old, {percent_text(link.loss)} lost",
        state=state,
        width=176,
        detail=(
            f"{link.rate:.0f} messages in a second, the newest {link.age:.1f} s old, "
            f"{percent_text(link.loss)} lost. {link.words}"
        ).strip(),
    )


def _recorder(facts: BarFacts) -> BarPart:
    recorder = facts.recorder
    if recorder is None:
        return BarPart(
            id="record", word="REC", value="off", state="plain", width=168,
            detail="Nothing is being recorded.",
        )  # fmt: skip
    size, free = bytes_text(recorder.size), bytes_text(recorder.disk_free)
    if not recorder.alive:
        return BarPart(
            id="record", word="REC", value=size, note="recorder stopped", state="warning",
            width=168, detail="The recorder is not running. Connect again: it goes on here.",
        )  # fmt: skip
    left = recorder.disk_seconds
    state: State = "good" if recorder.growing else "caution"
    note = f"{'growing' if recorder.growing else 'not growing'}, {free} left"
    if left is not None and left < _TIGHT:
        state = "warning" if left < _FULL else "caution"
        note = f"disk full in {duration_text(left)}"
    return BarPart(
        id="record",
        word="REC",
        value=size,
        note=note,
        state=state,
        width=200,
        detail=f"{size} recorded, {note}.",
    )


def _aircraft(facts: BarFacts) -> BarPart:
    return BarPart(
        id="aircraft",
        word="AIRCRAFT",
        value=facts.aircraft or DASH,
        state="plain",
        width=88,
        detail=f"Aircraft file {facts.aircraft}"
        if facts.aircraft
        else "No aircraft file in force.",
    )


def _calibration(facts: BarFacts) -> BarPart:
    if not facts.name:
        return BarPart(id="calibration", word="CALIBRATION", state="plain", width=120)
    if not facts.calibration:
        return BarPart(
            id="calibration", word="CALIBRATION", value="none", state="plain", width=120,
            detail="No calibration is in force: the aircraft sends engineering units.",
        )  # fmt: skip
    missing = facts.uncalibrated
    note = f"{missing} missing" if missing else facts.calibrated_on
    return BarPart(
        id="calibration",
        word="CALIBRATION",
        value=facts.calibration,
        note=note,
        state="caution" if missing else "good",
        width=120,
        detail=f"Calibration {facts.calibration}, {note}".rstrip(", "),
    )


def _alarms(facts: BarFacts) -> BarPart:
    alarms = facts.alarms
    if not alarms.sentences:
        standing = alarms.standing
        value = f"{standing} seen" if standing else "none"
        return BarPart(
            id="alarms", word="ALARMS", value=value, width=240, grows=True,
            state="caution" if standing else ("good" if facts.name else "plain"),
            detail=f"{count_text(standing, 'alarm')} standing, all acknowledged",
        )  # fmt: skip
    count = len(alarms.sentences)
    return BarPart(
        id="alarms",
        word=f"{count_text(count, 'ALARM', 'ALARMS')}   K acknowledges",
        value=alarms.sentences[0],
        state="warning" if alarms.severe else "caution",
        width=240,
        grows=True,
        detail="\n".join(alarms.sentences),
    )


def _sound(facts: BarFacts) -> BarPart:
    return BarPart(
        id="sound",
        word="SOUND  S",
        value="off" if facts.muted else "on",
        state="caution" if facts.muted else "plain",
        width=64,
        detail="Alarms are silent." if facts.muted else "Alarms sound.",
    )
