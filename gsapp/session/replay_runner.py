"""Playing a replay to its end without a window."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from gsapp.flight.read_settings import DEFAULT_AIRCRAFT, FlightReadSettings
from gsapp.session.feeds import UNLIMITED_SPEED, ReplayFeed
from gsapp.session.session import Session

_STEP, _PAUSE = 0.1, 0.01  # s of work at most, and between two steps that wait for the clock


def run_replay(session: Session, tell: Callable[[float], None] = lambda _: None) -> None:
    """Play a replay to its end, as fast as it goes or at its speed."""
    feed = session.replay_feed
    if feed is None:
        raise ValueError("only a replay has an end")
    while True:
        session.update(_STEP)
        if feed.complete and (feed.now is None or (feed.at_end and feed.caught_up)):
            break
        tell(_share(feed))
        if feed.speed != UNLIMITED_SPEED:
            time.sleep(_PAUSE)
    session.finish()
    tell(1.0)


def follow_recording(session: Session, tell: Callable[[], object]) -> None:
    """Watch a flight that is being recorded until its recorder stops, or is no more."""
    equipment = session.equipment
    if equipment is None:
        raise ValueError("only a live flight has a recorder")
    while equipment.recorder.state not in ("stopped", "failed") or not session.feed.caught_up:
        session.update(_STEP)
        tell()
        time.sleep(_PAUSE)
    session.finish()


def _share(feed: ReplayFeed) -> float:
    """Return the share done: of reading ahead, and of the playhead's way."""
    if feed.now is None or feed.start is None or feed.end is None or feed.end <= feed.start:
        return 0.5 * feed.progress
    return 0.5 * feed.progress + 0.5 * (feed.now - feed.start) / (feed.end - feed.start) * (
        feed.progress
    )


def replay_to_end(
    path: Path,
    aircraft: str | None,
    model: str | None,
    channel_map: str | None,
    calibration: str | None,
    cards: str | None,
) -> Session:
    """Replay a flight to its end; the caller closes the session."""
    flown = FlightReadSettings.load(path, aircraft=aircraft).aircraft
    session = Session.replay(
        path, speed=UNLIMITED_SPEED, channel_map=channel_map, certificates=calibration,
        aircraft=flown or DEFAULT_AIRCRAFT, model=model, cards=cards,
    )  # fmt: skip
    try:
        run_replay(session)
    except BaseException:
        session.close()
        raise
    return session
