"""Which maneuvers a run would take, and why none. No Qt."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gsapp.identification.axes import AXIS_SURFACES
from ui.estimate_form import EstimateForm
from ui.number_format import plain_shortcut_text
from ui.review.estimate_text import format_maneuver_count
from ui.translation import tr

if TYPE_CHECKING:
    from gsapp.identification.runs.request import SelectedManeuver
    from gsapp.session.review import Review


def select_maneuvers(
    form: EstimateForm, review: Review, looked_at: str
) -> tuple[SelectedManeuver, ...]:
    """Return the maneuvers that a run would take.

    Parameters
    ----------
    looked_at : str
        Id of the maneuver that is chosen.
    """
    if form.maneuvers == "chosen":
        chosen = review.select_maneuvers((looked_at,))
    elif form.maneuvers == "all":
        chosen = review.select_maneuvers([row.id for row in review.rows()])
    else:
        chosen = review.select_maneuvers()
    if form.axis == "both" or form.six_degrees:
        return chosen
    return tuple(one for one in chosen if not set(AXIS_SURFACES[form.axis]).isdisjoint(one.inputs))


def describe_selection(maneuvers: tuple[SelectedManeuver, ...]) -> str:
    """Return what a run would take, in words."""
    flights = len({one.flight for one in maneuvers})
    return f"{format_maneuver_count([one.inputs for one in maneuvers], flights)}."


def describe_empty_selection(form: EstimateForm, review: Review) -> str:
    """Return why a run would take nothing, and what to do."""
    there = tr("on the Maneuvers page ({keys})").format(keys=plain_shortcut_text("Alt+1"))
    if form.maneuvers == "chosen":
        return tr("No maneuver selected: select one {there} or in a figure.").format(there=there)
    if not review.rows():
        return tr("These flights have no maneuvers: add some {there}.").format(there=there)
    if form.axis != "both":
        return tr("No maneuver in use moved a surface of this axis: choose another axis.")
    return tr("No maneuver is in use: check some {there}.").format(there=there)
