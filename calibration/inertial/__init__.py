"""Gyros and accelerometers: zeros, scales, misalignment, and the factory's figures."""
