"""One maneuver of a fit: where it stands, and what its filter shows of columns and residual."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gsapp.dynamics.flight_model import FlightModel
from gsapp.identification.filter_error.kalman import SteadyStateFilter
from gsapp.identification.filter_error.maneuver_record import ManeuverRecord
from gsapp.identification.filter_error.motion_linearization import NominalMotion
from gsapp.identification.filter_error.sensitivity_columns import SensitivityColumn, filter_inputs
from gsapp.quantities import FloatArray


class FilteredColumns(NamedTuple):
    """Columns of a maneuver seen through its filter."""

    innovations: FloatArray
    """Shape (n_blocks, n_channels, m + n_local + 1). Whitened: the columns, the initial states, the
    residual."""
    deviations: FloatArray  # Shape (n_blocks, n_x, m + n_local + 1).
    n_initial_states: int  # Number of initial states.

    @property
    def rows(self) -> FloatArray:
        return self.innovations.reshape(-1, self.innovations.shape[2])


@dataclass(slots=True, kw_only=True, eq=False)
class ManeuverState:
    """One maneuver of a fit: where its motion stands, and what the last pass made of it."""

    record: ManeuverRecord
    flight_model: FlightModel
    motion: NominalMotion
    filter: SteadyStateFilter | None = None
    filtered_columns: FilteredColumns | None = None

    @property
    def current_filter(self) -> SteadyStateFilter:
        """Return its filter.

        Raises
        ------
        ValueError
            If the maneuver has not been linearized.
        """
        if self.filter is None:
            raise ValueError(f"maneuver {self.record.id} was not linearized yet")
        return self.filter


def filter_columns(
    own: SteadyStateFilter, columns: Sequence[SensitivityColumn], bias: FloatArray
) -> FilteredColumns:
    """Return columns, initial states and residual as a filter sees them.

    `bias`, shape (n_channels,).
    """
    rest = own.blocks.initial_state_map
    (n_x, n_local), count = rest.shape, len(columns)
    own_z, own_b, _ = own.blocks.residual(bias)
    z, b = filter_inputs(own, columns, room=n_local + 1)
    z[:, :, -1], b[:, :, -1] = own_z, own_b
    start = np.zeros((n_x, count + n_local + 1))
    start[:, count : count + n_local] = -rest * own.blocks.scales[:n_local]
    innovations, deviations = own.innovations(z, b, start)
    return FilteredColumns(
        innovations=own.whitener @ innovations, deviations=deviations, n_initial_states=n_local
    )


def predicted_motion(one: ManeuverState, moves: FloatArray, bias: FloatArray) -> NominalMotion:
    """Return the motion that the filter predicts with moved parameters.

    Parameters
    ----------
    one : ManeuverState
        With what was seen of it in the last pass, which is used up; without it nothing can move.
    moves : ndarray, shape (m,)
        Of the columns that were seen; empty where none were.
    bias : ndarray, shape (n_channels,)
    """
    own = one.current_filter
    seen = one.filtered_columns or filter_columns(own, (), bias)
    one.filtered_columns = None
    count = len(moves)
    rows = seen.rows
    residual = rows[:, -1] - rows[:, :count] @ moves
    local = np.linalg.lstsq(rows[:, count:-1], residual, rcond=None)[0]
    change = seen.deviations[:, :, -1] - seen.deviations[:, :, :-1] @ np.concatenate((moves, local))
    _, _, within = own.blocks.residual(bias)
    moved = (own.blocks.state_response @ change[:, None, :, None])[:, :, :, 0] + within
    moved = moved.reshape(-1, moved.shape[2])
    # Samples beyond the last whole block follow from the last one in it.
    rest = [moved[-1]]
    for k in range(len(moved) - 1, len(one.record) - 1):
        rest.append(own.blocks.stepwise[k] @ rest[-1] + own.blocks.defects[k])
    moved = np.vstack((moved, *rest[1:])).T
    n_states = len(one.motion.states)
    return NominalMotion(
        states=one.motion.states + moved[:n_states],
        gust=one.motion.gust + moved[n_states : n_states + len(one.motion.gust)],
    )
