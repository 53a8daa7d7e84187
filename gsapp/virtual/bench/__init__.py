"""A virtual aircraft on the ground, to calibrate: volts as its box sends them, and the truth."""

from gsapp.virtual.bench.bench_faults import (
    BENCH_FAULT_KINDS,
    BenchFault,
    parse_bench_fault,
)
from gsapp.virtual.bench.potentiometer import (
    POTENTIOMETER_TRAVEL,
    POTENTIOMETERS,
    SURFACE_POTENTIOMETERS,
    VANE_POTENTIOMETERS,
    Potentiometer,
)
from gsapp.virtual.bench.transducers import SensorTriad, Transducer
from gsapp.virtual.bench.virtual_bench import BenchWeather, VirtualBench

__all__ = [
    "BENCH_FAULT_KINDS",
    "POTENTIOMETERS",
    "POTENTIOMETER_TRAVEL",
    "SURFACE_POTENTIOMETERS",
    "VANE_POTENTIOMETERS",
    "BenchFault",
    "BenchWeather",
    "Potentiometer",
    "SensorTriad",
    "Transducer",
    "VirtualBench",
    "parse_bench_fault",
]
