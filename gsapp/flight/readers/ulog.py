"""PX4's on-board log, ``.ulg``, read by pyulog where it is installed."""

from __future__ import annotations

import contextlib
import io
import re
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from gsapp.decoding.flight_modes import px4_state
from gsapp.flight.events import Event
from gsapp.flight.parameter_events import parameter_events
from gsapp.flight.readers.log_mapping import ForeignLog, LogTable, find_valid_times
from gsapp.foundation import FlightError
from gsapp.quantities import BoolArray, FloatArray

_MAGIC = b"ULog\x01\x12\x35"
_STATUS = "vehicle_status"
"""Topic that holds the flight mode."""
_HEADER = 16
"""Bytes before the first message."""
_ELEMENT = re.compile(r"(?P<name>.+)\[(?P<index>\d+)\]")


def read_ulog(path: Path | str, wanted: Collection[str] | None = None) -> ForeignLog:
    """Read a PX4 ``.ulg`` log: one table for each topic (by default all) and instance.

    A torn end and damaged stretches are passed over and remarked on.
    """
    file = Path(path)
    try:
        with file.open("rb") as stream:
            magic = stream.read(len(_MAGIC))
    except OSError as error:
        raise FlightError(
            f"{file} cannot be read ({error.strerror}); check the path and the permissions"
        ) from error
    if magic != _MAGIC:
        raise FlightError(f"{file} is not a PX4 .ulg log; download it again, or name another file")
    parsed, said = _parse(file, wanted)
    remarks: list[str] = []
    left, longest = _cut_off(file)
    # A length that was damaged ends the log as a torn end does, and takes more than a message.
    if parsed.file_corruption or "corruption" in said.casefold() or left > longest:
        remarks.append(f"parts of {file.name} were damaged and skipped")
    elif left:
        remarks.append(f"the last message of {file.name} is incomplete and was skipped")
    dropouts = [int(dropout.duration) for dropout in parsed.dropouts]
    if dropouts:
        often = "once" if len(dropouts) == 1 else f"{len(dropouts)} times"
        remarks.append(
            f"the logger of {file.name} dropped out {often}, {sum(dropouts) / 1000.0:.1f} s in all"
        )
    tables: dict[tuple[str, str], LogTable] = {}
    for topic in parsed.data_list:
        stamps = topic.data.get("timestamp")
        if stamps is None or not len(stamps):
            continue
        times = stamps.astype(np.float64) * 1e-6
        # PX4 stamps 0 on a topic that was never published; its clock may count from 1970.
        good = find_valid_times(times) & (stamps > 0)
        dropped = int(good.size - good.sum())
        if dropped:
            counted = "1 sample" if dropped == 1 else f"{dropped} samples"
            remarks.append(
                f"skipped for impossible times: {counted} of {topic.name}[{topic.multi_id}]"
            )
        tables[topic.name, str(topic.multi_id)] = LogTable(
            times=times[good], fields=_fields(topic.data, good)
        )
    events = tuple(
        Event(kind="status", text=str(message.message), time=message.timestamp * 1e-6)
        for message in parsed.logged_messages
        if message.timestamp > 0
    )
    return ForeignLog(
        path=file,
        tables=tables,
        events=(*events, *_modes(tables), *_parameters(parsed)),
        remarks=tuple(remarks),
    )


def _modes(tables: Mapping[tuple[str, str], LogTable]) -> Iterator[Event]:
    """Yield the changes of the navigation state."""
    table = tables.get((_STATUS, "0"))
    states = None if table is None else table.fields.get("nav_state")
    if table is None or states is None:
        return
    changed = np.flatnonzero(np.diff(states, prepend=-1.0))
    for time, state in zip(table.times[changed].tolist(), states[changed].tolist(), strict=True):
        yield Event(kind="mode", text=f"Flight mode {px4_state(int(state))}", time=time)


def _parameters(parsed: Any) -> tuple[Event, ...]:
    start = float(parsed.start_timestamp) * 1e-6
    first = [(start, str(name), float(v)) for name, v in parsed.initial_parameters.items()]
    changes = [(int(time) * 1e-6, str(n), float(v)) for time, n, v in parsed.changed_parameters]
    return parameter_events([*first, *changes])


def _fields(data: Mapping[str, Any], good: BoolArray) -> dict[str, FloatArray]:
    """Gather the elements of arrays, which pyulog keeps as ``gyro_rad[0]`` and so on."""
    fields: dict[str, FloatArray] = {}
    elements: dict[str, dict[int, FloatArray]] = {}
    for name, values in data.items():
        if values.dtype.kind not in "fiub" or name == "timestamp":
            continue
        numbers = values[good].astype(np.float64)
        match = _ELEMENT.fullmatch(name)
        if match is None:
            fields[name] = numbers
        else:
            elements.setdefault(match["name"], {})[int(match["index"])] = numbers
    for name, found in elements.items():
        if sorted(found) == list(range(len(found))):
            fields[name] = np.column_stack([found[index] for index in range(len(found))])
    return fields


def _cut_off(file: Path) -> tuple[int, int]:
    """Return how many bytes stand at the end after the last whole message, and the longest one.

    A message is two bytes of length, one of its type, and so many bytes; pyulog passes over what
    is cut off without a word.
    """
    data = file.read_bytes()
    place, size, longest = _HEADER, len(data), 0
    while place + 2 < size:
        length = 3 + data[place] + (data[place + 1] << 8)
        if place + length > size:
            break
        longest = max(longest, length)
        place += length
    return size - place, longest


def _parse(file: Path, wanted: Collection[str] | None) -> tuple[Any, str]:
    """Return pyulog's result, and what it printed instead of raising."""
    try:
        from pyulog import ULog
        from pyulog.exceptions import ULogException
    except ImportError as error:
        raise FlightError(
            "reading .ulg logs needs pyulog, which is not installed; install it with "
            "'pip install gsapp-ground-station[ulog]'"
        ) from error
    said = io.StringIO()
    try:
        # Opened here: pyulog leaves a damaged file open, which Windows then neither renames nor
        # deletes.
        with contextlib.redirect_stdout(said), file.open("rb") as stream:
            parsed = ULog(stream, None if wanted is None else sorted({*wanted, _STATUS}))
    except ULogException as error:
        raise FlightError(
            f"{file} cannot be read as a PX4 .ulg log ({error}); download it again"
        ) from error
    except Exception as error:
        # pyulog lets whatever a damaged definition provokes pass through.
        raise FlightError(
            f"{file} is damaged where its messages are defined ({type(error).__name__}: "
            f"{error}); download it again"
        ) from error
    return parsed, said.getvalue()
