"""Proof, short: errors of maximum likelihood are as large as the bounds say.

40 virtual maneuvers with known derivatives. `tests/bench/truth.py` flies 220 of each kind: there
the scatter of the rms itself (5 %) allows to ask for 0.8 to 1.3, derivative by derivative.
"""

import numpy as np
import pytest

from gsapp.identification.maximum_likelihood import MLSettings, fit
from tests.identification.virtual_maneuvers import AXES, fly

COUNT = 20


@pytest.mark.parametrize(("kind", "color"), [("lon", 0.9), ("lat", 0.0)])
def test_errors_are_as_large_as_the_bounds(kind: str, color: float) -> None:
    """Of all derivatives together within 0.8 to 1.3; each within what 20 maneuvers can show."""
    honest: dict[str, list[float]] = {}
    plain: dict[str, list[float]] = {}
    for seed in range(300, 300 + COUNT):
        virtual = fly(seed, kind, color=color)
        estimate = fit([virtual.maneuver], MLSettings(axis=AXES[kind])).estimate
        assert estimate.converged
        for name, true in virtual.truth.items():
            one = estimate.derivatives[name]
            assert one.status == "estimated"
            error = (one.value or 0.0) - true
            honest.setdefault(name, []).append(error / (one.std or 0.0))
            plain.setdefault(name, []).append(error / (one.cramer_rao or 0.0))
    rms = {name: float(np.sqrt(np.mean(np.square(x)))) for name, x in honest.items()}
    together = float(np.sqrt(np.mean(np.square(list(honest.values())))))
    assert 0.8 < together < 1.3
    # The rms of 20 normal numbers scatters by 0.16.
    assert all(0.5 < value < 1.7 for value in rms.values()), rms
    if color:
        # Uncorrected bounds are three times too small, and more.
        assert np.sqrt(np.mean(np.square(list(plain.values())))) > 2.5
