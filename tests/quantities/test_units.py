"""Units convert within their quantity only, by exact factors, and back again."""

import math

import numpy as np
import pint
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gsapp.foundation import UnitError, UnknownNameError
from gsapp.quantities import (
    CHANNELS,
    QUANTITIES,
    channel,
    from_si,
    normalize_unit,
    parse_quantity,
    to_si,
    units,
)

UNITS = [(key, unit) for key, entry in QUANTITIES.items() for unit in entry.units]

# Definitions: NIST SP 811 (international foot, avoirdupois pound, standard gravity).
EXACT = [
    ("length", "ft", 0.3048),
    ("length", "nmi", 1852.0),
    ("mass", "lb", 0.45359237),
    ("mass", "slug", 0.45359237 * 9.80665 / 0.3048),
    ("force", "lbf", 0.45359237 * 9.80665),
    ("weight", "lb", 0.45359237 * 9.80665),
    ("acceleration", "g", 9.80665),
    ("angle", "deg", math.pi / 180),
    ("rotation_speed", "rpm", 2 * math.pi / 60),
    ("rotation_speed", "Hz", 2 * math.pi),
    ("pressure", "psi", 0.45359237 * 9.80665 / 0.0254**2),
    ("pressure", "lbf/ft^2", 0.45359237 * 9.80665 / 0.3048**2),
    ("pressure", "inH2O", 249.08891),
    ("pressure", "inHg", 3386.389),
    ("inertia", "slug*ft^2", 0.45359237 * 9.80665 * 0.3048),
    ("density", "slug/ft^3", 0.45359237 * 9.80665 / 0.3048**4),
    ("volume", "floz", 29.5735295625e-6),
    ("speed", "kt", 1852.0 / 3600.0),
    ("ratio", "%", 0.01),
    ("charge", "mAh", 3.6),
]


@pytest.mark.parametrize(("key", "unit", "factor"), EXACT)
def test_factors_are_those_of_the_definitions(key: str, unit: str, factor: float) -> None:
    assert to_si(1.0, unit, key) == pytest.approx(factor, rel=3e-7)


def test_pints_own_list_defines_every_unit_alike(monkeypatch: pytest.MonkeyPatch) -> None:
    values = np.array([0.0, 1.0, -40.0, 1234.5])
    ours = {(key, unit): to_si(values, unit, key) for key, unit in UNITS}
    registry: pint.UnitRegistry[float] = pint.UnitRegistry(cache_folder=None)
    units._linear.cache_clear()
    monkeypatch.setattr(units, "_registry", lambda: registry)
    try:
        theirs = {(key, unit): to_si(values, unit, key) for key, unit in UNITS}
    finally:
        units._linear.cache_clear()
    for pair, numbers in ours.items():
        assert numbers == pytest.approx(theirs[pair], rel=1e-14, abs=1e-300), pair


def test_temperatures_have_offsets() -> None:
    assert to_si(20.0, "degC", "temperature") == pytest.approx(293.15)
    assert to_si(59.0, "degF", "temperature") == pytest.approx(288.15)


@given(st.sampled_from(UNITS), st.floats(-1e6, 1e6))
def test_every_unit_goes_to_si_and_back(pair: tuple[str, str], value: float) -> None:
    key, unit = pair
    assert from_si(to_si(value, unit, key), unit, key) == pytest.approx(value, rel=1e-12, abs=1e-9)


def test_arrays_keep_their_gaps() -> None:
    converted = to_si(np.array([1.0, np.nan]), "deg", "angle")
    assert converted[0] == pytest.approx(math.pi / 180)
    assert math.isnan(converted[1])


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ("g", "mass"),
        ("%", "angle"),
        ("deg", "ratio"),
        ("gram", "mass"),
        ("m", "area"),
        ("", "time"),
    ],
)
def test_units_of_other_quantities_are_errors(text: str, key: str) -> None:
    with pytest.raises(UnitError, match="not a unit"):
        normalize_unit(text, key)


def test_common_spellings_are_understood() -> None:
    assert normalize_unit("slug ft^2", "inertia") == "slug*ft^2"
    assert normalize_unit(" m / s**2 ", "acceleration") == "m/s^2"
    assert normalize_unit("ft²", "area") == "ft^2"
    assert normalize_unit("°/s", "angular_rate") == "deg/s"


@pytest.mark.parametrize("text", ["fast", "", "1,5 ft", "ft 3", True, None, [1]])
def test_what_is_not_a_value_with_a_unit_says_what_to_write(text: object) -> None:
    with pytest.raises(UnitError, match="write for example"):
        parse_quantity(text, "length")  # type: ignore[arg-type]


def test_a_bare_number_needs_a_quantity_without_unit() -> None:
    assert parse_quantity(0.5, "ratio") == 0.5
    assert parse_quantity("50 %", "ratio") == 0.5
    with pytest.raises(UnitError, match="has no unit"):
        parse_quantity(3, "length")


def test_a_unit_that_will_not_do_is_named_beside_those_that_will() -> None:
    """Nothing, too, has a name, whether it was given or would have done."""
    with pytest.raises(UnitError, match=r"'kg'.*\(no unit\), %"):
        normalize_unit("kg", "ratio")
    with pytest.raises(UnitError, match=r"no unit.*\bm, ft\b"):
        normalize_unit(" ", "length")
    with pytest.raises(UnknownNameError, match=r"'lenght'.*length"):
        normalize_unit("m", "lenght")


def test_channels_hold_displayable_units_and_sensible_limits() -> None:
    for spec in CHANNELS.values():
        assert spec.si_display in spec.allowed_units, spec.id
        assert spec.us_display in spec.allowed_units, spec.id
        assert spec.limits[0] < spec.limits[1], spec.id
        assert spec.precision > 0, spec.id


def test_digits_follow_the_precision_of_the_sensor() -> None:
    assert channel("alpha").decimals("deg") == 1
    assert channel("rpm_left").decimals("rpm") == 0
    assert channel("an").decimals("g") == 2
    assert channel("temperature").decimals("degF") == 0


def test_another_unit_shows_no_digits_that_the_sensor_does_not_earn() -> None:
    assert [channel("V").decimals(unit) for unit in ("ft/s", "m/s")] == [1, 1]
    assert [channel("altitude").decimals(unit) for unit in ("ft", "m")] == [0, 0]
    for spec in CHANNELS.values():
        for unit in {spec.si_display, spec.us_display}:
            zero = from_si(0.0, unit, spec.quantity)
            step = abs(from_si(spec.precision, unit, spec.quantity) - zero)
            digits = spec.decimals(unit)
            assert digits in (0, 6) or step < 2.5001 * 10.0**-digits, (spec.id, unit)
