"""The calibration wizard in the window: a crew at a virtual bench, by keys, pixels read."""

import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from datetime import UTC, datetime
from itertools import product
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QPolygonF
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLabel, QPushButton
from pytestqt.qtbot import QtBot

import ui.main_window
import ui.preflight.wizard_controller
from calibration import certificate_paths, load_certificates
from calibration.plan import load_calibration_plan
from gsapp.flight.folder import FlightFolder
from gsapp.quantities import from_si
from gsapp.telemetry.recorder_control import find_recorders
from gsapp.virtual.bench import BenchFault, VirtualBench
from tests.ui.bench_kit import BenchWindow, leave_only, work_through
from tests.ui.window_kit import activate, count, open_window, pixels, until
from ui.display_limits import DISPLAY
from ui.flight_controller import FlightController
from ui.preflight.aircraft_figures import ViewDirection
from ui.preflight.surface_motion_view import SurfaceCloseup, SurfaceFigure, SurfaceKind
from ui.preflight.wizard_page import WizardPage
from ui.preflight.wizard_panels import WizardSummaryPanel

KEY = Qt.Key
Open = Callable[..., BenchWindow]


@pytest.fixture
def at_bench(tmp_path: Path, qapp: QApplication) -> Iterator[Open]:
    """Return a maker of windows at a bench, all on the same settings."""
    made: list[BenchWindow] = []

    def make(
        *channels: str, seed: int = 3, fault: BenchFault | None = None, bench: object = None
    ) -> BenchWindow:
        if channels:
            leave_only(tmp_path, *channels)
        known = bench if isinstance(bench, VirtualBench) else None
        faults = () if fault is None else (fault,)
        made.append(BenchWindow(tmp_path, known or VirtualBench(seed, faults=faults)))
        return made[-1]

    yield make
    for window in made:
        window.leave()


def begin(window: BenchWindow, key: Qt.Key = KEY.Key_Space) -> None:
    window.press(key)
    window.controller.pass_time(4.0)


# Surfaces


