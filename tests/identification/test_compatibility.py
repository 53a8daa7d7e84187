"""Instruments against one another: truth recovered, wrong signs found, no false alarm."""

import warnings
from collections import defaultdict
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gsapp.aircraft import load_aircraft
from gsapp.flight import Flight
from gsapp.foundation import FlightError, UnknownNameError
from gsapp.identification.compatibility import (
    CompatibilitySettings,
    InstrumentError,
    check_compatibility,
    correct_instruments,
    find_instrument_errors,
)
from gsapp.identification.compatibility.kinematics import integrate_rotation_matrices
from gsapp.identification.compatibility.results import format_error_with_bound
from gsapp.identification.maneuver import Maneuver, cut_maneuver
from gsapp.quantities.constants import DEGREE, GRAVITY
from gsapp.virtual.virtual_flight import VirtualFlight
from gsapp.virtual.virtual_flight import simulate_flight as fly_whole
from tests.identification.virtual_instruments import with_channels, with_errors, with_signs
from tests.identification.virtual_maneuvers import edited, fly, without

B777 = load_aircraft("b777")


def maneuvers_of(flown: VirtualFlight) -> list[Maneuver]:
    flight = Flight(name="virtual", path=Path("virtual"), block=flown.measured, sources={})
    return [
        cut_maneuver(
            flight, B777, one.t_start - 1.0, one.t_end + 1.0, id=str(index), inputs=one.inputs
        )
        for index, one in enumerate(flown.maneuvers)
    ]


def test_rotations_follow_the_rates() -> None:
    rng = np.random.default_rng(0)
    rates = np.cumsum(rng.standard_normal((40, 3)), axis=0) * 0.2
    found = integrate_rotation_matrices(rates, 0.01)
    total = Rotation.identity()
    steps = 0.5 * (rates[1:] + rates[:-1])
    steps[1:-1] = (13.0 * (rates[1:-2] + rates[2:-1]) - rates[:-3] - rates[3:]) / 24.0
    for k, step in enumerate(steps):
        total = total * Rotation.from_rotvec(0.01 * step)
        np.testing.assert_allclose(found[k + 1], total.as_matrix(), atol=1e-12)


ERRORS = (
    "p.bias", "q.bias", "r.bias", "ax.bias", "ay.bias", "an.bias", "V.scale",
    "alpha.bias", "alpha.scale", "alpha.delay", "beta.bias", "beta.scale", "beta.delay",
)  # fmt: skip


@pytest.mark.long
def test_errors_are_recovered_within_their_bounds() -> None:
    ratios: dict[str, list[float]] = defaultdict(list)
    for seed in range(300, 308):
        maneuver, truth = with_errors(seed, "both", ERRORS, gyros=0.3)
        found = check_compatibility([maneuver], settings=CompatibilitySettings(try_signs=False))
        for name, value in truth.items():
            one = found.parameters[name]
            if one.value is not None and one.std is not None:
                ratios[name].append((one.value - value) / one.std)
    for name in ("p.bias", "q.bias", "an.bias", "alpha.scale", "beta.scale", "beta.delay"):
        assert len(ratios[name]) >= 6, f"{name} is mostly not seen"
    every = np.concatenate([np.array(values) for values in ratios.values()])
    assert 0.8 < np.sqrt(np.mean(every**2)) < 1.3
    assert np.abs(every).max() < 5.0


def at_wrong_position(maneuver: Maneuver, alpha: float, beta: float) -> Maneuver:
    """Return a maneuver whose aircraft file puts the vanes so far behind where they are, m."""
    vanes = [
        InstrumentError(
            channel=name, kind="position", value=-ahead, std=0.0, position=(0.0, 0.0, 0.0)
        )
        for name, ahead in (("alpha", alpha), ("beta", beta))
    ]
    return correct_instruments(maneuver, vanes)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_vanes_are_found_where_they_are(
    flown_short: Callable[[int], VirtualFlight], seed: int
) -> None:
    maneuvers = maneuvers_of(flown_short(seed))
    assert find_instrument_errors(maneuvers) == ()
    wrong = [at_wrong_position(one, 1.0, 0.8) for one in maneuvers]
    alpha, beta = find_instrument_errors(wrong)
    assert alpha.value == pytest.approx(1.0, abs=4.0 * alpha.std)
    assert beta.value == pytest.approx(0.8, abs=4.0 * beta.std)
    assert max(alpha.std, beta.std) < 0.1
    assert alpha.position[0] == pytest.approx(B777.sensors.alpha_vane.position[0], abs=0.1)


