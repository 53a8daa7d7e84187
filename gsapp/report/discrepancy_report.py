"""The report on a search for a missing effect: the story in four steps, for a supervisor.

One HTML file that needs nothing beside it, and a PDF. The same answer gives the same pages, but
for the line that says when they were written.
"""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import Literal

import numpy as np

from gsapp.discrepancy.results import DiscrepancyResult, ManeuverHistories
from gsapp.foundation import GroundStationError
from gsapp.quantities import clock_text
from gsapp.report.discrepancy_figures import (
    coefficient_map_figure,
    gap_figure,
    misfit_waterfall_figure,
    missing_by_condition_figure,
    missing_history_figure,
    ranking_figure,
    residual_map_figure,
    response_overlay_figure,
    structure_figure,
)
from gsapp.report.discrepancy_text import (
    HEADLINES,
    change_text,
    closed_gap_text,
    coefficient_label,
    disagreement_sentence,
    disturbance_text,
    effect_class_text,
    effect_text,
    experiment_text,
    format_confidence,
    format_p_value,
    gain_text,
    parameter_rows,
    residual_remarks,
    rms_rows,
    value_with_std,
)
from gsapp.report.document import (
    Document,
    DocumentPart,
    DocumentSection,
    DocumentTable,
    Paragraph,
    convert_units,
)
from gsapp.report.document_writer import check_report_path, write_document
from gsapp.report.provenance import Provenance, provenance_section
from gsapp.report.settings import REPORT

DiscrepancyReportUnits = Literal["US", "SI"]

_NO_DISAGREEMENT_TEXT = "No disagreement between model and flight exceeds the noise."
_OPPOSITE = {"CN": "CZ", "CA": "CX"}
_MOST_COEFFICIENTS, _MOST_OVERLAYS, _MOST_OVER_TIME, _MOST_ROWS = 2, 3, 5, 25


def write_discrepancy_report(
    found: DiscrepancyResult,
    out: Path,
    *,
    aircraft: str = "",
    provenance: Provenance | None = None,
    units: DiscrepancyReportUnits = "US",
    overlays: Sequence[str] | None = None,
    written: datetime | None = None,
) -> tuple[Path, ...]:
    """Write the report.

    Parameters
    ----------
    out : Path
        A folder for ``report.html``, ``report.pdf`` and ``figures/*.png``; or one file that ends in
        ``.html`` or ``.pdf``.
    provenance : Provenance, optional
        Files with their sums, settings, versions (`search_provenance`): the last section.
    units : {"US", "SI"}
        Of the pictures and tables of channels.
    overlays : sequence of str, optional
        Ids of the maneuvers drawn in full; by default those kept out that were worst before.
    written : datetime, optional
        Stands in the line of the date; without it there is no such line.

    Raises
    ------
    GroundStationError
        If a file has another ending, or a maneuver of `overlays` is not there.
    OSError
        If the disk refuses.
    """
    check_report_path(out)
    document = discrepancy_document(
        found, aircraft=aircraft, provenance=provenance, units=units, overlays=overlays,
        written=written,
    )  # fmt: skip
    return write_document(document, out)


def discrepancy_document(
    found: DiscrepancyResult,
    *,
    aircraft: str = "",
    provenance: Provenance | None = None,
    units: DiscrepancyReportUnits = "US",
    overlays: Sequence[str] | None = None,
    written: datetime | None = None,
) -> Document:
    """Return the report before it is printed; parameters as `write_discrepancy_report`."""
    document = Document(
        title="Where simulation and flight disagree",
        written="" if written is None else f"{written:%Y-%m-%d %H:%M %Z}".strip(),
        facts=_facts(found, aircraft),
        sections=(
            _in_short(found, units),
            _find(found, units),
            _name(found),
            _add(found, units),
            _show(found, units, _chosen(found, overlays)),
            _observable(found),
            _terms(),
            *(() if provenance is None else (provenance_section(provenance),)),
        ),
    )
    return convert_units(document, units)


def _facts(found: DiscrepancyResult, aircraft: str) -> tuple[tuple[str, str], ...]:
    flights = dict.fromkeys(one.flight for one in found.maneuvers)
    kept = [one.id for one in found.maneuvers if one.held_out]
    samples = sum(one.times.size for one in found.maneuvers)
    return (
        *((("Aircraft", aircraft),) if aircraft else ()),
        ("Flights", ", ".join(flights)),
        ("Maneuvers", f"{len(found.maneuvers)}, {samples} samples"),
        ("Held out", ", ".join(kept) or "none"),
        ("Previous model", found.steps[0].model.parent or found.steps[0].model.name),
        ("Next model", found.model.name),
    )


