"""Instruments against one another: truth recovered, wrong signs found, no false alarm."""

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
    VanePosition,
    at_found_positions,
    check_compatibility,
    find_vane_positions,
)
from gsapp.identification.compatibility.kinematics import integrate_rotation_matrices
from gsapp.identification.maneuver import Maneuver, cut_maneuver
from gsapp.quantities import Block
from gsapp.virtual.virtual_flight import VirtualFlight
from gsapp.virtual.virtual_flight import simulate_flight as fly_whole
from tests.identification.virtual_instruments import with_errors, with_signs

B777 = load_aircraft("b777")


def maneuvers_of(flown: VirtualFlight) -> list[Maneuver]:
    flight = Flight(name="virtual", path=Path("virtual"), block=flown.measured, sources={})
    return [
        cut_maneuver(
            flight, B777, one.t_start - 1.0, one.t_end + 1.0, id=str(number), inputs=one.inputs
        )
        for number, one in enumerate(flown.maneuvers)
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
        VanePosition(channel=name, ahead=-ahead, std=0.0, position=(0.0, 0.0, 0.0))
        for name, ahead in (("alpha", alpha), ("beta", beta))
    ]
    return at_found_positions(maneuver, vanes)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_vanes_are_found_where_they_are(
    flown_short: Callable[[int], VirtualFlight], seed: int
) -> None:
    maneuvers = maneuvers_of(flown_short(seed))
    assert find_vane_positions(maneuvers) == ()
    wrong = [at_wrong_position(one, 1.0, 0.8) for one in maneuvers]
    alpha, beta = find_vane_positions(wrong)
    assert alpha.ahead == pytest.approx(1.0, abs=4.0 * alpha.std)
    assert beta.ahead == pytest.approx(0.8, abs=4.0 * beta.std)
    assert max(alpha.std, beta.std) < 0.1
    assert alpha.position[0] == pytest.approx(B777.sensors.alpha_vane.position[0], abs=0.1)


def test_a_vane_elsewhere_is_named_and_nothing_else_blamed(
    flown_short: Callable[[int], VirtualFlight],
) -> None:
    wrong = [at_wrong_position(one, 1.0, 0.0) for one in maneuvers_of(flown_short(1))]
    found = check_compatibility(wrong, settings=CompatibilitySettings(try_signs=False))
    assert {(one.kind, one.channels) for one in found.verdicts} == {("position", ("alpha",))}


def test_a_bad_vane_is_named() -> None:
    """A vane that shows 30 % too much is named with its scale; no other instrument is blamed."""
    maneuver, _ = with_errors(21, "both", ())
    block = maneuver.block
    values = block.values.copy()
    values[:, block.channels.index("alpha")] *= 1.3
    bad = replace(maneuver, block=Block(channels=block.channels, times=block.times, values=values))
    found = check_compatibility([bad])
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