@pytest.mark.parametrize(
    ("name", "delay"),
    [("q", 0.03), ("alpha", 0.03), ("beta", 0.03), ("r", 0.03)],
)
def test_a_late_channel_is_found_and_then_instruments_agree(
    flown_short: Callable[[int], VirtualFlight], name: str, delay: float
) -> None:
    maneuvers = maneuvers_of(flown_short(1))
    late = [
        edited(one, **{name: np.interp(one.block.times - delay, one.block.times, one.block[name])})
        for one in maneuvers
    ]
    (found,) = find_instrument_errors(late)
    assert f"{name}.delay" in (f"{found.channel}.{found.kind}", *found.alternatives)
    if found.kind == "delay":
        assert found.value == pytest.approx(delay, abs=5.0 * found.std)
    assert find_instrument_errors([correct_instruments(one, [found]) for one in late]) == ()


@pytest.mark.parametrize("seed", [961, 962])
def test_late_gyros_are_not_asserted_to_be_a_vane_elsewhere(seed: int) -> None:
    late = [
        edited(
            one,
            **{
                name: np.interp(one.block.times - 0.025, one.block.times, one.block[name])
                for name in ("p", "r")
            },
        )
        for one in (fly(10 * seed + k, "lat", color=0.5, gust=0.2).maneuver for k in range(2))
    ]
    (found,) = find_instrument_errors(late)
    assert (found.kind, found.is_ambiguous) == ("position", True)
    delay = next(one["r.delay"] for one in found.rivals if "r.delay" in one)
    assert delay == pytest.approx(0.025, abs=0.008)
    # Nothing for the aircraft file until a maneuver tells; the sentence says which.
    assert found.file_entry is None
    assert "two speeds" in found.text
    assert "r is " in found.text


@pytest.mark.parametrize(
    ("channel", "kind", "value"),
    [("alpha", "bias", 1.5 * DEGREE), ("alpha", "scale", 1.15), ("beta", "scale", 0.9)],
)
def test_zero_and_upwash_of_a_vane_are_found_and_then_instruments_agree(
    flown_short: Callable[[int], VirtualFlight], channel: str, kind: str, value: float
) -> None:
    scale, bias = (1.0, value) if kind == "bias" else (value, 0.0)
    wrong = [
        edited(one, **{channel: lambda shown: scale * shown + bias})
        for one in maneuvers_of(flown_short(2))
    ]
    (found,) = find_instrument_errors(wrong)
    assert (found.channel, found.kind) == (channel, kind)
    assert found.value == pytest.approx(value, abs=5.0 * found.std)
    assert found.file_entry == (
        "bias" if kind == "bias" else "upwash",
        pytest.approx(found.value, rel=1e-12),
    )
    assert "tilt of the gyros" in found.text or ".scale" in found.text
    assert find_instrument_errors([correct_instruments(one, [found]) for one in wrong]) == ()


def test_nothing_is_said_of_beta_where_only_the_elevator_moved(
    flown_short: Callable[[int], VirtualFlight],
) -> None:
    # In strong gusts the beta vane seemed to show twice the sideslip.
    gusty = [fly(9070 + k, "lon", gust=2.0, rotating=True).maneuver for k in range(2)]
    assert find_instrument_errors(gusty) == ()
    wrong = [at_wrong_position(one, 1.0, 0.8) for one in maneuvers_of(flown_short(1))]
    (alpha,) = find_instrument_errors([one for one in wrong if one.inputs == ("de",)])
    assert alpha.channel == "alpha"


def test_a_zero_that_the_aircraft_file_states_is_taken_off(
    flown_short: Callable[[int], VirtualFlight],
) -> None:
    flown = flown_short(2)
    flight = Flight(name="virtual", path=Path("virtual"), block=flown.measured, sources={})
    sensors = B777.sensors
    vane = sensors.alpha_vane.model_copy(update={"bias": 0.02})
    aircraft = B777.model_copy(update={"sensors": sensors.model_copy(update={"alpha_vane": vane})})
    plain, corrected = (
        cut_maneuver(flight, one, 5.0, 6.0, id="1", inputs=("de",)).block["alpha"]
        for one in (B777, aircraft)
    )
    assert corrected == pytest.approx(plain - 0.02, abs=1e-12)


def test_a_position_beyond_the_aircraft_is_a_warning_and_no_verdict(
    flown_short: Callable[[int], VirtualFlight],
) -> None:
    ahead = 1.5 * B777.geometry.span
    wrong = [at_wrong_position(one, ahead, 0.0) for one in maneuvers_of(flown_short(1))]
    found = check_compatibility(wrong, settings=CompatibilitySettings(try_signs=False))
    assert "position" not in {one.kind for one in found.verdicts}
    assert any("beyond the size of the aircraft" in one for one in found.warnings)


