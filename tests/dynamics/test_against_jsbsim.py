"""An independent engine gives the same accelerations at one instant."""

import math
from pathlib import Path

import numpy as np
import pytest

from gsapp.dynamics.equations import Loads, RigidBody, angular_accelerations, body_rates

jsbsim = pytest.importorskip("jsbsim")

SLUG = 14.593902937206365
FT = 0.3048
LBF = 4.4482216152605
FORCE = (5.0, -7.0, -40.0)
MOMENT = (6.0, -9.0, 4.0)

AIRCRAFT = """<?xml version="1.0"?>
<fdm_config name="plate" version="2.0" release="BETA">
  <metrics>
    <wingarea unit="FT2">11.33</wingarea><wingspan unit="FT">8.92</wingspan>
    <chord unit="FT">1.41</chord>
    <location name="AERORP" unit="IN"><x>0</x><y>0</y><z>0</z></location>
    <location name="EYEPOINT" unit="IN"><x>0</x><y>0</y><z>0</z></location>
    <location name="VRP" unit="IN"><x>0</x><y>0</y><z>0</z></location>
  </metrics>
  <mass_balance negated_crossproduct_inertia="false">
    <ixx unit="SLUG*FT2">5.20</ixx><iyy unit="SLUG*FT2">6.34</iyy>
    <izz unit="SLUG*FT2">6.97</izz><ixz unit="SLUG*FT2">0.28</ixz>
    <emptywt unit="LBS">46.652</emptywt>
    <location name="CG" unit="IN"><x>0</x><y>0</y><z>0</z></location>
  </mass_balance>
  <ground_reactions/>
  <propulsion/>
  <flight_control name="none"/>
  <aerodynamics>
    {axes}
  </aerodynamics>
</fdm_config>
"""

PLANET = """<?xml version="1.0"?>
<planet name="still">
  <semimajor_axis unit="FT">20925646.32546</semimajor_axis>
  <semiminor_axis unit="FT">20925646.32546</semiminor_axis>
  <rotation_rate unit="RAD/SEC">0.0</rotation_rate>
  <GM unit="FT3/SEC2">14.0764417572E15</GM>
  <J2>0.0</J2>
</planet>
"""


def axis(name: str, value: float) -> str:
    return (
        f'<axis name="{name}"><function name="aero/{name}"><value>{value}</value></function></axis>'
    )


@pytest.fixture
def engine(tmp_path: Path) -> "jsbsim.FGFDMExec":
    forces = zip(("X", "Y", "Z"), FORCE, strict=True)
    moments = zip(("ROLL", "PITCH", "YAW"), MOMENT, strict=True)
    axes = "".join(axis(name, value) for name, value in (*forces, *moments))
    folder = tmp_path / "plate"
    folder.mkdir()
    (folder / "plate.xml").write_text(AIRCRAFT.format(axes=axes))
    (tmp_path / "planet.xml").write_text(PLANET)
    jsbsim.FGJSBBase().debug_lvl = 0
    fdm = jsbsim.FGFDMExec(str(tmp_path))
    fdm.set_debug_level(0)
    assert fdm.load_planet(str(tmp_path / "planet.xml"), False)
    assert fdm.load_model_with_paths("plate", str(tmp_path), str(tmp_path), str(tmp_path), True)
    return fdm


def test_accelerations_agree_with_jsbsim(engine: "jsbsim.FGFDMExec") -> None:
    """Translation and rotation, with Ixz, rates and attitude; JSBSim's Earth stands still."""
    phi, theta = 0.3, 0.15
    rates = (0.6, -0.4, 0.5)
    flow = (95.0, 6.0, 9.0)
    for name, value in (
        ("u-fps", flow[0]), ("v-fps", flow[1]), ("w-fps", flow[2]),
        ("p-rad_sec", rates[0]), ("q-rad_sec", rates[1]), ("r-rad_sec", rates[2]),
        ("phi-rad", phi), ("theta-rad", theta), ("psi-true-rad", 0.7), ("h-sl-ft", 1000.0),
    ):  # fmt: skip
        engine[f"ic/{name}"] = value
    assert engine.run_ic()
    found = [engine[f"accelerations/{name}dot-ft_sec2"] for name in "uvw"]
    spin = [engine[f"accelerations/{name}dot-rad_sec2"] for name in "pqr"]
    gravity = engine["accelerations/gravity-ft_sec2"] * FT
    actual = tuple(engine[f"velocities/{name}-fps"] * FT for name in "uvw")
    assert actual == pytest.approx([x * FT for x in flow])

    # JSBSim's pound has its own last digits: take its mass.
    mass = engine["inertia/mass-slugs"] * SLUG
    unit = SLUG * FT * FT
    body = RigidBody(mass=mass, ixx=5.20 * unit, iyy=6.34 * unit, izz=6.97 * unit, ixz=0.28 * unit)
    pound = SLUG * FT
    load = Loads(*(x * pound for x in FORCE), *(x * pound * FT for x in MOMENT))
    pull = (
        -gravity * math.sin(theta),
        gravity * math.cos(theta) * math.sin(phi),
        gravity * math.cos(theta) * math.cos(phi),
    )
    ours = body_rates(actual, rates, load[:3], pull, mass)
    assert np.allclose(np.array(ours) / FT, found, atol=1e-9)
    ours_spin = angular_accelerations(*rates, *load[3:], body)
    assert np.allclose(ours_spin, spin, rtol=1e-9, atol=1e-9)
    # With the cross product reversed the yaw acceleration would differ by far more.
    wrong = RigidBody(mass=mass, ixx=body.ixx, iyy=body.iyy, izz=body.izz, ixz=-body.ixz)
    assert abs(angular_accelerations(*rates, *load[3:], wrong)[2] - spin[2]) > 1e-2
