"""Cheap maneuvers with exactly known noise, and a linear toy, for tests of the search's core.

Maneuvers are flown by the virtual aircraft of the tests of identification (body axes, quaternion:
other equations than those of the filter); instruments show the motion plus white noise of known
size, with no zero error and no converter. The toy is a constant linear system driven by noise, a
`Linearization` in itself: for it everything is known exactly.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache

import numpy as np
from scipy.linalg import expm

from gsapp.aircraft import load_aircraft
from gsapp.dynamics.model import Model, load_model
from gsapp.identification.filter_error.filter_error_fit import FilterErrorFit
from gsapp.identification.filter_error.gust_states import GustStates
from gsapp.identification.filter_error.motion_linearization import (
    INTEGRATED_STATES,
    Linearization,
    ManeuverRecord,
    NominalMotion,
    create_maneuver_record,
)
from gsapp.identification.filter_error.noise_model import NoiseModel
from gsapp.identification.maneuver import Maneuver
from gsapp.quantities import Block, FloatArray
from gsapp.quantities.constants import DEGREE
from tests.identification.virtual_maneuvers import fly

AIRCRAFT = load_aircraft("b777")
TRUTH = load_model("b777")
NOISE: Mapping[str, float] = {
    "V": 0.1,
    **dict.fromkeys(("alpha", "beta"), 0.1 * DEGREE),
    **dict.fromkeys(("p", "q", "r"), 0.5 * DEGREE),
    **dict.fromkeys(("ax", "ay", "an"), 0.05),
    **dict.fromkeys(("phi", "theta"), 0.2 * DEGREE),
}
"""Standard deviation of a sample, SI."""


@lru_cache(maxsize=64)
def _exact(seed: int, kind: str, duration: float, dt: float, gust: float, model: str) -> Maneuver:
    return fly(
        seed,
        kind,
        duration=duration,
        dt=dt,
        gust=gust,
        noise=0.0,
        model=Model.model_validate_json(model),
        aircraft=AIRCRAFT,
    ).maneuver


def maneuver(
    seed: int,
    kind: str = "both",
    *,
    noise: float = 1.0,
    duration: float = 6.0,
    dt: float = 0.02,
    gust: float = 0.0,
    model: Model | None = None,
    flight: str = "virtual",
) -> Maneuver:
    flown = (TRUTH if model is None else model).model_dump_json()
    exact = _exact(seed, kind, duration, dt, gust, flown)
    random = np.random.default_rng([seed, 77])
    block = exact.block
    values = block.values.copy()
    for name, size in NOISE.items():
        column = block.channels.index(name)
        values[:, column] += noise * size * random.standard_normal(len(values))
    return replace(
        exact, flight=flight, block=Block(channels=block.channels, times=block.times, values=values)
    )


def with_channel(one: Maneuver, name: str, samples: FloatArray | float) -> Maneuver:
    block = one.block
    kept = [place for place, own in enumerate(block.channels) if own != name]
    added = np.broadcast_to(np.asarray(samples, dtype=float), block.times.shape)
    return replace(
        one,
        block=Block(
            channels=(*(block.channels[place] for place in kept), name),
            times=block.times,
            values=np.column_stack((block.values[:, kept], added)),
        ),
    )


def true_noise(share: float = 1.0, gusts: float = 1e-9, moments: float = 1e-9) -> NoiseModel:
    return NoiseModel(
        variances={name: (share * size) ** 2 for name, size in NOISE.items()},
        gust_intensities=(gusts,) * 3,
        moment_intensity=moments,
    )


def prepared(
    maneuvers: list[Maneuver], model: Model = TRUTH, free: tuple[str, ...] = ()
) -> FilterErrorFit:
    fit = FilterErrorFit.create([create_maneuver_record(one) for one in maneuvers], model, free)
    fit.noise = {flight: true_noise() for flight in fit.noise}
    return fit


# --- the toy -------------------------------------------------------------------------------------

TOY_CHANNELS = ("V", "alpha", "beta", "p", "q", "r", "an")
_V = 30.0
GUST_ROWS = (0, 2, 1)
"""States that gusts along x, y, z enter: V, beta, alpha."""
_PAST = 600
"""Samples before the record, in which the toy forgets that it was at rest."""


class Toy:
    """A stable linear system of eight states in continuous gusts, and its samples.

    Parameters
    ----------
    noise : NoiseModel
        The truth.
    seed : int
        Of system and samples.
    n : int
        Samples.
    dt : float
        s; a block is 0.04 s.

    Attributes
    ----------
    step : ndarray, shape (11, 11)
        From sample to sample, gusts among the states.
    slopes : ndarray, shape (n_channels, 11)
    """

    def __init__(
        self, noise: NoiseModel, seed: int = 0, n: int = 4000, dt: float = 0.01, system: int = 0
    ) -> None:
        self.noise, self.dt, self.n = noise, dt, n
        random = np.random.default_rng([system, 5])
        rates = 1.2 * random.standard_normal((8, 8)) * np.outer(_SIZES, 1.0 / _SIZES)
        # All modes damped alike, as those of an aircraft roughly are.
        rates -= np.eye(8) * (np.linalg.eigvals(rates).real.max() + 0.8)
        full = np.zeros((11, 11))
        full[:8, :8] = rates
        gusts = GustStates.create(INTEGRATED_STATES, 8, _V, 1.0, noise)
        for index, (row, length) in enumerate(zip(GUST_ROWS, noise.gust_lengths, strict=True)):
            full[row, 8 + index] = full[8 + index, 8 + index] = -_V / length
        self.step = expm(full * dt)
        slopes = np.eye(len(TOY_CHANNELS), 8)
        slopes[-1] = 3.0 * random.standard_normal(8) / _SIZES
        self.slopes = np.hstack((slopes, np.zeros((len(slopes), 3))))
        self.transition = expm(rates * dt)
        self.process = _gathered(
            full, noise.process_noise(gusts.names, gusts.entries, (3, 4, 5)), dt
        )
        self.measurement = np.array([noise.variances[name] for name in TOY_CHANNELS])
        draw = np.random.default_rng([seed, 6])
        values, vectors = np.linalg.eigh(self.process)
        root = vectors * np.sqrt(np.maximum(values, 0.0))
        shocks = draw.standard_normal((_PAST + n, 11)) @ root.T
        errors = draw.standard_normal((n, len(TOY_CHANNELS))) * np.sqrt(self.measurement)
        state, states = np.zeros(11), np.empty((_PAST + n, 11))
        for k, shock in enumerate(shocks):
            state = self.step @ state + shock
            states[k] = state
        self.states = states = states[_PAST:]
        self.errors = errors
        self.measured = states @ self.slopes.T + errors

    def linearization(self, measured: FloatArray | None = None) -> Linearization:
        """Return it as what a flight model linearized along steady flight would be."""
        n, n_channels = self.n, len(TOY_CHANNELS)
        shown = self.measured if measured is None else measured
        counted = np.isfinite(shown)
        times = self.dt * np.arange(n)
        steady = np.zeros((8, n))
        steady[0] = _V
        shown = np.where(counted, shown, 0.0)
        record = ManeuverRecord(
            maneuver=Maneuver(
                id="toy",
                flight="toy",
                aircraft=AIRCRAFT,
                block=Block(channels=TOY_CHANNELS, times=times, values=shown),
                inputs=("de",),
                mass=20.0,
            ),
            motion=None,  # type: ignore[arg-type]
            dt=self.dt,
            channels=TOY_CHANNELS,
            measured=shown,
            valid=counted,
        )
        return Linearization(
            record=record,
            paths={},
            states=steady,
            speed=_V,
            transition=np.broadcast_to(self.transition, (n - 1, 8, 8)).copy(),
            next_states=steady[:, 1:],
            sensor_inputs=np.zeros((n, n_channels)),
            sensor_input_rates=np.zeros((n, n_channels)),
            computed=np.zeros((n, n_channels)),
            output_by_state=np.broadcast_to(self.slopes[:, :8], (n, n_channels, 8)).copy(),
            output_by_coefficient=np.zeros((n, n_channels, 6)),
            rate_by_coefficient=np.zeros((n, 8, 6)),
            output_by_control=np.zeros((n, n_channels, 5)),
            rate_by_control=np.zeros((n, 8, 5)),
            output_by_rotation=np.zeros((n, n_channels, 3)),
            rate_by_rotation=np.zeros((n, 8, 3)),
            variables={},
            output_rates=np.zeros((n, n_channels)),
            bias_sensitivity=np.ones((n, n_channels)),
            inputs=np.zeros((8, n)),
            free=(),
            rate_by_free=np.zeros((n, 8, 0)),
            output_by_free=np.zeros((n, n_channels, 0)),
        )

    def motion(self) -> NominalMotion:
        steady = np.zeros((8, self.n))
        steady[0] = _V
        return NominalMotion(states=steady, gust=np.zeros((3, self.n)))


def _gathered(rates: FloatArray, intensity: FloatArray, dt: float) -> FloatArray:
    size = len(rates)
    block = np.zeros((2 * size, 2 * size))
    block[:size, :size], block[:size, size:], block[size:, size:] = -rates, intensity, rates.T
    whole = expm(block * dt)
    found: FloatArray = whole[size:, size:].T @ whole[:size, size:]
    return found


_SIZES = np.array((1.0, 0.01, 0.01, 0.05, 0.05, 0.05, 0.02, 0.02))

TOY_NOISE = NoiseModel(
    variances={
        "V": 0.1**2,
        "alpha": 0.002**2,
        "beta": 0.002**2,
        "p": 0.01**2,
        "q": 0.01**2,
        "r": 0.01**2,
        "an": 2.0**2,
    },
    gust_intensities=(0.05, 0.1, 0.2),
    moment_intensity=0.0005,
)
