"""One message of one sender, turned into numbers: fields, scale, unit, calibration."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from calibration import Certificate
from calibration.certificate import reference_ratio
from gsapp.decoding.channel_map import FieldRef, MapEntry, Selector
from gsapp.decoding.conversions import CONVERSIONS
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

    def __init__(self, certificates: Sequence[Certificate], columns: Sequence[int]) -> None:
        self.columns = np.array(columns, dtype=np.intp)
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
        self.ratiometric = np.array([supply is not None for supply in supplies])
        self._supply = np.array([supply or 1.0 for supply in supplies])

    def evaluate(
        self, volts: FloatArray, excitation: FloatArray | None
    ) -> tuple[FloatArray, BoolArray]:
        """Return SI values and where volts were outside what was calibrated, shape (n, m).

        The same steps as `Certificate.evaluate`, so the same numbers to the last bit.
        """
        if excitation is not None and self.ratiometric.any():
            ratio = reference_ratio(self._supply, excitation[:, np.newaxis])
            volts = volts * np.where(self.ratiometric, ratio, 1.0)
        inside = np.clip(volts, self._low, self._high)
        beyond = volts - inside
        outside = (beyond < 0.0) | (beyond > 0.0)
        values: FloatArray = np.broadcast_to(self._coefficients[-1], inside.shape)
        for coefficient in reversed(self._coefficients[:-1]):
            values = values * inside + coefficient
        slope = np.where(beyond < 0.0, self._low_slope, self._high_slope)
        return values + beyond * slope, outside


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
        self._entries = tuple(entries)
        factors = [linear_factors(entry) for entry in entries]
        self._factor = np.array([factor for factor, _ in factors])
        self._offset = np.array([offset for _, offset in factors])
        self._arrays: list[tuple[str, list[int], list[int]]] = []
        self._singles: list[tuple[int, MapEntry]] = []
        missing = [(i, value) for i, entry in enumerate(entries) for value in entry.missing]
        self._missing_places = np.array([place for place, _ in missing], dtype=np.intp)
        self._missing_values = np.array([value for _, value in missing])
        self._valid = [(i, FieldRef(field=e.valid)) for i, e in enumerate(entries) if e.valid]
        self._plan_fields()
        outputs, picked, calibrated = [], [], []
        for index, entry in enumerate(entries):
            if entry.calibration is None:
                outputs.append(Output(channel=entry.channel, entry=entry, calibrated=False))
                picked.append(index)
                continue
            certificate = certificates.get(entry.calibration)
            if certificate is not None:
                calibrated.append((certificate, index, len(outputs)))
                outputs.append(Output(channel=entry.channel, entry=entry, calibrated=True))
                picked.append(index)
            outputs.append(Output(channel=entry.volts_channel, entry=entry, calibrated=False))
            picked.append(index)
        self.outputs = tuple(outputs)
        self._picked = np.array(picked, dtype=np.intp)
        self._calibrations = (
            _Calibrations([c for c, _, _ in calibrated], [i for _, i, _ in calibrated])
            if calibrated
            else None
        )
        self._calibrated_outputs = np.array([place for _, _, place in calibrated], dtype=np.intp)
        supply = [i for i, entry in enumerate(entries) if entry.channel == "excitation"]
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
        raw = np.empty((count, len(self._entries)))
        for name, elements, places in self._arrays:
            raw[:, places] = columns[name][:, elements]
        for place, entry in self._singles:
            if entry.convert is None:
                raw[:, place] = columns[entry.inputs[0].field]
            else:
                inputs = tuple(number_of(columns, ref) for ref in entry.inputs)
                raw[:, place] = CONVERSIONS[entry.convert].compute(inputs)
        if self._missing_places.size:
            unknown = raw[:, self._missing_places] == self._missing_values
            if unknown.any():
                rows, found = np.nonzero(unknown)
                raw[rows, self._missing_places[found]] = np.nan
        for place, flag in self._valid:
            raw[number_of(columns, flag) == 0.0, place] = np.nan
        si = raw * self._factor + self._offset
        finite = np.isfinite(si)
        if not finite.all():
            si[~finite] = np.nan
        values: FloatArray = si[:, self._picked]
        outside: BoolArray | None = None
        if self._calibrations is not None:
            supply = None if self._supply is None else si[:, self._supply]
            calibrated, outside = self._calibrations.evaluate(
                si[:, self._calibrations.columns], supply
            )
            values[:, self._calibrated_outputs] = calibrated
        self._count_clipped(values, outside)
        return values

    def _count_clipped(self, values: FloatArray, outside: BoolArray | None) -> None:
        """Count samples outside calibration, or at the end of the instrument's range."""
        clipped: BoolArray | None = None
        if self._ranges is not None:
            clipped = (values <= self._ranges[0]) | (values >= self._ranges[1])
        if outside is not None and outside.any():
            if clipped is None:
                clipped = np.zeros(values.shape, dtype=bool)
            clipped[:, self._calibrated_outputs] |= outside
        if clipped is None or not clipped.any():
            return
        totals = clipped.sum(axis=0)
        for column in np.flatnonzero(totals).tolist():
            name = self.outputs[column].channel
            self.clipped[name] = self.clipped.get(name, 0) + int(totals[column])

    def _plan_fields(self) -> None:
        """Gather the elements of each array field: they are fetched together."""
        gathered: dict[str, tuple[list[int], list[int]]] = {}
        for place, entry in enumerate(self._entries):
            ref = entry.inputs[0]
            if entry.convert is None and ref.index is not None:
                elements, places = gathered.setdefault(ref.field, ([], []))
                elements.append(ref.index)
                places.append(place)
            else:
                self._singles.append((place, entry))
        self._arrays = [(name, *both) for name, both in gathered.items()]
