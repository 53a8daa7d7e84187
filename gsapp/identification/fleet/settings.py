"""Settings of the analysis of fleets."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True, kw_only=True)
class FleetSettings:
    """Engineering choices; none was tuned on the fleets of the tests."""

    # Mixed model.
    min_slope_groups: int = 3  # Airframes that it takes to let their slopes differ ...
    min_slope_points: int = 3  # ... each with values at so many different conditions.
    confidence: float = 0.95  # Of intervals.
    least_std_share: float = 1e-3
    most_std_share: float = 30.0
    """Of the spread of all values: the least scatter of values that have no bounds, and the most
    of any effect."""
    likelihood_tolerance: float = 1e-4
    """Of twice the log-likelihood, within which two searches have found the same variances."""

    # Change over time.
    min_flights: int = 8  # Of an airframe: fewer give too few permutations and dates.
    min_side_flights: int = 2  # Before and after a step.
    change_significance: float = 0.05
    """For any false change among all series that are searched together."""
    permutations: int = 2000  # At least; more for many series, so that p can become small enough.
    max_permutations: int = 20_000
    enough_permutations: int = 20  # That reach what was found: it is no change, whatever follows.
    date_probability: float = 0.95  # Of the dates between the bounds of a change.
    least_probability: float = 1e-4  # Of a moment that counts, over that of the likeliest.
    kind_probability: float = 0.9  # From which a change is called a step, or a drift.


FLEET: Final = FleetSettings()
