"""Asks which log is to take the place of the live record, and says how the one in force stands."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtWidgets import (
    QComboBox,
    QFileDialog,
    QStackedWidget,
    QVBoxLayout,
    QWidget,
)

from ui.dialogs.file_dialogs import log_name_filter
from ui.dialogs.form_dialog import FieldMessage, FormDialog, PathField
from ui.dialogs.link_field import LinkField
from ui.disk_checks import nearest_folder, path_kind
from ui.display_style import DisplayStyle
from ui.review.onboard_log_worker import OnboardLogJob
from ui.translation import tr

if TYPE_CHECKING:
    from gsapp.flight.onboard_log import OnboardLogState
    from gsapp.telemetry.link_kinds import LinkAddress

_FILE, _LINK, _STORED, _NONE = "file", "link", "kept", "none"


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightLogs:
    """A flight that may get an on-board log."""

    path: Path
    name: str
    in_force: str = ""
    """File name of the log in force; empty for none."""
    state: OnboardLogState | None = None
    """How it stands; None where the flight has not been opened with it."""
    stored_logs: tuple[str, ...] = ()
    link: str = ""
    """The LINK that is recorded into it now; empty for none."""


class ExistingFileField(PathField):
    """A file that is there, typed or chosen."""

    def _choose(self) -> None:
        wanted = self.path if self.edit.text().strip() else Path.home()
        start = str(nearest_folder(wanted))
        path, _kind = QFileDialog.getOpenFileName(self, self._name, start, log_name_filter())
        if path:
            self.edit.setText(path)


class OnboardLogDialog(FormDialog):
    """Which flight, which log."""

    def __init__(
        self,
        style: DisplayStyle,
        flights: Sequence[FlightLogs],
        links: Sequence[str],
        parse: Callable[[str], LinkAddress],
        list_ports: Callable[[], Sequence[tuple[str, str]]],
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(
            tr("On-board log"),
            tr(
                "Replaces the telemetry record by the full on-board log. Flight time, marks, "
                "grades and maneuvers stay."
            ),
            tr("Apply"),
            style,
            parent,
        )
        self._flights = tuple(flights)
        self.flight = QComboBox()
        for one in self._flights:
            self.flight.addItem(one.name)
        self.now = FieldMessage()
        self.add_row(tr("Flight"), self.flight, self.now)
        self.origin = QComboBox()
        self.verdict = FieldMessage()
        self.add_row(tr("Log"), self.origin, self.verdict)
        self.file = ExistingFileField(tr("Log file"), style)
        at_work = [one.link for one in self._flights if one.link]
        self.link = LinkField(list(dict.fromkeys([*at_work, *links])), parse, list_ports, style)
        self._pages = QStackedWidget()
        self._pages.addWidget(_align_to_top(self.file))
        self._pages.addWidget(self.link)
        self._pages.addWidget(QWidget())
        self.add_row(tr("From"), self._pages)
        self.flight.currentIndexChanged.connect(self._flight_chosen)
        self.origin.currentIndexChanged.connect(self._validate)
        self.file.edit.textChanged.connect(self._validate)
        self.link.changed.connect(self._validate)
        self._flight_chosen()
        self.origin.setFocus()
        self.fit_to_content()

    @property
    def _chosen(self) -> FlightLogs:
        return self._flights[self.flight.currentIndex()]

    @property
    def _from(self) -> tuple[str, str]:
        kind, name = self.origin.currentData() or (_FILE, "")
        return kind, name

    def _flight_chosen(self) -> None:
        one = self._chosen
        state, in_force = one.state, one.in_force
        if not in_force:
            self.now.set_message(tr("Live record only (telemetry)."))
        elif state is None or state.file != in_force:
            self.now.set_message(
                tr("{in_force} is in use; its clock offset is shown when it opens.").format(
                    in_force=in_force
                )
            )
        else:
            self.now.set_message(
                capitalize_sentence(state.remark()) + ".", "good" if state.in_place else "caution"
            )
        self.origin.blockSignals(True)
        self.origin.clear()
        self.origin.addItem(tr("A file, from a card or the data box"), (_FILE, ""))
        self.origin.addItem(tr("The autopilot's, over the link"), (_LINK, ""))
        for name in one.stored_logs:
            if name != in_force:
                self.origin.addItem(
                    tr("{name}, in the flight's folder").format(name=name), (_STORED, name)
                )
        if in_force:
            self.origin.addItem(tr("None: live record only"), (_NONE, ""))
        self.origin.blockSignals(False)
        self._validate()

    def _validate(self) -> None:
        kind, name = self._from
        self._pages.setCurrentIndex({_FILE: 0, _LINK: 1}.get(kind, 2))
        usable = True
        if kind == _FILE:
            typed = self.file.edit.text().strip()
            usable = path_kind(typed) == "file" if typed else False
            if not typed:
                self.verdict.set_message(tr("ArduPilot .bin, PX4 .ulg, .tlog, or a Flight CSV."))
            elif usable:
                self.verdict.set_message(tr("Compared with the live record first."), "good")
            else:
                self.verdict.set_message(
                    tr("There is no file {typed}.").format(typed=typed), "warning"
                )
        elif kind == _LINK:
            usable = self.link.input_check.is_valid
            self.verdict.set_message(
                tr("The aircraft has landed and is disarmed. An interrupted download resumes.")
            )
        elif kind == _STORED:
            self.verdict.set_message(
                tr("{name} is in use again; the previous log stays in the folder.").format(
                    name=name
                )
            )
        else:
            self.verdict.set_message(tr("The log stays in the folder and can be used again."))
        self.button.setEnabled(usable)

    @property
    def job(self) -> OnboardLogJob:
        kind, name = self._from
        flight = self._chosen.path
        if kind == _FILE:
            return OnboardLogJob(flight=flight, file=Path(self.file.edit.text().strip()))
        if kind == _LINK:
            return OnboardLogJob(flight=flight, link=self.link.value)
        return OnboardLogJob(flight=flight, use=name)


def _align_to_top(field: QWidget) -> QWidget:
    page = QWidget()
    column = QVBoxLayout(page)
    column.setContentsMargins(0, 0, 0, 0)
    column.addWidget(field)
    column.addStretch(1)
    return page


def capitalize_sentence(words: str) -> str:
    """Return a sentence with its first letter capital."""
    return words[:1].upper() + words[1:]
