"""Files with which a flight is read, given to those who copy it: aircraft, map, certificates."""

from __future__ import annotations

import json
import logging
import re
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from calibration import load_certificates
from gsapp.aircraft import load_aircraft
from gsapp.decoding.channel_map import load_channel_map
from gsapp.flight.atomic_files import write_flight_file
from gsapp.flight.file_names import CARDS_FILE, FENCE_FILE, LIMITS_FILE
from gsapp.flight.folder import FlightFolder
from gsapp.foundation import GroundStationError, LinkError
from gsapp.telemetry.link_registry import kind_of, parse_link
from gsapp.telemetry.settings import TELEMETRY
from gsapp.telemetry.signing import read_signing_key
from gsapp.telemetry.sources import open_source

log = logging.getLogger(__name__)

_AIRCRAFT, _MAP, _CERTIFICATES = "aircraft", "channel_map", "calibration"
_COPIED: Final = (CARDS_FILE, FENCE_FILE, LIMITS_FILE)
_NAME: Final = re.compile(rf"(?:{_AIRCRAFT}|{_MAP}|{_CERTIFICATES})/\w[\w .+-]{{0,80}}\.toml")

_UNSAFE: Final = re.compile(r"^\W|[^\w .+-]")


def encode_files(folder: Path) -> bytes:
    """Return the files of a flight as one JSON object, text by name; empty where they are large."""
    flight = FlightFolder(path=folder)
    try:
        info = flight.info()
        names = ("", "") if info is None else (info.aircraft, info.channel_map)
        aircraft, channel_map = (_UNSAFE.sub("_", name) for name in names)
        paths = {
            f"{_AIRCRAFT}/{aircraft or _AIRCRAFT}.toml": flight.aircraft_file,
            f"{_MAP}/{channel_map or _MAP}.toml": flight.channel_map_file,
            **{f"{_CERTIFICATES}/{one.name}": one for one in flight.certificate_files()},
            **{name: folder / name for name in _COPIED},
        }
        texts = {
            name: path.read_text(encoding="utf-8") for name, path in paths.items() if path.is_file()
        }
    except (OSError, ValueError, GroundStationError) as error:
        log.warning("files of the flight are not shared: %s", error)
        texts = {}
    content = json.dumps(texts).encode()
    return content if len(content) <= TELEMETRY.max_files_bytes else b"{}"


def decode_files(content: bytes) -> dict[str, str]:
    """Return the files of another recorder, but for those that belong to no flight.

    Raise ValueError where they are damaged.
    """
    texts = json.loads(content)
    if not isinstance(texts, dict):
        raise ValueError("the files of the flight are damaged")
    return {
        name: text
        for name, text in texts.items()
        if isinstance(text, str) and (name in _COPIED or _NAME.fullmatch(name))
    }


@dataclass(frozen=True, slots=True, kw_only=True)
class SharedFiles:
    """Files of a flight that is copied, in a temporary folder; None for what it has not."""

    aircraft: Path | None = None
    channel_map: Path | None = None
    calibration: Path | None = None
    others: Mapping[str, str] | None = None  # Text of others, by their name in a flight folder.

    def store_others(self, folder: FlightFolder) -> None:
        """Write the others into a flight folder that does not have them."""
        for name, text in (self.others or {}).items():
            if not (folder.path / name).exists():
                write_flight_file(folder.path / name, text)


@contextmanager
def shared_files(
    link: str, key_file: str, folder: Path, tell: Callable[[str], object]
) -> Iterator[SharedFiles]:
    """Fetch the files of the flight that a link copies; nothing where it copies none.

    `tell` takes a sentence where they cannot be had; a folder with a flight in it has its own.
    """
    address = parse_link(link)
    if not kind_of(address).is_copy or FlightFolder(path=folder).info_file.exists():
        yield SharedFiles()
        return
    with tempfile.TemporaryDirectory() as temporary:
        place, texts = Path(temporary), {}
        try:
            texts = _fetch(link, read_signing_key(key_file) if key_file else b"")
            found = _unpack(place, texts)
        except (GroundStationError, OSError) as error:
            tell(f"The aircraft file and channel map of the flight were not copied: {error}")
            found = SharedFiles()
        yield found


def _fetch(link: str, key: bytes) -> dict[str, str]:
    source = open_source(link)
    source.prepare(0, key)
    try:
        source.open()
        deadline = time.monotonic() + TELEMETRY.copy_timeout
        while source.files is None:
            source.read(TELEMETRY.read_timeout)
            if time.monotonic() > deadline or not source.connected:
                raise LinkError(source.state)
        return source.files
    finally:
        source.close()


def _unpack(place: Path, texts: Mapping[str, str]) -> SharedFiles:
    """Write files below a folder, and see that they can be used."""
    for name, text in texts.items():
        path = place / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8")
    aircraft, channel_map = (
        next(iter(sorted((place / name).glob("*.toml"))), None) for name in (_AIRCRAFT, _MAP)
    )
    calibration = place / _CERTIFICATES if (place / _CERTIFICATES).is_dir() else None
    if aircraft is not None:
        load_aircraft(aircraft)
    if channel_map is not None:
        load_channel_map(channel_map)
    if calibration is not None:
        load_certificates(calibration)
    return SharedFiles(
        aircraft=aircraft, channel_map=channel_map, calibration=calibration,
        others={name: texts[name] for name in _COPIED if name in texts},
    )  # fmt: skip
