"""The test cards: the list as it is to be flown, and the form of the card chosen."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QKeyEvent, QResizeEvent
from PySide6.QtWidgets import QFileDialog, QHBoxLayout, QVBoxLayout, QWidget

from gsapp.flight.cards import CardSet, TestCard
from gsapp.foundation import GroundStationError
from ui.background_job import BackgroundJob, JobProgress
from ui.commands import CommandRequirement
from ui.dialogs.file_dialogs import ask_save_file
from ui.dialogs.form_dialog import FieldMessage
from ui.display_style import DisplayStyle
from ui.number_format import count_text
from ui.preflight.card_set_model import (
    CardSetModel,
    build_card_item,
    create_amplitude_field,
    create_card_fields,
    create_surfaces_field,
    create_tolerance_fields,
    replace_surfaces,
)
from ui.preflight.flight_card_fields import CardField, format_field
from ui.preflight.form_editor import FormEditor
from ui.preflight.form_fields import FormField, FormPart, set_touch_height
from ui.preflight.preflight_model import PreflightModel
from ui.preflight.preflight_steps import SavingStepPage
from ui.settings import SettingsStore, initial_dialog_folder
from ui.translation import QT_TR_NOOP, tr
from ui.undo import UndoHistory
from ui.widgets.action_button import ActionButton
from ui.widgets.labels import create_label
from ui.widgets.layout_widgets import FormColumns, FormSection, create_button_row
from ui.widgets.status_list import StatusListView

if TYPE_CHECKING:
    from gsapp.flight.maneuvers import DetectedManeuver


_SI = {"speed": "m/s", "alpha": "rad", "amplitude": "", "width": ""}
_SURFACES = ("de", "da", "dr")


class CardEditor(FormPart[CardSet]):
    """Everything on a card."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__(style)
        self._row = 0
        self.fields: dict[str, FormField] = {}
        self.area = FormColumns(style, 2)
        self._column.addWidget(self.area)
        point, maneuver = FormSection(style, tr("Test point")), FormSection(style, tr("Maneuver"))
        allowed = FormSection(style, tr("Tolerance"))
        plain = {value.key[-1]: value for value in create_card_fields(0)}
        for name in ("id", "title", "speed", "alpha", "height", "flap"):
            point.add(self._field(name, plain[name]))
        maneuver.add(self._field("kind", plain["kind"]))
        maneuver.add(self._field("surfaces", create_surfaces_field(0)))
        for surface in _SURFACES:
            maneuver.add(self._field(surface, create_amplitude_field(0, surface, alone=False)))
        for name in ("width", "throttle_step", "repeats", "remarks"):
            maneuver.add(self._field(name, plain[name]))
        for value in create_tolerance_fields(0):
            allowed.add(self._field(f"tolerance.{value.key[-1]}", value))
        self.area.head.addWidget(create_label(tr("Esc: back to the list"), "hint"))
        self.area.show_sections([(point, 0), (maneuver, 1), (allowed, 0)])

    def _field(self, name: str, value: CardField) -> FormField:
        rows = 2 if value.kind == "lines" else 1
        field = FormField(self._style, value.name, rows=rows, choices=value.choices)
        field.text_edited.connect(lambda text: self._typed(name, text))
        field.editing_finished.connect(self.editing_finished)
        self.fields[name] = field
        return field

    def _values(self, card: TestCard) -> Mapping[str, CardField]:
        row = self._row
        alone = len(card.surfaces) == 1
        return {
            **{value.key[-1]: value for value in create_card_fields(row)},
            **{f"tolerance.{value.key[-1]}": value for value in create_tolerance_fields(row)},
            **{name: create_amplitude_field(row, name, alone=alone) for name in card.surfaces},
        }

    def show_card(self, editor: FormEditor[CardSet], row: int) -> None:
        """Show a card of the set."""
        self._editor, self._row = editor, row
        cards = editor.file.model.cards
        if row >= len(cards):
            return
        card, units = cards[row], self._style.units
        order = ",".join(card.surfaces)
        self.fields["surfaces"].set_choices(
            create_surfaces_field(row, card.surfaces).choices, order
        )
        values = self._values(card)
        for name in _SURFACES:
            self.fields[name].setVisible(name in card.surfaces)
        for name, value in values.items():
            field = self.fields[name]
            field.name.setText(tr(value.name))
            field.set_text(editor.field_text(value, units))
            field.show_unit(value.unit_label(units) if value.kind == "number" else "")
            if name.startswith("tolerance."):
                part = value.key[-1]
                usual = f"{getattr(card.tolerance, part)!r} {_SI[part]}"
                field.show_hint(format_field(value, usual, units))
        self.fields["title"].show_hint(card.display_title)
        self.validate()

    def validate(self) -> None:
        editor = self._editor
        if editor is None:
            return
        for name, value in self._values(editor.file.model.cards[self._row]).items():
            problem = editor.problems.get(value.key, "")
            self.fields[name].show_message(
                tr("Not saved: {problem}").format(problem=problem) if problem else "", "warning"
            )

    def _typed(self, name: str, text: str) -> None:
        editor = self._editor
        if editor is None:
            return
        card = editor.file.model.cards[self._row]
        if name == "surfaces":
            place = ("cards", str(self._row))
            editor.set_values(
                {place: replace_surfaces(editor.stored_value(place), text.split(","))}
            )
            self.show_card(editor, self._row)
        else:
            editor.enter_text(self._values(card)[name], text, self._style.units)
            self.validate()
        self.edited.emit()

    def set_initial_focus(self) -> None:
        """Put the keyboard into the first field, ready to be typed over."""
        self.fields["id"].setFocus()
        self.fields["id"].select_all()


