"""Short questions about a flight: time, y range, export, channel map, certificates, closing."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from PySide6.QtWidgets import QComboBox, QLineEdit, QMessageBox, QWidget

from calibration import load_certificates
from gsapp.flight.certificates import AppliedCertificates
from gsapp.foundation import GroundStationError
from ui.dialogs.file_fields import ShippedFileField
from ui.dialogs.form_dialog import FieldMessage, FormDialog, PathField
from ui.disk_checks import may_block, path_kind
from ui.display_style import DisplayStyle
from ui.number_format import clock_text, count_text, parse_clock, parse_number, unit_text
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.message_boxes import create_message_box

ClosingAnswer = Literal["leave", "stop", "stay"]


class GoToDialog(FormDialog):
    """Asks for a flight time."""

    def __init__(
        self,
        style: DisplayStyle,
        first: float,
        last: float,
        now: float,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(
            tr("Go to time"),
            tr("This flight runs from {first} to {last}.").format(
                first=clock_text(first, decimals=1), last=clock_text(last, decimals=1)
            ),
            tr("Go"),
            style,
            parent,
        )
        self._span = (first, last)
        self.edit = QLineEdit(clock_text(now, decimals=1))
        self.edit.selectAll()
        self.message = FieldMessage()
        self.add_row(tr("Flight time"), self.edit, self.message)
        self.edit.textChanged.connect(self._validate)
        self._validate()
        self.edit.setFocus()
        self.fit_to_content(400)

    def _validate(self) -> None:
        time = self.time
        first, last = self._span
        if time is None:
            self.message.set_message(
                tr("Write minutes and seconds, such as 4:07.5, or seconds."), "warning"
            )
        elif not first <= time <= last:
            self.message.set_message(
                tr("Outside the flight; the nearest is {time}.").format(
                    time=clock_text(self.clamped_time, decimals=1)
                ),
                "caution",
            )
        else:
            self.message.set_message(clock_text(time, decimals=1), "good")
        self.button.setEnabled(time is not None)

    @property
    def time(self) -> float | None:
        """Return what is typed, s; None if it is no time."""
        return parse_clock(self.edit.text())

    @property
    def clamped_time(self) -> float:
        first, last = self._span
        return min(max(self.time if self.time is not None else first, first), last)


class RangeDialog(FormDialog):
    """Asks for the y range of a chart; two empty fields leave it to the program.

    `low`, `high`: the range in force, in that unit.
    """

    def __init__(
        self,
        style: DisplayStyle,
        title: str,
        unit: str,
        low: float,
        high: float,
        parent: QWidget | None = None,
    ) -> None:
        shown = tr(" in {unit}").format(unit=unit_text(unit)) if unit else ""
        super().__init__(
            tr("Y range"),
            tr("{title}{shown}. Leave both fields empty for an automatic range.").format(
                title=title, shown=shown
            ),
            tr("Set"),
            style,
            parent,
        )
        self.high, self.low = QLineEdit(f"{high:g}"), QLineEdit(f"{low:g}")
        self.message = FieldMessage()
        self.add_row(tr("Highest"), self.high)
        self.add_row(tr("Lowest"), self.low, self.message)
        for edit in (self.high, self.low):
            edit.textChanged.connect(self._validate)
        self.high.selectAll()
        self._validate()
        self.fit_to_content(400)

    def _validate(self) -> None:
        texts = self.high.text().strip(), self.low.text().strip()
        usable = self.range is not None or not any(texts)
        if not any(texts):
            self.message.set_message(tr("The range follows the trace."), "good")
        elif usable:
            self.message.set_message(tr("The range stays fixed. Y returns to automatic."), "good")
        elif any(parse_number(text) is None for text in texts):
            self.message.set_message(tr("Write two numbers, such as 5 and -2.5."), "warning")
        else:
            self.message.set_message(tr("The maximum must be above the minimum."), "warning")
        self.button.setEnabled(usable)

    @property
    def range(self) -> tuple[float, float] | None:
        """Return lowest and highest as typed; None if they make no range."""
        low, high = parse_number(self.low.text()), parse_number(self.high.text())
        return (low, high) if low is not None and high is not None and low < high else None


class ExportDialog(FormDialog):
    """Asks for format and file."""

    FORMATS = (
        ("csv", QT_TR_NOOP("Flight CSV (.csv)")),
        ("mat", QT_TR_NOOP("MATLAB (.mat)")),
        ("parquet", QT_TR_NOOP("Parquet (.parquet)")),
    )

    def __init__(self, style: DisplayStyle, start: Path, parent: QWidget | None = None) -> None:
        super().__init__(
            tr("Export the flight"),
            tr("All channels on one grid, with their units."),
            tr("Export"),
            style,
            parent,
        )
        self.kind = QComboBox()
        for kind, text in self.FORMATS:
            self.kind.addItem(tr(text), kind)
        self.add_row(tr("Format"), self.kind)
        self.path = PathField(tr("File"), style, folder=False)
        self.path.edit.setText(str(start.with_suffix(".csv")))
        self.message = FieldMessage()
        self.add_row(tr("File"), self.path, self.message)
        self.kind.activated.connect(self._update_suffix)
        self.path.edit.textChanged.connect(self._validate)
        self._validate()
        self.fit_to_content(560)

    def _update_suffix(self) -> None:
        text = self.path.edit.text().strip()
        if text:
            self.path.edit.setText(str(Path(text).with_suffix(f".{self.kind.currentData()}")))

    def _validate(self) -> None:
        text = self.path.edit.text().strip()
        file = Path(text).expanduser()
        usable = bool(text) and path_kind(file.parent) == "folder"
        if not text:
            self.message.set_message(tr("Name the file."), "warning")
        elif not usable:
            self.message.set_message(
                tr("There is no folder {parent}.").format(parent=file.parent), "warning"
            )
        elif path_kind(file) != "missing":
            self.message.set_message(tr("This file exists and will be replaced."), "caution")
        else:
            self.message.set_message(tr("A new file."), "good")
        self.button.setEnabled(usable)

    @property
    def request(self) -> tuple[str, Path]:
        return str(self.kind.currentData()), Path(self.path.edit.text().strip()).expanduser()


class ChannelMapDialog(FormDialog):
    """Asks which channel map reads a foreign file."""

    def __init__(
        self,
        style: DisplayStyle,
        path: Path,
        maps: Sequence[str],
        current: str,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(
            tr("Which channel map?"),
            tr("{name} contains messages; a channel map assigns them to channels.").format(
                name=path.name
            ),
            tr("Open"),
            style,
            parent,
        )
        self.channel_map = ShippedFileField(tr("Channel map"), maps, current)
        self.add_row(tr("Channel map"), self.channel_map)
        self.fit_to_content(480)


def ask_closing(
    parent: QWidget, flights: Sequence[str], works: Sequence[str] = (), caution: str = ""
) -> ClosingAnswer:
    """Ask what shall become of recordings, and of works that are not done, as a window closes.

    `caution` says what stopping the recording may do.
    A key pressed in haste loses nothing: it leaves recorders running, and where works would be
    given up, it stays.
    """
    sentences, consequences = [], []
    if flights:
        recorded = (
            tr("{flights} is being recorded.")
            if len(flights) == 1
            else tr("{flights} are being recorded.")
        )
        sentences.append(recorded.format(flights=tr(" and ").join(flights)))
        consequences.append(
            tr(
                "The recorder is a separate process. If left running, it continues without this "
                "window, and the next window finds it."
            )
        )
        if caution:
            consequences.append(caution)
    if works:
        sentences.append(tr("Not done yet: {works}.").format(works=", ".join(works)))
        consequences.append(tr("Unfinished work is discarded."))
    title = tr("Recording") if flights else tr("Not done")
    box = create_message_box(parent, title, " ".join(sentences), " ".join(consequences))
    role = QMessageBox.ButtonRole
    leave = box.addButton(tr("Leave it running") if flights else tr("Close"), role.AcceptRole)
    stop = box.addButton(tr("Stop recording"), role.DestructiveRole) if flights else None
    stay = box.addButton(tr("Stay"), role.RejectRole)
    box.setDefaultButton(stay if works else leave)
    box.setEscapeButton(stay)
    box.exec()
    box.deleteLater()
    clicked = box.clickedButton()
    if clicked is leave:
        return "leave"
    return "stop" if stop is not None and clicked is stop else "stay"


def ask_append(parent: QWidget, name: str, new_name: str) -> bool | None:
    """Ask whether to append to a finished flight; return None for neither that nor a new one."""
    box = create_message_box(
        parent,
        tr("Flight exists"),
        tr("{name} is a finished flight.").format(name=name),
        tr(
            "Record a new flight named {new_name}, or append to {name} so that both become one "
            "flight?"
        ).format(new_name=new_name, name=name),
    )
    new = box.addButton(tr("New flight"), QMessageBox.ButtonRole.AcceptRole)
    append = box.addButton(tr("Append"), QMessageBox.ButtonRole.DestructiveRole)
    cancel = box.addButton(tr("Cancel"), QMessageBox.ButtonRole.RejectRole)
    box.setDefaultButton(new)
    box.setEscapeButton(cancel)
    box.exec()
    box.deleteLater()
    clicked = box.clickedButton()
    return None if clicked not in (new, append) else clicked is append


def ask_stop(parent: QWidget, what: str, caution: str = "") -> bool:
    """Ask whether to stop the recording now, with a caution if any; going on is the default."""
    box = create_message_box(
        parent,
        tr("Stop recording"),
        tr("Stop recording {what}?").format(what=what),
        "\n\n".join(filter(None, (caution, tr("Everything recorded so far is kept.")))),
    )
    stop = box.addButton(tr("Stop recording"), QMessageBox.ButtonRole.DestructiveRole)
    go_on = box.addButton(tr("Keep recording"), QMessageBox.ButtonRole.RejectRole)
    box.setDefaultButton(go_on)
    box.setEscapeButton(go_on)
    box.exec()
    box.deleteLater()
    return box.clickedButton() is stop


class CertificatesDialog(FormDialog):
    """Asks for a set of certificates, and says what it would change."""

    def __init__(
        self,
        style: DisplayStyle,
        used: AppliedCertificates,
        shipped: Sequence[str],
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(
            tr("Other certificates"),
            tr(
                "Converts the recorded volts again. The certificates in the flight folder do not "
                "change."
            ),
            tr("Apply"),
            style,
            parent,
        )
        self._own = used.recorded
        self.certificates = ShippedFileField(
            tr("Certificates"),
            shipped,
            used.override_source,
            none=tr("Certificates of the flight"),
            folder=True,
        )
        self.message = FieldMessage()
        self.add_row(tr("Certificates"), self.certificates, self.message)
        self.certificates.currentIndexChanged.connect(self._validate)
        self._validate()
        self.fit_to_content(560)

    def _validate(self) -> None:
        given = self.certificates.value
        usable = True
        if not given:
            kept = len(self._own or {})
            text = tr("{certificates} in the flight folder.").format(
                certificates=count_text(kept, "certificate")
            )
            self.message.set_message(
                text if kept else tr("Certificates named by the channel map."), "good"
            )
        elif may_block(given):
            usable = False
            self.message.set_message(tr("{given} does not respond.").format(given=given), "warning")
        else:
            try:
                chosen = load_certificates(given)
            except GroundStationError as error:
                usable = False
                self.message.set_message(str(error), "warning")
            else:
                said = AppliedCertificates(
                    applied=chosen, override_source=given, recorded=self._own
                ).override_text
                self.message.set_message(f"{said[:1].upper()}{said[1:]}.", "caution")
        self.button.setEnabled(usable)
