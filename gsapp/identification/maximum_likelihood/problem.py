"""A fit laid out: segments with their data, parameters with their names and places.

The unknowns are the free *global* parameters (derivatives and parameters of effects, the same for
all maneuvers) followed by those of each maneuver: initial states of its segments, biases, scale
factors and time shifts of its responses.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from gsapp.dynamics.actuators import reconstruct_deflection
from gsapp.dynamics.equations import POLAR_STATES
from gsapp.dynamics.flight_model import MODEL_INPUTS, FlightModel
from gsapp.dynamics.signal_terms import SURFACE_CHANNELS as SURFACE_NAMES
from gsapp.dynamics.signal_terms import PathTerms, path_response
from gsapp.dynamics.terms import Term
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.maximum_likelihood.trajectory_solver import (
    SegmentForcing,
    TrajectorySolver,
    build_segment_forcing,
)
from gsapp.identification.motion import MeasuredMotion
from gsapp.quantities import BoolArray, FloatArray


def shift_samples(rows: FloatArray, samples: float) -> tuple[FloatArray, FloatArray]:
    """Return rows as they were `samples` samples ago, and the derivative by `samples`.

    Cubic convolution (Catmull-Rom): smooth in the shift, so that Gauss-Newton can find it. Beyond
    the ends the outermost sample holds.

    `rows`, shape (..., n).
    `samples`: positive: late.
    """
    count = rows.shape[-1]
    place = np.arange(count) - samples
    base = np.floor(place)
    u = float(place[0] - base[0])
    weights = (
        ((-0.5 * u + 1.0) * u - 0.5) * u,
        (1.5 * u - 2.5) * u * u + 1.0,
        ((-1.5 * u + 2.0) * u + 0.5) * u,
        (0.5 * u - 0.5) * u * u,
    )
    slopes = (
        (-1.5 * u + 2.0) * u - 0.5,
        (4.5 * u - 5.0) * u,
        (-4.5 * u + 4.0) * u + 0.5,
        (1.5 * u - 1.0) * u,
    )
    moved = np.zeros_like(rows)
    change = np.zeros_like(rows)
    for offset, (weight, slope) in enumerate(zip(weights, slopes, strict=True)):
        index = np.clip(base.astype(np.intp) + offset - 1, 0, count - 1)
        taken = rows[..., index]
        moved += weight * taken
        # A later shift is an earlier place.
        change -= slope * taken
    return moved, change


_PATH_SURFACES = ("de", "da", "dr")
_DIVERGENCE_LIMITS = {"V": 1e3, "alpha": 1.5, "beta": 1.5, "theta": 1.56}
"""Beyond these (m/s, rad) a computed motion says nothing about the measured one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GlobalParameters:
    """Global parameters of a fit."""

    equations: tuple[str, ...]
    paths: tuple[str, ...]
    sensors: tuple[str, ...]
    """Free ones in the equations; on the paths of inputs, their sensors' included; on the sensor
    paths of responses."""

    @property
    def all(self) -> tuple[str, ...]:
        return (*self.equations, *self.paths, *self.sensors)


@dataclass(slots=True, kw_only=True, eq=False)
class ManeuverSegment:
    """A stretch of contiguous samples with its own initial states, and its latest trajectory."""

    sample_slice: slice  # Of the maneuver's samples.
    measured: FloatArray  # Shape (n_responses, n). Zero where a sample does not count.
    valid: BoolArray
    complete: bool  # Whether all samples count.
    forcing: SegmentForcing
    x: FloatArray
    y: FloatArray | None = None
    S: FloatArray | None = None
    Phi: FloatArray | None = None
    """States, responses, sensitivities and derivatives of the steps at the last accepted point."""
    trial: tuple[FloatArray, FloatArray] | None = None  # States and responses being tried.
    rest_derivatives: FloatArray | None = None
    """Derivatives of the settled states of terms by the polar ones, at the first sample."""


