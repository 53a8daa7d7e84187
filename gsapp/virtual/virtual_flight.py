"""Whole virtual flights: the pilot, the aircraft, its instruments and its recorder."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from calibration.certificate_toml import load_certificates
from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.linearization import linearize
from gsapp.dynamics.model import Model, load_model
from gsapp.dynamics.terms import create_term
from gsapp.dynamics.trim import Trim, trim
from gsapp.foundation import FlightError
from gsapp.quantities import Block, FloatArray
from gsapp.virtual.airframe import (
    INSTRUMENT_INPUT_CHANNELS,
    ONBOARD_CHANNELS,
    TRUTH_CHANNELS,
    Airframe,
)
from gsapp.virtual.dirt import draw_dirt
from gsapp.virtual.flight_plan import FlightPlan, PlannedManeuver, load_flight_plan
from gsapp.virtual.human_pilot import AircraftHandling, HumanPilot
from gsapp.virtual.instruments import (
    DAQ_CHANNELS,
    AnalogDigitalConverter,
    Instruments,
    parse_sensor_fault,
)
from gsapp.virtual.settings import VIRTUAL
from gsapp.virtual.sticks import StickPositions, StickSource


def add_hidden_effects(aircraft: Aircraft, model: Model, hide: Sequence[str] = ()) -> Model:
    """Return the model that the virtual aircraft really follows: with ``ID[:PARAM=VALUE,..]``.

    Values are in SI and radians. Raise UnknownNameError if an effect or one of its parameters is
    unknown, FlightError if a value is not a number.
    """
    for text in hide:
        effect_id, parameters = parse_effect(text)
        create_term(effect_id, aircraft).values_for(parameters)
        model = model.with_effect(effect_id, parameters)
    return model


def parse_effect(text: str) -> tuple[str, dict[str, float]]:
    """Return id and parameters of ``ID[:PARAM=VALUE,..]``."""
    effect_id, _, rest = text.partition(":")
    parameters: dict[str, float] = {}
    for pair in rest.split(",") if rest else ():
        name, equals, value = pair.partition("=")
        try:
            if not equals:
                raise ValueError
            parameters[name.strip()] = float(value)
        except ValueError:
            raise FlightError(
                f"'{pair}' in '{text}' is not PARAM=VALUE; write for example "
                "aero.Cm.alpha2:Cm_alpha2=-2.0, in SI units and radians"
            ) from None
    return effect_id.strip(), parameters


# What a pilot knows of an aircraft after many flights: level flight, and what the sticks do.
# Found by asking the equations, so that the same pilot flies any aircraft.


def compute_handling(model: FlightModel, speed: float, density: float) -> AircraftHandling:
    """Return what a pilot knows of an aircraft, hidden effects included, who has flown this one.

    At an airspeed (m/s), in air of a density (kg/m^3). Raise FlightError if the aircraft cannot fly
    level or turn at that speed, or answers the sticks the wrong way round.
    """
    level = trim(model, V=speed, rho=density)
    slower = trim(model, V=0.95 * speed, rho=density)
    turn = trim(model, V=speed, rho=density, bank=VIRTUAL.turn_bank)
    controls, now = model.aircraft.controls, level.controls
    pitch_rate = _steady_rate(model, level, ("alpha", "q"), "de") * controls.de.full_stick_high
    roll_rate = _steady_rate(model, level, ("p",), "da") * controls.da.full_stick_high
    if not (pitch_rate > 0.05 and roll_rate > 0.05):
        raise FlightError(
            "the aircraft responds to the sticks in the wrong direction (full pull "
            f"{math.degrees(pitch_rate):.0f} deg/s, full right {math.degrees(roll_rate):.0f} "
            "deg/s); check Cm_de, Cl_da, and full_stick in the aircraft file"
        )
    pull = (turn.controls["de"] - now["de"]) / (1.0 / math.cos(VIRTUAL.turn_bank) - 1.0)
    return AircraftHandling(
        speed=speed,
        pitch_rate=pitch_rate,
        roll_rate=roll_rate,
        low_rate=(
            controls.de.full_stick_low / controls.de.full_stick_high,
            controls.da.full_stick_low / controls.da.full_stick_high,
            controls.dr.full_stick_low / controls.dr.full_stick_high,
        ),
        pitch=level.state[7],
        trim=now["de"] / controls.de.full_stick_high,
        throttle=now["throttle"],
        throttle_slope=(now["throttle"] - slower.controls["throttle"]) / (0.05 * speed),
        turn_pull=pull / controls.de.full_stick_high,
        turn_roll=turn.controls["da"] / math.sin(VIRTUAL.turn_bank) / controls.da.full_stick_high,
        turn_yaw=turn.controls["dr"] / math.sin(VIRTUAL.turn_bank) / controls.dr.full_stick_high,
        flap_travel=controls.flap.travel[1],
    )


def _steady_rate(model: FlightModel, level: Trim, states: tuple[str, ...], surface: str) -> float:
    linear = linearize(model, level, states=states, inputs=(surface,))
    return float(-np.linalg.solve(linear.A, linear.B)[-1, 0])


StickSourceFactory = Callable[
    [FlightPlan, AircraftHandling, np.random.Generator, float], StickSource
]
"""Makes whoever moves the sticks; the place for a joystick or a keyboard."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FlightSegment:
    """Some successive samples of a flight."""

    first_index: int  # Number of the first sample since the box was switched on.
    times: FloatArray  # Shape (n,). s since then.
    truth: FloatArray  # Shape (n, len(TRUTH)). What really happened, SI.
    volts: FloatArray  # Shape (n, 20). The converter's readings, V.
    onboard_names: tuple[str, ...]
    onboard: FloatArray
    """Shape (n, len(board_names)). What the autopilot-like board knows besides."""
    phases: tuple[str, ...]  # What was being done.

    def __len__(self) -> int:
        return int(self.times.size)


