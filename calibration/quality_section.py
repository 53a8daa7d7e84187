"""The section ``[quality]`` of a certificate file."""

from __future__ import annotations

from typing import Any

from pydantic import Field

from calibration.polynomial_fit import PolynomialFit
from calibration.quality import CalibrationQuality
from calibration.quantity_parsing import difference_unit, parse_quantity, parse_quantity_in_unit
from gsapp.foundation import FileProblem, StrictModel
from gsapp.quantities.fields import Voltage


class _UncertaintySection(StrictModel):
    volts: tuple[Voltage, ...] = Field(min_length=2)
    half_width: tuple[str, ...] = Field(min_length=2)


class QualitySection(StrictModel):
    """As written in the file; see `calibration.quality.CalibrationQuality`."""

    linearity: str
    resolution: str
    covered: tuple[str, str]
    travel: tuple[str, str] | None = None
    scatter: str | None = None
    hysteresis_uncertainty: str | None = None
    return_to_zero: str | None = None
    outliers: tuple[int, ...] = ()
    uncertainty: _UncertaintySection | None = None


def read_quality(
    section: QualitySection,
    *,
    fit: PolynomialFit,
    two_sided: bool,
    unit: str,
    key: str,
    problems: list[FileProblem],
) -> CalibrationQuality:
    """Return the quality that a file tells of; mistakes are added to `problems`.

    Parameters
    ----------
    fit : PolynomialFit
        Of the same file: what it says is not said twice.
    two_sided : bool
        Whether the points were taken upward and downward.
    unit, key : str
        Of the certificate, and the quantity of its channel.
    """
    step = difference_unit(unit)

    def optional(name: str) -> float | None:
        text = getattr(section, name)
        return None if text is None else parse_quantity(text, step, f"quality.{name}", problems)

    def pair(texts: tuple[str, str], name: str) -> tuple[float, float]:
        low, high = (
            parse_quantity_in_unit(text, unit, key, f"quality.{name}[{index}]", problems)
            for index, text in enumerate(texts)
        )
        # A single reading covers a single value; a travel without length is none.
        if low > high or (low == high and name == "travel"):
            problems.append(
                FileProblem(
                    where=f"quality.{name}", what="ends before it begins", remedy="swap the two"
                )
            )
        return low, high

    places: tuple[float, ...] = ()
    half_widths: tuple[float, ...] = ()
    if section.uncertainty is not None:
        places = section.uncertainty.volts
        half_widths = tuple(
            parse_quantity(text, step, f"quality.uncertainty.half_width[{index}]", problems)
            for index, text in enumerate(section.uncertainty.half_width)
        )
        if len(places) != len(half_widths) or sorted(set(places)) != list(places):
            problems.append(
                FileProblem(
                    where="quality.uncertainty",
                    what="volts do not ascend, or there are not as many half widths",
                    remedy="write one half width for each of the ascending volts",
                )
            )
    return CalibrationQuality(
        degree=len(fit.coefficients) - 1,
        rms=fit.rms,
        max_residual=fit.max_residual,
        linearity=parse_quantity(section.linearity, step, "quality.linearity", problems),
        scatter=optional("scatter"),
        hysteresis=fit.hysteresis if two_sided else None,
        hysteresis_uncertainty=optional("hysteresis_uncertainty"),
        return_to_zero=optional("return_to_zero"),
        resolution=parse_quantity(section.resolution, step, "quality.resolution", problems),
        covered=pair(section.covered, "covered"),
        travel=None if section.travel is None else pair(section.travel, "travel"),
        uncertainty_volts=places,
        half_widths=half_widths,
        outliers=section.outliers,
    )


def quality_content(quality: CalibrationQuality, unit: str) -> dict[str, Any]:
    """Return what the section holds; `read_quality` reads it back to six digits."""
    step = difference_unit(unit)

    def written(value: float | None) -> str | None:
        return None if value is None else f"{value:.6g} {step}".rstrip()

    def pair(values: tuple[float, float] | None) -> list[str] | None:
        return None if values is None else [f"{float(value)!r} {unit}".rstrip() for value in values]

    content = {
        "linearity": written(quality.linearity),
        "scatter": written(quality.scatter),
        "hysteresis_uncertainty": written(quality.hysteresis_uncertainty),
        "return_to_zero": written(quality.return_to_zero),
        "resolution": written(quality.resolution),
        "covered": pair(quality.covered),
        "travel": pair(quality.travel),
        "outliers": list(quality.outliers) or None,
        "uncertainty": {
            "volts": [f"{float(volts)!r} V" for volts in quality.uncertainty_volts],
            "half_width": [written(half_width) for half_width in quality.half_widths],
        }
        if quality.uncertainty_volts
        else None,
    }
    return {key: value for key, value in content.items() if value is not None}
