"""``gsapp record LINK --out FLIGHT``: record until interrupted."""

from __future__ import annotations

from pathlib import Path


def run(
    link: str,
    out: Path,
    *,
    channel_map: str | None = None,
    aircraft: str | None = None,
    calibration: str | None = None,
    heartbeat: bool | None = None,
    speed: float | None = None,
    json: Path | None = None,
) -> None:
    """Record a link into a flight folder, in this process, until Ctrl-C or `recorder.stop`.

    Parameters
    ----------
    link : str
        The LINK.
    out : Path
        The flight folder; continued if it holds a record already.
    channel_map, aircraft, calibration : str, optional
        Names or paths of what the record is to be read with; copies go into the folder.
    heartbeat : bool, optional
        Whether to send the ground station's sign of life once a second; by default only over
        ``udpout``.
    speed : float, optional
        Of a recorded flight as the link.
    json : Path, optional
        Where to write the final state for programs.
    """
    import threading

    from rich.console import Console

    from gsapp.flight.preparing import prepare_flight
    from gsapp.foundation import write_atomically
    from gsapp.telemetry.address import parse_link
    from gsapp.telemetry.recorder_process import record, stop_on_signals
    from gsapp.telemetry.status import RecorderStatus

    console = Console()
    stop = threading.Event()
    stop_on_signals(stop)
    told: list[str] = []

    def tell(status: RecorderStatus) -> None:
        words = [status.source_state, *status.notes, *status.warnings, status.error]
        for sentence in words:
            # Once each: the number in a warning changes all the time, its first words do not.
            key = sentence[:24]
            if sentence and key not in told:
                told.append(key)
                console.print(sentence, highlight=False, soft_wrap=True)

    parse_link(link)  # before anything is made
    prepare_flight(
        out, aircraft=aircraft, channel_map=channel_map, calibration=calibration, source=link
    )
    console.print(f"Recording {link} into {out}; Ctrl-C ends it.", highlight=False, soft_wrap=True)
    options = {} if speed is None else {"speed": speed}
    status = record(link, out, heartbeat=heartbeat, stop=stop, on_status=tell, **options)
    seconds = (status.updated_us - status.started_us) / 1e6
    console.print(
        f"Recorded {status.frames} frames, {status.lines} lines and {status.residue_bytes} other "
        f"bytes in {seconds:.0f} s.",
        highlight=False,
        soft_wrap=True,
    )
    if json is not None:
        write_atomically(json, status.model_dump_json(indent=2) + "\n")
