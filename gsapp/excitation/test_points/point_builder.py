"""Test points from test cards: completed by the trim curve, or refused with what it says."""

from __future__ import annotations

from gsapp.excitation.test_points.point import TestPoint
from gsapp.excitation.test_points.trim_curve import TrimCurve
from gsapp.flight.cards import TestCard, Tolerance
from gsapp.foundation import FlightError
from gsapp.quantities import channel, from_si


class TestPointError(FlightError):
    """Nobody can fly there; the sentence says what can be flown."""

    __test__ = False  # the name is the field's; it is no test of ours


def create_test_point(
    card: TestCard,
    curve: TrimCurve | None,
    *,
    system: str = "US",
) -> TestPoint:
    """Return the test point of a card.

    Parameters
    ----------
    curve : TrimCurve or None
        For the card's flap; None where no model is known.
    system : {"US", "SI"}
        Units of the sentences.

    Raises
    ------
    TestPointError
        If the aircraft does not fly level at the card's speed, or at the card's angle of attack
        at that speed.
    """
    return create_point_at(
        speed=card.speed,
        alpha=card.alpha,
        curve=curve,
        tolerance=card.tolerance,
        card=card.id,
        height=card.height,
        flap=card.flap,
        system=system,
    )


create_test_point.__test__ = False  # type: ignore[attr-defined]


def create_point_at(
    *,
    speed: float | None = None,
    alpha: float | None = None,
    curve: TrimCurve | None,
    tolerance: Tolerance | None = None,
    card: str = "",
    height: float | None = None,
    flap: float = 0.0,
    system: str = "US",
) -> TestPoint:
    """Return a test point for a speed, an angle of attack, or a pair of them.

    Parameters
    ----------
    speed, alpha : float or None
        m/s and rad; one of them at least. At 1 g one fixes the other.
    tolerance : Tolerance, optional
        A card's usual one by default.
    card, height, flap
        As of `TestPoint`.
    system : {"US", "SI"}
        Units of the sentences.

    Raises
    ------
    TestPointError
        If neither is given, it cannot be flown, or the pair lies off the trim curve by more than
        the tolerance.
    """
    if speed is None and alpha is None:
        raise TestPointError("a test point needs a speed or an angle of attack; write one of them")
    room = tolerance or Tolerance()
    remarks: tuple[str, ...] = ()
    level = None
    if curve is None or curve.speed_range is None:
        why = curve.problem if curve is not None and curve.problem else "no model is known"
        unknown = "whether speed and angle of attack fit each other"
        if speed is None or alpha is None:
            unknown = f"the {'speed' if speed is None else 'angle of attack'} that belongs to it"
        remarks = (f"{unknown} cannot be determined: {why}",)
    else:
        aimed = speed
        if aimed is None and alpha is not None:
            aimed = curve.speed_at(alpha)
            if aimed is None:
                raise TestPointError(_no_such_alpha(alpha, curve, system))
        assert aimed is not None  # noqa: S101  one of the two was given
        level = curve.level_flight_at(aimed)
        if level is None:
            raise TestPointError(_no_such_speed(aimed, curve, system))
        if alpha is not None and abs(alpha - level.alpha) > room.alpha:
            told = _format_value(level.alpha, "alpha", system)
            raise TestPointError(
                f"at {_format_value(aimed, 'V', system)} it flies level at alpha {told}, not "
                f"{_format_value(alpha, 'alpha', system)}; write {told} or leave alpha out"
            )
        speed = aimed
        # A pair within tolerance is aimed at as written.
        alpha = level.alpha if alpha is None else alpha
    return TestPoint(
        card=card,
        speed=speed,
        alpha=alpha,
        speed_tolerance=room.speed,
        alpha_tolerance=room.alpha,
        height=height,
        flap=flap,
        throttle=None if level is None else level.throttle,
        elevator=None if level is None else level.elevator,
        density=None if curve is None else curve.rho,
        mass=None if curve is None else curve.mass,
        remarks=remarks,
    )


def _no_such_speed(speed: float, curve: TrimCurve, system: str) -> str:
    assert curve.speed_range is not None  # noqa: S101  asked before
    low, high = curve.speed_range
    slow = speed < low
    end = low if slow else high
    return (
        f"level flight at {_format_value(speed, 'V', system)} is not possible: the "
        f"{'slowest' if slow else 'fastest'} is {_format_value(end, 'V', system)}; write "
        f"{'more' if slow else 'less'}"
    )


def _no_such_alpha(alpha: float, curve: TrimCurve, system: str) -> str:
    assert curve.speed_range is not None  # noqa: S101  asked before
    most, least = (curve.alpha_at(speed) or 0.0 for speed in curve.speed_range)
    return (
        f"level flight at alpha {_format_value(alpha, 'alpha', system)} is not possible: it goes "
        "from "
        f"{_format_value(least, 'alpha', system)} at "
        f"{_format_value(curve.speed_range[1], 'V', system)} to "
        f"{_format_value(most, 'alpha', system)} at "
        f"{_format_value(curve.speed_range[0], 'V', system)}; write one in between"
    )


def _format_value(value: float, name: str, system: str) -> str:
    """Return a value in the user's units, with the digits that are of use in a sentence."""
    spec = channel(name)
    unit = spec.display_unit(system)
    text = f"{from_si(value, unit, spec.quantity):.1f}"
    return f"{text.removesuffix('.0')} {unit}"
