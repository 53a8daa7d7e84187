"""The report on a campaign: derivatives with bounds, and whether they can be believed.

One HTML file that needs nothing beside it, and a PDF. The same result gives the same pages, but
for the line that says when they were written.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from datetime import datetime
from typing import Final, Literal

import numpy as np

from gsapp.foundation import FlightError
from gsapp.identification.axes import AXIS_TITLES
from gsapp.identification.campaign import CampaignResult, ManeuverResult
from gsapp.identification.methods import estimation_method
from gsapp.identification.runs.run_execution import RunOutcome
from gsapp.identification.summary import CONDITIONS, CampaignSummary
from gsapp.identification.summary.campaign_linear_models import (
    LinearModelValidation,
)
from gsapp.identification.summary.derivative_forms import FORM_TITLES, forms_of_means
from gsapp.identification.summary.method_comparison import contradiction_warnings
from gsapp.identification.summary.mode_uncertainty import (
    ModeUncertainty,
    propagate_mode_uncertainty,
)
from gsapp.report.document import (
    Document,
    DocumentFigure,
    DocumentPart,
    DocumentSection,
    DocumentTable,
    Paragraph,
    convert_units,
)
from gsapp.report.estimate_text import (
    DERIVATIVE_COLUMNS,
    JOINT_COLUMNS,
    bound_consistency_text,
    derivative_rows,
    estimate_headline,
    exclusion_text,
    joint_rows,
    maneuver_columns,
    maneuver_rows,
    outlier_maneuver_text,
    outlier_rows,
    prior_values,
    trend_text,
    unknown_rows,
)
from gsapp.report.fit_diagnostics import (
    fit_diagnostics_section,
    gusty_maneuvers_text,
    mean_comparison_table,
    method_comparison_table,
)
from gsapp.report.fit_figures import fit_figure, residual_figure
from gsapp.report.form_text import form_tables
from gsapp.report.ftr_histories import FlightEstimateHistory
from gsapp.report.linear_report import linear_section
from gsapp.report.mode_figures import modes_figure, modes_table
from gsapp.report.online_figures import online_estimates_figure
from gsapp.report.provenance import campaign_provenance, provenance_section
from gsapp.report.residual_text import residual_text
from gsapp.report.settings import REPORT
from gsapp.report.value_figures import value_figures

ReportUnits = Literal["US", "SI"]

_HALF_A_PAGE: Final = 4.5
"""Height of a picture of which two fit on a page with their captions, inches."""
_HOW_TO_READ: Final = (
    "The bound of the mean is one standard deviation; beside it in percent of the mean. It covers "
    "noise, errors of instruments and aircraft file that all maneuvers share, and what maneuvers "
    "and methods disagree. The truth lies within two bounds in 95 % of all cases. Scatter is the "
    "standard "
    "deviation from maneuver to maneuver; over the bounds of single maneuvers it is near 1 where "
    "these are consistent. Before: known before; n: maneuvers that count."
)
_ORDER_TEXT: Final = "{drawn}, worst fit first."
_NO_TREND: Final = "No significant trend with speed, angle of attack or sideslip."
_NOT_TESTED: Final = (
    "Trends with speed, angle of attack or sideslip were not tested: more maneuvers or a wider "
    "range of conditions are needed."
)
_ONLINE: Final = {
    "lon": ("Cm_alpha", "Cm_q", "Cm_de", "CN_alpha"),
    "lat": ("Cl_p", "Cl_da", "Cn_beta", "Cn_r", "Cn_dr", "Cl_beta"),
}
"""Derivatives whose history in the air is drawn."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CampaignReportData:
    """All that a report on a campaign is made from."""

    outcome: RunOutcome
    ftr_histories: tuple[FlightEstimateHistory, ...] = ()
    linear: LinearModelValidation

    @property
    def result(self) -> CampaignResult:
        return self.outcome.result

    @property
    def summary(self) -> CampaignSummary:
        return self.outcome.summary


