"""Options of commands from the settings of an estimation."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from typing import Annotated, Any, Literal, get_origin

import typer
from pydantic.fields import FieldInfo

from gsapp.identification.estimate_settings import EstimateSettings, FitSettings, setting_info
from gsapp.identification.methods import estimation_methods


def with_setting_options(function: Callable[..., None]) -> Callable[..., None]:
    """Return a command that has an option for each of its settings, too.

    Parameters
    ----------
    function : callable
        Marked by `gsapp.cli._commands.takes_settings`; it is called with the settings that were
        typed as further keywords.
    """
    own = inspect.signature(function, eval_str=True).parameters.values()
    options = list(_options(function.setting_names))  # type: ignore[attr-defined]
    names = {one.name for one in options}
    required = [one for one in own if one.default is one.empty]
    optional = [one for one in own if one not in required]

    def command(**values: Any) -> None:
        function(
            **{name: one for name, one in values.items() if name not in names or one is not None}
        )

    command.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
        [one.replace(kind=one.KEYWORD_ONLY) for one in (*required, *options, *optional)]
    )
    command.__name__, command.__doc__ = function.__name__, function.__doc__
    return command


def _options(names: tuple[str, ...]) -> Iterator[inspect.Parameter]:
    fields = EstimateSettings.model_fields
    for name in sorted(fields, key=lambda one: one in FitSettings.model_fields):
        field = fields[name]
        info = setting_info(field)
        if not info.option or (names and name not in names):
            continue
        kind, default = _type(name, field)
        text = str(field.description).partition(". ")[0].removesuffix(".")
        if name == "method":
            text = ", ".join(f"{one.id}: {one.title}" for one in estimation_methods().values())
        if info.is_repeatable:
            text += "; repeatable"
        option = typer.Option(info.option, metavar=info.metavar or None, help=text)
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
    if field.annotation is bool or get_origin(field.annotation) is Literal:
        return field.annotation, field.default
    if setting_info(field).is_repeatable:
        return list[str] | None, None
    return (float if field.annotation == float | None else str) | None, None
