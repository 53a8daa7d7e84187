"""The folder that a search for a missing effect leaves: model, report, figures, cards, result."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from gsapp.discrepancy.results import DiscrepancyResult, discrepancy_json
from gsapp.dynamics.model import save_model
from gsapp.flight.cards import save_cards
from gsapp.flight.info import local_timestamp
from gsapp.foundation import GroundStationError, write_atomically
from gsapp.foundation.errors import format_os_error
from gsapp.foundation.files import create_sibling_folder, format_json, move_into_place
from gsapp.report.discrepancy_report import DiscrepancyReportUnits, write_discrepancy_report
from gsapp.report.provenance import Provenance

MODEL_FILE, RESULT_FILE, CARDS_FILE = "model.toml", "discrepancy.json", "cards.toml"
"""Files in the folder beside the report and its figures."""


def check_output_folder(out: Path) -> None:
    """Raise unless the folder can be written: said before the search, not after it."""
    if out.exists() and not out.is_dir():
        raise GroundStationError(f"{out} is a file; choose a folder for the answer")
    there = next((one for one in (out, *out.absolute().parents) if one.is_dir()), Path())
    try:
        Path(tempfile.mkdtemp(prefix=".gsapp-", dir=there)).rmdir()
    except OSError as error:
        raise GroundStationError(
            format_os_error(out, error, "choose a folder with write permission")
        ) from error


def write_discrepancy_folder(
    found: DiscrepancyResult,
    out: Path,
    *,
    aircraft: str,
    provenance: Provenance,
    draw: Sequence[str] = (),
    units: DiscrepancyReportUnits = "US",
) -> None:
    """Write everything: all of it stands in the folder afterwards, or nothing.

    `draw`: maneuvers of which the report shows all channels; by default the worst held out.
    """
    with _atomic_folder(out) as folder:
        save_model(found.model, folder / MODEL_FILE)
        if found.experiment is not None:
            save_cards(folder / CARDS_FILE, found.experiment.card_set(aircraft))
        write_atomically(
            folder / RESULT_FILE, format_json(discrepancy_json(found, model=out / MODEL_FILE))
        )
        write_discrepancy_report(
            found, folder, aircraft=aircraft, provenance=provenance, units=units,
            overlays=draw or None, written=local_timestamp(),
        )  # fmt: skip


@contextmanager
def _atomic_folder(out: Path) -> Iterator[Path]:
    """Give a folder to fill; what is in it stands at `out` when all is done, or not at all."""
    out.parent.mkdir(parents=True, exist_ok=True)
    part = create_sibling_folder(out)
    try:
        yield part
        if not out.exists():
            move_into_place(part, out)
            return
        for new in part.iterdir():
            old = out / new.name
            if old.is_dir():
                shutil.rmtree(old)
            move_into_place(new, old)
    finally:
        shutil.rmtree(part, ignore_errors=True)
