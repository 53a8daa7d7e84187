"""Effects that a virtual aircraft has and its model lacks: ``ID[:PARAM=VALUE,..]``."""

from __future__ import annotations

from collections.abc import Sequence

from gsapp.aircraft import Aircraft
from gsapp.dynamics.model import Model
from gsapp.dynamics.terms import create_term
from gsapp.foundation import FlightError


def add_hidden_effects(aircraft: Aircraft, model: Model, hide: Sequence[str] = ()) -> Model:
    """Return the model that the virtual aircraft really follows.

    Parameters
    ----------
    hide : sequence of str
        Effects beyond it; values in SI and radians.

    Raises
    ------
    UnknownNameError
        If an effect or one of its parameters is unknown.
    FlightError
        If a value is not a number.
    """
    for text in hide:
        effect_id, parameters = parse_effect(text)
        create_term(effect_id, aircraft).values_for(parameters)
        model = model.with_effect(effect_id, parameters)
    return model


def parse_effect(text: str) -> tuple[str, dict[str, float]]:
    """Return id and parameters of ``ID[:PARAM=VALUE,..]``."""
    effect_id, _, rest = text.partition(":")
    parameters: dict[str, float] = {}
    for pair in rest.split(",") if rest else ():
        name, equals, value = pair.partition("=")
        try:
            if not equals:
                raise ValueError
            parameters[name.strip()] = float(value)
        except ValueError:
            raise FlightError(
                f"'{pair}' in '{text}' is not PARAM=VALUE; write for example "
                "aero.Cm.alpha2:Cm_alpha2=-2.0, in SI units and radians"
            ) from None
    return effect_id.strip(), parameters
