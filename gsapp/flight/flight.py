"""A flight, whatever file it came from."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gsapp.flight.certificates import (
    AppliedCertificates,
    calibration_remarks,
    count_samples_out_of_range,
    uncalibrated_channels,
)
from gsapp.flight.events import Event
from gsapp.flight.info import FlightInfo
from gsapp.flight.onboard_log.log_state import OnboardLogState
from gsapp.flight.uniform_grid import median_step
from gsapp.flight.writers import ColumnUnits
from gsapp.foundation.data_table import DataTable, import_notebook_package
from gsapp.quantities import Block, FloatArray, channel

if TYPE_CHECKING:
    import pandas
    import xarray

    from gsapp.decoding.decoder import ChannelSource


@dataclass(frozen=True, slots=True, kw_only=True)
class FrameCounts:
    """What became of the frames of a record."""

    good: int
    """Frames with a good checksum and a known id."""
    damaged: int
    """Pieces of bytes that belong to no whole frame."""
    unknown: int
    """Whole frames of an id outside the dialect, so that they could not be checked."""
    lost: int
    """Frames missing by their sequence numbers."""
    lines: int = 0
    """Lines of text that were read."""
    bad_lines: int = 0
    """Lines of text that were left out."""


@dataclass(frozen=True, slots=True, kw_only=True)
class OutOfRange:
    """Samples beyond what instruments were calibrated for."""

    counts: Mapping[str, int]
    """By channel; those of none are left out."""
    remarks: tuple[str, ...]
    """`Flight.calibration_remarks`."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Flight:
    """A whole flight in engineering units."""

    name: str
    """As the crew calls it; else the name of the file."""
    path: Path
    """The folder or file it was read from."""
    block: Block
    """All channels on one uniform grid. Pauses without any sample longer than
    `FLIGHT_DATA.max_filled_gap` are left out but for one missing row at either
    end."""
    sources: Mapping[str, ChannelSource]
    """Where each channel came from, and whether it was measured."""
    info: FlightInfo | None = None
    """From ``flight.toml``."""
    frames: FrameCounts | None = None
    """None where the flight was not recorded as frames."""
    events: tuple[Event, ...] = ()
    """Marks, notes and alarms, and what the vehicle said."""
    remarks: tuple[str, ...] = ()
    """What was lost or left out on reading, and how it was read, in words."""
    certificates: AppliedCertificates = field(default_factory=AppliedCertificates)
    """With which volts became engineering units."""
    onboard: OnboardLogState | None = None
    """What became of the on-board log; None where the flight has none, or only the live record was
    read."""
    native: bool = False
    """Whether `block` has the samples at their own times instead of a grid."""

    opened_with: Mapping[str, str] = field(default_factory=dict)
    """Aircraft, channel map and certificates in place of those of the flight, by setting."""
    out_of_range: OutOfRange | None = None
    """Counted when the samples were dropped (`without_samples`); None where they are there."""

    @property
    def uncalibrated_channels(self) -> tuple[str, ...]:
        return uncalibrated_channels(self.sources)

    @property
    def calibration_remarks(self) -> tuple[str, ...]:
        """Return what is to be said of the calibration behind the numbers; part of `remarks`."""
        if self.out_of_range is not None:
            return self.out_of_range.remarks
        return calibration_remarks(self.certificates, self.sources, self.block)

    def calibration_json(self) -> dict[str, Any]:
        """Return the certificates behind the numbers, and what lacks them, for programs.

        ``uncalibrated`` lists channels that had none, ``beyond`` counts the samples of channels
        outside the range that was calibrated.
        """
        counts = (
            count_samples_out_of_range(self.certificates, self.sources, self.block)
            if self.out_of_range is None
            else dict(self.out_of_range.counts)
        )
        return {
            **self.certificates.to_json(),
            "uncalibrated": list(self.uncalibrated_channels),
            "beyond": counts,
        }

    def without_samples(self) -> Flight:
        """Return what is known of the flight beside its samples and events."""
        counts = count_samples_out_of_range(self.certificates, self.sources, self.block)
        return replace(
            self,
            block=self.block.between(0.0, 0.0),
            events=(),
            out_of_range=OutOfRange(counts=counts, remarks=self.calibration_remarks),
        )

    @property
    def rate(self) -> float:
        """Return the samples per second of the grid; NaN for fewer than two samples, or no grid."""
        return math.nan if self.native else 1.0 / median_step(self.block.times)

    @property
    def duration(self) -> float:
        times = self.block.times
        return float(times[-1] - times[0]) if times.size else 0.0

    def to_numpy(self, channels: Sequence[str] | None = None, units: str = "us") -> FloatArray:
        """Return samples.

        Parameters
        ----------
        channels : sequence of str, optional
            Ids; all by default.
        units : {"us", "si", "base"}
            ``us``: ft/s, deg, g; ``si``: m/s, deg, g; ``base``: m/s, rad, m/s^2, as held inside.

        Returns
        -------
        ndarray, shape (n, n_channels)
            NaN where a sample is missing. ``block.times`` holds the times (s).
        """
        layout = self._layout(channels, units)
        return np.column_stack([np.empty((len(self.block), 0)), *self._columns(layout)])

    def to_dataframe(
        self, channels: Sequence[str] | None = None, units: str = "us"
    ) -> pandas.DataFrame:
        """Return samples as a pandas data frame, its index the time (s).

        ``attrs["units"]`` holds the unit of each column. Parameters as `to_numpy`.
        """
        layout = self._layout(channels, units)
        columns = dict(zip(layout.channels, self._columns(layout), strict=True))
        return DataTable(
            columns={"time": self.block.times, **columns},
            units={"time": "s", **dict(zip(layout.channels, layout.units, strict=True))},
            index="time",
        ).to_dataframe()

    def to_xarray(self, channels: Sequence[str] | None = None, units: str = "us") -> xarray.Dataset:
        """Return samples as an xarray data set over ``time`` (s).

        Each variable has its unit and title in its attributes. Parameters as `to_numpy`.
        """
        layout = self._layout(channels, units)
        variables = {
            name: ("time", values, {"units": unit, "long_name": channel(name).title})
            for name, unit, values in zip(
                layout.channels, layout.units, self._columns(layout), strict=True
            )
        }
        time = ("time", self.block.times, {"units": "s", "long_name": "Flight time"})
        return import_notebook_package("xarray").Dataset(
            variables, coords={"time": time}, attrs={"flight": self.name}
        )

    def _layout(self, channels: Sequence[str] | None, units: str) -> ColumnUnits:
        return ColumnUnits.from_channels(
            self.block.channels if channels is None else channels, units.casefold()
        )

    def _columns(self, layout: ColumnUnits) -> list[FloatArray]:
        return [
            layout.convert_column(index, self.block[name])
            for index, name in enumerate(layout.channels)
        ]

    def __repr__(self) -> str:
        return f"<Flight {self._title}>"

    @property
    def _title(self) -> str:
        rate = f", {self.rate:.4g} Hz" if math.isfinite(self.rate) else ""
        return f"{self.name}: {self.duration:.1f} s{rate}, {len(self.block.channels)} channels"

    def _repr_html_(self) -> str:
        layout = self._layout(None, "us")
        samples = [values[np.isfinite(values)] for values in self._columns(layout)]
        table = DataTable(
            columns={
                "channel": layout.channels,
                "title": [channel(name).title for name in layout.channels],
                "unit": layout.units,
                "samples": [one.size for one in samples],
                "min": [float(one.min()) if one.size else None for one in samples],
                "max": [float(one.max()) if one.size else None for one in samples],
            }
        )
        return table.to_html(self._title, most=None)


def calibration_sentences(flights: Iterable[Flight]) -> tuple[str, ...]:
    """Return what is to be said of the calibration of each flight, with its name."""
    return tuple(
        f"{flight.name}: {text}" for flight in flights for text in flight.calibration_remarks
    )


def calibration_json(flights: Iterable[Flight]) -> list[dict[str, Any]]:
    """Return the calibration behind each flight's numbers, for programs."""
    return [{"flight": flight.name, **flight.calibration_json()} for flight in flights]
