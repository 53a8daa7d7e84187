"""Changes of maneuvers applied to a list that was found otherwise than when they were made.

The detection may have become better, or the record, and count otherwise. So a change says where
the maneuvers lay that it takes out, and they are looked for there, whatever they are called now.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import Final

from gsapp.flight.maneuvers.detected_maneuver import DetectedManeuver
from gsapp.flight.maneuvers.maneuver_list import EditableManeuverList, ManeuverEdit
from gsapp.foundation import UnknownNameError

_SAME_SHARE: Final = 0.5
"""Share of the shorter of two stretches that both hold if they are the same maneuver."""


def localize_edit(book: EditableManeuverList, edit: ManeuverEdit) -> ManeuverEdit:
    """Return a change with the ids that its maneuvers have in a book.

    One that is not found any more stays as it was put in; there is nothing to take out then.
    `ManeuverEdit.remark` tells what is otherwise.

    Raises
    ------
    UnknownNameError
        If a change before it has taken the maneuver out.
    """
    if len(edit.segments) != len(edit.removed):
        return edit
    standing = {maneuver.id: maneuver for maneuver in book.maneuvers}
    known = (*book.detected, *(one for former in book.edits for one in former.added))
    names: dict[str, str] = {}
    stretches: list[tuple[float, float]] = []
    remarks: list[str] = []
    for name, stretch in zip(edit.removed, edit.segments, strict=True):
        now = _overlapping_maneuver_id(standing.values(), name, stretch)
        if now is not None:
            names[name] = now
            stretches.append(stretch)
            del standing[now]
        elif _overlapping_maneuver_id(known, name, stretch) is not None:
            raise UnknownNameError(
                f"'{edit.text}' changes the maneuver '{name}', which is not there any more"
            )
        else:
            remarks.append(
                f"maneuver {name} at {stretch[0]:.1f} s, changed by hand ('{edit.text}'), is not "
                f"found any more{'; it stands as it was changed' if edit.added else ''}"
            )
    added = []
    for maneuver in edit.added:
        wanted = names.get(maneuver.id, maneuver.id)
        called = wanted if wanted not in standing else book.unused_id(standing)
        if called != maneuver.id:
            remarks.append(
                f"maneuver {maneuver.id} at {maneuver.t_start:.1f} s, changed by hand "
                f"('{edit.text}'), is now called {called}: the flight's maneuvers are found "
                "otherwise than then"
            )
        standing[called] = maneuver
        added.append(replace(maneuver, id=called))
    return replace(
        edit,
        removed=tuple(names.values()),
        segments=tuple(stretches),
        added=tuple(added),
        remark="; ".join(remarks),
    )


def _overlapping_maneuver_id(
    maneuvers: Iterable[DetectedManeuver], name: str, stretch: tuple[float, float]
) -> str | None:
    """Return the id of the maneuver that lies at a stretch; the one of that name before others."""
    best, most = None, -math.inf
    for one in maneuvers:
        common = min(one.t_end, stretch[1]) - max(one.t_start, stretch[0])
        lengths = (one.t_end - one.t_start, stretch[1] - stretch[0])
        if common < _SAME_SHARE * min(lengths):
            continue
        if one.id == name:
            return name
        if common / max(lengths) > most:
            best, most = one.id, common / max(lengths)
    return best