@dataclass(frozen=True, slots=True, kw_only=True)
class FlownManeuver:
    """A maneuver as it was flown."""

    t_start: float
    t_end: float
    """s since the box was switched on; the end is where the pilot took over again."""
    inputs: tuple[str, ...]  # ``de``, ``da``, ``dr``.
    kind: str


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class VirtualFlight:
    """A flight that was flown to its end."""

    truth: Block  # What really happened: `gsapp.virtual.airframe.TRUTH_CHANNELS`, at the CG.
    measured: Block
    """What the ground makes of the converter's volts: `gsapp.virtual.instruments.DAQ_CHANNELS` and
    the combined surfaces (6.1.1)-(6.1.3)."""
    volts: FloatArray  # Shape (n, 20). V.
    phases: tuple[tuple[str, float], ...]  # Each phase with the time at which it began, s.
    maneuvers: tuple[FlownManeuver, ...]
    crashed: bool

    def phase(self, name: str) -> tuple[float, float]:
        """Return begin and end (s) of the first phase of that name.

        Raise FlightError if there was none.
        """
        for index, (phase, start) in enumerate(self.phases):
            if phase == name:
                later = self.phases[index + 1 :]
                return start, later[0][1] if later else float(self.truth.times[-1])
        raise FlightError(
            f"the flight had no phase '{name}'; it had {', '.join(p for p, _ in self.phases)}"
        )


