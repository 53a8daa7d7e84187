"""The flight card: what it holds, the slips it catches, and what it makes of the aircraft."""

from typing import Any

import numpy as np
import pytest

from gsapp.aircraft import load_aircraft
from gsapp.aircraft.aircraft_loader import SHIPPED_AIRCRAFT
from gsapp.decoding.channel_map import SHIPPED_CHANNEL_MAPS as MAPS
from gsapp.flight.flown_aircraft import apply_flight_info
from gsapp.flight.folder import FlightFolder
from gsapp.flight.info import FlightInfo
from gsapp.flight.info_checks import check_flight_info
from gsapp.flight.maneuver_settings import ManeuverSettings
from gsapp.flight.toml_document import FlightInfoFile
from gsapp.foundation import FileProblemsError, FlightError
from gsapp.foundation.toml import validate_content
from gsapp.identification.maneuver import (
    FlightWithManeuvers,
    open_flights_with_maneuvers,
)
from tests.flight.box_kit import box_tlog

B777 = load_aircraft("b777")
LB, FT = 0.45359237, 0.3048

WHOLE: dict[str, Any] = {
    "name": "Flight 17",
    "date": "2026-05-12T09:30:00-04:00",
    "aircraft": "b777",
    "takeoff_weight": "46.82 lb",
    "landing_weight": "44.5 lb",
    "fuel": "2.7 lb",
    "fuel_end": "0.4 lb",
    "flap": "10 deg",
    "weighing": {
        "loads": {"nose": ["4.2 lb", "0.02 lb"], "left": "21.3 lb", "right": "21.32 lb"},
        "axles": {"nose": ["2.60 ft", "0 ft", "1.15 ft"]},
        "pitch": ["0.4 deg", "0.2 deg"],
        "fuel": "2.7 lb",
        "scale_error": "0.03 lb",
    },
    "loading": [{"what": "nose ballast", "mass": "0.2 lb", "position": ["3 ft", "0 ft", "0 ft"]}],
    "weather": {"temperature": "71 degF", "pressure": "28.9 inHg", "wind_speed": "6 kt"},
    "transmitter": {
        "model": "nine channels, memory 2",
        "rate": "high",
        "dual_rates": {"elevator": {"high": "100 %", "low": "60 %", "expo": "20 %"}},
        "mixers": [{"source": "aileron", "target": "rudder", "share": "15 %"}],
        "trims": {"elevator": "4 %", "throttle": "-2 %"},
    },
    "crew": {"pilot": "R. Roe"},
    "pilot_comments": "needs right rudder",
}


def card(**values: Any) -> FlightInfo:
    return validate_content("flight.toml", values, FlightInfo)


def doubts(**values: Any) -> dict[str, str]:
    return {one.field: one.text for one in check_flight_info(card(**values), B777)}


def test_the_whole_card_survives_its_file(tmp_path) -> None:
    info = card(**WHOLE)
    folder = FlightFolder.create(tmp_path / "f", info)
    back = folder.info()
    assert back.model_dump(exclude={"versions"}) == info.model_dump(exclude={"versions"})
    text = folder.info_file.read_text()
    for absent in ("bank", "axle_error", "notes", "gear", "low_red"):
        assert absent not in text
    assert back.weighing.loads["left"].std == 0.0
    assert back.transmitter.dual_rates["elevator"].low == pytest.approx(0.6)
    assert check_flight_info(back, B777) == ()


def test_a_card_whose_folder_is_gone_is_neither_emptied_nor_made_anew(tmp_path) -> None:
    """A folder in place of a disk that was pulled out would be hidden when it comes back."""
    folder = FlightFolder(path=tmp_path / "flight")
    card = FlightInfoFile(folder)
    card.change({("crew", "pilot"): "Bob"})
    card.save()
    folder.path.rename(tmp_path / "away")
    assert not card.reload_if_changed()
    assert card.value(("crew", "pilot")) == "Bob"
    card.change({("crew", "engineer"): "Eve"})
    with pytest.raises(FlightError, match="no longer exists"):
        card.save()
    assert not folder.path.exists()
    (tmp_path / "away").rename(folder.path)
    card.save()
    assert FlightInfoFile(folder).content == {"crew": {"pilot": "Bob", "engineer": "Eve"}}


def test_every_mistake_of_a_card_is_told_at_once() -> None:
    with pytest.raises(FileProblemsError) as caught:
        card(
            fuel_end="3 ft",
            flapp="10 deg",
            weighing={"loads": {"nose": "4 lb"}},
            transmitter={
                "dual_rates": {"elevator": {"high": "50 %", "low": "60 %"}, "stick": {}},
                "mixers": [{"source": "rudder", "target": "rudder", "share": "10 %"}],
            },
            loading=[{"what": "x", "mass": "1 lb"}],
        )
    text = str(caught.value)
    for part in (
        "fuel_end: 'ft' is not a unit of mass",
        "flapp: is not a known key; did you mean 'flap'?",
        "weighing.loads: holds 1 readings",
        "transmitter.dual_rates.elevator: needs 0 % < low <= high",
        "transmitter.dual_rates.stick",
        "transmitter.mixers[0]: mixes a lever with itself",
        "loading[0].position: is missing",
    ):
        assert part in text


