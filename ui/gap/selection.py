"""What the crew looks at: maneuver, coefficient, variable, channel and step of an answer."""

from __future__ import annotations

from dataclasses import dataclass, replace

from gsapp.discrepancy.results import ManeuverView
from ui.gap.request import Answer

_VARIABLES = ("alpha", "beta", "V", "throttle", "de", "da", "dr", "flap")
"""In this order they are offered."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Selection:
    """What is looked at.

    Attributes
    ----------
    step : int
        Model on the way: 0 is the baseline.
    maneuver, coefficient, variable, channel : str
    """

    step: int = 0
    maneuver: str = ""
    coefficient: str = ""
    variable: str = ""
    channel: str = ""


def beginning(answer: Answer, *, variable: str, channel: str) -> Selection:
    """Return what to look at first: where model and flight disagree most.

    Parameters
    ----------
    answer : Answer
    variable, channel : str
        Looked at last, kept where this answer has them.
    """
    found = answer.discrepancy
    worst = next((one for one in found.disagreements if one.coefficient), None)
    selection = Selection(step=0)
    if worst is not None:
        if worst.region is not None:
            variable = worst.region.variable
        channel = worst.channel if worst.channel in found.channels else channel
        selection = replace(selection, maneuver=worst.maneuver, coefficient=worst.coefficient)
    return held(answer, replace(selection, variable=variable, channel=channel))


def held(answer: Answer, wish: Selection) -> Selection:
    """Return the nearest to a wish that the answer can show."""
    found = answer.discrepancy
    ids = [view.id for view in found.maneuvers]
    maneuver = wish.maneuver if wish.maneuver in ids else (ids[0] if ids else "")
    known = found.coefficients
    coefficient = wish.coefficient if wish.coefficient in known else (known[0] if known else "")
    view = view_of(answer, maneuver)
    there = variables(view) if view is not None else ()
    variable = wish.variable if wish.variable in there else (there[0] if there else "")
    channels = found.channels
    channel = wish.channel if wish.channel in channels else (channels[0] if channels else "")
    last = max(len(found.steps) - 1, 0)
    return Selection(
        step=min(max(wish.step, 0), last),
        maneuver=maneuver,
        coefficient=coefficient,
        variable=variable,
        channel=channel,
    )


def kept_out(answer: Answer, selection: Selection) -> str:
    """Return the maneuver kept out in which the baseline lacks most; empty if there is none."""
    found = answer.discrepancy
    if not found.steps or selection.coefficient not in found.coefficients:
        return ""
    column = found.coefficients.index(selection.coefficient)
    kept = [
        (float(found.steps[0].map[row, column]), view.id)
        for row, view in enumerate(found.maneuvers)
        if view.held_out
    ]
    return max(kept)[1] if kept else ""


def closed_most(answer: Answer) -> str:
    """Return the channel whose gap shrank most from the baseline to the last effect."""
    steps = answer.discrepancy.steps
    if len(steps) < 2:
        return ""
    shrunk = {
        name: before - steps[-1].gap.get(name, before) for name, before in steps[0].gap.items()
    }
    return max(shrunk, key=lambda name: shrunk[name]) if shrunk else ""


def view_of(answer: Answer, maneuver: str) -> ManeuverView | None:
    """Return the histories of a maneuver."""
    return next((one for one in answer.discrepancy.maneuvers if one.id == maneuver), None)


def variables(view: ManeuverView) -> tuple[str, ...]:
    """Return what a coefficient can be drawn against, the usual ones first."""
    known = [name for name in _VARIABLES if name in view.conditions]
    return (*known, *(name for name in view.conditions if name not in known))


def step_names(answer: Answer) -> tuple[str, ...]:
    """Return the names of the models from the baseline on."""
    steps = answer.discrepancy.steps
    return tuple(f"+ {answer.title(step.added)}" if step.added else "Baseline" for step in steps)
