"""Zero-phase smoothing: the same for both sides, honest about gaps, chosen from the data."""

import numpy as np
import pytest

from gsapp.identification.smoothing import (
    build_smoother,
    contiguous_slices,
    interpolate_missing,
    select_cutoff,
)

DT = 0.01
TIMES = np.arange(1001) * DT


@pytest.mark.parametrize("frequency", [0.3, 1.0, 3.0, 5.0])
def test_derivative_and_average_pass_the_same_filter(frequency):
    filtering = build_smoother(DT, 5.0)
    phase = 2.0 * np.pi * frequency * TIMES
    smoothed = filtering.smooth(filtering.simpson_average(np.cos(phase)))
    slope = filtering.smooth(filtering.differentiate(np.sin(phase)))
    inner = slice(filtering.half_width, -filtering.half_width)
    expected = 2.0 * np.pi * frequency * smoothed[inner]
    np.testing.assert_allclose(slope[inner], expected, atol=1e-4 * np.ptp(expected))


def test_smoothing_does_not_move_a_signal_in_time():
    filtering = build_smoother(DT, 3.0)
    bump = filtering.smooth(np.exp(-(((TIMES - 5.0) / 0.2) ** 2)))
    np.testing.assert_allclose(bump, bump[::-1], atol=1e-12)
    assert filtering.kernel.sum() == pytest.approx(1.0)


def test_the_gain_at_the_cutoff_is_that_of_a_filter():
    filtering = build_smoother(DT, 4.0)
    wave = filtering.smooth(np.sin(2.0 * np.pi * 4.0 * TIMES))[100:-100]
    assert np.max(np.abs(wave)) == pytest.approx(np.sqrt(0.5), rel=0.03)


def test_samples_near_a_gap_and_the_ends_do_not_count():
    filtering = build_smoother(DT, 5.0)
    missing = np.zeros(TIMES.size, dtype=bool)
    missing[500] = True
    good = filtering.valid_samples(missing)
    reach = filtering.half_width
    assert not good[:reach].any()
    assert not good[500 - reach : 501 + reach].any()
    assert good[500 - reach - 1]
    assert [part.start for part in contiguous_slices(good)] == [reach, 501 + reach]


def test_a_record_shorter_than_the_kernel_has_no_sample_that_counts():
    assert not build_smoother(DT, 2.0).valid_samples(np.zeros(10, dtype=bool)).any()


def test_the_cutoff_follows_the_motion_not_the_noise():
    random = np.random.default_rng(1)
    found = []
    for frequency in (0.5, 3.5):
        envelope = np.exp(-(((TIMES - 5.0) / 1.0) ** 2))
        signal = envelope * np.sin(2.0 * np.pi * frequency * TIMES)
        found.append(select_cutoff((signal + 0.02 * random.standard_normal(1001))[:, None], DT))
    assert found[0] < found[1]
    assert 2.0 <= found[0] < 3.5
    assert 3.0 < found[1] < 6.0


def test_noise_is_measured_beside_motion_and_an_engine_tone():
    random = np.random.default_rng(2)
    count = 4000
    times = np.arange(count) * DT
    one, two = random.standard_normal((2, count))
    noise = np.column_stack((0.1 * one, 0.05 * one + 0.05 * two))
    motion = np.exp(-(((times - 20.0) / 3.0) ** 2)) * np.sin(times)
    tone = 0.5 * np.sin(2.0 * np.pi * 31.0 * times)
    filtering = build_smoother(DT, 4.0)
    found = filtering.white_noise(filtering.simpson_average(noise + (motion + tone)[:, None]))
    true = np.cov(filtering.smooth(filtering.simpson_average(noise))[50:-50].T)
    np.testing.assert_allclose(found, true, rtol=0.3)


def test_bridging_leaves_what_is_there():
    signal = np.array([0.0, np.nan, 2.0, 3.0])
    assert interpolate_missing(signal, np.isnan(signal)).tolist() == [0.0, 1.0, 2.0, 3.0]
