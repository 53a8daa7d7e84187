"""The data compatibility check."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import cast

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.dynamics.sensors import pitot_airspeed, velocity_at
from gsapp.foundation import FlightError
from gsapp.foundation.name_suggestions import join_names
from gsapp.identification.compatibility.axis_hypotheses import (
    AxisCorrectionResult,
    evaluate_signs,
    find_axis_corrections,
)
from gsapp.identification.compatibility.error_selection import scale_settings, select_errors
from gsapp.identification.compatibility.instrument_error_fit import (
    InstrumentErrorFit,
    SegmentFit,
    at_limit,
    fit_instrument_errors,
    free_errors,
    is_motion_significant,
    nominal_value,
)
from gsapp.identification.compatibility.redundancy import compare_redundant_sensors
from gsapp.identification.compatibility.results import (
    CompatibilityResult,
    InstrumentParameter,
    InstrumentVerdict,
    InstrumentVerdictKind,
    channel_title,
    format_error,
    format_error_with_bound,
    format_quantity,
)
from gsapp.identification.compatibility.segments import (
    CompatibilitySegment,
    PreparedSegments,
    prepare_segments,
)
from gsapp.identification.compatibility.settings import (
    ACCELERATION_CHANNELS,
    COMPATIBILITY,
    KINEMATIC_INPUTS,
    KINEMATIC_OUTPUTS,
    RATE_CHANNELS,
    CompatibilitySettings,
)
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.results import ResponseFit, ResponseHistory
from gsapp.identification.statistics import response_fit

RECONSTRUCTED_CHANNELS = ("V", "alpha", "beta", "p", "q", "r", "phi", "theta")
"""Channels of `CompatibilityResult.reconstructed`."""
_MAX_SLOW_NOISE: Mapping[str, float] = {
    "V": 1.0, "alpha": 0.01, "beta": 0.01, "phi": 0.035, "theta": 0.035,
}  # fmt: skip
"""Slow noise of a channel (rms of averages, SI) beyond which the instrument is in question."""


_REMEDIES = {"delay": "add it to the aircraft file", "position": "correct the aircraft file"}


def check_compatibility(
    maneuvers: Sequence[Maneuver],
    aircraft: Aircraft | None = None,
    settings: CompatibilitySettings | None = None,
) -> CompatibilityResult:
    """Check whether the instruments are consistent with one another: kinematics alone.

    Several maneuvers are taken together: errors of instruments are common to them, each has a
    start of its own.

    `aircraft`: in place of the one that each maneuver knows.

    Raises `FlightError` if no maneuver is given. All else that is missing or unfit is said in
    `warnings`.
    """
    if not maneuvers:
        raise FlightError("there is no maneuver to check instruments by; give at least one")
    prepared = prepare_segments(maneuvers, aircraft)
    chosen = scale_settings(settings or CompatibilitySettings(), aircraft or maneuvers[0].aircraft)
    comparisons, disagreements = compare_redundant_sensors(maneuvers, chosen)
    stuck = (*_stuck_verdicts(prepared), *disagreements)
    if not prepared.segments:
        return CompatibilityResult(
            maneuvers=(),
            verdicts=stuck,
            comparisons=comparisons,
            converged=False,
            warnings=tuple(prepared.warnings),
            summary="the instruments cannot be compared: " + "; ".join(prepared.warnings),
        )
    channels = prepared.channels
    usual = free_errors(chosen, channels)
    first = select_errors(prepared.segments, chosen, usual)
    free = first.free
    found = AxisCorrectionResult(
        segments=tuple(prepared.segments), fit=first, corrections=(), verdicts=()
    )
    if chosen.try_signs:
        found = find_axis_corrections(prepared.segments, first, chosen, channels)
    if not found.fit.segments:
        raise FlightError(
            "the instruments cannot be compared: the motion from rates and accelerations fits "
            f"no other instrument; {_failure_cause(prepared.segments, chosen)}"
        )
    noises = [one.noise for one in found.fit.segments]
    begin = found.fit if found.fit.converged else None
    final = fit_instrument_errors(found.segments, chosen, free, noises=noises, begin=begin)
    if not final.segments:
        # Quiet stretches may have no way back from the usual start under the noise found.
        final = fit_instrument_errors(found.segments, chosen, free, noises=noises, begin=found.fit)
    found = AxisCorrectionResult(
        segments=found.segments,
        fit=final,
        corrections=found.corrections,
        verdicts=found.verdicts,
    )
    parameters = _parameters(final, chosen, usual)
    histories = tuple(_history(one) for one in final.segments)
    verdicts = (
        *stuck,
        *found.verdicts,
        *(_error_verdicts(parameters, chosen) if final.converged else ()),
        *(_unexplained_verdicts(final) if final.converged else ()),
        *_inconsistent_gyro_verdicts(final),
    )
    warnings = [
        *prepared.warnings,
        *_gust_warnings(final),
        *(_position_warnings(parameters, chosen) if final.converged else ()),
    ]
    if not final.converged:
        warnings.append(
            "the fit of instrument errors did not converge; its values are indicative only"
        )
    return CompatibilityResult(
        maneuvers=tuple(dict.fromkeys(one.maneuver for one in prepared.segments)),
        parameters=parameters,
        signs=evaluate_signs(found, chosen, channels),
        fit=_fits(histories),
        histories=histories,
        reconstructed=tuple(_motion(one) for one in final.segments),
        noise=_noise(prepared),
        gust=_gust_intensity(final),
        verdicts=verdicts,
        comparisons=comparisons,
        remedies=tuple(one.name for one in found.corrections),
        iterations=final.iterations,
        converged=final.converged,
        warnings=tuple(warnings),
        summary=_summary(verdicts, channels, final, chosen),
    )


def _stuck_verdicts(prepared: PreparedSegments) -> tuple[InstrumentVerdict, ...]:
    return tuple(
        InstrumentVerdict(
            kind="stuck",
            channels=(name,),
            sentence=f"{channel_title(name)} stays constant in maneuver {join_names(where)}: "
            "the instrument is stuck or not connected; it is excluded",
        )
        for name, where in prepared.stuck.items()
    )


def _parameters(
    found: InstrumentErrorFit, settings: CompatibilitySettings, usual: Sequence[str]
) -> dict[str, InstrumentParameter]:
    parameters = {
        name: InstrumentParameter(
            value=None,
            nominal=nominal_value(name),
            status="not-needed",
            why="with it free the instruments agree no better",
        )
        for name in usual
        if name not in found.free
    }
    for name in found.free:
        std = found.std(name)
        plausible = settings.plausible_size(name)
        why = _why_unknown(found, name, std, plausible)
        parameters[name] = InstrumentParameter(
            value=None if why else found.errors[name],
            std=None if why else std,
            nominal=nominal_value(name),
            status="not-observable" if why else "estimated",
            why=why,
        )
    return parameters


def _is_masked_by_noise(found: InstrumentErrorFit, name: str) -> bool:
    """Return whether noise hides the motion by which a scale or a delay of a vane is seen."""
    channel, _, kind = name.partition(".")
    if channel not in KINEMATIC_OUTPUTS or kind == "bias":
        return False
    if kind == "position":
        return False
    return not any(name in one.clearly_observable for one in found.segments)


def _why_unknown(found: InstrumentErrorFit, name: str, std: float, plausible: float) -> str:
    """Return why the fit gives no estimate of an error; empty where it gives one."""
    channel, _, kind = name.partition(".")
    unclear = _is_masked_by_noise(found, name)
    if kind == "position":
        return ""
    if not unclear and at_limit(name, found.errors[name]):
        return (
            f"the best fit lies beyond {format_error(name, COMPATIBILITY.max_delay)}, too long for "
            "an instrument delay; look for another error"
        )
    if unclear or (std > 0.9 * plausible and kind != "bias"):
        return f"{channel_title(channel)} hardly moves beyond the noise in these maneuvers"
    if std > COMPATIBILITY.observable_share * plausible:
        return (
            f"the data leave {format_error(name, std)} open, where "
            f"{format_error(name, plausible)} was plausible: not distinguishable from other "
            "errors; fly more or other maneuvers"
        )
    return ""


def _error_verdicts(
    parameters: Mapping[str, InstrumentParameter], settings: CompatibilitySettings
) -> list[InstrumentVerdict]:
    """Return verdicts on errors that surely exceed what is tolerable."""
    found = []
    for name, one in parameters.items():
        if one.value is None or one.std is None:
            continue
        excess = abs(one.value - one.nominal) - settings.tolerable_size(name)
        if excess <= COMPATIBILITY.significant_sigmas * one.std:
            continue
        channel, _, kind = name.partition(".")
        if kind == "position" and _is_beyond_aircraft(name, one.value, settings):
            continue
        size = abs(one.value) if kind in {"delay", "position"} else one.value
        value, std = format_error_with_bound(name, size, one.std)
        spread = f"{value} \N{PLUS-MINUS SIGN} {std}"
        way = "late" if one.value > 0.0 else "early"
        side = "ahead of" if one.value > 0.0 else "behind"
        said = {
            "bias": f"{channel_title(channel)} is off by {spread}",
            "scale": f"{channel_title(channel)} shows {spread} times the value from the other "
            "instruments",
            "delay": f"{channel_title(channel)} is {spread} {way} against the gyros",
            "position": f"the {channel} vane appears to be {spread} {side} its position in the "
            "aircraft file",
        }[kind]
        found.append(
            InstrumentVerdict(
                kind=cast("InstrumentVerdictKind", kind),
                channels=(channel,),
                sentence=f"{said}; {_REMEDIES.get(kind, 'check its calibration')}",
                value=one.value,
                std=one.std,
            )
        )
    return found


def _is_beyond_aircraft(name: str, ahead: float, settings: CompatibilitySettings) -> bool:
    """Return whether a vane is put farther away than the aircraft is large."""
    span = settings.plausible_size(name) / COMPATIBILITY.plausible_position
    return abs(ahead) > COMPATIBILITY.max_position * span


def _position_warnings(
    parameters: Mapping[str, InstrumentParameter], settings: CompatibilitySettings
) -> list[str]:
    """Return warnings about vanes that the fit puts where no aircraft carries one."""
    return [
        f"the fit puts the {name.partition('.')[0]} vane {format_error(name, abs(one.value))} "
        f"{'ahead of' if one.value > 0.0 else 'behind'} its position in the aircraft file, "
        "beyond the size of the aircraft: another error looks like it; check units, times and "
        "scales of the channels"
        for name, one in parameters.items()
        if name.endswith(".position")
        and one.value is not None
        and _is_beyond_aircraft(name, one.value, settings)
    ]


def _unexplained_verdicts(found: InstrumentErrorFit) -> list[InstrumentVerdict]:
    """Return verdicts on channels that go their own ways, by no error of a simple kind."""
    verdicts = []
    for name in KINEMATIC_OUTPUTS:
        slow = [
            (
                float(one.noise.output_factors[row] * one.error_model.output_variance[row]) ** 0.5,
                one,
            )
            for one in found.segments
            if name in one.segment.measured
            and one.noise.output_factors[row := one.prediction.channels.index(name)] > 4.0
        ]
        if not slow:
            continue
        size, worst = max(slow, key=lambda pair: pair[0])
        if size > _MAX_SLOW_NOISE[name]:
            verdicts.append(
                InstrumentVerdict(
                    kind="unexplained",
                    channels=(name,),
                    sentence=f"{channel_title(name)} contradicts rates and accelerations by "
                    f"{format_quantity(name, size)} (rms) in maneuver "
                    f"{worst.segment.maneuver}, not by bias, scale or delay; check the "
                    "instrument",
                    before=size,
                    seen_in=name,
                )
            )
    return verdicts


def _inconsistent_gyro_verdicts(found: InstrumentErrorFit) -> list[InstrumentVerdict]:
    """Return verdicts on gyros that only noise many times their own would reconcile with the rest.

    So looks a channel in another unit: its scale is too far off to be found by small steps.
    """
    verdicts = []
    for index, name in enumerate(("p", "q", "r")):
        worst = max(found.segments, key=lambda one: float(one.noise.input_factors[index]))
        power = float(worst.noise.input_factors[index])
        if power <= COMPATIBILITY.max_gyro_noise_ratio or name in worst.segment.absent:
            continue
        noise = power**0.5 * worst.segment.noise[name]
        if noise < COMPATIBILITY.min_gyro_noise_share * np.std(worst.segment.inputs[name]):
            continue
        verdicts.append(
            InstrumentVerdict(
                kind="unexplained",
                channels=(name,),
                sentence=f"{channel_title(name)} and the other instruments show different "
                f"motions in maneuver {worst.segment.maneuver}: they agree only if its "
                f"noise were {power**0.5:.0f} times larger; check its unit and those "
                "of the angles",
                before=(power * float(worst.error_model.input_density[index])) ** 0.5,
                seen_in=name,
            )
        )
    return verdicts


def _gust_intensity(found: InstrumentErrorFit) -> dict[str, float]:
    densities = np.array(
        [one.noise.input_factors[6:] * one.error_model.input_density[6:] for one in found.segments]
    ).mean(axis=0)
    return dict(zip(("u", "v", "w"), (float(one) for one in np.sqrt(densities)), strict=True))


def _gust_warnings(found: InstrumentErrorFit) -> list[str]:
    strong = {
        name: size
        for name, size in _gust_intensity(found).items()
        if size > COMPATIBILITY.gust_warning_speed
    }
    if not strong:
        return []
    text = ", ".join(f"{size:.1f} m/s along {name}" for name, size in strong.items())
    return [
        f"the air moved, by {text} over a second: airspeed, alpha and beta contain it, and bounds "
        "are wide accordingly"
    ]


def _noise(prepared: PreparedSegments) -> dict[str, float]:
    found: dict[str, list[float]] = {}
    for stretch in prepared.segments:
        for name, size in stretch.noise.items():
            if name in stretch.inputs or name in stretch.measured:
                found.setdefault(name, []).append(size)
    return {name: float(np.median(sizes)) for name, sizes in found.items()}


def _summary(
    verdicts: Sequence[InstrumentVerdict],
    channels: Sequence[str],
    found: InstrumentErrorFit,
    settings: CompatibilitySettings,
) -> str:
    if verdicts:
        return "; ".join(one.sentence for one in verdicts)
    names = join_names([channel_title(name) for name in channels])
    if found.converged:
        return f"{names} are consistent: remaining disagreement is in the model"
    stretches = [one.segment for one in found.segments]
    cause = ""
    if found.step > COMPATIBILITY.max_final_step or _is_quiet(stretches, settings):
        cause = f"; {_failure_cause(stretches, settings)}"
    return f"no contradiction found between {names}, but the fit did not converge{cause}"


def _is_quiet(stretches: Sequence[CompatibilitySegment], settings: CompatibilitySettings) -> bool:
    """Return whether no gyro, or without gyros no accelerometer, shows more than noise."""
    return not any(
        is_motion_significant(one, name, settings.rate)
        for one in stretches
        for name in next(
            (g for g in (RATE_CHANNELS, ACCELERATION_CHANNELS) if not one.absent.issuperset(g)), ()
        )
        if name not in one.absent
    )


def _failure_cause(
    stretches: Sequence[CompatibilitySegment], settings: CompatibilitySettings
) -> str:
    """Return the likeliest reason why the fit of these stretches has no outcome."""
    if _is_quiet(stretches, settings):
        return "too little motion in these maneuvers: choose windows with inputs"
    absent = set[str]().union(*(one.absent for one in stretches))
    if absent:
        names = join_names([channel_title(name) for name in KINEMATIC_INPUTS if name in absent])
        return f"{names} {'is' if len(absent) == 1 else 'are'} missing"
    return "check that all channels have the units of the channel map"


# --- histories ----------------------------------------------------------------------------------


def _history(one: SegmentFit) -> ResponseHistory:
    kept = [name for name in one.prediction.channels if name in one.segment.measured]
    rows = [one.prediction.channels.index(name) for name in kept]
    return ResponseHistory(
        maneuver=one.segment.maneuver,
        times=one.segment.times,
        channels=tuple(kept),
        measured=np.column_stack([one.segment.outputs[name] for name in kept]),
        computed=one.prediction.computed[:, rows],
    )


def _fits(histories: Sequence[ResponseHistory]) -> dict[str, ResponseFit]:
    found = {}
    for name in KINEMATIC_OUTPUTS:
        pairs = [
            (one.measured[:, row], one.computed[:, row])
            for one in histories
            if name in one.channels
            for row in [one.channels.index(name)]
        ]
        if pairs:
            measured, computed = (np.concatenate(side) for side in zip(*pairs, strict=True))
            found[name] = response_fit(measured, computed)
    return found


def _motion(one: SegmentFit) -> ResponseHistory:
    """Return the motion at the center of gravity beside what the instruments show."""
    path, stretch = one.prediction.path, one.segment
    place = stretch.aircraft.sensors.accelerometer.position
    velocity = (path.velocity[:, 0], path.velocity[:, 1], path.velocity[:, 2])
    rates = (path.rates[:, 0], path.rates[:, 1], path.rates[:, 2])
    u, v, w = velocity_at((-place[0], -place[1], -place[2]), velocity, rates)
    V = pitot_airspeed((u, v, w))
    computed = np.column_stack((V, np.arctan2(w, u), np.arcsin(v / V), *rates, *path.attitude))
    shown = {**stretch.inputs, **{name: stretch.outputs[name] for name in stretch.measured}}
    nothing = np.full(len(V), np.nan)
    return ResponseHistory(
        maneuver=stretch.maneuver,
        times=stretch.times,
        channels=RECONSTRUCTED_CHANNELS,
        measured=np.column_stack(
            [
                nothing if name in stretch.absent else shown.get(name, nothing)
                for name in RECONSTRUCTED_CHANNELS
            ]
        ),
        computed=computed,
    )
