"""From the panel to what is asked for and back; what each choice does, and what cannot be."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from PySide6.QtCore import QObject, Signal

from gsapp.foundation import GroundStationError
from gsapp.foundation.settings import SettingError, setting_info
from gsapp.identification.axes import axis_derivatives
from gsapp.identification.estimate_settings import EstimateSettings, FitSettings
from gsapp.identification.methods import estimation_method, estimation_methods
from ui.background_job import BackgroundJob, JobProgress
from ui.estimate_form import DerivativeEntry, EstimateForm
from ui.number_format import count_text, parse_number
from ui.translation import QT_TR_NOOP, tr

if TYPE_CHECKING:
    from gsapp.aircraft import Aircraft
    from gsapp.identification.runs.request import RunRequest, SelectedManeuver

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
        title=EstimateSettings.title_of("method"),
        help_text="",  # Those of the methods: `field_help_text`.
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


def field_help_text(field: str) -> str:
    """Return what a field does, in the language of the window."""
    if field == "method":
        return " ".join(f"{tr(one.title)}: {tr(one.help_text)}" for one in _METHODS)
    return tr(FIELD_HELP[field].help_text)


def format_maneuver_count(inputs: Sequence[Sequence[str]], flights: int) -> str:
    """Return ``8 maneuvers of 2 flights: 5 de, 3 da+dr`` from the surfaces that each one moved."""
    count = len(inputs)
    kinds: dict[str, int] = {}
    for one in inputs:
        name = "+".join(one) or tr("none")
        kinds[name] = kinds.get(name, 0) + 1
    parts = ", ".join(f"{number} {name}" for name, number in kinds.items())
    whole = count_text(count, "maneuver")
    of = tr(" of {flights} flights").format(flights=flights) if flights > 1 else ""
    return f"{whole}{of}: {parts}"


_METHOD_DEPENDENT: Final = frozenset((*FitSettings.model_fields, "weights", "model"))
"""Settings that only some methods use."""
_FORM_FIELDS: Final = {
    **dict.fromkeys(("free", "free_effects", "held", "start", "priors"), "derivatives"),
    **dict.fromkeys(("states", "responses", "biases", "scale_factors", "time_shifts"), "channels"),
}
"""Where settings stand on the form, if not in a field of their own."""


def method_uses(form: EstimateForm, setting: str) -> bool:
    """Return whether the chosen method uses a setting."""
    return setting not in _METHOD_DEPENDENT or setting in estimation_method(form.method).settings


def parse_derivative_settings(form: EstimateForm) -> dict[str, Any]:
    """Return the settings of the derivatives of the axis: free, held, start values, priors.

    Raises
    ------
    SettingError
        If a number cannot be read, or is missing.
    """
    free: list[str] = []
    held: dict[str, float] = {}
    start: dict[str, float] = {}
    priors: dict[str, tuple[float, float]] = {}
    names = axis_derivatives("both" if form.six_degrees else form.axis)
    effects = list_edited_effect_parameters(form)
    for name in (*names, *effects):
        entry = form.derivative(name)
        if entry.treated == "held":
            if not entry.value:
                raise SettingError("held", tr("{name} is held: enter its value").format(name=name))
            held[name] = _number("held", name, entry.value)
            continue
        if entry.treated == "free":
            free.append(name)
        if entry.start and method_uses(form, "start"):
            start[name] = _number("start", tr("the start of {name}").format(name=name), entry.start)
        if (entry.prior or entry.deviation) and method_uses(form, "priors"):
            priors[name] = _prior(name, entry)
    if all(name in held for name in names):
        raise SettingError("held", tr("every derivative is held: free at least one"))
    return {
        "free": tuple(name for name in free if name not in effects) or None,
        "free_effects": tuple(name for name in free if name in effects),
        "held": held,
        "start": start,
        "priors": priors,
    }


def list_edited_effect_parameters(form: EstimateForm) -> tuple[str, ...]:
    """Return the parameters of effects that something is wished for, where they count."""
    if not method_uses(form, "free_effects") or not form.model:
        return ()
    return tuple(name for name in form.derivatives if is_effect_parameter(name))


def is_effect_parameter(name: str) -> bool:
    """Return whether a name is that of an effect's parameter, ``<effect id>.<parameter>``."""
    return "." in name


def load_effect_parameters(model: str, aircraft: Aircraft) -> dict[str, float]:
    """Return the parameters of the effects of a model with their values, by name.

    Raises
    ------
    GroundStationError
        If there is no such model.
    """
    from gsapp.dynamics.model import load_model

    return {
        f"{effect.id}.{parameter.name}": value
        for effect in load_model(model).effects
        for parameter, value in zip(
            effect.term(aircraft).parameters, effect.values(aircraft), strict=True
        )
    }


def _prior(name: str, entry: DerivativeEntry) -> tuple[float, float]:
    if not entry.prior or not entry.deviation:
        missing = tr("a value") if not entry.prior else tr("a deviation")
        raise SettingError(
            "priors", tr("the prior of {name} needs {missing}").format(name=name, missing=missing)
        )
    return (
        _number("priors", tr("the prior of {name}").format(name=name), entry.prior),
        _number(
            "priors",
            tr("the prior standard deviation of {name}").format(name=name),
            entry.deviation,
        ),
    )


def _number(field: str, what: str, text: str) -> float:
    found = parse_number(text)
    if found is None:
        raise SettingError(
            field,
            tr("{what}: '{text}' is not a number; write it as -0.34").format(what=what, text=text),
        )
    return found


