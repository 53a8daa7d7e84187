"""How large an input should be: out of the noise below, within range and linear above."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from gsapp.aircraft import Aircraft, Control
from gsapp.excitation.settings import INPUTS
from gsapp.excitation.test_points.perturbation_models import InputResponse, PerturbationModels
from gsapp.excitation.test_points.point import ToleranceBand
from gsapp.flight.maneuvers.dead_instruments import clipping_ranges
from gsapp.flight.maneuvers.input_measures import INPUT_CRITERIA, MIN_NOISE, RESPONSE_CHANNELS
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import GRAVITY

_OWN_RATE: Final = {"de": "q", "da": "p", "dr": "r"}
_WORDS: Final = {
    "q": "the pitch rate",
    "p": "the roll rate",
    "r": "the yaw rate",
    "ax": "the forward acceleration",
    "ay": "the lateral acceleration",
    "an": "the normal acceleration",
}
"""Channels in words; others are called by their id."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Limit:
    """The most that a signal may deviate from trim, and why, in words."""

    signal: str
    margin: float
    words: str


def channel_noise(aircraft: Aircraft, noise: Mapping[str, float] | None = None) -> dict[str, float]:
    """Return the noise of each channel that answers, SI: as measured, else by the aircraft file."""
    found = aircraft.sensors.noise_in_flight
    given = {} if noise is None else {k: v for k, v in noise.items() if math.isfinite(v)}
    found.update((name, given[name]) for name in found if given.get(name, 0.0) > 0.0)
    return {name: max(value, MIN_NOISE[name]) for name, value in found.items()}


def amplitudes_from_model(
    aircraft: Aircraft,
    motions: PerturbationModels,
    answers: Mapping[str, InputResponse],
    noise: Mapping[str, float],
    *,
    width: float,
    stagger: float,
) -> dict[str, ToleranceBand]:
    """Return the bands of amplitudes (rad, as measured) that model and sensors call for.

    By surface, in the order in which they move, each `stagger` s after the one before; `width` of
    one step in s.
    """
    limits = _limits(aircraft, motions)
    alone = {
        surface: min(
            (*_limit_amplitudes(limits, [answer]), *_mechanical(aircraft, motions, surface, width)),
            key=lambda found: found[0],
        )
        for surface, answer in answers.items()
    }
    # Together they reach a limit sooner: all shrink alike.
    share, text = _combined_input_factor(
        limits, answers, {k: v[0] for k, v in alone.items()}, stagger
    )
    bands = {}
    for surface, (most, why) in alone.items():
        low, why_low = _min_amplitude(aircraft, surface, answers[surface], noise)
        band = _band(low, share * most, why_low, text or why)
        bands[surface] = _as_measured(band, getattr(aircraft.controls, surface))
    return bands


def amplitude_from_linkage(aircraft: Aircraft, surface: str, width: float) -> ToleranceBand:
    """Return what the linkage alone says of an amplitude for a step (s): a wide band."""
    control: Control = getattr(aircraft.controls, surface)
    low, why_low = max(_min_by_linkage(control), key=lambda found: found[0])
    high, why_high = min(_max_by_servo(control, 0.0, width), key=lambda found: found[0])
    return replace(
        _band(low, high, why_low, why_high),
        best=math.sqrt(low * max(high, INPUTS.narrow_band_ratio * low)),
    )


def _band(low: float, high: float, why_low: str, why_high: str) -> ToleranceBand:
    if high < INPUTS.narrow_band_ratio * low:
        why_high = f"{why_high}; little margin above the noise, fly another speed"
        high = INPUTS.narrow_band_ratio * low
    best = max(INPUTS.target_amplitude_share * high, math.sqrt(low * high))
    return ToleranceBand(
        low=float(low), best=float(best), high=float(high), why_low=why_low, why_high=why_high
    )


def _as_measured(band: ToleranceBand, control: Control) -> ToleranceBand:
    """Return a band as the channel shows it: before the linkage, its play comes on top."""
    if control.kind == "position":
        return band
    play = 0.5 * control.slop
    return replace(band, low=band.low + play, best=band.best + play, high=band.high + play)


def _limits(aircraft: Aircraft, motions: PerturbationModels) -> list[_Limit]:
    limits, alpha = aircraft.limits, float(motions.trim.polar.alpha)
    found = [
        _Limit(
            signal="alpha at the CG",
            margin=_margin(alpha, limits.alpha_linear),
            words="larger, alpha leaves its linear range",
        ),
        _Limit(
            signal="beta at the CG",
            margin=limits.beta_linear,
            words="larger, beta leaves its linear range",
        ),
        _Limit(
            signal="an",
            margin=_margin(GRAVITY, limits.load_factor),
            words="larger, the load factor reaches its limit",
        ),
    ]
    resting = {"alpha": alpha, "an": GRAVITY}
    for channel, (low, high) in clipping_ranges(aircraft).items():
        used = (INPUTS.max_range_share * low, INPUTS.max_range_share * high)
        found.append(
            _Limit(
                signal=channel,
                margin=_margin(resting.get(channel, 0.0), used),
                words=f"larger, {_channel_text(channel)} comes near the end of its sensor's range",
            )
        )
    return found


