"""A model with one effect more, fitted fully: of a leading few, and of the one that is added."""

from __future__ import annotations

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.discrepancy.candidates import CandidateEffect
from gsapp.discrepancy.effect_catalog import find_effect as catalog_record
from gsapp.discrepancy.effect_selection import (
    CandidateScreening,
    EffectDecision,
    detection_threshold,
    select_effect,
)
from gsapp.discrepancy.search_stages import SearchStage, fit_from_record
from gsapp.discrepancy.settings import SEARCH
from gsapp.dynamics.model import Model
from gsapp.dynamics.terms import create_term
from gsapp.foundation import FlightError
from gsapp.identification.filter_error.filter_error_fit import FilterErrorFit
from gsapp.identification.filter_error.noise_tuning import ActivityCallback, fit_to_convergence


class EffectFitter:
    """Fits effects beside what a model has; what a competition fitted is not fitted again."""

    def __init__(self, aircraft: Aircraft, false_alarm: float, tick: ActivityCallback) -> None:
        self._aircraft, self._false_alarm, self._tick = aircraft, false_alarm, tick
        self._trials: dict[str, FilterErrorFit] = {}
        self._tried_fit: FilterErrorFit | None = None

    def contest(
        self,
        fit: FilterErrorFit,
        screening: CandidateScreening,
        decision: EffectDecision,
        least: float,
    ) -> EffectDecision:
        """Fit those fully that come near the best, and decide again."""
        best = float(screening.gain.max())
        near = [
            index
            for index in screening.ranking
            if screening.candidates[index].named
            and screening.gain[index] > best - SEARCH.max_contender_gap
        ][: SEARCH.max_contenders]
        proven = [index for index in screening.ranking if screening.candidates[index].proven]
        near += [index for index in proven if index not in near]
        if len(near) < 2 and not proven:
            return decision
        gain = screening.gain.copy()
        costs: dict[int, float] = {}
        for index in near:
            one = screening.candidates[index]
            try:
                trial = self.trial(fit, one, screening)
            except FlightError:
                gain[index] = 0.0
                continue
            if _is_neutral(trial, one):
                gain[index] = 0.0
                continue
            costs[index] = trial.deviance() + one.shape_cost
        temper = screening.gain_factor
        if not costs:
            return select_effect(screening, gain, least=least, temper=temper)
        # The best fit keeps its gain by columns; the others differ from it as their fits do.
        best_fit = min(costs, key=lambda index: costs[index])
        for index, cost in costs.items():
            gain[index] = screening.gain[best_fit] - (cost - costs[best_fit])
        if best_fit in proven:
            gain[best_fit] = max(gain[best_fit], fit.deviance() - costs[best_fit])
        return select_effect(screening, np.maximum(gain, 0.0), least=least, temper=temper)

    def trial(
        self, fit: FilterErrorFit, one: CandidateEffect, screening: CandidateScreening
    ) -> FilterErrorFit:
        """Return a fit with a competitor added; the same is not fitted twice.

        Raise FlightError if it runs away.
        """
        if fit is not self._tried_fit:
            self._trials.clear()
            self._tried_fit = fit
        if one.id not in self._trials:
            self._trials[one.id] = self.fitted(fit, one, screening, f"comparing: {one.title}")
        return self._trials[one.id]

    def fit_with(
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
        one = competitor or _to_candidate(effect, self._aircraft)
        fit = self._trials.pop(effect, None) or self.fitted(
            last.fit,
            one,
            last.screening if competitor else None,
            f"fitting the model with: {one.title}",
        )
        self._trials.clear()
        if competitor and not forced:
            check_gain(last, fit, competitor, self._false_alarm)
        if (
            one.id.startswith("sensor.")
            and one.id.endswith(".scale")
            and abs(fit.values[f"{one.id}.scale"] + 1.0) < SEARCH.reversal_tolerance
        ):
            reversed_id = one.id.removesuffix(".scale") + ".reversed"
            model = fit.revised_model().without_effect(one.id).with_effect(reversed_id)
            one = _to_candidate(reversed_id, self._aircraft)
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

    def fitted(
        self,
        fit: FilterErrorFit,
        one: CandidateEffect,
        screening: CandidateScreening | None,
        doing: str,
    ) -> FilterErrorFit:
        term = create_term(one.id, self._aircraft)
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


def check_gain(
    last: SearchStage, fit: FilterErrorFit, one: CandidateEffect, false_alarm: float
) -> None:
    """Refuse an effect that the full fit does not bear out.

    Raise FlightError if little is left of its size, or of the gain that its column promised.
    """
    if _is_neutral(fit, one):
        raise FlightError(f"{one.id}: its size vanishes in the full fit")
    promised = last.gain_of(one.id)
    gained = last.deviance() - fit.deviance()
    if gained < min(
        SEARCH.min_gain_share * promised,
        detection_threshold(false_alarm, last.screening.candidates),
    ):
        raise FlightError(f"{one.id}: {gained:.0f} gained in the full fit, not {promised:.0f}")


def _is_neutral(fit: FilterErrorFit, one: CandidateEffect) -> bool:
    """Return whether a fit has put an effect where it does nothing: on the bound of its size."""
    return fit.values.get(f"{one.id}.{one.parameter}") == one.neutral


def _base_name(model: Model) -> str:
    return model.name.partition(" + ")[0]


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
