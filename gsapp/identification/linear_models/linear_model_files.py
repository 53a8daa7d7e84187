"""Linear models as TOML files; the published ones ship as references."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field, model_validator

from gsapp.dynamics.linearization import LinearModel, OperatingPoint
from gsapp.flight.readers.columns import parse_name
from gsapp.foundation import StrictModel, read_toml, toml_text, write_atomically
from gsapp.foundation.files import ShippedFiles
from gsapp.quantities import FloatArray, channel
from gsapp.quantities.fields import Density, Mass, Speed

SHIPPED_LINEAR_MODELS = ShippedFiles(
    folder=Path(__file__).parent / "published", kind="linear model"
)
PUBLISHED_AIRCRAFT = "B777"
"""The aircraft that the published models and errors are of, by the name in its file."""
_ERRORS = Path(__file__).parent / "published_errors.toml"
_LARGEST = 1_000_000_000
MatrixRows = tuple[tuple[Annotated[float, Field(strict=True)], ...], ...]


class LinearModelFile(StrictModel):
    """A linear model as it is written down."""

    name: str
    source: str = ""
    speed: Speed | None = None
    density: Density | None = None
    mass: Mass | None = None
    """Of the steady flight that the model is about: true airspeed, m/s; kg/m^3; kg."""
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    """Each ``id [unit]``: the units in which the matrices are written."""
    A: MatrixRows
    B: MatrixRows
    C: MatrixRows
    D: MatrixRows

    @model_validator(mode="after")
    def _fits(self) -> LinearModelFile:
        for label in (*self.states, *self.inputs, *self.outputs):
            parse_name(label)
        n, m, p = len(self.states), len(self.inputs), len(self.outputs)
        for name, rows, columns in (("A", n, n), ("B", n, m), ("C", p, n), ("D", p, m)):
            matrix = getattr(self, name)
            if len(matrix) != rows or any(len(row) != columns for row in matrix):
                raise ValueError(
                    f"{name} must have {rows} rows of {columns} numbers for these states, inputs "
                    "and outputs; check the brackets"
                )
            if any(abs(number) > _LARGEST for row in matrix for number in row):
                raise ValueError(
                    f"{name} holds a number beyond {_LARGEST:g}; correct the number or its unit"
                )
        return self

    def model(self) -> LinearModel:
        """Return the model in SI and radians."""
        x, u, y = (_si_factors(labels) for labels in (self.states, self.inputs, self.outputs))
        return LinearModel(
            states=_ids(self.states),
            inputs=_ids(self.inputs),
            outputs=_ids(self.outputs),
            A=x[:, None] * np.array(self.A) / x,
            B=x[:, None] * np.array(self.B) / u,
            C=y[:, None] * np.array(self.C) / x,
            D=y[:, None] * np.array(self.D) / u,
            operating_point=None
            if self.speed is None
            else OperatingPoint(speed=self.speed, density=self.density, mass=self.mass),
        )


def load_linear_model(name_or_path: str | Path) -> LinearModelFile:
    """Read a linear model, or a published one by its name.

    Raises `FileProblemsError` if the file holds mistakes; all are named. Raises `UnknownNameError`
    if there is neither such a file nor such a published model.
    """
    return read_toml(SHIPPED_LINEAR_MODELS.find(name_or_path), LinearModelFile)


def save_linear_model(model: LinearModel, path: Path, *, name: str, source: str = "") -> Path:
    """Write a linear model in SI."""
    return write_atomically(path, linear_model_text(model, name=name, source=source))


def linear_model_text(model: LinearModel, *, name: str, source: str = "") -> str:
    """Return the content of a file of a linear model, SI."""

    def labels(ids: Sequence[str]) -> list[str]:
        return [f"{one} [{channel(one).unit}]" for one in ids]

    content: dict[str, Any] = {
        "name": name,
        "source": source,
        **_steady(model.operating_point),
        "states": labels(model.states),
        "inputs": labels(model.inputs),
        "outputs": labels(model.outputs),
        **{key: getattr(model, key).tolist() for key in ("A", "B", "C", "D")},
    }
    return toml_text(content)


def _steady(about: OperatingPoint | None) -> dict[str, str]:
    """Return what a file says of the steady flight."""
    if about is None:
        return {}
    known = {
        "speed": (about.speed, "m/s"),
        "density": (about.density, "kg/m^3"),
        "mass": (about.mass, "kg"),
    }
    return {key: f"{value:.6g} {unit}" for key, (value, unit) in known.items() if value is not None}


class PublishedErrors(StrictModel):
    """RMS error over range in percent of one variable, by model: tables 7.4.1 and 7.4.2."""

    bls: float
    subspace: float
    ml: float


class _PublishedErrorTable(StrictModel):
    an: PublishedErrors
    alpha: PublishedErrors
    q: PublishedErrors
    ay: PublishedErrors
    beta: PublishedErrors
    p: PublishedErrors
    r: PublishedErrors


def published_errors() -> dict[str, PublishedErrors]:
    """Return tables 7.4.1 and 7.4.2 by variable."""
    table = read_toml(_ERRORS, _PublishedErrorTable)
    return {name: getattr(table, name) for name in type(table).model_fields}


def _ids(labels: Sequence[str]) -> tuple[str, ...]:
    return tuple(parse_name(label).id for label in labels)


def _si_factors(labels: Sequence[str]) -> FloatArray:
    """Return SI over the unit of each label: small changes have no offset."""
    ends = np.array([0.0, 1.0])
    return np.array([float(np.diff(parse_name(label).to_si(ends))[0]) for label in labels])
