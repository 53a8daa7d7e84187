"""The B777 as JSBSim reads it, with effects built into its functions that no model file holds.

With an `airframe` the coefficients are not ours at all: a model of the B777's size and mass flies
with the aerodynamics of another aircraft as JSBSim ships it, kinks and tables included.

Nothing here is shared with the effects of `gsapp.dynamics`: each hidden effect is written once
more, as XML for JSBSim. Sizes are properties ``hidden/<place>``, zero unless set; derivatives are
``known/<name>``. Axes and signs are those of the notes, section 3.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import jsbsim

from gsapp.aircraft import Aircraft

FOOT = 0.3048
INCH = FOOT / 12.0
POUND = 4.4482216152605
SLUG = POUND / FOOT
PSF = POUND / FOOT**2
GRAVITY = 9.80665
EARTH_RADIUS = 6378137.0
ALTITUDE = 300.0
SEA_LEVEL_DENSITY = 1.225
REFERENCE_SPEED = 28.956
"""Where speed terms are zero, m/s (95 ft/s)."""

LINEAR: Mapping[str, tuple[str, ...]] = {
    **dict.fromkeys(("CN", "CA", "Cm"), ("alpha", "q", "de")),
    **dict.fromkeys(("CY", "Cl", "Cn"), ("beta", "p", "r", "da", "dr")),
}
"""The linear build-up: what each coefficient is proportional to."""
DERIVATIVES = tuple(
    f"{coefficient}_{name}" for coefficient, names in LINEAR.items() for name in ("0", *names)
)
_AXES = {
    "CN": ("Z", "<value>-1</value>"),
    "CA": ("X", "<value>-1</value>"),
    "CY": ("Y", "<value>1</value>"),
    "Cl": ("ROLL", "<property>metrics/bw-ft</property>"),
    "Cm": ("PITCH", "<property>metrics/cbarw-ft</property>"),
    "Cn": ("YAW", "<property>metrics/bw-ft</property>"),
}

SURFACES = {
    "de": "fcs/elevator-pos-rad",
    "da": "fcs/left-aileron-pos-rad",
    "dr": "fcs/rudder-pos-rad",
    "flap": "fcs/flap-pos-rad",
}
_ALPHA = "<property>aero/alpha-rad</property>"
_BETA = "<property>aero/beta-rad</property>"
_DE, _DA, _DR, _FLAP = (f"<property>{place}</property>" for place in SURFACES.values())


def _hat(rate: str, half_length: str) -> str:
    return (
        f"<product><property>velocities/{rate}-aero-rad_sec</property>"
        f"<property>aero/{half_length}</property></product>"
    )


_P, _Q, _R = _hat("p", "bi2vel"), _hat("q", "ci2vel"), _hat("r", "bi2vel")
_ALPHA_DOT = (
    "<product><property>aero/alphadot-rad_sec</property><property>aero/ci2vel</property></product>"
)
_SPEED = (
    f"<difference><product><property>velocities/vt-fps</property>"
    f"<value>{FOOT / REFERENCE_SPEED!r}</value></product><value>1</value></difference>"
)
_READS = {
    "alpha": _ALPHA, "beta": _BETA, "p": _P, "q": _Q, "r": _R, "de": _DE, "da": _DA, "dr": _DR,
}  # fmt: skip


def _power(x: str, exponent: int) -> str:
    return "".join([x] * exponent)


def _magnitude(x: str) -> str:
    return f"<abs>{x}</abs>"


def _tanh(x: str, width: float) -> str:
    twice = f"<product><value>{2.0 / width!r}</value>{x}</product>"
    falls = f"<quotient><value>2</value><sum><exp>{twice}</exp><value>1</value></sum></quotient>"
    return f"<difference><value>1</value>{falls}</difference>"


@dataclass(frozen=True, slots=True, kw_only=True)
class AirEffect:
    """An effect on a coefficient."""

    coefficient: str  # CN, CA, CY, Cl, Cm, Cn, or CX, CZ.
    factors: str  # JSBSim's XML of what the size is multiplied by.
    typical: float  # A size from which scaling starts.


AIR: Mapping[str, AirEffect] = {
    name: AirEffect(coefficient=name.split(".")[1], factors=factors, typical=typical)
    for name, factors, typical in (
        ("aero.Cm.alpha2", _power(_ALPHA, 2), -2.0),
        ("aero.CN.alpha2", _power(_ALPHA, 2), 5.0),
        ("aero.CA.alpha2", _power(_ALPHA, 2), 1.0),
        ("aero.Cm.alphadot", _ALPHA_DOT, -6.0),
        ("aero.Cm.beta2", _power(_BETA, 2), -0.5),
        ("aero.CX.speed", _SPEED, 0.02),
        ("aero.CZ.speed", _SPEED, -0.10),
        ("aero.Cm.speed", _SPEED, 0.03),
        ("aero.Cl.alpha_beta", _ALPHA + _BETA, -1.0),
        ("aero.Cn.alpha_beta", _ALPHA + _BETA, 0.5),
        ("aero.Cn.beta3", _power(_BETA, 3), 1.0),
        ("aero.Cl.beta3", _power(_BETA, 3), 1.5),
        ("aero.Cm.de3", _power(_DE, 3), 6.0),
        ("aero.Cl.da3", _power(_DA, 3), -1.5),
        ("aero.Cn.dr3", _power(_DR, 3), 0.1),
        ("aero.Cm.alpha_de", _ALPHA + _DE, 1.5),
        ("aero.Cl.alpha_da", _ALPHA + _DA, -0.7),
        ("aero.Cn.alpha_dr", _ALPHA + _DR, 0.1),
        ("aero.Cm.alpha_q", _ALPHA + _Q, 60.0),
        ("aero.Cl.alpha_p", _ALPHA + _P, 2.0),
        ("aero.Cn.alpha_r", _ALPHA + _R, -1.0),
        ("aero.Cm.flap", _FLAP, -0.03),
        ("aero.CN.flap", _FLAP, 0.2),
        ("aero.CA.flap", _FLAP, 0.03),
        ("aero.Cl.alpha", _ALPHA, 0.02),
        ("outside.Cm.alpha3", _power(_ALPHA, 3), -10.0),
        ("outside.CN.alpha3", _power(_ALPHA, 3), -30.0),
        ("outside.Cm.alpha_de2", _ALPHA + _power(_DE, 2), 15.0),
        ("outside.Cm.de_deadzone", _tanh(_DE, 0.015), 0.006),
        ("outside.Cl.da_abs_beta", _DA + _magnitude(_BETA), -0.8),
        ("aero.Cn.q", _Q, 0.5),
        ("aero.Cl.q", _Q, 0.8),
        ("outside.CN.p2", _power(_P, 2), 3.0),
        ("outside.Cm.p2", _power(_P, 2), -1.0),
        ("outside.Cm.r2", _power(_R, 2), -8.0),
        ("outside.Cn.da_de", _DA + _DE, 0.3),
        ("outside.Cl.beta_de", _BETA + _DE, 0.6),
        ("aero.CY.alpha_r", _ALPHA + _R, 3.0),
        ("outside.Cm.abs_q_q", _Q + _magnitude(_Q), -300.0),
        ("aero.CN.beta2", _power(_BETA, 2), -1.0),
        ("outside.Cn.memory", "<property>memory/q</property>", 0.003),
        ("outside.CN.memory_q", "<property>memory/q</property>", 0.05),
    )
}
"""Effects of the air, by id; ids ``outside.*`` are in no catalog."""

STALL: Mapping[str, AirEffect] = {
    f"aero.{coefficient}.stall": AirEffect(
        coefficient=coefficient, factors=factors, typical=typical
    )
    for coefficient, factors, typical in (
        ("CN", _ALPHA + "<property>stall/lost-lift</property>", -4.6),
        ("CA", "<property>stall/separated</property>", 0.1),
        ("Cm", "<property>stall/separated</property>", -0.15),
    )
}
"""Effects of separated flow, which the plan of the benchmark does not reach."""
_ON_COEFFICIENTS = {**AIR, **STALL}

PROPULSION: Mapping[str, float] = {
    "propulsion.Cm.throttle": 0.01,
    "propulsion.Cn.asymmetry": 0.03,
    "propulsion.thrust.scale": -0.06,
}
"""Id: a size from which scaling starts; meters of arm, share, share."""


def place_of(effect: str) -> str:
    return "hidden/" + effect.replace(".", "-")


def _with_size(effect: str) -> str:
    one = _ON_COEFFICIENTS[effect]
    sign = "<value>-1</value>" if one.coefficient in ("CX", "CZ") else ""
    return f"<product>{sign}<property>{place_of(effect)}</property>{one.factors}</product>"


def _axis(coefficient: str, effects: Sequence[str]) -> str:
    terms = [f"<property>known/{coefficient}_0</property>"]
    terms += [
        f"<product><property>known/{coefficient}_{name}</property>{_READS[name]}</product>"
        for name in LINEAR[coefficient]
    ]
    same = {"CX": "CA", "CZ": "CN"}
    for effect in effects:
        if effect in _ON_COEFFICIENTS:
            target = _ON_COEFFICIENTS[effect].coefficient
            if same.get(target, target) == coefficient:
                terms.append(_with_size(effect))
    axis, factor = _AXES[coefficient]
    pressure = "<property>aero/qbar-psf</property><property>metrics/Sw-sqft</property>"
    product = f"<product>{pressure}{factor}<sum>{''.join(terms)}</sum></product>"
    function = f'<function name="aero/{coefficient}">{product}</function>'
    return f'<axis name="{axis}">{function}</axis>'


_DIRECTIONS = {
    "CN": ("force", 1.0, (0, 0, -1)),
    "CA": ("force", 1.0, (-1, 0, 0)),
    "CY": ("force", 1.0, (0, 1, 0)),
    "Cl": ("moment", "metrics/bw-ft", (1, 0, 0)),
    "Cm": ("moment", "metrics/cbarw-ft", (0, 1, 0)),
    "Cn": ("moment", "metrics/bw-ft", (0, 0, 1)),
}


def _applied(effect: str) -> str:
    """Return an effect of the air as a force or moment beside another aircraft's aerodynamics."""
    target = {"CX": "CA", "CZ": "CN"}.get(AIR[effect].coefficient, AIR[effect].coefficient)
    kind, length, (x, y, z) = _DIRECTIONS[target]
    arm = f"<property>{length}</property>" if isinstance(length, str) else ""
    where = '<location unit="IN"><x>0</x><y>0</y><z>0</z></location>' if kind == "force" else ""
    return f"""<{kind} name="{effect.replace(".", "-")}" frame="BODY">
      <function><product><property>aero/qbar-psf</property><property>metrics/Sw-sqft</property>
        {arm}{_with_size(effect)}</product></function>{where}
      <direction><x>{x}</x><y>{y}</y><z>{z}</z></direction></{kind}>"""


