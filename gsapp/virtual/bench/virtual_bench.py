"""A virtual aircraft on the ground, and the hands that calibrate its instruments.

Everything about it is drawn from a seed: how each potentiometer is bent and how much play its
linkage has, where gyros and accelerometers stand, the weather. What is true is there for tests to
ask; what the ground gets are the converter's volts, a hundred times a second. How far it is asked
to go on at a time changes nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calibration import load_certificates
from calibration.adc import ADC_FULL_SCALE, quantize
from calibration.inertial.accelerometers import Position
from gsapp.aircraft import load_aircraft
from gsapp.foundation import FlightError
from gsapp.foundation.name_suggestions import did_you_mean
from gsapp.quantities import INSTRUMENTS, Block, FloatArray
from gsapp.virtual.bench.bench_instruments import (
    ACCELEROMETERS,
    GYROS,
    POTENTIOMETERS,
    BenchFault,
    Linkage,
    Potentiometer,
    SensorTriad,
    Transducer,
    sample_accelerometers,
    sample_gyros,
)
from gsapp.virtual.bench.operator_motion import (
    BenchAttitude,
    OperatorTremor,
    PitotBreath,
    SurfaceMovement,
)
from gsapp.virtual.instruments import DAQ_CHANNELS
from gsapp.virtual.settings import VIRTUAL

# Faults at work on the volts of the bench.
# What is mounted the other way round (``reversed``) is so from the beginning: see `virtual`.


class BenchFaultInjector:
    """What faults make of volts, stretch after stretch."""

    def __init__(self, faults: Sequence[BenchFault], random: np.random.Generator) -> None:
        self._faults = tuple(faults)
        self._random = random.spawn(len(self._faults))
        self._open = [bool(own.integers(2)) for own in self._random]
        self._upward = [bool(own.integers(2)) for own in self._random]
        self._room = [float(own.uniform(*VIRTUAL.clipped_margin)) for own in self._random]
        self._at_first: FloatArray | None = None

    def apply(self, volts: FloatArray) -> FloatArray:
        """Return volts (n, 20) with the faults in them."""
        if not self._faults or not len(volts):
            return volts
        harmed = volts.copy()
        if self._at_first is None:
            self._at_first = harmed[0].copy()
        for index, fault in enumerate(self._faults):
            column = DAQ_CHANNELS.index(fault.channel)
            first = float(self._at_first[column])
            if fault.kind == "dead":
                harmed[:, column] = 0.0 if self._open[index] else first
            elif fault.kind == "swapped":
                other = DAQ_CHANNELS.index(fault.other)
                harmed[:, [column, other]] = harmed[:, [other, column]]
            elif fault.kind == "noisy":
                harmed[:, column] += self._scratching(self._random[index], len(volts))
            elif fault.kind == "clipped":
                end = (
                    ADC_FULL_SCALE - self._room[index] if self._upward[index] else self._room[index]
                )
                harmed[:, column] += end - first
        return harmed

    def _scratching(self, random: np.random.Generator, count: int) -> FloatArray:
        drawn = random.standard_normal((count, 2))
        lost = np.abs(drawn[:, 1]) > 2.17  # three samples in a hundred
        return np.asarray(
            VIRTUAL.bad_contact_std * drawn[:, 0] - np.where(lost, VIRTUAL.bad_contact_drop, 0.0)
        )


_HALF_DENSITY = 0.6
"""kg/m^3."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BenchWeather:
    """The air at the field: static pressure, Pa, and temperature, K."""

    pressure: float
    temperature: float

    @classmethod
    def sample(cls, random: np.random.Generator) -> BenchWeather:
        return cls(
            pressure=float(random.uniform(96e3, 102e3)),
            temperature=float(random.uniform(278.0, 306.0)),
        )


