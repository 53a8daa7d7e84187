"""Show: before and after, on maneuvers that neither naming nor fitting has seen."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from PySide6.QtGui import QAction, QResizeEvent

from gsapp.quantities import trace_color
from ui.flight.controls import ActionButton
from ui.gap.bars import ChannelBars, Waterfall
from ui.gap.chapters import ChapterView
from ui.gap.chart import FLIGHT_TIME, Band, Chart, Curve
from ui.gap.parts import Choice, Lines, Pair, button_row
from ui.gap.phrases import channel_text, closed_text, joined, maneuver_text
from ui.gap.pictures import bar_pairs, gap_lines, overlay_picture, waterfall
from ui.gap.selection import step_names
from ui.look import Look
from ui.pages import label

_ALL_NUMBERS = 620
_NOISE = 2


class ShowView(ChapterView):
    """Overlay, what is left of it, bars per channel, waterfall and numbers."""

    def __init__(self, look: Look, actions: Mapping[str, QAction]) -> None:
        super().__init__(look)
        pair = Pair(look, (7, 5))
        self.column.addWidget(pair, 1)
        self.maneuver = Choice(look, "Maneuver", letters=32)
        self.channel = Choice(look, "Channel", letters=16)
        self.buttons = {
            "gap_report": ActionButton(actions["gap_report"], "Write the report…", look),
            "gap_save": ActionButton(actions["gap_save"], "Save the model…", look),
        }
        pair.left.addWidget(button_row(look, self.maneuver, self.channel))
        self.overlay = Chart(look, "Measured and computed")
        pair.left.addWidget(self.overlay, 3)
        self.rest = Chart(look, "Measured minus computed", high=132)
        pair.left.addWidget(self.rest, 2)
        self.closed = label("", "heading", wrap=True)
        pair.right.addWidget(self.closed)
        self.on = label("", "muted", wrap=True)
        pair.right.addWidget(self.on)
        pair.right.addWidget(
            label("Gap per channel: gray before, color after", "strong", wrap=True)
        )
        self.bars = ChannelBars(look)
        pair.right.addWidget(self.bars)
        pair.right.addWidget(label("All channels, step by step", "strong"))
        self.falls = Waterfall(look)
        pair.right.addWidget(self.falls)
        pair.right.addWidget(button_row(look, *self.buttons.values()))
        pair.right.addStretch(1)
        self.numbers_heading = label("", "heading", wrap=True)
        self.column.addWidget(self.numbers_heading)
        self.numbers = Lines(
            look, "Numbers of each channel",
            ("Channel", "RMS", "Noise", "Of range", "Theil", "In 3 floors"),
            stretch=0, widths={1: 140, 2: 68, 3: 104, 4: 120, 5: 112},
            right=frozenset({1, 2, 3, 4, 5}), least=5, most=12,
        )  # fmt: skip
        self.column.addWidget(self.numbers)
        self.maneuver.box.currentIndexChanged.connect(
            lambda _index: self.selected.emit(replace(self.selection, maneuver=self.maneuver.value))
        )
        self.channel.box.currentIndexChanged.connect(
            lambda _index: self.selected.emit(replace(self.selection, channel=self.channel.value))
        )

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Leave out the noise where there is no room for all numbers; the bars show it."""
        super().resizeEvent(event)
        narrow = self.width() < self.look.px(_ALL_NUMBERS)
        self.numbers.setColumnHidden(_NOISE, narrow)

    def begin(self) -> None:
        """Begin on the maneuvers."""
        self.maneuver.box.setFocus()

    def refresh(self) -> None:
        """Draw everything."""
        answer, selection = self.answer, self.selection
        if answer is None:
            return
        found = answer.discrepancy
        self.maneuver.show_choices(
            [(view.id, maneuver_text(answer, view)) for view in found.maneuvers], selection.maneuver
        )
        self.channel.show_choices(
            [(name, channel_text(name)) for name in found.channels], selection.channel
        )
        self._draw_overlay()
        gap = found.gap
        self.closed.setText(f"{closed_text(gap.closed, gap.closed_std)}.")
        kept = "No maneuver could be kept out: fly one more of each kind."
        if gap.on:
            kept = f"Judged on maneuvers {joined(gap.on)}, kept out of naming and fitting."
        self.on.setText(f"From the baseline to the last effect. {kept}")
        self.bars.show_pairs(bar_pairs(answer, selection.step))
        self.falls.show_falls(waterfall(answer, selection.step))
        lines = gap_lines(answer, self.look.units)
        self.numbers.setMaximumWidth(self.look.px(760))
        self.numbers.show_lines(lines)
        self.numbers.setVisible(bool(lines))
        self.numbers_heading.setText("Baseline → last effect, on the maneuvers kept out")
        self.numbers_heading.setVisible(bool(lines))

    def _draw_overlay(self) -> None:
        answer, selection = self.answer, self.selection
        picture = overlay_picture(answer, selection, self.look.units) if answer else None
        for chart in (self.overlay, self.rest):
            chart.setVisible(picture is not None)
        if answer is None or picture is None:
            return
        name = step_names(answer)[selection.step]
        unit = f", {picture.unit}" if picture.unit else ""
        left = f"{picture.axis.split(', ')[0]}{unit}"
        color = trace_color(selection.channel)
        curves = [
            Curve(x=picture.times, y=picture.before, color="previous", name="baseline",
                  dashed=True),
            Curve(x=picture.times, y=picture.measured, color=color, name="measured"),
        ]  # fmt: skip
        rests = [
            Curve(x=picture.times, y=picture.measured - picture.before, color="previous",
                  name="baseline", dashed=True)
        ]  # fmt: skip
        if selection.step:
            curves.append(
                Curve(x=picture.times, y=picture.after, color="text", name=name, dashed=True)
            )
            rests.append(
                Curve(x=picture.times, y=picture.measured - picture.after, color=color,
                      name=name)
            )  # fmt: skip
        self.overlay.draw(curves, title=picture.title, bottom=FLIGHT_TIME, left=left)
        self.rest.draw(
            rests,
            [Band(low=-picture.floor, high=picture.floor, name="noise floor")],
            title=f"Measured minus computed: {picture.axis}",
            bottom=FLIGHT_TIME,
            left=left,
        )
