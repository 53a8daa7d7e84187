"""The one interface of all model terms: values and Jacobians, for numbers and for arrays.

A *term* reads named variables and adds to one named target. It may own parameters, and states of
its own whose rates it gives. Everything that a linear build-up leaves out (an effect) is a term;
so are the linear build-up itself, the lag of a servo and the scale error of a vane. Estimation,
simulation and the search for a missing effect all run on these functions:

    value(reads, states, parameters)     what is added to the target
    rates(reads, states, parameters)     of its own states
    jacobian(reads, states, parameters)  of both, by reads, states and parameters

``reads``, ``states`` and ``parameters`` are tuples in the order of the term's own lists. An
element is a float, or an array of shape (n,) with one number for each sample.

Targets
    ``CN CA CY Cl Cm Cn CX CZ``    coefficients (about the aircraft file's CG)
    ``X Y Z L M N``                forces (N) and moments (N m) in body axes
    ``thrust``                     force along x (N)
    ``mass ixx iyy izz ixz cg.x cg.y cg.z``   offsets of the file's values (kg, kg m^2, m)
    ``place.<instrument>.<axis>``  offset of where an instrument sits, from the file's (m)
    ``place.boom.x``               that of both vanes, as one boom carries them (m)
    ``control.<surface>``          the path of a control signal, see `gsapp.dynamics.signal_terms`
    ``sensor.<channel>``           the path of a measured signal, or of all those of a box
"""

# ruff: noqa: ARG002 - overridden methods, which use their arguments or not

from __future__ import annotations

import importlib
import pkgutil
import warnings
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.metadata import entry_points
from typing import Literal, NamedTuple

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.dynamics.arithmetic import Value
from gsapp.foundation import UnknownNameError
from gsapp.foundation.name_suggestions import did_you_mean
from gsapp.quantities import FloatArray

Values = Sequence[Value]

VARIABLES: Mapping[str, str] = {
    "V": "true airspeed, m/s",
    "alpha": "angle of attack at the CG, rad",
    "beta": "angle of sideslip at the CG, rad",
    "p": "roll rate, rad/s",
    "q": "pitch rate, rad/s",
    "r": "yaw rate, rad/s",
    "p_hat": "p b/(2V)",
    "q_hat": "q c/(2V)",
    "r_hat": "r b/(2V)",
    "de": "elevator, rad",
    "da": "aileron, rad",
    "dr": "rudder, rad",
    "flap": "flap, rad",
    "throttle": "throttle as the engines follow it, mean of both, 0 to 1",
    "throttle_difference": "half the left throttle minus the right",
    "rho": "air density, kg/m^3",
    "qbar": "dynamic pressure, Pa",
    "thrust": "all engines, N; for terms that do not add to the thrust",
    "alpha_dot_hat": "alpha' c/(2V); for terms that add to moments, and rates of own states",
    "beta_dot_hat": "beta' b/(2V); for terms that add to moments, and rates of own states",
}
"""What a term of the equations may read."""

COEFFICIENTS = ("CN", "CA", "CY", "Cl", "Cm", "Cn")
POSITIONED_INSTRUMENTS = ("alpha_vane", "beta_vane", "accelerometer", "air_data")
"""Instruments for which it matters where they sit, as the aircraft file calls them."""
BOOM_INSTRUMENTS = ("alpha_vane", "beta_vane")
"""Those of them that one boom carries."""
TARGETS = (
    *COEFFICIENTS,
    "CX",
    "CZ",
    "X",
    "Y",
    "Z",
    "L",
    "M",
    "N",
    "thrust",
    "mass",
    "ixx",
    "iyy",
    "izz",
    "ixz",
    "cg.x",
    "cg.y",
    "cg.z",
    *(f"place.{instrument}.{axis}" for instrument in POSITIONED_INSTRUMENTS for axis in "xyz"),
    "place.boom.x",
)
"""What a term of the equations may add to."""


def position_targets(instrument: str) -> tuple[tuple[str, ...], ...]:
    """Return the targets that move an instrument along x, along y, and along z."""
    boom = ("place.boom.x",) if instrument in BOOM_INSTRUMENTS else ()
    return tuple((f"place.{instrument}.{axis}", *(boom if axis == "x" else ())) for axis in "xyz")


@dataclass(frozen=True, slots=True)
class Parameter:
    """A number in a term that may be given, held, or estimated."""

    name: str  # Unique within its term; derivatives keep their usual name (``Cm_alpha2``).
    unit: str  # SI unit as text; empty for pure numbers.
    default: float
    """A plausible size: what is taken where a file or command names the effect alone."""
    bounds: tuple[float, float]  # Outside is not physical.
    description: str
    neutral: float = 0.0
    """The value at which the term does nothing."""
    free: bool = True  # Whether estimation may move it. A reference speed is not free.


