"""Regression in the frequency domain, with bounds for colored noise and forgetting.

For each of U moments and each of three equations, X = transforms of qbar x, Y = of qbar C, with
the real and imaginary parts one over the other (so that theta = Re(X* X)^-1 Re(X* Y), (8.1.15),
is plain least squares):

1. Trim, drift and the noise of the two end samples are projected out of X and Y: columns
   transform(qbar), transform(qbar t), and unit pulses at the ends.
2. G = X'X, b = X'Y, over the variance of the residuals, so that a rough record counts for less
   than a calm one; earlier records add theirs; theta = (G - N)^-1 b, N being what white noise of
   vanes and surfaces made of the diagonal of G.
3. cov = (G - N)^-1 [X' R X + earlier] (G - N)^-1, widened by what the level of the residuals is
   uncertain by (`_wider`). R, the covariance of the residuals, follows from their
   local level s_k and from how the weights in time couple frequencies,

       Gam_kl = s_k s_l K(w_k - w_l),   Psi_kl = s_k s_l K(w_k + w_l),
       K(w) = sum wt_i^2 exp(-j w t_i) / sum wt_i^2,

   s_k^2 = |e_k|^2 averaged over five neighbors, over the share that the fit left there (on
   average (2m - n)/2m). (8.1.17), printed with 1/(m - p), depends on the spacing of the
   frequencies.

Noise in the regressors shrinks derivatives. White noise of vanes and surfaces is taken off G.
That of the gyros is not white (engine vibration folds into it), and reaches the flow angles, too,
where these are moved to the CG. What of the rates goes with the residuals
e of the moment equations is F e, with F = (j w I - qbar b/2V D)^-1 (I inertia, D the
damping derivatives), whether e is noise of the gyros, e = F^-1 n, or a gust's moment that the
rates answer to. So Re sum conj(L F e) e', L being what an error of the rates makes of the
regressors and e' the residuals of any equation, is what X'Y holds too much; it is taken out of b
before the last solution, and |L F e|^2 is noise that excitation is measured against. In the
force equations half of it is taken out (`AxisBody.trust`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cache

import numpy as np
import numpy.typing as npt
from numpy.lib.stride_tricks import as_strided

from gsapp.identification.ftr.equations import AxisBody
from gsapp.identification.ftr.settings import Band
from gsapp.identification.ftr.transform import ComplexArray, Transforms
from gsapp.quantities import FloatArray

_TINY = 1e-9
"""Share of its natural size below which a column is taken as zero."""
_NEIGHBORS = 5
_FIRM = 8.0
"""Real equations that the roughness of earlier records counts for in the weight of a record."""
_NUISANCES = 4


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Information:
    """What closed records say about the three equations of one axis; sums over records.

    Attributes
    ----------
    G : ndarray, shape (3, p, p)
    b : ndarray, shape (3, p)
    meat : ndarray, shape (3, p, p)
        X' R X.
    rss, freedom : ndarray, shape (3,)
        Squared residuals over the squared weights of the samples; real equations less unknowns.
    variation : ndarray, shape (3,)
        Integral of (qbar C)^2 in the band, trim and drift taken out.
    noise : ndarray, shape (3, p)
        Share of the diagonal of G that noise of the regressors makes.
    white : ndarray, shape (3, p)
        What of it is to be taken off the diagonal: white noise of what is no rate.
    mean : ndarray, shape (3, p + 2)
        Sums at zero frequency of qbar x, qbar, qbar C.
    mean_noise : ndarray, shape (3,)
        Variance of the last of these.
    listened : ndarray, shape (3,)
        s.
    pressure : ndarray, shape (3,)
        Integral of qbar^2 over that time, Pa^2 s.
    spread : ndarray, shape (3, p)
        Integral of (qbar x)^2 in the band.
    weighty : ndarray, shape (3, p)
        Squared diagonal of G over freedom: tells how many records share the weight.
    """

    G: FloatArray
    b: FloatArray
    meat: FloatArray
    rss: FloatArray
    freedom: FloatArray
    variation: FloatArray
    noise: FloatArray
    white: FloatArray
    mean: FloatArray
    mean_noise: FloatArray
    listened: FloatArray
    pressure: FloatArray
    spread: FloatArray
    weighty: FloatArray

    @staticmethod
    def none(p: int) -> Information:
        """Return the information of no record at all."""
        return Information(
            G=np.zeros((3, p, p)),
            b=np.zeros((3, p)),
            meat=np.zeros((3, p, p)),
            rss=np.zeros(3),
            freedom=np.zeros(3),
            variation=np.zeros(3),
            noise=np.zeros((3, p)),
            white=np.zeros((3, p)),
            mean=np.zeros((3, p + 2)),
            mean_noise=np.zeros(3),
            listened=np.zeros(3),
            pressure=np.zeros(3),
            spread=np.zeros((3, p)),
            weighty=np.zeros((3, p)),
        )

    def plus(self, other: Information) -> Information:
        """Return the information of both together."""
        return Information(
            **{one.name: getattr(self, one.name) + getattr(other, one.name) for one in fields(self)}
        )

    def faded(self, share: float) -> Information:
        """Return the information with the signals behind it faded to a share."""
        square = share * share
        powers = {
            "meat": square * square,
            "weighty": square * square,
            "mean": share,
            "freedom": 1.0,
        }
        return Information(
            **{
                one.name: powers.get(one.name, square) * getattr(self, one.name)
                for one in fields(self)
            }
        )

    def at(self, moments: slice) -> Information:
        """Return some of several moments."""
        return Information(**{name: getattr(self, name)[moments] for name in _NAMES})

    def of(self, equations: npt.NDArray[np.bool_]) -> Information:
        """Return what some of the equations say, shape (3,) of bool; nothing for the others."""
        return Information(
            **{
                one.name: np.where(
                    equations.reshape((3,) + (1,) * (getattr(self, one.name).ndim - 1)),
                    getattr(self, one.name),
                    0.0,
                )
                for one in fields(self)
            }
        )

    def state(self) -> dict[str, npt.NDArray[np.generic]]:
        """Return the arrays by name."""
        return {name: getattr(self, name) for name in _NAMES}

    @staticmethod
    def from_state(state: Mapping[str, npt.NDArray[np.generic]]) -> Information:
        """Return what `state` was made from."""
        names = (one.name for one in fields(Information))
        return Information(**{name: np.array(state[name], dtype=np.float64) for name in names})


_NAMES = tuple(one.name for one in fields(Information))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Solution:
    """Estimates at U moments, from one axis's three equations.

    Attributes
    ----------
    theta : ndarray, shape (U, 3, p)
    covariance : ndarray, shape (U, 3, p, p)
        Honest.
    plain : ndarray, shape (U, 3, p)
        Standard deviation if residuals were white.
    bias, bias_std : ndarray, shape (U, 3)
        The constant part of the coefficient; the zero offset of its accelerometer is in its
        bound.
    bias_slopes : ndarray, shape (U, 3, p)
        Derivatives of the bias by theta: minus the mean of each variable.
    signal_to_noise : ndarray, shape (U, 3, p)
        What each variable did on its own (not explained by the others), over its noise.
    alone : ndarray, shape (U, 3, p)
        Share of its energy that a variable had on its own, 0 to 1.
    amplitude : ndarray, shape (U, 3, p)
        Rms of each variable in the band over the time listened to, in its unit.
    uncertain : ndarray, shape (U, 3, p + 1)
        Bound times what the variable did, over what the coefficient did; of the bias, last.
    freedom : ndarray, shape (U, 3)
        Real equations less unknowns.
    listened : ndarray, shape (U, 3)
        Effective time, s.
    correlation : ndarray, shape (U, 3, p, p)
        Of the regressors in the band.
    """

    theta: FloatArray
    covariance: FloatArray
    plain: FloatArray
    bias: FloatArray
    bias_std: FloatArray
    bias_slopes: FloatArray
    signal_to_noise: FloatArray
    alone: FloatArray
    amplitude: FloatArray
    uncertain: FloatArray
    freedom: FloatArray
    listened: FloatArray
    correlation: FloatArray

    @staticmethod
    def joined(parts: Sequence[Solution]) -> Solution:
        """Return moments one after the other."""
        if len(parts) == 1:
            return parts[0]
        return Solution(
            **{
                one.name: np.concatenate([getattr(part, one.name) for part in parts])
                for one in fields(Solution)
            }
        )

    def at(self, moment: int) -> Solution:
        """Return one moment (U = 1)."""
        place = moment % len(self.theta)
        return Solution(
            **{one.name: getattr(self, one.name)[place : place + 1].copy() for one in fields(self)}
        )

    def state(self) -> dict[str, npt.NDArray[np.generic]]:
        """Return the arrays by name."""
        return {one.name: getattr(self, one.name) for one in fields(self)}

    @staticmethod
    def from_state(state: Mapping[str, npt.NDArray[np.generic]]) -> Solution:
        """Return what `state` was made from."""
        names = (one.name for one in fields(Solution))
        return Solution(**{name: np.array(state[name], dtype=np.float64) for name in names})


def chosen_frequencies(
    listened: float, band: Band, spacing: float, count: int, p: int
) -> tuple[int, int]:
    """Return the step between the frequencies that a record resolves, and the first, in steps.

    The first is zero where there are too few.

    Parameters
    ----------
    listened : float
        Effective length, s.
    band : Band
    spacing : float
        Of the frequencies transformed, Hz.
    count : int
        How many there are, zero included.
    p : int
        Derivatives of an equation.
    """
    if listened <= 0.0:
        return 1, 0
    step = max(1, int(np.ceil(1.0 / (listened * spacing) - 1e-3)))
    lowest = max(band.lowest, 2.0 / listened)
    first = max(1, int(np.ceil(lowest / (spacing * step) - 1e-3)))
    number = (count - 1) // step + 1 - first
    return (step, first) if 2 * number >= p + _NUISANCES + 2 else (1, 0)


def solve(
    transforms: Transforms, band: Band, spacing: float, past: Information, body: AxisBody
) -> tuple[Solution, Information]:
    """Return the estimates at U moments, and what the record says by itself at the last one.

    Parameters
    ----------
    transforms : Transforms
        Of the record that is open.
    band : Band
    spacing : float
        Of the frequencies transformed, Hz.
    past : Information
        Of the records before it, at each moment: arrays of shape (U, 3, ...).
    body : AxisBody
    """
    p = transforms.signals.shape[2] - 7
    count = len(transforms.frequencies)
    choices = [
        chosen_frequencies(length, band, spacing, count, p)
        for length in transforms.listened.tolist()
    ]
    parts: list[Solution] = []
    latest = Information.none(p)
    for moments, step in _alike(choices):
        firsts = [first for _, first in choices[moments]]
        solution, latest = _solve_together(
            transforms.part(moments, step), firsts, past.at(moments), body
        )
        parts.append(solution)
    return Solution.joined(parts), latest


def _alike(choices: Sequence[tuple[int, int]]) -> list[tuple[slice, int]]:
    """Return stretches of moments with the same step between frequencies, and that step.

    Moments without frequencies go with any.
    """
    found: list[tuple[slice, int]] = []
    start, step = 0, 0
    for place, (own, first) in enumerate(choices):
        if first == 0:
            continue
        if step not in (0, own):
            found.append((slice(start, place), step))
            start = place
        step = own
    return [*found, (slice(start, len(choices)), max(step, 1))]


def _solve_together(
    transforms: Transforms, firsts: Sequence[int], past: Information, body: AxisBody
) -> tuple[Solution, Information]:
    """Return what `solve` does, from all frequencies not below the first of each moment."""
    p = transforms.signals.shape[2] - 7
    count = len(transforms.frequencies)
    keep = _together(_kept, firsts, count)
    number = keep.sum(axis=1)
    if not number.any():
        return _conclude(past, None, body), Information.none(p)
    pressure, turning = transforms.pressure, transforms.turning
    listened, squared = transforms.listened, transforms.squared
    signals = _real(transforms.signals[:, 1:])
    if not keep.all():
        signals *= np.concatenate((keep, keep), axis=1)[:, :, np.newaxis]
    # Natural sizes: a constant coefficient of one, a drift by one over the record, one sample.
    one = np.ones(len(keep))
    sizes = np.stack((pressure * listened, pressure * listened**2, one, one), axis=1)
    basis, used = _orthonormal(signals[:, :, p + 3 :], sizes)
    moved = signals[:, :, : p + 3]
    moved = moved - basis @ (np.swapaxes(basis, 1, 2) @ moved)
    X, Y = moved[:, :, :p], moved[:, :, p:]
    products = np.swapaxes(moved, 1, 2) @ moved
    G_own, b_own = products[:, :p, :p], products[:, p:, :p]
    energy = np.diagonal(products, axis1=1, axis2=2)[:, p:]
    counts = np.where(transforms.broken, 0.0, (number > 0)[:, np.newaxis] * 1.0)
    # White noise of variance v in one sample gives v times the squared weights at any frequency.
    sample = transforms.noise * body.sharpness
    times = (squared * number)[:, np.newaxis]
    white_own = np.minimum(sample, body.noise * (pressure**2)[:, np.newaxis]) * times
    # Before its residuals are known, a record is taken to be as rough as those before it.
    known = past.freedom > 0.0
    usual = squared[:, np.newaxis] * past.rss / np.where(known, past.freedom, 1.0)
    least = _TINY * energy / np.maximum(number, 1.0)[:, np.newaxis] + 1e-300
    weight = counts / np.where(known, np.maximum(usual, least), 1.0)
    b = past.b + weight[:, :, np.newaxis] * b_own
    alone = not known.any()
    inverse = _inverse(
        G_own[:, np.newaxis]
        if alone
        else past.G + weight[:, :, np.newaxis, np.newaxis] * G_own[:, np.newaxis]
    )
    theta = (inverse @ b[..., np.newaxis])[..., 0]
    residual = Y - X @ np.swapaxes(theta, 1, 2)
    # How many of the unknowns this record had to pay for, and where.
    pairs = (X[:, :, :, np.newaxis] * X[:, :, np.newaxis, :]).reshape(*X.shape[:2], p * p)
    each_way = (weight[:, :, np.newaxis, np.newaxis] * inverse).reshape(-1, 3, p * p)
    lever = pairs @ np.swapaxes(each_way, 1, 2)
    freedom = 2.0 * number[:, np.newaxis] - used[:, np.newaxis] - lever.sum(axis=1)
    scale = 2.0 * number[:, np.newaxis] / np.maximum(freedom, 1.0)
    some = _FIRM * known
    rough = (_energy(residual) + some * usual) / np.maximum(freedom + some, 1.0)
    weight = counts / np.maximum(rough, least)
    each = weight[:, :, np.newaxis]
    G = each[..., np.newaxis] * G_own[:, np.newaxis]
    white = each * white_own[:, np.newaxis]
    if alone:
        inverse = (
            inverse * np.where(each > 0.0, 1.0 / np.where(each > 0.0, each, 1.0), 0.0)[..., None]
        )
    else:
        inverse = _inverse(past.G + G)
    inverse = _cleaned(inverse, past.white + white)

    omega = 2.0 * np.pi * transforms.frequencies[1:]
    answer = _answer(residual, theta, body, turning, omega)
    moments = list(body.equations)
    # What of the regressors goes with the residuals: rates, and flow angles moved to the CG.
    reach = body.reach * turning[:, np.newaxis, np.newaxis]
    moving = answer @ np.swapaxes(reach, 1, 2)
    excess = np.swapaxes(residual, 1, 2) @ moving * (scale * body.trust)[:, :, np.newaxis]
    b_own = b_own - excess
    b = past.b + each * b_own
    theta = (inverse @ b[..., np.newaxis])[..., 0]
    residual = Y - X @ np.swapaxes(theta, 1, 2)

    near = _together(_neighbors, firsts, count)
    # The fit takes most of what there is at the lowest frequencies, where trim and motion lie.
    lever += np.einsum("urk,urk->ur", basis, basis)[..., np.newaxis]
    taken = _paired(lever)
    left = np.maximum(near @ (2.0 * keep[:, :, np.newaxis] - taken), 0.1)
    level = np.sqrt(2.0 * (near @ _paired(residual**2)) / left)
    meat = _meat(X, level, _coupling(transforms.correlation, count))

    hertz = float(transforms.frequencies[1])
    still, shaken = sample * times, _energy(moving) * scale[:, moments].max(axis=1)[:, np.newaxis]
    noise = np.where(body.turns, np.maximum(still, shaken), still + shaken)
    at_zero = transforms.signals[:, 0].real
    mean = np.empty((len(keep), 3, p + 2))
    mean[:, :, :p] = at_zero[:, np.newaxis, :p]
    mean[:, :, p] = at_zero[:, p + 3, np.newaxis]
    mean[:, :, p + 1] = at_zero[:, p : p + 3]
    # At zero frequency all power is real; the noise of the ends is not among the residuals.
    lowest = level[np.arange(len(keep)), np.argmax(keep, axis=1)]
    plain = counts[:, :, np.newaxis]
    diagonal = np.diagonal(G_own, axis1=1, axis2=2)
    own = Information(
        G=G,
        b=each * b_own,
        meat=(each**2)[..., np.newaxis] * meat,
        rss=counts * _energy(residual) / np.where(squared > 0.0, squared, 1.0)[:, None],
        freedom=counts * freedom,
        variation=counts * 2.0 * hertz * energy,
        noise=each * noise[:, np.newaxis],
        white=white,
        mean=plain * mean,
        mean_noise=counts * (lowest**2 + transforms.end_noise),
        listened=counts * listened[:, np.newaxis],
        pressure=counts * (pressure**2 * listened)[:, np.newaxis],
        spread=plain * (2.0 * hertz * diagonal)[:, np.newaxis],
        weighty=(each * diagonal[:, np.newaxis]) ** 2 / np.maximum(freedom, 1.0)[:, :, np.newaxis],
    )
    last = Information(**{name: getattr(own, name)[-1] for name in _NAMES})
    return _conclude(own.plus(past), inverse, body), last


def _together(
    made: Callable[[int, int], FloatArray], firsts: Sequence[int], count: int
) -> FloatArray:
    """Return what is made for each moment's first frequency, one array for all if they agree."""
    if all(first == firsts[0] for first in firsts):
        one = made(firsts[0], count)
        return np.broadcast_to(one, (len(firsts), *one.shape))
    return np.stack([made(first, count) for first in firsts])


