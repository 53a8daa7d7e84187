"""Maneuvers flown by JSBSim, an engine that shares no code with ours, with known derivatives.

JSBSim integrates the motion and builds the loads up from its own air data, with the derivatives of
one of our models as properties of its functions; engines push as external forces. It runs at
1 kHz; surfaces follow the pilot's inputs with the lag of the aircraft file and are put in at every
step. At 100 Hz its states and loads become what the instruments of the aircraft file show: vanes,
pitot and accelerometers where they sit (by cross products, not by our formulas), noise, zero
offsets of accelerometers, 12-bit converter, air data by way of pressures and temperature.
"""

import math
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import jsbsim
import numpy as np
from scipy.signal import lfilter

from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.decoding.air_data import density, dynamic_pressure, true_airspeed
from gsapp.dynamics.atmosphere import SEA_LEVEL_DENSITY
from gsapp.dynamics.buildup import linear_variables
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.model import Model
from gsapp.dynamics.trim import Trim, trim
from gsapp.identification import equation_error, ftr
from gsapp.identification import maximum_likelihood as ml
from gsapp.identification.axes import Axis, axis_derivatives
from gsapp.identification.filter_error import estimator as filter_error
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.results import Estimate
from gsapp.quantities import Block, FloatArray
from gsapp.quantities.constants import FOOT, GRAVITY
from tests.identification.virtual_maneuvers import NOISE, STEPS, Virtual, commands_for, varied_model

SLUG = 14.593902937206365
POUND = SLUG * FOOT
INCH = FOOT / 12.0
PSF = POUND / FOOT**2
RADIUS = 6378137.0
"""Of the Earth that stands still, m."""
SUBSTEPS = 10
"""Steps of JSBSim in one sample."""
RATE = 100.0
SETTLING = 0.2
"""Seconds that JSBSim flies before the record begins: its integrators need a past."""
MILSPEC_TURBULENCE = 3
"""JSBSim's number for it."""
ADAMS_BASHFORTH_2 = 3
"""JSBSim's number for it; by default it integrates rates of rotation by Euler."""

KINDS: Mapping[Axis, tuple[str, ...]] = {"lon": ("de",), "lat": ("da", "dr")}
STRONG: Mapping[Axis, tuple[str, ...]] = {
    "lon": ("CN_alpha", "Cm_alpha", "Cm_q", "Cm_de"),
    "lat": ("CY_beta", "Cl_beta", "Cl_p", "Cl_da", "Cn_beta", "Cn_r", "Cn_dr"),
}
"""Derivatives that rule the motion."""
METHODS: Mapping[str, Callable[[Sequence[Maneuver], Axis], Estimate]] = {
    "ee": equation_error.estimate,
    "ml": lambda maneuvers, axis: ml.estimate(maneuvers, ml.MLSettings(axis=axis)),
    "ftr": ftr.estimate,
    "fem": lambda maneuvers, axis: filter_error.estimate(maneuvers, ml.MLSettings(axis=axis)),
}
FORCES = {"CN": ("Z", -1.0), "CA": ("X", -1.0), "CY": ("Y", 1.0)}
MOMENTS = {"Cl": ("ROLL", "bw-ft"), "Cm": ("PITCH", "cbarw-ft"), "Cn": ("YAW", "bw-ft")}
SURFACES = {
    "de": "fcs/elevator-pos-rad",
    "da": "fcs/left-aileron-pos-rad",
    "dr": "fcs/rudder-pos-rad",
}
READS = {
    "alpha": ("aero/alpha-rad",),
    "beta": ("aero/beta-rad",),
    "p": ("velocities/p-aero-rad_sec", "aero/bi2vel"),
    "q": ("velocities/q-aero-rad_sec", "aero/ci2vel"),
    "r": ("velocities/r-aero-rad_sec", "aero/bi2vel"),
    **{name: (place,) for name, place in SURFACES.items()},
}
"""What each derivative multiplies, in JSBSim's properties."""

