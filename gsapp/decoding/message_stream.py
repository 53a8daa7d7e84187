"""One message of one sender, turned into numbers: fields, scale, unit, calibration.

What is done to a number is done in two ways that give the same bits: number by number for the few
samples that a live link gives at a time (one step of NumPy costs as much as thirty of them), and
by columns for the many that a file gives. The two stand beside each other, step by step.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from calibration import Certificate
from calibration.certificate import reference_ratio
from calibration.signals import find_signal
from gsapp.decoding.channel_map import FieldRef, MapEntry, Selector
from gsapp.decoding.conversions import CONVERSIONS, Conversion
from gsapp.decoding.grid import Numbers, column_index
from gsapp.decoding.settings import DECODING
from gsapp.foundation import FlightError
from gsapp.quantities import (
    CIRCULAR_CHANNELS,
    STEPWISE_CHANNELS,
    FloatArray,
    base_id,
    channel,
    is_raw_channel,
    to_si,
)

_FEW_SAMPLES, _FEW_NUMBERS = 8, 200
MessageColumns = Mapping[str, np.ndarray[tuple[int, ...], np.dtype[np.generic]]]
BoolArray = npt.NDArray[np.bool_]


def field_values(columns: MessageColumns, ref: FieldRef) -> FloatArray:
    """Return one number of every sample, shape (n,); raise KeyError if there is no such field.

    An element of an array is found in a field of shape (n, k), or in one called ``name[index]``.
    Contiguous, so that functions round alike however many samples there are.
    """
    if ref.index is None:
        return np.ascontiguousarray(columns[ref.field], dtype=np.float64)
    names = getattr(columns, "dtype", None)
    if names is None and ref.field not in columns:
        return np.ascontiguousarray(columns[f"{ref.field}[{ref.index}]"], dtype=np.float64)
    return np.ascontiguousarray(columns[ref.field][:, ref.index], dtype=np.float64)


def is_valid(flags: FloatArray, least: float | None) -> BoolArray:
    """Return which values count by the numbers of `MapEntry.valid`, shape (n,)."""
    found: BoolArray = flags != 0.0 if least is None else ~(flags < least)
    return found


def linear_factors(entry: MapEntry) -> tuple[float, float]:
    """Return factor and offset from the raw number to SI, to the signal where it is calibrated."""
    if entry.calibration is not None:
        factor = find_signal(entry.unit).factors[entry.unit]
        return factor * entry.scale, factor * entry.offset
    key = channel(entry.channel).quantity
    zero = to_si(0.0, entry.unit, key)
    factor = to_si(1.0, entry.unit, key) - zero
    return factor * entry.scale, factor * entry.offset + zero


@dataclass(frozen=True, slots=True, kw_only=True)
class StreamColumn:
    """One column that a stream yields."""

    channel: str
    entry: MapEntry
    """Where it comes from."""
    calibrated: bool  # Whether a certificate turned volts into it.
    uncalibrated_channel: str = ""
    """The channel that these volts would give, had it a certificate; else empty."""


class _CalibrationCurves(NamedTuple):
    """Calibrations that refer to one supply, for single numbers."""

    straight: list[tuple[int, float, float, float, float]]
    """Column, ends of the range (V), coefficients with the highest power first."""
    bent: list[tuple[int, float, float, float, float, float, float]]
    """The same, up to the third power."""
    certificates: dict[int, Certificate]  # By column.


class _Calibrations:
    """All certificates of one message at once: each step is one operation on a matrix."""

    def __init__(self, certificates: Sequence[Certificate], places: Sequence[int]) -> None:
        degree = max(certificate.degree for certificate in certificates)
        # The highest power first; where a certificate has none, it is zero.
        self._coefficients = [
            np.array([(*c.si_coefficients, 0.0, 0.0, 0.0)[power] for c in certificates])
            for power in range(degree, -1, -1)
        ]
        self._low = np.array([certificate.range[0] for certificate in certificates])
        self._high = np.array([certificate.range[1] for certificate in certificates])
        self._low_slope = np.array([certificate.end_slopes[0] for certificate in certificates])
        self._high_slope = np.array([certificate.end_slopes[1] for certificate in certificates])
        supplies = [
            certificate.excitation_voltage if certificate.ratiometric else None
            for certificate in certificates
        ]
        # No measured supply is plausible beside a negative one: such volts are never corrected.
        self._supply = np.array([supply or -1.0 for supply in supplies])
        self._any_ratiometric = any(supplies)
        self._curves: dict[float, _CalibrationCurves] = {}
        for place, certificate, supply in zip(places, certificates, supplies, strict=True):
            low, high = certificate.range
            c0, c1, c2, c3 = (*certificate.si_coefficients, 0.0, 0.0, 0.0)[:4]
            # By supply, so that each is compared with the measured one once.
            curves = self._curves.setdefault(supply or -1.0, _CalibrationCurves([], [], {}))
            curves.certificates[place] = certificate
            if certificate.degree == 1:
                curves.straight.append((place, low, high, c1, c0))
            else:
                curves.bent.append((place, low, high, c3, c2, c1, c0))

    def evaluate(
        self, volts: FloatArray, excitation: FloatArray | None
    ) -> tuple[FloatArray, BoolArray | None]:
        """Return SI values and where volts were outside what was calibrated, shape (n, m).

        None stands for nowhere.

        The same steps as `Certificate.evaluate`, so the same numbers to the last bit.
        """
        if excitation is not None and self._any_ratiometric:
            volts = volts * reference_ratio(self._supply, excitation[:, np.newaxis])
        inside = np.minimum(np.maximum(volts, self._low), self._high)
        values = self._coefficients[0] * inside
        for coefficient in self._coefficients[1:-1]:
            values += coefficient
            values *= inside
        values += self._coefficients[-1]
        if np.count_nonzero(volts == inside) == volts.size:
            return values, None
        beyond = volts - inside
        below = beyond < 0.0
        values += beyond * np.where(below, self._low_slope, self._high_slope)
        return values, below | (beyond > 0.0)

    def evaluate_singly(self, values: list[float], excitation: float) -> Sequence[int]:
        """Turn volts of one sample, all that the stream yields, into SI values in place.

        Return where they were outside what was calibrated. The supply is NaN where none is
        measured.
        """
        outside: Sequence[int] = ()
        for supply, (straight, bent, certificates) in self._curves.items():
            plausible = 0.5 * supply < excitation < 1.5 * supply
            ratio = supply / excitation if plausible else 1.0
            beyond = []
            for place, low, high, c1, c0 in straight:
                volts = values[place] * ratio
                if low <= volts <= high:
                    values[place] = c1 * volts + c0
                else:
                    beyond.append((place, volts))
            for place, low, high, c3, c2, c1, c0 in bent:
                volts = values[place] * ratio
                if low <= volts <= high:
                    values[place] = ((c3 * volts + c2) * volts + c1) * volts + c0
                else:
                    beyond.append((place, volts))
            for place, volts in beyond:
                values[place] = _extrapolate(certificates[place], volts)
                outside = (*outside, place)
        return outside


def _extrapolate(certificate: Certificate, volts: float) -> float:
    """Return what volts outside a calibration mean: its curve goes on straight."""
    if math.isnan(volts):
        return math.nan
    low, high = certificate.range
    below = volts < low
    inside = low if below else high
    value = 0.0
    for coefficient in reversed(certificate.si_coefficients):
        value = value * inside + coefficient
    return value + (volts - inside) * certificate.end_slopes[not below]


def _check_signal(entry: MapEntry, certificate: Certificate) -> None:
    given = find_signal(entry.unit).unit
    if given != certificate.signal_unit:
        raise FlightError(
            f"the certificate of {certificate.channel} is for {certificate.signal_unit}, and the "
            f"channel map gives {entry.source} in {given}; correct the unit in the map, or take "
            "another certificate"
        )


class MessageStream:
    """The channels that come from one message of one sender.

    Its entries have the same message, selector and time. Without its certificate a calibrated entry
    yields volts only. With `vehicle_time` its samples carry the vehicle's time; else they are timed
    by arrival.

    Attributes
    ----------
    outputs : tuple of StreamColumn
        Columns of `convert`, in order.
    few : int
        Up to so many samples are quicker number by number.
    wanted : tuple of FieldRef
        The numbers of the message that `convert_scalars` takes: one for each output, then those
        that conversions and flags of validity need.
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
        outputs: list[StreamColumn] = []
        calibrated: list[tuple[int, Certificate]] = []
        for entry in entries:
            if entry.calibration is None:
                outputs.append(StreamColumn(channel=entry.channel, entry=entry, calibrated=False))
                continue
            certificate = certificates.get(entry.calibration)
            if certificate is not None:
                _check_signal(entry, certificate)
                calibrated.append((len(outputs), certificate))
                outputs.append(StreamColumn(channel=entry.channel, entry=entry, calibrated=True))
            outputs.append(
                StreamColumn(
                    channel=entry.volts_channel,
                    entry=entry,
                    calibrated=False,
                    uncalibrated_channel="" if certificate is not None else entry.channel,
                )
            )
        self.outputs = tuple(outputs)
        self.few = max(1, min(_FEW_SAMPLES, _FEW_NUMBERS // len(outputs)))
        factors = [linear_factors(output.entry) for output in outputs]
        self._scaled = [(n, f, o) for n, (f, o) in enumerate(factors) if (f, o) != (1.0, 0.0)]
        self._factor = np.array([factor for factor, _ in factors])
        self._offset = np.array([offset for _, offset in factors])
        places = [place for place, _ in calibrated]
        self._calibrated = column_index(places)
        self._calibrations = (
            _Calibrations([each for _, each in calibrated], places) if calibrated else None
        )
        self._plan_fields()
        supply = [i for i, output in enumerate(outputs) if output.channel == "excitation"]
        self._supply = supply[0] if supply else None
        bases = [base_id(output.channel) for output in outputs]
        self.circular = np.array([base in CIRCULAR_CHANNELS for base in bases], dtype=bool)
        # Of a raw number nobody knows whether there is anything between two samples.
        self.stepwise = np.array(
            [base in STEPWISE_CHANNELS or is_raw_channel(base) for base in bases], dtype=bool
        )
        self.clipped: dict[str, int] = {}
        self._low = np.full(len(outputs), -np.inf)
        self._high = np.full(len(outputs), np.inf)
        self._limits: list[tuple[int, float, float]] = []

    @property
    def channels(self) -> tuple[str, ...]:
        return tuple(output.channel for output in self.outputs)

    def set_instrument_ranges(self, ranges: Mapping[str, tuple[float, float]]) -> None:
        """Count samples at the ends of these instruments' ranges, SI, by channel.

        A converter rounds the rail to one of its counts, so a thousandth of the range before
        the end counts as the end.
        """
        for index, output in enumerate(self.outputs):
            if output.channel in ranges:
                bottom, top = ranges[output.channel]
                margin = DECODING.range_margin * (
                    top - bottom if np.isfinite(top - bottom) else abs(top)
                )
                self._low[index], self._high[index] = bottom + margin, top - margin
                self._limits.append((index, bottom + margin, top - margin))

    def convert(self, columns: MessageColumns, count: int) -> FloatArray:
        """Return SI values of n samples, shape (n, n_outputs); NaN where the vehicle does not know.

        Columns are the fields by name, each of shape (n,) or (n, k).
        """
        values = self._fetch(columns, count)
        values *= self._factor
        values += self._offset
        outside: BoolArray | None = None
        if self._calibrations is not None:
            supply = None if self._supply is None else values[:, self._supply]
            calibrated, outside = self._calibrations.evaluate(values[:, self._calibrated], supply)
            values[:, self._calibrated] = calibrated
        within = (values > self._low) & (values < self._high)
        if outside is not None or np.count_nonzero(within) < within.size:
            # Seldom: clipped, missing, or not even finite.
            finite = np.isfinite(values)
            values[~finite] = np.nan
            clipped = ~within
            if outside is not None:
                clipped[:, self._calibrated] |= outside
            totals = (clipped & finite).sum(axis=0)
            for column in np.flatnonzero(totals).tolist():
                self._count(column, int(totals[column]))
        return values

    def convert_scalars(self, samples: Sequence[Numbers]) -> tuple[list[list[float]], bool]:
        """Return SI values of samples, each the numbers `wanted`: `convert`, number by number.

        Beside them stands whether no number is missing.
        """
        complete = True
        width = len(self.outputs)
        result = []
        for sample in samples:
            numbers = self._with_conversions(sample) if self._conversions else sample
            values = list(numbers[:width])
            for place, factor, offset in self._scaled:
                values[place] = numbers[place] * factor + offset
            if 0.0 in values:
                values = [value + 0.0 for value in values]  # no negative zeros
            for place, missing in self._missing:
                if numbers[place] in missing:
                    values[place] = math.nan
            for place, flag, least in self._flags:
                if numbers[flag] == 0.0 if least is None else numbers[flag] < least:
                    values[place] = math.nan
            outside: Sequence[int] = ()
            if self._calibrations is not None:
                supply = math.nan if self._supply is None else values[self._supply]
                outside = self._calibrations.evaluate_singly(values, supply)
            if not math.isfinite(sum(values)):
                complete = False
                values = [value if math.isfinite(value) else math.nan for value in values]
            if self._limits or outside:
                self._count_outside(values, outside)
            result.append(values)
        return result, complete

    def _count_outside(self, values: Numbers, outside: Sequence[int]) -> None:
        clipped = [p for p, low, high in self._limits if values[p] <= low or values[p] >= high]
        if clipped or outside:
            for place in {*clipped, *outside}:
                if not math.isnan(values[place]):
                    self._count(place, 1)

    def _with_conversions(self, numbers: Numbers) -> Numbers:
        found = list(numbers)
        for place, conversion, inputs in self._conversions:
            # By NumPy as well: its functions may round differently from Python's.
            parts = [np.array([numbers[each]], dtype=np.float64) for each in inputs]
            found[place] = float(conversion.compute(self._known(place, parts))[0])
        return found

    def _known(self, place: int, parts: Sequence[FloatArray]) -> tuple[FloatArray, ...]:
        """Return the numbers that a conversion takes, NaN where one is none: so is the result."""
        missing = self.outputs[place].entry.missing
        if not missing:
            return tuple(parts)
        return tuple(np.where(np.isin(part, missing), np.nan, part) for part in parts)

    def _fetch(self, columns: MessageColumns, count: int) -> FloatArray:
        """Return the raw number of each output; NaN where it says that it is none."""
        raw = np.empty((count, len(self.outputs)))
        for name, elements, places in self._arrays:
            raw[:, places] = columns[name].take(elements, axis=1)
        for place, field in self._singles:
            raw[:, place] = columns[field]
        for place, conversion, refs in self._converted:
            parts = [field_values(columns, ref) for ref in refs]
            raw[:, place] = conversion.compute(self._known(place, parts))
        if self._missing_places.size:
            unknown = raw.take(self._missing_places, axis=1) == self._missing_values
            if unknown.any():
                rows, found = np.nonzero(unknown)
                raw[rows, self._missing_places[found]] = np.nan
        for place, flag, least in self._valid:
            raw[~is_valid(field_values(columns, flag), least), place] = np.nan
        return raw

    def _count(self, column: int, clipped: int) -> None:
        name = self.outputs[column].channel
        self.clipped[name] = self.clipped.get(name, 0) + clipped

    def _conversion(self, place: int, entry: MapEntry) -> Conversion:
        """Return the conversion that an entry names, or that its curve is."""
        curve = entry.curve
        if curve is None:
            return CONVERSIONS[entry.convert or ""]

        def compute(parts: tuple[FloatArray, ...]) -> FloatArray:
            if beyond := curve.count_beyond(parts[0]):
                self._count(place, beyond)
            return curve.evaluate(parts[0])

        return Conversion(name="", inputs=1, compute=compute, meaning="")

    def _plan_fields(self) -> None:
        """Gather where the raw numbers come from; elements of an array are fetched together."""
        wanted = [output.entry.inputs[0] for output in self.outputs]
        self._conversions: list[tuple[int, Conversion, range]] = []
        self._flags: list[tuple[int, int, float | None]] = []
        self._missing: list[tuple[int, frozenset[float]]] = []
        gathered: dict[str, tuple[list[int], list[int]]] = {}
        self._singles: list[tuple[int, str]] = []
        self._converted: list[tuple[int, Conversion, tuple[FieldRef, ...]]] = []
        missing: list[tuple[int, float]] = []
        self._valid: list[tuple[int, FieldRef, float | None]] = []
        for place, output in enumerate(self.outputs):
            entry = output.entry
            ref = entry.inputs[0]
            if entry.convert is not None or entry.curve is not None:
                conversion = self._conversion(place, entry)
                self._converted.append((place, conversion, entry.inputs))
                inputs = range(len(wanted), len(wanted) + len(entry.inputs))
                self._conversions.append((place, conversion, inputs))
                wanted += entry.inputs
            elif ref.index is None:
                self._singles.append((place, ref.field))
            else:
                elements, places = gathered.setdefault(ref.field, ([], []))
                elements.append(ref.index)
                places.append(place)
            # Of a conversion the numbers that go in may be missing, not what comes out.
            if entry.missing and entry.convert is None and entry.curve is None:
                missing += [(place, value) for value in entry.missing]
                self._missing.append((place, frozenset(entry.missing)))
            if entry.valid:
                self._flags.append((place, len(wanted), entry.valid_from))
                wanted.append(FieldRef(field=entry.valid))
                self._valid.append((place, FieldRef(field=entry.valid), entry.valid_from))
        self._arrays = [
            (name, np.array(elements, dtype=np.intp), column_index(places))
            for name, (elements, places) in gathered.items()
        ]
        self._missing_places = np.array([place for place, _ in missing], dtype=np.intp)
        self._missing_values = np.array([value for _, value in missing])
        self.wanted = tuple(wanted)
