"""Inertias from swings of pendulums that are integrated, masses and arms from weighing."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gsapp.aircraft import load_aircraft
from gsapp.aircraft.ground_tests import MeasuredValue
from gsapp.aircraft.swings import (
    BifilarSwing,
    CompoundSwing,
    bifilar_inertia,
    compound_inertia,
    compute_inertia,
    load_swings,
    parallel_wire_stiffness,
    product_of_inertia,
    slanted_wire_stiffness,
    small_amplitude_period,
)
from gsapp.aircraft.weighing import (
    Support,
    WeighingRecord,
    cg_from_axles,
    cg_from_three_points,
    evaluate_weighing,
)
from gsapp.foundation import FileProblemsError, FlightError
from gsapp.foundation.toml import validate_content
from gsapp.quantities.constants import DEGREE, GRAVITY
from tests.cli.command_kit import gsapp

G = 9.80665
LB, FT, SLUG_FT2 = 4.4482216152605, 0.3048, 1.3558179483314


def swing_period(acceleration, amplitude: float, longest: float) -> float:
    def crossing(_t: float, y: np.ndarray) -> float:
        return float(y[0])

    found = solve_ivp(
        lambda _t, y: (y[1], acceleration(y[0], y[1])), (0.0, longest), (amplitude, 0.0),
        events=crossing, rtol=1e-11, atol=1e-13, max_step=longest / 200,
    )  # fmt: skip
    times = found.t_events[0]
    return float(times[2] - times[0])


def test_compound_pendulum_gives_back_the_inertia_of_an_integrated_swing() -> None:
    """A damped swing of 8 deg of aircraft and cradle, air included, means the Ixx put in."""
    ixx, weight, cradle, arm, cradle_arm = 5.20 * SLUG_FT2, 46.7 * LB, 12.0 * LB, 1.50, 1.62
    cradle_inertia, air, zeta, amplitude = 9.0, 0.15, 0.01, math.radians(8.0)
    about_pivot = ixx + (weight / G + air) * arm**2

    def period(inertia: float, moment: float) -> float:
        rate = math.sqrt(moment / inertia)
        return swing_period(
            lambda angle, speed: -(rate**2) * math.sin(angle) - 2 * zeta * rate * speed,
            amplitude, 12.0,
        )  # fmt: skip

    both = period(about_pivot + cradle_inertia, weight * arm + cradle * cradle_arm)
    alone = period(cradle_inertia, cradle * cradle_arm)
    mean = amplitude * math.exp(-zeta * 2.0 * math.pi * 0.75)
    found = compound_inertia(
        CompoundSwing(
            period=small_amplitude_period(both, mean, zeta),
            cradle_period=small_amplitude_period(alone, mean, zeta),
            aircraft_weight=weight, cradle_weight=cradle, aircraft_arm=arm,
            cradle_arm=cradle_arm, distance=arm, air_mass=air,
        )
    )  # fmt: skip
    assert found.value == pytest.approx(ixx, rel=2e-3)
    assert found.cradle == pytest.approx(cradle_inertia, rel=2e-4)


@pytest.mark.parametrize("slanted", [False, True])
def test_bifilar_pendulum_gives_back_the_inertia_of_an_integrated_swing(slanted: bool) -> None:
    """The height that two wires lift the aircraft by is its potential; nothing is linearized."""
    izz, cradle_izz, weight, cradle, length = 6.97 * SLUG_FT2, 2.1, 46.7 * LB, 12.0 * LB, 2.0
    upper, lower = (0.9, 1.1) if slanted else (1.0, 1.0)
    height = math.sqrt(length**2 - ((upper - lower) / 2) ** 2)

    def drop(angle: float) -> float:
        square = (upper**2 + lower**2 - 2 * upper * lower * math.cos(angle)) / 4.0
        return math.sqrt(length**2 - square)

    def period(inertia: float, load: float) -> float:
        def moment(angle: float) -> float:
            return -load * (drop(angle - 1e-5) - drop(angle + 1e-5)) / 2e-5

        return swing_period(lambda angle, _: moment(angle) / inertia, 0.02, 20.0)

    stiffness = (
        slanted_wire_stiffness(height, upper, lower)
        if slanted
        else parallel_wire_stiffness(length, 0.5, 0.5)
    )
    found = bifilar_inertia(
        BifilarSwing(
            period=period(izz + cradle_izz, weight + cradle),
            cradle_period=period(cradle_izz, cradle),
            aircraft_weight=weight, cradle_weight=cradle, stiffness=stiffness,
        )
    )  # fmt: skip
    assert found.value == pytest.approx(izz, rel=1e-3)


def test_offsets_of_the_bifilar_pendulum_are_taken_off() -> None:
    weight, cradle, apart = 46.7 * LB, 12.0 * LB, 0.05
    e_aircraft = apart * cradle / (weight + cradle)
    e_cradle = apart - e_aircraft
    total = 9.45 + 2.1 + (weight * e_aircraft**2 + cradle * e_cradle**2) / G
    stiffness = parallel_wire_stiffness(2.0, 0.5, 0.5)
    found = bifilar_inertia(
        BifilarSwing(
            period=2 * math.pi * math.sqrt(total / ((weight + cradle) * stiffness)),
            cradle_period=2 * math.pi * math.sqrt(2.1 / (cradle * stiffness)),
            aircraft_weight=weight, cradle_weight=cradle, stiffness=stiffness,
            aircraft_offset=e_aircraft, cradle_offset=e_cradle,
        )
    )  # fmt: skip
    assert found.value == pytest.approx(9.45, rel=1e-12)


@pytest.mark.parametrize("nose_up", [0.3, -0.5])
def test_product_of_inertia_from_a_tilted_swing(nose_up: float) -> None:
    ixx, izz, ixz = 7.05, 9.45, 0.38
    tensor = np.array([[ixx, -ixz], [-ixz, izz]])
    # With the nose up the vertical lies toward the tail in body axes: (-sin, cos) in x, z.
    down = np.array([-math.sin(nose_up), math.cos(nose_up)])
    vertical = float(down @ tensor @ down)
    assert product_of_inertia(vertical, ixx, izz, nose_up) == pytest.approx(ixz, rel=1e-10)


FILE = """
name = "B777"
air_density = "1.19 kg/m^3"

