"""Is the aircraft trimmed, level and at its test point? The cue before an input."""