class TermJacobian(NamedTuple):
    """Partial derivatives of a term, each element a float or an array of shape (n,)."""

    reads: tuple[Value, ...]
    states: tuple[Value, ...] = ()
    parameters: tuple[Value, ...] = ()
    rate_reads: tuple[tuple[Value, ...], ...] = ()
    rate_states: tuple[tuple[Value, ...], ...] = ()
    rate_parameters: tuple[tuple[Value, ...], ...] = ()
    """Of the rates: one inner tuple for each state of the term."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Term(ABC):
    """Base of all terms."""

    id: str  # ``group.target.kind``, such as ``aero.Cm.alpha2``.
    title: str  # In a field engineer's words.
    equation: str  # The physics, as text.
    target: str  # What it adds to.
    reads: tuple[str, ...]  # Names of the variables read.
    parameters: tuple[Parameter, ...] = ()
    states: tuple[str, ...] = ()
    """Names of its own states; empty for a static term."""
    rate_only_reads: tuple[str, ...] = ()
    """Of the variables read, those that enter the rates of its own states and not its value: rates
    of the flow angles, where it adds to a force."""
    shared_parameters: tuple[str, ...] = ()
    """Parameters that all terms of its class in one model share: one flow separates."""

    @abstractmethod
    def value(self, reads: Values, states: Values, parameters: Values) -> Value: ...

    @abstractmethod
    def jacobian(self, reads: Values, states: Values, parameters: Values) -> TermJacobian:
        """Return the exact partial derivatives of value and rates."""

    def rates(self, reads: Values, states: Values, parameters: Values) -> tuple[Value, ...]:
        """Return the rates of the term's own states (none for a static term)."""
        return ()

    def steady_state(self, reads: Values, parameters: Values) -> tuple[Value, ...]:
        """Return the states at which their rates vanish for constant `reads`."""
        return ()

    def states_along(
        self, reads: Sequence[FloatArray], parameters: Sequence[float], dt: float
    ) -> tuple[FloatArray, ...]:
        """Return the term's own states, shape (n,), along histories of what it reads.

        They have settled at the first sample. Heun's method; terms with a closed form override it.
        """
        now = self.steady_state([one[0] for one in reads], parameters)
        found = [now]
        slope = self.rates([one[0] for one in reads], now, parameters)
        for index in range(1, len(reads[0]) if self.states else 1):
            given = [one[index] for one in reads]
            ahead = [x + dt * rate for x, rate in zip(now, slope, strict=True)]
            then = self.rates(given, ahead, parameters)
            now = tuple(
                x + 0.5 * dt * (one + two) for x, one, two in zip(now, slope, then, strict=True)
            )
            found.append(now)
            slope = self.rates(given, now, parameters)
        return tuple(np.array(found, dtype=np.float64).T)

    @property
    def defaults(self) -> dict[str, float]:
        """Return the plausible value of every parameter by its name."""
        return {parameter.name: parameter.default for parameter in self.parameters}

    def values_for(self, given: Mapping[str, float]) -> tuple[float, ...]:
        """Return the parameters in order: those given, the defaults for the rest.

        Raise UnknownNameError if a name is not a parameter of this term.
        """
        known = self.defaults
        for name in given:
            if name not in known:
                raise UnknownNameError(unknown_parameter(self, name))
        return tuple(float(given.get(name, default)) for name, default in known.items())


def unknown_parameter(term: Term, name: str) -> str:
    """Return the sentence for a parameter that a term does not have."""
    names = [parameter.name for parameter in term.parameters]
    if not names:
        return f"the effect '{term.id}' has no parameters, so '{name}' cannot be set; leave it out"
    hint = " ".join(part for part in (did_you_mean(name, names, most=1), "it has") if part)
    return f"the effect '{term.id}' has no parameter '{name}'; {hint} {', '.join(names)}"


@dataclass(frozen=True, slots=True, kw_only=True)
class LinearTerm(Term):
    """Bias and linear terms of one coefficient: sum of parameter times variable.

    The first parameter stands alone, the others each multiply the variable at the same place.
    """

    def value(self, reads: Values, states: Values, parameters: Values) -> Value:
        total = parameters[0]
        for variable, parameter in zip(reads, parameters[1:], strict=True):
            total = total + variable * parameter
        return total

    def jacobian(self, reads: Values, states: Values, parameters: Values) -> TermJacobian:
        return TermJacobian(reads=tuple(parameters[1:]), parameters=(1.0, *reads))


@dataclass(frozen=True, slots=True, kw_only=True)
class Monomial(Term):
    """One parameter times a product of whole powers of variables."""

    powers: tuple[int, ...]  # One for each variable read, 1 or more.
    scale: float = 1.0  # A fixed factor, such as a length of the aircraft.

    def value(self, reads: Values, states: Values, parameters: Values) -> Value:
        total = self.scale * parameters[0]
        for variable, power in zip(reads, self.powers, strict=True):
            total = total * variable**power
        return total

    def jacobian(self, reads: Values, states: Values, parameters: Values) -> TermJacobian:
        by_read = []
        for index, power in enumerate(self.powers):
            slope = self.scale * parameters[0] * power * reads[index] ** (power - 1)
            for other, exponent in enumerate(self.powers):
                if other != index:
                    slope = slope * reads[other] ** exponent
            by_read.append(slope)
        product: Value = self.scale
        for variable, power in zip(reads, self.powers, strict=True):
            product = product * variable**power
        return TermJacobian(reads=tuple(by_read), parameters=(product,))


