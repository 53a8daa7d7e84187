"""A virtual aircraft on the ground, to calibrate: volts as its box sends them, and the truth."""

from gsapp.virtual.bench.bench_instruments import (
    BENCH_FAULT_KINDS,
    POTENTIOMETER_TRAVEL,
    POTENTIOMETERS,
    SURFACE_POTENTIOMETERS,
    VANE_POTENTIOMETERS,
    BenchFault,
    Potentiometer,
    SensorTriad,
    Transducer,
    parse_bench_fault,
)
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
