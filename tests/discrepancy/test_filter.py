"""Proves the filter against plain simulation, a Kalman filter at every sample, least squares."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from gsapp.dynamics.flight_model import MODEL_INPUTS, FlightModel
from gsapp.dynamics.sensors import OutputModel
from gsapp.foundation import FlightError
from gsapp.identification.filter_error.kalman import SteadyStateFilter, create_filter, solve_forward
from gsapp.identification.filter_error.motion_linearization import (
    INTEGRATED_STATES,
    Linearization,
    ManeuverRecord,
    NominalMotion,
    create_maneuver_record,
    linearize_along,
)
from gsapp.identification.filter_error.noise_model import NoiseModel
from gsapp.quantities import FloatArray
from tests.discrepancy.core_kit import (
    AIRCRAFT,
    GUST_ROWS,
    TOY_CHANNELS,
    TOY_NOISE,
    TRUTH,
    Toy,
    maneuver,
    prepared,
    true_noise,
    with_channel,
)
from tests.dynamics.histories import simulate_open_loop


def block_means(history: FloatArray, block: int) -> FloatArray:
    return np.array(
        [history[k : k + block].mean(axis=0) for k in range(0, len(history) - block + 1, block)]
    )


def whitened(one: SteadyStateFilter, innovations: FloatArray) -> FloatArray:
    found: FloatArray = (one.whitener[-len(innovations) :] @ innovations[:, :, None])[:, :, 0]
    return found


def innovations_of(one: SteadyStateFilter) -> FloatArray:
    z, b, _ = one.residual(np.zeros(len(one.linearization.record.channels)))
    found, _ = one.innovations(z[:, :, None], b[:, :, None])
    return found[:, :, 0]


# --- without turbulence: output error ------------------------------------------------------------


def simulated(record: ManeuverRecord) -> tuple[FloatArray, FloatArray]:
    model = FlightModel(AIRCRAFT, TRUTH)
    start = record.motion.states[0]
    inputs = record.motion.inputs
    states = simulate_open_loop(
        model, start, dict(zip(MODEL_INPUTS, inputs.T, strict=True)), record.dt
    )
    shown = OutputModel(model, record.channels).values(tuple(states.T), tuple(inputs.T))
    return states, np.column_stack(np.broadcast_arrays(*shown))


def nearby(record: ManeuverRecord, states: FloatArray, size: float) -> Linearization:
    times = record.dt * np.arange(len(record))
    bends = np.array([1.0, 0.01, 0.01, 0.05, 0.05, 0.05, 0.02, 0.02])
    waves = np.array([np.sin((1.0 + 0.3 * k) * times) for k in range(8)])
    model = FlightModel(AIRCRAFT, TRUTH)
    motion = NominalMotion(
        states=states[:, :8].T + size * bends[:, None] * waves, gust=np.zeros((3, len(record)))
    )
    return linearize_along(record, model, np.array(model.defaults), motion)


def test_without_process_noise_it_is_output_error() -> None:
    record = create_maneuver_record(maneuver(1))
    states, channels = simulated(record)
    found = nearby(record, states, 0.0)
    own = create_filter(
        found, None, NominalMotion(states=found.states, gust=np.zeros((3, len(record))))
    )
    block = round(0.04 / record.dt)
    expected = block_means(record.measured - channels, block)
    spread = expected.std(axis=0)
    assert np.abs((innovations_of(own) - expected) / spread).max() < 1e-4


def test_linearized_elsewhere_it_finds_the_same_residuals_to_first_order() -> None:
    """Along a motion off by e, residuals of simulation from the same start are found within e^2."""
    record = create_maneuver_record(maneuver(1))
    states, channels = simulated(record)
    expected = block_means(record.measured - channels, round(0.04 / record.dt))
    spread = expected.std(axis=0)
    errors = []
    for size in (1.0, 0.5):
        found = nearby(record, states, size)
        own = create_filter(
            found, None, NominalMotion(states=found.states, gust=np.zeros((3, len(record))))
        )
        plain = block_means(record.measured - found.computed, own.block_size)
        # The bend is far larger than the noise; nearly nothing of it is left.
        assert np.sqrt(np.mean(((plain - expected) / spread) ** 2)) > 2.0 * size
        errors.append(np.sqrt(np.mean(((innovations_of(own) - expected) / spread) ** 2)))
    assert errors[0] < 0.3
    assert errors[1] == pytest.approx(errors[0] / 4.0, rel=0.25)


def flown_in_dying_gust(record: ManeuverRecord, start: FloatArray, gust: FloatArray) -> FloatArray:
    """Integrate the equations, air moved by gusts that only die away from where they begin."""
    model = FlightModel(AIRCRAFT, TRUTH)
    decay = float(np.mean(record.motion.states[:, 0])) / np.array(true_noise().gust_lengths)
    inputs, dt = record.motion.inputs, record.dt

    def rates(state: FloatArray, given: FloatArray, time: float) -> FloatArray:
        found = np.array([float(one) for one in model.rates(tuple(state), tuple(given))])
        found[[*GUST_ROWS]] -= decay * gust * np.exp(-decay * time)
        return found

    state, rows = start, [start]
    for k in range(len(inputs) - 1):
        middle, t = 0.5 * (inputs[k] + inputs[k + 1]), k * dt
        a = rates(state, inputs[k], t)
        b = rates(state + 0.5 * dt * a, middle, t + 0.5 * dt)
        c = rates(state + 0.5 * dt * b, middle, t + 0.5 * dt)
        d = rates(state + dt * c, inputs[k + 1], t + dt)
        state = state + dt / 6.0 * (a + 2.0 * b + 2.0 * c + d)
        rows.append(state)
    return np.array(rows)


def test_settling_reaches_the_simulated_motion() -> None:
    """From the measured motion a few passes end at a plain simulation, values as they are.

    The air's motion at the start is part of the initial state: it dies away in that simulation.
    """
    fit = prepared([maneuver(1)])
    fit.noise = {"virtual": true_noise(gusts=1e-12, moments=1e-12)}
    one = fit.maneuvers[0]
    for _ in range(4):
        fit.linearize()
        fit.update_motion()
    start = np.array([*one.motion.states[:8, 0], one.record.motion.states[0, 8]])
    flown = flown_in_dying_gust(one.record, start, one.motion.gust[:, 0])
    noise = [0.1, *np.radians((0.1, 0.1, 0.5, 0.5, 0.5, 0.2, 0.2))]
    gap = (one.motion.states[:8].T - flown[:, :8]) / noise
    assert np.abs(gap).max() < 0.01
    # It is not where it began: the measured motion is noisy.
    begun = (one.record.motion.states[:, :8] - flown[:, :8]) / noise
    assert np.sqrt(np.mean(begun**2, axis=0)).min() > 0.7


# --- with process noise: the Kalman filter -------------------------------------------------------


def toy_step(toy: Toy) -> FloatArray:
    step = np.zeros((11, 11))
    step[:8, :8] = toy.transition
    for index, (row, length) in enumerate(zip(GUST_ROWS, toy.noise.gust_lengths, strict=True)):
        step[:8, 8 + index] = -30.0 / length * toy.dt * toy.transition[:, row]
        step[8 + index, 8 + index] = np.exp(-30.0 / length * toy.dt)
    return step


class PlainKalman:
    """A Kalman filter that steps from sample to sample and measures the sum over each block.

    The state is widened by the sum of the channels so far; process noise comes at every sample,
    measurement noise of every sample enters the sum.
    """

    def __init__(self, toy: Toy, block: int) -> None:
        self.toy, self.block = toy, block
        self.step = toy_step(toy)
        self.size, self.channels = 11, len(TOY_CHANNELS)
        wide = self.size + self.channels
        self.P = np.zeros((wide, wide))
        self.P[:11, :11] = np.diag((1.0, 1e-4, 1e-4, *(2.5e-3,) * 3, 4e-4, 4e-4, 1.0, 1e-4, 1e-4))
        self.x = np.zeros(wide)

    def _sample(self) -> None:
        wide = np.eye(len(self.x))
        wide[self.size :, : self.size] = self.toy.slopes
        self.x = wide @ self.x
        self.P = wide @ self.P @ wide.T
        self.P[self.size :, self.size :] += np.diag(self.toy.measurement)

    def _advance(self) -> None:
        wide = np.eye(len(self.x))
        wide[: self.size, : self.size] = self.step
        self.x = wide @ self.x
        self.P = wide @ self.P @ wide.T
        self.P[: self.size, : self.size] += self.toy.process

    def take(self, mean: FloatArray) -> tuple[FloatArray, FloatArray]:
        for _ in range(self.block):
            self._sample()
            self._advance()
        C = np.hstack((np.zeros((self.channels, self.size)), np.eye(self.channels) / self.block))
        S = C @ self.P @ C.T
        innovation = mean - C @ self.x
        gain = np.linalg.solve(S, C @ self.P).T
        self.x = self.x + gain @ innovation
        self.P = self.P - gain @ S @ gain.T
        # The sum begins anew.
        self.x[self.size :] = 0.0
        self.P[self.size :, :] = self.P[:, self.size :] = 0.0
        return innovation, S


def test_blocks_are_a_kalman_filter_at_every_sample() -> None:
    """Gains and covariances of blocks are those of a filter that goes sample by sample.

    That one takes continuous noise as it is; blocks take it in the middle between samples.
    """
    toy = Toy(TOY_NOISE, n=2000)
    own = create_filter(toy.linearization(), TOY_NOISE, toy.motion())
    assert own.block_size == 4
    plain = PlainKalman(toy, own.block_size)
    for _ in range(1500):
        plain.take(np.zeros(len(TOY_CHANNELS)))
    plain.x[:] = 0.0
    means = block_means(toy.measured, own.block_size)
    found = innovations_of(own)
    covariance = np.linalg.inv(own.whitener[-1].T @ own.whitener[-1])
    spread = np.sqrt(np.diag(covariance))
    for k in range(300):
        innovation, S = plain.take(means[k])
        assert np.abs((found[k] - innovation) / spread).max() < 2e-3
    assert np.abs((covariance - S) / np.outer(spread, spread)).max() < 5e-4
    assert own.log_determinant / len(means) == pytest.approx(np.linalg.slogdet(S)[1], abs=1e-3)


def test_innovations_of_the_toy_are_white_and_of_the_size_predicted() -> None:
    toy = Toy(TOY_NOISE, n=24000, seed=3)
    own = create_filter(toy.linearization(), TOY_NOISE, toy.motion())
    white = whitened(own, innovations_of(own)[20:])
    n = len(white)
    covariance = white.T @ white / n
    assert np.abs(covariance - np.eye(7)).max() < 4.5 / np.sqrt(n)
    for lag in range(1, 8):
        crossed = white[lag:].T @ white[:-lag] / n
        assert np.abs(crossed).max() < 4.5 / np.sqrt(n), lag
    # Without the gusts that are there it would be neither.
    blind = create_filter(toy.linearization(), true_like(gust=1e-6), toy.motion())
    poor = whitened(blind, innovations_of(blind)[20:])
    assert np.mean(poor[:, 1] ** 2) > 1.5


def test_colored_noise_is_told_from_turbulence() -> None:
    """Toys whose instruments have colored noise, in gusts that reach them: white innovations.

    And the smoother sees the true correlation; with gusts mistaken for noise it would be none.
    """
    truth = {"alpha": 0.7, "q": 0.8, "an": 0.7}
    noise = replace(TOY_NOISE, gust_intensities=(0.05, 0.4, 0.8), correlations=truth)
    toy = Toy(noise, n=24000, seed=6)
    measured = toy.measured - toy.errors
    for column, name in enumerate(TOY_CHANNELS):
        measured[:, column] += lfilter([1.0], [1.0, -truth.get(name, 0.0)], toy.errors[:, column])
    linearization = toy.linearization(measured)
    own = create_filter(linearization, noise, toy.motion())
    found = innovations_of(own)[20:]
    white = whitened(own, found)
    n = len(white)
    assert np.abs(white.T @ white / n - np.eye(7)).max() < 4.5 / np.sqrt(n) + 0.02
    for lag in range(1, 8):
        assert np.abs(white[lag:].T @ white[:-lag] / n).max() < 4.5 / np.sqrt(n) + 0.02, lag
    z, b, _ = own.residual(np.zeros(7))
    kept = own.smoothed_decay(z, b) ** (1.0 / own.block_size)
    expected = [truth[TOY_CHANNELS[place]] for place in own.colors.channel_indices]
    assert kept == pytest.approx(expected, abs=0.03)
    # From elsewhere it leads there.
    away = create_filter(
        linearization, replace(noise, correlations=dict.fromkeys(truth, 0.6)), toy.motion()
    )
    assert (away.smoothed_decay(z, b) ** (1.0 / own.block_size) > 0.6).all()
    # Taken for white, the same noise is neither white nor of that size.
    blind = create_filter(linearization, replace(noise, correlations={}), toy.motion())
    poor = whitened(blind, innovations_of(blind)[20:])
    assert np.abs(poor[1:].T @ poor[:-1] / n).max() > 0.2


def true_like(gust: float) -> NoiseModel:
    changed = TOY_NOISE
    for name in ("gust.u", "gust.v", "gust.w"):
        changed = changed.with_value(name, gust)
    return changed


def test_the_smoother_is_generalized_least_squares() -> None:
    """Adjoint of the measurements: inverse covariance of the whole record times the record.

    The dense covariance is built from its definition, the start as uncertain as the steady filter
    takes it.
    """
    toy = Toy(TOY_NOISE, n=160, seed=4)
    own = create_filter(toy.linearization(), TOY_NOISE, toy.motion())
    plain = PlainKalman(toy, own.block_size)
    for _ in range(1500):
        plain.take(np.zeros(len(TOY_CHANNELS)))
    start = plain.P[:11, :11]
    step, n, block = toy_step(toy), toy.n, own.block_size
    # Covariances of the states at all samples.
    spreads = [start]
    for _ in range(n - 1):
        spreads.append(step @ spreads[-1] @ step.T + toy.process)
    whole = np.zeros((n, 7, n, 7))
    for early in range(n):
        carried = spreads[early]
        for late in range(early, n):
            crossed = toy.slopes @ carried @ toy.slopes.T
            whole[late, :, early], whole[early, :, late] = crossed, crossed.T
            carried = step @ carried
        whole[early, :, early] += np.diag(toy.measurement)
    blocks = whole.reshape(n // block, block, 7, n // block, block, 7).mean(axis=(1, 4))
    dense = blocks.reshape(7 * n // block, -1)
    means = block_means(toy.measured, block)
    expected = np.linalg.solve(dense, means.ravel()).reshape(means.shape)
    found = own.adjoints(innovations_of(own)).measurement
    assert found == pytest.approx(expected, abs=1e-3 * float(np.abs(expected).max()))
    # And the innovations are the record, decorrelated: the same sum of squares, and log det.
    white = whitened(own, innovations_of(own))
    assert np.sum(white**2) == pytest.approx(means.ravel() @ expected.ravel(), rel=1e-4)
    assert own.log_determinant == pytest.approx(np.linalg.slogdet(dense)[1], rel=1e-4)


def test_what_the_smoother_expects_is_what_it_finds() -> None:
    toy = Toy(TOY_NOISE, n=40000, seed=5)
    own = create_filter(toy.linearization(), TOY_NOISE, toy.motion())
    process, measurement, _ = own.adjoints(innovations_of(own))
    by_process, by_measurement, _ = own.expected_adjoints()
    steps = slice(10, -10)
    found = np.mean(measurement[steps] ** 2, axis=0)
    assert found == pytest.approx(np.diag(by_measurement), rel=0.08)
    # Of the white noise behind gusts and moments; sums over gusts themselves scatter for minutes.
    entries = np.eye(11)[:, (3, 4, 5, 0, 1, 2)]
    for index, row in enumerate(GUST_ROWS):
        entries[8 + index, 3 + row] = 1.0
    for seen, usual in zip(process, by_process, strict=True):
        found = np.mean((seen[steps] @ entries) ** 2, axis=0)
        assert found == pytest.approx(np.diag(entries.T @ usual @ entries), rel=0.12)


def test_a_filter_that_does_not_forget_is_a_fit_that_ran_away() -> None:
    """Which a search passes over: a failure of the algebra would end it."""
    toy = Toy(TOY_NOISE, n=400, seed=5)
    own = create_filter(toy.linearization(), TOY_NOISE, toy.motion())
    with pytest.raises(FlightError, match="diverges"):
        replace(own, propagation=4.0 * own.propagation).expected_adjoints()


# --- what does not count -------------------------------------------------------------------------


def test_samples_that_are_missing_change_nothing() -> None:
    """A stretch of a channel is lost: its innovations are zero, what it held plays no part.

    Innovations before it are as they were, those after it forget it.
    """
    toy = Toy(TOY_NOISE, n=1200)
    lost = toy.measured.copy()
    lost[400:520, 4] = np.nan
    other = toy.measured.copy()
    other[400:520, 4] = 1e3
    found = []
    for shown in (lost, other):
        linearization = toy.linearization(np.where(np.isfinite(lost), shown, np.nan))
        found.append(innovations_of(create_filter(linearization, TOY_NOISE, toy.motion())))
    own = create_filter(toy.linearization(), TOY_NOISE, toy.motion())
    whole = innovations_of(own)
    assert np.array_equal(found[0], found[1])
    assert np.all(found[0][100:130, 4] == 0.0)
    assert np.array_equal(found[0][:100], whole[:100])
    assert not np.array_equal(found[0][130:], whole[130:])
    # It forgets the loss within a few seconds.
    off = whitened(own, found[0] - whole)
    assert np.abs(off[-20:]).max() < 0.05
    assert np.abs(off[130:150]).max() > 0.3


def test_a_channel_with_gaps_is_filled_by_nothing() -> None:
    whole = maneuver(1)
    samples = whole.samples("q").copy()
    samples[100:150] = np.nan
    record = create_maneuver_record(with_channel(whole, "q", samples))
    column = record.channels.index("q")
    assert not record.valid[100:150, column].any()
    assert record.valid.sum() == record.valid.size - 50
    fit = prepared([with_channel(whole, "q", samples)])
    fit.linearize()
    one = fit.maneuvers[0]
    assert one.filter is not None
    assert np.all(fit.residual_innovations(one)[50:75, column] == 0.0)
    assert np.any(fit.residual_innovations(one)[50:75, column - 1] != 0.0)


def test_records_hold_what_was_measured() -> None:
    record = create_maneuver_record(maneuver(1))
    assert record.channels == (*INTEGRATED_STATES[:6], "ax", "ay", "an", "phi", "theta")
    assert record.id == "1"
    whole = maneuver(1)
    for name in ("phi", "theta", "beta"):
        whole = with_channel(whole, name, np.nan)
    assert create_maneuver_record(whole).channels == ("V", "alpha", "p", "q", "r", "ax", "ay", "an")


@pytest.mark.parametrize("many", [1, 6, 7, 40])
def test_the_recursion_is_solved(many: int) -> None:
    random = np.random.default_rng(many)
    propagation = 0.3 * random.standard_normal((50, 11, 11))
    rows = random.standard_normal((51, 11, many))
    expected = rows.copy()
    for k in range(50):
        for column in range(many):
            expected[k + 1, :, column] += propagation[k].dot(expected[k, :, column])
    found = solve_forward(propagation, rows.copy())
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_gusts_of_the_noise_model_have_the_size_that_it_says() -> None:
    random = np.random.default_rng(8)
    noise, V, dt, n = true_noise(gusts=0.2), 30.0, 0.02, 200_000
    for name, length in zip("uvw", noise.gust_lengths, strict=True):
        decay = np.exp(-V / length * dt)
        size = np.sqrt(0.2 * (1.0 - decay**2) / (2.0 * V / length))
        gust = lfilter([1.0], [1.0, -decay], size * random.standard_normal(n))
        assert noise.gust_rms(V)[name] == pytest.approx(float(gust.std()), rel=0.1)
