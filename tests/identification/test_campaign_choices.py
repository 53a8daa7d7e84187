"""What a crew chooses to free over a campaign of both axes."""

from dataclasses import replace

from gsapp.identification.campaign import CampaignSettings, run_campaign
from tests.identification.virtual_maneuvers import fly


def test_each_axis_frees_its_own_of_the_derivatives_named() -> None:
    """Names of both axes at once: a maneuver is never asked for the other axis."""
    flown = [replace(fly(1, kind).maneuver, id=kind) for kind in ("lon", "lat")]
    result = run_campaign(flown, CampaignSettings(free=("Cm_alpha", "Cm_de", "Cl_p", "Cl_da")))
    asked = {
        one.maneuver.id: {
            name for name, found in one.estimate.derivatives.items() if found.status != "held"
        }
        for one in result.results
        if one.estimate is not None
    }
    assert asked == {"lon": {"Cm_alpha", "Cm_de"}, "lat": {"Cl_p", "Cl_da"}}
