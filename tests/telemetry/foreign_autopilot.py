"""An autopilot that keeps logs, on pymavlink alone.

``foreign_autopilot.py PORT LOG HEARD LOSS [ATONCE]``

It behaves as ArduPilot does: one request is answered at a time, a new one takes the place of the
last. It loses a share of what it sends, and writes down the types of all that it hears.
"""

import os
import random
import sys
import time
from pathlib import Path

os.environ["MAVLINK20"] = "1"
from pymavlink import mavutil

OLD, NUMBER = 7, 8
BEGUN = 1_760_000_000


def main(port: int, log: Path, heard: Path, loss: float, at_once: int = 8) -> None:
    """Serve until killed."""
    data = log.read_bytes()
    # On Windows pymavlink takes the port that it is given for its own end as well.
    link = mavutil.mavlink_connection("udpout:127.0.0.1:0", source_system=3, source_component=1)
    link.destination_addr = ("127.0.0.1", port)
    luck = random.Random(5)
    beat = 0.0
    asked = None
    with heard.open("a") as text:
        while True:
            now = time.monotonic()
            if now >= beat:
                beat = now + 0.2
                link.mav.heartbeat_send(1, 3, 0, 0, 4)
            while (message := link.recv_match()) is not None:
                text.write(f"{message.get_type()}\n")
                text.flush()
                if message.get_type() == "LOG_REQUEST_LIST":
                    link.mav.log_entry_send(OLD, 2, NUMBER, BEGUN - 86_400, 500)
                    link.mav.log_entry_send(NUMBER, 2, NUMBER, BEGUN, len(data))
                elif message.get_type() == "LOG_REQUEST_DATA" and message.id == NUMBER:
                    asked = [message.ofs, message.ofs + message.count]
                elif message.get_type() == "LOG_REQUEST_END":
                    asked = None
            for _ in range(at_once):
                if asked is None:
                    break
                piece = data[asked[0] : min(asked[0] + 90, asked[1])]
                if luck.random() >= loss:
                    link.mav.log_data_send(NUMBER, asked[0], len(piece), piece.ljust(90, b"\0"))
                asked[0] += 90
                if asked[0] >= asked[1] or len(piece) < 90:
                    asked = None
            time.sleep(0.002)


if __name__ == "__main__":
    main(
        int(sys.argv[1]), Path(sys.argv[2]), Path(sys.argv[3]), float(sys.argv[4]),
        *map(int, sys.argv[5:]),
    )  # fmt: skip
