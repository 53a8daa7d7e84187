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
from gsapp.dynamics.model import Model, save_model
from gsapp.foundation import write_atomically
from gsapp.identification.campaign import CampaignResult
from gsapp.identification.estimate_json import campaign_json
from gsapp.identification.linear_models.files import save_linear_model
from gsapp.identification.linear_models.signals import LinearAxis
from gsapp.identification.summary import CONDITIONS, CampaignSummary
from gsapp.quantities import channel


def write_files(
    folder: Path,
    result: CampaignResult,
    summary: CampaignSummary,
    models: Mapping[LinearAxis, LinearModel],
    *,
    aircraft: str,
) -> tuple[Path, ...]:
    """Write everything that other programs may want of a campaign.

    Parameters
    ----------
    folder : Path
        ``derivatives.csv`` (a row for each derivative), ``values.csv`` (a row for each value of
        each maneuver), ``derivatives.mat``, ``campaign.json``, ``model.toml``, ``linear-*.toml``.
    result : CampaignResult
    summary : CampaignSummary
    models : mapping of str to LinearModel
        By axis.
    aircraft : str

    Returns
    -------
    tuple of Path
        The files written; each whole or not at all.

    Raises
    ------
    OSError
        If the disk refuses.
    """
    flights = ", ".join(dict.fromkeys(one.maneuver.flight for one in result.results))
    written = [
        write_atomically(folder / "derivatives.csv", _derivatives_csv(summary)),
        write_atomically(folder / "values.csv", _values_csv(summary)),
        write_atomically(folder / "derivatives.mat", _mat(summary, models)),
        write_atomically(
            folder / "campaign.json", json.dumps(campaign_json(result), indent=1) + "\n"
        ),
    ]
    if summary.derivatives:
        written.append(
            save_model(_model(result, summary, aircraft, flights), folder / "model.toml")
        )
    for axis, model in models.items():
        written.append(
            save_linear_model(
                model, folder / f"linear-{axis}.toml", name=f"{aircraft}, {axis}",
                source=f"means over {flights}",
            )
        )  # fmt: skip
    return tuple(written)


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
