"""Texts of the core that the window shows in its own language."""

from __future__ import annotations


def QT_TR_NOOP(text: str) -> str:  # noqa: N802 - as Qt names it
    """Mark a text of a table for ``pyside6-lupdate``; `ui.translation.tr` translates it."""
    return text
