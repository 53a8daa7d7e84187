"""Which maneuvers are left out of the means by hand, with what can be taken back. No Qt."""

from __future__ import annotations


class ManeuverExclusions:
    """The maneuvers left out, and the changes that led there."""

    def __init__(self) -> None:
        self.now: frozenset[str] = frozenset()
        self._past: list[frozenset[str]] = []
        self._future: list[frozenset[str]] = []

    @property
    def can_undo(self) -> bool:
        """Return whether there is a change to take back."""
        return bool(self._past)

    @property
    def can_redo(self) -> bool:
        """Return whether there is a change to make again."""
        return bool(self._future)

    def set_excluded(self, without: frozenset[str]) -> None:
        """Follow what was changed elsewhere."""
        self.now = frozenset(without)

    def toggle(self, maneuver: str) -> frozenset[str]:
        """Leave a maneuver out, or take it in again; return those left out."""
        self._past.append(self.now)
        self._future.clear()
        self.now = self.now ^ {maneuver}
        return self.now

    def undo(self) -> frozenset[str]:
        """Take back the last change; return those left out."""
        if self._past:
            self._future.append(self.now)
            self.now = self._past.pop()
        return self.now

    def redo(self) -> frozenset[str]:
        """Make again what was taken back; return those left out."""
        if self._future:
            self._past.append(self.now)
            self.now = self._future.pop()
        return self.now
