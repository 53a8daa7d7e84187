"""Numbers as the crew reads them: times, sizes, rates, values with their units.

Nothing here knows of Qt. A value that is missing is a dash, never the last one left standing.
"""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Iterable

from gsapp.quantities import ChannelSpec, from_si
from gsapp.quantities import clock_text as clock_text
from gsapp.quantities import symbol_text as symbol_text
from gsapp.quantities import unit_text as unit_text
from ui.translation import QT_TR_NOOP, tr

DASH = "–"
MINUS = "−"


def number_text(value: float, decimals: int) -> str:
    """Return a number with a true minus sign; a dash where it is missing."""
    if not math.isfinite(value):
        return DASH
    text = f"{value:.{decimals}f}"
    if text.startswith("-"):
        # Minus nothing is nothing.
        return text[1:] if float(text) == 0.0 else MINUS + text[1:]
    return text


def value_with_std_text(value: float, std: float) -> str:
    """Return ``−0.338 ± 0.012``: two digits of the standard deviation, and the value to match."""
    if not math.isfinite(value):
        return DASH
    if not math.isfinite(std) or std <= 0.0:
        return number_text(value, _decimals(abs(value), 3))
    decimals = _decimals(std, 2)
    return f"{number_text(value, decimals)} ± {number_text(std, decimals)}"


def value_to_std_digits(value: float, std: float) -> str:
    """Return a number with the digits that its standard deviation earns."""
    if not math.isfinite(value):
        return DASH
    known = math.isfinite(std) and std > 0.0
    return number_text(value, _decimals(std, 2) if known else _decimals(abs(value), 3))


def _decimals(size: float, digits: int) -> int:
    if not math.isfinite(size) or size <= 0.0:
        return 3
    return min(max(digits - 1 - math.floor(math.log10(size)), 0), 9)


def parse_number(text: str) -> float | None:
    """Return a number as people write it, with a true minus sign or a decimal comma; or None."""
    try:
        value = float(text.strip().replace(MINUS, "-").replace(",", "."))
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def channel_value_text(
    spec: ChannelSpec, value: float | None, system: str, *, unit: bool = True
) -> str:
    """Return an SI value in the unit of the screen, with the digits that its sensor earns.

    `value`: SI; None or NaN is missing.
    """
    shown = spec.display_unit(system)
    if value is None or not math.isfinite(value):
        return DASH
    number = number_text(from_si(float(value), shown, spec.quantity), spec.decimals(shown))
    return f"{number} {unit_text(shown)}".rstrip() if unit else number


def parse_clock(text: str) -> float | None:
    """Return seconds for ``247``, ``247.3``, ``4:07.3`` or ``1:04:07``; None for anything else."""
    parts = text.strip().replace(",", ".").split(":")
    if not 1 <= len(parts) <= 3:
        return None
    seconds = 0.0
    for index, part in enumerate(parts):
        last = index == len(parts) - 1
        pattern = r"\d+(\.\d*)?" if last else r"\d+"
        if not re.fullmatch(pattern, part.strip()):
            return None
        number = float(part)
        if index > 0 and number >= 60.0:
            return None
        seconds = seconds * 60.0 + number
    return seconds


def duration_text(seconds: float | None) -> str:
    """Return a length of time in words: ``0.3 s``, ``42 s``, ``5 min``, ``2.5 h``."""
    if seconds is None or not math.isfinite(seconds):
        return DASH
    seconds = abs(seconds)
    if seconds < 9.95:
        return f"{seconds:.1f} s"
    if seconds < 99.5:
        return f"{seconds:.0f} s"
    if seconds < 5700:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.1f} h" if seconds < 36000 else f"{seconds / 3600:.0f} h"


def elapsed_text(seconds: float | None) -> str:
    """Return how long something took, to a tenth: ``3.2 s``, from a minute on ``04:07.3``."""
    if seconds is None or not math.isfinite(seconds):
        return DASH
    return f"{seconds:.1f} s" if abs(seconds) < 59.95 else clock_text(seconds, decimals=1)


def time_span_text(seconds: float) -> str:
    """Return a length of time as it is chosen: ``0.5 s``, ``30 s``, ``2 min``, ``1 h``."""
    for size, unit in ((3600, "h"), (60, "min")):
        if seconds >= size:
            return f"{seconds / size:g} {unit}"
    return f"{seconds:g} s"


