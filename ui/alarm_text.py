"""Alarms in words: on the screen and for the ear."""

from __future__ import annotations

import re

from gsapp.quantities import channel
from gsapp.session import Alarm
from ui.number_format import unit_text

_MINUS_SIGN = re.compile(r"(?<=\s)-(?=\d)")
_BEFORE_UNIT = re.compile(r"(?<=\d) (?=[^\d\s])")


def format_alarm(alarm: Alarm, units: str) -> str:
    """Return an alarm in words, units as they are shown everywhere else."""
    words = alarm.message_text(units)
    if alarm.rule is not None:
        # Only numbers with units are rewritten; the other sentences are plain words.
        words = _MINUS_SIGN.sub("\N{MINUS SIGN}", unit_text(words))
        words = _BEFORE_UNIT.sub("\N{NO-BREAK SPACE}", words)
    return words[:1].upper() + words[1:]


def spoken_alarm_text(alarm: Alarm) -> str:
    """Return an alarm in a few words for the ear: what, which side, what it means; no numbers."""
    if alarm.rule is None:
        return alarm.message
    meaning = alarm.rule.describe(alarm.severity)
    head = f"{channel(alarm.rule.channel).title} {alarm.rule.side}"
    return f"{head}, {meaning}" if meaning else head
