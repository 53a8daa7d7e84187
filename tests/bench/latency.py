"""(d) From the arrival of a sample to its pixels, in the window that a crew uses.

A sender in a process of its own speaks the full-rate link of the aircraft's box (some 250
messages a second, 100 of them volts) over UDP. A recorder in its own process stamps and writes
it. The main window, with 16 charts, its own timer and all that stands beside the charts, follows
the folder.

What is measured, in milliseconds, for every sample of the pitch rate:

arrival
    The stamp that the recorder gave to the datagram as it read it from the socket: host time.
to painted pixels
    Until the window was flushed after painting the row that holds all of the sample: the first
    row of the charts' grid at or after the sample's own time. Stamps on the grid: the sample
    itself. Stamps beside the grid: a row between this sample and the next, so the wait for the
    next one, 10 ms, is part of the figure.
to pixels that it moves
    The same until the row before it, beside the grid only: it lies between the sample before and
    this one, so these are the first pixels that change because this sample came.
to the session's history
    Until decoded, converted and laid on the grid: without painting.

That this means pixels is proven as it runs: the pitch rate leaps every 0.4 s, and the screen is
read after every flush for the color of its line at the new value. `ui.session_poller` tells how the
time is shared out.

Beside each run stands what the machine gave to a loop that only looks at the clock, as often as
the window looks at the record: how late its timer came, and its share of a core.
"""

import math
import os
import socket
import statistics
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from tests.bench.sender_process import send_in_real_time, sending

RATE = 100
LEAP_EVERY = 40  # samples
STEPPED = "q"
_STEPPED_PLACE = 8  # of the pitch rate among the volts
_LEVELS = (2.3, 2.7)
_OFF_GRID_US = 3700
_WARM_UP = 3.0


# The sender