def bytes_text(count: float | None) -> str:
    """Return a size with three digits: ``950 B``, ``12.4 kB``, ``3.02 MB``, ``118 GB``."""
    if count is None or not math.isfinite(count):
        return DASH
    if count < 999.5:
        return f"{count:.0f} B"
    for unit in ("kB", "MB", "GB", "TB"):
        count /= 1000.0
        if count < 9.995:
            return f"{count:.2f} {unit}"
        if count < 99.95:
            return f"{count:.1f} {unit}"
        if count < 999.5:
            return f"{count:.0f} {unit}"
    return f"{count:.0f} TB"


def percent_text(ratio: float | None) -> str:
    """Return a share: ``0 %``, ``0.4 %``, ``12 %``."""
    if ratio is None or not math.isfinite(ratio):
        return DASH
    share = 100.0 * ratio
    if 0.0 < share < 0.05:
        return "< 0.1 %"
    return f"{share:.1f} %" if 0.0 < share < 9.95 else f"{share:.0f} %"


_PLURALS = {
    QT_TR_NOOP("alarm"): QT_TR_NOOP("alarms"), QT_TR_NOOP("ALARM"): QT_TR_NOOP("ALARMS"),
    QT_TR_NOOP("byte"): QT_TR_NOOP("bytes"), QT_TR_NOOP("card"): QT_TR_NOOP("cards"),
    QT_TR_NOOP("certificate"): QT_TR_NOOP("certificates"),
    QT_TR_NOOP("chart"): QT_TR_NOOP("charts"), QT_TR_NOOP("client"): QT_TR_NOOP("clients"),
    QT_TR_NOOP("derivative"): QT_TR_NOOP("derivatives"), QT_TR_NOOP("doubt"): QT_TR_NOOP("doubts"),
    QT_TR_NOOP("flight"): QT_TR_NOOP("flights"), QT_TR_NOOP("frame"): QT_TR_NOOP("frames"),
    QT_TR_NOOP("input"): QT_TR_NOOP("inputs"), QT_TR_NOOP("item"): QT_TR_NOOP("items"),
    QT_TR_NOOP("line"): QT_TR_NOOP("lines"), QT_TR_NOOP("maneuver"): QT_TR_NOOP("maneuvers"),
    QT_TR_NOOP("message"): QT_TR_NOOP("messages"),
    QT_TR_NOOP("outlying maneuver"): QT_TR_NOOP("outlying maneuvers"),
    QT_TR_NOOP("remark"): QT_TR_NOOP("remarks"), QT_TR_NOOP("run"): QT_TR_NOOP("runs"),
    QT_TR_NOOP("time"): QT_TR_NOOP("times"), QT_TR_NOOP("value"): QT_TR_NOOP("values"),
}  # fmt: skip


def count_text(number: int, noun: str) -> str:
    """Return ``1 alarm``, ``3 alarms``, ``no alarms``."""
    return f"{number or tr('no')} {tr(noun if number == 1 else _PLURALS[noun])}"


_NAME_AT_START = re.compile(r"\S*[\d_/\\]|\S*\.\w|[b-z]\b")
"""How a file, a folder, a channel is named at the beginning of a sentence: as no word is."""


def join_sentences(remarks: Iterable[str]) -> str:
    """Return remarks as sentences, one after the other, as a banner says them.

    The name of a file or of a channel stays as it is written.
    """
    said = [words.rstrip(".") for words in remarks if words]
    return " ".join(
        f"{words}." if _NAME_AT_START.match(words) else f"{words[:1].upper()}{words[1:]}."
        for words in said
    )


_RESERVED_NAMES = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)\s*(\..*)?", re.IGNORECASE)
"""Names that Windows gives to devices, in every folder and with any ending."""


def sanitize_file_name(text: str) -> str:
    """Return a name as a file or folder can have it on every system; perhaps an empty one."""
    name = re.sub(r'[<>:"/\\|?*\x00-\x1f]+', "-", text).strip(" .")
    device = _RESERVED_NAMES.fullmatch(name)
    return f"{device[1]}-{device[2] or ''}" if device else name


_MAC_SYMBOLS = {"Alt": "⌥", "Shift": "⇧", "Ctrl": "⌘"}
"""In the order in which they are written there."""


def floor_percent(share: float) -> int:
    """Return a share in percent, so that 100 is said of the whole alone."""
    return math.floor(100.0 * share)


def plain_shortcut_text(keys: str, platform: str = sys.platform) -> str:
    """Return a shortcut of letters and figures as the system writes it: ``Ctrl+L`` is ⌘L on a Mac.

    As `ui.commands.shortcut_text` does, which needs Qt.
    """
    if platform != "darwin":
        return keys
    *held, key = keys.split("+")
    return "".join(sign for name, sign in _MAC_SYMBOLS.items() if name in held) + key
