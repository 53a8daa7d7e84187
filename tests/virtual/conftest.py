"""One short flight for all tests that only look at it."""

from __future__ import annotations

import pytest

from gsapp.dynamics.pilot.flight import VirtualFlight, fly


@pytest.fixture(scope="session")
def short_flight() -> VirtualFlight:
    return fly("short", seed=3)
