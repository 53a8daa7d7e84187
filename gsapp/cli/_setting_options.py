"""Options of commands from a class of settings."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from importlib import import_module
from typing import Annotated, Any, Literal, get_origin

import typer
from pydantic.fields import FieldInfo

from gsapp.foundation.settings import SettingsModel, setting_info
from gsapp.identification.methods import estimation_methods

_LAST = ("catalog", "units", "dated", "json")
"""Where the results go, of every command the last of its options."""


def with_setting_options(function: Callable[..., None]) -> Callable[..., None]:
    """Return a command that has an option for each of its settings, too.

    Parameters
    ----------
    function : callable
        Marked by `gsapp.cli._commands.takes_settings`; it is called with the settings that were
        typed as further keywords.
    """
    own = inspect.signature(function, eval_str=True).parameters.values()
    module, _, name = function.settings_path.partition(":")  # type: ignore[attr-defined]
    settings: type[SettingsModel] = getattr(import_module(module), name)
    options = list(_options(settings, function.setting_names))  # type: ignore[attr-defined]
    names = {one.name for one in options}
    first = [one for one in own if one.name not in _LAST]
    last = [one for one in own if one.name in _LAST]

    def command(**values: Any) -> None:
        function(
            **{name: one for name, one in values.items() if name not in names or one is not None}
        )

    command.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
        [one.replace(kind=one.KEYWORD_ONLY) for one in (*first, *options, *last)]
    )
    command.__name__, command.__doc__ = function.__name__, function.__doc__
    return command


def _options(settings: type[SettingsModel], names: tuple[str, ...]) -> Iterator[inspect.Parameter]:
    """Return the options, those of a class before those of the classes that it extends."""
    own = [name for base in settings.__mro__ for name in inspect.get_annotations(base)]
    for name in (one for one in own if one in settings.model_fields):
        field = settings.model_fields[name]
        info = setting_info(field)
        if not info.option or (names and name not in names):
            continue
        kind, default = _type(name, field)
        text = str(field.description).partition(". ")[0].removesuffix(".")
        if name == "method":
            text = ", ".join(f"{one.id}: {one.title}" for one in estimation_methods().values())
        if info.is_repeatable:
            text += "; repeatable"
        least = next((one.ge for one in field.metadata if hasattr(one, "ge")), None)
        option = typer.Option(info.option, metavar=info.metavar or None, help=text, min=least)
        yield inspect.Parameter(
            name,
            inspect.Parameter.KEYWORD_ONLY,
            default=default,
            annotation=Annotated[kind, option],
        )


def _type(name: str, field: FieldInfo) -> tuple[Any, Any]:
    """Return the type of an option, and its default; settings read typed text themselves."""
    if name == "method":
        return Literal[tuple(estimation_methods())], field.default
    if field.annotation in (bool, int) or get_origin(field.annotation) is Literal:
        return field.annotation, field.default
    if setting_info(field).is_repeatable:
        return list[str] | None, None
    if field.annotation == float | None:
        return float | None, None
    return str | None, field.default or None
