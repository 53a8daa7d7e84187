"""``gsapp fly --bench``: a process that sends over a real link and does what it is told."""

import io
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from gsapp.cli.main import app
from gsapp.decoding.channel_map import load_channel_map
from gsapp.decoding.decoder import Decoder
from gsapp.decoding.framing import Framer
from gsapp.flight.raw_files.record_files import RawRecord
from gsapp.foundation import FlightError, LinkError
from gsapp.quantities import Block
from gsapp.telemetry.clock import HostClock
from gsapp.virtual.bench import VirtualBench
from gsapp.virtual.downlink.aircraft_process import BenchProcess, find_free_udp_port
from gsapp.virtual.downlink.bench_downlink import (
    BenchDownlink,
    StdinConsole,
    UdpConsole,
    execute_bench_command,
)
from gsapp.virtual.downlink.downlink_transmitter import DownlinkTransmitter

PATIENCE = 60.0


class Ground:
    """A port that the box sends to, and the ordinary road behind it."""

    def __init__(self) -> None:
        self.port = find_free_udp_port()
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", self.port))
        self._socket.settimeout(PATIENCE)
        self._framer = Framer()
        self._decoder = Decoder(load_channel_map("b777"))
        self.texts: list[str] = []

    def samples(self) -> Iterator[Block]:
        until = time.monotonic() + PATIENCE
        while time.monotonic() < until:
            data = self._socket.recv(65536)
            frames = [f for f in self._framer.feed(data) if getattr(f, "known", False)]
            stamp = time.time_ns() // 1000
            records = [RawRecord(stamp_us=stamp, kind="frame", data=frame.data) for frame in frames]
            yield from self._decoder.feed(records)

    def until(self, channel: str, volts: float, tolerance: float) -> float:
        last = np.nan
        for block in self.samples():
            if channel in block and len(block):
                last = float(np.nanmean(block[channel]))
                if abs(last - volts) < tolerance:
                    return last
        raise AssertionError(f"{channel} stood at {last:.3f} V, not at {volts:.3f} V")

    def close(self) -> None:
        self._socket.close()


@pytest.fixture
def ground() -> Iterator[Ground]:
    made = Ground()
    yield made
    made.close()


def test_a_process_is_told_what_to_do_and_ends_with_who_started_it(
    ground: Ground, tmp_path: Path
) -> None:
    seed = 12
    # It works in a flight's folder, which holds a folder called as a part of the program is.
    (tmp_path / "calibration").mkdir()
    bench = BenchProcess(tmp_path, ground.port, seed=seed, faults=["alpha:dead"], speed=8.0)
    try:
        truth = VirtualBench(seed).potentiometers["rudder"]
        assert bench.send_line("rudder 15")
        supply = ground.until("excitation", 4.9, 0.08)
        ground.until("rudder_volts", float(truth.volts(15.0 - truth.play / 2, supply)), 0.02)
        assert bench.set_angle("rudder", -10.0)
        ground.until("rudder_volts", float(truth.volts(-10.0 + truth.play / 2, supply)), 0.02)
        assert bench.is_running()
        assert bench.take_error() == ""
    finally:
        bench.stop()
    assert not bench.is_running()
    assert not bench.send_line("rudder 0")
    assert bench.take_error() == "", "asked to end, it has nothing to complain of"
    assert "to 15 deg" in (tmp_path / "virtual-bench.log").read_text()


def test_the_end_of_what_is_typed_ends_it(tmp_path: Path) -> None:
    process = subprocess.Popen(
        [sys.executable, "-m", "gsapp.cli", "fly", "--bench", "--control", "-", "--thin",
         "--to", f"udpout:127.0.0.1:{find_free_udp_port()}", "--fault", "q:noisy"],
        stdin=subprocess.PIPE, stderr=subprocess.PIPE, cwd=tmp_path,
    )  # fmt: skip
    _, words = process.communicate(b"help\nwhere rudder\nfoo\n", timeout=PATIENCE)
    assert process.returncode == 0
    assert b"lie POSITION" in words
    assert b"rudder is at" in words
    assert b"'foo' is unknown" in words


