"""What the window remembers: one TOML file in the user's configuration folder."""

from __future__ import annotations

import contextlib
import logging
import os
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import platformdirs
from pydantic import Field, ValidationError

from gsapp.foundation import FileProblemsError, StrictModel, read_toml_table, write_toml
from gsapp.foundation.toml_lines import key_lines
from ui.disk_checks import nearest_folder, path_kind
from ui.estimate_form import EstimateForm
from ui.translation import tr

_APPLICATION = "gsapp"
_MAX_RECENT = 8
_CATALOG = "campaign.sqlite"  # Where the flights lie.

log = logging.getLogger(__name__)


class RecentFlight(StrictModel):
    """A flight that was open."""

    path: str  # Its folder or file.
    name: str = ""
    aircraft: str = ""
    date: str = ""  # When it was recorded, local time.
    duration: float = Field(default=0.0, ge=0.0)  # Of the record, s; 0 until the flight was closed.


class Settings(StrictModel):
    """Everything that is kept from one start to the next."""

    theme: str = "daylight"  # ``daylight``, ``dark`` or ``high-contrast``.
    units: str = Field(default="US", pattern="^(US|SI)$")  # ``US`` or ``SI``.
    scale: int = Field(default=100, ge=100, le=250)  # Size of everything, percent.
    muted: bool = False  # Whether alarms are silent.
    side_panel: bool = True  # Whether the panel beside the charts is open.
    # Points to which it was drawn; never narrower than its tabs.
    panel_width: int = Field(default=0, ge=0)
    # Place and size of the window, as Qt writes it, in hexadecimal.
    geometry: str = Field(default="", pattern="^[0-9a-f]*$")
    links: tuple[str, ...] = ()  # LINK texts used last, newest first.
    recent_flights: tuple[RecentFlight, ...] = ()  # Flights opened last, newest first.
    folder: str = ""  # Where a flight was opened last.
    flights: str = ""  # Where flights are recorded.
    aircraft: str = "b777"
    channel_map: str = "b777"
    calibration: str = "b777"
    listen_only: bool = False  # Whether a recording sends nothing.
    signing_key: str = ""  # Path of the key file of MAVLink signatures; the key is in no setting.
    # Addresses that a flight was shared with last, newest first.
    shares: tuple[str, ...] = (
        "http:0.0.0.0:8080", "udpout:127.0.0.1:14550", "tcpin:127.0.0.1:5770",
    )  # fmt: skip
    share_open: bool = False  # Whether other computers receive it without a key.
    share_key: str = ""  # Path of the key that they need; empty for the signing key.
    # Name of the layout on screen; the layouts themselves are files beside this one.
    layout: str = "Overview"
    span: float = Field(default=60.0, gt=0.0)  # Seconds in sight.
    map_tiles: str = ""  # Path of the map below the ground track.
    gap_flights: tuple[str, ...] = ()  # Flights searched last for a missing effect.
    # What they were compared with; empty for the flight's own, and for none.
    gap_aircraft: str = ""
    gap_model: str = "b777"
    gap_variable: str = "alpha"
    gap_channel: str = "q"
    preflight_step: str = Field(default="card", pattern="^(card|calibration|checklist|cards)$")
    # Flights under review, in the order in which they are numbered.
    review_flights: tuple[str, ...] = ()
    review_folder: str = ""  # Where a report or a file of a run was written last.
    review_channels: tuple[str, ...] = (
        "de", "da", "dr", "q", "p", "r", "alpha", "beta", "V", "an", "ay",
    )  # fmt: skip
    review_chapter: str = Field(
        default="maneuvers", pattern="^(maneuvers|estimate|figures|summary)$"
    )
    review_estimate: EstimateForm = Field(default_factory=EstimateForm)  # Settings of the estimate.
    pilot_window: bool = False  # Whether the pilot's page has a window of its own, too.
    # Whether cues are spoken: ``page``, once the pilot's page was opened; ``always``; ``never``.
    flight_speech: str = Field(default="page", pattern="^(page|always|never)$")

    live_search: bool = False  # Whether a missing effect is searched for in flight.

    def with_link(self, link: str) -> Settings:
        others = tuple(known for known in self.links if known != link)
        return self.with_values(links=(link, *others)[:_MAX_RECENT])

    def with_share(self, link: str) -> Settings:
        others = tuple(known for known in self.shares if known != link)
        return self.with_values(shares=(link, *others)[:_MAX_RECENT])

    def with_flight(self, flight: RecentFlight) -> Settings:
        others = tuple(known for known in self.recent_flights if known.path != flight.path)
        flights = (flight, *others)[:_MAX_RECENT]
        return self.with_values(recent_flights=[one.model_dump() for one in flights])

    def with_values(self, **values: object) -> Settings:
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


