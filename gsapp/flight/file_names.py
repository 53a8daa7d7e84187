"""How the files in a flight folder are called; what they are says `gsapp.flight.folder`."""

from __future__ import annotations

from typing import Final

FRAMES_FILE: Final = "raw.tlog"
LINES_FILE: Final = "raw.txt"
RESIDUE_FILE: Final = "residue.bin"
RAW_FILES: Final = (RESIDUE_FILE, LINES_FILE, FRAMES_FILE)
SENDERS_FILE: Final = "senders.txt"
"""Who sent the frames of ``raw.tlog``: beside it, since a frame names its sender without proof."""

INFO_FILE: Final = "flight.toml"
AIRCRAFT_FILE: Final = "aircraft.toml"
CHANNEL_MAP_FILE: Final = "channel_map.toml"
CALIBRATION_FOLDER: Final = "calibration"
LIMITS_FILE: Final = "limits.toml"
CARDS_FILE: Final = "cards.toml"
FENCE_FILE: Final = "fence.toml"
EVENTS_FILE: Final = "events.jsonl"
CACHE_FOLDER: Final = "cache"

# Of the recorder at work.
STATUS_FILE: Final = "recorder.json"
LOCK_FILE: Final = "recorder.lock"
STOP_FILE: Final = "recorder.stop"
LOG_FILE: Final = "recorder.log"
SEND_FILE: Final = "recorder.send"
SHARE_FILE: Final = "recorder.share"

FLIGHT_FOLDER_FILES: Final = frozenset(
    (
        *RAW_FILES,
        SENDERS_FILE,
        INFO_FILE,
        AIRCRAFT_FILE,
        CHANNEL_MAP_FILE,
        LIMITS_FILE,
        CARDS_FILE,
        FENCE_FILE,
        EVENTS_FILE,
        STATUS_FILE,
        LOCK_FILE,
        STOP_FILE,
        LOG_FILE,
        SEND_FILE,
        SHARE_FILE,
    )
)
"""All that have a meaning in a flight folder."""
