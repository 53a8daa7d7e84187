"""Test points lie on the trim curve, are refused off it, led to, and captured when held."""

import itertools
import re

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.simulation import ControlCommands, Simulator
from gsapp.dynamics.trim import trim
from gsapp.excitation.flight_rows import FlightRows, rows_from_block
from gsapp.excitation.settings import INPUTS
from gsapp.excitation.test_points.capture import TestPointCapture, guidance_text
from gsapp.excitation.test_points.point import (
    TestPoint,
    TestPointError,
    TrimCurve,
    create_point_at,
    create_test_point,
)
from gsapp.flight.cards import TestCard, load_cards
from gsapp.foundation import FlightError
from gsapp.quantities import Block, FloatArray
from gsapp.quantities.constants import DEGREE, FOOT
from tests.excitation.points_kit import b777, density, start

RATE = 100.0
CURVE = TrimCurve(*b777())
IN_AIR = TrimCurve(*b777(), rho=density())


# --- the curve ----------------------------------------------------------------------------------


@settings(max_examples=15, deadline=None)
@given(share=st.floats(0.0, 1.0), mass=st.floats(19.0, 22.0))
def test_the_curve_is_what_trim_finds(share: float, mass: float) -> None:
    """Anywhere on it, at any weight: alpha within 0.02 deg, throttle within half a percent."""
    aircraft, model = b777()
    curve = TrimCurve(aircraft, model, mass=mass, rho=1.1)
    assert curve.speed_range is not None
    slow, fast = curve.speed_range
    speed = slow + share * (fast - slow)
    level = curve.level_flight_at(speed)
    truth = trim(FlightModel(aircraft, model), V=speed, mass=mass, rho=1.1)
    assert level.alpha == pytest.approx(float(truth.polar.alpha), abs=0.02 * DEGREE)
    assert level.throttle == pytest.approx(truth.controls["throttle"], abs=0.005)
    assert level.elevator == pytest.approx(truth.controls["de"], abs=0.02 * DEGREE)
    assert curve.speed_at(level.alpha) == pytest.approx(speed, abs=0.02)


@pytest.mark.parametrize("speed", [70.0, 105.0])
def test_flown_as_the_curve_says_the_simulator_stays_level(speed: float) -> None:
    level = IN_AIR.level_flight_at(speed * FOOT)
    simulator = Simulator(*b777())
    still = trim(FlightModel(*b777()), V=level.speed, rho=density())
    controls = start(simulator, still)
    controls.update(de=level.elevator, throttle=level.throttle)
    simulator.start_in_air(
        V=level.speed,
        alpha=level.alpha,
        attitude=(0.0, level.alpha, 0.0),
        height=100.0,
        commands=ControlCommands(**controls),
    )
    for _ in range(300):
        simulator.step(ControlCommands(**controls))
    now = simulator.sample()
    assert now["V"] == pytest.approx(level.speed, abs=0.1)
    assert now["alpha"] == pytest.approx(level.alpha, abs=0.1 * DEGREE)
    assert now["height"] == pytest.approx(100.0, abs=0.3)


def test_the_ends_of_the_curve_are_where_trim_gives_up() -> None:
    aircraft, model = b777()
    assert CURVE.speed_range is not None
    slow, fast = CURVE.speed_range
    assert slow == pytest.approx(aircraft.limits.stall_speed)
    with pytest.raises(FlightError, match="throttle"):
        trim(FlightModel(aircraft, model), V=1.01 * fast)
    for speed in (0.99 * slow, 1.01 * fast):
        assert CURVE.alpha_at(speed) is None
    assert CURVE.speed_at(25.0 * DEGREE) is None


def test_weight_and_air_move_the_curve() -> None:
    aircraft, model = b777()
    speed = 100.0 * FOOT
    usual = CURVE.alpha_at(speed)
    lighter = TrimCurve(aircraft, model, mass=19.5).alpha_at(speed)
    thinner = TrimCurve(aircraft, model, rho=1.1).alpha_at(speed)
    assert lighter < usual - 0.1 * DEGREE
    assert thinner > usual + 0.1 * DEGREE


def test_alpha_as_measured_shifts_the_curve_by_its_median() -> None:
    speeds = [90.0 * FOOT, 100.0 * FOOT, 110.0 * FOOT]
    flown = [
        (speed, (CURVE.alpha_at(speed) or 0.0) + miss * DEGREE)
        for speed, miss in zip(speeds, (1.0, 1.1, 6.0), strict=True)
    ]
    moved = CURVE.with_measured_alpha(flown)
    assert moved.alpha_shift == pytest.approx(1.1 * DEGREE)
    assert moved.alpha_at(speeds[0]) == pytest.approx(flown[0][1] + 0.1 * DEGREE)
    assert moved.speed_at(flown[0][1] + 0.1 * DEGREE) == pytest.approx(speeds[0], abs=0.02)
    assert CURVE.with_measured_alpha(flown[:2]) is CURVE
    wrong = [(speed, alpha + 20.0 * DEGREE) for speed, alpha in flown]
    assert CURVE.with_measured_alpha(wrong).alpha_shift == INPUTS.max_alpha_shift


