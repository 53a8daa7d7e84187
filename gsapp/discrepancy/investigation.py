"""The search from first to last: `Investigation` prepares maneuvers, `run` tells the story."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.discrepancy.candidates import (
    CandidateEffect,
    catalog_candidates,
    coefficient_of,
    screen_stall,
    unnamed_candidates,
)
from gsapp.discrepancy.effect_catalog import eligible_effects as catalog_competitors
from gsapp.discrepancy.effect_catalog import excluded_effects
from gsapp.discrepancy.effect_catalog import find_effect as catalog_record
from gsapp.discrepancy.effect_selection import (
    CandidateScreening,
    EffectDecision,
    detection_threshold,
    screen_candidates,
    select_effect,
)
from gsapp.discrepancy.held_out_maneuvers import HeldOutManeuvers
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
    best_unnamed,
    equivalent_effects_of,
    find_wrong_effects,
    fit_baseline,
    fit_from_record,
)
from gsapp.discrepancy.settings import (
    SEARCH,
    DiscrepancySettings,
    SearchProgress,
    SearchProgressCallback,
    SearchStoppedError,
)
from gsapp.dynamics.effects.unnamed_terms import is_unnamed
from gsapp.dynamics.model import Model
from gsapp.dynamics.terms import create_term
from gsapp.foundation import FlightError
from gsapp.identification.filter_error.filter_error_fit import FilterErrorFit
from gsapp.identification.filter_error.motion_linearization import (
    create_maneuver_record,
)
from gsapp.identification.filter_error.noise_tuning import ActivityCallback, fit_to_convergence
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
            if number % 4 == 1:
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
        self._failed: set[str] = set()
        self._closed: set[str] = set()
        self._rests: dict[str, CandidateEffect] = {}
        self._trials: dict[str, FilterErrorFit] = {}
        self._tried_fit: FilterErrorFit | None = None
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
        present = {effect.id for effect in fit.model.effects}
        # An effect through an input that stood still may look like another one: it competes, too.
        top = highest_alpha(of.maneuvers)
        still = excluded_effects(of.aircraft, channels, moving=moving)
        records = [
            one
            for one in catalog_competitors(of.aircraft, channels, highest_alpha=top)
            if one.derivative not in fit.free
            and one.id not in present
            and one.id not in self._settings.refused
            and one.id not in self._failed
        ]
        stall = None
        if any(one.beyond_linear_alpha for one in records):
            maneuvers = [one.record.maneuver for one in fit.maneuvers]
            stall = screen_stall(fit.model, maneuvers, of.aircraft)
        flown = [one.filter.linearization for one in fit.maneuvers if one.filter]
        named = catalog_candidates(records, of.aircraft, still, flown, stall=stall)
        unnamed = unnamed_candidates(
            named, of.aircraft, throttle="throttle" in moving, flap="flap" in moving
        )
        left_out = {*present, *self._failed, *self._settings.refused}
        return (*named, *(one for one in unnamed if one.id not in left_out))

    def _is_closed(self, one: CandidateEffect) -> bool:
        """Return whether a candidate is a rest, or for a coefficient that is closed."""
        group, target, *_ = one.id.split(".")
        is_closed = group in ("aero", "unnamed") and coefficient_of(target) in self._closed
        return is_closed or one.id in self._rests

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
            last = stages[-1]
            if self._is_rest(one, stages[first - 1 :]):
                if len(self._rests) == SEARCH.max_rests:
                    break
                self._rests[one.id] = one
                stages[-1] = self._again(last)
                continue
            try:
                fit = self._fit_with(last, one.id, one)
            except FlightError:
                # A fit that runs away is no explanation; the others go on competing.
                self._failed.add(one.id)
                stages[-1] = self._again(last)
                continue
            if not one.named and not self._is_borne_out(last.fit, fit):
                # What this coefficient lacks has no shape that holds on other maneuvers: names
                # take what it cannot explain whatever its shape.
                self._closed.add(one.id.split(".")[1])
                stages[-1] = self._again(last)
                continue
            added = fit.model.effects[-1].id
            if not one.named:
                self._close_crowded((*(stage.added for stage in stages[first:]), added))
            new = self._stage(fit, added=added)
            among = equivalent_effects_of(last) if one.named else ()
            stages.append(replace(new, equivalent_effects=among))
            last.fit.forget_filters()
            kept, wrong = find_wrong_effects(stages, first)
            if wrong:
                self._failed |= wrong
                stages = [*stages[: kept - 1], self._again(stages[kept - 1])]
        lacking = [
            one for name, one in self._rests.items() if not one.named and not is_unnamed(name)
        ]
        if lacking and stages[-1].decision.kind == "nothing":
            unexplained = replace(
                stages[-1].decision, kind="unexplained", best=lacking[0], alternatives=(lacking[0],)
            )
            stages[-1] = replace(stages[-1], decision=unexplained)
        return stages

    def _is_rest(self, one: CandidateEffect, stages: Sequence[SearchStage]) -> bool:
        """Return whether what would be added next is no part of the model.

        No term makes an instrument ring, and what is small beside the effects found is how these
        differ from their form in the catalog.
        """
        if not one.named and not is_unnamed(one.id):
            return True
        last = stages[-1]
        gain = float(last.decision.gain[last.screening.index(one.id)])
        explained = [float(earlier.decision.gain.max()) for earlier, _ in pairwise(stages)]
        share = SEARCH.min_name_share if one.named else SEARCH.min_rest_share
        return gain < share * max(explained, default=0.0)

    def _next_effect(
        self, found: Sequence[SearchStage], last: SearchStage
    ) -> CandidateEffect | None:
        """Return what to add next: what was named, or the structure for which there is no name."""
        names = sum(not is_unnamed(one.added) for one in found)
        is_clear = last.decision.kind == "name" or equivalent_effects_of(last)
        if last.decision.kind == "unexplained" and not is_clear:
            least = detection_threshold(self._settings.false_alarm, last.screening.candidates)
            return best_unnamed(last, least)
        return last.decision.best if is_clear and names < self._settings.most_effects else None

    def _close_crowded(self, found: Sequence[str]) -> None:
        """Close the coefficients that have taken many terms without a name."""
        counts = Counter(one.split(".")[1] for one in found if is_unnamed(one))
        self._closed |= {
            target for target, count in counts.items() if count >= SEARCH.max_unnamed_terms
        }

    def _is_borne_out(self, before: FilterErrorFit, after: FilterErrorFit) -> bool:
        """Return whether maneuvers held out speak for what a fit has and the one before has not."""
        held = HeldOutManeuvers(self._of.records, self._held_out, (before, after))
        return held.gain(0, 1) > 0.0

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
        closed = [one for one in everything if self._is_closed(one)]
        competitors = [one for one in everything if one not in closed]
        self._tick("trying every effect of the catalog")
        screening = screen_candidates(fit, competitors, closed)
        least = detection_threshold(self._settings.false_alarm, competitors)
        temper = screening.gain_factor
        decision = select_effect(screening, screening.gain, least=least, temper=temper)
        if decision.kind in ("name", "ambiguous", "unexplained"):
            decision = self._contest(fit, screening, decision, least, temper)
        return SearchStage(
            fit=fit,
            added=added,
            information=fit.information().with_priors(fit.priors()),
            screening=screening,
            decision=decision,
            forced=forced,
        )

    def _contest(
        self,
        fit: FilterErrorFit,
        screening: CandidateScreening,
        decision: EffectDecision,
        least: float,
        temper: float,
    ) -> EffectDecision:
        """Fit those fully that come near the best, and decide again."""
        best = float(screening.gain.max())
        near = [
            place
            for place in screening.ranking
            if screening.candidates[place].named
            and screening.gain[place] > best - SEARCH.max_contender_gap
        ][: SEARCH.max_contenders]
        proven = [place for place in screening.ranking if screening.candidates[place].proven]
        near += [place for place in proven if place not in near]
        if len(near) < 2 and not proven:
            return decision
        gain = screening.gain.copy()
        costs: dict[int, float] = {}
        if fit is not self._tried_fit:
            self._trials.clear()
            self._tried_fit = fit
        for place in near:
            one = screening.candidates[place]
            try:
                # Where only the competition is held again, the same fit has been tried before.
                trial = self._trials.get(one.id) or self._fitted_with(
                    fit, one, screening, f"comparing: {one.title}"
                )
            except FlightError:
                gain[place] = 0.0
                continue
            self._trials[one.id] = trial
            costs[place] = trial.deviance() + one.shape_cost
        if not costs:
            return select_effect(screening, gain, least=least, temper=temper)
        # The best fit keeps its gain by columns; the others differ from it as their fits do.
        best_fit = min(costs, key=lambda place: costs[place])
        for place, cost in costs.items():
            gain[place] = screening.gain[best_fit] - (cost - costs[best_fit])
        if best_fit in proven:
            gain[best_fit] = max(gain[best_fit], fit.deviance() - costs[best_fit])
        return select_effect(screening, np.maximum(gain, 0.0), least=least, temper=temper)

    # --- adding ---------------------------------------------------------------------------------

    def _fitted_with(
        self,
        fit: FilterErrorFit,
        one: CandidateEffect,
        screening: CandidateScreening | None,
        doing: str,
    ) -> FilterErrorFit:
        term = create_term(one.id, self._of.aircraft)
        values = {**term.defaults, **one.shape}
        if one.parameter:
            item = next(item for item in term.parameters if item.name == one.parameter)
            if screening is not None:
                start = one.neutral + float(screening.size[screening.index(one.id)])
            else:
                start = item.default
            margin = 1e-3 * (item.bounds[1] - item.bounds[0])
            values[one.parameter] = float(
                np.clip(start, item.bounds[0] + margin, item.bounds[1] - margin)
            )
        model = fit.revised_model().with_effect(one.id, values)
        free = (*fit.free, *((f"{one.id}.{one.parameter}",) if one.parameter else ()))
        try:
            if one.shape:
                # Without the stall, noise and gusts had taken its part.
                records = [each.record for each in fit.maneuvers]
                shape = tuple(f"{one.id}.{name}" for name in one.fitted)
                return fit_from_record(records, model, free, self._tick, doing, shape)
            new = fit.with_model(model, free)
            passes = SEARCH.effect_passes if one.named else SEARCH.unnamed_passes
            fit_to_convergence(
                new,
                passes if screening else SEARCH.max_passes_far_start,
                self._tick,
                doing,
                fresh=True,
            )
        except FlightError as error:
            raise FlightError(f"with {one.id} added, {error}; refuse the effect") from error
        return new

    def _with(
        self,
        last: SearchStage,
        effect: str,
        competitor: CandidateEffect | None,
        *,
        forced: bool = False,
    ) -> SearchStage:
        fit = self._fit_with(last, effect, competitor, forced=forced)
        return self._stage(fit, added=fit.model.effects[-1].id, forced=forced)

    def _fit_with(
        self,
        last: SearchStage,
        effect: str,
        competitor: CandidateEffect | None,
        *,
        forced: bool = False,
    ) -> FilterErrorFit:
        """Return the fit of a stage with an effect added, of its screening if it competes.

        Raise FlightError if it runs away, or bears out little of what its column promised.
        """
        one = competitor or _to_candidate(effect, self._of.aircraft)
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
            and abs(fit.values[f"{one.id}.scale"] + 1.0) < SEARCH.reversal_tolerance
        ):
            reversed_id = one.id.removesuffix(".scale") + ".reversed"
            model = fit.revised_model().without_effect(one.id).with_effect(reversed_id)
            one = _to_candidate(reversed_id, self._of.aircraft)
            fit = fit.with_model(model, last.fit.free)
            fit_to_convergence(
                fit, SEARCH.effect_passes, self._tick, f"fitting the model with: {one.title}"
            )
        number = len(fit.model.effects)
        parent = last.fit.model
        fit.model = fit.model.model_copy(
            update={"name": f"{_base_name(parent)} + {number}", "parent": parent.name}
        )
        return fit

    # --- the answer -----------------------------------------------------------------------------

    def _answer(self, stages: list[SearchStage]) -> DiscrepancyResult:
        of, settings = self._of, self._settings
        self._tick("evaluating held-out maneuvers")
        kept, held = validate_on_held_out(
            stages,
            lambda chosen: HeldOutManeuvers(
                of.records, self._held_out, [one.fit for one in chosen]
            ),
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
        self._done = 1.0
        self._tell("done")
        return found


def _base_name(model: Model) -> str:
    return model.name.partition(" + ")[0]


def _check_gain(
    last: SearchStage, fit: FilterErrorFit, one: CandidateEffect, false_alarm: float
) -> None:
    """Refuse an effect that the full fit does not bear out.

    Raise FlightError if little is left of the gain that its column promised.
    """
    promised = float(last.decision.gain[last.screening.index(one.id)])
    gained = last.fit.deviance() - fit.deviance()
    if gained < min(
        SEARCH.min_gain_share * promised,
        detection_threshold(false_alarm, last.screening.candidates),
    ):
        raise FlightError(f"{one.id}: {gained:.0f} gained in the full fit, not {promised:.0f}")


def _to_candidate(effect: str, aircraft: Aircraft) -> CandidateEffect:
    record = catalog_record(effect)
    term = create_term(effect, aircraft)
    free = [item for item in term.parameters if item.free]
    return CandidateEffect(
        id=effect,
        title=record.title,
        named=True,
        parameter=free[0].name if free else "",
        plausible_size=free[0].default - free[0].neutral if free else 1.0,
        neutral=free[0].neutral if free else 0.0,
        build_column=lambda _: None,
    )
