"""A campaign, maneuver by maneuver."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from gsapp.foundation import FlightError, GroundStationError
from gsapp.identification.axes import SURFACES, Axis, axis_of
from gsapp.identification.campaign.fitting import fit_maneuver, fit_together
from gsapp.identification.campaign.results import (
    CampaignResult,
    CampaignValue,
    ManeuverResult,
    campaign_values,
)
from gsapp.identification.campaign.settings import CampaignSettings
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.moment_reference import HERE
from gsapp.identification.results import Estimate
from gsapp.identification.stand_ins import StandIn, campaign_stand_ins, lacking
from gsapp.identification.stuck import unseen_surfaces

Step = Callable[[int, int, str], bool | None]
"""Called with fits done, fits in all, and what is next; returning False stops."""


class CanceledError(GroundStationError):
    """The user stopped a campaign."""


def run_campaign(
    maneuvers: Sequence[Maneuver], settings: CampaignSettings, *, progress: Step | None = None
) -> CampaignResult:
    """Estimate from every maneuver.

    Parameters
    ----------
    maneuvers : sequence of Maneuver
        Of one or several flights.
    settings : CampaignSettings
    progress : callable, optional

    Raises
    ------
    FlightError
        If there is no maneuver of the axis asked for.
    CanceledError
        If `progress` returned False.
    """
    jobs = [(one, _axis(one, settings)) for one in maneuvers]
    chosen = [(one, axis) for one, axis in jobs if axis is not None]
    remarks = [
        f"maneuver {one.id} moved {' and '.join(one.inputs) or 'nothing'} and is left out of "
        f"axis {settings.axis}" + "".join(f": {words}" for words in _unseen(one, settings.axis))
        for one, axis in jobs
        if axis is None
    ]
    # Each sentence once, though all maneuvers of a flight share it.
    remarks += dict.fromkeys(
        f"{one.flight}: {sentence}" for one, _ in chosen for sentence in one.remarks
    )
    if any(one.cg_shift != HERE for one, _ in chosen):
        remarks.append("moment derivatives are given about the aircraft file's CG")
    if not chosen:
        what = "" if settings.axis == "both" else f" for axis {settings.axis}"
        why = "".join(f"; {remark}" for remark in remarks)
        raise FlightError(
            f"there is no maneuver to estimate from{what}{why}; name one with its start and stop, "
            "or see what 'gsapp maneuvers' finds"
        )
    groups = _groups(chosen) if settings.joint else []
    total, done = len(chosen) + len(groups), 0
    found: dict[int, ManeuverResult] = {}
    means: Mapping[str, CampaignValue] = {}
    known = campaign_stand_ins([one for one, _ in chosen])
    rounds = [_round(one, settings, known) for one, _ in chosen]
    for now in sorted(set(rounds)):
        for place, (one, axis) in enumerate(chosen):
            if rounds[place] != now:
                continue
            _tell(progress, done, total, f"maneuver {one.id}")
            found[place] = fit_maneuver(one, axis, settings, means, known)
            done += 1
        means = campaign_values([result.estimate for result in found.values()])
    joint: list[Estimate] = []
    for axis, together in groups:
        _tell(progress, done, total, f"{len(together)} maneuvers together")
        try:
            joint.append(fit_together(together, axis, settings, means, known))
        except FlightError as error:
            remarks.append(f"the joint fit failed: {error}")
        done += 1
    _tell(progress, done, total, "")
    return CampaignResult(
        settings=settings,
        results=tuple(found[place] for place in range(len(chosen))),
        values=means,
        joint=tuple(joint),
        remarks=tuple(remarks),
    )


def _tell(progress: Step | None, done: int, total: int, what: str) -> None:
    if progress is not None and progress(done, total, what) is False:
        raise CanceledError("stopped; nothing was written")


def _axis(maneuver: Maneuver, settings: CampaignSettings) -> Axis | None:
    """Return the axis to fit a maneuver in; None to leave it out."""
    if settings.six_degrees:
        return "both"
    if settings.axis == "both" or not maneuver.inputs:
        # Nothing moved: the axis asked for says why nothing can be earned.
        return axis_of(maneuver.inputs) if maneuver.inputs else settings.axis
    moved = not set(SURFACES[settings.axis]).isdisjoint(maneuver.inputs)
    return settings.axis if moved else None


def _unseen(maneuver: Maneuver, axis: Axis) -> tuple[str, ...]:
    """Return the surfaces of an axis that nobody saw move, in words."""
    return tuple(words for _, words in unseen_surfaces(maneuver, axis))


def _round(
    maneuver: Maneuver, settings: CampaignSettings, known: Mapping[str, StandIn]
) -> tuple[int, bool]:
    """Return when a maneuver's turn is: what others know already helps it."""
    lacks = bool(lacking((maneuver,), known, settings.likelihood.stand_ins))
    return -len(maneuver.inputs), lacks


def _groups(
    chosen: Sequence[tuple[Maneuver, Axis]],
) -> list[tuple[Axis, tuple[Maneuver, ...]]]:
    axes = dict.fromkeys(axis for _, axis in chosen)
    return [(axis, tuple(one for one, own in chosen if own == axis)) for axis in axes]