def test_without_a_model_that_flies_nothing_is_told() -> None:
    aircraft, model = b777()
    for curve, why in (
        (TrimCurve(aircraft, None), "no model"),
        (TrimCurve(aircraft, model.with_derivatives({"Cm_de": 1.0})), "Cm_de"),
    ):
        assert curve.speed_range is None
        assert curve.alpha_at(30.0) is None
        assert curve.speed_at(0.05) is None
        assert why in curve.problem


# --- making -------------------------------------------------------------------------------------


def _card(speed: str, alpha: str | None = None) -> TestCard:
    return TestCard(
        id="E9", speed=speed, alpha=alpha, surfaces=("de",), amplitude="4 deg", width="0.5 s"
    )


def test_a_card_is_completed_by_the_curve() -> None:
    point = create_test_point(_card("100 ft/s"), CURVE)
    assert point.alpha == CURVE.alpha_at(100.0 * FOOT)
    assert point.throttle == pytest.approx(0.523, abs=0.005)
    assert (point.card, point.remarks) == ("E9", ())
    for card in load_cards("b777").cards:
        assert create_test_point(card, CURVE).speed == card.speed


@settings(max_examples=40, deadline=None)
@given(speed=st.floats(65.0, 130.0), miss=st.floats(-8.0, 8.0))
def test_a_pair_off_the_curve_is_refused_with_the_trimmed_value(speed: float, miss: float) -> None:
    """Beyond 1.5 deg it is refused, and what the sentence says to write is then taken."""
    aircraft, model = b777()
    trimmed = float(trim(FlightModel(aircraft, model), V=speed * FOOT).polar.alpha) / DEGREE
    card = _card(f"{speed} ft/s", f"{trimmed + miss} deg")
    assume(abs(abs(miss) - 1.5) > 0.02)
    if abs(miss) < 1.5:
        assert create_test_point(card, CURVE).alpha == pytest.approx((trimmed + miss) * DEGREE)
        return
    with pytest.raises(TestPointError) as refused:
        create_test_point(card, CURVE)
    told = re.search(r"; write (-?[\d.]+) deg or leave alpha out", str(refused.value))
    assert float(told[1]) == pytest.approx(trimmed, abs=0.06)
    create_test_point(_card(f"{speed} ft/s", f"{told[1]} deg"), CURVE)


def test_the_sentence_is_in_the_units_of_the_user() -> None:
    card = _card("100 ft/s", "8 deg")
    with pytest.raises(TestPointError) as us:
        create_test_point(card, CURVE)
    assert "alpha 3.7 deg" in str(us.value)
    with pytest.raises(ValueError, match=r"30\.5 m/s"):
        create_test_point(card, CURVE, system="SI")
    assert isinstance(us.value, FlightError)


@pytest.mark.parametrize(
    ("wish", "words"),
    [
        ({"speed": 50.0 * FOOT}, r"the slowest is 61 ft/s; write more"),
        ({"speed": 150.0 * FOOT}, r"the fastest is 137\.\d ft/s; write less"),
        ({"alpha": 20.0 * DEGREE}, r"1\.6 deg at 137\.\d ft/s to 11\.2 deg at 61 ft/s"),
        ({}, r"write one of them"),
    ],
)
def test_what_cannot_be_flown_is_refused(wish: dict[str, float], words: str) -> None:
    with pytest.raises(TestPointError, match=words):
        create_point_at(curve=CURVE, **wish)


def test_alpha_alone_gets_its_speed() -> None:
    point = create_point_at(alpha=5.0 * DEGREE, curve=CURVE)
    assert point.speed is not None
    assert CURVE.alpha_at(point.speed) == pytest.approx(5.0 * DEGREE, abs=0.01 * DEGREE)


def test_without_a_model_a_point_stands_and_says_what_is_not_known() -> None:
    bare = create_test_point(_card("100 ft/s"), None)
    assert (bare.speed, bare.alpha, bare.throttle) == (pytest.approx(30.48), None, None)
    assert "angle of attack" in bare.remarks[0]
    pair = create_test_point(_card("100 ft/s", "12 deg"), TrimCurve(b777()[0], None))
    assert pair.alpha == pytest.approx(12.0 * DEGREE)
    assert "speed and angle" in pair.remarks[0]


# --- guidance -----------------------------------------------------------------------------------


