"""Which effect is it? Candidates compete; a name needs a margin over everything that looks alike.

Evidence is the probability of a candidate among all that compete, each with its gain in
log-likelihood and a prior: structure without a name is taken to be rarer than what the catalog
holds. Candidates whose columns look nearly alike are told apart by fitting each one fully.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from gsapp.discrepancy.candidates import CandidateEffect
from gsapp.discrepancy.settings import SEARCH
from gsapp.identification.filter_error.filter_error_fit import FilterErrorFit, InformationMatrix
from gsapp.identification.filter_error.maneuver_state import SensitivityColumn
from gsapp.identification.filter_error.motion_linearization import Linearization
from gsapp.quantities import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CandidateScreening:
    """What single candidates would gain."""

    candidates: tuple[CandidateEffect, ...]
    full_information: InformationMatrix
    projected_information: InformationMatrix
    """Before and after the model's own parameters took what they can."""
    maneuver_information: Mapping[str, InformationMatrix]  # Before that, of each maneuver.
    gain: FloatArray
    """Shape (n_competitors,). Fall of the sum of squares; 0 for a size that bounds forbid."""
    size: FloatArray
    std: FloatArray
    """Shape (n_competitors,). Difference from neutral, and its standard deviation."""

    @property
    def ranking(self) -> list[int]:
        """Return the places of the competitors, best first."""
        return [int(place) for place in np.argsort(-self.gain, kind="stable")]

    @property
    def misfit(self) -> float:
        """Return the mean square of the innovations, in units of what is believed."""
        return float(self.projected_information.matrix[-1, -1]) / max(
            self.projected_information.samples, 1.0
        )

    @property
    def gain_factor(self) -> float:
        """Return by how much gains count: less where the innovations are larger than believed."""
        return 1.0 / max(1.0, self.misfit)

    def index(self, effect: str) -> int:
        return [one.id for one in self.candidates].index(effect)

    def cosines(self, effect: str) -> FloatArray:
        """Return how alike the competitors look to one of them, -1 to 1."""
        return self.projected_information.cosines(effect)


def candidate_columns(
    competitors: Sequence[CandidateEffect], found: Linearization
) -> list[SensitivityColumn]:
    """Return the columns of competitors in one maneuver; empty where one cannot act.

    Of those tried at several sizes one column for each.
    """
    return [
        source.build_column(found) or () for one in competitors for source in (one.trials or (one,))
    ]


def column_names(candidates: Sequence[CandidateEffect]) -> tuple[str, ...]:
    """Return the names of all columns of candidates: of those tried at several sizes, each."""
    return tuple(f"{one.id}@{trial}" for one in candidates for trial in range(len(one.trials) or 1))


def compute_column_information(
    fit: FilterErrorFit, candidates: Sequence[CandidateEffect]
) -> dict[str, InformationMatrix]:
    """Return the information of each maneuver with the columns of all candidates."""
    names = column_names(candidates)
    columns = (names, lambda linearization: candidate_columns(candidates, linearization))
    return {one.record.id: fit.information_of(one, columns) for one in fit.maneuvers}


def screen_candidates(
    fit: FilterErrorFit,
    competitors: Sequence[CandidateEffect],
    nuisance: Sequence[CandidateEffect] = (),
    parts: Mapping[str, InformationMatrix] | None = None,
) -> CandidateScreening:
    """Return what single candidates would gain; the fit must have made a pass.

    `nuisance` does not compete: candidates gain what it cannot explain. `parts`: the information
    of each maneuver with these candidates, and perhaps others, where it is known.
    """
    if parts is None:
        parts = compute_column_information(fit, (*competitors, *nuisance))
    every = next(iter(parts.values())).names
    owners = [one for one in competitors for _ in (one.trials or (one,))]
    own, others = column_names(competitors), column_names(nuisance)
    wanted = {name: name for name in (*own, *others)}
    parts = {
        id_: one.renamed([name for name in every if "@" in name], wanted)
        for id_, one in parts.items()
    }
    names = tuple(wanted)
    whole = fit.sum_information(parts.values(), names).with_priors(fit.priors())
    left = whole.projected((*fit.free, *fit.bias_names(), *others))
    order = left.indices(own)
    gain, size, std = (one[order] for one in left.gains(whole))
    tried = [trial for one in competitors for trial in (one.trials or (None,))]
    for place, (one, trial) in enumerate(zip(owners, tried, strict=True)):
        low, high = (one.low, one.high) if trial is None else SEARCH.trial_share_range
        is_allowed = low <= size[place] <= high
        gain[place] = max(gain[place] - one.shape_cost, 0.0) if is_allowed else 0.0
        if trial is not None:
            # The column is the whole effect; the sizes tried are near enough to start from.
            size[place] = trial.value - one.neutral
            std[place] *= abs(size[place])
    best: dict[str, int] = {}
    for place, one in enumerate(owners):
        if one.id not in best or gain[place] > gain[best[one.id]]:
            best[one.id] = place
    chosen = {names[best[one.id]]: one.id for one in competitors}
    kept = [best[one.id] for one in competitors]
    return CandidateScreening(
        candidates=tuple(
            one
            if (trial := tried[place]) is None
            else replace(one, build_column=trial.build_column, trials=())
            for one, place in zip(competitors, kept, strict=True)
        ),
        full_information=whole.renamed(names, chosen),
        projected_information=left.renamed(names, chosen),
        maneuver_information={id_: one.renamed(names, chosen) for id_, one in parts.items()},
        gain=gain[kept],
        size=size[kept],
        std=std[kept],
    )


