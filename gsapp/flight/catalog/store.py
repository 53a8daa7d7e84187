"""The file of a catalog: opening, migrating, reading and writing, whoever else does so."""

from __future__ import annotations

import contextlib
import json
import math
import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from types import TracebackType
from typing import Any, Final, Self

from gsapp.flight.catalog import schema
from gsapp.flight.settings import FLIGHT_DATA
from gsapp.foundation import FlightError, UnknownNameError


def flight_row_id(connection: sqlite3.Connection, name: str) -> int:
    """Return the number of a flight."""
    row = connection.execute("SELECT id FROM flights WHERE name = ?", (name,)).fetchone()
    if row is None:
        raise UnknownNameError(f"the catalog has no flight '{name}'; store it first")
    return int(row["id"])


def maneuver_row_id(connection: sqlite3.Connection, flight: str, name: str) -> int:
    """Return the number of a maneuver; see `flight_row_id`."""
    number = flight_row_id(connection, flight)
    row = connection.execute(
        "SELECT id FROM maneuvers WHERE flight = ? AND name = ?", (number, name)
    ).fetchone()
    if row is None:
        raise UnknownNameError(
            f"the catalog has no maneuver '{name}' of the flight '{flight}'; store it first"
        )
    return int(row["id"])


def model_row_id(connection: sqlite3.Connection, name: str | None) -> int | None:
    """Return the number of a model, None for none; see `flight_row_id`."""
    if name is None:
        return None
    row = connection.execute("SELECT id FROM models WHERE name = ?", (name,)).fetchone()
    if row is None:
        raise UnknownNameError(f"the catalog has no model '{name}'; store it first")
    return int(row["id"])


def to_json_text(content: Any) -> str:
    """Return what JSON can hold as text."""
    try:
        return json.dumps(
            dict(content) if isinstance(content, Mapping) else content,
            ensure_ascii=False,
            allow_nan=False,
        )
    except (TypeError, ValueError) as error:
        raise FlightError(
            f"the catalog cannot hold {content!r} ({error}); give numbers, texts, lists and tables"
        ) from error


def insert_row(
    connection: sqlite3.Connection, table: str, values: Mapping[str, Any], key: Sequence[str] = ()
) -> int:
    """Insert a row, or renew the one with the same values in the columns of `key`; return its id.

    Of `values`, by column, tables and lists are written as JSON, numbers that are none as NULL.
    """
    names = ", ".join(values)
    # Names of tables and columns are the program's own.
    statement = f"INSERT INTO {table} ({names}) VALUES ({', '.join('?' * len(values))})"  # noqa: S608
    if key:
        changes = ", ".join(f"{name} = excluded.{name}" for name in values if name not in key)
        statement += f" ON CONFLICT ({', '.join(key)}) DO UPDATE SET {changes}"
    return int(connection.execute(statement, [*map(_column, values.values())]).lastrowid or 0)


def _column(value: Any) -> Any:
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    return to_json_text(value) if isinstance(value, (Mapping, list, tuple)) else value


def select_where(clauses: Mapping[str, Any]) -> tuple[str, list[Any]]:
    """Return an SQL condition and its values from clauses; those of None do not count."""
    given = {clause: value for clause, value in clauses.items() if value is not None}
    return " AND ".join(given) or "1", list(given.values())


def utc_timestamp() -> str:
    """Return the present time, UTC, as a catalog writes it."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")


_PRIMARY: Final = 0xFF
"""Bits of an error's code that tell its kind."""


