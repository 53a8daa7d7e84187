"""Channel maps: what ships is sound, and every mistake has a place and a remedy."""

from pathlib import Path

import pytest

from calibration import load_certificates
from gsapp.decoding.channel_map import load_channel_map, shipped_channel_maps
from gsapp.foundation import FileProblemsError, UnknownNameError
from tests.decoding.decoding_kit import write_map

MAPS = ["ardupilot-log", "ardupilot-plane", "b777", "b777-thin", "px4", "px4-log"]


def test_all_maps_ship() -> None:
    assert set(MAPS) <= set(shipped_channel_maps())
    with pytest.raises(UnknownNameError, match="b777"):
        load_channel_map("b77")


@pytest.mark.parametrize("name", MAPS)
def test_shipped_maps_load(name: str) -> None:
    chosen = load_channel_map(name)
    assert {"p", "q", "r", "ax", "ay", "an"} <= set(chosen.channels)
    assert {"dynamic_pressure", "static_pressure"} <= set(chosen.channels)


@pytest.mark.parametrize("name", ["b777", "b777-thin"])
def test_the_box_maps_follow_the_box(name: str) -> None:
    from gsapp.virtual.instruments import DAQ_CHANNELS

    chosen = load_channel_map(name)
    by_index = {
        entry.inputs[0].index: entry
        for entry in chosen.entries
        if entry.message == "DEBUG_FLOAT_ARRAY"
    }
    assert [by_index[place].channel for place in range(len(DAQ_CHANNELS))] == list(DAQ_CHANNELS)
    certificates = load_certificates(chosen.certificates or "")
    wanted = {entry.calibration for entry in chosen.entries if entry.calibration}
    assert wanted == set(certificates)


def test_estimates_are_marked_and_vanes_go_first() -> None:
    first, second = load_channel_map("ardupilot-plane").by_channel["alpha"]
    assert (first.message, first.kind) == ("SENSOR_AIRFLOW_ANGLES", "measured")
    assert (second.message, second.kind) == ("AOA_SSA", "estimated")


GOOD = """
name = "test"
system = 3
[[channels]]
id = "q"
source = "ATTITUDE.pitchspeed"
unit = "rad/s"
kind = "estimated"
[[channels]]
id = "q"
source = "DEBUG_FLOAT_ARRAY[daq].data[3]"
unit = "mV"
calibration = "q"
priority = 2
[[channels]]
id = "phi"
source = ["ATTITUDE_QUATERNION.q1", "ATTITUDE_QUATERNION.q2", "ATTITUDE_QUATERNION.q3", "ATTITUDE_QUATERNION.q4"]
convert = "quaternion.phi"
unit = "rad"
[[channels]]
id = "rpm_left"
source = "RAW_RPM[index=0].frequency"
unit = "rpm"
time = "arrival"
"""  # noqa: E501


def test_a_map_is_read(tmp_path: Path) -> None:
    chosen = load_channel_map(write_map(tmp_path, GOOD.replace('id = "q"', 'id = "q.2"')))
    assert chosen.channels == ("q.2", "phi", "rpm_left")
    assert [entry.priority for entry in chosen.by_channel["q.2"]] == [1, 2]
    volts = chosen.by_channel["q.2"][1]
    assert volts.volts_channel == "q_volts.2"
    assert (volts.selector.field, volts.selector.value) == ("name", "daq")
    assert volts.inputs[0].index == 3
    assert len(chosen.by_channel["phi"][0].inputs) == 4


