"""Settings of the virtual aircraft, its pilot, its calibration bench and its downlink."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from gsapp.quantities.constants import DEGREE


@dataclass(frozen=True, slots=True, kw_only=True)
class VirtualAircraftSettings:
    """Engineering choices unless a source is named."""

    # Airframe.
    wheel_grip_speed: float = 0.12  # m/s, of most grip: fits a step of 10 ms.
    vane_friction_speed: float = 3.0  # m/s: below, friction holds the vanes.
    fan_speedup: float = 0.3  # At 120 ft/s: 19,000 rpm on the ground, 25,000 in the air.
    pot_supply: float = 4.96  # V, of the day; certificates were taken at 5 V.
    rigging_std: float = 0.002  # Standard deviation by which left and right surface differ, rad.
    settling_time: float = 2.0  # s on the wheels before the box is switched on.
    fan_speedup_speed: float = 36.576  # Airspeed at which it is so, m/s.
    low_pass: float = 50.0  # Hz, of inputs that the aircraft file does not describe.
    turn_bank: float = math.radians(25.0)  # rad, of the turn that tells the elevator's pull.
    max_flight_duration: float = 11.0 * 60.0  # s: the recorder's memory (Seanor 3.5).

    # Pilot.
    upwind_leg_across: float = 25.0  # The upwind leg lies this far beside the runway, m.
    aim_point_along: float = -60.0  # m, of the approach, from the runway's middle.
    takeoff_start_along: float = -110.0  # Where the take-off run begins, m.
    max_legs: int = 60  # A pilot who has not found a quiet leg by then lands.
    pilot_position_across: float = -12.0  # m, from the runway, off the pattern.
    max_planned_time: float = 6 * 3600.0  # s of a whole flight.
    card_settling_time: float = 5.0  # s of a leg before the input of a test card.
    card_quiet_time: float = 4.0  # s that the sticks are left alone after it.
    hanging_angle: float = math.radians(8.0)  # rad, of pitch above path: seen to hang.

    # Training with keys.
    upset_bank: float = 55.0 * DEGREE  # rad: beyond, wings first, without pitch.
    steady_climb: float = 3.0  # m/s.
    intercept_range: float = 60.0  # From so far beside a leg's line, m, it is flown to at 45 deg.
    on_line_distance: float = 20.0  # m.
    steady_bank: float = 15.0 * DEGREE  # Bank below which the aircraft is steady, rad.
    max_intercept: float = 75.0 * DEGREE  # Greatest angle to a leg on the way to it, rad.
    max_joining_bank: float = 35.0 * DEGREE  # Greatest bank on the way to a leg, rad.
    key_timeout: float = 2.0  # s without keys until the built-in pilot takes over.
    look_ahead: float = 2.0  # The built-in pilot takes the aircraft where in so many seconds ...
    min_height: float = 10.0  # ... it would be lower than this, m.
    handover_rate: float = 4.0  # Share of full stick per second while the sticks change hands.
    stick_rate: float = 8.0  # Full stick per second, as with a quick thumb.
    throttle_rate: float = 0.7  # Share of the throttle's travel per second.
    min_key_travel: float = 0.05  # Share of full stick: less would not be seen on any surface.
    key_travel: float = 0.25  # Share of full stick that a key gives until another is chosen.

    # Calibration bench.
    positioning_std: float = 0.8  # About either axis of a position, deg.
    table_turn_std: float = 0.12  # Standard deviation of each end of a turn of the table, deg.
    laying_time: float = 3.0  # Seconds that it takes to lay the aircraft down.
    rest_before_turn: float = 3.0  # Seconds of rest before a turn.
    table_turn_rate: float = 30.0  # Mean rate of a turn of the table, deg/s.
    min_turn_time: float = 2.0  # Seconds that a turn takes at least.
    angle_setting_std: float = 0.05  # Of a digital protractor set and read, deg.
    tremor_std: float = 0.02  # Standard deviation of a surface held by hand, deg.
    tremor_frequency: float = 8.0  # Frequency of that tremor, Hz.
    tremor_decay: float = 0.9  # Radius of its poles as a sampled autoregression.
    surface_rate: float = 25.0  # deg/s of the way toward the angle; the rest is creeping up to it.
    nominal_supply: float = 5.0  # Supply of a potentiometer, V.
    bad_contact_std: float = 0.04  # A bad contact: standard deviation, V ...
    bad_contact_drop: float = 0.6  # ... and how far the volts fall when it is lost, V.
    clipped_margin: tuple[float, float] = (0.25, 0.45)  # V from the end of the converter at first.
    breath_delay: float = 0.5  # Seconds before a breath into the pitot.
    bench_rate: int = 100  # Samples a second.
    battery_voltage: float = 12.5  # Voltage of the battery, V.

    # Downlink.
    thin_rate: int = 4600  # What 57,600 baud carry, with room for the radio's own needs.
    full_rate: int = 100_000  # Bytes per second of a full link.
    ticks_ahead: int = 4  # Ticks flown ahead of the clock ...
    fast_ticks_ahead: int = 10  # ... and above double speed.
    burst_time: float = 3.0  # Credit kept for a burst, s at 100 bytes a second.
    heartbeat_interval: float = 1.0  # Seconds between heartbeats.
    travel_time_us: float = 12_000.0  # Delay of a message, microseconds: constant part ...
    jitter_us: float = 2_000.0  # ... and mean of the exponential part.
    linger_time: float = 10.0  # s without a request until the box is switched off.


VIRTUAL: Final = VirtualAircraftSettings()