def volts_at(tick: int) -> list[float]:
    now = tick / RATE
    volts = [
        2.5 + 0.3 * math.sin(0.7 * now + k) + 0.004 * ((tick * (k + 3)) % 5) for k in range(20)
    ]
    volts[_STEPPED_PLACE] = _LEVELS[tick // LEAP_EVERY % 2]
    volts[13:15] = [2.6, 1.2]
    volts[18] = 5.0
    return volts


def frames_of(seconds: float, shift_us: int) -> Iterator[tuple[float, bytes]]:
    """Yield the full-rate link with its times, stamped so much after the places of the grid."""
    from gsapp.decoding.dialect import dialect
    from gsapp.virtual.downlink.onboard_messages import OnboardSample, telemetry_layout

    values = defaultdict(lambda: 0.5)
    values |= {"static_pressure": 98000.0, "temperature": 290.0, "Vc": 30.0, "battery": 11.8}
    packer = dialect().MAVLink(None, srcSystem=1, srcComponent=1)
    slots = telemetry_layout(thin=False, attitude_sent=True, position_sent=False)
    for number in range(round(seconds * RATE)):
        tick = OnboardSample(
            number=number, volts=volts_at(number), values=values, unix_us=1_700_000_000
        )
        frames = []
        for slot in slots:
            if number % slot.every == slot.offset:
                message = slot.pack(tick)
                if hasattr(message, "time_usec"):
                    message.time_usec += shift_us
                frames.append(bytes(message.pack(packer)))
                packer.seq = (packer.seq + 1) % 256
        for frame in frames:
            yield number / RATE, frame


# The window, watched


@dataclass
class Frames:
    """What was on screen when.

    Attributes
    ----------
    reached, shown : list of (int, float)
        Index of the newest sample of the leaping channel, with the host time (s) at which the
        session had taken it in, and at which it was on screen.
    leaps : dict of int to float
        Host time (s) at which the new value of a leap was read from the screen, by its sample.
    """

    reached: list[tuple[int, float]] = field(default_factory=list)
    shown: list[tuple[int, float]] = field(default_factory=list)
    leaps: dict[int, float] = field(default_factory=dict)
    watching: bool = True
    _waiting: list[int] = field(default_factory=list)

    def advanced(self, window) -> None:
        history = window.flight_controller.history
        if (
            not self.watching
            or history is None
            or not history.has(STEPPED)
            or history.last(STEPPED) is None
        ):
            return
        newest = round(history.last(STEPPED)[0] * RATE)
        before = self.reached[-1][0] if self.reached else newest
        if newest > before or not self.reached:
            self.reached.append((newest, time.time()))
            self._waiting += [k for k in range(before + 1, newest + 1) if k % LEAP_EVERY == 0]

    def flushed(self, window) -> None:
        now = time.time()
        if not (self.watching and self.reached) or (
            self.shown and self.shown[-1][0] == self.reached[-1][0]
        ):
            return
        self.shown.append((self.reached[-1][0], now))
        # After a long stall a leap may be over before it was on screen.
        while self._waiting and self.shown[-1][0] >= self._waiting[0] + LEAP_EVERY:
            del self._waiting[0]
        if self._waiting and new_value_on_screen(window, self._waiting[0]):
            self.leaps[self._waiting.pop(0)] = now


def new_value_on_screen(window, sample: int) -> bool:
    """Tell whether the screen has the color of the leaping line at its new value, newest column."""
    from ui.strips.raster import value_row_transform

    charts, history = window.view.charts, window.flight_controller.history
    geometry, raster = charts.geometry_in_pixels, charts.raster.raster
    places = [
        index
        for index, number in enumerate(geometry.numbers)
        if charts.charts[number].specs[0].id == STEPPED
    ]
    value = float(history.samples(STEPPED, sample, sample + 1)[0])
    if not places or math.isnan(value):
        return False
    chart = raster.charts[places[0]]
    offset, gain = value_row_transform(chart, raster.pad)
    corner = charts.mapTo(window, charts.rect().topLeft())
    x = corner.x() + geometry.plot.x + geometry.plot.width - 1
    y = corner.y() + geometry.plot.y + chart.top + int(offset - gain * value)
    image = window.screen().grabWindow(window.winId(), x, y, 1, 1).toImage()
    if image.isNull():
        return False
    seen, color = image.pixelColor(0, 0), chart.traces[0].color
    return max(abs(one - other) for one, other in zip(seen.getRgb(), color, strict=False)) < 60


def watched_window(folder: Path, frames: Frames):
    """Return the main window, which tells `frames` what it takes in and what it has flushed."""
    from PySide6.QtCore import QEvent

    from ui.error_reporter import ErrorReporter
    from ui.main_window import MainWindow
    from ui.settings import SettingsStore

    class Watched(MainWindow):
        def event(self, event: QEvent) -> bool:
            done = super().event(event)
            if event.type() == QEvent.Type.UpdateRequest:
                frames.flushed(self)
            return done

    store = SettingsStore(folder / "window.toml")
    store.change(muted=True)
    window = Watched(store, ErrorReporter())
    # Connected after the charts' own slot: called when their columns are painted.
    window.flight_controller.frame_requested.connect(lambda _: frames.advanced(window))
    window.resize(1280, 800)
    window.show()
    return window


@dataclass(frozen=True, slots=True, kw_only=True)
class Result:
    history: np.ndarray
    pixels: np.ndarray
    first_pixels: np.ndarray
    leaps: np.ndarray
    leaps_sent: int
    same_frame: int
    window: float
    recorder: float | None
    frames_per_second: float
    charts: int
    off_grid: bool
    idle: float
    idle_late: float


def processor_time(pid: int) -> float | None:
    try:
        fields = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    except OSError:
        return None
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def empty_loop(seconds: float) -> tuple[float, float]:
    """Return share of a core, and the 95th percentile of lateness (ms), of an idle Qt timer."""
    from PySide6.QtCore import QEventLoop, Qt, QTimer

    from ui.app import create_application
    from ui.session_poller import POLL_INTERVAL_MS

    create_application()
    ticks: list[float] = []
    loop, timer = QEventLoop(), QTimer()
    timer.setTimerType(Qt.TimerType.PreciseTimer)
    timer.timeout.connect(lambda: ticks.append(time.perf_counter()))
    QTimer.singleShot(round(1000 * seconds), loop.quit)
    used, begin = time.process_time(), time.perf_counter()
    timer.start(POLL_INTERVAL_MS)
    loop.exec()
    timer.stop()
    share = (time.process_time() - used) / (time.perf_counter() - begin)
    late = 1e3 * np.diff(ticks) - POLL_INTERVAL_MS
    return share, float(np.percentile(late, 95))


def measure(seconds: float, shift_us: int = 0) -> Result:
    """Run sender, recorder and window for a while.

    Parameters
    ----------
    seconds : float
        How long to measure.
    shift_us : int
        How far the vehicle's stamps lie behind the places of the grid.
    """
    from PySide6.QtCore import QEventLoop, QTimer

    from ui.app import create_application
    from ui.dialogs.flight_requests import ConnectRequest

    application = create_application()

    def run(how_long: float) -> None:
        loop = QEventLoop()
        QTimer.singleShot(round(1000 * how_long), loop.quit)
        loop.exec()

    idle, idle_late = empty_loop(0.25 * seconds)
    frames = Frames()
    with tempfile.TemporaryDirectory() as place:
        os.environ["GSAPP_RUNTIME_FOLDER"] = str(Path(place) / "runtime")
        folder = Path(place) / "flight"
        window = watched_window(Path(place), frames)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        try:
            window.flight_controller.flight_opener.connect_aircraft(
                ConnectRequest(
                    link=f"udpin:127.0.0.1:{port}", folder=folder, channel_map="b777",
                    aircraft="b777", calibration="b777",
                )
            )  # fmt: skip
            deadline = time.monotonic() + 30.0
            while not window.flight_controller.is_open:
                run(0.05)
                if time.monotonic() > deadline:
                    raise TimeoutError("the recorder did not start")
            recorder = window.flight_controller.session.recorder
            with sending(__file__, port, seconds + 60.0, shift_us):
                while not frames.shown:
                    run(0.05)
                    if time.monotonic() > deadline:
                        raise TimeoutError("the sender was not heard")
                run(_WARM_UP)
                begin, first = time.perf_counter(), len(frames.shown)
                used = time.process_time()
                recorder_used = processor_time(recorder.pid) if recorder else None
                start = frames.shown[-1][0]
                run(seconds)
                frames.watching = False
                wall = time.perf_counter() - begin
                used = time.process_time() - used
                if recorder is not None and recorder_used is not None:
                    after = processor_time(recorder.pid)
                    recorder_used = None if after is None else after - recorder_used
                charts = len(window.view.charts.geometry_in_pixels.numbers)
                drawn = len(frames.shown) - first
        finally:
            window.flight_controller.recorders.stop_recording_and_wait()
            window.flight_controller.close()
            window.close()
            window.deleteLater()
            application.processEvents()
        arrived = arrivals(folder)
    frames.leaps = {k: at for k, at in frames.leaps.items() if k > start}
    pixels = ages(frames.shown, arrived, start)
    # Beside the grid a sample also completes the row before it, and moves the line there.
    arrived_before = {k - (shift_us != 0): at for k, at in arrived.items()}
    by_leap = {k: 1e3 * (at - arrived[k]) for k, at in frames.leaps.items() if k in arrived}
    last = frames.shown[-1][0]
    return Result(
        history=np.array(list(ages(frames.reached, arrived, start).values())),
        pixels=np.array(list(pixels.values())),
        first_pixels=np.array(list(ages(frames.shown, arrived_before, start).values())),
        leaps=np.array(list(by_leap.values())),
        leaps_sent=sum(k % LEAP_EVERY == 0 for k in range(start + 1, last + 1)),
        same_frame=sum(abs(by_leap[k] - pixels[k]) < 1e-6 for k in by_leap if k in pixels),
        window=used / wall,
        recorder=None if recorder_used is None else recorder_used / wall,
        frames_per_second=drawn / wall,
        charts=charts,
        off_grid=shift_us != 0,
        idle=idle,
        idle_late=idle_late,
    )


def arrivals(folder: Path) -> dict[int, float]:
    """Return when the recorder stamped the volts (host s), by the place at or after the sample.

    That place is the first row of the grid that holds all of the sample: on the grid the sample
    itself, beside it the next row, for which the next sample is needed.
    """
    from gsapp.decoding.dialect import dialect
    from gsapp.flight.raw_files import RawTail

    reader = dialect().MAVLink(None)
    found = {}
    for record in RawTail(folder).poll():
        if record.kind == "frame" and record.data[7:10] == b"\x5e\x01\x00":  # 350
            stamp = reader.decode(bytearray(record.data)).time_usec
            found[-(-stamp * RATE // 1_000_000)] = record.stamp_us / 1e6
    return found


def ages(
    events: list[tuple[int, float]], arrived: dict[int, float], start: int
) -> dict[int, float]:
    found = {}
    before = start
    for newest, at in events:
        for sample in range(before + 1, newest + 1):
            if sample in arrived:
                found[sample] = 1e3 * (at - arrived[sample])
        before = max(before, newest)
    return found


def describe(title: str, ms: np.ndarray) -> str:
    if not ms.size:
        return f"    {title:34} nothing came"
    middle, high, higher = np.percentile(ms, (50, 95, 99))
    return (
        f"    {title:34}{middle:7.1f}{high:7.1f}{higher:7.1f}{ms.max():7.1f}   {ms.size:5} samples"
    )


def tell(result: Result) -> None:
    """Print a result."""
    recorder = "" if result.recorder is None else f", recorder {100 * result.recorder:.0f} %"
    load = f"{os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "?"
    print(f"    {'ms':34}{'50th':>7}{'95th':>7}{'99th':>7}{'worst':>7}")
    print(describe("arrival to the session's history", result.history))
    if result.off_grid:
        print(describe("arrival to pixels that it moves", result.first_pixels))
    print(describe("arrival to painted pixels", result.pixels))
    print(describe("leaps, read from the screen", result.leaps))
    print(
        f"    {len(result.leaps)} of {result.leaps_sent} leaps seen, {result.same_frame} of them "
        f"in the very frame reckoned; {result.charts} charts, "
        f"{result.frames_per_second:.0f} frames/s\n"
        f"    share of a core: window {100 * result.window:.0f} %, an idle loop "
        f"{100 * result.idle:.1f} %{recorder}; {load} processes want {os.cpu_count()} cores; "
        f"an idle timer is up to {result.idle_late:.1f} ms late (95th)",
        flush=True,
    )


def sum_up(results: Sequence[Result]) -> None:
    pixels = [float(np.percentile(result.pixels, 95)) for result in results if result.pixels.size]
    if not pixels:
        return
    shares = [100 * result.window for result in results]
    ratios = [result.window / result.idle for result in results]
    print(
        f"    median of {len(pixels)} runs: 95th percentile {statistics.median(pixels):.1f} ms "
        f"(goal 20 ms), window {statistics.median(shares):.0f} % of a core, "
        f"{statistics.median(ratios):.0f} times an idle loop",
        flush=True,
    )


def main(*options: str) -> None:
    seconds, runs = (4.0, 1) if "--quick" in options else (8.0, 3)
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    for text, shift in (
        ("stamps on the grid, as the aircraft's box sends them", 0),
        ("stamps beside the grid: the row after a sample waits for the next sample", _OFF_GRID_US),
    ):
        results = []
        for number in range(runs):
            print(f"\n{text}, run {number + 1} of {runs}")
            results.append(measure(seconds, shift))
            tell(results[-1])
        sum_up(results)


if __name__ == "__main__":
    if sys.argv[1:2] == ["send"]:
        send_in_real_time(int(sys.argv[2]), frames_of(float(sys.argv[3]), int(sys.argv[4])))
    else:
        main(*sys.argv[1:])
