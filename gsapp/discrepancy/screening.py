"""All candidates against the residual at once: what each would gain, and how alike they look."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gsapp.discrepancy.candidates import CandidateEffect
from gsapp.identification.filter_error.filter_error_fit import FilterErrorFit
from gsapp.identification.filter_error.information_matrix import InformationMatrix
from gsapp.identification.filter_error.motion_linearization import Linearization
from gsapp.identification.filter_error.sensitivity_columns import SensitivityColumn
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
    """Return the columns of competitors in one maneuver; empty where one cannot act."""
    return [one.build_column(found) or () for one in competitors]


def screen_candidates(
    fit: FilterErrorFit, competitors: Sequence[CandidateEffect]
) -> CandidateScreening:
    """Return what single candidates would gain; the fit must have made a pass."""
    names = tuple(one.id for one in competitors)
    columns = (names, lambda linearization: candidate_columns(competitors, linearization))
    parts = {one.record.id: fit.information_of(one, columns) for one in fit.maneuvers}
    whole = fit.sum_information(parts.values(), names).with_priors(fit.priors())
    left = whole.projected((*fit.free, *fit.bias_names()))
    order = left.indices(names)
    gain, size, std = (one[order] for one in left.gains(whole))
    allowed = np.array(
        [one.low <= step <= one.high for one, step in zip(competitors, size, strict=True)]
    )
    return CandidateScreening(
        candidates=tuple(competitors),
        full_information=whole,
        projected_information=left,
        maneuver_information=parts,
        gain=np.where(allowed, gain, 0.0),
        size=size,
        std=std,
    )
