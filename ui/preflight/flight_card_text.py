"""What a weighing says, and how the flight card stands, in words. No Qt."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from gsapp.aircraft import Aircraft
from gsapp.aircraft.weighing import Weighing, evaluate_weighing
from gsapp.flight.info import FlightInfo
from gsapp.flight.info_checks import InfoWarning
from gsapp.foundation import FlightError
from gsapp.quantities import from_si
from gsapp.session.checklist.rule_evaluators import is_card_field_filled
from ui.number_format import count_text, number_text, unit_text
from ui.translation import QT_TR_NOOP, tr
from ui.window_frame.page_steps import StepStatus

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
    """A weighing on screen.

    Attributes
    ----------
    weight : str
        The one big number; empty while it is not known.
    lines : tuple of str
        Center of gravity and what else there is to say.
    problem : str
        Why there is none.
    weighed : Weighing or None
        The result itself.
    """

    weight: str = ""
    lines: tuple[str, ...] = ()
    problem: str = ""
    weighed: Weighing | None = None


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
    words = tr("CG {size} ± {about} {unit} {side} the aircraft file's").format(
        size=size, about=about, unit=unit_text(unit), side=side
    )
    if axis == 0 and aircraft is not None:
        share = 100.0 * abs(off) / aircraft.geometry.chord
        words += tr(" ({share:.1f} % of the chord)").format(share=share)
    return words


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
    return tuple(
        tr(words) for key, words in _REQUIRED_VALUES if not is_card_field_filled(info, key)
    )


def card_state(
    info: FlightInfo, problems: Sequence[str], doubts: Sequence[InfoWarning]
) -> StepStatus:
    """Return how the card stands."""
    missing = list_missing_values(info)
    if problems:
        words = tr("{values} wrong").format(values=count_text(len(problems), "value"))
        return StepStatus(state="warning", text=words, detail=". ".join(problems))
    if missing:
        words = (
            tr("{missing} missing").format(missing=missing[0])
            if len(missing) == 1
            else tr("{count} missing").format(count=len(missing))
        )
        return StepStatus(
            state="caution",
            text=words,
            detail=tr("Missing: {missing}").format(missing=", ".join(missing)),
        )
    if doubts:
        return StepStatus(
            state="caution",
            text=count_text(len(doubts), "doubt"),
            detail="\n".join(doubt.text for doubt in doubts),
        )
    return StepStatus(state="good", text=tr("complete"))
