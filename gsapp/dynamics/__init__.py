"""Equations of motion, aerodynamic model and effect terms, propulsion, sensors, simulation."""