TermFactory = Callable[[Aircraft], Term]
"""Makes a term for an aircraft; its geometry may enter."""

EffectClass = Literal["A", "B", "C"]
"""A: seen with the baseline's own derivatives free. B: seen by kinematics alone. C: seen only
against trusted values; a measurement on the ground settles it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EffectGuidance:
    """What field experience and theory say of an effect beyond its formula."""

    mistaken_for: tuple[str, ...]
    """Effects that look alike in ordinary maneuvers, most alike first."""
    separated_by: str  # The maneuver or record that tells them apart.
    effect_class: EffectClass = "A"
    remedy: str = ""  # Class C: the measurement on the ground that settles it. Else empty.
    needs: tuple[str, ...] = ()
    """Channels that must be recorded (and, of inputs, must move) before it can be seen."""
    source: str
    derivative: str = ""
    """Of the linear build-up, if the effect is one of its derivatives: a baseline that has it free
    leaves nothing to find."""
    variant_of: str = ""
    """A plainer effect that this looks like in all but special maneuvers: the same physics in a
    finer shape, or other physics of the same shape."""
    beyond_linear_alpha: bool = False
    """Whether it shows only where angles of attack exceed the linear range of the aircraft file."""
    decoy: bool = False
    """Whether it stands for structure without a name: where it wins, nothing was explained."""


class EffectDefinition(NamedTuple):
    """One effect: its id (``group.target.kind``), its term for an aircraft, its guidance.

    What an entry point of the group ``gsapp.effects`` gives, alone or in a sequence.
    """

    id: str
    create: TermFactory
    guidance: EffectGuidance


EFFECT_GROUPS = ("aero", "propulsion", "control", "sensor", "mass")
ENTRY_POINT_GROUP = "gsapp.effects"

_REGISTRY: dict[str, EffectDefinition] = {}
_DESCRIBED: list[Callable[[str], Term | None]] = []
_EFFECT_PACKAGE = "gsapp.dynamics.effects"
"""Its modules enter their effects when they are imported, and they import this module."""


def register_effect(effect_id: str, create: TermFactory, guidance: EffectGuidance) -> None:
    """Enter an effect under its id.

    Raise ValueError if the id is taken, or is not of the form ``group.target.kind``.
    """
    if effect_id in _REGISTRY:
        raise ValueError(f"the effect '{effect_id}' is registered twice")
    parts = effect_id.split(".")
    if len(parts) != 3 or parts[0] not in EFFECT_GROUPS:
        raise ValueError(
            f"'{effect_id}' is no effect id: group.target.kind with a group of "
            f"{', '.join(EFFECT_GROUPS)}"
        )
    _REGISTRY[effect_id] = EffectDefinition(effect_id, create, guidance)


def register_described_terms(describe: Callable[[str], Term | None]) -> None:
    """Enter terms whose ids say all of them: what makes one, or returns None for other ids."""
    _DESCRIBED.append(describe)


@cache
def _registered() -> Mapping[str, EffectDefinition]:
    package = importlib.import_module(_EFFECT_PACKAGE)
    for module in pkgutil.iter_modules(package.__path__):
        importlib.import_module(f"{_EFFECT_PACKAGE}.{module.name}")
    for point in entry_points(group=ENTRY_POINT_GROUP):
        try:
            found = point.load()
            for one in (found,) if isinstance(found, EffectDefinition) else found:
                register_effect(*one)
        except Exception as error:  # A package of somebody else's must not stop the program.
            warnings.warn(f"effects of the package '{point.value}' left out: {error}", stacklevel=2)
    return _REGISTRY


def effect_ids() -> tuple[str, ...]:
    """Return the ids of all registered effects, sorted."""
    return tuple(sorted(_registered()))


def effect_guidance(effect_id: str) -> EffectGuidance:
    """Return what is known of a registered effect beyond its formula."""
    return _registered()[effect_id].guidance


def create_term(term_id: str, aircraft: Aircraft) -> Term:
    """Return the term with that id for an aircraft.

    Structure without a name (`gsapp.dynamics.effects.unnamed_terms`) is described by its id.
    Raise UnknownNameError if no effect has that id; the nearest are named.
    """
    known = _registered()
    for describe in _DESCRIBED:
        if described := describe(term_id):
            return described
    found = known.get(term_id)
    if found is None:
        hint = did_you_mean(term_id, known, "'gsapp discrepancy --list' lists them")
        raise UnknownNameError(f"no effect is called '{term_id}'; {hint}")
    return found.create(aircraft)
