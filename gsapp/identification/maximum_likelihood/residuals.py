"""What a fit leaves of each maneuver, and what the residuals tell."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from gsapp.identification.maximum_likelihood.problem import ManeuverProblem
from gsapp.identification.maximum_likelihood.settings import MLSettings
from gsapp.identification.statistics import Turbulence, Whiteness, turbulence
from gsapp.identification.stuck import unseen_surfaces, unseen_words
from gsapp.quantities import FloatArray

COLORED: Final = 4.0
"""Power at low frequency over that of white noise from which on the crew is told."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Part:
    """One maneuver of a solution.

    Attributes
    ----------
    maneuver : str
    times : ndarray, shape (n,)
        s; only samples of its segments.
    responses : tuple of str
    measured, computed : ndarray, shape (n, n_responses)
        NaN in `measured` where a sample does not count.
    weights : ndarray, shape (n_responses, n_responses)
        W: the inverse of the noise covariance; where the user gave weights, those, scaled to the
        noise there is.
    segments : tuple of slice
        Stretches of contiguous samples.
    sensitivities : ndarray, shape (n, n_responses, n_columns)
    columns : ndarray of int, shape (n_columns,)
        Where each column stands among the solution's `names`.
    whiteness : tuple of Whiteness
        Of the residuals of each response.
    """

    maneuver: str
    times: FloatArray
    responses: tuple[str, ...]
    measured: FloatArray
    computed: FloatArray
    weights: FloatArray
    segments: tuple[slice, ...]
    sensitivities: FloatArray
    columns: np.ndarray[tuple[int], np.dtype[np.intp]]
    whiteness: tuple[Whiteness, ...]

    @property
    def residuals(self) -> FloatArray:
        """Return measured minus computed, NaN where a sample does not count."""
        return self.measured - self.computed


def gusts_in(one: ManeuverProblem, part: Part) -> list[Turbulence]:
    """Return the gusts that the residuals of a maneuver show."""
    sensors = one.maneuver.aircraft.sensors
    found = turbulence(
        dict(zip(part.responses, part.residuals.T, strict=True)),
        dt=one.dt,
        V=float(one.motion.state("V").mean()),
        alpha=float(one.motion.state("alpha").mean()),
        arms=(sensors.alpha_vane.position[0], sensors.beta_vane.position[0]),
        segments=None if len(part.segments) == 1 else part.segments,
    )
    return [gust for gust in found if gust.detected]


def color_warnings(part: Part) -> list[str]:
    """Return which residuals of a maneuver are far from white, in a sentence."""
    colored = _colored(part)
    if not colored:
        return []
    told = ", ".join(f"{name} ({inflation:.0f} times)" for name, inflation in colored.items())
    return [
        f"the residuals of {told} in maneuver {part.maneuver} are colored: "
        "their power at low frequency exceeds that of white noise; the bounds allow for it"
    ]


def moved_unseen(one: ManeuverProblem, part: Part, settings: MLSettings) -> str:
    """Return that a surface moved which nobody saw, or nothing.

    A surface without a record, or with a stuck one, is taken as still. Where it was not, its
    share goes into the derivatives of all others, with bounds that know nothing of it.
    """
    colored = _colored(part)
    unseen = dict(unseen_surfaces(one.maneuver, settings.axis, settings.stand_ins))
    if not colored or not unseen:
        return ""
    return unseen_words(
        unseen, f"and the residuals of {', '.join(colored)} hold motion that no record explains"
    )


def _colored(part: Part) -> dict[str, float]:
    """Return the responses with residuals far from white, with the inflation of each."""
    return {
        name: test.inflation
        for name, test in zip(part.responses, part.whiteness, strict=True)
        if not test.white and test.inflation > COLORED
    }
