"""The catalog of effects: complete, consistent, true of the equations, extended by packages."""

from __future__ import annotations

import io
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.cli._console import PlainConsole
from gsapp.cli._effect_catalog_text import list_effects, print_catalog
from gsapp.discrepancy.effect_catalog import (
    TURBULENCE,
    all_effects,
    effect_catalog_json,
    eligible_effects,
    excluded_effects,
    find_effect,
)
from gsapp.dynamics.buildup import derivative_names
from gsapp.dynamics.flight_model import MODEL_INPUTS, FlightModel
from gsapp.dynamics.model import load_model
from gsapp.dynamics.sensors import OutputModel
from gsapp.dynamics.terms import TARGETS, create_term, effect_ids
from gsapp.foundation import UnknownNameError
from gsapp.quantities import channel

B777 = load_aircraft("b777")
BASE = load_model("b777")
IDS = [one.id for one in all_effects()]
EFFECTS = [one for one in all_effects() if not one.disturbance]
RECORDED = (
    "alpha", "beta", "p", "q", "r", "ax", "ay", "an", "V", "qbar", "altitude", "phi", "theta",
    "psi", "de", "da", "dr", "throttle", "flap",
)  # fmt: skip

# What was asked for, in the words of those who asked.
ASKED = {
    "any missing linear derivative": [f"aero.{name.replace('_', '.')}" for name in
                                      derivative_names() if not name.endswith("_0")],
    "C_m, C_N, C_A in alpha^2": ["aero.Cm.alpha2", "aero.CN.alpha2", "aero.CA.alpha2"],
    "alpha-dot": ["aero.Cm.alphadot"],
    "C_m in beta^2": ["aero.Cm.beta2"],
    "speed terms": ["aero.CX.speed", "aero.CZ.speed", "aero.Cm.speed"],
    "C_l beta and C_n beta with alpha": ["aero.Cl.alpha_beta", "aero.Cn.alpha_beta"],
    "cubic C_n, C_l in beta": ["aero.Cn.beta3", "aero.Cl.beta3"],
    "effectiveness at large deflection": ["aero.Cm.de3", "aero.Cl.da3", "aero.Cn.dr3",
                                          "aero.Cm.de_falloff", "aero.Cl.da_falloff",
                                          "aero.Cn.dr_falloff"],
    "effectiveness with alpha": ["aero.Cm.alpha_de", "aero.CN.alpha_de", "aero.Cl.alpha_da",
                                 "aero.Cn.alpha_dr", "aero.Cn.alpha_da", "aero.CY.alpha_dr"],
    "damping with alpha": ["aero.Cm.alpha_q", "aero.Cl.alpha_p", "aero.Cn.alpha_r",
                           "aero.Cl.alpha_r", "aero.Cn.alpha_p"],
    "flap": ["aero.Cm.flap", "aero.CN.flap", "aero.CA.flap"],
    "left and right wing": ["aero.Cl.alpha"],
    "propulsion": ["propulsion.Cm.throttle", "propulsion.Cn.asymmetry",
                   "propulsion.thrust.scale"],
    "control path": [f"control.{surface}.{kind}" for surface in ("elevator", "aileron", "rudder")
                     for kind in ("backlash", "lag", "rate", "delay", "gearing")],
    "instruments": [*(f"sensor.{name}.{kind}" for name in ("alpha", "beta", "V", "p", "q", "r",
                                                           "ax", "ay", "an", "phi", "theta")
                      for kind in ("scale", "bias", "delay", "lag", "clipping", "reversed")),
                    "sensor.accelerometer.x", "sensor.alpha_vane.x", "sensor.beta_vane.x",
                    "sensor.p_r.swapped", "sensor.airdata.delay", "sensor.surfaces.delay",
                    "sensor.de.delay", "sensor.da.scale", "sensor.dr.bias"],
    "mass": ["mass.cg.x", "mass.cg.z", "mass.mass.error", "mass.inertia.ixz", "mass.inertia.ixx",
             "mass.inertia.iyy", "mass.inertia.izz"],
    "atmosphere": ["atmosphere.turbulence"],
}  # fmt: skip


