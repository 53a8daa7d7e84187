"""The review after landing: flights with their maneuvers, corrected by hand, chosen for runs."""

from gsapp.session.review.flight import ReviewedFlight, open_reviewed
from gsapp.session.review.keeping import keep_maneuvers
from gsapp.session.review.review import ManeuverRow, Review

__all__ = [
    "ManeuverRow",
    "Review",
    "ReviewedFlight",
    "keep_maneuvers",
    "open_reviewed",
]
