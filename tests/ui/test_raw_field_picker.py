"""Fields of messages on the time line of the review: listed, read in a thread, drawn and hidden."""

import numpy as np
import pytest
from pytestqt.qtbot import QtBot

from gsapp.flight import load_flight
from gsapp.session.review.traces import Traces
from tests.flight.test_raw_channels import bin_file, make_map  # noqa: F401
from ui.display_style import DisplayStyle
from ui.review.raw_field_picker import RawFieldPicker
from ui.review.timeline_painter import build_timeline_charts


@pytest.fixture
def picker(qtbot: QtBot) -> RawFieldPicker:
    made = RawFieldPicker(DisplayStyle())
    qtbot.addWidget(made)
    return made


def test_a_field_gets_a_chart_of_its_own_and_goes_again(
    picker: RawFieldPicker,
    qtbot: QtBot,
    bin_file,  # noqa: F811
    tmp_path,
) -> None:
    flight = load_flight(bin_file, channel_map=make_map(tmp_path, "ardupilot-log", "IMU.GyrY"))
    traces = Traces(flight)
    picker.show_flight(bin_file, traces)
    box = picker.fields.box
    assert box.count() == 1
    picker.list_fields()
    qtbot.waitUntil(lambda: box.findData("CTUN.NavRoll") > 0)
    with qtbot.waitSignal(picker.changed):
        picker.toggle("CTUN.NavRoll")
    assert picker.shown == ("CTUN.NavRoll",)
    charts = build_timeline_charts(traces, ("q", *picker.shown), 0.9, 1.3, 500, "US")
    assert [one.lines[0].channel for one in charts] == ["q", "CTUN.NavRoll"]
    line = charts[1].lines[0]
    assert line.values[:2] == pytest.approx([0.0, 7.0])
    assert np.diff(line.times)[0] == pytest.approx(0.0175)
    assert traces.value("CTUN.NavRoll", 1.019) == pytest.approx(7.0)
    picker.toggle("CTUN.NavRoll")
    assert picker.shown == ()
    picker.show_flight(tmp_path / "flight.csv", traces)
    assert box.count() == 1
    assert picker.isHidden()
