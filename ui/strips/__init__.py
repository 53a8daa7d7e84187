"""Strip charts: many channels over one time axis, live and scrolled back.

    chart = StripChart()                    # looks at the history itself, 60 times a second
    chart.set_history(history)              # gsapp.session.sample_history.SampleHistory, or the
    like chart.set_layout(default_layout(history.channels))
    chart.set_theme(DARK); chart.set_scale(1.5); chart.set_units("SI")
    chart.mark_requested.connect(marks.add)

What it is given
    ``set_history(history)``, ``set_layout(layout)``, ``set_theme(theme)``,
    ``set_units("US" | "SI")``, ``set_scale(1.0 ... 2.5)``, ``set_spans(spans)``,
    ``set_marks(marks)``, ``set_limits({channel: limits})``, ``set_sources({channel: source})``,
    ``set_patience({channel: seconds})``, ``set_now(flight_time)``,
    ``set_recording(True | False)``, ``set_newest(words)``, ``set_empty(words)``.
    `gsapp.session.limits.LimitBands` serve as limits; a source has ``kind`` (``measured``,
    ``estimated``, ``derived``) and ``calibrated``.
    ``set_now`` is what lets values grow stale when the link is lost; without it only the
    newest sample tells the time.

A frame
    A timer of its own drains what came. A window that polls its feed on a timer makes the widget
    with ``timed=False`` and calls ``advance()`` after each poll: no sample waits for a second
    timer. Nothing is signaled per sample; a hidden widget does nothing and catches up when shown.

What the user does
    ``perform(action)`` does what a key does; `KEY_ACTIONS` lists all actions with their keys for
    menus and help. As methods: ``toggle_pause()``, ``go_live()``, ``go_to(time)``,
    ``go_to_start()``, ``scroll(seconds)``, ``zoom(steps, anchor)``, ``set_window(seconds)``,
    ``set_cursor("cursor" | "a" | "b", time | None)``, ``toggle_cursor()``,
    ``step_cursor(columns)``, ``clear()``, ``toggle_enlarged()``, ``request_mark()``.
    The wheel zooms about the pointer, with Shift it scrolls; a click chooses a chart and sets the
    cursor, a double click enlarges the chart.

What it tells
    Signals ``mark_requested(time)``, ``cursor_moved(name, time | None)``,
    ``layout_changed(layout)``, ``view_changed()``; ``view`` (a `StripView`: ``paused``,
    ``seconds_behind``, ``columns``, ``cursors``, ``selected``), ``strip_layout``,
    ``readings(chart)``, ``value_at(channel, time)``, ``cursor_texts(chart)``.

Inside
    `columns` lays bins over the absolute sample index; `raster` paints them into a ring of
    pixels; `picture` keeps the ring up with the history; `ranges` and `ticks` choose axes;
    `geometry` places everything in pixels of the screen; `drawing` writes what is text;
    `exposed` tells which parts a repaint is about; `widget` is the one part that handles events.
    Only the last three know Qt.
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
