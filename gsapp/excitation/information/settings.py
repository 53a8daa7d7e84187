"""Settings of what a flight has taught, and of forecasts of what cards would."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from gsapp.quantities.constants import DEGREE, GRAVITY


@dataclass(frozen=True, slots=True, kw_only=True)
class InformationSettings:
    """Engineering choices, checked by `tests/bench/information.py`."""

    # Bounds.
    unobservable_bound: float = 1e3
    """A derivative whose bound exceeds this counts as not seen at all."""
    max_iterations: int = 12  # Steps after which a fit is left as it is.
    prior_share: float = 0.5
    """Share of a derivative that it may be off where a stretch without an input is listened to."""
    min_prior: float = 0.05  # The least of it, for a derivative near zero.
    weight_iterations: int = 3  # Of weights and step, until what is left over hardly changes.
    min_variance: float = 1e-16  # Variance, SI: no response is known better.
    vane_noise: float = 0.1 * DEGREE
    """Noise of instruments of which the aircraft file says nothing: rad ..."""
    gyro_noise: float = 1.0 * DEGREE  # ... rad/s ...
    accelerometer_noise: float = 0.005 * GRAVITY  # ... and m/s^2.

    # What the flight taught.
    noise_time: float = 4.0  # Seconds before a maneuver in which the noise is heard.
    min_noise_time: float = 2.5  # s; a shorter stretch says too little of the noise.
    pilot_prior_weight: float = 4.0  # What is usual counts as much as so many maneuvers seen.
    unknown_noise_ratio: tuple[float, float] = 1.0, 0.9
    """Mean and spread of the logarithm of what air nobody has heard does to bounds. In calm air
    they are what the instruments allow; in gusts of 0.8 m/s ten times that."""
    climb_exclusion_time: float = 8.0
    """Seconds after take-off that are left out: flaps, full throttle, a steep climb."""
    ground_retention: float = 60.0
    """Seconds of rows kept on the ground: a take-off is recognized some time after it was."""
    forecast_delay: float = 4.0
    """Seconds of flight after a verdict at which the new outlook is shown. The work is done before
    that, in slices; where it is not, at that moment. So what is shown when does not depend on how
    fast the computer is."""
    first_noise_time: float = 20.0
    """Seconds of the first flying among which a quiet stretch is looked for."""

    # Forecasts.
    pre_input_trim_time: float = 1.0
    """Seconds of trim before an input, as detected maneuvers have them."""
    hand_time_constant: float = 0.1  # Time constant of a hand at the stick, s.
    sweep_band: tuple[float, float] = (0.3, 2.0)  # Frequencies of a sweep, Hz.
    max_relative_bound: float = 1.0  # A bound as large as its derivative says nothing yet.
    execution_count: int = 8
    """Ways in which one card may turn out; each costs a run of the model with all sensitivities."""
    draw_count: int = 200
    """Of executions and surprises, from which the quantiles of a bound are taken."""
    band_quantiles: tuple[float, float, float] = (0.1, 0.5, 0.9)
    """Quantiles of a bound: the ends of the band, and what is expected."""
    speed_step: float = 0.5  # Speeds are rounded to so much, m/s: nearer ones fly alike.
    max_repeats: int = 6  # Nobody plans further ahead with one card.

    # Time left.
    default_flight_duration: float = 420.0
    """A flight lasts seven minutes at the most, s, where nobody says otherwise."""
    landing_reserve: float = 60.0  # To come home and land, with one approach gone around, s.
    default_maneuver_interval: float = 35.0
    """From one maneuver to the next where nothing is known yet, s: nine to twelve in a flight."""
    engine_running_speed: float = 100.0  # Above this speed, rad/s, an engine runs.
    closed_throttle: float = 0.02
    """Throttle below which an engine without a tachometer is taken to stand still."""
    fuel_flow_time: float = 30.0  # Seconds of flight from which on its own fuel flow counts.
    min_lap: float = 10.0  # Laps shorter than this, s, were none: two inputs on one leg ...
    max_lap: float = 120.0  # ... nor were longer ones: a pause.


INFORMATION: Final = InformationSettings()
