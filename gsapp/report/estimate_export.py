"""A campaign's results for other programs: CSV, MATLAB, JSON, a model file, linear models."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any, Final

import numpy as np

from gsapp.dynamics.linearization import LinearModel
from gsapp.dynamics.model import Model, format_model
from gsapp.foundation.delimited_text import delimited_text
from gsapp.identification.campaign import CampaignResult
from gsapp.identification.estimate_json import campaign_json, value_json
from gsapp.identification.linear_models.linear_model_files import linear_model_text
from gsapp.identification.linear_models.signals import LINEAR_STATES, LinearAxis
from gsapp.identification.runs.run_execution import RunOutcome
from gsapp.identification.summary import CONDITIONS, CampaignSummary
from gsapp.identification.summary.campaign_linear_models import LinearModelValidation
from gsapp.quantities import channel
from gsapp.report.form_text import forms_json
from gsapp.report.linear_text import comparison_json

FILE_TITLES: Final[Mapping[str, str]] = {
    "derivatives.csv": "Derivatives (CSV)",
    "values.csv": "Values of each maneuver (CSV)",
    "derivatives.mat": "Derivatives, models (MATLAB)",
    "campaign.json": "All results (JSON)",
    "model.toml": "Model of the means (TOML)",
    "linear-lon.toml": "Longitudinal model (TOML)",
    "linear-lat.toml": "Lateral model (TOML)",
    "linear-models.json": "Linear models, flight (JSON)",
}
"""What can be written of a campaign, by name of the file, in words."""


def file_names(outcome: RunOutcome, linear: LinearModelValidation | None = None) -> tuple[str, ...]:
    """Return the names of the files that a campaign can give.

    Parameters
    ----------
    linear : LinearModelValidation, optional
        Without it there is no file of it.
    """
    lacking = {f"linear-{axis}.toml" for axis in LINEAR_STATES if axis not in outcome.models}
    if not outcome.summary.derivatives:
        lacking.add("model.toml")
    if linear is None:
        lacking.add("linear-models.json")
    return tuple(name for name in FILE_TITLES if name not in lacking)


def file_content(
    name: str, outcome: RunOutcome, linear: LinearModelValidation | None = None
) -> bytes:
    """Return the content of one of the files that `file_names` has.

    Parameters
    ----------
    name : str
        ``derivatives.csv`` (a row for each derivative), ``values.csv`` (a row for each value of
        each maneuver), ``derivatives.mat``, ``campaign.json``, ``model.toml``,
        ``linear-lon.toml``, ``linear-lat.toml``, or ``linear-models.json`` with the comparison of
        linear models.
    """
    result, summary = outcome.result, outcome.summary
    flights = ", ".join(dict.fromkeys(one.maneuver.flight for one in result.results))
    match name:
        case "derivatives.csv":
            return _derivatives_csv(summary).encode()
        case "values.csv":
            return _values_csv(summary).encode()
        case "derivatives.mat":
            return _mat(summary, outcome.models)
        case "campaign.json":
            return _json(_campaign(result, summary))
        case "model.toml":
            return format_model(_model(result, summary, outcome.aircraft, flights)).encode()
        case "linear-models.json":
            return _json(comparison_json(linear or LinearModelValidation()))
    axis: LinearAxis = "lon" if name == "linear-lon.toml" else "lat"
    return linear_model_text(
        outcome.models[axis],
        name=f"{outcome.aircraft}, {axis}",
        source=f"means over {flights}",
    ).encode()


def campaign_files(outcome: RunOutcome, linear: LinearModelValidation) -> dict[str, bytes]:
    """Return everything that other programs may want of a campaign, as files by name."""
    return {name: file_content(name, outcome, linear) for name in file_names(outcome, linear)}


def outcome_json(outcome: RunOutcome) -> dict[str, Any]:
    """Return what a run gave, with the certificates that its flights were read with."""
    content: dict[str, Any] = campaign_json(outcome.result)
    instruments = [
        {
            "channel": one.channel,
            "kind": one.kind,
            "value": one.value,
            "std": one.std,
            "position": None if one.position is None else list(one.position),
            "alternatives": list(one.alternatives),
        }
        for one in outcome.instruments
    ]
    return content | {
        "disagreement": {
            name: one.value.disagreement for name, one in outcome.summary.derivatives.items()
        },
        "instruments": instruments,
        "forms": forms_json(
            outcome.result,
            {name: one.value for name, one in outcome.summary.derivatives.items()},
        ),
        "calibration": list(outcome.calibration),
    }


def _campaign(result: CampaignResult, summary: CampaignSummary) -> dict[str, Any]:
    """Return the JSON of ``gsapp estimate``, its means without what was left out; that is named."""
    left_out = [
        {
            "derivative": name,
            "maneuver": outlier.point.maneuver,
            "sigmas": outlier.sigmas,
            "reasons": list(outlier.reasons),
        }
        for name, one in summary.derivatives.items()
        for outlier in one.outliers
    ]
    means = {name: value_json(one.value) for name, one in summary.derivatives.items()}
    return {
        **campaign_json(result),
        "campaign": means,
        "left_out": left_out,
        "left_out_by_hand": sorted(summary.excluded_maneuvers),
    }


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
            "" if one.bound_consistency is None else repr(one.bound_consistency.ratio),
            str(one.value.n),
            str(len(one.outliers)),
        )
        for name, one in summary.derivatives.items()
    ]
    return delimited_text(rows)


def _values_csv(summary: CampaignSummary) -> str:
    conditions = (f"{name} [{channel(name).unit}]" for name in CONDITIONS)
    heads = ("derivative", "maneuver", "flight", "value", "std", "bound", "left_out", *conditions)
    rows: list[tuple[str, ...]] = [heads]
    for name, one in summary.derivatives.items():
        standing = {point.maneuver for point in one.included_points}
        rows += [
            (
                name,
                point.maneuver,
                point.flight,
                repr(point.value),
                repr(point.std),
                repr(one.bound(point)),
                str(int(point.maneuver not in standing)),
                *(
                    repr(point.conditions[key]) if key in point.conditions else ""
                    for key in CONDITIONS
                ),
            )
            for point in one.points
        ]
    return delimited_text(rows)


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
            **({} if model.operating_point is None else asdict(model.operating_point)),
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
    before = result.settings.known_model
    if before is None:
        known = {name for name in means if "." not in name}
        return Model(
            name=name, source=source, derivatives={key: means[key] for key in sorted(known)}
        )
    kept = {key: value for key, value in means.items() if "." not in key}
    return before.with_derivatives(kept, name=name).model_copy(update={"source": source})
