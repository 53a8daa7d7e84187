"""Settings declared once: type, default, limits, title, help, unit.

The options of a command, the form in the window, the request that is stored, and the description
in a report derive from the fields of one class. Values may be given as typed text: ``Cm_q,Cm_de``
for names, ``Cm_q=-20, CN_q=5`` for values, ``Cm_q=-20:5`` for values with a standard deviation.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Self

from pydantic import BeforeValidator, Field, ValidationError
from pydantic.fields import FieldInfo

from gsapp.foundation.errors import FlightError
from gsapp.foundation.toml import StrictModel


class SettingError(FlightError):
    """A setting has a value that it cannot have; words say what is wrong, and the remedy."""

    def __init__(self, field: str, words: str) -> None:
        super().__init__(words)
        self.field = field


@dataclass(frozen=True, slots=True, kw_only=True)
class SettingInfo:
    """How a setting appears to the user, beside its title and help."""

    option: str = ""  # On the command line; empty for none.
    metavar: str = ""  # Of its value there.
    is_repeatable: bool = False  # Whether the option may be given several times.
    choices: tuple[tuple[str, str], ...] = ()  # Values and their titles.
    unit: str = ""
    default_text: str = "none"  # What the default means.


def setting_info(field: FieldInfo) -> SettingInfo:
    """Return how a setting appears to the user."""
    return next((one for one in field.metadata if isinstance(one, SettingInfo)), SettingInfo())


def setting(
    default: Any,
    title: str,
    text: str,
    *,
    gt: float | None = None,
    ge: float | None = None,
    **info: Any,
) -> Any:
    """Declare a setting; the first sentence of its text is its help on the command line."""
    field = Field(default, title=title, description=text, gt=gt, ge=ge)
    field.metadata.append(SettingInfo(**info))
    return field


# --- typed text -----------------------------------------------------------------------------------


def _parse_names(value: Any) -> Any:
    if isinstance(value, str):
        return tuple(name.strip() for name in value.split(",") if name.strip())
    return value


def _parse_pairs(value: Any, read: Callable[[str], Any], form: str) -> Any:
    texts = value.split(",") if isinstance(value, str) else value
    if not isinstance(texts, Sequence):
        return value
    found = {}
    for text in filter(None, (one.strip() for one in texts)):
        name, equals, number = (part.strip() for part in text.partition("="))
        try:
            found[name] = read(number)
        except ValueError:
            equals = ""
        if not equals or not name:
            raise FlightError(f"'{text}' cannot be read; write {form}")
    return found


def _parse_values(value: Any) -> Any:
    return _parse_pairs(value, float, "NAME=VALUE, as Cm_q=-20")


def _parse_priors(value: Any) -> Any:
    def read(text: str) -> tuple[float, float]:
        number, _, std = text.partition(":")
        return float(number), float(std)

    return _parse_pairs(value, read, "NAME=VALUE:STD, as Cm_q=-20:5")


def _parse_optional_number(value: Any) -> Any:
    if not isinstance(value, str):
        return value
    try:
        return float(value) if value.strip() else None
    except ValueError:
        raise FlightError(f"'{value}' is not a number; write it as 10") from None


Names = Annotated[tuple[str, ...], BeforeValidator(_parse_names)]
OptionalNames = Annotated[tuple[str, ...] | None, BeforeValidator(_parse_names)]
Values = Annotated[Mapping[str, float], BeforeValidator(_parse_values)]
Priors = Annotated[Mapping[str, tuple[float, float]], BeforeValidator(_parse_priors)]
OptionalNumber = Annotated[float | None, BeforeValidator(_parse_optional_number)]


# --- declarations ---------------------------------------------------------------------------------


class SettingsModel(StrictModel):
    """Base of settings: a value that a setting cannot have raises `SettingError`."""

    def __init__(self, **values: Any) -> None:
        try:
            super().__init__(**values)
        except ValidationError as error:
            first = error.errors()[0]
            field = str(first["loc"][0]) if first["loc"] else ""
            text = str(first["msg"]).removeprefix("Value error, ")
            declared = type(self).model_fields.get(field)
            titles = () if declared is None or not declared.title else (declared.title,)
            where = ".".join(map(str, (*titles, *first["loc"][len(titles) :])))
            if first["type"] == "extra_forbidden":
                text = f"'{where}' is not a setting"
            elif first["type"] != "value_error":
                must = text.removeprefix("Input ")  # "Input should be greater than 0"
                text = f"{where} is {first['input']!r}; it {must[:1].lower()}{must[1:]}"
            raise SettingError(field, text) from error

    @classmethod
    def title_of(cls, name: str) -> str:
        return str(cls.model_fields[name].title)

    @classmethod
    def help_of(cls, name: str) -> str:
        """Return what a setting does, and when to change it."""
        return str(cls.model_fields[name].description)

    def with_changes(self, **changes: Any) -> Self:
        return type(self)(**{**dict(self), **changes})


def command_arguments(settings: SettingsModel) -> list[str]:
    """Return the options of a command that give these settings; defaults are left out."""
    arguments = []
    for name, field in type(settings).model_fields.items():
        option, value = setting_info(field).option, getattr(settings, name)
        if not option or value in (field.default, "", None):
            continue
        yes, _, no = option.partition("/")
        if isinstance(value, bool):
            arguments.append(yes if value else no)
        else:
            for one in value if isinstance(value, tuple) else (value,):
                arguments += [yes, str(one)]
    return arguments
