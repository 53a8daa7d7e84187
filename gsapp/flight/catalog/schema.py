"""The tables of a catalog, as the steps that lead from an empty file to the present version.

A step is never changed once it was released; what comes later is a further step. The version of a
file is its ``user_version``: the number of steps it has gone.
"""

from __future__ import annotations

from typing import Final

APPLICATION_ID: Final = 0x47534350
"""Marks a SQLite file as a catalog."""

_FIRST: Final = (
    """CREATE TABLE flights (
        id INTEGER PRIMARY KEY,
        name TEXT NOT NULL UNIQUE,
        path TEXT NOT NULL DEFAULT '',
        date TEXT,
        aircraft TEXT NOT NULL DEFAULT '',
        duration REAL,
        takeoff_weight REAL,
        landing_weight REAL,
        fuel REAL,
        notes TEXT NOT NULL DEFAULT '',
        pilot_comments TEXT NOT NULL DEFAULT '',
        facts TEXT NOT NULL DEFAULT '{}'
    )""",
    """CREATE TABLE weights (
        flight INTEGER NOT NULL REFERENCES flights(id) ON DELETE CASCADE,
        response TEXT NOT NULL,
        weight REAL NOT NULL CHECK (weight >= 0),
        PRIMARY KEY (flight, response)
    )""",
    """CREATE TABLE maneuvers (
        id INTEGER PRIMARY KEY,
        flight INTEGER NOT NULL REFERENCES flights(id) ON DELETE CASCADE,
        name TEXT NOT NULL,
        t_start REAL NOT NULL,
        t_end REAL NOT NULL,
        kind TEXT NOT NULL,
        amplitude REAL,
        note TEXT NOT NULL DEFAULT '',
        record TEXT NOT NULL,
        stands INTEGER NOT NULL DEFAULT 1,
        UNIQUE (flight, name),
        CHECK (t_start < t_end)
    )""",
    """CREATE TABLE inputs (
        maneuver INTEGER NOT NULL REFERENCES maneuvers(id) ON DELETE CASCADE,
        surface TEXT NOT NULL,
        amplitude REAL,
        PRIMARY KEY (maneuver, surface)
    )""",
    """CREATE TABLE conditions (
        maneuver INTEGER NOT NULL REFERENCES maneuvers(id) ON DELETE CASCADE,
        channel TEXT NOT NULL,
        mean REAL NOT NULL,
        least REAL NOT NULL,
        most REAL NOT NULL,
        PRIMARY KEY (maneuver, channel)
    )""",
    """CREATE TABLE grades (
        id INTEGER PRIMARY KEY,
        maneuver INTEGER NOT NULL REFERENCES maneuvers(id) ON DELETE CASCADE,
        grade TEXT NOT NULL CHECK (grade IN ('A', 'B', 'C', 'D')),
        reasons TEXT NOT NULL DEFAULT '[]',
        given_by TEXT NOT NULL DEFAULT 'program',
        given_at TEXT NOT NULL
    )""",
    """CREATE TABLE models (
        id INTEGER PRIMARY KEY,
        name TEXT NOT NULL UNIQUE,
        parent TEXT,
        content TEXT NOT NULL,
        evidence TEXT NOT NULL DEFAULT '',
        made_at TEXT NOT NULL
    )""",
    """CREATE TABLE runs (
        id INTEGER PRIMARY KEY,
        method TEXT NOT NULL,
        axis TEXT NOT NULL,
        settings TEXT NOT NULL DEFAULT '{}',
        model INTEGER REFERENCES models(id) ON DELETE SET NULL,
        converged INTEGER NOT NULL,
        iterations INTEGER NOT NULL DEFAULT 0,
        fit TEXT NOT NULL DEFAULT '{}',
        warnings TEXT NOT NULL DEFAULT '[]',
        message TEXT NOT NULL DEFAULT '',
        made_at TEXT NOT NULL
    )""",
    # The edges as they were then: they may be moved later.
    """CREATE TABLE run_maneuvers (
        run INTEGER NOT NULL REFERENCES runs(id) ON DELETE CASCADE,
        maneuver INTEGER NOT NULL REFERENCES maneuvers(id) ON DELETE CASCADE,
        t_start REAL NOT NULL,
        t_end REAL NOT NULL,
        PRIMARY KEY (run, maneuver)
    )""",
    """CREATE TABLE estimates (
        run INTEGER NOT NULL REFERENCES runs(id) ON DELETE CASCADE,
        name TEXT NOT NULL,
        value REAL,
        std REAL,
        cramer_rao REAL,
        status TEXT NOT NULL,
        confounded_with TEXT NOT NULL DEFAULT '[]',
        why TEXT NOT NULL DEFAULT '',
        PRIMARY KEY (run, name)
    )""",
    "CREATE INDEX maneuvers_by_flight ON maneuvers(flight, t_start)",
    "CREATE INDEX inputs_by_surface ON inputs(surface)",
    "CREATE INDEX conditions_by_channel ON conditions(channel, mean)",
    "CREATE INDEX grades_by_maneuver ON grades(maneuver, id)",
    "CREATE INDEX run_maneuvers_by_maneuver ON run_maneuvers(maneuver)",
    "CREATE INDEX estimates_by_name ON estimates(name)",
)

