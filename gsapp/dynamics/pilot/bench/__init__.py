"""A virtual aircraft on the ground, to calibrate: volts as its box sends them, and the truth."""

from gsapp.dynamics.pilot.bench.faults import KINDS, BenchFault, parse_bench_fault
from gsapp.dynamics.pilot.bench.field_air import BenchWeather
from gsapp.dynamics.pilot.bench.potentiometer import (
    POTENTIOMETERS,
    SURFACES,
    TRAVEL,
    VANES,
    Potentiometer,
)
from gsapp.dynamics.pilot.bench.transducers import Transducer, Triad
from gsapp.dynamics.pilot.bench.virtual import RATE, VirtualBench

__all__ = [
    "KINDS",
    "POTENTIOMETERS",
    "RATE",
    "SURFACES",
    "TRAVEL",
    "VANES",
    "BenchFault",
    "BenchWeather",
    "Potentiometer",
    "Transducer",
    "Triad",
    "VirtualBench",
    "parse_bench_fault",
]
