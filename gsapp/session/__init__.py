"""A running flight: tails the record and feeds history, alarms and events. No Qt."""
