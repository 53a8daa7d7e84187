"""What stands on the flight card, and how the card stands, in words. No Qt."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from gsapp.aircraft import Aircraft
from gsapp.aircraft.weighing import Weighing, evaluate_weighing
from gsapp.flight.info import FlightInfo
from gsapp.flight.info_checks import InfoWarning
from gsapp.flight.toml_document import KeyPath
from gsapp.foundation import FlightError, UnitError
from gsapp.quantities import from_si
from gsapp.quantities.units import normalize_unit, parse_quantity
from gsapp.session.checklist.rule_evaluators import is_card_field_filled
from ui.number_format import MINUS, count_text, number_text, parse_number, unit_text
from ui.translation import QT_TR_NOOP, tr
from ui.window_frame.page_steps import StepStatus

_NUMBER_WITH_UNIT = re.compile(r"\s*([-+]?[0-9.]+(?:[eE][-+]?\d+)?)\s*(.*)")


@dataclass(frozen=True, slots=True, kw_only=True)
class CardField:
    """One value of the card."""

    key: KeyPath
    """Path in the file."""
    name: str
    """On screen."""
    kind: Literal["text", "lines", "number", "whole", "choice"] = "text"
    """``text`` in one line, ``lines`` in several, ``number`` with a unit, ``whole`` number,
    ``choice`` of some."""
    quantity: str = ""
    """Of a number."""
    us: str = ""
    si: str = ""
    """Its units on screen."""
    digits: int = 1
    """After the point, at most, where it is converted."""
    choices: tuple[tuple[str, str], ...] = ()
    """What is written, and its words."""
    group: KeyPath = ()
    """Table that is only valid as a whole; the key itself where it stands alone."""

    @property
    def validated_key(self) -> KeyPath:
        """Return the path of what is checked together with it."""
        return self.group or self.key

    def unit(self, system: str) -> str:
        """Return the unit on screen, as it is written in files."""
        return self.us if system == "US" else self.si

    def unit_label(self, system: str) -> str:
        """Return the unit on screen."""
        return unit_text(self.unit(system))


def _number_field(
    key: str, name: str, quantity: str, us: str, si: str, digits: int = 1, group: str = ""
) -> CardField:
    return CardField(
        key=tuple(key.split(".")), name=name, kind="number", quantity=quantity, us=us, si=si,
        digits=digits, group=tuple(group.split(".")) if group else (),
    )  # fmt: skip


def _text_field(key: str, name: str) -> CardField:
    return CardField(key=tuple(key.split(".")), name=name)


def _multiline_field(key: str, name: str) -> CardField:
    return CardField(key=tuple(key.split(".")), name=name, kind="lines")


FLIGHT_FIELDS = (
    _text_field("name", QT_TR_NOOP("Flight name")),
    _text_field("crew.pilot", QT_TR_NOOP("Pilot")),
    _text_field("crew.engineer", QT_TR_NOOP("Flight-test engineer")),
    _text_field("crew.ground_station", QT_TR_NOOP("Ground station")),
    _text_field("crew.safety", QT_TR_NOOP("Safety observer")),
    _number_field("flap", QT_TR_NOOP("Flap setting"), "angle", "deg", "deg"),
    _text_field("airframe", QT_TR_NOOP("Airframe (serial number)")),
)
WEIGHT_FIELDS = (
    _number_field("takeoff_weight", QT_TR_NOOP("Take-off weight"), "weight", "lb", "kg", 2),
    _number_field("landing_weight", QT_TR_NOOP("Landing weight"), "weight", "lb", "kg", 2),
    _number_field("fuel", QT_TR_NOOP("Fuel at start"), "mass", "lb", "kg", 2),
    _number_field("fuel_end", QT_TR_NOOP("Fuel at end"), "mass", "lb", "kg", 2),
)
WEATHER_FIELDS = (
    _number_field("weather.temperature", QT_TR_NOOP("Temperature"), "temperature", "degF", "degC"),
    _number_field("weather.pressure", QT_TR_NOOP("Pressure"), "pressure", "inHg", "hPa", 2),
    _number_field("weather.wind_speed", QT_TR_NOOP("Wind"), "speed", "mph", "m/s"),
    _number_field("weather.wind_from", QT_TR_NOOP("Wind from"), "angle", "deg", "deg", 0),
    _text_field("weather.remarks", QT_TR_NOOP("Clouds, gusts")),
)
DEBRIEF_FIELDS = (
    _multiline_field("pilot_comments", QT_TR_NOOP("Pilot's comments at the debrief")),
    _multiline_field("notes", QT_TR_NOOP("Notes")),
)
RATE_SWITCH_FIELD = CardField(
    key=("transmitter", "rate"), name=QT_TR_NOOP("Rate switch"), kind="choice",
    choices=(
        ("", QT_TR_NOOP("Not noted")), ("high", QT_TR_NOOP("High rate")),
        ("low", QT_TR_NOOP("Low rate")),
    ),
)  # fmt: skip
TRANSMITTER_FIELDS = (
    _text_field("transmitter.model", QT_TR_NOOP("Transmitter, memory")),
    RATE_SWITCH_FIELD,
)
TRANSMITTER_REMARKS_FIELD = _multiline_field(
    "transmitter.remarks", QT_TR_NOOP("Remarks on the set-up")
)
STICKS = (
    ("elevator", QT_TR_NOOP("Elevator")),
    ("aileron", QT_TR_NOOP("Aileron")),
    ("rudder", QT_TR_NOOP("Rudder")),
)
TRANSMITTER_CONTROLS = (
    *STICKS, ("throttle", QT_TR_NOOP("Throttle")), ("flap", QT_TR_NOOP("Flap")),
    ("gear", QT_TR_NOOP("Gear")),
)  # fmt: skip
THROW_COLUMNS = (
    ("high", QT_TR_NOOP("High")), ("low", QT_TR_NOOP("Low")), ("expo", QT_TR_NOOP("Expo")),
)  # fmt: skip


def create_throw_field(stick: str, column: str) -> CardField:
    """Return the value of a dual rate or of a trim, in percent."""
    text = tr(dict(STICKS)[stick]).lower()
    if column == "trim":
        return _number_field(
            f"transmitter.trims.{stick}", tr("Trim of the {control}").format(control=text),
            "ratio", "%", "%", 0,
        )  # fmt: skip
    return _number_field(
        f"transmitter.dual_rates.{stick}.{column}",
        tr("{column} of the {control}").format(
            column=tr(dict(THROW_COLUMNS)[column]), control=text
        ),
        "ratio", "%", "%", 0, group=f"transmitter.dual_rates.{stick}",
    )  # fmt: skip


def create_payload_mass_field() -> CardField:
    """Return the mass of something on board."""
    return _number_field("loading", tr("Mass"), "mass", "lb", "kg", 2)


def create_payload_position_field() -> CardField:
    """Return how far ahead of the CG something lies."""
    return _number_field("loading", tr("Ahead of the CG"), "length", "in", "mm", 1)


def create_mixer_field() -> CardField:
    """Return the share of a mixer, in percent."""
    return _number_field("transmitter.mixers", tr("Share"), "ratio", "%", "%", 0)


_SCALE_TITLES = {
    "nose": QT_TR_NOOP("Scale, nose wheel"),
    "main": QT_TR_NOOP("Scale, main axle"),
    "left": QT_TR_NOOP("Scale, left wheel"),
    "right": QT_TR_NOOP("Scale, right wheel"),
    "tail": QT_TR_NOOP("Scale, tail wheel"),
}


def list_weighed_supports(way: str, third: str) -> tuple[str, ...]:
    """Return which supports stand on scales; `third` is ``nose`` or ``tail``."""
    return {"axles": (third, "main"), "wheels": (third, "left", "right")}.get(way, ())


WEIGHING_METHODS = (
    ("", QT_TR_NOOP("Not weighed on wheels")),
    ("axles", QT_TR_NOOP("Two axles: weight, CG along x")),
    ("wheels", QT_TR_NOOP("Three wheels: CG along x and y")),
)


def create_scale_fields() -> tuple[CardField, ...]:
    """Return the readings of all scales there can be."""
    return tuple(
        _number_field(f"weighing.loads.{support}", name, "weight", "lb", "kg", 2, group="weighing")
        for support, name in _SCALE_TITLES.items()
    )


WEIGHING_CONDITION_FIELDS = (
    _number_field(
        "weighing.fuel", QT_TR_NOOP("Fuel on board then"), "mass", "lb", "kg", 2, group="weighing"
    ),
    _number_field(
        "weighing.pitch",
        QT_TR_NOOP("Nose up on the scales"),
        "angle",
        "deg",
        "deg",
        1,
        group="weighing",
    ),
)


def find_weighing_method(weighing: object) -> str:
    """Return how an aircraft was weighed, from what the card holds."""
    loads = weighing.get("loads", {}) if isinstance(weighing, Mapping) else {}
    return "wheels" if "left" in loads or "right" in loads else ("axles" if loads else "")


def format_field(value: CardField, written: Any, system: str) -> str:
    """Return what stands on screen for what is written in the file.

    A number that was typed in the unit of the screen is shown as it was typed.
    """
    if written is None:
        return ""
    if value.kind != "number":
        return str(written)
    if isinstance(written, (list, tuple)):
        written = written[0] if written else ""
    unit = value.unit(system)
    match = _NUMBER_WITH_UNIT.fullmatch(str(written))
    if match is not None:
        try:
            if normalize_unit(match[2], value.quantity) == unit:
                return match[1].replace("-", MINUS)
        except UnitError:
            return str(written)
    number = from_si(parse_quantity(written, value.quantity), unit, value.quantity)
    text = f"{number:.{value.digits}f}"
    if "." in text:
        text = text.rstrip("0").rstrip(".")
    return "0" if text == "-0" else text.replace("-", MINUS)


def parse_field(value: CardField, text: str, system: str) -> Any:
    """Return what is to be written for what was typed; None for nothing.

    Raises
    ------
    UnitError
        If it is no number, or one with a unit of something else.
    """
    text = text.strip() if value.kind != "lines" else text
    if not text.strip():
        return None
    if value.kind == "whole":
        if not text.isdigit():
            raise UnitError(
                tr("'{text}' is not a whole number; write one, such as 3").format(text=text)
            )
        return int(text)
    if value.kind != "number":
        return text
    plain = text.replace(MINUS, "-").replace(",", ".")
    if parse_number(plain) is not None:
        written = f"{plain} {value.unit(system)}"
    else:
        written = plain
        if not plain[:1].isdigit() and plain[:1] not in "-+.":
            raise UnitError(
                tr("'{text}' is not a number; write one, such as {example}").format(
                    text=text, example=_example_text(value)
                )
            )
    parse_quantity(written, value.quantity)
    return written


def _example_text(value: CardField) -> str:
    return tr("10 or 10 {us}").format(us=value.us) if value.us != "%" else "60"


_WEIGHT_UNITS = {"US": "lb", "SI": "kg"}
_LENGTH_UNITS = {"US": ("in", 2), "SI": ("mm", 0)}
_REQUIRED_VALUES = (
    ("crew.pilot", QT_TR_NOOP("pilot")),
    ("takeoff_weight", QT_TR_NOOP("take-off weight")),
    ("fuel", QT_TR_NOOP("fuel at start")),
    ("weather.temperature", QT_TR_NOOP("temperature")),
    ("weather.pressure", QT_TR_NOOP("pressure")),
)
"""What an analysis needs: key path and words."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WeighingText:
    """A weighing on screen."""

    weight: str = ""
    """The one big number; empty while it is not known."""
    lines: tuple[str, ...] = ()
    """Center of gravity and what else there is to say."""
    problem: str = ""
    """Why there is none."""
    weighed: Weighing | None = None
    """The result itself."""