# --- the sections -------------------------------------------------------------------------------


def _in_short(found: DiscrepancyResult, units: DiscrepancyReportUnits) -> DocumentSection:
    parts: list[DocumentPart] = [
        Paragraph(text=HEADLINES[found.verdict], kind="lead"),
        Paragraph(text=found.why),
        *(Paragraph(text=effect_text(one, units)) for one in found.effects),
        Paragraph(text=closed_gap_text(found)),
    ]
    if found.experiment is not None:
        parts.append(Paragraph(text=experiment_text(found.experiment, units)))
    if disturbance_text(found):
        parts.append(Paragraph(text=disturbance_text(found)))
    parts += [Paragraph(text=f"Note: {sentence}", kind="note") for sentence in found.warnings]
    return DocumentSection(title="Summary", parts=tuple(parts))


def _find(found: DiscrepancyResult, units: DiscrepancyReportUnits) -> DocumentSection:
    parts: list[DocumentPart] = [
        Paragraph(
            text="The model was flown through every maneuver with the inputs that were measured. "
            "What force and moment it lacked was worked out from the measured motion and compared "
            "with what noise alone would give. First the instruments were compared with one "
            "another, without any aerodynamics, so that they are not mistaken for the aircraft."
        )
    ]
    odd = [one for one in found.instruments if not one.consistent]
    if found.instruments:
        good = "All instruments agree with one another." if not odd else ""
        parts.append(Paragraph(text=good or "Instruments: " + "; ".join(one.words for one in odd)))
    parts += [residual_map_figure(found), coefficient_map_figure(found)]
    if found.disagreements:
        parts += [
            Paragraph(
                text=f"Largest disagreement: {disagreement_sentence(found.disagreements[0])}"
            ),
            _disagreements(found),
        ]
    else:
        parts.append(Paragraph(text=_NO_DISAGREEMENT_TEXT))
    for coefficient in _coefficients(found):
        parts += [
            missing_history_figure(found, coefficient, _worst(found, coefficient)),
            missing_by_condition_figure(found, coefficient, _region(found, coefficient), units),
        ]
    return DocumentSection(title="1. Find: where do they disagree?", parts=tuple(parts))


def _disagreements(found: DiscrepancyResult) -> DocumentTable:
    shown = found.disagreements[:_MOST_ROWS]
    more = len(found.disagreements) - len(shown)
    return DocumentTable(
        caption="Disagreements beyond the noise, most significant first"
        + (f" ({more} more are in the JSON)" if more else ""),
        columns=("what", "most in", "maneuver", "from", "to", "times noise", "chance",
                 "where"),
        rows=tuple(
            (
                coefficient_label(one.coefficient) if one.coefficient else "instrument",
                one.channel,
                one.maneuver,
                clock_text(one.t_start, decimals=1),
                clock_text(one.t_end, decimals=1),
                f"{one.rms / one.noise_floor:.1f}" if one.noise_floor > 0.0 else "",
                format_p_value(one.p_value),
                one.region.words if one.region else "",
            )
            for one in shown
        ),
        numeric=frozenset({3, 4, 5, 6}),
    )  # fmt: skip


def _name(found: DiscrepancyResult) -> DocumentSection:
    parts: list[DocumentPart] = [
        Paragraph(
            text="Every effect of the catalog, and structures without a name, competed for what is "
            "missing. A name is given only if it wins by a margin over what looks most like it, "
            "and on maneuvers that had no part in choosing it."
        )
    ]
    if not any(step.ranking for step in found.steps):
        parts.append(Paragraph(text="No effect to name."))
    parts += [
        ranking_figure(step, number, last=step is found.steps[-1])
        for number, step in enumerate(found.steps, start=1)
        if step.ranking
    ]
    if found.effects:
        parts.append(
            DocumentTable(
                caption="Named",
                columns=("effect", "in words", "confidence", "next best", "margin", "held out"),
                rows=tuple(
                    (
                        one.effect,
                        one.title,
                        format_confidence(one),
                        one.runner_up,
                        f"{one.margin:.1f}" if one.runner_up else "",
                        gain_text(one.held_out),
                    )
                    for one in found.effects
                ),
                numeric=frozenset({4, 5}),
            )
        )
    if found.alternatives:
        parts.append(
            DocumentTable(
                caption="Indistinguishable effects",
                columns=("effect", "in words", "why", "distinguished by"),
                rows=tuple(
                    (" and ".join(one.effects), one.title, one.why, one.fly)
                    for one in found.alternatives
                ),
            )
        )
    return DocumentSection(title="2. Name: which effect is missing?", parts=tuple(parts))


