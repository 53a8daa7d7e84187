"""A campaign's results for other programs: CSV, MATLAB, JSON, a model file, linear models."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gsapp.dynamics.linearization import LinearModel
from gsapp.dynamics.model import Model, model_text
from gsapp.foundation import write_atomically
from gsapp.identification.campaign import CampaignResult
from gsapp.identification.estimate_json import campaign_json
from gsapp.identification.linear_models.files import linear_model_text
from gsapp.identification.linear_models.signals import LinearAxis
from gsapp.identification.runs.outcome import Outcome
from gsapp.identification.summary import CONDITIONS, CampaignSummary
from gsapp.quantities import channel
from gsapp.report.linear_report import LinearComparison, comparison_json


def campaign_files(outcome: Outcome, linear: LinearComparison) -> dict[str, bytes]:
    """Return everything that other programs may want of a campaign, as files by name.

    Parameters
    ----------
    outcome : Outcome
    linear : LinearComparison

    Returns
    -------
    dict of str to bytes
        ``derivatives.csv`` (a row for each derivative), ``values.csv`` (a row for each value of
        each maneuver), ``derivatives.mat``, ``campaign.json``, ``model.toml``, ``linear-*.toml``,
        and ``linear-models.json`` with the comparison of linear models.
    """
    result, summary, models = outcome.result, outcome.summary, outcome.models
    flights = ", ".join(dict.fromkeys(one.maneuver.flight for one in result.results))
    found = {
        "derivatives.csv": _derivatives_csv(summary).encode(),
        "values.csv": _values_csv(summary).encode(),
        "derivatives.mat": _mat(summary, models),
        "campaign.json": _json(campaign_json(result)),
        "linear-models.json": _json(comparison_json(linear)),
    }
    if summary.derivatives:
        model = _model(result, summary, outcome.aircraft, flights)
        found["model.toml"] = model_text(model).encode()
    for axis, linear_model in models.items():
        found[f"linear-{axis}.toml"] = linear_model_text(
            linear_model, name=f"{outcome.aircraft}, {axis}", source=f"means over {flights}"
        ).encode()
    return found


def write_files(folder: Path, outcome: Outcome, linear: LinearComparison) -> tuple[Path, ...]:
    """Write these files into a folder; each whole or not at all.

    Raises
    ------
    OSError
        If the disk refuses.
    """
    return tuple(
        write_atomically(folder / name, content)
        for name, content in campaign_files(outcome, linear).items()
    )


def _json(content: Mapping[str, Any]) -> bytes:
    return (json.dumps(content, indent=1, allow_nan=False) + "\n").encode()


def _derivatives_csv(summary: CampaignSummary) -> str:
    rows = [("derivative", "mean", "std", "scatter", "scatter_over_bounds", "n", "left_out")]
    rows += [
        (
            name,
            repr(one.value.mean),
            repr(one.value.std),
            "" if one.value.scatter is None else repr(one.value.scatter),
            "" if one.honesty is None else repr(one.honesty.ratio),
            str(one.value.n),
            str(len(one.outliers)),
        )
        for name, one in summary.derivatives.items()
    ]
    return _csv(rows)


def _values_csv(summary: CampaignSummary) -> str:
    conditions = (f"{name} [{channel(name).unit}]" for name in CONDITIONS)
    heads = ("derivative", "maneuver", "flight", "value", "std", "left_out", *conditions)
    rows: list[tuple[str, ...]] = [heads]
    for name, one in summary.derivatives.items():
        out = {outlier.point.maneuver for outlier in one.outliers}
        rows += [
            (
                name,
                point.maneuver,
                point.flight,
                repr(point.value),
                repr(point.std),
                str(int(point.maneuver in out)),
                *(
                    repr(point.conditions[key]) if key in point.conditions else ""
                    for key in CONDITIONS
                ),
            )
            for point in one.points
        ]
    return _csv(rows)


def _csv(rows: Sequence[tuple[str, ...]]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def _mat(summary: CampaignSummary, models: Mapping[LinearAxis, LinearModel]) -> bytes:
    """Return a MATLAB file: a struct of means and bounds, and the matrices of linear models."""
    from scipy.io import savemat  # a tenth of a second

    content: dict[str, Any] = {
        "derivatives": {
            name: {
                "mean": one.value.mean,
                "std": one.value.std,
                "scatter": np.nan if one.value.scatter is None else one.value.scatter,
                "n": float(one.value.n),
            }
            for name, one in summary.derivatives.items()
        }
    }
    for axis, model in models.items():
        content[f"linear_{axis}"] = {
            **{key: getattr(model, key) for key in ("A", "B", "C", "D")},
            "states": np.array(model.states, dtype=object),
            "inputs": np.array(model.inputs, dtype=object),
            "outputs": np.array(model.outputs, dtype=object),
        }
    stream = io.BytesIO()
    savemat(stream, content, long_field_names=True, do_compression=True)
    # The header holds the moment of writing: the same campaign gives the same file.
    data = bytearray(stream.getvalue())
    data[:_HEADER] = b"MATLAB 5.0 MAT-file, derivatives of a campaign".ljust(_HEADER)
    return bytes(data)


_HEADER = 116
"""Bytes of text at the start of a MATLAB file of version 5."""


def _model(result: CampaignResult, summary: CampaignSummary, aircraft: str, flights: str) -> Model:
    """Return the means as a model; with a model given before, its revision."""
    means = {name: one.value.mean for name, one in summary.derivatives.items()}
    name = f"{aircraft}, estimated"
    source = f"means over {flights}"
    before = result.settings.model
    if before is None:
        known = {name for name in means if "." not in name}
        return Model(
            name=name, source=source, derivatives={key: means[key] for key in sorted(known)}
        )
    kept = {key: value for key, value in means.items() if "." not in key}
    return before.with_derivatives(kept, name=name).model_copy(update={"source": source})
