"""``gsapp demo``: the whole job on a virtual flight.

The virtual aircraft streams over a real link, a recorder process writes it down, a session (and
the window, unless headless) shows it live; then the record is replayed, compared with what was
seen live, summed up, and drawn. With a second flight it makes a small campaign: derivatives by
maximum likelihood, a run that is kept and repeated, linear models, a report, and the review.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gsapp.cli._options import DISPLAY_UNITS, JsonFile

if TYPE_CHECKING:
    from gsapp.cli._console import PlainConsole
    from gsapp.session import Session
    from gsapp.virtual.downlink.aircraft_process import AircraftProcess

_CHANNELS = (
    "V", "altitude", "alpha", "beta", "p", "q", "r", "an", "ax", "ay",
    "de", "da", "dr", "throttle", "rpm_left",
)  # fmt: skip
_HEADLESS_SPEED = 4.0
_END_OF_DATA_SECONDS = 1.0
"""Seconds without a new sample, after the aircraft is done, that end the live part."""
_CATALOG = "campaign.sqlite"
"""As the window calls the catalog of a folder of flights."""
_PLAN = "six"
"""Of the other flight: enough maneuvers to tell honest bounds, and what strays, from chance."""


def demo(
    headless: Annotated[bool, typer.Option("--headless", help="Without a window")] = False,
    out: Annotated[Path, typer.Option(readable=False, metavar="DIR", help="Output folder")] = Path(
        "demo-flight"
    ),
    seed: Annotated[int, typer.Option(min=0, help="Random seed of the flight")] = 1,
    speed: Annotated[
        float | None, typer.Option(metavar="X", help="Times real time; 1 with a window, 4 without")
    ] = None,
    json: JsonFile = None,
) -> None:
    """Do the whole job once, on virtual flights.

    Stream, record, replay, estimate, report, review.

    Example: gsapp demo --headless --out demo-flight
    """
    from gsapp.cli._console import PlainConsole, is_stdout, write_json
    from gsapp.cli._usage_errors import check_speed
    from gsapp.cli.estimate import estimate
    from gsapp.cli.fly import write_folder
    from gsapp.cli.report import report
    from gsapp.flight.folder_setup import prepare_flight_folder
    from gsapp.telemetry.recorder_control import start_recorder
    from gsapp.virtual.downlink.aircraft_process import AircraftProcess, find_free_udp_port
    from gsapp.virtual.downlink.flight_settings import FlightSettings
    from ui.display_check import NoDisplayError, require_display
    from ui.settings import SettingsStore, settings_path

    DISPLAY_UNITS.set("SI" if SettingsStore(settings_path()).current.units == "SI" else "US")
    console = PlainConsole(soft_wrap=True, stderr=is_stdout(json))
    check_speed(speed)
    if not headless:
        try:
            require_display()
        except NoDisplayError as why:
            console.print(f"{why}.\nThe demo continues without a window.")
            headless = True
    folder = _unused(out / "flight")
    port = find_free_udp_port()
    link = f"udpin:127.0.0.1:{port}"
    prepare_flight_folder(folder, aircraft="b777", channel_map="b777", source=link, notes="Demo.")
    recorder = start_recorder(link, folder)
    console.print(f"1. A recorder (process {recorder.pid}) writes {link} into {folder}.")
    if speed is None:
        speed = _HEADLESS_SPEED if headless else 1.0
    aircraft = None
    try:
        aircraft = AircraftProcess(
            folder, port, FlightSettings(plan="short", seed=seed), speed=speed
        )
        console.print(f"2. The virtual aircraft flies the short plan at {speed:g} times real time.")
        if headless:
            live = _follow_live(folder, aircraft, console)
        else:
            from ui.app import run_window

            console.print("3. The window shows it live; close it to continue.")
            run_window(flight=folder)
            live = None
    finally:
        if aircraft is not None:
            aircraft.stop()
        recorder.stop()
    result = _replay(folder, out, live, console)
    flights = (out / f"{folder.name}-before", folder)
    catalog = out / _CATALOG
    derivatives = out / f"{folder.name}-derivatives.json"
    reported = out / f"{folder.name}-report"
    console.print("5. The same aircraft on another day, six maneuvers, at full speed:")
    write_folder(FlightSettings(plan=_PLAN, seed=seed + 1), flights[0], truth=None, console=console)
    console.print("6. The maneuvers of both flights by maximum likelihood:")
    estimate(flights=[*flights], json=derivatives, catalog=catalog, label=folder.name)
    number = _repeat(catalog)
    console.print(f"7. Run {number} is saved; repeating it gives bit-identical results.")
    console.print("8. The report with figures, files and linear models:")
    report(flights=[*flights], out=reported, model="b777")
    result |= {
        "report": str(reported),
        "derivatives": str(derivatives),
        "catalog": str(catalog),
        "flights": [str(path) for path in flights],
    }
    console.print(
        f"The flight: {folder}\nits summary: {result['summary']}\nits charts: "
        f"{result['picture']}\nderivatives of both flights: {derivatives}\n"
        f"the catalog with the run: {catalog}\nthe report: {reported}"
    )
    write_json(json, result)
    if not headless:
        _show_review(flights, out, console)


def _unused(path: Path) -> Path:
    """Return `path`, or `path`-2, -3, ...: an earlier flight is never written into."""
    number = 1
    candidate = path
    while candidate.exists():
        number += 1
        candidate = path.with_name(f"{path.name}-{number}")
    return candidate


def _follow_live(folder: Path, aircraft: AircraftProcess, console: PlainConsole) -> Session:
    """Follow the flight as a window would, until it is over."""
    from rich.progress import Progress, TextColumn

    from gsapp.foundation import FlightError
    from gsapp.session import Session
    from gsapp.session.live_estimation.fit_workers import ProcessFitWorker

    session = Session.follow(folder, workers=ProcessFitWorker())
    last_new, seen = time.monotonic(), None
    line = TextColumn("3. Live: flight time {task.fields[time]}, {task.fields[rate]} frames/s")
    with Progress(line, console=console) as progress:
        task = progress.add_task("", total=None, time="-", rate="-")
        while aircraft.is_running() or time.monotonic() - last_new < _END_OF_DATA_SECONDS:
            session.update()
            if session.now != seen:
                last_new, seen = time.monotonic(), session.now
                shown = "-" if seen is None else f"{seen:.0f} s"
                rate = session.snapshot().link.rate
                progress.update(task, time=shown, rate="-" if rate is None else f"{rate:.0f}")
            time.sleep(0.016)
    if complaint := aircraft.take_error():
        raise FlightError(complaint)
    return session


def _replay(folder: Path, out: Path, live: Session | None, console: PlainConsole) -> dict[str, Any]:
    """Replay the record, compare, sum up and draw; return the result for programs."""
    from gsapp.cli.replay import print_summary, summary_json
    from gsapp.foundation import FlightError
    from gsapp.report.strip_figure import write_strip_figure
    from gsapp.session import UNLIMITED_SPEED, Session
    from gsapp.session.live_estimation.fit_workers import InlineFitWorker
    from gsapp.session.replay_runner import run_replay

    session = Session.replay(folder, speed=UNLIMITED_SPEED, workers=InlineFitWorker())
    started = time.monotonic()
    run_replay(session)
    seconds = time.monotonic() - started
    flight = session.flight()
    if not len(flight.block):
        raise FlightError(f"nothing was recorded in {folder}; see {folder}/virtual-aircraft.log")
    console.print(f"4. Replayed {flight.duration:.0f} s of flight in {seconds:.1f} s.")
    compared = None
    if live is not None:
        live.finish()
        compared = _count_same_channels(live, session)
        differing = _differing_results(live, session)
        # Cues do not wait for what a pause held back; a replay has it in time.
        paused = any(one.key == "link" and one.time is not None
                     for one in live.alarm_registry.onsets)  # fmt: skip
        if differing and not paused:
            raise FlightError(f"the replay gives different {differing} than the live view")
        console.print(
            f"   {compared} channels are bit-identical to the live view, but not the {differing}:\n"
            "   the computer was too busy and data paused. Close other programs, or use --speed 1."
            if differing
            else f"   {compared} channels are bit-identical to the live view, and so are all cues\n"
            "   and all in-flight derivatives."
        )
        live.close()
    picture = write_strip_figure(
        flight.block, _CHANNELS, out / f"{folder.name}.png",
        title=f"Virtual flight of the B777, {flight.duration:.0f} s", units=DISPLAY_UNITS.get(),
    )  # fmt: skip
    summary = out / f"{folder.name}.json"
    print_summary(session, console, summary)
    shown = summary_json(session)
    session.close()
    return {
        "flight": str(folder),
        "summary": str(summary),
        "picture": str(picture),
        "channels_as_live": compared,
        **shown,
    }


def _count_same_channels(live: Session, replayed: Session) -> int:
    """Return how many channels agree bit for bit; raise if one differs."""
    import numpy as np

    from gsapp.foundation import FlightError

    first = round((replayed.history.start or 0.0) * replayed.history.rate)
    last = round((replayed.history.end or 0.0) * replayed.history.rate) + 1
    for channel_id in replayed.history.channels:
        ours = live.history.samples(channel_id, first, last)
        theirs = replayed.history.samples(channel_id, first, last)
        if not np.array_equal(ours, theirs, equal_nan=True):
            raise FlightError(f"'{channel_id}' differs between the live view and the replay")
    return len(replayed.history.channels)


def _differing_results(live: Session, replayed: Session) -> str:
    """Return what a replay gives otherwise than the live view; empty for nothing."""
    told, again = live.crew_cues.debrief(), replayed.crew_cues.debrief()
    if told is not None and again is not None and told.cues_json() != again.cues_json():
        return "cues"
    formed, found = live.estimates, replayed.estimates
    if formed is not None and found is not None and formed.to_json() != found.to_json():
        return "in-flight derivatives"
    return ""


def _repeat(catalog: Path) -> int:
    """Do the last run again; return its number."""
    from gsapp.flight.catalog import Catalog
    from gsapp.foundation import FlightError
    from gsapp.identification.runs.run_comparison import repeat_run
    from gsapp.identification.runs.run_store import stored_runs

    with Catalog(catalog) as store:
        number = max(one.number for one in stored_runs(store))
        again = repeat_run(store, number)
    if not again.is_identical:
        raise FlightError(f"run {number} gives other numbers: {'; '.join(again.differences)}")
    return number


def _show_review(flights: Sequence[Path], out: Path, console: PlainConsole) -> None:
    """Open the window where the campaign is reviewed; its settings stay with the demo."""
    from ui.app import run_window
    from ui.settings import SettingsStore, settings_path

    settings = out / "window.toml"
    store = SettingsStore(settings)
    # Theme and size are the user's; flights and catalog the demo's.
    own = SettingsStore(settings_path()).current
    store.change(
        theme=own.theme, scale=own.scale, units=own.units, muted=own.muted,
        flights=str(out), review_flights=tuple(str(path) for path in flights),
    )  # fmt: skip
    console.print(
        "9. The window shows both flights in Review: edit maneuvers (Alt+1), estimate (Alt+2), "
        "figures\n   (Alt+3), summary (Alt+4). Close it to end."
    )
    run_window(settings=settings, place="review")