def _thrust_pitch() -> str:
    """Return the moment of thrust beside the center of gravity."""
    return f"""<moment name="thrust-pitch" frame="BODY"><function><product>
        <property>{place_of("propulsion.Cm.throttle")}</property><value>{1.0 / FOOT!r}</value>
        <property>engines/thrust-lbs</property></product></function>
      <direction><x>0</x><y>1</y><z>0</z></direction></moment>"""


def _shipped_aerodynamics(airframe: str) -> str:
    """Return the coefficients of an aircraft that JSBSim ships."""
    root = Path(jsbsim.get_default_root_dir()) / "aircraft" / airframe / f"{airframe}.xml"
    text = root.read_text("utf-8")
    return text[text.index("<aerodynamics>") : text.index("</aerodynamics>")].partition(">")[2]


_FLAP_FOLLOWS = f"""<flight_control name="none"><channel name="flap">
  <fcs_function name="flap"><function><product>
    <property>fcs/flap-pos-rad</property><value>{1.0 / 0.698!r}</value></product></function>
    <output>fcs/flap-pos-norm</output></fcs_function>
</channel></flight_control>"""
"""Flap position of shipped aircraft: 1 at 40 deg."""


_SLIPSTREAM = "propulsion/engine/prop-induced-velocity_fps"
"""Read by aircraft with a propeller; ours has none, so that it blows nowhere."""


