"""A campaign, maneuver by maneuver."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from gsapp.foundation import FlightError, GroundStationError
from gsapp.identification.axes import AXIS_SURFACES, Axis, axis_of
from gsapp.identification.campaign.maneuver_fit import fit_maneuver, fit_maneuvers_jointly
from gsapp.identification.campaign.results import (
    CampaignResult,
    CampaignValue,
    ManeuverResult,
    campaign_values,
)
from gsapp.identification.campaign.settings import CampaignSettings
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.missing_channels import (
    AssumedConstant,
    campaign_assumed_constants,
    required_constants,
)
from gsapp.identification.moment_reference import NO_CG_SHIFT
from gsapp.identification.results import Estimate
from gsapp.identification.stuck_channels import unmeasured_surfaces

CampaignProgressCallback = Callable[[int, int, str], bool | None]
"""Called with fits done, fits in all, and what is next; returning False stops."""


class CanceledError(GroundStationError):
    """The user stopped a campaign."""


def run_campaign(
    maneuvers: Sequence[Maneuver],
    settings: CampaignSettings,
    *,
    progress: CampaignProgressCallback | None = None,
) -> CampaignResult:
    """Estimate from every maneuver.

    `maneuvers`: of one or several flights.

    Raises
    ------
    FlightError
        If there is no maneuver of the axis asked for.
    CanceledError
        If `progress` returned False.
    """
    jobs = [(one, _axis_to_fit(one, settings)) for one in maneuvers]
    chosen = [(one, axis) for one, axis in jobs if axis is not None]
    remarks = [
        f"maneuver {one.id} moved {' and '.join(one.inputs) or 'nothing'} and is excluded from "
        f"axis {settings.axis}"
        + "".join(f": {words}" for words in _unmeasured_surfaces_text(one, settings.axis))
        for one, axis in jobs
        if axis is None
    ]
    # Each sentence once, though all maneuvers of a flight share it.
    remarks += dict.fromkeys(
        f"{one.flight}: {sentence}" for one, _ in chosen for sentence in one.remarks
    )
    if any(one.cg_shift != NO_CG_SHIFT for one, _ in chosen):
        remarks.append("moment derivatives are given about the aircraft file's CG")
    if not chosen:
        what = "" if settings.axis == "both" else f" for axis {settings.axis}"
        why = "".join(f"; {remark}" for remark in remarks)
        raise FlightError(
            f"no maneuver to estimate from{what}{why}; give one by start and stop, or see "
            "'gsapp maneuvers'"
        )
    groups = _group_by_axis(chosen) if settings.joint else []
    total, done = len(chosen) + len(groups), 0
    found: dict[int, ManeuverResult] = {}
    means: Mapping[str, CampaignValue] = {}
    known = campaign_assumed_constants([one for one, _ in chosen])
    rounds = [_fitting_order(one, settings, known) for one, _ in chosen]
    for now in sorted(set(rounds)):
        for place, (one, axis) in enumerate(chosen):
            if rounds[place] != now:
                continue
            _report_progress(progress, done, total, f"maneuver {one.id}")
            found[place] = fit_maneuver(one, axis, settings, means, known)
            done += 1
        means = campaign_values([result.estimate for result in found.values()])
    joint: list[Estimate] = []
    for axis, together in groups:
        _report_progress(progress, done, total, f"{len(together)} maneuvers jointly")
        try:
            joint.append(fit_maneuvers_jointly(together, axis, settings, means, known))
        except FlightError as error:
            remarks.append(f"the joint fit failed: {error}")
        done += 1
    _report_progress(progress, done, total, "")
    return CampaignResult(
        settings=settings,
        results=tuple(found[place] for place in range(len(chosen))),
        values=means,
        joint=tuple(joint),
        remarks=tuple(remarks),
    )


def _report_progress(
    progress: CampaignProgressCallback | None, done: int, total: int, what: str
) -> None:
    if progress is not None and progress(done, total, what) is False:
        raise CanceledError("stopped; nothing was written")


def _axis_to_fit(maneuver: Maneuver, settings: CampaignSettings) -> Axis | None:
    """Return the axis to fit a maneuver in; None to leave it out."""
    if settings.six_degrees:
        return "both"
    if settings.axis == "both" or not maneuver.inputs:
        # Nothing moved: the axis asked for says why nothing can be earned.
        return axis_of(maneuver.inputs) if maneuver.inputs else settings.axis
    moved = not set(AXIS_SURFACES[settings.axis]).isdisjoint(maneuver.inputs)
    return settings.axis if moved else None


def _unmeasured_surfaces_text(maneuver: Maneuver, axis: Axis) -> tuple[str, ...]:
    return tuple(words for _, words in unmeasured_surfaces(maneuver, axis))


def _fitting_order(
    maneuver: Maneuver, settings: CampaignSettings, known: Mapping[str, AssumedConstant]
) -> tuple[int, bool]:
    """Return when a maneuver's turn is: what others know already helps it."""
    lacks = bool(required_constants((maneuver,), known, settings.stand_ins))
    return -len(maneuver.inputs), lacks


def _group_by_axis(
    chosen: Sequence[tuple[Maneuver, Axis]],
) -> list[tuple[Axis, tuple[Maneuver, ...]]]:
    axes = dict.fromkeys(axis for _, axis in chosen)
    return [(axis, tuple(one for one, own in chosen if own == axis)) for axis in axes]
