"""What a record tells of itself: sources, certificates, losses, words, and all as one flight."""

from __future__ import annotations

import math
from collections.abc import Mapping

from calibration import Certificate
from gsapp.decoding.decoder import Decoder
from gsapp.decoding.pipeline import ChannelSource
from gsapp.flight.certificates import (
    AppliedCertificates,
    calibration_remarks,
    instruments_out_of_range,
    uncalibrated_channels,
)
from gsapp.flight.events import Event, event_from_notice, sort_events
from gsapp.flight.flight import Flight, FrameCounts
from gsapp.flight.flight_loader import damaged_events_text
from gsapp.flight.folder import FlightFolder
from gsapp.flight.info import FlightInfo
from gsapp.flight.onboard_log import OnboardLogState
from gsapp.flight.parameter_events import parameter_events
from gsapp.flight.uniform_grid import combine_on_grid
from gsapp.foundation import FileProblemsError
from gsapp.quantities import Block
from gsapp.session.marks import MarkStore
from gsapp.session.monitor_settings import MONITORS
from gsapp.session.readers import FlightReader, RecordReader
from gsapp.session.sample_history import SampleHistory
from gsapp.session.session_flight import SessionFlight

_SAID = frozenset({"status", "mode", "parameter"})
"""Kinds of events that the vehicle itself causes, for its status messages."""


class FlightMetadata:
    """What can be told of a flight beside its samples."""

    def __init__(
        self, opened: SessionFlight, name: str, history: SampleHistory, mark_store: MarkStore
    ) -> None:
        self._opened = opened
        self.name = name
        self._history = history
        self._mark_store = mark_store
        self._read_info = opened.poll(self._info_on_disk, MONITORS.info_interval)

    @property
    def decoder(self) -> Decoder | None:
        """Return the decoder; None before a map was found, and for flights read whole."""
        reader = self._opened.reader
        return reader.decoder if isinstance(reader, RecordReader) else None

    @property
    def sources(self) -> Mapping[str, ChannelSource]:
        """Return every channel that the flight can have, and from where."""
        return self._opened.reader.sources

    @property
    def certificates(self) -> Mapping[str, Certificate]:
        """Return the certificates in force, by channel."""
        reader = self._opened.reader
        if isinstance(reader, RecordReader):
            return reader.certificates
        return self._opened.setting.certificates or {}

    @property
    def calibration(self) -> AppliedCertificates:
        """Return which certificates are in force, and whether in place of the flight's own."""
        if self._opened.loaded_flight is not None:
            return self._opened.loaded_flight.certificates
        setting = self._opened.setting
        return AppliedCertificates(
            applied=self.certificates,
            override_source=setting.override_source,
            recorded=setting.recorded,
        )

    @property
    def uncalibrated(self) -> tuple[str, ...]:
        """Return the channels whose instruments give volts only, for want of a certificate."""
        return uncalibrated_channels(self.sources)

    @property
    def out_of_calibrated_range(self) -> tuple[str, ...]:
        """Return the instruments that now read beyond what they were calibrated for."""
        return instruments_out_of_range(self.calibration, self.sources, self._latest_value)

    def _latest_value(self, name: str) -> float:
        last = self._history.last(name) if name in self._history.channels else None
        return math.nan if last is None else last[1]

    @property
    def is_read_whole(self) -> bool:
        """Return whether the flight was read whole, rather than decoded record by record."""
        return isinstance(self._opened.reader, FlightReader)

    @property
    def problem(self) -> str:
        """Return why nothing can be read, in words; empty where it can."""
        reader = self._opened.reader
        return reader.problem if isinstance(reader, RecordReader) else ""

    def remarks(self, block: Block | None = None) -> tuple[str, ...]:
        """Return what was lost or left out on reading, in words.

        Parameters
        ----------
        block : Block, optional
            The whole flight, of which there is more to be said.
        """
        read_whole = self._opened.loaded_flight
        whole = () if read_whole is None else read_whole.remarks
        decoder = self.decoder
        said = () if decoder is None else (*decoder.health.warnings(), *decoder.remarks)
        lost = [damage.describe() for damage in self._opened.find_damage()]
        if self._mark_store.damaged and read_whole is None:
            lost.append(damaged_events_text(self._mark_store.damaged))
        # What was read whole has said so itself.
        read = (
            calibration_remarks(self.calibration, self.sources, block) if read_whole is None else ()
        )
        return (*lost, *read, *self._opened.setting.remarks, *whole, *said)

    def info(self) -> FlightInfo | None:
        """Return the flight card as it is now; None without one, or if it holds mistakes."""
        loaded = self._opened.loaded_flight
        return self._read_info() if loaded is None else loaded.info

    def _info_on_disk(self) -> FlightInfo | None:
        path = self._opened.path
        try:
            return FlightFolder(path=path).info() if path.is_dir() else None
        except FileProblemsError:
            return None

    def messages(self, until: float | None) -> tuple[Event, ...]:
        """Return what the vehicle said, and what was noticed about it, by time."""
        return tuple(one for one in self._vehicle_events(until) if one.kind != "parameters")

    def _vehicle_events(self, until: float | None) -> tuple[Event, ...]:
        decoder, whole = self.decoder, self._opened.loaded_flight
        if decoder is not None:
            said = [
                *(
                    event_from_notice(notice)
                    for notice in (*decoder.messages, *decoder.modes, *decoder.notices)
                ),
                *parameter_events(decoder.parameters),
            ]
        elif whole is not None:
            said = [event for event in whole.events if event.kind in _SAID]
        else:
            said = []
        told = [
            event for event in said if until is None or event.time is None or event.time <= until
        ]
        return tuple(sorted(told, key=lambda event: (event.time is not None, event.time or 0.0)))

    def flight(self, until: float | None) -> Flight:
        """Return everything so far as one flight; see `gsapp.session.Session.flight`."""
        if self._opened.loaded_flight is not None:
            return self._opened.loaded_flight
        path, decoder = self._opened.path, self.decoder
        health = None if decoder is None else decoder.health
        damage = list(self._opened.find_damage())
        block = combine_on_grid(self._history.blocks(), self._history.rate)
        info = FlightFolder(path=path).info() if path.is_dir() else None
        log = None if info is None or not info.onboard_log else _onboard_log_state(info.onboard_log)
        # A log of another ground station has its damage in the file, not in a residue.
        torn = sum(each.location_count for each in damage) if path.is_file() else 0
        counted = self.sources if decoder is None else decoder.counted_sources()
        return Flight(
            name=self.name,
            path=path,
            block=block,
            sources={name: counted[name] for name in block.channels},
            info=info,
            frames=None
            if decoder is None or health is None
            else FrameCounts(
                good=health.good,
                damaged=health.damaged + torn,
                unknown=health.unknown,
                lost=health.lost,
                lines=decoder.lines,
                bad_lines=decoder.bad_lines,
            ),
            events=sort_events((*self._mark_store.events, *self._vehicle_events(until))),
            remarks=(*(() if log is None else (log.why,)), *self.remarks(block)),
            certificates=self.calibration,
            onboard=log,
        )


def _onboard_log_state(log: str) -> OnboardLogState:
    return OnboardLogState(
        file=log,
        in_place=False,
        why=f"this is the live record; the on-board log {log} holds more: 'gsapp export' joins the "
        "two, and the log can be replayed alone",
    )
