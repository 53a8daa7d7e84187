"""Saved layouts: one TOML file each, in a folder of the user's."""

from __future__ import annotations

import logging
import re
from pathlib import Path

from gsapp.foundation import FileProblemsError, FlightError, GroundStationError, UnknownNameError
from gsapp.foundation.files import list_files
from ui.flight.chart_selection import SHIPPED_LAYOUT_NAMES, rename_layout
from ui.number_format import sanitize_file_name
from ui.strips.strip_layout import StripLayout, load_layout, save_layout
from ui.translation import tr

log = logging.getLogger(__name__)

_UNSAFE_CHARACTERS = re.compile(r"[^\w\-]+")


class LayoutStore:
    """Layouts by name, on disk.

    Parameters
    ----------
    folder : Path
        Where they are kept; made when the first is saved.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._layouts: dict[str, tuple[Path, StripLayout]] = {}
        complaints: list[str] = []
        try:
            files = list_files(folder, "*.toml")
        except GroundStationError as error:
            log.warning("layouts not used: %s", error)
            complaints.append(tr("The layouts could not be read: {error}.").format(error=error))
            files = ()
        for path in files:
            try:
                layout = load_layout(path)
            except FileProblemsError as error:
                log.warning("layout not used: %s", error)
                complaints.append(
                    tr("The layout {name} could not be read: {problem}.").format(
                        name=path.name, problem=error.problems[0]
                    )
                )
            else:
                self._layouts[layout.name] = (path, layout)
        # What is wrong with files that could not be read; these are left alone.
        self.read_errors = tuple(complaints)

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(sorted(self._layouts))

    def load(self, name: str) -> StripLayout:
        try:
            return self._layouts[name][1]
        except KeyError:
            raise UnknownNameError(
                tr("no layout named '{name}' was saved").format(name=name)
            ) from None

    def save(self, layout: StripLayout, name: str) -> None:
        """Keep a layout under a name.

        Raises
        ------
        FlightError
            If the name belongs to a layout that comes with the program, or the disk refuses.
        """
        if name in SHIPPED_LAYOUT_NAMES or not name.strip():
            raise FlightError(
                tr("'{name}' comes with the program; choose another name").format(name=name)
            )
        path = self._layouts[name][0] if name in self._layouts else self._free_path(name)
        try:
            save_layout(path, rename_layout(layout, name))
        except OSError as error:
            raise FlightError(
                tr("the layout '{name}' cannot be written to {path} ({strerror})").format(
                    name=name, path=path, strerror=error.strerror
                )
            ) from error
        self._layouts[name] = (path, rename_layout(layout, name))

    def _free_path(self, name: str) -> Path:
        stem = sanitize_file_name(_UNSAFE_CHARACTERS.sub("-", name).strip("-").lower()) or "layout"
        taken = {path for path, _layout in self._layouts.values()}
        number = 1
        while True:
            path = self._folder / (f"{stem}.toml" if number == 1 else f"{stem}-{number}.toml")
            if path not in taken and not path.exists():
                return path
            number += 1

    def delete(self, name: str) -> None:
        path, _layout = self._layouts.pop(name)
        path.unlink(missing_ok=True)
