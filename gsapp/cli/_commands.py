"""What all commands have in common: plain help and complaints, and an end in order.

The library behind it prints its types beside arguments (``<list[Path]>``) and hands on the words of
the library that checks values (``Value error, ...``).
"""

from __future__ import annotations

import inspect
import re
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_origin

import typer
from typer.core import TyperCommand, TyperGroup
from typer.models import CommandInfo

if TYPE_CHECKING:
    from pydantic.fields import FieldInfo

    from gsapp.foundation.settings import SettingsModel

_TYPE = re.compile(r" <(list\[)?\w+\]?>$")
_CHOICE = re.compile(r"'(?P<typed>.*)' is not one of (?P<known>'.*')\.")
_METAVARS = {
    "<str>": "TEXT",
    "<int>": "N",
    "<int range>": "N",
    "<float>": "X",
    "<float range>": "X",
}
"""What stands in the place of a value that is not a choice."""
_LAST = ("catalog", "units", "dated", "json")
"""Where the results go, of every command the last of its options."""
LINKS = "{links}"
"""Stands for the kinds of links in the help of a command."""
_BRACES = str.maketrans("", "", "{}")


class _Command(TyperCommand):
    """A command whose help names arguments plainly, and whose complaints are plain words."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read what was typed."""
        with _plain_error_messages():
            return super().parse_args(ctx, args)

    def invoke(self, ctx: Any) -> Any:
        """Do it; when asked to end, take back on the way out what is half done."""
        # Not needed for --help.
        from gsapp.cli._usage_errors import check_distinct_flights, check_output_paths
        from gsapp.foundation.process_control import on_termination_signal

        check_output_paths(ctx.params)
        if "append" not in ctx.params:  # as one may be merged with itself, one after the other
            check_distinct_flights(ctx.params.get("flights") or ())
        # The exit code is as the shells count: 128 and the signal.
        with on_termination_signal(lambda signal: sys.exit(128 + signal), ctrl_c=False):
            return super().invoke(ctx)

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        """Return what follows the command's name in its usage."""
        return [piece.translate(_BRACES) for piece in super().collect_usage_pieces(ctx)]

    def format_help_text(self, ctx: Any, formatter: Any) -> None:
        """Write what the command does, with the kinds of links that are installed."""
        if self.help and LINKS in self.help:
            from gsapp.telemetry.link_registry import link_grammar

            self.help = self.help.replace(LINKS, link_grammar())
        super().format_help_text(ctx, formatter)

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write the lists of arguments and options."""
        for title, kind in (("Arguments", "argument"), ("Options", "option")):
            records = [
                record
                for parameter in self.get_params(ctx)
                if parameter.param_type_name == kind
                and (record := parameter.get_help_record(ctx)) is not None
            ]
            tidy = _without_type if kind == "argument" else _with_metavar
            records = [(tidy(name), text) for name, text in records]
            if records:
                with formatter.section(title):
                    formatter.write_dl(records)


def _without_type(name: str) -> str:
    return _TYPE.sub("", name)


def _with_metavar(name: str) -> str:
    option, _, kind = name.partition(" <")
    return f"{option} {_METAVARS[f'<{kind}']}" if f"<{kind}" in _METAVARS else name


class _SettingsCommand(_Command):
    """A command with options for settings, which are imported when the options are needed."""

    _expands = False

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._expands = True

    @property
    def params(self) -> list[Any]:
        """Return all arguments and options."""
        if self._expands:
            self._expands = False
            function = _with_setting_options(self.callback.__wrapped__)  # type: ignore[union-attr]
            whole = typer.main.get_command_from_info(
                CommandInfo(callback=function), pretty_exceptions_short=False, rich_markup_mode=None
            )
            self._params, self.callback = whole.params, whole.callback
        return self._params

    @params.setter
    def params(self, params: list[Any]) -> None:
        self._params = params


def _with_setting_options(function: Callable[..., None]) -> Callable[..., None]:
    """Return a command that has an option for each of its settings, too."""
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
    from gsapp.foundation.settings import setting_info
    from gsapp.identification.methods import estimation_methods

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
    from gsapp.foundation.settings import setting_info
    from gsapp.identification.methods import estimation_methods

    if name == "method":
        return Literal[tuple(estimation_methods())], field.default
    if field.annotation in (bool, bool | None, int) or get_origin(field.annotation) is Literal:
        return field.annotation, field.default
    if setting_info(field).is_repeatable:
        return list[str] | None, None
    if field.annotation == float | None:
        return float | None, None
    return str | None, field.default or None


MANEUVER_SETTINGS = "gsapp.flight.maneuver_settings:ManeuverSettings"
ESTIMATE_SETTINGS = "gsapp.identification.estimate_settings:EstimateSettings"


def takes_settings(
    settings: str, *names: str
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Mark a function that takes settings as keywords: of these names, or any.

    Parameters
    ----------
    settings : str
        A `gsapp.foundation.settings.SettingsModel`, ``module:class``.
    *names : str
        Its fields; all by default.
    """

    def mark(function: Callable[..., None]) -> Callable[..., None]:
        signature = inspect.signature(function, eval_str=True)
        own = [
            one
            for one in signature.parameters.values()
            if one.kind is not one.VAR_KEYWORD and one.name not in names
        ]
        function.settings_path = settings  # type: ignore[attr-defined]
        function.setting_names = names  # type: ignore[attr-defined]
        function.__signature__ = signature.replace(parameters=own)  # type: ignore[attr-defined]
        return function

    return mark