DecisionKind = Literal["nothing", "name", "ambiguous", "unexplained"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class EffectDecision:
    """What the competition came to."""

    kind: DecisionKind
    best: CandidateEffect | None
    """The most probable one of the catalog, or without a name where `kind` is unexplained."""
    alternatives: tuple[CandidateEffect, ...]
    """The set that these flights cannot tell apart, most probable first."""
    evidence: FloatArray
    """Shape (n_competitors,). Probabilities, in the order of the screening's competitors."""
    gain: FloatArray  # Shape (n_competitors,). Gains in the sum of squares that they rest on.
    contradicted: bool = False  # Whether maneuvers kept out speak against the best.


def detection_threshold(false_alarm: float, competitors: Sequence[CandidateEffect]) -> float:
    """Return the gain in the sum of squares that chance reaches in a share `false_alarm`.

    What has no name must gain more by its prior, and so has less of a chance.
    """
    from scipy.optimize import brentq
    from scipy.stats import chi2

    more = -2.0 * log_priors(competitors)
    if not len(more):
        return float(chi2.isf(false_alarm, 1))
    alike = float(chi2.isf(false_alarm / len(more), 1))
    return float(
        brentq(
            lambda gain: float(chi2.sf(gain + more, 1).sum()) - false_alarm,
            alike - float(more.max()) - 1.0,
            alike + 1.0,
        )
    )


def select_effect(
    screening: CandidateScreening, gain: FloatArray, *, least: float, temper: float
) -> EffectDecision:
    """Return what the competition comes to.

    Gains in the sum of squares, those of full fits put in, have the shape (n_competitors,). Below
    `least` nothing is said; `temper` is 1 where the noise model holds, less where gains are
    exaggerated.
    """
    competitors = screening.candidates
    evidence = posterior_probabilities(competitors, _discount_lag_delay(competitors, gain) * temper)
    order = np.argsort(-evidence, kind="stable")
    # What has no name must be that much clearer.
    clear = gain * temper + 2.0 * log_priors(competitors)
    if not len(order) or float(np.max(clear)) < least:
        return EffectDecision(
            kind="nothing", best=None, alternatives=(), evidence=evidence, gain=gain
        )
    best = competitors[int(order[0])]
    alternatives = _credible_set(competitors, evidence, order)
    named = sum(float(p) for one, p in zip(competitors, evidence, strict=True) if one.named)
    if named < 0.5:
        kind: DecisionKind = "unexplained"
    elif named < SEARCH.min_catalog_probability:
        kind = "unexplained"
    elif best.named and (
        best.excited and evidence[order[0]] >= SEARCH.min_effect_probability * named
    ):
        kind = "name"
    else:
        kind = "ambiguous"
        alternatives = tuple(
            sorted((one for one in alternatives if one.named), key=lambda one: not one.excited)
        )
        best = alternatives[0]
    return EffectDecision(
        kind=kind, best=best, alternatives=alternatives, evidence=evidence, gain=gain
    )


def posterior_probabilities(competitors: Sequence[CandidateEffect], gain: FloatArray) -> FloatArray:
    """Return the probability of each candidate among all, for gains in the sum of squares."""
    log = 0.5 * gain + log_priors(competitors)
    weight = np.exp(log - log.max()) if len(log) else log
    found: FloatArray = weight / weight.sum()
    return found


def _discount_lag_delay(competitors: Sequence[CandidateEffect], gain: FloatArray) -> FloatArray:
    """Return gains with those of a lag and a delay of one signal brought closer together."""
    places = {one.id: place for place, one in enumerate(competitors)}
    eased = gain.copy()
    for name, place in places.items():
        signal, _, kind = name.rpartition(".")
        other = places.get(f"{signal}.delay")
        if kind == "lag" and other is not None:
            low, high = sorted((place, other), key=lambda one: float(gain[one]))
            eased[low] = gain[high] - SEARCH.lag_delay_factor * (gain[high] - gain[low])
    return eased


def log_priors(competitors: Sequence[CandidateEffect]) -> FloatArray:
    """Return the logarithm of each candidate's prior."""
    return np.array(
        [0.0 if one.named else math.log(SEARCH.unnamed_effect_prior) for one in competitors]
    )


def _credible_set(
    competitors: Sequence[CandidateEffect], evidence: FloatArray, order: NDArray[np.intp]
) -> tuple[CandidateEffect, ...]:
    total, chosen = 0.0, []
    for place in order:
        chosen.append(competitors[int(place)])
        total += float(evidence[int(place)])
        if total >= SEARCH.credible_set_mass:
            break
    return tuple(chosen)
