"""Questions to a fleet: derivatives over many flights, between airframes, and over time."""