def describe_weighing(info: FlightInfo, aircraft: Aircraft | None, system: str) -> WeighingText:
    """Return what the scales say."""
    if info.weighing is None:
        return WeighingText()
    try:
        weighed = evaluate_weighing(info.weighing, {} if aircraft is None else aircraft.axles)
    except FlightError as error:
        return WeighingText(problem=str(error))
    weight = (
        f"{_weight_text(weighed.mass.value, system)} ± {_weight_text(2 * weighed.mass.std, system)}"
    )
    lines = [_cg_text(weighed, 0, aircraft, system)]
    if weighed.measured[1]:
        lines.append(_cg_text(weighed, 1, aircraft, system))
    shares = ", ".join(f"{name} {100 * share:.1f} %" for name, share in weighed.shares.items())
    lines.append(tr("Weight on the wheels: {shares}").format(shares=shares))
    return WeighingText(
        weight=f"{weight} {_WEIGHT_UNITS[system]}", lines=tuple(lines), weighed=weighed
    )


def _weight_text(mass: float, system: str) -> str:
    return number_text(from_si(mass, _WEIGHT_UNITS[system], "mass"), 2)


def _cg_text(weighed: Weighing, axis: int, aircraft: Aircraft | None, system: str) -> str:
    """Return where the CG lies along x or y, from that of the aircraft file."""
    unit, digits = _LENGTH_UNITS[system]
    off, std = weighed.cg[axis], weighed.cg_std[axis]
    size = number_text(from_si(abs(off), unit, "length"), digits)
    about = number_text(from_si(2 * std, unit, "length"), digits)
    side = ((tr("behind"), tr("ahead of")), (tr("left of"), tr("right of")))[axis][off > 0.0]
    text = tr("CG {size} ± {about} {unit} {side} the aircraft file's").format(
        size=size, about=about, unit=unit_text(unit), side=side
    )
    if axis == 0 and aircraft is not None:
        share = 100.0 * abs(off) / aircraft.geometry.chord
        text += tr(" ({share:.1f} % of the chord)").format(share=share)
    return text


