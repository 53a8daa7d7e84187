"""Strip charts: screen updates against pyqtgraph, share of a core, memory over an hour.

All figures are processor time of this process, medians, measured side by side in one run. An
update is what one frame takes: samples of a sixtieth of a second arrive, everything is drawn.
"""

import gc
import os
import statistics
import sys
import time
from collections.abc import Callable

import numpy as np

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import pyqtgraph
from PySide6.QtCore import QEventLoop, Qt, QTimer
from PySide6.QtWidgets import QApplication

from gsapp.quantities import CHANNELS, Block
from gsapp.session.limits import LimitBands
from gsapp.session.sample_history import SampleHistory
from tests.bench.memory import anonymous_memory
from ui.strips.strip_chart import StripChart
from ui.strips.strip_layout import Strip, StripGroup, StripLayout, Trace

SIZE = (1280, 800)
NAMES = tuple(name for name in CHANNELS if not name.endswith("_volts"))
FRAMES_PER_SECOND = 60


def signal(rng: np.random.Generator, first: int, count: int, rate: float, noise: float):
    t = (first + np.arange(count)) / rate
    return 0.1 * np.sin(0.4 * t) + noise * rng.normal(size=count)


class Stream:
    """Samples of many channels, appended block by block."""

    def __init__(self, channels: int, rate: float, noise: float = 0.03) -> None:
        self.names = NAMES[:channels]
        self.rate = rate
        self.history = SampleHistory(self.names, rate)
        self._rng = np.random.default_rng(1)
        self._noise = noise
        self.next = 0

    def append(self, count: int) -> None:
        while count > 0:
            piece = min(count, 20_000)
            column = signal(self._rng, self.next, piece, self.rate, self._noise)
            shift = 0.01 * np.arange(len(self.names))
            self.history.append(
                Block(
                    channels=self.names,
                    times=(self.next + np.arange(piece)) / self.rate,
                    values=column[:, None] + shift,
                )
            )
            self.next += piece
            count -= piece


def strip_chart(stream: Stream, window: float, *, cursors: bool = True) -> StripChart:
    """Return strip charts of all channels of a stream, with limits and cursors, on screen."""
    strips = tuple(Strip(traces=(Trace(channel=name),)) for name in stream.names)
    chart = StripChart(timed=False)
    chart.resize(*SIZE)
    chart.set_layout(StripLayout(window=window, groups=(StripGroup(strips=strips),)))
    limits = LimitBands(warning_low=-0.4, caution_low=-0.2, caution_high=0.4, warning_high=0.6)
    chart.set_limits(dict.fromkeys(stream.names, limits))
    chart.show()
    chart.set_history(stream.history)
    if cursors:
        end = stream.history.end or 0.0
        for name, share in (("cursor", 0.3), ("a", 0.5), ("b", 0.7)):
            chart.navigator.set_cursor(name, end - share * window)
    for _ in range(3):
        chart.advance()
        QApplication.processEvents()
    return chart


def median_ms(action: Callable[[], None], times: int) -> float:
    taken = []
    for _ in range(times):
        begin = time.process_time()
        action()
        taken.append(time.process_time() - begin)
    return 1e3 * statistics.median(taken)


def our_update(charts: int, window: float, rate: float, noise: float = 0.03, past: float = 1.0):
    """Return (frame, full picture) in ms, with a history of `past` windows."""
    stream = Stream(charts, rate, noise)
    stream.append(round(past * window * rate))
    chart = strip_chart(stream, window)
    due = 0.0

    def frame() -> None:
        nonlocal due
        due += rate / FRAMES_PER_SECOND
        count = int(due)
        due -= count
        stream.append(count)
        chart.advance()
        QApplication.processEvents()

    def full() -> None:
        chart.refresh()
        QApplication.processEvents()

    for _ in range(10):
        frame()
    # The mean, since values and axes have their turn in some of the frames only.
    begin = time.process_time()
    for _ in range(120):
        # The values are written ten times a second, as on a screen.
        time.sleep(0.002)
        frame()
    per_frame = (time.process_time() - begin) / 120 * 1e3
    per_full = median_ms(full, 7)
    chart.close()
    chart.deleteLater()
    QApplication.processEvents()
    stream.history.close()
    return per_frame, per_full


