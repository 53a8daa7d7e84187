"""The virtual aircraft on the ground: its truth, hands and faults, and the process it runs in."""

import io
import itertools
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

from calibration import CalibrationPoint
from calibration.adc import ADC_RESOLUTION
from calibration.curve_selection import fit_calibration
from gsapp.cli.main import app
from gsapp.decoding.channel_map import load_channel_map
from gsapp.decoding.decoder import Decoder
from gsapp.decoding.framing import Framer
from gsapp.flight.raw_files.record_files import RawRecord
from gsapp.foundation import FlightError, LinkError
from gsapp.quantities import Block
from gsapp.telemetry.clock import HostClock
from gsapp.virtual.bench import POTENTIOMETERS, BenchFault, VirtualBench, parse_bench_fault
from gsapp.virtual.downlink.aircraft_process import BenchProcess, find_free_udp_port
from gsapp.virtual.downlink.commanded_downlinks import (
    BenchDownlink,
    StdinConsole,
    UdpConsole,
    execute_bench_command,
)
from gsapp.virtual.downlink.downlink_transmitter import DownlinkTransmitter
from gsapp.virtual.instruments import DAQ_CHANNELS

SETTINGS = (-20.0, -10.0, 0.0, 10.0, 20.0)


def readings(bench: VirtualBench, channel: str) -> list[CalibrationPoint]:
    points = []
    bench.step(bench.set_angle(channel, -24.0))
    for direction, settings in (("up", SETTINGS), ("down", SETTINGS[::-1])):
        if direction == "down":
            bench.step(bench.set_angle(channel, 24.0))
        for angle in settings:
            bench.step(bench.set_angle(channel, angle) + 0.3)
            block = bench.step(1.0)
            volts = float(np.mean(block[f"{channel}_volts"] / block["excitation"]) * 5.0)
            points.append(CalibrationPoint(volts=volts, value=angle, direction=direction))
    return points


@pytest.mark.parametrize(("channel", "seed"), [("elevator_left", 1), ("beta", 2), ("rudder", 3)])
def test_points_taken_by_hand_give_the_true_curve(channel: str, seed: int) -> None:
    bench = VirtualBench(seed)
    points = readings(bench, channel)
    fit = fit_calibration(points, degree=3).fit
    potentiometer = bench.potentiometers[channel]
    angles = np.linspace(-20.0, 20.0, 41)
    found = np.polynomial.Polynomial(fit.coefficients)(potentiometer.volts(angles))
    assert np.max(np.abs(found - angles)) < 0.25
    up, down = (
        np.mean([p.volts for p in points if p.direction == direction])
        for direction in ("up", "down")
    )
    # Going up, the shaft lags behind.
    play = (down - up) / potentiometer.slope
    assert play == pytest.approx(potentiometer.play, abs=0.1)


def test_a_hand_takes_its_time_and_comes_from_one_side() -> None:
    bench = VirtualBench(4)
    bench.step(bench.set_angle("aileron_left", -15.0))
    seconds = bench.set_angle("aileron_left", 15.0)
    assert 1.5 < seconds < 4.0
    assert abs(bench.target_angle("aileron_left") - 15.0) < 0.4
    way = []
    for _ in range(round(100 * seconds)):
        bench.advance(1)
        way.append(bench.angle("aileron_left"))
    assert bench.busy is False
    assert max(way) < bench.target_angle("aileron_left") + 0.15
    assert bench.angle("aileron_left") == pytest.approx(
        bench.target_angle("aileron_left"), abs=0.01
    )
    bench.step(bench.set_angle("aileron_left", 10.0, hold=True))
    rest = []
    for _ in range(200):
        bench.advance(1)
        rest.append(bench.angle("aileron_left"))
    assert 0.01 < np.std(rest) < 0.04
    bench.release()
    bench.advance(1)
    assert bench.angle("aileron_left") == bench.target_angle("aileron_left")
    bench.step(bench.set_angle("aileron_left", 90.0))
    assert bench.target_angle("aileron_left") == 25.0, "the stop ends it"


def test_volts_are_those_of_the_converter() -> None:
    bench = VirtualBench(6)
    before = bench.advance(100)
    bench.set_angle("rudder", 20.0)
    after = bench.advance(300)[-50:]
    np.testing.assert_array_equal(np.round(after / ADC_RESOLUTION) * ADC_RESOLUTION, after)
    assert after.min() >= 0.0
    assert after.max() <= 5.0 - ADC_RESOLUTION
    moved = np.abs(after.mean(axis=0) - before.mean(axis=0))
    assert {name for name, by in zip(DAQ_CHANNELS, moved, strict=True) if by > 0.02} == {"rudder"}
    assert np.std(before[:, DAQ_CHANNELS.index("excitation")]) < 2e-3


def test_the_supply_drifts_and_the_potentiometers_with_it() -> None:
    bench = VirtualBench(8)
    first, last = bench.step(1.0), (bench.step(45.0), bench.step(1.0))[1]
    change = {
        name: float(last[name].mean() / first[name].mean() - 1.0)
        for name in ("excitation", "elevator_right_volts", "alpha_volts")
    }
    assert abs(change["excitation"]) > 3e-4
    for name in ("elevator_right_volts", "alpha_volts"):
        assert change[name] == pytest.approx(change["excitation"], abs=1.5e-4)


