"""Aerodynamic models as files: derivatives and effects (DESIGN section 4).

Coefficients are total, per radian, rates as q c/2V, p b/2V, r b/2V, moments about the aircraft
file's CG, thrust not included. A derivative that a file leaves out is zero. A revised model names
its parent.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from pydantic import Field, field_validator

from gsapp.aircraft import Aircraft
from gsapp.dynamics.buildup import derivative_names
from gsapp.dynamics.effects.unnamed_terms import is_unnamed
from gsapp.dynamics.terms import Term, create_term, effect_ids
from gsapp.foundation import (
    FileProblem,
    StrictModel,
    read_toml,
    toml_problems_error,
    toml_text,
    write_atomically,
)
from gsapp.foundation.files import ShippedFiles
from gsapp.foundation.name_suggestions import did_you_mean

SHIPPED_MODELS = ShippedFiles(folder=Path(__file__).parent / "models", kind="model")


class Effect(StrictModel):
    """One effect in a model."""

    id: str  # As in the registry, ``aero.Cm.alpha2``.
    parameters: dict[str, float] = Field(default_factory=dict)
    """SI and radians; what is left out takes the effect's default."""

    @field_validator("id")
    @classmethod
    def _known(cls, value: str) -> str:
        if value not in effect_ids() and not is_unnamed(value):
            lists = "'gsapp discrepancy --list' lists them"
            hint = did_you_mean(value, effect_ids(), lists, most=1)
            raise ValueError(f"no effect is called '{value}'; {hint}")
        return value

    def term(self, aircraft: Aircraft) -> Term:
        return create_term(self.id, aircraft)

    def values(self, aircraft: Aircraft) -> tuple[float, ...]:
        """Return the parameters in the order of the term."""
        return self.term(aircraft).values_for(self.parameters)


class Model(StrictModel):
    """A model file, read."""

    name: str = "model"
    parent: str | None = None
    """Name of the model that this one revises."""
    evidence: str = ""  # Why it was revised, in words.
    source: str = ""  # Where the numbers come from.
    derivatives: dict[str, float] = Field(default_factory=dict)
    """Those given; `derivative` returns zero for the rest."""
    effects: tuple[Effect, ...] = ()  # In the order in which they were found.

    @field_validator("derivatives")
    @classmethod
    def _are_known(cls, value: dict[str, float]) -> dict[str, float]:
        known = derivative_names()
        wrong = []
        for name in value:
            if name not in known:
                hint = did_you_mean(name, known, most=1)
                wrong.append(f"'{name}' is not a derivative{f' ({hint})' if hint else ''}")
        if wrong:
            raise ValueError(
                f"{', '.join(wrong)}; names are CN_ CA_ Cm_ 0 alpha q de and "
                "CY_ Cl_ Cn_ 0 beta p r da dr"
            )
        return value

    @field_validator("effects")
    @classmethod
    def _each_once(cls, value: tuple[Effect, ...]) -> tuple[Effect, ...]:
        ids = [effect.id for effect in value]
        twice = sorted({name for name in ids if ids.count(name) > 1})
        if twice:
            raise ValueError(f"{', '.join(twice)} appears twice; keep one")
        return value

    def derivative(self, name: str) -> float:
        return self.derivatives.get(name, 0.0)

    def with_derivatives(self, values: Mapping[str, float], *, name: str | None = None) -> Model:
        """Return a model with these derivatives changed; a new name makes this one its parent."""
        changed: dict[str, object] = {"derivatives": {**self.derivatives, **values}}
        return self._revised(changed, name)

    def with_effect(
        self,
        effect_id: str,
        parameters: Mapping[str, float] | None = None,
        *,
        name: str | None = None,
    ) -> Model:
        """Return a model with an effect added, or replaced where it stood."""
        effect = Effect(id=effect_id, parameters=dict(parameters or {}))
        kept = tuple(old for old in self.effects if old.id != effect_id)
        return self._revised({"effects": (*kept, effect)}, name)

    def without_effect(self, effect_id: str) -> Model:
        kept = tuple(old for old in self.effects if old.id != effect_id)
        return self._revised({"effects": kept}, None)

    def _revised(self, changed: dict[str, object], name: str | None) -> Model:
        content = self.model_dump()
        content.update({key: value for key, value in changed.items() if key != "effects"})
        if "effects" in changed:
            content["effects"] = changed["effects"]
        if name is not None and name != self.name:
            content.update(name=name, parent=self.name)
        return Model.model_validate(content)


def shipped_models() -> tuple[str, ...]:
    """Return the names of the models that come with the program."""
    return SHIPPED_MODELS.names()


def load_model(name_or_path: str | Path) -> Model:
    """Read a model file: a path, or the name of a shipped model such as ``b777``.

    Raise FileProblemsError if the file holds mistakes; all are named. Raise UnknownNameError if
    there is neither such a file nor such a shipped model.
    """
    path = SHIPPED_MODELS.find(name_or_path)
    model = read_toml(path, Model)
    problems = []
    for index, effect in enumerate(model.effects):
        problems += _parameter_problems(index, effect)
    if problems:
        raise toml_problems_error(path, problems)
    return model


def save_model(model: Model, path: str | Path) -> Path:
    """Write a model file, atomically."""
    return write_atomically(path, format_model(model))


def format_model(model: Model) -> str:
    """Return the content of a model file."""
    content = {
        key: value
        for key, value in model.model_dump(mode="json").items()
        if value not in (None, "", {}, [])
    }
    return toml_text(content)


def _parameter_problems(index: int, effect: Effect) -> list[FileProblem]:
    # Names, units and kinds of parameters do not depend on the aircraft; only defaults may.
    known = {item.name: item for item in create_term(effect.id, _ANY_AIRCRAFT).parameters}
    problems = []
    for name in effect.parameters:
        where = f"effects[{index}].parameters.{name}"
        if name not in known:
            remedy = did_you_mean(name, known, f"known: {', '.join(known)}", most=1)
            problems.append(
                FileProblem(where=where, what=f"is not a parameter of '{effect.id}'", remedy=remedy)
            )
    return problems


_ANY_AIRCRAFT = Aircraft.model_validate(
    {
        "geometry": {"wing_area": "1 m^2", "span": "1 m", "chord": "1 m"},
        "mass": {"mass": "1 kg", "ixx": "1 kg*m^2", "iyy": "1 kg*m^2", "izz": "1 kg*m^2"},
    }
)