def calibrations_path(settings: Path) -> Path:
    """Return the folder of all aircraft's calibrations that belongs to a settings file."""
    return settings.parent / "calibrations"


def checklist_path(settings: Path) -> Path:
    """Return the crew's own checklist that belongs to a settings file."""
    return settings.parent / "checklist.toml"


def log_path() -> Path:
    """Return where the log stands."""
    return Path(platformdirs.user_log_dir(_APPLICATION, appauthor=False)) / "window.log"


def default_flights_folder() -> Path:
    """Return where flights are recorded until the user names another folder."""
    return Path(platformdirs.user_documents_dir()) / "flights"


def recording_folder(settings: Settings) -> Path:
    """Return the folder in which flights are recorded; it need not be there yet."""
    return Path(settings.flights) if settings.flights else default_flights_folder()


def initial_dialog_folder(settings: Settings, remembered: str = "") -> Path:
    """Return the folder in which a file dialog begins.

    `remembered`: where this dialog was last, if it remembers; else where a flight was opened last
    counts, or where flights are recorded. Returns the nearest that is there: a dialog would take
    one that is not for the name of a file.
    """
    return nearest_folder(Path(remembered or settings.folder or recording_folder(settings)))


def writable_folder(wanted: Path) -> tuple[Path, str]:
    """Return a folder in which flights can be recorded, and why it is not the wanted one.

    It is the usual one where the wanted one, which need not be there yet, cannot be written. The
    sentence is empty for the wanted one.
    """
    usual = default_flights_folder()
    why = unwritable_reason(wanted)
    if not why or wanted == usual or unwritable_reason(usual):
        return wanted, ""
    return usual, tr("{why} Flights are recorded in {usual}.").format(why=why, usual=usual)


def unwritable_reason(folder: Path) -> str:
    """Return a sentence about why nothing can be written below a folder; empty if it can."""
    place = folder.expanduser()
    while (kind := path_kind(place)) == "missing" and place != place.parent:
        place = place.parent
    if kind == "stuck":
        return tr("{place} does not respond.").format(place=place)
    if kind != "folder":
        return tr("{place} is not a folder.").format(place=place)
    return (
        ""
        if os.access(place, os.W_OK | os.X_OK)
        else tr("{place} is not writable.").format(place=place)
    )


def catalog_path(settings: Settings) -> Path:
    """Return the catalog of the folder in which flights are recorded."""
    return recording_folder(settings) / _CATALOG