def _energy(rows: FloatArray) -> FloatArray:
    """Return the sums of squares over rows, (U, 2 m, e) -> (U, e)."""
    return np.asarray(np.einsum("ure,ure->ue", rows, rows), dtype=np.float64)


def solve_past(past: Information, body: AxisBody) -> Solution:
    """Return the estimates from closed records alone (U = 1)."""
    return _conclude(stacked([past]), None, body)


def stacked(several: Sequence[Information]) -> Information:
    """Return information at several moments, arrays of shape (U, 3, ...)."""
    if all(each is several[0] for each in several):
        return Information(
            **{
                name: np.broadcast_to(one, (len(several), *one.shape))
                for name, one in several[0].state().items()
            }
        )
    return Information(
        **{
            one.name: np.stack([getattr(each, one.name) for each in several])
            for one in fields(Information)
        }
    )


def _conclude(information: Information, inverse: FloatArray | None, body: AxisBody) -> Solution:
    """Return estimates and their qualities from information of shape (U, 3, ...).

    `inverse` is that of G, where it is known.
    """
    G = information.G
    p = G.shape[-1]
    if inverse is None:
        inverse = _cleaned(_inverse(G), information.white)
    theta = (inverse @ information.b[..., np.newaxis])[..., 0]
    diagonal: FloatArray = np.diagonal(G, axis1=2, axis2=3)
    wide = _wider(diagonal**2 / np.maximum(information.weighty, 1e-300))
    covariance = inverse @ information.meat @ inverse
    covariance *= wide[..., np.newaxis] * wide[..., np.newaxis, :]
    there = diagonal > 0.0
    spread = np.where(there, np.diagonal(inverse, axis1=2, axis2=3), 1.0)
    own = np.where(there, np.minimum(1.0 / spread, diagonal), 0.0)
    freedom = information.freedom
    # Records are weighted by one over the variance of their residuals.
    plain = np.sqrt(np.maximum(np.diagonal(inverse, axis1=2, axis2=3), 0.0))
    base = information.mean[..., p]
    safe = np.where(base > 0.0, base, 1.0)
    slopes = -information.mean[..., :p] / safe[..., np.newaxis]
    bias = information.mean[..., p + 1] / safe + (slopes * theta).sum(axis=-1)
    through = (slopes[..., np.newaxis, :] @ covariance @ slopes[..., np.newaxis])[..., 0, 0]
    # The mean square of qbar over the time listened to.
    square = information.pressure / np.maximum(information.listened, 1e-300)
    zero = body.offset**2 / np.where(square > 0.0, square, 1.0)
    bias_std = np.sqrt(np.maximum(through + information.mean_noise / safe**2 + zero, 0.0))
    std = np.sqrt(np.maximum(np.diagonal(covariance, axis1=2, axis2=3), 0.0))
    variation = np.sqrt(np.maximum(information.variation, 1e-300))
    uncertain = np.concatenate(
        (
            std * np.sqrt(information.spread) / variation[..., np.newaxis],
            (bias_std * np.sqrt(information.pressure) / variation)[..., np.newaxis],
        ),
        axis=-1,
    )
    noise = np.maximum(information.noise, 1e-300)
    # What white noise made of G is taken off already.
    left = information.noise - information.white
    scale = np.sqrt(np.where(there, diagonal, 1.0))
    return Solution(
        theta=theta,
        covariance=covariance,
        plain=plain,
        bias=bias,
        bias_std=bias_std,
        bias_slopes=slopes,
        signal_to_noise=np.sqrt(np.maximum(own - left, 0.0) / noise),
        alone=np.where(there, own / np.where(there, diagonal, 1.0), 0.0),
        amplitude=np.sqrt(
            information.spread / np.maximum(information.pressure, 1e-300)[..., np.newaxis]
        ),
        uncertain=uncertain,
        freedom=freedom,
        listened=information.listened,
        correlation=G / (scale[..., np.newaxis] * scale[..., np.newaxis, :]),
    )