_AIRCRAFT = """<?xml version="1.0"?>
<fdm_config name="known" version="2.0" release="BETA">
  <metrics>
    <wingarea unit="M2">{area}</wingarea><wingspan unit="M">{span}</wingspan>
    <chord unit="M">{chord}</chord>
    <location name="AERORP" unit="IN"><x>0</x><y>0</y><z>0</z></location>
    <location name="EYEPOINT" unit="IN"><x>{eye[0]}</x><y>{eye[1]}</y><z>{eye[2]}</z></location>
    <location name="VRP" unit="IN"><x>0</x><y>0</y><z>0</z></location>
  </metrics>
  <mass_balance negated_crossproduct_inertia="false">
    <ixx unit="KG*M2">{ixx}</ixx><iyy unit="KG*M2">{iyy}</iyy>
    <izz unit="KG*M2">{izz}</izz><ixz unit="KG*M2">{ixz}</ixz>
    <emptywt unit="KG">{mass}</emptywt>
    <location name="CG" unit="IN"><x>0</x><y>0</y><z>0</z></location>
  </mass_balance>
  <ground_reactions/>
  <propulsion/>
  <flight_control name="none"/>
  <external_reactions>
    <property value="0">engines/throttle</property>
    {engines}
  </external_reactions>
  <aerodynamics>
    {properties}
    {axes}
  </aerodynamics>
</fdm_config>
"""
_ENGINE = """<force name="engine{number}" frame="BODY">
      <function><product>
        <property>engines/throttle</property>
        <value>{share}</value>
        <property>atmosphere/rho-slugs_ft3</property>
        <difference><value>1</value>
          <product><value>{slope}</value><property>velocities/vt-fps</property></product>
        </difference>
      </product></function>
      <location unit="IN"><x>{x}</x><y>{y}</y><z>{z}</z></location>
      <direction><x>1</x><y>0</y><z>0</z></direction>
    </force>"""
_PLANET = """<?xml version="1.0"?>
<planet name="still">
  <semimajor_axis unit="M">{radius}</semimajor_axis>
  <semiminor_axis unit="M">{radius}</semiminor_axis>
  <rotation_rate unit="RAD/SEC">0.0</rotation_rate>
  <GM unit="FT3/SEC2">{GM!r}</GM>
  <J2>0.0</J2>
</planet>
"""


def _structural(position: tuple[float, float, float]) -> tuple[float, float, float]:
    x, y, z = position
    return -x / INCH, y / INCH, -z / INCH


def _products(coefficient: str) -> str:
    terms = [f"<property>known/{coefficient}_0</property>"]
    for name in linear_variables(coefficient):
        reads = "".join(f"<property>{one}</property>" for one in READS[name])
        terms.append(f"<product><property>known/{coefficient}_{name}</property>{reads}</product>")
    return f"<sum>{''.join(terms)}</sum>"


def _axis(coefficient: str) -> str:
    pressure = "<property>aero/qbar-psf</property><property>metrics/Sw-sqft</property>"
    if coefficient in FORCES:
        axis, sign = FORCES[coefficient]
        factor = f"<value>{sign}</value>"
    else:
        axis, length = MOMENTS[coefficient]
        factor = f"<property>metrics/{length}</property>"
    product = f"<product>{pressure}{factor}{_products(coefficient)}</product>"
    return f'<axis name="{axis}"><function name="aero/{coefficient}">{product}</function></axis>'


def _engine(aircraft: Aircraft, number: int) -> str:
    engine = aircraft.propulsion
    x, y, z = _structural(engine.position[number])
    sea_level = SEA_LEVEL_DENSITY * FOOT**3 / SLUG
    share = engine.max_thrust / len(engine.position) / POUND / sea_level
    slope = FOOT / engine.zero_thrust_speed
    return _ENGINE.format(number=number, share=share, slope=slope, x=x, y=y, z=z)


