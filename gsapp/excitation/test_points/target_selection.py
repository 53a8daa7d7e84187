"""Which input is wanted: from the card, from the model and the sensors, from the flight itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final, Literal

from gsapp.aircraft import Aircraft
from gsapp.dynamics.model import Model
from gsapp.excitation.settings import INPUTS
from gsapp.excitation.test_points.amplitudes import (
    amplitude_from_linkage,
    amplitudes_from_model,
    channel_noise,
)
from gsapp.excitation.test_points.input_timing import (
    ModeTiming,
    dutch_roll,
    oscillation_step_width,
    roll_step_width,
    roll_subsidence,
    short_period,
)
from gsapp.excitation.test_points.perturbation_models import (
    PerturbationModels,
    linearize_level_flight,
    simulate_input_response,
    update_model,
)
from gsapp.excitation.test_points.point import TargetInput, TestPoint, ToleranceBand
from gsapp.flight.cards import TestCard
from gsapp.flight.maneuvers.settings import DETECTION
from gsapp.foundation import FlightError
from gsapp.identification.ftr.estimates import LiveEstimate
from gsapp.virtual.flight_plan import INPUT_SHAPES

DEFAULT_STEP_WIDTH: Final = ToleranceBand(
    low=0.2,
    best=0.45,
    high=1.0,
    why_low="faster, too fast for manual input",
    why_high="slower, too slow to excite this aircraft",
)
"""Of one step where no model tells, s."""

TargetSource = Literal["card", "model", "flight", "usual"]


def select_target_input(
    surfaces: Sequence[str],
    kind: str,
    *,
    aircraft: Aircraft | None,
    model: Model | None,
    point: TestPoint | None,
    card: TestCard | None = None,
    noise: Mapping[str, float] | None = None,
    estimates: Mapping[str, LiveEstimate] | None = None,
) -> TargetInput:
    """Return the input wanted.

    Parameters
    ----------
    surfaces : sequence of str
        ``de``, ``da``, ``dr`` in the order in which they move.
    kind : str
        Shape: ``doublet``, ``3-2-1-1``, ``pulse``; others are judged as doublets.
    point : TestPoint or None
        Where it is flown; its speed is what counts.
    card : TestCard, optional
        What it is flown for. Its amplitudes and widths count, clipped by what sensors allow.
    noise : mapping of str to float, optional
        Standard deviations measured in this flight, by channel, SI; else the aircraft file's.
    estimates : mapping of str to LiveEstimate, optional
        By name: those earned in this flight take the place of the model's derivatives.

    Returns
    -------
    TargetInput
        Without a model that flies at the point, widths are the usual ones and amplitudes wide;
        without an aircraft either, a surface that no card speaks of has no amplitude.
    """
    motions, source = _best_models(aircraft, model, point, estimates)
    width, hands_off, mode = _timing(motions, surfaces, kind)
    step = width.best
    if card is not None:
        width = _card_width(card)
        if kind != "sweep":  # whose width is that of all of it
            step = width.best
    if aircraft is None:
        amplitudes: dict[str, ToleranceBand] = {}
    elif motions is None:
        amplitudes = {name: amplitude_from_linkage(aircraft, name, step) for name in surfaces}
    else:
        amplitudes = _amplitudes(aircraft, motions, surfaces, kind, step, noise)
    if card is not None:
        source = "card"
        for name, asked in card.amplitudes.items():
            if name in surfaces:
                limit = amplitudes.get(name) if motions is not None else None
                amplitudes[name] = _card_amplitude(asked, card.tolerance.amplitude, limit)
    return TargetInput(
        surfaces=tuple(surfaces),
        kind=kind,
        amplitudes=amplitudes,
        width=width,
        hands_off=hands_off,
        mode=mode,
        source=source,
    )


def _best_models(
    aircraft: Aircraft | None,
    model: Model | None,
    point: TestPoint | None,
    estimates: Mapping[str, LiveEstimate] | None,
) -> tuple[PerturbationModels | None, TargetSource]:
    if aircraft is None or model is None:
        return None, "usual"
    flown = update_model(model, estimates, aircraft=aircraft)
    if flown is not model and (motions := _models_at_point(aircraft, flown, point)) is not None:
        return motions, "flight"
    motions = _models_at_point(aircraft, model, point)
    return motions, "usual" if motions is None else "model"


def _models_at_point(
    aircraft: Aircraft, model: Model, point: TestPoint | None
) -> PerturbationModels | None:
    """Return the small motions at a point; None where the model does not fly there."""
    if point is None or point.speed is None or not point.speed > 0.0:
        return None
    try:
        return linearize_level_flight(
            aircraft,
            model,
            speed=point.speed,
            density=point.density,
            mass=point.mass,
            flap=point.flap,
        )
    except FlightError:
        return None


def _timing(
    motions: PerturbationModels | None, surfaces: Sequence[str], kind: str
) -> tuple[ToleranceBand, float, str]:
    """Return width, hands-off time and the mode that sets them."""
    if motions is None:
        usual = "short period" if set(surfaces) == {"de"} else "dutch roll"
        return (
            DEFAULT_STEP_WIDTH,
            INPUTS.default_hands_off_time,
            "roll" if set(surfaces) == {"da"} else usual,
        )
    wobble = dutch_roll(motions.lateral)
    excited: list[ModeTiming] = []
    if "de" in surfaces:
        excited.append(short_period(motions.longitudinal))
    if {"da", "dr"} & set(surfaces):
        excited.append(wobble)
    # The roll dies at once; what is waited for after an aileron input is the dutch roll.
    hands_off = max(mode.hands_off_time for mode in excited)
    if set(surfaces) == {"da"}:
        fastest = roll_subsidence(motions.lateral)
        return roll_step_width(fastest, wobble), hands_off, fastest.name
    slowest = min(excited, key=lambda mode: mode.natural_frequency)
    return oscillation_step_width(slowest, kind), hands_off, slowest.name


def _amplitudes(
    aircraft: Aircraft,
    motions: PerturbationModels,
    surfaces: Sequence[str],
    kind: str,
    width: float,
    noise: Mapping[str, float] | None,
) -> dict[str, ToleranceBand]:
    stagger = width * len(INPUT_SHAPES.get(kind, INPUT_SHAPES["doublet"]))
    answers = {
        name: simulate_input_response(
            motions,
            name,
            kind=kind,
            width=width,
            lag=getattr(aircraft.controls, name).lag,
            listen=DETECTION.response_time,
        )
        for name in surfaces
    }
    return amplitudes_from_model(
        aircraft, motions, answers, channel_noise(aircraft, noise), width=width, stagger=stagger
    )


def _card_width(card: TestCard) -> ToleranceBand:
    share = card.tolerance.width
    text = f"the card asks for {card.width:.2g} s within {100.0 * share:.0f} %"
    return ToleranceBand(
        low=(1.0 - share) * card.width,
        best=card.width,
        high=(1.0 + share) * card.width,
        why_low=text,
        why_high=text,
    )


def _card_amplitude(asked: float, share: float, limit: ToleranceBand | None) -> ToleranceBand:
    """Return the card's amplitude within what the model and the sensors allow."""
    text = f"the card asks for it within {100.0 * share:.0f} %"
    band = ToleranceBand(
        low=max(1.0 - share, 0.0) * asked,
        best=asked,
        high=(1.0 + share) * asked,
        why_low=text,
        why_high=text,
    )
    if limit is None:
        return band
    if band.low >= limit.high:
        return replace(limit, why_high=f"{limit.why_high}; the card requests more")
    if limit.high < band.high:
        band = replace(band, best=min(asked, limit.high), high=limit.high, why_high=limit.why_high)
    if limit.low > band.low:
        band = replace(band, low=min(limit.low, band.best), why_low=limit.why_low)
    return band
