"""The link in detail, in words and numbers."""

from gsapp.decoding.dialect import dialect
from gsapp.decoding.health import LinkHealth, LinkReport
from ui.dialogs.mavlink_inspector import (
    LINK_COLUMN_TITLES,
    build_link_message_rows,
    describe_senders,
)

START_US = 1_700_000_000_000_000


def heard(*frames: tuple[int, int]) -> LinkReport:
    health, module = LinkHealth(), dialect()
    for index, (component, sequence) in enumerate(frames):
        packer = module.MAVLink(None, srcSystem=1, srcComponent=component)
        packer.seq = sequence
        message = module.MAVLink_attitude_message(100 * sequence, 1, 2, 3, 4, 5, 6)
        health.feed([(START_US + 100_000 * index, "frame", bytes(message.pack(packer)))])
    return health.report()


def test_one_sender_is_told_once_and_its_messages_by_their_name_alone() -> None:
    report = heard(*((1, number) for number in (0, 1, 2, 3, 4, 5, 6, 6, 9)))
    assert ["20 % lost" in one for one in describe_senders(report)] == [True]
    (row,) = build_link_message_rows(report)
    assert dict(zip(LINK_COLUMN_TITLES, row.cells, strict=True)) == {
        "Message": "ATTITUDE", "Frames": "8", "Per s": "10", "Age": "0.0 s", "Delay": "0 ms",
    }  # fmt: skip


def test_of_several_senders_each_message_says_whose_it_is() -> None:
    report = heard(*((component, number) for number in range(20) for component in (1, 154)))
    assert [row.cells[0] for row in build_link_message_rows(report)] == [
        "1/1 ATTITUDE",
        "1/154 ATTITUDE",
    ]
    assert len(describe_senders(report)) == 2
    assert build_link_message_rows(heard()) == ()
    assert describe_senders(heard()) == ()
