"""Pictures of the window in flight: three themes, two sizes, two scales."""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path

THEMES = ("daylight", "dark", "high-contrast")
SIZES = ((1280, 800), (2560, 1600))
SCALES = (100, 200)


def main(*arguments: str) -> None:
    """Write all pictures into the folder named, or into ``bench-window``."""
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    from ui.screenshot import photograph, write_virtual_flight

    named = [argument for argument in arguments if not argument.startswith("-")]
    folder = Path(named[0] if named else "bench-window")
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        flight = write_virtual_flight(Path(scratch))
        for theme in THEMES:
            for width, height in SIZES:
                for scale in SCALES:
                    name = f"flight-{theme}-{width}x{height}-{scale}.png"
                    photograph(
                        flight, folder / name, theme=theme, scale=scale, size=(width, height)
                    )
                    print(folder / name)


if __name__ == "__main__":
    main(*sys.argv[1:])