def their_update(charts: int, window: float, rate: float, *, downsample: bool, times: int) -> float:
    """Return what pyqtgraph takes for a frame in which every curve gets its whole history, ms."""
    rng = np.random.default_rng(1)
    count = round(window * rate)
    extra = round(rate / FRAMES_PER_SECOND) + 1
    x = np.arange(count + extra * (times + 2)) / rate
    y = np.column_stack(
        [signal(rng, 0, x.size, rate, 0.03) + 0.01 * number for number in range(charts)]
    ).T.copy()
    widget = pyqtgraph.GraphicsLayoutWidget()
    widget.resize(*SIZE)
    curves = []
    for number in range(charts):
        plot = widget.addPlot(row=number, col=0)
        plot.showGrid(x=True, y=True, alpha=0.2)
        plot.setYRange(-0.2, 0.2 + 0.01 * number)
        plot.setMouseEnabled(False, False)
        curve = plot.plot(pen="w")
        if downsample:
            curve.setDownsampling(auto=True, method="peak")
            curve.setClipToView(True)
        curves.append(curve)
    widget.show()
    QApplication.processEvents()
    frame = 0

    def update() -> None:
        nonlocal frame
        begin = frame * extra
        for curve, row in zip(curves, y, strict=True):
            curve.setData(x[begin : begin + count], row[begin : begin + count])
        frame += 1
        QApplication.processEvents()

    update()
    taken = median_ms(update, times)
    widget.close()
    widget.deleteLater()
    QApplication.processEvents()
    gc.collect()
    return taken


def against_pyqtgraph(quick: bool) -> None:
    """Compare (a): a screen update of ours against pyqtgraph's, side by side."""
    print("\n(a) one screen update, ms of processor time; ratio to ours in brackets")
    print(f"{'charts  window   rate':24}{'ours':>8}{'anew':>8}{'setData':>18}{'peak':>18}")
    cases = [(n, w, r) for n in (16, 32) for w in (60.0, 600.0) for r in (100.0, 1000.0)]
    if quick:
        cases = [cases[0], (32, 60.0, 1000.0), cases[-1]]
    for charts, window, rate in cases:
        frame, full = our_update(charts, window, rate)
        heavy = charts * window * rate > 5e6
        whole = their_update(charts, window, rate, downsample=False, times=2 if heavy else 5)
        peak = their_update(charts, window, rate, downsample=True, times=5)
        print(
            f"{charts:6}{window:6.0f} s{rate:6.0f} Hz  {frame:8.2f}{full:8.1f}"
            f"{whole:9.0f} ({whole / frame:5.0f}x){peak:9.1f} ({peak / frame:5.0f}x)",
            flush=True,
        )
    print("ours: a frame while streaming. anew: everything from nothing, as after a zoom.")


def what_it_depends_on() -> None:
    print("\n    32 charts, 60 s window, 1 kHz: a frame, ms of processor time")
    for text, noise, past in (
        ("1 min of history, smooth", 0.0, 1.0),
        ("1 min of history, noise", 0.2, 1.0),
        ("10 min of history, smooth", 0.0, 10.0),
        ("10 min of history, noise", 0.2, 10.0),
    ):
        frame, full = our_update(32, 60.0, 1000.0, noise, past)
        print(f"    {text:28}{frame:8.2f}   anew {full:6.1f}", flush=True)


