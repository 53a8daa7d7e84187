"""Choosing the charts: a tree of what the flight has, the chosen ones in order, saved layouts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from PySide6.QtCore import QModelIndex, Qt, Signal
from PySide6.QtGui import QAction, QKeyEvent, QResizeEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QComboBox,
    QHBoxLayout,
    QInputDialog,
    QLineEdit,
    QListWidget,
    QMenu,
    QPushButton,
    QSplitter,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

from gsapp.quantities import channel
from ui.commands import shortcut_text
from ui.display_style import DisplayStyle
from ui.flight.chart_selection import (
    SHIPPED_LAYOUT_NAMES,
    build_layout,
    group_channels,
    list_layout_rows,
    matches_search,
    move_row,
    row_text,
    toggle_channel,
)
from ui.number_format import count_text, symbol_text
from ui.strips.strip_layout import StripLayout
from ui.translation import tr
from ui.widgets.flow_layout import arrange
from ui.widgets.labels import create_label, plain_tooltip
from ui.widgets.table_menu import TableMenu, create_table_actions

_ID = Qt.ItemDataRole.UserRole


class _ChartOrderList(QListWidget):
    """Headings and charts; dragged, or moved with Alt+Up and Alt+Down, removed with Delete."""

    moved = Signal(int, int)
    removed = Signal(int)
    dropped = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.setDragDropMode(QAbstractItemView.DragDropMode.InternalMove)
        self.setDefaultDropAction(Qt.DropAction.MoveAction)
        self.setAccessibleName(tr("Charts in their order"))
        up, down = shortcut_text("Alt+Up"), shortcut_text("Alt+Down")
        self.setToolTip(
            tr("Drag to order, or {up} and {down}; Delete removes").format(up=up, down=down)
        )
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.model().rowsMoved.connect(self._rows_moved)

    def _rows_moved(self, *_where: QModelIndex | int) -> None:
        self.dropped.emit()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        row = self.currentRow()
        alt = bool(event.modifiers() & Qt.KeyboardModifier.AltModifier)
        if row >= 0 and alt and event.key() in (Qt.Key.Key_Up, Qt.Key.Key_Down):
            self.moved.emit(row, -1 if event.key() == Qt.Key.Key_Up else 1)
        elif row >= 0 and event.key() in (Qt.Key.Key_Delete, Qt.Key.Key_Backspace):
            self.removed.emit(row)
        else:
            super().keyPressEvent(event)


_MIN_LIST_HEIGHT = 88
"""Points: three lines."""


class ChannelPanel(QWidget):
    """Chooses and orders the charts."""

    charts_changed = Signal(object)  # The charts as the user wants them now.
    layout_chosen = Signal(str)  # A layout to show.
    layout_saved = Signal(str)  # Save what is on screen under that name.
    layout_deleted = Signal(str)  # Forget a saved layout.
    import_requested = Signal()  # Take a layout from a file of another computer.
    export_requested = Signal()  # Write what is on screen into a file for others.

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        self._available: tuple[str, ...] = ()
        self._charts = StripLayout()
        self._notes: dict[str, str] = {}
        self._busy = False
        column = arrange(QVBoxLayout(self), 8, 8, 8, 8, 8)
        column.addLayout(self._layout_row())
        self.search = QLineEdit()
        self.search.setPlaceholderText(tr("Search channels"))
        self.search.setAccessibleName(tr("Search channels"))
        self.search.setClearButtonEnabled(True)
        self.search.textChanged.connect(self._filter)
        self.search.returnPressed.connect(self._toggle_first)
        column.addWidget(self.search)
        self._split = split = QSplitter(Qt.Orientation.Vertical)
        split.setChildrenCollapsible(False)
        self.tree = QTreeWidget()
        self.tree.setHeaderHidden(True)
        self.tree.setAccessibleName(tr("Channels of this flight"))
        self.tree.itemChanged.connect(self._ticked)
        self.tree.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        split.addWidget(self.tree)
        lower = QWidget()
        below = arrange(QVBoxLayout(lower), 4, 0, 8, 0, 0)
        head = QHBoxLayout()
        self._count = create_label("", "label")
        head.addWidget(self._count, 1)
        heading = QPushButton(tr("Add heading"))
        heading.setProperty("role", "quiet")
        heading.setAccessibleName(tr("Add a heading to the charts"))
        heading.clicked.connect(self._add_heading)
        head.addWidget(heading)
        below.addLayout(head)
        self.order = _ChartOrderList()
        self.order.moved.connect(self._move)
        self.order.removed.connect(self._remove)
        self.order.dropped.connect(self._dropped)
        self._add_menus()
        below.addWidget(self.order, 1)
        split.addWidget(lower)
        split.setStretchFactor(0, 3)
        split.setStretchFactor(1, 2)
        column.addWidget(split, 1)
        style.changed.connect(self._restyle)
        self._fit_lists()

    def _fit_lists(self) -> None:
        for view in (self.tree, self.order):
            view.setMinimumHeight(self._style.px(_MIN_LIST_HEIGHT))

    def _add_menus(self) -> None:
        show = QAction(tr("Show or hide in the charts"), self.tree)
        show.triggered.connect(self._toggle_current)
        self.tree.currentItemChanged.connect(
            lambda leaf, _: show.setEnabled(leaf is not None and leaf.parent() is not None)
        )
        show.setEnabled(False)
        self.tree.addActions([show, *create_table_actions(self.tree, self._channel_table)])
        self.tree.setContextMenuPolicy(Qt.ContextMenuPolicy.ActionsContextMenu)
        order = self.order
        menu = TableMenu(
            order, table=lambda: [(tr("Charts"),), *((text,) for text in self._order())]
        )
        menu.add_command(tr("Move up"), lambda: self._move(order.currentRow(), -1))
        menu.add_command(tr("Move down"), lambda: self._move(order.currentRow(), 1))
        menu.add_command(tr("Remove"), lambda: self._remove(order.currentRow()))

    def _order(self) -> list[str]:
        return [self.order.item(row).text() for row in range(self.order.count())]

    def _channel_table(self) -> list[tuple[str, ...]]:
        specs = [channel(leaf.data(0, _ID)) for leaf in self._channel_items()]
        return [
            (tr("Group"), tr("Symbol"), tr("Channel"), tr("Show in charts")),
            *(
                (one.group, symbol_text(one.symbol), one.title,
                 tr("yes") if one.id in self._charts.channels else tr("no"))
                for one in specs
            ),
        ]  # fmt: skip

    def _toggle_current(self) -> None:
        item = self.tree.currentItem()
        if item is None:
            return
        name = item.data(0, _ID)
        self._set(toggle_channel(self._charts, name, name not in self._charts.channels))

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        wide = self.width() > 1.5 * self.height()
        self._split.setOrientation(Qt.Orientation.Horizontal if wide else Qt.Orientation.Vertical)

    def _layout_row(self) -> QHBoxLayout:
        row = QHBoxLayout()
        row.setSpacing(4)
        self.layouts = QComboBox()
        self.layouts.setAccessibleName(tr("Layout"))
        self.layouts.setToolTip(tr("Layouts: named choices of charts"))
        self.layouts.setMinimumContentsLength(8)
        self.layouts.setSizeAdjustPolicy(
            QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
        )
        self.layouts.activated.connect(
            lambda index: self.layout_chosen.emit(self.layouts.itemData(index))
        )
        row.addWidget(self.layouts, 1)
        save = QPushButton(tr("Save as…"))
        save.setAccessibleName(tr("Save this layout under a name"))
        save.clicked.connect(self._ask_name)
        row.addWidget(save)
        more = QPushButton(tr("More"))
        more.setAccessibleName(tr("More for layouts"))
        menu = QMenu(more)
        menu.setToolTipsVisible(True)
        menu.addAction(tr("Import from a file…"), self.import_requested.emit)
        menu.addAction(tr("Export to a file…"), self.export_requested.emit)
        self.delete = menu.addAction(
            tr("Delete"), lambda: self.layout_deleted.emit(self.layouts.currentData())
        )
        more.setMenu(menu)
        row.addWidget(more)
        return row

    # What is shown

    def show_layouts(self, saved: Sequence[str], current: str) -> None:
        """List the layouts; `current` may be empty for one without a name."""
        self.layouts.clear()
        for name in (*SHIPPED_LAYOUT_NAMES, *saved):
            self.layouts.addItem(tr(name), name)
        self.layouts.setCurrentIndex(self.layouts.findData(current) if current else -1)
        self.layouts.setPlaceholderText(tr("Custom"))
        self.delete.setEnabled(current in saved)
        self.delete.setToolTip(
            plain_tooltip("" if current in saved else tr("Only saved layouts can be deleted"))
        )

    def show_channels(
        self, available: Sequence[str], charts: StripLayout, notes: Mapping[str, str]
    ) -> None:
        """Show what the flight has and what is charted.

        `notes`: what is to be said of a channel, such as ``estimated``.
        """
        self._charts = charts
        if (tuple(available), dict(notes)) != (self._available, self._notes):
            self._available, self._notes = tuple(available), dict(notes)
            self._fill_tree()
        else:
            self._tick_tree()
        self._fill_order()

    def _fill_tree(self) -> None:
        self._busy = True
        closed = {
            branch.data(0, _ID)
            for branch in _child_items(self.tree.invisibleRootItem())
            if not branch.isExpanded()
        } | ({"Volts"} if not self.tree.topLevelItemCount() else set())
        self.tree.clear()
        for name, specs in group_channels(self._available).items():
            branch = QTreeWidgetItem([f"{name}  ({len(specs)})"])
            branch.setData(0, _ID, name)
            branch.setFlags(Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable)
            self.tree.addTopLevelItem(branch)
            for spec in specs:
                note = self._notes.get(spec.id, "")
                leaf = QTreeWidgetItem([f"{symbol_text(spec.symbol)}   {spec.title}"])
                leaf.setData(0, _ID, spec.id)
                leaf.setToolTip(
                    0, plain_tooltip(f"{spec.description}{f' · {note}' if note else ''}")
                )
                if note:
                    leaf.setText(0, f"{leaf.text(0)}  · {note}")
                if "estimated" in note:
                    font = leaf.font(0)
                    font.setItalic(True)
                    leaf.setFont(0, font)
                leaf.setFlags(
                    Qt.ItemFlag.ItemIsEnabled
                    | Qt.ItemFlag.ItemIsSelectable
                    | Qt.ItemFlag.ItemIsUserCheckable
                )
                branch.addChild(leaf)
            branch.setExpanded(name not in closed)
        self._busy = False
        self._tick_tree()
        self._filter(self.search.text())

    def _channel_items(self) -> list[QTreeWidgetItem]:
        return [
            leaf
            for branch in _child_items(self.tree.invisibleRootItem())
            for leaf in _child_items(branch)
        ]

    def _tick_tree(self) -> None:
        self._busy = True
        for leaf in self._channel_items():
            on = leaf.data(0, _ID) in self._charts.channels
            leaf.setCheckState(0, Qt.CheckState.Checked if on else Qt.CheckState.Unchecked)
        self._busy = False

    def _fill_order(self) -> None:
        order = list_layout_rows(self._charts)
        texts = [row_text(row) for row in order]
        if self._order() != texts:
            kept = self.order.currentRow()
            self.order.clear()
            self.order.addItems(texts)
            self.order.setCurrentRow(min(kept, self.order.count() - 1))
        for index, row in enumerate(order):
            self.order.item(index).setData(_ID, row)
        self._restyle()
        self._count.setText(
            tr("{charts}, top to bottom").format(
                charts=count_text(len(self._charts.strips), "chart")
            )
        )

    def _restyle(self) -> None:
        """Give headings their letters; a style sheet cannot tell them from charts."""
        self._fit_lists()
        font = self._style.font("label", strong=True)
        for place in range(self.order.count()):
            item = self.order.item(place)
            if isinstance(item.data(_ID), str) and item.font() != font:
                item.setFont(font)

    # What the user does

    def _set(self, charts: StripLayout) -> None:
        if charts != self._charts:
            self._charts = charts
            self._tick_tree()
            self._fill_order()
            self.charts_changed.emit(charts)

    def _ticked(self, leaf: QTreeWidgetItem, _column: int) -> None:
        if not self._busy and leaf.parent() is not None:
            on = leaf.checkState(0) == Qt.CheckState.Checked
            self._set(toggle_channel(self._charts, leaf.data(0, _ID), on))

    def _move(self, place: int, steps: int) -> None:
        order = move_row(list_layout_rows(self._charts), place, steps)
        self._set(build_layout(self._charts, order))
        self.order.setCurrentRow(min(max(place + steps, 0), self.order.count() - 1))

    def _remove(self, place: int) -> None:
        order = list(list_layout_rows(self._charts))
        del order[place]
        self._set(build_layout(self._charts, order))

    def _dropped(self) -> None:
        order = [self.order.item(row).data(_ID) for row in range(self.order.count())]
        self._set(build_layout(self._charts, order))

    def _add_heading(self) -> None:
        name, agreed = QInputDialog.getText(self, tr("Add heading"), tr("Heading text"))
        if agreed and name.strip():
            order = list(list_layout_rows(self._charts))
            order.insert(max(self.order.currentRow(), 0), name.strip())
            self._set(build_layout(self._charts, order))

    def _filter(self, text: str) -> None:
        for branch in _child_items(self.tree.invisibleRootItem()):
            count = 0
            for leaf in _child_items(branch):
                shown = matches_search(channel(leaf.data(0, _ID)), text)
                leaf.setHidden(not shown)
                count += shown
            branch.setHidden(count == 0)
            if text and count:
                branch.setExpanded(True)

    def _toggle_first(self) -> None:
        """Enter in the search adds or removes the first hit: choosing without the mouse."""
        for leaf in self._channel_items():
            if not leaf.isHidden():
                on = leaf.data(0, _ID) not in self._charts.channels
                self._set(toggle_channel(self._charts, leaf.data(0, _ID), on))
                return

    def _ask_name(self) -> None:
        at = self.layouts.currentText()
        name, agreed = QInputDialog.getText(
            self,
            tr("Save layout"),
            tr("Name of the layout"),
            text="" if at in SHIPPED_LAYOUT_NAMES else at,
        )
        if agreed and name.strip():
            self.layout_saved.emit(name.strip())

    def set_initial_focus(self) -> None:
        """Put the keyboard into the search."""
        self.search.setFocus(Qt.FocusReason.ShortcutFocusReason)
        self.search.selectAll()


def _child_items(item: QTreeWidgetItem) -> list[QTreeWidgetItem]:
    children = (item.child(row) for row in range(item.childCount()))
    return [child for child in children if child is not None]