def aircraft_with(**kinds: str) -> Aircraft:
    controls = B777.controls
    changed = {
        name: getattr(controls, name).model_copy(update={"kind": kind})
        for name, kind in kinds.items()
    }
    return B777.model_copy(update={"controls": controls.model_copy(update=changed)})


# --- what it holds ------------------------------------------------------------------------------


def test_every_effect_that_a_model_can_have_has_a_record() -> None:
    assert [*effect_ids(), "atmosphere.turbulence"] == IDS
    assert len(set(IDS)) == len(IDS)


@pytest.mark.parametrize("words", ASKED)
def test_what_was_asked_for_is_there(words: str) -> None:
    assert not set(ASKED[words]) - set(IDS)


@pytest.mark.parametrize("one", EFFECTS, ids=lambda one: one.id)
def test_a_record_is_complete(one) -> None:
    term = create_term(one.id, B777)
    assert (one.title, one.equation, one.target) == (term.title, term.equation, term.target)
    assert one.parameters == term.parameters
    assert one.separated_by
    assert one.source
    assert one.id not in one.mistaken_for
    assert set(one.mistaken_for) <= set(IDS)
    assert len(set(one.mistaken_for)) == len(one.mistaken_for)
    assert bool(one.remedy) == (one.effect_class == "C")
    for name in one.needs:
        assert channel(name).id == name
    if one.derivative:
        assert one.derivative in derivative_names()
    if one.variant_of:
        assert not find_effect(one.variant_of).variant_of
    entry = {
        "aero": "coefficient",
        "propulsion": "propulsion",
        "control": "control path",
        "sensor": "instrument",
        "mass": "mass",
    }
    assert one.entry == entry[one.group]


def test_an_effect_has_an_alias_to_beware_of() -> None:
    without = [one.id for one in EFFECTS if not one.mistaken_for]
    assert without == ["control.flap.gearing"]


def test_inputs_that_an_effect_reads_must_be_recorded() -> None:
    for one in EFFECTS:
        term = create_term(one.id, B777)
        reads = {"thrust": "throttle"}
        inputs = {reads.get(name, name) for name in term.reads}
        inputs &= {"de", "da", "dr", "flap", "throttle"}
        assert inputs <= set(one.needs), one.id


def test_gusts_are_a_disturbance_and_never_compete() -> None:
    assert TURBULENCE.disturbance
    assert find_effect("atmosphere.turbulence") is TURBULENCE
    assert [one for one in all_effects() if one.disturbance] == [TURBULENCE]
    for variants in (False, True):
        found = eligible_effects(B777, RECORDED, variants=variants)
        assert TURBULENCE not in found
    assert "disturbance" in excluded_effects(B777, RECORDED)[TURBULENCE.id]


def test_an_unknown_effect_is_named_with_its_neighbors() -> None:
    with pytest.raises(UnknownNameError, match=r"aero\.Cm\.alpha2"):
        find_effect("aero.Cm.alfa2")


# --- sizes --------------------------------------------------------------------------------------


def test_plausible_sizes_go_with_the_aircraft() -> None:
    heavy = B777.model_copy(
        update={"mass": B777.mass.model_copy(update={"mass": 2.0 * B777.mass.mass})}
    )
    small, large = (create_term("mass.mass.error", one).defaults["error"] for one in (B777, heavy))
    assert large == pytest.approx(2.0 * small)
    assert abs(small) == pytest.approx(0.05 * B777.mass.mass)
    slop = "control.elevator.backlash"
    one, other = (create_term(slop, plane).defaults for plane in (B777, heavy))
    assert one == other == {"slop": 0.02}
    assert set(create_term("aero.Cm.speed", B777).defaults) == {"Cm_V", "V_ref"}


def test_a_plausible_size_differs_from_none() -> None:
    for one in EFFECTS:
        free = [item for item in one.parameters if item.free]
        assert not free or free[0].default != free[0].neutral, one.id


# --- who competes -------------------------------------------------------------------------------


def of_path(aircraft: Aircraft, surface: str) -> set[str]:
    prefix = f"control.{surface}."
    return {
        one.id.removeprefix(prefix)
        for one in eligible_effects(aircraft, RECORDED)
        if one.id.startswith(prefix)
    }


