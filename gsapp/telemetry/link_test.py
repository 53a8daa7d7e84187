"""Listening on a link before anything is recorded: what comes, and who sends."""

from __future__ import annotations

import os
import threading
import time

from gsapp.decoding.frames import MavlinkFrame, Residue
from gsapp.decoding.framing import Framer, LineFramer
from gsapp.decoding.health import LinkHealth, LinkReport
from gsapp.foundation import LinkError
from gsapp.telemetry.clock import HostClock
from gsapp.telemetry.heartbeat import GroundHeartbeat
from gsapp.telemetry.link_diagnosis import ContentSample, LinkDiagnosis, diagnose_link
from gsapp.telemetry.link_registry import kind_of, parse_link
from gsapp.telemetry.recorder_status import RecorderStatus
from gsapp.telemetry.settings import TELEMETRY
from gsapp.telemetry.sources import LinkUnavailableError, open_source


class LinkTest:
    """Opens a link in a thread of its own and keeps nothing but counts, until it is closed.

    Parameters
    ----------
    link : str
        The LINK.

    Attributes
    ----------
    open_error : str
        Why the link cannot be opened at all, in a sentence; empty where it can.

    Raises
    ------
    LinkError
        If it is none.
    """

    def __init__(self, link: str) -> None:
        self._clock = HostClock()
        self._address = parse_link(link)
        self._source = open_source(self._address, clock=self._clock)
        self._health = LinkHealth()
        self._sample = ContentSample()
        self._framers: dict[str, Framer | LineFramer] = {}
        self._received = 0
        self._started_us = self._clock.now_us()
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self.open_error = ""
        self._thread = threading.Thread(target=self._listen, name="testing a link", daemon=True)
        self._thread.start()

    def close(self) -> None:
        self._ended.set()
        self._thread.join()

    @property
    def seconds(self) -> float:
        return (self._clock.now_us() - self._started_us) / 1e6

    def report(self) -> LinkReport:
        with self._lock:
            return self._health.report(self._clock.now_us())

    def diagnosis(self) -> LinkDiagnosis | None:
        """Return why no aircraft is heard; None where one is, or lines of text."""
        if self.open_error:
            return LinkDiagnosis(problem="closed", found=self.open_error)
        report = self.report()
        if report.vehicles:
            return None
        return diagnose_link(
            RecorderStatus(
                pid=os.getpid(),
                link=str(self._address),
                folder="",
                state="recording",
                started_us=self._started_us,
                updated_us=self._clock.now_us(),
                source_state=self._source.state,
                connected=self._source.connected,
                received_bytes=self._received,
                content=self._sample.kind,
            ),
            others=[str(sender) for sender in report.senders],
        )

    def _listen(self) -> None:
        try:
            self._source.open()
        except LinkUnavailableError:
            pass
        except LinkError as error:
            self.open_error = str(error)
            return
        heartbeat = GroundHeartbeat() if kind_of(self._address).needs_heartbeat else None
        next_heartbeat = 0.0
        while not self._ended.is_set() and not self._source.finished:
            if heartbeat is not None and time.monotonic() >= next_heartbeat:
                next_heartbeat = time.monotonic() + TELEMETRY.heartbeat_interval
                self._source.write(heartbeat.frame())
            for stamp, data, peer in self._source.read(TELEMETRY.test_read_timeout):
                self._take(stamp, data, peer)
        self._source.close()

    def _take(self, stamp: int, data: bytes, peer: str) -> None:
        framer = self._framers.get(peer)
        if framer is None:
            framer = self._framers[peer] = self._source.new_framer()
        self._received += len(data)
        self._sample.feed(data)
        kinds = {MavlinkFrame: "frame", Residue: "residue"}
        with self._lock:
            self._health.feed(
                (stamp, kinds.get(type(item), "line"), item.data) for item in framer.feed(data)
            )