class FlightSimulation:
    """A flight that goes on as far as it is asked to.

    Parameters
    ----------
    model : Model or str
        The aerodynamics; a file or the name of a shipped one.
    seed : int
        Everything random comes from it.
    hide : sequence of str
        Effects that this aircraft has beyond the model, each ``ID[:PARAM=VALUE,..]``.
    faults : sequence of str
        What goes wrong with the instruments besides what the plan says, each
        ``CHANNEL:KIND[:PARAM=VALUE,..]``.
    turbulence : float, optional
        Standard deviation of the gusts, m/s; the plan's if left out.
    rate : float
        Samples a second, Hz.
    dirt : sequence of str
        Kinds of dirt, `gsapp.virtual.dirt.DIRT_KINDS`, or ``all``.
    certificates : str
        Folder or shipped set that turns values into the converter's volts.
    hands : callable, optional
        Makes whoever flies, see `StickSourceFactory`; the human pilot of this package by default.
    airborne : bool
        Begin in level flight where the upwind leg of the pattern begins, not on the runway; `hands`
        must know.
    """

    def __init__(
        self,
        plan: FlightPlan,
        *,
        aircraft: Aircraft,
        model: Model | str = "b777",
        seed: int = 0,
        hide: Sequence[str] = (),
        faults: Sequence[str] = (),
        turbulence: float | None = None,
        dirt: Sequence[str] = (),
        rate: float = 100.0,
        certificates: str | Path = "b777",
        hands: StickSourceFactory | None = None,
        airborne: bool = False,
    ) -> None:
        self._dt = 1.0 / rate
        base = load_model(model) if isinstance(model, str) else model
        random = np.random.default_rng(seed)
        pilot_random, air_random, instrument_random = random.spawn(3)
        self.dirt = draw_dirt(dirt, seed, aircraft)
        flown = add_hidden_effects(aircraft, base, (*hide, *self.dirt.effects))
        actual = self.dirt.apply_to(aircraft)
        air = plan.conditions.turbulence if turbulence is None else turbulence
        self._airframe = Airframe(
            plan,
            actual,
            flown,
            turbulence=air or self.dirt.turbulence,
            random=air_random,
            dt=self._dt,
            is_rotational=self.dirt.turbulence > 0.0,
        )
        # The pilot has learned on this very aircraft, with all that it hides.
        density = self._airframe.density(plan.pattern.height)
        feel = compute_handling(self._airframe.simulator.model, plan.pattern.speed, density)
        if airborne:
            self._airframe.begin_in_air(feel)
        make = _human_pilot if hands is None else hands
        self._hands = make(plan, feel, pilot_random, self._dt)
        self._instruments = Instruments(
            actual,
            instrument_random,
            self._dt,
            (*plan.faults, *(parse_sensor_fault(text) for text in faults)),
            self.dirt,
        )
        self._converter = AnalogDigitalConverter(load_certificates(certificates))
        self._count = 0
        self._crashed = False

    @property
    def finished(self) -> bool:
        return (
            self._hands.finished
            or self._crashed
            or self._count * self._dt >= VIRTUAL.max_flight_duration
        )

    @property
    def crashed(self) -> bool:
        return self._crashed

    @property
    def maneuvers(self) -> tuple[FlownManeuver, ...]:
        return tuple(
            FlownManeuver(t_start=start, t_end=end, inputs=maneuver.inputs, kind=maneuver.shape)
            for start, end, maneuver in _flown_maneuvers(self._hands)
        )

    @property
    def converter(self) -> AnalogDigitalConverter:
        return self._converter

    def advance(self, count: int) -> FlightSegment:
        """Fly on for up to `count` samples."""
        first = self._count
        truth, exposed, board = [], [], []
        phases: list[str] = []
        airframe, hands = self._airframe, self._hands
        while len(phases) < count and not self.finished:
            situation = airframe.aircraft_state()
            sticks = self._with_throttle_moves(hands.move(situation))
            truth.append(airframe.truth())
            exposed.append(airframe.instrument_inputs())
            board.append(airframe.onboard_values())
            phases.append(hands.phase)
            self._count += 1
            airframe.advance(sticks)
            if airframe.has_crashed:
                self._crashed = True
                phases[-1] = "crashed"
        columns = (
            np.array(exposed, dtype=np.float64)
            .reshape(len(phases), len(INSTRUMENT_INPUT_CHANNELS))
            .T
        )
        signals = dict(zip(INSTRUMENT_INPUT_CHANNELS, columns, strict=True))
        speeds = np.column_stack([signals["rpm_left"], signals["rpm_right"]])
        shown = self._instruments.read(signals, speeds)
        return FlightSegment(
            first_index=first,
            times=np.arange(first, self._count, dtype=np.float64) * self._dt,
            truth=np.array(truth, dtype=np.float64).reshape(len(phases), len(TRUTH_CHANNELS)),
            volts=self._converter.volts(shown),
            onboard_names=ONBOARD_CHANNELS,
            onboard=np.array(board, dtype=np.float64).reshape(len(phases), len(ONBOARD_CHANNELS)),
            phases=tuple(phases),
        )

    def _with_throttle_moves(self, sticks: StickPositions) -> StickPositions:
        """Return the sticks with the dirt's throttle moves, which belong to the pattern."""
        if not self._hands.phase.startswith(("pattern", "maneuver")):
            return sticks
        moved = sticks.throttle + self.dirt.throttle_offset(self._count * self._dt)
        return replace(sticks, throttle=min(max(moved, 0.0), 1.0))


