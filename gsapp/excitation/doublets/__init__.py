"""Inputs recognized while they happen, and the verdict on each."""
