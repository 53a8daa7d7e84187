"""Bounds: the fast forms against the sums as written, and against what really happens."""

import numpy as np
import pytest
from scipy.signal import lfilter

from gsapp.identification.statistics import (
    ManeuverFitData,
    colored_covariance,
    covariance_for_known_noise,
    cramer_rao,
    information_matrix,
    joint_covariance,
    noise_autocovariance,
    noise_covariance,
)
from gsapp.identification.statistics.correlation import default_lags
from gsapp.quantities import FloatArray

W = np.array([[2.0, 0.3, 0.0], [0.3, 1.0, -0.2], [0.0, -0.2, 5.0]])


def some(n: int = 60, responses: int = 3, parameters: int = 4) -> tuple[FloatArray, FloatArray]:
    random = np.random.default_rng(5)
    S = random.standard_normal((n, responses, parameters)).cumsum(axis=0)
    v = random.standard_normal((n, responses))
    for k in range(1, n):
        v[k] += 0.7 * v[k - 1]
    return S, v


def as_written(
    S: FloatArray, v: FloatArray, lags: int, segments: list[slice] | None = None
) -> FloatArray:
    """Return sum_j (1 - |j|/(Lg + 1)) sum_k S_k' W C_j W S_(k+j), term by term."""
    n, m, count = S.shape
    label = np.zeros(n, dtype=int)
    for index, part in enumerate(segments or [slice(0, n)]):
        label[part] = index
    ok = np.isfinite(v)
    clean = np.where(ok, v, 0.0)
    B = np.zeros((count, count))
    for j in range(-lags, lags + 1):
        pairs = [(k, k + j) for k in range(n) if 0 <= k + j < n and label[k] == label[k + j]]
        C = np.zeros((m, m))
        for a in range(m):
            for b in range(m):
                both = [clean[k, a] * clean[i, b] for k, i in pairs if ok[k, a] and ok[i, b]]
                C[a, b] = np.mean(both) * (1.0 - abs(j) / n) if both else 0.0
        for k, i in pairs:
            left = (S[k] * ok[k][:, None]).T @ W
            B += (1.0 - abs(j) / (lags + 1)) * left @ C @ (W @ (S[i] * ok[i][:, None]))
    return B


def gradient_covariance(
    S: FloatArray, v: FloatArray, lags: int, segments: list[slice] | None = None
) -> FloatArray:
    H = information_matrix(S, W, counted=v)
    covariance = colored_covariance(S, v, W, lags=lags, segments=segments, passes=0)
    found: FloatArray = H @ covariance @ H
    return found


def test_the_colored_correction_is_the_sum_of_the_notes() -> None:
    S, v = some()
    assert gradient_covariance(S, v, 7) == pytest.approx(as_written(S, v, 7), rel=1e-10)


def test_lags_do_not_cross_gaps() -> None:
    S, v = some()
    parts = [slice(0, 22), slice(22, 60)]
    found = gradient_covariance(S, v, 9, parts)
    assert found == pytest.approx(as_written(S, v, 9, parts), rel=1e-10)
    assert found != pytest.approx(gradient_covariance(S, v, 9), rel=1e-3)


def test_missing_samples_do_not_count() -> None:
    S, v = some(n=400)
    v[np.random.default_rng(1).random(v.shape) < 0.05] = np.nan
    other = np.where(np.isfinite(v)[:, :, None], S, 1e6)
    assert information_matrix(S, W, counted=v) == pytest.approx(
        information_matrix(other, W, counted=v)
    )
    found = gradient_covariance(S, v, 6)
    assert found == pytest.approx(gradient_covariance(other, v, 6), rel=1e-9)
    assert found == pytest.approx(as_written(S, v, 6), rel=1e-9)


def test_white_residuals_leave_the_cramer_rao_bound() -> None:
    """With white residuals and W = R^-1 the correction changes hardly anything."""
    random = np.random.default_rng(0)
    n = 20_000
    S = np.stack([np.ones(n), np.sin(np.arange(n) / 30.0)], axis=1)[:, None, :]
    v = 0.3 * random.standard_normal((n, 1))
    R = noise_covariance(v)
    raw, honest = cramer_rao(S, np.linalg.inv(R)), colored_covariance(S, v, np.linalg.inv(R))
    assert np.sqrt(honest.diagonal() / raw.diagonal()) == pytest.approx(1.0, abs=0.2)
    assert R[0, 0] == pytest.approx(0.09, rel=0.03)


@pytest.mark.parametrize("share_missing", [0.0, 0.1])
def test_the_honest_bound_is_the_scatter_under_colored_noise(share_missing: float) -> None:
    """Least squares 150 times over AR(0.9) noise, any W: the errors are as large as the bound."""
    random = np.random.default_rng(11)
    n, weight = 1000, np.diag([1.0, 40.0])
    t = np.arange(n) * 0.01
    doublet = np.where(t < 1.0, 1.0, np.where(t < 2.0, -1.0, 0.0))
    smooth = np.convolve(doublet, np.exp(-t / 0.3))[:n] * 0.03
    S = np.stack([np.stack([smooth, t * smooth], 1), np.stack([0.2 * smooth, np.cos(t)], 1)], 1)
    errors, raw = [], []
    for _ in range(150):
        noise = random.standard_normal((n + 100, 2)) * (0.2, 0.1)
        z = lfilter([1.0], [1.0, -0.9], noise, axis=0)[100:]
        z[random.random(z.shape) < share_missing] = np.nan
        H = information_matrix(S, weight, counted=z)
        estimate = np.linalg.solve(H, np.einsum("krp,kr->p", S, np.nan_to_num(z) @ weight))
        v = z - S @ estimate
        bound = np.sqrt(colored_covariance(S, v, weight).diagonal())
        errors.append(estimate / bound)
        white = np.linalg.inv(noise_covariance(v, diagonal=True))
        raw.append(estimate / np.sqrt(cramer_rao(S, white, counted=v).diagonal()))
    assert np.sqrt(np.mean(np.square(errors), axis=0)) == pytest.approx(1.0, abs=0.25)
    assert (np.sqrt(np.mean(np.square(raw), axis=0)) > 2.0).all()


