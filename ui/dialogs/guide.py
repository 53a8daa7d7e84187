"""The user guide: the documents that come with the program, readable without a network."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import Qt, QUrl
from PySide6.QtGui import QDesktopServices, QPalette, QTextDocument
from PySide6.QtWidgets import (
    QDialog,
    QHBoxLayout,
    QListWidget,
    QListWidgetItem,
    QTextBrowser,
    QWidget,
)

from ui.display_style import DisplayStyle
from ui.translation import tr

_KINDS = ("how-to", "reference", "explanation")
"""Folders of pages, in the order of the list; the tutorial comes first."""


def guide_folder() -> Path | None:
    """Return where the documents are: beside the source, or where an installation puts them.

    ``pip install --target`` and ``--user`` put ``share`` elsewhere than into ``sys.prefix``, but
    always beside or above the packages.
    """
    above = Path(__file__).parents[2:]
    places = (above[0] / "docs", *(folder / "share/doc/gsapp" for folder in above))
    return next((place for place in places if (place / "tutorial.md").is_file()), None)


def guide_pages(folder: Path) -> tuple[tuple[str, Path], ...]:
    """Return title and file of each page: tutorial, how-to, reference, explanation, the rest."""
    tutorial = folder / "tutorial.md"
    kinds = (path for kind in _KINDS for path in sorted((folder / kind).glob("*.md")))
    rest = (path for path in sorted(folder.glob("*.md")) if path != tutorial)
    return tuple((_title(path), path) for path in (tutorial, *kinds, *rest))


def _title(path: Path) -> str:
    with path.open(encoding="utf-8") as lines:
        return next((line[2:].strip() for line in lines if line.startswith("# ")), path.stem)


class GuideWindow(QDialog):
    """Pages on the left, the chosen one on the right. Stays open beside the window."""

    def __init__(self, look: DisplayStyle, folder: Path, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle(tr("User guide"))
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.resize(look.px(960), look.px(720))
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(0)
        self.pages = QListWidget()
        self.pages.setAccessibleName(tr("Pages of the guide"))
        self.pages.setFixedWidth(look.px(240))
        self.browser = QTextBrowser()
        self.browser.setAccessibleName(tr("Page of the guide"))
        self.browser.setOpenLinks(False)
        palette = self.browser.palette()
        palette.setColor(QPalette.ColorRole.Link, look.color("target"))
        self.browser.setPalette(palette)
        self._margin = look.px(24)
        self.browser.anchorClicked.connect(self._open_link)
        row.addWidget(self.pages)
        row.addWidget(self.browser, 1)
        for title, path in guide_pages(folder):
            item = QListWidgetItem(title)
            item.setToolTip(title)
            item.setData(Qt.ItemDataRole.UserRole, path)
            self.pages.addItem(item)
        self.pages.currentItemChanged.connect(
            lambda item, _former: self.show_page(item.data(Qt.ItemDataRole.UserRole))
        )
        self.pages.setCurrentRow(0)
        self.pages.setFocus()

    def show_page(self, path: Path) -> None:
        self.browser.setSource(
            QUrl.fromLocalFile(str(path)), QTextDocument.ResourceType.MarkdownResource
        )
        self.browser.document().setDocumentMargin(self._margin)

    def _open_link(self, link: QUrl) -> None:
        target = self.browser.source().resolved(link)
        if not target.isLocalFile():
            QDesktopServices.openUrl(target)
            return
        for row in range(self.pages.count()):
            if str(self.pages.item(row).data(Qt.ItemDataRole.UserRole)) == target.toLocalFile():
                self.pages.setCurrentRow(row)
                if target.fragment():
                    self.browser.scrollToAnchor(target.fragment())
                return
        if target.toLocalFile() == self.browser.source().toLocalFile():
            self.browser.scrollToAnchor(target.fragment())
            return
        path = Path(target.toLocalFile())
        if not path.exists():
            # An installation has the license beside the pages, not above them.
            path = Path(self.browser.source().toLocalFile()).with_name(path.name)
        if path.suffix in ("", ".md") and path.is_file():
            self.show_page(path)
