"""Writes the reference pages that follow from the code: ``python -m tests.docs.reference``.

The tests compare the pages with what this module makes, so none of them can be out of date.
"""

from __future__ import annotations

import importlib
import inspect
import re
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import typer

import gsapp
from gsapp.api.result import Result
from gsapp.cli._commands import LINKS
from gsapp.cli.main import app
from gsapp.decoding.channel_map import load_channel_map, shipped_channel_maps
from gsapp.discrepancy.effect_catalog import all_effects
from gsapp.discrepancy.settings import DiscrepancySettings
from gsapp.flight.flight import Flight
from gsapp.flight.maneuver_settings import ManeuverSettings
from gsapp.foundation import errors
from gsapp.foundation.settings import SettingsModel, setting_info
from gsapp.identification.estimate_settings import EstimateSettings
from gsapp.quantities.channels import CHANNELS
from gsapp.telemetry.link_kinds import BUILT_IN_KINDS
from gsapp.virtual.downlink.flight_settings import FlightSettings
from ui.commands import COMMANDS

FOLDER = Path(__file__).parents[2] / "docs" / "reference"
_MADE = "<!-- Made from the code by tests/docs/reference.py: change the code, not this page. -->"


def _row(cells: Iterable[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|").replace("\n", " ") for cell in cells) + " |"


def _table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> Iterator[str]:
    yield _row(head)
    yield _row("---" for _ in head)
    yield from (_row(row) for row in rows)
    yield ""


def _page(title: str, *lines: str) -> str:
    return "\n".join([f"# {title}", "", _MADE, "", *lines]).rstrip() + "\n"


def channels() -> str:
    """Return the page of all channels."""
    groups: dict[str, list[tuple[str, ...]]] = {}
    for spec in CHANNELS.values():
        low, high = spec.limits
        groups.setdefault(spec.group, []).append(
            (f"`{spec.id}`", spec.symbol, spec.title, spec.unit or "1", spec.si_display or "1",
             spec.us_display or "1", f"{low:g} to {high:g}", spec.description)
        )  # fmt: skip
    head = ("id", "symbol", "title", "unit in files", "SI", "US", "plausible", "meaning")
    lines: list[str] = [
        "Files hold SI units and radians; the window shows the units chosen. A second sensor of a "
        "channel is `q.2`, and the volts of an instrument are `q_volts`.",
        "",
    ]
    for group, rows in groups.items():
        lines += [f"## {group[:1].upper()}{group[1:]}", "", *_table(head, rows)]
    return _page("Channels", *lines)


def _arguments(command: Any) -> Iterator[tuple[str, ...]]:
    for parameter in command.params:
        if parameter.hidden or parameter.name in ("install_completion", "show_completion"):
            continue
        text = parameter.help or ""
        if parameter.param_type_name == "argument":
            yield f"`{parameter.metavar or parameter.name.upper()}`", "", text
            continue
        names = ", ".join(f"`{name}`" for name in (*parameter.opts, *parameter.secondary_opts))
        value = f" `{parameter.metavar}`" if parameter.metavar and not parameter.is_flag else ""
        default = parameter.default
        is_shown = isinstance(default, (str, int, float)) and not isinstance(default, bool)
        yield names + value, f"`{default}`" if is_shown and default != "" else "", text


def _command(command: Any, path: str) -> Iterator[str]:
    yield f"## {path}"
    yield ""
    text = (
        (command.help or "")
        .replace(LINKS, "[these](links.md)")
        .replace("\b\n", "")
        .replace("\f", "")
        .strip()
    )
    yield re.sub(r"\n{3,}", "\n\n", text)
    yield ""
    rows = list(_arguments(command))
    if rows:
        yield from _table(("argument or option", "default", "meaning"), rows)
    for name, part in getattr(command, "commands", {}).items():
        if not part.hidden:
            yield from _command(part, f"{path} {name}")


def commands() -> str:
    """Return the page of all commands."""
    group: Any = typer.main.get_command(app)
    lines: list[str] = []
    for name, command in group.commands.items():
        if not command.hidden:
            lines += _command(command, f"gsapp {name}")
    return _page("Commands", *lines)


def effects() -> str:
    """Return the page of all effects that a model may lack."""
    rows: dict[str, list[tuple[str, ...]]] = {}
    for record in all_effects():
        values = (
            f"`{one.name}={one.default:.4g}`{f' {one.unit}' if one.unit else ''}"
            for one in record.parameters
        )
        rows.setdefault(record.entry, []).append(
            (f"`{record.id}`", record.effect_class, record.title, f"`{record.equation}`",
             ", ".join(values), ", ".join(f"`{one}`" for one in record.mistaken_for),
             record.separated_by)
        )  # fmt: skip
    head = ("id", "class", "effect", "equation", "default", "mistaken for", "separated by")
    lines: list[str] = [
        "Effects that a linear model lacks: `gsapp discrepancy` finds them, `gsapp fly --hide` "
        "adds them to the virtual aircraft, and `[[effects]]` to a model file. Default values "
        "are those of the B777 in SI units and radians. Class A: visible with all derivatives "
        "free. Class B: visible in kinematics. Class C: visible against prior values only.",
        "",
    ]
    for entry, found in rows.items():
        lines += [f"## {entry[:1].upper()}{entry[1:]}", "", *_table(head, found)]
    return _page("Effects", *lines)


def links() -> str:
    """Return the page of all kinds of links."""
    records = {"mavlink": "MAVLink frames, `raw.tlog`", "text": "lines of text, `raw.txt`"}
    rows = [
        (f"`{kind.grammar}`", f"`{kind.example}`", kind.title, records[kind.framing], kind.help)
        for kind in BUILT_IN_KINDS
    ]
    return _page(
        "Links",
        "LINK is one of these, one of an installed package ([how to add one]"
        "(../how-to/add-a-link.md)), or the path of a flight, which is played.",
        "",
        *_table(("LINK", "example", "in the connect dialog", "recorded as", "meaning"), rows),
    )


def messages() -> str:
    """Return the page of the messages that the shipped maps read, and of the errors."""
    lines: list[str] = [
        "Fields that the shipped [channel maps](files.md#channel-map) read. *Estimated* channels "
        "are computed by the autopilot. If several fields carry one channel, the lowest priority "
        "counts first.",
        "",
    ]
    for name in shipped_channel_maps():
        found = load_channel_map(name)
        head = ("source", "channel", "unit", "kind", "priority")
        rows = sorted(
            (f"`{one.source}`", f"`{one.channel}`", one.unit or "1",
             f"certificate `{one.calibration}`" if one.calibration else one.kind,
             str(one.priority))
            for one in found.entries
        )  # fmt: skip
        lines += [f"## {name}", "", *_table(head, rows)]
    kinds = [
        (f"`{kind.__name__}`", (kind.__doc__ or "").split("\n")[0])
        for kind in vars(errors).values()
        if isinstance(kind, type) and issubclass(kind, errors.GroundStationError)
    ]
    lines += [
        "## Errors", "", "Exceptions of `gsapp.foundation.errors`, all with a message for people.",
        "", *_table(("exception", "meaning"), kinds),
    ]  # fmt: skip
    return _page("Messages", *lines)


def keys() -> str:
    """Return the page of all commands of the window with their keys."""
    menus: dict[str, list[tuple[str, ...]]] = {}
    for command in COMMANDS:
        shortcuts = ", ".join(f"<kbd>{key}</kbd>" for key in command.shortcuts)
        menus.setdefault(command.menu, []).append((command.text.rstrip("…"), shortcuts))
    lines: list[str] = []
    for menu, rows in menus.items():
        lines += [f"## {menu}", "", *_table(("command", "keys"), rows)]
    return _page("Window commands and keys", *lines)


def public_functions() -> dict[str, Callable[..., Any]]:
    """Return the functions of the Python API, and the methods of what they return, by name."""
    found = {
        f"gsapp.{name}": getattr(importlib.import_module(gsapp._MODULES[name]), name)
        for name in gsapp._MODULES
    }
    for kind in API_CLASSES:
        methods = (one for one in vars(kind).items() if inspect.isfunction(one[1]))
        found |= {f"{kind.__name__}.{name}": one for name, one in methods if name.startswith("to_")}
    return found


_FLIGHT_SETTINGS = ("aircraft", "channel_map", "calibration", "as_found")
API_SETTINGS: dict[str, tuple[type[SettingsModel], tuple[str, ...]]] = {
    "gsapp.compatibility": (ManeuverSettings, (*_FLIGHT_SETTINGS, "maneuver_windows")),
    "gsapp.discrepancy": (DiscrepancySettings, tuple(DiscrepancySettings.model_fields)),
    "gsapp.estimate": (EstimateSettings, tuple(EstimateSettings.model_fields)),
    "gsapp.fly": (FlightSettings, tuple(FlightSettings.model_fields)),
    "gsapp.maneuvers": (ManeuverSettings, _FLIGHT_SETTINGS),
}
"""What the functions take as further keywords."""


def _settings(asked: tuple[type[SettingsModel], tuple[str, ...]] | tuple[()]) -> Iterator[str]:
    """Yield the table of the settings that a function takes."""
    if not asked:
        return
    model, names = asked
    rows = []
    for name in names:
        field = model.model_fields[name]
        default = field.default if field.default not in ("", (), None) else None
        shown = f"`{default!r}`" if default is not None else setting_info(field).default_text
        rows.append((f"`{name}`", shown, str(field.description)))
    yield from _table(("setting", "default", "meaning"), rows)


API_CLASSES = (Flight, Result)
"""What the functions of the Python API return."""
_SECTION = re.compile(r"^(\w[\w ]*)\n-{3,}$", re.MULTILINE)


def _docstring(function: Callable[..., Any]) -> str:
    """Return a numpydoc docstring as Markdown: sections as headings, parameters as lists."""
    text = _SECTION.sub(r"**\1**\n", (inspect.getdoc(function) or "").replace("``", "`"))
    text = re.sub(r"(?m)^(\w+) : (.+)\n    ", r"- `\1` (\2): ", text)
    text = re.sub(r"(?m)^(?!- )((?:\*\*)?\w[\w., ()]*)\n    (?=\S)", r"- `\1`: ", text)
    return re.sub(r"(?m)^    ", "  ", text)


def api() -> str:
    """Return the page of the Python API."""
    lines: list[str] = [
        "The requests and results of the [commands](commands.md), for notebooks and scripts:",
        "",
        "```python",
        "import gsapp",
        "",
        'flight = gsapp.open("flights/2026-05-12-a")',
        'flight.to_dataframe(["alpha", "q", "de"], units="us")',
        "```",
        "",
        "Data frames and data sets need pandas and xarray: `python3 packaging/bootstrap.py setup "
        "notebook`, or `pip install gsapp-ground-station[notebook]`. The names and parameters on "
        "this page are stable; other modules of the program may change. `gsapp.__version__` is "
        "the version. Notebooks: [from a log to derivatives](../notebooks/"
        "1-from-a-log-to-derivatives.ipynb), [a hidden effect named](../notebooks/"
        "2-a-hidden-effect-named.ipynb), [a campaign compared](../notebooks/"
        "3-a-campaign-compared.ipynb).",
        "",
    ]
    for name, function in public_functions().items():
        signature = re.sub(r"\bself, |\bself\b", "", str(inspect.signature(function)))
        signature = re.sub(r"(: |-> )'([^']+)'", r"\1\2", signature)
        lines += [f"## {name}", "", "```python", f"{name}{signature}", "```", ""]
        lines += [_docstring(function), ""]
        lines += _settings(API_SETTINGS.get(name, ()))
    return _page("Python API", *lines)


PAGES: dict[str, Callable[[], str]] = {
    "api.md": api,
    "channels.md": channels,
    "commands.md": commands,
    "effects.md": effects,
    "links.md": links,
    "keys.md": keys,
    "messages.md": messages,
}


def is_defined(name: str) -> bool:
    """Return whether a dotted name is a module, or what one holds."""
    module, _, attribute = name.rpartition(".")
    try:
        importlib.import_module(name)
    except ModuleNotFoundError:
        try:
            return bool(module) and hasattr(importlib.import_module(module), attribute)
        except ModuleNotFoundError:
            return False
    return True


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for page, make in PAGES.items():
        (FOLDER / page).write_text(make(), encoding="utf-8")
