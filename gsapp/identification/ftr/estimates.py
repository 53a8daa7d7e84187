"""What FTR shows: when an estimate is earned, the log of all, and one at one moment.

A derivative is *unknown* until all of this holds:

1. its equation runs (its instruments are there), and there are enough real equations;
2. what its variable did in the band, and no other variable explains, exceeds the variable's own
   noise there by `FTRSettings.signal_to_noise`; noise in a regressor shrinks the derivative by
   one over the square of that;
3. its bound, times the rms of its variable, stays below `FTRSettings.uncertain_share` of the
   rms of the coefficient (trim and drift taken out).

Where 2 or 3 fails because the variable moved together with others, it is *not identifiable*, and
the one it moved with most is named. The constant part needs 3 alone, with its bound itself in the
place of the product.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from enum import IntEnum

import numpy as np
import numpy.typing as npt

from gsapp.foundation.temporary_arrays import create_temporary_array
from gsapp.identification.axes import derivatives_of
from gsapp.identification.ftr.settings import FTR_ALGORITHM, FTRSettings
from gsapp.identification.ftr.solution import FTRSolution
from gsapp.identification.results import DerivativeEstimate, DerivativeStatus
from gsapp.quantities import FloatArray


class EstimateVerdict(IntEnum):
    """Why an estimate is, or is not, shown."""

    ESTIMATED = 0
    NOT_MEASURED = 1
    TOO_SHORT = 2
    NOT_EXCITED = 3
    COLLINEAR = 4
    UNCERTAIN = 5

    @property
    def status(self) -> DerivativeStatus:
        if self is EstimateVerdict.ESTIMATED:
            return "estimated"
        return "not-identifiable" if self is EstimateVerdict.COLLINEAR else "unknown"


VerdictArray = npt.NDArray[np.int8]


def evaluate_estimates(
    solution: FTRSolution, settings: FTRSettings, running: npt.NDArray[np.bool_]
) -> tuple[VerdictArray, VerdictArray]:
    """Return a verdict for each derivative, and the place of the variable it moved with.

    `running`, shape (U, 3): equations whose instruments are there.

    Returns
    -------
    verdicts : ndarray of int8, shape (U, 3, p + 1)
        The constant part last.
    companions : ndarray of int8, shape (U, 3, p)
        -1 where there is none.
    """
    noisy = solution.signal_to_noise < settings.signal_to_noise
    uncertain = solution.uncertain > settings.uncertain_share
    # Not above is not enough: NaN must fail, too.
    uncertain |= ~np.isfinite(solution.uncertain)
    # Had it been alone in moving, would it have been enough?
    share = np.sqrt(np.maximum(solution.alone, 1e-30))
    companions = _most_correlated(solution)
    together = (solution.alone < FTR_ALGORITHM.collinearity_share) & (companions >= 0)
    noisy_together = (
        noisy & together & (solution.signal_to_noise > settings.signal_to_noise * share)
    )
    uncertain_together = (
        uncertain[..., :-1]
        & together
        & (solution.uncertain[..., :-1] * share < settings.uncertain_share)
    )
    verdicts = np.full(solution.uncertain.shape, EstimateVerdict.ESTIMATED, dtype=np.int8)
    verdicts[uncertain] = EstimateVerdict.UNCERTAIN
    own = verdicts[..., :-1]
    own[noisy] = EstimateVerdict.NOT_EXCITED
    own[noisy_together | (uncertain_together & ~noisy)] = EstimateVerdict.COLLINEAR
    verdicts[solution.freedom < settings.least_freedom] = EstimateVerdict.TOO_SHORT
    verdicts[~running] = EstimateVerdict.NOT_MEASURED
    return verdicts, companions


def widen_for_withheld(
    solution: FTRSolution, verdicts: VerdictArray, sizes: FloatArray
) -> FTRSolution:
    """Return a solution whose bounds hold what the derivatives withheld may have done.

    Noise in a regressor shrinks its derivative, by one over the square of its signal-to-noise
    ratio, and bends those of the variables that it moved with.

    `sizes`, shape (3, p): standard deviation of what is not known at all.
    """
    withheld = verdicts[..., :-1] != EstimateVerdict.ESTIMATED
    shrunk = 1.0 / (1.0 + np.nan_to_num(solution.signal_to_noise) ** 2)
    return solution.widened(np.where(withheld, sizes * shrunk, 0.0))


def _most_correlated(solution: FTRSolution) -> VerdictArray:
    correlation: FloatArray = np.abs(solution.correlation)
    p = correlation.shape[-1]
    if p < 2:
        return np.full(solution.theta.shape, -1, dtype=np.int8)
    others = correlation * (1.0 - np.eye(p))
    nearest = others.argmax(axis=-1)
    found = others.max(axis=-1) > 0.0
    return np.asarray(np.where(found, nearest, -1), dtype=np.int8)


def estimate_verdict_text(
    verdict: EstimateVerdict,
    *,
    name: str,
    companion: str | None,
    signal_to_noise: float,
    uncertain: float,
    listened: float,
    settings: FTRSettings,
    missing: str,
) -> str:
    """Return in words why an estimate is not shown; empty where it is."""
    variable = name.partition("_")[2]
    if verdict is EstimateVerdict.ESTIMATED:
        return ""
    if verdict is EstimateVerdict.NOT_MEASURED:
        return missing or "a required instrument was silent"
    if verdict is EstimateVerdict.TOO_SHORT:
        return f"only {listened:.1f} s of data" if listened > 0.0 else "no samples yet"
    if verdict is EstimateVerdict.NOT_EXCITED:
        return (
            f"{variable} was too weak alone: {signal_to_noise:.1f} times its noise, needed "
            f"{settings.signal_to_noise:g}"
        )
    if verdict is EstimateVerdict.COLLINEAR:
        return f"{variable} moved together with {companion}; move the surfaces at different times"
    what = "its bound" if variable == "0" else f"the bound times what {variable} did"
    return (
        f"{what} is {100 * uncertain:.0f} % of what the coefficient did; "
        f"needed {100 * settings.uncertain_share:.0f} %"
    )


Float32Array = npt.NDArray[np.float32]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class EstimateSnapshot:
    """Estimates at U moments in the order of the log, D derivatives, constants first."""

    values: FloatArray
    stds: FloatArray
    plains: FloatArray
    """Shape (U, D)."""
    verdicts: VerdictArray
    companions: VerdictArray
    """Shape (U, D)."""
    qualities: Float32Array
    """Shape (U, D, 4). Signal to noise, amplitude, uncertain share, seconds listened."""

    @staticmethod
    def from_axis_arrays(
        solution: FTRSolution, verdicts: VerdictArray, companions: VerdictArray
    ) -> EstimateSnapshot:
        """Return a solution laid out by derivative."""
        many = len(solution.theta)
        shape = solution.bias.shape

        def lay(bias: npt.NDArray[np.generic], rest: npt.NDArray[np.generic]) -> object:
            return np.concatenate((bias[..., np.newaxis], rest), axis=2).reshape(many, -1)

        qualities = np.empty((*verdicts.shape, 4), dtype=np.float32)
        with np.errstate(over="ignore"):
            qualities[..., 1:, 0] = solution.signal_to_noise
            qualities[..., 1:, 1] = solution.amplitude
            qualities[..., 1:, 2] = solution.uncertain[..., :-1]
            qualities[..., 0, 2] = solution.uncertain[..., -1]
        qualities[..., 0, :2] = 0.0
        qualities[..., 3] = solution.listened[..., np.newaxis]
        return EstimateSnapshot(
            values=np.asarray(lay(solution.bias, solution.theta)),
            stds=np.asarray(lay(solution.bias_std, solution.std)),
            plains=np.asarray(lay(solution.bias_std, solution.plain)),
            verdicts=np.asarray(lay(verdicts[..., -1], verdicts[..., :-1])),
            companions=np.asarray(lay(np.full(shape, -1, dtype=np.int8), companions)),
            qualities=qualities.reshape(many, -1, 4),
        )

    @staticmethod
    def concatenate(parts: Sequence[EstimateSnapshot]) -> EstimateSnapshot:
        """Return the derivatives of several axes together."""
        return EstimateSnapshot(
            **{
                one.name: np.concatenate([getattr(part, one.name) for part in parts], axis=1)
                for one in fields(EstimateSnapshot)
            }
        )


class EstimateLog:
    """Estimates of D derivatives at all moments so far; see `EstimateSnapshot` for the arrays.

    Those of a long flight lie in a temporary file.
    """

    def __init__(self, names: Sequence[str]) -> None:
        self.names = tuple(names)
        D = len(self.names)
        self._row = np.dtype(
            [
                ("times", np.float64),
                *((name, np.float64, (D,)) for name in ("values", "stds", "plains")),
                *((name, np.int8, (D,)) for name in ("verdicts", "companions")),
                ("qualities", np.float32, (D, 4)),
            ],
            align=True,
        )
        self.clear()

    def clear(self) -> None:
        """Forget everything."""
        self._count = 0
        self._table = create_temporary_array(256, self._row)

    def append(self, times: FloatArray, moment: EstimateSnapshot) -> None:
        """Add moments; those at or before the last one take its place."""
        index = int(np.searchsorted(self.times, times[0] - 1e-9))
        need = index + times.size
        if need > self._table.size:
            old = self._table
            self._table = create_temporary_array(2 * need, self._row)
            self._table[:index] = old[:index]
        self._table["times"][index:need] = times
        for one in fields(EstimateSnapshot):
            self._table[one.name][index:need] = getattr(moment, one.name)
        self._count = need

    @property
    def times(self) -> FloatArray:
        return np.asarray(self._table["times"][: self._count], dtype=np.float64)

    @property
    def last_time(self) -> float | None:
        return float(self._table["times"][self._count - 1]) if self._count else None

    def row_at(self, time: float | None) -> int | None:
        """Return the row of the last moment at or before a time; None if there is none."""
        if time is None:
            return self._count - 1 if self._count else None
        row = int(np.searchsorted(self.times, time + 1e-9, side="right")) - 1
        return row if row >= 0 else None

    @property
    def values(self) -> FloatArray:
        return np.asarray(self._table["values"][: self._count], dtype=np.float64)

    @property
    def stds(self) -> FloatArray:
        return np.asarray(self._table["stds"][: self._count], dtype=np.float64)

    @property
    def plains(self) -> FloatArray:
        return np.asarray(self._table["plains"][: self._count], dtype=np.float64)

    @property
    def verdicts(self) -> VerdictArray:
        return np.asarray(self._table["verdicts"][: self._count], dtype=np.int8)

    @property
    def companions(self) -> VerdictArray:
        return np.asarray(self._table["companions"][: self._count], dtype=np.int8)

    @property
    def qualities(self) -> Float32Array:
        return np.asarray(self._table["qualities"][: self._count], dtype=np.float32)

    def state(self) -> dict[str, npt.NDArray[np.generic]]:
        return {name: self._table[name][: self._count] for name in self._row.names or ()}

    def restore(self, state: Mapping[str, npt.NDArray[np.generic]]) -> None:
        self._count = len(state["times"])
        self._table = create_temporary_array(max(256, 2 * self._count), self._row)
        for name in self._row.names or ():
            self._table[name][: self._count] = state[name]


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
    index = log.names.index(name)
    verdict = EstimateVerdict(int(log.verdicts[row, index]))
    coefficient = name.partition("_")[0]
    companion = int(log.companions[row, index])
    others = derivatives_of(coefficient)[1:]
    partner = others[companion] if companion >= 0 else None
    noise, amplitude, uncertain, listened = (float(x) for x in log.qualities[row, index])
    earned = verdict is EstimateVerdict.ESTIMATED
    reach = min(noise / settings.signal_to_noise, 1.0) if not name.endswith("_0") else 1.0
    sure = min(settings.uncertain_share / uncertain, 1.0) if uncertain > 0.0 else 0.0
    return LiveEstimate(
        name=name,
        time=float(log.times[row]),
        value=float(log.values[row, index]) if earned else None,
        std=float(log.stds[row, index]) if earned else None,
        cramer_rao=float(log.plains[row, index]) if earned else None,
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


def estimate_history(log: EstimateLog, name: str, step: int = 1) -> EstimateHistory:
    """Return every `step`-th estimate of one derivative, the last among them."""
    index = log.names.index(name)
    rows = slice((log.times.size - 1) % step, None, step)
    earned = log.verdicts[rows, index] == EstimateVerdict.ESTIMATED
    return EstimateHistory(
        name=name,
        times=log.times[rows].copy(),
        values=np.where(earned, log.values[rows, index], np.nan),
        stds=np.where(earned, log.stds[rows, index], np.nan),
        signal_to_noise=log.qualities[rows, index, 0].astype(np.float64),
    )
