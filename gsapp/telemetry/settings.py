"""Settings of recording, of links and of fetching logs over them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True, kw_only=True)
class TelemetrySettings:
    """Engineering choices; times in s."""

    read_timeout: float = 0.2  # Wait for data of a source.
    check_interval: float = 0.05  # Interval of all other work.
    flush_pause: float = 0.02  # Pause of a stream after which what is left of it is written.
    status_interval: float = 0.5  # Interval at which the state is written for others to read.
    sync_interval: float = 1.0  # Interval at which what was written is forced to the disk.
    retry_interval: float = 0.5  # Interval at which what failed is tried again.
    folder_interval: float = 0.5  # Interval at which the folder is checked.
    heartbeat_interval: float = 1.0  # Interval of heartbeats of the ground station.
    low_disk_time: float = 1800.0  # Time left on the disk from which a warning is given ...
    low_disk_bytes: int = 200_000_000  # ... and bytes left.
    max_streams: int = 64  # Senders told apart.
    max_unsent: int = 64  # Frames that wait to be sent; more are dropped and asked again.
    unsent_time: float = 5.0  # For which dropped frames are reported.
    final_sending_time: float = 0.5  # Wait for what is being sent at the end.
    start_timeout: float = 20.0  # Time in which a recorder must have started.
    poll_interval: float = 0.02  # Interval at which a recorder is looked for.
    settled_us: int = 1_500_000  # After it, a recorder without state has a full disk.
    max_kept_bytes: int = 4 << 20  # Of a file kept in memory: settings and marks.
    owner_check_interval: float = 1.0  # Of the process that a record is made for.
    status_wait: float = 0.2  # For a status that is being read, on Windows.

    # Links.
    test_read_timeout: float = 0.1  # Wait for data in the test of a link.
    diagnosed_bytes: int = 4096  # Newest bytes of a link that are diagnosed ...
    min_diagnosed_bytes: int = 64  # ... if there are so many.
    min_printable_share: float = 0.95  # Share of printable bytes from which they are text.
    max_replayed_pause: float = 10.0  # Longest pause of a record that is replayed.
    connect_timeout: float = 2.0  # Wait for a TCP connection.
    max_clients: int = 8  # Clients of a TCP server.
    max_peers: int = 8  # Peers of a UDP socket ...
    peer_timeout: float = 30.0  # ... that were heard within this time.

    # Sharing what is received.
    share_interval: float = 0.02  # Interval at which clients are served.
    max_unshared: int = 4096  # Batches that wait for it.
    client_send_buffer: int = 65_536  # Of the system, for a TCP client.
    max_client_bytes: int = 262_144  # That wait for a TCP client before it is disconnected.
    hello_time: float = 0.3  # In which a client that copies the flight says so.
    proof_time: float = 5.0  # In which it proves that it has the key.
    copy_timeout: float = 5.0  # Silence after which the copy of a flight connects again.
    max_files_bytes: int = 1 << 20  # Of all files with which a flight is read, as they are sent.
    note_rate: float = 1.0  # Notes per second that another computer may send in the long run ...
    note_burst: int = 20  # ... and at once.
    max_note_length: int = 500  # Letters of a note of another computer.
    max_note_block: int = 8192  # Bytes of one that is sent.
    max_author_length: int = 40  # Letters of the name of that computer.

    # Fetching a log.
    fetch_interval: float = 0.02  # Interval at which answers are looked for.
    progress_interval: float = 0.25  # Interval at which progress is shown.
    save_interval: float = 2.0  # Interval at which what came is written to the disk.
    clock_unset: int = 946_684_800  # Logs from before 2000: clock not set.
    list_retry: float = 1.5  # Time after which the list of logs is asked for again.
    listen_time: float = 3.0  # For a heartbeat, which says whom to ask.
    min_window: int = 64 * 90  # Bytes asked for at a time: at least 64 messages of 90 bytes ...
    max_window: int = 4096 * 90  # ... and at most 4096 messages of 90 bytes ...
    window_time: float = 2.0  # ... what the link carries in this time in between.
    round_trip: float = 0.15  # Least cost of asking: may be sent twice meanwhile.
    min_measured_bytes: int = min_window // 2  # Of an answer that tells the pace of the link.
    first_silence: float = 1.5  # Until a piece is asked for again, before the first came ...
    silent_pieces: int = 20  # ... later: so many intervals between pieces, but ...
    min_silence: float = 0.25  # ... at least ...
    max_silence: float = 2.0  # ... and at most so long.
    fetch_timeout: float = 30.0  # Silence after which a download is given up.
    rate_window: float = 3.0  # Time over which the rate is averaged.
    max_cut_off: int = 5  # Early ends of a log after which its announced size is not believed.


TELEMETRY: Final = TelemetrySettings()
