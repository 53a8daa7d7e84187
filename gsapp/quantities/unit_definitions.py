"""The units that files are written in, as pint reads definitions.

Pint's own list holds some thousand units, and reading it takes longer than all the rest of an
aircraft file. Those few that `gsapp.quantities.units` lets pass are defined here, by the same
international agreements; a test compares each with pint's own.
"""

from __future__ import annotations

from typing import Final

DEFINITIONS: Final = """
micro- = 1e-6 = u-
milli- = 1e-3 = m-
centi- = 1e-2 = c-
hecto- = 1e2 = h-
kilo- = 1e3 = k-
meter = [length] = m
second = [time] = s
gram = [mass] = g
ampere = [current] = A
kelvin = [temperature]; offset: 0 = K
radian = [] = rad
bit = []
percent = 0.01
pi = 3.141592653589793
degree = pi / 180 * radian = deg
revolution = 2 * pi * radian
byte = 8 * bit = B
minute = 60 * second = min
hour = 60 * minute = h
hertz = 1 / second = Hz
inch = 0.0254 * meter = in
foot = 12 * inch = ft
mile = 5280 * foot = mi
nautical_mile = 1852 * meter = nmi
liter = 1e-3 * meter ** 3 = l
US_liquid_gallon = 231 * inch ** 3
US_fluid_ounce = US_liquid_gallon / 128
knot = nautical_mile / hour
mile_per_hour = mile / hour = mph
standard_gravity = 9.80665 * meter / second ** 2
pound = 0.45359237 * kilogram = lb
ounce = pound / 16 = oz
newton = kilogram * meter / second ** 2 = N
joule = newton * meter
pound_force = pound * standard_gravity = lbf
kilogram_force = kilogram * standard_gravity
slug = pound_force * second ** 2 / foot
pascal = newton / meter ** 2 = Pa
millibar = 100 * pascal
psi = pound_force / inch ** 2
inch_H2O = inch * 1000 * kilogram / meter ** 3 * standard_gravity
inch_Hg = inch * 13595.1 * kilogram / meter ** 3 * standard_gravity
degree_Celsius = kelvin; offset: 273.15 = degC
degree_Fahrenheit = 5 / 9 * kelvin; offset: 233.15 + 200 / 9 = degF
coulomb = ampere * second = C
volt = joule / coulomb = V
"""
"""Prefixes, base units, and what is made of them, the made after what it is made of."""