def test_a_crew_calibrates_by_one_key_and_checks_it(at_bench: Open) -> None:
    """From the first page to certificates in force; the surface is then read within bounds."""
    window = at_bench("elevator_left", "rudder")
    begin(window)
    assert window.view.phase == "sign"
    work_through(window, "rudder")
    # Ten points and a sign cost the press that began it.
    assert window.keys == 1
    assert window.controller.complaints == []
    assert window.voice.tones.count("taken") >= 12
    assert any("Left elevator" in text for text in window.voice.words)

    made = load_certificates(window.store.current.calibration)
    certificate = made["elevator_left"]
    potentiometer = window.bench.potentiometers["elevator_left"]
    assert len(certificate.points) == 10
    angles = np.linspace(-19.0, 19.0, 77)
    for side in (-0.5, 0.5):
        volts = potentiometer.volts(angles + side * potentiometer.play, 4.9)
        found = from_si(certificate.evaluate(volts, 4.9), "deg", "angle")
        bound = from_si(certificate.uncertainty(volts, 4.9), "deg", "angle")
        assert np.mean(np.abs(found - angles) <= bound) >= 0.95
    assert certificate.hysteresis == pytest.approx(potentiometer.play, abs=0.1)
    # What was not calibrated counts as before: the next flight still has its throttle.
    assert made["throttle"].who == "shipped example"

    # Skipping takes out of force, everywhere.
    window.press(KEY.Key_X)
    assert window.page.action_bar.isHidden()
    window.type("wire broken")
    window.press(KEY.Key_Return)
    assert window.view.phase == "done"
    assert [one.text for one in window.page.summary.outcomes][1] == "uncalibrated: wire broken"
    assert "rudder" not in load_certificates(window.store.current.calibration)
    window.press(KEY.Key_Space)
    standings = {one.title: one for one in window.page.start.standings or ()}
    assert standings["Left elevator"].is_calibrated
    assert standings["Rudder"].text == "uncalibrated: wire broken"
    listed = window.page.start.instruments
    widest = max(listed.fontMetrics().horizontalAdvance(title) for title in standings)
    for _ in range(3):  # showing them again takes no room from the titles
        listed.show_statuses(window.page.start.standings)
        assert listed.columnWidth(0) > widest

    # Before its first volts come an instrument is waited for: nothing is wrong with its signal.
    window.press(KEY.Key_C)
    window.press(KEY.Key_PageDown)
    assert window.page.work.prompt_view.prompt.state_text == "Waiting"
    window.controller.pass_time(3.0)
    assert window.page.work.prompt_view.prompt.state_text == "Steady"
    window.press(KEY.Key_Escape)
    window.press(KEY.Key_Return)
    window.press(KEY.Key_Space)

    # The check of a minute: the zero has not moved.
    began = window.bench.time
    begin(window, KEY.Key_C)
    work_through(window, "fit")
    assert window.bench.time - began < 60.0
    assert window.view.check_result.passed
    cue = window.page.work.prompt_view.prompt
    assert cue.side_text == "certificate valid"

    # Broken off: what was in force stays in force.
    window.press(KEY.Key_Escape)
    window.press(KEY.Key_Return)
    assert window.view.phase == "aborted"
    window.press(KEY.Key_Space)
    assert window.page.pages.currentWidget() is window.page.start
    # Left out of a check is not out of force, and nothing says so.
    begin(window, KEY.Key_C)
    assert "Skip: not checked" in [offer.text for offer in window.page.action_bar.offers]
    window.press(KEY.Key_X)
    assert "unchecked" in window.page.question_bar.question.text()
    window.type("no time")
    window.press(KEY.Key_Return)
    assert window.page.summary.title.text() == "Check done"
    assert ["no time" in one.text for one in window.page.summary.outcomes] == [True]

    # A horn that moved is remembered on the first page, until it is calibrated anew.
    bench = window.bench
    center = potentiometer.center + 2.0 * potentiometer.slope
    bench.potentiometers["elevator_left"] = replace(potentiometer, center=center)
    window.press(KEY.Key_Space)
    begin(window, KEY.Key_C)
    work_through(window, "fit")
    window.press(KEY.Key_Space)
    assert "Left elevator" in window.view.prompt
    window.press(KEY.Key_Space)
    (standing,) = (one for one in window.page.start.standings if one.title == "Left elevator")
    assert not standing.is_calibrated
    assert "has moved: zero −2.0" in standing.text or "has moved: zero −1.9" in standing.text
    kept = load_certificates(window.store.current.calibration)
    assert kept["elevator_left"].points == certificate.points


def test_a_plan_with_a_mistake_is_told_on_the_page(at_bench: Open) -> None:
    window = at_bench("rudder")
    page, offers = window.page, [one.id for one in window.page.action_bar.offers]
    own = page.folder.folder / "plans" / f"{page.folder.aircraft}.toml"
    plan = own.read_bytes()
    own.write_bytes(plan.replace(b"channel", b"chanel", 1))
    page.hide()
    page.show()
    assert own.name in page.start.message.text()
    assert "chanel" in page.start.message.text()
    assert [one.id for one in page.action_bar.offers] == ["practice"]
    own.write_bytes(plan)
    page.hide()
    page.show()
    assert [one.id for one in page.action_bar.offers] == offers
    assert "chanel" not in page.start.message.text()


def test_a_certificate_goes_into_the_flight_that_is_open_and_is_printed_by_a_key(
    tmp_path: Path, qtbot: QtBot, at_bench: Open
) -> None:
    flight = FlightFolder.create(tmp_path / "flight")
    flight.store_certificates(certificate_paths("b777"))
    window = at_bench("rudder")
    assert "paper" not in [one.id for one in window.page.action_bar.offers]
    window.controller.session.path = flight.path
    begin(window)
    work_through(window)
    kept = {path.stem: path for path in flight.certificate_files()}
    assert set(kept) == set(load_certificates("b777"))
    made = window.page.folder.store.in_force_folder / "rudder.toml"
    assert kept["rudder"].read_bytes() == made.read_bytes()
    assert kept["alpha"].read_bytes() == next(
        path.read_bytes() for path in certificate_paths("b777") if path.stem == "alpha"
    )
    assert window.controller.opened == [flight.path]
    assert load_certificates(window.store.current.calibration)["rudder"].points
    assert [one.id for one in window.page.action_bar.offers][:2] == ["leave", "paper"]
    with qtbot.waitSignal(window.controller.message_posted, timeout=30_000) as said:
        window.press(KEY.Key_W)
    assert said.args[1].startswith("1 page is written")
    page = Path(said.args[1].rpartition(": ")[2].rstrip(".")) / "rudder.pdf"
    assert page.read_bytes().startswith(b"%PDF-")
    assert window.controller.complaints == []
    window.press(KEY.Key_Space)
    assert "paper" in [one.id for one in window.page.action_bar.offers]


