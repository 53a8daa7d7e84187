"""What the box puts into each MAVLink message, and how often.

The layout is fixed: ``DEBUG_FLOAT_ARRAY`` named ``daq`` carries the converter's volts in the
order of `gsapp.virtual.instruments.DAQ_CHANNELS`, everything else is what an autopilot-like board
knows besides. Times are since the box was switched on.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from gsapp.decoding.dialect import dialect as load_dialect

dialect = load_dialect()
Values = Mapping[str, float]
Message = Any
"""A message object of pymavlink, which has no types."""
TICK_RATE = 100
"""Ticks of the box per second."""

_PWM_CENTER, _PWM_HALF_RANGE = 1500.0, 500.0


@dataclass(frozen=True, slots=True, kw_only=True)
class OnboardSample:
    """What the box knows at one tick."""

    number: int  # Since the box was switched on, 100 a second.
    volts: Sequence[float]  # The converter's readings, in the order of the layout.
    values: Values  # Everything else by channel id, SI units.
    unix_us: int  # Time of day, microseconds since 1970.
    stamp_us: int | None = None  # What the box writes as its time; None where it is right.

    @property
    def micros(self) -> int:
        return self.number * (1_000_000 // TICK_RATE) if self.stamp_us is None else self.stamp_us

    @property
    def millis(self) -> int:
        return self.micros // 1000


def _pwm(share: float) -> int:
    """Return the pulse, us, for a share of full travel between -1 and 1."""
    return round(_PWM_CENTER + _PWM_HALF_RANGE * min(max(share, -1.2), 1.2))


def _pwm_unsigned(share: float) -> int:
    """Return the pulse, us, for a share between 0 and 1."""
    return _pwm(2.0 * share - 1.0)


def daq(tick: OnboardSample) -> Message:
    """Pack the converter's volts."""
    data = [float(volt) for volt in tick.volts]
    data += [0.0] * (58 - len(data))
    return dialect.MAVLink_debug_float_array_message(tick.micros, b"daq", 0, data)


def attitude(tick: OnboardSample) -> Message:
    """Pack attitude and rates as estimated on board."""
    v = tick.values
    return dialect.MAVLink_attitude_message(
        tick.millis, v["phi"], v["theta"], _wrap_angle(v["psi"]), v["p"], v["q"], v["r"]
    )


def servo_output(tick: OnboardSample) -> Message:
    """Pack the pulses to the servos: aileron, elevator, throttle, rudder, flap."""
    v = tick.values
    return dialect.MAVLink_servo_output_raw_message(
        tick.micros & 0xFFFFFFFF,
        0,
        _pwm(v["servo_aileron"]),
        _pwm(v["servo_elevator"]),
        _pwm_unsigned(v["throttle_command"]),
        _pwm(v["servo_rudder"]),
        _pwm_unsigned(v["servo_flap"]),
        *[0] * 3,
    )


def rc_channels(tick: OnboardSample) -> Message:
    """Pack the transmitter's sticks: roll, pitch, throttle, yaw, rate switch."""
    v = tick.values
    pulses = [
        _pwm(v["stick_roll"]),
        _pwm(v["stick_pitch"]),
        _pwm_unsigned(v["throttle_command"]),
        _pwm(v["stick_yaw"]),
        _pwm_unsigned(v["rate_switch"]),
    ]
    rssi = round(254 * min(max(v["rc_rssi"], 0.0), 1.0))
    return dialect.MAVLink_rc_channels_message(tick.millis, 5, *pulses, *[0] * 13, rssi)


def rpm_left(tick: OnboardSample) -> Message:
    """Pack the left engine's speed, rpm."""
    return dialect.MAVLink_raw_rpm_message(0, tick.values["rpm_left"] * 30.0 / math.pi)


def rpm_right(tick: OnboardSample) -> Message:
    """Pack the right engine's speed, rpm."""
    return dialect.MAVLink_raw_rpm_message(1, tick.values["rpm_right"] * 30.0 / math.pi)


def scaled_pressure(tick: OnboardSample) -> Message:
    """Pack the pressures, hPa, and the temperature, centidegrees Celsius."""
    v = tick.values
    return dialect.MAVLink_scaled_pressure_message(
        tick.millis,
        v["static_pressure"] / 100.0,
        v["dynamic_pressure"] / 100.0,
        round((v["temperature"] - 273.15) * 100.0),
        0,
    )


def vfr_hud(tick: OnboardSample) -> Message:
    """Pack airspeed, heading, throttle, altitude and climb."""
    v = tick.values
    return dialect.MAVLink_vfr_hud_message(
        v["Vc"],
        v["ground_speed"],
        round(math.degrees(v["psi"])) % 360,
        round(100.0 * v["throttle"]),
        v["altitude"],
        v["climb_rate"],
    )


def global_position(tick: OnboardSample) -> Message:
    """Pack position and velocity."""
    v = tick.values
    return dialect.MAVLink_global_position_int_message(
        tick.millis,
        round(math.degrees(v["latitude"]) * 1e7),
        round(math.degrees(v["longitude"]) * 1e7),
        round(1000.0 * (v["height"] + v["elevation"])),
        round(1000.0 * v["height"]),
        round(100.0 * v["velocity_north"]),
        round(100.0 * v["velocity_east"]),
        round(-100.0 * v["climb_rate"]),
        round(math.degrees(v["psi"]) * 100.0) % 36000,
    )