def in_real_time(seconds: float, tick: Callable[[], None]) -> tuple[float, int]:
    """Call `tick` from a precise Qt timer; return processor time over wall time, and how often."""
    calls = 0

    def call() -> None:
        nonlocal calls
        calls += 1
        tick()

    loop = QEventLoop()
    timer = QTimer()
    timer.setTimerType(Qt.TimerType.PreciseTimer)
    timer.timeout.connect(call)
    QTimer.singleShot(round(1000 * seconds), loop.quit)
    used, started = time.process_time(), time.perf_counter()
    timer.start(1000 // FRAMES_PER_SECOND)
    loop.exec()
    timer.stop()
    wall = time.perf_counter() - started
    return (time.process_time() - used) / wall, calls


def streaming(chart: StripChart, stream: Stream, seconds: float) -> tuple[float, float, float]:
    feeding = 0.0
    begin, started = stream.next, time.perf_counter()

    def tick() -> None:
        nonlocal feeding
        before = time.process_time()
        due = begin + int((time.perf_counter() - started) * stream.rate)
        stream.append(due - stream.next)
        feeding += time.process_time() - before
        chart.advance()

    share, updates = in_real_time(seconds, tick)
    return share - feeding / seconds, feeding / seconds, updates / seconds


def share_of_a_core(seconds: float, runs: int) -> None:
    """(b) 60 updates a second in real time: processor time of the process over wall time.

    Counted is all that the charts, Qt and the timer take; not counted is making and storing the
    samples, which is told beside. An update takes in a sixtieth of a second of all 32 channels
    and paints it: grid, limits, three cursors with their columns of values, current values,
    clock, axes. The timer of Qt knows whole milliseconds only: 16, so 62 updates a second. The same
    loop with nothing to do stands beside each run, since the clock of a shared processor wanders.
    """
    print("\n(b) 32 charts, 1 kHz, 10 min of history, grid, limits, cursor, A and B, 60 updates/s")
    print("    % of a core       charts   empty loop   ratio   making samples   updates/s    load")
    stream = Stream(32, 1000.0)
    stream.append(600_000)
    for window in (60.0, 600.0):
        shares, ratios = [], []
        for _ in range(runs):
            empty, _calls = in_real_time(0.25 * seconds, lambda: None)
            chart = strip_chart(stream, window)
            share, feeding, rate = streaming(chart, stream, seconds)
            chart.close()
            chart.deleteLater()
            QApplication.processEvents()
            shares.append(share)
            ratios.append(share / empty)
            print(
                f"    {window:4.0f} s window {100 * share:9.1f}{100 * empty:13.2f}{ratios[-1]:8.0f}"
                f"{100 * feeding:17.1f}{rate:12.0f}{load():>8}",
                flush=True,
            )
        print(
            f"    {window:4.0f} s window: median {100 * statistics.median(shares):.1f} % of a core "
            f"(goal 15 %), {statistics.median(ratios):.0f} times the empty loop"
        )
    stream.history.close()


def load() -> str:
    return f"{os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "-"


def memory_over_an_hour(minutes: int) -> None:
    """(e) An hour at 100 Hz and 40 channels, a frame every simulated quarter of a second."""
    print(f"\n(e) memory over {minutes} simulated minutes, 100 Hz, 40 channels, 16 charts in sight")
    stream = Stream(40, 100.0)
    stream.append(6000)
    shown = Stream(16, 100.0)
    shown.history.close()
    shown.history = stream.history
    chart = strip_chart(shown, 60.0, cursors=False)
    settled = None
    for minute in range(1, minutes + 1):
        for _ in range(240):
            stream.append(25)
            chart.advance()
            QApplication.processEvents()
        used = anonymous_memory()
        if used is None:
            print("    this system does not tell; nothing measured")
            break
        if minute == 3:
            settled = used
        if minute in (3, minutes) or minute % 15 == 0:
            print(f"    after {minute:3} min {used:7.1f} MB", flush=True)
    if settled is not None and used is not None:
        print(f"    growth since the third minute: {used - settled:+.1f} MB")
    chart.close()
    stream.history.close()


def main(*arguments: str) -> None:
    quick = "--quick" in arguments
    application = QApplication.instance() or QApplication([])
    pyqtgraph.setConfigOptions(antialias=False)
    memory_over_an_hour(10 if quick else 60)
    against_pyqtgraph(quick)
    what_it_depends_on()
    share_of_a_core(4.0 if quick else 8.0, 1 if quick else 5)
    application.processEvents()


if __name__ == "__main__":
    main(*sys.argv[1:])
