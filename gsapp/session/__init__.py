"""A flight being watched, live or in a replay: history, alarms, marks, equipment. No Qt."""

from gsapp.session.alarms import Alarm, AlarmBoard
from gsapp.session.feeds import MAX_SPEED
from gsapp.session.following import Consumer
from gsapp.session.history import History
from gsapp.session.limits import Bands, LimitSet, Severity
from gsapp.session.marks import Mark
from gsapp.session.session import Session
from gsapp.session.snapshot import Playhead, SessionSnapshot
from gsapp.session.states import ChannelState, Freshness

__all__ = [
    "MAX_SPEED",
    "Alarm",
    "AlarmBoard",
    "Bands",
    "ChannelState",
    "Consumer",
    "Freshness",
    "History",
    "LimitSet",
    "Mark",
    "Playhead",
    "Session",
    "SessionSnapshot",
    "Severity",
]
