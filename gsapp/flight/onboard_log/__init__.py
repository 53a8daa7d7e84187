"""After landing: the on-board log takes the place of what came over the radio.

The radio carries a fraction of what the box records. The log, at its full rate, is aligned in time
with the live record, offset and drift, and replaces it; flight time stays that of the live record,
so that marks, grades and edges of maneuvers stand where they stood. Where one of the two has
nothing, the other fills in.
"""

from gsapp.flight.onboard_log.log_state import LogClock, OnboardLogState

__all__ = ["LogClock", "OnboardLogState"]
