"""Broken instruments: samples that drop out, stick or are cut off, and nothing else touched."""

import itertools
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gsapp.aircraft import load_aircraft
from gsapp.cli import fly as fly_command
from gsapp.flight.flight_loader import load_flight
from gsapp.foundation import FileProblemsError, FlightError, read_toml
from gsapp.quantities.constants import DEGREE
from gsapp.virtual.ad_converter import DAQ_CHANNELS
from gsapp.virtual.flight_plan import FlightPlan, load_flight_plan
from gsapp.virtual.sensor_faults import SensorFault, SensorFaultInjector, parse_sensor_fault
from gsapp.virtual.virtual_flight import FlightSegment, FlightSimulation

ALPHA, BETA, Q = (DAQ_CHANNELS.index(name) for name in ("alpha", "beta", "q"))
COUNT = 2200
FAULTS = (
    "alpha:dropout:every=0.9 s,length=0.1 s",
    "beta:stuck:start=5 s,end=12 s",
    "q:clip:low=-0.5 deg/s,high=0.5 deg/s",
)


def _flight(*faults: str) -> FlightSimulation:
    return FlightSimulation(
        load_flight_plan("short"), aircraft=load_aircraft("b777"), seed=3, faults=faults
    )


@pytest.fixture(scope="module")
def whole() -> FlightSegment:
    return _flight().advance(COUNT)


@pytest.fixture(scope="module")
def broken() -> FlightSegment:
    return _flight(*FAULTS).advance(COUNT)


def test_a_fault_breaks_its_own_channel_only(whole: FlightSegment, broken: FlightSegment) -> None:
    assert np.array_equal(broken.truth, whole.truth)
    others = [column for column in range(len(DAQ_CHANNELS)) if column not in (ALPHA, BETA, Q)]
    assert np.array_equal(broken.volts[:, others], whole.volts[:, others])


def test_dropouts_are_open_inputs_of_the_length_and_number_asked_for(
    whole: FlightSegment, broken: FlightSegment
) -> None:
    volts = broken.volts[:, ALPHA]
    gone = volts == 0.0
    assert np.array_equal(volts[~gone], whole.volts[~gone, ALPHA])
    # 22 are to be expected in 22 s; a tenth of the time is gone.
    assert 10 <= np.count_nonzero(np.diff(gone.astype(int)) == 1) <= 40
    assert 0.04 < gone.mean() < 0.2


def test_a_stuck_vane_repeats_the_sample_at_the_beginning(
    whole: FlightSegment, broken: FlightSegment
) -> None:
    volts = broken.volts[:, BETA]
    assert np.ptp(volts[500:1200]) <= 0.002  # the supply still ripples by one count
    assert np.ptp(whole.volts[500:1200, BETA]) > 0.01
    for part in (slice(0, 501), slice(1200, None)):
        assert np.array_equal(volts[part], whole.volts[part, BETA])


def test_clipped_samples_stop_at_the_limit_given_with_its_unit(
    whole: FlightSegment, broken: FlightSegment
) -> None:
    measured = _flight().converter.convert_volts
    assert np.abs(measured(broken.volts)["q"]).max() < 0.6 * DEGREE
    assert np.abs(measured(whole.volts)["q"]).max() > 1.0 * DEGREE


@settings(max_examples=30, deadline=None)
@given(
    cuts=st.lists(st.integers(0, 400), max_size=8),
    kind=st.sampled_from(["dropout", "stuck", "clip"]),
    every=st.sampled_from([None, 0.02, 0.3]),
    start=st.floats(0.0, 3.0),
)
def test_cutting_a_flight_into_other_pieces_breaks_the_same_samples(
    cuts: list[int], kind: str, every: float | None, start: float
) -> None:
    content = {"channel": "alpha", "kind": kind, "start": f"{start} s", "end": "3.5 s"}
    if every is not None:
        content |= {"every": f"{every} s", "length": "0.05 s"}
    if kind == "clip":
        content["low"] = "-1 deg"
    fault = SensorFault.model_validate(content)
    values = np.random.default_rng(0).normal(size=400)
    one = SensorFaultInjector(fault, 0.01, np.random.default_rng(7)).apply(values, 0)
    other = SensorFaultInjector(fault, 0.01, np.random.default_rng(7))
    edges = [0, *sorted(cuts), 400]
    pieces = [other.apply(values[a:b], a) for a, b in itertools.pairwise(edges)]
    assert np.array_equal(np.concatenate(pieces), one, equal_nan=True)


def test_a_plan_can_hold_faults_and_names_all_mistakes(tmp_path: Path) -> None:
    path = tmp_path / "plan.toml"
    path.write_text('[[faults]]\nchannel = "alpha"\nkind = "stuck"\nstart = "10 s"\n')
    plan = read_toml(path, FlightPlan)
    assert plan.faults == (parse_sensor_fault("alpha:stuck:start=10 s"),)
    path.write_text(
        '[[faults]]\nchannel = "alfa"\nkind = "stuck"\n'
        '[[faults]]\nchannel = "alpha"\nkind = "clip"\n'
        '[[faults]]\nchannel = "q"\nkind = "clip"\nhigh = "3 ft"\n'
    )
    with pytest.raises(FileProblemsError) as caught:
        read_toml(path, FlightPlan)
    said = [str(problem) for problem in caught.value.problems]
    assert len(said) == 3
    assert "'alfa'" in said[0]
    assert "one or both" in said[1]
    assert "'ft'" in said[2]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("alpha", "kind"),
        ("alpha:jam", "kind"),
        ("alpha:stuck:from=3", "from: is not a known key"),
        ("alpha:stuck:start", "is not PARAM=VALUE"),
        ("alpha:stuck:start=soon", "does not begin with a number"),
        ("alpha:stuck:start=9 s,end=3 s", "ends before it begins"),
        ("alpha:dropout:every=3 s", "belong together"),
        ("alpha:dropout:every=0 s,length=1 s", "every"),
        ("alpha:stuck:low=3 deg", "belong to clip"),
        ("alpha:clip:low=3 deg,high=-3 deg", "swap 'low' and 'high'"),
    ],
)
def test_what_is_no_fault_gets_one_sentence(text: str, words: str) -> None:
    with pytest.raises(FlightError, match=words) as caught:
        parse_sensor_fault(text)
    assert "\n" not in str(caught.value)


@pytest.mark.long
def test_a_broken_vane_goes_all_the_way_into_the_flight(tmp_path: Path) -> None:
    fly_command.run(out=tmp_path / "flight", plan="short", seed=3, faults=("alpha:stuck",))
    block = load_flight(tmp_path / "flight").block
    spread = {name: np.ptp(block[name][np.isfinite(block[name])]) for name in ("alpha", "beta")}
    assert spread["alpha"] < 1.0 * DEGREE
    assert spread["beta"] > 10.0 * DEGREE
