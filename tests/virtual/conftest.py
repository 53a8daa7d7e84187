"""One short flight for all tests that only look at it."""

from collections.abc import Callable

import pytest

from gsapp.virtual.virtual_flight import VirtualFlight


@pytest.fixture(scope="session")
def short_flight(flown_short: Callable[[int], VirtualFlight]) -> VirtualFlight:
    return flown_short(6)
