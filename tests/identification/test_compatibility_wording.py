"""Errors of instruments as a crew reads them."""

import pytest

from gsapp.identification.compatibility.results import format_error_with_bound
from gsapp.quantities.constants import DEGREE, GRAVITY


@pytest.mark.parametrize(
    ("parameter", "value", "std", "shown"),
    [
        # Three digits of each told 1 beside 0.00108, and a delay of 0 beside a bound of 0 ms.
        ("beta.scale", 1.00431, 0.00108, ("1.0043", "0.0011")),
        ("V.scale", 0.99837, 0.00079, ("0.99837", "0.00079")),
        ("phi.delay", 2.3e-4, 1.2e-4, ("0.23 ms", "0.12 ms")),
        ("V.delay", -6e-3, 2e-3, ("-6.0 ms", "2.0 ms")),
        ("alpha.bias", 0.02 * DEGREE, 0.062 * DEGREE, ("0.020 deg", "0.062 deg")),
        ("ax.bias", -4.7e-4 * GRAVITY, 3.4e-4 * GRAVITY, ("-0.00047 g", "0.00034 g")),
        ("q.bias", 1.5 * DEGREE, 23.0 * DEGREE, ("2 deg/s", "23 deg/s")),
        ("V.bias", -0.0001, 0.5, ("0.00 m/s", "0.50 m/s")),
    ],
)
def test_value_and_bound_end_at_the_same_digit(
    parameter: str, value: float, std: float, shown: tuple[str, str]
) -> None:
    assert format_error_with_bound(parameter, value, std) == shown