def test_weights_of_the_table_pass_and_slips_do_not() -> None:
    """Weights of table 6.2.3 are all right; each slip is told with what was probably meant."""
    for pounds in (45.92, 46.22, 46.32, 46.42, 46.60, 46.82, 47.12):
        assert doubts(takeoff_weight=f"{pounds} lb", landing_weight=f"{pounds - 2.3:.2f} lb") == {}
    slips = {
        "takeoff_weight": (
            {"takeoff_weight": "21.1 lb"},
            "was '21.1 kg' meant instead of '21.1 lb'",
        ),
        "fuel": ({"fuel": "2.7 kg"}, "was '2.7 lb' meant instead of '2.7 kg'"),
        "fuel_end": ({"fuel": "2 lb", "fuel_end": "2.2 lb"}, "swap the two"),
        "landing_weight": ({"takeoff_weight": "46 lb", "landing_weight": "47 lb"}, "heavier"),
        "flap": ({"flap": "60 deg"}, "beyond its travel"),
        "weather.temperature": (
            {"weather": {"temperature": "72 degC"}},
            "was '72 degF' meant instead of '72 degC'",
        ),
        "weather.pressure": (
            {"weather": {"pressure": "28.9 hPa"}},
            "was '28.9 inHg' meant instead of '28.9 hPa'",
        ),
        "weighing": (
            {"weighing": {"loads": {"nose": "21 lb", "left": "4.2 lb", "right": "21 lb"}}},
            "assignment of readings to wheels",
        ),
    }
    for field, (values, text) in slips.items():
        found = doubts(**values)
        assert list(found) == [field]
        assert text in found[field]
    (metric,) = check_flight_info(card(takeoff_weight="46.6 kg"), B777, system="SI")
    assert "46.6 kg" in metric.text
    heavy = doubts(takeoff_weight="46.6 kg")["takeoff_weight"]
    assert "'46.6 lb'" in heavy
    short = doubts(fuel="1 lb", takeoff_weight="46 lb", landing_weight="44 lb")
    assert "1.00 lb" in short["landing_weight"]
    scales = doubts(
        takeoff_weight="46.6 lb",
        weighing={"loads": {"nose": "4.2 lb", "left": "19 lb", "right": "19.1 lb"}, "fuel": "0 lb"},
        fuel="2.7 lb",
    )
    assert "45.0 lb" in scales["weighing"]


