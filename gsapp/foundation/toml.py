"""TOML files read into pydantic models, with every mistake reported at once.

Values that carry units are read by the types of `gsapp.quantities`; here is only what all files
share: syntax errors and wrong values with their line, unknown keys with the nearest known one.
"""

from __future__ import annotations

import re
import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar, get_args

import tomlkit
from pydantic import BaseModel, ConfigDict, ValidationError

from gsapp.foundation.errors import FileProblem, FileProblemsError
from gsapp.foundation.files import write_atomically
from gsapp.foundation.name_suggestions import did_you_mean
from gsapp.foundation.toml_lines import (
    join_key,
    key_lines,
    line_of_error,
    line_of_key,
    walk_values,
)

_LONGEST_VALUE = 80
"""Characters of a wrong value that are shown."""
_INTEGER_BITS = 64
"""Of the integers of TOML; Python does not even print those of thousands of digits."""
_RESTORE = "correct it, or restore a copy"
_TYPE_REMEDIES = {
    "bool": "write true or false",
    "dict": "write a table",
    "float": "write a number without quotes",
    "int": "write a whole number without quotes",
    "list": "write a list in brackets",
    "model": "write a table",
    "string": "write text in quotes",
    "tuple": "write a list in brackets",
}
"""By the part before the underscore of pydantic's type of an error."""
Model = TypeVar("Model", bound=BaseModel)


class StrictModel(BaseModel):
    """Base of every model read from a file: frozen, and unknown keys are errors."""

    # What a start does not read it need not pay for: validators are built when first needed.
    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True, allow_inf_nan=False)


def read_toml(path: Path | str, model: type[Model], *, distinct: str = "") -> Model:
    """Read a TOML file into a model.

    Each table of the list `distinct` must have an ``id`` of its own. Raise FileProblemsError if the
    file cannot be read, is not TOML, or does not fit the model; every mistake is listed with line,
    key path and remedy.
    """
    content = read_toml_table(path)
    twice = _duplicate_id_problems(content, distinct)
    try:
        found = validate_content(path, content, model)
    except FileProblemsError as error:
        raise toml_problems_error(path, [*error.problems, *twice]) from error
    if twice:
        raise toml_problems_error(path, twice)
    return found


def toml_problems_error(path: Path | str, problems: Sequence[FileProblem]) -> FileProblemsError:
    """Return the error for problems at key paths of a TOML file, with the lines of these."""
    lines = key_lines(_read_text(path))
    return FileProblemsError(
        path, [replace(one, line=line_of_key(one.where, lines)) for one in problems]
    )


def _duplicate_id_problems(content: Mapping[str, Any], key: str) -> list[FileProblem]:
    rows = content.get(key)
    tables = [row for row in rows if isinstance(row, dict)] if isinstance(rows, list) else []
    ids = Counter(str(row["id"]) for row in tables if "id" in row)
    return [
        FileProblem(
            where=key, what=f"the id '{name}' is given {count} times", remedy="give each its own"
        )
        for name, count in ids.items()
        if count > 1
    ]


def read_toml_table(path: Path | str) -> dict[str, Any]:
    """Read a TOML file without a model; see `read_toml` for the errors."""
    text = _read_text(path)
    try:
        content = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise FileProblemsError(path, [_syntax_problem(text, error)]) from error
    too_long = [
        FileProblem(where=key, what="has too many digits", remedy=_RESTORE)
        for key, value in walk_values(content)
        if isinstance(value, int) and value.bit_length() > _INTEGER_BITS
    ]
    if too_long:
        raise toml_problems_error(path, too_long)
    return content


def _read_text(path: Path | str) -> str:
    try:
        return Path(path).read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        line = error.object.count(b"\n", 0, error.start) + 1
        problem = FileProblem(
            where=f"line {line}",
            what=f"byte {error.start} is not UTF-8 text",
            remedy="save the file as UTF-8",
        )
        raise FileProblemsError(path, [problem]) from error
    except OSError as error:
        problem = FileProblem(
            where="file",
            what=f"cannot be read ({error.strerror})",
            remedy="check the path and the permissions",
        )
        raise FileProblemsError(path, [problem]) from error


