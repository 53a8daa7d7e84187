"""Tables of named fields over time, as every reader of a foreign log gives them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from gsapp.flight.events import Event
from gsapp.quantities import BoolArray, FloatArray


class LazyFields(Mapping[str, FloatArray]):
    """Fields of a message, each loaded when it is first asked for: most of a log never is."""

    def __init__(self, names: Iterable[str], load: Callable[[str], FloatArray]) -> None:
        self._load = load
        self._loaded: dict[str, FloatArray | None] = dict.fromkeys(names)

    def __getitem__(self, name: str) -> FloatArray:
        values = self._loaded[name]
        if values is None:
            values = self._loaded[name] = self._load(name)
        return values

    def __iter__(self) -> Iterator[str]:
        return iter(self._loaded)

    def __len__(self) -> int:
        return len(self._loaded)


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
    by_order: bool = False
    """Whether the times follow from where the samples stand in the log."""
    remark: str = ""
    """What was done about its times, in words; empty for nothing."""

    def where(self, rows: BoolArray) -> LogTable:
        """Return the rows where `rows`, shape (n,), is true."""
        return LogTable(
            times=self.times[rows],
            fields=LazyFields(self.fields, lambda name: self.fields[name][rows]),
            units=self.units,
            by_order=self.by_order,
            remark=self.remark,
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
    vehicle: str = ""
    """What it flew on, in words, where that is no airplane; empty for one, or if unknown."""

    @property
    def messages(self) -> tuple[str, ...]:
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


def gather_records(
    data: bytes, places: Sequence[int] | npt.NDArray[np.int64], dtype: np.dtype[Any]
) -> npt.NDArray[Any]:
    """Return what begins at some bytes of a file, shape (n,); all of it must lie within."""
    opaque = np.dtype(f"V{dtype.itemsize}")
    every = np.ndarray(max(len(data) - dtype.itemsize + 1, 0), opaque, data, strides=(1,))
    return every[np.asarray(places, dtype=np.int64)].view(dtype)
