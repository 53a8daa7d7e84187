"""What the detection gives: one found maneuver, with its grade."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final, Literal

from gsapp.foundation import FlightError
from gsapp.foundation.translation import QT_TR_NOOP

Grade = Literal["A", "B", "C", "D"]

GRADES: Final[Mapping[Grade, str]] = {
    "A": QT_TR_NOOP("good: as requested, no defect"),
    "B": QT_TR_NOOP("usable: one small defect, or not as requested (amplitude, width, trim)"),
    "C": QT_TR_NOOP("poor: several small defects or a large one; expect wide bounds"),
    "D": QT_TR_NOOP("unfit: too small, too large or invalid; exclude from fits"),
}
"""Grades and what they mean."""

GRADED_BY_PROGRAM: Final = "program"
"""Gave a grade by what the samples show."""
GRADED_BY_CREW: Final = "crew"
"""Gave a grade by what people know; the program does not overrule it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DetectedManeuver:  # noqa: PLW1641 - the decorator makes the hash
    """One maneuver of a flight, found in its record or named by hand."""

    id: str
    """Within its flight; numbers in order of time where nobody named it."""
    t_start: float
    """First sample, s of flight time; about a second of trim comes before the input."""
    t_end: float
    """Last sample, s: the pilot took over again, or the answer has died down."""
    inputs: tuple[str, ...]
    """Controls moved, of ``de``, ``da``, ``dr``, ``flap``, ``throttle``, in this order."""
    kind: str
    """Shape of the main input: ``doublet``, ``3-2-1-1``, ``pulse``, ``multistep``, ``sweep``, of
    throttle or flap ``step``; ``none`` where nothing moved."""
    amplitude: float | None
    """Half the peak-to-peak deflection of the main input, rad; of a pulse or step its height; of
    throttle from 0 to 1. The main one makes the quickest step, as a share of its travel."""
    grade: Grade
    """See `GRADES`."""
    reasons: tuple[str, ...] = ()
    """What the grade was lowered for, in words; empty for an A."""
    V: float | None = None
    """Airspeed at the start, m/s; None where not measured."""
    alpha: float | None = None
    """Angle of attack at the start, as measured at the vane, rad."""
    t_input: float = math.nan
    t_input_end: float = math.nan
    """When the first surface began to move and when the last one was back, s."""
    amplitudes: Mapping[str, float] = field(default_factory=dict)
    """Amplitude of each input, rad."""
    note: str = ""
    """What a person wrote beside it."""
    graded_by: str = GRADED_BY_PROGRAM
    """`GRADED_BY_PROGRAM` or `GRADED_BY_CREW`."""
    use: bool | None = None
    """Whether a person wants it in estimates; None leaves it to the grade."""

    def __eq__(self, other: object) -> bool:
        """Return whether all of it is the same; what is not known equals itself.

        From Python 3.13 on data classes compare number by number, and NaN equals nothing.
        """
        if not isinstance(other, DetectedManeuver):
            return NotImplemented
        return self.to_record() == other.to_record()

    def with_verdict(
        self, result: str, advice: str, grade: Grade | None = None
    ) -> DetectedManeuver:
        """Return the maneuver graded no better than its verdict allows.

        Only an input with the verdict ``good`` can be an A, see
        `gsapp.excitation.doublets.verdict`. A grade given by hand stays. The advice becomes a
        reason.
        """
        verdict: Grade = "A" if result == "good" else "B"
        limit: Grade = max(grade or "A", verdict)
        if limit <= self.grade or self.graded_by == GRADED_BY_CREW:
            return self
        return replace(self, grade=limit, reasons=(*self.reasons, advice))

    def is_used(self, *, alone: bool = False) -> bool:
        """Return whether it takes part in estimates.

        Where nobody decided the grade does: unfit ones stay out. One that is alone in its flight
        stays in; what it cannot give is said by its estimate.
        """
        return (alone or self.grade != "D") if self.use is None else self.use

    def to_json(self) -> dict[str, Any]:
        """Return the fixed fields for programs: SI units, absent = None."""
        return {
            "id": self.id,
            "t_start": round(self.t_start, 6),
            "t_end": round(self.t_end, 6),
            "inputs": list(self.inputs),
            "kind": self.kind,
            "amplitude": _finite_or_none(self.amplitude),
            "grade": self.grade,
            "reasons": list(self.reasons),
            "V": _finite_or_none(self.V),
            "alpha": _finite_or_none(self.alpha),
        }

    def to_record(self) -> dict[str, Any]:
        """Return everything, for storing; `from_record` reads it back."""
        return {
            **self.to_json(),
            "t_start": self.t_start,
            "t_end": self.t_end,
            "t_input": _finite_or_none(self.t_input),
            "t_input_end": _finite_or_none(self.t_input_end),
            "amplitudes": dict(self.amplitudes),
            "note": self.note,
            "graded_by": self.graded_by,
            "use": self.use,
        }

    @staticmethod
    def from_record(record: object) -> DetectedManeuver:
        """Return the maneuver that `to_record` made, or that a program wrote with less."""
        if not isinstance(record, dict):
            raise FlightError("a stored maneuver is no JSON object; detect the maneuvers again")
        try:
            grade = str(record["grade"])
            if grade not in GRADES:
                raise ValueError(f"there is no grade {grade}")
            found = DetectedManeuver(
                id=str(record["id"]),
                t_start=float(record["t_start"]),
                t_end=float(record["t_end"]),
                inputs=tuple(str(name) for name in record["inputs"]),
                kind=str(record["kind"]),
                amplitude=_float_or_none(record.get("amplitude")),
                grade=grade,  # type: ignore[arg-type]  # checked above
                reasons=tuple(str(text) for text in record.get("reasons", ())),
                V=_float_or_none(record.get("V")),
                alpha=_float_or_none(record.get("alpha")),
                t_input=_or_nan(record.get("t_input")),
                t_input_end=_or_nan(record.get("t_input_end")),
                amplitudes={
                    str(name): float(size) for name, size in record.get("amplitudes", {}).items()
                },
                note=str(record.get("note", "")),
                graded_by=str(record.get("graded_by", GRADED_BY_PROGRAM)),
                use=None if record.get("use") is None else bool(record["use"]),
            )
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise FlightError(
                f"a stored maneuver cannot be read ({error}); detect the maneuvers again"
            ) from error
        if not found.t_start < found.t_end:
            raise FlightError(
                f"the stored maneuver {found.id} ends before it begins; detect the maneuvers again"
            )
        return found


def _finite_or_none(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else value


def _float_or_none(value: Any) -> float | None:
    return None if value is None else float(value)


def _or_nan(value: Any) -> float:
    return math.nan if value is None else float(value)
