"""All that a verdict is drawn from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.excitation.doublets.input_measurement import MeasuredInput
from gsapp.excitation.test_points.point import TestPoint
from gsapp.excitation.test_points.stick_text import format_sticks
from gsapp.excitation.test_points.target_input import TargetInput, ToleranceBand
from gsapp.excitation.trim.tolerances import TrimTolerances
from gsapp.flight.cards.card import SURFACE_NAMES as SURFACE_WORDS
from gsapp.flight.maneuvers.input_shape import SurfaceInput
from gsapp.flight.maneuvers.maneuver_grade import GradingContext, pre_input_motion_ratio


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class InputCase:
    """All that a verdict is drawn from.

    Attributes
    ----------
    measured : MeasuredInput
    kind : str
        Shape of the main input.
    target_input : TargetInput or None
        None where nothing is known of what is wanted: shape and answer alone are judged.
    point : TestPoint or None
    setting : GradingContext
    tolerances : TrimTolerances
    known_aircraft : bool
        Whether there is an aircraft file.
    system : {"US", "SI"}
        Units of the words.
    """

    measured: MeasuredInput
    kind: str
    target_input: TargetInput | None
    point: TestPoint | None
    setting: GradingContext
    tolerances: TrimTolerances
    known_aircraft: bool = True
    system: str = "US"

    @property
    def aircraft(self) -> Aircraft:
        """Return the aircraft."""
        return self.setting.aircraft

    @property
    def dt(self) -> float:
        """Return the time between samples, s."""
        return float(np.median(np.diff(self.measured.passage.times)))

    def stick_text(self, surface: str) -> str:
        """Return the deflection wanted of a surface in the pilot's words.

        One position of the rate switch serves all surfaces of the input.
        """
        asked = {one.surface: self.amplitude_band(one.surface) for one in self.measured.inputs}
        best = {name: band.best for name, band in asked.items() if band is not None}
        aircraft = self.aircraft if self.known_aircraft else None
        return format_sticks(aircraft, best, rate_switch=self.measured.rate_switch)[surface]

    def describe_input(self, one: SurfaceInput) -> str:
        """Return what an input is called: "rudder doublet"."""
        return f"{SURFACE_WORDS[one.surface]} {one.kind}"

    @property
    def pre_input_motion_ratio(self) -> float:
        """Return the unrest before the input over its answer, as the grader measures it."""
        return pre_input_motion_ratio(self.measured.passage, self.setting, self.measured.surfaces)[
            0
        ]

    def amplitude_band(self, surface: str) -> ToleranceBand | None:
        """Return the amplitudes wanted of a surface; None where none are known."""
        return None if self.target_input is None else self.target_input.amplitudes.get(surface)