@pytest.mark.parametrize(
    ("kind", "expected"),
    [
        ("position", set()),
        ("servo", {"backlash", "saturation"}),
        ("command", {"backlash", "saturation", "lag", "rate", "delay"}),
    ],
)
def test_control_paths_compete_where_the_record_allows(kind: str, expected: set[str]) -> None:
    aircraft = aircraft_with(de=kind)
    assert of_path(aircraft, "elevator") == expected
    assert of_path(aircraft, "aileron") == set()
    ids = {one.id for one in eligible_effects(aircraft, RECORDED)}
    # A potentiometer can be late; a command has none.
    assert ("sensor.de.delay" in ids) == (kind != "command")
    reasons = excluded_effects(aircraft, RECORDED)
    if kind == "position":
        assert "on the surface" in reasons["control.elevator.backlash"]
    if kind == "servo":
        assert "at the servo" in reasons["control.elevator.lag"]


def test_no_position_at_all_leaves_no_box_of_surfaces() -> None:
    commands = aircraft_with(de="command", da="command", dr="command", flap="command")
    reasons = excluded_effects(commands, RECORDED)
    assert "only commands" in reasons["sensor.surfaces.delay"]
    assert "sensor.surfaces.delay" not in excluded_effects(B777, RECORDED)


@pytest.mark.parametrize(
    ("missing", "gone"),
    [
        (("flap",), {"aero.Cm.flap", "aero.CN.flap", "aero.CA.flap"}),
        (("throttle",), {"propulsion.Cm.throttle", "propulsion.Cn.asymmetry"}),
        (("V", "qbar"), {"aero.Cm.speed", "aero.CX.speed", "aero.CZ.speed", "sensor.V.scale"}),
        (("beta",), {"sensor.beta.scale", "sensor.alpha_beta.swapped", "sensor.beta_vane.x"}),
        (("dr",), {"aero.Cn.dr3", "aero.Cn.alpha_dr", "sensor.dr.delay"}),
    ],
)
def test_a_missing_channel_leaves_effects_out_and_says_so(
    missing: tuple[str, ...], gone: set[str]
) -> None:
    kept = [name for name in RECORDED if name not in missing]
    before = {one.id for one in eligible_effects(B777, RECORDED)}
    after = {one.id for one in eligible_effects(B777, kept)}
    assert gone <= before
    assert not gone & after
    reasons = excluded_effects(B777, kept)
    for name in gone:
        assert "not recorded" in reasons[name]


def test_inputs_must_move() -> None:
    moving = ("de", "throttle")
    ids = {one.id for one in eligible_effects(B777, RECORDED, moving=moving)}
    assert "aero.Cm.de3" in ids
    assert not {"aero.Cm.flap", "aero.Cn.dr3", "aero.Cl.alpha_da"} & ids
    assert "to move" in excluded_effects(B777, RECORDED, moving=moving)["aero.Cm.flap"]


def test_a_measured_thrust_stands_in_for_the_throttle() -> None:
    recorded = [*(name for name in RECORDED if name != "throttle"), "thrust"]
    ids = {one.id for one in eligible_effects(B777, recorded)}
    assert "propulsion.Cm.throttle" in ids


def test_competitors_and_those_left_out_are_all() -> None:
    for variants in (False, True):
        found = {one.id for one in eligible_effects(B777, RECORDED, variants=variants)}
        reasons = excluded_effects(B777, RECORDED, variants=variants)
        assert found | set(reasons) == set(IDS)
        assert not found & set(reasons)
        assert all(reasons.values())
        assert all(find_effect(name).effect_class in "AB" for name in found)
    plain = {one.id for one in eligible_effects(B777, RECORDED)}
    more = {one.id for one in eligible_effects(B777, RECORDED, variants=True)}
    assert more - plain == {one.id for one in all_effects() if one.variant_of}


# --- classes ------------------------------------------------------------------------------------

_CHANNELS = ("ax", "ay", "an", "p_dot", "q_dot", "r_dot")
_NOISE = np.array([0.05, 0.05, 0.05, 0.5, 0.5, 0.5])
_IN_EQUATIONS = [
    one
    for one in EFFECTS
    if one.target in TARGETS and one.parameters and not one.target.startswith("place.")
]


