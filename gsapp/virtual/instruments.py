"""From what each instrument is exposed to, to volts after the 12 bits of the converter.

In order: the motion of a flexible structure, the low-pass before the converter (50 Hz on all but
the rate gyros, which have none and are shaken by the engines instead), lag and delay, bias and
noise, the counts of a coarse converter, the end of the range, and what is broken: samples drop out,
stick, or are cut off, as with a loose wire or a jammed vane. Such a fault stands in the plan of a
flight (``[[faults]]``) or is given in one line, ``CHANNEL:KIND[:PARAM=VALUE,..]``. Works on
stretches of any length; cutting a flight into other pieces changes nothing.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import scipy  # loads scipy.signal (a third of a second) when it is first used
from pydantic import Field, ValidationInfo, field_validator, model_validator

from calibration.adc import quantize
from calibration.certificate import Certificate
from gsapp.aircraft import Accelerometer, Aircraft, AirData, AlphaVane, Gyro
from gsapp.aircraft.config import SurfaceSensors
from gsapp.foundation import FileProblemsError, FlightError, StrictModel, UnknownNameError
from gsapp.foundation.name_suggestions import did_you_mean
from gsapp.foundation.toml import validate_content
from gsapp.quantities import INSTRUMENTS, Block, FloatArray, channel, parse_quantity
from gsapp.quantities.fields import Time
from gsapp.virtual.dirt import Dirt, StructuralMode
from gsapp.virtual.settings import VIRTUAL

DAQ_CHANNELS = (*INSTRUMENTS, "excitation", "battery")
"""Channel of each input of the converter, in order."""

_DIVIDERS = {"excitation": 1.0, "battery": 0.2}
"""Inputs that see their voltage directly, or through a divider."""


class AnalogDigitalConverter:
    """Instruments' outputs into counts, and back through the certificates.

    There is one for each input that is not a plain voltage; raise UnknownNameError if one is
    missing.
    """

    def __init__(self, certificates: Mapping[str, Certificate]) -> None:
        missing = [
            name for name in DAQ_CHANNELS if name not in _DIVIDERS and name not in certificates
        ]
        if missing:
            raise UnknownNameError(
                f"there is no calibration certificate for {', '.join(missing)}; "
                "calibrate, or take the shipped set 'b777'"
            )
        self._certificates = dict(certificates)

    def volts(self, instruments: Mapping[str, FloatArray]) -> FloatArray:
        """Return the converted volts, shape (n, 20), of all inputs, by `calibration.adc.quantize`.

        What each instrument shows, of all `DAQ_CHANNELS`, is in SI, shape (n,). NaN is an open
        input, which the converter reads as nothing.
        """
        excitation = instruments["excitation"]
        columns = []
        for name in DAQ_CHANNELS:
            values = instruments[name]
            if name in _DIVIDERS:
                columns.append(values * _DIVIDERS[name])
            else:
                columns.append(self._certificates[name].volts(values, excitation))
        raw = np.nan_to_num(np.column_stack(columns), nan=0.0)
        return quantize(raw)

    def convert_volts(self, volts: FloatArray) -> dict[str, FloatArray]:
        """Return what the ground makes of converted volts, shape (n, 20): channel -> (n,)."""
        excitation = volts[:, DAQ_CHANNELS.index("excitation")]
        values = {}
        for index, name in enumerate(DAQ_CHANNELS):
            if name in _DIVIDERS:
                values[name] = volts[:, index] / _DIVIDERS[name]
            else:
                values[name] = self._certificates[name].evaluate(volts[:, index], excitation)
        return values

    def convert_to_block(self, times: FloatArray, volts: FloatArray) -> Block:
        """Return `convert_volts` as a block over times (s), shape (n,)."""
        values = self.convert_volts(volts)
        return Block(
            channels=DAQ_CHANNELS, times=times, values=np.column_stack(list(values.values()))
        )


# Engine vibration, as the gyros see it.
# The fans turn at 117 to 417 Hz; the gyros have no filter before the converter, so the 100 Hz
# samples show the difference to the nearest multiple of 100 Hz. Nothing here folds anything: the
# phase of each fan is followed exactly, and the samples do the rest.


class EngineVibration:
    """Rates shaken by two or more engines out of balance.

    Imbalance pushes with the square of the speed; the rate that it shakes up grows with the
    speed itself. `amplitude` is that of all engines together at `full_speed` (rad/s), on each axis,
    rad/s; random are the phases at the start and the directions in which each engine shakes.
    """

    def __init__(
        self, amplitude: float, full_speed: float, engines: int, random: np.random.Generator
    ) -> None:
        self._full_speed = max(full_speed, 1e-9)
        share = random.uniform(0.8, 1.2, (engines, 3)) / np.sqrt(engines)
        self._amplitude = amplitude * share
        self._offset = random.uniform(0.0, 2.0 * np.pi, (engines, 3))
        self._phase = random.uniform(0.0, 2.0 * np.pi, engines)
        self._speed: FloatArray | None = None

    def vibration_rates(self, speeds: FloatArray, dt: float) -> FloatArray:
        """Return p, q, r (rad/s), shape (n, 3), at the next samples, `dt` s apart.

        The speeds of the engines at these samples are in rad/s, shape (n, engines).
        """
        if not len(speeds):
            return np.empty((0, 3))
        before = np.vstack([speeds[:1] if self._speed is None else self._speed, speeds])
        turned = 0.5 * dt * (before[1:] + before[:-1])
        # Added one after the other, so that pieces give what the whole gives.
        phases = np.cumsum(np.vstack([self._phase, turned]), axis=0)[1:]
        self._phase = phases[-1]
        self._speed = speeds[-1:]
        waves = np.sin(phases[:, :, None] + self._offset)
        size = self._amplitude * (speeds / self._full_speed)[:, :, None]
        return np.asarray((size * waves).sum(axis=1))


GYRO_CHANNELS = ("p", "q", "r")
_NO_RANGE = (-math.inf, math.inf)


@dataclass(frozen=True, slots=True, kw_only=True)
class Instrument:
    """One instrument."""

    name: str  # Channel of the converter.
    low_pass: float | None = VIRTUAL.low_pass  # Corner of the filter before the converter, Hz.
    lag: float = 0.0
    delay: float = 0.0
    """s."""
    bias: float = 0.0
    noise: float = 0.0
    """SI; `noise` is the standard deviation of each sample."""
    range: tuple[float, float] = _NO_RANGE  # Lowest and highest value that it can show, SI.


def _instrument(
    name: str,
    sensor: SurfaceSensors | AlphaVane | Gyro | Accelerometer | AirData,
    noise: float,
    limits: tuple[float, float] = _NO_RANGE,
    bias: float = 0.0,
) -> Instrument:
    return Instrument(
        name=name,
        low_pass=sensor.low_pass,
        lag=sensor.lag,
        delay=sensor.delay,
        bias=bias,
        noise=noise,
        range=limits,
    )


def create_instruments(aircraft: Aircraft) -> tuple[Instrument, ...]:
    """Return the instruments on the recorder, as the aircraft file describes them."""
    sensors = aircraft.sensors
    surfaces, air = sensors.surfaces, sensors.air_data
    alpha, beta = sensors.alpha_vane, sensors.beta_vane
    gyro, accelerometer = sensors.gyro, sensors.accelerometer
    return (
        *(
            _instrument(name, surfaces, surfaces.noise)
            for name in (
                "elevator_left",
                "elevator_right",
                "aileron_left",
                "aileron_right",
                "rudder",
            )
        ),
        _instrument("alpha", alpha, alpha.noise, alpha.range, alpha.bias),
        _instrument("beta", beta, beta.noise, beta.range, beta.bias),
        *(
            _instrument(name, gyro, gyro.noise, gyro.range, bias)
            for name, bias in zip(GYRO_CHANNELS, gyro.bias, strict=True)
        ),
        *(
            _instrument(name, accelerometer, accelerometer.noise, accelerometer.range, bias)
            for name, bias in zip(("ax", "ay", "an"), accelerometer.bias, strict=True)
        ),
        _instrument("static_pressure", air, air.static_noise, air.static_range),
        _instrument("dynamic_pressure", air, air.noise, air.range),
        Instrument(name="temperature", lag=5.0, noise=0.05),
        Instrument(name="throttle", noise=0.001),
        Instrument(name="flap", noise=surfaces.noise),
        Instrument(name="excitation", noise=0.0005),
        Instrument(name="battery", noise=0.003),
    )


class _Filter:
    """A linear filter that goes on from stretch to stretch, settled at the first sample."""

    def __init__(self, numerator: FloatArray, denominator: FloatArray, dt: float) -> None:
        # Between samples the input is taken as a straight line.
        b, a, _ = scipy.signal.cont2discrete((numerator, denominator), dt, method="foh")
        self._b, self._a = np.atleast_1d(np.squeeze(b)), np.atleast_1d(a)
        self._state: FloatArray | None = None

    def __call__(self, values: FloatArray) -> FloatArray:
        if not len(values):
            return values
        if self._state is None:
            self._state = scipy.signal.lfilter_zi(self._b, self._a) * values[0]
        filtered, self._state = scipy.signal.lfilter(self._b, self._a, values, zi=self._state)
        return np.asarray(filtered, dtype=np.float64)


class _Delay:
    """A delay of any length; the first value stands for what was before."""

    def __init__(self, delay: float, dt: float) -> None:
        self._whole, self._part = divmod(delay / dt, 1.0)
        self._past: FloatArray | None = None

    def __call__(self, values: FloatArray) -> FloatArray:
        if not len(values):
            return values
        length = int(self._whole) + 1
        if self._past is None:
            self._past = np.full(length, values[0])
        line = np.concatenate([self._past, values])
        self._past = line[-length:]
        late = line[1 : len(values) + 1]
        later = line[: len(values)]
        return np.asarray((1.0 - self._part) * late + self._part * later)


class _Chain:
    """What one instrument does to its signal before noise is added."""

    def __init__(self, instrument: Instrument, dt: float) -> None:
        self.instrument = instrument
        self._steps: list[_Filter | _Delay] = []
        if instrument.low_pass is not None:
            b, a = scipy.signal.butter(2, 2.0 * np.pi * instrument.low_pass, analog=True)
            self._steps.append(_Filter(b, a, dt))
        if instrument.lag > 0.0:
            self._steps.append(_Filter(np.array([1.0]), np.array([instrument.lag, 1.0]), dt))
        if instrument.delay > 0.0:
            self._steps.append(_Delay(instrument.delay, dt))

    def __call__(self, values: FloatArray) -> FloatArray:
        for step in self._steps:
            values = step(values)
        return values


class StructuralVibration:
    """What a bending mode adds to an accelerometer that shakes with it, samples `dt` s apart.

    The mode is excited by the acceleration of the aircraft, and by engines and air at random.
    """

    def __init__(self, mode: StructuralMode, dt: float, random: np.random.Generator) -> None:
        omega = 2.0 * math.pi * mode.frequency
        poles = np.array([1.0, 2.0 * mode.damping * omega, omega * omega])
        self._excited = _Filter(np.array([mode.participation, 0.0, 0.0]), poles, dt)
        self._shaken = _Filter(np.array([poles[1], 0.0]), poles, dt)
        # White samples through a band so narrow keep this share of their variance.
        self._noise = mode.buffet / math.sqrt(mode.damping * omega * dt)
        self._random = random

    def __call__(self, values: FloatArray) -> FloatArray:
        """Return the acceleration with that of the structure, m/s^2, shape (n,)."""
        noise = self._noise * self._random.standard_normal(values.size)
        return values + self._excited(values) + self._shaken(noise)


_COMBINED: Mapping[str, tuple[str, ...]] = {
    "de": ("elevator_left", "elevator_right"),
    "da": ("aileron_left", "aileron_right"),
    "dr": ("rudder",),
}
"""The instruments behind the surfaces."""


class Instruments:
    """All instruments on the recorder of one aircraft, on one day.

    The aircraft file has noise, bias, range, lag and delay of each; samples are `dt` s apart.
    Faults act in their order on the same instrument.
    """

    def __init__(
        self,
        aircraft: Aircraft,
        random: np.random.Generator,
        dt: float,
        faults: Sequence[SensorFault] = (),
        dirt: Dirt | None = None,
    ) -> None:
        noise, shaking, failing, flexing = random.spawn(4)
        dirt = dirt or Dirt()
        self._structure = {
            mode.channel: StructuralVibration(mode, dt, own)
            for mode, own in zip(dirt.structure, flexing.spawn(len(dirt.structure)), strict=True)
        }
        self._resolutions = {
            instrument: count
            for name, count in dirt.resolutions.items()
            for instrument in _COMBINED.get(name, (name,))
        }
        self._dt = dt
        self._noise = noise
        self._chains = [_Chain(instrument, dt) for instrument in create_instruments(aircraft)]
        self._vibration = EngineVibration(
            aircraft.sensors.gyro.vibration, aircraft.propulsion.rpm_full, 2, shaking
        )
        self._failing = [
            SensorFaultInjector(fault, dt, own)
            for fault, own in zip(faults, failing.spawn(len(faults)), strict=True)
        ]
        self._count = 0

    def read(
        self, exposed: Mapping[str, FloatArray], engine_speeds: FloatArray
    ) -> dict[str, FloatArray]:
        """Return what the instruments show before the converter, SI, shape (n,); NaN for nothing.

        What each is exposed to where it is has the shape (n,), SI; the speeds of the left and right
        engine (n, 2), rad/s.
        """
        shaken = dict(
            zip(
                GYRO_CHANNELS,
                self._vibration.vibration_rates(engine_speeds, self._dt).T,
                strict=True,
            )
        )
        count = len(engine_speeds)
        # Row by row, so that the numbers do not depend on the length of the stretch.
        noise = self._noise.standard_normal((count, len(self._chains)))
        shown = {}
        for column, chain in enumerate(self._chains):
            instrument = chain.instrument
            values = exposed[instrument.name]
            if instrument.name in shaken:
                values = values + shaken[instrument.name]
            if instrument.name in self._structure:
                values = self._structure[instrument.name](values)
            values = chain(values) + instrument.bias + instrument.noise * noise[:, column]
            if instrument.name in self._resolutions:
                step = self._resolutions[instrument.name]
                values = step * np.round(values / step)
            shown[instrument.name] = np.clip(values, *instrument.range)
        for failing in self._failing:
            name = failing.fault.channel
            shown[name] = failing.apply(shown[name], self._count)
        self._count += count
        return shown


_NEVER = sys.maxsize


class SensorFault(StrictModel):
    """One thing that goes wrong with one instrument."""

    channel: str  # The input of the converter: one of `gsapp.virtual.instruments.DAQ_CHANNELS`.
    kind: Literal["dropout", "stuck", "clip"]
    """``dropout``: the input is open, which the converter reads as 0 V. ``stuck``: the sample at
    its beginning is repeated. ``clip``: nothing beyond `low` and `high` is shown."""
    start: Time = 0.0
    end: Time = math.inf
    """When it may act, s since the box was switched on."""
    every: Time | None = Field(default=None, gt=0.0)
    length: Time | None = Field(default=None, gt=0.0)
    """It comes and goes: mean time from one end to the next beginning, and mean duration, s, both
    spread exponentially. Without them it acts from `start` to `end`."""
    low: float | None = None
    high: float | None = None
    """What ``clip`` cuts off, in the SI unit of the channel."""

    @field_validator("channel")
    @classmethod
    def _is_measured(cls, value: str) -> str:
        if value not in DAQ_CHANNELS:
            hint = did_you_mean(value, DAQ_CHANNELS, f"choose one of {', '.join(DAQ_CHANNELS)}")
            raise ValueError(f"no instrument measures '{value}'; {hint}")
        return value

    @field_validator("low", "high", mode="before")
    @classmethod
    def _with_unit(cls, value: Any, info: ValidationInfo) -> Any:
        known = info.data.get("channel")
        if value is None or known is None:  # without a channel there is that to say already
            return None
        return parse_quantity(value, channel(known).quantity)

    @model_validator(mode="after")
    def _hangs_together(self) -> SensorFault:
        if not self.start < self.end:
            raise ValueError("it ends before it begins; swap 'start' and 'end'")
        if (self.every is None) != (self.length is None):
            raise ValueError("'every' and 'length' belong together; give both, or neither")
        cuts = self.low is not None or self.high is not None
        if cuts != (self.kind == "clip"):
            raise ValueError("'low' and 'high' belong to clip; give it one or both of them")
        if self.low is not None and self.high is not None and not self.low < self.high:
            raise ValueError("the lower end comes first; swap 'low' and 'high'")
        return self


def parse_sensor_fault(text: str) -> SensorFault:
    """Read a fault from one line, such as ``alpha:stuck:start=60 s,end=75 s``.

    Raise FlightError if it says something else.
    """
    channel_id, _, rest = text.partition(":")
    kind, _, rest = rest.partition(":")
    content = {"channel": channel_id.strip(), "kind": kind.strip()}
    for pair in rest.split(",") if rest else ():
        name, equals, value = pair.partition("=")
        if not equals:
            raise FlightError(
                f"'{pair}' in '{text}' is not PARAM=VALUE; write for example "
                "alpha:dropout:every=20 s,length=0.1 s"
            )
        content[name.strip()] = value.strip()
    try:
        return validate_content("fault", content, SensorFault)
    except FileProblemsError as error:
        said = ". ".join(str(problem) for problem in error.problems)
        raise FlightError(f"'{text}' is not a fault: {said}") from error


class SensorFaultInjector:
    """A fault at work, stretch after stretch, on samples `dt` s apart."""

    def __init__(self, fault: SensorFault, dt: float, random: np.random.Generator) -> None:
        self.fault = fault
        self._dt = dt
        self._random = random
        self._last = self._index(fault.end)
        self._begin, self._end = self._index(fault.start), self._last
        self._held = math.nan
        if fault.every is not None:
            self._end = self._begin
            self._await_next()

    def apply(self, shown: FloatArray, first: int) -> FloatArray:
        """Return what remains of successive samples, shape (n,); `first` counts from the start."""
        values = shown.copy()
        after = first + len(values)
        while self._begin < after:
            begin, end = max(self._begin, first), min(self._end, after)
            self._harm(values[begin - first : end - first], begins=begin == self._begin)
            if self._end > after:
                break
            self._await_next()
        return values

    def _harm(self, values: FloatArray, *, begins: bool) -> None:
        if self.fault.kind == "dropout":
            values[:] = math.nan
        elif self.fault.kind == "stuck":
            if begins:
                self._held = float(values[0])
            values[:] = self._held
        else:
            np.clip(values, self.fault.low, self.fault.high, out=values)

    def _await_next(self) -> None:
        every, length = self.fault.every, self.fault.length
        if every is None or length is None:
            self._begin = self._end = _NEVER
            return
        gap, duration = self._random.exponential((every, length))
        self._begin = self._end + max(round(gap / self._dt), 1)
        self._end = min(self._begin + max(round(duration / self._dt), 1), self._last)
        if self._begin >= self._last:
            self._begin = self._end = _NEVER

    def _index(self, time: float) -> int:
        return round(time / self._dt) if math.isfinite(time) else _NEVER
