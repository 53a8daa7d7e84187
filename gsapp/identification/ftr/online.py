"""`FTR`: derivatives with bounds while the aircraft still flies."""

from __future__ import annotations

import io
import json
import math
import zipfile
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from gsapp.aircraft import Aircraft
from gsapp.foundation import FlightError, UnknownNameError, write_atomically
from gsapp.identification.axes import COEFFICIENTS, axis_derivatives, derivatives_of
from gsapp.identification.ftr.equations import (
    AxisBody,
    AxisRows,
    Equations,
    FTRAxis,
    axis_regressors,
)
from gsapp.identification.ftr.judgment import Verdict, judge, words
from gsapp.identification.ftr.memory import EstimateLog, Moment
from gsapp.identification.ftr.regression import Information, Solution, solve, solve_past, stacked
from gsapp.identification.ftr.rows import RowAssembler
from gsapp.identification.ftr.settings import Band, FTRSettings
from gsapp.identification.ftr.transform import RunningTransform
from gsapp.identification.results import DerivativeEstimate
from gsapp.quantities import Block, FloatArray

AXES: tuple[FTRAxis, ...] = ("lon", "lat")
_STATE_VERSION = 2
_LEAST_FREEDOM = 4.0
"""Real equations beyond the unknowns that a record needs for its information to be kept."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LiveEstimate(DerivativeEstimate):
    """One derivative at one moment.

    Attributes
    ----------
    name : str
    time : float
        Flight time, s.
    signal_to_noise : float
        What its variable did on its own over its noise, in the band: the measure of excitation.
    amplitude : float
        Rms of its variable in the band (rad; rates as q c/2V, p b/2V, r b/2V).
    progress : float
        0 to 1: how much of the excitation that is asked for there has been.
    """

    name: str = ""
    time: float = 0.0
    signal_to_noise: float = 0.0
    amplitude: float = 0.0
    progress: float = 0.0


class _AxisRun:
    """The three regressions of one axis: open record, closed ones, latest solution."""

    def __init__(
        self, axis: FTRAxis, settings: FTRSettings, dt: float, block: int, body: AxisBody
    ) -> None:
        self.settings, self.body = settings, body
        self.band: Band = settings.longitudinal if axis == "lon" else settings.lateral
        self.p = len(axis_regressors(axis))
        self.transform = RunningTransform(
            self.p, self.band, settings.spacing, settings.forgetting, dt, block
        )
        length = block * dt
        self._longest_gap = max(1, round(settings.longest_gap / length))
        self._fade = 1.0 if settings.forgetting is None else np.exp(-length / settings.forgetting)
        self._record: int | None = None
        if settings.gate == "always" and settings.forgetting is None:
            seconds = settings.record_length or 1.0 / settings.spacing
            self._record = max(1, round(seconds / length))
        self.restart()

    def restart(self) -> None:
        self.past = self.checkpoint = Information.none(self.p)
        self.solution: Solution | None = None
        self.begin()

    def open_window(self) -> None:
        """Begin a window, which may have to be gone through again."""
        self.checkpoint = self.past
        self.begin()

    def rewind(self) -> None:
        """Go back to where the window began."""
        self.past = self.checkpoint
        self.begin()

    def begin(self) -> None:
        """Begin a record; what the open one said is forgotten."""
        self.transform.start()
        self.own = Information.none(self.p)
        self.open = False
        self.silent = 0

    def close(self) -> None:
        """Keep what the open record said, and begin another."""
        earned = self.own.freedom >= _LEAST_FREEDOM
        if earned.any():
            self.past = self.past.plus(self.own.of(earned))
        self.begin()

    def advance(self, first: int, rows: AxisRows) -> Solution:
        """Take in blocks from number `first` on; return the estimates after each."""
        valid, columns, running = rows.valid, rows.columns, rows.running
        joined = np.asarray(valid[:, 1:] & valid[:, :-1], dtype=bool)
        heard = np.asarray(joined.any(axis=1)).tolist()
        parts: list[Solution] = []
        start = 0
        for k in range(len(heard) + 1):
            end = k == len(heard)
            if not end:
                boundary = self._record is not None and (first + k) % self._record == 0
                lost = self.open and not heard[k] and self.silent + 1 >= self._longest_gap
                if boundary or lost:
                    parts += self._stretch(valid, columns, running, start, k)
                    start = k
                    self.close()
                self.open = self.open or heard[k]
                self.silent = 0 if heard[k] else self.silent + 1
            else:
                parts += self._stretch(valid, columns, running, start, k)
        together = Solution.joined(parts)
        self.solution = together.at(-1)
        return together

    def _stretch(
        self,
        valid: npt.NDArray[np.bool_],
        columns: FloatArray,
        running: npt.NDArray[np.bool_],
        start: int,
        stop: int,
    ) -> list[Solution]:
        if stop == start:
            return []
        part = slice(start, stop)
        transforms = self.transform.advance(columns[part], valid[part], running[part])
        before: list[Information] = []
        for _ in range(stop - start):
            if self._fade < 1.0 and self.past.listened.any():
                self.past = self.past.faded(float(self._fade))
            before.append(self.past)
        solution, self.own = solve(
            transforms, self.band, self.settings.spacing, stacked(before), self.body
        )
        return [solution]

    def conclude(self) -> Solution:
        """Return the estimates from closed records alone."""
        self.solution = solve_past(self.past, self.body)
        return self.solution

    def state(self) -> dict[str, npt.NDArray[np.generic]]:
        table: dict[str, npt.NDArray[np.generic]] = {
            "open": np.array(self.open),
            "silent": np.array(self.silent),
        }
        parts = {
            "transform": self.transform.state(),
            "past": self.past.state(),
            "checkpoint": self.checkpoint.state(),
            "own": self.own.state(),
        }
        if self.solution is not None:
            parts["solution"] = self.solution.state()
        for part, arrays in parts.items():
            table.update({f"{part}.{name}": array for name, array in arrays.items()})
        return table

    def restore(self, table: Mapping[str, npt.NDArray[np.generic]]) -> None:
        self.open, self.silent = bool(table["open"]), int(table["silent"])
        self.transform.restore(_under("transform", table))
        self.past = Information.from_state(_under("past", table))
        self.checkpoint = Information.from_state(_under("checkpoint", table))
        self.own = Information.from_state(_under("own", table))
        solution = _under("solution", table)
        self.solution = Solution.from_state(solution) if solution else None


@dataclass(slots=True)
class _Window:
    """A stretch of flight that is listened to."""

    start: float
    stop: float | None = None
    overrun: bool = False  # whether samples beyond the end were taken in before it was known


class FTR:
    """Fourier transform regression on a flight as it comes in.

    It is a consumer of a session's feed: `feed` takes blocks of some channels, in order, however
    they were cut, `settle` concludes; nothing that it gives depends on the cutting.
    `settings.updates` times a second of flight it renews the estimates of the six equations.

    Parameters
    ----------
    aircraft : Aircraft
    settings : FTRSettings, optional
    rate : float
        Samples per second of the grid that samples lie on.
    origin : float
        A time that lies on that grid, s.
    axes : sequence of {"lon", "lat"}
    measured : iterable of str, optional
        Channels known to be measured. By default that shows: a channel that was silent for half
        a second is not.
    mass : float, optional
        Where there is no channel for it, at the start, kg; the aircraft file's by default.
    burning : bool
        Whether fuel burns off that mass as the throttle asks.
    aligned : bool
        Whether channels that instruments record late were brought to their right time already;
        by default FTR does that by the aircraft file.

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
        axes: Sequence[FTRAxis] = AXES,
        measured: Iterable[str] | None = None,
        mass: float | None = None,
        burning: bool = True,
        aligned: bool = False,
    ) -> None:
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
        self._equations = Equations(
            aircraft,
            self.settings,
            dt,
            self.axes,
            measured=measured,
            mass=mass,
            burning=burning,
            aligned=aligned,
        )
        self._rows = RowAssembler(rate, self.block, self._equations.ahead)
        self._runs = {
            axis: _AxisRun(axis, self.settings, dt, self.block, self._equations.body(axis))
            for axis in self.axes
        }
        self.names = tuple(name for axis in self.axes for name in axis_derivatives(axis))
        self._lookback = max(1, round(self.settings.lookback * rate / self.block))
        self._log = EstimateLog(self.names)
        self._forget()

    # --- the consumer of a feed -----------------------------------------------------------------

    def feed(self, block: Block) -> None:
        """Take in the next samples of some channels."""
        if self.origin:
            block = Block(
                channels=block.channels, times=block.times - self.origin, values=block.values
            )
        self._rows.feed(block)

    def settle(self) -> None:
        """Renew the estimates, after all blocks of a step."""
        for number, rows in self._rows.complete():
            self._take(number, rows)

    def reset(self) -> None:
        """Forget everything; the flight begins anew."""
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
        self._last: dict[FTRAxis, AxisRows] = {}  # the last row of each axis
        self._ring: deque[tuple[int, dict[FTRAxis, AxisRows]]] = deque(maxlen=self._lookback)
        self._window: _Window | None = None

    # --- windows --------------------------------------------------------------------------------

    def begin(self, start: float) -> None:
        """Listen from a time on (s), which may lie up to `FTRSettings.lookback` back.

        Raises
        ------
        FlightError
            If FTR listens always, or a window is open, or the start is too long ago.
        """
        self._must_be_gated()
        if self._window is not None:
            raise FlightError(
                f"FTR listens since {self._window.start:.1f} s; end that maneuver first"
            )
        start -= self.origin
        if self._ring and self._ring.maxlen == len(self._ring):
            oldest = self._ring[0][0] * self.block / self.rate
            if start < oldest:
                raise FlightError(
                    f"FTR remembers the flight from {oldest + self.origin:.1f} s on; a maneuver "
                    f"cannot begin at {start + self.origin:.1f} s; raise lookback"
                )
        self._window = _Window(start)
        for run in self._runs.values():
            run.open_window()
        self._replay()

    def end(self, stop: float) -> None:
        """Listen up to a time (s), then keep what the maneuver said.

        Takes effect as soon as all samples up to there have come.

        Raises
        ------
        FlightError
            If no window is open, or it would end before it began.
        """
        self._must_be_gated()
        if self._window is None:
            raise FlightError("FTR listens to no maneuver; begin one first")
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
            raise FlightError("FTR listens always; choose the gate 'maneuvers' for windows")

    def _replay(self) -> None:
        """Run the open window over the blocks remembered."""
        window = self._window
        if window is None:
            return
        first, end = self._blocks_of(window)
        inside = [(number, rows) for number, rows in self._ring if first <= number < end]
        if not inside:
            return
        self._advance(
            inside[0][0],
            {axis: AxisRows.joined([rows[axis] for _, rows in inside]) for axis in self.axes},
        )

    def _blocks_of(self, window: _Window) -> tuple[int, int]:
        """Return the first block of a window, and the one after the last."""
        N = self.block
        first = (math.ceil(window.start * self.rate - 1e-6) - 1) // N
        if window.stop is None:
            return first, 2**62
        return first, -(-math.floor(window.stop * self.rate + 1e-6) // N)

    def _masked(self, first: int, rows: AxisRows) -> AxisRows:
        """Return rows of whole blocks with what lies outside the window not valid."""
        window = self._window
        if window is None:
            return rows
        blocks, length = rows.valid.shape
        places = (first + np.arange(blocks))[:, np.newaxis] * self.block + np.arange(length)
        times = places / self.rate
        inside = times >= window.start - 1e-9
        if window.stop is not None:
            inside &= times <= window.stop + 1e-9
        return AxisRows(valid=rows.valid & inside, columns=rows.columns, running=rows.running)

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
            run.close()
        self._window = None
        running = {axis: rows.running for axis, rows in self._last.items()}
        moments = {axis: run.conclude() for axis, run in self._runs.items()}
        self._log_moments(self._next - 1, moments, running)

    # --- blocks ---------------------------------------------------------------------------------

    def _take(self, first: int, values: FloatArray) -> None:
        """Take in whole blocks."""
        N = self.block
        blocks = (len(values) - 1 - self._equations.ahead) // N
        follows = self._next == first
        self._next = first + blocks
        shaped: dict[FTRAxis, AxisRows] = {}
        for axis, rows in self._equations.rows(values).items():
            before = self._last.get(axis) if follows else None
            shaped[axis] = _with_heads(rows, before, blocks, N)
            self._last[axis] = AxisRows(
                valid=rows.valid[-1:], columns=rows.columns[-1:], running=rows.running[-1:]
            )
        if self.settings.gate == "maneuvers":
            for k in range(blocks):
                self._ring.append(
                    (first + k, {axis: rows.part(k) for axis, rows in shaped.items()})
                )
            if self._window is None:
                return
            if self._window.stop is not None:
                _, end = self._blocks_of(self._window)
                shaped = {axis: rows.first_blocks(end - first) for axis, rows in shaped.items()}
        self._advance(first, shaped)
        self._close_if_due()

    def _advance(self, first: int, rows: Mapping[FTRAxis, AxisRows]) -> None:
        """Run whole blocks through the regressions, and keep the estimates."""
        if not len(rows[self.axes[0]].valid):
            return
        moments = {
            axis: run.advance(first, self._masked(first, rows[axis]))
            for axis, run in self._runs.items()
        }
        running = {axis: one.running[:, -1] for axis, one in rows.items()}
        self._log_moments(first, moments, running)

    def _log_moments(
        self,
        first: int,
        moments: Mapping[FTRAxis, Solution],
        running: Mapping[FTRAxis, npt.NDArray[np.bool_]],
    ) -> None:
        count = len(moments[self.axes[0]].theta)
        times = self.origin + (first + 1 + np.arange(count)) * self.block / self.rate
        parts = []
        for axis in self.axes:
            solution = moments[axis]
            parts.append(Moment.of(solution, *judge(solution, self.settings, running[axis])))
        self._log.append(times, Moment.side_by_side(parts))

    # --- what it found --------------------------------------------------------------------------

    @property
    def time(self) -> float | None:
        """Return the time of the latest estimates, s; None before the first."""
        return self._log.last

    def estimates(self, time: float | None = None) -> dict[str, LiveEstimate]:
        """Return all derivatives as they stood at a time (s), by default now.

        Empty before the first update.
        """
        row = self._log.row_at(time)
        if row is None:
            return {}
        missing = self.unavailable() if time is None else {}
        return {
            name: self._estimate(name, place, row, missing) for place, name in enumerate(self.names)
        }

    def _estimate(
        self, name: str, place: int, row: int, missing: Mapping[str, str]
    ) -> LiveEstimate:
        log, settings = self._log, self.settings
        verdict = Verdict(int(log.verdicts[row, place]))
        coefficient = name.partition("_")[0]
        companion = int(log.companions[row, place])
        others = derivatives_of(coefficient)[1:]
        partner = others[companion] if companion >= 0 else None
        noise, amplitude, uncertain, listened = (float(x) for x in log.qualities[row, place])
        earned = verdict is Verdict.EARNED
        reach = min(noise / settings.signal_to_noise, 1.0) if not name.endswith("_0") else 1.0
        sure = min(settings.uncertain_share / uncertain, 1.0) if uncertain > 0.0 else 0.0
        return LiveEstimate(
            name=name,
            time=float(log.times[row]),
            value=float(log.values[row, place]) if earned else None,
            std=float(log.stds[row, place]) if earned else None,
            cramer_rao=float(log.plains[row, place]) if earned else None,
            status=verdict.status,
            confounded_with=(partner,) if verdict is Verdict.TOGETHER and partner else (),
            why=words(
                verdict,
                name=name,
                companion=None if partner is None else partner.partition("_")[2],
                signal_to_noise=noise,
                uncertain=uncertain,
                listened=listened,
                settings=settings,
                missing=missing.get(coefficient, ""),
            ),
            signal_to_noise=noise,
            amplitude=amplitude,
            progress=1.0 if earned else float(np.nan_to_num(min(reach, sure))),
        )

    def history(self, name: str) -> EstimateHistory:
        """Return all estimates of one derivative.

        Raises
        ------
        UnknownNameError
            If there is no such derivative.
        """
        if name not in self.names:
            raise UnknownNameError(
                f"FTR does not estimate '{name}'; it estimates {', '.join(self.names)}"
            )
        log, place = self._log, self.names.index(name)
        earned = log.verdicts[:, place] == Verdict.EARNED
        return EstimateHistory(
            name=name,
            times=log.times.copy(),
            values=np.where(earned, log.values[:, place], np.nan),
            stds=np.where(earned, log.stds[:, place], np.nan),
            signal_to_noise=log.qualities[:, place, 0].astype(np.float64),
        )

    def covariance(self, names: Sequence[str]) -> FloatArray:
        """Return the covariance of the latest estimates; coefficients are independent."""
        out = np.zeros((len(names), len(names)))
        for axis, run in self._runs.items():
            if run.solution is None:
                continue
            for index, coefficient in enumerate(COEFFICIENTS[axis]):
                block = _with_bias(run.solution, index)
                own = derivatives_of(coefficient)
                rows = [k for k, name in enumerate(names) if name in own]
                places = [own.index(names[k]) for k in rows]
                out[np.ix_(rows, rows)] = block[np.ix_(places, places)]
        return out

    def unavailable(self) -> dict[str, str]:
        """Return the coefficients whose equation cannot run now, with the reason in words."""
        found: dict[str, str] = {}
        for axis in self.axes:
            found.update(self._equations.why_not(axis))
        return found

    def remarks(self) -> tuple[str, ...]:
        """Return what stands in for what was not measured, in words."""
        return self._equations.remarks()

    # --- records of other flights ---------------------------------------------------------------

    def information(self) -> dict[FTRAxis, Information]:
        """Return what the closed records say."""
        return {axis: run.past for axis, run in self._runs.items()}

    def remember(self, information: Mapping[FTRAxis, Information]) -> None:
        """Start from what earlier records said."""
        for axis, run in self._runs.items():
            if axis in information:
                run.past = information[axis]

    # --- saved state ----------------------------------------------------------------------------

    def save(self, path: Path) -> None:
        """Write everything to an ``.npz`` file from which `load` goes on, bit by bit the same."""
        table: dict[str, npt.NDArray[np.generic]] = {
            "about": np.array(json.dumps(self._about())),
            "next": np.array([] if self._next is None else [self._next], dtype=np.int64),
            "window": np.array(
                []
                if self._window is None
                else [
                    self._window.start,
                    np.nan if self._window.stop is None else self._window.stop,
                ]
            ),
            "ring": np.array([number for number, _ in self._ring], dtype=np.int64),
        }
        parts: dict[str, Mapping[str, npt.NDArray[np.generic]]] = {
            "rows": self._rows.state(),
            "equations": self._equations.state(),
            "log": self._log.state(),
        }
        for axis, run in self._runs.items():
            parts[f"run.{axis}"] = run.state()
            if axis in self._last:
                parts[f"last.{axis}"] = self._last[axis].state()
            if self._ring:
                parts[f"ring.{axis}"] = AxisRows.joined(
                    [rows[axis] for _, rows in self._ring]
                ).state()
        for part, arrays in parts.items():
            table.update({f"{part}.{name}": array for name, array in arrays.items()})
        buffer = io.BytesIO()
        np.savez_compressed(buffer, allow_pickle=False, **table)
        write_atomically(path, buffer.getvalue())

    def load(self, path: Path) -> None:
        """Go on from a state that `save` wrote, with the same aircraft and settings.

        Raises
        ------
        FlightError
            If the file cannot be read, or comes from another aircraft, rate or settings.
        """
        try:
            with np.load(path, allow_pickle=False) as stored:
                table = {name: stored[name] for name in stored.files}
            about = json.loads(str(table["about"]))
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
            raise FlightError(
                f"{path} holds no state of FTR that can be read ({error}); start it anew"
            ) from error
        mine = json.loads(json.dumps(self._about()))
        different = sorted(key for key in mine if about.get(key) != mine[key])
        if different:
            raise FlightError(
                f"the state in {path} was saved with other {' and '.join(different)}; "
                "use the same, or start FTR anew"
            )
        try:
            self._restore(table)
        except (KeyError, ValueError, IndexError) as error:
            self.reset()
            raise FlightError(f"the state in {path} is not complete ({error})") from error

    def _restore(self, table: Mapping[str, npt.NDArray[np.generic]]) -> None:
        self._rows.restore(_under("rows", table))
        self._equations.restore(_under("equations", table))
        self._log.restore(_under("log", table))
        self._next = int(table["next"][0]) if table["next"].size else None
        self._forget_but_next()
        if table["window"].size:
            start, stop = (float(x) for x in np.asarray(table["window"], dtype=np.float64))
            self._window = _Window(start, None if np.isnan(stop) else stop)
        numbers = np.asarray(table["ring"], dtype=np.int64).tolist()
        ring = {}
        for axis, run in self._runs.items():
            run.restore(_under(f"run.{axis}", table))
            last = _under(f"last.{axis}", table)
            if last:
                self._last[axis] = AxisRows.from_state(last)
            if numbers:
                ring[axis] = AxisRows.from_state(_under(f"ring.{axis}", table))
        for k, number in enumerate(numbers):
            self._ring.append((number, {axis: rows.part(k) for axis, rows in ring.items()}))

    def _forget_but_next(self) -> None:
        upcoming = self._next
        self._forget()
        self._next = upcoming

    def _about(self) -> dict[str, object]:
        return {
            "version": _STATE_VERSION,
            "aircraft": self.aircraft.model_dump(mode="json"),
            "settings": self.settings.as_table(),
            "rate": self.rate,
            "origin": self.origin,
            "axes": list(self.axes),
        }


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class EstimateHistory:
    """One derivative over the flight.

    Attributes
    ----------
    name : str
    times : ndarray, shape (n,)
        s.
    values, stds : ndarray, shape (n,)
        Per radian; NaN while unknown.
    signal_to_noise : ndarray, shape (n,)
        The measure of excitation; see `LiveEstimate`.
    """

    name: str
    times: FloatArray
    values: FloatArray
    stds: FloatArray
    signal_to_noise: FloatArray


def _with_heads(rows: AxisRows, before: AxisRows | None, blocks: int, N: int) -> AxisRows:
    """Return rows as blocks of N + 1, each headed by the last row of the block before."""

    def shaped(array: npt.NDArray[np.generic], head: npt.NDArray[np.generic] | None) -> object:
        body = array.reshape(blocks, N, *array.shape[1:])
        out = np.zeros((blocks, N + 1, *array.shape[1:]), dtype=array.dtype)
        out[:, 1:] = body
        out[1:, 0] = body[:-1, -1]
        if head is not None:
            out[0, 0] = head[0]
        return out

    return AxisRows(
        valid=np.asarray(shaped(rows.valid, None if before is None else before.valid)),
        columns=np.asarray(shaped(rows.columns, None if before is None else before.columns)),
        running=np.asarray(shaped(rows.running, None if before is None else before.running)),
    )


def _with_bias(solution: Solution, equation: int) -> FloatArray:
    """Return the covariance of one equation's derivatives, bias first, shape (p + 1, p + 1)."""
    inner = solution.covariance[-1, equation]
    cross = inner @ solution.bias_slopes[-1, equation]
    p = len(inner)
    out = np.empty((p + 1, p + 1))
    out[1:, 1:] = inner
    out[0, 1:] = out[1:, 0] = cross
    out[0, 0] = solution.bias_std[-1, equation] ** 2
    return out


def _under(
    part: str, table: Mapping[str, npt.NDArray[np.generic]]
) -> dict[str, npt.NDArray[np.generic]]:
    """Return the entries of a table below a name, by the rest of their names."""
    start = part + "."
    return {name.removeprefix(start): x for name, x in table.items() if name.startswith(start)}
