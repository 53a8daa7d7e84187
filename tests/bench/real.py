"""Real flights of ATTAS and HFB-320 as a stranger brings them, beside published derivatives.

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

import numpy as np
from scipy.io import loadmat

from gsapp.identification.campaign import CampaignValue
from gsapp.identification.methods import estimation_methods
from gsapp.identification.runs.request import RunRequest
from gsapp.identification.runs.run_execution import RunOutcome, execute_run
from gsapp.quantities import FloatArray

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
PUBLISHED_PITCH = {"M_alpha": -4.92651, "M_q": -2.00573, "M_de": -7.20806}
PUBLISHED_LATERAL = {
    "L_p": -2.06748, "L_r": 1.02929, "L_da": -6.30585, "L_dr": 1.1452, "L_beta": -3.84437,
    "N_p": -0.18385, "N_r": -0.48560, "N_da": -0.39121, "N_dr": -1.7609, "N_beta": 3.03138,
}  # fmt: skip
PUBLISHED_HFB = {"Cm_alpha": -0.9679, "Cm_q": -34.71, "Cm_de": -1.529}
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
        _print_hfb(_write_hfb(source, folder), hfb)


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


def _run_all_methods(flights: Sequence[Path], aircraft: Path, axis: str) -> dict[str, RunOutcome]:
    """Estimate over the whole of each record, by every method."""
    windows = []
    for number, path in enumerate(flights, start=1):
        times = np.loadtxt(path, delimiter=",", skiprows=1, usecols=0)
        windows.append(f"{number}:0:{times[-1] - 0.1:.1f}")
    return {
        method: execute_run(
            RunRequest(
                flights=tuple(flights), aircraft=str(aircraft), method=method, axis=axis,
                maneuver_windows=tuple(windows if len(windows) > 1 else [windows[0][2:]]),
                every_grade=True,
            )
        )
        for method in estimation_methods()
    }  # fmt: skip


def compute_dimensional_derivatives(
    values: Mapping[str, CampaignValue],
    V: float,
    qbar: float,
    ahead: Mapping[str, float],
) -> dict[str, tuple[float, float]]:
    """Return L, M, N derivatives (value, std) with the flow angles at the vanes as states.

    ``M_q' = M_q + M_alpha x/V``, ``N_r' = N_r - N_beta x/V``, where x is how far a vane is ahead.
    """
    b, c, S = ATTAS["b"], ATTAS["c"], ATTAS["S"]
    Ixx, Iyy, Izz = ATTAS["Ixx"], ATTAS["Iyy"], ATTAS["Izz"]
    determinant = Ixx * Izz - ATTAS_IXZ**2

    def moment(name: str, length: float, term: str) -> FloatArray:
        one = values.get(f"{name}_{term}")
        if one is None:
            return np.full(2, np.nan)
        half = 0.5 * length / V if term in ("p", "q", "r") else 1.0
        return np.array([one.mean, one.std]) * half * qbar * S * length

    found: dict[str, FloatArray] = {}
    for term in ("alpha", "q", "de"):
        found[f"M_{term}"] = moment("Cm", c, term) / Iyy
    for term in ("beta", "p", "r", "da", "dr"):
        L, N = moment("Cl", b, term), moment("Cn", b, term)
        # Bounds add as they are independent; the small product of inertia is neglected in them.
        found[f"L_{term}"] = np.array([Izz * L[0] + ATTAS_IXZ * N[0], Izz * L[1]]) / determinant
        found[f"N_{term}"] = np.array([ATTAS_IXZ * L[0] + Ixx * N[0], Ixx * N[1]]) / determinant
    found["M_q"][0] += found["M_alpha"][0] * ahead.get("alpha", 0.0) / V
    for axis in "LN":
        found[f"{axis}_r"][0] -= found[f"{axis}_beta"][0] * ahead.get("beta", 0.0) / V
    return {name: (float(one[0]), float(one[1])) for name, one in found.items()}


def _print_attas(
    title: str, flights: Sequence[Path], aircraft: Path, axis: str, published: Mapping[str, float]
) -> None:
    outcomes = _run_all_methods(flights, aircraft, axis)
    headings = flights[0].read_text().partition("\n")[0].split(",")
    data = np.concatenate([np.loadtxt(path, delimiter=",", skiprows=1) for path in flights])
    V, qbar = (float(data[:, headings.index(name)].mean()) for name in ("V [m/s]", "qbar [Pa]"))
    rows = {
        method: compute_dimensional_derivatives(
            outcome.result.values,
            V,
            qbar,
            {one.channel: one.value for one in outcome.instruments if one.kind == "position"},
        )
        for method, outcome in outcomes.items()
    }
    _print_table(title, outcomes, rows, published)


def _print_table(
    title: str,
    outcomes: Mapping[str, RunOutcome],
    rows: Mapping[str, Mapping[str, tuple[float, float]]],
    published: Mapping[str, float],
) -> None:
    print(f"\n{title}: value (difference from published in percent, in bounds)")
    for one in next(iter(outcomes.values())).instruments:
        print(f"  {one.text}")
    print(f"  {'':9}{'published':>10}" + "".join(f"{method:>26}" for method in rows))
    for name, value in published.items():
        cells = ""
        for found in rows.values():
            mean, std = found.get(name, (np.nan, np.nan))
            off = f"({100.0 * (mean / value - 1.0):+.1f} %, {abs(mean - value) / std:.1f})"
            cells += f"{mean:10.4f} {off:>15}" if np.isfinite(mean) else f"{'unknown':>26}"
        print(f"  {name:9}{value:10.4f}{cells}")


def _print_hfb(flight: Path, aircraft: Path) -> None:
    outcomes = _run_all_methods([flight], aircraft, "lon")
    rows = {
        method: {name: (one.mean, one.std) for name, one in outcome.result.values.items()}
        for method, outcome in outcomes.items()
    }
    _print_table("HFB-320", outcomes, rows, PUBLISHED_HFB)
