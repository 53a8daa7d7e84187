"""``gsapp certificates``: which are in force, how old and how good they are."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from gsapp.cli._console import print_sentence
from gsapp.cli._options import DISPLAY_UNITS
from gsapp.cli._tables import print_unwrapped

if TYPE_CHECKING:
    from rich.console import Console

    from calibration.certificate_store import CertificateOverview, CertificateStatus
    from calibration.validity import CalibrationInForce, CalibrationStatus

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
    from calibration.certificate_store import load_certificate_overview
    from calibration.validity import CalibrationInForce
    from gsapp.cli._console import PlainConsole
    from gsapp.cli._json_output import format_json, is_stdout, write_json

    console = PlainConsole(stderr=is_stdout(json))
    # Certificates carry the local time of the field.
    now = datetime.now().replace(microsecond=0)  # noqa: DTZ005
    found = load_certificate_overview(folder, former)
    in_force = CalibrationInForce(
        certificates={one.certificate.channel: one.certificate for one in found.in_force},
        flight_date=_flight_date(Path(folder)) or now.astimezone(),
        missing=[one.channel for one in found.skipped],
    )
    pages = _write_pages(console, found.in_force, report, page, now)
    if json is not None:
        write_json(json, format_json(_content(found, in_force, folder, now, pages)))
    if not is_stdout(json):
        _print(console, found, in_force, folder)
        if report is not None:
            console.print(f"{len(pages)} pages in {report}", highlight=False, soft_wrap=True)


def _write_pages(
    console: Console,
    standing: Sequence[CertificateStatus],
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
            pages.append(
                write_certificate_report(
                    one, path, written=f"{now:%Y-%m-%d %H:%M}", units=DISPLAY_UNITS.get()
                )
            )
    return tuple(pages)


def _flight_date(folder: Path) -> datetime | None:
    """Return when the flight took place whose folder it is; None for any other folder."""
    from gsapp.flight.folder import FlightFolder

    info = FlightFolder(path=folder).info()
    return None if info is None else info.date


def _content(
    found: CertificateOverview,
    in_force: CalibrationInForce,
    folder: str,
    now: datetime,
    pages: Sequence[Path],
) -> dict[str, Any]:
    """Return the list for programs: SI units, seconds; absent = null."""
    reports: Sequence[Path | None] = pages or [None] * len(found.in_force)
    return {
        "folder": folder,
        "status": _status(in_force.evaluate()),
        "certificates": [
            {**_one(standing, in_force, now), "report": None if report is None else str(report)}
            for standing, report in zip(found.in_force, reports, strict=True)
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


def _status(status: CalibrationStatus) -> dict[str, str]:
    return {"state": status.state, "words": status.summary, "detail": status.detail}


def _one(
    standing: CertificateStatus, in_force: CalibrationInForce, now: datetime
) -> dict[str, Any]:
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
        "status": _status(in_force.evaluate((certificate.channel,))),
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


def _print(
    console: Console, found: CertificateOverview, in_force: CalibrationInForce, folder: str
) -> None:
    from rich import box
    from rich.table import Table
    from rich.text import Text

    table = Table(
        title=f"{folder}: {len(found.in_force)} certificates in force",
        title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0),
    )  # fmt: skip
    for heading in ("channel", "taken", "status"):
        table.add_column(heading, no_wrap=True)
    for heading in ("points", "within (95 %)", "hysteresis", "moved"):
        table.add_column(heading, justify="right", no_wrap=True)
    # A narrow line has no room for names; they stand in the JSON and on the pages.
    wide = console.width >= _WIDE
    if wide:
        table.add_column("who", no_wrap=True, overflow="ellipsis", ratio=1)
    for one in found.in_force:
        certificate = one.certificate
        status = in_force.evaluate((certificate.channel,))
        table.add_row(
            certificate.channel,
            f"{certificate.stamp:%Y-%m-%d}",
            Text(status.summary, "" if status.state == "good" else "yellow"),
            str(len(certificate.points)),
            *_figures(one),
            *([certificate.who] if wide else []),
        )
    print_unwrapped(console, table)
    for one in found.in_force:
        if one.drift is not None and one.drift.significant:
            print_sentence(console, f"{one.certificate.channel}: {one.drift.sentence}", "yellow")
    status = in_force.evaluate()
    print_sentence(console, f"{status.detail}.", "" if status.state == "good" else "yellow")
    for skipped in found.skipped:
        print_sentence(
            console,
            f"{skipped.channel} is uncalibrated: {skipped.reason} ({skipped.who}, "
            f"{skipped.stamp:%Y-%m-%d %H:%M})",
            "yellow",
        )


def _figures(one: CertificateStatus) -> tuple[str, str, str]:
    """Return uncertainty, hysteresis and drift of zero, in the units of the call."""
    from gsapp.cli._calibration_text import si_converters
    from gsapp.quantities import channel

    name, quality, drift = one.certificate.channel, one.quality, one.drift
    unit = channel(name).display_unit(DISPLAY_UNITS.get())
    _, own = si_converters(name, one.certificate.unit)
    _, chosen = si_converters(name, unit)
    scale = (own(1.0) or 1.0) / (chosen(1.0) or 1.0)

    def shown(value: float | None) -> str:
        return "-" if value is None else f"{value * scale:z.3g}"

    width = None if quality is None else quality.uncertainty
    moved = (
        "-" if drift is None else f"{drift.zero * scale:+z.2g}{' !' if drift.significant else ''}"
    )
    return (
        f"{shown(width)} {unit if width is not None else ''}".rstrip(),
        shown(None if quality is None else quality.hysteresis),
        moved,
    )
