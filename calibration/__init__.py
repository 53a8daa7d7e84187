"""Volts to engineering units: points, fits, hysteresis, certificates."""
