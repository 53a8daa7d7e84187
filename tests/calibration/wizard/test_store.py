"""Certificates in force: history, skipping, reverting, whatever is interrupted."""

import datetime as dt
from pathlib import Path

import pytest

import calibration.certificate_store
from calibration import CalibrationError, CalibrationPoint, Certificate, load_certificates
from calibration.certificate_store import CertificateStore, CheckRecord
from calibration.curve_selection import create_certificate, fit_calibration
from calibration.drift import CheckResult
from gsapp.foundation import UnknownNameError

DAY = dt.datetime(2026, 5, 12, 8, 0)  # noqa: DTZ001 - a field's local time


def certificate(day: int, channel: str = "rudder") -> Certificate:
    points = [CalibrationPoint(volts=1.0 + at, value=10.0 * at + day) for at in range(3)]
    return create_certificate(
        fit_calibration(points, degree=1), points, channel_id=channel, unit="deg", who="crew",
        stamp=DAY.replace(day=day),
    )  # fmt: skip


def check_of(in_force: Certificate, stamp: dt.datetime, *, passed: bool = True) -> CheckRecord:
    found = CheckResult(
        zero=0.0, zero_uncertainty=0.1, slope=0.0, slope_uncertainty=0.01, largest=0.0,
        off=(0.0, 0.0, 0.0), passed=passed, sentence="",
    )  # fmt: skip
    return CheckRecord(
        channel="rudder", who="crew", stamp=stamp, certificate=in_force.stamp, unit="deg",
        result=found,
    )  # fmt: skip


def days(store: CertificateStore, channel: str = "rudder") -> list[int]:
    return [one.stamp.day for one in store.history(channel)]


def test_what_is_put_is_in_force_and_in_the_history(tmp_path: Path) -> None:
    store = CertificateStore(tmp_path, "B777")
    assert store.in_force() == {}
    assert store.history("rudder") == ()
    for day in (12, 13):
        store.put_in_force(certificate(day))
    store.put_in_force(certificate(12, "alpha"))
    assert {name: one.stamp.day for name, one in store.in_force().items()} == {
        "rudder": 13,
        "alpha": 12,
    }
    assert days(store) == [12, 13]
    loaded = load_certificates(store.in_force_folder)
    assert {name: one.stamp.day for name, one in loaded.items()} == {"rudder": 13, "alpha": 12}
    assert loaded["rudder"].points == certificate(13).points
    found = store.find_by_stamp("rudder", DAY)
    assert found.coefficients == certificate(12).coefficients
    assert store.find_by_stamp("rudder", DAY.replace(hour=1)) is None


def test_putting_twice_changes_nothing(tmp_path: Path) -> None:
    store = CertificateStore(tmp_path, "B777")
    for _ in range(2):
        store.put_in_force(certificate(12))
        store.mark_uncalibrated("beta", "vane lost", "crew", DAY)
    assert days(store) == [12]
    assert len(list(tmp_path.rglob("*skipped.toml"))) == 1


def test_skipped_is_uncalibrated_until_a_certificate_comes(tmp_path: Path) -> None:
    store = CertificateStore(tmp_path, "B777")
    store.put_in_force(certificate(12))
    store.mark_uncalibrated("rudder", "wire broken", "crew", DAY)
    assert store.in_force() == {}
    assert not list(store.in_force_folder.glob("*.toml"))
    skipped = CertificateStore(tmp_path, "B777").skipped_channels()["rudder"]
    assert (skipped.reason, skipped.who, skipped.stamp) == ("wire broken", "crew", DAY)
    store.mark_uncalibrated("rudder", "no time", "crew", DAY.replace(hour=9))
    skipped = store.skipped_channels()["rudder"]
    assert (skipped.reason, skipped.stamp.hour) == ("no time", 9)
    assert days(store) == [12]
    store.put_in_force(certificate(13))
    assert store.skipped_channels() == {}
    assert set(store.in_force()) == {"rudder"}


