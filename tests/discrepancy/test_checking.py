"""Proves that each lack of the flights has its own sentence, before any search begins."""

from dataclasses import replace

import numpy as np
import pytest

from gsapp.discrepancy.disagreements import ModelErrorLocation, find_disagreements
from gsapp.discrepancy.investigation import Investigation
from gsapp.discrepancy.results import ManeuverHistories
from gsapp.discrepancy.search_checks import check_forced_effects, check_maneuvers, moving_inputs
from gsapp.discrepancy.settings import DiscrepancySettings
from gsapp.foundation import FlightError, GroundStationError, UnknownNameError
from gsapp.identification.maneuver import Maneuver
from tests.discrepancy.core_kit import AIRCRAFT, maneuver, with_channel


@pytest.fixture(scope="module")
def flown() -> list[Maneuver]:
    return [maneuver(seed, duration=4.0) for seed in (1, 2, 3, 4)]


def without(one: Maneuver, name: str) -> Maneuver:
    return with_channel(one, name, np.nan)


def told(maneuvers: list[Maneuver]) -> str:
    with pytest.raises(FlightError) as caught:
        check_maneuvers(maneuvers, AIRCRAFT)
    return str(caught.value)


def test_good_flights_pass(flown: list[Maneuver]) -> None:
    check_maneuvers(flown, AIRCRAFT)
    check_forced_effects(("aero.Cm.alpha2",), AIRCRAFT, flown)


def test_each_lack_has_its_own_sentence(flown: list[Maneuver]) -> None:
    other = replace(flown[2], aircraft=AIRCRAFT.model_copy(update={"name": "glider"}))
    cases = {
        "only one maneuver": flown[:1],
        "3 maneuvers are too few": flown[:3],
        "has no alpha;": [*flown[:3], without(flown[3], "alpha")],
        "has no q;": [*flown[:3], without(flown[3], "q")],
        "has no an;": [*flown[:3], without(flown[3], "an")],
        "was flown by 'glider'": [*flown[:2], other, flown[3]],
        "has 2 samples": [*flown[:3], replace(flown[3], block=flown[3].block.between(1.0, 1.03))],
    }
    sentences = {}
    for words, given in cases.items():
        sentence = told(given)
        assert words in sentence
        sentences[words] = sentence
    assert len(set(sentences.values())) == len(cases)
    # The maneuver is named, and what to do about it.
    assert "maneuver 4 of 'virtual'" in sentences["has no q;"]
    assert "maneuver 3 of 'virtual'" in sentences["was flown by 'glider'"]
    for words in ("only one maneuver", "3 maneuvers are too few"):
        assert "fly" in sentences[words]


def test_two_channels_that_lack_are_told_together(flown: list[Maneuver]) -> None:
    bare = without(without(flown[3], "q"), "an")
    assert "has no q, an;" in told([*flown[:3], bare])


def test_no_maneuvers_at_all() -> None:
    assert "0 maneuvers" in told([])


def test_an_investigation_says_the_same(flown: list[Maneuver]) -> None:
    with pytest.raises(FlightError, match="too few"):
        Investigation(flown[:2], AIRCRAFT)


def test_inputs_that_move(flown: list[Maneuver]) -> None:
    flown = [with_channel(one, "throttle", 0.5) for one in flown]
    assert moving_inputs(flown) == {"de", "da", "dr"}
    stepped = [
        with_channel(one, "throttle", 0.5 + 0.1 * number) for number, one in enumerate(flown)
    ]
    assert moving_inputs(stepped) == {"de", "da", "dr", "throttle"}
    humming = [with_channel(one, "throttle", 0.5 + 0.01 * np.sin(one.block.times)) for one in flown]
    assert moving_inputs(humming) == {"de", "da", "dr"}
    still = [with_channel(one, "de", 0.02) for one in flown]
    assert moving_inputs(still) == {"da", "dr"}
    flap = [*flown[:3], with_channel(flown[3], "flap", 0.3), with_channel(flown[2], "flap", 0.0)]
    assert "flap" in moving_inputs(flap)


@pytest.mark.parametrize(
    ("channel", "samples", "effect", "words"),
    [
        ("throttle", np.nan, "propulsion.Cm.throttle", "needs throttle, which is not recorded"),
        ("throttle", 0.6, "propulsion.Cm.throttle", "needs throttle to move"),
        ("da", 0.01, "aero.Cl.da3", "needs da to move"),
        ("beta", np.nan, "sensor.beta.delay", "beta"),
    ],
)
def test_effects_that_cannot_be_judged(
    flown: list[Maneuver], channel: str, samples: float, effect: str, words: str
) -> None:
    given = [with_channel(one, channel, samples) for one in flown]
    with pytest.raises(FlightError) as caught:
        check_forced_effects((effect,), AIRCRAFT, given)
    assert str(caught.value).startswith(f"'{effect}'")
    assert words in str(caught.value)
    # The same from a search, before anything is fitted.
    calls = []
    with pytest.raises(FlightError, match="cannot be evaluated"):
        Investigation(given, AIRCRAFT).run(
            DiscrepancySettings(forced=(effect,)), progress=calls.append
        )
    assert calls == []


def test_effects_that_do_not_exist(flown: list[Maneuver]) -> None:
    with pytest.raises(UnknownNameError, match=r"'aero\.Cm\.alpha2'"):
        check_forced_effects(("aero.Cm.alpha2x",), AIRCRAFT, flown)


def test_all_kept_out(flown: list[Maneuver]) -> None:
    every = tuple(one.id for one in flown)
    with pytest.raises(GroundStationError, match="all maneuvers"):
        Investigation(flown, AIRCRAFT).run(DiscrepancySettings(held_out=every))


def test_the_worst_second_of_a_record_shorter_than_one() -> None:
    count = 12
    times = 5.0 + 0.01 * np.arange(count)
    missing = np.zeros((count, 1))
    missing[-1] = 1.0
    nothing = np.zeros((count, 0))
    view = ManeuverHistories(
        id="1", flight="a", kind="de", held_out=False, times=times, channels=(),
        measured=nothing, computed=(nothing, nothing), coefficients=("Cm",),
        missing=(missing, missing), noise_floor={}, coefficient_noise_floor={"Cm": 0.1},
        conditions={},
    )  # fmt: skip
    place = ModelErrorLocation(coefficient="Cm", channel="", maneuver="1", gain=9.0, p_value=1e-6)
    (found,) = find_disagreements([view], [place], false_alarm=0.01)
    assert times[0] <= found.t_start <= found.t_end <= times[-1]
