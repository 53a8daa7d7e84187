"""Messages turned into numbers: fields, scale, unit, calibration.

A `Stream` says which numbers of one message of one sender become which channels. A `Converter`
does what they ask for with the samples of all of them at once.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from calibration import Certificate
from calibration.certificate import reference_ratio
from gsapp.decoding.channel_map import FieldRef, MapEntry, Selector
from gsapp.decoding.conversions import CONVERSIONS, Conversion
from gsapp.decoding.grid import Samples, columns_at
from gsapp.quantities import FloatArray, base_id, channel, to_si

_CIRCULAR = frozenset({"phi", "psi", "track", "longitude"})
_RAIL = 1e-3
_FACTOR, _OFFSET, _LOW, _HIGH, _MISSING_FROM = range(5)
_STEPWISE = frozenset({"rate_switch", "gear", "gps_satellites"})
Columns = Mapping[str, npt.NDArray[np.generic]]
BoolArray = npt.NDArray[np.bool_]


def number_of(columns: Columns, ref: FieldRef) -> npt.NDArray[np.generic]:
    """Return one number of every sample, shape (n,).

    An element of an array is found in a field of shape (n, k), or in one called ``name[index]``.

    Raises
    ------
    KeyError
        If there is no such field.
    """
    if ref.index is None:
        return columns[ref.field]
    if ref.field not in columns:
        return columns[f"{ref.field}[{ref.index}]"]
    return columns[ref.field][:, ref.index]


def linear_factors(entry: MapEntry) -> tuple[float, float]:
    """Return factor and offset from the raw number to SI (to V, where it is calibrated)."""
    key = "voltage" if entry.calibration else channel(entry.channel).quantity
    zero = to_si(0.0, entry.unit, key)
    factor = to_si(1.0, entry.unit, key) - zero
    return factor * entry.scale, factor * entry.offset + zero


@dataclass(frozen=True, slots=True, kw_only=True)
class Output:
    """One column that a stream yields.

    Attributes
    ----------
    channel : str
        Id.
    entry : MapEntry
        Where it comes from.
    calibrated : bool
        Whether a certificate turned volts into it.
    """

    channel: str
    entry: MapEntry
    calibrated: bool


class _Calibrations:
    """All certificates of one message at once: each step is one operation on a matrix."""

    def __init__(self, certificates: Sequence[Certificate]) -> None:
        degree = max(certificate.degree for certificate in certificates)
        self._coefficients = [
            np.array([(*c.si_coefficients, 0.0, 0.0, 0.0)[power] for c in certificates])
            for power in range(degree + 1)
        ]
        self._low = np.array([certificate.range[0] for certificate in certificates])
        self._high = np.array([certificate.range[1] for certificate in certificates])
        self._low_slope = np.array([certificate.end_slopes[0] for certificate in certificates])
        self._high_slope = np.array([certificate.end_slopes[1] for certificate in certificates])
        supplies = [
            certificate.excitation_voltage if certificate.ratiometric else None
            for certificate in certificates
        ]
        self._ratiometric = np.array([supply is not None for supply in supplies])
        self._any_ratiometric = bool(self._ratiometric.any())
        self._supply = np.array([supply or 1.0 for supply in supplies])

    def evaluate(
        self, volts: FloatArray, excitation: FloatArray | None
    ) -> tuple[FloatArray, BoolArray | None]:
        """Return SI values and where volts were outside what was calibrated, shape (n, m).

        None stands for nowhere.

        The same steps as `Certificate.evaluate`, so the same numbers to the last bit.
        """
        if excitation is not None and self._any_ratiometric:
            ratio = reference_ratio(self._supply, excitation[:, np.newaxis])
            volts = volts * np.where(self._ratiometric, ratio, 1.0)
        inside = np.minimum(np.maximum(volts, self._low), self._high)
        values: FloatArray = self._coefficients[-1]
        for coefficient in reversed(self._coefficients[:-1]):
            values = values * inside + coefficient
        if np.count_nonzero(volts == inside) == inside.size:
            return values, None
        beyond = volts - inside
        below = beyond < 0.0
        outside = below | (beyond > 0.0)
        if not outside.any():
            return values, None
        return values + beyond * np.where(below, self._low_slope, self._high_slope), outside


class Stream:
    """The channels that come from one message of one sender.

    Parameters
    ----------
    entries : sequence of MapEntry
        With the same message, selector and time.
    certificates : mapping of str to Certificate
        By channel. Without its certificate a calibrated entry yields volts only.
    vehicle_time : bool
        Whether its samples carry the vehicle's time; else they are timed by arrival.

    Attributes
    ----------
    outputs : tuple of Output
        Its channels, in order.
    wanted : tuple of FieldRef
        The numbers of the message that a `Converter` needs: one for each output, then all that
        conversions and flags of validity need.
    circular, stepwise : ndarray of bool
        Which of its channels go round, and which keep their former value.
    clipped : dict of str to int
        Samples outside calibration or at the end of the instrument's range, by channel.
    """

    def __init__(
        self,
        entries: Sequence[MapEntry],
        certificates: Mapping[str, Certificate],
        *,
        vehicle_time: bool,
    ) -> None:
        self.message = entries[0].message
        self.selector: Selector | None = entries[0].selector
        self.vehicle_time = vehicle_time
        outputs: list[Output] = []
        calibrated: list[tuple[int, Certificate]] = []
        for entry in entries:
            if entry.calibration is None:
                outputs.append(Output(channel=entry.channel, entry=entry, calibrated=False))
                continue
            certificate = certificates.get(entry.calibration)
            if certificate is not None:
                calibrated.append((len(outputs), certificate))
                outputs.append(Output(channel=entry.channel, entry=entry, calibrated=True))
            outputs.append(Output(channel=entry.volts_channel, entry=entry, calibrated=False))
        self.outputs = tuple(outputs)
        self.width = len(outputs)
        self.wanted = self._plan_numbers()
        self._calibrated = columns_at([place for place, _ in calibrated])
        self._calibrations = _Calibrations([each for _, each in calibrated]) if calibrated else None
        supply = [i for i, output in enumerate(outputs) if output.channel == "excitation"]
        self._supply = supply[0] if supply else None
        bases = [base_id(output.channel) for output in outputs]
        self.circular = np.array([base in _CIRCULAR for base in bases], dtype=bool)
        self.stepwise = np.array([base in _STEPWISE for base in bases], dtype=bool)
        self.clipped: dict[str, int] = {}

    @property
    def channels(self) -> tuple[str, ...]:
        """Return the channel of each column."""
        return tuple(output.channel for output in self.outputs)

    def numbers(self, columns: Columns, count: int) -> FloatArray:
        """Return the numbers wanted, shape (n, n_wanted).

        Parameters
        ----------
        columns : mapping
            Fields by name, each of shape (n,) or (n, k).
        count : int
            Number of samples n.
        """
        raw = np.empty((count, len(self.wanted)))
        for place, ref in enumerate(self.wanted):
            raw[:, place] = number_of(columns, ref)
        return raw

    def prepare(self, raw: FloatArray) -> None:
        """Put the results of conversions in place, and NaN where a flag says not valid."""
        for place, conversion, inputs in self._converted:
            # Contiguous, so that functions round alike however many samples there are.
            raw[:, place] = conversion.compute(
                tuple(np.ascontiguousarray(raw[:, each]) for each in inputs)
            )
        for place, flag in self._valid:
            raw[raw[:, flag] == 0.0, place] = np.nan

    def calibrate(self, values: FloatArray) -> BoolArray | None:
        """Turn volts into SI values; return where they were outside what was calibrated.

        None stands for nowhere.
        """
        if self._calibrations is None:
            return None
        supply = None if self._supply is None else values[:, self._supply]
        calibrated, beyond = self._calibrations.evaluate(values[:, self._calibrated], supply)
        values[:, self._calibrated] = calibrated
        if beyond is None:
            return None
        outside = np.zeros((len(values), self.width), dtype=bool)
        outside[:, self._calibrated] = beyond
        return outside

    def count_clipped(self, clipped: BoolArray) -> None:
        """Count samples outside calibration, or at the end of the instrument's range."""
        totals = clipped.sum(axis=0)
        for column in np.flatnonzero(totals).tolist():
            name = self.outputs[column].channel
            self.clipped[name] = self.clipped.get(name, 0) + int(totals[column])

    def _plan_numbers(self) -> tuple[FieldRef, ...]:
        """Decide which number stands where in the matrix that a `Converter` takes."""
        wanted = [output.entry.inputs[0] for output in self.outputs]
        self._converted: list[tuple[int, Conversion, range]] = []
        self._valid: list[tuple[int, int]] = []
        for place, output in enumerate(self.outputs):
            entry = output.entry
            if entry.convert is not None:
                inputs = range(len(wanted), len(wanted) + len(entry.inputs))
                self._converted.append((place, CONVERSIONS[entry.convert], inputs))
                wanted += entry.inputs
            if entry.valid:
                self._valid.append((place, len(wanted)))
                wanted.append(FieldRef(field=entry.valid))
        self.prepared = bool(self._converted or self._valid)
        return tuple(wanted)


