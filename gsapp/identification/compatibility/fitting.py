"""Errors common to all stretches, with a start for each, by Gauss-Newton."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gsapp.identification.compatibility.predicting import (
    START,
    Prediction,
    Start,
    first_start,
    predict,
    sensitivities,
)
from gsapp.identification.compatibility.preparing import Stretch
from gsapp.identification.compatibility.settings import CompatibilitySettings
from gsapp.identification.compatibility.whitening import (
    Gain,
    Noise,
    Predictor,
    averaged,
    gain,
    likeliest_noise,
    predictor_for,
    unlikelihood,
    whitened,
)
from gsapp.identification.statistics import Part, joint_covariance
from gsapp.quantities import FloatArray

_SPEED_AT_START, _TURN_AT_START = 10.0, 0.5
"""Standard deviations of a start before anything was measured: m/s, rad."""
_SETTLED = 1e-3
"""A step smaller than this share of a bound is the last."""
_LARGEST_DELAY = 0.2
_LARGEST_TURN = 0.5
"""Of a start in one step, rad."""
_RIDGE = 1e-12
_FASTEST = 1e3
"""Velocities (m/s) beyond this are no flight."""
_MOTION_OVER_NOISE = 10.0
"""Variance of the motion over that of the noise in it, for scale and delay to be seen."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StretchFit:
    """One stretch of a fit.

    Attributes
    ----------
    stretch : Stretch
    start : Start
    found : Prediction
    predictor : Predictor
    noise : Noise
    gain : Gain
    left : ndarray, shape (m, n_channels)
        What the predictor leaves of the averaged residuals.
    S : ndarray, shape (m, n_channels, n_free + 5)
        The same of the sensitivities.
    """

    stretch: Stretch
    start: Start
    found: Prediction
    predictor: Predictor
    noise: Noise
    gain: Gain
    left: FloatArray
    S: FloatArray

    def residuals(self) -> FloatArray:
        """Return measured minus computed, shape (n, n_channels)."""
        shown = np.column_stack([self.stretch.shown[name] for name in self.found.channels])
        return np.asarray(shown - self.found.computed, dtype=np.float64)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Fit:
    """A fit to all stretches.

    Attributes
    ----------
    free : tuple of str
        Errors estimated.
    errors : mapping of str to float
        Values, scales as factors.
    covariance : ndarray, shape (n_free, n_free)
    stretches : tuple of StretchFit
    unlikelihood : float
        Twice the negative log-likelihood, errors weighed by what is plausible.
    iterations : int
    converged : bool
    """

    free: tuple[str, ...]
    errors: Mapping[str, float]
    covariance: FloatArray
    stretches: tuple[StretchFit, ...]
    unlikelihood: float
    iterations: int
    converged: bool

    def rms(self, channel: str) -> float:
        """Return the residual of one channel, rms over all stretches; SI."""
        parts = [
            one.residuals()[:, one.found.channels.index(channel)]
            for one in self.stretches
            if channel in one.found.channels
        ]
        return float(np.sqrt(np.nanmean(np.concatenate(parts) ** 2))) if parts else np.nan


def free_errors(settings: CompatibilitySettings, channels: Sequence[str]) -> tuple[str, ...]:
    """Return those of the errors to be estimated whose instrument is there."""
    return tuple(name for name in settings.free if name.partition(".")[0] in channels)


def nominal(name: str) -> float:
    """Return what an error is for a faultless instrument."""
    return 1.0 if name.endswith(".scale") else 0.0


