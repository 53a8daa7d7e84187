"""What FTR shows: one derivative at one moment, and over the flight."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gsapp.identification.axes import derivatives_of
from gsapp.identification.ftr.estimate_evaluation import EstimateVerdict, estimate_verdict_text
from gsapp.identification.ftr.estimate_log import EstimateLog
from gsapp.identification.ftr.settings import FTRSettings
from gsapp.identification.results import DerivativeEstimate
from gsapp.quantities import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class LiveEstimate(DerivativeEstimate):
    """One derivative at one moment."""

    name: str = ""
    time: float = 0.0
    """Flight time, s."""
    signal_to_noise: float = 0.0
    """What its variable did on its own over its noise, in the band: the measure of excitation."""
    amplitude: float = 0.0
    """Rms of its variable in the band (rad; rates as q c/2V, p b/2V, r b/2V)."""
    progress: float = 0.0
    """0 to 1: how much of the excitation that is asked for there has been."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class EstimateHistory:
    """One derivative over the flight."""

    name: str
    times: FloatArray
    """Shape (n,). s."""
    values: FloatArray
    stds: FloatArray
    """Shape (n,). Per radian; NaN while unknown."""
    signal_to_noise: FloatArray
    """Shape (n,). The measure of excitation; see `LiveEstimate`."""


def live_estimate_at(
    log: EstimateLog, name: str, row: int, settings: FTRSettings, missing: Mapping[str, str]
) -> LiveEstimate:
    """Return one derivative as it stood at one row of the log.

    `missing`: coefficients whose equation cannot run now, with the reason in words.
    """
    place = log.names.index(name)
    verdict = EstimateVerdict(int(log.verdicts[row, place]))
    coefficient = name.partition("_")[0]
    companion = int(log.companions[row, place])
    others = derivatives_of(coefficient)[1:]
    partner = others[companion] if companion >= 0 else None
    noise, amplitude, uncertain, listened = (float(x) for x in log.qualities[row, place])
    earned = verdict is EstimateVerdict.ESTIMATED
    reach = min(noise / settings.signal_to_noise, 1.0) if not name.endswith("_0") else 1.0
    sure = min(settings.uncertain_share / uncertain, 1.0) if uncertain > 0.0 else 0.0
    return LiveEstimate(
        name=name,
        time=float(log.times[row]),
        value=float(log.values[row, place]) if earned else None,
        std=float(log.stds[row, place]) if earned else None,
        cramer_rao=float(log.plains[row, place]) if earned else None,
        status=verdict.status,
        confounded_with=(partner,) if verdict is EstimateVerdict.COLLINEAR and partner else (),
        why=estimate_verdict_text(
            verdict,
            name=name,
            companion=None if partner is None else partner.partition("_")[2],
            signal_to_noise=noise,
            uncertain=uncertain,
            listened=listened,
            settings=settings,
            missing=missing.get(coefficient, ""),
        ),
        signal_to_noise=noise,
        amplitude=amplitude,
        progress=1.0 if earned else float(np.nan_to_num(min(reach, sure))),
    )


def estimate_history(log: EstimateLog, name: str) -> EstimateHistory:
    """Return all estimates of one derivative."""
    place = log.names.index(name)
    earned = log.verdicts[:, place] == EstimateVerdict.ESTIMATED
    return EstimateHistory(
        name=name,
        times=log.times.copy(),
        values=np.where(earned, log.values[:, place], np.nan),
        stds=np.where(earned, log.stds[:, place], np.nan),
        signal_to_noise=log.qualities[:, place, 0].astype(np.float64),
    )
