"""What flying each card some more times would bring, and in which band.

A card is turned out `INFORMATION.execution_count` times as this pilot flies; each gives an
information matrix. The bounds after one, two, ... further repeats follow by drawing among them,
with the luck of noise and gusts on top. All of it depends on the request alone, so that it may be
done in slices between two ticks, in another process, or at once.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.dynamics.model import Model
from gsapp.excitation.information.flight_knowledge import axes_of
from gsapp.excitation.information.information_matrix import (
    CombinedInformation,
    ManeuverInformation,
    compute_bounds,
)
from gsapp.excitation.information.outlook import BoundReduction, CardForecast
from gsapp.excitation.information.planned_maneuver import (
    CardExecution,
    PilotErrorModel,
    draw_executions,
    simulate_maneuver,
)
from gsapp.excitation.information.predicted_bounds import (
    ResponseNoise,
    predict_in_gusts,
    predict_information,
)
from gsapp.excitation.settings import INFORMATION
from gsapp.excitation.test_points.perturbation_models import (
    PerturbationModels,
    linearize_level_flight,
)
from gsapp.flight.cards import TestCard
from gsapp.foundation import FlightError
from gsapp.identification.axes import Axis, axis_derivatives
from gsapp.identification.filter_error.noise_model import NoiseModel
from gsapp.quantities import SURFACE_NAMES, FloatArray, from_si

_NUMBERS: Final = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine")
_INPUTS: Final = {"3-2-1-1": "3-2-1-1 input"}
_SPEED_TEXTS: Final = {"US": "ft/s", "SI": "m/s"}


def describe_forecast(
    card: TestCard,
    repeats: int,
    gains: Sequence[BoundReduction],
    model: Model,
    wanted: Mapping[str, float],
    system: str = "US",
) -> str:
    """Return what some repeats of a card bring, with the derivative that gains most.

    What is below the bound wanted already is not spoken of.
    """
    count = _NUMBERS[repeats] if repeats < len(_NUMBERS) else str(repeats)
    surfaces = "-".join(SURFACE_NAMES[name] for name in card.surfaces)
    shape = _INPUTS.get(card.kind, card.kind) + ("s" if repeats > 1 else "")
    unit = _SPEED_TEXTS[system]
    speed = from_si(card.speed, unit, "speed")
    text = f"{count} more {surfaces} {shape} at {speed:.0f} {unit}"
    best = _largest_reduction(gains, model, wanted)
    if best is None:
        return text
    value = abs(model.derivative(best.name))
    after = _percent(best.bound_after / value)
    if best.bound_before is None or best.bound_before > INFORMATION.max_relative_bound * value:
        return f"{text}: {best.name} to {after}"
    before = _percent(best.bound_before / value)
    return f"{text}: {best.name} from {before} to {after}"


def log_bound_reduction(gain: BoundReduction, model: Model) -> float:
    """Return by how much the logarithm of a bound shrinks, from 100 % of the derivative down.

    Negative where it stays above that; minus infinity for what has no value in the model.
    """
    value = abs(model.derivative(gain.name))
    if gain.name.endswith("_0") or not value:
        return -math.inf
    begun = value if gain.bound_before is None else min(gain.bound_before, value)
    return math.log(begun / gain.bound_after)


def _largest_reduction(
    gains: Sequence[BoundReduction], model: Model, wanted: Mapping[str, float]
) -> BoundReduction | None:
    open_ones = [
        gain
        for gain in gains
        if (gain.bound_before is None or gain.bound_before > wanted.get(gain.name, 0.0))
        and log_bound_reduction(gain, model) > 0.0
    ]
    return max(open_ones, key=lambda gain: log_bound_reduction(gain, model), default=None)


def _percent(share: float) -> str:
    percent = 100.0 * share
    digits = 0 if percent >= 9.5 else 1 if percent >= 0.95 else 2
    return f"{percent:.{digits}f} %"


@dataclass(frozen=True, slots=True, kw_only=True)
class UnfinishedCard:
    """A card with repeats missing."""

    card: TestCard
    missing: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ForecastRequest:
    """All that prospects depend on."""

    aircraft: Aircraft
    model: Model
    cards: tuple[UnfinishedCard, ...]
    totals: Mapping[Axis, CombinedInformation]
    """What was learned so far, by axis."""
    noise: Mapping[Axis, ResponseNoise]
    gusts: Mapping[Axis, NoiseModel]
    """Of the axes in which the latest maneuver met gusts."""
    pilot_errors: PilotErrorModel
    channels: frozenset[str]
    """What this flight measures."""
    rate: float
    mass: float
    density: float
    """Hz, kg, kg/m^3."""
    target_bounds: Mapping[str, float]
    """Bounds asked for."""
    maneuver_interval: float
    """From one maneuver to the next, s."""
    system: str = "US"
    """Units of the words."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ForecastResult:
    """Prospects of all cards that can be judged."""

    by_card: Mapping[str, tuple[CardForecast, ...]]
    """For one further repeat, two, ...; the best card first."""
    remarks: tuple[str, ...] = ()
    """Why others cannot be judged."""