def cloud_of(mass: float, inertia: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    values, axes = np.linalg.eigh(inertia)
    # A point mass pair on each principal axis: sum of squares along it.
    along = 0.5 * (values.sum() - 2.0 * values)
    masses = np.full(6, mass / 6.0)
    arms = np.sqrt(along / (2.0 * masses[0]))
    places = np.concatenate([axes.T * arms[:, None], -axes.T * arms[:, None]])
    return masses, places


def test_loading_and_fuel_move_cg_and_inertia_as_points_do() -> None:
    """Against a cloud of point masses with the loads among them, summed without any theorem."""
    file = B777.model_copy(
        update={"mass": B777.mass.model_copy(update={"fuel_position": (-0.2, 0.0, 0.1)})}
    )
    info = card(
        fuel="1.5 lb",
        loading=[
            {"what": "ballast", "mass": "0.6 lb", "position": ["3 ft", "0 ft", "-0.2 ft"]},
            {"what": "camera out", "mass": "-0.3 lb", "position": ["-1 ft", "0 ft", "0.4 ft"]},
        ],
    )
    found = apply_flight_info(file, info)
    own = file.mass
    tensor = np.array([[own.ixx, 0, -own.ixz], [0, own.iyy, 0], [-own.ixz, 0, own.izz]])
    masses, places = cloud_of(own.mass, tensor)
    masses = np.concatenate((masses, [0.6 * LB, -0.3 * LB, 1.5 * LB - own.fuel]))
    places = np.concatenate(
        (places, [[3 * FT, 0, -0.2 * FT], [-FT, 0, 0.4 * FT], own.fuel_position])
    )
    center = masses @ places / masses.sum()
    apart = places - center
    inertia = sum(
        one * (at @ at * np.eye(3) - np.outer(at, at))
        for one, at in zip(masses, apart, strict=True)
    )
    got = found.aircraft.mass
    assert got.mass == pytest.approx(masses.sum(), rel=1e-12)
    assert found.cg_shift == pytest.approx(center, abs=1e-12)
    assert (got.ixx, got.iyy, got.izz) == pytest.approx(np.diag(inertia), rel=1e-9)
    assert got.ixz == pytest.approx(-inertia[0, 2], rel=1e-9)
    assert got.fuel == pytest.approx(1.5 * LB)
    text = " ".join(found.remarks)
    assert "moves the CG" in text
    assert "Iyy +" in text


def test_a_weighed_cg_moves_instruments_and_engines() -> None:
    info = card(weighing={"loads": {"nose": "4.9 lb", "main": "41.7 lb"}})
    found = apply_flight_info(B777, info)
    x = found.cg_shift[0]
    assert x == pytest.approx((4.9 * 2.62 - 41.7 * 0.26) / 46.6 * FT, rel=1e-6)
    for name in ("alpha_vane", "accelerometer", "air_data"):
        before, after = (getattr(one.sensors, name).position[0] for one in (B777, found.aircraft))
        assert after == pytest.approx(before - x)
    assert found.aircraft.propulsion.position[1] == pytest.approx(
        (B777.propulsion.position[1][0] - x, *B777.propulsion.position[1][1:])
    )
    assert found.aircraft.sensors.surfaces.position == (0.0, 0.0, 0.0)
    assert found.aircraft.axles["left"][0] == pytest.approx(B777.axles["left"][0] - x)
    assert any("mm ahead" in remark for remark in found.remarks)
    # Scales with empty tanks, fuel filled in afterwards at the tank.
    empty = {"loads": {"nose": "4.9 lb", "main": "39.0 lb"}, "fuel": "0 lb"}
    dry = card(weighing=empty, fuel="2.7 lb")
    filled = apply_flight_info(B777, dry)
    assert filled.aircraft.mass.mass == pytest.approx(46.6 * LB)
    assert filled.cg_shift[0] == pytest.approx((4.9 * 2.62 - 39.0 * 0.26) / 46.6 * FT, rel=1e-6)


def test_a_card_that_says_nothing_changes_nothing() -> None:
    assert apply_flight_info(B777, None).aircraft is B777
    assert apply_flight_info(B777, card(name="old", notes="x")).aircraft is B777
    weighed = apply_flight_info(B777, card(takeoff_weight="46.42 lb"))
    assert weighed.aircraft.mass.mass == pytest.approx(46.42 * LB)
    assert weighed.aircraft.mass.iyy == B777.mass.iyy
    assert weighed.cg_shift == (0.0, 0.0, 0.0)
    with pytest.raises(FlightError, match="removes more"):
        apply_flight_info(
            B777,
            card(loading=[{"what": "x", "mass": "-60 lb", "position": ["0 ft", "0 ft", "0 ft"]}]),
        )
    with pytest.raises(FlightError, match="correct weights"):
        apply_flight_info(B777, card(takeoff_weight="1 lb"))


def test_fuel_burned_moves_the_cg_only_where_the_tank_is_off_it() -> None:
    at_cg = apply_flight_info(B777, card(takeoff_weight="46.42 lb"))
    assert at_cg.after_fuel_burn(1.0) is at_cg
    tank = B777.mass.model_copy(update={"fuel_position": (-0.3, 0.0, 0.0)})
    behind = apply_flight_info(
        B777.model_copy(update={"mass": tank}), card(takeoff_weight="46.42 lb")
    )
    later = behind.after_fuel_burn(1.0)
    assert later.aircraft.mass.iyy < behind.aircraft.mass.iyy
    assert later.cg_shift[0] == pytest.approx(0.3 * 1.0 / (46.42 * LB - 1.0), rel=1e-9)
    vanes = [one.aircraft.sensors.alpha_vane.position[0] for one in (behind, later)]
    assert vanes[0] - vanes[1] == pytest.approx(later.cg_shift[0])


def test_the_card_reaches_every_analysis(tmp_path) -> None:
    """Maneuvers cut from a recorded flight have its mass, CG and fuel; without a card, the file's.

    All commands cut their maneuvers here.
    """
    folder = FlightFolder.create(tmp_path / "flight", FlightInfo(name="Box test"))
    folder.tlog_file.write_bytes(box_tlog(lost=set()))
    folder.store_channel_map(MAPS.find("b777"))
    folder.store_aircraft(SHIPPED_AIRCRAFT.find("b777"))

    def cut() -> FlightWithManeuvers:
        return open_flights_with_maneuvers(
            [folder.path], ManeuverSettings(maneuver_windows=("10.5:12.5",))
        )[0]

    (plain,) = cut().maneuvers
    assert plain.cg_shift == (0.0, 0.0, 0.0)
    assert not any("CG" in remark for remark in plain.remarks)
    folder.update_info(
        weighing={"loads": {"nose": "4.9 lb", "main": "41.2 lb"}}, fuel="2.7 lb", fuel_end="2.3 lb"
    )
    flown = cut()
    (weighed,) = flown.maneuvers
    # What the card says was burned went in these three seconds.
    assert 45.7 * LB < weighed.mass < 46.1 * LB
    shift = flown.cg_shift[0]
    assert shift > 0.01
    assert weighed.cg_shift == flown.cg_shift
    places = [one.aircraft.sensors.alpha_vane.position[0] for one in (plain, weighed)]
    assert places[0] - places[1] == pytest.approx(shift)
    # What the instruments lack (the airspeed of this box never moves) no card changes.
    assert set(weighed.remarks) - set(plain.remarks) <= set(flown.remarks)
    assert any("CG by weighing" in remark for remark in flown.remarks)
