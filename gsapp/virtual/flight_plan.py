"""Flight plans: what the pilot sets out to fly, as a TOML file.

A plan says what a crew would say on the field: how long the engines run, where the pattern
lies, which inputs are flown with how much stick. How well it is flown is the pilot's affair.
"""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Literal

from pydantic import Field, field_validator, model_validator

from gsapp.aircraft import Aircraft
from gsapp.flight.cards import CardSet, TestCard
from gsapp.foundation import FlightError, StrictModel, read_toml
from gsapp.foundation.files import ShippedFiles
from gsapp.quantities.constants import DEGREE, FOOT
from gsapp.quantities.fields import Angle, Length, Ratio, Speed, Temperature, Time
from gsapp.virtual.instruments import SensorFault
from gsapp.virtual.settings import VIRTUAL

ControlSurface = Literal["de", "da", "dr"]

INPUT_SHAPES: dict[str, tuple[float, ...]] = {
    "doublet": (1.0, -1.0),
    "3-2-1-1": (1.0, 1.0, 1.0, -1.0, -1.0, 1.0, -1.0),
    "pulse": (1.0,),
}
"""Unit steps of each shape; one entry lasts one `PlannedManeuver.step`."""


class FieldConditions(StrictModel):
    """The field and the air on the day."""

    elevation: Length = 1240 * FOOT  # Of the runway above sea level, m.
    temperature: Temperature = 288.15  # Of the air on the ground, K.
    latitude: Angle = 39.64 * DEGREE
    longitude: Angle = -79.92 * DEGREE
    """Of the middle of the runway, rad."""
    runway_heading: Angle = 180 * DEGREE  # Direction of take-off, rad from north.
    wind_speed: Speed = 0.0
    wind_from: Angle = 180 * DEGREE
    """Mean wind, m/s, and where it comes from, rad from north."""
    turbulence: Speed = 0.0  # Standard deviation of the gusts, m/s.


class RunUp(StrictModel):
    """One throttle setting while the engines run before take-off."""

    at: Time  # Time since the engines started, s.
    throttle: Ratio = Field(ge=0.0, le=1.0)  # 0 idle to 1 full.


class EngineSchedule(StrictModel):
    """The engines on the ground."""

    start: Time = 2.0  # When they start, s after the box was switched on.
    running: Time = 80.0  # How long they run before the take-off run, s.
    run_ups: tuple[RunUp, ...] = ()  # Throttle settings in between, in order of time.
    imbalance: Ratio = 0.02  # Share by which the left engine turns faster than the right one.

    @field_validator("run_ups")
    @classmethod
    def _in_order(cls, value: tuple[RunUp, ...]) -> tuple[RunUp, ...]:
        if any(later.at <= earlier.at for earlier, later in itertools.pairwise(value)):
            raise ValueError("the run-ups must follow each other in time; sort them by 'at'")
        return value


class RangeCheck(StrictModel):
    """Large stick pulses on the ground: to show that the radio is alive."""

    at: Time = 60.0  # Of the first pulse, s after the engines started.
    pulses: tuple[ControlSurface, ...] = ()  # The control of each, ``de``, ``da`` or ``dr``.
    shape: Literal["pulse", "doublet"] = "pulse"  # Doublets show both sides of the travel.
    stick: Ratio = Field(default=0.9, gt=0.0, le=1.0)  # Share of full stick.
    duration: Time = 1.0
    """Of one pulse, or of either half of a doublet, s; as long lies between two inputs."""

    @property
    def spacing(self) -> float:
        """Return the time from one input to the next, s."""
        return (len(INPUT_SHAPES[self.shape]) + 1) * self.duration


class Takeoff(StrictModel):
    """Take-off run and climb: `speed` is where the nose is lifted, m/s; `climb` the path, rad."""

    speed: Speed = 73 * FOOT
    climb: Angle = 12 * DEGREE
    throttle: Ratio = Field(default=1.0, gt=0.0, le=1.0)


class Pattern(StrictModel):
    """The race-track."""

    height: Length = 260 * FOOT  # Above the field, m.
    speed: Speed = 100 * FOOT  # Airspeed that the pilot aims at, m/s.
    leg: Time = 10.0  # Length of the straight legs, s.
    bank: Angle = 45 * DEGREE  # In the turns, rad.
    side: Literal["left", "right"] = "left"
    """On which side of the runway, seen in the direction of take-off."""


class PlannedManeuver(StrictModel):
    """One input flown on one straight leg."""

    inputs: tuple[ControlSurface, ...] = Field(min_length=1)
    """``de``, ``da``, ``dr``; several are flown together."""
    shape: Literal["doublet", "3-2-1-1", "pulse"] = "doublet"
    stick: tuple[Ratio, ...]
    """Share of full stick, one for each input; the sign says which way first."""
    step: Time = 0.4  # Duration of one unit step, s.
    stagger: Time = 0.0  # Delay of each further input after the one before, s.
    rate: Literal["low", "high"] = "high"  # Position of the rate switch.
    speed: Speed | None = None  # Airspeed wanted, m/s; None is that of the pattern.
    quiet: Time = 3.0  # How long the pilot leaves the sticks alone afterwards, s.
    flap: Angle = 0.0  # Set before the input, rad.
    throttle_step: Ratio = 0.0  # Change of the throttle as the input ends, held while quiet.

    @model_validator(mode="after")
    def _one_stick_each(self) -> PlannedManeuver:
        if len(self.stick) != len(self.inputs):
            raise ValueError(
                f"there are {len(self.inputs)} inputs and {len(self.stick)} sizes in 'stick'; "
                "give one for each"
            )
        if len(set(self.inputs)) != len(self.inputs):
            raise ValueError("an input is listed twice; name each once")
        if any(not 0.0 < abs(size) <= 1.0 for size in self.stick):
            raise ValueError("stick sizes lie between -1 and 1 and are not zero; half stick is 0.5")
        if not self.step > 0.0:
            raise ValueError('step must be greater than zero; write for example "0.4 s"')
        return self

    @property
    def duration(self) -> float:
        """Return the time from the first to the last stick movement as intended, s."""
        return len(INPUT_SHAPES[self.shape]) * self.step + self.stagger * (len(self.inputs) - 1)