class Catalog:
    """One SQLite file: the maneuvers of a campaign and what was learned from them.

    Several programs may use it at once. A reader never waits; writers take turns. One that may not
    be written, on a locked card or a colleague's share, can be read all the same. A file that does
    not exist is made; one that is no catalog, damaged or newer than this program is refused.
    """

    def __init__(self, path: Path | str) -> None:
        self.path = Path(path)
        if self.path.is_dir():
            raise FlightError(f"{self.path} is a folder; name a file for the catalog")
        if not self.path.parent.is_dir():
            raise FlightError(
                f"the catalog {self.path} cannot be created: no folder {self.path.parent}"
            )
        is_new = not self.path.exists()
        with self._words():
            self._connection = self._connected()
        try:
            with self._words():
                if not is_new and not self._may_be_read():
                    self._connection.close()
                    self._connection = self._connected(beside=False)
                self._prepare()
        except BaseException:
            self._connection.close()
            if is_new:
                with contextlib.suppress(OSError):
                    self._leave_nothing()
            raise

    def _connected(self, *, beside: bool = True) -> sqlite3.Connection:
        """Connect to the file; without files beside it, it is taken as one that never changes."""
        name = self.path if beside else f"{self.path.absolute().as_uri()}?mode=ro&immutable=1"
        return sqlite3.connect(
            name,
            timeout=FLIGHT_DATA.catalog_timeout,
            isolation_level=None,
            check_same_thread=True,
            uri=not beside,
        )

    def _may_be_read(self) -> bool:
        """Return whether a first look into the file succeeds as it is opened.

        Even to read, SQLite puts files beside it for those who share it. In a folder that may not
        be written it can do without, unless another program has left there what it wrote last.
        """
        try:
            self._connection.execute("PRAGMA user_version").fetchone()
        except sqlite3.OperationalError as error:
            kind = error.sqlite_errorcode & _PRIMARY
            if kind not in (sqlite3.SQLITE_READONLY, sqlite3.SQLITE_CANTOPEN):
                raise
            log = self.path.with_name(f"{self.path.name}-wal")
            return log.exists() and log.stat().st_size > 0
        return True

    def _leave_nothing(self) -> None:
        if not self.path.stat().st_size:
            self.path.unlink()

    def close(self) -> None:
        self._connection.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    @property
    def version(self) -> int:
        return int(self.query("PRAGMA user_version")[0][0])

    def query(self, statement: str, values: Sequence[Any] = ()) -> list[sqlite3.Row]:
        with self._words():
            return list(self._connection.execute(statement, tuple(values)))

    @contextlib.contextmanager
    def transaction(self) -> Iterator[sqlite3.Connection]:
        """Give the connection within one transaction, or within that under way: all or nothing."""
        if self._connection.in_transaction:
            yield self._connection
            return
        with self._words():
            self._connection.execute("BEGIN IMMEDIATE")
            try:
                yield self._connection
            except BaseException:
                # Out of space, SQLite has taken everything back by itself.
                if self._connection.in_transaction:
                    self._connection.execute("ROLLBACK")
                raise
            self._connection.execute("COMMIT")

    # Opening --------------------------------------------------------------------------

    def _prepare(self) -> None:
        connection = self._connection
        connection.row_factory = sqlite3.Row
        connection.execute("PRAGMA foreign_keys = ON")
        version = self._checked_version()
        if version < len(schema.MIGRATIONS):
            self._migrate()
        # Some network file systems cannot share memory; the journal of old does there. While
        # another program opens the file, its choice stands.
        with contextlib.suppress(sqlite3.OperationalError):
            connection.execute("PRAGMA journal_mode = WAL")

    def _checked_version(self) -> int:
        """Return the version of a file that this program can use; 0 for an empty one."""
        connection = self._connection
        application = connection.execute("PRAGMA application_id").fetchone()[0]
        version = int(connection.execute("PRAGMA user_version").fetchone()[0])
        tables = connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]
        if application != schema.APPLICATION_ID and (application or version or tables):
            raise FlightError(f"{self.path} is a database of another program; name another file")
        programs = "SELECT count(*) FROM sqlite_master WHERE type IN ('view', 'trigger')"
        if connection.execute(programs).fetchone()[0]:
            # They would compute whatever they like, without end.
            raise self._damage("it has views or triggers")
        known = len(schema.MIGRATIONS)
        if version > known:
            raise FlightError(
                f"the catalog {self.path} was written by a newer version of this program "
                f"(tables of version {version}; this program supports up to {known}); update "
                "the program"
            )
        return version

    def _migrate(self) -> None:
        with self.transaction() as connection:
            # Another program may have done it while this one waited for its turn.
            done = self._checked_version()
            for step in schema.MIGRATIONS[done:]:
                for statement in step:
                    connection.execute(statement)
            connection.execute(f"PRAGMA application_id = {schema.APPLICATION_ID}")
            connection.execute(f"PRAGMA user_version = {len(schema.MIGRATIONS)}")

    @contextlib.contextmanager
    def _words(self) -> Iterator[None]:
        """Turn what SQLite says into a sentence for people."""
        try:
            yield
        except sqlite3.OperationalError as error:
            raise self._refusal(error) from error
        except sqlite3.IntegrityError as error:
            raise FlightError(f"the catalog {self.path} rejects the entry ({error})") from error
        except (sqlite3.DatabaseError, UnicodeDecodeError, OverflowError) as error:
            raise self._damage(str(error)) from error

    def _refusal(self, error: sqlite3.OperationalError) -> FlightError:
        if "locked" in str(error) or "busy" in str(error):
            return FlightError(
                f"another program has been writing to the catalog {self.path} for more than "
                f"{FLIGHT_DATA.catalog_timeout:.0f} s; close it, or try again"
            )
        # A column that is missing, or texts that are none; the latter have no code.
        code = getattr(error, "sqlite_errorcode", sqlite3.SQLITE_ERROR)
        if code == sqlite3.SQLITE_ERROR:
            return self._damage(str(error))
        todo = "check the path, the permissions and the space on the disk"
        if code == sqlite3.SQLITE_FULL:
            todo = "free disk space"
        return FlightError(f"the catalog {self.path} cannot be used ({error}); {todo}")

    def _damage(self, what: str) -> FlightError:
        return FlightError(
            f"the catalog {self.path} is damaged or not a catalog ({what}); restore a copy, or "
            "name a new file and store the flights again"
        )
