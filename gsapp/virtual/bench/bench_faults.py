"""What can be wrong with an instrument before a flight.

``CHANNEL:KIND``, and for two plugs that are swapped ``CHANNEL:swapped:with=CHANNEL``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from gsapp.foundation import FlightError
from gsapp.foundation.name_suggestions import did_you_mean
from gsapp.quantities import INSTRUMENTS
from gsapp.virtual.bench.potentiometer import POTENTIOMETERS
from gsapp.virtual.bench.transducers import ACCELEROMETERS, GYROS

BenchFaultKind = Literal["dead", "reversed", "swapped", "noisy", "clipped"]
BENCH_FAULT_KINDS: tuple[BenchFaultKind, ...] = get_args(BenchFaultKind)
REVERSIBLE_CHANNELS = (*POTENTIOMETERS, *GYROS, *ACCELEROMETERS, "dynamic_pressure")
"""What can be mounted, or have its hoses, the other way round."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BenchFault:
    """One thing that is wrong."""

    channel: str
    kind: BenchFaultKind
    """``dead``: its volts stay where they are, or its wire is open and reads nothing. ``reversed``:
    mounted the other way round. ``swapped``: its plug and that of `other` are exchanged. ``noisy``:
    a bad contact. ``clipped``: its volts run into the end of the converter within its travel."""
    other: str = ""  # Of ``swapped``.


def parse_bench_fault(text: str) -> BenchFault:
    """Read a fault from one line, such as ``elevator_left:swapped:with=elevator_right``.

    Raise FlightError if it says something else.
    """
    name, _, rest = text.partition(":")
    kind, _, rest = rest.partition(":")
    name, kind = name.strip(), kind.strip()
    if name not in INSTRUMENTS:
        hint = did_you_mean(name, INSTRUMENTS, f"choose one of {', '.join(INSTRUMENTS)}")
        raise FlightError(f"'{text}': no instrument is called '{name}'; {hint}")
    if kind not in BENCH_FAULT_KINDS:
        hint = did_you_mean(
            kind, BENCH_FAULT_KINDS, f"choose one of {', '.join(BENCH_FAULT_KINDS)}"
        )
        raise FlightError(f"'{text}': '{kind}' is not a fault; {hint}")
    key, _, other = (part.strip() for part in rest.partition("="))
    if kind == "swapped":
        if key != "with" or other not in INSTRUMENTS or other == name:
            raise FlightError(
                f"'{text}' needs the other channel; write for example "
                "elevator_left:swapped:with=elevator_right"
            )
    elif kind == "reversed" and name not in REVERSIBLE_CHANNELS:
        raise FlightError(f"'{text}': {name} cannot be reversed; choose another fault")
    elif rest:
        raise FlightError(f"'{text}': {kind} has no options; remove '{rest}'")
    return BenchFault(channel=name, kind=kind, other=other)
