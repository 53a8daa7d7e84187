"""Settings of what a flight has taught, and of forecasts of what cards would."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from gsapp.quantities.constants import DEGREE, GRAVITY


@dataclass(frozen=True, slots=True, kw_only=True)
class InformationSettings:
    """Engineering choices, checked by `tests/bench/information.py`."""

    # Bounds.
    unobservable_bound: float = 1e3  # A larger bound: derivative not observable.
    max_iterations: int = 12  # Steps after which a fit is left as it is.
    prior_share: float = 0.5  # Of a derivative's value: its uncertainty without an input.
    min_prior: float = 0.05  # The least of it, for a derivative near zero.
    weight_iterations: int = 3  # Of weights and step, until what is left over hardly changes.
    min_variance: float = 1e-16  # Variance, SI: no response is known better.
    vane_noise: float = 0.1 * DEGREE  # Of instruments without stated noise: rad ...
    gyro_noise: float = 1.0 * DEGREE  # ... rad/s ...
    accelerometer_noise: float = 0.005 * GRAVITY  # ... and m/s^2.

    # What the flight taught.
    noise_time: float = 4.0  # Seconds before a maneuver in which the noise is heard.
    min_noise_time: float = 2.5  # s; a shorter stretch says too little of the noise.
    pilot_prior_weight: float = 4.0  # What is usual counts as much as so many maneuvers seen.
    unknown_noise_ratio: tuple[float, float] = 1.0, 0.9
    """Mean and spread of the logarithm of what unknown air does to bounds. In calm air they are
    what the instruments allow; in gusts of 0.8 m/s ten times that."""
    climb_exclusion_time: float = 8.0  # s after take-off: flaps, throttle, steep climb.
    ground_retention: float = 60.0  # s of rows kept on the ground until take-off is found.
    forecast_delay: float = 4.0
    """s of flight after a verdict until the new forecast is shown, whatever the speed of the
    computer: work is done in slices before, or at that moment."""
    first_noise_time: float = 20.0  # s of first flight in which a quiet segment is found.

    # Forecasts.
    pre_input_trim_time: float = 1.0  # s of trim before an input, as detected.
    hand_time_constant: float = 0.1  # Time constant of a hand at the stick, s.
    sweep_band: tuple[float, float] = (0.3, 2.0)  # Frequencies of a sweep, Hz.
    max_relative_bound: float = 1.0  # A bound as large as its derivative says nothing yet.
    execution_count: int = 8  # Simulated executions of a card, with sensitivities.
    draw_count: int = 200  # Random draws for the quantiles of a bound.
    band_quantiles: tuple[float, float, float] = (0.1, 0.5, 0.9)  # Of a bound: band and median.
    speed_step: float = 0.5  # Speeds are rounded to so much, m/s: nearer ones fly alike.
    max_repeats: int = 6  # Nobody plans further ahead with one card.

    # Time left.
    default_flight_duration: float = 420.0  # s, where nothing else is said.
    landing_reserve: float = 60.0  # To come home and land, with one approach gone around, s.
    default_maneuver_interval: float = 35.0  # s, at first: nine to twelve in a flight.
    engine_running_speed: float = 100.0  # Above this speed, rad/s, an engine runs.
    closed_throttle: float = 0.02  # Below it, an engine without tachometer is stopped.
    fuel_flow_time: float = 30.0  # Seconds of flight from which on its own fuel flow counts.
    min_lap: float = 10.0  # Laps shorter than this, s, were none: two inputs on one leg ...
    max_lap: float = 120.0  # ... nor were longer ones: a pause.


INFORMATION: Final = InformationSettings()