def test_a_vane_elsewhere_is_named_and_nothing_else_blamed(
    flown_short: Callable[[int], VirtualFlight],
) -> None:
    wrong = [at_wrong_position(one, 1.0, 0.0) for one in maneuvers_of(flown_short(1))]
    found = check_compatibility(wrong, settings=CompatibilitySettings(try_signs=False))
    assert {(one.kind, one.channels) for one in found.verdicts} == {("position", ("alpha",))}
    statuses = {name: one.status for name, one in found.parameters.items()}
    assert statuses["alpha.position"] == "estimated"
    # Held: no statement on whether these maneuvers could show it.
    assert statuses["alpha.scale"] == "not-needed"


def test_a_bad_vane_is_named() -> None:
    """A vane that shows 30 % too much is named with its scale; no other instrument is blamed."""
    maneuver, _ = with_errors(21, "both", ())
    found = check_compatibility([edited(maneuver, alpha=lambda alpha: 1.3 * alpha)])
    assert [one.channels for one in found.verdicts] == [("alpha",)]
    (verdict,) = found.verdicts
    assert verdict.kind == "scale"
    assert verdict.value == pytest.approx(1.3, abs=0.08)
    assert "alpha shows 1." in found.summary


@pytest.mark.parametrize("name", ["alpha", "q", "r", "an"])
def test_a_reversed_axis_is_found(name: str) -> None:
    maneuver, _ = with_errors(31, "both", ("ay.bias", "an.bias"), size=0.2, duration=8.0, gyros=0.3)
    found = check_compatibility([with_signs(maneuver, [name])])
    assert found.remedies == (f"-{name}",)
    assert found.signs[name] == "reversed"
    verdict = next(one for one in found.verdicts if one.kind == "reversed")
    assert verdict.channels == (name,)
    assert verdict.after < verdict.before
    assert "appears reversed" in verdict.sentence


def test_exchanged_gyros_are_found() -> None:
    maneuver, _ = with_errors(32, "lat", ())
    found = check_compatibility([with_signs(maneuver, exchanged=("p", "r"))])
    assert found.remedies == ("p<>r",)
    assert "p and r appear swapped" in found.summary


def test_no_false_alarm_and_nothing_claimed_unseen() -> None:
    for seed, kind in ((41, "lon"), (42, "lat"), (43, "both")):
        maneuver, _ = with_errors(seed, kind, ())
        found = check_compatibility([maneuver])
        assert found.consistent, found.summary
        assert "in the model" in found.summary
        silent = "alpha.scale" if kind == "lat" else "beta.scale"
        if kind != "both":
            assert found.parameters[silent].value is None
            assert found.parameters[silent].std is None
            assert found.parameters[silent].why


@pytest.mark.long
def test_a_bad_model_is_not_blamed_on_instruments() -> None:
    flown = fly_whole("short", seed=5, hide=("aero.Cm.alpha2",))
    maneuvers = maneuvers_of(flown)
    found = check_compatibility(maneuvers)
    assert found.consistent, found.summary
    assert found.converged
    assert found.maneuvers == tuple(one.id for one in maneuvers)
    assert "reversed" not in found.signs.values()
    scale = found.parameters["beta.scale"]
    assert scale.value == pytest.approx(1.0, abs=0.02)
    for history in found.reconstructed:
        truth = flown.truth.between(history.times[0] - 1e-6, history.times[-1] + 1e-6)
        alpha = history.computed[:, history.channels.index("alpha")]
        assert np.abs(alpha - truth["alpha"]).max() < 0.02


def test_unknown_errors_and_nothing_at_all() -> None:
    with pytest.raises(UnknownNameError, match=r"alpha\.scale"):
        CompatibilitySettings(free=("alpha.gain",))
    with pytest.raises(FlightError, match="at least one"):
        check_compatibility([])


@pytest.fixture(scope="module")
def good() -> Maneuver:
    return with_errors(51, "both", ())[0]


def test_flight_b_has_nothing_to_contradict(good: Maneuver) -> None:
    bare = without(good, "alpha", "beta", "V", "qbar", "dynamic_pressure")
    found = check_compatibility([bare])
    assert not found.parameters
    assert found.maneuvers == ()
    assert "nothing to compare" in found.summary


def test_missing_gyros_leave_the_rest(good: Maneuver) -> None:
    found = check_compatibility([without(good, "p", "r")])
    assert not any(name.startswith(("p.", "r.")) for name in found.parameters)
    assert any("p and r" in one for one in found.warnings)
    assert not [one for one in found.verdicts if one.kind in ("reversed", "exchanged")]