def _wider(freedom: FloatArray) -> FloatArray:
    """Return what widens bounds so that three of them hold as much as of a normal distribution.

    The level of the residuals is itself estimated, around each frequency from its neighbors: as
    if from two thirds of all residuals. (Student's quantile over three, expanded.)
    """
    levels = np.maximum(2.0 / 3.0 * freedom, 4.0)
    return np.asarray(1.0 + 2.5 / levels + 5.75 / levels**2, dtype=np.float64)


# --- small linear algebra, for many moments at once ---------------------------------------------


def _real(transform: ComplexArray) -> FloatArray:
    """Return real parts over imaginary parts, shape (U, 2 m, columns)."""
    return np.concatenate((transform.real, transform.imag), axis=1)


def _orthonormal(columns: FloatArray, sizes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return an orthonormal basis of columns, and how many of them were not zero.

    Columns of the nuisance may vanish (the transform of a constant does at multiples of 1/T) or
    repeat: the basis then holds zeros in their place.
    """
    basis = np.ascontiguousarray(columns.transpose(2, 0, 1))
    basis /= np.maximum(sizes.T, 1e-300)[:, :, np.newaxis]
    lengths = np.sqrt(np.einsum("kur,kur->ku", basis, basis))
    used = np.zeros(len(columns))
    for place in range(len(basis)):
        one = basis[place]
        for other in basis[:place]:
            one -= np.einsum("ur,ur->u", other, one)[:, np.newaxis] * other
        left = np.sqrt(np.einsum("ur,ur->u", one, one))
        counts = left > np.maximum(1e-6 * lengths[place], _TINY)
        one *= (counts / np.where(counts, left, 1.0))[:, np.newaxis]
        used += counts
    return np.ascontiguousarray(basis.transpose(1, 2, 0)), used


def _paired(rows: FloatArray) -> FloatArray:
    """Return sums of what belongs to real and imaginary parts, (U, 2 m, e) -> (U, m, e)."""
    half = rows.shape[1] // 2
    return np.asarray(rows[:, :half] + rows[:, half:], dtype=np.float64)


def _cleaned(inverse: FloatArray, white: FloatArray) -> FloatArray:
    """Return the inverse of G with white noise taken off its diagonal.

    Of each variable up to 1/(2p) of what it did on its own is taken off: then at least half of G
    stays, whatever the variables. More is not needed where the variable was excited enough to be
    shown. Four terms of the series I + T + T^2 + ... , T = G^-1 N, leave out no more than the
    fourth power of that share.
    """
    diagonal = np.maximum(np.diagonal(inverse, axis1=-2, axis2=-1), 1e-300)
    less = np.minimum(white, 0.5 / diagonal.shape[-1] / diagonal)
    T = inverse * less[..., np.newaxis, :]
    first = inverse + T @ inverse
    return np.asarray(first + T @ (T @ first), dtype=np.float64)


def _inverse(G: FloatArray) -> FloatArray:
    """Return the inverse of scaled normal matrices; a variable that did nothing gets zeros."""
    p = G.shape[-1]
    diagonal = np.diagonal(G, axis1=-2, axis2=-1)
    there = diagonal > 0.0
    scale = there / np.sqrt(np.where(there, diagonal, 1.0))
    scales = scale[..., np.newaxis] * scale[..., np.newaxis, :]
    scaled = G * scales
    # A hair on the diagonal keeps columns that are equal to the last bit from stopping it all.
    scaled.reshape(-1, p * p)[:, :: p + 1] += np.where(there, 1e-12, 1.0).reshape(-1, p)
    return np.asarray(np.linalg.inv(scaled) * scales, dtype=np.float64)


@cache
def _kept(first: int, count: int) -> FloatArray:
    """Return ones from the first frequency on, zero frequency left out, shape (count - 1,)."""
    kept = np.zeros(count)
    if first > 0:
        kept[first:] = 1.0
    return kept[1:]


@cache
def _neighbors(first: int, count: int) -> FloatArray:
    """Return what averages over five chosen neighbors, fewer at the ends: (count - 1,) squared."""
    places = np.flatnonzero(_kept(first, count))
    order = np.arange(places.size)
    near = (np.abs(order[:, np.newaxis] - order) <= _NEIGHBORS // 2).astype(np.float64)
    out = np.zeros((count - 1, count - 1))
    out[np.ix_(places, places)] = near / np.maximum(near.sum(axis=1, keepdims=True), 1.0)
    return out


def _coupling(correlation: ComplexArray, count: int) -> FloatArray:
    """Return the covariance of real over imaginary residuals of unit level, (U, 2 m, 2 m)."""
    m = count - 1
    # K of a negative frequency is the conjugate. Running forwards and backwards, and half of it,
    # so that all that is added below lies in memory one after the other.
    half = 0.5 * correlation
    around = np.concatenate((half[:, m - 1 :: -1], half[:, 1:m].conj()), axis=1)
    out = np.empty((len(correlation), 2 * m, 2 * m))
    for part, sign, first, second in (
        ("real", 1.0, out[:, :m, :m], out[:, m:, m:]),
        ("imag", -1.0, out[:, m:, :m], out[:, :m, m:]),
    ):
        minus = _windows(np.ascontiguousarray(getattr(around, part)), m)[:, ::-1]
        plus = _windows(np.ascontiguousarray(getattr(half[:, 2:], part)), m)
        np.add(minus, plus, out=first)
        np.subtract(*((minus, plus) if sign > 0.0 else (plus, minus)), out=second)
    return out


def _windows(row: FloatArray, m: int) -> FloatArray:
    """Return m windows of m neighbors each, one place apart, shape (U, m, m), without a copy."""
    along, across = row.strides
    return as_strided(row, (len(row), m, m), (along, across, across), writeable=False)


def _answer(
    residual: FloatArray,
    theta: FloatArray,
    body: AxisBody,
    turning: FloatArray,
    omega: FloatArray,
) -> FloatArray:
    """Return what of the rates goes with the residuals, F e, shape (U, 2 m, number of rates)."""
    half = len(omega)
    equations, rates = list(body.equations), list(body.regressors)
    e = residual[:, :half, equations] + 1j * residual[:, half:, equations]
    D = theta[:, equations][:, :, rates] * turning[:, np.newaxis, np.newaxis]
    A = 1j * omega[:, np.newaxis, np.newaxis] * body.inertia - D[:, np.newaxis]
    if len(rates) == 1:
        answer = e / A[..., 0]
    else:
        determinant = A[..., 0, 0] * A[..., 1, 1] - A[..., 0, 1] * A[..., 1, 0]
        first = A[..., 1, 1] * e[..., 0] - A[..., 0, 1] * e[..., 1]
        second = A[..., 0, 0] * e[..., 1] - A[..., 1, 0] * e[..., 0]
        answer = np.stack((first / determinant, second / determinant), axis=-1)
    return _real(answer)


def _meat(X: FloatArray, level: FloatArray, coupling: FloatArray) -> FloatArray:
    """Return X' R X for each equation, (U, 3, p, p); level has shape (U, m, 3)."""
    moments, rows, p = X.shape
    # Rows of a matrix lie along the frequencies: products of rows are what is quick.
    across = np.swapaxes(np.concatenate((level, level), axis=1), 1, 2)[:, :, np.newaxis]
    weighed = np.ascontiguousarray(across) * np.ascontiguousarray(np.swapaxes(X, 1, 2))[:, None]
    spread = weighed.reshape(moments, 3 * p, rows) @ coupling
    return weighed @ np.swapaxes(spread.reshape(moments, 3, p, rows), 2, 3)
