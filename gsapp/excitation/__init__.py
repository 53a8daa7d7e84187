"""Feedback for the crew in flight: trimmed or not, was the input good, what to fly next. No Qt."""
