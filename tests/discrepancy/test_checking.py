"""Proves that each lack of the flights, and what they tell of an effect, has its own sentence."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gsapp.discrepancy.disagreements import ModelErrorLocation, find_disagreements
from gsapp.discrepancy.investigation import Investigation
from gsapp.discrepancy.results import ManeuverHistories
from gsapp.discrepancy.search_checks import (
    check_forced_effects,
    check_maneuvers,
    comparable_maneuvers,
    moving_inputs,
)
from gsapp.discrepancy.settings import DiscrepancySettings
from gsapp.foundation import FlightError, GroundStationError, UnknownNameError
from gsapp.identification.filter_error.filter_error_fit import InformationMatrix
from gsapp.identification.maneuver import Maneuver
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import DEGREE
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
    for text, flights in cases.items():
        sentence = told(flights)
        assert text in sentence
        sentences[text] = sentence
    assert len(set(sentences.values())) == len(cases)
    # The maneuver is named, and what to do about it.
    assert "maneuver 4 of 'virtual'" in sentences["has no q;"]
    assert "maneuver 3 of 'virtual'" in sentences["was flown by 'glider'"]
    for text in ("only one maneuver", "3 maneuvers are too few"):
        assert "fly" in sentences[text]


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
    stepped = [with_channel(one, "throttle", 0.5 + 0.1 * index) for index, one in enumerate(flown)]
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


NAMES = ("a", "b", "c", "d", "e")


@dataclass(frozen=True)
class Rows:
    names: tuple[str, ...]
    columns: FloatArray
    residual: FloatArray

    def information(self) -> InformationMatrix:
        every = np.column_stack((self.columns, self.residual))
        return InformationMatrix(
            names=self.names, matrix=every.T @ every, samples=float(len(self.residual))
        )


def rows(seed: int, names: tuple[str, ...] = NAMES, n: int = 60) -> Rows:
    random = np.random.default_rng(seed)
    common = random.standard_normal((n, 1))
    sizes = 10.0 ** random.uniform(-3.0, 3.0, len(names))
    columns = (common + random.standard_normal((n, len(names)))) * sizes
    return Rows(names, columns, random.standard_normal(n) + 2.0 * common[:, 0])


def left_of(columns: FloatArray, target: FloatArray) -> FloatArray:
    return target - columns @ np.linalg.lstsq(columns, target, rcond=None)[0]


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000), st.permutations(NAMES), st.integers(1, 4))
def test_projection_is_least_squares(seed: int, order: list[str], count: int) -> None:
    one = rows(seed)
    nuisance = tuple(order[:count])
    found = one.information().projected(nuisance)
    out = one.columns[:, [NAMES.index(name) for name in nuisance]]
    kept = [name for name in NAMES if name not in nuisance]
    assert found.names == tuple(kept)
    assert found.samples == 60 - count
    every = np.column_stack((one.columns[:, [NAMES.index(name) for name in kept]], one.residual))
    left = left_of(out, every)
    sizes = np.sqrt(np.diag(every.T @ every))
    scaled = np.outer(sizes, sizes)
    assert found.matrix / scaled == pytest.approx(left.T @ left / scaled, abs=1e-8)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000))
def test_projecting_twice_is_projecting_once(seed: int) -> None:
    whole = rows(seed).information()
    sizes = np.sqrt(np.diag(whole.projected(("a", "c")).matrix))
    once = whole.projected(("a", "c")).matrix / np.outer(sizes, sizes)
    for first, second in (("a", "c"), ("c", "a")):
        twice = whole.projected((first,)).projected((second,))
        assert twice.names == ("b", "d", "e")
        assert twice.matrix / np.outer(sizes, sizes) == pytest.approx(once, abs=1e-8)
        assert twice.samples == 58


def test_solution_is_least_squares_with_its_covariance() -> None:
    one = rows(3)
    for names in (NAMES, ("d", "b")):
        X = one.columns[:, [NAMES.index(name) for name in names]]
        values, covariance = one.information().solution(names)
        assert values == pytest.approx(np.linalg.lstsq(X, one.residual, rcond=None)[0], rel=1e-6)
        sizes = np.sqrt(np.diag(covariance))
        expected = np.linalg.inv(X.T @ X) / np.outer(sizes, sizes)
        assert covariance / np.outer(sizes, sizes) == pytest.approx(expected, abs=1e-6)


def test_misfit_is_the_sum_of_squares_with_given_values() -> None:
    one = rows(4)
    values = {"d": 0.3, "a": -2.0}
    X = one.columns[:, [3, 0]]
    left = one.residual - X @ np.array([0.3, -2.0])
    assert one.information().misfit(values) == pytest.approx(float(left @ left))
    assert one.information().misfit({}) == pytest.approx(float(one.residual @ one.residual))
    best, _ = one.information().solution(NAMES)
    assert one.information().misfit(dict(zip(NAMES, best, strict=True))) == pytest.approx(
        float(one.information().projected(NAMES).matrix[-1, -1])
    )


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000))
def test_maneuvers_add_up(seed: int) -> None:
    one, other = rows(seed, ("a", "b", "c")), rows(seed + 1, ("d", "b"), n=40)
    total = one.information() + other.information()
    assert total.names == ("a", "b", "c", "d")
    assert total.samples == 100
    stacked = np.zeros((100, 5))
    stacked[:60, [0, 1, 2]], stacked[60:, [3, 1]] = one.columns, other.columns
    stacked[:60, 4], stacked[60:, 4] = one.residual, other.residual
    assert total.matrix == pytest.approx(stacked.T @ stacked, rel=1e-9)


def test_the_order_of_maneuvers_changes_names_only() -> None:
    one, other = rows(7, ("a", "b", "c")).information(), rows(8, ("d", "b")).information()
    first, second = one + other, other + one
    assert set(first.names) == set(second.names)
    places = [*second.indices(first.names), -1]
    assert np.array_equal(first.matrix, second.matrix[np.ix_(places, places)])


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000), st.floats(-5.0, 5.0), st.floats(0.01, 10.0))
def test_a_prior_is_one_more_row(seed: int, value: float, std: float) -> None:
    """Knowing b = value with a deviation is a measurement of it; unknown names do not count."""
    one = rows(seed)
    found = one.information().with_priors({"b": (value, std), "unknown": (1.0, 1.0)})
    extra = np.zeros((1, 6))
    extra[0, 1], extra[0, 5] = 1.0 / std, value / std
    every = np.vstack((np.column_stack((one.columns, one.residual)), extra))
    assert found.names == NAMES
    assert found.matrix == pytest.approx(every.T @ every, rel=1e-9)
    assert found.samples == 60


def test_gains_are_what_a_refit_with_one_more_column_takes_off() -> None:
    one = rows(11)
    own = one.columns[:, :2]
    left = one.information().projected(("a", "b"))
    gain, size, std = left.gains(one.information())
    without = float(np.sum(left_of(own, one.residual) ** 2))
    for index, column in enumerate((2, 3, 4)):
        X = np.column_stack((own, one.columns[:, column]))
        with_it = float(np.sum(left_of(X, one.residual) ** 2))
        assert gain[index] == pytest.approx(without - with_it, rel=1e-6, abs=1e-9)
        assert size[index] == pytest.approx(
            np.linalg.lstsq(X, one.residual, rcond=None)[0][-1], rel=1e-6
        )
        assert std[index] == pytest.approx(np.sqrt(np.linalg.inv(X.T @ X)[-1, -1]), rel=1e-6)


def test_what_the_others_hold_already_gains_nothing() -> None:
    """A column that the model's parameters make up: no gain, and no size that could be told.

    One that is zero altogether (an effect that cannot act here) likewise.
    """
    one = rows(12)
    double = one.columns[:, 0] * 3.0 - 0.01 * one.columns[:, 1]
    columns = np.column_stack((one.columns, double, np.zeros(60)))
    wide = Rows((*NAMES, "double", "still"), columns, one.residual).information()
    gain, size, std = wide.projected(("a", "b")).gains(wide)
    assert gain[3:].tolist() == [0.0, 0.0]
    assert size[3:].tolist() == [0.0, 0.0]
    assert np.isinf(std[3:]).all()
    assert np.isfinite(std[:3]).all()
    # And parameters that are one and the same do not break a solution.
    values, covariance = wide.solution(("a", "b", "double"))
    assert np.isfinite(values).all()
    assert np.isfinite(covariance).all()
    X = one.columns[:, :2]
    assert wide.misfit(dict(zip(("a", "b", "double"), values, strict=True))) == pytest.approx(
        float(np.sum(left_of(X, one.residual) ** 2)), rel=1e-6
    )


def test_cosines_tell_what_looks_alike() -> None:
    """Of what is left once the model took its part: 1 with itself, -1 with its opposite."""
    one = rows(13)
    mirrored = -4.0 * one.columns[:, 2] + 0.3 * one.columns[:, 0]
    wide = Rows((*NAMES, "m"), np.column_stack((one.columns, mirrored)), one.residual)
    left = wide.information().projected(("a", "b"))
    cosines = dict(zip(left.names, left.cosines("c"), strict=True))
    assert cosines["c"] == pytest.approx(1.0)
    assert cosines["m"] == pytest.approx(-1.0, abs=1e-7)
    c, d = (left_of(one.columns[:, :2], one.columns[:, k]) for k in (2, 3))
    assert cosines["d"] == pytest.approx(float(c @ d / np.sqrt((c @ c) * (d @ d))), rel=1e-6)


def test_what_nothing_is_known_of_stays_where_it_is() -> None:
    one = rows(4)
    blind = Rows(NAMES, one.columns * (np.array(NAMES) != "c"), one.residual)
    moves, covariance = blind.information().solution(NAMES)
    others = [name for name in NAMES if name != "c"]
    expected, bounds = blind.information().solution(others)
    kept = [NAMES.index(name) for name in others]
    assert moves[NAMES.index("c")] == 0.0
    assert moves[kept] == pytest.approx(expected, rel=1e-6)
    assert covariance[np.ix_(kept, kept)] == pytest.approx(bounds, rel=1e-6)
    assert covariance[NAMES.index("c"), NAMES.index("c")] > 1e6


def test_steps_of_the_throttle_take_part_where_the_flap_is_as_usual() -> None:
    """Those of an approach do not; maneuvers that move a surface always do."""
    clean = [maneuver(seed, duration=3.0) for seed in (1, 2)]
    throttle = replace(maneuver(3, duration=3.0), inputs=("throttle",))
    approach = with_channel(replace(throttle, id="approach"), "flap", 20.0 * DEGREE)
    landing = with_channel(replace(clean[1], id="landing"), "flap", 20.0 * DEGREE)
    assert comparable_maneuvers([*clean, throttle, approach]) == [*clean, throttle]
    every = [*clean, landing, throttle, approach]
    assert comparable_maneuvers(every) == every