def validate_content(path: Path | str, content: Mapping[str, Any], model: type[Model]) -> Model:
    """Fit parsed content into a model; see `read_toml` for the errors."""
    try:
        return model.model_validate(content)
    except ValidationError as error:
        details = [dict(detail) for detail in error.errors()]
        problems = [
            _problem(detail, model) for detail in details if not _is_consequence(detail, details)
        ]
        raise FileProblemsError(path, problems) from error


def toml_text(content: Mapping[str, Any]) -> str:
    """Return TOML for a mapping; None values are left out, since TOML has no null."""
    return tomlkit.dumps(_without_none(content))


def write_toml(path: Path | str, content: Mapping[str, Any]) -> Path:
    """Write a mapping as TOML, atomically. None values are left out."""
    return write_atomically(path, toml_text(content))


def _without_none(content: Mapping[str, Any]) -> dict[str, Any]:
    return {
        key: _without_none(value) if isinstance(value, Mapping) else value
        for key, value in content.items()
        if value is not None
    }


def _syntax_problem(text: str, error: Exception) -> FileProblem:
    message, _, place = str(error).removesuffix(")").rpartition(" (at ")
    where = place if place.startswith("line") else f"line {line_of_error(text, error)}"
    if isinstance(error, tomllib.TOMLDecodeError):
        return FileProblem(
            where=where,
            what=f"is not valid TOML ({message})",
            remedy='write  key = "value"  and quote every value that has a unit',
        )
    what = "holds a number with too many digits"
    if isinstance(error, RecursionError):
        what = "has brackets nested too deeply"
    return FileProblem(where=where, what=what, remedy=_RESTORE)


def _key_path(location: Sequence[Any]) -> str:
    path = ""
    for part in location:
        if part != "[key]":
            path = join_key(path, part)
    return path or "file"


def _is_consequence(detail: dict[str, Any], details: Sequence[dict[str, Any]]) -> bool:
    """Return whether a list is only too short because an item of it is wrong."""
    place = tuple(detail["loc"])
    return detail["type"] == "too_short" and any(
        len(other["loc"]) > len(place) and tuple(other["loc"][: len(place)]) == place
        for other in details
    )


def _problem(detail: dict[str, Any], model: type[BaseModel]) -> FileProblem:
    location = tuple(detail["loc"])
    where = _key_path(location)
    if detail["type"] == "extra_forbidden":
        known = sorted(_known_keys(model, location[:-1]))
        usual = f"known keys: {', '.join(known)}"
        remedy = did_you_mean(str(location[-1]), known, usual, most=1)
        return FileProblem(where=where, what="is not a known key", remedy=remedy)
    if detail["type"] == "missing":
        return FileProblem(where=where, what="is missing", remedy="add it")
    text = str(detail["msg"]).removeprefix("Value error, ")
    what, _, remedy = text.partition("; ")
    if detail["type"] == "literal_error":
        choices = re.findall(r"'([^']+)'", detail["ctx"]["expected"])
        remedy = did_you_mean(str(detail["input"]), choices, most=1)
    if detail["type"] != "value_error":
        what = f"{what[:1].lower()}{what[1:]} (found {_shorten(repr(detail['input']))})"
        remedy = remedy or _TYPE_REMEDIES.get(detail["type"].partition("_")[0], "")
    return FileProblem(where=where, what=what, remedy=remedy)


def _shorten(text: str) -> str:
    return text if len(text) <= _LONGEST_VALUE else f"{text[:_LONGEST_VALUE]}..."


def _known_keys(model: type[BaseModel], location: Sequence[Any]) -> Iterator[str]:
    """Yield the keys that the table at `location` may hold."""
    current: list[type[BaseModel]] = [model]
    for part in location:
        if isinstance(part, int):
            continue
        deeper: list[type[BaseModel]] = []
        for candidate in current:
            for name, field in candidate.model_fields.items():
                if part in (name, field.alias):
                    deeper.extend(_models_in(field.annotation))
        # A key of a mapping, or the tag of a union, does not change the model.
        current = deeper or current
    for candidate in current:
        for name, field in candidate.model_fields.items():
            yield field.alias or name


def _models_in(annotation: Any) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
        return
    for argument in get_args(annotation):
        yield from _models_in(argument)
