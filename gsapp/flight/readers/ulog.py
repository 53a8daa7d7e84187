"""PX4's on-board log, ``.ulg``, read by pyulog where it is installed."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Collection
from pathlib import Path
from typing import Any

import numpy as np

from gsapp.flight.events import Event
from gsapp.flight.readers.log_table import Log, LogTable, clean_clock
from gsapp.foundation import FlightError

_MAGIC = b"ULog\x01\x12\x35"


def read_ulog(path: Path | str, wanted: Collection[str] | None = None) -> Log:
    """Read a PX4 ``.ulg`` log.

    Parameters
    ----------
    path : Path or str
        The file. A torn end and damaged stretches are passed over and remarked on.
    wanted : collection of str, optional
        Names of the topics to decode; all if left out.

    Returns
    -------
    Log
        One table for each topic and instance. Elements of array fields are fields of their own,
        named ``gyro_rad[0]`` and so on.

    Raises
    ------
    FlightError
        If pyulog is not installed, the file cannot be read, or it is not a ULog.
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
        raise FlightError(
            f"{file} does not begin as a PX4 .ulg log does; download it again, or name another file"
        )
    parsed, said = _parse(file, wanted)
    remarks: list[str] = []
    if parsed.file_corruption or "corruption" in said.casefold():
        remarks.append(f"parts of {file.name} were damaged and are left out")
    dropouts = [int(dropout.duration) for dropout in parsed.dropouts]
    if dropouts:
        remarks.append(
            f"the logger of {file.name} dropped out {len(dropouts)} times, "
            f"{sum(dropouts) / 1000.0:.1f} s in all"
        )
    tables: dict[tuple[str, str], LogTable] = {}
    for topic in parsed.data_list:
        stamps = topic.data.get("timestamp")
        if stamps is None or not len(stamps):
            continue
        times = stamps.astype(np.float64) * 1e-6
        good = clean_clock(times)
        if not good.all():
            remarks.append(
                f"{int(good.size - good.sum())} samples of {topic.name}[{topic.multi_id}] have a "
                "time that cannot be; left out"
            )
        fields = {
            name: values[good].astype(np.float64)
            for name, values in topic.data.items()
            if values.dtype.kind in "fiub" and name != "timestamp"
        }
        tables[topic.name, str(topic.multi_id)] = LogTable(times=times[good], fields=fields)
    events = tuple(
        Event(kind="status", text=str(message.message), time=message.timestamp * 1e-6)
        for message in parsed.logged_messages
    )
    return Log(path=file, tables=tables, events=events, remarks=tuple(remarks))


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
        with contextlib.redirect_stdout(said):
            parsed = ULog(str(file), None if wanted is None else sorted(wanted))
    except ULogException as error:
        raise FlightError(
            f"{file} cannot be read as a PX4 .ulg log ({error}); download it again"
        ) from error
    except Exception as error:
        # pyulog lets whatever a damaged definition provokes pass through.
        raise FlightError(
            f"{file} is damaged where its messages are defined ({type(error).__name__}: {error}), "
            "so that nothing can be read; download it again"
        ) from error
    return parsed, said.getvalue()
