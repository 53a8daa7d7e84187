"""Whether the calibration counts for a flight: judged here once, for every place that shows it."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from typing import Final, Literal

from calibration.certificate import Certificate
from gsapp.foundation.name_suggestions import format_names
from gsapp.quantities import CHANNELS, base_id, channel

VALIDITY_PERIOD: Final = timedelta(hours=18)
"""Surfaces and vanes are calibrated on every day of flying."""
SHIPPED_EXAMPLE: Final = "shipped example"
"""Signs certificates that come with the program: of no real instrument, and on no real day."""

_DAILY: Final = frozenset({"Surfaces", "Flow"})
"""Groups of the channels whose linkages and vanes are bent in transport."""
_CLOCKS_DIFFER: Final = timedelta(hours=25)
"""By how much certificates, which hold local time, may be ahead of a traveler's clock."""
_MOST_NAMED: Final = 4
_ORDER: Final = {name: at for at, name in enumerate(CHANNELS)}


@dataclass(frozen=True, slots=True, kw_only=True)
class CalibrationStatus:
    """How the calibration stands."""

    state: Literal["good", "caution", "warning", "unknown"]
    """``unknown`` where nothing is calibrated here: the aircraft sends engineering units."""
    summary: str
    """A few words, for a tile."""
    detail: str
    """A sentence without its full stop."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CalibrationInForce:
    """The certificates in force, and what else decides whether they count."""

    certificates: Mapping[str, Certificate]
    flight_date: datetime | None
    """When the flight takes place; None where that is not known, so that nothing is out of date."""
    missing: Collection[str] = ()
    """Channels that need a certificate and have none."""
    failed_checks: Mapping[str, datetime] = field(default_factory=dict)
    """Channels whose last check failed, with the stamp of the certificate that was checked."""

    def evaluate(
        self, names: Iterable[str] | None = None, valid_for: timedelta | None = None
    ) -> CalibrationStatus:
        """Judge the certificates.

        Parameters
        ----------
        names : iterable of str, optional
            Channels to judge; all by default.
        valid_for : timedelta, optional
            Age at which each certificate of `names` is out of date. By default those of surfaces
            and vanes are after `VALIDITY_PERIOD`, the others never.
        """
        every = (*self.certificates, *self.missing) if names is None else tuple(names)
        chosen = sorted(set(every), key=lambda name: (_ORDER[base_id(name)], name))
        if lacking := [name for name in chosen if name in self.missing]:
            return _warning(f"{len(lacking)} uncalibrated", "Not calibrated", lacking)
        held = {name: self._stamp(name) for name in chosen if name in self.certificates}
        if not held:
            text = "No certificate in force: the aircraft sends engineering units"
            return CalibrationStatus(state="unknown", summary="none", detail=text)
        if moved := [
            name for name in held if self.failed_checks.get(name) == self.certificates[name].stamp
        ]:
            return _warning(f"{len(moved)} moved", "Moved since calibration (check)", moved)
        aging = {
            name: at
            for name, at in held.items()
            if valid_for is not None or is_calibrated_daily(name)
        }
        return self._aged(held, aging, valid_for or VALIDITY_PERIOD)

    def _aged(
        self, held: Mapping[str, datetime], aging: Mapping[str, datetime], valid_for: timedelta
    ) -> CalibrationStatus:
        on = None if self.flight_date is None else self.flight_date.astimezone()
        if on is not None and (ahead := [at for at in held.values() if at - on > _CLOCKS_DIFFER]):
            return CalibrationStatus(
                state="caution",
                summary="clock?",
                detail=f"A certificate is dated {_date(max(ahead))}, after {_date(on)}: set the "
                "clock of this computer",
            )
        if examples := [name for name in aging if self.certificates[name].who == SHIPPED_EXAMPLE]:
            return CalibrationStatus(
                state="caution",
                summary="example values",
                detail=f"Example values, not of this aircraft: {_titles(examples)}",
            )
        oldest = min(aging, key=aging.__getitem__, default="")
        if on is None or not oldest:
            return CalibrationStatus(
                state="good", summary="in force", detail=f"{_count(held)} in force"
            )
        day = day_text(aging[oldest], on)
        if on - aging[oldest] > valid_for:
            old = [name for name, at in aging.items() if on - at > valid_for]
            since = f"{_titles(old)}: last calibrated {day}"
            return CalibrationStatus(state="caution", summary=f"from {day}", detail=since)
        return CalibrationStatus(
            state="good",
            summary=f"{len(aging)} of {len(aging)} {day}",
            detail=f"{_count(held)} in force, the oldest of {day} {aging[oldest]:%H:%M} "
            f"({_titles([oldest])})",
        )

    def _stamp(self, name: str) -> datetime:
        # Certificates written by hand give the field's time without its zone.
        return self.certificates[name].stamp.astimezone()


def is_calibrated_daily(channel_id: str) -> bool:
    """Return whether an instrument is calibrated on every day of flying."""
    return channel(channel_id).group in _DAILY


def day_text(stamp: datetime, now: datetime) -> str:
    """Return the day of a stamp: ``today``, ``yesterday``, ``12 May``, ``12 May 2003``."""
    days = (now.date() - stamp.date()).days
    if days in (0, 1):
        return "yesterday" if days else "today"
    return f"{stamp.day} {stamp:%B}" if stamp.year == now.year else _date(stamp)


def _date(stamp: datetime) -> str:
    return f"{stamp.day} {stamp:%b} {stamp.year}"


def _count(held: Collection[str]) -> str:
    return f"{len(held)} certificate{'' if len(held) == 1 else 's'}"


def _titles(names: Collection[str]) -> str:
    titles = [channel(name).title for name in names]
    return format_names(titles, _MOST_NAMED) if len(titles) > _MOST_NAMED else ", ".join(titles)


def _warning(text: str, what: str, names: Collection[str]) -> CalibrationStatus:
    return CalibrationStatus(state="warning", summary=text, detail=f"{what}: {_titles(names)}")
