"""An instrument that is not as the aircraft file says, and records corrected for it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from gsapp.identification.compatibility.results import format_error_with_bound
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.record_preparation import (
    advance_channels,
    advance_flags,
    subtract_biases,
)
from gsapp.quantities.fields import Position

ACCELEROMETER = "accelerometer"
"""In the place of a channel, where all three accelerometers are meant."""


@dataclass(frozen=True, slots=True, kw_only=True)
class InstrumentError:
    """An instrument that is not as the aircraft file says.

    Attributes
    ----------
    channel : str
        `ACCELEROMETER` for the position of the accelerometers.
    kind : {"position", "delay", "bias", "scale"}
    value, std : float
        Distance of a vane ahead, or of the accelerometers to the right, of the position in the
        aircraft file, m; delay, s; zero of a vane, rad; what a vane shows over what it should.
    position : tuple of float or None
        Of a vane or the accelerometers, from the CG of the aircraft file, m.
    file_value : float or None
        What the aircraft file should state of a vane: its zero (rad), or its upwash.
    alternatives : tuple of str
        What explains the records as well: names of errors, as ``q.delay``, or words.
    """

    channel: str
    kind: str
    value: float
    std: float
    position: Position | None = None
    file_value: float | None = None
    alternatives: tuple[str, ...] = ()
    rivals: tuple[Mapping[str, float], ...] = ()
    """Of a position or a delay: the errors, with their values (SI), that explain the records as
    well in its place; several in one where only together."""

    @property
    def is_ambiguous(self) -> bool:
        """Return whether a delay explains the records as well as a position, or the other way."""
        return any(not name.endswith(f".{self.kind}") for one in self.rivals for name in one)

    @property
    def section(self) -> str:
        """Return the section of the aircraft file below ``sensors``."""
        return self.channel if self.channel == ACCELEROMETER else f"{self.channel}_vane"

    @property
    def file_entry(self) -> tuple[str, float] | None:
        """Return what `gsapp.aircraft.write_sensor_values` is to write: its key and value (SI).

        None where the section cannot hold it, or a delay explains the records as well.
        """
        if self.is_ambiguous:
            return None
        if self.position is not None:
            return self.axis, self.position["xyz".index(self.axis)]
        if self.file_value is None:
            return None
        return {"bias": "bias", "scale": "upwash"}[self.kind], self.file_value

    @property
    def axis(self) -> str:
        """Return the body axis along which a position is off."""
        return "y" if self.channel == ACCELEROMETER else "x"

    @property
    def text(self) -> str:
        """Return it as a sentence."""
        if self.is_ambiguous:
            return self._ambiguous_text()
        name = f"{self.channel}.{self.kind}"
        shown = self.value if self.kind == "scale" else abs(self.value)
        value, std = format_error_with_bound(name, shown, self.std)
        spread = f"{value} \N{PLUS-MINUS SIGN} {std}"
        doubt = ""
        if self.alternatives:
            doubt = f" (these maneuvers do not rule out {' or '.join(self.alternatives)} instead)"
        section = f"sensors.{self.section}"
        if self.kind == "bias":
            way = "too much" if self.value > 0.0 else "too little"
            stated, _ = format_error_with_bound(name, self.file_value or 0.0, self.std)
            return (
                f"the {self.channel} vane appears to show {spread} {way} against the axes of the "
                f'gyros{doubt}, and is corrected: state {section}.bias = "{stated}"'
            )
        if self.kind == "scale":
            return (
                f"the {self.channel} vane appears to show {spread} times what the aircraft file "
                f"says{doubt}, and is corrected: state {section}.upwash = {self.file_value:.3g}"
            )
        if self.position is None:
            return (
                f"{self.channel} appears to be {spread} late{doubt}, and "
                "is used at its right time: state its lag or delay in the aircraft file"
            )
        sides = {"x": ("ahead of", "behind"), "y": ("to the right of", "to the left of")}[self.axis]
        side = sides[self.value < 0.0]
        instrument = self.section.replace("_", " ")
        place = self.position["xyz".index(self.axis)]
        return (
            f"the {instrument} appears to be {spread} {side} its "
            f"position in the aircraft file{doubt}, and is used there: correct "
            f"{section}.position to {self.axis} = {place:.4g} m"
        )

    def _ambiguous_text(self) -> str:
        value, std = format_error_with_bound(
            f"{self.channel}.{self.kind}", abs(self.value), self.std
        )
        own = _error_text(
            f"{self.channel}.{self.kind}", self.value, f"{value} \N{PLUS-MINUS SIGN} {std}"
        )
        others = [
            " and ".join(
                _error_text(
                    name, value, format_error_with_bound(name, abs(value), 0.1 * abs(value))[0]
                )
                for name, value in one.items()
            )
            for one in self.rivals
        ]
        return (
            f"these maneuvers do not tell whether {own}, or {', or '.join(others)}; the former is "
            "used: fly the same input at two speeds (a delay stays, a position shows less at the "
            "higher speed), or measure the position"
        )


def _error_text(name: str, value: float, size: str) -> str:
    """Return a delay or the position of a vane as a clause."""
    channel, _, kind = name.partition(".")
    if kind == "delay":
        return f"{channel} is {size} {'late' if value > 0.0 else 'early'}"
    side = "ahead of" if value > 0.0 else "behind"
    return f"the {channel} vane is {size} {side} its position in the aircraft file"


def correct_instruments(maneuver: Maneuver, errors: Sequence[InstrumentError]) -> Maneuver:
    """Return a maneuver with its instruments where they were found and its channels on time."""
    if not errors:
        return maneuver
    sensors = maneuver.aircraft.sensors
    delays = {one.channel: one.value for one in errors if one.kind == "delay"}
    clipped = {
        name: advance_flags(flags, delays[name] / maneuver.dt) if name in delays else flags
        for name, flags in maneuver.clipped.items()
    }
    block = advance_channels(maneuver.block, delays)
    block = subtract_biases(block, {one.channel: one.value for one in errors if one.kind == "bias"})
    for one in errors:
        if one.kind not in {"position", "scale"}:
            continue
        sensor = getattr(sensors, one.section)
        if one.kind == "scale":
            changed = {"upwash": sensor.upwash * one.value}
        else:
            place = list(sensor.position)
            place["xyz".index(one.axis)] += one.value
            changed = {"position": tuple(place)}
        sensors = sensors.model_copy(update={one.section: sensor.model_copy(update=changed)})
    aircraft = maneuver.aircraft.model_copy(update={"sensors": sensors})
    return replace(maneuver, aircraft=aircraft, block=block, clipped=clipped)
