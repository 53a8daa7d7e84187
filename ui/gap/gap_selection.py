"""What the crew looks at: maneuver, coefficient, variable, channel and step of a result."""

from __future__ import annotations

from dataclasses import dataclass, replace

from gsapp.discrepancy.results import ManeuverHistories
from gsapp.report.discrepancy_pictures import CONDITIONS
from ui.gap.search_jobs import SearchResult
from ui.translation import tr


@dataclass(frozen=True, slots=True, kw_only=True)
class GapSelection:
    """What is looked at."""

    step: int = 0
    """Model on the way: 0 is the baseline."""
    maneuver: str = ""
    coefficient: str = ""
    variable: str = ""
    channel: str = ""


def initial_selection(result: SearchResult, *, variable: str, channel: str) -> GapSelection:
    """Return where model and flight disagree most, variable and channel kept where they can be."""
    found = result.discrepancy
    worst = next((one for one in found.disagreements if one.coefficient), None)
    selection = GapSelection(step=0)
    if worst is not None:
        if worst.region is not None:
            variable = worst.region.variable
        channel = worst.channel if worst.channel in found.channels else channel
        selection = replace(selection, maneuver=worst.maneuver, coefficient=worst.coefficient)
    return nearest_valid_selection(result, replace(selection, variable=variable, channel=channel))


def nearest_valid_selection(result: SearchResult, wish: GapSelection) -> GapSelection:
    """Return the nearest to a wish that the result can show."""
    found = result.discrepancy
    ids = [view.id for view in found.maneuvers]
    maneuver = wish.maneuver if wish.maneuver in ids else (ids[0] if ids else "")
    known = found.coefficients
    coefficient = wish.coefficient if wish.coefficient in known else (known[0] if known else "")
    view = find_maneuver_view(result, maneuver)
    there = list_plot_variables(view) if view is not None else ()
    variable = wish.variable if wish.variable in there else (there[0] if there else "")
    channels = found.channels
    channel = wish.channel if wish.channel in channels else (channels[0] if channels else "")
    last = max(len(found.steps) - 1, 0)
    return GapSelection(
        step=min(max(wish.step, 0), last),
        maneuver=maneuver,
        coefficient=coefficient,
        variable=variable,
        channel=channel,
    )


def find_worst_held_out(result: SearchResult, selection: GapSelection) -> str:
    """Return the maneuver kept out in which the baseline lacks most; empty if there is none."""
    found = result.discrepancy
    if not found.steps or selection.coefficient not in found.coefficients:
        return ""
    column = found.coefficients.index(selection.coefficient)
    kept = [
        (float(found.steps[0].coefficient_map[row, column]), view.id)
        for row, view in enumerate(found.maneuvers)
        if view.held_out
    ]
    return max(kept)[1] if kept else ""


def find_most_closed_channel(result: SearchResult) -> str:
    """Return the channel whose gap shrank most from the baseline to the last effect."""
    steps = result.discrepancy.steps
    if len(steps) < 2:
        return ""
    shrunk = {
        name: before - steps[-1].gap.get(name, before) for name, before in steps[0].gap.items()
    }
    return max(shrunk, key=lambda name: shrunk[name]) if shrunk else ""


def find_maneuver_view(result: SearchResult, maneuver: str) -> ManeuverHistories | None:
    """Return the histories of a maneuver."""
    return next((one for one in result.discrepancy.maneuvers if one.id == maneuver), None)


def list_plot_variables(view: ManeuverHistories) -> tuple[str, ...]:
    """Return what a coefficient can be drawn against, the usual ones first."""
    known = [name for name in CONDITIONS if name in view.conditions]
    return (*known, *(name for name in view.conditions if name not in known))


def list_model_names(result: SearchResult) -> tuple[str, ...]:
    """Return the names of the models from the baseline on."""
    steps = result.discrepancy.steps
    return tuple(
        f"+ {result.title(step.added)}" if step.added else tr("Baseline") for step in steps
    )
