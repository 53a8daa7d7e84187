"""A virtual aircraft on the ground, and the hands that calibrate its instruments.

Everything about it is drawn from a seed: how each potentiometer is bent and how much play its
linkage has, where gyros and accelerometers stand, the weather. What is true is there for tests to
ask; what the ground gets are the converter's volts, a hundred times a second. How far it is asked
to go on at a time changes nothing.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from calibration import load_certificates
from calibration.adc import quantize
from calibration.inertial import Position
from gsapp.aircraft import load_aircraft
from gsapp.foundation import FlightError
from gsapp.foundation.name_suggestions import did_you_mean
from gsapp.quantities import INSTRUMENTS, Block, FloatArray
from gsapp.virtual.ad_converter import DAQ_CHANNELS
from gsapp.virtual.bench.bench_attitude import BenchAttitude
from gsapp.virtual.bench.bench_faults import BenchFault
from gsapp.virtual.bench.bench_weather import BenchWeather, Pitot
from gsapp.virtual.bench.fault_injection import BenchFaultInjector
from gsapp.virtual.bench.operator_motion import (
    ANGLE_SETTING_ERROR,
    OperatorTremor,
    SurfaceMovement,
)
from gsapp.virtual.bench.potentiometer import (
    POTENTIOMETERS,
    Linkage,
    Potentiometer,
)
from gsapp.virtual.bench.transducers import (
    ACCELEROMETERS,
    GYROS,
    SensorTriad,
    Transducer,
    sample_accelerometers,
    sample_gyros,
)

BENCH_SAMPLE_RATE = 100
"""Samples a second."""
_BATTERY = 12.5


class VirtualBench:
    """An aircraft on the ground whose surfaces are moved by hand.

    Parameters
    ----------
    seed : int
        Same seed, same aircraft, same weather, same hands.
    aircraft : str
        Whose gyros and accelerometers; a file, or the name of a shipped one.
    setting_error : float
        Standard deviation with which the protractor is set, deg.

    Attributes
    ----------
    potentiometers : dict of str to Potentiometer
        As they really are, by channel, reversed ones included.
    gyros, accelerometers : SensorTriad
        As they really are; deg/s and g.
    pressures : dict of str to Transducer
        As they really are; Pa.
    """

    def __init__(
        self,
        seed: int = 0,
        *,
        faults: Sequence[BenchFault] = (),
        aircraft: str = "b777",
        setting_error: float = ANGLE_SETTING_ERROR,
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
        self._tremor = OperatorTremor(1.0 / BENCH_SAMPLE_RATE)
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
        """Mount an instrument the other way round."""
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
        return self._ticks / BENCH_SAMPLE_RATE

    @property
    def ticks(self) -> int:
        """Return how many samples there were."""
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
        """Return whether a hand is still at it."""
        now = self.time + 1e-9
        return (
            any(setting.end > now for setting in self._settings.values())
            or self._attitude.busy
            or self._pitot.is_blowing(now)
        )

    # --- what hands do --------------------------------------------------------------------------

    def set_angle(self, channel: str, angle: float, *, hold: bool = False) -> float:
        """Set a surface or vane to an angle by hand.

        Parameters
        ----------
        channel : str
            One of `POTENTIOMETERS`.
        angle : float
            As read off the protractor, deg. The stops end it.
        hold : bool
            Keep it in the hand, which trembles, until `release`; otherwise it is let go there.

        Returns
        -------
        float
            How long it takes, s.

        Raises
        ------
        FlightError
            If it is no surface.
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
        """Turn the aircraft on its table.

        Parameters
        ----------
        channel : str
            ``p``, ``q`` or ``r``: the axis, which is brought upright first where it is not.
        angle : float
            deg, right-handed about the body axis: right wing down, nose up, nose right.
        seconds : float, optional
            For the turn itself; about 30 deg/s by default.

        Returns
        -------
        float
            How long it takes with all that goes before, s.

        Raises
        ------
        FlightError
            If it is no axis, or the turn takes no time.
        """
        self._held = ""
        return self._attitude.rotate(channel, angle, seconds, self.time) - self.time

    def cover(self) -> None:
        """Put the cover on the pitot."""
        self._pitot.covered = True

    def uncover(self) -> None:
        """Take the cover off: the wind is felt."""
        self._pitot.covered = False

    def blow(self) -> float:
        """Take the cover off and blow into the pitot; return how long that takes, s."""
        return self._pitot.blow(self._hands, self.time) - self.time

    # --- what the box converts ------------------------------------------------------------------

    def advance(self, ticks: int) -> FloatArray:
        """Go on and return the converter's volts.

        Parameters
        ----------
        ticks : int
            A hundred a second.

        Returns
        -------
        ndarray, shape (ticks, 20)
            V, in the order of `gsapp.virtual.ad_converter.DAQ_CHANNELS`.
        """
        times = (self._ticks + np.arange(ticks)) / BENCH_SAMPLE_RATE
        # Row by row, so that the numbers do not depend on how far it goes at a time.
        white = self._noise.standard_normal((ticks, len(DAQ_CHANNELS) + 1))
        supply = self._supply - 2e-5 * times
        supply = supply + self._supply_swing * np.sin(2.0 * np.pi * times / 90.0)
        columns = self._surfaces(times, supply, self._tremor(white[:, -1]))
        columns.update(self._inertial(times, white))
        columns.update(self._air(times, white))
        columns["excitation"] = supply
        columns["battery"] = np.full(ticks, 0.2 * _BATTERY)
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
        """Go on for some time; return what a session's history would hold of it.

        Returns
        -------
        Block
            ``<instrument>_volts`` of all instruments and ``excitation``, V.
        """
        first = self._ticks
        volts = self.advance(round(seconds * BENCH_SAMPLE_RATE))
        return Block(
            channels=(*(f"{name}_volts" for name in INSTRUMENTS), "excitation"),
            times=(first + np.arange(len(volts))) / BENCH_SAMPLE_RATE,
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
        raise FlightError(f"'{channel}' cannot be set by hand; {hint}")
    return channel
