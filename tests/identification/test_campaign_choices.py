"""What a crew chooses to free over a campaign of both axes."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from virtual_maneuvers import fly

from gsapp.identification.campaign import CampaignSettings, run_campaign


def test_each_axis_frees_its_own_of_the_derivatives_named() -> None:
    """Names of both axes at once: a maneuver never fits derivatives of the other axis."""
    flown = [replace(fly(1, kind).maneuver, id=kind) for kind in ("lon", "lat")]
    result = run_campaign(flown, CampaignSettings(free=("Cm_alpha", "Cm_de", "Cl_p", "Cl_da")))
    free = {
        one.maneuver.id: set(one.estimate.free)
        for one in result.results
        if one.estimate is not None
    }
    assert free == {"lon": {"Cm_alpha", "Cm_de"}, "lat": {"Cl_p", "Cl_da"}}
