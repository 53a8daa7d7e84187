"""Cases put to the program; answers kept by case, as long as program and cases stay the same.

How much was closed of the gap that could be closed is judged by the truth. The floor is what a
perfect answer would leave: the baseline with the effects that are hidden, at their true sizes,
fitted and held against the maneuvers kept out in the same way. Sums of squares of whitened
innovations under the baseline, the program's last model and the perfect one are compared: what
noise, gusts and estimated derivatives leave is in all three of them.
"""

from __future__ import annotations

import hashlib
import json
import os
import time
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import gsapp
from gsapp.discrepancy.held_out_maneuvers import HeldOutManeuvers
from gsapp.discrepancy.investigation import Investigation
from gsapp.discrepancy.settings import DiscrepancySettings
from gsapp.dynamics.terms import create_term
from gsapp.foundation import GroundStationError
from gsapp.identification.filter_error.noise_tuning import fit_to_convergence
from tests.discrepancy.blind.cases import WHOLE, Case
from tests.discrepancy.blind.flying import FlownCase, fly_case
from tests.discrepancy.blind.judging import Named, Outcome, outcome_of
from tests.discrepancy.blind.sensitivity import with_sizes

if TYPE_CHECKING:
    from gsapp.discrepancy.results import DiscrepancyResult
    from gsapp.dynamics.model import Model
    from gsapp.identification.filter_error.filter_error_fit import FilterErrorFit

VISIBLE = 10.0
"""Reducible sum of squares below which maneuvers kept out show no gap: three sigmas of chance."""
_PASSES = 4


def closed_gap(search: Investigation, flown: FlownCase, found: DiscrepancyResult) -> float | None:
    """Return the share of the reducible gap that an answer closes on maneuvers kept out.

    None where nothing is hidden that the catalog can express, or where even the perfect model
    leaves these maneuvers as they are.
    """
    if not flown.effects or any(one.startswith("outside.") for one in flown.effects):
        return None
    baseline = search.baseline(found.gap.on, lambda _: None)
    perfect = baseline.revised_model()
    for effect, size in flown.effects.items():
        perfect = perfect.with_effect(effect, _parameters(search, effect, size))
    free = {f"{one.effect}.{name}" for one in found.effects for name in one.parameters}
    fits = [
        baseline,
        _fitted(baseline, found.steps[-1].model, free) if found.effects else baseline,
        _fitted(baseline, perfect, set()),
    ]
    held = HeldOutManeuvers(search.records, found.gap.on, fits)
    reducible = 2.0 * held.gain(0, 2)
    return 2.0 * held.gain(0, 1) / reducible if reducible > VISIBLE else None


def _parameters(search: Investigation, effect: str, size: float) -> dict[str, float]:
    if effect.endswith(WHOLE):
        return {}
    term = create_term(effect, search.aircraft)
    own = next(item.name for item in term.parameters if item.free)
    return {**term.defaults, own: size}


def _fitted(baseline: FilterErrorFit, model: Model, more: set[str]) -> FilterErrorFit:
    fit = baseline.with_model(model, (*baseline.free, *sorted(more)))
    fit_to_convergence(fit, _PASSES, lambda _: None, "", fresh=True)
    return fit


ROOT = Path(gsapp.__file__).parents[1]


def fingerprint() -> str:
    digest = hashlib.sha256()
    folders = [ROOT / "gsapp" / one for one in ("discrepancy", "dynamics", "identification")]
    for folder in (*folders, Path(__file__).parent):
        for path in sorted(folder.rglob("*.py")):
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def answer(case: Case) -> Outcome:
    sized = with_sizes(case)
    flown = fly_case(sized)
    started = time.process_time()
    try:
        search = Investigation(flown.maneuvers, flown.aircraft, flown.model)
        found = search.run(DiscrepancySettings())
    except (GroundStationError, ValueError, ArithmeticError, np.linalg.LinAlgError) as error:
        spent = time.process_time() - started
        text = f"{type(error).__name__}: {error}"
        return Outcome(id=case.id, verdict="failed", cpu=spent, error=text)
    spent = time.process_time() - started
    return outcome_of(sized, found, closed=closed_gap(search, flown, found), cpu=spent)


def read(path: Path) -> Outcome:
    content = json.loads(path.read_text("utf-8"))
    content["named"] = tuple(Named(**one) for one in content["named"])
    for name in ("ranking", "values"):
        content[name] = tuple(content[name])
    content["open"] = tuple(tuple(one) for one in content["open"])
    return Outcome(**content)


def kept(case: Case, folder: Path) -> Outcome:
    path = folder / f"{case.id}.json"
    if path.exists():
        return read(path)
    found = answer(case)
    waiting = path.with_suffix(f".{os.getpid()}")
    waiting.write_text(json.dumps(asdict(found)), "utf-8")
    waiting.replace(path)
    return found