[aircraft]
weight = ["46.7 lb", "0.05 lb"]
volume = "1.0 ft^3"

[cradle]
weight = ["12 lb", "0.02 lb"]

[x]
times = ["25.10 s", "25.15 s", "25.06 s", "25.12 s"]
cradle_times = ["25.60 s", "25.66 s", "25.63 s"]
cycles = 10
amplitude = "5 deg"
pivot_to_cg = ["4.9 ft", "0.01 ft"]
pivot_to_cradle_cg = ["5.2 ft", "0.02 ft"]
"""


def written(folder: Path, text: str = FILE) -> Path:
    path = folder / "swings.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_uncertainty_is_that_of_a_monte_carlo(tmp_path: Path) -> None:
    """Linear propagation against 4,000 draws of every stated quantity."""
    swings = load_swings(written(tmp_path))
    found = compute_inertia(swings)
    rng = np.random.default_rng(7)
    x = swings.x
    drawn = []
    for _ in range(4000):
        weight, cradle, arm, cradle_arm, period, alone = (
            one.value + one.std * rng.standard_normal()
            for one in (
                swings.aircraft.weight, swings.cradle.weight, x.pivot_to_cg, x.pivot_to_cradle_cg,
                x.period, x.cradle_period,
            )
        )  # fmt: skip
        drawn.append(
            compound_inertia(
                CompoundSwing(
                    period, alone, weight, cradle, arm, cradle_arm, arm,
                    swings.air_density * swings.aircraft.volume,
                )
            ).value
        )  # fmt: skip
    assert found.values["ixx"].std == pytest.approx(float(np.std(drawn)), rel=0.06)
    assert found.values["ixx"].value == pytest.approx(float(np.mean(drawn)), rel=0.02)
    assert sum(found.shares["ixx"].values()) == pytest.approx(1.0)


def test_the_published_inertias_get_a_warning(tmp_path: Path) -> None:
    """Swings that mean the source's Ixx, Iyy, Izz put 1.26 ft rms of height into the aircraft."""
    weight = 46.7 * LB
    published = {"ixx": 5.20, "iyy": 6.34, "izz": 6.97}
    text = '[aircraft]\nweight = "46.7 lb"\ndepth = "1.6 ft"\n'
    for table, name in (("x", "ixx"), ("y", "iyy")):
        about_pivot = published[name] * SLUG_FT2 + weight / G * 1.5**2
        time = 20 * math.pi * math.sqrt(about_pivot / (weight * 1.5))
        text += f'[{table}]\ntimes = ["{time!r} s"]\ncycles = 10\npivot_to_cg = "1.5 m"\n'
    time = 20 * math.pi * math.sqrt(published["izz"] * SLUG_FT2 / (weight * 0.125))
    text += (
        f'[z]\ntimes = ["{time!r} s"]\ncycles = 10\nwire_length = "2 m"\n'
        'first_distance = "0.5 m"\nsecond_distance = "0.5 m"\n'
    )
    found = compute_inertia(load_swings(written(tmp_path, text)))
    for name, value in published.items():
        assert found.values[name].value == pytest.approx(value * SLUG_FT2, rel=1e-9)
    assert any("0.38 m (rms)" in warning for warning in found.warnings)


