"""Run the benchmarks: ratios measured side by side on this machine, never pass or fail.

python3 packaging/bootstrap.py bench               all but those below
python3 packaging/bootstrap.py bench strips framing
python3 packaging/bootstrap.py bench peers         MAVProxy between aircraft and recorder
python3 packaging/bootstrap.py bench sharing 60    a flight shared with MAVProxy and seven others
python3 packaging/bootstrap.py bench day           by mouse and keys; needs Xvfb, xdotool, openbox
python3 packaging/bootstrap.py bench real FOLDER real flights with published derivatives
python3 packaging/bootstrap.py bench dirt 40 lags,clock    fewer flights, some kinds of dirt
python3 packaging/bootstrap.py bench fuzz 1200     damaged files for every reader, for 20 minutes
python3 packaging/bootstrap.py bench faults 500    faults at random moments of a flight
python3 packaging/bootstrap.py bench soak 60      the window for an hour of real time
python3 packaging/bootstrap.py bench memory 480   eight simulated hours of a flight
python3 packaging/bootstrap.py bench many_flights 60    flown, and estimated on all cores
python3 packaging/bootstrap.py bench fleet 1000    searches of a catalog of small flights: 15 min
python3 packaging/bootstrap.py bench discrepancy   blind cases: hours; --quick takes a tenth
python3 packaging/bootstrap.py bench deciding_experiment   open searches decided: an hour
"""

import importlib.util
import os
import platform
import sys
import time
from pathlib import Path
from types import ModuleType

HERE = Path(__file__).parent
# What each shows, in the order in which they run.
BENCHMARKS = {
    "framing": "framing, decoding and mapping against pymavlink",
    "strips": "screen updates against pyqtgraph; share of a core; memory over an hour",
    "latency": "arrival to painted pixels",
    "window": "start of the program to its first useful picture",
    "memory": "memory over a simulated hour, down the whole road; MINUTES",
    "many_flights": "estimates of many flights: processes, Dask, a killed worker; COUNT, FOLDER",
    "fleet": "a catalog of a thousand small flights: searches, trends, changes; COUNT, FILE",
    "detection": "maneuver detection over a ten-minute flight",
    "ftr": "Fourier transform regression: samples a second, errors over bounds",
    "likelihood": "maximum likelihood over a campaign, against other programs",
    "truth": "errors over bounds, many seeds, colored noise, gusts; ML and filter error",
    "dirt": "errors over bounds in 200 dirty flights; COUNT, KINDS, first seed (see its head)",
    "jsbsim_truth": "derivatives known to JSBSim, found by four methods, in calm air and gusts",
    "campaign": "fourteen flights like the source's, estimated untouched by hand",
    "inertial": "gyros, accelerometers, pressures: errors over stated uncertainties, 200 aircraft",
    "linear_models": "three linear models beside the published table",
    "wanted_inputs": "inputs asked for, flown: limits used, noise left behind, best width",
    "discrepancy_speed": "CPU of a search for a missing effect, by phase",
    "discrepancy": "effects hidden in flights that JSBSim flew, named blind (hours)",
    "deciding_experiment": "experiments designed for open searches, flown: decided, separation",
    "live_search": "effects named during a flight, and falsely; CPU of a search (an hour)",
    "wizard": "the calibration wizard: keys, minutes, errors over bounds, faults named",
    "wizard_window": "the wizard's page: errors over bounds and faults named, 200 aircraft",
    "dangers": "false dangers over 40 whole flights; failing instruments named, and how late",
    "calibrations": "angles and hysteresis against the truth, faults named, drift found",
    "trim_cue": "GO against the simulator's states: given rightly and soon, by air and instruments",
    "information": "bounds expected against those reported; the band before a maneuver; its cost",
    "verdicts": "verdicts on 300 virtual inputs against the truth; how late they are",
    "cue_cost": "cues of a live flight: share of a core, telemetry to cue",
    "review": "opening a ten-minute flight for review, and working on its time line",
    "estimates_live": "a live flight with and without derivatives forming: frames, cues, losses",
    "day": "a day at the field by mouse and keys in a real X server, with screenshots",
    "real": "ATTAS and HFB-320 by default, beside published derivatives; their data in FOLDER",
    "fuzz": "every reader of a file under mutation; SECONDS, READERS, first seed (see its head)",
    "soak": "the window for a real hour: memory, handles, frames, latency; MINUTES (see its head)",
    "faults": "faults in flight: bytes lost, alarms, recovery; RUNS, FIRST_SEED, FAULTS",
    "sharing": "a flight shared with eight clients, one of them stuck: bytes lost, CPU; SECONDS",
    "peers": "MAVProxy between the virtual aircraft and the recorder; logs fetched both ways",
}
ONLY_WHEN_NAMED = {
    "fuzz", "peers", "sharing", "discrepancy", "deciding_experiment", "live_search", "day", "real",
    "dirt", "soak", "faults", "many_flights", "fleet",
}  # fmt: skip
WITH_ARGUMENTS = {
    "real",
    "dirt",
    "fuzz",
    "soak",
    "memory",
    "faults",
    "sharing",
    "many_flights",
    "fleet",
}


def load(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"bench_{name}", HERE / f"{name}.py")
    if spec is None or spec.loader is None:
        raise FileNotFoundError(f"no benchmark is called {name}")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def main(arguments: list[str]) -> int:
    """Run the benchmarks named, or all; return the exit code."""
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    options = [argument for argument in arguments if argument.startswith("-")]
    names = [argument for argument in arguments if not argument.startswith("-")]
    given = names[1:] if names[:1] and names[0] in WITH_ARGUMENTS else []
    names = names[: len(names) - len(given)]
    unknown = [name for name in names if name not in BENCHMARKS]
    if unknown or set(options) - {"--quick", "--plain"}:
        print(__doc__)
        print("\n".join(f"  {name:17} {what}" for name, what in BENCHMARKS.items()))
        return 2
    print(f"{platform.platform()}, Python {platform.python_version()}, {os.cpu_count()} cores")
    for name in names or [name for name in BENCHMARKS if name not in ONLY_WHEN_NAMED]:
        print(f"\n=== {name}: {BENCHMARKS[name]}", flush=True)
        started = time.monotonic()
        load(name).main(*given, *options)
        print(f"=== {name}: {time.monotonic() - started:.0f} s", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