def estimate_document(
    reported: CampaignReportData, *, units: ReportUnits = "US", written: datetime | None = None
) -> Document:
    """Return the report on a campaign.

    Parameters
    ----------
    written : datetime, optional
        Stands in the line of the date, with the number of the run where it is kept in a catalog;
        without it there is no such line.
    """
    outcome = reported.outcome
    flights = list(dict.fromkeys(one.maneuver.flight for one in outcome.result.results))
    sections = (
        _results_section(reported),
        _trust_section(reported, units),
        _values_section(reported, units),
        _online_section(reported),
        linear_section(reported.linear, units=units),
        _modes_section(reported, units),
        _forms_section(reported, units),
        _maneuvers_section(outcome.result, units),
        fit_diagnostics_section(outcome.result),
        provenance_section(campaign_provenance(outcome)),
    )
    document = Document(
        title=f"Derivatives of the {outcome.aircraft}",
        written="" if written is None else _written(written, outcome.number),
        facts=(
            ("Flights", ", ".join(flights)),
            ("Maneuvers", str(len(outcome.result.results))),
            ("Method", estimation_method(outcome.result.settings.method).title),
        ),
        sections=tuple(one for one in sections if one.parts),
    )
    return convert_units(document, units)


def _written(when: datetime, number: int | None) -> str:
    """Return the line of the date: it alone differs between two reports on the same."""
    run = "" if number is None else f"; run {number} of the catalog"
    return f"{when:%Y-%m-%d %H:%M}{run}"


def _results_section(reported: CampaignReportData) -> DocumentSection:
    summary = reported.summary
    parts: list[DocumentPart] = [
        Paragraph(text=estimate_headline(summary, reported.result), kind="lead")
    ]
    if summary.derivatives:
        parts.append(
            DocumentTable(
                caption="Derivatives per radian, rates as q c/2V, p b/2V, r b/2V, about the CG of "
                "the aircraft file; means weighted by the bound of each maneuver and by what the "
                "maneuvers scatter beyond their bounds",
                columns=DERIVATIVE_COLUMNS,
                rows=tuple(derivative_rows(summary, prior_values(reported.result))),
                numeric=frozenset(range(1, len(DERIVATIVE_COLUMNS))),
            ).without_empty_columns()
        )
        parts.append(Paragraph(text=_HOW_TO_READ, kind="note"))
    joint = joint_rows(reported.result, summary)
    if joint:
        parts.append(
            DocumentTable(
                caption="Joint fit of all maneuvers of an axis and the means; both use the "
                "same maneuvers, so a difference above 1 joint bound is large",
                columns=JOINT_COLUMNS,
                rows=joint,
                numeric=frozenset(range(1, len(JOINT_COLUMNS))),
            )
        )
    unknown = unknown_rows(reported.result)
    if unknown:
        parts.append(
            DocumentTable(
                caption="Not estimated", columns=("derivative", "status", "why"), rows=unknown
            )
        )
    return DocumentSection(title="Results", parts=tuple(parts))


def _trust_section(reported: CampaignReportData, units: ReportUnits) -> DocumentSection:
    summary = reported.summary
    parts: list[DocumentPart] = []
    if summary.derivatives:
        parts.append(Paragraph(text=bound_consistency_text(summary)))
    parts += [Paragraph(text=text) for text in residual_text(reported.result)]
    parts += [Paragraph(text=text) for text in gusty_maneuvers_text(reported.result)]
    parts += [Paragraph(text=f"{text}.") for text in contradiction_warnings(reported.result)]
    means = mean_comparison_table(reported.result)
    if means is not None:
        parts.append(means)
    parts += [Paragraph(text=text) for text in exclusion_text(summary)]
    parts += [Paragraph(text=text) for text in outlier_maneuver_text(summary)]
    rows = outlier_rows(summary)
    if rows:
        parts.append(
            DocumentTable(
                caption="Values excluded from the means (outliers)",
                columns=("derivative", "maneuver", "value", "standard deviations off", "why"),
                rows=rows,
                numeric=frozenset({2, 3}),
            )
        )
    trends = trend_text(summary, units)
    parts += [Paragraph(text=text) for text in trends]
    if summary.derivatives and not trends:
        tested = any(one.trends for one in summary.derivatives.values())
        parts.append(Paragraph(text=_NO_TREND if tested else _NOT_TESTED))
    unheard = (
        f"{one.flight}: FTR not computed: {one.why}" for one in reported.ftr_histories if one.why
    )
    said = dict.fromkeys((*reported.outcome.remarks, *unheard, *reported.result.remarks))
    parts += [Paragraph(text=text, kind="note") for text in said]
    return DocumentSection(title="Validity", parts=tuple(parts))


