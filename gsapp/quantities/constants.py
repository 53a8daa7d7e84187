"""Numbers that hold everywhere: standard gravity, size of the Earth, customary units in SI.

For values written in the code; what is read from files goes through `gsapp.quantities.units`.
"""

from __future__ import annotations

from typing import Final

GRAVITY: Final = 9.80665
"""Standard acceleration of free fall, m/s^2; one g."""
DEGREE: Final = 0.017453292519943295
"""rad."""
FOOT: Final = 0.3048
"""m."""
MAD_TO_STD: Final = 1.4826
"""Standard deviation over median absolute deviation of a normal distribution."""
EARTH_RADIUS: Final = 6_371_000.0
"""Mean radius of the Earth, m."""
