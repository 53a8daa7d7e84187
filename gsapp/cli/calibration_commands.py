"""Commands on calibrations: a certificate from points, and the certificates in force."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from gsapp.cli._options import DISPLAY_UNITS, JsonFile, Units

if TYPE_CHECKING:
    from rich.table import Table

    from calibration import Certificate
    from calibration.certificate_store import CertificateOverview, CertificateStatus
    from calibration.drift import Drift
    from calibration.points_file import PointsFile
    from calibration.quality import Calibration
    from calibration.validity import CalibrationInForce, CalibrationStatus
    from gsapp.cli._console import PlainConsole

_WIDE = 100


def calibrate(
    points: Annotated[
        Path,
        typer.Argument(
            metavar="POINTS.csv",
            readable=False,
            help="CSV with columns angle [deg], volts [V] (or pulse [us], counts [count]), "
            "direction (increasing or decreasing), optional excitation [V]",
        ),
    ],
    channel: Annotated[str, typer.Option(metavar="ID", help="Channel, such as elevator_left")],
    out: Annotated[Path, typer.Option(readable=False, metavar="FILE", help="Certificate to write")],
    degree: Annotated[
        int | None, typer.Option(min=1, max=3, help="Order of the fit; default: automatic")
    ] = None,
    excitation: Annotated[
        float | None, typer.Option(metavar="V", help="Supply voltage of a ratiometric instrument")
    ] = None,
    travel: Annotated[
        str | None,
        typer.Option(metavar="LOW:HIGH", help="Travel of the surface, in the unit of the points"),
    ] = None,
    who: Annotated[str, typer.Option(help="Name of the person who took the readings")] = "",
    temperature: Annotated[
        float | None, typer.Option(metavar="DEGC", help="Of the surroundings")
    ] = None,
    former: Annotated[
        list[Path] | None,
        typer.Option(
            readable=False, metavar="FILE", help="Certificate to compare with; repeatable"
        ),
    ] = None,
    report: Annotated[
        Path | None,
        typer.Option(readable=False, metavar="FILE", help="Report with the curves: .html or .pdf"),
    ] = None,
    units: Units = "us",  # noqa: ARG001  acts in its callback
    json: JsonFile = None,
) -> None:
    """Turn calibration points into a certificate.

    It holds the curve that they deserve, and how good it is.

    Example: gsapp calibrate points.csv --channel elevator_left --out calibration/elevator_left.toml

    Example: gsapp calibrate points.csv --channel rudder --out new.toml --excitation 5
    --travel -30:30 --who "B. Jones" --temperature 16 --former old.toml
    """
    from calibration import load_certificate
    from calibration.certificate_json import certificate_json
    from calibration.certificate_toml import save_certificate
    from calibration.points_calibration import calibrate_points, check_supply
    from gsapp.cli._console import is_stdout, write_json
    from gsapp.cli._usage_errors import as_usage_error
    from gsapp.quantities import channel as spec_of

    ends = _travel(travel)
    with as_usage_error():
        spec_of(channel)
        if report is not None:
            from gsapp.report.certificate_report import check_report_suffix

            check_report_suffix(report)
        check_supply(excitation)
    made = calibrate_points(
        points, channel, degree=degree, excitation=excitation, travel=ends, who=who,
        temperature=temperature, former=former or (),
    )  # fmt: skip
    save_certificate(made.certificate, out)
    if report is not None:
        _write_report(
            made.certificate, out, [load_certificate(path) for path in former or ()], report
        )
    write_json(json, certificate_json(made, out))
    if not is_stdout(json):
        _print_certificate(
            made.certificate, made.calibration, made.points_file, made.drifts, made.remarks, out
        )


def _write_report(
    certificate: Certificate, file: Path, former: Sequence[Certificate], report: Path
) -> None:
    from calibration.certificate_store import evaluate_certificate
    from gsapp.flight.info import local_timestamp
    from gsapp.report.certificate_report import write_certificate_report

    newest = max(former, key=lambda one: one.stamp.astimezone(), default=None)
    write_certificate_report(
        evaluate_certificate(certificate, file, newest), report,
        written=f"{local_timestamp():%Y-%m-%d %H:%M}",
        units=DISPLAY_UNITS.get(),
    )  # fmt: skip


def _travel(text: str | None) -> tuple[float, float] | None:
    """Read ``LOW:HIGH``."""
    from gsapp.cli._usage_errors import CommandUsageError

    if text is None:
        return None
    parts = text.split(":")
    try:
        low, high = (float(part) for part in parts)
    except ValueError:
        low = high = 0.0
    if not low < high:
        raise CommandUsageError(f"--travel '{text}' is no range; write LOW:HIGH, as -25:25")
    return low, high


def _print_certificate(
    certificate: Certificate,
    made: Calibration,
    taken: PointsFile,
    drifts: Sequence[tuple[Path, Drift]],
    sentences: Sequence[str],
    out: Path,
) -> None:
    from rich.table import Table

    from calibration.settings import FIT_ORDER_TITLES
    from gsapp.cli._console import PlainConsole

    console = PlainConsole()
    unit = certificate.unit
    console.print_unwrapped(_points_table(made, taken))
    table = Table("", unit, title=f"{certificate.channel}, {FIT_ORDER_TITLES[made.degree]}")
    for title, value in _quality_rows(made):
        table.add_row(title, value)
    console.print_unwrapped(table)
    if made.losses:
        losses = ", ".join(
            f"{FIT_ORDER_TITLES[degree]} {loss:z.3f}" for degree, loss in made.losses.items()
        )
        console.print_sentence(f"cross-validation residual, rms {unit}: {losses}")
    if made.quality.coverage is not None:
        console.print(f"{100.0 * made.quality.coverage:z.0f} % of the travel covered")  # fmt: skip
    for path, drift in drifts:
        console.print_sentence(
            f"{path.name}: {drift.sentence}", "yellow" if drift.significant else ""
        )
    for sentence in sentences:
        console.print_sentence(f"note: {sentence}")
    console.print(f"certificate: {out}", soft_wrap=True)


def _quality_rows(made: Calibration) -> list[tuple[str, str]]:
    """Return the figures of a calibration, in its unit."""
    quality = made.quality

    def shown(value: float | None) -> str:
        return "not known" if value is None else f"{value:z.3f}"

    width = shown(quality.hysteresis)
    if quality.hysteresis_uncertainty is not None:
        width += f" +- {quality.hysteresis_uncertainty:z.3f}"
    return [
        ("uncertainty, 95 %, maximum", shown(quality.uncertainty)),
        ("hysteresis, width", width),
        ("return to zero", shown(quality.return_to_zero)),
        ("linearity (from the best line)", f"{quality.linearity:z.3f}"),
        ("repeatability, std", shown(quality.scatter)),
        ("resolution", f"{quality.resolution:z.3f}"),
        ("covered", f"{quality.covered[0]:g} to {quality.covered[1]:g}"),
    ]


def _points_table(made: Calibration, taken: PointsFile) -> Table:
    from rich.table import Table

    from calibration.points import DIRECTION_TEXT

    unit = taken.unit
    table = Table("line", f"set, {unit}", taken.signal.name, "direction", f"residual, {unit}")
    rows = zip(taken.lines, taken.points, made.fit.residuals, strict=True)
    for index, (line, point, residual) in enumerate(rows):
        table.add_row(
            str(line), f"{point.value:g}", f"{point.volts:z.4f}", DIRECTION_TEXT[point.direction],
            f"{residual:+z.3f}", style="yellow" if index in made.quality.outliers else None,
        )  # fmt: skip
    return table


def certificates(
    folder: Annotated[
        str,
        typer.Argument(
            metavar="FOLDER|NAME",
            help="Folder of certificates, of an aircraft's, of a flight; or a shipped set",
        ),
    ],
    former: Annotated[
        str | None,
        typer.Option(
            metavar="FOLDER|NAME",
            help="Certificates to compare with; by default those before in an aircraft's history",
        ),
    ] = None,
    report: Annotated[
        Path | None,
        typer.Option(readable=False, metavar="DIR", help="Folder for a report of each certificate"),
    ] = None,
    page: Annotated[Literal["pdf", "html"], typer.Option("--format", help="Of the pages")] = "pdf",
    units: Units = "us",  # noqa: ARG001  acts in its callback
    json: JsonFile = None,
) -> None:
    """List the certificates in force: age, quality, drift.

    Example: gsapp certificates flights/2026-05-12-a --report pages
    """
    from calibration.certificate_store import load_certificate_overview
    from calibration.validity import CalibrationInForce
    from gsapp.cli._console import PlainConsole, is_stdout, write_json

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
        write_json(json, _overview_json(found, in_force, folder, now, pages))
    if not is_stdout(json):
        _print_overview(console, found, in_force, folder)
        if report is not None:
            console.print(f"{len(pages)} pages in {report}", soft_wrap=True)


def _write_pages(
    console: PlainConsole,
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


def _overview_json(
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
        "status": _evaluation_json(in_force.evaluate()),
        "certificates": [
            {
                **_status_json(standing, in_force, now),
                "report": None if report is None else str(report),
            }
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


def _evaluation_json(status: CalibrationStatus) -> dict[str, str]:
    return {"state": status.state, "words": status.summary, "detail": status.detail}


def _status_json(
    standing: CertificateStatus, in_force: CalibrationInForce, now: datetime
) -> dict[str, Any]:
    from calibration.certificate_json import drift_json, quality_json
    from gsapp.quantities import channel

    certificate, quality, former = standing.certificate, standing.quality, standing.former
    where = certificate.channel, certificate.unit
    return {
        "channel": certificate.channel,
        "file": str(standing.file),
        "instrument": certificate.instrument or None,
        "stamp": certificate.stamp.isoformat(),
        "age": standing.age(now).total_seconds(),
        "status": _evaluation_json(in_force.evaluate((certificate.channel,))),
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


def _print_overview(
    console: PlainConsole, found: CertificateOverview, in_force: CalibrationInForce, folder: str
) -> None:
    from rich.text import Text

    table = console.create_table(
        title=f"{folder}: {len(found.in_force)} certificates in force", padding=(0, 1, 0, 0),
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
            *_figure_cells(one),
            *([certificate.who] if wide else []),
        )
    console.print_unwrapped(table)
    for one in found.in_force:
        if one.drift is not None and one.drift.significant:
            console.print_sentence(f"{one.certificate.channel}: {one.drift.sentence}", "yellow")
    status = in_force.evaluate()
    console.print_sentence(f"{status.detail}.", "" if status.state == "good" else "yellow")
    for skipped in found.skipped:
        console.print_sentence(
            f"{skipped.channel} is uncalibrated: {skipped.reason} ({skipped.who}, "
            f"{skipped.stamp:%Y-%m-%d %H:%M})",
            "yellow",
        )


def _figure_cells(one: CertificateStatus) -> tuple[str, str, str]:
    """Return uncertainty, hysteresis and drift of zero, in the units of the call."""
    from calibration.certificate_json import si_converters
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
