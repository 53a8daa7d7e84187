"""The virtual aircraft flown by a process of its own, over a real link."""

from __future__ import annotations

import socket
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from gsapp.foundation import LinkError


def free_port() -> int:
    """Return a UDP port of this machine that nobody listens on."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


class AircraftProcess:
    """``gsapp fly`` in the background; its words go to ``virtual-aircraft.log``.

    Parameters
    ----------
    folder : Path
        Where the log of its words goes.
    port : int
        UDP port of this machine that it sends to.
    plan : str
        Flight plan; empty takes the default one.
    seed : int
        Same seed, same flight.
    speed : float
        Times real time.
    hidden : sequence of str
        Effects, ``ID[:PARAM=VALUE,..]``.
    thin : bool
        For a 57,600-baud radio.

    Raises
    ------
    LinkError
        If the process cannot be started.
    """

    def __init__(
        self,
        folder: Path,
        port: int,
        *,
        plan: str = "",
        seed: int = 0,
        speed: float = 1.0,
        hidden: Sequence[str] = (),
        thin: bool = False,
    ) -> None:
        command = [
            sys.executable, "-m", "gsapp.cli", "fly",
            "--to", f"udpout:127.0.0.1:{port}",
            "--seed", str(seed),
            "--speed", f"{speed:g}",
        ]  # fmt: skip
        if plan:
            command += ["--plan", plan]
        if thin:
            command.append("--thin")
        for effect in hidden:
            command += ["--hide", effect]
        self._words = folder / "virtual-aircraft.log"
        self._told = False
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with self._words.open("wb") as log:
                self._process = subprocess.Popen(
                    command,
                    cwd=folder,
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.DEVNULL,
                    stderr=log,
                    start_new_session=sys.platform != "win32",
                )
        except OSError as error:
            raise LinkError(
                f"the virtual aircraft cannot be started ({error.strerror}); see {self._words}"
            ) from error

    def flying(self) -> bool:
        """Return whether it still flies."""
        return self._process.poll() is None

    def complaint(self) -> str:
        """Return, once, why it ended if it failed; empty otherwise."""
        code = self._process.poll()
        if code in (None, 0) or self._told:
            return ""
        self._told = True
        lines = self._words.read_text(encoding="utf-8", errors="replace").strip().splitlines()
        why = lines[-1] if lines else f"code {code}"
        return f"The virtual aircraft ended: {why}"

    def stop(self) -> None:
        """End the flight."""
        if self._process.poll() is None:
            self._told = True
            self._process.terminate()
            try:
                self._process.wait(timeout=5.0)
            except subprocess.TimeoutExpired:
                self._process.kill()
