"""What the stream and the window notice of derivatives that form in a live flight.

The virtual aircraft's flight over its full-rate link, from a little before the first maneuver on,
is sent in real time by a process of its own over UDP. A recorder in its own process stamps and
writes it; the main window, off screen, with 16 charts, cues, and the panel of estimates, follows
the folder. In turns, on the same flight:

without
    No FTR and no fits; all else is the same.
with
    FTR listens to every sample in the window's process; maximum likelihood fits each maneuver in
    a process of its own three seconds after it ended.

Told for both, and as ratios: milliseconds from the recorder's stamp on a sample to the pixels that
show it, and to the cues that judged it; between two frames; the lateness of a timer of 10 ms in the
window's own loop; samples that are missing in the record or in the session; shares of a core.
"""

import os
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from tests.bench import latency
from tests.bench.sender_process import send_in_real_time, sending

RATE = latency.RATE
_SEED = 0
_BEFORE = 12.0
"""Seconds of flight before the first maneuver with which a run begins."""
_SETTLE = 4.0
_TIMER_MS = 10


@dataclass
class Seen(latency.Frames):
    cues: list[tuple[int, float]] = field(default_factory=list)
    late: list[float] = field(default_factory=list)

    def advanced(self, window) -> None:
        super().advanced(window)
        self._waiting.clear()
        session = window.flight_controller.session
        # Asked for only while it is watched: this, too, takes time.
        cues = session.cues if self.watching and session is not None else None
        if cues is not None and cues.time is not None:
            newest = round(cues.time * RATE)
            if not self.cues or newest > self.cues[-1][0]:
                self.cues.append((newest, time.time()))


@dataclass(frozen=True, slots=True, kw_only=True)
class Result:
    pixels: np.ndarray
    cues: np.ndarray
    frames: np.ndarray
    late: np.ndarray
    sent: int
    lost_in_record: int
    lost_in_session: int
    window: float
    fits_cpu: float
    fitted: int
    derivatives: int


# --- the flight -----------------------------------------------------------------------------------


def fly(place: Path, seconds: float) -> float:
    """Write the frames of the flight from before its first maneuver on; return the s it took."""
    from gsapp.virtual.downlink.flight_settings import FlightSettings
    from gsapp.virtual.downlink.onboard_log import pack_tlog_record

    begin = time.monotonic()
    downlink = FlightSettings(plan="default", seed=_SEED).create_downlink(1_760_000_000_000_000)
    packets, start = [], None
    while not downlink.finished:
        for packet in downlink.advance(200):
            packets.append(packet)
            if start is None:
                packets = packets[-round(_BEFORE * RATE) :]
                if "maneuver" in packet.phase:
                    start = packet.time - _BEFORE
            elif packet.time >= start + seconds + 2 * _SETTLE:
                downlink.stop()
    with place.open("wb") as file:
        for packet in packets:
            file.write(
                b"".join(pack_tlog_record(packet.stamp_us, frame) for frame in packet.live_frames)
            )
    return time.monotonic() - begin


def send(port: int, place: Path) -> None:
    from gsapp.flight.raw_files import read_tlog

    ticks: dict[int, bytes] = {}
    for record in read_tlog(place):
        ticks[record.stamp_us] = ticks.get(record.stamp_us, b"") + record.data
    send_in_real_time(port, ((1e-6 * stamp, data) for stamp, data in sorted(ticks.items())))


# --- a run ----------------------------------------------------------------------------------------


def children(pid: int) -> list[int]:
    found = []
    for status in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = status.read_text(encoding="ascii").rpartition(")")[2].split()
        except (OSError, ValueError):
            continue
        if int(fields[1]) == pid:
            found += [int(status.parent.name), *children(int(status.parent.name))]
    return found


