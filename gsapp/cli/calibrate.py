"""``gsapp calibrate``: a certificate from points that were written down."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.table import Table

from calibration.settings import FIT_ORDER_TITLES
from gsapp.cli._calibration_text import drift_json, quality_json, si_converters
from gsapp.cli._console import PlainConsole, print_sentence
from gsapp.cli._options import DISPLAY_UNITS
from gsapp.cli._tables import print_unwrapped

if TYPE_CHECKING:
    from calibration import Certificate
    from calibration.drift import Drift
    from calibration.points_file import PointsFile
    from calibration.quality import Calibration


def run(
    *,
    points: Path,
    channel: str,
    out: Path,
    degree: int | None = None,
    excitation: float | None = None,
    travel: str | None = None,
    who: str = "",
    temperature: float | None = None,
    former: Sequence[Path] = (),
    report: Path | None = None,
    json: Path | None = None,
) -> None:
    """Fit points and write the certificate.

    Parameters
    ----------
    points : Path
        CSV; see `calibration.points_file`.
    channel : str
        Channel id.
    out : Path
        The certificate.
    degree : int, optional
        1 to 3; without it the points decide.
    excitation : float, optional
        Supply of a ratiometric instrument, V; a column of the file goes before it.
    travel : str, optional
        ``LOW:HIGH`` of the surface, in the unit of the file.
    who : str
        Who took the readings.
    temperature : float, optional
        Of the surroundings, degC.
    former : sequence of Path
        Certificates to compare with.
    report : Path, optional
        Where the page with the curves goes, ``.html`` or ``.pdf``; it compares with the newest of
        `former`.
    json : Path, optional
        Where the result for programs goes.

    Raises
    ------
    GroundStationError
        If a file holds mistakes, or the points allow no curve.
    """
    from calibration import load_certificate, write_certificate
    from calibration.curve_selection import create_certificate, fit_calibration
    from calibration.drift import compute_drift
    from calibration.points_file import load_points
    from calibration.quality import collect_remarks
    from gsapp.cli._json_output import format_json, is_stdout, write_json
    from gsapp.cli._usage_errors import as_usage_error
    from gsapp.foundation import GroundStationError
    from gsapp.foundation.os_error_text import format_os_error
    from gsapp.quantities import channel as spec_of
    from gsapp.quantities import to_si

    ends = _travel(travel)
    with as_usage_error():
        spec_of(channel)
        if report is not None:
            from gsapp.report.certificate_report import check_report_suffix

            check_report_suffix(report)
        _check_supply(excitation)
    taken = load_points(points, channel)
    supply = taken.excitation or excitation
    _check_supply(supply)
    made = fit_calibration(taken.points, degree=degree, travel=ends)
    certificate = create_certificate(
        made,
        taken.points,
        channel_id=channel,
        unit=taken.unit,
        who=who,
        stamp=datetime.now(),  # noqa: DTZ005  certificates carry the field's local time
        excitation_voltage=supply,
        ratiometric=supply is not None,
        temperature=None if temperature is None else to_si(temperature, "degC", "temperature"),
    )
    drifts = [(path, compute_drift(certificate, load_certificate(path))) for path in former]
    sentences = collect_remarks(made, taken.points, taken.unit)
    if not who:
        sentences = (*sentences, "the person who took the readings is missing; add --who")
    try:
        write_certificate(certificate, out)
    except OSError as error:
        raise GroundStationError(
            format_os_error(out, error, "choose a folder with write permission")
        ) from error
    if report is not None:
        _write_report(certificate, out, [load_certificate(path) for path in former], report)
    if json is not None:
        content = _content(certificate, made, drifts, sentences, out)
        write_json(json, format_json(content))
        if is_stdout(json):
            return
    _print(certificate, made, taken, drifts, sentences, out)


def _write_report(
    certificate: Certificate, file: Path, former: Sequence[Certificate], report: Path
) -> None:
    from calibration.certificate_store import evaluate_certificate
    from gsapp.flight.info import local_timestamp
    from gsapp.report.certificate_report import write_certificate_report

    newest = max(former, key=lambda one: one.stamp.replace(tzinfo=None), default=None)
    write_certificate_report(
        evaluate_certificate(certificate, file, newest), report,
        written=f"{local_timestamp():%Y-%m-%d %H:%M}",
        units=DISPLAY_UNITS.get(),
    )  # fmt: skip


def _check_supply(volts: float | None) -> None:
    from gsapp.foundation import GroundStationError

    if volts is not None and not 0.5 <= volts <= 30.0:
        raise GroundStationError(f"a supply of {volts:g} V is not possible; give it in volts")


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


def _content(
    certificate: Certificate,
    made: Calibration,
    drifts: Sequence[tuple[Path, Drift]],
    sentences: Sequence[str],
    out: Path,
) -> dict[str, Any]:
    """Return the result for programs: SI units, volts; absent = null."""
    from gsapp.quantities import channel

    _, si = si_converters(certificate.channel, certificate.unit)
    quality = made.quality
    return {
        "certificate": str(out),
        "channel": certificate.channel,
        "unit": channel(certificate.channel).unit,
        "degree": made.degree,
        "coefficients": list(certificate.si_coefficients),
        "range": list(certificate.range),
        "losses": {str(degree): si(loss) for degree, loss in made.losses.items()},
        "quality": quality_json(quality, certificate.channel, certificate.unit),
        "residuals": [si(residual) for residual in made.fit.residuals],
        "outliers": list(quality.outliers),
        "former": [
            {
                "certificate": str(path),
                **drift_json(drift, certificate.channel, certificate.unit),
            }
            for path, drift in drifts
        ],
        "remarks": list(sentences),
    }


def _print(
    certificate: Certificate,
    made: Calibration,
    taken: PointsFile,
    drifts: Sequence[tuple[Path, Drift]],
    sentences: Sequence[str],
    out: Path,
) -> None:
    console = PlainConsole()
    unit = certificate.unit
    print_unwrapped(console, _points_table(made, taken))
    table = Table("", unit, title=f"{certificate.channel}, {FIT_ORDER_TITLES[made.degree]}")
    for title, value in _rows(made):
        table.add_row(title, value)
    print_unwrapped(console, table)
    if made.losses:
        losses = ", ".join(
            f"{FIT_ORDER_TITLES[degree]} {loss:z.3f}" for degree, loss in made.losses.items()
        )
        print_sentence(console, f"cross-validation residual, rms {unit}: {losses}")
    if made.quality.coverage is not None:
        console.print(f"{100.0 * made.quality.coverage:z.0f} % of the travel covered",
                      highlight=False)  # fmt: skip
    for path, drift in drifts:
        print_sentence(
            console, f"{path.name}: {drift.sentence}", "yellow" if drift.significant else ""
        )
    for sentence in sentences:
        print_sentence(console, f"note: {sentence}")
    console.print(f"certificate: {out}", highlight=False, soft_wrap=True)


def _rows(made: Calibration) -> list[tuple[str, str]]:
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
        ("ADC resolution", f"{quality.resolution:z.3f}"),
        ("covered", f"{quality.covered[0]:g} to {quality.covered[1]:g}"),
    ]


def _points_table(made: Calibration, taken: PointsFile) -> Table:
    from calibration.points import DIRECTION_TEXT

    unit = taken.unit
    table = Table("line", f"set, {unit}", "volts", "direction", f"residual, {unit}")
    rows = zip(taken.lines, taken.points, made.fit.residuals, strict=True)
    for index, (line, point, residual) in enumerate(rows):
        table.add_row(
            str(line), f"{point.value:g}", f"{point.volts:z.4f}", DIRECTION_TEXT[point.direction],
            f"{residual:+z.3f}", style="yellow" if index in made.quality.outliers else None,
        )  # fmt: skip
    return table