class Converter:
    """Turns the numbers of all streams into SI values at once.

    A step on a matrix costs about the same for one message as for fifty. So what every channel
    needs is done for all streams in one step, on a matrix with a row for each sample and the
    parameters of its stream in every row; only what few of them need is done stream by stream.

    Parameters
    ----------
    streams : sequence of Stream
        The streams, by their numbers.
    ranges : mapping of str to (float, float)
        What instruments can show, SI, by channel. Samples at the ends are counted as clipped: a
        converter rounds the rail to one of its counts, so a thousandth of the range before the
        end counts as the end.
    """

    def __init__(
        self, streams: Sequence[Stream], ranges: Mapping[str, tuple[float, float]]
    ) -> None:
        self._streams = tuple(streams)
        width = max((stream.width for stream in streams), default=0)
        most = max((len(o.entry.missing) for s in streams for o in s.outputs), default=0)
        # Factor, offset, low and high end of the range, raw values that mean missing.
        table = np.full((len(streams), _MISSING_FROM + most, width), np.nan)
        table[:, _FACTOR], table[:, _OFFSET] = 1.0, 0.0
        table[:, _LOW], table[:, _HIGH] = -np.inf, np.inf
        for number, stream in enumerate(streams):
            for place, output in enumerate(stream.outputs):
                column = table[number, :, place]
                column[_FACTOR], column[_OFFSET] = linear_factors(output.entry)
                missing = output.entry.missing
                column[_MISSING_FROM : _MISSING_FROM + len(missing)] = missing
                if output.channel in ranges:
                    bottom, top = ranges[output.channel]
                    margin = _RAIL * (top - bottom if np.isfinite(top - bottom) else abs(top))
                    column[_LOW], column[_HIGH] = bottom + margin, top - margin
        self._table = table
        self._any_missing = most > 0
        self._any_range = bool(np.isfinite(table[:, _LOW : _HIGH + 1]).any())

    def convert(self, batch: Sequence[Samples], raw: FloatArray) -> FloatArray:
        """Return SI values of samples.

        Parameters
        ----------
        batch : sequence of Samples
            Whose rows are whose.
        raw : ndarray, shape (n, n_wanted)
            The numbers that each stream wants, zeros beyond them. Written to.

        Returns
        -------
        ndarray, shape (n, width)
            As wide as the widest of these streams, zeros beyond the channels of a stream. NaN
            where the vehicle says that it does not know. It may be part of `raw`.
        """
        owners: list[int] = []
        width = 0
        for number, start, stop, _, _ in batch:
            stream = self._streams[number]
            owners += [number] * (stop - start)
            width = max(width, stream.width)
            if stream.prepared:
                stream.prepare(raw[start:stop])
        values = raw[:, :width]
        parameters = self._table[:, :, :width].take(owners, axis=0)
        if self._any_missing:
            unknown = values[:, np.newaxis] == parameters[:, _MISSING_FROM:]
            if np.count_nonzero(unknown):
                values[unknown.any(axis=1)] = np.nan
        values *= parameters[:, _FACTOR]
        values += parameters[:, _OFFSET]
        beyond: list[tuple[Samples, BoolArray]] = []
        for samples in batch:
            outside = self._streams[samples.stream].calibrate(values[samples.start : samples.stop])
            if outside is not None:
                beyond.append((samples, outside))
        finite = np.isfinite(values)
        if np.count_nonzero(finite) < finite.size:
            values[~finite] = np.nan
        if beyond or self._any_range:
            self._count_clipped(batch, values, parameters, beyond)
        return values

    def _count_clipped(
        self,
        batch: Sequence[Samples],
        values: FloatArray,
        parameters: FloatArray,
        beyond: Sequence[tuple[Samples, BoolArray]],
    ) -> None:
        clipped = (values <= parameters[:, _LOW]) | (values >= parameters[:, _HIGH])
        for (_, start, stop, _, _), outside in beyond:
            width = outside.shape[1]
            clipped[start:stop, :width] |= outside & ~np.isnan(values[start:stop, :width])
        if np.count_nonzero(clipped):
            for number, start, stop, _, _ in batch:
                stream = self._streams[number]
                stream.count_clipped(clipped[start:stop, : stream.width])