class Pitot:
    """What the pitot feels: a light gusty wind, nothing under its cover, or a breath.

    The phases of the gusts have the shape (3,), rad.
    """

    def __init__(self, gust_phases: FloatArray) -> None:
        self._phases = gust_phases
        self._breath: PitotBreath | None = None
        self.covered = False

    def blow(self, hands: np.random.Generator, now: float) -> float:
        """Have somebody take the cover off and blow; return when it is over, s."""
        self.covered = False
        self._breath = PitotBreath(
            begin=now + VIRTUAL.breath_delay,
            seconds=float(hands.uniform(1.0, 1.8)),
            peak=float(hands.uniform(500.0, 2200.0)),
        )
        return self._breath.end

    def is_blowing(self, now: float) -> bool:
        return self._breath is not None and self._breath.end > now

    def pressure(self, times: FloatArray) -> FloatArray:
        """Return the dynamic pressure, Pa, shape (n,)."""
        a, b, c = self._phases
        wind = 2.0 + 0.9 * np.sin(0.6 * times + a) + 0.6 * np.sin(1.9 * times + b)
        wind = wind + 0.4 * np.sin(4.3 * times + c)
        felt = np.zeros(times.size) if self.covered else _HALF_DENSITY * wind * np.abs(wind)
        if self._breath is not None:
            felt = felt + self._breath.pressure(times)
        return np.asarray(felt)


