"""The raw files of a flight: written by the recorder, tailed by windows, read by everyone.

========================  ==================================================================
``raw.tlog``              per frame: 8-byte big-endian host microseconds, the frame
``raw.txt``               per line: microseconds, tab, the line, line feed
``residue.bin``           per piece: 8-byte big-endian microseconds, 8-byte big-endian offset
                          in the stream, 4-byte big-endian length, the bytes
``senders.txt``           where the sender changes: microseconds, tab, network address, tab,
                          state of the signature, line feed; missing where neither is known
========================  ==================================================================

All of them only ever grow. A reader meets a torn record at the end as "not there yet" and damage in
the middle as a gap that it reports and steps over.

What arrives at one time is written as one batch under one stamp, the residue first and the frames
last, and stamps rise from batch to batch. Readers take them in the opposite order. So a tail of a
growing folder yields the very sequence that a reader of the finished one gets. The frames of a
batch have one sender; it is written before them and read after them.
"""

from gsapp.flight.file_names import FRAMES_FILE, LINES_FILE, RAW_FILES, RESIDUE_FILE
from gsapp.flight.raw_files.raw_reader import RawTail, read_nonempty_tlog, read_tlog
from gsapp.flight.raw_files.raw_writer import RawWriter
from gsapp.flight.raw_files.record_files import STAMP_STRUCT, FrameFile, RawDamage

__all__ = [
    "FRAMES_FILE",
    "LINES_FILE",
    "RAW_FILES",
    "RESIDUE_FILE",
    "STAMP_STRUCT",
    "FrameFile",
    "RawDamage",
    "RawTail",
    "RawWriter",
    "read_nonempty_tlog",
    "read_tlog",
]
