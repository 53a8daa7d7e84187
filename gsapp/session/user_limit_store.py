"""Limits that the user typed: a limits file of the user's own, which counts in every flight."""

from __future__ import annotations

import contextlib
import logging
import os
from collections.abc import Mapping
from pathlib import Path

from gsapp.foundation import FileProblemsError, FlightError, write_toml
from gsapp.foundation.files import file_stamp
from gsapp.quantities import channel, from_si
from gsapp.session.limits import LimitBands, LimitEntry, load_limits

log = logging.getLogger(__name__)

_KEYS = ("low_warning", "low_caution", "high_caution", "high_warning")
_BAND_FIELDS = ("warning_low", "caution_low", "caution_high", "warning_high")


class UserLimitStore:
    """Typed limits by channel, kept in a file that several windows may share.

    Attributes
    ----------
    error_text : str
        Why the file could not be used; empty if it could. It is then kept under another name.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self.error_text = ""
        self._entries: dict[str, LimitEntry] = {}
        self._stamp = file_stamp(self._path)
        # Unlike that of a path, it answers in a folder that nobody may look into, too.
        if os.access(path, os.F_OK):
            self._read()

    def refresh(self) -> bool:
        """Take in what another window has typed since; return whether there is anything.

        A file that cannot be read changes nothing: what was known still counts.
        """
        stamp = file_stamp(self._path)
        if stamp == self._stamp:
            return False
        self._stamp = stamp
        if stamp is None:
            found: dict[str, LimitEntry] = {}
        else:
            try:
                found = _entries(self._path)
            except FileProblemsError as error:
                log.warning("typed limits not taken in: %s", error)
                return False
        changed = found != self._entries
        self._entries = found
        return changed

    def _read(self) -> None:
        try:
            self._entries = _entries(self._path)
        except FileProblemsError as error:
            kept = self._path.with_suffix(".damaged.toml")
            with contextlib.suppress(OSError):
                self._path.replace(kept)
            log.warning("typed limits not used: %s", error)
            self.error_text = (
                f"The limits typed before could not be read ({error.problems[0]}): using those "
                f"of the aircraft; the old file is {kept.name}."
            )

    @property
    def limits(self) -> Mapping[str, LimitBands]:
        return {name: _bands(entry) for name, entry in self._entries.items()}

    def write(self, channel_id: str, bands: LimitBands | None, system: str) -> None:
        """Keep the limits of a channel, or forget them; those of others stay as they are there.

        Parameters
        ----------
        bands : LimitBands or None
            SI; None forgets what was typed, and limits that are all None switch them off.

        Raises
        ------
        FlightError
            If the file cannot be written; the limits are as before then.
        """
        self.refresh()
        entries = dict(self._entries)
        entries.pop(channel_id, None)
        if bands is not None:
            entries[channel_id] = _entry(channel_id, bands, system)
        content = [
            entry.model_dump(exclude_defaults=True, exclude_none=True) for entry in entries.values()
        ]
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            write_toml(self._path, {"limits": content})
        except OSError as error:
            raise FlightError(
                f"the limits cannot be written to {self._path} ({error.strerror}); they are "
                "unchanged"
            ) from error
        self._entries = entries
        self._stamp = file_stamp(self._path)


def _entries(path: Path) -> dict[str, LimitEntry]:
    return {entry.channel: entry for entry in load_limits(path).limits}


def _bands(entry: LimitEntry) -> LimitBands:
    values = (entry.value(key) for key in _KEYS)
    return LimitBands(**dict(zip(_BAND_FIELDS, values, strict=True)))


def _entry(channel_id: str, bands: LimitBands, system: str) -> LimitEntry:
    spec = channel(channel_id)
    unit = spec.display_unit(system)
    given = {
        key: f"{from_si(value, unit, spec.quantity):.10g} {unit}".rstrip()
        for key, name in zip(_KEYS, _BAND_FIELDS, strict=True)
        if (value := getattr(bands, name)) is not None
    }
    return LimitEntry.model_validate({"channel": channel_id, "off": not given, **given})
