"""What a fit leaves of each maneuver, and what the residuals tell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gsapp.identification.maximum_likelihood.algorithm_settings import ML_ALGORITHM
from gsapp.identification.maximum_likelihood.problem import ManeuverProblem
from gsapp.identification.maximum_likelihood.settings import MLSettings
from gsapp.identification.statistics import (
    TurbulenceDetection,
    Whiteness,
    detect_turbulence,
    response_fit,
)
from gsapp.identification.stuck_channels import unmeasured_surfaces, unmeasured_surfaces_text
from gsapp.quantities import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ManeuverResiduals:
    """One maneuver of a solution."""

    maneuver: str
    times: FloatArray  # Shape (n,). s; only samples of its segments.
    responses: tuple[str, ...]
    measured: FloatArray
    computed: FloatArray
    """Shape (n, n_responses). NaN in `measured` where a sample does not count."""
    weights: FloatArray
    """Shape (n_responses, n_responses). W: the inverse of the noise covariance; where the user gave
    weights, those, scaled to the noise there is."""
    segments: tuple[slice, ...]  # Stretches of contiguous samples.
    sensitivities: FloatArray  # Shape (n, n_responses, n_columns).
    columns: np.ndarray[tuple[int], np.dtype[np.intp]]
    """Shape (n_columns,). Where each column stands among the solution's `names`."""
    whiteness: tuple[Whiteness, ...]  # Of the residuals of each response.

    @property
    def residuals(self) -> FloatArray:
        """Return measured minus computed, NaN where a sample does not count."""
        return self.measured - self.computed


def detect_gusts(one: ManeuverProblem, part: ManeuverResiduals) -> list[TurbulenceDetection]:
    """Return the gusts that the residuals of a maneuver show."""
    sensors = one.maneuver.aircraft.sensors
    found = detect_turbulence(
        dict(zip(part.responses, part.residuals.T, strict=True)),
        dt=one.dt,
        V=float(one.motion.state("V").mean()),
        alpha=float(one.motion.state("alpha").mean()),
        arms=(sensors.alpha_vane.position[0], sensors.beta_vane.position[0]),
        segments=None if len(part.segments) == 1 else part.segments,
    )
    return [gust for gust in found if gust.detected]


def color_warnings(part: ManeuverResiduals) -> list[str]:
    """Return which residuals of a maneuver are far from white, in a sentence."""
    colored = _colored_responses(part)
    if not colored:
        return []
    told = ", ".join(f"{name} ({inflation:.0f} times)" for name, inflation in colored.items())
    found = [
        f"the residuals of {told} in maneuver {part.maneuver} are colored (excess power at low "
        "frequency); the bounds account for it"
    ]
    followed = {name: _averaged_r2(part, part.responses.index(name)) for name in colored}
    missed = [
        f"{name} (R2 {share:.2f})"
        for name, share in followed.items()
        if share < ML_ALGORITHM.min_response_r2
    ]
    if missed:
        found.append(
            f"the model does not follow {', '.join(missed)} in maneuver {part.maneuver}, which "
            "no bound includes: first rule out gusts, a wrong unit or sign of an instrument "
            "('gsapp compatibility') and wrong values in the aircraft file"
        )
    return found


def _averaged_r2(part: ManeuverResiduals, column: int) -> float:
    """Return R2 of a response, measured and computed averaged against their noise."""
    rows = max(
        1, round(ML_ALGORITHM.r2_averaging * (len(part.times) - 1) / float(np.ptp(part.times)))
    )
    starts = np.arange(0, len(part.times), rows)
    counted = np.isfinite(part.measured[:, column])
    counts = np.maximum(np.add.reduceat(counted.astype(np.float64), starts), 1.0)
    measured, computed = (
        np.add.reduceat(np.where(counted, samples[:, column], 0.0), starts) / counts
        for samples in (part.measured, part.computed)
    )
    known = np.add.reduceat(counted, starts) > 0
    return response_fit(measured[known], computed[known]).r2


def unmeasured_input_warning(
    one: ManeuverProblem, part: ManeuverResiduals, settings: MLSettings
) -> str:
    """Return that a surface moved which nobody saw, or nothing.

    A surface without a record, or with a stuck one, is taken as still. Where it was not, its
    share goes into the derivatives of all others, with bounds that know nothing of it.
    """
    colored = _colored_responses(part)
    unseen = dict(unmeasured_surfaces(one.maneuver, settings.axis, settings.stand_ins))
    if not colored or not unseen:
        return ""
    return unmeasured_surfaces_text(
        unseen, f"and the residuals of {', '.join(colored)} contain unexplained motion"
    )


def _colored_responses(part: ManeuverResiduals) -> dict[str, float]:
    """Return the responses with residuals far from white, with the inflation of each."""
    return {
        name: test.inflation
        for name, test in zip(part.responses, part.whiteness, strict=True)
        if not test.white and test.inflation > ML_ALGORITHM.colored_power_ratio
    }