def measure(place: Path, seconds: float, *, estimates: bool) -> Result:
    """Run sender, recorder and window for a while, with or without estimates."""
    from PySide6.QtCore import QEventLoop, Qt, QTimer

    import ui.flight_opener
    from gsapp.session.live_estimation.fit_workers import ProcessFitWorker
    from gsapp.virtual.downlink.aircraft_process import find_free_udp_port
    from ui.app import create_application
    from ui.dialogs.flight_requests import ConnectRequest

    ui.flight_opener.ProcessFitWorker = ProcessFitWorker if estimates else lambda: None
    application = create_application()

    def run(how_long: float) -> None:
        loop = QEventLoop()
        QTimer.singleShot(round(1000 * how_long), loop.quit)
        loop.exec()

    seen = Seen()
    timer = QTimer()
    timer.setTimerType(Qt.TimerType.PreciseTimer)
    ticks: list[float] = []
    timer.timeout.connect(lambda: ticks.append(time.perf_counter()))
    with tempfile.TemporaryDirectory() as scratch:
        os.environ["GSAPP_RUNTIME_FOLDER"] = str(Path(scratch) / "runtime")
        folder = Path(scratch) / "flight"
        window = latency.watched_window(Path(scratch), seen)
        port = find_free_udp_port()
        try:
            window.flight_controller.flight_opener.connect_aircraft(
                ConnectRequest(
                    link=f"udpin:127.0.0.1:{port}", folder=folder, channel_map="b777",
                    aircraft="b777", calibration="b777",
                )
            )  # fmt: skip
            deadline = time.monotonic() + 30.0
            while not window.flight_controller.is_open and time.monotonic() < deadline:
                run(0.05)
            window.commands.actions["panel_estimates"].trigger()
            with sending(__file__, port, place):
                while not seen.shown and time.monotonic() < deadline:
                    run(0.05)
                run(_SETTLE)
                start, first = seen.shown[-1][0], len(seen.shown)
                session = window.flight_controller.session
                recorder = session.recorder.pid if session.recorder else 0
                used, begin = time.process_time(), time.perf_counter()
                timer.start(_TIMER_MS)
                run(seconds)
                timer.stop()
                seen.watching = False
                wall = time.perf_counter() - begin
                used = time.process_time() - used
            fits = session.estimates
            helpers = [one for one in children(os.getpid()) if one != recorder]
            spent = sum(latency.processor_time(one) or 0.0 for one in helpers)
            last = seen.shown[-1][0]
            history = window.flight_controller.history.samples(latency.STEPPED, start + 1, last + 1)
            lost = int(np.isnan(history).sum())
            fitted = len(fits.result.results) if fits is not None else 0
            values = len(fits.result.values) if fits is not None else 0
        finally:
            window.flight_controller.recorders.stop_recording_and_wait()
            window.flight_controller.close()
            window.close()
            window.deleteLater()
            application.processEvents()
        arrived = latency.arrivals(folder)
    shown = [at for _, at in seen.shown[first:]]
    return Result(
        pixels=np.array(list(latency.ages(seen.shown, arrived, start).values())),
        cues=np.array(
            [1e3 * (at - arrived[k]) for k, at in seen.cues if k > start and k in arrived]
        ),
        frames=1e3 * np.diff(shown),
        late=1e3 * np.diff(ticks) - _TIMER_MS,
        sent=last - start,
        lost_in_record=sum(k not in arrived for k in range(start + 1, last + 1)),
        lost_in_session=lost,
        window=used / wall,
        fits_cpu=spent,
        fitted=fitted,
        derivatives=values,
    )


# --- what is told ---------------------------------------------------------------------------------


def joined(results: list[Result], name: str) -> np.ndarray:
    return np.concatenate([getattr(one, name) for one in results])


def tell(without: list[Result], with_them: list[Result]) -> None:
    """Print both beside each other, and the ratios."""
    print(f"    {'ms':36}{'':>9}{'50th':>7}{'95th':>7}{'99th':>7}{'worst':>8}")
    for name, title in (
        ("pixels", "arrival to painted pixels"),
        ("cues", "arrival to cues"),
        ("frames", "between two frames"),
        ("late", f"lateness of a {_TIMER_MS} ms timer"),
    ):
        rows = []
        for text, results in (("without", without), ("with", with_them)):
            ages = joined(results, name)
            row = np.array([*np.percentile(ages, (50, 95, 99)), ages.max()])
            rows.append(row)
            print(f"    {title:36}{text:>9}" + "".join(f"{one:7.1f}" for one in row))
        ratios = rows[1] / np.maximum(rows[0], 0.1)
        print(f"    {'':36}{'ratio':>9}" + "".join(f"{one:7.2f}" for one in ratios))
    for text, results in (("without", without), ("with", with_them)):
        sent = sum(one.sent for one in results)
        print(
            f"    {text:8} {sent} samples: {sum(one.lost_in_record for one in results)} lost in "
            f"the record, {sum(one.lost_in_session for one in results)} in the session; window "
            f"{100 * np.mean([one.window for one in results]):.0f} % of a core, fits "
            f"{sum(one.fits_cpu for one in results):.1f} s of processor time for "
            f"{sum(one.fitted for one in results)} maneuvers, "
            f"{max(one.derivatives for one in results)} derivatives"
        )
    load = f"{os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "?"
    print(f"    {load} processes want {os.cpu_count()} cores", flush=True)


def main(*options: str) -> None:
    seconds, turns = (45.0, 1) if "--quick" in options else (100.0, 2)
    with tempfile.TemporaryDirectory() as scratch:
        place = Path(scratch) / "flight.tlog"
        print(f"    flown in {fly(place, seconds):.0f} s", flush=True)
        without, with_them = [], []
        for _ in range(turns):
            without.append(measure(place, seconds, estimates=False))
            with_them.append(measure(place, seconds, estimates=True))
    tell(without, with_them)


if __name__ == "__main__":
    if sys.argv[1:2] == ["send"]:
        send(int(sys.argv[2]), Path(sys.argv[3]))
    else:
        main(*sys.argv[1:])
