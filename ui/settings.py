"""What the window remembers: one TOML file in the user's configuration folder."""

from __future__ import annotations

import contextlib
import logging
from pathlib import Path

import platformdirs
from pydantic import Field

from gsapp.foundation import FileProblemsError, StrictModel, read_toml, write_toml
from ui.review.estimate_wishes import Wishes

_APPLICATION = "gsapp"
_REMEMBERED = 8
_CATALOG = "campaign.sqlite"
"""Where the flights lie."""

log = logging.getLogger(__name__)


class Settings(StrictModel):
    """Everything that is kept from one start to the next.

    Attributes
    ----------
    theme : str
        ``daylight``, ``dark`` or ``high-contrast``.
    units : str
        ``US`` or ``SI``.
    scale : int
        Size of everything, percent.
    muted : bool
        Whether alarms are silent.
    side_panel : bool
        Whether the panel beside the charts is open.
    geometry : str
        Place and size of the window, as Qt writes it, in hexadecimal.
    links : tuple of str
        LINK texts used last, newest first.
    folder : str
        Where a flight was opened last.
    flights : str
        Where flights are recorded.
    aircraft, channel_map, calibration : str
        Chosen last when connecting.
    layout : str
        Name of the layout on screen; the layouts themselves are files beside this one.
    span : float
        Seconds in sight.
    gap_flights : tuple of str
        Flights searched last for a missing effect.
    gap_aircraft, gap_model : str
        What they were compared with; empty for the flight's own, and for none.
    gap_variable, gap_channel : str
        What was looked at last.
    preflight_step : str
        Step before the flight that was looked at last.
    pilot_window : bool
        Whether the pilot's page has a window of its own, too.
    review_flights : tuple of str
        Flights under review, in the order in which they are numbered.
    review_channels : tuple of str
        Channels on the time line of the review.
    review_folder : str
        Where a report or a file of a run was written last.
    review_chapter : str
        Chapter of the review that was looked at last.
    review_estimate : Wishes
        Settings of the estimate.
    flight_speech : str
        Whether cues are spoken: ``page``, once the pilot's page was opened; ``always``; ``never``.
    """

    theme: str = "daylight"
    units: str = Field(default="US", pattern="^(US|SI)$")
    scale: int = Field(default=100, ge=100, le=250)
    muted: bool = False
    side_panel: bool = True
    geometry: str = Field(default="", pattern="^[0-9a-f]*$")
    links: tuple[str, ...] = ()
    folder: str = ""
    flights: str = ""
    aircraft: str = "b777"
    channel_map: str = "b777"
    calibration: str = "b777"
    layout: str = "Overview"
    span: float = Field(default=60.0, gt=0.0)
    gap_flights: tuple[str, ...] = ()
    gap_aircraft: str = ""
    gap_model: str = "b777"
    gap_variable: str = "alpha"
    gap_channel: str = "q"
    preflight_step: str = Field(default="card", pattern="^(card|calibration|checklist|cards)$")
    review_flights: tuple[str, ...] = ()
    review_folder: str = ""
    review_channels: tuple[str, ...] = (
        "de", "da", "dr", "q", "p", "r", "alpha", "beta", "V", "an", "ay",
    )  # fmt: skip
    review_chapter: str = Field(
        default="maneuvers", pattern="^(maneuvers|estimate|figures|summary)$"
    )
    review_estimate: Wishes = Field(default_factory=Wishes)
    pilot_window: bool = False
    flight_speech: str = Field(default="page", pattern="^(page|always|never)$")

    def with_link(self, link: str) -> Settings:
        """Return the settings with that link as the newest."""
        others = tuple(known for known in self.links if known != link)
        return self.changed(links=(link, *others)[:_REMEMBERED])

    def changed(self, **values: object) -> Settings:
        """Return a copy with other values, checked."""
        return Settings.model_validate({**self.model_dump(), **values})


def settings_path() -> Path:
    """Return where the settings stand."""
    return Path(platformdirs.user_config_dir(_APPLICATION, appauthor=False)) / "window.toml"


def layouts_path(settings: Path) -> Path:
    """Return the folder of saved layouts that belongs to a settings file."""
    return settings.parent / "layouts"


def limits_path(settings: Path) -> Path:
    """Return the file of typed limits that belongs to a settings file."""
    return settings.parent / "limits.toml"


def next_flight_path(settings: Path) -> Path:
    """Return the folder of what waits for the next flight that belongs to a settings file."""
    return settings.parent / "next flight"


def checklist_path(settings: Path) -> Path:
    """Return the crew's own checklist that belongs to a settings file."""
    return settings.parent / "checklist.toml"


def log_path() -> Path:
    """Return where the log stands."""
    return Path(platformdirs.user_log_dir(_APPLICATION, appauthor=False)) / "window.log"


def flights_path() -> Path:
    """Return where flights are recorded until the user names another folder."""
    return Path(platformdirs.user_documents_dir()) / "flights"


def recording_folder(settings: Settings) -> Path:
    """Return the folder in which flights are recorded; it need not be there yet."""
    return Path(settings.flights) if settings.flights else flights_path()


def first_folder(settings: Settings, remembered: str = "") -> Path:
    """Return the folder in which a file dialog begins.

    Parameters
    ----------
    settings : Settings
    remembered : str
        Where this dialog was last, if it remembers; else where a flight was opened last counts,
        or where flights are recorded.

    Returns
    -------
    Path
        The nearest that is there: a dialog would take one that is not for the name of a file.
    """
    wanted = Path(remembered or settings.folder or recording_folder(settings))
    return next((place for place in (wanted, *wanted.parents) if place.is_dir()), Path.home())


def catalog_path(settings: Settings) -> Path:
    """Return the catalog of the folder in which flights are recorded."""
    return recording_folder(settings) / _CATALOG


class SettingsStore:
    """Keeps the settings and writes them when they change.

    Parameters
    ----------
    path : Path
        The file.

    Attributes
    ----------
    current : Settings
        As they are now.
    complaint : str
        Why the file could not be used; empty if it could. It is then kept under another name.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.complaint = ""
        self.current = self._read()

    def _read(self) -> Settings:
        if not self.path.exists():
            return Settings()
        try:
            return read_toml(self.path, Settings)
        except FileProblemsError as error:
            kept = self.path.with_suffix(".damaged.toml")
            with contextlib.suppress(OSError):
                self.path.replace(kept)
            log.warning("settings not used: %s", error)
            self.complaint = (
                f"The settings in {self.path.name} could not be read ({error.problems[0]}): "
                f"the window starts with its defaults, the old file is kept as {kept.name}."
            )
            return Settings()

    def change(self, **values: object) -> Settings:
        """Change some values and write the file; a disk that refuses is only logged."""
        self.replace(self.current.changed(**values))
        return self.current

    def replace(self, settings: Settings) -> None:
        """Take other settings and write them."""
        if settings == self.current and self.path.exists():
            return
        self.current = settings
        try:
            write_toml(self.path, settings.model_dump())
        except OSError as error:
            # The window goes on; only its memory is lost.
            log.warning("settings not saved to %s: %s", self.path, error)
