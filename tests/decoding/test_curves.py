"""From a servo's pulse to degrees: tables and polynomials of a map, and certificates of pulses."""

from datetime import UTC, datetime

import numpy as np
import pytest

from calibration import load_certificate, load_certificates, write_certificate
from calibration.curve_selection import create_certificate, fit_calibration
from calibration.points_file import load_points
from gsapp.decoding.channel_map import load_channel_map
from gsapp.decoding.decoder import Decoder
from gsapp.foundation import FileProblemsError, FlightError
from tests.decoding.decoding_kit import Sender, assert_same, decode_in_chunks

ENTRY = """
name = "servo"
[[channels]]
id = "de_command"
source = "SERVO_OUTPUT_RAW.servo2_raw"
missing = [0]
"""
TABLE = 'unit = "deg"\ntable = [[2000, 20.0], [1000, -25.0], [1400, -4.0]]\n'
POLYNOMIAL = 'unit = "deg"\npolynomial = [-73.7, 0.0333, 2.4e-5, -8.8e-9]\n'
CERTIFICATE = 'unit = "us"\ncalibration = "de_command"\n'
PULSES = [1000, 1200, 1400, 1700, 2000, 900, 2100, 0, 1500, 1501]


def make_map(tmp_path, lines):
    path = tmp_path / "map.toml"
    path.write_text(ENTRY + lines)
    return path


def records():
    send = Sender()
    return [
        send(20_000 * k, "servo_output_raw", 20_000 * k, 0, 0, pulse, *[0] * 6)
        for k, pulse in enumerate(PULSES)
    ]


def decode(tmp_path, lines, certificates=None):
    """Return the degrees at the samples, all at once and one by one, which must be the same."""
    chosen = load_channel_map(make_map(tmp_path, lines))
    make = lambda: Decoder(chosen, rate=50.0, certificates=certificates)  # noqa: E731
    whole, decoder = decode_in_chunks(make, records(), [1000])
    single, one_by_one = decode_in_chunks(make, records(), [1] * 10)
    assert_same(whole, single)
    assert decoder.clipped == one_by_one.clipped
    return np.rad2deg(whole["de_command"][1]), decoder


def test_a_table_is_straight_between_its_points_and_beyond_and_says_so(tmp_path):
    degrees, decoder = decode(tmp_path, TABLE)
    expected = [-25.0, -14.5, -4.0, 8.0, 20.0, -30.25, 24.0, 0.0, 0.04]
    np.testing.assert_allclose(np.delete(degrees, 7)[:7], expected[:7])
    assert degrees[8:] == pytest.approx(expected[7:])
    assert decoder.clipped == {"de_command": 2}


def test_a_polynomial_has_ascending_powers(tmp_path):
    degrees, _ = decode(tmp_path, POLYNOMIAL)
    raw = np.array(PULSES, dtype=float)
    held = raw > 0.0
    expected = -73.7 + 0.0333 * raw + 2.4e-5 * raw**2 - 8.8e-9 * raw**3
    np.testing.assert_allclose(degrees[held], expected[held], rtol=1e-9)


def test_scale_and_offset_act_after_a_table(tmp_path):
    degrees, _ = decode(tmp_path, TABLE + "scale = -1.0\noffset = 2.0\n")
    assert degrees[0] == pytest.approx(27.0)


@pytest.mark.parametrize(
    ("lines", "where", "what"),
    [
        ('unit = "deg"\ntable = [[1000, 1.0]]\n', "table", "fewer than two"),
        ('unit = "deg"\ntable = [[1, 1.0], [1, 2.0], [3, 1.0]]\n', "table", "two for one raw"),
        (TABLE + "polynomial = [1.0, 2.0]\n", "table", "exclude each other"),
        (CERTIFICATE + "polynomial = [1.0, 2.0]\n", "polynomial", "exclude each other"),
        ('unit = "deg"\ncalibration = "de_command"\n', "unit", "no unit of a signal"),
    ],
)
def test_mistakes_of_curves(tmp_path, lines, where, what):
    with pytest.raises(FileProblemsError) as caught:
        load_channel_map(make_map(tmp_path, lines))
    assert any(
        problem.where.endswith(where) and what in problem.what for problem in caught.value.problems
    )


POINTS = """angle [deg],pulse [us],direction
-25,1000,increasing
-14,1200,increasing
-4,1400,increasing
5.5,1600,increasing
13,1800,increasing
19,2000,increasing
18.8,2000,decreasing
12.8,1800,decreasing
5.3,1600,decreasing
-4.2,1400,decreasing
-14.2,1200,decreasing
-25.2,1000,decreasing
"""


@pytest.fixture
def folder(tmp_path):
    """Return a folder with the certificate of a servo, made of points of pulse and angle."""
    (tmp_path / "points.csv").write_text(POINTS)
    taken = load_points(tmp_path / "points.csv", "de_command")
    made = fit_calibration(taken.points, resolution=taken.signal.resolution)
    certificate = create_certificate(
        made,
        taken.points,
        channel_id="de_command",
        unit=taken.unit,
        who="B. Jones",
        stamp=datetime(2026, 5, 12, 8, 31, tzinfo=UTC),
        signal_unit=taken.signal.unit,
    )
    (tmp_path / "certificates").mkdir()
    write_certificate(certificate, tmp_path / "certificates" / "de_command.toml")
    return tmp_path / "certificates"


def test_a_certificate_of_pulses_is_read_back_and_calibrates_a_servo(tmp_path, folder):
    certificate = load_certificate(folder / "de_command.toml")
    assert certificate.signal_unit == "us"
    assert certificate.range == (1000.0, 2000.0)
    assert certificate.points[1].volts == 1200.0
    degrees, decoder = decode(tmp_path, CERTIFICATE, load_certificates(folder))
    assert degrees[[0, 1, 2]] == pytest.approx([-25.1, -14.1, -4.1], abs=0.3)
    assert decoder.clipped == {"de_command": 2}
    assert "signal.de_command" in decoder.channels
    assert decoder.sources["de_command"].calibrated


def test_without_its_certificate_the_signal_is_kept(tmp_path):
    chosen = load_channel_map(make_map(tmp_path, CERTIFICATE))
    decoder = Decoder(chosen)
    assert decoder.channels == ("signal.de_command",)
    assert decoder.sources["signal.de_command"].uncalibrated_channel == "de_command"


def test_a_certificate_of_another_signal_is_refused(tmp_path, folder):
    volts = CERTIFICATE.replace('"us"', '"mV"')
    chosen = load_channel_map(make_map(tmp_path, volts))
    with pytest.raises(FlightError, match=r"is for us.*in V"):
        Decoder(chosen, certificates=load_certificates(folder))
