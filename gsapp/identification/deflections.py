"""Surfaces of which only the command, or the servo, was recorded: where they really stood.

An autopilot logs what it asks of its servos. Between that and the surface lie delay, lag and rate
limit of the servo and play in the linkage. Left out, a lag of 0.04 s halves the roll damping of a
light aircraft, whose roll mode is as quick as the servo, and the fit looks none the worse. The
aircraft file says where each control is measured and what lies beyond; here the record is sent
along that way.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from gsapp.aircraft import Aircraft, Control
from gsapp.dynamics.actuators import control_paths, simulate_control_path
from gsapp.flight.maneuvers.signals import SURFACES
from gsapp.flight.uniform_grid import median_step
from gsapp.identification.preparation_settings import PREPARATION
from gsapp.identification.smoothing import interpolate_missing
from gsapp.quantities import Block, FloatArray

COMMAND_CHANNELS: Mapping[str, str] = {name: f"{name}_command" for name in SURFACES}
"""The channel of what was asked of each surface's servo."""


def reconstruct_deflections(block: Block, aircraft: Aircraft) -> Block:
    """Return a block with de, da and dr as the surfaces stood; even spacing is assumed.

    A control that is measured on the surface stays as it is. One of ``kind = "servo"`` passes the
    linkage, one of ``kind = "command"`` its travel, the servo and the linkage; where such a flight
    has no ``de``, its ``de_command`` is taken.

    Parameters
    ----------
    block : Block
        From some time before the surfaces move: the way is taken as at rest in the beginning.
    aircraft : Aircraft
    """
    if len(block) < 2:
        return block
    dt = median_step(block.times)
    found = {}
    for name in SURFACES:
        control: Control = getattr(aircraft.controls, name)
        record = _command_record(block, name, control)
        if record is not None:
            found[name] = _actuator_response(record, aircraft, name, control, dt)
    if not found:
        return block
    kept = [name for name in block.channels if name not in found]
    rest = block.select(kept)
    return Block(
        channels=(*rest.channels, *found),
        times=block.times,
        values=np.column_stack((rest.values, *found.values())),
    )


def unmodeled_servos(block: Block, aircraft: Aircraft) -> tuple[str, ...]:
    """Return the surfaces that moved, recorded as commands to a servo of which nothing is said."""
    return tuple(
        name
        for name in SURFACES
        if (control := getattr(aircraft.controls, name)).kind == "command"
        and not control_paths(aircraft, name)[0]
        and (record := _command_record(block, name, control)) is not None
        and np.nanmax(record) > np.nanmin(record)
    )


def _command_record(block: Block, name: str, control: Control) -> FloatArray | None:
    """Return the record of a control that is not measured on its surface; None without one."""
    if control.kind == "position":
        return None
    sources = (name, COMMAND_CHANNELS[name]) if control.kind == "command" else (name,)
    for source in sources:
        if source in block and np.isfinite(block[source]).any():
            return block[source]
    return None


def _actuator_response(
    record: FloatArray, aircraft: Aircraft, name: str, control: Control, dt: float
) -> FloatArray:
    """Return where the surface stood, missing where it hangs on missing samples."""
    servo, linkage = control_paths(aircraft, name)
    path = linkage if control.kind == "servo" else (*servo, *linkage)
    lost = ~np.isfinite(record)
    whole = interpolate_missing(record, lost)
    if control.kind == "command":
        whole = np.clip(whole, *control.travel)
    found = simulate_control_path(path, whole, dt)
    reach = found.tangent(lost.astype(np.float64)[:, None])[:, 0]
    return np.where(lost | (np.abs(reach) > PREPARATION.max_missing_share), np.nan, found.values)
