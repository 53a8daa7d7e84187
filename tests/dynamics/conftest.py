"""The shipped aircraft and model, once for all tests of the dynamics."""

import pytest

from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.model import Model, load_model


@pytest.fixture(scope="session")
def aircraft() -> Aircraft:
    return load_aircraft("b777")


@pytest.fixture(scope="session")
def model() -> Model:
    return load_model("b777")


@pytest.fixture(scope="session")
def flight_model(aircraft: Aircraft, model: Model) -> FlightModel:
    return FlightModel(aircraft, model)