def flown() -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Return states and inputs as they come together in flight tests at several trims."""
    random = np.random.default_rng(0)
    count = 1500

    def about(mean: float, spread: float) -> np.ndarray:
        return mean + spread * random.standard_normal(count)

    V = random.uniform(24.0, 37.0, count)
    alpha = 0.06 * (30.0 / V) ** 2 + about(0.0, 0.04)
    state = [V, alpha, about(0.0, 0.05), about(0.0, 0.5), *(about(0.0, 0.3) for _ in range(3)),
             about(0.05, 0.1), about(0.0, 0.0)]  # fmt: skip
    flap = 0.2 * (random.random(count) > 0.7)
    throttle = np.clip(about(0.4, 0.15), 0.0, 1.0)
    inputs = [about(-0.02, 0.05), about(0.0, 0.05), about(0.0, 0.08), flap, throttle,
              about(0.0, 0.0), about(1.15, 0.0), about(20.5, 0.3)]  # fmt: skip
    return state, inputs


STATE, FLOWN = flown()


def own_share(columns: np.ndarray) -> float:
    table = (columns / _NOISE[None, :, None]).reshape(-1, columns.shape[-1])
    others, own = table[:, :-1], table[:, -1]
    fit, *_ = np.linalg.lstsq(others, own, rcond=None)
    rest = own - others @ fit
    return float(np.sqrt(rest @ rest / (own @ own)))


@pytest.mark.parametrize("one", _IN_EQUATIONS, ids=lambda one: one.id)
def test_the_class_is_true_of_the_equations(one) -> None:
    model = FlightModel(B777, BASE.with_effect(one.id))
    values = list(model.defaults)
    for item in one.parameters:
        values[model.parameter_names.index(f"{one.id}.{item.name}")] = item.neutral
    size = next(item.name for item in one.parameters if item.free)
    others = [name for name in derivative_names() if name != one.derivative]
    random = np.random.default_rng(1)
    own_states = model.steady_states(STATE, FLOWN)
    state = [*STATE, *(x + 0.02 * random.standard_normal(len(STATE[0])) for x in own_states)]
    outputs = OutputModel(model, _CHANNELS)
    _, slopes, _ = outputs.jacobian(state, FLOWN, values, free=[*others, f"{one.id}.{size}"])
    share = own_share(slopes[:, :, len(model.state_names) + len(MODEL_INPUTS) :])
    if one.effect_class == "A":
        assert share > 0.15
    else:
        assert one.effect_class == "C"
        assert share < 0.13


@pytest.mark.parametrize("channel_id", ["de", "da", "dr"])
def test_wrong_gearing_is_of_class_c(channel_id: str) -> None:
    outputs = OutputModel(FlightModel(B777, BASE), _CHANNELS)
    _, slopes, _ = outputs.jacobian(STATE, FLOWN, free=derivative_names())
    by_surface = slopes[:, :, 9 + MODEL_INPUTS.index(channel_id)]
    gearing = by_surface * FLOWN[MODEL_INPUTS.index(channel_id)][:, None]
    columns = np.concatenate((slopes[:, :, 9 + len(MODEL_INPUTS) :], gearing[:, :, None]), axis=2)
    assert own_share(columns) < 1e-6
    word = {"de": "elevator", "da": "aileron", "dr": "rudder"}[channel_id]
    for name in (f"control.{word}.gearing", f"sensor.{channel_id}.scale"):
        assert find_effect(name).effect_class == "C"


# --- told ---------------------------------------------------------------------------------------


def test_the_json_holds_all_and_is_strict(tmp_path: Path) -> None:
    path = tmp_path / "catalog.json"
    list_effects(json=path)
    text = path.read_text(encoding="utf-8")
    found = json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))
    assert found == effect_catalog_json()
    assert [one["effect"] for one in found["effects"]] == list(effect_ids())
    assert [one["effect"] for one in found["disturbances"]] == ["atmosphere.turbulence"]
    one = next(x for x in found["effects"] if x["effect"] == "control.elevator.backlash")
    assert one["class"] == "A"
    assert one["remedy"] is None
    assert one["parameters"]["slop"]["unit"] == "rad"
    assert one["parameters"]["slop"]["plausible"] == 0.02
    assert one["parameters"]["slop"]["bounds"] == [0.0, 0.2]


def test_the_json_on_the_screen_stands_alone(capsys: pytest.CaptureFixture[str]) -> None:
    list_effects(json=Path("-"))
    assert json.loads(capsys.readouterr().out) == effect_catalog_json()


def test_the_table_tells_every_effect_or_its_family() -> None:
    console = PlainConsole(width=140, record=True, file=io.StringIO())
    print_catalog(console, all_effects())
    text = console.export_text()
    for name in IDS:
        group, _, kind = f"{name}.".split(".")[:3]
        family = {"control": f"control.<surface>.{kind}", "sensor": f"sensor.<channel>.{kind}"}.get(
            group, ""
        )
        surface = f"sensor.<de|da|dr|flap>.{kind}"
        assert name in text or family in text or surface in text, name
    assert "259 effects" in text
    assert "three scales" in text


PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "add-an-effect.md"
EFFECT = "aero.Cl.da_abs_beta"
SEARCH = """
import json
from gsapp.discrepancy.investigation import Investigation
from gsapp.discrepancy.settings import DiscrepancySettings
from tests.discrepancy.blind.cases import Case
from tests.discrepancy.blind.flying import fly_case
from tests.discrepancy.blind.plan import PLAN
from tests.discrepancy.test_hidden_effects import MANEUVERS, SEED

