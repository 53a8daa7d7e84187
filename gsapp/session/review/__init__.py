"""The review after landing: flights with their maneuvers, corrected by hand, chosen for runs."""

from gsapp.session.review.review import ManeuverRow, Review
from gsapp.session.review.reviewed_flight import (
    ReviewedFlight,
    open_reviewed_flight,
    save_maneuvers_to_catalog,
)

__all__ = [
    "ManeuverRow",
    "Review",
    "ReviewedFlight",
    "open_reviewed_flight",
    "save_maneuvers_to_catalog",
]