def fit(
    stretches: Sequence[Stretch],
    settings: CompatibilitySettings,
    free: Sequence[str],
    *,
    noises: Sequence[Noise] | None = None,
    iterations: int | None = None,
    bounds: bool = True,
) -> Fit:
    """Fit errors and starts.

    Parameters
    ----------
    stretches : sequence of Stretch
    settings : CompatibilitySettings
    free : sequence of str
    noises : sequence of Noise, optional
        Of the stretches, held; by default the likeliest are looked for.
    iterations : int, optional
        In place of the settings'.
    bounds : bool
        Whether the covariance is corrected for what color is left; it takes as long as a step.
    """
    most = settings.iterations if iterations is None else iterations
    free = tuple(free)
    plausible = np.array([settings.plausible_size(name) for name in free])
    errors = {name: nominal(name) for name in free}
    starts = [first_start(stretch, errors) for stretch in stretches]
    chosen = list(noises) if noises is not None else [Noise.white(len(s.shown)) for s in stretches]
    size = len(free) + len(START) * len(stretches)
    prior = np.zeros(size)
    prior[: len(free)] = 1.0 / plausible**2
    prior[len(free) :] = np.tile(
        [1.0 / _SPEED_AT_START**2] * 3 + [1.0 / _TURN_AT_START**2] * 2, len(stretches)
    )
    origin = np.zeros(size)
    looked, number, converged = noises is not None, 0, False
    parts: list[StretchFit] = []
    while True:
        latest = [
            _linearized(
                stretch, settings, errors, start, free, noise, look=not looked and number > 0
            )
            for stretch, start, noise in zip(stretches, starts, chosen, strict=True)
        ]
        sound = [one for one in latest if one is not None]
        if len(sound) < len(latest):
            return _lost(free, errors, parts, number)
        parts = sound
        if not looked and number:
            chosen = [part.noise for part in parts]
            looked = number >= 2
        H, g = np.diag(prior), -prior * origin
        for place, part in enumerate(parts):
            columns = _columns(place, len(free))
            S, left = _counted(part.S, part.left), np.nan_to_num(part.left)
            flat = S.reshape(-1, S.shape[2])
            weighted = (part.gain.weight @ S).reshape(flat.shape)
            H[np.ix_(columns, columns)] += flat.T @ weighted
            g[columns] += weighted.T @ left.ravel()
        scale = 1.0 / np.sqrt(H.diagonal())
        scaled = np.linalg.inv(H * scale * scale[:, None] + _RIDGE * np.eye(size))
        covariance = scaled * scale * scale[:, None]
        step = covariance @ g
        if number >= most or (looked and converged):
            break
        converged = bool((np.abs(step) <= _SETTLED * np.sqrt(covariance.diagonal())).all())
        number += 1
        step = _limited(step, free, errors)
        turns = np.abs(step[len(free) :].reshape(-1, len(START))[:, 3:]).max()
        step *= min(1.0, _LARGEST_TURN / max(turns, 1e-300))
        origin += step
        errors = {
            name: errors[name] + float(change) for name, change in zip(free, step, strict=False)
        }
        starts = [
            start.moved(step[_columns(place, len(free))[len(free) :]])
            for place, start in enumerate(starts)
        ]
    cost = sum(
        float(unlikelihood(part.left[None], part.gain.covariance[None])[0]) for part in parts
    )
    if bounds:
        covariance = joint_covariance(
            [
                Part(S=part.S, v=part.left, W=part.gain.weight, columns=_columns(place, len(free)))
                for place, part in enumerate(parts)
            ],
            size,
            prior=np.diag(prior),
        )
    return Fit(
        free=free,
        errors=errors,
        covariance=covariance[: len(free), : len(free)],
        stretches=tuple(parts),
        unlikelihood=cost + float(prior @ origin**2),
        iterations=number,
        converged=converged,
    )


def _lost(
    free: tuple[str, ...],
    errors: Mapping[str, float],
    parts: Sequence[StretchFit],
    number: int,
) -> Fit:
    """Return what there is of a fit that left all bounds."""
    return Fit(
        free=free,
        errors=errors,
        covariance=np.full((len(free), len(free)), np.inf),
        stretches=tuple(parts),
        unlikelihood=np.inf,
        iterations=number,
        converged=False,
    )


def _columns(place: int, shared: int) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    first = shared + len(START) * place
    return np.concatenate((np.arange(shared), np.arange(first, first + len(START))))


def _counted(S: FloatArray, left: FloatArray) -> FloatArray:
    return np.where(np.isfinite(left)[:, :, None], S, 0.0)


def _limited(step: FloatArray, free: Sequence[str], errors: Mapping[str, float]) -> FloatArray:
    """Return the step with scales kept away from zero and delays within reason."""
    found = step.copy()
    for place, name in enumerate(free):
        value = errors[name] + step[place]
        if name.endswith(".scale"):
            value = min(max(value, 0.1), 10.0)
        elif name.endswith(".delay"):
            value = min(max(value, -_LARGEST_DELAY), _LARGEST_DELAY)
        found[place] = value - errors[name]
    return found


