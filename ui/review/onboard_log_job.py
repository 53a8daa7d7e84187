"""What is done about a flight's on-board log, in a process of its own. No Qt."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ui.translation import tr


@dataclass(frozen=True, slots=True, kw_only=True)
class OnboardLogJob:
    """Let a log take the place of the live record; the result is a `OnboardLogResult`."""

    flight: Path
    file: Path | None = None
    link: str | None = None
    """The log that is fetched over this LINK; empty for that of the recorder at work."""
    use: str | None = None
    """A log that lies in the folder; empty for the live record alone."""

    @property
    def title(self) -> str:
        what = tr("Fetching") if self.link is not None else tr("Aligning")
        return tr("{what} the on-board log of {name}").format(what=what, name=self.flight.name)


@dataclass(frozen=True, slots=True, kw_only=True)
class OnboardLogResult:
    """How a flight stands now."""

    flight: Path
    text: str
    """Which log is in force and how its clock stands; for a banner."""
    previous_log: str
    """What was in force before; empty for the live record alone."""
