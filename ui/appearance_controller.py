"""Theme, scale and units: what the View menu changes, live, and the dialog of all settings."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QApplication, QCheckBox, QComboBox, QDialogButtonBox, QWidget

from ui.commands import CommandSet
from ui.dialogs.connect import ConnectionOptions, add_recording_fields, connection_options
from ui.dialogs.form_dialog import FieldMessage, FormDialog, PathField
from ui.display_style import SCALE_STEPS, DisplayStyle, sans_serif_font
from ui.settings import Settings, SettingsStore, recording_folder, unwritable_reason
from ui.style_sheet import create_style_sheet, style_sheet_icons
from ui.theme import THEMES, theme_title
from ui.translation import QT_TR_NOOP, tr
from ui.window_frame.banners import Banner, BannerStack

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
        style: DisplayStyle,
        choices: ConnectionOptions,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(tr("Settings"), tr("Saved for the next start."), tr("Save"), style, parent)
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
        self.flights = PathField(tr("Flights folder"), style)
        self.message = FieldMessage()
        self.add_row(tr("Flights folder"), self.flights, self.message)
        self.recording = add_recording_fields(self, choices, settings)
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
        for value, text in entries:
            box.addItem(tr(text), value)
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
        for name, field in self.recording.items():
            field.show_value(getattr(settings, name))
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
            **{name: field.value for name, field in self.recording.items()},
        }


class AppearanceController(QObject):
    """Applies the look to the whole application and keeps it in the settings."""

    saved = Signal()  # Settings were saved in the dialog.
    layout_reset = Signal()  # Those of layout and panel are as at first.

    def __init__(
        self, style: DisplayStyle, store: SettingsStore, parent: QWidget | None = None
    ) -> None:
        super().__init__(parent)
        self._style = style
        self._store = store
        self._signs = style_sheet_icons()
        self._window = parent
        self._commands: CommandSet | None = None
        self._banners: BannerStack | None = None
        self._announced = style.theme.name
        self._banner: Banner | None = None
        style.changed.connect(self.apply)

    @property
    def handlers(self) -> Mapping[str, Callable[[], object]]:
        return {
            "next_theme": self.next_theme,
            **{f"theme_{name}": partial(self._style.set_theme, name) for name in THEMES},
            "units": self.toggle_units,
            "larger": lambda: self.step_scale(1),
            "smaller": lambda: self.step_scale(-1),
            "settings": self.edit_settings,
            "normal_size": lambda: self._style.set_scale(SCALE_STEPS[0]),
        }

    def connect_window(self, commands: CommandSet, banners: BannerStack) -> None:
        """Check the theme in the menu from now on, and name in a banner what theme was chosen."""
        self._commands, self._banners = commands, banners
        self._style.changed.connect(self._show_theme)
        for name in THEMES:
            commands.actions[f"theme_{name}"].triggered.connect(self._show_theme)
        self._show_theme()

    def _show_theme(self) -> None:
        chosen = self._style.theme.name
        if self._commands is None or self._banners is None:
            return
        for name in THEMES:
            self._commands.check(f"theme_{name}", name == chosen)
        if chosen != self._announced:
            self._announced = chosen
            if self._banner is not None:
                self._banners.remove(self._banner)
            self._banner = self._banners.show_banner(
                "note", tr("{theme} theme.").format(theme=theme_title(chosen))
            )

    def edit_settings(self) -> None:
        """Ask for what is remembered, and put it in force."""
        dialog = SettingsDialog(
            self._store.current, self._style, connection_options(), self._window
        )
        if not dialog.exec():
            return
        values = dialog.values
        if values.pop("muted") != self._store.current.muted and self._commands is not None:
            self._commands.actions["mute"].trigger()
        self._style.set_theme(str(values.pop("theme")))
        self._style.set_scale(int(str(values.pop("scale"))))
        self._style.set_units(str(values.pop("units")))
        self._store.change(**values)
        self.saved.emit()
        if dialog.reset_layout.isChecked():
            self.layout_reset.emit()

    def apply(self) -> None:
        """Put style sheet and font in force, and remember."""
        application = QApplication.instance()
        style = self._style
        sheet = create_style_sheet(style, self._signs.paths(style))
        # Qt styles every widget anew even with the same sheet, as after a change of units.
        if isinstance(application, QApplication) and application.styleSheet() != sheet:
            application.setFont(sans_serif_font(style.sizes.body))
            application.setStyleSheet(sheet)
        self._store.change(theme=style.theme.name, scale=style.scale, units=style.units)

    def next_theme(self) -> None:
        names = list(THEMES)
        self._style.set_theme(names[(names.index(self._style.theme.name) + 1) % len(names)])

    def toggle_units(self) -> None:
        self._style.set_units("SI" if self._style.units == "US" else "US")

    def step_scale(self, steps: int) -> None:
        """Make everything larger or smaller by one step."""
        place = min(
            range(len(SCALE_STEPS)), key=lambda index: abs(SCALE_STEPS[index] - self._style.scale)
        )
        self._style.set_scale(SCALE_STEPS[min(max(place + steps, 0), len(SCALE_STEPS) - 1)])