def _human_pilot(
    plan: FlightPlan, feel: AircraftHandling, random: np.random.Generator, dt: float
) -> HumanPilot:
    return HumanPilot(plan, feel, random, dt=dt)


def _flown_maneuvers(hands: StickSource) -> list[tuple[float, float, PlannedManeuver]]:
    return hands.flown_maneuvers if isinstance(hands, HumanPilot) else []


def simulate_flight(
    plan: FlightPlan | str | Path = "default",
    *,
    aircraft: Aircraft | str | Path = "b777",
    **options: Any,
) -> VirtualFlight:
    """Fly a plan from switching the box on to engines off; return truth and measurement.

    Plan and aircraft are the things themselves, files, or names of shipped ones; the options are
    those of `FlightSimulation`. Raise GroundStationError if a file holds mistakes, an effect is
    unknown, or the aircraft cannot fly.
    """
    flight = FlightSimulation(
        plan if isinstance(plan, FlightPlan) else load_flight_plan(plan),
        aircraft=aircraft if isinstance(aircraft, Aircraft) else load_aircraft(aircraft),
        **options,
    )
    stretches = []
    while not flight.finished:
        stretches.append(flight.advance(1000))
    times = np.concatenate([stretch.times for stretch in stretches])
    volts = np.concatenate([stretch.volts for stretch in stretches])
    phases: list[tuple[str, float]] = []
    for stretch in stretches:
        for time, phase in zip(stretch.times, stretch.phases, strict=True):
            if not phases or phases[-1][0] != phase:
                phases.append((phase, float(time)))
    return VirtualFlight(
        truth=truth_block(stretches),
        measured=combine_surfaces(flight.converter.convert_to_block(times, volts)),
        volts=volts,
        phases=tuple(phases),
        maneuvers=flight.maneuvers,
        crashed=flight.crashed,
    )


def truth_block(stretches: Sequence[FlightSegment]) -> Block:
    """Return the true motion of successive stretches."""
    return Block(
        channels=TRUTH_CHANNELS,
        times=np.concatenate([stretch.times for stretch in stretches]),
        values=np.concatenate([stretch.truth for stretch in stretches]),
    )


def combine_surfaces(block: Block) -> Block:
    """Return the block with de, da, dr from the surfaces (6.1.1)-(6.1.3)."""
    elevator = 0.5 * (block["elevator_left"] + block["elevator_right"])
    aileron = 0.5 * (block["aileron_left"] + block["aileron_right"])
    return Block(
        channels=(*block.channels, "de", "da", "dr"),
        times=block.times,
        values=np.column_stack([block.values, elevator, aileron, block["rudder"]]),
    )


__all__ = [
    "DAQ_CHANNELS",
    "FlightSegment",
    "FlightSimulation",
    "FlownManeuver",
    "VirtualFlight",
    "combine_surfaces",
    "simulate_flight",
    "truth_block",
]
