"""``gsapp catalog``: groups, trends and changes over a fleet."""

import json
from datetime import timedelta
from pathlib import Path

import numpy as np
import pytest

import gsapp
from gsapp.flight.catalog import (
    Catalog,
    EstimationRun,
    ManeuverFilter,
    StoredEstimate,
    store_instrument_errors,
    store_run,
)
from gsapp.identification.fleet.fleet_values import select_fleet_values
from gsapp.quantities.constants import DEGREE
from tests.cli.command_kit import gsapp as command
from tests.identification.fleet_kit import CENTER, FIRST_DAY, SLOPE, VALUE, make_fleet, store_fleet

FLEET = make_fleet(11, flights=12)
STEP_DAY, STEP = 60.0, 0.3


@pytest.fixture(scope="module")
def catalog(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("fleet") / "fleet.sqlite"
    store_fleet(path, FLEET)
    store_fleet(path, FLEET, name="Cm_de", step=("SN 2", STEP_DAY, STEP))
    return path


def result_of(*words: object) -> dict:
    done = command("catalog", *words, "--json", "-")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_a_trend_recovers_the_fleet(catalog: Path, tmp_path: Path) -> None:
    figure = tmp_path / "trend.png"
    found = result_of(catalog, "trend", "Cm_alpha", "--against", "mach", "--figure", figure)
    truth = VALUE + SLOPE * (found["reference"]["mach"] - CENTER)
    assert found["intercept"]["low"] < truth < found["intercept"]["high"]
    assert found["slopes"]["mach"]["low"] < SLOPE < found["slopes"]["mach"]["high"]
    assert set(found["groups"]) == set(FLEET.own)
    assert (found["n"], found["flights"], found["unknown"]) == (len(FLEET.values), 72, 0)
    assert figure.read_bytes().startswith(b"\x89PNG")


def test_slopes_are_shown_in_the_units_of_the_user(catalog: Path) -> None:
    """The JSON stays SI; the table of the API is per ft/s."""
    words = (catalog, "trend", "Cm_alpha", "--against", "V")
    si = result_of(*words)["slopes"]["V"]["value"]
    assert result_of(*words, "--units", "si")["slopes"]["V"]["value"] == si
    rows = {
        units: gsapp.trend(catalog, "Cm_alpha", "V", units=units).tables["effects"].columns
        for units in ("us", "si")
    }
    assert rows["si"]["value"][1] == pytest.approx(si)
    assert rows["us"]["value"][1] == pytest.approx(0.3048 * si)
    # The value where the conditions have their mean does not depend on the units.
    assert rows["us"]["value"][0] == rows["si"]["value"][0]


def test_a_step_of_one_airframe_is_found_and_dated(catalog: Path, tmp_path: Path) -> None:
    figure = tmp_path / "changes.svg"
    found = result_of(
        catalog, "changes", "Cm_de", "Cm_alpha", "--against", "mach", "--figure", figure
    )["series"]
    changed = [one for one in found if one["time"] is not None]
    assert len(found) == 12
    assert [(one["name"], one["group"]) for one in changed] == [("Cm_de", "SN 2")]
    (one,) = changed
    day = f"{FIRST_DAY + timedelta(days=STEP_DAY):%Y-%m-%d}"
    assert one["kind"] == "step"
    assert one["earliest"] <= day <= one["latest"]
    assert one["size"] == pytest.approx(STEP, abs=4.0 * one["size_std"])
    assert b"<svg" in figure.read_bytes()


def test_a_vane_that_drifts_is_found(tmp_path: Path) -> None:
    """By 0.5 deg a year from the middle on, with a bound of 0.05 deg a flight."""
    path = tmp_path / "fleet.sqlite"
    dates = store_fleet(path, make_fleet(21, airframes=2, flights=60, maneuvers=1))
    random = np.random.default_rng(21)
    onset = FIRST_DAY + timedelta(days=300)
    bound = 0.05 * DEGREE
    with Catalog(path) as store:
        for flight, date in dates.items():
            years = max((date - onset) / timedelta(days=365.25), 0.0)
            drift = 0.5 * DEGREE * years if flight.startswith("SN 1") else 0.0
            value = drift + bound * random.standard_normal()
            errors = {
                "alpha.bias": (value, bound, "estimated"),
                "beta.bias": (None, None, "unknown"),
            }
            store_instrument_errors(store, flight, errors)
    found = result_of(path, "changes", "alpha.bias")["series"]
    assert [one["kind"] for one in found] == ["none", "drift"]
    drift = found[1]
    assert drift["unit"] == "rad"
    assert drift["earliest"] <= f"{onset:%Y-%m-%d}" <= drift["latest"]
    assert drift["size"] == pytest.approx(0.5 * DEGREE, abs=4.0 * drift["size_std"])
    shown = gsapp.changes(path, "alpha.bias").tables["changes"].columns
    assert shown["unit"] == ["deg", "deg"]
    assert shown["size"][1] == pytest.approx(drift["size"] / DEGREE)
    # What is unknown in all flights is no series.
    assert {one["name"] for one in result_of(path, "changes")["series"]} == {
        "Cm_alpha",
        "alpha.bias",
    }


def test_groups_count_and_average(catalog: Path) -> None:
    found = result_of(catalog, "groups", "Cm_alpha", "--by", "airframe")
    assert found["groups"][0] == {"group": "SN 0", "flights": 12, "maneuvers": 36}
    means = {one["group"]: one for one in found["values"][0]["groups"]}
    for name in FLEET.own:
        own = np.array([one == name for one in FLEET.airframes])
        assert means[name]["mean"] == pytest.approx(FLEET.values[own].mean(), abs=0.05)
        assert means[name]["n"] == 36
    months = result_of(catalog, "groups", "--by", "month")["groups"]
    assert months[0] == {"group": "2024-01", "flights": 24, "maneuvers": 72}
    assert result_of(catalog, "groups", "--by", "inputs")["groups"][0]["group"] == "de"


def test_filters_hold_for_questions(catalog: Path) -> None:
    some = ("--airframe", "SN 1", "--until", "2024-01")
    found = result_of(catalog, "groups", "Cm_alpha", *some)
    assert found["groups"] == [{"group": "SN 1", "flights": 4, "maneuvers": 12}]
    assert found["values"][0]["n"] == 12


def test_only_the_latest_earned_value_of_a_maneuver_counts(tmp_path: Path) -> None:
    """What is unknown, held, not converged or joint is in no mean."""
    path = tmp_path / "fleet.sqlite"
    fleet = make_fleet(12, airframes=1, flights=8, maneuvers=2)
    store_fleet(path, fleet)
    first, second, third = (("SN 0-0", "M0"), ("SN 0-0", "M1"), ("SN 0-1", "M0"))
    wild = StoredEstimate(value=1e3, std=1e-6, cramer_rao=1e-6)

    def store(*maneuvers, estimate=wild, method="ml", **options):
        store_run(
            opened,
            EstimationRun(
                method=method, axis="lon", maneuvers=maneuvers, estimates={"Cm_alpha": estimate},
                **options,
            ),
        )  # fmt: skip

    with Catalog(path) as opened:
        store(first, estimate=StoredEstimate(value=None, status="not-identifiable"))
        store(second, converged=False)
        store(first, third)
        store(third, method="ee")
        found = select_fleet_values(opened, "Cm_alpha", ManeuverFilter())
        assert (len(found.values), found.unknown) == (14, 2)
        assert found.method == "ml"
        assert max(one.value for one in found.values) < 0.0
        store(third, estimate=StoredEstimate(value=-0.1, std=0.01))
        again = select_fleet_values(opened, "Cm_alpha", ManeuverFilter())
        latest = next(one for one in again.values if one.flight == "SN 0-1")
        assert latest.value == -0.1
        assert len(again.values) == 14
        store(third, estimate=StoredEstimate(value=-0.2, std=None, status="held"))
        held = select_fleet_values(opened, "Cm_alpha", ManeuverFilter())
        assert len(held.values) == 14


def test_wrong_questions_are_named(catalog: Path) -> None:
    for words, code in (
        (("trend", "Cm_alpha"), 2),
        (("trend", "Cm_alpha", "Cm_de", "--against", "mach"), 2),
        (("trend", "Cm_alpha", "--against", "match"), 2),
        (("groups", "--by", "color"), 2),
        (("groups", "--figure", "x.png"), 2),
        (("changes", "--figure", "x.bmp"), 2),
        (("maneuvers", "Cm_alpha"), 2),
        (("trend", "Cm_alfa", "--against", "mach"), 1),
        (("trend", "Cm_alpha", "--against", "reynolds"), 1),
        (("trend", "Cm_alpha", "--against", "mach", "--method", "ee"), 1),
        (("trend", "Cm_alpha", "--against", "mach", "--since", "2030"), 1),
        (("changes", "Cm_alpha", "--since", "2030"), 1),
    ):
        assert command("catalog", catalog, *words).returncode == code, words


def test_the_api_gives_what_the_command_writes(catalog: Path) -> None:
    trend = gsapp.trend(catalog, "Cm_alpha", "mach", since="2024-02")
    words = ("trend", "Cm_alpha", "--against", "mach", "--since", "2024-02")
    assert trend.to_dict() == result_of(catalog, *words)
    changes = gsapp.changes(catalog, "Cm_de", against="mach")
    assert changes.to_dict() == result_of(catalog, "changes", "Cm_de", "--against", "mach")
    rows = changes.tables["changes"].columns
    kinds = dict(zip(rows["group"], rows["kind"], strict=True))
    assert [name for name, kind in kinds.items() if kind == "step"] == ["SN 2"]
