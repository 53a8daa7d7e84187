"""The place Model gap: find the disagreement, name the effect, add it, show the gap shrink."""
