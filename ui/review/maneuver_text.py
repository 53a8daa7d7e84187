"""A maneuver in words, for the table and beside the time line. No Qt."""

from __future__ import annotations

from gsapp.flight.maneuvers.detected_maneuver import GRADED_BY_CREW, GRADES, DetectedManeuver
from gsapp.quantities import channel, name_in_text
from gsapp.session.review.review import ManeuverRow
from ui.icons import IndicatorState
from ui.number_format import DASH, channel_value_text, clock_text, symbol_text
from ui.translation import tr

GRADE_STATES: dict[str, IndicatorState] = {"A": "good", "B": "good", "C": "caution", "D": "warning"}
"""How a grade is colored; the letter says it too."""


def surface_symbols_text(maneuver: DetectedManeuver) -> str:
    """Return the surfaces as symbols: ``δa δr``."""
    return " ".join(symbol_text(channel(name).symbol) for name in maneuver.inputs) or DASH


def title_text(name: str, maneuver: DetectedManeuver) -> str:
    """Return ``Maneuver 2:4, aileron and rudder doublet``, with the id among all flights."""
    names = [name_in_text(name) for name in maneuver.inputs]
    if not names:
        return tr("Maneuver {name}, no surface moved").format(name=name)
    listed = tr(" and ").join(filter(None, (", ".join(names[:-1]), names[-1])))
    return tr("Maneuver {name}, {listed} {kind}").format(
        name=name, listed=listed, kind=maneuver.kind
    )


def times_text(maneuver: DetectedManeuver) -> str:
    """Return the edges, which move by samples, and the length: ``01:36.02 to 01:41.50, 5.48 s``."""
    start, end = (clock_text(time, decimals=2) for time in (maneuver.t_start, maneuver.t_end))
    return tr("{start} to {end}, {length:.2f} s long").format(
        start=start, end=end, length=maneuver.t_end - maneuver.t_start
    )


def condition_text(maneuver: DetectedManeuver, units: str) -> str:
    """Return size, airspeed and angle of attack in the units of the screen."""
    parts = []
    if maneuver.amplitude is not None:
        sizes = [
            f"{symbol_text(channel(name).symbol)} "
            f"{channel_value_text(channel(name), maneuver.amplitudes.get(name), units)}"
            for name in maneuver.inputs
            if name in maneuver.amplitudes
        ]
        parts += sizes
    for name, value in (("V", maneuver.V), ("alpha", maneuver.alpha)):
        if value is not None:
            parts.append(
                f"{symbol_text(channel(name).symbol)} "
                f"{channel_value_text(channel(name), value, units)}"
            )
    return ", ".join(parts)


def grade_text(maneuver: DetectedManeuver) -> str:
    """Return the grade with whose it is: ``C by hand``."""
    return (
        tr("{grade} (manual)").format(grade=maneuver.grade)
        if maneuver.graded_by == GRADED_BY_CREW
        else maneuver.grade
    )


def reasons_text(maneuver: DetectedManeuver) -> str:
    """Return what the grade means and why it was given."""
    meaning = tr(GRADES[maneuver.grade])
    parts = [f"{meaning[0].upper()}{meaning[1:]}."]
    if maneuver.graded_by == GRADED_BY_CREW:
        parts.insert(0, tr("Graded manually."))
    if maneuver.reasons:
        # A reason may begin with a symbol, which is never written large.
        parts.append(tr("Why: {reasons}.").format(reasons="; ".join(maneuver.reasons)))
    return " ".join(parts)


def remarks_text(row: ManeuverRow) -> str:
    """Return what else is to be said: verdict, shared samples, use, changes, note."""
    parts = []
    if row.verdict is not None:
        parts.append(
            tr("Cue to the pilot: {advice}.").format(
                advice=row.verdict.advice or row.verdict.result
            )
        )
    if row.overlaps:
        parts.append(
            tr("Shares samples with {overlaps}: they would count twice in a mean.").format(
                overlaps=", ".join(row.overlaps)
            )
        )
    if not row.in_use:
        parts.append(tr("Not used in the estimate."))
    if row.is_edited:
        parts.append(tr("Edited."))
    if row.maneuver.note:
        parts.append(tr("Note: {note}").format(note=row.maneuver.note))
    return " ".join(parts)


def grade_counts_text(maneuvers: tuple[DetectedManeuver, ...]) -> str:
    """Return how many have which grade: ``A 3, B 2, D 1``."""
    counts = {grade: sum(one.grade == grade for one in maneuvers) for grade in GRADES}
    return ", ".join(f"{grade} {count}" for grade, count in counts.items() if count)
