"""An answer parted into what the sticks did and what the air did.

The answer without gusts, ``X theta``, follows from the surfaces as measured, from sticks held, from
the state in which it began and from each channel's zero error. Gusts are pushes ``w`` of unknown
size on the angle of attack or of sideslip, one every `DOUBLETS.gust_step`: the vanes show them at
once, and the aircraft answers as it does to any such angle. Both are found together, with what is
known of them beforehand:

    y = X theta + H w + e

How strong the gusts are, and how noisy each channel is, follows from the answer itself: expectation
maximization. What an instrument alone shows and no gust makes, as vibration does that the sampling
folds down, stays noise.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import toeplitz

from gsapp.excitation.doublets.settings import DOUBLETS
from gsapp.quantities import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class ResponseParts:
    """Standard deviations of the parts of one channel's answer, SI.

    Attributes
    ----------
    without_gusts : float
        Without gusts.
    gusts : float
        Of what gusts added.
    """

    without_gusts: float
    gusts: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ResponseChannel:
    """One channel's answer and what it may consist of.

    Attributes
    ----------
    samples : ndarray, shape (n,)
        SI; NaN where missing.
    responses : ndarray, shape (n, n_unknown)
        To everything but gusts.
    gust_response : ndarray, shape (n,)
        Response to a push of the air at the first sample, SI per rad.
    noise : float
        Standard deviation of a sample where nothing happens, SI.
    """

    samples: FloatArray
    responses: FloatArray
    gust_response: FloatArray
    noise: float


def separate_gusts(
    channels: Sequence[ResponseChannel], known: tuple[FloatArray, FloatArray], rate: float
) -> list[ResponseParts]:
    """Part the answer of all channels of one axis.

    Parameters
    ----------
    channels : sequence of ResponseChannel
    known : tuple of ndarray, shape (m, n_unknown) and (m,)
        What is known beforehand of the unknowns that are no gusts, each row in its own standard
        deviations.
    rate : float
        Samples per second.

    Returns
    -------
    list of Parts
        In the order of the channels. The gusts' part counts what is not known of the pushes as
        well: an estimate alone would always be too small.
    """
    step = max(round(DOUBLETS.gust_step * rate), 1)
    blocks = [_average(one, step) for one in channels]
    size = known[0].shape[1]
    pushes = blocks[0].pushes.shape[1]
    push = DOUBLETS.initial_gust
    noise = [block.least for block in blocks]
    for _ in range(DOUBLETS.gust_iterations):
        found, spread = _solve(blocks, noise, push, known)
        gusts = found[size:]
        unknown = float(np.trace(spread[size:, size:]))
        push = max(math.sqrt((float(gusts @ gusts) + unknown) / pushes), DOUBLETS.min_gust)
        noise = [block.noise(found, spread) for block in blocks]
    return [block.parts(found, spread, size) for block in blocks]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Block:
    """Means over `DOUBLETS.gust_step` of a channel, its responses and its gust responses."""

    samples: FloatArray
    responses: FloatArray
    pushes: FloatArray
    least: float

    @property
    def columns(self) -> FloatArray:
        return np.hstack((self.responses, self.pushes))

    def noise(self, found: FloatArray, spread: FloatArray) -> float:
        """Return the noise that leaves so much over."""
        columns = self.columns
        rest = self.samples - columns @ found
        square = float(rest @ rest) + float(((columns @ spread) * columns).sum())
        return max(math.sqrt(square / max(rest.size, 1)), self.least)

    def parts(self, found: FloatArray, spread: FloatArray, size: int) -> ResponseParts:
        """Return how large both parts are."""
        pushed = self.pushes - self.pushes.mean(axis=0)
        unknown = float(((pushed @ spread[size:, size:]) * pushed).sum()) / len(pushed)
        gusts = float(np.var(self.pushes @ found[size:]))
        calm = float(np.std(self.responses @ found[:size]))
        return ResponseParts(without_gusts=calm, gusts=math.sqrt(gusts + unknown))


def _average(one: ResponseChannel, step: int) -> _Block:
    count = one.samples.size // step
    there = np.isfinite(one.samples)
    place = np.arange(one.samples.size)
    whole = np.interp(place, place[there], one.samples[there])

    def means(values: FloatArray) -> FloatArray:
        blocks = values[: count * step].reshape(count, step, *values.shape[1:])
        return np.asarray(blocks.mean(axis=1))

    kept = means(there.astype(np.float64)) > 0.5
    after = means(one.gust_response)
    samples = means(whole)[kept]
    return _Block(
        samples=samples,
        responses=means(one.responses)[kept],
        pushes=toeplitz(after, np.zeros(count))[kept],
        least=max(
            one.noise / math.sqrt(step), DOUBLETS.min_noise_share * float(samples.std()), 1e-9
        ),
    )


def _solve(
    blocks: Sequence[_Block],
    noise: Sequence[float],
    push: float,
    known: tuple[FloatArray, FloatArray],
) -> tuple[FloatArray, FloatArray]:
    """Return the unknowns, pushes last, and their covariance."""
    rows, sides = known
    size, pushes = rows.shape[1], blocks[0].pushes.shape[1]
    normal = np.zeros((size + pushes, size + pushes))
    normal[:size, :size] = rows.T @ rows
    normal[range(size, size + pushes), range(size, size + pushes)] = 1.0 / push**2
    side = np.concatenate((rows.T @ sides, np.zeros(pushes)))
    for block, deviation in zip(blocks, noise, strict=True):
        columns = block.columns / deviation
        normal += columns.T @ columns
        side += columns.T @ (block.samples / deviation)
    # Angles beside accelerations: of one scale they are told apart to the last digit.
    scale = 1.0 / np.sqrt(np.diag(normal) + 1e-30)
    scaled = normal * np.outer(scale, scale) + 1e-12 * np.eye(scale.size)
    spread = np.linalg.inv(scaled) * np.outer(scale, scale)
    return spread @ side, spread