class SettingsStore:
    """Keeps the settings and writes them when they change.

    Several windows may share the file: each writes what was changed in it, and leaves alone what
    was changed in another. What is in force in a window stays so until it closes.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        # What of the file could not be used, or that it cannot be written; empty if all is well.
        # What could not be used is kept under another name.
        self.error_text = ""
        # Called with a sentence, once, when the file cannot be written although it seemed so.
        self.on_write_error: Callable[[str], object] = lambda _sentence: None
        self.current = self._read()  # As they are now.
        self._unwritten: dict[str, Any] = {}
        self._write_error_reported = not _may_write(path)
        if self._write_error_reported:
            self.error_text = f"{self.error_text} {self._forgetting}".lstrip()

    @property
    def _forgetting(self) -> str:
        return tr(
            "Settings will be lost when the window closes: {path} cannot be written. "
            "Check its permissions and the free disk space."
        ).format(path=self.path)

    def _read(self) -> Settings:
        """Return what can be used of the file; a single bad value costs that value alone."""
        try:
            content = read_toml_table(self.path)
        except FileProblemsError as error:
            if isinstance(error.__cause__, (FileNotFoundError, NotADirectoryError)):
                return Settings()
            log.warning("settings not used: %s", error)
            kept = self._back_up_file(shutil.move)
            problem = error.problems[0]
            place = str(problem).partition(":")[0]
            if not place.startswith("line"):
                place = problem.remedy
            self.error_text = tr(
                "The settings in {path} cannot be read ({place}): defaults are used.{kept}"
            ).format(path=self.path, place=place, kept=kept)
            return Settings()
        found, bad = _drop_invalid_values(content)
        if bad:
            lines = key_lines(self.path.read_text(encoding="utf-8"))
            bad = tuple(
                tr("{key} (line {line})").format(key=key, line=lines[key]) if key in lines else key
                for key in bad
            )
            log.warning("settings not used: %s: %s", self.path, ", ".join(bad))
            kept = self._back_up_file(shutil.copyfile)
            self.error_text = tr(
                "Some settings in {path} are invalid and were reset to defaults: {bad}.{kept}"
            ).format(path=self.path, bad=", ".join(bad), kept=kept)
        return found

    def _back_up_file(self, lay_aside: Callable[[Path, Path], object]) -> str:
        """Lay the file aside as it is, and return a sentence about where it is kept."""
        kept = self.path.with_suffix(".damaged.toml")
        with contextlib.suppress(OSError):
            lay_aside(self.path, kept)
            return tr(
                " The previous file was saved as {name}; correct it and rename it to use it again."
            ).format(name=kept.name)
        return ""

    def change(self, **values: object) -> Settings:
        """Change some values and write the file; a disk that refuses is told and logged."""
        self.replace(self.current.with_values(**values))
        return self.current

    def _written(self, values: dict[str, Any]) -> dict[str, Any]:
        """Return what stands in the file, or `values` where nothing can be read there."""
        try:
            content = read_toml_table(self.path)
        except FileProblemsError:
            return values
        return _drop_invalid_values(content)[0].model_dump()

    def replace(self, settings: Settings) -> None:
        if settings == self.current and os.access(self.path, os.F_OK):
            return
        before, values = self.current.model_dump(), settings.model_dump()
        self.current = settings
        self._unwritten |= {key: value for key, value in values.items() if value != before[key]}
        try:
            write_toml(self.path, {**self._written(values), **self._unwritten})
            self._unwritten.clear()
        except OSError as error:
            # The window goes on; only its memory is lost.
            log.warning("settings not saved to %s: %s", self.path, error)
            if not self._write_error_reported:
                self._write_error_reported = True
                self.on_write_error(self._forgetting)


def _may_write(path: Path) -> bool:
    """Return whether a file can be written, so far as permissions tell."""
    place = path.parent
    while not os.access(place, os.F_OK) and place != place.parent:
        place = place.parent
    return place.is_dir() and os.access(place, os.W_OK | os.X_OK)


def _drop_invalid_values(content: dict[str, Any]) -> tuple[Settings, tuple[str, ...]]:
    """Return the settings without what does not fit, and the keys of that.

    Keys that are not known, of a later version of the program, are passed over.
    """
    bad: list[str] = []
    while True:
        try:
            return Settings.model_validate(content), tuple(dict.fromkeys(bad))
        except ValidationError as error:
            dropped = {
                _drop(content, detail["loc"]): detail["type"] == "extra_forbidden"
                for detail in error.errors()
            }
            bad += [key for key, unknown in dropped.items() if key and not unknown]
            if not any(dropped):
                return Settings(), (*bad, tr("all of them"))


def _drop(content: dict[str, Any], location: Sequence[int | str]) -> str:
    """Take the innermost key on the way to a place out of nested tables, and return its path."""
    tables, path = [content], list[str]()
    for part in location:
        if not isinstance(tables[-1], dict) or part not in tables[-1]:
            break
        path.append(str(part))
        tables.append(tables[-1][part])
    if path:
        tables[len(path) - 1].pop(path[-1])
    return ".".join(path)
