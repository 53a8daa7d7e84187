"""The catalog: the maneuvers of a campaign, searchable, with what was estimated from them."""

from gsapp.flight.catalog.dump import dump, maneuvers_csv, table_csv
from gsapp.flight.catalog.records import (
    Condition,
    Run,
    StoredEstimate,
    StoredManeuver,
    StoredModel,
    conditions_of,
)
from gsapp.flight.catalog.searching import (
    flights_of,
    model_of,
    search_maneuvers,
    search_runs,
    weights_of,
)
from gsapp.flight.catalog.store import Catalog
from gsapp.flight.catalog.writing import (
    store_flight,
    store_grade,
    store_maneuvers,
    store_model,
    store_run,
    store_weights,
)

__all__ = [
    "Catalog",
    "Condition",
    "Run",
    "StoredEstimate",
    "StoredManeuver",
    "StoredModel",
    "conditions_of",
    "dump",
    "flights_of",
    "maneuvers_csv",
    "model_of",
    "search_maneuvers",
    "search_runs",
    "store_flight",
    "store_grade",
    "store_maneuvers",
    "store_model",
    "store_run",
    "store_weights",
    "table_csv",
    "weights_of",
]