def test_a_constant_channel_is_stuck(good: Maneuver) -> None:
    stuck = with_channels(good, alpha=np.full(len(good.block), 0.05))
    found = check_compatibility([stuck])
    assert [one.kind for one in found.verdicts] == ["stuck"]
    assert "alpha stays constant" in found.summary
    assert "alpha.bias" not in found.parameters


def test_gaps_do_not_count(good: Maneuver) -> None:
    alpha = good.block["alpha"].copy()
    alpha[200:260] = np.nan
    q = good.block["q"].copy()
    q[500:560] = np.nan
    whole, gappy = (
        check_compatibility([good]),
        check_compatibility([with_channels(good, alpha=alpha, q=q)]),
    )
    assert len(whole.histories) == 1
    assert len(gappy.histories) == 2
    assert gappy.consistent, gappy.summary
    one, other = whole.parameters["beta.scale"], gappy.parameters["beta.scale"]
    assert abs(one.value - other.value) < 4.0 * other.std


def test_all_nan_and_ten_samples(good: Maneuver) -> None:
    block = good.block
    empty = edited(good, **dict.fromkeys(block.channels, np.nan))
    assert "nothing to compare" in check_compatibility([empty]).summary
    short = replace(good, block=block.between(block.times[0], block.times[10] - 1e-6))
    assert "10 samples; too few" in check_compatibility([short]).summary


def test_redundant_gyros_and_the_outvoted_one(good: Maneuver) -> None:
    random = np.random.default_rng(1)
    q, size = good.block["q"], len(good.block)
    second = q + 0.2 * DEGREE * random.standard_normal(size)
    third = q + 3.0 * DEGREE + 0.2 * DEGREE * random.standard_normal(size)
    found = check_compatibility([with_channels(good, q__2=second, q__3=third)])
    (verdict,) = [one for one in found.verdicts if one.kind == "disagreement"]
    assert verdict.channels == ("q.3",)
    assert "q.3 is outvoted" in verdict.sentence
    pairs = {(one.reference, one.other): one for one in found.comparisons}
    assert pairs["q", "q.2"].agree
    assert pairs["q", "q.3"].bias == pytest.approx(3.0 * DEGREE, abs=0.2 * DEGREE)
    assert pairs["q", "q.3"].noise is not None
    agreeing = check_compatibility([with_channels(good, q__2=second)])
    assert agreeing.consistent, agreeing.summary


def test_two_that_disagree(good: Maneuver) -> None:
    vane = with_channels(good, alpha__2=-good.block["alpha"])
    sentences = [one.sentence for one in check_compatibility([vane]).verdicts]
    assert any("alpha.2" in one or "alpha.2 is" in one for one in sentences)
    de = good.block["de"]
    halves = with_channels(good, elevator_left=de, elevator_right=1.3 * de)
    verdicts = check_compatibility([halves]).verdicts
    assert [one.channels for one in verdicts] == [("elevator_left", "elevator_right")]
    assert "1.30 times as much" in verdicts[0].sentence


def test_airspeed_against_dynamic_pressure(good: Maneuver) -> None:
    V, rho = good.block["V"], good.block["density"]
    wrong = with_channels(good, dynamic_pressure=0.5 * rho * (1.15 * V) ** 2)
    verdicts = [one for one in check_compatibility([wrong]).verdicts if one.kind == "disagreement"]
    assert len(verdicts) == 1
    assert "dynamic pressure" in verdicts[0].sentence
    right = with_channels(good, dynamic_pressure=0.5 * rho * V**2)
    assert check_compatibility([right]).consistent


def test_a_pitch_rate_in_another_unit_is_not_called_consistent(good: Maneuver) -> None:
    found = check_compatibility([with_channels(good, q=good.block["q"] * DEGREE)])
    assert not found.consistent
    assert "different motions" in found.summary


def test_a_vane_in_another_unit_is_not_called_consistent(good: Maneuver) -> None:
    """Radians taken for degrees: it too little motion, and gusts could do that; it is no proof."""
    found = check_compatibility([with_channels(good, alpha=good.block["alpha"] * DEGREE)])
    assert not found.consistent
    assert "channel map" in found.summary


