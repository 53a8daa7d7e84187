"""What every reader of a foreign log hands over: tables of named fields over time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import numpy.typing as npt

from gsapp.flight.events import Event
from gsapp.flight.settings import FLIGHT_DATA
from gsapp.flight.uniform_grid import median_step
from gsapp.quantities import FloatArray

BoolArray = npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LogTable:
    """All samples of one message (and instance) of a log."""

    times: FloatArray
    """Shape (n,). Seconds on the vehicle's clock, strictly increasing."""
    fields: Mapping[str, FloatArray]
    """Shape (n,) or (n, k). Numbers by field name, in the log's own units; array fields have k
    columns."""
    units: Mapping[str, str] = field(default_factory=dict)
    """Units that the log itself states; empty where it does not."""

    def where(self, rows: BoolArray) -> LogTable:
        """Return the rows where `rows`, shape (n,), is true."""
        return LogTable(
            times=self.times[rows],
            fields={name: values[rows] for name, values in self.fields.items()},
            units=self.units,
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ForeignLog:
    """A foreign log, read."""

    path: Path
    tables: Mapping[tuple[str, str], LogTable]
    """By message name and selector: the instance number as text, empty for the only one."""
    events: tuple[Event, ...] = ()
    """What the vehicle said."""
    remarks: tuple[str, ...] = ()
    """What was lost, in words."""

    @property
    def messages(self) -> tuple[str, ...]:
        """Return the names of the messages, sorted, each once."""
        return tuple(sorted({message for message, _ in self.tables}))

    def table(self, message: str, selector: str) -> LogTable | None:
        """Return the table of a message; an empty selector means the first instance.

        Logs from before instances were numbered call the second IMU ``IMU2``; it is found as
        instance 1.
        """
        exact = self.tables.get((message, selector))
        if exact is not None:
            return exact
        if selector in ("", "0"):
            alone = self.tables.get((message, "0" if selector == "" else ""))
            if alone is not None:
                return alone
        if selector.isdigit() and int(selector) > 0:
            return self.tables.get((f"{message}{int(selector) + 1}", ""))
        return None


def find_valid_times(times: FloatArray) -> BoolArray:
    """Return which samples have a time that can be true.

    A damaged stamp stands far from those of its neighbors; what then still repeats or goes back
    is dropped too, so that the rest is strictly increasing.

    Parameters
    ----------
    times : ndarray, shape (n,)
        s, in the order of the file.

    Returns
    -------
    ndarray of bool, shape (n,)
        True where the sample stays.
    """
    good = np.isfinite(times)
    if times.size > FLIGHT_DATA.clock_neighbors:
        reach = FLIGHT_DATA.clock_neighbors // 2
        padded = np.concatenate((times[:1].repeat(reach), times, times[-1:].repeat(reach)))
        # Repeating the ends would let a damaged first or last stamp vouch for itself.
        padded[:reach] = times[1 : reach + 1]
        padded[-reach:] = times[-reach - 1 : -1]
        windows = np.lib.stride_tricks.sliding_window_view(padded, FLIGHT_DATA.clock_neighbors)
        center = np.median(windows, axis=1)
        limit = max(FLIGHT_DATA.max_clock_jump, 10.0 * abs(median_step(times)))
        good &= np.abs(times - center) <= limit
    kept = np.where(good, times, -np.inf)
    before = np.concatenate(([-np.inf], np.maximum.accumulate(kept)[:-1]))
    result: BoolArray = good & (times > before)
    return result
