"""What cards, and inputs that no card asks for, want: test point, amplitudes, stick words."""

from __future__ import annotations

from collections.abc import Mapping

from gsapp.aircraft import Aircraft
from gsapp.dynamics.atmosphere import SEA_LEVEL_DENSITY
from gsapp.dynamics.model import Model
from gsapp.excitation.doublets.verdict import InputVerdict
from gsapp.excitation.settings import CUES
from gsapp.excitation.test_points.point import TestPoint
from gsapp.excitation.test_points.point_builder import (
    TestPointError,
    create_point_at,
    create_test_point,
)
from gsapp.excitation.test_points.target_input import TargetInput
from gsapp.excitation.test_points.target_selection import select_target_input
from gsapp.excitation.test_points.trim_curve import TrimCurve
from gsapp.flight.cards import TestCard
from gsapp.identification.ftr.estimates import LiveEstimate


class CardTargets:
    """Finds and remembers wants; the same question costs nothing the second time.

    Parameters
    ----------
    system : {"US", "SI"}
        Units of the sentences.
    """

    def __init__(self, aircraft: Aircraft | None, model: Model | None, system: str) -> None:
        self._aircraft = aircraft
        self._model = model
        self._system = system
        self.restart()

    def restart(self) -> None:
        """Forget the day and the flight."""
        self._density = SEA_LEVEL_DENSITY
        self._steady: list[tuple[float, float]] = []
        self._estimates: Mapping[str, LiveEstimate] = {}
        self._noise: Mapping[str, float] = {}
        self._forget()

    def _forget(self) -> None:
        self._curves: dict[float, TrimCurve] = {}  # of the day, by flap
        self._shifted: dict[float, TrimCurve] = {}  # those with alpha as it was measured
        self._points: dict[str, tuple[TestPoint | None, str]] = {}
        self._wanted: dict[tuple[object, ...], TargetInput] = {}

    def use_units(self, system: str) -> None:
        """Say what is wrong with a card in these units, ``US`` or ``SI``, from now on."""
        self._system = system
        self._points.clear()

    def set_density(self, density: float) -> None:
        """Take the air of the day, kg/m^3."""
        self._density = density
        self._forget()

    def set_noise(self, noise: Mapping[str, float]) -> None:
        """Take the noise of the day, by channel, SI: what an input must stand out of."""
        self._noise = noise
        self._wanted.clear()

    def set_estimates(self, estimates: Mapping[str, LiveEstimate]) -> None:
        """Let wanted inputs follow from derivatives estimated in this flight."""
        self._estimates = estimates
        self._wanted.clear()

    def update_trim_alpha(self, verdict: InputVerdict) -> None:
        """Learn where the vane stands in trimmed flight, from an input that began in trim."""
        off = any(finding.result == "not-trimmed" for finding in verdict.findings)
        if verdict.V is None or verdict.alpha is None or off:
            return
        self._steady.append((verdict.V, verdict.alpha))
        self._shifted.clear()
        self._points.clear()

    def point(self, card: TestCard) -> tuple[TestPoint | None, str]:
        """Return the test point of a card; None, and why, where it cannot be flown."""
        found = self._points.get(card.id)
        if found is None:
            try:
                curve = self._curve(card.flap)
                found = create_test_point(card, curve, system=self._system), ""
            except TestPointError as error:
                found = None, f"card {card.id}: {error}"
            self._points[card.id] = found
        return found

    def target_input(self, card: TestCard) -> TargetInput:
        """Return what a card wants, within what the aircraft and its sensors allow."""
        found = self._wanted.get((card.id,))
        if found is None:
            found = self._wanted[(card.id,)] = select_target_input(
                card.surfaces,
                card.kind,
                aircraft=self._aircraft,
                model=self._model,
                point=self.point(card)[0],
                card=card,
                noise=self._noise,
                estimates=self._estimates,
            )
        return found

    def target_without_card(
        self, surfaces: tuple[str, ...], kind: str, V: float | None
    ) -> TargetInput:
        """Return what is wanted of an input that no card asks for, at an airspeed (m/s)."""
        near = None if V is None else round(V / CUES.same_speed)
        key = (surfaces, kind, near)
        found = self._wanted.get(key)
        if found is None:
            speed = None if near is None else near * CUES.same_speed
            found = self._wanted[key] = select_target_input(
                surfaces,
                kind,
                aircraft=self._aircraft,
                model=self._model,
                point=self.point_without_card(speed),
                noise=self._noise,
                estimates=self._estimates,
            )
        return found

    def point_without_card(self, speed: float | None) -> TestPoint | None:
        """Return level flight at an airspeed (m/s); None where there is none."""
        if speed is None:
            return None
        try:
            return create_point_at(speed=speed, curve=self._curve(0.0), system=self._system)
        except TestPointError:
            return None

    def _curve(self, flap: float) -> TrimCurve | None:
        if self._aircraft is None or self._model is None:
            return None
        if flap not in self._curves:
            made = TrimCurve(self._aircraft, self._model, rho=self._density, flap=flap)
            self._curves[flap] = made
        if flap not in self._shifted:
            self._shifted[flap] = self._curves[flap].with_measured_alpha(self._steady)
        return self._shifted[flap]