def test_lines_over_a_port_are_obeyed_and_answered(ground: Ground) -> None:
    """A real link for the volts, a real port for the words; several lines in one datagram."""
    from gsapp.cli._virtual_flight import open_link

    port = find_free_udp_port()
    clock = HostClock()
    bench = VirtualBench(2)
    control = UdpConsole(f"udpin:127.0.0.1:{port}", clock=clock)
    downlink = BenchDownlink(bench, control, thin=False, unix_us=clock.now_us())

    def run() -> None:
        with open_link(f"udpout:127.0.0.1:{ground.port}", clock, 10.0) as line:
            DownlinkTransmitter(downlink, line, clock=clock, speed=10.0).transmit()

    sender = threading.Thread(target=run)
    sender.start()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as crew:
        crew.settimeout(PATIENCE)
        crew.sendto(b"pitot covered\nelevator_left 10 deg\nelevator_left ten", ("127.0.0.1", port))
        answers = [crew.recv(4096).decode() for _ in range(3)]
    truth = bench.potentiometers["elevator_left"]
    ground.until("elevator_left_volts", float(truth.volts(10.0 - truth.play / 2, 4.9)), 0.06)
    downlink.stop()
    sender.join(PATIENCE)
    control.close()
    assert answers[0] == "pitot covered\n"
    assert answers[1].startswith("elevator_left goes")
    assert "'ten'" in answers[2]
    assert not sender.is_alive()


def test_every_line_of_the_help_is_obeyed() -> None:
    bench = VirtualBench(3)
    assert execute_bench_command(bench, "rudder -5 deg").startswith("rudder goes")
    assert execute_bench_command(bench, "alpha 3 hold").startswith("alpha goes")
    assert execute_bench_command(bench, "release") == "release"
    assert execute_bench_command(bench, "lie x_up").startswith("lies x_up in 3.0 s")
    assert execute_bench_command(bench, "turn p 45").startswith("turns 45 deg")
    assert execute_bench_command(bench, "turn r 360 9").endswith("s")
    bench.step(40.0)
    assert bench.up_direction == pytest.approx((0.0, 0.0, -1.0), abs=0.1), (
        "laid for the turn about z"
    )
    for what in ("covered", "open", "blow"):
        assert execute_bench_command(bench, f"pitot {what}") == f"pitot {what}"
    assert execute_bench_command(bench, "where rudder").startswith("rudder is at -")
    assert "release" in execute_bench_command(bench, "help")
    assert execute_bench_command(bench, "   ") == ""


@pytest.mark.parametrize(
    "line", ["elevator 10", "rudder", "rudder x", "rudder nan", "lie down", "turn p", "turn x 45",
             "pitot", "where", "where q", "rudder 10 20", "turn p 45 0"],
)  # fmt: skip
def test_what_is_not_understood_is_said(line: str) -> None:
    bench = VirtualBench(3)
    before = {name: bench.target_angle(name) for name in bench.potentiometers}
    with pytest.raises(FlightError):
        execute_bench_command(bench, line)
    assert {name: bench.target_angle(name) for name in bench.potentiometers} == before
    assert not bench.busy


def test_what_was_typed_before_the_end_is_heard() -> None:
    control = StdinConsole(io.StringIO("release\n"), lambda _: None)
    until = time.monotonic() + PATIENCE
    lines = []
    while not control.ended and time.monotonic() < until:
        lines += control.read_lines()
        time.sleep(0.01)
    assert control.ended
    assert lines == ["release\n"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--bench"], "give --to LINK"),
        (["--bench", "--to", "udpout:127.0.0.1:1", "--out", "x"], "no --out"),
        (["--bench", "--to", "udpout:127.0.0.1:1", "--truth", "x"], "leave out --truth"),
        (
            ["--bench", "--to", "udpout:127.0.0.1:1", "--plan", "short", "--turbulence", "1"],
            "leave out --plan, --turbulence",
        ),
        (["--out", "x", "--control", "-"], "belongs to --bench"),
    ],
)
def test_a_call_that_makes_no_sense_is_refused(arguments: list[str], words: str) -> None:
    result = CliRunner().invoke(app, ["fly", *arguments])
    assert result.exit_code == 2
    assert words in " ".join(result.output.replace("│", " ").split())


def test_a_port_for_words_is_a_port() -> None:
    with pytest.raises(LinkError, match="controlled"):
        UdpConsole("tcp:127.0.0.1:1234", clock=HostClock())
    port = find_free_udp_port()
    taken = UdpConsole(f"udpin:127.0.0.1:{port}", clock=HostClock())
    with pytest.raises(LinkError):
        UdpConsole(f"udpin:127.0.0.1:{port}", clock=HostClock())
    taken.close()
