"""What the dialogs can offer: shipped files, serial ports, effects of the virtual aircraft."""

from __future__ import annotations

from calibration import shipped_certificate_sets
from gsapp.aircraft import load_aircraft
from gsapp.aircraft.aircraft_loader import shipped_aircraft
from gsapp.decoding.channel_map import load_channel_map, shipped_channel_maps
from gsapp.foundation import GroundStationError
from gsapp.telemetry.link_kinds import describe_port, list_serial_ports
from gsapp.telemetry.link_registry import parse_link
from ui.dialogs.connect import ConnectionOptions
from ui.dialogs.virtual_flight import VirtualFlightOptions

_USUAL_PLAN = "default"
_VIRTUAL_AIRCRAFT = "b777"


def named_serial_ports() -> tuple[tuple[str, str], ...]:
    """Return path of each serial port, and its name with that of its USB device."""
    return tuple(sorted((port.device, describe_port(port)) for port in list_serial_ports()))


def mavlink_channel_maps() -> tuple[str, ...]:
    """Return the shipped channel maps for what comes over a link."""
    return tuple(
        name for name in shipped_channel_maps() if load_channel_map(name).format == "mavlink"
    )


def connection_options() -> ConnectionOptions:
    """Return what can be chosen when connecting."""
    return ConnectionOptions(
        aircraft=shipped_aircraft(),
        channel_maps=mavlink_channel_maps(),
        calibrations=shipped_certificate_sets(),
        parse=parse_link,
        list_ports=named_serial_ports,
    )


def virtual_flight_options() -> VirtualFlightOptions:
    """Return what can be chosen for the virtual aircraft."""
    # With their modules the window would start a quarter of a second later.
    from gsapp.virtual.flight_plan import SHIPPED_PLANS as PLANS

    plans = sorted(PLANS.names(), key=lambda name: (name != _USUAL_PLAN, name))
    return VirtualFlightOptions(plans=tuple(plans), effects=list_hidden_effects)


def list_hidden_effects() -> tuple[tuple[str, str], ...]:
    """Return id and title of the effects that can be hidden in the virtual aircraft."""
    from gsapp.dynamics.terms import create_term, effect_ids

    aircraft = load_aircraft(_VIRTUAL_AIRCRAFT)
    found = []
    for name in effect_ids():
        try:
            found.append((name, create_term(name, aircraft).title))
        except GroundStationError:
            # Needs something that this aircraft lacks.
            continue
    return tuple(found)
