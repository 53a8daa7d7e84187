"""The checklist as a file: items ticked by hand, and items judged by a rule from telemetry.

Rules are a small closed vocabulary; each is a table with its ``kind``:

============ ====================================================================================
kind         green when
============ ====================================================================================
within       a channel lies between `low` and `high`; red beyond `low_red`, `high_red`
link         frames come, and no more than `loss` of them get lost; red above `loss_red`
recorder     the recorder runs and what it writes grows
space        the disk takes `time` more of recording, and `gigabytes`; red below `time_red`
alive        every channel is fresh, plausible, off its end stops; not stuck, if `moving`
calibrated   every channel has a certificate in force; amber if one is older than `age`
follows      a surface goes with its stick, the right way, to both sides
engines      engine speeds stay between `low` and `high` for a while, left and right alike
pulses       so many large pulses were seen on a surface: the range check of the radio
card         the flight card is filled in, without slips
============ ====================================================================================
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Final, Literal

from pydantic import Discriminator, Field, field_validator, model_validator

from gsapp.foundation import StrictModel, UnknownNameError, read_toml
from gsapp.foundation.files import ShippedFiles
from gsapp.quantities import channel, parse_quantity
from gsapp.quantities.fields import Angle, Ratio, RotationSpeed, Time

SHIPPED_CHECKLISTS: Final = ShippedFiles(folder=Path(__file__).parent / "files", kind="checklist")

QuantityText = str | float
"""A value with the unit of its channel: ``"11.6 V"``."""


def _validate_channel(name: str) -> str:
    try:
        channel(name)
    except UnknownNameError as error:
        # pydantic passes ValueError on, with the key path.
        raise ValueError(str(error)) from error
    return name


def _validate_not_negative(value: float) -> float:
    if value < 0.0:
        raise ValueError('a duration is not negative; write for example "2 s"')
    return value


class _Rule(StrictModel):
    """What every rule shares."""

    @field_validator("channel", "stick", "surface", "throttle_channel", check_fields=False)
    @classmethod
    def _must_be_a_channel(cls, value: str) -> str:
        return _validate_channel(value)

    @field_validator("channels", check_fields=False)
    @classmethod
    def _must_be_channels(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        if not value:
            raise ValueError("names no channel; write at least one")
        for name in value:
            _validate_channel(name)
        return value

    @field_validator("duration", "time", "time_red", "age", "patience", check_fields=False)
    @classmethod
    def _must_not_be_negative(cls, value: float | None) -> float | None:
        return None if value is None else _validate_not_negative(value)

    @property
    def required_channels(self) -> tuple[str, ...]:
        return ()


class RangeRule(_Rule):
    """A channel between two values, as now and for the last `duration`."""

    kind: Literal["within"]
    channel: str
    low: QuantityText | None = None
    high: QuantityText | None = None
    """Ends of green, with the channel's unit."""
    low_red: QuantityText | None = None
    high_red: QuantityText | None = None
    """Beyond them red; between amber. Without them everything outside green is red."""
    duration: Time = 1.0
    """s."""

    @model_validator(mode="after")
    def _must_be_in_order(self) -> RangeRule:
        if self.low is None and self.high is None:
            raise ValueError('no end is given; write low = "11.6 V", high, or both')
        low_red, low, high, high_red = self.bounds
        if not low_red <= low <= high <= high_red:
            raise ValueError("low_red, low, high and high_red must grow in this order; sort them")
        return self

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Return ends of red, of green, of green, of red; SI, infinite where open."""
        low, high = self._si(self.low, -1), self._si(self.high, +1)
        low_red = low if self.low_red is None else self._si(self.low_red, -1)
        high_red = high if self.high_red is None else self._si(self.high_red, +1)
        return low_red, low, high, high_red

    def _si(self, value: QuantityText | None, side: int) -> float:
        if value is None:
            return side * float("inf")
        return parse_quantity(value, channel(self.channel).quantity)

    @property
    def required_channels(self) -> tuple[str, ...]:
        return (self.channel,)


class LinkRule(_Rule):
    """The telemetry comes in; `age` in s, `loss` and `loss_red` shares of frames lost of late."""

    kind: Literal["link"]
    age: Time = 2.0
    loss: Ratio = 0.02
    loss_red: Ratio = 0.10


class RecorderRule(_Rule):
    """The recorder runs, and its file grows."""

    kind: Literal["recorder"]


class DiskSpaceRule(_Rule):
    """Room on the disk: `time` and `time_red` of recording, s, and `gigabytes`."""

    kind: Literal["space"]
    time: Time = 3600.0
    time_red: Time = 900.0
    gigabytes: float = 0.5


class SensorActivityRule(_Rule):
    """Sensors are fresh and plausible."""

    kind: Literal["alive"]
    channels: tuple[str, ...]
    moving: bool = False
    """Whether each must differ from sample to sample: a gyro with its engine running does, a
    surface held still does not."""
    duration: Time = 3.0

    @property
    def required_channels(self) -> tuple[str, ...]:
        return self.channels


class CalibrationRule(_Rule):
    """Every channel has a certificate in force; one older than `age`, s, is amber."""

    kind: Literal["calibrated"]
    channels: tuple[str, ...]
    age: Time | None = None


class SurfaceResponseRule(_Rule):
    """A surface goes with its stick."""

    kind: Literal["follows"]
    stick: str
    """Channel of the stick, -1 to 1."""
    surface: str
    sign: Literal[1, -1] = 1
    """1 if a positive stick makes a positive deflection."""
    stick_reach: Ratio = 0.7
    """How far the stick must have been moved to either side."""
    surface_reach: Angle
    """How far the surface must have gone then, rad."""

    @property
    def required_channels(self) -> tuple[str, ...]:
        return (self.stick, self.surface)


class EngineSpeedRule(_Rule):
    """Engine speeds within bounds for a while, all at the same time."""

    kind: Literal["engines"]
    channels: tuple[str, ...] = ("rpm_left", "rpm_right")
    low: RotationSpeed
    high: RotationSpeed
    """rad/s."""
    apart: RotationSpeed | None = None
    """How far engines may differ, rad/s."""
    duration: Time = 2.0
    throttle: tuple[Ratio, Ratio] | None = None
    """The throttle's range in which these bounds hold, where the throttle is measured: an engine
    outside its bounds is red then, not merely not yet tried."""

    @model_validator(mode="after")
    def _must_be_in_order(self) -> EngineSpeedRule:
        if not 0.0 <= self.low < self.high:
            raise ValueError("low must lie below high, and neither below zero; swap them")
        if self.throttle is not None and not self.throttle[0] < self.throttle[1]:
            raise ValueError('throttle goes from low to high; write ["0 %", "5 %"]')
        return self

    @property
    def required_channels(self) -> tuple[str, ...]:
        return (*self.channels, "throttle")


class SurfacePulseRule(_Rule):
    """Large pulses on surfaces: the pilot's range check of the radio."""

    kind: Literal["pulses"]
    channels: tuple[str, ...] = ("de", "da", "dr")
    size: Angle
    """Least deflection from where it rested, rad."""
    count: int = Field(default=1, ge=1)
    longest: Time = 5.0
    """A surface held longer than this, s, is no pulse."""

    @property
    def required_channels(self) -> tuple[str, ...]:
        return self.channels


