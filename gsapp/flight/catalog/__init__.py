"""The catalog: the maneuvers of a campaign, searchable, with what was estimated from them."""

from gsapp.flight.catalog.dump import dump, maneuvers_csv, table_csv
from gsapp.flight.catalog.entries import (
    add_entry,
    store_entry,
    store_flight,
    store_grade,
    store_maneuvers,
)
from gsapp.flight.catalog.kept import (
    change_label,
    forget_record,
    kept_record,
    kept_records,
    recall_record,
    renew_record,
    store_kept,
)
from gsapp.flight.catalog.records import (
    CardScore,
    Condition,
    FlightEntry,
    KeptRecord,
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
    store_model,
    store_run,
    store_weights,
)

__all__ = [
    "CardScore",
    "Catalog",
    "Condition",
    "FlightEntry",
    "KeptRecord",
    "Run",
    "StoredEstimate",
    "StoredManeuver",
    "StoredModel",
    "StoredVerdict",
    "add_entry",
    "change_label",
    "conditions_of",
    "dump",
    "flights_of",
    "forget_record",
    "kept_record",
    "kept_records",
    "maneuvers_csv",
    "model_of",
    "recall_record",
    "renew_record",
    "scores_of",
    "search_maneuvers",
    "search_runs",
    "search_verdicts",
    "store_debrief",
    "store_entry",
    "store_flight",
    "store_grade",
    "store_kept",
    "store_maneuvers",
    "store_model",
    "store_run",
    "store_weights",
    "table_csv",
    "weights_of",
]
