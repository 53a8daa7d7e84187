"""The catalog: the maneuvers of a campaign, searchable, with what was estimated from them."""

from gsapp.flight.catalog.dump import dump, maneuvers_csv, table_csv
from gsapp.flight.catalog.records import (
    CardScore,
    Condition,
    Run,
    StoredEstimate,
    StoredManeuver,
    StoredModel,
    StoredVerdict,
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
from gsapp.flight.catalog.verdicts import scores_of, search_verdicts, store_debrief
from gsapp.flight.catalog.writing import (
    store_flight,
    store_grade,
    store_maneuvers,
    store_model,
    store_run,
    store_weights,
)

__all__ = [
    "CardScore",
    "Catalog",
    "Condition",
    "Run",
    "StoredEstimate",
    "StoredManeuver",
    "StoredModel",
    "StoredVerdict",
    "conditions_of",
    "dump",
    "flights_of",
    "maneuvers_csv",
    "model_of",
    "scores_of",
    "search_maneuvers",
    "search_runs",
    "search_verdicts",
    "store_debrief",
    "store_flight",
    "store_grade",
    "store_maneuvers",
    "store_model",
    "store_run",
    "store_weights",
    "table_csv",
    "weights_of",
]