class FlightCardRule(_Rule):
    """The flight card: `fields` that must be filled in, such as ``takeoff_weight``."""

    kind: Literal["card"]
    fields: tuple[str, ...] = ()


ChecklistRule = Annotated[
    RangeRule
    | LinkRule
    | RecorderRule
    | DiskSpaceRule
    | SensorActivityRule
    | CalibrationRule
    | SurfaceResponseRule
    | EngineSpeedRule
    | SurfacePulseRule
    | FlightCardRule,
    Discriminator("kind"),
]

CHECKLIST_RULES: Final[tuple[type[_Rule], ...]] = (
    RangeRule, LinkRule, RecorderRule, DiskSpaceRule, SensorActivityRule, CalibrationRule,
    SurfaceResponseRule, EngineSpeedRule, SurfacePulseRule, FlightCardRule,
)  # fmt: skip


class ChecklistItem(StrictModel):
    """One line of the checklist."""

    id: str
    words: str
    """What is to be true, as read aloud."""
    rule: ChecklistRule | None = None
    """Judges it from telemetry; without one it is ticked by hand."""

    @property
    def checked_by(self) -> Literal["hand", "telemetry"]:
        return "hand" if self.rule is None else "telemetry"


class ChecklistFile(StrictModel):
    """A checklist, read."""

    name: str = ""
    aircraft: str = ""
    """Name of the aircraft it is made for; empty for any."""
    items: tuple[ChecklistItem, ...] = Field(min_length=1)


def shipped_checklists() -> tuple[str, ...]:
    """Return the names of the checklists that come with the program."""
    return SHIPPED_CHECKLISTS.names()


def load_checklist(name_or_path: str | Path) -> ChecklistFile:
    """Read a checklist.

    Parameters
    ----------
    name_or_path : str or Path
        A path, or the name of a shipped list such as ``b777``.

    Raises
    ------
    FileProblemsError
        If the file holds mistakes; all are named at once.
    UnknownNameError
        If there is neither such a file nor such a shipped list.
    """
    return read_toml(SHIPPED_CHECKLISTS.find(name_or_path), ChecklistFile, distinct="items")
