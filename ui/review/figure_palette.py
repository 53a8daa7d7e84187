"""The report's pictures in the colors of the window."""

from __future__ import annotations

from gsapp.report.palette import Palette
from ui.display_style import mix_colors
from ui.theme import Theme, luminance

_PRINT_LINE_WIDTH = 1.8
"""Width of a trace of the window at which a picture's lines are as heavy as on paper."""
_BAND, _BAND_ON_DARK = 0.14, 0.28
"""How far bands lie from the background to the color of measured traces."""


def window_palette(theme: Theme) -> Palette:
    """Return the colors in which pictures are drawn in a theme."""
    dark = luminance(theme.plot) < luminance(theme.text)
    return Palette(
        background=theme.plot,
        ink=theme.text,
        secondary_ink=theme.muted,
        faint=mix_colors(theme.plot, theme.axis, 0.55).name(),
        previous=theme.previous,
        band=mix_colors(theme.plot, theme.traces["blue"], _BAND_ON_DARK if dark else _BAND).name(),
        excluded=theme.previous,
        traces=theme.traces,
        line_scale=theme.line_width / _PRINT_LINE_WIDTH,
    )
