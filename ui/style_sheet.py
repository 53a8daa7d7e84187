"""The style sheet: every standard control in the colors and sizes of the look."""

from __future__ import annotations

import tempfile
from functools import cache
from pathlib import Path

from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QPen

from ui.display_style import DisplayStyle, font_family, mix_colors

_ICON_POLYLINES = {
    "arrow_down": ((5, 9), (12, 16), (19, 9)),
    "arrow_left": ((15, 5), (8, 12), (15, 19)),
    "arrow_right": ((9, 5), (16, 12), (9, 19)),
    "arrow_up": ((5, 15), (12, 8), (19, 15)),
    "check": ((5, 12.5), (10, 17.5), (19, 7)),
}


class StyleSheetIcons:
    """Writes the pictures in the colors of a theme into a folder of their own, gone at exit."""

    def __init__(self) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="gsapp-signs-")

    def paths(self, style: DisplayStyle) -> dict[str, str]:
        found: dict[str, str] = {}
        for name, points in _ICON_POLYLINES.items():
            color = style.color("background" if name == "check" else "text")
            path = Path(self._folder.name) / f"{name}-{color.name()[1:]}.png"
            if not path.exists():
                _draw(points, color).save(str(path))
            found[name] = path.as_posix()
        return found


@cache
def style_sheet_icons() -> StyleSheetIcons:
    """Return those of this process: windows of one look then have one style sheet."""
    return StyleSheetIcons()


def _draw(points: tuple[tuple[float, float], ...], color: QColor) -> QImage:
    image = QImage(48, 48, QImage.Format.Format_ARGB32_Premultiplied)
    image.fill(Qt.GlobalColor.transparent)
    painter = QPainter(image)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.scale(2, 2)
    pen = QPen(color, 2.6)
    pen.setCapStyle(Qt.PenCapStyle.RoundCap)
    pen.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
    painter.setPen(pen)
    painter.drawPolyline([QPointF(x, y) for x, y in points])
    painter.end()
    return image


TAB_MARGIN = 4  # Points that the sheet leaves left and right of the words of a tab.

