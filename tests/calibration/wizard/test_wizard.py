"""The wizard leads a crew through surfaces and vanes without keys, and lets them change things."""

from pathlib import Path

import numpy as np
import pytest

from calibration import load_certificates
from calibration.plan import CalibrationPlan, load_calibration_plan
from tests.calibration.wizard.wizard_kit import SMALL, Field

DEG = np.pi / 180.0


def test_surfaces_and_vanes_cost_no_key(tmp_path: Path) -> None:
    channels = ("elevator_left", "elevator_right", "alpha")
    plan = load_calibration_plan("b777").select_channels(channels)
    field = Field(tmp_path, plan, seed=2)
    crew = field.begin(temperature=290.0)
    view = crew.until(lambda now: now.phase == "done")
    assert crew.keys == 0
    assert view.accepted == plan.channels
    assert view.prompt == "3 instruments calibrated."
    assert view.progress == 1.0
    for channel, certificate in load_certificates(field.store.in_force_folder).items():
        assert [point.direction for point in certificate.points] == ["up"] * 5 + ["down"] * 5
        assert certificate.who == "crew"
        assert certificate.temperature == pytest.approx(290.0)
        x = 0.95 * np.linspace(plan[channel].settings[0], plan[channel].settings[-1], 9)
        volts = (
            field.bench.zero[channel]
            + field.bench.slope[channel] * x
            + field.bench.curve[channel] * x * x
        )
        # The middle of the slop is what was set; the certificate says how well that is known.
        error = certificate.evaluate(volts, 5.0) / DEG - x
        assert np.all(np.abs(error) < certificate.uncertainty(volts, 5.0) / DEG)
        assert certificate.hysteresis == pytest.approx(field.bench.slop[channel], rel=0.1)


def test_the_end_says_which_instruments_are_calibrated_and_no_next_one_is_promised(
    tmp_path: Path,
) -> None:
    alone = CalibrationPlan(name="alone", instruments=SMALL.instruments[:1])
    crew = Field(tmp_path / "alone", alone).begin()
    assert crew.until(lambda now: now.phase == "done").prompt == "Left elevator calibrated."
    fits = {one.prompt for one in crew.views if one.phase == "fit"}
    assert fits == {"Left elevator OK: accept it."}
    crew = Field(tmp_path / "two").begin()
    crew.until(lambda now: now.phase == "sign")
    crew.press("skip", reason="no protractor")
    assert crew.until(lambda now: now.phase == "done").prompt == "1 of 2 instruments calibrated."


def test_by_key_each_point_costs_one(tmp_path: Path) -> None:
    crew = Field(tmp_path).begin(auto=False, by_key=True)
    crew.until(lambda now: now.accepted != ())
    assert crew.keys == 6
    assert sum(view.tone == "steady" for view in crew.views) > 0


def test_a_setting_reached_from_the_wrong_side_is_not_taken(tmp_path: Path) -> None:
    """Overshot: the wizard says so, waits, and takes the point once it is reached as asked."""
    crew = Field(tmp_path).begin()
    crew.until(lambda now: len(now.points) == 1)
    bench, channel = crew.bench, "elevator_left"
    crew.see(bench.move(channel, 4.0))
    crew.see(bench.move(channel, 0.0))
    assert not crew.wait(3.0, lambda now: len(now.points) == 2)
    view = crew.wizard.view
    assert "Overshot" in view.prompt
    assert "Overshot" in view.spoken
    assert any(seen.tone == "error" for seen in crew.views)
    crew.see(bench.move(channel, -4.0))
    crew.see(bench.move(channel, 0.0))
    assert crew.wait(3.0, lambda now: len(now.points) == 2)
    assert crew.wizard.view.points[1].direction == "up"


def test_a_key_takes_it_at_once_and_notes_the_side_in_truth(tmp_path: Path) -> None:
    crew = Field(tmp_path).begin()
    crew.until(lambda now: len(now.points) == 1)
    crew.see(crew.bench.move("elevator_left", 4.0))
    crew.see(crew.bench.move("elevator_left", 0.0))
    crew.wait(1.2)
    view = crew.press("take")
    assert view.points[1].direction == "down"
    assert "decreasing" in view.message


def test_a_rest_on_the_way_is_not_the_setting(tmp_path: Path) -> None:
    crew = Field(tmp_path).begin()
    crew.until(lambda now: len(now.points) == 2)
    crew.see(crew.bench.move("elevator_left", 9.0))
    assert not crew.wait(4.0, lambda now: len(now.points) == 3)
    assert "Steady at about" in crew.wizard.view.prompt
    crew.see(crew.bench.move("elevator_left", 20.0))
    assert crew.wait(3.0, lambda now: len(now.points) == 3)


def test_a_crew_that_lingers_is_not_a_setting_ahead(tmp_path: Path) -> None:
    crew = Field(tmp_path).begin()
    crew.until(lambda now: len(now.points) == 1)
    crew.see(crew.bench.move("elevator_left", -24.0))
    crew.see(crew.bench.move("elevator_left", -20.0))
    assert not crew.wait(4.0, lambda now: len(now.points) == 2)
    assert "20 deg" in crew.wizard.view.prompt


