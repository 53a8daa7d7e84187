"""`FTR`: derivatives with bounds while the aircraft still flies."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from gsapp.aircraft import Aircraft
from gsapp.foundation import FlightError, UnknownNameError
from gsapp.identification.axes import AXIS_COEFFICIENTS, axis_derivatives, derivatives_of
from gsapp.identification.ftr.axis_regression import AxisRegression
from gsapp.identification.ftr.channels import FTRAxis
from gsapp.identification.ftr.equations import RegressionEquations
from gsapp.identification.ftr.estimates import (
    EstimateHistory,
    EstimateLog,
    EstimateSnapshot,
    LiveEstimate,
    estimate_history,
    evaluate_estimates,
    live_estimate_at,
    widen_for_withheld,
)
from gsapp.identification.ftr.regression_rows import (
    BlockBuffer,
    EstimationWindow,
    KnownEffects,
    RegressionRows,
    RowAssembler,
    split_into_blocks,
)
from gsapp.identification.ftr.settings import FTRSettings
from gsapp.identification.ftr.solution import FTRSolution, RecordInformation
from gsapp.identification.ftr.state_file import (
    STATE_FILE_VERSION,
    ArrayTable,
    add_prefix,
    read_state,
    strip_prefix,
    write_state,
)
from gsapp.identification.memory_allocator import retain_freed_memory
from gsapp.identification.statistics.identifiability import withheld_std
from gsapp.quantities import Block, FloatArray

FTR_AXES: tuple[FTRAxis, ...] = ("lon", "lat")


class FTR:
    """Fourier transform regression on a flight as it comes in.

    It is a consumer of a session's feed: `feed` takes blocks of some channels, in order, however
    they were cut, `process_step` concludes; nothing that it gives depends on the cutting.
    `settings.updates` times a second of flight it renews the estimates of the six equations.

    Parameters
    ----------
    rate, origin : float
        Samples per second of the grid that samples lie on, Hz; a time that lies on it, s.
    measured : iterable of str, optional
        Channels known to be measured. By default a channel that was silent for half a second is
        not.
    mass, burning : float, bool
        Mass at the start where no channel gives it, kg, by default of the aircraft file; whether
        fuel burns off it as the throttle asks.
    aligned : bool
        Whether channels that instruments record late were brought to their right time already;
        by default FTR does that by the aircraft file.
    known : KnownEffects, optional
        Coefficients of known effects, subtracted before the regression.

    Raises
    ------
    FlightError
        If the rate is too low for the band.
    """

    def __init__(
        self,
        aircraft: Aircraft,
        settings: FTRSettings | None = None,
        *,
        rate: float,
        origin: float = 0.0,
        axes: Sequence[FTRAxis] = FTR_AXES,
        measured: Iterable[str] | None = None,
        mass: float | None = None,
        burning: bool = True,
        aligned: bool = False,
        known: KnownEffects | None = None,
    ) -> None:
        retain_freed_memory()
        self.aircraft = aircraft
        self.settings = settings or FTRSettings()
        if not rate > 0.0:
            raise FlightError(f"FTR needs a positive sample rate, not {rate:g} Hz")
        for axis in axes:
            band = self.settings.longitudinal if axis == "lon" else self.settings.lateral
            if 0.4 * rate < band.lowest + 5 * self.settings.spacing:
                raise FlightError(
                    f"{rate:g} samples a second are too few for a band up to "
                    f"{band.highest:g} Hz; record faster or lower the band"
                )
        self.rate, self.origin = rate, origin
        self.axes = tuple(axes)
        self.block = max(2, round(rate / self.settings.updates))
        dt = 1.0 / rate
        self._equations = RegressionEquations(
            aircraft,
            self.settings,
            dt,
            self.axes,
            measured=measured,
            mass=mass,
            burning=burning,
            aligned=aligned,
        )
        self._known = known
        self._rows = RowAssembler(rate, self.block, self._equations.ahead)
        self._runs = {
            axis: AxisRegression(
                axis, self.settings, dt, self.block, self._equations.axis_dynamics(axis)
            )
            for axis in self.axes
        }
        self._withheld_stds = {
            axis: np.array(
                [
                    [withheld_std(name) for name in derivatives_of(coefficient)[1:]]
                    for coefficient in AXIS_COEFFICIENTS[axis]
                ]
            )
            for axis in self.axes
        }
        self.names = tuple(name for axis in self.axes for name in axis_derivatives(axis))
        lookback = max(1, round(self.settings.lookback * rate / self.block))
        self._buffer = BlockBuffer(self.axes, lookback)
        self._log = EstimateLog(self.names)
        self._forget()

    # --- the consumer of a feed -----------------------------------------------------------------

    def feed(self, block: Block) -> None:
        if self.origin:
            block = Block(
                channels=block.channels, times=block.times - self.origin, values=block.values
            )
        self._rows.feed(block)

    def process_step(self) -> None:
        for number, rows in self._rows.take_complete_blocks():
            self._take(number, rows)

    def reset(self) -> None:
        self._rows.restart()
        self._equations.restart()
        for run in self._runs.values():
            run.restart()
        self._log.clear()
        self._forget()

    def finish(self) -> None:
        """Take in what was held back for samples that will not come; the flight is over."""
        for number, rows in self._rows.flush():
            self._take(number, rows)

    def _forget(self) -> None:
        self._next: int | None = None  # number of the block to come
        self._last: dict[FTRAxis, RegressionRows] = {}  # the last row of each axis
        self._buffer.clear()
        self._window: EstimationWindow | None = None

    # --- windows --------------------------------------------------------------------------------

    def begin_window(self, start: float) -> None:
        """Listen from a time on (s), which may lie up to `FTRSettings.lookback` back.

        Raises `FlightError` if FTR listens always, or a window is open, or the start is too long
        ago.
        """
        self._must_be_gated()
        if self._window is not None:
            raise FlightError(
                f"FTR window open since {self._window.start:.1f} s; end that maneuver first"
            )
        start -= self.origin
        if self._buffer.oldest_if_full is not None:
            oldest = self._buffer.oldest_if_full * self.block / self.rate
            if start < oldest:
                raise FlightError(
                    f"FTR keeps data from {oldest + self.origin:.1f} s on; a maneuver cannot "
                    f"begin at {start + self.origin:.1f} s; raise lookback"
                )
        self._window = EstimationWindow(start=start)
        for run in self._runs.values():
            run.open_window()
        self._replay()

    def end_window(self, stop: float) -> None:
        """Listen up to a time (s), then keep what the maneuver said.

        Takes effect as soon as all samples up to there have come.

        Raises `FlightError` if no window is open, or it would end before it began.
        """
        self._must_be_gated()
        if self._window is None:
            raise FlightError("no FTR window is open; start one first")
        if stop - self.origin <= self._window.start:
            raise FlightError(
                f"a maneuver cannot end at {stop:.2f} s: it began at "
                f"{self._window.start + self.origin:.2f} s"
            )
        self._window.stop = stop - self.origin
        if self._next is not None:
            self._window.overrun = self._next > self._blocks_of(self._window)[1] - 1
        self._close_if_due()

    def _must_be_gated(self) -> None:
        if self.settings.gate == "always":
            raise FlightError("the FTR gate is 'always'; use the gate 'maneuvers' for windows")

    def _replay(self) -> None:
        """Run the open window over the blocks remembered."""
        window = self._window
        if window is None:
            return
        found = self._buffer.between(*self._blocks_of(window))
        if found is not None:
            self._advance(*found)

    def _blocks_of(self, window: EstimationWindow) -> tuple[int, int]:
        return window.blocks(self.rate, self.block)

    def _close_if_due(self) -> None:
        window = self._window
        if window is None or window.stop is None or self._next is None:
            return
        if self._next < self._blocks_of(window)[1]:
            return
        if window.overrun:
            # Anew, so that what counts does not depend on when the end became known.
            for run in self._runs.values():
                run.rewind()
            self._replay()
        for run in self._runs.values():
            run.close_record()
        self._window = None
        running = {axis: rows.running for axis, rows in self._last.items()}
        moments = {axis: run.solve_closed_records() for axis, run in self._runs.items()}
        self._log_moments(self._next - 1, moments, running)

    # --- blocks ---------------------------------------------------------------------------------

    def _take(self, first: int, values: FloatArray) -> None:
        """Take in whole blocks."""
        N = self.block
        blocks = (len(values) - 1 - self._equations.ahead) // N
        follows = self._next == first
        self._next = first + blocks
        shaped: dict[FTRAxis, RegressionRows] = {}
        whole = self._equations.rows(values)
        if self._known is not None:
            after = first * N + 1
            whole = {
                axis: self._known.subtract_from(axis, one, after) for axis, one in whole.items()
            }
        for axis, rows in whole.items():
            before = self._last.get(axis) if follows else None
            shaped[axis] = split_into_blocks(rows, before, blocks, N)
            self._last[axis] = RegressionRows(
                valid=rows.valid[-1:], columns=rows.columns[-1:], running=rows.running[-1:]
            )
        if self.settings.gate == "maneuvers":
            self._buffer.append(first, blocks, shaped)
            if self._window is None:
                return
            if self._window.stop is not None:
                _, end = self._blocks_of(self._window)
                shaped = {axis: rows.first_blocks(end - first) for axis, rows in shaped.items()}
        self._advance(first, shaped)
        self._close_if_due()

    def _advance(self, first: int, rows: Mapping[FTRAxis, RegressionRows]) -> None:
        """Run whole blocks through the regressions, and keep the estimates."""
        if not len(rows[self.axes[0]].valid):
            return
        moments = {
            axis: run.advance(
                first,
                rows[axis]
                if self._window is None
                else self._window.masked(first, rows[axis], self.rate, self.block),
            )
            for axis, run in self._runs.items()
        }
        running = {axis: one.running[:, -1] for axis, one in rows.items()}
        self._log_moments(first, moments, running)

    def _log_moments(
        self,
        first: int,
        moments: Mapping[FTRAxis, FTRSolution],
        running: Mapping[FTRAxis, npt.NDArray[np.bool_]],
    ) -> None:
        count = len(moments[self.axes[0]].theta)
        times = self.origin + (first + 1 + np.arange(count)) * self.block / self.rate
        parts = []
        for axis in self.axes:
            plain = moments[axis]
            verdicts, _ = evaluate_estimates(plain, self.settings, running[axis])
            solution = widen_for_withheld(plain, verdicts, self._withheld_stds[axis])
            self._runs[axis].solution = solution.select_moment(-1)
            parts.append(
                EstimateSnapshot.from_axis_arrays(
                    solution, *evaluate_estimates(solution, self.settings, running[axis])
                )
            )
        self._log.append(times, EstimateSnapshot.concatenate(parts))

    # --- what it found --------------------------------------------------------------------------

    @property
    def time(self) -> float | None:
        """Return the time of the latest estimates, s; None before the first."""
        return self._log.last_time

    def estimates(self, time: float | None = None) -> dict[str, LiveEstimate]:
        """Return all derivatives as they stood at a time (s), by default now.

        Empty before the first update.
        """
        row = self._log.row_at(time)
        if row is None:
            return {}
        missing = self.unavailable_coefficients() if time is None else {}
        return {
            name: live_estimate_at(self._log, name, row, self.settings, missing)
            for name in self.names
        }

    def history(self, name: str, *, max_points: int | None = None) -> EstimateHistory:
        """Return the estimates of one derivative, thinned out evenly to `max_points` at most.

        Raises `UnknownNameError` if there is no such derivative.
        """
        if name not in self.names:
            raise UnknownNameError(
                f"FTR does not estimate '{name}'; it estimates {', '.join(self.names)}"
            )
        step = 1 if max_points is None else -(-self._log.times.size // max_points)
        return estimate_history(self._log, name, max(step, 1))

    def covariance(self, names: Sequence[str]) -> FloatArray:
        """Return the covariance of the latest estimates; coefficients are independent."""
        out = np.zeros((len(names), len(names)))
        for axis, run in self._runs.items():
            if run.solution is None:
                continue
            for index, coefficient in enumerate(AXIS_COEFFICIENTS[axis]):
                block = run.solution.covariance_with_bias(index)
                own = derivatives_of(coefficient)
                rows = [k for k, name in enumerate(names) if name in own]
                places = [own.index(names[k]) for k in rows]
                out[np.ix_(rows, rows)] = block[np.ix_(places, places)]
        return out

    def unavailable_coefficients(self) -> dict[str, str]:
        """Return the coefficients whose equation cannot run now, with the reason in words."""
        found: dict[str, str] = {}
        for axis in self.axes:
            found.update(self._equations.missing_reasons(axis))
        return found

    def remarks(self) -> tuple[str, ...]:
        """Return what stands in for what was not measured, in words."""
        return self._equations.remarks()

    # --- records of other flights ---------------------------------------------------------------

    def information(self) -> dict[FTRAxis, RecordInformation]:
        """Return what the closed records say."""
        return {axis: run.closed_information for axis, run in self._runs.items()}

    def set_prior_information(self, information: Mapping[FTRAxis, RecordInformation]) -> None:
        """Start from what earlier records said."""
        for axis, run in self._runs.items():
            if axis in information:
                run.closed_information = information[axis]

    # --- saved state ----------------------------------------------------------------------------

    def save(self, path: Path) -> None:
        """Write everything to an ``.npz`` file from which `load` goes on, bit by bit the same."""
        numbers, buffered = self._buffer.state()
        table: ArrayTable = {
            "next": np.array([] if self._next is None else [self._next], dtype=np.int64),
            "window": np.array([]) if self._window is None else self._window.state(),
            "ring": numbers,
        }
        parts: dict[str, Mapping[str, npt.NDArray[np.generic]]] = {
            "rows": self._rows.state(),
            "equations": self._equations.state(),
            "log": self._log.state(),
            **buffered,
        }
        for axis, run in self._runs.items():
            parts[f"run.{axis}"] = run.state()
            if axis in self._last:
                parts[f"last.{axis}"] = self._last[axis].state()
        write_state(path, self._about(), {**table, **add_prefix(parts)})

    def load(self, path: Path) -> None:
        """Go on from a state that `save` wrote, with the same aircraft and settings.

        Raises `FlightError` if the file cannot be read, or comes from another aircraft, rate or
        settings.
        """
        table = read_state(path, self._about())
        try:
            self._restore(table)
        except (KeyError, ValueError, IndexError) as error:
            self.reset()
            raise FlightError(f"the state in {path} is not complete ({error})") from error

    def _restore(self, table: ArrayTable) -> None:
        self._rows.restore(strip_prefix("rows", table))
        self._equations.restore(strip_prefix("equations", table))
        self._log.restore(strip_prefix("log", table))
        self._forget()
        self._next = int(table["next"][0]) if table["next"].size else None
        self._window = EstimationWindow.from_state(table["window"])
        self._buffer.restore(table["ring"], table)
        for axis, run in self._runs.items():
            run.restore(strip_prefix(f"run.{axis}", table))
            last = strip_prefix(f"last.{axis}", table)
            if last:
                self._last[axis] = RegressionRows.from_state(last)

    def _about(self) -> dict[str, object]:
        return {
            "version": STATE_FILE_VERSION,
            "aircraft": self.aircraft.model_dump(mode="json"),
            "settings": self.settings.as_table(),
            "rate": self.rate,
            "origin": self.origin,
            "axes": list(self.axes),
        }