def structural(position: tuple[float, float, float]) -> tuple[float, float, float]:
    x, y, z = position
    return -x / INCH, y / INCH, -z / INCH


def _thrust(aircraft: Aircraft) -> str:
    engine = aircraft.propulsion
    scale = engine.max_thrust / POUND / (SEA_LEVEL_DENSITY * FOOT**3 / SLUG)
    more = place_of("propulsion.thrust.scale")
    return f"""<product>
      <property>engines/throttle</property><value>{scale!r}</value>
      <property>atmosphere/rho-slugs_ft3</property>
      <difference><value>1</value><product>
        <value>{FOOT / engine.zero_thrust_speed!r}</value><property>velocities/vt-fps</property>
      </product></difference>
      <sum><value>1</value><property>{more}</property></sum></product>"""


def _engine(aircraft: Aircraft, number: int) -> str:
    positions = aircraft.propulsion.position
    x, y, z = structural(positions[number])
    side = -1.0 if positions[number][1] > 0.0 else 1.0
    uneven = place_of("propulsion.Cn.asymmetry")
    return f"""<force name="engine{number}" frame="BODY">
      <function><product><value>{1.0 / len(positions)!r}</value>
        <sum><value>1</value>
          <product><value>{side}</value><property>{uneven}</property></product></sum>
        {_thrust(aircraft)}</product></function>
      <location unit="IN"><x>{x}</x><y>{y}</y><z>{z}</z></location>
      <direction><x>1</x><y>0</y><z>0</z></direction>
    </force>"""


