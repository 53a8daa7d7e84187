"""Values on the screen: in line with one another, and no bound of zero."""

import pytest

from gsapp.cli._console import format_value_and_bound


@pytest.mark.parametrize(
    ("value", "std", "shown"),
    [
        (-22.97391, 0.10781, ("-22.9739", "0.1078")),
        (0.0149608, 0.0000291, ("0.014961", "0.000029")),
        (-0.00000042, 0.0000037, ("-0.0000004", "0.0000037")),
        (0.5, 0.0, ("0.50000000", "0.00000000")),
    ],
)
def test_a_small_bound_keeps_two_digits(value: float, std: float, shown: tuple[str, str]) -> None:
    assert format_value_and_bound(value, std) == shown
