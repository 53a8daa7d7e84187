"""Derivatives while a flight happens: FTR as it listens, and fits of its maneuvers."""
