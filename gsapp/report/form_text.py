"""Derivatives in other forms, in rows of tables and for programs."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import asdict, dataclass
from typing import Any, Final

from gsapp.dynamics.linearization import LinearModel
from gsapp.identification.axes import AXIS_TITLES
from gsapp.identification.campaign import CampaignResult, CampaignValue
from gsapp.identification.linear_models.signals import LinearAxis
from gsapp.identification.summary import CampaignSummary
from gsapp.identification.summary.derivative_forms import (
    FORM_TITLES,
    DerivativeForms,
    forms_of_estimate,
    forms_of_means,
)
from gsapp.quantities import channel
from gsapp.quantities.units import from_si
from gsapp.report.estimate_text import decimals_for_std
from gsapp.report.linear_text import (
    MODE_BOUND_COLUMNS,
    linear_model_json,
    mode_cells,
    number_or_none,
)

FORM_COLUMNS: Final = ("derivative", "value", "bound", "unit")
_SPEED: Final = channel("V").quantity


def form_rows(forms: DerivativeForms, form: str, units: str) -> tuple[tuple[str, ...], ...]:
    """Return a row for each derivative of a form, as `FORM_COLUMNS` has them."""
    rows = []
    for name, one in forms.values.get(form, {}).items():
        value, std, unit = one.value, one.std, one.unit
        if units == "US" and unit.startswith("m/"):
            value, std = from_si(value, "ft/s", _SPEED), from_si(std, "ft/s", _SPEED)
            unit = unit.replace("m/", "ft/")
        digits = decimals_for_std(std)
        rows.append((name, f"{value:z.{digits}f}", f"{std:.{digits}f}", unit))
    return tuple(rows)


@dataclass(frozen=True, slots=True, kw_only=True)
class FormTable:
    """Derivatives in one form, or a matrix: rows of text; all but the first column are numbers."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


def form_tables(
    forms: Mapping[LinearAxis, DerivativeForms],
    units: str,
    wanted: Collection[str],
    source: str = "means",
) -> tuple[FormTable, ...]:
    """Return the tables of some forms.

    `source`: of the derivatives, in words.
    """
    tables = []
    for form in wanted:
        for axis, one in forms.items():
            title = f"{AXIS_TITLES[axis].capitalize()} {FORM_TITLES[form]}, {source}"
            rows = form_rows(one, form, units)
            if rows:
                title += f", {_condition(one, form, units)}"
                tables.append(FormTable(title=title, columns=FORM_COLUMNS, rows=rows))
            elif form == "state-space" and one.model is not None and one.vane_model is not None:
                tables.append(_matrix_table(one.model, f"{title}: SI, radians, at the CG"))
                if any(one.vane):
                    tables.append(_matrix_table(one.vane_model, f"{title}: at the vane"))
                cells = tuple(mode_cells(mode) for mode in one.modes)
                tables.append(FormTable(title="", columns=MODE_BOUND_COLUMNS, rows=cells))
    return tuple(tables)


def campaign_form_tables(
    result: CampaignResult, summary: CampaignSummary, units: str, wanted: Collection[str]
) -> tuple[FormTable, ...]:
    """Return the tables of the means, and of each joint fit, in some forms."""
    means = {name: one.value for name, one in summary.derivatives.items()}
    tables = form_tables(forms_of_means(result, means), units, wanted)
    for one in result.joint:
        tables += form_tables(forms_of_estimate(result, one), units, wanted, "joint fit")
    return tables


def _condition(one: DerivativeForms, form: str, units: str) -> str:
    spec = channel("V")
    unit = spec.display_unit(units)
    V = from_si(one.condition.U1, unit, spec.quantity)
    text = f"at V = {V:.{spec.decimals(unit)}f} {unit}"
    if form == "dimensional-vane":
        length = "ft" if units == "US" else "m"
        x = from_si(one.vane[0], length, "length")
        angle = "alpha" if one.axis == "lon" else "beta"
        text += f", {angle} vane {x:.2f} {length} ahead of the CG"
    return text


def _matrix_table(model: LinearModel, title: str) -> FormTable:
    """Return A and B."""
    return FormTable(
        title=title,
        columns=("", *model.states, *model.inputs),
        rows=tuple(
            (f"{state}'", *(f"{value:z.4f}" for value in (*A, *B)))
            for state, A, B in zip(model.states, model.A, model.B, strict=True)
        ),
    )


def forms_json(
    result: CampaignResult, values: Mapping[str, CampaignValue]
) -> dict[str, dict[str, Any]]:
    """Return the means, and each joint fit, in all forms, for programs (SI, radians)."""
    joint: dict[str, Any] = {}
    for estimate in result.joint:
        joint |= _axes_json(forms_of_estimate(result, estimate))
    return {"campaign": _axes_json(forms_of_means(result, values)), "joint": joint}


def _axes_json(forms: Mapping[LinearAxis, DerivativeForms]) -> dict[str, Any]:
    return {
        axis: {
            "condition": {
                "V": one.condition.U1,
                "qbar": one.condition.qbar,
                "density": one.condition.rho,
                "mass": one.condition.mass,
                "alpha": one.condition.alpha1,
                "de": one.condition.de1,
            },
            "vane": list(one.vane),
            **{
                form: {name: asdict(value) for name, value in own.items()}
                for form, own in one.values.items()
            },
            "state-space": _model_json(one),
        }
        for axis, one in forms.items()
    }


def _model_json(one: DerivativeForms) -> dict[str, Any] | None:
    if one.model is None or one.vane_model is None:
        return None
    content = linear_model_json(one.model)
    for mode, found in zip(content["modes"], one.modes, strict=True):
        mode["frequency_std"] = number_or_none(found.frequency_std)
        mode["damping_std"] = number_or_none(found.damping_std)
        mode["time_constant_std"] = number_or_none(found.time_constant_std)
    at_vane = {"A": one.vane_model.A.tolist(), "B": one.vane_model.B.tolist()}
    return {**content, "vane": at_vane}
