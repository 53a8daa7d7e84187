"""The journal of a calibration: every step as one line of JSON, on the disk before it counts.

A file that a power failure left with a torn last line is read up to there, and goes on from
there. Damage elsewhere ends what is read: a step may only count if all before it do.
"""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from datetime import datetime
from pathlib import Path
from types import MappingProxyType
from typing import Any

from calibration.plan import CalibrationPlan, InstrumentPlan
from calibration.points import CalibrationError
from gsapp.foundation import write_atomically
from gsapp.foundation.files import flush_to_disk


@dataclass(frozen=True, slots=True, kw_only=True)
class JournalStep:
    """Something that was done."""

    kind: str
    """``begin``, ``sign``, ``point``, ``accept`` ..."""
    channel: str = ""
    """The instrument it concerns; empty for the calibration as a whole."""
    stamp: datetime
    """When, to the second."""
    data: Mapping[str, Any] = field(default_factory=dict)
    """What belongs to it, of types that JSON has."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "stamp", self.stamp.replace(microsecond=0))
        object.__setattr__(self, "data", MappingProxyType(dict(self.data)))


class Journal:
    """The file that steps are appended to."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def append(self, step: JournalStep) -> None:
        """Write a step and see it onto the disk."""
        content = {
            "step": step.kind,
            "channel": step.channel,
            "stamp": step.stamp.isoformat(),
            **step.data,
        }
        line = json.dumps(content, ensure_ascii=False, allow_nan=False).encode() + b"\n"
        try:
            self._append(line)
        except OSError as error:
            raise CalibrationError(
                f"the step cannot be written to {self.path} ({error.strerror}); check disk "
                "space and permissions, then repeat"
            ) from error

    def _append(self, line: bytes) -> None:
        self.path.parent.mkdir(parents=True, exist_ok=True)
        with self.path.open("ab") as stream:
            end = stream.seek(0, os.SEEK_END)
            try:
                stream.write(line)
                stream.flush()
                flush_to_disk(stream.fileno())
            except OSError:
                # Half a line would spoil the next one.
                with contextlib.suppress(OSError):
                    os.ftruncate(stream.fileno(), end)
                raise

    def read(self) -> tuple[JournalStep, ...]:
        """Return the steps, as far as the file is good."""
        return self._read()[0]

    def recover(self) -> tuple[JournalStep, ...]:
        """Return the steps, and make the file ready to go on after the last good one.

        Where more than that is in the file, it is kept whole beside it as ``.damaged``.
        """
        steps, data, good = self._read()
        if good < len(data):
            write_atomically(self.path.with_name(f"{self.path.name}.damaged"), data)
            write_atomically(self.path, data[:good])
        return steps

    def _read(self) -> tuple[tuple[JournalStep, ...], bytes, int]:
        """Return the steps, the bytes of the file, and how many of them the steps take."""
        try:
            data = self.path.read_bytes()
        except FileNotFoundError:
            return (), b"", 0
        except OSError as error:
            raise CalibrationError(
                f"{self.path} cannot be read ({error.strerror}); check its permissions"
            ) from error
        steps: list[JournalStep] = []
        good = 0
        for line in data.splitlines(keepends=True):
            step = _parse(line) if line.endswith(b"\n") else None
            if step is None:
                break
            steps.append(step)
            good += len(line)
        return tuple(steps), data, good

    def set_aside(self) -> Path | None:
        """Move a former journal out of the way, under the time of its beginning; keep it."""
        if not self.path.exists():
            return None
        steps = self.read()
        when = steps[0].stamp.strftime("%Y-%m-%dT%H%M%S") if steps else "damaged"
        kept = self.path.with_name(f"{self.path.stem}-{when}{self.path.suffix}")
        number = 2
        while kept.exists():
            kept = self.path.with_name(f"{self.path.stem}-{when}-{number}{self.path.suffix}")
            number += 1
        return self.path.rename(kept)


def _parse(line: bytes) -> JournalStep | None:
    """Return the step of a line; None where it holds none."""
    try:
        content = json.loads(line)
        kind, name = content.pop("step"), content.pop("channel")
        stamp = datetime.fromisoformat(content.pop("stamp"))
    except (ValueError, AttributeError, KeyError, TypeError, RecursionError):
        return None
    if not isinstance(kind, str) or not isinstance(name, str):
        return None
    return JournalStep(kind=kind, channel=name, stamp=stamp, data=content)


_TUPLES = ("settings", "check_settings", "travel")


def to_json_content(value: Any) -> Any:
    """Return a frozen record as tables, lists, texts and numbers."""
    if is_dataclass(value):
        return {one.name: to_json_content(getattr(value, one.name)) for one in fields(value)}
    if isinstance(value, Mapping):
        return {str(key): to_json_content(one) for key, one in value.items()}
    if isinstance(value, (tuple, list)):
        return [to_json_content(one) for one in value]
    return value


def plan_from_json(content: Mapping[str, Any]) -> CalibrationPlan:
    """Return the plan that a journal kept: it goes on by the plan that it was begun with."""
    instruments = tuple(_instrument(one) for one in content["instruments"])
    return CalibrationPlan(**{**content, "instruments": instruments})


def _instrument(content: Mapping[str, Any]) -> InstrumentPlan:
    tuples = {key: tuple(content[key]) for key in _TUPLES if content[key] is not None}
    return InstrumentPlan(**{**content, **tuples})
