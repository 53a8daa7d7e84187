"""``gsapp certificates``: which are in force, how old and how good they are."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from gsapp.cli._tables import print_whole

if TYPE_CHECKING:
    from rich.console import Console

    from calibration.overview import Overview, Standing

_OLD = timedelta(days=1)
"""Surfaces and vanes are calibrated anew on every day of flying."""
_CLOCKS_DIFFER = 1500.0
"""Minutes by which local times, as certificates bear them, may be ahead by traveling alone."""
_WIDE = 100


def run(
    *,
    folder: str,
    former: str | None = None,
    report: Path | None = None,
    page: Literal["pdf", "html"] = "pdf",
    json: Path | None = None,
) -> None:
    """List certificates, and write their pages.

    Parameters
    ----------
    folder : str
        Folder of certificates, of one aircraft in a store, of a flight; or a shipped set.
    former : str, optional
        Such a folder or set to compare with.
    report : Path, optional
        Folder for a page of each.
    page : {"pdf", "html"}
    json : Path, optional
        Where the list for programs goes.

    Raises
    ------
    GroundStationError
        If there are none, one holds mistakes, or a page cannot be written.
    """
    from calibration.overview import overview
    from gsapp.cli._results import on_screen, result_text, write_result
    from gsapp.cli._screen import Screen

    console = Screen(stderr=on_screen(json))
    # Certificates carry the local time of the field.
    now = datetime.now().replace(microsecond=0)  # noqa: DTZ005
    found = overview(folder, former)
    pages = _write_pages(console, found.standing, report, page, now)
    if json is not None:
        write_result(json, result_text(_content(found, folder, now, pages)))
    if not on_screen(json):
        _print(console, found, folder, now)
        if report is not None:
            console.print(f"{len(pages)} pages in {report}", highlight=False, soft_wrap=True)


def _write_pages(
    console: Console,
    standing: Sequence[Standing],
    folder: Path | None,
    page: Literal["pdf", "html"],
    now: datetime,
) -> tuple[Path, ...]:
    if folder is None:
        return ()
    from gsapp.report.certificate_report import write_certificate_report

    pages = []
    with console.status("drawing") as status:
        for one in standing:
            status.update(f"drawing {one.certificate.channel}")
            path = folder / f"{one.certificate.channel}.{page}"
            pages.append(write_certificate_report(one, path, written=f"{now:%Y-%m-%d %H:%M}"))
    return tuple(pages)


def _content(found: Overview, folder: str, now: datetime, pages: Sequence[Path]) -> dict[str, Any]:
    """Return the list for programs: SI units, seconds; absent = null."""
    reports: Sequence[Path | None] = pages or [None] * len(found.standing)
    return {
        "folder": folder,
        "certificates": [
            {**_one(standing, now), "report": None if report is None else str(report)}
            for standing, report in zip(found.standing, reports, strict=True)
        ],
        "uncalibrated": [
            {
                "channel": one.channel,
                "reason": one.reason,
                "who": one.who,
                "stamp": one.stamp.isoformat(),
            }
            for one in found.skipped
        ],
    }


def _one(standing: Standing, now: datetime) -> dict[str, Any]:
    from gsapp.cli._calibration_text import drift_json, quality_json
    from gsapp.quantities import channel

    certificate, quality, former = standing.certificate, standing.quality, standing.former
    where = certificate.channel, certificate.unit
    return {
        "channel": certificate.channel,
        "file": str(standing.file),
        "instrument": certificate.instrument or None,
        "stamp": certificate.stamp.isoformat(),
        "age": standing.age(now).total_seconds(),
        "who": certificate.who or None,
        "temperature": certificate.temperature,
        "excitation_voltage": certificate.excitation_voltage,
        "points": len(certificate.points),
        "unit": channel(certificate.channel).unit,
        "degree": certificate.degree,
        "coefficients": list(certificate.si_coefficients),
        "range": list(certificate.range),
        "values": list(certificate.value_range),
        "quality": None if quality is None else quality_json(quality, *where),
        "former": None
        if former is None
        else {
            "stamp": former.stamp.isoformat(),
            **({} if standing.drift is None else drift_json(standing.drift, *where)),
        },
    }


def _print(console: Console, found: Overview, folder: str, now: datetime) -> None:
    from rich import box
    from rich.table import Table
    from rich.text import Text

    table = Table(
        title=f"{folder}: {len(found.standing)} certificates in force",
        title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0),
    )  # fmt: skip
    for heading in ("channel", "taken", "age"):
        table.add_column(heading, no_wrap=True)
    for heading in ("points", "within (95 %)", "hysteresis", "moved"):
        table.add_column(heading, justify="right", no_wrap=True)
    # A narrow line has no room for names; they stand in the JSON and on the pages.
    wide = console.width >= _WIDE
    if wide:
        table.add_column("who", no_wrap=True, overflow="ellipsis", ratio=1)
    for one in found.standing:
        certificate = one.certificate
        age = one.age(now)
        table.add_row(
            certificate.channel,
            f"{certificate.stamp:%Y-%m-%d}",
            Text(age_text(age), "yellow" if age > _OLD else ""),
            str(len(certificate.points)),
            *_figures(one),
            *([certificate.who] if wide else []),
        )
    print_whole(console, table)
    for one in found.standing:
        if one.drift is not None and one.drift.significant:
            _say(console, f"{one.certificate.channel}: {one.drift.sentence}")
    if any(one.age(now) < timedelta(minutes=-_CLOCKS_DIFFER) for one in found.standing):
        _say(
            console,
            f"Certificates lie in the future: this computer's clock says {now:%Y-%m-%d %H:%M}; set "
            "it, lest what is recorded bear a wrong date.",
        )
    for skipped in found.skipped:
        _say(
            console,
            f"{skipped.channel} is uncalibrated: {skipped.reason} ({skipped.who}, "
            f"{skipped.stamp:%Y-%m-%d %H:%M})",
        )


def _figures(one: Standing) -> tuple[str, str, str]:
    """Return uncertainty, hysteresis and drift of zero, in the unit of the certificate."""
    unit, quality, drift = one.certificate.unit, one.quality, one.drift

    def shown(value: float | None) -> str:
        return "-" if value is None else f"{value:z.3g}"

    width = None if quality is None else quality.uncertainty
    moved = "-" if drift is None else f"{drift.zero:+z.2g}{' !' if drift.significant else ''}"
    return (
        "-" if width is None else f"{width:z.3g} {unit}".rstrip(),
        shown(None if quality is None else quality.hysteresis),
        moved,
    )


def age_text(age: timedelta) -> str:
    """Return how old something is: ``40 min``, ``5 h``, ``12 d``, ``3 y``.

    What was taken after the present moment is a matter of the computer's clock: ``clock?``.
    """
    minutes = age.total_seconds() / 60.0
    if minutes < -_CLOCKS_DIFFER:
        return "clock?"
    for most, minutes_each, unit in ((90.0, 1.0, "min"), (2880.0, 60.0, "h"), (1e6, 1440.0, "d")):
        if minutes < most:
            return f"{minutes / minutes_each:z.0f} {unit}"
    return f"{minutes / 525_960.0:z.0f} y"


def _say(console: Console, sentence: str) -> None:
    console.print(sentence, style="yellow", highlight=False, soft_wrap=True)
