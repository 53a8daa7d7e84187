"""Bounds of estimates: Cramer-Rao, and corrected for colored residuals (notes, section 7).

The estimate minimizes sum v'Wv (5.1.4), so that theta - truth = H^-1 sum S'W n with the
information H = sum S'WS and the noise n. Its covariance is H^-1 where W is the inverse of the
covariance of white noise, and H^-1 B H^-1 for any W and any noise,

    B = sum_j (1 - |j|/(Lg + 1)) sum_k S_k' W C_j W S_(k+j)

being the covariance of the gradient. C_j, the autocovariance of the noise, comes from the
residuals. These are smaller than the noise by what the fit took for motion, most of it at low
frequency, where it matters: v = n - S H^-1 sum S'W n. Its expectation,

    E v v' = E n n' - (Y S' + S Y'),   Y = Phi W S H^-1 - S cov/2,   Phi n = C * n,

is added back: without it the bound is 5 to 15 % too small for ten seconds at 100 Hz.
All sums over lags are made by FFT.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.linalg.blas import zgemm

from gsapp.identification.statistics.correlation import (
    STATISTICS,
    ComplexArray,
    LagLayout,
    bartlett,
    default_lags,
    residual_autocovariance,
)
from gsapp.quantities import FloatArray


def information_matrix(
    S: FloatArray, W: FloatArray, *, counted: FloatArray | None = None
) -> FloatArray:
    """Return H = sum_k S_k' W S_k, shape (n_parameters, n_parameters).

    Parameters
    ----------
    S : ndarray, shape (n, n_responses, n_parameters)
    W : ndarray, shape (n_responses, n_responses)
    counted : ndarray, shape (n, n_responses), optional
        Residuals, or anything else that is NaN where a sample does not count.
    """
    kept = S if counted is None else _mask_sensitivities(S, counted)
    flat = kept.reshape(-1, kept.shape[2])
    diagonal = W.diagonal()
    if (diagonal >= 0.0).all() and not (W - np.diag(diagonal)).any():
        # A product with itself takes half of the work, and comes out symmetric.
        half = (kept * np.sqrt(diagonal)[:, None]).reshape(flat.shape)
        symmetric: FloatArray = half.T @ half
        return symmetric
    found: FloatArray = flat.T @ (W @ kept).reshape(flat.shape)
    return 0.5 * (found + found.T)


def cramer_rao(S: FloatArray, W: FloatArray, *, counted: FloatArray | None = None) -> FloatArray:
    """Return the Cramer-Rao covariance (sum S'WS)^-1, W = R^-1.

    Parameters as in `information_matrix`. A parameter that the responses do not see, or that lies
    in a combination of which they see nothing, has an infinite variance.
    """
    return invert_information(information_matrix(S, W, counted=counted))


def invert_information(H: FloatArray) -> FloatArray:
    """Return the inverse of an information matrix; infinite variances where it has none."""
    inverted, lost = _inverse(H)
    inverted[lost, lost] = np.inf
    return inverted


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ManeuverFitData:
    """One maneuver of a fit."""

    S: FloatArray  # Shape (n, n_responses, m). By the parameters that this maneuver knows.
    v: FloatArray  # Shape (n, n_responses). Residuals, NaN where a sample does not count.
    W: FloatArray  # Shape (n_responses, n_responses).
    columns: npt.NDArray[np.intp] | None = None
    """Shape (m,). Which parameters of the fit those are; the first m by default."""
    segments: Sequence[slice] | None = None  # Stretches of contiguous samples.


def joint_covariance(
    parts: Sequence[ManeuverFitData],
    size: int,
    *,
    lags: int | None = None,
    prior: FloatArray | None = None,
    passes: int = 1,
) -> FloatArray:
    """Return the honest covariance of parameters fitted to several maneuvers at once.

    Parameters
    ----------
    parts : sequence of ManeuverFitData
        The noise of each maneuver has an autocovariance of its own.
    size : int
        Number of parameters.
    lags : int, optional
        Lg. By default `gsapp.identification.statistics.correlation.default_lags`.
    prior : ndarray, shape (size, size), optional
        W2, the inverse covariance of a-priori values, which the cost holds beside the residuals.
    passes : int
        How often what the fit took away is added back; 0 is the formula of the notes as it is.

    Returns
    -------
    ndarray, shape (size, size)
        Infinite variances where the information has no inverse.
    """
    works = [_SpectralWorkspace(part, lags) for part in parts]
    H = np.zeros((size, size)) if prior is None else prior.copy()
    for work in works:
        H[work.place] += information_matrix(work.part.S, work.part.W, counted=work.part.v)
    inverted, lost = _inverse(H)
    covariance = np.zeros((size, size))
    for number in range(passes + 1):
        B = np.zeros((size, size)) if prior is None else prior.copy()
        for work in works:
            if number:
                work.add_back(inverted[work.place], covariance[work.place])
            B[work.place] += work.gradient_covariance()
        found = inverted @ B @ inverted
        if number and not (found.diagonal() >= 0.0).all():
            break
        covariance = 0.5 * (found + found.T)
    covariance[lost, lost] = np.inf
    return covariance


def colored_covariance(
    S: FloatArray,
    v: FloatArray,
    W: FloatArray,
    *,
    lags: int | None = None,
    segments: Sequence[slice] | None = None,
    prior: FloatArray | None = None,
    passes: int = 1,
) -> FloatArray:
    """Return the covariance of estimates made with any W under colored residuals.

    Notes, section 7: "Any W, colored", with what the fit took away added back. Parameters as in
    `ManeuverFitData` and `joint_covariance`, of which this is the case of one maneuver.
    """
    part = ManeuverFitData(S=S, v=v, W=W, segments=segments)
    return joint_covariance([part], S.shape[2], lags=lags, prior=prior, passes=passes)


def covariance_for_known_noise(
    S: FloatArray, W: FloatArray, lagged: FloatArray, *, segments: Sequence[slice] | None = None
) -> FloatArray:
    """Return the honest covariance that estimates will have under noise that is known.

    What `joint_covariance` will find in the residuals of a maneuver, before there are any.

    Parameters
    ----------
    S : ndarray, shape (n, n_responses, n_parameters)
    W : ndarray, shape (n_responses, n_responses)
        The weights that the fit will take.
    lagged : ndarray, shape (2 Lg + 1, n_responses, n_responses)
        Autocovariance of the noise; the middle one is that of lag 0.

    Returns
    -------
    ndarray, shape (n_parameters, n_parameters)
        Infinite variances where the information has no inverse.
    """
    part = ManeuverFitData(S=S, v=np.zeros(S.shape[:2]), W=W, segments=segments)
    inverted, lost = _inverse(information_matrix(S, W))
    work = _SpectralWorkspace(part, len(lagged) // 2, lagged)
    # What was put together from several stretches need not be a covariance.
    work.lift()
    covariance: FloatArray = inverted @ work.gradient_covariance() @ inverted
    covariance[lost, lost] = np.inf
    return covariance


def noise_autocovariance(part: ManeuverFitData, *, lags: int | None = None) -> FloatArray:
    """Return the autocovariance of the noise behind the residuals of a fit of one maneuver.

    What the fit took away is added back.

    `part`: with all parameters that the fit had.
    `lags`: lg. By default `gsapp.identification.statistics.correlation.default_lags`.

    Shape (2 Lg + 1, n_responses, n_responses). The middle one is that of lag 0.
    """
    work = _SpectralWorkspace(part, lags)
    inverted, _ = _inverse(information_matrix(part.S, part.W, counted=part.v))
    covariance = inverted @ work.gradient_covariance() @ inverted
    work.add_back(inverted, covariance)
    return work.lagged


def gradient_covariances(part: ManeuverFitData, *, lags: int | None = None) -> FloatArray:
    """Return the covariance of each response's share of the gradient, its residuals' color kept.

    Shape (n_responses, m, m). `part`: its weights are diagonal.
    """
    return _SpectralWorkspace(part, lags).gradient_covariances()


class _SpectralWorkspace:
    """The spectra of one maneuver.

    All is done in four arrays: fresh memory costs more here than the arithmetic.
    """

    def __init__(
        self, part: ManeuverFitData, lags: int | None, lagged: FloatArray | None = None
    ) -> None:
        self.part = part
        count, responses, width = part.S.shape
        columns = np.arange(width) if part.columns is None else part.columns
        self.place = np.ix_(columns, columns)
        self._layout = LagLayout(
            count, part.segments, default_lags(count) if lags is None else lags
        )
        self._taper = bartlett(self._layout.lags)[:, None, None]
        self._shares = self._layout.frequency_weights[:, None, None]
        counted = np.isfinite(part.v)
        self._lost = None if counted.all() else ~counted
        self._per_pair = self._layout.pair_normalization(counted)
        self._C = residual_autocovariance(part.v, self._layout) if lagged is None else lagged
        self.lagged = self._C
        self._density = self._layout.spectrum_of_lags(self._C * self._taper)
        rows = (self._layout.length, responses, width)
        self._row, self._other = np.zeros(rows), np.empty(rows)
        self._layout.scatter(_mask_sensitivities(part.S, part.v), self._row)
        self._S: ComplexArray = np.fft.rfft(self._row, axis=0)
        self._scratch = np.empty_like(self._S)

    def gradient_covariance(self) -> FloatArray:
        """Return B."""
        B = self._integrated()
        if (B.diagonal() < 0.0).any():
            # Means over differing pairs, or what was added back, need not be a covariance.
            self.lift()
            B = self._integrated()
        return 0.5 * (B + B.T)

    def gradient_covariances(self) -> FloatArray:
        """Return the share of each response in B, shape (n_responses, width, width)."""
        shares, W = self._shares[:, 0, 0], self.part.W.diagonal()
        density = np.maximum(np.diagonal(self._density, axis1=1, axis2=2).real, 0.0)
        weighted = shares[:, None] * density * W**2
        spectra = self._S.transpose(1, 0, 2)
        found: FloatArray = np.array(
            [
                zgemm(1.0, (own * weight[:, None]).T, own.T, trans_b=2).real
                for own, weight in zip(spectra, weighted.T, strict=True)
            ]
        )
        return 0.5 * (found + found.swapaxes(1, 2))

    def lift(self) -> None:
        """Lift the density of the noise to what a density can be."""
        self._density = _clip_negative_eigenvalues(self._density)

    def _integrated(self) -> FloatArray:
        W, width = self.part.W, self._S.shape[2]
        np.matmul(self._shares * (W @ self._density @ W), self._S, out=self._scratch)
        left, right = (x.reshape(-1, width).T for x in (self._scratch, self._S))
        B: FloatArray = zgemm(1.0, left, right, trans_b=2).real.T
        return B

    def add_back(self, inverted: FloatArray, covariance: FloatArray) -> None:
        """Add to the autocovariance what the fit took from the residuals."""
        S, width = self.part.S, len(inverted)
        np.matmul(self._density @ self.part.W, self._S, out=self._scratch)
        np.fft.irfft(self._scratch, n=self._layout.length, axis=0, out=self._other)
        half = 0.5 * covariance
        for source, target in self._layout.pieces:
            # Noise there is only where samples count: Y stays zero between the segments.
            Y = self._row[target]
            np.matmul(self._other[target].reshape(-1, width), inverted, out=Y.reshape(-1, width))
            own = self._other[target].reshape(-1, width)
            np.matmul(S[source].reshape(-1, width), half, out=own)
            Y -= self._other[target]
            if self._lost is not None:
                Y[self._lost[source]] = 0.0
        np.fft.rfft(self._row, axis=0, out=self._scratch)
        np.conjugate(self._scratch, out=self._scratch)
        cross = self._scratch @ self._S.swapaxes(1, 2)
        taken = self._layout.lags_of(cross + cross.conj().swapaxes(1, 2))
        self.lagged = self._C + taken * self._per_pair
        self._density = self._layout.spectrum_of_lags(self.lagged * self._taper)


def noise_covariance(v: FloatArray, *, diagonal: bool = False) -> FloatArray:
    """Return the measurement noise R = mean of v v', shape (n_responses, n_responses).

    `v`, shape (n, n_responses): each element of R is the mean over the samples where both responses
    count.
    `diagonal`: leave the covariances between responses out.

    Notes
    -----
    With missing samples the means need not fit together; R is then made positive by lifting its
    eigenvalues. A response without any sample has a zero row.
    """
    counted = np.isfinite(v)
    clean = np.where(counted, v, 0.0)
    pairs = counted.T.astype(np.float64) @ counted
    R: FloatArray = clean.T @ clean / np.maximum(pairs, 1.0)
    if diagonal:
        return np.diag(R.diagonal())
    if not counted.all():
        scale = np.sqrt(np.where(R.diagonal() > 0.0, R.diagonal(), 1.0))
        values, vectors = np.linalg.eigh(R / scale / scale[:, None])
        if values[0] < 0.0:
            lifted: FloatArray = (vectors * np.maximum(values, 1e-6)) @ vectors.T
            R = lifted * scale * scale[:, None]
    return R


def _mask_sensitivities(S: FloatArray, v: FloatArray) -> FloatArray:
    counted = np.isfinite(v)
    return S if counted.all() else S * counted[:, :, None]


def _inverse(H: FloatArray) -> tuple[FloatArray, npt.NDArray[np.intp]]:
    """Return the inverse on what H sees, and the indices of parameters that it does not."""
    diagonal = H.diagonal()
    seen = diagonal > 0.0
    scale = 1.0 / np.sqrt(np.where(seen, diagonal, 1.0))
    values, vectors = np.linalg.eigh(H * scale * scale[:, None])
    good = values > STATISTICS.singular_tolerance * max(float(values[-1]), 1e-300)
    reciprocal = np.where(good, 1.0 / np.where(good, values, 1.0), 0.0)
    inverted: FloatArray = (vectors * reciprocal) @ vectors.T * scale * scale[:, None]
    # Taking part in a combination that is not seen: beyond the rounding of the eigenvectors.
    lost = ~seen | (np.abs(vectors[:, ~good]) > 1e-3).any(axis=1)
    return inverted, np.flatnonzero(lost)


def _clip_negative_eigenvalues(density: ComplexArray) -> ComplexArray:
    """Return Hermitian matrices with their negative eigenvalues lifted to zero."""
    values, vectors = np.linalg.eigh(0.5 * (density + density.conj().swapaxes(1, 2)))
    lifted: ComplexArray = (
        vectors * np.maximum(values, 0.0)[:, None, :] @ vectors.conj().swapaxes(1, 2)
    )
    return lifted
