"""What the dialogs can offer: shipped files, serial ports, effects of the virtual aircraft."""

from __future__ import annotations

from calibration import shipped_sets
from gsapp.aircraft import load_aircraft
from gsapp.aircraft.reading import shipped_aircraft
from gsapp.decoding.channel_map import load_channel_map, shipped_channel_maps
from gsapp.foundation import GroundStationError
from gsapp.telemetry.address import parse_link
from gsapp.telemetry.sources.serial_port import plugged_in, port_words
from ui.dialogs.connect import ConnectChoices
from ui.dialogs.virtual import VirtualChoices

_USUAL_PLAN = "default"
_VIRTUAL_AIRCRAFT = "b777"


def serial_ports() -> tuple[tuple[str, str], ...]:
    """Return path of each serial port, and its name with that of its USB device."""
    return tuple(sorted((port.device, port_words(port)) for port in plugged_in()))


def live_maps() -> tuple[str, ...]:
    """Return the shipped channel maps for what comes over a link."""
    return tuple(
        name for name in shipped_channel_maps() if load_channel_map(name).format == "mavlink"
    )


def connect_choices() -> ConnectChoices:
    """Return what can be chosen when connecting."""
    return ConnectChoices(
        aircraft=shipped_aircraft(),
        channel_maps=live_maps(),
        calibrations=shipped_sets(),
        parse=parse_link,
        list_ports=serial_ports,
    )


def virtual_choices() -> VirtualChoices:
    """Return what can be chosen for the virtual aircraft."""
    # With their modules the window would start a quarter of a second later.
    from gsapp.dynamics.pilot.plan import SHIPPED as PLANS

    plans = sorted(PLANS.names(), key=lambda name: (name != _USUAL_PLAN, name))
    return VirtualChoices(plans=tuple(plans), effects=hidden_effects)


def hidden_effects() -> tuple[tuple[str, str], ...]:
    """Return id and title of the effects that can be hidden in the virtual aircraft."""
    from gsapp.dynamics.terms import effect_ids, make_term

    aircraft = load_aircraft(_VIRTUAL_AIRCRAFT)
    found = []
    for name in effect_ids():
        try:
            found.append((name, make_term(name, aircraft).title))
        except GroundStationError:
            # Needs something that this aircraft lacks.
            continue
    return tuple(found)
