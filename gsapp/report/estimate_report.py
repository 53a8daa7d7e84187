"""The report on a campaign: derivatives with bounds, and whether they can be believed.

One HTML file that needs nothing beside it, and a PDF. The same result gives the same pages, but
for the line that says when they were written.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from typing import Final, Literal

import numpy as np

from gsapp.dynamics.linearization import Mode
from gsapp.identification.campaign import CampaignResult, ManeuverResult
from gsapp.identification.ftr import EstimateHistory
from gsapp.identification.summary import CampaignSummary
from gsapp.report.document import Document, Paragraph, Part, Picture, Section, Table
from gsapp.report.estimate_words import (
    DERIVATIVE_COLUMNS,
    METHODS,
    derivative_rows,
    headline,
    honesty_words,
    maneuver_columns,
    maneuver_rows,
    outlier_rows,
    trend_words,
    unknown_rows,
    wild_words,
)
from gsapp.report.fit_figures import fit_picture, residual_picture
from gsapp.report.online_figures import online_picture
from gsapp.report.provenance import Provenance, provenance_section
from gsapp.report.value_figures import values_pictures

Units = Literal["US", "SI"]

_MOST_FITS: Final = 12
"""Maneuvers whose responses are drawn in full, the worst fitted first; the table lists all."""
_CLOSE: Final = 0.9
"""Correlation of two derivatives from which they are named."""
_ONLINE: Final = {
    "lon": ("Cm_alpha", "Cm_q", "Cm_de", "CN_alpha"),
    "lat": ("Cl_p", "Cl_da", "Cn_beta", "Cn_r", "Cn_dr", "Cl_beta"),
}
"""Derivatives whose history in the air is drawn."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Heard:
    """What FTR formed over one flight."""

    flight: str
    histories: Mapping[str, EstimateHistory]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Reported:
    """All that a report on a campaign is made from.

    Attributes
    ----------
    aircraft : str
        Name of the one that flew.
    result : CampaignResult
    summary : CampaignSummary
    known : mapping of str to float
        Derivatives known before: drawn, and listed.
    heard : tuple of Heard
        FTR over the flights; may be empty.
    modes : mapping of str to tuple of Mode
        Of the linear models with the means, by axis in words; may be empty.
    remarks : tuple of str
        Of reading the flights.
    provenance : Provenance or None
    """

    aircraft: str
    result: CampaignResult
    summary: CampaignSummary
    known: Mapping[str, float] = field(default_factory=dict)
    heard: tuple[Heard, ...] = ()
    modes: Mapping[str, tuple[Mode, ...]] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()
    provenance: Provenance | None = None


def estimate_document(
    reported: Reported, *, units: Units = "US", written: datetime | None = None
) -> Document:
    """Return the report on a campaign.

    Parameters
    ----------
    reported : Reported
    units : {"US", "SI"}
        Of pictures and tables.
    written : datetime, optional
        Stands in the line of the date; without it there is no such line.
    """
    result, summary = reported.result, reported.summary
    sections = [
        _results_section(reported, summary),
        _trust_section(reported, summary, units),
        _values_section(reported, summary, units),
        _online_section(reported, summary),
        _maneuvers_section(result, units),
        _together_section(reported),
    ]
    if reported.provenance is not None:
        sections.append(provenance_section(reported.provenance))
    flights = list(dict.fromkeys(one.maneuver.flight for one in result.results))
    return Document(
        title=f"Derivatives of the {reported.aircraft}",
        written="" if written is None else f"{written:%Y-%m-%d %H:%M}",
        facts=(
            ("Flights", ", ".join(flights)),
            ("Maneuvers", str(len(result.results))),
            ("Method", METHODS[result.settings.method]),
        ),
        sections=tuple(one for one in sections if one.parts),
    )


def _results_section(reported: Reported, summary: CampaignSummary) -> Section:
    parts: list[Part] = [Paragraph(text=headline(summary, reported.result), kind="lead")]
    if summary.derivatives:
        parts.append(
            Table(
                caption="Derivatives per radian, rates as q c/2V, p b/2V, r b/2V, about the CG of "
                "the aircraft file; means weighted by the bounds of each maneuver",
                columns=DERIVATIVE_COLUMNS,
                rows=tuple(derivative_rows(summary, reported.known)),
                numeric=frozenset(range(1, len(DERIVATIVE_COLUMNS))),
            )
        )
    unknown = unknown_rows(reported.result)
    if unknown:
        parts.append(
            Table(caption="Not earned", columns=("derivative", "status", "why"), rows=unknown)
        )
    return Section(title="What came out", parts=tuple(parts))


