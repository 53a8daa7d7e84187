"""From the sticks to the surfaces: rate switch, servos, linkages, and what the effects do there."""

from __future__ import annotations

import numpy as np

from gsapp.aircraft import Control
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.pilot.hands import Sticks
from gsapp.dynamics.signals import SignalPath, SignalTerm
from gsapp.dynamics.terms import make_term

_NAMES = ("elevator", "aileron", "rudder", "flap")

_RIGGING = 0.002
"""Standard deviation by which left and right surface differ, rad."""


class _Servo:
    """One control: command, servo, linkage, surface."""

    def __init__(self, name: str, control: Control, flight_model: FlightModel, dt: float) -> None:
        self._control = control
        aircraft = flight_model.aircraft

        def term(kind: str) -> SignalTerm:
            made = make_term(f"control.{name}.{kind}", aircraft)
            assert isinstance(made, SignalTerm)
            return made

        drive: list[tuple[SignalTerm, tuple[float, ...]]] = []
        if control.delay > 0.0:
            drive.append((term("delay"), (control.delay,)))
        if control.lag > 0.0:
            drive.append((term("lag"), (control.lag,)))
        drive.append((term("rate"), (control.rate_limit,)))
        self._drive = SignalPath(tuple(drive), dt)
        linkage: list[tuple[SignalTerm, tuple[float, ...]]] = []
        if control.slop > 0.0:
            linkage.append((term("backlash"), (control.slop,)))
        for effect, values in flight_model.control_terms.get(name, ()):
            assert isinstance(effect, SignalTerm)
            linkage.append((effect, values))
        self._linkage = SignalPath(tuple(linkage), dt)
        self.command = self.servo = self.surface = 0.0

    def advance(self, command: float) -> None:
        low, high = self._control.travel
        self.command = min(max(command, low), high)
        self.servo = self._drive.step(self.command)
        self.surface = min(max(self._linkage.step(self.servo), low), high)

    @property
    def shown(self) -> float:
        """Return the angle that is recorded: where the aircraft file says it is measured."""
        kind = self._control.kind
        return self.surface if kind == "position" else self.servo if kind == "servo" else self.command


class Surfaces:
    """All controls of one aircraft.

    Parameters
    ----------
    flight_model : FlightModel
        Aircraft and effects on the control paths.
    random : numpy.random.Generator
        For the rigging of the day.
    dt : float
        Step, s.
    """

    def __init__(
        self, flight_model: FlightModel, random: np.random.Generator, dt: float
    ) -> None:
        controls = flight_model.aircraft.controls
        self._controls = (controls.de, controls.da, controls.dr, controls.flap)
        self._servos = tuple(
            _Servo(name, control, flight_model, dt)
            for name, control in zip(_NAMES, self._controls, strict=True)
        )
        rigging = _RIGGING * random.standard_normal(2)
        self._rigging = (float(rigging[0]), float(rigging[1]))
        self.advance(Sticks())

    def advance(self, sticks: Sticks) -> None:
        """Go on by one step."""
        for servo, control, stick in zip(
            self._servos[:3], self._controls[:3], (sticks.pitch, sticks.roll, sticks.yaw),
            strict=True,
        ):  # fmt: skip
            full = control.full_stick_high if sticks.high_rate else control.full_stick_low
            servo.advance(full * stick)
        self._servos[3].advance(self._controls[3].travel[1] * sticks.flap)

    @property
    def positions(self) -> tuple[float, float, float, float]:
        """Return de, da, dr and flap, rad."""
        de, da, dr, flap = (servo.surface for servo in self._servos)
        return de, da, dr, flap

    @property
    def commands(self) -> tuple[float, float, float]:
        """Return what the receiver asks of the servos: de, da, dr, rad."""
        de, da, dr, _ = (servo.command for servo in self._servos)
        return de, da, dr

    @property
    def servo_shares(self) -> tuple[float, float, float, float]:
        """Return the pulses to the servos: -1 to 1 of full travel, the flap's 0 to 1."""
        shares = [
            servo.command / control.travel[1]
            for servo, control in zip(self._servos, self._controls, strict=True)
        ]
        return shares[0], shares[1], shares[2], shares[3]

    @property
    def shown(self) -> tuple[float, float, float, float, float]:
        """Return elevator left and right, aileron left and right, rudder as recorded, rad."""
        de, da, dr, _ = (servo.shown for servo in self._servos)
        elevator, aileron = self._rigging
        return de + elevator, de - elevator, da + aileron, da - aileron, dr


