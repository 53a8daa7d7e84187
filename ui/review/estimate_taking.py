"""Which maneuvers a run would take, and why none. No Qt."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gsapp.identification.axes import SURFACES
from ui.review.estimate_wishes import Wishes
from ui.review.estimate_words import maneuver_count
from ui.words import keys_text

if TYPE_CHECKING:
    from gsapp.identification.runs.request import ChosenManeuver
    from gsapp.session.review import Review


def taken(wishes: Wishes, review: Review, looked_at: str) -> tuple[ChosenManeuver, ...]:
    """Return the maneuvers that a run would take.

    Parameters
    ----------
    wishes : Wishes
    review : Review
    looked_at : str
        Id of the maneuver that is chosen.
    """
    if wishes.maneuvers == "chosen":
        chosen = review.chosen((looked_at,))
    elif wishes.maneuvers == "all":
        chosen = review.chosen([row.id for row in review.rows()])
    else:
        chosen = review.chosen()
    if wishes.axis == "both" or wishes.six_degrees:
        return chosen
    return tuple(one for one in chosen if not set(SURFACES[wishes.axis]).isdisjoint(one.inputs))


def taken_words(maneuvers: tuple[ChosenManeuver, ...]) -> str:
    """Return what a run would take, in words."""
    flights = len({one.flight for one in maneuvers})
    return f"{maneuver_count([one.inputs for one in maneuvers], flights)}."


def none_words(wishes: Wishes, review: Review) -> str:
    """Return why a run would take nothing, and what to do."""
    there = f"under Maneuvers ({keys_text('Alt+1')})"
    if wishes.maneuvers == "chosen":
        return f"No maneuver is chosen: choose one {there} or in a figure."
    if not review.rows():
        return f"These flights have no maneuvers: add them {there}."
    if wishes.axis != "both":
        return "No maneuver in use moved a surface of this axis: choose another axis."
    return f"No maneuver is in use: check some {there}."