case = Case(id="own", group="outside", kind="outside.Cl.da_abs_beta", plan=SEED, seed=SEED,
            effects={"outside.Cl.da_abs_beta": 2.0}, rate=50, verdicts=())
flown = fly_case(case, [one for one in PLAN if one.id in MANEUVERS])
search = Investigation(flown.maneuvers, flown.aircraft, flown.model)
found = search.run(DiscrepancySettings())
print(json.dumps([found.verdict, [[one.effect, one.parameters] for one in found.effects]]))
"""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder in which the example is installed as a distribution."""
    folder = tmp_path_factory.mktemp("site")
    page = PAGE.read_text("utf-8")
    (source,) = re.findall(r"```python\n(.*?)```", page, flags=re.S)
    (project,) = re.findall(r"```toml\n(.*?)```", page, flags=re.S)
    (folder / "sideslip_effects.py").write_text(source, "utf-8")
    (points,) = re.findall(r'entry-points\."(gsapp\.effects)"\]\n(.*?)\n\n', project, flags=re.S)
    info = folder / "sideslip_effects-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: sideslip-effects\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(f"[{points[0]}]\n{points[1].replace(chr(34), '')}\n")
    return folder


def run_at(site: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run Python with the package of the example on its path."""
    path = os.pathsep.join((str(site), str(PAGE.parents[2])))
    return subprocess.run(
        [sys.executable, *arguments],
        env={**os.environ, "PYTHONPATH": path, "OPENBLAS_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        check=True,
        timeout=600,
    )


def test_the_catalog_lists_the_example(site: Path, tmp_path: Path) -> None:
    listed = tmp_path / "catalog.json"
    run_at(site, "-m", "gsapp", "discrepancy", "--catalog", "--json", str(listed))
    effects = {one["effect"]: one for one in json.loads(listed.read_text("utf-8"))["effects"]}
    assert effects[EFFECT]["class"] == "A"
    assert effects[EFFECT]["parameters"]["Cl_da_abs_beta"]["plausible"] == -0.8


@pytest.mark.long
def test_a_search_finds_the_example(site: Path) -> None:
    """What has no name without the package (`test_hidden_effects`) has one with it."""
    pytest.importorskip("jsbsim", reason="truth is flown by JSBSim, which is not installed")
    verdict, effects = json.loads(run_at(site, "-c", SEARCH).stdout.splitlines()[-1])
    assert verdict == "effects-found"
    ((name, parameters),) = effects
    assert name == EFFECT
    assert parameters["Cl_da_abs_beta"][0] == pytest.approx(2.0, rel=0.15)


def test_a_package_that_fails_is_left_out(tmp_path: Path) -> None:
    info = tmp_path / "broken-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: broken\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[gsapp.effects]\nbroken = no_such_module:EFFECT\n")
    code = "from gsapp.dynamics.terms import effect_ids; print(len(effect_ids()))"
    done = run_at(tmp_path, "-c", code)
    assert int(done.stdout) > 200
    assert "no_such_module" in done.stderr
