"""The search from first to last: `Investigation` prepares maneuvers, `run` tells the story."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.discrepancy.answering import answer_of, borne_out
from gsapp.discrepancy.baseline import Tick, baseline_fit, settle
from gsapp.discrepancy.belonging import check_model
from gsapp.discrepancy.candidates import Competitor, named_competitors
from gsapp.discrepancy.catalog import competitors as catalog_competitors
from gsapp.discrepancy.catalog import record as catalog_record
from gsapp.discrepancy.checking import check_forced, check_maneuvers, moving_inputs
from gsapp.discrepancy.filtering.fitting import Fit
from gsapp.discrepancy.filtering.record import Record, record_of
from gsapp.discrepancy.instruments import instrument_remarks
from gsapp.discrepancy.naming import Decision, decide, threshold
from gsapp.discrepancy.results import (
    Discrepancy,
    InstrumentRemark,
)
from gsapp.discrepancy.screening import Screening, screen
from gsapp.discrepancy.settings import (
    Callback,
    DiscrepancySettings,
    Progress,
    SearchStoppedError,
)
from gsapp.discrepancy.showing import HeldOut
from gsapp.discrepancy.stages import Stage, standing_for_all, without_misnomers
from gsapp.discrepancy.unnamed import unnamed_competitors
from gsapp.dynamics.model import Model
from gsapp.dynamics.terms import make_term
from gsapp.foundation import FlightError
from gsapp.identification.maneuver import Maneuver

_REVERSED = 0.15
"""A scale this near to -1 is a reversed axis."""
_PASSES = 4
_CONTENDERS = 3
_FOREIGN = 1.2
"""Mean square of the innovations from which turned and swapped instruments are looked for first."""
_CLOSE = 16.0
"""Candidates within this gain of the best are fitted fully before a name is said."""
_KEPT = 0.25
"""Share of the gain that its column promises, that the full fit of an effect must show, unless it
shows as much as chance does not reach: far from neutral columns promise too much."""
_FAR = 12
"""Passes of a fit that starts from a motion seen by turned or swapped instruments."""


class Investigation:
    """Maneuvers made ready for any number of searches.

    Parameters
    ----------
    maneuvers : sequence of Maneuver
        Of one aircraft; of one or several flights.
    aircraft : Aircraft
    model : Model, optional
        The current model; without it the linear build-up is fitted.

    Raises
    ------
    FlightError
        If there are too few maneuvers to keep any out, or they hold too little.
    """

    def __init__(
        self, maneuvers: Sequence[Maneuver], aircraft: Aircraft, model: Model | None = None
    ) -> None:
        check_maneuvers(maneuvers, aircraft)
        if model is not None:
            check_model(model, maneuvers)
        self._maneuvers = tuple(maneuvers)
        self._aircraft = aircraft
        self._model = model
        self._records = tuple(record_of(one) for one in maneuvers)
        self._baselines: dict[tuple[str, ...], Fit] = {}
        self._instruments: dict[bool, tuple[InstrumentRemark, ...]] = {}

    @property
    def default_held_out(self) -> tuple[str, ...]:
        """Return the maneuvers that are kept out unless told otherwise: one of four, of each kind.

        The second of every four with the same inputs, so that none is the only one of its kind.
        """
        seen: dict[tuple[str, ...], int] = {}
        kept = []
        for one in self._maneuvers:
            number = seen.get(one.inputs, 0)
            seen[one.inputs] = number + 1
            if number % 4 == 1:
                kept.append(one.id)
        if not kept:
            kept = [self._maneuvers[len(self._maneuvers) // 2].id]
        return tuple(kept)

    def run(
        self, settings: DiscrepancySettings, *, progress: Callback | None = None
    ) -> Discrepancy:
        """Search.

        Raises
        ------
        SearchStoppedError
            If `progress` returned False.
        FlightError
            If an effect was forced that these flights or this aircraft cannot have.
        """
        return _Search(self, settings, progress).finish()

    def baseline(self, held_out: tuple[str, ...], tick: Tick) -> Fit:
        """Return the baseline fitted without the maneuvers kept out; fitted once."""
        if held_out not in self._baselines:
            records = [one for one in self._records if one.id not in held_out]
            self._baselines[held_out] = baseline_fit(records, self._model, tick)
        return self._baselines[held_out]

    def instruments(self, tick: Tick, *, try_signs: bool) -> tuple[InstrumentRemark, ...]:
        """Return what kinematics alone say of the instruments; looked at once."""
        if try_signs not in self._instruments:
            tick("comparing the instruments with one another")
            self._instruments[try_signs] = instrument_remarks(self._maneuvers, try_signs=try_signs)
        return self._instruments[try_signs]

    @property
    def records(self) -> tuple[Record, ...]:
        """Return the maneuvers made ready."""
        return self._records

    @property
    def maneuvers(self) -> tuple[Maneuver, ...]:
        """Return the maneuvers."""
        return self._maneuvers

    @property
    def aircraft(self) -> Aircraft:
        """Return the aircraft."""
        return self._aircraft

    @property
    def model(self) -> Model | None:
        """Return the current model, where one was given."""
        return self._model


class _Search:
    """One run: collects stages until nothing more is proven."""

    def __init__(
        self, of: Investigation, settings: DiscrepancySettings, progress: Callback | None
    ) -> None:
        self._of, self._settings, self._progress = of, settings, progress
        self._done = 0.0
        self._failed: set[str] = set()
        self._trials: dict[str, Fit] = {}
        held = settings.held_out
        self._held_out = of.default_held_out if held is None else tuple(held)
        if len(self._held_out) >= len(of.maneuvers):
            raise FlightError("all maneuvers are kept out; leave some to learn from")
        check_forced(settings.forced, of.aircraft, of.maneuvers)

    def _tick(self, doing: str) -> None:
        # The share is a guess: how many effects there are shows only at the end.
        self._done += 0.04 * (1.0 - self._done)
        self._tell(doing)

    def _tell(self, doing: str) -> None:
        if self._progress is not None and (
            self._progress(Progress(share=self._done, doing=doing)) is False
        ):
            raise SearchStoppedError("the search was stopped; nothing was changed")

    # --- competitors ----------------------------------------------------------------------------

    def _competitors(self, fit: Fit) -> tuple[Competitor, ...]:
        of = self._of
        channels = {name for one in of.maneuvers for name in one.block.channels}
        moving = moving_inputs(of.maneuvers)
        present = {effect.id for effect in fit.model.effects}
        records = [
            one
            for one in catalog_competitors(of.aircraft, channels, moving=moving)
            if one.derivative not in fit.free
            and one.id not in present
            and one.id not in self._settings.refused
            and one.id not in self._failed
        ]
        named = named_competitors(records, of.aircraft)
        unnamed = unnamed_competitors(named, throttle="throttle" in moving, flap="flap" in moving)
        return (*named, *(one for one in unnamed if one.id not in self._settings.refused))

    # --- the loop -------------------------------------------------------------------------------

    def finish(self) -> Discrepancy:
        stages = self._stages()
        return self._answer(stages)

    def _stages(self) -> list[Stage]:
        fit = self._of.baseline(self._held_out, self._tick)
        stages = [self._stage(fit, added="")]
        stages += self._proven(stages[0])
        for effect in self._settings.forced:
            competitor = next(
                (one for one in stages[-1].screening.competitors if one.id == effect), None
            )
            stages.append(self._with(stages[-1], effect, competitor, forced=True))
        while len(stages) <= self._settings.most_effects + len(self._settings.forced):
            last = stages[-1]
            among = standing_for_all(last)
            if last.decision.best is None or not (last.decision.kind == "name" or among):
                break
            try:
                new = self._with(last, last.decision.best.id, last.decision.best)
                stages.append(replace(new, among=among))
            except FlightError:
                # A fit that runs away is no explanation; the others go on competing.
                self._failed.add(last.decision.best.id)
                stages[-1] = self._stage(last.fit, added=last.added, forced=last.forced)
        return without_misnomers(stages, len(self._settings.forced))

    def _proven(self, baseline: Stage) -> list[Stage]:
        """Return stages with turned and swapped instruments that kinematics alone prove.

        No model explains flights that were recorded so; named later, others would come first.
        """
        if baseline.screening.misfit < _FOREIGN:
            return []
        stages = [baseline]
        for remark in self._of.instruments(self._tick, try_signs=True):
            known = {one.id for one in stages[-1].fit.model.effects}
            if remark.effect and remark.effect not in (*known, *self._settings.refused):
                new = self._with(stages[-1], remark.effect, None)
                stages.append(replace(new, proven=True))
        return stages[1:]

    def _stage(self, fit: Fit, *, added: str, forced: bool = False) -> Stage:
        competitors = self._competitors(fit)
        self._tick("trying every effect of the catalog")
        screening = screen(fit, competitors)
        least = threshold(self._settings.false_alarm, competitors)
        temper = screening.temper
        decision = decide(screening, screening.gain, least=least, temper=temper)
        if decision.kind in ("name", "ambiguous", "unexplained"):
            decision = self._contest(fit, screening, decision, least, temper)
        return Stage(fit=fit, added=added, screening=screening, decision=decision, forced=forced)

    def _contest(
        self, fit: Fit, screening: Screening, decision: Decision, least: float, temper: float
    ) -> Decision:
        """Fit those fully that come near the best, and decide again."""
        best = float(screening.gain.max())
        near = [
            place
            for place in screening.order
            if screening.competitors[place].named and screening.gain[place] > best - _CLOSE
        ][:_CONTENDERS]
        if len(near) < 2:
            return decision
        gain = screening.gain.copy()
        costs: dict[int, float] = {}
        for place in near:
            one = screening.competitors[place]
            try:
                trial = self._fitted_with(fit, one, screening, f"comparing: {one.title}")
            except FlightError:
                gain[place] = 0.0
                continue
            self._trials[one.id] = trial
            costs[place] = trial.cost()
        if not costs:
            return decide(screening, gain, least=least, temper=temper)
        # The best fit keeps its gain by columns; the others differ from it as their fits do.
        best_fit = min(costs, key=lambda place: costs[place])
        for place, cost in costs.items():
            gain[place] = screening.gain[best_fit] - (cost - costs[best_fit])
        return decide(screening, np.maximum(gain, 0.0), least=least, temper=temper)

    # --- adding ---------------------------------------------------------------------------------

    def _fitted_with(
        self, fit: Fit, one: Competitor, screening: Screening | None, doing: str
    ) -> Fit:
        term = make_term(one.id, self._of.aircraft)
        values = dict(term.defaults)
        if one.parameter:
            item = next(item for item in term.parameters if item.name == one.parameter)
            if one.start is not None:
                start = one.start(
                    [each.filter.linearization for each in fit.maneuvers if each.filter]
                )
            elif screening is not None:
                start = one.neutral + float(screening.size[screening.place(one.id)])
            else:
                start = item.default
            margin = 1e-3 * (item.bounds[1] - item.bounds[0])
            values[one.parameter] = float(
                np.clip(start, item.bounds[0] + margin, item.bounds[1] - margin)
            )
        model = fit.revised_model().with_effect(one.id, values)
        free = (*fit.free, *((f"{one.id}.{one.parameter}",) if one.parameter else ()))
        new = fit.with_model(model, free)
        settle(new, _PASSES if screening else _FAR, self._tick, doing, fresh=True)
        return new

    def _with(
        self, last: Stage, effect: str, competitor: Competitor | None, *, forced: bool = False
    ) -> Stage:
        one = competitor or _as_competitor(effect, self._of.aircraft)
        fit = self._trials.pop(effect, None) or self._fitted_with(
            last.fit,
            one,
            last.screening if competitor else None,
            f"fitting the model with: {one.title}",
        )
        self._trials.clear()
        if competitor and not forced:
            _check_gain(last, fit, competitor, self._settings.false_alarm)
        if (
            one.id.startswith("sensor.")
            and one.id.endswith(".scale")
            and abs(fit.values[f"{one.id}.scale"] + 1.0) < _REVERSED
        ):
            effect = one.id.removesuffix(".scale") + ".reversed"
            model = fit.revised_model().without_effect(one.id).with_effect(effect)
            one = _as_competitor(effect, self._of.aircraft)
            fit = fit.with_model(model, last.fit.free)
            settle(fit, _PASSES, self._tick, f"fitting the model with: {one.title}")
        number = len(fit.model.effects)
        parent = last.fit.model
        fit.model = fit.model.model_copy(
            update={"name": f"{_root(parent)} + {number}", "parent": parent.name}
        )
        return self._stage(fit, added=effect, forced=forced)

    # --- the answer -----------------------------------------------------------------------------

    def _answer(self, stages: list[Stage]) -> Discrepancy:
        of, settings = self._of, self._settings
        self._tick("looking at the maneuvers kept out")
        kept, held = borne_out(
            stages,
            lambda chosen: HeldOut(of.records, self._held_out, [one.fit for one in chosen]),
            len(settings.forced),
            settings.false_alarm,
        )
        instruments: tuple[InstrumentRemark, ...] = ()
        if settings.check_instruments:
            lacking = len(kept) > 1 or kept[0].decision.kind != "nothing"
            instruments = of.instruments(self._tick, try_signs=lacking)
        self._tick("drawing the maneuvers")
        found = answer_of(
            kept,
            held,
            maneuvers=of.maneuvers,
            aircraft=of.aircraft,
            model=of.model,
            instruments=instruments,
            false_alarm=settings.false_alarm,
        )
        self._done = 1.0
        self._tell("done")
        return found


def _root(model: Model) -> str:
    return model.name.partition(" + ")[0]


def _check_gain(last: Stage, fit: Fit, one: Competitor, false_alarm: float) -> None:
    """Refuse an effect that the full fit does not bear out.

    Raises
    ------
    FlightError
        If little is left of the gain that its column promised.
    """
    promised = float(last.decision.gain[last.screening.place(one.id)])
    gained = last.fit.cost() - fit.cost()
    if gained < min(_KEPT * promised, threshold(false_alarm, last.screening.competitors)):
        raise FlightError(f"{one.id}: {gained:.0f} gained in the full fit, not {promised:.0f}")


def _as_competitor(effect: str, aircraft: Aircraft) -> Competitor:
    record = catalog_record(effect)
    term = make_term(effect, aircraft)
    free = [item for item in term.parameters if item.free]
    return Competitor(
        id=effect,
        title=record.title,
        named=True,
        parameter=free[0].name if free else "",
        plausible=free[0].default - free[0].neutral if free else 1.0,
        neutral=free[0].neutral if free else 0.0,
        make=lambda _: None,
    )
