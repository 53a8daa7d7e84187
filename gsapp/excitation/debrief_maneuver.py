"""One maneuver for the debrief: its verdict, what was wanted, how it began, and its curves."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, cast

import numpy as np
from pydantic import TypeAdapter

from gsapp.excitation.doublets.verdict import InputVerdict
from gsapp.excitation.flight_rows import FlightRows
from gsapp.excitation.settings import CUES
from gsapp.excitation.test_points.point import TestPoint
from gsapp.excitation.test_points.target_input import TargetInput
from gsapp.foundation import FlightError
from gsapp.quantities import FloatArray

_ANSWERS: Final[Mapping[str, tuple[str, ...]]] = {
    "de": ("q", "alpha", "an"),
    "da": ("p", "phi"),
    "dr": ("r", "beta", "ay"),
}
"""What answers to each surface."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ManeuverCurves:
    """A few samples a second of some channels, for a small plot."""

    times: FloatArray
    """Shape (n,). Flight time, s."""
    series: Mapping[str, FloatArray]
    """Shape (n,). By channel, SI; NaN where missing."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class EvaluatedManeuver:
    """A maneuver with all that the debrief shows of it."""

    verdict: InputVerdict
    target_input: TargetInput | None
    """What was asked for when it was flown."""
    point: TestPoint | None
    """Where it should have begun."""
    go_at: float | None
    """When GO was given before it, s; None if it was flown without."""
    trim_deviations: Mapping[str, float]
    """What was off as it began, in tolerances, signed; of ``speed``, ``bank`` ..."""
    curves: ManeuverCurves

    def to_json(self) -> dict[str, Any]:
        """Return what a program reads of it, without the curves. SI, absent = None."""
        record = self.to_record()
        return {
            **record["verdict"],
            "wanted": record["wanted"],
            "go_at": record["go_at"],
            "off": record["off"],
        }

    def to_record(self) -> dict[str, Any]:
        """Return what JSON can hold; `from_record` reads it back. SI, absent = None."""
        return {
            "verdict": _json(_VERDICT.dump_python(self.verdict, mode="json")),
            "wanted": _json(_WANTED.dump_python(self.target_input, mode="json")),
            "point": _json(_POINT.dump_python(self.point, mode="json")),
            "go_at": self.go_at,
            "off": _json(dict(self.trim_deviations)),
            "curves": {
                "times": [round(float(time), 4) for time in self.curves.times],
                "series": {
                    name: [_sample(value) for value in values]
                    for name, values in self.curves.series.items()
                },
            },
        }

    @staticmethod
    def from_record(record: object) -> EvaluatedManeuver:
        """Return the maneuver that `to_record` made.

        Raises
        ------
        FlightError
            If it is none.
        """
        try:
            return _read(cast("Mapping[str, Any]", record))
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise FlightError(
                f"a stored verdict cannot be read ({error}); debrief the flight anew"
            ) from error


def extract_curves(
    rows: FlightRows | None, surfaces: tuple[str, ...], rate: float
) -> ManeuverCurves:
    """Return the surfaces and their answers, thinned.

    Parameters
    ----------
    rows : FlightRows or None
        Of the maneuver; None gives empty curves.
    surfaces : tuple of str
        That moved.
    rate : float
        Of the grid, Hz.
    """
    if rows is None:
        return ManeuverCurves(times=np.empty(0), series={})
    every = max(1, round(rate / CUES.plot_rate))
    kept = (rows.first_index + np.arange(len(rows))) % every == 0
    names = dict.fromkeys((*surfaces, *(name for one in surfaces for name in _ANSWERS[one])))
    series = {name: rows[name][kept] for name in names}
    return ManeuverCurves(
        times=rows.times[kept],
        series={name: values for name, values in series.items() if np.isfinite(values).any()},
    )


_VERDICT: Final = TypeAdapter(InputVerdict)
_WANTED: Final = TypeAdapter[TargetInput | None](TargetInput | None)
_POINT: Final = TypeAdapter[TestPoint | None](TestPoint | None)


def _read(record: Mapping[str, Any]) -> EvaluatedManeuver:
    curves = record["curves"]
    return EvaluatedManeuver(
        verdict=_VERDICT.validate_python(record["verdict"]),
        target_input=_WANTED.validate_python(record["wanted"]),
        point=_POINT.validate_python(record["point"]),
        go_at=record["go_at"],
        trim_deviations={str(name): float(share) for name, share in record["off"].items()},
        curves=ManeuverCurves(
            times=np.array(curves["times"], dtype=np.float64),
            series={
                name: np.array([math.nan if one is None else one for one in values])
                for name, values in curves["series"].items()
            },
        ),
    )


def _sample(value: float) -> float | None:
    return float(f"{value:.5g}") if math.isfinite(value) else None


def _json(content: Any) -> Any:
    """Return content with numbers that JSON has no word for as texts, which are read back."""
    if isinstance(content, dict):
        return {name: _json(one) for name, one in content.items()}
    if isinstance(content, list):
        return [_json(one) for one in content]
    if isinstance(content, float) and not math.isfinite(content):
        return str(content)
    return content