def test_guidance_is_short_and_leads_the_right_way() -> None:
    """By speed, by alpha where no speed is measured, and nothing once near enough."""
    point = create_point_at(speed=100.0 * FOOT, curve=CURVE)

    def at(speed: float | None, alpha: float | None = None, system: str = "US") -> str:
        return guidance_text(
            point,
            speed=None if speed is None else speed * FOOT,
            alpha=None if alpha is None else alpha * DEGREE,
            system=system,
        )

    assert at(97.0) == "3 ft/s slow: a little power"
    assert at(104.0) == "4 ft/s fast: ease the throttle"
    assert at(80.0) == "20 ft/s slow: power, then 52 %"
    assert at(120.0) == "20 ft/s fast: throttle back, then 52 %"
    assert at(120.0, system="SI") == "6 m/s fast: throttle back, then 52 %"
    assert at(101.0) == ""
    assert at(None, 5.0) == "alpha high 1.3 deg: a little power"
    assert at(None, 9.0) == "alpha high 5 deg: power, then 52 %"
    assert at(100.0, 7.0) == "alpha high 3 deg"
    assert at(100.0, 1.0) == "alpha low 3 deg"
    assert at(100.0, 4.5) == ""
    assert at(float("nan"), float("nan")) == ""
    assert guidance_text(None, speed=30.0, alpha=None) == ""


# --- capture ------------------------------------------------------------------------------------


def _point(speed: float, card: str) -> TestPoint:
    return TestPoint(
        card=card, speed=speed, speed_tolerance=5.0 * FOOT, alpha_tolerance=1.5 * DEGREE
    )


SLOW, USUAL, NEXT = _point(26.0, "E2"), _point(30.0, "E1"), _point(31.0, "C1")


def _rows(speed: FloatArray, alpha: FloatArray | None = None) -> FlightRows:
    times = np.arange(speed.size) / RATE
    flow = np.full(speed.size, 0.06) if alpha is None else alpha
    return rows_from_block(
        Block(channels=("V", "alpha"), times=times, values=np.column_stack((speed, flow))), RATE
    )


def _captured(rows: FlightRows, points: tuple[TestPoint, ...]) -> list[str]:
    capture, found = TestPointCapture(points), []
    for first in range(0, len(rows), 5):
        capture.process_rows(rows.slice_rows(first, first + 5))
        found.append(capture.captured.card if capture.captured else "")
    return found


def test_a_point_is_captured_after_two_seconds_and_left_when_left() -> None:
    speed = np.concatenate((np.full(300, 30.2), np.linspace(30.2, 20.0, 200), np.full(100, 20.0)))
    found = _captured(_rows(speed), (SLOW, USUAL, NEXT))
    first = found.index("E1")
    assert first * 0.05 == pytest.approx(INPUTS.capture_time, abs=0.1)
    assert set(found[:first]) == {""}
    assert set(found[first:60]) == {"E1"}
    assert found[-1] == ""


def test_flying_through_a_point_captures_nothing() -> None:
    assert set(_captured(_rows(np.linspace(20.0, 36.0, 1600)), (SLOW, USUAL))) == {""}


def test_the_nearest_is_captured_and_forgotten_once_it_is_not_wanted() -> None:
    capture = TestPointCapture((USUAL, NEXT))
    capture.process_rows(_rows(np.full(300, 30.8)))
    assert capture.captured == NEXT
    capture.set_points((USUAL,))
    assert capture.captured is None


def test_missing_speed_holds_nothing_and_alpha_serves_where_it_is_asked_for() -> None:
    nothing = np.full(400, np.nan)
    by_alpha = TestPoint(
        card="S1", alpha=8.0 * DEGREE, speed_tolerance=1.5, alpha_tolerance=1.5 * DEGREE
    )
    capture = TestPointCapture((USUAL, by_alpha))
    capture.process_rows(_rows(nothing, np.full(400, 8.3 * DEGREE)))
    assert capture.captured == by_alpha
    capture.restart()
    assert capture.captured is None


@settings(max_examples=40, deadline=None)
@given(cuts=st.lists(st.integers(1, 1599), max_size=8), seed=st.integers(5000, 5100))
def test_cutting_the_rows_changes_nothing(cuts: list[int], seed: int) -> None:
    random = np.random.default_rng(seed)
    levels = np.repeat(random.choice([24.0, 26.3, 29.6, 30.6, 31.2], 3), 2)
    speed = np.interp(np.arange(1600), [0, 400, 600, 1000, 1200, 1599], levels)
    rows = _rows(speed + 0.05 * random.standard_normal(1600))
    points = (SLOW, USUAL, NEXT)
    pieces, captured = TestPointCapture(points), []
    for first, last in itertools.pairwise(sorted({0, *cuts, 1600})):
        pieces.process_rows(rows.slice_rows(first, last))
        fresh = TestPointCapture(points)
        fresh.process_rows(rows.slice_rows(0, last))
        assert pieces.captured == fresh.captured
        captured.append(pieces.captured)
    assert set(levels[-2:]) <= {24.0} or captured[-1] is not None
