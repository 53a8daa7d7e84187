"""A flight being watched, live or in a replay: history, alarms, marks, equipment. No Qt."""

from gsapp.session.alarms import Alarm, AlarmRegistry
from gsapp.session.channel_states import ChannelState, Freshness
from gsapp.session.consumer_scheduler import Consumer
from gsapp.session.feeds import UNLIMITED_SPEED
from gsapp.session.limits import LimitBands, LimitSet, Severity
from gsapp.session.marks import FlightMark
from gsapp.session.sample_history import SampleHistory
from gsapp.session.session import Session
from gsapp.session.snapshot import Playhead, SessionSnapshot

__all__ = [
    "UNLIMITED_SPEED",
    "Alarm",
    "AlarmRegistry",
    "ChannelState",
    "Consumer",
    "FlightMark",
    "Freshness",
    "LimitBands",
    "LimitSet",
    "Playhead",
    "SampleHistory",
    "Session",
    "SessionSnapshot",
    "Severity",
]
