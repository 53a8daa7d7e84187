"""The search from first to last: `Investigation` prepares maneuvers, `run` tells the story."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from weakref import WeakKeyDictionary

from gsapp.aircraft import Aircraft
from gsapp.discrepancy.candidates import (
    CandidateEffect,
    StallScreening,
    catalog_candidates,
    screen_stall,
    unnamed_candidates,
)
from gsapp.discrepancy.effect_catalog import eligible_effects as catalog_competitors
from gsapp.discrepancy.effect_catalog import excluded_effects
from gsapp.discrepancy.effect_fitting import EffectFitter
from gsapp.discrepancy.effect_selection import (
    compute_column_information,
    detection_threshold,
    screen_candidates,
    select_effect,
)
from gsapp.discrepancy.experiment_design import design_experiment
from gsapp.discrepancy.held_out_maneuvers import HeldOutManeuvers, SettledFits, is_held_out
from gsapp.discrepancy.rejected_effects import RejectedEffects, is_rest
from gsapp.discrepancy.result_builder import build_result, validate_on_held_out
from gsapp.discrepancy.results import DiscrepancyResult, InstrumentRemark
from gsapp.discrepancy.search_checks import (
    check_forced_effects,
    check_instruments,
    check_maneuvers,
    check_model_match,
    comparable_maneuvers,
    highest_alpha,
    moving_inputs,
)
from gsapp.discrepancy.search_stages import (
    SearchStage,
    equivalent_effects_of,
    find_wrong_effects,
    fit_baseline,
    is_refuted,
    next_effect,
    refuted,
)
from gsapp.discrepancy.settings import (
    SEARCH,
    DiscrepancySettings,
    SearchProgress,
    SearchProgressCallback,
    SearchStoppedError,
)
from gsapp.discrepancy.unexplained_structure import with_structures
from gsapp.dynamics.model import Model
from gsapp.foundation import FlightError
from gsapp.identification.filter_error.filter_error_fit import FilterErrorFit, InformationMatrix
from gsapp.identification.filter_error.motion_linearization import (
    create_maneuver_record,
)
from gsapp.identification.filter_error.noise_tuning import ActivityCallback
from gsapp.identification.maneuver import Maneuver


class Investigation:
    """Maneuvers of one or several flights of one aircraft, made ready for any number of searches.

    Without a current model the linear build-up is fitted. Raise FlightError if there are too few
    maneuvers to keep any out, or they hold too little.
    """

    def __init__(
        self, maneuvers: Sequence[Maneuver], aircraft: Aircraft, model: Model | None = None
    ) -> None:
        maneuvers = comparable_maneuvers(maneuvers)
        check_maneuvers(maneuvers, aircraft)
        if model is not None:
            check_model_match(model, maneuvers)
        self.maneuvers = tuple(maneuvers)
        self.aircraft = aircraft
        self.model = model
        self.records = tuple(create_maneuver_record(one) for one in maneuvers)
        self._baselines: dict[tuple[str, ...], FilterErrorFit] = {}
        self._instruments: dict[bool, tuple[InstrumentRemark, ...]] = {}

    @property
    def default_held_out(self) -> tuple[str, ...]:
        """Return the maneuvers that are kept out unless told otherwise: one of four, of each kind.

        The second of every four with the same inputs, so that none is the only one of its kind.
        """
        seen: dict[tuple[str, ...], int] = {}
        kept = []
        for one in self.maneuvers:
            number = seen.get(one.inputs, 0)
            seen[one.inputs] = number + 1
            if is_held_out(number):
                kept.append(one.id)
        if not kept:
            kept = [self.maneuvers[len(self.maneuvers) // 2].id]
        return tuple(kept)

    def run(
        self, settings: DiscrepancySettings, *, progress: SearchProgressCallback | None = None
    ) -> DiscrepancyResult:
        """Search.

        Raise SearchStoppedError if `progress` returned False. Raise FlightError if an effect was
        forced that these flights or this aircraft cannot have.
        """
        return _Search(self, settings, progress).finish()

    def baseline(self, held_out: tuple[str, ...], tick: ActivityCallback) -> FilterErrorFit:
        if held_out not in self._baselines:
            records = [one for one in self.records if one.id not in held_out]
            self._baselines[held_out] = fit_baseline(records, self.model, tick)
        return self._baselines[held_out]

    def instruments(
        self, tick: ActivityCallback, *, try_signs: bool
    ) -> tuple[InstrumentRemark, ...]:
        """Return what kinematics alone say of the instruments; looked at once."""
        if try_signs not in self._instruments:
            tick("comparing the instruments with one another")
            self._instruments[try_signs] = check_instruments(self.maneuvers, try_signs=try_signs)
        return self._instruments[try_signs]


class _Search:
    """One run: collects stages until nothing more is proven."""

    def __init__(
        self,
        of: Investigation,
        settings: DiscrepancySettings,
        progress: SearchProgressCallback | None,
    ) -> None:
        self._of, self._settings, self._progress = of, settings, progress
        self._done = 0.0
        self._rejected = RejectedEffects()
        self._settled: SettledFits = WeakKeyDictionary()
        self._stalls: WeakKeyDictionary[FilterErrorFit, StallScreening] = WeakKeyDictionary()
        # Of the last fit alone: they take tens of megabytes.
        self._columns: tuple[FilterErrorFit, Mapping[str, InformationMatrix]] | None = None
        self._fitter = EffectFitter(of.aircraft, settings.false_alarm, self._tick)
        held = settings.held_out
        self._held_out = of.default_held_out if held is None else tuple(held)
        if len(self._held_out) >= len(of.maneuvers):
            raise FlightError("all maneuvers are held out; keep some for fitting")
        check_forced_effects(settings.forced, of.aircraft, of.maneuvers)

    def _tick(self, doing: str) -> None:
        # The share is a guess: how many effects there are shows only at the end.
        self._done += 0.04 * (1.0 - self._done)
        self._tell(doing)

    def _tell(self, doing: str) -> None:
        if self._progress is not None and (
            self._progress(SearchProgress(share=self._done, activity=doing)) is False
        ):
            raise SearchStoppedError("the search was stopped; no changes")

    # --- competitors ----------------------------------------------------------------------------

    def _competitors(self, fit: FilterErrorFit) -> tuple[CandidateEffect, ...]:
        of = self._of
        channels = {name for one in of.maneuvers for name in one.block.channels}
        moving = moving_inputs(of.maneuvers)
        left_out = {
            *(effect.id for effect in fit.model.effects),
            *self._settings.refused,
            *self._rejected.failed,
        }
        # An effect through an input that stood still may look like another one: it competes, too.
        top = highest_alpha(of.maneuvers)
        still = excluded_effects(of.aircraft, channels, moving=moving)
        records = [
            one
            for one in catalog_competitors(of.aircraft, channels, highest_alpha=top)
            if one.derivative not in fit.free and one.id not in left_out
        ]
        stall = None
        if any(one.beyond_linear_alpha for one in records):
            if fit not in self._stalls:
                maneuvers = [one.record.maneuver for one in fit.maneuvers]
                self._stalls[fit] = screen_stall(fit.model, maneuvers, of.aircraft)
            stall = self._stalls[fit]
        flown = [one.filter.linearization for one in fit.maneuvers if one.filter]
        named = catalog_candidates(records, of.aircraft, still, flown, stall=stall)
        unnamed = unnamed_candidates(
            named, of.aircraft, throttle="throttle" in moving, flap="flap" in moving
        )
        return (*named, *(one for one in unnamed if one.id not in left_out))

    # --- the loop -------------------------------------------------------------------------------

    def finish(self) -> DiscrepancyResult:
        stages = self._stages()
        return self._answer(stages)

    def _stages(self) -> list[SearchStage]:
        fit = self._of.baseline(self._held_out, self._tick)
        stages = [self._stage(fit, added="")]
        stages += self._proven(stages[0])
        for effect in self._settings.forced:
            competitor = next(
                (one for one in stages[-1].screening.candidates if one.id == effect), None
            )
            stages.append(self._with(stages[-1], effect, competitor, forced=True))
        first = len(stages)
        while one := self._next_effect(stages[first:], stages[-1]):
            if is_rest(one, stages[first - 1 :]):
                if self._rejected.is_full:
                    break
                self._rejected.rests[one.id] = one
                stages[-1] = self._again(stages[-1])
                continue
            new = self._borne_out(stages[-1], one)
            if new is None:
                if self._rejected.is_full:
                    break
                stages[-1] = self._again(stages[-1])
                continue
            stages = self._added(stages, new, one, first)
        stages[-1] = self._rejected.explain(stages[-1])
        return stages

    def _borne_out(self, last: SearchStage, one: CandidateEffect) -> FilterErrorFit | None:
        """Return the fit with an effect added; None, and set aside, where it is not borne out."""
        try:
            fit = self._fitter.fit_with(last, one.id, one)
        except FlightError:
            # A fit that runs away is no explanation; the others go on competing.
            self._rejected.failed.add(one.id)
            return None
        held = self._held((last.fit, fit))
        if one.named:
            if is_refuted(last, held, 0, self._settings.false_alarm):
                self._rejected.refuted[one.id] = refuted(last, self._settings.false_alarm).decision
                return None
        elif held.gain(0, 1) <= 0.0:
            self._rejected.closed.add(one.id.split(".")[1])
            return None
        return fit

    def _added(
        self, stages: list[SearchStage], fit: FilterErrorFit, one: CandidateEffect, first: int
    ) -> list[SearchStage]:
        """Return the stages with one more, and without what it shows to be wrong."""
        last, added = stages[-1], fit.model.effects[-1].id
        if not one.named:
            self._rejected.close_crowded((*(stage.added for stage in stages[first:]), added))
        new = self._stage(fit, added=added)
        among = equivalent_effects_of(last) if one.named else ()
        stages = [*stages, replace(new, equivalent_effects=among)]
        last.fit.forget_filters()
        kept, wrong = find_wrong_effects(stages, first)
        if not wrong:
            return stages
        self._rejected.failed |= wrong
        return [*stages[: kept - 1], self._again(stages[kept - 1])]

    def _next_effect(
        self, found: Sequence[SearchStage], last: SearchStage
    ) -> CandidateEffect | None:
        settings = self._settings
        return next_effect(found, last, settings.most_effects, settings.false_alarm)

    def _held(self, fits: Sequence[FilterErrorFit]) -> HeldOutManeuvers:
        """Return the maneuvers kept out under the models of fits."""
        return HeldOutManeuvers(self._of.records, self._held_out, fits, self._settled)

    def _again(self, stage: SearchStage) -> SearchStage:
        """Return a stage with the competition of what is left to compete."""
        new = self._stage(stage.fit, added=stage.added, forced=stage.forced)
        return replace(new, proven=stage.proven, equivalent_effects=stage.equivalent_effects)

    def _proven(self, baseline: SearchStage) -> list[SearchStage]:
        """Return stages with turned and swapped instruments that kinematics alone prove.

        No model explains flights that were recorded so; named later, others would come first.
        """
        screening = baseline.screening
        leading = screening.ranking[: SEARCH.sign_check_ranks]
        suspected = any(screening.candidates[k].id.startswith("sensor.") for k in leading)
        if screening.misfit < SEARCH.sign_check_misfit or not suspected:
            return []
        stages = [baseline]
        for remark in self._of.instruments(self._tick, try_signs=True):
            known = {one.id for one in stages[-1].fit.model.effects}
            if remark.effect and remark.effect not in (*known, *self._settings.refused):
                new = self._with(stages[-1], remark.effect, None)
                stages.append(replace(new, proven=True))
        return stages[1:]

    def _stage(self, fit: FilterErrorFit, *, added: str, forced: bool = False) -> SearchStage:
        if not fit.is_linearized:
            fit.linearize()
        everything = self._competitors(fit)
        closed = [one for one in everything if self._rejected.is_projected(one)]
        competitors = [one for one in everything if one not in closed]
        self._tick("trying every effect of the catalog")
        if self._columns is None or self._columns[0] is not fit:
            self._columns = fit, compute_column_information(fit, everything)
        screening = screen_candidates(fit, competitors, closed, self._columns[1])
        least = detection_threshold(self._settings.false_alarm, competitors)
        decision = select_effect(
            screening, screening.gain, least=least, temper=screening.gain_factor
        )
        if decision.kind in ("name", "ambiguous", "unexplained"):
            decision = self._fitter.contest(fit, screening, decision, least)
        return SearchStage(
            fit=fit,
            added=added,
            screening=screening,
            decision=decision,
            forced=forced,
        )

    def _with(
        self,
        last: SearchStage,
        effect: str,
        competitor: CandidateEffect | None,
        *,
        forced: bool = False,
    ) -> SearchStage:
        fit = self._fitter.fit_with(last, effect, competitor, forced=forced)
        return self._stage(fit, added=fit.model.effects[-1].id, forced=forced)

    # --- the answer -----------------------------------------------------------------------------

    def _answer(self, stages: list[SearchStage]) -> DiscrepancyResult:
        of, settings = self._of, self._settings
        self._tick("evaluating held-out maneuvers")
        kept, held = validate_on_held_out(
            stages,
            lambda chosen: self._held([one.fit for one in chosen]),
            len(settings.forced),
            settings.false_alarm,
        )
        instruments: tuple[InstrumentRemark, ...] = ()
        if settings.check_instruments:
            lacking = len(kept) > 1 or kept[0].decision.kind != "nothing"
            instruments = of.instruments(self._tick, try_signs=lacking)
        self._tick("drawing the maneuvers")
        found = build_result(
            kept,
            held,
            maneuvers=of.maneuvers,
            aircraft=of.aircraft,
            model=of.model,
            instruments=instruments,
            false_alarm=settings.false_alarm,
        )
        found = with_structures(found, of.records, of.aircraft, tables=settings.tables)
        self._tick("designing the next maneuvers")
        one = design_experiment(kept, found.verdict, of.maneuvers, self._fitter.trial)
        found = replace(found, experiment=one)
        self._done = 1.0
        self._tell("done")
        return found
