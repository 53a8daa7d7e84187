"""Tests; what several share is imported from here, as `tests.ui.window_kit`."""