def _add(found: DiscrepancyResult, units: DiscrepancyReportUnits) -> DocumentSection:
    parts: list[DocumentPart] = []
    if found.effects:
        parts += [
            Paragraph(
                text="Each effect became a term of the model, and all free values were fitted "
                "again together, the effect's own among them."
            ),
            DocumentTable(
                caption="Effects in the model",
                columns=("effect", "equation"),
                rows=tuple((one.effect, one.equation) for one in found.effects),
            ),
            DocumentTable(
                caption="Their parameters, with one standard deviation",
                columns=("effect", "parameter", "value", "unit"),
                rows=parameter_rows(found.effects, units),
                numeric=frozenset({2}),
            ),
            *(structure_figure(one, units) for one in found.structures),
        ]
    if found.values:
        parts.append(
            DocumentTable(
                caption="Values that moved beyond their bounds",
                columns=("derivative", "before", "after", "moved [std]"),
                rows=tuple(
                    (
                        name,
                        f"{one.before:.4g}",
                        value_with_std(one.after, one.std),
                        change_text(one),
                    )
                    for name, one in found.values.items()
                ),
                numeric=frozenset({1, 2, 3}),
            )
        )
    if not parts:
        parts.append(Paragraph(text="No effect was added."))
    model = found.model
    if model.parent:
        evidence = f" {model.evidence}" if model.evidence else ""
        parts.append(
            Paragraph(text=f"The model '{model.name}' revises '{model.parent}'.{evidence}")
        )
    return DocumentSection(title="3. Add: the model with the effect", parts=tuple(parts))


def _show(
    found: DiscrepancyResult, units: DiscrepancyReportUnits, overlays: Sequence[ManeuverHistories]
) -> DocumentSection:
    parts: list[DocumentPart] = [
        Paragraph(text=text) for text in (closed_gap_text(found), *residual_remarks(found))
    ]
    if found.gap.channels:
        parts.append(gap_figure(found))
    if len(found.steps) > 1:
        parts.append(misfit_waterfall_figure(found))
    if found.gap.channels:
        parts.append(_channels(found, units))
    parts += [response_overlay_figure(view, units) for view in overlays]
    return DocumentSection(title="4. Show: does the gap shrink?", parts=tuple(parts))


def _channels(found: DiscrepancyResult, units: DiscrepancyReportUnits) -> DocumentTable:
    rows: list[tuple[str, ...]] = [
        (
            *rms,
            f"{one.before_pct:.1f}",
            f"{one.after_pct:.1f}",
            f"{one.theil_before:.3f}",
            f"{one.theil_after:.3f}",
            f"{100.0 * one.within_before:.0f}",
            f"{100.0 * one.within_after:.0f}",
        )
        for rms, one in zip(rms_rows(found.gap, units), found.gap.channels.values(), strict=True)
    ]
    columns: tuple[str, ...]
    columns = ("channel", "RMS before", "after", "noise", "over range before [%]", "after [%]",
               "Theil before", "after", "within 3 x noise before [%]", "after [%]")  # fmt: skip
    if len(found.steps) == 1:
        kept = (0, 1, 3, 4, 6, 8)
        columns = ("channel", "RMS", "noise", "over range [%]", "Theil", "within 3 x noise [%]")
        rows = [tuple(row[place] for place in kept) for row in rows]
    return DocumentTable(
        caption="Residuals on the held-out maneuvers",
        columns=columns,
        rows=tuple(rows),
        numeric=frozenset(range(1, len(columns))),
    )


