"""One message of one sender, turned into numbers: fields, scale, unit, calibration."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from calibration import Certificate
from calibration.certificate import reference_ratio
from gsapp.decoding.channel_map import FieldRef, MapEntry, Selector
from gsapp.decoding.conversions import CONVERSIONS, Conversion
from gsapp.decoding.grid import columns_at
from gsapp.quantities import FloatArray, base_id, channel, to_si

_CIRCULAR = frozenset({"phi", "psi", "track", "longitude"})
_RAIL = 1e-3
_STEPWISE = frozenset({"rate_switch", "gear", "gps_satellites"})
Columns = Mapping[str, np.ndarray[tuple[int, ...], np.dtype[np.generic]]]
BoolArray = npt.NDArray[np.bool_]


def number_of(columns: Columns, ref: FieldRef) -> FloatArray:
    """Return one number of every sample, float64, shape (n,).

    An element of an array is found in a field of shape (n, k), or in one called ``name[index]``.

    Contiguous, so that functions round alike however many samples there are.

    Raises
    ------
    KeyError
        If there is no such field.
    """
    if ref.index is None:
        return np.ascontiguousarray(columns[ref.field], dtype=np.float64)
    names = getattr(columns, "dtype", None)
    if names is None and ref.field not in columns:
        return np.ascontiguousarray(columns[f"{ref.field}[{ref.index}]"], dtype=np.float64)
    return np.ascontiguousarray(columns[ref.field][:, ref.index], dtype=np.float64)


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
        inside = volts.clip(self._low, self._high)
        beyond = volts - inside
        below = beyond < 0.0
        outside = below | (beyond > 0.0)
        values: FloatArray = self._coefficients[-1]
        for coefficient in reversed(self._coefficients[:-1]):
            values = values * inside + coefficient
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
        Columns of `convert`, in order.
    circular, stepwise : ndarray of bool
        Which of them go round, and which keep their former value.
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
        factors = [linear_factors(output.entry) for output in outputs]
        self._factor = np.array([factor for factor, _ in factors])
        self._offset = np.array([offset for _, offset in factors])
        self._calibrated = columns_at([place for place, _ in calibrated])
        self._calibrations = _Calibrations([each for _, each in calibrated]) if calibrated else None
        self._plan_fields()
        supply = [i for i, output in enumerate(outputs) if output.channel == "excitation"]
        self._supply = supply[0] if supply else None
        bases = [base_id(output.channel) for output in outputs]
        self.circular = np.array([base in _CIRCULAR for base in bases], dtype=bool)
        self.stepwise = np.array([base in _STEPWISE for base in bases], dtype=bool)
        self.clipped: dict[str, int] = {}
        self._ranges: tuple[FloatArray, FloatArray] | None = None

    @property
    def channels(self) -> tuple[str, ...]:
        """Return the channel of each column."""
        return tuple(output.channel for output in self.outputs)

    def watch_ranges(self, ranges: Mapping[str, tuple[float, float]]) -> None:
        """Count samples at the ends of these instruments' ranges, SI, by channel.

        A converter rounds the rail to one of its counts, so a thousandth of the range before
        the end counts as the end.
        """
        low = np.full(len(self.outputs), -np.inf)
        high = np.full(len(self.outputs), np.inf)
        for place, output in enumerate(self.outputs):
            if output.channel in ranges:
                bottom, top = ranges[output.channel]
                margin = _RAIL * (top - bottom if np.isfinite(top - bottom) else abs(top))
                low[place], high[place] = bottom + margin, top - margin
        if np.isfinite(low).any() or np.isfinite(high).any():
            self._ranges = (low, high)

    def convert(self, columns: Columns, count: int) -> FloatArray:
        """Return SI values of samples.

        Parameters
        ----------
        columns : structured ndarray or mapping
            Fields by name, each of shape (n,) or (n, k).
        count : int
            Number of samples n.

        Returns
        -------
        ndarray, shape (n, n_outputs)
            NaN where the vehicle says that it does not know.
        """
        values = self._fetch(columns, count)
        values *= self._factor
        values += self._offset
        outside: BoolArray | None = None
        if self._calibrations is not None:
            supply = None if self._supply is None else values[:, self._supply]
            calibrated, outside = self._calibrations.evaluate(values[:, self._calibrated], supply)
            values[:, self._calibrated] = calibrated
        finite = np.isfinite(values)
        if not finite.all():
            values[~finite] = np.nan
            if outside is not None:
                outside &= finite[:, self._calibrated]
        self._count_clipped(values, outside)
        return values

    def _fetch(self, columns: Columns, count: int) -> FloatArray:
        """Return the raw number of each output; NaN where it says that it is none."""
        raw = np.empty((count, len(self.outputs)))
        for name, elements, places in self._arrays:
            raw[:, places] = columns[name].take(elements, axis=1)
        for place, field in self._singles:
            raw[:, place] = columns[field]
        for place, conversion, refs in self._converted:
            raw[:, place] = conversion.compute(tuple(number_of(columns, ref) for ref in refs))
        if self._missing_places.size:
            unknown = raw.take(self._missing_places, axis=1) == self._missing_values
            if unknown.any():
                rows, found = np.nonzero(unknown)
                raw[rows, self._missing_places[found]] = np.nan
        for place, flag in self._valid:
            raw[number_of(columns, flag) == 0.0, place] = np.nan
        return raw

    def _count_clipped(self, values: FloatArray, outside: BoolArray | None) -> None:
        """Count samples outside calibration, or at the end of the instrument's range."""
        clipped: BoolArray | None = None
        if self._ranges is not None:
            clipped = (values <= self._ranges[0]) | (values >= self._ranges[1])
        if outside is not None:
            if clipped is None:
                clipped = np.zeros(values.shape, dtype=bool)
            clipped[:, self._calibrated] |= outside
        if clipped is None or not clipped.any():
            return
        totals = clipped.sum(axis=0)
        for column in np.flatnonzero(totals).tolist():
            name = self.outputs[column].channel
            self.clipped[name] = self.clipped.get(name, 0) + int(totals[column])

    def _plan_fields(self) -> None:
        """Gather where the raw numbers come from; elements of an array are fetched together."""
        gathered: dict[str, tuple[list[int], list[int]]] = {}
        self._singles: list[tuple[int, str]] = []
        self._converted: list[tuple[int, Conversion, tuple[FieldRef, ...]]] = []
        missing: list[tuple[int, float]] = []
        self._valid: list[tuple[int, FieldRef]] = []
        for place, output in enumerate(self.outputs):
            entry = output.entry
            ref = entry.inputs[0]
            if entry.convert is not None:
                self._converted.append((place, CONVERSIONS[entry.convert], entry.inputs))
            elif ref.index is None:
                self._singles.append((place, ref.field))
            else:
                elements, places = gathered.setdefault(ref.field, ([], []))
                elements.append(ref.index)
                places.append(place)
            missing += [(place, value) for value in entry.missing]
            if entry.valid:
                self._valid.append((place, FieldRef(field=entry.valid)))
        self._arrays = [
            (name, np.array(elements, dtype=np.intp), columns_at(places))
            for name, (elements, places) in gathered.items()
        ]
        self._missing_places = np.array([place for place, _ in missing], dtype=np.intp)
        self._missing_values = np.array([value for _, value in missing])
