"""The checklist before a flight: a file of items, and how they stand by hand and telemetry."""

from gsapp.session.checklist.items import (
    SHIPPED,
    ChecklistFile,
    ChecklistItem,
    load_checklist,
    shipped_checklists,
)
from gsapp.session.checklist.judgment import Facts, ItemState, Judgment, State
from gsapp.session.checklist.live import SessionChecklist
from gsapp.session.checklist.running import Checklist

__all__ = [
    "SHIPPED",
    "Checklist",
    "ChecklistFile",
    "ChecklistItem",
    "Facts",
    "ItemState",
    "Judgment",
    "SessionChecklist",
    "State",
    "load_checklist",
    "shipped_checklists",
]
