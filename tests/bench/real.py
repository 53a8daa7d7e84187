"""Real flights of ATTAS and HFB-320 as a stranger brings them, beside published derivatives.

Where the folder holds the segments of a UAV as well, they follow (`tests.bench.real_uav`).

The folder holds ``fAttasElv1.mat``, ``fAttasElv2.mat``, ``fAttasAilRud1.mat``,
``fAttasAilRud2.mat`` and ``hfb320_1_10.asc``, the data of R. V. Jategaonkar, Flight Vehicle System
Identification, 2nd edition; they are not part of this project. The aircraft files say nothing of
vanes. Published values are dimensional (1/s, 1/s^2, per rad) with the flow angle at the vane as
state, for HFB-320 coefficients with rates as q c/2V, by filter error.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import loadmat

from gsapp.identification.campaign import CampaignValue
from gsapp.identification.linear_models.signals import LinearAxis
from gsapp.identification.methods import estimation_methods
from gsapp.identification.runs.request import RunRequest
from gsapp.identification.runs.run_execution import RunOutcome, execute_run
from gsapp.identification.summary.derivative_forms import forms_of_estimate, forms_of_means
from gsapp.quantities import FloatArray
from tests.bench.real_uav import print_uav

ATTAS = {"S": 64.0, "b": 21.5, "c": 3.159, "Ixx": 133367.0, "Iyy": 252687.0, "Izz": 359593.0}
ATTAS_IXZ = 11442.0
ATTAS_COLUMNS = {
    "time [s]": 1, "ax [m/s^2]": 2, "ay [m/s^2]": 3, "p [deg/s]": 7, "q [deg/s]": 8, "r [deg/s]": 9,
    "phi [deg]": 10, "theta [deg]": 11, "psi [deg]": 12, "alpha [deg]": 13, "beta [deg]": 14,
    "V [m/s]": 15, "de [deg]": 22, "dr [deg]": 30, "density [kg/m^3]": 34,
}  # fmt: skip
HFB_COLUMNS = {
    "time [s]": 1, "de [rad]": 2, "qbar [Pa]": 3, "thrust [N]": 4, "V [m/s]": 5, "alpha [rad]": 6,
    "theta [rad]": 7, "q [rad/s]": 8, "ax [m/s^2]": 10, "ay [m/s^2]": 12, "p [rad/s]": 13,
    "r [rad/s]": 14, "beta [rad]": 17, "phi [rad]": 18, "da [rad]": 19, "dr [rad]": 20,
}  # fmt: skip
# The modes are those of a linear model of the vane's angle and q fitted to the same records, whose
# M derivatives are the published ones within 0.2 %.
PUBLISHED_PITCH = {
    "M_alpha": -4.92651,
    "M_q": -2.00573,
    "M_de": -7.20806,
    "short period, rad/s": 2.532,
    "short period, damping": 0.492,
}
PUBLISHED_LATERAL = {
    "L_p": -2.06748, "L_r": 1.02929, "L_da": -6.30585, "L_dr": 1.1452, "L_beta": -3.84437,
    "N_p": -0.18385, "N_r": -0.48560, "N_da": -0.39121, "N_dr": -1.7609, "N_beta": 3.03138,
}  # fmt: skip
PUBLISHED_HFB = {"Cm_alpha": -0.9679, "Cm_q": -34.71, "Cm_de": -1.529, "CL_alpha": 4.328}
_AIRCRAFT = """name = "{name}"
[geometry]
wing_area = "{S} m^2"
span = "{b} m"
chord = "{c} m"
[mass]
mass = "{mass} kg"
ixx = "{Ixx} kg m^2"
iyy = "{Iyy} kg m^2"
izz = "{Izz} kg m^2"
ixz = "{Ixz} kg m^2"
"""
_HFB_THRUST = """[propulsion]
max_thrust = "20000 N"
zero_thrust_speed = "400 m/s"
lag = "1 s"
position = [["0 m", "0 m", "-0.641 m"]]
"""


def main(*arguments: str) -> None:
    """Print what each method gives by default beside what was published."""
    if not arguments:
        print("name the folder of the data: bench real FOLDER")
        return
    source = Path(arguments[0])
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        attas, hfb = _write_aircraft(folder)
        pitch = [_write_attas(source, folder, name, 0) for name in ("fAttasElv1", "fAttasElv2")]
        _print_attas("ATTAS, short period", pitch, attas, "lon", PUBLISHED_PITCH)
        lateral = [
            _write_attas(source, folder, name, half)
            for name in ("fAttasAilRud1", "fAttasAilRud2")
            for half in (0, 1)
        ]
        _print_attas("ATTAS, lateral", lateral, attas, "lat", PUBLISHED_LATERAL)
        structure = {
            "ml": _run(
                lateral, attas, "lat", "ml", joint=True, instruments="file",
                states=("p", "r"), responses=("p", "r"),
            )
        }  # fmt: skip
        rows = {method: _published_form(one, "lat") for method, one in structure.items()}
        _print_table("ATTAS, lateral, published structure", structure, rows, PUBLISHED_LATERAL)
        _print_hfb(_write_hfb(source, folder), hfb)
        print_uav(source, folder)


def _write_aircraft(folder: Path) -> tuple[Path, Path]:
    attas, hfb = folder / "attas.toml", folder / "hfb.toml"
    attas.write_text(_AIRCRAFT.format(name="ATTAS", mass=17631, Ixz=ATTAS_IXZ, **ATTAS))
    sizes = {"S": 30.1, "b": 14.49, "c": 2.43, "Ixx": 30000, "Iyy": 91389, "Izz": 115000, "Ixz": 0}
    hfb.write_text(_AIRCRAFT.format(name="HFB-320", mass=7472, **sizes) + _HFB_THRUST)
    return attas, hfb


def _write_attas(source: Path, folder: Path, name: str, half: int) -> Path:
    """Write a record as a flight; joined records in halves, parted where time jumps."""
    data = loadmat(source / f"{name}.mat")[name]
    jumps = np.flatnonzero(np.diff(data[:, 0]) > 1.0) + 1
    data = np.split(data, jumps)[half]
    columns = {heading: data[:, number - 1] for heading, number in ATTAS_COLUMNS.items()}
    columns["an [m/s^2]"] = -data[:, 3]
    columns["da [deg]"] = 0.5 * (data[:, 28] - data[:, 27])
    columns["thrust [N]"] = data[:, 36] + data[:, 37]
    columns["qbar [Pa]"] = 0.5 * data[:, 33] * data[:, 14] ** 2
    return _write_csv(folder / f"{name}-{half + 1}.csv", columns)


def _write_hfb(source: Path, folder: Path) -> Path:
    data = np.loadtxt(source / "hfb320_1_10.asc")
    columns = {heading: data[:, number - 1] for heading, number in HFB_COLUMNS.items()}
    columns["an [m/s^2]"] = -data[:, 10]
    return _write_csv(folder / "hfb.csv", columns)


def _write_csv(path: Path, columns: dict[str, FloatArray]) -> Path:
    columns["time [s]"] = columns["time [s]"] - columns["time [s]"][0]
    header = ",".join(columns)
    np.savetxt(path, np.column_stack(list(columns.values())), delimiter=",", header=header,
               comments="")  # fmt: skip
    return path


def _run_all_methods(
    flights: Sequence[Path], aircraft: Path, axis: LinearAxis
) -> dict[str, RunOutcome]:
    """Estimate by every method."""
    return {method: _run(flights, aircraft, axis, method) for method in estimation_methods()}


def _run(
    flights: Sequence[Path], aircraft: Path, axis: LinearAxis, method: str, **settings: Any
) -> RunOutcome:
    """Estimate over the whole of each record."""
    windows = []
    for number, path in enumerate(flights, start=1):
        times = np.loadtxt(path, delimiter=",", skiprows=1, usecols=0)
        windows.append(f"{number}:0:{times[-1] - 0.1:.1f}")
    return execute_run(
        RunRequest(
            flights=tuple(flights),
            aircraft=str(aircraft),
            method=method,
            axis=axis,
            maneuver_windows=tuple(windows if len(windows) > 1 else [windows[0][2:]]),
            every_grade=True,
            **settings,
        )
    )


def _print_attas(
    title: str,
    flights: Sequence[Path],
    aircraft: Path,
    axis: LinearAxis,
    published: Mapping[str, float],
) -> None:
    outcomes = _run_all_methods(flights, aircraft, axis)
    rows = {method: _published_form(one, axis) for method, one in outcomes.items()}
    _print_table(title, outcomes, rows, published)


def _published_form(outcome: RunOutcome, axis: LinearAxis) -> dict[str, tuple[float, float]]:
    """Return dimensional derivatives at the vanes, and the modes: value, bound."""
    forms = forms_of_means(outcome.result, _means(outcome)).get(axis)
    for joint in outcome.result.joint:
        forms = forms_of_estimate(outcome.result, joint).get(axis, forms)
    if forms is None:
        return {}
    found = {name: (one.value, one.std) for name, one in forms.values["dimensional-vane"].items()}
    for one in forms.modes:
        found[f"{one.mode.name}, rad/s"] = (one.mode.frequency, one.frequency_std)
        found[f"{one.mode.name}, damping"] = (one.mode.damping, one.damping_std)
    return found


def _means(outcome: RunOutcome) -> dict[str, CampaignValue]:
    """Return the means with the bounds given to a person: noise, systematic, disagreement."""
    return {name: one.value for name, one in outcome.summary.derivatives.items()}


def _print_table(
    title: str,
    outcomes: Mapping[str, RunOutcome],
    rows: Mapping[str, Mapping[str, tuple[float, float]]],
    published: Mapping[str, float],
) -> None:
    print(f"\n{title}: value (difference from published in percent, in bounds)")
    for one in next(iter(outcomes.values())).instruments:
        print(f"  {one.text}")
    print(f"  {'':21}{'published':>10}" + "".join(f"{method:>26}" for method in rows))
    for name, value in published.items():
        cells = ""
        for found in rows.values():
            mean, std = found.get(name, (np.nan, np.nan))
            off = f"({100.0 * (mean / value - 1.0):+.1f} %, {abs(mean - value) / std:.1f})"
            cells += f"{mean:10.4f} {off:>15}" if np.isfinite(mean) else f"{'unknown':>26}"
        print(f"  {name:21}{value:10.4f}{cells}")


def _print_hfb(flight: Path, aircraft: Path) -> None:
    outcomes = _run_all_methods([flight], aircraft, "lon")
    rows = {}
    for method, outcome in outcomes.items():
        values = _means(outcome)
        rows[method] = {name: (one.mean, one.std) for name, one in values.items()}
        forms = forms_of_means(outcome.result, values)
        if "lon" in forms:
            lift = forms["lon"].values["CL-CD"]
            rows[method] |= {name: (one.value, one.std) for name, one in lift.items()}
    _print_table("HFB-320", outcomes, rows, PUBLISHED_HFB)
