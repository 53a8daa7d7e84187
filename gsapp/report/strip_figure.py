"""Strip charts on paper: the channels of a flight over one time axis."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from gsapp.foundation import write_atomically
from gsapp.quantities import Block, channel, from_si
from gsapp.report.palette import PRINT_PALETTE
from gsapp.report.plot_elements import format_clock_axis, label_channel, label_flight_time

if TYPE_CHECKING:
    from matplotlib.axes import Axes

INK, FAINT = PRINT_PALETTE.ink, PRINT_PALETTE.faint


def write_strip_figure(
    block: Block,
    channels: Sequence[str],
    path: Path | str,
    *,
    title: str = "",
    units: str = "US",
) -> Path:
    """Draw channels one above the other and write the picture.

    Parameters
    ----------
    block : Block
        The samples; gaps stay gaps.
    channels : sequence of str
        Ids from top to bottom; those that the block lacks are left out.
    """
    shown = [channel_id for channel_id in channels if channel_id in block]
    rows = max(len(shown), 1)
    figure = Figure(figsize=(11.0, 1.1 + 0.72 * rows), dpi=110, facecolor="white")
    axes = figure.subplots(rows, 1, sharex=True, squeeze=False)[:, 0]
    for row, channel_id in zip(axes, shown, strict=False):
        _draw_strip(row, block, channel_id, units)
    bottom = axes[-1]
    format_clock_axis(bottom)
    bottom.tick_params(axis="x", labelsize=8, colors=INK, length=3)
    label_flight_time(bottom, PRINT_PALETTE)
    if len(block):
        bottom.set_xlim(float(block.times[0]), float(block.times[-1]))
    figure.suptitle(title, x=0.01, y=0.995, ha="left", va="top", fontsize=11, color=INK)
    figure.subplots_adjust(
        left=0.17, right=0.985, top=1.0 - 0.42 / figure.get_figheight(),
        bottom=0.5 / figure.get_figheight(), hspace=0.12,
    )  # fmt: skip
    content = io.BytesIO()
    figure.savefig(content, format=Path(path).suffix.lstrip(".") or "png")
    return write_atomically(path, content.getvalue())


def _draw_strip(row: Axes, block: Block, channel_id: str, units: str) -> None:
    spec = channel(channel_id)
    unit = spec.display_unit(units)
    values = from_si(np.asarray(block[channel_id]), unit, spec.quantity)
    row.plot(block.times, values, color=PRINT_PALETTE.channel(channel_id), linewidth=0.8)
    row.grid(True, color=FAINT, linewidth=0.4)
    row.yaxis.set_major_locator(MaxNLocator(nbins=3, min_n_ticks=2))
    row.tick_params(axis="y", labelsize=7, colors=INK, length=2)
    row.tick_params(axis="x", length=0)
    for side in ("top", "right"):
        row.spines[side].set_visible(False)
    for side in ("left", "bottom"):
        row.spines[side].set_color(FAINT)
    label_channel(row, channel_id, units, PRINT_PALETTE)