class Engine:
    """JSBSim with one aircraft loaded; flies any number of maneuvers.

    Parameters
    ----------
    aircraft : Aircraft, optional
        The shipped B777 by default.
    earth : {"still", "rotating"}
        A sphere at rest with standard gravity, or JSBSim's own: WGS 84, turning.
    order : int
        Of the lag between inputs and surfaces. Of first order, surfaces start with a corner, and
        100 samples a second with straight lines between them miss 0.15 % of the moments.
    """

    def __init__(
        self, aircraft: Aircraft | None = None, *, earth: str = "still", order: int = 1
    ) -> None:
        self.aircraft, self.order = aircraft or load_aircraft("b777"), order
        jsbsim.FGJSBBase().debug_lvl = 0
        with tempfile.TemporaryDirectory() as name:
            root = Path(name)
            (root / "known").mkdir()
            (root / "known" / "known.xml").write_text(self._description(), "utf-8")
            self.fdm = jsbsim.FGFDMExec(name)
            self.fdm.set_debug_level(0)
            if earth == "still":
                pull = GRAVITY * RADIUS**2 / FOOT**3
                (root / "planet.xml").write_text(_PLANET.format(radius=RADIUS, GM=pull), "utf-8")
                assert self.fdm.load_planet(str(root / "planet.xml"), False)
            assert self.fdm.load_model_with_paths("known", name, name, name, True)
        self.fdm.set_dt(1.0 / (RATE * SUBSTEPS))
        for kind in ("rotational", "translational"):
            self.fdm[f"simulation/integrator/rate/{kind}"] = ADAMS_BASHFORTH_2
            self.fdm[f"simulation/integrator/position/{kind}"] = ADAMS_BASHFORTH_2

    def _description(self) -> str:
        aircraft, names = self.aircraft, [*FORCES, *MOMENTS]
        derivatives = [
            f"{one}_{suffix}" for one in names for suffix in ("0", *linear_variables(one))
        ]
        eye = _structural(aircraft.sensors.accelerometer.position)
        geometry, mass = aircraft.geometry, aircraft.mass
        count = len(aircraft.propulsion.position)
        return _AIRCRAFT.format(
            area=geometry.wing_area,
            span=geometry.span,
            chord=geometry.chord,
            eye=eye,
            ixx=mass.ixx,
            iyy=mass.iyy,
            izz=mass.izz,
            ixz=mass.ixz,
            mass=mass.mass,
            engines="".join(_engine(aircraft, number) for number in range(count)),
            properties="".join(
                f'<property value="0">known/{one}</property>' for one in derivatives
            ),
            axes="".join(_axis(one) for one in names),
        )

    @property
    def mass(self) -> float:
        return float(self.fdm["inertia/mass-slugs"] * SLUG)

    def start(self, model: Model, V: float, altitude: float = 300.0) -> Trim:
        """Put the aircraft in the air, trimmed by our equations in JSBSim's air; return that."""
        fdm = self.fdm
        for name in axis_derivatives("both"):
            fdm[f"known/{name}"] = model.derivative(name)
        fdm["ic/h-sl-ft"] = altitude / FOOT
        fdm["ic/lat-geod-deg"] = 39.6
        fdm["ic/psi-true-rad"] = 0.7
        assert fdm.run_ic()
        rho = fdm["atmosphere/rho-slugs_ft3"] * SLUG / FOOT**3
        found = trim(FlightModel(self.aircraft, model), V=V, rho=rho, mass=self.mass)
        state = found.polar
        fdm["ic/u-fps"] = V * math.cos(state.alpha) * math.cos(state.beta) / FOOT
        fdm["ic/v-fps"] = V * math.sin(state.beta) / FOOT
        fdm["ic/w-fps"] = V * math.sin(state.alpha) * math.cos(state.beta) / FOOT
        fdm["ic/phi-rad"], fdm["ic/theta-rad"] = state.phi, state.theta
        assert fdm.run_ic()
        return found

    def start_turbulence(self, sigma: float, seed: int) -> None:
        """Begin JSBSim's turbulence of MIL-F-8785C, rotational gusts included; sigma_w in m/s.

        The same seed gives the same gusts in an engine that has not flown yet.
        """
        self.fdm["simulation/randomseed"] = seed
        # JSBSim turns the axes of gusts by this, the other way round: let them be the aircraft's.
        self.fdm["atmosphere/psiw-rad"] = -self.fdm["attitude/psi-rad"]
        self.fdm["atmosphere/turb-type"] = MILSPEC_TURBULENCE
        # The severity counts above 2,000 ft only, but 0 is no turbulence at all.
        self.fdm["atmosphere/turbulence/milspec/severity"] = 3
        self.fdm["atmosphere/turbulence/milspec/windspeed_at_20ft_AGL-fps"] = sigma / 0.1 / FOOT

    def fly(
        self,
        found: Trim,
        commands: Mapping[str, FloatArray],
        throttle_moves: FloatArray | None = None,
    ) -> dict[str, FloatArray]:
        """Fly commanded deflections (rad, about trim, 100 Hz); return the truth, SI.

        Throttle moves, about trim, likewise, share of full. Velocities u, v, w through the air, p,
        q, r, the same against the air (``p_air`` ...), their rates, specific force at the CG and,
        as JSBSim's pilot feels it at the accelerometers, ``felt_x`` ...; attitude, air, surfaces.
        """
        fdm, controls = self.fdm, found.controls
        count = len(next(iter(commands.values())))
        ahead = round(SETTLING * RATE) * SUBSTEPS
        moved = []
        for name in SURFACES:
            command = np.repeat(commands.get(name, np.zeros(count)), SUBSTEPS)
            decay = math.exp(-1.0 / (RATE * SUBSTEPS * getattr(self.aircraft.controls, name).lag))
            for _ in range(self.order):
                command = lfilter([1.0 - decay], [1.0, -decay], command)
            moved.append(controls[name] + np.concatenate((np.zeros(ahead), command)))
        surfaces = np.column_stack(moved).tolist()
        throttle = np.full(count, controls["throttle"])
        if throttle_moves is not None:
            throttle = np.clip(throttle + throttle_moves, 0.0, 1.0)
        levers = np.concatenate((np.full(ahead, throttle[0]), np.repeat(throttle, SUBSTEPS)))
        places = tuple(SURFACES.values())
        rows = []
        for step, deflections in enumerate(surfaces):
            for place, deflection in zip(places, deflections, strict=True):
                fdm[place] = deflection
            fdm["engines/throttle"] = levers[step]
            fdm.run()
            if step >= ahead and (step - ahead) % SUBSTEPS == 0:
                rows.append([fdm[place] for place in _RECORDED])
        recorded = np.array(rows)
        table = {
            name: recorded[:, column] * unit
            for column, (name, unit) in enumerate(_RECORDED.values())
        }
        for axis in "xyz":
            table[f"f{axis}"] /= self.mass
        table["time"] = np.arange(count) / RATE
        table["throttle"] = throttle
        return table


