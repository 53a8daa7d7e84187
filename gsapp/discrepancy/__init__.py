"""Where simulation and flight disagree: find the gap, name the effect, add it, show it shrink."""
