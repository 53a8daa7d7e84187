"""Groups, trends and changes of ``gsapp catalog``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from gsapp.cli._options import DISPLAY_UNITS

if TYPE_CHECKING:
    from gsapp.cli._console import PlainConsole
    from gsapp.flight.catalog import Catalog, ManeuverFilter
    from gsapp.identification.fleet.fleet_values import FleetValues
    from gsapp.report.document import DocumentFigure

_FIGURE_FORMATS = (".png", ".pdf", ".svg")


@dataclass(frozen=True, slots=True, kw_only=True)
class FleetRequest:
    """What is asked of the maneuvers that fit."""

    what: str  # ``maneuvers``, ``groups``, ``trend`` or ``changes``.
    names: tuple[str, ...]
    by: str
    against: tuple[str, ...]
    method: str
    figure: Path | None

    def check(self) -> None:
        """Raise, with the right call in words, where it cannot be what was meant."""
        if self.what == "maneuvers":
            if self.names:
                raise typer.BadParameter(
                    f"names belong to groups, trend and changes; write --derivative {self.names[0]}"
                )
            if self.figure is not None:
                raise typer.BadParameter("--figure draws a trend or changes")
            return
        from gsapp.cli._usage_errors import as_usage_error
        from gsapp.identification.fleet.fleet_analysis import check_condition
        from gsapp.identification.fleet.fleet_values import check_group_key

        with as_usage_error():
            check_group_key(self.by)
            for name in self.against:
                check_condition(name)
        if self.what == "trend" and (len(self.names) != 1 or not self.against):
            raise typer.BadParameter("write: gsapp catalog CATALOG trend NAME --against CONDITION")
        if self.figure is None:
            return
        if self.what == "groups":
            raise typer.BadParameter("--figure draws a trend or changes")
        if self.figure.suffix.lower() not in _FIGURE_FORMATS:
            raise typer.BadParameter(f"--figure: end the name in {', '.join(_FIGURE_FORMATS)}")


def run_fleet_request(
    console: PlainConsole,
    store: Catalog,
    wanted: ManeuverFilter,
    request: FleetRequest,
    json: Path | None,
) -> None:
    """Print the answer, and write it as JSON and as a figure where they are asked for."""
    from gsapp.cli._console import write_json

    answers: dict[str, Callable[..., Any]] = {
        "groups": _groups, "trend": _trend, "changes": _changes,
    }  # fmt: skip
    write_json(json, answers[request.what](console, store, wanted, request))


def _select(
    store: Catalog, names: Sequence[str], wanted: ManeuverFilter, request: FleetRequest
) -> list[FleetValues]:
    from gsapp.identification.fleet.fleet_values import select_fleet_values

    return [
        select_fleet_values(store, name, wanted, method=request.method, conditions=request.against)
        for name in names
    ]


def _groups(
    console: PlainConsole, store: Catalog, wanted: ManeuverFilter, request: FleetRequest
) -> Any:
    from gsapp.cli._console import format_value_and_bound
    from gsapp.identification.fleet.fleet_analysis import groups_json, settings_remarks
    from gsapp.identification.fleet.fleet_values import (
        count_groups,
        group_means,
        select_fleet_maneuvers,
    )
    from gsapp.report.fleet_text import unknown_remarks, value_and_bound

    counts = count_groups(select_fleet_maneuvers(store, wanted), request.by)
    fleet = _select(store, request.names, wanted, request)
    means = [{one.group: one for one in group_means(found, request.by)} for found in fleet]
    numbers = ("flights", "maneuvers", *request.names)
    table = console.create_table(f"by {request.by}", (request.by, *numbers), right=numbers)
    for group, (flights, maneuvers) in counts.items():
        cells = []
        for found, own in zip(fleet, means, strict=True):
            one = own.get(group)
            if one is None:
                cells.append("unknown")
                continue
            value, std, unit = value_and_bound(found.name, one.mean, one.std, DISPLAY_UNITS.get())
            cells.append(f"{' ±'.join(format_value_and_bound(value, std))} {unit}".rstrip())
        table.add_row(group or "none", str(flights), str(maneuvers), *cells)
    console.print_unwrapped(table)
    _remark(console, [*unknown_remarks(fleet), *settings_remarks(fleet)])
    return {
        "by": request.by,
        "groups": [
            {"group": group, "flights": flights, "maneuvers": maneuvers}
            for group, (flights, maneuvers) in counts.items()
        ],
        "values": [
            groups_json(found, tuple(own.values()), request.by)
            for found, own in zip(fleet, means, strict=True)
        ],
    }


def _trend(
    console: PlainConsole, store: Catalog, wanted: ManeuverFilter, request: FleetRequest
) -> Any:
    from gsapp.cli._console import format_value_and_bound
    from gsapp.identification.fleet.fleet_analysis import fit_trend, settings_remarks, trend_json
    from gsapp.report.fleet_figures import trend_figure
    from gsapp.report.fleet_text import effect_rows, group_rows, trend_remarks, trend_title

    units = DISPLAY_UNITS.get()
    (found,) = _select(store, request.names, wanted, request)
    trend = fit_trend(found, request.against, request.by)
    table = console.create_table(
        trend_title(trend), ("", "value", "bound", "95 %", "p"), right=("value", "bound", "p")
    )
    effects = (trend.fit.intercept, *trend.fit.slopes.values())
    for (name, value, std, low, high), one in zip(effect_rows(trend, units), effects, strict=True):
        cells = format_value_and_bound(value, std)
        p_value = "" if one is trend.fit.intercept else f"{one.p_value:.2g}"
        table.add_row(name, *cells, f"{low:z.4g} to {high:z.4g}", p_value)
    console.print_unwrapped(table)
    numbers = ("values", found.name, "bound", "slope", "bound of the slope")
    groups = console.create_table("", (request.by, *numbers), right=numbers)
    for group, count, value, std, slope, slope_std in group_rows(trend, units):
        cells = format_value_and_bound(value, std)
        slopes = ("", "")
        if slope is not None and slope_std is not None:
            slopes = format_value_and_bound(slope, slope_std)
        groups.add_row(group, str(count), *cells, *slopes)
    console.print_unwrapped(groups)
    _remark(console, [*trend_remarks(trend, units), *settings_remarks([trend.values])])
    _draw(console, request.figure, lambda: trend_figure(trend, units=units))
    return trend_json(trend)


def _changes(
    console: PlainConsole, store: Catalog, wanted: ManeuverFilter, request: FleetRequest
) -> Any:
    from gsapp.identification.fleet.fleet_analysis import (
        changes_json,
        find_changes,
        settings_remarks,
    )
    from gsapp.identification.fleet.fleet_values import check_any_value, list_fleet_names
    from gsapp.identification.fleet.settings import FLEET
    from gsapp.report.fleet_figures import change_figure
    from gsapp.report.fleet_text import CHANGE_COLUMNS, change_row, unknown_remarks

    units = DISPLAY_UNITS.get()
    fleet = _select(store, request.names or list_fleet_names(store), wanted, request)
    for one in fleet if request.names else ():
        check_any_value(one)
    found = find_changes([one for one in fleet if one.values], request.by, request.against)
    changed = [one for one in found if one.change.time is not None]
    shown = found if request.names else changed
    table = console.create_table(
        f"{len(changed)} of {len(found)} series changed; drifts per year",
        CHANGE_COLUMNS,
        right=("flights", "size", "bound", "before", "now", "p"),
    )
    for series in shown:
        table.add_row(*change_row(series, units))
    console.print_unwrapped(table)
    console.print_sentence(
        f"chance of any false change among all {len(found)} series: "
        f"{100 * FLEET.change_significance:.0f} %; dates lie between the bounds with "
        f"{100 * FLEET.date_probability:.0f} %",
        "dim",
    )
    _remark(console, [*(unknown_remarks(fleet) if request.names else ()), *settings_remarks(fleet)])
    _draw(console, request.figure, lambda: change_figure(found, units=units))
    return changes_json(found, request.by)


def _remark(console: PlainConsole, sentences: Sequence[str]) -> None:
    for sentence in sentences:
        console.print_sentence(sentence, "yellow")


def _draw(console: PlainConsole, path: Path | None, make: Callable[[], DocumentFigure]) -> None:
    if path is None:
        return
    import io

    from gsapp.foundation import write_atomically
    from gsapp.report.document import figure_style

    content = io.BytesIO()
    figure = make().to_figure()
    with figure_style():
        figure.savefig(content, format=path.suffix.lower().removeprefix("."))
    write_atomically(path, content.getvalue())
    console.print(f"written to {path}", soft_wrap=True)
