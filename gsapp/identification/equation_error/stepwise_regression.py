"""Which terms a coefficient needs: forward and backward, by what the data can prove.

The pool holds the linear terms, the effects of the catalog that enter this coefficient, and
squares and products without a name (``unnamed.Cm.alpha_q``). Each round takes the candidate
that explains most of what is left. It stays if its partial F, with the bound that believes in
colored residuals, is large enough and stretches of the record that were left out are predicted
better with it (PRESS, stretch by stretch: neighboring samples are no witnesses of their own).
A term that later ones have made superfluous goes again.

Where the flights go beyond the linear range of angles of attack, the stall competes in the shape
that fits best beside the linear terms; its F is for all of its parameters together.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement
from typing import Literal

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.dynamics.buildup import create_linear_terms, linear_variables
from gsapp.dynamics.effect_terms import StallTerm
from gsapp.dynamics.effects.unnamed_terms import product_id
from gsapp.dynamics.model import Model
from gsapp.dynamics.terms import Monomial, Parameter, Term, create_term, effect_ids
from gsapp.foundation import FlightError
from gsapp.identification.coefficients import Coefficients, smooth_coefficients
from gsapp.identification.equation_error.equations import (
    DRIFT_PREFIX,
    FORCE_COEFFICIENTS,
    maneuver_offset_columns,
)
from gsapp.identification.equation_error.regression import (
    EQUATION_ERROR,
    Equation,
    ManeuverRows,
    solve_equation,
)
from gsapp.identification.equation_error.stall_regression import fit_stall_shape
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.motion import MeasuredMotion
from gsapp.identification.smoothing import BoolArray, contiguous_slices
from gsapp.quantities import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class StepwiseStep:
    """One change of the set of terms."""

    action: Literal["added", "removed", "refused"]
    term: str  # A derivative or an effect id.
    partial_f: float
    r2: float  # Of the whole fit after the step.
    press: float  # Predicted sum of squares over that of a fit of the mean, after the step.
    equivalent_terms: tuple[str, ...]  # Candidates that would have served about as well.
    why: str  # In words.


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TermSelection:
    """The terms that the data prove for one coefficient."""

    coefficient: str
    values: Mapping[str, tuple[float, float]]  # Chosen terms, bias first: value and honest bound.
    steps: tuple[StepwiseStep, ...]  # How it came to them.
    unexcited: tuple[str, ...]
    """Candidates that these maneuvers cannot show: their variables hardly change, or too little."""
    r2: float
    shapes: Mapping[str, Mapping[str, float]]
    """Of chosen terms that are not linear in all of their parameters: the others, as fitted."""

    @property
    def beyond_linear(self) -> tuple[str, ...]:
        return tuple(name for name in self.values if "." in name)

    @property
    def slopes(self) -> dict[str, tuple[float, float]]:
        """Values that tell a stable aircraft from an unstable one.

        Beside other terms in alpha, that of alpha is the slope at zero only, far from flight.
        """
        is_bent = any("alpha" in name or name.endswith(".stall") for name in self.beyond_linear)
        return {
            name: value
            for name, value in self.values.items()
            if not (is_bent and name.endswith("_alpha"))
        }


def candidate_terms(coefficient: str, aircraft: Aircraft) -> dict[str, Term]:
    """Return the candidates by name: linear terms, effects of the catalog, unnamed products.

    Only terms that are one free parameter times something measured; the linear ones of the
    coefficient are called as their derivatives.
    """
    pool: dict[str, Term] = {}
    seen: set[tuple[tuple[str, int], ...]] = set()
    for variable, name in zip(
        linear_variables(coefficient).values(), _linear_names(coefficient), strict=True
    ):
        pool[name] = _linear_term(name, coefficient, variable)
        seen.add(((variable, 1),))
    for term_id in effect_ids():
        group, target, *_ = term_id.split(".")
        if group not in ("aero", "propulsion") or target != coefficient:
            continue
        term = create_term(term_id, aircraft)
        if term.states or sum(parameter.free for parameter in term.parameters) != 1:
            continue
        pool[term_id] = term
        if isinstance(term, Monomial):
            seen.add(tuple(sorted(zip(term.reads, term.powers, strict=True))))
    factors = dict.fromkeys((*linear_variables(coefficient).values(), "alpha", "beta"))
    for one, two in combinations_with_replacement(factors, 2):
        powers = ((one, 2),) if one == two else tuple(sorted(((one, 1), (two, 1))))
        if powers in seen:
            continue
        name = product_id(coefficient, one, two)
        pool[name] = create_term(name, aircraft)
    return pool


def select_terms(
    maneuvers: Sequence[Maneuver],
    coefficient: str,
    *,
    pool: Mapping[str, Term] | None = None,
    keep_linear: bool = True,
    model: Model | None = None,
    motions: Sequence[MeasuredMotion] | None = None,
    delays: Mapping[str, float] | None = None,
    most_terms: int | None = None,
) -> TermSelection:
    """Choose the terms of one coefficient.

    Parameters
    ----------
    coefficient : str
        CN, CA, CY, Cl, Cm, Cn.
    pool : mapping of str to Term, optional
        Candidates; by default `candidate_terms`.
    keep_linear : bool
        Whether the linear terms that are excited stand from the start and stay, so that a missing
        effect is not taken for one of them.
    model : Model, optional
        Its effects are taken as known.
    motions, delays
        As in `gsapp.identification.equation_error.estimator`.
    most_terms : int, optional
        Beyond those from the start; by default as many as are proven.

    Raises
    ------
    FlightError
        If the coefficient cannot be had from these maneuvers.
    """
    found = smooth_coefficients(maneuvers, model=model, motions=motions, delays=delays)
    used = [one for one in found if coefficient not in one.missing]
    if not used:
        raise FlightError(
            f"{coefficient} cannot be estimated from these maneuvers: "
            f"{found[0].missing[coefficient]}"
        )
    aircraft = maneuvers[0].aircraft
    candidates = dict(candidate_terms(coefficient, aircraft) if pool is None else pool)
    unexcited = []
    stall = _stall_term(coefficient, aircraft) if pool is None else None
    if stall is not None and not any(
        one.id == stall.id for one in (model.effects if model else ())
    ):
        shape = fit_stall_shape(stall, used, aircraft.limits.alpha_linear[1])
        if shape is None:
            unexcited.append(stall.id)
        else:
            candidates[stall.id] = stall.with_shape(shape.values)
    table = _RegressorTable(coefficient, candidates, used, unexcited)
    linear = [name for name in _linear_names(coefficient) if name in table.columns]
    search = _StepwiseSearch(table, linear if keep_linear else [])
    search.run(most_terms)
    return search.result()


def _stall_term(coefficient: str, aircraft: Aircraft) -> StallTerm | None:
    term_id = f"aero.{coefficient}.stall"
    term = create_term(term_id, aircraft) if term_id in effect_ids() else None
    return term if isinstance(term, StallTerm) else None


def _linear_names(coefficient: str) -> tuple[str, ...]:
    terms = {term.target: term for term in create_linear_terms()}
    return tuple(parameter.name for parameter in terms[coefficient].parameters[1:])


def _linear_term(name: str, coefficient: str, variable: str) -> Monomial:
    return Monomial(
        id=name,
        title=f"{coefficient} from {variable}",
        equation=f"{coefficient} += {name} {variable}",
        target=coefficient,
        reads=(variable,),
        powers=(1,),
        parameters=(
            Parameter(
                name=name,
                unit="",
                default=1.0,
                bounds=(-1e6, 1e6),
                description="size of the term, angles in radians",
            ),
        ),
    )


class _RegressorTable:
    """The smoothed coefficient and what each candidate would add to it, row by row."""

    def __init__(
        self,
        coefficient: str,
        pool: Mapping[str, Term],
        used: Sequence[Coefficients],
        unexcited: Sequence[str],
    ) -> None:
        self.coefficient = coefficient
        stride = used[0].smoother.stride
        self.stride, self.dt = stride, stride * used[0].smoother.dt
        pool = {name: term for name, term in pool.items() if _is_measured(term, used)}
        ys: list[FloatArray] = []
        rows: list[FloatArray] = []
        stretches: list[ManeuverRows] = []
        at = 0
        for one in used:
            columns = one.smooth(
                np.column_stack([_term_column(term, one) for term in pool.values()])
            )
            good = one.valid_samples(coefficient)
            for mask in _masks(pool.values(), one):
                good = good & mask
            segments = []
            size = 0
            for part in contiguous_slices(good):
                taken = slice(part.start, part.stop, stride)
                ys.append(one.values[taken, one.column(coefficient)])
                rows.append(columns[taken])
                segments.append(slice(size, size + ys[-1].size))
                size += ys[-1].size
            if size:
                stretches.append(ManeuverRows(rows=slice(at, at + size), segments=tuple(segments)))
            at += size
        if not at:
            raise FlightError(
                f"{coefficient} cannot be estimated from these maneuvers: no stretch is long "
                "enough between missing and clipped samples"
            )
        self.y = np.concatenate(ys)
        reads = linear_variables(coefficient)
        self._linear = _linear_names(coefficient)
        self._offsets = (
            maneuver_offset_columns(stretches)
            if coefficient in FORCE_COEFFICIENTS
            else np.empty((at, 0))
        )
        # White noise of the linear regressors is taken out, the mean over the maneuvers.
        self._noise = np.mean([one.noise(tuple(reads.values())) for one in used], axis=0)
        self.stretches = tuple(stretches)
        table = np.concatenate(rows)
        moved = table.std(axis=0) > 1e-3 * np.maximum(np.abs(table).max(axis=0), 1e-12)
        self.columns = {name: table[:, index] for index, name in enumerate(pool) if moved[index]}
        self.unexcited = (
            *unexcited,
            *(name for index, name in enumerate(pool) if not moved[index]),
        )
        self.shapes = {
            name: {one: term.defaults[one] for one in term.shared_parameters}
            for name, term in pool.items()
            if term.shared_parameters
        }

    def equation(self, names: Sequence[str]) -> Equation:
        spare = [f"{DRIFT_PREFIX}{index}" for index in range(self._offsets.shape[1])]
        X = np.column_stack(
            [np.ones(self.y.size), *(self.columns[name] for name in names), self._offsets]
        )
        noise = np.zeros((X.shape[1], X.shape[1]))
        linear = [name for name in names if name in self._linear]
        places = [1 + names.index(name) for name in linear]
        rows = [self._linear.index(name) for name in linear]
        noise[np.ix_(places, places)] = self._noise[np.ix_(rows, rows)]
        return Equation(
            y=self.y,
            X=X,
            Z=X,
            names=(f"{self.coefficient}_0", *names, *spare),
            maneuver_rows=self.stretches,
            dt=self.dt,
            stride=self.stride,
            noise=noise,
        )


def _is_measured(term: Term, used: Sequence[Coefficients]) -> bool:
    for variable in term.reads:
        channel = variable.split("_")[0] if variable.endswith("_hat") else variable
        if channel in ("qbar", "thrust"):
            continue
        if not all(channel in one.measured for one in used):
            return False
    return True


def _term_column(term: Term, one: Coefficients) -> FloatArray:
    free = next(index for index, item in enumerate(term.parameters) if item.free)
    reads = [one.variables[name] for name in term.reads]
    values = tuple(term.defaults.values())
    states = term.states_along(reads, values, one.smoother.dt) if term.states else ()
    slopes = term.jacobian(reads, states, values).parameters
    return np.broadcast_to(np.asarray(slopes[free], dtype=np.float64), one.times.shape)


def _masks(terms: Iterable[Term], one: Coefficients) -> list[BoolArray]:
    names = {name for term in terms for name in term.reads}
    return [one.variable_valid[name] for name in sorted(names) if name in one.variable_valid]


class _StepwiseSearch:
    """Forward selection with backward elimination."""

    def __init__(self, table: _RegressorTable, kept: Sequence[str]) -> None:
        self._table = table
        self._kept = tuple(kept)
        self._chosen = list(kept)
        self._refused: set[str] = set()
        self._steps: list[StepwiseStep] = []
        about = table.y - table.y.mean()
        self._total = max(float(about @ about), 1e-300)
        self._press = self._predicted(self._chosen)

    def run(self, most_terms: int | None = None) -> None:
        for _ in range(len(self._table.columns) if most_terms is None else most_terms):
            if not self._forward():
                break
            self._backward()

    def result(self) -> TermSelection:
        solution = solve_equation(self._table.equation(self._chosen))
        values = {
            name: (float(value), float(std))
            for name, value, std in zip(solution.names, solution.values, solution.std, strict=True)
            if not name.startswith(DRIFT_PREFIX)
        }
        return TermSelection(
            coefficient=self._table.coefficient,
            values=values,
            steps=tuple(self._steps),
            unexcited=self._table.unexcited,
            r2=self._r2(self._chosen),
            shapes={
                name: shape for name, shape in self._table.shapes.items() if name in self._chosen
            },
        )

    def _forward(self) -> bool:
        table = self._table
        names = [
            name for name in table.columns if name not in self._chosen and name not in self._refused
        ]
        if not names:
            return False
        basis = np.linalg.qr(table.equation(self._chosen).X)[0]
        left = table.y - basis @ (basis.T @ table.y)
        raw = np.column_stack([table.columns[name] for name in names])
        new = raw - basis @ (basis.T @ raw)
        size = np.linalg.norm(new, axis=0)
        # What others explain all but a millionth of is no candidate.
        usable = size > 1e-3 * np.linalg.norm(raw, axis=0)
        new /= np.where(usable, size, 1.0)
        worth = np.where(usable, np.abs(new.T @ left), 0.0)
        places = np.argsort(-worth)[: EQUATION_ERROR.max_candidates].tolist()
        if any(self._parameter_count(names[place]) > 1 for place in places):
            # By the sum of squares whatever has more parameters would win.
            ratios = {
                place: self._partial_f([*self._chosen, names[place]])[names[place]]
                for place in places
            }
            places.sort(key=lambda place: -ratios[place])
        for place in places:
            if worth[place] <= 0.0:
                return False
            name = names[place]
            alike = tuple(
                names[other]
                for other in np.flatnonzero(
                    usable & (np.abs(new.T @ new[:, place]) > EQUATION_ERROR.max_cosine)
                ).tolist()
                if other != place
            )
            if self._try(name, alike):
                return True
        return False

    def _try(self, name: str, alike: tuple[str, ...]) -> bool:
        wanted = [*self._chosen, name]
        partial = self._partial_f(wanted)[name]
        press = self._predicted(wanted)
        if partial >= EQUATION_ERROR.f_to_enter and press < self._press:
            why = (
                f"partial F {partial:.0f}, held-out prediction improves by "
                f"{100.0 * (1.0 - press / self._press):.1f} %"
            )
            self._chosen, self._press = wanted, press
            self._note("added", name, partial, alike, why)
            return True
        why = (
            f"partial F {partial:.1f} is less than {EQUATION_ERROR.f_to_enter:.0f}"
            if partial < EQUATION_ERROR.f_to_enter
            else "held-out prediction does not improve"
        )
        self._refused.add(name)
        self._note("refused", name, partial, alike, why)
        return False

    def _backward(self) -> None:
        while True:
            free = [name for name in self._chosen if name not in self._kept]
            partial = self._partial_f(self._chosen)
            weakest = min(free, key=lambda name: partial[name])
            if partial[weakest] >= EQUATION_ERROR.f_to_remove:
                return
            self._chosen.remove(weakest)
            self._refused.add(weakest)
            self._press = self._predicted(self._chosen)
            why = f"partial F fell to {partial[weakest]:.1f} as later terms explain the same"
            self._note("removed", weakest, partial[weakest], (), why)
            if not [name for name in self._chosen if name not in self._kept]:
                return

    def _partial_f(self, names: Sequence[str]) -> dict[str, float]:
        """Return (value / honest bound)^2 of every term over the number of its parameters."""
        solution = solve_equation(self._table.equation(names))
        values = (solution.values / np.maximum(solution.std, 1e-300)) ** 2
        return {
            name: float(value) / self._parameter_count(name)
            for name, value in zip(names, values[1:], strict=False)
        }

    def _parameter_count(self, name: str) -> int:
        return 1 + len(self._table.shapes.get(name, ()))

    def _note(
        self,
        action: Literal["added", "removed", "refused"],
        name: str,
        partial: float,
        alike: tuple[str, ...],
        why: str,
    ) -> None:
        self._steps.append(
            StepwiseStep(
                action=action,
                term=name,
                partial_f=float(partial),
                r2=self._r2(self._chosen),
                press=self._press,
                equivalent_terms=alike,
                why=why,
            )
        )

    def _r2(self, names: Sequence[str]) -> float:
        basis = np.linalg.qr(self._table.equation(names).X)[0]
        left = self._table.y - basis @ (basis.T @ self._table.y)
        return 1.0 - float(left @ left) / self._total

    def _predicted(self, names: Sequence[str]) -> float:
        """Return the squares of predictions of stretches left out, over those about the mean."""
        y = self._table.y
        basis = np.linalg.qr(self._table.equation(names).X)[0]
        left = y - basis @ (basis.T @ y)
        width = max(2, round(EQUATION_ERROR.press_segment_duration / self._table.dt))
        total = 0.0
        for start in range(0, y.size, width):
            part = slice(start, min(start + width, y.size))
            inner = np.eye(part.stop - part.start) - basis[part] @ basis[part].T
            miss = np.linalg.lstsq(inner, left[part], rcond=1e-8)[0]
            total += float(miss @ miss)
        return total / self._total
