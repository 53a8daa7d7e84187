"""Verdicts given in flight, and how the test cards were flown, in a catalog.

A verdict is no second grade. The grade says what a maneuver is worth to a fit, and may be changed
by a person; the verdict is what the pilot was told. Both are shown side by side.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Final

from gsapp.flight.catalog.entries import store_flight
from gsapp.flight.catalog.records import CardScore, StoredVerdict
from gsapp.flight.catalog.store import Catalog, insert_row, select_where
from gsapp.flight.flight import Flight
from gsapp.foundation import FlightError

_VERDICT_COLUMNS: Final = ("name", "t_input", "t_end", "kind", "V", "result", "advice", "card")


def store_debrief(
    catalog: Catalog,
    flight: Flight,
    verdicts: Sequence[StoredVerdict],
    scores: Sequence[CardScore] = (),
    *,
    aircraft: str = "",
) -> None:
    """Store all that was said of a flight's inputs, in place of what was stored before."""
    number = store_flight(catalog, flight, aircraft=aircraft)
    with catalog.transaction() as connection:
        connection.execute("DELETE FROM verdicts WHERE flight = ?", (number,))
        connection.execute("DELETE FROM scores WHERE flight = ?", (number,))
        for one in verdicts:
            values = {
                "flight": number,
                **{name: getattr(one, name) for name in _VERDICT_COLUMNS},
                "surfaces": "+".join(one.surfaces),
                "counts": one.is_counted,
                "record": _json(one),
            }
            insert_row(connection, "verdicts", values)
        connection.executemany(
            """INSERT INTO scores (flight, card, place, heading, good, flown, wanted)
            VALUES (?, ?, ?, ?, ?, ?, ?)""",
            [
                (number, one.card, index, one.title, one.good, one.flown, one.requested)
                for index, one in enumerate(scores)
            ],
        )


def search_verdicts(
    catalog: Catalog,
    *,
    flight: str | None = None,
    result: str | None = None,
    card: str | None = None,
) -> tuple[StoredVerdict, ...]:
    """Return the verdicts that fit, by date of the flight and time."""
    wanted, values = select_where(
        {"f.name = ?": flight, "v.result = ?": result, "v.card = ?": card}
    )
    rows = catalog.query(
        f"""SELECT v.*, f.name AS flight_name, m.name AS maneuver, g.grade, g.given_by
        FROM verdicts v JOIN flights f ON f.id = v.flight
        LEFT JOIN maneuvers m ON m.id = (SELECT id FROM maneuvers WHERE flight = v.flight
            AND stands = 1 AND t_start <= v.t_input AND v.t_input < t_end
            ORDER BY t_start DESC LIMIT 1)
        LEFT JOIN grades g ON g.id = (SELECT max(id) FROM grades WHERE maneuver = m.id)
        WHERE {wanted}
        ORDER BY f.date IS NULL, f.date, f.name, v.t_input""",  # noqa: S608 - own clauses
        values,
    )
    return tuple(
        StoredVerdict(
            flight=row["flight_name"],
            **{name: row[name] for name in _VERDICT_COLUMNS},
            surfaces=tuple(row["surfaces"].split("+")),
            is_counted=bool(row["counts"]),
            record=_parsed(catalog, row["record"]),
            maneuver=row["maneuver"] or "",
            grade=row["grade"] or "",
            graded_by=row["given_by"] or "",
        )
        for row in rows
    )


def list_card_scores(catalog: Catalog, flight: str) -> tuple[CardScore, ...]:
    """Return how the cards of a flight were flown, in their order; empty where none are known."""
    rows = catalog.query(
        """SELECT s.* FROM scores s JOIN flights f ON f.id = s.flight WHERE f.name = ?
        ORDER BY s.place""",
        (flight,),
    )
    return tuple(
        CardScore(
            card=row["card"],
            title=row["heading"],
            good=row["good"],
            flown=row["flown"],
            requested=row["wanted"],
        )
        for row in rows
    )


def _json(verdict: StoredVerdict) -> str:
    try:
        return json.dumps(dict(verdict.record), ensure_ascii=False, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise FlightError(
            f"the catalog cannot hold the verdict {verdict.name} ({error}); give numbers, texts, "
            "lists and tables"
        ) from error


def _parsed(catalog: Catalog, text: str) -> dict[str, object]:
    try:
        content = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise FlightError(
            f"a verdict in the catalog {catalog.path} is damaged ({error}); debrief its flight "
            "again"
        ) from error
    return content if isinstance(content, dict) else {}
