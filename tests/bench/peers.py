"""MAVProxy as a foreign peer: virtual aircraft -> MAVProxy -> recorder, and its reading of our log.

After landing, the on-board log is fetched through MAVProxy by this program, and by MAVProxy from
the virtual aircraft: the same bytes, and how long each took.

MAVProxy is installed for this alone, without what it asks for (a gigabyte): pymavlink and
pyserial, which are here, are all that it needs to pass messages on.
"""

import os
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from gsapp.virtual.downlink.aircraft_process import find_free_udp_port

MAVPROXY = "MAVProxy==1.8.75"


def counts(log: Path) -> Counter[str]:
    os.environ.setdefault("MAVLINK20", "1")
    from pymavlink import mavutil

    reader = mavutil.mavlink_connection(str(log))
    found: Counter[str] = Counter()
    while (message := reader.recv_match()) is not None:
        if message.get_srcSystem() == 1:
            found[message.get_type()] += 1
    return found


def install(folder: Path) -> dict[str, str]:
    subprocess.run(
        [sys.executable, "-m", "pip", "install", "-q", "--no-deps", "--target", folder, MAVPROXY],
        check=True,
    )
    return {**os.environ, "PYTHONPATH": str(folder)}


def main(*_: str) -> None:
    """Fly the short plan through MAVProxy and compare what both recorded."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        environment = install(folder / "site")
        first, second = find_free_udp_port(), find_free_udp_port()
        flight = folder / "flight"
        gsapp = [sys.executable, "-m", "gsapp.cli"]
        recorder = subprocess.Popen(
            [*gsapp, "record", f"udpin:127.0.0.1:{second}", "--out", str(flight)]
        )
        proxy = subprocess.Popen(
            [
                sys.executable, str(folder / "site/bin/mavproxy.py"),
                f"--master=udpin:127.0.0.1:{first}", f"--out=udpout:127.0.0.1:{second}",
                "--daemon", "--non-interactive", f"--state-basedir={folder}",
                f"--logfile={folder / 'proxy.tlog'}", "--streamrate=-1", "--default-modules=",
            ],
            cwd=folder, env=environment,
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        time.sleep(3.0)
        subprocess.run(
            [*gsapp, "fly", "--to", f"udpout:127.0.0.1:{first}", "--plan", "short", "--speed", "4"],
            check=True, stdout=subprocess.DEVNULL,
        )  # fmt: skip
        time.sleep(1.0)
        for process in (recorder, proxy):
            process.send_signal(signal.SIGINT)
        recorder.wait(timeout=20)
        try:
            proxy.wait(timeout=10)
        except subprocess.TimeoutExpired:
            proxy.kill()
        ours, theirs = counts(flight / "raw.tlog"), counts(folder / "proxy.tlog")
        print(f"{'message':24} {'our record':>11} {'MAVProxy':>9}")
        for name in sorted(set(ours) | set(theirs)):
            print(f"{name:24} {ours[name]:11,} {theirs[name]:9,}")
        passed_on = sum(ours.values()) / max(sum(theirs.values()), 1)
        print(f"recorded of what MAVProxy received: {100 * passed_on:.2f} %")
    with tempfile.TemporaryDirectory() as scratch:
        fetch_logs(Path(scratch))


def fetch_logs(folder: Path) -> None:
    """Fetch the log of a thin flight through MAVProxy, then let MAVProxy fetch it."""
    os.environ["GSAPP_RUNTIME_FOLDER"] = str(folder / "run")
    environment = install(folder / "site")
    first, second = find_free_udp_port(), find_free_udp_port()
    flight, box, theirs = folder / "flight", folder / "box.tlog", folder / "theirs.tlog"
    gsapp = [sys.executable, "-m", "gsapp.cli"]
    said, text = folder / "fly.txt", folder / "proxy.txt"
    with said.open("w") as aircraft_words, text.open("w") as proxy_words:
        recorder = subprocess.Popen(
            [
                *gsapp, "record", f"udpin:127.0.0.1:{second}", "--map", "b777-thin",
                "--aircraft", "b777", "--out", str(flight),
            ],
            stdout=subprocess.DEVNULL,
        )  # fmt: skip
        proxy = subprocess.Popen(
            [
                sys.executable, str(folder / "site/bin/mavproxy.py"),
                f"--master=udpin:127.0.0.1:{first}", f"--out=udpout:127.0.0.1:{second}",
                f"--state-basedir={folder}", f"--logfile={folder / 'proxy.tlog'}",
                "--streamrate=-1", "--default-modules=log",
            ],
            cwd=folder, env=environment, text=True,
            stdin=subprocess.PIPE, stdout=proxy_words, stderr=subprocess.STDOUT,
        )  # fmt: skip
        time.sleep(3.0)
        aircraft = subprocess.Popen(
            [
                *gsapp, "fly", "--to", f"udpout:127.0.0.1:{first}", "--plan", "short", "--thin",
                "--speed", "10", "--onboard", str(box),
            ],
            stdout=subprocess.DEVNULL, stderr=aircraft_words,
        )  # fmt: skip
    try:
        while "full record" not in said.read_text() and aircraft.poll() is None:
            time.sleep(0.5)
        begin = time.monotonic()
        subprocess.run(
            [*gsapp, "onboard", str(flight), "--fetch"], check=True, stdout=subprocess.DEVNULL
        )
        kept = flight / "onboard-1.tlog"
        tell_fetched("this program, aligned and in force", kept, box, begin)
        begin = time.monotonic()
        proxy.stdin.write(f"log download 1 {theirs}\n")
        proxy.stdin.flush()
        while "Finished" not in text.read_text() and time.monotonic() < begin + 180.0:
            time.sleep(0.2)
        tell_fetched("MAVProxy", theirs, box, begin)
    finally:
        proxy.kill()  # at its prompt it does not listen to less
        for process in (recorder, aircraft):
            process.terminate()
            process.wait(timeout=20)


def tell_fetched(who: str, log: Path, box: Path, begin: float) -> None:
    same = log.exists() and log.read_bytes() == box.read_bytes()
    print(
        f"on-board log of {box.stat().st_size / 1e6:.1f} MB, fetched by {who}: "
        f"{'the same bytes' if same else 'OTHER BYTES'}, {time.monotonic() - begin:.0f} s"
    )


if __name__ == "__main__":
    main()
