"""Which picture of the aircraft belongs to a view."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ui.preflight.aircraft_pose_figure import AircraftPoseFigure
from ui.preflight.surface_motion_view import SurfaceFigure

if TYPE_CHECKING:
    from calibration.plan import InstrumentPlan
    from calibration.wizard import WizardView


def select_figure(view: WizardView) -> SurfaceFigure | AircraftPoseFigure | None:
    """Return the aircraft as it stands, or as it is to be laid or turned."""
    instrument = view.instrument
    if instrument is None:
        return None
    if instrument.is_angle_sensor:
        return _surface_figure(view, instrument)
    if view.phase == "gyro_turn":
        return AircraftPoseFigure(
            kind="turn",
            accessible_text=view.prompt,
            axis=instrument.channel,
            angle=view.target or 0.0,
            turned=view.amount or 0.0,
        )
    if view.phase == "accel_position" and view.position is not None:
        return AircraftPoseFigure(kind="lie", accessible_text=view.prompt, position=view.position)
    if view.phase == "pressure_zero":
        return AircraftPoseFigure(kind="cover", accessible_text=view.prompt)
    if view.phase == "pressure_blow":
        return AircraftPoseFigure(kind="blow", accessible_text=view.prompt)
    return AircraftPoseFigure(kind="still", accessible_text=view.prompt)


def _surface_figure(view: WizardView, instrument: InstrumentPlan) -> SurfaceFigure:
    where = instrument.positive.rpartition(" ")[2]
    settings = [slot.value for slot in view.remaining] + [point.value for point in view.points]
    return SurfaceFigure(
        channel=instrument.channel,
        title=instrument.title,
        view="above" if where in ("left", "right") else "side",
        kind="vane" if instrument.kind == "vane" else "surface",
        sense=1 if where in ("down", "left") else -1,
        ticks=tuple(sorted({*instrument.settings, *settings})),
        angle=view.current_value,
        target=_target_angle(view, instrument),
    )


def _target_angle(view: WizardView, instrument: InstrumentPlan) -> float | None:
    """Return where the surface is wanted; while its sign is proven, well to the positive side."""
    if view.phase == "sign":
        return max(instrument.settings)
    return view.target if view.phase == "points" else None