def test_the_same_rest_is_not_taken_twice(tmp_path: Path) -> None:
    crew = Field(tmp_path).begin()
    crew.until(lambda now: len(now.points) == 3)
    assert crew.wizard.view.target == 20.0
    assert not crew.wait(4.0, lambda now: len(now.points) == 4)
    assert "Past 20 down" in crew.wizard.view.spoken
    crew.see(crew.bench.move("elevator_left", 23.0))
    crew.wait(1.2)
    assert "20 deg" in crew.wizard.view.prompt
    crew.see(crew.bench.move("elevator_left", 20.0))
    assert {view.spoken for view in crew.views[-5:]} == {"Back to 20 down"}
    assert crew.wait(3.0, lambda now: len(now.points) == 4)
    assert all(view.tone != "error" for view in crew.views)
    points = crew.wizard.view.points
    assert (points[2].direction, points[3].direction) == ("up", "down")
    assert abs(points[3].volts - points[2].volts) > 0.005


def test_repeat_delete_add_and_choose(tmp_path: Path) -> None:
    crew = Field(tmp_path).begin()
    crew.until(lambda now: now.phase == "fit")
    view = crew.press("repeat", index=1)
    assert (view.phase, view.target, len(view.points)) == ("points", 0.0, 5)
    crew.see(crew.bench.move("elevator_left", -10.0))
    crew.obey()
    view = crew.press("delete", index=0)
    assert (view.phase, len(view.points)) == ("fit", 5)
    assert crew.press("delete", index=7).tone == "error"
    view = crew.press("add", value=10.0)
    assert (view.phase, view.target, view.direction) == ("points", 10.0, "single")
    crew.obey()
    assert len(crew.wizard.view.points) == 6
    assert crew.press("add", value=40.0).tone == "error"
    view = crew.press("choose_degree", degree=1)
    assert view.degree == 1
    assert view.calibration.degree == 1
    # What the crew is looking into is not accepted under its hands.
    assert not crew.wait(5.0, lambda now: now.phase != "fit")
    crew.press("accept")
    assert crew.bench.plan.channels[0] in crew.wizard.view.accepted
    assert load_certificates(Field(tmp_path).store.in_force_folder)["elevator_left"].degree == 1


def test_an_outlier_is_pointed_out_and_not_accepted_by_itself(tmp_path: Path) -> None:
    plan = load_calibration_plan("b777").select_kinds(("vane",)).select_channels(["alpha"])
    crew = Field(tmp_path, plan).begin()
    crew.until(lambda now: len(now.points) == 6)
    crew.see(crew.bench.move("alpha", 15.0))
    crew.wait(1.0)
    crew.press("take")
    crew.until(lambda now: now.phase == "fit")
    assert not crew.wait(5.0, lambda now: now.phase != "fit")
    view = crew.wizard.view
    assert view.calibration.quality.outliers == (6,)
    assert view.problems[0].startswith("point 7, 12 deg")
    crew.press("repeat", index=6)
    crew.see(crew.bench.move("alpha", 17.0))
    crew.until(lambda now: now.phase == "done")


def test_undo_takes_back_step_by_step_as_far_as_the_certificate(tmp_path: Path) -> None:
    field = Field(tmp_path)
    field.begin().until(lambda now: now.accepted != ())
    first = field.store.in_force()["elevator_left"]
    crew = field.begin()
    crew.until(lambda now: "elevator_left" in now.accepted)
    assert field.store.in_force()["elevator_left"].stamp > first.stamp
    view = crew.press("undo")
    assert (view.phase, view.accepted) == ("fit", ())
    assert field.store.in_force()["elevator_left"].stamp == first.stamp
    view = crew.press("undo")
    assert (view.phase, len(view.points)) == ("points", 5)
    for _ in range(7):
        view = crew.press("undo")
    assert view.phase == "begin"
    assert "undo" not in view.available_actions


def test_skip_back_open_and_abort(tmp_path: Path) -> None:
    field = Field(tmp_path)
    field.begin().until(lambda now: now.accepted != ())
    before = {name: one.stamp for name, one in field.store.in_force().items()}
    crew = field.begin()
    crew.until(lambda now: now.phase == "sign")
    assert "back" not in crew.wizard.view.available_actions
    view = crew.press("next")
    assert view.instrument is SMALL.instruments[1]
    view = crew.press("back")
    assert view.instrument is SMALL.instruments[0]
    view = crew.press("skip", reason="no protractor")
    assert view.skipped == {"elevator_left": "no protractor"}
    assert "elevator_left" not in field.store.in_force()
    assert field.store.skipped_channels()["elevator_left"].reason == "no protractor"
    view = crew.press("open", channel="elevator_left")
    assert view.phase == "sign"
    view = crew.press("undo")
    view = crew.press("undo")
    assert {name: one.stamp for name, one in field.store.in_force().items()} == before
    view = crew.press("abort")
    assert (view.phase, view.available_actions) == ("aborted", frozenset())
    assert {name: one.stamp for name, one in field.store.in_force().items()} == before


def test_what_it_does_by_itself_does_not_depend_on_the_pieces(tmp_path: Path) -> None:
    field = Field(tmp_path / "a")
    crew = field.begin()
    blocks = []
    feed = crew.wizard.feed
    crew.wizard.feed = lambda block: (blocks.append(block), feed(block))[1]  # type: ignore
    crew.until(lambda now: len(now.points) == 4)
    journals = []
    whole = type(blocks[0]).concatenate(blocks)
    for name, cuts in (("b", 7), ("c", 5000)):
        other = Field(tmp_path / name)
        wizard = other.begin().wizard
        for at in range(0, len(whole), cuts):
            part = whole.times[at : at + cuts]
            wizard.feed(whole.between(part[0], np.nextafter(part[-1], np.inf)))
        lines = other.journal.read_text(encoding="utf-8").splitlines()
        journals.append([line.replace('"stamp"', "") for line in lines])
    assert journals[0] == journals[1]
    assert len(journals[0]) == len(field.journal.read_text(encoding="utf-8").splitlines())
