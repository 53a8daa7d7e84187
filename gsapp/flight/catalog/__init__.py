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
    update_campaign_run,
)
from gsapp.flight.catalog.entries import (
    add_entry,
    store_entry,
    store_flight,
    store_grade,
    store_maneuvers,
)
from gsapp.flight.catalog.queries import (
    ManeuverFilter,
    find_maneuvers,
    list_estimated,
    list_flights,
    load_maneuvers,
    maneuvers_csv,
    search_maneuvers,
    search_runs,
)
from gsapp.flight.catalog.records import (
    CampaignRun,
    CardScore,
    EstimationRun,
    FlightEntry,
    StoredEstimate,
    StoredManeuver,
    StoredModel,
    StoredVerdict,
)
from gsapp.flight.catalog.store import Catalog
from gsapp.flight.catalog.verdicts import list_card_scores, search_verdicts, store_debrief

__all__ = [
    "CampaignRun",
    "CardScore",
    "Catalog",
    "EstimationRun",
    "FlightEntry",
    "ManeuverFilter",
    "StoredEstimate",
    "StoredManeuver",
    "StoredModel",
    "StoredVerdict",
    "add_entry",
    "delete_campaign_run",
    "find_maneuvers",
    "get_campaign_run",
    "list_campaign_runs",
    "list_card_scores",
    "list_estimated",
    "list_flights",
    "load_maneuvers",
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
    "update_campaign_run",
]