def aircraft_xml(aircraft: Aircraft, effects: Sequence[str], airframe: str = "") -> str:
    """Return JSBSim's description of an aircraft with these effects (of `AIR`, `PROPULSION`)."""
    geometry, mass = aircraft.geometry, aircraft.mass
    engines = "".join(_engine(aircraft, k) for k in range(len(aircraft.propulsion.position)))
    places = [f"known/{one}" for one in DERIVATIVES] + ["memory/q"]
    if not STALL.keys().isdisjoint(effects):
        places += ["stall/lost-lift", "stall/separated"]
    places += [place_of(one) for one in dict.fromkeys((*PROPULSION, *effects))]
    places += [_SLIPSTREAM] if airframe else []
    properties = "".join(f'<property value="0">{one}</property>' for one in places)
    axes = (
        _shipped_aerodynamics(airframe)
        if airframe
        else "".join(_axis(one, effects) for one in LINEAR)
    )
    applied = "".join(_applied(one) for one in effects if airframe and one in AIR)
    applied += _thrust_pitch() if "propulsion.Cm.throttle" in effects else ""
    dry = mass.mass - mass.fuel
    return f"""<?xml version="1.0"?>
<fdm_config name="hidden" version="2.0" release="BETA">
  <metrics>
    <wingarea unit="M2">{geometry.wing_area!r}</wingarea>
    <wingspan unit="M">{geometry.span!r}</wingspan>
    <chord unit="M">{geometry.chord!r}</chord>
    <location name="AERORP" unit="IN"><x>0</x><y>0</y><z>0</z></location>
    <location name="EYEPOINT" unit="IN"><x>0</x><y>0</y><z>0</z></location>
    <location name="VRP" unit="IN"><x>0</x><y>0</y><z>0</z></location>
  </metrics>
  <mass_balance negated_crossproduct_inertia="false">
    <ixx unit="KG*M2">{mass.ixx!r}</ixx><iyy unit="KG*M2">{mass.iyy!r}</iyy>
    <izz unit="KG*M2">{mass.izz!r}</izz><ixz unit="KG*M2">{mass.ixz!r}</ixz>
    <emptywt unit="KG">{dry!r}</emptywt>
    <location name="CG" unit="IN"><x>0</x><y>0</y><z>0</z></location>
    <pointmass name="fuel"><weight unit="KG">{mass.fuel!r}</weight>
      <location unit="IN"><x>0</x><y>0</y><z>0</z></location></pointmass>
  </mass_balance>
  <ground_reactions/>
  <propulsion/>
  {_FLAP_FOLLOWS if airframe else '<flight_control name="none"/>'}
  <external_reactions>
    <property value="0">engines/throttle</property>
    {properties}
    {engines}{applied}
  </external_reactions>
  <aerodynamics>
    <function name="engines/thrust-lbs">{_thrust(aircraft)}</function>
    {axes}
  </aerodynamics>
</fdm_config>
"""


def planet_xml() -> str:
    pull = GRAVITY * (EARTH_RADIUS + ALTITUDE) ** 2 / FOOT**3
    return f"""<?xml version="1.0"?>
<planet name="still">
  <semimajor_axis unit="M">{EARTH_RADIUS!r}</semimajor_axis>
  <semiminor_axis unit="M">{EARTH_RADIUS!r}</semiminor_axis>
  <rotation_rate unit="RAD/SEC">0.0</rotation_rate>
  <GM unit="FT3/SEC2">{pull!r}</GM>
  <J2>0.0</J2>
</planet>
"""


def write_aircraft(
    folder: Path, aircraft: Aircraft, effects: Sequence[str], airframe: str = ""
) -> None:
    (folder / "hidden").mkdir(exist_ok=True)
    text = aircraft_xml(aircraft, effects, airframe)
    (folder / "hidden" / "hidden.xml").write_text(text, "utf-8")
    (folder / "planet.xml").write_text(planet_xml(), "utf-8")