@pytest.mark.parametrize(
    ("old", "new", "where", "words"),
    [
        ('id = "rpm_left"', 'id = "rpm_lft"', "channels[3].id", "rpm_left"),
        ("ATTITUDE.p", "ATITUDE.p", "channels[0].source", "ATTITUDE"),
        ("pitchspeed", "pitchrate", "channels[0].source", "pitchspeed"),
        ("pitchspeed", "pitchspeed[1]", "channels[0].source", "leave [1] out"),
        ("data[3]", "data[58]", "channels[1].source", "0 to 57"),
        ("data[3]", "data", "channels[1].source", "data[0]"),
        ("data[3]", "name", "channels[1].source", "text"),
        ("ATTITUDE.p", "ATTITUDE[1].p", "channels[0].source", "identifies the sender"),
        ("[index=0]", "[indx=0]", "channels[3].source", "indx"),
        ("[index=0]", "[left]", "channels[3].source", "number"),
        ("ATTITUDE.p", "ATTITUDE p", "channels[0].source", "MESSAGE.field"),
        ('"rad/s"', '"m/s"', "channels[0].unit", "rad/s"),
        ('"mV"', '"deg/s"', "channels[1].unit", "V"),
        ('calibration = "q"', 'calibration = "pitch"', "channels[1].calibration", "channel"),
        ("priority = 2", "priority = 1", "channels[1].priority", "own priority"),
        ("quaternion.phi", "quaternion.phii", "channels[2].convert", "quaternion.phi"),
        (', "ATTITUDE_QUATERNION.q4"', "", "channels[2].source", "takes 4"),
        ('"ATTITUDE_QUATERNION.q4"', '"ATTITUDE.roll"', "channels[2].source", "one message"),
        ('"arrival"', '"stamp"', "channels[3].time", "arrival"),
        ('time = "arrival"', 'time = "frequency"', "channels[3].time", "milliseconds"),
        ('time = "arrival"', 'valid = "good"', "channels[3].valid", "good"),
        ("kind = ", "kid = ", "channels[0].kid", "kind"),
        ('"estimated"', '"guessed"', "channels[0].kind", "estimated"),
        ("system = 3", "system = 300", "system", "255"),
        ("system = 3", 'fallback = "3"', "fallback", "unit"),
        ("system = 3", 'format = "csv"', "format", "mavlink"),
    ],
)
def test_every_mistake_has_a_place_and_a_remedy(
    tmp_path: Path, old: str, new: str, where: str, words: str
) -> None:
    assert old in GOOD
    with pytest.raises(FileProblemsError) as caught:
        load_channel_map(write_map(tmp_path, GOOD.replace(old, new)))
    problems = {
        problem.where: f"{problem.what}; {problem.remedy}" for problem in caught.value.problems
    }
    assert where in problems, problems
    assert words in problems[where]


def test_all_mistakes_are_reported_at_once(tmp_path: Path) -> None:
    text = (
        GOOD.replace("system = 3", "system = 0\nsytem = 1")
        .replace('"rad/s"', '"furlong"')
        .replace("data[3]", "data[99]")
        .replace('id = "phi"', 'id = "fi"')
        .replace('unit = "rpm"', "")
    )
    with pytest.raises(FileProblemsError) as caught:
        load_channel_map(write_map(tmp_path, text))
    assert {problem.where for problem in caught.value.problems} == {
        "system",
        "sytem",
        "channels[0].unit",
        "channels[1].source",
        "channels[2].id",
        "channels[3].unit",
    }


TABLE = """
name = "thesis"
format = "table"
time = "GPS time"
[[channels]]
id = "alpha"
source = "Alpha"
unit = "deg"
scale = 1.0
[[channels]]
id = "q"
source = "Pitch rate"
unit = "deg/s"
"""


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"time =": "timee ="}, {"timee"}),
        ({'"table"': '"tabel"'}, {"format"}),
        ({'"table"': '"spreadsheet"'}, {"format"}),
        ({"scale = 1.0": 'scale = "x"', '"deg"': '"furlong"'}, {"[0].scale", "[0].unit"}),
        ({"scale = 1.0": "'a.b' = 1", '"alpha"': '"alfa"'}, {"[0].a.b", "[0].id"}),
        ({'"Alpha"': '" "', "time =": "timee ="}, {"[0].source", "timee"}),
        ({'"Alpha"': "[]"}, {"[0].source"}),
    ],
)
def test_a_mistake_brings_no_false_ones_and_hides_none(
    tmp_path: Path, changes: dict[str, str], told: set[str]
) -> None:
    text = TABLE
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)
    with pytest.raises(FileProblemsError) as caught:
        load_channel_map(write_map(tmp_path, text))
    wheres = [problem.where.removeprefix("channels") for problem in caught.value.problems]
    assert sorted(wheres) == sorted(told), caught.value


@pytest.mark.parametrize(
    ("columns", "where", "words"),
    [
        ('["time [s]", "alfa [deg]"]', "text.columns[1]", "alpha"),
        ('["time [s]", "alpha"]', "text.columns[1]", "unit"),
        ('["time [s]", "alpha [psi]"]', "text.columns[1]", "angle"),
        ('["time [h]", "alpha [deg]"]', "text.columns[0]", "us"),
        ('["alpha [deg]", "alpha [deg]"]', "text.columns[1]", "priority"),
        ("3", "text.columns", "list"),
        ('[""]', "channels", "no channel"),
    ],
)
def test_mistakes_in_text_columns(tmp_path: Path, columns: str, where: str, words: str) -> None:
    text = f'name = "t"\n[text]\ncolumns = {columns}\n'
    with pytest.raises(FileProblemsError) as caught:
        load_channel_map(write_map(tmp_path, text))
    problem = caught.value.problems[0]
    assert problem.where == where
    assert words in f"{problem.what}; {problem.remedy}"
