"""What the debrief prints of an input."""

from math import radians
from types import SimpleNamespace

from gsapp.cli.debrief import _sizes


def test_an_input_stands_beside_its_target_and_the_band_that_is_good() -> None:
    band = SimpleNamespace(low=radians(1.5), best=radians(9.3), high=radians(15.5))
    judged = SimpleNamespace(
        verdict=SimpleNamespace(amplitudes={"dr": radians(14.6), "da": radians(2.0)}),
        target_input=SimpleNamespace(amplitudes={"dr": band}),
    )
    assert _sizes(judged) == "rudder 14.6 deg (target 9.3, 1.5 to 15.5), aileron 2.0 deg"