_VERDICTS: Final = (
    # What was said of each input in flight. Which maneuver it is follows from the times: the
    # maneuvers may be found anew, and were not yet found when the first verdict was given.
    """CREATE TABLE verdicts (
        id INTEGER PRIMARY KEY,
        flight INTEGER NOT NULL REFERENCES flights(id) ON DELETE CASCADE,
        name TEXT NOT NULL,
        t_input REAL NOT NULL,
        t_end REAL NOT NULL,
        surfaces TEXT NOT NULL,
        kind TEXT NOT NULL,
        V REAL,
        result TEXT NOT NULL,
        advice TEXT NOT NULL DEFAULT '',
        card TEXT NOT NULL DEFAULT '',
        counts INTEGER NOT NULL DEFAULT 0,
        record TEXT NOT NULL,
        UNIQUE (flight, name)
    )""",
    """CREATE TABLE scores (
        flight INTEGER NOT NULL REFERENCES flights(id) ON DELETE CASCADE,
        card TEXT NOT NULL,
        place INTEGER NOT NULL,
        heading TEXT NOT NULL DEFAULT '',
        good INTEGER NOT NULL,
        flown INTEGER NOT NULL,
        wanted INTEGER NOT NULL,
        PRIMARY KEY (flight, card)
    )""",
    "CREATE INDEX verdicts_by_flight ON verdicts(flight, t_input)",
)

_CAMPAIGN_RUNS: Final = (
    # A run over a whole campaign; what was forgotten can be called back. `runs` holds its fits.
    """CREATE TABLE kept_runs (
        id INTEGER PRIMARY KEY,
        label TEXT NOT NULL DEFAULT '',
        made_at TEXT NOT NULL,
        method TEXT NOT NULL,
        axis TEXT NOT NULL,
        aircraft TEXT NOT NULL DEFAULT '',
        flights TEXT NOT NULL DEFAULT '[]',
        request TEXT NOT NULL,
        settings TEXT NOT NULL DEFAULT '{}',
        inputs TEXT NOT NULL DEFAULT '[]',
        versions TEXT NOT NULL DEFAULT '{}',
        result TEXT NOT NULL DEFAULT '{}',
        forgotten_at TEXT
    )""",
    "ALTER TABLE runs ADD COLUMN kept INTEGER REFERENCES kept_runs(id) ON DELETE CASCADE",
    "CREATE INDEX runs_by_kept ON runs(kept)",
)

_FLEET: Final = (
    "ALTER TABLE flights ADD COLUMN airframe TEXT NOT NULL DEFAULT ''",
    # What the instruments of a flight show of their own errors, SI.
    """CREATE TABLE instrument_errors (
        flight INTEGER NOT NULL REFERENCES flights(id) ON DELETE CASCADE,
        name TEXT NOT NULL,
        value REAL,
        std REAL,
        status TEXT NOT NULL,
        PRIMARY KEY (flight, name)
    )""",
)

# Until then a verdict that is `invalid` was called `spoiled`.
_INVALID_VERDICTS: Final = (
    """UPDATE verdicts SET result = replace(result, 'spoiled', 'invalid'),
        record = replace(record, '"result": "spoiled"', '"result": "invalid"')""",
)

MIGRATIONS: tuple[tuple[str, ...], ...] = (
    _FIRST, _VERDICTS, _CAMPAIGN_RUNS, _FLEET, _INVALID_VERDICTS,
)  # fmt: skip
"""Statements of each step, oldest first."""
