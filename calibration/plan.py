"""What is calibrated on an aircraft, in which order, and at which settings: a TOML file.

::

    name = "B777"

    [[instruments]]
    channel = "elevator_left"
    title = "Left elevator"
    kind = "surface"
    unit = "deg"
    settings = ["-20 deg", "-10 deg", "0 deg", "10 deg", "20 deg"]
    check_settings = ["-10 deg", "0 deg", "10 deg"]
    travel = ["-25 deg", "25 deg"]
    positive = "trailing edge down"
    negative = "trailing edge up"
    partner = "elevator_right"
    ratiometric = true
    view = "side"
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Literal

from pydantic import Field

from calibration.certificate_toml import certificate_paths
from calibration.inertial.accelerometers import ACCELEROMETERS
from calibration.inertial.gyros import GYROS
from calibration.settings import CALIBRATION
from gsapp.foundation import (
    FileProblem,
    StrictModel,
    UnitError,
    UnknownNameError,
    read_toml,
    toml_problems_error,
)
from gsapp.foundation.files import ShippedFiles
from gsapp.quantities import INSTRUMENTS, base_id, channel, from_si, normalize_unit, parse_quantity
from gsapp.quantities.constants import DEGREE
from gsapp.quantities.fields import Angle

InstrumentKind = Literal["surface", "vane", "gyro", "accelerometer", "pressure"]
AircraftView = Literal["side", "above"]

CALIBRATION_PLANS = ShippedFiles(folder=Path(__file__).parent / "plans", kind="calibration plan")

ANGLE_SENSOR_KINDS: frozenset[str] = frozenset({"surface", "vane"})
"""Kinds that are set to angles against a protractor."""

_OF_KIND: Mapping[InstrumentKind, tuple[str, ...]] = {
    "gyro": GYROS,
    "accelerometer": ACCELEROMETERS,
    "pressure": ("dynamic_pressure", "static_pressure"),
}
_NEEDED: Mapping[InstrumentKind, tuple[str, ...]] = {
    "accelerometer": ACCELEROMETERS,
    "pressure": ("dynamic_pressure",),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class InstrumentPlan:
    """How one instrument is calibrated."""

    channel: str
    """Channel id; its volts are ``<channel>_volts``."""
    title: str
    """As the crew calls it."""
    kind: InstrumentKind
    """Which steps it takes."""
    unit: str
    """Of settings, travel and certificate."""
    settings: tuple[float, ...] = ()
    """Angles at the protractor, ascending, `unit`; taken up, then down. Empty for instruments that
    are not set by hand."""
    check_settings: tuple[float, ...] = ()
    """The three of the short check, ascending, `unit`."""
    travel: tuple[float, float] | None = None
    """Least and greatest value it reaches on the aircraft, `unit`."""
    positive: str = ""
    negative: str = ""
    """What a positive and a negative value look like, such as ``trailing edge down``."""
    partner: str = ""
    """Channel on the other side of the aircraft; empty where there is none."""
    sign_with_partner: int = 1
    """+1 where both values have the same sign when both are driven together, else -1."""
    ratiometric: bool = False
    """Whether its volts follow the supply."""
    view: AircraftView = "side"
    """From where the aircraft is drawn so that the movement is seen."""
    turn: float | None = None
    """Of a gyro: angle of the turntable, there and back, deg. None leaves the scale unchecked."""
    setting_error: float | None = None
    """Standard deviation of one setting as known beforehand, `unit`: a protractor read to half a
    degree is off by 0.15 deg. None leaves it to the points."""

    @property
    def is_angle_sensor(self) -> bool:
        """Return whether it is set to angles by hand, as surfaces and vanes are."""
        return self.kind in ANGLE_SENSOR_KINDS

    @property
    def positive_motion_text(self) -> str:
        """Return what to do so that its sign is proven."""
        return f"Move the {self.title.lower()} {self.positive}"

    def format_setting(self, value: float) -> str:
        """Return a setting as the crew reads it off: ``20 deg trailing edge up``, not -20."""
        size = f"{abs(value):g} {self.unit}".rstrip()
        if value == 0.0:
            return size
        return f"{size} {self.positive if value > 0.0 else self.negative}".rstrip()


@dataclass(frozen=True, slots=True, kw_only=True)
class CalibrationPlan:
    """The instruments of an aircraft in the order in which they are calibrated."""

    name: str
    instruments: tuple[InstrumentPlan, ...]
    nominal: str = ""
    """Folder or shipped set of certificates: the factory's figures, and the way each instrument is
    mounted. What is measured is held against it where nothing better is known."""

    def __getitem__(self, channel_id: str) -> InstrumentPlan:
        """Return the plan of one channel.

        Raises
        ------
        UnknownNameError
            If the plan leaves it out.
        """
        for instrument in self.instruments:
            if instrument.channel == channel_id:
                return instrument
        raise UnknownNameError(
            f"the calibration plan '{self.name}' has no '{channel_id}'; it has "
            f"{', '.join(self.channels)}"
        )

    @property
    def channels(self) -> tuple[str, ...]:
        return tuple(instrument.channel for instrument in self.instruments)

    def select_kinds(self, kinds: Sequence[InstrumentKind]) -> CalibrationPlan:
        """Return the plan reduced to instruments of these kinds."""
        return self.select_channels([one.channel for one in self.instruments if one.kind in kinds])

    def select_channels(self, channels: Sequence[str]) -> CalibrationPlan:
        """Return the plan reduced to these channels, in its own order."""
        return replace(
            self, instruments=tuple(one for one in self.instruments if one.channel in channels)
        )

    def select_with_dependencies(self, channel_id: str) -> CalibrationPlan:
        """Return the plan reduced to one instrument and those that its steps need.

        Raises
        ------
        UnknownNameError
            If the plan leaves it out.
        """
        return self.select_channels((channel_id, *_NEEDED.get(self[channel_id].kind, ())))


class _InstrumentTable(StrictModel):
    channel: str
    title: str = ""
    kind: InstrumentKind
    unit: str
    settings: tuple[str, ...] = ()
    check_settings: tuple[str, ...] = ()
    travel: tuple[str, str] | None = None
    positive: str = ""
    negative: str = ""
    partner: str = ""
    sign_with_partner: Literal[1, -1] = 1
    ratiometric: bool = False
    view: AircraftView = "side"
    turn: Angle | None = None
    setting_error: str | None = None


class _PlanFile(StrictModel):
    name: str
    nominal: str = ""
    instruments: tuple[_InstrumentTable, ...] = Field(min_length=1)


def load_calibration_plan(name_or_path: str | Path) -> CalibrationPlan:
    """Read a calibration plan, or a shipped one such as ``b777``.

    Raises
    ------
    FileProblemsError
        If the file holds mistakes; all are named, with key path and remedy.
    UnknownNameError
        If there is no such file and none of that name is shipped.
    """
    path = CALIBRATION_PLANS.find(name_or_path)
    file = read_toml(path, _PlanFile)
    reader = _Reader(file)
    instruments = tuple(reader.instrument(at) for at in range(len(file.instruments)))
    reader.check_together()
    if reader.problems:
        raise toml_problems_error(path, reader.problems)
    return CalibrationPlan(name=file.name, instruments=instruments, nominal=file.nominal)


class _Reader:
    """Turns the tables of a file into plans and collects what is wrong with them."""

    def __init__(self, file: _PlanFile) -> None:
        self._file = file
        self.problems: list[FileProblem] = []

    def instrument(self, at: int) -> InstrumentPlan:
        """Return the plan of one table; only fit for use if no problem was found."""
        table = self._file.instruments[at]
        quantity, unit = self._quantity_and_unit(at)
        values = [
            tuple(self._value(at, key, index, text, quantity, unit) for index, text in items)
            for key, items in (
                ("settings", enumerate(table.settings)),
                ("check_settings", enumerate(table.check_settings)),
                ("travel", enumerate(table.travel or ())),
                ("setting_error", enumerate((table.setting_error,) if table.setting_error else ())),
            )
        ]
        settings, check_settings, travel, setting_error = values
        self._check_partner(at)
        self._check_ascending(at, "settings", settings)
        self._check_ascending(at, "check_settings", check_settings)
        self._check_ascending(at, "travel", travel)
        if table.kind in ANGLE_SENSOR_KINDS:
            self._check_set_by_hand(at, settings, check_settings, travel)
        parsed = {
            "title": table.title or table.channel,
            "unit": unit,
            "settings": settings,
            "check_settings": check_settings,
            "travel": travel or None,
            "setting_error": setting_error[0] if setting_error else None,
            "turn": None if table.turn is None else float(f"{table.turn / DEGREE:.12g}"),
        }
        return InstrumentPlan(**{**table.model_dump(), **parsed})

    def check_together(self) -> None:
        """Check what concerns several instruments, or the file as a whole."""
        tables = self._file.instruments
        for kind, names in _OF_KIND.items():
            given = [table.channel for table in tables if table.kind == kind]
            for index, table in enumerate(tables):
                if table.kind == kind and table.channel not in names:
                    self._report(
                        index, "kind", f"'{kind}' is not one of '{table.channel}'",
                        f"such are {', '.join(names)}",
                    )  # fmt: skip
            missing = [name for name in _NEEDED.get(kind, ()) if name not in given]
            if given and missing:
                what = f"there is a {kind}, but none for {', '.join(missing)}"
                remedy = "they are calibrated together; add it"
                self.problems.append(FileProblem(where="instruments", what=what, remedy=remedy))
        if self._file.nominal:
            try:
                certificate_paths(self._file.nominal)
            except UnknownNameError as error:
                self.problems.append(FileProblem.from_error("nominal", error))

    def _report(self, at: int, key: str, what: str, remedy: str) -> None:
        where = f"instruments[{at}].{key}"
        self.problems.append(FileProblem(where=where, what=what, remedy=remedy))

    def _quantity_and_unit(self, at: int) -> tuple[str, str]:
        table = self._file.instruments[at]
        earlier = [other.channel for other in self._file.instruments[:at]]
        if table.channel in earlier:
            first = earlier.index(table.channel)
            self._report(
                at,
                "channel",
                f"'{table.channel}' is already in instruments[{first}]",
                "remove one of the two",
            )
        try:
            quantity = channel(table.channel).quantity
        except UnknownNameError as error:
            self.problems.append(FileProblem.from_error(f"instruments[{at}].channel", error))
            return "", table.unit
        if base_id(table.channel) not in INSTRUMENTS:
            self._report(
                at,
                "channel",
                f"'{table.channel}' has no voltage channel",
                f"calibrate one of {', '.join(INSTRUMENTS)}",
            )
        try:
            return quantity, normalize_unit(table.unit, quantity)
        except UnitError as error:
            self.problems.append(FileProblem.from_error(f"instruments[{at}].unit", error))
            return "", table.unit

    def _value(self, at: int, key: str, index: int, text: str, quantity: str, unit: str) -> float:
        if not quantity:
            return float("nan")
        try:
            value = float(from_si(parse_quantity(text, quantity), unit, quantity))
        except UnitError as error:
            self.problems.append(FileProblem.from_error(f"instruments[{at}].{key}[{index}]", error))
            return float("nan")
        # Back and forth through SI leaves -20 deg a bit off in the last digit.
        return float(f"{value:.12g}") + 0.0

    def _check_partner(self, at: int) -> None:
        table = self._file.instruments[at]
        channels = [other.channel for other in self._file.instruments]
        if not table.partner:
            return
        if table.partner not in channels or table.partner == table.channel:
            self._report(
                at,
                "partner",
                f"'{table.partner}' is not another instrument of this plan",
                "name the channel on the other side of the aircraft, or leave the key out",
            )

    def _check_ascending(self, at: int, key: str, values: Sequence[float]) -> None:
        if any(not low < high for low, high in pairwise(values) if low == low and high == high):
            self._report(at, key, "is not increasing", "list the values in increasing order")

    def _check_set_by_hand(
        self,
        at: int,
        settings: Sequence[float],
        check_settings: Sequence[float],
        travel: Sequence[float],
    ) -> None:
        table = self._file.instruments[at]
        if len(settings) < CALIBRATION.min_settings:
            self._report(
                at,
                "settings",
                f"holds {len(settings)} settings, too few for a curve",
                f"give at least {CALIBRATION.min_settings}, as five from -20 deg to 20 deg",
            )
        if len(check_settings) != CALIBRATION.check_settings:
            self._report(
                at,
                "check_settings",
                f"holds {len(check_settings)} settings",
                "give the three settings of the short check",
            )
        for key, text in (("positive", table.positive), ("negative", table.negative)):
            if not text:
                self._report(at, key, "is missing", 'describe it, such as "trailing edge down"')
        if len(travel) == 2:
            for key, values in (("settings", settings), ("check_settings", check_settings)):
                if any(not travel[0] <= value <= travel[1] for value in values if value == value):
                    self._report(at, key, "exceeds the travel", "keep the settings within travel")
