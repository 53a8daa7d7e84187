"""The menu of a strip chart: what the right button of the mouse offers."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path

from PySide6.QtGui import QAction, QGuiApplication
from PySide6.QtWidgets import QMenu, QWidget

from gsapp.foundation import FlightError
from ui.dialogs.save_dialog import ask_save_file
from ui.flight.flight_view_state import FlightViewState
from ui.number_format import channel_value_text, clock_text
from ui.strips.strip_chart import StripChart
from ui.translation import tr

_ZOOM_MARGIN = 1.2
"""Time in sight beside a maneuver that is zoomed to, times its length."""


def create_chart_menu(
    charts: StripChart,
    picture: FlightViewState,
    actions: Mapping[str, QAction],
    time: float | None,
    units: str,
    parent: QWidget,
) -> QMenu:
    """Return the menu of the selected chart.

    Parameters
    ----------
    time : float or None
        Flight time under the pointer, s.
    """
    menu = QMenu(parent)
    chart = charts.model.selected_chart
    if chart is not None:
        if time is not None:
            for spec in chart.specs:
                text = channel_value_text(spec, charts.model.value_at(spec.id, time), units)
                menu.addAction(
                    tr("Copy {title} {text}").format(title=spec.title, text=text),
                    partial(_copy_text, text),
                )
        menu.addAction(tr("Hide {title}").format(title=chart.specs[0].title), charts.editor.hide)
        menu.addAction(actions["chart_enlarge"])
        menu.addSeparator()
        auto = menu.addAction(tr("Autoscale"), lambda: charts.editor.set_range(None))
        auto.setEnabled(chart.strip.range != "auto")
        menu.addAction(actions["type_range"])
        menu.addAction(actions["type_limits"])
        menu.addSeparator()
    if time is not None:
        at = clock_text(time, decimals=1)
        menu.addAction(tr("Mark {at}").format(at=at), lambda: charts.mark_requested.emit(time))
        menu.addAction(
            tr("Set A at {at}").format(at=at), lambda: charts.navigator.set_cursor("a", time)
        )
        menu.addAction(
            tr("Set B at {at}").format(at=at), lambda: charts.navigator.set_cursor("b", time)
        )
        for span in picture.spans:
            if span.stop is not None and span.start <= time <= span.stop:
                menu.addAction(
                    tr("Zoom to {label}").format(label=span.label),
                    partial(zoom_to, charts, span.start, span.stop),
                )
    a, b = charts.view.cursors.get("a"), charts.view.cursors.get("b")
    if a is not None and b is not None and a != b:
        menu.addAction(tr("Zoom to A and B"), lambda: zoom_to(charts, min(a, b), max(a, b)))
    menu.addAction(actions["chart_clear"])
    menu.addSeparator()
    menu.addAction(tr("Copy picture"), lambda: QGuiApplication.clipboard().setPixmap(charts.grab()))
    menu.addAction(tr("Save as…"), lambda: export_chart_image(charts))
    return menu


def _copy_text(text: str) -> None:
    QGuiApplication.clipboard().setText(text)


def zoom_to(charts: StripChart, start: float, stop: float) -> None:
    """Show a stretch of the flight (s) with some room on either side."""
    charts.navigator.set_window(_ZOOM_MARGIN * (stop - start))
    charts.navigator.go_to((start + stop) / 2.0)


def export_chart_image(charts: StripChart) -> None:
    """Write the charts as they are on screen into a file."""
    picture = charts.grab()  # before the dialog stands over it
    path = ask_save_file(
        charts, tr("Save the charts"), Path.home() / "charts.png", tr("Picture (*.png)")
    )
    if path is not None and not picture.save(str(path)):
        raise FlightError(tr("{path} cannot be written; choose another folder").format(path=path))
