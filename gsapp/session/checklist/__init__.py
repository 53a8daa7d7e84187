"""The checklist before a flight: a file of items, and how they stand by hand and telemetry."""

from gsapp.session.checklist.evaluation import (
    ChecklistContext,
    EvaluatedItem,
    ItemStatus,
    RuleResult,
)
from gsapp.session.checklist.items import (
    SHIPPED_CHECKLISTS,
    ChecklistFile,
    ChecklistItem,
    load_checklist,
    shipped_checklists,
)
from gsapp.session.checklist.session_checklist import Checklist, SessionChecklist

__all__ = [
    "SHIPPED_CHECKLISTS",
    "Checklist",
    "ChecklistContext",
    "ChecklistFile",
    "ChecklistItem",
    "EvaluatedItem",
    "ItemStatus",
    "RuleResult",
    "SessionChecklist",
    "load_checklist",
    "shipped_checklists",
]