def test_what_is_not_seen_has_an_infinite_variance() -> None:
    S, v = some(parameters=3)
    blind = np.concatenate((S, 0.0 * S[:, :, :1]), axis=2)
    twins = np.concatenate((S, 2.0 * S[:, :, 1:2]), axis=2)
    R = np.linalg.inv(W)
    for given, lost in ((blind, [3]), (twins, [1, 3])):
        for covariance in (cramer_rao(given, R), colored_covariance(given, v, W, lags=5)):
            infinite = np.isinf(covariance.diagonal())
            assert np.flatnonzero(infinite).tolist() == lost
            assert (covariance.diagonal()[~infinite] > 0.0).all()
    alone = cramer_rao(S, R).diagonal()
    assert cramer_rao(blind, R).diagonal()[:3] == pytest.approx(alone)


def test_parts_of_a_joint_fit() -> None:
    """Two maneuvers with a parameter each of their own: as one fit with the other's at zero."""
    S, v = some(n=300)
    cut = 140
    shared, own = S[:, :, :2], S[:, :, 2:3]
    parts = [
        ManeuverFitData(S=np.concatenate((shared[:cut], own[:cut]), 2), v=v[:cut], W=W),
        ManeuverFitData(
            S=np.concatenate((shared[cut:], own[cut:]), 2),
            v=v[cut:],
            W=2.0 * W,
            columns=np.array([0, 1, 3]),
        ),
    ]
    found = joint_covariance(parts, 4, lags=20)
    whole = np.zeros((300, 3, 4))
    whole[:, :, :2] = shared
    whole[:cut, :, 2:3], whole[cut:, :, 3:] = own[:cut], own[cut:]
    # The same with the second maneuver's weights taken into its responses.
    heavy = np.concatenate((np.ones(cut), np.full(300 - cut, np.sqrt(2.0))))
    segments = [slice(0, cut), slice(cut, 300)]
    H = information_matrix(whole * heavy[:, None, None], W)
    B = sum(
        as_written(whole[part] * heavy[part, None, None], v[part] * heavy[part, None], 20)
        for part in segments
    )
    raw = np.linalg.inv(H) @ B @ np.linalg.inv(H)
    assert joint_covariance(parts, 4, lags=20, passes=0) == pytest.approx(raw, rel=1e-8)
    assert (found.diagonal() > raw.diagonal()).all()


def test_what_the_fit_took_is_added_back() -> None:
    """Under white noise the residuals of a fit with a few parameters still give the bound.

    Four parameters on 200 samples take a fiftieth of the power, all of it where they are felt.
    """
    random = np.random.default_rng(8)
    n = 200
    k = np.arange(n)[:, None]
    S = np.cos(np.pi * k * np.arange(1, 5) / n)[:, None, :]
    one = np.ones((1, 1))
    ratios = {0: [], 2: []}  # type: dict[int, list[FloatArray]]
    for _ in range(200):
        z = random.standard_normal((n, 1))
        v = z - S @ np.linalg.solve(information_matrix(S, one), np.einsum("krp,kr->p", S, z))
        for passes, found in ratios.items():
            honest = colored_covariance(S, v, one, lags=20, passes=passes)
            found.append(honest.diagonal() / cramer_rao(S, one).diagonal())
    printed, mended = (np.mean(ratios[passes]) for passes in (0, 2))
    assert printed < 0.85
    assert mended == pytest.approx(1.0, abs=0.12)


def test_a_priori_values_bound_what_the_data_do_not_see() -> None:
    S, v = some(parameters=2)
    blind = np.concatenate((S, 0.0 * S[:, :, :1]), axis=2)
    prior = np.diag([0.0, 0.0, 1.0 / 0.3**2])
    found = colored_covariance(blind, v, W, lags=5, prior=prior)
    assert found[2, 2] == pytest.approx(0.09)


def test_noise_covariance_counts_pairs() -> None:
    random = np.random.default_rng(2)
    mix = np.array([[1.0, 0.0, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 0.1]])
    v = random.standard_normal((30_000, 3)) @ mix.T
    v[random.random(v.shape) < 0.3] = np.nan
    R = noise_covariance(v)
    assert R[0, 1] == pytest.approx(0.8, abs=0.03)
    assert np.linalg.eigvalsh(R)[0] > 0.0
    assert noise_covariance(v, diagonal=True)[0, 1] == 0.0
    v[:, 2] = np.nan
    assert (noise_covariance(v)[2] == 0.0).all()


def test_lags_suit_the_record() -> None:
    assert [default_lags(n) for n in (3, 10, 100, 400, 5000)] == [1, 2, 25, 100, 100]


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
