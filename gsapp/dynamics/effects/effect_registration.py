"""What the modules of effects share: words, and how effects are entered."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from gsapp.aircraft import Aircraft
from gsapp.dynamics.buildup import COEFFICIENT_TITLES
from gsapp.dynamics.effect_terms import OffsetTerm
from gsapp.dynamics.signal_terms import SURFACE_CHANNELS, SignalTerm
from gsapp.dynamics.terms import EffectGuidance, Monomial, Parameter, Term, register_effect

LONGITUDINAL = ("CN", "CA", "Cm")
SURFACE_NAMES = {channel: surface for surface, channel in SURFACE_CHANNELS.items()}
VARIABLE_TITLES = {
    **SURFACE_NAMES,
    "alpha": "angle of attack",
    "beta": "sideslip",
    "p_hat": "roll rate",
    "q_hat": "pitch rate",
    "r_hat": "yaw rate",
}
BEYOND = "Seanor, section 4.2: left out of the linear build-up"


def held_parameter(
    name: str, unit: str, value: float, bounds: tuple[float, float], description: str
) -> Parameter:
    """Return a parameter that estimation does not move; it is neutral where it stands."""
    return Parameter(name, unit, value, bounds, description, neutral=value, free=False)


# 95 ft/s, the middle of the flight-test speeds.
V_REF = held_parameter("V_ref", "m/s", 28.956, (1.0, 300.0), "speed at which the term is zero")


def coefficient_title(target: str) -> str:
    """Return the title of a coefficient with a capital letter."""
    words = COEFFICIENT_TITLES[target]
    return words[0].upper() + words[1:]


def register_term(term: Term, guidance: EffectGuidance) -> None:
    """Enter an effect that is the same for every aircraft."""
    register_effect(term.id, lambda _: term, guidance)


def register_signal_term(
    kind: type[SignalTerm],
    term_id: str,
    channel: str,
    title: str,
    equation: str,
    guidance: EffectGuidance,
    parameters: tuple[Parameter, ...] = (),
    states: tuple[str, ...] = (),
) -> None:
    """Enter an effect on the path of a signal."""
    term = kind(
        id=term_id,
        title=title,
        equation=equation,
        target=term_id.rpartition(".")[0],
        reads=(channel,),
        parameters=parameters,
        states=states,
    )
    register_term(term, guidance)


def register_monomial(
    target: str,
    kind: str,
    factors: Sequence[tuple[str, int]],
    default: float,
    title: str,
    guidance: EffectGuidance,
    *,
    group: str = "aero",
) -> None:
    """Enter a coefficient's derivative by a product of powers of variables."""
    name = f"{target}_{kind}"
    product = " ".join(
        variable if power == 1 else f"{variable}^{power}" for variable, power in factors
    )
    register_term(
        Monomial(
            id=f"{group}.{target}.{kind}",
            title=title,
            equation=f"{target} += {name} {product}",
            target=target,
            reads=tuple(variable for variable, _ in factors),
            powers=tuple(power for _, power in factors),
            parameters=(
                Parameter(
                    name, "", default, (-200.0, 200.0), "size of the term, angles in radians"
                ),
            ),
        ),
        guidance,
    )


def register_offset(
    term_id: str,
    target: str,
    unit: str,
    size: Callable[[Aircraft], float],
    title: str,
    guidance: EffectGuidance,
) -> None:
    """Enter a value of the aircraft file in error, by `size` where nothing else is said."""
    name = target.rpartition(".")[2] if "." in target else "error"

    def make(aircraft: Aircraft) -> Term:
        default = size(aircraft)
        bound = 20.0 * abs(default)
        return OffsetTerm(
            id=term_id,
            title=title,
            equation=f"{target} = aircraft file's + {name}",
            target=target,
            reads=(),
            parameters=(
                Parameter(
                    name, unit, default, (-bound, bound), "difference from the aircraft file"
                ),
            ),
        )

    register_effect(term_id, make, guidance)


TAU = (Parameter("tau", "s", 0.06, (0.0, 1.0), "time constant"),)
DELAY = (Parameter("delay", "s", 0.05, (0.0, 0.5), "how late the signal is"),)
