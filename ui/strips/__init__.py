"""Strip charts: many channels over one time axis, live and scrolled back.

    chart = StripChart()                    # looks at the history itself, 60 times a second
    chart.set_history(history)              # gsapp.session.sample_history.SampleHistory
    chart.set_layout(default_layout(history.channels))
    chart.navigator.go_to(120.0)
    chart.mark_requested.connect(marks.add)

`pixel_columns` lays bins over the absolute sample index; `raster` paints them into a ring of
pixels; `chart_raster` keeps the ring up with the history; `auto_range` and `axis_ticks` choose
axes; `chart_geometry` places everything in pixels of the screen. `chart_model` holds what is
shown; `view_navigator` and `chart_editor` change it by key and menu, `chart_mouse` by mouse;
`chart_canvas` keeps the picture and paints it with `chart_painter`; `strip_chart` is the widget.
"""

from ui.strips.chart_annotations import ChartMark, ChartSpan
from ui.strips.chart_keys import KEY_ACTIONS, KeyAction
from ui.strips.strip_chart import StripChart
from ui.strips.strip_layout import (
    Strip,
    StripGroup,
    StripLayout,
    Trace,
    default_layout,
    load_layout,
    save_layout,
)
from ui.strips.strip_view import StripView

__all__ = [
    "KEY_ACTIONS",
    "ChartMark",
    "ChartSpan",
    "KeyAction",
    "Strip",
    "StripChart",
    "StripGroup",
    "StripLayout",
    "StripView",
    "Trace",
    "default_layout",
    "load_layout",
    "save_layout",
]
