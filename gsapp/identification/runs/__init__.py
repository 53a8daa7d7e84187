"""Estimations as a crew asks for them: what to estimate from, what came out, and the same again."""
