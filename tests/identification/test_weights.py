"""Weights files: the source's table as it stands, units, and mistakes told apart."""

import math
from pathlib import Path

import pytest

from gsapp.foundation import FileProblemsError, UnknownNameError
from gsapp.identification.weights import load_weights, shipped_weights
from gsapp.quantities.constants import GRAVITY

# Table 6.2.7: beta, p, r, a_y.
LATERAL = {
    "A": (3.0, 0.7, 1.0, 30.0),
    "B": (0.0, 1.8, 1.2, 100.0),
    "C": (1.0, 1.0, 1.0, 20.0),
    "D": (2.5, 1.0, 1.0, 100.0),
    "E": (2.5, 1.0, 1.0, 100.0),
}


@pytest.mark.parametrize("flight", LATERAL)
def test_the_table_of_the_source(flight: str) -> None:
    """Every weight of the table comes out in SI; accelerations were in g."""
    found = load_weights("table-6.2.7").for_flight(flight)
    beta, p, r, ay = LATERAL[flight]
    assert [found[name] for name in ("beta", "p", "r")] == [beta, p, r]
    assert found["ay"] == pytest.approx(ay / GRAVITY**2)
    assert [found[name] for name in ("alpha", "q")] == [5.0, 8.0]
    assert found["an"] == pytest.approx(35.0 / GRAVITY**2)
    assert found["ax"] == pytest.approx(100.0 / GRAVITY**2)


def test_flights_are_found_however_they_are_written() -> None:
    """A flight without a table of its own gets the default."""
    weights = load_weights("table-6.2.7")
    assert weights.for_flight("Flight B") == weights.for_flight("flight_b")
    assert weights.for_flight("flight_b")["p"] == 1.8
    assert weights.for_flight("17") == weights.for_flight()


def test_a_file_of_the_user(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('[units]\nalpha = "deg"\n[default]\nalpha = 2\nq = 3\n', encoding="utf-8")
    found = load_weights(path).for_flight("any")
    assert found["alpha"] == pytest.approx(2.0 * (180.0 / math.pi) ** 2)
    assert found["q"] == 3.0
    assert "table-6.2.7" in shipped_weights()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[default]\nalfa = 1", "did you mean 'alpha'"),
        ("[default]\nalpha = -1", "0 or more"),
        ("[flights.A]\nbeta = nan", "flights.A.beta"),
        ('[units]\nan = "deg"', "not a unit of acceleration"),
        ("[defaults]\nalpha = 1", "did you mean 'default'"),
        ("[default]\nalpha = 'heavy'", "default.alpha"),
    ],
)
def test_mistakes_are_named(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "wrong.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(FileProblemsError, match=words):
        load_weights(path)


def test_an_unknown_name() -> None:
    with pytest.raises(UnknownNameError, match=r"'table-6\.2\.7'"):
        load_weights("table-6.2.8")