def test_mistakes_of_a_file_come_all_at_once(tmp_path: Path) -> None:
    text = FILE.replace('"4.9 ft"', '"4.9 kg"').replace("cycles = 10", "cycles = 0\nperiod = 3")
    with pytest.raises(FileProblemsError) as caught:
        load_swings(written(tmp_path, text))
    message = str(caught.value)
    assert "x.pivot_to_cg" in message
    assert "x.cycles" in message
    assert "x.period" in message


def test_a_cradle_that_was_not_swung_alone_is_refused(tmp_path: Path) -> None:
    """Its inertia would silently count as the aircraft's."""
    text = "\n".join(line for line in FILE.splitlines() if "cradle_times" not in line)
    with pytest.raises(FileProblemsError, match="swung alone"):
        load_swings(written(tmp_path, text))


def test_command_prints_a_table_and_writes_json(tmp_path: Path) -> None:
    """The command from outside: table for people, SI for programs, exit codes."""
    out = tmp_path / "inertia.json"
    done = gsapp("inertia", written(tmp_path), "--json", out)
    assert done.returncode == 0, done.stderr
    assert "ixx" in done.stdout
    content = json.loads(out.read_text(encoding="utf-8"))
    expected = compute_inertia(load_swings(tmp_path / "swings.toml")).values["ixx"]
    assert content["inertia"]["ixx"]["value"] == pytest.approx(expected.value)
    failed = gsapp("inertia", tmp_path / "none.toml")
    assert failed.returncode == 1
    assert "cannot be read" in failed.stderr


B777 = load_aircraft("b777")
WHEELS = {name: np.array(place) for name, place in {**B777.axles}.items()}


def loads_of(mass: float, cg: np.ndarray, pitch: float = 0.0, bank: float = 0.0) -> dict:
    """Return what scales show (N): forces and moments about the origin balance, solved whole.

    Independent of the formulas under test: three unknown vertical forces, three equations.
    """
    # Up in body axes for a small pitch and bank, one after the other.
    up = np.array(
        [math.sin(pitch), -math.cos(pitch) * math.sin(bank), -math.cos(pitch) * math.cos(bank)]
    )
    names = list(WHEELS)
    columns = [np.concatenate((np.cross(WHEELS[name], up), [1.0])) for name in names]
    wanted = np.concatenate((np.cross(cg, up), [1.0])) * mass * GRAVITY
    forces, *_ = np.linalg.lstsq(np.array(columns).T, wanted, rcond=None)
    return dict(zip(names, forces.tolist(), strict=True))


def supports(loads: dict[str, float], std: float = 0.1) -> list[Support]:
    return [
        Support(name=name, position=tuple(WHEELS[name]), load=MeasuredValue(load, std))
        for name, load in loads.items()
    ]


@pytest.mark.parametrize("tilt", [(0.0, 0.0), (3.0 * DEGREE, 0.0), (0.0, -2.0 * DEGREE)])
def test_three_wheels_give_back_mass_and_place(tilt: tuple[float, float]) -> None:
    pitch, bank = tilt
    cg = np.array([0.02, -0.007, 0.03])
    found = cg_from_three_points(
        *supports(loads_of(21.0, cg, pitch, bank)),
        pitch=MeasuredValue(pitch, 0.01),
        bank=MeasuredValue(bank, 0.01),
        height=MeasuredValue(0.03),
    )
    assert found.mass.value == pytest.approx(21.0, rel=1e-9)
    # One rotation after the other: the second sees the cosine of the first.
    assert found.cg[:2] == pytest.approx(cg[:2], abs=2e-6)
    assert found.measured == (True, True, False)
    assert sum(found.shares.values()) == pytest.approx(1.0)


