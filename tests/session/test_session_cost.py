"""What a window asks for many times a second costs no work on files."""

from pathlib import Path
from typing import Any

import pytest

import gsapp.flight.read_settings
from calibration import load_certificates
from gsapp.decoding.framing import Framer
from gsapp.flight.folder import FlightFolder
from gsapp.flight.raw_files import RawWriter
from gsapp.session import UNLIMITED_SPEED, Session
from gsapp.session.replay_runner import run_replay

START_US = 1_700_000_000_000_000


def test_certificates_that_the_map_names_are_read_once(
    tmp_path: Path, box: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "flight"
    FlightFolder.create(folder)
    writer, framer = RawWriter(folder), Framer()
    for k in range(400):
        writer.append(START_US + 10_000 * k, framer.feed(b"".join(box.tick(k))))
    writer.close()
    read: list[object] = []

    def counted(name: Any) -> Any:
        read.append(name)
        return load_certificates(name)

    monkeypatch.setattr(gsapp.flight.read_settings, "load_certificates", counted)
    session = Session.replay(folder, channel_map="b777", speed=UNLIMITED_SPEED)
    run_replay(session)
    told = [session.snapshot().calibration for _ in range(5)]
    assert read == ["b777"]
    assert set(told) == {tuple(sorted(load_certificates("b777")))}
    session.close()
