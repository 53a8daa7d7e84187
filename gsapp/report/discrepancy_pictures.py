"""What the pictures of a search show, on paper and in the window: data, units, titles of steps.

Drawing is left to matplotlib (`gsapp.report.discrepancy_figures`) and pyqtgraph (`ui.gap`). On
both the model before is gray, measured in the color of its channel, computed dashed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gsapp.discrepancy.results import (
    DiscrepancyResult,
    ManeuverHistories,
    UnexplainedStructure,
)
from gsapp.foundation import UnknownNameError
from gsapp.quantities import FloatArray, channel, from_si
from gsapp.quantities.notation import symbol_text, unit_text

CONDITIONS = ("alpha", "beta", "V", "throttle", "de", "da", "dr", "flap")
"""What a missing part is drawn against, in this order."""


def to_display_units(name: str, values: FloatArray, system: str) -> FloatArray:
    """Return SI values of a channel in the unit of display; as they are for no channel."""
    try:
        spec = channel(name)
    except UnknownNameError:
        return values
    return np.asarray(from_si(values, spec.display_unit(system), spec.quantity))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MissingHistory:
    """The missing part of one coefficient over one maneuver."""

    times: FloatArray
    before: FloatArray
    """Shape (n,). Under the baseline."""
    after: FloatArray | None
    """Shape (n,). Under another model, if one is shown."""
    floor: float
    spans: tuple[tuple[float, float], ...]
    """Where the disagreement is proven, s."""


def missing_history(
    found: DiscrepancyResult, view: ManeuverHistories, coefficient: str, step: int = -1
) -> MissingHistory:
    """Return the missing part of a coefficient in a maneuver, under the baseline and a step."""
    column = view.coefficients.index(coefficient)
    step = step % len(view.missing)
    return MissingHistory(
        times=view.times,
        before=view.missing[0][:, column],
        after=view.missing[step][:, column] if step else None,
        floor=view.coefficient_noise_floor.get(coefficient, float("nan")),
        spans=tuple(
            (one.t_start, one.t_end)
            for one in found.disagreements
            if (one.maneuver, one.coefficient) == (view.id, coefficient)
        ),
    )


def missing_by_condition(
    view: ManeuverHistories, coefficient: str, condition: str, step: int, system: str
) -> tuple[FloatArray, FloatArray] | None:
    """Return a condition in the unit of display and the missing part of a coefficient.

    None where the maneuver lacks one of them.
    """
    if condition not in view.conditions or coefficient not in view.coefficients:
        return None
    column = view.coefficients.index(coefficient)
    return (
        to_display_units(condition, view.conditions[condition], system),
        view.missing[step][:, column],
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StructureCurve:
    """A structure without a name over its first variable; what holds the second, in words."""

    name: str  # Empty where there is no second.
    x: FloatArray  # In the unit of display.
    y: FloatArray  # NaN where nothing was flown.


def structure_curves(structure: UnexplainedStructure, system: str) -> tuple[StructureCurve, ...]:
    """Return the cuts through a structure: one, or those in the middle and near both ends."""
    x = to_display_units(structure.variables[0], structure.nodes[0], system)
    shown = np.where(structure.flown > 0.0, structure.values, np.nan)
    if len(structure.variables) == 1:
        return (StructureCurve(name="", x=x, y=shown),)
    name, nodes = structure.variables[1], structure.nodes[1]
    values = to_display_units(name, nodes, system)
    unit = variable_unit(name, system)
    return tuple(
        StructureCurve(
            name=f"{symbol_text(name)} = {values[index]:z.3g}{f' {unit}' if unit else ''}",
            x=x,
            y=shown[:, index],
        )
        for index in (1, nodes.size // 2, nodes.size - 2)
    )


def variable_unit(name: str, system: str) -> str:
    """Return the unit of display of a variable that a term reads; empty for pure numbers."""
    try:
        return unit_text(channel(name).display_unit(system))
    except UnknownNameError:
        return ""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ChannelOverlay:
    """One channel of one maneuver, measured and computed, in the unit of display."""

    times: FloatArray
    measured: FloatArray
    before: FloatArray
    after: FloatArray | None
    """Shape (n,). Computed by another model than the baseline, if one is shown."""
    floor: float


def channel_overlay(
    view: ManeuverHistories, name: str, system: str, step: int = -1
) -> ChannelOverlay:
    """Return a channel of a maneuver, measured, and computed by the baseline and a step."""
    column, step = view.channels.index(name), step % len(view.computed)
    floor = to_display_units(name, np.array([view.noise_floor.get(name, np.nan), 0.0]), system)
    return ChannelOverlay(
        times=view.times,
        measured=to_display_units(name, view.measured[:, column], system),
        before=to_display_units(name, view.computed[0][:, column], system),
        after=to_display_units(name, view.computed[step][:, column], system) if step else None,
        floor=float(floor[0] - floor[1]),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class ChannelGapPair:
    """Residual of one channel over its noise floor, RMS on the maneuvers kept out."""

    channel: str
    before: float
    after: float


def channel_gaps(found: DiscrepancyResult, step: int = -1) -> tuple[ChannelGapPair, ...]:
    """Return the gap of each channel under the baseline and under a step."""
    if not found.steps:
        return ()
    first, shown = found.steps[0].gap, found.steps[step].gap
    return tuple(
        ChannelGapPair(channel=name, before=first[name], after=shown.get(name, float("nan")))
        for name in found.channels
        if name in first
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class WaterfallStep:
    """One step of the waterfall: the misfit before and after it, 1 at the noise floor.

    `added` is the id of an effect, or empty.
    """

    added: str
    before: float
    after: float


def waterfall_steps(found: DiscrepancyResult) -> tuple[WaterfallStep, ...]:
    """Return how the misfit of all channels fell from the baseline on."""
    misfits = [one.misfit for one in found.steps]
    return tuple(
        WaterfallStep(added=one.added, before=before, after=one.misfit)
        for one, before in zip(found.steps, [*misfits[:1], *misfits], strict=False)
    )
