"""The catalog: the maneuvers of a campaign, searchable, with what was estimated from them."""

from gsapp.flight.catalog.campaign_runs import (
    delete_campaign_run,
    get_campaign_run,
    list_campaign_runs,
    restore_campaign_run,
    set_campaign_run_label,
    store_campaign_run,
    store_model,
    store_run,
    store_weights,
    update_campaign_run,
)
from gsapp.flight.catalog.catalog_export import export_catalog, maneuvers_csv, table_csv
from gsapp.flight.catalog.entries import (
    add_entry,
    store_entry,
    store_flight,
    store_grade,
    store_maneuvers,
)
from gsapp.flight.catalog.queries import (
    get_model,
    get_weights,
    list_flights,
    search_maneuvers,
    search_runs,
)
from gsapp.flight.catalog.records import (
    CampaignRun,
    CardScore,
    EstimationRun,
    FlightCondition,
    FlightEntry,
    StoredEstimate,
    StoredManeuver,
    StoredModel,
    StoredVerdict,
    compute_conditions,
)
from gsapp.flight.catalog.store import Catalog
from gsapp.flight.catalog.verdicts import list_card_scores, search_verdicts, store_debrief

__all__ = [
    "CampaignRun",
    "CardScore",
    "Catalog",
    "EstimationRun",
    "FlightCondition",
    "FlightEntry",
    "StoredEstimate",
    "StoredManeuver",
    "StoredModel",
    "StoredVerdict",
    "add_entry",
    "compute_conditions",
    "delete_campaign_run",
    "export_catalog",
    "get_campaign_run",
    "get_model",
    "get_weights",
    "list_campaign_runs",
    "list_card_scores",
    "list_flights",
    "maneuvers_csv",
    "restore_campaign_run",
    "search_maneuvers",
    "search_runs",
    "search_verdicts",
    "set_campaign_run_label",
    "store_campaign_run",
    "store_debrief",
    "store_entry",
    "store_flight",
    "store_grade",
    "store_maneuvers",
    "store_model",
    "store_run",
    "store_weights",
    "table_csv",
    "update_campaign_run",
]
