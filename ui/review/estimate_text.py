"""What each choice of the estimate does, and when to change it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from gsapp.foundation.settings import setting_info
from gsapp.identification.estimate_settings import EstimateSettings
from gsapp.identification.methods import estimation_methods

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
    ("used", "Maneuvers in use"),
    ("chosen", "Selected maneuver only"),
    ("all", "All, unfit included"),
)
_METHODS = estimation_methods().values()
SETTING_CHOICES: Mapping[str, FieldChoices] = {
    **{name: setting_info(field).choices for name, field in EstimateSettings.model_fields.items()},
    "method": tuple((one.id, one.title) for one in _METHODS),
    "maneuvers": MANEUVER_CHOICES,
}
"""Values of settings and their titles, where they are a choice."""
AS_MODEL_TEXT = "model"
"""How a parameter of an effect is treated where nothing is wished for it: as the model says."""
TREATMENT_CHOICES: FieldChoices = (("tables", "tables"), ("free", "free"), ("held", "held"))

FIELD_HELP: Mapping[str, FieldHelp] = {
    **{
        name: FieldHelp(title=str(field.title), help_text=str(field.description))
        for name, field in EstimateSettings.model_fields.items()
        if setting_info(field).option
    },
    "method": FieldHelp(
        title="Method",
        help_text=" ".join(f"{one.title}: {one.help_text}" for one in _METHODS),
    ),
    "maneuvers": FieldHelp(
        title="Maneuvers",
        help_text="The maneuvers checked on the Maneuvers page. Use the selected one to try "
        "settings, or all to include unfit ones.",
    ),
    "derivatives": FieldHelp(
        title="Derivatives",
        help_text="By default, the derivatives that the moved surfaces excite are free. Hold "
        "one at a known value, or give a start value or a prior with its standard "
        "deviation. If some are marked free, only these are estimated.",
    ),
    "channels": FieldHelp(
        title="Channels",
        help_text="Space changes a cell. Compared: must be followed by the fit. State: "
        "integrated, not taken from measurement. Bias, scale, shift: errors of the instrument "
        "that are fitted too; free one where the compatibility check found it.",
    ),
    "run": FieldHelp(
        title="Estimate",
        help_text="Uses the settings shown; the defaults suit most flights. Each run is saved "
        "with its settings and can be repeated exactly.",
    ),
    "runs": FieldHelp(
        title="Saved runs",
        help_text="All runs with their settings. Space marks one for comparison with the "
        "selected run. Enter repeats a run exactly and shows it in the figures.",
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
