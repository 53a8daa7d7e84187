"""An autopilot that signs, on pymavlink alone: ``foreign_signer.py PORT HEARD SECONDS KEY``.

It sends attitudes and heartbeats signed with a key in hexadecimal digits, none where that is
empty, and answers the list of logs. It takes only what is signed with its key, and writes down
the types of that, or ``REFUSED``. SECONDS is by how much its clock is ahead.
"""

import os
import sys
import time
from pathlib import Path

os.environ["MAVLINK20"] = "1"
from pymavlink import mavutil
from pymavlink.dialects.v20 import all as names


def main(port: int, heard: str, ahead: float, key: str) -> None:
    link = mavutil.mavlink_connection(
        f"udpout:127.0.0.1:{port}", source_system=3, source_component=1, dialect="all"
    )
    if key:
        time_stamp = int((time.time() + ahead - 1_420_070_400) * 100_000)
        link.setup_signing(
            bytes.fromhex(key),
            sign_outgoing=True,
            allow_unsigned_callback=None,
            initial_timestamp=time_stamp,
        )
    with Path(heard).open("a") as text:
        for k in range(100_000):
            link.mav.attitude_send(1000 + 20 * k, 0.1, 0, 0, 0, 0, 0)
            if k % 10 == 0:
                link.mav.heartbeat_send(1, 3, 0, 0, 4)
            while (message := link.recv_msg()) is not None:
                refused = message.get_type() == "BAD_DATA"
                text.write("REFUSED\n" if refused else f"{message.get_type()}\n")
                text.flush()
            time.sleep(0.02)


if __name__ == "__main__":
    assert names.WIRE_PROTOCOL_VERSION == "2.0"
    main(int(sys.argv[1]), sys.argv[2], float(sys.argv[3]), sys.argv[4])
