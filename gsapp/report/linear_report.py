"""Linear models in a report: how well they follow flight, and their modes (section 7.4)."""

from __future__ import annotations

from gsapp.identification.axes import AXIS_TITLES
from gsapp.identification.methods import linear_model_title
from gsapp.identification.summary.campaign_linear_models import (
    AxisValidation,
    LinearModelValidation,
)
from gsapp.quantities import channel
from gsapp.quantities.units import from_si
from gsapp.report.document import DocumentPart, DocumentSection, DocumentTable, Paragraph
from gsapp.report.linear_figures import linear_model_figure
from gsapp.report.linear_text import (
    MODE_COLUMNS,
    compare_linear_models,
    error_rows,
    mode_rows,
    validation_text,
)

__all__ = ["LinearModelValidation", "compare_linear_models", "error_table", "linear_section"]


def error_table(one: AxisValidation, method: str) -> DocumentTable:
    """Return RMS error over range in percent by variable and model: tables 7.4.1 and 7.4.2.

    Over the maneuvers kept out, then over the whole of the flights where flights were.
    """
    rows = error_rows(one.outputs, one.errors)
    over = "each held-out maneuver, with its own initial state"
    if one.whole_flight_errors:
        whole = error_rows(one.outputs, one.whole_flight_errors)
        rows += tuple((f"{name}, whole flight", *errors) for name, *errors in whole)
        over += f", and the whole of {' and '.join(one.flights)} from first to last maneuver"
    return DocumentTable(
        caption=f"RMS error over range, percent, of the {AXIS_TITLES[one.axis]} models over "
        f"{over}; * the least of each row",
        columns=("variable", *(linear_model_title(name, method) for name in one.models)),
        rows=rows,
        numeric=frozenset(range(1, 1 + len(one.models))),
    )


def _mode_table(one: AxisValidation, method: str, units: str) -> DocumentTable:
    return DocumentTable(
        caption=f"Modes of the {AXIS_TITLES[one.axis]} models that were compared"
        f"{_about(one, units)}",
        columns=("model", *MODE_COLUMNS),
        rows=tuple(
            (linear_model_title(name, method), *row)
            for name, fitted in one.models.items()
            for row in mode_rows(fitted.model)
        ),
        numeric=frozenset(range(2, 1 + len(MODE_COLUMNS))),
    )


def _speed(value: float, units: str) -> str:
    spec = channel("V")
    unit = spec.display_unit(units)
    return f"{from_si(value, unit, spec.quantity):.{spec.decimals(unit)}f} {unit}"


def _about(one: AxisValidation, units: str) -> str:
    about = next((fitted.model.operating_point for fitted in one.models.values()), None)
    return "" if about is None else f", about steady flight at {_speed(about.speed, units)}"


def linear_section(comparison: LinearModelValidation, *, units: str) -> DocumentSection:
    """Return the section on linear models: how well they follow what they never saw, their modes.

    Parameters
    ----------
    comparison : LinearModelValidation
    units : {"US", "SI"}
    """
    parts: list[DocumentPart] = []
    for one in comparison.axes.values():
        parts.append(Paragraph(text=validation_text(one)))
        parts.append(error_table(one, comparison.method))
        parts.append(linear_model_figure(one, units=units))
        parts.append(_mode_table(one, comparison.method, units))
    parts += [Paragraph(text=f"{_sentence(text)}.", kind="note") for text in comparison.remarks]
    return DocumentSection(title="Linear models against flight", parts=tuple(parts))


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:]