_SHEET = """
QWidget {{ color: {text}; font-family: "{family}"; font-size: {body}px; }}
QMainWindow, QDialog, QWidget#page, QWidget#frame {{ background: {background}; }}
QWidget#rail {{ background: {background}; border-right: 1px solid {line}; }}
QWidget#bar {{ background: {background}; border-bottom: 1px solid {line}; }}
QWidget#controls {{ background: {background}; border-top: 1px solid {line}; }}
QWidget#panel, QScrollArea#panel, QWidget#panelBody {{ background: {panel}; }}
QToolTip {{ background: {banner}; color: {banner_text}; border: 0; padding: {p4}px {p8}px; }}

QLabel {{ background: transparent; }}
QLabel[role="title"] {{ font-size: {title}px; font-weight: 600; }}
QLabel[role="heading"] {{ font-size: {heading}px; font-weight: 600; }}
QLabel[role="strong"] {{ font-weight: 600; }}
QLabel[role="label"], QLabel[role="hint"] {{ color: {muted}; font-size: {label}px; }}
QLabel[role="muted"] {{ color: {muted}; }}
QLabel[role="number"] {{ font-weight: 600; }}
QLabel[state="good"] {{ color: {good}; }}
QLabel[state="caution"] {{ color: {caution}; }}
QLabel[state="warning"] {{ color: {warning}; }}

QMenuBar {{ background: {background}; border-bottom: 1px solid {line}; padding: 0 {p8}px; }}
QMenuBar::item {{ background: transparent; padding: {p4}px {p8}px; }}
QMenuBar::item:selected, QMenuBar::item:pressed {{ background: {chosen}; }}
QToolButton#qt_menubar_ext_button {{ background: {chosen}; border: 0; border-radius: 0; padding: 0;
  qproperty-iconSize: 0px 0px; image: url("{arrow_right}"); }}
QMenu {{ background: {panel}; border: 1px solid {line}; padding: {p4}px 0;
  menu-scrollable: 1; }}
QMenu::item {{ padding: {p6}px {p24}px {p6}px {p32}px; }}
QMenu::item:selected {{ background: {chosen}; }}
QMenu::item:disabled {{ color: {faint}; }}
QMenu::separator {{ height: 1px; background: {line}; margin: {p4}px 0; }}
QMenu::indicator {{ width: {p12}px; height: {p12}px; margin-left: {p10}px; }}
QMenu::indicator:checked {{ background: {text}; border-radius: {p2}px; }}

QDialogButtonBox {{ dialogbuttonbox-buttons-have-icons: 0; }}
QPushButton, QToolButton {{ background: {panel}; border: 1px solid {axis}; border-radius: {p4}px;
  padding: {p4}px {p12}px; min-height: {p20}px; }}
QPushButton:hover, QToolButton:hover {{ background: {hover}; }}
QPushButton:pressed, QToolButton:pressed {{ background: {pressed}; }}
QPushButton:checked, QToolButton:checked {{ background: {text}; color: {background};
  border-color: {text}; }}
QPushButton:focus, QToolButton:focus {{ border: 2px solid {text}; padding: {p3}px {p11}px; }}
QPushButton:disabled, QToolButton:disabled {{ color: {faint}; border-color: {line};
  background: {background}; }}
QPushButton:default, QPushButton[role="primary"] {{ background: {text}; color: {background};
  border-color: {text}; }}
QPushButton:default:hover, QPushButton[role="primary"]:hover {{ background: {ink_hover}; }}
QPushButton:default:disabled, QPushButton[role="primary"]:disabled {{ background: {chosen};
  color: {faint}; border-color: {line}; }}
QPushButton:checked:focus, QPushButton:default:focus, QPushButton[role="primary"]:focus {{
  border: 3px double {text}; background-clip: padding; padding: {p2}px {p10}px; }}
QPushButton[role="quiet"] {{ background: transparent; border-color: transparent; }}
QPushButton[role="quiet"]:hover {{ background: {pressed}; }}
QPushButton[role="quiet"]:focus {{ border: 2px solid {text}; }}
QPushButton[role="segment"] {{ padding: {p4}px {p8}px; }}
QPushButton[role="segment"]:focus {{ padding: {p3}px {p7}px; }}

QLineEdit, QPlainTextEdit, QSpinBox, QDoubleSpinBox, QComboBox {{ background: {panel};
  border: 1px solid {axis}; border-radius: {p4}px; padding: {p4}px {p8}px; min-height: {p20}px;
  selection-background-color: {text}; selection-color: {background}; }}
QLineEdit, QPlainTextEdit, QComboBox {{ placeholder-text-color: {muted}; }}
QLineEdit:focus, QPlainTextEdit:focus, QSpinBox:focus, QDoubleSpinBox:focus, QComboBox:focus {{
  border: 2px solid {text}; padding: {p3}px {p7}px; }}
QLineEdit[tall="true"], QComboBox[tall="true"], QPushButton[tall="true"] {{
  min-height: {p34}px; }}
QLineEdit[state="warning"] {{ border: 2px solid {warning}; padding: {p3}px {p7}px; }}
QLineEdit:disabled, QSpinBox:disabled, QDoubleSpinBox:disabled, QComboBox:disabled {{
  color: {faint}; background: {background}; border-color: {line}; }}
QComboBox {{ combobox-popup: 0; }}
QComboBox::drop-down {{ border: 0; width: {p24}px; }}
QComboBox::down-arrow {{ image: url("{arrow_down}"); width: {p12}px; height: {p12}px; }}
QComboBox QAbstractItemView {{ background: {panel}; border: 1px solid {axis};
  selection-background-color: {chosen}; selection-color: {text}; outline: 0; }}
QComboBox QAbstractItemView:focus {{ border: 1px solid {axis}; }}
QCheckBox, QRadioButton {{ spacing: {p8}px; min-height: {p24}px;
  border: 1px solid transparent; border-radius: {p3}px; outline: 0; }}
QCheckBox::indicator, QRadioButton::indicator {{ width: {p16}px; height: {p16}px;
  border: 1px solid {axis}; background: {panel}; }}
QCheckBox::indicator {{ border-radius: {p3}px; }}
QRadioButton::indicator {{ border-radius: {p8}px; }}
QCheckBox::indicator:checked {{ image: url("{check}"); background: {text}; border-color: {text}; }}
QRadioButton::indicator:checked {{ background: {text}; border: {p4}px solid {panel};
  width: {p10}px; height: {p10}px; }}
QCheckBox:focus, QRadioButton:focus {{ border-color: {text}; }}
QCheckBox:disabled, QRadioButton:disabled {{ color: {faint}; }}

QTreeView, QTableView, QListView, QTreeWidget, QTableWidget, QListWidget {{ background: {panel};
  border: 2px solid transparent; outline: 0; alternate-background-color: {background};
  gridline-color: {grid}; }}
QAbstractItemView[role="boxed"] {{ border: 1px solid {axis}; border-radius: {p4}px; padding: 1px; }}
QTreeView:focus, QTableView:focus, QListView:focus {{ border: 2px solid {text}; padding: 0; }}
QScrollArea[role="read"], QTextBrowser {{ border: 2px solid transparent; }}
QScrollArea[role="read"]:focus, QTextBrowser:focus {{ border-color: {text}; }}
QTreeView::item, QListView::item {{ min-height: {p28}px; padding: 0 {p4}px; }}
QTableView::item {{ padding: {p4}px {p6}px; }}
QTableView[role="close"]::item {{ padding: {p4}px {p3}px; }}
QTreeView::item:hover, QListView::item:hover, QTableView::item:hover {{ background: {hover}; }}
QTreeView::item:selected, QListView::item:selected, QTableView::item:selected {{
  background: {chosen}; color: {text}; }}
QTreeView::item:selected:active, QListView::item:selected:active,
QTableView::item:selected:active {{ background: {pressed}; }}
QTreeView::branch {{ background: transparent; }}
QTreeView::branch:selected {{ background: {chosen}; }}
QTreeView::branch:selected:active {{ background: {pressed}; }}
QTreeView::branch:has-children:closed {{ image: url("{arrow_right}"); }}
QTreeView::branch:has-children:open {{ image: url("{arrow_down}"); }}
QTreeView::indicator, QTableView::indicator {{ width: {p14}px; height: {p14}px;
  border: 1px solid {axis}; border-radius: {p3}px; background: {panel}; }}
QTreeView::indicator:checked, QTableView::indicator:checked {{ image: url("{check}");
  background: {text}; border-color: {text}; }}
QHeaderView {{ background: {panel}; }}
QHeaderView::section {{ background: {panel}; color: {muted}; font-size: {label}px; border: 0;
  border-bottom: 1px solid {line}; padding: {p4}px {p8}px; }}
QTableView[role="close"] QHeaderView::section {{ padding: {p4}px {p4}px; }}
QTableCornerButton::section {{ background: {panel}; border: 0; }}

QTabWidget::pane {{ border: 0; border-top: 1px solid {line}; background: {panel}; }}
QTabBar {{ background: {background}; }}
QTabBar::tab {{ background: transparent; color: {muted}; font-size: {label}px;
  padding: {p8}px {tab_side}px {p6}px {tab_side}px; border-bottom: {p2}px solid transparent; }}
QTabBar::tab:selected {{ color: {text}; border-bottom-color: {text}; font-weight: 600; }}
QTabBar::tab:hover {{ background: {hover}; }}
QTabBar::tab:selected:focus {{ background: {text}; color: {background}; }}
QTabBar QToolButton {{ border: 0; border-radius: 0; padding: 0; min-height: 0; }}

QFileDialog {{ backward-icon: url("{arrow_left}"); forward-icon: url("{arrow_right}");
  filedialog-parent-directory-icon: url("{arrow_up}"); }}
QFileDialog QToolButton, QFileDialog QToolButton:focus {{ padding: 0; }}

QScrollBar {{ background: transparent; border: 0; }}
QScrollBar:vertical {{ width: {p10}px; }}
QScrollBar:horizontal {{ height: {p10}px; }}
QScrollBar::handle {{ background: {axis}; border-radius: {p3}px; margin: {p2}px; }}
QScrollBar::handle:vertical {{ min-height: {p32}px; }}
QScrollBar::handle:horizontal {{ min-width: {p32}px; }}
QScrollBar::handle:hover {{ background: {muted}; }}
QScrollBar::add-line, QScrollBar::sub-line, QScrollBar::add-page, QScrollBar::sub-page {{
  background: transparent; border: 0; width: 0; height: 0; }}
QSplitter::handle {{ background: {line}; }}
QSplitter::handle:horizontal {{ width: 1px; }}
QSplitter::handle:vertical {{ height: 1px; }}

QProgressBar {{ background: {chosen}; border: 0; border-radius: {p4}px; }}
QProgressBar::chunk {{ background: {text}; border-radius: {p4}px; }}

QWidget#messages {{ border-top: 1px solid {line}; }}
QWidget#messages QPushButton {{ padding: 1px {p8}px; min-height: {p16}px; }}
QFrame#banner {{ background: {panel}; border: 1px solid {muted}; border-radius: {p4}px; }}
QFrame#banner[level="caution"] {{ background: {caution_band}; }}
QFrame#banner[level="warning"] {{ background: {warning_band}; }}
QFrame#card {{ background: {panel}; border: 1px solid {line}; border-radius: {p8}px; }}
QFrame#rule {{ background: {line}; max-height: 1px; min-height: 1px; border: 0; }}
"""


def create_style_sheet(style: DisplayStyle, signs: dict[str, str]) -> str:
    """Return the style sheet.

    `signs`: paths of the small pictures that style sheets can only take from files: those of
    `ui.style_sheet`.
    """
    theme = style.theme
    colors = {
        role: style.color(role).name()
        for role in ("background", "panel", "text", "muted", "line", "axis", "grid", "hover",
                     "chosen", "pressed", "good", "caution", "warning", "caution_band",
                     "warning_band", "banner", "banner_text")
    }  # fmt: skip
    colors["faint"] = mix_colors(theme.background, theme.text, 0.5).name()
    colors["ink_hover"] = mix_colors(theme.text, theme.background, 0.18).name()
    steps = (2, 3, 4, 6, 7, 8, 10, 11, 12, 14, 16, 20, 24, 28, 32, 34)
    sizes = {f"p{step}": str(style.px(step)) for step in steps}
    sizes["tab_side"] = str(style.px(TAB_MARGIN))
    types = {
        "body": str(style.sizes.body),
        "label": str(style.sizes.label),
        "heading": str(style.px(15)),
        "title": str(style.px(22)),
        "family": font_family(),
    }
    return _SHEET.format(**colors, **sizes, **types, **signs)
