"""All that the program remembers of the user's choices, in one dialog."""

from __future__ import annotations

from typing import Any

from PySide6.QtWidgets import QCheckBox, QComboBox, QDialogButtonBox, QWidget

from ui.dialogs.connect import ConnectionOptions
from ui.dialogs.file_fields import ShippedFileField
from ui.dialogs.form_dialog import FieldMessage, FormDialog, PathField
from ui.display_style import SCALE_STEPS, DisplayStyle
from ui.settings import Settings, recording_folder, unwritable_reason
from ui.theme import THEMES, theme_title
from ui.translation import QT_TR_NOOP, tr

_SPEECH = (
    ("page", QT_TR_NOOP("While the pilot's page is in use")), ("always", QT_TR_NOOP("Always")),
    ("never", QT_TR_NOOP("Never")),
)  # fmt: skip
_UNITS = (("US", QT_TR_NOOP("US customary (ft, lb, °F)")), ("SI", QT_TR_NOOP("SI (m, kg, °C)")))


class SettingsDialog(FormDialog):
    """Asks for look, units, sound, and what a new flight begins with."""

    def __init__(
        self,
        settings: Settings,
        look: DisplayStyle,
        choices: ConnectionOptions,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(tr("Settings"), tr("Saved for the next start."), tr("Save"), look, parent)
        self.theme = self._choice([(name, theme_title(name)) for name in THEMES])
        self.add_row(tr("Theme"), self.theme)
        self.scale = self._choice([(percent, f"{percent} %") for percent in SCALE_STEPS])
        self.add_row(tr("Scale"), self.scale)
        self.units = self._choice(_UNITS)
        self.add_row(tr("Units"), self.units)
        self.sound = QCheckBox(tr("Play alarms and callouts"))
        self.add_row(tr("Sound"), self.sound)
        self.speech = self._choice(_SPEECH)
        self.add_row(tr("Spoken cues"), self.speech)
        self.flights = PathField(tr("Flights folder"), look)
        self.message = FieldMessage()
        self.add_row(tr("Flights folder"), self.flights, self.message)
        self.aircraft = ShippedFileField(tr("Aircraft"), choices.aircraft, settings.aircraft)
        self.add_row(tr("Aircraft"), self.aircraft)
        self.channel_map = ShippedFileField(
            tr("Channel map"), choices.channel_maps, settings.channel_map
        )
        self.add_row(tr("Channel map"), self.channel_map)
        self.calibration = ShippedFileField(
            tr("Calibration"), choices.calibrations, settings.calibration,
            none=tr("From the channel map"), folder=True,
        )  # fmt: skip
        self.add_row(tr("Calibration"), self.calibration)
        restore = self.buttons.addButton(
            tr("Restore defaults"), QDialogButtonBox.ButtonRole.ResetRole
        )
        restore.clicked.connect(lambda: self.show_values(Settings()))
        self.reset_layout = QCheckBox(tr("Reset layout and panel width"))
        self.add_row(tr("Flight page"), self.reset_layout)
        self.flights.edit.textChanged.connect(self._validate)
        self.show_values(settings)
        self.fit_to_content(560)

    @staticmethod
    def _choice(entries: Any) -> QComboBox:
        box = QComboBox()
        for value, words in entries:
            box.addItem(tr(words), value)
        return box

    def show_values(self, settings: Settings) -> None:
        """Show these settings; they count once saved."""
        for box, value in (
            (self.theme, settings.theme),
            (self.scale, settings.scale),
            (self.units, settings.units),
            (self.speech, settings.flight_speech),
        ):
            box.setCurrentIndex(max(box.findData(value), 0))
        self.sound.setChecked(not settings.muted)
        self.flights.edit.setText(str(recording_folder(settings)))
        for field, name in (
            (self.aircraft, settings.aircraft),
            (self.channel_map, settings.channel_map),
            (self.calibration, settings.calibration),
        ):
            field.show_value(name)
        self._validate()

    def _validate(self) -> None:
        text = self.flights.edit.text().strip()
        why = unwritable_reason(self.flights.path) if text else tr("Name a folder.")
        self.message.set_message(
            why or tr("New flights are recorded here."), "warning" if why else "good"
        )
        self.button.setEnabled(not why)

    @property
    def values(self) -> dict[str, object]:
        defaults = Settings()
        usual = str(recording_folder(defaults))
        flights = str(self.flights.path)
        names = ("layout", "panel_width", "side_panel") if self.reset_layout.isChecked() else ()
        return {
            **{name: getattr(defaults, name) for name in names},
            "theme": self.theme.currentData(),
            "scale": self.scale.currentData(),
            "units": self.units.currentData(),
            "muted": not self.sound.isChecked(),
            "flight_speech": self.speech.currentData(),
            "flights": "" if flights == usual else flights,
            "aircraft": self.aircraft.value,
            "channel_map": self.channel_map.value,
            "calibration": self.calibration.value,
        }
