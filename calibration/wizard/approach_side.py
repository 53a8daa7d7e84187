"""From which side a rest was reached: slop is taken up by the last movement, not by the first."""

from __future__ import annotations

import math
from typing import Literal

from calibration.wizard.settings import WIZARD

ApproachSide = Literal["below", "above"]


class ApproachTracker:
    """Remembers where volts were before they came to rest.

    It is fed means over short, equal times, so that noise is small against `apart`.
    """

    def __init__(self) -> None:
        self._means: list[float] = []

    def restart(self) -> None:
        """Forget where the volts were: from here on they must move anew."""
        self._means.clear()

    def feed(self, mean: float) -> None:
        if math.isfinite(mean):
            self._means.append(mean)
            del self._means[: -WIZARD.max_means]

    def approach_side(self, volts: float, apart: float) -> ApproachSide | None:
        """Return the side from which the volts last came to a rest at `volts`.

        Parameters
        ----------
        volts : float
            Where they rest, V.
        apart : float
            How far away from there counts as elsewhere, V.

        Returns
        -------
        {"below", "above"} or None
            None where they were nowhere else since the last restart.
        """
        for mean in reversed(self._means):
            if abs(mean - volts) > apart:
                return "below" if mean < volts else "above"
        return None
