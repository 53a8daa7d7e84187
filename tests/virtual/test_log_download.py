"""The on-board log can be fetched over the link, in pieces, and is never erased over the air."""

from pathlib import Path

import numpy as np
import pytest

from gsapp.virtual.downlink.onboard_log import LOG_DATA_BYTES, LOG_ID, LogServer
from gsapp.virtual.downlink.onboard_messages import dialect


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = tmp_path / "onboard.tlog"
    path.write_bytes(np.random.default_rng(3).bytes(1234))
    return path


def test_the_list_names_one_log_with_its_size(log: Path) -> None:
    server = LogServer(log, started=1_700_000_000)
    server.handle_request(dialect.MAVLink_log_request_list_message(1, 1, 0, 0xFFFF))
    (entry,) = server.pending_responses(1000)
    assert (entry.id, entry.num_logs, entry.last_log_num) == (LOG_ID, 1, LOG_ID)
    assert entry.size == 1234
    assert entry.time_utc == 1_700_000_000


def test_the_whole_log_comes_within_the_budget_of_each_turn(log: Path) -> None:
    server = LogServer(log, started=0)
    server.handle_request(dialect.MAVLink_log_request_data_message(1, 1, LOG_ID, 0, 0xFFFFFFFF))
    pieces, turns = {}, 0
    while answers := list(server.pending_responses(300)):
        turns += 1
        assert len(answers) <= 3
        for answer in answers:
            pieces[answer.ofs] = (answer.count, bytes(answer.data[: answer.count]))
    assert turns > 4
    assert b"".join(data for _, (_, data) in sorted(pieces.items())) == log.read_bytes()
    assert pieces[max(pieces)][0] < LOG_DATA_BYTES


def test_a_lost_piece_can_be_asked_for_again(log: Path) -> None:
    server = LogServer(log, started=0)
    server.handle_request(dialect.MAVLink_log_request_data_message(1, 1, LOG_ID, 180, 180))
    answers = list(server.pending_responses(10_000))
    assert [answer.ofs for answer in answers] == [180, 270]
    assert b"".join(bytes(a.data[: a.count]) for a in answers) == log.read_bytes()[180:360]


def test_erase_is_not_obeyed_and_end_stops(log: Path) -> None:
    server = LogServer(log, started=0)
    before = log.read_bytes()
    server.handle_request(dialect.MAVLink_log_erase_message(1, 1))
    assert list(server.pending_responses(1000)) == []
    assert log.read_bytes() == before
    server.handle_request(dialect.MAVLink_log_request_data_message(1, 1, LOG_ID, 0, 0xFFFFFFFF))
    list(server.pending_responses(200))
    server.handle_request(dialect.MAVLink_log_request_end_message(1, 1))
    assert list(server.pending_responses(1000)) == []


def test_a_request_beyond_the_end_gets_the_end_mark(log: Path) -> None:
    server = LogServer(log, started=0)
    server.handle_request(dialect.MAVLink_log_request_data_message(1, 1, LOG_ID, 5000, 90))
    (answer,) = server.pending_responses(1000)
    assert answer.count == 0
