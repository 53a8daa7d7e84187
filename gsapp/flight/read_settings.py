"""What a flight is read with: channel map, certificates, aircraft, rate of the grid."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from calibration import Certificate, load_certificates
from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.decoding.channel_map import ChannelMap, load_channel_map
from gsapp.decoding.decoder import Decoder
from gsapp.flight.certificates import AppliedCertificates
from gsapp.flight.events import events_path, read_selected_system
from gsapp.flight.folder import FlightFolder
from gsapp.flight.info import FlightInfo
from gsapp.foundation import FlightError
from gsapp.foundation.files import path_lexists

DEFAULT_AIRCRAFT = "b777"
"""The shipped aircraft file taken where neither the user nor the flight names one."""
DEFAULT_GRID_RATE = 100.0
"""Samples per second of the grid where nothing else is said."""

NameOrPath = str | Path


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightReadSettings:
    """What shapes the numbers of a flight, beside the record itself."""

    channel_map: ChannelMap | None = None
    """None leaves it to be guessed from the record."""
    certificates: Mapping[str, Certificate] | None = None
    """By channel; None takes those that the map names."""
    override_source: str = ""
    """What `certificates` were given as, in place of the flight's own; empty where they are its
    own."""
    recorded: Mapping[str, Certificate] | None = None
    """Those kept with the flight; None if none are."""
    aircraft: Aircraft | None = None
    """For limits and instrument ranges."""
    rate: float | None = None
    """Of the grid, Hz; None leaves it to the reader."""
    system: int | None = None
    """The flown system that the crew has chosen; None leaves it to the map and the record."""
    address: str = ""
    """The network address that it sends from, if the crew has chosen one."""
    raw: tuple[str, ...] = ()
    """Patterns of raw channels, beside those of the map."""
    native: bool = False
    """Whether samples stay at their own times instead of the grid."""

    @classmethod
    def load(
        cls,
        path: Path,
        *,
        channel_map: ChannelMap | NameOrPath | None = None,
        certificates: NameOrPath | None = None,
        aircraft: Aircraft | NameOrPath | None = None,
        rate: float | None = None,
        raw: Sequence[str] = (),
        native: bool = False,
    ) -> FlightReadSettings:
        """Find what a flight is read with: what is given, else what lies in its folder.

        The folder need not hold anything yet.
        """
        own = None
        if path.is_dir():
            folder = FlightFolder(path=path)
            info = folder.info()
            rate = rate or (info.grid_rate if info else None)
            if channel_map is None and path_lexists(folder.channel_map_file):
                channel_map = folder.channel_map_file
            if folder.certificate_files():
                own = load_certificates(folder.calibration_folder)
        if isinstance(channel_map, (str, Path)):
            channel_map = load_channel_map(channel_map)
        system, address = read_selected_system(events_path(path))
        return FlightReadSettings(
            channel_map=channel_map,
            certificates=own if certificates is None else load_certificates(certificates),
            override_source="" if certificates is None else str(certificates),
            recorded=own,
            aircraft=find_aircraft(path, aircraft),
            rate=rate,
            system=system,
            address=address,
            raw=tuple(raw),
            native=native,
        )

    @property
    def grid_rate(self) -> float:
        """Return the rate of the grid of a decoded record, Hz."""
        return self.rate or DEFAULT_GRID_RATE

    def decoder(self, channel_map: ChannelMap) -> Decoder:
        """Return a decoder of the flight's raw records with a map."""
        return Decoder(
            self.with_raw(channel_map),
            certificates=self.certificates_for(channel_map),
            aircraft=self.aircraft,
            rate=self.grid_rate,
            system=self.system,
            address=self.address,
            keep_samples=self.native,
        )

    def with_raw(self, channel_map: ChannelMap) -> ChannelMap:
        """Return a map that keeps the raw channels wanted too."""
        return replace(channel_map, raw=(*channel_map.raw, *self.raw)) if self.raw else channel_map

    def certificates_for(self, channel_map: ChannelMap) -> Mapping[str, Certificate]:
        """Return the certificates in force with a map, which must have something to calibrate."""
        if self.override_source and not any(entry.calibration for entry in channel_map.entries):
            raise FlightError(
                f"the certificates of '{self.override_source}' cannot be applied: the channel map "
                f"'{channel_map.name}' calibrates no channel, its messages hold engineering "
                "units; leave out --calibration, or give a map of the raw volts with --map"
            )
        if self.certificates is not None:
            return self.certificates
        return load_certificates(channel_map.certificates) if channel_map.certificates else {}

    def applied_certificates(self, channel_map: ChannelMap | None) -> AppliedCertificates:
        """Return which certificates count, and which would by themselves; see `certificates_for`.

        The map is None where columns are read that were calibrated before.
        """
        used = {} if channel_map is None else self.certificates_for(channel_map)
        return AppliedCertificates(
            applied=used, override_source=self.override_source, recorded=self.recorded
        )


def find_aircraft(path: Path, given: Aircraft | NameOrPath | None = None) -> Aircraft | None:
    """Return the aircraft that is given, else the copy in the flight's folder; None for neither."""
    if given is None and path.is_dir():
        copy = FlightFolder(path=path).aircraft_file
        given = copy if path_lexists(copy) else None
    return load_aircraft(given) if isinstance(given, (str, Path)) else given


def assumed_aircraft_text(flight: str, card: FlightInfo | None) -> str:
    """Return that a flight without an aircraft file is taken for the usual aircraft's, in words.

    Empty where its card names that aircraft.
    """
    if card is not None and card.aircraft.lower() == DEFAULT_AIRCRAFT:
        return ""
    return (
        f"no aircraft file given and none in '{flight}': using geometry, mass, inertia and "
        f"limits of the {DEFAULT_AIRCRAFT.upper()}; name the file of the flown aircraft "
        "(--aircraft FILE)"
    )
