"""The pilot's transmitter as it was set up for a flight: dual rates, mixers, trims."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from pydantic import Field, model_validator

from gsapp.foundation import StrictModel
from gsapp.quantities.fields import Ratio

Lever = Literal["elevator", "aileron", "rudder", "throttle", "flap", "gear"]
Stick = Literal["elevator", "aileron", "rudder"]

MAX_THROW = 1.5
"""No transmitter gives more than this share of the usual throw."""


class DualRate(StrictModel):
    """Throw of one stick at either position of the rate switch."""

    high: Ratio = 1.0
    low: Ratio = 1.0
    """Shares of the full throw."""
    expo: Ratio = 0.0
    """Softness about the center: 0 is a straight line, 1 all cubic."""

    @model_validator(mode="after")
    def _must_make_sense(self) -> DualRate:
        if not 0.0 < self.low <= self.high <= MAX_THROW:
            raise ValueError(
                'needs 0 % < low <= high <= 150 %; write for example high = "100 %", low = "60 %"'
            )
        if not -1.0 <= self.expo <= 1.0:
            raise ValueError("expo lies from -100 % to 100 %; write it as the transmitter shows it")
        return self


class Mixer(StrictModel):
    """One lever that moves another's servo as well."""

    source: Lever
    target: Lever
    """``aileron`` with target ``rudder`` turns the rudder with the ailerons."""
    share: Ratio
    """Of the target's throw at full throw of the source."""

    @model_validator(mode="after")
    def _must_make_sense(self) -> Mixer:
        if self.source == self.target:
            raise ValueError("mixes a lever into itself; name another target")
        if not abs(self.share) <= MAX_THROW:
            raise ValueError('share is beyond 150 %; write for example "15 %"')
        return self


class Transmitter(StrictModel):
    """What the pilot's transmitter does with the sticks."""

    model: str = ""
    """Make and memory, in words."""
    rate: Literal["high", "low"] | None = None
    """Position of the rate switch at take-off."""
    dual_rates: Mapping[Stick, DualRate] = Field(default_factory=dict)
    """``elevator``, ``aileron``, ``rudder``."""
    mixers: tuple[Mixer, ...] = ()
    trims: Mapping[Lever, Ratio] = Field(default_factory=dict)
    """Trim levers at take-off as shares of full stick; signs as of the sticks: nose up, right wing
    down, nose right positive."""
    remarks: str = ""

    @model_validator(mode="after")
    def _must_make_sense(self) -> Transmitter:
        for lever, trim in self.trims.items():
            if not abs(trim) <= 1.0:
                raise ValueError(
                    f'the trim of the {lever} is beyond 100 %; write for example "4 %"'
                )
        return self