_CARD_FILE_FILTER = QT_TR_NOOP("Test cards (*.toml)")
_SIDE_BY_SIDE_WIDTH = 900
"""Points of width below which the card stands in place of the list."""
_SEARCH_SECONDS = 15.0
"""Between two looks for maneuvers of a flight that goes on."""


class CardsPage(SavingStepPage):
    """Plans the maneuvers of a flight."""

    def __init__(
        self,
        style: DisplayStyle,
        actions: Mapping[str, QAction],
        store: SettingsStore,
        fail: Callable[[BaseException], object],
    ) -> None:
        super().__init__(style, tr("Test cards"), fail)
        self._store = store
        self.model: CardSetModel | None = None
        self._job: BackgroundJob | None = None
        self._searched: float | None = None
        self._search_clock = 0.0
        self._editing = False
        self._row = QHBoxLayout(self)
        self._list_panel = QWidget()
        self._left_column = QVBoxLayout(self._list_panel)
        self._left_column.setContentsMargins(0, 0, 0, 0)
        self.title = create_label("", "heading", wrap=True)
        self._left_column.addWidget(self.title)
        self.message = FieldMessage()
        self._left_column.addWidget(self.message)
        changes = ("cards_up", "cards_down", "cards_remove", "cards_add")
        self.list = StatusListView(style, tr("Test cards"), [actions[name] for name in changes])
        self.list.current_item_changed.connect(lambda _key: self._show_card())
        self.list.move_requested.connect(self.move_card)
        self.list.delete_requested.connect(self.remove)
        self.list.item_activated.connect(lambda _key: self.edit())
        self._left_column.addWidget(self.list, 1)
        buttons = [
            ActionButton(actions[name], text, style)
            for name, text in (
                ("cards_add", tr("Add")),
                ("cards_remove", tr("Remove")),
                ("cards_up", tr("Up")),
                ("cards_down", tr("Down")),
                ("cards_open", tr("Open…")),
                ("cards_save", tr("Save as…")),
            )
        ]
        for button in buttons:
            set_touch_height(button)
        self._left_column.addWidget(create_button_row(style, *buttons))
        self._row.addWidget(self._list_panel, 1)
        self.form = CardEditor(style)
        self.form.edited.connect(self._typed)
        self.form.editing_finished.connect(self._field_left)
        self._row.addWidget(self.form, 1)
        style.changed.connect(self._restyle)
        self._fit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        px = self.display_style.px
        self._list_panel.setVisible(self.is_side_by_side or not self._editing)
        self.form.setVisible(self.is_side_by_side or self._editing)
        self._row.setContentsMargins(px(16), px(12), 0, px(8))
        self._row.setSpacing(px(8))
        self._left_column.setSpacing(px(8))

    @property
    def is_side_by_side(self) -> bool:
        return self.width() >= self.display_style.px(_SIDE_BY_SIDE_WIDTH)

    def edit(self) -> None:
        """Go into the card; Esc comes back to the list."""
        self._editing = True
        self._fit()
        self.form.set_initial_focus()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Escape and not self.list.hasFocus():
            self.set_initial_focus()
        else:
            super().keyPressEvent(event)

    def _restyle(self) -> None:
        self._fit()
        self._show_list()
        self._show_card()

    # Showing

    @property
    def handlers(self) -> Mapping[str, Callable[[], object]]:
        return {
            "cards_add": self.add,
            "cards_remove": self.remove,
            "cards_up": lambda: self.move_card(-1),
            "cards_down": lambda: self.move_card(1),
            "cards_open": self.open,
            "cards_save": self.save,
        }

    @property
    def present(self) -> tuple[CommandRequirement, ...]:
        if self.model is None or self.model.editor is None:
            return ()
        return ("cards", "card") if self.list.current_key else ("cards",)

    def set_model(self, model: PreflightModel) -> None:
        """Show the cards of another flight."""
        self.flush()
        self.model = model.cards
        self.setEnabled(self.model.editor is not None)
        self._searched = None
        self._search_clock = 0.0
        self._show_list()
        self.list.select_row(0)
        self._show_card()
        self.show_save_state()

    def refresh(self) -> None:
        """Look now and then for what was flown, and for what another program wrote."""
        model = self.model
        if model is None or model.editor is None:
            return
        if not self._save_timer.isActive() and model.editor.reload_if_changed():
            self._cards_changed()
        if time.monotonic() - self._search_clock >= _SEARCH_SECONDS:
            self._search()

    def _show_list(self) -> None:
        model = self.model
        cards = model.cards if model is not None else None
        if model is None or cards is None:
            self.title.setText(tr("Test cards"))
            self.list.set_items(())
            return
        total = sum(card.repeats for card in cards.cards)
        name = cards.name or tr("Test cards")
        self.title.setText(f"{name}: {count_text(total, 'maneuver')}")
        units = self.display_style.units
        self.list.set_items(
            [build_card_item(card, model.progress(card.id), units) for card in cards.cards]
        )

    @property
    def row(self) -> int:
        return self.list.currentIndex().row()

    def _show_card(self) -> None:
        model = self.model
        if model is not None and model.editor is not None and self.row >= 0:
            self.form.show_card(model.editor, self.row)

    def show_save_state(self) -> None:
        """Say what is wrong with the cards, else whose they are."""
        model = self.model
        if model is None or model.editor is None:
            self.message.set_message("" if model is None else model.read_error, "warning")
        elif model.editor.problems:
            self.message.set_message(tr("Saved, except the marked fields."), "warning")
        elif not model.editor.file.is_saved:
            if self._save_timer.isActive():
                self.message.set_message(tr("Saving…"))
            else:
                self.message.set_message(tr("Not saved"), "warning")
        elif not model.editor.file.path.exists():
            self.message.set_message(tr("Shipped cards; a change makes your own copy."))
        elif model.flown is not None and model.flown.unplanned:
            beside = count_text(len(model.flown.unplanned), "maneuver")
            self.message.set_message(tr("Flown outside the cards: {beside}.").format(beside=beside))
        else:
            self.message.set_message(tr("Saved"), "good")

    def set_initial_focus(self) -> None:
        """Put the keyboard into the list."""
        self._editing = False
        self._fit()
        self.list.setFocus()

    # What was flown

    def _search(self) -> None:
        """Look in a thread for the maneuvers of the open flight."""
        model = self.model
        if model is None or (self._job is not None and self._job.is_running):
            return
        self._search_clock = time.monotonic()
        session = model.session
        now = None if session is None else session.now
        flight = None if now == self._searched else model.loadable_flight()
        if flight is None:
            return
        self._searched = now

        def run(_progress: JobProgress) -> tuple[DetectedManeuver, ...]:
            return model.find_maneuvers(flight)

        def found(maneuvers: tuple[DetectedManeuver, ...]) -> None:
            # Another flight may be open by now.
            if model.session is session:
                model.set_maneuvers(maneuvers)
                self._show_list()
                self.show_save_state()
                self.changed.emit()

        self._job = BackgroundJob(tr("Looking for maneuvers"), run, self)
        self._job.done.connect(found)
        self._job.failed.connect(self._fail)
        self._job.start()

    # Typing

    def _typed(self) -> None:
        self._save_timer.start()
        if self.model is not None:
            self.model.compare_with_flight()
        self._show_list()
        self.show_save_state()
        self.changed.emit()

    def _field_left(self) -> None:
        self.flush()
        self._show_card()

    @property
    def form_editor(self) -> FormEditor[CardSet] | None:
        return None if self.model is None else self.model.editor

    def _cards_changed(self, row: int | None = None) -> None:
        """Show the cards after they were changed as a whole."""
        if self.model is not None:
            self.model.compare_with_flight()
        self._show_list()
        if row is not None:
            self.list.select_row(row)
        self._show_card()
        self.flush()
        self.show_save_state()
        self.changed.emit()

    # Commands

    def add(self) -> None:
        """Put a copy of the card below it, and type its name."""
        if self.model is not None:
            self._cards_changed(self.model.add(max(self.row, 0)))
            self.edit()

    def remove(self) -> None:
        """Take the card out; Ctrl+Z brings it back."""
        if self.model is None or self.row < 0:
            return
        row = self.row
        if self.model.remove(row):
            self._cards_changed(row)
        else:
            self.message.set_message(
                tr("The last card cannot be removed: a set needs one."), "caution"
            )

    def move_card(self, steps: int) -> None:
        """Move the card up or down."""
        if self.model is not None and self.row >= 0:
            self._cards_changed(self.model.move(self.row, steps))

    def open(self) -> None:
        """Ask for a file, and take its cards in place of these; Ctrl+Z takes that back."""
        start = str(initial_dialog_folder(self._store.current))
        path, _kind = QFileDialog.getOpenFileName(
            self, tr("Open test cards"), start, tr(_CARD_FILE_FILTER)
        )
        if not path or self.model is None:
            return
        try:
            self.model.import_cards(Path(path))
        except GroundStationError as error:
            self._fail(error)
        else:
            self._cards_changed(0)

    def save(self) -> None:
        """Ask for a file, and write the cards there for other flights."""
        file = None if self.model is None else self.model.file
        if file is None:
            return
        start = initial_dialog_folder(self._store.current) / "test cards.toml"
        path = ask_save_file(self, tr("Save the test cards"), start, tr(_CARD_FILE_FILTER))
        if path is None:
            return
        try:
            file.save_as(path)
        except GroundStationError as error:
            self._fail(error)
        else:
            self.message.set_message(tr("Saved as {path}.").format(path=path), "good")

    @property
    def undo_history(self) -> UndoHistory | None:
        return None if self.model is None else self.model.editor

    def show_restored(self) -> None:
        self._cards_changed()
        self.changed.emit()
