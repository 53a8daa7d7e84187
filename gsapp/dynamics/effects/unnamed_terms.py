"""Terms for structure that the catalog has no name for: ``unnamed.<coefficient>.<structure>``.

``unnamed.Cm.alpha_de2`` is a product of powers, ``unnamed.CA.absbeta`` a kink at zero,
``unnamed.Cn.late_q`` follows a variable with one lag, ``unnamed.Cm.table_alpha_q`` is a table. The
id says all, so that a model file can hold what was found and is not understood.
"""

# ruff: noqa: ARG002 - overridden methods, which use their arguments or not

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement
from math import prod

from gsapp.dynamics.arithmetic import Value, where
from gsapp.dynamics.buildup import LATERAL_COEFFICIENTS
from gsapp.dynamics.effect_terms import UnsteadyTerm
from gsapp.dynamics.effects.effect_registration import V_REF
from gsapp.dynamics.effects.tables import NODES, create_table_term
from gsapp.dynamics.terms import (
    COEFFICIENTS,
    Parameter,
    Term,
    TermJacobian,
    Values,
    register_described_terms,
)

PREFIX = "unnamed."
REFERENCE_SPEED = V_REF.default  # m/s: where products with speed are zero.
LAG_TIME = 0.15  # Time constant of what follows late, s.
_BOUND = 1e6
_TABLE = "table_"
_LONGITUDINAL = ("alpha", "q", "de", "V")
LATERAL_VARIABLES = ("beta", "p", "r", "da", "dr")
_INPUTS = ("throttle", "flap")
_CUBIC = (
    "alpha3", "alpha2_q", "alpha2_de", "alpha_de2", "de3", "alpha_beta2", "alpha_q_de",
)  # fmt: skip
_FACTOR = re.compile(
    rf"(abs)?({'|'.join((*_LONGITUDINAL, *LATERAL_VARIABLES, *_INPUTS))})([23])?", re.ASCII
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Factor:
    """A power of a variable, of its absolute value, or of speed over its reference less 1."""

    variable: str
    power: int
    absolute: bool

    def value(self, x: Value) -> Value:
        if self.variable == "V":
            x = x / REFERENCE_SPEED - 1.0
        if self.absolute:
            x = x * _sign(x)
        found: Value = x**self.power
        return found

    def slope(self, x: Value) -> Value:
        scale: Value = 1.0
        if self.variable == "V":
            x, scale = x / REFERENCE_SPEED - 1.0, 1.0 / REFERENCE_SPEED
        if self.absolute:
            scale = scale * _sign(x)
            x = x * _sign(x)
        found: Value = scale * self.power * x ** (self.power - 1)
        return found


def _sign(x: Value) -> Value:
    return where(x < 0.0, -1.0, 1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class ProductTerm(Term):
    """One parameter times a product of factors."""

    factors: tuple[Factor, ...]  # One for each variable read.

    def value(self, reads: Values, states: Values, parameters: Values) -> Value:
        return parameters[0] * self._product(reads)

    def jacobian(self, reads: Values, states: Values, parameters: Values) -> TermJacobian:
        values = [one.value(x) for one, x in zip(self.factors, reads, strict=True)]
        slopes = [one.slope(x) for one, x in zip(self.factors, reads, strict=True)]
        return TermJacobian(
            reads=tuple(
                parameters[0] * slope * prod(values[:k] + values[k + 1 :])
                for k, slope in enumerate(slopes)
            ),
            parameters=(self._product(reads),),
        )

    def _product(self, reads: Values) -> Value:
        return prod(one.value(x) for one, x in zip(self.factors, reads, strict=True))


@dataclass(frozen=True, slots=True, kw_only=True)
class LaggedTerm(UnsteadyTerm):
    """What follows a variable with one lag, and has nothing of its present value."""

    def value(self, reads: Values, states: Values, parameters: Values) -> Value:
        return parameters[0] * states[0]

    def jacobian(self, reads: Values, states: Values, parameters: Values) -> TermJacobian:
        rates = UnsteadyTerm.jacobian(self, reads, states, parameters)
        return rates._replace(
            reads=(0.0,), states=(parameters[0],), parameters=(1.0 * states[0], 0.0)
        )


def is_unnamed(term_id: str) -> bool:
    """Return whether an id is of structure without a name that a model can hold."""
    return _parse(term_id) is not None


def static_variables(term_id: str) -> tuple[str, ...]:
    """Return the variables of a product, as a term reads them; none where it follows late."""
    found = _parse(term_id)
    return tuple(_read(one.variable) for one in found[2]) if found else ()


def table_id(target: str, variables: Sequence[str]) -> str:
    """Return the id of a table of a coefficient over variables, as a term reads them."""
    return f"{PREFIX}{target}.{_TABLE}{'_'.join(one.removesuffix('_hat') for one in variables)}"


def create_unnamed_term(term_id: str) -> Term | None:
    """Return the term that an id describes; None if it describes none."""
    found = _parse(term_id)
    if found is None:
        return None
    target, structure, factors = found
    if structure.startswith(_TABLE):
        variables = [one.variable for one in factors]
        return create_table_term(term_id, target, variables, [_read(one) for one in variables])
    size = Parameter(
        name=f"{target}_{structure}",
        unit="",
        default=1.0,
        bounds=(-_BOUND, _BOUND),
        description="size; no typical value",
    )
    if factors:
        return ProductTerm(
            id=term_id,
            title=f"{target} needs {' * '.join(_words(one) for one in factors)}",
            equation=f"{target} += {size.name} * {' * '.join(_formula(one) for one in factors)}",
            target=target,
            reads=tuple(_read(one.variable) for one in factors),
            parameters=(size,),
            factors=factors,
        )
    variable = structure.removeprefix("late_")
    own_axes = (variable in LATERAL_VARIABLES) == (target in LATERAL_COEFFICIENTS)
    lag = Parameter(
        name="lag", unit="s", default=LAG_TIME, bounds=(0.01, 2.0), free=False, neutral=LAG_TIME,
        description="time constant",
    )  # fmt: skip
    # What a coefficient's own variable adds late, it has had at once in the linear build-up.
    late = f"({variable} - late {variable})" if own_axes else f"late {variable}"
    return (UnsteadyTerm if own_axes else LaggedTerm)(
        id=term_id,
        title=f"{target} follows {variable} late",
        equation=f"{target} += {size.name} * {late}, lag {LAG_TIME:g} s",
        target=target,
        reads=(_read(variable),),
        parameters=(size, lag),
        states=(f"late_{variable}",),
    )


def unnamed_ids(*, throttle: bool, flap: bool) -> tuple[str, ...]:
    """Return the ids of products and lags of all coefficients, of inputs that moved."""
    inputs = tuple(name for name, moved in zip(_INPUTS, (throttle, flap), strict=True) if moved)
    found = []
    for target in COEFFICIENTS:
        lateral = target in LATERAL_COEFFICIENTS
        names = _lateral_structures(inputs) if lateral else _longitudinal_structures(inputs)
        late = (
            ("beta", "da", "dr", "alpha", "q", "de")
            if lateral
            else ("alpha", "de", *LATERAL_VARIABLES)
        )
        found += [f"{PREFIX}{target}.{name}" for name in names]
        found += [f"{PREFIX}{target}.late_{name}" for name in late]
    return tuple(found)


def product_id(target: str, *variables: str) -> str:
    """Return the id of a product of two variables of the equations, as `unnamed_ids` writes it."""
    lateral = target in LATERAL_COEFFICIENTS
    order = (
        (*LATERAL_VARIABLES, *_LONGITUDINAL) if lateral else (*_LONGITUDINAL, *LATERAL_VARIABLES)
    )
    names = sorted((one.removesuffix("_hat") for one in variables), key=order.index)
    structure = f"{names[0]}2" if names[0] == names[1] else "_".join(names)
    return f"{PREFIX}{target}.{structure}"


def _lateral_structures(inputs: Sequence[str]) -> list[str]:
    names = [f"{one}_{other}" for one in LATERAL_VARIABLES for other in (*_LONGITUDINAL, *inputs)]
    names += [f"{one}3" for one in LATERAL_VARIABLES]
    names += [f"alpha2_{one}" for one in LATERAL_VARIABLES]
    names += [f"beta2_{one}" for one in LATERAL_VARIABLES[1:]]
    names += [f"absbeta_{one}" for one in LATERAL_VARIABLES]
    return [*names, *(f"abs{one}_{one}" for one in LATERAL_VARIABLES[1:])]


def _longitudinal_structures(inputs: Sequence[str]) -> list[str]:
    names = [
        f"{one}2" if one == other else f"{one}_{other}"
        for group in (_LONGITUDINAL, LATERAL_VARIABLES)
        for one, other in combinations_with_replacement(group, 2)
    ]
    names += ["absbeta", "absq_q", "absde_de", *_CUBIC]
    return [*names, *(f"{one}_{other}" for one in inputs for other in _LONGITUDINAL)]


def _parse(term_id: str) -> tuple[str, str, tuple[Factor, ...]] | None:
    """Return coefficient, structure and factors (none of what is late) of an id."""
    _, _, rest = term_id.partition(PREFIX)
    target, _, structure = rest.partition(".")
    if not term_id.startswith(PREFIX) or target not in COEFFICIENTS:
        return None
    late = structure.removeprefix("late_")
    if late != structure:
        known = late in (*_LONGITUDINAL[:3], *LATERAL_VARIABLES)
        return (target, structure, ()) if known else None
    factors = []
    table = structure.startswith(_TABLE)
    for word in structure.removeprefix(_TABLE).split("_"):
        matched = _FACTOR.fullmatch(word)
        if matched is None:
            return None
        absolute, variable, power = matched.groups()
        factors.append(
            Factor(variable=variable, power=int(power or 1), absolute=absolute is not None)
        )
        if table and word != variable:
            return None
    if table and len(factors) not in NODES:
        return None
    return target, structure, tuple(factors)


def _formula(factor: Factor) -> str:
    """Return a factor as what it is: speed counts from its reference."""
    if factor.variable != "V":
        return _words(factor)
    speed = f"(V/({REFERENCE_SPEED:g} m/s) - 1)"
    return speed if factor.power == 1 else f"{speed}^{factor.power}"


def _read(variable: str) -> str:
    return f"{variable}_hat" if variable in ("p", "q", "r") else variable


def _words(factor: Factor) -> str:
    name = f"|{factor.variable}|" if factor.absolute else factor.variable
    return name if factor.power == 1 else f"{name}^{factor.power}"


register_described_terms(create_unnamed_term)