class _Group(TyperGroup):
    """The commands together; a flight in the place of one is told how it opens."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read what was typed."""
        with _plain_error_messages():
            return super().parse_args(ctx, args)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return which command was typed, and what follows it."""
        if args and args[0] not in self.commands and Path(args[0]).exists():
            ctx.fail(f"'{args[0]}' is no command; a flight is opened by: gsapp replay FLIGHT")
        return super().resolve_command(ctx, args)


class CommandApp(typer.Typer):
    """The commands of the program."""

    def __init__(self, **options: Any) -> None:
        super().__init__(cls=_Group, **options)

    def command(self, name: str | None = None, **options: Any) -> Callable[..., Any]:
        """Return what makes a command of a function."""

        def register(function: Callable[..., Any]) -> Callable[..., Any]:
            kind = _SettingsCommand if hasattr(function, "setting_names") else _Command
            return super(CommandApp, self).command(name, cls=kind, **options)(function)

        return register


@contextmanager
def _plain_error_messages() -> Iterator[None]:
    """Say in plain words what is wrong with what was typed, and what was meant."""
    try:
        yield
    except typer.BadParameter as error:
        error.message = _with_hint(_plain(error))
        raise
    except typer.TyperException as error:
        if near := getattr(error, "possibilities", None):  # it is about an unknown option
            error.message += f". Did you mean {' or '.join(near)}?"
            error.possibilities = ()  # type: ignore[attr-defined]
        raise


def _with_hint(complaint: str) -> str:
    """Return a complaint with the choice that was meant, where it is about one."""
    choice = _CHOICE.fullmatch(complaint)
    if choice is None:
        return complaint
    from gsapp.foundation.name_suggestions import did_you_mean  # not needed for --help

    hint = did_you_mean(choice["typed"], re.findall(r"'([^']+)'", choice["known"]), most=1)
    return f"{complaint} {hint[:1].upper()}{hint[1:]}".rstrip()


def _plain(error: typer.BadParameter) -> str:
    """Return what is wrong with a value, without the words of the library that checked it."""
    details = getattr(error.__cause__, "errors", None)
    if details is None:
        return error.message
    (found, *_) = details()
    limits, value = found.get("ctx", {}), found["input"]
    if "error" in limits:
        return str(limits["error"])
    if found["type"].startswith("float_") or str(value).strip().casefold() == "nan":
        return f"'{value}' is not a number"
    if found["type"] == "greater_than_equal":
        return f"{value} is too small; use {limits['ge']:g} or more"
    if found["type"] == "less_than_equal":
        return f"{value} is too large; use {limits['le']:g} or less"
    if found["type"].startswith("int_"):
        return f"'{value}' is not a whole number"
    return error.message
