"""A flight in engineering units, kept beside its raw files so that it opens at once.

The cache is never the truth: its key is a hash of everything that shapes the numbers (raw bytes,
map, certificates, aircraft, rate, and the code that decodes), and whatever does not fit, or is
damaged, is built again. Plain arrays and JSON, no pickle.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from gsapp.decoding.decoder import ChannelSource
from gsapp.flight.atomic_files import atomic_flight_file
from gsapp.flight.events import Event
from gsapp.flight.flight import FrameCounts
from gsapp.flight.info import current_versions
from gsapp.flight.onboard_log.log_state import OnboardLogState
from gsapp.foundation import GroundStationError
from gsapp.quantities import Block

_NAME = "engineering.npz"
_CHUNK_BYTES = 1 << 20


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DecodedFlight:
    """What comes of reading raw files or a log; see `gsapp.flight.Flight`."""

    block: Block
    sources: Mapping[str, ChannelSource]
    frames: FrameCounts | None = None
    vehicle_messages: tuple[Event, ...] = ()
    remarks: tuple[str, ...] = field(default=())
    onboard: OnboardLogState | None = None


def cache_key(files: Iterable[Path], settings: Mapping[str, Any]) -> str:
    """Return a key that changes with any byte, setting or line of code behind the numbers."""
    digest = hashlib.blake2b(digest_size=20)
    for file in files:
        digest.update(f"\0{file.name}\0".encode())
        with file.open("rb") as stream:
            while piece := stream.read(_CHUNK_BYTES):
                digest.update(piece)
    digest.update(json.dumps([dict(settings), current_versions()], sort_keys=True).encode())
    digest.update(_code_hash())
    return digest.hexdigest()


@cache
def _code_hash() -> bytes:
    """Return a hash of the program's own modules that shape the numbers, where they are files."""
    import calibration
    import gsapp.decoding
    import gsapp.dynamics  # the atmosphere, of which air data are made
    import gsapp.flight
    import gsapp.quantities

    digest = hashlib.blake2b(digest_size=20)
    packages = (gsapp.quantities, calibration, gsapp.dynamics, gsapp.decoding, gsapp.flight)
    for package in packages:
        for folder in package.__path__:
            for file in sorted(Path(folder).rglob("*.py")):
                digest.update(file.read_bytes())
    return digest.digest()


def load_cached(folder: Path, key: str) -> DecodedFlight | None:
    """Return what is cached under a key; None if there is nothing, something else, or damage."""
    try:
        with np.load(folder / _NAME, allow_pickle=False) as archive:
            content = json.loads(str(archive["content"]))
            if content["key"] != key:
                return None
            return DecodedFlight(
                block=Block(
                    channels=tuple(content["channels"]),
                    times=archive["times"],
                    values=archive["values"],
                ),
                sources={
                    name: ChannelSource(**source) for name, source in content["sources"].items()
                },
                frames=FrameCounts(**content["frames"]) if content["frames"] else None,
                vehicle_messages=tuple(Event.from_json(event) for event in content["said"]),
                remarks=tuple(content["remarks"]),
                onboard=OnboardLogState.from_json(content["onboard"])
                if content["onboard"]
                else None,
            )
    except Exception:
        # A damaged archive makes zipfile, NumPy and JSON raise whatever they meet.
        return None


def store_cached(folder: Path, key: str, decoded: DecodedFlight) -> None:
    """Cache a flight. Where that cannot be done it is left undone: nothing is lost."""
    content = {
        "key": key,
        "channels": decoded.block.channels,
        "sources": {name: asdict(source) for name, source in decoded.sources.items()},
        "frames": asdict(decoded.frames) if decoded.frames else None,
        "said": [event.to_json() for event in decoded.vehicle_messages],
        "remarks": decoded.remarks,
        "onboard": decoded.onboard.to_json() if decoded.onboard else None,
    }
    with (
        contextlib.suppress(GroundStationError, OSError),
        atomic_flight_file(folder / _NAME) as temporary,
        temporary.open("wb") as stream,
    ):
        np.savez(
            stream,
            times=decoded.block.times,
            values=decoded.block.values,
            content=np.array(json.dumps(content)),
        )
