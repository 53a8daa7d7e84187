"""Fourteen hand-flown maneuvers of a 3.3 kg UAV: what is detected, and whether like ones agree.

The folder holds ``ProcessedData_*.mat`` of the project UAV-OAT-controlo (or the same without that
prefix), one struct for each maneuver, named by its surface; they are not part of this project.
Controls are commands of the autopilot, 4500 of 45 deg here: their true scale moves the control
derivatives and nothing else. Wing and inertia are assumed, too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from pathlib import Path

import numpy as np
from scipy.io import loadmat

from gsapp.flight.maneuvers import DetectedManeuver, collect_maneuvers
from gsapp.identification.maneuver import open_flight
from gsapp.identification.methods import estimation_methods
from gsapp.identification.runs.request import RunRequest
from gsapp.identification.runs.run_execution import execute_run
from gsapp.quantities.constants import DEGREE

AIRCRAFT = """name = "UAV"
[geometry]
wing_area = "0.6 m^2"
span = "2 m"
chord = "0.3 m"
[mass]
mass = "3.3 kg"
ixx = "0.25 kg m^2"
iyy = "0.25 kg m^2"
izz = "0.4 kg m^2"
ixz = "0 kg m^2"
"""
COLUMNS = {
    "time [s]": "time", "phi [deg]": "roll", "theta [deg]": "pitch", "psi [deg]": "yaw",
    "altitude [m]": "h", "alpha [deg]": "AoA", "beta [deg]": "beta", "V [m/s]": "Va",
    "p [rad/s]": "p", "q [rad/s]": "q", "r [rad/s]": "r", "ax [m/s^2]": "ax", "ay [m/s^2]": "ay",
    "throttle [%]": "delta_t",
}  # fmt: skip
DEGREES_PER_COUNT = 0.01
SURFACES = {"ail": "da", "el": "de", "rud": "dr"}
# As read from plots: four steps to alternate sides in all of them, the first two clearly longer
# than the last two (3-2-1-1), but for two with 1.1-1.6-1.1-0.9 s and, cut off at the front,
# 1.2-1.6-1.3-0.5 s, labeled multistep after the first detection. Half of peak to peak, counts.
MULTISTEPS = {("2022_05_07_11_13_57", "el_1"), ("2022_05_07_11_13_57", "el_3")}
AMPLITUDES = {("2022_05_07_11_13_57", "rud_1"): 1339, ("2023_02_01_14_21_28", "el_1"): 901}
USUAL_AMPLITUDE = 2254
DERIVATIVES = {
    "lon": ("CN_alpha", "Cm_alpha", "Cm_q", "Cm_de"),
    "lat": ("CY_beta", "Cl_beta", "Cl_p", "Cl_da", "Cn_beta", "Cn_r", "Cn_da", "Cl_dr", "Cn_dr"),
}


def print_uav(source: Path, folder: Path) -> None:
    """Print the table of the segments, then that of the derivatives."""
    aircraft = folder / "uav.toml"
    aircraft.write_text(AIRCRAFT)
    segments = _write_segments(source, folder)
    if not segments:
        print("\nno segments of the UAV in the folder")
        return
    print("\nUAV: segment, surface, kind, amplitude as detected (deg), and whether as seen by eye")
    right = 0
    for key, path in segments.items():
        opened = open_flight(path, aircraft=str(aircraft))
        found = collect_maneuvers(opened.flight, opened.aircraft).maneuvers
        verdict = _compare(key, found)
        right += verdict == "right"
        text = ", ".join(
            f"{'+'.join(one.inputs)} {one.kind} {(one.amplitude or 0.0) / DEGREE:.1f} ({one.grade})"
            for one in found
        )
        print(f"  {'/'.join(key):27} {text:32} {verdict}")
    print(f"  {right} of {len(segments)} right")
    for year in dict.fromkeys(stem[:4] for stem, _ in segments):
        for prefix, axis in (("el", "lon"), ("ail", "lat"), ("rud", "lat")):
            like = [
                path
                for (stem, name), path in segments.items()
                if stem[:4] == year and name.startswith(prefix)
            ]
            if like:
                _print_derivatives(f"UAV {year}, {prefix}", like, aircraft, axis)


def _write_segments(source: Path, folder: Path) -> dict[tuple[str, str], Path]:
    """Write each segment as a flight; return them by file and struct."""
    written = {}
    for file in sorted(source.glob("*20[0-9][0-9]_*.mat")):
        stem = file.stem.removeprefix("ProcessedData_")
        for name, one in loadmat(file, squeeze_me=True, struct_as_record=False).items():
            if name.startswith("__") or name.partition("_")[0] not in SURFACES:
                continue
            columns = {heading: getattr(one, field) for heading, field in COLUMNS.items()}
            columns["an [m/s^2]"] = -one.az
            # Trailing edge down and to the left are positive; the autopilot pitches up and turns
            # right with positive commands.
            for surface, sign, field in (("da", 1, "a"), ("de", -1, "e"), ("dr", -1, "r")):
                counts = getattr(one, f"delta_{field}")
                columns[f"{surface}_command [deg]"] = sign * DEGREES_PER_COUNT * counts
            path = folder / f"{stem}-{name}.csv"
            np.savetxt(path, np.column_stack(list(columns.values())), delimiter=",",
                       header=",".join(columns), comments="")  # fmt: skip
            written[stem, name] = path
    return written


def _compare(key: tuple[str, str], found: Sequence[DetectedManeuver]) -> str:
    surface = SURFACES[key[1].partition("_")[0]]
    kind = "multistep" if key in MULTISTEPS else "3-2-1-1"
    amplitude = DEGREES_PER_COUNT * AMPLITUDES.get(key, USUAL_AMPLITUDE) * DEGREE
    if len(found) != 1:
        return f"{len(found)} maneuvers"
    (one,) = found
    wrong = []
    if one.inputs != (surface,):
        wrong.append(f"surface is {surface}")
    if one.kind != kind:
        wrong.append(f"kind is {kind}")
    if abs((one.amplitude or 0.0) / amplitude - 1.0) > 0.05:
        wrong.append(f"amplitude is {amplitude / DEGREE:.1f}")
    return "; ".join(wrong) or "right"


def _print_derivatives(title: str, flights: Sequence[Path], aircraft: Path, axis: str) -> None:
    rows: dict[str, dict[str, list[tuple[float, float]]]] = {}
    given: dict[str, dict[str, list[tuple[float, float]]]] = {}
    for method in estimation_methods():
        request = RunRequest(
            flights=tuple(flights), aircraft=str(aircraft), method=method, axis=axis,
            every_grade=True,
        )  # fmt: skip
        summaries = execute_run(request).summary.derivatives
        found = {name: summaries[name] for name in DERIVATIVES[axis] if name in summaries}
        rows[method] = {
            name: [(point.value, point.std) for point in one.points] for name, one in found.items()
        }
        given[method] = {
            name: [(point.value, one.bound(point)) for point in one.points]
            for name, one in found.items()
        }
    print(f"\n{title}: values +- noise of each segment; worst pair in joint bounds")
    for name in DERIVATIVES[axis]:
        for method, found_rows in rows.items():
            if name in found_rows:
                print(f"  {name:9}{method:4}{_row_text(found_rows[name])}")
    for method in rows:
        parts = [
            f"{told} {share}"
            for told, values in (("noise", rows[method]), ("bounds", given[method]))
            if (share := _share_text(values))
        ]
        if parts:
            print(f"  {method}: pairs within two joint {'; '.join(parts)}")


def _row_text(values: Sequence[tuple[float, float]]) -> str:
    cells = " ".join(f"{value:8.3f} +-{std:6.3f}" for value, std in values)
    return f"{cells}  {max(_distances(values)):4.1f}" if len(values) > 1 else cells


def _distances(values: Sequence[tuple[float, float]]) -> list[float]:
    """Return the difference of each pair of values (value, bound) in joint bounds."""
    return [
        abs(one[0] - other[0]) / float(np.hypot(one[1], other[1]))
        for one, other in combinations(values, 2)
    ]


def _share_text(found: Mapping[str, Sequence[tuple[float, float]]]) -> str:
    pairs = np.array([one for values in found.values() for one in _distances(values)])
    if not pairs.size:
        return ""
    return f"{100.0 * np.mean(pairs <= 2.0):.0f} % of {pairs.size}, worst {pairs.max():.1f}"
