"""Which charts are shown, in which order: changes to a `StripLayout`, without Qt.

The list beside the charts is flat: headings and charts, in order. A chart belongs to the heading
above it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType

from gsapp.quantities import CHANNELS, ChannelSpec, base_id, channel
from ui.number_format import symbol_text
from ui.strips.strip_layout import Strip, StripGroup, StripLayout, Trace, default_layout
from ui.translation import QT_TR_NOOP, tr

LayoutRow = str | Strip  # A heading, or a chart.

OVERVIEW_LAYOUT = QT_TR_NOOP("Overview")

_SHIPPED_LAYOUTS: Mapping[str, tuple[tuple[str, tuple[str, ...]], ...]] = MappingProxyType(
    {
        QT_TR_NOOP("Longitudinal"): (
            (QT_TR_NOOP("Pitch"), ("de", "alpha", "q", "theta", "an", "ax")),
            (QT_TR_NOOP("Flight"), ("V", "altitude")),
        ),
        QT_TR_NOOP("Lateral"): (
            (QT_TR_NOOP("Controls"), ("da", "dr")),
            (QT_TR_NOOP("Roll and yaw"), ("beta", "p", "r", "phi", "psi", "ay")),
        ),
        QT_TR_NOOP("Engines"): (
            (QT_TR_NOOP("Engines"), ("throttle", "rpm_left", "rpm_right")),
            (QT_TR_NOOP("Flight"), ("V", "altitude", "climb_rate")),
        ),
        QT_TR_NOOP("Health"): (
            (QT_TR_NOOP("Power"), ("battery", "battery_receiver", "excitation")),
            (QT_TR_NOOP("Link"), ("link_rssi", "rc_rssi", "link_loss")),
        ),
    }
)

SHIPPED_LAYOUT_NAMES = (OVERVIEW_LAYOUT, *_SHIPPED_LAYOUTS)  # Layouts that come with the program.

_CHANNEL_ORDER = {name: index for index, name in enumerate(CHANNELS)}


def create_shipped_layout(name: str, available: Sequence[str] | None) -> StripLayout:
    """Return a layout that comes with the program, without charts that this flight lacks."""
    if name == OVERVIEW_LAYOUT or name not in _SHIPPED_LAYOUTS:
        layout = default_layout(available or None)
        return StripLayout(name=OVERVIEW_LAYOUT, window=layout.window, groups=layout.groups)
    groups = []
    for title, channels in _SHIPPED_LAYOUTS[name]:
        present = [known for known in channels if not available or known in available]
        strips = tuple(Strip(traces=(Trace(channel=known),)) for known in present)
        if strips:
            groups.append(StripGroup(name=title, strips=strips))
    return StripLayout(name=name, groups=tuple(groups))


def list_layout_rows(layout: StripLayout) -> tuple[LayoutRow, ...]:
    """Return headings and charts, in order."""
    found: list[LayoutRow] = []
    for group in layout.groups:
        if group.name or found:
            found.append(group.name)
        found.extend(group.strips)
    return tuple(found)


def build_layout(layout: StripLayout, order: Iterable[LayoutRow]) -> StripLayout:
    """Return the layout that a list of headings and charts describes."""
    groups: list[tuple[str, list[Strip]]] = []
    for row in order:
        if isinstance(row, str):
            groups.append((row, []))
        elif groups:
            groups[-1][1].append(row)
        else:
            groups.append(("", [row]))
    return StripLayout(
        name=layout.name,
        window=layout.window,
        groups=tuple(StripGroup(name=name, strips=tuple(strips)) for name, strips in groups),
    )


def row_text(row: LayoutRow) -> str:
    """Return how a row is listed."""
    if isinstance(row, str):
        return tr(row) or tr("More")
    names = tr(" and ").join(symbol_text(channel(trace.channel).symbol) for trace in row.traces)
    return f"{names}   {channel(row.channel).title}"


def move_row(order: Sequence[LayoutRow], place: int, steps: int) -> tuple[LayoutRow, ...]:
    """Return the list with one row moved up (negative) or down, held at the ends."""
    found = list(order)
    if 0 <= place < len(found):
        row = found.pop(place)
        found.insert(min(max(place + steps, 0), len(found)), row)
    return tuple(found)


def toggle_channel(layout: StripLayout, name: str, on: bool) -> StripLayout:
    """Return the layout with a channel added to the group of its kind, or taken away."""
    if on == (name in layout.channels):
        return layout
    if on:
        spec = channel(name)
        strip = Strip(traces=(Trace(channel=name),))
        groups = list(layout.groups)
        places = [index for index, group in enumerate(groups) if group.name == spec.group]
        if places:
            group = groups[places[0]]
            groups[places[0]] = StripGroup(name=group.name, strips=(*group.strips, strip))
        else:
            groups.append(StripGroup(name=spec.group, strips=(strip,)))
        return StripLayout(name=layout.name, window=layout.window, groups=tuple(groups))
    kept: list[LayoutRow] = []
    for row in list_layout_rows(layout):
        if isinstance(row, str):
            kept.append(row)
            continue
        traces = tuple(trace for trace in row.traces if trace.channel != name)
        if traces:
            kept.append(row.model_copy(update={"traces": traces}))
    return _drop_empty_groups(build_layout(layout, kept))


def _drop_empty_groups(layout: StripLayout) -> StripLayout:
    groups = tuple(group for group in layout.groups if group.strips)
    return StripLayout(name=layout.name, window=layout.window, groups=groups)


def rename_layout(layout: StripLayout, name: str, window: float | None = None) -> StripLayout:
    """Return the layout under another name, and with another time in sight."""
    return StripLayout(name=name, window=window or layout.window, groups=layout.groups)


def sort_by_vocabulary(channels: Iterable[str]) -> tuple[str, ...]:
    """Return channels in the order of the vocabulary, redundant sensors after the first."""
    return tuple(
        sorted(channels, key=lambda name: (_CHANNEL_ORDER.get(base_id(name), 10_000), name))
    )


def group_channels(available: Iterable[str]) -> dict[str, tuple[ChannelSpec, ...]]:
    """Return the channels by group, groups and channels in the order of the vocabulary."""
    groups: dict[str, list[ChannelSpec]] = {}
    for name in sort_by_vocabulary(available):
        spec = channel(name)
        groups.setdefault(spec.group, []).append(spec)
    return {name: tuple(specs) for name, specs in groups.items()}


def matches_search(spec: ChannelSpec, words: str) -> bool:
    """Return whether a channel is meant by all the words of a search."""
    text = f"{spec.id} {spec.symbol} {spec.title} {spec.group}".lower()
    return all(word in text for word in words.lower().split())
