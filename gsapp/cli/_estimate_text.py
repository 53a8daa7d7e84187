"""An estimation on the screen: values, fits, and what is to be said of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rich import box
from rich.table import Table
from rich.text import Text

from gsapp.cli._console import print_sentence
from gsapp.cli._tables import print_unwrapped
from gsapp.cli._value_format import MEAN_HEADINGS, MEAN_LEGEND, format_value_and_bound, mean_cells

if TYPE_CHECKING:
    from rich.console import Console

    from gsapp.identification.campaign import CampaignResult, CampaignValue, ManeuverResult
    from gsapp.identification.results import Estimate
    from gsapp.identification.runs.run_execution import RunOutcome

_FIXED, _EACH = 52, 22
"""Characters that the means take, and each column of a maneuver's own."""
_BY_EQUATIONS = "equation error"
"""Heads what stands beside maximum likelihood in gusts."""


def print_outcome(console: Console, outcome: RunOutcome) -> None:
    """Print the derivatives, how well each maneuver was fitted, and what is to be said.

    Parameters
    ----------
    console : Console
    outcome : RunOutcome
    """
    results = outcome.result.results
    print_unwrapped(console, _values(outcome.result, console.width))
    print_sentence(console, MEAN_LEGEND, "dim")
    print_unwrapped(console, _fits(results))
    for sentence in _sentences(outcome):
        print_sentence(console, sentence, "yellow")


def _values(result: CampaignResult, width: int) -> Table:
    """Return means, and what each maneuver gave where a line has room for it."""
    from gsapp.identification.campaign import campaign_values

    results = result.results
    gusty = [one for one in results if one.equation_error_estimate is not None]
    columns = len(results) + len(gusty) + bool(gusty)
    wide = _FIXED + _EACH * columns <= width
    table = Table(
        title=f"{result.settings.method.upper()}: {len(results)} "
        f"maneuver{'' if len(results) == 1 else 's'}, per radian",
        title_justify="left",
        box=box.SIMPLE_HEAD,
        pad_edge=False,
    )
    table.add_column("", no_wrap=True)
    headings = [*MEAN_HEADINGS]
    if gusty:
        headings.append(f"{_BY_EQUATIONS}, n")
    for one in results if wide else ():
        headings.append(f"{one.maneuver.id} {'+'.join(one.maneuver.inputs) or 'none'}")
        if one in gusty:
            headings.append(_BY_EQUATIONS)
    for heading in headings:
        table.add_column(heading, justify="right", no_wrap=True)
    by_equations = campaign_values([one.equation_error_estimate for one in gusty])
    for name in _rows(result):
        cells: list[str | Text] = [*_summary(result.values.get(name))]
        if gusty:
            cells.append(_mean(by_equations.get(name)))
        for one in results if wide else ():
            cells.append(_cell(one.estimate, name))
            if one in gusty:
                cells.append(_cell(one.equation_error_estimate, name))
        table.add_row(name, *cells)
    return table


def _fits(results: Sequence[ManeuverResult]) -> Table:
    fits = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in ("maneuver", "seconds", "inputs", "rounds"):
        fits.add_column(heading, no_wrap=True)
    fits.add_column("R2 of each response", overflow="fold")
    several = len({one.maneuver.flight for one in results}) > 1
    for one in results:
        maneuver, estimate = one.maneuver, one.estimate
        rounds = "failed" if estimate is None else str(estimate.iterations)
        if estimate is not None and not estimate.converged:
            rounds += ", not converged"
        fits.add_row(
            f"{maneuver.id} {maneuver.flight}" if several else maneuver.id,
            f"{maneuver.t_start:z.2f} - {maneuver.t_end:z.2f}",
            "+".join(maneuver.inputs) or "none",
            rounds,
            "  ".join(
                f"{name} {fit.r2:z.3f}" for name, fit in (estimate.fit if estimate else {}).items()
            ),
        )
    return fits


def _rows(result: CampaignResult) -> list[str]:
    """Return the names of all that was to be estimated, in the order of the build-up."""
    from gsapp.dynamics.buildup import derivative_names

    names = dict.fromkeys(
        name
        for one in result.results
        if one.estimate is not None
        for name, found in one.estimate.derivatives.items()
        if found.status != "held"
    )
    order = {name: place for place, name in enumerate(derivative_names())}
    return sorted(names, key=lambda name: order.get(name, len(order)))


def _summary(value: CampaignValue | None) -> list[str]:
    return ["unknown", "", "", ""] if value is None else mean_cells(value)


def _mean(value: CampaignValue | None) -> str:
    return (
        ""
        if value is None
        else f"{' ±'.join(format_value_and_bound(value.mean, value.std))} {value.n:3d}"
    )


def _cell(estimate: Estimate | None, name: str) -> str | Text:
    if estimate is None or name not in estimate.derivatives:
        return ""
    one = estimate.derivatives[name]
    if one.status == "held":
        return Text(f"held {one.value:z.4g}" if one.value else "held", "dim")
    if one.value is None or one.std is None:
        return Text(one.status, "dim")
    return " ±".join(format_value_and_bound(one.value, one.std, least=3))


def _sentences(outcome: RunOutcome) -> list[str]:
    """Return what is to be said, each sentence once, with the maneuvers it is about."""
    said: dict[str, list[str]] = {}
    for one in outcome.result.results:
        told = (one.failure,) if one.estimate is None else one.estimate.warnings
        if one.equation_error_estimate is not None:
            told = (
                *told,
                *_method_difference_text(one),
                *(f"{_BY_EQUATIONS}: {text}" for text in one.equation_error_estimate.warnings),
            )
        why = () if one.estimate is None else _unknown_reasons(one.estimate)
        # The maneuvers are named once, in front.
        own = f"maneuver {one.maneuver.id}: "
        for sentence in (*told, *why):
            said.setdefault(sentence.removeprefix(own), []).append(one.maneuver.id)
    remarks = dict.fromkeys((*outcome.remarks, *outcome.result.remarks))
    return [
        *remarks,
        *(
            f"maneuver{'s' if len(ids) > 1 else ''} {', '.join(ids)}: {sentence}"
            for sentence, ids in said.items()
        ),
    ]


def _unknown_reasons(estimate: Estimate) -> tuple[str, ...]:
    """Return each reason for which derivatives were not earned, once, with their names."""
    reasons: dict[str, list[str]] = {}
    for name, found in estimate.derivatives.items():
        if found.status in ("unknown", "not-identifiable") and found.why:
            reasons.setdefault(found.why, []).append(name)
    every = sum(len(names) for names in reasons.values())
    return tuple(
        f"{'no derivative' if len(names) == every > 1 and not estimate.free else ', '.join(names)}"
        f": {why}"
        for why, names in reasons.items()
        # Said already.
        if why not in estimate.warnings
    )


def _method_difference_text(one: ManeuverResult) -> tuple[str, ...]:
    """Return in a sentence where equation error lies apart from maximum likelihood."""
    from gsapp.identification.summary.method_comparison import compare_methods
    from gsapp.identification.summary.settings import SUMMARY

    names = [value.name for value in compare_methods(one) if value.differs]
    if not names:
        return (
            f"{_BY_EQUATIONS} agrees within {SUMMARY.significant_sigmas:z.0f} joint bounds in "
            "every derivative",
        )
    return (
        f"{_BY_EQUATIONS} lies more than {SUMMARY.significant_sigmas:z.0f} joint bounds off in "
        f"{', '.join(names)}; use the smaller bound",
    )
