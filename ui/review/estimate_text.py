"""What each choice of the estimate does, and when to change it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

FieldChoices = tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldHelp:
    """A choice explained.

    Attributes
    ----------
    title : str
        What it is called.
    help_text : str
        What it does, and when to change it: one sentence or two.
    """

    title: str
    help_text: str


MANEUVER_CHOICES: FieldChoices = (
    ("used", "Those in use"),
    ("chosen", "Only the chosen one"),
    ("all", "All, unfit ones too"),
)
METHOD_CHOICES: FieldChoices = (
    ("ml", "Maximum likelihood"),
    ("ee", "Equation error"),
    ("ftr", "Fourier transform (FTR)"),
)
AXIS_CHOICES: FieldChoices = (
    ("both", "By the surfaces moved"),
    ("lon", "Longitudinal only"),
    ("lat", "Lateral only"),
)
NOISE_CHOICES: FieldChoices = (("diagonal", "Each response by itself"), ("full", "Correlated"))
INTEGRATION_CHOICES: FieldChoices = (("rk4", "Runge and Kutta"), ("euler", "Euler"))
AS_MODEL_TEXT = "model"
"""How a parameter of an effect is treated where nothing is wished for it: as the model says."""
TREATMENT_CHOICES: FieldChoices = (("tables", "tables"), ("free", "free"), ("held", "held"))

FIELD_HELP: Mapping[str, FieldHelp] = {
    "maneuvers": FieldHelp(
        title="Maneuvers",
        help_text="Those checked under Maneuvers. Take only the chosen one to try settings, all "
        "to see "
        "what unfit ones would give.",
    ),
    "method": FieldHelp(
        title="Method",
        help_text="Maximum likelihood integrates the motion until it follows what was measured: "
        "the "
        "result to report. Equation error regresses the moments sample by sample: steadier in "
        "gusts. FTR does that in the frequency domain, as in flight.",
    ),
    "axis": FieldHelp(
        title="Axis",
        help_text="Each maneuver is fitted in the axis of the surfaces that it moved. Choose one "
        "axis "
        "to leave the others out and to choose its responses.",
    ),
    "six_degrees": FieldHelp(
        title="Six degrees of freedom",
        help_text="Fits all 30 derivatives and all motions in every maneuver. Only where "
        "elevator and "
        "lateral surfaces moved together, or sideslip couples into pitch.",
    ),
    "joint": FieldHelp(
        title="All together, too",
        help_text="Fits all maneuvers of an axis at once beside the single fits: one set of values "
        "that must follow them all. Takes longer; helps where single maneuvers are weak.",
    ),
    "derivatives": FieldHelp(
        title="Derivatives",
        help_text="By the tables, what a maneuver's surfaces can show is free. Hold one at a value "
        "known better from elsewhere, give a start or what is known beforehand with its "
        "deviation. Where some are marked free, these alone are estimated.",
    ),
    "weights": FieldHelp(
        title="Weights of the responses",
        help_text="By default the noise of each response is estimated from its residuals. "
        "Weights of "
        "your own reproduce an older analysis: table 6.2.7 is the source's.",
    ),
    "noise": FieldHelp(
        title="Noise of the responses",
        help_text="Whether the noise of different responses counts as independent. Correlated "
        "where "
        "one disturbance, a gust, moves several at once.",
    ),
    "bound_factor": FieldHelp(
        title="Factor of the bounds",
        help_text="Empty, bounds are corrected for colored residuals. A number multiplies the "
        "Cramer-Rao bounds instead; the source took 10.",
    ),
    "integration": FieldHelp(
        title="Integration",
        help_text="Runge and Kutta follows fast motion exactly. Euler only to reproduce the "
        "numbers "
        "of an older program.",
    ),
    "channels": FieldHelp(
        title="Channels",
        help_text="Space changes a cell. Compared: must be followed by the fit. State: "
        "integrated, not "
        "taken from measurement. Bias, scale, shift: errors of the instrument that are fitted "
        "beside the derivatives; free one where the compatibility check found it.",
    ),
    "stand_ins": FieldHelp(
        title="Stand-ins",
        help_text="Constants for what was not measured, in SI and radians: V=30, alpha=0.05. "
        "Without "
        "them the other maneuvers of the campaign stand in, as far as they can.",
    ),
    "model": FieldHelp(
        title="Model",
        help_text="Gives values to what a maneuver cannot show, and effects beyond the linear "
        "ones. "
        "None: each campaign's own means stand in.",
    ),
    "aircraft": FieldHelp(
        title="Aircraft",
        help_text="Geometry, mass, inertia and instruments. Each flight has a copy of what it was "
        "flown with; choose another file only to correct that.",
    ),
    "calibration": FieldHelp(
        title="Certificates",
        help_text="Volts to engineering units. Each flight has its own in force; choose others "
        "after a "
        "calibration that was found wrong.",
    ),
    "label": FieldHelp(
        title="Name of the run",
        help_text="How this run is called among the kept ones; it can be named later, too.",
    ),
    "run": FieldHelp(
        title="Estimate",
        help_text="Uses the settings shown; the defaults suit most flights. Every run is kept "
        "with its "
        "settings and can be repeated exactly.",
    ),
    "runs": FieldHelp(
        title="Kept runs",
        help_text="Every run with its settings. Space marks one; the run with the keyboard is "
        "then set "
        "beside it. Enter does a run again, exactly, and shows it in the figures.",
    ),
}
"""By field of the panel."""


def format_maneuver_count(inputs: Sequence[Sequence[str]], flights: int) -> str:
    """Return what will be estimated from: ``8 maneuvers of 2 flights: 5 de, 3 da+dr``.

    Parameters
    ----------
    inputs : sequence of sequence of str
        Surfaces that each maneuver moved.
    flights : int
    """
    count = len(inputs)
    kinds: dict[str, int] = {}
    for one in inputs:
        name = "+".join(one) or "none"
        kinds[name] = kinds.get(name, 0) + 1
    parts = ", ".join(f"{number} {name}" for name, number in kinds.items())
    whole = f"{count} maneuver{'' if count == 1 else 's'}"
    of = f" of {flights} flights" if flights > 1 else ""
    return f"{whole}{of}: {parts}"
