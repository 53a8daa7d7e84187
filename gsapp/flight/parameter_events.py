"""Parameters of the vehicle as events: all at first, then each that changes."""

from __future__ import annotations

from collections.abc import Iterable

from gsapp.flight.events import Event


def parameter_events(values: Iterable[tuple[float | None, str, float]]) -> tuple[Event, ...]:
    """Return the events of parameters: time (s), name and value, in the order of the record.

    One event ``parameters`` has in its data what each was at first; an event ``parameter`` follows
    for each change.
    """
    first: dict[str, float] = {}
    now: dict[str, float] = {}
    begun: float | None = None
    changes = []
    for time, name, value in values:
        if name not in first:
            begun = time if not first else begun
            first[name] = now[name] = value
        elif value != now[name]:
            text = f"{name} = {value:.7g} (was {now[name]:.7g})"
            data = {"name": name, "value": value}
            changes.append(Event(kind="parameter", text=text, time=time, data=data))
            now[name] = value
    if not first:
        return ()
    text = f"{len(first)} parameters"
    return (Event(kind="parameters", text=text, time=begun, data=first), *changes)
