"""Texts of the window in the language of the system."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from gsapp.foundation.translation import QT_TR_NOOP

if TYPE_CHECKING:
    from PySide6.QtCore import QCoreApplication, QLocale, QTranslator

__all__ = ["QT_TR_NOOP", "install_translator", "tr"]

_FOLDER = Path(__file__).with_name("translations")
# The builders of the pilot's page and the workers know nothing of Qt: it is loaded with the
# translator, which only the window installs.
_translator: QTranslator | None = None


def tr(text: str) -> str:
    """Return a text of the window in its language; English where there is no translation."""
    return (_translator.translate("", text) or text) if _translator is not None else text


def install_translator(
    application: QCoreApplication, locale: QLocale | None = None, folder: Path = _FOLDER
) -> None:
    """Load the texts of the window, and with them those of Qt, in a language that has any."""
    global _translator  # noqa: PLW0603 - one language for the process
    from PySide6.QtCore import QLibraryInfo, QLocale, QTranslator

    locale = locale or QLocale()
    translator, of_qt = QTranslator(application), QTranslator(application)
    if translator.load(locale, "gsapp", "_", str(folder)):
        _translator = translator
        places = QLibraryInfo.path(QLibraryInfo.LibraryPath.TranslationsPath)
        if of_qt.load(locale, "qtbase", "_", places):
            application.installTranslator(of_qt)
