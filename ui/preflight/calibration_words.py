"""How the calibration stands, at a glance. No Qt."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from datetime import date

from calibration import Certificate
from ui.frame.steps import StepState


def calibration_state(
    titles: Mapping[str, str],
    certificates: Mapping[str, Certificate],
    today: date,
    *,
    unfinished: bool = False,
    moved: Collection[str] = (),
) -> StepState:
    """Return how the calibration stands.

    Parameters
    ----------
    titles : mapping of str to str
        What is to be calibrated at the field: channel id and its name.
    certificates : mapping of str to Certificate
        In force, by channel.
    today : date
        A calibration counts for the day on which it was made.
    unfinished : bool
        Whether one was begun and not finished.
    moved : collection of str
        Channels of which the last check said that the certificate does not hold.
    """
    missing = [title for name, title in titles.items() if name not in certificates]
    if missing:
        return StepState(
            state="warning",
            words=f"{len(missing)} uncalibrated",
            detail=f"Uncalibrated: {', '.join(missing)}",
        )
    gone = [title for name, title in titles.items() if name in moved]
    if gone:
        return StepState(
            state="warning",
            words=f"{len(gone)} moved",
            detail=f"Moved since it was calibrated, by the last check: {', '.join(gone)}",
        )
    if unfinished:
        return StepState(
            state="caution", words="not finished", detail="A calibration was begun, not finished"
        )
    stamps = [certificates[name].stamp.astimezone() for name in titles]
    oldest = min(stamps, default=None)
    if oldest is None:
        return StepState(state="unknown", words="nothing planned")
    count = f"{len(titles)} of {len(titles)}"
    if oldest.date() == today:
        return StepState(state="good", words=f"{count} today")
    day = f"{oldest.day} {oldest:%b}" if oldest.year == today.year else str(oldest.year)
    return StepState(
        state="caution",
        words=f"from {day}",
        detail=f"The oldest of {len(titles)} certificates is of {oldest.day} {oldest:%B %Y}",
    )