def _values_section(reported: CampaignReportData, units: ReportUnits) -> DocumentSection:
    summary, known = reported.summary, prior_values(reported.result)
    over = [
        name
        for name in CONDITIONS
        if any(
            trend.condition == name for one in summary.derivatives.values() for trend in one.trends
        )
    ]
    parts: list[DocumentPart] = []
    for name in (*over, "number"):
        parts += value_figures(summary, name, units=units, known=known)
    return DocumentSection(title="Values by maneuver", parts=tuple(parts))


def _online_section(reported: CampaignReportData) -> DocumentSection:
    result, summary = reported.result, reported.summary
    wanted = [name for names in _ONLINE.values() for name in names]
    parts = []
    for number, one in enumerate(reported.ftr_histories[: REPORT.max_ftr_flights], start=1):
        flown = {
            name
            for found in result.results
            if found.estimate is not None and found.maneuver.flight == one.flight
            for name in found.estimate.free
        }
        # What this flight says nothing of has no chart.
        histories = [
            one.histories[name]
            for name in wanted
            if name in one.histories
            and (name in flown or np.isfinite(one.histories[name].values).any())
        ]
        if histories:
            parts.append(online_estimates_figure(histories, result, summary, one.flight, number))
    return DocumentSection(title="Estimates in flight", parts=tuple(parts))


def _modes_section(reported: CampaignReportData, units: ReportUnits) -> DocumentSection:
    modes: dict[str, tuple[ModeUncertainty, ...]] = {}
    for axis in reported.outcome.models:
        try:
            modes[AXIS_TITLES[axis]] = propagate_mode_uncertainty(
                reported.result, reported.summary, axis
            )
        except FlightError:
            # Said among the remarks by whatever made the models.
            continue
    parts: tuple[DocumentPart, ...] = (
        (modes_table(modes, units), modes_figure(modes)) if modes else ()
    )
    return DocumentSection(title="Dynamic modes", parts=parts)


def _forms_section(reported: CampaignReportData, units: ReportUnits) -> DocumentSection:
    """Return the means in the forms that others publish, but for what other sections hold."""
    means = {name: one.value for name, one in reported.summary.derivatives.items()}
    forms = forms_of_means(reported.result, means)
    wanted = [form for form in FORM_TITLES if form != "state-space"]
    return DocumentSection(
        title="Other forms",
        parts=tuple(
            DocumentTable(
                caption=one.title, columns=one.columns, rows=one.rows, numeric=frozenset({1, 2})
            )
            for one in form_tables(forms, units, wanted)
        ),
    )


def _maneuvers_section(result: CampaignResult, units: ReportUnits) -> DocumentSection:
    columns = maneuver_columns(units)
    parts: list[DocumentPart] = [
        DocumentTable(
            caption="Maneuvers, and the worst-fitted response of each",
            columns=columns,
            rows=maneuver_rows(result.results, units),
            numeric=frozenset({4, 5}),
        )
    ]
    drawn = sorted(result.results, key=_worst_fit)[: REPORT.max_fits]
    few = f"the {len(drawn)} fitted worst are drawn" if len(drawn) < len(result.results) else ""
    parts.append(Paragraph(text=_ORDER_TEXT.format(drawn=few or "all are drawn"), kind="note"))
    for one in drawn:
        parts += _on_half_a_page(fit_figure(one, units=units))
        beside = method_comparison_table(one)
        if beside is not None:
            parts.append(beside)
    for one in drawn[:2]:
        parts += _on_half_a_page(residual_figure(one, units=units))
    return DocumentSection(title="Maneuvers", parts=tuple(parts))


def _on_half_a_page(picture: DocumentFigure | None) -> tuple[DocumentFigure, ...]:
    if picture is None:
        return ()
    return (replace(picture, height=min(picture.height, _HALF_A_PAGE)),)


def _worst_fit(result: ManeuverResult) -> float:
    fits = () if result.estimate is None else result.estimate.fit.values()
    return min((fit.r2 for fit in fits), default=np.inf)