@dataclass(slots=True, kw_only=True, eq=False)
class ManeuverProblem:
    """One maneuver of a fit: data, equations, unknowns of its own."""

    maneuver: Maneuver
    dt: float
    motion: MeasuredMotion
    model: FlightModel
    trajectory_solver: TrajectorySolver
    names: GlobalParameters
    base: FloatArray
    parameter_indices: list[int]
    """Of the free parameters of the equations in `base`."""
    responses: tuple[str, ...]
    segments: list[ManeuverSegment]
    weights: Mapping[str, float] | None
    local_names: tuple[str, ...]
    local_start: FloatArray
    initial: tuple[int, ...]
    """Active states whose start is free."""
    fixed_initial: list[FloatArray]
    biases: tuple[int, ...]
    scales: tuple[int, ...]
    shifts: tuple[int, ...]
    remarks: tuple[str, ...] = ()
    control_paths: dict[str, PathTerms] = field(default_factory=dict)
    sensor_paths: dict[str, PathTerms] = field(default_factory=dict)

    # --- unknowns -------------------------------------------------------------------------------

    @property
    def id(self) -> str:
        return self.maneuver.id

    def values(self, shared: FloatArray) -> FloatArray:
        """Return all parameters of the equations for the global unknowns."""
        values = self.base.copy()
        values[self.parameter_indices] = shared[: len(self.parameter_indices)]
        return values

    def _path_values(self, path: PathTerms, shared: FloatArray) -> PathTerms:
        given = dict(zip(self.names.all, shared, strict=True))
        return tuple(
            (
                term,
                tuple(
                    float(given.get(f"{term.id}.{item.name}", value))
                    for item, value in zip(term.parameters, values, strict=True)
                ),
            )
            for term, values in path
        )

    def _initial(self, index: int, local: FloatArray) -> FloatArray:
        start = self.fixed_initial[index].copy()
        width = len(self.initial)
        start[list(self.initial)] = local[index * width : (index + 1) * width]
        return start

    # --- trajectories ---------------------------------------------------------------------------

    def _update_inputs(self, shared: FloatArray) -> None:
        """Send the recorded surfaces along their paths, where those have free parameters."""
        if not self.names.paths:
            return
        inputs, by_path = self.effective_inputs(shared)
        values = self.values(shared)
        for segment in self.segments:
            segment.forcing = build_segment_forcing(
                self.trajectory_solver.kernel,
                self.motion.states.T[:, segment.sample_slice],
                inputs[:, segment.sample_slice],
                by_path[:, :, segment.sample_slice],
                values,
            )

    def effective_inputs(self, shared: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return inputs as they act, (8, n), and derivatives (3, n_paths, n).

        What the sensors of surfaces did is undone first, then comes the control path.
        """
        inputs = self.motion.inputs.T.copy()
        by_path = np.zeros((3, len(self.names.paths), inputs.shape[1]))
        for surface, channel in SURFACE_NAMES.items():
            shown, moved = self.sensor_paths.get(channel, ()), self.control_paths.get(surface, ())
            if not shown and not moved:
                continue
            row = MODEL_INPUTS.index(channel)
            found = reconstruct_deflection(
                self._path_values(shown, shared),
                self._path_values(moved, shared),
                inputs[row],
                self.dt,
            )
            inputs[row] = found.values
            if channel not in _PATH_SURFACES:
                continue
            index = _PATH_SURFACES.index(channel)
            for column, name in enumerate(
                (*path_parameter_names(shown), *path_parameter_names(moved))
            ):
                if name in self.names.paths:
                    by_path[index, self.names.paths.index(name)] = found.parameters[:, column]
        return inputs, by_path

    def evaluate_residuals(
        self, shared: FloatArray, local: FloatArray, moved: FloatArray | None
    ) -> list[FloatArray] | None:
        """Return the residuals of every segment, (n_responses, n); None where it diverges.

        `shared` and `local`: unknowns.
        `moved`: change of the unknowns (all columns) from the last accepted point.
        """
        self._update_inputs(shared)
        values = self.values(shared)
        found = []
        for index, segment in enumerate(self.segments):
            start = self._start(index, segment, local)
            guess = segment.x
            if moved is not None and segment.S is not None:
                change = moved[self._state_columns(index)]
                guess = guess + np.einsum("imn,m->in", segment.S, change)
            x = self.trajectory_solver.trajectory(
                segment.forcing,
                self.dt,
                values,
                start,
                guess,
                Phi=segment.Phi,
                at_any_rate=moved is None,
            )
            if x is None or not self._plausible(x):
                return None
            y = self.trajectory_solver.kernel.outputs(segment.forcing.samples, x, values)
            y = self._recorded(y, shared, local)
            segment.trial = x, y
            residual = segment.measured - y
            if not segment.complete:
                residual *= segment.valid
            found.append(residual)
        return found

    def _plausible(self, x: FloatArray) -> bool:
        if not np.isfinite(x).all():
            return False
        for row, name in enumerate(self.trajectory_solver.kernel.state_names):
            if (
                name in _DIVERGENCE_LIMITS
                and float(np.abs(x[row]).max()) > _DIVERGENCE_LIMITS[name]
            ):
                return False
            if name == "V" and float(x[row].min()) <= 0.5:
                return False
        return True

    def _start(self, index: int, segment: ManeuverSegment, local: FloatArray) -> FloatArray:
        start = self._initial(index, local)
        own = len(self.trajectory_solver.kernel.state_names) - len(start)
        if not own:
            return start
        rest, segment.rest_derivatives = self._rest(segment, start)
        return np.concatenate((start, rest))

    def _rest(self, segment: ManeuverSegment, start: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the settled states of terms, and their derivatives by the polar ones."""
        names = self.trajectory_solver.kernel.state_names[: len(start)]
        state = [float(x) for x in segment.forcing.samples.states[:, 0]]
        inputs = [float(x) for x in segment.forcing.samples.inputs[:, 0]]

        def settled(at: FloatArray) -> FloatArray:
            full = list(state)
            for name, value in zip(names, at, strict=True):
                full[POLAR_STATES.index(name)] = float(value)
            return np.array(self.model.steady_states(full, inputs), dtype=np.float64)

        step = 1e-6
        slopes = [
            (settled(start + step * unit) - settled(start - step * unit)) / (2.0 * step)
            for unit in np.eye(len(start))
        ]
        return settled(start), np.array(slopes).T

    def accept_trial(self) -> None:
        """Make the tried trajectories the last accepted ones."""
        for segment in self.segments:
            if segment.trial is not None:
                (segment.x, segment.y), segment.trial = segment.trial, None

    # --- sensitivities --------------------------------------------------------------------------

    @property
    def shared_count(self) -> int:
        return len(self.names.all)

    def _state_columns(self, index: int) -> list[int]:
        """Return the columns (global, then local) that the states of a segment depend on."""
        width, kernel = len(self.initial), len(self.trajectory_solver.kernel.free)
        first = self.shared_count + index * width
        return [*range(kernel), *range(first, first + width)]

    def sensitivities(self, shared: FloatArray, local: FloatArray) -> list[FloatArray]:
        """Return the derivatives of the responses at the last accepted point, every segment.

        Each of shape (n_responses, n_global + n_local, n), zero where a sample does not count.
        """
        self._update_inputs(shared)
        values = self.values(shared)
        kernel = self.trajectory_solver.kernel
        found = []
        for index, segment in enumerate(self.segments):
            width = len(self.initial)
            by_start = np.zeros((len(kernel.state_names), width))
            by_start[list(self.initial), range(width)] = 1.0
            if segment.rest_derivatives is not None:
                by_start[-len(segment.rest_derivatives) :] = segment.rest_derivatives[
                    :, list(self.initial)
                ]
            S, segment.Phi = self.trajectory_solver.sensitivities(
                segment.forcing, self.dt, values, segment.x, by_start
            )
            segment.S = S
            y, dy = kernel.output_sensitivities(segment.forcing.samples, segment.x, values, S)
            total = np.zeros((len(y), self.shared_count + len(local), y.shape[1]))
            free = len(kernel.free)
            first = self.shared_count + index * width
            total[:, :free] = dy[:, :free]
            total[:, first : first + width] = dy[:, free:]
            self._recorded(y, shared, local, total)
            if not segment.complete:
                total *= segment.valid[:, None, :]
            found.append(total)
        return found

    def _recorded(
        self, y: FloatArray, shared: FloatArray, local: FloatArray, total: FloatArray | None = None
    ) -> FloatArray:
        """Send computed responses through sensor paths, shift, scale, bias; in place."""
        if self.sensor_paths:
            self._along_sensor_paths(y, shared, total)
        place = len(self.segments) * len(self.initial)
        first = self.shared_count
        biases = range(place, place + len(self.biases))
        scales = range(biases.stop, biases.stop + len(self.scales))
        shifts = range(scales.stop, scales.stop + len(self.shifts))
        for row, column in zip(self.shifts, shifts, strict=True):
            samples = float(local[column]) / self.dt
            if total is not None:
                total[row], _ = shift_samples(total[row], samples)
            y[row], change = shift_samples(y[row], samples)
            if total is not None:
                total[row, first + column] = change / self.dt
        for row, column in zip(self.scales, scales, strict=True):
            if total is not None:
                total[row] *= local[column]
                total[row, first + column] = y[row]
            y[row] *= local[column]
        for row, column in zip(self.biases, biases, strict=True):
            y[row] += local[column]
            if total is not None:
                total[row, first + column] = 1.0
        return y

    def _along_sensor_paths(
        self, y: FloatArray, shared: FloatArray, total: FloatArray | None
    ) -> None:
        first = len(self.names.equations) + len(self.names.paths)
        for row, name in enumerate(self.responses):
            path = self.sensor_paths.get(name)
            if path is None:
                continue
            found = path_response(self._path_values(path, shared), y[row], self.dt)
            y[row] = found.values
            if total is None:
                continue
            total[row] = found.tangent(np.ascontiguousarray(total[row].T)).T
            for column, parameter in enumerate(path_parameter_names(path)):
                if parameter in self.names.sensors:
                    at = first + self.names.sensors.index(parameter)
                    total[row, at] = found.parameters[:, column]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class EstimationProblem:
    """All maneuvers of a fit."""

    names: GlobalParameters
    parts: tuple[ManeuverProblem, ...]
    unexcited: Mapping[str, str]  # Derivatives taken out of the free set, each with why.
    remarks: tuple[str, ...]

    @property
    def unknowns(self) -> tuple[str, ...]:
        local = [name for part in self.parts for name in part.local_names]
        return (*self.names.all, *local)

    def unknown_indices(self, index: int) -> slice:
        """Return the places of a maneuver's own unknowns."""
        first = len(self.names.all) + sum(len(part.local_names) for part in self.parts[:index])
        return slice(first, first + len(self.parts[index].local_names))


def path_parameter_names(path: Sequence[tuple[Term, tuple[float, ...]]]) -> list[str]:
    """Return the names of the parameters on a signal's path."""
    return [f"{term.id}.{item.name}" for term, _ in path for item in term.parameters]
