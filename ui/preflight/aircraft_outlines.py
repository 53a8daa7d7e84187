"""Outlines of the model airliner from the side and from above. Plain numbers, no Qt.

Units are arbitrary: from the side x runs aft and y down, nose to the left; from above x runs to
the right wing and y aft, nose up.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

ViewDirection = Literal["side", "above"]
OutlinePoints = tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class MovingPart:
    """What moves, as seen in one view.

    Attributes
    ----------
    outline : tuple of (float, float)
        Closed.
    hinge : tuple of float
        Where it turns, and where its ring is drawn.
    rotation_visible : bool
        Whether its turning can be seen in this view.
    """

    outline: OutlinePoints
    hinge: tuple[float, float]
    rotation_visible: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class AircraftOutline:
    """The aircraft in one view.

    Attributes
    ----------
    size : tuple of float
        Width and height of the box around it.
    shapes : tuple
        Closed outlines of what does not move, painted in this order.
    parts : mapping of str to MovingPart
        What moves, by channel.
    """

    size: tuple[float, float]
    shapes: tuple[OutlinePoints, ...]
    parts: Mapping[str, MovingPart]


def _mirrored(points: OutlinePoints, about: float) -> OutlinePoints:
    return tuple((2 * about - x, y) for x, y in points)


_ELEVATOR: OutlinePoints = ((96, 18.2), (96, 20.6), (104.5, 19.6))
_AILERON: OutlinePoints = ((58.5, 27), (58.5, 29.4), (65.5, 28.6))
_RUDDER: OutlinePoints = ((96.2, 2.5), (100.6, 3.2), (100.6, 16.6), (94.6, 16.6))

SIDE_OUTLINE = AircraftOutline(
    size=(108.0, 40.0),
    shapes=(
        # Fuselage.
        (
            (7, 22.5), (8, 20.5), (11, 18.4), (16, 16.8), (22, 16.2), (78, 16.2), (92, 17),
            (100, 18.6), (100, 20), (90, 22.6), (76, 27), (68, 28.4), (20, 28.4), (12, 27.2),
            (8, 24.8),
        ),
        # Fin.
        ((78, 16.2), (90, 1.6), (96.2, 1.6), (94.6, 16.8)),
        # Tailplane and wing, as sections.
        ((84, 19.6), (86, 18.4), (96, 18.2), (96, 20.6), (86, 20.4)),
        ((38, 28.6), (41, 26.6), (50, 26), (58.5, 27), (58.5, 29.4), (42, 30.2)),
        # Engine.
        ((33, 30.6), (35, 29.8), (46, 30.2), (50, 31.6), (50, 34.6), (46, 36.2), (35, 36.6),
         (33, 35.6)),
        # Boom of the vanes.
        ((0.4, 22.2), (7.4, 22.2), (7.4, 23.2), (0.4, 23.2)),
    ),
    parts=MappingProxyType(
        {
            "elevator_left": MovingPart(outline=_ELEVATOR, hinge=(96, 19.4)),
            "elevator_right": MovingPart(outline=_ELEVATOR, hinge=(96, 19.4)),
            "aileron_left": MovingPart(outline=_AILERON, hinge=(58.5, 28.2)),
            "aileron_right": MovingPart(outline=_AILERON, hinge=(58.5, 28.2)),
            "rudder": MovingPart(outline=_RUDDER, hinge=(95.4, 9.5), rotation_visible=False),
            "alpha": MovingPart(outline=((2, 21.9), (2, 23.5), (7.6, 23.2), (7.6, 22.2)),
                          hinge=(2, 22.7)),
        }
    ),
)  # fmt: skip
"""Nose to the left, seen from its left."""

_WING: OutlinePoints = ((46, 34), (4, 57), (2.6, 60.5), (4, 62.5), (26, 56.2), (46, 54))
_TAILPLANE: OutlinePoints = ((47.4, 82), (33, 91), (32, 93.2), (33, 94.4), (48.6, 92))
_ENGINE: OutlinePoints = ((30.4, 37), (34.2, 36.6), (35, 38), (34.6, 46), (30.8, 47), (29.8, 38.4))
_AILERON_TOP: OutlinePoints = ((4.2, 60.4), (22.4, 54.6), (22.8, 57.2), (4.2, 62.6))
_ELEVATOR_TOP: OutlinePoints = ((33, 92.4), (47.6, 89.6), (48, 92.6), (33, 95))

TOP_OUTLINE = AircraftOutline(
    size=(100.0, 106.0),
    shapes=(
        _WING,
        _mirrored(_WING, 50),
        _TAILPLANE,
        _mirrored(_TAILPLANE, 50),
        _ENGINE,
        _mirrored(_ENGINE, 50),
        (
            (50, 7), (52, 8.2), (54, 12), (54.8, 18), (54.8, 70), (53.6, 84), (51.4, 97), (50, 99),
            (48.6, 97), (46.4, 84), (45.2, 70), (45.2, 18), (46, 12), (48, 8.2),
        ),
        ((49.4, 80), (50, 78.6), (50.6, 80), (50.8, 95), (49.2, 95)),
        ((49.6, 0.6), (50.4, 0.6), (50.4, 7.4), (49.6, 7.4)),
    ),
    parts=MappingProxyType(
        {
            "elevator_left": MovingPart(outline=_ELEVATOR_TOP, hinge=(41, 92),
            rotation_visible=False),
            "elevator_right": MovingPart(
                outline=_mirrored(_ELEVATOR_TOP, 50), hinge=(59, 92), rotation_visible=False
            ),
            "aileron_left": MovingPart(outline=_AILERON_TOP, hinge=(13, 58.5),
            rotation_visible=False),
            "aileron_right": MovingPart(
                outline=_mirrored(_AILERON_TOP, 50), hinge=(87, 58.5), rotation_visible=False
            ),
            "rudder": MovingPart(outline=((49.1, 95), (50.9, 95), (50.2, 104.5), (49.8, 104.5)),
                           hinge=(50, 95)),
            "beta": MovingPart(outline=((49.2, 2), (50.8, 2), (50.5, 8.4), (49.5, 8.4)),
            hinge=(50, 2)),
        }
    ),
)  # fmt: skip
"""Nose up, seen from above: the left wing is on the left."""

OUTLINES_BY_VIEW: Mapping[ViewDirection, AircraftOutline] = MappingProxyType(
    {"side": SIDE_OUTLINE, "above": TOP_OUTLINE}
)

_WING_REAR: OutlinePoints = ((54, 53), (96, 46), (97.5, 44.5), (97.5, 46.5), (54, 57))
_TAILPLANE_REAR: OutlinePoints = ((52, 45), (67, 42.6), (67.4, 43.6), (52, 47.4))

REAR_OUTLINE = AircraftOutline(
    size=(100.0, 80.0),
    shapes=(
        _WING_REAR,
        _mirrored(_WING_REAR, 50),
        ((69, 56), (72, 54.6), (75, 56), (75.6, 59), (74, 62), (70, 62), (68.4, 59)),
        ((31, 56), (28, 54.6), (25, 56), (24.4, 59), (26, 62), (30, 62), (31.6, 59)),
        ((49.2, 44), (49.6, 25), (50.4, 25), (50.8, 44)),
        ((50, 43), (54, 44.2), (56.6, 48), (56.6, 52), (54, 56), (50, 57.4), (46, 56), (43.4, 52),
         (43.4, 48), (46, 44.2)),
        _TAILPLANE_REAR,
        _mirrored(_TAILPLANE_REAR, 50),
    ),
    parts=MappingProxyType({}),
)  # fmt: skip
"""Seen from behind: the right wing is on the right."""