def _observable(found: DiscrepancyResult) -> DocumentSection:
    parts: list[DocumentPart] = [
        Paragraph(
            text="Worked out before any verdict, for these very maneuvers: how clearly each effect "
            "of usual size would show, after the model's own values have taken what they can, and "
            "what it looks most like (1: exactly alike)."
        )
    ]
    order = sorted(found.observability, key=lambda one: -np.nan_to_num(one.sigma))
    clear = [one for one in order if one.sigma >= REPORT.clear_sigmas]
    faint = [one for one in order if not one.sigma >= REPORT.clear_sigmas]
    if clear:
        parts.append(
            DocumentTable(
                caption=f"Would show clearly: {REPORT.clear_sigmas:g} standard deviations or more",
                columns=("effect", "class", "standard deviations", "most similar to"),
                rows=tuple(
                    (
                        one.effect,
                        one.effect_class,
                        f"{one.sigma:.0f}",
                        ", ".join(f"{name} ({cosine:.2f})" for name, cosine in one.aliases[:2]),
                    )
                    for one in clear
                ),
                numeric=frozenset({2}),
            )
        )
    together: dict[str, list[str]] = {}
    for one in faint:
        sigma = f", {one.sigma:.1f}" if np.isfinite(one.sigma) and one.sigma > 0.0 else ""
        together.setdefault(one.fly, []).append(f"{one.effect} ({one.effect_class}{sigma})")
    if faint:
        parts.append(
            DocumentTable(
                caption="Would not",
                columns=("effect (class, standard deviations)", "to see it"),
                rows=tuple((", ".join(names), fly) for fly, names in together.items()),
            )
        )
    if found.observability:
        classes = sorted({one.effect_class for one in found.observability})
        parts.append(
            Paragraph(
                text="; ".join(f"Class {name}: {effect_class_text(name)}" for name in classes)
                + ".",
                kind="note",
            )
        )
    return DocumentSection(title="Observability", parts=tuple(parts))


def _terms() -> DocumentSection:
    return DocumentSection(
        title="Terms",
        parts=tuple(
            Paragraph(text=text)
            for text in (
                "Noise floor: residual of a perfect model, estimated from the flight data.",
                "Held out: maneuvers used neither to name the effect nor to fit its size. An "
                "overfitted model fails on them.",
                "Gap: residual beyond the noise floor, which a model can close.",
                "Chance: probability of so large a disagreement from noise alone, corrected "
                "for the number of tests.",
                "Confidence: of names given with 90 %, nine in ten are right.",
                "Theil's coefficient: 0 is a perfect match, 1 the worst; below about 0.3 is "
                "usually called good.",
            )
        ),
    )


# --- what is shown ------------------------------------------------------------------------------


def _coefficients(found: DiscrepancyResult) -> tuple[str, ...]:
    """Return the coefficients to draw over time: those that effects add to, else the worst."""
    targets = [one.effect.split(".")[1] for one in found.effects if "." in one.effect]
    named = [_OPPOSITE.get(one, one) for one in targets]
    known = [one for one in named if one in found.coefficients]
    worst = [one.coefficient for one in found.disagreements if one.coefficient]
    return tuple(dict.fromkeys(known or worst))[:_MOST_COEFFICIENTS]


def _region(found: DiscrepancyResult, coefficient: str) -> str:
    for one in found.disagreements:
        if one.coefficient == coefficient and one.region is not None:
            return one.region.variable
    return ""


def _worst(found: DiscrepancyResult, coefficient: str) -> tuple[str, ...]:
    column = found.steps[0].coefficient_map[:, found.coefficients.index(coefficient)]
    order = np.argsort(-np.nan_to_num(column, nan=-np.inf), kind="stable")
    return tuple(found.maneuvers[place].id for place in order[:_MOST_OVER_TIME])


def _chosen(found: DiscrepancyResult, ids: Sequence[str] | None) -> tuple[ManeuverHistories, ...]:
    """Return the maneuvers to draw in full, in order of time."""
    if ids is not None:
        known = {one.id: one for one in found.maneuvers}
        missing = [name for name in ids if name not in known]
        if missing:
            raise GroundStationError(
                f"there is no maneuver '{missing[0]}' to draw; there are {', '.join(known)}"
            )
        return tuple(known[name] for name in dict.fromkeys(ids))
    sizes = np.nan_to_num(found.steps[0].coefficient_map, nan=0.0).max(axis=1, initial=0.0)
    kept = [place for place, one in enumerate(found.maneuvers) if one.held_out]
    best = sorted(kept or range(len(found.maneuvers)), key=lambda place: -sizes[place])
    return tuple(found.maneuvers[place] for place in sorted(best[:_MOST_OVERLAYS]))
