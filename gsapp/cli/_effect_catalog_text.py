"""The effects that a model may lack, as tables for people."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from gsapp.cli._console import PlainConsole
    from gsapp.discrepancy.effect_catalog import EffectRecord

_HEADINGS = {
    "aero": "Aerodynamics",
    "propulsion": "Engines",
    "control": "Between command and surface",
    "sensor": "Instruments",
    "mass": "Mass properties",
    "atmosphere": "Disturbances (never named as effects)",
}
_WIDTH = 120
_CLASSES = (
    "A: observable in flight with all derivatives free.  B: observable from kinematics alone.  "
    "C: not observable in flight; requires the ground measurement.  Angles in radians, p_hat = "
    "p b/2V, q_hat = q c/2V, r_hat = r b/2V, T thrust."
)


def list_effects(json: Path | None) -> None:
    """Print the catalog, or write it for programs where asked to."""
    from gsapp.cli._console import PlainConsole, is_stdout, write_json
    from gsapp.discrepancy.effect_catalog import all_effects, effect_catalog_json

    write_json(json, effect_catalog_json())
    if not is_stdout(json):
        console = PlainConsole()
        # Into a file or a pager the columns may be as wide as they read well.
        print_catalog(console if console.is_terminal else PlainConsole(width=_WIDTH), all_effects())


def print_catalog(console: PlainConsole, records: tuple[EffectRecord, ...]) -> None:
    """Print a table for each group of effects.

    What is alike for every surface, or every channel, stands there once.
    """
    for group, heading in _HEADINGS.items():
        table = console.create_table(heading, title_style="bold", box=None, padding=(0, 2, 1, 0))
        table.add_column("effect", no_wrap=True)
        table.add_column("")
        table.add_column("effect, equation, typical size", ratio=1)
        table.add_column("mistaken for; distinguished by", ratio=1)
        for name, record in _rows([one for one in records if one.group == group]):
            title, equation = record.title, record.equation
            lines = [title, equation, _sizes(record)]
            taken = ", ".join(record.mistaken_for[:3])
            told = record.remedy or record.separated_by
            table.add_row(
                name,
                "" if record.disturbance else record.effect_class,
                "\n".join(line for line in lines if line),
                f"{taken}\n{told}" if taken else told,
            )
        console.print(table)
    named = sum(not one.disturbance for one in records)
    console.print(f"{named} effects. {_CLASSES}")


def _rows(records: list[EffectRecord]) -> Iterator[tuple[str, EffectRecord]]:
    """Yield records with the names to show; of a family only the one that stands for it."""
    from gsapp.dynamics.signal_terms import INPUT_CHANNELS, MOTION_CHANNELS, SURFACE_CHANNELS

    families = {
        "control": (tuple(SURFACE_CHANNELS), "<surface>"),
        "sensor": (MOTION_CHANNELS, "<channel>"),
        "sensor.": (INPUT_CHANNELS, "<de|da|dr|flap>"),
    }
    for record in records:
        group, name, kind = f"{record.id}.".split(".")[:3]
        for key in (group, f"{group}."):
            members, family = families.get(key, ((), ""))
            if name in members:
                if name == members[0]:
                    yield f"{group}.{family}.{kind}", record
                break
        else:
            yield record.id, record


def _sizes(record: EffectRecord) -> str:
    sizes = [
        f"{item.name} {item.default:.4g} {item.unit}".rstrip()
        for item in record.parameters
        if item.free
    ]
    return ", ".join(sizes)