def test_the_last_check_of_the_certificate_in_force_counts(tmp_path: Path) -> None:
    store = CertificateStore(tmp_path, "B777")
    in_force = certificate(12)
    store.put_in_force(in_force)
    assert store.last_check("rudder") is None
    stamps = [DAY.replace(hour=hour) for hour in (9, 10, 11)]
    for stamp, passed in zip(stamps, (True, False, True), strict=True):
        store.record_check(check_of(in_force, stamp, passed=passed))

    def last() -> tuple[int, bool] | None:
        checked = CertificateStore(tmp_path, "B777").last_check("rudder")
        return None if checked is None else (checked.stamp.hour, checked.result.passed)

    assert last() == (11, True)
    for _ in range(2):
        store.withdraw_check("rudder", stamps[-1])
    assert last() == (10, False)
    store.put_in_force(certificate(13))
    assert last() is None


def test_a_check_made_twice_in_a_second_is_taken_back_twice(tmp_path: Path) -> None:
    store = CertificateStore(tmp_path, "B777")
    store.put_in_force(certificate(12))
    for _ in range(2):
        store.record_check(check_of(certificate(12), DAY))
        assert store.checks("rudder")
        store.withdraw_check("rudder", DAY)
        assert not store.checks("rudder")


def test_revert_goes_back_one_at_a_time_and_by_stamp_once(tmp_path: Path) -> None:
    store = CertificateStore(tmp_path, "B777")
    store.put_in_force(certificate(12))
    store.mark_uncalibrated("rudder", "wire broken", "crew", DAY.replace(hour=9))
    store.put_in_force(certificate(13))
    for _ in range(2):
        store.withdraw("rudder", DAY.replace(day=13))
    assert set(store.skipped_channels()) == {"rudder"}
    store.withdraw("rudder", DAY.replace(hour=9))
    assert store.in_force()["rudder"].stamp.day == 12
    for _ in range(2):
        store.withdraw("rudder", DAY)
    assert store.in_force() == {}
    assert store.skipped_channels() == {}
    assert len(list(tmp_path.rglob("*.withdrawn"))) == 3
    store.put_in_force(certificate(14))
    assert days(store) == [14]


def test_a_change_that_was_interrupted_is_whole_when_opened_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store = CertificateStore(tmp_path, "B777")
    store.put_in_force(certificate(12))

    def killed(*arguments: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(calibration.certificate_store, "write_atomically", killed)
        with pytest.raises(KeyboardInterrupt):
            store.put_in_force(certificate(13))
    assert load_certificates(store.in_force_folder)["rudder"].stamp.day == 12
    again = CertificateStore(tmp_path, "B777")
    assert load_certificates(again.in_force_folder)["rudder"].stamp.day == 13


def test_two_windows_see_each_others_changes(tmp_path: Path) -> None:
    one, other = CertificateStore(tmp_path, "B777"), CertificateStore(tmp_path, "B777")
    one.put_in_force(certificate(12))
    other.put_in_force(certificate(13))
    one.put_in_force(certificate(14))
    assert days(other) == [12, 13, 14]


def test_aircraft_do_not_mix_whatever_their_names(tmp_path: Path) -> None:
    names = ("B777", "../B777", "b/777", ".", "Flieger Nr. 2")
    for day, name in enumerate(names, start=1):
        CertificateStore(tmp_path / "all", name).put_in_force(certificate(day))
    found = [CertificateStore(tmp_path / "all", name) for name in names]
    assert [days(store) for store in found] == [[1], [2], [3], [4], [5]]
    assert [path.name for path in tmp_path.iterdir()] == ["all"]
    with pytest.raises(CalibrationError, match="has no name"):
        CertificateStore(tmp_path, " ")


def test_only_known_channels_are_skipped(tmp_path: Path) -> None:
    store = CertificateStore(tmp_path, "B777")
    with pytest.raises(UnknownNameError, match="rudder"):
        store.mark_uncalibrated("ruder", "typo", "crew", DAY)
    assert not (tmp_path / "B777" / "history").exists()