def sys_status(tick: OnboardSample) -> Message:
    """Pack the battery and the load."""
    v = tick.values
    sensors = (
        dialect.MAV_SYS_STATUS_SENSOR_3D_GYRO
        | dialect.MAV_SYS_STATUS_SENSOR_3D_ACCEL
        | dialect.MAV_SYS_STATUS_SENSOR_ABSOLUTE_PRESSURE
        | dialect.MAV_SYS_STATUS_SENSOR_DIFFERENTIAL_PRESSURE
    )
    return dialect.MAVLink_sys_status_message(
        sensors,
        sensors,
        sensors,
        round(1000.0 * v["cpu_load"]),
        round(1000.0 * v["battery"]),
        round(100.0 * v["battery_current"]),
        round(100.0 * v["battery_remaining"]),
        *[0] * 6,
    )


def heartbeat(tick: OnboardSample) -> Message:
    """Pack the sign of life; flown by hand."""
    return _heartbeat(flying=tick.values["armed"] > 0.5)


def landed_heartbeat() -> Message:
    """Pack the sign of life after the flight."""
    return _heartbeat(flying=False)


def _heartbeat(*, flying: bool) -> Message:
    mode = dialect.MAV_MODE_FLAG_MANUAL_INPUT_ENABLED
    if flying:
        mode |= dialect.MAV_MODE_FLAG_SAFETY_ARMED
    return dialect.MAVLink_heartbeat_message(
        dialect.MAV_TYPE_FIXED_WING,
        dialect.MAV_AUTOPILOT_GENERIC,
        mode,
        0,
        dialect.MAV_STATE_ACTIVE if flying else dialect.MAV_STATE_STANDBY,
        3,
    )


def system_time(tick: OnboardSample) -> Message:
    """Pack the time of day."""
    return dialect.MAVLink_system_time_message(tick.unix_us, tick.millis)


def status_text(text: str, severity: int = dialect.MAV_SEVERITY_INFO) -> Message:
    """Pack one line for the crew; 50 characters go into one message."""
    return dialect.MAVLink_statustext_message(severity, text.encode("ascii", "replace")[:50])


def _wrap_angle(angle: float) -> float:
    return math.remainder(angle, 2.0 * math.pi)


@dataclass(frozen=True, slots=True, kw_only=True)
class MessageSlot:
    """One message of a layout: sent at every tick ``n`` with ``n % every == offset``."""

    pack: Callable[[OnboardSample], Message]
    every: int
    offset: int = 0


_RATES: tuple[tuple[Callable[[OnboardSample], Message], float, float], ...] = (
    (daq, 100, 20),
    (attitude, 50, 5),
    (servo_output, 50, 5),
    (rc_channels, 20, 2),
    (rpm_left, 10, 2),
    (rpm_right, 10, 2),
    (scaled_pressure, 10, 0),
    (vfr_hud, 5, 0),
    (sys_status, 1, 0.5),
    (heartbeat, 1, 1),
    (system_time, 1, 0),
    (global_position, 5, 1),
)
"""Each message with its rate over a network, and over a 57,600-baud radio; 0 is not sent, Hz."""


def telemetry_layout(
    *, thin: bool, attitude_sent: bool, position_sent: bool
) -> tuple[MessageSlot, ...]:
    """Return what is sent when, the converter's volts first.

    `thin` is for a 57,600-baud radio, instead of 460,800 baud or a network. Attitude and position
    are sent where the board knows them; the source's aircraft knew neither.
    """
    known: dict[Callable[[OnboardSample], Message], bool] = {
        attitude: attitude_sent,
        global_position: position_sent,
    }
    rates = [
        (pack, thin_rate if thin else full_rate)
        for pack, full_rate, thin_rate in _RATES
        if known.get(pack, True)
    ]
    slots = []
    for index, (pack, rate) in enumerate((pack, rate) for pack, rate in rates if rate):
        every = round(TICK_RATE / rate)
        # Spread over the ticks, so that a slow radio never has to swallow all at once.
        slots.append(MessageSlot(pack=pack, every=every, offset=(3 * index) % every))
    return tuple(slots)


@dataclass(frozen=True, slots=True, kw_only=True)
class Packet:
    """What leaves the box at one tick."""

    time: float  # s since the box was switched on.
    stamp_us: int  # The box's time of day, microseconds since 1970.
    live_frames: tuple[bytes, ...]  # Frames for the link.
    onboard_frames: tuple[bytes, ...]  # Frames for the on-board log; empty where there is none.
    phase: str  # What the pilot is doing.


class FramePacker:
    """Packs messages into MAVLink 2 frames with a sequence number of their own."""

    def __init__(self) -> None:
        self._mavlink = dialect.MAVLink(None, srcSystem=1, srcComponent=1)

    def pack(self, message: Message) -> bytes:
        """Return the frame of a message; the sequence number goes on by one."""
        frame = bytes(message.pack(self._mavlink))
        self._mavlink.seq = (self._mavlink.seq + 1) % 256
        return frame


class FrameScheduler:
    """Turns ticks into the frames of one link.

    Two boxes with different layouts make the live link and the on-board log of one flight.
    """

    def __init__(self, slots: Sequence[MessageSlot]) -> None:
        self._slots = tuple(slots)
        self._packer = FramePacker()

    def frames(self, tick: OnboardSample) -> list[bytes]:
        """Return the frames due at this tick, in the order in which they are sent."""
        return [
            self._packer.pack(slot.pack(tick))
            for slot in self._slots
            if tick.number % slot.every == slot.offset
        ]

    def pack_text(self, text: str) -> bytes:
        return self._packer.pack(status_text(text))

    def pack(self, message: Message) -> bytes:
        return self._packer.pack(message)
