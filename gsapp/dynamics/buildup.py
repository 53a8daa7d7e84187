"""The linear build-up (4.2.1)-(4.2.6): six coefficients, thirty derivatives."""

from __future__ import annotations

from gsapp.dynamics.terms import COEFFICIENTS, LinearTerm, Parameter

LONGITUDINAL_VARIABLES = {"alpha": "alpha", "q": "q_hat", "de": "de"}
LATERAL_VARIABLES = {"beta": "beta", "p": "p_hat", "r": "r_hat", "da": "da", "dr": "dr"}
"""Suffix of the derivative: variable that it multiplies."""

LONGITUDINAL_COEFFICIENTS = ("CN", "CA", "Cm")
LATERAL_COEFFICIENTS = ("CY", "Cl", "Cn")
COEFFICIENT_TITLES = {
    "CX": "force along x",
    "CZ": "force along z",
    "CN": "normal force",
    "CA": "axial force",
    "CY": "side force",
    "Cl": "rolling moment",
    "Cm": "pitching moment",
    "Cn": "yawing moment",
}


def linear_variables(coefficient: str) -> dict[str, str]:
    """Return suffix -> variable of the linear terms of one coefficient."""
    return LONGITUDINAL_VARIABLES if coefficient in LONGITUDINAL_COEFFICIENTS else LATERAL_VARIABLES


def derivative_names() -> tuple[str, ...]:
    """Return the names of all derivatives, coefficient by coefficient."""
    return tuple(
        f"{coefficient}_{suffix}"
        for coefficient in COEFFICIENTS
        for suffix in ("0", *linear_variables(coefficient))
    )


def create_linear_terms() -> tuple[LinearTerm, ...]:
    """Return the six linear terms, each with the derivatives of one coefficient."""
    terms = []
    for coefficient in COEFFICIENTS:
        reads = linear_variables(coefficient)
        names = [f"{coefficient}_{suffix}" for suffix in ("0", *reads)]
        products = [f"{coefficient}_{suffix} {variable}" for suffix, variable in reads.items()]
        terms.append(
            LinearTerm(
                id=f"linear.{coefficient}",
                title=f"Linear {COEFFICIENT_TITLES[coefficient]}",
                equation=f"{coefficient} = {names[0]} + {' + '.join(products)}",
                target=coefficient,
                reads=tuple(reads.values()),
                parameters=tuple(
                    Parameter(
                        name,
                        "",
                        0.0,
                        (-100.0, 100.0),
                        "per radian, rates as q c/2V, p b/2V, r b/2V",
                    )
                    for name in names
                ),
            )
        )
    return tuple(terms)
