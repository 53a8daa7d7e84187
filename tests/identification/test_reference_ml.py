"""Proof: the fast maximum likelihood engine agrees with the plain one.

Estimates to 1e-6 of a bound, bounds (plain and corrected for colored residuals) to 1e-6 of
themselves. The plain fit starts where the fast one ended and goes on until it stands still: were
that not the optimum, it would walk away. `test_the_plain_fit_from_afar` starts elsewhere.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from gsapp.dynamics.model import Model, load_model
from gsapp.identification.axes import AXIS_RESPONSES, AXIS_STATES, Axis, axis_derivatives
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.maximum_likelihood import DEFAULT_BIASES, MLSettings, MLSolution, fit
from gsapp.quantities import Block
from tests.identification.reference_ml import Fit, Reference
from tests.identification.virtual_maneuvers import fly

LAGS = 12
TIGHT = 1e-20


def compared(
    maneuvers: Sequence[Maneuver],
    axis: Axis,
    *,
    model: Model | None = None,
    free: Sequence[str] | None = None,
    effects: Sequence[str] = (),
    plain: Mapping[str, Any] | None = None,
    **settings: Any,
) -> tuple[MLSolution, Fit]:
    """Fit both ways and compare all unknowns; return both."""
    base = model or load_model("b777")
    fast = fit(
        maneuvers,
        MLSettings(
            axis=axis,
            model=base,
            free=free,
            free_effects=tuple(effects),
            tolerance=TIGHT,
            lags=LAGS,
            **settings,
        ),
    )
    chosen = (*(free or axis_derivatives(axis)), *effects)
    given: dict[str, Any] = {
        "states": AXIS_STATES[axis],
        "responses": AXIS_RESPONSES[axis],
        "biases": DEFAULT_BIASES[axis],
    }
    reference = Reference(
        maneuvers=maneuvers, model=base, free=chosen, lags=LAGS, **{**given, **(plain or {})}
    )
    assert len(fast.names) == len(reference.names)
    places = {name: fast.names.index(fast_name(name, maneuvers)) for name in reference.names}
    slow = reference.fit(
        {name: float(fast.values[place]) for name, place in places.items()},
        bounds={name: fast.cramer_rao[place, place] ** 0.5 for name, place in places.items()},
    )
    assert slow.change < 1e-6
    for name, index in places.items():
        bound = slow.cramer_rao[name]
        assert abs(fast.values[index] - slow.theta[name]) < 1e-6 * bound, name
        assert np.sqrt(fast.cramer_rao[index, index]) == pytest.approx(bound, rel=1e-6), name
        honest = np.sqrt(fast.covariance[index, index])
        assert honest == pytest.approx(slow.std[name], rel=1e-6), name
    return fast, slow


def fast_name(name: str, maneuvers: Sequence[Maneuver]) -> str:
    kind, _, rest = name.partition(".")
    if kind not in ("initial", "bias", "scale", "shift"):
        return name
    number, _, rest = rest.partition(".")
    maneuver = maneuvers[int(number)].id
    if kind != "initial":
        return f"{maneuver}.{kind}.{rest}"
    segment, _, state = rest.partition(".")
    tail = f".{int(segment) + 1}" if segment != "0" else ""
    return f"{maneuver}.initial.{state}{tail}"


def small(seed: int, kind: str, seconds: float = 3.6, **options: Any) -> Maneuver:
    return fly(seed, kind, dt=0.025, duration=seconds, **options).maneuver


def without(maneuver: Maneuver, missing: Mapping[str, slice]) -> Maneuver:
    values = maneuver.block.values.copy()
    for name, part in missing.items():
        values[part, maneuver.block.channels.index(name)] = np.nan
    block = Block(channels=maneuver.block.channels, times=maneuver.block.times, values=values)
    return replace(maneuver, block=block)


def test_longitudinal() -> None:
    compared([small(5, "lon")], "lon")


@pytest.mark.long
def test_the_plain_fit_from_afar() -> None:
    """Started at the truth and at measured initial states, the plain fit ends at the same place."""
    virtual = fly(15, "lon", dt=0.025, duration=3.0)
    free = ("CN_0", "CN_alpha", "CN_de", "Cm_0", "Cm_alpha", "Cm_q", "Cm_de")
    responses = ("alpha", "q", "an")
    truth = {name: virtual.truth[name] for name in axis_derivatives("lon")}
    held = {name: value for name, value in truth.items() if name not in free}
    model = load_model("b777")
    fast = fit(
        [virtual.maneuver],
        MLSettings(
            axis="lon", model=model, free=free, held=held, responses=responses, tolerance=TIGHT
        ),
    )
    reference = Reference(
        maneuvers=[virtual.maneuver],
        model=model,
        states=AXIS_STATES["lon"],
        responses=responses,
        free=free,
        held=held,
        biases=DEFAULT_BIASES["lon"],
        lags=1,
    )
    slow = reference.fit({name: truth[name] for name in free})
    assert slow.change < 1e-6
    for name in free:
        assert abs(fast.value(name) - slow.theta[name]) < 2e-6 * slow.cramer_rao[name]
        assert abs(slow.theta[name] - truth[name]) > 1e-3 * slow.cramer_rao[name]


def test_lateral_directional() -> None:
    compared([small(6, "lat")], "lat")


@pytest.mark.long
def test_six_degrees_of_freedom() -> None:
    free = tuple(name for name in axis_derivatives("lon") if name not in ("CA_q", "CA_de"))
    compared([small(7, "lon", 4.0)], "both", free=free)


def test_with_effects() -> None:
    model = (
        load_model("b777")
        .with_effect("aero.Cm.alpha2", {"Cm_alpha2": -1.0})
        .with_effect("aero.CN.memory")
    )
    free = ("CN_0", "CN_alpha", "CN_de", "CA_0", "CA_alpha", "Cm_0", "Cm_alpha", "Cm_q", "Cm_de")
    maneuver = small(8, "lon", model=model)
    compared([maneuver], "lon", model=model, free=free, effects=("aero.Cm.alpha2.Cm_alpha2",))


def test_missing_samples_and_a_gap_in_time() -> None:
    whole = small(9, "lon", 5.0)
    holed = without(
        whole,
        {"alpha": slice(30, 42), "an": slice(100, 101), "de": slice(60, 62), "q": slice(0, 3)},
    )
    block = holed.block
    kept = np.r_[0:90, 110 : len(block)]
    cut = Block(channels=block.channels, times=block.times[kept], values=block.values[kept])
    fast, _ = compared([replace(holed, block=cut)], "lon")
    assert len(fast.parts[0].segments) == 2


def test_several_maneuvers_together() -> None:
    model = load_model("b777")
    one = small(10, "lon", 3.0, model=model)
    other = small(11, "lon", 3.0, model=model, noise=2.0)
    free = ("CN_0", "CN_alpha", "CN_de", "CA_0", "CA_alpha", "Cm_0", "Cm_alpha", "Cm_q", "Cm_de")
    compared([one, replace(other, mass=0.99 * other.mass)], "lon", free=free)


def test_weights_of_the_user_and_a_priori_values() -> None:
    """W1 and W2 given, some derivatives held."""
    weights = {"alpha": 5.0, "q": 8.0, "an": 0.36, "ax": 1.0}
    priors = {"Cm_q": (-23.0, 1.0), "CN_alpha": (4.4, 0.2)}
    held = {"CA_q": 0.1, "CN_q": 5.0}
    free = tuple(name for name in axis_derivatives("lon") if name not in held)
    compared(
        [small(12, "lon", 3.0)],
        "lon",
        free=free,
        weights=weights,
        priors=priors,
        held=held,
        plain={"weights": weights, "priors": priors, "held": held},
    )


def test_scale_factors_time_shifts_and_covariances() -> None:
    free = ("CN_0", "CN_alpha", "CN_de", "CA_0", "CA_alpha", "Cm_0", "Cm_alpha", "Cm_q", "Cm_de")
    compared(
        [small(13, "lon")],
        "lon",
        free=free,
        scale_factors=("alpha",),
        time_shifts=("q",),
        airspeed_cutoff=1e3,  # None.
        noise="full",
        plain={"scale_factors": ("alpha",), "time_shifts": ("q",), "full": True},
    )


def test_euler_integration() -> None:
    """Euler's rule, selectable as in the source."""
    free = ("CN_0", "CN_alpha", "CN_de", "CA_0", "CA_alpha", "Cm_0", "Cm_alpha", "Cm_q", "Cm_de")
    compared([small(14, "lon", 3.0)], "lon", free=free, integration="euler", plain={"euler": True})
