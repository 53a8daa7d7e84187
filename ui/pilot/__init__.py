"""The place Pilot: cues to be read from three meters, the debrief, and training with keys."""
