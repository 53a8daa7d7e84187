"""The LINK grammar: every form, and a remedy for every mistake."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gsapp.foundation import LinkError
from gsapp.telemetry.link_kinds import LinkAddress
from gsapp.telemetry.link_registry import parse_link


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("udpin:0.0.0.0:14550", LinkAddress(kind="udpin", host="0.0.0.0", port=14550)),  # noqa: S104
        ("udpin:14550", LinkAddress(kind="udpin", host="127.0.0.1", port=14550)),
        ("udpin::14550", LinkAddress(kind="udpin", host="127.0.0.1", port=14550)),
        ("udpout:field-pc:14551", LinkAddress(kind="udpout", host="field-pc", port=14551)),
        ("tcp:10.1.2.3:5760", LinkAddress(kind="tcp", host="10.1.2.3", port=5760)),
        ("tcpin:[::1]:5760", LinkAddress(kind="tcpin", host="::1", port=5760)),
        ("serial:/dev/ttyUSB0:57600", LinkAddress(kind="serial", path="/dev/ttyUSB0", baud=57600)),
        ("serial:COM3:115200", LinkAddress(kind="serial", path="COM3", baud=115200)),
        ("text:/dev/ttyACM0:9600", LinkAddress(kind="text", path="/dev/ttyACM0", baud=9600)),
        (" virtual ", LinkAddress(kind="virtual")),
    ],
)
def test_every_form_is_read(text: str, address: LinkAddress) -> None:
    assert parse_link(text) == address
    assert parse_link(str(address)) == address


def test_a_path_that_exists_is_a_flight(tmp_path: Path) -> None:
    assert parse_link(str(tmp_path)) == LinkAddress(kind="flight", path=str(tmp_path))


@pytest.mark.parametrize(
    ("text", "remedy"),
    [
        ("", "a link is missing; write udpin:HOST:PORT"),
        ("udpin", "write for example udpin:127.0.0.1:14550"),
        ("udpin:localhost", "udpin:localhost:14550"),
        ("udpin:localhost:70000", "1 to 65535, usually 14550"),
        ("tcp:a b:5760", "not a host name"),
        ("udp:localhost:14550", "did you mean 'udpi?n?o?u?t?:localhost:14550'"),
        ("seriel:/dev/ttyUSB0:57600", "did you mean 'serial:/dev/ttyUSB0:57600'"),
        ("serial:/dev/ttyUSB0", "serial:/dev/ttyUSB0:57600"),
        ("serial:/dev/ttyUSB0:1", "300 to 12000000, usually 57600"),
        ("udpin:localhost:²", "'²' is not a whole number; write for example udpin:localhost:14550"),
        ("udpin:localhost:" + "9" * 5000, "1 to 65535"),
        ("serial:/dev/ttyUSB0:5760²", "is not a whole number"),
        ("x" * 300, "; write udpin:HOST:PORT"),
        ("flights/none", "neither a link nor a flight that exists"),
    ],
)
def test_every_mistake_names_its_remedy(text: str, remedy: str) -> None:
    with pytest.raises(LinkError, match=remedy.replace("(", r"\(")):
        parse_link(text)


@given(st.text(max_size=40).filter(lambda text: "\0" not in text and not Path(text).exists()))
def test_any_text_is_a_link_or_gets_a_sentence(text: str) -> None:
    try:
        address = parse_link(text)
    except LinkError:
        return
    assert parse_link(str(address)) == address
