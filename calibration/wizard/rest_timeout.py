"""Why an instrument does not come to rest: said after a while, and not anew twice a second."""

from __future__ import annotations

from calibration.rest_detection import RestStatus
from calibration.wizard.settings import WIZARD


class RestTimeoutMonitor:
    """Follows the reading of a watch for rest."""

    def __init__(self) -> None:
        self._waited = 0.0
        self._said_at = 0.0
        self._why = ""

    def restart(self) -> None:
        """Begin to wait anew."""
        self._waited = self._said_at = 0.0
        self._why = ""

    def feed(self, reading: RestStatus) -> None:
        if reading.state == "rested":
            self.restart()
            return
        self._waited += WIZARD.slice_duration
        if (
            self._waited >= WIZARD.rest_timeout
            and self._waited - self._said_at >= WIZARD.reason_interval
        ):
            self._said_at = self._waited
            self._why = reading.why

    @property
    def warnings(self) -> tuple[str, ...]:
        """Return what to say of it: nothing, or one sentence."""
        return (f"not steady: {self._why}",) if self._why else ()