_RECORDED: Mapping[str, tuple[str, float]] = {
    **{f"velocities/{one}-aero-fps": (one, FOOT) for one in "uvw"},
    **{f"velocities/{one}-rad_sec": (one, 1.0) for one in "pqr"},
    **{f"velocities/{one}-aero-rad_sec": (f"{one}_air", 1.0) for one in "pqr"},
    **{f"accelerations/{one}dot-rad_sec2": (f"{one}_dot", 1.0) for one in "pqr"},
    **{f"forces/fb{one}-total-lbs": (f"f{one}", POUND) for one in "xyz"},
    **{f"accelerations/a-pilot-{one}-ft_sec2": (f"felt_{one}", FOOT) for one in "xyz"},
    "attitude/phi-rad": ("phi", 1.0),
    "attitude/theta-rad": ("theta", 1.0),
    "atmosphere/rho-slugs_ft3": ("density", SLUG / FOOT**3),
    "atmosphere/P-psf": ("static_pressure", PSF),
    "atmosphere/T-R": ("temperature", 5.0 / 9.0),
    **{place: (name, 1.0) for name, place in SURFACES.items()},
}
"""JSBSim's properties that are recorded: our name, and the unit in SI."""


def fly(
    engine: Engine,
    seed: int,
    kind: Axis = "lon",
    *,
    duration: float = 10.0,
    model: Model | None = None,
    noise: float = 1.0,
    offset: float = 0.0,
    gust: float = 0.0,
) -> Virtual:
    """Fly one maneuver; speed (95 to 105 ft/s), inputs, derivatives and noise vary with the seed.

    Parameters
    ----------
    engine : Engine
    seed : int
    kind : {"lon", "lat"}
        Elevator doublets or a 3-2-1-1; aileron and rudder doublets.
    duration : float
        s.
    model : Model, optional
        The truth; the shipped one, varied, by default.
    noise : float
        Scales all noise; zero leaves the converter out too.
    offset : float
        Standard deviation of the zero offsets of the accelerometers, m/s^2.
    gust : float
        Standard deviation of the vertical gusts, m/s; the air turns, too.
    """
    random = np.random.default_rng(seed)
    truth = model or varied_model(random)
    found = engine.start(truth, V=float(random.uniform(95.0, 105.0)) * FOOT)
    if gust:
        engine.start_turbulence(gust, seed)
    else:
        engine.fdm["atmosphere/turb-type"] = 0
    times = np.arange(round(duration * RATE)) / RATE
    motion = engine.fly(found, commands_for(kind, times, random))
    shown = instruments(engine.aircraft, motion, random, noise=noise, offset=offset)
    maneuver = Maneuver(
        id=str(seed),
        flight="jsbsim",
        aircraft=engine.aircraft,
        block=Block(
            channels=tuple(shown), times=motion["time"], values=np.column_stack([*shown.values()])
        ),
        inputs=KINDS[kind],
        mass=engine.mass,
        kind="doublet",
    )
    known = {one: truth.derivative(one) for one in axis_derivatives(kind)}
    return Virtual(maneuver=maneuver, truth=known, motion=motion)


@dataclass(frozen=True, slots=True, kw_only=True)
class Errors:
    """What one method made of many maneuvers, by derivative.

    Attributes
    ----------
    over_bounds : dict of str to ndarray
        Error over the honest bound, for every maneuver that earned a number.
    errors, truths : dict of str to ndarray
        Per radian.
    withheld : int
        Numbers that were not earned.
    """

    over_bounds: dict[str, FloatArray]
    errors: dict[str, FloatArray]
    truths: dict[str, FloatArray]
    withheld: int

    def rms(self, name: str) -> float:
        return float(np.sqrt(np.mean(self.over_bounds[name] ** 2)))

    def percent(self, name: str) -> float:
        size = float(np.abs(np.mean(self.truths[name])))
        rms = float(np.sqrt(np.mean(self.errors[name] ** 2)))
        return 100.0 * rms / size if size > 0.0 else math.nan