@pytest.mark.parametrize(
    ("seed", "gust", "duration", "missing"),
    [
        (3579, 1.0, 3.0, ("an", "alpha", "theta")),
        (732, 2.0, 3.0, ("an", "alpha", "theta")),
        (4273, 1.0, 5.0, ("r", "phi")),
    ],
)
def test_quiet_stretches_in_gusts_give_a_result(
    seed: int, gust: float, duration: float, missing: tuple[str, ...]
) -> None:
    kind = "lat" if seed % 2 else "lon"
    flown = without(fly(seed, kind, gust=gust, duration=duration).maneuver, *missing)
    found = check_compatibility([flown], settings=CompatibilitySettings(try_signs=False))
    assert found.maneuvers == (flown.id,)
    assert found.histories
    assert not found.converged
    assert not found.consistent
    assert found.warnings


@pytest.mark.parametrize(
    "missing", [("r", "p", "phi"), ("p", "q", "r", "ax", "an", "alpha", "theta")]
)
def test_where_nothing_moves_units_are_not_blamed(missing: tuple[str, ...]) -> None:
    still = fly(105, "lon", duration=5.0, still=("de", "da", "dr")).maneuver
    try:
        found = check_compatibility(
            [without(still, *missing)], settings=CompatibilitySettings(try_signs=False)
        )
        said = found.summary
        assert not found.consistent
    except FlightError as error:
        said = str(error)
    assert "too little motion" in said
    assert "unit" not in said


def test_a_delay_that_ends_at_its_limit_is_no_estimate() -> None:
    """More is no delay: 200 ms with a bound of 4 would be stated in an aircraft file."""
    flown = fly(51, "both").maneuver
    late = np.interp(flown.block.times - 0.25, flown.block.times, flown.block["V"])
    found = check_compatibility(
        [with_channels(flown, V=late)], settings=CompatibilitySettings(try_signs=False)
    )
    assert found.parameters["V.delay"].value is None
    assert "beyond 200 ms" in found.parameters["V.delay"].why
    assert not [one for one in found.verdicts if one.kind == "delay"]
    assert not found.consistent


@pytest.mark.parametrize(("shift", "word"), [(0.06, "late"), (-0.06, "early")])
def test_a_delay_is_late_or_early(good: Maneuver, shift: float, word: str) -> None:
    moved = np.interp(good.block.times - shift, good.block.times, good.block["alpha"])
    found = check_compatibility(
        [with_channels(good, alpha=moved)], settings=CompatibilitySettings(try_signs=False)
    )
    (verdict,) = [one for one in found.verdicts if one.kind == "delay"]
    assert f"ms {word} against the gyros" in verdict.sentence
    assert "-" not in verdict.sentence


def test_a_channel_with_a_few_samples_counts_as_absent(good: Maneuver) -> None:
    few = np.full(len(good.block), np.nan)
    few[100:105] = 0.05
    bare = without(good, "beta", "V", "qbar", "dynamic_pressure", "phi", "theta")
    found = check_compatibility([with_channels(bare, alpha=few)])
    assert not found.parameters
    assert found.warnings


def test_redundant_gyros_of_which_one_is_rarely_there(good: Maneuver) -> None:
    rare = np.full(len(good.block), np.nan)
    rare[:45] = good.block["q"][:45]
    with np.errstate(all="raise"), warnings.catch_warnings():
        warnings.simplefilter("error")
        found = check_compatibility([with_channels(good, **{"q.2": rare})])
    (compared,) = [one for one in found.comparisons if one.other == "q.2"]
    assert compared.delay is None or abs(compared.delay) < 0.1


@pytest.mark.parametrize(
    ("parameter", "value", "std", "shown"),
    [
        # Three digits of each told 1 beside 0.00108, and a delay of 0 beside a bound of 0 ms.
        ("beta.scale", 1.00431, 0.00108, ("1.0043", "0.0011")),
        ("V.scale", 0.99837, 0.00079, ("0.99837", "0.00079")),
        ("phi.delay", 2.3e-4, 1.2e-4, ("0.23 ms", "0.12 ms")),
        ("V.delay", -6e-3, 2e-3, ("-6.0 ms", "2.0 ms")),
        ("alpha.bias", 0.02 * DEGREE, 0.062 * DEGREE, ("0.020 deg", "0.062 deg")),
        ("ax.bias", -4.7e-4 * GRAVITY, 3.4e-4 * GRAVITY, ("-0.00047 g", "0.00034 g")),
        ("q.bias", 1.5 * DEGREE, 23.0 * DEGREE, ("2 deg/s", "23 deg/s")),
        ("V.bias", -0.0001, 0.5, ("0.00 m/s", "0.50 m/s")),
    ],
)
def test_value_and_bound_end_at_the_same_digit(
    parameter: str, value: float, std: float, shown: tuple[str, str]
) -> None:
    assert format_error_with_bound(parameter, value, std) == shown
