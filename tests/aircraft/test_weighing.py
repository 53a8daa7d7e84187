"""Weight and center of gravity from scales, and what they are worth."""

import math

import numpy as np
import pytest

from gsapp.aircraft import load_aircraft
from gsapp.aircraft.ground_tests import MeasuredValue
from gsapp.aircraft.weighing import (
    Support,
    WeighingRecord,
    cg_from_axles,
    cg_from_three_points,
    evaluate_weighing,
)
from gsapp.foundation import FlightError
from gsapp.foundation.toml import validate_content
from gsapp.quantities.constants import DEGREE, GRAVITY

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
