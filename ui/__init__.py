"""The ground station window: views and view models (PySide6, pyqtgraph)."""