def _trust_section(reported: Reported, summary: CampaignSummary, units: Units) -> Section:
    parts: list[Part] = []
    if summary.derivatives:
        parts.append(Paragraph(text=honesty_words(summary)))
    parts += [Paragraph(text=text) for text in wild_words(summary)]
    rows = outlier_rows(summary)
    if rows:
        parts.append(
            Table(
                caption="Values left out of the means: farther off than bounds and chance allow",
                columns=("derivative", "maneuver", "value", "standard deviations off", "why"),
                rows=rows,
                numeric=frozenset({2, 3}),
            )
        )
    trends = trend_words(summary, units)
    parts += [Paragraph(text=text) for text in trends]
    if (
        summary.derivatives
        and not trends
        and any(one.trends for one in summary.derivatives.values())
    ):
        parts.append(
            Paragraph(
                text="No derivative changes provably with speed, angle of attack or sideslip."
            )
        )
    said = dict.fromkeys((*reported.remarks, *reported.result.remarks))
    parts += [Paragraph(text=text, kind="note") for text in said]
    return Section(title="Can it be believed?", parts=tuple(parts))


def _values_section(reported: Reported, summary: CampaignSummary, units: Units) -> Section:
    over = [
        name
        for name in ("V", "alpha", "beta")
        if any(
            trend.condition == name for one in summary.derivatives.values() for trend in one.trends
        )
    ]
    parts: list[Part] = []
    for name in (*over, "number"):
        parts += values_pictures(summary, name, units=units, known=reported.known)
    return Section(title="Each value, maneuver by maneuver", parts=tuple(parts))


def _online_section(reported: Reported, summary: CampaignSummary) -> Section:
    wanted = [name for names in _ONLINE.values() for name in names]
    parts = []
    for number, one in enumerate(reported.heard, start=1):
        histories = [one.histories[name] for name in wanted if name in one.histories]
        if histories:
            parts.append(online_picture(histories, reported.result, summary, one.flight, number))
    return Section(title="As it formed in the air", parts=tuple(parts))


def _maneuvers_section(result: CampaignResult, units: Units) -> Section:
    columns = maneuver_columns(units)
    parts: list[Part] = [
        Table(
            caption="Maneuvers, and the response that each fit follows worst",
            columns=columns,
            rows=maneuver_rows(result.results, units),
            numeric=frozenset({4, 5}),
        )
    ]
    drawn = sorted(result.results, key=_worst_fit)[:_MOST_FITS]
    pictures: list[Picture | None] = [fit_picture(one, units=units) for one in drawn]
    pictures += [residual_picture(one, units=units) for one in drawn[:2]]
    parts += [one for one in pictures if one is not None]
    return Section(title="Maneuvers", parts=tuple(parts))


def _worst_fit(result: ManeuverResult) -> float:
    fits = () if result.estimate is None else result.estimate.fit.values()
    return min((fit.r2 for fit in fits), default=np.inf)


def _together_section(reported: Reported) -> Section:
    parts: list[Part] = []
    rows = _correlated(reported.result)
    if rows:
        parts.append(
            Table(
                caption="Derivatives that a single maneuver can hardly tell apart: correlations "
                f"beyond {_CLOSE} in size",
                columns=("one", "other", "in how many fits", "correlation there"),
                rows=rows,
                numeric=frozenset({2, 3}),
            )
        )
    for axis, modes in reported.modes.items():
        parts.append(
            Table(
                caption=f"Modes of the linear {axis} model made from the means",
                columns=("mode", "frequency [rad/s]", "damping ratio", "time constant [s]"),
                rows=tuple(
                    (
                        one.name,
                        f"{one.frequency:.2f}",
                        f"{one.damping:.2f}",
                        f"{one.time_constant:.2f}",
                    )
                    for one in modes
                ),
                numeric=frozenset({1, 2, 3}),
            )
        )
    return Section(title="Correlations and modes", parts=tuple(parts))


def _correlated(result: CampaignResult) -> tuple[tuple[str, str, str, str], ...]:
    """Return the pairs that are close in some fit, those close most often first."""
    every = [one.estimate for one in result.results if one.estimate is not None]
    close: dict[tuple[str, str], list[float]] = {}
    for estimate in (*result.joint, *every):
        matrix = estimate.correlation
        for row, one in enumerate(estimate.free):
            for column, other in enumerate(estimate.free[:row]):
                value = float(matrix[row, column])
                if abs(value) > _CLOSE and not (one + other).count("_0"):
                    close.setdefault((other, one), []).append(value)
    ordered = sorted(close.items(), key=lambda pair: (-len(pair[1]), pair[0]))
    return tuple(
        (one, other, str(len(values)), f"{float(np.median(values)):+.3f}")
        for (one, other), values in ordered
    )