def test_two_axles_give_the_place_along_x_alone() -> None:
    loads = loads_of(20.0, np.array([-0.015, 0.0, 0.0]))
    main = 0.5 * (WHEELS["left"] + WHEELS["right"])
    found = cg_from_axles(
        Support(
            name="nose", position=tuple(WHEELS["nose"]), load=MeasuredValue(loads["nose"], 0.1)
        ),
        Support(
            name="main",
            position=tuple(main),
            load=MeasuredValue(loads["left"] + loads["right"], 0.2),
        ),
    )
    assert found.cg == pytest.approx((-0.015, 0.0, 0.0), abs=1e-9)
    assert found.measured == (True, False, False)
    assert math.isnan(found.cg_std[1])


def test_the_stated_uncertainty_is_the_scatter() -> None:
    random = np.random.default_rng(4)
    cg, pitch_std, place_std, load_std = np.array([0.01, 0.004, 0.0]), 0.009, 0.003, 0.3
    found, masses = [], []
    for _ in range(500):
        pitch, bank = pitch_std * random.standard_normal(2)
        loads = loads_of(21.0, cg, pitch, bank)
        stands = [
            Support(
                name=name,
                position=tuple(WHEELS[name] + place_std * random.standard_normal(3)),
                load=MeasuredValue(load + load_std * random.standard_normal(), load_std),
                position_std=place_std,
            )
            for name, load in loads.items()
        ]
        level = MeasuredValue(0.0, pitch_std)
        one = cg_from_three_points(*stands, pitch=level, bank=level)
        found.append(one.cg)
        masses.append(one.mass.value)
    scatter = np.std(found, axis=0)  # itself known to 3 %
    assert one.cg_std[:2] == pytest.approx(scatter[:2], rel=0.1)
    assert one.mass.std == pytest.approx(np.std(masses), rel=0.1)
    assert np.mean(found, axis=0)[:2] == pytest.approx(cg[:2], abs=5e-4)


def test_a_card_takes_the_axles_of_the_aircraft() -> None:
    whole = WeighingRecord.model_validate(
        {"loads": {"nose": "4.2 lb", "left": "21.2 lb", "right": "21.1 lb"}}
    )
    axles = WeighingRecord.model_validate({"loads": {"main": "42.3 lb", "nose": "4.2 lb"}})
    one, two = evaluate_weighing(whole, B777.axles), evaluate_weighing(axles, B777.axles)
    assert one.mass.value == pytest.approx(46.5 * 0.45359237)
    assert one.cg[0] == pytest.approx(two.cg[0], abs=1e-12)
    assert one.cg[0] == pytest.approx((4.2 * 2.62 - 42.3 * 0.26) / 46.5 * 0.3048)
    # The heavier side is the left one.
    assert one.cg[1] < 0.0
    measured = evaluate_weighing(
        WeighingRecord.model_validate(
            {"loads": {"nose": ["4.2 lb", "0.3 lb"], "left": "21.2 lb", "right": "21.1 lb"}}
        ),
        B777.axles,
    )
    assert measured.cg_std[0] > 1.5 * one.cg_std[0]


def test_nonsense_is_told_in_a_sentence() -> None:
    level = supports(loads_of(20.0, np.zeros(3)))
    with pytest.raises(FlightError, match="'left' shows -3 N"):
        cg_from_axles(
            level[0], Support(name="left", position=(0.0, 0.0, 0.0), load=MeasuredValue(-3.0))
        )
    same = Support(name="twin", position=level[0].position, load=MeasuredValue(20.0))
    with pytest.raises(FlightError, match="same x position"):
        cg_from_axles(level[0], same)
    with pytest.raises(FlightError, match="in one line"):
        cg_from_three_points(
            level[1],
            level[2],
            Support(name="skid", position=(-0.08, 0.1, 0.3), load=MeasuredValue(9.0)),
        )
    record = WeighingRecord.model_validate({"loads": {"tail": "2 lb", "main": "44 lb"}})
    with pytest.raises(FlightError, match=r"weighing\.loads\.tail"):
        evaluate_weighing(record, B777.axles)
    with pytest.raises(ValueError, match=r"(?s)loads: nose.*pitch"):
        validate_content(
            "flight.toml",
            {"loads": {"nose": "0 lb", "main": "9 lb"}, "pitch": "40 deg"},
            WeighingRecord,
        )
