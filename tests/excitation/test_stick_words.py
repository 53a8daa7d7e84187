"""Degrees become words that a pilot flies, and the words mean nearly the same degrees."""

import math

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from gsapp.aircraft import load_aircraft
from gsapp.excitation.test_points.stick_text import (
    STICK_SHARES,
    format_amplitude_change,
    format_sticks,
    format_width_change,
    needs_high_rate,
)
from gsapp.flight.cards import load_cards
from gsapp.quantities.constants import DEGREE

B777 = load_aircraft("b777")
SURFACES = st.sampled_from(["de", "da", "dr"])

MEANT = {
    "50 % smaller": 0.5,
    "35 % smaller": 0.65,
    "25 % smaller": 0.75,
    "10 % smaller": 0.9,
    "10 % larger": 1.1,
    "25 % larger": 1.25,
    "35 % larger": 1.35,
    "50 % larger": 1.5,
    "twice as large": 2.0,
    "three times as large": 3.0,
}


def format_stick(aircraft, surface, size, rate_switch=None):
    return format_sticks(aircraft, {surface: size}, rate_switch=rate_switch)[surface]


def _degrees(text: str, surface: str) -> float:
    way, rate = text.split(", ", 1)
    share = next(size for said, size in STICK_SHARES.items() if way.startswith(said))
    control = getattr(B777.controls, surface)
    return abs(share * (control.full_stick_high if "high" in rate else control.full_stick_low))


@given(surface=SURFACES, degrees=st.floats(0.1, 25.0), switch=st.sampled_from([None, 0.0, 1.0]))
def test_words_round_trip(surface: str, degrees: float, switch: float | None) -> None:
    control = getattr(B777.controls, surface)
    assume(degrees * DEGREE <= 1.05 * abs(control.full_stick_high))
    text = format_stick(B777, surface, degrees * DEGREE, rate_switch=switch)
    full = abs(control.full_stick_high if "high" in text else control.full_stick_low)
    assert abs(_degrees(text, surface) - degrees * DEGREE) / full < 1.0 / 6.0


@given(surface=SURFACES, degrees=st.floats(0.1, 25.0))
def test_the_rate_lets_the_stick_move_well_where_one_does(surface: str, degrees: float) -> None:
    control = getattr(B777.controls, surface)
    sizes = {
        "high": degrees * DEGREE / abs(control.full_stick_high),
        "low": degrees * DEGREE / abs(control.full_stick_low),
    }
    easy = [rate for rate, share in sizes.items() if 1.0 / 3.0 <= share <= 0.75]
    assume(easy)
    text = format_stick(B777, surface, degrees * DEGREE)
    assert any(f"{rate} rate" in text for rate in easy)


def test_a_measured_switch_stays_where_it_can() -> None:
    assert format_stick(B777, "da", 6.0 * DEGREE) == "half stick, low rate"
    assert format_stick(B777, "da", 6.0 * DEGREE, rate_switch=1.0) == "third of stick, high rate"
    assert format_stick(B777, "da", 6.0 * DEGREE, rate_switch=0.0) == "half stick, low rate"
    assert format_stick(B777, "da", 19.0 * DEGREE, rate_switch=0.0) == "full stick, high rate"
    assert format_stick(B777, "de", 1.0 * DEGREE, rate_switch=1.0) == "tenth of stick, low rate"
    assert format_stick(B777, "dr", 12.0 * DEGREE, rate_switch=math.nan) == "half rudder, high rate"


def test_one_switch_serves_all_surfaces_of_an_input() -> None:
    card = load_cards("b777").card("C1")
    text = format_sticks(B777, card.amplitudes, rate_switch=1.0)
    assert text == {"da": "third of stick, high rate", "dr": "third of rudder, high rate"}
    free = format_sticks(B777, card.amplitudes)
    assert len({said.rpartition(", ")[2] for said in free.values()}) == 1
    assert needs_high_rate(B777, {"da": 18.0 * DEGREE, "dr": 8.0 * DEGREE}, rate_switch=0.0)


def test_more_than_the_stick_gives_is_said() -> None:
    assert format_stick(B777, "dr", 30.0 * DEGREE) == "full rudder, high rate, and more than that"
    assert format_stick(None, "dr", 30.0 * DEGREE) == "30 deg"


def test_without_dual_rates_no_switch_is_named() -> None:
    even = B777.controls.de.model_copy(update={"full_stick_low": B777.controls.de.full_stick_high})
    aircraft = B777.model_copy(update={"controls": B777.controls.model_copy(update={"de": even})})
    assert format_stick(aircraft, "de", 10.0 * DEGREE) == "half stick"


@given(factor=st.floats(0.45, 3.4))
def test_factors_are_named_by_the_nearest(factor: float) -> None:
    assume(abs(factor - 1.0) > 0.06)
    meant = MEANT[format_amplitude_change(factor)]
    assert abs(meant / factor - 1.0) < 0.24
    assert (meant - 1.0) * (factor - 1.0) > 0.0


@pytest.mark.parametrize(
    ("factor", "words"),
    [(1.5, "50 % larger"), (2.1, "twice as large"), (0.66, "35 % smaller"), (0.5, "50 % smaller"),
     (9.0, "much larger"), (0.1, "much smaller"), (1.1, "10 % larger"), (0.91, "10 % smaller")],
)  # fmt: skip
def test_factors_in_words(factor: float, words: str) -> None:
    assert format_amplitude_change(factor) == words


def test_widths_in_words() -> None:
    assert format_width_change(0.8, 0.4) == "quicker: 0.4 s each way"
    assert format_width_change(0.3, 0.5) == "hold longer: 0.5 s each way"
    assert format_width_change(0.5, 0.5) == "0.5 s each way"
