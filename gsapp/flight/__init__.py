"""Flight folder, import and export, cut and merge, maneuver detection, catalog."""
