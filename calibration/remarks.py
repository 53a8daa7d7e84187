"""What a person should know of a calibration before accepting it, in sentences."""

from __future__ import annotations

from collections.abc import Sequence

from calibration.points import CalibrationPoint
from calibration.quality import Calibration
from calibration.settings import CALIBRATION


def collect_remarks(
    calibration: Calibration, points: Sequence[CalibrationPoint], unit: str
) -> tuple[str, ...]:
    """Return what is odd about a calibration, each with its remedy; empty where all is well.

    Parameters
    ----------
    calibration : Calibration
        From `calibration.curve_selection.fit_calibration`.
    points : sequence of CalibrationPoint
        The points that it was drawn through.
    """
    quality = calibration.quality
    found = [
        f"point {index + 1} ({points[index].value:g} {unit}, {points[index].direction}) does not "
        "fit the others; repeat or delete it"
        for index in quality.outliers
    ]
    if not calibration.losses:
        found.append("too few settings to choose the fit order; take at least three")
    if not quality.half_widths:
        found.append("too few points to estimate the uncertainty; take more")
    width, std = calibration.branch_fit.hysteresis, calibration.branch_fit.hysteresis_std
    if width is None:
        found.append("hysteresis was not measured; take the settings in both directions")
    elif std is not None and width < -3.0 * std:
        found.append(
            "the voltage leads the movement; check whether the directions were noted in reverse"
        )
    if quality.coverage is not None and quality.coverage < CALIBRATION.min_coverage:
        found.append(
            f"only {100.0 * quality.coverage:.0f} % of the travel is covered; values beyond are "
            "extrapolated; take settings nearer to the ends"
        )
    return tuple(found)
