"""The menu of the systems heard on the link, one of which is the flown one."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QActionGroup
from PySide6.QtWidgets import QMenu, QWidget

from ui.dialogs.link_rows import describe_vehicle
from ui.flight_controller import FlightController
from ui.translation import tr


def create_system_menu(
    controller: FlightController, link_action: QAction, parent: QWidget
) -> QMenu | None:
    """Return the menu, deleted when it closes; None without a flight."""
    session = controller.session
    if session is None:
        return None
    report = session.link_report()
    menu = QMenu(tr("Flown system"), parent)
    menu.setObjectName("flown_system")
    menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    group = QActionGroup(menu)
    for vehicle in () if report is None else report.vehicles:
        action = menu.addAction(
            describe_vehicle(vehicle, live=not controller.is_replay),
            partial(controller.select_system, vehicle.system),
        )
        action.setCheckable(True)
        action.setChecked(report is not None and vehicle.system == report.system)
        group.addAction(action)
    if menu.isEmpty():
        menu.addAction(tr("No aircraft found")).setEnabled(False)
    menu.addSeparator()
    menu.addAction(link_action)
    return menu