ForecastSteps = Generator[None, None, ForecastResult]


def forecast_cards(request: ForecastRequest) -> ForecastResult:
    """Return what each card would bring, at once."""
    steps = forecast_cards_stepwise(request)
    while True:
        try:
            next(steps)
        except StopIteration as done:
            reply: ForecastResult = done.value
            return reply


def forecast_cards_stepwise(request: ForecastRequest) -> ForecastSteps:
    """Find what each card would bring, in steps of some ten milliseconds."""
    found: list[tuple[CardForecast, ...]] = []
    remarks: list[str] = []
    motions: dict[tuple[float, float], PerturbationModels] = {}
    for one in request.cards:
        informations: dict[Axis, list[ManeuverInformation]] = {
            a: [] for a in axes_of(one.card.surfaces)
        }
        problem: FlightError | None = None
        executions = draw_executions(one.card, request.pilot_errors, INFORMATION.execution_count)
        for seed, execution in enumerate(executions):
            speed = INFORMATION.speed_step * round(
                (one.card.speed + execution.speed_error) / INFORMATION.speed_step
            )
            flying = speed, one.card.flap
            try:
                if flying not in motions:
                    motions[flying] = _motions_at(speed, one.card, request)
                turned_out = yield from _card_information(
                    one.card, execution, motions[flying], request, seed
                )
            except FlightError as error:
                problem = error  # one that goes wrong says nothing of the others
            else:
                for axis, information in turned_out.items():
                    informations[axis].append(information)
            yield
        if all(informations.values()):
            found.append(_forecast_card(one, informations, request))
        else:
            remarks.append(f"card {one.card.id} cannot be evaluated: {problem}")
        yield
    found.sort(key=lambda repeats: -repeats[0].score)
    return ForecastResult(by_card={one[0].card: one for one in found}, remarks=tuple(remarks))


def _motions_at(speed: float, card: TestCard, request: ForecastRequest) -> PerturbationModels:
    return linearize_level_flight(
        request.aircraft,
        request.model,
        speed=speed,
        density=request.density,
        mass=request.mass,
        flap=card.flap,
    )


def _card_information(
    card: TestCard,
    execution: CardExecution,
    motions: PerturbationModels,
    request: ForecastRequest,
    seed: int,
) -> Generator[None, None, dict[Axis, ManeuverInformation]]:
    """Return what a card brings in each axis if it turns out so, in such gusts."""
    maneuver = simulate_maneuver(
        card,
        execution,
        motions,
        aircraft=request.aircraft,
        model=request.model,
        mass=request.mass,
        rate=request.rate,
        channels=request.channels,
    )
    found: dict[Axis, ManeuverInformation] = {}
    for axis in axes_of(card.surfaces):
        if axis in request.gusts:
            found[axis] = yield from predict_in_gusts(
                maneuver, axis, request.model, request.gusts[axis], seed=seed
            )
        else:
            found[axis] = predict_information(maneuver, axis, request.model, request.noise[axis])
    return found


