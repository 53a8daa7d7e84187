"""Whether certificates count: one judgment, shown alike in every place."""

from dataclasses import replace
from datetime import UTC, datetime, timedelta

import pytest

from calibration import Certificate, load_certificates
from calibration.validity import VALIDITY_PERIOD, CalibrationInForce, CalibrationStatus, day_text

NOON = datetime(2026, 5, 12, 12, 0, tzinfo=UTC)
SHIPPED = load_certificates("b777")


def made(name: str, age: timedelta) -> Certificate:
    return replace(SHIPPED[name], who="crew", stamp=NOON - age)


def judged(*certificates: Certificate, **more: object) -> CalibrationStatus:
    known = {one.channel: one for one in certificates}
    return CalibrationInForce(certificates=known, flight_date=NOON, **more).evaluate()


def test_only_surfaces_and_vanes_are_out_of_date() -> None:
    old = timedelta(days=400)
    assert judged(made("rudder", timedelta(hours=1)), made("p", old)).state == "good"
    assert judged(made("rudder", old), made("p", old)).state == "caution"
    assert judged(made("alpha", VALIDITY_PERIOD), made("p", old)).state == "good"


def test_the_values_that_ship_are_nobodys_calibration() -> None:
    """They once counted as 23 years old."""
    status = judged(SHIPPED["rudder"], made("alpha", timedelta(hours=1)))
    assert status.state == "caution"
    assert "2003" not in status.summary + status.detail
    assert "Rudder" in status.detail


def test_what_is_worst_comes_first() -> None:
    rudder, alpha = made("rudder", timedelta(hours=1)), made("alpha", timedelta(days=3))
    assert judged(rudder, alpha, missing=["beta"]).summary == "1 uncalibrated"
    assert judged(rudder, alpha, failed_checks={"rudder": rudder.stamp}).summary == "1 moved"
    # That check was one of an earlier certificate.
    assert judged(rudder, failed_checks={"rudder": alpha.stamp}).state == "good"
    assert judged(replace(rudder, stamp=NOON + timedelta(days=3))).summary == "clock?"
    assert judged().state == "unknown"


def test_a_record_is_judged_by_its_own_day() -> None:
    certificates = {"rudder": made("rudder", timedelta(hours=2))}
    assert (
        CalibrationInForce(certificates=certificates, flight_date=NOON).evaluate().state == "good"
    )
    later = CalibrationInForce(certificates=certificates, flight_date=NOON + timedelta(days=30))
    assert later.evaluate().state == "caution"
    assert (
        CalibrationInForce(certificates=certificates, flight_date=None).evaluate().state == "good"
    )


@pytest.mark.parametrize(
    ("days", "words"),
    [(0, "today"), (1, "yesterday"), (9, "3 May"), (200, "24 Oct 2025"), (-2, "14 May")],
)
def test_days_are_dates_once_they_are_past(days: int, words: str) -> None:
    assert day_text(NOON - timedelta(days=days), NOON) == words
