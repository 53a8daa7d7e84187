"""The second half of ``gsapp demo``: a small campaign, estimated, kept, repeated and reported."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from gsapp.foundation import FlightError

if TYPE_CHECKING:
    from rich.console import Console

DEMO_CATALOG: Final = "campaign.sqlite"
"""As the window calls the catalog of a folder of flights."""
_PLAN: Final = "six"
"""Of the other flight: enough maneuvers to tell honest bounds, and what strays, from chance."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DemoCampaign:
    """Where everything of the campaign lies.

    Attributes
    ----------
    flights : tuple of Path
    catalog : Path
    derivatives : Path
        JSON of ``gsapp estimate``.
    report : Path
        Folder.
    """

    flights: tuple[Path, ...]
    catalog: Path
    derivatives: Path
    report: Path


def create_demo_campaign(flight: Path, out: Path, console: Console, *, seed: int) -> DemoCampaign:
    """Fly once more, estimate from both flights, keep the run, repeat it, and write the report.

    Parameters
    ----------
    flight : Path
        The flight that was seen live; linear models are judged on it.
    out : Path
        Folder for everything.
    console : Console
    seed : int
        Of the other flight.

    Raises
    ------
    GroundStationError
        If a step fails, or the run cannot be repeated to the last bit.
    """
    from gsapp.cli import estimate, report
    from gsapp.cli.fly import write_folder
    from gsapp.virtual.downlink.flight_settings import FlightSettings

    made = DemoCampaign(
        flights=(out / f"{flight.name}-before", flight),
        catalog=out / DEMO_CATALOG,
        derivatives=out / f"{flight.name}-derivatives.json",
        report=out / f"{flight.name}-report",
    )
    console.print("5. The same aircraft on another day, six maneuvers, at full speed:")
    write_folder(
        FlightSettings(plan=_PLAN, seed=seed), made.flights[0], truth=None, console=console
    )
    console.print("6. The maneuvers of both flights by maximum likelihood:")
    estimate.run(
        flights=made.flights, json=made.derivatives, catalog=made.catalog, label=flight.name
    )
    number = _repeat(made.catalog)
    console.print(f"7. Run {number} is saved; repeating it gives bit-identical results.")
    console.print("8. The report with figures, files and linear models:")
    report.run(flights=made.flights, out=made.report, model="b777")
    return made


def _repeat(catalog: Path) -> int:
    """Do the last run again; return its number."""
    from gsapp.flight.catalog import Catalog
    from gsapp.identification.runs.run_comparison import repeat_run
    from gsapp.identification.runs.run_store import stored_runs

    with Catalog(catalog) as store:
        number = max(one.number for one in stored_runs(store))
        again = repeat_run(store, number)
    if not again.is_identical:
        raise FlightError(f"run {number} gives other numbers: {'; '.join(again.differences)}")
    return number


def show_review(campaign: DemoCampaign, out: Path, console: Console) -> None:
    """Open the window where the campaign is reviewed; its settings stay with the demo."""
    from ui.app import run_window
    from ui.settings import SettingsStore, settings_path

    settings = out / "window.toml"
    store = SettingsStore(settings)
    # Theme and size are the user's; flights and catalog the demo's.
    own = SettingsStore(settings_path()).current
    store.change(
        theme=own.theme, scale=own.scale, units=own.units, muted=own.muted,
        flights=str(out), review_flights=tuple(str(path) for path in campaign.flights),
    )  # fmt: skip
    console.print(
        "9. The window shows both flights in Review: edit maneuvers (Alt+1), estimate (Alt+2), "
        "figures\n   (Alt+3), summary (Alt+4). Close it to end."
    )
    run_window(settings=settings, place="review")
