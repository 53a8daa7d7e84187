"""The place Review: maneuvers corrected, derivatives estimated, figures, summary, report."""
