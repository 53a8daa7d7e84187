"""Pages without a flight, and the flights that were open last."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from PySide6.QtCore import QObject, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QFont, QFontMetricsF, QPainter, QPaintEvent, QResizeEvent
from PySide6.QtWidgets import QAbstractButton, QGridLayout, QPushButton, QSizePolicy, QWidget

from gsapp.flight.folder import FlightFolder
from ui.background_job import BackgroundJob
from ui.commands import shortcut_text
from ui.disk_checks import path_kind
from ui.display_style import DisplayStyle
from ui.flight_controller import FlightController
from ui.icons import paint_icon
from ui.number_format import clock_text
from ui.settings import RecentFlight, SettingsStore
from ui.translation import QT_TR_NOOP, tr
from ui.widgets.flow_layout import FlowLayout, clear_layout
from ui.widgets.labels import CenteredPage, create_label, plain_tooltip


class RecentFlights(QObject):
    """Keeps in the settings which flights were open, with what the start page says of them."""

    def __init__(self, controller: FlightController, store: SettingsStore) -> None:
        super().__init__(controller)
        self._controller = controller
        self._store = store
        controller.changed.connect(self._opened)
        controller.about_to_close.connect(self._left)

    def remove(self, path: str) -> None:
        """Forget a flight; its files stay as they are."""
        known = self._store.current.recent_flights
        self._store.change(recent_flights=[one.model_dump() for one in known if one.path != path])

    def _opened(self) -> None:
        session = self._controller.session
        if session is None:
            return
        path = session.path.absolute()
        self._store_flight(
            RecentFlight(path=str(path), name=session.name, aircraft=self._aircraft())
        )
        work = BackgroundJob(
            tr("Reading the date of {name}").format(name=path.name),
            lambda _progress: _recording_date(path),
            self,
        )
        work.done.connect(lambda date: self._update_flight(str(path), date=date))
        work.start()

    def _left(self) -> None:
        session = self._controller.session
        if session is not None:
            replay = session.replay_feed
            first, last = (0.0, session.now) if replay is None else (replay.start, replay.end)
            if first is not None and last is not None:
                path = str(session.path.absolute())
                self._update_flight(path, duration=last - first, aircraft=self._aircraft())

    def _aircraft(self) -> str:
        session = self._controller.session
        return "" if session is None or session.aircraft is None else session.aircraft.name

    def _store_flight(self, flight: RecentFlight) -> None:
        known = self._store.current.recent_flights
        former = next((one for one in known if one.path == flight.path), flight)
        kept = former.model_copy(update={"name": flight.name, "aircraft": flight.aircraft})
        self._store.replace(self._store.current.with_flight(kept))

    def _update_flight(self, path: str, **values: object) -> None:
        flights = tuple(
            one.model_copy(update=values) if one.path == path else one
            for one in self._store.current.recent_flights
        )
        self._store.change(recent_flights=[one.model_dump() for one in flights])


def _recording_date(path: Path) -> str:
    """Return when a flight was recorded, or written, as ``2026-05-12 14:03``."""
    info = FlightFolder(path=path).info() if path.is_dir() else None
    date = info.date if info is not None else None
    when = date or datetime.fromtimestamp(path.stat().st_mtime, UTC)
    return when.astimezone().strftime("%Y-%m-%d %H:%M")


_LINKS_OFFERED = 3
_FLIGHTS_OFFERED = 5
_TRAINING_SHORTCUT = "Ctrl+Shift+T"


@dataclass(frozen=True, slots=True, kw_only=True)
class StartOption:
    """One of the large choices of the empty window."""

    command: str
    title: str
    text: str
    icon: str
    key: str


START_OPTIONS = (
    StartOption(
        command="connect",
        title=QT_TR_NOOP("Connect an aircraft"),
        text=QT_TR_NOOP("Serial radio, UDP or TCP. Every byte is recorded."),
        icon="link",
        key="Ctrl+L",
    ),
    StartOption(
        command="open_file",
        title=QT_TR_NOOP("Open a flight"),
        text=QT_TR_NOOP("A file: tlog, bin, ulg, csv, mat. A flight folder: {keys}."),
        icon="folder",
        key="Ctrl+O",
    ),
    StartOption(
        command="virtual",
        title=QT_TR_NOOP("Fly the virtual aircraft"),
        text=QT_TR_NOOP("A full flight-test day, simulated."),
        icon="airplane",
        key="Ctrl+Shift+V",
    ),
)


class StartOptionButton(QAbstractButton):
    """A large choice: sign, title, sentence, key."""

    def __init__(self, choice: StartOption, style: DisplayStyle) -> None:
        super().__init__()
        self.option = choice
        self._title = tr(choice.title)
        self._words = tr(choice.text).format(keys=shortcut_text("Ctrl+Shift+O"))
        self.flat_width = 0  # Pixels of width of a flat card, for narrow windows; 0 for a tall one.
        self._style = style
        self.setText(self._title)
        self.setAccessibleName(f"{self._title}, {shortcut_text(choice.key)}")
        self.setAccessibleDescription(self._words)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)

    def sizeHint(self) -> QSize:
        style = self._style
        return (
            QSize(self.flat_width, style.px(64))
            if self.flat_width
            else QSize(style.px(256), style.px(208))
        )

    def paintEvent(self, _event: QPaintEvent) -> None:
        style = self._style
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        box = QRectF(self.rect()).adjusted(1, 1, -1, -1)
        lit = self.underMouse() or self.hasFocus()
        painter.setBrush(style.color("hover" if self.isDown() else "panel"))
        painter.setPen(style.color("accent" if lit else "line"))
        painter.drawRoundedRect(box, style.px(8), style.px(8))
        if self.hasFocus():
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.drawRoundedRect(box.adjusted(1, 1, -1, -1), style.px(7), style.px(7))
        if self.flat_width:
            self._paint_flat(painter, box)
        else:
            self._paint_tall(painter, box)
        painter.end()

    def _title_font(self) -> QFont:
        font = self._style.font("body", strong=True)
        font.setPixelSize(self._style.px(16))
        return font

    def _paint_flat(self, painter: QPainter, box: QRectF) -> None:
        style, choice = self._style, self.option
        side = style.px(32)
        sign = QRectF(style.px(16), (box.height() - side) / 2, side, side)
        paint_icon(painter, choice.icon, sign, style.color("text"))
        line = QRectF(style.px(64), style.px(8), box.width() - style.px(80), style.px(24))
        painter.setFont(self._title_font())
        painter.setPen(style.color("text"))
        painter.drawText(line, Qt.AlignmentFlag.AlignVCenter, self._title)
        painter.setPen(style.color("muted"))
        painter.setFont(style.font("label"))
        keys = Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignRight
        painter.drawText(line, keys, shortcut_text(choice.key))
        text = QFontMetricsF(painter.font()).elidedText(
            self._words, Qt.TextElideMode.ElideRight, line.width()
        )
        below = line.translated(0, style.px(24))
        painter.drawText(below, Qt.AlignmentFlag.AlignVCenter, text)

    def _paint_tall(self, painter: QPainter, box: QRectF) -> None:
        style, choice = self._style, self.option
        left, wide = style.px(24), box.width() - 2 * style.px(24)
        side = style.px(40)
        sign = QRectF(left, style.px(24), side, side)
        paint_icon(painter, choice.icon, sign, style.color("text"))
        painter.setFont(self._title_font())
        painter.setPen(style.color("text"))
        painter.drawText(QRectF(left, style.px(80), wide, style.px(24)), 0, self._title)
        painter.setFont(style.font("body"))
        painter.setPen(style.color("muted"))
        text = QRectF(left, style.px(108), wide, style.px(56))
        painter.drawText(text, Qt.TextFlag.TextWordWrap, self._words)
        small = style.font("label")
        painter.setFont(small)
        keys = shortcut_text(choice.key)
        across = QFontMetricsF(small).horizontalAdvance(keys) + style.px(16)
        chip = QRectF(left, box.bottom() - style.px(36), across, style.px(20))
        painter.setPen(style.color("line"))
        painter.setBrush(style.color("background"))
        painter.drawRoundedRect(chip, style.px(4), style.px(4))
        painter.setPen(style.color("muted"))
        painter.drawText(chip, Qt.AlignmentFlag.AlignCenter, keys)


class StartPage(CenteredPage):
    """The empty window: three choices, and what was used last."""

    chosen = Signal(str)  # Id of the command.
    link_chosen = Signal(str)  # A LINK used before.
    # Path of a flight that was open before, to open it again or to forget it.
    flight_chosen = Signal(str)
    flight_removed = Signal(str)

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__(style, 816)
        self.setAccessibleName(tr("Begin"))
        self.column.addWidget(create_label(tr("Ground station"), "title"))
        self.column.addWidget(create_label(tr("Choose a source."), "muted", wrap=True))
        self.column.addSpacing(16)
        row = QWidget()
        self._flow = FlowLayout(row, spacing=style.px(24))
        self.buttons: dict[str, StartOptionButton] = {}
        for choice in START_OPTIONS:
            button = StartOptionButton(choice, style)
            button.clicked.connect(
                lambda _checked=False, name=choice.command: self.chosen.emit(name)
            )
            self._flow.addWidget(button)
            self.buttons[choice.command] = button
        self.column.addWidget(row)
        self.column.addSpacing(8)
        self.training_button = QPushButton(
            tr("Train: fly the virtual aircraft with keys   {keys}").format(
                keys=shortcut_text(_TRAINING_SHORTCUT)
            )
        )
        self.training_button.setProperty("tall", True)
        self.training_button.setAccessibleName(
            tr("Train with the virtual aircraft, {keys}").format(
                keys=shortcut_text(_TRAINING_SHORTCUT)
            )
        )
        self.training_button.clicked.connect(lambda: self.chosen.emit("pilot_train"))
        self.column.addWidget(self.training_button, 0, Qt.AlignmentFlag.AlignLeft)
        self.column.addSpacing(8)
        self._links_holder = QWidget()
        self._links = FlowLayout(self._links_holder, spacing=style.px(8))
        self.column.addWidget(self._links_holder)
        self._links_holder.hide()
        self.column.addSpacing(8)
        self._flights_holder = QWidget()
        self._flights = QGridLayout(self._flights_holder)
        self._flights.setContentsMargins(0, 0, 0, 0)
        self._flights.setColumnStretch(0, 1)
        self.column.addWidget(self._flights_holder)
        self._flights_holder.hide()
        self.column.addSpacing(8)
        self._foot = create_label(
            tr("All keys: ?   ·   Larger: {larger}   ·   Theme: {theme}").format(
                larger=shortcut_text("Ctrl++"), theme=shortcut_text("Ctrl+T")
            ),
            "hint",
            wrap=True,
        )
        self.column.addWidget(self._foot)
        self.setFocusProxy(self.buttons[START_OPTIONS[0].command])
        style.changed.connect(self._rescale)

    def show_links(self, links: Sequence[str]) -> None:
        """Offer the links used last, to connect with one press."""
        clear_layout(self._links)
        for link in links[:_LINKS_OFFERED]:
            button = QPushButton(link)
            button.setAccessibleName(tr("Connect to {link}").format(link=link))
            button.clicked.connect(lambda _checked=False, text=link: self.link_chosen.emit(text))
            self._links.addWidget(button)
        self._links_holder.setVisible(bool(links))

    def show_flights(self, flights: Sequence[RecentFlight]) -> None:
        """List the flights opened last; those that are gone can only be removed."""
        clear_layout(self._flights)
        self._flights_holder.setVisible(bool(flights))
        if not flights:
            return
        self._flights.addWidget(create_label(tr("Recent flights"), "heading"), 0, 0, 1, 2)
        for row, flight in enumerate(flights[:_FLIGHTS_OFFERED], start=1):
            is_gone = path_kind(flight.path) == "missing"
            duration = clock_text(flight.duration) if flight.duration else ""
            facts = tr("not found") if is_gone else " · ".join(
                filter(None, (flight.date, duration, flight.aircraft))
            )  # fmt: skip
            name = flight.name or Path(flight.path).name
            button = QPushButton("   ".join(filter(None, (name, facts))).replace("&", "&&"))
            button.setStyleSheet("text-align: left")
            button.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
            button.setAccessibleName(tr("Open {name}, {facts}").format(name=name, facts=facts))
            button.setEnabled(not is_gone)
            button.setToolTip(
                plain_tooltip(
                    tr("{path} not found").format(path=flight.path) if is_gone else flight.path
                )
            )
            remove = QPushButton(tr("Remove"))
            remove.setProperty("role", "quiet")
            remove.setAccessibleName(tr("Remove {name} from this list").format(name=name))
            remove.setToolTip(tr("Remove from this list; the files stay"))
            for control, signal in ((button, self.flight_chosen), (remove, self.flight_removed)):
                control.clicked.connect(
                    lambda _checked=False, signal=signal, path=flight.path: signal.emit(path)
                )
            self._flights.addWidget(button, row, 0)
            self._flights.addWidget(remove, row, 1)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._rescale()

    def _rescale(self) -> None:
        if not hasattr(self, "buttons"):
            return
        narrow = self._body.width() < self._style.px(816)
        self._flow.setSpacing(self._style.px(8 if narrow else 24))
        for button in self.buttons.values():
            button.flat_width = self._body.width() if narrow else 0
            button.updateGeometry()
            button.update()
