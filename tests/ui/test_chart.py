"""The charts beside the strips: what is drawn is seen whole."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPointF
from pytestqt.qtbot import QtBot

from ui.gap.chart import Chart, Curve
from ui.look import Look


@pytest.mark.parametrize(("scale", "width"), [(100, 280), (100, 700), (200, 560), (200, 900)])
def test_points_at_the_ends_are_not_cut(qtbot: QtBot, scale: int, width: int) -> None:
    look = Look(scale=scale)
    chart = Chart(look, "Points off the curve")
    qtbot.addWidget(chart)
    chart.resize(width, 3 * scale)
    points = Curve(
        x=np.array([0.4, 2.5, 4.7]), y=np.array([-1.0, 0.0, 1.0]), color="blue", points=True,
        symbol="t",
    )  # fmt: skip
    with qtbot.waitExposed(chart):
        chart.show()
    chart.draw([points], title="Points", bottom="Volts", left="Off [deg]")
    qtbot.wait(50)

    box = chart.plot.getPlotItem().getViewBox()
    inside = box.mapToScene(box.rect()).boundingRect()
    half = look.px(11) / 2
    for x, y in zip(points.x, points.y, strict=True):
        at = box.mapViewToScene(QPointF(x, y))
        assert inside.left() + half <= at.x() <= inside.right() - half
        assert inside.top() + half <= at.y() <= inside.bottom() - half