class Landing(StrictModel):
    """Approach and landing."""

    speed: Speed = 80 * FOOT  # On final approach, m/s.
    glide: Angle = 4.5 * DEGREE  # Angle of the approach path, rad.
    flap: Angle = 20 * DEGREE  # Set for the approach, rad.


class PilotLimits(StrictModel):
    """The pilot's limits: errors are standard deviations."""

    delay: Time = 0.2  # From seeing to moving, s.
    hand: Time = 0.1  # Lag of the hand, s.
    bank_error: Angle = 2.5 * DEGREE
    pitch_error: Angle = 1.0 * DEGREE
    """Of attitudes seen from the ground, rad."""
    distance_error: Ratio = 0.012
    """Of height and place, as a share of the distance to the aircraft."""
    speed_error: Speed = 5 * FOOT  # Of the airspeed guessed, m/s; there is no airspeed cue.
    size_error: Ratio = 0.12
    timing_error: Ratio = 0.12
    """Share by which each stick step misses its size and its duration."""
    residual: Ratio = 0.01
    """Stick left over after an input and while holding still, share of full stick."""
    trim_error: Ratio = 0.015  # By how much the trim levers are off, share of full stick.
    coordination: Ratio = 0.8  # Share of the rudder needed in a turn that is really given.


class FlightPlan(StrictModel):
    """A whole flight, from switching the box on to engines off."""

    name: str = "flight"
    description: str = ""
    conditions: FieldConditions = Field(default_factory=FieldConditions)
    engines: EngineSchedule = Field(default_factory=EngineSchedule)
    range_check: RangeCheck = Field(default_factory=RangeCheck)
    takeoff: Takeoff = Field(default_factory=Takeoff)
    pattern: Pattern = Field(default_factory=Pattern)
    maneuvers: tuple[PlannedManeuver, ...] = ()
    landing: Landing = Field(default_factory=Landing)
    human: PilotLimits = Field(default_factory=PilotLimits)
    faults: tuple[SensorFault, ...] = ()
    """What goes wrong with the instruments."""

    @model_validator(mode="after")
    def _ends(self) -> FlightPlan:
        checked = len(self.range_check.pulses) * self.range_check.spacing
        ground = (self.engines.start, self.engines.running, self.range_check.at, checked)
        flown = [one.duration + one.quiet + self.pattern.leg for one in self.maneuvers]
        if not sum(map(abs, (*ground, *flown))) <= VIRTUAL.max_planned_time:
            raise ValueError(
                f"the flight would take longer than {VIRTUAL.max_planned_time / 3600.0:g} hours; "
                "shorten engines, legs or maneuvers"
            )
        return self


def with_cards(plan: FlightPlan, cards: CardSet, aircraft: Aircraft) -> FlightPlan:
    """Return a plan whose maneuvers are those of test cards, each with its repeats.

    Raise FlightError if a card asks for a shape that the pilot does not fly.
    """
    maneuvers = [_plan_card(card, aircraft) for card in cards.cards for _ in range(card.repeats)]
    longest = max(one.duration + one.quiet for one in maneuvers)
    leg = max(plan.pattern.leg, longest + VIRTUAL.card_settling_time)
    pattern = plan.pattern.model_copy(update={"leg": leg})
    return plan.model_copy(update={"maneuvers": tuple(maneuvers), "pattern": pattern})


def _plan_card(card: TestCard, aircraft: Aircraft) -> PlannedManeuver:
    if card.kind not in INPUT_SHAPES:
        raise FlightError(
            f"card {card.id}: the virtual pilot flies {', '.join(INPUT_SHAPES)}, not {card.kind}"
        )
    sizes = {
        name: size / abs(getattr(aircraft.controls, name).full_stick_high)
        for name, size in card.amplitudes.items()
    }
    return PlannedManeuver(
        inputs=card.surfaces,
        shape=card.kind,
        stick=tuple(min(size, 1.0) for size in sizes.values()),
        step=f"{card.width!r} s",
        stagger=f"{card.duration * (len(sizes) > 1)!r} s",
        speed=f"{card.speed!r} m/s",
        quiet=f"{VIRTUAL.card_quiet_time!r} s",
        flap=f"{card.flap!r} rad",
        throttle_step=card.throttle_step,
    )


SHIPPED_PLANS = ShippedFiles(folder=Path(__file__).parent / "plans", kind="flight plan")


def load_flight_plan(name_or_path: str | Path) -> FlightPlan:
    """Read a flight plan: a path, or the name of a shipped one, ``default`` or ``short``.

    Raise FileProblemsError if the file holds mistakes; all are named. Raise UnknownNameError if
    there is neither such a file nor such a shipped plan.
    """
    return read_toml(SHIPPED_PLANS.find(name_or_path), FlightPlan)