def _margin(value: float, limits: tuple[float, float]) -> float:
    return max(min(limits[1] - value, value - limits[0]), 0.0)


def _limit_amplitudes(
    limits: Iterable[_Limit], answers: Sequence[InputResponse]
) -> list[tuple[float, str]]:
    """Return the amplitude at which each limit is reached, rad, with its words."""
    found = []
    for limit in limits:
        peak = max(_peak(answer, limit.signal) for answer in answers)
        found.append((limit.margin / peak if peak > 0.0 else math.inf, limit.words))
    return found


def _peak(answer: InputResponse, signal: str) -> float:
    line = answer.histories.get(signal)
    return 0.0 if line is None else float(np.max(np.abs(line)))


def _combined_input_factor(
    limits: Iterable[_Limit],
    answers: Mapping[str, InputResponse],
    amplitudes: Mapping[str, float],
    stagger: float,
) -> tuple[float, str]:
    """Return by what all amplitudes must shrink when the surfaces move together, and why."""
    if len(answers) < 2:
        return 1.0, ""
    share, text = 1.0, ""
    for limit in limits:
        lines = [
            _delayed(answer, limit.signal, amplitudes[surface], index * stagger)
            for index, (surface, answer) in enumerate(answers.items())
        ]
        size = max(line.size for line in lines)
        lines = [np.pad(line, (0, size - line.size), mode="edge") for line in lines]
        # Nobody says which way each stick goes first: the worst of all ways counts.
        for signs in itertools.product((1.0, -1.0), repeat=len(lines) - 1):
            total = sum(
                (sign * line for sign, line in zip(signs, lines[1:], strict=True)), lines[0]
            )
            peak = float(np.max(np.abs(total)))
            if peak > 0.0 and limit.margin / peak < share:
                share, text = limit.margin / peak, f"{limit.words} when they move together"
    return share, text


def _delayed(answer: InputResponse, signal: str, amplitude: float, delay: float) -> FloatArray:
    line = answer.histories.get(signal)
    if line is None:
        line = np.zeros(1)
    return np.concatenate((np.zeros(round(delay / INPUTS.response_time_step)), amplitude * line))


def _mechanical(
    aircraft: Aircraft, motions: PerturbationModels, surface: str, width: float
) -> list[tuple[float, str]]:
    control: Control = getattr(aircraft.controls, surface)
    return _max_by_servo(control, float(motions.trim.controls[surface]), width)


def _max_by_servo(control: Control, trimmed: float, width: float) -> list[tuple[float, str]]:
    """Return what stick, stops and servo allow, rad, with words."""
    stick = max(abs(control.full_stick_high), abs(control.full_stick_low))
    return [
        (_margin(trimmed, control.travel), "larger, the surface reaches its stop"),
        (stick, "full stick reached"),
        (
            0.5 * INPUTS.max_edge_share * width * control.rate_limit,
            "larger, the servo is too slow for the step",
        ),
    ]


def _min_by_linkage(control: Control) -> list[tuple[float, str]]:
    half = 0.5 * (control.travel[1] - control.travel[0])
    return [
        (INPUTS.min_free_plays * control.slop, "smaller, the linkage play absorbs it"),
        (INPUTS.min_travel_share * half, "smaller, it is not detected as an input"),
    ]


def _min_amplitude(
    aircraft: Aircraft, surface: str, answer: InputResponse, noise: Mapping[str, float]
) -> tuple[float, str]:
    """Return the least amplitude whose answer stands out, rad, with words."""
    swings = {name: answer.peak_to_peak(name) / noise[name] for name in RESPONSE_CHANNELS[surface]}
    best = max(swings, key=lambda name: swings[name])
    rate = _OWN_RATE[surface]
    found = _min_by_linkage(getattr(aircraft.controls, surface))
    for name, wanted in (
        (best, INPUT_CRITERIA.weak_response),
        (rate, INPUT_CRITERIA.faint_response),
    ):
        if swings[name] > 0.0:
            text = f"smaller, {_channel_text(name)} is below {wanted:.0f} times its noise"
            found.append((wanted / swings[name], text))
    return max(found, key=lambda one: one[0])


def _channel_text(channel: str) -> str:
    return _WORDS.get(channel, channel)
