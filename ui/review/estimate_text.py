"""What each choice of the estimate does, and when to change it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from gsapp.foundation.settings import setting_info
from gsapp.identification.estimate_settings import EstimateSettings
from gsapp.identification.methods import estimation_methods
from ui.number_format import count_text
from ui.translation import QT_TR_NOOP, tr

FieldChoices = tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldHelp:
    """A choice explained."""

    title: str
    help_text: str


MANEUVER_CHOICES: FieldChoices = (
    ("used", QT_TR_NOOP("Maneuvers in use")),
    ("chosen", QT_TR_NOOP("Selected maneuver only")),
    ("all", QT_TR_NOOP("All, unfit included")),
)
_METHODS = estimation_methods().values()
SETTING_CHOICES: Mapping[str, FieldChoices] = {
    **{name: setting_info(field).choices for name, field in EstimateSettings.model_fields.items()},
    "method": tuple((one.id, one.title) for one in _METHODS),
    "maneuvers": MANEUVER_CHOICES,
}
"""Values of settings and their titles, where they are a choice."""
AS_MODEL_TEXT = QT_TR_NOOP("model")
"""How a parameter of an effect is treated where nothing is wished for it: as the model says."""
TREATMENT_CHOICES: FieldChoices = (
    ("tables", QT_TR_NOOP("tables")), ("free", QT_TR_NOOP("free")), ("held", QT_TR_NOOP("held")),
)  # fmt: skip

FIELD_HELP: Mapping[str, FieldHelp] = {
    **{
        name: FieldHelp(title=str(field.title), help_text=str(field.description))
        for name, field in EstimateSettings.model_fields.items()
        if setting_info(field).option
    },
    "method": FieldHelp(
        title=QT_TR_NOOP("Method"),
        help_text=" ".join(f"{one.title}: {one.help_text}" for one in _METHODS),
    ),
    "maneuvers": FieldHelp(
        title=QT_TR_NOOP("Maneuvers"),
        help_text=QT_TR_NOOP(
            "The maneuvers checked on the Maneuvers page. Use the selected one to try "
            "settings, or all to include unfit ones."
        ),
    ),
    "derivatives": FieldHelp(
        title=QT_TR_NOOP("Derivatives"),
        help_text=QT_TR_NOOP(
            "By default, the derivatives that the moved surfaces excite are free. Hold "
            "one at a known value, or give a start value or a prior with its standard "
            "deviation. If some are marked free, only these are estimated."
        ),
    ),
    "channels": FieldHelp(
        title=QT_TR_NOOP("Channels"),
        help_text=QT_TR_NOOP(
            "Space changes a cell. Compared: must be followed by the fit. State: "
            "integrated, not taken from measurement. Bias, scale, shift: errors of the instrument "
            "that are fitted too; free one where the compatibility check found it."
        ),
    ),
    "run": FieldHelp(
        title=QT_TR_NOOP("Estimate"),
        help_text=QT_TR_NOOP(
            "Uses the settings shown; the defaults suit most flights. Each run is saved "
            "with its settings and can be repeated exactly."
        ),
    ),
    "runs": FieldHelp(
        title=QT_TR_NOOP("Saved runs"),
        help_text=QT_TR_NOOP(
            "All runs with their settings. Space marks one for comparison with the "
            "selected run. Enter repeats a run exactly and shows it in the figures."
        ),
    ),
}
"""By field of the panel."""


def format_maneuver_count(inputs: Sequence[Sequence[str]], flights: int) -> str:
    """Return what will be estimated from: ``8 maneuvers of 2 flights: 5 de, 3 da+dr``.

    Parameters
    ----------
    inputs : sequence of sequence of str
        Surfaces that each maneuver moved.
    """
    count = len(inputs)
    kinds: dict[str, int] = {}
    for one in inputs:
        name = "+".join(one) or tr("none")
        kinds[name] = kinds.get(name, 0) + 1
    parts = ", ".join(f"{number} {name}" for name, number in kinds.items())
    whole = count_text(count, "maneuver")
    of = tr(" of {flights} flights").format(flights=flights) if flights > 1 else ""
    return f"{whole}{of}: {parts}"
