"""Flying the virtual aircraft: plan, seed, speed, hidden effects."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QLineEdit,
    QListWidget,
    QListWidgetItem,
    QVBoxLayout,
    QWidget,
)

from gsapp.aircraft import load_aircraft
from gsapp.foundation import GroundStationError
from gsapp.virtual.downlink.flight_settings import FlightSettings
from ui.background_job import BackgroundJob
from ui.dialogs.file_fields import RecordingDialog, ShippedFileField
from ui.dialogs.flight_requests import VirtualFlightRequest
from ui.dialogs.form_dialog import FieldMessage, IntegerField
from ui.display_style import DisplayStyle
from ui.translation import tr
from ui.widgets.flow_layout import arrange
from ui.widgets.labels import plain_tooltip

_SPEEDS = (1.0, 2.0, 5.0, 10.0)
_USUAL_PLAN = "default"
_VIRTUAL_AIRCRAFT = "b777"


@dataclass(frozen=True, slots=True, kw_only=True)
class VirtualFlightOptions:
    """What can be chosen for the virtual aircraft."""

    plans: tuple[str, ...]  # Flight plans that come with the program, the usual one first.
    # Returns id and title of the effects that can be hidden in it; takes a second or two the first
    # time, so that it is called in a thread.
    effects: Callable[[], Sequence[tuple[str, str]]]


def virtual_flight_options() -> VirtualFlightOptions:
    """Return what can be chosen for the virtual aircraft."""
    # With their modules the window would start a quarter of a second later.
    from gsapp.virtual.flight_plan import SHIPPED_PLANS as PLANS

    plans = sorted(PLANS.names(), key=lambda name: (name != _USUAL_PLAN, name))
    return VirtualFlightOptions(plans=tuple(plans), effects=list_hidden_effects)


def list_hidden_effects() -> tuple[tuple[str, str], ...]:
    """Return id and title of the effects that can be hidden in the virtual aircraft."""
    from gsapp.dynamics.terms import create_term, effect_ids

    aircraft = load_aircraft(_VIRTUAL_AIRCRAFT)
    found = []
    for name in effect_ids():
        try:
            found.append((name, create_term(name, aircraft).title))
        except GroundStationError:
            # Needs something that this aircraft lacks.
            continue
    return tuple(found)


class VirtualFlightDialog(RecordingDialog):
    """Asks how the virtual aircraft shall fly."""

    def __init__(
        self,
        style: DisplayStyle,
        choices: VirtualFlightOptions,
        flights: Path,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(
            tr("Fly the virtual aircraft"),
            tr(
                "Engine start, pulses, take-off, doublets, landing: sent over a real link on this "
                "computer and recorded like any flight."
            ),
            tr("Fly"),
            style,
            parent,
        )
        self.plan = ShippedFileField(
            tr("Plan"), choices.plans, choices.plans[0] if choices.plans else ""
        )
        self.add_row(tr(FlightSettings.title_of("plan")), self.plan)
        self.speed = QComboBox()
        for speed in _SPEEDS:
            self.speed.addItem(
                tr("real time") if speed == 1.0 else tr("{speed:g} times").format(speed=speed),
                speed,
            )
        self.add_row(tr("Speed"), self.speed)
        self.seed = IntegerField(0, 999_999, 1)
        self.seed.setToolTip(tr(FlightSettings.help_of("seed")).removesuffix("."))
        self.add_row(tr(FlightSettings.title_of("seed")), self.seed)
        self.thin = QCheckBox(tr(FlightSettings.help_of("thin")).removesuffix("."))
        self.add_row(tr(FlightSettings.title_of("thin")), self.thin)
        self.search = QLineEdit()
        self.search.setPlaceholderText(tr("Search the effects"))
        self.search.setAccessibleName(tr("Search the effects"))
        self.search.setClearButtonEnabled(True)
        self.search.textChanged.connect(self._filter)
        self.effects = QListWidget()
        self.effects.setAccessibleName(tr("Hidden effects"))
        self.effects.setFixedHeight(style.px(112))
        self.effects.setProperty("role", "boxed")
        self.effects.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.note = FieldMessage()
        self.note.set_message(tr("Reading the catalog of effects…"))
        self._reading = BackgroundJob(
            tr("Reading the effects"), lambda _progress: choices.effects(), self
        )
        self._reading.done.connect(self._offer)
        self._reading.failed.connect(
            lambda error: self.note.set_message(
                tr("The effects cannot be read: {error}").format(error=error), "warning"
            )
        )
        self._reading.start()
        holder = QWidget()
        column = arrange(QVBoxLayout(holder), style.px(8))
        column.addWidget(self.search)
        column.addWidget(self.effects)
        holder.setFocusProxy(self.search)
        self.add_row(tr(FlightSettings.title_of("hide")), holder, self.note)
        self.add_folder_field(flights)
        self.fit_to_content()

    def _offer(self, effects: Sequence[tuple[str, str]]) -> None:
        for effect, title in effects:
            item = QListWidgetItem(f"{title}   ({effect})" if title else effect)
            item.setToolTip(plain_tooltip(item.text()))
            item.setData(Qt.ItemDataRole.UserRole, effect)
            item.setFlags(item.flags() | Qt.ItemFlag.ItemIsUserCheckable)
            item.setCheckState(Qt.CheckState.Unchecked)
            self.effects.addItem(item)
        self.note.set_message(tr(FlightSettings.help_of("hide")))
        self._filter(self.search.text())

    def _filter(self, text: str) -> None:
        wanted = text.lower().split()
        for row in range(self.effects.count()):
            item = self.effects.item(row)
            ticked = item.checkState() == Qt.CheckState.Checked
            fits = all(word in item.text().lower() for word in wanted)
            item.setHidden(not (fits or ticked))

    @property
    def request(self) -> VirtualFlightRequest:
        ticked = [
            str(self.effects.item(row).data(Qt.ItemDataRole.UserRole))
            for row in range(self.effects.count())
            if self.effects.item(row).checkState() == Qt.CheckState.Checked
        ]
        return VirtualFlightRequest(
            plan=self.plan.value,
            seed=self.seed.value,
            speed=float(self.speed.currentData()),
            hide=tuple(ticked),
            thin=self.thin.isChecked(),
            folder=self.folder_field.folder,
            title=self.folder_field.title.text().strip(),
        )