def everything(bench: VirtualBench, cuts: list[int]) -> np.ndarray:
    bench.set_angle("elevator_left", 12.0)
    bench.rotate("p", 90.0)
    bench.blow()
    pieces, left = [], 1500
    for cut in itertools.cycle(cuts):
        if not left:
            return np.vstack(pieces)
        pieces.append(bench.advance(min(cut, left)))
        left -= len(pieces[-1])
    raise AssertionError


def test_cutting_changes_nothing_and_seeds_do() -> None:
    faults = [
        parse_bench_fault("elevator_left:noisy"),
        parse_bench_fault("alpha:swapped:with=beta"),
    ]
    whole = everything(VirtualBench(5, faults=faults), [1500])
    cut = everything(VirtualBench(5, faults=faults), [1, 7, 33, 100])
    np.testing.assert_array_equal(whole, cut)
    assert not np.array_equal(whole, everything(VirtualBench(6, faults=faults), [1500]))


def test_a_turn_is_what_was_asked_within_the_marks() -> None:
    bench = VirtualBench(9)
    block = bench.step(bench.rotate("q", 180.0) + 1.0)
    assert bench.up_direction[1] == pytest.approx(1.0, abs=1e-3)
    rates = (block["q_volts"] - bench.gyros.zero[1]) / bench.gyros.matrix[1, 1]
    turning = block.times > 3.5  # laid by then
    assert np.sum(rates[turning]) / 100.0 == pytest.approx(180.0, abs=1.5)
    assert np.sum(rates[~turning]) / 100.0 == pytest.approx(0.0, abs=4.0)
    rolled = (block["p_volts"] - bench.gyros.zero[0]) / bench.gyros.matrix[0, 0]
    assert abs(np.sum(rolled[~turning]) / 100.0) == pytest.approx(90.0, abs=5.0)


def swing(bench: VirtualBench, channel: str) -> dict[str, float]:
    stretches = [bench.step(bench.set_angle(channel, angle)) for angle in (-20.0, 20.0, 0.0)]
    return {
        name: float(np.ptp(np.concatenate([b[f"{name}_volts"] for b in stretches])))
        for name in POTENTIOMETERS
    }


@pytest.mark.parametrize("channel", ["elevator_right", "alpha"])
def test_faults_show_as_they_would(channel: str) -> None:
    other = "beta" if channel != "rudder" else "aileron_left"
    sound = swing(VirtualBench(3), channel)
    assert sound[channel] > 1.0
    dead = VirtualBench(3, faults=[BenchFault(channel=channel, kind="dead")])
    assert swing(dead, channel)[channel] == 0.0
    swapped = VirtualBench(3, faults=[BenchFault(channel=channel, kind="swapped", other=other)])
    found = swing(swapped, channel)
    assert found[other] > 1.0
    assert found[channel] < 0.1
    signs = []
    for faults in ([], [BenchFault(channel=channel, kind="reversed")]):
        bench = VirtualBench(3, faults=faults)
        block = bench.step(bench.set_angle(channel, 20.0))
        signs.append(np.sign(block[f"{channel}_volts"][-1] - block[f"{channel}_volts"][0]))
    assert signs[0] == -signs[1]
    clipped = VirtualBench(3, faults=[BenchFault(channel=channel, kind="clipped")])
    block = [clipped.step(clipped.set_angle(channel, a) + 0.5) for a in (-20.0, 20.0)]
    volts = np.concatenate([b[f"{channel}_volts"] for b in block])
    ends = np.count_nonzero((volts == 0.0) | (volts == 5.0 - ADC_RESOLUTION))
    assert ends > 50
    noisy = VirtualBench(3, faults=[BenchFault(channel=channel, kind="noisy")])
    assert np.std(np.diff(noisy.step(2.0)[f"{channel}_volts"])) > 0.03


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("elevator:dead", "no instrument is called 'elevator'"),
        ("rudder:loose", "'loose' is not a fault"),
        ("rudder:swapped", "needs the other channel"),
        ("rudder:swapped:with=rudder", "needs the other channel"),
        ("rudder:dead:start=3 s", "has no options"),
        ("static_pressure:reversed", "cannot be reversed"),
    ],
)
def test_a_fault_that_is_none_is_refused(text: str, words: str) -> None:
    with pytest.raises(FlightError, match=words):
        parse_bench_fault(text)


def test_what_cannot_be_done_is_refused() -> None:
    bench = VirtualBench()
    with pytest.raises(FlightError, match="manually"):
        bench.set_angle("q", 10.0)
    with pytest.raises(FlightError, match="not a turn axis"):
        bench.rotate("alpha", 10.0)
    with pytest.raises(FlightError, match="cannot take 0 s"):
        bench.rotate("p", 10.0, seconds=0.0)


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


@pytest.mark.long
def test_the_end_of_what_is_typed_ends_it(tmp_path: Path) -> None:
    process = subprocess.Popen(
        [sys.executable, "-m", "gsapp.cli", "fly", "--bench", "--control", "-", "--thin",
         "--to", f"udpout:127.0.0.1:{find_free_udp_port()}", "--fault", "q:noisy"],
        stdin=subprocess.PIPE, stderr=subprocess.PIPE, cwd=tmp_path,
    )  # fmt: skip
    _, text = process.communicate(b"help\nwhere rudder\nfoo\n", timeout=PATIENCE)
    assert process.returncode == 0
    assert b"lie POSITION" in text
    assert b"rudder is at" in text
    assert b"'foo' is unknown" in text


def test_lines_over_a_port_are_obeyed_and_answered(ground: Ground) -> None:
    """A real link for the volts, a real port for the words; several lines in one datagram."""
    from gsapp.cli.fly import open_link

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
