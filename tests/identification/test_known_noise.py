"""Bounds under noise that is known beforehand, and the noise behind residuals."""

import numpy as np
from scipy.signal import lfilter

from gsapp.identification.statistics import (
    ManeuverFitData,
    covariance_for_known_noise,
    cramer_rao,
    noise_autocovariance,
)

COUNT, LAGS = 120, 12


def _sensitivities() -> np.ndarray:
    return np.random.default_rng(5).standard_normal((COUNT, 2, 3)).cumsum(axis=0)


def test_white_noise_gives_the_cramer_rao_bound() -> None:
    S, R = _sensitivities(), np.diag([0.5, 2.0])
    lagged = np.zeros((2 * LAGS + 1, 2, 2))
    lagged[LAGS] = R
    W = np.linalg.inv(R)
    np.testing.assert_allclose(
        covariance_for_known_noise(S, W, lagged), cramer_rao(S, W), rtol=1e-9
    )


def test_colored_noise_gives_the_sum_over_lags() -> None:
    """The covariance is H^-1 B H^-1 with B summed sample by sample."""
    S, W = _sensitivities(), np.diag([2.0, 0.5])
    apart = np.abs(np.arange(-LAGS, LAGS + 1))
    lagged = 0.8 ** apart[:, None, None] * np.array([[0.5, 0.1], [0.1, 2.0]])
    B = np.zeros((3, 3))
    for k in range(COUNT):
        for j in range(-LAGS, LAGS + 1):
            if 0 <= k + j < COUNT:
                taper = 1.0 - abs(j) / (LAGS + 1.0)
                B += taper * S[k].T @ W @ lagged[j + LAGS] @ W @ S[k + j]
    H = np.einsum("kri,rs,ksj->ij", S, W, S)
    expected = np.linalg.inv(H) @ B @ np.linalg.inv(H)
    np.testing.assert_allclose(covariance_for_known_noise(S, W, lagged), expected, rtol=1e-6)


def test_what_a_fit_took_from_the_noise_is_added_back() -> None:
    random = np.random.default_rng(6)
    count, color = 400, 0.8
    flat = np.vander(np.linspace(-1.0, 1.0, count), 3)
    raw, mended = [], []
    for _ in range(200):
        error = random.standard_normal(count + 50)
        noise = lfilter([np.sqrt(1.0 - color**2)], [1.0, -color], error)[50:]
        residual = noise - flat @ np.linalg.lstsq(flat, noise, rcond=None)[0]
        raw.append(float(residual @ residual) / count - float(noise @ noise) / count)
        part = ManeuverFitData(S=flat[:, None, :], v=residual[:, None], W=np.eye(1))
        found = noise_autocovariance(part, lags=40)[40, 0, 0]
        mended.append(float(found) - float(noise @ noise) / count)
    assert np.mean(raw) < -0.03
    assert abs(np.mean(mended)) < np.mean(np.abs(raw)) / 3.0
