"""What stands on the flight card: names, places in the file, units on screen. No Qt."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from gsapp.flight.toml_document import KeyPath
from gsapp.foundation import UnitError
from gsapp.quantities import from_si
from gsapp.quantities.units import normalize_unit, parse_quantity
from ui.number_format import MINUS, parse_number, unit_text
from ui.translation import QT_TR_NOOP, tr

_NUMBER_WITH_UNIT = re.compile(r"\s*([-+]?[0-9.]+(?:[eE][-+]?\d+)?)\s*(.*)")


@dataclass(frozen=True, slots=True, kw_only=True)
class CardField:
    """One value of the card.

    Attributes
    ----------
    key : tuple of str
        Path in the file.
    name : str
        On screen.
    kind : str
        ``text`` in one line, ``lines`` in several, ``number`` with a unit, ``whole`` number,
        ``choice`` of some.
    quantity : str
        Of a number.
    us, si : str
        Its units on screen.
    digits : int
        After the point, at most, where it is converted.
    choices : tuple of (str, str)
        What is written, and its words.
    group : tuple of str
        Table that is only valid as a whole; the key itself where it stands alone.
    """

    key: KeyPath
    name: str
    kind: Literal["text", "lines", "number", "whole", "choice"] = "text"
    quantity: str = ""
    us: str = ""
    si: str = ""
    digits: int = 1
    choices: tuple[tuple[str, str], ...] = ()
    group: KeyPath = ()

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
    words = tr(dict(STICKS)[stick]).lower()
    if column == "trim":
        return _number_field(
            f"transmitter.trims.{stick}", tr("Trim of the {control}").format(control=words),
            "ratio", "%", "%", 0,
        )  # fmt: skip
    return _number_field(
        f"transmitter.dual_rates.{stick}.{column}",
        tr("{column} of the {control}").format(
            column=tr(dict(THROW_COLUMNS)[column]), control=words
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