def test_the_large_number_and_the_aircraft_follow_the_hand(at_bench: Open) -> None:
    window = at_bench("elevator_left")
    begin(window)
    work, style = window.page.work, window.display_style
    assert count(work.prompt_view, style.theme.target) > 300  # what is wanted
    assert count(work.prompt_view, style.theme.good_fill) > 2000
    assert work.prompt_view.prompt.state_text == "Steady"

    def ink_row() -> float:
        shown = pixels(work.motion_view)[: work.motion_view.height() // 2]
        rows = np.nonzero(shown == int(style.theme.text[1:], 16))[0]
        return float(rows.mean())

    neutral = ink_row()
    window.controller.pass_time(0.6 * window.bench.set_angle("elevator_left", 20.0))
    assert work.prompt_view.prompt.state_text == "Moving"
    assert count(work.prompt_view, style.theme.caution_fill) > 2000
    window.controller.pass_time(2.0)
    assert ink_row() > neutral + 5.0, "trailing edge down is down on the screen"
    assert "Left elevator" in work.motion_view.accessibleName()


@pytest.mark.parametrize("way", ["space", "enter", "double click", "menu", "button"])
def test_one_instrument_is_calibrated_again_by_itself(at_bench: Open, way: str) -> None:
    window = at_bench("elevator_left", "rudder")
    rows = window.page.start.instruments
    window.press(KEY.Key_Down)
    assert rows.selected_channel == "elevator_left"
    window.press(KEY.Key_Down)
    assert rows.selected_channel == "rudder"
    box = rows.visualRect(rows.currentIndex())
    if way in ("space", "enter"):
        QTest.keyClick(rows, KEY.Key_Space if way == "space" else KEY.Key_Return)
    elif way == "double click":
        QTest.mouseClick(rows.viewport(), Qt.MouseButton.LeftButton, pos=box.center())
        assert window.page.run is None
        QTest.mouseDClick(rows.viewport(), Qt.MouseButton.LeftButton, pos=box.center())
    elif way == "menu":
        (action,) = (one for one in rows.actions() if one.text() == "Calibrate again")
        action.trigger()
    else:
        assert window.page.action_bar.offers[0].id == "again"
        window.page.action_bar.triggered.emit("again")
    assert window.page.run is not None
    window.controller.pass_time(4.0)
    assert (window.view.instrument.channel, window.view.count) == ("rudder", 1)


def test_the_others_keep_their_certificates(at_bench: Open) -> None:
    window = at_bench("elevator_left", "rudder")
    store = window.page.folder.store
    morning = datetime(2026, 5, 12, 8, 0, tzinfo=UTC)
    for name in ("elevator_left", "rudder"):
        store.put_in_force(replace(load_certificates("b777")[name], stamp=morning))
    window.page.calibrate_instrument("rudder")
    work_through(window, "done")
    assert store.in_force()["elevator_left"].stamp == morning
    assert len(store.history("rudder")) == 2
    assert len(store.history("elevator_left")) == 1
    window.press(KEY.Key_Space)
    # Accelerometers share their positions, and come together.
    names = load_calibration_plan("b777").select_with_dependencies("ax").channels
    assert names == ("ax", "ay", "an")
    assert load_calibration_plan("b777").select_with_dependencies("q").channels == ("q",)


def test_the_ground_temperature_is_asked_for_in_the_units_of_the_screen(at_bench: Open) -> None:
    window = at_bench("rudder")
    start = window.page.start
    start.temperature.setText("68")
    assert "°F" in start.temperature.accessibleName()
    assert start.temperature_kelvin == pytest.approx(293.15)
    window.display_style.set_units("SI")
    assert "°C" in start.temperature.accessibleName()
    assert start.temperature.text() == "20.0"
    assert start.temperature_kelvin == pytest.approx(293.15)


def test_points_are_repeated_deleted_added_and_taken_back_by_keys(
    at_bench: Open, monkeypatch: pytest.MonkeyPatch
) -> None:
    window = at_bench("rudder")
    begin(window)
    with pytest.raises(AssertionError):
        work_through(window, most=5)
    assert len(window.view.points) == 4
    rows = window.page.work.points.rows
    assert [row.index for row in rows[:5]] == [0, 1, 2, 3, None]
    assert rows[4].current
    assert rows[0].direction == "up"
    assert "increasing" in rows[0].accessible_text
    legend = window.page.work.charts.curve.legend
    assert "increasing" in [one.text() for one in legend.findChildren(QLabel)]

    scrolled: list[float] = []
    monkeypatch.setattr(window.page.work, "scroll_pages", scrolled.append)
    window.press(KEY.Key_Down, Qt.KeyboardModifier.ControlModifier)
    # As the arrows of macOS are.
    both = Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.KeypadModifier
    window.press(KEY.Key_Down, both)
    assert scrolled == [0.8, 0.8]
    window.press(KEY.Key_Up)
    window.press(KEY.Key_Up)
    assert window.page.work.points.choice == 2
    window.press(KEY.Key_Delete)
    assert len(window.view.points) == 3
    window.press(KEY.Key_Backspace)
    assert len(window.view.points) == 4
    window.press(KEY.Key_R)  # the last one
    assert len(window.view.points) == 3
    assert window.view.target == 12.0
    window.press(KEY.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert len(window.view.points) == 4

    window.press(KEY.Key_A)
    window.type("six")
    window.press(KEY.Key_Return)
    assert window.page.question_bar.question.text().startswith("'six'")
    window.type("6")  # in place of what is no answer
    window.press(KEY.Key_Return)
    assert any(slot.value == 6.0 for slot in window.view.remaining)
    window.press(KEY.Key_A)
    window.press(KEY.Key_Escape)  # a question taken back changes nothing
    assert sum(slot.value == 6.0 for slot in window.view.remaining) == 1
    assert QApplication.focusWidget() is window.page


def test_a_temperature_that_is_none_begins_nothing(at_bench: Open) -> None:
    """Else the certificates would be without it, and nobody told."""
    window = at_bench("alpha")
    window.page.start.temperature.setText("2o")
    window.press(KEY.Key_Space)
    QApplication.processEvents()
    assert window.page.run is None
    assert "'2o' is not a number" in window.controller.complaints[0]
    window.page.start.temperature.setText("21,5")
    begin(window)
    assert window.page.run is not None


def test_a_window_that_was_killed_goes_on_at_the_same_point(at_bench: Open) -> None:
    window = at_bench("alpha")
    window.page.start.operator.setText("E. Meyer")
    begin(window)
    with pytest.raises(AssertionError):
        work_through(window, most=6)
    before = window.view.points
    assert len(before) == 5
    window.leave()
    again = at_bench(bench=window.bench)
    assert not again.page.start.resume.isHidden()
    begin(again)
    assert again.view.points == before
    work_through(again)
    assert again.view.certificates["alpha"].who == "E. Meyer"
    again.press(KEY.Key_Space)
    assert again.page.start.resume.isHidden()


def test_a_dead_potentiometer_is_named(at_bench: Open) -> None:
    window = at_bench(
        "elevator_left", "rudder", fault=BenchFault(channel="elevator_left", kind="dead")
    )
    begin(window)
    window.set_surface("elevator_left", 20.0)
    window.controller.pass_time(3.0)
    window.press(KEY.Key_Space)
    window.controller.pass_time(1.0)
    remarks = window.page.work.remarks
    assert [fault.kind for fault in window.view.faults] == ["dead"]
    assert any("stayed" in one.sentence and one.state == "warning" for one in remarks.shown)
    assert remarks.isVisible()
    assert count(remarks, window.display_style.theme.warning) > 50


def test_volts_that_stop_are_not_left_standing(
    at_bench: Open, monkeypatch: pytest.MonkeyPatch
) -> None:
    window = at_bench("elevator_left")
    begin(window)
    assert window.page.work.prompt_view.prompt.volts_text != "– V"
    monkeypatch.setattr(
        "ui.preflight.wizard_controller.DISPLAY", replace(DISPLAY, no_volts_time=-1.0)
    )
    window.controller.refreshed.emit()
    cue = window.page.work.prompt_view.prompt
    assert (cue.state, cue.state_text) == ("warning", "No signal")
    assert not cue.value_text
    assert not cue.volts_text
    assert window.page.work.motion_view.figure.angle is None
    # Where the flight is only being read anew nothing is wrong with the signal.
    window.controller.session.feed.is_up_to_date = False
    window.controller.refreshed.emit()
    cue = window.page.work.prompt_view.prompt
    assert (cue.state, cue.state_text) == ("unknown", "Catching up")


def test_no_heading_stands_over_deflections_that_are_not_there(window: BenchWindow) -> None:
    panel = WizardSummaryPanel(window.display_style)
    panel.show_outcomes("Calibration done", "Rudder calibrated.", ())
    assert [one.text() for one in panel.findChildren(QLabel) if not one.isHidden()] == [
        "Calibration done",
        "Rudder calibrated.",
    ]


@pytest.mark.parametrize(
    ("channel", "view", "kind", "end", "scale"),
    [("rudder", "above", "surface", 24.0, 100), ("elevator_left", "side", "surface", 24.0, 200),
     ("alpha", "side", "vane", 40.0, 200), ("beta", "above", "vane", 40.0, 100)],
)  # fmt: skip
def test_a_surface_does_not_turn_over_the_words_that_name_its_sides(
    window: BenchWindow,
    channel: str,
    view: ViewDirection,
    kind: SurfaceKind,
    end: float,
    scale: int,
) -> None:
    style = window.display_style
    style.set_scale(scale)
    for sense, wide in product((-1, 1), (260, 330)):
        figure = SurfaceFigure(
            channel=channel, title=channel, view=view, kind=kind, sense=sense, ticks=(-end, end)
        )
        box = QRectF(0.0, 0.0, style.px(wide), style.px(154))
        words = SurfaceCloseup(style, figure).side_boxes(box)
        assert not words[0].intersects(words[1])
        for angle, place in product((-end, 0.0, end), words):
            assert box.contains(place)
            part = SurfaceCloseup(style, replace(figure, angle=angle)).moving_part(box)
            assert part.intersected(QPolygonF(place)).isEmpty()


def test_nothing_is_calibrated_by_a_replay(at_bench: Open) -> None:
    """Its volts would make a certificate of today, and those of practice one that counts."""
    window = at_bench("elevator_left")
    window.controller.session.replay_feed = object()
    window.controller.changed.emit()
    assert "This is a replay" in window.page.start.message.text()
    begin(window)
    window.set_surface("elevator_left", 20.0)
    window.controller.pass_time(3.0)
    window.press(KEY.Key_Space)
    assert window.view.phase == "begin"  # still waits for the first volts


def let_no_volts_come(monkeypatch: pytest.MonkeyPatch) -> None:
    later = time.monotonic() + 2.0
    monkeypatch.setattr(
        ui.preflight.wizard_controller, "time", SimpleNamespace(monotonic=lambda: later)
    )


def test_no_point_is_taken_of_volts_that_no_longer_come(
    at_bench: Open, monkeypatch: pytest.MonkeyPatch
) -> None:
    window = at_bench("elevator_left")
    begin(window)
    with pytest.raises(AssertionError):
        work_through(window, most=3)
    taken = len(window.view.points)
    assert taken
    with monkeypatch.context() as silence:
        let_no_volts_come(silence)
        window.press(KEY.Key_Space)
        assert len(window.view.points) == taken
        assert window.view.message == "no voltage"
    # They come again: it goes on where it was.
    with pytest.raises(AssertionError):
        work_through(window, most=1)
    assert len(window.view.points) == taken + 1


def test_two_points_lie_on_their_line(at_bench: Open) -> None:
    """A bar of its full length beside +0.00 would be the rounding of the computer."""
    window = at_bench("rudder")
    begin(window)
    with pytest.raises(AssertionError):
        work_through(window, most=3)
    rows = [row for row in window.page.work.points.rows if row.index is not None]
    assert [row.residual for row in rows] == ["+0.00°", "+0.00°"]
    assert all(abs(row.share) < 0.01 for row in rows)


def test_the_surfaces_at_the_end_are_those_of_now(
    at_bench: Open, monkeypatch: pytest.MonkeyPatch
) -> None:
    window = at_bench("rudder")
    begin(window)
    window.press(KEY.Key_Escape)
    window.press(KEY.Key_Return)
    window.controller.pass_time(1.0)
    assert window.page.summary.isVisible()
    shown: list[int] = []
    monkeypatch.setattr(
        window.page.summary, "show_deflections", lambda rows: shown.append(len(rows))
    )
    monkeypatch.setattr(
        "ui.preflight.wizard_page.list_combined_deflections",
        lambda history, _units: [history] if history else [],
    )
    window.controller.refreshed.emit()
    let_no_volts_come(monkeypatch)
    window.controller.refreshed.emit()
    assert shown == [1, 0]


# Gyros, accelerometers, pressures


def test_the_others_are_led_through_with_a_picture_for_each(at_bench: Open) -> None:
    window = at_bench("p", "ax", "ay", "an", "dynamic_pressure", "static_pressure")
    begin(window, KEY.Key_G)
    bench, controller = window.bench, window.controller
    figure = window.page.work.motion_view
    assert window.view.phase == "gyro_still"
    controller.pass_time(7.0)
    assert window.view.phase == "gyro_turn"
    assert (figure.figure.kind, figure.figure.axis) == ("turn", "p")
    while window.view.phase == "gyro_turn":
        window.press(KEY.Key_PageDown)
    controller.pass_time(4.0)
    seen = []
    while window.view.phase == "accel_position":
        seen.append(figure.figure.position)
        controller.pass_time(bench.move_to_position(window.view.position) + 5.0)
    assert seen == ["z_down", "z_up", "x_up", "x_down", "y_up", "y_down"]
    until_phase(window, "pressure_zero")
    assert figure.figure.kind == "cover"
    bench.cover()
    window.press(KEY.Key_Space)
    controller.pass_time(6.0)
    assert window.view.phase == "pressure_blow"
    assert figure.figure.kind == "blow"
    controller.pass_time(bench.blow() + 4.0)  # goes green by itself
    until_phase(window, "done")
    assert {"p", "ax", "ay", "an", "dynamic_pressure"} <= set(window.view.certificates)


def until_phase(window: BenchWindow, phase: str) -> None:
    for _ in range(20):
        if window.view.phase == phase:
            return
        if window.view.phase == "fit" and window.view.problems:
            window.press(KEY.Key_Space)
        window.controller.pass_time(1.0)
    raise AssertionError(f"{window.view.phase}: {window.view.prompt} {window.view.problems}")


# For gloves, and at every size


@pytest.mark.parametrize(("scale", "size"), [(100, (1190, 600)), (200, (1180, 430))])
def test_controls_are_for_gloves_and_the_cue_is_never_cut(
    at_bench: Open, scale: int, size: tuple[int, int]
) -> None:
    window = at_bench("elevator_left")
    begin(window)
    window.display_style.set_scale(scale)
    window.resize(*size)
    for _ in range(3):  # layouts settle one after the other
        QApplication.processEvents()
    assert (window.width(), window.height()) == size, "the page asks for more room than there is"
    bar, cue = window.page.action_bar, window.page.work.prompt_view
    buttons = [one for one in bar.findChildren(QPushButton) if one.isVisible()]
    assert any(one.text().startswith("Direction correct") for one in buttons)
    for button in buttons:
        assert button.height() >= 44 * scale // 100
        assert button.width() >= button.sizeHint().width()
        assert button.accessibleName()
    # Number and prompt above the actions, whole.
    top = cue.mapTo(window, cue.rect().topLeft()).y()
    assert cue.height() >= cue.minimumSizeHint().height()
    assert top + cue.height() <= bar.mapTo(window, bar.rect().topLeft()).y()
    window.display_style.set_scale(100)


# In the window itself


@pytest.mark.long
def test_practice_runs_over_a_real_link_and_comes_in_force_live(
    tmp_path: Path, qtbot: QtBot, monkeypatch: pytest.MonkeyPatch
) -> None:
    """F1, Alt+2, P: the bench's process, recorder and decoder; the helper moves what is asked.

    Its recording ends with it, unasked: nobody would come back to it.
    """
    asked: list[str] = []
    monkeypatch.setenv("GSAPP_RUNTIME_FOLDER", str(tmp_path / "run"))
    monkeypatch.setattr(
        ui.main_window, "ask_closing", lambda *names: asked.extend(names[1:]) or "stop"
    )
    window = open_window(tmp_path)
    activate(qtbot, window)
    controller = window.flight_controller

    def press(key: Qt.Key, modifier: Qt.KeyboardModifier = Qt.KeyboardModifier.NoModifier) -> None:
        qtbot.keyClick(QApplication.focusWidget() or window, key, modifier)

    def calibrated() -> bool:
        return (
            controller.session is not None
            and "elevator_left" in controller.session.metadata.certificates
        )

    try:
        qtbot.keyClick(window, KEY.Key_F1)
        there = window.commands.actions["preflight_calibration"]
        until(qtbot, there.isEnabled)
        press(KEY.Key_2, Qt.KeyboardModifier.AltModifier)
        until(qtbot, lambda: window.findChild(WizardPage) is not None)
        page = window.findChild(WizardPage)
        page.practice.speed = 3.0
        press(KEY.Key_P)
        until(qtbot, lambda: page.practice.running and controller.time is not None, 30_000)
        until(qtbot, page.hasFocus)
        press(KEY.Key_Space)
        until(qtbot, lambda: page.run is not None and page.run.view.phase == "sign", 20_000)
        press(KEY.Key_H)
        until(qtbot, lambda: page.run.view.phase == "points", 20_000)
        assert calibrated()
        press(KEY.Key_X)
        press(KEY.Key_Return)
        folder = controller.session.path
        assert not (folder / "calibration" / "elevator_left.toml").exists()
        assert (folder / "calibration" / "throttle.toml").exists()
        # The open flight is read anew, live, as soon as one looks elsewhere.
        press(KEY.Key_F2)
        until(qtbot, lambda: controller.session is not None and not calibrated(), 20_000)
        # Practice never counts for an aircraft.
        assert window.store.current.calibration == "b777"
        assert find_recorders()
    finally:
        window.close()
        window.deleteLater()
    assert not asked
    until(qtbot, lambda: not find_recorders(), 20_000)


def test_practice_does_not_take_the_place_of_a_flight_that_is_recorded(
    tmp_path: Path, qtbot: QtBot, monkeypatch: pytest.MonkeyPatch
) -> None:
    window = open_window(tmp_path)
    activate(qtbot, window)
    try:
        qtbot.keyClick(window, KEY.Key_F1)
        there = window.commands.actions["preflight_calibration"]
        until(qtbot, there.isEnabled)
        there.trigger()
        until(qtbot, lambda: window.findChild(WizardPage) is not None)
        page = window.findChild(WizardPage)
        begun: list[object] = []
        monkeypatch.setattr(
            window.flight_controller.flight_opener,
            "connect_aircraft",
            lambda *_, **__: begun.append(1),
        )
        with monkeypatch.context() as patch:
            patch.setattr(FlightController, "is_recording", True)
            qtbot.keyClick(page, KEY.Key_P)
        assert any("being recorded" in text for text in window.banners.texts())
        assert not begun
        qtbot.keyClick(page, KEY.Key_P)
        assert begun
    finally:
        window.close()
        window.deleteLater()