def estimates_of(method: str, flown: Sequence[Virtual], axis: Axis) -> list[Estimate]:
    return [METHODS[method]([one.maneuver], axis) for one in flown]


def errors_of(estimates: Sequence[Estimate], flown: Sequence[Virtual]) -> Errors:
    """Compare estimates from single maneuvers with what is true of those."""
    found: dict[str, list[tuple[float, float, float]]] = {}
    withheld = 0
    for estimate, one in zip(estimates, flown, strict=True):
        for name, true in one.truth.items():
            derivative = estimate.derivatives[name]
            if derivative.value is None or derivative.std is None:
                withheld += 1
                continue
            found.setdefault(name, []).append((derivative.value - true, derivative.std, true))
    tables = {name: np.array(rows) for name, rows in found.items()}
    return Errors(
        over_bounds={name: table[:, 0] / table[:, 1] for name, table in tables.items()},
        errors={name: table[:, 0] for name, table in tables.items()},
        truths={name: table[:, 2] for name, table in tables.items()},
        withheld=withheld,
    )


def exposures(aircraft: Aircraft, motion: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    """Return what the instruments are exposed to where they sit, SI."""
    sensors = aircraft.sensors
    flow = np.column_stack([motion[one] for one in "uvw"])
    rates = np.column_stack([motion[one] for one in "pqr"])
    through_air = np.column_stack([motion[f"{one}_air"] for one in "pqr"])
    spin = np.column_stack([motion[f"{one}_dot"] for one in "pqr"])
    force = np.column_stack([motion[f"f{one}"] for one in "xyz"])

    def local(position: tuple[float, float, float]) -> FloatArray:
        return flow + np.cross(through_air, np.array(position))

    arm = np.array(sensors.accelerometer.position)
    felt = force + np.cross(spin, arm) + np.cross(rates, np.cross(rates, arm))
    vane, fin = local(sensors.alpha_vane.position), local(sensors.beta_vane.position)
    pitot = np.linalg.norm(local(sensors.air_data.position), axis=1)
    return {
        "alpha": sensors.alpha_vane.upwash * np.arctan2(vane[:, 2], vane[:, 0]),
        "beta": sensors.beta_vane.upwash * np.arctan2(fin[:, 1], fin[:, 0]),
        **{name: motion[name] for name in ("p", "q", "r")},
        "ax": felt[:, 0],
        "ay": felt[:, 1],
        "an": -felt[:, 2],
        **{name: motion[name] for name in ("phi", "theta", *SURFACES)},
        "dynamic_pressure": dynamic_pressure(pitot, motion["density"]),
        "static_pressure": motion["static_pressure"],
    }


def instruments(
    aircraft: Aircraft,
    motion: Mapping[str, FloatArray],
    random: np.random.Generator,
    *,
    noise: float = 1.0,
    offset: float = 0.0,
) -> dict[str, FloatArray]:
    """Return what the instruments show of a motion, and the air data that follow, SI."""
    sensors, exposed = aircraft.sensors, exposures(aircraft, motion)
    sizes = {
        **NOISE,
        "dynamic_pressure": sensors.air_data.noise,
        "static_pressure": sensors.air_data.static_noise,
    }
    low, high = sensors.air_data.range
    still, full = sensors.air_data.static_range
    steps = {
        **STEPS,
        "dynamic_pressure": (high - low) / 4096,
        "static_pressure": (full - still) / 4096,
    }
    count = len(motion["time"])
    shown = {}
    for name, values in exposed.items():
        error = sizes[name] * random.standard_normal(count)
        if name in ("ax", "ay", "an"):
            error = error + offset * random.standard_normal()
        found = values + noise * error
        step = steps.get(name, 0.0) if noise else 0.0
        shown[name] = np.round(found / step) * step if step else found
    # One thermometer at the field: the mean of what JSBSim's air had.
    shown["temperature"] = np.full(count, float(motion["temperature"].mean()))
    shown["density"] = density(shown["static_pressure"], shown["temperature"])
    shown["qbar"] = shown["dynamic_pressure"]
    shown["V"] = true_airspeed(shown["dynamic_pressure"], shown["density"])
    shown["throttle"] = motion["throttle"]
    return shown
