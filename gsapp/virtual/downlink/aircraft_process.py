"""The virtual aircraft, in the air or on the ground, in a process of its own over a real link."""

from __future__ import annotations

import contextlib
import os
import socket
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from gsapp.foundation import LinkError
from gsapp.foundation.process_control import module_command, start_detached_process
from gsapp.foundation.settings import command_arguments
from gsapp.virtual.downlink.flight_settings import FlightSettings


def find_free_udp_port() -> int:
    """Return a UDP port of this machine that nobody listens on."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


class BackgroundCommand:
    """A command of this program in the background, which works in a folder.

    Its words go to the log `words` there; `title` says who it is, for messages. One that `listens`
    hears what is written to it, and ends when nobody can write any more. Raise LinkError if the
    process cannot be started.
    """

    def __init__(
        self,
        title: str,
        arguments: Sequence[str],
        folder: Path,
        words: str,
        *,
        listens: bool = False,
    ) -> None:
        self._title = title
        self._words = folder / words
        self._told = False
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with self._words.open("wb") as log:
                self._process = start_detached_process(
                    module_command("gsapp.cli", *arguments),
                    log,
                    folder=folder,
                    listens=listens,
                )
        except OSError as error:
            raise LinkError(
                f"{title} cannot be started ({error.strerror}); see {self._words}"
            ) from error

    def is_running(self) -> bool:
        return self._process.poll() is None

    def take_error(self) -> str:
        """Return, once, why it ended if it failed; empty otherwise."""
        code = self._process.poll()
        if code in (None, 0) or self._told:
            return ""
        self._told = True
        lines = self._words.read_text(encoding="utf-8", errors="replace").strip().splitlines()
        why = lines[-1] if lines else f"code {code}"
        return f"{self._title[0].upper()}{self._title[1:]} ended: {why}"

    def send_line(self, line: str) -> bool:
        """Write it a line to obey; return whether it could hear."""
        stream = self._process.stdin
        if stream is None:
            return False
        data = line.encode() + b"\n"
        try:
            return stream.write(data) == len(data)
        except (OSError, ValueError):
            return False

    def stop(self) -> None:
        if self._process.poll() is None:
            self._told = True
            self._process.terminate()
            try:
                self._process.wait(timeout=5.0)
            except subprocess.TimeoutExpired:
                self._process.kill()
        if self._process.stdin is not None:
            with contextlib.suppress(OSError):
                self._process.stdin.close()


def fly_command(port: int, settings: FlightSettings, speed: float = 1.0) -> list[str]:
    """Return the arguments of ``gsapp`` that send to a UDP port of this machine."""
    link = f"udpout:127.0.0.1:{port}"
    return ["fly", "--to", link, "--speed", f"{speed:g}", *command_arguments(settings)]


class AircraftProcess(BackgroundCommand):
    """``gsapp fly`` in the background; its words go to ``virtual-aircraft.log`` in the folder.

    It sends to a UDP port of this machine, `speed` times real time. Raise LinkError if the process
    cannot be started.
    """

    def __init__(
        self, folder: Path, port: int, settings: FlightSettings, *, speed: float = 1.0
    ) -> None:
        command = fly_command(port, settings, speed)
        super().__init__("the virtual aircraft", command, folder, "virtual-aircraft.log")


class BenchProcess(BackgroundCommand):
    """``gsapp fly --bench`` in the background; its words go to ``virtual-bench.log`` in the folder.

    It obeys the lines of `gsapp.virtual.downlink.commanded_downlinks.BENCH_HELP`, and ends with the
    program that started it. It sends to a UDP port of this machine, `speed` times real time. Same
    seed, same aircraft; what is wrong with it is ``CHANNEL:KIND``. Raise LinkError if the process
    cannot be started.
    """

    def __init__(
        self,
        folder: Path,
        port: int,
        *,
        seed: int = 0,
        faults: Sequence[str] = (),
        speed: float = 1.0,
    ) -> None:
        command = [
            *fly_command(port, FlightSettings(seed=seed, faults=tuple(faults)), speed),
            "--bench", "--control", "-",
        ]  # fmt: skip
        super().__init__("the virtual bench", command, folder, "virtual-bench.log", listens=True)

    def set_angle(self, channel: str, angle: float) -> bool:
        return self.send_line(f"{channel} {angle:.10g}")


class TrainingProcess(BackgroundCommand):
    """``gsapp fly --sticks`` in the background; its words go to ``virtual-training.log``.

    It obeys the lines of `gsapp.virtual.downlink.commanded_downlinks.TRAINING_HELP`, and ends with
    the program that started it. Nothing here waits: what it cannot hear now is lost, and said so.
    It sends to a UDP port of this machine. Same seed and same sticks, same flight; `turbulence` is
    the standard deviation of the gusts, m/s. Raise LinkError if the process cannot be started.
    """

    def __init__(self, folder: Path, port: int, *, seed: int, turbulence: float) -> None:
        settings = FlightSettings(seed=seed, turbulence=turbulence, position=True, airborne=True)
        command = [*fly_command(port, settings), "--sticks"]
        super().__init__(
            "the virtual aircraft", command, folder, "virtual-training.log", listens=True
        )
        stream = self._process.stdin
        # Windows can do that since Python 3.12.
        if stream is not None and (sys.platform != "win32" or sys.version_info >= (3, 12)):
            # A window must not stand still because an aircraft does.
            os.set_blocking(stream.fileno(), False)

    def send_sticks(self, pitch: float, roll: float, yaw: float) -> bool:
        """Say where the keys push; to be said at least every second, moved or not.

        -1 to 1 of the chosen size; pulled, right, right are positive; 0 lets go. Return whether it
        could hear.
        """
        return self.send_line(f"sticks {pitch:.4g} {roll:.4g} {yaw:.4g}")

    def take_over(self) -> bool:
        """Take the aircraft; return whether it could hear. It says "You have it" over the link."""
        return self.send_line("take")

    def hand_over(self) -> bool:
        return self.send_line("give")

    def land(self) -> bool:
        return self.send_line("land")

    def set_stick_size(self, share: float) -> bool:
        """Choose how far a key pushes, as a share of full stick; return whether it could hear."""
        return self.send_line(f"size {share:.4g}")

    def set_rate_switch(self, *, high: bool) -> bool:
        return self.send_line(f"rate {'high' if high else 'low'}")

    def move_lever(self, axis: str, by: float) -> bool:
        """Move the ``throttle``, or the trim lever of an axis, by a share of its travel.

        Positive is more throttle, nose up, right. Return whether it could hear.
        """
        return self.send_line(f"click {axis} {by:.4g}")
