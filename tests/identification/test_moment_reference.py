"""A weighed CG: instruments count from it, and moments are reported about the aircraft file's."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from gsapp.aircraft import load_aircraft
from gsapp.discrepancy.search_checks import record_remarks
from gsapp.dynamics.model import load_model
from gsapp.flight.flown_aircraft import apply_flight_info
from gsapp.flight.info import FlightInfo
from gsapp.foundation import FlightError
from gsapp.identification.campaign import CampaignSettings, run_campaign
from gsapp.identification.estimate_corrections import (
    common_cg_shift,
    derivatives_about_flown_cg,
    estimate_about_file_cg,
    model_about_flown_cg,
)
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.results import DerivativeEstimate, Estimate
from gsapp.quantities import Block
from tests.identification.virtual_maneuvers import Virtual, _measured, fly

B777 = load_aircraft("b777")
AHEAD = 0.025
"""How far the CG was ahead of where the aircraft file has it, m: 6 % of the chord."""


def weighed(x: float) -> FlightInfo:
    nose, main = B777.axles["nose"][0], B777.axles["left"][0]
    share = (x - main) / (nose - main)
    weight = B777.mass.mass * 9.80665
    return FlightInfo.model_validate(
        {
            "weighing": {
                "loads": {"nose": f"{share * weight} N", "main": f"{(1 - share) * weight} N"},
                "fuel": f"{B777.mass.fuel} kg",
            }
        }
    )


@cache
def moved_ahead(kind: str, seed: int) -> Virtual:
    model = load_model("b777").with_effect("mass.cg.x", {"x": AHEAD})
    return fly(seed, kind, model=model, aircraft=B777)


def flown(kind: str, seed: int, *, card: bool) -> Maneuver:
    """Return a maneuver of an aircraft whose CG is not where its file says.

    The motion comes from the simulator with its own effect of a moved CG; instruments sit where
    they sit in the aircraft, so closer to the CG by that much.
    """
    virtual = moved_ahead(kind, seed)
    truly = apply_flight_info(B777, weighed(AHEAD))
    random = np.random.default_rng(seed)
    measured = _measured(truly.aircraft, virtual.motion, random, 0.0, 0.3)
    block = Block(
        channels=tuple(measured),
        times=virtual.motion["time"],
        values=np.column_stack([*measured.values()]),
    )
    own = truly if card else apply_flight_info(B777, None)
    return replace(
        virtual.maneuver,
        block=block,
        aircraft=own.aircraft,
        cg_shift=own.cg_shift,
        remarks=own.remarks,
    )


@pytest.mark.parametrize("kind", ["lon", "lat"])
def test_a_weighed_cg_gives_the_derivatives_of_the_aircraft_file(kind: str) -> None:
    """All three methods, with and without the card, on motion that another code integrated.

    With the card each derivative is within four bounds of the truth about the file's CG; without
    it those that a CG shifts are not even near. Constants hold the accelerometers' biases.
    """
    truth = load_model("b777")
    moved = {"lon": "Cm_alpha", "lat": "Cn_beta"}[kind]
    for method in ("ml", "ee", "ftr"):
        settings = CampaignSettings(method=method)
        with_card, without = (
            run_campaign([flown(kind, 3, card=card)], settings) for card in (True, False)
        )
        found = with_card.results[0].estimate
        off = {
            name: (one.value - truth.derivative(name)) / one.std
            for name, one in found.derivatives.items()
            if one.value is not None and one.std and not name.endswith("_0")
        }
        assert len(off) == (9 if kind == "lon" else 15)
        assert max(map(abs, off.values())) < 4.0
        assert any("25 mm ahead" in remark for remark in with_card.remarks)
        wrong = without.results[0].estimate.derivatives[moved]
        assert abs(wrong.value - truth.derivative(moved)) > 5.0 * wrong.std


def test_what_is_held_is_about_the_file_too() -> None:
    truth = load_model("b777")
    one = replace(flown("lon", 4, card=True), inputs=("de",))
    held = {
        name: truth.derivative(name) for name in ("Cm_q", "CN_q", "CA_q", "Cm_alpha", "CN_alpha")
    }
    result = run_campaign([one], CampaignSettings(held=held))
    found = result.results[0].estimate
    assert found.derivatives["Cm_q"].status == "held"
    assert found.value("Cm_q") == pytest.approx(truth.derivative("Cm_q"), rel=1e-9)
    assert found.value("Cm_alpha") == pytest.approx(truth.derivative("Cm_alpha"), rel=1e-9)
    error = found.value("Cm_de") - truth.derivative("Cm_de")
    assert abs(error) < 4.0 * found.derivatives["Cm_de"].std


def estimate_of(**values: float | None) -> Estimate:
    random = np.random.default_rng(0)
    free = tuple(name for name, value in values.items() if value is not None)
    half = random.standard_normal((len(free), len(free)))
    covariance = half @ half.T
    return Estimate(
        method="ml",
        axis="lon",
        maneuvers=("1",),
        derivatives={
            name: DerivativeEstimate(
                value=value,
                std=None
                if value is None
                else float(covariance[free.index(name), free.index(name)]) ** 0.5,
                status="unknown" if value is None else "estimated",
            )
            for name, value in values.items()
        },
        free=free,
        covariance=covariance,
    )


def test_covariance_is_carried_over_as_samples_are() -> None:
    before = estimate_of(CN_alpha=4.0, CA_alpha=-0.2, Cm_alpha=-0.5, CN_0=0.3)
    shift = (0.03, 0.0, 0.02)
    after = estimate_about_file_cg(before, shift, B777.geometry)
    chord = B777.geometry.chord
    assert after.value("Cm_alpha") == pytest.approx(-0.5 + 0.03 / chord * 4.0 - 0.02 / chord * -0.2)
    draws = np.random.default_rng(1).multivariate_normal(
        [4.0, -0.2, -0.5, 0.3], before.covariance, size=20_000
    )
    draws[:, 2] += (0.03 * draws[:, 0] - 0.02 * draws[:, 1]) / chord
    assert after.covariance == pytest.approx(np.cov(draws.T), abs=0.15)
    assert after.derivatives["Cm_alpha"].std == pytest.approx(after.covariance[2, 2] ** 0.5)
    assert after.derivatives["CN_0"] == before.derivatives["CN_0"]


def test_there_and_back() -> None:
    model, shift = load_model("b777"), (-0.02, 0.0, 0.01)
    there = model_about_flown_cg(model, shift, B777.geometry)
    assert there.derivative("Cn_beta") != pytest.approx(model.derivative("Cn_beta"))
    back = estimate_about_file_cg(estimate_of(**there.derivatives), shift, B777.geometry)
    for name, value in model.derivatives.items():
        assert back.value(name) == pytest.approx(value, abs=1e-12)
    alone = derivatives_about_flown_cg({"Cm_q": -20.0}, shift, B777.geometry, {"CN_q": 5.0})
    assert alone == {"Cm_q": pytest.approx(-20.0 + 0.02 / B777.geometry.chord * 5.0)}


def test_what_cannot_be_carried_over_says_so() -> None:
    found = estimate_about_file_cg(
        estimate_of(CN_alpha=None, CA_alpha=0.1, Cm_alpha=-0.5), (0.02, 0.0, 0.0), B777.geometry
    )
    assert found.value("Cm_alpha") == -0.5
    assert "Cm_alpha" in found.warnings[0]
    one = flown("lon", 3, card=True)
    near: Any = replace(one, cg_shift=(AHEAD + 1e-3, 0.0, 0.0))
    assert common_cg_shift([one, near])[0] == pytest.approx(AHEAD + 0.5e-3, abs=1e-5)
    with pytest.raises(FlightError, match="CGs 25 mm apart"):
        common_cg_shift([one, replace(one, cg_shift=(0.0, 0.0, 0.0))])


def test_a_search_for_effects_is_told_of_the_cg() -> None:
    one = flown("lon", 3, card=True)
    told = record_remarks([one], one.aircraft)
    assert [text for text in told if "25 mm ahead" in text]
    apart = record_remarks([one, replace(one, cg_shift=(0.0, 0.0, 0.0))], one.aircraft)
    assert [text for text in apart if "25 mm apart" in text]
    plain = flown("lon", 3, card=False)
    assert not [text for text in record_remarks([plain], plain.aircraft) if "CG" in text]