def _forecast_card(
    one: UnfinishedCard,
    informations: Mapping[Axis, list[ManeuverInformation]],
    request: ForecastRequest,
) -> tuple[CardForecast, ...]:
    repeats = min(one.missing, INFORMATION.max_repeats)
    gains: list[list[BoundReduction]] = [[] for _ in range(repeats)]
    shrunk = np.zeros(repeats)
    for axis, matrices in informations.items():
        heard = request.noise[axis].duration > 0.0
        surprise = request.pilot_errors.bound_ratio
        luck = (surprise.mean, surprise.std) if heard else INFORMATION.unknown_noise_ratio
        names, before, after = _bounds_after(request.totals[axis], matrices, luck, repeats)
        # Shape (3, repeats, n_names).
        bands = np.quantile(after, INFORMATION.band_quantiles, axis=0)
        for row in range(repeats):
            for column, name in enumerate(names):
                low, middle, high = bands[:, row, column].tolist()
                gains[row].append(
                    BoundReduction(
                        name=name,
                        bound_before=before.get(name),
                        bound_after=middle,
                        low=low,
                        high=high,
                    )
                )
            shrunk[row] += _shrinkage(names, before, after[:, row], request)
    seconds = request.maneuver_interval / request.pilot_errors.usable_share
    counted = max(len(_counted_derivatives(request.model)), 1)
    found = []
    for row in range(repeats):
        ordered = tuple(
            sorted(gains[row], key=lambda gain: -log_bound_reduction(gain, request.model))
        )
        found.append(
            CardForecast(
                card=one.card.id,
                repeats=row + 1,
                reductions=ordered,
                score=float(shrunk[0]) / counted,
                seconds=(row + 1) * seconds,
                text=describe_forecast(
                    one.card, row + 1, ordered, request.model, request.target_bounds, request.system
                ),
            )
        )
    return tuple(found)


def _bounds_after(
    total: CombinedInformation,
    informations: list[ManeuverInformation],
    luck: tuple[float, float],
    repeats: int,
) -> tuple[tuple[str, ...], dict[str, float], FloatArray]:
    """Return names, bounds now, and bounds after each repeat, shape (draws, repeats, n_names).

    `luck` is mean and spread of the logarithm by which noise and gusts lift a bound.
    """
    seen = {name for one in informations for name in one.names}
    now = {name: std for name, (_, std) in total.estimates().items()}
    names = tuple(name for name in total.names if name in seen or name in now)
    whole = [total.names.index(name) for name in names]
    matrices = np.zeros((2, len(informations), len(names), len(names)))
    for index, one in enumerate(informations):
        places = np.ix_(*[[names.index(name) for name in one.names]] * 2)
        matrices[0, index][places] = one.matrix
        matrices[1, index][places] = one.gradient_covariance
    random = np.random.default_rng(0)
    chosen = random.integers(len(informations), size=(INFORMATION.draw_count, repeats))
    mean, spread = luck
    surprise = np.exp(mean + spread * random.standard_normal((INFORMATION.draw_count, repeats)))
    gained = np.cumsum(matrices[:, chosen] / surprise[:, :, None, None] ** 2, axis=2)
    place = np.ix_(whole, whole)
    return (
        names,
        now,
        compute_bounds(
            gained[0] + total.matrix[place], gained[1] + total.gradient_covariance[place]
        ),
    )


def _counted_derivatives(model: Model) -> list[str]:
    """Return the derivatives that bounds are wanted of: biases, and zeros, tell nothing."""
    return [
        name
        for name in axis_derivatives("both")
        if not name.endswith("_0") and model.derivative(name)
    ]


def _shrinkage(
    names: tuple[str, ...], before: Mapping[str, float], after: FloatArray, request: ForecastRequest
) -> float:
    """Return by how much the logarithms of the bounds shrink, added up.

    A bound counts from 100 % of its derivative down to what is wanted.
    """
    counted = _counted_derivatives(request.model)
    total = 0.0
    for column, name in enumerate(names):
        if name not in counted:
            continue
        value = abs(request.model.derivative(name))
        least = request.target_bounds.get(name, 0.0)
        begun = max(min(before.get(name, value), value), least)
        reached = np.clip(after[:, column], least, begun)
        total += float(np.mean(np.log(begun / reached))) if begun > 0.0 else 0.0
    return total