def _linearized(
    stretch: Stretch,
    settings: CompatibilitySettings,
    errors: Mapping[str, float],
    start: Start,
    free: Sequence[str],
    noise: Noise,
    *,
    look: bool,
) -> StretchFit | None:
    """Return a stretch with all that a step needs; None where the motion left all bounds."""
    found = predict(stretch, errors, start)
    if not np.abs(found.path.velocity).max() < _FASTEST:
        return None
    shown = np.column_stack([stretch.shown[name] for name in found.channels])
    counted = np.isfinite(shown)
    predictor = predictor_for(stretch, found, settings.rate)
    v = averaged(shown - found.computed, counted, predictor.width)
    if look:
        noise = likeliest_noise(predictor, v, noise)
    S = averaged(sensitivities(stretch, errors, start, found, free), counted, predictor.width)
    chosen = gain(predictor, noise)
    left = whitened(predictor, chosen.K, v[:, :, None])[:, :, 0]
    if not np.nanmax(np.abs(left)) < _FASTEST:
        return None
    _as_predicted(S, averaged(shown, counted, predictor.width) - left, found, free, errors,
                  predictor, noise, chosen)  # fmt: skip
    return StretchFit(
        stretch=stretch,
        start=start,
        found=found,
        predictor=predictor,
        noise=noise,
        gain=chosen,
        left=left,
        S=np.nan_to_num(whitened(predictor, chosen.K, S)),
    )


def _as_predicted(
    S: FloatArray,
    shown: FloatArray,
    found: Prediction,
    free: Sequence[str],
    errors: Mapping[str, float],
    predictor: Predictor,
    noise: Noise,
    chosen: Gain,
) -> None:
    """Let scale and delay of vanes see the motion as predicted, not as integrated.

    Where an aircraft hardly moves, integrated noise is all the motion there seems to be; a vane
    that does not follow it would be given a scale of zero. The prediction has had most of that
    noise taken out. Where the noise left is still not small beside the motion, the stretch has
    no say.

    Parameters
    ----------
    S : ndarray, shape (m, n_channels, n_free + 5)
        Of averages; changed.
    shown : ndarray, shape (m, n_channels)
        Averages that the predictor expects.
    """
    R = noise.show * predictor.show
    late = np.maximum(chosen.covariance.diagonal() - R, 0.0)
    Q = np.einsum("d,dij->ij", noise.drive * predictor.drive, predictor.process)
    H = predictor.H.mean(axis=0)
    walked = np.einsum("ri,ij,rj->r", H, Q, H)
    for row, name in enumerate(found.channels):
        scale = errors.get(f"{name}.scale", 1.0)
        ideal = (shown[:, row] - errors.get(f"{name}.bias", 0.0)) / scale
        if f"{name}.scale" in free:
            seen = np.nanvar(ideal) > _MOTION_OVER_NOISE * late[row]
            S[:, row, free.index(f"{name}.scale")] = ideal if seen else 0.0
        if f"{name}.delay" in free:
            # Backwards: what is shown now must not be in the expectation it is compared with.
            change = np.diff(ideal, prepend=ideal[:1])
            seen = np.nanmean(change**2) > _MOTION_OVER_NOISE * walked[row]
            S[:, row, free.index(f"{name}.delay")] = (
                -scale * np.nan_to_num(change) / predictor.step if seen else 0.0
            )


def scale_bounds(
    found: Fit, settings: CompatibilitySettings, channels: Sequence[str]
) -> dict[str, float]:
    """Return how well the scale of each channel would be known were it free beside the others.

    Infinite where the data do not see it.
    """
    names = [f"{name}.scale" for name in channels]
    free = (*found.free, *(name for name in names if name not in found.free))
    size = len(free) + len(START) * len(found.stretches)
    H = np.zeros((size, size))
    places = np.arange(len(found.free))
    H[places, places] = 1.0 / np.array([settings.plausible_size(n) for n in found.free]) ** 2
    H[range(len(free), size), range(len(free), size)] = 1e-6
    for place, one in enumerate(found.stretches):
        part = _linearized(
            one.stretch, settings, found.errors, one.start, free, one.noise, look=False
        )
        if part is None:
            continue
        columns = _columns(place, len(free))
        S = _counted(part.S, part.left)
        flat = S.reshape(-1, S.shape[2])
        H[np.ix_(columns, columns)] += flat.T @ (part.gain.weight @ S).reshape(flat.shape)
    bounds = {}
    for name, label in zip(channels, names, strict=True):
        own = free.index(label)
        others = [k for k in range(size) if k != own and not len(found.free) <= k < len(free)]
        information = H[own, own]
        if own < len(found.free):
            information -= 1.0 / settings.plausible_size(label) ** 2
        rest = H[np.ix_(others, others)]
        scale = 1.0 / np.sqrt(rest.diagonal())
        shared = H[others, own] * scale
        information -= shared @ np.linalg.solve(rest * scale * scale[:, None], shared)
        bounds[name] = float(information**-0.5) if information > 1e-9 else np.inf
    return bounds