class VirtualBench:
    """An aircraft on the ground whose surfaces are moved by hand.

    `potentiometers` (by channel), `gyros` (deg/s), `accelerometers` (g) and `pressures` (by
    channel, Pa) are as they really are, reversed ones included.

    Parameters
    ----------
    seed : int
        Same seed, same aircraft, same weather, same hands.
    aircraft : str
        Whose gyros and accelerometers; a file, or the name of a shipped one.
    setting_error : float
        Standard deviation with which the protractor is set, deg.
    """

    def __init__(
        self,
        seed: int = 0,
        *,
        faults: Sequence[BenchFault] = (),
        aircraft: str = "b777",
        setting_error: float = VIRTUAL.angle_setting_std,
    ) -> None:
        drawing, self._hands, noise, harming = np.random.default_rng([seed, 0xBE]).spawn(4)
        nominal = load_certificates("b777")
        described = load_aircraft(aircraft)
        self.potentiometers = {name: Potentiometer.sample(name, drawing) for name in POTENTIOMETERS}
        self.gyros: SensorTriad = sample_gyros(nominal, described, drawing)
        self.accelerometers: SensorTriad = sample_accelerometers(nominal, described, drawing)
        air = described.sensors.air_data
        self.pressures = {
            "static_pressure": Transducer.sample(
                nominal["static_pressure"], drawing, zero_std=150.0, noise=air.static_noise
            ),
            "dynamic_pressure": Transducer.sample(
                nominal["dynamic_pressure"], drawing, zero_std=12.0, noise=air.noise
            ),
        }
        for fault in faults:
            if fault.kind == "reversed":
                self._reverse(fault.channel)
        self.weather = BenchWeather.sample(drawing)
        self._supply = float(drawing.uniform(4.85, 4.96))
        self._supply_swing = float(drawing.uniform(0.002, 0.008))
        self._pitot = Pitot(drawing.uniform(0.0, 2.0 * np.pi, 3))
        self._others = {
            "temperature": float(nominal["temperature"].volts(self.weather.temperature)),
            "throttle": float(nominal["throttle"].volts(0.0)),
            "flap": float(nominal["flap"].volts(0.0)),
        }
        self._setting_error = setting_error
        self._noise = noise
        self._tremor = OperatorTremor(1.0 / VIRTUAL.bench_rate)
        self._harm = BenchFaultInjector(faults, harming)
        self._ticks = 0
        self._held = ""
        self._settings = {}
        self._linkages = {}
        self._angles = {}
        for name, potentiometer in self.potentiometers.items():
            # As the last flight left it, and the play with it.
            angle = float(drawing.uniform(-2.0, 2.0))
            self._settings[name] = SurfaceMovement(
                begin=-1.0, seconds=1.0, start=angle, target=angle
            )
            play = potentiometer.play
            self._linkages[name] = Linkage(play, angle + play * float(drawing.uniform(-0.5, 0.5)))
            self._angles[name] = angle
        self._attitude = BenchAttitude(self._hands)

    def _reverse(self, name: str) -> None:
        if name in GYROS:
            self.gyros = self.gyros.reversed(GYROS.index(name))
        elif name in ACCELEROMETERS:
            self.accelerometers = self.accelerometers.reversed(ACCELEROMETERS.index(name))
        elif name in self.pressures:
            self.pressures[name] = self.pressures[name].reversed()
        else:
            self.potentiometers[name] = self.potentiometers[name].reversed()

    # --- what is true ---------------------------------------------------------------------------

    @property
    def time(self) -> float:
        """Return the time since the box was switched on, s."""
        return self._ticks / VIRTUAL.bench_rate

    @property
    def ticks(self) -> int:
        return self._ticks

    def angle(self, channel: str) -> float:
        """Return where a surface or vane really is, deg, tremor included."""
        return self._angles[_surface(channel)]

    def target_angle(self, channel: str) -> float:
        """Return where the hand really has set a surface, or is about to, deg.

        Apart from what it was asked by the error of setting a protractor.
        """
        return self._settings[_surface(channel)].target

    @property
    def up_direction(self) -> tuple[float, float, float]:
        """Return the direction that points up once the aircraft lies still, in body axes."""
        return self._attitude.up_direction

    @property
    def busy(self) -> bool:
        now = self.time + 1e-9
        return (
            any(setting.end > now for setting in self._settings.values())
            or self._attitude.busy
            or self._pitot.is_blowing(now)
        )

    # --- what hands do --------------------------------------------------------------------------

    def set_angle(self, channel: str, angle: float, *, hold: bool = False) -> float:
        """Set one of the `POTENTIOMETERS` to an angle by hand; return how long it takes, s.

        The angle is as read off the protractor, deg; the stops end it. With `hold` it is kept in
        the hand, which trembles, until `release`; otherwise it is let go there. Raise FlightError
        if it is no surface.
        """
        name = _surface(channel)
        here = float(self._settings[name].angles(np.array([self.time]))[0])
        stop = self.potentiometers[name].travel
        error = float(self._hands.normal(0.0, self._setting_error))
        target = min(max(angle + error, -stop), stop)
        self._settings[name] = SurfaceMovement.create(self.time, here, target)
        self._held = name if hold else ""
        return self._settings[name].seconds

    def release(self) -> None:
        """Take the hand off a surface that is held; it stays where it is."""
        self._held = ""

    def move_to_position(self, position: Position) -> float:
        """Lay the aircraft in a position; return how long that takes, s."""
        self._held = ""
        return self._attitude.move_to_position(position, self.time) - self.time

    def rotate(self, channel: str, angle: float, *, seconds: float | None = None) -> float:
        """Turn the aircraft on its table; return how long it takes with all that goes before, s.

        The axis of ``p``, ``q`` or ``r`` is brought upright first where it is not. The angle is in
        deg, right-handed about the body axis: right wing down, nose up, nose right. The turn itself
        takes `seconds`, at about 30 deg/s by default. Raise FlightError if it is no axis, or the
        turn takes no time.
        """
        self._held = ""
        return self._attitude.rotate(channel, angle, seconds, self.time) - self.time

    def cover(self) -> None:
        self._pitot.covered = True

    def uncover(self) -> None:
        """Take the cover off: the wind is felt."""
        self._pitot.covered = False

    def blow(self) -> float:
        """Take the cover off and blow into the pitot; return how long that takes, s."""
        return self._pitot.blow(self._hands, self.time) - self.time

    # --- what the box converts ------------------------------------------------------------------

    def advance(self, ticks: int) -> FloatArray:
        """Go on for ticks, a hundred a second; return the converter's volts, shape (ticks, 20).

        V, in the order of `gsapp.virtual.instruments.DAQ_CHANNELS`.
        """
        times = (self._ticks + np.arange(ticks)) / VIRTUAL.bench_rate
        # Row by row, so that the numbers do not depend on how far it goes at a time.
        white = self._noise.standard_normal((ticks, len(DAQ_CHANNELS) + 1))
        supply = self._supply - 2e-5 * times
        supply = supply + self._supply_swing * np.sin(2.0 * np.pi * times / 90.0)
        columns = self._surfaces(times, supply, self._tremor(white[:, -1]))
        columns.update(self._inertial(times, white))
        columns.update(self._air(times, white))
        columns["excitation"] = supply
        columns["battery"] = np.full(ticks, 0.2 * VIRTUAL.battery_voltage)
        noise = {name: pot.noise for name, pot in self.potentiometers.items()}
        volts = np.empty((ticks, len(DAQ_CHANNELS)))
        for index, name in enumerate(DAQ_CHANNELS):
            own = columns[name] if name in columns else np.full(ticks, self._others[name])
            small = 0.0 if name in _OWN_NOISE_CHANNELS else noise.get(name, 0.5e-3)
            volts[:, index] = own + small * white[:, index]
        volts = self._harm.apply(volts)
        self._ticks += ticks
        return quantize(volts)

    def step(self, seconds: float) -> Block:
        """Go on for some time (s); return what a session's history would hold of it.

        ``<instrument>_volts`` of all instruments and ``excitation``, V.
        """
        first = self._ticks
        volts = self.advance(round(seconds * VIRTUAL.bench_rate))
        return Block(
            channels=(*(f"{name}_volts" for name in INSTRUMENTS), "excitation"),
            times=(first + np.arange(len(volts))) / VIRTUAL.bench_rate,
            values=volts[:, : len(INSTRUMENTS) + 1],
        )

    def _surfaces(
        self, times: FloatArray, supply: FloatArray, tremor: FloatArray
    ) -> dict[str, FloatArray]:
        columns = {}
        for name, potentiometer in self.potentiometers.items():
            setting, linkage = self._settings[name], self._linkages[name]
            if name != self._held and times.size and times[0] >= setting.end:
                # At rest, as nearly all are nearly always.
                self._angles[name] = setting.final_angle
                shaft = linkage.follow(np.array([setting.final_angle]))
            else:
                grip = np.ones(times.size) if name == self._held else setting.tremor_gain(times)
                angles = setting.angles(times) + grip * tremor
                shaft = linkage.follow(angles)
                self._angles[name] = float(angles[-1]) if times.size else self._angles[name]
            columns[name] = potentiometer.volts(shaft, supply)
        return columns

    def _inertial(self, times: FloatArray, white: FloatArray) -> dict[str, FloatArray]:
        force, rates = self._attitude.motion(times)
        gyros = self.gyros.volts(rates, times, _columns(white, GYROS))
        accelerometers = self.accelerometers.volts(force, times, _columns(white, ACCELEROMETERS))
        both = np.hstack([gyros, accelerometers])
        return dict(zip((*GYROS, *ACCELEROMETERS), both.T, strict=True))

    def _air(self, times: FloatArray, white: FloatArray) -> dict[str, FloatArray]:
        given = {
            "static_pressure": np.full(times.size, self.weather.pressure),
            "dynamic_pressure": self._pitot.pressure(times),
        }
        return {
            name: self.pressures[name].volts(values, white[:, DAQ_CHANNELS.index(name)])
            for name, values in given.items()
        }


_OWN_NOISE_CHANNELS = frozenset((*GYROS, *ACCELEROMETERS, "static_pressure", "dynamic_pressure"))


def _columns(white: FloatArray, names: Sequence[str]) -> FloatArray:
    return white[:, [DAQ_CHANNELS.index(name) for name in names]]


def _surface(channel: str) -> str:
    if channel not in POTENTIOMETERS:
        hint = did_you_mean(
            channel, POTENTIOMETERS, f"choose one of {', '.join(POTENTIOMETERS)}", most=1
        )
        raise FlightError(f"'{channel}' cannot be set manually; {hint}")
    return channel