def format_takeoff_weight(weighed: Weighing, info: FlightInfo, system: str) -> str:
    """Return a weighed weight as it is written on the card, with the fuel that came in since."""
    unit = _WEIGHT_UNITS[system]
    mass = weighed.mass.value
    if info.weighing is not None and info.weighing.fuel is not None and info.fuel is not None:
        mass += info.fuel - info.weighing.fuel
    return f"{from_si(mass, unit, 'mass'):.2f} {unit}"


def describe_card_owner(
    info: FlightInfo, name: str, *, next_flight: bool, file_name: str = ""
) -> str:
    """Return whose card this is."""
    if not next_flight:
        date = "" if info.date is None else f", {info.date.day} {info.date:%B %Y %H:%M}"
        aircraft = f", {info.aircraft}" if info.aircraft else ""
        return tr("Card of {name}{date}{aircraft}: saved in its flight.toml.").format(
            name=name, date=date, aircraft=aircraft
        )
    goes = tr("copied to the flight folder when recording starts")
    if file_name:
        return tr("{file_name} has no card. Showing the card of the next flight: {goes}.").format(
            file_name=file_name, goes=goes
        )
    return tr("Card of the next flight: {goes}.").format(goes=goes)


def list_missing_values(info: FlightInfo) -> tuple[str, ...]:
    """Return in words what an analysis will need and nobody has written yet."""
    return tuple(tr(text) for key, text in _REQUIRED_VALUES if not is_card_field_filled(info, key))


def card_state(
    info: FlightInfo, problems: Sequence[str], doubts: Sequence[InfoWarning]
) -> StepStatus:
    """Return how the card stands."""
    missing = list_missing_values(info)
    if problems:
        text = tr("{values} wrong").format(values=count_text(len(problems), "value"))
        return StepStatus(state="warning", text=text, detail=". ".join(problems))
    if missing:
        text = (
            tr("{missing} missing").format(missing=missing[0])
            if len(missing) == 1
            else tr("{count} missing").format(count=len(missing))
        )
        return StepStatus(
            state="caution",
            text=text,
            detail=tr("Missing: {missing}").format(missing=", ".join(missing)),
        )
    if doubts:
        return StepStatus(
            state="caution",
            text=count_text(len(doubts), "doubt"),
            detail="\n".join(doubt.text for doubt in doubts),
        )
    return StepStatus(state="good", text=tr("complete"))