def build_run_request(
    form: EstimateForm,
    flights: Sequence[Path],
    maneuvers: Sequence[SelectedManeuver],
    label: str = "",
) -> RunRequest:
    """Return what is asked for.

    Raises
    ------
    SettingError
        If a field holds what cannot be asked for.
    """
    from gsapp.identification.runs.request import RunRequest

    values = {name: getattr(form, name) for name in EstimateSettings.model_fields}
    # Channels can be chosen where all maneuvers are fitted in one axis.
    is_single_axis = form.axis != "both" or form.six_degrees
    own_channels = () if is_single_axis else ("responses", "states")
    used = {
        name: value
        for name, value in values.items()
        if method_uses(form, name) and name not in own_channels
    }
    used |= {"flights": flights, "maneuvers": maneuvers, "label": label}
    try:
        if method_uses(form, "held"):
            used |= parse_derivative_settings(form)
        return RunRequest(**used)
    except SettingError as error:
        raise SettingError(_FORM_FIELDS.get(error.field, error.field), str(error)) from error


def find_form_error(form: EstimateForm) -> SettingError | None:
    """Return what cannot be asked for, with its field of the form; None if all is well."""
    from gsapp.dynamics.model import load_model
    from gsapp.identification.weights import load_weights

    readers: tuple[tuple[str, Callable[[str], object]], ...] = (
        ("weights", load_weights),
        ("model", load_model),
    )
    try:
        build_run_request(form, (), ())
    except SettingError as error:
        return error
    for field, read in readers:
        name = getattr(form, field)
        if name and method_uses(form, field):
            try:
                read(name)
            except (GroundStationError, OSError) as error:
                return SettingError(field, str(error))
    return None


_OTHER_FIELDS: Final = frozenset(
    ("free", "free_effects", "held", "start", "priors", "bound_factor", "stand_ins", "label",
     "maneuver_windows", "every_grade", "as_found")
)  # fmt: skip
"""Settings that the form holds in another way, or not at all."""


def form_from_request(request: RunRequest) -> EstimateForm:
    """Return the form as it must stand to ask for a run again."""
    derivatives: dict[str, DerivativeEntry] = {}
    effects = {
        *request.free_effects,
        *filter(is_effect_parameter, (*request.held, *request.start, *request.priors)),
    }
    for name in (*axis_derivatives("both"), *sorted(effects)):
        entry = DerivativeEntry(
            treated="held"
            if name in request.held
            else "free"
            if name in (*(request.free or ()), *request.free_effects)
            else "tables",
            value=_text(request.held.get(name)),
            start=_text(request.start.get(name)),
            prior=_text(request.priors[name][0]) if name in request.priors else "",
            deviation=_text(request.priors[name][1]) if name in request.priors else "",
        )
        if entry != DerivativeEntry():
            derivatives[name] = entry
    same = {
        name: getattr(request, name)
        for name in EstimateSettings.model_fields
        if name not in _OTHER_FIELDS
    }
    return EstimateForm(
        **same,
        derivatives=derivatives,
        bound_factor=_text(request.bound_factor),
        stand_ins=", ".join(f"{name}={value!r}" for name, value in request.stand_ins.items()),
    )


def find_unrestored_settings(request: RunRequest, form: EstimateForm) -> tuple[str, ...]:
    """Return the titles of the settings of a run that the form cannot ask for again."""
    from gsapp.identification.runs.request import setting_differences, setting_title

    again = build_run_request(form, request.flights, request.maneuvers)
    # Read from their files anew, these stand in the settings of the run only.
    read = {setting_title(name) for name in ("weights", "model") if getattr(request, name)}
    return tuple(name for name, *_ in setting_differences(request, again) if name not in read)


def _text(value: float | None) -> str:
    """Return a number so that reading it gives it again to the last bit."""
    return "" if value is None else repr(float(value))


class EstimateValidator(QObject):
    """Validates forms once it has loaded what that takes."""

    loaded = Signal(object, object)
    """Names of the models and of the weights that come with the program."""

    def __init__(
        self, report_error: Callable[[BaseException], None], parent: QObject | None = None
    ) -> None:
        super().__init__(parent)
        self.ready = False
        self.problem: SettingError | None = None
        self._validated: EstimateForm | None = None
        self._model = ""
        self.effects: Mapping[str, float] = {}
        work = BackgroundJob(tr("Loading the settings"), _load, self)
        work.done.connect(self._loaded)
        work.failed.connect(report_error)
        work.start()

    def _loaded(self, names: tuple[tuple[str, ...], tuple[str, ...]]) -> None:
        self.ready = True
        self.loaded.emit(*names)

    def invalidate(self) -> None:
        """Judge anew: files may be others now."""
        self._validated = None

    def validate(self, form: EstimateForm) -> SettingError | None:
        """Return what cannot be asked for; None if all is well, or nothing is loaded yet."""
        if self.ready and self._validated != form:
            self.problem = find_form_error(form)
            self._validated = form
        return self.problem

    def load_model_effects(self, model: str, aircraft: Aircraft) -> bool:
        """Find the parameters of the effects of a model; return whether it is another one."""
        if not self.ready or model == self._model:
            return False
        self._model, self.effects = model, {}
        if model:
            # A model that cannot be read is said beside its field.
            with contextlib.suppress(GroundStationError, OSError):
                self.effects = load_effect_parameters(model, aircraft)
        return True


def _load(_progress: JobProgress) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Import what takes a second; return the names of models and weights."""
    import gsapp.identification.runs.run_execution  # noqa: F401
    from gsapp.dynamics.model import shipped_models
    from gsapp.identification.weights import shipped_weights

    return shipped_models(), shipped_weights()
