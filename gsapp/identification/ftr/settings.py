"""What the user chooses about Fourier transform regression."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field
from typing import Final, Literal

from gsapp.foundation import FlightError
from gsapp.identification.preparation_settings import PREPARATION

Gate = Literal["always", "maneuvers"]
"""Listen all the time, or only within the windows that are opened with `FTR.begin`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FrequencyBand:
    """Frequencies of the regressions of one axis, Hz."""

    lowest: float
    highest: float
    """Never below two cycles in the time listened to, whatever `lowest` says."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FTRSettings:
    """Settings of `FTR`; the defaults suit a 30 kg aircraft and maneuvers of some ten seconds."""

    longitudinal: FrequencyBand = field(
        default_factory=lambda: FrequencyBand(lowest=0.1, highest=2.0)
    )
    lateral: FrequencyBand = field(default_factory=lambda: FrequencyBand(lowest=0.1, highest=3.0))
    """The roll mode of the B777 lies at 2 Hz, its short period at 0.8 Hz."""
    spacing: float = 0.1
    """Of the frequencies, Hz. While less than ``1/spacing`` seconds were listened to, only every
    second, third, ... frequency is used: a record does not resolve closer ones."""
    forgetting: float | None = None
    """Time constant, s of listening, with which signals fade; None keeps them all."""
    gate: Gate = "always"
    record_length: float | None = None
    """Listening always and without forgetting, s after which a stretch of flight is closed, its
    information kept and a new one begun with a trim of its own; ``1/spacing`` by default."""
    updates: float = 10.0
    """Estimates a second."""
    longest_gap: float = 2.0
    """A pause longer than this, s, closes a record: trim may have changed."""
    lookback: float = 60.0
    """How far back, s, a window may begin."""
    minimum_speed: float | None = None
    """Calibrated airspeed below which samples do not count, m/s; by default 1.25 of the stall
    speed, so that the runs on the runway stay out (the B777 takes off at 1.2). Unless it is zero,
    neither do samples count within 5 m of the ground that the aircraft last stood on, where static
    pressure is measured: touching down bends all estimates."""
    speed: float | None = None
    """Airspeed that stands in where none is measured, m/s."""
    still: tuple[str, ...] = ()
    """Surfaces that did not move and need not be measured."""
    accelerometer_offset: float = PREPARATION.accelerometer_offset
    """How uncertain the zero of the accelerometers is, m/s^2. It goes into the bounds of CN_0, CA_0
    and CY_0: no mean can tell it from them."""
    signal_to_noise: float = 3.0
    """A derivative is unknown until what its variable did on its own, in the band, exceeds its
    noise there by this factor. At 3, noise takes 1/9 off a derivative; as much of that as is known
    is put back."""
    uncertain_share: float = 0.3
    """A derivative is unknown until its bound, times what its variable did, is below this share of
    what the coefficient did."""
    least_freedom: int = 8
    """A derivative is unknown until there are so many more real equations than unknowns."""

    def __post_init__(self) -> None:
        positive = {
            "spacing": self.spacing,
            "forgetting": self.forgetting,
            "record_length": self.record_length,
            "updates": self.updates,
            "longest_gap": self.longest_gap,
            "lookback": self.lookback,
            "speed": self.speed,
        }
        for name, value in positive.items():
            if value is not None and not (math.isfinite(value) and value > 0.0):
                raise FlightError(f"FTR needs a positive {name}, not {value:g}")
        for axis, band in (("longitudinal", self.longitudinal), ("lateral", self.lateral)):
            if not 0.0 < band.lowest < band.highest:
                raise FlightError(
                    f"the {axis} band of FTR runs from {band.lowest:g} to {band.highest:g} Hz; "
                    "give a lowest frequency above zero and below the highest"
                )
            if (band.highest - band.lowest) / self.spacing < 4:
                raise FlightError(
                    f"the {axis} band of FTR holds fewer than five frequencies; choose a spacing "
                    f"finer than {self.spacing:g} Hz or a wider band"
                )
            if band.highest / self.spacing > 1000:
                raise FlightError(
                    f"a spacing of {self.spacing:g} Hz gives more than 1000 frequencies up to "
                    f"{band.highest:g} Hz; choose a wider spacing"
                )
        if self.gate not in ("always", "maneuvers"):
            raise FlightError(f"the gate of FTR is 'always' or 'maneuvers', not '{self.gate}'")
        wrong = [name for name in self.still if name not in ("de", "da", "dr")]
        if wrong:
            raise FlightError(f"{', '.join(wrong)} is no surface; FTR supports de, da, dr")

    def as_table(self) -> dict[str, object]:
        """Return the settings as plain values, for a saved state."""
        return {**asdict(self), "still": list(self.still)}


@dataclass(frozen=True, slots=True, kw_only=True)
class FTRAlgorithmSettings:
    """Engineering choices, checked by `tests/bench/ftr.py`."""

    # Samples.
    channel_timeout: float = 0.5  # s without a sample: not measured.
    max_row_delay: float = 1.0  # s that a row waits for a late channel.
    max_filled_gap: float = 60.0  # s of a pause that are filled with missing rows.
    chunk_samples: int = 4096  # Samples given at a time.

    # On the ground.
    min_ground_clearance: float = 5.0  # m above take-off: wheels may touch below.
    pressure_time_constant: float = 0.5  # Time constant of the smoothing of static pressure, s.
    min_speed_ratio: float = 1.25  # To the stall speed: wheels may touch below.
    ground_speed_share: float = 0.5  # Of the lowest speed that counts: on the ground.

    # Regression.
    maneuver_update_rate: float = 2.0  # Updates a second: only the last one is kept.
    min_record_freedom: float = 4.0  # Equations beyond the unknowns, to keep a record.
    zero_column_tolerance: float = 1e-9  # Of its natural size: smaller is zero.
    collinearity_share: float = 0.1  # Of a variable's energy on its own.
    averaged_neighbors: int = 2  # Neighbors on either side that a level is averaged over.
    roughness_prior_weight: float = 8.0  # Equations, of the roughness of former records.
    min_roughness: float = 1e-120  # Rounding only; its inverse squared is finite.


FTR_ALGORITHM: Final = FTRAlgorithmSettings()
